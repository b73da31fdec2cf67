// SPDX-License-Identifier: BSD-3-Clause
// What the paper says of methods (report CW 369, sections 2 and 3.4, figure 3), and what the report
// predicts of roundings, in numbers: emulated, and on every GL context.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>

#include "passes/accumulate/buffer.h"
#include "tests/support/common.h"
#include "tests/support/contexts.h"
#include "weft.h"

enum { SIDE = 64, PIXELS = SIDE * SIDE };
static const int counts[] = {32, 64, 128, 256, 1024};

// ---- frames -------------------------------------------------------------------------------------

// Every code, 16 times.
static uint8_t ramp_code(int frame, int pixel)
{
    (void)frame;
    return (uint8_t)pixel;
}

static uint8_t noise_code(int frame, int pixel)
{
    uint64_t state = (uint64_t)frame * 0x9e3779b97f4a7c15u + (uint64_t)pixel * 0xd1342543de82ef95u;
    state = (state ^ state >> 31) * 0xbf58476d1ce4e5b9u;
    return (uint8_t)((state ^ state >> 29) >> 56);
}

struct errors {
    double largest, mean; // codes; the mean has a sign
};

// The mean of `count` frames by one method, against their exact one.
static struct errors run(weft_context *context, struct weft_accumulator_params params, int count,
                         uint8_t (*code)(int frame, int pixel),
                         struct weft_accumulator_report *report)
{
    static uint8_t codes[PIXELS];
    static float out[PIXELS];
    static double sums[PIXELS];
    weft_accumulator *a = NULL;
    struct errors e = {0};
    params.width = params.height = SIDE;
    params.channel_count = 1;
    params.frame_count = count;
    params.context = context;
    params.emulate = !context;
    params.log = &log_to_stderr;
    assert_int_equal(weft_accumulator_create(&params, &a), WEFT_OK);
    for (int k = 0; k < count; k++) {
        for (int p = 0; p < PIXELS; p++) {
            codes[p] = code(k, p);
            sums[p] = (k ? sums[p] : 0.0) + codes[p];
        }
        const struct weft_plane plane = {.values = codes, .type = WEFT_PLANE_UNORM8};
        assert_int_equal(weft_accumulator_add(a, &(struct weft_frame){.plane = &plane}, 1.0),
                         WEFT_OK);
    }
    assert_int_equal(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, out, 0), WEFT_OK);
    weft_accumulator_get_report(a, report);
    weft_accumulator_destroy(&a);
    for (int p = 0; p < PIXELS; p++) {
        const double error = 255.0 * (double)out[p] - sums[p] / count;
        assert_false(isnan(error));
        e.largest = fmax(e.largest, fabs(error));
        e.mean += error / PIXELS;
    }
    assert_true(e.largest <= 255.0 * report->bound);
    return e;
}

// Without a context, and with each that is to be had.
static void on_each(void (*check)(weft_context *context))
{
    check(NULL);
    for (int c = 0; c < 2 && contexts[c]; c++)
        check(contexts[c]);
}

// ---- facts --------------------------------------------------------------------------------------

// Figure 3, bottom row: equal frames come back, whatever the rounding; what is left is the rounding
// of a code to a float, once divided.
static void check_equal_frames(weft_context *context)
{
    static const int branchings[] = {2, 4, 16};
    struct weft_accumulator_report report;
    for (size_t n = 0; n < WEFT_COUNT(counts); n++)
        for (size_t b = 0; b < WEFT_COUNT(branchings); b++)
            for (int r = 0; r < WEFT_TREE_ROUNDING_COUNT; r++)
                assert_true(
                    run(context,
                        (struct weft_accumulator_params){.method = WEFT_ACCUMULATE_TREE,
                                                         .branching = branchings[b],
                                                         .rounding = (enum weft_tree_rounding)r},
                        counts[n], ramp_code, &report)
                        .largest <= 255.0 * 0x1p-25);
}

static void trees_give_equal_frames_back(void **state)
{
    (void)state;
    on_each(check_equal_frames);
}

// Section 3.4: "an accumulation tree results in a worst case error of 4/255" for 256 frames, with
// nodes of two inputs that cut the result's last bit off.
static void check_truncating_tree(weft_context *context)
{
    struct weft_accumulator_report report;
    const struct errors e =
        run(context,
            (struct weft_accumulator_params){
                .method = WEFT_ACCUMULATE_TREE, .branching = 2, .rounding = WEFT_TREE_TRUNCATE},
            256, noise_code, &report);
    assert_true(e.largest <= 4.0);
    assert_true(e.mean < -1.5);
}

static void a_truncating_tree_is_within_four_codes(void **state)
{
    (void)state;
    on_each(check_truncating_tree);
}

// The mean of PIXELS independent errors, each within the bound: by Hoeffding's inequality farther
// from what is expected than this less than once in 10^5 times.
static double mean_tolerance(const struct weft_accumulator_report *report)
{
    return 5.0 * 255.0 * report->bound / SIDE;
}

static void check_bias(weft_context *context)
{
    static const int branchings[] = {2, 4, 8};
    struct weft_accumulator_report report;
    for (size_t b = 0; b < WEFT_COUNT(branchings); b++) {
        for (int r = 0; r < WEFT_TREE_ROUNDING_COUNT; r++) {
            const struct errors e =
                run(context,
                    (struct weft_accumulator_params){.method = WEFT_ACCUMULATE_TREE,
                                                     .branching = branchings[b],
                                                     .rounding = (enum weft_tree_rounding)r},
                    256, noise_code, &report);
            print_message("b = %d, %s: mean error %+.3f codes, expected %+.3f\n", branchings[b],
                          weft_tree_rounding_names[r], e.mean, 255.0 * report.bias);
            assert_true(fabs(e.mean - 255.0 * report.bias) <= mean_tolerance(&report));
        }
    }
}

static void roundings_lean_as_predicted(void **state)
{
    (void)state;
    on_each(check_bias);
}

// Sections 2 and 3.4: blending 256 frames on 8 bits "results in a black image". So it does where
// products are cut off; where they are rounded, codes below 128 are black, and others 255 or so.
static void check_blending(weft_context *context)
{
    struct weft_accumulator_report report;
    for (size_t n = 0; n < WEFT_COUNT(counts); n++) {
        const struct errors e =
            run(context, (struct weft_accumulator_params){.method = WEFT_ACCUMULATE_BLEND},
                counts[n], ramp_code, &report);
        print_message("blending %d frames: largest error %.0f codes\n", counts[n], e.largest);
        if (counts[n] >= 256)
            assert_true(e.largest >= 100.0);
    }
}

static void blending_256_frames_is_useless(void **state)
{
    (void)state;
    on_each(check_blending);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(trees_give_equal_frames_back),
        cmocka_unit_test(a_truncating_tree_is_within_four_codes),
        cmocka_unit_test(roundings_lean_as_predicted),
        cmocka_unit_test(blending_256_frames_is_useless),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
