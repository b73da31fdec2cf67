// SPDX-License-Identifier: BSD-3-Clause
// What the voxels in reach of a footprint are.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/kernels/prefilter.h"
#include "filter/threads.h"
#include "passes/cpu/cpu.h"
#include "passes/positions/footprint_impl.h"
#include "tiles/volume/region.h"

// Of a cell's reach along an axis; with 7 bits more for the first brick they fit in 64.
enum {
    MAX_SIDE = WEFT_BRICK_SIZE + WEFT_KERNEL_MAX_WIDTH - 1,
    MAX_BRICKS = (MAX_SIDE + 2 * (WEFT_BRICK_SIZE - 1)) / WEFT_BRICK_SIZE,
    PART_ROWS = 16, // of pixels that a thread marks at once
    PART_CELLS = 64,
};

static bool go_on(const struct weft_progress *progress, double fraction)
{
    return !progress || !progress->report || progress->report(progress->priv, fraction);
}

// ---- one brick ----------------------------------------------------------------------------------

// A bit for every voxel of a brick: bit x of row 8 z + y.
struct mask {
    uint8_t row[WEFT_BRICK_SIZE * WEFT_BRICK_SIZE];
};

static size_t count_marked(const struct mask *mask)
{
    size_t count = 0;
    for (size_t i = 0; i < sizeof mask->row; i += sizeof(uint64_t)) {
        uint64_t bits;
        memcpy(&bits, mask->row + i, sizeof bits);
        count += (size_t)__builtin_popcountll(bits);
    }
    return count;
}

// Those of a brick that are marked; what changes no range as a whole is not looked at closer.
static void measure_voxels(const float *values, const struct mask *mask,
                           struct weft_statistics *out)
{
    struct weft_statistics whole = WEFT_STATISTICS_NONE;
    weft_statistics_add(&whole, values, WEFT_BRICK_VOXELS);
    if (!whole.not_finite && whole.minimum >= out->minimum && whole.maximum <= out->maximum) {
        out->count += count_marked(mask);
        return;
    }
    float marked[WEFT_BRICK_VOXELS];
    size_t count = 0;
    for (int i = 0; i < WEFT_BRICK_VOXELS; i++) {
        marked[count] = values[i];
        count += mask->row[i / WEFT_BRICK_SIZE] >> i % WEFT_BRICK_SIZE & 1;
    }
    weft_statistics_add(out, marked, count);
}

static void measure_constant(float value, const struct mask *mask, struct weft_statistics *out)
{
    float filled[WEFT_BRICK_VOXELS];
    for (int i = 0; i < WEFT_BRICK_VOXELS; i++)
        filled[i] = value;
    measure_voxels(filled, mask, out);
}

static void measure_differences(const float *brick, struct weft_statistics *out)
{
    enum { ROW = WEFT_BRICK_SIZE, PLANE = ROW * ROW };
    for (int i = 0; i < PLANE; i++) {
        weft_statistics_add_differences(out, brick + i * ROW, ROW, 1);
        weft_statistics_add_differences(out, brick + i / ROW * PLANE + i % ROW, ROW, ROW);
        weft_statistics_add_differences(out, brick + i, ROW, PLANE);
    }
}

// ---- voxels in reach ----------------------------------------------------------------------------

// Cubes of 8 voxels, each with a mask.
struct reached {
    struct weft_cell_map bricks;
    struct mask *masks; // by number
    size_t capacity;
};

static void reached_destroy(struct reached *r)
{
    weft_cell_map_destroy(&r->bricks);
    free(r->masks);
    *r = (struct reached){.masks = NULL};
}

// A brick's number, whose mask is empty where it is new; WEFT_CELL_NONE: out of memory.
static int64_t find_number(struct reached *r, struct weft_cell_key key)
{
    const size_t known = r->bricks.count;
    const int64_t number = weft_cell_map_add(&r->bricks, key);
    if (number == WEFT_CELL_NONE)
        return WEFT_CELL_NONE;
    if ((size_t)number >= r->capacity) {
        const size_t capacity = r->capacity ? 2 * r->capacity : 256;
        void *masks = realloc(r->masks, capacity * sizeof *r->masks);
        if (!masks)
            return WEFT_CELL_NONE;
        r->masks = masks;
        r->capacity = capacity;
    }
    if ((size_t)number == known)
        r->masks[number] = (struct mask){.row = {0}};
    return number;
}

