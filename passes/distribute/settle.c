// SPDX-License-Identifier: BSD-3-Clause
#include "passes/distribute/ranks_impl.h"

#include <stdio.h>
#include <string.h>

// What a rank tells of itself.
struct introduction {
    char host[64];
    int threads;
};

enum weft_result weft_ranks_settle(struct weft_ranks *ranks)
{
    struct introduction own;
    memset(&own, 0, sizeof own);
    (void)snprintf(own.host, sizeof own.host, "%s", ranks->info.host);
    own.threads = ranks->info.threads;
    const enum weft_result res = weft_ranks_gather(ranks, &own, sizeof own, ranks->parts);
    if (res != WEFT_OK || ranks->info.rank != 0)
        return res;
    for (int r = 0; r < ranks->info.size; r++) {
        if (ranks->parts[r].size == sizeof own)
            memcpy(&own, ranks->parts[r].data, sizeof own);
        memcpy(ranks->hosts[r], own.host, sizeof ranks->hosts[r]);
        ranks->threads[r] = own.threads;
    }
    weft_ranks_free_parts(ranks->info.size, ranks->parts);
    return WEFT_OK;
}
