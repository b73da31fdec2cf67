// SPDX-License-Identifier: BSD-3-Clause
// Slices whose rows and columns run along the volume's axes: the voxels in reach become a plane,
// summed along the third axis, which passes/separable/separable.h magnifies.
#include <stdlib.h>
#include <string.h>

#include "passes/separable/separable.h"
#include "passes/fused/exact.h"
#include "passes/fused/resident_impl.h"
#include "passes/slice/plane.h"
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

static enum weft_result plan_tile(const struct weft_slice_plan *plan,
                                  const struct weft_slice_tile *tile,
                                  const struct weft_slice_plane *plane, enum weft_axis_order order,
                                  weft_separable_plan **out)
{
    return weft_separable_plan_create(
        weft_separable_params(.kernel = plan->info.kernel, .size = {plane->size[0], plane->size[1]},
                              .width = tile->width, .height = tile->height, .x = plane->x,
                              .y = plane->y, .order = order, .engine = plan->info.engine,
                              .sums = plan->info.sums, .memory_bytes = plan->separable_bytes,
                              .log = plan->resident ? plan->resident->log : plan->log),
        out);
}

static bool is_whole(const struct weft_slice_plan *plan, const struct weft_slice_tile *tile)
{
    const struct weft_slice_geometry *g = &plan->footprint->grid.index;
    return tile->width == g->width && tile->height == g->height;
}

// The order that the whole slice has, for its tiles; auto where a tile is all of it.
static enum weft_result find_order(const struct weft_slice_plan *plan, enum weft_axis_order *out)
{
    const struct weft_slice_geometry *g = &plan->footprint->grid.index;
    const struct weft_slice_tile whole = {.width = g->width, .height = g->height};
    struct weft_slice_plane plane;
    weft_separable_plan *own = NULL;
    *out = WEFT_AXIS_ORDER_AUTO;
    if (is_whole(plan, &plan->tiles[0]))
        return WEFT_OK;
    enum weft_result res = weft_slice_plane_place(plan, &whole, &plane);
    if (res == WEFT_OK)
        res = plan_tile(plan, &whole, &plane, WEFT_AXIS_ORDER_AUTO, &own);
    if (res == WEFT_OK)
        *out = weft_separable_plan_get_info(own)->first_axis == 0 ? WEFT_AXIS_ORDER_X_FIRST
                                                                  : WEFT_AXIS_ORDER_Y_FIRST;
    weft_separable_plan_destroy(&own);
    weft_slice_plane_destroy(&plane);
    return res;
}

static enum weft_result filter_create(const struct weft_separable_compile_params *where,
                                      const struct weft_slice_plan *plan,
                                      const struct weft_slice_tile *tile,
                                      const struct weft_slice_plane *plane,
                                      enum weft_axis_order order, struct filter *out)
{
    *out = (struct filter){.plan = NULL};
    enum weft_result res = plan_tile(plan, tile, plane, order, &out->plan);
    if (res == WEFT_OK)
        res = weft_separable_compile(out->plan, where, &out->compiled);
    if (res != WEFT_OK)
        filter_destroy(out);
    return res;
}

// A tile's samples and what filters them.
struct stage {
    struct weft_slice_plane plane;
    struct filter filter;
};

// Every tile has a stage of its own. All are kept where the plan's memory holds them beside the
// bricks of any tile; else they are made as they are needed.
struct weft_slice_separable {
    const struct weft_slice_plan *plan;
    struct weft_separable_compile_params where;
    enum weft_axis_order order; // of all tiles; auto: there is one, of all pixels
    int threads;                // that sum voxels: the CPU engine's, or as many as there are
    float *scratch;             // of all pixels, where some are painted on their way to a texture
    struct stage *stages;       // by tile; NULL: not kept
    uint64_t kept_bytes;        // of all stages, or 0
};

static void stage_destroy(struct stage *stage)
{
    filter_destroy(&stage->filter);
    weft_slice_plane_destroy(&stage->plane);
}

// A stage that a resident volume keeps from one slice to the next: planes that lie behind each
// other are filtered alike.
struct kept_stage {
    struct stage stage;
    struct weft_kernel kernel;
    struct weft_separable_compile_params where;
    enum weft_sums sums;
    uint64_t memory_bytes;
    int width, height;
    enum weft_axis_order order;
};

