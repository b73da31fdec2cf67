// SPDX-License-Identifier: BSD-3-Clause
// tools/methods/pass_options.h - what verbs that plan passes share: the options that say how, and
// what is told of plans and their bounds.
#ifndef WEFT_TOOLS_METHODS_PASS_OPTIONS_H
#define WEFT_TOOLS_METHODS_PASS_OPTIONS_H

#include "tools/common/json.h"
#include "tools/options/options.h"
#include "weft.h"

// A verb's own enum has these side by side, from a `first` on: all, or those before the source.
enum pass_option {
    PASS_PROFILE,
    PASS_TAPS_PER_PASS,
    PASS_BITS,
    PASS_RESOLUTION,
    PASS_TECHNIQUE,
    PASS_WORST_CASE,
    PASS_ORDER,
    PASS_PLAN_COUNT,
    PASS_SOURCE_RANGE = PASS_PLAN_COUNT, // of verbs that have a source
    PASS_OPTION_COUNT
};

// The numbers in helps are the library's.
#define PASS_WORD(number) #number
#define PASS_NUMBER(macro) PASS_WORD(macro)
#define PASS_SPEC_TECHNIQUE(text)                                                                  \
    {                                                                                              \
        .name = "technique", 0, OPTION_CHOICE, NULL, text, weft_technique_names,                   \
        .group = OPTION_METHOD                                                                     \
    }
#define PASS_SPEC_TAPS_PER_PASS                                                                    \
    {                                                                                              \
        .name = "taps-per-pass", 't', OPTION_NUMBER, "N",                                          \
        "pairs of a source and a tile texture in one pass (default: as many as the profile has)",  \
        .group = OPTION_METHOD                                                                     \
    }
// clang-format off
#define PASS_SPEC_BITS                                                                             \
    {                                                                                              \
        .name = "bits", 'b', OPTION_NUMBER, "B",                                                   \
        "of kernel tiles, 4 to 16, on unorm targets (default " PASS_NUMBER(WEFT_PASS_PLAN_BITS)    \
        "; on 16-bit targets " PASS_NUMBER(WEFT_PASS_PLAN_BITS_16)                                 \
        ", hierarchical " PASS_NUMBER(WEFT_PASS_PLAN_BITS_16_HIERARCHICAL)                         \
        ", split-precision " PASS_NUMBER(WEFT_PASS_PLAN_BITS_16_SPLIT)                             \
        ", at most " PASS_NUMBER(WEFT_PASS_PLAN_MOST_BITS_16) ")", .group = OPTION_METHOD}
#define PASS_SPEC_RESOLUTION                                                                       \
    {                                                                                              \
        .name = "resolution", 'm', OPTION_NUMBER, "M",                                             \
        "samples per kernel tile and axis (default " PASS_NUMBER(WEFT_PASS_PLAN_SAMPLES_2D)        \
        ", in 3D " PASS_NUMBER(WEFT_PASS_PLAN_SAMPLES_3D) ")", .group = OPTION_FILTER}
// clang-format on
#define PASS_SPEC_WORST_CASE(range)                                                                \
    {                                                                                              \
        .name = "worst-case", 'w', OPTION_CHOICE, NULL,                                            \
        "input for which no store may clamp: constants of any level (default), or samples "        \
        "anywhere in " range,                                                                      \
        weft_worst_case_names, .group = OPTION_METHOD                                              \
    }

#define PASS_SPEC_PROFILE(text)                                                                    \
    {                                                                                              \
        .name = "profile", 0, OPTION_TEXT, "NAME,key=value,...",                                   \
        text "; 'help' lists names and keys", .group = OPTION_METHOD,                              \
        .names = OPTION_NAMES_PROFILE                                                              \
    }
#define PASS_SPEC_ORDER(text)                                                                      \
    {                                                                                              \
        .name = "order", 0, OPTION_CHOICE, NULL, text, weft_order_names, WEFT_ORDER_GIVEN,         \
        .group = OPTION_METHOD                                                                     \
    }

// For the verbs' tables. What differs from verb to verb is told by its help.
#define PASS_PLAN_OPTIONS(first, profile_help, technique_help, range)                              \
    [first + PASS_PROFILE] = PASS_SPEC_PROFILE(profile_help),                                      \
             [first + PASS_TAPS_PER_PASS] = PASS_SPEC_TAPS_PER_PASS,                               \
             [first + PASS_BITS] = PASS_SPEC_BITS,                                                 \
             [first + PASS_RESOLUTION] = PASS_SPEC_RESOLUTION,                                     \
             [first + PASS_TECHNIQUE] = PASS_SPEC_TECHNIQUE(technique_help),                       \
             [first + PASS_WORST_CASE] = PASS_SPEC_WORST_CASE(range)
#define PASS_OPTIONS(first, profile_help)                                                          \
    PASS_PLAN_OPTIONS(first, profile_help,                                                         \
                      "how taps become passes (default plain), as in weft plan", "range"),         \
        [first + PASS_ORDER] = PASS_SPEC_ORDER(                                                    \
            "of the passes: searched for so that no store clamps (default), or, where "            \
            "results may clamp, what comes first and fits, or tap by tap"),                        \
                 [first + PASS_SOURCE_RANGE] = {.name = "source-range",                            \
                                                0,                                                 \
                                                OPTION_RANGE,                                      \
                                                "LO,HI",                                           \
                                                "values mapped to 0 and 1 and back; what is "      \
                                                "outside is clamped (default: smallest "           \
                                                "and largest)",                                    \
                                                .group = OPTION_METHOD}

enum { PASS_TEXT = 160 }; // of the texts below

// `--kernel help` and `--profile help`: prints the list and returns true.
bool pass_options_help(const struct option_value *kernel, const struct option_value *first);

// Fills what the options before the source say; *params has the library's defaults.
// default_profile: where none is given (NULL: the library's). Returns WEFT_ERR_ARGUMENT after an
// error line.
enum weft_result pass_options_read(const struct option_value *first, const char *default_profile,
                                   struct weft_pass_plan_params *params);
// Checks them all without a plan. Returns as pass_options_read does.
enum weft_result pass_options_check(const struct option_value *first);

#define PASS_DEFAULT_PROFILE "fp32"

// What the options from `first` on ask of a plan; *params has the library's defaults.
enum weft_result pass_plan_params(const struct option_value *first, const char *default_profile,
                                  const struct weft_kernel *kernel, int dims, int channels,
                                  struct weft_pass_plan_params *params);
// A plan by the options from `first` on. default_profile: where none is given.
enum weft_result pass_plan_create(const struct option_value *first, const char *default_profile,
                                  const struct weft_kernel *kernel, int dims, int channels,
                                  weft_pass_plan **out);

json_t *pass_bound_json(const struct weft_bound *bound);
// "0.0123 (source 0.002, E2 0.01, E3 0.0003)".
const char *pass_bound_format(const struct weft_bound *bound, char text[PASS_TEXT]);

// What a plan is, without its passes one by one: those are in its text.
json_t *pass_plan_json(const weft_pass_plan *plan);
// "12 passes, 16 tiles of 64 samples, 32 fetches": for attributes.
const char *pass_plan_summary(const weft_pass_plan *plan, char text[PASS_TEXT]);

void pass_plan_print(const weft_pass_plan *plan);

#endif
