// SPDX-License-Identifier: BSD-3-Clause
#define WEFT_SET weft_separable_lines_avx2
#define WEFT_FLOATS 8
#ifdef __x86_64__
#include "passes/separable/cpu_body.h"
#else
typedef int weft_no_avx2; // of other processors
#endif
