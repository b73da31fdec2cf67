// SPDX-License-Identifier: BSD-3-Clause
// What stays: slices with a volume to themselves, and with a resident one, on OpenGL and the CPU
// engine: the first slice, the same plane again, and a sweep of planes a voxel apart, planned,
// compiled, run and destroyed each; 1024 x 1024 pixels, oblique, Catmull-Rom, of 256^3 floats in
// memory. Without --bench it runs a small case once and checks that pixels are the same.
// Usage: bench_resident [--bench] [--context osmesa|egl] [--runs N]
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "weft.h"

enum { SWEEP = 100, MOST = 2 * SWEEP };

static void print_log(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    if (level <= WEFT_LOG_WARNING)
        fprintf(stderr, "bench_resident: %s\n", message);
}

static const struct weft_log log_to_stderr = {print_log, NULL};

// ---- one slice ----------------------------------------------------------------------------------

// Where a slice's time goes.
enum part { PLAN, COMPILE, READ, LAYOUT, UPLOAD, PASSES, READ_BACK, REST, PARTS };
static const char *const part_names[PARTS] = {"plan",   "compile", "read",      "layout",
                                              "upload", "passes",  "read back", "rest"};

struct times {
    double part[PARTS], whole;
};

struct way {
    const char *name;
    weft_context *context; // NULL: the CPU engine
    weft_resident *resident;
    bool stays;
    struct times first, again[MOST], sweep[MOST];
    int agains, sweeps;
    float *pixels; // of the sweep's last plane
};

struct job {
    weft_volume *volume;
    int size, side;
};

static void set_plane(const struct job *job, double step, struct weft_slice_geometry *g)
{
    // A plane through the middle, tilted against all axes; steps along its normal, roughly.
    const double u[3] = {0.62, 0.28, 0.12}, v[3] = {-0.25, 0.55, 0.30};
    const double normal[3] = {0.04, -0.49, 0.87};
    *g = (struct weft_slice_geometry){.width = job->side, .height = job->side};
    for (int a = 0; a < 3; a++) {
        g->u[a] = u[a] * job->size;
        g->v[a] = v[a] * job->size;
        g->origin[a] = 0.5 * job->size - 0.5 * (g->u[a] + g->v[a]) + step * normal[a];
    }
}

static enum weft_result run_slice(const struct job *job, struct way *way, double step,
                                  struct times *out)
{
    weft_slice_plan *plan = NULL;
    weft_slice *slice = NULL;
    struct weft_slice_report report;
    struct weft_slice_params params = {.engine = way->context ? WEFT_ENGINE_GL : WEFT_ENGINE_CPU,
                                       .space = WEFT_SPACE_INDEX,
                                       .layout = way->context ? WEFT_LAYOUT_INTERLEAVED
                                                              : WEFT_LAYOUT_PLAIN,
                                       .resident = way->resident,
                                       .log = &log_to_stderr};
    set_plane(job, step, &params.geometry);
    const double start = weft_now_seconds();
    enum weft_result res = weft_slice_plan_create(job->volume, &params, &plan);
    const double planned = weft_now_seconds();
    if (res == WEFT_OK)
        res = weft_slice_compile(plan, weft_slice_compile_params(.context = way->context), &slice);
    const double compiled = weft_now_seconds();
    if (res == WEFT_OK)
        res = weft_slice_run(slice, weft_slice_run_params(.pixels = way->pixels), &report);
    weft_slice_destroy(&slice);
    weft_slice_plan_destroy(&plan);
    if (res != WEFT_OK)
        return res;
    *out = (struct times){.part = {[PLAN] = planned - start,
                                   [COMPILE] = compiled - planned,
                                   [READ] = report.read_seconds,
                                   [LAYOUT] = report.layout_seconds,
                                   [UPLOAD] = report.upload_seconds,
                                   [PASSES] = report.pass_seconds,
                                   [READ_BACK] = report.readback_seconds},
                          .whole = weft_now_seconds() - start};
    out->part[REST] = out->whole;
    for (int p = 0; p < REST; p++)
        out->part[REST] -= out->part[p];
    return WEFT_OK;
}

