// SPDX-License-Identifier: BSD-3-Clause
#define WEFT_SET weft_warp_lines_avx2
#ifdef __x86_64__
#include "passes/warp/cpu_body.h"
#else
typedef int weft_no_avx2; // of other processors
#endif
