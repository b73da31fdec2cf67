// SPDX-License-Identifier: BSD-3-Clause
// weft chart: speed and accuracy, one against the other.
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tools/chart/chart.h"
#include "tools/common/ending.h"
#include "tools/options/kernels.h"
#include "tools/common/paths.h"
#include "tools/draw/plot.h"
#include "tools/verbs/verb.h"

static const char default_output[] = "chart.svg", default_signal[] = "marschner-lobb";
static const char default_kernels[] = "catmull-rom;linear;mitchell;bspline3;lanczos:3";
static const char default_truth_kernels[] =
    "nearest;linear;mitchell;catmull-rom;keys6;lanczos:3+unit;bspline3;bspline3i";

static const char *const csv_ending[] = {".csv", NULL};
static const char *const png_ending[] = {".png", NULL};
static const struct option_spec options[CHART_OPTION_COUNT] = {
    [CHART_OUTPUT] = {.name = "output",
                      'o',
                      OPTION_OUTPUT,
                      "CHART.svg|.png|.pdf|.eps",
                      "the chart, by gnuplot (default chart.svg, where no other output is asked "
                      "for). Of two charts the second is CHART-truth.svg",
                      plot_endings,
                      .group = OPTION_FILES,
                      .brief = "the chart"},
    [CHART_PNG] = {.name = "png",
                   0,
                   OPTION_OUTPUT,
                   "CHART.png",
                   "the same as PNG; the second likewise",
                   png_ending,
                   .group = OPTION_PICTURES,
                   .brief = "the chart, too"},
    [CHART_CSV] = {.name = "csv",
                   0,
                   OPTION_OUTPUT,
                   "FILE.csv",
                   "the points of both charts",
                   csv_ending,
                   .group = OPTION_FILES,
                   .brief = "its points as a table"},
    [CHART_JSON] = OPTIONS_JSON("the points, what was skipped and why, the slice and the machine"),
    [CHART_SCRIPT] = {.name = "script",
                      0,
                      OPTION_FLAG,
                      NULL,
                      "keep gnuplot's script and data beside each chart, as CHART.svg.gp",
                      .group = OPTION_PICTURES},
    [CHART_TRUTH] = {.name = "truth",
                     0,
                     OPTION_FLAG,
                     NULL,
                     "only the second chart (then -o names it as it is)",
                     .group = OPTION_METHOD,
                     .brief = "against the function that made the volume"},
    [CHART_ACCUMULATE] = {.name = "accumulate",
                          0,
                          OPTION_FLAG,
                          NULL,
                          "instead: averages of frames by every method of weft accumulate",
                          .group = OPTION_TASK,
                          .brief = "chart averages of frames"},
    [CHART_FRAMES] = {.name = "frames",
                      0,
                      OPTION_TEXT,
                      "N,N,...",
                      "of --accumulate: how many frames, ascending (default 4,16,64,256,1024; "
                      "quick: 4,16,64)",
                      .group = OPTION_GEOMETRY,
                      .brief = "for averages of so many frames"},
    [CHART_ANTIALIAS] = {.name = "antialias",
                         0,
                         OPTION_FLAG,
                         NULL,
                         "instead: ways of anti-aliasing a scene, against exact coverage",
                         .group = OPTION_FILTER,
                         .brief = "chart anti-aliasing"},
    [CHART_SCENE] = {.name = "scene",
                     0,
                     OPTION_TEXT,
                     "NAME",
                     "of --antialias: what is drawn (weft antialias --scene help lists it), of one "
                     "colour a triangle (default polygons:1000,50; quick: polygons:250,50)",
                     .group = OPTION_GEOMETRY},
    [CHART_GRID] = {.name = "grid",
                    0,
                    OPTION_TEXT,
                    "NAME",
                    "which grid of the file (default: the first scalar one)",
                    .group = OPTION_FILES,
                    .names = OPTION_NAMES_GRID},
    [CHART_RAW] = RAW_OPTION,
    [CHART_PLANE] = {.name = "plane",
                     0,
                     OPTION_TEXT,
                     "oblique|x|y|z|OX,OY,OZ,UX,UY,UZ,VX,VY,VZ",
                     "of the first chart: oblique through the active box (default), across an "
                     "axis in the box's middle, or origin and edges in index space",
                     .group = OPTION_GEOMETRY},
    [CHART_KERNEL] = {.name = "kernel",
                      'k',
                      OPTION_TEXT,
                      "NAME;NAME;...",
                      "the kernels, separated by semicolons, or by commas that no number follows. "
                      "The first chart runs all methods with the first one, and two methods with "
                      "the others (default catmull-rom;linear;mitchell;bspline3;lanczos:3)",
                      .group = OPTION_FILTER,
                      .brief = "which kernels",
                      .names = OPTION_NAMES_KERNEL},
    [CHART_SIZE] = {.name = "size",
                    0,
                    OPTION_PIXELS,
                    "N|WxH",
                    "pixels (default 512x512; quick: 256x256; --accumulate and --antialias: half "
                    "of that)",
                    .group = OPTION_GEOMETRY,
                    .brief = "pixels of a slice"},
    [CHART_POINTS] = {.name = "points",
                      0,
                      OPTION_TEXT,
                      "FILE.csv",
                      "points measured elsewhere, for the first chart: "
                      "technique,label,seconds,bytes,max_error,rms_error",
                      .group = OPTION_FILES,
                      .names = OPTION_NAMES_FILE},
    [CHART_QUICK] = {.name = "quick",
                     0,
                     OPTION_FLAG,
                     NULL,
                     "fewer methods and runs, in half a minute",
                     .group = OPTION_TASK,
                     .brief = "fewer points"},
    ENGINE_OPTIONS(CHART_ENGINE, "methods on both, as far as there is OpenGL",
                   "of the CPU engine's methods (default: of both)"),
    [CHART_QUIET] = OPTIONS_QUIET,
    [CHART_VERBOSE] = OPTIONS_VERBOSE,
};

