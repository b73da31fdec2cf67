// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>
#include <stdio.h>

#include "filter/check.h"
#include "passes/positions/grid.h"

// Whether a planar cut in index space, widened by `reach` voxels, may meet a box: neither the axes
// nor the plane's normal separate them.
static bool meets(const struct weft_slice_geometry *cut, const double low[3], const double high[3],
                  double reach)
{
    double normal[3], nearest = 0.0, farthest = 0.0, length = 0.0;
    for (int a = 0; a < 3; a++) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        const double o = cut->origin[a], u = cut->u[a], v = cut->v[a];
        if (o + fmin(0.0, u) + fmin(0.0, v) - reach > high[a] ||
            o + fmax(0.0, u) + fmax(0.0, v) + reach < low[a])
            return false;
        normal[a] = cut->u[b] * cut->v[c] - cut->u[c] * cut->v[b];
        length += normal[a] * normal[a];
        const double from = normal[a] * (low[a] - o), to = normal[a] * (high[a] - o);
        nearest += fmin(from, to);
        farthest += fmax(from, to);
    }
    // A cube of half-width `reach` reaches sqrt(3) times as far along a diagonal.
    const double margin = reach * sqrt(3.0 * length);
    return nearest <= margin && farthest >= -margin;
}

// Whether the numbers of a cut, taken for those of the other space, meet the box of index space.
static bool meets_otherwise(const struct weft_slice_geometry *cut, enum weft_space space,
                            const struct weft_volume_info *volume, const double low[3],
                            const double high[3], double reach)
{
    struct weft_slice_geometry index = *cut;
    double inverse[3][4];
    if (space == WEFT_SPACE_WORLD)
        return meets(cut, low, high, reach);
    if (!weft_affine_invert(volume->index_to_world, inverse))
        return false;
    for (int r = 0; r < 3; r++) {
        const double *m = inverse[r];
        index.origin[r] =
            m[0] * cut->origin[0] + m[1] * cut->origin[1] + m[2] * cut->origin[2] + m[3];
        index.u[r] = m[0] * cut->u[0] + m[1] * cut->u[1] + m[2] * cut->u[2];
        index.v[r] = m[0] * cut->v[0] + m[1] * cut->v[1] + m[2] * cut->v[2];
    }
    return meets(&index, low, high, reach);
}

// Where a plane across an axis comes to the outermost voxels' centres, if it does by moving along
// that axis; NAN: it does not.
static double nearest_plane(const struct weft_slice_geometry *cut, enum weft_space space,
                            const struct weft_volume_info *volume, const double low[3],
                            const double high[3], int *axis)
{
    int a = 0;
    while (a < 3 && (cut->u[a] != 0.0 || cut->v[a] != 0.0))
        a++;
    if (a == 3)
        return NAN;
    double half = 0.5;
    if (space == WEFT_SPACE_WORLD)
        half = 0.5 * (fabs(volume->index_to_world[a][0]) + fabs(volume->index_to_world[a][1]) +
                      fabs(volume->index_to_world[a][2]));
    struct weft_slice_geometry moved = *cut;
    moved.origin[a] = fmin(fmax(cut->origin[a], low[a] + half), high[a] - half);
    *axis = a;
    return moved.origin[a] != cut->origin[a] && meets(&moved, low, high, 0.0) ? moved.origin[a]
                                                                              : NAN;
}

// What would meet the volume.
static void advise(const struct weft_slice_geometry *cut, enum weft_space space, double reach,
                   const struct weft_volume_info *volume, char *text, size_t size)
{
    const enum weft_space other = space == WEFT_SPACE_WORLD ? WEFT_SPACE_INDEX : WEFT_SPACE_WORLD;
    double low[3], high[3];
    int axis = 0;
    weft_slice_active_box(volume, space, low, high);
    const double at = nearest_plane(cut, space, volume, low, high, &axis);
    size_t used = 0;
    *text = 0;
    if (!isnan(at))
        used = (size_t)snprintf(
            text, size, "; the nearest plane across %c that meets it is at %.7g", "xyz"[axis], at);
    weft_slice_active_box(volume, WEFT_SPACE_INDEX, low, high);
    if (meets_otherwise(cut, space, volume, low, high, reach))
        snprintf(text + used, size - used, "; in %s space the same numbers would meet it",
                 weft_space_names[other]);
}

void weft_slice_miss_report(const struct weft_log *log, const struct weft_slice_grid *grid,
                            const struct weft_slice_geometry *geometry, enum weft_space space,
                            int taps, const struct weft_volume_info *volume)
{
    const double reach = 0.5 * taps;
    double low[3], high[3];
    weft_slice_active_box(volume, WEFT_SPACE_INDEX, low, high);
    const bool met = !volume->empty && meets(&grid->index, low, high, reach);
    char advice[160] = "";
    if (!volume->empty && !met)
        advise(geometry, space, reach, volume, advice, sizeof advice);
    weft_slice_active_box(volume, space, low, high);
    char box[200] = "which has no active voxels";
    if (!volume->empty)
        snprintf(box, sizeof box, "whose active voxels lie from (%g, %g, %g) to (%g, %g, %g) in %s",
                 low[0], low[1], low[2], high[0], high[1], high[2],
                 space == WEFT_SPACE_WORLD ? "world space" : "index space");
    if (met)
        weft_warn(log,
                  "the slice crosses grid %s, %s, but no pixel comes near one of them: every pixel "
                  "is the background, %g",
                  volume->name, box, volume->background);
    else
        weft_warn(log, "the slice misses grid %s, %s: every pixel is the background, %g%s",
                  volume->name, box, volume->background, advice);
}
