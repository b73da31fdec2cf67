// SPDX-License-Identifier: BSD-3-Clause
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
#include "filter/check.h"
#include "tests/support/plans.h"
#include "weft.h"

static const struct weft_pass_plan_info *info_of(const weft_pass_plan *plan)
{
    return weft_pass_plan_get_info(plan);
}

// ---- every tile once ----------------------------------------------------------------------------

static bool is_zero(const struct weft_kernel_tile *tile)
{
    return tile->minimum == 0.0 && tile->maximum == 0.0;
}

// The offsets of a group's components are those of its tiles' taps, and every tile that is not zero
// is in one group of all passes of a part.
static void check_cover(const weft_pass_plan *plan)
{
    const struct weft_pass_list *list = info_of(plan)->passes;
    const int tiles = info_of(plan)->tile_count;
    int *seen = calloc((size_t)tiles, sizeof *seen);
    assert_non_null(seen);
    for (int n = 0; n < list->pass_count; n++) {
        const struct weft_pass *pass = &list->passes[n];
        if (pass->kind != WEFT_PASS_TAPS || pass->part == WEFT_PASS_LOW)
            continue;
        for (int g = 0; g < pass->group_count; g++) {
            const struct weft_tap_group *group = &list->groups[pass->group_first + g];
            for (int c = 0; c < 4; c++) {
                if (group->tile[c] < 0)
                    continue;
                seen[group->tile[c]]++;
                const int *tap = weft_kernel_tiles_get(list->tiles, group->tile[c])->tap;
                for (int a = 0; a < 3; a++)
                    assert_int_equal(group->offset[a] + list->pattern[c][a], tap[a]);
            }
        }
    }
    for (int i = 0; i < tiles; i++)
        assert_int_equal(seen[i], is_zero(weft_kernel_tiles_get(list->tiles, i)) ? 0 : 1);
    free(seen);
}

// ---- the catalogue ------------------------------------------------------------------------------

static void every_kernel_has_a_valid_plan(void **state)
{
    (void)state;
    print_message("%-22s dims  taps tiles splits passes  bits lost  verdict   search\n", "kernel");
    for (const struct weft_kernel_info *const *k = weft_kernel_list; *k; k++) {
        const struct weft_kernel kernel = kernel_named((*k)->name);
        for (int dims = 2; kernel.width <= 4 && dims <= 3; dims++) {
            weft_pass_plan *plan =
                make_plan(weft_pass_plan_params(.kernel = kernel, .dims = dims,
                                                .samples = dims > 2 ? 16 : 64, .taps_per_pass = 1));
            const struct weft_pass_plan_info *info = info_of(plan);
            print_message("%-22s %dD   %4d  %4d   %4d   %4d   %8.2f  %s  %7.3f s\n", (*k)->name,
                          dims, info->tap_count, info->tile_count, info->split_count,
                          info->passes->pass_count, info->scale_bits,
                          info->valid ? "valid  " : "INVALID", info->search_seconds);
            assert_true(info->valid);
            check_cover(plan);
            weft_pass_plan_destroy(&plan);
        }
    }
}

// ---- dot4 ---------------------------------------------------------------------------------------

