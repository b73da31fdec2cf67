// SPDX-License-Identifier: BSD-3-Clause
#include "passes/plan/plan.h"

const char *const weft_technique_names[] = {"plain",        "dot4", "split-precision",
                                            "hierarchical", "log",  NULL};
