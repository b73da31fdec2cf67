// SPDX-License-Identifier: BSD-3-Clause
// The exact method: means are rounded once, as rational numbers in wide integers say, whatever the
// order of frames, types, weights and threads.
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

__extension__ typedef __int128 wide;
#if defined(__x86_64__)
__extension__ typedef __float128 quad; // 113 bits
#else
typedef long double quad;
#endif

enum { WIDTH = 37, HEIGHT = 5, PIXELS = WIDTH * HEIGHT, MOST_FRAMES = 64, CODE = 65535 };

static uint64_t random_state = 1;

// SplitMix64 (Steele, Lea, Flood 2014).
static uint64_t next_bits(void)
{
    uint64_t z = random_state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

static double next_unit(void)
{
    return (double)(next_bits() >> 11) * 0x1p-53;
}

// ---- frames -------------------------------------------------------------------------------------

// One channel of any type, interleaved with nonsense, rows apart.
struct picture {
    enum weft_plane_type type;
    size_t step, stride;
    unsigned char *bytes;
};

static struct picture pictures[MOST_FRAMES];
static double weights[MOST_FRAMES];

static void set(struct picture *p, size_t i, uint64_t bits)
{
    unsigned char *at =
        p->bytes + (i / WIDTH * p->stride + i % WIDTH * p->step) * weft_plane_type_size(p->type);
    const float value = ldexpf((float)(int64_t)(bits >> 40) - 0x1p23f, (int)(bits % 24) - 40);
    const uint16_t half = weft_half_from_float(ldexpf(value, 4));
    const uint32_t integer = ((uint32_t)bits >> 12) >> (bits >> 60);
    switch (p->type) {
    case WEFT_PLANE_FLOAT:
        memcpy(at, &value, sizeof value);
        break;
    case WEFT_PLANE_HALF:
        memcpy(at, &half, sizeof half);
        break;
    case WEFT_PLANE_UINT:
        memcpy(at, &integer, sizeof integer);
        break;
    default:
        memcpy(at, &integer, weft_plane_type_size(p->type));
        break;
    }
}

static void make_picture(struct picture *p, enum weft_plane_type type)
{
    p->type = type;
    p->step = 1 + next_bits() % 5;
    p->stride = WIDTH * p->step + next_bits() % 3;
    const size_t size = p->stride * HEIGHT * weft_plane_type_size(type);
    free(p->bytes);
    assert_non_null(p->bytes = malloc(size));
    memset(p->bytes, 0xff, size); // NAN between the values
    for (size_t i = 0; i < PIXELS; i++)
        set(p, i, next_bits());
}

static void forget_pictures(void)
{
    for (int f = 0; f < MOST_FRAMES; f++) {
        free(pictures[f].bytes);
        pictures[f] = (struct picture){0};
    }
}

static struct weft_plane plane_of(const struct picture *p)
{
    return (struct weft_plane){p->bytes, p->type, p->stride, p->step};
}

// As a rational number: *code says that it is in units of 1 / 65535.
static double value_of(const struct picture *p, size_t i, bool *code)
{
    const unsigned char *at =
        p->bytes + (i / WIDTH * p->stride + i % WIDTH * p->step) * weft_plane_type_size(p->type);
    uint16_t half;
    uint32_t integer = 0;
    float value;
    *code = p->type == WEFT_PLANE_UNORM8 || p->type == WEFT_PLANE_UNORM16;
    switch (p->type) {
    case WEFT_PLANE_FLOAT:
        memcpy(&value, at, sizeof value);
        return (double)value;
    case WEFT_PLANE_HALF:
        memcpy(&half, at, sizeof half);
        return (double)weft_half_to_float(half);
    default:
        memcpy(&integer, at, weft_plane_type_size(p->type));
        return p->type == WEFT_PLANE_UNORM8 ? integer * 257.0 : integer;
    }
}

// ---- accumulating -------------------------------------------------------------------------------

static struct weft_accumulator_params usual(void)
{
    return (struct weft_accumulator_params){.width = WIDTH,
                                            .height = HEIGHT,
                                            .channel_count = 1,
                                            .method = WEFT_ACCUMULATE_EXACT,
                                            .log = &log_to_stderr};
}

static weft_accumulator *make(struct weft_accumulator_params params)
{
    weft_accumulator *a = NULL;
    assert_int_equal(weft_accumulator_create(&params, &a), WEFT_OK);
    return a;
}

static enum weft_result add_picture(weft_accumulator *a, int f)
{
    const struct weft_plane plane = plane_of(&pictures[f]);
    return weft_accumulator_add(a, &(struct weft_frame){.plane = &plane}, weights[f]);
}

static void get(weft_accumulator *a, enum weft_accumulated what, float *out)
{
    assert_int_equal(weft_accumulator_current(a, what, 0, out, 0), WEFT_OK);
}

// Adds pictures in an order, and gets their mean and the bound.
static double accumulate(struct weft_accumulator_params params, const int *order, int count,
                         float *out)
{
    struct weft_accumulator_report report;
    weft_accumulator *a = make(params);
    for (int f = 0; f < count; f++)
        assert_int_equal(add_picture(a, order ? order[f] : f), WEFT_OK);
    get(a, WEFT_ACCUMULATED_MEAN, out);
    assert_int_equal(weft_accumulator_finish(a), WEFT_OK);
    weft_accumulator_get_report(a, &report);
    assert_int_equal(report.frames, count);
    assert_int_equal(report.method, WEFT_ACCUMULATE_EXACT);
    weft_accumulator_destroy(&a);
    return report.bound;
}

// ---- rational numbers ---------------------------------------------------------------------------

// Whether `mean` is the float nearest to sum / denominator, ties to even: exactly, in integers. All
// of it is small enough that nothing overflows.
static bool is_nearest(float mean, wide sum, wide denominator)
{
    int exponent;
    if (mean == 0.0f)
        return sum == 0;
    const wide mantissa = (wide)ldexp(frexp((double)mean, &exponent), 24);
    const int shift = exponent - 24; // mean = mantissa * 2^shift
    if (shift >= 0)
        denominator *= (wide)1 << shift;
    else
        sum *= (wide)1 << -shift;
    wide rest = sum - mantissa * denominator;
    const bool towards_zero = (rest < 0) != (mantissa < 0);
    rest = rest < 0 ? -rest : rest;
    if (towards_zero && (mantissa == 1 << 23 || mantissa == -(1 << 23)))
        return 4 * rest <= denominator; // the floats below lie closer
    return 2 * rest < denominator || (2 * rest == denominator && mantissa % 2 == 0);
}

// Integer weights: the sum in units of 2^-48 / 65535, in which all values here are integers.
static void check_nearest(const float *out, int count)
{
    for (size_t i = 0; i < PIXELS; i++) {
        wide sum = 0, total = 0;
        for (int f = 0; f < count; f++) {
            bool code;
            const double value = value_of(&pictures[f], i, &code);
            const wide units = (wide)ldexp(value, 48);
            assert_true(ldexp((double)units, -48) == value);
            sum += units * (wide)weights[f] * (code ? 1 : CODE);
            total += (wide)weights[f];
        }
        wide denominator = total * CODE;
        denominator *= (wide)1 << 48;
        if (denominator < 0) {
            sum = -sum;
            denominator = -denominator;
        }
        if (!is_nearest(out[i], sum, denominator))
            fail_msg("pixel %zu: %.9g is not nearest to %.17g", i, (double)out[i],
                     (double)sum / (double)denominator);
    }
}

static void assert_same(const float *a, const float *b)
{
    assert_memory_equal(a, b, PIXELS * sizeof *a);
}

static int *shuffled(int count)
{
    static int order[MOST_FRAMES];
    for (int f = 0; f < count; f++)
        order[f] = f;
    for (int f = count - 1; f > 0; f--) {
        const int g = (int)(next_bits() % (unsigned)(f + 1)), other = order[g];
        order[g] = order[f];
        order[f] = other;
    }
    return order;
}

// ---- integer weights ----------------------------------------------------------------------------

// `types` of so many values in turn, with weights from a list.
static void check_integers(unsigned types, int count, int32_t least, int32_t most)
{
    float out[PIXELS], again[PIXELS];
    double total = 0.0;
    for (int f = 0; f < count; f++) {
        enum weft_plane_type type;
        do
            type = (enum weft_plane_type)(next_bits() % WEFT_PLANE_TYPE_COUNT);
        while (!(types >> type & 1));
        make_picture(&pictures[f], type);
        do
            weights[f] = least + (double)(next_bits() % (uint64_t)(most - least + 1));
        while (weights[f] == 0.0 || (f == count - 1 && total + weights[f] == 0.0));
        total += weights[f];
    }
    accumulate(usual(), NULL, count, out);
    check_nearest(out, count);
    accumulate(usual(), shuffled(count), count, again);
    assert_same(out, again);
    struct weft_accumulator_params known = usual();
    known.frame_count = count;
    known.weight = weights;
    accumulate(known, NULL, count, again);
    assert_same(out, again);
    known.cpu.instructions = WEFT_INSTRUCTIONS_PLAIN;
    accumulate(known, NULL, count, again);
    assert_same(out, again);
}

static void test_integer_weights(void **state)
{
    (void)state;
    static const int counts[] = {1, 2, 3, 7, 30, 64};
    int checked = 0;
    for (unsigned types = 1; types < 1u << WEFT_PLANE_TYPE_COUNT; types++)
        for (size_t n = 0; n < WEFT_COUNT(counts); n++) {
            check_integers(types, counts[n], 1, 1);
            check_integers(types, counts[n], 1, 9);
            check_integers(types, counts[n], -5, 7);
            check_integers(types, counts[n], 1, 1 << 20); // sums become wide on the way
            checked += 4;
        }
    assert_int_equal(checked, 31 * 6 * 4);
    forget_pictures();
}

// ---- real weights -------------------------------------------------------------------------------

static void check_reals(int count, double scale, bool negative, bool known)
{
    float out[PIXELS], again[PIXELS];
    struct weft_accumulator_params params = usual();
    for (int f = 0; f < count; f++) {
        make_picture(&pictures[f], (enum weft_plane_type)(next_bits() % WEFT_PLANE_TYPE_COUNT));
        weights[f] = scale * exp(-8.0 * next_unit()) * (negative && f % 3 == 1 ? -0.25 : 1.0);
    }
    if (known) {
        params.frame_count = count;
        params.weight = weights;
    }
    const double bound = accumulate(params, NULL, count, out);
    for (size_t i = 0; i < PIXELS; i++) {
        quad sum = 0.0, total = 0.0;
        for (int f = 0; f < count; f++) {
            bool code;
            const double value = value_of(&pictures[f], i, &code);
            sum += (quad)weights[f] * (code ? (quad)value / CODE : (quad)value);
            total += weights[f];
        }
        const double mean = (double)(sum / total), error = fabs((double)(out[i] - sum / total));
        if (!(error <= bound))
            fail_msg("pixel %zu: %.9g, %.17g, bound %g", i, (double)out[i], mean, bound);
        // Values of some size come out rounded once, but for what lies next to a tie.
        if (fabs(mean) > 0x1p-20)
            assert_true(error <= fabs(mean) * 0x1.001p-24);
    }
    if (!known) {
        accumulate(params, shuffled(count), count, again);
        assert_same(out, again);
    }
}

static void test_real_weights(void **state)
{
    (void)state;
    for (int count = 1; count <= 64; count += 9)
        for (int known = 0; known < 2; known++)
            for (int negative = 0; negative < 2; negative++) {
                check_reals(count, 1.0, negative, known);
                check_reals(count, 7e4, negative, known);
                if (known) {
                    check_reals(count, 1e-30, negative, known);
                    check_reals(count, 1e200, negative, known);
                }
            }
    forget_pictures();
}

// ---- how products are made does not matter ------------------------------------------------------

// A large value elsewhere makes the others' products go another way: they are the same, also where
// they are ties between units.
static void test_ways_of_products(void **state)
{
    (void)state;
    enum { FRAMES = 40 };
    float values[PIXELS], few[PIXELS], many[PIXELS];
    const struct weft_plane plane = {.values = values};
    const double real[] = {0.3,       1.0 / 3.0, 1.0 + 0x1p-30, 0.5 + 0x1p-41,
                           1234.5678, 0x1.8p-11, 3e-6};
    int differ = 0;
    for (size_t w = 0; w < WEFT_COUNT(real); w++) {
        weft_accumulator *a = make(usual()), *b = make(usual());
        for (int f = 0; f < FRAMES; f++) {
            for (size_t i = 0; i < PIXELS; i++)
                values[i] = ldexpf((float)(int64_t)(next_bits() >> 40) - 0x1p23f,
                                   -(int)(next_bits() % 80) - (i % 2 ? 23 : 40));
            for (int large = 0; large < 2; large++) {
                values[0] = large ? 3e11f : 0.0f;
                assert_int_equal(weft_accumulator_add(
                                     large ? b : a, &(struct weft_frame){.plane = &plane}, real[w]),
                                 WEFT_OK);
            }
        }
        get(a, WEFT_ACCUMULATED_MEAN, few);
        get(b, WEFT_ACCUMULATED_MEAN, many);
        assert_memory_equal(few + 1, many + 1, sizeof few - sizeof *few);
        differ += few[0] != many[0];
        weft_accumulator_destroy(&a);
        weft_accumulator_destroy(&b);
    }
    assert_int_equal(differ, WEFT_COUNT(real));
}

// ---- threads ------------------------------------------------------------------------------------

enum { WIDE = 640, HIGH = 301, LARGE = WIDE * HIGH, KINDS = 3 };

// All results of frames that are large enough for several threads.
static void accumulate_large(int threads, enum weft_instruction_set instructions, float *out)
{
    static float floats[LARGE];
    static uint16_t halves[LARGE];
    static uint8_t codes[4 * LARGE];
    const struct weft_plane planes[KINDS] = {
        {.values = floats},
        {.values = halves, .type = WEFT_PLANE_HALF},
        {.values = codes, .type = WEFT_PLANE_UNORM8, .step = 4}};
    struct weft_accumulator_params params = usual();
    params.width = WIDE;
    params.height = HIGH;
    params.channel_count = KINDS;
    params.nonfinite = WEFT_NONFINITE_SKIP;
    params.keep = WEFT_KEEP_VARIANCE | WEFT_KEEP_EXTREMES;
    params.cpu.threads = threads;
    params.cpu.instructions = instructions;
    random_state = 77;
    weft_accumulator *a = make(params);
    for (int f = 0; f < 4; f++) {
        for (size_t i = 0; i < LARGE; i++) {
            const uint64_t bits = next_bits();
            floats[i] = (float)(int32_t)bits * 0x1p-30f;
            halves[i] = (uint16_t)(bits >> 32);
            codes[4 * i] = (uint8_t)(bits >> 48);
        }
        floats[f * 1000] = NAN;
        assert_int_equal(
            weft_accumulator_add(a, &(struct weft_frame){.plane = planes}, f == 3 ? 0.7 : 2.0),
            WEFT_OK);
    }
    for (int what = 0; what < WEFT_ACCUMULATED_COUNT; what++)
        for (int c = 0; c < KINDS; c++, out += LARGE)
            assert_int_equal(weft_accumulator_current(a, (enum weft_accumulated)what, c, out, 0),
                             WEFT_OK);
    weft_accumulator_destroy(&a);
}

static void test_threads(void **state)
{
    (void)state;
    static const int threads[] = {1, 2, 3, 7};
    const size_t count = (size_t)WEFT_ACCUMULATED_COUNT * KINDS * LARGE;
    float *first = malloc(count * sizeof *first), *other = malloc(count * sizeof *other);
    assert_true(first && other);
    accumulate_large(1, WEFT_INSTRUCTIONS_PLAIN, first);
    for (size_t t = 0; t < WEFT_COUNT(threads); t++) {
        accumulate_large(threads[t], WEFT_INSTRUCTIONS_AUTO, other);
        assert_memory_equal(first, other, count * sizeof *first);
    }
    free(first);
    free(other);
}

// ---- limits -------------------------------------------------------------------------------------

// What is too much is refused with its place, and changes nothing.
static void test_limits(void **state)
{
    (void)state;
    struct message kept = {0};
    const struct weft_log log = {keep_message, &kept};
    struct weft_accumulator_params params = usual();
    float values[PIXELS] = {1.0f, 2.0f}, before[PIXELS], after[PIXELS];
    uint8_t codes[PIXELS] = {255};
    const struct weft_plane plane = {.values = values};
    const struct weft_plane coded = {.values = codes, .type = WEFT_PLANE_UNORM8};
    params.log = &log;
    weft_accumulator *a = make(params);
    assert_int_equal(weft_accumulator_add(a, &(struct weft_frame){.plane = &plane}, 1.0), WEFT_OK);
    values[WIDTH + 3] = 4e18f;
    assert_int_equal(weft_accumulator_add(a, &(struct weft_frame){.plane = &plane}, 1.0), WEFT_OK);
    get(a, WEFT_ACCUMULATED_MEAN, before);
    assert_true(before[WIDTH + 3] == 2e18f && before[1] == 2.0f);
    assert_int_equal(weft_accumulator_add(a, &(struct weft_frame){.plane = &plane}, 1.0),
                     WEFT_ERR_LIMIT);
    assert_non_null(strstr(kept.text, "frame 2, channel 0, pixel (3, 1) is 4e+18"));
    // Codes beside floats leave less room.
    assert_int_equal(weft_accumulator_add(a, &(struct weft_frame){.plane = &coded}, 1.0),
                     WEFT_ERR_LIMIT);
    values[WIDTH + 3] = NAN;
    assert_int_equal(weft_accumulator_add(a, &(struct weft_frame){.plane = &plane}, 1.0),
                     WEFT_ERR_FORMAT);
    assert_non_null(strstr(kept.text, "frame 2, channel 0, pixel (3, 1) is nan"));
    assert_int_equal(weft_accumulator_add(a, &(struct weft_frame){.plane = &plane}, 1e7),
                     WEFT_ERR_ARGUMENT);
    assert_non_null(strstr(kept.text, "above 1.04858e+06 have to be announced"));
    assert_int_equal(kept.count, 4);
    get(a, WEFT_ACCUMULATED_MEAN, after);
    assert_same(before, after);
    values[WIDTH + 3] = 0.0f;
    assert_int_equal(weft_accumulator_add(a, &(struct weft_frame){.plane = &plane}, -2.0), WEFT_OK);
    assert_int_equal(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, after, 0),
                     WEFT_ERR_ARGUMENT);
    assert_non_null(strstr(kept.text, "the weights add up to 0"));
    weft_accumulator_destroy(&a);
}

