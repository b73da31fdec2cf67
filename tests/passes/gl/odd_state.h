// SPDX-License-Identifier: BSD-3-Clause
// tests/passes/gl/odd_state.h - state of GL that is nowhere its default, and all of it compared.
// Include after cmocka.h.
#ifndef WEFT_TESTS_PASSES_GL_ODD_STATE_H
#define WEFT_TESTS_PASSES_GL_ODD_STATE_H

#include <string.h>

#include "filter/check.h"
#include "passes/gl/gl.h"

enum { ODD_VALUES = 4096, ODD_UNITS = 40 };

// Of GL as it is, in one order.
struct odd_values {
    int count;
    GLenum name[ODD_VALUES];
    int index[ODD_VALUES];
    double value[ODD_VALUES];
};

static inline void odd_add(struct odd_values *v, GLenum name, int index, double value)
{
    assert_true(v->count < ODD_VALUES);
    v->name[v->count] = name;
    v->index[v->count] = index;
    v->value[v->count++] = value;
}

struct odd_name {
    GLenum name;
    int values, since;
};

static const GLenum odd_switches[] = {
    GL_BLEND,
    GL_COLOR_LOGIC_OP,
    GL_CULL_FACE,
    GL_DEPTH_CLAMP,
    GL_DEPTH_TEST,
    GL_DITHER,
    GL_FRAMEBUFFER_SRGB,
    GL_LINE_SMOOTH,
    GL_MULTISAMPLE,
    GL_POLYGON_OFFSET_FILL,
    GL_POLYGON_OFFSET_LINE,
    GL_POLYGON_OFFSET_POINT,
    GL_POLYGON_SMOOTH,
    GL_PRIMITIVE_RESTART,
    GL_PROGRAM_POINT_SIZE,
    GL_RASTERIZER_DISCARD,
    GL_SAMPLE_ALPHA_TO_COVERAGE,
    GL_SAMPLE_ALPHA_TO_ONE,
    GL_SAMPLE_COVERAGE,
    GL_SAMPLE_MASK,
    GL_SCISSOR_TEST,
    GL_STENCIL_TEST,
    GL_TEXTURE_CUBE_MAP_SEAMLESS,
    GL_CLIP_DISTANCE0,
    GL_CLIP_DISTANCE0 + 3,
    GL_CLIP_DISTANCE0 + 7,
};

