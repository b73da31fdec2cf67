// SPDX-License-Identifier: BSD-3-Clause
#include "passes/gl/native/state.h"

#include <stdio.h>
#include <stdlib.h>

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

// ---- what there is ------------------------------------------------------------------------------

// The GL version, as 10 * major + minor, that has it.
static const struct {
    GLenum name;
    int since;
} switches[] = {
    {GL_DEPTH_TEST, 33},
    {GL_STENCIL_TEST, 33},
    {GL_CULL_FACE, 33},
    {GL_COLOR_LOGIC_OP, 33},
    {GL_DEPTH_CLAMP, 33},
    {GL_POLYGON_OFFSET_FILL, 33},
    {GL_POLYGON_OFFSET_LINE, 33},
    {GL_POLYGON_OFFSET_POINT, 33},
    {GL_POLYGON_SMOOTH, 33},
    {GL_LINE_SMOOTH, 33},
    {GL_SAMPLE_ALPHA_TO_COVERAGE, 33},
    {GL_SAMPLE_ALPHA_TO_ONE, 33},
    {GL_SAMPLE_COVERAGE, 33},
    {GL_SAMPLE_MASK, 33},
    {GL_SAMPLE_SHADING, 40},
    {GL_PRIMITIVE_RESTART, 33},
    {GL_RASTERIZER_DISCARD, 33},
    {GL_FRAMEBUFFER_SRGB, 33},
    {GL_PROGRAM_POINT_SIZE, 33},
    {GL_DITHER, 33},
    {GL_MULTISAMPLE, 33},
    {GL_CLIP_DISTANCE0, 33},
    {GL_CLIP_DISTANCE1, 33},
    {GL_CLIP_DISTANCE2, 33},
    {GL_CLIP_DISTANCE3, 33},
    {GL_CLIP_DISTANCE4, 33},
    {GL_CLIP_DISTANCE5, 33},
    {GL_CLIP_DISTANCE6, 33},
    {GL_CLIP_DISTANCE7, 33},
};

static const GLenum pixel_store[] = {
    GL_PACK_SWAP_BYTES,    GL_PACK_LSB_FIRST,   GL_PACK_ROW_LENGTH,    GL_PACK_IMAGE_HEIGHT,
    GL_PACK_SKIP_PIXELS,   GL_PACK_SKIP_ROWS,   GL_PACK_SKIP_IMAGES,   GL_PACK_ALIGNMENT,
    GL_UNPACK_SWAP_BYTES,  GL_UNPACK_LSB_FIRST, GL_UNPACK_ROW_LENGTH,  GL_UNPACK_IMAGE_HEIGHT,
    GL_UNPACK_SKIP_PIXELS, GL_UNPACK_SKIP_ROWS, GL_UNPACK_SKIP_IMAGES, GL_UNPACK_ALIGNMENT,
};

static const struct {
    GLenum target, binding;
} buffers[] =
    {
        {GL_ARRAY_BUFFER, GL_ARRAY_BUFFER_BINDING},
        {GL_TEXTURE_BUFFER, GL_TEXTURE_BUFFER_BINDING},
        {GL_COPY_READ_BUFFER, GL_COPY_READ_BUFFER_BINDING},
        {GL_COPY_WRITE_BUFFER, GL_COPY_WRITE_BUFFER_BINDING},
        {GL_PIXEL_PACK_BUFFER, GL_PIXEL_PACK_BUFFER_BINDING},
        {GL_PIXEL_UNPACK_BUFFER, GL_PIXEL_UNPACK_BUFFER_BINDING},
        {GL_UNIFORM_BUFFER, GL_UNIFORM_BUFFER_BINDING}, // last: indexed bindings change it
},
  textures[] = {
      {GL_TEXTURE_2D, GL_TEXTURE_BINDING_2D},
      {GL_TEXTURE_3D, GL_TEXTURE_BINDING_3D},
      {GL_TEXTURE_2D_ARRAY, GL_TEXTURE_BINDING_2D_ARRAY},
      {GL_TEXTURE_BUFFER, GL_TEXTURE_BINDING_BUFFER},
      {GL_TEXTURE_2D_MULTISAMPLE, GL_TEXTURE_BINDING_2D_MULTISAMPLE},
      {GL_TEXTURE_2D_MULTISAMPLE_ARRAY, GL_TEXTURE_BINDING_2D_MULTISAMPLE_ARRAY},
};

