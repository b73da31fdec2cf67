// SPDX-License-Identifier: BSD-3-Clause
// Bounds of a plan's error by its sources (WSCG 2003, section 2.5). E2 is eq. 4 between sample
// positions too: the looked-up weight is constant in a cell of 1/M, the exact one a product of
// nearly straight lines, so that the sum of differences is largest at a corner of the cell, but for
// the lines' curvature, which is added.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/kernels/kernel_axes.h"
#include "filter/kernels/kernel_nd.h"
#include "filter/kernels/prefilter.h"
#include "passes/plan/plan_impl.h"
#include "passes/plan/range_impl.h"
#include "tiles/volume/volume.h"

// A cell's near end, its far end from inside, its middle, and where its tiles were sampled.
enum { NEAR, FAR, MIDDLE, SAMPLED, SIDES };

// Weights (radial: offsets) of one axis at one cell's ends and middle.
typedef double axis_weights[SIDES][WEFT_KERNEL_MAX_WIDTH];

struct e2 {
    const struct weft_planner *planner;
    const struct weft_kernel_tiles_info *info;
    bool radial;
    axis_weights *axis[3]; // [cell]
    // Cells are compared in rows along x.
    double *side[SIDES];       // axis[0] as [tap][cell]
    double *tap;               // what the tiles have, as [tap][cell]
    double *value;             // of one tile, by cell
    double *sum[2];            // by cell
    double *exact;             // of one cell, by tap
    double largest, magnitude; // of eq. 4's sum, and of the sum of |weights|
    double quantised;          // of prefiltered kernels
};

// ---- exact weights ------------------------------------------------------------------------------

static double axis_weight(const struct e2 *e, const struct weft_kernel *kernel, double fraction,
                          int tap)
{
    const double x = fraction + weft_kernel_offset(kernel) - tap;
    return e->radial ? x : weft_kernel_weight(kernel, x);
}

static void fill_axis(const struct e2 *e, const struct weft_kernel *kernel, axis_weights *out)
{
    const int m = e->info->samples;
    for (int k = 0; k < m; k++) {
        const double end = k + 1 < m ? (double)(k + 1) / m : 1.0;
        const double at[SIDES] = {(double)k / m, nextafter(end, 0.0), (k + 0.5) / m,
                                  weft_kernel_tiles_position(e->planner->plan->tiles, k)};
        for (int side = 0; side < SIDES; side++)
            for (int t = 0; t < kernel->width; t++)
                out[k][side][t] = axis_weight(e, kernel, at[side], t);
    }
}

static enum weft_result fill_axes(struct e2 *e)
{
    const struct weft_pass_plan_params *p = &e->planner->p;
    for (int a = 0; a < p->dims; a++) {
        struct weft_kernel kernel = p->kernel;
        enum weft_result res = WEFT_OK;
        res = weft_kernel_derive_times(p->log, &p->kernel, p->derivative.along[a], &kernel);
        if (res != WEFT_OK)
            return res;
        fill_axis(e, &kernel, e->axis[a]);
    }
    return WEFT_OK;
}

// ---- what is added for curvature ----------------------------------------------------------------

static double sum_of_magnitudes(const struct e2 *e, int axis)
{
    double largest = 0.0;
    for (int k = 0; k < e->info->samples; k++)
        for (int side = 0; side < SIDES; side++) {
            double sum = 0.0;
            for (int t = 0; t < e->info->width; t++)
                sum += fabs(e->axis[axis][k][side][t]);
            largest = fmax(largest, sum);
        }
    return largest;
}

// Of a cell's middle from the line between its ends; twice that is enough where a knot lies in the
// cell, too.
static double deviation(const struct e2 *e, int axis)
{
    double largest = 0.0;
    for (int k = 0; k < e->info->samples; k++) {
        const axis_weights *w = &e->axis[axis][k];
        double sum = 0.0;
        for (int t = 0; t < e->info->width; t++)
            sum += fabs((*w)[MIDDLE][t] - 0.5 * ((*w)[NEAR][t] + (*w)[FAR][t]));
        largest = fmax(largest, sum);
    }
    return 2.0 * largest;
}

