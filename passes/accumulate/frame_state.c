// SPDX-License-Identifier: BSD-3-Clause
// What callers' drawing leaves behind in GL, undone. Only state that decides what weft's passes
// draw, upload or read: they bind their own programs, textures, buffers and framebuffers.
#include "passes/accumulate/frame.h"

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
        GL_POLYGON_SMOOTH,
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
    for (GLint i = 0; i < units; i++)
        gl->BindSampler((GLuint)i, 0);
    gl->ActiveTexture(GL_TEXTURE0);
    gl->BindVertexArray(vertex_array);
    gl->UseProgram(0);
    gl->BindRenderbuffer(GL_RENDERBUFFER, 0);
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
}

void weft_frame_reset_state(const GladGLContext *gl, GLuint vertex_array)
{
    reset_switches(gl);
    reset_drawing(gl);
    reset_pixel_store(gl);
    reset_bindings(gl, vertex_array);
}