enum { DRAW_BUFFERS = 8, VIEWPORTS = 16 };

struct blending {
    GLboolean on, mask[4];
    GLint source[2], factor[2], equation[2]; // of colours and of alpha
};

struct rasterizing {
    GLint cull, front, logic, polygon[2], clamp_read;
    GLfloat offset[2], point, line;
    GLint clip_origin, clip_depth, provoking;
    GLint sample_mask;
    GLfloat sample_shading;
    GLfloat clear[4], clear_depth;
    GLint clear_stencil;
};

struct viewports {
    GLfloat at[VIEWPORTS][4];
    GLdouble depth[VIEWPORTS][2];
    GLint scissor[VIEWPORTS][4];
    GLboolean scissors[VIEWPORTS];
};

struct stencil_side {
    GLint func, ref, read, fail, depth_fail, pass, write;
};

struct unit {
    GLint texture[COUNT(textures)], sampler;
};

struct uniforms {
    GLint buffer;
    GLint64 start, size;
};

struct image {
    GLint texture, level, layered, layer, access, format;
};

// What only compatibility profiles have; its names are not in the header.
enum {
    ALPHA_TEST = 0x0BC0,
    POINT_SMOOTH = 0x0B10,
    LINE_STIPPLE = 0x0B24,
    POLYGON_STIPPLE = 0x0B42,
    POINT_SPRITE = 0x8861,
    CLAMP_VERTEX_COLOR = 0x891A,
    CLAMP_FRAGMENT_COLOR = 0x891B,
    MAP_COLOR = 0x0D10,
    RED_SCALE = 0x0D14,
    RED_BIAS,
    GREEN_SCALE = 0x0D18,
    GREEN_BIAS,
    BLUE_SCALE,
    BLUE_BIAS,
    ALPHA_SCALE,
    ALPHA_BIAS,
};
static const struct {
    GLenum name;
    float usual;
} transfers[] = {
    {MAP_COLOR, 0.0f},   {RED_SCALE, 1.0f},   {RED_BIAS, 0.0f},
    {GREEN_SCALE, 1.0f}, {GREEN_BIAS, 0.0f},  {BLUE_SCALE, 1.0f},
    {BLUE_BIAS, 0.0f},   {ALPHA_SCALE, 1.0f}, {ALPHA_BIAS, 0.0f},
};
static const struct {
    GLenum name;
    bool usual; // as core profiles have it
} old_switches[] = {
    {ALPHA_TEST, false},      {POINT_SMOOTH, false}, {LINE_STIPPLE, false},
    {POLYGON_STIPPLE, false}, {POINT_SPRITE, true},
};
static const GLenum old_clamps[] = {CLAMP_VERTEX_COLOR, CLAMP_FRAGMENT_COLOR};

typedef void(GLAD_API_PTR *pixel_transfer_function)(GLenum name, GLfloat value);

struct compatibility {
    pixel_transfer_function pixel_transfer; // NULL: a core profile
    GLboolean on[COUNT(old_switches)];
    GLint clamp[COUNT(old_clamps)];
    GLfloat transfer[COUNT(transfers)];
};

struct weft_gl_state {
    int version; // 10 * major + minor
    GLint draw_buffers, viewport_count, image_count, unit_count;
    GLboolean on[COUNT(switches)];
    struct blending blending[DRAW_BUFFERS];
    GLfloat blend_color[4];
    GLboolean depth_mask;
    GLint depth_func;
    struct stencil_side stencil[2];
    struct rasterizing rasterizing;
    struct viewports viewports;
    GLint store[COUNT(pixel_store)];
    GLint program, vertex_array, draw_framebuffer, read_framebuffer, renderbuffer, active_unit;
    GLint buffer[COUNT(buffers)];
    struct unit units[WEFT_GL_STATE_UNITS];
    struct uniforms uniforms;
    struct image images[WEFT_GL_STATE_IMAGES];
    struct compatibility old;
};

// ---- room ---------------------------------------------------------------------------------------

static GLint get(const GladGLContext *gl, GLenum name)
{
    GLint value = 0;
    gl->GetIntegerv(name, &value);
    return value;
}

static GLint at_most(GLint count, GLint most)
{
    return count < most ? count : most;
}

