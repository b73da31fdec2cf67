// SPDX-License-Identifier: BSD-3-Clause
#include "passes/params/params.h"

#include <string.h>

// What the macros make, once, with static storage, so that padding is zero.
#define DEFINE_INIT(tag)                                                                           \
    static const struct tag *const default_##tag = tag();                                          \
    void tag##_init(struct tag *params)                                                            \
    {                                                                                              \
        memcpy(params, default_##tag, sizeof *params);                                             \
    }
WEFT_PARAMS_LIST(DEFINE_INIT)
