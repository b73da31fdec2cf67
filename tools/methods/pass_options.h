// SPDX-License-Identifier: BSD-3-Clause
// tools/methods/pass_options.h - what `weft resample` and `weft slice --profile` share: the options
// that say how passes are planned, and what is told of plans and their bounds.
#ifndef WEFT_TOOLS_METHODS_PASS_OPTIONS_H
#define WEFT_TOOLS_METHODS_PASS_OPTIONS_H

#include "tools/common/json.h"
#include "tools/common/options.h"
#include "tools/methods/plan_options.h"
#include "weft.h"

enum resample_plan_option {
    RESAMPLE_PLAN_PROFILE,
    RESAMPLE_PLAN_TECHNIQUE,
    RESAMPLE_PLAN_RESOLUTION,
    RESAMPLE_PLAN_BITS,
    RESAMPLE_PLAN_TAPS_PER_PASS,
    RESAMPLE_PLAN_WORST_CASE,
    RESAMPLE_PLAN_ORDER,
    RESAMPLE_PLAN_SOURCE_RANGE,
    RESAMPLE_PLAN_OPTION_COUNT
};

// For the verbs' tables, which have them side by side in this order, from `first` on.
#define RESAMPLE_PLAN_OPTIONS(first, profile_help)                                                 \
    [first +                                                                                       \
        RESAMPLE_PLAN_PROFILE] = {.name = "profile",                                               \
                                  'p',                                                             \
                                  OPTION_TEXT,                                                     \
                                  "NAME,key=value,...",                                            \
                                  profile_help "; 'help' lists names and keys"},                   \
        [first + RESAMPLE_PLAN_TECHNIQUE] =                                                        \
            PLAN_SPEC_TECHNIQUE("how taps become passes (default plain), as in weft plan"),        \
        [first + RESAMPLE_PLAN_RESOLUTION] = PLAN_SPEC_RESOLUTION,                                 \
        [first + RESAMPLE_PLAN_BITS] = PLAN_SPEC_BITS,                                             \
        [first + RESAMPLE_PLAN_TAPS_PER_PASS] = PLAN_SPEC_TAPS_PER_PASS,                           \
        [first + RESAMPLE_PLAN_WORST_CASE] = PLAN_SPEC_WORST_CASE("range"),                        \
        [first +                                                                                   \
            RESAMPLE_PLAN_ORDER] = {.name = "order",                                               \
                                    0,                                                             \
                                    OPTION_CHOICE,                                                 \
                                    NULL,                                                          \
                                    "of the passes: searched for so that no store clamps "         \
                                    "(default), or, where results may clamp, what comes first "    \
                                    "and fits, or tap by tap",                                     \
                                    weft_order_names,                                              \
                                    WEFT_ORDER_GIVEN},                                             \
        [first + RESAMPLE_PLAN_SOURCE_RANGE] = {                                                   \
            .name = "source-range",                                                                \
            0,                                                                                     \
            OPTION_RANGE,                                                                          \
            "LO,HI",                                                                               \
            "values mapped to 0 and 1 and back; what is outside is clamped (default: smallest "    \
            "and largest)"}

enum { RESAMPLE_PLAN_TEXT = 160 }; // of the texts below

// `--kernel help` and `--profile help`: prints the list and returns true. kernel may be NULL.
bool resample_plan_help(const struct option_value *kernel, const struct option_value *first);

// Checks what needs no plan. Returns WEFT_ERR_ARGUMENT after an error line.
enum weft_result resample_plan_check(const struct option_value *first);

#define RESAMPLE_DEFAULT_PROFILE "fp32"

// What the options from `first` on ask of a plan; *params has the library's defaults.
enum weft_result resample_plan_params(const struct option_value *first, const char *default_profile,
                                      const struct weft_kernel *kernel, int dims, int channels,
                                      struct weft_pass_plan_params *params);
// A plan by the options from `first` on. default_profile: where none is given.
enum weft_result resample_plan_create(const struct option_value *first, const char *default_profile,
                                      const struct weft_kernel *kernel, int dims, int channels,
                                      weft_pass_plan **out);

json_t *resample_bound_json(const struct weft_bound *bound);
// "0.0123 (source 0.002, E2 0.01, E3 0.0003)".
const char *resample_bound_format(const struct weft_bound *bound, char text[RESAMPLE_PLAN_TEXT]);

// What a plan is, without its passes one by one: those are in its text.
json_t *resample_plan_json(const weft_pass_plan *plan);
// "12 passes, 16 tiles of 64 samples, 32 fetches": for attributes.
const char *resample_plan_summary(const weft_pass_plan *plan, char text[RESAMPLE_PLAN_TEXT]);

void resample_plan_print(const weft_pass_plan *plan);

#endif
