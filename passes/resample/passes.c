// SPDX-License-Identifier: BSD-3-Clause
// Resampling by the passes of a plan, in tiles of the result. The tiles are fixed by the sizes
// alone, so that the result does not depend on anything else.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "passes/resample/resample_impl.h"

// Pixels along a tile's side, and samples that it reaches: what does not fit is cut.
enum { MAX_TILE = 1024, MAX_REACH = 2048, MIN_TILE = 16 };

// ---- planning -----------------------------------------------------------------------------------

static int tile_side(const struct weft_window_map *map)
{
    const double side = floor(MAX_REACH * (double)map->to / (double)map->from);
    return side > MAX_TILE ? MAX_TILE : side < MIN_TILE ? MIN_TILE : (int)side;
}

static int pixels_along(const weft_resample_plan *plan, int axis)
{
    return axis ? plan->info.height : plan->info.width;
}

// Pixels of tile number `at` along an axis.
static int tile_size(const weft_resample_plan *plan, int axis, int at)
{
    const int left = pixels_along(plan, axis) - at * plan->side[axis];
    return left < plan->side[axis] ? left : plan->side[axis];
}

// Values from the first pixel's first tap to the last one's last, or the edge's if there are none.
static void set_reach(const weft_resample_plan *plan, int axis, int at, int *first, int *count)
{
    const int64_t last = (int64_t)plan->info.size[axis] + 2 * plan->info.overlap - 1;
    const struct weft_kernel *kernel = &plan->info.kernel;
    const struct weft_window_map *map = &plan->info.map[axis];
    const int pixel = at * plan->side[axis], size = tile_size(plan, axis, at);
    const int shift = plan->info.overlap;
    double fraction;
    int64_t from =
        weft_kernel_first_tap(kernel, weft_window_map_position(map, pixel, shift), &fraction);
    int64_t to = weft_kernel_first_tap(
                     kernel, weft_window_map_position(map, pixel + size - 1, shift), &fraction) +
                 kernel->width - 1;
    from = from < 0 ? 0 : from > last ? last : from;
    to = to > last ? last : to < 0 ? 0 : to;
    *first = (int)from;
    *count = (int)(to - from) + 1;
}

static int largest_reach(const weft_resample_plan *plan, int axis)
{
    int largest = 0;
    for (int i = 0; i < plan->count[axis]; i++) {
        int first, count;
        set_reach(plan, axis, i, &first, &count);
        largest = count > largest ? count : largest;
    }
    return largest;
}

// Values as they are copied and as a texture, pixels of channels that nobody asked for, and
// targets.
static double tile_bytes(const weft_resample_plan *plan)
{
    const struct weft_pass_plan_info *passes = plan->info.passes;
    const double values = (double)largest_reach(plan, 0) * largest_reach(plan, 1);
    const double pixels = (double)tile_size(plan, 0, 0) * tile_size(plan, 1, 0);
    return sizeof(float) * (2.0 * passes->channels * values + pixels) +
           (double)passes->target_bytes_per_pixel * pixels;
}

enum weft_result weft_resample_plan_tiles(weft_resample_plan *plan)
{
    for (int a = 0; a < 2; a++) {
        plan->side[a] = tile_side(&plan->info.map[a]);
        plan->count[a] = (pixels_along(plan, a) + plan->side[a] - 1) / plan->side[a];
    }
    plan->info.tiles = plan->count[0] * plan->count[1];
    const double bytes = tile_bytes(plan);
    if (bytes <= (double)plan->memory_bytes)
        return WEFT_OK;
    weft_error(plan->log,
               "resampling: a tile of %d x %d pixels takes %.0f bytes: the limit is %llu",
               tile_size(plan, 0, 0), tile_size(plan, 1, 0), bytes,
               (unsigned long long)plan->memory_bytes);
    return WEFT_ERR_LIMIT;
}

// ---- tiles --------------------------------------------------------------------------------------

// A tile of some channels of a source that are filtered together, or what a part of the pixels has
// of it.
struct tile {
    int x, y, width, height; // of the result
    int from[2], size[2];    // of the values that it reaches
    double *at[2];           // of its columns and rows, in those values
    int channels;            // of the passes; those past the source's repeat its first
    float *values[WEFT_RESAMPLE_MAX_CHANNELS];
    float *unused; // their pixels; NULL where there are none
};

