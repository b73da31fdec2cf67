// SPDX-License-Identifier: BSD-3-Clause
#include "passes/plan/plan.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "passes/plan/plan_impl.h"
#include "passes/plan/range_impl.h"

enum {
    LOG_EXTRA_BITS = 8,
    MOST_MARGINS = 12,
    SOME_POSITIONS = 4096,
    SOME_EVERY = 16,
    MOST_SPLIT_BITS = 8
};
static const uint64_t DEFAULT_MEMORY = UINT64_C(1) << 30;

// ---- what is asked ------------------------------------------------------------------------------

static bool is_real(const struct weft_profile *profile)
{
    return weft_target_bits(profile->target) == 0;
}

static enum weft_result fill_kernel(struct weft_pass_plan_params *p)
{
    if (p->kernel.info)
        return WEFT_OK;
    return weft_kernel_create(p->log, weft_kernel_find("catmull-rom"), NULL, &p->kernel);
}

static int default_bits(const struct weft_pass_plan_params *p)
{
    if (p->profile.target != WEFT_TARGET_UNORM16)
        return WEFT_PASS_PLAN_BITS;
    return p->technique == WEFT_TECHNIQUE_HIERARCHICAL      ? WEFT_PASS_PLAN_BITS_16_HIERARCHICAL
           : p->technique == WEFT_TECHNIQUE_SPLIT_PRECISION ? WEFT_PASS_PLAN_BITS_16_SPLIT
                                                            : WEFT_PASS_PLAN_BITS_16;
}

static enum weft_result fill_defaults(struct weft_pass_plan_params *p)
{
    enum weft_result res = fill_kernel(p);
    if (res == WEFT_OK && !p->profile.name[0])
        p->profile = *weft_profile_find("unorm8");
    p->dims = p->dims ? p->dims : 2;
    p->channels = p->channels ? p->channels : 1;
    p->samples = p->samples    ? p->samples
                 : p->dims > 2 ? WEFT_PASS_PLAN_SAMPLES_3D
                               : WEFT_PASS_PLAN_SAMPLES_2D;
    p->bits = p->bits ? p->bits : default_bits(p);
    p->taps_per_pass = p->taps_per_pass ? p->taps_per_pass : p->profile.taps_per_pass;
    p->memory_bytes = p->memory_bytes ? p->memory_bytes : DEFAULT_MEMORY;
    return res;
}

static enum weft_result check_ranges(const struct weft_pass_plan_params *p)
{
    enum weft_result res = weft_kernel_check(p->log, &p->kernel);
    if (res == WEFT_OK)
        res = weft_profile_check(p->log, &p->profile);
    if (res != WEFT_OK)
        return res;
    res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, p->dims == 2 || p->dims == 3);
    weft_require(p->log, p->channels == 1 || p->channels == 4);
    weft_require_enum(p->log, p->technique, WEFT_TECHNIQUE_LOG);
    weft_require_enum(p->log, p->worst_case, WEFT_WORST_ANY);
    weft_require_enum(p->log, p->order, WEFT_ORDER_GIVEN);
    weft_require(p->log, weft_derivative_order(&p->derivative) >= 0);
    weft_require(p->log, p->dims == 3 || !p->derivative.along[2]);
    weft_require(p->log, p->order != WEFT_ORDER_GIVEN || p->tile_order);
    if (p->taps_per_pass < 1 || p->taps_per_pass > p->profile.taps_per_pass) {
        weft_error(p->log, "plan: profile %s takes 1 to %d taps per pass, not %d", p->profile.name,
                   p->profile.taps_per_pass, p->taps_per_pass);
        goto fail;
    }
    if (p->profile.target == WEFT_TARGET_UNORM16 && p->bits > WEFT_PASS_PLAN_MOST_BITS_16) {
        weft_error(p->log,
                   "plan: tiles for 16-bit targets have 4 to %d bits, not %d: products "
                   "must fit into 32",
                   WEFT_PASS_PLAN_MOST_BITS_16, p->bits);
        goto fail;
    }
    return WEFT_OK;
fail:
    return res;
}

// What the profile has no means for, or the technique no sense.
static const char *unsupported(const struct weft_pass_plan_params *p)
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

static enum weft_result check_params(const struct weft_pass_plan_params *p)
{
    enum weft_result res = check_ranges(p);
    const char *why = res == WEFT_OK ? unsupported(p) : NULL;
    if (!why)
        return res;
    weft_error(p->log, "plan: technique %s %s (profile %s)",
               weft_name(weft_technique_names, p->technique), why, p->profile.name);
    return WEFT_ERR_UNSUPPORTED;
}

