// SPDX-License-Identifier: BSD-3-Clause
// Runs: bricks are listed strip by strip, computed many at a time, and handed over in order.
#include <stdlib.h>
#include <string.h>

#include "passes/lattice/lattice_impl.h"
#include "tiles/volume/volume_impl.h"

enum {
    BATCH_BRICKS = 8192, // that are computed and handed over together, but for a strip of more
    MEMO_BLOCKS = 1 << 16,
};

// What threads share, and what each has of its own.
struct run {
    weft_lattice_plan *plan;
    const struct weft_lattice_run_params *params;
    struct weft_cpu cpu;
    struct weft_lattice_lines lines;
    struct weft_lattice_memo memo;
    struct weft_lattice_list list; // of the batch
    struct weft_lattice_block *block;
    size_t block_count, block_capacity, first_block; // the last: of those that are computed now
    size_t room;                                     // bricks that values and made have room for
    float *values[WEFT_LATTICE_GRIDS];               // of each grid, brick after brick
    struct weft_lattice_made *made[WEFT_LATTICE_GRIDS];
    struct weft_lattice_scratch *scratch; // of each thread
    struct weft_lattice_checked *checked; // likewise
    double *verify_seconds;               // likewise
    uint64_t source_bytes;                // that may be kept of the source
    struct weft_lattice_report report;
};

// ---- blocks -------------------------------------------------------------------------------------

static int block_side(const struct weft_lattice_plan *plan)
{
    const double widest =
        fmax(fmax(plan->info.stretch[0], plan->info.stretch[1]), plan->info.stretch[2]);
    if (!plan->info.separable)
        return WEFT_BRICK_SIZE;
    return widest > 4.0 ? WEFT_BRICK_SIZE : WEFT_LATTICE_STRIP;
}

static void widen(struct weft_lattice_box *box, const int32_t origin[3])
{
    for (int a = 0; a < 3; a++) {
        const int64_t last = origin[a] + WEFT_BRICK_SIZE - 1;
        box->min[a] = box->min[a] < origin[a] ? box->min[a] : origin[a];
        box->max[a] = box->max[a] > last ? box->max[a] : last;
    }
}

// Bricks of a batch by the block that they are in: sorted by z, y / side, x / side.
struct placed {
    int32_t key[3];
    size_t brick;
};

static int compare_placed(const void *a, const void *b)
{
    const struct placed *p = a, *q = b;
    const int order = weft_compare_origins(p->key, q->key);
    return order ? order : p->brick < q->brick ? -1 : p->brick > q->brick;
}

static bool add_block(struct run *run, const struct placed *from, size_t count)
{
    if (run->block_count == run->block_capacity) {
        const size_t capacity = run->block_capacity ? 2 * run->block_capacity : 64;
        void *grown = realloc(run->block, capacity * sizeof *run->block);
        if (!grown)
            return false;
        run->block = grown;
        run->block_capacity = capacity;
    }
    struct weft_lattice_block *block = &run->block[run->block_count++];
    *block = (struct weft_lattice_block){
        .box = {{INT64_MAX, INT64_MAX, INT64_MAX}, {INT64_MIN, INT64_MIN, INT64_MIN}},
        .count = count};
    block->brick = malloc(count * sizeof *block->brick);
    if (!block->brick)
        return false;
    for (size_t i = 0; i < count; i++) {
        block->brick[i] = from[i].brick;
        widen(&block->box, run->list.brick[from[i].brick]);
    }
    block->reach = weft_lattice_footprint(run->plan, &block->box);
    return true;
}

static void clear_blocks(struct run *run)
{
    for (size_t i = 0; i < run->block_count; i++)
        free(run->block[i].brick);
    run->block_count = 0;
}

static bool make_blocks(struct run *run)
{
    const int side = block_side(run->plan);
    const size_t count = run->list.brick_count;
    struct placed *placed = malloc(count * sizeof *placed + 1);
    bool made = placed != NULL;
    for (size_t i = 0; made && i < count; i++) {
        placed[i].brick = i;
        for (int a = 0; a < 3; a++)
            placed[i].key[a] = run->list.brick[i][a] & (a < 2 ? -side : -WEFT_BRICK_SIZE);
    }
    if (made)
        qsort(placed, count, sizeof *placed, compare_placed);
    for (size_t from = 0, to; made && from < count; from = to) {
        for (to = from + 1;
             to < count && weft_compare_origins(placed[from].key, placed[to].key) == 0; to++)
            ;
        made = add_block(run, placed + from, to - from);
    }
    free(placed);
    return made;
}

