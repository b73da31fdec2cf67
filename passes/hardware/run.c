// SPDX-License-Identifier: BSD-3-Clause
#include "passes/hardware/run.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "passes/fused/exact.h"
#include "passes/gl/context_backend.h"
#include "passes/gl/kernel_weights.h"
#include "passes/gl/program.h"
#include "passes/gl/target.h"
#include "passes/gl/textures/delivery.h"
#include "passes/gl/volume_texture.h"
#include "passes/hardware/blocks.h"
#include "passes/positions/grid_uniforms.h"

enum { NO_TILE = -1 };

struct weft_hardware {
    const struct weft_hardware_plan *plan;
    weft_context *context;
    const GladGLContext *gl;
    const struct weft_log *log;
    uint64_t own_bytes; // beside voxels
    int loaded;         // the tile whose voxels and table GL has
    struct weft_hardware_blocks blocks;
    struct weft_gl_volume source;
    struct weft_gl_buffer entries, kernel;
    struct weft_gl_target target;
    GLuint program; // the context's, held
    // Of a run.
    const struct weft_progress *progress;
    struct weft_fused_report report;
    const weft_brick_store *store; // of the tile, the footprint's
};

static bool go_on(const struct weft_hardware *r, double fraction)
{
    return !r->progress || !r->progress->report || r->progress->report(r->progress->priv, fraction);
}

// ---- compiling ----------------------------------------------------------------------------------

static enum weft_result check_sampler(const struct weft_hardware *r)
{
    const struct weft_hardware_plan_info *info = &r->plan->info;
    struct weft_sampler own;
    const enum weft_result res =
        weft_sampler_measure(r->context, r->plan->slice->info.source, &own);
    if (res != WEFT_OK)
        return res;
    const struct weft_sampler *planned = &info->sampler;
    const bool holds = own.fraction <= planned->fraction && own.rounding <= planned->rounding;
    for (int a = 0; a < 3; a++) {
        if (holds && info->texture_size[a] <= own.max_size)
            continue;
        weft_error(r->log,
                   "the context's sampler of %s textures is off by %.3g and %.3g, up to %d texels; "
                   "the plan has %.3g, %.3g and %d: plan with what weft_sampler_measure gives",
                   weft_source_format_name(r->plan->slice->info.source), own.fraction, own.rounding,
                   own.max_size, planned->fraction, planned->rounding, info->texture_size[a]);
        return WEFT_ERR_LIMIT;
    }
    return WEFT_OK;
}

static void print_taps(const struct weft_hardware_plan *plan, char *first, char *second,
                       size_t size)
{
    const struct weft_hardware_pairs *pairs = &plan->pairs;
    size_t used = 0, also = 0;
    for (int i = 0; i < pairs->fetches; i++) {
        const char *comma = i ? "," : "";
        used += (size_t)snprintf(first + used, size - used, "%s%d", comma, pairs->tap[i]);
        also +=
            (size_t)snprintf(second + also, size - also, "%s%d", comma,
                             pairs->paired[i] ? pairs->tap[i] + 1 : plan->slice->info.kernel.width);
    }
}

static enum weft_result find_program(struct weft_hardware *r)
{
    const struct weft_slice_plan *slice = r->plan->slice;
    const struct weft_polynomial_tiles *tiles = &slice->weights[0]->tiles;
    char first[64], second[64], defines[512];
    print_taps(r->plan, first, second, sizeof first);
    snprintf(defines, sizeof defines,
             "#define WIDTH %d\n#define GROUPS %d\n#define DEGREE %d\n#define SEGMENTS %d\n"
             "#define FETCHES %d\n#define FIRST_TAPS %s\n#define SECOND_TAPS %s\n#define SIDE %d\n"
             "#define MAPPED %d\n#define UNIT_SUM %d\n",
             tiles->width, tiles->groups, tiles->degree, tiles->segments, r->plan->pairs.fetches,
             first, second, r->plan->atlas.side, slice->info.source != WEFT_SOURCE_FLOAT,
             slice->info.kernel.unit_sum);
    const enum weft_result res = weft_program_get(
        r->context, "hardware", defines, weft_shader_rectangles, weft_shader_hardware, &r->program);
    if (res == WEFT_OK)
        weft_program_hold(r->context, r->program);
    return res;
}