struct weft_gl_state *weft_gl_state_create(const GladGLContext *gl,
                                           GLADapiproc (*find)(void *priv, const char *name),
                                           void *priv)
{
    struct weft_gl_state *s = calloc(1, sizeof *s);
    if (!s)
        return NULL;
    s->version = 10 * get(gl, GL_MAJOR_VERSION) + get(gl, GL_MINOR_VERSION);
    s->draw_buffers = at_most(get(gl, GL_MAX_DRAW_BUFFERS), DRAW_BUFFERS);
    s->unit_count = at_most(get(gl, GL_MAX_COMBINED_TEXTURE_IMAGE_UNITS), WEFT_GL_STATE_UNITS);
    s->viewport_count = s->version < 41 ? 1 : at_most(get(gl, GL_MAX_VIEWPORTS), VIEWPORTS);
    s->image_count =
        s->version < 42 ? 0 : at_most(get(gl, GL_MAX_IMAGE_UNITS), WEFT_GL_STATE_IMAGES);
    if (get(gl, GL_CONTEXT_PROFILE_MASK) & GL_CONTEXT_COMPATIBILITY_PROFILE_BIT) {
        s->old.pixel_transfer = (pixel_transfer_function)find(priv, "glPixelTransferf");
        if (!s->old.pixel_transfer) {
            free(s);
            return NULL;
        }
    }
    return s;
}

bool weft_gl_state_is_free(const GladGLContext *gl, char *why, size_t why_size)
{
    static const struct {
        GLenum target;
        const char *name;
    } queries[] = {
        {GL_SAMPLES_PASSED, "GL_SAMPLES_PASSED"},
        {GL_ANY_SAMPLES_PASSED, "GL_ANY_SAMPLES_PASSED"},
        {GL_PRIMITIVES_GENERATED, "GL_PRIMITIVES_GENERATED"},
    };
    for (size_t i = 0; i < COUNT(queries); i++) {
        GLint query = 0;
        gl->GetQueryiv(queries[i].target, GL_CURRENT_QUERY, &query);
        if (query) {
            snprintf(why, why_size, "query %d of %s has begun and would count what weft draws",
                     query, queries[i].name);
            return false;
        }
    }
    if (gl->VERSION_4_0 && get(gl, GL_TRANSFORM_FEEDBACK_ACTIVE) &&
        !get(gl, GL_TRANSFORM_FEEDBACK_PAUSED)) {
        snprintf(why, why_size, "transform feedback has begun and is not paused");
        return false;
    }
    return true;
}

// ---- fragments ----------------------------------------------------------------------------------

static void save_blending(const GladGLContext *gl, struct weft_gl_state *s)
{
    static const GLenum names[] = {GL_BLEND_SRC_RGB, GL_BLEND_DST_RGB, GL_BLEND_EQUATION_RGB};
    static const GLenum alphas[] = {GL_BLEND_SRC_ALPHA, GL_BLEND_DST_ALPHA,
                                    GL_BLEND_EQUATION_ALPHA};
    for (GLint i = 0; i < s->draw_buffers; i++) {
        struct blending *b = &s->blending[i];
        GLint *const colour[] = {&b->source[0], &b->factor[0], &b->equation[0]};
        GLint *const alpha[] = {&b->source[1], &b->factor[1], &b->equation[1]};
        b->on = gl->IsEnabledi(GL_BLEND, (GLuint)i);
        gl->GetBooleani_v(GL_COLOR_WRITEMASK, (GLuint)i, b->mask);
        for (size_t n = 0; n < COUNT(names); n++) {
            if (s->version >= 40) {
                gl->GetIntegeri_v(names[n], (GLuint)i, colour[n]);
                gl->GetIntegeri_v(alphas[n], (GLuint)i, alpha[n]);
            } else {
                gl->GetIntegerv(names[n], colour[n]);
                gl->GetIntegerv(alphas[n], alpha[n]);
            }
        }
    }
    gl->GetFloatv(GL_BLEND_COLOR, s->blend_color);
}

