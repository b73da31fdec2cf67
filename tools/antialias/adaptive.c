// SPDX-License-Identifier: BSD-3-Clause
#include "tools/antialias/adaptive.h"

enum weft_result antialias_adaptive_create(const struct weft_marker_params *marker,
                                           const struct weft_supersample_params *supersample,
                                           struct antialias_adaptive *out)
{
    *out = (struct antialias_adaptive){0};
    enum weft_result res = weft_marker_create(marker, &out->marker);
    if (res == WEFT_OK)
        res = weft_supersample_create(supersample, &out->supersample);
    if (res != WEFT_OK)
        antialias_adaptive_clear(out);
    return res;
}

void antialias_adaptive_clear(struct antialias_adaptive *adaptive)
{
    weft_supersample_destroy(&adaptive->supersample);
    weft_marker_destroy(&adaptive->marker);
    weft_marks_clear(&adaptive->marks);
}

enum weft_result antialias_adaptive_run(struct antialias_adaptive *adaptive,
                                        const struct weft_antialias_drawing *drawing,
                                        const struct weft_progress *progress)
{
    weft_marks_clear(&adaptive->marks);
    enum weft_result res = weft_marker_run(adaptive->marker, drawing, &adaptive->marks);
    if (res == WEFT_OK && adaptive->marks.count > 0)
        res = weft_supersample_run(adaptive->supersample, drawing, &adaptive->marks, progress);
    if (res != WEFT_OK)
        weft_marks_clear(&adaptive->marks);
    return res;
}

enum weft_result antialias_adaptive_read(const struct antialias_adaptive *adaptive, int channel,
                                         float *out)
{
    const enum weft_result res = weft_marker_read(adaptive->marker, channel, out, 0);
    return res == WEFT_OK && adaptive->marks.count > 0
               ? weft_supersample_read(adaptive->supersample, channel, out, 0)
               : res;
}
