// SPDX-License-Identifier: BSD-3-Clause
// Stopping early, on noise whose deviation is known.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <string.h>

#include "tests/support/common.h"
#include "passes/accumulate/accumulate.h"

enum { SIDE = 48, PIXELS = SIDE * SIDE, MOST = 3000 };

static uint64_t random_state;

// SplitMix64 (Steele, Lea, Flood 2014), 0 to 1.
static double next_unit(void)
{
    uint64_t z = random_state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

// Of mean 0 and deviation 1.
static double next_noise(void)
{
    double sum = 0.0;
    for (int i = 0; i < 12; i++)
        sum += next_unit();
    return sum - 6.0;
}

// What a pixel shows in a frame, and what it is.
struct scene {
    double (*shown)(int x, int y);
    double (*mean)(int x, int y);
};

struct outcome {
    int frames;            // that were added; MOST + 1: it was never enough
    double rms, share_off; // of the true error; share of pixels off by more than 3 limits
    struct weft_convergence found;
};

static struct outcome run(const struct scene *scene, struct weft_until until, int channels,
                          double limit)
{
    static float frame[PIXELS], mean[PIXELS];
    weft_accumulator *a = NULL;
    struct outcome out = {.frames = MOST + 1};
    random_state = 11;
    assert_int_equal(
        weft_accumulator_create(
            weft_accumulator_params(.width = SIDE, .height = SIDE, .channel_count = channels,
                                    .method = WEFT_ACCUMULATE_EXACT, .keep = WEFT_KEEP_VARIANCE,
                                    .log = &log_to_stderr),
            &a),
        WEFT_OK);
    static const float dark[PIXELS];
    for (int f = 1; f <= MOST; f++) {
        for (int i = 0; i < PIXELS; i++)
            frame[i] = (float)scene->shown(i % SIDE, i / SIDE);
        // The channel that is noise is the last one.
        struct weft_plane planes[2] = {{.values = dark}, {.values = dark}};
        planes[channels - 1].values = frame;
        assert_int_equal(weft_accumulator_add(a, &(struct weft_frame){.plane = planes}, 2.0),
                         WEFT_OK);
        if (f % 4)
            continue;
        assert_int_equal(weft_accumulator_judge(a, &until, &out.found), WEFT_OK);
        if (out.found.enough) {
            out.frames = f;
            break;
        }
    }
    assert_int_equal(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, channels - 1, mean, 0),
                     WEFT_OK);
    weft_accumulator_destroy(&a);
    for (int i = 0; i < PIXELS; i++) {
        const double error = (double)mean[i] - scene->mean(i % SIDE, i / SIDE);
        out.rms += error * error / PIXELS;
        out.share_off += (fabs(error) > 3.0 * limit) / (double)PIXELS;
    }
    out.rms = sqrt(out.rms);
    return out;
}

// ---- noise of one size --------------------------------------------------------------------------

static double even_mean(int x, int y)
{
    (void)x, (void)y;
    return 0.7;
}

static double even_noise(int x, int y)
{
    return even_mean(x, y) + 0.25 * next_noise();
}

// A mean of n frames is off by 0.25 / sqrt(n): it stops about where that is the limit, within what
// 25 pixels know of their variance, and the true error is the promised one.
static void test_known_noise(void **state)
{
    (void)state;
    const struct scene scene = {even_noise, even_mean};
    static const double limits[] = {0.05, 0.03, 0.015};
    for (size_t i = 0; i < WEFT_COUNT(limits); i++)
        for (int channels = 1; channels <= 2; channels++) {
            const double limit = limits[i], frames = 0.0625 / (limit * limit);
            const struct outcome by_size =
                run(&scene, (struct weft_until){.absolute = limit}, channels, limit);
            assert_true(by_size.frames >= frames && by_size.frames < 1.6 * frames);
            assert_true(by_size.rms < limit && by_size.rms > 0.7 * limit);
            assert_true(by_size.share_off < 0.006); // 0.0027 are, of noise like this
            assert_true(by_size.found.share >= 0.99);
            assert_near(by_size.found.median, 0.25 / sqrt(by_size.frames), 0.1 * limit, "median");
            assert_true(by_size.found.largest > by_size.found.median &&
                        by_size.found.largest < 1.5 * by_size.found.median);
            if (channels == 1) { // to the mean it is the same; a dark channel has no error
                const struct outcome to_mean =
                    run(&scene, (struct weft_until){.relative = limit / 0.7}, 1, limit);
                assert_near(to_mean.frames, by_size.frames, 0.2 * by_size.frames, "frames");
            }
        }
}