static double curvature(const struct e2 *e)
{
    double sum = 0.0;
    for (int a = 0; !e->radial && a < e->info->dims; a++) {
        double product = deviation(e, a);
        for (int b = 0; b < e->info->dims; b++)
            product *= b == a ? 1.0 : sum_of_magnitudes(e, b);
        sum += product;
    }
    return sum;
}

// ---- eq. 4 --------------------------------------------------------------------------------------

static double log_weight(const struct e2 *e, double exact)
{
    const double octaves = e->planner->plan->list.log_octaves;
    const double step = octaves / (e->planner->full - 1);
    const double code = round(-log2(fabs(exact)) / step);
    return fabs(exact) < exp2(-octaves) ? 0.0 : copysign(exp2(-fmax(code, 0.0) * step), exact);
}

static void fill_taps(struct e2 *e, size_t first)
{
    const struct weft_pass_list *list = &e->planner->plan->list;
    const int m = e->info->samples, width = e->info->width;
    memset(e->tap, 0, (size_t)e->planner->plan->info.tap_count * (size_t)m * sizeof *e->tap);
    for (int i = 0; i < e->info->tile_count; i++) {
        const struct weft_kernel_tile *tile = weft_kernel_tiles_get(list->tiles, i);
        const double unit = (tile->negated ? -1.0 : 1.0) * (e->info->one * tile->scale);
        const int t = (tile->tap[2] * width + tile->tap[1]) * width + tile->tap[0];
        double *tap = e->tap + (size_t)t * (size_t)m;
        weft_range_load(list, i, first, m, e->value);
        for (int k = 0; k < m; k++)
            tap[k] +=
                e->planner->logarithms ? log_weight(e, e->value[k] / unit) : e->value[k] / unit;
    }
}

// Adds differences of one tap from a product of weights, in every cell of the row. (Where the
// product underflows, weft_kernel_combine has 2^-1074: no sum shows it.)
static void add_differences(double *restrict sum, const double *restrict tap,
                            const double *restrict x, double y, double z, int count)
{
    for (int k = 0; k < count; k++)
        sum[k] += fabs(tap[k] - x[k] * y * z);
}

static void add_excess(double *restrict more, double *restrict less, const double *restrict tap,
                       const double *restrict x, double y, double z, int count)
{
    for (int k = 0; k < count; k++) {
        const double difference = tap[k] - x[k] * y * z;
        more[k] += difference > 0.0 ? difference : 0.0;
        less[k] += difference < 0.0 ? -difference : 0.0;
    }
}

static double largest_of(double largest, const double *sum, int count)
{
    for (int k = 0; k < count; k++)
        largest = fmax(largest, sum[k]);
    return largest;
}

// The exact weights at one corner of every cell of a row (SAMPLED: where tiles were sampled) beside
// the taps.
static void compare_products(struct e2 *e, const int at[3], const int side[3])
{
    const int dims = e->info->dims, width = e->info->width, m = e->info->samples;
    const double *tap = e->tap;
    memset(e->sum[0], 0, (size_t)m * sizeof(double));
    memset(e->sum[1], 0, (size_t)m * sizeof(double));
    for (int k = 0; k < (dims > 2 ? width : 1); k++) {
        const double z = dims > 2 ? e->axis[2][at[2]][side[2]][k] : 1.0;
        for (int j = 0; j < width; j++) {
            const double y = e->axis[1][at[1]][side[1]][j], *x = e->side[side[0]];
            for (int i = 0; i < width; i++, tap += m, x += m)
                if (side[0] == SAMPLED)
                    add_excess(e->sum[0], e->sum[1], tap, x, y, z, m);
                else
                    add_differences(e->sum[0], tap, x, y, z, m);
        }
    }
}