// ---- what was asked -----------------------------------------------------------------------------

static enum weft_result add_kernel(struct chart *chart, const char *text, size_t length)
{
    if (length == 0 || chart->kernel_count == CHART_MAX_KERNELS) {
        report_error("--kernel: %s", length ? "more than 16 names" : "a name is missing");
        return WEFT_ERR_ARGUMENT;
    }
    struct chart_kernel *kernel = &chart->kernel[chart->kernel_count++];
    kernel->text = strndup(text, length);
    if (!kernel->text)
        return WEFT_ERR_MEMORY;
    return kernels_load_filter(kernel->text, 3, &kernel->kernel, &kernel->file);
}

static enum weft_result read_kernels(struct chart *chart, const char *text)
{
    const bool semicolons = strchr(text, ';');
    for (;;) {
        const size_t length = kernels_list_length(text, semicolons);
        enum weft_result res = add_kernel(chart, text, length);
        if (res != WEFT_OK || !text[length])
            return res;
        text += length + 1;
        if (semicolons && !*text) // "table:a,b;" is one
            return WEFT_OK;
    }
}

static enum weft_result read_all_kernels(struct chart_job *job)
{
    const struct option_value *given = &job->option[CHART_KERNEL];
    enum weft_result res = WEFT_OK;
    if (job->has_methods)
        res = read_kernels(&job->methods, given->given ? given->text : default_kernels);
    if (job->has_truth && res == WEFT_OK)
        res = read_kernels(&job->truth, given->given ? given->text : default_truth_kernels);
    return res;
}

// Of frames and scenes there is none. A signal's name, else a file. Impulses have no value between
// their samples.
static enum weft_result choose_source(struct chart_job *job, const char *operand)
{
    job->has_frames = job->option[CHART_ACCUMULATE].given;
    job->has_edges = job->option[CHART_ANTIALIAS].given;
    if ((job->has_frames || job->has_edges) && operand) {
        report_error("%s, and takes no %s",
                     job->has_frames ? "--accumulate makes its own frames"
                                     : "--antialias draws what --scene names",
                     operand);
        return WEFT_ERR_ARGUMENT;
    }
    if (job->has_frames || job->has_edges)
        return WEFT_OK;
    const bool truth = job->option[CHART_TRUTH].given;
    job->signal = weft_signal_find(operand ? operand : default_signal);
    if (job->signal && job->signal->lattice) {
        report_error("%s is defined at its samples only: there is no truth beside them", operand);
        return WEFT_ERR_ARGUMENT;
    }
    if (!job->signal && truth) {
        report_error("--truth takes a signal (weft make help lists them), not the file %s",
                     operand);
        return WEFT_ERR_ARGUMENT;
    }
    if (job->signal && (job->option[CHART_GRID].given || job->option[CHART_RAW].given)) {
        report_error("--grid and --raw are of files, not of the signal %s", job->signal->name);
        return WEFT_ERR_ARGUMENT;
    }
    job->path = job->signal ? NULL : operand;
    job->has_methods = !truth;
    job->has_truth = job->signal;
    return raw_read(&job->option[CHART_RAW], &job->layout, &job->raw);
}

