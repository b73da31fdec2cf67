// SPDX-License-Identifier: BSD-3-Clause
// Pixels that are summed in double, tap by tap: at the borders of the samples, and wherever single
// precision or samples that are not finite ask for care. What engines share around it.
#include <math.h>
#include <stdlib.h>

#include "passes/warp/careful.h"

bool weft_warp_is_plain(const struct weft_warp_plan *plan, const weft_resample_source *source)
{
    return source->samples.not_finite == 0 &&
           weft_warp_scale_bits(plan, &source->info.statistics) == 0;
}

enum weft_result weft_warp_scratch_create(const struct weft_warp_plan *plan,
                                          struct weft_warp_scratch *out)
{
    *out = (struct weft_warp_scratch){.plan = plan};
    for (int a = 0; a < 2; a++) {
        const size_t taps = (size_t)plan->info.taps[a];
        out->weights[a] = calloc(taps, sizeof *out->weights[a]);
        out->index[a] = calloc(taps, sizeof *out->index[a]);
    }
    if (out->weights[0] && out->weights[1] && out->index[0] && out->index[1])
        return WEFT_OK;
    weft_warp_scratch_destroy(out);
    weft_error(plan->log, "out of memory for %d x %d weights", plan->info.taps[0],
               plan->info.taps[1]);
    return WEFT_ERR_MEMORY;
}

void weft_warp_scratch_destroy(struct weft_warp_scratch *scratch)
{
    for (int a = 0; a < 2; a++) {
        free(scratch->weights[a]);
        free(scratch->index[a]);
        scratch->weights[a] = NULL;
        scratch->index[a] = NULL;
    }
}

void weft_warp_scratch_set(struct weft_warp_scratch *scratch, const struct weft_warp_row *row,
                           int i)
{
    const struct weft_warp_plan *plan = scratch->plan;
    for (int a = 0; a < 2; a++) {
        const double scale = plan->stretches ? row->scale[a][i] : 1.0;
        int64_t first;
        scratch->count[a] = weft_warp_weights(plan, row->at[a][i] + plan->info.overlap, scale,
                                              &first, scratch->weights[a]);
        scratch->first[a] = weft_warp_reduce(plan, a, first, scratch->count[a]);
    }
}

float weft_warp_careful(struct weft_warp_scratch *scratch, const struct weft_warp_values *values)
{
    for (int a = 0; a < 2; a++)
        for (int k = 0; k < scratch->count[a]; k++)
            scratch->index[a][k] =
                weft_boundary_index(values->boundary, scratch->first[a] + k, values->size[a]);
    double sum = 0.0;
    for (int j = 0; j < scratch->count[1]; j++) {
        double along = 0.0;
        if (scratch->weights[1][j] == 0.0)
            continue;
        for (int i = 0; i < scratch->count[0]; i++)
            if (scratch->weights[0][i] != 0.0)
                along += scratch->weights[0][i] *
                         weft_warp_value(values, scratch->index[0][i], scratch->index[1][j]);
        sum += scratch->weights[1][j] * along;
    }
    return (float)sum;
}

// ---- clamping -----------------------------------------------------------------------------------

static void range_around(const struct weft_warp_values *values, const double at[2],
                         const double scale[2], float *low, float *high)
{
    *low = INFINITY;
    *high = -INFINITY;
    const int64_t from[2] = {(int64_t)ceil(at[0] - scale[0]), (int64_t)ceil(at[1] - scale[1])};
    for (int64_t y = from[1]; (double)y <= at[1] + scale[1]; y++)
        for (int64_t x = from[0]; (double)x <= at[0] + scale[0]; x++) {
            const float value = (float)weft_warp_value(
                values, weft_boundary_index(values->boundary, x, values->size[0]),
                weft_boundary_index(values->boundary, y, values->size[1]));
            if (!isfinite(value))
                continue;
            *low = fminf(*low, value);
            *high = fmaxf(*high, value);
        }
}

double weft_warp_held(const struct weft_warp_values *values, const double at[2],
                      const double scale[2], double value)
{
    float low, high;
    range_around(values, at, scale, &low, &high);
    // Comparisons with NaN are false: it stays.
    return value < (double)low ? (double)low : value > (double)high ? (double)high : value;
}

void weft_warp_clamp(const struct weft_warp_plan *plan, const weft_resample_source *source, int c,
                     const struct weft_warp_row *row, int count, float *pixels)
{
    const struct weft_warp_values values = weft_warp_samples(plan, source, c);
    for (int i = 0; i < count; i++) {
        const double at[2] = {row->at[0][i], row->at[1][i]};
        const double one[2] = {1.0, 1.0}, own[2] = {row->scale[0][i], row->scale[1][i]};
        pixels[i] =
            (float)weft_warp_held(&values, at, plan->stretches ? own : one, (double)pixels[i]);
    }
}
