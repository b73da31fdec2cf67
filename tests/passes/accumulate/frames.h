// SPDX-License-Identifier: BSD-3-Clause
// tests/passes/accumulate/frames.h - frames of random values, and their weighted mean in long
// double. Include after cmocka.h.
#ifndef WEFT_TESTS_PASSES_ACCUMULATE_FRAMES_H
#define WEFT_TESTS_PASSES_ACCUMULATE_FRAMES_H

#include <stdlib.h>
#include <string.h>

#include "filter/half.h"
#include "passes/accumulate/accumulate.h"
#include "tests/support/common.h"

// xorshift64*: the same numbers everywhere.
static inline uint64_t next_random(uint64_t *state)
{
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return *state * 0x2545f4914f6cdd1du;
}

static inline double next_uniform(uint64_t *state)
{
    return (double)(next_random(state) >> 11) * 0x1p-53;
}

// The value of pixel i of a tightly packed plane.
static inline double plane_value(const struct weft_plane *plane, size_t i)
{
    switch (plane->type) {
    case WEFT_PLANE_HALF:
        return weft_half_to_float(((const uint16_t *)plane->values)[i]);
    case WEFT_PLANE_UNORM8:
        return ((const uint8_t *)plane->values)[i] / 255.0;
    case WEFT_PLANE_UNORM16:
        return ((const uint16_t *)plane->values)[i] / 65535.0;
    case WEFT_PLANE_UINT:
        return ((const uint32_t *)plane->values)[i];
    default:
        return ((const float *)plane->values)[i];
    }
}

// `count` random values of a type; those that are no codes lie in low to high.
static inline void fill_plane(enum weft_plane_type type, double low, double high, size_t count,
                              uint64_t *seed, void *values)
{
    for (size_t i = 0; i < count; i++) {
        const double value = low + (high - low) * next_uniform(seed);
        switch (type) {
        case WEFT_PLANE_HALF: {
            uint16_t half = weft_half_from_float((float)value);
            const double stored = weft_half_to_float(half);
            ((uint16_t *)values)[i] =
                stored < low || stored > high ? weft_half_from_float((float)low) : half;
            break;
        }
        case WEFT_PLANE_UNORM8:
            ((uint8_t *)values)[i] = (uint8_t)next_random(seed);
            break;
        case WEFT_PLANE_UNORM16:
            ((uint16_t *)values)[i] = (uint16_t)next_random(seed);
            break;
        case WEFT_PLANE_UINT:
            ((uint32_t *)values)[i] = (uint32_t)value;
            break;
        default:
            ((float *)values)[i] = (float)value;
            break;
        }
    }
}

// Frames of one accumulation, all of one type and in memory.
struct frames {
    int count, channels;
    size_t pixels; // of a plane
    enum weft_plane_type type;
    double *weight;
    char *values;             // frame after frame, plane after plane
    struct weft_plane *plane; // likewise
    long double *sum;         // of w v, plane after plane
    long double total;        // of the weights
};

static inline void make_frames(struct frames *f, int count, int channels, size_t pixels,
                               enum weft_plane_type type, double low, double high, uint64_t seed)
{
    const size_t bytes = pixels * weft_plane_type_size(type);
    *f = (struct frames){.count = count, .channels = channels, .pixels = pixels, .type = type};
    f->weight = calloc((size_t)count, sizeof *f->weight);
    f->values = calloc((size_t)count * (size_t)channels, bytes);
    f->plane = calloc((size_t)count * (size_t)channels, sizeof *f->plane);
    f->sum = calloc((size_t)channels * pixels, sizeof *f->sum);
    assert_true(f->weight && f->values && f->plane && f->sum);
    for (int i = 0; i < count * channels; i++) {
        void *values = f->values + (size_t)i * bytes;
        fill_plane(type, low, high, pixels, &seed, values);
        f->plane[i] = (struct weft_plane){.values = values, .type = type};
    }
}

static inline void free_frames(struct frames *f)
{
    free(f->weight);
    free(f->values);
    free(f->plane);
    free(f->sum);
}

// How frames weigh.
enum weighing { EQUAL, RANDOM, EXTREME, SIGNED, WEIGHINGS };

static inline void weigh_frames(struct frames *f, enum weighing weighing, uint64_t seed)
{
    for (int i = 0; i < f->count; i++) {
        const double u = next_uniform(&seed);
        f->weight[i] = weighing == EQUAL     ? 1.0
                       : weighing == RANDOM  ? u < 0.1 ? 0.0 : u
                       : weighing == EXTREME ? pow(10.0, 8.0 * u - 4.0)
                                             : u - 0.3;
    }
    if (weighing == RANDOM || weighing == SIGNED)
        f->weight[0] = 1.0; // so that the sums so far are well above 0
}

// Adds a frame to the exact sums.
static inline void sum_frame(struct frames *f, int frame)
{
    f->total += (long double)f->weight[frame];
    for (int c = 0; c < f->channels; c++)
        for (size_t i = 0; i < f->pixels; i++)
            f->sum[(size_t)c * f->pixels + i] +=
                (long double)f->weight[frame] *
                (long double)plane_value(&f->plane[frame * f->channels + c], i);
}

// Largest |actual - exact mean| of a channel.
static inline double mean_error(const struct frames *f, int channel, const float *actual)
{
    double worst = 0.0;
    for (size_t i = 0; i < f->pixels; i++) {
        const long double exact = f->sum[(size_t)channel * f->pixels + i] / f->total;
        worst = larger(worst, (double)fabsl((long double)actual[i] - exact));
    }
    return worst;
}

#endif
