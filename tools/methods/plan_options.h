// SPDX-License-Identifier: BSD-3-Clause
// tools/methods/plan_options.h - the options that say what is to be planned, as `weft plan` and
// `weft validate --order` share them.
#ifndef WEFT_TOOLS_METHODS_PLAN_OPTIONS_H
#define WEFT_TOOLS_METHODS_PLAN_OPTIONS_H

#include "tools/methods/pass_options.h"

enum plan_option {
    PLAN_KERNEL,
    PLAN_DIMS,
    PLAN_DERIVATIVE,
    PLAN_PASSES, // the first of enum pass_option; a verb has its own help of the order
    PLAN_ROUND_SINGLY = PLAN_PASSES + PASS_PLAN_COUNT,
    PLAN_SINGLE_BIAS,
    PLAN_NO_SCALE,
    PLAN_BLEND_ONLY,
    PLAN_CHANNELS,
    PLAN_MEMORY, // but for the worst case, those above make no sense for a plan that is there
    PLAN_JSON,
    PLAN_QUIET,
    PLAN_VERBOSE,
    PLAN_COMMON_COUNT, // a verb's own are behind them
};

// For the verbs' tables.
#define PLAN_COMMON_OPTIONS                                                                        \
    [PLAN_KERNEL] = {.name = "kernel",                                                             \
                     'k',                                                                          \
                     OPTION_TEXT,                                                                  \
                     "NAME",                                                                       \
                     "the reconstruction kernel (default catmull-rom), as in weft slice; 'help' "  \
                     "lists the kernels",                                                          \
                     .group = OPTION_FILTER,                                                       \
                     .brief = "which kernel (catmull-rom); help lists them",                       \
                     .names = OPTION_NAMES_KERNEL},                                                \
    [PLAN_DIMS] = {.name = "dims",                                                                 \
                   'd',                                                                            \
                   OPTION_CHOICE,                                                                  \
                   NULL,                                                                           \
                   "dimensions of the source (default 2)",                                         \
                   plan_dims_choices,                                                              \
                   .group = OPTION_TASK,                                                           \
                   .brief = "of the source: 2 or 3"},                                              \
    [PLAN_DERIVATIVE] = {.name = "derivative",                                                     \
                         0,                                                                        \
                         OPTION_TEXT,                                                              \
                         "x|y|z|xx|xy|...",                                                        \
                         "reconstruct this component of the gradient or the Hessian instead",      \
                         .group = OPTION_FILTER,                                                   \
                         .brief = "a component of gradient or Hessian"},                           \
    PASS_PLAN_OPTIONS(PLAN_PASSES,                                                                 \
                      "what the hardware may do in a pass (default unorm8): a name, a name and "   \
                      "what differs, or, from unorm8 on, only what differs",                       \
                      "plain: a tap per fetch (default); dot4: four; split-precision: twice "      \
                      "the passes keep the bits that the target loses; hierarchical: small "       \
                      "weights in targets of their own; log: sums of logarithms for products",     \
                      "[0, 1]"),                                                                   \
    [PLAN_ROUND_SINGLY] = {.name = "round-singly",                                                 \
                           0,                                                                      \
                           OPTION_FLAG,                                                            \
                           NULL,                                                                   \
                           "round each weight by itself, so that constants ripple (default: so "   \
                           "that the sum at each position is kept)",                               \
                           .group = OPTION_METHOD},                                                \
    [PLAN_SINGLE_BIAS] = {.name = "single-bias",                                                   \
                          0,                                                                       \
                          OPTION_FLAG,                                                             \
                          NULL,                                                                    \
                          "the whole bias comes with the first pass, as naive code has it",        \
                          .group = OPTION_METHOD},                                                 \
    [PLAN_NO_SCALE] = {.name = "no-scale",                                                         \
                       0,                                                                          \
                       OPTION_FLAG,                                                                \
                       NULL,                                                                       \
                       "do not scale the result, even where no order keeps the range without",     \
                       .group = OPTION_METHOD},                                                    \
    [PLAN_BLEND_ONLY] = {.name = "blend-only",                                                     \
                         0,                                                                        \
                         OPTION_FLAG,                                                              \
                         NULL,                                                                     \
                         "as if the profile had no ping-pong",                                     \
                         .group = OPTION_METHOD},                                                  \
    [PLAN_CHANNELS] = {.name = "channels",                                                         \
                       0,                                                                          \
                       OPTION_CHOICE,                                                              \
                       NULL,                                                                       \
                       "of the source that are filtered together (default 1); not with dot4",      \
                       plan_channels_choices,                                                      \
                       .group = OPTION_FILES},                                                     \
    [PLAN_MEMORY] = {.name = "memory",                                                             \
                     0,                                                                            \
                     OPTION_BYTES,                                                                 \
                     "BYTES",                                                                      \
                     "limit for the tiles (default 1G); K, M and G are powers of 1024",            \
                     .group = OPTION_RESOURCES},                                                   \
    [PLAN_JSON] = OPTIONS_JSON("everything"), [PLAN_QUIET] = OPTIONS_QUIET,                        \
    [PLAN_VERBOSE] = OPTIONS_VERBOSE

extern const char *const plan_dims_choices[], *const plan_channels_choices[];

// Fills params from the common options. *file is for weft_kernel_file_destroy once the plan is
// gone. Returns WEFT_ERR_ARGUMENT, or what kernels_load returns, after an error line.
enum weft_result plan_options_read(const struct option_value *options,
                                   struct weft_pass_plan_params *params, weft_kernel_file **file);

#endif
