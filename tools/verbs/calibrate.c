// SPDX-License-Identifier: BSD-3-Clause
// weft calibrate: what methods cost on this machine, measured and kept.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/cells.h"
#include "tools/methods/cost_file.h"
#include "tools/methods/engine_options.h"
#include "tools/common/paths.h"
#include "tools/common/report.h"
#include "tools/common/run_report.h"
#include "tools/verbs/verb.h"

enum {
    CALIBRATE_OUTPUT,
    CALIBRATE_CONTEXT,
    CALIBRATE_JSON,
    CALIBRATE_QUIET,
    CALIBRATE_VERBOSE,
    CALIBRATE_OPTION_COUNT
};

static const char *const text_ending[] = {".txt", NULL};
static const struct option_spec options[CALIBRATE_OPTION_COUNT] = {
    [CALIBRATE_OUTPUT] = {.name = "output",
                          'o',
                          OPTION_OUTPUT,
                          "FILE",
                          "where the numbers go (default: where other verbs look for them)",
                          text_ending,
                          .group = OPTION_FILES,
                          .brief = "where the numbers go"},
    [CALIBRATE_CONTEXT] = ENGINE_SPEC_CONTEXT,
    [CALIBRATE_JSON] = OPTIONS_JSON("the numbers"),
    [CALIBRATE_QUIET] = OPTIONS_QUIET,
    [CALIBRATE_VERBOSE] = OPTIONS_VERBOSE,
};

struct calibration {
    const struct option_value *option;
    struct engine engine;
    weft_context *context; // NULL: none is to be had
    char *path;
    struct weft_cost_model model;
    double seconds;
};

// ---- tables -------------------------------------------------------------------------------------

static bool set_heading(struct cells *cells, const char *const *heading)
{
    bool done = true;
    for (int c = 0; done && c < cells->columns; c++)
        done = cells_set(cells, 0, c, "%s", heading[c]);
    return done;
}

static bool print_general(const struct weft_cost_model *m)
{
    static const char *const heading[] = {"of any method", "ns"};
    const struct {
        const char *what;
        double value;
    } rows[] = {
        {"a voxel read", m->voxel},
        {"fused: any run", m->start[WEFT_ALGORITHM_FUSED]},
        {"fused: a pixel", m->entry + m->pixel},
        {"fused: four weights", m->weights},
        {"fused: four weights of sampled tiles", m->weights_fetched},
        {"separable: any run", m->start[WEFT_ALGORITHM_SEPARABLE]},
        {"separable: a pixel", m->separable_pixel},
        {"separable: a tap", m->tap},
        {"separable: a voxel summed", m->summed},
        {"passes: any run", m->start[WEFT_ALGORITHM_MULTIPASS]},
        {"passes: a pixel", m->pass_pixel},
        {"passes: an exact weight", m->pass_weight},
    };
    struct cells cells;
    bool done = cells_create(&cells, (int)(sizeof rows / sizeof *rows) + 1, 2);
    cells.text_columns = 1;
    done = done && set_heading(&cells, heading);
    for (int i = 0; done && i < cells.rows - 1; i++)
        done = cells_set(&cells, i + 1, 0, "%s", rows[i].what) &&
               cells_set(&cells, i + 1, 1, "%.3g", rows[i].value);
    if (done)
        cells_print(&cells, CELLS_TEXT, stdout);
    cells_destroy(&cells);
    return done;
}

static bool print_cpu(const struct weft_cost_model *m)
{
    static const char *const heading[] = {"CPU engine, ns", "float sums", "double sums"};
    const double(*row)[WEFT_COST_WIDTHS] = m->cpu_row,
          (*tap)[WEFT_COST_WIDTHS] = m->cpu_separable_tap;
    const struct {
        const char *what;
        double value[WEFT_COST_SUMS];
    } rows[] = {
        {"fused: any run", {m->cpu_fused_start[0], m->cpu_fused_start[1]}},
        {"fused: a pixel", {m->cpu_pixel[0], m->cpu_pixel[1]}},
        {"fused: a row of 2 taps", {row[0][0], row[1][0]}},
        {"fused: a row of 4 taps", {row[0][1], row[1][1]}},
        {"fused: a row of 6 taps", {row[0][2], row[1][2]}},
        {"fused: a row of 8 taps", {row[0][3], row[1][3]}},
        {"fused: a sample laid out", {m->cpu_sample[0], m->cpu_sample[1]}},
        {"separable: any run", {m->cpu_separable_start[0], m->cpu_separable_start[1]}},
        {"separable: a tap of 2", {tap[0][0], tap[1][0]}},
        {"separable: a tap of 4", {tap[0][1], tap[1][1]}},
        {"separable: a tap of 6", {tap[0][2], tap[1][2]}},
        {"separable: a tap of 8", {tap[0][3], tap[1][3]}},
        {"separable: a voxel summed", {m->cpu_summed[0], m->cpu_summed[1]}},
    };
    struct cells cells;
    bool done = cells_create(&cells, (int)(sizeof rows / sizeof *rows) + 1, 3);
    cells.text_columns = 1;
    done = done && set_heading(&cells, heading);
    for (int i = 0; done && i < cells.rows - 1; i++)
        done = cells_set(&cells, i + 1, 0, "%s", rows[i].what) &&
               cells_set(&cells, i + 1, 1, "%.3g", rows[i].value[WEFT_SUMS_FLOAT]) &&
               cells_set(&cells, i + 1, 2, "%.3g", rows[i].value[WEFT_SUMS_DOUBLE]);
    if (done)
        cells_print(&cells, CELLS_TEXT, stdout);
    cells_destroy(&cells);
    return done;
}

