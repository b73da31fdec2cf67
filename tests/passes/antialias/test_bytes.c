// SPDX-License-Identifier: BSD-3-Clause
// Bytes by formula: the figures of both papers, and counts that are none.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <limits.h>
#include <string.h>

#include "tests/support/common.h"
#include "passes/antialias/pattern/bytes.h"

// Enderton and others: "759 MB" and "316 MB" at 3840 x 2160 with 8 samples, of 2^20 bytes.
static void test_accumulative(void **state)
{
    (void)state;
    const uint64_t msaa = weft_bytes_multisample(3840, 2160, 8, 8, 4);
    const uint64_t acaa = weft_bytes_accumulative(3840, 2160, 8, 8, 4);
    assert_int_equal(msaa, UINT64_C(96) * 3840 * 2160);
    assert_int_equal(acaa, UINT64_C(40) * 3840 * 2160);
    assert_near((double)msaa / 0x1p20, 759.0, 0.5, "MSAA, 8 samples");
    assert_near((double)acaa / 0x1p20, 316.0, 0.5, "ACAA, 8 samples");
}

// Lin and others, 512 x 512 with 4 x 4 samples of 24 bits and depths of 32, in 10^6 bytes: 29.3 of
// all pixels (cut, not rounded), 7.5, 4.6 and 18 of 15.7, 5.8 and 51.5 % of them.
static void test_adaptive(void **state)
{
    static const struct {
        double share, megabytes, digits;
    } paper[] = {{0.157, 7.5, 0.05}, {0.058, 4.6, 0.05}, {0.515, 18.0, 0.5}};
    const double pixels = 512.0 * 512.0;
    (void)state;
    assert_near(floor((double)weft_bytes_multisample(512, 512, 16, 3, 4) / 1e5) / 10.0, 29.3, 1e-9,
                "full supersampling");
    assert_int_equal(weft_bytes_adaptive(512, 512, 0, 16, 3, 4), 512 * 512 * 11);
    for (size_t i = 0; i < WEFT_COUNT(paper); i++) {
        const int64_t edges = llround(paper[i].share * pixels);
        const uint64_t bytes = weft_bytes_adaptive(512, 512, edges, 16, 3, 4);
        assert_int_equal(bytes, 512 * 512 * 11 + 112 * edges);
        assert_near((double)bytes / 1e6, paper[i].megabytes, paper[i].digits, "edge pixels");
        // "< 20 %", "< 10 %", and "< 50 %", which its own 18 MB are a little more than.
        assert_true(paper[i].share < 0.2 || i == 2);
    }
    // Where the text's own shares are: 10 MB at 20 %, and 4.6 MB at 5.8.
    assert_true((double)weft_bytes_adaptive(512, 512, llround(0.2 * pixels), 16, 3, 4) < 10e6);
}

// Shares of MSAA's bytes: half or less for float colours with the paper's sums, not for 8 bits or
// sums of three or four integers beside 8-bit or half colours.
static void test_shares(void **state)
{
    static const struct {
        int colour, sum, samples;
        double share;
    } rows[] = {{4, 4, 4, 0.62},    {4, 4, 8, 0.56},  {4, 4, 16, 0.53},  {8, 8, 4, 0.50},
                {8, 8, 8, 0.42},    {8, 8, 16, 0.38}, {16, 16, 4, 0.40}, {16, 16, 8, 0.30},
                {16, 16, 16, 0.25}, {4, 12, 4, 0.88}, {4, 12, 8, 0.69},  {4, 12, 16, 0.59}};
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(rows); i++) {
        const double msaa =
            (double)weft_bytes_multisample(100, 10, rows[i].samples, rows[i].colour, 4);
        const double acaa =
            (double)weft_bytes_accumulative(100, 10, rows[i].samples, rows[i].sum, 4);
        assert_near(acaa / msaa, rows[i].share, 0.0051, "share");
        if (rows[i].colour >= 8)
            assert_true(acaa <= 0.5 * msaa);
        else
            assert_true(acaa > 0.5 * msaa);
    }
}

static void test_formats(void **state)
{
    static const char *const names[] = {"8", "16f", "32f"};
    static const int bytes[] = {4, 8, 16};
    (void)state;
    for (int i = 0; i < WEFT_ANTIALIAS_FORMAT_COUNT; i++) {
        assert_string_equal(weft_antialias_format_names[i], names[i]);
        assert_int_equal(weft_antialias_format_bytes((enum weft_antialias_format)i), bytes[i]);
    }
    assert_null(weft_antialias_format_names[WEFT_ANTIALIAS_FORMAT_COUNT]);
    assert_int_equal(weft_antialias_format_bytes(WEFT_ANTIALIAS_FORMAT_COUNT), 0);
}

static void test_extremes(void **state)
{
    (void)state;
    assert_int_equal(weft_bytes_multisample(0, 5, 4, 4, 4), 0);
    assert_int_equal(weft_bytes_multisample(5, -5, 4, 4, 4), 0);
    assert_int_equal(weft_bytes_multisample(5, 5, -4, 4, 4), 0);
    assert_int_equal(weft_bytes_adaptive(5, 5, -1, 16, 3, 4), 25 * 11);
    assert_true(weft_bytes_multisample(INT32_MAX, INT32_MAX, INT_MAX, INT_MAX, INT_MAX) ==
                UINT64_MAX);
    assert_true(weft_bytes_accumulative(INT32_MAX, INT32_MAX, INT_MAX, INT_MAX, INT_MAX) ==
                UINT64_MAX);
    assert_true(weft_bytes_adaptive(INT32_MAX, INT32_MAX, INT64_MAX, INT_MAX, INT_MAX, INT_MAX) ==
                UINT64_MAX);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_accumulative), cmocka_unit_test(test_adaptive),
        cmocka_unit_test(test_shares),       cmocka_unit_test(test_formats),
        cmocka_unit_test(test_extremes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
