// SPDX-License-Identifier: BSD-3-Clause
#include "passes/accumulate/sums/blocks.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/half.h"
#include "filter/threads.h"

// Values that are worth a thread, and pixels of one part of the work.
enum { VALUES_PER_THREAD = 1 << 15, PART_VALUES = 1 << 16 };

enum { HALF_INFINITE = 0x7c00, FLOAT_INFINITE = 0x7f800000 };

// ---- values that are not finite -----------------------------------------------------------------

static inline uint32_t half_size(const void *values, size_t i)
{
    return ((const uint16_t *)values)[i] & 0x7fffu;
}

static inline int32_t float_size(const void *values, size_t i)
{
    return (int32_t)(((const uint32_t *)values)[i] & 0x7fffffffu);
}

// Copies the values, 0 for those that are not finite; returns how many, and which.
static size_t clean(const struct weft_block *block, void *out, uint16_t *bad)
{
    size_t count = 0;
    memcpy(out, block->values, block->count * weft_plane_type_size(block->type));
    for (size_t i = 0; block->type == WEFT_PLANE_HALF && i < block->count; i++)
        if (half_size(out, i) >= HALF_INFINITE) {
            ((uint16_t *)out)[i] = 0;
            bad[count++] = (uint16_t)i;
        }
    for (size_t i = 0; block->type == WEFT_PLANE_FLOAT && i < block->count; i++)
        if (float_size(out, i) >= FLOAT_INFINITE) {
            ((uint32_t *)out)[i] = 0;
            bad[count++] = (uint16_t)i;
        }
    return count;
}

const float *weft_block_floats(const struct weft_block *block, float *memory)
{
    const uint8_t *bytes = block->values;
    const uint16_t *words = block->values;
    const uint32_t *integers = block->values;
    switch (block->type) {
    case WEFT_PLANE_HALF:
        weft_half_to_floats(words, block->count, memory);
        return memory;
    case WEFT_PLANE_UNORM8:
        for (size_t i = 0; i < block->count; i++)
            memory[i] = (float)bytes[i] / 255.0f;
        return memory;
    case WEFT_PLANE_UNORM16:
        for (size_t i = 0; i < block->count; i++)
            memory[i] = (float)words[i] / 65535.0f;
        return memory;
    case WEFT_PLANE_UINT:
        for (size_t i = 0; i < block->count; i++)
            memory[i] = (float)integers[i];
        return memory;
    default:
        return block->values;
    }
}

// ---- parts --------------------------------------------------------------------------------------

struct run {
    const struct weft_frame_shape *shape;
    const struct weft_plane *planes;
    const struct weft_scan *scan;
    bool (*use)(void *priv, int thread, const struct weft_block *block);
    bool (*use_pixels)(void *priv, int thread, size_t first, size_t end);
    void *priv;
    size_t rows, pixels; // of a part
};

static size_t pixel_count(const struct weft_frame_shape *shape)
{
    return (size_t)shape->width * (size_t)shape->height;
}

static int threads_of(const struct weft_frame_shape *shape)
{
    const size_t most = pixel_count(shape) * (size_t)shape->channel_count / VALUES_PER_THREAD + 1;
    return most < (size_t)shape->threads ? (int)most : shape->threads;
}

#define GATHER(type, step)                                                                         \
    for (size_t i = 0; i < count; i++)                                                             \
        ((type *)out)[i] = ((const type *)values)[i * (step)];
#define GATHER_STEPS(type)                                                                         \
    switch (step) {                                                                                \
    case 2:                                                                                        \
        GATHER(type, 2)                                                                            \
        break;                                                                                     \
    case 3:                                                                                        \
        GATHER(type, 3)                                                                            \
        break;                                                                                     \
    case 4:                                                                                        \
        GATHER(type, 4)                                                                            \
        break;                                                                                     \
    default:                                                                                       \
        GATHER(type, step)                                                                         \
    }

