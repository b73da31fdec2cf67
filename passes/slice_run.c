// SPDX-License-Identifier: BSD-3-Clause
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "passes/context_backend.h"
#include "passes/program.h"
#include "passes/slice_plan.h"

// Everything that a run holds, sized for the plan's largest tile before the first one runs.
struct runner {
    const struct weft_slice_plan *plan;
    weft_context *context;
    const GladGLContext *gl;
    weft_volume *volume;
    const struct weft_log *log;
    const struct weft_progress *progress;
    struct weft_slice_report report;

    enum weft_layout layout; // the plan's, unless it had to fall back
    float *values;           // voxels of the tile's bricks
    float *block;            // voxels of one cell's block
    int32_t *cell_entries;   // by cell number
    int32_t *entries;        // by pixel, while the buffer is mapped
    bool *block_constants;   // by block of the tile: some pixel's entry names a constant
    struct weft_block_layout block_layout; // of the tile
    struct weft_gl_buffer source, entry_buffer, kernel;
    // Without and with constants: pixels that need no branch are drawn faster without one.
    GLuint programs[2]; // the context's
    GLuint target, framebuffer, vertex_array;
};

static bool go_on(const struct runner *r, double fraction)
{
    return !r->progress || !r->progress->report || r->progress->report(r->progress->priv, fraction);
}

// ---- set-up -------------------------------------------------------------------------------------

struct sizes {
    size_t bricks, cells, block_voxels, source_bytes, entries, blocks;
    int width, height;
};

static size_t larger(size_t a, size_t b)
{
    return a > b ? a : b;
}

// Blocks are numbered from the one that holds the tile's first pixel.
static int first_block(int start)
{
    return start / WEFT_GRID_BLOCK;
}

static int last_block(int start, int length)
{
    return (start + length - 1) / WEFT_GRID_BLOCK - first_block(start);
}

// What the tiles need at most; a fallback to the plain layout never needs more.
static struct sizes largest_sizes(const struct weft_slice_plan *plan)
{
    struct sizes s = {0};
    for (int i = 0; i < plan->info.tile_count; i++) {
        const struct weft_slice_tile *tile = &plan->tiles[i];
        const struct weft_slice_tile_plan *p = &plan->tile_plans[i];
        const int *span = p->layout.span;
        s.bricks = larger(s.bricks, p->bricks.count);
        s.cells = larger(s.cells, p->map.count);
        s.block_voxels =
            larger(s.block_voxels, (size_t)span[0] * (size_t)span[1] * (size_t)span[2]);
        s.source_bytes = larger(s.source_bytes, p->source_texels * p->layout.texel_bytes);
        s.entries = larger(s.entries, (size_t)tile->width * (size_t)tile->height);
        s.blocks = larger(s.blocks, (size_t)(last_block(tile->x, tile->width) + 1) *
                                        (size_t)(last_block(tile->y, tile->height) + 1));
        s.width = tile->width > s.width ? tile->width : s.width;
        s.height = tile->height > s.height ? tile->height : s.height;
    }
    return s;
}

static enum weft_result check_limits(const struct runner *r, const struct sizes *s)
{
    const struct weft_context_info *info = &r->context->info;
    size_t texels = s->source_bytes / (r->layout == WEFT_LAYOUT_PLAIN ? 4 : 16);
    if (s->width > info->max_target_size || s->height > info->max_target_size ||
        (int64_t)texels > info->max_buffer_texels ||
        (int64_t)s->entries > info->max_buffer_texels) {
        weft_error(r->log,
                   "a tile of %d x %d pixels and %zu texels is over the context's limits of %d and "
                   "%lld; plan with its max_target_size and max_buffer_texels",
                   s->width, s->height, texels, info->max_target_size,
                   (long long)info->max_buffer_texels);
        return WEFT_ERR_LIMIT;
    }
    return WEFT_OK;
}

