// SPDX-License-Identifier: BSD-3-Clause
// Textures of a caller's: results that are drawn to them are those in memory, without a read back,
// sources come from them, and what does not do is refused.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>

#include "tests/passes/gl/every_engine.h"
#include "tests/passes/gl/own_contexts.h"
#include "tests/support/alloc_fail.h"
#include "tests/support/common.h"

// ---- contexts -----------------------------------------------------------------------------------

static const struct {
    const char *name;
    bool egl, shares;
} kinds[] = {
    {"EGL's own context", true, false},
    {"EGL's share group", true, true},
    {"OSMesa's own context", false, false},
};

static struct own own;
static weft_context *context;
static int reads; // of pixels, to memory

static void GLAD_API_PTR count_read(GLint x, GLint y, GLsizei width, GLsizei height, GLenum format,
                                    GLenum type, void *out)
{
    GLint buffer = 0;
    own.gl.GetIntegerv(GL_PIXEL_PACK_BUFFER_BINDING, &buffer);
    reads += buffer == 0;
    own.gl.ReadPixels(x, y, width, height, format, type, out);
}

static weft_gl_function find_counting(void *priv, const char *name)
{
    return strcmp(name, "glReadPixels") == 0 ? (weft_gl_function)count_read : own_find(priv, name);
}

static bool start(size_t kind)
{
    struct weft_context_params params = {.log = &log_to_stderr};
    own =
        (struct own){.name = kinds[kind].name, .egl = kinds[kind].egl, .version = 33, .core = true};
    if (!own_start(&own)) {
        print_message("[  SKIPPED ] %s\n", own.name);
        return false;
    }
    if (kinds[kind].shares) {
        params.egl_display = own.display;
        params.egl_share = own.context;
    } else {
        params.caller =
            (struct weft_context_caller){.get_proc_address = find_counting, .priv = &own};
    }
    ENGINE_OK(weft_context_create(&params, &context));
    return true;
}

static void stop(void)
{
    weft_context_destroy(&context);
    own_stop(&own);
}

// ---- textures -----------------------------------------------------------------------------------

enum { EDGE_X = 3, EDGE_Y = 2, WIDE = ENGINE_W + 7, HIGH = ENGINE_H + 5 };

static const float untouched = 0.625f; // every format holds it to 1/255

static GLuint make_texture(GLenum format, int level)
{
    float *texels = malloc(sizeof *texels * 4 * WIDE * HIGH);
    GLuint texture = 0;
    assert_non_null(texels);
    for (int i = 0; i < 4 * WIDE * HIGH; i++)
        texels[i] = untouched;
    own.gl.GenTextures(1, &texture);
    own.gl.BindTexture(GL_TEXTURE_2D, texture);
    own.gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, level);
    for (int i = 0; i <= level; i++)
        own.gl.TexImage2D(GL_TEXTURE_2D, i, (GLint)format, WIDE << (level - i), HIGH << (level - i),
                          0, GL_RGBA, GL_FLOAT, i == level ? texels : NULL);
    assert_int_equal(own.gl.GetError(), GL_NO_ERROR);
    free(texels);
    return texture;
}

// Pixels from (EDGE_X, EDGE_Y) on are `expected`, and all others and other channels what they were.
static void expect_texture(const char *what, GLuint texture, int level, int channel,
                           const float *expected, double tolerance)
{
    float *found = malloc(sizeof *found * 4 * WIDE * HIGH);
    assert_non_null(found);
    own.gl.BindTexture(GL_TEXTURE_2D, texture);
    own.gl.GetTexImage(GL_TEXTURE_2D, level, GL_RGBA, GL_FLOAT, found);
    for (int i = 0; i < 4 * WIDE * HIGH; i++) {
        const int x = i / 4 % WIDE - EDGE_X, y = i / 4 / WIDE - EDGE_Y, c = i % 4;
        const bool in = x >= 0 && x < ENGINE_W && y >= 0 && y < ENGINE_H && c == channel;
        const double wanted = (double)(in ? expected[y * ENGINE_W + x] : untouched);
        const bool same = (double)found[i] == wanted || (isnan(found[i]) && isnan(wanted)) ||
                          fabs((double)found[i] - wanted) <= (in ? tolerance : 0.5 / 255.0);
        if (!same && (in || channel > 0 || c == 0))
            fail_msg("%s, %s: pixel (%d, %d), channel %d is %g instead of %g", own.name, what, x, y,
                     c, (double)found[i], wanted);
    }
    free(found);
}

