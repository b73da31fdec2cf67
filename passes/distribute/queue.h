// SPDX-License-Identifier: BSD-3-Clause
// passes/distribute/queue.h - items on their way between ranks: those that rank 0 hands out, and
// what came of those that others did (not installed). Thread-safety: all of it under the ranks'
// lock; both threads of a rank call it.
#ifndef WEFT_PASSES_DISTRIBUTE_QUEUE_H
#define WEFT_PASSES_DISTRIBUTE_QUEUE_H

#include "passes/distribute/talk.h"

// Results of a rank that may wait to be taken, and their bytes, unless there are but two.
enum { WEFT_QUEUE_RESULTS = 64, WEFT_QUEUE_BYTES = 4 << 20 };

enum { WEFT_NO_ITEM = -1 }; // all were given
// weft_head.code of WEFT_MESSAGE_CONTROL; value: results that were taken, and their bytes.
enum { WEFT_CONTROL_GIVES = 1, WEFT_CONTROL_STOPS = 2 };

struct weft_queue_result {
    int64_t item;
    size_t size;
    char *data;
};

// What rank 0 has of another rank.
struct weft_queue_rank {
    bool asks;                   // for an item
    bool stops;                  // that work ends is to be told
    uint64_t taken, taken_bytes; // to be told
    struct weft_outgoing control;
    struct weft_queue_result result[WEFT_QUEUE_RESULTS]; // a ring
    int first, waiting;
};

struct weft_queue {
    struct weft_talk *talk;
    int rank, size;
    // Of the work that is under way, or that this rank has not begun yet.
    bool stopped;            // no item is to be begun any more
    int failed_rank;         // -1: none
    int64_t failed_item;     // the lowest of those that failed
    enum weft_result failed; // its result

    // Rank 0.
    struct weft_queue_rank *other; // [size]
    bool open;                     // items are given to who asks
    const int64_t *order;          // NULL: as they are numbered
    int64_t next, count;
    int64_t done; // items of others
    bool owes;    // somebody is to be told something
    int waiting;  // results of all
    size_t lacks; // bytes of a result that there was no memory for
    int turn;     // whose results are looked at first

    // Other ranks.
    struct weft_outgoing ask, result[WEFT_QUEUE_RESULTS], failure;
    bool answered;
    int64_t answer;
    uint64_t untaken, untaken_bytes;
};

// Returns WEFT_ERR_MEMORY; what was made then is freed by weft_queue_clear.
enum weft_result weft_queue_init(struct weft_queue *queue, struct weft_talk *talk);
void weft_queue_clear(struct weft_queue *queue);

// A message of WEFT_MESSAGE_ASK, _RESULT or _CONTROL has come.
void weft_queue_deliver(struct weft_queue *queue, int from, struct weft_incoming *in);
// Work has failed at an item (INT64_MAX: at none), on this rank; no item is begun any more.
void weft_queue_fail(struct weft_queue *queue, int64_t item, enum weft_result result);
// All have done their items: nothing of this work is remembered.
void weft_queue_end_work(struct weft_queue *queue);

// ---- rank 0 -------------------------------------------------------------------------------------

// Items are given from now on to who asks, and by weft_queue_next; order is borrowed, may be NULL.
void weft_queue_open(struct weft_queue *queue, const int64_t *order, int64_t count);
int64_t weft_queue_next(struct weft_queue *queue);
// Tells others what is to be told to them, as far as messages are free. Returns whether it did.
bool weft_queue_tell(struct weft_queue *queue);
// A result that waits; false: none. Its bytes are the caller's to free.
bool weft_queue_get_result(struct weft_queue *queue, int *from, struct weft_queue_result *out);
void weft_queue_note_taken(struct weft_queue *queue, int from, size_t size);

// ---- other ranks --------------------------------------------------------------------------------

void weft_queue_ask(struct weft_queue *queue);
// Whether a result of so many bytes may be sent now.
bool weft_queue_has_room(const struct weft_queue *queue, size_t size);
// Tells rank 0 that an item was done; data, allocated, is taken over.
void weft_queue_send_result(struct weft_queue *queue, int64_t item, void *data, size_t size);

#endif
