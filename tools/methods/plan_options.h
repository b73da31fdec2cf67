// SPDX-License-Identifier: BSD-3-Clause
// tools/methods/plan_options.h - the options that say what is to be planned, as `weft plan` and
// `weft validate --order` share them.
#ifndef WEFT_TOOLS_METHODS_PLAN_OPTIONS_H
#define WEFT_TOOLS_METHODS_PLAN_OPTIONS_H

#include "tools/common/options.h"
#include "weft.h"

enum plan_option {
    PLAN_KERNEL,
    PLAN_DIMS,
    PLAN_DERIVATIVE,
    PLAN_PROFILE,
    PLAN_TAPS_PER_PASS,
    PLAN_BITS,
    PLAN_RESOLUTION,
    PLAN_TECHNIQUE,
    PLAN_ROUND_SINGLY,
    PLAN_SINGLE_BIAS,
    PLAN_NO_SCALE,
    PLAN_BLEND_ONLY,
    PLAN_CHANNELS,
    PLAN_SUBJECT_COUNT, // those above make no sense for a plan that is there already
    PLAN_WORST_CASE = PLAN_SUBJECT_COUNT,
    PLAN_MEMORY,
    PLAN_JSON,
    PLAN_QUIET,
    PLAN_VERBOSE,
    PLAN_COMMON_COUNT, // a verb's own are behind them
};

// Options that several verbs have, once: the numbers in them are the library's.
#define PLAN_WORD(number) #number
#define PLAN_NUMBER(macro) PLAN_WORD(macro)
#define PLAN_SPEC_TECHNIQUE(text)                                                                  \
    {                                                                                              \
        .name = "technique", 0, OPTION_CHOICE, NULL, text, weft_technique_names                    \
    }
#define PLAN_SPEC_TAPS_PER_PASS                                                                    \
    {                                                                                              \
        .name = "taps-per-pass", 't', OPTION_NUMBER, "N",                                          \
        "pairs of a source and a tile texture in one pass (default: as many as the profile has)"   \
    }
// clang-format off
#define PLAN_SPEC_BITS                                                                             \
    {                                                                                              \
        .name = "bits", 'b', OPTION_NUMBER, "B",                                                   \
        "of kernel tiles, 4 to 16, on unorm targets (default " PLAN_NUMBER(WEFT_PASS_PLAN_BITS)    \
        "; on 16-bit targets " PLAN_NUMBER(WEFT_PASS_PLAN_BITS_16)                                 \
        ", hierarchical " PLAN_NUMBER(WEFT_PASS_PLAN_BITS_16_HIERARCHICAL)                         \
        ", split-precision " PLAN_NUMBER(WEFT_PASS_PLAN_BITS_16_SPLIT)                             \
        ", at most " PLAN_NUMBER(WEFT_PASS_PLAN_MOST_BITS_16) ")"                                  \
    }
#define PLAN_SPEC_RESOLUTION                                                                       \
    {                                                                                              \
        .name = "resolution", 'm', OPTION_NUMBER, "M",                                             \
        "samples per kernel tile and axis (default " PLAN_NUMBER(WEFT_PASS_PLAN_SAMPLES_2D)        \
        ", in 3D " PLAN_NUMBER(WEFT_PASS_PLAN_SAMPLES_3D) ")"                                      \
    }
// clang-format on
#define PLAN_SPEC_WORST_CASE(range)                                                                \
    {                                                                                              \
        .name = "worst-case", 'w', OPTION_CHOICE, NULL,                                            \
        "input for which no store may clamp: constants of any level (default), or samples "        \
        "anywhere in " range,                                                                      \
        weft_worst_case_names                                                                      \
    }

