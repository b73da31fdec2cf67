// SPDX-License-Identifier: BSD-3-Clause
// passes/multipass/multipass.h - runs plans: on GL, and on the CPU in the same integers.
// Both take samples on a lattice and the positions of a planar grid of pixels, and give values in
// the samples' own range. On unorm targets the two agree in every bit on every GL that keeps to
// GL's rules: passes compute in integers and hand over whole codes.
// Samples f are mapped to (f - low) / (high - low), so that a result r of the plan's arithmetic,
// (y / T - bias) / scale of its last target, is the value low S + (high - low) r, where S is the
// sum of the kernel's weights: 1 where they add up to one everywhere, about 0 for derivatives, and
// else the exact sum at the pixel's position.
#ifndef WEFT_PASSES_MULTIPASS_MULTIPASS_H
#define WEFT_PASSES_MULTIPASS_MULTIPASS_H

#include <math.h>

#include "../gl/context.h"
#include "../plan/plan.h"

WEFT_BEGIN_DECLS

// Samples (of a prefiltered kernel, coefficients) [z][y][x], x fastest, tightly packed, at integer
// coordinates; beyond them the nearest sample's value holds. Sizes along axes past the plan's dims
// are 1.
struct weft_samples {
    int size[3];
    const float *plane[4]; // as many as the plan has channels; borrowed
    // The range mapped to [0, 1], one for all channels. NAN, or both 0: the finite minimum and
    // maximum. What lies outside is clamped to it. Where both are the same, all samples count as
    // that.
    double low, high;
};

// Pixel (x, y) lies at origin + x du + y dv, in the samples' coordinates, as doubles; where columns
// are given, at columns[x] along the first axis, and where rows are, at rows[y] along the second:
// for scales whose multiples doubles do not hold. Its first tap and fraction are those of
// weft_kernel_first_tap, and of a tile's M samples along an axis number floor(fraction M) is taken.
struct weft_pixel_grid {
    int width, height;
    double origin[3], du[3], dv[3];
    const double *columns, *rows; // [width], [height]; borrowed; NULL: as above
    int fraction_bits; // positions are rounded to so many, half-way up; 0: they stay as they are
};

struct weft_multipass_report {
    double low, high; // the range that was mapped
    uint64_t clamped; // samples outside it, or not finite, of all channels
    // Pixels with a tap whose sample is not finite, and whose exact weight is not 0: they are NAN,
    // in the channels where that is so.
    uint64_t not_finite;
    double prepare_seconds, upload_seconds, pass_seconds, readback_seconds;
    uint64_t source_bytes, tile_bytes, target_bytes, position_bytes; // in textures and buffers
    // Emulation only: clamped stores over all passes, and by how many codes at most.
    uint64_t clamps;
    double largest_clamp;
};

struct weft_multipass_params {
    const weft_pass_plan *plan; // required
    const struct weft_samples *samples;
    const struct weft_pixel_grid *grid;
    float *pixels[4]; // width * height each, as many as the plan has channels; NAN and all
    const struct weft_progress *progress; // may be NULL
    const struct weft_log *log;
};

// Returns WEFT_ERR_ARGUMENT (sizes, ranges, positions that are not finite), WEFT_ERR_UNSUPPORTED
// (log with a range below 0), WEFT_ERR_LIMIT (texels and the GL's limit), WEFT_ERR_MEMORY,
// WEFT_ERR_GL or WEFT_ERR_CANCELLED. report may be NULL. Targets that a pass both reads and writes
// need no second texture where GL has GL_EXT_shader_framebuffer_fetch.
WEFT_API enum weft_result weft_multipass_run(weft_context *context,
                                             const struct weft_multipass_params *params,
                                             struct weft_multipass_report *report);

// The same without GL. Half targets are rounded towards zero, as llvmpipe does it.
WEFT_API enum weft_result weft_multipass_emulate(const struct weft_multipass_params *params,
                                                 struct weft_multipass_report *report);

// |pixel - reference| over all pixels where both are finite. The reference is
// filter/analysis/reference.h's at the exact positions, along one axis with the derived kernel
// where the plan has a derivative. Where that is beyond the range of floats, the range's end and
// infinity are right. Returns WEFT_ERR_ARGUMENT, WEFT_ERR_LIMIT or WEFT_ERR_CANCELLED.
struct weft_multipass_error {
    double maximum, rms; // in the samples' units
    int at_x, at_y, channel;
    uint64_t not_finite_mismatches;
};
WEFT_API enum weft_result weft_multipass_verify(const struct weft_multipass_params *params,
                                                struct weft_multipass_error *out);

WEFT_END_DECLS
#endif