static enum weft_result find_program(struct runner *r, bool constants)
{
    static const char *const layout_define[] = {
        [WEFT_LAYOUT_INTERLEAVED] = "INTERLEAVED",
        [WEFT_LAYOUT_ALIGNED] = "ALIGNED",
        [WEFT_LAYOUT_PLAIN] = "PLAIN",
    };
    const struct weft_polynomial_tiles *tiles = &r->plan->kernel_tiles;
    char defines[256];
    snprintf(defines, sizeof defines,
             "#define WIDTH %d\n#define GROUPS %d\n#define DEGREE %d\n#define SEGMENTS %d\n"
             "#define CONSTANTS %d\n#define LAYOUT_%s\n",
             tiles->width, tiles->groups, tiles->degree, tiles->segments, constants,
             layout_define[r->layout]);
    return weft_program_get(r->context, "slice", defines, weft_shader_full_target,
                            weft_shader_slice, &r->programs[constants]);
}

static enum weft_result create_target(struct runner *r, const struct sizes *s)
{
    const GladGLContext *gl = r->gl;
    gl->GenTextures(1, &r->target);
    gl->BindTexture(GL_TEXTURE_2D, r->target);
    gl->TexImage2D(GL_TEXTURE_2D, 0, GL_R32F, s->width, s->height, 0, GL_RED, GL_FLOAT, NULL);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    gl->GenFramebuffers(1, &r->framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, r->framebuffer);
    gl->FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, r->target, 0);
    gl->GenVertexArrays(1, &r->vertex_array);
    gl->BindVertexArray(r->vertex_array);
    GLenum status = gl->CheckFramebufferStatus(GL_FRAMEBUFFER);
    enum weft_result res = weft_gl_check(r->log, gl, "creating the render target");
    if (res == WEFT_OK && status != GL_FRAMEBUFFER_COMPLETE) {
        weft_error(r->log, "GL: an r32f render target of %d x %d is incomplete (0x%04x)", s->width,
                   s->height, status);
        res = WEFT_ERR_GL;
    }
    return res;
}

static enum weft_result create_kernel(struct runner *r)
{
    const struct weft_polynomial_tiles *tiles = &r->plan->kernel_tiles;
    if (tiles->segments == 1)
        return WEFT_OK; // a uniform
    size_t bytes = tiles->coefficient_count * sizeof *tiles->coefficients;
    enum weft_result res =
        weft_gl_buffer_create(r->log, r->gl, GL_RGBA32F, tiles->coefficient_count / 4, &r->kernel);
    void *memory = res == WEFT_OK ? weft_gl_buffer_map(r->gl, &r->kernel, bytes) : NULL;
    if (memory) {
        memcpy(memory, tiles->coefficients, bytes);
        weft_gl_buffer_unmap(r->gl, &r->kernel);
    }
    return weft_gl_check(r->log, r->gl, "uploading the kernel tiles");
}

static enum weft_result create_buffers(struct runner *r, const struct sizes *s)
{
    GLenum format = r->layout == WEFT_LAYOUT_PLAIN ? GL_R32F : GL_RGBA32F;
    // malloc(0) may be NULL: one more than needed.
    r->values = malloc((s->bricks + 1) * WEFT_BRICK_VOXELS * sizeof *r->values);
    r->block = malloc(s->block_voxels * sizeof *r->block);
    r->cell_entries = malloc((s->cells + 1) * sizeof *r->cell_entries);
    r->block_constants = malloc(s->blocks * sizeof *r->block_constants);
    if (!r->values || !r->block || !r->cell_entries || !r->block_constants) {
        weft_error(r->log, "not enough memory for the voxels of %zu bricks", s->bricks);
        return WEFT_ERR_MEMORY;
    }
    enum weft_result res = weft_gl_buffer_create(
        r->log, r->gl, format, s->source_bytes / (format == GL_R32F ? 4 : 16), &r->source);
    if (res == WEFT_OK)
        res = weft_gl_buffer_create(r->log, r->gl, GL_R32I, s->entries, &r->entry_buffer);
    if (res == WEFT_OK)
        res = create_kernel(r);
    if (res == WEFT_OK)
        res = create_target(r, s);
    r->report.peak_bytes = (s->bricks + 1) * WEFT_BRICK_VOXELS * sizeof *r->values +
                           s->source_bytes + s->entries * 4 +
                           (size_t)s->width * (size_t)s->height * 4;
    return res;
}