// Equations of extensions are of all channels at once.
static void restore_blending_of(const GladGLContext *gl, const struct blending *b, bool indexed,
                                GLuint i)
{
    const GLenum source[2] = {(GLenum)b->source[0], (GLenum)b->source[1]};
    const GLenum factor[2] = {(GLenum)b->factor[0], (GLenum)b->factor[1]};
    const GLenum equation[2] = {(GLenum)b->equation[0], (GLenum)b->equation[1]};
    const bool same = equation[0] == equation[1];
    if (indexed) {
        gl->BlendFuncSeparatei(i, source[0], factor[0], source[1], factor[1]);
        if (same)
            gl->BlendEquationi(i, equation[0]);
        else
            gl->BlendEquationSeparatei(i, equation[0], equation[1]);
    } else {
        gl->BlendFuncSeparate(source[0], factor[0], source[1], factor[1]);
        if (same)
            gl->BlendEquation(equation[0]);
        else
            gl->BlendEquationSeparate(equation[0], equation[1]);
    }
}

static void restore_blending(const GladGLContext *gl, const struct weft_gl_state *s)
{
    for (GLint i = 0; i < s->draw_buffers; i++) {
        const struct blending *b = &s->blending[i];
        (b->on ? gl->Enablei : gl->Disablei)(GL_BLEND, (GLuint)i);
        gl->ColorMaski((GLuint)i, b->mask[0], b->mask[1], b->mask[2], b->mask[3]);
        restore_blending_of(gl, b, s->version >= 40, (GLuint)i);
    }
    gl->BlendColor(s->blend_color[0], s->blend_color[1], s->blend_color[2], s->blend_color[3]);
}

static const GLenum stencil_names[2][7] = {
    {GL_STENCIL_FUNC, GL_STENCIL_REF, GL_STENCIL_VALUE_MASK, GL_STENCIL_FAIL,
     GL_STENCIL_PASS_DEPTH_FAIL, GL_STENCIL_PASS_DEPTH_PASS, GL_STENCIL_WRITEMASK},
    {GL_STENCIL_BACK_FUNC, GL_STENCIL_BACK_REF, GL_STENCIL_BACK_VALUE_MASK, GL_STENCIL_BACK_FAIL,
     GL_STENCIL_BACK_PASS_DEPTH_FAIL, GL_STENCIL_BACK_PASS_DEPTH_PASS, GL_STENCIL_BACK_WRITEMASK},
};

static void save_tests(const GladGLContext *gl, struct weft_gl_state *s)
{
    gl->GetBooleanv(GL_DEPTH_WRITEMASK, &s->depth_mask);
    s->depth_func = get(gl, GL_DEPTH_FUNC);
    for (int side = 0; side < 2; side++) {
        struct stencil_side *f = &s->stencil[side];
        GLint *const to[] = {&f->func,       &f->ref,  &f->read, &f->fail,
                             &f->depth_fail, &f->pass, &f->write};
        for (size_t i = 0; i < COUNT(to); i++)
            gl->GetIntegerv(stencil_names[side][i], to[i]);
    }
}

static void restore_tests(const GladGLContext *gl, const struct weft_gl_state *s)
{
    static const GLenum sides[] = {GL_FRONT, GL_BACK};
    gl->DepthMask(s->depth_mask);
    gl->DepthFunc((GLenum)s->depth_func);
    for (int side = 0; side < 2; side++) {
        const struct stencil_side *f = &s->stencil[side];
        gl->StencilFuncSeparate(sides[side], (GLenum)f->func, f->ref, (GLuint)f->read);
        gl->StencilOpSeparate(sides[side], (GLenum)f->fail, (GLenum)f->depth_fail, (GLenum)f->pass);
        gl->StencilMaskSeparate(sides[side], (GLuint)f->write);
    }
}

// ---- rasterizing --------------------------------------------------------------------------------

