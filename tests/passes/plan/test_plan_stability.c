// SPDX-License-Identifier: BSD-3-Clause
// Each technique beside the naive way that it replaces, where that fails.
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

enum { SIDE = 8, M = 8, SHIFTED = SIDE * M };

// ---- images -------------------------------------------------------------------------------------

struct result {
    float pixels[SHIFTED * SHIFTED];
    struct weft_multipass_report report;
    struct weft_verify_report error;
};

// M pixels a sample, at the centres of the tiles' samples: what is looked up is the weight itself.
// Whatever a plan does, clamping too, is within its bound and a few roundings of results to floats.
static void emulate(const weft_pass_plan *plan, const struct weft_samples *samples,
                    struct result *out)
{
    const double step = 1.0 / M;
    struct weft_pixel_grid grid = {
        .width = SHIFTED, .height = SHIFTED, .du = {step}, .dv = {0, step}};
    for (int a = 0; a < 3; a++)
        grid.origin[a] =
            samples->size[a] > SIDE ? 0.5 * samples->size[a] - SIDE / 2 + 0.5 * step : 0.5 * step;
    if (samples->size[2] == 1)
        grid.origin[2] = 0.0;
    const struct weft_multipass_run_params params = {
        .samples = samples, .grid = &grid, .pixels = {out->pixels}, .log = &log_to_stderr};
    assert_int_equal(run_plan(NULL, plan, &params, &out->report), WEFT_OK);
    assert_int_equal(verify_plan(plan, &params, &out->error), WEFT_OK);
    const double low = out->report.low, high = out->report.high;
    const double bound = weft_pass_plan_get_info(plan)->error.bound_any * (high - low) +
                         4.0 * 0x1p-24 * fmax(fabs(low), fabs(high));
    assert_true(out->error.maximum <= bound && out->error.not_finite_mismatches == 0);
}

static void emulate_constant(const weft_pass_plan *plan, float level, struct result *out)
{
    float plane[SIDE * SIDE * SIDE];
    const int depth = weft_pass_plan_get_info(plan)->dims > 2 ? SIDE : 1;
    for (size_t i = 0; i < WEFT_COUNT(plane); i++)
        plane[i] = level;
    const struct weft_samples samples = {
        .size = {SIDE, SIDE, depth}, .plane = {plane}, .low = 0.0, .high = 1.0};
    emulate(plan, &samples, out);
}

// ---- orders -------------------------------------------------------------------------------------

static void naive_orders_clamp(void **state)
{
    (void)state;
    static struct result naive, planned;
    for (int dims = 2; dims <= 3; dims++) {
        struct weft_pass_plan_params *p =
            weft_pass_plan_params(.dims = dims, .samples = M, .taps_per_pass = 1,
                                  .order = WEFT_ORDER_NATURAL);
        weft_pass_plan *plan = make_plan(p);
        const struct weft_range_report range = weft_pass_plan_get_info(plan)->range;
        assert_false(weft_pass_plan_get_info(plan)->valid);
        emulate_constant(plan, 1.0f, &naive);
        weft_pass_plan_destroy(&plan);
        p->order = WEFT_ORDER_PLANNED;
        plan = make_plan(p);
        assert_true(weft_pass_plan_get_info(plan)->valid);
        emulate_constant(plan, 1.0f, &planned);
        weft_pass_plan_destroy(&plan);
        print_message("Catmull-Rom %dD, constant 1.0: naive order leaves [0, 1] in pass %d (%.3f), "
                      "%llu stores clamp by up to %.0f codes, error %.3f; planned order %.3f\n",
                      dims, range.pass, range.value, (unsigned long long)naive.report.clamps,
                      naive.report.largest_clamp, naive.error.maximum, planned.error.maximum);
        assert_true(naive.report.clamps > 0);
        assert_true(naive.error.maximum > 20.0 / 255.0);
        assert_int_equal(planned.report.clamps, 0);
        // Roundings are left a margin, by a scale that white is rounded with, too.
        assert_true(planned.error.maximum < 0.1 * naive.error.maximum);
    }
}

// The range report names what the emulation shows: the first pass that clamps on a constant.
static void wrong_orders_are_named(void **state)
{
    (void)state;
    weft_pass_plan *plan = make_plan(
        weft_pass_plan_params(.samples = M, .taps_per_pass = 1, .order = WEFT_ORDER_NATURAL));
    const struct weft_pass_plan_info *info = weft_pass_plan_get_info(plan);
    const struct weft_pass_list *list = info->passes;
    const int *at = info->range.position;
    double sum = 0.0;
    for (int n = 0; n <= info->range.pass; n++) {
        const int tile = list->groups[list->passes[n].group_first].tile[0];
        if (n < info->range.pass)
            for (int k = 0; k < M * M; k++) {
                double before = 0.0;
                for (int i = 0; i <= n; i++)
                    before += weft_kernel_tiles_value(
                        list->tiles, list->groups[list->passes[i].group_first].tile[0],
                        (const int[3]){k % M, k / M, 0});
                assert_true(before > -1e-9 && before < 1.0 + 1e-9);
            }
        sum += weft_kernel_tiles_value(list->tiles, tile, at);
    }
    assert_near(sum, info->range.value, 1e-9, "the value of the first pass that leaves");
    assert_true(sum < 0.0 || sum > 1.0);
    assert_non_null(strstr(info->text, "INVALID"));
    weft_pass_plan_destroy(&plan);
}

