// SPDX-License-Identifier: BSD-3-Clause
#include "passes/antialias/multisample.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "passes/antialias/drawing/run.h"
#include "passes/gl/program.h"
#include "passes/gl/target.h"
#include "passes/jitter/discrepancy.h"

const char *const weft_msaa_resolve_names[] = {"blit", "sum", NULL};

struct weft_msaa {
    struct weft_msaa_params params;
    int samples; // that GL has
    // What is drawn to: a texture of so many samples, or a target of one.
    GLuint framebuffer, texture;
    struct weft_gl_target single;
    struct weft_depth_buffer depth;
    struct weft_gl_target resolved; // none of a blit of one sample
    GLuint program;                 // of sums
    double scale, discrepancy;
    GLfloat background[4]; // as the format keeps it
    uint64_t bytes;
    bool has_picture;
    struct weft_rectangle part; // that was drawn last
    float *picture;             // of it; four channels a pixel
};

// ---- targets ------------------------------------------------------------------------------------

static GLenum format_of(enum weft_antialias_format format)
{
    static const GLenum formats[WEFT_ANTIALIAS_FORMAT_COUNT] = {GL_RGBA8, GL_RGBA16F, GL_RGBA32F};
    return formats[format];
}

// As of accumulative anti-aliasing: a power of two, so that multiplying by it rounds nothing, and
// sums stay below 2^30 in magnitude, far from the values with a meaning of their own.
static double find_scale(double range, int samples)
{
    return exp2(floor(log2(0x1p30 / (range * samples))));
}

static enum weft_result make_samples(weft_msaa *m)
{
    const struct weft_msaa_params *p = &m->params;
    const GladGLContext *gl = &p->context->gl;
    gl->GenTextures(1, &m->texture);
    gl->BindTexture(GL_TEXTURE_2D_MULTISAMPLE, m->texture);
    gl->TexImage2DMultisample(GL_TEXTURE_2D_MULTISAMPLE, m->samples, format_of(p->format), p->width,
                              p->height, GL_TRUE);
    gl->BindTexture(GL_TEXTURE_2D_MULTISAMPLE, 0);
    gl->GenFramebuffers(1, &m->framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, m->framebuffer);
    gl->FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D_MULTISAMPLE,
                             m->texture, 0);
    return weft_gl_check(p->log, gl, "making a texture of samples");
}

static enum weft_result make_drawn(weft_msaa *m)
{
    const struct weft_msaa_params *p = &m->params;
    const GladGLContext *gl = &p->context->gl;
    enum weft_result res = weft_depth_buffer_create(p->log, gl, p->width, p->height, p->samples,
                                                    p->depth_bits, false, &m->depth);
    if (res != WEFT_OK)
        return res;
    m->samples = m->depth.samples;
    res = m->samples > 1 ? make_samples(m)
                         : weft_gl_target_create(p->log, gl, format_of(p->format), p->width,
                                                 p->height, &m->single);
    if (res != WEFT_OK)
        return res;
    const GLuint framebuffer = m->samples > 1 ? m->framebuffer : m->single.framebuffer;
    gl->BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, m->depth.attachment, GL_RENDERBUFFER,
                                m->depth.renderbuffer);
    const GLenum status = gl->CheckFramebufferStatus(GL_FRAMEBUFFER);
    res = weft_gl_check(p->log, gl, "making a target of samples");
    if (res == WEFT_OK && status != GL_FRAMEBUFFER_COMPLETE) {
        weft_error(p->log, "msaa: %d samples of %" PRId32 " x %" PRId32 " pixels: GL says 0x%04x",
                   m->samples, p->width, p->height, status);
        res = WEFT_ERR_GL;
    }
    return res;
}

static enum weft_result make_resolved(weft_msaa *m)
{
    const struct weft_msaa_params *p = &m->params;
    const bool sum = p->resolve == WEFT_MSAA_SUM;
    char defines[64];
    if (!sum && m->samples == 1)
        return WEFT_OK;
    const enum weft_result res =
        weft_gl_target_create(p->log, &p->context->gl, sum ? GL_RGBA32I : format_of(p->format),
                              p->width, p->height, &m->resolved);
    if (res != WEFT_OK || !sum)
        return res;
    m->scale = find_scale(p->range, m->samples);
    snprintf(defines, sizeof defines, "#define SAMPLES %d\n", m->samples);
    return weft_program_get(p->context, "msaa_sum", defines, weft_shader_full_target,
                            weft_shader_msaa_sum, &m->program);
}

