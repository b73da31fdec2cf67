// SPDX-License-Identifier: BSD-3-Clause
// States of exact sums: what was saved goes on to the same bytes, parts that are joined are one
// run, and bytes that are not a state of this accumulation are refused with one line.
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

enum { WIDTH = 7, HEIGHT = 5, PIXELS = WIDTH * HEIGHT, CHANNELS = 2, FRAMES = 24 };

static struct message kept;
static const struct weft_log keep_log = {keep_message, &kept};

static struct weft_accumulator_params usual(void)
{
    return (struct weft_accumulator_params){.width = WIDTH,
                                            .height = HEIGHT,
                                            .channel_count = CHANNELS,
                                            .method = WEFT_ACCUMULATE_EXACT,
                                            .nonfinite = WEFT_NONFINITE_SKIP,
                                            .log = &keep_log};
}

static weft_accumulator *make(struct weft_accumulator_params params)
{
    weft_accumulator *a = NULL;
    assert_int_equal(weft_accumulator_create(&params, &a), WEFT_OK);
    return a;
}

static double weight_of(int f, bool mixed)
{
    return mixed && f % 2 ? 0.3 + f * 0.1 : 1 + f % 3;
}

// Frame f: halves and floats, now and then codes, some values of no number, weights of all sorts.
static void add_weighed(weft_accumulator *a, int f, bool mixed, double weight)
{
    float floats[PIXELS];
    uint16_t halves[PIXELS];
    uint8_t codes[PIXELS];
    for (int i = 0; i < PIXELS; i++) {
        floats[i] = sinf((float)(f * 31 + i)) * 3.0f;
        halves[i] = weft_half_from_float(floats[i]);
        codes[i] = (uint8_t)(f * 7 + i * 13);
    }
    floats[f % PIXELS] = f % 3 ? floats[f % PIXELS] : NAN;
    halves[(f + 3) % PIXELS] = f % 4 ? 0x3c00 : 0x7c00;
    const struct weft_plane planes[CHANNELS] = {
        {.values = halves, .type = WEFT_PLANE_HALF},
        {.values = mixed && f % 5 == 2 ? (void *)codes : floats,
         .type = mixed && f % 5 == 2 ? WEFT_PLANE_UNORM8 : WEFT_PLANE_FLOAT}};
    assert_int_equal(weft_accumulator_add(a, &(struct weft_frame){.plane = planes}, weight),
                     WEFT_OK);
}

static void add(weft_accumulator *a, int f, bool mixed)
{
    add_weighed(a, f, mixed, weight_of(f, mixed));
}

struct result {
    float value[WEFT_ACCUMULATED_COUNT][CHANNELS][PIXELS];
};

static void get(weft_accumulator *a, struct result *out, unsigned keep)
{
    memset(out, 0, sizeof *out);
    for (int what = 0; what < WEFT_ACCUMULATED_COUNT; what++) {
        const bool moment = what != WEFT_ACCUMULATED_MEAN && what != WEFT_ACCUMULATED_WEIGHT;
        for (int c = 0; c < CHANNELS && (!moment || keep > 0); c++)
            assert_int_equal(
                weft_accumulator_current(a, (enum weft_accumulated)what, c, out->value[what][c], 0),
                WEFT_OK);
    }
}

// Saves, destroys, and loads into another.
static weft_accumulator *through_state(weft_accumulator *a, struct weft_accumulator_params params)
{
    void *state;
    size_t size;
    assert_int_equal(weft_accumulator_save(a, &state, &size), WEFT_OK);
    weft_accumulator_destroy(&a);
    a = make(params);
    assert_int_equal(weft_accumulator_load(a, state, size), WEFT_OK);
    free(state);
    return a;
}

static void check_going_on(unsigned keep, int batch, bool mixed)
{
    struct weft_accumulator_params params = usual();
    struct result whole, resumed, joined;
    params.keep = keep;
    params.batch = batch;
    weft_accumulator *a = make(params), *b = make(params), *parts[3];
    for (int f = 0; f < FRAMES; f++)
        add(a, f, mixed);
    get(a, &whole, keep);
    weft_accumulator_destroy(&a);
    for (int f = 0; f < FRAMES; f++) {
        if (f % 5 == 0)
            b = through_state(b, params);
        add(b, f, mixed);
    }
    get(b, &resumed, keep);
    weft_accumulator_destroy(&b);
    assert_memory_equal(&whole, &resumed, sizeof whole);
    if (batch > FRAMES)
        return;
    // In thirds, joined from the last.
    for (int p = 0; p < 3; p++) {
        parts[p] = make(params);
        for (int f = p * FRAMES / 3; f < (p + 1) * FRAMES / 3; f++)
            add(parts[p], f, mixed);
    }
    parts[1] = through_state(parts[1], params);
    assert_int_equal(weft_accumulator_join(parts[2], parts[0]), WEFT_OK);
    assert_int_equal(weft_accumulator_join(parts[2], parts[1]), WEFT_OK);
    get(parts[2], &joined, keep);
    assert_memory_equal(&whole, &joined, sizeof whole);
    for (int p = 0; p < 3; p++)
        weft_accumulator_destroy(&parts[p]);
}