static void destroy(struct runner *r)
{
    const GladGLContext *gl = r->gl;
    weft_gl_buffer_destroy(gl, &r->source);
    weft_gl_buffer_destroy(gl, &r->entry_buffer);
    weft_gl_buffer_destroy(gl, &r->kernel);
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    if (r->framebuffer)
        gl->DeleteFramebuffers(1, &r->framebuffer);
    if (r->target)
        gl->DeleteTextures(1, &r->target);
    if (r->vertex_array)
        gl->DeleteVertexArrays(1, &r->vertex_array);
    free(r->values);
    free(r->block);
    free(r->cell_entries);
    free(r->block_constants);
}

// ---- one tile's data ----------------------------------------------------------------------------

static bool all_finite(const float *values, size_t count)
{
    // Finite numbers times zero are zero; anything else is NaN.
    float sum = 0.0f;
    for (size_t i = 0; i < count; i++)
        sum += values[i] * 0.0f;
    return sum == 0.0f;
}

// Aligned rows multiply samples beside the kernel's reach by zero, which only finite ones stand.
static void choose_layout(struct runner *r, size_t value_count)
{
    if (r->layout != WEFT_LAYOUT_ALIGNED || all_finite(r->values, value_count))
        return;
    weft_note(r->log, "the volume holds NaN or infinity: layout plain instead of aligned");
    r->report.plain_fallback = true;
    r->layout = WEFT_LAYOUT_PLAIN;
    // The same memory, read as single samples.
    r->source.format = GL_R32F;
    r->source.texel_bytes = 4;
    r->gl->BindTexture(GL_TEXTURE_BUFFER, r->source.texture);
    r->gl->TexBuffer(GL_TEXTURE_BUFFER, GL_R32F, r->source.buffer);
    r->programs[0] = r->programs[1] = 0;
}

static void write_block(const struct runner *r, const struct weft_brick_store *store,
                        const struct weft_block_layout *layout, struct weft_cell_key key,
                        const struct weft_slice_cell *cell, void *texels)
{
    int32_t min[3], max[3];
    int size[3];
    weft_slice_cell_box(r->plan, key, cell, min, max);
    if (layout->kind == WEFT_LAYOUT_ALIGNED)
        min[0] -= cell->low[0];
    for (int a = 0; a < 3; a++)
        size[a] = max[a] - min[a] + 1;
    if (size[0] < layout->span[0] || size[1] < layout->span[1] || size[2] < layout->span[2])
        memset(r->block, 0,
               sizeof *r->block * (size_t)layout->span[0] * (size_t)layout->span[1] *
                   (size_t)layout->span[2]);
    weft_brick_store_copy_box(store, min, size, layout->span, r->block);
    weft_block_layout_write(layout, r->block, texels);
}

// Fills the source buffer and cell_entries. All cells of a tile share one layout.
static void lay_out(struct runner *r, const struct weft_slice_tile_plan *tile,
                    const struct weft_brick_store *store, const struct weft_block_layout *layout,
                    char *source)
{
    // The head holds the constants; a plain fallback has the same head in smaller texels.
    size_t constants = 0, at = tile->head_texels;
    if (layout->kind == WEFT_LAYOUT_PLAIN && tile->layout.kind == WEFT_LAYOUT_ALIGNED)
        at = larger(tile->constant_count, weft_block_layout_offset(layout, (int[]){7, 7, 7}) + 1);
    memset(source, 0, at * layout->texel_bytes);
    for (size_t i = 0; i < tile->map.count; i++) {
        const struct weft_slice_cell *cell = &tile->cells[i];
        if (cell->constant) {
            memcpy(source + constants * layout->texel_bytes, &cell->value, sizeof cell->value);
            r->cell_entries[i] = ~(int32_t)constants++;
            continue;
        }
        int low[3] = {cell->low[0], cell->low[1], cell->low[2]};
        if (layout->kind == WEFT_LAYOUT_ALIGNED)
            low[0] = 0;
        write_block(r, store, layout, tile->map.keys[i], cell, source + at * layout->texel_bytes);
        r->cell_entries[i] = (int32_t)(at - weft_block_layout_offset(layout, low));
        at += layout->block_texels;
    }
}

