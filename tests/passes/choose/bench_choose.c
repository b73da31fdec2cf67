// SPDX-License-Identifier: BSD-3-Clause
// Random slices and error budgets: is what weft_choose takes within the budget, and how much slower
// than the fastest of all methods that are? A method is within when its largest error, measured
// against the double reference, is; methods are timed in turns, as whole runs. Usage: bench_choose
// [--bench] [--context osmesa|egl] [--jobs N] [--runs N] Without --bench a few small jobs are run
// once each, and only errors can fail.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/slice_jobs.h"

enum { MAX_RUNS = 15, MAX_WAYS = 96 };

static void print_log(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    if (level == WEFT_LOG_ERROR)
        fprintf(stderr, "bench_choose: error: %s\n", message);
}

static const struct weft_log log_to_stderr = {print_log, NULL};

struct bench {
    weft_context *context;
    struct weft_cost_model model;
    int jobs, runs, magnification;
};

// A method that is run: planned as it would be, were it chosen.
struct contender {
    const struct weft_candidate *candidate;
    weft_method_plan *plan;
    bool chosen, within;
    double seconds[MAX_RUNS];
};

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(const double *values, int count)
{
    double sorted[MAX_RUNS];
    memcpy(sorted, values, (size_t)count * sizeof *values);
    qsort(sorted, (size_t)count, sizeof *sorted, compare);
    return sorted[count / 2];
}

// Passes are looked at where they could be as fast: planning all of them takes hours.
static bool is_worth_a_run(const struct weft_choice *choice, const struct weft_candidate *c)
{
    const double chosen = choice->candidates[choice->chosen].seconds;
    return c->state == WEFT_CANDIDATE_CHOSEN ||
           (c->state != WEFT_CANDIDATE_REFUSED &&
            (c->method.algorithm != WEFT_ALGORITHM_MULTIPASS || c->seconds < 1.5 * chosen));
}

static int plan_contenders(const struct job *job, double budget, const struct weft_choice *choice,
                           struct contender *out)
{
    int count = 0;
    for (size_t i = 0; i < choice->count && count < MAX_WAYS; i++) {
        const struct weft_candidate *c = &choice->candidates[i];
        struct weft_method_params params = job->params;
        struct contender *contender = &out[count];
        if (!is_worth_a_run(choice, c))
            continue;
        *contender =
            (struct contender){.candidate = c, .chosen = c->state == WEFT_CANDIDATE_CHOSEN};
        params.method = c->method;
        if (c->method.algorithm == WEFT_ALGORITHM_FUSED && c->bound < budget)
            params.slice.smooth_error = 0.999 * (budget - c->bound);
        if (weft_method_plan_create(job->volume, &params, &contender->plan) == WEFT_OK)
            count++;
    }
    return count;
}

static enum weft_result time_contenders(const struct bench *b, double budget,
                                        struct contender *contenders, int count, float *pixels)
{
    enum weft_result res = WEFT_OK;
    for (int run = -1; res == WEFT_OK && run < b->runs; run++) {
        for (int i = 0; res == WEFT_OK && i < count; i++) {
            struct contender *c = &contenders[i];
            struct weft_method_report report;
            if (run >= 0 && !c->within)
                continue;
            res = weft_method_run(
                c->plan, weft_method_run_params(.context = b->context, .pixels = pixels), &report);
            if (run >= 0)
                c->seconds[run] = report.seconds;
            if (run >= 0 || res != WEFT_OK)
                continue;
            struct weft_verify_report error;
            res = weft_slice_verify(weft_method_plan_get_slice(c->plan), pixels,
                                    &(struct weft_slice_verify_params){.max_seconds = 0.1}, &error);
            // The first run warms up, and tells which methods are to be timed.
            c->within = error.maximum <= budget;
        }
    }
    return res;
}

struct tally {
    int jobs, none, over, good, good_by_bound;
    double worst;
    double ratios[4096];
};

static void judge(const struct bench *b, const struct contender *contenders, int count,
                  double budget, struct tally *t)
{
    double chosen = 0.0, fastest = INFINITY, by_bound = INFINITY;
    const struct contender *winner = NULL, *best = NULL;
    for (int i = 0; i < count; i++) {
        const struct contender *c = &contenders[i];
        const double seconds = c->within ? median(c->seconds, b->runs) : INFINITY;
        if (c->chosen) {
            winner = c;
            chosen = seconds;
            t->over += !c->within;
        }
        if (seconds < fastest) {
            fastest = seconds;
            best = c;
        }
        if (c->candidate->bound <= budget)
            by_bound = fmin(by_bound, seconds);
    }
    if (!winner || !best)
        return;
    const double ratio = chosen / fastest;
    t->ratios[t->jobs++] = ratio;
    t->good += ratio <= 1.5;
    t->good_by_bound += chosen / by_bound <= 1.5;
    t->worst = fmax(t->worst, ratio);
    if (ratio > 1.5)
        printf("%6.2f  %-40s %8.2f ms, %-40s %8.2f ms\n", ratio, winner->candidate->name,
               1e3 * chosen, best->candidate->name, 1e3 * fastest);
}

