// SPDX-License-Identifier: BSD-3-Clause
// passes/gl/sampler_rows.h - where a sampler is measured, and what the measurements prove
// (passes/gl/sampler.h): pure, so that it can be tested with samplers that are known (not
// installed).
#ifndef WEFT_PASSES_GL_SAMPLER_ROWS_H
#define WEFT_PASSES_GL_SAMPLER_ROWS_H

#include "passes/gl/sampler.h"

enum {
    WEFT_SAMPLER_POINTS = 1024, // of a row
    WEFT_SAMPLER_PLACES = 6,    // pairs of texels, measured in so many rows of points each:
    WEFT_SAMPLER_PARTS = 8,
    WEFT_SAMPLER_SPACINGS = 7,
    // Row 0: centres; then places; then spacings.
    WEFT_SAMPLER_ROWS = 1 + WEFT_SAMPLER_PLACES * WEFT_SAMPLER_PARTS + WEFT_SAMPLER_SPACINGS,
};

// The points of a row, in texels along an axis: start + i * step, exact in single precision.
struct weft_sampler_row {
    float start, step;
};
void weft_sampler_rows_set(int size, struct weft_sampler_row out[WEFT_SAMPLER_ROWS]);

// What was found along one axis, [row][point]: `contrast` of texels 0, 1, 0, 1, ...; `code` of
// texels low, 1, low, 1, ...
struct weft_sampler_found {
    int size;
    const float *contrast, *code;
    double low;
};
// Takes the axis into account: *out is {0} before the first. false: a sampler that does not do, and
// `why` says in what.
bool weft_sampler_rows_judge(const struct weft_sampler_found *found, struct weft_sampler *out,
                             char *why, size_t why_size);

#endif
