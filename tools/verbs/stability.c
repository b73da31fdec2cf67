// SPDX-License-Identifier: BSD-3-Clause
// weft stability: known failures, the naive way beside weft's own.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "tools/common/cells.h"
#include "tools/common/run_report.h"
#include "tools/common/report.h"
#include "tools/verbs/verb.h"

enum {
    STABILITY_CASE,
    STABILITY_CONTEXT,
    STABILITY_DATA,
    STABILITY_LIST,
    STABILITY_JSON,
    STABILITY_QUIET,
    STABILITY_VERBOSE,
    STABILITY_OPTION_COUNT
};

static const struct option_spec options[STABILITY_OPTION_COUNT] = {
    [STABILITY_CASE] = {.name = "case",
                        'c',
                        OPTION_TEXT,
                        "NAME,...",
                        "only these cases, in the order of the list",
                        .group = OPTION_TASK,
                        .brief = "only this one; --list names them"},
    [STABILITY_CONTEXT] = {.name = "context",
                           0,
                           OPTION_TEXT,
                           "auto|osmesa|egl",
                           "where OpenGL runs (default auto: a GPU through EGL, else OSMesa, else "
                           "EGL in software)",
                           .group = OPTION_METHOD},
    [STABILITY_DATA] = {.name = "data",
                        0,
                        OPTION_TEXT,
                        "DIR",
                        "folder with test images of the OpenEXR project (WideFloatRange.exr, "
                        "BrightRingsNanInf.exr); cases generate those that are not there",
                        .group = OPTION_FILES,
                        .brief = "folder of real volumes to try as well"},
    [STABILITY_LIST] = {.name = "list",
                        'l',
                        OPTION_FLAG,
                        NULL,
                        "list the cases: what fails, the naive way, weft's way",
                        .group = OPTION_REPORTS,
                        .brief = "what fails, and how weft does it"},
    [STABILITY_JSON] = OPTIONS_JSON("all of it"),
    [STABILITY_QUIET] = OPTIONS_QUIET,
    [STABILITY_VERBOSE] = {.name = "verbose",
                           'v',
                           OPTION_FLAG,
                           NULL,
                           "tell of every case what was seen, and say what is done",
                           .group = OPTION_REPORTS},
};

enum { MAX_CASES = 64 };

struct suite {
    const struct option_value *option;
    int count;
    const struct weft_stability_case *cases[MAX_CASES];
    struct weft_stability_result results[MAX_CASES];
    weft_context *context;
};

// ---- which cases --------------------------------------------------------------------------------

static bool is_named(const char *list, const char *name)
{
    const size_t length = strlen(name);
    for (const char *at = list; at; at = strchr(at, ',') ? strchr(at, ',') + 1 : NULL)
        if (strcspn(at, ",") == length && strncmp(at, name, length) == 0)
            return true;
    return false;
}

static bool report_unknown(const char *name)
{
    const char *names[MAX_CASES + 1] = {NULL};
    char explanation[512];
    for (int i = 0; i < MAX_CASES && weft_stability_list[i]; i++)
        names[i] = weft_stability_list[i]->name;
    report_error("no case '%s'%s", name,
                 weft_closest_explain(name, strlen(name), names, explanation, sizeof explanation));
    return false;
}

// Whether all names of a list are cases; false after an error line.
static bool check_names(const char *list)
{
    for (const char *at = list; at; at = strchr(at, ',') ? strchr(at, ',') + 1 : NULL) {
        char name[64];
        snprintf(name, sizeof name, "%.*s", (int)strcspn(at, ","), at);
        if (!weft_stability_find(name)) {
            return report_unknown(name);
        }
    }
    return true;
}

static void choose_cases(struct suite *s, const char *names)
{
    for (int i = 0; weft_stability_list[i] && s->count < MAX_CASES; i++)
        if (!names || is_named(names, weft_stability_list[i]->name))
            s->cases[s->count++] = weft_stability_list[i];
}

// ---- text ---------------------------------------------------------------------------------------

static int count_verdicts(const struct suite *s, enum weft_stability_verdict verdict)
{
    int count = 0;
    for (int i = 0; i < s->count; i++)
        count += s->results[i].verdict == verdict;
    return count;
}

