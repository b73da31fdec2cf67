// SPDX-License-Identifier: BSD-3-Clause
// tiles/image/image_prefilter.h - coefficients of a plane, for kernels that interpolate by a
// prefilter (filter/kernels/prefilter.h; not installed).
#ifndef WEFT_TILES_IMAGE_IMAGE_PREFILTER_H
#define WEFT_TILES_IMAGE_IMAGE_PREFILTER_H

#include "filter/boundary.h"
#include "filter/kernels/prefilter.h"

// Samples (x, y) at samples[y * stride + x], stride >= width, and what stands beyond them.
struct weft_image_plane {
    const float *samples;
    int width, height;
    int64_t stride;
    enum weft_boundary boundary; // default clamp
    float border;                // the value of the boundary of that name, finite
};

// Computes the coefficients of a plane and of `pad` more samples on every side, for which the
// boundary's hold, and past those the last one of them: of mirrored and periodic planes only the
// samples' own coefficients are right, if pad is the prefilter's overlap. *out has (width + 2 pad)
// (height + 2 pad) of them, tightly packed, and is to be freed. Those that depend on samples that
// are not finite are missing. Returns WEFT_ERR_ARGUMENT for kernels without a prefilter,
// WEFT_ERR_MEMORY, or WEFT_ERR_LIMIT where coefficients leave the range of floats, as those of the
// largest floats do; *out is then NULL.
enum weft_result weft_image_prefilter(const struct weft_log *log, const struct weft_kernel *kernel,
                                      const struct weft_image_plane *plane, int pad, float **out);

#endif
