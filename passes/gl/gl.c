// SPDX-License-Identifier: BSD-3-Clause
#include "passes/gl/gl.h"

#include "passes/gl/native/state.h"

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

// ---- what callers' drawing leaves behind, undone ------------------------------------------------
// Only state that decides what weft's passes draw, upload or read: they bind their own programs,
// textures, buffers and framebuffers.

static void reset_switches(const GladGLContext *gl)
{
    static const GLenum off[] = {
        GL_BLEND,
        GL_DEPTH_TEST,
        GL_STENCIL_TEST,
        GL_SCISSOR_TEST,
        GL_CULL_FACE,
        GL_COLOR_LOGIC_OP,
        GL_DEPTH_CLAMP,
        GL_POLYGON_OFFSET_FILL,
        GL_POLYGON_OFFSET_LINE,
        GL_POLYGON_OFFSET_POINT,
        GL_POLYGON_SMOOTH,
        GL_LINE_SMOOTH,
        GL_SAMPLE_ALPHA_TO_COVERAGE,
        GL_SAMPLE_ALPHA_TO_ONE,
        GL_SAMPLE_COVERAGE,
        GL_SAMPLE_MASK,
        GL_PRIMITIVE_RESTART,
        GL_RASTERIZER_DISCARD,
        GL_FRAMEBUFFER_SRGB,
        GL_PROGRAM_POINT_SIZE,
    };
    enum { CLIP_DISTANCES = 8 };
    for (size_t i = 0; i < WEFT_COUNT(off); i++)
        gl->Disable(off[i]);
    for (unsigned i = 0; i < CLIP_DISTANCES; i++)
        gl->Disable(GL_CLIP_DISTANCE0 + i);
    if (gl->VERSION_4_0)
        gl->Disable(GL_SAMPLE_SHADING);
    gl->Enable(GL_DITHER);
    gl->Enable(GL_MULTISAMPLE);
}

static void reset_drawing(const GladGLContext *gl)
{
    gl->BlendFunc(GL_ONE, GL_ZERO);
    gl->BlendEquation(GL_FUNC_ADD);
    gl->BlendColor(0.0f, 0.0f, 0.0f, 0.0f);
    gl->ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    gl->DepthMask(GL_TRUE);
    gl->DepthFunc(GL_LESS);
    gl->DepthRange(0.0, 1.0);
    gl->StencilMask(~0u);
    gl->StencilFunc(GL_ALWAYS, 0, ~0u);
    gl->StencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
    gl->SampleMaski(0, ~0u);
    gl->PointSize(1.0f);
    gl->LineWidth(1.0f);
    gl->PolygonOffset(0.0f, 0.0f);
    gl->ProvokingVertex(GL_LAST_VERTEX_CONVENTION);
    gl->CullFace(GL_BACK);
    gl->FrontFace(GL_CCW);
    gl->LogicOp(GL_COPY);
    gl->PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    gl->ClearColor(0.0f, 0.0f, 0.0f, 0.0f);
    gl->ClearDepth(1.0);
    gl->ClearStencil(0);
    gl->ClampColor(GL_CLAMP_READ_COLOR, GL_FIXED_ONLY);
    if (gl->ClipControl)
        gl->ClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
}

static void reset_pixel_store(const GladGLContext *gl)
{
    static const GLenum zero[] = {
        GL_PACK_SWAP_BYTES,  GL_PACK_LSB_FIRST,     GL_PACK_ROW_LENGTH,     GL_PACK_IMAGE_HEIGHT,
        GL_PACK_SKIP_PIXELS, GL_PACK_SKIP_ROWS,     GL_PACK_SKIP_IMAGES,    GL_UNPACK_SWAP_BYTES,
        GL_UNPACK_LSB_FIRST, GL_UNPACK_ROW_LENGTH,  GL_UNPACK_IMAGE_HEIGHT, GL_UNPACK_SKIP_PIXELS,
        GL_UNPACK_SKIP_ROWS, GL_UNPACK_SKIP_IMAGES,
    };
    for (size_t i = 0; i < WEFT_COUNT(zero); i++)
        gl->PixelStorei(zero[i], 0);
    gl->PixelStorei(GL_PACK_ALIGNMENT, 4);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 4);
    gl->BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    gl->BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
}

// Samplers would stand in for what textures say of filters.
static void reset_bindings(const GladGLContext *gl, GLuint vertex_array)
{
    GLint units = 0;
    gl->GetIntegerv(GL_MAX_COMBINED_TEXTURE_IMAGE_UNITS, &units);
    for (GLint i = 0; i < units && i < WEFT_GL_STATE_UNITS; i++)
        gl->BindSampler((GLuint)i, 0);
    gl->ActiveTexture(GL_TEXTURE0);
    gl->BindVertexArray(vertex_array);
    gl->UseProgram(0);
    gl->BindRenderbuffer(GL_RENDERBUFFER, 0);
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
}

void weft_gl_reset_state(const GladGLContext *gl, GLuint vertex_array)
{
    reset_switches(gl);
    reset_drawing(gl);
    reset_pixel_store(gl);
    reset_bindings(gl, vertex_array);
}