static void test_going_on(void **state)
{
    (void)state;
    check_going_on(0, 1, false);
    check_going_on(0, 1, true);
    const unsigned keep = WEFT_KEEP_VARIANCE | WEFT_KEEP_EXTREMES;
    for (int batch = 1; batch <= 8; batch *= 2)
        for (int mixed = 0; mixed < 2; mixed++)
            check_going_on(keep, batch, mixed);
    check_going_on(keep, 2000, true); // longer than all frames: an open batch
}

// ---- what is refused ----------------------------------------------------------------------------

static enum weft_result load(struct weft_accumulator_params params, const void *state, size_t size)
{
    weft_accumulator *a = make(params);
    struct weft_accumulator_report report;
    kept.count = 0;
    const enum weft_result res = weft_accumulator_load(a, state, size);
    assert_int_equal(kept.count, res != WEFT_OK);
    if (res != WEFT_OK) { // others may follow
        weft_accumulator_get_report(a, &report);
        assert_int_equal(report.frames, 0);
        add(a, 0, false);
    }
    weft_accumulator_destroy(&a);
    return res;
}

static void test_damage(void **state)
{
    (void)state;
    weft_accumulator *a = make(usual());
    void *bytes;
    size_t size, refused = 0;
    for (int f = 0; f < 5; f++)
        add(a, f, true);
    assert_int_equal(weft_accumulator_save(a, &bytes, &size), WEFT_OK);
    weft_accumulator_destroy(&a);
    assert_int_equal(load(usual(), bytes, size), WEFT_OK);
    unsigned char *changed = malloc(size + 1);
    assert_non_null(changed);
    memcpy(changed, bytes, size);
    changed[size] = 0;
    for (size_t i = 0; i < size; i++)
        for (int bit = 1; bit < 256; bit = bit * 8 + 1) {
            changed[i] ^= (unsigned char)bit;
            refused += load(usual(), changed, size) == WEFT_ERR_FORMAT;
            changed[i] ^= (unsigned char)bit;
        }
    assert_int_equal(refused, 3 * size);
    for (size_t cut = 0; cut < size; cut++)
        assert_int_equal(load(usual(), changed, cut), WEFT_ERR_FORMAT);
    assert_int_equal(load(usual(), changed, size + 1), WEFT_ERR_FORMAT);
    changed[8]++; // the version
    assert_int_equal(load(usual(), changed, size), WEFT_ERR_FORMAT);
    assert_non_null(strstr(kept.text, "version 3, this weft reads version 2"));
    free(changed);
    free(bytes);
}

static void test_other_params(void **state)
{
    (void)state;
    static const double ones[FRAMES] = {1.0, 2.0, [2] = 1.0};
    struct weft_accumulator_params others[7];
    void *bytes;
    size_t size;
    weft_accumulator *a = make(usual()), *b;
    add(a, 0, false);
    assert_int_equal(weft_accumulator_save(a, &bytes, &size), WEFT_OK);
    for (size_t i = 0; i < WEFT_COUNT(others); i++)
        others[i] = usual();
    others[0].width = HEIGHT, others[0].height = WIDTH;
    others[1].nonfinite = WEFT_NONFINITE_PROPAGATE;
    others[2].batch = 2;
    others[3].high = 2.0;
    others[4].level_branching[0] = 2;
    others[5].frame_count = FRAMES;
    others[6].frame_count = FRAMES, others[6].weight = ones;
    static const char *const texts[] = {"width is 7, here 5",           "nonfinite is 1, here 2",
                                        "batch is 1, here 2",           "high is 1, here 2",
                                        "level_branching is 0, here 2", "frame_count is 0, here 24",
                                        "frame_count is 0, here 24"};
    for (size_t i = 0; i < WEFT_COUNT(others); i++) {
        b = make(others[i]);
        assert_int_equal(weft_accumulator_load(b, bytes, size), WEFT_ERR_ARGUMENT);
        assert_non_null(strstr(kept.text, texts[i]));
        const bool fits = i >= 5; // parts have weights of their own
        assert_int_equal(weft_accumulator_join(a, b), fits ? WEFT_OK : WEFT_ERR_ARGUMENT);
        weft_accumulator_destroy(&b);
    }
    assert_int_equal(weft_accumulator_join(a, a), WEFT_ERR_ARGUMENT);
    // Two open batches do not fit together.
    others[2].keep = WEFT_KEEP_VARIANCE;
    weft_accumulator *c = make(others[2]);
    b = make(others[2]);
    add(b, 0, false);
    assert_int_equal(weft_accumulator_join(c, b), WEFT_OK);
    assert_int_equal(weft_accumulator_join(c, b), WEFT_ERR_ARGUMENT);
    assert_non_null(strstr(kept.text, "not whole, of 1 and 1 frames instead of 2"));
    weft_accumulator_destroy(&b);
    weft_accumulator_destroy(&c);
    assert_int_equal(weft_accumulator_load(a, bytes, size), WEFT_ERR_ARGUMENT); // has a frame
    weft_accumulator_destroy(&a);
    free(bytes);
}