static bool fill_row(struct cells *cells, int row, const struct weft_stability_case *c,
                     const struct weft_stability_result *r)
{
    const bool skipped = r->verdict == WEFT_STABILITY_SKIPPED;
    bool done = cells_set(cells, row, 0, "%s", c->name) && cells_set(cells, row, 1, "%s", r->unit);
    const double values[3] = {r->naive, r->ours, r->limit};
    for (int v = 0; v < 3; v++)
        done = done && cells_set(cells, row, 2 + v, skipped ? "-" : "%.3g", values[v]);
    return done && cells_set(cells, row, 5, "%s", weft_stability_verdict_text(r->verdict));
}

static enum weft_result print_table(const struct suite *s)
{
    static const char *const heading[] = {"case", "unit", "naive", "ours", "limit", "verdict"};
    struct cells cells;
    bool done = cells_create(&cells, s->count + 1, 6);
    for (int c = 0; done && c < 6; c++)
        done = cells_set(&cells, 0, c, "%s", heading[c]);
    cells.text_columns = 2;
    for (int i = 0; done && i < s->count; i++)
        done = fill_row(&cells, i + 1, s->cases[i], &s->results[i]);
    if (done)
        cells_print(&cells, CELLS_TEXT, stdout);
    else
        report_error("out of memory for the table");
    cells_destroy(&cells);
    return done ? WEFT_OK : WEFT_ERR_MEMORY;
}

// What was seen, of all cases or of those that do not hold.
static void print_texts(const struct suite *s, bool all)
{
    const bool any = all || count_verdicts(s, WEFT_STABILITY_HOLDS) < s->count;
    if (any)
        putchar('\n');
    for (int i = 0; i < s->count; i++)
        if (all || s->results[i].verdict != WEFT_STABILITY_HOLDS)
            printf("%s: %s\n", s->cases[i]->name, s->results[i].text);
}

static enum weft_result print_text(const struct suite *s)
{
    const struct weft_context_info *info = weft_context_get_info(s->context);
    const enum weft_result res = print_table(s);
    if (res != WEFT_OK)
        return res;
    print_texts(s, s->option[STABILITY_VERBOSE].given);
    printf("\n%d case%s on %s: %d hold, %d fail, %d where the naive way holds too, %d skipped\n",
           s->count, s->count == 1 ? "" : "s", info->platform,
           count_verdicts(s, WEFT_STABILITY_HOLDS), count_verdicts(s, WEFT_STABILITY_OURS_FAILS),
           count_verdicts(s, WEFT_STABILITY_NAIVE_HOLDS_TOO),
           count_verdicts(s, WEFT_STABILITY_SKIPPED));
    return WEFT_OK;
}

static void print_list(const struct suite *s)
{
    for (int i = 0; i < s->count; i++) {
        const struct weft_stability_case *c = s->cases[i];
        printf("%s%s\n  fails   %s\n  naive   %s\n  ours    %s\n", i ? "\n" : "", c->name,
               c->failure, c->naive, c->ours);
        if (c->source)
            printf("  source  %s\n", c->source);
        if (c->image)
            printf("  image   %s\n", c->image);
    }
}

// ---- JSON ---------------------------------------------------------------------------------------

static json_t *text_or_null(const char *text)
{
    return text ? json_text(text) : json_null();
}

static json_t *case_json(const struct weft_stability_case *c)
{
    return json_pack("{s:s,s:s,s:s,s:s,s:o,s:o,s:b}", "name", c->name, "failure", c->failure,
                     "naive_way", c->naive, "our_way", c->ours, "source", text_or_null(c->source),
                     "image", text_or_null(c->image), "needs_context", c->needs_context);
}

// null for an error that is infinite.
static json_t *result_json(const struct weft_stability_case *c,
                           const struct weft_stability_result *r)
{
    json_t *root = case_json(c);
    json_object_update_new(root, json_pack("{s:s,s:o,s:o,s:o,s:o,s:o}", "verdict",
                                           weft_stability_verdict_text(r->verdict), "unit",
                                           json_text(r->unit), "naive", json_number(r->naive),
                                           "ours", json_number(r->ours), "limit",
                                           json_number(r->limit), "text", json_text(r->text)));
    return root;
}

static enum weft_result print_json(const struct suite *s)
{
    const bool list = s->option[STABILITY_LIST].given;
    json_t *root = json_object(), *cases = json_array();
    for (int i = 0; i < s->count; i++)
        json_array_append_new(cases, list ? case_json(s->cases[i])
                                          : result_json(s->cases[i], &s->results[i]));
    if (!list) {
        json_object_set_new(root, "context", run_report_context(s->context));
        json_object_set_new(root, "failed",
                            json_integer(count_verdicts(s, WEFT_STABILITY_OURS_FAILS)));
    }
    json_object_set_new(root, "cases", cases);
    return json_print(root);
}

