// SPDX-License-Identifier: BSD-3-Clause
#include "passes/accumulate/blend_target.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "filter/half.h"
#include "passes/accumulate/frame.h"
#include "passes/accumulate/sums/blocks.h"
#include "passes/accumulate/sums/state.h"
#include "passes/gl/program.h"
#include "passes/gl/textures/output.h"

struct weft_blend_target {
    int bits;
    struct weft_value_range range; // whole: values are what they are
    struct weft_gl_target *gl;     // one a group
    void *emulated;                // channel after channel: uint16_t or float
    void *read;                    // texels of a group
    int read_group;                // which; -1: none
    uint64_t passes;
};

static bool has_codes(const weft_blend_target *t)
{
    return t->bits == 8 || t->bits == 16;
}

static size_t value_size(const weft_blend_target *t)
{
    return t->bits == 8 && !t->emulated ? sizeof(uint8_t)
           : has_codes(t)               ? sizeof(uint16_t)
                                        : sizeof(float);
}

static size_t pixel_count(const weft_accumulator *a)
{
    return (size_t)a->params.width * (size_t)a->params.height;
}

// ---- targets ------------------------------------------------------------------------------------

static enum weft_result create_emulated(weft_accumulator *a, weft_blend_target *t)
{
    size_t count;
    if (weft_size_mul(pixel_count(a), (size_t)a->params.channel_count, &count))
        t->emulated = calloc(count, has_codes(t) ? sizeof(uint16_t) : sizeof(float));
    return t->emulated ? WEFT_OK : WEFT_ERR_MEMORY;
}

static enum weft_result create_group(weft_accumulator *a, weft_blend_target *t, int g)
{
    const struct weft_accumulator_params *p = &a->params;
    const GladGLContext *gl = &p->context->gl;
    static const GLfloat zero[4] = {0.0f};
    const enum weft_result res = weft_gl_target_create(p->log, gl, weft_frame_format(t->bits),
                                                       p->width, p->height, &t->gl[g]);
    if (res != WEFT_OK)
        return res;
    gl->ClearBufferfv(GL_COLOR, 0, zero);
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    return weft_gl_check(p->log, gl, "clearing a target");
}

static enum weft_result create_gl(weft_accumulator *a, weft_blend_target *t)
{
    const struct weft_accumulator_params *p = &a->params;
    const int groups = weft_frame_groups(a);
    if (!p->context) {
        weft_error(p->log, "accumulate: blending needs an OpenGL context, or to be emulated");
        return WEFT_ERR_ARGUMENT;
    }
    const int most = p->context->info.max_target_size;
    if (p->width > most || p->height > most) {
        weft_error(p->log,
                   "accumulate: %" PRId32 " x %" PRId32 " pixels; targets have at most %d a side",
                   p->width, p->height, most);
        return WEFT_ERR_LIMIT;
    }
    t->gl = calloc((size_t)groups, sizeof *t->gl);
    t->read = malloc(pixel_count(a) * WEFT_FRAME_GROUP * value_size(t));
    if (!t->gl || !t->read)
        return WEFT_ERR_MEMORY;
    enum weft_result res = weft_context_enter(p->context);
    if (res != WEFT_OK)
        return res;
    for (int g = 0; g < groups && res == WEFT_OK; g++)
        res = create_group(a, t, g);
    weft_context_leave(p->context);
    return res;
}

enum weft_result weft_blend_target_create(weft_accumulator *a, int bits, weft_blend_target **out)
{
    weft_blend_target *t = calloc(1, sizeof *t);
    enum weft_result res = t ? WEFT_OK : WEFT_ERR_MEMORY;
    *out = NULL;
    if (res == WEFT_OK) {
        t->bits = bits;
        t->read_group = -1;
        t->range = weft_value_range_of(&a->params);
        t->range.whole = t->range.whole || !has_codes(t);
        res = a->params.emulate ? create_emulated(a, t) : create_gl(a, t);
    }
    if (res == WEFT_ERR_MEMORY)
        weft_error(a->params.log,
                   "accumulate: not enough memory for a target of %" PRId32 " x %" PRId32 " pixels",
                   a->params.width, a->params.height);
    if (res != WEFT_OK)
        weft_blend_target_destroy(a, &t);
    *out = t;
    return res;
}

