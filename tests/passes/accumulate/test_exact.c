// SPDX-License-Identifier: BSD-3-Clause
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "tests/support/common.h"
#include "passes/accumulate/accumulate.h"

static void test_two_frames(void **state)
{
    (void)state;
    static const float first[] = {1.0f, 2.0f, -3.0f, 4.0f}, second[] = {3.0f, 2.0f, 5.0f, 0.0f};
    float out[4];
    weft_accumulator *a = NULL;
    assert_int_equal(
        weft_accumulator_create(weft_accumulator_params(.width = 2, .height = 2, .channel_count = 1,
                                                        .log = &log_to_stderr),
                                &a),
        WEFT_OK);
    const struct weft_plane planes[] = {{.values = first}, {.values = second}};
    for (int i = 0; i < 2; i++)
        assert_int_equal(weft_accumulator_add(a, &(struct weft_frame){.plane = &planes[i]}, 1.0),
                         WEFT_OK);
    assert_int_equal(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, out, 0), WEFT_OK);
    for (int i = 0; i < 4; i++)
        assert_true(out[i] == (first[i] + second[i]) / 2.0f);
    weft_accumulator_destroy(&a);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_two_frames)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
