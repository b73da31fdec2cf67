// SPDX-License-Identifier: BSD-3-Clause
// The slice engine beside plain C: a 1024 x 1024 oblique Catmull-Rom slice of a dense 256^3 volume,
// data resident. Without --bench it runs a small case once and checks that all methods agree.
// Usage: bench_slice [--bench] [--context osmesa|egl] [--runs N]
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "weft.h"

typedef float v4 __attribute__((vector_size(16)));
typedef float v4_unaligned __attribute__((vector_size(16), aligned(4)));

enum { THREADS = 2, MAX_RUNS = 99 };

struct job {
    int size; // voxels along each axis
    int side; // pixels
    float *data;
    double origin[3], u[3], v[3];
};

// ---- the baseline: one 4-wide vector per row of taps, rows split over two threads ---------------

struct worker {
    const struct job *job;
    float *pixels;
    int first_row;
};

static v4 catmull_rom(float t)
{
    const v4 c0 = {0, 1, 0, 0}, c1 = {-0.5f, 0, 0.5f, 0}, c2 = {1, -2.5f, 2, -0.5f},
             c3 = {-0.5f, 1.5f, -1.5f, 0.5f};
    return ((c3 * t + c2) * t + c1) * t + c0;
}

static float baseline_pixel(const struct job *job, const double position[3])
{
    int first[3];
    v4 w[3], sum = {0};
    for (int a = 0; a < 3; a++) {
        int whole = (int)position[a]; // all positions are inside, hence positive
        first[a] = whole - 1;
        w[a] = catmull_rom((float)(position[a] - whole));
    }
    size_t pitch = (size_t)job->size;
    const float *at = job->data + ((size_t)first[2] * pitch + (size_t)first[1]) * pitch + first[0];
    for (int z = 0; z < 4; z++) {
        v4 plane = {0};
        for (int y = 0; y < 4; y++)
            plane +=
                w[1][y] * *(const v4_unaligned *)(at + ((size_t)z * pitch + (size_t)y) * pitch);
        sum += w[2][z] * plane;
    }
    sum *= w[0];
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

static void *baseline_rows(void *priv)
{
    const struct worker *worker = priv;
    const struct job *job = worker->job;
    for (int y = worker->first_row; y < job->side; y += THREADS) {
        for (int x = 0; x < job->side; x++) {
            double position[3];
            for (int a = 0; a < 3; a++)
                position[a] = job->origin[a] + (x + 0.5) / job->side * job->u[a] +
                              (y + 0.5) / job->side * job->v[a];
            worker->pixels[(size_t)y * (size_t)job->side + (size_t)x] =
                baseline_pixel(job, position);
        }
    }
    return NULL;
}

static double run_baseline(const struct job *job, float *pixels)
{
    pthread_t thread[THREADS];
    struct worker worker[THREADS];
    double start = weft_now_seconds();
    for (int i = 0; i < THREADS; i++) {
        worker[i] = (struct worker){job, pixels, i};
        if (pthread_create(&thread[i], NULL, baseline_rows, &worker[i]) != 0)
            abort();
    }
    for (int i = 0; i < THREADS; i++)
        pthread_join(thread[i], NULL);
    return weft_now_seconds() - start;
}

// ---- runs ---------------------------------------------------------------------------------------

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, int count)
{
    qsort(values, (size_t)count, sizeof *values, by_value);
    return values[count / 2];
}

static void print_log(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    if (level <= WEFT_LOG_WARNING)
        fprintf(stderr, "bench_slice: %s\n", message);
}

static const struct weft_log log_to_stderr = {print_log, NULL};

static bool make_job(int size, int side, struct job *job)
{
    *job = (struct job){.size = size, .side = side};
    size_t n = (size_t)size;
    job->data = malloc(n * n * n * sizeof *job->data);
    if (!job->data)
        return false;
    const struct weft_signal_info *signal = weft_signal_find("marschner-lobb");
    for (size_t i = 0; i < n * n * n; i++) {
        double at[3] = {weft_signal_coordinate((int64_t)(i % n), size),
                        weft_signal_coordinate((int64_t)(i / n % n), size),
                        weft_signal_coordinate((int64_t)(i / n / n), size)};
        job->data[i] = (float)signal->value(at);
    }
    // A plane through the middle, tilted against all axes, as large as fits inside.
    const double u[3] = {0.62, 0.28, 0.12}, v[3] = {-0.25, 0.55, 0.30};
    for (int a = 0; a < 3; a++) {
        job->u[a] = u[a] * size;
        job->v[a] = v[a] * size;
        job->origin[a] = 0.5 * size - 0.5 * (job->u[a] + job->v[a]);
    }
    return true;
}

// One layout's plan, and what its runs took. Runs of all methods take turns, so that what slows the
// machine down for a while slows all of them, and ratios are taken turn by turn.
struct method {
    weft_slice_plan *plan;
    double seconds[MAX_RUNS], whole_seconds[MAX_RUNS], ratio[MAX_RUNS];
    struct weft_slice_report report;
    struct weft_verify_report error;
};

static enum weft_result make_plan(const struct job *job, weft_volume *volume,
                                  enum weft_layout layout, weft_slice_plan **plan)
{
    struct weft_slice_params params = {
        .space = WEFT_SPACE_INDEX,
        .layout = layout,
        .geometry = {.width = job->side, .height = job->side},
        .log = &log_to_stderr,
    };
    memcpy(params.geometry.origin, job->origin, sizeof job->origin);
    memcpy(params.geometry.u, job->u, sizeof job->u);
    memcpy(params.geometry.v, job->v, sizeof job->v);
    return weft_slice_plan_create(volume, &params, plan);
}