static const struct odd_name odd_names[] = {
    {GL_ACTIVE_TEXTURE, 1, 33},
    {GL_ARRAY_BUFFER_BINDING, 1, 33},
    {GL_BLEND_COLOR, 4, 33},
    {GL_CLAMP_READ_COLOR, 1, 33},
    {GL_CLIP_DEPTH_MODE, 1, 45},
    {GL_CLIP_ORIGIN, 1, 45},
    {GL_COLOR_CLEAR_VALUE, 4, 33},
    {GL_COPY_READ_BUFFER_BINDING, 1, 33},
    {GL_COPY_WRITE_BUFFER_BINDING, 1, 33},
    {GL_CULL_FACE_MODE, 1, 33},
    {GL_CURRENT_PROGRAM, 1, 33},
    {GL_DEPTH_CLEAR_VALUE, 1, 33},
    {GL_DEPTH_FUNC, 1, 33},
    {GL_DEPTH_WRITEMASK, 1, 33},
    {GL_DRAW_BUFFER, 1, 33},
    {GL_DRAW_FRAMEBUFFER_BINDING, 1, 33},
    {GL_ELEMENT_ARRAY_BUFFER_BINDING, 1, 33},
    {GL_FRONT_FACE, 1, 33},
    {GL_LINE_WIDTH, 1, 33},
    {GL_LOGIC_OP_MODE, 1, 33},
    {GL_MIN_SAMPLE_SHADING_VALUE, 1, 40},
    {GL_PATCH_VERTICES, 1, 40},
    {GL_PIXEL_PACK_BUFFER_BINDING, 1, 33},
    {GL_PIXEL_UNPACK_BUFFER_BINDING, 1, 33},
    {GL_POINT_FADE_THRESHOLD_SIZE, 1, 33},
    {GL_POINT_SIZE, 1, 33},
    {GL_POINT_SPRITE_COORD_ORIGIN, 1, 33},
    {GL_POLYGON_MODE, 1, 33},
    {GL_POLYGON_OFFSET_FACTOR, 1, 33},
    {GL_POLYGON_OFFSET_UNITS, 1, 33},
    {GL_PRIMITIVE_RESTART_INDEX, 1, 33},
    {GL_PROVOKING_VERTEX, 1, 33},
    {GL_READ_BUFFER, 1, 33},
    {GL_READ_FRAMEBUFFER_BINDING, 1, 33},
    {GL_RENDERBUFFER_BINDING, 1, 33},
    {GL_SAMPLE_COVERAGE_INVERT, 1, 33},
    {GL_SAMPLE_COVERAGE_VALUE, 1, 33},
    {GL_STENCIL_BACK_FAIL, 1, 33},
    {GL_STENCIL_BACK_FUNC, 1, 33},
    {GL_STENCIL_BACK_PASS_DEPTH_FAIL, 1, 33},
    {GL_STENCIL_BACK_PASS_DEPTH_PASS, 1, 33},
    {GL_STENCIL_BACK_REF, 1, 33},
    {GL_STENCIL_BACK_VALUE_MASK, 1, 33},
    {GL_STENCIL_BACK_WRITEMASK, 1, 33},
    {GL_STENCIL_CLEAR_VALUE, 1, 33},
    {GL_STENCIL_FAIL, 1, 33},
    {GL_STENCIL_FUNC, 1, 33},
    {GL_STENCIL_PASS_DEPTH_FAIL, 1, 33},
    {GL_STENCIL_PASS_DEPTH_PASS, 1, 33},
    {GL_STENCIL_REF, 1, 33},
    {GL_STENCIL_VALUE_MASK, 1, 33},
    {GL_STENCIL_WRITEMASK, 1, 33},
    {GL_TEXTURE_BUFFER_BINDING, 1, 33},
    {GL_UNIFORM_BUFFER_BINDING, 1, 33},
    {GL_VERTEX_ARRAY_BINDING, 1, 33},
    {GL_PACK_ALIGNMENT, 1, 33},
    {GL_PACK_IMAGE_HEIGHT, 1, 33},
    {GL_PACK_LSB_FIRST, 1, 33},
    {GL_PACK_ROW_LENGTH, 1, 33},
    {GL_PACK_SKIP_IMAGES, 1, 33},
    {GL_PACK_SKIP_PIXELS, 1, 33},
    {GL_PACK_SKIP_ROWS, 1, 33},
    {GL_PACK_SWAP_BYTES, 1, 33},
    {GL_UNPACK_ALIGNMENT, 1, 33},
    {GL_UNPACK_IMAGE_HEIGHT, 1, 33},
    {GL_UNPACK_LSB_FIRST, 1, 33},
    {GL_UNPACK_ROW_LENGTH, 1, 33},
    {GL_UNPACK_SKIP_IMAGES, 1, 33},
    {GL_UNPACK_SKIP_PIXELS, 1, 33},
    {GL_UNPACK_SKIP_ROWS, 1, 33},
    {GL_UNPACK_SWAP_BYTES, 1, 33},
};

// Of compatibility profiles, whose names are not in the header: switches of the alpha test, smooth
// points, stipples of lines and polygons and point sprites; colour clamps, and pixel transfer.
static const GLenum odd_old_switches[] = {0x0BC0, 0x0B10, 0x0B24, 0x0B42, 0x8861};
static const GLenum odd_old[] = {0x891A, 0x891B, 0x0D10, 0x0D14, 0x0D15, 0x0D18,
                                 0x0D19, 0x0D1A, 0x0D1B, 0x0D1C, 0x0D1D};

static const GLenum odd_blend[] = {GL_BLEND_SRC_RGB,      GL_BLEND_DST_RGB,
                                   GL_BLEND_SRC_ALPHA,    GL_BLEND_DST_ALPHA,
                                   GL_BLEND_EQUATION_RGB, GL_BLEND_EQUATION_ALPHA};
