// SPDX-License-Identifier: BSD-3-Clause
#include "passes/positions/footprint_impl.h"

#include <stdlib.h>
#include <string.h>

#include "filter/kernels/prefilter.h"
#include "tiles/volume/volume_cache.h"

static const uint64_t DEFAULT_MEMORY = UINT64_C(1) << 30;
enum { BRICK_BYTES = WEFT_BRICK_VOXELS * sizeof(float) };

// ---- making and holding -------------------------------------------------------------------------

weft_volume *weft_footprint_voxels(const weft_footprint *footprint)
{
    return footprint->coefficients ? footprint->coefficients : footprint->volume;
}

static enum weft_result check_kernel(const struct weft_log *log, const struct weft_kernel *kernel)
{
    const enum weft_result res = weft_kernel_check(log, kernel);
    if (res != WEFT_OK || !kernel->radial)
        return res;
    weft_error(log, "kernel %s is radial: a slice multiplies the weights of three axes",
               kernel->info->name);
    return WEFT_ERR_UNSUPPORTED;
}

static enum weft_result create_coefficients(weft_footprint *f)
{
    struct weft_prefilter prefilter;
    enum weft_result res = weft_prefilter_compute(f->log, &f->info.kernel, &prefilter);
    if (res != WEFT_OK)
        return res;
    f->info.prefilter_overlap = weft_prefilter_overlap(&prefilter, WEFT_VOLUME_PREFILTER_ERROR);
    if (f->shared)
        return WEFT_OK;
    res = weft_volume_cache(f->volume, f->log, &f->samples);
    return res == WEFT_OK
               ? weft_volume_prefilter(f->log, f->samples, &f->info.kernel, &f->coefficients)
               : res;
}

enum weft_result weft_footprint_open(weft_footprint *f)
{
    struct weft_region region;
    if (f->bricks.volume)
        return WEFT_OK;
    // What stays resident does not need voxels twice.
    if (f->shared && weft_brick_reader_borrow(f->log, weft_footprint_voxels(f), &f->bricks))
        return WEFT_OK;
    weft_slice_grid_region(&f->grid, f->info.kernel.width, &region);
    return weft_brick_reader_open(f->log, weft_footprint_voxels(f), &region, &f->bricks);
}

static enum weft_result fill(weft_footprint *f, const struct weft_footprint_shared *shared)
{
    struct weft_footprint_info *info = &f->info;
    enum weft_result res = WEFT_OK;
    if (!info->kernel.info)
        res = weft_kernel_parse(f->log, "catmull-rom", &info->kernel);
    if (res == WEFT_OK)
        res = check_kernel(f->log, &info->kernel);
    if (res == WEFT_OK) {
        f->facts = weft_kernel_facts_find(shared ? shared->kernels : &f->own_facts, &info->kernel);
        res = f->facts ? WEFT_OK : WEFT_ERR_MEMORY;
    }
    if (res == WEFT_ERR_MEMORY)
        weft_error(f->log, "not enough memory for kernel %s", info->kernel.info->name);
    if (res == WEFT_OK && info->kernel.prefiltered)
        res = create_coefficients(f);
    if (res == WEFT_OK)
        res = weft_slice_grid_create(f->log, &info->geometry, info->space, info->kernel.width,
                                     weft_volume_get_info(f->volume), &f->grid);
    info->index_geometry = f->grid.index;
    return res;
}

enum weft_result weft_footprint_create_over(const struct weft_footprint_params *params,
                                            const struct weft_footprint_shared *shared,
                                            weft_footprint **out)
{
    *out = NULL;
    weft_footprint *f = NULL;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(params->log, params->volume != NULL);
    weft_require_enum(params->log, params->space, WEFT_SPACE_INDEX);
    f = calloc(1, sizeof *f);
    if (!f) {
        weft_error(params->log, "not enough memory for a slice's footprint");
        return WEFT_ERR_MEMORY;
    }
    *f = (struct weft_footprint){
        .info = {.kernel = params->kernel, .space = params->space, .geometry = params->geometry},
        .log = params->log,
        .holders = 1,
        .volume = params->volume,
        .memory_bytes = params->memory_bytes ? params->memory_bytes : DEFAULT_MEMORY,
    };
    if (shared) {
        f->shared = true;
        f->samples = shared->samples;
        f->coefficients = shared->coefficients;
        f->samples_read = f->samples ? weft_volume_cache_get_info(f->samples)->bricks_read : 0;
    }
    res = fill(f, shared);
    if (res != WEFT_OK)
        goto fail;
    *out = f;
    return WEFT_OK;
fail:
    weft_footprint_destroy(&f);
    return res;
}

