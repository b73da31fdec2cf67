// SPDX-License-Identifier: BSD-3-Clause
#include "passes/accumulate/frame.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "passes/gl/context_backend.h"

struct weft_frame_source {
    bool has_textures, has_planes;   // of the frame that is being added
    struct weft_gl_target *textures; // of its groups: in `uploaded`, or the caller's
    struct weft_gl_target *uploaded; // what planes are loaded into, and frames are drawn into
    GLuint depth;                    // of what is drawn
    GLuint reader;                   // a framebuffer through which callers' textures are read
    void *packed;                    // one group's texels on their way to GL
    void *read;                      // texels that came back
    size_t packed_bytes, read_bytes;
    struct weft_plane plane[WEFT_FRAME_GROUP]; // in `read`
};

// ---- what is kept -------------------------------------------------------------------------------

static enum weft_result no_memory(const weft_accumulator *a)
{
    weft_error(a->params.log, "accumulate: not enough memory for a frame of %" PRId32 " x %" PRId32,
               a->params.width, a->params.height);
    return WEFT_ERR_MEMORY;
}

static enum weft_result make_source(weft_accumulator *a)
{
    struct weft_frame_source *s = a->source;
    const size_t groups = (size_t)weft_frame_groups(a);
    if (s)
        return WEFT_OK;
    s = calloc(1, sizeof *s);
    if (s) {
        s->textures = calloc(groups, sizeof *s->textures);
        s->uploaded = calloc(groups, sizeof *s->uploaded);
    }
    a->source = s;
    if (s && s->textures && s->uploaded)
        return WEFT_OK;
    weft_frame_source_destroy(a);
    return no_memory(a);
}

// Makes sure of room for the frame's pixels.
static enum weft_result fit_memory(const weft_accumulator *a, size_t texel_bytes, void **memory,
                                   size_t *bytes)
{
    size_t wanted;
    if (!weft_size_mul((size_t)a->params.width * (size_t)a->params.height, texel_bytes, &wanted))
        return no_memory(a);
    if (wanted <= *bytes)
        return WEFT_OK;
    free(*memory);
    *bytes = 0;
    *memory = malloc(wanted);
    if (!*memory)
        return no_memory(a);
    *bytes = wanted;
    return WEFT_OK;
}

static void destroy_textures(weft_accumulator *a)
{
    struct weft_frame_source *s = a->source;
    weft_context *context = a->params.context;
    if (!s->uploaded || !context || weft_context_enter(context) != WEFT_OK)
        return;
    const GladGLContext *gl = &context->gl;
    for (int g = 0; g < weft_frame_groups(a); g++)
        weft_gl_target_destroy(gl, &s->uploaded[g]);
    if (s->depth)
        gl->DeleteRenderbuffers(1, &s->depth);
    if (s->reader)
        gl->DeleteFramebuffers(1, &s->reader);
    weft_context_leave(context);
}

void weft_frame_source_destroy(weft_accumulator *a)
{
    struct weft_frame_source *s = a->source;
    if (!s)
        return;
    destroy_textures(a);
    free(s->textures);
    free(s->uploaded);
    free(s->packed);
    free(s->read);
    free(s);
    a->source = NULL;
}

// Of a pixel in GL's memory.
static size_t texel_bytes(GLenum format)
{
    return format == GL_RGBA8 ? 4 : format == GL_RGBA32F ? 16 : format ? 8 : 0;
}

uint64_t weft_frame_bytes(const weft_accumulator *a)
{
    const struct weft_frame_source *s = a->source;
    const uint64_t pixels = (uint64_t)a->params.width * (uint64_t)a->params.height;
    if (!s)
        return 0;
    uint64_t bytes = s->packed_bytes + s->read_bytes + (s->depth ? 4 * pixels : 0);
    for (int g = 0; g < weft_frame_groups(a); g++)
        bytes += texel_bytes(s->uploaded[g].format) * pixels;
    return bytes;
}

void weft_frame_begin(weft_accumulator *a)
{
    if (a->source)
        a->source->has_textures = a->source->has_planes = false;
}

// ---- rows of texels -----------------------------------------------------------------------------

static size_t step_of(const struct weft_plane *plane)
{
    return plane->step ? plane->step : 1;
}

