// SPDX-License-Identifier: BSD-3-Clause
// passes/accumulate/blend_target.h - targets that frames are blended into one after another, on GL
// or emulated (not installed): what the methods "blend" and "float" share.
#ifndef WEFT_PASSES_ACCUMULATE_BLEND_TARGET_H
#define WEFT_PASSES_ACCUMULATE_BLEND_TARGET_H

#include "passes/accumulate/accumulate_impl.h"
#include "passes/accumulate/blend/emulate.h"
#include "passes/accumulate/values.h"

WEFT_BEGIN_DECLS

// RGBA of 8, 16, WEFT_ACCUMULATE_HALF or 32 bits for each group of channels. Of 8 and 16 bits the
// values are places in params.low to params.high.
typedef struct weft_blend_target weft_blend_target;

// Makes targets of zeros, on params.context unless params.emulate. On failure *out is NULL. Returns
// WEFT_ERR_ARGUMENT (no context), WEFT_ERR_LIMIT (a side), WEFT_ERR_MEMORY or WEFT_ERR_GL.
enum weft_result weft_blend_target_create(weft_accumulator *a, int bits, weft_blend_target **out);
void weft_blend_target_destroy(weft_accumulator *a, weft_blend_target **target);

// Makes sure that a frame can be blended: as weft_frame_check where it lies in memory, with the
// range or what halves hold as limits; textures of floats are read back for it unless what is not
// finite is to propagate. *largest: |value| as far as it is known, else the range's.
enum weft_result weft_blend_target_check(weft_accumulator *a, const weft_blend_target *target,
                                         const struct weft_frame *frame, double *largest);
// Blends a frame that was checked. Returns WEFT_ERR_MEMORY or WEFT_ERR_GL.
enum weft_result weft_blend_target_add(weft_accumulator *a, weft_blend_target *target,
                                       const struct weft_frame *frame,
                                       const struct weft_blend_step *step);

// What is read: offset + value * scale / divisor in double, rounded to a float once; codes are
// code / largest code.
struct weft_blend_reading {
    double offset, scale, divisor;
};
enum weft_result weft_blend_target_read(weft_accumulator *a, weft_blend_target *target,
                                        const struct weft_blend_reading *reading, int channel,
                                        float *out, size_t stride);

// Channels of one group, drawn to a texture in single precision. Not emulated. Returns what
// weft_texture_write does.
enum weft_result weft_blend_target_draw(weft_accumulator *a, weft_blend_target *target,
                                        const struct weft_blend_reading *reading, int channel,
                                        int channels, const struct weft_texture *texture);

// All values, to be taken into a target of the same bits on GL or emulated. Returns WEFT_ERR_MEMORY
// or WEFT_ERR_GL; of bytes that lack the state tells.
enum weft_result weft_blend_target_save(weft_accumulator *a, weft_blend_target *target,
                                        weft_state *state);
enum weft_result weft_blend_target_load(weft_accumulator *a, weft_blend_target *target,
                                        weft_state *state);

const struct weft_value_range *weft_blend_target_range(const weft_blend_target *target);
// Fills in textures, bytes and passes.
void weft_blend_target_report(const weft_accumulator *a, const weft_blend_target *target,
                              struct weft_accumulator_report *out);

WEFT_END_DECLS
#endif