// The mask itself, until the next one is looked for.
static struct mask *find_mask(struct reached *r, struct weft_cell_key key)
{
    const int64_t number = find_number(r, key);
    return number == WEFT_CELL_NONE ? NULL : &r->masks[number];
}

// Adds what another one has marked.
static bool reached_join(struct reached *r, const struct reached *other)
{
    for (size_t i = 0; i < other->bricks.count; i++) {
        struct mask *mask = find_mask(r, other->bricks.keys[i]);
        if (!mask)
            return false;
        for (size_t row = 0; row < sizeof mask->row; row++)
            mask->row[row] |= other->masks[i].row[row];
    }
    return true;
}

// What a cell's pixels reach: rows of bits along x, from where the first tap of a pixel at the
// cell's corner lies.
struct rows {
    int32_t origin[3];
    int side; // along each axis
    uint64_t bits[MAX_SIDE][MAX_SIDE];
};

// Every position's taps: as many voxels along each axis as the kernel is wide.
static void spread(const struct mask *positions, int width, struct rows *out)
{
    uint64_t flat[WEFT_BRICK_SIZE][MAX_SIDE] = {{0}}; // spread along x and y
    out->side = WEFT_BRICK_SIZE + width - 1;
    memset(out->bits, 0, sizeof out->bits);
    for (int row = 0; row < WEFT_BRICK_SIZE * WEFT_BRICK_SIZE; row++) {
        uint64_t bits = 0;
        for (int tap = 0; positions->row[row] && tap < width; tap++)
            bits |= (uint64_t)positions->row[row] << tap;
        for (int tap = 0; bits && tap < width; tap++)
            flat[row / WEFT_BRICK_SIZE][row % WEFT_BRICK_SIZE + tap] |= bits;
    }
    for (int z = 0; z < WEFT_BRICK_SIZE; z++)
        for (int tap = 0; tap < width; tap++)
            for (int y = 0; y < out->side; y++)
                out->bits[z + tap][y] |= flat[z][y];
}

// The bricks that a cell's rows lie in, by number; WEFT_CELL_NONE: not looked for yet.
struct near_bricks {
    int32_t at[3]; // of the first one
    int64_t number[MAX_BRICKS][MAX_BRICKS][MAX_BRICKS];
};

// A row that needs no clamping: a byte for each brick along x.
static bool mark_row(uint64_t bits, int32_t y, int32_t z, struct near_bricks *near,
                     struct reached *reached)
{
    const int row = (z & 7) * WEFT_BRICK_SIZE + (y & 7);
    struct weft_cell_key key = {{near->at[0], y >> 3, z >> 3}};
    int64_t *number = near->number[key.at[2] - near->at[2]][key.at[1] - near->at[1]];
    for (; bits; bits >>= 8, key.at[0]++, number++) {
        if (!(bits & 0xff))
            continue;
        if (*number == WEFT_CELL_NONE)
            *number = find_number(reached, key);
        if (*number == WEFT_CELL_NONE)
            return false;
        reached->masks[*number].row[row] |= (uint8_t)bits;
    }
    return true;
}

static bool mark_rows(const struct rows *rows, struct reached *reached)
{
    const int shift = rows->origin[0] & (WEFT_BRICK_SIZE - 1);
    struct near_bricks near;
    for (int a = 0; a < 3; a++)
        near.at[a] = rows->origin[a] >> 3;
    for (int i = 0; i < MAX_BRICKS * MAX_BRICKS * MAX_BRICKS; i++)
        (&near.number[0][0][0])[i] = WEFT_CELL_NONE;
    for (int z = 0; z < rows->side; z++)
        for (int y = 0; y < rows->side; y++)
            if (rows->bits[z][y] && !mark_row(rows->bits[z][y] << shift, rows->origin[1] + y,
                                              rows->origin[2] + z, &near, reached))
                return false;
    return true;
}

static int32_t clamp(int32_t x, int32_t low, int32_t high)
{
    return x < low ? low : x > high ? high : x;
}