enum weft_plane_type weft_frame_common_type(const struct weft_plane *planes, int count)
{
    bool halves = true, bytes = true, codes = true;
    for (int c = 0; c < count; c++) {
        halves = halves && planes[c].type == WEFT_PLANE_HALF;
        bytes = bytes && planes[c].type == WEFT_PLANE_UNORM8;
        codes =
            codes && (planes[c].type == WEFT_PLANE_UNORM8 || planes[c].type == WEFT_PLANE_UNORM16);
    }
    return halves  ? WEFT_PLANE_HALF
           : bytes ? WEFT_PLANE_UNORM8
           : codes ? WEFT_PLANE_UNORM16
                   : WEFT_PLANE_FLOAT;
}

static void spread_bytes(const struct weft_plane *plane, int32_t y, int32_t width, uint8_t *out)
{
    const uint8_t *row = weft_plane_line(plane, y, width);
    const size_t step = step_of(plane);
    for (size_t i = 0; i < (size_t)width; i++)
        out[i * WEFT_FRAME_GROUP] = row[i * step];
}

// Codes of 8 bits are 257 times as much in 16.
static void spread_words(const struct weft_plane *plane, int32_t y, int32_t width, uint16_t *out)
{
    const void *row = weft_plane_line(plane, y, width);
    const uint8_t *bytes = row;
    const uint16_t *words = row;
    const size_t step = step_of(plane);
    for (size_t i = 0; i < (size_t)width; i++)
        out[i * WEFT_FRAME_GROUP] =
            plane->type == WEFT_PLANE_UNORM8 ? (uint16_t)(257 * bytes[i * step]) : words[i * step];
}

void weft_frame_pack_row(const struct weft_plane *planes, int count, enum weft_plane_type type,
                         int32_t y, int32_t width, void *out)
{
    if (count < WEFT_FRAME_GROUP)
        memset(out, 0, (size_t)width * WEFT_FRAME_GROUP * weft_plane_type_size(type));
    for (int c = 0; c < count; c++) {
        if (type == WEFT_PLANE_UNORM8)
            spread_bytes(&planes[c], y, width, (uint8_t *)out + c);
        else if (type == WEFT_PLANE_FLOAT)
            weft_plane_row(&planes[c], y, width, (float *)out + c, WEFT_FRAME_GROUP);
        else
            spread_words(&planes[c], y, width, (uint16_t *)out + c);
    }
}

// ---- planes that are uploaded -------------------------------------------------------------------

static const struct upload_format {
    GLenum format, type;
} upload_formats[] = {
    [WEFT_PLANE_FLOAT] = {GL_RGBA32F, GL_FLOAT},
    [WEFT_PLANE_HALF] = {GL_RGBA16F, GL_HALF_FLOAT},
    [WEFT_PLANE_UNORM8] = {GL_RGBA8, GL_UNSIGNED_BYTE},
    [WEFT_PLANE_UNORM16] = {GL_RGBA16, GL_UNSIGNED_SHORT},
};

// Planes that lie in memory as texels do; returns the texels from row to row, 0: they do not.
static size_t interleaved_stride(const struct weft_plane *planes, int count, int32_t width)
{
    const struct weft_plane *first = planes;
    const size_t size = weft_plane_type_size(first->type);
    const size_t stride = first->stride ? first->stride : (size_t)width * first->step;
    if (count < WEFT_FRAME_GROUP || first->type == WEFT_PLANE_UINT || stride % WEFT_FRAME_GROUP ||
        stride / WEFT_FRAME_GROUP > INT32_MAX)
        return 0;
    for (int c = 0; c < count; c++) {
        const struct weft_plane *p = &planes[c];
        if (p->type != first->type || p->step != WEFT_FRAME_GROUP || p->stride != first->stride ||
            (const char *)p->values != (const char *)first->values + (size_t)c * size)
            return 0;
    }
    return stride / WEFT_FRAME_GROUP;
}

