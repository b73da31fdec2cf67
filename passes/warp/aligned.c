// SPDX-License-Identifier: BSD-3-Clause
// Maps of which each axis of the result follows one of the source: along one axis and then the
// other, channel by channel, by passes/separable. Where the axes are swapped that makes the
// transpose of the pixels, in bands that are turned back.
#include <math.h>
#include <stdlib.h>

#include "filter/threads.h"
#include "passes/warp/careful.h"
#include "tiles/volume/volume.h"

// ---- plan ---------------------------------------------------------------------------------------

// Whether x of the source goes along the result's columns.
static bool is_swapped(const struct weft_warp_plan *plan)
{
    return plan->info.inverse[0] == 0.0;
}

// Among the values that are read, of each of the result's columns or rows.
static double *find_positions(const struct weft_warp_plan *plan, int axis)
{
    const bool down = is_swapped(plan) ? axis == 0 : axis == 1;
    const int count = down ? plan->info.height : plan->info.width;
    double *out = malloc((size_t)count * sizeof *out);
    for (int i = 0; out && i < count; i++) {
        double at[2], scale[2];
        weft_warp_position(plan, down ? 0 : i, down ? i : 0, at, scale);
        out[i] = at[axis] + plan->info.overlap;
    }
    return out;
}

enum weft_result weft_warp_aligned_plan(struct weft_warp_plan *plan)
{
    struct weft_warp_info *info = &plan->info;
    const bool swapped = is_swapped(plan);
    double *at[2] = {find_positions(plan, 0), find_positions(plan, 1)};
    const struct weft_separable_params params = {
        .kernel = info->kernel,
        .size = {plan->values[0], plan->values[1]},
        .width = swapped ? info->height : info->width,
        .height = swapped ? info->width : info->height,
        .x = at[0],
        .y = at[1],
        .stretch = {info->scale[0], info->scale[1]},
        .boundary = info->boundary,
        .engine = info->engine,
        .sums = info->sums,
        .memory_bytes = plan->memory_bytes - (swapped ? plan->memory_bytes / 4 : 0),
        .log = plan->log};
    enum weft_result res = WEFT_ERR_MEMORY;
    if (at[0] && at[1])
        res = weft_separable_plan_create(&params, &plan->separable);
    else
        weft_error(plan->log, "out of memory for the positions of %d x %d pixels", info->width,
                   info->height);
    free(at[0]);
    free(at[1]);
    if (res != WEFT_OK)
        return res;
    const struct weft_separable_info *made = weft_separable_plan_get_info(plan->separable);
    for (int a = 0; a < 2; a++)
        info->taps[a] = made->taps[a];
    info->bound = weft_separable_plan_bound(plan->separable, 1.0, WEFT_VOLUME_PREFILTER_ERROR);
    return WEFT_OK;
}

// ---- run ----------------------------------------------------------------------------------------

struct runner {
    const struct weft_warp_compiled *compiled;
    const struct weft_warp_run_params *params;
    struct weft_separable_survey survey; // of the channel
    int band;                            // columns of the part that are turned back at once
    float *turned;                       // of them
    struct weft_resample_report *report;
};

enum { ROWS = 32 }; // of the part, that a thread turns back together

struct turning {
    const struct runner *r;
    const struct weft_rectangle *band;
    float *plane;
};

static bool turn_rows(void *priv, int thread, size_t number)
{
    const struct turning *t = priv;
    const struct weft_rectangle *part = &t->r->params->part, *band = t->band;
    const int from = (int)number * ROWS;
    const int end = from + ROWS < part->height ? from + ROWS : part->height;
    float *out = t->plane + (band->x - part->x);
    (void)thread;
    for (int x = 0; x < band->width; x++)
        for (int y = from; y < end; y++)
            out[y * t->r->params->stride + x] = t->r->turned[(int64_t)x * part->height + y];
    return true;
}

// As many columns as a quarter of what a run may take has room for, and one at least.
static enum weft_result create_band(struct runner *r)
{
    const struct weft_rectangle *part = &r->params->part;
    const uint64_t column = (uint64_t)part->height * sizeof(float);
    const uint64_t room = r->compiled->plan->memory_bytes / 4 / column;
    r->band = room < (uint64_t)part->width ? (int)room : part->width;
    r->band = r->band > 1 ? r->band : 1;
    r->turned = malloc((size_t)r->band * (size_t)column);
    if (r->turned)
        return WEFT_OK;
    weft_error(r->params->log, "out of memory for %d x %d pixels", r->band, part->height);
    return WEFT_ERR_MEMORY;
}

