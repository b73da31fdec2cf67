// SPDX-License-Identifier: BSD-3-Clause
// Items of work done by ranks: the same bytes come of them for every number of ranks, schedule,
// order of messages and costs; each is done once; what fails ends the work on all ranks alike.
// WEFT_RANKS=full: all combinations.
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <cmocka.h>

#include "filter/check.h"
#include "tests/passes/distribute/threads_transport.h"

enum { ITEMS_MAX = 6000 };

static const int rank_counts[] = {1, 2, 3, 7};

// What items do, seen by all ranks.
static struct {
    struct weft_items items;
    size_t most;        // bytes of an item
    bool empty;         // items say nothing
    bool full;          // all but the first say w.most bytes
    int64_t fails[2];   // items that fail in run, take; -1: none
    int64_t also_fails; // in run
    double cancel_at;   // fraction of progress
    double seconds;     // that rank 0 takes for an item
    struct weft_items_report report[THREADS_RANKS_MAX];
    // What happened.
    atomic_int runs[ITEMS_MAX], takes[ITEMS_MAX], waiting[THREADS_RANKS_MAX];
    atomic_int owner[ITEMS_MAX], most_waiting;
    unsigned char *result;
    double fraction;
} w;

struct rank {
    weft_ranks *ranks;
    int rank;
};

static size_t bytes_of(int64_t item)
{
    if (w.empty || w.full)
        return w.empty ? 0 : item == 0 ? 1 : w.most;
    return 1 + (size_t)(item * 7919 % (int64_t)w.most);
}

static void make(int64_t item, unsigned char *data)
{
    for (size_t i = 0; i < bytes_of(item); i++)
        data[i] = (unsigned char)((i + 31) * ((uint64_t)item + 7) >> 3);
}

static enum weft_result run(void *priv, int64_t item, void **data, size_t *size)
{
    const struct rank *rank = priv;
    THREADS_CHECK(item >= 0 && item < w.items.count);
    atomic_fetch_add(&w.runs[item], 1);
    if (item == w.fails[0])
        return WEFT_ERR_OPEN;
    if (item == w.also_fails)
        return WEFT_ERR_FORMAT;
    if (rank->rank == 0 && w.seconds > 0.0)
        nanosleep(&(struct timespec){0, (long)(w.seconds * 1e9)}, NULL);
    if (w.empty)
        return WEFT_OK;
    *size = bytes_of(item);
    *data = malloc(*size);
    make(item, *data);
    atomic_store(&w.owner[item], rank->rank);
    const int waits = 1 + atomic_fetch_add(&w.waiting[rank->rank], 1);
    int most = atomic_load(&w.most_waiting);
    while (waits > most && !atomic_compare_exchange_weak(&w.most_waiting, &most, waits))
        continue;
    return WEFT_OK;
}

static enum weft_result take(void *priv, int64_t item, const void *data, size_t size)
{
    const struct rank *rank = priv;
    THREADS_CHECK(rank->rank == 0 && item >= 0 && item < w.items.count);
    THREADS_CHECK(!w.empty && size == bytes_of(item));
    atomic_fetch_add(&w.takes[item], 1);
    if (item == w.fails[1])
        return WEFT_ERR_WRITE;
    if (w.result)
        memcpy(w.result + (size_t)item * w.most, data, size);
    atomic_fetch_sub(&w.waiting[atomic_load(&w.owner[item])], 1);
    return WEFT_OK;
}

static bool report_progress(void *priv, double fraction)
{
    const struct rank *rank = priv;
    THREADS_CHECK(rank->rank == 0 && fraction >= w.fraction && fraction <= 1.0);
    w.fraction = fraction;
    return !(fraction >= w.cancel_at);
}

static enum weft_result do_items(void *priv, weft_ranks *ranks)
{
    (void)priv;
    struct weft_ranks_info info;
    weft_ranks_get_info(ranks, &info);
    struct rank rank = {ranks, info.rank};
    const struct weft_progress progress = {report_progress, &rank};
    struct weft_items items = w.items;
    items.run = run;
    items.take = take;
    items.priv = &rank;
    items.progress = info.rank == 0 ? &progress : NULL;
    return weft_ranks_do_items(ranks, &items, &w.report[info.rank]);
}

