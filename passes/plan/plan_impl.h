// SPDX-License-Identifier: BSD-3-Clause
// passes/plan/plan_impl.h - inside the planner (not installed).
// Values of tiles are integers here: q of passes/plan/pass.h, and a target is full at `divisor`, so
// that what a search finds holds exactly.
#ifndef WEFT_PASSES_PLAN_PLAN_IMPL_H
#define WEFT_PASSES_PLAN_PLAN_IMPL_H

#include "filter/check.h"
#include "passes/plan/plan.h"

enum { WEFT_PASS_PLAN_ADDS = 1, WEFT_PASS_PLAN_SUBTRACTS = 2 };

// What is placed as a whole: the taps of one fetch, and which signs its weights have.
struct weft_pass_plan_item {
    struct weft_tap_group group;
    int signs;       // WEFT_PASS_PLAN_ADDS, WEFT_PASS_PLAN_SUBTRACTS or both
    int32_t largest; // of |value|
};

struct weft_pass_plan {
    struct weft_pass_plan_info info;
    struct weft_pass_list list;
    weft_kernel_tiles *tiles;
    struct weft_tap_group *groups;
    struct weft_pass *passes;
    struct weft_range *ranges;
    struct weft_pass_plan_split *splits; // of tiles
    int split_room;
    uint32_t *log_table;
    char *text;
};

struct weft_planner {
    struct weft_pass_plan_params p; // with defaults filled in
    struct weft_pass_plan *plan;
    int full;        // T; 1 for half and float
    bool real;       // a half or float target: no codes, nothing clamps
    bool logarithms; // values of tiles are entries of the log table
    bool derives;    // weights add up to about 0: the result is signed
    double unit;     // the weight that a value of 1 stands for
    int item_count, item_room;
    struct weft_pass_plan_item *items;
    int32_t divisor;         // where a target is full
    int32_t bias, bias_step; // of the result, in codes, and what each pass's is a multiple of
    struct weft_pass_plan_margin {
        int low, high;  // codes of every target that exact sums leave to roundings
        int leaf;       // of a hierarchy's groups, above
        int fewer_bits; // split precision: than low parts could have, exact sums
    } margin;
    double log_scale; // of the table's entries, without the margin
    int pass_room, group_room;
};

// Planning does not know how far it is; it only asks whether to go on.
static inline bool weft_planner_cancelled(const struct weft_planner *planner)
{
    const struct weft_progress *progress = planner->p.progress;
    return progress && progress->report && !progress->report(progress->priv, 0.0);
}

// The same for what reports progress of its own, which would go back and forth.
static inline bool weft_planner_goes_on(void *planner, double fraction)
{
    (void)fraction;
    return !weft_planner_cancelled((const struct weft_planner *)planner);
}

static inline struct weft_progress weft_planner_watch(struct weft_planner *planner)
{
    return (struct weft_progress){weft_planner_goes_on, planner};
}

// ---- plan.c -------------------------------------------------------------------------------------

// Parameters with their defaults. Returns WEFT_ERR_ARGUMENT, or WEFT_ERR_UNSUPPORTED for a
// technique that the profile has no means for.
enum weft_result weft_planner_resolve(const struct weft_pass_plan_params *params,
                                      struct weft_pass_plan_params *out);

// ---- plan_tiles.c -------------------------------------------------------------------------------

// As the parameters say, with the splits that are given.
enum weft_result weft_planner_make_tiles(struct weft_planner *planner);
// Brings the items into the given order. Returns WEFT_ERR_ARGUMENT where that is none of all tiles.
enum weft_result weft_planner_apply_order(struct weft_planner *planner);
// Splits a tile and notes it. NAN: the middle of its range.
enum weft_result weft_planner_split_tile(struct weft_planner *planner, int tile, double threshold);

// ---- plan_values.c: values at sample positions, numbered x fastest ------------------------------

size_t weft_planner_positions(const struct weft_planner *planner);
enum { WEFT_PLANNER_CHUNK = 2048 }; // positions looked at together
// Numbers of the next positions, from `first` on; returns how many there are, 0 at the end.
size_t weft_planner_chunk(const struct weft_planner *planner, size_t first,
                          uint32_t positions[WEFT_PLANNER_CHUNK]);
