// SPDX-License-Identifier: BSD-3-Clause
// Where it is cut, and what of it the picture shows.
#include "tools/slice/stages.h"

#include <math.h>
#include <string.h>

#include "tools/common/numbered.h"
#include "tools/common/report.h"

// ---- options ------------------------------------------------------------------------------------

static int axis_of(const struct slice_setup *setup)
{
    const struct option_value *axis = &setup->option[SLICE_AXIS];
    return axis->given ? (int)axis->integer[0] : 2;
}

static enum weft_result read_options(struct slice_setup *setup)
{
    const struct option_value *o = setup->option;
    struct framing *f = &setup->framing;
    enum weft_result res = WEFT_OK;
    *f = (struct framing){.is_at = o[SLICE_AT].given, .is_up = o[SLICE_UP].given};
    f->columns = o[SLICE_FLIP].given && o[SLICE_FLIP].integer[0] != 1;
    f->rows = o[SLICE_FLIP].given && o[SLICE_FLIP].integer[0] != 0;
    if (o[SLICE_SIZE].given)
        res = framing_read_size(o[SLICE_SIZE].text, WEFT_SLICE_MAX_SIZE, WEFT_SLICE_MAX_PIXELS,
                                &f->size);
    if (res == WEFT_OK && f->is_at)
        res = framing_read_at(o[SLICE_AT].text, &f->at);
    if (res == WEFT_OK && f->is_up)
        res = framing_read_up(o[SLICE_UP].text, f->up);
    if (res == WEFT_OK && o[SLICE_BOX].given)
        res = framing_read_box(o[SLICE_BOX].text, f);
    return res;
}

// Whether a direction runs across the plane that --axis cuts.
static bool is_across(const struct slice_setup *setup)
{
    const int axis = axis_of(setup);
    const double *up = setup->framing.up;
    return !setup->option[SLICE_ORIGIN].given && up[(axis + 1) % 3] == 0.0 &&
           up[(axis + 2) % 3] == 0.0;
}

static const char *find_conflict(const struct slice_setup *setup)
{
    static const char *const across[] = {
        "--up: x runs across the plane that --axis x cuts; y, -y, z and -z lie in it",
        "--up: y runs across the plane that --axis y cuts; x, -x, z and -z lie in it",
        "--up: z runs across the plane that --axis z cuts; x, -x, y and -y lie in it"};
    const struct option_value *o = setup->option;
    if (slice_is_curved(setup))
        return NULL; // slice_check_curve tells what is of planes
    if (o[SLICE_UP].given && o[SLICE_PLANES].given)
        return "--up is not of --planes: their lines say what is up, against v";
    if (o[SLICE_UP].given && is_across(setup))
        return across[axis_of(setup)];
    if (o[SLICE_BOX].given && (o[SLICE_ORIGIN].given || o[SLICE_PLANES].given))
        return "--box is what planes of --axis show, and not of --origin or --planes";
    if (o[SLICE_BOX].given && setup->framing.box != FRAMING_BOX_GIVEN &&
        !(o[SLICE_FRAMES].given && numbered_is(setup->input)))
        return "--box all and --box first are of --frames with a volume each, as smoke_%04d.vdb";
    return NULL;
}

enum weft_result slice_read_framing(struct slice_setup *setup)
{
    const enum weft_result res = read_options(setup);
    const char *conflict = res == WEFT_OK ? find_conflict(setup) : NULL;
    if (!conflict)
        return res;
    report_error("%s", conflict);
    return WEFT_ERR_ARGUMENT;
}

// ---- the box ------------------------------------------------------------------------------------

static enum weft_space space_of(const struct slice_setup *setup)
{
    return (enum weft_space)setup->option[SLICE_SPACE].integer[0];
}

// What --at says, in the plane's space: of its first frame, and its last.
static void find_places(struct slice_setup *setup)
{
    struct slice_frame *frame = &setup->frame;
    const struct framing *f = &setup->framing;
    const int axis = axis_of(setup);
    for (int i = 0; i < 2; i++) {
        const double low = frame->low[axis], high = frame->high[axis];
        frame->at[i] = !f->is_at       ? NAN
                       : f->at.part[i] ? low + f->at.at[i] * (high - low)
                                       : f->at.at[i];
    }
}

// The box that --axis cuts, once for all frames.
static void find_frame(const struct slice_job *job)
{
    struct slice_setup *setup = job->setup;
    struct slice_frame *frame = &setup->frame;
    const struct slice_sweep *sweep = &setup->sweep;
    const struct framing *f = &setup->framing;
    if (f->box == FRAMING_BOX_GIVEN) {
        memcpy(frame->low, f->low, sizeof frame->low);
        memcpy(frame->high, f->high, sizeof frame->high);
    } else {
        weft_slice_active_box(weft_volume_get_info(job->volume), space_of(setup), frame->low,
                              frame->high);
    }
    if (f->box == FRAMING_BOX_ALL && sweep->given && sweep->count > 1 && numbered_is(setup->input))
        framing_widen_box(&(struct framing_files){.name = setup->input,
                                                  .first = sweep->first,
                                                  .step = sweep->step,
                                                  .count = sweep->count,
                                                  .grid = setup->source[0].grid,
                                                  .raw = setup->raw},
                          space_of(setup), frame->low, frame->high);
    find_places(setup);
}

