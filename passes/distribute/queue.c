// SPDX-License-Identifier: BSD-3-Clause
#include "passes/distribute/queue.h"

#include <stdlib.h>

#include "filter/check.h"

enum weft_result weft_queue_init(struct weft_queue *queue, struct weft_talk *talk)
{
    queue->talk = talk;
    queue->rank = talk->transport->rank;
    queue->size = talk->transport->size;
    queue->failed_rank = -1;
    if (queue->rank == 0)
        queue->other = calloc((size_t)queue->size, sizeof *queue->other);
    return queue->rank != 0 || queue->other ? WEFT_OK : WEFT_ERR_MEMORY;
}

void weft_queue_clear(struct weft_queue *queue)
{
    int from;
    struct weft_queue_result result;
    while (weft_queue_get_result(queue, &from, &result))
        free(result.data);
    free(queue->other);
    queue->other = NULL;
}

void weft_queue_end_work(struct weft_queue *queue)
{
    for (int r = 1; queue->other && r < queue->size; r++) {
        struct weft_queue_rank *other = &queue->other[r];
        other->asks = other->stops = false;
        other->taken = other->taken_bytes = 0;
    }
    queue->stopped = queue->open = queue->answered = queue->owes = false;
    queue->failed_rank = -1;
    queue->done = 0;
    queue->lacks = 0;
    queue->untaken = queue->untaken_bytes = 0;
}

// ---- failures -----------------------------------------------------------------------------------

static void stop_all(struct weft_queue *queue)
{
    for (int r = 1; !queue->stopped && r < queue->size; r++)
        queue->other[r].stops = queue->owes = true;
    queue->stopped = true;
}

static void note_failure(struct weft_queue *queue, int64_t item, enum weft_result result, int rank)
{
    if (queue->failed_rank < 0 || item < queue->failed_item) {
        queue->failed_rank = rank;
        queue->failed_item = item;
        queue->failed = result;
    }
    if (queue->rank == 0)
        stop_all(queue);
    queue->stopped = true;
}

void weft_queue_fail(struct weft_queue *queue, int64_t item, enum weft_result result)
{
    if (queue->rank != 0 && !queue->failure.busy) {
        const struct weft_head head = {
            .kind = WEFT_MESSAGE_RESULT, .code = (int32_t)result, .item = item};
        weft_talk_post(queue->talk, &queue->failure, 0, &head, NULL, NULL);
    }
    note_failure(queue, item, result, queue->rank);
}

// ---- what has come ------------------------------------------------------------------------------

static void receive_result(struct weft_queue *queue, int from, struct weft_incoming *in)
{
    struct weft_queue_rank *other = &queue->other[from];
    const size_t size = (size_t)in->head.size;
    if (in->head.code != WEFT_OK) {
        note_failure(queue, in->head.item, (enum weft_result)in->head.code, from);
        return;
    }
    queue->done++;
    if (size == 0)
        return;
    if (in->lost || other->waiting == WEFT_QUEUE_RESULTS) {
        queue->lacks = size;
        note_failure(queue, in->head.item, WEFT_ERR_MEMORY, 0);
        weft_queue_note_taken(queue, from, size);
        return;
    }
    queue->waiting++;
    other->result[(other->first + other->waiting++) % WEFT_QUEUE_RESULTS] =
        (struct weft_queue_result){.item = in->head.item, .size = size, .data = in->data};
    in->data = NULL;
}

static void receive_control(struct weft_queue *queue, const struct weft_head *head)
{
    queue->untaken -= head->value[0];
    queue->untaken_bytes -= head->value[1];
    if (head->code & WEFT_CONTROL_GIVES) {
        queue->answered = true;
        queue->answer = head->item;
    }
    if (head->code & WEFT_CONTROL_STOPS)
        queue->stopped = true;
}

