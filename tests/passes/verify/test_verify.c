// SPDX-License-Identifier: BSD-3-Clause
// The verifier itself: errors of known size in known places are found, by every engine's call; what
// is finite on one side only is one; and the same pixels are looked at every time.

#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "tests/support/contexts.h"
#include "tests/support/plan_runs.h"
#include "weft.h"

// ---- the rule -----------------------------------------------------------------------------------

enum verdict { COMPARED, AGREED, MISMATCH };

static void the_rule_is_one(void **state)
{
    static const double big = 1e39; // beyond the range of floats
    static const struct {
        double value, reference;
        enum verdict verdict;
        double error;
    } cases[] = {
        {1.0, 1.0, COMPARED, 0.0},
        {1.5, 1.0, COMPARED, 0.5},
        {-1.5, 1.0, COMPARED, 2.5},
        {FLT_MAX, 2.0 * (double)FLT_MAX, COMPARED, 0.0}, // the range's end
        {INFINITY, big, AGREED, 0.0},
        {-INFINITY, -big, AGREED, 0.0},
        {-INFINITY, big, MISMATCH, INFINITY}, // the other end
        {NAN, big, MISMATCH, INFINITY},
        {INFINITY, FLT_MAX, MISMATCH, INFINITY},
        {NAN, 0.0, MISMATCH, INFINITY},
        {0.0, NAN, MISMATCH, INFINITY},
        {0.0, INFINITY, MISMATCH, INFINITY},
        {NAN, NAN, AGREED, 0.0},
        {INFINITY, NAN, AGREED, 0.0},
        {-INFINITY, INFINITY, AGREED, 0.0},
    };
    int verdicts[3] = {0};
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct weft_verify_report r = {.bound_absolute = NAN};
        const struct weft_reference_value reference = {cases[i].reference, 2.0};
        weft_verify_add(&r, 3, 4, 1, cases[i].value, &reference);
        verdicts[cases[i].verdict]++;
        if (r.values_compared != (cases[i].verdict == COMPARED) ||
            r.not_finite_mismatches != (cases[i].verdict == MISMATCH) ||
            !(r.maximum == cases[i].error) || !(r.relative_maximum == cases[i].error / 2.0))
            fail_msg("%g instead of %g: error %g, relative %g", cases[i].value, cases[i].reference,
                     r.maximum, r.relative_maximum);
        if (cases[i].verdict != AGREED)
            assert_true(r.at_x == 3 && r.at_y == 4 && r.at_channel == 1);
    }
    assert_true(verdicts[COMPARED] && verdicts[AGREED] && verdicts[MISMATCH]);
}

// A mismatch stays the maximum, where it was first; what is compared goes on being counted.
static void mismatches_are_the_maximum(void **state)
{
    struct weft_verify_report r = {.bound_absolute = 1.0};
    const struct weft_reference_value one = {1.0, 1.0}, none = {NAN, 1.0};
    (void)state;
    weft_verify_add(&r, 0, 0, 0, 1.5, &one);
    assert_true(r.maximum == 0.5 && r.share == 0.5 && r.at_x == 0);
    weft_verify_add(&r, 1, 0, 0, 1.0, &none);
    weft_verify_add(&r, 2, 0, 0, NAN, &one);
    weft_verify_add(&r, 3, 0, 0, 4.0, &one);
    assert_true(isinf(r.maximum) && isinf(r.relative_maximum) && isinf(r.share) && r.at_x == 1);
    assert_true(r.at_value == 1.0 && isnan(r.at_reference));
    assert_int_equal(r.not_finite_mismatches, 2);
    assert_int_equal(r.values_compared, 2);
    assert_near(r.rms, sqrt((0.25 + 9.0) / 2.0), 1e-15, "rms of what is compared");
}

