// SPDX-License-Identifier: BSD-3-Clause
// tests/support/tile_error.h - the error of kernel tiles as a GL's own samplers look them up.
// eps_h (Hadwiger, Hauser, Moeller, WSCG 2003, eq. 4) is measured three times: from what GL
// returns, from a sampler in ideal arithmetic, and from a model of llvmpipe's, found on Mesa 22.3.6
// on x86-64. That filters textures of 8-bit unorm in integers: positions are rounded to 1/256 of a
// texel, ties to even, and every interpolation, along x, then y, then z, to eight bits:
//   a + ((w (b - a) + 128) >> 8), w in 0 to 255.
// Other formats, and nearest lookup, are as ideal.
#ifndef WEFT_TESTS_SUPPORT_TILE_ERROR_H
#define WEFT_TESTS_SUPPORT_TILE_ERROR_H

#include "filter/analysis/error.h"
#include "passes/gl/context.h"
#include "tiles/kernel/kernel_tiles.h"

struct weft_tile_error_params {
    const weft_kernel_tiles *tiles; // required
    enum weft_error_lookup lookup;
    // L resampling positions per axis at fractions (i + 0.5) / L, 1 to 4096, up to 2^24 in all
    // (default 256, in 3D 32).
    int locations;
    const struct weft_log *log;
};

// Over all positions, of eps_i = sum_j |eps_h,j|.
struct weft_tile_error_figures {
    double maximum, mean;          // eps_h and its mean
    double single;                 // largest error of one weight
    double signed_min, signed_max; // of sum_j eps_h,j: the ripple on a constant 1.0
};

struct weft_tile_error {
    struct weft_tile_error_figures measured, ideal, eight_bit;
    // Largest difference of a weight as measured from the two models.
    double difference_ideal, difference_eight_bit;
    // Of the L fractions, how many lie where roundings of the texture coordinate decide which texel
    // (nearest) or which 1/256 of one (linear, 8-bit unorm) is looked up, so that a GL may differ
    // from its model: none where L is a power of two, M < 2 L and samples are at centres.
    int borders;
};

// Draws every tile of the set once. Returns WEFT_ERR_ARGUMENT, WEFT_ERR_UNSUPPORTED (2D and 3D
// tiles of radial kernels), WEFT_ERR_LIMIT, WEFT_ERR_MEMORY or WEFT_ERR_GL.
enum weft_result weft_tile_error_measure(weft_context *context,
                                         const struct weft_tile_error_params *params,
                                         struct weft_tile_error *out);
// The models alone, without GL: what was measured is NAN.
enum weft_result weft_tile_error_model(const struct weft_tile_error_params *params,
                                       struct weft_tile_error *out);

#endif
