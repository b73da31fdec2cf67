// SPDX-License-Identifier: BSD-3-Clause
// The accumulation buffer as a method. The buffer holds sum w t / C, t being the places of frames'
// values in the range and C the larger one of the sums of positive and of negative weights, so
// that no sum leaves [-1, 1]: for weights that are not negative C is their sum. Where it is known
// beforehand each frame is one accum, otherwise C grows and the buffer is multiplied before.
#include <math.h>
#include <stdlib.h>

#include "passes/accumulate/buffer_impl.h"
#include "passes/accumulate/frame.h"
#include "passes/accumulate/sums/state.h"
#include "passes/accumulate/values.h"

// What the sums do.
struct rules {
    int bits;
    double code_error; // of an operation on codes
    double whole;      // C, where it is known
    struct weft_value_range range;
};

// How far the sums are, and what they may be wrong by.
struct sums {
    double positive, negative; // sums of |w| of either sign
    double whole;              // C
    // Bound of |a - sum w t / C|: in codes, or of floats in the largest |v|.
    double error;
};

struct method {
    weft_accum_buffer *buffer;
    struct rules rules;
    struct sums sums; // so far
    double largest;   // |v| so far
};

// ---- bounds -------------------------------------------------------------------------------------

#define HALF_ULP 0x1p-24

static struct rules rules_of(const struct weft_accumulator_params *p, double whole)
{
    return (struct rules){
        .bits = p->bits,
        .code_error =
            p->rounding == WEFT_TREE_TRUNCATE ? WEFT_ACCUM_TRUNCATE_ERROR : WEFT_ACCUM_ERROR,
        .whole = whole,
        .range = weft_value_range_of(p),
    };
}

// Multiplied by C / C': the factor and the product are rounded.
static double error_multiplied(const struct rules *r, const struct sums *s, double factor)
{
    const double values = (s->positive + s->negative) / s->whole;
    const double error = factor * s->error;
    if (r->bits == 16)
        return error + r->code_error;
    return error + 2.01 * HALF_ULP * (factor * values + error);
}

// The weight and the product are rounded, and of floats the value, where it is an integer, and the
// sum; t was wrong from the beginning.
static double error_added(const struct rules *r, const struct sums *s, double weight)
{
    const double share = fabs(weight) / s->whole, values = (s->positive + s->negative) / s->whole;
    if (r->bits == 16)
        return s->error + r->code_error + 32767.0 * r->range.error * share;
    return s->error + 3.01 * HALF_ULP * share + 1.01 * HALF_ULP * (values + s->error);
}

// Counts a weight; returns what the buffer has to be multiplied by before.
static double count_weight(const struct rules *r, double weight, struct sums *s)
{
    double factor = 1.0;
    struct sums next = *s;
    *(weight > 0.0 ? &next.positive : &next.negative) += fabs(weight);
    next.whole = r->whole > 0.0 ? r->whole : fmax(next.positive, next.negative);
    if (s->whole > 0.0 && s->whole != next.whole) {
        factor = s->whole / next.whole;
        next.error = error_multiplied(r, s, factor);
    }
    next.error = error_added(r, &next, weight);
    *s = next;
    return factor;
}

static double bound_of(const struct rules *r, const struct sums *s, double largest)
{
    const double total = fabs(s->positive - s->negative);
    const double gain = s->whole / total, values = (s->positive + s->negative) / total;
    const double extent = r->bits == 16 ? r->range.extent : largest;
    const double unit = r->bits == 16 ? r->range.size / 32767.0 : largest;
    const double result = HALF_ULP * extent * values; // rounded to a float
    return total > 0.0 ? (gain * s->error * unit + result) * (1.0 + 0x1p-20) + 0x1p-120 : INFINITY;
}

static double expect(const struct weft_accumulator_params *p, int64_t frames)
{
    const struct rules r = rules_of(p, p->frame_count > 0 ? (double)frames : 0.0);
    struct sums s = {0};
    for (int64_t i = 0; i < frames; i++)
        count_weight(&r, 1.0, &s);
    return p->bits == 16 || p->bits == 32 ? bound_of(&r, &s, r.range.extent) : INFINITY;
}

// ---- the method ---------------------------------------------------------------------------------