static void save_rasterizing(const GladGLContext *gl, struct weft_gl_state *s)
{
    struct rasterizing *r = &s->rasterizing;
    r->cull = get(gl, GL_CULL_FACE_MODE);
    r->front = get(gl, GL_FRONT_FACE);
    r->logic = get(gl, GL_LOGIC_OP_MODE);
    gl->GetIntegerv(GL_POLYGON_MODE, r->polygon); // of core profiles one or two
    r->clamp_read = get(gl, GL_CLAMP_READ_COLOR);
    gl->GetFloatv(GL_POLYGON_OFFSET_FACTOR, &r->offset[0]);
    gl->GetFloatv(GL_POLYGON_OFFSET_UNITS, &r->offset[1]);
    gl->GetFloatv(GL_POINT_SIZE, &r->point);
    gl->GetFloatv(GL_LINE_WIDTH, &r->line);
    gl->GetFloatv(GL_COLOR_CLEAR_VALUE, r->clear);
    gl->GetFloatv(GL_DEPTH_CLEAR_VALUE, &r->clear_depth);
    r->clear_stencil = get(gl, GL_STENCIL_CLEAR_VALUE);
    r->provoking = get(gl, GL_PROVOKING_VERTEX);
    gl->GetIntegeri_v(GL_SAMPLE_MASK_VALUE, 0, &r->sample_mask);
    if (gl->MinSampleShading && s->version >= 40)
        gl->GetFloatv(GL_MIN_SAMPLE_SHADING_VALUE, &r->sample_shading);
    if (s->version >= 45) {
        r->clip_origin = get(gl, GL_CLIP_ORIGIN);
        r->clip_depth = get(gl, GL_CLIP_DEPTH_MODE);
    }
}

static void restore_polygon_mode(const GladGLContext *gl, const struct weft_gl_state *s)
{
    const GLint *mode = s->rasterizing.polygon;
    if (s->old.pixel_transfer && mode[0] != mode[1]) {
        gl->PolygonMode(GL_FRONT, (GLenum)mode[0]);
        gl->PolygonMode(GL_BACK, (GLenum)mode[1]);
    } else {
        gl->PolygonMode(GL_FRONT_AND_BACK, (GLenum)mode[0]);
    }
}

static void restore_rasterizing(const GladGLContext *gl, const struct weft_gl_state *s)
{
    const struct rasterizing *r = &s->rasterizing;
    gl->CullFace((GLenum)r->cull);
    gl->FrontFace((GLenum)r->front);
    gl->LogicOp((GLenum)r->logic);
    restore_polygon_mode(gl, s);
    gl->ClampColor(GL_CLAMP_READ_COLOR, (GLenum)r->clamp_read);
    gl->PolygonOffset(r->offset[0], r->offset[1]);
    gl->PointSize(r->point);
    gl->LineWidth(r->line);
    gl->ClearColor(r->clear[0], r->clear[1], r->clear[2], r->clear[3]);
    gl->ClearDepth((GLdouble)r->clear_depth);
    gl->ClearStencil(r->clear_stencil);
    gl->ProvokingVertex((GLenum)r->provoking);
    gl->SampleMaski(0, (GLbitfield)r->sample_mask);
    if (gl->MinSampleShading && s->version >= 40)
        gl->MinSampleShading(r->sample_shading);
    if (s->version >= 45)
        gl->ClipControl((GLenum)r->clip_origin, (GLenum)r->clip_depth);
}

static void save_viewports(const GladGLContext *gl, struct weft_gl_state *s)
{
    struct viewports *v = &s->viewports;
    if (s->version < 41) {
        gl->GetFloatv(GL_VIEWPORT, v->at[0]);
        gl->GetDoublev(GL_DEPTH_RANGE, v->depth[0]);
        gl->GetIntegerv(GL_SCISSOR_BOX, v->scissor[0]);
        v->scissors[0] = gl->IsEnabled(GL_SCISSOR_TEST);
        return;
    }
    for (GLint i = 0; i < s->viewport_count; i++) {
        gl->GetFloati_v(GL_VIEWPORT, (GLuint)i, v->at[i]);
        gl->GetDoublei_v(GL_DEPTH_RANGE, (GLuint)i, v->depth[i]);
        gl->GetIntegeri_v(GL_SCISSOR_BOX, (GLuint)i, v->scissor[i]);
        v->scissors[i] = gl->IsEnabledi(GL_SCISSOR_TEST, (GLuint)i);
    }
}

static void restore_viewports(const GladGLContext *gl, const struct weft_gl_state *s)
{
    const struct viewports *v = &s->viewports;
    if (s->version < 41) {
        const GLfloat *at = v->at[0];
        const GLint *box = v->scissor[0];
        gl->Viewport((GLint)at[0], (GLint)at[1], (GLsizei)at[2], (GLsizei)at[3]);
        gl->DepthRange(v->depth[0][0], v->depth[0][1]);
        gl->Scissor(box[0], box[1], box[2], box[3]);
        (v->scissors[0] ? gl->Enable : gl->Disable)(GL_SCISSOR_TEST);
        return;
    }
    for (GLint i = 0; i < s->viewport_count; i++) {
        gl->ViewportIndexedfv((GLuint)i, v->at[i]);
        gl->DepthRangeIndexed((GLuint)i, v->depth[i][0], v->depth[i][1]);
        gl->ScissorIndexedv((GLuint)i, v->scissor[i]);
        (v->scissors[i] ? gl->Enablei : gl->Disablei)(GL_SCISSOR_TEST, (GLuint)i);
    }
}

