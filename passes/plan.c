// SPDX-License-Identifier: BSD-3-Clause
#include "passes/plan.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/kernel_nd.h"
#include "passes/plan_impl.h"

enum { MAX_SPLITS = 16, LOG_EXTRA_BITS = 8 };
// How far scaled tiles of a hierarchy go: deep enough for a tri-cubic kernel's corners.
enum { HIERARCHY_SCALE_8 = 128, HIERARCHY_SCALE_16 = 8 };
static const uint64_t DEFAULT_MEMORY = UINT64_C(1) << 30;

const char *const weft_technique_names[] = {"plain",        "dot4", "split-precision",
                                            "hierarchical", "log",  NULL};

// ---- what is asked ------------------------------------------------------------------------------

static bool is_real(const struct weft_profile *profile)
{
    return weft_target_bits(profile->target) == 0;
}

static enum weft_result fill_kernel(struct weft_plan_params *p)
{
    if (p->kernel.info)
        return WEFT_OK;
    return weft_kernel_create(p->log, weft_kernel_find("catmull-rom"), NULL, &p->kernel);
}

static int default_bits(const struct weft_plan_params *p)
{
    if (p->profile.target != WEFT_TARGET_UNORM16)
        return 8;
    return p->technique == WEFT_TECHNIQUE_HIERARCHICAL      ? 11
           : p->technique == WEFT_TECHNIQUE_SPLIT_PRECISION ? 10
                                                            : 12;
}

static enum weft_result fill_defaults(struct weft_plan_params *p)
{
    enum weft_result res = fill_kernel(p);
    if (res == WEFT_OK && !p->profile.name[0])
        p->profile = *weft_profile_find("unorm8");
    p->dims = p->dims ? p->dims : 2;
    p->channels = p->channels ? p->channels : 1;
    p->samples = p->samples ? p->samples : p->dims > 2 ? 32 : 64;
    p->bits = p->bits ? p->bits : default_bits(p);
    p->taps_per_pass = p->taps_per_pass ? p->taps_per_pass : p->profile.taps_per_pass;
    p->memory_bytes = p->memory_bytes ? p->memory_bytes : DEFAULT_MEMORY;
    return res;
}

static enum weft_result check_ranges(const struct weft_plan_params *p)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, p->dims == 2 || p->dims == 3);
    weft_require(p->log, p->channels == 1 || p->channels == 4);
    weft_require(p->log, p->technique >= 0 && p->technique <= WEFT_TECHNIQUE_LOG);
    weft_require(p->log, p->derivative >= 0 && p->derivative <= p->dims);
    weft_require(p->log, p->order != WEFT_ORDER_GIVEN || p->steps);
    if (p->taps_per_pass < 1 || p->taps_per_pass > p->profile.taps_per_pass) {
        weft_error(p->log, "plan: profile %s takes 1 to %d taps per pass, not %d", p->profile.name,
                   p->profile.taps_per_pass, p->taps_per_pass);
        goto fail;
    }
    if (p->profile.target == WEFT_TARGET_UNORM16 && p->bits > 14) {
        weft_error(p->log,
                   "plan: tiles for 16-bit targets have 4 to 14 bits, not %d: products "
                   "must fit into 32",
                   p->bits);
        goto fail;
    }
    return WEFT_OK;
fail:
    return res;
}

