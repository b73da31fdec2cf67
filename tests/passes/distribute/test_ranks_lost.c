// SPDX-License-Identifier: BSD-3-Clause
// Ranks that fall silent, are stopped, cannot send, or wait in vain: the job ends soon, with one
// line that names who it was; and it does not where nobody is lost. All jobs run at once, since
// they wait.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

#include "filter/check.h"
#include "filter/threads.h"
#include "tests/passes/distribute/threads_transport.h"

static struct weft_ranks_info info_of(weft_ranks *ranks)
{
    struct weft_ranks_info info;
    weft_ranks_get_info(ranks, &info);
    return info;
}

static void pause_for(double seconds)
{
    nanosleep(&(struct timespec){(time_t)seconds, (long)((seconds - (time_t)seconds) * 1e9)}, NULL);
}

// ---- bodies -------------------------------------------------------------------------------------

// Rank 1 computes for long, the others end at once.
static enum weft_result work_long(void *priv, weft_ranks *ranks)
{
    (void)priv;
    const int rank = info_of(ranks).rank;
    if (rank == 1)
        pause_for(1.5);
    return WEFT_OK;
}

// Until the job has ended.
static enum weft_result meet_again_and_again(void *priv, weft_ranks *ranks)
{
    (void)priv;
    char line[8] = "";
    for (int i = 0; i < 1000; i++) {
        const enum weft_result res = weft_ranks_agree(ranks, WEFT_OK, line, sizeof line, NULL);
        if (res != WEFT_OK)
            return res;
        pause_for(0.01);
    }
    return WEFT_OK;
}

static enum weft_result set_timeout(void *priv, weft_ranks *ranks)
{
    THREADS_CHECK(weft_ranks_set_timeout(ranks, 0.1) == WEFT_ERR_ARGUMENT);
    THREADS_CHECK(weft_ranks_set_timeout(ranks, 0.5) == WEFT_OK);
    THREADS_CHECK(info_of(ranks).timeout == 0.5);
    return meet_again_and_again(priv, ranks);
}

static enum weft_result meet_a_few_times(void *priv, weft_ranks *ranks)
{
    (void)priv;
    char line[8] = "";
    for (int i = 0; i < 20; i++) {
        THREADS_CHECK(weft_ranks_agree(ranks, WEFT_OK, line, sizeof line, NULL) == WEFT_OK);
        pause_for(0.005);
    }
    return WEFT_OK;
}

static enum weft_result do_other_things(void *priv, weft_ranks *ranks)
{
    (void)priv;
    char line[8] = "";
    void *data = NULL;
    size_t size = 0;
    if (info_of(ranks).rank == 1)
        return weft_ranks_share(ranks, &data, &size);
    return weft_ranks_agree(ranks, WEFT_OK, line, sizeof line, NULL);
}

static enum weft_result leave_one_alone(void *priv, weft_ranks *ranks)
{
    const int leaves = *(const int *)priv;
    char line[8] = "";
    if (info_of(ranks).rank == leaves)
        return WEFT_OK;
    return weft_ranks_agree(ranks, WEFT_OK, line, sizeof line, NULL);
}

// ---- jobs ---------------------------------------------------------------------------------------

enum {
    SILENT,              // 3: a rank each
    MUTE = SILENT + 3,   // it never spoke
    CHANGED,             // the time-out was changed
    SENDING,             // 12: each rank cannot send after 0 to 3 messages
    LONG = SENDING + 12, // works long
    STOPPED,             // all were stopped, and go on
    DIFFERENT,           // do different things
    ALONE,               // 3: a rank each has left the others
    JOBS = ALONE + 3
};
static const int numbers[] = {0, 1, 2};
static struct threads_params job[JOBS];
static struct threads_outcome outcome[JOBS];

