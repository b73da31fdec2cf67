// SPDX-License-Identifier: BSD-3-Clause
#include "passes/fused/run.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "passes/gl/context_backend.h"
#include "passes/gl/kernel_weights.h"
#include "passes/gl/program.h"
#include "passes/gl/target.h"
#include "passes/gl/textures/delivery.h"
#include "passes/positions/grid_uniforms.h"
#include "passes/fused/exact.h"
#include "passes/fused/layout.h"
#include "passes/fused/outputs.h"
#include "passes/fused/resident_impl.h"

// Shaders for pixels that need less: a software GL runs both sides of a branch.
enum kind { KIND_FULL, KIND_SMOOTH, KIND_CONSTANT, KIND_COUNT };

// Pixels are sorted into squares, of which each is drawn with the cheapest shader that does for all
// of it.
enum { SQUARE = WEFT_SLICE_SQUARE, SQUARES_PER_BLOCK = WEFT_GRID_BLOCK / SQUARE };

// Of several outputs: rows that are read back at once.
enum { READ_ROWS = 64 };

struct weft_fused {
    const struct weft_slice_plan *plan;
    weft_context *context;
    const GladGLContext *gl;
    const struct weft_log *log;
    uint64_t own_bytes; // beside voxels
    // Of a run.
    const struct weft_progress *progress;
    struct weft_fused_report report;

    struct weft_slice_layout layout;
    struct weft_slice_blocks cells; // of the tile
    int32_t *entries;               // by pixel, while the buffer is mapped
    float *rows;                    // of several outputs: texels that are read back; else NULL
    uint8_t *squares;               // of the tile: bits of the classes that its pixels have
    struct weft_fused_sizes sizes;  // of objects
    struct weft_fused_objects own,
        *objects;                   // what is made in GL: for this, or the resident volume's
    GLuint programs[KIND_COUNT][2]; // the context's; without and with constants among the pixels
};

static bool go_on(const struct weft_fused *r, double fraction)
{
    return !r->progress || !r->progress->report || r->progress->report(r->progress->priv, fraction);
}

// ---- set-up -------------------------------------------------------------------------------------

struct sizes {
    size_t bricks, cells, source_texels, source_bytes, entries, squares;
    int width, height;
};

static size_t larger(size_t a, size_t b)
{
    return a > b ? a : b;
}

// Squares and blocks of a tile are numbered from the one that holds its first pixel.
static int count_cut(int start, int length, int size)
{
    return (start + length - 1) / size - start / size + 1;
}

static size_t square_number(const struct weft_slice_tile *tile, int x, int y)
{
    size_t row = (size_t)count_cut(tile->x, tile->width, SQUARE);
    return (size_t)(y / SQUARE - tile->y / SQUARE) * row + (size_t)(x / SQUARE - tile->x / SQUARE);
}

static size_t square_count(const struct weft_slice_tile *tile)
{
    return (size_t)count_cut(tile->x, tile->width, SQUARE) *
           (size_t)count_cut(tile->y, tile->height, SQUARE);
}

// What the tiles need at most.
static struct sizes largest_sizes(const struct weft_slice_plan *plan)
{
    struct sizes s = {0};
    for (int i = 0; i < plan->info.tile_count; i++) {
        const struct weft_slice_tile *tile = &plan->tiles[i];
        const struct weft_slice_tile_plan *p = &plan->tile_plans[i];
        s.bricks = larger(s.bricks, p->bricks.count);
        s.cells = larger(s.cells, p->cells->map.count);
        s.source_bytes = larger(s.source_bytes, p->source_texels * p->layout.texel_bytes);
        if (!weft_slice_reads_blocks(plan))
            s.source_texels = larger(s.source_texels, p->source_texels);
        s.entries = larger(s.entries, (size_t)tile->width * (size_t)tile->height);
        s.squares = larger(s.squares, square_count(tile));
        s.width = tile->width > s.width ? tile->width : s.width;
        s.height = tile->height > s.height ? tile->height : s.height;
    }
    return s;
}

