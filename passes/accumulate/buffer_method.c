// SPDX-License-Identifier: BSD-3-Clause
// The accumulation buffer as a method. The buffer holds sum w t / C, t being the places of frames'
// values in the range and C the larger one of the sums of positive and of negative weights, so
// that no sum leaves [-1, 1]: for weights that are not negative C is their sum. Where it is known
// beforehand each frame is one accum, otherwise C grows and the buffer is multiplied before.
#include <math.h>
#include <stdlib.h>

#include "passes/accumulate/buffer_impl.h"
#include "passes/accumulate/frame.h"
#include "passes/accumulate/values.h"

// How far the sums are, and what they may be wrong by.
struct sums {
    double positive, negative; // sums of |w| of either sign
    double whole;              // C
    // Bound of |a - sum w t / C|: in codes, or of floats in the largest |v|.
    double error;
};

struct method {
    weft_accum_buffer *buffer;
    struct weft_value_range range;
    struct sums known; // all weights, where they are known; {0} otherwise
    struct sums sums;  // so far
    double largest;    // |v| so far
};

// ---- bounds -------------------------------------------------------------------------------------

#define HALF_ULP 0x1p-24

// Of an operation on codes.
static double code_error(const weft_accumulator *a)
{
    return a->params.rounding == WEFT_TREE_TRUNCATE ? WEFT_ACCUM_TRUNCATE_ERROR : WEFT_ACCUM_ERROR;
}

// Multiplied by C / C': the factor and the product are rounded.
static double error_multiplied(const weft_accumulator *a, const struct sums *s, double factor)
{
    const double values = (s->positive + s->negative) / s->whole;
    const double error = factor * s->error;
    if (a->params.bits == 16)
        return error + code_error(a);
    return error + 2.01 * HALF_ULP * (factor * values + error);
}

// The weight and the product are rounded, and of floats the value, where it is an integer, and the
// sum; t was wrong from the beginning.
static double error_added(const weft_accumulator *a, const struct weft_value_range *range,
                          const struct sums *s, double weight)
{
    const double share = fabs(weight) / s->whole, values = (s->positive + s->negative) / s->whole;
    if (a->params.bits == 16)
        return s->error + code_error(a) + 32767.0 * range->error * share;
    return s->error + 3.01 * HALF_ULP * share + 1.01 * HALF_ULP * (values + s->error);
}

// Counts a weight; returns what the buffer has to be multiplied by before.
static double count_weight(const weft_accumulator *a, const struct method *m, double weight,
                           struct sums *s)
{
    double factor = 1.0, whole = m->known.whole;
    struct sums next = *s;
    *(weight > 0.0 ? &next.positive : &next.negative) += fabs(weight);
    if (!whole)
        whole = fmax(next.positive, next.negative);
    if (s->whole && s->whole != whole) {
        factor = s->whole / whole;
        next.error = error_multiplied(a, s, factor);
    }
    next.whole = whole;
    next.error = error_added(a, &m->range, &next, weight);
    *s = next;
    return factor;
}

static double bound_of(const weft_accumulator *a, const struct method *m, const struct sums *s,
                       double largest)
{
    const double total = fabs(s->positive - s->negative);
    const double gain = s->whole / total, values = (s->positive + s->negative) / total;
    const double extent = a->params.bits == 16 ? m->range.extent : largest;
    const double unit = a->params.bits == 16 ? m->range.size / 32767.0 : largest;
    const double result = HALF_ULP * extent * values; // rounded to a float
    return total > 0.0 ? (gain * s->error * unit + result) * (1.0 + 0x1p-20) + 0x1p-120 : INFINITY;
}

static struct sums expected(const weft_accumulator *a, const struct method *m)
{
    struct sums s = {0};
    for (int64_t i = 0; i < a->params.frame_count; i++)
        if (a->weight[i] != 0.0)
            count_weight(a, m, a->weight[i], &s);
    return s;
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
    m->range = weft_value_range_of(p);
    for (int64_t i = 0; i < p->frame_count; i++)
        *(a->weight[i] > 0.0 ? &m->known.positive : &m->known.negative) += fabs(a->weight[i]);
    m->known.whole = fmax(m->known.positive, m->known.negative);
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
    const double factor = count_weight(a, m, weight, &sums);
    if (factor != 1.0)
        res = weft_accum_buffer_mult(m->buffer, factor);
    if (res == WEFT_OK)
        res = weft_accum_buffer_accum_within(m->buffer, planes, codes ? &m->range : NULL,
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
    return weft_accum_buffer_read(m->buffer, m->sums.whole / total * (codes ? m->range.size : 1.0),
                                  codes ? a->params.low : 0.0, channel, out, stride);
}

static void report(const weft_accumulator *a, struct weft_accumulator_report *out)
{
    const struct method *m = a->own;
    size_t bytes;
    weft_accum_buffer_values(m->buffer, &bytes);
    out->bytes += bytes;
    if (a->counted) {
        out->bound = bound_of(a, m, &m->sums, m->largest);
    } else {
        const struct sums sums = expected(a, m);
        out->bound = bound_of(a, m, &sums, m->range.extent);
    }
}

const struct weft_accumulate_way weft_accumulate_buffer = {
    .method = WEFT_ACCUMULATE_BUFFER,
    .negative = true,
    .create = create,
    .destroy = destroy,
    .add = add,
    .mean = mean,
    .report = report,
};