static void bounds_have_both_verdicts(void **state)
{
    (void)state;
    for (int within = 0; within < 2; within++) {
        // 0.25 of the largest sample in the pixel's own reach, and as much as that is less.
        struct weft_verify_report r = {.bound_relative = 0.25, .bound_absolute = 0.01};
        const struct weft_reference_value small = {0.0, 1.0}, large = {0.0, 100.0};
        weft_verify_add(&r, 0, 0, 0, 20.0, &large);
        weft_verify_add(&r, 1, 0, 0, within ? 0.13 : 0.52, &small);
        assert_near(r.bound, 25.01, 1e-12, "the bound at the largest sample");
        assert_true(r.maximum == 20.0 && r.at_x == 0);
        // The largest error is within its bound; the small one tells.
        assert_near(r.share, within ? 20.0 / 25.01 : 2.0, 1e-12, "share");
        assert_true((r.share <= 1.0) == (within == 1));
        assert_near(r.relative_maximum, within ? 0.2 : 0.52, 1e-15, "relative");
    }
    struct weft_verify_report none = {.bound_absolute = NAN};
    weft_verify_add(&none, 0, 0, 0, 1.0, &(struct weft_reference_value){0.0, 1.0});
    assert_true(isnan(none.bound) && isnan(none.share));
    struct weft_verify_report zero = {0};
    weft_verify_add(&zero, 0, 0, 0, 1.0, &(struct weft_reference_value){1.0, 1.0});
    assert_true(zero.share == 0.0);
    weft_verify_add(&zero, 0, 0, 0, 1.5, &(struct weft_reference_value){1.0, 0.0});
    assert_true(isinf(zero.share) && isinf(zero.relative_maximum) && zero.maximum == 0.5);
}

// ---- pixels in memory ---------------------------------------------------------------------------

enum { SIDE = 12, WIDTH = 23, HEIGHT = 17, STRIDE = 29, SAMPLE_STRIDE = 15 };

// Linear interpolation keeps a plane: 2 x - 3 y + 5, and channel by channel 10 more.
struct image {
    float samples[4][SIDE * SAMPLE_STRIDE], pixels[4][HEIGHT * STRIDE];
    double columns[WIDTH], rows[HEIGHT];
    struct weft_pixel_grid grid;
    struct weft_pixels_verify_params params;
};

static struct image *make_image(const char *kernel, int channels)
{
    struct image *m = malloc(sizeof *m);
    assert_non_null(m);
    memset(m->samples, 0xff, sizeof m->samples); // NAN where nobody may look
    memset(m->pixels, 0xff, sizeof m->pixels);
    for (int x = 0; x < WIDTH; x++)
        m->columns[x] = 2.0 + 7.0 * x / WIDTH;
    for (int y = 0; y < HEIGHT; y++)
        m->rows[y] = 2.0 + 7.0 * y / HEIGHT;
    m->grid = (struct weft_pixel_grid){
        .width = WIDTH, .height = HEIGHT, .columns = m->columns, .rows = m->rows};
    m->params = *weft_pixels_verify_params(.kernel = {kernel_named(kernel)}, .grid = &m->grid,
                                           .size = {SIDE, SIDE}, .channels = channels,
                                           .log = &log_to_stderr);
    for (int c = 0; c < channels; c++) {
        for (int y = 0; y < SIDE; y++)
            for (int x = 0; x < SIDE; x++)
                m->samples[c][y * SAMPLE_STRIDE + x] = 2.0f * x - 3.0f * y + 5.0f + 10.0f * c;
        for (int y = 0; y < HEIGHT; y++)
            for (int x = 0; x < WIDTH; x++)
                m->pixels[c][y * STRIDE + x] =
                    (float)(2.0 * m->columns[x] - 3.0 * m->rows[y] + 5.0 + 10.0 * c);
        m->params.samples[c] =
            (struct weft_verify_plane){.values = m->samples[c], .stride = SAMPLE_STRIDE};
        m->params.pixels[c] = (struct weft_verify_plane){.values = m->pixels[c], .stride = STRIDE};
    }
    return m;
}

static struct weft_verify_report verify_image(const struct image *m)
{
    struct weft_verify_report report;
    assert_int_equal(weft_pixels_verify(&m->params, &report), WEFT_OK);
    return report;
}

