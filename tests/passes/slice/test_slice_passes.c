// SPDX-License-Identifier: BSD-3-Clause
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "tests/support/contexts.h"
#include "filter/kernels/signal.h"
#include "passes/slice/multipass.h"
#include "passes/verify/verify.h"

// ---- volumes, slices, plans ---------------------------------------------------------------------

enum { N = 32 };

static float signal_at(const char *name, int x, int y, int z)
{
    const double at[3] = {weft_signal_coordinate(x, N), weft_signal_coordinate(y, N),
                          weft_signal_coordinate(z, N)};
    return (float)weft_signal_find(name)->value(at);
}

// value = low + signal * scale, outside the volume the background (NAN: the nearest voxel's).
static float *make_voxels(const char *signal, double low, double scale)
{
    float *data = malloc(N * N * N * sizeof *data);
    assert_non_null(data);
    for (int z = 0; z < N; z++)
        for (int y = 0; y < N; y++)
            for (int x = 0; x < N; x++)
                data[(z * N + y) * N + x] =
                    (float)(low + scale * (double)signal_at(signal, x, y, z));
    return data;
}

// Takes over the voxels.
static weft_volume *make_volume(float *data, float background)
{
    weft_volume *volume = NULL;
    const struct weft_volume_params params = {.size = {N, N, N},
                                              .origin = {-5, 100, 7},
                                              .background = background,
                                              .data = data,
                                              .log = &log_to_stderr};
    assert_int_equal(weft_volume_create(&params, &volume), WEFT_OK);
    free(data);
    return volume;
}

// Tilted against every axis, through the middle of the volume and past its faces.
static struct weft_slice_geometry oblique(int width, int height)
{
    struct weft_slice_geometry g = {.width = width, .height = height};
    const double u[3] = {0.9, 0.4, 0.2}, v[3] = {-0.3, 0.8, 0.5}, corner[3] = {-5, 100, 7};
    for (int a = 0; a < 3; a++) {
        g.u[a] = u[a] * N;
        g.v[a] = v[a] * N;
        g.origin[a] = corner[a] + 0.5 * N - 0.5 * (g.u[a] + g.v[a]);
    }
    return g;
}

static struct weft_slice_geometry across(const weft_volume *volume, int axis, double at, int width,
                                         int height)
{
    struct weft_slice_geometry g;
    assert_int_equal(weft_slice_axis_geometry(&log_to_stderr, volume, WEFT_SPACE_INDEX, axis, at,
                                              width, height, &g),
                     WEFT_OK);
    return g;
}

struct method {
    const char *kernel, *profile;
    enum weft_technique technique;
    int samples;
    enum weft_order order;
};

static weft_pass_plan *make_plan(const struct method *method)
{
    weft_pass_plan *plan = NULL;
    struct weft_pass_plan_params *params =
        weft_pass_plan_params(.kernel = kernel_named(method->kernel), .dims = 3,
                              .samples = method->samples, .technique = method->technique,
                              .order = method->order, .log = &log_to_stderr);
    assert_int_equal(weft_profile_parse(&log_to_stderr, method->profile, &params->profile),
                     WEFT_OK);
    assert_int_equal(weft_pass_plan_create(params, &plan), WEFT_OK);
    return plan;
}

// Slice, plan and volume of one case, and what came out.
struct fixture {
    weft_volume *volume;
    weft_slice_plan *slice;
    weft_pass_plan *plan;
    size_t count;
    struct weft_slice_report report;
};

static void set_up(struct fixture *f, weft_volume *volume, const struct weft_slice_geometry *g,
                   const struct method *method)
{
    const struct weft_slice_params params = {
        .kernel = kernel_named(method->kernel), .space = WEFT_SPACE_INDEX, .geometry = *g};
    *f = (struct fixture){.volume = volume, .plan = make_plan(method)};
    assert_int_equal(weft_slice_plan_create(volume, &params, &f->slice), WEFT_OK);
    f->count = (size_t)g->width * (size_t)g->height;
}

static void tear_down(struct fixture *f)
{
    weft_pass_plan_destroy(&f->plan);
    weft_slice_plan_destroy(&f->slice);
}

static struct weft_slice_passes passes_of(const struct fixture *f)
{
    return *weft_slice_passes(.plan = f->plan, .log = &log_to_stderr);
}

