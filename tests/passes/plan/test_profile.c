// SPDX-License-Identifier: BSD-3-Clause
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "tests/support/common.h"
#include "passes/plan/profile.h"

static void the_list_holds_what_it_says(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        enum weft_target_format target;
        int internal_bits;
        double range;
        int taps, dot, max_scale;
        bool ping_pong;
    } cases[] = {
        {"fp32", WEFT_TARGET_FLOAT, 0, INFINITY, 8, 4, 0, true},
        {"fp16", WEFT_TARGET_HALF, 0, INFINITY, 8, 4, 0, true},
        {"unorm16", WEFT_TARGET_UNORM16, 0, INFINITY, 8, 4, 0, true},
        {"unorm8", WEFT_TARGET_UNORM8, 0, INFINITY, 8, 4, 0, true},
        {"geforce3", WEFT_TARGET_UNORM8, 9, 1.0, 2, 3, 4, false},
        {"radeon8500", WEFT_TARGET_UNORM8, 12, 8.0, 3, 4, 8, false},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const struct weft_profile *p = weft_profile_find(cases[i].name);
        assert_non_null(p);
        assert_ptr_equal(p, weft_profile_list[i]);
        assert_int_equal(p->target, cases[i].target);
        assert_int_equal(p->internal_bits, cases[i].internal_bits);
        assert_true(p->internal_range == cases[i].range);
        assert_int_equal(p->taps_per_pass, cases[i].taps);
        assert_int_equal(p->dot_width, cases[i].dot);
        assert_int_equal(p->max_scale, cases[i].max_scale);
        assert_int_equal(p->ping_pong, cases[i].ping_pong);
    }
    assert_null(weft_profile_list[WEFT_COUNT(cases)]);
    assert_null(weft_profile_find("voodoo"));
}

static void targets_have_bits(void **state)
{
    (void)state;
    assert_int_equal(weft_target_bits(WEFT_TARGET_UNORM8), 8);
    assert_int_equal(weft_target_one(WEFT_TARGET_UNORM8), 255);
    assert_int_equal(weft_target_one(WEFT_TARGET_UNORM16), 65535);
    assert_int_equal(weft_target_bits(WEFT_TARGET_HALF), 0);
    assert_string_equal(weft_target_name(WEFT_TARGET_FLOAT), "float");
}

static void users_write_their_own(void **state)
{
    (void)state;
    struct weft_profile p;
    assert_int_equal(weft_profile_parse(&log_to_stderr, "radeon8500", &p), WEFT_OK);
    assert_memory_equal(&p, weft_profile_find("radeon8500"), sizeof p);
    assert_int_equal(weft_profile_parse(&log_to_stderr,
                                        "geforce3,taps=1,range=2,internal-bits=10,ping-pong=yes",
                                        &p),
                     WEFT_OK);
    assert_string_equal(p.name, "geforce3,taps=1,range=2,internal-bits=10,ping-pong=yes");
    assert_int_equal(p.taps_per_pass, 1);
    assert_true(p.internal_range == 2.0);
    assert_int_equal(p.internal_bits, 10);
    assert_true(p.ping_pong);
    assert_int_equal(p.dot_width, 3); // as geforce3
    assert_int_equal(weft_profile_parse(&log_to_stderr, "target=unorm16,dot=1,max-scale=2", &p),
                     WEFT_OK);
    assert_int_equal(p.target, WEFT_TARGET_UNORM16); // the rest as unorm8
    assert_int_equal(p.taps_per_pass, 8);
    assert_int_equal(p.dot_width, 1);
    assert_int_equal(p.max_scale, 2);
    assert_int_equal(weft_profile_parse(&log_to_stderr, "range=inf", &p), WEFT_OK);
    assert_true(isinf(p.internal_range));
}

static void mistakes_are_named(void **state)
{
    (void)state;
    static const struct {
        const char *text, *message;
    } cases[] = {
        {"voodoo", "no profile 'voodoo'; there are fp32, fp16, unorm16, unorm8, geforce3"},
        {"", "no profile ''"},
        {"unorm8,bits=3", "no KEY=VALUE 'bits=3'; there are target, internal-bits, range"},
        {"unorm8,taps", "no KEY=VALUE 'taps'; there are target"},
        {"taps=0", "taps takes a number from 1 to 16, not '0'"},
        {"taps=1.5", "taps takes a whole number, not '1.5'"},
        {"taps=many", "taps takes a number from 1 to 16, not 'many'"},
        {"dot=2", "dot takes 1, 3 or 4, not 2"},
        {"max-scale=3", "max-scale takes a power of two or 0, not 3"},
        {"ping-pong=maybe", "ping-pong takes yes or no, not 'maybe'"},
        {"target=rgb565", "target takes unorm8, unorm16, half or float, not 'rgb565'"},
        {"range=0.5", "range takes a number from 1 to 1024, not '0.5'"},
        {"internal-bits=7", "7 bits inside a pass are fewer than the target's 8"},
        {"fp16,internal-bits=12", "a half target has no fraction bits inside"},
        {"unorm8,taps=1,taps=1,taps=1,taps=1,taps=1,taps=1,taps=1,taps=1,taps=1", "longer than 63"},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct message message = {.count = 0};
        const struct weft_log log = {keep_message, &message};
        struct weft_profile p;
        assert_int_equal(weft_profile_parse(&log, cases[i].text, &p), WEFT_ERR_ARGUMENT);
        assert_int_equal(message.count, 1);
        if (!strstr(message.text, cases[i].message))
            fail_msg("'%s' is not in '%s'", cases[i].message, message.text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_list_holds_what_it_says),
        cmocka_unit_test(targets_have_bits),
        cmocka_unit_test(users_write_their_own),
        cmocka_unit_test(mistakes_are_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
