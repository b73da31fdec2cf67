// SPDX-License-Identifier: BSD-3-Clause
// passes/plan/plan.h - plans: which passes reconstruct with a kernel on a target of limited
// precision, in which order, at what cost and with what error. Pure C, no GL. Source: Hadwiger,
// Hauser and Moeller, "Quality Issues of Hardware-Accelerated High-Quality Filtering on PC Graphics
// Hardware", WSCG 2003, sections 2 to 6.
#ifndef WEFT_PASSES_PLAN_PLAN_H
#define WEFT_PASSES_PLAN_PLAN_H

#include "../../filter/analysis/bound.h"
#include "pass.h"
#include "range.h"
#include "tile_name.h"

WEFT_BEGIN_DECLS

// How taps become passes. Default: plain. A profile need not have the means for each: see
// weft_pass_plan_create.
enum weft_technique {
    WEFT_TECHNIQUE_PLAIN,           // a tap per fetch
    WEFT_TECHNIQUE_DOT4,            // four taps per fetch (section 6); single-valued sources
    WEFT_TECHNIQUE_SPLIT_PRECISION, // 2N + 1 passes keep bits that the target cannot (section 3.1)
    WEFT_TECHNIQUE_HIERARCHICAL,    // scaled groups in targets of their own (section 3.2)
    WEFT_TECHNIQUE_LOG,             // sums of logarithms for products (section 3.3)
};
// NULL-ended, in the order of the enum: "plain", "dot4", "split-precision", "hierarchical", "log".
WEFT_API extern const char *const weft_technique_names[];

// Which tap comes when. Default: planned.
enum weft_order {
    // Searched for, so that no store clamps in the declared worst case; where roundings take sums
    // beyond their range, it is scaled to leave them a margin. Not allowed to scale, it tells by
    // how
    // much roundings can clamp: see `valid`.
    WEFT_ORDER_PLANNED,
    WEFT_ORDER_GREEDY,  // the first tile that fits comes next, as long as one does: the baseline
    WEFT_ORDER_NATURAL, // tap by tap, as naive code would: may clamp
    WEFT_ORDER_GIVEN,   // `tile_order`: may clamp
};
// NULL-ended, in the order of the enum: "planned", "greedy", "natural", "given".
WEFT_API extern const char *const weft_order_names[];

// One split of a tile in two, so that an order is found that keeps the range (section 4).
struct weft_pass_plan_split {
    struct weft_tile_name tile; // keeps weights >= threshold; the rest is its tap's next piece
    double threshold;           // NAN: the middle of the weights' range
};

// Defaults of the parameters below, as numbers that a help text can be put together from.
#define WEFT_PASS_PLAN_SAMPLES_2D 64
#define WEFT_PASS_PLAN_SAMPLES_3D 32
#define WEFT_PASS_PLAN_BITS 8     // of tiles for 8-bit targets
#define WEFT_PASS_PLAN_BITS_16 12 // for 16-bit targets; products there must fit into 32 bits
#define WEFT_PASS_PLAN_BITS_16_HIERARCHICAL 11
#define WEFT_PASS_PLAN_BITS_16_SPLIT 10
#define WEFT_PASS_PLAN_MOST_BITS_16 14 // the most that 16-bit targets take

// What is to be planned. All zero asks for the defaults: 2D Catmull-Rom on 8-bit targets.
struct weft_pass_plan_params {
    struct weft_kernel kernel; // default (info NULL): catmull-rom
    int dims;                  // 2 or 3 (default 2)
    // What is reconstructed: default the value, else a derivative along axes up to dims
    struct weft_derivative derivative;
    struct weft_profile profile; // default (name empty): unorm8
    int taps_per_pass;           // pairs of textures, at most the profile's (default: as many)
    int samples;                 // M (default 64, in 3D 32)
    // Of tiles of unorm targets, 4 to 16 (16-bit targets: to 14, as products have 32 bits)
    // (default 8, there 12, hierarchical 11, split precision 10). Half targets have half tiles,
    // float targets float ones.
    int bits;
    enum weft_technique technique;
    enum weft_worst_case worst_case;
    enum weft_order order;
    // Each weight by itself: weights at a position may add up to more than 1 then, where no order
    // helps, and constants ripple (default: rounded so that sums are exact, where tiles share a
    // scale).
    bool round_singly;
    bool single_bias;      // the whole bias comes with the first pass, as naive code would have it
    bool no_splits;        // tiles may not be split where no order is found
    bool no_scale;         // nor may the target's range be scaled
    bool blend_only;       // as if the profile had no ping-pong
    int channels;          // 1, or 4 of an image together (not with dot4) (default 1)
    uint64_t memory_bytes; // of tiles (default 1 GiB)
    // Of WEFT_ORDER_GIVEN: every tile once, but those that are 0 everywhere; neighbours of one sign
    // share passes, up to taps_per_pass. Not with dot4 or hierarchical.
    const struct weft_tile_name *tile_order;
    size_t tile_order_count;
    const struct weft_pass_plan_split *splits; // made first, in order
    size_t split_count;
    const struct weft_progress *progress; // asked now and then, its fraction stays 0; may be NULL
    const struct weft_log *log;           // borrowed for the plan's life
};
#define WEFT_PASS_PLAN_DEFAULTS
#define weft_pass_plan_params(...)                                                                 \
    (&(struct weft_pass_plan_params){WEFT_PASS_PLAN_DEFAULTS __VA_ARGS__})

