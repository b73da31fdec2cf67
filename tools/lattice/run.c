// SPDX-License-Identifier: BSD-3-Clause
// Grids, planned and made.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"
#include "tools/lattice/job.h"

// What one core of 2020 takes for a voxel of the reference, and each of its taps; and what
// verifying may take about.
static const double voxel_seconds = 2e-6, tap_seconds = 2.5e-8, verify_seconds = 10.0;

// ---- plans --------------------------------------------------------------------------------------

static enum weft_result open_like(struct lattice_job *job)
{
    const struct option_value *like = &job->option[LATTICE_LIKE];
    if (!like->given)
        return WEFT_OK;
    const struct weft_volume_open_params params = {.path = like->text, .log = report_log()};
    const enum weft_result res = weft_volume_open(&params, &job->like);
    if (res != WEFT_OK || !weft_volume_get_info(job->like)->empty)
        return res;
    report_error("--like %s: it has no active voxel, and so no box", like->text);
    return WEFT_ERR_ARGUMENT;
}

// Both boxes in the world, the grid's before --matrix moves it.
static enum weft_result report_apart(const struct lattice_job *job,
                                     const struct weft_volume_info *grid)
{
    const struct weft_volume_info *like = weft_volume_get_info(job->like);
    double a[2][3], b[2][3];
    weft_slice_active_box(like, WEFT_SPACE_WORLD, a[0], a[1]);
    weft_slice_active_box(grid, WEFT_SPACE_WORLD, b[0], b[1]);
    report_error("--like %s: its box and grid '%s' of %s do not overlap: in world space it is "
                 "(%g, %g, %g) to (%g, %g, %g), and the grid's%s (%g, %g, %g) to (%g, %g, %g)",
                 job->option[LATTICE_LIKE].text, grid->name, job->input, a[0][0], a[0][1], a[0][2],
                 a[1][0], a[1][1], a[1][2], job->moved ? " before --matrix" : "", b[0][0], b[0][1],
                 b[0][2], b[1][0], b[1][1], b[1][2]);
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result plan_grid(struct lattice_job *job, const char *name,
                                  struct lattice_grid *grid)
{
    const struct option_value *o = job->option;
    const struct weft_volume_open_params open = {
        .path = job->input, .grid = name, .raw = job->raw, .log = report_log()};
    enum weft_result res = weft_volume_open(&open, &grid->volume);
    if (res != WEFT_OK)
        return res;
    if (weft_volume_get_info(grid->volume)->components > 1) {
        report_error("%s: grid '%s' is of vectors; weft lattice takes grids of numbers", job->input,
                     weft_volume_get_info(grid->volume)->name);
        return WEFT_ERR_UNSUPPORTED;
    }
    struct weft_lattice_params *params =
        weft_lattice_params(.volume = grid->volume, .kernel = job->kernel,
                            .index_space = o[LATTICE_SPACE].given &&
                                           o[LATTICE_SPACE].integer[0] == WEFT_SPACE_INDEX,
                            .quantities = job->quantities.count ? &job->quantities : NULL,
                            .no_stretch =
                                o[LATTICE_ANTIALIAS].given && o[LATTICE_ANTIALIAS].integer[0] == 1,
                            .prune = o[LATTICE_PRUNE].given ? o[LATTICE_PRUNE].number[0] : 0.0,
                            .log = report_log());
    if (o[LATTICE_MEMORY].given)
        params->memory_bytes = (uint64_t)o[LATTICE_MEMORY].integer[0];
    res = lattice_place(job, grid->volume, params);
    if (res == WEFT_OK)
        res = weft_lattice_plan_create(params, &grid->plan);
    if (res != WEFT_OK || !weft_lattice_plan_get_info(grid->plan)->empty)
        return res;
    const struct weft_volume_info *info = weft_volume_get_info(grid->volume);
    if (!job->like || info->empty)
        return WEFT_OK;
    return report_apart(job, info);
}

// All that weft reads, of whose vectors that would be one component alone: those are told.
static enum weft_result plan_all(struct lattice_job *job)
{
    const struct weft_volume_open_params params = {
        .path = job->input, .raw = job->raw, .log = report_log()};
    struct weft_volume_list list = {0};
    enum weft_result res = weft_volume_list_load(&params, &list);
    if (res == WEFT_OK && !(job->grid = calloc(list.count + 1, sizeof *job->grid)))
        res = WEFT_ERR_MEMORY;
    for (size_t i = 0; res == WEFT_OK && i < list.count; i++) {
        const struct weft_volume_info *info = &list.grids[i];
        if (!info->supported || info->components > 1)
            report_warning("%s: grid '%s' is left out: %s", job->input, info->name,
                           info->supported ? "it is of vectors" : info->problem);
        else
            res = plan_grid(job, info->name, &job->grid[job->grid_count++]);
    }
    weft_volume_list_clear(&list);
    if (res != WEFT_OK || job->grid_count)
        return res;
    report_error("%s: there is no grid of numbers", job->input);
    return WEFT_ERR_UNSUPPORTED;
}

static enum weft_result plan_one(struct lattice_job *job)
{
    const struct option_value *name = &job->option[LATTICE_GRID];
    job->grid = calloc(1, sizeof *job->grid);
    if (!job->grid)
        return WEFT_ERR_MEMORY;
    job->grid_count = 1;
    return plan_grid(job, name->given ? name->text : NULL, job->grid);
}

enum weft_result lattice_plan(struct lattice_job *job)
{
    const struct option_value *name = &job->option[LATTICE_GRID];
    const double start = report_now_seconds();
    enum weft_result res = open_like(job);
    if (res == WEFT_OK)
        res = name->given && strcmp(name->text, "all") == 0 ? plan_all(job) : plan_one(job);
    job->plan_seconds = report_now_seconds() - start;
    return res;
}

// ---- files --------------------------------------------------------------------------------------

static uint64_t output_memory(const struct lattice_job *job)
{
    const struct option_value *given = &job->option[LATTICE_OUTPUT_MEMORY];
    return given->given ? (uint64_t)given->integer[0] : UINT64_C(4) << 30;
}

static enum weft_result check_size(const struct lattice_job *job)
{
    double voxels = 0.0, bytes = 0.0;
    for (size_t i = 0; i < job->grid_count; i++) {
        const struct weft_lattice_info *info = weft_lattice_plan_get_info(job->grid[i].plan);
        for (int g = 0; g < info->grid_count; g++) {
            voxels += info->voxels;
            bytes += info->voxels * info->grid[g].components * sizeof(float);
        }
    }
    if (bytes <= (double)output_memory(job))
        return WEFT_OK;
    report_error("the result would have about %.4g voxels, %.4g bytes of memory for the writer, "
                 "which may have %llu (--output-memory)",
                 voxels, bytes, (unsigned long long)output_memory(job));
    return WEFT_ERR_LIMIT;
}

static enum weft_result create_writer(struct lattice_job *job)
{
    struct weft_volume_grid grid[WEFT_VOLUME_WRITER_GRIDS];
    int count = 0;
    for (size_t i = 0; i < job->grid_count; i++) {
        const struct weft_lattice_info *info = weft_lattice_plan_get_info(job->grid[i].plan);
        job->grid[i].first = count;
        for (int g = 0; g < info->grid_count; g++) {
            if (count == WEFT_VOLUME_WRITER_GRIDS) {
                report_error("%s: more than %d grids would come out", job->input,
                             WEFT_VOLUME_WRITER_GRIDS);
                return WEFT_ERR_LIMIT;
            }
            grid[count++] = info->grid[g].grid;
        }
    }
    const uint64_t memory = output_memory(job);
    struct weft_volume_writer_params *params =
        weft_volume_writer_params(.path = job->option[LATTICE_OUTPUT].text,
                                  .no_clobber = job->option[LATTICE_NO_CLOBBER].given,
                                  .grid_count = count, .grid = grid,
                                  .limits = {.memory_bytes = memory + memory / 2,
                                             .output_bytes = 2 * memory,
                                             .cpu_seconds = 36000,
                                             .wall_seconds = 3600},
                                  .log = report_log());
    return weft_volume_writer_create(params, &job->writer);
}

// Whatever keeps the writer from writing is an output not written.
static enum weft_result written(enum weft_result res)
{
    return res == WEFT_OK || res == WEFT_ERR_MEMORY || res == WEFT_ERR_CANCELLED ? res
                                                                                 : WEFT_ERR_WRITE;
}

struct sink {
    struct lattice_job *job;
    int first;
};

static enum weft_result take(void *priv, const struct weft_volume_lot *lot)
{
    const struct sink *sink = priv;
    struct weft_volume_lot moved = *lot;
    moved.grid += sink->first;
    return sink->job->writer ? written(weft_volume_writer_add(sink->job->writer, &moved)) : WEFT_OK;
}

// ---- runs ---------------------------------------------------------------------------------------

static double verify_share(const struct lattice_job *job, const struct weft_lattice_info *info)
{
    if (!job->option[LATTICE_VERIFY].given)
        return 0.0;
    double taps = 1.0;
    for (int a = 0; a < 3; a++)
        taps *= (double)info->width[a];
    const double each =
        (voxel_seconds + taps * tap_seconds) * info->derivative_count * info->grid_count;
    const double all = fmax(1.0, 2.0 * info->voxels * (double)job->grid_count);
    return fmin(1.0, fmax(verify_seconds / each, 64.0) / all);
}

static void tell_band(const struct lattice_job *job, const struct weft_lattice_info *info)
{
    if (info->clamps && info->band_voxels < 1.5)
        report_warning("%s: half the band of the level set is %.3g voxels of the result wide: "
                       "surfaces need 1.5 and more",
                       job->input, info->band_voxels);
}

enum weft_result lattice_run(struct lattice_job *job)
{
    const bool writes = job->option[LATTICE_OUTPUT].given;
    enum weft_result res = writes ? check_size(job) : WEFT_OK;
    if (res == WEFT_OK && writes)
        res = written(create_writer(job));
    for (size_t i = 0; res == WEFT_OK && i < job->grid_count; i++) {
        struct lattice_grid *grid = &job->grid[i];
        const struct weft_lattice_info *info = weft_lattice_plan_get_info(grid->plan);
        struct sink sink = {job, grid->first};
        tell_band(job, info);
        res = weft_lattice_run(grid->plan,
                               weft_lattice_run_params(.sink = take, .priv = &sink,
                                                       .verify = {.share = verify_share(job, info)},
                                                       .progress = report_progress("filtering")),
                               &grid->report);
    }
    const double start = report_now_seconds();
    if (res == WEFT_OK && writes) {
        report_stage("writing", job->option[LATTICE_OUTPUT].text);
        res = written(weft_volume_writer_finish(&job->writer, &job->file_bytes));
    }
    job->write_seconds = report_now_seconds() - start;
    return res;
}

void lattice_clear(struct lattice_job *job)
{
    weft_volume_writer_discard(&job->writer);
    for (size_t i = 0; i < job->grid_count; i++) {
        weft_lattice_plan_destroy(&job->grid[i].plan);
        weft_volume_destroy(&job->grid[i].volume);
    }
    free(job->grid);
    weft_volume_destroy(&job->like);
    weft_kernel_file_destroy(&job->kernel_file);
}