void weft_blend_target_destroy(weft_accumulator *a, weft_blend_target **target)
{
    weft_blend_target *t = *target;
    *target = NULL;
    if (!t)
        return;
    if (t->gl && weft_context_enter(a->params.context) == WEFT_OK) {
        for (int g = 0; g < weft_frame_groups(a); g++)
            weft_gl_target_destroy(&a->params.context->gl, &t->gl[g]);
        weft_context_leave(a->params.context);
    }
    free(t->gl);
    free(t->emulated);
    free(t->read);
    free(t);
}

const struct weft_value_range *weft_blend_target_range(const weft_blend_target *t)
{
    return &t->range;
}

void weft_blend_target_report(const weft_accumulator *a, const weft_blend_target *t,
                              struct weft_accumulator_report *out)
{
    const uint64_t groups = (uint64_t)weft_frame_groups(a), pixels = pixel_count(a);
    const uint64_t texel = WEFT_FRAME_GROUP * (t->bits == 8 ? 1 : t->bits == 32 ? 4 : 2);
    if (t->gl) {
        out->textures = (int)groups;
        out->bytes += groups * pixels * texel + pixels * WEFT_FRAME_GROUP * value_size(t);
    } else {
        out->bytes += pixels * (uint64_t)a->params.channel_count * value_size(t);
    }
    out->passes = t->passes;
}

// ---- checks -------------------------------------------------------------------------------------

static bool has_floats(GLenum format)
{
    return format == GL_R16F || format == GL_RGBA16F || format == GL_R32F || format == GL_RGBA32F;
}

// Whether a frame on GL has to be looked at in memory.
static enum weft_result look_at_texture(weft_accumulator *a, const struct weft_frame *frame,
                                        bool *read)
{
    const struct weft_gl_target *textures;
    enum weft_result res = weft_context_enter(a->params.context);
    if (res != WEFT_OK)
        return res;
    res = weft_frame_textures(a, frame, &textures);
    weft_context_leave(a->params.context);
    *read = res == WEFT_OK && has_floats(textures[0].format) &&
            a->params.nonfinite != WEFT_NONFINITE_PROPAGATE;
    return res;
}

enum weft_result weft_blend_target_check(weft_accumulator *a, const weft_blend_target *t,
                                         const struct weft_frame *frame, double *largest)
{
    const struct weft_value_limits range = {a->params.low, a->params.high};
    const struct weft_value_limits halves = {-(double)WEFT_HALF_MAX, (double)WEFT_HALF_MAX};
    const struct weft_value_limits *limits = has_codes(t) ? &range : t->bits == 32 ? NULL : &halves;
    const struct weft_plane *planes = NULL;
    bool read = true;
    *largest = t->range.extent;
    if (frame->plane)
        return weft_frame_check(a, frame->plane, limits, largest);
    enum weft_result res = look_at_texture(a, frame, &read);
    if (res != WEFT_OK || !read)
        return res;
    res = weft_frame_planes(a, frame, &planes);
    return res == WEFT_OK ? weft_frame_check(a, planes, NULL, largest) : res;
}

// ---- blending on GL -----------------------------------------------------------------------------

static enum weft_result use_program(weft_accumulator *a, const weft_blend_target *t,
                                    const struct weft_blend_step *step, GLuint texture)
{
    static const char *const defines[2][2] = {
        {"#define RANGE 0\n#define WEIGHT 0\n", "#define RANGE 0\n#define WEIGHT 1\n"},
        {"#define RANGE 1\n#define WEIGHT 0\n", "#define RANGE 1\n#define WEIGHT 1\n"},
    };
    const GladGLContext *gl = &a->params.context->gl;
    GLuint program = 0;
    const enum weft_result res =
        weft_program_get(a->params.context, "blend", defines[!t->range.whole][step->weight != 1.0f],
                         weft_shader_full_target, weft_shader_blend, &program);
    if (res != WEFT_OK)
        return res;
    gl->UseProgram(program);
    weft_gl_bind_texture(gl, program, 0, "frame", GL_TEXTURE_2D, texture);
    gl->Uniform1f(weft_gl_location(gl, program, "low"), t->range.low);
    gl->Uniform1f(weft_gl_location(gl, program, "scale"), t->range.scale);
    gl->Uniform1f(weft_gl_location(gl, program, "weight"), step->weight);
    return WEFT_OK;
}