static enum weft_result run_passes(weft_context *context, const struct fixture *f,
                                   const struct weft_slice_passes *passes, float *pixels,
                                   struct weft_slice_report *report)
{
    return weft_slice_run_once(f->slice,
                               weft_slice_compile_params(.context = context, .passes = passes),
                               weft_slice_run_params(.pixels = pixels), report);
}

static float *make_pixels(const struct fixture *f)
{
    float *pixels = malloc(f->count * sizeof *pixels);
    assert_non_null(pixels);
    for (size_t i = 0; i < f->count; i++)
        pixels[i] = 12345.0f;
    return pixels;
}

// To be freed. memory_bytes 0: the default.
static float *run(struct fixture *f, weft_context *context, uint64_t memory_bytes)
{
    float *pixels = make_pixels(f);
    struct weft_slice_passes passes = passes_of(f);
    passes.memory_bytes = memory_bytes;
    assert_int_equal(run_passes(context, f, &passes, pixels, &f->report), WEFT_OK);
    return pixels;
}

// The plan's bound for any input, and the rounding of pixels to single precision.
static double bound_of(const struct fixture *f)
{
    const struct weft_slice_report *r = &f->report;
    const double largest = fmax(fabs((double)r->minimum), fabs((double)r->maximum));
    return weft_pass_plan_get_info(f->plan)->error.bound_any * (r->high - r->low) +
           0x1p-24 * largest;
}

static void assert_within_bound(const struct fixture *f, const float *pixels, const char *what)
{
    struct weft_verify_report error;
    assert_int_equal(weft_slice_verify(f->slice, pixels, NULL, &error), WEFT_OK);
    if (!(error.maximum <= bound_of(f)) || error.not_finite_mismatches)
        fail_msg("%s: error %.3g at (%d, %d): %.9g instead of %.9g; the bound is %.3g; %d not "
                 "finite",
                 what, error.maximum, error.at_x, error.at_y, error.at_value, error.at_reference,
                 bound_of(f), (int)error.not_finite_mismatches);
}

// ---- accuracy -----------------------------------------------------------------------------------

static const struct method methods[] = {
    {"catmull-rom", "fp32", WEFT_TECHNIQUE_PLAIN, 48, WEFT_ORDER_PLANNED},
    {"catmull-rom", "fp32", WEFT_TECHNIQUE_DOT4, 32, WEFT_ORDER_PLANNED},
    {"linear", "fp32", WEFT_TECHNIQUE_PLAIN, 128, WEFT_ORDER_PLANNED},
    {"bspline2", "fp32", WEFT_TECHNIQUE_PLAIN, 32, WEFT_ORDER_PLANNED},
    {"catmull-rom", "fp16", WEFT_TECHNIQUE_PLAIN, 32, WEFT_ORDER_PLANNED},
    {"catmull-rom", "unorm16", WEFT_TECHNIQUE_DOT4, 32, WEFT_ORDER_PLANNED},
    {"catmull-rom", "unorm8", WEFT_TECHNIQUE_PLAIN, 16, WEFT_ORDER_PLANNED},
    {"bspline", "unorm8", WEFT_TECHNIQUE_DOT4, 16, WEFT_ORDER_PLANNED},
    {"bspline", "radeon8500", WEFT_TECHNIQUE_DOT4, 16, WEFT_ORDER_PLANNED},
    {"linear", "geforce3", WEFT_TECHNIQUE_PLAIN, 16, WEFT_ORDER_PLANNED},
};

static void slices_stay_within_the_bound(void **state)
{
    (void)state;
    const struct {
        const char *signal;
        double low, scale;
        float background;
    } volumes[] = {
        {"marschner-lobb", 0.0, 1.0, 0.0f},
        {"chirp", -300.0, 17.0, NAN},
    };
    for (size_t v = 0; v < WEFT_COUNT(volumes); v++) {
        weft_volume *volume =
            make_volume(make_voxels(volumes[v].signal, volumes[v].low, volumes[v].scale),
                        volumes[v].background);
        const struct weft_slice_geometry slices[] = {
            oblique(70, 60), across(volume, 2, NAN, 50, 40), across(volume, 0, -4.75, 33, 35)};
        for (size_t w = 0; w < WEFT_COUNT(methods); w++) {
            for (size_t s = 0; s < WEFT_COUNT(slices); s++) {
                char what[128];
                struct fixture f;
                set_up(&f, volume, &slices[s], &methods[w]);
                float *pixels = run(&f, contexts[0], 0);
                snprintf(what, sizeof what, "%s, slice %d, %s on %s", volumes[v].signal, (int)s,
                         methods[w].kernel, methods[w].profile);
                assert_within_bound(&f, pixels, what);
                free(pixels);
                tear_down(&f);
            }
        }
        weft_volume_destroy(&volume);
    }
}

