// SPDX-License-Identifier: BSD-3-Clause
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "tests/support/contexts.h"
#include "filter/half.h"
#include "passes/accumulate/frame.h"
#include "passes/gl/context_backend.h"

// Odd sizes: rows end where no alignment would have them.
enum { WIDTH = 13, HEIGHT = 7, CHANNELS = 9, PIXELS = WIDTH * HEIGHT, PITCH = WIDTH + 5 };

static uint32_t random_state;

static uint32_t next_random(void)
{
    random_state = random_state * 1664525u + 1013904223u;
    return random_state >> 8;
}

// ---- planes -------------------------------------------------------------------------------------

// Planes of random values, channels apart in rows of PITCH values.
static _Alignas(8) unsigned char memory[CHANNELS][4 * PITCH * HEIGHT];

static void fill_plane(int c, enum weft_plane_type type, struct weft_plane *out)
{
    for (int i = 0; i < PITCH * HEIGHT; i++) {
        const uint32_t r = next_random();
        if (type == WEFT_PLANE_FLOAT)
            ((float *)memory[c])[i] = ldexpf((float)r - 8e6f, (int)(r % 40) - 30);
        else if (type == WEFT_PLANE_HALF)
            ((uint16_t *)memory[c])[i] = weft_half_from_float(((float)r - 8e6f) * 1e-4f);
        else if (type == WEFT_PLANE_UNORM8)
            memory[c][i] = (uint8_t)r;
        else if (type == WEFT_PLANE_UNORM16)
            ((uint16_t *)memory[c])[i] = (uint16_t)r;
        else
            ((uint32_t *)memory[c])[i] = r;
    }
    *out = (struct weft_plane){.values = memory[c], .type = type, .stride = PITCH};
}

// Pixel by pixel, in double; the conversions are those of the plane's definition.
static double plane_value(const struct weft_plane *p, int x, int y)
{
    const size_t step = p->step ? p->step : 1;
    const size_t i = (size_t)y * (p->stride ? p->stride : WIDTH * step) + (size_t)x * step;
    switch (p->type) {
    case WEFT_PLANE_FLOAT:
        return ((const float *)p->values)[i];
    case WEFT_PLANE_HALF:
        return weft_half_to_float(((const uint16_t *)p->values)[i]);
    case WEFT_PLANE_UNORM8:
        return ((const uint8_t *)p->values)[i] / 255.0;
    case WEFT_PLANE_UNORM16:
        return ((const uint16_t *)p->values)[i] / 65535.0;
    default:
        return ((const uint32_t *)p->values)[i];
    }
}

// An accumulator of which only frames are used.
static weft_accumulator make(weft_context *context, int channels, int bits)
{
    return (weft_accumulator){.params = {.width = WIDTH,
                                         .height = HEIGHT,
                                         .channel_count = channels,
                                         .frame_bits = bits,
                                         .context = context,
                                         .log = &log_to_stderr}};
}

static void enter(weft_context *context)
{
    assert_int_equal(weft_context_enter(context), WEFT_OK);
}