static void begin_blending(const GladGLContext *gl, const struct weft_blend_step *step)
{
    const float c = step->constant;
    gl->Disable(GL_DITHER);
    gl->Enable(GL_BLEND);
    gl->BlendColor(c, c, c, c);
    gl->BlendFunc(step->operation == WEFT_BLEND_SUM ? GL_ONE : GL_CONSTANT_ALPHA,
                  step->operation == WEFT_BLEND_MIX ? GL_ONE_MINUS_CONSTANT_ALPHA : GL_ONE);
}

static void end_blending(const GladGLContext *gl)
{
    gl->BlendFunc(GL_ONE, GL_ZERO);
    gl->Disable(GL_BLEND);
    gl->Enable(GL_DITHER);
}

static enum weft_result draw_groups(weft_accumulator *a, weft_blend_target *t,
                                    const struct weft_frame *frame,
                                    const struct weft_blend_step *step)
{
    const struct weft_accumulator_params *p = &a->params;
    const GladGLContext *gl = &p->context->gl;
    const struct weft_gl_target *textures;
    enum weft_result res = weft_frame_textures(a, frame, &textures);
    if (res != WEFT_OK)
        return res;
    begin_blending(gl, step);
    for (int g = 0; g < weft_frame_groups(a) && res == WEFT_OK; g++) {
        res = use_program(a, t, step, textures[g].texture);
        weft_gl_target_bind(gl, &t->gl[g], p->width, p->height);
        if (res == WEFT_OK)
            gl->DrawArrays(GL_TRIANGLES, 0, 3);
        t->passes++;
    }
    end_blending(gl);
    return res == WEFT_OK ? weft_gl_check(p->log, gl, "blending a frame") : res;
}

static enum weft_result add_on_gl(weft_accumulator *a, weft_blend_target *t,
                                  const struct weft_frame *frame,
                                  const struct weft_blend_step *step)
{
    enum weft_result res = weft_context_enter(a->params.context);
    if (res != WEFT_OK)
        return res;
    res = draw_groups(a, t, frame, step);
    weft_context_leave(a->params.context);
    t->read_group = -1;
    return res;
}

// ---- emulation ----------------------------------------------------------------------------------

struct emulation {
    weft_accumulator *a;
    weft_blend_target *target;
    const struct weft_plane *planes;
    const struct weft_blend_step *step;
};

// A group's texels on GL have one type, which decides what shaders fetch.
static enum weft_plane_type texel_type(const struct emulation *e, int channel)
{
    const int first = channel - channel % WEFT_FRAME_GROUP;
    const int rest = e->a->params.channel_count - first;
    return weft_frame_common_type(&e->planes[first],
                                  rest < WEFT_FRAME_GROUP ? rest : WEFT_FRAME_GROUP);
}

static bool blend_block(void *priv, int thread, const struct weft_block *block)
{
    const struct emulation *e = priv;
    weft_blend_target *t = e->target;
    const size_t at = (size_t)block->channel * pixel_count(e->a) + block->at;
    float values[WEFT_BLOCK_VALUES];
    const float *fetched = weft_block_floats(block, values);
    (void)thread;
    if (fetched != values)
        memcpy(values, fetched, block->count * sizeof *values);
    weft_blend_fetch(texel_type(e, block->channel), values, block->count);
    weft_value_range_apply(&t->range, values, block->count);
    if (e->step->weight != 1.0f)
        weft_blend_weigh(e->step->weight, values, block->count);
    weft_blend_emulate(t->bits, e->step, values, block->count,
                       (char *)t->emulated + at * value_size(t));
    return true;
}

