// SPDX-License-Identifier: BSD-3-Clause
// filter/kernels/stretch.h - kernels stretched for minification. Where pixels lie `scale` samples
// apart, more than one, the kernel h(x) becomes h(x / scale) / scale: its pass band ends where the
// pixels' does, and what they cannot show is filtered away (Turkowski 1990, "Filters for common
// resampling tasks"). In double, no allocation, thread-safe.
#ifndef WEFT_FILTER_KERNELS_STRETCH_H
#define WEFT_FILTER_KERNELS_STRETCH_H

#include "kernel.h"

WEFT_BEGIN_DECLS

// Scales accepted: 1 (not stretched) to this.
#define WEFT_STRETCH_MAX 16777216.0

// Returns what a kernel is stretched by for pixels that lie `distance` samples apart: the distance
// where it is more than 1, to WEFT_STRETCH_MAX, else 1, and 1 for kernels that move samples.
WEFT_API double weft_stretch_scale(const struct weft_kernel *kernel, double distance);

// Returns how many samples a stretched kernel meets at any position, at most: ceil(2 r scale) for
// scales above 1, one more of kernels of one tap, the kernel's width at 1; 0 for a kernel that
// weft_kernel_check refuses, a scale out of its range, and radial kernels.
WEFT_API int64_t weft_stretch_width(const struct weft_kernel *kernel, double scale);

// Writes the weft_stretch_width weights of the taps at position x, in order of increasing tap: at
// scale 1 those of weft_kernel_weights; else h((x - tap) / scale), divided by their sum where the
// kernel's weights add up to one (unit_sum, or normalised), so that constants stay, and by
// scale^(1 + n) else, n being the derivative that the record reconstructs. Of kernels of one tap a
// sample counts by how much of its unit square the stretched box covers: the area average of any
// scale. Returns the first tap. Of prefiltered kernels these are the weights of h itself. Writes
// none, and returns 0, for scales out of their range, positions that are not finite, radial kernels
// and those whose info, support or width is wrong; it checks no more, since it is called for every
// pixel.
WEFT_API int64_t weft_stretch_weights(const struct weft_kernel *kernel, double scale, double x,
                                      double *weights);

WEFT_END_DECLS
#endif