static void gather(const void *restrict values, size_t size, size_t step, size_t count,
                   void *restrict out)
{
    if (size == 1) {
        GATHER_STEPS(uint8_t)
    } else if (size == 2) {
        GATHER_STEPS(uint16_t)
    } else {
        GATHER_STEPS(uint32_t)
    }
}

static bool use_block(const struct run *run, int thread, int c, size_t y, size_t x)
{
    const struct weft_plane *plane = &run->planes[c];
    const size_t width = (size_t)run->shape->width, size = weft_plane_type_size(plane->type);
    const size_t step = plane->step ? plane->step : 1;
    const size_t stride = plane->stride ? plane->stride : width * step;
    uint32_t gathered[WEFT_BLOCK_VALUES], cleaned[WEFT_BLOCK_VALUES];
    uint16_t bad[WEFT_BLOCK_VALUES];
    struct weft_block block = {
        .channel = c,
        .type = plane->type,
        .values = (const char *)plane->values + (y * stride + x * step) * size,
        .at = y * width + x,
        .count = width - x < WEFT_BLOCK_VALUES ? width - x : WEFT_BLOCK_VALUES,
        .bad = bad,
    };
    if (step != 1) {
        gather(block.values, size, step, block.count, gathered);
        block.values = gathered;
    }
    if (run->scan && run->scan[c].nonfinite > 0) {
        block.bad_count = clean(&block, cleaned, bad);
        block.values = cleaned;
    }
    return run->use(run->priv, thread, &block);
}

static bool run_rows(void *priv, int thread, size_t part)
{
    const struct run *run = priv;
    const size_t width = (size_t)run->shape->width, height = (size_t)run->shape->height;
    const size_t first = part * run->rows;
    const size_t end = height - first < run->rows ? height : first + run->rows;
    for (size_t y = first; y < end; y++)
        for (size_t x = 0; x < width; x += WEFT_BLOCK_VALUES)
            for (int c = 0; c < run->shape->channel_count; c++)
                if (!use_block(run, thread, c, y, x))
                    return false;
    return true;
}

bool weft_blocks_run(const struct weft_frame_shape *shape, const struct weft_plane *planes,
                     const struct weft_scan *scan,
                     bool (*use)(void *priv, int thread, const struct weft_block *block),
                     void *priv)
{
    struct run run = {.shape = shape, .planes = planes, .scan = scan, .use = use, .priv = priv};
    const size_t height = (size_t)shape->height;
    run.rows = PART_VALUES / ((size_t)shape->width * (size_t)shape->channel_count) + 1;
    return weft_threads_run(threads_of(shape), (height + run.rows - 1) / run.rows, run_rows, &run);
}

static bool run_pixels(void *priv, int thread, size_t part)
{
    const struct run *run = priv;
    const size_t count = pixel_count(run->shape), first = part * run->pixels;
    return run->use_pixels(run->priv, thread, first,
                           count - first < run->pixels ? count : first + run->pixels);
}

bool weft_pixels_run(const struct weft_frame_shape *shape,
                     bool (*use)(void *priv, int thread, size_t first, size_t end), void *priv)
{
    struct run run = {.shape = shape, .use_pixels = use, .priv = priv, .pixels = PART_VALUES};
    return weft_threads_run(threads_of(shape), (pixel_count(shape) + PART_VALUES - 1) / PART_VALUES,
                            run_pixels, &run);
}

// ---- scanning -----------------------------------------------------------------------------------

struct scanning {
    struct weft_scan *found; // [thread][channel]
    int channel_count;
};

static double largest_half(const struct weft_block *block)
{
    uint32_t largest = 0;
    for (size_t i = 0; i < block->count; i++) {
        const uint32_t size = half_size(block->values, i);
        largest = size > largest ? size : largest;
    }
    return weft_half_to_float((uint16_t)largest);
}

static double largest_float(const struct weft_block *block)
{
    int32_t largest = 0;
    float value;
    for (size_t i = 0; i < block->count; i++) {
        const int32_t size = float_size(block->values, i);
        largest = size > largest ? size : largest;
    }
    memcpy(&value, &largest, sizeof value);
    return value;
}

