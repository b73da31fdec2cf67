// SPDX-License-Identifier: BSD-3-Clause
// tests/passes/distribute/model.h - a model of frames that ranks divide (passes/distribute): what
// schedules come to with more processors than there are, from what regions take. It moves from one
// event to the next, as the ranks do: static ranks take their own items, pulling ones ask rank 0,
// which also takes results between its own items; a rank with `room` results that are not taken
// waits; frames end for all when rank 0 has taken everything. Processors are alike.
#ifndef WEFT_TESTS_PASSES_DISTRIBUTE_MODEL_H
#define WEFT_TESTS_PASSES_DISTRIBUTE_MODEL_H

#include "passes/distribute/schedule/load.h"
#include "passes/distribute/schedule/schedule.h"

// Seconds and bytes of all but the items. All 0: communication costs nothing.
struct model_machine {
    double latency;      // of a message, from call to call
    double byte_seconds; // of a byte on its way
    double ahead;        // ranks whose last item took less ask for the next one as they begin one
    double answer;       // that rank 0 is kept by a message that it answers, one after the other
    double take;         // of rank 0, for a result
    double take_byte;    // and for each byte of it
    double start;        // before the first frame
    double frame;        // between frames, of all ranks: what is shared, what one rank does alone
    int room;            // results of a rank that may wait (default 64)
};

struct model {
    int processors, frames;
    enum weft_schedule schedule;       // not auto
    bool one_work;                     // no barrier between frames: items of all frames are one
                                       // work, in their order (not of dynamic schedules)
    struct weft_regions_params params; // of the regions; `ranks` 0: processors
    double keep;                       // of dynamic schedules
    double bytes;                      // of a pixel of a result
    // Seconds that a region of a frame takes.
    double (*cost)(const void *priv, int frame, const struct weft_rectangle *region);
    const void *priv;
    struct model_machine machine;
};

struct model_result {
    struct weft_load load; // freed by weft_load_clear; works only, without start and frame
    double completion;     // with them
    double work;           // seconds of all items together
    double idle_share, imbalance;
    double largest; // dearest item
    double bound;   // sum over works: mean + (1 - 1/P) dearest (list scheduling)
    double lower;   // sum over works: the larger of mean and dearest
    int64_t items;  // of the last work
};
// false: no memory, or a size that is none.
bool model_run(const struct model *model, struct model_result *out);

// Costs that were measured: of each frame seconds in a grid of equal cells, of which `fixed` was no
// part of what lies in the cell. A region costs `fixed` and what of the rest its area has.
struct model_grid {
    int32_t width, height; // of the picture
    int columns, rows, frames;
    double fixed;
    double *seconds; // [frames][rows][columns]
};
double model_grid_cost(const void *grid, int frame, const struct weft_rectangle *region);

#endif