static void free_kept_stage(void *priv)
{
    struct kept_stage *kept = priv;
    stage_destroy(&kept->stage);
    free(kept);
}

static bool filters_alike(const struct kept_stage *kept, const weft_slice_separable *s,
                          const struct weft_slice_tile *tile, const struct weft_slice_plane *plane)
{
    const struct weft_separable_compile_params *where = &s->where;
    const struct weft_slice_plan *plan = s->plan;
    const struct weft_slice_plane *old = &kept->stage.plane;
    return weft_kernel_same(&kept->kernel, &plan->info.kernel) &&
           kept->where.context == where->context && kept->sums == plan->info.sums &&
           memcmp(&kept->where.cpu, &where->cpu, sizeof where->cpu) == 0 &&
           kept->memory_bytes == plan->separable_bytes && kept->width == tile->width &&
           kept->height == tile->height && kept->order == s->order &&
           memcmp(old->size, plane->size, sizeof plane->size) == 0 &&
           memcmp(old->x, plane->x, (size_t)tile->width * sizeof *plane->x) == 0 &&
           memcmp(old->y, plane->y, (size_t)tile->height * sizeof *plane->y) == 0;
}

// The filter that the slice before left, if it is the one wanted.
static bool take_filter(const weft_slice_separable *s, const struct weft_slice_tile *tile,
                        struct stage *stage)
{
    const struct weft_slice_plan *plan = s->plan;
    struct kept_stage *kept =
        plan->resident ? weft_resident_take(plan->resident, free_kept_stage) : NULL;
    const bool found = kept && filters_alike(kept, s, tile, &stage->plane);
    if (found) {
        stage->filter = kept->stage.filter;
        kept->stage.filter = (struct filter){.plan = NULL};
    }
    if (kept)
        free_kept_stage(kept);
    return found;
}

// Leaves a slice's only stage to the next one. Without memory it is destroyed.
static void leave_stage(const weft_slice_separable *s)
{
    const struct weft_slice_plan *plan = s->plan;
    const bool wanted =
        plan->resident && plan->info.tile_count == 1 && s->stages[0].filter.compiled;
    struct kept_stage *kept = wanted ? malloc(sizeof *kept) : NULL;
    if (!kept)
        return;
    *kept = (struct kept_stage){.stage = s->stages[0],
                                .kernel = plan->info.kernel,
                                .where = s->where,
                                .sums = plan->info.sums,
                                .memory_bytes = plan->separable_bytes,
                                .width = plan->tiles[0].width,
                                .height = plan->tiles[0].height,
                                .order = s->order};
    s->stages[0] = (struct stage){.filter = {.plan = NULL}};
    weft_resident_keep(plan->resident, kept, free_kept_stage);
}

static enum weft_result stage_create(const weft_slice_separable *s,
                                     const struct weft_slice_tile *tile, struct stage *stage)
{
    *stage = (struct stage){.filter = {.plan = NULL}};
    const enum weft_result res = weft_slice_plane_create(s->plan, tile, &stage->plane);
    if (res != WEFT_OK || take_filter(s, tile, stage))
        return res;
    return filter_create(&s->where, s->plan, tile, &stage->plane, s->order, &stage->filter);
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
        res = stage_create(s, &plan->tiles[i], &s->stages[i]);
    return res;
}

enum weft_result weft_slice_separable_compile(weft_context *context, const struct weft_cpu *cpu,
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
    s->where = (struct weft_separable_compile_params){.context = context, .cpu = *cpu};
    s->threads = cpu->threads;
    s->kept_bytes = bytes_to_keep(plan);
    res = find_order(plan, &s->order);
    if (res == WEFT_OK && s->kept_bytes)
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
    if ((*separable)->stages)
        leave_stage(*separable);
    for (int i = 0; (*separable)->stages && i < (*separable)->plan->info.tile_count; i++)
        stage_destroy(&(*separable)->stages[i]);
    free((*separable)->stages);
    free((*separable)->scratch);
    free(*separable);
    *separable = NULL;
}

// Pixels of a tile that are painted over go through memory: room for them, where the caller has
// none.
static enum weft_result make_scratch(weft_slice_separable *s, struct weft_slice_run_params *p)
{
    const struct weft_rectangle *part = &s->plan->info.part;
    if (!s->scratch)
        s->scratch = malloc((size_t)part->width * (size_t)part->height * sizeof *s->scratch);
    p->pixels = s->scratch;
    p->stride = part->width;
    if (s->scratch)
        return WEFT_OK;
    weft_error(s->plan->log, "not enough memory for %d x %d pixels", part->width, part->height);
    return WEFT_ERR_MEMORY;
}