// Widths that are multiples of 4 and those that are not.
static void four_taps_cover_every_tap_once(void **state)
{
    (void)state;
    static const struct {
        const char *kernel;
        int width, groups_2d, groups_3d; // without signs: the fewest that there can be, or nearly
    } cases[] = {{"linear", 2, 1, 2},       {"bspline2", 3, 3, 9},  {"bspline", 4, 4, 16},
                 {"bspline4", 5, 9, 45},    {"bspline5", 6, 9, 54}, {"bspline7", 8, 16, 128},
                 {"catmull-rom", 4, 4, 16}, {"mitchell", 4, 8, 32}, {"lanczos:3", 6, 9, 54},
                 {"lagrange5", 6, 9, 54}};
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        for (int dims = 2; dims <= 3; dims++) {
            weft_pass_plan *plan =
                make_plan(weft_pass_plan_params(.kernel = kernel_named(cases[i].kernel),
                                                .dims = dims, .samples = dims > 2 ? 4 : 16,
                                                .technique = WEFT_TECHNIQUE_DOT4));
            const struct weft_pass_plan_info *info = info_of(plan);
            const int expected = dims > 2 ? cases[i].groups_3d : cases[i].groups_2d;
            print_message("%-12s %dD: %d taps in %d groups, pattern (%d,%d,%d) (%d,%d,%d)\n",
                          cases[i].kernel, dims, info->tap_count, info->passes->group_count,
                          info->passes->pattern[1][0], info->passes->pattern[1][1],
                          info->passes->pattern[1][2], info->passes->pattern[2][0],
                          info->passes->pattern[2][1], info->passes->pattern[2][2]);
            assert_int_equal(info->kernel.width, cases[i].width);
            assert_true(info->passes->group_count <= expected);
            check_cover(plan);
            weft_pass_plan_destroy(&plan);
        }
    }
}

static void blending_keeps_the_signs_of_four_taps_apart(void **state)
{
    (void)state;
    weft_pass_plan *plan = make_plan(weft_pass_plan_params(.technique = WEFT_TECHNIQUE_DOT4,
                                                           .profile = profile_named("radeon8500")));
    const struct weft_pass_list *list = info_of(plan)->passes;
    for (int n = 0; n < list->pass_count; n++) {
        assert_false(list->passes[n].reads_target);
        for (int g = 0; g < list->passes[n].group_count; g++)
            for (int c = 0; c < 4; c++) {
                const struct weft_tap_group *group = &list->groups[list->passes[n].group_first + g];
                if (group->tile[c] >= 0)
                    assert_int_equal(group->sign[c] < 0, list->passes[n].subtract);
            }
    }
    check_cover(plan);
    weft_pass_plan_destroy(&plan);
}

// ---- orders -------------------------------------------------------------------------------------

static void positive_kernels_never_subtract(void **state)
{
    (void)state;
    static const char *const names[] = {"nearest", "linear", "bspline", "gaussian", "notch"};
    for (size_t i = 0; i < WEFT_COUNT(names); i++) {
        weft_pass_plan *plan = make_plan(
            weft_pass_plan_params(.kernel = kernel_named(names[i]), .worst_case = WEFT_WORST_ANY));
        const struct weft_pass_list *list = info_of(plan)->passes;
        for (int n = 0; n < list->pass_count; n++)
            assert_false(list->passes[n].subtract || list->passes[n].reads_target);
        assert_true(info_of(plan)->error.clamp == 0.0);
        assert_true(list->result_bias == 0.0);
        weft_pass_plan_destroy(&plan);
    }
}

// Half a code for each pass of one tap.
static bool stays_but_for_roundings(const struct weft_pass_plan_info *info)
{
    return 255.0 * info->range.overflow <= 0.5 * info->passes->pass_count;
}

static void greedy_orders_are_beaten(void **state)
{
    (void)state;
    int planned = 0, greedy = 0, cases = 0;
    static const char *const names[] = {"catmull-rom", "mitchell", "cubic:0,1", "lagrange3",
                                        "blackman-sinc"};
    for (size_t i = 0; i < WEFT_COUNT(names); i++) {
        for (int dims = 2; dims <= 3; dims++) {
            for (int samples = 8; samples <= 16; samples += 8) {
                for (int order = WEFT_ORDER_PLANNED; order <= WEFT_ORDER_GREEDY; order++) {
                    weft_pass_plan *plan = NULL;
                    const struct weft_pass_plan_params *p =
                        weft_pass_plan_params(.kernel = kernel_named(names[i]), .dims = dims,
                                              .samples = samples, .taps_per_pass = 1,
                                              .order = (enum weft_order)order, .no_scale = true,
                                              .no_splits = true);
                    const bool made = weft_pass_plan_create(p, &plan) == WEFT_OK;
                    // Roundings, for which there is no room without a scale, aside.
                    *(order == WEFT_ORDER_PLANNED ? &planned : &greedy) +=
                        made && stays_but_for_roundings(info_of(plan));
                    weft_pass_plan_destroy(&plan);
                }
                cases++;
            }
        }
    }
    print_message("without splits and scale, of %d cases: %d planned, %d greedy orders are valid\n",
                  cases, planned, greedy);
    assert_true(planned > greedy);
}