static uint64_t count_bytes(const weft_msaa *m)
{
    const GladGLContext *gl = &m->params.context->gl;
    uint64_t bytes = m->depth.bytes;
    if (m->texture)
        bytes += weft_texture_bytes(gl, GL_TEXTURE_2D_MULTISAMPLE, m->texture);
    if (m->single.texture)
        bytes += weft_texture_bytes(gl, GL_TEXTURE_2D, m->single.texture);
    if (m->resolved.texture)
        bytes += weft_texture_bytes(gl, GL_TEXTURE_2D, m->resolved.texture);
    return bytes;
}

static enum weft_result read_positions(const GladGLContext *gl, int samples, double (*out)[2])
{
    for (int i = 0; i < samples; i++) {
        GLfloat at[2] = {0.5f, 0.5f};
        if (samples > 1)
            gl->GetMultisamplefv(GL_SAMPLE_POSITION, (GLuint)i, at);
        out[i][0] = (double)at[0] - 0.5;
        out[i][1] = 0.5 - (double)at[1];
    }
    return weft_gl_check(NULL, gl, "asking for the places of samples");
}

static enum weft_result find_discrepancy(weft_msaa *m)
{
    const struct weft_msaa_params *p = &m->params;
    double position[WEFT_PATTERN_MAX][2];
    struct weft_discrepancy found;
    enum weft_result res = read_positions(&p->context->gl, m->samples, position);
    if (res == WEFT_OK)
        res =
            weft_discrepancy_compute(weft_discrepancy_params(.points = (const double(*)[2])position,
                                                             .count = m->samples, .log = p->log),
                                     &found);
    m->discrepancy = found.value;
    return res;
}

// ---- the object ---------------------------------------------------------------------------------

static bool check(struct weft_msaa_params *p)
{
    p->samples = p->samples == 0 ? 4 : p->samples;
    p->range = p->range == 0.0 ? 1.0 : p->range;
    p->depth_bits = p->depth_bits == 0 ? 24 : p->depth_bits;
    if (p->samples < 1 || p->width < 1 || p->height < 1) {
        weft_error(p->log, "msaa: %d samples of %" PRId32 " x %" PRId32 " pixels", p->samples,
                   p->width, p->height);
        return false;
    }
    if (!(p->range >= 0x1p-60 && p->range <= 0x1p60) ||
        (p->depth_bits != 24 && p->depth_bits != 32)) {
        weft_error(p->log,
                   "msaa: colours to %g, depths of %d bits: 2^-60 to 2^60, and 24 or 32 bits",
                   p->range, p->depth_bits);
        return false;
    }
    for (int c = 0; c < 4; c++)
        if (!(fabs(p->background[c]) <= 0x1p60)) {
            weft_error(p->log, "msaa: channel %d of the background is %g", c, p->background[c]);
            return false;
        }
    for (int c = 0; c < 4; c++)
        p->range = fmax(p->range, fabs(p->background[c]));
    return true;
}

static enum weft_result make(weft_msaa *m)
{
    const struct weft_msaa_params *p = &m->params;
    enum weft_result res = weft_context_enter(p->context);
    if (res != WEFT_OK)
        return res;
    res = weft_background_kept(p->log, &p->context->gl, format_of(p->format), p->background,
                               m->background);
    if (res == WEFT_OK)
        res = make_drawn(m);
    if (res == WEFT_OK)
        res = find_discrepancy(m);
    if (res == WEFT_OK)
        res = make_resolved(m);
    if (res == WEFT_OK) {
        weft_program_hold(p->context, m->program);
        m->bytes = count_bytes(m);
    }
    p->context->gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    weft_context_leave(p->context);
    return res;
}

enum weft_result weft_msaa_create(const struct weft_msaa_params *params, weft_msaa **out)
{
    const struct weft_log *log = params ? params->log : NULL;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_msaa *m = NULL;
    size_t pixels, bytes;
    *out = NULL;
    weft_require(log, params && params->context);
    weft_require_enum(log, params->format, WEFT_ANTIALIAS_FORMAT_COUNT - 1);
    weft_require_enum(log, params->resolve, WEFT_MSAA_RESOLVE_COUNT - 1);
    struct weft_msaa_params p = *params;
    if (!check(&p))
        goto fail;
    const int most = p.context->info.max_target_size;
    if (p.width > most || p.height > most) {
        weft_error(log, "msaa: %" PRId32 " x %" PRId32 " pixels: GL has targets to %d", p.width,
                   p.height, most);
        res = WEFT_ERR_LIMIT;
        goto fail;
    }
    res = WEFT_ERR_MEMORY;
    m = calloc(1, sizeof *m);
    if (m && weft_size_mul((size_t)p.width, (size_t)p.height, &pixels) &&
        weft_size_mul(pixels, 4 * sizeof *m->picture, &bytes))
        m->picture = malloc(bytes);
    if (!m || !m->picture) {
        weft_error(log, "msaa: no memory for %" PRId32 " x %" PRId32 " pixels", p.width, p.height);
        goto fail;
    }
    m->params = p;
    res = make(m);
    if (res != WEFT_OK)
        goto fail;
    *out = m;
    return WEFT_OK;
fail:
    weft_msaa_destroy(&m);
    return res;
}

