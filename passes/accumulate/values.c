// SPDX-License-Identifier: BSD-3-Clause
#include "passes/accumulate/values.h"

#include <inttypes.h>
#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "filter/threads.h"
#include "passes/accumulate/frame.h"

void weft_value_chunk(const struct weft_plane *plane, int32_t width, int32_t x, int32_t y,
                      int32_t count, float *out)
{
    const size_t step = plane->step ? plane->step : 1;
    struct weft_plane part = *plane;
    part.values =
        (const char *)plane->values + (size_t)x * step * weft_plane_type_size(plane->type);
    part.stride = plane->stride ? plane->stride : (size_t)width * step;
    weft_plane_row(&part, y, count, out, 1);
}

// ---- checks -------------------------------------------------------------------------------------

enum { PART = 1 << 16, CHUNK = WEFT_VALUE_CHUNK }; // values of a part, and of a step of it

struct check {
    const weft_accumulator *a;
    const struct weft_plane *planes;
    const struct weft_value_limits *limits;
    float low, high;
    int32_t rows; // of a part
    size_t bands; // of a plane
    _Atomic uint64_t nonfinite;
    _Atomic uint32_t largest; // as bits, which are in the order of the values
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

// Without branches, so that it is made in vectors; what is bad is looked for where there is any.
static void check_floats(struct check *c, const float *values, size_t count)
{
    uint32_t largest = 0, nonfinite = 0, beyond = 0;
    for (size_t i = 0; i < count; i++) {
        uint32_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        bits &= 0x7fffffffu;
        const uint32_t finite = bits < 0x7f800000u;
        nonfinite += !finite;
        beyond |= !(values[i] >= c->low) | !(values[i] <= c->high);
        bits = finite ? bits : 0;
        largest = bits > largest ? bits : largest;
    }
    uint32_t known = atomic_load_explicit(&c->largest, memory_order_relaxed);
    while (largest > known && !atomic_compare_exchange_weak(&c->largest, &known, largest))
        ;
    if (nonfinite)
        c->nonfinite += nonfinite;
    if (c->limits ? beyond : nonfinite && c->a->params.nonfinite != WEFT_NONFINITE_PROPAGATE)
        c->bad = true;
}

// Pixels x to x + CHUNK of a row, or to its end.
static size_t chunk_of(const struct check *c, int channel, int32_t y, int32_t x, float *out)
{
    const struct weft_accumulator_params *p = &c->a->params;
    const int32_t count = p->width - x < CHUNK ? p->width - x : CHUNK;
    weft_value_chunk(&c->planes[channel], p->width, x, y, count, out);
    return (size_t)count;
}

static bool check_part(void *priv, int thread, size_t i)
{
    (void)thread;
    struct check *c = priv;
    const struct weft_accumulator_params *p = &c->a->params;
    const int channel = (int)(i / c->bands);
    const int64_t first = (int64_t)(i % c->bands) * c->rows, end = first + c->rows;
    float values[CHUNK];
    if (need_none(c, c->planes[channel].type))
        return true;
    for (int32_t y = (int32_t)first; y < end && y < p->height; y++)
        for (int32_t x = 0; x < p->width; x += CHUNK)
            check_floats(c, values, chunk_of(c, channel, y, x, values));
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
    float values[CHUNK];
    for (int channel = 0; channel < p->channel_count; channel++)
        for (int32_t y = 0; y < p->height && !need_none(c, c->planes[channel].type); y++)
            for (int32_t x = 0; x < p->width; x += CHUNK) {
                const size_t count = chunk_of(c, channel, y, x, values);
                for (size_t i = 0; i < count; i++)
                    if (is_refused(c, values[i])) {
                        log_refused(c, channel, x + (int32_t)i, y, values[i]);
                        return;
                    }
            }
}

enum weft_result weft_frame_check(weft_accumulator *a, const struct weft_plane *planes,
                                  const struct weft_value_limits *limits, double *largest)
{
    const struct weft_accumulator_params *p = &a->params;
    const int32_t rows = PART / p->width > 1 ? PART / p->width : 1;
    struct check c = {
        .a = a,
        .planes = planes,
        .limits = limits,
        .low = limits ? (float)limits->low : -INFINITY,
        .high = limits ? (float)limits->high : INFINITY,
        .rows = rows,
        .bands = ((size_t)p->height + (size_t)rows - 1) / (size_t)rows,
    };
    float value = 0.0f;
    const size_t values = (size_t)p->width * (size_t)p->height * (size_t)p->channel_count;
    const int threads =
        values / PART + 1 < (size_t)p->cpu.threads ? (int)(values / PART + 1) : p->cpu.threads;
    weft_threads_run(threads, c.bands * (size_t)p->channel_count, check_part, &c);
    const uint32_t bits = c.largest;
    memcpy(&value, &bits, sizeof value);
    for (int i = 0; i < p->channel_count; i++)
        if (need_none(&c, planes[i].type) && value < 1.0f)
            value = 1.0f;
    if (largest)
        *largest = value;
    if (c.bad) {
        find_refused(&c);
        return WEFT_ERR_FORMAT;
    }
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
