// SPDX-License-Identifier: BSD-3-Clause
// What `weft resample --verify` compares prefiltered kernels with: cardinal splines over the
// image's own samples, in double, without coefficients.
#include <math.h>
#include <stdlib.h>

#include "tools/common/report.h"
#include "tools/resample/job.h"

static const double WEIGHTS_ERROR = 0x1p-32;

struct verifier {
    const struct resample_job *job;
    struct resample_group *group;
    struct weft_prefilter prefilter;
    int overlap;
    double whole;                        // largest sum of the plain kernel's |weights| in 2D
    struct weft_prefilter_axis *columns; // of the result
    double *value, *depends, *reaches;   // of the input's columns, at a row of the result
    double square_sum, compared;
};

static enum weft_result out_of_memory(const struct verifier *v)
{
    report_error("out of memory to verify %d x %d pixels", v->job->result.width,
                 v->job->result.height);
    return WEFT_ERR_MEMORY;
}

static enum weft_result create(struct verifier *v)
{
    const struct resample_job *job = v->job;
    const size_t columns = (size_t)job->image.width;
    struct weft_kernel plain = job->kernel;
    enum weft_result res = weft_prefilter_compute(report_log(), &job->kernel, &v->prefilter);
    if (res != WEFT_OK)
        return res;
    plain.prefiltered = false;
    v->whole = pow(weft_analysis_overshoot(&plain).gain, 2.0);
    v->overlap = weft_prefilter_overlap(&v->prefilter, WEIGHTS_ERROR);
    v->columns = malloc((size_t)job->result.width * sizeof *v->columns);
    v->value = malloc(3 * columns * sizeof *v->value);
    if (!v->columns || !v->value)
        return out_of_memory(v);
    v->depends = v->value + columns;
    v->reaches = v->depends + columns;
    for (int x = 0; x < job->result.width; x++)
        weft_prefilter_axis_set(&v->prefilter, &job->kernel, v->overlap,
                                resample_position(&job->place[0], x, 0), 0, job->image.width - 1,
                                &v->columns[x]);
    return WEFT_OK;
}

// Sums along the columns of the input.
static void add_rows(struct verifier *v, const float *samples, int y)
{
    const struct resample_job *job = v->job;
    const int width = job->image.width;
    struct weft_prefilter_axis axis;
    weft_prefilter_axis_set(&v->prefilter, &job->kernel, v->overlap,
                            resample_position(&job->place[1], y, 0), 0, job->image.height - 1,
                            &axis);
    for (int x = 0; x < width; x++)
        v->value[x] = v->depends[x] = v->reaches[x] = 0.0;
    for (int k = 0; k < axis.count; k++) {
        const float *row = samples + (size_t)(axis.first + k) * (size_t)width;
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
    struct weft_multipass_error *e = &v->group->error;
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

static enum weft_result verify_group(struct verifier *v)
{
    const struct resample_job *job = v->job;
    const int width = job->result.width, height = job->result.height, count = v->group->count;
    const struct weft_progress *progress = report_progress("verifying");
    v->square_sum = v->compared = 0.0;
    v->group->error = (struct weft_multipass_error){.maximum = 0.0};
    for (int c = 0; c < count; c++) {
        const size_t channel = v->group->channel[c];
        const float *samples = job->image.channels[job->source[channel]].plane;
        const float *pixels = job->result.channels[channel].plane;
        for (int y = 0; y < height; y++) {
            if (!progress->report(progress->priv, (c + (double)y / height) / count))
                return WEFT_ERR_CANCELLED;
            add_rows(v, samples, y);
            for (int x = 0; x < width; x++)
                compare(v, c, x, y, (double)pixels[(size_t)y * (size_t)width + (size_t)x]);
        }
    }
    v->group->error.rms = v->compared > 0.0 ? sqrt(v->square_sum / v->compared) : 0.0;
    return WEFT_OK;
}

enum weft_result resample_verify_samples(struct resample_job *job)
{
    struct verifier v = {.job = job};
    enum weft_result res = create(&v);
    for (size_t g = 0; res == WEFT_OK && g < job->group_count; g++) {
        v.group = &job->group[g];
        res = verify_group(&v);
    }
    free(v.columns);
    free(v.value);
    return res;
}
