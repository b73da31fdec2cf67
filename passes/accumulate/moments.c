// SPDX-License-Identifier: BSD-3-Clause
#include "passes/accumulate/moments.h"

enum weft_result weft_moments_create(weft_accumulator *a)
{
    weft_error(a->params.log, "accumulate: moments are not built yet");
    return WEFT_ERR_UNSUPPORTED;
}

void weft_moments_destroy(weft_accumulator *a)
{
    (void)a;
}

enum weft_result weft_moments_check(const weft_accumulator *a, const struct weft_plane *planes)
{
    (void)a, (void)planes;
    return WEFT_ERR_UNSUPPORTED;
}

enum weft_result weft_moments_add(weft_accumulator *a, const struct weft_plane *planes,
                                  double weight)
{
    (void)a, (void)planes, (void)weight;
    return WEFT_ERR_UNSUPPORTED;
}

enum weft_result weft_moments_read(weft_accumulator *a, enum weft_accumulated what, int channel,
                                   float *out, size_t stride)
{
    (void)a, (void)what, (void)channel, (void)out, (void)stride;
    return WEFT_ERR_UNSUPPORTED;
}

uint64_t weft_moments_bytes(const weft_accumulator *a)
{
    (void)a;
    return 0;
}

void weft_moments_save(const weft_accumulator *a, weft_state *state)
{
    (void)a, (void)state;
}

enum weft_result weft_moments_load(weft_accumulator *a, weft_state *state)
{
    (void)a, (void)state;
    return WEFT_ERR_UNSUPPORTED;
}

enum weft_result weft_moments_check_join(const weft_accumulator *a, const weft_accumulator *other)
{
    (void)a, (void)other;
    return WEFT_ERR_UNSUPPORTED;
}

enum weft_result weft_moments_join(weft_accumulator *a, const weft_accumulator *other)
{
    (void)a, (void)other;
    return WEFT_ERR_UNSUPPORTED;
}
