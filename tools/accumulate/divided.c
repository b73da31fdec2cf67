// SPDX-License-Identifier: BSD-3-Clause
#include "tools/accumulate/divided.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/accumulate/every.h"
#include "tools/accumulate/outcome.h"
#include "tools/accumulate/read.h"
#include "tools/accumulate/settings.h"
#include "tools/accumulate/state.h"
#include "tools/common/report.h"
#include "tools/ranks/ranks.h"

// ---- what rank 0 knows --------------------------------------------------------------------------

static enum weft_result no_memory(const struct accumulate_job *job)
{
    report_error("out of memory for %lld frames", (long long)job->frame_count);
    return WEFT_ERR_MEMORY;
}

// Weights, then names, each with its end. NULL: no memory.
static char *pack_frames(const struct accumulate_job *job, size_t *size)
{
    size_t bytes = (size_t)job->frame_count * sizeof(double);
    for (int64_t i = 0; i < job->frame_count; i++)
        bytes += strlen(job->frame[i].path) + 1;
    char *packed = malloc(bytes + 1), *at = packed;
    *size = bytes;
    for (int64_t i = 0; packed && i < job->frame_count; i++, at += sizeof(double))
        memcpy(at, &job->frame[i].weight, sizeof(double));
    for (int64_t i = 0; packed && i < job->frame_count; i++)
        at = stpcpy(at, job->frame[i].path) + 1;
    return packed;
}

static enum weft_result take_frames(struct accumulate_job *job, const char *packed)
{
    const char *name = packed + (size_t)job->frame_count * sizeof(double);
    job->frame = calloc((size_t)job->frame_count, sizeof *job->frame);
    for (int64_t i = 0; job->frame && i < job->frame_count; i++) {
        struct accumulate_frame *frame = &job->frame[i];
        memcpy(&frame->weight, packed + (size_t)i * sizeof(double), sizeof(double));
        frame->path = strdup(name);
        if (!frame->path)
            return no_memory(job);
        name += strlen(name) + 1;
    }
    return job->frame ? accumulate_sum_weights(job) : no_memory(job);
}

enum weft_result divided_share_frames(struct accumulate_job *job)
{
    void *packed = NULL;
    size_t size = 0;
    enum weft_result res = WEFT_OK;
    if (ranks_tells() && !(packed = pack_frames(job, &size)))
        res = no_memory(job);
    res = ranks_agree(res);
    if (res == WEFT_OK)
        res = ranks_share(&job->frame_count, sizeof job->frame_count);
    if (res == WEFT_OK)
        res = weft_ranks_share(ranks_get(), &packed, &size);
    if (res == WEFT_OK)
        res = ranks_agree(ranks_tells() ? WEFT_OK : take_frames(job, packed));
    free(packed);
    return res;
}

// Frames must be of one shape, on whatever rank they are read.
static enum weft_result compare_shapes(const struct accumulate_job *job)
{
    struct settings settings;
    enum weft_result res = ranks_agree(settings_make(job, &settings) ? WEFT_OK : WEFT_ERR_MEMORY);
    if (res == WEFT_OK)
        res = weft_ranks_compare(ranks_get(), "the first frame", settings.shape);
    settings_clear(&settings);
    return res;
}

enum weft_result divided_share_order(struct accumulate_job *job)
{
    void *order = ranks_tells() ? job->sequence : NULL;
    size_t size = (size_t)job->counting * sizeof *job->sequence;
    enum weft_result res = compare_shapes(job);
    if (res == WEFT_OK)
        res = ranks_check_alike(NULL, job->divided.request.mixed);
    if (res == WEFT_OK)
        res = weft_ranks_share(ranks_get(), &order, &size);
    if (res == WEFT_OK && !ranks_tells())
        memcpy(job->sequence, order, size);
    if (!ranks_tells())
        free(order);
    return res;
}

// ---- frames of this rank ------------------------------------------------------------------------

// Frames of a round, from job->next on, and this rank's sequence, which goes on from block to
// block.
struct reading {
    struct accumulate_job *job;
    weft_image_sequence *sequence; // NULL: not yet
    int64_t asked;                 // names of it before this block
    struct outcomes outcomes;      // of all frames of the round, on rank 0
    int64_t taken;                 // of all rounds
    double start;                  // monotonic seconds
    bool told_profile;             // that profiles are not applied
};
// Of a rank, in rounds that are as long as something takes that is not known yet.
enum { LEAST_FRAMES = 16 };

