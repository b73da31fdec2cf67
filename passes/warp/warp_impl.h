// SPDX-License-Identifier: BSD-3-Clause
// passes/warp/warp_impl.h - what the files of passes/warp share (not installed).
#ifndef WEFT_PASSES_WARP_WARP_IMPL_H
#define WEFT_PASSES_WARP_WARP_IMPL_H

#include "passes/positions/weights.h"
#include "passes/resample/resample_impl.h"
#include "passes/separable/separable.h"
#include "passes/warp/warp.h"

struct weft_warp_plan {
    struct weft_warp_info info;
    struct weft_warp_map map;
    uint64_t memory_bytes;
    const struct weft_log *log;
    double gain;    // largest sum of |weights| of a pixel's taps, and 1 at least
    bool stretches; // a scale is above 1 somewhere
    // Values that are read: samples, or coefficients with the overlap on every side.
    int values[2];
    struct weft_kernel plain; // the kernel, not prefiltered
    struct weft_kernel_facts *facts;
    const struct weft_slice_weights *weights; // as good as the sums
    weft_separable_plan *separable;           // of aligned maps, which have no weights here
    char words[1024];
};

// ---- positions ----------------------------------------------------------------------------------

enum { WEFT_WARP_ROW = 64 }; // pixels of a row that are worked on together

// Where pixels of a row lie, among the values that are read.
struct weft_warp_row {
    double at[2][WEFT_WARP_ROW];
    double scale[2][WEFT_WARP_ROW]; // of plans that stretch
    // Of plans that do not: the first tap, brought so near to the values that taps between are the
    // same ones, and the fraction.
    int32_t first[2][WEFT_WARP_ROW];
    double fraction[2][WEFT_WARP_ROW];
};
// Pixels x to x + count - 1 of row y.
void weft_warp_row_set(const struct weft_warp_plan *plan, int x, int y, int count,
                       struct weft_warp_row *row);

// A first tap so near to the values that all its taps are what they were, by the boundary.
int32_t weft_warp_reduce(const struct weft_warp_plan *plan, int axis, int64_t first, int taps);

// ---- stretched kernels --------------------------------------------------------------------------

// Writes the weights at a position and a scale, those of weft_stretch_weights to within rounding:
// at most info.taps of them. Returns how many; the first tap goes to *first.
int weft_warp_weights(const struct weft_warp_plan *plan, double at, double scale, int64_t *first,
                      double *weights);

// ---- plans --------------------------------------------------------------------------------------

// Inverts the map's matrix. Returns WEFT_ERR_ARGUMENT.
enum weft_result weft_warp_set_matrix(struct weft_warp_plan *plan);
// Looks at all positions. Returns WEFT_ERR_ARGUMENT.
enum weft_result weft_warp_set_positions(struct weft_warp_plan *plan);
// Finds the terms of the bound. Returns WEFT_ERR_MEMORY.
enum weft_result weft_warp_set_bound(struct weft_warp_plan *plan);
// By how many bits samples must be smaller so that sums stay within the range of floats; 0: none.
int weft_warp_scale_bits(const struct weft_warp_plan *plan,
                         const struct weft_resample_statistics *statistics);
void weft_warp_set_text(struct weft_warp_plan *plan);

// ---- requests -----------------------------------------------------------------------------------

// Whether a source, a part, planes and a stride suit a plan; part and stride get their defaults.
// Returns WEFT_ERR_ARGUMENT.
enum weft_result weft_warp_check(const struct weft_warp_plan *plan,
                                 const weft_resample_source *source, struct weft_rectangle *part,
                                 const float *const *plane, int64_t *stride,
                                 const struct weft_log *log);

// ---- engines ------------------------------------------------------------------------------------

struct weft_warp_cpu;
struct weft_warp_gl;

struct weft_warp_compiled {
    const struct weft_warp_plan *plan;
    // One of them.
    weft_separable *separable; // of aligned maps
    struct weft_warp_cpu *cpu;
    struct weft_warp_gl *gl;
    int threads; // beside the engine's own
};

// Plans what follows the axes: taps, bound and the filtering along each. Returns what
// weft_separable_plan_create does.
enum weft_result weft_warp_aligned_plan(struct weft_warp_plan *plan);
enum weft_result weft_warp_aligned_run(const struct weft_warp_compiled *compiled,
                                       const struct weft_warp_run_params *params,
                                       struct weft_resample_report *report);

enum weft_result weft_warp_cpu_compile(const struct weft_warp_plan *plan,
                                       const struct weft_cpu *cpu, struct weft_warp_cpu **out);
void weft_warp_cpu_destroy(struct weft_warp_cpu **compiled); // accepts &NULL
// The request is checked, with its defaults filled in.
enum weft_result weft_warp_cpu_run(struct weft_warp_cpu *compiled,
                                   const struct weft_warp_run_params *params,
                                   struct weft_resample_report *report);

enum weft_result weft_warp_gl_compile(weft_context *context, const struct weft_warp_plan *plan,
                                      struct weft_warp_gl **out);
void weft_warp_gl_destroy(struct weft_warp_gl **compiled); // accepts &NULL
enum weft_result weft_warp_gl_run(struct weft_warp_gl *compiled,
                                  const struct weft_warp_run_params *params,
                                  struct weft_resample_report *report);

static inline bool weft_warp_go_on(const struct weft_progress *progress, double fraction)
{
    return !progress || !progress->report || progress->report(progress->priv, fraction);
}

#endif