// ---- computing ----------------------------------------------------------------------------------

static bool compute_brick(struct run *run, const struct weft_lattice_work *work, int thread,
                          const double *derivative, const size_t pitch[3], size_t brick)
{
    const struct weft_lattice_info *info = &run->plan->info;
    const int32_t *origin = run->list.brick[brick];
    float *channel[WEFT_QUANTITY_CHANNELS];
    for (int g = 0; g < info->grid_count; g++)
        for (int c = 0; c < info->grid[g].components; c++)
            channel[info->grid[g].channel + c] =
                run->values[g] +
                (brick * (size_t)info->grid[g].components + (size_t)c) * WEFT_BRICK_VOXELS;
    weft_lattice_channels(work, derivative, pitch, origin, channel);
    for (int g = 0; g < info->grid_count; g++) {
        float *values = channel[info->grid[g].channel];
        struct weft_lattice_made *made = &run->made[g][brick];
        *made = weft_lattice_finish(run->plan, g, origin, values);
        const double start = weft_now_seconds();
        if (!weft_lattice_verify_brick(work, &run->params->verify, g, origin, values,
                                       &run->checked[thread]))
            return false;
        run->verify_seconds[thread] += weft_now_seconds() - start;
    }
    return true;
}

static bool compute_block(void *priv, int thread, size_t i)
{
    struct run *run = priv;
    const struct weft_lattice_block *block = &run->block[run->first_block + i];
    const struct weft_lattice_work work = {.plan = run->plan,
                                           .memo = &run->memo,
                                           .lines = &run->lines,
                                           .scratch = &run->scratch[thread],
                                           .block = block};
    const double *derivative;
    size_t pitch[3];
    if (!(run->plan->info.separable ? weft_lattice_compute_separable
                                    : weft_lattice_compute_direct)(&work, &derivative, pitch))
        return false;
    for (size_t b = 0; b < block->count; b++)
        if (!compute_brick(run, &work, thread, derivative, pitch, block->brick[b]))
            return false;
    return true;
}

static bool need_weights(struct run *run, const struct weft_lattice_block *block)
{
    for (int a = 0; run->plan->info.separable && a < 3; a++)
        for (int64_t at = block->box.min[a]; at <= block->box.max[a]; at += WEFT_BRICK_SIZE)
            if (!weft_lattice_memo_get(run->plan, &run->memo, a, (int32_t)at))
                return false;
    return true;
}

static enum weft_result out_of_memory(const struct run *run)
{
    weft_error(run->plan->log, "not enough memory for %zu bricks", run->list.brick_count);
    return WEFT_ERR_MEMORY;
}

static void note_peak(struct run *run)
{
    uint64_t bytes = run->plan->reader.kept_bytes + run->memo.capacity * sizeof(void *);
    for (int t = 0; t < run->cpu.threads; t++)
        bytes += run->scratch[t].capacity * sizeof(double);
    for (int g = 0; g < run->plan->info.grid_count; g++)
        bytes += run->room *
                 ((size_t)run->plan->info.grid[g].components * WEFT_BRICK_VOXELS * sizeof(float) +
                  sizeof *run->made[g]);
    run->report.peak_bytes = bytes > run->report.peak_bytes ? bytes : run->report.peak_bytes;
}

// Computes blocks whose bricks of the source are there.
static enum weft_result compute_some(struct run *run, size_t from, size_t to)
{
    const double start = weft_now_seconds();
    if (run->memo.known.count > MEMO_BLOCKS)
        weft_lattice_memo_clear(&run->memo);
    for (size_t i = from; i < to; i++)
        if (!need_weights(run, &run->block[i]))
            return out_of_memory(run);
    run->first_block = from;
    const bool done = weft_threads_run(run->cpu.threads, to - from, compute_block, run);
    run->report.pass_seconds += weft_now_seconds() - start;
    note_peak(run);
    return done ? WEFT_OK : out_of_memory(run);
}

