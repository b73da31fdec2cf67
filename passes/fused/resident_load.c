// SPDX-License-Identifier: BSD-3-Clause
// Which blocks of a resident volume a slice needs, and laying out those that are not there.
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/threads.h"
#include "passes/fused/resident_impl.h"
#include "passes/gl/context_backend.h"
#include "tiles/volume/region.h"

enum {
    LOT = 2048,                // blocks that are laid out between two looks at progress
    PART = 256,                // and by a thread at a time
    READ_ALL_BRICKS = 1 << 17, // of a volume, that are looked up once and for all
    FIRST_PLACES = 1024,       // in a buffer
    KEPT_VOXELS = 32 << 20,    // bytes of bricks, from one lot to the next
};

// A block to lay out: of a cell of the request, in this place (WEFT_CELL_NONE: it has none yet).
struct weft_resident_job {
    size_t cell;
    int64_t place;
};

// ---- bricks -------------------------------------------------------------------------------------

// All that blocks of a slice's cells may hold. Blocks reach beyond what their pixels do, by the
// size of a cell and of the apron at most.
static enum weft_result open_reader(weft_resident *r, const struct weft_slice_grid *grid)
{
    const int taps = r->info.kernel.width;
    const bool all = weft_volume_get_info(r->volume)->bricks <= READ_ALL_BRICKS;
    struct weft_region region = {
        .min = {-WEFT_INDEX_LIMIT, -WEFT_INDEX_LIMIT, -WEFT_INDEX_LIMIT},
        .max = {WEFT_INDEX_LIMIT - 1, WEFT_INDEX_LIMIT - 1, WEFT_INDEX_LIMIT - 1}};
    if (r->reader.volume &&
        (r->reader.borrowed || all || memcmp(grid, &r->reader_grid, sizeof *grid) == 0))
        return WEFT_OK;
    weft_brick_reader_close(&r->reader);
    if (weft_brick_reader_borrow(r->log, r->voxels, &r->reader))
        return WEFT_OK;
    if (!all) {
        struct weft_region taps_region;
        weft_slice_grid_region(grid, taps, &taps_region);
        region = weft_region_widen(&taps_region, WEFT_BRICK_SIZE + taps);
        r->reader_grid = *grid;
    }
    return weft_brick_reader_open(r->log, r->voxels, &region, &r->reader);
}

static void block_box(const weft_resident *r, const struct weft_cell_key *key, int32_t min[3],
                      int32_t max[3])
{
    const int width = r->info.kernel.width, offset = width % 2 ? (width - 1) / 2 : width / 2 - 1;
    for (int a = 0; a < 3; a++) {
        min[a] = key->at[a] * WEFT_BRICK_SIZE - offset;
        max[a] = min[a] + WEFT_BRICK_SIZE + width - 2;
    }
}

struct weft_resident_request weft_resident_request_of(const struct weft_slice_plan *plan,
                                                      const struct weft_slice_cells *cells)
{
    return (struct weft_resident_request){
        .grid = &plan->footprint->grid,
        .cells = cells,
        .constants = plan->info.savings & WEFT_SAVING_CONSTANT,
        .curved = plan->smooth.error > 0.0,
        .log = plan->log,
    };
}

// ---- what there is ------------------------------------------------------------------------------

// Without memory a cell's value is not remembered, and found again.
static void remember_constant(weft_resident *r, const struct weft_cell_key *key, float value)
{
    struct weft_cell_cache *c = &r->constants;
    const size_t before = c->capacity;
    bool evicted;
    const int64_t place = weft_cell_cache_add(c, *key, &evicted);
    if (place == WEFT_CELL_NONE)
        return;
    if (c->capacity != before) {
        void *values = realloc(r->values, c->capacity * sizeof *r->values);
        if (!values) {
            weft_cell_cache_clear(c);
            return;
        }
        r->values = values;
    }
    r->values[place] = value;
}

static bool add_job(weft_resident *r, size_t count, size_t cell, int64_t place)
{
    if (count == r->job_capacity) {
        const size_t capacity = r->job_capacity ? 2 * r->job_capacity : 256;
        void *jobs = realloc(r->jobs, capacity * sizeof *r->jobs);
        if (!jobs)
            return false;
        r->jobs = jobs;
        r->job_capacity = capacity;
    }
    r->jobs[count] = (struct weft_resident_job){cell, place};
    return true;
}

// A request's cells, sorted: those of one value, those that have blocks, and r->jobs.
struct sorting {
    const struct weft_resident_request *request;
    const struct weft_slice_plan *plan; // with `out`: blocks are used, and told of; else NULL
    struct weft_slice_blocks *out;
    size_t present, jobs;
    bool background;
};

