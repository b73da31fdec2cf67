// SPDX-License-Identifier: BSD-3-Clause
#include "passes/antialias/accumulative.h"

const char *const weft_acaa_form_names[] = {
    [WEFT_ACAA_AUTO] = "auto",           [WEFT_ACAA_POST_DEPTH] = "post-depth",
    [WEFT_ACAA_SAMPLE_ID] = "sample-id", [WEFT_ACAA_JITTER] = "jitter",
    [WEFT_ACAA_FORM_COUNT] = NULL,
};
const char *const weft_acaa_coincident_names[] = {
    [WEFT_COINCIDENT_STENCIL] = "stencil", [WEFT_COINCIDENT_MASK] = "mask",
    [WEFT_COINCIDENT_ALPHA] = "alpha",     [WEFT_COINCIDENT_NONE] = "none",
    [WEFT_COINCIDENT_COUNT] = NULL,
};
const char *const weft_acaa_sums_names[] = {
    [WEFT_ACAA_INTEGER] = "integer",
    [WEFT_ACAA_FLOAT] = "float",
    [WEFT_ACAA_SUMS_COUNT] = NULL,
};
