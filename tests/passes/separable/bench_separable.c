// SPDX-License-Identifier: BSD-3-Clause
// Separable filtering of a plane on OpenGL and on the CPU engine, with every set of instructions
// and both kinds of sums: ways in turns, medians, and the largest difference from double precision.
// Without --bench it runs small planes once, and checks that all ways are within their bounds.
// Usage: bench_separable [--bench] [--context osmesa|egl] [--runs N] [--threads N]
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "weft.h"

enum { MAX_RUNS = 99, MAX_WAYS = 12 };

struct job {
    const char *kernel;
    int size[2], width, height;
};

static const struct job jobs[] = {
    {"catmull-rom", {1240, 846}, 4096, 4096}, {"catmull-rom", {1240, 846}, 310, 212},
    {"catmull-rom", {256, 256}, 1024, 1024},  {"lanczos:3", {1240, 846}, 2480, 1692},
    {"lanczos:8", {1240, 846}, 1240, 846},
};
static const struct job small_jobs[] = {{"catmull-rom", {60, 50}, 200, 170},
                                        {"lanczos:3", {160, 150}, 40, 30}};

struct way {
    char name[64];
    enum weft_engine engine;
    enum weft_sums sums;
    struct weft_separable_compile_params compile;
    weft_separable_plan *plan;
    weft_separable *compiled;
    double seconds[MAX_RUNS];
    struct weft_verify_report error;
};