static const char *name_of(void *priv, int64_t i)
{
    const struct accumulate_job *job = priv;
    return job->frame[job->sequence[job->begun + i]].path;
}

// What was said of a frame: why it is left out, or that its profile is not applied.
static enum weft_result keep_lines(const struct report_held *held, struct outcome *out)
{
    bool whole = true;
    for (int i = 0; i < held->count; i++) {
        char **text = held->level[i] == WEFT_LOG_ERROR ? &out->problem : &out->warning;
        if (held->level[i] > WEFT_LOG_WARNING || *text)
            continue;
        *text = strdup(held->line[i]);
        whole = whole && *text;
    }
    return whole ? WEFT_OK : WEFT_ERR_MEMORY;
}

// Nothing is told of a frame before its turn comes, but for what ends the run.
static enum weft_result add_frame(struct accumulate_job *job, const struct weft_image_frame *frame,
                                  int64_t place, struct outcome *out)
{
    const struct accumulate_frame *named = &job->frame[job->sequence[place]];
    const struct weft_transfer before = job->transfer;
    struct report_held held = {.count = 0};
    job->decoder.told_profile = false;
    job->transfer.curve = WEFT_CURVE_AUTO;
    report_hold(&held);
    const enum weft_result res = read_add(job, frame, named->weight);
    report_hold(NULL);
    *out = (struct outcome){.stamp = {(int64_t)frame->file_bytes, frame->changed_ns},
                            .transfer = job->transfer};
    job->transfer = before;
    // Which frames are too much together depends on which of them a rank has.
    const bool skips = job->option[ACCUMULATE_SKIP_BAD].given && read_is_bad(res);
    if (res != WEFT_OK && (!skips || res == WEFT_ERR_LIMIT)) {
        report_release(&held);
        return res;
    }
    if (res != WEFT_OK)
        out->stamp = state_file_stamp(named->path);
    return keep_lines(&held, out);
}

static enum weft_result open_block(struct reading *r, int64_t first, int64_t count)
{
    struct accumulate_job *job = r->job;
    const int64_t asked = r->asked;
    job->begun = job->next + first - asked; // of the names that are asked for now
    r->asked += count;
    return asked ? weft_image_sequence_extend(r->sequence, count)
                 : read_open(job, count, name_of, NULL, &r->sequence);
}

static enum weft_result run(void *priv, int64_t first, int64_t count, void **data, size_t *size)
{
    struct reading *r = priv;
    struct accumulate_job *job = r->job;
    struct outcomes outcomes = {.count = 0};
    enum weft_result res = open_block(r, first, count);
    if (res == WEFT_OK)
        res = outcomes_create(count, &outcomes);
    for (int64_t i = 0; i < count && res == WEFT_OK; i++) {
        const struct weft_image_frame *frame = NULL;
        const double start = report_now_seconds();
        res = weft_image_sequence_next(r->sequence, &frame);
        job->read_seconds += report_now_seconds() - start;
        if (res == WEFT_OK)
            res = add_frame(job, frame, job->next + first + i, &outcomes.list[i]);
    }
    if (res == WEFT_OK)
        res = outcomes_pack(&outcomes, job, data, size);
    outcomes_clear(&outcomes);
    return res;
}

static enum weft_result take(void *priv, int64_t first, int64_t count, const void *data,
                             size_t size)
{
    struct reading *r = priv;
    r->taken += count;
    return outcomes_take(&r->outcomes, r->job, first, count, data, size);
}

// ---- rounds -------------------------------------------------------------------------------------

// Frames are told of in their order, as one process does.
static enum weft_result count_frames(struct reading *r)
{
    struct accumulate_job *job = r->job;
    enum weft_result res = WEFT_OK;
    for (int64_t i = 0; i < r->outcomes.count && res == WEFT_OK; i++) {
        const struct outcome *o = &r->outcomes.list[i];
        if (o->transfer.curve != WEFT_CURVE_AUTO)
            job->transfer = o->transfer;
        if (o->warning && !r->told_profile) {
            report_warning("%s", o->warning);
            r->told_profile = true;
        }
        if (o->problem)
            report_error("%s", o->problem);
        res = o->problem ? read_skip(job, &o->stamp) : read_count(job, &o->stamp);
    }
    return res;
}

