// SPDX-License-Identifier: BSD-3-Clause
// Images at smaller and larger sizes: kernels stretched for minification, boundaries and clamping,
// on every engine, beside a reference of this file's own and beside the verifier; what aliases.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tests/passes/separable/wheres.h"

enum { MOST = 260 * 260 };

// ---- a run --------------------------------------------------------------------------------------

struct request {
    const char *kernel;
    int from[2], to[2];
    struct weft_window_map map[2];
    enum weft_boundary boundary;
    double border;
    bool unstretched, clamp;
    const struct where *where;
    struct weft_rectangle part;
};

struct work {
    weft_resample_plan *plan;
    weft_resample_source *source;
    struct weft_resample_report report;
    struct weft_verify_report error;
    double bound;
};

static float pixels[MOST];

// Plans, runs and verifies; the pixels lie tightly packed.
static struct work run_to(const struct request *r, const float *samples, float *out)
{
    struct work w = {0};
    weft_resample_compiled *compiled = NULL;
    const struct weft_kernel kernel = kernel_named(r->kernel);
    const struct where *where = r->where ? r->where : &wheres[first_cpu];
    assert_int_equal(
        weft_resample_plan_create(
            weft_resample_params(.kernel = kernel, .size = {r->from[0], r->from[1]},
                                 .width = r->to[0], .height = r->to[1],
                                 .map = {r->map[0], r->map[1]}, .boundary = r->boundary,
                                 .unstretched = r->unstretched, .clamp = r->clamp,
                                 .engine = where->engine, .sums = where->sums,
                                 .log = &log_to_stderr),
            &w.plan),
        WEFT_OK);
    assert_int_equal(
        weft_resample_source_create(
            weft_resample_source_params(.kernel = kernel, .width = r->from[0], .height = r->from[1],
                                        .plane = {samples}, .boundary = r->boundary,
                                        .border = r->border, .log = &log_to_stderr),
            &w.source),
        WEFT_OK);
    assert_int_equal(
        weft_resample_compile(w.plan,
                              weft_resample_compile_params(.context = where->compile.context,
                                                           .cpu = where->compile.cpu),
                              &compiled),
        WEFT_OK);
    assert_int_equal(
        weft_resample_run(compiled,
                          weft_resample_run_params(.source = w.source, .part = r->part,
                                                   .plane = {out}, .log = &log_to_stderr),
                          &w.report),
        WEFT_OK);
    weft_resample_compiled_destroy(&compiled);
    assert_int_equal(
        weft_resample_verify(w.plan,
                             &(struct weft_resample_verify_params){.source = w.source,
                                                                   .part = r->part,
                                                                   .plane = {out},
                                                                   .how = {.max_seconds = 0.02},
                                                                   .log = &log_to_stderr},
                             &w.error),
        WEFT_OK);
    w.bound = weft_resample_bound(w.plan, &weft_resample_source_get_info(w.source)->statistics,
                                  weft_statistics_magnitude(&w.report.pixels))
                  .total;
    if (!(w.error.maximum <= w.bound) || w.error.not_finite_mismatches || !w.error.pixels_checked)
        fail_msg("%s, %d x %d to %d x %d, %s, on %s: error %.3g of %.3g at (%d, %d), %g not %g",
                 r->kernel, r->from[0], r->from[1], r->to[0], r->to[1],
                 weft_boundary_names[r->boundary], where->name, w.error.maximum, w.bound,
                 w.error.at_x, w.error.at_y, w.error.at_value, w.error.at_reference);
    return w;
}

static void clear(struct work *w)
{
    weft_resample_source_destroy(&w->source);
    weft_resample_plan_destroy(&w->plan);
}

static void run(const struct request *r, const float *samples)
{
    struct work w = run_to(r, samples, pixels);
    clear(&w);
}

static float *make_samples(int width, int height)
{
    float *samples = malloc((size_t)width * (size_t)height * sizeof *samples);
    assert_non_null(samples);
    for (int i = 0; i < width * height; i++)
        samples[i] = (float)sin(0.31 * (i % width)) * 3.0f +
                     (float)((uint32_t)(i + 1) * 2654435761u >> 9 & 1023) / 1024.0f;
    return samples;
}

// ---- this file's own reference ------------------------------------------------------------------

