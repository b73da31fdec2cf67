// SPDX-License-Identifier: BSD-3-Clause
// Sums on GL as a method: the shader multiplies each frame by its weight, blending adds it to a
// target of 32-bit floats, and what is read back is divided by the sum of weights in double.
//
// The bound holds for every GL whose products and sums are one of the two floats nearest to the
// exact ones, with those below 2^-126 as 0.
#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "passes/accumulate/blend_target.h"
#include "passes/accumulate/sums/state.h"

struct progress {
    double sum;       // of the weights, scaled
    double magnitude; // of |weights|
    double error;     // of the target, in the largest |value|
    double change;    // largest |w - w'| / |w|
    double count;     // of frames
};

struct method {
    weft_blend_target *target;
    int32_t exponent; // weights are scaled by 2^-exponent,
    int32_t scaled;   // 1: by the largest weight, or if they are not known by the first one
    struct progress progress;
    double largest; // |v| so far
};

// ---- weights and bounds -------------------------------------------------------------------------

#define ULP 0x1p-23

// A product is w v rounded, of a w that is rounded, and of a v that may be an integer.
static float count_weight(int32_t exponent, double weight, struct progress *s)
{
    const double scaled = ldexp(weight, -exponent);
    const float used = (float)scaled;
    const double change = fabs((double)used - scaled);
    s->sum += scaled;
    s->magnitude += fabs(scaled);
    s->error += 1.01 * (2.0 * ULP * fabs(scaled) + change) +
                (s->count > 0.0 ? ULP * (s->magnitude + s->error) : 0.0);
    s->change = fmax(s->change, change / fabs(scaled));
    s->count += 1.0;
    return used;
}

static double bound_of(const struct progress *s, double largest)
{
    const double smallest = 3.0 * s->count * (double)FLT_MIN;
    const double result = 0x1p-24 * largest * s->magnitude; // rounded to a float
    if (s->count == 0.0 || s->sum == 0.0)
        return INFINITY;
    return (s->error * largest + smallest + result) / fabs(s->sum) * (1.0 + 0x1p-20) + 0x1p-140;
}

static double expect(const struct weft_accumulator_params *p, int64_t frames)
{
    const struct weft_value_range range = weft_value_range_of(p);
    struct progress s = {0};
    for (int64_t i = 0; i < frames; i++)
        count_weight(0, 1.0, &s);
    return bound_of(&s, range.extent);
}

// A scale by which weights lie in [1, 2).
static int exponent_of(double weight)
{
    int exponent;
    frexp(weight, &exponent);
    return exponent - 1;
}

// ---- the method ---------------------------------------------------------------------------------

static enum weft_result create(weft_accumulator *a)
{
    const struct weft_accumulator_params *p = &a->params;
    double most = 0.0;
    struct method *m = calloc(1, sizeof *m);
    a->own = m;
    if (p->nonfinite == WEFT_NONFINITE_SKIP) {
        weft_error(p->log,
                   "accumulate: values that are not finite cannot be skipped by sums on GL");
        return WEFT_ERR_ARGUMENT;
    }
    if (!m) {
        weft_error(p->log, "accumulate: not enough memory");
        return WEFT_ERR_MEMORY;
    }
    a->params.bits = 32;
    for (int64_t i = 0; i < p->frame_count; i++)
        most = fmax(most, fabs(a->weight[i]));
    m->scaled = p->frame_count > 0;
    m->exponent = m->scaled ? exponent_of(most) : 0;
    return weft_blend_target_create(a, 32, &m->target);
}

static void destroy(weft_accumulator *a)
{
    struct method *m = a->own;
    if (m)
        weft_blend_target_destroy(a, &m->target);
    free(m);
    a->own = NULL;
}

