// SPDX-License-Identifier: BSD-3-Clause
#include "filter/analysis/reference.h"

#include <math.h>

#include "filter/kernels/kernel_nd.h"

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
    double weights[WEFT_KERNEL_MAX_WEIGHTS];
    int64_t first[3];
    if (weft_kernel_weights_nd(kernel, dims, position, weights, first) == 0)
        return (struct weft_reference_value){.value = NAN};
    // An unused dimension is one tap at index 0.
    const int width = kernel->width, rows = dims > 1 ? width : 1, planes = dims > 2 ? width : 1;
    struct sum sum = {0};
    double magnitude = 0.0;
    const double *weight = weights;
    for (int k = 0; k < planes; k++) {
        for (int j = 0; j < rows; j++) {
            for (int i = 0; i < width; i++) {
                const double w = *weight++, f = fetch(priv, (int64_t[3]){first[0] + i, first[1] + j,
                                                                         first[2] + k});
                if (w != 0.0)
                    add(&sum, w * f);
                if (w != 0.0 || isfinite(f))
                    magnitude = fmax(magnitude, fabs(f));
            }
        }
    }
    // With an infinity in the sum, what was lost is inf - inf.
    const double value = isfinite(sum.total) ? sum.total + sum.lost : sum.total;
    return (struct weft_reference_value){.value = value, .magnitude = magnitude};
}