// A texture as floats, by a framebuffer of our own.
static void read_texture(const GladGLContext *gl, GLuint texture, float *out)
{
    GLuint framebuffer = 0;
    gl->GenFramebuffers(1, &framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl->FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
    assert_int_equal(gl->CheckFramebufferStatus(GL_FRAMEBUFFER), GL_FRAMEBUFFER_COMPLETE);
    gl->ReadPixels(0, 0, WIDTH, HEIGHT, GL_RGBA, GL_FLOAT, out);
    gl->DeleteFramebuffers(1, &framebuffer);
    assert_int_equal(gl->GetError(), GL_NO_ERROR);
}

static void check_group(const struct weft_plane *planes, int count, const float *texels)
{
    for (int i = 0; i < PIXELS; i++) {
        for (int c = 0; c < WEFT_FRAME_GROUP; c++) {
            const double value = c < count ? plane_value(&planes[c], i % WIDTH, i / WIDTH) : 0.0;
            // Codes become floats in GL: to an ulp.
            const double slack =
                c < count && planes[c].type != WEFT_PLANE_FLOAT && planes[c].type != WEFT_PLANE_HALF
                    ? 0x1p-23 * fabs(value)
                    : 0.0;
            if (!(isnan(value) && isnan(texels[4 * i + c])))
                assert_near(texels[4 * i + c], value, slack, "texel");
        }
    }
}

static void check_upload(weft_context *context, const struct weft_plane *planes, int channels,
                         const GLenum *formats)
{
    static float texels[4 * PIXELS];
    weft_accumulator a = make(context, channels, 8);
    const struct weft_frame frame = {.plane = planes};
    const struct weft_gl_target *textures = NULL;
    const struct weft_plane *same = NULL;
    enter(context);
    assert_int_equal(weft_frame_textures(&a, &frame, &textures), WEFT_OK);
    for (int g = 0; g < weft_frame_groups(&a); g++) {
        const int rest = channels - 4 * g;
        assert_int_equal(textures[g].format, formats[g]);
        read_texture(&context->gl, textures[g].texture, texels);
        check_group(planes + 4 * g, rest < 4 ? rest : 4, texels);
    }
    weft_context_leave(context);
    assert_int_equal(weft_frame_planes(&a, &frame, &same), WEFT_OK);
    assert_ptr_equal(same, planes);
    weft_frame_source_destroy(&a);
    assert_null(a.source);
}

static void test_planes(void **state)
{
    enum { F = WEFT_PLANE_FLOAT, H, B, W, U };
    static const struct {
        int channels;
        int type[CHANNELS];
        GLenum format[3];
    } cases[] = {
        {1, {F}, {GL_RGBA32F}},
        {1, {H}, {GL_RGBA16F}},
        {1, {B}, {GL_RGBA8}},
        {1, {W}, {GL_RGBA16}},
        {1, {U}, {GL_RGBA32F}},
        {3, {B, B, B}, {GL_RGBA8}},
        {4, {H, H, H, H}, {GL_RGBA16F}},
        {4, {B, W, W, B}, {GL_RGBA16}},
        {4, {B, H, H, H}, {GL_RGBA32F}},
        {4, {B, W, F, U}, {GL_RGBA32F}},
        {9, {H, H, H, H, F, B, W, U, B}, {GL_RGBA16F, GL_RGBA32F, GL_RGBA8}},
    };
    (void)state;
    random_state = 1;
    for (size_t k = 0; k < 2 && contexts[k]; k++) {
        for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
            struct weft_plane planes[CHANNELS];
            for (int c = 0; c < cases[i].channels; c++)
                fill_plane(c, cases[i].type[c], &planes[c]);
            check_upload(contexts[k], planes, cases[i].channels, cases[i].format);
        }
    }
}

// RGBA as it lies in memory, of whole rows and of a part of longer ones.
static void test_interleaved_planes(void **state)
{
    static const GLenum formats[] = {GL_RGBA32F, GL_RGBA16F, GL_RGBA8, GL_RGBA16};
    (void)state;
    random_state = 2;
    for (size_t k = 0; k < 2 && contexts[k]; k++) {
        for (int type = 0; type <= WEFT_PLANE_UNORM16; type++) {
            for (size_t stride = 0; stride <= 4 * (WIDTH + 1); stride += 4 * (WIDTH + 1)) {
                struct weft_plane planes[4];
                const size_t size = weft_plane_type_size(type);
                for (int c = 0; c < CHANNELS; c++)
                    fill_plane(c, type, &planes[0]);
                for (size_t c = 0; c < 4; c++)
                    planes[c] = (struct weft_plane){memory[0] + c * size, type, stride, 4};
                check_upload(contexts[k], planes, 4, &formats[type]);
                // The other way round is not as GL has it.
                const struct weft_plane first = planes[0];
                planes[0] = planes[2];
                planes[2] = first;
                check_upload(contexts[k], planes, 4, &formats[type]);
            }
        }
    }
}