// A plan of single precision and many samples comes close to the slice in one pass.
static void fine_tiles_come_close_to_one_pass(void **state)
{
    (void)state;
    const struct method method = {"linear", "fp32", WEFT_TECHNIQUE_PLAIN, 128, WEFT_ORDER_PLANNED};
    const struct weft_slice_geometry g = oblique(80, 80);
    weft_volume *volume = make_volume(make_voxels("marschner-lobb", 0.0, 1.0), 0.0f);
    struct fixture f;
    set_up(&f, volume, &g, &method);
    float *pixels = run(&f, contexts[0], 0), *one_pass = make_pixels(&f);
    assert_int_equal(weft_slice_run_once(f.slice, weft_slice_compile_params(.context = contexts[0]),
                                         weft_slice_run_params(.pixels = one_pass), NULL),
                     WEFT_OK);
    // Half a sample in each of three axes, where neighbours differ by at most 1.
    for (size_t i = 0; i < f.count; i++)
        assert_near(pixels[i], one_pass[i], 3 * 0.5 / 128 + 1e-6, "a pixel");
    free(pixels);
    free(one_pass);
    tear_down(&f);
    weft_volume_destroy(&volume);
}

// ---- the same bits ------------------------------------------------------------------------------

static void assert_same_bits(const float *a, const float *b, size_t count, const char *what)
{
    for (size_t i = 0; i < count; i++)
        if (memcmp(&a[i], &b[i], sizeof *a) != 0)
            fail_msg("%s: pixel %zu is %.9g and %.9g", what, i, (double)a[i], (double)b[i]);
}

static void gl_and_emulation_agree_in_every_bit(void **state)
{
    (void)state;
    weft_volume *volume = make_volume(make_voxels("chirp", -0.25, 2.0), 0.5f);
    const struct weft_slice_geometry g = oblique(90, 50);
    int compared = 0;
    for (size_t w = 0; w < WEFT_COUNT(methods); w++) {
        struct fixture f;
        // Floats are summed in an order of GL's own.
        if (strncmp(methods[w].profile, "fp", 2) == 0)
            continue;
        set_up(&f, volume, &g, &methods[w]);
        float *emulated = run(&f, NULL, 0);
        for (int c = 0; c < 2 && contexts[c]; c++) {
            float *pixels = run(&f, contexts[c], 0);
            assert_same_bits(pixels, emulated, f.count, methods[w].profile);
            free(pixels);
            compared++;
        }
        free(emulated);
        tear_down(&f);
    }
    assert_true(compared >= 4);
    weft_volume_destroy(&volume);
}

static void cutting_changes_no_bit(void **state)
{
    (void)state;
    weft_volume *volume = make_volume(make_voxels("marschner-lobb", -1.0, 3.0), 0.0f);
    const struct weft_slice_geometry g = oblique(530, 290); // more than one block each way
    static const struct method both[] = {
        {"catmull-rom", "unorm8", WEFT_TECHNIQUE_PLAIN, 16, WEFT_ORDER_NATURAL},
        {"bspline2", "fp32", WEFT_TECHNIQUE_PLAIN, 7, WEFT_ORDER_PLANNED},
    };
    for (size_t w = 0; w < WEFT_COUNT(both); w++) {
        struct fixture f;
        set_up(&f, volume, &g, &both[w]);
        float *whole = run(&f, contexts[0], 0);
        const int rectangles = f.report.rectangles;
        assert_true(f.report.peak_bytes > 0);
        for (uint64_t memory = f.report.peak_bytes / 2, i = 0; i < 2; i++, memory -= memory / 3) {
            float *cut = run(&f, contexts[0], memory);
            assert_true(f.report.rectangles > rectangles);
            assert_true(f.report.peak_bytes <= memory);
            assert_same_bits(cut, whole, f.count, both[w].kernel);
            free(cut);
        }
        free(whole);
        tear_down(&f);
    }
    weft_volume_destroy(&volume);
}