// What the profile has no means for, or the technique no sense.
static const char *unsupported(const struct weft_plan_params *p)
{
    const bool coded = p->technique == WEFT_TECHNIQUE_SPLIT_PRECISION ||
                       p->technique == WEFT_TECHNIQUE_HIERARCHICAL ||
                       p->technique == WEFT_TECHNIQUE_LOG;
    if (coded && is_real(&p->profile))
        return "is for targets of fixed point";
    if (p->technique == WEFT_TECHNIQUE_DOT4 && p->profile.dot_width == 1)
        return "needs dot products";
    if (p->technique == WEFT_TECHNIQUE_DOT4 && p->channels != 1)
        return "takes single-valued sources";
    if (p->technique == WEFT_TECHNIQUE_SPLIT_PRECISION && p->profile.max_scale == 1)
        return "needs factors above 1 for its shifts";
    if (p->technique == WEFT_TECHNIQUE_SPLIT_PRECISION && p->profile.internal_bits &&
        p->profile.internal_bits <= weft_target_bits(p->profile.target))
        return "needs more bits inside a pass than the target has";
    if (p->order == WEFT_ORDER_GIVEN &&
        (p->technique == WEFT_TECHNIQUE_DOT4 || p->technique == WEFT_TECHNIQUE_HIERARCHICAL))
        return "finds its own groups: no order can be given";
    return NULL;
}

static enum weft_result check_params(const struct weft_plan_params *p)
{
    enum weft_result res = check_ranges(p);
    const char *why = res == WEFT_OK ? unsupported(p) : NULL;
    if (!why)
        return res;
    weft_error(p->log, "plan: technique %s %s (profile %s)", weft_technique_names[p->technique],
               why, p->profile.name);
    return WEFT_ERR_UNSUPPORTED;
}

// ---- tiles --------------------------------------------------------------------------------------

static enum weft_result make_tiles(struct weft_planner *planner)
{
    const struct weft_plan_params *p = &planner->p;
    struct weft_kernel_tiles_params *tiles =
        weft_kernel_tiles_params(.kernel = p->kernel, .dims = p->dims, .derivative = p->derivative,
                                 .samples = p->samples, .bits = p->bits,
                                 .memory_bytes = p->memory_bytes, .log = p->log);
    if (planner->logarithms) {
        tiles->format = WEFT_TILE_FLOAT;
        tiles->signs = WEFT_TILE_SEPARATE;
    } else if (planner->real) {
        tiles->format = p->profile.target == WEFT_TARGET_HALF ? WEFT_TILE_HALF : WEFT_TILE_FLOAT;
    } else if (p->technique == WEFT_TECHNIQUE_HIERARCHICAL) {
        tiles->scaling = WEFT_TILE_SCALE_EACH;
        tiles->max_scale =
            p->profile.target == WEFT_TARGET_UNORM16 ? HIERARCHY_SCALE_16 : HIERARCHY_SCALE_8;
    } else {
        tiles->scaling = WEFT_TILE_SCALE_SET;
        tiles->rounding = p->round_singly ? WEFT_TILE_NEAREST : WEFT_TILE_SUM_PRESERVING;
    }
    weft_kernel_tiles_destroy(&planner->plan->tiles);
    planner->plan->info.tile_params = *tiles;
    planner->plan->info.tile_split_count = 0;
    enum weft_result res = weft_kernel_tiles_create(tiles, &planner->plan->tiles);
    planner->plan->list.tiles = planner->plan->tiles;
    return res;
}

// The tile of a step, -1 if there is none.
static int find_step(const weft_kernel_tiles *tiles, const struct weft_plan_step *step)
{
    const int count = weft_kernel_tiles_get_info(tiles)->tile_count;
    int piece = 0;
    for (int i = 0; i < count; i++) {
        const struct weft_kernel_tile *tile = weft_kernel_tiles_get(tiles, i);
        if (memcmp(tile->tap, step->tap, sizeof tile->tap) != 0)
            continue;
        if (step->part != WEFT_TILE_WHOLE && tile->part != step->part)
            continue;
        if (piece++ == step->piece)
            return i;
    }
    return -1;
}

static const char *part_text(enum weft_tile_part part)
{
    return part == WEFT_TILE_POSITIVE ? "+" : part == WEFT_TILE_NEGATIVE ? "-" : "";
}