void weft_queue_deliver(struct weft_queue *queue, int from, struct weft_incoming *in)
{
    if (in->head.kind == WEFT_MESSAGE_CONTROL)
        receive_control(queue, &in->head);
    else if (queue->rank == 0 && in->head.kind == WEFT_MESSAGE_ASK)
        queue->other[from].asks = queue->owes = true;
    else if (queue->rank == 0 && in->head.kind == WEFT_MESSAGE_RESULT)
        receive_result(queue, from, in);
}

// ---- rank 0 -------------------------------------------------------------------------------------

void weft_queue_open(struct weft_queue *queue, const int64_t *order, int64_t count)
{
    queue->open = queue->owes = true;
    queue->order = order;
    queue->next = 0;
    queue->count = count;
}

int64_t weft_queue_next(struct weft_queue *queue)
{
    if (queue->stopped || queue->next >= queue->count)
        return WEFT_NO_ITEM;
    const int64_t at = queue->next++;
    return queue->order ? queue->order[at] : at;
}

bool weft_queue_tell(struct weft_queue *queue)
{
    bool told = false, owes = false;
    for (int r = 1; queue->owes && r < queue->size; r++) {
        struct weft_queue_rank *other = &queue->other[r];
        const bool gives = other->asks && queue->open;
        if (!gives && !other->stops && other->taken == 0)
            continue;
        if (other->control.busy) {
            owes = true;
            continue;
        }
        const struct weft_head head = {
            .kind = WEFT_MESSAGE_CONTROL,
            .code = (gives ? WEFT_CONTROL_GIVES : 0) | (other->stops ? WEFT_CONTROL_STOPS : 0),
            .item = gives ? weft_queue_next(queue) : WEFT_NO_ITEM,
            .value = {other->taken, other->taken_bytes},
        };
        weft_talk_post(queue->talk, &other->control, r, &head, NULL, NULL);
        other->asks = other->asks && !gives;
        other->stops = false;
        other->taken = other->taken_bytes = 0;
        told = true;
    }
    queue->owes = owes;
    return told;
}

bool weft_queue_get_result(struct weft_queue *queue, int *from, struct weft_queue_result *out)
{
    for (int i = 0; queue->waiting > 0 && i < queue->size; i++) {
        const int r = (queue->turn + i) % queue->size;
        struct weft_queue_rank *other = &queue->other[r];
        if (other->waiting == 0)
            continue;
        *from = r;
        *out = other->result[other->first];
        other->first = (other->first + 1) % WEFT_QUEUE_RESULTS;
        other->waiting--;
        queue->waiting--;
        queue->turn = r + 1;
        return true;
    }
    return false;
}

void weft_queue_note_taken(struct weft_queue *queue, int from, size_t size)
{
    queue->other[from].taken++;
    queue->other[from].taken_bytes += size;
    queue->owes = true;
}

// ---- other ranks --------------------------------------------------------------------------------

void weft_queue_ask(struct weft_queue *queue)
{
    const struct weft_head head = {.kind = WEFT_MESSAGE_ASK};
    queue->answered = false;
    weft_talk_post(queue->talk, &queue->ask, 0, &head, NULL, NULL);
}

static struct weft_outgoing *find_free(const struct weft_queue *queue)
{
    for (int i = 0; i < WEFT_QUEUE_RESULTS; i++)
        if (!queue->result[i].busy)
            return (struct weft_outgoing *)&queue->result[i];
    return NULL;
}

bool weft_queue_has_room(const struct weft_queue *queue, size_t size)
{
    if (!find_free(queue))
        return false;
    if (size == 0 || queue->untaken < 2)
        return true;
    return queue->untaken < WEFT_QUEUE_RESULTS && size <= WEFT_QUEUE_BYTES &&
           queue->untaken_bytes <= WEFT_QUEUE_BYTES - size;
}

void weft_queue_send_result(struct weft_queue *queue, int64_t item, void *data, size_t size)
{
    const struct weft_head head = {.kind = WEFT_MESSAGE_RESULT, .item = item, .size = size};
    queue->untaken += size > 0;
    queue->untaken_bytes += size;
    weft_talk_post(queue->talk, find_free(queue), 0, &head, data, data);
}
