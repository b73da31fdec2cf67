// SPDX-License-Identifier: BSD-3-Clause
#include "passes/accumulate/buffer_impl.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "filter/threads.h"
#include "passes/accumulate/values.h"

const char *const weft_accum_rounding_names[] = {"nearest", "truncate", NULL};

enum { LARGEST = 32767 }; // code
enum { PART = 1 << 16 };  // values of a part of the work, at least
enum { CHUNK = WEFT_VALUE_CHUNK };

struct weft_accum_buffer {
    struct weft_accum_buffer_params params;
    size_t plane; // values of a channel
    void *values; // channel after channel: int16_t or float
};

// ---- buffers ------------------------------------------------------------------------------------

static size_t value_size(const weft_accum_buffer *b)
{
    return b->params.bits == 16 ? sizeof(int16_t) : sizeof(float);
}

static enum weft_result check_params(const struct weft_accum_buffer_params *p)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, p->width > 0 && p->height > 0);
    weft_require(p->log, p->channel_count > 0);
    weft_require(p->log, p->bits == 0 || p->bits == 16 || p->bits == 32);
    weft_require_enum(p->log, p->rounding, WEFT_ACCUM_ROUNDING_COUNT - 1);
    res = WEFT_OK;
fail:
    return res;
}

enum weft_result weft_accum_buffer_create(const struct weft_accum_buffer_params *params,
                                          weft_accum_buffer **out)
{
    *out = NULL;
    size_t count;
    struct weft_cpu cpu;
    enum weft_result res = check_params(params);
    if (res == WEFT_OK)
        res = weft_cpu_resolve(params->log, &params->cpu, &cpu);
    if (res != WEFT_OK)
        return res;
    weft_accum_buffer *b = calloc(1, sizeof *b);
    if (b) {
        b->params = *params;
        b->params.bits = params->bits ? params->bits : 16;
        b->params.cpu = cpu;
        b->plane = (size_t)params->width * (size_t)params->height;
        if (weft_size_mul(b->plane, (size_t)params->channel_count, &count))
            b->values = calloc(count, value_size(b));
    }
    if (!b || !b->values) {
        weft_error(params->log,
                   "accumulation buffer: not enough memory for %d channels of %" PRId32
                   " x %" PRId32 " pixels",
                   params->channel_count, params->width, params->height);
        weft_accum_buffer_destroy(&b);
        return WEFT_ERR_MEMORY;
    }
    *out = b;
    return WEFT_OK;
}

void weft_accum_buffer_destroy(weft_accum_buffer **buffer)
{
    if (!buffer || !*buffer)
        return;
    free((*buffer)->values);
    free(*buffer);
    *buffer = NULL;
}

void *weft_accum_buffer_values(const weft_accum_buffer *b, size_t *bytes)
{
    *bytes = b->plane * (size_t)b->params.channel_count * value_size(b);
    return b->values;
}

// ---- codes --------------------------------------------------------------------------------------

// Adding this rounds |x| < 2^22 to an integer, halves to even; taking it away leaves the integer.
#define TO_INTEGER 0x1.8p23f

// A product as a change of a code, which needs no more than twice the range. NAN: the least.
static inline int32_t code_of(float x, bool truncate)
{
    const float most = 2.0f * LARGEST;
    x = x > -most ? x : -most;
    x = x < most ? x : most;
    return (int32_t)(truncate ? x : (x + TO_INTEGER) - TO_INTEGER);
}

static inline int16_t in_range(int32_t code)
{
    code = code > -LARGEST ? code : -LARGEST;
    return (int16_t)(code < LARGEST ? code : LARGEST);
}

// Loops whose `truncate` is known when they are compiled.
#define BOTH_ROUNDINGS(loop)                                                                       \
    if (truncate)                                                                                  \
        for (size_t i = 0; i < count; i++)                                                         \
            loop(true);                                                                            \
    else                                                                                           \
        for (size_t i = 0; i < count; i++)                                                         \
        loop(false)

static void add_frame_codes(const float *v, float scale, bool truncate, int16_t *a, size_t count)
{
#define ADD(rounding) a[i] = in_range(a[i] + code_of(v[i] * scale, rounding))
    BOTH_ROUNDINGS(ADD);
#undef ADD
}

static void multiply_codes(float value, bool truncate, int16_t *a, size_t count)
{
#define MULTIPLY(rounding) a[i] = in_range(code_of((float)a[i] * value, rounding))
    BOTH_ROUNDINGS(MULTIPLY);
#undef MULTIPLY
}