static enum weft_result no_such_step(const struct weft_planner *planner,
                                     const struct weft_plan_step *step)
{
    weft_error(planner->p.log, "plan: there is no tile (%d,%d,%d)%s piece %d of kernel %s",
               step->tap[0], step->tap[1], step->tap[2], part_text(step->part), step->piece,
               planner->p.kernel.info->name);
    return WEFT_ERR_ARGUMENT;
}

enum weft_result weft_planner_split_tile(struct weft_planner *planner, int tile, double threshold)
{
    struct weft_plan *plan = planner->plan;
    if (plan->info.tile_split_count == plan->split_room) {
        const int room = plan->split_room ? 2 * plan->split_room : 16;
        struct weft_plan_split *splits = realloc(plan->splits, (size_t)room * sizeof *splits);
        if (!splits) {
            weft_error(planner->p.log, "plan: not enough memory for %d splits", room);
            return WEFT_ERR_MEMORY;
        }
        plan->splits = splits;
        plan->split_room = room;
    }
    const struct weft_kernel_tile *t = weft_kernel_tiles_get(plan->tiles, tile);
    const struct weft_plan_split split = {
        .tile = weft_plan_tile_step(plan, tile),
        .threshold = isnan(threshold) ? 0.5 * (t->minimum + t->maximum) : threshold};
    enum weft_result res = weft_kernel_tiles_split(plan->tiles, tile, threshold);
    if (res == WEFT_OK)
        plan->splits[plan->info.tile_split_count++] = split;
    return res;
}

static enum weft_result make_given_splits(struct weft_planner *planner)
{
    enum weft_result res = WEFT_OK;
    for (size_t i = 0; res == WEFT_OK && i < planner->p.split_count; i++) {
        const struct weft_plan_split *split = &planner->p.splits[i];
        const int tile = find_step(planner->plan->tiles, &split->tile);
        if (tile < 0)
            return no_such_step(planner, &split->tile);
        res = weft_planner_split_tile(planner, tile, split->threshold);
        planner->plan->info.split_count++;
    }
    return res;
}

// ---- units --------------------------------------------------------------------------------------

static enum weft_result make_log_table(struct weft_planner *planner, double scale)
{
    struct weft_pass_list *list = &planner->plan->list;
    const int full = planner->full;
    const double one = (double)full * (1 << list->extra_bits) * scale;
    if (!planner->plan->log_table)
        planner->plan->log_table = malloc((2 * (size_t)full + 1) * sizeof(uint32_t));
    if (!planner->plan->log_table) {
        weft_error(planner->p.log, "plan: not enough memory for a table of %d logarithms", full);
        return WEFT_ERR_MEMORY;
    }
    for (int i = 0; i <= 2 * full; i++)
        planner->plan->log_table[i] =
            (uint32_t)round(one * exp2(-i * list->log_octaves / (full - 1)));
    list->log_table = planner->plan->log_table;
    return WEFT_OK;
}

// Value 1 of a tile in weight, and what a target holds. Tiles of a hierarchy have scales of their
// own, and the largest one's unit.
static void set_units(struct weft_planner *planner)
{
    const weft_kernel_tiles *tiles = planner->plan->tiles;
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(tiles);
    double scale = 0.0;
    for (int i = 0; i < info->tile_count; i++)
        scale = fmax(scale, weft_kernel_tiles_get(tiles, i)->scale);
    planner->unit = 1.0 / (info->one * scale);
    if (planner->logarithms)
        planner->unit = 1.0 / ((double)planner->full * (1 << planner->plan->list.extra_bits));
    if (planner->real)
        planner->unit = 1.0;
}

static void shift_atoms(struct weft_planner *planner)
{
    const weft_kernel_tiles *tiles = planner->plan->tiles;
    const double one = weft_kernel_tiles_get_info(tiles)->one;
    for (int i = 0; i < planner->atom_count; i++)
        for (int c = 0; c < 4; c++) {
            struct weft_tap_group *group = &planner->atoms[i].group;
            const struct weft_kernel_tile *tile = weft_kernel_tiles_get(tiles, group->tile[c]);
            if (tile)
                group->shift[c] = (int)lround(-log2(planner->unit * one * tile->scale));
        }
}

