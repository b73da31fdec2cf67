// SPDX-License-Identifier: BSD-3-Clause
#include "passes/distribute/items.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "passes/distribute/ranks_impl.h"

// How often progress is asked for while others work.
static const double ask_seconds = 0.05;
// After an item that took less, the one after the next is asked for before the next is done: the
// way to rank 0 and back, about a millisecond, would count. All are busy until the last such item.
static const double short_item = 0.02;

struct record {
    int64_t item;
    double seconds;
};

// One call of weft_ranks_do_items on this rank.
struct job {
    weft_ranks *ranks;
    const struct weft_items *work;
    struct weft_queue *queue;
    enum weft_schedule schedule;
    bool pulls;   // items come from rank 0
    int64_t next; // of this rank otherwise
    bool asked;   // for an item that is not wanted yet
    int64_t *order;
    double taking;
    uint64_t bytes;
    // What this rank did.
    struct record *records;
    int64_t done, room;
};

void weft_items_report_clear(struct weft_items_report *report)
{
    if (!report)
        return;
    weft_load_clear(&report->load);
    free(report->item_seconds);
    free(report->item_rank);
    *report = (struct weft_items_report){0};
}

static enum weft_result check(const struct weft_items *work, const struct weft_log *log)
{
    weft_require(log, work->count >= 0);
    weft_require_enum(log, work->schedule, WEFT_SCHEDULE_COUNT - 1);
    weft_require(log, work->run && work->take);
    for (int64_t i = 0; work->cost && i < work->count; i++)
        weft_require(log, work->cost[i] > 0.0 && isfinite(work->cost[i]));
    return WEFT_OK;
fail:
    return WEFT_ERR_ARGUMENT;
}

static enum weft_schedule resolve(const struct weft_items *work, int ranks)
{
    if (work->schedule != WEFT_SCHEDULE_AUTO)
        return work->schedule;
    return work->count >= 2 * (int64_t)ranks ? WEFT_SCHEDULE_PULL : WEFT_SCHEDULE_STATIC;
}

// ---- the report ---------------------------------------------------------------------------------

static enum weft_result make_report(const struct job *job, struct weft_items_report *report)
{
    const int ranks = job->ranks->info.size;
    const size_t count = job->work->count > 0 ? (size_t)job->work->count : 1;
    report->count = job->work->count;
    report->schedule = job->schedule;
    report->failed_rank = -1;
    const enum weft_result res = weft_load_create(ranks, &report->load);
    report->item_seconds = calloc(count, sizeof *report->item_seconds);
    report->item_rank = calloc(count, sizeof *report->item_rank);
    if (res != WEFT_OK || !report->item_seconds || !report->item_rank) {
        weft_error(job->ranks->params.log, "out of memory: a report of %zu items of %d ranks",
                   count, ranks);
        weft_items_report_clear(report);
        return WEFT_ERR_MEMORY;
    }
    for (size_t i = 0; i < count; i++)
        report->item_rank[i] = -1;
    return WEFT_OK;
}

static void tell_of_rank(struct weft_items_report *report, int rank, const char *host, int threads,
                         const struct record *records, int64_t count)
{
    struct weft_rank_load *load = &report->load.rank[rank];
    (void)snprintf(load->host, sizeof load->host, "%s", host);
    load->threads = threads;
    load->items = count;
    for (int64_t i = 0; i < count; i++) {
        load->busy += records[i].seconds;
        report->item_seconds[records[i].item] = records[i].seconds;
        report->item_rank[records[i].item] = rank;
    }
}

// ---- items --------------------------------------------------------------------------------------

static void lock(struct job *job)
{
    pthread_mutex_lock(&job->ranks->lock);
}

// What this thread has changed is to be told to others.
static void unlock(struct job *job)
{
    pthread_cond_signal(&job->ranks->posted);
    pthread_mutex_unlock(&job->ranks->lock);
}

static void fail(struct job *job, int64_t item, enum weft_result result)
{
    lock(job);
    weft_queue_fail(job->queue, item, result);
    unlock(job);
}

static void fail_for_memory(struct job *job, const char *what, size_t bytes)
{
    weft_error(job->ranks->params.log, "out of memory: %s, %zu bytes", what, bytes);
    fail(job, INT64_MAX, WEFT_ERR_MEMORY);
}

static bool is_stopped(const struct job *job)
{
    return job->queue->stopped || job->ranks->lost;
}