static void begin(int64_t count, size_t most)
{
    for (int r = 0; r < THREADS_RANKS_MAX; r++)
        weft_items_report_clear(&w.report[r]);
    free(w.result);
    memset(&w, 0, sizeof w);
    w.items.count = count;
    w.most = most;
    w.fails[0] = w.fails[1] = w.also_fails = -1;
    w.cancel_at = 2.0;
    w.result = calloc((size_t)count + 1, most);
}

// Runs what w says; all ranks return the same.
static enum weft_result do_on(int ranks, unsigned seed, double delay)
{
    struct threads_outcome out;
    threads_run(
        &(struct threads_params){.ranks = ranks, .seed = seed, .delay = delay, .body = do_items},
        &out);
    assert_int_equal(threads_faults(), 0);
    assert_int_equal(out.lines + out.left, 0);
    assert_int_equal(out.exit_code, -1);
    for (int r = 1; r < ranks; r++) {
        assert_int_equal(out.result[r], out.result[0]);
        assert_int_equal(w.report[r].failed_rank, w.report[0].failed_rank);
    }
    return out.result[0];
}

static void assert_report(int ranks, enum weft_schedule schedule)
{
    const struct weft_items_report *report = &w.report[0];
    int64_t items = 0, of_rank[THREADS_RANKS_MAX] = {0};
    uint64_t bytes = 0, all_bytes = 0;
    assert_int_equal(report->schedule, schedule);
    assert_int_equal(report->load.ranks, ranks);
    assert_int_equal(report->failed_rank, -1);
    for (int64_t i = 0; i < w.items.count; i++) {
        const int rank = report->item_rank[i];
        assert_in_range(rank, 0, ranks - 1);
        assert_true(report->item_seconds[i] >= 0.0);
        assert_true(schedule == WEFT_SCHEDULE_PULL || rank == i % ranks);
        assert_int_equal(w.report[rank].item_rank[i], rank);
        of_rank[rank]++;
        all_bytes += rank == 0 ? 0 : bytes_of(i);
    }
    for (int r = 0; r < ranks; r++) {
        const struct weft_rank_load *load = &report->load.rank[r];
        assert_true(load->threads >= 1);
        assert_true(load->busy >= 0.0 && load->busy <= report->load.seconds);
        assert_int_equal(load->items, of_rank[r]);
        assert_int_equal(w.report[r].load.rank[r].items, of_rank[r]);
        assert_true(r == 0 || (load->taking == 0.0 && w.report[r].load.rank[r].taking == 0.0));
        assert_string_equal(load->host, "node0");
        items += load->items;
        bytes += load->bytes;
    }
    assert_int_equal(items, w.items.count);
    assert_int_equal(bytes, all_bytes);
    assert_int_equal(report->load.rank[0].bytes, 0);
}

static void assert_done_once(void)
{
    unsigned char *wanted = malloc(w.most);
    for (int64_t i = 0; i < w.items.count; i++) {
        assert_int_equal(atomic_load(&w.runs[i]), 1);
        assert_int_equal(atomic_load(&w.takes[i]), w.empty ? 0 : 1);
        make(i, wanted);
        assert_memory_equal(w.result + (size_t)i * w.most, wanted, bytes_of(i));
    }
    free(wanted);
    assert_true(w.items.count == 0 || w.fraction == 1.0);
}

static bool is_full(void)
{
    const char *wish = getenv("WEFT_RANKS");
    return wish && strcmp(wish, "full") == 0;
}