static int64_t most_of(int64_t a, int64_t b)
{
    return a > b ? a : b;
}

static int64_t common_divisor(int64_t a, int64_t b)
{
    return b ? common_divisor(b, a % b) : a;
}

// The least divisor from this one on that leaves room for sums from -down to up. Biases are whole
// codes; with 16 bits they come in steps, so that the search has whole numbers of 32 bits.
static void set_bias(struct weft_planner *planner, int64_t divisor, int64_t down, int64_t up)
{
    const int64_t full = planner->full, unit = full == 255 ? 1 : 255;
    for (divisor = (divisor + unit - 1) / unit * unit;; divisor += unit) {
        const int64_t step = full == 255 ? 1 : full / common_divisor(divisor, full);
        const int64_t bias = ((down * full + divisor - 1) / divisor + step - 1) / step * step;
        planner->divisor = (int32_t)divisor;
        planner->bias = (int32_t)bias;
        planner->bias_step = (int32_t)step;
        if (up * full <= (full - bias) * divisor)
            return;
    }
}

// Scale and bias for sums as they are, with so much of the range to spare, INFINITY: as much as any
// order needs. Derivatives are stored as 0.5 + 0.5 g (section 5), with less than 0.5 where their
// weights need it.
static void set_scale(struct weft_planner *planner, const struct weft_plan_sums *sums, double spare)
{
    const bool any = planner->p.worst_case == WEFT_WORST_ANY || isinf(spare);
    const int64_t one = llround(1.0 / planner->unit);
    // Scaled logarithms are rounded anew.
    const int64_t rounding = planner->logarithms ? planner->atom_count : 0;
    int64_t up = any ? sums->positive : most_of(sums->most, 0);
    int64_t down = any ? sums->negative : most_of(-(int64_t)sums->least, 0);
    up += up > one - rounding ? rounding : 0;
    down += down ? rounding : 0;
    const double room = isinf(spare) ? 0.0 : ceil(spare * (double)one);
    planner->bias = 0;
    planner->bias_step = 1;
    if (planner->real || planner->p.order > WEFT_ORDER_GREEDY || !planner->p.allow_scale) {
        planner->divisor = (int32_t)one;
        if (planner->derives && !planner->real)
            set_bias(planner, 2 * one, one, one);
        return;
    }
    if (planner->derives) {
        const int64_t side = most_of(one, most_of(up, down)) + (int64_t)room;
        set_bias(planner, 2 * side, side, side);
    } else if (down > 0 || room > 0.0) {
        const int64_t half = (int64_t)room / 2;
        set_bias(planner, most_of(one, up + down), down + half, up + (int64_t)room - half);
    } else {
        planner->divisor = (int32_t)most_of(one, up);
    }
}

// Entries of the log table carry the scale, so that a target is full at T.
static enum weft_result scale_log_table(struct weft_planner *planner)
{
    const double one = 1.0 / planner->unit;
    enum weft_result res = make_log_table(planner, one / planner->divisor);
    planner->plan->list.result_scale = one / planner->divisor;
    planner->divisor = (int32_t)one;
    return res;
}

// ---- finding an order ---------------------------------------------------------------------------

static bool negative_weights(const struct weft_planner *planner)
{
    const weft_kernel_tiles *tiles = planner->plan->tiles;
    for (int i = 0; i < weft_kernel_tiles_get_info(tiles)->tile_count; i++)
        if (weft_kernel_tiles_get(tiles, i)->minimum < 0.0)
            return true;
    return false;
}

// Whether a pass may hold both signs: only by reading what it adds to.
static bool mixes_signs(const struct weft_planner *planner)
{
    const struct weft_plan_params *p = &planner->p;
    return !planner->real && p->profile.ping_pong && !p->blend_only && negative_weights(planner) &&
           (p->taps_per_pass > 1 || p->technique == WEFT_TECHNIQUE_DOT4);
}

