// SPDX-License-Identifier: BSD-3-Clause
// Slices whose rows and columns run along the volume's axes: the voxels in reach become a plane,
// summed along the third axis, which passes/separable/separable.h magnifies.
#include <stdlib.h>

#include "passes/separable/separable.h"
#include "passes/fused/exact.h"
#include "passes/slice/slice_impl.h"

struct weft_separable_work weft_slice_separable_work(const struct weft_slice_plan *request)
{
    const struct weft_slice_grid *grid = &request->footprint->grid;
    const struct weft_rectangle whole = {.width = grid->index.width, .height = grid->index.height};
    const int *order = request->axes.order;
    int32_t min[3], max[3];
    weft_slice_axes_box(&request->axes, &request->info.kernel, grid, &whole, min, max);
    struct weft_separable_work work = weft_separable_work_of(
        request->info.kernel.width, (double)max[order[0]] - min[order[0]] + 1.0,
        (double)max[order[1]] - min[order[1]] + 1.0, whole.width, whole.height);
    work.summed *= request->axes.kept;
    return work;
}

// ---- one tile -----------------------------------------------------------------------------------

// What a tile is made from.
struct plane {
    int32_t min[3], max[3];
    int size[2];
    float *samples, *strip; // [y][x]; and the voxels of eight of its rows
    double *x, *y;
};

static void plane_destroy(struct plane *p)
{
    free(p->samples);
    free(p->strip);
    free(p->x);
    free(p->y);
    *p = (struct plane){0};
}

static enum weft_result plane_create(const struct weft_slice_plan *plan,
                                     const struct weft_slice_tile *tile, struct plane *p)
{
    const struct weft_slice_axes *axes = &plan->axes;
    *p = (struct plane){0};
    const struct weft_rectangle at = {tile->x, tile->y, tile->width, tile->height};
    weft_slice_axes_box(axes, &plan->info.kernel, &plan->footprint->grid, &at, p->min, p->max);
    for (int i = 0; i < 2; i++)
        p->size[i] = p->max[axes->order[i]] - p->min[axes->order[i]] + 1;
    const size_t row = (size_t)p->size[0];
    p->samples = malloc(row * (size_t)p->size[1] * sizeof *p->samples);
    p->strip = malloc(row * WEFT_BRICK_SIZE * (size_t)axes->kept * sizeof *p->strip);
    p->x = malloc((size_t)tile->width * sizeof *p->x);
    p->y = malloc((size_t)tile->height * sizeof *p->y);
    if (!p->samples || !p->strip || !p->x || !p->y) {
        weft_error(plan->log, "not enough memory for a plane of %d x %d samples", p->size[0],
                   p->size[1]);
        plane_destroy(p);
        return WEFT_ERR_MEMORY;
    }
    for (int i = 0; i < tile->width; i++)
        p->x[i] = weft_slice_axes_coordinate(axes, &plan->footprint->grid, 0, tile->x + i) -
                  p->min[axes->order[0]];
    for (int i = 0; i < tile->height; i++)
        p->y[i] = weft_slice_axes_coordinate(axes, &plan->footprint->grid, 1, tile->y + i) -
                  p->min[axes->order[1]];
    return WEFT_OK;
}

// Sums the planes in reach, the rows of a brick at a time. false: some voxels were unfit.
static bool plane_fill(const struct weft_slice_plan *plan, const weft_brick_store *store,
                       struct plane *p)
{
    bool fit = true;
    const struct weft_slice_axes *axes = &plan->axes;
    const int column = axes->order[1];
    for (int y = 0; y < p->size[1];) {
        int32_t min[3];
        int size[3];
        for (int a = 0; a < 3; a++) {
            min[a] = p->min[a];
            size[a] = p->max[a] - p->min[a] + 1;
        }
        min[column] += y;
        const int in_brick = WEFT_BRICK_SIZE - (min[column] & (WEFT_BRICK_SIZE - 1));
        size[column] = p->size[1] - y < in_brick ? p->size[1] - y : in_brick;
        weft_brick_store_copy_box(store, min, size, size, p->strip);
        fit &= !weft_slice_replace_unfit(plan, p->strip,
                                         (size_t)size[0] * (size_t)size[1] * (size_t)size[2]);
        weft_slice_sum_planes(axes, p->strip, size, size,
                              p->samples + (size_t)y * (size_t)p->size[0], p->size[0]);
        y += size[column];
    }
    return fit;
}

