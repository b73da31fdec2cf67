// SPDX-License-Identifier: BSD-3-Clause
// What the compiler makes of vectors of 4 for any processor.
#include "passes/fused/lines/lines.h"

#define REAL float
#define REAL_IS_FLOAT 1
#define WIDE 4
#define NARROW 4
#define MIDDLE 4
#define BROAD 4
#define FMA(lanes, a, b, c) ((a) * (b) + (c))
#include "passes/fused/lines/lines_body.h"

#define REAL double
#define REAL_IS_FLOAT 0
#define WIDE 2
#define NARROW 2
#define MIDDLE 2
#define BROAD 2
#define FMA(lanes, a, b, c) ((a) * (b) + (c))
#include "passes/fused/lines/lines_body.h"

weft_line_fn weft_line_find_plain(const struct weft_line_kernel *kernel)
{
    return kernel->sums == WEFT_SUMS_DOUBLE ? find_double(kernel) : find_float(kernel);
}
