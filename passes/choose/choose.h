// SPDX-License-Identifier: BSD-3-Clause
// passes/choose/choose.h - the cheapest method of a slice that meets an error budget.
// The budget is for what weft adds to the kernel: representation (E2), arithmetic (E3) and the
// source's codes, all by proven bounds. E1, the kernel's own error, is told beside. Costs are
// predicted by a model of the machine (passes/choose/cost.h).
#ifndef WEFT_PASSES_CHOOSE_CHOOSE_H
#define WEFT_PASSES_CHOOSE_CHOOSE_H

#include "candidate.h"
#include "cost.h"

WEFT_BEGIN_DECLS

// What is to be chosen for. It is borrowed until the call returns, the log for the plan's life.
struct weft_choose_params {
    // The request: kernel, geometry (required), space, footprint, memory_bytes, without, limits of
    // the GL, clamp_to_samples, progress, log. Where `layout` is not AUTO, fused methods of that
    // layout alone are candidates. Leave engine, sums, source, lookup, samples, low, high and
    // smooth_error 0: the methods and the budget decide them.
    struct weft_slice_params slice;
    double max_error; // the budget, in the volume's values, >= 0 (default 0: exact methods alone)
    unsigned engines; // that candidates may run on, bits 1u << enum weft_engine (default 0: all)
    int threads;      // that the CPU engine will have (default 0: those that the model has)
    // Of what is to run it, by enum weft_source_format (default NULL: weft_sampler_assume).
    const struct weft_sampler *samplers;
    const struct weft_profile *profile;  // candidates are passes on this one (default NULL: all)
    const struct weft_cost_model *model; // that predicts times (default NULL: weft_cost_default)
};
#define WEFT_CHOOSE_DEFAULTS
#define weft_choose_params(...) (&(struct weft_choose_params){WEFT_CHOOSE_DEFAULTS __VA_ARGS__})

// What was chosen. weft_choice_clear frees it. Thread-safety: read-only use from any thread.

struct weft_choice {
    struct weft_candidate *candidates; // by predicted time, refused ones last
    size_t count;
    int chosen; // index of the chosen candidate; -1: none meets the budget
    int best;   // index of that with the least bound among those that are not estimated; -1: none
    struct weft_slice_statistics statistics; // of the voxels in reach, by which bounds were found
    // The plan of the chosen method, ready for weft_method_run; NULL where none was chosen. It is
    // the plan by which the method was chosen. Smooth pieces may take what of the budget the
    // method's own bound leaves, where the slice has pixels enough for that to pay.
    weft_method_plan *plan;
    int planned; // plans that were made to choose, for reports
};

// Chooses: reads the voxels in reach once for their statistics, lists candidates with the least
// time and bound that each can have, and plans the cheapest ones until one meets the budget. The
// log (debug level) has the reason of each refused candidate. The volume is borrowed for the life
// of the plan. Returns WEFT_OK with chosen = -1 where nothing meets the budget; WEFT_ERR_ARGUMENT
// (max_error, and what weft_slice_plan_create refuses), WEFT_ERR_MEMORY, WEFT_ERR_CANCELLED, and
// what weft_volume_read returns. On failure *out has no candidates and no plan.
WEFT_API enum weft_result weft_choose(weft_volume *volume, const struct weft_choose_params *params,
                                      struct weft_choice *out);
// Frees candidates and plan; whoever keeps the plan sets `plan` to NULL before. {0} is fine.
WEFT_API void weft_choice_clear(struct weft_choice *choice);

// Returns the engine that a model predicts to be faster with a planned slice: as it is planned, or
// on the other engine by floats with exact weights, in single precision. OpenGL where both are as
// fast. threads as above. Pure.
WEFT_API enum weft_engine weft_choose_engine(const struct weft_cost_model *model,
                                             const weft_slice_plan *plan, int threads);

WEFT_END_DECLS
#endif
