// SPDX-License-Identifier: BSD-3-Clause
#include <float.h>
#include <math.h>
#include <string.h>

#include "passes/separable/separable_impl.h"

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

// Of the window's samples from `from` to `to`.
static void survey_floats(const struct weft_separable_run_params *p, const int from[2],
                          const int to[2], struct weft_separable_survey *out)
{
    const int columns = to[0] - from[0] + 1;
    uint32_t largest = 0;
    for (int y = from[1]; y <= to[1]; y++) {
        const float *row = p->samples + weft_separable_sample(p, from[0], y);
        uint32_t bits = largest_bits(row, columns);
        out->not_finite = out->not_finite || bits >= INFINITY_BITS;
        if (bits >= INFINITY_BITS)
            bits = largest_finite_bits(row, columns);
        largest = bits > largest ? bits : largest;
    }
    float value;
    memcpy(&value, &largest, sizeof value);
    out->largest = (double)value;
}

static void survey_doubles(const struct weft_separable_run_params *p, const int from[2],
                           const int to[2], struct weft_separable_survey *out)
{
    double zero = 0.0; // NAN as soon as one is not finite
    for (int y = from[1]; y <= to[1]; y++)
        for (int x = from[0]; x <= to[0]; x++)
            zero += 0.0 * p->wide[weft_separable_sample(p, x, y)];
    out->not_finite = zero != 0.0;
}

static int smaller(int a, int b)
{
    return a < b ? a : b;
}

static int larger(int a, int b)
{
    return a > b ? a : b;
}

// The params are checked.
static struct weft_separable_survey survey(const weft_separable_plan *plan,
                                           const struct weft_separable_run_params *p)
{
    const struct weft_rectangle *w = &p->window;
    const int from[2] = {larger(plan->axis[0].reach[0], w->x),
                         larger(plan->axis[1].reach[0], w->y)};
    const int to[2] = {smaller(plan->axis[0].reach[1], w->x + w->width - 1),
                       smaller(plan->axis[1].reach[1], w->y + w->height - 1)};
    struct weft_separable_survey out = {0};
    if (from[0] > to[0] || from[1] > to[1])
        return out;
    if (p->wide)
        survey_doubles(p, from, to, &out);
    else
        survey_floats(p, from, to, &out);
    return out;
}

enum weft_result weft_separable_survey_samples(const weft_separable_plan *plan,
                                               const struct weft_separable_run_params *params,
                                               struct weft_separable_survey *out)
{
    struct weft_separable_run_params p = *params;
    *out = (struct weft_separable_survey){0};
    const enum weft_result res = weft_separable_check_samples(plan, &p);
    if (res == WEFT_OK)
        *out = survey(plan, &p);
    return res;
}

void weft_separable_survey_join(struct weft_separable_survey *sum,
                                const struct weft_separable_survey *other)
{
    sum->largest = fmax(sum->largest, other->largest);
    sum->not_finite = sum->not_finite || other->not_finite;
}

// Sums stay below 2^127, which leaves room for their roundings.
static void choose_scale(struct weft_separable_care *care, const weft_separable_plan *plan,
                         double largest)
{
    if (weft_separable_is_safe(largest))
        return; // no sum of products with weights that add up to less than 2^31 overflows
    int exponent;
    frexp(largest * plan->axis[0].growth * plan->axis[1].growth, &exponent);
    care->scale_bits = exponent > 127 ? exponent - 127 : 0;
    care->margin = weft_separable_plan_error(plan) * largest;
}

// Sums of floats do not leave the range of doubles.
struct weft_separable_care weft_separable_take_care(const weft_separable_plan *plan,
                                                    const struct weft_separable_run_params *params)
{
    struct weft_separable_survey of = params->survey ? *params->survey : survey(plan, params);
    if (plan->info.boundary == WEFT_BOUNDARY_BORDER)
        of.largest = fmax(of.largest, fabs(params->border));
    struct weft_separable_care care = {.skips_zeros = of.not_finite};
    if (plan->info.sums == WEFT_SUMS_FLOAT)
        choose_scale(&care, plan, of.largest);
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
    for (int x = from; x < to; x++) {
        if (columns[x] < 0)
            continue;
        const size_t at = weft_separable_sample(params, columns[x], sample);
        row[x - from] = params->wide ? (float)params->wide[at] : params->samples[at];
    }
}

void weft_separable_finish(const struct weft_separable_care *care, const weft_separable_plan *plan,
                           const struct weft_separable_run_params *params, const int from[2],
                           const int size[2])
{
    for (int y = from[1]; y < from[1] + size[1]; y++) {
        float *row = weft_separable_pixel(params, from[0], y);
        for (int x = 0; care->scale_bits && x < size[0]; x++)
            row[x] = held(care, row[x]);
        if (plan->axis[1].whole[y] >= 0)
            copy_whole(plan, params, plan->axis[1].whole[y], from[0], from[0] + size[0], row);
    }
}