static void bytes_are_the_same(void **state)
{
    (void)state;
    static const int64_t counts[] = {0, 1, 5, 40};
    static double costs[40];
    int ran = 0;
    for (int i = 0; i < 40; i++)
        costs[i] = 1.0 + i * 17 % 40;
    for (size_t n = 0; n < WEFT_COUNT(rank_counts); n++)
        for (int s = 0; s < WEFT_SCHEDULE_COUNT; s++)
            for (size_t c = 0; c < WEFT_COUNT(counts); c++)
                for (unsigned seed = 0; seed < (is_full() ? 20 : 2); seed++) {
                    begin(counts[c], seed % 2 ? 3000 : 300);
                    w.items.schedule = (enum weft_schedule)s;
                    w.items.cost = seed % 2 ? costs : NULL;
                    assert_int_equal(do_on(rank_counts[n], seed, 0.0005), WEFT_OK);
                    assert_done_once();
                    assert_report(rank_counts[n], s != WEFT_SCHEDULE_AUTO ? (enum weft_schedule)s
                                                  : counts[c] >= 2 * rank_counts[n]
                                                      ? WEFT_SCHEDULE_PULL
                                                      : WEFT_SCHEDULE_STATIC);
                    ran++;
                }
    assert_true(ran >= 4 * 4 * 4 * 2);
}

static void thousands_of_items(void **state)
{
    (void)state;
    for (int s = WEFT_SCHEDULE_STATIC; s < WEFT_SCHEDULE_COUNT; s++)
        for (int empty = 0; empty < 2; empty++) {
            begin(5000, 100);
            w.items.schedule = (enum weft_schedule)s;
            w.empty = empty;
            assert_int_equal(do_on(3, 1, 0.0), WEFT_OK);
            assert_done_once();
            assert_report(3, (enum weft_schedule)s);
        }
}

static void the_dearest_come_first(void **state)
{
    (void)state;
    static const double costs[] = {1.0, 5.0, 3.0, 5.0, 2.0, 4.0};
    begin(6, 10);
    w.items.cost = costs;
    w.items.schedule = WEFT_SCHEDULE_PULL;
    w.cancel_at = 0.3; // after two
    assert_int_equal(do_on(1, 0, 0.0), WEFT_ERR_CANCELLED);
    for (int i = 0; i < 6; i++)
        assert_int_equal(atomic_load(&w.runs[i]), costs[i] == 5.0 ? 1 : 0);
}

static void large_results_arrive(void **state)
{
    (void)state;
    begin(2, ((size_t)64 << 20) + 12345);
    w.items.schedule = WEFT_SCHEDULE_STATIC;
    w.full = true;
    assert_int_equal(do_on(2, 3, 0.0), WEFT_OK);
    assert_done_once();
}

// ---- failures -----------------------------------------------------------------------------------

// What has failed at one place is what all return; items are begun no more.
static void assert_failed(int ranks, enum weft_result res, enum weft_result wanted)
{
    assert_int_equal(res, wanted);
    for (int64_t i = 0; i < w.items.count; i++) {
        assert_in_range(atomic_load(&w.runs[i]), 0, 1);
        assert_in_range(atomic_load(&w.takes[i]), 0, atomic_load(&w.runs[i]));
    }
    assert_in_range(w.report[0].failed_rank, 0, ranks - 1);
}

static void failures_end_the_work(void **state)
{
    (void)state;
    int ran = 0;
    for (int ranks = 1; ranks <= 3; ranks++)
        for (int s = WEFT_SCHEDULE_STATIC; s < WEFT_SCHEDULE_COUNT; s++)
            for (int64_t at = 0; at < 9; at += is_full() || s == WEFT_SCHEDULE_PULL ? 1 : 4) {
                begin(9, 500);
                w.items.schedule = (enum weft_schedule)s;
                w.fails[0] = at;
                assert_failed(ranks, do_on(ranks, (unsigned)at, 0.001), WEFT_ERR_OPEN);
                assert_true(s == WEFT_SCHEDULE_PULL || w.report[0].failed_rank == at % ranks);
                assert_int_equal(w.report[0].item_rank[at], w.report[0].failed_rank);

                begin(9, 500);
                w.items.schedule = (enum weft_schedule)s;
                w.fails[1] = at;
                assert_failed(ranks, do_on(ranks, (unsigned)at, 0.001), WEFT_ERR_WRITE);
                assert_int_equal(w.report[0].failed_rank, 0);

                begin(9, 500);
                w.items.schedule = (enum weft_schedule)s;
                w.cancel_at = (double)at / 9.0;
                assert_failed(ranks, do_on(ranks, (unsigned)at, 0.001), WEFT_ERR_CANCELLED);
                ran++;
            }
    assert_true(ran >= 3 * (3 + 3 + 9));
}