// Sums that are no floats.
static enum weft_result check_sum(const weft_accumulator *a, const struct method *m, double weight,
                                  double largest)
{
    const double magnitude = m->progress.magnitude + fabs(ldexp(weight, -m->exponent));
    if (magnitude * fmax(largest, m->largest) < (double)FLT_MAX && magnitude < (double)FLT_MAX)
        return WEFT_OK;
    weft_error(a->params.log,
               "accumulate: frame %" PRId64 " of weight %g with values up to %g: sums on GL, whose "
               "first weight is about 2^%d, reach %g and end at %g",
               a->frames, weight, largest, m->exponent, magnitude * fmax(largest, m->largest),
               (double)FLT_MAX);
    return WEFT_ERR_LIMIT;
}

static enum weft_result add(weft_accumulator *a, const struct weft_frame *frame, double weight)
{
    struct method *m = a->own;
    double largest;
    enum weft_result res = weft_blend_target_check(a, m->target, frame, &largest);
    if (res != WEFT_OK)
        return res;
    if (!m->scaled)
        m->exponent = exponent_of(weight);
    m->scaled = 1;
    res = check_sum(a, m, weight, largest);
    if (res != WEFT_OK)
        return res;
    const struct weft_blend_step step = {
        .operation = WEFT_BLEND_SUM,
        .constant = 1.0f,
        .weight = count_weight(m->exponent, weight, &m->progress),
    };
    m->largest = fmax(m->largest, largest);
    return weft_blend_target_add(a, m->target, frame, &step);
}

static enum weft_result find_reading(const weft_accumulator *a, struct weft_blend_reading *out)
{
    const struct method *m = a->own;
    *out = (struct weft_blend_reading){.scale = 1.0, .divisor = m->progress.sum};
    if (m->progress.sum != 0.0)
        return WEFT_OK;
    weft_error(a->params.log, "accumulate: the weights so far add up to 0");
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result mean(weft_accumulator *a, int channel, float *out, size_t stride)
{
    const struct method *m = a->own;
    struct weft_blend_reading reading;
    const enum weft_result res = find_reading(a, &reading);
    return res == WEFT_OK ? weft_blend_target_read(a, m->target, &reading, channel, out, stride)
                          : res;
}

static enum weft_result draw_mean(weft_accumulator *a, int channel, int channels,
                                  const struct weft_texture *texture)
{
    const struct method *m = a->own;
    struct weft_blend_reading reading;
    const enum weft_result res = find_reading(a, &reading);
    return res == WEFT_OK
               ? weft_blend_target_draw(a, m->target, &reading, channel, channels, texture)
               : res;
}

static void report(const weft_accumulator *a, struct weft_accumulator_report *out)
{
    const struct method *m = a->own;
    const bool begun = m->progress.count > 0.0;
    struct progress s = m->progress;
    weft_blend_target_report(a, m->target, out);
    for (int64_t i = 0; !begun && i < a->params.frame_count; i++)
        if (a->weight[i] != 0.0)
            count_weight(m->exponent, a->weight[i], &s);
    out->bound = bound_of(&s, begun ? m->largest : weft_blend_target_range(m->target)->extent);
    out->weight_change = s.change;
}

static enum weft_result save(weft_accumulator *a, weft_state *state)
{
    const struct method *m = a->own;
    weft_state_put(state, &m->exponent, sizeof m->exponent);
    weft_state_put(state, &m->scaled, sizeof m->scaled);
    weft_state_put(state, &m->progress, sizeof m->progress);
    weft_state_put(state, &m->largest, sizeof m->largest);
    return weft_blend_target_save(a, m->target, state);
}

static enum weft_result load(weft_accumulator *a, weft_state *state)
{
    struct method *m = a->own;
    weft_state_take(state, &m->exponent, sizeof m->exponent);
    weft_state_take(state, &m->scaled, sizeof m->scaled);
    weft_state_take(state, &m->progress, sizeof m->progress);
    weft_state_take(state, &m->largest, sizeof m->largest);
    return weft_blend_target_load(a, m->target, state);
}

const struct weft_accumulate_way weft_accumulate_float = {
    .method = WEFT_ACCUMULATE_FLOAT,
    .negative = true,
    .create = create,
    .destroy = destroy,
    .add = add,
    .mean = mean,
    .draw_mean = draw_mean,
    .expect = expect,
    .report = report,
    .save = save,
    .load = load,
};
