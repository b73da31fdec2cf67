// SPDX-License-Identifier: BSD-3-Clause
// Slices for the verifier: a plan's positions, a volume's voxels.
#include <math.h>

#include "passes/verify/cardinal.h"
#include "passes/verify/verifier.h"

struct subject {
    const struct weft_slice_plan *plan;
    const struct weft_slice_output *output;       // that is verified now
    struct weft_kernel kernel[3];                 // its own, along each axis
    const float *pixels;                          // its plane
    weft_footprint *rest;                         // of what floats lack, where it is verified
    weft_slice_samples *samples;                  // of prefiltered kernels, in place of the cursors
    struct weft_brick_cursor cursor, rest_cursor; // of a tile's voxels
};

// ---- positions and pixels -----------------------------------------------------------------------

static void position(void *priv, int x, int y, const double moved[3], double out[3])
{
    const struct subject *s = priv;
    weft_slice_grid_position(&s->plan->footprint->grid, x, y, moved, out);
}

static bool derives(const struct subject *s)
{
    const int *along = s->output->derivative.along;
    return along[0] + along[1] + along[2] > 0;
}

static bool jumps(const struct subject *s)
{
    return s->kernel[0].continuity < 0 || s->kernel[1].continuity < 0 ||
           s->kernel[2].continuity < 0;
}

static double margin(void *priv, const double at[3])
{
    const struct subject *s = priv;
    // Jumps inside a tile are met by fractions of 24 bits, times a number of segments.
    return fmax(weft_slice_grid_margin(&s->plan->footprint->grid, at), jumps(s) ? 0x1p-23 : 0.0);
}

static double pixel(void *priv, int channel, int x, int y)
{
    const struct subject *s = priv;
    (void)channel;
    const struct weft_rectangle *part = &s->plan->info.part;
    return (double)s->pixels[(size_t)(y - part->y) * (size_t)part->width + (size_t)(x - part->x)];
}

// ---- references ---------------------------------------------------------------------------------

// Planes that have no weight are not read, whatever they hold.
static double fetch(void *priv, const int64_t index[3])
{
    struct subject *s = priv;
    const struct weft_slice_axes *axes = &s->plan->axes;
    const int64_t plane = axes->summed ? index[axes->order[2]] - axes->plane : 0;
    if (axes->summed && (plane < 0 || plane >= axes->kept))
        return 0.0;
    const int32_t x = (int32_t)index[0], y = (int32_t)index[1], z = (int32_t)index[2];
    const double value = weft_brick_cursor_voxel(&s->cursor, x, y, z);
    return s->rest ? value + weft_brick_cursor_voxel(&s->rest_cursor, x, y, z) : value;
}

// Clamps the reference as the plan does: to the samples next to the position.
static void clamp_reference(struct subject *s, const double at[3],
                            struct weft_reference_value *reference)
{
    const struct weft_kernel *kernel = &s->plan->info.kernel;
    const int middle = (kernel->width - 1) / 2, odd = kernel->width % 2;
    int64_t from[3], index[3];
    double fraction, low = INFINITY, high = -INFINITY;
    for (int a = 0; a < 3; a++)
        from[a] = weft_kernel_first_tap(kernel, at[a], &fraction) + middle - odd;
    for (int i = 0; i < (odd ? 27 : 8); i++) {
        const int side = odd ? 3 : 2;
        index[0] = from[0] + i % side;
        index[1] = from[1] + i / side % side;
        index[2] = from[2] + i / (side * side);
        const double sample = fetch(s, index);
        low = fmin(low, sample);
        high = fmax(high, sample);
    }
    if (isfinite(reference->value))
        reference->value = fmin(fmax(reference->value, low), high);
}

static enum weft_result refer(void *priv, int channel, const double at[3], bool finite,
                              struct weft_reference_value *out)
{
    struct subject *s = priv;
    (void)channel;
    if (s->samples)
        return weft_slice_samples_compute(s->samples, &s->output->derivative, at, finite, out);
    *out = derives(s) ? weft_reference_compute_axes(s->kernel, 3, at, fetch, s)
                      : weft_reference_compute(&s->kernel[0], 3, at, fetch, s);
    if (s->plan->clamp_to_samples && s->plan->info.kernel.width > 1)
        clamp_reference(s, at, out);
    return WEFT_OK;
}

// ---- voxels -------------------------------------------------------------------------------------