// Where no order helps, and nothing may be scaled, tiles are split.
static void tiles_are_split_where_no_order_helps(void **state)
{
    (void)state;
    int with = 0, without = 0;
    for (int samples = 24; samples <= 40; samples++) {
        weft_pass_plan *plan = NULL;
        struct weft_pass_plan_params *p =
            weft_pass_plan_params(.kernel = kernel_named("cubic:0,2"), .samples = samples,
                                  .taps_per_pass = 1, .no_scale = true, .no_splits = true);
        if (weft_pass_plan_create(p, &plan) == WEFT_OK) {
            weft_pass_plan_destroy(&plan);
            continue;
        }
        without++;
        p->no_splits = false;
        if (weft_pass_plan_create(p, &plan) != WEFT_OK)
            continue;
        with++;
        assert_true(stays_but_for_roundings(info_of(plan)));
        assert_true(info_of(plan)->split_count > 0);
        assert_int_equal(info_of(plan)->tile_count,
                         weft_kernel_tiles_get_info(info_of(plan)->passes->tiles)->tile_count);
        check_cover(plan);
        weft_pass_plan_destroy(&plan);
    }
    print_message("cubic:0,2 2D, M 24 to 40: %d without an order, %d of them with splits\n",
                  without, with);
    assert_true(with > 0 && without < 17); // some have an order
}

static void weights_rounded_singly_need_scale(void **state)
{
    (void)state;
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    weft_pass_plan *plan = NULL;
    struct weft_pass_plan_params *p =
        weft_pass_plan_params(.dims = 3, .samples = 16, .taps_per_pass = 1, .round_singly = true,
                              .no_scale = true, .log = &log);
    assert_int_equal(weft_pass_plan_create(p, &plan), WEFT_ERR_UNSUPPORTED);
    assert_non_null(strstr(message.text, "267/255"));
    p->no_scale = false;
    p->log = &log_to_stderr;
    assert_int_equal(weft_pass_plan_create(p, &plan), WEFT_OK);
    assert_true(info_of(plan)->valid);
    assert_true(info_of(plan)->passes->result_scale <= 255.0 / 267.0 + 1e-12);
    weft_pass_plan_destroy(&plan);
}

static void given_orders_are_judged(void **state)
{
    (void)state;
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    struct weft_tile_name names[17] = {{{0}, WEFT_TILE_WHOLE, 0}};
    weft_pass_plan *plan = NULL;
    for (int i = 0; i < 16; i++)
        names[i] = (struct weft_tile_name){{i % 4, i / 4, 0}, WEFT_TILE_WHOLE, 0};
    struct weft_pass_plan_params *p =
        weft_pass_plan_params(.order = WEFT_ORDER_GIVEN, .tile_order = names,
                              .tile_order_count = 16, .taps_per_pass = 1, .log = &log);
    assert_int_equal(weft_pass_plan_create(p, &plan), WEFT_OK);
    assert_false(info_of(plan)->valid);
    assert_int_equal(info_of(plan)->range.pass, 1); // (1,0) is subtracted from the corner's little
    assert_true(info_of(plan)->range.value < 0.0);
    weft_pass_plan_destroy(&plan);
    p->tile_order_count = 15;
    assert_int_equal(weft_pass_plan_create(p, &plan), WEFT_ERR_ARGUMENT);
    if (!strstr(message.text, "(3,3)+ is missing"))
        fail_msg("%s", message.text);
    p->tile_order_count = 17;
    names[16] = names[4];
    assert_int_equal(weft_pass_plan_create(p, &plan), WEFT_ERR_ARGUMENT);
    assert_non_null(strstr(message.text, "(0,1) comes twice"));
    names[15].tap[0] = 4;
    assert_int_equal(weft_pass_plan_create(p, &plan), WEFT_ERR_ARGUMENT);
    assert_non_null(strstr(message.text, "no tile (4,3)"));
}