static enum weft_result run_job(const struct bench *b, struct random *r, struct tally *t)
{
    static struct contender contenders[MAX_WAYS];
    struct job job;
    struct weft_choice choice;
    set_job(r, b->magnification, &job);
    const double budget = random_budget(r, &job.params.statistics);
    const struct weft_choose_params params = {
        .slice = job.params.slice, .max_error = budget, .model = &b->model};
    const struct weft_slice_geometry *g = &job.params.slice.geometry;
    float *pixels = malloc((size_t)g->width * (size_t)g->height * sizeof *pixels);
    job_must(pixels, "memory");
    int count = 0;
    enum weft_result res = weft_choose(job.volume, &params, &choice);
    if (res == WEFT_OK && choice.chosen < 0)
        t->none++;
    if (res == WEFT_OK && choice.chosen >= 0) {
        count = plan_contenders(&job, budget, &choice, contenders);
        res = time_contenders(b, budget, contenders, count, pixels);
        if (res == WEFT_OK)
            judge(b, contenders, count, budget, t);
    }
    for (int i = 0; i < count; i++)
        weft_method_plan_destroy(&contenders[i].plan);
    weft_choice_clear(&choice);
    weft_volume_destroy(&job.volume);
    free(pixels);
    return res;
}

static int run(struct bench *b, bool calibrate)
{
    static struct tally t;
    struct random r = {7};
    b->model = weft_cost_default;
    enum weft_result res =
        calibrate ? weft_cost_calibrate(&log_to_stderr, b->context, NULL, &b->model) : WEFT_OK;
    const struct weft_context_info *info = weft_context_get_info(b->context);
    printf("%s, %s; %d jobs, medians of %d turns; those more than 1.5 times slower than the "
           "fastest within the budget:\n",
           info->platform, info->renderer, b->jobs, b->runs);
    for (int i = 0; res == WEFT_OK && i < b->jobs; i++)
        res = run_job(b, &r, &t);
    if (res != WEFT_OK)
        return 1;
    qsort(t.ratios, (size_t)t.jobs, sizeof *t.ratios, compare);
    printf("%d jobs: %d budgets that no bound meets, %d over their budget; time by that of the "
           "fastest method within: median %.2f, 90 %% %.2f, worst %.2f; within 1.5: %d of %d (%.1f "
           "%%), of methods whose bound is within: %d (%.1f %%)\n",
           b->jobs, t.none, t.over, t.ratios[t.jobs / 2], t.ratios[t.jobs * 9 / 10], t.worst,
           t.good, t.jobs, 100.0 * t.good / t.jobs, t.good_by_bound,
           100.0 * t.good_by_bound / t.jobs);
    return t.over > 0;
}

int main(int argc, char **argv)
{
    struct bench b = {.jobs = 5, .runs = 1, .magnification = 1};
    enum weft_context_kind kind = WEFT_CONTEXT_OSMESA;
    bool bench = false;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--bench") == 0) {
            bench = true;
            b.jobs = 200;
            b.runs = 5;
            b.magnification = 6;
        } else if (strcmp(argv[i], "--jobs") == 0 && i + 1 < argc) {
            b.jobs = atoi(argv[++i]);
        } else if (strcmp(argv[i], "--runs") == 0 && i + 1 < argc) {
            b.runs = atoi(argv[++i]);
        } else if (strcmp(argv[i], "--context") == 0 && i + 1 < argc &&
                   weft_context_kind_parse(&log_to_stderr, argv[i + 1], &kind) == WEFT_OK) {
            i++;
        } else {
            fprintf(stderr, "usage: bench_choose [--bench] [--context osmesa|egl] [--jobs N] "
                            "[--runs N]\n");
            return 2;
        }
    }
    if (b.jobs < 1 || b.jobs > 4096 || b.runs < 1 || b.runs > MAX_RUNS) {
        fprintf(stderr, "bench_choose: jobs must be 1 to 4096, runs 1 to %d\n", MAX_RUNS);
        return 2;
    }
    if (weft_context_create(&(struct weft_context_params){.kind = kind, .log = &log_to_stderr},
                            &b.context) != WEFT_OK)
        return 77; // skipped
    const int status = run(&b, bench);
    weft_context_destroy(&b.context);
    return status;
}