// For the verbs' tables.
#define PLAN_COMMON_OPTIONS                                                                        \
    [PLAN_KERNEL] = {.name = "kernel",                                                             \
                     'k',                                                                          \
                     OPTION_TEXT,                                                                  \
                     "NAME",                                                                       \
                     "the reconstruction kernel (default catmull-rom), as in weft slice; 'help' "  \
                     "lists the kernels"},                                                         \
    [PLAN_DIMS] = {.name = "dims",                                                                 \
                   'd',                                                                            \
                   OPTION_CHOICE,                                                                  \
                   NULL,                                                                           \
                   "dimensions of the source (default 2)",                                         \
                   plan_dims_choices},                                                             \
    [PLAN_DERIVATIVE] = {.name = "derivative",                                                     \
                         0,                                                                        \
                         OPTION_CHOICE,                                                            \
                         NULL,                                                                     \
                         "reconstruct this component of the gradient instead",                     \
                         plan_derivative_choices},                                                 \
    [PLAN_PROFILE] = {.name = "profile",                                                           \
                      'p',                                                                         \
                      OPTION_TEXT,                                                                 \
                      "NAME,key=value,...",                                                        \
                      "what the hardware may do in a pass (default unorm8): a name, a name and "   \
                      "what differs, or, from unorm8 on, only what differs; 'help' lists names "   \
                      "and keys"},                                                                 \
    [PLAN_TAPS_PER_PASS] = PLAN_SPEC_TAPS_PER_PASS, [PLAN_BITS] = PLAN_SPEC_BITS,                  \
    [PLAN_RESOLUTION] = PLAN_SPEC_RESOLUTION,                                                      \
    [PLAN_TECHNIQUE] = PLAN_SPEC_TECHNIQUE(                                                        \
        "plain: a tap per fetch (default); dot4: four; split-precision: twice "                    \
        "the passes keep the bits that the target loses; hierarchical: small "                     \
        "weights in targets of their own; log: sums of logarithms for products"),                  \
    [PLAN_ROUND_SINGLY] = {.name = "round-singly",                                                 \
                           0,                                                                      \
                           OPTION_FLAG,                                                            \
                           NULL,                                                                   \
                           "round each weight by itself, so that constants ripple (default: so "   \
                           "that the sum at each position is kept)"},                              \
    [PLAN_SINGLE_BIAS] = {.name = "single-bias",                                                   \
                          0,                                                                       \
                          OPTION_FLAG,                                                             \
                          NULL,                                                                    \
                          "the whole bias comes with the first pass, as naive code has it"},       \
    [PLAN_NO_SCALE] = {.name = "no-scale",                                                         \
                       0,                                                                          \
                       OPTION_FLAG,                                                                \
                       NULL,                                                                       \
                       "do not scale the result, even where no order keeps the range without"},    \
    [PLAN_BLEND_ONLY] = {.name = "blend-only",                                                     \
                         0,                                                                        \
                         OPTION_FLAG,                                                              \
                         NULL,                                                                     \
                         "as if the profile had no ping-pong"},                                    \
    [PLAN_CHANNELS] = {.name = "channels",                                                         \
                       0,                                                                          \
                       OPTION_CHOICE,                                                              \
                       NULL,                                                                       \
                       "of the source that are filtered together (default 1); not with dot4",      \
                       plan_channels_choices},                                                     \
    [PLAN_WORST_CASE] = PLAN_SPEC_WORST_CASE("[0, 1]"),                                            \
    [PLAN_MEMORY] = {.name = "memory",                                                             \
                     0,                                                                            \
                     OPTION_BYTES,                                                                 \
                     "BYTES",                                                                      \
                     "limit for the tiles (default 1G); K, M and G are powers of 1024"},           \
    [PLAN_JSON] = {.name = "json", 0, OPTION_FLAG, NULL, "print everything as JSON"},              \
    [PLAN_QUIET] = {.name = "quiet", 'q', OPTION_FLAG, NULL, "only errors, and no progress"},      \
    [PLAN_VERBOSE] = {.name = "verbose", 'v', OPTION_FLAG, NULL, "say what is done"}

extern const char *const plan_dims_choices[], *const plan_derivative_choices[],
                                                  *const plan_channels_choices[];

// `--kernel help` and `--profile help`: prints the list and returns true.
bool plan_options_help(const struct option_value *options);

// Fills params from the common options. *file is for weft_kernel_file_destroy once the plan is
// gone. Returns WEFT_ERR_ARGUMENT, or what kernels_load returns, after an error line.
enum weft_result plan_options_read(const struct option_value *options,
                                   struct weft_pass_plan_params *params, weft_kernel_file **file);

#endif
