// SPDX-License-Identifier: BSD-3-Clause
// passes/gl/gl.h - the GL function table, error checks and texture buffers (not installed).
// Functions take the table of a context that is current in the calling thread.
#ifndef WEFT_PASSES_GL_GL_H
#define WEFT_PASSES_GL_GL_H

#include <glad/gl.h>

#include "filter/check.h"

// Fills the table from the context that is current, with `find` to look functions up. false where
// that context does not answer; versions that it lacks are left NULL, and VERSION_* say which.
bool weft_gl_load(GladGLContext *gl, GLADapiproc (*find)(void *priv, const char *name), void *priv);

// Reports every pending GL error, naming the step. GL_OUT_OF_MEMORY is WEFT_ERR_MEMORY, others are
// WEFT_ERR_GL; the context must not be used further after either.
enum weft_result weft_gl_check(const struct weft_log *log, const GladGLContext *gl,
                               const char *step);

// Sets the state of GL that weft's functions count on, after a caller's code has run: GL's defaults,
// with the context's own vertex array.
void weft_gl_reset_state(const GladGLContext *gl, GLuint vertex_array);

// A buffer read by shaders through a texture.
struct weft_gl_buffer {
    GLuint buffer, texture;
    GLenum format;      // GL_RGBA or GL_R with 32F, 16F, 16, 8, 16UI, 8UI; GL_R32I, R32UI, RG32UI
    size_t texel_bytes; // of the format
    size_t size_bytes;  // allocated
};

enum weft_result weft_gl_buffer_create(const struct weft_log *log, const GladGLContext *gl,
                                       GLenum format, size_t texel_count,
                                       struct weft_gl_buffer *out);
void weft_gl_buffer_destroy(const GladGLContext *gl, struct weft_gl_buffer *buffer); // {0} is fine

// Fills the first `bytes` (a whole number of texels) of a buffer with `data`. {0} becomes a buffer
// of this format; one of this format stays where it is large enough, and is made larger otherwise.
// What lies behind is undefined. Returns WEFT_ERR_GL or WEFT_ERR_MEMORY.
enum weft_result weft_gl_buffer_load(const struct weft_log *log, const GladGLContext *gl,
                                     GLenum format, const void *data, size_t bytes,
                                     struct weft_gl_buffer *buffer);

// Makes sure of room for so many texels: {0} becomes a buffer of this format, one of this format
// stays where it is large enough. The content is undefined where it does not stay. Returns
// WEFT_ERR_GL or WEFT_ERR_MEMORY.
enum weft_result weft_gl_buffer_fit(const struct weft_log *log, const GladGLContext *gl,
                                    GLenum format, size_t texel_count,
                                    struct weft_gl_buffer *buffer);

// Makes a buffer larger; its content stays, and its texture. {0} becomes a buffer of this format.
// Returns WEFT_ERR_GL or WEFT_ERR_MEMORY; the buffer is then what it was.
enum weft_result weft_gl_buffer_grow(const struct weft_log *log, const GladGLContext *gl,
                                     GLenum format, size_t texel_count,
                                     struct weft_gl_buffer *buffer);

// Write-only memory for the first `size_bytes`, whose old content is lost; NULL when GL fails.
void *weft_gl_buffer_map(const GladGLContext *gl, const struct weft_gl_buffer *buffer,
                         size_t size_bytes);
// The same for bytes from `offset` on; the rest stays what it is.
void *weft_gl_buffer_map_range(const GladGLContext *gl, const struct weft_gl_buffer *buffer,
                               size_t offset, size_t size_bytes);
// false when GL lost the content while it was mapped.
bool weft_gl_buffer_unmap(const GladGLContext *gl, const struct weft_gl_buffer *buffer);

#endif