static enum weft_result pack(weft_accumulator *a, const struct weft_plane *planes, int count,
                             enum weft_plane_type type)
{
    struct weft_frame_source *s = a->source;
    const size_t texel = WEFT_FRAME_GROUP * weft_plane_type_size(type);
    const enum weft_result res = fit_memory(a, texel, &s->packed, &s->packed_bytes);
    for (int32_t y = 0; res == WEFT_OK && y < a->params.height; y++)
        weft_frame_pack_row(planes, count, type, y, a->params.width,
                            (char *)s->packed + (size_t)y * (size_t)a->params.width * texel);
    return res;
}

static enum weft_result upload_group(weft_accumulator *a, const struct weft_plane *planes, int g)
{
    const struct weft_accumulator_params *p = &a->params;
    const GladGLContext *gl = &p->context->gl;
    struct weft_frame_source *s = a->source;
    const int first = g * WEFT_FRAME_GROUP, rest = p->channel_count - first;
    const int count = rest < WEFT_FRAME_GROUP ? rest : WEFT_FRAME_GROUP;
    const enum weft_plane_type type = weft_frame_common_type(planes + first, count);
    const size_t stride = interleaved_stride(planes + first, count, p->width);
    enum weft_result res = WEFT_OK;
    if (stride == 0)
        res = pack(a, planes + first, count, type);
    if (res == WEFT_OK)
        res = weft_gl_target_fit(p->log, gl, upload_formats[type].format, p->width, p->height,
                                 &s->uploaded[g]);
    if (res != WEFT_OK)
        return res;
    gl->BindTexture(GL_TEXTURE_2D, s->uploaded[g].texture);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    gl->PixelStorei(GL_UNPACK_ROW_LENGTH, (GLint)stride);
    gl->TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, p->width, p->height, GL_RGBA,
                      upload_formats[type].type, stride ? planes[first].values : s->packed);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 4);
    gl->PixelStorei(GL_UNPACK_ROW_LENGTH, 0);
    s->textures[g] = s->uploaded[g];
    return weft_gl_check(p->log, gl, "uploading a frame");
}

// ---- frames that are drawn, and callers' textures -----------------------------------------------

static enum weft_result attach_depth(weft_accumulator *a, const struct weft_gl_target *target)
{
    const GladGLContext *gl = &a->params.context->gl;
    struct weft_frame_source *s = a->source;
    if (!s->depth) {
        gl->GenRenderbuffers(1, &s->depth);
        gl->BindRenderbuffer(GL_RENDERBUFFER, s->depth);
        gl->RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, a->params.width,
                                a->params.height);
    }
    weft_gl_target_bind(gl, target, a->params.width, a->params.height);
    gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, s->depth);
    const GLenum status = gl->CheckFramebufferStatus(GL_FRAMEBUFFER);
    if (status == GL_FRAMEBUFFER_COMPLETE)
        return weft_gl_check(a->params.log, gl, "making a depth buffer");
    weft_error(a->params.log, "GL: a depth buffer of %" PRId32 " x %" PRId32 " cannot be had",
               a->params.width, a->params.height);
    return WEFT_ERR_GL;
}

static enum weft_result call_back(weft_accumulator *a, const struct weft_frame *frame,
                                  const struct weft_gl_target *target)
{
    const struct weft_log *log = a->params.log;
    const GladGLContext *gl = &a->params.context->gl;
    const struct weft_draw_target draw_target = {target->framebuffer, a->params.width,
                                                 a->params.height};
    GLint vertex_array = 0;
    gl->GetIntegerv(GL_VERTEX_ARRAY_BINDING, &vertex_array);
    gl->ClearColor(0.0f, 0.0f, 0.0f, 0.0f);
    gl->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    const enum weft_result res = frame->draw(frame->priv, a->frames, &draw_target);
    if (res != WEFT_OK)
        weft_error(log, "accumulate: frame %" PRId64 " was not drawn: %s", a->frames,
                   weft_result_text(res));
    const enum weft_result fault = weft_gl_check(log, gl, "a frame was drawn");
    weft_gl_reset_state(gl, (GLuint)vertex_array);
    return res == WEFT_OK ? fault : res;
}

