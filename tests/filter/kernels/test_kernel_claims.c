// SPDX-License-Identifier: BSD-3-Clause
// Records of users: what they claim against what their functions give. Every record of the
// catalogue passes as a user's; a record with one member wrong is refused by a line that names it.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "filter/check.h"
#include "filter/kernels/kernel.h"

static char message[1024];

static void keep(void *priv, enum weft_log_level level, const char *text)
{
    (void)priv;
    (void)level;
    snprintf(message, sizeof message, "%s", text);
}
static const struct weft_log log_to_message = {.write = keep};

// A copy of a record is nobody's of the catalogue, and is checked: with its initial parameters, and
// with each at either end of its range.
static void the_catalogue_keeps_its_claims(void **state)
{
    int made = 0;
    (void)state;
    for (size_t i = 0; weft_kernel_list[i]; i++) {
        const struct weft_kernel_info copy = *weft_kernel_list[i];
        for (int k = 0; k < 9; k++) {
            double param[WEFT_KERNEL_PARAMS];
            struct weft_kernel kernel;
            bool narrow = false;
            for (int p = 0, at = k; p < WEFT_KERNEL_PARAMS; p++, at /= 3) {
                const struct weft_kernel_param *of = &copy.params[p];
                param[p] = at % 3 == 0 ? of->initial : at % 3 == 1 ? of->min : of->max;
                narrow |= of->name && strcmp(of->name, "radius") && param[p] == 0.05;
            }
            if (narrow) // a sigma of 0.05: steeper than what is looked at
                continue;
            message[0] = '\0';
            if (weft_kernel_create(&log_to_message, &copy, param, &kernel) != WEFT_OK)
                fail_msg("%s:%g,%g: %s", copy.name, param[0], param[1], message);
            made++;
        }
    }
    assert_true(made > 400);
}

// ---- one wrong member each ----------------------------------------------------------------------

static double tent(const struct weft_kernel *kernel, double x)
{
    (void)kernel;
    return fabs(x) < 1.0 ? 1.0 - fabs(x) : 0.0;
}

static double tent_slope(const struct weft_kernel *kernel, double x)
{
    (void)kernel;
    return x >= -1.0 && x < 1.0 ? x < 0.0 ? 1.0 : -1.0 : 0.0;
}

static double tent_falls(const struct weft_kernel *kernel, double x)
{
    return -tent_slope(kernel, x);
}

// Sums to 0.965 at an eighth.
static double low(const struct weft_kernel *kernel, double x)
{
    return tent(kernel, x) * (1.0 - 0.28 * fmin(fabs(x), 1.0 - fabs(x)));
}

static double closed_box(const struct weft_kernel *kernel, double x)
{
    (void)kernel;
    return fabs(x) <= 0.5 ? 1.0 : 0.0;
}

static double none(const struct weft_kernel *kernel, double x)
{
    (void)x;
    return x == 0.0 ? NAN : tent(kernel, x);
}

static double skewed(const struct weft_kernel *kernel, double x)
{
    return tent(kernel, x) + (x >= -1.0 && x < 0.0 ? 0.1 : 0.0);
}

static void raise_order(struct weft_kernel *kernel)
{
    kernel->order = 3;
}

// A tent that tells the truth but for what the case says.
#define TENT(...)                                                                                  \
    {                                                                                              \
        .name = "mine", .weight = tent, .derivative = tent_slope, .radius = 1.0, .degree = 1,      \
        .order = 2, .order_prefiltered = 2, .interpolating = true, .unit_sum = true, __VA_ARGS__   \
    }
#define PARAM(...) .params = {{__VA_ARGS__}}

