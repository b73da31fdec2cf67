// SPDX-License-Identifier: BSD-3-Clause
#include <float.h>
#include <math.h>
#include <string.h>

#include "passes/separable/separable_impl.h"

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
static double survey(struct weft_separable_care *care, const weft_separable_plan *plan,
                     const float *samples)
{
    const struct weft_separable_axis *x = &plan->axis[0], *y = &plan->axis[1];
    const int columns = x->reach[1] - x->reach[0] + 1;
    uint32_t largest = 0;
    for (int j = y->reach[0]; j <= y->reach[1]; j++) {
        const float *row = samples + (size_t)j * (size_t)x->size + x->reach[0];
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

// Sums stay below 2^127, which leaves room for their roundings.
static void choose_scale(struct weft_separable_care *care, const weft_separable_plan *plan,
                         double largest)
{
    if (largest < ldexp(1.0, SAFE_EXPONENT))
        return;
    int exponent;
    frexp(largest * plan->axis[0].growth * plan->axis[1].growth, &exponent);
    care->scale_bits = exponent > 127 ? exponent - 127 : 0;
    care->margin = weft_separable_error_bound(&plan->info.kernel, WEFT_SUMS_FLOAT) * largest;
}

static bool any_not_finite(const weft_separable_plan *plan, const double *samples)
{
    const struct weft_separable_axis *x = &plan->axis[0], *y = &plan->axis[1];
    double zero = 0.0; // NAN as soon as one is not finite
    for (int j = y->reach[0]; j <= y->reach[1]; j++)
        for (int i = x->reach[0]; i <= x->reach[1]; i++)
            zero += 0.0 * samples[(size_t)j * (size_t)x->size + (size_t)i];
    return zero != 0.0;
}

// Sums of floats do not leave the range of doubles.
struct weft_separable_care weft_separable_take_care(const weft_separable_plan *plan,
                                                    const struct weft_separable_run_params *params)
{
    struct weft_separable_care care = {0};
    if (params->wide) {
        care.skips_zeros = any_not_finite(plan, params->wide);
        return care;
    }
    const double largest = survey(&care, plan, params->samples);
    if (plan->info.sums == WEFT_SUMS_FLOAT)
        choose_scale(&care, plan, largest);
    return care;
}

// ---- pixels -------------------------------------------------------------------------------------

// A sum just past the range of floats may be one inside, and is then the range's end.
static float held(const struct weft_separable_care *care, float pixel)
{
    const double value = ldexp((double)pixel, care->scale_bits), beyond = fabs(value) - FLT_MAX;
    return (float)(beyond > 0.0 && beyond <= care->margin ? copysign(FLT_MAX, value) : value);
}

// A row of pixels, from one column to another, that lies on a row of samples.
static void copy_whole(const weft_separable_plan *plan,
                       const struct weft_separable_run_params *params, int sample, int from, int to,
                       float *row)
{
    const int32_t *columns = plan->axis[0].whole;
    const size_t at = (size_t)sample * (size_t)plan->info.size[0];
    for (int x = from; x < to; x++)
        if (columns[x] >= 0)
            row[x] = params->wide ? (float)params->wide[at + (size_t)columns[x]]
                                  : params->samples[at + (size_t)columns[x]];
}

void weft_separable_finish(const struct weft_separable_care *care, const weft_separable_plan *plan,
                           const struct weft_separable_run_params *params, const int from[2],
                           const int size[2])
{
    const int end = from[0] + size[0];
    for (int y = from[1]; y < from[1] + size[1]; y++) {
        float *row = params->pixels + y * params->stride;
        for (int x = from[0]; care->scale_bits && x < end; x++)
            row[x] = held(care, row[x]);
        if (plan->axis[1].whole[y] >= 0)
            copy_whole(plan, params, plan->axis[1].whole[y], from[0], end, row);
    }
}
