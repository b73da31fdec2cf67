// SPDX-License-Identifier: BSD-3-Clause
// What a volume on another lattice is, and what it cost.
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tools/common/report.h"
#include "tools/common/run_report.h"
#include "tools/lattice/job.h"

void lattice_explain(const struct lattice_job *job)
{
    for (size_t i = 0; i < job->grid_count; i++) {
        report_line("grid '%s' of %s", weft_volume_get_info(job->grid[i].volume)->name, job->input);
        fputs(weft_lattice_plan_get_info(job->grid[i].plan)->text, stdout);
    }
}

static void print_verified(const struct weft_lattice_report *r)
{
    const struct weft_verify_report *v = &r->verify;
    printf("verified %llu of %llu voxels: largest difference %.3g at (%d, %d, %d), RMS %.3g; %.3g "
           "of its bound at most\n",
           (unsigned long long)v->pixels_checked, (unsigned long long)v->pixels_total, v->maximum,
           r->verify_at[0], r->verify_at[1], r->verify_at[2], v->rms, v->share);
}

void lattice_print_text(const struct lattice_job *job)
{
    for (size_t i = 0; i < job->grid_count; i++) {
        const struct lattice_grid *grid = &job->grid[i];
        const struct weft_lattice_info *info = weft_lattice_plan_get_info(grid->plan);
        for (int g = 0; g < info->grid_count; g++)
            report_note("grid '%s': %llu bricks in, %llu bricks and %llu tiles out, %llu active "
                        "voxels",
                        info->grid[g].grid.name, (unsigned long long)info->bricks_in,
                        (unsigned long long)grid->report.bricks_out[g],
                        (unsigned long long)grid->report.tiles_out[g],
                        (unsigned long long)grid->report.active_voxels[g]);
        if (job->option[LATTICE_VERIFY].given)
            print_verified(&grid->report);
    }
}

bool lattice_verdict(const struct lattice_job *job)
{
    bool good = true;
    for (size_t i = 0; good && job->option[LATTICE_VERIFY].given && i < job->grid_count; i++) {
        const struct weft_verify_report *v = &job->grid[i].report.verify;
        good = report_verdict(weft_volume_get_info(job->grid[i].volume)->name, v->share, 1.0,
                              v->not_finite_mismatches);
    }
    return good;
}

static json_t *matrix_json(const double (*m)[4])
{
    json_t *out = json_array();
    for (int r = 0; r < 3; r++)
        json_array_append_new(out, json_numbers(m[r], 4));
    return out;
}

static json_t *result_json(const struct lattice_grid *grid, int g)
{
    const struct weft_lattice_grid *of = &weft_lattice_plan_get_info(grid->plan)->grid[g];
    const struct weft_lattice_report *r = &grid->report;
    return json_pack("{s:o,s:s,s:o,s:i,s:o,s:o,s:o,s:o}", "name", json_text(of->grid.name),
                     "quantity", weft_quantity_names[of->quantity], "class",
                     json_text(of->grid.grid_class), "components", of->components, "background",
                     json_number((double)of->grid.background), "bricks",
                     json_count(r->bricks_out[g]), "tiles", json_count(r->tiles_out[g]),
                     "active_voxels", json_count(r->active_voxels[g]));
}

static json_t *error_json(const struct lattice_job *job, const struct weft_lattice_report *r)
{
    const struct weft_verify_report *v = &r->verify;
    if (!job->option[LATTICE_VERIFY].given)
        return json_null();
    json_t *error = run_report_verify_error(v, r->verify_at, 3);
    json_object_set_new(error, "share_of_bound", json_number(v->share));
    return error;
}

static json_t *grid_json(const struct lattice_job *job, const struct lattice_grid *grid)
{
    const struct weft_lattice_info *info = weft_lattice_plan_get_info(grid->plan);
    const struct weft_lattice_report *r = &grid->report;
    char kernel[256];
    weft_kernel_format(&info->kernel, kernel, sizeof kernel);
    json_t *results = json_array(), *seconds;
    for (int g = 0; g < info->grid_count; g++)
        json_array_append_new(results, result_json(grid, g));
    const struct run_stage stages[] = {{"read", r->read_seconds},
                                       {"pass", r->pass_seconds},
                                       {"hand_over", r->sink_seconds},
                                       {"verify", r->verify_seconds}};
    seconds = run_report_seconds(stages, sizeof stages / sizeof *stages, r->seconds);
    return json_pack(
        "{s:o,s:o,s:b,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "name",
        json_text(weft_volume_get_info(grid->volume)->name), "kernel", json_text(kernel),
        "separable", info->separable, "to_source", matrix_json((const double(*)[4])info->to_source),
        "index_to_world", matrix_json((const double(*)[4])info->index_to_world), "stretch",
        json_numbers(info->stretch, 3), "box_min", json_counts(info->box_min, 3), "box_max",
        json_counts(info->box_max, 3), "bricks_in", json_count(info->bricks_in), "tiles_in",
        json_count(info->tiles_in), "bricks_read", json_count(r->bricks_read), "bricks_computed",
        json_count(r->bricks_computed), "not_finite", json_count(r->not_finite), "clamped",
        json_count(r->clamped), "band_voxels", json_number(info->band_voxels), "relative_bound",
        json_number(info->bound[0].relative + info->bound[0].rounded_gain * 0x1p-24), "bytes",
        run_report_bytes("peak", r->peak_bytes), "seconds", seconds, "results", results, "error",
        error_json(job, r));
}

enum weft_result lattice_print_json(const struct lattice_job *job)
{
    json_t *grids = json_array();
    for (size_t i = 0; i < job->grid_count; i++)
        json_array_append_new(grids, grid_json(job, &job->grid[i]));
    const struct run_stage stages[] = {{"plan", job->plan_seconds}, {"write", job->write_seconds}};
    return json_print(json_pack("{s:o,s:o}", "grids", grids, "seconds",
                                run_report_seconds(stages, 2, report_now_seconds() - job->start)));
}
