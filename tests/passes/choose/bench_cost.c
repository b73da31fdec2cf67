// SPDX-License-Identifier: BSD-3-Clause
// The cost model beside the clock: calibrates, and runs all methods of slices through a volume.
// Without --bench a small case with the costs of weft_cost_default, of which only sanity is
// checked: times depend on the machine's load. Usage:
// bench_cost [--bench] [--context auto|osmesa|egl] [--kernels NAME,...] [--defaults]
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "weft.h"

enum { MAX_RUNS = 3 };
static const double PLANNING_SECONDS = 8.0; // what takes longer is left out

struct bench {
    bool full, defaults;
    int size, side, runs;
    const char *kernels;
    enum weft_context_kind kind;
    weft_context *context;
    weft_volume *volume;
    float *pixels;
    struct weft_cost_model model;
    double deadline;
    int compared, close, failures; // close: within a factor of 1.5
};

static void print_log(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    if (level <= WEFT_LOG_WARNING)
        fprintf(stderr, "bench_cost: %s\n", message);
}

static const struct weft_log log_to_stderr = {print_log, NULL};

static bool before_deadline(void *priv, double fraction)
{
    const struct bench *b = priv;
    (void)fraction;
    return weft_now_seconds() < b->deadline;
}

// ---- the volume and its slices ------------------------------------------------------------------

static enum weft_result make_volume(struct bench *b)
{
    const size_t n = (size_t)b->size, count = n * n * n;
    float *data = malloc(count * sizeof *data);
    b->pixels = malloc((size_t)b->side * (size_t)b->side * sizeof *b->pixels);
    enum weft_result res = WEFT_ERR_MEMORY;
    if (data && b->pixels) {
        const struct weft_signal_info *signal = weft_signal_find("marschner-lobb");
        for (size_t i = 0; i < count; i++) {
            const double at[3] = {weft_signal_coordinate((int64_t)(i % n), b->size),
                                  weft_signal_coordinate((int64_t)(i / n % n), b->size),
                                  weft_signal_coordinate((int64_t)(i / n / n), b->size)};
            data[i] = (float)signal->value(at);
        }
        res = weft_volume_create(weft_volume_params(.size = {b->size, b->size, b->size},
                                                    .data = data, .log = &log_to_stderr),
                                 &b->volume);
    }
    free(data);
    return res;
}

static struct weft_slice_geometry plane(const struct bench *b, bool oblique)
{
    static const double edges[2][2][3] = {{{0.9, 0.0, 0.0}, {0.0, 0.9, 0.0}},
                                          {{0.62, 0.28, 0.12}, {-0.25, 0.55, 0.30}}};
    struct weft_slice_geometry g = {.width = b->side, .height = b->side};
    for (int a = 0; a < 3; a++) {
        g.u[a] = b->size * edges[oblique][0][a];
        g.v[a] = b->size * edges[oblique][1][a];
        g.origin[a] = 0.5 * b->size - 0.5 * (g.u[a] + g.v[a]);
    }
    g.origin[2] += oblique ? 0.0 : 0.3;
    return g;
}

// ---- one method ---------------------------------------------------------------------------------

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static enum weft_result statistics(struct bench *b, const weft_method_plan *plan, double *out)
{
    double seconds[MAX_RUNS];
    enum weft_result res = WEFT_OK;
    for (int i = -1; res == WEFT_OK && i < b->runs; i++) { // the first one warms up
        struct weft_method_report report;
        res = weft_method_run(
            plan, weft_method_run_params(.context = b->context, .pixels = b->pixels), &report);
        if (res == WEFT_OK && i >= 0)
            seconds[i] = report.seconds;
    }
    if (res == WEFT_OK) {
        qsort(seconds, (size_t)b->runs, sizeof *seconds, by_value);
        *out = seconds[b->runs / 2];
    }
    return res;
}

static void compare(struct bench *b, const struct weft_method_params *params)
{
    weft_method_plan *plan = NULL;
    double measured = 0.0;
    b->deadline = weft_now_seconds() + PLANNING_SECONDS;
    enum weft_result res = weft_method_plan_create(b->volume, params, &plan);
    if (res == WEFT_ERR_UNSUPPORTED || res == WEFT_ERR_CANCELLED || res == WEFT_ERR_LIMIT)
        return;
    if (res == WEFT_OK)
        res = statistics(b, plan, &measured);
    if (res != WEFT_OK) {
        b->failures++;
        return;
    }
    const double predicted = weft_cost_of(&b->model, &weft_method_plan_get_info(plan)->work),
                 ratio = predicted / measured;
    b->failures += !(predicted > 0.0 && isfinite(predicted));
    b->compared++;
    b->close += ratio >= 1.0 / 1.5 && ratio <= 1.5;
    printf("  %-44s %9.2f %9.2f %6.2f%s\n", weft_method_plan_get_info(plan)->name, 1e3 * predicted,
           1e3 * measured, ratio, ratio >= 1.0 / 1.5 && ratio <= 1.5 ? "" : " *");
    fflush(stdout);
    weft_method_plan_destroy(&plan);
}

