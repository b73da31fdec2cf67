// SPDX-License-Identifier: BSD-3-Clause
#include "passes/accumulate/accumulate_impl.h"

static enum weft_result create(weft_accumulator *a)
{
    weft_error(a->params.log, "accumulate: %s is not built yet",
               weft_accumulate_method_names[a->way->method]);
    return WEFT_ERR_UNSUPPORTED;
}

static void destroy(weft_accumulator *a)
{
    (void)a;
}

const struct weft_accumulate_way weft_accumulate_tree = {
    .method = WEFT_ACCUMULATE_TREE,
    .negative = false,
    .create = create,
    .destroy = destroy,
};
