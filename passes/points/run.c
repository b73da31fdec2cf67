// SPDX-License-Identifier: BSD-3-Clause
// A run: batches of points, and as many of their bricks at once as memory has room for.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/kernels/prefilter.h"
#include "passes/points/points_impl.h"
#include "tiles/volume/region.h"

enum { BRICK_BYTES = WEFT_BRICK_VOXELS * sizeof(float), LEAST_BATCH = 4096 };

struct run {
    weft_points *points;
    const struct weft_points_run_params *params;
    struct weft_point_batch batch;
    struct weft_points_report report;
    uint64_t batch_bytes;
    size_t done; // points
};

static bool go_on(const struct run *r)
{
    const struct weft_progress *progress = r->params->progress;
    return !progress || !progress->report ||
           progress->report(progress->priv, (double)r->done / (double)r->params->count);
}

// ---- bricks -------------------------------------------------------------------------------------

static enum weft_result open_bricks(weft_points *p)
{
    struct weft_region all = {.slab_count = 0};
    if (p->bricks.volume || weft_brick_reader_borrow(p->log, p->voxels, &p->bricks))
        return WEFT_OK;
    for (int a = 0; a < 3; a++) {
        all.min[a] = -WEFT_INDEX_LIMIT;
        all.max[a] = WEFT_INDEX_LIMIT;
    }
    return weft_brick_reader_open(p->log, p->voxels, &all, &p->bricks);
}

// What a run of points has been noted for last, from brick to brick.
struct noted {
    bool any;
    int32_t min[3], max[3];
};

// Notes the bricks in reach of a run but those that the one before it has, which often is its
// neighbour along x. false: out of memory.
static bool note_run(const weft_points *p, const struct weft_point_run *run, struct noted *before,
                     struct weft_cell_map *bricks)
{
    int32_t min[3], max[3];
    weft_point_run_box(p, run, min, max);
    const struct noted now = {
        true, {min[0] >> 3, min[1] >> 3, min[2] >> 3}, {max[0] >> 3, max[1] >> 3, max[2] >> 3}};
    if (before->any && memcmp(now.min + 1, before->min + 1, 2 * sizeof now.min[0]) == 0 &&
        memcmp(now.max + 1, before->max + 1, 2 * sizeof now.max[0]) == 0 &&
        now.min[0] >= before->min[0] && now.min[0] <= before->max[0])
        min[0] = (before->max[0] + 1) * WEFT_BRICK_SIZE;
    *before = now;
    return min[0] > max[0] || weft_brick_reader_note(&p->bricks, min, max, bricks);
}

// Notes the bricks of runs from `from` on, as many as there is room for, at least those of one run.
// Returns the first run that is left; 0: out of memory.
static size_t note_runs(const struct run *r, size_t from, struct weft_cell_map *bricks)
{
    const weft_points *p = r->points;
    const uint64_t room = p->memory_bytes > r->batch_bytes ? p->memory_bytes - r->batch_bytes : 0;
    struct noted before = {.any = false};
    size_t to = from;
    if (p->bricks.borrowed)
        return r->batch.run_count;
    while (to < r->batch.run_count && (to == from || bricks->count * BRICK_BYTES < room))
        if (!note_run(p, &r->batch.run[to++], &before, bricks))
            return 0;
    return to;
}

static enum weft_result load_bricks(struct run *r, const struct weft_cell_map *bricks)
{
    struct weft_brick_reader *reader = &r->points->bricks;
    const uint64_t before = reader->bricks_read;
    const double seconds = reader->read_seconds;
    if (reader->borrowed)
        return WEFT_OK;
    uint64_t bytes = r->batch_bytes + reader->kept_bytes;
    if (reader->kept_bytes &&
        bytes + weft_brick_reader_missing(reader, bricks) * BRICK_BYTES > r->points->memory_bytes)
        weft_brick_reader_drop(reader);
    const enum weft_result res = weft_brick_reader_load(reader, bricks);
    bytes = r->batch_bytes + reader->kept_bytes;
    r->report.bricks_read += reader->bricks_read - before;
    r->report.read_seconds += reader->read_seconds - seconds;
    r->report.peak_bytes = bytes > r->report.peak_bytes ? bytes : r->report.peak_bytes;
    return res;
}

// ---- samples behind coefficients ----------------------------------------------------------------

static void add_value(double value, struct weft_bound_values *out)
{
    if (!isfinite(value))
        return;
    out->sample_low = fmin(out->sample_low, value);
    out->sample_high = fmax(out->sample_high, value);
    // Shells of ever lesser weight, a sixteenth each (passes/positions/footprint_impl.h).
    out->beyond = fmax(out->beyond, fabs(value) * 16.0 / 15.0);
}