// ---- weights ------------------------------------------------------------------------------------

static void weights_rounded_singly_ripple(void **state)
{
    (void)state;
    static struct result singly, exact;
    for (int dims = 2; dims <= 3; dims++) {
        struct weft_pass_plan_params *p =
            weft_pass_plan_params(.dims = dims, .samples = M, .round_singly = true);
        weft_pass_plan *plan = make_plan(p);
        emulate_constant(plan, 1.0f, &singly);
        weft_pass_plan_destroy(&plan);
        p->round_singly = false;
        plan = make_plan(p);
        emulate_constant(plan, 1.0f, &exact);
        weft_pass_plan_destroy(&plan);
        print_message(
            "Catmull-Rom %dD: constant 1.0 ripples by %.2f LSB with weights rounded one by "
            "one, by %.2f with sums kept\n",
            dims, 255.0 * singly.error.maximum, 255.0 * exact.error.maximum);
        assert_true(singly.error.maximum > 0.9 / 255.0);
        // In 3D roundings of passes are left a margin, which takes up to a code.
        assert_true(exact.error.maximum < (dims > 2 ? 1.01 / 255.0 : 1e-6));
        assert_int_equal(exact.report.clamps, 0);
    }
}

static void a_single_bias_clamps(void **state)
{
    (void)state;
    static struct result single, spread;
    for (int dims = 2; dims <= 3; dims++) {
        struct weft_pass_plan_params *p =
            weft_pass_plan_params(.dims = dims, .derivative = {{1, 0, 0}}, .samples = M,
                                  .taps_per_pass = 1, .order = WEFT_ORDER_NATURAL,
                                  .single_bias = true);
        weft_pass_plan *plan = make_plan(p);
        const bool valid = weft_pass_plan_get_info(plan)->valid;
        emulate_constant(plan, 1.0f, &single);
        weft_pass_plan_destroy(&plan);
        p->order = WEFT_ORDER_PLANNED;
        p->single_bias = false;
        plan = make_plan(p);
        emulate_constant(plan, 1.0f, &spread);
        print_message("gradient along x, %dD, of a constant: one bias of 0.5 in front %llu stores "
                      "clamp, gradient %.3f instead of 0; spread over the passes %llu, %.3f\n",
                      dims, (unsigned long long)single.report.clamps, single.error.maximum,
                      (unsigned long long)spread.report.clamps, spread.error.maximum);
        assert_false(valid);
        assert_true(single.report.clamps > 0 && single.error.maximum > 0.04);
        assert_true(weft_pass_plan_get_info(plan)->valid);
        assert_int_equal(spread.report.clamps, 0);
        assert_true(spread.error.maximum <= weft_pass_plan_get_info(plan)->error.bound);
        assert_true(spread.error.maximum < 0.25 * single.error.maximum);
        weft_pass_plan_destroy(&plan);
    }
}

// ---- long sums ----------------------------------------------------------------------------------

static void fill_marschner_lobb(float *plane, int size)
{
    const struct weft_signal_info *signal = weft_signal_find("marschner-lobb");
    for (int z = 0; z < size; z++)
        for (int y = 0; y < size; y++)
            for (int x = 0; x < size; x++) {
                const double at[3] = {weft_signal_coordinate(x, size),
                                      weft_signal_coordinate(y, size),
                                      weft_signal_coordinate(z, size)};
                plane[(z * size + y) * size + x] = (float)signal->value(at);
            }
}

// The volume's densest 40^3, or NULL where it is not there.
static float *load_mri(int size)
{
    weft_volume *volume = NULL;
    const struct weft_volume_open_params open = {.path = WEFT_TEST_DATA "/mri.vdb"};
    if (weft_volume_open(&open, &volume) != WEFT_OK)
        return NULL;
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    struct weft_region region;
    struct weft_brick_list list;
    float *plane = calloc((size_t)(size * size * size), sizeof *plane);
    assert_non_null(plane);
    memset(&region, 0, sizeof region);
    for (int a = 0; a < 3; a++) {
        region.min[a] = (info->active_min[a] + info->active_max[a] - size) / 2;
        region.max[a] = region.min[a] + size - 1;
    }
    assert_int_equal(weft_volume_find(volume, &region, &list), WEFT_OK);
    float *values = malloc(list.brick_count * WEFT_BRICK_VOXELS * sizeof *values + 1);
    assert_non_null(values);
    assert_int_equal(
        weft_volume_read(volume, list.brick_count, (const int32_t(*)[3])list.brick_origin, values),
        WEFT_OK);
    for (size_t b = 0; b < list.brick_count; b++)
        for (int i = 0; i < WEFT_BRICK_VOXELS; i++) {
            const int x = list.brick_origin[b][0] + i % 8 - region.min[0];
            const int y = list.brick_origin[b][1] + i / 8 % 8 - region.min[1];
            const int z = list.brick_origin[b][2] + i / 64 - region.min[2];
            if (x >= 0 && x < size && y >= 0 && y < size && z >= 0 && z < size)
                plane[(z * size + y) * size + x] = values[b * WEFT_BRICK_VOXELS + (size_t)i];
        }
    free(values);
    weft_brick_list_clear(&list);
    weft_volume_destroy(&volume);
    return plane;
}

