// SPDX-License-Identifier: BSD-3-Clause
// tests/support/texture.h - kernel tiles as GL textures.
// 1D, 2D or 3D, clamped to the edge, without mipmaps. Integers are stored as they are, not
// stretched: unorm of up to 8 bits in R8, of more in R16; a texel of q then
// reads as q / 255 or q / 65535, and `factor` turns it into the weight. That is exact for every
// number of bits, which stretching 5 bits to 8 would not be. Linear lookup in less than 8 bits
// takes R16: software samplers may round what they filter from 8-bit textures to 8 bits
// (tests/support/tile_error.h).
#ifndef WEFT_TESTS_SUPPORT_TEXTURE_H
#define WEFT_TESTS_SUPPORT_TEXTURE_H

#include "filter/analysis/error.h"
#include "passes/gl/gl.h"
#include "tiles/kernel/kernel_tiles.h"

struct weft_tile_texture {
    GLuint texture;
    GLenum target; // GL_TEXTURE_1D, _2D, _3D
    GLenum internal_format;
    double factor; // weight = texel * factor, sign and scale of the tile included
    size_t bytes;  // of the texels
};

// A tile as it is stored: mirrored tiles are fetched at 1 - s along the mirrored axes, with the
// factor of the tile given here. `memory_bytes` bounds texture and staging copy together (0: 1
// GiB). Returns WEFT_ERR_LIMIT (bytes and limit, or what GL's proxy refuses, in the log),
// WEFT_ERR_MEMORY (bytes in the log) or WEFT_ERR_GL.
enum weft_result weft_tile_texture_create(const struct weft_log *log, const GladGLContext *gl,
                                          const weft_kernel_tiles *tiles, int tile,
                                          enum weft_error_lookup lookup, uint64_t memory_bytes,
                                          struct weft_tile_texture *out);
void weft_tile_texture_destroy(const GladGLContext *gl, struct weft_tile_texture *texture);

// Reads the texels back as the set's values (M^dims). Returns WEFT_ERR_MEMORY or
// WEFT_ERR_GL.
enum weft_result weft_tile_texture_read(const struct weft_log *log, const GladGLContext *gl,
                                        const weft_kernel_tiles *tiles,
                                        const struct weft_tile_texture *texture, void *values);

#endif