// ---- all of them --------------------------------------------------------------------------------

static enum weft_result run_slice(struct bench *b, const char *kernel, bool oblique)
{
    const struct weft_progress progress = {before_deadline, b};
    struct weft_method_params params = {
        .slice = {.space = WEFT_SPACE_INDEX, .geometry = plane(b, oblique), .log = &log_to_stderr}};
    weft_slice_plan *plan = NULL;
    struct weft_method *methods = NULL;
    size_t count = 0;
    enum weft_result res = weft_kernel_parse(&log_to_stderr, kernel, &params.slice.kernel);
    if (res == WEFT_OK)
        res = weft_slice_plan_create(b->volume, &params.slice, &plan);
    if (res == WEFT_OK)
        res = weft_footprint_statistics(weft_slice_plan_get_footprint(plan), NULL,
                                        &params.statistics);
    if (res == WEFT_OK)
        res = weft_method_list(&log_to_stderr, &methods, &count);
    printf("%s, %s: %d x %d pixels of %d^3 voxels\n  %-44s %9s %9s %6s\n", kernel,
           oblique ? "oblique" : "along the axes", b->side, b->side, b->size, "method", "predicted",
           "measured", "ratio");
    params.slice.progress = &progress;
    for (size_t i = 0; res == WEFT_OK && i < count; i++) {
        // A small case plans few taps and samples.
        if (!b->full && methods[i].algorithm == WEFT_ALGORITHM_MULTIPASS && methods[i].samples > 16)
            continue;
        params.method = methods[i];
        compare(b, &params);
    }
    weft_slice_plan_destroy(&plan);
    free(methods);
    return res;
}

static enum weft_result run_kernels(struct bench *b)
{
    enum weft_result res = WEFT_OK;
    for (const char *at = b->kernels; res == WEFT_OK && *at; at += *at == ',') {
        char kernel[64];
        const int length = (int)strcspn(at, ",");
        snprintf(kernel, sizeof kernel, "%.*s", length, at);
        at += length;
        for (int oblique = 1; res == WEFT_OK && oblique >= 0; oblique--)
            res = run_slice(b, kernel, oblique);
    }
    return res;
}

static enum weft_result calibrate(struct bench *b)
{
    const double start = weft_now_seconds();
    b->model = weft_cost_default;
    if (b->defaults || !b->full) // measuring what costs are is test_command_calibrate's
        return WEFT_OK;
    enum weft_result res = weft_cost_calibrate(&log_to_stderr, b->context, NULL, &b->model);
    char *text = res == WEFT_OK ? weft_cost_format(&b->model) : NULL;
    if (text)
        printf("calibrated in %.1f s\n%s", weft_now_seconds() - start, text);
    free(text);
    return res;
}

static int run(struct bench *b)
{
    enum weft_result res = weft_context_create(
        &(struct weft_context_params){.kind = b->kind, .log = &log_to_stderr}, &b->context);
    if (res == WEFT_ERR_UNSUPPORTED)
        return 77;
    if (res == WEFT_OK)
        res = make_volume(b);
    if (res == WEFT_OK)
        res = calibrate(b);
    if (res == WEFT_OK)
        res = run_kernels(b);
    printf("%d of %d methods within a factor of 1.5 (times in ms, medians of %d)\n", b->close,
           b->compared, b->runs);
    weft_volume_destroy(&b->volume);
    weft_context_destroy(&b->context);
    free(b->pixels);
    return res != WEFT_OK || b->failures || !b->compared;
}

int main(int argc, char **argv)
{
    struct bench b = {.kernels = "linear", .kind = WEFT_CONTEXT_AUTO};
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--bench") == 0) {
            b.full = true;
            b.kernels = "catmull-rom,linear,lanczos:3";
        } else if (strcmp(argv[i], "--defaults") == 0) {
            b.defaults = true;
        } else if (strcmp(argv[i], "--kernels") == 0 && i + 1 < argc) {
            b.kernels = argv[++i];
        } else if (strcmp(argv[i], "--context") == 0 && i + 1 < argc) {
            if (weft_context_kind_parse(&log_to_stderr, argv[++i], &b.kind) != WEFT_OK)
                return 2;
        } else {
            fprintf(stderr, "usage: bench_cost [--bench] [--context auto|osmesa|egl] "
                            "[--kernels NAME,...] [--defaults]\n");
            return 2;
        }
    }
    b.size = b.full ? 256 : 48;
    b.side = b.full ? 512 : 64;
    b.runs = b.full ? MAX_RUNS : 1;
    return run(&b);
}