static void test_rows(void **state)
{
    (void)state;
    random_state = 3;
    for (int type = 0; type < WEFT_PLANE_TYPE_COUNT; type++) {
        struct weft_plane plane;
        float row[WIDTH];
        fill_plane(0, type, &plane);
        for (int y = 0; y < HEIGHT; y++) {
            weft_plane_row(&plane, y, WIDTH, row, 1);
            for (int x = 0; x < WIDTH; x++)
                assert_true(row[x] == (float)plane_value(&plane, x, y));
        }
    }
}

// ---- callers' textures --------------------------------------------------------------------------

static const struct {
    GLenum format, channels, type;
    enum weft_plane_type plane;
    size_t texel;
} texture_cases[] = {
    {GL_R8, GL_RED, GL_UNSIGNED_BYTE, WEFT_PLANE_UNORM8, 1},
    {GL_R16, GL_RED, GL_UNSIGNED_SHORT, WEFT_PLANE_UNORM16, 2},
    {GL_R16F, GL_RED, GL_HALF_FLOAT, WEFT_PLANE_HALF, 2},
    {GL_R32F, GL_RED, GL_FLOAT, WEFT_PLANE_FLOAT, 4},
    {GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, WEFT_PLANE_UNORM8, 4},
    {GL_RGBA16, GL_RGBA, GL_UNSIGNED_SHORT, WEFT_PLANE_UNORM16, 8},
    {GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT, WEFT_PLANE_HALF, 8},
    {GL_RGBA32F, GL_RGBA, GL_FLOAT, WEFT_PLANE_FLOAT, 16},
};

static void test_textures(void **state)
{
    (void)state;
    random_state = 4;
    for (size_t k = 0; k < 2 && contexts[k]; k++) {
        const GladGLContext *gl = &contexts[k]->gl;
        for (size_t i = 0; i < WEFT_COUNT(texture_cases); i++) {
            const int channels = texture_cases[i].channels == GL_RED ? 1 : 4;
            weft_accumulator a = make(contexts[k], channels, 8);
            struct weft_frame frame = {0};
            struct weft_plane filled;
            const struct weft_plane *planes = NULL;
            const struct weft_gl_target *textures = NULL;
            for (int c = 0; c < CHANNELS; c++)
                fill_plane(c, texture_cases[i].plane, &filled);
            enter(contexts[k]);
            gl->GenTextures(1, &frame.texture);
            gl->BindTexture(GL_TEXTURE_2D, frame.texture);
            gl->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
            gl->TexImage2D(GL_TEXTURE_2D, 0, (GLint)texture_cases[i].format, WIDTH, HEIGHT, 0,
                           texture_cases[i].channels, texture_cases[i].type, memory);
            assert_int_equal(weft_frame_textures(&a, &frame, &textures), WEFT_OK);
            assert_int_equal(textures[0].texture, frame.texture);
            assert_int_equal(textures[0].framebuffer, 0);
            assert_int_equal(textures[0].format, texture_cases[i].format);
            weft_context_leave(contexts[k]);
            assert_int_equal(weft_frame_planes(&a, &frame, &planes), WEFT_OK);
            for (int c = 0; c < channels; c++)
                assert_int_equal(planes[c].type, texture_cases[i].plane);
            assert_memory_equal(planes[0].values, memory, PIXELS * texture_cases[i].texel);
            weft_frame_source_destroy(&a);
            enter(contexts[k]);
            gl->DeleteTextures(1, &frame.texture);
            weft_context_leave(contexts[k]);
        }
    }
}

static GLuint make_texture(const GladGLContext *gl, GLenum kind, GLenum format, int width)
{
    GLuint texture;
    gl->GenTextures(1, &texture);
    gl->BindTexture(kind, texture);
    if (kind == GL_TEXTURE_2D)
        gl->TexImage2D(kind, 0, (GLint)format, width, HEIGHT, 0, GL_RGBA, GL_UNSIGNED_BYTE, NULL);
    else
        gl->TexImage3D(kind, 0, (GLint)format, width, HEIGHT, 1, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                       NULL);
    return texture;
}

