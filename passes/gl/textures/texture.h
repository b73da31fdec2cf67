// SPDX-License-Identifier: BSD-3-Clause
// passes/gl/textures/texture.h - textures of the caller's that results are written to and sources
// are read from (docs/contexts.md). They are of the context that a call uses: made in
// weft_context_call, in a context of its share group, or in the caller's own context.
#ifndef WEFT_PASSES_GL_TEXTURES_TEXTURE_H
#define WEFT_PASSES_GL_TEXTURES_TEXTURE_H

#include "../context.h"

WEFT_BEGIN_DECLS

// A rectangle of a complete GL_TEXTURE_2D, and the first of its channels. Pixel (i, j) is texel (x
// + i, y + j): row 0 of the pixels is the lowest of these rows, as GL counts. Its format is one
// that GL draws into, of floats or of normalised integers, and not sRGB: GL_R, RG or RGBA with 8,
// 16, 16F, 32F and the like. Values come as they are in float formats of 32 bits, and are rounded,
// and clamped, to what others hold. The name, its storage and its parameters stay the caller's;
// texels and channels beside are left as they are. What calls write is done in the context's order;
// of a share group it is done when they return.
struct weft_texture {
    unsigned name; // required
    int level;     // of its mipmaps (default 0)
    int x, y;      // of the first texel (default 0, 0)
    int channel;   // 0 to 3: R, G, B, A, of the first channel; further ones follow (default 0)
};

// Reads a rectangle's texels: channel texture->channel + c of pixel (i, j) to
// plane[c][j * stride + i], as floats; stride 0: width. Returns WEFT_ERR_ARGUMENT (sizes, pointers,
// channels; a texture that is none, is not 2D, is too small, lacks a channel, or has a format that
// does not do: the log has the numbers), WEFT_ERR_MEMORY or WEFT_ERR_GL.
WEFT_API enum weft_result weft_texture_read(weft_context *context,
                                            const struct weft_texture *texture, int width,
                                            int height, int channels, float *const *plane,
                                            int64_t stride);

// Writes planes to it, likewise: what any engine has made in memory. Returns as above.
WEFT_API enum weft_result weft_texture_write(weft_context *context,
                                             const struct weft_texture *texture, int width,
                                             int height, int channels, const float *const *plane,
                                             int64_t stride);

WEFT_END_DECLS
#endif