static enum weft_result check_limits(const struct weft_fused *r, const struct sizes *s)
{
    const struct weft_context_info *info = &r->context->info;
    if (s->width > info->max_target_size || s->height > info->max_target_size ||
        (int64_t)s->source_texels > info->max_buffer_texels ||
        (int64_t)s->entries > info->max_buffer_texels) {
        weft_error(r->log,
                   "a tile of %d x %d pixels and %zu texels is over the context's limits of %d and "
                   "%lld; plan with its max_target_size and max_buffer_texels",
                   s->width, s->height, s->source_texels, info->max_target_size,
                   (long long)info->max_buffer_texels);
        return WEFT_ERR_LIMIT;
    }
    return WEFT_OK;
}

static int lead_of(const struct weft_slice_plan *plan)
{
    return weft_slice_reads_blocks(plan)
               ? weft_resident_lead(plan->resident, plan->info.kernel.width)
               : 0;
}

// Samples before the first tap that a row of interleaved texels is fetched from: none where the row
// is long enough to begin at the tap itself.
static int skip_of(const struct weft_slice_plan *plan, int first, int width)
{
    const int taps =
        weft_slice_reads_blocks(plan) ? plan->resident->info.kernel.width : plan->info.kernel.width;
    const int fetches = weft_layout_row_fetches(WEFT_LAYOUT_INTERLEAVED, width);
    const int most = weft_layout_row_fetches(WEFT_LAYOUT_INTERLEAVED, taps);
    return first + 4 * fetches <= 4 * most ? 0 : first;
}

static enum weft_result find_program(struct weft_fused *r, enum kind kind, bool constants)
{
    static const char *const layout_define[] = {
        [WEFT_LAYOUT_INTERLEAVED] = "INTERLEAVED",
        [WEFT_LAYOUT_ALIGNED] = "ALIGNED",
        [WEFT_LAYOUT_PLAIN] = "PLAIN",
    };
    const struct weft_slice_plan *plan = r->plan;
    const struct weft_polynomial_tiles *tiles = &plan->weights[0]->tiles;
    const struct weft_kernel *kernel = &plan->info.kernel;
    const bool full = kind == KIND_FULL;
    const int middle = (tiles->width - 1) / 2, odd = tiles->width % 2;
    const int width = full ? tiles->width : 2, first = lead_of(plan) + (full ? 0 : middle);
    char defines[WEFT_FUSED_DEFINES];
    snprintf(defines, sizeof defines,
             "#define WIDTH %d\n#define FIRST %d\n#define SKIP %d\n#define GROUPS %d\n#define "
             "DEGREE %d\n#define "
             "SEGMENTS %d\n"
             "#define SUMMED %d\n#define CONSTANTS %d\n#define CONSTANTS_ONLY %d\n"
             "#define MAPPED %d\n#define UNIT_SUM %d\n#define LAYOUT_%s\n",
             width, first, skip_of(plan, first, width), full ? tiles->groups : 1,
             full ? tiles->degree : 1, full ? tiles->segments : 1, plan->axes.summed, constants,
             kind == KIND_CONSTANT, plan->info.source != WEFT_SOURCE_FLOAT, kernel->unit_sum,
             layout_define[r->plan->info.layout]);
    if (full && plan->clamp_to_samples && tiles->width > 1)
        snprintf(defines + strlen(defines), sizeof defines - strlen(defines),
                 "#define CLAMP_FROM %d\n#define CLAMP_TO %d\n", middle - odd, middle + 1);
    if (weft_slice_derives(plan))
        weft_fused_define_outputs(plan, defines);
    return weft_program_get(r->context, "slice", defines, weft_shader_rectangles, weft_shader_fused,
                            &r->programs[kind][constants]);
}

// Those of the resident volume may be what another slice left.
static enum weft_result fit_objects(struct weft_fused *r)
{
    enum weft_result res = weft_fused_objects_fit(r->log, r->gl, &r->sizes, r->objects);
    for (int n = 0; res == WEFT_OK && n < WEFT_LINE_ORDERS; n++)
        if (r->plan->weights[n])
            res = weft_gl_kernel_create(r->log, r->gl, &r->plan->weights[n]->tiles,
                                        &r->objects->kernel[n]);
    return res;
}

