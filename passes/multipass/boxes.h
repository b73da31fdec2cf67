// SPDX-License-Identifier: BSD-3-Clause
// passes/multipass/boxes.h - samples of which only boxes are there (not installed).
// A cut through a volume reaches a thin part of any box around it. Its samples come as many small
// boxes, and each pixel reads one of them: what is mapped, laid out and uploaded is about what its
// taps touch.
#ifndef WEFT_PASSES_MULTIPASS_BOXES_H
#define WEFT_PASSES_MULTIPASS_BOXES_H

#include <math.h>

#include "passes/multipass/multipass.h"

// Samples in a box. Boxes may overlap, and then hold the same values.
struct weft_sample_box {
    int32_t min[3];        // the first one's coordinates, those of the grid
    int size[3];           // each at least 1
    const float *plane[4]; // [z][y][x], as many as the plan has channels; borrowed
};

// Where a run found each pixel's first tap: it depends on grid and boxes, not on samples, so that
// runs that have these in common can share it. {0} at first; a run of the compiled plan fills it.
struct weft_box_entries {
    struct weft_job_entry *entry;
};
void weft_box_entries_destroy(struct weft_box_entries *entries); // {0} is fine

struct weft_sample_boxes {
    size_t count;
    const struct weft_sample_box *box;
    // [y][x] of the grid: which box holds the taps of each pixel, all of them. NULL: there is one
    // box, beyond which the nearest of its samples holds.
    const uint32_t *of_pixel;
    struct weft_box_entries *kept; // NULL: found for this run alone
    double low, high;              // as in struct weft_samples
};

// A range for floats: a float is in it where it lies from low to high as a double.
struct weft_float_range {
    float least, most;
};

static inline struct weft_float_range weft_float_range(double low, double high)
{
    struct weft_float_range range = {(float)low, (float)high};
    if ((double)range.least < low)
        range.least = nextafterf(range.least, INFINITY);
    if ((double)range.most > high)
        range.most = nextafterf(range.most, -INFINITY);
    return range;
}

// weft_multipass_run with these in place of params->samples. Samples that several boxes hold count
// several times where the report counts them.
enum weft_result weft_multipass_run_boxes(weft_multipass *compiled,
                                          const struct weft_multipass_run_params *params,
                                          const struct weft_sample_boxes *boxes,
                                          struct weft_multipass_report *report);

#endif
