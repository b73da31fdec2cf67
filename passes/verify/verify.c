// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>
#include <stdlib.h>

#include "filter/analysis/reference.h"
#include "passes/verify/pixel_error.h"
#include "passes/verify/cardinal.h"

static const double DEFAULT_SECONDS = 10.0;

// Relative errors below this need no second look.
static const double CLOSE = 1e-6;

struct verifier {
    const struct weft_slice_plan *plan;
    weft_volume *volume;
    const struct weft_slice_verify_params *params;
    const float *pixels;
    struct weft_brick_cursor cursor;
    weft_footprint *rest; // of what floats lack, where it is verified
    struct weft_brick_cursor rest_cursor;
    weft_slice_samples *samples; // of prefiltered kernels, in place of the cursor
    enum weft_result failure;    // of reading them
    double square_sum;
    double share; // of pixels to check, 1 = all
    uint64_t timed_pixels;
    double started;
    struct weft_slice_error error;
};

// Planes that have no weight are not read, whatever they hold.
static double fetch(void *priv, const int64_t index[3])
{
    struct verifier *v = priv;
    const struct weft_slice_axes *axes = &v->plan->axes;
    const int64_t plane = axes->summed ? index[axes->order[2]] - axes->plane : 0;
    if (axes->summed && (plane < 0 || plane >= axes->kept))
        return 0.0;
    const int32_t x = (int32_t)index[0], y = (int32_t)index[1], z = (int32_t)index[2];
    const double value = weft_brick_cursor_voxel(&v->cursor, x, y, z);
    return v->rest ? value + weft_brick_cursor_voxel(&v->rest_cursor, x, y, z) : value;
}

// Clamps the reference as the plan does: to the samples next to the position.
static void clamp_reference(struct verifier *v, const double position[3],
                            struct weft_reference_value *reference)
{
    const struct weft_kernel *kernel = &v->plan->info.kernel;
    const int middle = (kernel->width - 1) / 2, odd = kernel->width % 2;
    int64_t from[3], at[3];
    double fraction, low = INFINITY, high = -INFINITY;
    for (int a = 0; a < 3; a++)
        from[a] = weft_kernel_first_tap(kernel, position[a], &fraction) + middle - odd;
    for (int i = 0; i < (odd ? 27 : 8); i++) {
        const int side = odd ? 3 : 2;
        at[0] = from[0] + i % side;
        at[1] = from[1] + i / side % side;
        at[2] = from[2] + i / (side * side);
        const double sample = fetch(v, at);
        low = fmin(low, sample);
        high = fmax(high, sample);
    }
    if (isfinite(reference->value))
        reference->value = fmin(fmax(reference->value, low), high);
}

static struct weft_reference_value refer_at(struct verifier *v, const double position[3],
                                            bool finite)
{
    struct weft_reference_value reference = {NAN, 0.0};
    if (v->samples && v->failure == WEFT_OK)
        v->failure = weft_slice_samples_compute(v->samples, position, finite, &reference);
    if (v->samples)
        return reference;
    reference = weft_reference_compute(&v->plan->info.kernel, 3, position, fetch, v);
    if (v->plan->clamp_to_samples && v->plan->info.kernel.width > 1)
        clamp_reference(v, position, &reference);
    return reference;
}

