// SPDX-License-Identifier: BSD-3-Clause
// passes/choose/cost.h - what methods cost on this machine: a model of a few times that a
// calibration measures, and predictions by it. Times are nanoseconds of wall clock: of OpenGL with
// whatever threads the context uses, of the CPU engine with those that it was measured with.
#ifndef WEFT_PASSES_CHOOSE_COST_H
#define WEFT_PASSES_CHOOSE_COST_H

#include "method.h"

WEFT_BEGIN_DECLS

enum {
    WEFT_COST_ALGORITHMS = 4,
    WEFT_COST_LAYOUTS = 3,
    WEFT_COST_TARGETS = 4,
    WEFT_COST_SUMS = 2,
    WEFT_COST_WIDTHS = 4
};

// A machine's times, each in nanoseconds for one of what it names. A plain value that owns nothing.
struct weft_cost_model {
    // GL's name of where they were measured; "": nowhere, and what is below for OpenGL are
    // defaults.
    char renderer[128];
    // Likewise of the CPU engine; auto and 0: nowhere, and what is below for it are defaults.
    enum weft_instruction_set instructions;
    int threads;
    double start[WEFT_COST_ALGORITHMS]; // [enum weft_algorithm]: of a run on OpenGL, of any size
    double voxel;                       // that is read from a brick, on either engine
    // The fused algorithm takes for each pixel: `entry` to find its cell; `pixel` for position,
    // store and reading back; `weights` for four of its weights' coefficients where they are
    // uniform, `weights_fetched` where they come from a texture; and `fetch` for each fetch of the
    // source.
    double entry, pixel, weights, weights_fetched;
    double fetch[WEFT_COST_LAYOUTS][4]; // [layout less 1][enum weft_source_format]
    double texel[WEFT_COST_LAYOUTS][4]; // that is laid out and uploaded, likewise
    // Hardware takes what the fused one does for each pixel, but for fetches, which are filtered,
    // and texels. By enum weft_source_format.
    double hardware_fetch[4], hardware_texel[4];
    // The separable algorithm: a voxel that is summed along an axis before, a tap of either pass,
    // and a pixel of the result.
    double summed, tap, separable_pixel;
    // Passes: `pass_pixel` for each pixel of the result, whatever the plan; `pass_weight` for each
    // weight of the exact sum that corrects a pixel where weights do not add up to one. By enum
    // weft_target_format: `pass` for a pixel of a pass. By that and by [0] plain, [1] dot4: a
    // fetch, a sample that is mapped and laid out, a byte of tiles that is made and uploaded. Tiles
    // of more than WEFT_COST_NEAR_BYTES leave a core's cache: a fetch takes `pass_far` times more
    // for each doubling past that.
    double pass_pixel, pass_weight, pass_far;
    double pass[WEFT_COST_TARGETS], pass_fetch[WEFT_COST_TARGETS][2];
    double pass_sample[WEFT_COST_TARGETS][2], tile_byte[WEFT_COST_TARGETS][2];
    // The CPU engine, all by enum weft_sums. A run of any size, fused and separable. The fused
    // algorithm: a sample that is laid out, `cpu_pixel` for each pixel, and `cpu_row` for each row
    // of its taps, by [0] 2, [1] 4, [2] 6 and [3] 8 taps of the row. The separable one: a voxel
    // that is summed along an axis before, and a tap along either axis, by the kernel's taps
    // likewise.
    double cpu_fused_start[WEFT_COST_SUMS], cpu_separable_start[WEFT_COST_SUMS];
    double cpu_sample[WEFT_COST_SUMS], cpu_pixel[WEFT_COST_SUMS];
    double cpu_row[WEFT_COST_SUMS][WEFT_COST_WIDTHS];
    double cpu_summed[WEFT_COST_SUMS];
    double cpu_separable_tap[WEFT_COST_SUMS][WEFT_COST_WIDTHS];
};
enum { WEFT_COST_NEAR_BYTES = 1 << 20 };

// Times of a software GL (llvmpipe) and of AVX2 on two cores: what holds until a calibration is at
// hand.
WEFT_API extern const struct weft_cost_model weft_cost_default;

// Measures the times of a context and of the CPU engine with all cores, by running methods on
// volumes and plans of its own, which takes about 14 seconds on a software GL, and twice as long
// where that compiles programs for the first time; without a context (NULL) of the CPU engine
// alone, and those of OpenGL are the defaults. Other load on the machine makes all of them wrong.
// progress may be NULL. Returns WEFT_ERR_CANCELLED, WEFT_ERR_GL or WEFT_ERR_MEMORY.
WEFT_API enum weft_result weft_cost_calibrate(const struct weft_log *log, weft_context *context,
                                              const struct weft_progress *progress,
                                              struct weft_cost_model *out);

// Reads a model from text: the lines "weft-cost 2", "renderer NAME" and "cpu INSTRUCTIONS THREADS",
// then one "name value ..." for each member, in any order, values from 0 to 1e12. Returns
// WEFT_ERR_FORMAT where a line is wrong (the log has it) or missing, or the text is of another
// version; *out then holds no model.
WEFT_API enum weft_result weft_cost_parse(const struct weft_log *log, const char *text,
                                          struct weft_cost_model *out);
// Writes the text that weft_cost_parse reads, with six digits of each value. The caller frees it;
// NULL where memory ran out.
WEFT_API char *weft_cost_format(const struct weft_cost_model *model);

// Predicts the seconds that a run takes from its work: a plan's own (struct weft_method_plan_info),
// or an estimate of it. Of the CPU engine with other threads than were measured they are
// proportional to the number. Pure and thread-safe. Returns NAN where an enum has a value that it
// does not know, or threads are negative.
WEFT_API double weft_cost_of(const struct weft_cost_model *model, const struct weft_work *work);

WEFT_END_DECLS
#endif
