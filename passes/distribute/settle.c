// SPDX-License-Identifier: BSD-3-Clause
#include "passes/distribute/ranks_impl.h"

#include <stdio.h>
#include <string.h>

enum weft_result weft_ranks_settle(struct weft_ranks *ranks)
{
    const char *host = ranks->info.host;
    const enum weft_result res = weft_ranks_gather(ranks, host, strlen(host), ranks->parts);
    if (res != WEFT_OK || ranks->info.rank != 0)
        return res;
    for (int r = 0; r < ranks->info.size; r++)
        (void)snprintf(ranks->hosts[r], sizeof ranks->hosts[r], "%.*s", (int)ranks->parts[r].size,
                       ranks->parts[r].data ? (const char *)ranks->parts[r].data : "");
    weft_ranks_free_parts(ranks->info.size, ranks->parts);
    return WEFT_OK;
}