// ---- a dark half where light is rare, and fireflies ---------------------------------------------

static double half_mean(int x, int y)
{
    (void)y;
    return x < SIDE / 2 ? 0.02 : 1.0;
}

// One frame of 25 shows 0.5 there: most pixels have seen nothing in the first frames.
static double half_rare(int x, int y)
{
    (void)y;
    if (x < SIDE / 2)
        return next_unit() < 0.04 ? 0.5 : 0.0;
    return 1.0 + 0.01 * next_noise();
}

static void test_dark_region(void **state)
{
    (void)state;
    const struct scene scene = {half_rare, half_mean};
    // The deviation is 0.5 sqrt(0.04 * 0.96) = 0.098, so 2400 frames for 0.002; a tenth of the
    // mean.
    const double limit = 0.1 * 0.02;
    const struct outcome near = run(&scene, (struct weft_until){.relative = 0.1}, 1, limit);
    print_message("dark region: %d frames, rms %g\n", near.frames, near.rms);
    assert_true(near.frames > 1900 && near.frames <= 3000);
    // Judged by itself a pixel that has seen nothing has no error and no mean: far too early.
    const struct outcome alone =
        run(&scene, (struct weft_until){.relative = 0.1, .radius = -1, .share = 0.6}, 1, limit);
    print_message("by single pixels: %d frames\n", alone.frames);
    assert_true(alone.frames < 100);
}

static double even_dim(int x, int y)
{
    (void)x, (void)y;
    return 0.1 + 1e-4 * 200.0;
}

static double fireflies(int x, int y)
{
    (void)x, (void)y;
    return 0.1 + 0.01 * next_noise() + (next_unit() < 1e-4 ? 200.0 : 0.0);
}

// Deviation of one frame: 2. A sixteenth of the 48^2 pixels' neighbourhoods has seen one after 16
// frames, all of them vary: what is rare is found, if not before it has come.
static void test_fireflies(void **state)
{
    (void)state;
    const struct scene scene = {fireflies, even_dim};
    const struct outcome out =
        run(&scene, (struct weft_until){.absolute = 0.005, .share = 0.99}, 1, 0.005);
    print_message("fireflies: %d frames\n", out.frames);
    assert_int_equal(out.frames, MOST + 1); // 160,000 would do
    assert_true(out.found.share < 0.9);
}

// ---- what decides -------------------------------------------------------------------------------

static double constant(int x, int y)
{
    return even_mean(x, y);
}

static void test_least(void **state)
{
    (void)state;
    const struct scene still = {constant, even_mean};
    assert_int_equal(run(&still, (struct weft_until){.absolute = 1e-9}, 1, 1.0).frames, 16);
    assert_int_equal(run(&still, (struct weft_until){.absolute = 1e-9, .least = 40}, 1, 1.0).frames,
                     40);
    assert_int_equal(
        run(&still, (struct weft_until){.absolute = 1e-9, .least = 2, .share = 1.0}, 1, 1.0).frames,
        4);
}

static void test_unknown(void **state)
{
    (void)state;
    static float frame[PIXELS];
    struct weft_convergence found;
    const struct weft_until until = {.absolute = 1.0, .least = 2};
    const struct weft_plane plane = {.values = frame};
    weft_accumulator *a = NULL;
    assert_int_equal(
        weft_accumulator_create(
            weft_accumulator_params(.width = SIDE, .height = SIDE, .channel_count = 1,
                                    .method = WEFT_ACCUMULATE_EXACT, .keep = WEFT_KEEP_VARIANCE,
                                    .nonfinite = WEFT_NONFINITE_SKIP, .log = &log_to_stderr),
            &a),
        WEFT_OK);
    frame[0] = NAN;
    for (int f = 0; f < 2; f++) {
        assert_int_equal(weft_accumulator_add(a, &(struct weft_frame){.plane = &plane}, 1.0),
                         WEFT_OK);
        assert_int_equal(weft_accumulator_judge(a, &until, &found), WEFT_OK);
        assert_int_equal(found.enough, f == 1); // one sample has no variance
        assert_true(f == 0 ? isnan(found.largest) && found.share == 0.0
                           : found.largest == 0.0 && found.share == 1.0);
    }
    weft_accumulator_destroy(&a);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_known_noise), cmocka_unit_test(test_dark_region),
        cmocka_unit_test(test_fireflies),   cmocka_unit_test(test_least),
        cmocka_unit_test(test_unknown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