static const char *option_conflict(const struct option_value *o)
{
    if (o[CHART_QUIET].given && o[CHART_VERBOSE].given)
        return "-q and -v exclude each other";
    if (o[CHART_TRUTH].given && (o[CHART_PLANE].given || o[CHART_POINTS].given))
        return "--plane and --points are of the first chart, which --truth leaves out";
    if (o[CHART_FRAMES].given && !o[CHART_ACCUMULATE].given)
        return "--frames is of --accumulate";
    if (o[CHART_SCENE].given && !o[CHART_ANTIALIAS].given)
        return "--scene is of --antialias";
    if (o[CHART_ACCUMULATE].given && o[CHART_ANTIALIAS].given)
        return "--accumulate and --antialias are two charts";
    if ((o[CHART_ACCUMULATE].given || o[CHART_ANTIALIAS].given) &&
        (o[CHART_TRUTH].given || o[CHART_GRID].given || o[CHART_RAW].given ||
         o[CHART_PLANE].given || o[CHART_KERNEL].given || o[CHART_POINTS].given))
        return "--truth, --grid, --raw, --plane, --kernel and --points are of slices, not of "
               "--accumulate "
               "or --antialias";
    return NULL;
}

static enum weft_result read_engine(struct chart_job *job)
{
    const struct option_value *o = &job->option[CHART_ENGINE];
    const enum weft_result res = engine_options_read(o, NULL, &job->engine);
    job->has_cpu = o[ENGINE_ENGINE].integer[0] != 1 + WEFT_ENGINE_GL;
    return res;
}

static enum weft_result check_options(struct chart_job *job)
{
    const struct option_value *o = job->option;
    const char *conflict = option_conflict(o);
    if (conflict) {
        report_error("%s", conflict);
        return WEFT_ERR_ARGUMENT;
    }
    const int64_t *size = o[CHART_SIZE].integer;
    if (o[CHART_SIZE].given && (size[0] < 1 || size[0] > WEFT_SLICE_MAX_SIZE || size[1] < 1 ||
                                size[1] > WEFT_SLICE_MAX_SIZE)) {
        report_error("--size %s: width and height must be from 1 to %d", o[CHART_SIZE].text,
                     WEFT_SLICE_MAX_SIZE);
        return WEFT_ERR_ARGUMENT;
    }
    enum weft_result res = chart_plane_check(&o[CHART_PLANE]);
    if (res == WEFT_OK)
        res = read_engine(job);
    if (res == WEFT_OK && job->has_edges)
        chart_edges_read(job);
    else if (res == WEFT_OK)
        res = job->has_frames ? chart_frames_read(job) : read_all_kernels(job);
    if (res == WEFT_OK && o[CHART_POINTS].given)
        res = chart_points_load(o[CHART_POINTS].text, &job->methods);
    return res;
}

// ---- outputs ------------------------------------------------------------------------------------

// Where a chart goes: the second of two is NAME-truth.svg. NULL without memory; to be freed.
static char *chart_path(const struct chart_job *job, const struct chart *chart, const char *path)
{
    char *out = NULL;
    const char *ending = strrchr(path, '.');
    const bool second = job->has_methods && chart == &job->truth;
    if (asprintf(&out, "%.*s%s%s", (int)(ending - path), path, second ? "-truth" : "", ending) < 0)
        return NULL;
    return out;
}

static bool ends_in(const char *path, const char *ending)
{
    const size_t length = strlen(paths_base_name(path)), size = strlen(ending);
    return length > size && strcasecmp(path + strlen(path) - size, ending) == 0;
}

static const char *output_of(const struct chart_job *job)
{
    const struct option_value *o = job->option;
    const bool none = !o[CHART_OUTPUT].given && !o[CHART_PNG].given && !o[CHART_CSV].given &&
                      !o[CHART_JSON].given;
    return none ? default_output : o[CHART_OUTPUT].text;
}

