// SPDX-License-Identifier: BSD-3-Clause
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "passes/separable/job.h"

// Below 2^this, no sum of products with weights that add up to less than 2^31 overflows.
enum { SAFE_EXPONENT = 64 };

// ---- samples ------------------------------------------------------------------------------------

// Whose order is that of magnitudes; from INFINITY_BITS on they are not finite.
static uint32_t magnitude_bits(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits & 0x7fffffff;
}

enum { INFINITY_BITS = 0x7f800000 };

static uint32_t largest_bits(const float *row, int count)
{
    uint32_t largest = 0;
    for (int i = 0; i < count; i++) {
        const uint32_t bits = magnitude_bits(row[i]);
        largest = bits > largest ? bits : largest;
    }
    return largest;
}

static uint32_t largest_finite_bits(const float *row, int count)
{
    uint32_t largest = 0;
    for (int i = 0; i < count; i++) {
        const uint32_t bits = magnitude_bits(row[i]);
        largest = bits > largest && bits < INFINITY_BITS ? bits : largest;
    }
    return largest;
}

// The largest finite |sample| in reach.
static double survey(struct weft_separable_care *care, const struct weft_separable_params *p,
                     const struct weft_separable_reach reach[2])
{
    const int columns = reach[0].last - reach[0].first + 1;
    uint32_t largest = 0;
    for (int y = reach[1].first; y <= reach[1].last; y++) {
        const float *row = p->samples + (size_t)y * (size_t)p->size[0] + reach[0].first;
        uint32_t bits = largest_bits(row, columns);
        care->skips_zeros = care->skips_zeros || bits >= INFINITY_BITS;
        if (bits >= INFINITY_BITS)
            bits = largest_finite_bits(row, columns);
        largest = bits > largest ? bits : largest;
    }
    float value;
    memcpy(&value, &largest, sizeof value);
    return (double)value;
}

// ---- weights ------------------------------------------------------------------------------------

// Largest sum of |weights| of all positions, and 1 at least: what samples grow by on the way.
static double growth(const struct weft_kernel *kernel, const double *at, int count)
{
    double most = 1.0;
    for (int i = 0; i < count; i++) {
        double weights[WEFT_KERNEL_MAX_WIDTH], sum = 0.0;
        weft_kernel_weights(kernel, at[i], weights);
        for (int j = 0; j < kernel->width; j++)
            sum += fabs(weights[j]);
        most = fmax(most, sum);
    }
    return most;
}

// Sums stay below 2^127, which leaves room for their roundings.
static void choose_scale(struct weft_separable_care *care, const struct weft_separable_params *p,
                         double largest)
{
    if (largest < ldexp(1.0, SAFE_EXPONENT))
        return;
    int exponent;
    frexp(largest * growth(&p->kernel, p->x, p->width) * growth(&p->kernel, p->y, p->height),
          &exponent);
    care->scale_bits = exponent > 127 ? exponent - 127 : 0;
    care->margin = weft_separable_error_bound(&p->kernel) * largest;
}

// The sample that a position is: all of its weights are 0 but for one of 1. -1: none.
static int32_t whole_sample(const struct weft_kernel *kernel, double at, int size)
{
    double weights[WEFT_KERNEL_MAX_WIDTH];
    int64_t sample = -1;
    if (kernel->width > 1 && at != rint(at))
        return -1;
    const int64_t first = weft_kernel_weights(kernel, at, weights);
    for (int j = 0; j < kernel->width; j++) {
        if (weights[j] == 1.0)
            sample = first + j < 0 ? 0 : first + j >= size ? size - 1 : first + j;
        else if (weights[j] != 0.0)
            return -1;
    }
    return (int32_t)sample;
}

enum weft_result weft_separable_care_create(const struct weft_separable_params *p,
                                            const struct weft_separable_reach reach[2],
                                            struct weft_separable_care *out)
{
    const double *const at[2] = {p->x, p->y};
    const int count[2] = {p->width, p->height};
    *out = (struct weft_separable_care){0};
    for (int a = 0; a < 2; a++) {
        out->whole[a] = malloc((size_t)count[a] * sizeof *out->whole[a]);
        if (!out->whole[a]) {
            weft_error(p->log, "not enough memory for %d pixels", count[a]);
            weft_separable_care_destroy(out);
            return WEFT_ERR_MEMORY;
        }
        for (int i = 0; i < count[a]; i++)
            out->whole[a][i] = whole_sample(&p->kernel, at[a][i], p->size[a]);
    }
    choose_scale(out, p, survey(out, p, reach));
    return WEFT_OK;
}

void weft_separable_care_destroy(struct weft_separable_care *care)
{
    free(care->whole[0]);
    free(care->whole[1]);
    *care = (struct weft_separable_care){0};
}

// ---- pixels -------------------------------------------------------------------------------------

// A sum just past the range of floats may be one inside, and is then the range's end.
static float held(const struct weft_separable_care *care, float pixel)
{
    const double value = ldexp((double)pixel, care->scale_bits), beyond = fabs(value) - FLT_MAX;
    return (float)(beyond > 0.0 && beyond <= care->margin ? copysign(FLT_MAX, value) : value);
}

void weft_separable_care_finish(const struct weft_separable_care *care,
                                const struct weft_separable_params *p, const int from[2],
                                const int size[2])
{
    for (int y = from[1]; y < from[1] + size[1]; y++) {
        float *row = p->pixels + y * p->stride;
        for (int x = from[0]; care->scale_bits && x < from[0] + size[0]; x++)
            row[x] = held(care, row[x]);
        const int32_t sample = care->whole[1][y];
        const float *samples = p->samples + (size_t)(sample < 0 ? 0 : sample) * (size_t)p->size[0];
        for (int x = from[0]; sample >= 0 && x < from[0] + size[0]; x++)
            if (care->whole[0][x] >= 0)
                row[x] = samples[care->whole[0][x]];
    }
}
