// SPDX-License-Identifier: BSD-3-Clause
// passes/choose/cost_impl.h - what predicting and calibrating share (not installed).
#ifndef WEFT_PASSES_CHOOSE_COST_IMPL_H
#define WEFT_PASSES_CHOOSE_COST_IMPL_H

#include "passes/choose/cost.h"

// Samples of the boxes that passes lay out for a slice: its rectangles are halved until a box fits.
double weft_cost_box_samples(const struct weft_slice_plan_info *slice);

#endif
