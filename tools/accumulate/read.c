// SPDX-License-Identifier: BSD-3-Clause
// Reading the frames of `weft accumulate`, one after another.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/accumulate/every.h"
#include "tools/accumulate/read.h"
#include "tools/accumulate/state.h"
#include "tools/common/report.h"

// ---- told ---------------------------------------------------------------------------------------

bool read_tell(struct accumulate_job *job)
{
    snprintf(job->doing, sizeof job->doing, "reading frame %lld of %lld", (long long)job->next,
             (long long)job->counting);
    state_set_last_words(job);
    return report_progress(job->doing)->report(NULL, (double)job->next / (double)job->counting);
}

static const char *name_of(void *priv, int64_t i)
{
    const struct accumulate_job *job = priv;
    return job->frame[job->sequence[job->begun + i]].path;
}

// ---- what a frame's fault is --------------------------------------------------------------------

// Whether the method refuses a value; of codes none.
static bool is_refused(const struct accumulate_job *job, float value)
{
    const struct accumulate_request *r = &job->request;
    const double low = r->how.low, high = low < r->how.high ? r->how.high : 1.0;
    const bool codes = job->planned.bits == 8 || job->planned.bits == 16;
    if (!isfinite(value))
        return r->nonfinite == WEFT_NONFINITE_ERROR || codes;
    return codes && job->planned.method != WEFT_ACCUMULATE_BUFFER &&
           ((double)value < low || (double)value > high);
}

static size_t channel_averaged(const struct accumulate_job *job, int averaged)
{
    size_t c = 0;
    while (job->channel[c].averaged != averaged)
        c++;
    return c;
}

// The first value that is refused, in the file's own channels and pixels.
static bool find_refused(const struct accumulate_job *job, int averaged, float *row, int32_t *x,
                         int32_t *y)
{
    for (*y = 0; *y < job->image.height; (*y)++) {
        weft_plane_row(&job->plane[averaged], *y, job->image.width, row, 1);
        for (*x = 0; *x < job->image.width; (*x)++)
            if (is_refused(job, row[*x]))
                return true;
    }
    return false;
}

static void tell_value(const struct accumulate_job *job, const char *path, int averaged,
                       float value, int32_t x, int32_t y)
{
    const char *channel = job->image.channels[channel_averaged(job, averaged)].name;
    if (!isfinite(value))
        report_error("%s: channel %s is %g at pixel (%d, %d) (--nonfinite says what becomes of "
                     "such values)",
                     path, channel, (double)value, job->image.x + x, job->image.y + y);
    else
        report_error("%s: channel %s is %.9g at pixel (%d, %d), beyond the range of the targets of "
                     "%d bits, %g to %g (--source-range)",
                     path, channel, (double)value, job->image.x + x, job->image.y + y,
                     job->planned.bits, job->request.how.low,
                     job->request.how.low < job->request.how.high ? job->request.how.high : 1.0);
}

// Says why the accumulator has refused the frame in job->plane.
static void tell_refused(struct accumulate_job *job, const char *path)
{
    float *row = malloc((size_t)job->image.width * sizeof *row);
    int32_t x, y;
    for (int c = 0; row && c < job->averaged_count; c++) {
        if (!find_refused(job, c, row, &x, &y))
            continue;
        tell_value(job, path, c, row[x], x, y);
        free(row);
        return;
    }
    free(row);
    report_error("%s: %s", path, job->message);
}

bool read_is_bad(enum weft_result res)
{
    return res == WEFT_ERR_OPEN || res == WEFT_ERR_FORMAT || res == WEFT_ERR_READER ||
           res == WEFT_ERR_UNSUPPORTED || res == WEFT_ERR_LIMIT;
}

// ---- frames -------------------------------------------------------------------------------------

static enum weft_result add(struct accumulate_job *job, const struct weft_image_frame *frame,
                            double weight)
{
    const struct weft_frame planes = {.plane = job->plane};
    const double start = report_now_seconds();
    *job->message = 0;
    job->adding = true;
    const enum weft_result res = weft_accumulator_add(job->accumulator, &planes, weight);
    job->adding = false;
    job->add_seconds += report_now_seconds() - start;
    if (res == WEFT_ERR_FORMAT || res == WEFT_ERR_LIMIT)
        tell_refused(job, frame->name);
    else if (res != WEFT_OK)
        report_error("%s", job->message);
    return res;
}

enum weft_result read_add(struct accumulate_job *job, const struct weft_image_frame *frame,
                          double weight)
{
    enum weft_result res = frame->result;
    if (res != WEFT_OK)
        report_error("%s", frame->message);
    if (res == WEFT_OK)
        res = accumulate_match(job, frame);
    const double start = report_now_seconds();
    if (res == WEFT_OK)
        res = accumulate_decode(job, frame);
    job->decode_seconds += report_now_seconds() - start;
    if (res == WEFT_OK)
        res = add(job, frame, weight);
    if (res == WEFT_OK)
        accumulate_widen(job, &frame->image);
    return res;
}

