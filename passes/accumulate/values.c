// SPDX-License-Identifier: BSD-3-Clause
#include "passes/accumulate/values.h"

#include <inttypes.h>
#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "passes/accumulate/sums/blocks.h"

// ---- checks -------------------------------------------------------------------------------------

struct check {
    const weft_accumulator *a;
    const struct weft_plane *planes;
    const struct weft_value_limits *limits;
    float low, high;
    _Atomic uint64_t nonfinite;
    _Atomic int32_t largest; // as bits
    _Atomic bool bad;
};

static bool is_refused(const struct check *c, float value)
{
    if (c->limits)
        return !(value >= c->low && value <= c->high);
    return !isfinite(value) && c->a->params.nonfinite != WEFT_NONFINITE_PROPAGATE;
}

// Codes are what they are.
static bool need_none(const struct check *c, enum weft_plane_type type)
{
    const bool codes = type == WEFT_PLANE_UNORM8 || type == WEFT_PLANE_UNORM16;
    return codes && (!c->limits || (c->low <= 0.0f && c->high >= 1.0f));
}

static inline uint32_t bits_of(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

enum { SIZE = 0x7fffffff, INFINITE = 0x7f800000 };

// Largest |value| as bits, which are in the order of sizes; *beyond: a sign where any value is not
// within the limits. Without branches, so that it is made in vectors.
static int32_t look_at(const struct check *c, const float *values, size_t count, uint32_t *beyond)
{
    const float low = c->low, high = c->high;
    int32_t largest = 0;
    uint32_t signs = 0;
    for (size_t i = 0; i < count; i++) {
        const int32_t size = (int32_t)(bits_of(values[i]) & SIZE);
        largest = size > largest ? size : largest;
        signs |= bits_of(values[i] - low + 0.0f) | bits_of(high - values[i] + 0.0f); // no -0
    }
    *beyond = signs;
    return largest;
}

static void raise_largest(struct check *c, int32_t size)
{
    int32_t known = atomic_load_explicit(&c->largest, memory_order_relaxed);
    while (size > known && !atomic_compare_exchange_weak(&c->largest, &known, size))
        ;
}

static void check_floats(struct check *c, const float *values, size_t count)
{
    uint32_t beyond;
    int32_t largest = look_at(c, values, count, &beyond);
    if (largest >= INFINITE) {
        largest = 0;
        for (size_t i = 0; i < count; i++) {
            const int32_t size = (int32_t)(bits_of(values[i]) & SIZE);
            c->nonfinite += size >= INFINITE;
            largest = size < INFINITE && size > largest ? size : largest;
        }
        if (c->limits || c->a->params.nonfinite != WEFT_NONFINITE_PROPAGATE)
            c->bad = true;
    }
    if (c->limits && beyond >> 31)
        c->bad = true;
    raise_largest(c, largest);
}

static bool check_block(void *priv, int thread, const struct weft_block *block)
{
    struct check *c = priv;
    float memory[WEFT_BLOCK_VALUES];
    (void)thread;
    if (!need_none(c, block->type))
        check_floats(c, weft_block_floats(block, memory), block->count);
    return true;
}

static void log_refused(const struct check *c, int channel, int32_t x, int32_t y, float value)
{
    const weft_accumulator *a = c->a;
    if (isfinite(value))
        weft_error(a->params.log,
                   "accumulate: frame %" PRId64 ", channel %d, pixel (%d, %d): %g is not within %g "
                   "to %g",
                   a->frames, channel, x, y, value, c->limits->low, c->limits->high);
    else
        weft_error(a->params.log, "accumulate: frame %" PRId64 ", channel %d, pixel (%d, %d): %g",
                   a->frames, channel, x, y, value);
}

// The first one, in the order of channels and rows.
static void find_refused(const struct check *c)
{
    const struct weft_accumulator_params *p = &c->a->params;
    for (int channel = 0; channel < p->channel_count; channel++) {
        struct weft_plane pixel = c->planes[channel];
        const size_t step = pixel.step ? pixel.step : 1;
        for (int32_t y = 0; y < p->height; y++)
            for (int32_t x = 0; x < p->width; x++) {
                float value;
                pixel.values = (const char *)weft_plane_line(&c->planes[channel], y, p->width) +
                               (size_t)x * step * weft_plane_type_size(pixel.type);
                weft_plane_row(&pixel, 0, 1, &value, 1);
                if (!is_refused(c, value))
                    continue;
                log_refused(c, channel, x, y, value);
                return;
            }
    }
}

enum weft_result weft_frame_check(weft_accumulator *a, const struct weft_plane *planes,
                                  const struct weft_value_limits *limits, double *largest)
{
    const struct weft_frame_shape shape = weft_accumulator_shape(a);
    struct check c = {
        .a = a,
        .planes = planes,
        .limits = limits,
        .low = limits ? (float)limits->low : -INFINITY,
        .high = limits ? (float)limits->high : INFINITY,
    };
    float value = 0.0f;
    bool codes = false, others = false;
    for (int i = 0; i < shape.channel_count; i++)
        *(need_none(&c, planes[i].type) ? &codes : &others) = true;
    if (others)
        weft_blocks_run(&shape, planes, NULL, check_block, &c);
    const int32_t bits = c.largest;
    memcpy(&value, &bits, sizeof value);
    if (largest)
        *largest = codes && value < 1.0f ? 1.0 : (double)value;
    if (c.bad) {
        find_refused(&c);
        return WEFT_ERR_FORMAT;
    }
    if (!a->scan)
        a->nonfinite += c.nonfinite;
    return WEFT_OK;
}

// ---- the range ----------------------------------------------------------------------------------

struct weft_value_range weft_value_range_of(const struct weft_accumulator_params *params)
{
    const double size = params->high - params->low;
    const double extent = fmax(fabs(params->low), fabs(params->high));
    const bool whole = params->low == 0.0 && params->high == 1.0;
    return (struct weft_value_range){
        .low = (float)params->low,
        .scale = (float)(1.0 / size),
        .whole = whole,
        .size = size,
        // v of integers and low are rounded to floats, and so are the difference, the scale and
        // the product.
        .error = whole ? 0.0 : 0x1p-24 * (3.0 + 2.0 * extent / size),
        .extent = extent,
    };
}

void weft_value_range_apply(const struct weft_value_range *range, float *values, size_t count)
{
    const float low = range->low, scale = range->scale;
    for (size_t i = 0; i < count && !range->whole; i++)
        values[i] = (values[i] - low) * scale;
}