static void planted_errors_are_found(void **state)
{
    static const char *const kernels[] = {"linear", "catmull-rom", "bspline3"};
    int planted = 0;
    (void)state;
    for (size_t k = 0; k < WEFT_COUNT(kernels); k++) {
        for (int i = 0; i < 12; i++) {
            struct image *m = make_image(kernels[k], 1 + i % 4);
            const int x = i * 7 % WIDTH, y = i * 5 % HEIGHT, c = i % (1 + i % 4);
            const struct weft_verify_report clean = verify_image(m);
            assert_true(clean.maximum < 4e-6 && clean.not_finite_mismatches == 0);
            assert_int_equal(clean.pixels_checked, WIDTH * HEIGHT);
            assert_int_equal(clean.pixels_total, WIDTH * HEIGHT);
            assert_int_equal(clean.values_compared, WIDTH * HEIGHT * (1 + i % 4));
            m->pixels[c][y * STRIDE + x] += 0.25f;
            const struct weft_verify_report r = verify_image(m);
            assert_near(r.maximum, 0.25, 4e-6, kernels[k]);
            assert_true(r.at_x == x && r.at_y == y && r.at_channel == c);
            assert_true(r.at_value == (double)m->pixels[c][y * STRIDE + x]);
            assert_near(r.at_reference, r.at_value - 0.25, 4e-6, "the reference there");
            assert_near(r.rms, 0.25 / sqrt((double)r.values_compared), 1e-6, "rms of one value");
            assert_true(r.magnitude >= 15.0 && r.relative_maximum > 0.25 / 60.0);
            planted++;
            free(m);
        }
    }
    assert_int_equal(planted, 36);
}

static void one_sided_values_are_found(void **state)
{
    (void)state;
    for (int side = 0; side < 3; side++) { // the pixel, the sample, both
        struct image *m = make_image("linear", 1);
        const int x = 9, y = 6;
        // The first tap of that pixel, and all the pixels that it counts for.
        const int tap_x = (int)m->columns[x], tap_y = (int)m->rows[y];
        int touched = 0;
        if (side != 0)
            m->samples[0][tap_y * SAMPLE_STRIDE + tap_x] = NAN;
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            const double dx = fabs(m->columns[i % WIDTH] - tap_x);
            const double dy = fabs(m->rows[i / WIDTH] - tap_y);
            const bool in_reach = dx < 1.0 && dy < 1.0;
            touched += in_reach;
            if (side == 2 && in_reach)
                m->pixels[0][i / WIDTH * STRIDE + i % WIDTH] = NAN;
        }
        if (side == 0)
            m->pixels[0][y * STRIDE + x] = INFINITY;
        const struct weft_verify_report r = verify_image(m);
        assert_true(touched > 4);
        assert_int_equal(r.not_finite_mismatches, side == 0 ? 1 : side == 1 ? touched : 0);
        assert_true(isinf(r.maximum) == (side != 2));
        assert_int_equal(r.values_compared, WIDTH * HEIGHT - (side == 0 ? 1 : touched));
        if (side == 0)
            assert_true(r.at_x == x && r.at_y == y && isinf(r.at_value) &&
                        isfinite(r.at_reference));
        if (side == 1)
            assert_true(isfinite(r.at_value) && isnan(r.at_reference));
        free(m);
    }
}

// Floats would hide the last bits of integers, on either side.
static void integers_are_exact(void **state)
{
    static const uint32_t samples[4] = {UINT32_MAX, UINT32_MAX - 1, 7, 0};
    uint32_t pixels[4] = {UINT32_MAX, UINT32_MAX - 1, 7, 0};
    static const double at[2] = {0.0, 1.0};
    const struct weft_pixel_grid grid = {.width = 2, .height = 2, .columns = at, .rows = at};
    struct weft_pixels_verify_params *params =
        weft_pixels_verify_params(.kernel = {kernel_named("nearest")}, .grid = &grid,
                                  .size = {2, 2},
                                  .samples = {{.values = samples, .type = WEFT_VERIFY_UINT32}},
                                  .pixels = {{.values = pixels, .type = WEFT_VERIFY_UINT32}});
    struct weft_verify_report r;
    (void)state;
    assert_int_equal(weft_pixels_verify(params, &r), WEFT_OK);
    assert_true(r.maximum == 0.0 && r.values_compared == 4);
    pixels[1] = UINT32_MAX;
    assert_int_equal(weft_pixels_verify(params, &r), WEFT_OK);
    assert_true(r.maximum == 1.0 && r.at_x == 1 && r.at_y == 0 && r.rms == 0.5);
}

