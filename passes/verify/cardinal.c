// SPDX-License-Identifier: BSD-3-Clause
#include "passes/verify/cardinal.h"

#include <math.h>
#include <stdlib.h>

#include "filter/kernels/prefilter.h"
#include "tiles/volume/region.h"

enum { MAX_BRICKS = 1 << 15 }; // kept between positions
// Products of two axes' weights below this change nothing that single precision shows.
static const double NEGLIGIBLE = 1e-13;
struct weft_slice_samples {
    const struct weft_log *log;
    const struct weft_slice_plan *plan;
    struct weft_kernel kernel;
    struct weft_prefilter prefilter;
    int overlap, near;
    double negligible;
    double gain[WEFT_LINE_ORDERS]; // largest sums of |weights| of the plain kernel, by order
    struct weft_brick_list topology;
    weft_brick_store *store; // of the topology
    struct weft_cell_map map;
    float *values, *largest; // by number: voxels, and their largest finite magnitude
    size_t capacity;
};

void weft_slice_samples_destroy(weft_slice_samples **samples)
{
    if (!samples || !*samples)
        return;
    weft_brick_list_clear(&(*samples)->topology);
    weft_brick_store_destroy(&(*samples)->store);
    weft_cell_map_destroy(&(*samples)->map);
    free((*samples)->values);
    free((*samples)->largest);
    free(*samples);
    *samples = NULL;
}

// What is left out past an overlap is to be no more than some 2^-30 of the largest voxel at the
// taps: of all voxels what lies farther from some of the taps, and all of the shells from there on.
static void set_overlap(weft_slice_samples *s, const struct weft_slice_statistics *statistics,
                        const struct weft_slice_shells *shells)
{
    double largest = fmax(fabs(statistics->voxel_low), fabs(statistics->voxel_high)), rest = 0.0;
    int count = 1;
    for (int i = WEFT_SLICE_SHELLS - 1; i >= 1; i--)
        rest = WEFT_SLICE_SHELL_FALL * (shells->largest[i] + rest);
    largest = fmax(largest, shells->largest[0]);
    for (; count < WEFT_SLICE_SHELLS; count++) {
        // Both in units of the fall so far.
        const double fall = pow(WEFT_SLICE_SHELL_FALL, count - 1);
        if (fall * (WEFT_SLICE_SHELL_FALL * largest + rest) <=
            4.0 * WEFT_SLICE_SHELL_FALL * shells->at_taps)
            break;
        rest = rest / WEFT_SLICE_SHELL_FALL - shells->largest[count];
        largest = fmax(largest, shells->largest[count]);
    }
    s->overlap = shells->overlap[count];
    s->near = shells->overlap[1];
    s->negligible = largest > 0.0 ? NEGLIGIBLE * shells->at_taps / largest : NEGLIGIBLE;
}

enum weft_result weft_slice_samples_create(const struct weft_slice_plan *plan,
                                           const struct weft_slice_statistics *statistics,
                                           const struct weft_slice_shells *shells,
                                           weft_slice_samples **out)
{
    weft_volume *volume = plan->footprint->samples;
    enum weft_result res = WEFT_ERR_MEMORY;
    weft_slice_samples *s = calloc(1, sizeof *s);
    *out = NULL;
    if (!s) {
        weft_error(plan->log, "not enough memory to verify the slice");
        goto fail;
    }
    s->log = plan->log;
    s->plan = plan;
    s->kernel = plan->info.kernel;
    res = weft_prefilter_compute(plan->log, &s->kernel, &s->prefilter);
    if (res != WEFT_OK)
        goto fail;
    set_overlap(s, statistics, shells);
    for (int n = 0; n < WEFT_LINE_ORDERS; n++)
        if (plan->kernels[n])
            s->gain[n] = weft_kernel_facts_compute(plan->kernels[n])->gain;
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    struct weft_region region;
    weft_slice_grid_region(&plan->footprint->grid, s->kernel.width, &region);
    region = weft_region_widen(&region, s->overlap);
    if (info->clamp_to_edge)
        weft_region_clamp(info, &region);
    res = weft_volume_find(volume, &region, &s->topology);
    if (res == WEFT_OK)
        res = weft_brick_places_create(plan->log, info, &s->topology, &s->store);
    if (res != WEFT_OK)
        goto fail;
    *out = s;
    return WEFT_OK;
fail:
    weft_slice_samples_destroy(&s);
    return res;
}

double weft_slice_samples_seconds(const weft_slice_samples *samples)
{
    const double side = samples->kernel.width + 2 * samples->overlap;
    return 1.5e-9 * side * side * side;
}