static size_t block_number(const struct weft_slice_tile *tile, int bx, int by)
{
    size_t row = (size_t)last_block(tile->x, tile->width) + 1;
    return (size_t)(by - first_block(tile->y)) * row + (size_t)(bx - first_block(tile->x));
}

struct entry_writer {
    struct runner *r;
    const struct weft_slice_tile_plan *tile_plan;
    const struct weft_slice_tile *tile;
};

static bool write_entries(void *priv, const struct weft_slice_run_of_pixels *run)
{
    const struct entry_writer *w = priv;
    int64_t number = weft_cell_map_find(&w->tile_plan->map, run->cell);
    int32_t entry = w->r->cell_entries[number];
    if (entry < 0)
        w->r->block_constants[block_number(w->tile, run->x / WEFT_GRID_BLOCK,
                                           run->y / WEFT_GRID_BLOCK)] = true;
    int32_t *out = w->r->entries + (size_t)(run->y - w->tile->y) * (size_t)w->tile->width +
                   (run->x - w->tile->x);
    for (int i = 0; i < run->count; i++)
        out[i] = entry;
    return true;
}

static enum weft_result load_tile(struct runner *r, int index)
{
    const struct weft_slice_tile *tile = &r->plan->tiles[index];
    const struct weft_slice_tile_plan *p = &r->plan->tile_plans[index];
    weft_brick_store *store = NULL;
    double start = weft_now_seconds();
    enum weft_result res = weft_slice_read_bricks(r->plan, r->volume, &p->bricks, r->values);
    double read = weft_now_seconds();
    if (res == WEFT_OK)
        choose_layout(r, p->bricks.count * WEFT_BRICK_VOXELS);
    if (res == WEFT_OK)
        res = weft_slice_store_create(r->log, weft_volume_get_info(r->volume), &r->plan->topology,
                                      &p->bricks, r->values, &store);
    if (res != WEFT_OK)
        goto fail;

    // The layouts are written straight into GL's memory: upload is mapping and unmapping.
    struct weft_block_layout *layout = &r->block_layout;
    *layout = p->layout;
    if (r->layout != layout->kind)
        weft_block_layout_init(layout, r->layout, p->layout.width,
                               (int[]){WEFT_BRICK_SIZE, p->layout.span[1] - p->layout.width + 1,
                                       p->layout.span[2] - p->layout.width + 1});
    res = WEFT_ERR_GL;
    size_t source_bytes = p->source_texels * p->layout.texel_bytes;
    size_t entry_bytes = (size_t)tile->width * (size_t)tile->height * sizeof *r->entries;
    char *source = weft_gl_buffer_map(r->gl, &r->source, source_bytes);
    r->entries = weft_gl_buffer_map(r->gl, &r->entry_buffer, entry_bytes);
    double mapped = weft_now_seconds();
    if (source && r->entries) {
        struct entry_writer writer = {r, p, tile};
        lay_out(r, p, store, layout, source);
        memset(r->block_constants, 0,
               block_number(tile, first_block(tile->x) + last_block(tile->x, tile->width),
                            first_block(tile->y) + last_block(tile->y, tile->height)) +
                   1);
        weft_slice_grid_walk(&r->plan->grid, tile->x, tile->y, tile->width, tile->height,
                             write_entries, &writer);
    }
    double laid_out = weft_now_seconds();
    if (source && r->entries && weft_gl_buffer_unmap(r->gl, &r->source) &&
        weft_gl_buffer_unmap(r->gl, &r->entry_buffer))
        res = WEFT_OK;
    if (weft_gl_check(r->log, r->gl, "uploading a tile's voxels") != WEFT_OK || res != WEFT_OK) {
        weft_error(r->log, "a tile of %zu bytes could not be handed to GL", source_bytes);
        res = WEFT_ERR_GL;
    }
    r->report.read_seconds += read - start;
    r->report.layout_seconds += laid_out - mapped;
    r->report.upload_seconds += weft_now_seconds() - laid_out + (mapped - read);
    r->report.uploaded_bytes += source_bytes + entry_bytes;
fail:
    weft_brick_store_destroy(&store);
    return res;
}