// One axis' derivative in 1D to 3D, of x^2 + 3 y - z: 2 x by a kernel that keeps parabolas.
static void axes_have_kernels_of_their_own(void **state)
{
    enum { N = 9 };
    static float samples[N * N * N];
    (void)state;
    for (int dims = 1; dims <= 3; dims++) {
        float pixels[5];
        for (int i = 0; i < N * N * N; i++) {
            const int x = i % N, y = i / N % N, z = i / N / N;
            samples[i] = (float)(x * x + (dims > 1 ? 3 * y : 0) - (dims > 2 ? z : 0));
        }
        const struct weft_pixel_grid grid = {
            .width = 5,
            .height = 1,
            .origin = {3.1, dims > 1 ? 4.3 : 0.0, dims > 2 ? 3.6 : 0.0},
            .du = {0.4}};
        struct weft_pixels_verify_params *params =
            weft_pixels_verify_params(.kernel = {kernel_named("catmull-rom"),
                                                 kernel_named("catmull-rom"),
                                                 kernel_named("catmull-rom")},
                                      .dims = dims, .grid = &grid, .size = {N, N, N},
                                      .samples = {{.values = samples}},
                                      .pixels = {{.values = pixels}});
        assert_int_equal(weft_kernel_derive(NULL, &params->kernel[0], &params->kernel[0]), WEFT_OK);
        for (int x = 0; x < 5; x++)
            pixels[x] = (float)(2.0 * (3.1 + 0.4 * x));
        pixels[3] -= 0.5f;
        struct weft_verify_report r;
        assert_int_equal(weft_pixels_verify(params, &r), WEFT_OK);
        assert_near(r.maximum, 0.5, 1e-6, "a derivative");
        assert_true(r.at_x == 3 && r.values_compared == 5);
    }
}

// A cardinal spline passes through its samples, and keeps a plane between them.
static void cardinal_splines_pass_through(void **state)
{
    static const char *const kernels[] = {"bspline3i", "bspline2i", "bspline5i"};
    (void)state;
    for (size_t k = 0; k < WEFT_COUNT(kernels); k++) {
        struct image *m = make_image(kernels[k], 2);
        struct weft_verify_report r;
        m->params.cardinal = true;
        // At samples: whatever they are.
        m->grid.width = m->grid.height = SIDE;
        for (int i = 0; i < SIDE; i++)
            m->columns[i] = m->rows[i] = i;
        for (int c = 0; c < 2; c++)
            for (int i = 0; i < SIDE * SIDE; i++) {
                const float value = (float)((i * 7919 + c * 31) % 101);
                m->samples[c][i / SIDE * SAMPLE_STRIDE + i % SIDE] = value;
                m->pixels[c][i / SIDE * STRIDE + i % SIDE] = value;
            }
        r = verify_image(m);
        // What lies past the overlap for 2^-32 is left out.
        assert_true(r.maximum <= 100.0 * 0x1p-30 && r.values_compared == 2 * SIDE * SIDE);
        assert_true(r.magnitude == 100.0);
        m->pixels[1][3 * STRIDE + 8] += 1.0f;
        r = verify_image(m);
        assert_near(r.maximum, 1.0, 1e-6, kernels[k]);
        assert_true(r.at_x == 8 && r.at_y == 3 && r.at_channel == 1);
        // A missing sample is a missing pixel, with neighbours; others stay as they are.
        m->samples[0][5 * SAMPLE_STRIDE + 5] = NAN;
        r = verify_image(m);
        assert_true(r.not_finite_mismatches > 0 && isinf(r.maximum) && r.at_channel == 0);
        m->params.dims = 3;
        m->params.size[2] = 1;
        assert_int_equal(weft_pixels_verify(&m->params, &r), WEFT_ERR_UNSUPPORTED);
        free(m);
    }
}

// ---- which pixels -------------------------------------------------------------------------------

