// SPDX-License-Identifier: BSD-3-Clause
#include "passes/gl/textures/output.h"

#include "filter/check.h"
#include "passes/gl/program.h"

enum { CHANNELS = 4 };

// ---- looking ------------------------------------------------------------------------------------

static GLint level_value(const GladGLContext *gl, int level, GLenum name)
{
    GLint value = 0;
    gl->GetTexLevelParameteriv(GL_TEXTURE_2D, level, name, &value);
    return value;
}

// Binds it; an error of that is no error of weft's.
static enum weft_result bind(const struct weft_gl_output *o)
{
    const GladGLContext *gl = &o->context->gl;
    if (!o->at.name || !gl->IsTexture(o->at.name)) {
        weft_error(o->log, "texture %u is none of the context's", o->at.name);
        return WEFT_ERR_ARGUMENT;
    }
    gl->BindTexture(GL_TEXTURE_2D, o->at.name);
    if (gl->GetError() == GL_NO_ERROR)
        return WEFT_OK;
    weft_error(o->log, "texture %u is no GL_TEXTURE_2D", o->at.name);
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result check_size(const struct weft_gl_output *o, int width, int height)
{
    const GladGLContext *gl = &o->context->gl;
    const struct weft_texture *t = &o->at;
    const GLint most[2] = {level_value(gl, t->level, GL_TEXTURE_WIDTH),
                           level_value(gl, t->level, GL_TEXTURE_HEIGHT)};
    if (t->x <= most[0] - width && t->y <= most[1] - height)
        return WEFT_OK;
    weft_error(
        o->log,
        "texture %u has %d x %d texels at level %d; %d x %d pixels from (%d, %d) on need %lld "
        "x %lld",
        t->name, most[0], most[1], t->level, width, height, t->x, t->y, (long long)t->x + width,
        (long long)t->y + height);
    return WEFT_ERR_ARGUMENT;
}

// With the texture attached, GL knows what it holds.
static enum weft_result check_format(const struct weft_gl_output *o, int channels)
{
    static const GLenum sizes[CHANNELS] = {GL_TEXTURE_RED_SIZE, GL_TEXTURE_GREEN_SIZE,
                                           GL_TEXTURE_BLUE_SIZE, GL_TEXTURE_ALPHA_SIZE};
    const GladGLContext *gl = &o->context->gl;
    const GLenum status = gl->CheckFramebufferStatus(GL_FRAMEBUFFER);
    const GLenum format = (GLenum)level_value(gl, o->at.level, GL_TEXTURE_INTERNAL_FORMAT);
    GLint type = 0, encoding = 0;
    if (gl->GetError() != GL_NO_ERROR || status != GL_FRAMEBUFFER_COMPLETE) {
        weft_error(o->log, "texture %u of format 0x%04x: GL cannot draw into level %d (0x%04x)",
                   o->at.name, format, o->at.level, status);
        return WEFT_ERR_ARGUMENT;
    }
    gl->GetFramebufferAttachmentParameteriv(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0,
                                            GL_FRAMEBUFFER_ATTACHMENT_COMPONENT_TYPE, &type);
    gl->GetFramebufferAttachmentParameteriv(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0,
                                            GL_FRAMEBUFFER_ATTACHMENT_COLOR_ENCODING, &encoding);
    if (type == GL_INT || type == GL_UNSIGNED_INT || encoding == GL_SRGB) {
        weft_error(o->log,
                   "texture %u of format 0x%04x holds %s: neither floats nor normalised "
                   "integers as they are",
                   o->at.name, format, encoding == GL_SRGB ? "sRGB" : "integers");
        return WEFT_ERR_ARGUMENT;
    }
    for (int c = o->at.channel; c < o->at.channel + channels; c++)
        if (level_value(gl, o->at.level, sizes[c]) == 0) {
            weft_error(o->log, "texture %u of format 0x%04x has no channel %c", o->at.name, format,
                       "RGBA"[c]);
            return WEFT_ERR_ARGUMENT;
        }
    return WEFT_OK;
}

static enum weft_result check_numbers(const struct weft_gl_output *o, int width, int height,
                                      int channels)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(o->log, width > 0 && height > 0);
    weft_require(o->log, o->at.level >= 0 && o->at.level < 32 && o->at.x >= 0 && o->at.y >= 0);
    weft_require(o->log, o->at.channel >= 0 && o->at.channel < CHANNELS && channels >= 1 &&
                             channels <= CHANNELS - o->at.channel);
    res = WEFT_OK;
fail:
    return res;
}