enum weft_result weft_planner_resolve(const struct weft_pass_plan_params *params,
                                      struct weft_pass_plan_params *out)
{
    *out = *params;
    const enum weft_result res = fill_defaults(out);
    return res == WEFT_OK ? check_params(out) : res;
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

static enum weft_result emit(struct weft_planner *planner, const struct weft_pass_plan_order *order)
{
    planner->plan->list.pass_count = planner->plan->list.group_count = 0;
    if (planner->p.technique == WEFT_TECHNIQUE_HIERARCHICAL)
        return weft_planner_emit_hierarchy(planner);
    return planner->p.technique == WEFT_TECHNIQUE_SPLIT_PRECISION
               ? weft_planner_emit_split(planner, order)
               : weft_planner_emit(planner, order);
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

static enum weft_result simulate(struct weft_planner *planner, size_t every)
{
    const struct weft_progress watch = weft_planner_watch(planner);
    struct weft_pass_plan *plan = planner->plan;
    free(plan->ranges);
    plan->ranges = calloc((size_t)plan->list.pass_count + 1, sizeof *plan->ranges);
    if (!plan->ranges) {
        weft_error(planner->p.log, "plan: not enough memory for %d ranges", plan->list.pass_count);
        return WEFT_ERR_MEMORY;
    }
    enum weft_result res =
        weft_range_simulate_some(planner->p.log, &plan->list, planner->p.worst_case, every, &watch,
                                 plan->ranges, &plan->info.range);
    plan->info.valid = plan->info.range.valid;
    return res;
}

static int codes_beyond(const struct weft_planner *planner, double x)
{
    return x > 0.0 ? (int)ceil(x * planner->full - 1e-6) : 0;
}

// In a hierarchy roundings of groups shrink with the result's scale: what reaches from `low` codes
// below to `high` above is made to fit as it is.
static void shrink(struct weft_planner *planner, int low, int high)
{
    struct weft_pass_plan_margin *m = &planner->margin;
    const double room = planner->full - planner->bias;
    const double ratio = (double)planner->full / (planner->full + low + high);
    const double k = 1.0 - (m->low + m->high) / room;
    const int below = (int)ceil(ratio * (planner->bias + m->low + low) - 1e-9) - planner->bias;
    const int all = (int)ceil(room * (1.0 - k * ratio) - 1e-9);
    m->low = below > m->low ? below : m->low;
    m->high = all - m->low > m->high ? all - m->low : m->high;
}

// Gives the margin what roundings were seen to take; what a pass has inside counts as its top.
static void widen_margin(struct weft_planner *planner)
{
    const struct weft_pass_plan *plan = planner->plan;
    const bool leaves = planner->p.technique == WEFT_TECHNIQUE_HIERARCHICAL;
    int low = 0, high = 0, leaf = 0;
    bool carries = false;
    for (int i = 0; i < plan->list.pass_count; i++) {
        const struct weft_pass *pass = &plan->passes[i];
        const int below = codes_beyond(planner, -plan->ranges[i].minimum);
        const int above = codes_beyond(planner, plan->ranges[i].maximum - 1.0);
        int *top = leaves && pass->kind == WEFT_PASS_TAPS ? &leaf : &high;
        carries = carries || (pass->part == WEFT_PASS_LOW && above);
        low = below > low ? below : low;
        *top = above > *top ? above : *top;
    }
    if (!low && !high && !leaf)
        *(leaves ? &leaf : &high) = codes_beyond(planner, plan->info.range.overflow);
    if (carries) {
        planner->margin.fewer_bits++;
        return;
    }
    planner->margin.leaf += leaf;
    if (leaves) {
        shrink(planner, low, high);
        return;
    }
    planner->margin.low += low;
    planner->margin.high += high;
}

// Passes that hold for the integers that they compute: with a margin, where roundings take sums
// beyond their exact range and scaling is allowed. What some positions need is mostly enough.
static enum weft_result emit_valid(struct weft_planner *planner,
                                   const struct weft_pass_plan_order *order)
{
    const struct weft_pass_plan_params *p = &planner->p;
    const bool scales = p->order == WEFT_ORDER_PLANNED && !p->no_scale && !planner->real;
    bool all = !scales || weft_planner_positions(planner) < SOME_POSITIONS;
    for (int round = 0;; round++) {
        enum weft_result res = emit(planner, order);
        if (res == WEFT_OK)
            res = simulate(planner, all ? 1 : SOME_EVERY);
        if (res == WEFT_OK && !all && (planner->plan->info.valid || round == MOST_MARGINS)) {
            all = true;
            res = simulate(planner, 1);
        }
        if (res != WEFT_OK || planner->plan->info.valid || !scales || round >= MOST_MARGINS)
            return res;
        widen_margin(planner);
    }
}

// A planned order keeps exact sums in range; without a scale, what roundings take beyond is told.
static enum weft_result judge_planned(const struct weft_planner *planner)
{
    const struct weft_pass_list *list = &planner->plan->list;
    const struct weft_range_report *range = &planner->plan->info.range;
    const double roundings = 0.5 * (4 * list->group_count + 2 * list->pass_count);
    if (planner->p.no_scale && range->overflow * planner->full <= roundings)
        return WEFT_OK;
    weft_error(planner->p.log,
               "plan: pass %d leaves [0, 1] with %.6g at sample position (%d, %d, %d), and no "
               "order prevents it",
               range->pass, range->value, range->position[0], range->position[1],
               range->position[2]);
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
    const struct weft_pass_plan_params *p = &planner->p;
    struct weft_pass_plan *plan = planner->plan;
    const struct weft_pass_list *list = &plan->list;
    const struct weft_kernel_tiles_info *tiles = weft_kernel_tiles_get_info(plan->tiles);
    struct weft_pass_plan_info *info = &plan->info;
    const int target_bytes = p->profile.target == WEFT_TARGET_FLOAT    ? 4
                             : p->profile.target == WEFT_TARGET_UNORM8 ? 1
                                                                       : 2;
    const size_t group_values =
        list->dot4 ? 4 * (size_t)list->group_count : (size_t)tiles->stored_count;
    info->passes = list;
    info->ranges = plan->ranges;
    info->tile_splits = plan->splits;
    info->tile_count = tiles->tile_count;
    info->split_count = info->tile_split_count;
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

static void start_info(struct weft_planner *planner)
{
    struct weft_pass_plan_info *info = &planner->plan->info;
    *info = (struct weft_pass_plan_info){.kernel = planner->p.kernel,
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
}

static enum weft_result tell(struct weft_planner *planner)
{
    fill_info(planner);
    const enum weft_result res = weft_planner_find_error(planner);
    return res == WEFT_OK ? weft_planner_write_text(planner) : res;
}

static enum weft_result make(struct weft_planner *planner)
{
    struct weft_pass_plan_order order = {0};
    const double start = weft_now_seconds();
    struct weft_pass_plan_info *info = &planner->plan->info;
    start_info(planner);
    start_list(planner);
    enum weft_result res = weft_planner_prepare(planner, 0.0);
    if (res == WEFT_OK && planner->p.technique != WEFT_TECHNIQUE_HIERARCHICAL)
        res = weft_planner_fit(planner, &order);
    if (res == WEFT_OK)
        res = emit_valid(planner, &order);
    weft_pass_plan_order_destroy(&order);
    info->search_seconds = weft_now_seconds() - start;
    if (res == WEFT_OK)
        res = check_bits(planner);
    if (res == WEFT_OK && !info->valid && planner->p.order == WEFT_ORDER_PLANNED)
        res = judge_planned(planner);
    return res == WEFT_OK ? tell(planner) : res;
}

// ---- passes that are given ----------------------------------------------------------------------

enum { MOST_GIVEN_SHIFT = 16 }; // a 14-bit weight times that is within 32 bits

static const char *foreign_pass(const struct weft_planner *planner, const struct weft_pass *pass)
{
    const bool split = planner->p.technique == WEFT_TECHNIQUE_SPLIT_PRECISION;
    if (pass->kind == WEFT_PASS_COMBINE)
        return split || planner->p.technique == WEFT_TECHNIQUE_HIERARCHICAL ? NULL : "combines";
    return (pass->part != WEFT_PASS_WHOLE) == split ? NULL
           : split                                  ? "adds whole parts"
                                                    : "adds high or low parts";
}

static enum weft_result take_passes(struct weft_planner *planner, const struct weft_pass_list *from)
{
    struct weft_pass_list *list = &planner->plan->list;
    enum weft_result res = WEFT_OK;
    for (int i = 0; res == WEFT_OK && i < from->group_count; i++) {
        for (int c = 0; c < (list->dot4 ? 4 : 1); c++)
            if (from->groups[i].tile[c] >= 0 &&
                (unsigned)from->groups[i].shift[c] > MOST_GIVEN_SHIFT) {
                weft_error(planner->p.log, "plan: group %d is shifted by %d bits, not 0 to %d", i,
                           from->groups[i].shift[c], MOST_GIVEN_SHIFT);
                return WEFT_ERR_ARGUMENT;
            }
        res = weft_planner_add_group(planner, &from->groups[i]);
    }
    for (int i = 0; res == WEFT_OK && i < from->pass_count; i++) {
        const struct weft_pass *pass = &from->passes[i];
        const char *foreign = foreign_pass(planner, pass);
        if (foreign) {
            weft_error(planner->p.log, "plan: pass %d %s, which technique %s does not", i, foreign,
                       weft_technique_names[planner->p.technique]);
            return WEFT_ERR_ARGUMENT;
        }
        if (pass->target < 0 || pass->target >= from->pass_count) { // each slot is written
            weft_error(planner->p.log, "plan: pass %d writes slot %d, of %d passes", i,
                       pass->target, from->pass_count);
            return WEFT_ERR_ARGUMENT;
        }
        if (!weft_planner_add_pass(planner, *pass))
            res = WEFT_ERR_MEMORY;
        list->slot_count = pass->target >= list->slot_count ? pass->target + 1 : list->slot_count;
        list->scratch_count |= pass->reads_target || pass->kind == WEFT_PASS_COMBINE;
    }
    return res;
}

static enum weft_result take_list(struct weft_planner *planner, const struct weft_pass_list *from)
{
    struct weft_pass_list *list = &planner->plan->list;
    const int most = planner->p.profile.internal_bits ? list->extra_bits : MOST_SPLIT_BITS;
    if (planner->p.technique == WEFT_TECHNIQUE_SPLIT_PRECISION) {
        if (from->extra_bits < 1 || from->extra_bits > most) {
            weft_error(planner->p.log, "plan: %d bits in the low target, not 1 to %d",
                       from->extra_bits, most);
            return WEFT_ERR_ARGUMENT;
        }
        list->extra_bits = from->extra_bits;
    }
    if (list->dot4)
        memcpy(list->pattern, from->pattern, sizeof list->pattern);
    list->result = from->result;
    list->result_scale = from->result_scale;
    list->result_bias = from->result_bias;
    const enum weft_result res = take_passes(planner, from);
    return res == WEFT_OK && planner->logarithms
               ? weft_planner_make_log_table(planner, list->result_scale)
               : res;
}

static enum weft_result judge(struct weft_planner *planner, const struct weft_pass_list *from,
                              enum weft_order order)
{
    start_info(planner);
    planner->plan->info.order = order;
    start_list(planner);
    enum weft_result res = weft_planner_make_tiles(planner);
    if (res == WEFT_OK)
        res = take_list(planner, from);
    if (res == WEFT_OK)
        res = simulate(planner, 1);
    if (res == WEFT_OK)
        res = check_bits(planner);
    return res == WEFT_OK ? tell(planner) : res;
}

// ---- creation -----------------------------------------------------------------------------------

static enum weft_result create(const struct weft_pass_plan_params *params,
                               const struct weft_pass_list *given, enum weft_order order,
                               weft_pass_plan **out)
{
    *out = NULL;
    struct weft_planner planner = {.plan = NULL};
    enum weft_result res = weft_planner_resolve(params, &planner.p);
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
    planner.derives =
        weft_derivative_order(&planner.p.derivative) > 0 || planner.p.kernel.info->derivation > 0;
    res = given ? judge(&planner, given, order) : make(&planner);
    free(planner.items);
    if (res == WEFT_OK)
        *out = planner.plan;
    else
        weft_pass_plan_destroy(&planner.plan);
    return res;
}

enum weft_result weft_pass_plan_create(const struct weft_pass_plan_params *params,
                                       weft_pass_plan **out)
{
    return create(params, NULL, params->order, out);
}

enum weft_result weft_pass_plan_judge(const struct weft_pass_plan_params *params,
                                      const struct weft_pass_list *passes, weft_pass_plan **out)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    struct weft_pass_plan_params p = *params;
    *out = NULL;
    weft_require(p.log, passes && passes->passes && passes->pass_count > 0);
    weft_require(p.log, passes->result_scale > 0.0);
    p.order = WEFT_ORDER_PLANNED; // others need an order of tiles
    return create(&p, passes, params->order, out);
fail:
    return res;
}

void weft_pass_plan_destroy(weft_pass_plan **plan)
{
    if (!plan || !*plan)
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

const struct weft_pass_plan_info *weft_pass_plan_get_info(const weft_pass_plan *plan)
{
    return &plan->info;
}
