// SPDX-License-Identifier: BSD-3-Clause
// Multi-pass plans: passes, time and error of every technique on every profile, for tri-cubic
// reconstruction at oblique positions; the ratio of plain to dot4, one tap or four a pass, turn by
// turn; and how time grows with taps. Without --bench it runs small pictures once and checks that
// errors stay within their bounds. Usage: bench_plan [--bench] [--context auto|osmesa|egl]
// [--runs N]
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "weft.h"
#include "tests/support/plan_runs.h"

enum { MAX_RUNS = 99, VERIFIED_SIDE = 96 };

struct bench {
    weft_context *context;
    int size, side, runs; // samples and pixels along a side
    float *samples, *pixels;
    int failures;
    bool small; // without --bench: kernels of few taps, in coarse tables
};

static void print_log(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    if (level <= WEFT_LOG_WARNING)
        fprintf(stderr, "bench_plan: %s\n", message);
}

static const struct weft_log log_to_stderr = {print_log, NULL};

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, int count)
{
    qsort(values, (size_t)count, sizeof *values, by_value);
    return values[count / 2];
}

static bool make_samples(struct bench *b)
{
    const struct weft_signal_info *signal = weft_signal_find("marschner-lobb");
    const int n = b->size;
    b->samples = malloc((size_t)n * (size_t)n * (size_t)n * sizeof *b->samples);
    const size_t side = (size_t)(b->side > VERIFIED_SIDE ? b->side : VERIFIED_SIDE);
    b->pixels = malloc(side * side * sizeof *b->pixels);
    for (int i = 0; b->samples && b->pixels && i < n * n * n; i++) {
        const double at[3] = {weft_signal_coordinate(i % n, n),
                              weft_signal_coordinate(i / n % n, n),
                              weft_signal_coordinate(i / n / n, n)};
        b->samples[i] = (float)signal->value(at);
    }
    return b->samples && b->pixels;
}

static struct weft_multipass_run_params job(const struct bench *b, const weft_pass_plan *plan,
                                            int side, struct weft_samples *samples,
                                            struct weft_pixel_grid *grid)
{
    const double n = b->size, step = 0.9 * n / side;
    const int dims = weft_pass_plan_get_info(plan)->dims;
    *samples = (struct weft_samples){.size = {b->size, b->size, dims > 2 ? b->size : 1},
                                     .plane = {b->samples},
                                     .low = 0.0,
                                     .high = 1.0};
    *grid = (struct weft_pixel_grid){.width = side,
                                     .height = side,
                                     .origin = {0.05 * n, 0.1 * n, 0.2 * n},
                                     .du = {0.9 * step, 0.1 * step, 0.3 * step},
                                     .dv = {-0.05 * step, 0.85 * step, 0.25 * step}};
    return (struct weft_multipass_run_params){
        .samples = samples, .grid = grid, .pixels = {b->pixels}, .log = &log_to_stderr};
}

static double run_once(struct bench *b, const weft_pass_plan *plan, int side,
                       struct weft_verify_report *error)
{
    struct weft_samples samples;
    struct weft_pixel_grid grid;
    struct weft_multipass_report report = {0};
    const struct weft_multipass_run_params params = job(b, plan, side, &samples, &grid);
    if (run_plan(b->context, plan, &params, &report) != WEFT_OK ||
        (error && verify_plan(plan, &params, error) != WEFT_OK))
        b->failures++;
    return report.pass_seconds;
}

static weft_pass_plan *make(struct bench *b, const struct weft_pass_plan_params *params)
{
    struct weft_pass_plan_params p = *params;
    weft_pass_plan *plan = NULL;
    p.log = &log_to_stderr;
    b->failures += weft_pass_plan_create(&p, &plan) != WEFT_OK;
    return plan;
}

// ---- techniques and profiles --------------------------------------------------------------------

static bool has_technique(const struct weft_profile *profile, int technique)
{
    return weft_target_bits(profile->target) > 0 || technique <= WEFT_TECHNIQUE_DOT4;
}

