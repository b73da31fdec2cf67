// SPDX-License-Identifier: BSD-3-Clause
#include "passes/distribute/schedule/load.h"

#include <stdlib.h>
#include <string.h>

enum weft_result weft_load_create(int ranks, struct weft_load *out)
{
    *out = (struct weft_load){0};
    if (ranks < 1)
        return WEFT_ERR_ARGUMENT;
    out->rank = calloc((size_t)ranks, sizeof *out->rank);
    if (!out->rank)
        return WEFT_ERR_MEMORY;
    out->ranks = ranks;
    return WEFT_OK;
}

void weft_load_clear(struct weft_load *load)
{
    free(load->rank);
    *load = (struct weft_load){0};
}

void weft_load_add(struct weft_load *load, const struct weft_load *other)
{
    load->seconds += other->seconds;
    for (int r = 0; r < load->ranks && r < other->ranks; r++) {
        struct weft_rank_load *to = &load->rank[r];
        const struct weft_rank_load *from = &other->rank[r];
        to->busy += from->busy;
        to->taking += from->taking;
        to->items += from->items;
        to->bytes += from->bytes;
        if (!to->threads)
            to->threads = from->threads;
        if (!to->host[0])
            memcpy(to->host, from->host, sizeof to->host);
    }
}

void weft_load_compute(const struct weft_load *load, struct weft_load_figures *out)
{
    *out = (struct weft_load_figures){.imbalance = 1.0};
    double busy = 0.0;
    for (int r = 0; r < load->ranks; r++) {
        busy += load->rank[r].busy;
        if (load->rank[r].busy > out->largest_busy)
            out->largest_busy = load->rank[r].busy;
    }
    if (busy > 0.0) {
        out->mean_busy = busy / load->ranks;
        out->imbalance = out->largest_busy / out->mean_busy;
    }
    if (load->ranks > 0 && load->seconds > 0.0)
        out->idle_share = 1.0 - busy / (load->ranks * load->seconds);
}
