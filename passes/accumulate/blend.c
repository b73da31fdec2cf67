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
#include "passes/accumulate/sums/state.h"

// What blending does to errors.
struct rules {
    int bits;
    bool codes;
    double one;        // the largest code
    double total;      // of the weights; 0: not known
    double ulp, least; // of floats: one unit in the last place, relative, and where it is smallest
    struct weft_value_range range;
};

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
    struct rules rules;
    struct progress progress;
    double largest; // |v| so far
};

static struct rules rules_of(const struct weft_accumulator_params *p, double total)
{
    return (struct rules){
        .bits = p->bits,
        .codes = p->bits == 8 || p->bits == 16,
        .one = p->bits == 8 ? 255.0 : 65535.0,
        .total = total,
        .ulp = p->bits == 32 ? 0x1p-23 : 0x1p-10,
        .least = p->bits == 32 ? 0x1p-126 : 0x1p-24,
        .range = weft_value_range_of(p),
    };
}

// ---- weights ------------------------------------------------------------------------------------

// The constant of a frame whose share is exactly `share`. Added codes follow the sum of shares, so
// that they add up to the largest code.
static double constant_of(const struct rules *r, const struct progress *s, double share)
{
    if (!r->codes)
        return (double)(float)share;
    if (!r->total)
        return rint(share * r->one) / r->one;
    const double all = fmin(s->sum / r->total, 1.0);
    return (rint(all * r->one) - s->placed) / r->one;
}

static void count_change(const struct rules *r, struct progress *s, double share, double constant)
{
    const double ratio = constant / share;
    if (!r->total && share < 1.0) { // what there was is mixed with the rest
        const double rest = (1.0 - constant) / (1.0 - share);
        s->least *= rest;
        s->most *= rest;
    }
    s->least = s->count == 0.0 ? ratio : fmin(s->least, ratio);
    s->most = s->count == 0.0 ? ratio : fmax(s->most, ratio);
}

// ---- bounds -------------------------------------------------------------------------------------

// d + s c: the value and the product are rounded.
static void add_codes(const struct rules *r, struct progress *s, double share, double c)
{
    const double change = (c - share) * r->one;
    if (c > 0.0)
        s->error += c * (1.0 + r->range.error * r->one) + (c < 1.0 ? 1.0 : 0.0);
    *(change > 0.0 ? &s->above : &s->below) += fabs(change);
    s->placed += c * r->one;
}

// d (1 - c) + s c: the value and both products are rounded, and frame and mean differ by less than
// the range where c is not the share.
static void mix_codes(const struct rules *r, struct progress *s, double share, double c)
{
    s->error = (1.0 - c) * s->error + c * (1.0 + r->range.error * r->one) +
               fabs(c - share) * r->one + (c > 0.0 && c < 1.0 ? 2.0 : 0.0);
}

// The value, the constant, their product and the sum are rounded; values that are integers were
// before.
static void add_floats(const struct rules *r, struct progress *s, double share)
{
    const double values = s->sum / r->total;
    s->error += (3.1 * r->ulp + 0x1p-23) * share + r->ulp * (values + s->error);
}

// The value, the constant, its complement, both products and the sum; frame and mean differ by
// twice the largest value at most.
static void mix_floats(const struct rules *r, struct progress *s, double share)
{
    if (share == 1.0)
        s->error = r->ulp;
    else
        s->error = (1.0 - share) * s->error * (1.0 + 4.0 * r->ulp) +
                   1.01 * r->ulp * (3.0 + 2.0 * share) + 0x1p-22 * share;
}

// Counts a weight and returns the constant that the frame is blended with.
static double count_weight(const struct rules *r, double weight, struct progress *s)
{
    s->sum += weight;
    const double share = weight / (r->total ? r->total : s->sum);
    const double c = constant_of(r, s, share);
    count_change(r, s, share, c);
    s->count += 1.0;
    if (r->codes)
        (r->total ? add_codes : mix_codes)(r, s, share, c);
    else
        (r->total ? add_floats : mix_floats)(r, s, share);
    return c;
}