// Channels that are copied, once it is known which frame is the first.
static enum weft_result copy_first(struct accumulate_job *job)
{
    if (job->added == 0)
        return WEFT_OK;
    for (size_t c = 0; c < job->image.channel_count; c++)
        if (job->channel[c].averaged < 0 && !job->image.channels[c].plane)
            return accumulate_copy_again(job);
    return WEFT_OK;
}

// So many frames that the sums become one in time for what is to be done with them; 0: none is
// left. Between two saves or means so far a rank has a few blocks at least.
static int64_t find_round(const struct reading *r)
{
    const struct accumulate_job *job = r->job;
    const struct option_value *every = &job->option[ACCUMULATE_EVERY];
    int64_t count = job->stopped ? 0 : job->counting - job->next;
    double seconds = HUGE_VAL;
    if (job->option[ACCUMULATE_UNTIL].given && read_next_judged(job) - job->added < count)
        count = read_next_judged(job) - job->added;
    if (every->given)
        seconds = every->number[0];
    if (job->option[ACCUMULATE_RESUME].given)
        seconds = fmin(seconds, state_patience(job));
    if (seconds < HUGE_VAL) {
        const double spent = report_now_seconds() - r->start, done = (double)r->taken;
        const double some = done > 0.0 ? done / spent * seconds : 0.0;
        const double least = (double)ranks_size() * LEAST_FRAMES;
        count = (int64_t)fmin((double)count, fmax(least, some));
    }
    return count;
}

static bool report_round(void *priv, double fraction)
{
    (void)fraction;
    return read_tell(((struct reading *)priv)->job);
}

static enum weft_result create(void *priv, weft_accumulator **out)
{
    return accumulate_create(priv, out);
}

static enum weft_result add_round(struct reading *r, int64_t count)
{
    struct accumulate_job *job = r->job;
    const struct weft_progress progress = {report_round, r};
    const struct rank_frames frames = {
        .count = count,
        .counted = job->added,
        .batch = job->request.how.batch ? job->request.how.batch : 1,
        .request = &job->divided.request,
        .run = run,
        .take = take,
        .priv = r,
        .progress = &progress,
    };
    enum weft_result res = ranks_agree(outcomes_create(count, &r->outcomes));
    if (res == WEFT_OK)
        res = rank_frames_add(&frames, &job->divided.report);
    if (res == WEFT_OK)
        res = rank_frames_join(&job->accumulator, create, job, &job->divided.report);
    return res;
}

// What is done with the mean so far.
static enum weft_result use_round(struct reading *r)
{
    struct accumulate_job *job = r->job;
    enum weft_result res = count_frames(r);
    if (res == WEFT_OK)
        res = copy_first(job);
    if (res == WEFT_OK)
        res = read_judge(job);
    if (res == WEFT_OK && every_is_due(job))
        every_write(job);
    if (res == WEFT_OK)
        state_save_now_and_then(job);
    return res;
}

// What other ranks have to know of it.
struct round {
    int64_t next, added, count;
};

static enum weft_result share_round(struct reading *r, int64_t *count)
{
    struct accumulate_job *job = r->job;
    struct round round = {job->next, job->added, ranks_tells() ? find_round(r) : 0};
    const enum weft_result res = ranks_share(&round, sizeof round);
    job->next = round.next;
    job->added = round.added;
    *count = round.count;
    return res;
}

enum weft_result divided_read(struct accumulate_job *job)
{
    struct reading r = {.job = job, .start = report_now_seconds()};
    enum weft_result res = ranks_agree(ranks_tells() ? read_go_on(job) : WEFT_OK);
    int64_t count = 0;
    if (res == WEFT_OK)
        res = share_round(&r, &count);
    while (res == WEFT_OK && count > 0) {
        res = add_round(&r, count);
        if (res == WEFT_OK)
            res = ranks_agree(ranks_tells() ? use_round(&r) : WEFT_OK);
        outcomes_clear(&r.outcomes);
        if (res == WEFT_OK)
            res = share_round(&r, &count);
    }
    outcomes_clear(&r.outcomes);
    weft_image_sequence_destroy(&r.sequence);
    return res;
}
