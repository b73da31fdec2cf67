// SPDX-License-Identifier: BSD-3-Clause
// Oblique Catmull-Rom slices in passes: what share of a whole run each step takes, and the whole
// run over its passes. Two runs of a compiled slice count apart: the first one, which reads bricks
// and finds the range of the voxels and where pixels lie, and later ones.
// Run without --bench it takes a small slice, and checks that later runs give the first one's
// pixels.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "weft.h"

enum { MAX_RUNS = 31, LATER_RUNS = 2, METHODS = 4, BRICK = 8 };

static const struct {
    const char *profile, *technique;
} methods[METHODS] = {
    {"unorm8", "plain"}, {"unorm8", "dot4"}, {"unorm16", "plain"}, {"fp16", "dot4"}};

struct bench {
    struct weft_kernel kernel;
    weft_context *context;
    weft_volume *volume;
    int runs, side, size; // of pixels and voxels along an axis
    struct weft_slice_geometry cut;
};

// Seconds of a run.
enum step { READ, LAYOUT, UPLOAD, PASSES, READ_BACK, WHOLE, STEPS };
struct times {
    double seconds[STEPS];
};

static void log_line(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    if (level <= WEFT_LOG_WARNING)
        fprintf(stderr, "%s\n", message);
}

static const struct weft_log log_to_stderr = {log_line, NULL};

static double now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

// ---- the volume ---------------------------------------------------------------------------------

static const double along[3] = {0.8, 0.36, -0.48}, down[3] = {0.0, 0.8, 0.6};

static double distance(int size, const int32_t origin[3])
{
    double sum = 0.0;
    for (int a = 0; a < 3; a++) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        const double normal = along[b] * down[c] - along[c] * down[b];
        sum += normal * (origin[a] + 0.5 * (BRICK - 1) - 0.5 * (size - 1));
    }
    return fabs(sum);
}

// Origins of the bricks near the plane; counts them where `out` is NULL.
static size_t find_bricks(int size, int32_t (*out)[3])
{
    size_t count = 0;
    int32_t at[3];
    for (at[2] = 0; at[2] < size; at[2] += BRICK)
        for (at[1] = 0; at[1] < size; at[1] += BRICK)
            for (at[0] = 0; at[0] < size; at[0] += BRICK)
                if (distance(size, at) <= 20.0) {
                    if (out)
                        memcpy(out[count], at, sizeof at);
                    count++;
                }
    return count;
}

static weft_volume *make_noise(int size)
{
    const size_t count = find_bricks(size, NULL), voxels = count * WEFT_BRICK_VOXELS;
    int32_t(*origin)[3] = malloc(count * sizeof *origin);
    float *values = malloc(voxels * sizeof *values);
    weft_volume *volume = NULL;
    if (origin && values) {
        find_bricks(size, origin);
        for (size_t i = 0; i < voxels; i++)
            values[i] = (float)((uint32_t)(i * 2654435761u) >> 8) / 16777216.0f;
        weft_volume_create_bricks(
            weft_volume_bricks_params(.brick_count = count,
                                      .brick_origin = (const int32_t(*)[3])origin,
                                      .brick_values = values, .log = &log_to_stderr),
            &volume);
    }
    free(origin);
    free(values);
    return volume;
}

static void set_cut(struct bench *b)
{
    const double middle = 0.5 * (b->size - 1), half = 0.4 * b->size;
    b->cut.width = b->cut.height = b->side;
    for (int a = 0; a < 3; a++) {
        b->cut.u[a] = 2.0 * half * along[a];
        b->cut.v[a] = 2.0 * half * down[a];
        b->cut.origin[a] = middle - half * (along[a] + down[a]);
    }
}

// ---- runs ---------------------------------------------------------------------------------------

static enum weft_result run_slice(weft_slice *slice, float *pixels, struct times *out)
{
    struct weft_slice_report r;
    const double start = now();
    const enum weft_result res = weft_slice_run(slice, weft_slice_run_params(.pixels = pixels), &r);
    *out = (struct times){{[READ] = r.read_seconds,
                           [LAYOUT] = r.layout_seconds,
                           [UPLOAD] = r.upload_seconds,
                           [PASSES] = r.pass_seconds,
                           [READ_BACK] = r.readback_seconds,
                           [WHOLE] = now() - start}};
    return res;
}