static void print_technique(struct bench *b, const struct weft_profile *profile, int technique)
{
    double seconds[MAX_RUNS];
    struct weft_verify_report error = {0};
    weft_pass_plan *plan =
        make(b, weft_pass_plan_params(.dims = 3, .profile = *profile, .samples = b->small ? 8 : 32,
                                      .technique = (enum weft_technique)technique));
    if (!plan)
        return;
    const struct weft_pass_plan_info *info = weft_pass_plan_get_info(plan);
    run_once(b, plan, VERIFIED_SIDE, &error);
    run_once(b, plan, b->side, NULL); // warms up
    for (int i = 0; i < b->runs; i++)
        seconds[i] = run_once(b, plan, b->side, NULL);
    b->failures += !(error.maximum <= info->error.bound_any + 1e-6);
    const double time = median(seconds, b->runs);
    printf("%-11s %-16s %6d %8d %8.1f %9.1f %9.2f %10.5f %10.5f %9.3f %9.3f\n", profile->name,
           weft_technique_names[technique], info->passes->pass_count, info->fetches, 1e3 * time,
           1e-6 * b->side * b->side / time, 1e-6 * (double)info->tile_bytes, error.maximum,
           error.rms, info->error.bound, info->error.bound_any);
    weft_pass_plan_destroy(&plan);
}

static void print_techniques(struct bench *b)
{
    printf("\ncatmull-rom, 3D, M %d, %d x %d pixels, as many taps a pass as the profile takes\n",
           b->small ? 8 : 32, b->side, b->side);
    printf("%-11s %-16s %6s %8s %8s %9s %9s %10s %10s %9s %9s\n", "profile", "technique", "passes",
           "fetches", "ms", "Mpixel/s", "tiles MB", "max error", "rms error", "bound", "any");
    for (const struct weft_profile *const *p = weft_profile_list; *p; p++)
        for (int t = 0; t <= WEFT_TECHNIQUE_LOG; t++)
            if (has_technique(*p, t))
                print_technique(b, *p, t);
}

// ---- plain against dot4 -------------------------------------------------------------------------

static void print_ratio(struct bench *b, const char *kernel, const char *profile)
{
    double plain[MAX_RUNS], dot4[MAX_RUNS], ratio[MAX_RUNS];
    struct weft_pass_plan_params p =
        *weft_pass_plan_params(.dims = 3, .samples = b->small ? 8 : 32, .taps_per_pass = 1);
    if (weft_kernel_parse(&log_to_stderr, kernel, &p.kernel) != WEFT_OK)
        return;
    p.profile = *weft_profile_find(profile);
    weft_pass_plan *one = make(b, &p);
    p.technique = WEFT_TECHNIQUE_DOT4;
    weft_pass_plan *four = make(b, &p);
    for (int i = -1; one && four && i < b->runs; i++) {
        const double first = run_once(b, one, b->side, NULL);
        const double second = run_once(b, four, b->side, NULL);
        if (i < 0)
            continue;
        plain[i] = first;
        dot4[i] = second;
        ratio[i] = first / second;
    }
    if (one && four)
        printf("%-14s %-11s %4d passes %7.1f ms, dot4 %3d passes %7.1f ms: %.2f times fewer, %.2f "
               "times faster\n",
               kernel, profile, weft_pass_plan_get_info(one)->passes->pass_count,
               1e3 * median(plain, b->runs), weft_pass_plan_get_info(four)->passes->pass_count,
               1e3 * median(dot4, b->runs),
               (double)weft_pass_plan_get_info(one)->passes->pass_count /
                   weft_pass_plan_get_info(four)->passes->pass_count,
               median(ratio, b->runs));
    weft_pass_plan_destroy(&one);
    weft_pass_plan_destroy(&four);
}