#define TEXTURE_AT(of, of_channel)                                                                 \
    (&(struct weft_texture){.name = (of), .x = EDGE_X, .y = EDGE_Y, .channel = (of_channel)})

// ---- slices -------------------------------------------------------------------------------------

// One slice, to memory, to a texture, and to both; how many pixels were read back for the texture.
static int check_slice(const char *what, const struct weft_slice_geometry *geometry, float missing,
                       bool passes, bool hardware)
{
    static float expected[ENGINE_PIXELS], pixels[ENGINE_PIXELS];
    weft_volume *volume = engine_volume(missing);
    weft_slice_plan *plan = NULL;
    weft_pass_plan *pass_plan = NULL;
    weft_hardware_plan *pairs = NULL;
    weft_slice *slice = NULL;
    struct weft_slice_report report;
    const struct weft_slice_params params = {.kernel = kernel_named(passes     ? "linear"
                                                                    : hardware ? "bspline"
                                                                               : "catmull-rom"),
                                             .space = WEFT_SPACE_INDEX,
                                             .geometry = *geometry,
                                             .log = &log_to_stderr};
    ENGINE_OK(weft_slice_plan_create(volume, &params, &plan));
    if (passes)
        ENGINE_OK(weft_pass_plan_create(
            weft_pass_plan_params(.kernel = params.kernel, .dims = 3, .samples = 4), &pass_plan));
    if (hardware)
        ENGINE_OK(weft_hardware_plan_create(weft_hardware_params(.slice = plan), &pairs));
    ENGINE_OK(weft_slice_compile(
        plan,
        weft_slice_compile_params(.context = context, .hardware = pairs,
                                  .passes = passes ? weft_slice_passes(.plan = pass_plan) : NULL),
        &slice));
    reads = 0;
    ENGINE_OK(weft_slice_run(slice, weft_slice_run_params(.pixels = expected), &report));
    assert_int_equal(reads > 0, context->backend->callers);
    assert_int_equal(report.exact_pixels > 0, missing != 0.0f && !passes);
    const GLuint texture = make_texture(GL_RGBA32F, 0);
    const int before = reads;
    ENGINE_OK(
        weft_slice_run(slice, weft_slice_run_params(.texture = TEXTURE_AT(texture, 1)), &report));
    const int read = reads - before;
    assert_true(isnan(report.minimum) && report.not_finite == 0);
    expect_texture(what, texture, 0, 1, expected, 0.0);
    ENGINE_OK(weft_slice_run(
        slice, weft_slice_run_params(.pixels = pixels, .texture = TEXTURE_AT(texture, 1)),
        &report));
    assert_memory_equal(pixels, expected, sizeof pixels);
    assert_false(isnan(report.minimum));
    expect_texture(what, texture, 0, 1, expected, 0.0);
    own.gl.DeleteTextures(1, &texture);
    weft_slice_destroy(&slice);
    weft_hardware_plan_destroy(&pairs);
    weft_pass_plan_destroy(&pass_plan);
    weft_slice_plan_destroy(&plan);
    weft_volume_destroy(&volume);
    return read;
}

static void slices_are_drawn_to_textures(void **state)
{
    (void)state;
    int ran = 0;
    for (size_t k = 0; k < WEFT_COUNT(kinds); k++) {
        if (!start(k))
            continue;
        assert_int_equal(check_slice("fused", &engine_oblique, 0.0f, false, false), 0);
        assert_int_equal(check_slice("hardware", &engine_oblique, 0.0f, false, true), 0);
        assert_int_equal(check_slice("separable", &engine_across, 0.0f, false, false), 0);
        check_slice("passes", &engine_oblique, 0.0f, true, false);
        check_slice("fused, a voxel missing", &engine_oblique, NAN, false, false);
        check_slice("hardware, a voxel missing", &engine_oblique, NAN, false, true);
        check_slice("separable, a voxel missing", &engine_across, NAN, false, false);
        stop();
        ran++;
    }
    if (ran == 0)
        skip();
}

