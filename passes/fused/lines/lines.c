// SPDX-License-Identifier: BSD-3-Clause
#include "passes/fused/lines/lines.h"

#include <stdlib.h>

// Coefficient number `from` of the tiles to `copies` of number `to` on of the kernel.
static void copy(const struct weft_polynomial_tiles *tiles, size_t from, int copies, size_t to,
                 const struct weft_line_kernel *out)
{
    float *single = out->coefficients;
    double *precise = out->coefficients;
    for (int i = 0; i < copies; i++) {
        if (out->sums == WEFT_SUMS_DOUBLE)
            precise[to + (size_t)i] = tiles->precise[from];
        else
            single[to + (size_t)i] = tiles->coefficients[from];
    }
}

enum weft_result weft_line_kernel_create(const struct weft_log *log, enum weft_sums sums,
                                         const struct weft_polynomial_tiles *tiles,
                                         struct weft_line_kernel *out)
{
    const bool whole = tiles->segments == 1;
    const size_t row = 4 * (size_t)tiles->groups, width = (size_t)tiles->width;
    const size_t powers = (size_t)tiles->segments * (size_t)(tiles->degree + 1);
    const size_t count = powers * (whole ? width * WEFT_LINE_COPIES : row);
    const size_t size = sums == WEFT_SUMS_DOUBLE ? sizeof(double) : sizeof(float);
    out->sums = sums;
    out->width = tiles->width;
    out->degree = tiles->degree;
    out->segments = tiles->segments;
    out->stride = (int)row;
    out->coefficients = aligned_alloc(64, (count * size + 63) / 64 * 64);
    if (!out->coefficients) {
        weft_error(log, "not enough memory for %zu coefficients of kernel tiles", count);
        return WEFT_ERR_MEMORY;
    }
    for (size_t p = 0; p < powers; p++) {
        for (size_t i = 0; i < (whole ? width : row); i++)
            copy(tiles, p * row + i, whole ? WEFT_LINE_COPIES : 1,
                 whole ? (p * width + i) * WEFT_LINE_COPIES : p * row + i, out);
    }
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
