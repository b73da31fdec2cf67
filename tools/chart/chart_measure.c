// SPDX-License-Identifier: BSD-3-Clause
// What `weft chart` measures: methods planned, run and compared, one after the other.
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "tools/chart/chart.h"
#include "tools/common/ending.h"

// Ways that take longer for one thing than this are not what one slice is computed by.
static const double PLAN_SECONDS = 6.0, RUN_SECONDS = 6.0;
// For each chart as a whole.
static const double BUDGET_SECONDS = 85.0, QUICK_BUDGET_SECONDS = 12.0;
static const double VERIFY_SECONDS = 0.2;

// Of each round of two: what happens to the machine for a while is not to fall on one method alone.
enum { LEAST_RUNS = 3, MOST_RUNS = CHART_RUNS / 2 };
static const double RUNS_SECONDS = 0.3, QUICK_RUNS_SECONDS = 0.1; // more runs until then

struct bench {
    struct chart_job *job;
    struct chart *chart;
    const struct chart_scene *scene;
    const struct weft_slice_statistics *statistics; // of the kernel in hand
    float *pixels;
    double start, budget;      // of the chart
    size_t done, total;        // methods
    double deadline;           // of what runs now; INFINITY: none
    char reason[CHART_REASON]; // of the last failure, from the log
    bool reason_is_error;
};

// ---- what the library says ----------------------------------------------------------------------

// A method that cannot be is no error of the chart: its reason is kept, errors before details.
static void keep_reason(void *priv, enum weft_log_level level, const char *message)
{
    struct bench *b = priv;
    if (b->reason_is_error || (level != WEFT_LOG_ERROR && level != WEFT_LOG_DEBUG))
        return;
    b->reason_is_error = level == WEFT_LOG_ERROR;
    snprintf(b->reason, sizeof b->reason, "%s", message);
}

static bool go_on(void *priv, double fraction)
{
    (void)fraction;
    const struct bench *b = priv;
    const struct weft_progress *all = report_progress("measuring");
    return all->report(all->priv, (double)b->done / (double)b->total) &&
           report_now_seconds() < b->deadline;
}

// ---- one method ---------------------------------------------------------------------------------