// Derivatives, one a channel, of a part.
static void outputs_are_channels(void **state)
{
    static float expected[3][ENGINE_PIXELS];
    const struct weft_derivative derivative[3] = {derivative_named("none"), derivative_named("x"),
                                                  derivative_named("yz")};
    const struct weft_rectangle part = {5, 3, 20, 11};
    (void)state;
    if (!start(0))
        skip();
    weft_volume *volume = engine_volume(0.0f);
    weft_slice_plan *plan = NULL;
    ENGINE_OK(weft_slice_plan_create(
        volume,
        weft_slice_params(.space = WEFT_SPACE_INDEX, .geometry = engine_oblique, .part = part,
                          .derivative = derivative, .derivative_count = 3, .log = &log_to_stderr),
        &plan));
    const GLuint texture = make_texture(GL_RGBA32F, 0);
    ENGINE_OK(weft_slice_run_once(plan, weft_slice_compile_params(.context = context),
                                  weft_slice_run_params(.pixels = expected[0],
                                                        .plane_stride = ENGINE_PIXELS,
                                                        .texture = TEXTURE_AT(texture, 0)),
                                  NULL));
    float plane[3][ENGINE_PIXELS];
    float *const planes[3] = {plane[0], plane[1], plane[2]};
    ENGINE_OK(
        weft_texture_read(context, TEXTURE_AT(texture, 0), part.width, part.height, 3, planes, 0));
    for (int o = 0; o < 3; o++)
        assert_memory_equal(plane[o], expected[o],
                            sizeof(float) * (size_t)(part.width * part.height));
    own.gl.DeleteTextures(1, &texture);
    weft_slice_plan_destroy(&plan);
    weft_volume_destroy(&volume);
    stop();
}

// ---- images -------------------------------------------------------------------------------------

struct image_case {
    const char *name, *kernel;
    bool passes, clamp;
    float scale; // of the samples
    double tolerance;
};

// Samples from one texture, pixels to another; the same as from memory to memory.
static void check_image(const struct image_case *c)
{
    static float expected[2][ENGINE_PIXELS];
    float samples[2][ENGINE_N * ENGINE_N];
    const struct weft_kernel kernel = kernel_named(c->kernel);
    weft_pass_plan *pass_plan = NULL;
    weft_resample_plan *plan = NULL;
    weft_resample_compiled *compiled = NULL;
    weft_resample_source *source = NULL, *from_texture = NULL;
    engine_samples(samples[0]);
    for (int i = 0; i < ENGINE_N * ENGINE_N; i++) {
        samples[0][i] *= c->scale;
        samples[1][i] = 1.0f - samples[0][i];
    }
    if (c->passes)
        ENGINE_OK(weft_pass_plan_create(
            weft_pass_plan_params(.kernel = kernel, .dims = 2, .samples = 8), &pass_plan));
    ENGINE_OK(weft_resample_plan_create(
        weft_resample_params(.passes = pass_plan, .kernel = kernel, .size = {ENGINE_N, ENGINE_N},
                             .width = ENGINE_W, .height = ENGINE_H, .clamp = c->clamp,
                             .log = &log_to_stderr),
        &plan));
    ENGINE_OK(
        weft_resample_compile(plan, weft_resample_compile_params(.context = context), &compiled));
    struct weft_resample_source_params *params =
        weft_resample_source_params(.kernel = kernel, .width = ENGINE_N, .height = ENGINE_N,
                                    .channels = 2, .plane = {samples[0], samples[1]},
                                    .log = &log_to_stderr);
    ENGINE_OK(weft_resample_source_create(params, &source));
    ENGINE_OK(weft_resample_run(
        compiled, weft_resample_run_params(.source = source, .plane = {expected[0], expected[1]}),
        NULL));
    const GLuint in = make_texture(GL_RGBA32F, 0), out = make_texture(GL_RGBA32F, 0);
    ENGINE_OK(weft_texture_write(context, TEXTURE_AT(in, 1), ENGINE_N, ENGINE_N, 2,
                                 (const float *const[]){samples[0], samples[1]}, 0));
    params->plane[0] = params->plane[1] = NULL;
    params->context = context;
    params->texture = TEXTURE_AT(in, 1);
    ENGINE_OK(weft_resample_source_create(params, &from_texture));
    own.gl.DeleteTextures(1, &in); // it was read
    const int before = reads;
    ENGINE_OK(weft_resample_run(
        compiled, weft_resample_run_params(.source = from_texture, .texture = TEXTURE_AT(out, 2)),
        NULL));
    if (!c->passes && !c->clamp && c->scale < 1e18f)
        assert_int_equal(reads, before);
    float found[2][ENGINE_PIXELS];
    float *const planes[2] = {found[0], found[1]};
    ENGINE_OK(weft_texture_read(context, TEXTURE_AT(out, 2), ENGINE_W, ENGINE_H, 2, planes, 0));
    for (int i = 0; i < 2 * ENGINE_PIXELS; i++)
        if (found[i / ENGINE_PIXELS][i % ENGINE_PIXELS] !=
            expected[i / ENGINE_PIXELS][i % ENGINE_PIXELS])
            fail_msg("%s, %s: value %d is %g instead of %g", own.name, c->name, i,
                     (double)found[i / ENGINE_PIXELS][i % ENGINE_PIXELS],
                     (double)expected[i / ENGINE_PIXELS][i % ENGINE_PIXELS]);
    own.gl.DeleteTextures(1, &out);
    weft_resample_source_destroy(&from_texture);
    weft_resample_source_destroy(&source);
    weft_resample_compiled_destroy(&compiled);
    weft_resample_plan_destroy(&plan);
    weft_pass_plan_destroy(&pass_plan);
}