void weft_msaa_destroy(weft_msaa **msaa)
{
    weft_msaa *m = msaa ? *msaa : NULL;
    if (!m)
        return;
    *msaa = NULL;
    weft_context *context = m->params.context;
    if (context && weft_context_enter(context) == WEFT_OK) {
        const GladGLContext *gl = &context->gl;
        weft_program_release(context, m->program);
        weft_gl_target_destroy(gl, &m->resolved);
        weft_gl_target_destroy(gl, &m->single);
        gl->DeleteFramebuffers(1, &m->framebuffer);
        gl->DeleteTextures(1, &m->texture);
        weft_depth_buffer_destroy(gl, &m->depth);
        weft_context_leave(context);
    }
    free(m->picture);
    free(m);
}

// ---- a picture ----------------------------------------------------------------------------------

static GLuint drawn_framebuffer(const weft_msaa *m)
{
    return m->samples > 1 ? m->framebuffer : m->single.framebuffer;
}

static enum weft_result draw(weft_msaa *m, const struct weft_antialias_drawing *drawing)
{
    const struct weft_msaa_params *p = &m->params;
    const GladGLContext *gl = &p->context->gl;
    const struct weft_pass_state state = {.colours = 1, .depth_func = GL_LESS, .depth_write = true};
    struct weft_antialias_pass pass = {
        .stage = WEFT_STAGE_COLOUR,
        .count = 1,
        .framebuffer = drawn_framebuffer(m),
        .width = p->width,
        .height = p->height,
        .part = m->part,
        .head = weft_head_colour(gl, m->samples > 1),
    };
    weft_drawing_place(p->width, p->height, 0, (const double[2]){0.0, 0.0}, pass.place);
    gl->BindFramebuffer(GL_FRAMEBUFFER, pass.framebuffer);
    weft_part_scissor(gl, &m->part, p->width, p->height);
    gl->ClearBufferfv(GL_COLOR, 0, m->background);
    gl->ClearBufferfv(GL_DEPTH, 0, &(GLfloat){1.0f});
    return weft_drawing_run(p->log, p->context, drawing, &pass, &state);
}

static void blit(const weft_msaa *m)
{
    const GladGLContext *gl = &m->params.context->gl;
    const struct weft_rectangle *r = &m->part;
    const GLint end[2] = {r->x + r->width, r->y + r->height};
    gl->BindFramebuffer(GL_READ_FRAMEBUFFER, m->framebuffer);
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, m->resolved.framebuffer);
    gl->BlitFramebuffer(r->x, r->y, end[0], end[1], r->x, r->y, end[0], end[1], GL_COLOR_BUFFER_BIT,
                        GL_NEAREST);
}

static void add_up(const weft_msaa *m)
{
    const struct weft_msaa_params *p = &m->params;
    const GladGLContext *gl = &p->context->gl;
    const bool several = m->samples > 1;
    const GLenum kind = several ? GL_TEXTURE_2D_MULTISAMPLE : GL_TEXTURE_2D;
    weft_gl_target_bind(gl, &m->resolved, p->width, p->height);
    weft_part_scissor(gl, &m->part, p->width, p->height);
    gl->UseProgram(m->program);
    weft_gl_bind_texture(gl, m->program, 0, "colours", kind,
                         several ? m->texture : m->single.texture);
    gl->Uniform1f(weft_gl_location(gl, m->program, "scale"), (GLfloat)m->scale);
    gl->Uniform1f(weft_gl_location(gl, m->program, "range"), (GLfloat)p->range);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    gl->Disable(GL_SCISSOR_TEST);
    gl->BindTexture(kind, 0);
}

static enum weft_result read_back(weft_msaa *m)
{
    const struct weft_msaa_params *p = &m->params;
    const struct weft_gl_target *from = m->resolved.texture ? &m->resolved : &m->single;
    const struct weft_gl_pixels pixels = {
        .x = m->part.x,
        .y = m->part.y,
        .width = m->part.width,
        .height = m->part.height,
        .type = p->resolve == WEFT_MSAA_SUM         ? GL_INT
                : p->format == WEFT_ANTIALIAS_RGBA8 ? GL_UNSIGNED_BYTE
                                                    : GL_FLOAT,
        .data = m->picture,
    };
    return weft_gl_target_read(p->log, &p->context->gl, from, &pixels);
}

// In place: codes take less room than floats, so that the last are moved first.
static void convert_codes(float *picture, size_t count)
{
    const unsigned char *codes = (const unsigned char *)picture;
    for (size_t i = count; i-- > 0;)
        picture[i] = (float)(codes[i] / 255.0);
}

