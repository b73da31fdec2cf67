// SPDX-License-Identifier: BSD-3-Clause
// passes/warp/cpu_body.h - what a file for one set of instructions is made of (not installed).
// Included by cpu_<set>.c with
//   WEFT_SET   what weft_warp_lines_of calls it
#include <string.h>

#include "passes/warp/cpu.h"

#define NUMBER float
#define NAME(x) x##_in_floats
#include "passes/warp/cpu_lines.h"

#define NUMBER double
#define NAME(x) x##_in_doubles
#include "passes/warp/cpu_lines.h"

const struct weft_warp_lines *WEFT_SET(enum weft_sums sums)
{
    return sums == WEFT_SUMS_DOUBLE ? &lines_in_doubles : &lines_in_floats;
}
