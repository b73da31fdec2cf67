// SPDX-License-Identifier: BSD-3-Clause
#include "tools/antialias/drawer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/log.h"

const char *const antialias_way_names[] = {"acaa", "msaa", "adaptive", "supersample", "none", NULL};

struct antialias_drawer {
    struct antialias_params params;
    // One of these, by the way: of supersampling `adaptive` without a marker.
    weft_acaa *acaa;
    weft_msaa *msaa;
    struct antialias_adaptive adaptive;
};

// ---- making -------------------------------------------------------------------------------------

static enum weft_result create_acaa(antialias_drawer *drawer)
{
    const struct antialias_params *p = &drawer->params;
    struct weft_acaa_params *params =
        weft_acaa_params(.width = p->size[0], .height = p->size[1], .samples = p->samples,
                         .form = p->form, .coincident = p->coincident, .filter = p->filter,
                         .filter_width = p->filter_width, .sums = p->sums, .range = p->sum_range,
                         .depth_bits = p->depth_bits, .context = p->context, .log = p->log);
    memcpy(params->background, p->background, sizeof params->background);
    return weft_acaa_create(params, &drawer->acaa);
}

static enum weft_result create_msaa(antialias_drawer *drawer)
{
    const struct antialias_params *p = &drawer->params;
    struct weft_msaa_params *params =
        weft_msaa_params(.width = p->size[0], .height = p->size[1], .samples = p->samples,
                         .format = p->format, .resolve = p->resolve, .range = p->sum_range,
                         .depth_bits = p->depth_bits, .context = p->context, .log = p->log);
    memcpy(params->background, p->background, sizeof params->background);
    return weft_msaa_create(params, &drawer->msaa);
}

// The set of samples; of a grid none: supersampling has it by itself. To be cleared.
static enum weft_result make_pattern(const struct antialias_params *p, struct weft_jitter *out)
{
    *out = (struct weft_jitter){0};
    if (!p->pattern)
        return WEFT_OK;
    return weft_jitter_create(weft_jitter_params(.info = p->pattern, .count = p->samples,
                                                 .seed = p->seed, .centre = true, .log = p->log),
                              out);
}

static enum weft_result create_supersample(antialias_drawer *drawer)
{
    const struct antialias_params *p = &drawer->params;
    struct weft_jitter set;
    enum weft_result res = make_pattern(p, &set);
    if (res != WEFT_OK)
        return res;
    struct weft_supersample_params *params =
        weft_supersample_params(.width = p->size[0], .height = p->size[1],
                                .position = (const double(*)[2])set.points, .count = p->samples,
                                .filter = p->filter, .filter_width = p->filter_width,
                                .store = p->store, .format = p->format, .method = p->method,
                                .context = p->context, .log = p->log);
    struct weft_marker_params *marker =
        weft_marker_params(.width = p->size[0], .height = p->size[1], .format = p->format,
                           .mark = p->mark, .contrast = p->contrast, .max_share = p->max_share,
                           .context = p->context, .log = p->log);
    memcpy(params->background, p->background, sizeof params->background);
    memcpy(marker->background, p->background, sizeof marker->background);
    res = p->way == ANTIALIAS_ADAPTIVE
              ? antialias_adaptive_create(marker, params, &drawer->adaptive)
              : weft_supersample_create(params, &drawer->adaptive.supersample);
    weft_jitter_clear(&set);
    return res;
}

enum weft_result antialias_drawer_create(const struct antialias_params *params,
                                         antialias_drawer **out)
{
    static enum weft_result (*const create[])(antialias_drawer *) = {
        create_acaa, create_msaa, create_supersample, create_supersample, create_msaa};
    antialias_drawer *drawer = *out = calloc(1, sizeof *drawer);
    if (!drawer) {
        log_error(params->log, "out of memory for a drawer of pictures");
        return WEFT_ERR_MEMORY;
    }
    drawer->params = *params;
    const enum weft_result res = create[params->way](drawer);
    if (res != WEFT_OK)
        antialias_drawer_destroy(out);
    return res;
}

void antialias_drawer_destroy(antialias_drawer **drawer)
{
    if (!*drawer)
        return;
    weft_acaa_destroy(&(*drawer)->acaa);
    weft_msaa_destroy(&(*drawer)->msaa);
    antialias_adaptive_clear(&(*drawer)->adaptive);
    free(*drawer);
    *drawer = NULL;
}

// ---- drawing ------------------------------------------------------------------------------------

