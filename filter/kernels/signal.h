// SPDX-License-Identifier: BSD-3-Clause
// filter/kernels/signal.h - analytic test signals: volumes whose value is known at every point.
// A signal is defined over the cube [-1, 1]^3 unless its record says otherwise; a volume of n
// voxels along an axis samples it at -1 + 2 (i + 0.5) / n ("cell-centred"; Marschner and Lobb 1994
// use 40^3). Distances (sphere) are in those units. Thread-safe, allocates nothing.
#ifndef WEFT_FILTER_KERNELS_SIGNAL_H
#define WEFT_FILTER_KERNELS_SIGNAL_H

#include "../base.h"

WEFT_BEGIN_DECLS

// One signal: constant data in static storage.
struct weft_signal_info {
    const char *name;        // "marschner-lobb"
    const char *description; // one line
    const char *citation;    // authors, where it was published; NULL where it needs none
    // Returns the value at a point of [-1, 1]^3. Pure.
    double (*value)(const double position[3]);
    // Writes the gradient there, per unit of the cube, not per voxel. Pure; NULL where the signal
    // has none.
    void (*gradient)(const double position[3], double gradient[3]);
    int default_size; // voxels along each axis that show what the signal is for
    bool level_set;   // the value is a signed distance, to be stored as a narrow band
    // Defined by voxel index (impulse: 1 at voxel n/2 along each axis, 0 elsewhere); value() then
    // returns that of the voxel around the point at the default size.
    bool lattice;
};

// All signals, NULL-ended:
// - marschner-lobb: fM = 6, alpha = 0.25; values 0 to 1
// - sphere: distance to a sphere of radius 0.75 about the origin, negative inside
// - chirp: (1 + cos(32 pi |x|^2)) / 2, values 0 to 1; at its default size each axis reaches the
//   Nyquist rate at the faces of the cube, so that all three do at its corners
// - ramp: (x + 2y + 3z + 6) / 12, values 0 to 1
// - constant: 1
// - impulse: 1 at one voxel, 0 elsewhere
WEFT_API extern const struct weft_signal_info *const weft_signal_list[];
// Finds a signal by its name. Returns NULL if there is none, or for a NULL name.
WEFT_API const struct weft_signal_info *weft_signal_find(const char *name);

// Returns the cell-centred coordinate of voxel i among n (> 0) along an axis, as above.
static inline double weft_signal_coordinate(int64_t i, int64_t n)
{
    return -1.0 + (2.0 * (double)i + 1.0) / (double)n;
}

WEFT_END_DECLS
#endif
