// SPDX-License-Identifier: BSD-3-Clause
// passes/warp/careful.h - values, and pixels summed in double, tap by tap (not installed).
#ifndef WEFT_PASSES_WARP_CAREFUL_H
#define WEFT_PASSES_WARP_CAREFUL_H

#include "passes/warp/warp_impl.h"

// ---- values -------------------------------------------------------------------------------------

// A plane of values, and what holds beyond them.
struct weft_warp_values {
    const float *plane;
    int64_t stride;
    int size[2];
    enum weft_boundary boundary;
    float border;
};

// At indices that weft_boundary_index returned.
static inline double weft_warp_value(const struct weft_warp_values *v, int64_t x, int64_t y)
{
    return (double)(x < 0 || y < 0 ? v->border : v->plane[y * v->stride + x]);
}

// A channel's samples.
static inline struct weft_warp_values weft_warp_samples(const struct weft_warp_plan *plan,
                                                        const weft_resample_source *source, int c)
{
    return (struct weft_warp_values){source->plane[c],
                                     source->stride,
                                     {plan->info.size[0], plan->info.size[1]},
                                     plan->info.boundary,
                                     (float)source->info.border};
}

// What is read in their place: the same, or coefficients.
static inline struct weft_warp_values weft_warp_values(const struct weft_warp_plan *plan,
                                                       const weft_resample_source *source, int c)
{
    return (struct weft_warp_values){weft_resample_values(source, c),
                                     plan->values[0],
                                     {plan->values[0], plan->values[1]},
                                     plan->info.boundary,
                                     (float)source->info.border};
}

// Whether sums in single precision do: no value is NAN, infinite, or too large for them.
bool weft_warp_is_plain(const struct weft_warp_plan *plan, const weft_resample_source *source);

// ---- one pixel ----------------------------------------------------------------------------------

// What one thread needs: the weights of a pixel.
struct weft_warp_scratch {
    const struct weft_warp_plan *plan;
    int count[2];
    int32_t first[2]; // reduced
    double *weights[2];
    int64_t *index[2];
};
// Returns WEFT_ERR_MEMORY.
enum weft_result weft_warp_scratch_create(const struct weft_warp_plan *plan,
                                          struct weft_warp_scratch *out);
void weft_warp_scratch_destroy(struct weft_warp_scratch *scratch); // {0} is fine

// Finds the weights of a row's pixel number i, and sums it; taps whose weight is 0 do not count.
void weft_warp_scratch_set(struct weft_warp_scratch *scratch, const struct weft_warp_row *row,
                           int i);
float weft_warp_careful(struct weft_warp_scratch *scratch, const struct weft_warp_values *values);

// A value, held between the samples around a position, within a scale along each axis.
double weft_warp_held(const struct weft_warp_values *values, const double at[2],
                      const double scale[2], double value);
// Holds pixels of a row, of one channel.
void weft_warp_clamp(const struct weft_warp_plan *plan, const weft_resample_source *source, int c,
                     const struct weft_warp_row *row, int count, float *pixels);

#endif