// The same for radial weights, which are no products.
static void compare_radial(struct e2 *e, const int at[3], const int side[3])
{
    const int m = e->info->samples;
    memset(e->sum[1], 0, (size_t)m * sizeof(double));
    for (int k = 0; k < m; k++) {
        const double *axis[3] = {e->axis[0][k][side[0]], e->axis[1][at[1]][side[1]],
                                 e->info->dims > 2 ? e->axis[2][at[2]][side[2]] : NULL};
        const int count = weft_kernel_combine(&e->planner->p.kernel, e->info->dims, axis, e->exact);
        double sum = 0.0;
        for (int i = 0; i < count; i++)
            sum += fabs(e->tap[(size_t)i * (size_t)m + (size_t)k] - e->exact[i]);
        e->sum[0][k] = sum;
    }
}

static void compare(struct e2 *e, const int at[3], int corner)
{
    const int side[3] = {corner & 1, corner >> 1 & 1, corner >> 2 & 1}; // NEAR or FAR
    if (e->radial)
        compare_radial(e, at, side);
    else
        compare_products(e, at, side);
    e->largest = largest_of(e->largest, e->sum[0], e->info->samples);
}

// What quantised weights alone make, of coefficients in [0, 1]: where tiles were sampled, weights
// that are too large and those that are too small do not add up.
static void compare_sampled(struct e2 *e, const int at[3])
{
    compare_products(e, at, (const int[3]){SAMPLED, SAMPLED, SAMPLED});
    for (int i = 0; i < 2; i++)
        e->quantised = largest_of(e->quantised, e->sum[i], e->info->samples);
}

static void measure_taps(struct e2 *e)
{
    const int m = e->info->samples;
    memset(e->sum[0], 0, (size_t)m * sizeof(double));
    for (int i = 0; i < e->planner->plan->info.tap_count; i++)
        for (int k = 0; k < m; k++)
            e->sum[0][k] += fabs(e->tap[(size_t)i * (size_t)m + (size_t)k]);
    e->magnitude = largest_of(e->magnitude, e->sum[0], m);
}

static enum weft_result compare_all(struct e2 *e)
{
    const int m = e->info->samples, rows = e->info->dims > 2 ? m * m : m;
    for (int row = 0; row < rows; row++) {
        const int at[3] = {0, row % m, row / m};
        if (weft_planner_cancelled(e->planner))
            return WEFT_ERR_CANCELLED;
        fill_taps(e, (size_t)row * (size_t)m);
        measure_taps(e);
        for (int corner = 0; corner < 1 << e->info->dims; corner++)
            compare(e, at, corner);
        if (e->planner->p.kernel.prefiltered)
            compare_sampled(e, at);
    }
    e->largest += curvature(e);
    return WEFT_OK;
}

// ---- of prefiltered kernels ---------------------------------------------------------------------

// With cardinal weights, the samples' own: a weight at a place less that at its cell's sample is a
// sum of `dims` products in which one factor is a difference, of which each is convolved with the
// inverse filter along its own axis. Sums of |cardinal weights| of an axis, the largest in each of
// up to 2^BITS parts of a sample's width (in 3D 2^6, for time).
enum { BITS = 9, BITS_3D = 6, BINS = 1 << BITS };

struct cardinal {
    struct weft_prefilter prefilter;
    double filter[WEFT_PREFILTER_MAX_OVERLAP + 1];
    int overlap, bits;
    double difference[3][BINS], gain[3][BINS];
};

static double cardinal_sum(const struct cardinal *c, int width, const double *weights)
{
    double sum = 0.0;
    for (int k = -c->overlap; k < width + c->overlap; k++) {
        double weight = 0.0;
        for (int t = 0; t < width; t++)
            weight += abs(k - t) <= c->overlap ? weights[t] * c->filter[abs(k - t)] : 0.0;
        sum += fabs(weight);
    }
    // Images and volumes may cut their filter off nearer.
    for (int t = 0; t < width; t++)
        sum += 2.0 * WEFT_VOLUME_PREFILTER_ERROR * fabs(weights[t]);
    return sum;
}

