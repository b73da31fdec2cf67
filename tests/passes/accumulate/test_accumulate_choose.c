// SPDX-License-Identifier: BSD-3-Clause
// What auto comes to, with a GPU and without, and that the bounds by which it chooses are those
// that frames then have.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <string.h>

#include "tests/support/common.h"
#include "passes/accumulate/accumulate_impl.h"

static struct weft_accumulator_params on_gpu(void)
{
    // Only whether there is one is asked.
    static int context;
    return (struct weft_accumulator_params){.width = 4,
                                            .height = 4,
                                            .channel_count = 4,
                                            .frame_count = 64,
                                            .frames_on_gl = true,
                                            .max_error = 0.1,
                                            .context = (weft_context *)(void *)&context,
                                            .log = &log_to_stderr};
}

static struct weft_accumulate_choice choose(struct weft_accumulator_params p, bool hardware)
{
    struct weft_accumulate_choice choice;
    assert_int_equal(weft_accumulate_choose(&p, hardware, &choice), WEFT_OK);
    assert_true(choice.why[0] != '\0');
    return choice;
}

static void test_exact(void **state)
{
    (void)state;
    struct weft_accumulator_params others[7];
    static const char *const why[] = {"memory",   "software", "no context",          "any number",
                                      "channels", "skips",    "no method on the GPU"};
    for (size_t i = 0; i < WEFT_COUNT(others); i++)
        others[i] = on_gpu();
    others[0].frames_on_gl = false;
    others[2].context = NULL;
    others[3].frame_count = 0;
    others[4].channel_count = 5;
    others[5].nonfinite = WEFT_NONFINITE_SKIP;
    others[6].max_error = 0.0; // what exact sums have
    for (size_t i = 0; i < WEFT_COUNT(others); i++) {
        const struct weft_accumulate_choice choice = choose(others[i], i != 1);
        assert_int_equal(choice.method, WEFT_ACCUMULATE_EXACT);
        assert_non_null(strstr(choice.why, why[i]));
    }
}

// The bound of a method by its own word: that of an accumulator before its first frame.
static double expected(struct weft_accumulator_params p, enum weft_accumulate_method method,
                       int bits)
{
    struct weft_accumulator_report report;
    weft_accumulator *a = NULL;
    p.method = method;
    p.bits = bits;
    p.emulate = true;
    p.context = NULL;
    assert_int_equal(weft_accumulator_create(&p, &a), WEFT_OK);
    weft_accumulator_get_report(a, &report);
    assert_int_equal(report.method, method);
    assert_string_equal(report.why, "asked for");
    weft_accumulator_destroy(&a);
    return report.bound;
}

static void test_on_gpu(void **state)
{
    (void)state;
    static const struct {
        enum weft_accumulate_method method;
        int bits;
    } order[] = {{WEFT_ACCUMULATE_FLOAT, 32},
                 {WEFT_ACCUMULATE_TREE, 8},
                 {WEFT_ACCUMULATE_TREE, 16},
                 {WEFT_ACCUMULATE_TREE, 32}};
    static const double weights[64] = {[0] = 2.0, [63] = -1.0};
    int chosen[WEFT_COUNT(order)] = {0}, by_exact = 0;
    for (int frames = 2; frames <= 1 << 16; frames *= 8)
        for (double error = 1e-9; error < 1.0; error *= 3.0)
            for (int propagate = 0; propagate < 2; propagate++) {
                struct weft_accumulator_params p = on_gpu();
                p.frame_count = frames;
                p.max_error = error;
                p.nonfinite = propagate ? WEFT_NONFINITE_PROPAGATE : WEFT_NONFINITE_ERROR;
                if (error < expected(p, WEFT_ACCUMULATE_EXACT, 0))
                    continue;
                const struct weft_accumulate_choice choice = choose(p, true);
                size_t first = 0;
                while (first < WEFT_COUNT(order) &&
                       ((propagate && order[first].bits != 32) ||
                        expected(p, order[first].method, order[first].bits) > error))
                    first++;
                if (first == WEFT_COUNT(order)) {
                    assert_int_equal(choice.method, WEFT_ACCUMULATE_EXACT);
                    by_exact++;
                    continue;
                }
                assert_int_equal(choice.method, order[first].method);
                assert_int_equal(choice.bits, order[first].bits);
                chosen[first]++;
            }
    // Trees of 8 and 16 bits come before what is as good and dearer: many frames in floats.
    assert_true(by_exact > 0 && chosen[0] > 0 && chosen[1] + chosen[2] > 0 && chosen[3] > 0);
    struct weft_accumulator_params p = on_gpu();
    p.weight = weights;
    assert_int_equal(choose(p, true).method, WEFT_ACCUMULATE_FLOAT);
    p.max_error = expected(on_gpu(), WEFT_ACCUMULATE_FLOAT, 32) * 0.9;
    assert_int_equal(choose(p, true).method, WEFT_ACCUMULATE_EXACT); // no tree has negative weights
    p.weight = NULL;
    assert_int_equal(choose(p, true).method, WEFT_ACCUMULATE_TREE);
}

static void test_nothing(void **state)
{
    (void)state;
    struct message kept = {0};
    const struct weft_log log = {keep_message, &kept};
    struct weft_accumulator_params p = on_gpu();
    struct weft_accumulate_choice choice;
    weft_accumulator *a = NULL;
    p.log = &log;
    p.max_error = 1e-9;
    p.high = 1000.0;
    for (int hardware = 0; hardware < 2; hardware++)
        assert_int_equal(weft_accumulate_choose(&p, hardware, &choice), WEFT_ERR_UNSUPPORTED);
    assert_non_null(strstr(kept.text, "no method is within 1e-09 for values from 0 to 1000"));
    p.context = NULL;
    assert_int_equal(weft_accumulator_create(&p, &a), WEFT_ERR_UNSUPPORTED);
    assert_null(a);
    p.max_error = 1e-4;
    assert_int_equal(weft_accumulator_create(&p, &a), WEFT_OK);
    struct weft_accumulator_report report;
    weft_accumulator_get_report(a, &report);
    assert_int_equal(report.method, WEFT_ACCUMULATE_EXACT);
    assert_true(report.bound <= 1e-4);
    weft_accumulator_destroy(&a);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact),
        cmocka_unit_test(test_on_gpu),
        cmocka_unit_test(test_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
