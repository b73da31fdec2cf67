// SPDX-License-Identifier: BSD-3-Clause
#define WEFT_SET weft_separable_lines_sse2
#define WEFT_FLOATS 4
#ifdef __x86_64__
#include "passes/separable/cpu_body.h"
#else
typedef int weft_no_sse2; // of other processors
#endif