// ---- what is in reach ---------------------------------------------------------------------------

static const struct method small_method = {"catmull-rom", "unorm8", WEFT_TECHNIQUE_PLAIN, 8,
                                           WEFT_ORDER_NATURAL};

static void the_range_is_that_of_the_voxels_in_reach(void **state)
{
    (void)state;
    float *data = make_voxels("ramp", 0.0, 1.0);
    data[(16 * N + 10) * N + 10] = 50.0f;  // four taps at z = 7 + 14.5: voxels 13 to 16
    data[(17 * N + 10) * N + 10] = 100.0f; // one slice further
    data[(13 * N + 20) * N + 20] = -7.0f;
    weft_volume *volume = make_volume(data, 0.0f);
    const struct weft_slice_geometry g = across(volume, 2, 7 + 14.5, 40, 40);
    struct fixture f;
    set_up(&f, volume, &g, &small_method);
    float *pixels = run(&f, contexts[0], 0);
    assert_true(f.report.low == -7.0 && f.report.high == 50.0);
    assert_int_equal(f.report.clamped, 0);
    assert_within_bound(&f, pixels, "spikes");
    free(pixels);
    tear_down(&f);
    weft_volume_destroy(&volume);
}

static void a_declared_range_clamps(void **state)
{
    (void)state;
    weft_volume *volume = make_volume(make_voxels("ramp", 0.0, 1.0), 0.0f);
    const struct weft_slice_geometry g = oblique(40, 40);
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    struct fixture f;
    set_up(&f, volume, &g, &small_method);
    float *pixels = make_pixels(&f);
    struct weft_slice_passes passes = passes_of(&f);
    passes.log = &log;
    passes.low = -1.0;
    passes.high = 2.0;
    assert_int_equal(run_passes(contexts[0], &f, &passes, pixels, &f.report), WEFT_OK);
    assert_true(f.report.low == -1.0 && f.report.high == 2.0 && f.report.clamped == 0);
    assert_within_bound(&f, pixels, "a wide range");
    passes.low = 0.25;
    passes.high = 0.5;
    assert_int_equal(message.count, 0);
    assert_int_equal(run_passes(contexts[0], &f, &passes, pixels, &f.report), WEFT_OK);
    assert_true(f.report.clamped > 0);
    assert_int_equal(message.count, 1);
    assert_non_null(strstr(message.text, "source range"));
    for (size_t i = 0; i < f.count; i++)
        assert_true(pixels[i] >= 0.2f && pixels[i] <= 0.55f);
    free(pixels);
    tear_down(&f);
    weft_volume_destroy(&volume);
}

static void beside_the_volume_is_background(void **state)
{
    (void)state;
    static const float backgrounds[] = {0.0f, 7.25f, -1e30f};
    for (size_t i = 0; i < WEFT_COUNT(backgrounds); i++) {
        weft_volume *volume = make_volume(make_voxels("ramp", 0.0, 1.0), backgrounds[i]);
        const struct weft_slice_geometry g = across(volume, 1, -500.0, 20, 20);
        struct fixture f;
        set_up(&f, volume, &g, &small_method);
        float *pixels = run(&f, contexts[0], 0);
        for (size_t p = 0; p < f.count; p++)
            assert_true(pixels[p] == backgrounds[i]);
        assert_int_equal(f.report.bricks_read, 0);
        free(pixels);
        tear_down(&f);
        weft_volume_destroy(&volume);
    }
}

