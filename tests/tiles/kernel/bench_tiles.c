// SPDX-License-Identifier: BSD-3-Clause
// Kernel tile sets: time and memory by resolution, with and without mirroring; and over kernels
// what sum-preserving rounding costs and saves against rounding every weight by itself. Without
// --bench it runs small sets once and checks that the sums come out. Usage: bench_tiles [--bench]
// [--runs N]
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "tests/support/tile_error.h"
#include "tests/support/samples.h"
#include "weft.h"

enum { MAX_RUNS = 99 };

static void print_log(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    if (level <= WEFT_LOG_WARNING)
        fprintf(stderr, "bench_tiles: %s\n", message);
}

static const struct weft_log log_to_stderr = {print_log, NULL};

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// ---- time and memory ----------------------------------------------------------------------------

static int time_set(const char *name, int dims, int samples, bool mirror,
                    enum weft_tile_rounding rounding, int runs, uint64_t memory_bytes)
{
    double seconds[MAX_RUNS];
    struct weft_kernel_tiles_info info = {.tile_count = 0};
    struct weft_kernel_tiles_params p =
        *weft_kernel_tiles_params(.dims = dims, .samples = samples, .store_all = !mirror,
                                  .rounding = rounding, .memory_bytes = memory_bytes);
    if (weft_kernel_parse(&log_to_stderr, name, &p.kernel) != WEFT_OK)
        return 1;
    for (int i = -1; i < runs; i++) { // the first one warms up
        weft_kernel_tiles *set = NULL;
        const double start = weft_now_seconds();
        const enum weft_result res = weft_kernel_tiles_create(&p, &set);
        if (res == WEFT_ERR_LIMIT) {
            printf("%-12s %dD %5d %9s %-8s over the limit of %.0f MB\n", name, dims, samples,
                   mirror ? "mirrored" : "whole", rounding ? "sums" : "nearest",
                   1e-6 * (double)memory_bytes);
            return 0;
        }
        if (res != WEFT_OK)
            return 1;
        if (i >= 0)
            seconds[i] = weft_now_seconds() - start;
        info = *weft_kernel_tiles_get_info(set);
        weft_kernel_tiles_destroy(&set);
    }
    qsort(seconds, (size_t)runs, sizeof *seconds, by_value);
    printf("%-12s %dD %5d %9s %-8s %6d %6d %10.3f %10.3f %10.2f\n", name, dims, samples,
           mirror ? "mirrored" : "whole", rounding ? "sums" : "nearest", info.tile_count,
           info.stored_count, 1e-6 * (double)info.memory_bytes, 1e-6 * (double)info.saved_bytes,
           1e3 * seconds[runs / 2]);
    return 0;
}

static int time_sets(bool bench, int runs)
{
    static const int samples[] = {16, 32, 64, 128, 256, 512};
    const uint64_t memory_bytes = UINT64_C(1) << 29;
    const int sizes = bench ? 6 : 1;
    int failures = 0;
    printf("tile sets, 8-bit unorm, median of %d runs\n", runs);
    printf("%-12s %s %5s %9s %-8s %6s %6s %10s %10s %10s\n", "kernel", "d ", "M", "storage",
           "rounding", "tiles", "stored", "MB", "saved MB", "ms");
    for (int dims = 2; dims <= 3; dims++)
        for (int i = 0; i < sizes; i++)
            for (int rounding = 0; rounding < 2; rounding++)
                for (int mirror = 1; mirror >= 0; mirror--)
                    failures += time_set("catmull-rom", dims, samples[i], mirror,
                                         rounding ? WEFT_TILE_SUM_PRESERVING : WEFT_TILE_NEAREST,
                                         dims == 3 && samples[i] > 64 ? 1 : runs, memory_bytes);
    return failures;
}

// ---- sum-preserving against independent rounding ------------------------------------------------

struct rounding_figures {
    double weight_lsb;          // largest error of one weight at a sample
    int ripple_min, ripple_max; // of the sum of weights at a sample against the full range, LSB
    double error_lsb;           // eps_h, nearest lookup
};

// Adds what the tiles have at a sample, tap by tap.
static void add_sample(const weft_kernel_tiles *set, const int at[3], double *weight, int *total)
{
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(set);
    *total = 0;
    for (int t = 0; t < info->tile_count; t++) {
        const int *tap = weft_kernel_tiles_get(set, t)->tap;
        weight[(tap[2] * info->width + tap[1]) * info->width + tap[0]] +=
            weft_kernel_tiles_value(set, t, at);
        *total += weft_kernel_tiles_integer(set, t, at);
    }
}

