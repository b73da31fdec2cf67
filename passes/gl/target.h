// SPDX-License-Identifier: BSD-3-Clause
// passes/gl/target.h - what passes draw into, and what their shaders read (not installed).
// Functions take the table of a context that is current in the calling thread.
#ifndef WEFT_PASSES_GL_TARGET_H
#define WEFT_PASSES_GL_TARGET_H

#include "passes/gl/gl.h"

// A 2D texture, fetched by texel, and the framebuffer that draws into it. {0} is none.
struct weft_gl_target {
    GLuint texture, framebuffer;
    GLenum format;     // GL_R or GL_RGBA with 8, 16, 16F or 32F; GL_RGBA32I
    int width, height; // texels
};

// Creates a target with undefined content and leaves its framebuffer bound. On failure *out is {0}.
// Returns WEFT_ERR_GL or WEFT_ERR_MEMORY, with format and size in the log.
enum weft_result weft_gl_target_create(const struct weft_log *log, const GladGLContext *gl,
                                       GLenum format, int width, int height,
                                       struct weft_gl_target *out);
// Accepts {0} and leaves it behind; framebuffer 0 is bound then.
void weft_gl_target_destroy(const GladGLContext *gl, struct weft_gl_target *target);
// Makes sure that a target has this format and at least this size: keeps it, or creates a new one
// in its place, as large as the old one at least. Errors as of weft_gl_target_create.
enum weft_result weft_gl_target_fit(const struct weft_log *log, const GladGLContext *gl,
                                    GLenum format, int width, int height,
                                    struct weft_gl_target *target);

// Draws go into the first width x height texels from now on.
void weft_gl_target_bind(const GladGLContext *gl, const struct weft_gl_target *target, int width,
                         int height);

// Draws go into the first width x height texels of several targets at once, up to eight, as outputs
// 0, 1, ... of the fragment shader; by the first one's framebuffer, which draws into them until it
// is bound so again.
void weft_gl_targets_bind(const GladGLContext *gl, const struct weft_gl_target *targets, int count,
                          int width, int height);

// Where texels are read to.
struct weft_gl_pixels {
    int width, height; // from the texel (x, y) on
    GLenum type;       // GL_FLOAT, of unorm targets their codes: GL_UNSIGNED_BYTE, _SHORT, of half
                       // ones their bits: GL_HALF_FLOAT; of integers GL_INT
    int stride;        // texels from row to row (default width)
    void *data;        // an offset where a GL_PIXEL_PACK_BUFFER is bound
    int x, y;          // of the target's (default its first texel)
};
// Waits for what was drawn. Returns WEFT_ERR_GL or WEFT_ERR_MEMORY.
enum weft_result weft_gl_target_read(const struct weft_log *log, const GladGLContext *gl,
                                     const struct weft_gl_target *target,
                                     const struct weft_gl_pixels *out);

// Of a program's uniform; -1, which GL ignores, where it uses none of that name.
GLint weft_gl_location(const GladGLContext *gl, GLuint program, const char *name);
// Binds a texture to a unit and hands the unit to the sampler `name` of the program in use. `kind`:
// GL_TEXTURE_2D, ... Unit 0 is active afterwards.
void weft_gl_bind_texture(const GladGLContext *gl, GLuint program, GLuint unit, const char *name,
                          GLenum kind, GLuint texture);
void weft_gl_bind_buffer(const GladGLContext *gl, GLuint program, GLuint unit, const char *name,
                         const struct weft_gl_buffer *buffer);

#endif