static enum weft_result run_method(struct method *method, weft_context *context, float *pixels,
                                   int turn, double baseline)
{
    double start = weft_now_seconds();
    enum weft_result res =
        weft_slice_run_once(method->plan, weft_slice_compile_params(.context = context),
                            weft_slice_run_params(.pixels = pixels), &method->report);
    if (res == WEFT_OK && turn >= 0) {
        method->seconds[turn] = method->report.pass_seconds;
        method->whole_seconds[turn] = weft_now_seconds() - start;
        method->ratio[turn] = baseline / method->report.pass_seconds;
    }
    return res;
}

static double largest_difference(const float *a, const float *b, size_t count)
{
    double largest = 0.0;
    for (size_t i = 0; i < count; i++) {
        double d = a[i] > b[i] ? (double)a[i] - b[i] : (double)b[i] - a[i];
        largest = d > largest ? d : largest;
    }
    return largest;
}

enum { FIRST = WEFT_LAYOUT_INTERLEAVED, LAST = WEFT_LAYOUT_PLAIN };

// All turns of all methods; the one before the first warms up. `failures` counts wrong results.
static enum weft_result take_turns(const struct job *job, weft_context *context,
                                   weft_volume *volume, struct method *methods, double *baseline,
                                   int runs, int *failures)
{
    size_t count = (size_t)job->side * (size_t)job->side;
    float *pixels = malloc(count * sizeof *pixels), *expected = malloc(count * sizeof *expected);
    enum weft_result res = pixels && expected ? WEFT_OK : WEFT_ERR_MEMORY;
    for (int l = FIRST; res == WEFT_OK && l <= LAST; l++)
        res = make_plan(job, volume, (enum weft_layout)l, &methods[l].plan);
    for (int turn = -1; res == WEFT_OK && turn < runs; turn++) {
        double seconds = run_baseline(job, expected);
        if (turn >= 0)
            baseline[turn] = seconds;
        for (int l = FIRST; res == WEFT_OK && l <= LAST; l++) {
            res = run_method(&methods[l], context, pixels, turn, seconds);
            // Both round in single precision.
            if (turn < 0 && res == WEFT_OK) {
                *failures += !(largest_difference(pixels, expected, count) <= 1e-5);
                res = weft_slice_verify(methods[l].plan, pixels,
                                        &(struct weft_slice_verify_params){.max_seconds = 2.0},
                                        &methods[l].error);
                *failures += !(methods[l].error.relative_maximum <= 2e-6);
            }
        }
    }
    free(pixels);
    free(expected);
    return res;
}

static void print_methods(const struct job *job, const weft_context *context,
                          struct method *methods, double *baseline, int runs)
{
    const struct weft_context_info *info = weft_context_get_info(context);
    double megapixels = 1e-6 * job->side * job->side, megabytes = 4e-6 * pow(job->size, 3);
    double seconds = median(baseline, runs);
    printf("%s, %s, %s; %d^3 voxels, %d x %d pixels, medians of %d turns\n", info->platform,
           info->renderer, info->version, job->size, job->side, job->side, runs);
    printf("%-24s %10s %8s %10s %10s %10s\n", "method", "Mpixel/s", "ratio", "whole ms", "MB",
           "max error");
    printf("%-24s %10.1f %8.2f %10.1f %10.1f\n", "plain C, 2 threads", megapixels / seconds, 1.0,
           1e3 * seconds, megabytes);
    for (int l = FIRST; l <= LAST; l++)
        printf("%-24s %10.1f %8.2f %10.1f %10.1f %10.2e\n", weft_layout_name((enum weft_layout)l),
               megapixels / median(methods[l].seconds, runs), median(methods[l].ratio, runs),
               1e3 * median(methods[l].whole_seconds, runs),
               1e-6 * (double)methods[l].report.peak_bytes, methods[l].error.relative_maximum);
}

static int run(enum weft_context_kind kind, int size, int side, int runs)
{
    static struct method methods[LAST + 1];
    static double baseline[MAX_RUNS];
    struct job job;
    weft_context *context = NULL;
    weft_volume *volume = NULL;
    int failures = 0;
    enum weft_result res = make_job(size, side, &job) ? WEFT_OK : WEFT_ERR_MEMORY;
    if (res == WEFT_OK)
        res = weft_context_create(
            &(struct weft_context_params){.kind = kind, .log = &log_to_stderr}, &context);
    if (res == WEFT_OK)
        res = weft_volume_create(&(struct weft_volume_params){.size = {size, size, size},
                                                              .background = 0.0f,
                                                              .data = job.data,
                                                              .log = &log_to_stderr},
                                 &volume);
    if (res == WEFT_OK)
        res = take_turns(&job, context, volume, methods, baseline, runs, &failures);
    if (res == WEFT_OK)
        print_methods(&job, context, methods, baseline, runs);
    for (int l = FIRST; l <= LAST; l++)
        weft_slice_plan_destroy(&methods[l].plan);
    weft_volume_destroy(&volume);
    weft_context_destroy(&context);
    free(job.data);
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
            runs = runs < 1 ? 1 : runs > MAX_RUNS ? MAX_RUNS : runs;
        } else if (strcmp(argv[i], "--context") == 0 && i + 1 < argc) {
            if (weft_context_kind_parse(&log_to_stderr, argv[++i], &kind) != WEFT_OK)
                return 2;
        } else {
            fprintf(stderr,
                    "usage: bench_slice [--bench] [--context auto|osmesa|egl] [--runs N]\n");
            return 2;
        }
    }
    return run(kind, bench ? 256 : 48, bench ? 1024 : 128, runs) ? 1 : 0;
}