// Of the endings in the options' table one must be there: names are made of these.
static enum weft_result check_image(enum chart_option option, const char *path)
{
    const struct option_spec *spec = &options[option];
    if (!path)
        return WEFT_OK;
    for (int i = 0; spec->choices[i]; i++)
        if (ends_in(path, spec->choices[i]))
            return paths_check_output(path, false);
    report_error("--%s %s: the name must end in one of %s", spec->name, path, spec->value);
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result check_outputs(const struct chart_job *job)
{
    const struct option_value *o = job->option;
    const char *const path[] = {output_of(job), o[CHART_PNG].text, o[CHART_CSV].text,
                                o[CHART_JSON].text};
    enum weft_result res = check_image(CHART_OUTPUT, path[0]);
    if (res == WEFT_OK)
        res = check_image(CHART_PNG, path[1]);
    for (int i = 2; i < 4 && res == WEFT_OK; i++)
        res = path[i] ? paths_check_output(path[i], false) : WEFT_OK;
    for (int i = 0; i < 4 && res == WEFT_OK; i++) {
        for (int j = 0; j < i && path[i]; j++) {
            if (path[j] && paths_same_file(path[i], path[j])) {
                report_error("%s and %s are the same file", path[j], path[i]);
                return WEFT_ERR_ARGUMENT;
            }
        }
    }
    return res;
}

static enum exit_code draw(const struct chart_job *job, const struct chart *chart, const char *path)
{
    if (!chart->count)
        return EXIT_CODE_DONE;
    char *name = chart_path(job, chart, path);
    if (!name)
        return (enum exit_code)report_finish(WEFT_ERR_MEMORY);
    enum exit_code code = chart_draw(job, chart, name, job->option[CHART_SCRIPT].given);
    if (code == EXIT_CODE_DONE)
        json_add_output(name);
    free(name);
    return code;
}

static enum exit_code draw_all(const struct chart_job *job, const char *path)
{
    const bool script = job->option[CHART_SCRIPT].given;
    json_add_output(path);
    if (job->has_frames)
        return job->frames.measured ? chart_frames_draw(job, path, script) : EXIT_CODE_DONE;
    if (job->has_edges)
        return job->edges.measured ? chart_edges_draw(job, path, script) : EXIT_CODE_DONE;
    const enum exit_code first = draw(job, &job->methods, path);
    const enum exit_code second = draw(job, &job->truth, path);
    return first ? first : second;
}

// All that can be written is, also after a failure of one.
static enum exit_code write_outputs(const struct chart_job *job)
{
    const struct option_value *o = job->option;
    enum weft_result res = WEFT_OK;
    if (o[CHART_CSV].given)
        res = chart_save_csv(job, o[CHART_CSV].text);
    const bool json_is_printed = o[CHART_JSON].given && !o[CHART_JSON].text;
    if (!report_is_quiet() && !json_is_printed && res == WEFT_OK)
        res = chart_print(job);
    if (res != WEFT_OK)
        return (enum exit_code)report_finish(res);
    const char *const paths[] = {output_of(job), o[CHART_PNG].text};
    enum exit_code code = EXIT_CODE_DONE;
    for (int i = 0; i < 2; i++) {
        const enum exit_code drawn = paths[i] ? draw_all(job, paths[i]) : EXIT_CODE_DONE;
        code = code ? code : drawn;
    }
    if (o[CHART_JSON].given)
        res = chart_print_json(job); // with the charts' bytes
    return res == WEFT_OK ? code : (enum exit_code)report_finish(res);
}

static bool all_within_bounds(const struct chart_job *job)
{
    bool good = true;
    for (size_t i = 0; good && i < job->methods.count; i++) {
        const struct chart_point *p = &job->methods.point[i];
        good = report_verdict(p->label, p->max_error, p->bound, p->not_finite_mismatches);
    }
    for (size_t i = 0; good && i < job->frames.points; i++) {
        const struct chart_frames_point *p = &job->frames.point[i];
        good = *p->reason || report_verdict(p->label, p->max_error, p->bound, 0);
    }
    return good;
}

// ---- the verb -----------------------------------------------------------------------------------

static void describe_machine(char out[CHART_TEXT])
{
    char line[256], model[80] = "unknown processor";
    FILE *file = fopen("/proc/cpuinfo", "r");
    while (file && fgets(line, sizeof line, file)) {
        const char *value = strncmp(line, "model name", 10) == 0 ? strchr(line, ':') : NULL;
        if (!value)
            continue;
        snprintf(model, sizeof model, "%s", value + 1 + strspn(value + 1, " \t"));
        model[strcspn(model, "\n")] = 0;
        break;
    }
    if (file)
        fclose(file);
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    snprintf(out, CHART_TEXT, "%s, %ld core%s", model, cores, cores == 1 ? "" : "s");
}

static enum weft_result measure(struct chart_job *job)
{
    enum weft_result res = WEFT_OK;
    if (job->has_methods)
        res = chart_measure_methods(job);
    if (job->has_truth && res == WEFT_OK)
        res = chart_measure_truth(job);
    if (job->has_frames)
        res = chart_frames_measure(job);
    if (job->has_edges)
        res = chart_edges_measure(job);
    chart_find_front(&job->methods, true, true);
    chart_find_front(&job->truth, false, false);
    return res;
}

static int run_stages(struct chart_job *job, const char *operand)
{
    enum weft_result res = choose_source(job, operand);
    if (res == WEFT_OK)
        res = check_options(job);
    if (res == WEFT_OK)
        res = check_outputs(job);
    if (res == WEFT_OK)
        res = engine_create_context(&job->engine, &job->context);
    if (res != WEFT_OK)
        return report_finish(res);
    describe_machine(job->machine);
    ending_defer_interrupt();
    res = measure(job);
    job->interrupted = ending_is_due();
    // What was measured is kept.
    if (res != WEFT_OK && !job->interrupted)
        return report_finish(res);
    enum exit_code code = write_outputs(job);
    if (code == EXIT_CODE_DONE && !all_within_bounds(job))
        code = EXIT_CODE_FAILED;
    return code != EXIT_CODE_DONE ? (int)code : report_finish(res);
}

static void clear_chart(struct chart *chart)
{
    for (int k = 0; k < chart->kernel_count; k++) {
        weft_kernel_file_destroy(&chart->kernel[k].file);
        free(chart->kernel[k].text);
    }
    free(chart->point);
    free(chart->skipped);
}

static int run(const char *const *operands, const struct option_value *values)
{
    const char *operand = operands[0];
    report_set_level(values[CHART_QUIET].given, values[CHART_VERBOSE].given);
    struct chart_job *job = calloc(1, sizeof *job);
    if (!job)
        return report_finish(WEFT_ERR_MEMORY);
    job->option = values;
    int code = run_stages(job, operand);
    weft_context_destroy(&job->context);
    clear_chart(&job->methods);
    clear_chart(&job->truth);
    free(job->frames.point);
    free(job);
    return code;
}

static const char *const epilogue[] = {
    "The first chart has the error against the same kernel in double precision, on a sample of the "
    "pixels: what the kernel's and the source's representation and the arithmetic add. Lines rise "
    "from it to the bound that the plan promised. The step line joins the points that no other one "
    "beats in both time and error. Time is from voxels in memory to pixels in memory: the median "
    "of three runs or more after one that compiles shaders.",
    "The second chart is of signals, whose value is known everywhere: there the error is the total "
    "one, what the kernel does to the signal included, at 40 to 128 samples along each axis.",
    "The chart of --accumulate averages noisy frames of 8 bits, which lie in memory, by every "
    "method, with targets of all bits and trees of 2 to 16 inputs a node: time, from memory to "
    "memory, against the largest error, its bound, and both over the number of frames.",
    "The chart of --antialias draws a scene by every way of weft antialias, with several numbers "
    "of "
    "samples and filters of a pixel: error against the exact coverage of its polygons, by the same "
    "filter, over the time of a picture and over memory.",
    "Interrupted (SIGINT, as Ctrl-C sends it), it writes what was measured so far, and dies of the "
    "signal; a second one ends it at once. Without gnuplot it leaves scripts and data in "
    "CHART.svg.gp, and ends with 1, too.",
    NULL,
};

static const char *const examples[] = {
    "weft chart smoke.vdb -o smoke.svg --csv smoke.csv --plane z",
    "weft chart marschner-lobb --quick",
    "weft chart --accumulate --frames 16,64,256,1024 --png accumulate.png",
    "weft chart --antialias --scene polygons:50,3000 --png antialias.png",
    NULL,
};

const struct verb verb_chart = {
    .name = "chart",
    .group = VERB_METHODS,
    .summary = "speed against accuracy, of every method on this machine",
    .usage = "[VOLUME|SIGNAL|--accumulate|--antialias] [-o CHART.svg] [options]",
    .description =
        "Computes one slice by every method there is, measures time, memory and error, "
        "and charts one against the other. Takes a volume, or one of the signals of "
        "weft make (default marschner-lobb), and then draws a second chart, of the error "
        "against the signal itself. Takes up to three minutes.",
    .examples = examples,
    .epilogue = epilogue,
    .options = options,
    .option_count = CHART_OPTION_COUNT,
    .operand_names = OPTION_NAMES_FILE,
    .reads_stdin = true,
    .run = run,
};
