// SPDX-License-Identifier: BSD-3-Clause
#include "passes/fused/lines/lines.h"

#include <stdlib.h>
#include <string.h>

// Coefficient number `from` of the tiles to `copies` of number `to` on.
static void copy(const struct weft_polynomial_tiles *tiles, size_t from, int copies, size_t to,
                 enum weft_sums sums, void *coefficients)
{
    float *single = coefficients;
    double *precise = coefficients;
    for (int i = 0; i < copies; i++) {
        if (sums == WEFT_SUMS_DOUBLE)
            precise[to + (size_t)i] = tiles->precise[from];
        else
            single[to + (size_t)i] = tiles->coefficients[from];
    }
}

// tiles NULL: weights of 0.
static enum weft_result create_weights(const struct weft_log *log, enum weft_sums sums, int width,
                                       const struct weft_polynomial_tiles *tiles,
                                       struct weft_line_weights *out)
{
    const bool whole = !tiles || tiles->segments == 1;
    const size_t row = tiles ? 4 * (size_t)tiles->groups : 0, taps = whole ? (size_t)width : row;
    const size_t powers = tiles ? (size_t)tiles->segments * (size_t)(tiles->degree + 1) : 1;
    const size_t count = powers * taps * (whole ? WEFT_LINE_COPIES : 1);
    const size_t size = sums == WEFT_SUMS_DOUBLE ? sizeof(double) : sizeof(float);
    const size_t bytes = (count * size + 63) / 64 * 64;
    out->degree = tiles ? tiles->degree : 0;
    out->segments = tiles ? tiles->segments : 1;
    out->stride = (int)row;
    out->coefficients = aligned_alloc(64, bytes);
    if (!out->coefficients) {
        weft_error(log, "not enough memory for %zu coefficients of kernel tiles", count);
        return WEFT_ERR_MEMORY;
    }
    memset(out->coefficients, 0, bytes);
    for (size_t p = 0; tiles && p < powers; p++) {
        for (size_t i = 0; i < taps; i++)
            copy(tiles, p * row + i, whole ? WEFT_LINE_COPIES : 1,
                 whole ? (p * taps + i) * WEFT_LINE_COPIES : p * row + i, sums, out->coefficients);
    }
    return WEFT_OK;
}

enum weft_result
weft_line_kernel_create(const struct weft_log *log, enum weft_sums sums,
                        const struct weft_polynomial_tiles *const tiles[WEFT_LINE_ORDERS],
                        struct weft_line_kernel *out)
{
    enum weft_result res = WEFT_OK;
    out->sums = sums;
    out->width = tiles[0]->width;
    for (int n = 0; n < WEFT_LINE_ORDERS; n++)
        out->weights[n] = (struct weft_line_weights){0};
    for (int n = 0; res == WEFT_OK && n < WEFT_LINE_ORDERS; n++)
        res = create_weights(log, sums, out->width, tiles[n], &out->weights[n]);
    if (res != WEFT_OK)
        weft_line_kernel_destroy(out);
    return res;
}

void weft_line_kernel_destroy(struct weft_line_kernel *kernel)
{
    for (int n = 0; n < WEFT_LINE_ORDERS; n++) {
        free(kernel->weights[n].coefficients);
        kernel->weights[n].coefficients = NULL;
    }
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
