// SPDX-License-Identifier: BSD-3-Clause
// passes/antialias/pattern/pattern.h - where in a pixel samples are, when they come from several
// passes of a device's own few, and what each counts in the pixels around it.
//
// A pass moves the picture by a part of a pixel, so that the device's samples lie elsewhere in it.
// A sample that leaves its pixel so is its neighbour's, at the place that it has there: all pixels
// have the same samples, and each sample counts once. Everything is pure.
#ifndef WEFT_PASSES_ANTIALIAS_PATTERN_PATTERN_H
#define WEFT_PASSES_ANTIALIAS_PATTERN_PATTERN_H

#include "../../../filter/kernels/kernel.h"
#include "../../jitter/jitter.h"

WEFT_BEGIN_DECLS

// Samples of a pixel, of a device's pixel, and pixels that a sample reaches to each side, at most.
enum { WEFT_PATTERN_MAX = 256, WEFT_PATTERN_MAX_DEVICE = 32, WEFT_PATTERN_MAX_RADIUS = 8 };

struct weft_pattern_params {
    // The device's positions, x to the right, y down the rows, in pixels from the middle
    // (required), device_count of them.
    const double (*device)[2];
    int device_count;           // 1 to WEFT_PATTERN_MAX_DEVICE (required)
    int count;                  // samples of a pixel, a multiple of device_count to
                                // WEFT_PATTERN_MAX (required)
    const struct weft_log *log; // borrowed until the call returns; may be NULL
};
#define WEFT_PATTERN_DEFAULTS
#define weft_pattern_params(...) (&(struct weft_pattern_params){WEFT_PATTERN_DEFAULTS __VA_ARGS__})

// Samples of a pixel, pass by pass: sample pass * device_count + i is the device's i-th one.
struct weft_pattern {
    int count, passes, device_count;
    double offset[WEFT_PATTERN_MAX][2];   // of each pass's samples, in [0, 1): 256ths of a pixel
    double position[WEFT_PATTERN_MAX][2]; // of each sample in the pixel that it lies in
    int16_t pixel[WEFT_PATTERN_MAX][2];   // which pixel that is, from the one that is drawn: 0 or 1
    double discrepancy; // of the positions in the square (passes/jitter/discrepancy.h)
    double mean[2];     // of the positions: what they shift the picture by
};

// Finds the moves that give the set the least half-plane discrepancy of those tried, always the
// same ones: within milliseconds of up to 64 samples, a quarter of a second of 256; of Direct3D's
// four samples, 8, 16 and 64 are tabled, of longer searches. Of one pass there is no move; of
// several the first one is moved, too, so that the set lies about the pixel's middle. On failure
// *out is all zero. Returns WEFT_ERR_ARGUMENT (counts, positions that are not finite or not within
// the pixel).
WEFT_API enum weft_result weft_pattern_create(const struct weft_pattern_params *params,
                                              struct weft_pattern *out);

// ---- what samples count -------------------------------------------------------------------------

struct weft_spread_params {
    const double (*position)[2]; // of samples in a pixel, as above (required)
    int count;                   // 1 to WEFT_PATTERN_MAX (required)
    struct weft_kernel filter;   // h of a pixel (default nearest: a box of one pixel)
    double filter_width;         // pixels that its support 2 r is scaled to (default: as it is)
    // Weights become integers that add up to 2^bits, each at most 1 from its share, by the largest
    // remainder (1 to 30; default 0: real numbers only). Where all weights that are not 0 are the
    // same, as of a box, their integers are 1, and add up to how many those are.
    int bits;
    const struct weft_log *log; // borrowed until the call returns; may be NULL
};
#define WEFT_SPREAD_DEFAULTS
#define weft_spread_params(...) (&(struct weft_spread_params){WEFT_SPREAD_DEFAULTS __VA_ARGS__})

// What each sample of a pixel gives to the pixels around it: the pixel (x, y) further right and
// down gets h((x - p_x) / s) h((y - p_y) / s), s = width / (2 r), divided by the sum over all
// samples that a pixel gets. Of a support with jumps at its rims, [-r, r) about the pixel, a sample
// at the lower rim counts, and one at the upper does not. All zero: none.
struct weft_spread {
    int count, radius; // samples; pixels that they reach to each side, 0 of a box
    double *weight;    // [y + radius][x + radius][sample], of sum 1; owned
    int32_t *integer;  // the same as integers, of sum `total`; owned; NULL without bits
    int64_t total;
    double error;    // of the integers: sum of |integer / total - weight|
    double negative; // sum of the |weights| below 0
};
// On failure *out is all zero. Returns WEFT_ERR_ARGUMENT (no positions, some that are not in
// the pixel, a count, bits, a width that is not in [2^-20, 2^20], a kernel that is a derivative,
// weights that add up to less than 1/1000 of their magnitudes), WEFT_ERR_LIMIT (a radius above
// WEFT_PATTERN_MAX_RADIUS), WEFT_ERR_UNSUPPORTED (radial and prefiltered kernels) or
// WEFT_ERR_MEMORY.
WEFT_API enum weft_result weft_spread_create(const struct weft_spread_params *params,
                                             struct weft_spread *out);
WEFT_API void weft_spread_clear(struct weft_spread *spread); // accepts NULL, leaves zeros behind

WEFT_END_DECLS
#endif
