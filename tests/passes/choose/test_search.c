// SPDX-License-Identifier: BSD-3-Clause
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "passes/choose/search.h"
#include "tests/support/common.h"

enum { MOST = 40, JOBS = 3000 };

// What a candidate is when it is planned, by its name's number.
struct truth {
    double seconds, bound;
    enum weft_result result;
    int planned;
};

struct job {
    struct weft_candidate candidates[MOST];
    struct truth truth[MOST];
    size_t count;
    double max_error;
    int plans; // that are there
    struct weft_quiet_log quiet;
};

static double uniform(void)
{
    return rand() / (RAND_MAX + 1.0);
}

static int number_of(const struct weft_candidate *candidate)
{
    return atoi(candidate->name);
}

static enum weft_result plan(void *priv, struct weft_candidate *candidate, void **out)
{
    struct job *job = priv;
    struct truth *truth = &job->truth[number_of(candidate)];
    truth->planned++;
    if (truth->result != WEFT_OK) {
        weft_log_write(&job->quiet.log, WEFT_LOG_ERROR, "number %d cannot be planned",
                       number_of(candidate));
        return truth->result;
    }
    candidate->seconds = truth->seconds;
    candidate->bound = truth->bound;
    *out = truth;
    job->plans++;
    return WEFT_OK;
}

static struct job *destroying;

static void destroy(void *made)
{
    assert_non_null(made);
    destroying->plans--;
}

// Figures of those that are estimated are the least; some are refused before or when planned.
static void set_job(struct job *job)
{
    memset(job, 0, sizeof *job);
    job->count = (size_t)(rand() % MOST);
    job->max_error = uniform();
    for (size_t i = 0; i < job->count; i++) {
        struct weft_candidate *c = &job->candidates[i];
        struct truth *t = &job->truth[i];
        const bool estimated = rand() % 2;
        snprintf(c->name, sizeof c->name, "%d", (int)i);
        *t = (struct truth){.seconds = uniform(), .bound = uniform()};
        t->result = rand() % 8 ? WEFT_OK : rand() % 2 ? WEFT_ERR_UNSUPPORTED : WEFT_ERR_LIMIT;
        c->state = rand() % 8 ? WEFT_CANDIDATE_DEARER : WEFT_CANDIDATE_REFUSED;
        c->estimated = estimated;
        c->seconds = t->seconds * (estimated ? uniform() : 1.0);
        c->bound =
            c->state == WEFT_CANDIDATE_REFUSED ? NAN : t->bound * (estimated ? uniform() : 1.0);
    }
}

// By looking at all of them. -1: none.
static int cheapest_of(const struct job *job)
{
    int best = -1;
    for (size_t i = 0; i < job->count; i++) {
        const struct truth *t = &job->truth[i];
        if (job->candidates[i].state != WEFT_CANDIDATE_REFUSED && t->result == WEFT_OK &&
            t->bound <= job->max_error && (best < 0 || t->seconds < job->truth[best].seconds))
            best = (int)i;
    }
    return best;
}

static void check_states(const struct job *job, const struct weft_search_result *result)
{
    int chosen = 0;
    double last = 0.0;
    for (size_t i = 0; i < job->count; i++) {
        const struct weft_candidate *c = &job->candidates[i];
        const struct truth *t = &job->truth[number_of(c)];
        const bool refused = c->state == WEFT_CANDIDATE_REFUSED;
        assert_true(t->planned <= 1);
        assert_true(refused == isnan(c->bound));
        if (!refused) {
            assert_true(c->seconds >= last);
            last = c->seconds;
        }
        if (c->state == WEFT_CANDIDATE_EXCEEDS)
            assert_true(c->bound > job->max_error);
        // Only what could have been cheaper was planned.
        if (result->chosen >= 0 && t->planned && !refused)
            assert_true(c->state == WEFT_CANDIDATE_EXCEEDS || (int)i >= result->chosen);
        chosen += c->state == WEFT_CANDIDATE_CHOSEN;
        if (result->chosen < 0 && !refused)
            assert_int_equal(c->state, WEFT_CANDIDATE_EXCEEDS);
    }
    assert_int_equal(chosen, result->chosen >= 0);
}

// Where nothing is within: the best of what is known.
static void check_best(const struct job *job, const struct weft_search_result *result)
{
    const double best = result->best < 0 ? INFINITY : job->candidates[result->best].bound;
    for (size_t i = 0; i < job->count; i++) {
        const struct weft_candidate *c = &job->candidates[i];
        if (c->state != WEFT_CANDIDATE_REFUSED && !c->estimated)
            assert_true(best <= c->bound);
    }
}

static struct weft_search start_search(struct job *job, const struct weft_log *log,
                                       double max_error)
{
    weft_quiet_log_init(&job->quiet, log);
    destroying = job;
    return (struct weft_search){.candidates = job->candidates,
                                .count = job->count,
                                .max_error = max_error,
                                .quiet = &job->quiet,
                                .priv = job,
                                .plan = plan,
                                .destroy = destroy};
}

