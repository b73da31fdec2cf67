// SPDX-License-Identifier: BSD-3-Clause
// passes/choose/cost.h - what methods cost on this machine: a model of a few times that a
// calibration measures, and predictions by it. Times are nanoseconds of wall clock with whatever
// threads the context uses.
#ifndef WEFT_PASSES_CHOOSE_COST_H
#define WEFT_PASSES_CHOOSE_COST_H

#include "method.h"

WEFT_BEGIN_DECLS

enum { WEFT_COST_ENGINES = 3, WEFT_COST_LAYOUTS = 3, WEFT_COST_TARGETS = 4 };

struct weft_cost_model {
    char renderer[128];              // that it was measured on; "" in the defaults
    double start[WEFT_COST_ENGINES]; // [enum weft_engine]: of a run, whatever its size
    double voxel;                    // read, of bricks
    // Fused, per pixel of the slice: finding its cell; position, store and reading back; a vector
    // of four weights' coefficients, that are uniform or fetched; a fetch of the source.
    double entry, pixel, weights, weights_fetched;
    double fetch[WEFT_COST_LAYOUTS][4]; // [layout less 1][enum weft_source_format]
    double texel[WEFT_COST_LAYOUTS][4]; // laid out, likewise
    // Separable: a voxel summed before, a tap of either pass, and each pixel of the result.
    double summed, tap, separable_pixel;
    // Passes: each pixel of the result, whatever the plan; a weight of the exact sum that a pixel's
    // result is corrected by, where weights do not add up to one. By enum weft_target_format: a
    // pixel of a pass; and by plain or dot4 moreover: a fetch of it, a sample mapped and laid out,
    // a byte of tiles made and uploaded. A fetch takes pass_far more of that for each doubling of
    // the tiles past WEFT_COST_NEAR_BYTES, which a core's cache holds.
    double pass_pixel, pass_weight, pass_far;
    double pass[WEFT_COST_TARGETS], pass_fetch[WEFT_COST_TARGETS][2];
    double pass_sample[WEFT_COST_TARGETS][2], tile_byte[WEFT_COST_TARGETS][2];
};
enum { WEFT_COST_NEAR_BYTES = 1 << 20 };

// Of a software GL on two cores.
WEFT_API extern const struct weft_cost_model weft_cost_default;

// Measures for some seconds. Returns WEFT_ERR_CANCELLED, WEFT_ERR_GL or WEFT_ERR_MEMORY.
WEFT_API enum weft_result weft_cost_calibrate(const struct weft_log *log, weft_context *context,
                                              const struct weft_progress *progress,
                                              struct weft_cost_model *out);

// Text, one "name value ..." a line. Returns WEFT_ERR_FORMAT (what is wrong with it is in the log).
WEFT_API enum weft_result weft_cost_parse(const struct weft_log *log, const char *text,
                                          struct weft_cost_model *out);
// To be freed; NULL where memory ran out.
WEFT_API char *weft_cost_format(const struct weft_cost_model *model);

// Weighs work: of a plan (struct weft_method_plan_info), or of what one would do. Returns seconds
// of a run; NAN for values that an enum does not have.
WEFT_API double weft_cost_of(const struct weft_cost_model *model, const struct weft_work *work);

WEFT_END_DECLS
#endif
