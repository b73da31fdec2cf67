// SPDX-License-Identifier: BSD-3-Clause
// Blending as a method. Where all weights are known, frame k is added with w_k / W; otherwise it is
// mixed in by w_k / (sum so far), so that the target is the mean at all times.
//
// The bound holds for every GL that blends in the target's own precision or a higher one (OpenGL
// 4.5, section 17.3.8), whichever way it rounds: the frame's value, the constant, its complement,
// each product and the sum become one of the two numbers of the target that are nearest to them. Of
// codes the constant is one and sums are exact, so that those make no error.
#include <math.h>
#include <stdlib.h>

#include "passes/accumulate/blend_target.h"

// How far it is. Errors are in codes, of floats in the largest |value|.
struct progress {
    double sum;          // of the weights
    double placed;       // of the constants' codes that were added
    double error;        // of roundings, so far
    double above, below; // sums of constant - weight over frames that got too much, and too little
    double least, most;  // constant / weight of all frames so far
    double count;        // of frames
};

struct method {
    weft_blend_target *target;
    struct progress progress;
    double largest; // |v| so far
};

static bool has_codes(const weft_accumulator *a)
{
    return a->params.bits == 8 || a->params.bits == 16;
}

static double largest_code(const weft_accumulator *a)
{
    return a->params.bits == 8 ? 255.0 : 65535.0;
}

// One unit in the last place, relative, and absolutely where numbers are smallest.
static double precision(const weft_accumulator *a)
{
    return a->params.bits == 32 ? 0x1p-23 : 0x1p-10;
}

static double smallest(const weft_accumulator *a)
{
    return a->params.bits == 32 ? 0x1p-126 : 0x1p-24;
}

// ---- weights ------------------------------------------------------------------------------------

// The constant of a frame whose share is exactly `share`. Added codes follow the sum of shares, so
// that they add up to the largest code.
static double constant_of(const weft_accumulator *a, const struct progress *s, double share)
{
    const double one = largest_code(a);
    if (!has_codes(a))
        return (double)(float)share;
    if (!a->known_total)
        return rint(share * one) / one;
    const double all = fmin(s->sum / a->known_total, 1.0);
    return (rint(all * one) - s->placed) / one;
}

static void count_change(const weft_accumulator *a, struct progress *s, double share,
                         double constant)
{
    const double ratio = constant / share;
    if (!a->known_total && share < 1.0) { // what there was is mixed with the rest
        const double rest = (1.0 - constant) / (1.0 - share);
        s->least *= rest;
        s->most *= rest;
    }
    s->least = s->count == 0.0 ? ratio : fmin(s->least, ratio);
    s->most = s->count == 0.0 ? ratio : fmax(s->most, ratio);
}

// ---- bounds -------------------------------------------------------------------------------------

// d + s c: the value and the product are rounded.
static void add_codes(const weft_accumulator *a, const struct weft_value_range *range,
                      struct progress *s, double share, double c)
{
    const double one = largest_code(a), change = (c - share) * one;
    if (c > 0.0)
        s->error += c * (1.0 + range->error * one) + (c < 1.0 ? 1.0 : 0.0);
    *(change > 0.0 ? &s->above : &s->below) += fabs(change);
    s->placed += c * one;
}

// d (1 - c) + s c: the value and both products are rounded, and frame and mean differ by less than
// the range where c is not the share.
static void mix_codes(const weft_accumulator *a, const struct weft_value_range *range,
                      struct progress *s, double share, double c)
{
    const double one = largest_code(a);
    s->error = (1.0 - c) * s->error + c * (1.0 + range->error * one) + fabs(c - share) * one +
               (c > 0.0 && c < 1.0 ? 2.0 : 0.0);
}

// The value, the constant, their product and the sum are rounded; values that are integers were
// before.
static void add_floats(const weft_accumulator *a, struct progress *s, double share)
{
    const double u = precision(a), values = s->sum / a->known_total;
    s->error += (3.1 * u + 0x1p-23) * share + u * (values + s->error);
}

// The value, the constant, its complement, both products and the sum; frame and mean differ by
// twice the largest value at most.
static void mix_floats(const weft_accumulator *a, struct progress *s, double share)
{
    const double u = precision(a);
    if (share == 1.0)
        s->error = u;
    else
        s->error = (1.0 - share) * s->error * (1.0 + 4.0 * u) + 1.01 * u * (3.0 + 2.0 * share) +
                   0x1p-22 * share;
}

