// SPDX-License-Identifier: BSD-3-Clause
// passes/hardware/work.h - what filtering by the texture sampler does, in counts that
// passes/choose/cost.h weighs.
#ifndef WEFT_PASSES_HARDWARE_WORK_H
#define WEFT_PASSES_HARDWARE_WORK_H

#include "../../tiles/volume/layout.h"

WEFT_BEGIN_DECLS

// The work of one run, known from a plan or estimated before there is one.
struct weft_hardware_work {
    enum weft_source_format source; // of the texels
    double texels;                  // that are laid out and uploaded
    double fetches;                 // filtered ones, per pixel
    double weights;       // vectors of four coefficients that a pixel's weights are made of
    bool weights_fetched; // from a texture, or else uniform
};

WEFT_END_DECLS
#endif