static enum weft_result prepare(struct weft_planner *planner, double spare)
{
    struct weft_plan_sums sums = {0};
    enum weft_result res = make_tiles(planner);
    planner->plan->info.split_count = 0;
    if (res == WEFT_OK)
        res = make_given_splits(planner);
    if (res != WEFT_OK)
        return res;
    set_units(planner);
    if (planner->logarithms)
        res = make_log_table(planner, 1.0);
    if (res == WEFT_OK)
        res = weft_planner_make_atoms(planner, mixes_signs(planner) || planner->real);
    if (res != WEFT_OK)
        return res;
    if (planner->p.technique == WEFT_TECHNIQUE_HIERARCHICAL)
        shift_atoms(planner);
    if (!planner->real)
        res = weft_planner_sums(planner, &sums);
    if (res != WEFT_OK)
        return res;
    set_scale(planner, &sums, spare);
    return planner->logarithms ? scale_log_table(planner) : WEFT_OK;
}

// Splits what could not be placed; returns how many splits there were.
static int split_stuck(struct weft_planner *planner, const struct weft_plan_order *order,
                       int placed, int most, enum weft_result *res)
{
    int splits = 0;
    for (int i = placed; *res == WEFT_OK && i < order->atom_count && splits < most; i++)
        splits += weft_planner_split_atom(planner, order->atom[i], res);
    planner->plan->info.split_count += splits;
    return splits;
}

// Tries with splits, up to so many; at first with a wide search, perhaps. *found: an order was.
static enum weft_result order_atoms(struct weft_planner *planner, int splits, bool wide,
                                    struct weft_plan_order *order, bool *found)
{
    for (;;) {
        int placed = 0;
        weft_plan_order_destroy(order);
        enum weft_result res = weft_plan_order_create(planner->p.log, planner->atom_count, order);
        if (res == WEFT_OK)
            res = weft_planner_order(planner, mixes_signs(planner) || planner->real, wide, order,
                                     &placed);
        *found = placed == order->atom_count;
        if (res != WEFT_OK || *found)
            return res;
        const int made = split_stuck(planner, order, placed, splits, &res);
        if (res != WEFT_OK || !made)
            return res;
        splits -= made;
    }
}

static enum weft_result no_order(const struct weft_planner *planner)
{
    struct weft_plan_sums sums = {0};
    const double one = 1.0 / planner->unit;
    enum weft_result res = weft_planner_sums(planner, &sums);
    if (res != WEFT_OK)
        return res;
    if (sums.most > planner->divisor)
        weft_error(planner->p.log,
                   "plan: no order of passes helps: the weights at a sample position add up to "
                   "%.6g (%d/%.0f) where 1.0 is full",
                   sums.most / one, sums.most, one);
    else
        weft_error(planner->p.log,
                   "plan: no order of %d groups of taps was found that stays within [0, 1]",
                   planner->atom_count);
    return WEFT_ERR_UNSUPPORTED;
}

// Orders first, then splits, then less and less of the range.
static enum weft_result find_order(struct weft_planner *planner, struct weft_plan_order *order)
{
    static const double spares[] = {0.0,  0.008, 0.016, 0.03, 0.0625, 0.125,
                                    0.25, 0.5,   1.0,   2.0,  4.0,    INFINITY};
    // Passes of four taps, and of derivatives, are saved by a little of the range.
    const bool scales =
        planner->p.allow_scale && (planner->p.technique == WEFT_TECHNIQUE_DOT4 || planner->derives);
    const bool splits = planner->p.allow_splits && !scales;
    bool found = false;
    enum weft_result res = WEFT_OK;
    for (size_t i = 0; i < WEFT_COUNT(spares); i++) {
        if (i)
            res = prepare(planner, spares[i]);
        if (res == WEFT_OK)
            res = order_atoms(planner, splits && i == 0 ? MAX_SPLITS : 0, i == 0, order, &found);
        if (res != WEFT_OK || found)
            return res;
        if (!planner->p.allow_scale)
            break;
    }
    return no_order(planner);
}