static enum weft_result enter_tile(void *priv, int part, struct weft_rectangle *out)
{
    struct subject *s = priv;
    const struct weft_slice_tile *tile = &s->plan->tiles[part];
    const struct weft_cell_map *bricks;
    const weft_brick_store *store = NULL, *rest = NULL;
    enum weft_result res = WEFT_OK;
    *out = weft_slice_tile_part(s->plan, tile);
    if (s->samples) // they are read as they are needed
        return res;
    res = weft_slice_tile_bricks(s->plan, part, &bricks);
    if (res == WEFT_OK)
        res = weft_footprint_load(s->plan->footprint, bricks, 0, &store);
    if (res == WEFT_OK && s->rest)
        res = weft_footprint_load(s->rest, bricks, 0, &rest);
    s->cursor = (struct weft_brick_cursor){.store = store};
    s->rest_cursor = (struct weft_brick_cursor){.store = rest};
    return res;
}

// ---- the call -----------------------------------------------------------------------------------

// What prefiltered kernels are verified against: how far voxels count.
static enum weft_result set_samples(struct subject *s)
{
    weft_footprint *footprint = s->plan->footprint;
    const struct weft_slice_statistics *statistics = &footprint->statistics;
    return weft_slice_samples_create(s->plan, statistics, &footprint->shells, &s->samples);
}

// And the bound, of what was measured.
static void set_measured(const struct subject *s, struct weft_verifier *v)
{
    const struct weft_slice_statistics *statistics = &s->plan->footprint->statistics;
    const struct weft_bound_values values = {.low = statistics->low,
                                             .high = statistics->high,
                                             .sample_low = statistics->voxel_low,
                                             .sample_high = statistics->voxel_high,
                                             .beyond = statistics->beyond};
    v->bound_relative = 0.0;
    v->bound_absolute = weft_bound_compute(&s->output->bound, &values).total;
    v->seconds = weft_slice_samples_seconds(s->samples);
    v->far = true;
}

// Of voxels up to m: proportional to m, but for what is absolute.
static void set_bound(const struct subject *s, struct weft_verifier *v)
{
    static const struct weft_bound_values none, one = {-1.0, 1.0, -1.0, 1.0, 0.0, 0.0};
    struct weft_bound_terms terms = s->output->bound;
    v->bound_absolute = weft_bound_compute(&terms, &none).total;
    terms.absolute = terms.absolute_rounding = 0.0;
    v->bound_relative = weft_bound_compute(&terms, &one).total;
}

// Verifies the output that the subject names.
static enum weft_result verify_output(struct subject *s, const struct weft_slice_verify_params *p,
                                      struct weft_verify_report *out)
{
    const struct weft_slice_plan *plan = s->plan;
    for (int a = 0; a < 3; a++)
        s->kernel[a] = plan->kernels[s->output->derivative.along[a]]->kernel;
    struct weft_verifier v = {
        .width = plan->footprint->grid.index.width,
        .height = plan->footprint->grid.index.height,
        .pixels = plan->info.part,
        .channels = 1,
        .first_channel = (int)(s->output - plan->info.output),
        .priv = s,
        .position = position,
        .margin = margin,
        .refer = refer,
        .pixel = pixel,
        .enter = enter_tile,
        .part_count = plan->info.tile_count,
        .jumps = jumps(s) || plan->clamp_to_samples,
        .seconds = weft_verifier_seconds(&plan->info.kernel, 3),
        .how = {p->max_seconds, p->seed, p->progress, p->tell, p->tell_priv},
        .log = plan->log,
    };
    (s->samples ? set_measured : set_bound)(s, &v);
    return weft_verifier_run(&v, out);
}

enum weft_result weft_slice_verify(const weft_slice_plan *plan, const float *pixels,
                                   const struct weft_slice_verify_params *params,
                                   struct weft_verify_report *out)
{
    static const struct weft_slice_verify_params defaults;
    const struct weft_slice_verify_params *p = params ? params : &defaults;
    const struct weft_rectangle *part = &plan->info.part;
    const size_t plane = (size_t)part->width * (size_t)part->height;
    struct subject subject = {.plan = plan};
    enum weft_result res = WEFT_OK;
    for (int o = 0; o < plan->info.output_count; o++)
        out[o] = (struct weft_verify_report){0};
    if (plan->info.kernel.prefiltered)
        res = weft_footprint_measure(plan->footprint, p->progress);
    if (plan->info.kernel.prefiltered && res == WEFT_OK)
        res = set_samples(&subject);
    if (!plan->info.kernel.prefiltered && p->rest)
        res = weft_footprint_create(
            weft_footprint_params(.volume = p->rest, .kernel = plan->info.kernel,
                                  .space = plan->info.space, .geometry = plan->info.geometry,
                                  .log = plan->log),
            &subject.rest);
    for (int o = 0; res == WEFT_OK && o < plan->info.output_count; o++) {
        subject.output = &plan->info.output[o];
        subject.pixels = pixels + (size_t)o * plane;
        res = verify_output(&subject, p, &out[o]);
    }
    weft_footprint_destroy(&subject.rest);
    weft_slice_samples_destroy(&subject.samples);
    return res;
}