static const GLenum odd_textures[] = {GL_TEXTURE_BINDING_1D,
                                      GL_TEXTURE_BINDING_2D,
                                      GL_TEXTURE_BINDING_3D,
                                      GL_TEXTURE_BINDING_2D_ARRAY,
                                      GL_TEXTURE_BINDING_BUFFER,
                                      GL_TEXTURE_BINDING_2D_MULTISAMPLE,
                                      GL_TEXTURE_BINDING_2D_MULTISAMPLE_ARRAY,
                                      GL_TEXTURE_BINDING_CUBE_MAP,
                                      GL_SAMPLER_BINDING};
static const GLenum odd_images[] = {GL_IMAGE_BINDING_NAME,   GL_IMAGE_BINDING_LEVEL,
                                    GL_IMAGE_BINDING_LAYER,  GL_IMAGE_BINDING_LAYERED,
                                    GL_IMAGE_BINDING_ACCESS, GL_IMAGE_BINDING_FORMAT};

static inline int odd_version(const GladGLContext *gl)
{
    GLint major = 0, minor = 0;
    gl->GetIntegerv(GL_MAJOR_VERSION, &major);
    gl->GetIntegerv(GL_MINOR_VERSION, &minor);
    return 10 * major + minor;
}

static inline bool odd_is_core(const GladGLContext *gl)
{
    GLint mask = 0;
    gl->GetIntegerv(GL_CONTEXT_PROFILE_MASK, &mask);
    return mask & GL_CONTEXT_CORE_PROFILE_BIT;
}

static inline void odd_read_indexed(const GladGLContext *gl, int version, struct odd_values *v)
{
    GLint64 place;
    GLint value;
    for (int i = 0; i < 8; i++) {
        GLboolean mask[4];
        odd_add(v, GL_BLEND, i, gl->IsEnabledi(GL_BLEND, (GLuint)i));
        gl->GetBooleani_v(GL_COLOR_WRITEMASK, (GLuint)i, mask);
        for (int c = 0; c < 4; c++)
            odd_add(v, GL_COLOR_WRITEMASK, 4 * i + c, mask[c]);
        for (size_t n = 0; n < WEFT_COUNT(odd_blend); n++) {
            if (version >= 40)
                gl->GetIntegeri_v(odd_blend[n], (GLuint)i, &value);
            else
                gl->GetIntegerv(odd_blend[n], &value);
            odd_add(v, odd_blend[n], i, value);
        }
    }
    for (GLuint i = 0; i < 36; i++) {
        gl->GetIntegeri_v(GL_UNIFORM_BUFFER_BINDING, i, &value);
        odd_add(v, GL_UNIFORM_BUFFER_BINDING, (int)i, value);
        gl->GetInteger64i_v(GL_UNIFORM_BUFFER_START, i, &place);
        odd_add(v, GL_UNIFORM_BUFFER_START, (int)i, (double)place);
        gl->GetInteger64i_v(GL_UNIFORM_BUFFER_SIZE, i, &place);
        odd_add(v, GL_UNIFORM_BUFFER_SIZE, (int)i, (double)place);
    }
    for (GLuint i = 0; version >= 42 && i < 8; i++)
        for (size_t n = 0; n < WEFT_COUNT(odd_images); n++) {
            gl->GetIntegeri_v(odd_images[n], i, &value);
            odd_add(v, odd_images[n], (int)i, value);
        }
    gl->GetIntegeri_v(GL_SAMPLE_MASK_VALUE, 0, &value);
    odd_add(v, GL_SAMPLE_MASK_VALUE, 0, value);
}

static inline void odd_read_viewports(const GladGLContext *gl, int version, struct odd_values *v)
{
    for (GLuint i = 0; i < (version >= 41 ? 16 : 1); i++) {
        GLdouble at[4] = {0}, depth[2] = {0};
        GLint box[4] = {0};
        if (version >= 41) {
            gl->GetDoublei_v(GL_VIEWPORT, i, at);
            gl->GetDoublei_v(GL_DEPTH_RANGE, i, depth);
            gl->GetIntegeri_v(GL_SCISSOR_BOX, i, box);
            odd_add(v, GL_SCISSOR_TEST, (int)i, gl->IsEnabledi(GL_SCISSOR_TEST, i));
        } else {
            gl->GetDoublev(GL_VIEWPORT, at);
            gl->GetDoublev(GL_DEPTH_RANGE, depth);
            gl->GetIntegerv(GL_SCISSOR_BOX, box);
        }
        for (int n = 0; n < 4; n++) {
            odd_add(v, GL_VIEWPORT, 4 * (int)i + n, at[n]);
            odd_add(v, GL_SCISSOR_BOX, 4 * (int)i + n, box[n]);
            odd_add(v, GL_DEPTH_RANGE, 4 * (int)i + n, depth[n % 2]);
        }
    }
}

