// SPDX-License-Identifier: BSD-3-Clause
// The target that moved pictures are drawn into, and its stencil: 1 where pixels are to be drawn.
#include "filter/check.h"
#include "passes/antialias/supersample_impl.h"
#include "passes/gl/program.h"

GLenum weft_supersample_format(const weft_supersample *s)
{
    static const GLenum formats[WEFT_ANTIALIAS_FORMAT_COUNT] = {GL_RGBA8, GL_RGBA16F, GL_RGBA32F};
    return formats[s->params.format];
}

enum weft_result weft_supersample_make_scratch(weft_supersample *s)
{
    const GladGLContext *gl = &s->params.context->gl;
    const struct weft_log *log = s->params.log;
    const int width = s->params.width + 2 * s->radius, height = s->params.height + 2 * s->radius;
    enum weft_result res = weft_background_kept(log, gl, weft_supersample_format(s),
                                                s->params.background, s->background);
    if (res == WEFT_OK)
        res =
            weft_gl_target_create(log, gl, weft_supersample_format(s), width, height, &s->scratch);
    if (res == WEFT_OK)
        res = weft_depth_buffer_create(log, gl, width, height, 1, 24, true, &s->depth);
    if (res != WEFT_OK)
        return res;
    gl->BindFramebuffer(GL_FRAMEBUFFER, s->scratch.framebuffer);
    gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, s->depth.attachment, GL_RENDERBUFFER,
                                s->depth.renderbuffer);
    if (gl->CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
        weft_error(log, "GL: a target of %d x %d pixels with depth and stencil cannot be had",
                   width, height);
        return WEFT_ERR_GL;
    }
    return weft_gl_check(log, gl, "making a target of samples");
}

void weft_supersample_destroy_scratch(weft_supersample *s)
{
    const GladGLContext *gl = &s->params.context->gl;
    weft_gl_target_destroy(gl, &s->scratch);
    weft_depth_buffer_destroy(gl, &s->depth);
}

// ---- which pixels are drawn ---------------------------------------------------------------------

static GLuint load_mask(const GladGLContext *gl, const struct weft_marks *marks)
{
    GLuint texture;
    gl->GenTextures(1, &texture);
    gl->BindTexture(GL_TEXTURE_2D, texture);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    gl->TexImage2D(GL_TEXTURE_2D, 0, GL_R8, marks->width, marks->height, 0, GL_RED,
                   GL_UNSIGNED_BYTE, marks->marked);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 4);
    weft_texture_by_texel(gl, GL_TEXTURE_2D);
    return texture;
}

// Core GL cannot write the stencil from memory, but where a fragment passes.
enum weft_result weft_supersample_mask(weft_supersample *s)
{
    static const struct weft_pass_state state = {
        .stencil = {.func = GL_ALWAYS, .ref = 1, .read = 1, .write = 1, .pass = GL_REPLACE}};
    const GladGLContext *gl = &s->params.context->gl;
    GLuint program;
    if (!s->masked)
        return WEFT_OK;
    const enum weft_result res =
        weft_program_get(s->params.context, "supersample_mask", "", weft_shader_full_target,
                         weft_shader_supersample_mask, &program);
    if (res != WEFT_OK)
        return res;
    const GLuint texture = load_mask(gl, &s->mask);
    weft_pass_state_begin(gl, s->scratch.framebuffer, s->scratch.width, s->scratch.height,
                          &s->window, &state);
    gl->ClearStencil(0);
    gl->Clear(GL_STENCIL_BUFFER_BIT);
    gl->UseProgram(program);
    weft_gl_bind_texture(gl, program, 0, "mask", GL_TEXTURE_2D, texture);
    gl->Uniform2i(weft_gl_location(gl, program, "first"), s->window.x, s->window.y);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    weft_pass_state_end(gl);
    gl->DrawBuffer(GL_COLOR_ATTACHMENT0);
    gl->ReadBuffer(GL_COLOR_ATTACHMENT0);
    gl->DeleteTextures(1, &texture);
    weft_marks_clear(&s->mask);
    return weft_gl_check(s->params.log, gl, "masking what is drawn");
}

// ---- drawing ------------------------------------------------------------------------------------

enum weft_result weft_supersample_draw(weft_supersample *s,
                                       const struct weft_antialias_drawing *drawing, int index)
{
    const GladGLContext *gl = &s->params.context->gl;
    struct weft_antialias_pass pass = {
        .stage = WEFT_STAGE_COLOUR,
        .index = index,
        .count = s->used,
        .framebuffer = s->scratch.framebuffer,
        .width = s->scratch.width,
        .height = s->scratch.height,
        .part = s->window,
        .head = weft_head_colour(gl, false),
    };
    struct weft_pass_state state = {.colours = 1, .depth_func = GL_LESS, .depth_write = true};
    if (s->masked) {
        state.stencil.func = GL_EQUAL;
        state.stencil.ref = 1;
        state.stencil.read = 1;
        state.stencil.pass = GL_KEEP;
    }
    weft_drawing_place(s->params.width, s->params.height, s->radius, s->sample[index].position,
                       pass.place);
    gl->BindFramebuffer(GL_FRAMEBUFFER, s->scratch.framebuffer);
    weft_part_scissor(gl, &s->window, s->scratch.width, s->scratch.height);
    gl->ClearColor(s->background[0], s->background[1], s->background[2], s->background[3]);
    gl->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    return weft_drawing_run(s->params.log, s->params.context, drawing, &pass, &state);
}