static void a_wrong_member_is_named(void **state)
{
    static const struct weft_kernel_info flat = {
        .name = "flat", .weight = closed_box, .radius = 0.5, .degree = -1, .continuity = -1};
    const struct weft_kernel_info linear = *weft_kernel_find("linear");
    const struct weft_kernel_info slope = *weft_kernel_find("d-linear");
    const struct {
        const char *text;
        struct weft_kernel_info info;
    } cases[] = {
        {NULL, TENT(.order = 2)},
        {"without a name: .name is missing", TENT(.name = NULL)},
        {"mine: .weight is missing", TENT(.weight = NULL)},
        {"mine: .weight: at fraction 0 weights are not finite",
         TENT(.weight = none, .interpolating = false)},
        {"mine: .radius is -1", TENT(.radius = -1.0)},
        {"mine: .radius is 0, and there is no", TENT(.radius = 0.0)},
        {"mine: half-width 9 is not in (0, 8]", TENT(.radius = 9.0)},
        {"outside [-0.75, 0.75), by .radius", TENT(.radius = 0.75, .unit_sum = false)},
        {"mine: .weight is 1 at 0.5: it is 0 outside [-0.5, 0.5)",
         {.name = "mine", .weight = closed_box, .radius = 0.5, .continuity = -1}},
        {"mine: .params[0] (a): .initial is 3, not in [0, 2]", TENT(PARAM("a", 3.0, 0.0, 2.0))},
        {"mine: .degree is -2, not in", TENT(.degree = -2)},
        {"mine: .degree is 65, not in", TENT(.degree = 65)},
        {"mine: .degree is 0, but the weights of tap 0 are off", TENT(.degree = 0)},
        {"mine: .continuity is -2, below -1", TENT(.continuity = -2)},
        {"mine: .continuity is 1, but h' jumps by ", TENT(.continuity = 1)},
        {"mine: .continuity is 0, but h jumps by ",
         {.name = "mine", .weight = skewed, .radius = 1.0, .degree = 1}},
        {"mine: .order is -1, below 0", TENT(.order = -1)},
        {"mine: .order is 3, but at fraction ", TENT(.order = 3)},
        {"mine: .order is 3, but at fraction ", TENT(.refine = raise_order)},
        {"mine: .order_prefiltered is -1, below 0", TENT(.order_prefiltered = -1)},
        {"mine: .order_prefiltered is 3, but the sum of (k - x)^2 ", TENT(.order_prefiltered = 3)},
        {"mine: .interpolating is claimed, but the weight at -1 is 0.166667, not 0",
         {.name = "mine",
          .weight = weft_kernel_find("bspline")->weight,
          .degree = 3,
          .radius = 2.0,
          .interpolating = true}},
        {"mine: .unit_sum is claimed, but the weights at fraction 0.125 sum to 0.965",
         TENT(.weight = low, .degree = -1, .derivative = NULL, .interpolating = false)},
        {"mine: .moves is claimed, but at fraction 0.03125 the largest weight is 0.96875 of 1",
         TENT(.moves = true)},
        {"mine: .derivative: .weight: between ", TENT(.derivative = tent_falls)},
        {"mine: .derivation is 3, not in 0 to 2", TENT(.derivation = 3)},
        {"mine: .primitive is missing, but .derivation is 1", TENT(.derivation = 1)},
        {"mine: .primitive is given, but .derivation is 0", TENT(.primitive = &linear)},
        {"mine: .primitive takes no such",
         TENT(.primitive = &flat, .derivation = 1, .unit_sum = false, .interpolating = false)},
        {"mine: .primitive is a derivative itself: its .derivation is 1",
         TENT(.primitive = &slope, .derivation = 1, .unit_sum = false, .interpolating = false)},
        {"mine: .primitive: its weight: between ",
         TENT(.primitive = &linear, .derivation = 1, .unit_sum = false, .interpolating = false)},
        {"mine: .order_prefiltered is 2, but records that reconstruct a derivative have none",
         {.name = "mine",
          .weight = tent_slope,
          .radius = 1.0,
          .continuity = -1,
          .primitive = &linear,
          .derivation = 1,
          .order = 1,
          .order_prefiltered = 2}},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct weft_kernel kernel;
        memset(&kernel, 0x55, sizeof kernel);
        message[0] = '\0';
        const enum weft_result res =
            weft_kernel_create(&log_to_message, &cases[i].info, NULL, &kernel);
        if (!cases[i].text) {
            assert_int_equal(res, WEFT_OK);
            continue;
        }
        assert_null(kernel.info);
        if (res != WEFT_ERR_ARGUMENT || !strstr(message, cases[i].text))
            fail_msg("case %zu, \"%s\": %d, %s", i, cases[i].text, (int)res, message);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_catalogue_keeps_its_claims),
        cmocka_unit_test(a_wrong_member_is_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
