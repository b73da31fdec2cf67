// SPDX-License-Identifier: BSD-3-Clause
// Plans that say that nothing clamps are run in integers, on constants of every level and on noise:
// no store clamps. WEFT_CLAMP_PLANS=N takes every Nth plan of the sweep (1: all, some minutes).
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "tests/support/plan_runs.h"
#include "filter/check.h"
#include "tests/support/plans.h"
#include "weft.h"

enum { EVERY = 499, SIDE = 7, MOST_PIXELS = 16 * 16 * 16 };

static const int sample_counts[2][3] = {{4, 7, 16}, {4, 5, 8}}; // 2D, 3D

static uint64_t seed = 20030203;

static uint32_t random_next(void)
{
    seed = seed * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)(seed >> 33);
}

// A pixel at every sample position: along y, M^2 of them go through y and z.
static struct weft_pixel_grid all_positions(const struct weft_pass_plan_info *info)
{
    const int m = info->samples, rows = info->dims > 2 ? m * m : m;
    struct weft_pixel_grid grid = {.width = m, .height = rows};
    grid.origin[0] = 0.5 / m;
    grid.origin[1] = 0.5 / m;
    grid.du[0] = grid.dv[1] = 1.0 / m;
    if (info->dims > 2) {
        grid.origin[2] = 0.5 / rows;
        grid.dv[2] = 1.0 / rows;
    }
    return grid;
}

static float pixels[MOST_PIXELS];

static double run(const weft_pass_plan *plan, const float *plane, int size)
{
    const struct weft_pass_plan_info *info = weft_pass_plan_get_info(plan);
    const struct weft_pixel_grid grid = all_positions(info);
    const struct weft_samples samples = {
        .size = {size, size, info->dims > 2 ? size : 1}, .plane = {plane}, .low = 0.0, .high = 1.0};
    const struct weft_multipass_run_params params = {
        .samples = &samples, .grid = &grid, .pixels = {pixels}, .log = &log_to_stderr};
    struct weft_multipass_report report;
    assert_true(grid.width * grid.height <= MOST_PIXELS);
    assert_int_equal(run_plan(NULL, plan, &params, &report), WEFT_OK);
    return report.largest_clamp;
}

// Of codes of 16 bits, some.
static double run_constants(const weft_pass_plan *plan)
{
    const int one = weft_target_one(weft_pass_plan_get_info(plan)->profile.target);
    double largest = 0.0;
    for (int level = 0; level <= one; level++) {
        const float value = (float)level / (float)one;
        largest = larger(largest, run(plan, &value, 1));
        level += one > 255 ? (int)(random_next() % 1000) : 0;
    }
    const float white = 1.0f;
    return larger(largest, run(plan, &white, 1));
}

static double run_noise(const weft_pass_plan *plan)
{
    static float plane[SIDE * SIDE * SIDE];
    double largest = 0.0;
    for (int n = 0; n < 20; n++) {
        for (size_t i = 0; i < WEFT_COUNT(plane); i++)
            plane[i] = n % 2 ? (float)(random_next() & 1) : (float)random_next() * 0x1p-31f;
        largest = larger(largest, run(plan, plane, SIDE));
    }
    return largest;
}

struct tally {
    int number, every, plans, refused, natural, clamping;
};

static void check_plan(const struct weft_pass_plan_params *params, struct tally *tally)
{
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    struct weft_pass_plan_params p = *params;
    weft_pass_plan *plan = NULL;
    p.log = &log;
    const enum weft_result res = weft_pass_plan_create(&p, &plan);
    if (res != WEFT_OK) {
        if (res != WEFT_ERR_UNSUPPORTED && res != WEFT_ERR_LIMIT)
            fail_msg("%s: %s", weft_result_text(res), message.text);
        tally->refused++;
        return;
    }
    const struct weft_pass_plan_info *info = weft_pass_plan_get_info(plan);
    const bool any = p.worst_case == WEFT_WORST_ANY;
    const double clamped = any ? larger(run_constants(plan), run_noise(plan)) : run_constants(plan);
    if ((info->valid && clamped != 0.0) || (p.order == WEFT_ORDER_PLANNED && !info->valid))
        fail_msg("clamps by up to %g codes:\n%s", clamped, info->text);
    // With 8 bits every level is followed, so that what clamps is seen to.
    const bool exact = p.profile.target == WEFT_TARGET_UNORM8 && !any &&
                       p.technique != WEFT_TECHNIQUE_LOG && isinf(p.profile.internal_range);
    if (exact && !info->valid && clamped == 0.0)
        fail_msg("nothing clamps, says the emulation:\n%s", info->text);
    tally->plans++;
    tally->natural += p.order != WEFT_ORDER_PLANNED;
    tally->clamping += !info->valid;
    weft_pass_plan_destroy(&plan);
}

