// SPDX-License-Identifier: BSD-3-Clause
#include "passes/distribute/ranks_impl.h"

#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/threads.h"

// What a rank tells of itself.
struct introduction {
    char host[64];
    cpu_set_t processors; // that it may run on
};

static void introduce(const struct weft_ranks *ranks, struct introduction *own)
{
    memset(own, 0, sizeof *own);
    (void)snprintf(own->host, sizeof own->host, "%s", ranks->info.host);
    if (sched_getaffinity(0, sizeof own->processors, &own->processors) == 0)
        return;
    for (int i = 0; i < weft_threads_available() && i < CPU_SETSIZE; i++)
        CPU_SET(i, &own->processors);
}

// A processor that several ranks of a node may use is divided among them; what is left over of the
// same processors goes to the first of those ranks.
static int share_threads(const struct introduction *all, int size, int rank)
{
    const struct introduction *own = &all[rank];
    int same = 0, before = 0, users[CPU_SETSIZE] = {0};
    double share = 0.0;
    for (int r = 0; r < size; r++) {
        if (strcmp(all[r].host, own->host) != 0)
            continue;
        for (int i = 0; i < CPU_SETSIZE; i++)
            users[i] += CPU_ISSET(i, &all[r].processors) && CPU_ISSET(i, &own->processors);
        if (CPU_EQUAL(&all[r].processors, &own->processors)) {
            same++;
            before += r < rank;
        }
    }
    for (int i = 0; i < CPU_SETSIZE; i++)
        share += users[i] > 0 ? 1.0 / users[i] : 0.0;
    const int threads = (int)(share + (double)(same - 1 - before) / same + 1e-6);
    return threads > 1 ? threads : 1;
}

// Rank 0: of what it gathered of all; NULL where there is no memory.
static int *share_out(struct weft_ranks *ranks)
{
    const int size = ranks->info.size;
    struct introduction *all = calloc((size_t)size, sizeof *all);
    int *threads = calloc((size_t)size, sizeof *threads);
    for (int r = 0; all && r < size; r++) {
        if (ranks->parts[r].size == sizeof *all)
            memcpy(&all[r], ranks->parts[r].data, sizeof *all);
        memcpy(ranks->hosts[r], all[r].host, sizeof ranks->hosts[r]);
    }
    for (int r = 0; all && threads && r < size; r++)
        threads[r] = share_threads(all, size, r);
    if (!all) {
        free(threads);
        threads = NULL;
    }
    free(all);
    return threads;
}

enum weft_result weft_ranks_settle(struct weft_ranks *ranks)
{
    struct introduction own;
    introduce(ranks, &own);
    enum weft_result res = weft_ranks_gather(ranks, &own, sizeof own, ranks->parts);
    if (res != WEFT_OK)
        return res;
    void *threads = NULL;
    if (ranks->info.rank == 0) {
        threads = share_out(ranks);
        weft_ranks_free_parts(ranks->info.size, ranks->parts);
    }
    size_t size = threads ? (size_t)ranks->info.size * sizeof(int) : 0;
    res = weft_ranks_share(ranks, &threads, &size);
    if (res == WEFT_OK && size == 0)
        res = WEFT_ERR_MEMORY;
    if (res == WEFT_OK)
        ranks->info.threads = ((const int *)threads)[ranks->info.rank];
    free(threads);
    return res;
}