// What a tile's samples are laid out in and filtered by is there, and bytes of others beside.
static enum weft_result filter_tile(weft_slice_separable *s, const struct weft_slice_tile *tile,
                                    const weft_brick_store *store, struct stage *stage,
                                    uint64_t beside, const struct weft_slice_run_params *params,
                                    struct weft_slice_report *report,
                                    struct weft_statistics *pixels)
{
    const struct weft_slice_plan *plan = s->plan;
    struct weft_slice_plane *plane = &stage->plane;
    const struct filter *filter = &stage->filter;
    struct weft_separable_report own;
    const double start = weft_now_seconds();
    const bool fit = weft_slice_plane_fill(plan, store, s->threads, plane);
    report->layout_seconds += weft_now_seconds() - start;
    struct weft_slice_run_params p = *params;
    struct weft_texture texture = p.texture ? *p.texture : (struct weft_texture){0};
    texture.x += tile->x - plan->info.part.x;
    texture.y += tile->y - plan->info.part.y;
    enum weft_result res = !fit && !p.pixels ? make_scratch(s, &p) : WEFT_OK;
    float *at = p.pixels ? weft_slice_pixel(plan, p.pixels, p.stride, tile->x, tile->y) : NULL;
    if (res == WEFT_OK)
        res = weft_separable_run(
            filter->compiled,
            weft_separable_run_params(.samples = plane->samples, .wide = plane->wide, .pixels = at,
                                      .stride = at ? p.stride : 0,
                                      .texture = p.texture && fit ? &texture : NULL,
                                      .progress = p.progress, .log = plan->log),
            &own);
    if (res == WEFT_OK && !fit)
        res =
            weft_slice_exact_paint(plan, (int)(tile - plan->tiles), beside,
                                   &(struct weft_slice_pixels){.at = p.pixels, .stride = p.stride},
                                   p.progress, 1.0, &report->exact_pixels);
    if (res == WEFT_OK && !fit && p.texture)
        res = weft_texture_write(s->where.context, &texture, tile->width, tile->height, 1,
                                 (const float *const[]){at}, p.stride);
    if (res != WEFT_OK)
        return res;
    add_report(&own, report);
    weft_statistics_join(pixels, &own.pixels);
    report->fetches += (uint64_t)(weft_separable_plan_get_info(filter->plan)->fetches_per_pixel *
                                  tile->width * tile->height);
    const uint64_t bytes = plan->footprint->info.kept_bytes + beside +
                           weft_slice_plane_bytes(plan, plane->size) + own.peak_bytes;
    report->peak_bytes = bytes > report->peak_bytes ? bytes : report->peak_bytes;
    return WEFT_OK;
}

static enum weft_result run_tile(weft_slice_separable *s, int index,
                                 const struct weft_slice_run_params *params,
                                 struct weft_slice_report *report, struct weft_statistics *pixels)
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
        res = stage_create(s, tile, &own);
    report->layout_seconds += weft_now_seconds() - read;
    if (res == WEFT_OK)
        res = filter_tile(s, tile, store, stage, beside, params, report, pixels);
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
                                          struct weft_slice_report *report,
                                          struct weft_statistics *pixels)
{
    struct part part = {params->progress, 0, s->plan->info.tile_count};
    const struct weft_progress progress = {report_part, &part};
    const struct weft_slice_run_params own = {.pixels = params->pixels,
                                              .stride = params->stride,
                                              .texture = params->texture,
                                              .progress = &progress};
    struct weft_statistics all = WEFT_STATISTICS_NONE;
    enum weft_result res = WEFT_OK;
    for (; res == WEFT_OK && part.done < part.count; part.done++) {
        res = report_part(&part, 0.0) ? WEFT_OK : WEFT_ERR_CANCELLED;
        if (res == WEFT_OK)
            res = run_tile(s, part.done, &own, report, &all);
    }
    if (report->exact_pixels == 0)
        weft_statistics_join(pixels, &all);
    if (res == WEFT_ERR_CANCELLED)
        weft_note(s->plan->log, "the slice was cancelled at tile %d of %d", part.done, part.count);
    return res;
}
