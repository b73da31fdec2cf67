// SPDX-License-Identifier: BSD-3-Clause
#include "filter/analysis/reference.h"

#include <math.h>

#include "filter/kernels/kernel_nd.h"
#include "filter/kernels/kernel_records.h"
#include "filter/kernels/stretch.h"

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

static void add_tap(struct sum *sum, double *magnitude, double w, double f)
{
    if (w != 0.0)
        add(sum, w * f);
    if (w != 0.0 || isfinite(f))
        *magnitude = fmax(*magnitude, fabs(f));
}

// With an infinity in the sum, what was lost is inf - inf.
static struct weft_reference_value value_of(const struct sum *sum, double magnitude)
{
    const double value = isfinite(sum->total) ? sum->total + sum->lost : sum->total;
    return (struct weft_reference_value){.value = value, .magnitude = magnitude};
}

// Over all taps: `width` along each of dims axes.
static struct weft_reference_value sum_taps(int width, int dims, const double *weight,
                                            const int64_t first[3], weft_reference_fetch fetch,
                                            void *priv)
{
    // An unused dimension is one tap at index 0.
    const int rows = dims > 1 ? width : 1, planes = dims > 2 ? width : 1;
    struct sum sum = {0};
    double magnitude = 0.0;
    for (int k = 0; k < planes; k++) {
        for (int j = 0; j < rows; j++) {
            for (int i = 0; i < width; i++) {
                const int64_t at[3] = {first[0] + i, first[1] + j, first[2] + k};
                add_tap(&sum, &magnitude, *weight++, fetch(priv, at));
            }
        }
    }
    return value_of(&sum, magnitude);
}

struct weft_reference_value weft_reference_compute(const struct weft_kernel *kernel, int dims,
                                                   const double *position,
                                                   weft_reference_fetch fetch, void *priv)
{
    double weights[WEFT_KERNEL_MAX_WEIGHTS];
    int64_t first[3];
    if (weft_kernel_weights_nd(kernel, dims, position, weights, first) == 0)
        return (struct weft_reference_value){.value = NAN};
    return sum_taps(kernel->width, dims, weights, first, fetch, priv);
}

struct weft_reference_value weft_reference_compute_axes(const struct weft_kernel kernel[3],
                                                        int dims, const double *position,
                                                        weft_reference_fetch fetch, void *priv)
{
    double axis[3][WEFT_KERNEL_MAX_WIDTH], weights[WEFT_KERNEL_MAX_WEIGHTS];
    int64_t first[3] = {0};
    bool usable = dims >= 1 && dims <= 3;
    for (int a = 0; usable && a < dims; a++) {
        usable = weft_kernel_usable(&kernel[a]) && !weft_kernel_is_radial(&kernel[a], dims) &&
                 kernel[a].width == kernel[0].width;
        if (usable)
            first[a] = weft_kernel_weights(&kernel[a], position[a], axis[a]);
    }
    if (!usable)
        return (struct weft_reference_value){.value = NAN};
    weft_kernel_combine(&kernel[0], dims, (const double *const[3]){axis[0], axis[1], axis[2]},
                        weights);
    return sum_taps(kernel[0].width, dims, weights, first, fetch, priv);
}

struct weft_reference_value weft_reference_compute_stretched(const struct weft_kernel *kernel,
                                                             const double *scale, int dims,
                                                             const double *position, double *room,
                                                             weft_reference_fetch fetch, void *priv)
{
    int64_t first[3] = {0}, width[3] = {1, 1, 1};
    double one = 1.0, *weight[3] = {&one, &one, &one}, magnitude = 0.0;
    struct sum sum = {0};
    bool usable = dims >= 1 && dims <= 3;
    for (int a = 0; usable && a < dims; a++) {
        width[a] = weft_stretch_width(kernel, scale[a]);
        weight[a] = room;
        first[a] = weft_stretch_weights(kernel, scale[a], position[a], room);
        room += width[a];
        usable = width[a] > 0;
    }
    if (!usable)
        return (struct weft_reference_value){.value = NAN};
    for (int64_t k = 0; k < width[2]; k++) {
        for (int64_t j = 0; j < width[1]; j++) {
            for (int64_t i = 0; i < width[0]; i++) {
                const double w = weight[2][k] * weight[1][j] * weight[0][i];
                const int64_t at[3] = {first[0] + i, first[1] + j, first[2] + k};
                add_tap(&sum, &magnitude, w, fetch(priv, at));
            }
        }
    }
    return value_of(&sum, magnitude);
}
