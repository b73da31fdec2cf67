// SPDX-License-Identifier: BSD-3-Clause
#include "passes/distribute/ranks_impl.h"

#include <math.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "filter/threads.h"

static const double least_timeout = 0.5, default_timeout = 6.0;
// While nothing moves the thread gives way to others at first, for longer while a message is under
// way, which needs many looks. Then its naps grow with the time since something moved, so that what
// comes waits for a tenth of what it took, and a millisecond, at most; they are longer where the
// body computes and waits for nothing, so that it has the processor.
static const double short_look = 50e-6, long_look = 20e-3;
static const double nap_share = 0.1, least_nap = 20e-6, longest_nap = 1e-3, working_nap = 5e-3;

// The thread that runs the body.
struct body {
    struct weft_ranks *ranks;
    weft_body run;
    void *priv;
    enum weft_result result;
};

static bool is_timeout(double seconds)
{
    return isfinite(seconds) && seconds >= least_timeout;
}

void weft_ranks_get_info(const weft_ranks *ranks, struct weft_ranks_info *out)
{
    *out = ranks->info;
}

enum weft_result weft_ranks_set_timeout(weft_ranks *ranks, double seconds)
{
    weft_require(ranks->params.log, is_timeout(seconds));
    pthread_mutex_lock(&ranks->lock);
    ranks->info.timeout = seconds;
    pthread_mutex_unlock(&ranks->lock);
    return WEFT_OK;
fail:
    return WEFT_ERR_ARGUMENT;
}

// ---- the body's thread --------------------------------------------------------------------------

static void *run_body(void *priv)
{
    struct body *body = priv;
    struct weft_ranks *ranks = body->ranks;
    enum weft_result res = weft_ranks_settle(ranks);
    if (res == WEFT_OK)
        res = body->run(body->priv, ranks);
    pthread_mutex_lock(&ranks->lock);
    body->result = res;
    ranks->body_done = true;
    pthread_cond_signal(&ranks->posted);
    pthread_mutex_unlock(&ranks->lock);
    return NULL;
}

// ---- the thread that talks ----------------------------------------------------------------------

static void deliver_letter(struct weft_letter *letter, struct weft_incoming *in)
{
    letter->full = true;
    letter->message = *in;
    in->data = NULL;
}

static void deliver(void *priv, int from, struct weft_incoming *in)
{
    struct weft_ranks *ranks = priv;
    weft_life_hear(&ranks->life, from, in);
    switch (in->head.kind) {
    case WEFT_MESSAGE_UP:
        if (ranks->up && !ranks->up[from].full)
            deliver_letter(&ranks->up[from], in);
        break;
    case WEFT_MESSAGE_DOWN:
        if (in->head.value[1] == WEFT_STEP_ITEMS)
            weft_queue_end_work(&ranks->queue);
        if (!ranks->down.full)
            deliver_letter(&ranks->down, in);
        break;
    case WEFT_MESSAGE_BYE:
        if (ranks->bye)
            ranks->bye[from] = true;
        break;
    case WEFT_MESSAGE_END:
        ranks->ending = true;
        break;
    default:
        weft_queue_deliver(&ranks->queue, from, in);
    }
}

static void post_plain(struct weft_ranks *ranks, struct weft_outgoing *message, int to, int kind)
{
    const struct weft_head head = {.kind = kind};
    weft_talk_post(&ranks->talk, message, to, &head, NULL, NULL);
}

// Rank 0: once all bodies have ended, all are told.
static void tell_end(struct weft_ranks *ranks)
{
    bool all = ranks->body_done;
    ranks->bye[0] = ranks->body_done;
    for (int r = 1; r < ranks->info.size; r++) {
        all = all && ranks->bye[r] && !ranks->down_message[r].busy;
        if (ranks->body_done && (ranks->up[r].full || ranks->queue.other[r].asks))
            (void)snprintf(ranks->wrong, sizeof ranks->wrong,
                           "rank 0 has ended while rank %d waits for it", r);
    }
    for (int r = 1; all && r < ranks->info.size; r++)
        post_plain(ranks, &ranks->down_message[r], r, WEFT_MESSAGE_END);
    ranks->ending = all;
}

static void end_step(struct weft_ranks *ranks)
{
    if (ranks->info.rank == 0 && !ranks->ending)
        tell_end(ranks);
    if (ranks->info.rank != 0 && ranks->body_done && !ranks->said_bye) {
        ranks->said_bye = true;
        post_plain(ranks, &ranks->bye_message, 0, WEFT_MESSAGE_BYE);
    }
    if (ranks->ending && ranks->body_done && !ranks->said_last) {
        ranks->said_last = true;
        post_plain(ranks, &ranks->last_message, ranks->life.next, WEFT_MESSAGE_LAST);
    }
}

