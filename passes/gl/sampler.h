// SPDX-License-Identifier: BSD-3-Clause
// passes/gl/sampler.h - how exactly a context filters 3D textures linearly. GL does not tell, so it
// is measured, by drawing.
//
// The model: between texels i and i + 1 along an axis a sampler that is asked for the coordinate
// i + 1/2 + x uses a fraction x' and rounds the values that it blends. At texel centres (x = 0) it
// gives the texel; x' does not fall as x rises. Both are checked; a sampler that is otherwise is
// refused. For the fraction there are two bounds, of which the smaller one holds:
// - as x' does not fall, between two measured points it lies between what was found there;
// - as samplers keep so many bits of a fraction, the steps of x' are of one length s, and x' - x
//   differs from any measured difference by at most s; and s is at most the spacing of points in a
//   row that all gave different fractions.
// The first one needs finer points than steps, the second finds a sampler that is as good as single
// precision. Fractions are measured at both ends and in the middle of the longest texture, along
// each axis, from the lower to the higher texel and back; the rounding of values where two texels
// differ by one code (or, as floats, by 2^-20).
#ifndef WEFT_PASSES_GL_SAMPLER_H
#define WEFT_PASSES_GL_SAMPLER_H

#include "../../tiles/volume/layout.h"
#include "context.h"

WEFT_BEGIN_DECLS

// A linear sampler of 3D textures of one format, of at most max_size texels along a side, whose
// sides are powers of two. A result is off by at most
//     3 * fraction * largest |difference of two texels next to each other| along an axis
//         + 3 * rounding * largest |texel|.
struct weft_sampler {
    double fraction; // largest |x' - x|: about 2^-9 where it has 8 bits and rounds
    double rounding; // along an axis, relative to the largest |texel|; unorm formats: to 1
    int max_size;    // what GL has; 64 to WEFT_SAMPLER_MAX_SIZE
};
enum { WEFT_SAMPLER_MAX_SIZE = 512 }; // past that single precision leaves few bits of a fraction

// Returns what holds for nearly every sampler, until one is measured: 8 bits, the rest cut off, of
// fractions and, of unorm8, of values, and sizes of 256. All 0 for values that are no format. Pure.
WEFT_API struct weft_sampler weft_sampler_assume(enum weft_source_format format);

// Measures a context's sampler, which takes a few milliseconds and a program, and remembers it: the
// next call for the same context and format is free. Returns WEFT_ERR_ARGUMENT (format),
// WEFT_ERR_UNSUPPORTED (no such sampler: centres that are no texels, fractions that fall),
// WEFT_ERR_GL or WEFT_ERR_MEMORY; the log of the context has the numbers.
WEFT_API enum weft_result weft_sampler_measure(weft_context *context,
                                               enum weft_source_format format,
                                               struct weft_sampler *out);

WEFT_END_DECLS
#endif
