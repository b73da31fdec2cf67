// SPDX-License-Identifier: BSD-3-Clause
// tests/passes/gl/every_engine.h - every engine that draws on GL, once, with small requests.
// Include after cmocka.h.
#ifndef WEFT_TESTS_PASSES_GL_EVERY_ENGINE_H
#define WEFT_TESTS_PASSES_GL_EVERY_ENGINE_H

#include <string.h>

#include "tests/passes/antialias/triangles.h"
#include "tests/support/common.h"
#include "weft.h"

enum { ENGINE_N = 12, ENGINE_W = 40, ENGINE_H = 33, ENGINE_PIXELS = ENGINE_W * ENGINE_H };

// Pictures, one behind the other; every engine adds some.
struct every_engine {
    const char *name[32];
    float pixels[32][ENGINE_PIXELS];
    int count;
};

static inline float *engine_picture(struct every_engine *e, const char *name)
{
    assert_true(e->count < (int)WEFT_COUNT(e->name));
    e->name[e->count] = name;
    return e->pixels[e->count++];
}

#define ENGINE_OK(call) assert_int_equal(call, WEFT_OK)

static const struct weft_slice_geometry engine_oblique = {
    {1, 2, 3}, {9, 2, 1}, {-1, 8, 3}, ENGINE_W, ENGINE_H};
static const struct weft_slice_geometry engine_across = {
    {1, 1, 5.3}, {9, 0, 0}, {0, 9, 0}, ENGINE_W, ENGINE_H};

static inline weft_volume *engine_volume_logged(float missing, const struct weft_log *log)
{
    static float data[ENGINE_N * ENGINE_N * ENGINE_N];
    weft_volume *volume = NULL;
    for (int i = 0; i < (int)WEFT_COUNT(data); i++)
        data[i] = (float)sin(0.37 * i) + (float)(i * 7919 % 101) / 101.0f;
    data[5 + ENGINE_N * (6 + ENGINE_N * 6)] += missing;
    ENGINE_OK(weft_volume_create(
        weft_volume_params(.size = {ENGINE_N, ENGINE_N, ENGINE_N}, .data = data, .log = log),
        &volume));
    return volume;
}

static inline weft_volume *engine_volume(float missing)
{
    return engine_volume_logged(missing, &log_to_stderr);
}

static inline void engine_slice(weft_context *context, const struct weft_slice_geometry *geometry,
                                bool passes, bool hardware, float *out)
{
    weft_volume *volume = engine_volume(0.0f);
    weft_slice_plan *plan = NULL;
    weft_pass_plan *pass_plan = NULL;
    weft_hardware_plan *pairs = NULL;
    const struct weft_slice_params params = {.kernel =
                                                 kernel_named(hardware ? "bspline" : "catmull-rom"),
                                             .space = WEFT_SPACE_INDEX,
                                             .geometry = *geometry,
                                             .log = &log_to_stderr};
    ENGINE_OK(weft_slice_plan_create(volume, &params, &plan));
    if (passes)
        ENGINE_OK(weft_pass_plan_create(weft_pass_plan_params(.kernel = params.kernel, .dims = 3,
                                                              .samples = 4, .log = &log_to_stderr),
                                        &pass_plan));
    if (hardware)
        ENGINE_OK(weft_hardware_plan_create(weft_hardware_params(.slice = plan), &pairs));
    const struct weft_slice_passes how = {.plan = pass_plan, .log = &log_to_stderr};
    ENGINE_OK(weft_slice_run_once(plan,
                                  weft_slice_compile_params(.context = context,
                                                            .passes = passes ? &how : NULL,
                                                            .hardware = pairs),
                                  weft_slice_run_params(.pixels = out), NULL));
    weft_hardware_plan_destroy(&pairs);
    weft_pass_plan_destroy(&pass_plan);
    weft_slice_plan_destroy(&plan);
    weft_volume_destroy(&volume);
}