// ---- one position -------------------------------------------------------------------------------

static float find_largest(const float *values)
{
    float largest = 0.0f;
    for (int i = 0; i < WEFT_BRICK_VOXELS; i++)
        if (isfinite(values[i]) && fabsf(values[i]) > largest)
            largest = fabsf(values[i]);
    return largest;
}

// Reads the bricks of the map from number `known` on.
static enum weft_result read_bricks(weft_slice_samples *s, size_t known)
{
    const size_t count = s->map.count - known;
    enum weft_result res = WEFT_ERR_MEMORY;
    int32_t(*origin)[3] = malloc(count * sizeof *origin + 1);
    if (origin && s->map.count > s->capacity) {
        const size_t capacity = 2 * s->map.count;
        float *values = realloc(s->values, capacity * WEFT_BRICK_VOXELS * sizeof *values);
        s->values = values ? values : s->values;
        float *largest = realloc(s->largest, capacity * sizeof *largest);
        s->largest = largest ? largest : s->largest;
        s->capacity = values && largest ? capacity : s->capacity;
    }
    if (!origin || s->map.count > s->capacity) {
        weft_error(s->log, "not enough memory for %zu bricks", s->map.count);
        goto fail;
    }
    for (size_t i = 0; i < count; i++)
        for (int a = 0; a < 3; a++)
            origin[i][a] = s->map.keys[known + i].at[a] * WEFT_BRICK_SIZE;
    res = weft_footprint_read_samples(s->plan->footprint, count, (const int32_t(*)[3])origin,
                                      s->values + known * WEFT_BRICK_VOXELS);
    for (size_t i = known; res == WEFT_OK && i < s->map.count; i++)
        s->largest[i] = find_largest(s->values + i * WEFT_BRICK_VOXELS);
fail:
    free(origin);
    return res;
}

// Of missing voxels: how much the result depends on them, and at most a coefficient in reach.
struct sum {
    const struct weft_prefilter_axis *axis;
    double negligible;
    int64_t near_low[3], near_high[3]; // voxels whose magnitude counts
    double total, magnitude, depends, reaches;
};

static int64_t clamp(int64_t x, int64_t low, int64_t high)
{
    return x < low ? low : x > high ? high : x;
}

static void set_axis(const weft_slice_samples *s, int a, int order, double position,
                     struct sum *sum, struct weft_prefilter_axis *out)
{
    const struct weft_volume_info *info = weft_volume_get_info(s->plan->footprint->samples);
    const int32_t low = info->clamp_to_edge ? info->active_min[a] : INT32_MIN;
    const int32_t high = info->clamp_to_edge ? info->active_max[a] : INT32_MAX;
    double fraction;
    const int64_t first = weft_kernel_first_tap(&s->kernel, position, &fraction);
    weft_prefilter_axis_set(&s->prefilter, &s->plan->kernels[order]->kernel, s->overlap, position,
                            low, high, out);
    sum->near_low[a] = clamp(first - s->near, low, high);
    sum->near_high[a] = clamp(first + s->kernel.width - 1 + s->near, low, high);
}

static bool is_near(const struct sum *sum, const int32_t origin[3])
{
    bool near = true;
    for (int a = 0; a < 3; a++)
        near = near && origin[a] <= sum->near_high[a] &&
               origin[a] + (WEFT_BRICK_SIZE - 1) >= sum->near_low[a];
    return near;
}

// A brick's voxels from low to high (0 to 7) along each axis.
static void add_voxels(struct sum *sum, const int32_t origin[3], const int low[3],
                       const int high[3], const float *values)
{
    const struct weft_prefilter_axis *axis = sum->axis;
    for (int z = low[2]; z <= high[2]; z++) {
        for (int y = low[1]; y <= high[1]; y++) {
            const int64_t at_y = origin[1] + y - axis[1].first;
            const int64_t at_z = origin[2] + z - axis[2].first;
            const double across = axis[2].weight[at_z] * axis[1].weight[at_y];
            const double reach = axis[2].reach[at_z] * axis[1].reach[at_y];
            if (fabs(across) < sum->negligible && reach < sum->negligible)
                continue;
            double row = 0.0;
            for (int x = low[0]; x <= high[0]; x++) {
                const float voxel = values[z * 64 + y * 8 + x];
                const int64_t at_x = origin[0] + x - axis[0].first;
                if (isfinite(voxel)) {
                    row += axis[0].weight[at_x] * (double)voxel;
                    continue;
                }
                sum->depends += fabs(across * axis[0].weight[at_x]);
                sum->reaches += reach * axis[0].reach[at_x];
            }
            sum->total += across * row;
        }
    }
}

