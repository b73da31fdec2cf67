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

void weft_slice_miss_report(const struct weft_log *log, const struct weft_slice_grid *grid,
                            const struct weft_slice_geometry *geometry, enum weft_space space,
                            int taps, const struct weft_volume_info *volume)
{
    const double reach = 0.5 * taps;
    double low[3], high[3];
    weft_slice_active_box(volume, WEFT_SPACE_INDEX, low, high);
    const bool met = !volume->empty && meets(&grid->index, low, high, reach);
    const bool other =
        !volume->empty && !met && space == WEFT_SPACE_WORLD && meets(geometry, low, high, reach);
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
                  volume->name, box, volume->background,
                  other ? "; in index space the same numbers would meet it" : "");
}