// Voxel by voxel, at the nearest one of the volume's box.
static bool mark_clamped(const struct weft_volume_info *info, const struct rows *rows,
                         struct reached *reached)
{
    for (int i = 0; i < rows->side * rows->side * rows->side; i++) {
        const int x = i % rows->side, y = i / rows->side % rows->side,
                  z = i / (rows->side * rows->side);
        int32_t at[3] = {rows->origin[0] + x, rows->origin[1] + y, rows->origin[2] + z};
        if (!(rows->bits[z][y] >> x & 1))
            continue;
        for (int a = 0; a < 3; a++)
            at[a] = clamp(at[a], info->active_min[a], info->active_max[a]);
        const struct weft_cell_key key = {{at[0] >> 3, at[1] >> 3, at[2] >> 3}};
        struct mask *mask = find_mask(reached, key);
        if (!mask)
            return false;
        mask->row[(at[2] & 7) * WEFT_BRICK_SIZE + (at[1] & 7)] |= (uint8_t)(1u << (at[0] & 7));
    }
    return true;
}

static bool mark_cell(const weft_footprint *f, struct weft_cell_key key,
                      const struct mask *positions, struct reached *reached)
{
    const struct weft_volume_info *info = weft_volume_get_info(weft_footprint_voxels(f));
    struct rows rows;
    bool inside = true;
    spread(positions, f->info.kernel.width, &rows);
    for (int a = 0; a < 3; a++) {
        rows.origin[a] = key.at[a] * WEFT_BRICK_SIZE - f->grid.tap_offset;
        inside = inside && rows.origin[a] >= info->active_min[a] &&
                 rows.origin[a] + rows.side - 1 <= info->active_max[a];
    }
    return inside || !info->clamp_to_edge ? mark_rows(&rows, reached)
                                          : mark_clamped(info, &rows, reached);
}

// ---- positions in cells -------------------------------------------------------------------------

// What one thread has found.
struct marker {
    struct reached cells; // of which the bits are floor(position + tap_shift)
    struct reached voxels;
    struct weft_slice_block block;
    int block_x, block_y;
    const struct marking *marking;
};

struct marking {
    const weft_footprint *footprint;
    struct weft_rectangle part; // that is marked
    const struct weft_progress *progress;
    struct marker *marker; // of each thread
    bool cancelled;        // told to the caller's thread
};

// Pixels of a row within their cell: what weft_slice_grid_pixel has as whole numbers, of which a
// cell leaves the last three bits.
static void mark_positions(const struct weft_slice_grid *grid, const struct weft_slice_block *block,
                           int dx, int dy, int count, struct mask *mask)
{
    int64_t at[3];
    for (int a = 0; a < 3; a++)
        at[a] = block->position[a] + dx * grid->du[a] + dy * grid->dv[a];
    for (int i = 0; i < count; i++) {
        const int x = (int)(at[0] >> grid->fraction_bits) & 7;
        const int y = (int)(at[1] >> grid->fraction_bits) & 7;
        const int z = (int)(at[2] >> grid->fraction_bits) & 7;
        mask->row[z * WEFT_BRICK_SIZE + y] |= (uint8_t)(1u << x);
        for (int a = 0; a < 3; a++)
            at[a] += grid->du[a];
    }
}

static bool mark_span(void *priv, const struct weft_span *span)
{
    struct marker *m = priv;
    const struct weft_slice_grid *grid = &m->marking->footprint->grid;
    const int bx = span->x / WEFT_GRID_BLOCK, by = span->y / WEFT_GRID_BLOCK;
    struct mask *mask = find_mask(&m->cells, span->cell);
    if (!mask)
        return false;
    if (bx != m->block_x || by != m->block_y)
        weft_slice_grid_block(grid, bx, by, &m->block);
    m->block_x = bx;
    m->block_y = by;
    const bool one = memcmp(span->low, span->high, sizeof span->low) == 0;
    mark_positions(grid, &m->block, span->x % WEFT_GRID_BLOCK, span->y % WEFT_GRID_BLOCK,
                   one ? 1 : span->count, mask);
    return true;
}

static bool mark_pixels(void *priv, int thread, size_t part)
{
    struct marking *m = priv;
    const int end = ((int)part + 1) * PART_ROWS;
    for (int y = (int)part * PART_ROWS; y < end && y < m->part.height; y++) {
        if (thread == 0 && !go_on(m->progress, 0.0)) {
            m->cancelled = true;
            return false;
        }
        if (!weft_slice_grid_walk(&m->footprint->grid, m->part.x, m->part.y + y, m->part.width, 1,
                                  mark_span, &m->marker[thread]))
            return false;
    }
    return true;
}