// A planned order, handed back as the caller's own, is as valid.
static void a_planned_order_can_be_given(void **state)
{
    (void)state;
    weft_pass_plan *plan =
        make_plan(weft_pass_plan_params(.kernel = kernel_named("mitchell"), .taps_per_pass = 1));
    const struct weft_pass_list *list = info_of(plan)->passes;
    struct weft_tile_name names[64];
    assert_true(list->group_count <= 64);
    for (int g = 0; g < list->group_count; g++)
        names[g] = weft_tile_name_of(list->tiles, list->groups[g].tile[0], false);
    weft_pass_plan *given =
        make_plan(weft_pass_plan_params(.kernel = kernel_named("mitchell"), .taps_per_pass = 1,
                                        .order = WEFT_ORDER_GIVEN, .tile_order = names,
                                        .tile_order_count = (size_t)list->group_count));
    assert_true(info_of(given)->valid);
    assert_int_equal(info_of(given)->passes->pass_count, list->pass_count);
    weft_pass_plan_destroy(&given);
    weft_pass_plan_destroy(&plan);
}

// ---- techniques ---------------------------------------------------------------------------------

// N passes of e lost bits fit beside their carries into m bits while N (2^e - 1) < 2^m. The paper's
// N = 2^(m - e + 1) - 1 (31 for 12 bits, 8 of them stored) lets carries overflow: 31 times 15 is
// 465. 255 for 9 bits, and 10 bits for 64 passes, are as it says.
static void split_precision_keeps_what_carries_leave(void **state)
{
    (void)state;
    static const struct {
        const char *profile, *kernel;
        int dims, taps, least_bits, passes;
    } cases[] = {{"geforce3", "bspline", 2, 1, 9, 33},    {"geforce3", "bspline", 3, 1, 9, 129},
                 {"radeon8500", "bspline", 2, 1, 12, 33}, {"radeon8500", "bspline", 3, 1, 10, 129},
                 {"radeon8500", "bspline", 3, 3, 11, 45}, {"unorm8", "bspline", 3, 8, 12, 17}};
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        weft_pass_plan *plan = make_plan(
            weft_pass_plan_params(.kernel = kernel_named(cases[i].kernel), .dims = cases[i].dims,
                                  .samples = 16, .taps_per_pass = cases[i].taps,
                                  .profile = profile_named(cases[i].profile),
                                  .technique = WEFT_TECHNIQUE_SPLIT_PRECISION));
        const struct weft_pass_plan_info *info = info_of(plan);
        print_message("%-10s %s %dD: %d passes keep %d bits\n", cases[i].profile, cases[i].kernel,
                      cases[i].dims, info->passes->pass_count, info->kept_bits);
        assert_true(info->kept_bits >= cases[i].least_bits);
        assert_int_equal(info->passes->pass_count, cases[i].passes);
        assert_true(info->valid);
        weft_pass_plan_destroy(&plan);
    }
}

