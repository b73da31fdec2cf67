// SPDX-License-Identifier: BSD-3-Clause
// passes/slice/multipass.h - what plans of passes (passes/plan/plan.h) make of cuts through
// volumes: bounds of their errors.
#ifndef WEFT_PASSES_SLICE_MULTIPASS_H
#define WEFT_PASSES_SLICE_MULTIPASS_H

#include "slice.h"

WEFT_BEGIN_DECLS

// Returns the terms of |pixel - exact| for weft_bound_compute, of a slice that is run in passes:
// those of the plan of passes, what the grid's numbers lose as floats, and positions, which are off
// by their rounding to fixed point. Pure.
WEFT_API struct weft_bound_terms weft_slice_multipass_bound_terms(const weft_slice_plan *slice,
                                                                  const weft_pass_plan *plan);

WEFT_END_DECLS
#endif