// The first thread's cells are those of all by now.
static bool mark_cells(void *priv, int thread, size_t part)
{
    struct marking *m = priv;
    const struct reached *cells = &m->marker[0].cells;
    const size_t end = (part + 1) * PART_CELLS;
    for (size_t i = part * PART_CELLS; i < end && i < cells->bricks.count; i++)
        if (!mark_cell(m->footprint, cells->bricks.keys[i], &cells->masks[i],
                       &m->marker[thread].voxels))
            return false;
    return true;
}

static bool mark_all(struct marking *m, int threads)
{
    struct marker *first = &m->marker[0];
    const size_t rows = (size_t)m->part.height;
    bool done = weft_threads_run(threads, (rows + PART_ROWS - 1) / PART_ROWS, mark_pixels, m);
    for (int t = 1; done && t < threads; t++)
        done = reached_join(&first->cells, &m->marker[t].cells);
    const size_t cells = first->cells.bricks.count;
    done = done && weft_threads_run(threads, (cells + PART_CELLS - 1) / PART_CELLS, mark_cells, m);
    for (int t = 1; done && t < threads; t++)
        done = reached_join(&first->voxels, &m->marker[t].voxels);
    return done;
}

struct measure_how {
    struct weft_rectangle part; // of the slice's pixels
    bool differences;           // as well as the range
    int threads;
    const struct weft_progress *progress;
};

static struct weft_rectangle whole_of(const weft_footprint *f)
{
    return (struct weft_rectangle){0, 0, f->grid.index.width, f->grid.index.height};
}

static enum weft_result find_reached(const weft_footprint *f, const struct measure_how *how,
                                     struct reached *out)
{
    const int threads = how->threads;
    struct marking m = {.footprint = f,
                        .part = how->part,
                        .progress = how->progress,
                        .marker = calloc((size_t)threads, sizeof *m.marker)};
    for (int t = 0; m.marker && t < threads; t++) {
        m.marker[t].block_x = -1;
        m.marker[t].marking = &m;
    }
    const bool done = m.marker && mark_all(&m, threads);
    if (m.marker)
        *out = m.marker[0].voxels;
    for (int t = 0; m.marker && t < threads; t++) {
        reached_destroy(&m.marker[t].cells);
        if (t > 0)
            reached_destroy(&m.marker[t].voxels);
    }
    free(m.marker);
    if (done)
        return WEFT_OK;
    if (m.cancelled)
        return WEFT_ERR_CANCELLED;
    weft_error(f->log, "not enough memory to measure %zu bricks", out->bricks.count);
    return WEFT_ERR_MEMORY;
}

// ---- their voxels -------------------------------------------------------------------------------

// Bricks from number `from` on that have voxels, `count` of them at most; returns where to go on.
// What has none is measured at once.
static size_t next_bricks(weft_footprint *f, const struct reached *reached, size_t from,
                          size_t count, struct weft_cell_map *out)
{
    for (; from < reached->bricks.count && out->count < count; from++) {
        const struct weft_cell_key *key = &reached->bricks.keys[from];
        const int32_t origin[3] = {key->at[0] * 8, key->at[1] * 8, key->at[2] * 8};
        const float *values;
        float constant;
        if (weft_brick_store_find(f->bricks.places, origin, &values, &constant) !=
            WEFT_BRICK_VALUES)
            measure_constant(constant, &reached->masks[from], &f->voxels);
        else if (weft_cell_map_add(out, *key) == WEFT_CELL_NONE)
            return from;
    }
    return from;
}

// Bricks that were read, which threads measure.
struct measuring {
    const struct reached *reached;
    const struct weft_cell_map *bricks;
    const weft_brick_store *store;
    bool differences;
    struct weft_statistics *voxels; // of each thread
};

static bool measure_part(void *priv, int thread, size_t part)
{
    const struct measuring *m = priv;
    const size_t end = (part + 1) * PART_CELLS;
    for (size_t i = part * PART_CELLS; i < end && i < m->bricks->count; i++) {
        const struct weft_cell_key *key = &m->bricks->keys[i];
        const int32_t origin[3] = {key->at[0] * 8, key->at[1] * 8, key->at[2] * 8};
        const float *values;
        float constant;
        weft_brick_store_find(m->store, origin, &values, &constant);
        measure_voxels(values, &m->reached->masks[weft_cell_map_find(&m->reached->bricks, *key)],
                       &m->voxels[thread]);
        if (m->differences)
            measure_differences(values, &m->voxels[thread]);
    }
    return true;
}