// In place. *worst: the least sum of all.
static void convert_sums(float *picture, size_t count, double divisor, int32_t *worst)
{
    *worst = INT32_MAX;
    for (size_t i = 0; i < count; i++) {
        int32_t sum;
        memcpy(&sum, &picture[i], sizeof sum);
        *worst = sum < *worst ? sum : *worst;
        picture[i] = (float)(sum / divisor);
    }
}

static enum weft_result convert(weft_msaa *m)
{
    const struct weft_msaa_params *p = &m->params;
    const size_t count = 4 * weft_part_pixels(&m->part);
    int32_t worst = 0;
    if (p->resolve == WEFT_MSAA_SUM)
        convert_sums(m->picture, count, m->scale * m->samples, &worst);
    else if (p->format == WEFT_ANTIALIAS_RGBA8)
        convert_codes(m->picture, count);
    if (worst == INT32_MIN) {
        weft_error(p->log, "msaa: there are colours that are not finite");
        return WEFT_ERR_FORMAT;
    }
    if (worst == INT32_MIN + 1) {
        weft_error(p->log, "msaa: there are colours beyond the range of %g", p->range);
        return WEFT_ERR_LIMIT;
    }
    return WEFT_OK;
}

enum weft_result weft_msaa_run(weft_msaa *msaa, const struct weft_antialias_drawing *drawing)
{
    const struct weft_msaa_params *p = &msaa->params;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    msaa->has_picture = false;
    weft_require(p->log, drawing && drawing->draw);
    res = weft_rectangle_within(p->log, &drawing->part, p->width, p->height, &msaa->part);
    if (res == WEFT_OK)
        res = weft_context_enter(p->context);
    if (res != WEFT_OK)
        goto fail;
    res = draw(msaa, drawing);
    if (res == WEFT_OK && p->resolve == WEFT_MSAA_SUM)
        add_up(msaa);
    else if (res == WEFT_OK && msaa->samples > 1)
        blit(msaa);
    if (res == WEFT_OK)
        res = read_back(msaa);
    p->context->gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    weft_context_leave(p->context);
    if (res == WEFT_OK)
        res = convert(msaa);
    msaa->has_picture = res == WEFT_OK;
fail:
    return res;
}

enum weft_result weft_msaa_read(const weft_msaa *msaa, int channel, float *out, size_t stride)
{
    const struct weft_msaa_params *p = &msaa->params;
    const size_t width = (size_t)msaa->part.width;
    if (!msaa->has_picture || channel < 0 || channel > 3) {
        weft_error(p->log, "msaa: %s",
                   msaa->has_picture ? "channels are 0 to 3" : "no picture yet");
        return WEFT_ERR_ARGUMENT;
    }
    const float *in = msaa->picture + channel;
    stride = stride ? stride : width;
    for (size_t y = 0; y < (size_t)msaa->part.height; y++, out += stride)
        for (size_t x = 0; x < width; x++, in += 4)
            out[x] = *in;
    return WEFT_OK;
}

void weft_msaa_get_report(const weft_msaa *msaa, struct weft_msaa_report *out)
{
    const struct weft_msaa_params *p = &msaa->params;
    *out = (struct weft_msaa_report){
        .samples = msaa->samples,
        .discrepancy = msaa->discrepancy,
        .scale = msaa->scale,
        .formula_bytes = weft_bytes_multisample(p->width, p->height, msaa->samples,
                                                weft_antialias_format_bytes(p->format), 4),
        .bytes = msaa->bytes,
    };
}

// ---- where samples are --------------------------------------------------------------------------

int weft_msaa_positions(weft_context *context, int samples, double out[WEFT_PATTERN_MAX][2])
{
    struct weft_depth_buffer depth;
    GLuint framebuffer = 0;
    int count = 0;
    if (!context || samples < 1 || weft_context_enter(context) != WEFT_OK)
        return 0;
    const GladGLContext *gl = &context->gl;
    if (weft_depth_buffer_create(NULL, gl, 1, 1, samples, 24, false, &depth) == WEFT_OK) {
        gl->GenFramebuffers(1, &framebuffer);
        gl->BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
        gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, depth.attachment, GL_RENDERBUFFER,
                                    depth.renderbuffer);
        gl->DrawBuffer(GL_NONE);
        gl->ReadBuffer(GL_NONE);
        if (depth.samples <= WEFT_PATTERN_MAX && read_positions(gl, depth.samples, out) == WEFT_OK)
            count = depth.samples;
        gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
        gl->DeleteFramebuffers(1, &framebuffer);
        weft_depth_buffer_destroy(gl, &depth);
    }
    weft_context_leave(context);
    return count;
}