// ---- the verb -----------------------------------------------------------------------------------

static enum weft_result run_cases(struct suite *s)
{
    const struct weft_stability_params params = {
        .context = s->context, .data_folder = s->option[STABILITY_DATA].text, .log = report_log()};
    const struct weft_progress *progress = report_progress("testing");
    enum weft_result res = WEFT_OK;
    for (int i = 0; res == WEFT_OK && i < s->count; i++) {
        if (!progress->report(progress->priv, (double)i / s->count))
            return WEFT_ERR_CANCELLED;
        res = weft_stability_run(s->cases[i], &params, &s->results[i]);
        if (res != WEFT_OK)
            report_error("case %s: %s", s->cases[i]->name, weft_result_text(res));
    }
    return res;
}

static enum weft_result create_context(struct suite *s)
{
    const struct option_value *o = &s->option[STABILITY_CONTEXT];
    struct weft_context_params params = {.log = report_log()};
    enum weft_result res = WEFT_OK;
    if (o->given)
        res = weft_context_kind_parse(report_log(), o->text, &params.kind);
    return res == WEFT_OK ? weft_context_create(&params, &s->context) : res;
}

static enum weft_result run_suite(struct suite *s)
{
    enum weft_result res = create_context(s);
    if (res == WEFT_OK)
        res = run_cases(s);
    if (res == WEFT_OK)
        res = s->option[STABILITY_JSON].given ? print_json(s) : print_text(s);
    weft_context_destroy(&s->context);
    return res;
}

// false after an error line, with the exit code.
static bool check_options(const char *operand, const struct option_value *o, int *code)
{
    struct stat status;
    *code = EXIT_CODE_USAGE;
    if (operand) {
        report_error("weft stability takes no file; --data DIR names a folder of images");
        return false;
    }
    if (o[STABILITY_QUIET].given && o[STABILITY_VERBOSE].given) {
        report_error("-q and -v exclude each other");
        return false;
    }
    if (o[STABILITY_CASE].given && !check_names(o[STABILITY_CASE].text))
        return false;
    *code = EXIT_CODE_INPUT;
    if (o[STABILITY_DATA].given &&
        (stat(o[STABILITY_DATA].text, &status) != 0 || !S_ISDIR(status.st_mode))) {
        report_error("%s is no folder", o[STABILITY_DATA].text);
        return false;
    }
    return true;
}

static int run(const char *const *operands, const struct option_value *values)
{
    const char *operand = operands[0];
    int code;
    struct suite suite = {.option = values};
    report_set_level(values[STABILITY_QUIET].given, values[STABILITY_VERBOSE].given);
    if (!check_options(operand, values, &code))
        return code;
    choose_cases(&suite, values[STABILITY_CASE].text);
    if (values[STABILITY_LIST].given) {
        enum weft_result res = WEFT_OK;
        if (values[STABILITY_JSON].given)
            res = print_json(&suite);
        else
            print_list(&suite);
        return report_finish(res);
    }
    code = report_finish(run_suite(&suite));
    return code == EXIT_CODE_DONE && count_verdicts(&suite, WEFT_STABILITY_OURS_FAILS)
               ? EXIT_CODE_FAILED
               : code;
}

static const char *const epilogue[] = {
    "Numbers are errors, in the unit named. A case holds where weft's way stays within its limit, "
    "which is derived and not tuned, and the naive way does not. Where the naive way keeps the "
    "limit too, the case shows nothing on this OpenGL.",
    "The exit code is 1 when weft's way fails a case. In JSON an error that is infinite is null.",
    NULL,
};

static const char *const examples[] = {
    "weft stability --case far-away,no-data -v",
    NULL,
};

const struct verb verb_stability = {
    .name = "stability",
    .group = VERB_METHODS,
    .summary = "known failures: the naive way beside weft's own",
    .usage = "[--case NAME,...] [--context auto|osmesa|egl] [--data DIR] [--json] | --list",
    .description =
        "Runs one case for every known failure of reconstruction and accumulation: "
        "clamping, ripple, long sums, half floats, sampler weights, far coordinates, NaN "
        "and more; measures the naive way and weft's own, and compares both with what "
        "weft promises.",
    .examples = examples,
    .epilogue = epilogue,
    .options = options,
    .option_count = STABILITY_OPTION_COUNT,
    .run = run,
};