// The number of pixels in time for so many, of which each is off by its own number.
static struct weft_verify_report sample_image(struct image *m, double seconds, uint64_t seed)
{
    m->params.how = (struct weft_verify_params){.max_seconds = seconds, .seed = seed};
    return verify_image(m);
}

static void samples_of_pixels_repeat(void **state)
{
    enum { N = 300 };
    static float sample = 0.0f, pixels[N * N];
    const struct weft_pixel_grid grid = {.width = N, .height = N};
    struct image m = {.params = *weft_pixels_verify_params(.kernel = {kernel_named("linear")},
                                                           .grid = &grid, .size = {1, 1},
                                                           .samples = {{.values = &sample}},
                                                           .pixels = {{.values = pixels}})};
    (void)state;
    for (int i = 0; i < N * N; i++)
        pixels[i] = (float)(1 + i);
    const struct weft_verify_report all = sample_image(&m, INFINITY, 0);
    assert_int_equal(all.pixels_checked, N * N);
    assert_true(all.maximum == N * N && all.at_x == N - 1 && all.at_y == N - 1);
    const struct weft_verify_report usual = sample_image(&m, 0.0, 0); // 10 s are enough
    assert_int_equal(usual.pixels_checked, N * N);
    // 64 are expected where there is no time at all: 5 standard deviations.
    const struct weft_verify_report few = sample_image(&m, 1e-12, 0);
    assert_in_range(few.pixels_checked, 24, 104);
    assert_int_equal(few.pixels_total, N * N);
    const struct weft_verify_report again = sample_image(&m, 1e-12, 0);
    assert_memory_equal(&few, &again, sizeof few);
    const struct weft_verify_report other = sample_image(&m, 1e-12, 1);
    assert_true(other.squares != few.squares && other.pixels_checked > 0);
    // Twice the time, about twice the pixels, the same ones among them: no sum gets less.
    struct weft_verify_report before = few;
    int doubled = 0;
    for (double seconds = 1e-4; seconds < 0.1; seconds *= 2.0) {
        const struct weft_verify_report r = sample_image(&m, seconds, 0);
        assert_true(r.pixels_checked >= before.pixels_checked && r.squares >= before.squares);
        assert_true(r.maximum >= before.maximum);
        if (before.pixels_checked > 1000 && r.pixels_checked < N * N) {
            assert_near((double)r.pixels_checked / (double)before.pixels_checked, 2.0, 0.2,
                        "for twice the time");
            doubled++;
        }
        before = r;
    }
    assert_true(doubled >= 2);
    // Spread over the image: the mean square of all, 1/3 of the largest.
    const struct weft_verify_report some = sample_image(&m, 3e-3, 7);
    assert_in_range(some.pixels_checked, 2000, N * N - 1);
    assert_near(some.rms / all.rms, 1.0, 0.05, "rms of a sample");
}

static bool refuse(void *priv, double fraction)
{
    int *calls = priv;
    (void)fraction;
    return (*calls)-- > 0;
}

static void bad_places_and_cancelling_end_it(void **state)
{
    struct image *m = make_image("linear", 1);
    struct weft_verify_report r;
    int calls = 3;
    const struct weft_progress progress = {refuse, &calls};
    (void)state;
    m->params.how.progress = &progress;
    assert_int_equal(weft_pixels_verify(&m->params, &r), WEFT_ERR_CANCELLED);
    assert_true(r.pixels_checked == 0 && r.pixels_total == 0);
    m->params.how.progress = NULL;
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    m->params.log = &log;
    m->rows[4] = NAN;
    assert_int_equal(weft_pixels_verify(&m->params, &r), WEFT_ERR_ARGUMENT);
    assert_non_null(strstr(message.text, "(0, 4)"));
    free(m);
}

// ---- the engines' calls -------------------------------------------------------------------------