// The definition, written anew: sum of h((x - i) / s), divided by the sum of weights.
static double along(const struct weft_kernel *kernel, double at, double scale, int size,
                    const struct request *r, double (*sample)(const void *priv, int i),
                    const void *priv)
{
    double sum = 0.0, weights = 0.0;
    const int reach = (int)ceil(kernel->support * scale) + 1;
    for (int i = (int)floor(at) - reach; i <= (int)floor(at) + reach + 1; i++) {
        const double w = weft_kernel_weight(kernel, (at - i) / scale);
        const int64_t k = weft_boundary_index(r->boundary, i, size);
        weights += w;
        sum += w * (k < 0 ? r->border : sample(priv, (int)k));
    }
    return sum / weights;
}

struct plane {
    const struct weft_kernel *kernel;
    const struct request *r;
    const float *samples;
    double x, scale[2];
    int row;
};

static double sample_of(const void *priv, int x)
{
    const struct plane *p = priv;
    return (double)p->samples[p->row * p->r->from[0] + x];
}

static double row_of(const void *priv, int y)
{
    struct plane p = *(const struct plane *)priv;
    p.row = y;
    return along(p.kernel, p.x, p.scale[0], p.r->from[0], p.r, sample_of, &p);
}

static double reference(const struct request *r, const float *samples, int x, int y)
{
    const struct weft_kernel kernel = kernel_named(r->kernel);
    struct plane p = {.kernel = &kernel, .r = r, .samples = samples};
    for (int a = 0; a < 2; a++)
        p.scale[a] = fmax(1.0, (double)r->from[a] / r->to[a]);
    p.x = (x + 0.5) * r->from[0] / r->to[0] - 0.5;
    return along(&kernel, (y + 0.5) * r->from[1] / r->to[1] - 0.5, p.scale[1], r->from[1], r,
                 row_of, &p);
}

// ---- tests --------------------------------------------------------------------------------------

static const struct {
    int from[2], to[2];
} shapes[] = {
    {{23, 17}, {92, 68}},  // up 4 times
    {{111, 74}, {30, 20}}, // down 3.7 times
    {{96, 112}, {6, 7}},   // down 16 times
    {{63, 20}, {9, 60}},   // down by an odd factor along x, up along y
    {{40, 31}, {1, 1}},    // to one pixel, of which kernels reach far beyond
    {{1, 5}, {3, 2}},      // of one sample
};

static const char *const kernels[] = {"lanczos:3+unit", "catmull-rom", "mitchell", "linear",
                                      "area"};

static void sizes_meet_the_reference(void **state)
{
    (void)state;
    int runs = 0;
    for (size_t s = 0; s < WEFT_COUNT(shapes); s++) {
        float *samples = make_samples(shapes[s].from[0], shapes[s].from[1]);
        for (size_t k = 0; k < WEFT_COUNT(kernels); k++)
            for (int b = 0; b < WEFT_BOUNDARY_COUNT; b++, runs++) {
                struct request r = {.kernel = kernels[k],
                                    .from = {shapes[s].from[0], shapes[s].from[1]},
                                    .to = {shapes[s].to[0], shapes[s].to[1]},
                                    .boundary = (enum weft_boundary)b,
                                    .border = 2.5,
                                    .where = &wheres[runs % where_count]};
                struct work w = run_to(&r, samples, pixels);
                const bool box = strcmp(kernels[k], "area") == 0; // whose weights are no samples
                for (int i = 0; !box && i < r.to[0] * r.to[1]; i += 1 + r.to[0] * r.to[1] / 40)
                    assert_near((double)pixels[i], reference(&r, samples, i % r.to[0], i / r.to[0]),
                                w.bound + 1e-12, kernels[k]);
                clear(&w);
            }
        free(samples);
    }
    assert_true(runs == (int)(WEFT_COUNT(shapes) * WEFT_COUNT(kernels) * WEFT_BOUNDARY_COUNT));
}

// All instruction sets in either sums, and OpenGL, of the same plan.
static void engines_meet_the_reference(void **state)
{
    (void)state;
    float *samples = make_samples(201, 74);
    for (int w = 0; w < where_count; w++)
        for (int b = 0; b < WEFT_BOUNDARY_COUNT; b++)
            run(&(struct request){.kernel = "lanczos:3+unit",
                                  .from = {201, 74},
                                  .to = {54, 20},
                                  .boundary = (enum weft_boundary)b,
                                  .border = -1.0,
                                  .where = &wheres[w]},
                samples);
    free(samples);
}