// Slots of a hierarchy are a stack: each is written before it is read, and read once.
static void hierarchies_use_a_stack_of_targets(void **state)
{
    (void)state;
    static const char *const profiles[] = {"unorm8", "unorm16", "geforce3", "radeon8500",
                                           "unorm8,taps=1"};
    for (size_t i = 0; i < WEFT_COUNT(profiles); i++) {
        weft_pass_plan *plan = make_plan(
            weft_pass_plan_params(.dims = 3, .samples = 8, .profile = profile_named(profiles[i]),
                                  .technique = WEFT_TECHNIQUE_HIERARCHICAL));
        const struct weft_pass_list *list = info_of(plan)->passes;
        bool holds[64] = {false};
        assert_true(list->slot_count <= 64);
        for (int n = 0; n < list->pass_count; n++) {
            const struct weft_pass *pass = &list->passes[n];
            for (int k = 0; pass->kind == WEFT_PASS_COMBINE && k < pass->input_count; k++) {
                assert_true(holds[pass->input[k]]);
                holds[pass->input[k]] = false;
            }
            assert_true(pass->clears ? !holds[pass->target] : holds[pass->target]);
            holds[pass->target] = true;
        }
        print_message("%-14s %d passes, %d targets\n", profiles[i], list->pass_count,
                      list->slot_count);
        assert_true(info_of(plan)->valid);
        check_cover(plan);
        weft_pass_plan_destroy(&plan);
    }
}

static void refused(const struct weft_pass_plan_params *params, enum weft_result expected,
                    const char *text)
{
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    struct weft_pass_plan_params p = *params;
    weft_pass_plan *plan = NULL;
    p.log = &log;
    assert_int_equal(weft_pass_plan_create(&p, &plan), expected);
    assert_null(plan);
    assert_int_equal(message.count, 1);
    if (!strstr(message.text, text))
        fail_msg("'%s' is not in '%s'", text, message.text);
}

static void bad_requests_are_refused(void **state)
{
    (void)state;
    refused(weft_pass_plan_params(.dims = 4), WEFT_ERR_ARGUMENT, "dims");
    refused(weft_pass_plan_params(.channels = 3), WEFT_ERR_ARGUMENT, "channels");
    refused(weft_pass_plan_params(.taps_per_pass = 9), WEFT_ERR_ARGUMENT,
            "1 to 8 taps per pass, not 9");
    refused(weft_pass_plan_params(.derivative = {{0, 0, 1}}), WEFT_ERR_ARGUMENT, "derivative");
    refused(weft_pass_plan_params(.samples = 5000), WEFT_ERR_ARGUMENT, "5000");
    refused(weft_pass_plan_params(.bits = 17), WEFT_ERR_ARGUMENT, "17");
    refused(weft_pass_plan_params(.bits = 15, .profile = profile_named("unorm16")),
            WEFT_ERR_ARGUMENT, "4 to 14 bits, not 15");
    refused(weft_pass_plan_params(.technique = WEFT_TECHNIQUE_HIERARCHICAL,
                                  .profile = profile_named("fp16")),
            WEFT_ERR_UNSUPPORTED, "fixed point");
    refused(weft_pass_plan_params(.technique = WEFT_TECHNIQUE_DOT4, .channels = 4),
            WEFT_ERR_UNSUPPORTED, "single-valued");
    refused(weft_pass_plan_params(.technique = WEFT_TECHNIQUE_DOT4,
                                  .profile = profile_named("unorm8,dot=1")),
            WEFT_ERR_UNSUPPORTED, "dot products");
    refused(weft_pass_plan_params(.technique = WEFT_TECHNIQUE_SPLIT_PRECISION,
                                  .profile = profile_named("geforce3,max-scale=1")),
            WEFT_ERR_UNSUPPORTED, "factors above 1");
    refused(weft_pass_plan_params(.technique = WEFT_TECHNIQUE_SPLIT_PRECISION,
                                  .profile = profile_named("internal-bits=8")),
            WEFT_ERR_UNSUPPORTED, "more bits");
    refused(weft_pass_plan_params(.dims = 3, .samples = 512, .memory_bytes = 1 << 20),
            WEFT_ERR_LIMIT, "1048576");
    refused(weft_pass_plan_params(.kernel = kernel_named("nearest"), .derivative = {{1, 0, 0}}),
            WEFT_ERR_ARGUMENT, "nearest");
}

