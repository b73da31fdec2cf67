// SPDX-License-Identifier: BSD-3-Clause
#include <stddef.h>

#include "passes/accumulate/accumulate.h"

const char *const weft_accumulate_method_names[] = {"auto",  "exact", "tree", "buffer",
                                                    "blend", "float", NULL};
const char *const weft_accumulate_nonfinite_names[] = {"error", "skip", "propagate", NULL};
const char *const weft_accumulated_names[] = {
    "mean", "variance", "standard error", "minimum", "maximum", "weight", NULL};