static void add_report(const struct weft_separable_report *one, struct weft_slice_report *sum)
{
    sum->layout_seconds += one->prepare_seconds;
    sum->upload_seconds += one->upload_seconds;
    sum->pass_seconds += one->pass_seconds;
    sum->readback_seconds += one->readback_seconds;
    sum->uploaded_bytes += one->uploaded_bytes;
    sum->passes += one->passes;
}

// A tile's plane, planned and compiled.
struct filter {
    weft_separable_plan *plan;
    weft_separable *compiled;
};

static void filter_destroy(struct filter *f)
{
    weft_separable_destroy(&f->compiled);
    weft_separable_plan_destroy(&f->plan);
}

static enum weft_result filter_create(weft_context *context, const struct weft_slice_plan *plan,
                                      const struct weft_slice_tile *tile, const struct plane *plane,
                                      struct filter *out)
{
    *out = (struct filter){.plan = NULL};
    enum weft_result res = weft_separable_plan_create(
        weft_separable_params(.kernel = plan->info.kernel, .size = {plane->size[0], plane->size[1]},
                              .width = tile->width, .height = tile->height, .x = plane->x,
                              .y = plane->y, .memory_bytes = plan->separable_bytes,
                              .log = plan->log),
        &out->plan);
    if (res == WEFT_OK)
        res = weft_separable_compile(out->plan, weft_separable_compile_params(.context = context),
                                     &out->compiled);
    if (res != WEFT_OK)
        filter_destroy(out);
    return res;
}

// A tile's samples and what filters them.
struct stage {
    struct plane plane;
    struct filter filter;
};

// Every tile has a stage of its own. All are kept where the plan's memory holds them beside the
// bricks of any tile; else they are made as they are needed.
struct weft_slice_separable {
    const struct weft_slice_plan *plan;
    weft_context *context;
    struct stage *stages; // by tile; NULL: not kept
    uint64_t kept_bytes;  // of all stages, or 0
};

static void stage_destroy(struct stage *stage)
{
    filter_destroy(&stage->filter);
    plane_destroy(&stage->plane);
}

static enum weft_result stage_create(weft_context *context, const struct weft_slice_plan *plan,
                                     const struct weft_slice_tile *tile, struct stage *stage)
{
    *stage = (struct stage){.filter = {.plan = NULL}};
    const enum weft_result res = plane_create(plan, tile, &stage->plane);
    return res == WEFT_OK ? filter_create(context, plan, tile, &stage->plane, &stage->filter) : res;
}

static uint64_t brick_bytes(const struct weft_slice_plan *plan, int tile)
{
    return plan->tile_plans[tile].bricks.count * WEFT_BRICK_VOXELS * sizeof(float);
}

// The bytes of all stages; 0 where they are too many together.
static uint64_t bytes_to_keep(const struct weft_slice_plan *plan)
{
    uint64_t stages = 0, bricks = 0;
    for (int i = 0; i < plan->info.tile_count; i++) {
        const uint64_t own = brick_bytes(plan, i);
        stages += plan->tiles[i].memory_bytes - own;
        bricks = own > bricks ? own : bricks;
    }
    return plan->info.tile_count == 1 || stages + bricks <= 2 * plan->separable_bytes ? stages : 0;
}

static enum weft_result keep_stages(weft_slice_separable *s)
{
    const struct weft_slice_plan *plan = s->plan;
    enum weft_result res = WEFT_OK;
    s->stages = calloc((size_t)plan->info.tile_count, sizeof *s->stages);
    if (!s->stages) {
        weft_error(plan->log, "not enough memory to compile the slice");
        return WEFT_ERR_MEMORY;
    }
    for (int i = 0; res == WEFT_OK && i < plan->info.tile_count; i++)
        res = stage_create(s->context, plan, &plan->tiles[i], &s->stages[i]);
    return res;
}

enum weft_result weft_slice_separable_compile(weft_context *context,
                                              const struct weft_slice_plan *plan,
                                              weft_slice_separable **out)
{
    *out = NULL;
    enum weft_result res = WEFT_OK;
    weft_slice_separable *s = calloc(1, sizeof *s);
    if (!s) {
        weft_error(plan->log, "not enough memory to compile the slice");
        return WEFT_ERR_MEMORY;
    }
    s->plan = plan;
    s->context = context;
    s->kept_bytes = bytes_to_keep(plan);
    if (s->kept_bytes)
        res = keep_stages(s);
    if (res == WEFT_OK)
        *out = s;
    else
        weft_slice_separable_destroy(&s);
    return res;
}