// ---- turns --------------------------------------------------------------------------------------

static enum weft_result hold(const struct job *job, struct way *way)
{
    return way->stays ? weft_resident_create(weft_resident_params(.volume = job->volume,
                                                                  .context = way->context,
                                                                  .log = &log_to_stderr),
                                             &way->resident)
                      : WEFT_OK;
}

// The first slice of each way, on a resident volume that is empty; programs are compiled before.
static enum weft_result run_first(const struct job *job, struct way *ways, int count)
{
    enum weft_result res = WEFT_OK;
    for (int w = 0; res == WEFT_OK && w < count; w++) {
        res = run_slice(job, &ways[w], 0.0, &ways[w].first);
        if (res == WEFT_OK)
            res = hold(job, &ways[w]);
        if (res == WEFT_OK)
            res = run_slice(job, &ways[w], 0.0, &ways[w].first);
    }
    return res;
}

// One plane after the other, each by all ways, so that what slows the machine down slows all.
static enum weft_result run_turns(const struct job *job, struct way *ways, int count, int runs,
                                  bool sweep)
{
    enum weft_result res = WEFT_OK;
    for (int i = 0; res == WEFT_OK && i < runs; i++) {
        for (int w = 0; res == WEFT_OK && w < count; w++) {
            struct way *way = &ways[w];
            res = run_slice(job, way, sweep ? (i % SWEEP - SWEEP / 2) * job->size / 256.0 : 0.0,
                            sweep ? &way->sweep[way->sweeps++] : &way->again[way->agains++]);
        }
    }
    return res;
}

// ---- figures ------------------------------------------------------------------------------------

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// The median of a part, or of the whole (PARTS).
static double median(const struct times *times, int count, int part)
{
    double values[MOST];
    for (int i = 0; i < count; i++)
        values[i] = part == PARTS ? times[i].whole : times[i].part[part];
    qsort(values, (size_t)count, sizeof *values, by_value);
    return values[count / 2];
}

static void print_times(const char *name, const char *what, const struct times *times, int count)
{
    const double whole = median(times, count, PARTS);
    printf("%-20s %-7s %8.2f", name, what, 1e3 * whole);
    for (int p = 0; p < PARTS; p++)
        printf(" %9.2f", 1e3 * median(times, count, p));
    printf(" %8.0f%%\n", 100.0 * (1.0 - median(times, count, PASSES) / whole));
}

static void print_all(const struct job *job, const struct way *ways, int count)
{
    printf("%d^3 voxels, %d x %d pixels; medians, milliseconds\n", job->size, job->side, job->side);
    printf("%-20s %-7s %8s", "", "slice", "whole");
    for (int p = 0; p < PARTS; p++)
        printf(" %9s", part_names[p]);
    printf(" %9s\n", "no pass");
    for (int w = 0; w < count; w++) {
        print_times(ways[w].name, "first", &ways[w].first, 1);
        print_times(ways[w].name, "again", ways[w].again, ways[w].agains);
        print_times(ways[w].name, "sweep", ways[w].sweep, ways[w].sweeps);
    }
    for (int w = 0; w < count; w++) {
        if (!ways[w].resident)
            continue;
        const struct weft_resident_info *info = weft_resident_get_info(ways[w].resident);
        printf("%s: %llu blocks of %llu bytes laid out, %llu reused, %llu gave way\n", ways[w].name,
               (unsigned long long)info->laid_out, (unsigned long long)info->block_bytes,
               (unsigned long long)info->reused, (unsigned long long)info->evicted);
    }
}

