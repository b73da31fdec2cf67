// SPDX-License-Identifier: BSD-3-Clause
// passes/choose/method_impl.h - what choosing a method shares with planning one (not installed).
#ifndef WEFT_PASSES_CHOOSE_METHOD_IMPL_H
#define WEFT_PASSES_CHOOSE_METHOD_IMPL_H

#include "passes/choose/method.h"
#include "passes/fused/plan.h"
#include "passes/hardware/plan.h"

// The slice as the method has it planned, and its passes.
struct weft_slice_params weft_method_slice_params(const struct weft_method_params *params);
struct weft_pass_plan_params weft_method_pass_params(const struct weft_method_params *params);

// The statistics as a bound takes them.
struct weft_bound_values weft_method_values(const struct weft_slice_statistics *statistics);

// The work of a method: of a request for it, where voxels lie as in a plan that was placed (or the
// request's own). passes: their plan's, or the least; NULL but for passes. samples: of their boxes.
// That of hardware is the caller's to fill in.
struct weft_work weft_method_work(const struct weft_method *method,
                                  const struct weft_slice_plan *request,
                                  const struct weft_slice_plan *placed,
                                  const struct weft_pass_work *passes, double samples);

// The sampler that hardware is planned for.
struct weft_sampler weft_method_sampler(const struct weft_method_params *params);

// Where a plan logs to from now on.
void weft_method_plan_set_log(weft_method_plan *plan, const struct weft_log *log);

// Whether the voxels are such as the method can take. Returns WEFT_ERR_UNSUPPORTED.
enum weft_result weft_method_check(const struct weft_method_params *params);

#endif