// Coefficients of mirrored, periodic and bordered signals, beside the cardinal spline.
static void prefilters_keep_to_the_boundary(void **state)
{
    (void)state;
    static const char *const splines[] = {"bspline3i", "bspline5i", "omomsi"};
    static const int sizes[][2] = {{23, 17}, {3, 2}, {1, 9}};
    for (size_t s = 0; s < WEFT_COUNT(sizes); s++) {
        float *samples = make_samples(sizes[s][0], sizes[s][1]);
        for (size_t k = 0; k < WEFT_COUNT(splines); k++)
            for (int b = 0; b < WEFT_BOUNDARY_COUNT; b++)
                run(&(struct request){.kernel = splines[k],
                                      .from = {sizes[s][0], sizes[s][1]},
                                      .to = {4 * sizes[s][0] + 1, 3 * sizes[s][1]},
                                      .boundary = (enum weft_boundary)b,
                                      .border = 2.0},
                    samples);
        free(samples);
    }
}

// A mirrored picture becomes the mirrored result: of sums in double, bit by bit.
static void mirrored_input_gives_mirrored_output(void **state)
{
    (void)state;
    enum { W = 74, H = 37, TO = 20, ROWS = 10 };
    static float other[MOST], back[W * H];
    float *samples = make_samples(W, H);
    for (int i = 0; i < W * H; i++)
        back[i] = samples[i / W * W + W - 1 - i % W];
    for (int b = 0; b < WEFT_BOUNDARY_COUNT; b++) {
        struct request r = {.kernel = "lanczos:3+unit",
                            .from = {W, H},
                            .to = {TO, ROWS},
                            .boundary = (enum weft_boundary)b};
        struct work w = run_to(&r, samples, pixels), mirrored = run_to(&r, back, other);
        for (int i = 0; i < TO * ROWS; i++)
            assert_near((double)other[i], (double)pixels[i / TO * TO + TO - 1 - i % TO],
                        2.0 * w.bound, "mirrored");
        clear(&w);
        clear(&mirrored);
    }
    free(samples);
}

static void constants_stay_exact(void **state)
{
    (void)state;
    static float grey[64 * 64];
    for (int i = 0; i < 64 * 64; i++)
        grey[i] = 0.18f;
    int exact = 0;
    for (int w = first_cpu; w < where_count; w++)
        for (size_t k = 0; k < WEFT_COUNT(kernels); k++) {
            const bool wide = wheres[w].sums == WEFT_SUMS_DOUBLE;
            run(&(struct request){.kernel = kernels[k],
                                  .from = {64, 64},
                                  .to = {17, 9},
                                  .boundary = (enum weft_boundary)(w % 3),
                                  .clamp = !wide,
                                  .where = &wheres[w]},
                grey);
            for (int i = 0; i < 17 * 9; i++, exact++)
                assert_true(pixels[i] == 0.18f);
        }
    assert_true(exact > 0);
}

// Pixels are held between samples; without it they overshoot, so that both cases are met.
static void clamped_pixels_do_not_overshoot(void **state)
{
    (void)state;
    static float step[48 * 40];
    int beyond[2] = {0};
    for (int i = 0; i < 48 * 40; i++)
        step[i] = i % 48 < 24 ? 0.25f : 0.75f;
    static const int sizes[][2] = {{150, 61}, {17, 13}};
    for (int clamp = 0; clamp < 2; clamp++)
        for (size_t s = 0; s < WEFT_COUNT(sizes); s++) {
            run(&(struct request){.kernel = "lanczos:3+unit",
                                  .from = {48, 40},
                                  .to = {sizes[s][0], sizes[s][1]},
                                  .clamp = clamp},
                step);
            for (int i = 0; i < sizes[s][0] * sizes[s][1]; i++)
                beyond[clamp] += pixels[i] < 0.25f || pixels[i] > 0.75f;
        }
    assert_true(beyond[0] > 100 && beyond[1] == 0);
}

// Parts have the whole's bits, whatever is stretched and whatever stands beyond.
static void parts_have_the_bits_of_the_whole(void **state)
{
    (void)state;
    static float part[MOST];
    float *samples = make_samples(111, 74);
    int same = 0;
    for (int w = 0; w < where_count; w++)
        for (int b = 0; b < WEFT_BOUNDARY_COUNT; b++) {
            struct request r = {.kernel = b % 2 ? "lanczos:3+unit" : "area",
                                .from = {111, 74},
                                .to = {30, 20},
                                .boundary = (enum weft_boundary)b,
                                .border = 7.0,
                                .clamp = b == 1,
                                .where = &wheres[w]};
            run(&r, samples);
            r.part = (struct weft_rectangle){3, 5, 17, 9};
            struct work of = run_to(&r, samples, part);
            const struct weft_rectangle reach = weft_resample_reach(of.plan, &r.part);
            assert_true(reach.x >= 0 && reach.y >= 0 && reach.x + reach.width <= 111 &&
                        reach.y + reach.height <= 74);
            for (int y = 0; y < 9; y++, same++)
                assert_memory_equal(part + 17 * y, pixels + (5 + y) * 30 + 3, 17 * sizeof *part);
            clear(&of);
        }
    assert_int_equal(same, where_count * WEFT_BOUNDARY_COUNT * 9);
    free(samples);
}

