// SPDX-License-Identifier: BSD-3-Clause
// Pixels held between the samples next to them, whatever engine made them.
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "filter/threads.h"
#include "passes/resample/resample_impl.h"

enum { BAND_ROWS = 16 };

// The samples next to a pixel along an axis, before the boundary's rule.
struct next {
    int64_t first, last;
};

static struct next next_of(const weft_resample_plan *plan, int axis, int pixel)
{
    const double at = weft_window_map_position(&plan->info.map[axis], pixel, 0);
    const double away = plan->info.stretch[axis];
    return (struct next){(int64_t)ceil(at - away), (int64_t)floor(at + away)};
}

static int64_t sample_of(const weft_resample_plan *plan, int axis, int64_t index)
{
    return weft_boundary_index(plan->info.boundary, index, plan->info.size[axis]);
}

void weft_resample_next_reach(const weft_resample_plan *plan, int axis, int first, int count,
                              int reach[2])
{
    const int64_t from = next_of(plan, axis, first).first;
    const int64_t to = next_of(plan, axis, first + count - 1).last;
    reach[0] = plan->info.size[axis] - 1;
    reach[1] = 0;
    for (int64_t i = from; i <= to; i++) {
        const int64_t sample = sample_of(plan, axis, i);
        if (sample < 0)
            continue;
        reach[0] = sample < reach[0] ? (int)sample : reach[0];
        reach[1] = sample > reach[1] ? (int)sample : reach[1];
    }
    reach[0] = reach[0] > reach[1] ? reach[1] : reach[0];
}

// ---- rows ---------------------------------------------------------------------------------------

struct ends {
    float low, high; // low > high: there is no finite sample
};

static void add(struct ends *ends, float low, float high)
{
    ends->low = low < ends->low ? low : ends->low;
    ends->high = high > ends->high ? high : ends->high;
}

static void add_sample(struct ends *ends, float sample)
{
    if (fabsf(sample) <= FLT_MAX)
        add(ends, sample, sample);
}

struct clamping {
    const weft_resample_plan *plan;
    const struct weft_resample_run_params *params;
    struct next *columns; // of every column of the part
    struct ends *rows;    // of each thread: a row of the window
    size_t bands;         // of a channel
};

// Of the samples of every column of the window that are next to a row of pixels.
static void find_column_ends(const struct clamping *c, int channel, int y, struct ends *out)
{
    const weft_resample_source *source = c->params->source;
    const struct weft_rectangle *w = &source->info.window;
    const struct next rows = next_of(c->plan, 1, y);
    for (int x = 0; x < w->width; x++)
        out[x] = (struct ends){INFINITY, -INFINITY};
    for (int64_t i = rows.first; i <= rows.last; i++) {
        const int64_t row = sample_of(c->plan, 1, i);
        const float *samples = source->plane[channel] + (row - w->y) * source->stride;
        for (int x = 0; x < w->width; x++)
            add_sample(&out[x], row < 0 ? (float)source->info.border : samples[x]);
    }
}

static struct ends ends_of(const struct clamping *c, const struct next *columns,
                           const struct ends *of)
{
    const struct weft_resample_source_info *info = &c->params->source->info;
    struct ends ends = {INFINITY, -INFINITY};
    for (int64_t i = columns->first; i <= columns->last; i++) {
        const int64_t column = sample_of(c->plan, 0, i);
        if (column < 0)
            add_sample(&ends, (float)info->border);
        else
            add(&ends, of[column - info->window.x].low, of[column - info->window.x].high);
    }
    return ends;
}

static void clamp_row(const struct clamping *c, int channel, int y, struct ends *of)
{
    const struct weft_rectangle *part = &c->params->part;
    float *pixels = c->params->plane[channel] + (y - part->y) * c->params->stride;
    find_column_ends(c, channel, y, of);
    for (int x = 0; x < part->width; x++) {
        const struct ends ends = ends_of(c, &c->columns[x], of);
        if (ends.low > ends.high || !(fabsf(pixels[x]) <= FLT_MAX))
            continue;
        pixels[x] = pixels[x] < ends.low ? ends.low : pixels[x] > ends.high ? ends.high : pixels[x];
    }
}

static bool clamp_band(void *priv, int thread, size_t i)
{
    const struct clamping *c = priv;
    const struct weft_rectangle *part = &c->params->part;
    const int from = part->y + (int)(i % c->bands) * BAND_ROWS, end = part->y + part->height;
    const size_t width = (size_t)c->params->source->info.window.width;
    for (int y = from; y < end && y < from + BAND_ROWS; y++)
        clamp_row(c, (int)(i / c->bands), y, c->rows + (size_t)thread * width);
    return true;
}

enum weft_result weft_resample_clamp(const weft_resample_plan *plan,
                                     const struct weft_resample_run_params *params, int threads)
{
    const struct weft_resample_source_info *info = &params->source->info;
    const struct weft_rectangle *part = &params->part;
    const int count = threads ? threads : weft_threads_available();
    struct clamping c = {
        .plan = plan, .params = params, .bands = (size_t)(part->height - 1) / BAND_ROWS + 1};
    c.columns = malloc((size_t)part->width * sizeof *c.columns);
    c.rows = malloc((size_t)count * (size_t)info->window.width * sizeof *c.rows);
    const bool room = c.columns && c.rows;
    for (int x = 0; room && x < part->width; x++)
        c.columns[x] = next_of(plan, 0, part->x + x);
    if (room)
        weft_threads_run(count, c.bands * (size_t)info->channels, clamp_band, &c);
    else
        weft_error(params->log, "out of memory to clamp %d x %d pixels", part->width, part->height);
    free(c.columns);
    free(c.rows);
    return room ? WEFT_OK : WEFT_ERR_MEMORY;
}