// Notes what blocks from `from` on need of the source, as many as memory holds. Returns the first
// that was left out; `from` where it does not hold what one needs.
static enum weft_result note_blocks(struct run *run, size_t from, struct weft_cell_map *bricks,
                                    size_t *to)
{
    const size_t most = run->source_bytes / (WEFT_BRICK_VOXELS * sizeof(float));
    enum weft_result res = WEFT_OK;
    for (*to = from; *to < run->block_count; ++*to) {
        int32_t min[3], max[3];
        for (int a = 0; a < 3; a++) {
            min[a] = (int32_t)run->block[*to].reach.min[a] - 1;
            max[a] = (int32_t)run->block[*to].reach.max[a] + 1;
        }
        struct weft_cell_map one = {0};
        bool noted = weft_brick_reader_note(&run->plan->reader, min, max, &one);
        const bool fits = *to == from ? one.count <= most : bricks->count + one.count <= most;
        for (size_t i = 0; noted && fits && i < one.count; i++)
            noted = weft_cell_map_add(bricks, one.keys[i]) != WEFT_CELL_NONE;
        if (noted && !fits && *to == from) {
            weft_error(run->plan->log,
                       "a block needs %zu bricks of the source, which memory of %llu bytes does "
                       "not hold",
                       one.count, (unsigned long long)run->plan->memory_bytes);
            res = WEFT_ERR_LIMIT;
        }
        weft_cell_map_destroy(&one);
        if (!noted)
            res = out_of_memory(run);
        if (res != WEFT_OK || !fits)
            return res;
    }
    return res;
}

static enum weft_result compute_batch(struct run *run)
{
    struct weft_brick_reader *reader = &run->plan->reader;
    enum weft_result res = WEFT_OK;
    for (size_t from = 0, to = 0; res == WEFT_OK && from < run->block_count; from = to) {
        struct weft_cell_map bricks = {0};
        to = run->block_count;
        if (!reader->borrowed) {
            res = note_blocks(run, from, &bricks, &to);
            const size_t missing = res == WEFT_OK ? weft_brick_reader_missing(reader, &bricks) : 0;
            if (reader->kept_bytes + missing * WEFT_BRICK_VOXELS * sizeof(float) >
                run->source_bytes)
                weft_brick_reader_drop(reader);
            if (res == WEFT_OK)
                res = weft_brick_reader_load(reader, &bricks);
        }
        weft_cell_map_destroy(&bricks);
        if (res == WEFT_OK)
            res = compute_some(run, from, to);
    }
    return res;
}

// ---- handing over -------------------------------------------------------------------------------

static int compare_tiles(const void *a, const void *b)
{
    return weft_compare_origins(((const struct weft_volume_tile *)a)->origin,
                                ((const struct weft_volume_tile *)b)->origin);
}

static bool tile_is_active(const struct weft_lattice_plan *plan, int grid, float value)
{
    const float background = plan->info.grid[grid].grid.background;
    return plan->info.clamps && plan->info.grid[grid].quantity == WEFT_QUANTITY_VALUE
               ? fabsf(value) < fabsf(background)
               : memcmp(&value, &background, sizeof value) != 0;
}

static void count_lot(struct run *run, const struct weft_volume_lot *lot)
{
    struct weft_lattice_report *report = &run->report;
    report->bricks_out[lot->grid] += lot->brick_count;
    report->tiles_out[lot->grid] += lot->tile_count;
    for (size_t i = 0; i < lot->tile_count; i++)
        if (tile_is_active(run->plan, lot->grid, lot->tiles[i].value))
            report->active_voxels[lot->grid] += (uint64_t)lot->tiles[i].size *
                                                (uint64_t)lot->tiles[i].size *
                                                (uint64_t)lot->tiles[i].size;
}

