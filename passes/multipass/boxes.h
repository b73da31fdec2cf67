// SPDX-License-Identifier: BSD-3-Clause
// passes/multipass/boxes.h - samples of which only boxes are there (not installed).
// A cut through a volume reaches a thin part of any box around it. Its samples come as many small
// boxes, and each pixel reads one of them: what is mapped, laid out and uploaded is about what its
// taps touch.
#ifndef WEFT_PASSES_MULTIPASS_BOXES_H
#define WEFT_PASSES_MULTIPASS_BOXES_H

#include "passes/multipass/multipass.h"

// Samples in a box. Boxes may overlap, and then hold the same values.
struct weft_sample_box {
    int32_t min[3];        // the first one's coordinates, those of the grid
    int size[3];           // each at least 1
    const float *plane[4]; // [z][y][x], as many as the plan has channels; borrowed
};

struct weft_sample_boxes {
    size_t count;
    const struct weft_sample_box *box;
    // [y][x] of the grid: which box holds the taps of each pixel, all of them. NULL: there is one
    // box, beyond which the nearest of its samples holds.
    const uint32_t *of_pixel;
    double low, high; // as in struct weft_samples
};

// weft_multipass_run with these in place of params->samples. Samples that several boxes hold count
// several times where the report counts them.
enum weft_result weft_multipass_run_boxes(weft_multipass *compiled,
                                          const struct weft_multipass_run_params *params,
                                          const struct weft_sample_boxes *boxes,
                                          struct weft_multipass_report *report);

#endif
