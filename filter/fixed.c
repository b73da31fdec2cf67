// SPDX-License-Identifier: BSD-3-Clause
#include "filter/fixed.h"

const char *const weft_fixed_rounding_names[] = {"nearest", "truncated", NULL};
