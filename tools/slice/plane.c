// SPDX-License-Identifier: BSD-3-Clause
// What is cut, and where.
#include "tools/slice/stages.h"

#include <math.h>
#include <string.h>

#include "tools/common/report.h"

enum weft_result slice_open(struct slice_job *job)
{
    double start = report_now_seconds();
    const struct weft_volume_open_params params = {
        .path = job->input,
        .grid = job->setup->option[SLICE_GRID].text,
        .log = report_log(),
    };
    report_stage("reading", job->input);
    enum weft_result res = weft_volume_open(&params, &job->volume);
    job->open_seconds = report_now_seconds() - start;
    return res;
}

enum weft_result slice_place(struct slice_job *job)
{
    const struct option_value *o = job->setup->option;
    const enum weft_space space = (enum weft_space)o[SLICE_SPACE].integer[0];
    struct weft_slice_geometry *out = &job->geometry;
    int width = (int)o[SLICE_SIZE].integer[0], height = (int)o[SLICE_SIZE].integer[1];
    if (!o[SLICE_ORIGIN].given) {
        int axis = o[SLICE_AXIS].given ? (int)o[SLICE_AXIS].integer[0] : 2;
        double at = o[SLICE_AT].given ? o[SLICE_AT].number[0] : NAN;
        return weft_slice_axis_geometry(report_log(), job->volume, space, axis, at, width, height,
                                        out);
    }
    *out = (struct weft_slice_geometry){.width = width, .height = height};
    memcpy(out->origin, o[SLICE_ORIGIN].number, sizeof out->origin);
    memcpy(out->u, o[SLICE_U].number, sizeof out->u);
    memcpy(out->v, o[SLICE_V].number, sizeof out->v);
    return weft_slice_size_compute(report_log(), job->volume, space, out);
}