enum weft_result antialias_drawer_run(antialias_drawer *drawer,
                                      const struct weft_antialias_drawing *drawing, int picture,
                                      const struct weft_progress *progress)
{
    switch (drawer->params.way) {
    case ANTIALIAS_ACAA:
        return weft_acaa_run(drawer->acaa, drawing, progress);
    case ANTIALIAS_ADAPTIVE:
        return antialias_adaptive_run(&drawer->adaptive, drawing, picture, progress);
    case ANTIALIAS_SUPERSAMPLE:
        return weft_supersample_run(drawer->adaptive.supersample, drawing, NULL, progress);
    default:
        return weft_msaa_run(drawer->msaa, drawing);
    }
}

void antialias_drawer_get_room(const antialias_drawer *drawer, struct weft_acaa_room *out)
{
    *out = (struct weft_acaa_room){0};
    if (drawer->acaa)
        weft_acaa_get_room(drawer->acaa, out);
}

enum weft_result antialias_drawer_set_room(antialias_drawer *drawer,
                                           const struct weft_acaa_room *room)
{
    return drawer->acaa ? weft_acaa_set_room(drawer->acaa, room) : WEFT_OK;
}

enum weft_result antialias_drawer_read(antialias_drawer *drawer, int channel, float *out)
{
    switch (drawer->params.way) {
    case ANTIALIAS_ACAA:
        return weft_acaa_read(drawer->acaa, channel, out, 0);
    case ANTIALIAS_ADAPTIVE:
        return antialias_adaptive_read(&drawer->adaptive, channel, out);
    case ANTIALIAS_SUPERSAMPLE:
        return weft_supersample_read(drawer->adaptive.supersample, channel, out, 0);
    default:
        return weft_msaa_read(drawer->msaa, channel, out, 0);
    }
}

enum weft_result antialias_drawer_read_weight(antialias_drawer *drawer, float *out)
{
    return drawer->acaa ? weft_acaa_read_weight(drawer->acaa, out, 0) : WEFT_ERR_ARGUMENT;
}

// ---- what they took -----------------------------------------------------------------------------

enum { PAPER_COLOUR = 3, PAPER_DEPTH = 4 }; // bytes in the accounting of Lin and others

static void report_acaa(const antialias_drawer *drawer, struct antialias_report *out)
{
    const struct antialias_params *p = &drawer->params;
    weft_acaa_get_report(drawer->acaa, &out->acaa);
    out->samples = out->acaa.samples;
    out->passes = out->acaa.passes;
    out->discrepancy = out->acaa.discrepancy;
    out->radius = out->acaa.radius;
    out->bound = out->acaa.bound;
    out->formula_bytes = out->acaa.formula_bytes;
    out->bytes = out->acaa.bytes;
    for (int f = 0; f < WEFT_ANTIALIAS_FORMAT_COUNT; f++)
        out->multisample_bytes[f] =
            weft_bytes_multisample(p->size[0], p->size[1], out->samples,
                                   weft_antialias_format_bytes((enum weft_antialias_format)f), 4);
}

static void report_msaa(const antialias_drawer *drawer, struct antialias_report *out)
{
    weft_msaa_get_report(drawer->msaa, &out->msaa);
    out->samples = out->msaa.samples;
    out->passes = 1;
    out->discrepancy = out->msaa.discrepancy;
    out->formula_bytes = out->msaa.formula_bytes;
    out->bytes = out->msaa.bytes;
}

static void report_supersample(const antialias_drawer *drawer, struct antialias_report *out)
{
    const struct antialias_params *p = &drawer->params;
    const struct antialias_adaptive *a = &drawer->adaptive;
    weft_supersample_get_report(a->supersample, &out->supersample);
    out->samples = p->samples;
    out->passes = p->samples + (a->marker ? 1 : 0);
    out->discrepancy = out->supersample.discrepancy;
    out->radius = out->supersample.radius;
    out->bound = out->supersample.bound;
    out->bytes = out->supersample.bytes;
    out->full_bytes =
        weft_bytes_multisample(p->size[0], p->size[1], p->samples, PAPER_COLOUR, PAPER_DEPTH);
    out->formula_bytes = out->full_bytes;
    if (!a->marker)
        return;
    if (!a->supersampled)
        out->supersample.pixels = out->supersample.sampled = 0;
    out->bytes += weft_marker_bytes(a->marker);
    antialias_report_set_marks(p, &a->marks, out);
}

void antialias_report_set_marks(const struct antialias_params *params,
                                const struct weft_marks *marks, struct antialias_report *out)
{
    out->marks = marks;
    out->formula_bytes = weft_bytes_adaptive(params->size[0], params->size[1], marks->count,
                                             params->samples, PAPER_COLOUR, PAPER_DEPTH);
    if (marks->count == 0)
        out->passes = 1;
}

void antialias_drawer_get_report(const antialias_drawer *drawer, struct antialias_report *out)
{
    *out = (struct antialias_report){.bound = NAN};
    if (drawer->acaa)
        report_acaa(drawer, out);
    else if (drawer->msaa)
        report_msaa(drawer, out);
    else
        report_supersample(drawer, out);
}
