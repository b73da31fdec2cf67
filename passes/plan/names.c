// SPDX-License-Identifier: BSD-3-Clause
#include "passes/plan/plan.h"

const char *const weft_technique_names[] = {"plain",        "dot4", "split-precision",
                                            "hierarchical", "log",  NULL};
const char *const weft_order_names[] = {"planned", "greedy", "natural", "given", NULL};
const char *const weft_worst_case_names[] = {"constant", "any", NULL};
const char *const weft_pass_kind_names[] = {"taps", "combine", NULL};
const char *const weft_pass_part_names[] = {"whole", "high", "low", NULL};