static enum weft_result draw(weft_accumulator *a, const struct weft_frame *frame,
                             const struct weft_gl_target *target)
{
    const GladGLContext *gl = &a->params.context->gl;
    enum weft_result res = attach_depth(a, target);
    if (res == WEFT_OK)
        res = call_back(a, frame, target);
    // What is the framebuffer's own state.
    gl->BindFramebuffer(GL_FRAMEBUFFER, target->framebuffer);
    gl->DrawBuffer(GL_COLOR_ATTACHMENT0);
    gl->ReadBuffer(GL_COLOR_ATTACHMENT0);
    return res;
}

// Looks at a texture that is bound; *why: what is wrong with it.
static enum weft_result look_at(const weft_accumulator *a, struct weft_gl_target *out)
{
    static const GLenum formats[] = {GL_R8,   GL_RGBA8,   GL_R16,  GL_RGBA16,
                                     GL_R16F, GL_RGBA16F, GL_R32F, GL_RGBA32F};
    const GladGLContext *gl = &a->params.context->gl;
    GLint format = 0, width = 0, height = 0;
    size_t i = 0;
    gl->GetTexLevelParameteriv(GL_TEXTURE_2D, 0, GL_TEXTURE_INTERNAL_FORMAT, &format);
    gl->GetTexLevelParameteriv(GL_TEXTURE_2D, 0, GL_TEXTURE_WIDTH, &width);
    gl->GetTexLevelParameteriv(GL_TEXTURE_2D, 0, GL_TEXTURE_HEIGHT, &height);
    while (i < WEFT_COUNT(formats) && formats[i] != (GLenum)format)
        i++;
    *out = (struct weft_gl_target){
        .texture = out->texture, .format = (GLenum)format, .width = width, .height = height};
    if (width != a->params.width || height != a->params.height) {
        weft_error(a->params.log,
                   "accumulate: frame %" PRId64 "'s texture has %d x %d texels, not %" PRId32
                   " x %" PRId32,
                   a->frames, width, height, a->params.width, a->params.height);
        return WEFT_ERR_ARGUMENT;
    }
    if (i < WEFT_COUNT(formats) && (i % 2 == 1 || a->params.channel_count == 1))
        return WEFT_OK;
    weft_error(a->params.log,
               "accumulate: frame %" PRId64 "'s texture has the format 0x%04x: %d channel%s need "
               "%sGL_RGBA with 8, 16, 16F or 32F",
               a->frames, (unsigned)format, a->params.channel_count,
               a->params.channel_count > 1 ? "s" : "",
               a->params.channel_count > 1 ? "" : "GL_R or ");
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result borrow_texture(weft_accumulator *a, const struct weft_frame *frame)
{
    const GladGLContext *gl = &a->params.context->gl;
    struct weft_gl_target texture = {.texture = frame->texture};
    if (!gl->IsTexture(frame->texture)) {
        weft_error(a->params.log, "accumulate: frame %" PRId64 ": %u is no texture", a->frames,
                   frame->texture);
        return WEFT_ERR_ARGUMENT;
    }
    gl->BindTexture(GL_TEXTURE_2D, frame->texture);
    if (gl->GetError() != GL_NO_ERROR) {
        weft_error(a->params.log, "accumulate: frame %" PRId64 ": texture %u is not a 2D one",
                   a->frames, frame->texture);
        return WEFT_ERR_ARGUMENT;
    }
    const enum weft_result res = look_at(a, &texture);
    gl->BindTexture(GL_TEXTURE_2D, 0);
    if (res == WEFT_OK)
        a->source->textures[0] = texture;
    return res;
}

static enum weft_result make_textures(weft_accumulator *a, const struct weft_frame *frame)
{
    const struct weft_accumulator_params *p = &a->params;
    struct weft_frame_source *s = a->source;
    enum weft_result res = WEFT_OK;
    if (s->has_textures)
        return WEFT_OK;
    if (frame->plane) {
        for (int g = 0; res == WEFT_OK && g < weft_frame_groups(a); g++)
            res = upload_group(a, frame->plane, g);
    } else if (frame->texture) {
        res = borrow_texture(a, frame);
    } else {
        res = weft_gl_target_fit(p->log, &p->context->gl, weft_frame_format(p->frame_bits),
                                 p->width, p->height, &s->uploaded[0]);
        if (res == WEFT_OK)
            res = draw(a, frame, &s->uploaded[0]);
        s->textures[0] = s->uploaded[0];
    }
    s->has_textures = res == WEFT_OK;
    return res;
}

enum weft_result weft_frame_textures(weft_accumulator *a, const struct weft_frame *frame,
                                     const struct weft_gl_target **out)
{
    enum weft_result res = make_source(a);
    *out = NULL;
    if (res == WEFT_OK)
        res = make_textures(a, frame);
    if (res == WEFT_OK)
        *out = a->source->textures;
    return res;
}

void weft_frame_swap(weft_accumulator *a, int group, struct weft_gl_target *target)
{
    struct weft_gl_target *uploaded = &a->source->uploaded[group];
    const struct weft_gl_target old = *target;
    *target = *uploaded;
    *uploaded = old;
    a->source->textures[group] = *target;
}

// ---- reading back -------------------------------------------------------------------------------

static enum weft_plane_type type_of(GLenum format)
{
    switch (format) {
    case GL_R8:
    case GL_RGBA8:
        return WEFT_PLANE_UNORM8;
    case GL_R16:
    case GL_RGBA16:
        return WEFT_PLANE_UNORM16;
    case GL_R16F:
    case GL_RGBA16F:
        return WEFT_PLANE_HALF;
    default:
        return WEFT_PLANE_FLOAT;
    }
}

static bool has_four_channels(GLenum format)
{
    return format == GL_RGBA8 || format == GL_RGBA16 || format == GL_RGBA16F ||
           format == GL_RGBA32F;
}

// A caller's texture gets a framebuffer, which lets go of it again.
static enum weft_result read_target(weft_accumulator *a, struct weft_gl_target target,
                                    const struct weft_gl_pixels *pixels)
{
    const GladGLContext *gl = &a->params.context->gl;
    struct weft_frame_source *s = a->source;
    const bool borrowed = target.framebuffer == 0;
    if (borrowed) {
        if (!s->reader)
            gl->GenFramebuffers(1, &s->reader);
        gl->BindFramebuffer(GL_FRAMEBUFFER, s->reader);
        gl->FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D,
                                 target.texture, 0);
        target.framebuffer = s->reader;
    }
    const enum weft_result res = weft_gl_target_read(a->params.log, gl, &target, pixels);
    if (borrowed)
        gl->FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, 0, 0);
    return res;
}