// first + a second + b third, by tap.
static double cardinal_sum_of(const struct cardinal *c, int width, const double *first, double a,
                              const double *second, double b, const double *third)
{
    double weights[WEFT_KERNEL_MAX_WIDTH];
    for (int t = 0; t < width; t++)
        weights[t] = first[t] + a * second[t] + b * third[t];
    return cardinal_sum(c, width, weights);
}

static void fill_cardinal(const struct e2 *e, int axis, struct cardinal *c)
{
    const int m = e->info->samples, width = e->info->width;
    for (int k = 0; k < m; k++) {
        const axis_weights *w = &e->axis[axis][k];
        const double *sampled = (*w)[SAMPLED];
        double *difference = &c->difference[axis][((int64_t)k << c->bits) / m];
        double *gain = &c->gain[axis][((int64_t)k << c->bits) / m];
        // As of deviation().
        const double bend =
            2.0 * cardinal_sum_of(c, width, (*w)[MIDDLE], -0.5, (*w)[NEAR], -0.5, (*w)[FAR]);
        for (int side = NEAR; side <= FAR; side++) {
            const double *end = (*w)[side];
            const double sum = cardinal_sum_of(c, width, end, -1.0, sampled, 0.0, sampled);
            *difference = fmax(*difference, sum + bend);
            *gain = fmax(*gain, cardinal_sum(c, width, end) + bend);
        }
        *gain = fmax(*gain, cardinal_sum(c, width, sampled));
    }
}

// The weights' differences add up to 0, so that half the samples' range counts.
static double sampled_e2(const struct e2 *e, const struct cardinal *c)
{
    const int dims = e->info->dims, count = 1 << c->bits * dims, mask = (1 << c->bits) - 1;
    double largest = 0.0;
    for (int i = 0; i < count; i++) {
        double sum = 0.0;
        for (int a = 0; a < dims; a++) {
            double product = c->difference[a][i >> c->bits * a & mask];
            for (int b = 0; b < dims; b++)
                product *= b == a ? 1.0 : c->gain[b][i >> c->bits * b & mask];
            sum += product;
        }
        largest = fmax(largest, sum);
    }
    return 0.5 * largest;
}

static void find_cardinal(const struct e2 *e, struct weft_pass_plan_error *out)
{
    const struct weft_kernel *kernel = &e->planner->p.kernel;
    struct cardinal c = {.bits = e->info->dims < 3 ? BITS : BITS_3D};
    out->e2_quantised = out->e2_sampled = NAN;
    if (!kernel->prefiltered || weft_prefilter_compute(NULL, kernel, &c.prefilter) != WEFT_OK)
        return;
    c.overlap = weft_prefilter_overlap(&c.prefilter, 0x1p-32);
    weft_prefilter_taps(&c.prefilter, c.overlap, c.filter);
    for (int a = 0; a < e->info->dims; a++)
        fill_cardinal(e, a, &c);
    out->e2_quantised = e->quantised;
    out->e2_sampled = sampled_e2(e, &c);
}

// ---- both ---------------------------------------------------------------------------------------

// One block of memory for all that rows need.
static double *allocate_rows(struct e2 *e)
{
    const size_t m = (size_t)e->info->samples, width = (size_t)e->info->width;
    const size_t taps = (size_t)e->planner->plan->info.tap_count;
    const size_t axis = SIDES * WEFT_KERNEL_MAX_WIDTH;
    double *block = malloc((m * (3 * axis + SIDES * width + taps + 3) + taps) * sizeof *block);
    double *next = block;
    if (!block)
        return NULL;
    for (int a = 0; a < 3; a++, next += m * axis)
        e->axis[a] = (axis_weights *)next;
    for (int side = 0; side < SIDES; side++, next += m * width)
        e->side[side] = next;
    e->tap = next;
    e->value = e->tap + m * taps;
    e->sum[0] = e->value + m;
    e->sum[1] = e->sum[0] + m;
    e->exact = e->sum[1] + m;
    return block;
}