// ---- bindings -----------------------------------------------------------------------------------

static void save_units(const GladGLContext *gl, struct weft_gl_state *s)
{
    s->active_unit = get(gl, GL_ACTIVE_TEXTURE);
    for (GLint i = 0; i < s->unit_count; i++) {
        gl->ActiveTexture(GL_TEXTURE0 + (GLenum)i);
        s->units[i].sampler = get(gl, GL_SAMPLER_BINDING);
        for (size_t t = 0; t < COUNT(textures); t++)
            s->units[i].texture[t] = get(gl, textures[t].binding);
    }
}

static GLuint if_it_is(GLboolean(GLAD_API_PTR *is)(GLuint name), GLint name)
{
    return name && is((GLuint)name) ? (GLuint)name : 0;
}

static void restore_units(const GladGLContext *gl, const struct weft_gl_state *s)
{
    for (GLint i = 0; i < s->unit_count; i++) {
        gl->ActiveTexture(GL_TEXTURE0 + (GLenum)i);
        gl->BindSampler((GLuint)i, if_it_is(gl->IsSampler, s->units[i].sampler));
        for (size_t t = 0; t < COUNT(textures); t++)
            gl->BindTexture(textures[t].target, if_it_is(gl->IsTexture, s->units[i].texture[t]));
    }
    gl->ActiveTexture((GLenum)s->active_unit);
}

static void save_indexed(const GladGLContext *gl, struct weft_gl_state *s)
{
    struct uniforms *u = &s->uniforms;
    gl->GetIntegeri_v(GL_UNIFORM_BUFFER_BINDING, WEFT_GL_STATE_UNIFORM, &u->buffer);
    gl->GetInteger64i_v(GL_UNIFORM_BUFFER_START, WEFT_GL_STATE_UNIFORM, &u->start);
    gl->GetInteger64i_v(GL_UNIFORM_BUFFER_SIZE, WEFT_GL_STATE_UNIFORM, &u->size);
    for (GLint i = 0; i < s->image_count; i++) {
        struct image *m = &s->images[i];
        gl->GetIntegeri_v(GL_IMAGE_BINDING_NAME, (GLuint)i, &m->texture);
        gl->GetIntegeri_v(GL_IMAGE_BINDING_LEVEL, (GLuint)i, &m->level);
        gl->GetIntegeri_v(GL_IMAGE_BINDING_LAYERED, (GLuint)i, &m->layered);
        gl->GetIntegeri_v(GL_IMAGE_BINDING_LAYER, (GLuint)i, &m->layer);
        gl->GetIntegeri_v(GL_IMAGE_BINDING_ACCESS, (GLuint)i, &m->access);
        gl->GetIntegeri_v(GL_IMAGE_BINDING_FORMAT, (GLuint)i, &m->format);
    }
}

static void restore_indexed(const GladGLContext *gl, const struct weft_gl_state *s)
{
    const struct uniforms *u = &s->uniforms;
    const GLuint buffer = if_it_is(gl->IsBuffer, u->buffer);
    if (buffer && u->size > 0)
        gl->BindBufferRange(GL_UNIFORM_BUFFER, WEFT_GL_STATE_UNIFORM, buffer, (GLintptr)u->start,
                            (GLsizeiptr)u->size);
    else
        gl->BindBufferBase(GL_UNIFORM_BUFFER, WEFT_GL_STATE_UNIFORM, buffer);
    for (GLint i = 0; i < s->image_count; i++) {
        const struct image *m = &s->images[i];
        gl->BindImageTexture((GLuint)i, if_it_is(gl->IsTexture, m->texture), m->level,
                             (GLboolean)m->layered, m->layer, (GLenum)m->access, (GLenum)m->format);
    }
}