static inline void engine_samples(float out[ENGINE_N * ENGINE_N])
{
    for (int i = 0; i < ENGINE_N * ENGINE_N; i++)
        out[i] = (float)cos(0.7 * i);
}

static inline void engine_resample(weft_context *context, bool passes, float *out)
{
    float samples[ENGINE_N * ENGINE_N];
    weft_pass_plan *pass_plan = NULL;
    weft_resample_plan *plan = NULL;
    weft_resample_compiled *compiled = NULL;
    weft_resample_source *source = NULL;
    engine_samples(samples);
    if (passes)
        ENGINE_OK(
            weft_pass_plan_create(weft_pass_plan_params(.kernel = kernel_named("linear"), .dims = 2,
                                                        .samples = 8, .log = &log_to_stderr),
                                  &pass_plan));
    const struct weft_kernel kernel = kernel_named(passes ? "linear" : "catmull-rom");
    ENGINE_OK(weft_resample_plan_create(
        weft_resample_params(.passes = pass_plan, .kernel = kernel, .size = {ENGINE_N, ENGINE_N},
                             .width = ENGINE_W, .height = ENGINE_H, .log = &log_to_stderr),
        &plan));
    ENGINE_OK(
        weft_resample_compile(plan, weft_resample_compile_params(.context = context), &compiled));
    ENGINE_OK(weft_resample_source_create(
        weft_resample_source_params(.kernel = kernel, .width = ENGINE_N, .height = ENGINE_N,
                                    .plane = {samples}, .log = &log_to_stderr),
        &source));
    ENGINE_OK(weft_resample_run(compiled,
                                weft_resample_run_params(.source = source, .plane = {out}), NULL));
    weft_resample_source_destroy(&source);
    weft_resample_compiled_destroy(&compiled);
    weft_resample_plan_destroy(&plan);
    weft_pass_plan_destroy(&pass_plan);
}

static inline void engine_warp(weft_context *context, float *out)
{
    float samples[ENGINE_N * ENGINE_N];
    struct weft_warp_params *params =
        weft_warp_params(.size = {ENGINE_N, ENGINE_N}, .width = ENGINE_W, .height = ENGINE_H,
                         .log = &log_to_stderr);
    weft_warp_plan *plan = NULL;
    weft_warp_compiled *compiled = NULL;
    weft_resample_source *source = NULL;
    engine_samples(samples);
    weft_warp_matrix_rotate(20.0, (double[2]){6.0, 6.0}, params->map.matrix);
    ENGINE_OK(weft_warp_plan_create(params, &plan));
    ENGINE_OK(weft_warp_compile(plan, weft_resample_compile_params(.context = context), &compiled));
    ENGINE_OK(weft_resample_source_create(
        weft_resample_source_params(.width = ENGINE_N, .height = ENGINE_N, .plane = {samples},
                                    .log = &log_to_stderr),
        &source));
    ENGINE_OK(
        weft_warp_run(compiled, weft_warp_run_params(.source = source, .plane = {out}), NULL));
    weft_resample_source_destroy(&source);
    weft_warp_compiled_destroy(&compiled);
    weft_warp_plan_destroy(&plan);
}

// A slice in a texture of weft's, read from there.
static inline void engine_texture(weft_context *context, float *out)
{
    weft_volume *volume = engine_volume(0.0f);
    weft_slice_plan *plan = NULL;
    struct weft_texture texture = {.name = 0};
    ENGINE_OK(weft_context_enter(context));
    context->gl.GenTextures(1, &texture.name);
    context->gl.BindTexture(GL_TEXTURE_2D, texture.name);
    context->gl.TexImage2D(GL_TEXTURE_2D, 0, GL_R32F, ENGINE_W, ENGINE_H, 0, GL_RED, GL_FLOAT,
                           NULL);
    context->gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    weft_context_leave(context);
    ENGINE_OK(
        weft_slice_plan_create(volume,
                               weft_slice_params(.space = WEFT_SPACE_INDEX,
                                                 .geometry = engine_oblique, .log = &log_to_stderr),
                               &plan));
    ENGINE_OK(weft_slice_run_once(plan, weft_slice_compile_params(.context = context),
                                  weft_slice_run_params(.texture = &texture), NULL));
    ENGINE_OK(
        weft_texture_read(context, &texture, ENGINE_W, ENGINE_H, 1, (float *const[]){out}, 0));
    ENGINE_OK(weft_texture_write(context, &texture, ENGINE_W, ENGINE_H, 1,
                                 (const float *const[]){out}, 0));
    ENGINE_OK(weft_context_enter(context));
    context->gl.DeleteTextures(1, &texture.name);
    weft_context_leave(context);
    weft_slice_plan_destroy(&plan);
    weft_volume_destroy(&volume);
}