static void describe_jobs(void)
{
    for (int r = 0; r < 3; r++) {
        job[SILENT + r] = (struct threads_params){.timeout = 0.6,
                                                  .delay = 0.002,
                                                  .sends_before = 6,
                                                  .body = meet_again_and_again,
                                                  .stopping_rank = r + 1,
                                                  .node_ranks = 1};
        job[ALONE + r] = (struct threads_params){.body = leave_one_alone, .delay = 0.01};
        for (int i = 0; i < 3; i++)
            job[ALONE + r].priv[i] = (void *)&numbers[r];
        for (int before = 0; before < 4; before++)
            job[SENDING + 4 * r + before] = (struct threads_params){.body = meet_again_and_again,
                                                                    .sends_before = before,
                                                                    .delay = 0.001,
                                                                    .failing_rank = r + 1};
    }
    job[MUTE] = (struct threads_params){
        .ranks = 2, .timeout = 0.5, .stopping_rank = 2, .body = meet_again_and_again};
    job[CHANGED] = (struct threads_params){
        .ranks = 2, .timeout = 3600.0, .body = set_timeout, .stopping_rank = 1, .sends_before = 20};
    job[LONG] = (struct threads_params){.timeout = 1.0, .body = work_long};
    job[STOPPED] = (struct threads_params){.timeout = 1.0,
                                           .body = meet_a_few_times,
                                           .stopping_rank = 2,
                                           .sends_before = 8,
                                           .stop_seconds = 1.5,
                                           .stop_all = true};
    job[DIFFERENT] = (struct threads_params){.body = do_other_things};
}

static bool run_job(void *priv, int thread, size_t i)
{
    (void)priv, (void)thread;
    job[i].ranks = job[i].ranks ? job[i].ranks : 3;
    threads_run(&job[i], &outcome[i]);
    return true;
}

static int run_jobs(void **state)
{
    (void)state;
    describe_jobs();
    return weft_threads_run(JOBS, JOBS, run_job, NULL) ? 0 : -1;
}

// By the rank that says so.
static void assert_ended(const struct threads_outcome *out, int rank, const char *line)
{
    assert_int_equal(out->exit_code, 7);
    assert_int_equal(out->lines, 1);
    assert_int_equal(out->line_rank, rank);
    if (!strstr(out->line, line))
        fail_msg("'%s' is not in '%s'", line, out->line);
    assert_in_range(out->seconds * 1000.0, 0, 5000);
}

static void a_silent_rank_is_named_once(void **state)
{
    (void)state;
    for (int silent = 0; silent < 3; silent++) {
        char line[128];
        (void)snprintf(line, sizeof line,
                       "rank %d on node%d (process %ld) is lost: no sign of life for 0.6 seconds",
                       silent, silent, (long)getpid());
        assert_ended(&outcome[SILENT + silent], (silent + 1) % 3, line);
        for (int r = 0; r < 3; r++)
            assert_int_equal(outcome[SILENT + silent].result[r], WEFT_ERR_CANCELLED);
    }
    assert_ended(&outcome[MUTE], 0, "rank 1 is lost: no sign of life for 0.5 seconds, nor before");
    assert_ended(&outcome[CHANGED], 1, "is lost: no sign of life for 0.5 seconds");
}

static void what_cannot_be_sent_ends_the_job(void **state)
{
    (void)state;
    char line[64];
    (void)snprintf(line, sizeof line, "(process %ld): cannot send to rank ", (long)getpid());
    for (int i = 0; i < 12; i++)
        assert_ended(&outcome[SENDING + i], i / 4, line);
}

static void who_is_not_lost_goes_on(void **state)
{
    (void)state;
    static const int jobs[] = {LONG, STOPPED};
    for (size_t i = 0; i < WEFT_COUNT(jobs); i++) {
        const struct threads_outcome *out = &outcome[jobs[i]];
        assert_int_equal(out->lines + out->left, 0);
        assert_int_equal(out->exit_code, -1);
        assert_true(out->seconds > 1.4);
        for (int r = 0; r < 3; r++)
            assert_int_equal(out->result[r], WEFT_OK);
    }
    assert_int_equal(threads_faults(), 0);
}

static void who_waits_in_vain_ends_the_job(void **state)
{
    (void)state;
    assert_ended(&outcome[DIFFERENT], 0,
                 "ranks do not do the same: rank 0 is at agree, rank 1 at share");
    for (int leaves = 0; leaves < 3; leaves++) {
        char line[64];
        (void)snprintf(line, sizeof line, "rank %d has ended while ", leaves);
        assert_ended(&outcome[ALONE + leaves], 0, line);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_silent_rank_is_named_once),
        cmocka_unit_test(what_cannot_be_sent_ends_the_job),
        cmocka_unit_test(who_is_not_lost_goes_on),
        cmocka_unit_test(who_waits_in_vain_ends_the_job),
    };
    return cmocka_run_group_tests(tests, run_jobs, NULL);
}
