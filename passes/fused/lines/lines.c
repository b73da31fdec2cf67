// SPDX-License-Identifier: BSD-3-Clause
#include "passes/fused/lines/lines.h"

#include <stdlib.h>

// Rows are read in vectors of up to 16 lanes.
static int stride_of(int width)
{
    return width <= 4 ? 4 : width <= 8 ? 8 : 16;
}

static void copy(const struct weft_polynomial_tiles *tiles, struct weft_line_kernel *out)
{
    const size_t powers = (size_t)tiles->segments * (size_t)(tiles->degree + 1);
    const size_t from = 4 * (size_t)tiles->groups, to = (size_t)out->stride;
    float *single = out->coefficients;
    double *precise = out->coefficients;
    for (size_t p = 0; p < powers; p++) {
        for (size_t i = 0; i < (size_t)tiles->width; i++) {
            if (out->sums == WEFT_SUMS_DOUBLE)
                precise[p * to + i] = tiles->precise[p * from + i];
            else
                single[p * to + i] = tiles->coefficients[p * from + i];
        }
    }
}

enum weft_result weft_line_kernel_create(const struct weft_log *log, enum weft_sums sums,
                                         const struct weft_polynomial_tiles *tiles,
                                         struct weft_line_kernel *out)
{
    const size_t powers = (size_t)tiles->segments * (size_t)(tiles->degree + 1);
    const size_t size = sums == WEFT_SUMS_DOUBLE ? sizeof(double) : sizeof(float);
    out->sums = sums;
    out->width = tiles->width;
    out->degree = tiles->degree;
    out->segments = tiles->segments;
    out->stride = stride_of(tiles->width);
    out->coefficients = calloc(powers * (size_t)out->stride, size);
    if (!out->coefficients) {
        weft_error(log, "not enough memory for %zu coefficients of kernel tiles",
                   powers * (size_t)out->stride);
        return WEFT_ERR_MEMORY;
    }
    copy(tiles, out);
    return WEFT_OK;
}

void weft_line_kernel_destroy(struct weft_line_kernel *kernel)
{
    free(kernel->coefficients);
    kernel->coefficients = NULL;
}

weft_line_fn weft_line_find(enum weft_instruction_set instructions,
                            const struct weft_line_kernel *kernel)
{
    switch (instructions) {
#if defined(__x86_64__)
    case WEFT_INSTRUCTIONS_SSE2:
        return weft_line_find_sse2(kernel);
    case WEFT_INSTRUCTIONS_AVX2:
        return weft_line_find_avx2(kernel);
    case WEFT_INSTRUCTIONS_AVX512:
        return weft_line_find_avx512(kernel);
#endif
    default:
        return weft_line_find_plain(kernel);
    }
}