struct runner {
    const weft_resample_plan *plan;
    const weft_resample_source *source;
    struct weft_rectangle part;
    const struct weft_log *log;
    int first, count; // of the source's channels
    struct weft_resample_steps steps;
    weft_multipass *compiled;
    float *const *to;
    struct weft_resample_work *work;
    int64_t stride;
};

static bool allocate_positions(struct tile *tile)
{
    for (int a = 0; a < 2; a++)
        tile->at[a] = malloc((size_t)(a ? tile->height : tile->width) * sizeof *tile->at[a]);
    return tile->at[0] && tile->at[1];
}

static bool allocate_values(const struct runner *r, struct tile *tile)
{
    const size_t values = (size_t)tile->size[0] * (size_t)tile->size[1];
    bool done = true;
    for (int c = 0; c < tile->channels; c++)
        done = (tile->values[c] = malloc(values * sizeof(float))) != NULL && done;
    if (r->count < tile->channels)
        done = (tile->unused = malloc((size_t)tile->height * (size_t)r->stride * sizeof(float))) !=
                   NULL &&
               done;
    return done;
}

// Positions are those in the whole tile, whose roundings they have: what is taken off where only a
// part of its values is reached is a whole number, and what is left is exact.
static void find_positions(const struct runner *r, int axis, struct tile *tile)
{
    const struct weft_kernel *kernel = &r->plan->info.kernel;
    const int first = axis ? tile->y : tile->x, count = axis ? tile->height : tile->width;
    const int64_t last = tile->size[axis] - 1;
    double *at = tile->at[axis], fraction;
    weft_window_map_positions(&r->plan->info.map[axis], first, count,
                              r->plan->info.overlap - tile->from[axis], at);
    int64_t low = weft_kernel_first_tap(kernel, at[0], &fraction);
    int64_t high = weft_kernel_first_tap(kernel, at[count - 1], &fraction) + kernel->width - 1;
    low = low < 0 ? 0 : low > last ? last : low;
    high = high > last ? last : high < 0 ? 0 : high;
    for (int i = 0; i < count; i++)
        at[i] -= (double)low;
    tile->from[axis] += (int)low;
    tile->size[axis] = (int)(high - low) + 1;
}

static void copy_values(const struct runner *r, struct tile *tile)
{
    const struct weft_rectangle window = weft_resample_values_window(r->source);
    const size_t row = (size_t)tile->size[0];
    for (int c = 0; c < tile->channels; c++) {
        const float *values =
            weft_resample_values(r->source, c < r->count ? r->first + c : r->first);
        for (int y = 0; y < tile->size[1]; y++)
            memcpy(tile->values[c] + (size_t)y * row,
                   values + (int64_t)(tile->from[1] + y - window.y) * window.width + tile->from[0] -
                       window.x,
                   row * sizeof(float));
    }
}

static bool fill_tile(const struct runner *r, struct tile *tile)
{
    bool done = allocate_positions(tile);
    for (int a = 0; done && a < 2; a++)
        find_positions(r, a, tile);
    done = done && allocate_values(r, tile);
    if (done)
        copy_values(r, tile);
    else
        weft_error(r->log, "out of memory: a tile of %d x %d pixels from %d x %d samples",
                   tile->width, tile->height, tile->size[0], tile->size[1]);
    return done;
}

static enum weft_result create_tile(const struct runner *r, int column, int row, struct tile *out)
{
    const weft_resample_plan *plan = r->plan;
    const struct weft_rectangle whole = {column * plan->side[0], row * plan->side[1],
                                         tile_size(plan, 0, column), tile_size(plan, 1, row)};
    const struct weft_rectangle own = weft_rectangle_common(&whole, &r->part);
    *out = (struct tile){.x = own.x,
                         .y = own.y,
                         .width = own.width,
                         .height = own.height,
                         .channels = plan->info.passes->channels};
    set_reach(plan, 0, column, &out->from[0], &out->size[0]);
    set_reach(plan, 1, row, &out->from[1], &out->size[1]);
    return fill_tile(r, out) ? WEFT_OK : WEFT_ERR_MEMORY;
}

static void destroy_tile(struct tile *tile)
{
    free(tile->at[0]);
    free(tile->at[1]);
    for (int c = 0; c < WEFT_RESAMPLE_MAX_CHANNELS; c++)
        free(tile->values[c]);
    free(tile->unused);
}

