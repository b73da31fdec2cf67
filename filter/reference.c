// SPDX-License-Identifier: BSD-3-Clause
#include "filter/reference.h"

#include <math.h>

// Neumaier (1974): the sum and what its roundings lost.
struct sum {
    double total, lost;
};

static void add(struct sum *sum, double term)
{
    const double next = sum->total + term;
    if (fabs(sum->total) >= fabs(term))
        sum->lost += (sum->total - next) + term;
    else
        sum->lost += (term - next) + sum->total;
    sum->total = next;
}

struct weft_reference_value weft_reference_compute(const struct weft_kernel *kernel, int dims,
                                                   const double *position,
                                                   weft_reference_fetch fetch, void *priv)
{
    if (dims < 1 || dims > 3)
        return (struct weft_reference_value){.value = NAN};
    // An unused dimension is one tap of weight 1 at index 0.
    double weights[3][WEFT_KERNEL_MAX_WIDTH] = {{1.0}, {1.0}, {1.0}};
    int64_t first[3] = {0, 0, 0};
    int count[3] = {1, 1, 1};
    for (int d = 0; d < dims; d++) {
        first[d] = weft_kernel_weights(kernel, position[d], weights[d]);
        count[d] = kernel->width;
    }
    struct sum sum = {0};
    double magnitude = 0.0;
    for (int k = 0; k < count[2]; k++) {
        for (int j = 0; j < count[1]; j++) {
            for (int i = 0; i < count[0]; i++) {
                const double f =
                    fetch(priv, (int64_t[3]){first[0] + i, first[1] + j, first[2] + k});
                add(&sum, weights[0][i] * weights[1][j] * weights[2][k] * f);
                magnitude = fmax(magnitude, fabs(f));
            }
        }
    }
    // With an infinity in the sum, what was lost is inf - inf.
    const double value = isfinite(sum.total) ? sum.total + sum.lost : sum.total;
    return (struct weft_reference_value){.value = value, .magnitude = magnitude};
}
