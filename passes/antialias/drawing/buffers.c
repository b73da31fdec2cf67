// SPDX-License-Identifier: BSD-3-Clause
#include <inttypes.h>

#include "filter/check.h"
#include "passes/antialias/drawing/run.h"

// ---- bytes --------------------------------------------------------------------------------------

// Of a texel or sample of so many bits.
static uint64_t texel_bytes(int64_t bits)
{
    return bits == 40 ? 8 : (uint64_t)(bits + 7) / 8;
}

uint64_t weft_renderbuffer_bytes(const GladGLContext *gl, GLuint renderbuffer)
{
    static const GLenum sizes[] = {GL_RENDERBUFFER_RED_SIZE,   GL_RENDERBUFFER_GREEN_SIZE,
                                   GL_RENDERBUFFER_BLUE_SIZE,  GL_RENDERBUFFER_ALPHA_SIZE,
                                   GL_RENDERBUFFER_DEPTH_SIZE, GL_RENDERBUFFER_STENCIL_SIZE};
    GLint width = 0, height = 0, samples = 0;
    int64_t bits = 0;
    gl->BindRenderbuffer(GL_RENDERBUFFER, renderbuffer);
    gl->GetRenderbufferParameteriv(GL_RENDERBUFFER, GL_RENDERBUFFER_WIDTH, &width);
    gl->GetRenderbufferParameteriv(GL_RENDERBUFFER, GL_RENDERBUFFER_HEIGHT, &height);
    gl->GetRenderbufferParameteriv(GL_RENDERBUFFER, GL_RENDERBUFFER_SAMPLES, &samples);
    for (size_t i = 0; i < WEFT_COUNT(sizes); i++) {
        GLint size = 0;
        gl->GetRenderbufferParameteriv(GL_RENDERBUFFER, sizes[i], &size);
        bits += size;
    }
    gl->BindRenderbuffer(GL_RENDERBUFFER, 0);
    return (uint64_t)width * (uint64_t)height * (uint64_t)(samples > 1 ? samples : 1) *
           texel_bytes(bits);
}

uint64_t weft_texture_bytes(const GladGLContext *gl, GLenum target, GLuint texture)
{
    static const GLenum sizes[] = {GL_TEXTURE_RED_SIZE,   GL_TEXTURE_GREEN_SIZE,
                                   GL_TEXTURE_BLUE_SIZE,  GL_TEXTURE_ALPHA_SIZE,
                                   GL_TEXTURE_DEPTH_SIZE, GL_TEXTURE_STENCIL_SIZE};
    GLint size[3] = {0}, samples = 0;
    int64_t bits = 0;
    gl->BindTexture(target, texture);
    gl->GetTexLevelParameteriv(target, 0, GL_TEXTURE_WIDTH, &size[0]);
    gl->GetTexLevelParameteriv(target, 0, GL_TEXTURE_HEIGHT, &size[1]);
    gl->GetTexLevelParameteriv(target, 0, GL_TEXTURE_DEPTH, &size[2]);
    if (target == GL_TEXTURE_2D_MULTISAMPLE)
        gl->GetTexLevelParameteriv(target, 0, GL_TEXTURE_SAMPLES, &samples);
    for (size_t i = 0; i < WEFT_COUNT(sizes); i++) {
        GLint channel = 0;
        gl->GetTexLevelParameteriv(target, 0, sizes[i], &channel);
        bits += channel;
    }
    gl->BindTexture(target, 0);
    return (uint64_t)size[0] * (uint64_t)size[1] * (uint64_t)size[2] *
           (uint64_t)(samples > 1 ? samples : 1) * texel_bytes(bits);
}

// ---- depths -------------------------------------------------------------------------------------

static GLenum format_of(int depth_bits, bool stencil)
{
    if (depth_bits == 32)
        return stencil ? GL_DEPTH32F_STENCIL8 : GL_DEPTH_COMPONENT32F;
    return GL_DEPTH24_STENCIL8;
}

enum weft_result weft_depth_buffer_create(const struct weft_log *log, const GladGLContext *gl,
                                          int32_t width, int32_t height, int samples,
                                          int depth_bits, bool stencil,
                                          struct weft_depth_buffer *out)
{
    GLint most = 0;
    *out = (struct weft_depth_buffer){.attachment = depth_bits == 32 && !stencil
                                                        ? GL_DEPTH_ATTACHMENT
                                                        : GL_DEPTH_STENCIL_ATTACHMENT};
    gl->GetIntegerv(GL_MAX_SAMPLES, &most);
    if (samples > 1 && samples > most) {
        weft_error(log, "antialias: %d samples of a pixel; GL has at most %d", samples, most);
        *out = (struct weft_depth_buffer){0};
        return WEFT_ERR_LIMIT;
    }
    gl->GenRenderbuffers(1, &out->renderbuffer);
    gl->BindRenderbuffer(GL_RENDERBUFFER, out->renderbuffer);
    gl->RenderbufferStorageMultisample(GL_RENDERBUFFER, samples > 1 ? samples : 0,
                                       format_of(depth_bits, stencil), width, height);
    gl->GetRenderbufferParameteriv(GL_RENDERBUFFER, GL_RENDERBUFFER_SAMPLES, &out->samples);
    out->samples = out->samples > 1 ? out->samples : 1;
    const enum weft_result res = weft_gl_check(log, gl, "making a buffer of depths");
    if (res == WEFT_OK) {
        out->bytes = weft_renderbuffer_bytes(gl, out->renderbuffer);
        return WEFT_OK;
    }
    weft_error(
        log, "antialias: depths of %" PRId32 " x %" PRId32 " pixels with %d samples cannot be had",
        width, height, samples);
    weft_depth_buffer_destroy(gl, out);
    return res;
}

void weft_depth_buffer_destroy(const GladGLContext *gl, struct weft_depth_buffer *buffer)
{
    if (buffer->renderbuffer)
        gl->DeleteRenderbuffers(1, &buffer->renderbuffer);
    *buffer = (struct weft_depth_buffer){0};
}

void weft_texture_by_texel(const GladGLContext *gl, GLenum target)
{
    gl->TexParameteri(target, GL_TEXTURE_MAX_LEVEL, 0);
    gl->TexParameteri(target, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl->TexParameteri(target, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
}