// ---- drawing ------------------------------------------------------------------------------------

// Clears to a colour of the frame's own and leaves what it likes behind.
static inline enum weft_result engine_draw(void *priv, int64_t index,
                                           const struct weft_draw_target *target)
{
    const GladGLContext *gl = &((weft_context *)priv)->gl;
    (void)target;
    gl->ClearColor(0.25f * (float)index, 0.5f, 0.75f, 1.0f);
    gl->Clear(GL_COLOR_BUFFER_BIT);
    gl->Enable(GL_SCISSOR_TEST);
    gl->Enable(GL_BLEND);
    gl->ColorMask(GL_FALSE, GL_TRUE, GL_FALSE, GL_TRUE);
    return WEFT_OK;
}

static inline void engine_accumulate(weft_context *context, enum weft_accumulate_method method,
                                     float *out)
{
    weft_accumulator *a = NULL;
    ENGINE_OK(weft_accumulator_create(weft_accumulator_params(.width = ENGINE_W, .height = ENGINE_H,
                                                              .channel_count = 4, .frame_count = 4,
                                                              .method = method, .context = context,
                                                              .log = &log_to_stderr),
                                      &a));
    for (int i = 0; i < 4; i++)
        ENGINE_OK(weft_accumulator_add(
            a, &(struct weft_frame){.draw = engine_draw, .priv = context}, 1.0));
    ENGINE_OK(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, out, 0));
    weft_accumulator_destroy(&a);
}

static inline void engine_triangles(weft_context *context, struct triangles *t)
{
    static const int size[2] = {ENGINE_W, ENGINE_H};
    static const float colour[2][4] = {{1.0f, 0.5f, 0.25f, 1.0f}, {0.25f, 0.75f, 0.5f, 1.0f}};
    static const double corner[2][3][2] = {{{3.2, 4.1}, {36.4, 9.3}, {14.7, 30.9}},
                                           {{1.1, 28.3}, {30.2, 1.7}, {38.6, 31.5}}};
    struct triangle_vertex vertices[6];
    for (int i = 0; i < 2; i++)
        triangle_at(size, corner[i], 0.3 + 0.2 * i, colour[i], (uint32_t)i + 1, &vertices[3 * i]);
    triangles_create(context, vertices, 6, t);
}

static inline void engine_acaa(weft_context *context, struct triangles *t, enum weft_acaa_form form,
                               float *out)
{
    weft_acaa *acaa = NULL;
    memset(out, 0, ENGINE_PIXELS * sizeof *out);
    const enum weft_result res =
        weft_acaa_create(weft_acaa_params(.width = ENGINE_W, .height = ENGINE_H, .samples = 4,
                                          .form = form, .context = context),
                         &acaa);
    if (res == WEFT_ERR_UNSUPPORTED) // by GL 3.3
        return;
    ENGINE_OK(res);
    ENGINE_OK(weft_acaa_run(acaa, triangles_drawing(t), NULL));
    ENGINE_OK(weft_acaa_read(acaa, 0, out, 0));
    weft_acaa_destroy(&acaa);
}

