// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/output/order.h"

#include <pthread.h>
#include <stdlib.h>

#include "filter/threads.h"

// All under the lock.
struct run {
    const struct weft_order *order;
    pthread_mutex_t lock;
    pthread_cond_t changed; // something was taken, or failed
    bool *ready;            // of each slot
    size_t taken;
    bool taking, failed;
};

// With the lock, which is given up while an item is taken.
static void take_ready(struct run *r)
{
    const struct weft_order *o = r->order;
    while (!r->taking && !r->failed && r->ready[r->taken % o->slots]) {
        const size_t i = r->taken;
        r->taking = true;
        pthread_mutex_unlock(&r->lock);
        const bool good = o->take(o->priv, i, i % o->slots);
        pthread_mutex_lock(&r->lock);
        r->taking = false;
        r->ready[i % o->slots] = false;
        r->taken++;
        r->failed = r->failed || !good;
        pthread_cond_broadcast(&r->changed);
    }
}

// Returns whether the item's slot is free. It becomes so: items are begun in order, so the one that
// is to be taken next waits for nobody.
static bool wait_for_slot(struct run *r, size_t i, size_t *taken)
{
    pthread_mutex_lock(&r->lock);
    while (!r->failed && i - r->taken >= r->order->slots)
        pthread_cond_wait(&r->changed, &r->lock);
    const bool failed = r->failed;
    *taken = r->taken;
    pthread_mutex_unlock(&r->lock);
    return !failed;
}

static bool make_item(void *priv, int thread, size_t i)
{
    struct run *r = priv;
    const struct weft_order *o = r->order;
    size_t taken;
    bool good = wait_for_slot(r, i, &taken);
    if (good && thread == 0 && o->ask)
        good = o->ask(o->priv, taken);
    good = good && o->make(o->priv, thread, i, i % o->slots);
    pthread_mutex_lock(&r->lock);
    r->ready[i % o->slots] = good;
    if (good) {
        take_ready(r);
    } else {
        r->failed = true;
        pthread_cond_broadcast(&r->changed);
    }
    good = !r->failed;
    pthread_mutex_unlock(&r->lock);
    return good;
}

bool weft_order_run(const struct weft_order *order)
{
    struct run r = {.order = order, .ready = calloc(order->slots, sizeof *r.ready)};
    if (!r.ready)
        return false;
    pthread_mutex_init(&r.lock, NULL);
    pthread_cond_init(&r.changed, NULL);
    const bool good = weft_threads_run(order->threads, order->count, make_item, &r) && !r.failed;
    pthread_cond_destroy(&r.changed);
    pthread_mutex_destroy(&r.lock);
    free(r.ready);
    return good;
}