static bool is_over(const struct weft_ranks *ranks)
{
    if (ranks->lost)
        return ranks->body_done;
    return ranks->said_last && ranks->life.ended && weft_talk_is_done(&ranks->talk);
}

// With the lock, which is given up meanwhile. Where the transport cannot end all processes, this
// rank ends with its body.
static void end_job(struct weft_ranks *ranks, const char *line)
{
    const struct weft_distribute_params *p = &ranks->params;
    const struct weft_transport *t = ranks->talk.transport;
    pthread_mutex_unlock(&ranks->lock);
    if (p->lost)
        p->lost(p->priv, line);
    else
        (void)fprintf(stderr, "%s\n", line);
    t->abort(t->priv, p->exit_code);
    pthread_mutex_lock(&ranks->lock);
    ranks->lost = true;
    pthread_cond_broadcast(&ranks->changed);
}

static void look_for_faults(struct weft_ranks *ranks, bool silent)
{
    char line[512];
    const struct weft_life *life = &ranks->life;
    const struct weft_talk *talk = &ranks->talk;
    const char *fault = talk->fault[0] ? talk->fault : ranks->wrong;
    if (fault[0]) {
        (void)snprintf(line, sizeof line, "rank %d on %s (process %ld): %s; all ranks are ended",
                       ranks->info.rank, ranks->info.host, (long)getpid(), fault);
    } else if (silent && life->process) {
        (void)snprintf(line, sizeof line,
                       "rank %d on %s (process %ld) is lost: no sign of life for %g seconds; all "
                       "ranks are ended",
                       talk->watched, life->host, life->process, ranks->info.timeout);
    } else if (silent) {
        (void)snprintf(line, sizeof line,
                       "rank %d is lost: no sign of life for %g seconds, nor before; all ranks are "
                       "ended",
                       talk->watched, ranks->info.timeout);
    } else {
        return;
    }
    end_job(ranks, line);
}

static void nap(struct weft_ranks *ranks, double idle)
{
    if (idle < (weft_talk_is_under_way(&ranks->talk) ? long_look : short_look)) {
        pthread_mutex_unlock(&ranks->lock);
        sched_yield();
        pthread_mutex_lock(&ranks->lock);
        return;
    }
    double seconds = idle * nap_share;
    const bool works = ranks->info.rank != 0 && !ranks->waits && !ranks->body_done;
    seconds = fmin(seconds, works ? working_nap : longest_nap);
    seconds = fmax(seconds, least_nap);
    weft_ranks_wait(ranks, &ranks->posted, seconds);
}

static void talk_to_the_end(struct weft_ranks *ranks)
{
    double active = weft_now_seconds();
    weft_life_init(&ranks->life, &ranks->talk, active);
    pthread_mutex_lock(&ranks->lock);
    while (!is_over(ranks)) {
        if (ranks->lost) {
            pthread_cond_wait(&ranks->posted, &ranks->lock);
            continue;
        }
        pthread_mutex_unlock(&ranks->lock);
        const bool moved = weft_talk_move(&ranks->talk);
        pthread_mutex_lock(&ranks->lock);
        if (moved)
            pthread_cond_broadcast(&ranks->changed);
        weft_queue_tell(&ranks->queue);
        end_step(ranks);
        const double now = weft_now_seconds();
        const bool silent =
            weft_life_step(&ranks->life, now, ranks->info.timeout, ranks->said_last);
        look_for_faults(ranks, silent);
        if (ranks->talk.stirred || (moved && weft_talk_is_under_way(&ranks->talk)))
            active = now;
        ranks->talk.stirred = false;
        if (!moved && !ranks->talk.posted.first && !ranks->lost && !is_over(ranks))
            nap(ranks, now - active);
    }
    pthread_mutex_unlock(&ranks->lock);
}

// Signals come to the body, as to the thread that called before.
static enum weft_result run_together(struct weft_ranks *ranks, struct body *body)
{
    pthread_t thread;
    sigset_t all, before;
    const bool started = pthread_create(&thread, NULL, run_body, body) == 0;
    if (!started) {
        weft_error(ranks->params.log, "rank %d cannot start a thread", ranks->info.rank);
        body->result = WEFT_ERR_MEMORY;
        ranks->body_done = true;
    }
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    talk_to_the_end(ranks);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    if (started)
        pthread_join(thread, NULL);
    return body->result;
}

// ---- the whole ----------------------------------------------------------------------------------