// Everything. The units are walked through, and the active one set again.
static inline void odd_read(const GladGLContext *gl, struct odd_values *v)
{
    const int version = odd_version(gl);
    GLint active = 0, value = 0;
    v->count = 0;
    for (size_t i = 0; i < WEFT_COUNT(odd_switches); i++)
        odd_add(v, odd_switches[i], 0, gl->IsEnabled(odd_switches[i]));
    for (size_t i = 0; i < WEFT_COUNT(odd_names); i++) {
        GLdouble values[4] = {0};
        if (version < odd_names[i].since)
            continue;
        gl->GetDoublev(odd_names[i].name, values);
        for (int n = 0; n < odd_names[i].values; n++)
            odd_add(v, odd_names[i].name, n, values[n]);
    }
    for (size_t i = 0; !odd_is_core(gl) && i < WEFT_COUNT(odd_old); i++) {
        GLdouble values[4] = {0};
        gl->GetDoublev(odd_old[i], values);
        odd_add(v, odd_old[i], 0, values[0]);
    }
    for (size_t i = 0; !odd_is_core(gl) && i < WEFT_COUNT(odd_old_switches); i++)
        odd_add(v, odd_old_switches[i], 0, gl->IsEnabled(odd_old_switches[i]));
    odd_read_indexed(gl, version, v);
    odd_read_viewports(gl, version, v);
    gl->GetIntegerv(GL_ACTIVE_TEXTURE, &active);
    for (int unit = 0; unit < ODD_UNITS; unit++) {
        gl->ActiveTexture(GL_TEXTURE0 + (GLenum)unit);
        for (size_t n = 0; n < WEFT_COUNT(odd_textures); n++) {
            gl->GetIntegerv(odd_textures[n], &value);
            odd_add(v, odd_textures[n], unit, value);
        }
    }
    gl->ActiveTexture((GLenum)active);
    assert_int_equal(gl->GetError(), GL_NO_ERROR);
}

static inline void odd_compare(const struct odd_values *before, const struct odd_values *after,
                               const char *what)
{
    assert_int_equal(before->count, after->count);
    for (int i = 0; i < before->count; i++)
        if (before->value[i] != after->value[i])
            fail_msg("%s: state 0x%04x [%d] is %g instead of %g", what, before->name[i],
                     before->index[i], after->value[i], before->value[i]);
}

// ---- odd state ----------------------------------------------------------------------------------

static inline GLuint odd_buffer(const GladGLContext *gl, GLenum target)
{
    GLuint buffer = 0;
    gl->GenBuffers(1, &buffer);
    gl->BindBuffer(target, buffer);
    gl->BufferData(target, 4096, NULL, GL_STATIC_DRAW);
    return buffer;
}

static inline GLuint odd_texture(const GladGLContext *gl, GLenum target)
{
    GLuint texture = 0;
    gl->GenTextures(1, &texture);
    gl->BindTexture(target, texture);
    return texture;
}

