// SPDX-License-Identifier: BSD-3-Clause
#include "passes/gl/kernel_weights.h"

#include "passes/gl/target.h"

enum weft_result weft_gl_kernel_create(const struct weft_log *log, const GladGLContext *gl,
                                       const struct weft_polynomial_tiles *tiles,
                                       struct weft_gl_buffer *out)
{
    if (tiles->segments == 1)
        return WEFT_OK;
    return weft_gl_buffer_load(log, gl, GL_RGBA32F, tiles->coefficients,
                               tiles->coefficient_count * sizeof *tiles->coefficients, out);
}

void weft_gl_kernel_bind(const GladGLContext *gl, GLuint program, GLuint unit, const char *name,
                         const struct weft_polynomial_tiles *tiles,
                         const struct weft_gl_buffer *buffer)
{
    if (tiles->segments > 1)
        weft_gl_bind_buffer(gl, program, unit, name, buffer);
    else
        gl->Uniform4fv(weft_gl_location(gl, program, name), (GLsizei)(tiles->coefficient_count / 4),
                       tiles->coefficients);
}
