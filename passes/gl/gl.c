// SPDX-License-Identifier: BSD-3-Clause
#include "passes/gl/gl.h"

static const char *error_name(GLenum error)
{
    switch (error) {
    case GL_INVALID_ENUM:
        return "GL_INVALID_ENUM";
    case GL_INVALID_VALUE:
        return "GL_INVALID_VALUE";
    case GL_INVALID_OPERATION:
        return "GL_INVALID_OPERATION";
    case GL_INVALID_FRAMEBUFFER_OPERATION:
        return "GL_INVALID_FRAMEBUFFER_OPERATION";
    case GL_OUT_OF_MEMORY:
        return "GL_OUT_OF_MEMORY";
    case GL_CONTEXT_LOST:
        return "GL_CONTEXT_LOST";
    }
    return "unknown GL error";
}

enum weft_result weft_gl_check(const struct weft_log *log, const GladGLContext *gl,
                               const char *step)
{
    enum weft_result res = WEFT_OK;
    // A lost context reports errors for ever.
    for (int i = 0; i < 8; i++) {
        GLenum error = gl->GetError();
        if (error == GL_NO_ERROR)
            break;
        weft_error(log, "GL: %s (0x%04x) after %s", error_name(error), error, step);
        res = error == GL_OUT_OF_MEMORY ? WEFT_ERR_MEMORY : WEFT_ERR_GL;
    }
    return res;
}

static size_t format_bytes(GLenum format)
{
    switch (format) {
    case GL_RGBA32F:
        return 16;
    case GL_RGBA16F:
    case GL_RGBA16:
    case GL_RGBA16UI:
    case GL_RG32UI:
        return 8;
    case GL_R16F:
    case GL_R16:
    case GL_R16UI:
        return 2;
    case GL_R8:
    case GL_R8UI:
        return 1;
    default: // GL_RGBA8, GL_RGBA8UI, GL_R32F, GL_R32I, GL_R32UI
        return 4;
    }
}

enum weft_result weft_gl_buffer_create(const struct weft_log *log, const GladGLContext *gl,
                                       GLenum format, size_t texel_count,
                                       struct weft_gl_buffer *out)
{
    *out = (struct weft_gl_buffer){.format = format, .texel_bytes = format_bytes(format)};
    out->size_bytes = texel_count * out->texel_bytes;
    gl->GenBuffers(1, &out->buffer);
    gl->BindBuffer(GL_TEXTURE_BUFFER, out->buffer);
    gl->BufferData(GL_TEXTURE_BUFFER, (GLsizeiptr)out->size_bytes, NULL, GL_STREAM_DRAW);
    gl->GenTextures(1, &out->texture);
    gl->BindTexture(GL_TEXTURE_BUFFER, out->texture);
    gl->TexBuffer(GL_TEXTURE_BUFFER, format, out->buffer);
    enum weft_result res = weft_gl_check(log, gl, "creating a texture buffer");
    if (res != WEFT_OK) {
        weft_error(log, "a texture buffer of %zu bytes could not be created", out->size_bytes);
        weft_gl_buffer_destroy(gl, out);
    }
    return res;
}

void weft_gl_buffer_destroy(const GladGLContext *gl, struct weft_gl_buffer *buffer)
{
    if (buffer->texture)
        gl->DeleteTextures(1, &buffer->texture);
    if (buffer->buffer)
        gl->DeleteBuffers(1, &buffer->buffer);
    *buffer = (struct weft_gl_buffer){0};
}

