// SPDX-License-Identifier: BSD-3-Clause
// tests/passes/jitter/points.h - random numbers and sets of points for these tests.
// Include after cmocka.h.
#ifndef WEFT_TESTS_PASSES_JITTER_POINTS_H
#define WEFT_TESTS_PASSES_JITTER_POINTS_H

#include "tests/support/common.h"
#include "passes/jitter/jitter.h"

typedef const double (*points_of)[2];

// In [low, high); a linear congruential generator (Knuth, MMIX), its upper bits.
static inline double random_in(uint64_t *state, double low, double high)
{
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return low + (high - low) * ((double)(*state >> 11) * 0x1p-53);
}

static inline void random_normal(uint64_t *state, double normal[2])
{
    const double angle = random_in(state, 0.0, 2.0 * M_PI);
    normal[0] = cos(angle);
    normal[1] = sin(angle);
}

// "NAME:N", centred or not, of side or diameter `size`.
static inline struct weft_jitter set_named(const char *text, enum weft_jitter_shape shape,
                                           double size, bool centre)
{
    struct weft_jitter_params params = {.log = &log_to_stderr};
    struct weft_jitter set;
    assert_int_equal(weft_jitter_parse(&log_to_stderr, text, &params.info, &params.count), WEFT_OK);
    params.shape = shape;
    params.size = size;
    params.centre = centre;
    assert_int_equal(weft_jitter_create(&params, &set), WEFT_OK);
    return set;
}

#endif