static enum weft_result measure_bricks(weft_footprint *f, const struct measure_how *how,
                                       const struct reached *reached,
                                       const struct weft_cell_map *bricks)
{
    struct weft_statistics voxels[WEFT_CPU_MAX_THREADS];
    struct measuring m = {.reached = reached,
                          .bricks = bricks,
                          .differences = how->differences && !f->coefficients,
                          .voxels = voxels};
    const enum weft_result res = weft_footprint_load(f, bricks, 0, &m.store);
    if (res != WEFT_OK)
        return res;
    for (int t = 0; t < how->threads; t++)
        voxels[t] = (struct weft_statistics)WEFT_STATISTICS_NONE;
    weft_threads_run(how->threads, (bricks->count + PART_CELLS - 1) / PART_CELLS, measure_part, &m);
    for (int t = 0; t < how->threads; t++)
        weft_statistics_join(&f->voxels, &voxels[t]);
    return WEFT_OK;
}

// Reads the bricks in reach in lots.
static enum weft_result measure_reached(weft_footprint *f, const struct measure_how *how)
{
    enum { LOT = 1 << 14 };
    struct reached reached = {.masks = NULL};
    enum weft_result res = find_reached(f, how, &reached);
    for (size_t at = 0; res == WEFT_OK && at < reached.bricks.count;) {
        struct weft_cell_map lot = {0};
        const size_t next = next_bricks(f, &reached, at, LOT, &lot);
        if (!go_on(how->progress, (double)at / (double)reached.bricks.count)) {
            res = WEFT_ERR_CANCELLED;
        } else if (next < reached.bricks.count && lot.count < LOT) {
            weft_error(f->log, "not enough memory to measure %zu bricks", reached.bricks.count);
            res = WEFT_ERR_MEMORY;
        } else {
            res = measure_bricks(f, how, &reached, &lot);
        }
        at = next;
        weft_cell_map_destroy(&lot);
    }
    reached_destroy(&reached);
    return res;
}

// ---- what coefficients stand for ----------------------------------------------------------------

// Regions of rising size: what is in reach, then what lies beyond within each cut.
struct reach {
    struct weft_region taps;
    struct weft_region region[1 + WEFT_SLICE_SHELLS];
    struct weft_slice_statistics *out;
    struct weft_slice_shells *shells;
};

static void set_reach(const weft_footprint *f, struct reach *reach)
{
    const struct weft_volume_info *info = weft_volume_get_info(f->volume);
    struct weft_region taps;
    weft_slice_grid_region(&f->grid, f->info.kernel.width, &taps);
    for (int i = 0; i <= WEFT_SLICE_SHELLS; i++) {
        reach->region[i] = weft_region_widen(&taps, reach->shells->overlap[i]);
        if (info->clamp_to_edge)
            weft_region_clamp(info, &reach->region[i]);
    }
    if (info->clamp_to_edge)
        weft_region_clamp(info, &taps);
    reach->taps = taps;
}

// 0: in reach; else in shell n - 1, the nearest one that the cube meets. At least `from`.
static int find_reach(const struct reach *reach, const int32_t origin[3], int32_t size, int from)
{
    while (from < WEFT_SLICE_SHELLS && !weft_region_meets(&reach->region[from], origin, size))
        from++;
    return from;
}

static bool is_known(const struct reach *reach, int at, double value)
{
    return !isfinite(value) ||
           fabs(value) <= (at ? reach->shells->largest[at - 1] : reach->shells->at_taps);
}

static void add_reached(const struct reach *reach, const int32_t origin[3], int32_t size, int from,
                        double value)
{
    struct weft_slice_statistics *out = reach->out;
    const int at = find_reach(reach, origin, size, from);
    if (at) {
        reach->shells->largest[at - 1] = fmax(reach->shells->largest[at - 1], fabs(value));
        return;
    }
    out->voxel_low = fmin(out->voxel_low, value);
    out->voxel_high = fmax(out->voxel_high, value);
    if (fabs(value) > reach->shells->at_taps && weft_region_meets(&reach->taps, origin, size))
        reach->shells->at_taps = fabs(value);
}