// ---- orders that are given ----------------------------------------------------------------------

static enum weft_result apply_steps(struct weft_planner *planner)
{
    const struct weft_plan_params *p = &planner->p;
    struct weft_plan_atom *atoms = planner->atoms;
    for (size_t n = 0; n < p->step_count; n++) {
        const int tile = find_step(planner->plan->tiles, &p->steps[n]);
        int at = 0;
        if (tile < 0)
            return no_such_step(planner, &p->steps[n]);
        while (at < planner->atom_count && atoms[at].group.tile[0] != tile)
            at++;
        if (at < (int)n || at == planner->atom_count) {
            weft_error(p->log, "plan: tile (%d,%d,%d)%s piece %d comes twice", p->steps[n].tap[0],
                       p->steps[n].tap[1], p->steps[n].tap[2], part_text(p->steps[n].part),
                       p->steps[n].piece);
            return WEFT_ERR_ARGUMENT;
        }
        const struct weft_plan_atom moved = atoms[at];
        atoms[at] = atoms[n];
        atoms[n] = moved;
    }
    if (p->step_count == (size_t)planner->atom_count)
        return WEFT_OK;
    const struct weft_kernel_tile *missing =
        weft_kernel_tiles_get(planner->plan->tiles, atoms[p->step_count].group.tile[0]);
    weft_error(p->log, "plan: %zu tiles in the order of %d; tap (%d,%d,%d)%s is missing",
               p->step_count, planner->atom_count, missing->tap[0], missing->tap[1],
               missing->tap[2], part_text(missing->part));
    return WEFT_ERR_ARGUMENT;
}

// ---- the plan -----------------------------------------------------------------------------------

static void start_list(struct weft_planner *planner)
{
    const struct weft_profile *profile = &planner->p.profile;
    struct weft_pass_list *list = &planner->plan->list;
    const int bits = weft_target_bits(profile->target);
    list->target = profile->target;
    list->dims = planner->p.dims;
    list->dot4 = planner->p.technique == WEFT_TECHNIQUE_DOT4;
    list->dot_width = profile->dot_width;
    list->exact_inside = profile->internal_bits == 0;
    list->range = profile->internal_range;
    list->extra_bits = profile->internal_bits ? profile->internal_bits - bits : 0;
    if (planner->logarithms) {
        list->log_octaves = profile->target == WEFT_TARGET_UNORM16 ? 16.0 : 10.0;
        if (list->exact_inside)
            list->extra_bits = LOG_EXTRA_BITS;
    }
}

static enum weft_result emit(struct weft_planner *planner, struct weft_plan_order *order)
{
    enum weft_result res;
    if (planner->p.technique == WEFT_TECHNIQUE_HIERARCHICAL)
        return weft_planner_emit_hierarchy(planner);
    if (planner->p.order == WEFT_ORDER_PLANNED && !planner->real) {
        res = find_order(planner, order);
    } else {
        bool found;
        res = planner->p.order == WEFT_ORDER_GIVEN ? apply_steps(planner) : WEFT_OK;
        if (res == WEFT_OK)
            res = order_atoms(planner, 0, false, order, &found);
    }
    if (res != WEFT_OK)
        return res;
    res = planner->p.technique == WEFT_TECHNIQUE_SPLIT_PRECISION
              ? weft_planner_emit_split(planner, order)
              : weft_planner_emit(planner, order);
    if (!planner->logarithms)
        planner->plan->list.result_scale = 1.0 / (planner->unit * planner->divisor);
    return res;
}

