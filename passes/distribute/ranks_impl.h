// SPDX-License-Identifier: BSD-3-Clause
// passes/distribute/ranks_impl.h - what a rank knows of all (not installed).
// Two threads share it, the one that talks and that of the body, under its lock. Rank 0 is the
// middle: others talk to it, and it to them; signs of life alone go round in a ring.
#ifndef WEFT_PASSES_DISTRIBUTE_RANKS_IMPL_H
#define WEFT_PASSES_DISTRIBUTE_RANKS_IMPL_H

#include <pthread.h>

#include "filter/check.h"
#include "passes/distribute/life.h"
#include "passes/distribute/queue.h"
#include "passes/distribute/ranks.h"
#include "passes/distribute/talk.h"

// A message of what all do together, until the body wants it.
struct weft_letter {
    bool full;
    struct weft_incoming message;
};

struct weft_ranks {
    struct weft_distribute_params params;
    struct weft_ranks_info info; // timeout under the lock, the rest is set before the body runs
    char host[64];
    char (*hosts)[64];             // rank 0: of all ranks; NULL where there are no others
    int *threads;                  // rank 0: of all ranks, likewise
    struct weft_ranks_part *parts; // rank 0: room for what it gathers for itself
    bool together;                 // there are others: what follows is used

    pthread_mutex_t lock;
    pthread_cond_t changed; // for the body: something came, or was sent
    pthread_cond_t posted;  // for the thread that talks: there is something to send
    struct weft_talk talk;
    struct weft_life life;
    struct weft_queue queue;

    bool waits;     // the body does, for something that is to come
    bool lost;      // the job has ended but for this process
    bool body_done; // on this rank
    bool ending;    // on all ranks, known to this one
    bool said_bye, said_last;
    bool *bye; // rank 0: whose body has ended

    struct weft_letter *up; // rank 0: [size], at most one of each rank
    struct weft_letter down;
    struct weft_outgoing up_message, *down_message; // [size]
    struct weft_outgoing bye_message, last_message;
    char wrong[160]; // what the ranks do not do alike; else empty
};

// With the lock: waits until one of them is signalled, at most so many seconds.
void weft_ranks_wait(struct weft_ranks *ranks, pthread_cond_t *condition, double seconds);

// Likewise, for the body, until something has come or was sent.
void weft_ranks_await_change(struct weft_ranks *ranks);

// The first that all do together: rank 0 learns of the nodes.
enum weft_result weft_ranks_settle(struct weft_ranks *ranks);

// What is asked of the ranks once the job has ended returns this.
#define WEFT_RANKS_LOST WEFT_ERR_CANCELLED

// ---- letters: what all do together --------------------------------------------------------------

// For the body, without the lock. `step` tells one thing that they do from another; where ranks are
// at different ones, or one has ended, the job ends. False: it has.
enum weft_step {
    WEFT_STEP_SHARE,
    WEFT_STEP_GATHER,
    WEFT_STEP_AGREE,
    WEFT_STEP_COMPARE,
    WEFT_STEP_ITEMS
};
// To rank 0. data is borrowed until the answer has come.
void weft_ranks_send_up(struct weft_ranks *ranks, enum weft_step step, const struct weft_head *head,
                        const void *data);
// Rank 0: whether a rank's letter has come; with the lock.
bool weft_ranks_has_up(struct weft_ranks *ranks, int from, enum weft_step step);
// Rank 0: the letter of a rank. Its bytes are the caller's to free.
bool weft_ranks_await_up(struct weft_ranks *ranks, int from, enum weft_step step,
                         struct weft_incoming *out);
void weft_ranks_send_down(struct weft_ranks *ranks, int to, enum weft_step step,
                          const struct weft_head *head, const void *data);
// Rank 0: until what it borrowed was sent.
bool weft_ranks_await_sent(struct weft_ranks *ranks);
bool weft_ranks_await_down(struct weft_ranks *ranks, enum weft_step step,
                           struct weft_incoming *out);
// Rank 0 tells all what came of it (failed: which rank, -1: none), and returns that; others hear
// it.
enum weft_result weft_ranks_conclude(struct weft_ranks *ranks, enum weft_step step,
                                     enum weft_result result, int failed);
enum weft_result weft_ranks_hear(struct weft_ranks *ranks, enum weft_step step, int *failed);

#endif