static void print_log(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    if (level <= WEFT_LOG_WARNING)
        fprintf(stderr, "bench_separable: %s\n", message);
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

// ---- ways ---------------------------------------------------------------------------------------

static int add_cpu(struct way *way, enum weft_instruction_set set, enum weft_sums sums, int threads)
{
    *way = (struct way){.engine = WEFT_ENGINE_CPU,
                        .sums = sums,
                        .compile = {.cpu = {.threads = threads, .instructions = set}}};
    snprintf(way->name, sizeof way->name, "cpu, %s, %s sums, %d threads",
             weft_instruction_set_names[set], weft_sums_names[sums], threads);
    return 1;
}

static int find_ways(weft_context *context, int threads, struct way *ways)
{
    const enum weft_instruction_set best = weft_instruction_set_best();
    int count = 0;
    if (context) {
        ways[count] = (struct way){.compile = {.context = context}};
        snprintf(ways[count].name, sizeof ways->name, "gl, %s",
                 weft_context_get_info(context)->renderer);
        count++;
    }
    for (int set = WEFT_INSTRUCTIONS_PLAIN; weft_instruction_set_names[set]; set++)
        if (weft_instruction_set_runs((enum weft_instruction_set)set))
            count +=
                add_cpu(&ways[count], (enum weft_instruction_set)set, WEFT_SUMS_FLOAT, threads);
    count += add_cpu(&ways[count], best, WEFT_SUMS_DOUBLE, threads);
    if (threads > 1)
        count += add_cpu(&ways[count], best, WEFT_SUMS_FLOAT, 1);
    return count;
}

// ---- one job ------------------------------------------------------------------------------------

struct planes {
    float *samples, *pixels;
    double *at[2];
};

static void free_planes(struct planes *p)
{
    free(p->samples);
    free(p->pixels);
    free(p->at[0]);
    free(p->at[1]);
}

static bool make_planes(const struct job *job, struct planes *p)
{
    const size_t samples = (size_t)job->size[0] * (size_t)job->size[1];
    const int count[2] = {job->width, job->height};
    p->samples = malloc(samples * sizeof *p->samples);
    p->pixels = malloc((size_t)job->width * (size_t)job->height * sizeof *p->pixels);
    for (int a = 0; a < 2; a++)
        p->at[a] = malloc((size_t)count[a] * sizeof *p->at[a]);
    if (!p->samples || !p->pixels || !p->at[0] || !p->at[1])
        return false;
    for (size_t i = 0; i < samples; i++)
        p->samples[i] = (float)((i * 2654435761u >> 8 & 0xffff) / 65536.0);
    for (int a = 0; a < 2; a++)
        for (int i = 0; i < count[a]; i++)
            p->at[a][i] = (i + 0.5) * job->size[a] / count[a] - 0.5;
    return true;
}

static bool compile_way(const struct job *job, const struct planes *p, struct way *way)
{
    struct weft_separable_params params = {.size = {job->size[0], job->size[1]},
                                           .width = job->width,
                                           .height = job->height,
                                           .x = p->at[0],
                                           .y = p->at[1],
                                           .engine = way->engine,
                                           .sums = way->sums,
                                           .log = &log_to_stderr};
    return weft_kernel_parse(&log_to_stderr, job->kernel, &params.kernel) == WEFT_OK &&
           weft_separable_plan_create(&params, &way->plan) == WEFT_OK &&
           weft_separable_compile(way->plan, &way->compile, &way->compiled) == WEFT_OK;
}

static bool run_way(const struct planes *p, struct way *way, int run)
{
    const struct weft_separable_run_params params = {
        .samples = p->samples, .pixels = p->pixels, .log = &log_to_stderr};
    const double start = weft_now_seconds();
    if (weft_separable_run(way->compiled, &params, NULL) != WEFT_OK)
        return false;
    if (run >= 0) {
        way->seconds[run] = weft_now_seconds() - start;
        return true;
    }
    const struct weft_verify_params how = {.max_seconds = 0.5};
    return weft_separable_verify(way->plan, &params, &how, &way->error) == WEFT_OK &&
           !way->error.not_finite_mismatches &&
           way->error.relative_maximum <=
               weft_separable_error_bound(&weft_separable_plan_get_info(way->plan)->kernel,
                                          way->sums);
}

static void print_job(const struct job *job, struct way *ways, int count, int runs)
{
    printf("%d x %d samples to %d x %d pixels, %s:\n", job->size[0], job->size[1], job->width,
           job->height, job->kernel);
    for (int w = 0; w < count; w++) {
        const double seconds = median(ways[w].seconds, runs);
        printf("  %-64s %8.2f ms %8.0f Mpixel/s   error %.2g\n", ways[w].name, seconds * 1e3,
               1e-6 * job->width * job->height / seconds, ways[w].error.relative_maximum);
    }
}

// Every way is run and checked first, and then in turns.
static bool run_job(const struct job *job, struct way *ways, int count, int runs)
{
    struct planes p = {0};
    bool ok = make_planes(job, &p);
    for (int w = 0; ok && w < count; w++)
        ok = compile_way(job, &p, &ways[w]) && run_way(&p, &ways[w], -1);
    for (int i = 0; ok && i < runs; i++)
        for (int w = 0; ok && w < count; w++)
            ok = run_way(&p, &ways[w], i);
    if (ok && runs > 0)
        print_job(job, ways, count, runs);
    for (int w = 0; w < count; w++) {
        weft_separable_destroy(&ways[w].compiled);
        weft_separable_plan_destroy(&ways[w].plan);
    }
    free_planes(&p);
    if (!ok)
        fprintf(stderr, "bench_separable: %s to %d x %d failed, or is beyond its bound\n",
                job->kernel, job->width, job->height);
    return ok;
}

int main(int argc, char **argv)
{
    bool bench = false, ok = true;
    int runs = 9, threads = weft_cpu_threads();
    struct weft_context_params context_params = {.kind = WEFT_CONTEXT_AUTO};
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--bench") == 0)
            bench = true;
        else if (i + 1 < argc && strcmp(argv[i], "--runs") == 0)
            runs = atoi(argv[++i]);
        else if (i + 1 < argc && strcmp(argv[i], "--threads") == 0)
            threads = atoi(argv[++i]);
        else if (i + 1 < argc && strcmp(argv[i], "--context") == 0)
            ok =
                weft_context_kind_parse(&log_to_stderr, argv[++i], &context_params.kind) == WEFT_OK;
        else
            ok = false;
    }
    if (!ok || runs < 1 || runs > MAX_RUNS || threads < 1) {
        fprintf(stderr, "usage: bench_separable [--bench] [--context osmesa|egl] [--runs N] "
                        "[--threads N]\n");
        return 2;
    }
    struct way ways[MAX_WAYS];
    weft_context *context = NULL;
    weft_context_create(&context_params, &context); // or there is the CPU alone
    const int count = find_ways(context, threads, ways);
    const struct job *list = bench ? jobs : small_jobs;
    const size_t job_count = bench ? WEFT_COUNT(jobs) : WEFT_COUNT(small_jobs);
    for (size_t i = 0; ok && i < job_count; i++)
        ok = run_job(&list[i], ways, count, bench ? runs : 0);
    weft_context_destroy(&context);
    return ok ? 0 : 1;
}
