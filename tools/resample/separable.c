// SPDX-License-Identifier: BSD-3-Clause
// `weft resample` along one axis and then the other, in single precision.
#include <math.h>
#include <stdlib.h>

#include "tools/common/report.h"
#include "tools/resample/job.h"

struct runner {
    struct resample_job *job;
    const char *what;
    double step, steps; // channels
    double *at[2];      // of the columns and of the rows
};

static bool report_step(void *priv, double fraction)
{
    const struct runner *r = priv;
    const struct weft_progress *outer = report_progress(r->what);
    return outer->report(outer->priv, (r->step + fraction) / r->steps);
}

static enum weft_result set_positions(struct runner *r)
{
    const struct resample_job *job = r->job;
    const int to[2] = {job->result.width, job->result.height};
    for (int a = 0; a < 2; a++) {
        r->at[a] = malloc((size_t)to[a] * sizeof *r->at[a]);
        if (!r->at[a]) {
            report_error("out of memory for %d positions", to[a]);
            return WEFT_ERR_MEMORY;
        }
        for (int i = 0; i < to[a]; i++)
            r->at[a][i] = resample_position(&job->place[a], i, job->pad);
    }
    return WEFT_OK;
}

static void add_report(struct resample_job *job, const struct weft_separable_report *one)
{
    struct weft_separable_report *sum = &job->separable_report;
    job->report.prepare_seconds += one->prepare_seconds;
    job->report.upload_seconds += one->upload_seconds;
    job->report.pass_seconds += one->pass_seconds;
    job->report.readback_seconds += one->readback_seconds;
    sum->uploaded_bytes += one->uploaded_bytes;
    sum->peak_bytes = one->peak_bytes > sum->peak_bytes ? one->peak_bytes : sum->peak_bytes;
    sum->passes += one->passes;
    sum->first_axis = one->first_axis;
    sum->fetches_per_pixel = one->fetches_per_pixel;
    job->tiles += one->rectangles;
}

static enum weft_result run_group(struct runner *r, struct resample_group *group, bool verify)
{
    const struct resample_job *job = r->job;
    const struct weft_progress progress = {report_step, r};
    const struct weft_separable_params params = {
        .kernel = job->kernel,
        .size = {job->image.width + 2 * job->pad, job->image.height + 2 * job->pad},
        .samples = resample_source_plane(job, group->channel[0]),
        .width = job->result.width,
        .height = job->result.height,
        .x = r->at[0],
        .y = r->at[1],
        .pixels = job->result.channels[group->channel[0]].plane,
        .progress = &progress,
        .log = report_log(),
    };
    enum weft_result res;
    if (verify) {
        struct weft_separable_error error;
        res = weft_separable_verify(&params, 0.0, &error);
        if (res == WEFT_OK)
            group->error = (struct weft_multipass_error){
                .maximum = error.maximum,
                .rms = error.rms,
                .at_x = error.at_x,
                .at_y = error.at_y,
                .not_finite_mismatches = error.not_finite_mismatches,
            };
    } else {
        struct weft_separable_report report;
        res = weft_separable_run(job->context, &params, &report);
        if (res == WEFT_OK)
            add_report(r->job, &report);
    }
    r->step++;
    return res;
}

static enum weft_result each_group(struct runner *r, const char *what, bool verify)
{
    enum weft_result res = WEFT_OK;
    r->what = what;
    r->step = 0.0;
    for (size_t g = 0; res == WEFT_OK && g < r->job->group_count; g++)
        if (!r->job->group[g].exact)
            res = run_group(r, &r->job->group[g], verify);
    return res;
}

enum weft_result resample_separable_run(struct resample_job *job)
{
    struct runner r = {.job = job, .steps = (double)job->group_count};
    enum weft_result res = set_positions(&r);
    if (res == WEFT_OK)
        res = each_group(&r, "resampling", false);
    for (size_t g = 0; res == WEFT_OK && g < job->group_count; g++)
        if (!job->group[g].exact)
            resample_measure_result(job, &job->group[g]);
    const double start = report_now_seconds();
    if (res == WEFT_OK && job->option[RESAMPLE_VERIFY].given)
        res = job->coefficients ? resample_verify_samples(job) : each_group(&r, "verifying", true);
    job->verify_seconds = report_now_seconds() - start;
    free(r.at[0]);
    free(r.at[1]);
    return res;
}