// Announced frames may be left out; others may not come.
static void test_left_out(void **state)
{
    (void)state;
    struct message kept = {0};
    const struct weft_log log = {keep_message, &kept};
    const float values[PIXELS] = {3.0f};
    const struct weft_plane plane = {.values = values};
    const struct weft_frame frame = {.plane = &plane};
    const double announced[] = {1.0, 2.0, 3.0};
    struct weft_accumulator_params params = usual();
    float out[PIXELS];
    params.frame_count = 3;
    params.weight = announced;
    params.log = &log;
    weft_accumulator *a = make(params);
    assert_int_equal(weft_accumulator_add(a, &frame, 1.0), WEFT_OK);
    assert_int_equal(weft_accumulator_add(a, &frame, 1.5), WEFT_ERR_ARGUMENT);
    assert_int_equal(weft_accumulator_add(a, &frame, 0.0), WEFT_OK);
    assert_int_equal(weft_accumulator_add(a, &frame, 3.0), WEFT_OK);
    assert_int_equal(weft_accumulator_add(a, &frame, 3.0), WEFT_ERR_LIMIT);
    get(a, WEFT_ACCUMULATED_MEAN, out);
    assert_true(out[0] == 3.0f && out[1] == 0.0f);
    weft_accumulator_destroy(&a);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_integer_weights),  cmocka_unit_test(test_real_weights),
        cmocka_unit_test(test_ways_of_products), cmocka_unit_test(test_threads),
        cmocka_unit_test(test_limits),           cmocka_unit_test(test_left_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