void weft_slice_separable_destroy(weft_slice_separable **separable)
{
    if (!separable || !*separable)
        return;
    for (int i = 0; (*separable)->stages && i < (*separable)->plan->info.tile_count; i++)
        stage_destroy(&(*separable)->stages[i]);
    free((*separable)->stages);
    free(*separable);
    *separable = NULL;
}

// What a tile's samples are laid out in and filtered by is there, and bytes of others beside.
static enum weft_result filter_tile(const struct weft_slice_plan *plan,
                                    const struct weft_slice_tile *tile,
                                    const weft_brick_store *store, struct stage *stage,
                                    uint64_t beside, const struct weft_slice_run_params *params,
                                    struct weft_slice_report *report)
{
    struct plane *plane = &stage->plane;
    const struct filter *filter = &stage->filter;
    struct weft_separable_report own;
    const double start = weft_now_seconds();
    const bool fit = plane_fill(plan, store, plane);
    report->layout_seconds += weft_now_seconds() - start;
    enum weft_result res = weft_separable_run(
        filter->compiled,
        weft_separable_run_params(.samples = plane->samples,
                                  .pixels = params->pixels + tile->y * params->stride + tile->x,
                                  .stride = params->stride, .progress = params->progress,
                                  .log = plan->log),
        &own);
    if (res == WEFT_OK && !fit)
        res = weft_slice_exact_paint(plan, tile, store, params->pixels, params->stride,
                                     params->progress, 1.0, &report->exact_pixels);
    if (res != WEFT_OK)
        return res;
    add_report(&own, report);
    report->fetches += (uint64_t)(weft_separable_plan_get_info(filter->plan)->fetches_per_pixel *
                                  tile->width * tile->height);
    const uint64_t bytes = plan->footprint->info.kept_bytes + beside +
                           4 * (uint64_t)plane->size[0] * (uint64_t)plane->size[1] + own.peak_bytes;
    report->peak_bytes = bytes > report->peak_bytes ? bytes : report->peak_bytes;
    return WEFT_OK;
}

static enum weft_result run_tile(weft_slice_separable *s, int index,
                                 const struct weft_slice_run_params *params,
                                 struct weft_slice_report *report)
{
    const struct weft_slice_plan *plan = s->plan;
    const struct weft_slice_tile *tile = &plan->tiles[index];
    const uint64_t stage_bytes = tile->memory_bytes - brick_bytes(plan, index);
    const uint64_t beside = s->stages ? s->kept_bytes - stage_bytes : 0; // of the other stages
    const weft_brick_store *store;
    struct stage own = {.filter = {.plan = NULL}};
    struct stage *stage = s->stages ? &s->stages[index] : &own;
    const double start = weft_now_seconds();
    enum weft_result res = weft_footprint_load(plan->footprint, &plan->tile_plans[index].bricks,
                                               stage_bytes + beside, &store);
    const double read = weft_now_seconds();
    report->read_seconds += read - start;
    if (res == WEFT_OK && !s->stages)
        res = stage_create(s->context, plan, tile, &own);
    report->layout_seconds += weft_now_seconds() - read;
    if (res == WEFT_OK)
        res = filter_tile(plan, tile, store, stage, beside, params, report);
    stage_destroy(&own);
    return res;
}

// ---- all of them --------------------------------------------------------------------------------

// Progress of a tile as part of the whole.
struct part {
    const struct weft_progress *progress;
    int done, count;
};

static bool report_part(void *priv, double fraction)
{
    const struct part *p = priv;
    return !p->progress || !p->progress->report ||
           p->progress->report(p->progress->priv, (p->done + fraction) / p->count);
}

enum weft_result weft_slice_separable_run(weft_slice_separable *s,
                                          const struct weft_slice_run_params *params,
                                          struct weft_slice_report *report)
{
    struct part part = {params->progress, 0, s->plan->info.tile_count};
    const struct weft_progress progress = {report_part, &part};
    const struct weft_slice_run_params own = {
        .pixels = params->pixels, .stride = params->stride, .progress = &progress};
    enum weft_result res = WEFT_OK;
    for (; res == WEFT_OK && part.done < part.count; part.done++) {
        res = report_part(&part, 0.0) ? WEFT_OK : WEFT_ERR_CANCELLED;
        if (res == WEFT_OK)
            res = run_tile(s, part.done, &own, report);
    }
    if (res == WEFT_ERR_CANCELLED)
        weft_note(s->plan->log, "the slice was cancelled at tile %d of %d", part.done, part.count);
    return res;
}