static inline void engine_msaa(weft_context *context, struct triangles *t,
                               enum weft_msaa_resolve resolve, float *out)
{
    weft_msaa *msaa = NULL;
    ENGINE_OK(weft_msaa_create(weft_msaa_params(.width = ENGINE_W, .height = ENGINE_H, .samples = 4,
                                                .resolve = resolve, .context = context,
                                                .log = &log_to_stderr),
                               &msaa));
    ENGINE_OK(weft_msaa_run(msaa, triangles_drawing(t)));
    ENGINE_OK(weft_msaa_read(msaa, 0, out, 0));
    weft_msaa_destroy(&msaa);
}

// Marked pixels, supersampled over the picture of one sample.
static inline void engine_adaptive(weft_context *context, struct triangles *t,
                                   enum weft_supersample_store store, float *out)
{
    weft_marker *marker = NULL;
    weft_supersample *supersample = NULL;
    struct weft_marks marks = {0};
    ENGINE_OK(weft_marker_create(weft_marker_params(.width = ENGINE_W, .height = ENGINE_H,
                                                    .context = context, .log = &log_to_stderr),
                                 &marker));
    ENGINE_OK(weft_marker_run(marker, triangles_drawing(t), &marks));
    ENGINE_OK(weft_marker_read(marker, 0, out, 0));
    ENGINE_OK(weft_supersample_create(
        weft_supersample_params(.width = ENGINE_W, .height = ENGINE_H, .count = 4, .store = store,
                                .context = context, .log = &log_to_stderr),
        &supersample));
    ENGINE_OK(weft_supersample_run(supersample, triangles_drawing(t), &marks, NULL));
    ENGINE_OK(weft_supersample_read(supersample, 0, out, 0));
    weft_supersample_destroy(&supersample);
    weft_marks_clear(&marks);
    weft_marker_destroy(&marker);
}

static inline void run_antialias(weft_context *context, struct every_engine *e)
{
    struct triangles t;
    engine_triangles(context, &t);
    for (int form = WEFT_ACAA_AUTO; form <= WEFT_ACAA_JITTER; form++)
        engine_acaa(context, &t, (enum weft_acaa_form)form, engine_picture(e, "acaa"));
    for (int resolve = 0; resolve < WEFT_MSAA_RESOLVE_COUNT; resolve++)
        engine_msaa(context, &t, (enum weft_msaa_resolve)resolve, engine_picture(e, "msaa"));
    for (int store = 0; store < WEFT_STORE_COUNT; store++)
        engine_adaptive(context, &t, (enum weft_supersample_store)store,
                        engine_picture(e, "adaptive"));
    triangles_destroy(&t);
}

static inline void run_every_engine(weft_context *context, struct every_engine *e)
{
    static const enum weft_accumulate_method methods[] = {
        WEFT_ACCUMULATE_EXACT, WEFT_ACCUMULATE_TREE, WEFT_ACCUMULATE_BUFFER, WEFT_ACCUMULATE_BLEND,
        WEFT_ACCUMULATE_FLOAT};
    e->count = 0;
    engine_slice(context, &engine_oblique, false, false, engine_picture(e, "fused"));
    engine_slice(context, &engine_across, false, false, engine_picture(e, "separable slice"));
    engine_slice(context, &engine_oblique, true, false, engine_picture(e, "slice by passes"));
    engine_slice(context, &engine_oblique, false, true, engine_picture(e, "hardware"));
    engine_resample(context, false, engine_picture(e, "separable"));
    engine_resample(context, true, engine_picture(e, "passes"));
    engine_warp(context, engine_picture(e, "warp"));
    engine_texture(context, engine_picture(e, "texture"));
    assert_memory_equal(e->pixels[0], e->pixels[e->count - 1], sizeof e->pixels[0]); // fused
    for (size_t i = 0; i < WEFT_COUNT(methods); i++)
        engine_accumulate(context, methods[i],
                          engine_picture(e, weft_accumulate_method_names[methods[i]]));
    run_antialias(context, e);
}

#endif