static bool print_sources(const struct weft_cost_model *m)
{
    static const char *const heading[] = {"fused, ns of a source", "fetch", "texel laid out"};
    struct cells cells;
    bool done = cells_create(&cells, WEFT_COST_LAYOUTS * WEFT_SOURCE_FORMATS + 1, 3);
    cells.text_columns = 1;
    done = done && set_heading(&cells, heading);
    for (int i = 0; done && i < cells.rows - 1; i++) {
        const int layout = i / WEFT_SOURCE_FORMATS, source = i % WEFT_SOURCE_FORMATS;
        done =
            cells_set(&cells, i + 1, 0, "%s %s", weft_layout_name((enum weft_layout)(layout + 1)),
                      weft_source_format_name((enum weft_source_format)source)) &&
            cells_set(&cells, i + 1, 1, "%.3g", m->fetch[layout][source]) &&
            cells_set(&cells, i + 1, 2, "%.3g", m->texel[layout][source]);
    }
    if (done)
        cells_print(&cells, CELLS_TEXT, stdout);
    cells_destroy(&cells);
    return done;
}

static bool print_targets(const struct weft_cost_model *m)
{
    static const char *const heading[] = {"passes, ns of a target", "pixel of a pass", "fetch",
                                          "sample laid out", "tile byte"};
    struct cells cells;
    bool done = cells_create(&cells, 2 * WEFT_COST_TARGETS + 1, 5);
    cells.text_columns = 1;
    done = done && set_heading(&cells, heading);
    for (int i = 0; done && i < cells.rows - 1; i++) {
        const int target = i / 2, dot4 = i % 2;
        done = cells_set(&cells, i + 1, 0, "%s%s",
                         weft_target_name((enum weft_target_format)target), dot4 ? " dot4" : "") &&
               cells_set(&cells, i + 1, 1, "%.3g", m->pass[target]) &&
               cells_set(&cells, i + 1, 2, "%.3g", m->pass_fetch[target][dot4]) &&
               cells_set(&cells, i + 1, 3, "%.3g", m->pass_sample[target][dot4]) &&
               cells_set(&cells, i + 1, 4, "%.3g", m->tile_byte[target][dot4]);
    }
    if (done)
        cells_print(&cells, CELLS_TEXT, stdout);
    cells_destroy(&cells);
    return done;
}

static enum weft_result print_text(const struct calibration *c)
{
    typedef bool (*print)(const struct weft_cost_model *model);
    static const print tables[] = {print_general, print_sources, print_targets, print_cpu};
    const size_t count = sizeof tables / sizeof *tables;
    report_line("%s%s%s instructions, %d thread%s, measured in %.1f s", c->model.renderer,
                c->context ? "; " : "", weft_instruction_set_names[c->model.instructions],
                c->model.threads, c->model.threads == 1 ? "" : "s", c->seconds);
    for (size_t i = c->context ? 0 : count - 1; i < count; i++) {
        putchar('\n');
        if (!tables[i](&c->model)) {
            report_error("out of memory for a table");
            return WEFT_ERR_MEMORY;
        }
    }
    putchar('\n');
    report_line("kept in %s", c->path);
    return WEFT_OK;
}

// ---- JSON ---------------------------------------------------------------------------------------

// "name 1 2 3" of weft_cost_format: a number, or as many as there are.
static void add_line(json_t *object, const char *line)
{
    char name[64];
    json_t *values = json_array();
    const size_t length = strcspn(line, " \n");
    snprintf(name, sizeof name, "%.*s", (int)length, line);
    for (const char *at = line + length; *at == ' ';) {
        char *end;
        json_array_append_new(values, json_number(strtod(at, &end)));
        at = end;
    }
    json_t *first = json_incref(json_array_get(values, 0));
    if (json_array_size(values) == 1) {
        json_object_set_new(object, name, first);
        json_decref(values);
        return;
    }
    json_decref(first);
    json_object_set_new(object, name, values);
}

