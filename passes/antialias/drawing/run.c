// SPDX-License-Identifier: BSD-3-Clause
#include "passes/antialias/drawing/run.h"

#include "filter/check.h"

// ---- state --------------------------------------------------------------------------------------

static void draw_to(const GladGLContext *gl, int colours)
{
    static const GLenum buffers[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1,
                                     GL_COLOR_ATTACHMENT2, GL_COLOR_ATTACHMENT3};
    if (colours)
        gl->DrawBuffers(colours, buffers);
    else
        gl->DrawBuffer(GL_NONE);
    gl->ReadBuffer(colours ? GL_COLOR_ATTACHMENT0 : GL_NONE);
}

static void begin_tests(const GladGLContext *gl, const struct weft_pass_state *state)
{
    gl->DepthMask(state->depth_write);
    if (state->depth_func) {
        gl->Enable(GL_DEPTH_TEST);
        gl->DepthFunc(state->depth_func);
    }
    gl->StencilMask(state->stencil.write);
    if (state->stencil.func) {
        gl->Enable(GL_STENCIL_TEST);
        gl->StencilFunc(state->stencil.func, state->stencil.ref, state->stencil.read);
        gl->StencilOp(GL_KEEP, GL_KEEP, state->stencil.pass);
    }
}

void weft_pass_state_begin(const GladGLContext *gl, GLuint framebuffer, int32_t width,
                           int32_t height, const struct weft_rectangle *part,
                           const struct weft_pass_state *state)
{
    gl->BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl->Viewport(0, 0, width, height);
    weft_part_scissor(gl, part, width, height);
    draw_to(gl, state->colours);
    begin_tests(gl, state);
    if (state->samples) {
        gl->Enable(GL_SAMPLE_MASK);
        gl->SampleMaski(0, state->samples);
    }
    if (state->polygon)
        gl->PolygonMode(GL_FRONT_AND_BACK, state->polygon);
    if (state->line > 0.0f)
        gl->LineWidth(state->line);
    if (state->point > 0.0f)
        gl->PointSize(state->point);
    if (state->nearer > 0.0f) {
        gl->Enable(GL_POLYGON_OFFSET_LINE);
        gl->Enable(GL_POLYGON_OFFSET_POINT);
        gl->PolygonOffset(-state->nearer, -1.0f);
    }
}

void weft_pass_state_end(const GladGLContext *gl)
{
    gl->Disable(GL_SCISSOR_TEST);
    gl->Disable(GL_DEPTH_TEST);
    gl->DepthFunc(GL_LESS);
    gl->DepthMask(GL_TRUE);
    gl->Disable(GL_STENCIL_TEST);
    gl->StencilMask(~0u);
    gl->StencilFunc(GL_ALWAYS, 0, ~0u);
    gl->StencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
    gl->Disable(GL_SAMPLE_MASK);
    gl->SampleMaski(0, ~0u);
    gl->PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    gl->LineWidth(1.0f);
    gl->PointSize(1.0f);
    gl->Disable(GL_POLYGON_OFFSET_LINE);
    gl->Disable(GL_POLYGON_OFFSET_POINT);
    gl->PolygonOffset(0.0f, 0.0f);
}

// What the callback may have left, too.
static void reset(const GladGLContext *gl, GLuint vertex_array)
{
    weft_gl_reset_state(gl, vertex_array);
    weft_pass_state_end(gl);
    if (gl->MinSampleShading) {
        gl->Disable(GL_SAMPLE_SHADING);
        gl->MinSampleShading(0.0f);
    }
}

enum weft_result weft_drawing_run(const struct weft_log *log, weft_context *context,
                                  const struct weft_antialias_drawing *drawing,
                                  const struct weft_antialias_pass *pass,
                                  const struct weft_pass_state *state)
{
    static const char *const stages[] = {"depth", "colour", "lines", "points"};
    const GladGLContext *gl = &context->gl;
    GLint vertex_array = 0;
    gl->GetIntegerv(GL_VERTEX_ARRAY_BINDING, &vertex_array);
    weft_pass_state_begin(gl, pass->framebuffer, pass->width, pass->height, &pass->part, state);
    const enum weft_result res = drawing->draw(drawing->priv, pass);
    if (res != WEFT_OK)
        weft_error(log, "antialias: pass %d of stage %s was not drawn: %s", pass->index,
                   stages[pass->stage], weft_result_text(res));
    const enum weft_result fault = weft_gl_check(log, gl, "a pass of the scene was drawn");
    reset(gl, (GLuint)vertex_array);
    gl->BindFramebuffer(GL_FRAMEBUFFER, pass->framebuffer);
    draw_to(gl, state->colours);
    return res == WEFT_OK ? fault : res;
}
