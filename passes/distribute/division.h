// SPDX-License-Identifier: BSD-3-Clause
// passes/distribute/division.h - a picture that ranks divide, frame after frame: its regions, and
// what they learn from the frame before.
//
//     for each frame:
//         regions = weft_division_regions(division)
//         weft_ranks_do_items(ranks, {.count = weft_regions_count(regions),
//             .cost = weft_division_costs(division), .schedule = ..., ...}, &report)
//         weft_division_learn(division, &report)
#ifndef WEFT_PASSES_DISTRIBUTE_DIVISION_H
#define WEFT_PASSES_DISTRIBUTE_DIVISION_H

#include "items.h"
#include "schedule/cost_map.h"

WEFT_BEGIN_DECLS

struct weft_division_params {
    struct weft_regions_params regions; // `ranks` 0: as many as there are
    enum weft_schedule schedule;        // of the works that will be done (default auto)
    // Of dynamic schedules: weft_regions_balance's (0 to < 1, default 0.5).
    double keep;
    // What the picture cost before, on rank 0; on others it is not looked at. Borrowed while the
    // division lives; what is learnt is added to it. NULL (default): nothing is known, or kept.
    weft_cost_map *map;
};
#define WEFT_DIVISION_DEFAULTS .keep = 0.5,
#define weft_division_params(...)                                                                  \
    (&(struct weft_division_params){WEFT_DIVISION_DEFAULTS __VA_ARGS__})

// The same on all ranks. Thread-safety: the thread that body is called in. The ranks outlive it.
typedef struct weft_division weft_division;

// Divides the picture: of a dynamic schedule with a map by what it tells. Collective. Returns
// WEFT_ERR_ARGUMENT and as weft_regions_create, on all ranks alike; *out is then NULL.
WEFT_API enum weft_result weft_division_create(weft_ranks *ranks,
                                               const struct weft_division_params *params,
                                               weft_division **out);
WEFT_API void weft_division_destroy(weft_division **division); // accepts &NULL, leaves NULL behind

// Borrowed until the division learns or is destroyed.
WEFT_API const weft_regions *weft_division_regions(const weft_division *division);
// What regions are expected to cost, for weft_items.cost: seconds of the frame before, or by the
// map. NULL: nothing is known, or the schedule has no use for it.
WEFT_API const double *weft_division_costs(const weft_division *division);

// Learns from a work of these regions that ended well: moves boundaries of dynamic schedules, keeps
// costs of pull ones, and adds rank 0's seconds to the map. Collective. Returns WEFT_ERR_MEMORY, or
// WEFT_ERR_ARGUMENT (seconds that are none), on
// all ranks alike.
WEFT_API enum weft_result weft_division_learn(weft_division *division,
                                              const struct weft_items_report *report);

WEFT_END_DECLS
#endif
