// SPDX-License-Identifier: BSD-3-Clause
// What stays of a volume from frame to frame.
#include "tools/slice/stages.h"

#include <math.h>

#include "tools/common/numbered.h"
#include "tools/common/report.h"

#define LEAST_MEMORY (UINT64_C(64) << 20)

static void cross(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// How many voxels of a world's unit cube there are; 1 of index space itself.
static double voxels_in_unit(const struct slice_job *job)
{
    const double(*m)[4] = weft_volume_get_info(job->volume)->index_to_world;
    double yz[3];
    if (job->slice_params.space == WEFT_SPACE_INDEX)
        return 1.0;
    cross(m[1], m[2], yz);
    return 1.0 / fabs(dot(m[0], yz));
}

// How far the next frame's middle is from this one's plane, in voxels: what edges and way span has
// a volume, which over the edges' area is the distance.
static double distance_of_next(const struct slice_job *job)
{
    const struct weft_slice_geometry *g = &job->geometry;
    const struct weft_slice_geometry *index = &weft_slice_plan_get_info(job->plan)->index_geometry;
    struct slice_job next = *job;
    double way[3], normal[3], index_normal[3];
    next.frame += job->setup->sweep.step;
    if (slice_place(&next) != WEFT_OK)
        return INFINITY;
    for (int c = 0; c < 3; c++)
        way[c] = next.geometry.origin[c] - g->origin[c] +
                 0.5 * (next.geometry.u[c] - g->u[c] + next.geometry.v[c] - g->v[c]);
    cross(g->u, g->v, normal);
    cross(index->u, index->v, index_normal);
    return fabs(dot(way, normal)) * voxels_in_unit(job) / sqrt(dot(index_normal, index_normal));
}

// One volume that frames read in one layout and format, so near to each other that they share half
// of their blocks: planes that are farther apart than a block share none. Passes, and textures,
// take none that stays, and a budget chooses formats itself; a range that is not given is each
// frame's own.
static bool stays(const struct slice_job *job)
{
    const struct slice_setup *setup = job->setup;
    const struct option_value *o = setup->option;
    return job->index + 1 < setup->sweep.count && setup->source_count == 1 &&
           !numbered_is(setup->input) && !o[SLICE_MAX_ERROR].given &&
           !o[SLICE_PASSES + PASS_PROFILE].given && !o[SLICE_HARDWARE].given &&
           (o[SLICE_SOURCE].integer[0] == WEFT_SOURCE_FLOAT ||
            o[SLICE_PASSES + PASS_SOURCE_RANGE].given) &&
           slice_memory(setup) >= LEAST_MEMORY && distance_of_next(job) < WEFT_BRICK_SIZE / 2;
}

// Frames across an axis read bricks alone: where all are, blocks need not be held.
static bool reads_blocks(const struct slice_job *job)
{
    const unsigned savings = weft_slice_plan_get_info(job->plan)->savings;
    return job->setup->sweep.planes || !(savings & (WEFT_SAVING_AXIS | WEFT_SAVING_SEPARABLE));
}

enum weft_result slice_keep_volume(struct slice_job *job)
{
    struct slice_setup *setup = job->setup;
    const struct weft_slice_params *slice = &job->slice_params;
    if (setup->resident || !stays(job))
        return WEFT_OK;
    const double start = report_now_seconds();
    // A quarter is the plan's, another what blocks take for a while when they grow.
    const uint64_t quarter = slice_memory(setup) / 4;
    const struct weft_resident_params params = {
        .volume = job->volume,
        .context = slice->engine == WEFT_ENGINE_GL ? setup->context : NULL,
        .kernel = slice->kernel,
        .layout = slice->layout,
        .source = slice->source,
        .low = slice->low,
        .high = slice->high,
        .memory_bytes = reads_blocks(job) ? quarter : quarter / 4,
        .brick_bytes = reads_blocks(job) ? quarter : 2 * quarter,
        .log = report_log(),
    };
    const enum weft_result res = weft_resident_create(&params, &setup->resident);
    job->plan_seconds += report_now_seconds() - start;
    return res == WEFT_OK ? slice_plan_anew(job) : res;
}

json_t *slice_resident_json(const struct slice_setup *setup)
{
    if (!setup->resident)
        return json_null();
    const struct weft_resident_info *info = weft_resident_get_info(setup->resident);
    return json_pack("{s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "block_bytes",
                     json_count(info->block_bytes), "capacity", json_count(info->capacity),
                     "blocks", json_count(info->blocks), "laid_out", json_count(info->laid_out),
                     "reused", json_count(info->reused), "evicted", json_count(info->evicted),
                     "bricks_read", json_count(info->bricks_read), "brick_bytes",
                     json_count(info->brick_bytes));
}