enum weft_result weft_footprint_create(const struct weft_footprint_params *params,
                                       weft_footprint **out)
{
    enum weft_result res = weft_footprint_create_over(params, NULL, out);
    if (res == WEFT_OK)
        res = weft_footprint_open(*out);
    if (res != WEFT_OK)
        weft_footprint_destroy(out);
    return res;
}

weft_footprint *weft_footprint_hold(weft_footprint *footprint)
{
    footprint->holders++;
    return footprint;
}

static void forget_spans(struct weft_slice_cells *cells)
{
    free(cells->spans);
    free(cells->rows);
    cells->spans = NULL;
    cells->rows = NULL;
}

static void cells_destroy(struct weft_slice_cells *cells)
{
    weft_cell_map_destroy(&cells->map);
    free(cells->at);
    forget_spans(cells);
    free(cells);
}

void weft_footprint_destroy(weft_footprint **footprint)
{
    weft_footprint *f = footprint ? *footprint : NULL;
    if (!f)
        return;
    *footprint = NULL;
    if (--f->holders > 0)
        return;
    weft_brick_reader_close(&f->bricks);
    for (size_t i = 0; i < f->cells_count; i++)
        cells_destroy(f->cells[i]);
    free(f->cells);
    weft_kernel_facts_destroy(&f->own_facts);
    if (!f->shared) {
        weft_volume_destroy(&f->coefficients);
        weft_volume_destroy(&f->samples);
    }
    free(f);
}

const struct weft_footprint_info *weft_footprint_get_info(const weft_footprint *footprint)
{
    return &footprint->info;
}

// ---- cells --------------------------------------------------------------------------------------

struct collector {
    struct weft_slice_cells *cells;
    const struct weft_progress *progress;
    double fraction;
    int row;
    size_t near; // span of the row before, which this row's next one may share its cell with
    bool cancelled;
};

static bool go_on(struct collector *c, int row)
{
    const struct weft_progress *p = c->progress;
    c->cancelled = p && p->report && !p->report(p->priv, c->fraction);
    c->row = row;
    return !c->cancelled;
}

// The number of a cell, which has no pixel yet where it is new; WEFT_CELL_NONE: out of memory.
static int64_t add_cell(struct weft_slice_cells *cells, struct weft_cell_key key)
{
    const size_t known = cells->map.count;
    const int64_t number = weft_cell_map_add(&cells->map, key);
    if (number == WEFT_CELL_NONE || (size_t)number < known)
        return number;
    if ((size_t)number >= cells->capacity) {
        const size_t capacity = cells->capacity ? 2 * cells->capacity : 1024;
        void *at = realloc(cells->at, capacity * sizeof *cells->at);
        if (!at)
            return WEFT_CELL_NONE;
        cells->at = at;
        cells->capacity = capacity;
    }
    cells->at[number] = (struct weft_slice_cell){.low = {7, 7, 7}};
    return number;
}

// The same, looked for first where the row before was.
static int64_t find_cell(struct collector *c, const struct weft_cell_key *key)
{
    enum { LOOKS = 3 };
    struct weft_slice_cells *cells = c->cells;
    const size_t end = cells->spans ? cells->rows[c->row - cells->rectangle.y] : 0;
    for (size_t i = c->near; i < end && i < c->near + LOOKS; i++) {
        const int32_t *at = cells->map.keys[cells->spans[i].cell].at;
        if (at[0] == key->at[0] && at[1] == key->at[1] && at[2] == key->at[2]) {
            c->near = i + 1;
            return cells->spans[i].cell;
        }
    }
    return add_cell(cells, *key);
}

static void start_row(struct collector *c)
{
    const struct weft_slice_cells *cells = c->cells;
    const int row = c->row - cells->rectangle.y;
    if (!cells->spans)
        return;
    c->near = row ? cells->rows[row - 1] : 0;
    cells->rows[row] = cells->span_count;
}

// Spans that are not kept, for want of memory or being many, are walked again.
static void add_span(struct weft_slice_cells *cells, int64_t number, int count)
{
    if (!cells->spans)
        return;
    if (cells->span_count == cells->span_capacity) {
        const size_t capacity = 2 * cells->span_capacity;
        const size_t pixels = (size_t)cells->rectangle.width * (size_t)cells->rectangle.height;
        void *spans =
            capacity <= pixels ? realloc(cells->spans, capacity * sizeof *cells->spans) : NULL;
        if (!spans) {
            forget_spans(cells);
            return;
        }
        cells->spans = spans;
        cells->span_capacity = capacity;
    }
    cells->spans[cells->span_count++] = (struct weft_cell_span){(uint32_t)number, (uint32_t)count};
}

