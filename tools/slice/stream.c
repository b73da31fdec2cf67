// SPDX-License-Identifier: BSD-3-Clause
// A slice's file, whose bands are written as they come from the ranks.
#include <pthread.h>
#include <stdlib.h>

#include "tools/common/ending.h"
#include "tools/common/report.h"
#include "tools/slice/stages.h"

struct slice_stream {
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t changed;
    enum weft_result (*write)(struct slice_job *job);
    bool allowed, given_up;
    struct report_held held; // what writing has told
    enum weft_result result;
};

static void *write_file(void *priv)
{
    struct slice_job *job = priv;
    report_hold(&job->stream->held);
    job->stream->result = job->stream->write(job);
    return NULL;
}

bool slice_stream_begin(struct slice_job *job, enum weft_result (*write)(struct slice_job *job))
{
    struct slice_stream *s = calloc(1, sizeof *s);
    if (!s)
        return false;
    pthread_mutex_init(&s->lock, NULL);
    pthread_cond_init(&s->changed, NULL);
    s->write = write;
    job->stream = s;
    if (ending_start_thread(&s->thread, write_file, job))
        return true;
    job->stream = NULL;
    free(s);
    return false;
}

void slice_stream_put(struct slice_job *job, int64_t band, struct weft_bytes data)
{
    struct slice_stream *s = job->stream;
    if (s)
        pthread_mutex_lock(&s->lock);
    job->bands[band] = data;
    if (s) {
        pthread_cond_signal(&s->changed);
        pthread_mutex_unlock(&s->lock);
    }
}

// Whether the next band may be written.
static bool is_ready(const struct slice_job *job)
{
    const int next = job->bands_given;
    return job->bands[next].data && (job->stream->allowed || next < job->band_count - 1);
}

enum weft_result slice_stream_give(void *priv, int line, struct weft_bytes *out)
{
    struct slice_job *job = priv;
    struct slice_stream *s = job->stream;
    (void)line;
    if (job->bands_given == job->band_count)
        return WEFT_OK;
    if (s) {
        pthread_mutex_lock(&s->lock);
        while (!s->given_up && !is_ready(job))
            pthread_cond_wait(&s->changed, &s->lock);
        const bool given_up = s->given_up;
        pthread_mutex_unlock(&s->lock);
        if (given_up)
            return WEFT_ERR_CANCELLED;
    }
    *out = job->bands[job->bands_given++];
    return WEFT_OK;
}

void slice_stream_allow(struct slice_job *job)
{
    struct slice_stream *s = job->stream;
    if (!s)
        return;
    pthread_mutex_lock(&s->lock);
    s->allowed = true;
    pthread_cond_signal(&s->changed);
    pthread_mutex_unlock(&s->lock);
}

enum weft_result slice_stream_end(struct slice_job *job)
{
    struct slice_stream *s = job->stream;
    if (!s)
        return WEFT_OK;
    pthread_mutex_lock(&s->lock);
    s->given_up = !s->allowed;
    pthread_cond_signal(&s->changed);
    pthread_mutex_unlock(&s->lock);
    pthread_join(s->thread, NULL);
    job->stream = NULL;
    if (s->allowed)
        report_release(&s->held);
    const enum weft_result res = s->result;
    pthread_cond_destroy(&s->changed);
    pthread_mutex_destroy(&s->lock);
    free(s);
    return res;
}
