// SPDX-License-Identifier: BSD-3-Clause
// passes/gl/textures/output.h - what passes draw, drawn on into a caller's texture (not installed).
// The context is current in all calls.
#ifndef WEFT_PASSES_GL_TEXTURES_OUTPUT_H
#define WEFT_PASSES_GL_TEXTURES_OUTPUT_H

#include "filter/rectangle.h"
#include "passes/gl/context_backend.h"
#include "passes/gl/target.h"
#include "passes/gl/textures/texture.h"

// A texture that was looked at, with a framebuffer that draws into it. {0} is none.
struct weft_gl_output {
    weft_context *context;
    const struct weft_log *log;
    struct weft_texture at;
    GLuint framebuffer;
    struct weft_gl_target staging; // of what is uploaded
};

// How texels that were drawn are pixels.
enum weft_gl_texels {
    WEFT_TEXELS_PLAIN,  // one, whose channels are the pixel's, from R on
    WEFT_TEXELS_PACKED, // four of a row, of one channel
};

// Looks at a texture for a picture of so many pixels and channels, which the log names `what`. On
// failure *out is {0}. Returns WEFT_ERR_ARGUMENT, with the numbers in the log, or WEFT_ERR_GL.
enum weft_result weft_gl_output_open(weft_context *context, const struct weft_log *log,
                                     const struct weft_texture *texture, int width, int height,
                                     int channels, struct weft_gl_output *out);
void weft_gl_output_close(struct weft_gl_output *output); // {0} is fine

// What texels are drawn from, and how values become others: offset + value * scale / divisor, in
// single precision, unless `maps` is false.
struct weft_gl_drawn {
    GLuint texture;
    enum weft_gl_texels texels;
    int x, y;    // of the first pixel in it
    int channel; // its first one that is drawn (default R)
    bool maps;
    float offset, scale, divisor;
};
// Draws `channels` of them from channel `first` of the output on, to pixels `to` of the picture.
// Returns WEFT_ERR_GL or WEFT_ERR_MEMORY.
enum weft_result weft_gl_output_draw(const struct weft_gl_output *output,
                                     const struct weft_gl_drawn *drawn, int first, int channels,
                                     const struct weft_rectangle *to);
// The same of one channel from memory.
enum weft_result weft_gl_output_upload(struct weft_gl_output *output, const float *pixels,
                                       int64_t stride, int channel,
                                       const struct weft_rectangle *to);

#endif