// ---- the engine ---------------------------------------------------------------------------------

struct request {
    struct weft_progress progress;
    struct weft_samples samples;
    struct weft_pixel_grid grid;
    struct weft_multipass_run_params params;
};

static void make_request(struct runner *r, struct tile *tile, struct request *q)
{
    const struct weft_resample_statistics *s = &r->source->info.statistics;
    *q = (struct request){
        .progress = {weft_resample_report_step, &r->steps},
        .samples = {.size = {tile->size[0], tile->size[1], 1}, .low = s->low, .high = s->high},
        .grid = {.width = tile->width,
                 .height = tile->height,
                 .columns = tile->at[0],
                 .rows = tile->at[1]},
        .params = {.samples = &q->samples,
                   .grid = &q->grid,
                   .stride = r->stride,
                   .progress = &q->progress,
                   .log = r->log},
    };
    for (int c = 0; c < tile->channels; c++) {
        q->samples.plane[c] = tile->values[c];
        q->params.pixels[c] =
            c < r->count
                ? r->to[r->first + c] + (tile->y - r->part.y) * r->stride + (tile->x - r->part.x)
                : tile->unused;
    }
}

static void add_work(struct weft_resample_work *sum, const struct weft_multipass_report *one)
{
    const struct weft_resample_work work = {
        .tiles = 1,
        .prepare_seconds = one->prepare_seconds,
        .upload_seconds = one->upload_seconds,
        .pass_seconds = one->pass_seconds,
        .readback_seconds = one->readback_seconds,
        .source_bytes = one->source_bytes,
        .tile_bytes = one->tile_bytes,
        .target_bytes = one->target_bytes,
        .position_bytes = one->position_bytes,
        .uploaded_bytes = one->uploaded_bytes,
        .clamps = one->clamps,
        .largest_clamp = one->largest_clamp,
    };
    weft_resample_work_add(sum, &work);
}

static enum weft_result run_tile(struct runner *r, struct tile *tile)
{
    struct request q;
    struct weft_multipass_report report = {0};
    make_request(r, tile, &q);
    const enum weft_result res = weft_multipass_run(r->compiled, &q.params, &report);
    if (res == WEFT_OK)
        add_work(r->work, &report);
    return res;
}

static enum weft_result visit_tile(struct runner *r, int column, int row)
{
    struct tile tile;
    enum weft_result res = create_tile(r, column, row, &tile);
    if (res == WEFT_OK)
        res = run_tile(r, &tile);
    destroy_tile(&tile);
    r->steps.step++;
    return res;
}

// Of one set of channels after the other.
static enum weft_result visit_tiles(struct runner *r, const struct weft_progress *progress)
{
    const int *side = r->plan->side, from[2] = {r->part.x / side[0], r->part.y / side[1]};
    const int columns = (r->part.x + r->part.width - 1) / side[0] - from[0] + 1;
    const int tiles = ((r->part.y + r->part.height - 1) / side[1] - from[1] + 1) * columns;
    const int together = r->plan->info.passes->channels, channels = r->source->info.channels;
    r->steps = (struct weft_resample_steps){
        .outer = progress, .steps = (double)tiles * ((channels + together - 1) / together)};
    for (r->first = 0; r->first < channels; r->first += together) {
        r->count = channels - r->first < together ? channels - r->first : together;
        for (int i = 0; i < tiles; i++) {
            if (!weft_resample_report_step(&r->steps, 0.0)) {
                weft_note(r->log, "resampling was cancelled at tile %d of %d", i, tiles);
                return WEFT_ERR_CANCELLED;
            }
            const enum weft_result res =
                visit_tile(r, from[0] + i % columns, from[1] + i / columns);
            if (res != WEFT_OK)
                return res;
        }
    }
    return WEFT_OK;
}

enum weft_result weft_resample_run_passes(weft_resample_compiled *compiled,
                                          const struct weft_resample_run_params *params,
                                          struct weft_resample_work *work)
{
    struct runner r = {
        .plan = compiled->plan,
        .source = params->source,
        .part = params->part,
        .log = params->log,
        .compiled = compiled->passes,
        .to = params->plane,
        .stride = params->stride,
        .work = work,
    };
    return visit_tiles(&r, params->progress);
}
