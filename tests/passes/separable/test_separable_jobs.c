// SPDX-License-Identifier: BSD-3-Clause
// Random jobs of separable filtering on OpenGL and on the CPU engine with every set of instructions
// and both kinds of sums: within their bounds of double precision, and so of each other; the same
// bytes for any number of threads and any memory, and in parts. WEFT_SEPARABLE_JOBS: how many
// (default 60).
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/passes/separable/wheres.h"
#include "tests/support/common.h"

enum { MOST_SAMPLES = 120, MOST_PIXELS = 150, GAP = 9, JOBS = 60 };

static const char *const kernels[] = {"nearest",   "linear",    "bspline2",        "catmull-rom",
                                      "lagrange5", "bspline5",  "lanczos:3",       "bspline7",
                                      "lanczos:4", "lanczos:8", "gaussian:2,0.05", "d-linear",
                                      "keys6",     "mitchell",  "lanczos:5+unit",  "dd-bspline5"};

struct random {
    uint64_t state;
};

static double uniform(struct random *r) // splitmix64, in [0, 1)
{
    uint64_t h = r->state += UINT64_C(0x9e3779b97f4a7c15);
    h = (h ^ h >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    h = (h ^ h >> 27) * UINT64_C(0x94d049bb133111eb);
    return (double)((h ^ h >> 31) >> 11) * 0x1p-53;
}

static int below(struct random *r, int n)
{
    return (int)(uniform(r) * n);
}

struct job {
    struct weft_separable_params params;
    struct weft_separable_run_params run;
    float samples[MOST_SAMPLES * MOST_SAMPLES];
    double at[2][MOST_PIXELS];
    float largest; // finite |sample|
};

// Rising or falling evenly, in any order near the samples, or anywhere; whole at times.
static void set_positions(struct random *r, int samples, int count, double *at)
{
    const int kind = below(r, 5);
    const double from = samples * (uniform(r) * 2.0 - 0.5), step = samples * uniform(r) / count;
    for (int i = 0; i < count; i++) {
        at[i] =
            kind < 3 ? from + (kind == 1 ? -step : step) * i : samples * (1.4 * uniform(r) - 0.2);
        if (kind == 2)
            at[i] = (i + 0.5) * samples / count - 0.5;
        if (kind == 4 && i % 7 == 0)
            at[i] = (uniform(r) - 0.5) * exp2(60.0 * uniform(r));
        if (kind == 4 && i % 5 == 0)
            at[i] = rint(at[i]);
    }
}

static void set_samples(struct random *r, int count, struct job *job)
{
    static const float special[] = {NAN,   INFINITY, -INFINITY, 0.0f,
                                    -0.0f, FLT_MAX,  -FLT_MAX,  1e-40f};
    const double scale = below(r, 4) ? 1.0 : exp2(240.0 * uniform(r) - 120.0);
    const int specials = below(r, 3) ? 0 : 1 + below(r, 6), from = below(r, 2) ? 0 : 3;
    for (int i = 0; i < count; i++)
        job->samples[i] = (float)(scale * (2.0 * uniform(r) - 1.0));
    for (int i = 0; i < specials; i++)
        job->samples[below(r, count)] = special[from + below(r, 8 - from)];
    for (int i = 0; i < count; i++)
        if (isfinite(job->samples[i]))
            job->largest = fmaxf(job->largest, fabsf(job->samples[i]));
}

static struct job *make_job(struct random *r, int number)
{
    struct job *job = calloc(1, sizeof *job);
    assert_non_null(job);
    int samples[2], pixels[2];
    for (int a = 0; a < 2; a++) {
        samples[a] = 1 + below(r, below(r, 3) ? MOST_SAMPLES : 9);
        pixels[a] = 1 + below(r, below(r, 3) ? MOST_PIXELS : 20);
        set_positions(r, samples[a], pixels[a], job->at[a]);
    }
    set_samples(r, samples[0] * samples[1], job);
    job->params = (struct weft_separable_params){
        .kernel = kernel_named(kernels[number % (int)WEFT_COUNT(kernels)]),
        .size = {samples[0], samples[1]},
        .width = pixels[0],
        .height = pixels[1],
        .x = job->at[0],
        .y = job->at[1],
        .log = &log_to_stderr};
    job->run = (struct weft_separable_run_params){
        .samples = job->samples, .stride = pixels[0] + GAP, .log = &log_to_stderr};
    return job;
}

static double bound_of(const struct job *job, enum weft_sums sums)
{
    const struct weft_bound_terms terms =
        weft_separable_bound_terms(&job->params.kernel, sums, (double)job->largest, 1.0);
    const double largest = (double)job->largest;
    return weft_bound_compute(&terms, &(struct weft_bound_values){.low = -largest,
                                                                  .high = largest,
                                                                  .sample_low = -largest,
                                                                  .sample_high = largest})
        .total;
}

// Plans, compiles and runs; pixels between rows stay. Compares with double precision where asked.
static void run(const struct where *where, struct job *job, int threads, uint64_t memory,
                bool verifies, float *pixels)
{
    struct weft_separable_compile_params compile = where->compile;
    struct weft_separable_report report;
    struct weft_verify_report error;
    weft_separable_plan *plan = NULL;
    weft_separable *compiled = NULL;
    const size_t stride = (size_t)job->run.stride, width = (size_t)job->params.width;
    const size_t count = stride * (size_t)job->params.height;
    job->params.engine = where->engine;
    job->params.sums = where->sums;
    job->params.memory_bytes = memory;
    job->run.pixels = pixels;
    compile.cpu.threads = threads;
    for (size_t i = 0; i < count; i++)
        pixels[i] = 4711.0f;
    assert_int_equal(weft_separable_plan_create(&job->params, &plan), WEFT_OK);
    assert_int_equal(weft_separable_compile(plan, &compile, &compiled), WEFT_OK);
    assert_int_equal(weft_separable_run(compiled, &job->run, &report), WEFT_OK);
    assert_true(report.peak_bytes <= (memory ? memory : UINT64_C(1) << 30));
    assert_int_equal(report.pixels.count, width * (size_t)job->params.height);
    for (size_t i = 0; i < count; i++)
        assert_true(i % stride < width || pixels[i] == 4711.0f);
    if (verifies) {
        assert_int_equal(weft_separable_verify(plan, &job->run, NULL, &error), WEFT_OK);
        if (!(error.maximum <= bound_of(job, where->sums)) || error.not_finite_mismatches)
            fail_msg("%s: error %.3g of %.3g at (%d, %d), %d not finite", where->name,
                     error.maximum, bound_of(job, where->sums), error.at_x, error.at_y,
                     (int)error.not_finite_mismatches);
    }
    weft_separable_destroy(&compiled);
    weft_separable_plan_destroy(&plan);
}

// Both within their bounds of the same value, and as finite, but where results overflow.
static void assert_agree(const struct job *job, const struct where *a, const float *x,
                         const struct where *b, const float *y)
{
    const double bound = bound_of(job, a->sums) + bound_of(job, b->sums);
    for (int i = 0; i < job->run.stride * job->params.height; i++) {
        const double p = (double)x[i], q = (double)y[i];
        if (isfinite(x[i]) && isfinite(y[i])
                ? !(fabs(p - q) <= bound)
                : isnan(x[i]) != isnan(y[i]) && fmin(fabs(p), fabs(q)) < FLT_MAX / 2.0)
            fail_msg("pixel %d is %.9g by %s and %.9g by %s, farther than %.3g", i, p, a->name, q,
                     b->name, bound);
    }
}

static void random_jobs_agree(void **state)
{
    static const int threads[] = {2, 3, 7};
    static const uint64_t memory[] = {0, 1 << 20, 1 << 17, 1 << 15};
    static float first[MOST_PIXELS * (MOST_PIXELS + GAP)],
        pixels[MOST_PIXELS * (MOST_PIXELS + GAP)], again[MOST_PIXELS * (MOST_PIXELS + GAP)];
    const char *asked = getenv("WEFT_SEPARABLE_JOBS");
    const int jobs = asked ? atoi(asked) : JOBS;
    struct random r = {13};
    int ran = 0;
    (void)state;
    for (int i = 0; i < jobs; i++) {
        struct job *job = make_job(&r, i);
        const size_t bytes = (size_t)job->run.stride * (size_t)job->params.height * sizeof *first;
        for (int w = 0; w < where_count; w++) {
            const struct where *where = &wheres[w];
            // The reference takes longest: each way in turn, and what is left is near those.
            run(where, job, 1, 0, w == i % where_count, w ? pixels : first);
            if (w)
                assert_agree(job, &wheres[0], first, where, pixels);
            run(where, job, threads[(i + w) % 3], memory[(i + w / 2) % 4], false, again);
            if (where->engine == WEFT_ENGINE_CPU)
                assert_memory_equal(again, w ? pixels : first, bytes);
            ran++;
        }
        free(job);
    }
    assert_int_equal(ran, jobs * where_count);
}

// ---- parts --------------------------------------------------------------------------------------

// A part from any pixel on, of one pixel, a few, whole rows, or any size.
static struct weft_rectangle make_part(struct random *r, int width, int height)
{
    static const int sides[] = {1, 7, 64, MOST_PIXELS};
    const int most[2] = {sides[below(r, 4)], sides[below(r, 4)]};
    struct weft_rectangle part = {.x = below(r, width), .y = below(r, height)};
    if (most[0] == MOST_PIXELS)
        part.x = 0;
    part.width = most[0] < width - part.x ? most[0] : width - part.x;
    part.height = most[1] < height - part.y ? most[1] : height - part.y;
    return part;
}

// The samples of a window, and no more.
static float *cut_window(const struct job *job, const struct weft_rectangle *window)
{
    float *out = malloc((size_t)window->width * (size_t)window->height * sizeof *out);
    assert_non_null(out);
    for (int y = 0; y < window->height; y++)
        memcpy(out + y * window->width,
               job->samples + (window->y + y) * job->params.size[0] + window->x,
               (size_t)window->width * sizeof *out);
    return out;
}

// What two halves of the samples' rows show.
static struct weft_separable_survey survey(const weft_separable_plan *plan, const struct job *job)
{
    const int width = job->params.size[0], half = job->params.size[1] / 2;
    struct weft_separable_survey sum = {0}, one;
    for (int i = half ? 0 : 1; i < 2; i++) {
        const struct weft_rectangle window = {0, i ? half : 0, width,
                                              i ? job->params.size[1] - half : half};
        float *samples = cut_window(job, &window);
        assert_int_equal(weft_separable_survey_samples(
                             plan,
                             weft_separable_run_params(.samples = samples, .window = window,
                                                       .log = &log_to_stderr),
                             &one),
                         WEFT_OK);
        weft_separable_survey_join(&sum, &one);
        free(samples);
    }
    return sum;
}

static void run_part(const weft_separable_plan *plan, weft_separable *compiled,
                     const struct job *job, const struct weft_rectangle *part, const float *whole)
{
    static float pixels[MOST_PIXELS * (MOST_PIXELS + GAP)];
    const struct weft_separable_survey surveyed = survey(plan, job);
    const struct weft_rectangle window = weft_separable_reach(plan, part);
    struct weft_separable_report report;
    struct weft_verify_report error;
    float *samples = cut_window(job, &window);
    struct weft_separable_run_params run = {.samples = samples,
                                            .window = window,
                                            .part = *part,
                                            .survey = &surveyed,
                                            .pixels = pixels,
                                            .stride = part->width + GAP,
                                            .log = &log_to_stderr};
    for (int i = 0; i < part->height * (part->width + GAP); i++)
        pixels[i] = 4711.0f;
    assert_int_equal(weft_separable_run(compiled, &run, &report), WEFT_OK);
    assert_int_equal(report.pixels.count, part->width * part->height);
    for (int y = 0; y < part->height; y++) {
        const float *row = pixels + y * run.stride;
        assert_memory_equal(row, whole + (part->y + y) * job->run.stride + part->x,
                            (size_t)part->width * sizeof *row);
        for (int x = 0; x < GAP; x++)
            assert_true(row[part->width + x] == 4711.0f);
    }
    assert_int_equal(weft_separable_verify(plan, &run, NULL, &error), WEFT_OK);
    assert_int_equal(error.pixels_total, part->width * part->height);
    assert_int_equal(error.not_finite_mismatches, 0);
    free(samples);
}

static void parts_are_the_crop(void **state)
{
    static float whole[MOST_PIXELS * (MOST_PIXELS + GAP)];
    static const uint64_t memory[] = {0, 1 << 17, 1 << 15};
    const char *asked = getenv("WEFT_SEPARABLE_JOBS");
    const int jobs = asked ? atoi(asked) : JOBS;
    struct random r = {17};
    int ran = 0, finite = 0;
    (void)state;
    for (int i = 0; i < jobs; i++) {
        struct job *job = make_job(&r, i);
        const struct where *where = &wheres[i / 2 % where_count];
        struct weft_separable_compile_params compile = where->compile;
        weft_separable_plan *plan = NULL;
        weft_separable *compiled = NULL;
        job->params.memory_bytes = memory[i % 3];
        compile.cpu.threads = 1 + i % 3;
        run(where, job, 1, memory[i % 3], false, whole);
        assert_int_equal(weft_separable_plan_create(&job->params, &plan), WEFT_OK);
        assert_int_equal(weft_separable_compile(plan, &compile, &compiled), WEFT_OK);
        for (int k = 0; k < 6; k++, ran++) {
            const struct weft_rectangle part = make_part(&r, job->params.width, job->params.height);
            run_part(plan, compiled, job, &part, whole);
            finite += isfinite(whole[part.y * job->run.stride + part.x]) != 0;
        }
        weft_separable_destroy(&compiled);
        weft_separable_plan_destroy(&plan);
        free(job);
    }
    assert_int_equal(ran, 6 * jobs);
    assert_true(finite > ran / 2 && (asked || finite < ran));
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(random_jobs_agree),
                                       cmocka_unit_test(parts_are_the_crop)};
    return cmocka_run_group_tests(tests, create_wheres, destroy_wheres);
}