static void fill_sides(struct e2 *e)
{
    const int m = e->info->samples;
    for (int side = 0; side < SIDES; side++)
        for (int t = 0; t < e->info->width; t++)
            for (int k = 0; k < m; k++)
                e->side[side][t * m + k] = e->axis[0][k][side][t];
}

static enum weft_result find_e2(const struct weft_planner *planner,
                                struct weft_pass_plan_error *out, double *magnitude)
{
    struct e2 e = {.planner = planner, .info = weft_kernel_tiles_get_info(planner->plan->tiles)};
    e.radial = weft_kernel_is_radial(&planner->p.kernel, planner->p.dims);
    double *rows = allocate_rows(&e);
    if (!rows) {
        weft_error(planner->p.log, "plan: not enough memory for the error of %d taps",
                   planner->plan->info.tap_count);
        return WEFT_ERR_MEMORY;
    }
    enum weft_result res = fill_axes(&e);
    fill_sides(&e);
    if (res == WEFT_OK)
        res = compare_all(&e);
    out->e2 = e.largest;
    *magnitude = e.magnitude;
    if (res == WEFT_OK)
        find_cardinal(&e, out);
    free(rows);
    return res;
}

// ---- arithmetic ---------------------------------------------------------------------------------

// Of a slot, in codes: what roundings can add up to, and what clamping can lose.
struct slot_error {
    double rounding, clamping;
};

static int products_of(const struct weft_pass_list *list, const struct weft_pass *pass)
{
    int count = 0;
    for (int g = 0; g < pass->group_count; g++)
        for (int c = 0; c < 4; c++)
            count += list->groups[pass->group_first + g].tile[c] >= 0;
    return count;
}

static double taps_rounding(const struct weft_planner *planner, const struct weft_pass *pass,
                            double magnitude)
{
    const struct weft_pass_list *list = &planner->plan->list;
    const double inside = 0.5 / (1 << list->extra_bits);
    const int products = products_of(list, pass);
    if (planner->real) { // what is stored, what is added to it, and sums in single precision
        const bool half = list->target == WEFT_TARGET_HALF;
        return magnitude * (2.0 * (half ? 0x1p-10 : 0x1p-24) + (products + 2) * 0x1p-23) +
               (half ? 0x1p-23 : 0x1p-125);
    }
    if (pass->part == WEFT_PASS_LOW)
        return 0.0; // counted with the high part
    const bool sums = list->exact_inside && !planner->logarithms;
    const double store = pass->part == WEFT_PASS_WHOLE && list->extra_bits ? 0.5 : 0.0;
    return (sums ? 1 : products) * inside + store;
}

static void combine_errors(const struct weft_pass_list *list, const struct weft_pass *pass,
                           const struct slot_error *slots, struct slot_error *out)
{
    *out = (struct slot_error){0.5, 0.0};
    for (int i = 0; i < pass->input_count; i++) {
        const double share = fabs((double)pass->numerator[i]) / pass->denominator;
        out->rounding += share * slots[pass->input[i]].rounding;
        out->clamping += share * slots[pass->input[i]].clamping;
        if (!list->exact_inside)
            out->rounding += 0.5 / (1 << list->extra_bits);
    }
}