// ---- aliasing -----------------------------------------------------------------------------------

// The response of the stretched weights at the centre of a pixel to a wave along an axis: what is
// left of it, at most, wherever the pixel lies.
static double left_of(const struct weft_kernel *kernel, double scale, double frequency)
{
    double most = 0.0;
    static double weights[4096];
    const int width = (int)weft_stretch_width(kernel, scale);
    assert_true(width > 0 && width <= 4096);
    for (int p = 0; p < 16; p++) {
        double re = 0.0, im = 0.0;
        const int64_t first = weft_stretch_weights(kernel, scale, p / 16.0, weights);
        for (int i = 0; i < width; i++) {
            re += weights[i] * cos(2.0 * acos(-1.0) * frequency * (double)(first + i));
            im += weights[i] * sin(2.0 * acos(-1.0) * frequency * (double)(first + i));
        }
        most = fmax(most, hypot(re, im));
    }
    return most;
}

// Waves that the pixels cannot show: what is left of each is what the response allows. Nothing of
// it is filtered away where the kernel is not stretched.
static void waves_leave_what_the_response_allows(void **state)
{
    (void)state;
    enum { SIZE = 222, TO = 60, ROWS = 8 };
    static float wave[SIZE * ROWS];
    const double scale = 3.7;
    double alias = 0.0;
    for (size_t k = 0; k < WEFT_COUNT(kernels); k++) {
        const struct weft_kernel kernel = kernel_named(kernels[k]);
        for (double frequency = 0.5 / scale; frequency <= 0.5; frequency += 0.03) {
            for (int i = 0; i < SIZE * ROWS; i++)
                wave[i] = (float)cos(2.0 * acos(-1.0) * frequency * (i % SIZE));
            struct request r = {.kernel = kernels[k],
                                .from = {SIZE, ROWS},
                                .to = {TO, ROWS},
                                .boundary = WEFT_BOUNDARY_MIRROR};
            const double allowed = left_of(&kernel, scale, frequency);
            run(&r, wave);
            for (int x = 8; x < TO - 8; x++)
                assert_true(fabs((double)pixels[x]) <= allowed + 0.01);
            r.unstretched = true;
            run(&r, wave);
            for (int x = 8; x < TO - 8; x++)
                alias = fmax(alias, fabs((double)pixels[x]));
        }
    }
    assert_true(alias > 0.9);
    // Far beyond the pixels' frequencies little is allowed.
    const struct weft_kernel lanczos = kernel_named("lanczos:3+unit");
    assert_true(left_of(&lanczos, scale, 0.45) < 0.02);
}

// A zone plate's rings come within the pixels' frequencies in its middle, and turn grey outside;
// a checkerboard turns grey altogether.
static void zone_plates_turn_grey(void **state)
{
    (void)state;
    enum { SIZE = 512, TO = 128 };
    static float plate[SIZE * SIZE];
    for (int i = 0; i < SIZE * SIZE; i++) {
        const double x = i % SIZE - 0.5 * (SIZE - 1), y = (int)(i / SIZE) - 0.5 * (SIZE - 1);
        plate[i] = (float)(0.5 + 0.5 * cos(acos(-1.0) * 0.5 / (0.5 * SIZE) * (x * x + y * y)));
    }
    struct request r = {.kernel = "lanczos:3+unit", .from = {SIZE, SIZE}, .to = {TO, TO}};
    run(&r, plate);
    double middle = 0.0, outside = 0.0;
    for (int i = 0; i < TO * TO; i++) {
        const double x = i % TO - 0.5 * (TO - 1), y = (int)(i / TO) - 0.5 * (TO - 1);
        const double contrast = fabs((double)pixels[i] - 0.5), radius = hypot(x, y);
        // Half a wave per sample at the edge: an eighth, which pixels show, at a quarter of it.
        if (radius < 0.2 * 0.5 * TO)
            middle = fmax(middle, contrast);
        else if (radius > 0.5 * 0.5 * TO && radius < 0.48 * TO)
            outside = fmax(outside, contrast);
    }
    assert_true(middle > 0.45 && outside < 0.05);
    for (int i = 0; i < SIZE * SIZE; i++)
        plate[i] = (float)((i % SIZE + i / SIZE) % 2);
    r.boundary = WEFT_BOUNDARY_MIRROR; // which continues it
    run(&r, plate);
    for (int i = 0; i < TO * TO; i++)
        assert_near((double)pixels[i], 0.5, 1e-3, "a checkerboard");
}

