// SPDX-License-Identifier: BSD-3-Clause
// passes/gl/volume_texture.h - 3D textures that the sampler filters linearly (not installed).
// Functions take the table of a context that is current in the calling thread.
#ifndef WEFT_PASSES_GL_VOLUME_TEXTURE_H
#define WEFT_PASSES_GL_VOLUME_TEXTURE_H

#include "passes/gl/gl.h"
#include "tiles/volume/layout.h"

// One sample a texel. {0} is none.
struct weft_gl_volume {
    GLuint texture;
    enum weft_source_format format;
    int size[3]; // texels
};

// Creates a texture with undefined content. On failure *out is {0}. Returns WEFT_ERR_GL or
// WEFT_ERR_MEMORY, with format and size in the log.
enum weft_result weft_gl_volume_create(const struct weft_log *log, const GladGLContext *gl,
                                       enum weft_source_format format, const int size[3],
                                       struct weft_gl_volume *out);
void weft_gl_volume_destroy(const GladGLContext *gl, struct weft_gl_volume *volume); // {0} is fine

// Fills `depth` planes from plane z on: texels of the format, [z][y][x]. Returns WEFT_ERR_GL or
// WEFT_ERR_MEMORY.
enum weft_result weft_gl_volume_load(const struct weft_log *log, const GladGLContext *gl,
                                     const struct weft_gl_volume *volume, int z, int depth,
                                     const void *texels);

#endif
