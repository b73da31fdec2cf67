// SPDX-License-Identifier: BSD-3-Clause
// passes/resample/resample_impl.h - what the files of passes/resample share (not installed).
#ifndef WEFT_PASSES_RESAMPLE_RESAMPLE_IMPL_H
#define WEFT_PASSES_RESAMPLE_RESAMPLE_IMPL_H

#include "filter/check.h"
#include "passes/resample/resample.h"
#include "passes/separable/separable.h"

struct weft_resample_plan {
    struct weft_resample_info info;
    const weft_pass_plan *passes;
    uint64_t memory_bytes;
    const struct weft_log *log;
    int side[2], count[2]; // of the tiles of passes: pixels, and how many along each axis
    double *at[2];         // separable: where columns and rows lie, in the values that are read
    weft_separable_plan *separable;
    char words[768]; // info.text of separable plans
};

struct weft_resample_source {
    struct weft_resample_source_info info;
    const float *plane[WEFT_RESAMPLE_MAX_CHANNELS]; // the window's samples
    int64_t stride;
    struct weft_statistics samples; // with differences where they were given
    bool has_differences;
    // What is read in their place, tightly packed: coefficients, with `overlap` more of them on
    // every side, or samples whose rows lay apart; NULL where planes themselves are read.
    float *own[WEFT_RESAMPLE_MAX_CHANNELS];
    int overlap;
    float *texels; // planes that were read from a texture; else NULL
};

struct weft_resample_compiled {
    const weft_resample_plan *plan;
    weft_context *context;
    weft_multipass *passes;    // of a plan of passes
    weft_separable *separable; // of others
    int threads;               // that clamp; 0: one a processor
    struct weft_resample_compiled_info info;
};

// The values that are there, among those that are read of the whole image: samples, or coefficients
// with an overlap; and those of a channel, tightly packed.
static inline struct weft_rectangle weft_resample_values_window(const weft_resample_source *source)
{
    const struct weft_rectangle *w = &source->info.window;
    const int more = 2 * source->overlap;
    return (struct weft_rectangle){w->x, w->y, w->width + more, w->height + more};
}

static inline const float *weft_resample_values(const weft_resample_source *source, int c)
{
    return source->own[c] ? source->own[c] : source->plane[c];
}

// Whether a source is of a plan's size and kernel. Returns WEFT_ERR_ARGUMENT.
enum weft_result weft_resample_check_source(const struct weft_log *log,
                                            const weft_resample_plan *plan,
                                            const weft_resample_source *source);
// Whether it, a part, planes (NULL: none are needed) and a stride suit a plan; part and stride get
// their defaults. Returns WEFT_ERR_ARGUMENT.
enum weft_result weft_resample_check_request(const struct weft_log *log,
                                             const weft_resample_plan *plan,
                                             const weft_resample_source *source,
                                             struct weft_rectangle *part, const float *const *plane,
                                             int64_t *stride);
// Whether a window has what a part's pixels reach. Returns WEFT_ERR_ARGUMENT.
enum weft_result weft_resample_check_reach(const struct weft_log *log,
                                           const weft_resample_plan *plan,
                                           const struct weft_rectangle *part,
                                           const struct weft_rectangle *window);

// Whether integers, a part (NULL: all), pixels and a stride suit a plan. *integers gets its window
// and stride, *out the part, *stride its default. Returns WEFT_ERR_ARGUMENT.
enum weft_result weft_resample_check_move(const weft_resample_plan *plan,
                                          struct weft_resample_integers *integers,
                                          const struct weft_rectangle *part, const uint32_t *pixels,
                                          int64_t *stride, struct weft_rectangle *out);

// From the first to the last sample next to `count` pixels of an axis, from number `first` on.
void weft_resample_next_reach(const weft_resample_plan *plan, int axis, int first, int count,
                              int reach[2]);
// Holds a run's pixels between the samples next to them. Returns WEFT_ERR_MEMORY.
enum weft_result weft_resample_clamp(const weft_resample_plan *plan,
                                     const struct weft_resample_run_params *params, int threads);

// Cuts a plan of passes into tiles, by its sizes alone, and checks what the largest takes. Returns
// WEFT_ERR_LIMIT.
enum weft_result weft_resample_plan_tiles(weft_resample_plan *plan);

// What terms of any plan add up to for a source.
struct weft_bound weft_resample_bound_of(const struct weft_bound_terms *terms,
                                         const struct weft_resample_statistics *statistics,
                                         double result);

// A request's progress, as that of one of its steps.
struct weft_resample_steps {
    const struct weft_progress *outer;
    double step, steps;
};
// For struct weft_progress: priv is struct weft_resample_steps.
bool weft_resample_report_step(void *priv, double fraction);

// Adds what filtering along one axis and then the other did.
void weft_resample_add_separable(const weft_separable_plan *plan,
                                 const struct weft_separable_report *one,
                                 struct weft_resample_work *sum);
// What was measured of all samples, where it says that nothing need be done about them: samples in
// reach then need no look. true: *out holds.
bool weft_resample_knows_survey(const weft_resample_source *source,
                                struct weft_separable_survey *out);

// The engines. The request is checked.
enum weft_result weft_resample_run_passes(weft_resample_compiled *compiled,
                                          const struct weft_resample_run_params *params,
                                          struct weft_resample_work *work);
// Adds to the pixels' statistics, too.
enum weft_result weft_resample_run_separable(weft_resample_compiled *compiled,
                                             const struct weft_resample_run_params *params,
                                             struct weft_resample_report *report);

#endif
