// SPDX-License-Identifier: BSD-3-Clause
// passes/separable/work.h - what filtering one axis after the other does, in counts that
// passes/choose/cost.h weighs.
#ifndef WEFT_PASSES_SEPARABLE_WORK_H
#define WEFT_PASSES_SEPARABLE_WORK_H

#include "../../filter/base.h"

WEFT_BEGIN_DECLS

// The work of one run.
struct weft_separable_work {
    int width;     // taps of the kernel
    double summed; // samples that are prepared: of slices, voxels summed along the third axis
    double taps;   // that both passes add up, over all pixels
};

// Counts the work for a kernel's width, a plane of samples in reach and a plane of pixels: columns
// and rows of both, all > 0. Pure and thread-safe. The first pass is along the axis that leaves
// fewer pixels between the two.
WEFT_API struct weft_separable_work weft_separable_work_of(int width, double sample_columns,
                                                           double sample_rows, double columns,
                                                           double rows);

WEFT_END_DECLS
#endif