static bool measure_rounding(const struct weft_kernel *kernel, int dims, int samples,
                             enum weft_tile_rounding rounding, struct rounding_figures *out)
{
    static double weight[WEFT_KERNEL_MAX_WIDTH * WEFT_KERNEL_MAX_WIDTH * WEFT_KERNEL_MAX_WIDTH];
    weft_kernel_tiles *set = NULL;
    struct weft_tile_error error;
    *out = (struct rounding_figures){.ripple_min = 1 << 20, .ripple_max = -(1 << 20)};
    if (weft_kernel_tiles_create(weft_kernel_tiles_params(.kernel = *kernel, .dims = dims,
                                                          .samples = samples, .rounding = rounding,
                                                          .log = &log_to_stderr),
                                 &set) != WEFT_OK)
        return false;
    int at[3] = {0};
    do {
        int tap[3] = {0}, total;
        memset(weight, 0, sizeof weight);
        add_sample(set, at, weight, &total);
        out->ripple_min = total - 255 < out->ripple_min ? total - 255 : out->ripple_min;
        out->ripple_max = total - 255 > out->ripple_max ? total - 255 : out->ripple_max;
        do {
            const double w = weight[(tap[2] * kernel->width + tap[1]) * kernel->width + tap[0]];
            out->weight_lsb =
                fmax(out->weight_lsb, 255.0 * fabs(w - weft_kernel_tiles_exact(set, tap, at)));
        } while (next_position(dims, kernel->width, tap));
    } while (next_position(dims, samples, at));
    const struct weft_tile_error_params params = {
        .tiles = set, .locations = dims == 3 ? 32 : 256, .log = &log_to_stderr};
    const bool done = weft_tile_error_model(&params, &error) == WEFT_OK;
    out->error_lsb = 255.0 * error.ideal.maximum;
    weft_kernel_tiles_destroy(&set);
    return done;
}

static int compare_roundings(bool bench)
{
    static const char *const names[] = {
        "linear",           "bspline",        "catmull-rom",
        "mitchell",         "notch",          "bspline5",
        "lagrange3",        "omoms3",         "keys6",
        "lanczos:2+unit",   "lanczos:3+unit", "blackman-sinc:2+unit",
        "hann-sinc:3+unit", "gaussian+unit"};
    int failures = 0;
    printf("\n8-bit unorm, each weight by itself | sum-preserving; LSB; nearest lookup\n");
    printf("%-22s %s %4s %8s %9s %8s | %8s %6s %8s\n", "kernel", "d ", "M", "weight", "ripple",
           "eps_h", "weight", "ripple", "eps_h");
    for (int dims = 2; dims <= 3; dims++) {
        for (size_t i = 0; i < (bench ? WEFT_COUNT(names) : 3); i++) {
            struct weft_kernel kernel;
            struct rounding_figures apart, together;
            const int samples = dims == 3 ? 16 : bench ? 64 : 16;
            if (weft_kernel_parse(NULL, names[i], &kernel) != WEFT_OK ||
                (dims == 3 && kernel.width > 4))
                continue;
            if (!measure_rounding(&kernel, dims, samples, WEFT_TILE_NEAREST, &apart) ||
                !measure_rounding(&kernel, dims, samples, WEFT_TILE_SUM_PRESERVING, &together)) {
                failures++;
                continue;
            }
            printf("%-22s %dD %4d %8.4f %+4d..%+3d %8.4f | %8.4f %6d %8.4f\n", names[i], dims,
                   samples, apart.weight_lsb, apart.ripple_min, apart.ripple_max, apart.error_lsb,
                   together.weight_lsb, together.ripple_max - together.ripple_min,
                   together.error_lsb);
            failures += together.ripple_min != 0 || together.ripple_max != 0 ||
                        !(together.weight_lsb < 1.0) || !(apart.weight_lsb <= 0.5 + 1e-9);
        }
    }
    return failures;
}

int main(int argc, char **argv)
{
    bool bench = false;
    int runs = 1;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--bench") == 0) {
            bench = true;
            runs = 5;
        } else if (strcmp(argv[i], "--runs") == 0 && i + 1 < argc) {
            runs = atoi(argv[++i]);
            runs = runs < 1 ? 1 : runs > MAX_RUNS ? MAX_RUNS : runs;
        } else {
            fprintf(stderr, "usage: bench_tiles [--bench] [--runs N]\n");
            return 2;
        }
    }
    return time_sets(bench, runs) + compare_roundings(bench) ? 1 : 0;
}