// Targets of four outputs; 0: there is the value alone.
static int target_count(const struct weft_slice_plan *plan)
{
    return weft_slice_derives(plan) ? weft_fused_target_count(plan->info.output_count) : 0;
}

// Of a constant cell: its value and, where there are derivatives, what those are.
static size_t constant_texels(const struct weft_fused *r)
{
    return weft_slice_derives(r->plan) ? 2 : 1;
}

// Room for rows of texels on their way to the planes of outputs.
static enum weft_result create_rows(struct weft_fused *r, int width)
{
    r->rows = malloc((size_t)READ_ROWS * (size_t)width * 4 * sizeof *r->rows);
    if (r->rows)
        return WEFT_OK;
    weft_error(r->log, "not enough memory for rows of %d pixels", width);
    return WEFT_ERR_MEMORY;
}

static enum weft_result create_buffers(struct weft_fused *r, const struct sizes *s)
{
    const bool blocks = weft_slice_reads_blocks(r->plan);
    r->squares = malloc(s->squares * sizeof *r->squares);
    if (!r->squares) {
        weft_error(r->log, "not enough memory for %zu squares", s->squares);
        return WEFT_ERR_MEMORY;
    }
    r->sizes = (struct weft_fused_sizes){
        .source_format = weft_fused_source_format(r->plan->info.source, r->plan->info.layout),
        .source_texels = blocks ? 0 : s->source_texels,
        .entries = s->entries,
        .constants = constant_texels(r) * (s->cells + 1),
        .width = s->width,
        .height = s->height,
        .targets = target_count(r->plan),
    };
    enum weft_result res = weft_slice_blocks_create(r->plan, &r->cells);
    if (res == WEFT_OK && !blocks)
        res = weft_slice_layout_create(r->plan, &r->layout);
    if (res == WEFT_OK)
        res = fit_objects(r);
    const size_t pixel_bytes = r->sizes.targets ? 16 * (size_t)r->sizes.targets : 4;
    r->own_bytes = s->source_bytes + s->entries * 4 + constant_texels(r) * s->cells * 4 +
                   (size_t)s->width * (size_t)s->height * pixel_bytes;
    if (res == WEFT_OK && r->sizes.targets)
        res = create_rows(r, s->width);
    return res;
}

// ---- one tile's data ----------------------------------------------------------------------------

struct entry_writer {
    const struct weft_fused *r;
    const struct weft_slice_tile *tile;
    bool mixed; // cells are of several classes
};

static bool write_entries(void *priv, int x, int y, const struct weft_cell_span *span)
{
    const struct entry_writer *w = priv;
    const int32_t entry = w->r->cells.entries[span->cell];
    const uint8_t bit = (uint8_t)(1u << w->r->cells.classes[span->cell]);
    const int count = (int)span->count, from = w->tile->x + x;
    int32_t *out = w->r->entries + (size_t)y * (size_t)w->tile->width + x;
    for (int i = 0; i < count; i++)
        out[i] = entry;
    for (int at = from; w->mixed && at < from + count; at = (at / SQUARE + 1) * SQUARE)
        w->r->squares[square_number(w->tile, at, w->tile->y + y)] |= bit;
    return true;
}

static void write_constants(struct weft_fused *r)
{
    const size_t texels = constant_texels(r);
    size_t bytes = r->cells.constant_count * texels * sizeof *r->cells.constants;
    float *memory = bytes ? weft_gl_buffer_map(r->gl, &r->objects->constants, bytes) : NULL;
    if (!memory)
        return;
    if (texels == 1)
        memcpy(memory, r->cells.constants, bytes);
    for (size_t i = 0; texels > 1 && i < r->cells.constant_count; i++) {
        static const struct weft_derivative value, slope = {{1, 0, 0}};
        memory[2 * i] = weft_slice_constant(&value, r->cells.constants[i]);
        memory[2 * i + 1] = weft_slice_constant(&slope, r->cells.constants[i]);
    }
    weft_gl_buffer_unmap(r->gl, &r->objects->constants);
}

