// SPDX-License-Identifier: BSD-3-Clause
// What pixels of prefiltered kernels are compared with: cardinal splines over the samples
// themselves, in double, without coefficients.
#include <math.h>
#include <stdlib.h>

#include "filter/analysis/analysis.h"
#include "filter/kernels/prefilter.h"
#include "passes/resample/resample_impl.h"

static const double WEIGHTS_ERROR = 0x1p-32;

struct verifier {
    const struct weft_resample_info *info;
    const struct weft_resample_verify_params *params;
    struct weft_prefilter prefilter;
    int overlap;
    double whole;                        // largest sum of the plain kernel's |weights| in 2D
    struct weft_prefilter_axis *columns; // of the result
    double *value, *depends, *reaches;   // of the samples' columns, at a row of the result
    double square_sum, compared;
    struct weft_multipass_error error;
};

static enum weft_result create(struct verifier *v)
{
    const struct weft_resample_info *info = v->info;
    const size_t columns = (size_t)info->size[0];
    struct weft_kernel plain = info->kernel;
    const enum weft_result res =
        weft_prefilter_compute(v->params->log, &info->kernel, &v->prefilter);
    if (res != WEFT_OK)
        return res;
    plain.prefiltered = false;
    v->whole = pow(weft_analysis_overshoot(&plain).gain, 2.0);
    v->overlap = weft_prefilter_overlap(&v->prefilter, WEIGHTS_ERROR);
    v->columns = malloc((size_t)info->width * sizeof *v->columns);
    v->value = malloc(3 * columns * sizeof *v->value);
    if (!v->columns || !v->value) {
        weft_error(v->params->log, "out of memory to verify %d x %d pixels", info->width,
                   info->height);
        return WEFT_ERR_MEMORY;
    }
    v->depends = v->value + columns;
    v->reaches = v->depends + columns;
    for (int x = 0; x < info->width; x++)
        weft_prefilter_axis_set(&v->prefilter, &info->kernel, v->overlap,
                                weft_window_map_position(&info->map[0], x, 0), 0, info->size[0] - 1,
                                &v->columns[x]);
    return WEFT_OK;
}

// Sums along the columns of the samples.
static void add_rows(struct verifier *v, int channel, int y)
{
    const struct weft_resample_info *info = v->info;
    const weft_resample_source *source = v->params->source;
    const int width = info->size[0];
    struct weft_prefilter_axis axis;
    weft_prefilter_axis_set(&v->prefilter, &info->kernel, v->overlap,
                            weft_window_map_position(&info->map[1], y, 0), 0, info->size[1] - 1,
                            &axis);
    for (int x = 0; x < width; x++)
        v->value[x] = v->depends[x] = v->reaches[x] = 0.0;
    for (int k = 0; k < axis.count; k++) {
        const float *row = source->plane[channel] + (axis.first + k) * source->stride;
        for (int x = 0; x < width; x++) {
            if (isfinite(row[x])) {
                v->value[x] += axis.weight[k] * (double)row[x];
                continue;
            }
            v->depends[x] += fabs(axis.weight[k]);
            v->reaches[x] += axis.reach[k];
        }
    }
}

static double refer(const struct verifier *v, int x, bool finite)
{
    const struct weft_prefilter_axis *axis = &v->columns[x];
    const int64_t first = axis->first;
    double value = 0.0, depends = 0.0, reaches = 0.0;
    for (int k = 0; k < axis->count; k++) {
        value += axis->weight[k] * v->value[first + k];
        depends += fabs(axis->weight[k]) * v->depends[first + k];
        reaches += axis->reach[k] * v->reaches[first + k];
    }
    return weft_prefilter_is_missing(depends, reaches, v->whole, finite) ? (double)NAN : value;
}

static void compare(struct verifier *v, int channel, int x, int y, double value)
{
    struct weft_multipass_error *e = &v->error;
    const double reference = refer(v, x, isfinite(value));
    if (!isfinite(value) || !isfinite(reference)) {
        e->not_finite_mismatches += isfinite(value) != isfinite(reference);
        return;
    }
    const double error = fabs(value - reference);
    v->square_sum += error * error;
    v->compared += 1.0;
    if (error > e->maximum) {
        e->maximum = error;
        e->at_x = x;
        e->at_y = y;
        e->channel = channel;
    }
}

static enum weft_result verify_channel(struct verifier *v, int channel)
{
    const int width = v->info->width, height = v->info->height;
    struct weft_resample_steps steps = {
        .outer = v->params->progress, .step = channel, .steps = v->params->source->info.channels};
    for (int y = 0; y < height; y++) {
        if (!weft_resample_report_step(&steps, (double)y / height))
            return WEFT_ERR_CANCELLED;
        add_rows(v, channel, y);
        const float *pixels = v->params->plane[channel] + y * v->params->stride;
        for (int x = 0; x < width; x++)
            compare(v, channel, x, y, (double)pixels[x]);
    }
    return WEFT_OK;
}

enum weft_result weft_resample_verify_cardinal(const weft_resample_plan *plan,
                                               const struct weft_resample_verify_params *params,
                                               struct weft_multipass_error *out)
{
    struct verifier v = {.info = &plan->info, .params = params};
    enum weft_result res = create(&v);
    for (int c = 0; res == WEFT_OK && c < params->source->info.channels; c++)
        res = verify_channel(&v, c);
    v.error.rms = v.compared > 0.0 ? sqrt(v.square_sum / v.compared) : 0.0;
    if (res == WEFT_OK)
        *out = v.error;
    free(v.columns);
    free(v.value);
    return res;
}