static int compare_numbers(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Of the member at an offset within struct chart_run.
static double median(const struct chart_point *point, size_t offset)
{
    double values[CHART_RUNS];
    const int count = point->runs;
    for (int i = 0; i < count; i++)
        memcpy(&values[i], (const char *)&point->run[i] + offset, sizeof values[i]);
    qsort(values, (size_t)count, sizeof *values, compare_numbers);
    return 0.5 * (values[(count - 1) / 2] + values[count / 2]);
}

// The first run is not counted: it compiles shaders and touches memory for the first time.
static enum weft_result run_method(struct bench *b, const weft_method_plan *plan,
                                   const struct weft_progress *progress, struct chart_point *point)
{
    const bool quick = b->job->option[CHART_QUICK].given;
    const int before = point->runs;
    double spent = 0.0;
    const struct weft_method_run_params params = {.context = b->job->context,
                                                  .cpu = b->job->engine.cpu,
                                                  .pixels = b->pixels,
                                                  .progress = progress};
    struct weft_method_report report;
    b->deadline = report_now_seconds() + RUN_SECONDS;
    enum weft_result res = weft_method_run(plan, &params, &report);
    b->deadline = INFINITY;
    while (res == WEFT_OK && point->runs - before < MOST_RUNS && point->runs < CHART_RUNS &&
           (point->runs - before < LEAST_RUNS ||
            spent < (quick ? QUICK_RUNS_SECONDS : RUNS_SECONDS))) {
        res = weft_method_run(plan, &params, &report);
        if (res != WEFT_OK)
            break;
        point->run[point->runs++] = (struct chart_run){
            .seconds = report.seconds - report.slice.read_seconds,
            .read_seconds = report.slice.read_seconds,
            .pass_seconds = report.slice.pass_seconds,
        };
        spent += report.seconds;
    }
    if (res != WEFT_OK)
        return res;
    point->seconds = median(point, offsetof(struct chart_run, seconds));
    point->read_seconds = median(point, offsetof(struct chart_run, read_seconds));
    point->pass_seconds = median(point, offsetof(struct chart_run, pass_seconds));
    point->bytes = report.slice.peak_bytes;
    return WEFT_OK;
}

static void set_errors(struct chart_point *point, const struct weft_verify_report *error,
                       double bound)
{
    point->max_error = error->maximum;
    point->rms_error = error->rms;
    point->pixels_checked = error->pixels_checked;
    point->not_finite_mismatches = error->not_finite_mismatches;
    point->bound = bound;
}

static enum weft_result verify_kernel(struct bench *b, const weft_method_plan *plan,
                                      const struct weft_progress *progress,
                                      struct chart_point *point)
{
    const struct weft_slice_verify_params params = {.max_seconds = VERIFY_SECONDS,
                                                    .progress = progress};
    struct weft_verify_report error;
    enum weft_result res =
        weft_slice_verify(weft_method_plan_get_slice(plan), b->pixels, &params, &error);
    if (res == WEFT_OK)
        set_errors(point, &error, weft_method_plan_get_info(plan)->bound);
    return res;
}

static void verify_truth(const struct bench *b, struct chart_point *point)
{
    const struct weft_slice_geometry *g = &b->scene->geometry;
    struct weft_verify_report error = {.bound_absolute = NAN};
    for (int y = 0; y < g->height; y++) {
        for (int x = 0; x < g->width; x++) {
            const double value = b->pixels[(size_t)y * (size_t)g->width + (size_t)x];
            const struct weft_reference_value truth = {.value = chart_scene_truth(b->scene, x, y)};
            weft_verify_add(&error, x, y, 0, value, &truth);
            error.pixels_checked++;
        }
    }
    set_errors(point, &error, NAN);
}

static struct weft_slice_params slice_params(const struct bench *b, int kernel,
                                             const struct weft_progress *progress,
                                             const struct weft_log *log)
{
    return (struct weft_slice_params){
        .kernel = b->chart->kernel[kernel].kernel,
        .space = WEFT_SPACE_INDEX,
        .geometry = b->scene->geometry,
        .progress = progress,
        .log = log,
    };
}

static enum weft_result measure_method(struct bench *b, struct chart_point *point)
{
    const struct weft_log log = {.write = keep_reason, .priv = b};
    const struct weft_progress progress = {.report = go_on, .priv = b};
    struct weft_method_params params = {
        .method = point->method,
        .slice = slice_params(b, point->kernel, &progress, &log),
        .statistics = *b->statistics,
    };
    weft_method_plan *plan = NULL;
    b->reason[0] = 0;
    b->reason_is_error = false;
    b->deadline = report_now_seconds() + PLAN_SECONDS;
    enum weft_result res = WEFT_OK;
    if (point->method.algorithm == WEFT_ALGORITHM_HARDWARE)
        res = weft_sampler_measure(b->job->context, point->method.source, &params.sampler);
    if (res == WEFT_OK)
        res = weft_method_plan_create(b->scene->volume, &params, &plan);
    b->deadline = INFINITY;
    if (res == WEFT_ERR_CANCELLED)
        snprintf(b->reason, sizeof b->reason, "planning takes over %g s", PLAN_SECONDS);
    if (res != WEFT_OK)
        return res;
    snprintf(point->label, sizeof point->label, "%s", weft_method_plan_get_info(plan)->name);
    res = run_method(b, plan, &progress, point);
    if (res == WEFT_ERR_CANCELLED)
        snprintf(b->reason, sizeof b->reason, "a run takes over %g s", RUN_SECONDS);
    const bool again = point->pixels_checked > 0; // it was verified then
    if (res == WEFT_OK && !again && b->chart == &b->job->truth)
        verify_truth(b, point);
    else if (res == WEFT_OK && !again)
        res = verify_kernel(b, plan, &progress, point);
    weft_method_plan_destroy(&plan);
    return res;
}

// ---- many methods -------------------------------------------------------------------------------

static enum chart_family family_of(const struct weft_method *method)
{
    if (method->engine == WEFT_ENGINE_CPU)
        return CHART_CPU + method->sums;
    switch (method->algorithm) {
    case WEFT_ALGORITHM_FUSED:
        return CHART_FUSED + method->source;
    case WEFT_ALGORITHM_SEPARABLE:
        return CHART_SEPARABLE;
    case WEFT_ALGORITHM_HARDWARE:
        return CHART_HARDWARE;
    case WEFT_ALGORITHM_MULTIPASS:
        break;
    }
    return CHART_PASSES + method->technique;
}

static void name_technique(const struct weft_method *method, char out[CHART_TEXT])
{
    if (method->engine == WEFT_ENGINE_CPU) {
        weft_method_format(method, out, CHART_TEXT);
        return;
    }
    const char *detail =
        method->algorithm == WEFT_ALGORITHM_FUSED || method->algorithm == WEFT_ALGORITHM_HARDWARE
            ? weft_source_format_name(method->source)
        : method->algorithm == WEFT_ALGORITHM_MULTIPASS ? weft_technique_names[method->technique]
                                                        : "";
    snprintf(out, CHART_TEXT, "%s%s%s", weft_algorithm_names[method->algorithm], *detail ? " " : "",
             detail);
}

// What keeps one method from being measured and the rest not.
static bool is_of_the_method(enum weft_result res)
{
    return res == WEFT_ERR_UNSUPPORTED || res == WEFT_ERR_LIMIT ||
           (res == WEFT_ERR_CANCELLED && !ending_is_due());
}

static enum weft_result add_method(struct bench *b, const struct weft_method *method, int kernel)
{
    struct chart *chart = b->chart;
    struct chart_point point = {.family = family_of(method),
                                .kernel = kernel,
                                .voxels = b->scene->voxels,
                                .method = *method,
                                .bound = NAN};
    name_technique(method, point.technique);
    weft_method_format(method, point.label, sizeof point.label);
    enum weft_result res = WEFT_ERR_UNSUPPORTED;
    if (report_now_seconds() - b->start < b->budget)
        res = measure_method(b, &point);
    else
        snprintf(b->reason, sizeof b->reason, "the chart's %g s are over", b->budget);
    b->done++;
    if (res == WEFT_OK)
        return chart_append(&chart->point, &chart->count, &point);
    if (!is_of_the_method(res)) {
        if (b->reason_is_error)
            report_error("%s: %s", point.label, b->reason);
        return res;
    }
    snprintf(point.reason, sizeof point.reason, "%s",
             *b->reason ? b->reason : weft_result_text(res));
    return chart_append(&chart->skipped, &chart->skipped_count, &point);
}

// A second round of what is quick to plan.
static enum weft_result measure_again(struct bench *b, int kernel)
{
    enum weft_result res = WEFT_OK;
    for (size_t i = 0; i < b->chart->count && res == WEFT_OK; i++) {
        struct chart_point *point = &b->chart->point[i];
        if (point->kernel != kernel || point->method.algorithm == WEFT_ALGORITHM_MULTIPASS ||
            report_now_seconds() - b->start > b->budget)
            continue;
        res = measure_method(b, point);
        if (is_of_the_method(res))
            res = WEFT_OK;
    }
    return res;
}

// Reads what is in reach of a kernel at the scene's slice. A slice beside the volume is an error
// here, not the library's warning.
static enum weft_result measure_voxels(struct bench *b, int kernel,
                                       struct weft_slice_statistics *out)
{
    const struct weft_log log = {.write = keep_reason, .priv = b};
    const struct weft_progress progress = {.report = go_on, .priv = b};
    const struct weft_slice_params params = slice_params(b, kernel, &progress, &log);
    weft_slice_plan *plan = NULL;
    b->reason_is_error = false;
    enum weft_result res = weft_slice_plan_create(b->scene->volume, &params, &plan);
    if (res == WEFT_OK && weft_slice_plan_get_info(plan)->misses_volume) {
        report_error("the plane misses the volume");
        res = WEFT_ERR_ARGUMENT;
    }
    if (res == WEFT_OK)
        res = weft_footprint_statistics(weft_slice_plan_get_footprint(plan), &progress, out);
    if (res != WEFT_OK && b->reason_is_error)
        report_error("%s", b->reason);
    weft_slice_plan_destroy(&plan);
    b->statistics = out;
    return res;
}

static void begin(struct bench *b, struct chart_job *job, struct chart *chart)
{
    const bool quick = job->option[CHART_QUICK].given;
    *b = (struct bench){
        .job = job,
        .chart = chart,
        .start = report_now_seconds(),
        .budget = quick ? QUICK_BUDGET_SECONDS : BUDGET_SECONDS,
        .total = 1,
        .deadline = INFINITY,
    };
}

static enum weft_result allocate_pixels(struct bench *b)
{
    const struct weft_slice_geometry *g = &b->scene->geometry;
    b->pixels = malloc((size_t)g->width * (size_t)g->height * sizeof *b->pixels);
    if (b->pixels)
        return WEFT_OK;
    report_error("out of memory for %d x %d pixels", g->width, g->height);
    return WEFT_ERR_MEMORY;
}

// ---- the first chart ----------------------------------------------------------------------------

// The least comes first: what tells most in least time, should the time be over before the list.
static int rank(const struct weft_method *method)
{
    if (method->algorithm == WEFT_ALGORITHM_SEPARABLE || method->engine == WEFT_ENGINE_CPU)
        return 0;
    if (method->algorithm == WEFT_ALGORITHM_HARDWARE)
        return 1;
    if (method->algorithm == WEFT_ALGORITHM_FUSED)
        return method->lookup == WEFT_LOOKUP_POLYNOMIAL ? 1 : method->samples % 64 == 0 ? 3 : 4;
    if (method->samples > 32)
        return 7;
    return method->technique == WEFT_TECHNIQUE_DOT4 ? 2 : method->samples == 32 ? 5 : 6;
}

static bool is_quick(const struct weft_method *method)
{
    if (method->engine == WEFT_ENGINE_CPU)
        return true;
    if (method->algorithm == WEFT_ALGORITHM_HARDWARE)
        return method->source == WEFT_SOURCE_FLOAT || method->source == WEFT_SOURCE_UNORM8;
    if (method->algorithm == WEFT_ALGORITHM_MULTIPASS)
        return method->samples == 16 && method->technique <= WEFT_TECHNIQUE_DOT4;
    return method->lookup == WEFT_LOOKUP_POLYNOMIAL
               ? method->layout == WEFT_LAYOUT_INTERLEAVED || method->source == WEFT_SOURCE_FLOAT
               : method->samples == 64;
}

// Kernels beside the first one: what they cost and keep by a good method in floats and one in
// bytes.
static bool is_for_other_kernels(const struct weft_method *method)
{
    if (method->engine == WEFT_ENGINE_CPU)
        return method->algorithm == WEFT_ALGORITHM_FUSED && method->sums == WEFT_SUMS_FLOAT;
    return method->algorithm == WEFT_ALGORITHM_FUSED && method->lookup == WEFT_LOOKUP_POLYNOMIAL &&
           method->layout == WEFT_LAYOUT_INTERLEAVED &&
           (method->source == WEFT_SOURCE_FLOAT || method->source == WEFT_SOURCE_UNORM8);
}

static bool is_asked(const struct chart_job *job, const struct weft_method *method)
{
    const struct option_value *sums = &job->option[CHART_ENGINE + ENGINE_SUMS];
    if (method->engine == WEFT_ENGINE_GL)
        return job->context;
    return job->has_cpu && (!sums->given || (int64_t)method->sums == sums->integer[0]);
}

// Sorted, without what is not asked for or a quick chart leaves out; keeps the list's order among
// equals.
static size_t order_methods(const struct chart_job *job, struct weft_method *methods, size_t count)
{
    const bool quick = job->option[CHART_QUICK].given;
    size_t kept = 0;
    for (size_t i = 0; i < count; i++)
        if (is_asked(job, &methods[i]) && (!quick || is_quick(&methods[i])))
            methods[kept++] = methods[i];
    for (size_t i = 1; i < kept; i++) { // insertion: qsort is not stable
        const struct weft_method method = methods[i];
        size_t at = i;
        for (; at > 0 && rank(&methods[at - 1]) > rank(&method); at--)
            methods[at] = methods[at - 1];
        methods[at] = method;
    }
    return kept;
}

static enum weft_result measure_other_kernels(struct bench *b, const struct weft_method *methods,
                                              size_t count)
{
    struct weft_slice_statistics statistics;
    enum weft_result res = WEFT_OK;
    for (int k = 1; k < b->chart->kernel_count && res == WEFT_OK; k++) {
        res = measure_voxels(b, k, &statistics);
        for (size_t i = 0; i < count && res == WEFT_OK; i++)
            if (is_for_other_kernels(&methods[i]))
                res = add_method(b, &methods[i], k);
    }
    return res;
}

enum weft_result chart_measure_methods(struct chart_job *job)
{
    struct bench b;
    struct chart_scene scene = {0};
    struct weft_method *methods = NULL;
    size_t count = 0, others = 0, quick_ones;
    begin(&b, job, &job->methods);
    b.scene = &scene;
    enum weft_result res = chart_scene_create(job, &scene);
    if (res == WEFT_OK)
        res = weft_method_list(report_log(), &methods, &count);
    if (res != WEFT_OK)
        goto fail;
    count = order_methods(job, methods, count);
    for (size_t i = 0; i < count; i++)
        others += is_for_other_kernels(&methods[i]);
    b.total = count + others * (size_t)(b.chart->kernel_count - 1);
    res = allocate_pixels(&b);
    // The other kernels come after the fast methods, in case the time is over early.
    for (quick_ones = 0; quick_ones < count && rank(&methods[quick_ones]) <= 2;)
        quick_ones++;
    if (res == WEFT_OK)
        res = measure_voxels(&b, 0, &job->statistics);
    for (size_t i = 0; i < quick_ones && res == WEFT_OK; i++)
        res = add_method(&b, &methods[i], 0);
    if (res == WEFT_OK)
        res = measure_other_kernels(&b, methods, count);
    b.statistics = &job->statistics;
    size_t next = quick_ones;
    for (; next < count && rank(&methods[next]) <= 4 && res == WEFT_OK; next++)
        res = add_method(&b, &methods[next], 0);
    if (res == WEFT_OK)
        res = measure_again(&b, 0);
    for (; next < count && res == WEFT_OK; next++)
        res = add_method(&b, &methods[next], 0);
fail:
    free(methods);
    free(b.pixels);
    chart_scene_destroy(&scene);
    return res;
}

// ---- the second chart ---------------------------------------------------------------------------

static const int truth_voxels[] = {40, 64, 96, 128};
enum { TRUTH_VOXELS = sizeof truth_voxels / sizeof *truth_voxels, QUICK_TRUTH_VOXELS = 2 };

// In single precision, in two formats of fixed point, and in passes of 8 bits; without OpenGL in
// single precision alone.
static void list_truth_methods(const struct chart_job *job, struct weft_method out[], size_t *count)
{
    static const enum weft_source_format formats[] = {WEFT_SOURCE_FLOAT, WEFT_SOURCE_UNORM16,
                                                      WEFT_SOURCE_UNORM8};
    *count = 0;
    if (!job->context) {
        out[(*count)++] = (struct weft_method){.engine = WEFT_ENGINE_CPU};
        return;
    }
    for (size_t i = 0; i < sizeof formats / sizeof *formats; i++)
        out[(*count)++] =
            (struct weft_method){.layout = WEFT_LAYOUT_INTERLEAVED, .source = formats[i]};
    out[(*count)++] = (struct weft_method){.algorithm = WEFT_ALGORITHM_MULTIPASS,
                                           .samples = 32,
                                           .profile = *weft_profile_find("unorm8"),
                                           .technique = WEFT_TECHNIQUE_DOT4};
}

// Of half the cube's edge: so that no kernel reaches over the border where the samples are fewest.
static double truth_margin(const struct chart *chart)
{
    int width = 0;
    for (int k = 0; k < chart->kernel_count; k++)
        width = chart->kernel[k].kernel.width > width ? chart->kernel[k].kernel.width : width;
    return fmax(0.375, (width + 1.0) / truth_voxels[0]);
}

static enum weft_result measure_truth_scene(struct bench *b, const struct weft_method *methods,
                                            size_t count)
{
    enum weft_result res = b->pixels ? WEFT_OK : allocate_pixels(b);
    struct weft_slice_statistics statistics;
    for (int k = 0; k < b->chart->kernel_count && res == WEFT_OK; k++) {
        res = measure_voxels(b, k, &statistics);
        for (size_t i = 0; i < count && res == WEFT_OK; i++)
            res = add_method(b, &methods[i], k);
    }
    return res;
}

enum weft_result chart_measure_truth(struct chart_job *job)
{
    const bool quick = job->option[CHART_QUICK].given;
    const int sizes = quick ? QUICK_TRUTH_VOXELS : TRUTH_VOXELS;
    struct weft_method methods[4];
    size_t count;
    struct bench b;
    enum weft_result res = WEFT_OK;
    begin(&b, job, &job->truth);
    list_truth_methods(job, methods, &count);
    if (quick && count > 1)
        count--; // passes take longest to plan
    b.total = (size_t)(sizes * b.chart->kernel_count) * count;
    for (int i = 0; i < sizes && res == WEFT_OK; i++) {
        struct chart_scene scene;
        res = chart_truth_scene_create(job, truth_voxels[i], truth_margin(b.chart), &scene);
        b.scene = &scene;
        if (res == WEFT_OK)
            res = measure_truth_scene(&b, methods, count);
        chart_scene_destroy(&scene);
    }
    free(b.pixels);
    return res;
}

// ---- the front ----------------------------------------------------------------------------------

// Errors that differ by less than a thousandth are the same: other pixels were looked at, files
// have six digits, and all that is rounded to a float once is off by half a unit somewhere.
static const double SAME_ERROR = 1.001;

static bool beats(const struct chart_point *a, const struct chart_point *b, bool by_max)
{
    const double x = by_max ? a->max_error : a->rms_error, y = by_max ? b->max_error : b->rms_error;
    return a->seconds <= b->seconds && x <= SAME_ERROR * y && (a->seconds < b->seconds || x < y);
}

void chart_find_front(struct chart *chart, bool by_max, bool first_only)
{
    for (size_t i = 0; i < chart->count; i++) {
        struct chart_point *p = &chart->point[i];
        p->front = !first_only || p->kernel <= 0;
        for (size_t j = 0; j < chart->count && p->front; j++)
            if (!first_only || chart->point[j].kernel <= 0)
                p->front = !beats(&chart->point[j], p, by_max);
    }
}