// The table of the tile's pixels, and the values of its constant cells.
static enum weft_result load_entries(struct weft_fused *r, int index)
{
    const struct weft_slice_tile *tile = &r->plan->tiles[index];
    const size_t bytes = (size_t)tile->width * (size_t)tile->height * sizeof *r->entries;
    const bool mixed = r->cells.constant_count || r->cells.smooth_count;
    struct entry_writer writer = {r, tile, mixed};
    const double start = weft_now_seconds();
    r->entries = weft_gl_buffer_map(r->gl, &r->objects->entries, bytes);
    const double mapped = weft_now_seconds();
    if (r->entries) {
        memset(r->squares, mixed ? 0 : 1u << WEFT_CELL_FULL, square_count(tile));
        weft_footprint_visit(r->plan->footprint, r->plan->tile_plans[index].cells, 0, tile->height,
                             write_entries, &writer);
        write_constants(r);
    }
    const double written = weft_now_seconds();
    const bool kept = r->entries && weft_gl_buffer_unmap(r->gl, &r->objects->entries);
    r->report.layout_seconds += written - mapped;
    r->report.upload_seconds += (mapped - start) + (weft_now_seconds() - written);
    r->report.uploaded_bytes += bytes;
    const enum weft_result res = weft_gl_check(r->log, r->gl, "uploading a tile's table");
    if (res != WEFT_OK || kept)
        return res;
    weft_error(r->log, "a table of %zu bytes could not be handed to GL", bytes);
    return WEFT_ERR_GL;
}

// Bricks are read, and the tile's own blocks made of them, straight into GL's memory: upload is
// mapping and unmapping.
static enum weft_result load_source(struct weft_fused *r, int index)
{
    const struct weft_slice_tile_plan *p = &r->plan->tile_plans[index];
    const size_t bytes = p->source_texels * p->layout.texel_bytes;
    const weft_brick_store *store;
    const double start = weft_now_seconds();
    enum weft_result res =
        weft_footprint_load(r->plan->footprint, &p->bricks, r->own_bytes, &store);
    const double read = weft_now_seconds();
    if (res != WEFT_OK)
        return res;
    char *source = weft_gl_buffer_map(r->gl, &r->objects->source, bytes);
    const double mapped = weft_now_seconds();
    if (source)
        weft_slice_layout_write(&r->layout, p, store, source, &r->cells);
    const double laid_out = weft_now_seconds();
    const bool kept = source && weft_gl_buffer_unmap(r->gl, &r->objects->source);
    r->report.read_seconds += read - start;
    r->report.layout_seconds += laid_out - mapped;
    r->report.upload_seconds += (mapped - read) + (weft_now_seconds() - laid_out);
    r->report.uploaded_bytes += bytes;
    res = weft_gl_check(r->log, r->gl, "uploading a tile's voxels");
    if (res != WEFT_OK || kept)
        return res;
    weft_error(r->log, "a tile of %zu bytes could not be handed to GL", bytes);
    return WEFT_ERR_GL;
}

// What the tile needs of the resident volume is there, or added.
static enum weft_result load_blocks(struct weft_fused *r, int index)
{
    const struct weft_resident_info *info = &r->plan->resident->info, before = *info;
    const enum weft_result res =
        weft_resident_load(r->plan->resident, r->plan, index, r->progress, &r->cells);
    r->report.read_seconds += info->read_seconds - before.read_seconds;
    r->report.layout_seconds += info->layout_seconds - before.layout_seconds;
    r->report.upload_seconds += info->upload_seconds - before.upload_seconds;
    r->report.uploaded_bytes += (info->laid_out - before.laid_out) * info->block_bytes;
    return res;
}

static enum weft_result load_tile(struct weft_fused *r, int index)
{
    enum weft_result res =
        weft_slice_reads_blocks(r->plan) ? load_blocks(r, index) : load_source(r, index);
    if (res == WEFT_OK)
        res = load_entries(r, index);
    const uint64_t bytes = r->own_bytes + r->plan->footprint->info.kept_bytes;
    r->report.peak_bytes = bytes > r->report.peak_bytes ? bytes : r->report.peak_bytes;
    return res == WEFT_OK && r->cells.any_unfit ? weft_slice_exact_check(r->plan, r->progress)
                                                : res;
}

