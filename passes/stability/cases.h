// SPDX-License-Identifier: BSD-3-Clause
// passes/stability/cases.h - the cases, and what they share (not installed).
#ifndef WEFT_PASSES_STABILITY_CASES_H
#define WEFT_PASSES_STABILITY_CASES_H

#include "passes/accumulate/accumulate.h"
#include "passes/gl/gl.h"
#include "passes/stability/stability.h"
#include "passes/verify/verify.h"

extern const struct weft_stability_case weft_stability_order_2d, weft_stability_order_3d,
    weft_stability_gradient_bias, weft_stability_ripple_2d, weft_stability_ripple_3d;
extern const struct weft_stability_case weft_stability_blend_8, weft_stability_mean_8,
    weft_stability_half_sum, weft_stability_buffer_16, weft_stability_tree_bias,
    weft_stability_float_mean, weft_stability_srgb_mean, weft_stability_id_mean,
    weft_stability_nan_frame;
extern const struct weft_stability_case weft_stability_jitter_shift, weft_stability_few_frames,
    weft_stability_lens_outside, weft_stability_light_corner;
extern const struct weft_stability_case weft_stability_drawn_twice, weft_stability_shader_apart,
    weft_stability_edge_ids, weft_stability_own_frustum, weft_stability_bright_sum;
extern const struct weft_stability_case weft_stability_half_passes, weft_stability_half_overflow;
extern const struct weft_stability_case weft_stability_filter_weights, weft_stability_texel_centres,
    weft_stability_same_size, weft_stability_odd_width;
extern const struct weft_stability_case weft_stability_far_away, weft_stability_one_voxel,
    weft_stability_wide_kernel;
extern const struct weft_stability_case weft_stability_wide_range, weft_stability_no_data,
    weft_stability_not_finite, weft_stability_zero_weight, weft_stability_ringing;

// One line of the result.
void weft_stability_say(struct weft_stability_result *result, const char *unit, const char *format,
                        ...) __attribute__((format(printf, 3, 4)));

// A repeatable value in [-1, 1] for every voxel.
float weft_stability_noise(int x, int y, int z);
void weft_stability_fill_noise(float *data, const int size[3]);

// ---- averages -----------------------------------------------------------------------------------

// Frames of one channel in memory, one after the other.
struct weft_stability_frames {
    int count, width, height;
    enum weft_plane_type type;
    void *values; // [frame][y][x]
};
struct weft_plane weft_stability_frame(const struct weft_stability_frames *frames, int index);

// Their mean by one method, on the context or, without one, emulated. Each frame counts `weight`.
// out[pixel]; report: NULL where nobody asks.
enum weft_result weft_stability_accumulate(const struct weft_stability_params *params,
                                           const struct weft_stability_frames *frames,
                                           struct weft_accumulator_params how, double weight,
                                           float *out, struct weft_accumulator_report *report);

// ---- slices -------------------------------------------------------------------------------------

// Voxels in memory, clamped to the edge, and a slice through them in index space.
struct weft_stability_slice {
    const char *kernel;
    const float *data; // [z][y][x], x fastest
    int size[3];
    int32_t first[3]; // index coordinates of the first voxel
    struct weft_slice_geometry geometry;
    bool clamp; // pixels to the samples next to them
};

// A plane tilted against every axis, through the middle of the box from `first` on.
struct weft_slice_geometry weft_stability_oblique(const int32_t first[3], double length, int width,
                                                  int height);

// What a slice's plan promises: relative * largest voxel in reach + absolute.
struct weft_stability_bound {
    double relative, absolute;
};

// Pixels of weft_slice_run, and the bound of their error.
enum weft_result weft_stability_slice_run(const struct weft_stability_params *params,
                                          const struct weft_stability_slice *slice, float *pixels,
                                          struct weft_stability_bound *bound);

// Verifies all pixels. bound: NULL where `share` is not asked for.
enum weft_result weft_stability_compare(const struct weft_log *log,
                                        const struct weft_stability_slice *slice,
                                        const float *pixels,
                                        const struct weft_stability_bound *bound,
                                        struct weft_verify_report *out);

// ---- passes of plans ----------------------------------------------------------------------------

// On GL, or emulated without a context.
enum weft_result weft_stability_passes_run(const struct weft_stability_params *params,
                                           const struct weft_pass_plan_params *plan_params,
                                           const struct weft_samples *samples,
                                           const struct weft_pixel_grid *grid, float *pixels,
                                           struct weft_verify_report *error,
                                           struct weft_pass_plan_error *bounds);

// ---- naive ways ---------------------------------------------------------------------------------

// A slice as one writes it first: a fragment shader, positions in single precision, weights from
// a formula (Catmull-Rom), a sampler or a padded row of four.
struct weft_naive_slice {
    enum weft_naive_lookup {
        WEFT_NAIVE_CATMULL_ROM,
        WEFT_NAIVE_LINEAR_OF_FOUR,
        WEFT_NAIVE_SAMPLER, // GL_LINEAR at (position + 0.5) / size
        WEFT_NAIVE_CORNERS, // GL_LINEAR at position / (size - 1)
    } lookup;
    bool normalised; // the texture coordinate of a picture as large as the target: positions are
                     // gl_FragCoord / target * source - 0.5, whatever the slice's geometry
    GLenum source, target; // internal formats, red only
    bool mapped; // samples to [0, 1] and pixels back, by a scale formed in single precision
};
enum weft_result weft_naive_slice_run(const struct weft_stability_params *params,
                                      const struct weft_stability_slice *slice,
                                      const struct weft_naive_slice *naive, float *pixels);

// A slice by weft's way and by the naive one, each against the reference. pixels: room for one.
struct weft_stability_ways {
    struct weft_verify_report ours, naive;
    struct weft_stability_bound bound; // of ours
};
enum weft_result weft_stability_compare_ways(const struct weft_stability_params *params,
                                             const struct weft_stability_slice *slice,
                                             const struct weft_naive_slice *naive, float *pixels,
                                             struct weft_stability_ways *out);

// The same in double on the CPU, with one of the mistakes.
enum weft_naive_mistake {
    WEFT_NAIVE_FLOOR,      // the first tap of odd widths is found as that of even ones is
    WEFT_NAIVE_DROP,       // taps outside are left out
    WEFT_NAIVE_NORMALISED, // coordinates go through [0, 1], divided by the size less 1
};
enum weft_result weft_naive_convolve(const struct weft_log *log,
                                     const struct weft_stability_slice *slice,
                                     enum weft_naive_mistake mistake, float *pixels);

#endif