static void test_textures_refused(void **state)
{
    static const struct {
        GLenum kind, format;
        int width, channels;
        const char *text;
    } cases[] = {
        {GL_TEXTURE_2D, GL_RGBA8, WIDTH + 1, 4, "has 14 x 7 texels, not 13 x 7"},
        {GL_TEXTURE_2D, GL_RGB8, WIDTH, 3, "3 channels need GL_RGBA with 8"},
        {GL_TEXTURE_2D, GL_R8, WIDTH, 2, "2 channels need GL_RGBA with 8"},
        {GL_TEXTURE_2D, GL_SRGB8_ALPHA8, WIDTH, 1, "1 channel need GL_R or GL_RGBA"},
        {GL_TEXTURE_3D, GL_RGBA8, WIDTH, 4, "is not a 2D one"},
        {0, 0, 0, 4, "12345 is no texture"},
    };
    (void)state;
    for (size_t k = 0; k < 2 && contexts[k]; k++) {
        for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
            struct message message = {.count = 0};
            const struct weft_log log = {keep_message, &message};
            const struct weft_gl_target *textures;
            const struct weft_plane *planes;
            weft_accumulator a = make(contexts[k], cases[i].channels, 8);
            a.params.log = &log;
            enter(contexts[k]);
            const struct weft_frame frame = {
                .texture = cases[i].kind ? make_texture(&contexts[k]->gl, cases[i].kind,
                                                        cases[i].format, cases[i].width)
                                         : 12345};
            assert_int_equal(weft_frame_textures(&a, &frame, &textures), WEFT_ERR_ARGUMENT);
            assert_null(textures);
            weft_context_leave(contexts[k]);
            assert_int_equal(weft_frame_planes(&a, &frame, &planes), WEFT_ERR_ARGUMENT);
            assert_int_equal(message.count, 2);
            if (!strstr(message.text, cases[i].text))
                fail_msg("no \"%s\" in: %s", cases[i].text, message.text);
            weft_frame_source_destroy(&a);
            enter(contexts[k]);
            contexts[k]->gl.DeleteTextures(1, &frame.texture);
            weft_context_leave(contexts[k]);
        }
    }
}

// ---- frames that are drawn ----------------------------------------------------------------------

struct painter {
    const GladGLContext *gl;
    int calls;
    int64_t index;
    void (*leave)(const GladGLContext *gl); // state; NULL: none
    enum weft_result result;
};

static const double colours[2][4] = {{0.2, 0.4, 0.6, 0.8}, {1.0, 0.0, 51.0 / 255, 102.0 / 255}};

// One colour, and another in the box (2, 1) - (6, 4). The target is as was promised: the viewport
// set, colours and depth cleared.
static enum weft_result paint(void *priv, int64_t index, const struct weft_draw_target *target)
{
    struct painter *p = priv;
    const GladGLContext *gl = p->gl;
    GLint bound = 0, viewport[4], depth_bits = 0;
    float texel[4], depth = 0.0f;
    gl->GetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &bound);
    gl->GetIntegerv(GL_VIEWPORT, viewport);
    gl->GetFramebufferAttachmentParameteriv(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT,
                                            GL_FRAMEBUFFER_ATTACHMENT_DEPTH_SIZE, &depth_bits);
    assert_int_equal(bound, target->framebuffer);
    assert_int_equal(depth_bits, 24);
    assert_true(viewport[0] == 0 && viewport[1] == 0);
    assert_true(viewport[2] == WIDTH && viewport[3] == HEIGHT);
    assert_true(target->width == WIDTH && target->height == HEIGHT);
    for (int i = 0; i < PIXELS; i++) {
        gl->ReadPixels(i % WIDTH, i / WIDTH, 1, 1, GL_RGBA, GL_FLOAT, texel);
        gl->ReadPixels(i % WIDTH, i / WIDTH, 1, 1, GL_DEPTH_COMPONENT, GL_FLOAT, &depth);
        assert_true(texel[0] == 0 && texel[1] == 0 && texel[2] == 0 && texel[3] == 0);
        assert_true(depth == 1.0f);
    }
    assert_false(gl->IsEnabled(GL_BLEND) || gl->IsEnabled(GL_SCISSOR_TEST) ||
                 gl->IsEnabled(GL_DEPTH_TEST));
    for (int c = 0; c < 2; c++) {
        gl->ClearColor((float)colours[c][0], (float)colours[c][1], (float)colours[c][2],
                       (float)colours[c][3]);
        gl->ClearDepth(0.5);
        gl->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
        gl->Enable(GL_SCISSOR_TEST);
        gl->Scissor(2, 1, 4, 3);
    }
    if (p->leave)
        p->leave(gl);
    p->calls++;
    p->index = index;
    return p->result;
}

