// SPDX-License-Identifier: BSD-3-Clause
#define WEFT_SET weft_separable_lines_plain
#define WEFT_FLOATS 4
#include "passes/separable/cpu_body.h"