// Ways of one engine have the same pixels; and nothing is laid out twice.
static int count_failures(const struct job *job, const struct way *ways, int count)
{
    int failures = 0;
    const size_t bytes = (size_t)job->side * (size_t)job->side * sizeof(float);
    for (int w = 0; w < count; w++) {
        failures += w % 2 && memcmp(ways[w].pixels, ways[w - 1].pixels, bytes) != 0;
        const struct weft_resident_info *info =
            ways[w].resident ? weft_resident_get_info(ways[w].resident) : NULL;
        failures += info && (info->laid_out != info->blocks || info->reused == 0);
    }
    return failures;
}

static enum weft_result make_job(int size, int side, struct job *job)
{
    const size_t n = (size_t)size;
    const struct weft_signal_info *signal = weft_signal_find("marschner-lobb");
    float *data = malloc(n * n * n * sizeof *data);
    *job = (struct job){.size = size, .side = side};
    if (!data)
        return WEFT_ERR_MEMORY;
    for (size_t i = 0; i < n * n * n; i++) {
        double at[3] = {weft_signal_coordinate((int64_t)(i % n), size),
                        weft_signal_coordinate((int64_t)(i / n % n), size),
                        weft_signal_coordinate((int64_t)(i / n / n), size)};
        data[i] = (float)signal->value(at);
    }
    const enum weft_result res =
        weft_volume_create(weft_volume_params(.size = {size, size, size}, .background = 0.0f,
                                              .data = data, .log = &log_to_stderr),
                           &job->volume);
    free(data);
    return res;
}

static int run(enum weft_context_kind kind, int size, int side, int runs)
{
    static struct way ways[4] = {{.name = "OpenGL, alone"},
                                 {.name = "OpenGL, resident", .stays = true},
                                 {.name = "CPU, alone"},
                                 {.name = "CPU, resident", .stays = true}};
    const int count = (int)WEFT_COUNT(ways);
    struct job job;
    weft_context *context = NULL;
    int failures = 0;
    enum weft_result res = make_job(size, side, &job);
    if (res == WEFT_OK)
        res =
            weft_context_create(weft_context_params(.kind = kind, .log = &log_to_stderr), &context);
    for (int w = 0; res == WEFT_OK && w < count; w++) {
        ways[w].context = w < 2 ? context : NULL;
        ways[w].pixels = malloc((size_t)side * (size_t)side * sizeof(float));
        res = ways[w].pixels ? WEFT_OK : WEFT_ERR_MEMORY;
    }
    if (res == WEFT_OK)
        res = run_first(&job, ways, count);
    if (res == WEFT_OK)
        res = run_turns(&job, ways, count, runs, false);
    if (res == WEFT_OK)
        res = run_turns(&job, ways, count, runs > 1 ? SWEEP : 3, true);
    if (res == WEFT_OK) {
        printf("%s, CPU engine with %s\n", weft_context_get_info(context)->renderer,
               weft_instruction_set_names[weft_instruction_set_best()]);
        print_all(&job, ways, count);
        failures = count_failures(&job, ways, count);
    }
    for (int w = 0; w < count; w++) {
        weft_resident_destroy(&ways[w].resident);
        free(ways[w].pixels);
    }
    weft_context_destroy(&context);
    weft_volume_destroy(&job.volume);
    return failures + (res != WEFT_OK);
}

int main(int argc, char **argv)
{
    bool bench = false;
    int runs = 1;
    enum weft_context_kind kind = WEFT_CONTEXT_OSMESA;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--bench") == 0) {
            bench = true;
            runs = 31;
        } else if (strcmp(argv[i], "--runs") == 0 && i + 1 < argc) {
            runs = atoi(argv[++i]);
            runs = runs < 1 ? 1 : runs > MOST ? MOST : runs;
        } else if (strcmp(argv[i], "--context") == 0 && i + 1 < argc) {
            if (weft_context_kind_parse(&log_to_stderr, argv[++i], &kind) != WEFT_OK)
                return 2;
        } else {
            fprintf(stderr,
                    "usage: bench_resident [--bench] [--context auto|osmesa|egl] [--runs N]\n");
            return 2;
        }
    }
    return run(kind, bench ? 256 : 48, bench ? 1024 : 128, runs) ? 1 : 0;
}
