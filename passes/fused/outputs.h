// SPDX-License-Identifier: BSD-3-Clause
// passes/fused/outputs.h - several outputs of a pixel as the shader passes/fused/fused.glsl makes
// them (not installed).
#ifndef WEFT_PASSES_FUSED_OUTPUTS_H
#define WEFT_PASSES_FUSED_OUTPUTS_H

#include "passes/fused/plan.h"

// Bytes that the defines of all outputs fit in.
enum { WEFT_FUSED_DEFINES = 8192 };

// Adds to `defines`, a string in WEFT_FUSED_DEFINES bytes, what the shader is told of a plan that
// derives: which weights there are, and lists of what is summed up, each thing once, in an order in
// which what is needed comes first.
void weft_fused_define_outputs(const struct weft_slice_plan *plan, char *defines);

#endif