// Of two failures that both happened, the first item's is returned.
static void the_first_failure_is_returned(void **state)
{
    (void)state;
    for (unsigned seed = 0; seed < 10; seed++) {
        begin(8, 100);
        w.items.schedule = WEFT_SCHEDULE_STATIC;
        w.fails[0] = 1;
        w.also_fails = 0;
        const enum weft_result res = do_on(2, seed, 0.002);
        assert_failed(2, res, atomic_load(&w.runs[0]) ? WEFT_ERR_FORMAT : WEFT_ERR_OPEN);
    }
}

// ---- several works, and what they need ----------------------------------------------------------

static enum weft_result do_works(void *priv, weft_ranks *ranks)
{
    enum weft_result res = WEFT_OK;
    char line[8] = "";
    struct weft_ranks_info info;
    weft_ranks_get_info(ranks, &info);
    for (int work = 0; work < 12; work++) {
        // Written by one rank while the others wait.
        if (info.rank == 0) {
            begin(7, 200);
            w.items.schedule = (enum weft_schedule)(work % WEFT_SCHEDULE_COUNT);
            w.fails[0] = work % 3 == 1 ? work % 7 : -1;
        }
        THREADS_CHECK(weft_ranks_agree(ranks, WEFT_OK, line, sizeof line, NULL) == WEFT_OK);
        res = do_items(priv, ranks);
        THREADS_CHECK(res == (work % 3 == 1 ? WEFT_ERR_OPEN : WEFT_OK));
        THREADS_CHECK(weft_ranks_agree(ranks, WEFT_OK, line, sizeof line, NULL) == WEFT_OK);
        for (int i = 0; info.rank == 0 && res == WEFT_OK && i < 7; i++)
            THREADS_CHECK(atomic_load(&w.runs[i]) == 1 && atomic_load(&w.takes[i]) == 1);
    }
    return res;
}

static void works_follow_each_other(void **state)
{
    (void)state;
    for (int ranks = 1; ranks <= 7; ranks += 3) {
        struct threads_outcome out;
        threads_run(&(struct threads_params){.ranks = ranks, .delay = 0.001, .body = do_works},
                    &out);
        assert_int_equal(threads_faults(), 0);
        assert_int_equal(out.lines + out.left, 0);
    }
}

// While rank 0 is at a long item of its own, others hold so many results: two large ones that wait,
// one that waits to be sent; of small ones many.
static void results_that_wait_are_few(void **state)
{
    (void)state;
    for (int large = 0; large < 2; large++) {
        begin(14, large ? 3 << 20 : 1000);
        w.items.schedule = WEFT_SCHEDULE_STATIC;
        w.seconds = large ? 0.02 : 0.1;
        w.items.count = large ? 14 : 8;
        w.full = large;
        assert_int_equal(do_on(2, 0, 0.0), WEFT_OK);
        assert_done_once();
        print_message("%s results of rank 1 that were not taken: at most %d\n",
                      large ? "large" : "small", atomic_load(&w.most_waiting));
        if (large)
            assert_in_range(atomic_load(&w.most_waiting), 1, 4);
        else
            assert_int_equal(atomic_load(&w.most_waiting), 4);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bytes_are_the_same),      cmocka_unit_test(thousands_of_items),
        cmocka_unit_test(the_dearest_come_first),  cmocka_unit_test(large_results_arrive),
        cmocka_unit_test(failures_end_the_work),   cmocka_unit_test(the_first_failure_is_returned),
        cmocka_unit_test(works_follow_each_other), cmocka_unit_test(results_that_wait_are_few),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