// With signs and shifts; out[i] += the item's value at positions[i].
void weft_planner_add_values(const struct weft_planner *planner,
                             const struct weft_pass_plan_item *item, size_t count,
                             const uint32_t *positions, int32_t *out);

// Over all positions, of sums over all items.
struct weft_pass_plan_sums {
    int32_t least, most;        // of the sums themselves
    int32_t positive, negative; // largest sum of either sign, both >= 0
};
enum weft_result weft_planner_sums(const struct weft_planner *planner,
                                   struct weft_pass_plan_sums *out);

// ---- plan_items.c -------------------------------------------------------------------------------

// Fills planner->items, one per tile or, with dot4, per four taps, whose pattern goes to the list.
// With `mixed`, one item may have weights of both signs.
enum weft_result weft_planner_make_items(struct weft_planner *planner, bool mixed);
// An item in two: a tile by its values, four taps by twos. false if it cannot be (a result is set
// when something failed).
bool weft_planner_split_item(struct weft_planner *planner, int item, enum weft_result *res);

// ---- plan_order.c -------------------------------------------------------------------------------

// The items in a row, and where a pass ends. Biases are in codes.
struct weft_pass_plan_order {
    int item_count, pass_count;
    int *item;     // by place
    int *pass_end; // by pass: one past its last place
    int *bias;     // by pass
    int initial;   // before the first
};
enum weft_result weft_pass_plan_order_create(const struct weft_log *log, int items,
                                             struct weft_pass_plan_order *out);
void weft_pass_plan_order_destroy(struct weft_pass_plan_order *order); // {0} is fine

// Orders the items as the parameters say, so that sums at all positions stay within [0, divisor].
// `mixed`: a pass may hold items of both signs. `wide`: search harder. *placed is how many items
// there are; when no order was found fewer, and the order is the best there was: those in front
// could be placed, those behind could not.
enum weft_result weft_planner_order(const struct weft_planner *planner, bool mixed, bool wide,
                                    struct weft_pass_plan_order *order, int *placed);

// ---- plan_fit.c ---------------------------------------------------------------------------------

// Tiles, units, items, scale and bias, with so much of the range to spare; INFINITY:
// as much as any order needs.
enum weft_result weft_planner_prepare(struct weft_planner *planner, double spare);
// Orders the items; where none is found, tiles are split or the range is scaled, as allowed.
// Returns WEFT_ERR_UNSUPPORTED where nothing helps.
enum weft_result weft_planner_fit(struct weft_planner *planner, struct weft_pass_plan_order *order);

// With entries for weights and samples of 1 that are `scale` of full range.
enum weft_result weft_planner_make_log_table(struct weft_planner *planner, double scale);

// ---- plan_passes.c ------------------------------------------------------------------------------

// Write the list's passes: by one order, split into high and low parts, or by groups with targets
// of their own, and set the result's scale and bias. Return WEFT_ERR_LIMIT, WEFT_ERR_UNSUPPORTED
// and WEFT_ERR_MEMORY.
enum weft_result weft_planner_emit(struct weft_planner *planner,
                                   const struct weft_pass_plan_order *order);
enum weft_result weft_planner_emit_split(struct weft_planner *planner,
                                         const struct weft_pass_plan_order *order);
// The divisor with which exact sums leave the margin, and as much more at the upper end, for passes
// whose biases, the margin below included, are so many codes in all; 0: there is no room.
int32_t weft_planner_margin_divisor(const struct weft_planner *planner, int bias, int more);
// Largest sum of magnitudes of a pass's weights over all positions.
int32_t weft_planner_pass_magnitude(const struct weft_planner *planner,
                                    const struct weft_pass *pass);
struct weft_pass *weft_planner_add_pass(struct weft_planner *planner, struct weft_pass pass);
enum weft_result weft_planner_add_group(struct weft_planner *planner,
                                        const struct weft_tap_group *group);

// ---- plan_hierarchy.c ---------------------------------------------------------------------------

enum weft_result weft_planner_emit_hierarchy(struct weft_planner *planner);

// ---- plan_error.c, plan_text.c ------------------------------------------------------------------

enum weft_result weft_planner_find_error(struct weft_planner *planner);
enum weft_result weft_planner_write_text(struct weft_planner *planner);

#endif