static void save_bindings(const GladGLContext *gl, struct weft_gl_state *s)
{
    s->program = get(gl, GL_CURRENT_PROGRAM);
    s->vertex_array = get(gl, GL_VERTEX_ARRAY_BINDING);
    s->draw_framebuffer = get(gl, GL_DRAW_FRAMEBUFFER_BINDING);
    s->read_framebuffer = get(gl, GL_READ_FRAMEBUFFER_BINDING);
    s->renderbuffer = get(gl, GL_RENDERBUFFER_BINDING);
    for (size_t i = 0; i < COUNT(buffers); i++)
        s->buffer[i] = get(gl, buffers[i].binding);
    save_units(gl, s);
    save_indexed(gl, s);
}

static void restore_bindings(const GladGLContext *gl, const struct weft_gl_state *s)
{
    restore_indexed(gl, s);
    restore_units(gl, s);
    for (size_t i = 0; i < COUNT(buffers); i++)
        gl->BindBuffer(buffers[i].target, if_it_is(gl->IsBuffer, s->buffer[i]));
    gl->BindRenderbuffer(GL_RENDERBUFFER, if_it_is(gl->IsRenderbuffer, s->renderbuffer));
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, if_it_is(gl->IsFramebuffer, s->draw_framebuffer));
    gl->BindFramebuffer(GL_READ_FRAMEBUFFER, if_it_is(gl->IsFramebuffer, s->read_framebuffer));
    gl->BindVertexArray(if_it_is(gl->IsVertexArray, s->vertex_array));
    gl->UseProgram(if_it_is(gl->IsProgram, s->program));
}

// ---- compatibility profiles ---------------------------------------------------------------------

static void save_old(const GladGLContext *gl, struct compatibility *old)
{
    for (size_t i = 0; i < COUNT(old_switches); i++) {
        old->on[i] = gl->IsEnabled(old_switches[i].name);
        (old_switches[i].usual ? gl->Enable : gl->Disable)(old_switches[i].name);
    }
    for (size_t i = 0; i < COUNT(old_clamps); i++) {
        gl->GetIntegerv(old_clamps[i], &old->clamp[i]);
        gl->ClampColor(old_clamps[i], GL_FALSE);
    }
    for (size_t i = 0; i < COUNT(transfers); i++) {
        gl->GetFloatv(transfers[i].name, &old->transfer[i]);
        old->pixel_transfer(transfers[i].name, transfers[i].usual);
    }
}

static void restore_old(const GladGLContext *gl, const struct compatibility *old)
{
    for (size_t i = 0; i < COUNT(old_switches); i++)
        (old->on[i] ? gl->Enable : gl->Disable)(old_switches[i].name);
    for (size_t i = 0; i < COUNT(old_clamps); i++)
        gl->ClampColor(old_clamps[i], (GLenum)old->clamp[i]);
    for (size_t i = 0; i < COUNT(transfers); i++)
        old->pixel_transfer(transfers[i].name, old->transfer[i]);
}

// ---- all of it ----------------------------------------------------------------------------------

void weft_gl_state_save(const GladGLContext *gl, struct weft_gl_state *s)
{
    for (size_t i = 0; i < COUNT(switches); i++)
        if (s->version >= switches[i].since)
            s->on[i] = gl->IsEnabled(switches[i].name);
    save_blending(gl, s);
    save_tests(gl, s);
    save_rasterizing(gl, s);
    save_viewports(gl, s);
    for (size_t i = 0; i < COUNT(pixel_store); i++)
        s->store[i] = get(gl, pixel_store[i]);
    save_bindings(gl, s);
    if (s->old.pixel_transfer)
        save_old(gl, &s->old);
}

void weft_gl_state_restore(const GladGLContext *gl, const struct weft_gl_state *s)
{
    for (size_t i = 0; i < COUNT(switches); i++)
        if (s->version >= switches[i].since)
            (s->on[i] ? gl->Enable : gl->Disable)(switches[i].name);
    restore_blending(gl, s);
    restore_tests(gl, s);
    restore_rasterizing(gl, s);
    restore_viewports(gl, s);
    for (size_t i = 0; i < COUNT(pixel_store); i++)
        gl->PixelStorei(pixel_store[i], s->store[i]);
    restore_bindings(gl, s);
    if (s->old.pixel_transfer)
        restore_old(gl, &s->old);
}