static enum weft_result print_json(const struct calibration *c)
{
    char *text = weft_cost_format(&c->model);
    if (!text) {
        report_error("out of memory for JSON");
        return WEFT_ERR_MEMORY;
    }
    json_t *model = json_object();
    const char *line = text;
    for (int i = 0; *line; i++, line += strcspn(line, "\n") + 1)
        if (i >= 3) // behind the heading, the renderer and the CPU
            add_line(model, line);
    free(text);
    json_t *root = json_pack("{s:s,s:i,s:o,s:o,s:o}", "instructions",
                             weft_instruction_set_names[c->model.instructions], "threads",
                             c->model.threads, "context", run_report_context(c->context), "seconds",
                             run_report_total_seconds(c->seconds), "nanoseconds", model);
    json_add_output(c->path);
    return json_print(root); // without OpenGL its numbers are the defaults
}

// ---- the verb -----------------------------------------------------------------------------------

static enum weft_result read_context(struct calibration *c)
{
    const struct option_value *o = &c->option[CALIBRATE_CONTEXT];
    c->engine.automatic = !o->given;
    return o->given ? weft_context_kind_parse(report_log(), o->text, &c->engine.kind) : WEFT_OK;
}

// Before the long work, whether it can be kept.
static enum weft_result choose_path(struct calibration *c)
{
    const struct option_value *o = &c->option[CALIBRATE_OUTPUT];
    enum weft_result res = WEFT_OK;
    c->path = o->given ? strdup(o->text) : cost_file_path(c->engine.kind);
    if (!c->path) {
        report_error("no folder is known to keep the numbers in: set XDG_CACHE_HOME or HOME, or "
                     "give -o FILE");
        return WEFT_ERR_WRITE;
    }
    if (!o->given)
        res = cost_file_make_folders(c->path);
    return res == WEFT_OK ? paths_check_output(c->path, false) : res;
}

static enum weft_result calibrate(struct calibration *c)
{
    const double start = report_now_seconds();
    enum weft_result res =
        weft_cost_calibrate(report_log(), c->context, report_progress("calibrating"), &c->model);
    c->seconds = report_now_seconds() - start;
    return res;
}

static enum weft_result run_stages(struct calibration *c)
{
    enum weft_result res = read_context(c);
    if (res == WEFT_OK)
        res = choose_path(c);
    if (res == WEFT_OK)
        res = engine_create_context(&c->engine, &c->context);
    if (res == WEFT_OK)
        res = calibrate(c);
    if (res == WEFT_OK)
        res = cost_file_save(&c->model, c->path);
    if (res == WEFT_OK && c->option[CALIBRATE_JSON].given)
        return print_json(c);
    return res == WEFT_OK && !report_is_quiet() ? print_text(c) : res;
}

static int run(const char *const *operands, const struct option_value *values)
{
    const char *operand = operands[0];
    struct calibration c = {.option = values};
    report_set_level(values[CALIBRATE_QUIET].given, values[CALIBRATE_VERBOSE].given);
    if (operand) {
        report_error("weft calibrate takes no file; -o FILE names where the numbers go");
        return EXIT_CODE_USAGE;
    }
    if (values[CALIBRATE_QUIET].given && values[CALIBRATE_VERBOSE].given) {
        report_error("-q and -v exclude each other");
        return EXIT_CODE_USAGE;
    }
    const enum weft_result res = run_stages(&c);
    weft_context_destroy(&c.context);
    free(c.path);
    return report_finish(res);
}

static const char *const epilogue[] = {
    "The numbers are kept in $XDG_CACHE_HOME/weft, or ~/.cache/weft, in a file for each --context. "
    "Where there is none, other verbs take numbers of a software OpenGL on two cores, and OpenGL "
    "before the CPU engine. Without OpenGL the CPU engine alone is measured.",
    "What else the machine does meanwhile counts as weft's: calibrate when it is idle, and again "
    "when processor, GPU or driver are others. Costs decide which method is taken, never how right "
    "its result is.",
    NULL,
};

const struct verb verb_calibrate = {
    .name = "calibrate",
    .group = VERB_METHODS,
    .summary = "what methods of filtering cost on this machine",
    .usage = "[-o FILE] [--context auto|osmesa|egl] [--json]",
    .description = "Runs small jobs for some ten seconds and finds what a pixel, a fetch, a pass "
                   "and the like take here, so that the cheapest of several methods can be chosen.",
    .epilogue = epilogue,
    .options = options,
    .option_count = CALIBRATE_OPTION_COUNT,
    .run = run,
};
