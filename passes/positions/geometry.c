// SPDX-License-Identifier: BSD-3-Clause
#include "passes/positions/geometry.h"

#include <math.h>

#include "filter/check.h"
#include "passes/positions/grid.h"

const char *const weft_space_names[] = {"world", "index", NULL};

enum { DEFAULT_SIDE = 1024 };

void weft_slice_active_box(const struct weft_volume_info *info, enum weft_space space,
                           double low[3], double high[3])
{
    for (int a = 0; a < 3; a++) {
        low[a] = space == WEFT_SPACE_INDEX ? info->active_min[a] - 0.5 : INFINITY;
        high[a] = space == WEFT_SPACE_INDEX ? info->active_max[a] + 0.5 : -INFINITY;
    }
    for (int corner = 0; corner < 8 && space == WEFT_SPACE_WORLD; corner++) {
        for (int r = 0; r < 3; r++) {
            const double *m = info->index_to_world[r];
            double at = m[3];
            for (int c = 0; c < 3; c++)
                at += m[c] *
                      (corner >> c & 1 ? info->active_max[c] + 0.5 : info->active_min[c] - 0.5);
            low[r] = fmin(low[r], at);
            high[r] = fmax(high[r], at);
        }
    }
}

static double world_length(const struct weft_volume_info *info, enum weft_space space,
                           const double edge[3])
{
    double length = 0.0; // by hypot: squares overflow where lengths do not
    for (int r = 0; r < 3; r++) {
        double along = edge[r];
        if (space == WEFT_SPACE_INDEX) {
            const double *m = info->index_to_world[r];
            along = m[0] * edge[0] + m[1] * edge[1] + m[2] * edge[2];
        }
        length = hypot(length, along);
    }
    return length;
}

static bool has_length(const double edge[3])
{
    const double length = hypot(hypot(edge[0], edge[1]), edge[2]);
    return length > 0.0 && isfinite(length);
}

static bool spans_plane(const struct weft_slice_geometry *g)
{
    return has_length(g->u) && has_length(g->v);
}

static int scaled_side(int side, double length, double other_length)
{
    double pixels = round(side * length / other_length);
    return pixels < 1.0 ? 1 : pixels > WEFT_SLICE_MAX_SIZE ? WEFT_SLICE_MAX_SIZE : (int)pixels;
}

enum weft_result weft_slice_size_compute(const struct weft_log *log, const weft_volume *volume,
                                         enum weft_space space,
                                         struct weft_slice_geometry *geometry)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, geometry->width >= 0 && geometry->height >= 0);
    weft_require_enum(log, space, WEFT_SPACE_INDEX);
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    double u = world_length(info, space, geometry->u), v = world_length(info, space, geometry->v);
    if (!(u > 0.0 && v > 0.0 && isfinite(u) && isfinite(v))) {
        weft_error(log, "the edge vectors u and v have lengths %g and %g: they span no plane", u,
                   v);
        return spans_plane(geometry) ? WEFT_ERR_FORMAT : res; // it is the transform then
    }
    if (geometry->width == 0 && geometry->height == 0) {
        geometry->width = u >= v ? DEFAULT_SIDE : scaled_side(DEFAULT_SIDE, u, v);
        geometry->height = v >= u ? DEFAULT_SIDE : scaled_side(DEFAULT_SIDE, v, u);
    } else if (geometry->width == 0) {
        geometry->width = scaled_side(geometry->height, u, v);
    } else if (geometry->height == 0) {
        geometry->height = scaled_side(geometry->width, v, u);
    }
    res = WEFT_OK;
fail:
    return res;
}

enum weft_result weft_slice_box_geometry(const struct weft_log *log, const weft_volume *volume,
                                         enum weft_space space, const double low[3],
                                         const double high[3], int axis, double coordinate,
                                         int width, int height, struct weft_slice_geometry *out)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, axis >= 0 && axis < 3);
    weft_require_enum(log, space, WEFT_SPACE_INDEX);
    weft_require(log, !isinf(coordinate));
    int along_u = axis == 0 ? 1 : 0, along_v = axis == 2 ? 1 : 2;
    *out = (struct weft_slice_geometry){
        .origin = {low[0], low[1], low[2]}, .width = width, .height = height};
    out->origin[axis] = isnan(coordinate) ? 0.5 * (low[axis] + high[axis]) : coordinate;
    out->u[along_u] = high[along_u] - low[along_u];
    out->v[along_v] = high[along_v] - low[along_v];
    if (!isfinite(out->origin[axis]) || !isfinite(low[along_u]) || !isfinite(low[along_v]) ||
        !spans_plane(out)) {
        weft_error(log, "grid %s: its transform leaves no box to cut: (%g, %g, %g) to (%g, %g, %g)",
                   weft_volume_get_info(volume)->name, low[0], low[1], low[2], high[0], high[1],
                   high[2]);
        return WEFT_ERR_FORMAT;
    }
    res = weft_slice_size_compute(log, volume, space, out);
fail:
    return res;
}

enum weft_result weft_slice_axis_geometry(const struct weft_log *log, const weft_volume *volume,
                                          enum weft_space space, int axis, double coordinate,
                                          int width, int height, struct weft_slice_geometry *out)
{
    double low[3], high[3];
    weft_slice_active_box(weft_volume_get_info(volume), space, low, high);
    return weft_slice_box_geometry(log, volume, space, low, high, axis, coordinate, width, height,
                                   out);
}