// A fixed random number in [0, 1) for every pixel (splitmix64 of its coordinates).
static double pixel_random(int x, int y)
{
    uint64_t h = (uint64_t)(uint32_t)y << 32 | (uint32_t)x;
    h += UINT64_C(0x9e3779b97f4a7c15);
    h = (h ^ h >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    h = (h ^ h >> 27) * UINT64_C(0x94d049bb133111eb);
    h ^= h >> 31;
    return (double)(h >> 11) * 0x1p-53;
}

// Infinite where one is finite and the other is not.
static double difference(float value, double reference)
{
    bool mismatch;
    const double error = weft_pixel_error(value, reference, &mismatch);
    return mismatch ? INFINITY : isnan(error) ? 0.0 : error;
}

// The reference at a pixel. Where that is not close, engines may have its position rounded the
// other way, onto the other side of a cell's border: then the largest |voxel| on either side
// counts, and where the kernel jumps, or what counts is not finite, the side that comes closer.
static struct weft_reference_value refer(struct verifier *v, int x, int y, float value)
{
    const struct weft_kernel *kernel = &v->plan->info.kernel;
    double position[3];
    weft_slice_grid_position(&v->plan->footprint->grid, x, y, NULL, position);
    struct weft_reference_value best = refer_at(v, position, isfinite(value));
    if (difference(value, best.value) <= CLOSE * best.magnitude)
        return best;
    const bool jumps =
        kernel->continuity < 0 || v->plan->clamp_to_samples || isinf(difference(value, best.value));
    if (v->samples && !jumps) // they reach farther than one voxel more
        return best;
    // Jumps inside a tile are met by fractions of 24 bits, times a number of segments.
    const double margin = fmax(weft_slice_grid_margin(&v->plan->footprint->grid, position),
                               kernel->continuity < 0 ? 0x1p-23 : 0.0);
    for (int corner = 0; corner < 8; corner++) {
        double moved[3], at[3];
        for (int a = 0; a < 3; a++)
            moved[a] = corner >> a & 1 ? margin : -margin;
        weft_slice_grid_position(&v->plan->footprint->grid, x, y, moved, at);
        struct weft_reference_value other = refer_at(v, at, isfinite(value));
        best.magnitude = fmax(best.magnitude, other.magnitude);
        if (jumps && difference(value, other.value) < difference(value, best.value))
            best.value = other.value;
    }
    return best;
}

static void check_pixel(struct verifier *v, int x, int y)
{
    struct weft_slice_error *e = &v->error;
    const float value =
        v->pixels[(size_t)y * (size_t)v->plan->footprint->grid.index.width + (size_t)x];
    const struct weft_reference_value reference = refer(v, x, y, value);
    bool mismatch;
    const double error = weft_pixel_error(value, reference.value, &mismatch);
    e->pixels_checked++;
    e->not_finite_mismatches += mismatch;
    if (isnan(error))
        return;
    v->square_sum += error * error;
    e->magnitude = fmax(e->magnitude, reference.magnitude);
    if (reference.magnitude > 0.0)
        e->relative_maximum = fmax(e->relative_maximum, error / reference.magnitude);
    else if (error > 0.0)
        e->relative_maximum = INFINITY;
    if (error > e->maximum || e->pixels_checked == 1) {
        e->maximum = error;
        e->at_x = x;
        e->at_y = y;
        e->at_value = value;
        e->at_reference = reference.value;
    }
}

static double time_limit(const struct verifier *v)
{
    return v->params->max_seconds > 0.0 ? v->params->max_seconds : DEFAULT_SECONDS;
}

// After the first pixels, how many of the rest can be afforded.
static void set_share(struct verifier *v)
{
    enum { TIMED_PIXELS = 20000 };
    if (v->samples || v->timed_pixels++ != TIMED_PIXELS)
        return;
    double limit = time_limit(v);
    double each = (weft_now_seconds() - v->started) / TIMED_PIXELS;
    v->share = fmin(1.0, limit / (each * (double)v->error.pixels_total));
}

static bool go_on(const struct verifier *v, double fraction)
{
    const struct weft_progress *progress = v->params->progress;
    return !progress || !progress->report || progress->report(progress->priv, fraction);
}

static enum weft_result check_tile(struct verifier *v, int index)
{
    const struct weft_slice_tile *tile = &v->plan->tiles[index];
    // Samples are read as they are needed.
    static const struct weft_cell_map none;
    const struct weft_cell_map *bricks = v->samples ? &none : &v->plan->tile_plans[index].bricks;
    const weft_brick_store *store = NULL, *rest = NULL;
    enum weft_result res = weft_footprint_load(v->plan->footprint, bricks, 0, &store);
    if (res == WEFT_OK && v->rest)
        res = weft_footprint_load(v->rest, bricks, 0, &rest);
    if (res != WEFT_OK)
        return res;
    v->cursor = (struct weft_brick_cursor){.store = store};
    v->rest_cursor = (struct weft_brick_cursor){.store = rest};
    for (int y = tile->y; y < tile->y + tile->height; y++) {
        double rows = (double)(y - tile->y) / tile->height;
        if (!go_on(v, (index + rows) / v->plan->info.tile_count))
            res = WEFT_ERR_CANCELLED;
        if (res == WEFT_OK)
            res = v->failure;
        if (res != WEFT_OK)
            return res;
        for (int x = tile->x; x < tile->x + tile->width; x++) {
            if (v->share >= 1.0 || pixel_random(x, y) < v->share) {
                check_pixel(v, x, y);
                set_share(v);
            }
        }
    }
    return WEFT_OK;
}

// What prefiltered kernels are verified against: how far voxels count, and the bound of all.
static enum weft_result set_samples(struct verifier *v)
{
    const weft_footprint *footprint = v->plan->footprint;
    enum weft_result res = weft_footprint_measure(v->plan->footprint, v->params->progress);
    if (res == WEFT_OK)
        res = weft_slice_samples_create(v->plan, v->volume, &footprint->statistics,
                                        &footprint->shells, &v->samples);
    if (res != WEFT_OK)
        return res;
    const struct weft_slice_statistics *statistics = &footprint->statistics;
    const struct weft_bound_values values = {.low = statistics->low,
                                             .high = statistics->high,
                                             .sample_low = statistics->voxel_low,
                                             .sample_high = statistics->voxel_high,
                                             .beyond = statistics->beyond};
    v->error.bound = weft_bound_compute(&v->plan->info.bound, &values).total;
    v->share =
        time_limit(v) / (weft_slice_samples_seconds(v->samples) * (double)v->error.pixels_total);
    return res;
}

enum weft_result weft_slice_verify(const weft_slice_plan *plan, weft_volume *volume,
                                   const float *pixels,
                                   const struct weft_slice_verify_params *params,
                                   struct weft_slice_error *out)
{
    static const struct weft_slice_verify_params defaults;
    const struct weft_slice_geometry *g = &plan->footprint->grid.index;
    struct verifier v = {
        .plan = plan,
        .volume = volume,
        .params = params ? params : &defaults,
        .pixels = pixels,
        .share = 1.0,
        .error = {.pixels_total = (uint64_t)g->width * (uint64_t)g->height},
    };
    enum weft_result res = WEFT_OK;
    v.started = weft_now_seconds();
    if (plan->info.kernel.prefiltered)
        res = set_samples(&v);
    else if (v.params->rest)
        res = weft_footprint_create(
            weft_footprint_params(.volume = v.params->rest, .kernel = plan->info.kernel,
                                  .space = plan->info.space, .geometry = plan->info.geometry,
                                  .log = plan->log),
            &v.rest);
    for (int i = 0; res == WEFT_OK && i < plan->info.tile_count; i++)
        res = check_tile(&v, i);
    res = res == WEFT_OK ? v.failure : res;
    weft_footprint_destroy(&v.rest);
    weft_slice_samples_destroy(&v.samples);
    if (res != WEFT_OK)
        return res;
    const double m = v.error.magnitude;
    const struct weft_bound_values values = {-m, m, -m, m, 0.0, 0.0};
    if (!plan->info.kernel.prefiltered)
        v.error.bound = weft_bound_compute(&plan->info.bound, &values).total;
    v.error.rms = v.error.pixels_checked ? sqrt(v.square_sum / (double)v.error.pixels_checked) : 0;
    *out = v.error;
    return WEFT_OK;
}
