// SPDX-License-Identifier: BSD-3-Clause
#include "tools/antialias/adaptive.h"

#include <stdlib.h>
#include <string.h>

enum weft_result antialias_adaptive_create(const struct weft_marker_params *marker,
                                           const struct weft_supersample_params *supersample,
                                           struct antialias_adaptive *out)
{
    struct weft_marker_params params = *marker;
    struct weft_supersample_report report;
    *out = (struct antialias_adaptive){.picture = -1,
                                       .by_share = marker->max_share > 0.0,
                                       .size = {marker->width, marker->height}};
    enum weft_result res = weft_supersample_create(supersample, &out->supersample);
    if (res == WEFT_OK) {
        weft_supersample_get_report(out->supersample, &report);
        params.reach = report.radius;
        res = weft_marker_create(&params, &out->marker);
    }
    if (res != WEFT_OK)
        antialias_adaptive_clear(out);
    return res;
}

void antialias_adaptive_clear(struct antialias_adaptive *adaptive)
{
    weft_supersample_destroy(&adaptive->supersample);
    weft_marker_destroy(&adaptive->marker);
    weft_marks_clear(&adaptive->marks);
    *adaptive = (struct antialias_adaptive){.marker = NULL};
}

static enum weft_result mark(struct antialias_adaptive *adaptive,
                             const struct weft_antialias_drawing *drawing, int picture)
{
    struct weft_antialias_drawing marked = *drawing;
    if (adaptive->by_share && drawing->part.width && adaptive->picture == picture)
        return WEFT_OK;
    if (adaptive->by_share)
        marked.part = (struct weft_rectangle){0};
    weft_marks_clear(&adaptive->marks);
    adaptive->picture = picture;
    return weft_marker_run(adaptive->marker, &marked, &adaptive->marks);
}

enum weft_result antialias_adaptive_run(struct antialias_adaptive *adaptive,
                                        const struct weft_antialias_drawing *drawing, int picture,
                                        const struct weft_progress *progress)
{
    const struct weft_marks *marks = &adaptive->marks;
    adaptive->part = drawing->part;
    adaptive->supersampled = false;
    enum weft_result res = mark(adaptive, drawing, picture);
    // Pixels around the part may be marked though none of its own is.
    if (res == WEFT_OK)
        adaptive->supersampled =
            memchr(marks->marked, 1, (size_t)marks->part.width * (size_t)marks->part.height);
    if (adaptive->supersampled)
        res = weft_supersample_run(adaptive->supersample, drawing, marks, progress);
    if (res != WEFT_OK) {
        weft_marks_clear(&adaptive->marks);
        adaptive->picture = -1;
    }
    return res;
}

// Of the whole picture that was marked.
static enum weft_result read_part(const struct antialias_adaptive *adaptive, int channel,
                                  float *out)
{
    const struct weft_rectangle *part = &adaptive->part;
    const size_t width = (size_t)adaptive->size[0];
    float *all = malloc(width * (size_t)adaptive->size[1] * sizeof *all);
    if (!all)
        return WEFT_ERR_MEMORY;
    const enum weft_result res = weft_marker_read(adaptive->marker, channel, all, 0);
    for (int32_t y = 0; y < part->height && res == WEFT_OK; y++)
        memcpy(out + (size_t)y * (size_t)part->width,
               all + (size_t)(part->y + y) * width + (size_t)part->x,
               (size_t)part->width * sizeof *out);
    free(all);
    return res;
}

enum weft_result antialias_adaptive_read(const struct antialias_adaptive *adaptive, int channel,
                                         float *out)
{
    const enum weft_result res = adaptive->by_share && adaptive->part.width
                                     ? read_part(adaptive, channel, out)
                                     : weft_marker_read(adaptive->marker, channel, out, 0);
    return res == WEFT_OK && adaptive->supersampled
               ? weft_supersample_read(adaptive->supersample, channel, out, 0)
               : res;
}