// ---- passes -------------------------------------------------------------------------------------

// The weights of the full kernel, or those of linear interpolation, whose first tap is not the
// full kernel's.
static void bind_kernel(const struct weft_fused *r, GLuint program, enum kind kind)
{
    static const float linear[2][4] = {{1.0f, 0.0f}, {-1.0f, 1.0f}};
    static const char *const names[WEFT_LINE_ORDERS] = {"kernel", "kernel_1", "kernel_2"};
    if (kind == KIND_SMOOTH)
        r->gl->Uniform4fv(weft_gl_location(r->gl, program, "kernel"), 2, linear[0]);
    for (int n = 0; kind != KIND_SMOOTH && n < WEFT_LINE_ORDERS; n++)
        if (r->plan->weights[n])
            weft_gl_kernel_bind(r->gl, program, 3 + (GLuint)n, names[n],
                                &r->plan->weights[n]->tiles, &r->objects->kernel[n]);
}

static void bind_tile(const struct weft_fused *r, GLuint program, enum kind kind,
                      const struct weft_slice_tile *tile)
{
    const GladGLContext *gl = r->gl;
    const struct weft_block_layout *layout = &r->cells.layout;
    double scale, offset;
    weft_source_range_mapping(r->plan->info.source, &r->plan->range, &scale, &offset);
    gl->UseProgram(program);
    weft_gl_bind_buffer(r->gl, program, 0, "source",
                        weft_slice_reads_blocks(r->plan) ? &r->plan->resident->buffer
                                                         : &r->objects->source);
    weft_gl_bind_buffer(r->gl, program, 1, "entries", &r->objects->entries);
    weft_gl_bind_buffer(r->gl, program, 2, "constants", &r->objects->constants);
    bind_kernel(r, program, kind);
    gl->Uniform2f(weft_gl_location(r->gl, program, "mapping"), (float)scale, (float)offset);
    gl->Uniform2i(weft_gl_location(r->gl, program, "pitch"), layout->row_texels,
                  layout->row_texels * layout->span[1]);
    gl->Uniform1i(weft_gl_location(r->gl, program, "row_entries"), tile->width);
    gl->Uniform2f(weft_gl_location(r->gl, program, "viewport"), (float)tile->width,
                  (float)tile->height);
    weft_slice_grid_bind(gl, program, &r->plan->footprint->grid, r->plan->axes.order);
}

// The shader that a square's classes need, and whether constants are among them.
static enum kind square_kind(uint8_t classes, bool *constants)
{
    *constants = classes & 1u << WEFT_CELL_CONSTANT;
    return classes & 1u << WEFT_CELL_FULL     ? KIND_FULL
           : classes & 1u << WEFT_CELL_SMOOTH ? KIND_SMOOTH
                                              : KIND_CONSTANT;
}

// Rectangles in window coordinates: left, bottom, right, top.
struct rectangles {
    int count;
    GLint at[SQUARES_PER_BLOCK * SQUARES_PER_BLOCK][4];
};

// Adds a row's rectangle, or stretches the one below it.
static void add_rectangle(struct rectangles *list, int x0, int y0, int x1, int y1)
{
    for (int i = 0; i < list->count; i++) {
        GLint *below = list->at[i];
        if (below[0] == x0 && below[2] == x1 && below[3] == y0) {
            below[3] = y1;
            return;
        }
    }
    memcpy(list->at[list->count++], (GLint[4]){x0, y0, x1, y1}, sizeof list->at[0]);
}

static int smaller(int a, int b)
{
    return a < b ? a : b;
}

static int next_square(int at, int limit)
{
    return smaller((at / SQUARE + 1) * SQUARE, limit);
}

