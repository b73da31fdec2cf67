// SPDX-License-Identifier: BSD-3-Clause
// Where it is cut.
#include "tools/slice/stages.h"

#include <math.h>
#include <string.h>

#include "tools/common/report.h"

// The plane that --axis or --origin say, for FIRST.
static enum weft_result find_plane(const struct slice_job *job, int width, int height,
                                   struct weft_slice_geometry *out)
{
    const struct option_value *o = job->setup->option;
    const enum weft_space space = (enum weft_space)o[SLICE_SPACE].integer[0];
    if (!o[SLICE_ORIGIN].given) {
        const int axis = o[SLICE_AXIS].given ? (int)o[SLICE_AXIS].integer[0] : 2;
        const double at = o[SLICE_AT].given ? o[SLICE_AT].number[0] : NAN;
        return weft_slice_axis_geometry(report_log(), job->volume, space, axis, at, width, height,
                                        out);
    }
    *out = (struct weft_slice_geometry){.width = width, .height = height};
    memcpy(out->origin, o[SLICE_ORIGIN].number, sizeof out->origin);
    memcpy(out->u, o[SLICE_U].number, sizeof out->u);
    memcpy(out->v, o[SLICE_V].number, sizeof out->v);
    return weft_slice_size_compute(report_log(), job->volume, space, out);
}

// Frame f of FIRST to LAST lies at A + t (B - A) with t from 0 to 1, so that both ends are met
// exactly, or f - FIRST steps away.
static void move_plane(const struct slice_job *job, struct weft_slice_geometry *g)
{
    const struct slice_sweep *sweep = &job->setup->sweep;
    const struct option_value *o = job->setup->option, *at = &o[SLICE_AT], *step = &o[SLICE_STEP];
    const double moved = (double)(job->frame - sweep->first);
    const int axis = o[SLICE_AXIS].given ? (int)o[SLICE_AXIS].integer[0] : 2;
    if (at->given && at->integer[0] && sweep->last > sweep->first) {
        const double t = moved / (double)(sweep->last - sweep->first);
        g->origin[axis] = (1.0 - t) * at->number[0] + t * at->number[1];
    }
    for (int c = 0; step->given && c < 3; c++)
        g->origin[c] += moved * step->number[c];
}

static enum weft_result take_plane(struct slice_job *job, int width, int height,
                                   struct weft_slice_geometry *out)
{
    const struct option_value *o = job->setup->option;
    const struct slice_plane *plane =
        &job->setup->sweep.planes[job->frame - job->setup->sweep.first];
    *out = (struct weft_slice_geometry){.width = width, .height = height};
    memcpy(out->origin, plane->origin, sizeof out->origin);
    memcpy(out->u, plane->u, sizeof out->u);
    memcpy(out->v, plane->v, sizeof out->v);
    return weft_slice_size_compute(report_log(), job->volume,
                                   (enum weft_space)o[SLICE_SPACE].integer[0], out);
}

// Told once: a part of a later volume is not in the picture.
static void warn_of_growth(const struct slice_job *job)
{
    struct slice_setup *setup = job->setup;
    const struct weft_slice_geometry *kept = &setup->plane;
    struct weft_slice_geometry own;
    if (setup->option[SLICE_ORIGIN].given || setup->volume_grew ||
        find_plane(job, kept->width, kept->height, &own) != WEFT_OK)
        return;
    for (int c = 0; c < 3; c++) {
        const double along = kept->u[c] + kept->v[c], slack = 1e-6 * along;
        setup->volume_grew =
            setup->volume_grew || (along > 0.0 && (own.origin[c] < kept->origin[c] - slack ||
                                                   own.origin[c] + own.u[c] + own.v[c] >
                                                       kept->origin[c] + along + slack));
    }
    if (setup->volume_grew)
        report_warning("the active box of %s reaches beyond the first volume's, which all frames "
                       "show; --origin, --u and --v say another plane",
                       job->input);
}

enum weft_result slice_place(struct slice_job *job)
{
    struct slice_setup *setup = job->setup;
    const struct option_value *size = &setup->option[SLICE_SIZE];
    const int width = (int)size->integer[0], height = (int)size->integer[1];
    if (setup->sweep.planes)
        return take_plane(job, width, height, &job->geometry);
    // One plane for all frames: a pixel is the same place in all of them but for what moves.
    if (!setup->plane.width) {
        const enum weft_result res = find_plane(job, width, height, &job->geometry);
        if (res != WEFT_OK)
            return res;
        setup->plane = job->geometry;
    }
    warn_of_growth(job);
    job->geometry = setup->plane;
    move_plane(job, &job->geometry);
    return WEFT_OK;
}