static void add_codes(int32_t code, int16_t *a, size_t count)
{
    for (size_t i = 0; i < count; i++)
        a[i] = in_range(a[i] + code);
}

// ---- operations ---------------------------------------------------------------------------------

enum operation { LOAD, ACCUM, ADD, MULT };

struct work {
    weft_accum_buffer *buffer;
    enum operation operation;
    const struct weft_plane *planes;      // LOAD, ACCUM
    const struct weft_value_range *range; // of them; NULL: as they are
    double value;
    int32_t rows; // of a part
    size_t bands; // of a plane
};

// Codes of frames stay what they are: what one stands for is part of the scale, but where Mesa's
// arithmetic is wanted.
static double frame_values(const struct work *w, const struct weft_plane *plane, int32_t x,
                           int32_t y, int32_t count, float *out)
{
    const struct weft_accum_buffer_params *p = &w->buffer->params;
    const bool bytes = plane->type == WEFT_PLANE_UNORM8;
    if ((!bytes && plane->type != WEFT_PLANE_UNORM16) || w->range) {
        weft_value_chunk(plane, p->width, x, y, count, out);
        if (w->range)
            weft_value_range_apply(w->range, out, (size_t)count);
        return 1.0;
    }
    const size_t step = plane->step ? plane->step : 1;
    const size_t stride = plane->stride ? plane->stride : (size_t)p->width * step;
    const size_t first = (size_t)y * stride + (size_t)x * step;
    const float one = bytes ? 1.0f / 255.0f : 1.0f / 65535.0f;
    const bool mesa = p->bits == 16 && p->rounding == WEFT_ACCUM_TRUNCATE;
    const float factor = mesa ? one : 1.0f;
    if (bytes) {
        const uint8_t *codes = (const uint8_t *)plane->values + first;
        for (int32_t i = 0; i < count; i++)
            out[i] = (float)codes[(size_t)i * step] * factor;
    } else {
        const uint16_t *codes = (const uint16_t *)plane->values + first;
        for (int32_t i = 0; i < count; i++)
            out[i] = (float)codes[(size_t)i * step] * factor;
    }
    return mesa ? 1.0 : bytes ? 1.0 / 255.0 : 1.0 / 65535.0;
}

static void work_on_codes(const struct work *w, const float *v, double one, int16_t *a,
                          size_t count)
{
    const bool truncate = w->buffer->params.rounding == WEFT_ACCUM_TRUNCATE;
    const float value = (float)w->value, scale = value * (float)LARGEST;
    switch (w->operation) {
    case LOAD:
        memset(a, 0, count * sizeof *a); // fall through
    case ACCUM:
        add_frame_codes(v, truncate ? scale : (float)(w->value * one * LARGEST), truncate, a,
                        count);
        return;
    case ADD:
        add_codes(code_of(truncate ? scale : (float)(w->value * LARGEST), truncate), a, count);
        return;
    case MULT:
        multiply_codes(value, truncate, a, count);
        return;
    }
}

static void work_on_floats(const struct work *w, const float *v, double one, float *a, size_t count)
{
    const float value = (float)w->value, scale = (float)(w->value * one);
    switch (w->operation) {
    case LOAD:
        for (size_t i = 0; i < count; i++)
            a[i] = v[i] * scale;
        return;
    case ACCUM:
        for (size_t i = 0; i < count; i++)
            a[i] += v[i] * scale;
        return;
    case ADD:
        for (size_t i = 0; i < count; i++)
            a[i] += value;
        return;
    case MULT:
        for (size_t i = 0; i < count; i++)
            a[i] *= value;
        return;
    }
}

static void work_on_chunk(const struct work *w, int channel, int32_t x, int32_t y, int32_t count)
{
    weft_accum_buffer *b = w->buffer;
    const size_t at = (size_t)channel * b->plane + (size_t)y * (size_t)b->params.width + (size_t)x;
    float v[CHUNK];
    double one = 1.0;
    if (w->planes)
        one = frame_values(w, &w->planes[channel], x, y, count, v);
    if (b->params.bits == 16)
        work_on_codes(w, v, one, (int16_t *)b->values + at, (size_t)count);
    else
        work_on_floats(w, v, one, (float *)b->values + at, (size_t)count);
}

static bool work_on_part(void *priv, int thread, size_t i)
{
    (void)thread;
    const struct work *w = priv;
    const struct weft_accum_buffer_params *p = &w->buffer->params;
    const int channel = (int)(i / w->bands);
    const int64_t first = (int64_t)(i % w->bands) * w->rows, end = first + w->rows;
    for (int32_t y = (int32_t)first; y < end && y < p->height; y++)
        for (int32_t x = 0; x < p->width; x += CHUNK)
            work_on_chunk(w, channel, x, y, p->width - x < CHUNK ? p->width - x : CHUNK);
    return true;
}

