// SPDX-License-Identifier: BSD-3-Clause
// passes/antialias/drawing/run.h - how the ways of anti-aliasing call an application's callback
// (not installed). Functions take a context that is current in the calling thread.
#ifndef WEFT_PASSES_ANTIALIAS_DRAWING_RUN_H
#define WEFT_PASSES_ANTIALIAS_DRAWING_RUN_H

#include "passes/antialias/drawing/drawing.h"
#include "passes/gl/context_backend.h"

// What a pass needs of GL; all zero: no tests, nothing is written, triangles are filled.
struct weft_pass_state {
    int colours;       // colour attachments that are drawn to, from the first on
    GLenum depth_func; // of the depth test; 0: there is none
    bool depth_write;  // needs a test
    struct {
        GLenum func; // 0: there is no test
        GLint ref;
        GLuint read, write; // masks of bits
        GLenum pass;        // what is done where both tests pass (default 0: GL_ZERO), or else
                            // nothing
    } stencil;
    GLuint samples;    // a mask of those that are drawn to; 0: all
    GLenum polygon;    // GL_LINE or GL_POINT; 0: GL_FILL
    float line, point; // widths in pixels; 0: 1
    float nearer;      // of outlines and corners of polygons: so many times their slope of depth,
                       // max(|dz/dx|, |dz/dy|)
};

// Binds pass->framebuffer with a viewport of pass->width x height, sets the state and the scissor
// to pass->part, calls `draw` and sets GL's defaults again; pass->framebuffer stays bound, drawing
// to state->colours attachments. Returns what `draw` returned, with a line in the log, or
// WEFT_ERR_GL or WEFT_ERR_MEMORY for an error of GL that it left.
enum weft_result weft_drawing_run(const struct weft_log *log, weft_context *context,
                                  const struct weft_antialias_drawing *drawing,
                                  const struct weft_antialias_pass *pass,
                                  const struct weft_pass_state *state);

// Sets what the state says, for draws of weft's own; weft_pass_state_end sets GL's defaults again,
// but for the framebuffer and what shaders read. part: of the framebuffer, to be drawn.
void weft_pass_state_begin(const GladGLContext *gl, GLuint framebuffer, int32_t width,
                           int32_t height, const struct weft_rectangle *part,
                           const struct weft_pass_state *state);
void weft_pass_state_end(const GladGLContext *gl);

// ---- parts --------------------------------------------------------------------------------------

// Sets the scissor to a part of a framebuffer of this size; of all of it there is none.
void weft_part_scissor(const GladGLContext *gl, const struct weft_rectangle *part, int32_t width,
                       int32_t height);
// The part with `by` pixels around it, as far as they are within width x height. Pure.
struct weft_rectangle weft_part_grown(const struct weft_rectangle *part, int by, int32_t width,
                                      int32_t height);
// Moved. Pure.
struct weft_rectangle weft_part_moved(const struct weft_rectangle *part, int32_t x, int32_t y);
size_t weft_part_pixels(const struct weft_rectangle *part);

// What a target of this format keeps of a colour. Clearing a part draws it on some GL, whose
// roundings are not those of clearing: of what is kept both are the same. Returns WEFT_ERR_GL or
// WEFT_ERR_MEMORY.
enum weft_result weft_background_kept(const struct weft_log *log, const GladGLContext *gl,
                                      GLenum format, const double colour[4], GLfloat out[4]);

// The matrix `place` of a pass: of a picture of width x height with a rim of so many pixels around
// it, whose pixels' middles see what lies at `sample`, x to the right, y down the rows, in pixels
// from the middle. Without a rim and a sample it is exactly the identity. Pure.
void weft_drawing_place(int32_t width, int32_t height, int rim, const double sample[2],
                        double out[16]);

// ---- heads --------------------------------------------------------------------------------------

// What a head begins with: GLSL's version, and WEFT_AT of inputs. Where shading is at the pixel's
// middle anyway, and where it is asked for there: of several samples GL leaves open where inputs
// that are not asked for are taken (GL 4.6, section 14.3.1), and for shading by samples it is at
// each sample's place.
#define WEFT_HEAD_33 "#version 330 core\n#define WEFT_AT(name) (name)\n"
#define WEFT_HEAD_MIDDLE "#define WEFT_AT(name) interpolateAtOffset(name, vec2(0.0))\n"
#define WEFT_HEAD_40 "#version 400 core\n" WEFT_HEAD_MIDDLE
#define WEFT_HEAD_42 "#version 420 core\n" WEFT_HEAD_MIDDLE
#define WEFT_HEAD_45 "#version 450 core\n" WEFT_HEAD_MIDDLE

// Of depth passes: nothing is written.
extern const char weft_head_depth[];
// One colour goes to the first attachment. in_middle: for several samples, WEFT_HEAD_40 where the
// context has it.
const char *weft_head_colour(const GladGLContext *gl, bool in_middle);

// Whether the context has an extension of this name.
bool weft_drawing_has_extension(const GladGLContext *gl, const char *name);

// ---- buffers of depths --------------------------------------------------------------------------

// A renderbuffer; {0} is none.
struct weft_depth_buffer {
    GLuint renderbuffer;
    GLenum attachment; // GL_DEPTH_STENCIL_ATTACHMENT or GL_DEPTH_ATTACHMENT
    int samples;       // that it has: those asked for, or the next larger number that GL has
    uint64_t bytes;    // that GL's own sizes of it come to
};
// Of samples > 1, or of one (0 or 1). depth_bits: 24 or 32; stencil: with 8 bits of it (24 bits
// always have them, as they cost nothing). It is not bound to a framebuffer. On failure *out is
// {0}. Returns WEFT_ERR_LIMIT (GL has no buffer of so many samples; the log has both numbers),
// WEFT_ERR_GL or WEFT_ERR_MEMORY.
enum weft_result weft_depth_buffer_create(const struct weft_log *log, const GladGLContext *gl,
                                          int32_t width, int32_t height, int samples,
                                          int depth_bits, bool stencil,
                                          struct weft_depth_buffer *out);
void weft_depth_buffer_destroy(const GladGLContext *gl, struct weft_depth_buffer *buffer);

// Of the texture that is bound to `target`: it has level 0 alone, and shaders fetch its texels.
void weft_texture_by_texel(const GladGLContext *gl, GLenum target);

// Bytes that a renderbuffer or a texture (target, level 0 of it, layers) takes by GL's own sizes of
// it: 5 bytes of depths and stencil count as the 8 that they are kept in. It is left unbound.
uint64_t weft_renderbuffer_bytes(const GladGLContext *gl, GLuint renderbuffer);
uint64_t weft_texture_bytes(const GladGLContext *gl, GLenum target, GLuint texture);

#endif
