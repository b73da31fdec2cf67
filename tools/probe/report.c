// SPDX-License-Identifier: BSD-3-Clause
// What weft probe tells: warnings, what --verify found, the plan, JSON.
#include <math.h>
#include <string.h>

#include "tools/common/report.h"
#include "tools/common/run_report.h"
#include "tools/probe/job.h"

static const char *space_of(const struct probe_job *job)
{
    return weft_space_names[job->option[PROBE_SPACE].integer[0]];
}

// ---- in words -----------------------------------------------------------------------------------

// Points whose numbers would lie among the active voxels if they were of the other space.
static size_t count_otherwise(const struct probe_job *job)
{
    const struct weft_volume_info *v = &job->volume;
    const bool world = job->option[PROBE_SPACE].integer[0] == WEFT_SPACE_WORLD;
    struct weft_quantity_transform transform;
    double low[3], high[3];
    size_t inside = 0;
    weft_slice_active_box(v, WEFT_SPACE_INDEX, low, high);
    if (v->empty || weft_quantity_transform_create(NULL, v->index_to_world, &transform) != WEFT_OK)
        return 0;
    for (size_t i = 0; i < job->table.count; i++) {
        const double *p = job->table.position[i];
        bool in = true;
        for (int r = 0; r < 3; r++) {
            double at = world ? p[r] : 0.0;
            for (int c = 0; c < 3 && !world; c++)
                at += transform.inverse[r][c] * (p[c] - v->index_to_world[c][3]);
            in = in && at >= low[r] && at <= high[r];
        }
        inside += in;
    }
    return inside;
}

// Where the grid is, in the points' space, and whether the other one may be meant.
static void warn_of_outside(const struct probe_job *job)
{
    const struct weft_points_report *r = &job->report;
    const struct weft_volume_info *v = &job->volume;
    double low[3], high[3];
    char values[80] = "its edge", other[100] = "";
    weft_slice_active_box(v, (enum weft_space)job->option[PROBE_SPACE].integer[0], low, high);
    if (!v->clamp_to_edge)
        snprintf(values, sizeof values, "its background, %g", (double)v->background);
    if (r->outside + r->bad_positions == job->table.count && count_otherwise(job))
        snprintf(other, sizeof other, "; in %s space %zu of them would lie inside",
                 weft_space_names[!job->option[PROBE_SPACE].integer[0]], count_otherwise(job));
    report_warning("%llu of %zu points lie outside of the active voxels of grid %s, (%g, %g, %g) "
                   "to (%g, %g, %g) in %s space: their values are those of %s%s",
                   (unsigned long long)r->outside, job->table.count, v->name, low[0], low[1],
                   low[2], high[0], high[1], high[2], space_of(job), values, other);
}

static void warn(const struct probe_job *job)
{
    const struct weft_points_report *r = &job->report;
    if (r->bad_positions)
        report_warning("%llu of %zu points have no position that can be sampled (NaN, infinite, or "
                       "beyond +-2^30 voxels): their values are nan",
                       (unsigned long long)r->bad_positions, job->table.count);
    if (r->outside)
        warn_of_outside(job);
}

static void print_error(const struct probe_job *job, int output)
{
    const struct weft_verify_report *e = &job->error[output];
    const int *n = job->quantities.derivative[output].along;
    report_tell("verified: derivative %d%d%d at %llu of %llu points: largest error %.3g, bound "
                "%.3g, RMS %.3g",
                n[0], n[1], n[2], (unsigned long long)e->pixels_checked,
                (unsigned long long)e->pixels_total, e->maximum, e->bound, e->rms);
}

void probe_report(const struct probe_job *job)
{
    warn(job);
    for (int d = 0; job->option[PROBE_VERIFY].given && d < job->quantities.derivative_count; d++)
        print_error(job, d);
    report_note("%zu points: %.3f s to read them, %.3f s to sort, %.3f s to read %llu bricks, "
                "%.3f s of sums, %.3f s to write",
                job->table.count, job->read_seconds, job->report.sort_seconds,
                job->report.read_seconds, (unsigned long long)job->report.bricks_read,
                job->report.pass_seconds, job->write_seconds);
}