// An unclamped sum that is x beyond the range puts what is stored at most x off, however often it
// clamps: adding within a range does not widen a difference.
static enum weft_result find_e3(const struct weft_planner *planner, const struct weft_range *ranges,
                                double magnitude, struct slot_error *out)
{
    const struct weft_pass_list *list = &planner->plan->list;
    struct slot_error *slots = calloc((size_t)list->slot_count, sizeof *slots), combined;
    if (!slots) {
        weft_error(planner->p.log, "plan: not enough memory for %d targets", list->slot_count);
        return WEFT_ERR_MEMORY;
    }
    for (int n = 0; n < list->pass_count; n++) {
        const struct weft_pass *pass = &list->passes[n];
        const double beyond =
            planner->real ? 0.0 : fmax(0.0, fmax(-ranges[n].minimum, ranges[n].maximum - 1.0));
        struct slot_error *slot = &slots[pass->target];
        if (pass->kind == WEFT_PASS_COMBINE) {
            combine_errors(list, pass, slots, &combined);
            *slot = combined;
            slot->clamping += beyond * planner->full;
            continue;
        }
        if (pass->clears)
            *slot = (struct slot_error){0.0, 0.0};
        slot->rounding += taps_rounding(planner, pass, magnitude);
        slot->clamping = fmax(slot->clamping, beyond * planner->full);
    }
    *out = slots[list->result];
    free(slots);
    return WEFT_OK;
}

static double source_error(const struct weft_planner *planner)
{
    if (planner->real)
        return planner->p.profile.target == WEFT_TARGET_HALF ? 0x1p-12 : 0x1p-24;
    if (!planner->logarithms)
        return 0.5 / planner->full;
    const double octaves = planner->plan->list.log_octaves;
    return fmax(exp2(0.5 * octaves / (planner->full - 1)) - 1.0, exp2(-octaves));
}

// Results are at most what exact weights make of the values, and the error.
static void set_terms(struct weft_pass_plan_info *info, double magnitude)
{
    const struct weft_pass_plan_error *e = &info->error;
    info->bound = (struct weft_bound_terms){
        .source = e->source,
        .e2 = e->e2,
        .e3 = e->e3,
        .clamp = e->bound_any - e->source - e->e2 - e->e3,
        .e2_quantised = info->kernel.prefiltered ? e->e2_quantised : 0.0,
        .e2_sampled = info->kernel.prefiltered ? e->e2_sampled : 0.0,
        .rounded_gain = magnitude + e->e2,
        .prefilter = weft_prefilter_error(&info->kernel, info->dims, WEFT_VOLUME_PREFILTER_ERROR),
    };
}

enum weft_result weft_planner_find_error(struct weft_planner *planner)
{
    struct weft_pass_plan *plan = planner->plan;
    const double unit = 1.0 / (planner->full * plan->list.result_scale);
    struct weft_pass_plan_error *error = &plan->info.error;
    const struct weft_progress watch = weft_planner_watch(planner);
    struct slot_error declared = {0}, any = {0};
    struct weft_range_report report;
    double magnitude = 0.0;
    struct weft_range *ranges = calloc((size_t)plan->list.pass_count + 1, sizeof *ranges);
    enum weft_result res = WEFT_ERR_MEMORY;
    if (ranges)
        res = find_e2(planner, error, &magnitude);
    else
        weft_error(planner->p.log, "plan: not enough memory for %d ranges", plan->list.pass_count);
    if (res == WEFT_OK)
        res = weft_range_simulate(planner->p.log, &plan->list, WEFT_WORST_ANY, &watch, ranges,
                                  &report);
    if (res == WEFT_OK)
        res = find_e3(planner, ranges, magnitude, &any);
    if (res == WEFT_OK)
        res = find_e3(planner, plan->ranges, magnitude, &declared);
    free(ranges);
    if (res != WEFT_OK)
        return res;
    error->source = source_error(planner) * magnitude;
    error->e3 = any.rounding * unit;
    error->clamp = any.clamping * unit;
    error->bound = error->source + error->e2 + error->e3 + declared.clamping * unit;
    error->bound_any = fmax(error->bound, error->source + error->e2 + error->e3 + error->clamp);
    set_terms(&plan->info, magnitude);
    return WEFT_OK;
}