// Each voxel where it is itself, if that may change anything.
static bool measure_brick(const struct reach *reach, const int32_t origin[3], const float *values)
{
    const int at = find_reach(reach, origin, WEFT_BRICK_SIZE, 0);
    for (int i = 0; i < WEFT_BRICK_VOXELS; i++) {
        const double value = (double)values[i];
        const int32_t voxel[3] = {origin[0] + (i & 7), origin[1] + (i >> 3 & 7),
                                  origin[2] + (i >> 6)};
        const bool widens =
            at == 0 && (value < reach->out->voxel_low || value > reach->out->voxel_high);
        if (isfinite(value) && (widens || !is_known(reach, at, value)))
            add_reached(reach, voxel, 1, at, value);
    }
    return at == 0;
}

// Whether a brick that was not seen before is all of one value; false: out of memory.
static bool look_up(const weft_brick_store *places, struct weft_cell_key key, float value,
                    struct weft_cell_map *seen, bool *found)
{
    const int32_t origin[3] = {key.at[0] * 8, key.at[1] * 8, key.at[2] * 8};
    const size_t known = seen->count;
    const float *values;
    float constant;
    if (weft_cell_map_add(seen, key) == WEFT_CELL_NONE)
        return false;
    *found = seen->count > known &&
             weft_brick_store_find(places, origin, &values, &constant) == WEFT_BRICK_CONSTANT &&
             constant == value;
    return true;
}

// Whether the taps of some cell, and what lies up to `overlap` voxels around them, are on the
// background, or on a tile of its value.
static enum weft_result find_background(const weft_footprint *f, const weft_brick_store *places,
                                        const struct weft_slice_cells *cells, int overlap,
                                        bool *found)
{
    const float background = weft_volume_get_info(f->volume)->background;
    struct weft_cell_map seen = {0};
    bool enough = true;
    *found = false;
    for (size_t i = 0; enough && !*found && i < cells->map.count; i++) {
        int32_t min[3], max[3];
        struct weft_cell_key at;
        weft_footprint_cell_box(f, cells, i, min, max);
        for (int a = 0; a < 3; a++) {
            min[a] = (min[a] - overlap) >> 3;
            max[a] = (max[a] + overlap) >> 3;
        }
        for (at.at[2] = min[2]; enough && !*found && at.at[2] <= max[2]; at.at[2]++)
            for (at.at[1] = min[1]; enough && !*found && at.at[1] <= max[1]; at.at[1]++)
                for (at.at[0] = min[0]; enough && !*found && at.at[0] <= max[0]; at.at[0]++)
                    enough = look_up(places, at, background, &seen, found);
    }
    weft_cell_map_destroy(&seen);
    if (enough)
        return WEFT_OK;
    weft_error(f->log, "not enough memory to look for the background");
    return WEFT_ERR_MEMORY;
}

static enum weft_result measure_background(weft_footprint *f, const struct reach *reach,
                                           const struct weft_brick_list *list)
{
    const struct weft_volume_info *info = weft_volume_get_info(f->volume);
    const struct weft_rectangle whole = whole_of(f);
    const double value = (double)info->background;
    const struct weft_slice_cells *cells = NULL;
    weft_brick_store *places = NULL;
    bool near, at_taps;
    if (!isfinite(value) || info->clamp_to_edge)
        return WEFT_OK;
    enum weft_result res = weft_brick_places_create(f->log, info, list, &places);
    if (res == WEFT_OK)
        res = weft_footprint_cells(f, &whole, NULL, 0.0, &cells);
    if (res == WEFT_OK)
        res = find_background(f, places, cells, reach->shells->overlap[0], &near);
    if (res == WEFT_OK)
        res = find_background(f, places, cells, 0, &at_taps);
    weft_footprint_release(f, &cells);
    weft_brick_store_destroy(&places);
    if (res != WEFT_OK)
        return res;
    if (near) {
        reach->out->voxel_low = fmin(reach->out->voxel_low, value);
        reach->out->voxel_high = fmax(reach->out->voxel_high, value);
    } else { // it may be anywhere else
        reach->shells->largest[0] = fmax(reach->shells->largest[0], fabs(value));
    }
    if (at_taps)
        reach->shells->at_taps = fmax(reach->shells->at_taps, fabs(value));
    return WEFT_OK;
}