// What the target is multiplied by to be a mean of the frames so far.
static double gain_of(const struct rules *r, const struct progress *s)
{
    return r->total ? r->total / s->sum : 1.0;
}

static double bound_of(const struct rules *r, const struct progress *s, double largest)
{
    const double gain = gain_of(r, s), result = 0x1p-24 * (r->codes ? r->range.extent : largest);
    if (s->count == 0.0)
        return INFINITY;
    if (r->codes) {
        const double codes = s->error + fmax(s->above, s->below);
        return gain * codes / r->one * r->range.size * (1.0 + 0x1p-20) + result;
    }
    return gain * (s->error * largest + 4.0 * s->count * r->least) * (1.0 + 0x1p-20) + result;
}

static double expect(const struct weft_accumulator_params *p, int64_t frames)
{
    const struct rules r = rules_of(p, p->frame_count > 0 ? (double)frames : 0.0);
    struct progress s = {0};
    for (int64_t i = 0; i < frames; i++)
        count_weight(&r, 1.0, &s);
    return bound_of(&r, &s, r.range.extent);
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
    m->rules = rules_of(&a->params, a->known_total);
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
    const double constant = count_weight(&m->rules, weight, &m->progress);
    const struct weft_blend_step step = {
        .operation = m->rules.total ? WEFT_BLEND_ADD : WEFT_BLEND_MIX,
        .constant = (float)constant,
        .weight = 1.0f,
    };
    if (constant > 0.0 || !m->rules.codes)
        res = weft_blend_target_add(a, m->target, frame, &step);
    m->largest = fmax(m->largest, largest);
    return res;
}

static struct weft_blend_reading reading_of(const weft_accumulator *a)
{
    const struct method *m = a->own;
    const struct rules *r = &m->rules;
    return (struct weft_blend_reading){
        .offset = r->codes ? a->params.low : 0.0,
        .scale = gain_of(r, &m->progress) * (r->codes ? r->range.size : 1.0),
        .divisor = 1.0,
    };
}

static enum weft_result mean(weft_accumulator *a, int channel, float *out, size_t stride)
{
    const struct method *m = a->own;
    const struct weft_blend_reading reading = reading_of(a);
    return weft_blend_target_read(a, m->target, &reading, channel, out, stride);
}

static enum weft_result draw_mean(weft_accumulator *a, int channel, int channels,
                                  const struct weft_texture *texture)
{
    const struct method *m = a->own;
    const struct weft_blend_reading reading = reading_of(a);
    return weft_blend_target_draw(a, m->target, &reading, channel, channels, texture);
}

static void report(const weft_accumulator *a, struct weft_accumulator_report *out)
{
    const struct method *m = a->own;
    const bool begun = m->progress.count > 0.0;
    struct progress s = m->progress;
    weft_blend_target_report(a, m->target, out);
    for (int64_t i = 0; !begun && i < a->params.frame_count; i++)
        if (a->weight[i] != 0.0)
            count_weight(&m->rules, a->weight[i], &s);
    out->bound = bound_of(&m->rules, &s, begun ? m->largest : m->rules.range.extent);
    if (s.count > 0.0)
        out->weight_change = fmax(s.most - 1.0, 1.0 - s.least);
}

static enum weft_result save(weft_accumulator *a, weft_state *state)
{
    const struct method *m = a->own;
    weft_state_put(state, &m->progress, sizeof m->progress);
    weft_state_put(state, &m->largest, sizeof m->largest);
    return weft_blend_target_save(a, m->target, state);
}

static enum weft_result load(weft_accumulator *a, weft_state *state)
{
    struct method *m = a->own;
    weft_state_take(state, &m->progress, sizeof m->progress);
    weft_state_take(state, &m->largest, sizeof m->largest);
    return weft_blend_target_load(a, m->target, state);
}

const struct weft_accumulate_way weft_accumulate_blend = {
    .method = WEFT_ACCUMULATE_BLEND,
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
