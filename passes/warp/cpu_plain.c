// SPDX-License-Identifier: BSD-3-Clause
#define WEFT_SET weft_warp_lines_plain
#include "passes/warp/cpu_body.h"