enum weft_result weft_points_measure_samples(const weft_points *p, const int32_t min[3],
                                             const int32_t max[3], struct weft_bound_values *out)
{
    enum { CHUNK = 256 };
    struct weft_region region = {.slab_count = 0};
    struct weft_brick_list list = {0};
    const struct weft_volume_info *volume = weft_volume_get_info(p->volume);
    float *values = malloc((size_t)CHUNK * BRICK_BYTES);
    enum weft_result res = WEFT_ERR_MEMORY;
    if (!values) {
        weft_error(p->log, "not enough memory to measure %d bricks", CHUNK);
        goto fail;
    }
    memcpy(region.min, min, sizeof region.min);
    memcpy(region.max, max, sizeof region.max);
    region = weft_region_widen(&region, WEFT_PREFILTER_MAX_OVERLAP);
    if (volume->clamp_to_edge)
        weft_region_clamp(volume, &region);
    else
        add_value((double)volume->background, out);
    res = weft_volume_find(p->volume, &region, &list);
    for (size_t i = 0; res == WEFT_OK && i < list.tile_count; i++)
        add_value((double)list.tiles[i].value, out);
    for (size_t from = 0; res == WEFT_OK && from < list.brick_count; from += CHUNK) {
        const size_t left = list.brick_count - from, count = left < CHUNK ? left : CHUNK;
        res = weft_volume_read(p->volume, count, (const int32_t(*)[3])list.brick_origin + from,
                               values);
        for (size_t i = 0; res == WEFT_OK && i < count * WEFT_BRICK_VOXELS; i++)
            add_value((double)values[i], out);
    }
    weft_brick_list_clear(&list);
fail:
    free(values);
    return res;
}

// Of all runs of a batch.
static enum weft_result measure_batch(struct run *r)
{
    int32_t low[3] = {INT32_MAX, INT32_MAX, INT32_MAX}, high[3] = {INT32_MIN, INT32_MIN, INT32_MIN};
    for (size_t i = 0; i < r->batch.run_count; i++) {
        int32_t min[3], max[3];
        weft_point_run_box(r->points, &r->batch.run[i], min, max);
        for (int a = 0; a < 3; a++) {
            low[a] = min[a] < low[a] ? min[a] : low[a];
            high[a] = max[a] > high[a] ? max[a] : high[a];
        }
    }
    return weft_points_measure_samples(r->points, low, high, &r->report.values);
}

// ---- batches ------------------------------------------------------------------------------------

static enum weft_result run_batch(struct run *r)
{
    weft_points *p = r->points;
    const double start = weft_now_seconds();
    weft_point_batch_sort(p, r->params, &r->batch, &r->report);
    r->report.sort_seconds += weft_now_seconds() - start;
    enum weft_result res = WEFT_OK;
    if (r->params->measure && p->coefficients && r->batch.run_count)
        res = measure_batch(r);
    for (size_t from = 0, to; res == WEFT_OK && from < r->batch.run_count; from = to) {
        struct weft_cell_map bricks = {0};
        to = note_runs(r, from, &bricks);
        if (to)
            res = load_bricks(r, &bricks);
        else
            weft_error(p->log, "not enough memory for the places of %zu bricks", bricks.count);
        const double begun = weft_now_seconds();
        const struct weft_point_job job = {p, r->params, &r->batch, from, to, &r->report};
        if (!to)
            res = WEFT_ERR_MEMORY;
        if (res == WEFT_OK)
            res = weft_point_job_run(&job);
        r->report.pass_seconds += weft_now_seconds() - begun;
        weft_cell_map_destroy(&bricks);
        if (res == WEFT_OK && !go_on(r))
            res = WEFT_ERR_CANCELLED;
    }
    return res;
}

// Points of a batch: as many as there are, or a quarter of memory has room for.
static size_t batch_size(const weft_points *p, size_t count)
{
    const uint64_t room = p->memory_bytes / 4 / weft_point_batch_bytes;
    size_t size = count < WEFT_POINTS_BATCH ? count : WEFT_POINTS_BATCH;
    if (size > room)
        size = room < LEAST_BATCH ? LEAST_BATCH : (size_t)room;
    return size;
}

static enum weft_result check_run(const weft_points *p, const struct weft_points_run_params *params)
{
    if (params->count && (!params->position || !params->out)) {
        weft_error(p->log, "%zu points without %s", params->count,
                   params->position ? "a place for results" : "positions");
        return WEFT_ERR_ARGUMENT;
    }
    if (params->stride && params->stride < params->count) {
        weft_error(p->log, "a stride of %zu for %zu points", params->stride, params->count);
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

static void set_values(const weft_points *p, struct weft_bound_values *v)
{
    if (v->low > v->high)
        v->low = v->high = 0.0;
    if (!p->coefficients) {
        v->sample_low = v->low;
        v->sample_high = v->high;
    } else if (v->sample_low > v->sample_high) {
        v->sample_low = v->sample_high = 0.0;
    }
}

enum weft_result weft_points_run(weft_points *points, const struct weft_points_run_params *params,
                                 struct weft_points_report *report)
{
    struct weft_points_run_params own = *params;
    struct run r = {.points = points, .params = &own};
    if (report)
        *report = (struct weft_points_report){0};
    enum weft_result res = check_run(points, params);
    if (res != WEFT_OK || !params->count)
        return res;
    own.stride = params->stride ? params->stride : params->count;
    r.report.values = (struct weft_bound_values){
        .low = INFINITY, .high = -INFINITY, .sample_low = INFINITY, .sample_high = -INFINITY};
    const size_t size = batch_size(points, params->count);
    r.batch_bytes = r.report.peak_bytes = size * weft_point_batch_bytes;
    res = weft_point_batch_create(points->log, size, &r.batch);
    if (res == WEFT_OK)
        res = open_bricks(points);
    while (res == WEFT_OK && r.done < params->count) {
        const size_t left = params->count - r.done;
        r.batch.first = r.done;
        r.batch.count = left < size ? left : size;
        res = run_batch(&r);
        r.done += r.batch.count;
    }
    if (res == WEFT_ERR_CANCELLED)
        weft_note(points->log, "sampling was cancelled at point %zu of %zu", r.batch.first,
                  params->count);
    set_values(points, &r.report.values);
    weft_point_batch_destroy(&r.batch);
    if (report)
        *report = r.report;
    return res;
}
