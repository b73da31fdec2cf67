// SPDX-License-Identifier: BSD-3-Clause
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "passes/positions/window_map.h"

// (x + 0.5) from / to - 0.5, counted from the first sample, in 128 bits: rounded once.
static double exact_position(const struct weft_window_map *m, int pixel, int shift)
{
    const __int128 top = (2 * ((__int128)pixel + m->pixel) + 1) * m->from +
                         (2 * ((__int128)m->sample + shift) - 1) * m->to;
    return (double)((long double)top / (2.0L * (long double)m->to));
}

static uint32_t next(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

static void positions_are_rounded_once(void **state)
{
    (void)state;
    uint32_t seed = 7;
    int whole = 0, half = 0;
    for (int i = 0; i < 20000; i++) {
        const struct weft_window_map m = {.from = 1 + next(&seed) % (i % 2 ? 8 : 5000),
                                          .to = 1 + next(&seed) % (i % 3 ? 8 : 5000),
                                          .pixel = (int64_t)(next(&seed) % 4000) - 2000,
                                          .sample = (int64_t)(next(&seed) % 4000) - 2000};
        const int pixel = (int)(next(&seed) % 1000), shift = (int)(next(&seed) % 60) - 30;
        const double at = weft_window_map_position(&m, pixel, shift);
        assert_near(at, exact_position(&m, pixel, shift), 0x1p-52 * (1.0 + fabs(at)), "position");
        // What is whole, or half-way, in exact arithmetic.
        const int64_t top =
            (2 * (pixel + m.pixel) + 1) * m.from + (2 * (m.sample + shift) - 1) * m.to;
        if (top % (2 * m.to) == 0)
            whole += at == (double)(top / (2 * m.to));
        else if (top % m.to == 0)
            half += at == (double)(top / m.to) / 2.0;
        if (top % (2 * m.to) == 0)
            assert_true(at == floor(at));
        // The square that it lies in, with its edge half a sample before the centre.
        const double square = (double)weft_window_map_square(&m, pixel) + shift;
        assert_true(at >= square - 0.5 - 1e-9 && at < square + 0.5 + 1e-9);
    }
    assert_true(whole > 500 && half > 500);
    double several[5];
    const struct weft_window_map m = weft_window_map_plain(7, 11);
    weft_window_map_positions(&m, 3, 5, 2, several);
    for (int i = 0; i < 5; i++)
        assert_true(several[i] == weft_window_map_position(&m, 3 + i, 2));
}

static void plain_maps_are_symmetric(void **state)
{
    (void)state;
    for (int from = 1; from < 40; from++)
        for (int to = 1; to < 40; to++) {
            const struct weft_window_map m = weft_window_map_plain(from, to);
            for (int x = 0; x < to; x++)
                assert_near(weft_window_map_position(&m, x, 0) +
                                weft_window_map_position(&m, to - 1 - x, 0),
                            from - 1, 1e-13, "opposite pixels");
            if (to == from)
                assert_true(weft_window_map_position(&m, to - 1, 0) == to - 1);
        }
    // A pixel on the edge of two squares counts to the later one.
    const struct weft_window_map edge = weft_window_map_plain(2, 1);
    assert_int_equal(weft_window_map_square(&edge, 0), 1);
}

static const struct {
    struct weft_window data, display;
    int64_t to;
    struct weft_window new_data, new_display; // by hand
} scales[] = {
    {{0, 10}, {0, 10}, 20, {0, 20}, {0, 20}},
    {{0, 10}, {0, 10}, 5, {0, 5}, {0, 5}},
    {{2, 5}, {0, 10}, 20, {4, 10}, {0, 20}},
    {{-1, 11}, {0, 10}, 15, {-2, 17}, {0, 15}}, // -1.5 and 16.5 grow to whole pixels
    {{1, 2}, {0, 3}, 4, {1, 3}, {0, 4}},        // 1.33 and 2.67
    {{10, 20}, {10, 20}, 20, {20, 40}, {20, 40}},
    {{-5, 5}, {-5, 5}, 15, {-7, 8}, {-7, 8}}, // -7.5 + 1/2, downwards
    {{-3, 0}, {-3, 0}, 2, {-2, 0}, {-2, 0}},
    {{100, 101}, {0, 1}, 3, {300, 303}, {0, 3}},
};

static void windows_grow_to_whole_pixels(void **state)
{
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(scales); i++) {
        struct weft_window data, display;
        struct weft_window_map m;
        assert_int_equal(weft_window_map_scale(&log_to_stderr, scales[i].data, scales[i].display,
                                               scales[i].to, &data, &display, &m),
                         WEFT_OK);
        assert_int_equal(data.first, scales[i].new_data.first);
        assert_int_equal(data.end, scales[i].new_data.end);
        assert_int_equal(display.first, scales[i].new_display.first);
        assert_int_equal(display.end, scales[i].new_display.end);
        // The new data window's ends are just outside the old one's.
        const double scale = (double)m.from / (double)m.to;
        const double first = weft_window_map_position(&m, 0, 0) - 0.5 * scale;
        const double last =
            weft_window_map_position(&m, (int)(data.end - data.first) - 1, 0) + 0.5 * scale;
        const double samples = (double)(scales[i].data.end - scales[i].data.first);
        assert_true(first <= -0.5 + 1e-12 && first > -0.5 - scale);
        assert_true(last >= samples - 0.5 - 1e-12 && last < samples - 0.5 + scale);
    }
}

static void windows_have_limits(void **state)
{
    (void)state;
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    struct weft_window data, display;
    struct weft_window_map m;
    const struct weft_window one = {0, 1}, far = {1000000, 1000001};
    assert_int_equal(weft_window_map_scale(&log, far, one, 1000, &data, &display, &m), WEFT_OK);
    assert_int_equal(weft_window_map_scale(&log, far, one, 2000, &data, &display, &m),
                     WEFT_ERR_LIMIT);
    assert_non_null(strstr(message.text, "2000002000"));
    assert_non_null(strstr(message.text, "1073741823"));
    assert_int_equal(weft_window_map_scale(&log, one, one, 0, &data, &display, &m),
                     WEFT_ERR_ARGUMENT);
    assert_int_equal(m.to, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(positions_are_rounded_once),
        cmocka_unit_test(plain_maps_are_symmetric),
        cmocka_unit_test(windows_grow_to_whole_pixels),
        cmocka_unit_test(windows_have_limits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