static void check_painted(const struct weft_plane *planes, int bits)
{
    static const enum weft_plane_type types[] = {[8] = WEFT_PLANE_UNORM8,
                                                 [16] = WEFT_PLANE_UNORM16,
                                                 [WEFT_ACCUMULATE_HALF] = WEFT_PLANE_HALF,
                                                 [32] = WEFT_PLANE_FLOAT};
    const double slack = bits == 8 || bits == 16 ? 1e-6 : bits == 32 ? 1e-7 : 0x1p-11;
    for (int i = 0; i < PIXELS; i++) {
        const int x = i % WIDTH, y = i / WIDTH, inside = x >= 2 && x < 6 && y >= 1 && y < 4;
        for (int c = 0; c < 4; c++) {
            assert_int_equal(planes[c].type, types[bits]);
            assert_near(plane_value(&planes[c], x, y), colours[inside][c], slack, "painted");
        }
    }
}

// Draws a frame, asks for it in both ways, in either order, and sees it painted once.
static void check_drawn(weft_accumulator *a, struct painter *p, bool planes_first)
{
    const struct weft_frame frame = {.draw = paint, .priv = p};
    const struct weft_gl_target *textures = NULL;
    const struct weft_plane *planes = NULL;
    const int before = p->calls;
    weft_frame_begin(a);
    if (planes_first)
        assert_int_equal(weft_frame_planes(a, &frame, &planes), WEFT_OK);
    enter(a->params.context);
    assert_int_equal(weft_frame_textures(a, &frame, &textures), WEFT_OK);
    assert_int_equal(textures[0].format, weft_frame_format(a->params.frame_bits));
    weft_context_leave(a->params.context);
    assert_int_equal(weft_frame_planes(a, &frame, &planes), WEFT_OK);
    assert_int_equal(p->calls, before + 1);
    assert_int_equal(p->index, a->frames);
    check_painted(planes, a->params.frame_bits);
    a->frames++;
}

static const int bit_cases[] = {8, 16, WEFT_ACCUMULATE_HALF, 32};

static void test_drawn(void **state)
{
    (void)state;
    for (size_t k = 0; k < 2 && contexts[k]; k++) {
        for (size_t i = 0; i < WEFT_COUNT(bit_cases); i++) {
            weft_accumulator a = make(contexts[k], 4, bit_cases[i]);
            struct painter p = {.gl = &contexts[k]->gl};
            check_drawn(&a, &p, false);
            check_drawn(&a, &p, true);
            weft_frame_source_destroy(&a);
        }
    }
}