static enum weft_result add_emulated(weft_accumulator *a, weft_blend_target *t,
                                     const struct weft_frame *frame,
                                     const struct weft_blend_step *step)
{
    struct emulation e = {.a = a, .target = t, .step = step};
    const enum weft_result res = weft_frame_planes(a, frame, &e.planes);
    const struct weft_frame_shape shape = weft_accumulator_shape(a);
    if (res == WEFT_OK)
        weft_blocks_run(&shape, e.planes, NULL, blend_block, &e);
    t->passes += res == WEFT_OK ? (uint64_t)weft_frame_groups(a) : 0;
    return res;
}

enum weft_result weft_blend_target_add(weft_accumulator *a, weft_blend_target *t,
                                       const struct weft_frame *frame,
                                       const struct weft_blend_step *step)
{
    return t->emulated ? add_emulated(a, t, frame, step) : add_on_gl(a, t, frame, step);
}

// ---- reading ------------------------------------------------------------------------------------

static GLenum texel_component(const weft_blend_target *t)
{
    return t->bits == 8 ? GL_UNSIGNED_BYTE : t->bits == 16 ? GL_UNSIGNED_SHORT : GL_FLOAT;
}

static enum weft_result read_group(weft_accumulator *a, weft_blend_target *t, int g)
{
    const struct weft_accumulator_params *p = &a->params;
    if (t->read_group == g)
        return WEFT_OK;
    enum weft_result res = weft_context_enter(p->context);
    if (res != WEFT_OK)
        return res;
    const struct weft_gl_pixels pixels = {
        .width = p->width,
        .height = p->height,
        .type = t->bits == 8    ? GL_UNSIGNED_BYTE
                : t->bits == 16 ? GL_UNSIGNED_SHORT
                                : GL_FLOAT,
        .data = t->read,
    };
    res = weft_gl_target_read(p->log, &p->context->gl, &t->gl[g], &pixels);
    weft_context_leave(p->context);
    t->read_group = res == WEFT_OK ? g : -1;
    return res;
}

enum weft_result weft_blend_target_read(weft_accumulator *a, weft_blend_target *t,
                                        const struct weft_blend_reading *r, int channel, float *out,
                                        size_t stride)
{
    const size_t width = (size_t)a->params.width, size = value_size(t);
    const size_t step = t->emulated ? 1 : WEFT_FRAME_GROUP;
    const double divisor = r->divisor * (t->bits == 8 ? 255.0 : t->bits == 16 ? 65535.0 : 1.0);
    const char *values = t->emulated
                             ? (char *)t->emulated + (size_t)channel * pixel_count(a) * size
                             : (char *)t->read + (size_t)(channel % WEFT_FRAME_GROUP) * size;
    if (!t->emulated) {
        const enum weft_result res = read_group(a, t, channel / WEFT_FRAME_GROUP);
        if (res != WEFT_OK)
            return res;
    }
    for (size_t i = 0; i < pixel_count(a); i++, values += step * size) {
        const double value = size == 1               ? *(const uint8_t *)values
                             : size == sizeof(float) ? (double)*(const float *)values
                                                     : *(const uint16_t *)values;
        out[i / width * stride + i % width] = (float)(r->offset + value * r->scale / divisor);
    }
    return WEFT_OK;
}

enum weft_result weft_blend_target_draw(weft_accumulator *a, weft_blend_target *t,
                                        const struct weft_blend_reading *r, int channel,
                                        int channels, const struct weft_texture *texture)
{
    const struct weft_accumulator_params *p = &a->params;
    const struct weft_rectangle whole = {.width = p->width, .height = p->height};
    const struct weft_gl_drawn drawn = {
        .texture = t->gl[channel / WEFT_FRAME_GROUP].texture,
        .channel = channel % WEFT_FRAME_GROUP,
        .maps = r->offset != 0.0 || r->scale != r->divisor,
        .offset = (float)r->offset,
        .scale = (float)r->scale,
        .divisor = (float)r->divisor,
    };
    struct weft_gl_output output;
    enum weft_result res = weft_context_enter(p->context);
    if (res != WEFT_OK)
        return res;
    res = weft_gl_output_open(p->context, p->log, texture, p->width, p->height, channels, &output);
    if (res == WEFT_OK)
        res = weft_gl_output_draw(&output, &drawn, 0, channels, &whole);
    weft_gl_output_close(&output);
    weft_context_leave(p->context);
    return res;
}