// Bounds of |result - exact|, for a source mapped to [0, 1]. Between sample positions radial
// kernels are looked at in the corners of cells only. E1, the kernel's own error, is
// filter/analysis/error.h's.
struct weft_pass_plan_error {
    double source; // the source's own codes
    double e2;     // the kernel's representation: quantised weights, nearest sample position
    double e3;     // arithmetic: products, sums and stores
    double clamp;  // what the worst input can lose to clamping
    // source + e2 + e3, for inputs as the worst case says (constant: of any level); with what they
    // lose to clamping where the plan is not valid.
    double bound;
    double bound_any; // with clamp: for any input in range
    // Another bound of e2 for prefiltered kernels, whose coefficients' range is up to gain^dims
    // times the samples': e2_quantised of the coefficients' range and e2_sampled of the samples',
    // since nearest positions are off by a cardinal spline's slope. NAN for others.
    double e2_quantised, e2_sampled;
};

// What a plan is: the parameters with their defaults filled in, the passes, and what they cost. All
// that it points to belongs to the plan.
struct weft_pass_plan_info {
    struct weft_kernel kernel;
    struct weft_profile profile;
    struct weft_derivative derivative;
    int dims, samples, bits, channels;
    enum weft_technique technique;
    enum weft_worst_case worst_case;
    enum weft_order order;
    // No store clamps in the worst case, by the simulator: constants of all levels, or any input.
    // Else stores clamp by up to range.overflow; the bounds know.
    bool valid;
    struct weft_range_report range;
    const struct weft_range *ranges;     // of each pass, [passes->pass_count]
    const struct weft_pass_list *passes; // what is to be run
    int tap_count;                       // width^dims
    int tile_count;                      // tiles, parts and pieces included
    int split_count;                     // splits that the planner (or the caller) made
    // How the tile set was made: with these, then split tile by tile.
    struct weft_kernel_tiles_params tile_params;
    const struct weft_pass_plan_split *tile_splits;
    int tile_split_count;
    int fetches;         // per pixel and channel set, of source and tiles and targets, all passes
    int kept_bits;       // of sums: the target's, more with split precision
    double scale_bits;   // precision that scaling costs: log2(1 / result_scale)
    uint64_t tile_bytes; // of tile textures
    uint64_t target_bytes_per_pixel; // of all targets that are alive at once, and scratch ones
    struct weft_pass_plan_error error;
    // The terms of |result - exact| that weft_bound_compute adds up in a source's own values, for
    // any input in their range.
    struct weft_bound_terms bound;
    double search_seconds; // that planning took
    const char *text;      // the plan as --explain prints it, one line per pass
};

typedef struct weft_pass_plan weft_pass_plan; // Thread-safety: read-only once made.

// Plans passes in which no store clamps in the declared worst case, or says what clamps. Takes from
// milliseconds to seconds, without GL. *out is NULL where it fails.
// Returns WEFT_ERR_ARGUMENT, WEFT_ERR_UNSUPPORTED (no order keeps the range: the log says where and
// by how much; a technique that the profile has no means for; log with signed data), WEFT_ERR_LIMIT
// (memory, or sums that 32 bits do not hold), WEFT_ERR_MEMORY or WEFT_ERR_CANCELLED. Natural and
// given orders that clamp are plans too, and so are planned ones that may not scale and clamp by no
// more than roundings add up to: see `valid`.
WEFT_API enum weft_result weft_pass_plan_create(const struct weft_pass_plan_params *params,
                                                weft_pass_plan **out);
// Judges passes that are there already, from a file or by hand: its tiles are made anew from the
// parameters
// (`splits` included; `order` is a word only), its ranges, figures and bounds from tiles and
// passes. Of the list slots, result, scale and bias of the result, pattern and, with split
// precision, the extra bits count; the rest follows from profile and technique. The bounds are
// right if the passes count each tile once, at the list's scale. Returns what weft_pass_plan_create
// does, and WEFT_ERR_ARGUMENT for passes that the technique does not have.
WEFT_API enum weft_result weft_pass_plan_judge(const struct weft_pass_plan_params *params,
                                               const struct weft_pass_list *passes,
                                               weft_pass_plan **out);
WEFT_API void weft_pass_plan_destroy(weft_pass_plan **plan); // accepts &NULL, leaves NULL behind
// Lives as long as the plan.
WEFT_API const struct weft_pass_plan_info *weft_pass_plan_get_info(const weft_pass_plan *plan);

WEFT_END_DECLS
#endif