static enum weft_result check_params(const struct weft_accumulator_params *p)
{
    if (p->bits != 16 && p->bits != 32) {
        weft_error(p->log, "accumulate: the buffer has 16 or 32 bits, not %d", p->bits);
        return WEFT_ERR_ARGUMENT;
    }
    if (p->nonfinite != WEFT_NONFINITE_ERROR) {
        weft_error(p->log, "accumulate: to the buffer values that are not finite are an error");
        return WEFT_ERR_ARGUMENT;
    }
    if (p->rounding == WEFT_TREE_UNBIASED) {
        weft_error(p->log, "accumulate: the buffer rounds to nearest or truncates");
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

static enum weft_result create(weft_accumulator *a)
{
    const struct weft_accumulator_params *p = &a->params;
    enum weft_result res = check_params(p);
    struct method *m = res == WEFT_OK ? calloc(1, sizeof *m) : NULL;
    a->own = m;
    if (res != WEFT_OK)
        return res;
    if (!m) {
        weft_error(p->log, "accumulate: not enough memory");
        return WEFT_ERR_MEMORY;
    }
    double positive = 0.0, negative = 0.0;
    for (int64_t i = 0; i < p->frame_count; i++)
        *(a->weight[i] > 0.0 ? &positive : &negative) += fabs(a->weight[i]);
    m->rules = rules_of(p, fmax(positive, negative));
    return weft_accum_buffer_create(
        &(struct weft_accum_buffer_params){
            .width = p->width,
            .height = p->height,
            .channel_count = p->channel_count,
            .bits = p->bits,
            .rounding =
                p->rounding == WEFT_TREE_TRUNCATE ? WEFT_ACCUM_TRUNCATE : WEFT_ACCUM_NEAREST,
            .cpu = p->cpu,
            .log = p->log,
        },
        &m->buffer);
}

static void destroy(weft_accumulator *a)
{
    struct method *m = a->own;
    if (m)
        weft_accum_buffer_destroy(&m->buffer);
    free(m);
    a->own = NULL;
}

static enum weft_result add(weft_accumulator *a, const struct weft_frame *frame, double weight)
{
    struct method *m = a->own;
    const bool codes = a->params.bits == 16;
    const struct weft_plane *planes = NULL;
    const struct weft_value_limits limits = {a->params.low, a->params.high};
    double largest;
    enum weft_result res = weft_frame_planes(a, frame, &planes);
    if (res == WEFT_OK)
        res = weft_frame_check(a, planes, codes && frame->plane ? &limits : NULL, &largest);
    if (res != WEFT_OK)
        return res;
    struct sums sums = m->sums;
    const double factor = count_weight(&m->rules, weight, &sums);
    if (factor != 1.0)
        res = weft_accum_buffer_mult(m->buffer, factor);
    if (res == WEFT_OK)
        res = weft_accum_buffer_accum_within(m->buffer, planes, codes ? &m->rules.range : NULL,
                                             weight / sums.whole);
    m->sums = sums;
    m->largest = fmax(m->largest, largest);
    return res;
}

static enum weft_result mean(weft_accumulator *a, int channel, float *out, size_t stride)
{
    const struct method *m = a->own;
    const bool codes = a->params.bits == 16;
    const double total = m->sums.positive - m->sums.negative;
    if (!(total != 0.0)) {
        weft_error(a->params.log, "accumulate: the weights so far add up to 0");
        return WEFT_ERR_ARGUMENT;
    }
    return weft_accum_buffer_read(m->buffer,
                                  m->sums.whole / total * (codes ? m->rules.range.size : 1.0),
                                  codes ? a->params.low : 0.0, channel, out, stride);
}

static void report(const weft_accumulator *a, struct weft_accumulator_report *out)
{
    const struct method *m = a->own;
    size_t bytes;
    weft_accum_buffer_values(m->buffer, &bytes);
    out->bytes += bytes;
    struct sums s = m->sums;
    for (int64_t i = 0; a->counted == 0 && i < a->params.frame_count; i++)
        if (a->weight[i] != 0.0)
            count_weight(&m->rules, a->weight[i], &s);
    out->bound = bound_of(&m->rules, &s, a->counted ? m->largest : m->rules.range.extent);
}

// ---- states -------------------------------------------------------------------------------------

static enum weft_result save(weft_accumulator *a, weft_state *state)
{
    const struct method *m = a->own;
    size_t bytes;
    const void *values = weft_accum_buffer_values(m->buffer, &bytes);
    weft_state_put(state, &m->sums, sizeof m->sums);
    weft_state_put(state, &m->largest, sizeof m->largest);
    weft_state_put(state, values, bytes);
    return WEFT_OK;
}

static enum weft_result load(weft_accumulator *a, weft_state *state)
{
    struct method *m = a->own;
    size_t bytes;
    void *values = weft_accum_buffer_values(m->buffer, &bytes);
    weft_state_take(state, &m->sums, sizeof m->sums);
    weft_state_take(state, &m->largest, sizeof m->largest);
    weft_state_take(state, values, bytes);
    return WEFT_OK;
}

const struct weft_accumulate_way weft_accumulate_buffer = {
    .method = WEFT_ACCUMULATE_BUFFER,
    .negative = true,
    .create = create,
    .destroy = destroy,
    .add = add,
    .mean = mean,
    .expect = expect,
    .report = report,
    .save = save,
    .load = load,
};