// Samples of `batch` frames, dealt to so many parts that then are joined in one order or the other:
// the state has the bytes of the one that had all frames in theirs. Parts are given their samples
// from the last one down, but for one that is not whole, which comes last.
static void check_parts(unsigned keep, int batch, bool mixed, double scale, int parts)
{
    const int whole = (FRAMES - 1) / batch, left = FRAMES - 1 - whole * batch; // of an odd number
    struct weft_accumulator_params params = usual();
    double weight[FRAMES];
    void *bytes, *other_bytes;
    size_t size, other_size;
    for (int f = 0; f < FRAMES; f++)
        weight[f] = scale * weight_of(f, mixed);
    params.keep = keep;
    params.batch = batch;
    params.frame_count = FRAMES - 1;
    params.weight = weight;
    weft_accumulator *one = make(params), *part[5];
    for (int f = 0; f < FRAMES - 1; f++)
        add_weighed(one, f, mixed, weight[f]);
    params.part = true;
    for (int p = 0; p < parts; p++)
        part[p] = make(params);
    for (int s = whole - 1; s >= 0; s--)
        for (int f = s * batch; f < (s + 1) * batch; f++)
            add_weighed(part[(s * 3 + s / 5) % parts], f, mixed, weight[f]);
    for (int f = whole * batch; f < whole * batch + left; f++)
        add_weighed(part[parts - 1], f, mixed, weight[f]);
    const bool upwards = (whole + parts) % 2;
    const int last = upwards ? 0 : parts - 1;
    for (int p = 0; p < parts; p++) {
        const int other = upwards ? p : parts - 1 - p;
        if (other != last)
            assert_int_equal(weft_accumulator_join(part[last], part[other]), WEFT_OK);
    }
    assert_int_equal(weft_accumulator_save(one, &bytes, &size), WEFT_OK);
    assert_int_equal(weft_accumulator_save(part[last], &other_bytes, &other_size), WEFT_OK);
    assert_int_equal(size, other_size);
    assert_memory_equal(bytes, other_bytes, size);
    struct weft_accumulator_report a, b;
    weft_accumulator_get_report(one, &a);
    weft_accumulator_get_report(part[last], &b);
    assert_true(a.bound == b.bound && a.total_weight == b.total_weight && a.counted == b.counted);
    free(bytes);
    free(other_bytes);
    weft_accumulator_destroy(&one);
    for (int p = 0; p < parts; p++)
        weft_accumulator_destroy(&part[p]);
}

static void test_parts(void **state)
{
    static const unsigned keeps[] = {0, WEFT_KEEP_VARIANCE, WEFT_KEEP_VARIANCE | WEFT_KEEP_EXTREMES,
                                     WEFT_KEEP_EXTREMES};
    static const double scales[] = {1.0, 1.0 / 3000.0, 0x1p30 / 3.0};
    int ran = 0;
    (void)state;
    for (size_t k = 0; k < WEFT_COUNT(keeps); k++)
        for (int batch = 1; batch <= 4; batch += k & 1 ? 1 : 3)
            for (int mixed = 0; mixed < 2; mixed++)
                for (size_t s = 0; s < WEFT_COUNT(scales); s++)
                    for (int parts = 1; parts <= 5; parts++, ran++)
                        check_parts(keeps[k], batch, mixed, scales[s], parts);
    assert_int_equal(ran, (2 * 2 + 2 * 4) * 2 * 3 * 5);
}

// Of the exact method alone; what was announced is compared with what comes where all frames come.
static void test_refused_parts(void **state)
{
    static const double weight[2] = {1.0, 2.0};
    struct weft_accumulator_params params = usual();
    weft_accumulator *a = NULL;
    (void)state;
    params.nonfinite = WEFT_NONFINITE_ERROR;
    params.part = true;
    params.emulate = true;
    for (int method = WEFT_ACCUMULATE_TREE; method < WEFT_ACCUMULATE_METHOD_COUNT; method++) {
        params.method = (enum weft_accumulate_method)method;
        assert_int_equal(weft_accumulator_create(&params, &a), WEFT_ERR_ARGUMENT);
        assert_null(a);
        assert_non_null(strstr(kept.text, "cannot be joined"));
        assert_non_null(strstr(kept.text, weft_accumulate_method_names[method]));
    }
    params = usual();
    params.frame_count = 2;
    params.weight = weight;
    for (int part = 0; part < 2; part++) {
        params.part = part;
        a = make(params);
        float values[PIXELS] = {0.0f};
        const struct weft_plane planes[CHANNELS] = {{.values = values}, {.values = values}};
        const struct weft_frame frame = {.plane = planes};
        assert_int_equal(weft_accumulator_add(a, &frame, 2.0), part ? WEFT_OK : WEFT_ERR_ARGUMENT);
        weft_accumulator_destroy(&a);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_going_on),      cmocka_unit_test(test_parts),
        cmocka_unit_test(test_refused_parts), cmocka_unit_test(test_damage),
        cmocka_unit_test(test_other_params),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
