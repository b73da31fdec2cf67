// SPDX-License-Identifier: BSD-3-Clause
#include "passes/distribute/items.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "filter/check.h"
#include "passes/distribute/ranks_impl.h"

// One call of weft_ranks_do_items on this rank.
struct job {
    weft_ranks *ranks;
    const struct weft_items *work;
    const struct weft_log *log;
    struct weft_items_report report;
    double started;
    int64_t done;
    enum weft_result result; // of what failed first
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

static enum weft_schedule resolve(const struct weft_items *work, int ranks)
{
    if (work->schedule != WEFT_SCHEDULE_AUTO)
        return work->schedule;
    return work->count >= 2 * (int64_t)ranks ? WEFT_SCHEDULE_PULL : WEFT_SCHEDULE_STATIC;
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

static enum weft_result make_report(struct job *job)
{
    struct weft_items_report *report = &job->report;
    const int ranks = job->ranks->info.size;
    const size_t count = job->work->count > 0 ? (size_t)job->work->count : 1;
    enum weft_result res = weft_load_create(ranks, &report->load);
    report->schedule = resolve(job->work, ranks);
    report->failed_rank = -1;
    report->item_seconds = calloc(count, sizeof *report->item_seconds);
    report->item_rank = calloc(count, sizeof *report->item_rank);
    if (res == WEFT_OK && (!report->item_seconds || !report->item_rank))
        res = WEFT_ERR_MEMORY;
    if (res != WEFT_OK) {
        weft_error(job->log, "out of memory: a report of %zu items of %d ranks", count, ranks);
        return res;
    }
    for (size_t i = 0; i < count; i++)
        report->item_rank[i] = -1;
    (void)snprintf(report->load.rank[job->ranks->info.rank].host, sizeof report->load.rank[0].host,
                   "%s", job->ranks->info.host);
    return WEFT_OK;
}

// Rank 0's own results are taken where they are.
static enum weft_result do_item(struct job *job, int64_t item)
{
    const struct weft_items *work = job->work;
    struct weft_rank_load *load = &job->report.load.rank[job->ranks->info.rank];
    void *data = NULL;
    size_t size = 0;
    const double begun = weft_now_seconds();
    enum weft_result res = work->run(work->priv, item, &data, &size);
    const double ended = weft_now_seconds();
    job->report.item_seconds[item] = ended - begun;
    job->report.item_rank[item] = job->ranks->info.rank;
    load->busy += ended - begun;
    load->items++;
    if (res == WEFT_OK && data) {
        res = work->take(work->priv, item, data, size);
        load->taking += weft_now_seconds() - ended;
    }
    free(data);
    job->done++;
    return res;
}

static bool goes_on(const struct job *job)
{
    const struct weft_progress *progress = job->work->progress;
    return !progress || !progress->report ||
           progress->report(progress->priv, (double)job->done / (double)job->work->count);
}

static enum weft_result do_all(struct job *job)
{
    enum weft_result res = WEFT_OK;
    for (int64_t i = 0; res == WEFT_OK && i < job->work->count; i++)
        if ((res = do_item(job, i)) == WEFT_OK && !goes_on(job))
            res = WEFT_ERR_CANCELLED;
    return res;
}

enum weft_result weft_ranks_do_items(weft_ranks *ranks, const struct weft_items *work,
                                     struct weft_items_report *report)
{
    struct job job = {.ranks = ranks, .work = work, .log = ranks->params.log};
    if (report)
        *report = (struct weft_items_report){0};
    enum weft_result res = check(work, job.log);
    if (res != WEFT_OK)
        return res;
    job.started = weft_now_seconds();
    if ((res = make_report(&job)) == WEFT_OK) {
        if ((res = do_all(&job)) != WEFT_OK)
            job.report.failed_rank = 0;
        job.report.load.seconds = weft_now_seconds() - job.started;
    }
    if (report)
        *report = job.report;
    else
        weft_items_report_clear(&job.report);
    return res;
}
