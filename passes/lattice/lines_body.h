// SPDX-License-Identifier: BSD-3-Clause
// passes/lattice/lines_body.h - sums of rows, compiled once for each set of instructions: the file
// of a set defines WEFT_SET, the name of its functions, and WEFT_DOUBLES, those of a vector. (Not
// installed.)
#include "passes/lattice/lattice_impl.h"

typedef double vector __attribute__((vector_size(WEFT_DOUBLES * sizeof(double)), aligned(8)));
enum { VECTORS = 8 / WEFT_DOUBLES };

static inline vector splat(double value)
{
    return value - (vector){0};
}

static void sum(double *out, const double *const *row, const double *weight, int64_t taps,
                size_t count)
{
    for (size_t i = 0; i < count; i += 8) {
        vector total[VECTORS];
        for (int v = 0; v < VECTORS; v++)
            total[v] = splat(0.0);
        for (int64_t t = 0; t < taps; t++)
            for (int v = 0; v < VECTORS; v++)
                total[v] += splat(weight[t]) * *(const vector *)(row[t] + i + v * WEFT_DOUBLES);
        for (int v = 0; v < VECTORS; v++)
            *(vector *)(out + i + v * WEFT_DOUBLES) = total[v];
    }
}

static void add(double *out, const double *row, double weight, size_t count)
{
    const vector w = splat(weight);
    for (size_t i = 0; i < count; i += WEFT_DOUBLES)
        *(vector *)(out + i) += w * *(const vector *)(row + i);
}

const struct weft_lattice_lines WEFT_SET = {sum, add};