// The squares of block (bx, by) within the tile that want this shader, neighbours joined.
static void find_rectangles(const struct weft_fused *r, const struct weft_slice_tile *tile, int bx,
                            int by, enum kind kind, bool constants, struct rectangles *out)
{
    const int from_x = bx * WEFT_GRID_BLOCK > tile->x ? bx * WEFT_GRID_BLOCK : tile->x;
    const int from_y = by * WEFT_GRID_BLOCK > tile->y ? by * WEFT_GRID_BLOCK : tile->y;
    const int to_x = smaller((bx + 1) * WEFT_GRID_BLOCK, tile->x + tile->width);
    const int to_y = smaller((by + 1) * WEFT_GRID_BLOCK, tile->y + tile->height);
    out->count = 0;
    for (int y = from_y; y < to_y; y = next_square(y, to_y)) {
        int start = -1;
        for (int x = from_x; x < to_x; x = next_square(x, to_x)) {
            bool mixed;
            bool wanted = square_kind(r->squares[square_number(tile, x, y)], &mixed) == kind &&
                          (mixed == constants || kind == KIND_CONSTANT);
            if (wanted && start < 0)
                start = x;
            if (start >= 0 && !wanted) {
                add_rectangle(out, start - tile->x, y - tile->y, x - tile->x,
                              next_square(y, to_y) - tile->y);
                start = -1;
            }
        }
        if (start >= 0)
            add_rectangle(out, start - tile->x, y - tile->y, to_x - tile->x,
                          next_square(y, to_y) - tile->y);
    }
}

static void count_fetches(struct weft_fused *r, const struct rectangles *list, enum kind kind)
{
    const struct weft_slice_plan_info *info = &r->plan->info;
    const int depth = r->plan->axes.summed ? 1 : 2;
    const int fetches = kind == KIND_FULL ? info->fetches_per_pixel
                        : kind == KIND_SMOOTH
                            ? 2 * depth * weft_layout_row_fetches(r->plan->info.layout, 2)
                            : 0;
    for (int i = 0; i < list->count; i++)
        r->report.fetches += (uint64_t)(list->at[i][2] - list->at[i][0]) *
                             (uint64_t)(list->at[i][3] - list->at[i][1]) * (uint64_t)fetches;
}

static void draw_rectangles(struct weft_fused *r, GLuint program,
                            const struct weft_slice_tile *tile, int bx, int by,
                            const struct rectangles *list)
{
    weft_slice_grid_bind_block(r->gl, program, &r->plan->footprint->grid, r->plan->axes.order, bx,
                               by);
    r->gl->Uniform2i(weft_gl_location(r->gl, program, "block"), bx * WEFT_GRID_BLOCK - tile->x,
                     by * WEFT_GRID_BLOCK - tile->y);
    r->gl->Uniform4iv(weft_gl_location(r->gl, program, "rectangles"), list->count, list->at[0]);
    r->gl->DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, list->count);
    r->report.passes++;
}

// Draws what wants one kind of shader.
static enum weft_result draw_kind(struct weft_fused *r, const struct weft_slice_tile *tile,
                                  enum kind kind, bool constants)
{
    const int columns = count_cut(tile->x, tile->width, WEFT_GRID_BLOCK);
    const int rows = count_cut(tile->y, tile->height, WEFT_GRID_BLOCK);
    bool bound = false;
    for (int i = 0; i < rows * columns; i++) {
        struct rectangles list;
        int bx = tile->x / WEFT_GRID_BLOCK + i % columns;
        int by = tile->y / WEFT_GRID_BLOCK + i / columns;
        find_rectangles(r, tile, bx, by, kind, constants, &list);
        if (list.count == 0)
            continue;
        if (!r->programs[kind][constants]) {
            enum weft_result res = find_program(r, kind, constants);
            if (res != WEFT_OK)
                return res;
        }
        if (!bound)
            bind_tile(r, r->programs[kind][constants], kind, tile);
        bound = true;
        draw_rectangles(r, r->programs[kind][constants], tile, bx, by, &list);
        count_fetches(r, &list, kind);
    }
    return WEFT_OK;
}