static void images_come_from_textures_and_go_to_them(void **state)
{
    static const struct image_case cases[] = {
        {"separable", "catmull-rom", false, false, 1.0f, 0.0},
        {"prefiltered", "bspline3i", false, false, 1.0f, 0.0},
        {"clamped", "catmull-rom", false, true, 1.0f, 0.0},
        {"passes", "linear", true, false, 1.0f, 0.0},
        {"large samples", "catmull-rom", false, false, 2e38f, 0.0},
    };
    (void)state;
    int ran = 0;
    for (size_t k = 0; k < WEFT_COUNT(kinds); k++) {
        if (!start(k))
            continue;
        for (size_t c = 0; c < WEFT_COUNT(cases); c++)
            check_image(&cases[c]);
        stop();
        ran++;
    }
    if (ran == 0)
        skip();
}

// ---- accumulation -------------------------------------------------------------------------------

static void check_mean(enum weft_accumulate_method method, int bits, double low, double tolerance)
{
    static float expected[ENGINE_PIXELS];
    weft_accumulator *a = NULL;
    ENGINE_OK(weft_accumulator_create(
        weft_accumulator_params(.width = ENGINE_W, .height = ENGINE_H, .channel_count = 4,
                                .frame_count = 3, .method = method, .bits = bits, .low = low,
                                .high = 1.0, .context = context, .log = &log_to_stderr),
        &a));
    for (int i = 0; i < 3; i++)
        ENGINE_OK(weft_accumulator_add(
            a, &(struct weft_frame){.draw = engine_draw, .priv = context}, 1.0));
    const GLuint texture = make_texture(GL_RGBA32F, 0);
    for (int channel = 0; channel < 3; channel++) {
        ENGINE_OK(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, channel, expected, 0));
        const int before = reads;
        ENGINE_OK(weft_accumulator_current_texture(a, WEFT_ACCUMULATED_MEAN, channel, 1,
                                                   TEXTURE_AT(texture, 3)));
        if (method == WEFT_ACCUMULATE_BLEND || method == WEFT_ACCUMULATE_FLOAT)
            assert_int_equal(reads, before);
        expect_texture(weft_accumulate_method_names[method], texture, 0, 3, expected, tolerance);
    }
    ENGINE_OK(
        weft_accumulator_current_texture(a, WEFT_ACCUMULATED_MEAN, 0, 4, TEXTURE_AT(texture, 0)));
    own.gl.DeleteTextures(1, &texture);
    weft_accumulator_destroy(&a);
}

