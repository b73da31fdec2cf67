// SPDX-License-Identifier: BSD-3-Clause
// passes/separable/separable_impl.h - what the files of passes/separable share (not installed).
#ifndef WEFT_PASSES_SEPARABLE_SEPARABLE_IMPL_H
#define WEFT_PASSES_SEPARABLE_SEPARABLE_IMPL_H

#include "filter/check.h"
#include "passes/separable/separable.h"

// Columns that a pass computes at a time, in a texel of its target.
enum { WEFT_SEPARABLE_LANES = 4 };

static inline int weft_separable_round_up(int columns)
{
    return (columns + WEFT_SEPARABLE_LANES - 1) / WEFT_SEPARABLE_LANES * WEFT_SEPARABLE_LANES;
}

// ---- plans --------------------------------------------------------------------------------------

// One axis of the pixels and of the samples.
struct weft_separable_axis {
    int positions, size; // pixels, samples
    double stretch;      // of the kernel
    int width;           // taps of every position
    enum weft_boundary boundary;
    double *at;     // of every position
    int32_t *first; // of every position: the first tap, moved to where the same samples are near
    int32_t low;    // the least of those
    int32_t span;   // taps from there to the last one of all
    int32_t *whole; // of every position: the sample it is, with a weight of 1; -1: none
    int all_taps;   // different taps of all positions
    int reach[2];   // first and last sample among them
    double growth;  // largest sum of |weights|, and 1 at least
};

struct weft_separable_plan {
    struct weft_separable_info info;
    struct weft_separable_axis axis[2];
    uint64_t memory_bytes;
    const struct weft_log *log;
};

// Writes the axis->width weights of a position, in order of its taps.
void weft_separable_weights(const struct weft_kernel *kernel,
                            const struct weft_separable_axis *axis, int position, double *weights);

// Different taps of a part of an axis' positions, counted from axis->low.
struct weft_separable_taps {
    int count;
    int32_t *sample; // of the different taps in order: which sample; -1: the border's value
    int32_t *place;  // of every tap that there is: its number among those
};

// Room for any part of an axis. Returns WEFT_ERR_MEMORY.
enum weft_result weft_separable_taps_create(const struct weft_log *log,
                                            const struct weft_separable_axis *axis,
                                            struct weft_separable_taps *out);
void weft_separable_taps_destroy(struct weft_separable_taps *taps); // {0} is fine
// Numbers the different taps of positions `from` to `to`, exclusive.
void weft_separable_taps_number(const struct weft_separable_axis *axis, int from, int to,
                                struct weft_separable_taps *taps);
// The number of a position's first tap.
static inline int32_t weft_separable_first_tap(const struct weft_separable_axis *axis,
                                               const struct weft_separable_taps *taps, int position)
{
    return taps->place[axis->first[position] - axis->low];
}

// First and last sample of positions `from` to `to`, exclusive.
void weft_separable_axis_reach(const struct weft_separable_axis *axis, int from, int to,
                               int reach[2]);

// ---- compiled plans -----------------------------------------------------------------------------

// One of the engines.
struct weft_separable {
    const weft_separable_plan *plan;
    struct weft_separable_gl *gl;
    struct weft_separable_cpu *cpu;
};

// Different taps of the parts that an axis is cut into, so many positions each; numbered in `taps`,
// of which the last part's are left. Returns those of the part that has most.
int weft_separable_most_taps(const struct weft_separable_axis *axis, int cut,
                             struct weft_separable_taps *taps);

// Where zeros are left out, only those are zero that are so in double.
float weft_separable_single_weight(bool skips_zeros, double weight);

// ---- runs ---------------------------------------------------------------------------------------

// What is done so that pixels are right where sums in single precision alone would not be.
struct weft_separable_care {
    bool skips_zeros; // a sample is not finite: taps whose weight is 0 are left out
    // Samples are divided by 2^this and pixels multiplied, so that no sum overflows on the way.
    int scale_bits;
    double margin; // by which rounding alone may bring a pixel past the range of floats
};

// The run with its defaults filled in, the survey but for that. Returns WEFT_ERR_ARGUMENT.
enum weft_result weft_separable_check_run(const weft_separable_plan *plan,
                                          const struct weft_separable_run_params *params,
                                          struct weft_separable_run_params *out);

// Its samples and window alone, likewise.
enum weft_result weft_separable_check_samples(const weft_separable_plan *plan,
                                              struct weft_separable_run_params *params);

// By the run's survey, or a look at the samples in reach.
struct weft_separable_care weft_separable_take_care(const weft_separable_plan *plan,
                                                    const struct weft_separable_run_params *params);

// Where a pixel is written, and which of the window's samples one is. The run is checked.
static inline float *weft_separable_pixel(const struct weft_separable_run_params *params, int x,
                                          int y)
{
    return params->pixels + (y - params->part.y) * params->stride + (x - params->part.x);
}

static inline size_t weft_separable_sample(const struct weft_separable_run_params *params, int x,
                                           int y)
{
    const struct weft_rectangle *window = &params->window;
    return (size_t)(y - window->y) * (size_t)window->width + (size_t)(x - window->x);
}
// Scales a rectangle of pixels back, and makes those samples, bit by bit, that are samples.
void weft_separable_finish(const struct weft_separable_care *care, const weft_separable_plan *plan,
                           const struct weft_separable_run_params *params, const int from[2],
                           const int size[2]);

static inline bool weft_separable_go_on(const struct weft_progress *progress, double fraction)
{
    return !progress || !progress->report || progress->report(progress->priv, fraction);
}

#endif