static bool collect_span(void *priv, const struct weft_span *span)
{
    struct collector *c = priv;
    if (span->y != c->row) {
        if (!go_on(c, span->y))
            return false;
        start_row(c);
    }
    const int64_t number = find_cell(c, &span->cell);
    if (number == WEFT_CELL_NONE)
        return false;
    add_span(c->cells, number, span->count);
    struct weft_slice_cell *cell = &c->cells->at[number];
    for (int a = 0; a < 3; a++) {
        cell->low[a] = span->low[a] < cell->low[a] ? span->low[a] : cell->low[a];
        cell->high[a] = span->high[a] > cell->high[a] ? span->high[a] : cell->high[a];
    }
    return true;
}

// Room for the first spans; none is no failure.
static void expect_spans(struct weft_slice_cells *cells)
{
    enum { PIXELS = 16 }; // of a span, at first
    const struct weft_rectangle *r = &cells->rectangle;
    cells->span_capacity = (size_t)r->height + (size_t)r->width * (size_t)r->height / PIXELS;
    cells->rows = malloc(((size_t)r->height + 1) * sizeof *cells->rows);
    cells->spans = cells->rows ? malloc(cells->span_capacity * sizeof *cells->spans) : NULL;
}

static struct weft_slice_cells *find_cells(const weft_footprint *f,
                                           const struct weft_rectangle *rectangle)
{
    for (size_t i = 0; i < f->cells_count; i++)
        if (memcmp(&f->cells[i]->rectangle, rectangle, sizeof *rectangle) == 0)
            return f->cells[i];
    return NULL;
}

bool weft_footprint_has_cells(const weft_footprint *f, const struct weft_rectangle *rectangle)
{
    return find_cells(f, rectangle) != NULL;
}

static bool keep_cells(weft_footprint *f, struct weft_slice_cells *cells)
{
    if (f->cells_count == f->cells_capacity) {
        const size_t capacity = f->cells_capacity ? 2 * f->cells_capacity : 16;
        void *list = realloc(f->cells, capacity * sizeof *f->cells);
        if (!list)
            return false;
        f->cells = list;
        f->cells_capacity = capacity;
    }
    f->cells[f->cells_count++] = cells;
    return true;
}

enum weft_result weft_footprint_cells(weft_footprint *f, const struct weft_rectangle *rectangle,
                                      const struct weft_progress *progress, double fraction,
                                      const struct weft_slice_cells **out)
{
    struct weft_slice_cells *cells = find_cells(f, rectangle);
    *out = cells;
    if (cells) {
        cells->holders++;
        return WEFT_OK;
    }
    struct collector c = {.progress = progress, .fraction = fraction, .row = -1};
    cells = c.cells = calloc(1, sizeof *cells);
    if (cells)
        *cells = (struct weft_slice_cells){.rectangle = *rectangle, .holders = 1};
    if (cells)
        expect_spans(cells);
    if (cells &&
        weft_slice_grid_walk(&f->grid, rectangle->x, rectangle->y, rectangle->width,
                             rectangle->height, collect_span, &c) &&
        keep_cells(f, cells)) {
        if (cells->spans)
            cells->rows[rectangle->height] = cells->span_count;
        *out = cells;
        return WEFT_OK;
    }
    if (cells)
        cells_destroy(cells);
    if (c.cancelled)
        return WEFT_ERR_CANCELLED;
    weft_error(f->log, "not enough memory for the cells of %d x %d pixels", rectangle->width,
               rectangle->height);
    return WEFT_ERR_MEMORY;
}

// Those of the whole are kept: every plan begins with them.
static bool is_whole(const weft_footprint *f, const struct weft_rectangle *rectangle)
{
    return rectangle->width == f->grid.index.width && rectangle->height == f->grid.index.height;
}

void weft_footprint_release(weft_footprint *f, const struct weft_slice_cells **cells)
{
    struct weft_slice_cells *own = *cells ? find_cells(f, &(*cells)->rectangle) : NULL;
    *cells = NULL;
    if (!own || --own->holders > 0 || is_whole(f, &own->rectangle))
        return;
    for (size_t i = 0; i < f->cells_count; i++)
        if (f->cells[i] == own)
            f->cells[i] = f->cells[--f->cells_count];
    cells_destroy(own);
}

// Walks what was not kept.
struct visit {
    const struct weft_slice_cells *cells;
    weft_cell_visitor visit;
    void *priv;
};

static bool visit_span(void *priv, const struct weft_span *span)
{
    const struct visit *v = priv;
    const struct weft_cell_span own = {(uint32_t)weft_cell_map_find(&v->cells->map, span->cell),
                                       (uint32_t)span->count};
    return v->visit(v->priv, span->x - v->cells->rectangle.x, span->y - v->cells->rectangle.y,
                    &own);
}

