// SPDX-License-Identifier: BSD-3-Clause
// Vectors of 8 floats or 4 doubles, AVX2 and FMA.
#ifdef __x86_64__
#include "passes/fused/lines/lines.h"

// A product and a sum, rounded once, by lanes.
#define FMA_float_4(a, b, c) _mm_fmadd_ps(a, b, c)
#define FMA_float_8(a, b, c) _mm256_fmadd_ps(a, b, c)
#define FMA_double_4(a, b, c) _mm256_fmadd_pd(a, b, c)

#define REAL float
#define REAL_IS_FLOAT 1
#define WIDE 8
#define NARROW 4
#define MIDDLE 8
#define BROAD 8
#define FMA(lanes, a, b, c) JOIN(JOIN(FMA, float), lanes)(a, b, c)
#include "passes/fused/lines/lines_body.h"

#define REAL double
#define REAL_IS_FLOAT 0
#define WIDE 4
#define NARROW 4
#define MIDDLE 4
#define BROAD 4
#define FMA(lanes, a, b, c) JOIN(JOIN(FMA, double), lanes)(a, b, c)
#include "passes/fused/lines/lines_body.h"

weft_line_fn weft_line_find_avx2(const struct weft_line_kernel *kernel)
{
    return kernel->sums == WEFT_SUMS_DOUBLE ? find_double(kernel) : find_float(kernel);
}

#else
typedef int weft_no_avx2_lines; // of other processors
#endif
