// SPDX-License-Identifier: BSD-3-Clause
// Pixels of pictures, and how square they are.
#include <math.h>
#include <stdio.h>

#include "tools/common/report.h"
#include "tools/framing/framing.h"

enum weft_result framing_choose_size(const struct framing_size *size, const weft_volume *volume,
                                     enum weft_space space, struct weft_slice_geometry *g)
{
    g->width = size->longer ? size->longer : size->side[0];
    g->height = size->side[1];
    enum weft_result res = weft_slice_size_compute(report_log(), volume, space, g);
    if (res == WEFT_OK && size->longer && g->height > size->longer) {
        g->width = 0;
        g->height = size->longer;
        res = weft_slice_size_compute(report_log(), volume, space, g);
    }
    if (res != WEFT_OK || (int64_t)g->width * g->height <= WEFT_SLICE_MAX_PIXELS)
        return res;
    report_error("%d x %d pixels: there may be at most %lld in all", g->width, g->height,
                 (long long)WEFT_SLICE_MAX_PIXELS);
    return WEFT_ERR_ARGUMENT;
}

// Whether a side is within a pixel of what it should be.
static bool is_near(double side, double wanted)
{
    return fabs(side - wanted) <= 1.0;
}

void framing_format_aspect(const double lengths[2], int width, int height, const char *where,
                           char out[FRAMING_TEXT])
{
    *out = 0;
    // Of a pixel: its width for its height.
    const double aspect = lengths[0] / width / (lengths[1] / height);
    if (!(aspect > 0.0 && isfinite(aspect)) || is_near(height, height / aspect) ||
        is_near(width, width * aspect))
        return;
    const bool wide = aspect > 1.0;
    const double times = wide ? aspect : 1.0 / aspect;
    char by[60];
    if (times < 1.1)
        snprintf(by, sizeof by, "%.2g %% %s than", 100.0 * (times - 1.0),
                 wide ? "wider" : "higher");
    else
        snprintf(by, sizeof by, "%.3g times as %s as", times, wide ? "wide" : "high");
    snprintf(out, FRAMING_TEXT,
             "%d x %d pixels are not square: %s %s%s; %dx0 or 0x%d keeps them so", width, height,
             by, wide ? "high" : "wide", where, width, height);
}

void framing_format_cut(const weft_volume *volume, enum weft_space space,
                        const struct weft_slice_geometry *g, char out[FRAMING_TEXT])
{
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    double lengths[2] = {0};
    for (int e = 0; e < 2; e++) {
        const double *edge = e ? g->v : g->u;
        for (int r = 0; r < 3; r++) {
            const double *m = info->index_to_world[r];
            const double along = space == WEFT_SPACE_WORLD
                                     ? edge[r]
                                     : m[0] * edge[0] + m[1] * edge[1] + m[2] * edge[2];
            lengths[e] = hypot(lengths[e], along);
        }
    }
    framing_format_aspect(lengths, g->width, g->height, " in world space", out);
}