static void print_ratios(struct bench *b)
{
    static const char *const kernels[] = {"bspline", "catmull-rom", "lagrange3"};
    static const char *const profiles[] = {"unorm8", "unorm16", "fp32"};
    printf("\none tap or four a pass, medians of %d turns, ratios turn by turn\n", b->runs);
    for (size_t p = 0; p < WEFT_COUNT(profiles); p++)
        for (size_t k = 0; k < WEFT_COUNT(kernels) - b->small; k++)
            print_ratio(b, kernels[k], profiles[p]);
}

// ---- cost by taps -------------------------------------------------------------------------------

static void print_cost(struct bench *b, const char *kernel, int dims, enum weft_technique technique)
{
    double seconds[MAX_RUNS];
    struct weft_pass_plan_params p =
        *weft_pass_plan_params(.dims = dims, .samples = dims > 2 ? 16 : 64, .taps_per_pass = 1,
                               .technique = technique);
    if (weft_kernel_parse(&log_to_stderr, kernel, &p.kernel) != WEFT_OK)
        return;
    p.profile = *weft_profile_find("fp32"); // no tile is dropped for being 0
    weft_pass_plan *plan = make(b, &p);
    if (!plan)
        return;
    run_once(b, plan, b->side, NULL);
    for (int i = 0; i < b->runs; i++)
        seconds[i] = run_once(b, plan, b->side, NULL);
    const struct weft_pass_plan_info *info = weft_pass_plan_get_info(plan);
    const double time = median(seconds, b->runs);
    printf("%-12s %dD %-6s %4d taps %4d passes %8.1f ms, %6.3f ms a pass, %6.3f ms a tap\n", kernel,
           dims, weft_technique_names[technique], info->tap_count, info->passes->pass_count,
           1e3 * time, 1e3 * time / info->passes->pass_count, 1e3 * time / info->tap_count);
    weft_pass_plan_destroy(&plan);
}

static void print_costs(struct bench *b)
{
    printf("\nfp32, one group of taps a pass\n");
    for (int t = WEFT_TECHNIQUE_PLAIN; t <= WEFT_TECHNIQUE_DOT4; t++) {
        print_cost(b, "linear", 3, (enum weft_technique)t);
        print_cost(b, "bspline", 2, (enum weft_technique)t);
        print_cost(b, "bspline", 3, (enum weft_technique)t);
        if (!b->small)
            print_cost(b, "lanczos:3", 3, (enum weft_technique)t);
    }
}

int main(int argc, char **argv)
{
    struct bench b = {.size = 20, .side = 48, .runs = 1, .small = true};
    bool bench = false;
    enum weft_context_kind kind = WEFT_CONTEXT_OSMESA;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--bench") == 0) {
            bench = true;
            b = (struct bench){.size = 64, .side = 1024, .runs = b.runs > 1 ? b.runs : 7};
        } else if (strcmp(argv[i], "--runs") == 0 && i + 1 < argc) {
            b.runs = atoi(argv[++i]);
            b.runs = b.runs < 1 ? 1 : b.runs > MAX_RUNS ? MAX_RUNS : b.runs;
        } else if (strcmp(argv[i], "--context") == 0 && i + 1 < argc) {
            if (weft_context_kind_parse(&log_to_stderr, argv[++i], &kind) != WEFT_OK)
                return 2;
        } else {
            fprintf(stderr, "usage: bench_plan [--bench] [--context auto|osmesa|egl] [--runs N]\n");
            return 2;
        }
    }
    const struct weft_context_params params = {.kind = kind, .log = &log_to_stderr};
    if (!make_samples(&b) || weft_context_create(&params, &b.context) != WEFT_OK)
        return bench ? 1 : 77;
    const struct weft_context_info *info = weft_context_get_info(b.context);
    printf("%s, %s, %s; %d^3 samples\n", info->platform, info->renderer, info->version, b.size);
    print_techniques(&b);
    print_ratios(&b);
    print_costs(&b);
    weft_context_destroy(&b.context);
    free(b.samples);
    free(b.pixels);
    return b.failures ? 1 : 0;
}