static enum weft_result create_objects(struct weft_hardware *r)
{
    const struct weft_hardware_plan *plan = r->plan;
    const struct weft_slice_plan *slice = plan->slice;
    size_t entries = 0;
    int width = 0, height = 0;
    for (int i = 0; i < plan->info.tile_count; i++) {
        const struct weft_rectangle *at = &plan->tiles[i].at;
        const size_t pixels = (size_t)at->width * (size_t)at->height;
        entries = pixels > entries ? pixels : entries;
        width = at->width > width ? at->width : width;
        height = at->height > height ? at->height : height;
    }
    enum weft_result res = weft_hardware_blocks_create(plan, &r->blocks);
    if (res == WEFT_OK)
        res =
            weft_gl_volume_create(r->log, r->gl, slice->info.source, plan->atlas.size, &r->source);
    if (res == WEFT_OK)
        res = weft_gl_buffer_create(r->log, r->gl, GL_R32I, entries, &r->entries);
    if (res == WEFT_OK)
        res = weft_gl_kernel_create(r->log, r->gl, &slice->weights[0]->tiles, &r->kernel);
    if (res == WEFT_OK)
        res = weft_gl_target_create(r->log, r->gl, GL_R32F, width, height, &r->target);
    r->own_bytes = weft_hardware_atlas_bytes(&plan->atlas, slice->info.source) +
                   r->blocks.plane_bytes + entries * sizeof(int32_t) +
                   (size_t)width * (size_t)height * sizeof(float);
    return res;
}

enum weft_result weft_hardware_compile(weft_context *context, const weft_hardware_plan *plan,
                                       weft_hardware **out)
{
    *out = NULL;
    weft_hardware *r = calloc(1, sizeof *r);
    if (!r) {
        weft_error(plan->log, "not enough memory to compile hardware filtering");
        return WEFT_ERR_MEMORY;
    }
    *r = (weft_hardware){
        .plan = plan, .context = context, .gl = &context->gl, .log = plan->log, .loaded = NO_TILE};
    enum weft_result res = check_sampler(r);
    if (res == WEFT_OK)
        res = weft_context_enter(context);
    if (res != WEFT_OK) {
        free(r);
        return res;
    }
    res = create_objects(r);
    if (res == WEFT_OK)
        res = find_program(r);
    weft_context_leave(context);
    if (res == WEFT_OK)
        *out = r;
    else
        weft_hardware_destroy(&r);
    return res;
}

void weft_hardware_destroy(weft_hardware **hardware)
{
    weft_hardware *r = hardware ? *hardware : NULL;
    if (!r)
        return;
    if (weft_context_enter(r->context) == WEFT_OK) {
        weft_gl_volume_destroy(r->gl, &r->source);
        weft_gl_buffer_destroy(r->gl, &r->entries);
        weft_gl_buffer_destroy(r->gl, &r->kernel);
        weft_gl_target_destroy(r->gl, &r->target);
        weft_context_leave(r->context);
    }
    weft_program_release(r->context, r->program);
    weft_hardware_blocks_destroy(&r->blocks);
    free(r);
    *hardware = NULL;
}

// ---- one tile's data ----------------------------------------------------------------------------

static enum weft_result load_blocks(struct weft_hardware *r, const struct weft_hardware_tile *tile)
{
    const int side = r->plan->atlas.side;
    enum weft_result res = WEFT_OK;
    size_t cell = 0;
    weft_hardware_blocks_begin(&r->blocks);
    for (int z = 0; res == WEFT_OK && cell < tile->cells->map.count; z += side) {
        const double start = weft_now_seconds();
        weft_hardware_blocks_fill(&r->blocks, tile, r->store, &cell);
        const double filled = weft_now_seconds();
        res = weft_gl_volume_load(r->log, r->gl, &r->source, z, side, r->blocks.plane);
        r->report.layout_seconds += filled - start;
        r->report.upload_seconds += weft_now_seconds() - filled;
        r->report.uploaded_bytes += r->blocks.plane_bytes;
    }
    return res;
}

struct entry_writer {
    const struct weft_hardware_tile *tile;
    const int32_t *by_cell;
    int32_t *out;
};

static bool write_entries(void *priv, const struct weft_span *run)
{
    const struct entry_writer *w = priv;
    const int32_t entry = w->by_cell[weft_cell_map_find(&w->tile->cells->map, run->cell)];
    int32_t *out = w->out + (size_t)(run->y - w->tile->at.y) * (size_t)w->tile->at.width +
                   (run->x - w->tile->at.x);
    for (int i = 0; i < run->count; i++)
        out[i] = entry;
    return true;
}

