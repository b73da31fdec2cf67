// SPDX-License-Identifier: BSD-3-Clause
#include "passes/distribute/talk.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"

enum weft_result weft_talk_init(struct weft_talk *talk, const struct weft_transport *transport)
{
    const size_t size = (size_t)transport->size;
    talk->transport = transport;
    talk->watched = -1;
    talk->in = calloc(size, sizeof *talk->in);
    talk->out = calloc(size, sizeof *talk->out);
    talk->scratch = malloc(WEFT_TRANSPORT_MAX);
    return talk->in && talk->out && talk->scratch ? WEFT_OK : WEFT_ERR_MEMORY;
}

static void free_owned(const struct weft_messages *list)
{
    for (struct weft_outgoing *m = list->first; m; m = m->next)
        free(m->owned);
}

void weft_talk_clear(struct weft_talk *talk)
{
    const int size = talk->transport ? talk->transport->size : 0;
    for (int r = 0; r < size && talk->in; r++)
        free(talk->in[r].data);
    for (int r = 0; r < size && talk->out; r++)
        free_owned(&talk->out[r]);
    free_owned(&talk->posted);
    free(talk->in);
    free(talk->out);
    free(talk->scratch);
    *talk = (struct weft_talk){0};
}

// ---- sending ------------------------------------------------------------------------------------

static void append(struct weft_messages *list, struct weft_outgoing *message)
{
    message->next = NULL;
    if (list->last)
        list->last->next = message;
    else
        list->first = message;
    list->last = message;
}

static struct weft_outgoing *remove_first(struct weft_messages *list)
{
    struct weft_outgoing *first = list->first;
    list->first = first->next;
    if (!list->first)
        list->last = NULL;
    return first;
}

void weft_talk_post(struct weft_talk *talk, struct weft_outgoing *message, int to,
                    const struct weft_head *head, const void *data, void *owned)
{
    const bool few = head->size <= WEFT_FEW_BYTES;
    *message = (struct weft_outgoing){
        .busy = true,
        .to = to,
        .first.head = *head,
        .data = data,
        .owned = owned,
        .begun = few ? (size_t)head->size : 0,
    };
    if (few && head->size > 0)
        memcpy(message->first.bytes, data, (size_t)head->size);
    append(&talk->posted, message);
    talk->stirred = talk->stirred || head->kind != WEFT_MESSAGE_ALIVE;
}

static void take_posted(struct weft_talk *talk)
{
    pthread_mutex_lock(talk->lock);
    while (talk->posted.first) {
        struct weft_outgoing *message = remove_first(&talk->posted);
        append(&talk->out[message->to], message);
        talk->to_send++;
    }
    pthread_mutex_unlock(talk->lock);
}

bool weft_talk_is_under_way(const struct weft_talk *talk)
{
    return talk->to_send > 0 || talk->open > 0;
}

bool weft_talk_is_done(const struct weft_talk *talk)
{
    return talk->to_send == 0 && !talk->posted.first;
}

static bool send_piece(struct weft_talk *talk, struct weft_outgoing *m, const void *data,
                       size_t size)
{
    const struct weft_transport *t = talk->transport;
    if (t->send(t->priv, m->to, data, size, &m->request[m->pieces])) {
        m->pieces++;
        return true;
    }
    (void)snprintf(talk->fault, sizeof talk->fault, "cannot send to rank %d", m->to);
    return false;
}

// Begins what may be under way at once.
static bool begin(struct weft_talk *talk, struct weft_outgoing *m)
{
    bool moved = false;
    const size_t size = (size_t)m->first.head.size;
    if (!m->begun_first) {
        if (!send_piece(talk, m, &m->first, sizeof m->first.head + m->begun))
            return false;
        m->begun_first = moved = true;
    }
    while (m->begun < size && m->pieces < WEFT_PIECES_UNDER_WAY) {
        const size_t left = size - m->begun;
        const size_t piece = left < WEFT_TRANSPORT_MAX ? left : WEFT_TRANSPORT_MAX;
        if (!send_piece(talk, m, m->data + m->begun, piece))
            return false;
        m->begun += piece;
        moved = true;
    }
    return moved;
}