static double largest_integer(const struct weft_block *block)
{
    uint32_t largest = 0;
    for (size_t i = 0; i < block->count; i++) {
        const uint32_t value = ((const uint32_t *)block->values)[i];
        largest = value > largest ? value : largest;
    }
    return largest;
}

static double largest_of(const struct weft_block *block)
{
    switch (block->type) {
    case WEFT_PLANE_HALF:
        return largest_half(block);
    case WEFT_PLANE_FLOAT:
        return largest_float(block);
    case WEFT_PLANE_UINT:
        return largest_integer(block);
    default:
        return 1.0;
    }
}

static bool scan_block(void *priv, int thread, const struct weft_block *block)
{
    const struct scanning *scanning = priv;
    struct weft_scan *found =
        &scanning->found[(size_t)thread * (size_t)scanning->channel_count + (size_t)block->channel];
    double largest = largest_of(block);
    if (!isfinite(largest)) {
        uint32_t cleaned[WEFT_BLOCK_VALUES];
        uint16_t bad[WEFT_BLOCK_VALUES];
        struct weft_block finite = *block;
        found->nonfinite += clean(block, cleaned, bad);
        finite.values = cleaned;
        largest = largest_of(&finite);
    }
    found->largest = fmax(found->largest, largest);
    return true;
}

static bool all_codes(const struct weft_frame_shape *shape, const struct weft_plane *planes)
{
    for (int c = 0; c < shape->channel_count; c++)
        if (planes[c].type != WEFT_PLANE_UNORM8 && planes[c].type != WEFT_PLANE_UNORM16)
            return false;
    return true;
}

bool weft_scan_frame(const struct weft_frame_shape *shape, const struct weft_plane *planes,
                     struct weft_scan *scan)
{
    const size_t channels = (size_t)shape->channel_count;
    const size_t threads = (size_t)threads_of(shape);
    for (size_t c = 0; c < channels; c++)
        scan[c] = (struct weft_scan){.largest = 1.0};
    if (all_codes(shape, planes))
        return true;
    struct scanning scanning = {calloc(threads * channels, sizeof(struct weft_scan)),
                                (int)channels};
    if (!scanning.found)
        return false;
    weft_blocks_run(shape, planes, NULL, scan_block, &scanning);
    for (size_t c = 0; c < channels; c++)
        scan[c].largest = 0.0;
    for (size_t i = 0; i < threads * channels; i++) {
        struct weft_scan *into = &scan[i % channels];
        into->largest = fmax(into->largest, scanning.found[i].largest);
        into->nonfinite += scanning.found[i].nonfinite;
    }
    free(scanning.found);
    return true;
}

static double value_at(const struct weft_plane *plane, size_t at)
{
    switch (plane->type) {
    case WEFT_PLANE_FLOAT:
        return ((const float *)plane->values)[at];
    case WEFT_PLANE_HALF:
        return weft_half_to_float(((const uint16_t *)plane->values)[at]);
    case WEFT_PLANE_UINT:
        return ((const uint32_t *)plane->values)[at];
    default:
        return 1.0; // what codes are judged by
    }
}

struct weft_place weft_scan_find(const struct weft_frame_shape *shape,
                                 const struct weft_plane *planes, int channel, double limit)
{
    const struct weft_plane *plane = &planes[channel];
    const size_t step = plane->step ? plane->step : 1;
    const size_t stride = plane->stride ? plane->stride : (size_t)shape->width * step;
    struct weft_place place = {0};
    for (int32_t y = 0; y < shape->height; y++)
        for (int32_t x = 0; x < shape->width; x++) {
            place = (struct weft_place){channel, x, y,
                                        value_at(plane, (size_t)y * stride + (size_t)x * step)};
            if (!isfinite(place.value) || fabs(place.value) > limit)
                return place;
        }
    return place;
}
