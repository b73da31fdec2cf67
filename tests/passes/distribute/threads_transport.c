// SPDX-License-Identifier: BSD-3-Clause
#include "tests/passes/distribute/threads_transport.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "filter/check.h"

enum { EAGER_BYTES = 4096 };

struct message {
    struct message *next, *older;
    const void *data; // the sender's, of a large one
    char *copy;       // of a small one
    size_t size;
    double due;
    bool taken; // of a large one: then it was sent
};

struct world;

struct rank {
    struct world *world;
    struct weft_transport transport;
    pthread_t thread;
    char host[16];
    unsigned state;
    int sends;
    bool stopped;
};

struct world {
    const struct threads_params *params;
    struct threads_outcome *out;
    pthread_mutex_t lock;
    struct rank rank[THREADS_RANKS_MAX];
    struct message *queue[THREADS_RANKS_MAX][THREADS_RANKS_MAX]; // to, from
    struct message *all;                                         // freed at the end
    bool aborted;
    double stop_until; // of all
};

static atomic_int faults;

void threads_check(bool good, const char *file, int line, const char *what)
{
    if (good)
        return;
    atomic_fetch_add(&faults, 1);
    (void)fprintf(stderr, "%s, line %d: %s\n", file, line, what);
}

int threads_faults(void)
{
    return atomic_load(&faults);
}

static void must(bool condition, const char *what)
{
    if (condition)
        return;
    (void)fprintf(stderr, "a transport is used as its header does not allow: %s\n", what);
    abort();
}

static void sleep_a_while(void)
{
    nanosleep(&(struct timespec){0, 2000000}, NULL);
}

static double draw(struct rank *rank)
{
    return rand_r(&rank->state) / (double)RAND_MAX;
}

// Every call of a rank that is stopped lasts until it goes on.
static void stay_stopped(struct rank *rank)
{
    struct world *w = rank->world;
    const struct threads_params *p = w->params;
    pthread_mutex_lock(&w->lock);
    if (rank->transport.rank == p->stopping_rank - 1 && rank->sends >= p->sends_before &&
        !rank->stopped) {
        rank->stopped = true;
        const double until = p->stop_seconds > 0.0 ? weft_now_seconds() + p->stop_seconds : 1e300;
        if (p->stop_all)
            w->stop_until = until;
        while (!w->aborted && weft_now_seconds() < until) {
            pthread_mutex_unlock(&w->lock);
            sleep_a_while();
            pthread_mutex_lock(&w->lock);
        }
    }
    while (!w->aborted && weft_now_seconds() < w->stop_until) {
        pthread_mutex_unlock(&w->lock);
        sleep_a_while();
        pthread_mutex_lock(&w->lock);
    }
    pthread_mutex_unlock(&w->lock);
}

static bool send_message(void *priv, int to, const void *data, size_t size, void **request)
{
    struct rank *rank = priv;
    struct world *w = rank->world;
    const int from = rank->transport.rank;
    must(size > 0 && size <= WEFT_TRANSPORT_MAX, "a message's size");
    must(to >= 0 && to < w->params->ranks && to != from, "who it is for");
    rank->sends++;
    stay_stopped(rank);
    pthread_mutex_lock(&w->lock);
    bool good = !w->aborted &&
                !(from == w->params->failing_rank - 1 && rank->sends > w->params->sends_before);
    struct message *m = good ? calloc(1, sizeof *m) : NULL;
    if (m) {
        m->data = data;
        m->size = size;
        m->due = weft_now_seconds() + draw(rank) * w->params->delay;
        m->taken = size <= EAGER_BYTES;
        if (m->taken) {
            m->copy = malloc(size);
            memcpy(m->copy, data, size);
        }
        struct message **end = &w->queue[to][from];
        for (; *end; end = &(*end)->next)
            m->due = (*end)->due > m->due ? (*end)->due : m->due;
        *end = m;
        m->older = w->all;
        w->all = m;
    }
    // A small one is sent now or later; of a large one it is not known before it was taken.
    *request = m && !m->taken ? m : NULL;
    pthread_mutex_unlock(&w->lock);
    return good;
}

static bool was_sent(void *priv, void *request)
{
    struct rank *rank = priv;
    struct message *m = request;
    stay_stopped(rank);
    if (!m)
        return draw(rank) < 0.7;
    pthread_mutex_lock(&rank->world->lock);
    const bool taken = m->taken;
    pthread_mutex_unlock(&rank->world->lock);
    return taken;
}