static inline void odd_bindings(const GladGLContext *gl, int version)
{
    static const GLenum targets[] = {GL_TEXTURE_2D,
                                     GL_TEXTURE_3D,
                                     GL_TEXTURE_2D_ARRAY,
                                     GL_TEXTURE_BUFFER,
                                     GL_TEXTURE_2D_MULTISAMPLE,
                                     GL_TEXTURE_2D_MULTISAMPLE_ARRAY,
                                     GL_TEXTURE_CUBE_MAP};
    static const GLenum buffers[] = {GL_ARRAY_BUFFER,        GL_TEXTURE_BUFFER,
                                     GL_COPY_READ_BUFFER,    GL_COPY_WRITE_BUFFER,
                                     GL_PIXEL_UNPACK_BUFFER, GL_PIXEL_PACK_BUFFER};
    GLuint vertex_array, framebuffers[2], renderbuffer, samplers[ODD_UNITS];
    gl->GenVertexArrays(1, &vertex_array);
    gl->BindVertexArray(vertex_array);
    odd_buffer(gl, GL_ELEMENT_ARRAY_BUFFER);
    for (GLuint i = 0; i < 36; i += 5)
        gl->BindBufferRange(GL_UNIFORM_BUFFER, i, odd_buffer(gl, GL_UNIFORM_BUFFER), 256, 512);
    gl->BindBufferBase(GL_UNIFORM_BUFFER, 34, odd_buffer(gl, GL_UNIFORM_BUFFER));
    odd_buffer(gl, GL_UNIFORM_BUFFER);
    gl->GenSamplers(ODD_UNITS, samplers);
    for (GLuint unit = 0; unit < ODD_UNITS; unit++) {
        gl->ActiveTexture(GL_TEXTURE0 + unit);
        for (size_t t = 0; t < WEFT_COUNT(targets); t++)
            odd_texture(gl, targets[t]);
        gl->SamplerParameteri(samplers[unit], GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        gl->BindSampler(unit, samplers[unit]);
    }
    for (GLuint i = 0; version >= 42 && i < 8; i++) {
        const GLuint texture = odd_texture(gl, GL_TEXTURE_2D);
        gl->TexStorage2D(GL_TEXTURE_2D, 2, GL_RGBA8, 4, 4);
        gl->BindImageTexture(i, texture, 1, GL_FALSE, 0, GL_READ_ONLY, GL_RGBA8);
    }
    for (size_t i = 0; i < WEFT_COUNT(buffers); i++)
        odd_buffer(gl, buffers[i]);
    gl->ActiveTexture(GL_TEXTURE7);
    gl->GenFramebuffers(2, framebuffers);
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffers[0]);
    gl->BindFramebuffer(GL_READ_FRAMEBUFFER, framebuffers[1]);
    gl->GenRenderbuffers(1, &renderbuffer);
    gl->BindRenderbuffer(GL_RENDERBUFFER, renderbuffer);
}

static inline void odd_program(const GladGLContext *gl)
{
    static const char *const vertex = "#version 330\nvoid main() { gl_Position = vec4(0.0); }\n";
    const GLuint shader = gl->CreateShader(GL_VERTEX_SHADER), program = gl->CreateProgram();
    GLint linked = 0;
    gl->ShaderSource(shader, 1, &vertex, NULL);
    gl->CompileShader(shader);
    gl->AttachShader(program, shader);
    gl->LinkProgram(program);
    gl->GetProgramiv(program, GL_LINK_STATUS, &linked);
    assert_true(linked);
    gl->UseProgram(program);
}

static inline void odd_fragments(const GladGLContext *gl, int version)
{
    for (GLuint i = 0; i < 8; i++) {
        (i % 2 ? gl->Enablei : gl->Disablei)(GL_BLEND, i);
        gl->ColorMaski(i, i % 2, GL_TRUE, i % 3 == 0, GL_FALSE);
        if (version < 40)
            continue;
        gl->BlendFuncSeparatei(i, GL_DST_COLOR, GL_SRC_ALPHA + i % 4, GL_ZERO, GL_ONE);
        gl->BlendEquationSeparatei(i, GL_MAX, i % 2 ? GL_MIN : GL_FUNC_SUBTRACT);
    }
    if (version < 40) {
        gl->BlendFuncSeparate(GL_DST_COLOR, GL_SRC_ALPHA, GL_ZERO, GL_ONE);
        gl->BlendEquationSeparate(GL_MAX, GL_MIN);
    }
    gl->BlendColor(0.25f, 0.5f, 0.75f, 0.125f);
    gl->DepthMask(GL_FALSE);
    gl->DepthFunc(GL_GREATER);
    gl->StencilFuncSeparate(GL_FRONT, GL_EQUAL, 3, 0x0f);
    gl->StencilFuncSeparate(GL_BACK, GL_NEVER, 5, 0x3c);
    gl->StencilOpSeparate(GL_FRONT, GL_INCR, GL_DECR, GL_INVERT);
    gl->StencilOpSeparate(GL_BACK, GL_ZERO, GL_REPLACE, GL_INCR_WRAP);
    gl->StencilMaskSeparate(GL_FRONT, 0x55);
    gl->StencilMaskSeparate(GL_BACK, 0xaa);
    gl->ClearColor(0.1f, 0.2f, 0.3f, 0.4f);
    gl->ClearDepth(0.25);
    gl->ClearStencil(9);
    gl->SampleMaski(0, 0x2);
    gl->SampleCoverage(0.25f, GL_TRUE);
    if (version >= 40)
        gl->MinSampleShading(0.75f);
}