static void found_constant(const weft_resident *r, struct sorting *s, size_t cell, float value)
{
    const float background = weft_volume_get_info(r->voxels)->background;
    s->background = s->background && memcmp(&value, &background, sizeof value) == 0;
    if (s->out)
        weft_slice_blocks_set_constant(s->out, cell, value);
}

// What a block is to a plan.
static void found_block(const weft_resident *r, struct sorting *s, size_t cell, int64_t place)
{
    const struct weft_resident_block *block = &r->blocks[place];
    const struct weft_sample_range *range = &block->range;
    enum weft_cell_class class = WEFT_CELL_FULL;
    float value = range->low;
    s->background = false;
    if (!s->out)
        return;
    const bool fit = weft_sample_range_fit(s->plan, range);
    if (s->request->constants && range->finite && range->low == range->high)
        class = WEFT_CELL_CONSTANT;
    else if (fit && s->request->curved)
        class = weft_sample_range_constant(s->plan, range, &value)        ? WEFT_CELL_CONSTANT
                : weft_sample_range_smooth(s->plan, range, block->second) ? WEFT_CELL_SMOOTH
                                                                          : WEFT_CELL_FULL;
    s->out->cells_constant += class == WEFT_CELL_CONSTANT;
    s->out->cells_smooth += class == WEFT_CELL_SMOOTH;
    if (class == WEFT_CELL_CONSTANT) {
        weft_slice_blocks_set_constant(s->out, cell, value);
        return;
    }
    s->out->any_unfit |= !fit;
    weft_slice_blocks_set(s->out, cell, (size_t)place * r->layout.block_texels, class);
}

static bool sort_known(weft_resident *r, struct sorting *s)
{
    const struct weft_resident_request *q = s->request;
    const struct weft_cell_map *map = &q->cells->map;
    for (size_t i = 0; i < map->count; i++) {
        const int32_t *at = map->keys[i].at;
        int64_t place = q->constants ? weft_cell_cache_find(&r->constants, at) : WEFT_CELL_NONE;
        if (place != WEFT_CELL_NONE) {
            weft_cell_cache_use(&r->constants, place);
            found_constant(r, s, i, r->values[place]);
            continue;
        }
        place = weft_cell_cache_find(&r->cells, at);
        if (place != WEFT_CELL_NONE && s->out)
            weft_cell_cache_use(&r->cells, place);
        if (place != WEFT_CELL_NONE && (r->blocks[place].curved || !q->curved)) {
            found_block(r, s, i, place);
            s->present++;
        } else if (!add_job(r, s->jobs++, i, place)) {
            return false;
        }
    }
    return true;
}

// Of the cells that nothing is known of, those on one tile, or the background, are found.
static void sort_unknown(weft_resident *r, struct sorting *s)
{
    const weft_brick_store *places = r->reader.places;
    size_t left = 0;
    for (size_t i = 0; i < s->jobs; i++) {
        const struct weft_resident_job job = r->jobs[i];
        const struct weft_cell_key *key = &s->request->cells->map.keys[job.cell];
        int32_t min[3], max[3];
        float value;
        block_box(r, key, min, max);
        if (s->request->constants && job.place == WEFT_CELL_NONE &&
            weft_brick_store_box_constant(places, min, max, &value)) {
            remember_constant(r, key, value);
            found_constant(r, s, job.cell, value);
        } else {
            s->background = false;
            r->jobs[left++] = job;
        }
    }
    s->jobs = left;
}

static enum weft_result sort_cells(weft_resident *r, struct sorting *s)
{
    s->background = true;
    const bool enough = sort_known(r, s);
    enum weft_result res = enough ? WEFT_OK : WEFT_ERR_MEMORY;
    if (!enough)
        weft_error(s->request->log, "not enough memory for %zu blocks", s->jobs);
    if (res == WEFT_OK && s->jobs)
        res = open_reader(r, s->request->grid);
    if (res == WEFT_OK && s->jobs)
        sort_unknown(r, s);
    return res;
}

// The bricks under some jobs.
static enum weft_result note_bricks(const weft_resident *r, const struct weft_slice_cells *cells,
                                    const struct weft_resident_job *jobs, size_t count,
                                    struct weft_cell_map *bricks)
{
    bool enough = true;
    for (size_t i = 0; enough && i < count; i++) {
        int32_t min[3], max[3];
        block_box(r, &cells->map.keys[jobs[i].cell], min, max);
        enough = weft_brick_reader_note(&r->reader, min, max, bricks);
    }
    if (enough)
        return WEFT_OK;
    weft_error(r->log, "not enough memory for the bricks of %zu blocks", count);
    return WEFT_ERR_MEMORY;
}