// A plan of its own, so that nothing is known of the voxels. Returns how many pixels differ between
// runs, -1: failed.
static int run_method(const struct bench *b, const weft_pass_plan *passes, float *const pixels[2],
                      struct times *first, struct times *later)
{
    const struct weft_slice_params params = {.geometry = b->cut,
                                             .kernel = b->kernel,
                                             .space = WEFT_SPACE_INDEX,
                                             .without = WEFT_SAVING_AXIS,
                                             .log = &log_to_stderr};
    const struct weft_slice_passes p = {
        .plan = passes, .low = NAN, .high = NAN, .log = &log_to_stderr};
    const struct weft_slice_compile_params where = {.context = b->context, .passes = &p};
    weft_slice_plan *plan = NULL;
    weft_slice *slice = NULL;
    int different = 0;
    enum weft_result res = weft_slice_plan_create(b->volume, &params, &plan);
    if (res == WEFT_OK)
        res = weft_slice_compile(plan, &where, &slice);
    if (res == WEFT_OK)
        res = run_slice(slice, pixels[0], first);
    for (int i = 0; res == WEFT_OK && i < LATER_RUNS; i++) {
        res = run_slice(slice, pixels[1], &later[i]);
        for (int at = 0; at < b->side * b->side; at++)
            different += memcmp(&pixels[0][at], &pixels[1][at], sizeof(float)) != 0;
    }
    weft_slice_destroy(&slice);
    weft_slice_plan_destroy(&plan);
    return res == WEFT_OK ? different : -1;
}

// ---- results ------------------------------------------------------------------------------------

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Of a step, or of a step over the passes of the same run.
static double median(const struct times *times, int count, enum step step, bool over_passes)
{
    double values[LATER_RUNS * MAX_RUNS];
    for (int i = 0; i < count; i++)
        values[i] = times[i].seconds[step] / (over_passes ? times[i].seconds[PASSES] : 1.0);
    qsort(values, (size_t)count, sizeof *values, compare);
    return values[count / 2];
}

static void print_times(int method, const char *which, const struct times *times, int count)
{
    printf("%-8s %-6s %-6s", methods[method].profile, methods[method].technique, which);
    for (int step = 0; step < STEPS; step++)
        printf(" %9.1f", 1e3 * median(times, count, (enum step)step, false));
    printf(" %12.2f\n", median(times, count, WHOLE, true));
}

static int bench_method(const struct bench *b, int number, float *const pixels[2])
{
    struct times first[MAX_RUNS], later[LATER_RUNS * MAX_RUNS];
    struct weft_pass_plan_params params = {
        .kernel = b->kernel, .dims = 3, .channels = 1, .log = &log_to_stderr};
    weft_pass_plan *passes = NULL;
    int different = 0;
    params.profile = *weft_profile_find(methods[number].profile);
    for (int t = 0; weft_technique_names[t]; t++)
        if (strcmp(weft_technique_names[t], methods[number].technique) == 0)
            params.technique = (enum weft_technique)t;
    if (weft_pass_plan_create(&params, &passes) != WEFT_OK)
        return 1;
    for (int i = 0; different == 0 && i < b->runs; i++)
        different = run_method(b, passes, pixels, &first[i], &later[LATER_RUNS * i]);
    weft_pass_plan_destroy(&passes);
    if (different != 0) {
        fprintf(stderr, "bench_passes: %s %s: %s\n", methods[number].profile,
                methods[number].technique,
                different < 0 ? "failed" : "later runs give other pixels");
        return 1;
    }
    print_times(number, "first", first, b->runs);
    print_times(number, "later", later, LATER_RUNS * b->runs);
    return 0;
}

static int run(struct bench *b)
{
    const size_t count = (size_t)b->side * (size_t)b->side;
    float *const pixels[2] = {malloc(count * sizeof(float)), malloc(count * sizeof(float))};
    int failures = 1;
    b->volume = make_noise(b->size);
    if (b->volume && pixels[0] && pixels[1] &&
        weft_kernel_parse(&log_to_stderr, "catmull-rom", &b->kernel) == WEFT_OK) {
        set_cut(b);
        printf("%s; an oblique slice of %d^2 pixels of %d^3 voxels of noise in memory, "
               "Catmull-Rom, medians of %d turns, ms\n",
               weft_context_get_info(b->context)->renderer, b->side, b->size, b->runs);
        printf("%-8s %-6s %-6s %9s %9s %9s %9s %9s %9s %12s\n", "profile", "by", "run", "read",
               "layout", "upload", "passes", "read back", "whole", "over passes");
        failures = 0;
        for (int m = 0; m < METHODS; m++)
            failures += bench_method(b, m, pixels);
    }
    weft_volume_destroy(&b->volume);
    free(pixels[0]);
    free(pixels[1]);
    return failures != 0;
}

int main(int argc, char **argv)
{
    struct bench b = {.runs = 1, .side = 96, .size = 96};
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--bench") == 0) {
            b.runs = 5;
            b.side = b.size = 1024;
        } else if (strcmp(argv[i], "--runs") == 0 && i + 1 < argc) {
            b.runs = atoi(argv[++i]);
        } else {
            fprintf(stderr, "usage: bench_passes [--bench] [--runs N]\n");
            return 2;
        }
    }
    if (b.runs < 1 || b.runs > MAX_RUNS) {
        fprintf(stderr, "bench_passes: runs must be 1 to %d\n", MAX_RUNS);
        return 2;
    }
    if (weft_context_create(weft_context_params(.kind = WEFT_CONTEXT_OSMESA, .log = &log_to_stderr),
                            &b.context) != WEFT_OK)
        return 77; // skipped
    const int status = run(&b);
    weft_context_destroy(&b.context);
    return status;
}