static void means_go_to_textures(void **state)
{
    (void)state;
    int ran = 0;
    for (size_t k = 0; k < WEFT_COUNT(kinds); k++) {
        if (!start(k))
            continue;
        check_mean(WEFT_ACCUMULATE_EXACT, 0, 0.0, 0.0);
        check_mean(WEFT_ACCUMULATE_TREE, 8, 0.0, 0.0);
        check_mean(WEFT_ACCUMULATE_BUFFER, 16, 0.0, 0.0);
        check_mean(WEFT_ACCUMULATE_BLEND, 32, 0.0, 0x1p-21);
        check_mean(WEFT_ACCUMULATE_BLEND, 8, -1.0, 0x1p-21);
        check_mean(WEFT_ACCUMULATE_FLOAT, 0, 0.0, 0x1p-21);
        stop();
        ran++;
    }
    if (ran == 0)
        skip();
}

// ---- what textures hold -------------------------------------------------------------------------

static void formats_round_as_gl_does(void **state)
{
    static const struct {
        GLenum format;
        int channel;
        double tolerance;
    } cases[] = {
        {GL_R8, 0, 0.5 / 255 + 1e-6},    {GL_RG16, 1, 0.5 / 65535 + 1e-6},
        {GL_RGBA8, 3, 0.5 / 255 + 1e-6}, {GL_RGBA16F, 2, 0x1p-11},
        {GL_R16F, 0, 0x1p-11},           {GL_RG32F, 1, 0.0},
        {GL_RGB10_A2, 2, 1.0 / 1023},
    };
    static float ramp[ENGINE_PIXELS], back[ENGINE_PIXELS];
    (void)state;
    if (!start(0))
        skip();
    for (int i = 0; i < ENGINE_PIXELS; i++)
        ramp[i] = (float)i / ENGINE_PIXELS;
    for (size_t c = 0; c < WEFT_COUNT(cases); c++)
        for (int level = 0; level < 2; level++) {
            const GLuint texture = make_texture(cases[c].format, level);
            struct weft_texture at = *TEXTURE_AT(texture, cases[c].channel);
            at.level = level;
            ENGINE_OK(weft_texture_write(context, &at, ENGINE_W, ENGINE_H, 1,
                                         (const float *const[]){ramp}, 0));
            if (cases[c].format == GL_RGBA8 || cases[c].format == GL_R16F)
                expect_texture("formats", texture, level, cases[c].channel, ramp,
                               cases[c].tolerance);
            ENGINE_OK(
                weft_texture_read(context, &at, ENGINE_W, ENGINE_H, 1, (float *const[]){back}, 0));
            for (int i = 0; i < ENGINE_PIXELS; i++)
                assert_near((double)back[i], (double)ramp[i], cases[c].tolerance, "a texel");
            own.gl.DeleteTextures(1, &texture);
        }
    stop();
}

static struct message message;

static void expect_refused(const struct weft_texture *texture, int width, int channels,
                           const char *text)
{
    static float values[ENGINE_PIXELS];
    const float *const plane[4] = {values, values, values, values};
    float *const out[4] = {values, values, values, values};
    message.count = 0;
    assert_int_equal(weft_texture_write(context, texture, width, 3, channels, plane, 0),
                     WEFT_ERR_ARGUMENT);
    assert_int_equal(message.count, 1);
    if (!strstr(message.text, text))
        fail_msg("'%s' lacks '%s'", message.text, text);
    assert_int_equal(weft_texture_read(context, texture, width, 3, channels, out, 0),
                     WEFT_ERR_ARGUMENT);
    assert_int_equal(message.count, 2);
}