// 64 passes of one tap each on 8 bits: high and low parts lose less than plain sums, groups that
// use their target's range (and whose tiles use theirs) still less.
static void compare_long_sums(const char *name, const float *plane, int size)
{
    static const enum weft_technique techniques[] = {
        WEFT_TECHNIQUE_PLAIN, WEFT_TECHNIQUE_HIERARCHICAL, WEFT_TECHNIQUE_SPLIT_PRECISION};
    static const char *const kernels[] = {"bspline", "catmull-rom"};
    static struct result result;
    const struct weft_samples samples = {
        .size = {size, size, size}, .plane = {plane}, .low = NAN, .high = NAN};
    for (size_t k = 0; k < WEFT_COUNT(kernels); k++) {
        double rms[3], most[3];
        for (size_t t = 0; t < WEFT_COUNT(techniques); t++) {
            weft_pass_plan *plan = make_plan(
                weft_pass_plan_params(.kernel = kernel_named(kernels[k]), .dims = 3, .samples = M,
                                      .taps_per_pass = 1, .technique = techniques[t]));
            const struct weft_pass_plan_info *info = weft_pass_plan_get_info(plan);
            emulate(plan, &samples, &result);
            const double width = result.report.high - result.report.low;
            rms[t] = 255.0 * result.error.rms / width;
            most[t] = 255.0 * result.error.maximum / width;
            print_message("%-15s %-12s %-16s %3d passes: maximum %6.3f LSB, rms %6.3f, bound "
                          "%.1f\n",
                          name, kernels[k], weft_technique_names[techniques[t]],
                          info->passes->pass_count, most[t], rms[t], 255.0 * info->error.bound_any);
            weft_pass_plan_destroy(&plan);
        }
        assert_true(rms[0] > rms[1] && rms[1] > rms[2]);
        assert_true(most[0] > most[1] && most[1] > most[2]);
    }
}

static void long_sums_lose_bits(void **state)
{
    (void)state;
    enum { SIZE = 40 };
    float *plane = malloc(SIZE * SIZE * SIZE * sizeof *plane);
    assert_non_null(plane);
    fill_marschner_lobb(plane, SIZE);
    compare_long_sums("marschner-lobb", plane, SIZE);
    free(plane);
    plane = load_mri(SIZE);
    if (plane)
        compare_long_sums("mri.vdb", plane, SIZE);
    else
        print_message("[  SKIPPED ] mri.vdb is not there\n");
    free(plane);
}

// Half floats that truncate drift; the bound knows.
static void half_floats_drift(void **state)
{
    (void)state;
    static struct result half, full;
    enum { SIZE = 40 };
    float *plane = malloc(SIZE * SIZE * SIZE * sizeof *plane);
    assert_non_null(plane);
    fill_marschner_lobb(plane, SIZE);
    const struct weft_samples samples = {
        .size = {SIZE, SIZE, SIZE}, .plane = {plane}, .low = 0.0, .high = 1.0};
    struct weft_pass_plan_params *p =
        weft_pass_plan_params(.kernel = kernel_named("bspline"), .dims = 3, .samples = M,
                              .taps_per_pass = 1, .profile = profile_named("fp16"));
    weft_pass_plan *plan = make_plan(p);
    emulate(plan, &samples, &half);
    const double bound = weft_pass_plan_get_info(plan)->error.e3;
    weft_pass_plan_destroy(&plan);
    p->profile = profile_named("fp32");
    plan = make_plan(p);
    emulate(plan, &samples, &full);
    weft_pass_plan_destroy(&plan);
    double mean = 0.0, most = 0.0;
    for (int i = 0; i < SHIFTED * SHIFTED; i++) {
        const double drift = (double)half.pixels[i] - (double)full.pixels[i];
        mean += drift / (SHIFTED * SHIFTED);
        most = larger(most, fabs(drift));
    }
    print_message("fp16, 64 passes: %.2e on average from fp32, up to %.2e; bound of the arithmetic "
                  "%.2e\n",
                  mean, most, bound);
    assert_true(mean < -4.0 * 0x1p-11); // rounded to nearest, there would be no drift
    assert_true(most <= bound);
    free(plane);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(naive_orders_clamp),
        cmocka_unit_test(wrong_orders_are_named),
        cmocka_unit_test(weights_rounded_singly_ripple),
        cmocka_unit_test(a_single_bias_clamps),
        cmocka_unit_test(long_sums_lose_bits),
        cmocka_unit_test(half_floats_drift),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
