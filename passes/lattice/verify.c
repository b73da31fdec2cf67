// SPDX-License-Identifier: BSD-3-Clause
// Voxels that come out beside sums over all taps: positions and weights are found anew.
#include <stdlib.h>
#include <string.h>

#include "passes/lattice/lattice_impl.h"

// splitmix64 (Steele, Lea and Flood, OOPSLA 2014).
static uint64_t mix(uint64_t x)
{
    x += UINT64_C(0x9e3779b97f4a7c15);
    x = (x ^ x >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    x = (x ^ x >> 27) * UINT64_C(0x94d049bb133111eb);
    return x ^ x >> 31;
}

static bool is_chosen(const struct weft_lattice_verify *how, const int64_t r[3])
{
    const uint64_t hash =
        mix(mix(mix(mix(how->seed) ^ (uint64_t)r[0]) ^ (uint64_t)r[1]) ^ (uint64_t)r[2]);
    return (double)(hash >> 11) * 0x1p-53 < how->share;
}

// The weights of one voxel, of every order along every axis of the source.
struct taps {
    int64_t first[3];
    double *weight[3][WEFT_LATTICE_ORDERS];
    double *room;
};

static bool make_taps(const struct weft_lattice_plan *plan, struct taps *out)
{
    size_t count = 0, at = 0;
    for (int a = 0; a < 3; a++)
        count += WEFT_LATTICE_ORDERS * (size_t)plan->info.width[a];
    out->room = malloc(count * sizeof *out->room);
    for (int a = 0; out->room && a < 3; a++)
        for (int order = 0; order < WEFT_LATTICE_ORDERS; order++) {
            out->weight[a][order] = out->room + at;
            at += (size_t)plan->info.width[a];
        }
    return out->room != NULL;
}

static void weigh(const struct weft_lattice_plan *plan, const int64_t r[3], struct taps *out)
{
    const struct weft_lattice_info *info = &plan->info;
    for (int a = 0; a < 3; a++)
        for (int order = 0; order < WEFT_LATTICE_ORDERS && plan->kernel[order].info; order++)
            out->first[a] =
                weft_stretch_weights(&plan->kernel[order], info->stretch[a],
                                     weft_lattice_at(info->to_source[a], r), out->weight[a][order]);
}

// Neumaier's compensated sum (1974).
struct sum {
    double value, rest;
};
static void add(struct sum *sum, double term)
{
    const double total = sum->value + term;
    sum->rest +=
        fabs(sum->value) >= fabs(term) ? (sum->value - total) + term : (term - total) + sum->value;
    sum->value = total;
}

static struct weft_reference_value refer(const struct weft_lattice_work *work,
                                         const struct taps *taps,
                                         const struct weft_derivative *derivative)
{
    const struct weft_lattice_plan *plan = work->plan;
    const int64_t *width = plan->info.width;
    struct weft_brick_cursor cursor = {.store = plan->reader.store ? plan->reader.store
                                                                   : plan->reader.places};
    struct sum sum = {0.0, 0.0};
    double magnitude = 0.0;
    bool bad = false;
    for (int64_t z = 0; z < width[2]; z++)
        for (int64_t y = 0; y < width[1]; y++)
            for (int64_t x = 0; x < width[0]; x++) {
                const double weight = taps->weight[0][derivative->along[0]][x] *
                                      taps->weight[1][derivative->along[1]][y] *
                                      taps->weight[2][derivative->along[2]][z];
                if (weight == 0.0)
                    continue;
                const double value = (double)weft_brick_cursor_voxel(
                    &cursor, (int32_t)(taps->first[0] + x), (int32_t)(taps->first[1] + y),
                    (int32_t)(taps->first[2] + z));
                bad |= !isfinite(value);
                magnitude = isfinite(value) ? fmax(magnitude, fabs(value)) : magnitude;
                add(&sum, weight * value);
            }
    return (struct weft_reference_value){bad ? NAN : sum.value + sum.rest, magnitude};
}

// What finishing makes of a reference: where pruning may have gone either way, it went right.
static double finish_reference(const struct weft_lattice_plan *plan, int grid, double reference,
                               double value, double bound)
{
    const struct weft_lattice_grid *out = &plan->info.grid[grid];
    const double background = (double)out->grid.background;
    if (out->quantity == WEFT_QUANTITY_VALUE && plan->info.clamps) {
        const double most = fabs(background);
        reference = fmin(fmax(reference, -most), most);
        if (fabs(value) == most && fabs(reference) >= most - plan->prune - bound)
            return value * reference < 0.0 ? reference : value;
        return reference;
    }
    if (value == background && fabs(reference - background) <= plan->prune + bound &&
        plan->prune > 0.0)
        return value;
    return reference;
}

static void verify_voxel(const struct weft_lattice_work *work, const struct taps *taps, int grid,
                         const int64_t r[3], const float *value, struct weft_lattice_checked *out)
{
    const struct weft_lattice_plan *plan = work->plan;
    const struct weft_lattice_info *info = &plan->info;
    const struct weft_lattice_grid *of = &info->grid[grid];
    struct weft_reference_value reference[WEFT_DERIVATIVES];
    double exact[WEFT_DERIVATIVES], error[WEFT_DERIVATIVES];
    double channel[WEFT_QUANTITY_CHANNELS], bound[WEFT_QUANTITY_CHANNELS];
    for (int d = 0; d < info->derivative_count; d++) {
        reference[d] = refer(work, taps, &info->derivative[d]);
        exact[d] = reference[d].value;
        error[d] = info->bound[d].relative * reference[d].magnitude +
                   fabs(reference[d].value) * 0x1p-23 + info->bound[d].absolute;
    }
    if (plan->plain) {
        channel[0] = exact[0];
        bound[0] = error[0];
    } else {
        weft_quantities_compute(&plan->quantities, &plan->transform, exact, channel);
        weft_quantities_bound(&plan->quantities, &plan->transform, exact, error, bound);
    }
    for (int c = 0; c < of->components; c++) {
        const int at = of->channel + c;
        const double own = bound[at] + fabs(channel[at]) * 0x1p-24;
        const double before = out->report.maximum;
        struct weft_reference_value wanted = {
            finish_reference(plan, grid, channel[at], (double)value[c * WEFT_BRICK_VOXELS], own),
            reference[0].magnitude};
        out->report.bound_absolute = own;
        weft_verify_add(&out->report, 0, 0, at, (double)value[c * WEFT_BRICK_VOXELS], &wanted);
        for (int a = 0; out->report.maximum > before && a < 3; a++)
            out->at[a] = (int32_t)r[a];
    }
    out->report.pixels_checked++;
}

bool weft_lattice_verify_brick(const struct weft_lattice_work *work,
                               const struct weft_lattice_verify *how, int grid,
                               const int32_t origin[3], const float *values,
                               struct weft_lattice_checked *out)
{
    struct taps taps = {.room = NULL};
    if (how->share <= 0.0)
        return true;
    if (!make_taps(work->plan, &taps))
        return false;
    for (int v = 0; v < WEFT_BRICK_VOXELS; v++) {
        const int64_t r[3] = {(int64_t)origin[0] + (v & 7), (int64_t)origin[1] + (v >> 3 & 7),
                              (int64_t)origin[2] + (v >> 6)};
        if (!weft_lattice_is_made(work->plan, r) || !is_chosen(how, r))
            continue;
        weigh(work->plan, r, &taps);
        verify_voxel(work, &taps, grid, r, values + v, out);
    }
    free(taps.room);
    out->report.pixels_total += WEFT_BRICK_VOXELS;
    return true;
}
