// SPDX-License-Identifier: BSD-3-Clause
#include "passes/distribute/ranks_impl.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static const char *const step_names[] = {"share", "gather", "agree", "compare", "do_items"};

void weft_ranks_wait(struct weft_ranks *ranks, pthread_cond_t *condition, double seconds)
{
    struct timespec until;
    clock_gettime(CLOCK_MONOTONIC, &until);
    const int64_t at = until.tv_nsec + (int64_t)(seconds * 1e9);
    until.tv_sec += (time_t)(at / 1000000000);
    until.tv_nsec = (long)(at % 1000000000);
    pthread_cond_timedwait(condition, &ranks->lock, &until);
}

void weft_ranks_await_change(struct weft_ranks *ranks)
{
    ranks->waits = true;
    pthread_cond_signal(&ranks->posted);
    pthread_cond_wait(&ranks->changed, &ranks->lock);
    ranks->waits = false;
}

static void post(struct weft_ranks *ranks, struct weft_outgoing *message, int to, int kind,
                 enum weft_step step, const struct weft_head *head, const void *data)
{
    struct weft_head full = *head;
    full.kind = kind;
    full.value[1] = (uint64_t)step;
    pthread_mutex_lock(&ranks->lock);
    while (message->busy && !ranks->lost)
        weft_ranks_await_change(ranks);
    if (!ranks->lost)
        weft_talk_post(&ranks->talk, message, to, &full, data, NULL);
    pthread_cond_signal(&ranks->posted);
    pthread_mutex_unlock(&ranks->lock);
}

void weft_ranks_send_up(struct weft_ranks *ranks, enum weft_step step, const struct weft_head *head,
                        const void *data)
{
    post(ranks, &ranks->up_message, 0, WEFT_MESSAGE_UP, step, head, data);
}

void weft_ranks_send_down(struct weft_ranks *ranks, int to, enum weft_step step,
                          const struct weft_head *head, const void *data)
{
    post(ranks, &ranks->down_message[to], to, WEFT_MESSAGE_DOWN, step, head, data);
}

// Whether the letter is there and the right one; what is wrong ends the job.
static bool has_come(struct weft_ranks *ranks, const struct weft_letter *letter, int from,
                     enum weft_step step)
{
    const uint64_t other = letter->message.head.value[1];
    if (letter->full && other == (uint64_t)step)
        return true;
    if (letter->full && other < WEFT_COUNT(step_names))
        (void)snprintf(ranks->wrong, sizeof ranks->wrong,
                       "ranks do not do the same: rank %d is at %s, rank %d at %s",
                       ranks->info.rank, step_names[step], from, step_names[other]);
    else if (!letter->full && ranks->bye && ranks->bye[from])
        (void)snprintf(ranks->wrong, sizeof ranks->wrong,
                       "rank %d has ended while others wait for it at %s", from, step_names[step]);
    return false;
}

static bool await(struct weft_ranks *ranks, struct weft_letter *letter, int from,
                  enum weft_step step, struct weft_incoming *out)
{
    pthread_mutex_lock(&ranks->lock);
    while (!ranks->lost && (!has_come(ranks, letter, from, step) || ranks->up_message.busy))
        weft_ranks_await_change(ranks);
    const bool came = !ranks->lost;
    if (came) {
        *out = letter->message;
        *letter = (struct weft_letter){0};
    }
    pthread_mutex_unlock(&ranks->lock);
    return came;
}

bool weft_ranks_await_up(struct weft_ranks *ranks, int from, enum weft_step step,
                         struct weft_incoming *out)
{
    return await(ranks, &ranks->up[from], from, step, out);
}

bool weft_ranks_await_down(struct weft_ranks *ranks, enum weft_step step, struct weft_incoming *out)
{
    return await(ranks, &ranks->down, 0, step, out);
}

bool weft_ranks_has_up(struct weft_ranks *ranks, int from, enum weft_step step)
{
    return has_come(ranks, &ranks->up[from], from, step);
}

enum weft_result weft_ranks_conclude(struct weft_ranks *ranks, enum weft_step step,
                                     enum weft_result result, int failed)
{
    const struct weft_head head = {.code = (int32_t)result, .item = failed};
    for (int r = 1; r < ranks->info.size; r++)
        weft_ranks_send_down(ranks, r, step, &head, NULL);
    return result;
}

enum weft_result weft_ranks_hear(struct weft_ranks *ranks, enum weft_step step, int *failed)
{
    struct weft_incoming in;
    if (!weft_ranks_await_down(ranks, step, &in))
        return WEFT_RANKS_LOST;
    free(in.data);
    if (failed)
        *failed = (int)in.head.item;
    return (enum weft_result)in.head.code;
}

bool weft_ranks_await_sent(struct weft_ranks *ranks)
{
    pthread_mutex_lock(&ranks->lock);
    for (int r = 1; r < ranks->info.size; r++)
        while (ranks->down_message[r].busy && !ranks->lost)
            weft_ranks_await_change(ranks);
    const bool sent = !ranks->lost;
    pthread_mutex_unlock(&ranks->lock);
    return sent;
}