static enum weft_result load_entries(struct weft_hardware *r, const struct weft_hardware_tile *tile)
{
    const struct weft_rectangle *at = &tile->at;
    const size_t bytes = (size_t)at->width * (size_t)at->height * sizeof(int32_t);
    const double start = weft_now_seconds();
    struct entry_writer writer = {tile, r->blocks.entries,
                                  weft_gl_buffer_map(r->gl, &r->entries, bytes)};
    const double mapped = weft_now_seconds();
    if (writer.out)
        weft_slice_grid_walk(&r->plan->slice->footprint->grid, at->x, at->y, at->width, at->height,
                             write_entries, &writer);
    const double written = weft_now_seconds();
    const bool kept = writer.out && weft_gl_buffer_unmap(r->gl, &r->entries);
    r->report.layout_seconds += written - mapped;
    r->report.upload_seconds += weft_now_seconds() - written + (mapped - start);
    r->report.uploaded_bytes += bytes;
    const enum weft_result res = weft_gl_check(r->log, r->gl, "uploading a tile's table");
    if (res == WEFT_OK && !kept)
        weft_error(r->log, "a table of %zu bytes could not be handed to GL", bytes);
    return res == WEFT_OK && !kept ? WEFT_ERR_GL : res;
}

// Voxels that only exact pixels need are asked for anew.
static enum weft_result load_tile(struct weft_hardware *r, int index)
{
    const struct weft_hardware_tile *tile = &r->plan->tiles[index];
    weft_footprint *footprint = r->plan->slice->footprint;
    const double start = weft_now_seconds();
    if (r->loaded == index && !r->blocks.any_unfit)
        return WEFT_OK;
    enum weft_result res = weft_footprint_load(footprint, &tile->bricks, r->own_bytes, &r->store);
    r->report.read_seconds += weft_now_seconds() - start;
    const uint64_t bytes = r->own_bytes + footprint->info.kept_bytes;
    r->report.peak_bytes = bytes > r->report.peak_bytes ? bytes : r->report.peak_bytes;
    if (res != WEFT_OK || r->loaded == index)
        return res;
    r->loaded = NO_TILE;
    res = load_blocks(r, tile);
    if (res == WEFT_OK)
        res = load_entries(r, tile);
    if (res == WEFT_OK && r->blocks.any_unfit)
        res = weft_slice_exact_check(r->plan->slice, r->progress);
    if (res == WEFT_OK)
        r->loaded = index;
    return res;
}

// ---- passes -------------------------------------------------------------------------------------

static void bind_tile(const struct weft_hardware *r, const struct weft_rectangle *at)
{
    static const int order[3] = {0, 1, 2};
    const GladGLContext *gl = r->gl;
    const struct weft_slice_plan *slice = r->plan->slice;
    const int *size = r->source.size;
    double scale, offset;
    weft_source_range_mapping(slice->info.source, &slice->range, &scale, &offset);
    gl->UseProgram(r->program);
    weft_gl_bind_texture(gl, r->program, 0, "source", GL_TEXTURE_3D, r->source.texture);
    weft_gl_bind_buffer(gl, r->program, 1, "entries", &r->entries);
    weft_gl_kernel_bind(gl, r->program, 2, "kernel", &slice->weights[0]->tiles, &r->kernel);
    gl->Uniform3f(weft_gl_location(gl, r->program, "texel"), 1.0f / (float)size[0],
                  1.0f / (float)size[1], 1.0f / (float)size[2]);
    gl->Uniform2f(weft_gl_location(gl, r->program, "mapping"), (float)scale, (float)offset);
    gl->Uniform1i(weft_gl_location(gl, r->program, "row_entries"), at->width);
    gl->Uniform2f(weft_gl_location(gl, r->program, "viewport"), (float)at->width,
                  (float)at->height);
    weft_slice_grid_bind(gl, r->program, &slice->footprint->grid, order);
}

static int smaller(int a, int b)
{
    return a < b ? a : b;
}

static int larger(int a, int b)
{
    return a > b ? a : b;
}

// The pixels of block (bx, by) that lie in the tile.
static void draw_block(struct weft_hardware *r, const struct weft_rectangle *at, int bx, int by)
{
    static const int order[3] = {0, 1, 2};
    const GladGLContext *gl = r->gl;
    const int x = bx * WEFT_GRID_BLOCK - at->x, y = by * WEFT_GRID_BLOCK - at->y;
    const GLint rectangle[4] = {larger(x, 0), larger(y, 0), smaller(x + WEFT_GRID_BLOCK, at->width),
                                smaller(y + WEFT_GRID_BLOCK, at->height)};
    weft_slice_grid_bind_block(gl, r->program, &r->plan->slice->footprint->grid, order, bx, by);
    gl->Uniform2i(weft_gl_location(gl, r->program, "block"), x, y);
    gl->Uniform4iv(weft_gl_location(gl, r->program, "rectangles"), 1, rectangle);
    gl->DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, 1);
    r->report.passes++;
}