static inline void odd_rasterizing(const GladGLContext *gl, int version)
{
    gl->CullFace(GL_FRONT_AND_BACK);
    gl->FrontFace(GL_CW);
    gl->LogicOp(GL_XOR);
    gl->PolygonMode(GL_FRONT_AND_BACK, GL_LINE);
    gl->PolygonOffset(2.0f, 3.0f);
    gl->PointSize(5.0f);
    gl->LineWidth(1.0f);
    gl->ClampColor(GL_CLAMP_READ_COLOR, GL_TRUE);
    gl->PrimitiveRestartIndex(2);
    gl->ProvokingVertex(GL_FIRST_VERTEX_CONVENTION);
    gl->Viewport(1, 2, 3, 4);
    gl->DepthRange(0.75, 0.25);
    gl->Scissor(1, 1, 1, 1);
    if (version >= 41) {
        gl->ViewportIndexedf(3, 0.5f, 1.5f, 7.25f, 9.5f);
        gl->DepthRangeIndexed(5, 0.125, 0.5);
        gl->ScissorIndexed(2, 4, 3, 2, 1);
    }
    if (version >= 45)
        gl->ClipControl(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
}

static inline void odd_pixel_store(const GladGLContext *gl)
{
    static const GLenum names[] = {
        GL_PACK_SWAP_BYTES,  GL_PACK_LSB_FIRST,     GL_PACK_ROW_LENGTH,     GL_PACK_IMAGE_HEIGHT,
        GL_PACK_SKIP_PIXELS, GL_PACK_SKIP_ROWS,     GL_PACK_SKIP_IMAGES,    GL_UNPACK_SWAP_BYTES,
        GL_UNPACK_LSB_FIRST, GL_UNPACK_ROW_LENGTH,  GL_UNPACK_IMAGE_HEIGHT, GL_UNPACK_SKIP_PIXELS,
        GL_UNPACK_SKIP_ROWS, GL_UNPACK_SKIP_IMAGES,
    };
    for (size_t i = 0; i < WEFT_COUNT(names); i++)
        gl->PixelStorei(names[i], 1);
    gl->PixelStorei(GL_PACK_ALIGNMENT, 8);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 2);
}

// Nothing is as GL begins, of what passes depend on. `transfer`: glPixelTransferf, NULL: a core
// profile.
static inline void odd_set(const GladGLContext *gl, void (*transfer)(GLenum name, GLfloat value))
{
    const int version = odd_version(gl);
    odd_program(gl);
    odd_bindings(gl, version);
    for (size_t i = 0; i < WEFT_COUNT(odd_switches); i++)
        if (odd_switches[i] != GL_DITHER && odd_switches[i] != GL_MULTISAMPLE)
            gl->Enable(odd_switches[i]);
    gl->Disable(GL_DITHER);
    gl->Disable(GL_MULTISAMPLE);
    if (version >= 40)
        gl->Enable(GL_SAMPLE_SHADING);
    if (version >= 41)
        gl->Disablei(GL_SCISSOR_TEST, 1);
    odd_fragments(gl, version);
    odd_rasterizing(gl, version);
    odd_pixel_store(gl);
    if (transfer) {
        for (size_t i = 0; i < WEFT_COUNT(odd_old_switches); i++)
            (odd_old_switches[i] == 0x8861 ? gl->Disable : gl->Enable)(odd_old_switches[i]);
        gl->ClampColor(0x891A, GL_TRUE);
        gl->ClampColor(0x891B, GL_TRUE);
        gl->PolygonMode(GL_FRONT, GL_POINT);
        for (size_t i = 2; i < WEFT_COUNT(odd_old); i++)
            transfer(odd_old[i], i == 2 ? 1.0f : 0.25f * (float)i);
    }
    assert_int_equal(gl->GetError(), GL_NO_ERROR);
}

#endif