// Moves the bricks that are kept together, and lists what became tiles.
static enum weft_result send_grid(struct run *run, int grid)
{
    const struct weft_lattice_grid *of = &run->plan->info.grid[grid];
    const struct weft_lattice_list *list = &run->list;
    const size_t size = (size_t)of->components * WEFT_BRICK_VOXELS;
    const bool is_value = of->quantity == WEFT_QUANTITY_VALUE;
    const size_t tiles = is_value ? list->tile_count : 0;
    struct weft_volume_lot lot = {.grid = grid, .values = run->values[grid]};
    int32_t(*origin)[3] = malloc(list->brick_count * sizeof *origin + 1);
    struct weft_volume_tile *tile = malloc((list->brick_count + tiles) * sizeof *tile + 1);
    enum weft_result res = WEFT_OK;
    if (!origin || !tile) {
        res = out_of_memory(run);
        goto fail;
    }
    for (size_t i = 0; i < list->brick_count; i++) {
        const struct weft_lattice_made *made = &run->made[grid][i];
        run->report.active_voxels[grid] += made->kind == WEFT_LATTICE_VALUES ? made->active : 0;
        run->report.not_finite += made->not_finite;
        run->report.clamped += made->clamped;
        if (made->kind == WEFT_LATTICE_TILE) {
            tile[lot.tile_count++] =
                (struct weft_volume_tile){{list->brick[i][0], list->brick[i][1], list->brick[i][2]},
                                          WEFT_BRICK_SIZE,
                                          made->constant};
        } else if (made->kind == WEFT_LATTICE_VALUES) {
            memcpy(origin[lot.brick_count], list->brick[i], sizeof *origin);
            if (lot.brick_count < i)
                memcpy(run->values[grid] + lot.brick_count * size, run->values[grid] + i * size,
                       size * sizeof(float));
            lot.brick_count++;
        }
    }
    for (size_t i = 0; i < tiles; i++)
        tile[lot.tile_count++] = list->tile[i];
    qsort(tile, lot.tile_count, sizeof *tile, compare_tiles);
    lot.brick_origin = (const int32_t(*)[3])origin;
    lot.tiles = tile;
    count_lot(run, &lot);
    res = lot.brick_count + lot.tile_count ? run->params->sink(run->params->priv, &lot) : WEFT_OK;
fail:
    free(origin);
    free(tile);
    return res;
}

static enum weft_result need_room(struct run *run)
{
    const size_t count = run->list.brick_count;
    const struct weft_lattice_info *info = &run->plan->info;
    if (count <= run->room)
        return WEFT_OK;
    uint64_t bytes = 0;
    for (int g = 0; g < info->grid_count; g++)
        bytes += count * WEFT_BRICK_VOXELS * sizeof(float) * (uint64_t)info->grid[g].components;
    if (bytes > run->plan->memory_bytes / 2) {
        weft_error(run->plan->log,
                   "a strip of the result has %zu bricks, %llu bytes, more than half of the memory "
                   "of %llu bytes",
                   count, (unsigned long long)bytes, (unsigned long long)run->plan->memory_bytes);
        return WEFT_ERR_LIMIT;
    }
    run->room = 0;
    for (int g = 0; g < info->grid_count; g++) {
        free(run->values[g]);
        free(run->made[g]);
        run->values[g] = malloc(count * (size_t)info->grid[g].components * WEFT_BRICK_VOXELS *
                                sizeof *run->values[g]);
        run->made[g] = malloc(count * sizeof *run->made[g]);
        if (!run->values[g] || !run->made[g])
            return out_of_memory(run);
    }
    run->room = count;
    return WEFT_OK;
}

static bool go_on(const struct run *run, double fraction)
{
    const struct weft_progress *progress = run->params->progress;
    return !progress || !progress->report || progress->report(progress->priv, fraction);
}

static enum weft_result finish_batch(struct run *run, double fraction)
{
    enum weft_result res = go_on(run, fraction) ? need_room(run) : WEFT_ERR_CANCELLED;
    if (res == WEFT_OK && !make_blocks(run))
        res = out_of_memory(run);
    if (res == WEFT_OK)
        res = compute_batch(run);
    clear_blocks(run);
    run->report.bricks_computed += run->list.brick_count;
    const double start = weft_now_seconds();
    for (int g = 0; res == WEFT_OK && g < run->plan->info.grid_count; g++)
        res = send_grid(run, g);
    run->report.sink_seconds += weft_now_seconds() - start;
    run->list.brick_count = run->list.tile_count = 0;
    return res;
}

// ---- all ----------------------------------------------------------------------------------------

static size_t batch_bricks(const struct run *run)
{
    size_t components = 0;
    for (int g = 0; g < run->plan->info.grid_count; g++)
        components += (size_t)run->plan->info.grid[g].components;
    const uint64_t fit =
        run->plan->memory_bytes / 4 / (components * WEFT_BRICK_VOXELS * sizeof(float));
    return fit < BATCH_BRICKS ? (size_t)fit : BATCH_BRICKS;
}