static void textures_that_are_refused(void **state)
{
    static const struct weft_log log = {keep_message, &message};
    (void)state;
    own = (struct own){.name = "OSMesa", .version = 33, .core = true};
    if (!own_start(&own))
        skip();
    ENGINE_OK(weft_context_create(
        weft_context_params(.caller = {.get_proc_address = own_find, .priv = &own}, .log = &log),
        &context));
    const GLuint good = make_texture(GL_RG32F, 0), srgb = make_texture(GL_SRGB8_ALPHA8, 0);
    GLuint whole = 0, deep = 0, depth = 0, gone = make_texture(GL_R8, 0);
    own.gl.DeleteTextures(1, &gone);
    own.gl.GenTextures(1, &whole);
    own.gl.BindTexture(GL_TEXTURE_2D, whole);
    own.gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8UI, 9, 9, 0, GL_RGBA_INTEGER, GL_UNSIGNED_BYTE,
                      NULL);
    own.gl.GenTextures(1, &depth);
    own.gl.BindTexture(GL_TEXTURE_2D, depth);
    own.gl.TexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, 9, 9, 0, GL_DEPTH_COMPONENT, GL_FLOAT,
                      NULL);
    own.gl.GenTextures(1, &deep);
    own.gl.BindTexture(GL_TEXTURE_3D, deep);
    expect_refused(&(struct weft_texture){0}, 3, 1, "texture 0 is none of the context's");
    expect_refused(&(struct weft_texture){.name = gone}, 3, 1, "is none of the context's");
    expect_refused(&(struct weft_texture){.name = deep}, 3, 1, "is no GL_TEXTURE_2D");
    expect_refused(&(struct weft_texture){.name = whole}, 3, 1, "holds integers");
    expect_refused(&(struct weft_texture){.name = srgb}, 3, 1, "holds sRGB");
    expect_refused(&(struct weft_texture){.name = depth}, 3, 1, "cannot draw into");
    expect_refused(&(struct weft_texture){.name = good, .x = WIDE - 2}, 3, 1,
                   "has 47 x 38 texels at level 0; 3 x 3 pixels from (45, 0) on need 48 x 3");
    expect_refused(&(struct weft_texture){.name = good, .level = 1}, 3, 1, "0 x 0 texels");
    expect_refused(&(struct weft_texture){.name = good}, 3, 3, "has no channel B");
    expect_refused(&(struct weft_texture){.name = good, .channel = 3}, 3, 2, "required");
    expect_refused(&(struct weft_texture){.name = good, .x = -1}, 3, 1, "required");
    expect_refused(&(struct weft_texture){.name = good}, 0, 1, "required");
    assert_int_equal(own.gl.GetError(), GL_NO_ERROR);
    // A slice of more outputs than channels, and one without a context.
    weft_volume *volume = engine_volume(0.0f);
    weft_slice_plan *plan = NULL;
    ENGINE_OK(weft_slice_plan_create(volume,
                                     weft_slice_params(.space = WEFT_SPACE_INDEX,
                                                       .geometry = engine_oblique,
                                                       .engine = WEFT_ENGINE_CPU, .log = &log),
                                     &plan));
    assert_int_equal(weft_slice_run_once(plan, weft_slice_compile_params(.context = NULL),
                                         weft_slice_run_params(.texture = TEXTURE_AT(good, 0)),
                                         NULL),
                     WEFT_ERR_ARGUMENT);
    weft_slice_plan_destroy(&plan);
    weft_volume_destroy(&volume);
    stop();
}

// ---- memory -------------------------------------------------------------------------------------

static const struct weft_log counting = {keep_message, &message};
static GLuint first_texture, second_texture;
static weft_volume *with_missing;

static enum weft_result make_context(void)
{
    weft_context *made = NULL;
    const enum weft_result res = weft_context_create(
        weft_context_params(.caller = {.get_proc_address = own_find, .priv = &own},
                            .log = &counting),
        &made);
    weft_context_destroy(&made);
    return res;
}