static void the_cheapest_within_is_found(void **state)
{
    (void)state;
    static struct job job;
    int chosen = 0, none = 0, planned = 0, all = 0;
    srand(12);
    for (int i = 0; i < JOBS; i++) {
        set_job(&job);
        const bool tells = rand() % 2;
        const int expected = cheapest_of(&job);
        struct weft_search search = start_search(&job, &log_to_stderr, job.max_error);
        search.tells_best = tells;
        struct weft_search_result result;
        assert_int_equal(weft_search_run(&search, &result), WEFT_OK);
        check_states(&job, &result);
        if (expected < 0) {
            assert_true(result.chosen == -1 && !result.plan && job.plans == 0);
            check_best(&job, &result);
        } else {
            assert_true(result.chosen >= 0);
            assert_int_equal(number_of(&job.candidates[result.chosen]), expected);
            assert_true(result.plan == &job.truth[expected] && job.plans == 1);
        }
        chosen += expected >= 0;
        none += expected < 0;
        planned += result.planned;
        all += (int)job.count;
    }
    print_message("%d chosen, %d not; %d of %d candidates planned\n", chosen, none, planned, all);
    assert_true(chosen > JOBS / 2 && none > JOBS / 50);
    assert_true(planned < all / 4);
}

// ---- what is told -------------------------------------------------------------------------------

static void estimates_alone_have_a_best(void **state)
{
    (void)state;
    static struct job job;
    memset(&job, 0, sizeof job);
    job.count = 3;
    for (int i = 0; i < 3; i++) {
        snprintf(job.candidates[i].name, sizeof job.candidates[i].name, "%d", i);
        job.candidates[i].state = WEFT_CANDIDATE_DEARER;
        job.candidates[i].estimated = true;
        job.candidates[i].seconds = 1.0 + i;
        job.candidates[i].bound = i == 1 ? 0.5 : 1.0;
        job.truth[i] = (struct truth){.seconds = 3.0, .bound = 2.0};
    }
    const struct weft_search search = start_search(&job, NULL, 0.25);
    struct weft_search_result result;
    assert_int_equal(weft_search_run(&search, &result), WEFT_OK);
    assert_true(result.chosen == -1 && result.planned == 1 && job.plans == 0);
    assert_int_equal(number_of(&job.candidates[result.best]), 1);
}

static void failures_end_the_search(void **state)
{
    (void)state;
    static struct job job;
    struct message message = {0};
    const struct weft_log log = {keep_message, &message};
    memset(&job, 0, sizeof job);
    job.count = 2;
    for (int i = 0; i < 2; i++) {
        snprintf(job.candidates[i].name, sizeof job.candidates[i].name, "%d", i);
        job.candidates[i].state = WEFT_CANDIDATE_DEARER;
        job.candidates[i].seconds = 1.0 + i;
        // The first costs more than was thought, and waits with its plan.
        job.truth[i] = (struct truth){.seconds = 5.0, .result = i ? WEFT_ERR_MEMORY : WEFT_OK};
    }
    const struct weft_search search = start_search(&job, &log, 1.0);
    struct weft_search_result result;
    assert_int_equal(weft_search_run(&search, &result), WEFT_ERR_MEMORY);
    assert_true(!result.plan && result.chosen == -1 && job.plans == 0);
    assert_int_equal(message.count, 1);
    assert_non_null(strstr(message.text, "number 1"));
}

static struct weft_candidate tiles_of(int samples, int bits, bool estimated)
{
    return (struct weft_candidate){
        .method = {.algorithm = WEFT_ALGORITHM_MULTIPASS, .samples = samples, .bits = bits},
        .estimated = estimated,
        .bound = 0.1};
}

static void plans_tell_of_finer_tiles(void **state)
{
    (void)state;
    const struct weft_candidate planned = {
        .method = {.algorithm = WEFT_ALGORITHM_MULTIPASS, .samples = 16, .bits = 8}, .bound = 1.0};
    // With half of the bound that stays: 0.5 of 0.4 or 0.16, and 0.45. What is higher already, has
    // another number of bits, as few samples or a plan of its own keeps its bound.
    static const double rest[2] = {0.0, 0.5}, expected[2][2] = {{0.4, 0.16}, {0.65, 0.53}};
    for (int r = 0; r < 2; r++) {
        struct weft_candidate c[6] = {tiles_of(32, 8, true),  tiles_of(64, 8, true),
                                      tiles_of(32, 12, true), tiles_of(16, 8, true),
                                      tiles_of(32, 8, false), tiles_of(32, 8, true)};
        c[5].bound = 2.0;
        weft_search_learn(c, WEFT_COUNT(c), &planned, rest[r]);
        for (int i = 0; i < 2; i++)
            assert_true(fabs(c[i].bound - expected[r][i]) <= 1e-15);
        for (int i = 2; i < 5; i++)
            assert_true(c[i].bound == 0.1);
        assert_true(c[5].bound == 2.0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_cheapest_within_is_found),
        cmocka_unit_test(estimates_alone_have_a_best),
        cmocka_unit_test(failures_end_the_search),
        cmocka_unit_test(plans_tell_of_finer_tiles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
