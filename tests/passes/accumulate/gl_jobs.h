// SPDX-License-Identifier: BSD-3-Clause
// tests/passes/accumulate/gl_jobs.h - one accumulation on every GL context and emulated: the same
// bits, and within the bound. Include after cmocka.h.
#ifndef WEFT_TESTS_PASSES_ACCUMULATE_GL_JOBS_H
#define WEFT_TESTS_PASSES_ACCUMULATE_GL_JOBS_H

#include "passes/accumulate/accumulate_impl.h"
#include "tests/passes/accumulate/frames.h"
#include "tests/support/contexts.h"

enum { JOB_WIDTH = 13, JOB_HEIGHT = 7, JOB_PIXELS = JOB_WIDTH * JOB_HEIGHT, JOB_CHANNELS = 5 };

struct gl_job {
    enum weft_accumulate_method method;
    int n, channels, bits;
    enum weft_plane_type type;
    enum weighing weighing;
    bool known;
    double low, high;
};

static inline struct weft_accumulator_params gl_job_params(const struct gl_job *j,
                                                           const struct frames *f)
{
    return (struct weft_accumulator_params){
        .width = JOB_WIDTH,
        .height = JOB_HEIGHT,
        .channel_count = j->channels,
        .method = j->method,
        .bits = j->bits,
        .frame_count = j->known ? j->n : 0,
        .weight = j->known ? f->weight : NULL,
        .low = j->low,
        .high = j->high,
        .log = &log_to_stderr,
    };
}

// Emulated, and on each context that there is.
enum { RUNS = 3 };

static inline int create_runs(const struct gl_job *j, const struct frames *f,
                              weft_accumulator *runs[RUNS])
{
    struct weft_accumulator_params p = gl_job_params(j, f);
    int count = 0;
    p.emulate = true;
    assert_int_equal(weft_accumulator_create(&p, &runs[count++]), WEFT_OK);
    p.emulate = false;
    for (int c = 0; c < 2; c++) {
        p.context = contexts[c];
        if (p.context)
            assert_int_equal(weft_accumulator_create(&p, &runs[count++]), WEFT_OK);
    }
    return count;
}

// Compares the runs' means so far with the first one's, and that with the exact mean. Returns the
// largest error.
static inline double compare_runs(const struct gl_job *j, const struct frames *f, int count,
                                  weft_accumulator *runs[RUNS])
{
    double worst = 0.0;
    float out[RUNS][JOB_PIXELS];
    for (int c = 0; c < j->channels; c++) {
        for (int r = 0; r < count; r++)
            assert_int_equal(weft_accumulator_current(runs[r], WEFT_ACCUMULATED_MEAN, c, out[r], 0),
                             WEFT_OK);
        for (int r = 1; r < count; r++)
            if (memcmp(out[0], out[r], sizeof out[0]) != 0)
                for (int i = 0; i < JOB_PIXELS; i++)
                    if (memcmp(&out[0][i], &out[r][i], sizeof(float)) != 0)
                        fail_msg("%s, %d bits, %d frames of %s, %s: run %d, channel %d, pixel %d: "
                                 "%a, emulated %a",
                                 weft_accumulate_method_names[j->method], j->bits, j->n,
                                 weft_plane_type_names[j->type], j->known ? "known" : "not known",
                                 r, c, i, (double)out[r][i], (double)out[0][i]);
        worst = larger(worst, mean_error(f, c, out[0]));
    }
    return worst;
}

// Every run goes on from the state of the next one, on GL or emulated.
static inline void pass_states_on(const struct gl_job *j, const struct frames *f, int count,
                                  weft_accumulator *runs[RUNS])
{
    weft_accumulator *next[RUNS];
    struct weft_accumulator_report before, after;
    assert_int_equal(create_runs(j, f, next), count);
    for (int r = 0; r < count; r++) {
        void *state = NULL;
        size_t size = 0;
        assert_int_equal(weft_accumulator_save(runs[(r + 1) % count], &state, &size), WEFT_OK);
        assert_int_equal(weft_accumulator_load(next[r], state, size), WEFT_OK);
        weft_accumulator_get_report(runs[r], &before);
        weft_accumulator_get_report(next[r], &after);
        assert_true(before.bound == after.bound && before.counted == after.counted &&
                    before.weight_change == after.weight_change);
        free(state);
    }
    for (int r = 0; r < count; r++) {
        weft_accumulator_destroy(&runs[r]);
        runs[r] = next[r];
    }
}

// Runs a job; returns its largest error / bound.
static inline double run_gl_job(const struct gl_job *j, uint64_t seed)
{
    struct frames f;
    weft_accumulator *runs[RUNS];
    struct weft_accumulator_report report;
    double worst = 0.0;
    make_frames(&f, j->n, j->channels, JOB_PIXELS, j->type, j->low, j->high, seed);
    weigh_frames(&f, j->weighing, seed + 1);
    const int count = create_runs(j, &f, runs);
    weft_accumulator_get_report(runs[0], &report);
    assert_true(j->known ? isfinite(report.bound) : isinf(report.bound));
    const double predicted = report.bound;
    const struct weft_accumulator_params params = gl_job_params(j, &f);
    const double expected = runs[0]->way->expect(&params, j->n);
    assert_true(expected > 0.0 && isfinite(expected));
    if (j->known && j->weighing == EQUAL)
        assert_near(expected, predicted, 1e-9 * predicted, "the bound that is expected");
    for (int k = 0; k < j->n; k++) {
        for (int r = 0; r < count; r++)
            assert_int_equal(
                weft_accumulator_add(
                    runs[r], &(struct weft_frame){.plane = &f.plane[k * j->channels]}, f.weight[k]),
                WEFT_OK);
        sum_frame(&f, k);
        if (k == j->n / 2)
            pass_states_on(j, &f, count, runs);
        if (k % 5 && k != j->n - 1)
            continue;
        const double error = compare_runs(j, &f, count, runs);
        weft_accumulator_get_report(runs[0], &report);
        if (!(error <= report.bound))
            fail_msg("%s, %d bits, %d of %d frames of %s, weighing %d, %s: error %g, bound %g",
                     weft_accumulate_method_names[j->method], j->bits, k + 1, j->n,
                     weft_plane_type_names[j->type], (int)j->weighing,
                     j->known ? "known" : "not known", error, report.bound);
        worst = larger(worst, error / report.bound);
    }
    if (j->known)
        assert_true(report.bound <= predicted * 1.0001);
    assert_true(report.method == j->method);
    for (int r = 0; r < count; r++)
        weft_accumulator_destroy(&runs[r]);
    free_frames(&f);
    return worst;
}

#endif