// ---- states -------------------------------------------------------------------------------------

// Texels' components are one after another for each group, as they are in GL; emulated values are
// saved as the same ones.
static size_t saved_size(const weft_blend_target *t)
{
    return t->bits == 8 ? sizeof(uint8_t) : t->bits == 16 ? sizeof(uint16_t) : sizeof(float);
}

// A row of a channel to components of a row of texels, or back.
static void move_row(const weft_accumulator *a, const weft_blend_target *t, int channel, int32_t y,
                     bool save, char *texels)
{
    const size_t width = (size_t)a->params.width, size = saved_size(t), own = value_size(t);
    char *row = (char *)t->emulated + ((size_t)channel * pixel_count(a) + (size_t)y * width) * own;
    texels += (size_t)(channel % WEFT_FRAME_GROUP) * size;
    for (size_t x = 0; x < width; x++, texels += WEFT_FRAME_GROUP * size) {
        uint16_t *code = (uint16_t *)row + x;
        if (size != own && save)
            *texels = (char)(uint8_t)*code;
        else if (size != own)
            *code = (uint8_t)*texels;
        else if (save)
            memcpy(texels, row + x * own, size);
        else
            memcpy(row + x * own, texels, size);
    }
}

static enum weft_result move_emulated(weft_accumulator *a, weft_blend_target *t, int g,
                                      weft_state *state, bool save)
{
    const size_t bytes = (size_t)a->params.width * WEFT_FRAME_GROUP * saved_size(t);
    const int first = g * WEFT_FRAME_GROUP, end = first + WEFT_FRAME_GROUP;
    char *texels = malloc(bytes);
    if (!texels) {
        weft_error(a->params.log, "accumulate: not enough memory for a state");
        return WEFT_ERR_MEMORY;
    }
    for (int32_t y = 0; y < a->params.height; y++) {
        if (save)
            memset(texels, 0, bytes);
        else
            weft_state_take(state, texels, bytes);
        for (int c = first; c < end && c < a->params.channel_count; c++)
            move_row(a, t, c, y, save, texels);
        if (save)
            weft_state_put(state, texels, bytes);
    }
    free(texels);
    return WEFT_OK;
}

static enum weft_result load_group(weft_accumulator *a, weft_blend_target *t, int g)
{
    const struct weft_accumulator_params *p = &a->params;
    enum weft_result res = weft_context_enter(p->context);
    if (res != WEFT_OK)
        return res;
    const GladGLContext *gl = &p->context->gl;
    gl->BindTexture(GL_TEXTURE_2D, t->gl[g].texture);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    gl->TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, p->width, p->height, GL_RGBA, texel_component(t),
                      t->read);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 4);
    res = weft_gl_check(p->log, gl, "loading a target");
    weft_context_leave(p->context);
    t->read_group = -1;
    return res;
}

enum weft_result weft_blend_target_save(weft_accumulator *a, weft_blend_target *t,
                                        weft_state *state)
{
    enum weft_result res = WEFT_OK;
    for (int g = 0; g < weft_frame_groups(a) && res == WEFT_OK; g++) {
        res = t->emulated ? move_emulated(a, t, g, state, true) : read_group(a, t, g);
        if (!t->emulated && res == WEFT_OK)
            weft_state_put(state, t->read, pixel_count(a) * WEFT_FRAME_GROUP * saved_size(t));
    }
    return res;
}

enum weft_result weft_blend_target_load(weft_accumulator *a, weft_blend_target *t,
                                        weft_state *state)
{
    enum weft_result res = WEFT_OK;
    for (int g = 0; g < weft_frame_groups(a) && res == WEFT_OK; g++) {
        if (!t->emulated)
            weft_state_take(state, t->read, pixel_count(a) * WEFT_FRAME_GROUP * saved_size(t));
        res = t->emulated ? move_emulated(a, t, g, state, false) : load_group(a, t, g);
    }
    return res;
}
