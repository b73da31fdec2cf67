// SPDX-License-Identifier: BSD-3-Clause
// What the CPU engine runs on, and work in parts on threads.
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "filter/threads.h"
#include "passes/cpu/cpu.h"

static void zero_asks_for_the_best(void **state)
{
    (void)state;
    struct weft_cpu cpu;
    assert_int_equal(weft_cpu_resolve(NULL, &(struct weft_cpu){0}, &cpu), WEFT_OK);
    assert_int_equal(cpu.threads, weft_cpu_threads());
    assert_int_equal(cpu.instructions, weft_instruction_set_best());
    assert_true(cpu.instructions != WEFT_INSTRUCTIONS_AUTO);
    assert_true(weft_instruction_set_runs(WEFT_INSTRUCTIONS_PLAIN));
#if defined(__x86_64__)
    assert_true(weft_instruction_set_runs(WEFT_INSTRUCTIONS_SSE2));
#endif
}

static void sets_that_do_not_run_are_refused(void **state)
{
    (void)state;
    struct weft_cpu cpu = {.threads = -5};
    for (int set = 0; weft_instruction_set_names[set]; set++) {
        const struct weft_cpu asked = {3, (enum weft_instruction_set)set};
        const bool runs = weft_instruction_set_runs(asked.instructions);
        assert_int_equal(weft_cpu_resolve(NULL, &asked, &cpu),
                         runs ? WEFT_OK : WEFT_ERR_UNSUPPORTED);
        assert_true(!runs || cpu.threads == 3);
    }
}

enum { PARTS = 1000, MOST = 7 };

struct sum {
    unsigned char times[PARTS];
    size_t stop;
    int threads;
};

static bool add(void *priv, int thread, size_t i)
{
    struct sum *sum = priv;
    if (thread < 0 || thread >= sum->threads)
        return false;
    sum->times[i]++;
    return i != sum->stop;
}

static void every_part_is_done_once(void **state)
{
    (void)state;
    for (int threads = 1; threads <= MOST; threads++) {
        struct sum sum = {.stop = PARTS, .threads = threads};
        assert_true(weft_threads_run(threads, PARTS, add, &sum));
        for (int i = 0; i < PARTS; i++)
            assert_int_equal(sum.times[i], 1);
        assert_true(weft_threads_run(threads, 0, add, &sum));
    }
}

// Parts are begun in order, so that all before the one that stops are done.
static void a_part_stops_the_rest(void **state)
{
    (void)state;
    for (int threads = 1; threads <= MOST; threads++) {
        struct sum sum = {.stop = PARTS / 2, .threads = threads};
        assert_false(weft_threads_run(threads, PARTS, add, &sum));
        for (int i = 0; i < PARTS; i++)
            assert_true(i <= PARTS / 2 ? sum.times[i] == 1 : sum.times[i] <= 1);
        assert_true(threads > 1 || sum.times[PARTS / 2 + 1] == 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(zero_asks_for_the_best),
        cmocka_unit_test(sets_that_do_not_run_are_refused),
        cmocka_unit_test(every_part_is_done_once),
        cmocka_unit_test(a_part_stops_the_rest),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
