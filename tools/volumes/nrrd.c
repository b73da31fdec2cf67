// SPDX-License-Identifier: BSD-3-Clause
// A grid as an NRRD file.
#include "tools/volumes/convert.h"

#include <math.h>
#include <string.h>

#include "tools/common/report.h"

// Samples keep their type where floats, and what those lack, hold them.
static enum weft_sample_type own_type(const struct weft_volume_info *info)
{
    const bool scaled = info->rounded && strcmp(info->type, "double") != 0;
    for (int t = 0; t < WEFT_SAMPLE_DOUBLE && !scaled; t++)
        if (!strcmp(info->type, weft_sample_type_names[t]))
            return (enum weft_sample_type)t;
    return strcmp(info->type, "vec3i") == 0 ? WEFT_SAMPLE_INT32 : WEFT_SAMPLE_FLOAT;
}

// What neither floats hold nor, of other types, floats and what those lack: 48 bits.
static void warn(const struct convert_job *job, const struct weft_volume_info *info, bool floats)
{
    const double change = floats ? info->largest_rounding : floor(info->largest_rounding * 0x1p-24);
    if (change > 0.0)
        report_warning("%s: grid '%s': integers are changed by up to %g", job->output, info->name,
                       change);
    if (info->values_infinite)
        report_warning("%s: grid '%s': %llu values are beyond the range of floats: infinite",
                       job->output, info->name, (unsigned long long)info->values_infinite);
}

enum weft_result convert_write_nrrd(struct convert_job *job)
{
    struct convert_grid *grid = &job->grid[0];
    const struct option_value *type = &job->option[CONVERT_TYPE];
    if (job->grid_count != 1) {
        report_error("%s: an NRRD file holds one grid, not %zu; --grid NAME says which",
                     job->output, job->grid_count);
        return WEFT_ERR_ARGUMENT;
    }
    const struct weft_volume_info *info = weft_volume_get_info(grid->volume[0]);
    struct weft_nrrd_save_params params = {
        .path = job->output,
        .no_clobber = job->option[CONVERT_NO_CLOBBER].given,
        .components = info->components,
        .type = type->given ? (enum weft_sample_type)type->integer[0] : own_type(info),
        .log = report_log()};
    if (!strcmp(info->grid_class, "staggered") && info->components > 1) {
        report_error("%s: the components of grid '%s' lie on faces of cells (staggered), for which "
                     "NRRD has no place",
                     job->input, info->name);
        return WEFT_ERR_UNSUPPORTED;
    }
    if (info->empty) {
        report_error("%s: grid '%s' has no active voxel", job->input, info->name);
        return WEFT_ERR_UNSUPPORTED;
    }
    enum weft_result res =
        params.type == WEFT_SAMPLE_FLOAT ? WEFT_OK : convert_open_rest(job, grid);
    memcpy(params.volume, grid->volume, sizeof params.volume);
    memcpy(params.rest, grid->rest, sizeof params.rest);
    if (res != WEFT_OK)
        return res;
    for (int c = 0; c < info->components; c++)
        warn(job, weft_volume_get_info(grid->volume[c]), params.type == WEFT_SAMPLE_FLOAT);
    report_stage("writing", job->output);
    return weft_volume_save_nrrd(&params);
}