static int64_t next_pulled(struct job *job)
{
    if (job->ranks->info.rank == 0)
        return weft_queue_next(job->queue);
    if (!job->asked)
        weft_queue_ask(job->queue);
    while (!is_stopped(job) && (!job->queue->answered || job->queue->ask.busy))
        weft_ranks_await_change(job->ranks);
    if (is_stopped(job) || job->queue->answer == WEFT_NO_ITEM)
        return WEFT_NO_ITEM;
    const int64_t item = job->queue->answer;
    job->asked = job->done > 0 && job->records[job->done - 1].seconds < short_item;
    if (job->asked)
        weft_queue_ask(job->queue);
    return item;
}

static int64_t next_item(struct job *job)
{
    int64_t item = WEFT_NO_ITEM;
    lock(job);
    if (!is_stopped(job) && job->pulls) {
        item = next_pulled(job);
    } else if (!is_stopped(job) && job->next < job->work->count) {
        item = job->next;
        job->next += job->ranks->info.size;
    }
    unlock(job);
    return item;
}

static bool record(struct job *job, int64_t item, double seconds)
{
    if (job->done == job->room) {
        const int64_t room = job->room ? 2 * job->room : 16;
        struct record *grown = realloc(job->records, (size_t)room * sizeof *grown);
        if (!grown)
            return false;
        job->records = grown;
        job->room = room;
    }
    job->records[job->done++] = (struct record){item, seconds};
    return true;
}

// Rank 0, without the lock.
static void take(struct job *job, int64_t item, const void *data, size_t size)
{
    const double begun = weft_now_seconds();
    const enum weft_result res = job->work->take(job->work->priv, item, data, size);
    job->taking += weft_now_seconds() - begun;
    if (res != WEFT_OK)
        fail(job, item, res);
}

// Other ranks: data is taken over.
static void send_result(struct job *job, int64_t item, void *data, size_t size)
{
    lock(job);
    while (!is_stopped(job) && !weft_queue_has_room(job->queue, size))
        weft_ranks_await_change(job->ranks);
    if (is_stopped(job)) {
        free(data);
    } else {
        weft_queue_send_result(job->queue, item, data, size);
        job->bytes += size;
    }
    unlock(job);
}

static void do_item(struct job *job, int64_t item)
{
    void *data = NULL;
    size_t size = 0;
    const double begun = weft_now_seconds();
    enum weft_result res = job->work->run(job->work->priv, item, &data, &size);
    if (!record(job, item, weft_now_seconds() - begun) && res == WEFT_OK) {
        weft_error(job->ranks->params.log, "out of memory: a list of items");
        res = WEFT_ERR_MEMORY;
    }
    if (res != WEFT_OK)
        fail(job, item, res);
    else if (job->ranks->info.rank != 0)
        send_result(job, item, data, data ? size : 0), data = NULL;
    else if (data && size > 0)
        take(job, item, data, size);
    free(data);
}

// ---- rank 0 -------------------------------------------------------------------------------------

// Results of others; after a failure they are dropped.
static void take_waiting(struct job *job)
{
    struct weft_queue_result result;
    int from;
    lock(job);
    while (weft_queue_get_result(job->queue, &from, &result)) {
        const bool stopped = is_stopped(job);
        pthread_mutex_unlock(&job->ranks->lock);
        if (!stopped)
            take(job, result.item, result.data, result.size);
        free(result.data);
        lock(job);
        weft_queue_note_taken(job->queue, from, result.size);
        pthread_cond_signal(&job->ranks->posted);
    }
    unlock(job);
}

static void ask_progress(struct job *job)
{
    const struct weft_progress *progress = job->work->progress;
    lock(job);
    const int64_t done = job->done + job->queue->done;
    const bool stopped = is_stopped(job);
    unlock(job);
    if (stopped || !progress || !progress->report || job->work->count == 0)
        return;
    if (!progress->report(progress->priv, (double)done / (double)job->work->count))
        fail(job, INT64_MAX, WEFT_ERR_CANCELLED);
}

// Until the last of others' results has come.
static void wait_for_others(struct job *job)
{
    bool all;
    do {
        take_waiting(job);
        ask_progress(job);
        lock(job);
        all = job->queue->waiting == 0;
        for (int r = 1; r < job->ranks->info.size; r++)
            all = weft_ranks_has_up(job->ranks, r, WEFT_STEP_ITEMS) && all;
        all = all || job->ranks->lost;
        if (!all)
            weft_ranks_wait(job->ranks, &job->ranks->changed, ask_seconds);
        unlock(job);
    } while (!all);
}

static int compare_costs(const void *a, const void *b, void *priv)
{
    const int64_t i = *(const int64_t *)a, k = *(const int64_t *)b;
    const double *cost = priv;
    if (cost[i] != cost[k])
        return cost[i] > cost[k] ? -1 : 1;
    return (i > k) - (i < k);
}

