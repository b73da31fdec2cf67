// SPDX-License-Identifier: BSD-3-Clause
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <pthread.h>
#include <stdatomic.h>
#include <unistd.h>

#include "tiles/output/order.h"

enum { ITEMS = 500, SLOTS = 40, NEVER = ITEMS + 1 };

struct work {
    size_t held[SLOTS]; // 1 more than the item; 0: free
    size_t taken, fail_make, fail_take, stop;
    atomic_int taking, faults;
    atomic_size_t made;
    pthread_t caller;
};

static bool make(void *priv, int thread, size_t i, size_t slot)
{
    struct work *w = priv;
    w->faults += w->held[slot] != 0;
    w->faults += (thread == 0) != (pthread_equal(pthread_self(), w->caller) != 0);
    if (i % 7 == 0)
        usleep((unsigned)(i % 5) * 20);
    w->held[slot] = i + 1;
    w->made++;
    return i != w->fail_make;
}

static bool take(void *priv, size_t i, size_t slot)
{
    struct work *w = priv;
    w->faults += w->taking++ != 0;
    w->faults += i != w->taken || w->held[slot] != i + 1;
    w->held[slot] = 0;
    w->taken++;
    w->taking--;
    return i != w->fail_take;
}

static bool ask(void *priv, size_t taken)
{
    struct work *w = priv;
    w->faults += !pthread_equal(pthread_self(), w->caller);
    return taken < w->stop;
}

static bool run(struct work *w, int threads, size_t slots, size_t count)
{
    const struct weft_order order = {.threads = threads,
                                     .count = count,
                                     .slots = slots,
                                     .make = make,
                                     .take = take,
                                     .ask = ask,
                                     .priv = w};
    w->caller = pthread_self();
    const bool whole = weft_order_run(&order);
    assert_int_equal(w->faults, 0);
    return whole;
}

static void test_all_in_order(void **state)
{
    (void)state;
    static const size_t slots[] = {1, 2, 3, 10, SLOTS};
    for (int threads = 1; threads <= 8; threads++) {
        for (size_t s = 0; s < 5; s++) {
            struct work w = {.fail_make = NEVER, .fail_take = NEVER, .stop = NEVER};
            assert_true(run(&w, threads, slots[s], ITEMS));
            assert_true(w.taken == ITEMS && w.made == ITEMS);
        }
    }
    struct work w = {.fail_make = NEVER, .fail_take = NEVER, .stop = NEVER};
    assert_true(run(&w, 4, 4, 0));
    assert_true(run(&w, 4, 4, 1));
    assert_int_equal(w.taken, 1);
}

// Nothing is begun once a call has failed, and nothing behind that item is taken.
static void test_failures(void **state)
{
    (void)state;
    for (int threads = 1; threads <= 8; threads += 3) {
        for (size_t at = 0; at < ITEMS; at += 61) {
            struct work w = {.fail_make = at, .fail_take = NEVER, .stop = NEVER};
            assert_false(run(&w, threads, 5, ITEMS));
            assert_true(w.taken <= at && w.made <= at + 5);
            w = (struct work){.fail_make = NEVER, .fail_take = at, .stop = NEVER};
            assert_false(run(&w, threads, 5, ITEMS));
            assert_true(w.taken == at + 1 && w.made <= at + 6);
            w = (struct work){.fail_make = NEVER, .fail_take = NEVER, .stop = at};
            const bool whole = run(&w, threads, 5, ITEMS);
            assert_true(whole ? threads > 1 && w.taken == ITEMS : w.taken >= at);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_all_in_order),
        cmocka_unit_test(test_failures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