// ---- passes -------------------------------------------------------------------------------------

static GLint location(const struct runner *r, GLuint program, const char *name)
{
    return r->gl->GetUniformLocation(program, name);
}

// A position or step modulo 8 voxels, as the shader's two words.
static void set_fixed(const struct runner *r, GLuint program, const char *name,
                      const char *low_name, const int64_t value[3])
{
    int low_bits = r->plan->grid.fraction_bits - WEFT_GRID_WORD_FRACTION_BITS;
    GLint word[3], low[3];
    for (int a = 0; a < 3; a++) {
        word[a] = (GLint)(uint32_t)(value[a] >> low_bits);
        low[a] = (GLint)(value[a] & ((INT64_C(1) << low_bits) - 1));
    }
    r->gl->Uniform3iv(location(r, program, name), 1, word);
    r->gl->Uniform3iv(location(r, program, low_name), 1, low);
}

static void bind_buffer(const struct runner *r, GLuint program, GLuint unit, const char *name,
                        const struct weft_gl_buffer *buffer)
{
    r->gl->ActiveTexture(GL_TEXTURE0 + unit);
    r->gl->BindTexture(GL_TEXTURE_BUFFER, buffer->texture);
    r->gl->Uniform1i(location(r, program, name), (GLint)unit);
    r->gl->ActiveTexture(GL_TEXTURE0);
}

static void bind_tile(const struct runner *r, GLuint program, const struct weft_slice_tile *tile)
{
    const GladGLContext *gl = r->gl;
    const struct weft_polynomial_tiles *tiles = &r->plan->kernel_tiles;
    gl->UseProgram(program);
    bind_buffer(r, program, 0, "source", &r->source);
    bind_buffer(r, program, 1, "entries", &r->entry_buffer);
    if (tiles->segments > 1)
        bind_buffer(r, program, 2, "kernel", &r->kernel);
    else
        gl->Uniform4fv(location(r, program, "kernel"), (GLsizei)(tiles->coefficient_count / 4),
                       tiles->coefficients);
    gl->Uniform2i(location(r, program, "pitch"), r->block_layout.row_texels,
                  r->block_layout.row_texels * r->block_layout.span[1]);
    gl->Uniform1i(location(r, program, "row_entries"), tile->width);
    gl->Uniform1i(location(r, program, "low_bits"),
                  r->plan->grid.fraction_bits - WEFT_GRID_WORD_FRACTION_BITS);
    set_fixed(r, program, "du", "du_low", r->plan->grid.du);
    set_fixed(r, program, "dv", "dv_low", r->plan->grid.dv);
}

// Draws the part of block (bx, by) that lies in the tile.
static void draw_block(struct runner *r, GLuint program, const struct weft_slice_tile *tile, int bx,
                       int by)
{
    const GladGLContext *gl = r->gl;
    int x0 = bx * WEFT_GRID_BLOCK - tile->x, y0 = by * WEFT_GRID_BLOCK - tile->y;
    int x1 = x0 + WEFT_GRID_BLOCK, y1 = y0 + WEFT_GRID_BLOCK;
    int from_x = x0 > 0 ? x0 : 0, from_y = y0 > 0 ? y0 : 0;
    int to_x = x1 < tile->width ? x1 : tile->width, to_y = y1 < tile->height ? y1 : tile->height;
    struct weft_slice_block block;
    weft_slice_grid_block(&r->plan->grid, bx, by, &block);
    set_fixed(r, program, "origin", "origin_low", block.position);
    gl->Uniform2i(location(r, program, "block"), x0, y0);
    gl->Viewport(from_x, from_y, to_x - from_x, to_y - from_y);
    gl->Scissor(from_x, from_y, to_x - from_x, to_y - from_y);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    r->report.passes++;
}