// Each one's pixels, one of them off; found where it is, and nowhere else.
static void assert_planted(const struct weft_verify_report *clean,
                           const struct weft_verify_report *planted, int x, int y, double error,
                           const char *what)
{
    if (!(clean->maximum < 0.01 * error) || clean->not_finite_mismatches ||
        clean->pixels_checked != clean->pixels_total)
        fail_msg("%s: error %g without any", what, clean->maximum);
    if (planted->at_x != x || planted->at_y != y ||
        !(fabs(planted->maximum - error) <= 2.0 * clean->maximum))
        fail_msg("%s: error %g at (%d, %d) instead of %g at (%d, %d)", what, planted->maximum,
                 planted->at_x, planted->at_y, error, x, y);
}

static void separable_errors_are_found(void **state)
{
    struct image *m = make_image("catmull-rom", 1);
    float samples[SIDE * SIDE];
    struct weft_verify_report clean, planted;
    (void)state;
    for (int i = 0; i < SIDE * SIDE; i++)
        samples[i] = m->samples[0][i / SIDE * SAMPLE_STRIDE + i % SIDE];
    const struct weft_separable_params params = {.kernel = m->params.kernel[0],
                                                 .size = {SIDE, SIDE},
                                                 .width = WIDTH,
                                                 .height = HEIGHT,
                                                 .x = m->columns,
                                                 .y = m->rows};
    const struct weft_separable_run_params run = {
        .samples = samples, .pixels = m->pixels[0], .stride = STRIDE};
    weft_separable_plan *plan = NULL;
    weft_separable *compiled = NULL;
    assert_int_equal(weft_separable_plan_create(&params, &plan), WEFT_OK);
    assert_int_equal(weft_separable_compile(
                         plan, weft_separable_compile_params(.context = contexts[0]), &compiled),
                     WEFT_OK);
    assert_int_equal(weft_separable_run(compiled, &run, NULL), WEFT_OK);
    assert_int_equal(weft_separable_verify(plan, &run, NULL, &clean), WEFT_OK);
    assert_true(clean.share <= 1.0 && clean.maximum <= clean.bound);
    m->pixels[0][11 * STRIDE + 20] -= 2.0f;
    assert_int_equal(weft_separable_verify(plan, &run, NULL, &planted), WEFT_OK);
    assert_planted(&clean, &planted, 20, 11, 2.0, "separable");
    assert_true(planted.share > 1.0 && planted.maximum > planted.bound);
    m->pixels[0][2 * STRIDE + 1] = NAN;
    assert_int_equal(weft_separable_verify(plan, &run, NULL, &planted), WEFT_OK);
    assert_true(planted.not_finite_mismatches == 1 && isinf(planted.maximum) && planted.at_x == 1);
    weft_separable_destroy(&compiled);
    weft_separable_plan_destroy(&plan);
    free(m);
}

static void multipass_errors_are_found(void **state)
{
    struct image *m = make_image("catmull-rom", 1);
    float samples[SIDE * SIDE];
    weft_pass_plan *plan = NULL;
    (void)state;
    for (int i = 0; i < SIDE * SIDE; i++)
        samples[i] = m->samples[0][i / SIDE * SAMPLE_STRIDE + i % SIDE];
    assert_int_equal(weft_pass_plan_create(weft_pass_plan_params(.samples = 64), &plan), WEFT_OK);
    const struct weft_samples source = {.size = {SIDE, SIDE, 1}, .plane = {samples}};
    const struct weft_multipass_run_params params = {.samples = &source,
                                                     .grid = &m->grid,
                                                     .pixels = {m->pixels[0]},
                                                     .stride = STRIDE,
                                                     .log = &log_to_stderr};
    struct weft_verify_report clean, planted;
    assert_int_equal(run_plan(NULL, plan, &params, NULL), WEFT_OK);
    assert_int_equal(verify_plan(plan, &params, &clean), WEFT_OK);
    const double error = 200.0 * clean.maximum;
    m->pixels[0][16 * STRIDE + 22] =
        (float)(2.0 * m->columns[22] - 3.0 * m->rows[16] + 5.0 + error);
    assert_int_equal(verify_plan(plan, &params, &planted), WEFT_OK);
    assert_planted(&clean, &planted, 22, 16, error, "passes");
    m->pixels[0][0] = -INFINITY;
    assert_int_equal(verify_plan(plan, &params, &planted), WEFT_OK);
    assert_true(planted.not_finite_mismatches == 1 && isinf(planted.maximum) && planted.at_x == 0);
    weft_pass_plan_destroy(&plan);
    free(m);
}

