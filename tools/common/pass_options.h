// SPDX-License-Identifier: BSD-3-Clause
// tools/common/pass_options.h - what `weft resample` and `weft slice --profile` share: the options
// that say how passes are planned, and what is told of plans and their bounds.
#ifndef WEFT_TOOLS_COMMON_PASS_OPTIONS_H
#define WEFT_TOOLS_COMMON_PASS_OPTIONS_H

#include "tools/common/json.h"
#include "tools/common/options.h"
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
        [first +                                                                                   \
            RESAMPLE_PLAN_TECHNIQUE] = {.name = "technique",                                       \
                                        0,                                                         \
                                        OPTION_CHOICE,                                             \
                                        NULL,                                                      \
                                        "how taps become passes (default plain), as in weft plan", \
                                        weft_technique_names},                                     \
        [first +                                                                                   \
            RESAMPLE_PLAN_RESOLUTION] = {.name = "resolution",                                     \
                                         'm',                                                      \
                                         OPTION_NUMBER,                                            \
                                         "M",                                                      \
                                         "samples per kernel tile and axis (default 64, in 3D "    \
                                         "32)"},                                                   \
        [first +                                                                                   \
            RESAMPLE_PLAN_BITS] = {.name = "bits",                                                 \
                                   'b',                                                            \
                                   OPTION_NUMBER,                                                  \
                                   "B",                                                            \
                                   "of kernel tiles, 4 to 16, on unorm targets (default 8, on "    \
                                   "16-bit targets 14)"},                                          \
        [first +                                                                                   \
            RESAMPLE_PLAN_TAPS_PER_PASS] = {.name = "taps-per-pass",                               \
                                            't',                                                   \
                                            OPTION_NUMBER,                                         \
                                            "N",                                                   \
                                            "pairs of a source and a tile texture in one pass "    \
                                            "(default: as many as the profile has)"},              \
        [first + RESAMPLE_PLAN_WORST_CASE] = {.name = "worst-case",                                \
                                              'w',                                                 \
                                              OPTION_CHOICE,                                       \
                                              NULL,                                                \
                                              "input for which no store may clamp: constants of "  \
                                              "any level (default), or samples anywhere in range", \
                                              weft_worst_case_names},                              \
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