static double sum_shells(const struct weft_slice_shells *shells)
{
    double sum = 0.0;
    for (int i = WEFT_SLICE_SHELLS - 1; i >= 0; i--)
        sum = shells->largest[i] + WEFT_SLICE_SHELL_FALL * sum;
    return sum;
}

// A few bricks at a time.
static enum weft_result measure_bricks_around(weft_footprint *f,
                                              const struct weft_progress *progress,
                                              const struct weft_brick_list *list,
                                              struct reach *reach)
{
    enum { CHUNK = 1024 };
    enum weft_result res = WEFT_OK;
    float *values = malloc(CHUNK * WEFT_BRICK_VOXELS * sizeof *values);
    if (!values) {
        weft_error(f->log, "not enough memory to measure %d bricks", CHUNK);
        return WEFT_ERR_MEMORY;
    }
    for (size_t from = 0; res == WEFT_OK && from < list->brick_count; from += CHUNK) {
        const size_t left = list->brick_count - from, count = left < CHUNK ? left : CHUNK;
        const int32_t(*origin)[3] = (const int32_t(*)[3])list->brick_origin + from;
        res = go_on(progress, (double)from / (double)list->brick_count)
                  ? weft_footprint_read_samples(f, count, origin, values)
                  : WEFT_ERR_CANCELLED;
        for (size_t b = 0; res == WEFT_OK && b < count; b++) {
            const float *brick = values + b * WEFT_BRICK_VOXELS;
            if (measure_brick(reach, origin[b], brick))
                measure_differences(brick, &f->voxels);
        }
    }
    free(values);
    return res;
}

static enum weft_result measure_around(weft_footprint *f, const struct weft_progress *progress)
{
    struct reach reach = {.out = &f->statistics, .shells = &f->shells};
    struct weft_brick_list list = {0};
    set_reach(f, &reach);
    enum weft_result res = weft_volume_find(f->volume, &reach.region[WEFT_SLICE_SHELLS], &list);
    if (res == WEFT_OK)
        res = measure_bricks_around(f, progress, &list, &reach);
    if (res == WEFT_OK)
        res = measure_background(f, &reach, &list);
    for (size_t i = 0; i < list.tile_count; i++)
        if (isfinite(list.tiles[i].value))
            add_reached(&reach, list.tiles[i].origin, list.tiles[i].size, 0,
                        (double)list.tiles[i].value);
    f->statistics.beyond = sum_shells(&f->shells);
    weft_brick_list_clear(&list);
    return res;
}

static void set_shells(const struct weft_kernel *kernel, struct weft_slice_shells *out)
{
    struct weft_prefilter prefilter;
    double cut = WEFT_VOLUME_PREFILTER_ERROR;
    *out = (struct weft_slice_shells){.overlap = {0}};
    if (weft_prefilter_compute(NULL, kernel, &prefilter) != WEFT_OK)
        return;
    for (int i = 0; i <= WEFT_SLICE_SHELLS; i++, cut *= WEFT_SLICE_SHELL_FALL)
        out->overlap[i] = weft_prefilter_overlap(&prefilter, cut);
}

// ---- all ----------------------------------------------------------------------------------------

// Where nothing is finite the range is 0.
static void set_range(double minimum, double maximum, double *low, double *high)
{
    *low = minimum <= maximum ? minimum : 0.0;
    *high = minimum <= maximum ? maximum : 0.0;
}

static void set_range_of_voxels(weft_footprint *f)
{
    struct weft_slice_statistics *out = &f->statistics;
    const struct weft_statistics *voxels = &f->voxels;
    set_range(voxels->minimum, voxels->maximum, &out->low, &out->high);
    out->voxels = voxels->count;
    out->not_finite = voxels->not_finite;
}

static void set_statistics(weft_footprint *f)
{
    struct weft_slice_statistics *out = &f->statistics;
    set_range_of_voxels(f);
    memcpy(out->difference, f->voxels.difference, sizeof out->difference);
    if (f->coefficients)
        set_range(out->voxel_low, out->voxel_high, &out->voxel_low, &out->voxel_high);
    else
        set_range(out->low, out->high, &out->voxel_low, &out->voxel_high);
}

