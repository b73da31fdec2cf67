// SPDX-License-Identifier: BSD-3-Clause
// passes/multipass/reference.h - what a plan is to compute, exactly (not installed): positions,
// weights and values in double, of a list of passes made by hand as of a plan's.
#ifndef WEFT_PASSES_MULTIPASS_REFERENCE_H
#define WEFT_PASSES_MULTIPASS_REFERENCE_H

#include "passes/multipass/multipass.h"

// The part of a plan that is run; a list of passes made by hand does as well.
struct weft_multipass_work {
    const struct weft_pass_list *passes;
    struct weft_kernel kernel;
    struct weft_derivative derivative; // as in struct weft_pass_plan_info
    int channels;                      // 1 or 4
    int threads;                       // 0: one a processor
    bool portable;                     // GL: no extensions (tests)
};

// A plan's. Returns WEFT_ERR_ARGUMENT without one.
enum weft_result weft_multipass_plan_work(const struct weft_log *log, const weft_pass_plan *plan,
                                          struct weft_multipass_work *out);

// What a run is asked for, and what was asked for where pixels are verified.
struct weft_multipass_request {
    const struct weft_samples *samples;
    const struct weft_pixel_grid *grid;
    const float *pixels[4];
    int64_t stride; // 0: the grid's width
};

static inline int64_t weft_multipass_stride(const struct weft_multipass_request *request)
{
    return request->stride ? request->stride : request->grid->width;
}

// floor, without a call where that can be.
static inline double weft_floor(double x)
{
    if (!(fabs(x) < 0x1p62))
        return floor(x);
    const double toward_zero = (double)(int64_t)x;
    return toward_zero > x ? toward_zero - 1.0 : toward_zero;
}

// The position of a pixel; what weft_pixel_grid says, in double.
static inline void weft_multipass_position(const struct weft_pixel_grid *grid, int x, int y,
                                           double out[3])
{
    for (int a = 0; a < 3; a++)
        out[a] = grid->origin[a] + x * grid->du[a] + y * grid->dv[a];
    if (grid->columns)
        out[0] = grid->columns[x];
    if (grid->rows)
        out[1] = grid->rows[y];
    const int bits = grid->fraction_bits;
    if (!bits)
        return;
    const double units = bits > 0 && bits < 63 ? (double)(UINT64_C(1) << bits) : ldexp(1.0, bits);
    const double unit = 1.0 / units;
    for (int a = 0; a < 3; a++)
        out[a] = weft_floor(out[a] * units + 0.5) * unit;
}

// The kernel of each axis: the derivative's along one, where the plan says so.
struct weft_axis_kernels {
    struct weft_kernel kernel[3];
    bool sums_are_one;
};
void weft_multipass_axis_kernels(const struct weft_multipass_work *work,
                                 struct weft_axis_kernels *out);

// The exact weights at a position, as weft_kernel_weights_nd gives them, derivatives' too.
int weft_multipass_weights(const struct weft_multipass_work *work,
                           const struct weft_axis_kernels *axes, const double position[3],
                           double *weights, int64_t first[3]);

// The sample that a tap reads: the nearest, beyond all.
static inline size_t weft_multipass_sample(const struct weft_samples *samples,
                                           const int64_t index[3])
{
    size_t at = 0;
    for (int a = 2; a >= 0; a--) {
        const int64_t last = samples->size[a] - 1;
        const int64_t i = index[a] < 0 ? 0 : index[a] > last ? last : index[a];
        at = at * (size_t)samples->size[a] + (size_t)i;
    }
    return at;
}

// The value at a position, in double: the reference's, or a derivative's.
double weft_multipass_refer(const struct weft_multipass_work *work,
                            const struct weft_axis_kernels *axes,
                            const struct weft_samples *samples, int channel,
                            const double position[3]);

static inline bool weft_job_go_on(const struct weft_progress *progress, double fraction)
{
    return !progress || !progress->report || progress->report(progress->priv, fraction);
}

#endif