// Everything that could spoil what weft draws, uploads or reads next.
static void leave_strange_state(const GladGLContext *gl)
{
    static const GLenum on[] = {
        GL_BLEND,          GL_DEPTH_TEST,         GL_STENCIL_TEST,
        GL_SCISSOR_TEST,   GL_CULL_FACE,          GL_COLOR_LOGIC_OP,
        GL_DEPTH_CLAMP,    GL_RASTERIZER_DISCARD, GL_FRAMEBUFFER_SRGB,
        GL_SAMPLE_MASK,    GL_SAMPLE_COVERAGE,    GL_SAMPLE_ALPHA_TO_COVERAGE,
        GL_CLIP_DISTANCE0, GL_CLIP_DISTANCE3,     GL_PRIMITIVE_RESTART,
    };
    static const GLenum store[] = {GL_PACK_SKIP_PIXELS, GL_PACK_SKIP_ROWS,  GL_UNPACK_SKIP_PIXELS,
                                   GL_UNPACK_SKIP_ROWS, GL_PACK_ROW_LENGTH, GL_UNPACK_ROW_LENGTH};
    static const GLenum nothing = GL_NONE;
    static GLuint sampler, buffer, vertex_array, framebuffer;
    for (size_t i = 0; i < WEFT_COUNT(on); i++)
        gl->Enable(on[i]);
    gl->Disable(GL_DITHER);
    gl->DepthFunc(GL_NEVER);
    gl->StencilFunc(GL_NEVER, 1, 255);
    gl->Scissor(0, 0, 1, 1);
    gl->Viewport(3, 3, 2, 2);
    gl->DepthRange(0.25, 0.25);
    gl->CullFace(GL_FRONT_AND_BACK);
    gl->FrontFace(GL_CW);
    gl->LogicOp(GL_INVERT);
    gl->BlendFunc(GL_ZERO, GL_ZERO);
    gl->BlendEquation(GL_MIN);
    gl->PolygonMode(GL_FRONT_AND_BACK, GL_POINT);
    gl->ColorMask(GL_FALSE, GL_TRUE, GL_FALSE, GL_FALSE);
    gl->DepthMask(GL_FALSE);
    gl->StencilMask(0);
    gl->SampleCoverage(0.0f, GL_FALSE);
    gl->SampleMaski(0, 0);
    gl->ClearColor(1.0f, 1.0f, 1.0f, 1.0f);
    gl->ClearDepth(0.0);
    gl->DrawBuffers(1, &nothing);
    gl->ReadBuffer(GL_NONE);
    for (size_t i = 0; i < WEFT_COUNT(store); i++)
        gl->PixelStorei(store[i], 1);
    gl->PixelStorei(GL_PACK_SWAP_BYTES, 1);
    gl->PixelStorei(GL_UNPACK_SWAP_BYTES, 1);
    gl->PixelStorei(GL_PACK_ALIGNMENT, 8);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 8);
    gl->GenBuffers(1, &buffer);
    gl->BindBuffer(GL_PIXEL_PACK_BUFFER, buffer);
    gl->BindBuffer(GL_PIXEL_UNPACK_BUFFER, buffer);
    gl->GenSamplers(1, &sampler);
    for (GLuint unit = 0; unit < 16; unit++) {
        gl->BindSampler(unit, sampler);
        gl->ActiveTexture(GL_TEXTURE0 + unit);
    }
    gl->GenVertexArrays(1, &vertex_array);
    gl->BindVertexArray(vertex_array);
    gl->GenFramebuffers(1, &framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    if (gl->ClipControl)
        gl->ClipControl(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
}

static void test_drawn_into_a_target(void **state)
{
    (void)state;
    for (size_t k = 0; k < 2 && contexts[k]; k++) {
        const GladGLContext *gl = &contexts[k]->gl;
        weft_accumulator a = make(contexts[k], 4, 8);
        struct painter p = {.gl = gl, .leave = leave_strange_state};
        uint8_t texels[4 * PIXELS];
        struct weft_plane planes[4];
        struct weft_gl_target target;
        enter(contexts[k]);
        assert_int_equal(
            weft_gl_target_create(&log_to_stderr, gl, GL_RGBA8, WIDTH, HEIGHT, &target), WEFT_OK);
        assert_int_equal(
            weft_frame_draw(&a, &(struct weft_frame){.draw = paint, .priv = &p}, &target), WEFT_OK);
        const struct weft_gl_pixels pixels = {
            .width = WIDTH, .height = HEIGHT, .type = GL_UNSIGNED_BYTE, .data = texels};
        assert_int_equal(weft_gl_target_read(&log_to_stderr, gl, &target, &pixels), WEFT_OK);
        for (int c = 0; c < 4; c++)
            planes[c] = (struct weft_plane){texels + c, WEFT_PLANE_UNORM8, 0, 4};
        check_painted(planes, 8);
        assert_int_equal(p.calls, 1);
        weft_gl_target_destroy(gl, &target);
        weft_context_leave(contexts[k]);
        weft_frame_source_destroy(&a);
    }
}

static void test_strange_state(void **state)
{
    (void)state;
    for (size_t k = 0; k < 2 && contexts[k]; k++) {
        const GladGLContext *gl = &contexts[k]->gl;
        weft_accumulator a = make(contexts[k], 4, 8);
        struct painter p = {.gl = gl, .leave = leave_strange_state};
        struct weft_plane planes[4];
        GLint before = 0, after = 0;
        enter(contexts[k]);
        gl->GetIntegerv(GL_VERTEX_ARRAY_BINDING, &before);
        weft_context_leave(contexts[k]);
        check_drawn(&a, &p, false);
        check_drawn(&a, &p, true);
        weft_frame_source_destroy(&a);
        for (int c = 0; c < 4; c++)
            fill_plane(c, WEFT_PLANE_UNORM8, &planes[c]);
        check_upload(contexts[k], planes, 4, (const GLenum[]){GL_RGBA8});
        enter(contexts[k]);
        gl->GetIntegerv(GL_VERTEX_ARRAY_BINDING, &after);
        weft_context_leave(contexts[k]);
        assert_int_equal(before, after);
    }
}

static void raise_error(const GladGLContext *gl)
{
    gl->Enable(0x1234);
}

static void test_drawing_fails(void **state)
{
    static const struct {
        void (*leave)(const GladGLContext *gl);
        enum weft_result result, expected;
        const char *text;
    } cases[] = {
        {NULL, WEFT_ERR_CANCELLED, WEFT_ERR_CANCELLED, "frame 5 was not drawn"},
        {leave_strange_state, WEFT_ERR_OPEN, WEFT_ERR_OPEN, "frame 5 was not drawn"},
        {raise_error, WEFT_OK, WEFT_ERR_GL, "GL_INVALID_ENUM (0x0500) after a frame was drawn"},
    };
    (void)state;
    for (size_t k = 0; k < 2 && contexts[k]; k++) {
        for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
            struct message message = {.count = 0};
            const struct weft_log log = {keep_message, &message};
            weft_accumulator a = make(contexts[k], 4, 8);
            struct painter p = {
                .gl = &contexts[k]->gl, .leave = cases[i].leave, .result = cases[i].result};
            const struct weft_plane *planes = NULL;
            a.frames = 5;
            a.params.log = &log;
            assert_int_equal(
                weft_frame_planes(&a, &(struct weft_frame){.draw = paint, .priv = &p}, &planes),
                cases[i].expected);
            assert_null(planes);
            assert_int_equal(message.count, 1);
            if (!strstr(message.text, cases[i].text))
                fail_msg("no \"%s\" in: %s", cases[i].text, message.text);
            p.leave = NULL;
            p.result = WEFT_OK;
            check_drawn(&a, &p, false);
            weft_frame_source_destroy(&a);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_planes),
        cmocka_unit_test(test_interleaved_planes),
        cmocka_unit_test(test_rows),
        cmocka_unit_test(test_textures),
        cmocka_unit_test(test_textures_refused),
        cmocka_unit_test(test_drawn),
        cmocka_unit_test(test_drawn_into_a_target),
        cmocka_unit_test(test_strange_state),
        cmocka_unit_test(test_drawing_fails),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
