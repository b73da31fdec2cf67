// SPDX-License-Identifier: BSD-3-Clause
// What is kept beside the mean, against two passes in long double over the same values.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "filter/half.h"
#include "passes/accumulate/accumulate.h"

enum { WIDTH = 19, HEIGHT = 3, PIXELS = WIDTH * HEIGHT, MOST = 60 };

static uint64_t random_state = 5;

// SplitMix64 (Steele, Lea, Flood 2014), 0 to 1.
static double next_unit(void)
{
    uint64_t z = random_state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

// Frames as they are and as they are meant.
static int count;
static uint32_t memory[MOST][PIXELS];
static enum weft_plane_type type[MOST];
static long double value[MOST][PIXELS];
static double weights[MOST];

static void set(int f, size_t i, double v)
{
    uint32_t *floats = memory[f];
    uint16_t *words = (uint16_t *)(void *)memory[f];
    uint8_t *bytes = (uint8_t *)(void *)memory[f];
    const float single = (float)v;
    switch (type[f]) {
    case WEFT_PLANE_HALF:
        words[i] = weft_half_from_float(single);
        value[f][i] = weft_half_to_float(words[i]);
        break;
    case WEFT_PLANE_UNORM8:
        bytes[i] = (uint8_t)lrint(fabs(v) * 255.0);
        value[f][i] = bytes[i] / 255.0L;
        break;
    case WEFT_PLANE_UNORM16:
        words[i] = (uint16_t)lrint(fabs(v) * 65535.0);
        value[f][i] = words[i] / 65535.0L;
        break;
    case WEFT_PLANE_UINT:
        floats[i] = (uint32_t)lrint(fabs(v) * 1048575.0);
        value[f][i] = floats[i];
        break;
    default:
        memcpy(&floats[i], &single, sizeof single);
        value[f][i] = single;
        break;
    }
}

// Values about `mean`, each frame of one of the types.
static void make_frames(int frames, unsigned types, double mean, double spread)
{
    count = frames;
    for (int f = 0; f < frames; f++) {
        weights[f] = 1.0;
        do
            type[f] = (enum weft_plane_type)(next_unit() * WEFT_PLANE_TYPE_COUNT);
        while (!(types >> type[f] & 1));
        for (size_t i = 0; i < PIXELS; i++)
            set(f, i, mean + spread * (next_unit() - 0.5));
    }
}

static struct weft_accumulator_params usual(void)
{
    return (struct weft_accumulator_params){.width = WIDTH,
                                            .height = HEIGHT,
                                            .channel_count = 1,
                                            .method = WEFT_ACCUMULATE_EXACT,
                                            .keep = WEFT_KEEP_VARIANCE | WEFT_KEEP_EXTREMES,
                                            .log = &log_to_stderr};
}

static weft_accumulator *accumulate(struct weft_accumulator_params params)
{
    weft_accumulator *a = NULL;
    assert_int_equal(weft_accumulator_create(&params, &a), WEFT_OK);
    for (int f = 0; f < count; f++) {
        const struct weft_plane plane = {.values = memory[f], .type = type[f]};
        assert_int_equal(weft_accumulator_add(a, &(struct weft_frame){.plane = &plane}, weights[f]),
                         WEFT_OK);
    }
    return a;
}

static void get(weft_accumulator *a, enum weft_accumulated what, float *out)
{
    assert_int_equal(weft_accumulator_current(a, what, 0, out, 0), WEFT_OK);
}

// The plain mean of a batch.
static long double sample(size_t i, int batch, int b)
{
    long double sum = 0.0L;
    for (int f = b * batch; f < (b + 1) * batch; f++)
        sum += value[f][i];
    return sum / batch;
}

// In two passes: unbiased, of batches; those that are not whole do not count.
static long double variance_of(size_t i, int batch)
{
    const int n = count / batch;
    long double mean = 0.0L, square = 0.0L;
    for (int b = 0; b < n; b++)
        mean += sample(i, batch, b) / n;
    for (int b = 0; b < n; b++)
        square += (sample(i, batch, b) - mean) * (sample(i, batch, b) - mean);
    return square / (n - 1);
}

// sum of squares of batches' weights over the square of their sum; an open one as if it were whole.
static long double weight_share(int batch)
{
    long double square = 0.0L, total = 0.0L;
    for (int f = 0; f < count; f += batch) {
        const int length = count - f < batch ? count - f : batch;
        long double weight = 0.0L;
        for (int g = f; g < f + length; g++)
            weight += weights[g];
        square += weight * weight * batch / length;
        total += weight;
    }
    return square / (total * total);
}

// Two roundings to floats and some to doubles: far below this.
static const long double tolerance = 0x1p-22L;

static void check(int batch, long double floor)
{
    struct weft_accumulator_params params = usual();
    float variance[PIXELS], deviation[PIXELS], least[PIXELS], largest[PIXELS];
    params.batch = batch;
    weft_accumulator *a = accumulate(params);
    get(a, WEFT_ACCUMULATED_VARIANCE, variance);
    get(a, WEFT_ACCUMULATED_STANDARD_ERROR, deviation);
    get(a, WEFT_ACCUMULATED_MINIMUM, least);
    get(a, WEFT_ACCUMULATED_MAXIMUM, largest);
    for (size_t i = 0; i < PIXELS; i++) {
        long double low = value[0][i], high = value[0][i];
        for (int f = 0; f < count; f++) {
            low = value[f][i] < low ? value[f][i] : low;
            high = value[f][i] > high ? value[f][i] : high;
        }
        assert_true(least[i] == (float)low && largest[i] == (float)high);
        if (count / batch < 2) {
            assert_true(isnan(variance[i]) && isnan(deviation[i]));
            continue;
        }
        const long double wanted = variance_of(i, batch);
        const long double error = sqrtl(wanted * weight_share(batch));
        if (!(fabsl(variance[i] - wanted) <= tolerance * wanted + floor) ||
            !(fabsl(deviation[i] - error) <= tolerance * error + sqrtl(floor)))
            fail_msg("pixel %zu: variance %.9g, %.17Lg, standard error %.9g, %.17Lg", i,
                     (double)variance[i], wanted, (double)deviation[i], error);
    }
    weft_accumulator_destroy(&a);
}

static void test_types(void **state)
{
    (void)state;
    static const int counts[] = {1, 2, 3, 17, 60};
    int checked = 0;
    for (unsigned types = 1; types < 1u << WEFT_PLANE_TYPE_COUNT; types++)
        for (size_t n = 0; n < WEFT_COUNT(counts); n++, checked++) {
            make_frames(counts[n], types, 0.5, 0.9);
            check(1, 0.0L);
        }
    assert_int_equal(checked, 31 * 5);
}

// What a single pass in floats or doubles would lose: sums that differ in their last bits only.
static void test_cancellation(void **state)
{
    (void)state;
    static const double means[] = {1.0, 100.0, 4096.0, 1e6, 1e9, -3e4};
    for (size_t m = 0; m < WEFT_COUNT(means); m++)
        for (int ulps = 2; ulps <= 2000; ulps *= 10) {
            make_frames(40, 1 << WEFT_PLANE_FLOAT, means[m], fabs(means[m]) * 0x1p-23 * ulps);
            check(1, 0.0L);
        }
    make_frames(40, 1 << WEFT_PLANE_HALF, 60000.0, 200.0);
    check(1, 0.0L);
    make_frames(40, 1 << WEFT_PLANE_UNORM16, 0.99, 2.0 / 65535.0);
    check(1, 0.0L);
    make_frames(40, 1 << WEFT_PLANE_UINT, 3000.0, 3e-6);
    check(1, 0.0L);
    // The squares of small floats are rounded to 2^-104, and they themselves to 2^-64.
    make_frames(40, 1 << WEFT_PLANE_FLOAT, 1e-6, 1e-9);
    check(1, 0x1p-80L);
    make_frames(40, 1 << WEFT_PLANE_FLOAT, 1e-13, 1e-14);
    check(1, 0x1p-90L);
}

static void test_weights_and_batches(void **state)
{
    (void)state;
    int checked = 0;
    for (int batch = 1; batch <= 20; batch += batch < 4 ? 1 : 7)
        for (unsigned types = 1; types < 1u << WEFT_PLANE_TYPE_COUNT; types += 3, checked++) {
            make_frames(53, types, 0.5, 0.9);
            for (int f = 0; f < count; f++)
                weights[f] = types % 2 ? 1 + f % 4 : 0.1 + next_unit();
            check(batch, 0.0L);
        }
    assert_int_equal(checked, 6 * 11);
}

// Beside another method it is the same.
static void test_beside_buffer(void **state)
{
    (void)state;
    struct weft_accumulator_params params = usual();
    float exact[PIXELS], beside[PIXELS];
    make_frames(20, 1 << WEFT_PLANE_HALF | 1 << WEFT_PLANE_UNORM8, 0.5, 0.9);
    for (int what = WEFT_ACCUMULATED_VARIANCE; what < WEFT_ACCUMULATED_COUNT; what++) {
        params.method = WEFT_ACCUMULATE_EXACT;
        weft_accumulator *a = accumulate(params);
        get(a, (enum weft_accumulated)what, exact);
        weft_accumulator_destroy(&a);
        params.method = WEFT_ACCUMULATE_BUFFER;
        a = accumulate(params);
        get(a, (enum weft_accumulated)what, beside);
        weft_accumulator_destroy(&a);
        assert_memory_equal(exact, beside, sizeof exact);
    }
}

static void test_zeros(void **state)
{
    (void)state;
    float out[PIXELS];
    make_frames(2, 1 << WEFT_PLANE_FLOAT, 0.0, 0.0);
    for (int order = 0; order < 2; order++) {
        for (size_t i = 0; i < PIXELS; i++) {
            set(order, i, -0.0);
            set(1 - order, i, 0.0);
        }
        weft_accumulator *a = accumulate(usual());
        for (int what = 0; what < WEFT_ACCUMULATED_WEIGHT; what++) {
            get(a, (enum weft_accumulated)what, out);
            for (size_t i = 0; i < PIXELS; i++)
                assert_true(out[i] == 0.0f && !signbit(out[i]));
        }
        weft_accumulator_destroy(&a);
    }
}

// ---- values that are not finite -----------------------------------------------------------------

// Pixel 0 has them in frame 3, pixel 1 always but in frame 0, pixel 2 always.
static void spoil(void)
{
    for (int f = 0; f < count; f++) {
        if (f == 3)
            set(f, 0, (double)NAN);
        if (f != 0)
            set(f, 1, (double)INFINITY);
        set(f, 2, f % 2 ? (double)NAN : -(double)INFINITY);
    }
}

static void test_skipping(void **state)
{
    (void)state;
    enum { FRAMES = 12 };
    static const unsigned types[] = {1 << WEFT_PLANE_FLOAT, 1 << WEFT_PLANE_HALF};
    for (size_t t = 0; t < WEFT_COUNT(types); t++)
        for (int batch = 1; batch <= 2; batch++) {
            struct weft_accumulator_params params = usual();
            struct weft_accumulator_report report;
            float out[WEFT_ACCUMULATED_COUNT][PIXELS];
            params.nonfinite = WEFT_NONFINITE_SKIP;
            params.batch = batch;
            make_frames(FRAMES, types[t], 0.5, 0.9);
            spoil();
            weft_accumulator *a = accumulate(params);
            weft_accumulator_get_report(a, &report);
            assert_int_equal(report.nonfinite, 1 + (FRAMES - 1) + FRAMES);
            for (int what = 0; what < WEFT_ACCUMULATED_COUNT; what++) {
                get(a, (enum weft_accumulated)what, out[what]);
                assert_true(what == WEFT_ACCUMULATED_WEIGHT ? out[what][2] == 0.0f
                                                            : isnan(out[what][2]));
                assert_true(isfinite(out[what][3]));
            }
            weft_accumulator_destroy(&a);
            assert_true(out[WEFT_ACCUMULATED_WEIGHT][0] == (float)(11.0 / 12.0));
            assert_true(out[WEFT_ACCUMULATED_WEIGHT][1] == (float)(1.0 / 12.0));
            assert_true(out[WEFT_ACCUMULATED_WEIGHT][3] == 1.0f);
            assert_true(out[WEFT_ACCUMULATED_MEAN][1] == (float)value[0][1]);
            assert_true(out[WEFT_ACCUMULATED_MAXIMUM][1] == (float)value[0][1]);
            assert_true(isnan(out[WEFT_ACCUMULATED_VARIANCE][1]));
            // Pixel 0 as if what was spoilt had not been.
            for (int f = batch == 1 ? 3 : 2; f < FRAMES - batch; f++)
                value[f][0] = value[f + batch][0];
            count -= batch;
            const long double variance = variance_of(0, batch);
            const long double error = sqrtl(variance / (count / batch));
            assert_near((double)out[WEFT_ACCUMULATED_VARIANCE][0], (double)variance,
                        (double)(variance * tolerance), "variance");
            assert_near((double)out[WEFT_ACCUMULATED_STANDARD_ERROR][0], (double)error,
                        (double)(error * tolerance), "standard error");
        }
}

static void test_propagating(void **state)
{
    (void)state;
    for (int batch = 1; batch <= 7; batch += 6) {
        struct weft_accumulator_params params = usual();
        float out[PIXELS];
        params.nonfinite = WEFT_NONFINITE_PROPAGATE;
        params.batch = batch;
        make_frames(16, 1 << WEFT_PLANE_FLOAT | 1 << WEFT_PLANE_HALF, 0.5, 0.9);
        spoil();
        weft_accumulator *a = accumulate(params);
        for (int what = 0; what < WEFT_ACCUMULATED_WEIGHT; what++) {
            get(a, (enum weft_accumulated)what, out);
            for (size_t i = 0; i < PIXELS; i++)
                assert_int_equal(isnan(out[i]) != 0, i < 3);
        }
        weft_accumulator_destroy(&a);
    }
}

// A refused frame changes nothing, whatever refuses it.
static void test_refused(void **state)
{
    (void)state;
    struct message kept = {0};
    const struct weft_log log = {keep_message, &kept};
    struct weft_accumulator_params params = usual();
    float before[WEFT_ACCUMULATED_COUNT][PIXELS], after[PIXELS], bad[PIXELS] = {0.0f};
    const struct weft_plane plane = {.values = bad};
    params.log = &log;
    make_frames(5, 1 << WEFT_PLANE_FLOAT, 0.5, 0.9);
    weft_accumulator *a = accumulate(params);
    for (int what = 0; what < WEFT_ACCUMULATED_COUNT; what++)
        get(a, (enum weft_accumulated)what, before[what]);
    static const struct {
        float value;
        enum weft_result result;
        const char *text;
    } cases[] = {{NAN, WEFT_ERR_FORMAT, "frame 5, channel 0, pixel (4, 2) is nan"},
                 {-INFINITY, WEFT_ERR_FORMAT, "frame 5, channel 0, pixel (4, 2) is -inf"},
                 {-3e15f, WEFT_ERR_LIMIT,
                  "pixel (4, 2) is -3e+15: with the frames before it sums "
                  "of squares reach 9e+30"},
                 {1e20f, WEFT_ERR_LIMIT, "pixel (4, 2) is 1e+20"}};
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        bad[2 * WIDTH + 4] = cases[i].value;
        kept.count = 0;
        assert_int_equal(weft_accumulator_add(a, &(struct weft_frame){.plane = &plane}, 1.0),
                         cases[i].result);
        assert_int_equal(kept.count, 1);
        if (!strstr(kept.text, cases[i].text))
            fail_msg("%s", kept.text);
        for (int what = 0; what < WEFT_ACCUMULATED_COUNT; what++) {
            get(a, (enum weft_accumulated)what, after);
            assert_memory_equal(before[what], after, sizeof after);
        }
    }
    weft_accumulator_destroy(&a);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_types),
        cmocka_unit_test(test_cancellation),
        cmocka_unit_test(test_weights_and_batches),
        cmocka_unit_test(test_beside_buffer),
        cmocka_unit_test(test_zeros),
        cmocka_unit_test(test_skipping),
        cmocka_unit_test(test_propagating),
        cmocka_unit_test(test_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