static void clear_statistics(weft_footprint *f)
{
    f->voxels = (struct weft_statistics)WEFT_STATISTICS_NONE;
    f->statistics = (struct weft_slice_statistics){.voxel_low = INFINITY, .voxel_high = -INFINITY};
}

enum weft_result weft_footprint_measure(weft_footprint *f, const struct weft_progress *progress)
{
    if (f->measured)
        return WEFT_OK;
    const struct measure_how how = {
        .part = whole_of(f), .differences = true, .threads = 1, .progress = progress};
    f->ranged = false;
    clear_statistics(f);
    set_shells(&f->info.kernel, &f->shells);
    enum weft_result res = weft_footprint_open(f);
    if (res == WEFT_OK && f->coefficients)
        res = measure_around(f, progress);
    if (res == WEFT_OK)
        res = measure_reached(f, &how);
    if (res != WEFT_OK)
        return res;
    set_statistics(f);
    f->ranged = f->measured = true;
    return WEFT_OK;
}

enum weft_result weft_footprint_measure_range(weft_footprint *f, int threads,
                                              const struct weft_progress *progress)
{
    if (f->ranged)
        return WEFT_OK;
    const struct measure_how how = {.part = whole_of(f), .threads = threads, .progress = progress};
    clear_statistics(f);
    enum weft_result res = weft_footprint_open(f);
    if (res == WEFT_OK)
        res = measure_reached(f, &how);
    if (res != WEFT_OK)
        return res;
    set_range_of_voxels(f);
    f->ranged = true;
    return WEFT_OK;
}

enum weft_result weft_footprint_statistics(weft_footprint *footprint,
                                           const struct weft_progress *progress,
                                           struct weft_slice_statistics *out)
{
    const enum weft_result res = weft_footprint_measure(footprint, progress);
    *out = footprint->statistics;
    return res;
}

// ---- parts --------------------------------------------------------------------------------------

enum weft_result weft_footprint_part_statistics(weft_footprint *f,
                                                const struct weft_rectangle *part,
                                                const struct weft_progress *progress,
                                                struct weft_slice_statistics *out)
{
    const struct weft_statistics known_voxels = f->voxels;
    const struct weft_slice_statistics known = f->statistics;
    struct measure_how how = {.differences = true, .threads = 1, .progress = progress};
    *out = (struct weft_slice_statistics){0};
    if (f->coefficients) {
        weft_error(f->log, "kernel %si: voxels are measured for all of a slice, not for parts",
                   f->info.kernel.info->name);
        return WEFT_ERR_UNSUPPORTED;
    }
    enum weft_result res =
        weft_rectangle_within(f->log, part, f->grid.index.width, f->grid.index.height, &how.part);
    if (res == WEFT_OK)
        res = weft_footprint_open(f);
    if (res != WEFT_OK)
        return res;
    clear_statistics(f);
    res = measure_reached(f, &how);
    if (res == WEFT_OK) {
        set_statistics(f);
        *out = f->statistics;
    }
    f->voxels = known_voxels;
    f->statistics = known;
    return res;
}

static bool has_range(const struct weft_slice_statistics *s)
{
    return s->voxels > s->not_finite;
}

struct weft_slice_statistics weft_slice_statistics_join(const struct weft_slice_statistics *a,
                                                        const struct weft_slice_statistics *b)
{
    const struct weft_slice_statistics *ranged = has_range(a) ? a : b;
    struct weft_slice_statistics out = *ranged;
    out.voxels = a->voxels + b->voxels;
    out.not_finite = a->not_finite + b->not_finite;
    out.beyond = fmax(a->beyond, b->beyond);
    for (int i = 0; i < WEFT_STATISTICS_DIFFERENCES; i++)
        out.difference[i] = fmax(a->difference[i], b->difference[i]);
    if (!has_range(a) || !has_range(b))
        return out;
    out.low = fmin(a->low, b->low);
    out.high = fmax(a->high, b->high);
    out.voxel_low = fmin(a->voxel_low, b->voxel_low);
    out.voxel_high = fmax(a->voxel_high, b->voxel_high);
    return out;
}

void weft_footprint_set_statistics(weft_footprint *f,
                                   const struct weft_slice_statistics *statistics)
{
    f->statistics = *statistics;
    f->ranged = true;
    f->measured = !f->coefficients;
}
