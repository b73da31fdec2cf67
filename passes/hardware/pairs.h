// SPDX-License-Identifier: BSD-3-Clause
// passes/hardware/pairs.h - which neighbouring taps of a kernel a linear sampler takes at once
// (Sigg and Hadwiger, GPU Gems 2, chapter 20): those whose weights a and b have one sign at every
// position, as (a + b) times the value at b / (a + b) between the two. Pure (not installed).
#ifndef WEFT_PASSES_HARDWARE_PAIRS_H
#define WEFT_PASSES_HARDWARE_PAIRS_H

#include "filter/kernels/kernel.h"
#include "tiles/kernel/polynomial_tiles.h"

// Weights of the other sign that are no larger are taken for roundings of 0, and count as errors.
#define WEFT_HARDWARE_WRONG_SIGN 0x1p-20

// The fetches along an axis, in the order of their taps.
struct weft_hardware_pairs {
    int fetches;
    int tap[WEFT_KERNEL_MAX_WIDTH];     // the first one's
    bool paired[WEFT_KERNEL_MAX_WIDTH]; // with the tap after it
    int pairs;
    // What weights of the wrong sign make all weights of a position off by, at most.
    double wrong_sign;
};

// As few fetches as there can be, by the signs of the polynomials over all of [0, 1], which their
// Bernstein coefficients enclose.
void weft_hardware_pairs_find(const struct weft_polynomial_tiles *tiles,
                              struct weft_hardware_pairs *out);

#endif