// What a pass adds up, before it divides, must fit into 31 bits.
static enum weft_result check_bits(const struct weft_planner *planner)
{
    const struct weft_pass_list *list = &planner->plan->list;
    const double inside = (double)planner->full * (1 << list->extra_bits);
    for (int n = 0; !planner->real && !planner->logarithms && n < list->pass_count; n++) {
        const struct weft_pass *pass = &list->passes[n];
        double sum = pass->kind == WEFT_PASS_COMBINE
                         ? fabs((double)pass->bias) + pass->denominator
                         : (fabs((double)pass->bias) + 1.0) * pass->divisor;
        if (pass->kind == WEFT_PASS_TAPS)
            sum += weft_planner_pass_magnitude(planner, pass) * inside;
        for (int i = 0; pass->kind == WEFT_PASS_COMBINE && i < pass->input_count; i++)
            sum += fabs((double)pass->numerator[i]) * (list->exact_inside ? planner->full : inside);
        if (sum < 0x1p31)
            continue;
        weft_error(planner->p.log,
                   "plan: sums of pass %d reach %.4g, more than 32 bits hold: fewer tile bits or "
                   "taps per pass",
                   n, sum);
        return WEFT_ERR_LIMIT;
    }
    return WEFT_OK;
}

static enum weft_result simulate(struct weft_planner *planner)
{
    struct weft_plan *plan = planner->plan;
    plan->ranges = calloc((size_t)plan->list.pass_count + 1, sizeof *plan->ranges);
    if (!plan->ranges) {
        weft_error(planner->p.log, "plan: not enough memory for %d ranges", plan->list.pass_count);
        return WEFT_ERR_MEMORY;
    }
    enum weft_result res =
        weft_range_simulate(planner->p.log, &plan->list, planner->p.worst_case, planner->p.progress,
                            plan->ranges, &plan->info.range);
    plan->info.valid = plan->info.range.valid;
    if (res != WEFT_OK || plan->info.valid || planner->p.order != WEFT_ORDER_PLANNED)
        return res;
    weft_error(planner->p.log,
               "plan: pass %d leaves [0, 1] with %.6g at sample position (%d, %d, %d), and no "
               "order prevents it",
               plan->info.range.pass, plan->info.range.value, plan->info.range.position[0],
               plan->info.range.position[1], plan->info.range.position[2]);
    return WEFT_ERR_UNSUPPORTED;
}

static int count_fetches(const struct weft_pass_list *list)
{
    int fetches = 0;
    for (int n = 0; n < list->pass_count; n++) {
        const struct weft_pass *pass = &list->passes[n];
        fetches += pass->kind == WEFT_PASS_COMBINE ? pass->input_count
                                                   : 1 + 2 * pass->group_count + pass->reads_target;
    }
    return fetches;
}

static void fill_info(struct weft_planner *planner)
{
    const struct weft_plan_params *p = &planner->p;
    struct weft_plan *plan = planner->plan;
    const struct weft_pass_list *list = &plan->list;
    const struct weft_kernel_tiles_info *tiles = weft_kernel_tiles_get_info(plan->tiles);
    struct weft_plan_info *info = &plan->info;
    const int target_bytes = p->profile.target == WEFT_TARGET_FLOAT    ? 4
                             : p->profile.target == WEFT_TARGET_UNORM8 ? 1
                                                                       : 2;
    const size_t group_values =
        list->dot4 ? 4 * (size_t)list->group_count : (size_t)tiles->stored_count;
    info->passes = list;
    info->ranges = plan->ranges;
    info->tile_splits = plan->splits;
    info->tile_count = tiles->tile_count;
    info->fetches = count_fetches(list);
    info->kept_bits = weft_target_bits(p->profile.target) +
                      (p->technique == WEFT_TECHNIQUE_SPLIT_PRECISION ? list->extra_bits : 0);
    info->scale_bits = planner->real ? 0.0 : 0.0 - log2(list->result_scale);
    info->tile_bytes = (uint64_t)tiles->tile_values * group_values *
                       (planner->real         ? tiles->value_bytes
                        : planner->logarithms ? (uint64_t)target_bytes
                        : tiles->bits > 8     ? 2
                                              : 1);
    info->target_bytes_per_pixel =
        (uint64_t)(target_bytes * p->channels * (list->slot_count + list->scratch_count));
}