// Draws the blocks with or without constants.
static enum weft_result draw_blocks(struct runner *r, const struct weft_slice_tile *tile,
                                    bool constants)
{
    bool bound = false;
    for (int y = 0; y <= last_block(tile->y, tile->height); y++) {
        for (int x = 0; x <= last_block(tile->x, tile->width); x++) {
            int bx = first_block(tile->x) + x, by = first_block(tile->y) + y;
            if (r->block_constants[block_number(tile, bx, by)] != constants)
                continue;
            if (!r->programs[constants]) {
                enum weft_result res = find_program(r, constants);
                if (res != WEFT_OK)
                    return res;
            }
            if (!bound)
                bind_tile(r, r->programs[constants], tile);
            bound = true;
            draw_block(r, r->programs[constants], tile, bx, by);
        }
    }
    return WEFT_OK;
}

static enum weft_result draw_tile(struct runner *r, int index)
{
    const struct weft_slice_tile *tile = &r->plan->tiles[index];
    double start = weft_now_seconds();
    r->gl->Enable(GL_SCISSOR_TEST);
    enum weft_result res = draw_blocks(r, tile, false);
    if (res == WEFT_OK)
        res = draw_blocks(r, tile, true);
    r->gl->Finish();
    r->report.pass_seconds += weft_now_seconds() - start;
    return res == WEFT_OK ? weft_gl_check(r->log, r->gl, "drawing a tile") : res;
}

static enum weft_result read_back(struct runner *r, int index, float *pixels)
{
    const struct weft_slice_tile *tile = &r->plan->tiles[index];
    const GladGLContext *gl = r->gl;
    int width = r->plan->grid.index.width;
    double start = weft_now_seconds();
    gl->PixelStorei(GL_PACK_ROW_LENGTH, width);
    gl->PixelStorei(GL_PACK_ALIGNMENT, 4);
    gl->ReadPixels(0, 0, tile->width, tile->height, GL_RED, GL_FLOAT,
                   pixels + (size_t)tile->y * (size_t)width + tile->x);
    r->report.readback_seconds += weft_now_seconds() - start;
    return weft_gl_check(r->log, gl, "reading pixels back");
}

static void measure_pixels(const float *pixels, size_t count, struct weft_slice_report *report)
{
    float minimum = INFINITY, maximum = -INFINITY;
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(pixels[i])) {
            report->not_finite++;
            continue;
        }
        minimum = pixels[i] < minimum ? pixels[i] : minimum;
        maximum = pixels[i] > maximum ? pixels[i] : maximum;
    }
    report->minimum = report->not_finite < count ? minimum : NAN;
    report->maximum = report->not_finite < count ? maximum : NAN;
}

enum weft_result weft_slice_run(weft_context *context, const weft_slice_plan *plan,
                                weft_volume *volume, float *pixels,
                                const struct weft_progress *progress,
                                struct weft_slice_report *report)
{
    struct runner r = {
        .plan = plan,
        .context = context,
        .gl = &context->gl,
        .volume = weft_slice_voxels(plan, volume),
        .log = plan->log,
        .progress = progress,
        .layout = plan->info.layout,
    };
    struct sizes sizes = largest_sizes(plan);
    enum weft_result res = weft_context_enter(context);
    if (res != WEFT_OK)
        return res;
    res = check_limits(&r, &sizes);
    if (res == WEFT_OK)
        res = create_buffers(&r, &sizes);
    for (int i = 0; res == WEFT_OK && i < plan->info.tile_count; i++) {
        if (!go_on(&r, (double)i / plan->info.tile_count)) {
            weft_note(plan->log, "the slice was cancelled at tile %d of %d", i,
                      plan->info.tile_count);
            res = WEFT_ERR_CANCELLED;
            break;
        }
        res = load_tile(&r, i);
        if (res == WEFT_OK)
            res = draw_tile(&r, i);
        if (res == WEFT_OK)
            res = read_back(&r, i, pixels);
    }
    destroy(&r);
    weft_context_leave(context);
    if (res != WEFT_OK)
        return res;
    go_on(&r, 1.0);
    const struct weft_slice_geometry *g = &plan->grid.index;
    measure_pixels(pixels, (size_t)g->width * (size_t)g->height, &r.report);
    if (report)
        *report = r.report;
    return WEFT_OK;
}
