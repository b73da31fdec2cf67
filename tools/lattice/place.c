// SPDX-License-Identifier: BSD-3-Clause
// Where the result's voxels lie.
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"
#include "tools/lattice/job.h"

enum { MATRIX_NUMBERS = 12 };

enum weft_result lattice_read_matrix(struct lattice_job *job)
{
    const struct option_value *value = &job->option[LATTICE_MATRIX];
    if (!value->given)
        return WEFT_OK;
    const char *at = value->text;
    int count = 0;
    for (; count < MATRIX_NUMBERS; count++) {
        char *end = NULL;
        const double number = strchr(" \t", *at) ? NAN : strtod(at, &end);
        if (!end || end == at || !isfinite(number) ||
            *end != (count + 1 < MATRIX_NUMBERS ? ',' : '\0'))
            break;
        job->matrix[count / 4][count % 4] = number;
        at = end + 1;
    }
    job->moved = true;
    if (count == MATRIX_NUMBERS)
        return WEFT_OK;
    report_error("--matrix %s: 12 finite numbers are wanted, rows of 4, as 1,0,0,5,0,1,0,0,0,0,1,0",
                 value->text);
    return WEFT_ERR_ARGUMENT;
}

// How far apart neighbours are along each index axis, in the world's unit.
static void spacing_of(const double (*m)[4], double out[3])
{
    for (int c = 0; c < 3; c++)
        out[c] = hypot(hypot(m[0][c], m[1][c]), m[2][c]);
}

// Voxels of the source from one of the result's to the next, along its own axes.
static enum weft_result read_steps(const struct lattice_job *job,
                                   const struct weft_volume_info *info, double step[3])
{
    const struct option_value *scale = &job->option[LATTICE_SCALE];
    const struct option_value *voxel = &job->option[LATTICE_VOXEL];
    double spacing[3];
    spacing_of(info->index_to_world, spacing);
    for (int a = 0; a < 3; a++) {
        const struct option_value *given = scale->given ? scale : voxel;
        step[a] = 1.0;
        if (!given->given)
            continue;
        step[a] = scale->given ? 1.0 / scale->number[a] : voxel->number[a] / spacing[a];
        if (given->number[a] > 0.0 && isfinite(step[a]) && step[a] > 0.0)
            continue;
        report_error("--%s %s: it must be above 0, and of a size that gives a lattice",
                     scale->given ? "scale" : "voxel", given->text);
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

// The other file's lattice and box.
static void place_like(const struct lattice_job *job, struct weft_lattice_params *params)
{
    const struct weft_volume_info *like = weft_volume_get_info(job->like);
    memcpy(params->index_to_world, like->index_to_world, sizeof params->index_to_world);
    params->boxed = true;
    memcpy(params->box_min, like->active_min, sizeof params->box_min);
    memcpy(params->box_max, like->active_max, sizeof params->box_max);
}

enum weft_result lattice_place(const struct lattice_job *job, weft_volume *volume,
                               struct weft_lattice_params *params)
{
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    double step[3];
    if (job->like) {
        place_like(job, params);
    } else {
        const enum weft_result res = read_steps(job, info, step);
        if (res != WEFT_OK)
            return res;
        for (int a = 0; a < 3; a++) {
            params->to_source[a][a] = step[a];
            for (int c = 0; c < 4; c++)
                params->index_to_world[a][c] = info->index_to_world[a][c] * (c < 3 ? step[c] : 1.0);
        }
    }
    if (!job->like && !job->moved)
        return WEFT_OK;
    return weft_lattice_map_compute(report_log(), (const double(*)[4])info->index_to_world,
                                    job->moved ? (const double(*)[4])job->matrix : NULL,
                                    (const double(*)[4])params->index_to_world, params->to_source);
}