// Told once: a part of a later volume is not in the picture, and nobody asked for that.
static void warn_of_growth(const struct slice_job *job)
{
    struct slice_setup *setup = job->setup;
    const struct slice_frame *frame = &setup->frame;
    double low[3], high[3];
    if (setup->option[SLICE_ORIGIN].given || setup->option[SLICE_BOX].given || setup->volume_grew ||
        weft_volume_get_info(job->volume)->empty)
        return;
    weft_slice_active_box(weft_volume_get_info(job->volume), space_of(setup), low, high);
    for (int c = 0; c < 3; c++) {
        const double slack = 1e-6 * (frame->high[c] - frame->low[c]);
        setup->volume_grew = setup->volume_grew ||
                             (c != axis_of(setup) &&
                              (low[c] < frame->low[c] - slack || high[c] > frame->high[c] + slack));
    }
    if (setup->volume_grew)
        report_warning("the active box of %s reaches beyond what its header told, and so beyond "
                       "what all frames show; --box X0,Y0,Z0,X1,Y1,Z1 says another",
                       job->input);
}

// ---- planes -------------------------------------------------------------------------------------

// Turned, mirrored and of the size that is asked for. Edges that are given stay.
static enum weft_result orient(const struct slice_job *job, bool given,
                               struct weft_slice_geometry *g)
{
    struct slice_setup *setup = job->setup;
    const struct framing *f = &setup->framing;
    enum weft_result res = WEFT_OK;
    if (f->is_up)
        res = weft_slice_turn(report_log(), job->volume, space_of(setup), f->up, !given, g);
    if (res != WEFT_OK)
        return res;
    weft_slice_mirror(f->columns, f->rows, g);
    res = framing_choose_size(&f->size, job->volume, space_of(setup), g);
    if (res != WEFT_OK || !f->size.side[0] || !f->size.side[1] || setup->aspect[0])
        return res;
    framing_format_cut(job->volume, space_of(setup), g, setup->aspect);
    return WEFT_OK;
}

// The plane that --axis or --origin say, for FIRST.
static enum weft_result find_plane(const struct slice_job *job, struct weft_slice_geometry *out)
{
    const struct slice_setup *setup = job->setup;
    const struct option_value *o = setup->option;
    if (o[SLICE_ORIGIN].given) {
        *out = (struct weft_slice_geometry){.width = 0};
        memcpy(out->origin, o[SLICE_ORIGIN].number, sizeof out->origin);
        memcpy(out->u, o[SLICE_U].number, sizeof out->u);
        memcpy(out->v, o[SLICE_V].number, sizeof out->v);
        return orient(job, true, out);
    }
    find_frame(job);
    const struct slice_frame *frame = &setup->frame;
    const enum weft_result res =
        weft_slice_box_geometry(report_log(), job->volume, space_of(setup), frame->low, frame->high,
                                axis_of(setup), frame->at[0], 0, 0, out);
    return res == WEFT_OK ? orient(job, false, out) : res;
}

// Frame f of FIRST to LAST lies at A + t (B - A) with t from 0 to 1, so that both ends are met
// exactly, or f - FIRST steps away.
static void move_plane(const struct slice_job *job, struct weft_slice_geometry *g)
{
    const struct slice_sweep *sweep = &job->setup->sweep;
    const struct option_value *step = &job->setup->option[SLICE_STEP];
    const double moved = (double)(job->frame - sweep->first);
    if (job->setup->framing.at.moves && sweep->last > sweep->first) {
        const double t = moved / (double)(sweep->last - sweep->first);
        const double *at = job->setup->frame.at;
        g->origin[axis_of(job->setup)] = (1.0 - t) * at[0] + t * at[1];
    }
    for (int c = 0; step->given && c < 3; c++)
        g->origin[c] += moved * step->number[c];
}

static enum weft_result take_plane(struct slice_job *job, struct weft_slice_geometry *out)
{
    const struct slice_plane *plane =
        &job->setup->sweep.planes[job->frame - job->setup->sweep.first];
    *out = (struct weft_slice_geometry){.width = 0};
    memcpy(out->origin, plane->origin, sizeof out->origin);
    memcpy(out->u, plane->u, sizeof out->u);
    memcpy(out->v, plane->v, sizeof out->v);
    return orient(job, true, out);
}

enum weft_result slice_place(struct slice_job *job)
{
    struct slice_setup *setup = job->setup;
    if (setup->sweep.planes)
        return take_plane(job, &job->geometry);
    // One plane for all frames: a pixel is the same place in all of them but for what moves.
    if (!setup->plane.width) {
        const enum weft_result res = find_plane(job, &job->geometry);
        if (res != WEFT_OK)
            return res;
        setup->plane = job->geometry;
    }
    warn_of_growth(job);
    job->geometry = setup->plane;
    move_plane(job, &job->geometry);
    return WEFT_OK;
}