enum weft_result weft_gl_output_open(weft_context *context, const struct weft_log *log,
                                     const struct weft_texture *texture, int width, int height,
                                     int channels, struct weft_gl_output *out)
{
    const GladGLContext *gl = &context->gl;
    *out = (struct weft_gl_output){.context = context, .log = log, .at = *texture};
    enum weft_result res = check_numbers(out, width, height, channels);
    if (res == WEFT_OK)
        res = bind(out);
    if (res == WEFT_OK)
        res = check_size(out, width, height);
    if (res == WEFT_OK) {
        gl->GenFramebuffers(1, &out->framebuffer);
        gl->BindFramebuffer(GL_FRAMEBUFFER, out->framebuffer);
        gl->FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture->name,
                                 texture->level);
        res = check_format(out, channels);
    }
    gl->BindTexture(GL_TEXTURE_2D, 0);
    if (res == WEFT_OK)
        res = weft_gl_check(log, gl, "looking at a texture");
    if (res != WEFT_OK)
        weft_gl_output_close(out);
    return res;
}

void weft_gl_output_close(struct weft_gl_output *o)
{
    if (o->staging.texture)
        weft_gl_target_destroy(&o->context->gl, &o->staging);
    if (o->framebuffer) {
        o->context->gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
        o->context->gl.DeleteFramebuffers(1, &o->framebuffer);
    }
    *o = (struct weft_gl_output){.framebuffer = 0};
}

// ---- drawing ------------------------------------------------------------------------------------

enum weft_result weft_gl_output_draw(const struct weft_gl_output *o,
                                     const struct weft_gl_drawn *drawn, int first, int channels,
                                     const struct weft_rectangle *to)
{
    static const char *const defines[2][2] = {
        {"#define PACKED 0\n#define MAPS 0\n", "#define PACKED 0\n#define MAPS 1\n"},
        {"#define PACKED 1\n#define MAPS 0\n", "#define PACKED 1\n#define MAPS 1\n"},
    };
    const GladGLContext *gl = &o->context->gl;
    const int x = o->at.x + to->x, y = o->at.y + to->y, from = o->at.channel + first;
    GLuint program = 0;
    const enum weft_result res = weft_program_get(
        o->context, "texture_copy", defines[drawn->texels == WEFT_TEXELS_PACKED][drawn->maps],
        weft_shader_full_target, weft_shader_texture_copy, &program);
    if (res != WEFT_OK)
        return res;
    gl->UseProgram(program);
    weft_gl_bind_texture(gl, program, 0, "source", GL_TEXTURE_2D, drawn->texture);
    gl->Uniform2i(weft_gl_location(gl, program, "offset"), drawn->x - x, drawn->y - y);
    gl->Uniform1i(weft_gl_location(gl, program, "first"), from - drawn->channel);
    gl->Uniform3f(weft_gl_location(gl, program, "mapping"), drawn->offset, drawn->scale,
                  drawn->divisor);
    gl->BindFramebuffer(GL_FRAMEBUFFER, o->framebuffer);
    gl->Viewport(x, y, to->width, to->height);
    GLboolean mask[CHANNELS];
    for (int c = 0; c < CHANNELS; c++)
        mask[c] = c >= from && c < from + channels;
    gl->ColorMask(mask[0], mask[1], mask[2], mask[3]);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    gl->ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    return weft_gl_check(o->log, gl, "drawing into a texture");
}

// Rows of a few thousand pixels are uploaded at a time.
enum { UPLOAD_PIXELS = 1 << 20 };

enum weft_result weft_gl_output_upload(struct weft_gl_output *o, const float *pixels,
                                       int64_t stride, int channel, const struct weft_rectangle *to)
{
    const GladGLContext *gl = &o->context->gl;
    const int fit = UPLOAD_PIXELS / to->width, rows = fit < 1 ? 1 : fit;
    enum weft_result res = weft_gl_target_fit(o->log, gl, GL_R32F, to->width,
                                              rows < to->height ? rows : to->height, &o->staging);
    for (int y = 0; res == WEFT_OK && y < to->height; y += rows) {
        const int count = to->height - y < rows ? to->height - y : rows;
        const struct weft_rectangle part = {to->x, to->y + y, to->width, count};
        gl->BindTexture(GL_TEXTURE_2D, o->staging.texture);
        gl->PixelStorei(GL_UNPACK_ROW_LENGTH, (GLint)stride);
        gl->TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, to->width, count, GL_RED, GL_FLOAT,
                          pixels + y * stride);
        gl->PixelStorei(GL_UNPACK_ROW_LENGTH, 0);
        res = weft_gl_output_draw(o, &(struct weft_gl_drawn){.texture = o->staging.texture},
                                  channel, 1, &part);
    }
    return res;
}