static enum weft_result make(struct weft_planner *planner)
{
    struct weft_plan_order order = {0};
    const double start = weft_now_seconds();
    struct weft_plan_info *info = &planner->plan->info;
    *info = (struct weft_plan_info){.kernel = planner->p.kernel,
                                    .profile = planner->p.profile,
                                    .dims = planner->p.dims,
                                    .derivative = planner->p.derivative,
                                    .samples = planner->p.samples,
                                    .bits = planner->p.bits,
                                    .channels = planner->p.channels,
                                    .technique = planner->p.technique,
                                    .worst_case = planner->p.worst_case,
                                    .order = planner->p.order,
                                    .tap_count = 1};
    for (int a = 0; a < planner->p.dims; a++)
        info->tap_count *= planner->p.kernel.width;
    start_list(planner);
    enum weft_result res = prepare(planner, 0.0);
    if (res == WEFT_OK)
        res = emit(planner, &order);
    weft_plan_order_destroy(&order);
    info->search_seconds = weft_now_seconds() - start;
    if (res == WEFT_OK)
        res = check_bits(planner);
    if (res == WEFT_OK)
        res = simulate(planner);
    if (res == WEFT_OK)
        fill_info(planner);
    if (res == WEFT_OK)
        res = weft_planner_find_error(planner);
    return res == WEFT_OK ? weft_planner_write_text(planner) : res;
}

enum weft_result weft_plan_create(const struct weft_plan_params *params, weft_plan **out)
{
    *out = NULL;
    struct weft_planner planner = {.p = *params};
    enum weft_result res = fill_defaults(&planner.p);
    if (res == WEFT_OK)
        res = check_params(&planner.p);
    if (res != WEFT_OK)
        return res;
    planner.plan = calloc(1, sizeof *planner.plan);
    if (!planner.plan) {
        weft_error(params->log, "plan: not enough memory");
        return WEFT_ERR_MEMORY;
    }
    planner.real = is_real(&planner.p.profile);
    planner.full = planner.real ? 1 : weft_target_one(planner.p.profile.target);
    planner.logarithms = planner.p.technique == WEFT_TECHNIQUE_LOG;
    planner.derives = planner.p.derivative || planner.p.kernel.info->derivation > 0;
    res = make(&planner);
    free(planner.atoms);
    if (res == WEFT_OK)
        *out = planner.plan;
    else
        weft_plan_destroy(&planner.plan);
    return res;
}

void weft_plan_destroy(weft_plan **plan)
{
    if (!*plan)
        return;
    weft_kernel_tiles_destroy(&(*plan)->tiles);
    free((*plan)->groups);
    free((*plan)->passes);
    free((*plan)->ranges);
    free((*plan)->log_table);
    free((*plan)->splits);
    free((*plan)->text);
    free(*plan);
    *plan = NULL;
}

const struct weft_plan_info *weft_plan_get_info(const weft_plan *plan)
{
    return &plan->info;
}

struct weft_plan_step weft_plan_tile_step(const weft_plan *plan, int tile)
{
    const struct weft_kernel_tile *t = weft_kernel_tiles_get(plan->tiles, tile);
    struct weft_plan_step step = {.part = t->part};
    memcpy(step.tap, t->tap, sizeof step.tap);
    for (int i = 0; i < tile; i++) {
        const struct weft_kernel_tile *other = weft_kernel_tiles_get(plan->tiles, i);
        step.piece += other->part == t->part && memcmp(other->tap, t->tap, sizeof t->tap) == 0;
    }
    return step;
}
