// SPDX-License-Identifier: BSD-3-Clause
// passes/choose/method_impl.h - what choosing a method shares with planning one (not installed).
#ifndef WEFT_PASSES_CHOOSE_METHOD_IMPL_H
#define WEFT_PASSES_CHOOSE_METHOD_IMPL_H

#include "passes/fused/plan.h"
#include "passes/choose/method.h"

// The slice as the method has it planned.
struct weft_slice_params weft_method_slice_params(const struct weft_method_params *params);

// Of a fused or separable method: the bound, in the volume's values.
double weft_method_slice_bound(const struct weft_slice_plan_info *info,
                               const struct weft_slice_statistics *statistics);

// Whether the voxels are such as the method can take. Returns WEFT_ERR_UNSUPPORTED.
enum weft_result weft_method_check(const struct weft_method_params *params);

#endif
