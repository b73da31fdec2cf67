// SPDX-License-Identifier: BSD-3-Clause
// passes/gl/native/state.h - the state of GL that weft changes, kept while it uses a caller's
// context (not installed). What is not listed here no pass of weft's changes:
//   switches (glEnable) of blending, depth, stencil and scissor tests, culling, logic operation,
//     depth clamp, polygon offsets, smoothing of polygons and lines, all of multisampling,
//     primitive restart, rasterizer discard, sRGB, point size, clip distances and dithering
//   blend functions, equations and colour, colour masks; depth and stencil functions, operations
//     and masks; culling, polygon mode and offset, point and line size; viewports, scissor boxes
//     and depth ranges; clear values, clip control, provoking vertex, sample mask, clamping of
//     what is read
//   glPixelStore
//   the program, the vertex array, framebuffers and renderbuffer; 2D, 3D, buffer, array and
//     multisample textures and samplers of units 0 to 31, and the active unit; array, texture,
//     copy, pixel and uniform buffers, the uniform buffer of binding 35, and image units 0 to 7
// and in a compatibility profile the alpha test, stipples of lines and polygons, smooth points and
// point sprites, clamping of colours and pixel transfer.
#ifndef WEFT_PASSES_GL_NATIVE_STATE_H
#define WEFT_PASSES_GL_NATIVE_STATE_H

#include <stdbool.h>
#include <stddef.h>

#include <glad/gl.h>

// As many as weft's passes use at most.
enum {
    WEFT_GL_STATE_UNITS = 32,
    WEFT_GL_STATE_UNIFORM = 35, // the one binding of uniform buffers
    WEFT_GL_STATE_IMAGES = 8,
};

struct weft_gl_state;

// Room for the state of a context that is current, whose functions `find` knows. NULL: no memory,
// or functions of its compatibility profile are missing. `free` ends it.
struct weft_gl_state *weft_gl_state_create(const GladGLContext *gl,
                                           GLADapiproc (*find)(void *priv, const char *name),
                                           void *priv);

// What the caller has begun that draws would count in or be dropped by: false, and `why` says what.
bool weft_gl_state_is_free(const GladGLContext *gl, char *why, size_t why_size);

// Keeps the state as it is, and sets what belongs to compatibility profiles alone to what core
// profiles have.
void weft_gl_state_save(const GladGLContext *gl, struct weft_gl_state *state);
// Makes it what it was. Objects that have been deleted meanwhile are unbound.
void weft_gl_state_restore(const GladGLContext *gl, const struct weft_gl_state *state);

#endif
