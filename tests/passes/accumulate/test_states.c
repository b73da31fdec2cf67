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

// Frame f: halves and floats, now and then codes, some values of no number, weights of all sorts.
static void add(weft_accumulator *a, int f, bool mixed)
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
    const double weight = mixed && f % 2 ? 0.3 + f * 0.1 : 1 + f % 3;
    assert_int_equal(weft_accumulator_add(a, &(struct weft_frame){.plane = planes}, weight),
                     WEFT_OK);
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
    assert_non_null(strstr(kept.text, "version 2, this weft reads version 1"));
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_going_on),
        cmocka_unit_test(test_damage),
        cmocka_unit_test(test_other_params),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