static enum weft_result draw_tile(struct weft_hardware *r, const struct weft_rectangle *at)
{
    const double start = weft_now_seconds();
    weft_gl_target_bind(r->gl, &r->target, at->width, at->height);
    bind_tile(r, at);
    for (int by = at->y / WEFT_GRID_BLOCK; by * WEFT_GRID_BLOCK < at->y + at->height; by++)
        for (int bx = at->x / WEFT_GRID_BLOCK; bx * WEFT_GRID_BLOCK < at->x + at->width; bx++)
            draw_block(r, at, bx, by);
    r->gl->Finish();
    r->report.pass_seconds += weft_now_seconds() - start;
    r->report.fetches +=
        (uint64_t)at->width * (uint64_t)at->height * (uint64_t)r->plan->info.fetches_per_pixel;
    return weft_gl_check(r->log, r->gl, "drawing a tile");
}

static enum weft_result read_back(struct weft_hardware *r, const struct weft_rectangle *at,
                                  float *pixels, int64_t stride)
{
    const double start = weft_now_seconds();
    const struct weft_gl_pixels out = {
        .width = at->width,
        .height = at->height,
        .type = GL_FLOAT,
        .stride = (int)stride,
        .data = weft_slice_pixel(r->plan->slice, pixels, stride, at->x, at->y),
    };
    const enum weft_result res = weft_gl_target_read(r->log, r->gl, &r->target, &out);
    r->report.readback_seconds += weft_now_seconds() - start;
    return res;
}

// ---- runs ---------------------------------------------------------------------------------------

static enum weft_result run_tile(struct weft_hardware *r, int index, struct weft_gl_delivery *to)
{
    const struct weft_rectangle *at = &r->plan->tiles[index].at, *part = &r->plan->slice->info.part;
    const struct weft_rectangle in = {at->x - part->x, at->y - part->y, at->width, at->height};
    const double fraction = (index + 1.0) / r->plan->info.tile_count;
    enum weft_result res = load_tile(r, index);
    if (res == WEFT_OK)
        res = draw_tile(r, at);
    const bool paints = r->blocks.any_unfit;
    if (res == WEFT_OK && paints)
        res = weft_gl_delivery_room(r->log, to);
    if (res == WEFT_OK && (to->reads || paints))
        res = read_back(r, at, to->at, to->stride);
    if (res == WEFT_OK && paints) {
        const struct weft_slice_tile tile = {
            .x = at->x, .y = at->y, .width = at->width, .height = at->height};
        const struct weft_slice_pixels out = {.at = to->at, .stride = to->stride};
        res = weft_slice_exact_paint_from(r->plan->slice, &tile, r->store, &out, r->progress,
                                          fraction, &r->report.exact_pixels);
    }
    if (res != WEFT_OK)
        return res;
    return paints ? weft_gl_delivery_upload(to, &in)
                  : weft_gl_delivery_draw(to, &(struct weft_gl_drawn){.texture = r->target.texture},
                                          &in);
}

static enum weft_result run_tiles(struct weft_hardware *r, struct weft_gl_delivery *to)
{
    const int count = r->plan->info.tile_count;
    enum weft_result res = WEFT_OK;
    for (int i = 0; res == WEFT_OK && i < count; i++) {
        if (go_on(r, (double)i / count)) {
            res = run_tile(r, i, to);
        } else {
            weft_note(r->log, "the slice was cancelled at tile %d of %d", i, count);
            res = WEFT_ERR_CANCELLED;
        }
    }
    return res;
}

enum weft_result weft_hardware_run(weft_hardware *r, const struct weft_slice_pixels *pixels,
                                   const struct weft_progress *progress,
                                   struct weft_fused_report *report)
{
    const struct weft_rectangle *part = &r->plan->slice->info.part;
    struct weft_gl_delivery to = {.width = part->width,
                                  .height = part->height,
                                  .outputs = 1,
                                  .at = pixels->at,
                                  .stride = pixels->stride};
    enum weft_result res = weft_context_enter(r->context);
    if (res != WEFT_OK)
        return res;
    r->progress = progress;
    r->report = (struct weft_fused_report){0};
    r->blocks.cells_constant = 0;
    res = weft_gl_delivery_begin(r->context, r->log, pixels->texture, &to);
    if (res == WEFT_OK)
        res = run_tiles(r, &to);
    weft_gl_delivery_end(&to);
    r->report.cells_constant = r->blocks.cells_constant;
    *report = r->report;
    weft_context_leave(r->context);
    return res;
}
