// SPDX-License-Identifier: BSD-3-Clause
// passes/fused/work.h - what the fused pass over all taps does, in counts that
// passes/choose/cost.h weighs.
#ifndef WEFT_PASSES_FUSED_WORK_H
#define WEFT_PASSES_FUSED_WORK_H

#include "../../tiles/volume/layout.h"

WEFT_BEGIN_DECLS

// The work of one run, known from a plan or estimated before there is one.
struct weft_fused_work {
    enum weft_layout layout;        // not AUTO
    enum weft_source_format source; // of the texels
    double texels;                  // that are laid out and uploaded
    double fetches;                 // of the source, per pixel
    double weights;       // vectors of four coefficients that a pixel's weights are made of
    bool weights_fetched; // from a texture, or else uniform
};

// The same of the CPU engine, which reads floats from memory.
struct weft_fused_cpu_work {
    double samples; // that are laid out
    double rows;    // of taps side by side along x, per pixel
    int width;      // taps of a row
};

WEFT_END_DECLS
#endif
