// SPDX-License-Identifier: BSD-3-Clause
#include "passes/accumulate/buffer_impl.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "passes/accumulate/sums/blocks.h"
#include "passes/accumulate/sums/codes.h"
#include "passes/accumulate/values.h"

const char *const weft_accum_rounding_names[] = {"nearest", "truncate", NULL};

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

// ---- operations ---------------------------------------------------------------------------------

enum operation { LOAD, ACCUM, ADD, MULT };

struct work {
    weft_accum_buffer *buffer;
    enum operation operation;
    const struct weft_plane *planes;      // LOAD, ACCUM
    const struct weft_value_range *range; // of them; NULL: as they are
    double value;
};

// Codes of frames stay what they are: what one stands for is part of the scale, but where Mesa's
// arithmetic is wanted. Returns values in `memory`, or as they lie in the block.
static const float *frame_values(const struct work *w, const struct weft_block *block,
                                 float *memory, double *one)
{
    const struct weft_accum_buffer_params *p = &w->buffer->params;
    const bool mesa = p->bits == 16 && p->rounding == WEFT_ACCUM_TRUNCATE;
    const bool bytes = block->type == WEFT_PLANE_UNORM8;
    const float largest = bytes ? 255.0f : 65535.0f, factor = mesa ? 1.0f / largest : 1.0f;
    *one = 1.0;
    if (w->range || (!bytes && block->type != WEFT_PLANE_UNORM16)) {
        const float *values = weft_block_floats(block, memory);
        if (!w->range)
            return values;
        if (values != memory)
            memcpy(memory, values, block->count * sizeof *memory);
        weft_value_range_apply(w->range, memory, block->count);
        return memory;
    }
    for (size_t i = 0; bytes && i < block->count; i++)
        memory[i] = (float)((const uint8_t *)block->values)[i] * factor;
    for (size_t i = 0; !bytes && i < block->count; i++)
        memory[i] = (float)((const uint16_t *)block->values)[i] * factor;
    *one = mesa ? 1.0 : 1.0 / (double)largest;
    return memory;
}

static float code_scale(const struct work *w, double one)
{
    if (w->buffer->params.rounding == WEFT_ACCUM_TRUNCATE)
        return (float)w->value * (float)WEFT_CODE_LARGEST;
    return (float)(w->value * one * WEFT_CODE_LARGEST);
}

static bool add_block(void *priv, int thread, const struct weft_block *block)
{
    const struct work *w = priv;
    const weft_accum_buffer *b = w->buffer;
    const size_t at = (size_t)block->channel * b->plane + block->at;
    const bool load = w->operation == LOAD;
    float memory[WEFT_BLOCK_VALUES];
    double one;
    const float *v = frame_values(w, block, memory, &one);
    (void)thread;
    if (b->params.bits == 16) {
        int16_t *a = (int16_t *)b->values + at;
        if (load)
            memset(a, 0, block->count * sizeof *a);
        weft_codes_add(v, code_scale(w, one), b->params.rounding == WEFT_ACCUM_TRUNCATE, a,
                       block->count);
    } else {
        float *a = (float *)b->values + at;
        const float scale = (float)(w->value * one);
        for (size_t i = 0; load && i < block->count; i++)
            a[i] = v[i] * scale;
        for (size_t i = 0; !load && i < block->count; i++)
            a[i] += v[i] * scale;
    }
    return true;
}

static void change_codes(const struct work *w, int16_t *a, size_t count)
{
    const bool truncate = w->buffer->params.rounding == WEFT_ACCUM_TRUNCATE;
    if (w->operation == ADD)
        weft_codes_shift(code_scale(w, 1.0), truncate, a, count);
    else
        weft_codes_multiply((float)w->value, truncate, a, count);
}

static void change_floats(const struct work *w, float *a, size_t count)
{
    const float value = (float)w->value;
    for (size_t i = 0; w->operation == ADD && i < count; i++)
        a[i] += value;
    for (size_t i = 0; w->operation == MULT && i < count; i++)
        a[i] *= value;
}

static bool change_pixels(void *priv, int thread, size_t first, size_t end)
{
    const struct work *w = priv;
    const weft_accum_buffer *b = w->buffer;
    (void)thread;
    for (int c = 0; c < b->params.channel_count; c++) {
        const size_t at = (size_t)c * b->plane + first;
        if (b->params.bits == 16)
            change_codes(w, (int16_t *)b->values + at, end - first);
        else
            change_floats(w, (float *)b->values + at, end - first);
    }
    return true;
}

static enum weft_result operate(struct work *w)
{
    const struct weft_accum_buffer_params *p = &w->buffer->params;
    const struct weft_frame_shape shape = {p->width, p->height, p->channel_count, p->cpu.threads};
    const bool frames = w->operation == LOAD || w->operation == ACCUM;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, isfinite((float)w->value));
    for (int c = 0; frames && c < p->channel_count; c++) {
        weft_require(p->log, w->planes[c].values != NULL);
        weft_require_enum(p->log, w->planes[c].type, WEFT_PLANE_TYPE_COUNT - 1);
    }
    if (frames)
        weft_blocks_run(&shape, w->planes, NULL, add_block, w);
    else
        weft_pixels_run(&shape, change_pixels, w);
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
    const double scale = codes ? r->scale / WEFT_CODE_LARGEST : r->scale;
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