// A thread costs as much as some part of the work.
static int threads_worth(const weft_accum_buffer *b)
{
    const size_t worth = b->plane * (size_t)b->params.channel_count / PART + 1;
    return worth < (size_t)b->params.cpu.threads ? (int)worth : b->params.cpu.threads;
}

static enum weft_result operate(struct work *w)
{
    const struct weft_accum_buffer_params *p = &w->buffer->params;
    const bool frames = w->operation == LOAD || w->operation == ACCUM;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, isfinite((float)w->value));
    for (int c = 0; frames && c < p->channel_count; c++) {
        weft_require(p->log, w->planes[c].values != NULL);
        weft_require_enum(p->log, w->planes[c].type, WEFT_PLANE_TYPE_COUNT - 1);
    }
    w->rows = PART / p->width > 1 ? PART / p->width : 1;
    w->bands = ((size_t)p->height + (size_t)w->rows - 1) / (size_t)w->rows;
    weft_threads_run(threads_worth(w->buffer), w->bands * (size_t)p->channel_count, work_on_part,
                     w);
    res = WEFT_OK;
fail:
    return res;
}

enum weft_result weft_accum_buffer_load(weft_accum_buffer *b, const struct weft_plane *planes,
                                        double value)
{
    struct work w = {.buffer = b, .operation = LOAD, .planes = planes, .value = value};
    return operate(&w);
}

enum weft_result weft_accum_buffer_accum(weft_accum_buffer *b, const struct weft_plane *planes,
                                         double value)
{
    return weft_accum_buffer_accum_within(b, planes, NULL, value);
}

enum weft_result weft_accum_buffer_accum_within(weft_accum_buffer *b,
                                                const struct weft_plane *planes,
                                                const struct weft_value_range *range, double value)
{
    struct work w = {
        .buffer = b,
        .operation = ACCUM,
        .planes = planes,
        .range = range && !range->whole ? range : NULL,
        .value = value,
    };
    return operate(&w);
}

enum weft_result weft_accum_buffer_add(weft_accum_buffer *b, double value)
{
    struct work w = {.buffer = b, .operation = ADD, .value = value};
    return operate(&w);
}

enum weft_result weft_accum_buffer_mult(weft_accum_buffer *b, double value)
{
    struct work w = {.buffer = b, .operation = MULT, .value = value};
    return operate(&w);
}

// ---- results ------------------------------------------------------------------------------------

struct result {
    double scale, offset, low, high;
};

static void write_row(const weft_accum_buffer *b, const struct result *r, size_t first, float *out)
{
    const bool codes = b->params.bits == 16;
    const double scale = codes ? r->scale / LARGEST : r->scale;
    for (size_t x = 0; x < (size_t)b->params.width; x++) {
        const double a =
            codes ? ((const int16_t *)b->values)[first + x] : ((const float *)b->values)[first + x];
        const double value = r->offset + a * scale;
        out[x] = (float)(value < r->low ? r->low : value > r->high ? r->high : value);
    }
}

static enum weft_result write_result(const weft_accum_buffer *b, struct result r, int channel,
                                     float *out, size_t stride)
{
    const struct weft_accum_buffer_params *p = &b->params;
    const size_t width = (size_t)p->width, step = stride ? stride : width;
    const size_t first = (size_t)channel * b->plane;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, isfinite(r.scale) && isfinite(r.offset));
    weft_require(p->log, channel >= 0 && channel < p->channel_count);
    weft_require(p->log, out && step >= width);
    for (size_t y = 0; y < (size_t)p->height; y++)
        write_row(b, &r, first + y * width, out + y * step);
    res = WEFT_OK;
fail:
    return res;
}

enum weft_result weft_accum_buffer_return(const weft_accum_buffer *b, double value, int channel,
                                          float *out, size_t stride)
{
    const struct result r = {.scale = value, .low = 0.0, .high = 1.0};
    return write_result(b, r, channel, out, stride);
}

enum weft_result weft_accum_buffer_read(const weft_accum_buffer *b, double scale, double offset,
                                        int channel, float *out, size_t stride)
{
    const struct result r = {.scale = scale, .offset = offset, .low = -INFINITY, .high = INFINITY};
    return write_result(b, r, channel, out, stride);
}