// A slice with a missing voxel, whose pixels go through memory.
static enum weft_result slice_to_texture(void)
{
    enum weft_result res = WEFT_OK;
    for (int i = 0; res == WEFT_OK && i < 2; i++) {
        weft_slice_plan *plan = NULL;
        res = weft_slice_plan_create(
            with_missing,
            weft_slice_params(.space = WEFT_SPACE_INDEX,
                              .geometry = i ? engine_across : engine_oblique, .log = &counting),
            &plan);
        if (res == WEFT_OK)
            res = weft_slice_run_once(
                plan, weft_slice_compile_params(.context = context),
                weft_slice_run_params(.texture = TEXTURE_AT(first_texture, 0)), NULL);
        weft_slice_plan_destroy(&plan);
    }
    return res;
}

// From one texture to the other, held between samples.
static enum weft_result resample_textures(void)
{
    weft_resample_plan *plan = NULL;
    weft_resample_compiled *compiled = NULL;
    weft_resample_source *source = NULL;
    enum weft_result res = weft_resample_plan_create(
        weft_resample_params(.size = {ENGINE_N, ENGINE_N}, .width = ENGINE_W, .height = ENGINE_H,
                             .clamp = true, .log = &counting),
        &plan);
    if (res == WEFT_OK)
        res = weft_resample_compile(plan, weft_resample_compile_params(.context = context),
                                    &compiled);
    if (res == WEFT_OK)
        res = weft_resample_source_create(
            weft_resample_source_params(.width = ENGINE_N, .height = ENGINE_N, .threads = 1,
                                        .context = context, .texture = TEXTURE_AT(first_texture, 0),
                                        .log = &counting),
            &source);
    if (res == WEFT_OK)
        res = weft_resample_run(compiled,
                                weft_resample_run_params(.source = source,
                                                         .texture = TEXTURE_AT(second_texture, 0),
                                                         .log = &counting),
                                NULL);
    weft_resample_source_destroy(&source);
    weft_resample_compiled_destroy(&compiled);
    weft_resample_plan_destroy(&plan);
    return res;
}

static void without_memory_calls_end(void **state)
{
    enum weft_result (*const calls[])(void) = {make_context, slice_to_texture, resample_textures};
    (void)state;
    if (!start(2))
        skip();
    context->log = &counting;
    first_texture = make_texture(GL_RGBA32F, 0);
    second_texture = make_texture(GL_RGBA32F, 0);
    with_missing = engine_volume_logged(NAN, &counting);
    for (size_t i = 0; i < WEFT_COUNT(calls); i++) {
        ENGINE_OK(calls[i]()); // programs are there then
        unsigned long k = 1;
        for (bool struck = true; struck; k++) {
            message.count = 0;
            alloc_fail_at(k);
            const enum weft_result res = calls[i]();
            struck = alloc_fail_struck();
            alloc_fail_at(0);
            // A filter of slices that cannot be kept for the next one is no failure.
            if (struck && res != WEFT_OK) {
                if (i && res != WEFT_ERR_MEMORY)
                    fail_msg("call %zu, allocation %lu: %d, %s", i, k, res, message.text);
                if (!message.count)
                    fail_msg("call %zu, allocation %lu: %d says nothing", i, k, res);
            }
            assert_int_equal(own.gl.GetError(), GL_NO_ERROR);
        }
        assert_true(k > 2);
    }
    own.gl.DeleteTextures(1, &first_texture);
    own.gl.DeleteTextures(1, &second_texture);
    weft_volume_destroy(&with_missing);
    stop();
}

// ---- docs/contexts.md ---------------------------------------------------------------------------

static void the_example_prints_what_it_should(void **state)
{
    char line[64] = "";
    (void)state;
    if (!start(0))
        skip();
    stop();
    FILE *out = popen(WEFT_BINARY_DIR "/contexts_example", "r");
    assert_non_null(out);
    assert_non_null(fgets(line, sizeof line, out));
    assert_int_equal(pclose(out), 0);
    assert_string_equal(line, "2.0625 4.5625\n");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slices_are_drawn_to_textures),
        cmocka_unit_test(outputs_are_channels),
        cmocka_unit_test(images_come_from_textures_and_go_to_them),
        cmocka_unit_test(means_go_to_textures),
        cmocka_unit_test(formats_round_as_gl_does),
        cmocka_unit_test(textures_that_are_refused),
        cmocka_unit_test(without_memory_calls_end),
        cmocka_unit_test(the_example_prints_what_it_should),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