enum weft_result weft_gl_buffer_fit(const struct weft_log *log, const GladGLContext *gl,
                                    GLenum format, size_t texel_count,
                                    struct weft_gl_buffer *buffer)
{
    const size_t bytes = texel_count * format_bytes(format);
    if (buffer->buffer && buffer->format != format)
        weft_gl_buffer_destroy(gl, buffer);
    if (!buffer->buffer)
        return weft_gl_buffer_create(log, gl, format, texel_count, buffer);
    if (bytes <= buffer->size_bytes)
        return WEFT_OK;
    buffer->size_bytes = bytes;
    gl->BindBuffer(GL_TEXTURE_BUFFER, buffer->buffer);
    gl->BufferData(GL_TEXTURE_BUFFER, (GLsizeiptr)bytes, NULL, GL_STREAM_DRAW);
    const enum weft_result res = weft_gl_check(log, gl, "growing a texture buffer");
    if (res == WEFT_OK)
        return WEFT_OK;
    weft_error(log, "a texture buffer could not grow to %zu bytes", bytes);
    weft_gl_buffer_destroy(gl, buffer);
    return res;
}

enum weft_result weft_gl_buffer_grow(const struct weft_log *log, const GladGLContext *gl,
                                     GLenum format, size_t texel_count,
                                     struct weft_gl_buffer *buffer)
{
    const size_t bytes = texel_count * format_bytes(format);
    GLuint larger;
    if (!buffer->buffer)
        return weft_gl_buffer_create(log, gl, format, texel_count, buffer);
    gl->GenBuffers(1, &larger);
    gl->BindBuffer(GL_TEXTURE_BUFFER, larger);
    gl->BufferData(GL_TEXTURE_BUFFER, (GLsizeiptr)bytes, NULL, GL_STREAM_DRAW);
    gl->BindBuffer(GL_COPY_READ_BUFFER, buffer->buffer);
    gl->CopyBufferSubData(GL_COPY_READ_BUFFER, GL_TEXTURE_BUFFER, 0, 0,
                          (GLsizeiptr)buffer->size_bytes);
    gl->BindBuffer(GL_COPY_READ_BUFFER, 0);
    const enum weft_result res = weft_gl_check(log, gl, "growing a texture buffer");
    if (res != WEFT_OK) {
        weft_error(log, "a texture buffer could not grow to %zu bytes", bytes);
        gl->DeleteBuffers(1, &larger);
        return res;
    }
    gl->BindTexture(GL_TEXTURE_BUFFER, buffer->texture);
    gl->TexBuffer(GL_TEXTURE_BUFFER, format, larger);
    gl->DeleteBuffers(1, &buffer->buffer);
    buffer->buffer = larger;
    buffer->size_bytes = bytes;
    return WEFT_OK;
}

enum weft_result weft_gl_buffer_load(const struct weft_log *log, const GladGLContext *gl,
                                     GLenum format, const void *data, size_t bytes,
                                     struct weft_gl_buffer *buffer)
{
    const enum weft_result res =
        weft_gl_buffer_fit(log, gl, format, bytes / format_bytes(format), buffer);
    if (res != WEFT_OK)
        return res;
    gl->BindBuffer(GL_TEXTURE_BUFFER, buffer->buffer);
    gl->BufferSubData(GL_TEXTURE_BUFFER, 0, (GLsizeiptr)bytes, data);
    return weft_gl_check(log, gl, "filling a texture buffer");
}

void *weft_gl_buffer_map(const GladGLContext *gl, const struct weft_gl_buffer *buffer,
                         size_t size_bytes)
{
    return weft_gl_buffer_map_range(gl, buffer, 0, size_bytes);
}

void *weft_gl_buffer_map_range(const GladGLContext *gl, const struct weft_gl_buffer *buffer,
                               size_t offset, size_t size_bytes)
{
    gl->BindBuffer(GL_TEXTURE_BUFFER, buffer->buffer);
    return gl->MapBufferRange(GL_TEXTURE_BUFFER, (GLintptr)offset, (GLsizeiptr)size_bytes,
                              GL_MAP_WRITE_BIT | GL_MAP_INVALIDATE_RANGE_BIT);
}

bool weft_gl_buffer_unmap(const GladGLContext *gl, const struct weft_gl_buffer *buffer)
{
    gl->BindBuffer(GL_TEXTURE_BUFFER, buffer->buffer);
    return gl->UnmapBuffer(GL_TEXTURE_BUFFER);
}
