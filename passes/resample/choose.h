// SPDX-License-Identifier: BSD-3-Clause
// passes/resample/choose.h - the cheapest passes of a resampling that meet an error budget, or the
// engine and sums that do without passes. Techniques, samples and bits of tiles, and engines and
// sums, are candidates of the same search as methods of slices are
// (passes/choose/choose.h); bounds are weft_bound_compute's, and costs are predicted by a model of
// the machine (passes/choose/cost.h).
#ifndef WEFT_PASSES_RESAMPLE_CHOOSE_H
#define WEFT_PASSES_RESAMPLE_CHOOSE_H

#include "../choose/candidate.h"
#include "../choose/cost.h"
#include "resample.h"

WEFT_BEGIN_DECLS

// What is chosen for. Borrowed until the call returns, the log of `passes` for the plan's life.
struct weft_resample_choose_params {
    // What the passes have in common, and where the search starts (required). channels: 1 or 4.
    struct weft_pass_plan_params passes;
    // What is searched for, past what `passes` says: the technique, M, and bits of unorm targets.
    bool any_technique, any_samples, any_bits;
    // The sources that are to be filtered by them, each by itself, of one size (required).
    const weft_resample_source *const *sources;
    const double *max_error; // [source_count], in each one's values, > 0
    size_t source_count;
    int width, height;                   // pixels of each result
    const struct weft_cost_model *model; // default (NULL): weft_cost_default
    const struct weft_log *log;          // may be NULL
};
#define WEFT_RESAMPLE_CHOOSE_DEFAULTS
#define weft_resample_choose_params(...)                                                           \
    (&(struct weft_resample_choose_params){WEFT_RESAMPLE_CHOOSE_DEFAULTS __VA_ARGS__})

// What is chosen for without passes: what runs a separable plan, and in which sums. Borrowed until
// the call returns, the plan's log for its life.
struct weft_resample_engine_params {
    struct weft_resample_params plan; // required, without passes; engine and sums are chosen
    // The sources that are to be filtered, each by itself, of one size (default: one, of any).
    const weft_resample_source *const *sources;
    const double *max_error; // [source_count], in each one's values, >= 0; NULL (default): any
                             // error that float sums make
    size_t source_count;
    unsigned engines;                    // as in struct weft_choose_params
    int threads;                         // likewise
    const struct weft_cost_model *model; // default (NULL): weft_cost_default
    const struct weft_log *log;          // may be NULL
};
#define WEFT_RESAMPLE_ENGINE_DEFAULTS
#define weft_resample_engine_params(...)                                                           \
    (&(struct weft_resample_engine_params){WEFT_RESAMPLE_ENGINE_DEFAULTS __VA_ARGS__})

// What was chosen. weft_resample_choice_clear frees it. Thread-safety: read-only use from any
// thread.
struct weft_resample_choice {
    // By predicted time of all sources, refused ones last. Bounds of passes are to the width of a
    // source's range, of the one of whose max_error the bound takes the largest part; others are
    // that part.
    struct weft_candidate *candidates;
    size_t count;
    int chosen;       // -1: none meets the budget
    int best;         // planned, of the least bound; -1: the profile has no passes for the kernel
    double max_error; // of passes the least that a source allows, to its range's width; else 1
    // The chosen one's; whoever keeps it sets this to NULL.
    weft_pass_plan *plan;
    weft_resample_plan *separable;
    int planned; // plans that were made to choose
};

// Chooses. Returns WEFT_OK with chosen = -1 where nothing meets the budget; WEFT_ERR_ARGUMENT
// (sources, errors), WEFT_ERR_MEMORY or WEFT_ERR_CANCELLED; *out then holds nothing.
WEFT_API enum weft_result weft_resample_choose(const struct weft_resample_choose_params *params,
                                               struct weft_resample_choice *out);
// Chooses likewise without passes: plans each engine in each sums, and takes the one of which the
// least time is predicted of those that are within. Without budgets, which none is beyond, that is
// the faster engine. Returns moreover what weft_resample_plan_create does.
WEFT_API enum weft_result
weft_resample_choose_engine(const struct weft_resample_engine_params *params,
                            struct weft_resample_choice *out);
WEFT_API void weft_resample_choice_clear(struct weft_resample_choice *choice); // {0} is fine

WEFT_END_DECLS
#endif