// Counts a weight and returns the constant that the frame is blended with.
static double count_weight(const weft_accumulator *a, const struct method *m, double weight,
                           struct progress *s)
{
    const struct weft_value_range *range = weft_blend_target_range(m->target);
    s->sum += weight;
    const double share = weight / (a->known_total ? a->known_total : s->sum);
    const double c = constant_of(a, s, share);
    count_change(a, s, share, c);
    s->count += 1.0;
    if (has_codes(a))
        (a->known_total ? add_codes : mix_codes)(a, range, s, share, c);
    else
        (a->known_total ? add_floats : mix_floats)(a, s, share);
    return c;
}

// What the target is multiplied by to be a mean of the frames so far.
static double gain_of(const weft_accumulator *a, const struct progress *s)
{
    return a->known_total ? a->known_total / s->sum : 1.0;
}

static double bound_of(const weft_accumulator *a, const struct method *m, const struct progress *s,
                       double largest)
{
    const struct weft_value_range *range = weft_blend_target_range(m->target);
    const double gain = gain_of(a, s), result = 0x1p-24 * (has_codes(a) ? range->extent : largest);
    if (s->count == 0.0)
        return INFINITY;
    if (has_codes(a)) {
        const double codes = s->error + fmax(s->above, s->below);
        return gain * codes / largest_code(a) * range->size * (1.0 + 0x1p-20) + result;
    }
    return gain * (s->error * largest + 4.0 * s->count * smallest(a)) * (1.0 + 0x1p-20) + result;
}

static struct progress expected(const weft_accumulator *a, const struct method *m)
{
    struct progress s = {0};
    for (int64_t i = 0; i < a->params.frame_count; i++)
        if (a->weight[i] != 0.0)
            count_weight(a, m, a->weight[i], &s);
    return s;
}

// ---- the method ---------------------------------------------------------------------------------

static enum weft_result check_params(const struct weft_accumulator_params *p)
{
    const bool propagates = p->nonfinite == WEFT_NONFINITE_PROPAGATE;
    if (p->nonfinite == WEFT_NONFINITE_SKIP || (propagates && p->bits != 32)) {
        weft_error(p->log,
                   "accumulate: values that are not finite cannot be %s by blending on %d "
                   "bits",
                   propagates ? "propagated" : "skipped",
                   p->bits == WEFT_ACCUMULATE_HALF ? 16 : p->bits);
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

static enum weft_result create(weft_accumulator *a)
{
    const enum weft_result res = check_params(&a->params);
    struct method *m = res == WEFT_OK ? calloc(1, sizeof *m) : NULL;
    a->own = m;
    if (res != WEFT_OK)
        return res;
    if (!m) {
        weft_error(a->params.log, "accumulate: not enough memory");
        return WEFT_ERR_MEMORY;
    }
    return weft_blend_target_create(a, a->params.bits, &m->target);
}

static void destroy(weft_accumulator *a)
{
    struct method *m = a->own;
    if (m)
        weft_blend_target_destroy(a, &m->target);
    free(m);
    a->own = NULL;
}

static enum weft_result add(weft_accumulator *a, const struct weft_frame *frame, double weight)
{
    struct method *m = a->own;
    double largest;
    enum weft_result res = weft_blend_target_check(a, m->target, frame, &largest);
    if (res != WEFT_OK)
        return res;
    const double constant = count_weight(a, m, weight, &m->progress);
    const struct weft_blend_step step = {
        .operation = a->known_total ? WEFT_BLEND_ADD : WEFT_BLEND_MIX,
        .constant = (float)constant,
        .weight = 1.0f,
    };
    if (constant > 0.0 || !has_codes(a))
        res = weft_blend_target_add(a, m->target, frame, &step);
    m->largest = fmax(m->largest, largest);
    return res;
}

static enum weft_result mean(weft_accumulator *a, int channel, float *out, size_t stride)
{
    const struct method *m = a->own;
    const struct weft_value_range *range = weft_blend_target_range(m->target);
    const struct weft_blend_reading reading = {
        .offset = has_codes(a) ? a->params.low : 0.0,
        .scale = gain_of(a, &m->progress) * (has_codes(a) ? range->size : 1.0),
        .divisor = 1.0,
    };
    return weft_blend_target_read(a, m->target, &reading, channel, out, stride);
}

static void report(const weft_accumulator *a, struct weft_accumulator_report *out)
{
    const struct method *m = a->own;
    struct progress s = m->progress;
    double largest = m->largest;
    weft_blend_target_report(a, m->target, out);
    if (s.count == 0.0) {
        s = expected(a, m);
        largest = weft_blend_target_range(m->target)->extent;
    }
    out->bound = bound_of(a, m, &s, largest);
    if (s.count > 0.0)
        out->weight_change = fmax(s.most - 1.0, 1.0 - s.least);
}

const struct weft_accumulate_way weft_accumulate_blend = {
    .method = WEFT_ACCUMULATE_BLEND,
    .create = create,
    .destroy = destroy,
    .add = add,
    .mean = mean,
    .report = report,
};
