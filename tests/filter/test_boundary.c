// SPDX-License-Identifier: BSD-3-Clause
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "filter/boundary.h"

// Written out: indices -9 to 9 of four samples, and of one.
static void rules_are_what_they_say(void **state)
{
    (void)state;
    static const char *const four[] = {"aaaaaaaaaabcddddddd", "dcbabcdcbabcdcbabcd",
                                       "dabcdabcdabcdabcdab", "---------abcd------"};
    for (int b = 0; b < WEFT_BOUNDARY_COUNT; b++) {
        for (int i = -9; i <= 9; i++) {
            const int64_t at = weft_boundary_index((enum weft_boundary)b, i, 4);
            const int64_t one = weft_boundary_index((enum weft_boundary)b, i, 1);
            assert_int_equal(at < 0 ? '-' : 'a' + (int)at, four[b][i + 9]);
            assert_int_equal(one, b == WEFT_BOUNDARY_BORDER && i != 0 ? -1 : 0);
        }
        assert_non_null(weft_boundary_names[b]);
    }
    assert_null(weft_boundary_names[WEFT_BOUNDARY_COUNT]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(rules_are_what_they_say)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
