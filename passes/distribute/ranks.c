// SPDX-License-Identifier: BSD-3-Clause
#include "passes/distribute/ranks_impl.h"

#include <math.h>
#include <stdio.h>
#include <unistd.h>

#include "filter/check.h"
#include "filter/threads.h"

static const double least_timeout = 0.5;

static bool is_timeout(double seconds)
{
    return isfinite(seconds) && seconds >= least_timeout;
}

static enum weft_result run_alone(struct weft_ranks *ranks, weft_body body, void *priv)
{
    char host[256] = "";
    if (gethostname(host, sizeof host - 1) != 0 || !host[0])
        (void)snprintf(host, sizeof host, "localhost");
    ranks->info = (struct weft_ranks_info){
        .size = 1,
        .node_size = 1,
        .threads = weft_threads_available(),
        .host = host,
        .timeout = ranks->params.timeout,
    };
    return body(priv, ranks);
}

enum weft_result weft_distribute_over(const struct weft_transport *transport,
                                      const struct weft_distribute_params *params, weft_body body,
                                      void *priv)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    struct weft_ranks ranks = {.params = *params};
    if (ranks.params.timeout == 0.0)
        ranks.params.timeout = weft_distribute_params()->timeout;
    weft_require(params->log, body);
    weft_require(params->log, is_timeout(ranks.params.timeout));
    weft_require(params->log, !transport || transport->size == 1);
    res = run_alone(&ranks, body, priv);
fail:
    return res;
}

void weft_ranks_get_info(const weft_ranks *ranks, struct weft_ranks_info *out)
{
    *out = ranks->info;
}

enum weft_result weft_ranks_set_timeout(weft_ranks *ranks, double seconds)
{
    weft_require(ranks->params.log, is_timeout(seconds));
    ranks->info.timeout = seconds;
    return WEFT_OK;
fail:
    return WEFT_ERR_ARGUMENT;
}