// The frame's texture, in memory.
static enum weft_result read_back(weft_accumulator *a)
{
    struct weft_frame_source *s = a->source;
    const struct weft_gl_target *texture = &s->textures[0];
    const enum weft_plane_type type = type_of(texture->format);
    const size_t channels = has_four_channels(texture->format) ? WEFT_FRAME_GROUP : 1,
                 size = weft_plane_type_size(type);
    enum weft_result res = fit_memory(a, channels * size, &s->read, &s->read_bytes);
    if (res == WEFT_OK)
        res = read_target(a, *texture,
                          &(struct weft_gl_pixels){.width = a->params.width,
                                                   .height = a->params.height,
                                                   .type = upload_formats[type].type,
                                                   .data = s->read});
    for (size_t c = 0; c < channels; c++)
        s->plane[c] = (struct weft_plane){.values = (char *)s->read + c * size,
                                          .type = type,
                                          .stride = (size_t)a->params.width * channels,
                                          .step = channels};
    s->has_planes = res == WEFT_OK;
    return res;
}

enum weft_result weft_frame_planes(weft_accumulator *a, const struct weft_frame *frame,
                                   const struct weft_plane **out)
{
    weft_context *context = a->params.context;
    enum weft_result res = WEFT_OK;
    *out = frame->plane;
    if (*out)
        return WEFT_OK;
    res = make_source(a);
    if (res == WEFT_OK && !a->source->has_planes) {
        res = weft_context_enter(context);
        if (res != WEFT_OK)
            return res;
        res = make_textures(a, frame);
        if (res == WEFT_OK)
            res = read_back(a);
        weft_context_leave(context);
    }
    if (res == WEFT_OK)
        *out = a->source->plane;
    return res;
}

enum weft_result weft_frame_draw(weft_accumulator *a, const struct weft_frame *frame,
                                 const struct weft_gl_target *target)
{
    const enum weft_result res = make_source(a);
    return res == WEFT_OK ? draw(a, frame, target) : res;
}
