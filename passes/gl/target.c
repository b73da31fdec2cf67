// SPDX-License-Identifier: BSD-3-Clause
#include "passes/gl/target.h"

#include "filter/check.h"

struct format {
    GLenum format;
    const char *name;
    GLenum channels, type;
};

static const struct format formats[] = {
    {GL_R8, "r8", GL_RED, GL_UNSIGNED_BYTE},
    {GL_RGBA8, "rgba8", GL_RGBA, GL_UNSIGNED_BYTE},
    {GL_R16, "r16", GL_RED, GL_UNSIGNED_SHORT},
    {GL_RGBA16, "rgba16", GL_RGBA, GL_UNSIGNED_SHORT},
    {GL_R16F, "r16f", GL_RED, GL_FLOAT},
    {GL_RGBA16F, "rgba16f", GL_RGBA, GL_FLOAT},
    {GL_R32F, "r32f", GL_RED, GL_FLOAT},
    {GL_RGBA32F, "rgba32f", GL_RGBA, GL_FLOAT},
    {GL_RGBA32I, "rgba32i", GL_RGBA_INTEGER, GL_INT},
};

static const struct format *find_format(GLenum format)
{
    size_t i = 0;
    while (i + 1 < WEFT_COUNT(formats) && formats[i].format != format)
        i++;
    return &formats[i];
}

enum weft_result weft_gl_target_create(const struct weft_log *log, const GladGLContext *gl,
                                       GLenum format, int width, int height,
                                       struct weft_gl_target *out)
{
    const struct format *f = find_format(format);
    *out = (struct weft_gl_target){.format = format, .width = width, .height = height};
    gl->GenTextures(1, &out->texture);
    gl->BindTexture(GL_TEXTURE_2D, out->texture);
    gl->TexImage2D(GL_TEXTURE_2D, 0, (GLint)format, width, height, 0, f->channels, f->type, NULL);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl->GenFramebuffers(1, &out->framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, out->framebuffer);
    gl->FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, out->texture, 0);
    const GLenum status = gl->CheckFramebufferStatus(GL_FRAMEBUFFER);
    enum weft_result res = weft_gl_check(log, gl, "creating a render target");
    if (res == WEFT_OK && status == GL_FRAMEBUFFER_COMPLETE)
        return WEFT_OK;
    weft_error(log, "GL: a render target of %d x %d texels %s cannot be had (0x%04x)", width,
               height, f->name, status);
    weft_gl_target_destroy(gl, out);
    return res == WEFT_OK ? WEFT_ERR_GL : res;
}

void weft_gl_target_destroy(const GladGLContext *gl, struct weft_gl_target *target)
{
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    if (target->framebuffer)
        gl->DeleteFramebuffers(1, &target->framebuffer);
    if (target->texture)
        gl->DeleteTextures(1, &target->texture);
    *target = (struct weft_gl_target){0};
}

enum weft_result weft_gl_target_fit(const struct weft_log *log, const GladGLContext *gl,
                                    GLenum format, int width, int height,
                                    struct weft_gl_target *target)
{
    const bool same = target->texture && target->format == format;
    if (same && target->width >= width && target->height >= height)
        return WEFT_OK;
    if (same) {
        width = target->width > width ? target->width : width;
        height = target->height > height ? target->height : height;
    }
    weft_gl_target_destroy(gl, target);
    return weft_gl_target_create(log, gl, format, width, height, target);
}

void weft_gl_target_bind(const GladGLContext *gl, const struct weft_gl_target *target, int width,
                         int height)
{
    gl->BindFramebuffer(GL_FRAMEBUFFER, target->framebuffer);
    gl->Viewport(0, 0, width, height);
}

void weft_gl_targets_bind(const GladGLContext *gl, const struct weft_gl_target *targets, int count,
                          int width, int height)
{
    GLenum buffers[8]; // as many as every GL 3.3 has
    weft_gl_target_bind(gl, targets, width, height);
    for (int i = 0; i < count; i++) {
        buffers[i] = GL_COLOR_ATTACHMENT0 + (GLenum)i;
        gl->FramebufferTexture2D(GL_FRAMEBUFFER, buffers[i], GL_TEXTURE_2D, targets[i].texture, 0);
    }
    gl->DrawBuffers(count, buffers);
}

enum weft_result weft_gl_target_read(const struct weft_log *log, const GladGLContext *gl,
                                     const struct weft_gl_target *target,
                                     const struct weft_gl_pixels *out)
{
    gl->BindFramebuffer(GL_FRAMEBUFFER, target->framebuffer);
    gl->PixelStorei(GL_PACK_ROW_LENGTH, out->stride);
    gl->PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl->ReadPixels(out->x, out->y, out->width, out->height, find_format(target->format)->channels,
                   out->type, out->data);
    gl->PixelStorei(GL_PACK_ALIGNMENT, 4);
    gl->PixelStorei(GL_PACK_ROW_LENGTH, 0);
    return weft_gl_check(log, gl, "reading pixels back");
}

GLint weft_gl_location(const GladGLContext *gl, GLuint program, const char *name)
{
    return gl->GetUniformLocation(program, name);
}

void weft_gl_bind_texture(const GladGLContext *gl, GLuint program, GLuint unit, const char *name,
                          GLenum kind, GLuint texture)
{
    gl->ActiveTexture(GL_TEXTURE0 + unit);
    gl->BindTexture(kind, texture);
    gl->Uniform1i(weft_gl_location(gl, program, name), (GLint)unit);
    gl->ActiveTexture(GL_TEXTURE0);
}

void weft_gl_bind_buffer(const GladGLContext *gl, GLuint program, GLuint unit, const char *name,
                         const struct weft_gl_buffer *buffer)
{
    weft_gl_bind_texture(gl, program, unit, name, GL_TEXTURE_BUFFER, buffer->texture);
}