static void sparse_volumes_read_the_bricks_in_reach_only(void **state)
{
    (void)state;
    enum { BRICKS = 3 };
    static float values[BRICKS * WEFT_BRICK_VOXELS];
    static const int32_t origins[BRICKS][3] = {{0, 0, 0}, {16, 8, 0}, {0, 0, 400}};
    for (int i = 0; i < BRICKS * WEFT_BRICK_VOXELS; i++)
        values[i] = i / WEFT_BRICK_VOXELS < 2 ? 0.01f * (float)(i % 97) : 1000.0f;
    const struct weft_volume_tile tile = {.origin = {128, 0, 0}, .size = 128, .value = 0.5f};
    const struct weft_volume_bricks_params params = {.brick_count = BRICKS,
                                                     .brick_origin = origins,
                                                     .brick_values = values,
                                                     .tile_count = 1,
                                                     .tiles = &tile,
                                                     .background = 0.125f,
                                                     .log = &log_to_stderr};
    weft_volume *volume = NULL;
    assert_int_equal(weft_volume_create_bricks(&params, &volume), WEFT_OK);
    const struct weft_slice_geometry g = {
        .origin = {-10, -10, 2.0}, .u = {200, 10, 6}, .v = {0, 60, 1}, .width = 300, .height = 90};
    struct fixture f;
    set_up(&f, volume, &g, &small_method);
    float *pixels = run(&f, contexts[0], 0);
    assert_true(f.report.high < 1.0); // the far brick is not seen
    assert_within_bound(&f, pixels, "sparse");
    free(pixels);
    tear_down(&f);
    weft_volume_destroy(&volume);
}

static void not_finite_voxels_stay_in_reach(void **state)
{
    (void)state;
    static const float bad[] = {NAN, INFINITY, -INFINITY};
    for (size_t b = 0; b < WEFT_COUNT(bad); b++) {
        float *data = make_voxels("ramp", 0.0, 1.0);
        data[(15 * N + 16) * N + 17] = bad[b];
        weft_volume *volume = make_volume(data, 0.0f);
        const struct weft_slice_geometry g = oblique(61, 67); // on no voxel's plane
        struct fixture f;
        set_up(&f, volume, &g, &small_method);
        for (int gl = 0; gl < 2; gl++) {
            float *pixels = run(&f, gl ? contexts[0] : NULL, 0);
            assert_true(f.report.not_finite > 0 && f.report.not_finite < 600);
            assert_true(f.report.clamped > 0 && f.report.high <= 1.0);
            assert_within_bound(&f, pixels, "not finite");
            free(pixels);
        }
        tear_down(&f);
        weft_volume_destroy(&volume);
    }
}

// ---- refusals and interrupts --------------------------------------------------------------------

static void bad_arguments_are_refused(void **state)
{
    (void)state;
    weft_volume *volume = make_volume(make_voxels("ramp", 0.0, 1.0), 0.0f);
    const struct weft_slice_geometry g = oblique(40, 40);
    const struct method other = {"bspline", "fp32", WEFT_TECHNIQUE_PLAIN, 8, WEFT_ORDER_PLANNED};
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    struct fixture f;
    set_up(&f, volume, &g, &small_method);
    weft_pass_plan *other_plan = make_plan(&other), *flat = NULL;
    assert_int_equal(weft_pass_plan_create(weft_pass_plan_params(.samples = 8), &flat), WEFT_OK);
    float *pixels = make_pixels(&f);
    const struct weft_slice_passes good = passes_of(&f);
    const struct {
        const weft_pass_plan *plan;
        float *pixels;
        double low, high;
        uint64_t memory_bytes;
        enum weft_result expected;
        const char *text;
    } cases[] = {
        {NULL, pixels, NAN, NAN, 0, WEFT_ERR_ARGUMENT, "plan"},
        {flat, pixels, NAN, NAN, 0, WEFT_ERR_ARGUMENT, "dims == 3"},
        {other_plan, pixels, NAN, NAN, 0, WEFT_ERR_ARGUMENT, "kernel"},
        {f.plan, NULL, NAN, NAN, 0, WEFT_ERR_ARGUMENT, "pixels"},
        {f.plan, pixels, 1.0, 1.0, 0, WEFT_ERR_ARGUMENT, "from 1 to 1"},
        {f.plan, pixels, 2.0, 1.0, 0, WEFT_ERR_ARGUMENT, "from 2 to 1"},
        {f.plan, pixels, NAN, 1.0, 0, WEFT_ERR_ARGUMENT, "range"},
        {f.plan, pixels, 0.0, INFINITY, 0, WEFT_ERR_ARGUMENT, "range"},
        {f.plan, pixels, NAN, NAN, 1000, WEFT_ERR_LIMIT, "1000 bytes"},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct weft_slice_passes passes = good;
        passes.plan = cases[i].plan;
        passes.low = cases[i].low;
        passes.high = cases[i].high;
        passes.memory_bytes = cases[i].memory_bytes;
        passes.log = &log;
        message.count = 0;
        assert_int_equal(run_passes(contexts[0], &f, &passes, cases[i].pixels, NULL),
                         cases[i].expected);
        assert_int_equal(message.count, 1);
        if (!strstr(message.text, cases[i].text))
            fail_msg("'%s' is not in '%s'", cases[i].text, message.text);
    }
    free(pixels);
    weft_pass_plan_destroy(&other_plan);
    weft_pass_plan_destroy(&flat);
    tear_down(&f);
    weft_volume_destroy(&volume);
}