static enum weft_result draw_tile(struct weft_fused *r, int index)
{
    const struct weft_slice_tile *tile = &r->plan->tiles[index];
    double start = weft_now_seconds();
    enum weft_result res = WEFT_OK;
    if (r->sizes.targets)
        weft_gl_targets_bind(r->gl, r->objects->targets, r->sizes.targets, tile->width,
                             tile->height);
    else
        weft_gl_target_bind(r->gl, &r->objects->target, tile->width, tile->height);
    for (int i = 0; res == WEFT_OK && i < 2 * KIND_CONSTANT; i++)
        res = draw_kind(r, tile, (enum kind)(i / 2), i % 2);
    if (res == WEFT_OK)
        res = draw_kind(r, tile, KIND_CONSTANT, true);
    r->gl->Finish();
    r->report.pass_seconds += weft_now_seconds() - start;
    return res == WEFT_OK ? weft_gl_check(r->log, r->gl, "drawing a tile") : res;
}

static enum weft_result read_value(struct weft_fused *r, const struct weft_slice_tile *tile,
                                   const struct weft_rectangle *at,
                                   const struct weft_slice_pixels *pixels)
{
    const struct weft_gl_pixels out = {
        .x = at->x - tile->x,
        .y = at->y - tile->y,
        .width = at->width,
        .height = at->height,
        .type = GL_FLOAT,
        .stride = (int)pixels->stride,
        .data = weft_slice_pixel(r->plan, pixels->at, pixels->stride, at->x, at->y),
    };
    return weft_gl_target_read(r->log, r->gl, &r->objects->target, &out);
}

// Every fourth value to a plane.
static void copy_output(const float *from, int width, float *to)
{
    for (int x = 0; x < width; x++)
        to[x] = from[4 * x];
}

// Rows of texels to rows of the planes of outputs.
static void copy_rows(const struct weft_fused *r, int target, const struct weft_rectangle *at,
                      const struct weft_slice_pixels *pixels)
{
    const int first = 4 * target, rest = r->plan->info.output_count - first;
    for (int y = 0; y < at->height; y++) {
        const float *row = r->rows + (size_t)y * (size_t)at->width * 4;
        float *out = weft_slice_pixel(r->plan, pixels->at, pixels->stride, at->x, at->y + y);
        for (int i = 0; i < 4 && i < rest; i++)
            copy_output(row + i, at->width, out + (first + i) * pixels->plane);
    }
}

static enum weft_result read_outputs(struct weft_fused *r, const struct weft_slice_tile *tile,
                                     const struct weft_rectangle *at,
                                     const struct weft_slice_pixels *pixels)
{
    enum weft_result res = WEFT_OK;
    for (int t = 0; t < r->sizes.targets; t++) {
        struct weft_rectangle rows = *at;
        for (; res == WEFT_OK && rows.y < at->y + at->height; rows.y += READ_ROWS) {
            rows.height = smaller(READ_ROWS, at->y + at->height - rows.y);
            const struct weft_gl_pixels out = {
                .x = rows.x - tile->x,
                .y = rows.y - tile->y,
                .width = rows.width,
                .height = rows.height,
                .type = GL_FLOAT,
                .data = r->rows,
            };
            res = weft_gl_target_read(r->log, r->gl, &r->objects->targets[t], &out);
            if (res == WEFT_OK)
                copy_rows(r, t, &rows, pixels);
        }
    }
    return res;
}

static enum weft_result read_back(struct weft_fused *r, int index,
                                  const struct weft_slice_pixels *pixels)
{
    const struct weft_slice_tile *tile = &r->plan->tiles[index];
    const struct weft_rectangle at = weft_slice_tile_part(r->plan, tile);
    double start = weft_now_seconds();
    const enum weft_result res =
        (r->sizes.targets ? read_outputs : read_value)(r, tile, &at, pixels);
    r->report.readback_seconds += weft_now_seconds() - start;
    return res;
}

// ---- compiling and running ----------------------------------------------------------------------

enum weft_result weft_fused_compile(weft_context *context, const weft_slice_plan *plan,
                                    weft_fused **out)
{
    *out = NULL;
    const struct sizes sizes = largest_sizes(plan);
    weft_fused *r = calloc(1, sizeof *r);
    if (!r) {
        weft_error(plan->log, "not enough memory to compile the slice");
        return WEFT_ERR_MEMORY;
    }
    r->plan = plan;
    r->context = context;
    r->gl = &context->gl;
    r->log = plan->log;
    r->objects = plan->resident ? &plan->resident->objects : &r->own;
    enum weft_result res = check_limits(r, &sizes);
    if (res == WEFT_OK)
        res = weft_context_enter(context);
    if (res != WEFT_OK) {
        free(r);
        return res;
    }
    res = create_buffers(r, &sizes);
    if (res == WEFT_OK)
        res = find_program(r, KIND_FULL, false);
    weft_context_leave(context);
    if (res == WEFT_OK)
        *out = r;
    else
        weft_fused_destroy(&r);
    return res;
}