enum weft_result read_count(struct accumulate_job *job, const struct state_stamp *stamp)
{
    struct accumulate_frame *named = &job->frame[job->sequence[job->next]];
    job->first = job->first < 0 ? job->sequence[job->next] : job->first;
    job->added++;
    named->stamp = *stamp;
    named->done = true;
    job->next++;
    return WEFT_OK;
}

// The error line stays with the frame, and others may have theirs.
enum weft_result read_skip(struct accumulate_job *job, const struct state_stamp *stamp)
{
    struct accumulate_frame *named = &job->frame[job->sequence[job->next]];
    named->problem = strdup(report_get_error());
    report_set_part(NULL, NULL);
    job->skipped++;
    if (!named->problem)
        return WEFT_ERR_MEMORY;
    named->stamp = *stamp;
    named->done = true;
    job->next++;
    return WEFT_OK;
}

static enum weft_result take_frame(struct accumulate_job *job, const struct weft_image_frame *frame)
{
    const struct accumulate_frame *named = &job->frame[job->sequence[job->next]];
    struct state_stamp stamp = {(int64_t)frame->file_bytes, frame->changed_ns};
    enum weft_result res = read_add(job, frame, named->weight);
    if (res == WEFT_OK)
        res = accumulate_copy(job, frame);
    if (res == WEFT_OK)
        return read_count(job, &stamp);
    if (!job->option[ACCUMULATE_SKIP_BAD].given || !read_is_bad(res))
        return res;
    stamp = state_file_stamp(named->path);
    return read_skip(job, &stamp);
}

int64_t read_next_judged(const struct accumulate_job *job)
{
    return accumulation_next_judged(&job->request.how.until, job->judged);
}

// Of frames that an earlier run has added: all that was judged but for the last, which may end it.
static void remember_judged(struct accumulate_job *job)
{
    for (int64_t next; (next = read_next_judged(job)) < job->added;)
        job->judged = next;
}

enum weft_result read_judge(struct accumulate_job *job)
{
    if (!job->option[ACCUMULATE_UNTIL].given || job->added < read_next_judged(job))
        return WEFT_OK;
    const double start = report_now_seconds();
    const enum weft_result res =
        weft_accumulator_judge(job->accumulator, &job->request.how.until, &job->convergence);
    job->judged = job->added;
    job->stopped = res == WEFT_OK && job->convergence.enough && job->next < job->counting;
    job->judge_seconds += report_now_seconds() - start;
    return res;
}

// *more: there may be another one.
static enum weft_result read_next(struct accumulate_job *job, weft_image_sequence *sequence,
                                  bool *more)
{
    const struct weft_image_frame *frame = NULL;
    const double start = report_now_seconds();
    *more = false;
    if (!read_tell(job))
        return WEFT_ERR_CANCELLED;
    enum weft_result res = weft_image_sequence_next(sequence, &frame);
    job->read_seconds += report_now_seconds() - start;
    *more = frame || res == WEFT_ERR_CANCELLED;
    if (res == WEFT_ERR_CANCELLED) // the mean was asked for: the same frame comes the next time
        res = WEFT_OK;
    else if (frame)
        res = take_frame(job, frame);
    if (res == WEFT_OK && frame)
        res = read_judge(job);
    if (res == WEFT_OK && every_is_due(job))
        every_write(job);
    if (res == WEFT_OK && frame)
        state_save_now_and_then(job);
    *more = *more && !job->stopped;
    return res;
}

static bool asks_for_mean(void *priv)
{
    return every_is_due(priv);
}

enum weft_result read_open(struct accumulate_job *job, int64_t count,
                           const char *(*name)(void *priv, int64_t i), bool (*stop)(void *priv),
                           weft_image_sequence **out)
{
    const int threads = job->request.how.threads;
    return weft_image_sequence_create(
        weft_image_sequence_params(.count = count, .name = name, .stop = stop, .priv = job,
                                   .readers = threads < WEFT_IMAGE_SEQUENCE_MAX_READERS
                                                  ? threads
                                                  : WEFT_IMAGE_SEQUENCE_MAX_READERS,
                                   .memory_bytes = (uint64_t)ACCUMULATE_AHEAD_MB << 20,
                                   .part = job->request.part, .log = report_log()),
        out);
}

enum weft_result read_go_on(struct accumulate_job *job)
{
    every_begin(job);
    if (job->added == 0)
        return WEFT_OK;
    remember_judged(job);
    const enum weft_result res = accumulate_copy_again(job);
    return res == WEFT_OK && !job->joins ? read_judge(job) : res;
}

enum weft_result accumulate_read(struct accumulate_job *job)
{
    weft_image_sequence *sequence = NULL;
    enum weft_result res = read_go_on(job);
    bool more = job->next < job->counting && !job->stopped;
    if (!more || res != WEFT_OK)
        return res;
    job->begun = job->next;
    res = read_open(job, job->counting - job->begun, name_of, asks_for_mean, &sequence);
    while (res == WEFT_OK && more)
        res = read_next(job, sequence, &more);
    weft_image_sequence_destroy(&sequence);
    return res;
}