static int64_t probe(void *priv, int *from)
{
    struct rank *rank = priv;
    struct world *w = rank->world;
    const int ranks = w->params->ranks, first = (int)(draw(rank) * ranks);
    int64_t size = -1;
    stay_stopped(rank);
    const double now = weft_now_seconds();
    pthread_mutex_lock(&w->lock);
    for (int i = 0; i < ranks && size < 0 && !w->aborted; i++) {
        const struct message *m = w->queue[rank->transport.rank][(first + i) % ranks];
        if (m && m->due <= now) {
            *from = (first + i) % ranks;
            size = (int64_t)m->size;
        }
    }
    pthread_mutex_unlock(&w->lock);
    return size;
}

static bool take(void *priv, int from, void *data, size_t size)
{
    struct rank *rank = priv;
    struct world *w = rank->world;
    stay_stopped(rank);
    pthread_mutex_lock(&w->lock);
    struct message *m = w->queue[rank->transport.rank][from];
    must(w->aborted || (m && m->size == size), "what is taken");
    const bool good = !w->aborted;
    if (good) {
        w->queue[rank->transport.rank][from] = m->next;
        memcpy(data, m->copy ? m->copy : m->data, size);
        free(m->copy);
        m->copy = NULL;
        m->taken = true;
    }
    pthread_mutex_unlock(&w->lock);
    return good;
}

static void end_all(void *priv, int exit_code)
{
    struct rank *rank = priv;
    struct world *w = rank->world;
    pthread_mutex_lock(&w->lock);
    if (!w->aborted)
        w->out->exit_code = exit_code;
    w->aborted = true;
    pthread_mutex_unlock(&w->lock);
}

// What is said because all were ended already does not count.
static void note_line(void *priv, const char *line)
{
    struct rank *rank = priv;
    struct world *w = rank->world;
    pthread_mutex_lock(&w->lock);
    if (!w->aborted && w->out->lines++ == 0) {
        (void)snprintf(w->out->line, sizeof w->out->line, "%s", line);
        w->out->line_rank = rank->transport.rank;
    }
    pthread_mutex_unlock(&w->lock);
}

static void *run_rank(void *priv)
{
    struct rank *rank = priv;
    const struct threads_params *p = rank->world->params;
    const int r = rank->transport.rank;
    rank->world->out->result[r] = weft_distribute_over(
        &rank->transport,
        weft_distribute_params(.timeout = p->timeout ? p->timeout : 60.0, .lost = note_line,
                               .priv = rank, .exit_code = 7, .log = r == 0 ? p->log : NULL),
        p->body, p->priv[r]);
    return NULL;
}

static int discard(struct world *w)
{
    int left = 0;
    for (int to = 0; to < THREADS_RANKS_MAX; to++)
        for (int from = 0; from < THREADS_RANKS_MAX; from++)
            for (const struct message *m = w->queue[to][from]; m; m = m->next)
                left++;
    for (struct message *m = w->all, *older; m; m = older) {
        older = m->older;
        free(m->copy);
        free(m);
    }
    return left;
}

void threads_run(const struct threads_params *params, struct threads_outcome *out)
{
    struct world *w = calloc(1, sizeof *w);
    must(w && params->ranks >= 1 && params->ranks <= THREADS_RANKS_MAX, "the number of ranks");
    w->params = params;
    w->out = out;
    w->stop_until = -1e300;
    *out = (struct threads_outcome){.exit_code = -1, .line_rank = -1};
    pthread_mutex_init(&w->lock, NULL);
    const double begun = weft_now_seconds();
    const int node = params->node_ranks ? params->node_ranks : params->ranks;
    for (int r = 0; r < params->ranks; r++) {
        struct rank *rank = &w->rank[r];
        (void)snprintf(rank->host, sizeof rank->host, "node%d", r / node);
        rank->world = w;
        rank->state = params->seed * 7919u + (unsigned)r;
        rank->transport = (struct weft_transport){
            .rank = r,
            .size = params->ranks,
            .node = r - r % node,
            .node_rank = r % node,
            .node_size = node,
            .threads = r + 1,
            .host = rank->host,
            .priv = rank,
            .send = send_message,
            .sent = was_sent,
            .probe = probe,
            .take = take,
            .abort = end_all,
        };
    }
    for (int r = 0; r < params->ranks; r++)
        pthread_create(&w->rank[r].thread, NULL, run_rank, &w->rank[r]);
    for (int r = 0; r < params->ranks; r++)
        pthread_join(w->rank[r].thread, NULL);
    out->seconds = weft_now_seconds() - begun;
    const int left = discard(w);
    out->left = w->aborted ? 0 : left;
    pthread_mutex_destroy(&w->lock);
    free(w);
}