static enum weft_result run_all(struct run *run)
{
    const struct weft_lattice_info *info = &run->plan->info;
    const int32_t strip = WEFT_LATTICE_STRIP, layer = WEFT_BRICK_SIZE;
    const int32_t first = info->box_min[2] & -layer;
    const double layers = ((double)info->box_max[2] - first) / layer + 1.0;
    const size_t most = batch_bricks(run);
    enum weft_result res = WEFT_OK;
    for (int64_t z = first; res == WEFT_OK && z <= info->box_max[2]; z += layer)
        for (int64_t y = info->box_min[1] & -strip; res == WEFT_OK && y <= info->box_max[1];
             y += strip) {
            res = weft_lattice_walk(run->plan, (int32_t)z, (int32_t)y, &run->list);
            if (res == WEFT_OK && run->list.brick_count + run->list.tile_count >= most)
                res = finish_batch(run, ((double)z - first) / layer / layers);
        }
    if (res == WEFT_OK)
        res = finish_batch(run, 1.0 - 0x1p-10);
    return res == WEFT_OK && !go_on(run, 1.0) ? WEFT_ERR_CANCELLED : res;
}

static enum weft_result begin(struct run *run)
{
    const struct weft_log *log = run->plan->log;
    const struct weft_lattice_run_params *params = run->params;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, params->sink != NULL);
    weft_require(log, params->verify.share >= 0.0 && params->verify.share <= 1.0);
    res = weft_cpu_resolve(log, &params->cpu, &run->cpu);
    if (res != WEFT_OK)
        return res;
    const size_t threads = (size_t)run->cpu.threads;
    run->lines = weft_lattice_lines_find(run->cpu.instructions);
    run->source_bytes = run->plan->memory_bytes / 2;
    run->scratch = calloc(threads, sizeof *run->scratch);
    run->checked = calloc(threads, sizeof *run->checked);
    run->verify_seconds = calloc(threads, sizeof *run->verify_seconds);
    if (run->scratch && run->checked && run->verify_seconds)
        return WEFT_OK;
    weft_error(log, "not enough memory for %zu threads", threads);
    res = WEFT_ERR_MEMORY;
fail:
    return res;
}

static void end(struct run *run)
{
    for (int t = 0; run->scratch && t < run->cpu.threads; t++)
        weft_lattice_scratch_clear(&run->scratch[t]);
    for (int g = 0; g < WEFT_LATTICE_GRIDS; g++) {
        free(run->values[g]);
        free(run->made[g]);
    }
    clear_blocks(run);
    free(run->block);
    free(run->scratch);
    free(run->checked);
    free(run->verify_seconds);
    weft_lattice_list_clear(&run->list);
    weft_lattice_memo_clear(&run->memo);
}

static void join_checked(struct run *run)
{
    struct weft_lattice_report *report = &run->report;
    for (int t = 0; t < run->cpu.threads; t++) {
        const double before = report->verify.maximum;
        weft_verify_join(&report->verify, &run->checked[t].report);
        if (report->verify.maximum > before)
            memcpy(report->verify_at, run->checked[t].at, sizeof report->verify_at);
        report->verify_seconds += run->verify_seconds[t];
    }
}

enum weft_result weft_lattice_run(weft_lattice_plan *plan,
                                  const struct weft_lattice_run_params *params,
                                  struct weft_lattice_report *report)
{
    const double start = weft_now_seconds();
    struct run run = {.plan = plan, .params = params};
    const uint64_t read_before = plan->reader.bricks_read;
    const double seconds_before = plan->reader.read_seconds;
    enum weft_result res = begin(&run);
    if (res == WEFT_OK && !plan->info.empty)
        res = run_all(&run);
    if (res == WEFT_OK) {
        join_checked(&run);
        run.report.bricks_read = plan->reader.bricks_read - read_before;
        run.report.read_seconds = plan->reader.read_seconds - seconds_before;
        run.report.cpu = run.cpu;
        run.report.seconds = weft_now_seconds() - start;
    }
    if (report)
        *report = run.report;
    weft_brick_reader_drop(&plan->reader);
    end(&run);
    return res;
}
