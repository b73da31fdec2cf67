// SPDX-License-Identifier: BSD-3-Clause
// passes/distribute/ranks_impl.h - what a rank knows of all (not installed).
#ifndef WEFT_PASSES_DISTRIBUTE_RANKS_IMPL_H
#define WEFT_PASSES_DISTRIBUTE_RANKS_IMPL_H

#include "passes/distribute/ranks.h"

struct weft_ranks {
    struct weft_distribute_params params;
    struct weft_ranks_info info;
};

#endif