static void check_kernel(const struct weft_kernel *kernel, int dims, struct tally *tally)
{
    static const char *const profiles[] = {"unorm8", "unorm8,taps=1", "unorm16", "geforce3",
                                           "radeon8500"};
    enum { MEANS = 5 * 5 * 3 * 3 };
    for (int i = 0; i < MEANS; i++) {
        struct weft_pass_plan_params *p =
            weft_pass_plan_params(.kernel = *kernel, .dims = dims,
                                  .profile = profile_named(profiles[i % 5]),
                                  .technique = (enum weft_technique)(i / 5 % 5),
                                  .samples = sample_counts[dims - 2][i / 25 % 3]);
        p->worst_case = i / 75 == 1 ? WEFT_WORST_ANY : WEFT_WORST_CONSTANT;
        p->order = i / 75 == 2 ? WEFT_ORDER_NATURAL : WEFT_ORDER_PLANNED;
        if (tally->number++ % tally->every == 0)
            check_plan(p, tally);
    }
}

static void no_store_clamps(void **state)
{
    (void)state;
    struct tally tally = {.every = EVERY};
    if (getenv("WEFT_CLAMP_PLANS"))
        tally.every = atoi(getenv("WEFT_CLAMP_PLANS"));
    assert_true(tally.every > 0);
    for (const struct weft_kernel_info *const *k = weft_kernel_list; *k; k++) {
        const struct weft_kernel kernel = kernel_named((*k)->name);
        for (int dims = 2; kernel.width <= 4 && dims <= 3; dims++)
            check_kernel(&kernel, dims, &tally);
    }
    print_message("%d plans, %d of them natural orders, %d that clamp; %d refused\n", tally.plans,
                  tally.natural, tally.clamping, tally.refused);
    assert_true(tally.plans > tally.number / tally.every * 9 / 10);
    assert_in_range(tally.clamping, 1, tally.natural);
    assert_true(tally.clamping < tally.plans);
}

// Not allowed to scale, a planned order says by how much roundings clamp, and its bound counts it.
static void without_a_scale_clamping_is_told(void **state)
{
    (void)state;
    static const char *const kernels[] = {"bspline", "catmull-rom", "cardinal:1.5", "mitchell"};
    int clamping = 0, valid = 0;
    for (size_t i = 0; i < WEFT_COUNT(kernels); i++) {
        for (int dims = 2; dims <= 3; dims++) {
            weft_pass_plan *plan = NULL;
            if (weft_pass_plan_create(weft_pass_plan_params(.kernel = kernel_named(kernels[i]),
                                                            .dims = dims, .samples = 4,
                                                            .taps_per_pass = 1, .no_scale = true),
                                      &plan) != WEFT_OK)
                continue;
            const struct weft_pass_plan_info *info = weft_pass_plan_get_info(plan);
            const double clamped = run_constants(plan), told = 255.0 * info->range.overflow;
            print_message("%-12s %dD: clamps by %g codes, told %.2f\n", kernels[i], dims, clamped,
                          told);
            assert_int_equal(info->valid, clamped == 0.0);
            assert_true(clamped <= told + 1e-9);
            const struct weft_pass_plan_error *e = &info->error;
            assert_true(e->bound >= e->source + e->e2 + e->e3 + info->range.overflow - 1e-12);
            clamping += clamped > 0.0;
            valid += info->valid;
            weft_pass_plan_destroy(&plan);
        }
    }
    assert_true(clamping > 0 && valid > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_store_clamps),
        cmocka_unit_test(without_a_scale_clamping_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