// Makes a rectangle of the separable plan's pixels.
static enum weft_result filter(struct runner *r, int channel, const struct weft_rectangle *part,
                               float *pixels, int64_t stride, struct weft_resample_steps *steps)
{
    const weft_resample_source *source = r->params->source;
    const struct weft_progress progress = {weft_resample_report_step, steps};
    const struct weft_separable_run_params run = {.samples = weft_resample_values(source, channel),
                                                  .border = source->info.border,
                                                  .window = weft_resample_values_window(source),
                                                  .part = *part,
                                                  .survey = &r->survey,
                                                  .pixels = pixels,
                                                  .stride = stride,
                                                  .progress = &progress,
                                                  .log = r->params->log};
    struct weft_separable_report one;
    const enum weft_result res = weft_separable_run(r->compiled->separable, &run, &one);
    if (res != WEFT_OK)
        return res;
    weft_resample_add_separable(r->compiled->plan->separable, &one, &r->report->work);
    weft_statistics_join(&r->report->pixels, &one.pixels);
    steps->step++;
    return WEFT_OK;
}

static enum weft_result survey(struct runner *r, int channel)
{
    const weft_resample_source *source = r->params->source;
    if (weft_resample_knows_survey(source, &r->survey))
        return WEFT_OK;
    return weft_separable_survey_samples(
        r->compiled->plan->separable,
        weft_separable_run_params(.samples = weft_resample_values(source, channel),
                                  .window = weft_resample_values_window(source),
                                  .log = r->params->log),
        &r->survey);
}

static enum weft_result run_swapped(struct runner *r, int channel,
                                    struct weft_resample_steps *steps)
{
    const struct weft_rectangle *part = &r->params->part;
    enum weft_result res = WEFT_OK;
    for (int x = 0; res == WEFT_OK && x < part->width; x += r->band) {
        const int width = part->width - x < r->band ? part->width - x : r->band;
        const struct weft_rectangle band = {part->x + x, part->y, width, part->height};
        const struct weft_rectangle turned = {band.y, band.x, band.height, band.width};
        struct turning t = {r, &band, r->params->plane[channel]};
        res = filter(r, channel, &turned, r->turned, part->height, steps);
        if (res == WEFT_OK)
            weft_threads_run(r->compiled->threads, (size_t)(part->height - 1) / ROWS + 1, turn_rows,
                             &t);
    }
    return res;
}

// ---- clamping -----------------------------------------------------------------------------------

struct clamping {
    const struct runner *r;
    int channel;
};

static bool clamp_row(void *priv, int thread, size_t number)
{
    const struct clamping *c = priv;
    const struct weft_warp_run_params *p = c->r->params;
    const struct weft_warp_plan *plan = c->r->compiled->plan;
    float *out = p->plane[c->channel] + (int64_t)number * p->stride;
    (void)thread;
    for (int x = 0; x < p->part.width; x += WEFT_WARP_ROW) {
        const int left = p->part.width - x, count = left < WEFT_WARP_ROW ? left : WEFT_WARP_ROW;
        struct weft_warp_row row;
        weft_warp_row_set(plan, p->part.x + x, p->part.y + (int)number, count, &row);
        weft_warp_clamp(plan, p->source, c->channel, &row, count, out + x);
    }
    return true;
}

static void clamp(struct runner *r, int channel)
{
    const struct weft_warp_run_params *p = r->params;
    struct clamping c = {r, channel};
    weft_threads_run(r->compiled->threads, (size_t)p->part.height, clamp_row, &c);
    for (int y = 0; y < p->part.height; y++)
        weft_statistics_add(&r->report->pixels, p->plane[channel] + y * p->stride,
                            (size_t)p->part.width);
}

enum weft_result weft_warp_aligned_run(const struct weft_warp_compiled *compiled,
                                       const struct weft_warp_run_params *params,
                                       struct weft_resample_report *report)
{
    const bool swapped = is_swapped(compiled->plan);
    const int channels = params->source->info.channels;
    struct runner r = {
        .compiled = compiled, .params = params, .band = params->part.width, .report = report};
    enum weft_result res = swapped ? create_band(&r) : WEFT_OK;
    const int bands = (params->part.width - 1) / r.band + 1;
    struct weft_resample_steps steps = {.outer = params->progress,
                                        .steps = (double)channels * bands};
    for (int c = 0; res == WEFT_OK && c < channels; c++) {
        res = survey(&r, c);
        if (res == WEFT_OK)
            res = swapped ? run_swapped(&r, c, &steps)
                          : filter(&r, c, &params->part, params->plane[c], params->stride, &steps);
    }
    if (res == WEFT_OK && compiled->plan->info.clamp) {
        report->pixels = (struct weft_statistics)WEFT_STATISTICS_NONE;
        for (int c = 0; c < channels; c++)
            clamp(&r, c);
    }
    free(r.turned);
    return res;
}