// ---- texts --------------------------------------------------------------------------------------

static void a_plan_prints_its_passes(void **state)
{
    (void)state;
    weft_pass_plan *plan =
        make_plan(weft_pass_plan_params(.kernel = kernel_named("linear"), .samples = 4,
                                        .taps_per_pass = 1, .order = WEFT_ORDER_NATURAL));
    // Weights at (k + 0.5) / 4: up to 49/64, or 195/255. E2 is 0.469 by the next test's formula,
    // and what 8 bits add.
    assert_string_equal(
        info_of(plan)->text,
        "plan: linear, 2D, unorm8, plain; tiles of 4^2 samples in 8 bits\n"
        "4 taps, 4 tiles, 4 passes, 12 fetches, 1 target; tiles 16 bytes, targets 1 bytes a pixel\n"
        "pass 00: taps (0,0), add, -> unorm8 A, range [0.000, 0.765]\n"
        "pass 01: taps (1,0), add, -> unorm8 A, range [0.000, 0.875]\n"
        "pass 02: taps (0,1), add, -> unorm8 A, range [0.000, 0.984]\n"
        "pass 03: taps (1,1), add, -> unorm8 A, range [0.000, 1.000]\n"
        "stored: 1 value + 0\n"
        "range: valid, no store clamps for constants of any level\n"
        "error, of the source's range: source 0.00196 + E2 0.471 + E3 0.00784 = 0.48; with "
        "clamping of any input 0.48\n");
    weft_pass_plan_destroy(&plan);
}

// Linear weights in cells of 1/M: half a cell's slope for each of two taps an axis, on top of what
// the quantisation adds; the sum over the axes, to first order.
static void e2_is_that_of_the_cells(void **state)
{
    (void)state;
    for (int samples = 4; samples <= 64; samples *= 4) {
        weft_pass_plan *plan =
            make_plan(weft_pass_plan_params(.kernel = kernel_named("linear"),
                                            .profile = profile_named("fp32"), .samples = samples));
        // At the corner of the first cell: |(1 - a)^2 - 1| + 2 a (1 - a) + a^2 with a = 1 / (2 M).
        const double a = 0.5 / samples;
        assert_near(info_of(plan)->error.e2,
                    1.0 - (1.0 - a) * (1.0 - a) + 2.0 * a * (1.0 - a) + a * a, 1e-6,
                    "E2 of linear weights");
        weft_pass_plan_destroy(&plan);
    }
}

static void the_same_request_gives_the_same_plan(void **state)
{
    (void)state;
    const struct weft_pass_plan_params *p =
        weft_pass_plan_params(.dims = 3, .samples = 16, .kernel = kernel_named("cardinal"));
    weft_pass_plan *first = make_plan(p), *second = make_plan(p);
    assert_string_equal(info_of(first)->text, info_of(second)->text);
    weft_pass_plan_destroy(&first);
    weft_pass_plan_destroy(&second);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_kernel_has_a_valid_plan),
        cmocka_unit_test(four_taps_cover_every_tap_once),
        cmocka_unit_test(blending_keeps_the_signs_of_four_taps_apart),
        cmocka_unit_test(positive_kernels_never_subtract),
        cmocka_unit_test(greedy_orders_are_beaten),
        cmocka_unit_test(tiles_are_split_where_no_order_helps),
        cmocka_unit_test(weights_rounded_singly_need_scale),
        cmocka_unit_test(given_orders_are_judged),
        cmocka_unit_test(a_planned_order_can_be_given),
        cmocka_unit_test(split_precision_keeps_what_carries_leave),
        cmocka_unit_test(hierarchies_use_a_stack_of_targets),
        cmocka_unit_test(bad_requests_are_refused),
        cmocka_unit_test(a_plan_prints_its_passes),
        cmocka_unit_test(e2_is_that_of_the_cells),
        cmocka_unit_test(the_same_request_gives_the_same_plan),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
