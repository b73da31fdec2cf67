// SPDX-License-Identifier: BSD-3-Clause
#define WEFT_SET weft_separable_lines_avx512
#define WEFT_FLOATS 16
#ifdef __x86_64__
#include "passes/separable/cpu_body.h"
#else
typedef int weft_no_avx512; // of other processors
#endif