void weft_fused_destroy(weft_fused **fused)
{
    weft_fused *r = fused ? *fused : NULL;
    if (!r)
        return;
    // What the resident volume keeps is its own.
    if (r->objects == &r->own && weft_context_enter(r->context) == WEFT_OK) {
        weft_fused_objects_destroy(r->gl, &r->own);
        weft_context_leave(r->context);
    }
    weft_slice_layout_destroy(&r->layout);
    weft_slice_blocks_destroy(&r->cells);
    free(r->squares);
    free(r->rows);
    free(r);
    *fused = NULL;
}

// What was drawn to the caller's texture, as it is or from memory.
static enum weft_result hand_over(struct weft_fused *r, const struct weft_slice_tile *tile,
                                  bool painted, struct weft_gl_delivery *to)
{
    const struct weft_rectangle *part = &r->plan->info.part;
    struct weft_rectangle at = weft_slice_tile_part(r->plan, tile);
    const struct weft_gl_drawn drawn = {.texture = r->sizes.targets ? r->objects->targets[0].texture
                                                                    : r->objects->target.texture,
                                        .x = at.x - tile->x,
                                        .y = at.y - tile->y};
    at.x -= part->x;
    at.y -= part->y;
    return painted ? weft_gl_delivery_upload(to, &at) : weft_gl_delivery_draw(to, &drawn, &at);
}

static enum weft_result run_tile(weft_fused *r, int index, struct weft_gl_delivery *to)
{
    enum weft_result res = load_tile(r, index);
    if (res == WEFT_OK)
        res = draw_tile(r, index);
    const bool paints = r->cells.any_unfit;
    if (res == WEFT_OK && paints)
        res = weft_gl_delivery_room(r->log, to);
    const struct weft_slice_pixels pixels = {
        .at = to->at, .stride = to->stride, .plane = to->plane};
    if (res == WEFT_OK && (to->reads || paints))
        res = read_back(r, index, &pixels);
    if (res == WEFT_OK && paints)
        res = weft_slice_exact_paint(r->plan, index, r->own_bytes, &pixels, r->progress,
                                     (index + 1.0) / r->plan->info.tile_count,
                                     &r->report.exact_pixels);
    return res == WEFT_OK ? hand_over(r, &r->plan->tiles[index], paints, to) : res;
}

static enum weft_result run_tiles(weft_fused *r, struct weft_gl_delivery *to)
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

enum weft_result weft_fused_run(weft_fused *r, const struct weft_slice_pixels *pixels,
                                const struct weft_progress *progress,
                                struct weft_fused_report *report)
{
    const struct weft_rectangle *part = &r->plan->info.part;
    struct weft_gl_delivery to = {.width = part->width,
                                  .height = part->height,
                                  .outputs = r->plan->info.output_count,
                                  .at = pixels->at,
                                  .stride = pixels->stride,
                                  .plane = pixels->plane};
    enum weft_result res = weft_context_enter(r->context);
    if (res != WEFT_OK)
        return res;
    r->progress = progress;
    r->report = (struct weft_fused_report){0};
    r->cells.cells_constant = r->cells.cells_smooth = 0;
    res = weft_gl_delivery_begin(r->context, r->log, pixels->texture, &to);
    if (res == WEFT_OK)
        res = fit_objects(r);
    if (res == WEFT_OK)
        res = run_tiles(r, &to);
    weft_gl_delivery_end(&to);
    r->report.cells_constant = r->cells.cells_constant;
    r->report.cells_smooth = r->cells.cells_smooth;
    *report = r->report;
    weft_context_leave(r->context);
    return res;
}
