// SPDX-License-Identifier: BSD-3-Clause
// passes/accumulate/moments.h - what is kept of frames beside a method's own state: sums of squares
// and extremes, exact, in memory (not installed). The sums are integers, so that they are the same
// in every bit whatever the order of frames, and parts can be joined.
#ifndef WEFT_PASSES_ACCUMULATE_MOMENTS_H
#define WEFT_PASSES_ACCUMULATE_MOMENTS_H

#include "passes/accumulate/accumulate_impl.h"

WEFT_BEGIN_DECLS

// For a->params.keep. Returns WEFT_ERR_MEMORY.
enum weft_result weft_moments_create(weft_accumulator *a);
void weft_moments_destroy(weft_accumulator *a);
// Whether a frame fits, as a->scan says; nothing is changed. Returns WEFT_ERR_LIMIT, and has told
// where.
enum weft_result weft_moments_check(const weft_accumulator *a, const struct weft_plane *planes);
// Adds a frame that was checked. Returns WEFT_ERR_MEMORY.
enum weft_result weft_moments_add(weft_accumulator *a, const struct weft_plane *planes,
                                  double weight);
// Any of enum weft_accumulated but the mean.
enum weft_result weft_moments_read(weft_accumulator *a, enum weft_accumulated what, int channel,
                                   float *out, size_t stride);
uint64_t weft_moments_bytes(const weft_accumulator *a);
// As the functions of a method do.
void weft_moments_save(const weft_accumulator *a, weft_state *state);
enum weft_result weft_moments_load(weft_accumulator *a, weft_state *state);
// Whether two fit; nothing is changed. Returns WEFT_ERR_ARGUMENT or WEFT_ERR_LIMIT.
enum weft_result weft_moments_check_join(const weft_accumulator *a, const weft_accumulator *other);
// Adds another's. Returns WEFT_ERR_MEMORY.
enum weft_result weft_moments_join(weft_accumulator *a, const weft_accumulator *other);

WEFT_END_DECLS
#endif
