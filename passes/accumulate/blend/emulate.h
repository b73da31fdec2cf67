// SPDX-License-Identifier: BSD-3-Clause
// passes/accumulate/blend/emulate.h - what the blending unit of Mesa's software renderer, llvmpipe,
// does to a target, bit for bit (not installed). Measured with Mesa 22.3.6, for all pairs of codes:
// - 8 and 16 bits, L being the largest code: the frame's value is clamped to [0, 1] and becomes the
//   nearest code s, and so does the constant c; p(a, b) = (a b + (a b >> n) + 2^(n - 1)) >> n in n
//   bits is a product, within 0.502 of a b / L. ADD gives min(d + p(s, c), L), MIX
//   min(p(s, c) + p(d, L - c), L).
// - Floats: s c + d, and s c + d (1 - c), each operation rounded to nearest. Where an operand or a
//   result is smaller than 2^-126 it is 0.
// - Halves: the same in single precision, of which the result is rounded toward zero.
// Pure functions; thread-safe.
#ifndef WEFT_PASSES_ACCUMULATE_BLEND_EMULATE_H
#define WEFT_PASSES_ACCUMULATE_BLEND_EMULATE_H

#include "tiles/image/plane.h"

WEFT_BEGIN_DECLS

// What a frame is blended into a target d with.
struct weft_blend_step {
    enum weft_blend_operation {
        WEFT_BLEND_SUM, // frame + d
        WEFT_BLEND_ADD, // frame * constant + d
        WEFT_BLEND_MIX, // frame * constant + d * (1 - constant)
    } operation;
    float constant; // of codes: of one exactly, code / L
    float weight;   // that the shader multiplies the frame by; 1: it does not
};

// Values of planes as shaders fetch them from texels of a type: codes c, which come as c / L, are
// float(c) * (1 / L).
void weft_blend_fetch(enum weft_plane_type type, float *values, size_t count);

// Blends `count` values, which are weighted already, into a target of so many bits (of 8 and 16
// codes as uint16_t, else floats).
void weft_blend_emulate(int bits, const struct weft_blend_step *step, const float *values,
                        size_t count, void *target);

// A product in the shader, which makes what is smaller than 2^-126 0.
void weft_blend_weigh(float weight, float *values, size_t count);

WEFT_END_DECLS
#endif
