// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/volume/volume.h"

#include <math.h>
#include <stdlib.h>

#include "tiles/volume/volume_impl.h"

bool weft_transform_valid(const double m[3][4])
{
    double norm[3], det = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                          m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                          m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++)
            if (!isfinite(m[r][c]))
                return false;
    for (int c = 0; c < 3; c++)
        norm[c] = hypot(hypot(m[0][c], m[1][c]), m[2][c]);
    double relative = fabs(det) / norm[0] / norm[1] / norm[2];
    return isfinite(det) && relative > 1e-12;
}

// ---- life ---------------------------------------------------------------------------------------

enum weft_result weft_volume_make(const struct weft_log *log,
                                  const struct weft_volume_backend *backend, weft_volume **out)
{
    weft_volume *volume = calloc(1, sizeof *volume);
    void *data = calloc(1, backend->data_bytes);
    *out = NULL;
    if (!volume || !data) {
        weft_error(log, "not enough memory for a volume");
        free(volume);
        free(data);
        return WEFT_ERR_MEMORY;
    }
    volume->log = log;
    volume->backend = backend;
    volume->data = data;
    *out = volume;
    return WEFT_OK;
}

void weft_volume_destroy(weft_volume **volume)
{
    if (!volume || !*volume)
        return;
    (*volume)->backend->clear((*volume)->data);
    free((*volume)->data);
    free((*volume)->info.metadata);
    free(*volume);
    *volume = NULL;
}

const struct weft_volume_info *weft_volume_get_info(const weft_volume *volume)
{
    return &volume->info;
}

// ---- looking ------------------------------------------------------------------------------------

enum weft_result weft_volume_find(weft_volume *volume, const struct weft_region *region,
                                  struct weft_brick_list *out)
{
    *out = (struct weft_brick_list){0};
    const struct weft_log *log = volume->log;
    weft_require(log, region->slab_count >= 0 && region->slab_count <= 3);
    for (int s = 0; s < region->slab_count; s++) {
        const struct weft_slab *slab = &region->slab[s];
        weft_require(log, isfinite(slab->normal[0]) && isfinite(slab->normal[1]) &&
                              isfinite(slab->normal[2]));
        weft_require(log, !isnan(slab->lower) && !isnan(slab->upper));
    }
    return volume->backend->find(volume, region, out);
fail:
    return WEFT_ERR_ARGUMENT;
}

enum weft_result weft_volume_read(weft_volume *volume, size_t count,
                                  const int32_t (*brick_origin)[3], float *values)
{
    const struct weft_log *log = volume->log;
    weft_require(log, !count || (brick_origin && values));
    return volume->backend->read(volume, count, brick_origin, values);
fail:
    return WEFT_ERR_ARGUMENT;
}