// Voxels so far apart that no rectangle has a box.
static void far_apart_pixels_are_refused_with_numbers(void **state)
{
    (void)state;
    weft_volume *volume = make_volume(make_voxels("ramp", 0.0, 1.0), 0.0f);
    const struct weft_slice_geometry g = {
        .origin = {-1e6, -1e6, 8}, .u = {2e6, 0, 0}, .v = {0, 2e6, 0}, .width = 100, .height = 100};
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    struct fixture f;
    set_up(&f, volume, &g, &small_method);
    struct weft_slice_passes passes = passes_of(&f);
    weft_slice *slice = NULL;
    passes.log = &log;
    // Before anything is run.
    assert_int_equal(
        weft_slice_compile(
            f.slice, weft_slice_compile_params(.context = contexts[0], .passes = &passes), &slice),
        WEFT_ERR_LIMIT);
    assert_null(slice);
    assert_int_equal(message.count, 1);
    assert_non_null(strstr(message.text, "2048 voxels"));
    tear_down(&f);
    weft_volume_destroy(&volume);
}

struct count_down {
    int left, calls;
    double last;
    bool falls;
};

static bool count(void *priv, double fraction)
{
    struct count_down *c = priv;
    c->calls++;
    c->falls = c->falls || fraction < c->last || fraction > 1.0;
    c->last = fraction;
    return c->left-- > 0;
}

static void progress_rises_and_cancels(void **state)
{
    (void)state;
    weft_volume *volume = make_volume(make_voxels("ramp", 0.0, 1.0), 0.0f);
    const struct weft_slice_geometry g = oblique(300, 300);
    struct fixture f;
    set_up(&f, volume, &g, &small_method);
    float *pixels = make_pixels(&f);
    struct weft_slice_passes passes = passes_of(&f);
    struct count_down counter = {.left = INT32_MAX};
    const struct weft_progress progress = {count, &counter};
    const struct weft_slice_run_params run_params = {.pixels = pixels, .progress = &progress};
    weft_slice *slice = NULL;
    passes.log = NULL;
    assert_int_equal(
        weft_slice_compile(
            f.slice, weft_slice_compile_params(.context = contexts[0], .passes = &passes), &slice),
        WEFT_OK);
    assert_int_equal(weft_slice_run(slice, &run_params, NULL), WEFT_OK);
    assert_false(counter.falls);
    assert_true(counter.last == 1.0);
    // The voxels in reach are measured once.
    const int first_calls = counter.calls;
    counter = (struct count_down){.left = INT32_MAX};
    assert_int_equal(weft_slice_run(slice, &run_params, NULL), WEFT_OK);
    const int calls = counter.calls;
    assert_true(calls > 6 && calls < first_calls);
    for (int left = 0; left < calls - 2; left += 1 + calls / 8) {
        counter = (struct count_down){.left = left};
        assert_int_equal(weft_slice_run(slice, &run_params, NULL), WEFT_ERR_CANCELLED);
    }
    weft_slice_destroy(&slice);
    free(pixels);
    tear_down(&f);
    weft_volume_destroy(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slices_stay_within_the_bound),
        cmocka_unit_test(fine_tiles_come_close_to_one_pass),
        cmocka_unit_test(gl_and_emulation_agree_in_every_bit),
        cmocka_unit_test(cutting_changes_no_bit),
        cmocka_unit_test(the_range_is_that_of_the_voxels_in_reach),
        cmocka_unit_test(a_declared_range_clamps),
        cmocka_unit_test(beside_the_volume_is_background),
        cmocka_unit_test(sparse_volumes_read_the_bricks_in_reach_only),
        cmocka_unit_test(not_finite_voxels_stay_in_reach),
        cmocka_unit_test(bad_arguments_are_refused),
        cmocka_unit_test(far_apart_pixels_are_refused_with_numbers),
        cmocka_unit_test(progress_rises_and_cancels),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