// ---- what cannot be -----------------------------------------------------------------------------

static void refused(struct weft_resample_params params, enum weft_result result, const char *text)
{
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    weft_resample_plan *plan = NULL;
    params.log = &log;
    assert_int_equal(weft_resample_plan_create(&params, &plan), result);
    assert_null(plan);
    if (!strstr(message.text, text))
        fail_msg("'%s' without '%s'", message.text, text);
}

static void what_cannot_be_stretched_is_refused(void **state)
{
    (void)state;
    weft_pass_plan *passes = NULL;
    assert_int_equal(weft_pass_plan_create(
                         weft_pass_plan_params(.kernel = kernel_named("catmull-rom")), &passes),
                     WEFT_OK);
    struct weft_resample_params down =
        *weft_resample_params(.passes = passes, .size = {40, 40}, .width = 20, .height = 20);
    refused(down, WEFT_ERR_UNSUPPORTED, "which passes do not");
    down.unstretched = true;
    down.boundary = WEFT_BOUNDARY_WRAP;
    refused(down, WEFT_ERR_UNSUPPORTED, "not wrap");
    down = *weft_resample_params(.kernel = kernel_named("bspline3i"), .size = {40, 40}, .width = 20,
                                 .height = 20);
    refused(down, WEFT_ERR_UNSUPPORTED, "mitchell");
    down.kernel = kernel_named("mitchell");
    down.boundary = (enum weft_boundary)9;
    refused(down, WEFT_ERR_ARGUMENT, "boundary");
    weft_pass_plan_destroy(&passes);
    static const double at[2] = {0.0, 1.0};
    struct weft_separable_params wide =
        *weft_separable_params(.kernel = kernel_named("lanczos:3+unit"), .size = {9, 9}, .width = 2,
                               .height = 1, .x = at, .y = at, .stretch = {1e8, 1.0});
    weft_separable_plan *plan = NULL;
    assert_int_equal(weft_separable_plan_create(&wide, &plan), WEFT_ERR_ARGUMENT);
    wide.stretch[0] = WEFT_STRETCH_MAX;
    wide.kernel = kernel_named("lanczos:8");
    assert_int_equal(weft_separable_plan_create(&wide, &plan), WEFT_ERR_LIMIT);
    assert_null(plan);
}

// ---- images of the data folder ------------------------------------------------------------------

static void pictures_meet_the_reference(void **state)
{
    (void)state;
    static const char *const names[] = {"BrightRings",   "BrightRingsNanInf", "GammaChart",
                                        "SquaresSwirls", "WideFloatRange",    "stripes"};
    for (size_t i = 0; i < WEFT_COUNT(names); i++) {
        char path[512];
        struct weft_image image;
        snprintf(path, sizeof path, "%s/%s.exr", WEFT_TEST_DATA, names[i]);
        if (access(path, R_OK) != 0) {
            print_message("[  SKIPPED ] %s is not here\n", path);
            continue;
        }
        assert_int_equal(weft_image_load(&(struct weft_image_load_params){.path = path}, &image),
                         WEFT_OK);
        const double factors[] = {4.0, 1.0 / 3.7};
        for (int f = 0; f < 2; f++) {
            struct request r = {.kernel = "lanczos:3+unit",
                                .from = {image.width, image.height},
                                .where = &wheres[where_count - 2]};
            for (int a = 0; a < 2; a++)
                r.to[a] = (int)fmax(1.0, floor(r.from[a] * factors[f] + 0.5));
            float *out = malloc((size_t)r.to[0] * (size_t)r.to[1] * sizeof *out);
            assert_non_null(out);
            struct work w = run_to(&r, image.channels[0].plane, out);
            clear(&w);
            free(out);
        }
        weft_image_clear(&image);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sizes_meet_the_reference),
        cmocka_unit_test(engines_meet_the_reference),
        cmocka_unit_test(prefilters_keep_to_the_boundary),
        cmocka_unit_test(mirrored_input_gives_mirrored_output),
        cmocka_unit_test(constants_stay_exact),
        cmocka_unit_test(clamped_pixels_do_not_overshoot),
        cmocka_unit_test(parts_have_the_bits_of_the_whole),
        cmocka_unit_test(waves_leave_what_the_response_allows),
        cmocka_unit_test(zone_plates_turn_grey),
        cmocka_unit_test(what_cannot_be_stretched_is_refused),
        cmocka_unit_test(pictures_meet_the_reference),
    };
    return cmocka_run_group_tests(tests, create_wheres, destroy_wheres);
}