static void add_brick(struct sum *sum, const struct weft_cell_key *key, const float *values,
                      float constant)
{
    float filled[WEFT_BRICK_VOXELS];
    int32_t origin[3];
    int low[3], high[3];
    double product = 1.0;
    for (int a = 0; a < 3; a++) {
        const struct weft_prefilter_axis *axis = &sum->axis[a];
        origin[a] = key->at[a] * WEFT_BRICK_SIZE;
        low[a] = axis->first > origin[a] ? (int)(axis->first - origin[a]) : 0;
        high[a] = (int)(axis->first + axis->count - 1 - origin[a]);
        high[a] = high[a] < WEFT_BRICK_SIZE - 1 ? high[a] : WEFT_BRICK_SIZE - 1;
        double weights = 0.0;
        for (int i = low[a]; i <= high[a]; i++)
            weights += axis->weight[origin[a] + i - axis->first];
        product *= weights;
    }
    if (!values && isfinite(constant)) {
        sum->total += product * (double)constant;
        if (is_near(sum, origin))
            sum->magnitude = fmax(sum->magnitude, fabs((double)constant));
        return;
    }
    for (int i = 0; i < WEFT_BRICK_VOXELS && !values; i++)
        filled[i] = constant;
    add_voxels(sum, origin, low, high, values ? values : filled);
}

// One round notes the bricks that are not there yet, another one adds all of them up.
static enum weft_result visit_bricks(weft_slice_samples *s, struct sum *sum, bool add)
{
    struct weft_cell_key from, to, at;
    for (int a = 0; a < 3; a++) {
        from.at[a] = (int32_t)(sum->axis[a].first >> 3);
        to.at[a] = (int32_t)((sum->axis[a].first + sum->axis[a].count - 1) >> 3);
    }
    for (at.at[2] = from.at[2]; at.at[2] <= to.at[2]; at.at[2]++) {
        for (at.at[1] = from.at[1]; at.at[1] <= to.at[1]; at.at[1]++) {
            for (at.at[0] = from.at[0]; at.at[0] <= to.at[0]; at.at[0]++) {
                const int32_t origin[3] = {at.at[0] * 8, at.at[1] * 8, at.at[2] * 8};
                const float *values;
                float constant;
                const bool there = weft_brick_store_find(s->store, origin, &values, &constant) ==
                                   WEFT_BRICK_VALUES;
                const int64_t number = there ? weft_cell_map_add(&s->map, at) : 0;
                if (number == WEFT_CELL_NONE) {
                    weft_error(s->log, "not enough memory for %zu bricks", s->map.count);
                    return WEFT_ERR_MEMORY;
                }
                if (!add)
                    continue;
                if (there && is_near(sum, origin))
                    sum->magnitude = fmax(sum->magnitude, (double)s->largest[number]);
                add_brick(sum, &at, there ? s->values + (size_t)number * WEFT_BRICK_VOXELS : NULL,
                          constant);
            }
        }
    }
    return WEFT_OK;
}

enum weft_result weft_slice_samples_compute(weft_slice_samples *samples,
                                            const struct weft_derivative *derivative,
                                            const double position[3], bool finite,
                                            struct weft_reference_value *out)
{
    struct weft_prefilter_axis axis[3];
    struct sum sum = {.axis = axis, .negligible = samples->negligible};
    double whole = 1.0; // largest sum of the plain kernel's |weights|
    for (int a = 0; a < 3; a++) {
        set_axis(samples, a, derivative->along[a], position[a], &sum, &axis[a]);
        whole *= samples->gain[derivative->along[a]];
    }
    if (samples->map.count >= MAX_BRICKS)
        weft_cell_map_destroy(&samples->map);
    const size_t known = samples->map.count;
    enum weft_result res = visit_bricks(samples, &sum, false);
    if (res == WEFT_OK && samples->map.count > known)
        res = read_bricks(samples, known);
    if (res == WEFT_OK)
        res = visit_bricks(samples, &sum, true);
    else
        weft_cell_map_destroy(&samples->map); // it names bricks that were not read
    const bool missing = weft_prefilter_is_missing(sum.depends, sum.reaches, whole, finite);
    *out = (struct weft_reference_value){
        .value = missing ? (double)NAN : sum.total,
        .magnitude = sum.magnitude,
    };
    return res;
}
