// SPDX-License-Identifier: BSD-3-Clause
#include "passes/antialias/pattern/bytes.h"

const char *const weft_antialias_format_names[] = {"8", "16f", "32f", NULL};

int weft_antialias_format_bytes(enum weft_antialias_format format)
{
    switch (format) {
    case WEFT_ANTIALIAS_RGBA8:
        return 4;
    case WEFT_ANTIALIAS_RGBA16F:
        return 8;
    case WEFT_ANTIALIAS_RGBA32F:
        return 16;
    default:
        return 0;
    }
}

// count * each, UINT64_MAX where that is more; 0 of what is not there.
static uint64_t multiply(int64_t count, int64_t each)
{
    uint64_t product;
    if (count <= 0 || each <= 0)
        return 0;
    return __builtin_mul_overflow((uint64_t)count, (uint64_t)each, &product) ? UINT64_MAX : product;
}

static uint64_t of_pixels(int32_t width, int32_t height, int64_t each)
{
    return width > 0 && height > 0 ? multiply((int64_t)width * height, each) : 0;
}

// Of one pixel or block; ints only, so that nothing overflows.
static int64_t of_samples(int samples, int64_t each)
{
    return (int64_t)(samples > 0 ? samples : 0) * (each > 0 ? each : 0);
}

uint64_t weft_bytes_multisample(int32_t width, int32_t height, int samples, int colour_bytes,
                                int depth_bytes)
{
    return of_pixels(width, height, of_samples(samples, (int64_t)colour_bytes + depth_bytes));
}

uint64_t weft_bytes_accumulative(int32_t width, int32_t height, int samples, int sum_bytes,
                                 int depth_bytes)
{
    return of_pixels(width, height, of_samples(samples, depth_bytes) + sum_bytes);
}

uint64_t weft_bytes_adaptive(int32_t width, int32_t height, int64_t edge_pixels, int samples,
                             int colour_bytes, int depth_bytes)
{
    enum { POINTER = 4 };
    const int64_t sample = (int64_t)colour_bytes + depth_bytes;
    const uint64_t base = of_pixels(width, height, sample + POINTER);
    const uint64_t blocks = multiply(edge_pixels, of_samples(samples, sample));
    return base > UINT64_MAX - blocks ? UINT64_MAX : base + blocks;
}