static void resampled_errors_are_found(void **state)
{
    static const char *const kernels[] = {"lanczos:3", "bspline3i"};
    struct image *m = make_image("linear", 1);
    (void)state;
    for (size_t k = 0; k < WEFT_COUNT(kernels); k++) {
        weft_resample_plan *plan = NULL;
        weft_resample_compiled *compiled = NULL;
        weft_resample_source *source = NULL;
        struct weft_verify_report clean, planted;
        const struct weft_kernel kernel = kernel_named(kernels[k]);
        assert_int_equal(
            weft_resample_plan_create(weft_resample_params(.kernel = kernel, .size = {SIDE, SIDE},
                                                           .width = WIDTH, .height = HEIGHT),
                                      &plan),
            WEFT_OK);
        assert_int_equal(
            weft_resample_source_create(
                weft_resample_source_params(.kernel = kernel, .width = SIDE, .height = SIDE,
                                            .plane = {m->samples[0]}, .stride = SAMPLE_STRIDE),
                &source),
            WEFT_OK);
        assert_int_equal(weft_resample_compile(
                             plan, weft_resample_compile_params(.context = contexts[0]), &compiled),
                         WEFT_OK);
        const struct weft_resample_run_params run = {
            .source = source, .plane = {m->pixels[0]}, .stride = STRIDE};
        assert_int_equal(weft_resample_run(compiled, &run, NULL), WEFT_OK);
        const struct weft_resample_verify_params verify = {
            .source = source, .plane = {m->pixels[0]}, .stride = STRIDE};
        assert_int_equal(weft_resample_verify(plan, &verify, &clean), WEFT_OK);
        assert_true(clean.maximum <= clean.bound);
        m->pixels[0][5 * STRIDE + 7] += 1.0f;
        assert_int_equal(weft_resample_verify(plan, &verify, &planted), WEFT_OK);
        assert_planted(&clean, &planted, 7, 5, 1.0, kernels[k]);
        assert_true(planted.maximum > planted.bound);
        weft_resample_compiled_destroy(&compiled);
        weft_resample_source_destroy(&source);
        weft_resample_plan_destroy(&plan);
    }
    free(m);
}

static void moved_integers_are_found(void **state)
{
    uint32_t samples[20], pixels[60];
    weft_resample_plan *plan = NULL;
    struct weft_verify_report clean, planted;
    const struct weft_resample_integers source = {.width = 5, .height = 4, .plane = samples};
    (void)state;
    for (int i = 0; i < 20; i++)
        samples[i] = UINT32_MAX - (uint32_t)i;
    assert_int_equal(
        weft_resample_plan_create(weft_resample_params(.kernel = kernel_named("nearest"),
                                                       .size = {5, 4}, .width = 10, .height = 6),
                                  &plan),
        WEFT_OK);
    assert_int_equal(weft_resample_move(plan, &source, NULL, pixels, 0), WEFT_OK);
    assert_int_equal(weft_resample_move_verify(plan, &source, NULL, pixels, 0, NULL, &clean),
                     WEFT_OK);
    assert_true(clean.maximum == 0.0 && clean.bound == 0.0 && clean.share == 0.0);
    pixels[34] ^= 1;
    assert_int_equal(weft_resample_move_verify(plan, &source, NULL, pixels, 0, NULL, &planted),
                     WEFT_OK);
    assert_planted(&clean, &planted, 4, 3, 1.0, "integers");
    assert_true(isinf(planted.share) && planted.maximum > planted.bound);
    weft_resample_plan_destroy(&plan);
}