enum weft_result weft_resident_survey(weft_resident *r, const struct weft_resident_request *request,
                                      struct weft_resident_survey *out)
{
    struct sorting s = {.request = request};
    struct weft_cell_map bricks = {0};
    enum weft_result res = sort_cells(r, &s);
    if (res == WEFT_OK && s.jobs && !r->reader.borrowed)
        res = note_bricks(r, request->cells, r->jobs, s.jobs, &bricks);
    *out = (struct weft_resident_survey){.blocks = s.present + s.jobs,
                                         .missing = s.jobs,
                                         .bricks = bricks.count,
                                         .background = s.background};
    weft_cell_map_destroy(&bricks);
    return res;
}

// ---- laying out ---------------------------------------------------------------------------------

// Blocks in neighbouring places.
struct run {
    weft_resident *resident;
    const weft_brick_store *store;
    const struct weft_cell_map *map;
    const struct weft_resident_job *jobs;
    size_t count;
    bool curved;
    char *texels; // of the first
};

// Numbers that are not finite lie in the blocks as 0: what reaches them is made elsewhere.
static void replace_missing(float *voxels, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!isfinite(voxels[i]))
            voxels[i] = 0.0f;
}

static void lay_out(const struct run *run, size_t i, float *box)
{
    weft_resident *r = run->resident;
    const struct weft_block_layout *layout = &r->layout;
    const int *span = layout->span;
    struct weft_resident_block *block = &r->blocks[run->jobs[i].place];
    int32_t min[3], max[3], origin[3];
    const int32_t *key = run->map->keys[run->jobs[i].cell].at;
    block_box(r, &run->map->keys[run->jobs[i].cell], min, max);
    for (int a = 0; a < 3; a++)
        origin[a] = key[a] * WEFT_BRICK_SIZE;
    weft_brick_store_copy_block(run->store, origin, origin[0] - min[0],
                                max[0] - origin[0] - WEFT_BRICK_SIZE + 1, box);
    const struct weft_sample_box samples = weft_sample_box_of(box, span, span);
    block->range = weft_sample_box_range(&samples);
    block->curved = run->curved;
    for (int a = 0; a < 3 && run->curved; a++)
        block->second[a] = weft_sample_box_second_difference(&samples, a);
    if (!block->range.finite)
        replace_missing(box, (size_t)span[0] * (size_t)span[1] * (size_t)span[2]);
    weft_block_layout_write(layout, &r->range, box, run->texels + i * r->info.block_bytes);
}

static bool lay_out_part(void *priv, int thread, size_t part)
{
    const struct run *run = priv;
    const int *span = run->resident->layout.span;
    float *box =
        run->resident->boxes + (size_t)thread * (size_t)span[0] * (size_t)span[1] * (size_t)span[2];
    for (size_t i = part * PART; i < run->count && i < (part + 1) * PART; i++)
        lay_out(run, i, box);
    return true;
}

static enum weft_result write_run(const struct run *whole)
{
    struct run run = *whole;
    weft_resident *r = run.resident;
    const GladGLContext *gl = r->context ? &r->context->gl : NULL;
    const size_t from = (size_t)run.jobs[0].place * r->info.block_bytes;
    const size_t bytes = run.count * r->info.block_bytes;
    const double start = weft_now_seconds();
    run.texels = gl ? weft_gl_buffer_map_range(gl, &r->buffer, from, bytes) : r->texels + from;
    const double mapped = weft_now_seconds();
    if (run.texels)
        weft_threads_run(r->threads, (run.count + PART - 1) / PART, lay_out_part, &run);
    const double done = weft_now_seconds();
    const bool kept = run.texels && (!gl || weft_gl_buffer_unmap(gl, &r->buffer));
    r->info.layout_seconds += done - mapped;
    r->info.upload_seconds += (mapped - start) + (weft_now_seconds() - done);
    const enum weft_result res =
        gl ? weft_gl_check(r->log, gl, "uploading blocks of voxels") : WEFT_OK;
    if (res != WEFT_OK || kept)
        return res;
    weft_error(r->log, "%zu bytes of blocks could not be handed to GL", bytes);
    return WEFT_ERR_GL;
}

// Runs of jobs whose places follow each other.
static enum weft_result write_blocks(struct run *lot)
{
    const size_t count = lot->count;
    const struct weft_resident_job *jobs = lot->jobs;
    enum weft_result res = WEFT_OK;
    for (size_t from = 0, to; res == WEFT_OK && from < count; from = to) {
        struct run run = *lot;
        for (to = from + 1; to < count && jobs[to].place == jobs[to - 1].place + 1; to++)
            ;
        run.jobs = jobs + from;
        run.count = to - from;
        res = write_run(&run);
    }
    return res;
}