static void init_locks(struct weft_ranks *ranks)
{
    pthread_condattr_t monotonic;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_mutex_init(&ranks->lock, NULL);
    pthread_cond_init(&ranks->changed, &monotonic);
    pthread_cond_init(&ranks->posted, &monotonic);
    pthread_condattr_destroy(&monotonic);
}

static void init_info(struct weft_ranks *ranks, const struct weft_transport *t)
{
    if (!t || !t->host)
        if (gethostname(ranks->host, sizeof ranks->host - 1) != 0 || !ranks->host[0])
            (void)snprintf(ranks->host, sizeof ranks->host, "localhost");
    ranks->info = (struct weft_ranks_info){
        .rank = t ? t->rank : 0,
        .size = t ? t->size : 1,
        .node = t ? t->node : 0,
        .node_rank = t ? t->node_rank : 0,
        .node_size = t ? t->node_size : 1,
        .threads = t ? t->threads : weft_threads_available(),
        .host = t && t->host ? t->host : ranks->host,
        .timeout = ranks->params.timeout,
    };
}

static enum weft_result init_together(struct weft_ranks *ranks, const struct weft_transport *t)
{
    const size_t size = (size_t)t->size;
    ranks->together = true;
    ranks->talk.lock = &ranks->lock;
    ranks->talk.deliver = deliver;
    ranks->talk.priv = ranks;
    enum weft_result res = weft_talk_init(&ranks->talk, t);
    if (res == WEFT_OK)
        res = weft_queue_init(&ranks->queue, &ranks->talk);
    if (res != WEFT_OK || t->rank != 0)
        return res;
    ranks->hosts = calloc(size, sizeof *ranks->hosts);
    ranks->threads = calloc(size, sizeof *ranks->threads);
    ranks->parts = calloc(size, sizeof *ranks->parts);
    ranks->bye = calloc(size, sizeof *ranks->bye);
    ranks->up = calloc(size, sizeof *ranks->up);
    ranks->down_message = calloc(size, sizeof *ranks->down_message);
    const bool made = ranks->hosts && ranks->threads && ranks->parts && ranks->bye && ranks->up &&
                      ranks->down_message;
    return made ? WEFT_OK : WEFT_ERR_MEMORY;
}

static void clear(struct weft_ranks *ranks)
{
    for (int r = 0; ranks->up && r < ranks->info.size; r++)
        free(ranks->up[r].message.data);
    free(ranks->down.message.data);
    if (ranks->together) {
        weft_queue_clear(&ranks->queue);
        weft_talk_clear(&ranks->talk);
    }
    free(ranks->hosts);
    free(ranks->threads);
    free(ranks->parts);
    free(ranks->bye);
    free(ranks->up);
    free(ranks->down_message);
    pthread_mutex_destroy(&ranks->lock);
    pthread_cond_destroy(&ranks->changed);
    pthread_cond_destroy(&ranks->posted);
    free(ranks);
}

static bool is_transport(const struct weft_transport *t)
{
    return t->size >= 1 && t->threads >= 1 && t->rank >= 0 && t->rank < t->size && t->node >= 0 &&
           t->node <= t->rank && t->node_size >= 1 && t->node_rank >= 0 &&
           t->node_rank < t->node_size &&
           (t->size == 1 || (t->send && t->sent && t->probe && t->take && t->abort));
}

enum weft_result weft_distribute_over(const struct weft_transport *transport,
                                      const struct weft_distribute_params *params, weft_body body,
                                      void *priv)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    const double timeout =
        params->timeout == 0.0 ? default_timeout : params->timeout;
    weft_require(params->log, body);
    weft_require(params->log, is_timeout(timeout));
    weft_require(params->log, !transport || is_transport(transport));
    res = WEFT_ERR_MEMORY;
    struct weft_ranks *ranks = calloc(1, sizeof *ranks);
    if (!ranks) {
        weft_error(params->log, "out of memory: ranks");
        goto fail;
    }
    ranks->queue.failed_rank = -1;
    ranks->params = *params;
    ranks->params.timeout = timeout;
    ranks->params.exit_code = params->exit_code ? params->exit_code : 1;
    init_locks(ranks);
    init_info(ranks, transport);
    if (!transport || transport->size == 1)
        res = body(priv, ranks);
    else if ((res = init_together(ranks, transport)) != WEFT_OK)
        weft_error(params->log, "out of memory: %d ranks", transport->size);
    else
        res = run_together(ranks, &(struct body){ranks, body, priv, WEFT_OK});
    clear(ranks);
fail:
    return res;
}