// Cut into tiles or not, plain and prefiltered.
static void slice_errors_are_found(void **state)
{
    enum { N = 40, PIXELS = 60 };
    static const char *const kernels[] = {"catmull-rom", "nearest", "bspline3i"};
    static float data[N * N * N], pixels[PIXELS * PIXELS];
    (void)state;
    for (int i = 0; i < N * N * N; i++)
        data[i] = (float)(i % N) - 2.0f * (float)(i / N % N) + 0.5f * (float)(i / N / N);
    for (size_t k = 0; k < WEFT_COUNT(kernels); k++) {
        struct weft_verify_report clean, planted, sampled[2];
        uint64_t checked[2];
        int tiles[2];
        for (int cut = 0; cut < 2; cut++) {
            weft_volume *volume = NULL;
            weft_slice_plan *plan = NULL;
            struct weft_slice_params params = {.kernel = kernel_named(kernels[k]),
                                               .space = WEFT_SPACE_INDEX,
                                               .geometry = {.origin = {6.3, 7.1, 12.2},
                                                            .u = {25.0, 4.0, 3.0},
                                                            .v = {-2.0, 22.0, 5.0},
                                                            .width = PIXELS,
                                                            .height = PIXELS},
                                               .layout = WEFT_LAYOUT_INTERLEAVED,
                                               .max_target_size = cut ? PIXELS / 2 : PIXELS};
            assert_int_equal(
                weft_volume_create(weft_volume_params(.size = {N, N, N}, .data = data), &volume),
                WEFT_OK);
            assert_int_equal(weft_slice_plan_create(volume, &params, &plan), WEFT_OK);
            tiles[cut] = weft_slice_plan_get_info(plan)->tile_count;
            assert_int_equal(weft_slice_run_once(plan,
                                                 weft_slice_compile_params(.context = contexts[0]),
                                                 weft_slice_run_params(.pixels = pixels), NULL),
                             WEFT_OK);
            const struct weft_slice_verify_params all = {.max_seconds = INFINITY};
            assert_int_equal(weft_slice_verify(plan, pixels, &all, &clean), WEFT_OK);
            assert_true(clean.maximum <= clean.bound && clean.share <= 1.0);
            const struct weft_slice_verify_params few = {.max_seconds = 1e-12, .seed = 3};
            assert_int_equal(weft_slice_verify(plan, pixels, &few, &sampled[cut]), WEFT_OK);
            checked[cut] = sampled[cut].pixels_checked;
            pixels[41 * PIXELS + 17] += 3.0f;
            assert_int_equal(weft_slice_verify(plan, pixels, &all, &planted), WEFT_OK);
            assert_planted(&clean, &planted, 17, 41, 3.0, kernels[k]);
            assert_true(planted.maximum > planted.bound && planted.share > 1.0);
            pixels[3] = NAN;
            assert_int_equal(weft_slice_verify(plan, pixels, &all, &planted), WEFT_OK);
            assert_true(planted.not_finite_mismatches == 1 && isinf(planted.maximum) &&
                        planted.at_x == 3 && planted.at_y == 0);
            weft_slice_plan_destroy(&plan);
            weft_volume_destroy(&volume);
        }
        assert_true(tiles[0] == 1 && tiles[1] > 1);
        assert_in_range(checked[0], 24, 104);
        assert_int_equal(checked[0], checked[1]); // the same pixels, in any cut
        // One layout: each cut has the same pixels.
        assert_true(sampled[0].maximum == sampled[1].maximum);
        if (k == 0) // of nearest it is the first that each cut comes by
            assert_true(sampled[0].at_x == sampled[1].at_x && sampled[0].at_y == sampled[1].at_y);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_rule_is_one),
        cmocka_unit_test(mismatches_are_the_maximum),
        cmocka_unit_test(bounds_have_both_verdicts),
        cmocka_unit_test(planted_errors_are_found),
        cmocka_unit_test(one_sided_values_are_found),
        cmocka_unit_test(integers_are_exact),
        cmocka_unit_test(axes_have_kernels_of_their_own),
        cmocka_unit_test(cardinal_splines_pass_through),
        cmocka_unit_test(samples_of_pixels_repeat),
        cmocka_unit_test(bad_places_and_cancelling_end_it),
        cmocka_unit_test(separable_errors_are_found),
        cmocka_unit_test(multipass_errors_are_found),
        cmocka_unit_test(resampled_errors_are_found),
        cmocka_unit_test(moved_integers_are_found),
        cmocka_unit_test(slice_errors_are_found),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
