// SPDX-License-Identifier: BSD-3-Clause
// passes/accumulate/buffer.h - OpenGL's accumulation buffer, in memory and without OpenGL: what
// glAccum does (OpenGL 1.1, section 4.2.4, after Haeberli and Akeley, "The Accumulation Buffer",
// SIGGRAPH 1990) to images of any number of channels.
//
// A value a of the buffer is a signed code of 16 bits that stands for a / 32767, so that the range
// is [-1, 1], or a float. Where a product or a sum has no code, OpenGL leaves it undefined; here it
// becomes the nearest one, -32767 or 32767. Floats have no limits. As OpenGL says, values are
// clamped to [0, 1] where they are returned, and nowhere else.
//
// A whole frame goes through each call, on several threads: the same bytes whatever their number.
#ifndef WEFT_PASSES_ACCUMULATE_BUFFER_H
#define WEFT_PASSES_ACCUMULATE_BUFFER_H

#include "../../tiles/image/plane.h"
#include "../cpu/cpu.h"

WEFT_BEGIN_DECLS

// How products become codes of 16 bits. Default: to nearest.
enum weft_accum_rounding {
    // Of the product in single precision, halves to even codes. An operation adds an error of at
    // most WEFT_ACCUM_ERROR codes, on average 0.
    WEFT_ACCUM_NEAREST,
    // Toward zero, as Mesa's buffer does: bit for bit its arithmetic (main/accum.c of Mesa 22.3)
    // where that does not wrap. Codes v of frames become float(v) * (1 / largest code), and with
    // scale = float(value) * 32767, all in single precision, load and accum add (short)(v * scale),
    // mult is (short)(a * value), add is (short)(scale). An operation loses half a code on average,
    // and less than WEFT_ACCUM_TRUNCATE_ERROR.
    WEFT_ACCUM_TRUNCATE,
    WEFT_ACCUM_ROUNDING_COUNT
};
// NULL-ended, in the order of the enum: "nearest", "truncate".
WEFT_API extern const char *const weft_accum_rounding_names[];

// In codes: what rounding a product loses, and what single precision adds to that: two, and five,
// roundings of up to 32767 codes.
#define WEFT_ACCUM_ERROR (0.5 + 0x1p-8)
#define WEFT_ACCUM_TRUNCATE_ERROR (1.0 + 0x1p-6)

// What a buffer is.
struct weft_accum_buffer_params {
    int32_t width, height;             // pixels, each > 0 (required)
    int channel_count;                 // > 0 (required)
    int bits;                          // of a value: 16 or, floats, 32 (default 16)
    enum weft_accum_rounding rounding; // of 16 bits (default: to nearest)
    struct weft_cpu cpu;               // threads; the instructions do not matter
    const struct weft_log *log;        // borrowed for the buffer's life; may be NULL
};
#define WEFT_ACCUM_BUFFER_DEFAULTS
#define weft_accum_buffer_params(...)                                                              \
    (&(struct weft_accum_buffer_params){WEFT_ACCUM_BUFFER_DEFAULTS __VA_ARGS__})

// Thread-safety: one thread at a time.
typedef struct weft_accum_buffer weft_accum_buffer;

// Makes a buffer of zeros: width * height * channel_count values. On failure *out is NULL. Returns
// WEFT_ERR_ARGUMENT (a range), WEFT_ERR_UNSUPPORTED (instructions that do not run here) or
// WEFT_ERR_MEMORY.
WEFT_API enum weft_result weft_accum_buffer_create(const struct weft_accum_buffer_params *params,
                                                   weft_accum_buffer **out);
WEFT_API void weft_accum_buffer_destroy(weft_accum_buffer **buffer); // accepts &NULL

// The operations, a being each value of the buffer and v the frame's: channel_count planes of any
// types, which are borrowed until the call returns. `value` is a float of GL: it is rounded to one.
// Each returns WEFT_ERR_ARGUMENT, with the buffer as it was, where `value` is not finite or beyond
// a float, or a plane is none. In 16 bits a product that is NAN counts as -1.
// a = v value
WEFT_API enum weft_result weft_accum_buffer_load(weft_accum_buffer *buffer,
                                                 const struct weft_plane *planes, double value);
// a = a + v value
WEFT_API enum weft_result weft_accum_buffer_accum(weft_accum_buffer *buffer,
                                                  const struct weft_plane *planes, double value);
// a = a + value
WEFT_API enum weft_result weft_accum_buffer_add(weft_accum_buffer *buffer, double value);
// a = a value
WEFT_API enum weft_result weft_accum_buffer_mult(weft_accum_buffer *buffer, double value);
// out = a value, clamped to [0, 1]: channel `channel` as floats, each rounded once to nearest,
// out[y * stride + x]; stride 0: width. Returns WEFT_ERR_ARGUMENT (a channel, a stride below width,
// a value that is not finite).
WEFT_API enum weft_result weft_accum_buffer_return(const weft_accum_buffer *buffer, double value,
                                                   int channel, float *out, size_t stride);
// out = offset + a scale, as it is: OpenGL has no such call. Otherwise as the one above.
WEFT_API enum weft_result weft_accum_buffer_read(const weft_accum_buffer *buffer, double scale,
                                                 double offset, int channel, float *out,
                                                 size_t stride);

WEFT_END_DECLS
#endif