void probe_explain(const struct probe_job *job)
{
    char kernel[256];
    weft_kernel_format(&job->info.kernel, kernel, sizeof kernel);
    report_line("points: %zu in %s space, grid %s%s", job->table.count, space_of(job),
                job->volume.name, job->components > 1 ? ", each component" : "");
    report_line("kernel: %s, %d taps an axis, sums in %s", kernel, job->info.kernel.width,
                weft_sums_names[job->info.sums]);
    if (job->info.prefilter_overlap)
        report_line("prefilter: coefficients of voxels up to %d farther",
                    job->info.prefilter_overlap);
    for (int d = 0; d < job->info.output_count; d++) {
        const int *n = job->info.output[d].along;
        const struct weft_bound_values one = {-1.0, 1.0, -1.0, 1.0, 1.0, 0.0};
        report_line("derivative %d%d%d: error at most %.3g of the largest |voxel| in reach", n[0],
                    n[1], n[2], weft_bound_compute(&job->info.bound[d], &one).total);
    }
    for (int c = 0; c < job->channel_count; c++)
        report_line("channel: %s", job->channel[c]);
    report_line("CPU: %d threads, %s", job->info.cpu.threads,
                weft_instruction_set_names[job->info.cpu.instructions]);
}

// ---- in JSON ------------------------------------------------------------------------------------

static json_t *derivatives_json(const struct probe_job *job)
{
    json_t *outputs = json_array();
    for (int d = 0; d < job->info.output_count; d++) {
        const struct weft_derivative *n = &job->info.output[d];
        json_t *output =
            json_pack("{s:[i,i,i]}", "derivative", n->along[0], n->along[1], n->along[2]);
        if (!job->option[PROBE_EXPLAIN].given)
            json_object_set_new(
                output, "bound",
                json_number(weft_bound_compute(&job->info.bound[d], &job->report.values).total));
        if (job->option[PROBE_VERIFY].given) {
            const struct weft_verify_report *e = &job->error[d];
            json_object_set_new(output, "error", run_report_verify_error(e, NULL, 0));
            json_object_set_new(output, "bound", json_number(e->bound));
        }
        json_array_append_new(outputs, output);
    }
    return outputs;
}

static json_t *points_json(const struct probe_job *job)
{
    json_t *points = json_array();
    for (size_t i = 0; i < job->table.count; i++) {
        json_t *point = json_pack("{s:o}", "position", json_numbers(job->table.position[i], 3));
        for (int c = 0; c < job->channel_count; c++)
            json_object_set_new(
                point, job->channel[c],
                json_number((double)job->channels[(size_t)c * job->table.count + i]));
        json_array_append_new(points, point);
    }
    return points;
}

bool probe_writes_json(const struct probe_job *job)
{
    return job->option[PROBE_OUTPUT].given && job->option[PROBE_OUTPUT].integer[0] == 3;
}

enum weft_result probe_print_json(const struct probe_job *job)
{
    const struct weft_points_report *r = &job->report;
    const bool planned = job->option[PROBE_EXPLAIN].given;
    char kernel[256];
    weft_kernel_format(&job->info.kernel, kernel, sizeof kernel);
    json_t *channels = json_array();
    for (int c = 0; c < job->channel_count; c++)
        json_array_append_new(channels, json_text(job->channel[c]));
    json_t *root = json_pack("{s:o,s:o,s:s,s:s,s:o,s:o,s:o}", "grid", json_text(job->volume.name),
                             "kernel", json_text(kernel), "space", space_of(job), "sums",
                             weft_sums_names[job->info.sums], "count", json_count(job->table.count),
                             "channels", channels, "derivatives", derivatives_json(job));
    if (!planned) {
        const struct run_stage stages[] = {{"points", job->read_seconds},
                                           {"sort", r->sort_seconds},
                                           {"read", r->read_seconds},
                                           {"sums", r->pass_seconds},
                                           {"write", job->write_seconds}};
        json_object_set_new(root, "bad_positions", json_count(r->bad_positions));
        json_object_set_new(root, "outside", json_count(r->outside));
        json_object_set_new(root, "not_finite", json_count(r->not_finite));
        json_object_set_new(root, "exact_points", json_count(r->exact_points));
        json_object_set_new(root, "bricks_read", json_count(r->bricks_read));
        json_object_set_new(root, "bytes", run_report_bytes("peak", r->peak_bytes));
        json_object_set_new(root, "seconds",
                            run_report_seconds(stages, sizeof stages / sizeof *stages,
                                               report_now_seconds() - job->start));
    }
    if (!planned && (!job->option[PROBE_OUTPUT].given || probe_writes_json(job)))
        json_object_set_new(root, "points", points_json(job));
    return json_print(root);
}