// Forgets the pieces that were sent.
static bool reap(const struct weft_transport *t, struct weft_outgoing *m)
{
    int left = 0;
    for (int i = 0; i < m->pieces; i++)
        if (!t->sent(t->priv, m->request[i]))
            m->request[left++] = m->request[i];
    const bool moved = left < m->pieces;
    m->pieces = left;
    return moved;
}

static bool send_to(struct weft_talk *talk, int to)
{
    bool moved = false;
    struct weft_outgoing *m;
    while ((m = talk->out[to].first) && !talk->fault[0]) {
        moved |= begin(talk, m);
        moved |= reap(talk->transport, m);
        if (m->pieces > 0 || m->begun < m->first.head.size || !m->begun_first)
            break;
        remove_first(&talk->out[to]);
        talk->to_send--;
        free(m->owned);
        m->owned = NULL;
        pthread_mutex_lock(talk->lock);
        m->busy = false;
        pthread_mutex_unlock(talk->lock);
    }
    return moved;
}

// ---- taking -------------------------------------------------------------------------------------

static void misunderstand(struct weft_talk *talk, int from, int64_t size)
{
    (void)snprintf(talk->fault, sizeof talk->fault,
                   "cannot understand what came of rank %d, %lld bytes", from, (long long)size);
}

static void complete(struct weft_talk *talk, int from)
{
    struct weft_incoming *in = &talk->in[from];
    pthread_mutex_lock(talk->lock);
    talk->stirred = talk->stirred || in->head.kind != WEFT_MESSAGE_ALIVE;
    talk->deliver(talk->priv, from, in);
    pthread_mutex_unlock(talk->lock);
    free(in->data);
    talk->open -= in->open;
    *in = (struct weft_incoming){0};
}

static bool take_first(struct weft_talk *talk, int from, size_t size)
{
    const struct weft_transport *t = talk->transport;
    struct weft_incoming *in = &talk->in[from];
    struct weft_first first;
    if (size < sizeof first.head || size > sizeof first || !t->take(t->priv, from, &first, size))
        return false;
    const size_t bytes = size - sizeof first.head;
    const bool few = first.head.size <= WEFT_FEW_BYTES;
    if ((unsigned)first.head.kind >= WEFT_MESSAGE_KINDS || bytes != (few ? first.head.size : 0))
        return false;
    *in = (struct weft_incoming){.head = first.head, .open = !few};
    talk->open += in->open;
    in->data = first.head.size > 0 ? malloc((size_t)first.head.size) : NULL;
    in->lost = first.head.size > 0 && !in->data;
    if (bytes > 0 && in->data)
        memcpy(in->data, first.bytes, bytes);
    if (few)
        complete(talk, from);
    return true;
}

static bool take_piece(struct weft_talk *talk, int from, size_t size)
{
    const struct weft_transport *t = talk->transport;
    struct weft_incoming *in = &talk->in[from];
    if (size == 0 || size > WEFT_TRANSPORT_MAX || size > in->head.size - in->filled ||
        !t->take(t->priv, from, in->data ? in->data + in->filled : talk->scratch, size))
        return false;
    in->filled += size;
    if (in->filled == in->head.size)
        complete(talk, from);
    return true;
}

bool weft_talk_move(struct weft_talk *talk)
{
    const struct weft_transport *t = talk->transport;
    bool moved = false;
    int from = 0;
    int64_t size;
    while (!talk->fault[0] && (size = t->probe(t->priv, &from)) >= 0) {
        const bool good = talk->in[from].open ? take_piece(talk, from, (size_t)size)
                                              : take_first(talk, from, (size_t)size);
        if (!good)
            misunderstand(talk, from, size);
        moved = true;
        talk->heard = talk->heard || from == talk->watched;
    }
    take_posted(talk);
    for (int to = 0; to < t->size && talk->to_send > 0; to++)
        if (talk->out[to].first)
            moved |= send_to(talk, to);
    return moved;
}