// Room in GL for all places that are taken: twice as much whenever there is too little.
static enum weft_result fit_buffer(weft_resident *r)
{
    const size_t held = r->buffer.size_bytes / (size_t)r->info.block_bytes;
    size_t places = held ? held : FIRST_PLACES;
    if (!r->context || r->cells.known <= held)
        return WEFT_OK;
    while (places < r->cells.known)
        places *= 2;
    places = places < r->info.capacity ? places : (size_t)r->info.capacity;
    const double start = weft_now_seconds();
    const enum weft_result res = weft_gl_buffer_grow(
        r->log, &r->context->gl, weft_fused_source_format(r->info.source, r->info.layout),
        places * r->layout.block_texels, &r->buffer);
    r->info.upload_seconds += weft_now_seconds() - start;
    return res;
}

// Finds places for blocks that have none. false: out of memory.
static bool find_places(weft_resident *r, const struct weft_cell_map *map,
                        struct weft_resident_job *jobs, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        bool evicted = false;
        if (jobs[i].place == WEFT_CELL_NONE)
            jobs[i].place = weft_cell_cache_add(&r->cells, map->keys[jobs[i].cell], &evicted);
        if (jobs[i].place == WEFT_CELL_NONE)
            return false;
        r->info.evicted += evicted;
    }
    return true;
}

static void forget(weft_resident *r, struct weft_resident_job *jobs, size_t count)
{
    for (size_t i = 0; i < count && jobs[i].place != WEFT_CELL_NONE; i++)
        weft_cell_cache_remove(&r->cells, jobs[i].place);
}

// Reads, and lays out, some of the jobs; all or none of them.
static enum weft_result load_lot(weft_resident *r, struct sorting *s,
                                 struct weft_resident_job *jobs, size_t count)
{
    const struct weft_slice_cells *cells = s->request->cells;
    struct weft_cell_map bricks = {0};
    enum weft_result res = WEFT_OK;
    const double start = weft_now_seconds();
    if (!r->reader.borrowed) {
        if (r->reader.kept_bytes > KEPT_VOXELS)
            weft_brick_reader_drop(&r->reader);
        res = note_bricks(r, cells, jobs, count, &bricks);
        if (res == WEFT_OK)
            res = weft_brick_reader_load(&r->reader, &bricks);
    }
    weft_cell_map_destroy(&bricks);
    r->info.read_seconds += weft_now_seconds() - start;
    if (res != WEFT_OK)
        return res;
    struct run lot = {.resident = r,
                      .store = r->reader.store,
                      .map = &cells->map,
                      .jobs = jobs,
                      .count = count,
                      .curved = s->request->curved};
    if (!find_places(r, &cells->map, jobs, count)) {
        weft_error(s->request->log, "not enough memory for %zu blocks", count);
        res = WEFT_ERR_MEMORY;
    }
    if (res == WEFT_OK)
        res = fit_buffer(r);
    if (res == WEFT_OK)
        res = write_blocks(&lot);
    if (res != WEFT_OK) {
        forget(r, jobs, count);
        return res;
    }
    for (size_t i = 0; i < count; i++)
        found_block(r, s, jobs[i].cell, jobs[i].place);
    r->info.laid_out += count;
    return WEFT_OK;
}

static enum weft_result load_jobs(weft_resident *r, struct sorting *s,
                                  const struct weft_progress *progress, double fraction)
{
    enum weft_result res = WEFT_OK;
    for (size_t at = 0; res == WEFT_OK && at < s->jobs; at += LOT) {
        const size_t count = s->jobs - at < LOT ? s->jobs - at : LOT;
        if (progress && progress->report && !progress->report(progress->priv, fraction))
            res = WEFT_ERR_CANCELLED;
        else
            res = load_lot(r, s, r->jobs + at, count);
    }
    weft_brick_reader_drop(&r->reader);
    return res;
}

enum weft_result weft_resident_load(weft_resident *r, const struct weft_slice_plan *plan, int tile,
                                    const struct weft_progress *progress,
                                    struct weft_slice_blocks *out)
{
    const struct weft_resident_request request =
        weft_resident_request_of(plan, plan->tile_plans[tile].cells);
    struct sorting s = {.request = &request, .plan = plan, .out = out};
    out->layout = r->layout;
    out->lead = weft_resident_lead(r, plan->info.kernel.width);
    out->texels = r->texels;
    out->constant_count = out->smooth_count = 0;
    out->any_unfit = false;
    enum weft_result res = sort_cells(r, &s);
    if (res == WEFT_OK && s.present + s.jobs > r->info.capacity) {
        weft_error(plan->log,
                   "a tile of %d x %d pixels needs %zu blocks; the resident volume holds %" PRIu64,
                   plan->tiles[tile].width, plan->tiles[tile].height, s.present + s.jobs,
                   r->info.capacity);
        res = WEFT_ERR_LIMIT;
    }
    if (res == WEFT_OK) {
        r->info.reused += s.present;
        res = load_jobs(r, &s, progress, (double)tile / plan->info.tile_count);
    }
    weft_resident_count(r);
    return res;
}
