// SPDX-License-Identifier: BSD-3-Clause
// passes/separable/cpu_body.h - what a file for one set of instructions is made of (not installed).
// Included by cpu_<set>.c with
//   WEFT_SET     what weft_separable_lines_of calls it
//   WEFT_FLOATS  floats in a vector: 4, 8 or 16
#include <math.h>
#include <string.h>

#include "passes/separable/cpu.h"

#define NUMBER float
#define LANES WEFT_FLOATS
#define NAME(x) x##_in_floats
#include "passes/separable/cpu_lines.h"

#define NUMBER double
#define LANES (WEFT_FLOATS / 2)
#define NAME(x) x##_in_doubles
#include "passes/separable/cpu_lines.h"

const struct weft_separable_lines *WEFT_SET(enum weft_sums sums)
{
    return sums == WEFT_SUMS_DOUBLE ? &lines_in_doubles : &lines_in_floats;
}