static void open_queue(struct job *job)
{
    const int64_t count = job->work->count;
    if (job->work->cost && count > 0) {
        job->order = malloc((size_t)count * sizeof *job->order);
        for (int64_t i = 0; job->order && i < count; i++)
            job->order[i] = i;
        if (job->order)
            qsort_r(job->order, (size_t)count, sizeof *job->order, compare_costs,
                    (void *)job->work->cost);
        else
            fail_for_memory(job, "the order of items", (size_t)count * sizeof *job->order);
    }
    lock(job);
    weft_queue_open(job->queue, job->order, count);
    unlock(job);
}

// What other ranks did; returns how many items that were, or -1: the job has ended.
static int64_t hear_of_others(struct job *job, struct weft_items_report *report)
{
    int64_t done = 0;
    for (int r = 1; r < job->ranks->info.size; r++) {
        struct weft_incoming in;
        if (!weft_ranks_await_up(job->ranks, r, WEFT_STEP_ITEMS, &in))
            return -1;
        const int64_t count = (int64_t)(in.head.size / sizeof(struct record));
        if (in.lost)
            fail_for_memory(job, "what a rank did", (size_t)in.head.size);
        if (report && report->load.rank && !in.lost) {
            tell_of_rank(report, r, job->ranks->hosts[r], job->ranks->threads[r],
                         (const struct record *)in.data, count);
            report->load.rank[r].bytes = in.head.value[0];
        }
        free(in.data);
        done += count;
    }
    return done;
}

static enum weft_result lead(struct job *job, struct weft_items_report *report)
{
    if (job->pulls)
        open_queue(job);
    int64_t item;
    while ((item = next_item(job)) != WEFT_NO_ITEM) {
        do_item(job, item);
        take_waiting(job);
        ask_progress(job);
    }
    wait_for_others(job);
    const int64_t others = hear_of_others(job, report);
    if (others < 0)
        return WEFT_RANKS_LOST;
    lock(job);
    const int failed = job->queue->failed_rank;
    const size_t lacks = job->queue->lacks;
    enum weft_result res = failed < 0 ? WEFT_OK : job->queue->failed;
    weft_queue_end_work(job->queue);
    unlock(job);
    if (lacks)
        weft_error(job->ranks->params.log, "out of memory: the result of an item, %zu bytes",
                   lacks);
    if (res == WEFT_OK && others + job->done != job->work->count) {
        weft_error(job->ranks->params.log, "ranks were given different work: %lld of %lld items",
                   (long long)(others + job->done), (long long)job->work->count);
        res = WEFT_ERR_ARGUMENT;
    }
    if (report)
        report->failed_rank = failed;
    return weft_ranks_conclude(job->ranks, WEFT_STEP_ITEMS, res, failed);
}

// ---- other ranks --------------------------------------------------------------------------------

static enum weft_result follow(struct job *job, struct weft_items_report *report)
{
    int64_t item;
    while ((item = next_item(job)) != WEFT_NO_ITEM)
        do_item(job, item);
    const struct weft_head head = {
        .size = (uint64_t)job->done * sizeof *job->records,
        .value = {job->bytes},
    };
    int failed = -1;
    weft_ranks_send_up(job->ranks, WEFT_STEP_ITEMS, &head, job->records);
    const enum weft_result res = weft_ranks_hear(job->ranks, WEFT_STEP_ITEMS, &failed);
    if (report)
        report->failed_rank = failed;
    return res;
}

enum weft_result weft_ranks_do_items(weft_ranks *ranks, const struct weft_items *work,
                                     struct weft_items_report *report)
{
    const double begun = weft_now_seconds();
    const int rank = ranks->info.rank;
    if (report)
        *report = (struct weft_items_report){0};
    enum weft_result res = check(work, ranks->params.log);
    if (res != WEFT_OK)
        return res;
    struct job job = {.ranks = ranks, .work = work, .queue = &ranks->queue, .next = rank};
    job.schedule = resolve(work, ranks->info.size);
    job.pulls = job.schedule == WEFT_SCHEDULE_PULL;
    if (report && make_report(&job, report) != WEFT_OK)
        fail(&job, INT64_MAX, WEFT_ERR_MEMORY);
    res = rank == 0 ? lead(&job, report) : follow(&job, report);
    if (report && report->load.rank) {
        tell_of_rank(report, rank, ranks->info.host, ranks->info.threads, job.records, job.done);
        report->load.rank[rank].taking = job.taking;
        report->load.rank[rank].bytes = job.bytes;
        report->load.seconds = weft_now_seconds() - begun;
    }
    free(job.records);
    free(job.order);
    return res;
}