bool weft_footprint_visit(const weft_footprint *f, const struct weft_slice_cells *cells, int row,
                          int end, weft_cell_visitor visit, void *priv)
{
    const struct weft_rectangle *r = &cells->rectangle;
    struct visit walk = {cells, visit, priv};
    if (!cells->spans)
        return weft_slice_grid_walk(&f->grid, r->x, r->y + row, r->width, end - row, visit_span,
                                    &walk);
    for (int y = row; y < end; y++) {
        int x = 0;
        for (size_t i = cells->rows[y]; i < cells->rows[y + 1]; i++) {
            if (!visit(priv, x, y, &cells->spans[i]))
                return false;
            x += (int)cells->spans[i].count;
        }
    }
    return true;
}

// ---- boxes --------------------------------------------------------------------------------------

void weft_footprint_cell_box(const weft_footprint *f, const struct weft_slice_cells *cells,
                             size_t i, int32_t min[3], int32_t max[3])
{
    const struct weft_slice_cell *cell = &cells->at[i];
    for (int a = 0; a < 3; a++) {
        const int32_t start = cells->map.keys[i].at[a] * WEFT_BRICK_SIZE - f->grid.tap_offset;
        min[a] = start + cell->low[a];
        max[a] = start + cell->high[a] + f->info.kernel.width - 1;
    }
}

// Widens a box by the taps of one pixel.
static void add_pixel(const weft_footprint *f, const struct weft_slice_block *block, int x, int y,
                      bool first, int32_t min[3], int32_t max[3])
{
    int32_t whole[3];
    double fraction[3];
    weft_slice_grid_pixel(&f->grid, block, x, y, whole, fraction);
    for (int a = 0; a < 3; a++) {
        const int32_t low = whole[a] - f->grid.tap_offset, high = low + f->info.kernel.width - 1;
        min[a] = first || low < min[a] ? low : min[a];
        max[a] = first || high > max[a] ? high : max[a];
    }
}

static int last_of_block(int from, int end)
{
    const int next = (from / WEFT_GRID_BLOCK + 1) * WEFT_GRID_BLOCK;
    return (next < end ? next : end) - 1;
}

void weft_footprint_box(const weft_footprint *f, const struct weft_rectangle *r, int32_t min[3],
                        int32_t max[3])
{
    const int end_x = r->x + r->width, end_y = r->y + r->height;
    bool first = true;
    for (int y = r->y, y1; y < end_y; y = y1 + 1) {
        y1 = last_of_block(y, end_y);
        for (int x = r->x, x1; x < end_x; x = x1 + 1) {
            struct weft_slice_block block;
            x1 = last_of_block(x, end_x);
            weft_slice_grid_block(&f->grid, x / WEFT_GRID_BLOCK, y / WEFT_GRID_BLOCK, &block);
            for (int corner = 0; corner < 4; corner++, first = false)
                add_pixel(f, &block, corner & 1 ? x1 : x, corner & 2 ? y1 : y, first, min, max);
        }
    }
}

// ---- voxels -------------------------------------------------------------------------------------

// What is kept and was read; of coefficients nothing is read but the samples that they depend on.
static void count_bricks(weft_footprint *f)
{
    f->info.bricks_read = f->bricks.bricks_read;
    f->info.kept_bytes = f->bricks.kept_bytes;
    f->info.read_seconds = f->bricks.read_seconds;
    if (!f->samples)
        return;
    const struct weft_volume_cache_info *samples = weft_volume_cache_get_info(f->samples);
    f->info.bricks_read = samples->bricks_read - f->samples_read;
    f->info.kept_bytes += f->shared ? 0 : samples->kept_bytes;
}

// Samples are kept in what others leave.
static void limit_samples(weft_footprint *f, uint64_t other_bytes)
{
    const uint64_t bytes = f->bricks.kept_bytes + other_bytes;
    if (f->samples && !f->shared)
        weft_volume_cache_limit(f->samples, bytes < f->memory_bytes ? f->memory_bytes - bytes : 0);
}

enum weft_result weft_footprint_read_samples(weft_footprint *f, size_t count,
                                             const int32_t (*origin)[3], float *values)
{
    limit_samples(f, 0);
    const enum weft_result res = weft_volume_read(f->samples, count, origin, values);
    count_bricks(f);
    return res;
}

enum weft_result weft_footprint_load(weft_footprint *f, const struct weft_cell_map *bricks,
                                     uint64_t other_bytes, const weft_brick_store **out)
{
    *out = NULL;
    enum weft_result res = weft_footprint_open(f);
    if (res != WEFT_OK)
        return res;
    size_t missing = weft_brick_reader_missing(&f->bricks, bricks);
    if (f->bricks.kept_bytes && missing &&
        f->bricks.kept_bytes + missing * BRICK_BYTES + other_bytes > f->memory_bytes) {
        weft_brick_reader_drop(&f->bricks);
        missing = bricks->count;
    }
    limit_samples(f, missing * BRICK_BYTES + other_bytes);
    res = weft_brick_reader_load(&f->bricks, bricks);
    count_bricks(f);
    if (res == WEFT_OK)
        *out = f->bricks.store;
    return res;
}
