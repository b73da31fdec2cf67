// SPDX-License-Identifier: BSD-3-Clause
// What the source has where, and what of the result is computed.
#include <stdlib.h>
#include <string.h>

#include "passes/lattice/lattice_impl.h"
#include "tiles/volume/volume_impl.h"

// Sizes of nodes as powers of two, the largest first.
static const int shifts[] = {12, 7, 3};
enum { LEVELS = 3 };

static bool same(float a, float b)
{
    return memcmp(&a, &b, sizeof a) == 0;
}

// ---- the source ---------------------------------------------------------------------------------

static void widen(struct weft_lattice_box *box, bool *any, const int32_t origin[3], int64_t size)
{
    for (int a = 0; a < 3; a++) {
        const int64_t last = origin[a] + size - 1;
        box->min[a] = *any && box->min[a] < origin[a] ? box->min[a] : origin[a];
        box->max[a] = *any && box->max[a] > last ? box->max[a] : last;
    }
    *any = true;
}

// Cells of 128 and 4096 voxels that hold something smaller. false: out of memory.
static bool note_below(struct weft_lattice_plan *plan, const int32_t origin[3], int64_t size)
{
    static const int shift[] = {7, 12};
    for (int i = 0; i < 2; i++) {
        const struct weft_cell_key key = {
            {origin[0] >> shift[i], origin[1] >> shift[i], origin[2] >> shift[i]}};
        if (size < INT64_C(1) << shift[i] &&
            weft_cell_map_add(&plan->below[i], key) == WEFT_CELL_NONE)
            return false;
    }
    return true;
}

static enum weft_result survey(struct weft_lattice_plan *plan, const struct weft_brick_list *list,
                               struct weft_lattice_box *bounds)
{
    bool any = false, noted = true;
    for (size_t i = 0; noted && i < list->brick_count; i++) {
        widen(bounds, &any, list->brick_origin[i], WEFT_BRICK_SIZE);
        noted = note_below(plan, list->brick_origin[i], WEFT_BRICK_SIZE);
    }
    for (size_t i = 0; noted && i < list->tile_count; i++) {
        if (!same(list->tiles[i].value, plan->background))
            widen(bounds, &any, list->tiles[i].origin, list->tiles[i].size);
        noted = note_below(plan, list->tiles[i].origin, list->tiles[i].size);
    }
    plan->info.bricks_in = list->brick_count;
    plan->info.tiles_in = list->tile_count;
    plan->info.empty = !any;
    if (noted)
        return WEFT_OK;
    weft_error(plan->log, "not enough memory for where %zu bricks lie", list->brick_count);
    return WEFT_ERR_MEMORY;
}

enum weft_result weft_lattice_find(struct weft_lattice_plan *plan, struct weft_lattice_box *bounds)
{
    static const struct weft_region all = {
        .min = {-WEFT_INDEX_LIMIT, -WEFT_INDEX_LIMIT, -WEFT_INDEX_LIMIT},
        .max = {WEFT_INDEX_LIMIT, WEFT_INDEX_LIMIT, WEFT_INDEX_LIMIT}};
    struct weft_brick_list list = {0};
    enum weft_result res = WEFT_OK;
    const bool borrowed = weft_brick_reader_borrow(plan->log, plan->source, &plan->reader);
    if (!borrowed)
        res = weft_brick_reader_open(plan->log, plan->source, &all, &plan->reader);
    else
        res = weft_volume_find(plan->source, &all, &list);
    if (res == WEFT_OK)
        res = survey(plan, borrowed ? &list : &plan->reader.topology, bounds);
    weft_brick_list_clear(&list);
    return res;
}

// ---- kernels' footprints ------------------------------------------------------------------------

struct weft_lattice_box weft_lattice_footprint(const struct weft_lattice_plan *plan,
                                               const struct weft_lattice_box *box)
{
    double min[3], max[3], low[3], high[3];
    struct weft_lattice_box out;
    for (int a = 0; a < 3; a++) {
        min[a] = (double)box->min[a];
        max[a] = (double)box->max[a];
    }
    weft_lattice_map_box(plan->info.to_source, min, max, low, high);
    for (int a = 0; a < 3; a++) {
        out.min[a] = (int64_t)ceil(low[a] - plan->reach[a] - 0x1p-30);
        out.max[a] = (int64_t)floor(high[a] + plan->reach[a] + 0x1p-30);
    }
    return out;
}

// What a part of the source is, as far as it has been looked at.
struct look {
    const struct weft_lattice_plan *plan;
    struct weft_lattice_box box;
    bool any; // something was
    float value;
};

static bool add_value(struct look *look, float value)
{
    if (look->any && !same(look->value, value))
        return false;
    look->any = true;
    look->value = value;
    return true;
}

static bool is_below(const struct weft_lattice_plan *plan, int level, const int32_t origin[3])
{
    const int shift = shifts[level];
    const struct weft_cell_key key = {{origin[0] >> shift, origin[1] >> shift, origin[2] >> shift}};
    return level < 2 && weft_cell_map_find(&plan->below[1 - level], key) != WEFT_CELL_NONE;
}

// false: not all of it has one value.
static bool look_into(struct look *look, int level, const struct weft_lattice_box *part)
{
    const int shift = shifts[level];
    int64_t from[3], to[3], at[3];
    for (int a = 0; a < 3; a++) {
        from[a] = part->min[a] >> shift;
        to[a] = part->max[a] >> shift;
    }
    for (at[2] = from[2]; at[2] <= to[2]; at[2]++)
        for (at[1] = from[1]; at[1] <= to[1]; at[1]++)
            for (at[0] = from[0]; at[0] <= to[0]; at[0]++) {
                struct weft_lattice_box cell;
                int32_t origin[3];
                const float *values;
                float constant;
                for (int a = 0; a < 3; a++) {
                    const int64_t first = at[a] * (INT64_C(1) << shift);
                    const int64_t last = first + (INT64_C(1) << shift) - 1;
                    origin[a] = (int32_t)first;
                    cell.min[a] = first > part->min[a] ? first : part->min[a];
                    cell.max[a] = last < part->max[a] ? last : part->max[a];
                }
                if (is_below(look->plan, level, origin)) {
                    if (!look_into(look, level + 1, &cell))
                        return false;
                } else if (weft_brick_store_find(look->plan->reader.places, origin, &values,
                                                 &constant) != WEFT_BRICK_CONSTANT ||
                           !add_value(look, constant)) {
                    return false;
                }
            }
    return true;
}

// Whether all that kernels of a box of the result meet has one value.
static bool is_constant(const struct weft_lattice_plan *plan, const struct weft_lattice_box *box,
                        float *value)
{
    struct look look = {.plan = plan, .box = weft_lattice_footprint(plan, box)};
    const int64_t least = -WEFT_INDEX_LIMIT, most = WEFT_INDEX_LIMIT - 1;
    bool inside = true, outside = plan->clamped;
    if (outside)
        return false;
    for (int a = 0; a < 3; a++) {
        inside = inside && look.box.min[a] >= least && look.box.max[a] <= most;
        outside = outside || look.box.max[a] < least || look.box.min[a] > most;
        look.box.min[a] = look.box.min[a] > least ? look.box.min[a] : least;
        look.box.max[a] = look.box.max[a] < most ? look.box.max[a] : most;
    }
    if (!inside)
        add_value(&look, plan->background);
    if (!outside && !look_into(&look, 0, &look.box))
        return false;
    *value = look.value;
    return true;
}

// ---- the result ---------------------------------------------------------------------------------

void weft_lattice_list_clear(struct weft_lattice_list *list)
{
    free(list->brick);
    free(list->tile);
    *list = (struct weft_lattice_list){0};
}

static bool grow(void **items, size_t *capacity, size_t count, size_t size)
{
    if (count < *capacity)
        return true;
    const size_t wanted = *capacity ? 2 * *capacity : 256;
    void *grown = realloc(*items, wanted * size);
    if (!grown)
        return false;
    *items = grown;
    *capacity = wanted;
    return true;
}

static bool add_tile(struct weft_lattice_list *list, const int64_t origin[3], int32_t size,
                     float value)
{
    if (!grow((void **)&list->tile, &list->tile_capacity, list->tile_count, sizeof *list->tile))
        return false;
    list->tile[list->tile_count++] = (struct weft_volume_tile){
        {(int32_t)origin[0], (int32_t)origin[1], (int32_t)origin[2]}, size, value};
    return true;
}

static bool add_brick(struct weft_lattice_list *list, const int64_t origin[3])
{
    if (!grow((void **)&list->brick, &list->brick_capacity, list->brick_count, sizeof *list->brick))
        return false;
    for (int a = 0; a < 3; a++)
        list->brick[list->brick_count][a] = (int32_t)origin[a];
    list->brick_count++;
    return true;
}

struct walk {
    const struct weft_lattice_plan *plan;
    struct weft_lattice_list *list;
    struct weft_lattice_box layer; // all that is walked through
};

// A node that overlaps the layer and the result's box. Tiles are where they begin.
static bool walk_node(const struct walk *walk, int level, const int64_t origin[3]);

static bool walk_nodes(const struct walk *walk, int level, const struct weft_lattice_box *part)
{
    const int64_t size = INT64_C(1) << shifts[level];
    int64_t at[3];
    for (at[2] = part->min[2] & -size; at[2] <= part->max[2]; at[2] += size)
        for (at[1] = part->min[1] & -size; at[1] <= part->max[1]; at[1] += size)
            for (at[0] = part->min[0] & -size; at[0] <= part->max[0]; at[0] += size)
                if (!walk_node(walk, level, at))
                    return false;
    return true;
}

static bool walk_node(const struct walk *walk, int level, const int64_t origin[3])
{
    const struct weft_lattice_info *info = &walk->plan->info;
    const int64_t size = INT64_C(1) << shifts[level];
    struct weft_lattice_box node, part;
    bool whole = true, begins = true;
    float value;
    for (int a = 0; a < 3; a++) {
        const int64_t low = origin[a], high = origin[a] + size - 1;
        node.min[a] = low > info->box_min[a] ? low : info->box_min[a];
        node.max[a] = high < info->box_max[a] ? high : info->box_max[a];
        whole = whole && !(walk->plan->boxed && (node.min[a] > low || node.max[a] < high));
        begins = begins && low >= walk->layer.min[a] && low <= walk->layer.max[a];
        part.min[a] = low > walk->layer.min[a] ? low : walk->layer.min[a];
        part.max[a] = high < walk->layer.max[a] ? high : walk->layer.max[a];
        if (node.min[a] > node.max[a])
            return true;
        // A tile has voxels past the box where nothing is active, too.
        node.min[a] = walk->plan->boxed ? node.min[a] : low;
        node.max[a] = walk->plan->boxed ? node.max[a] : high;
    }
    if (is_constant(walk->plan, &node, &value)) {
        if (same(value, walk->plan->background))
            return true;
        if (whole)
            return !begins || add_tile(walk->list, origin, (int32_t)size, value);
    }
    return level == LEVELS - 1 ? add_brick(walk->list, origin) : walk_nodes(walk, level + 1, &part);
}

static int compare_bricks(const void *a, const void *b)
{
    return weft_compare_origins(a, b);
}

enum weft_result weft_lattice_walk(const struct weft_lattice_plan *plan, int32_t z, int32_t y,
                                   struct weft_lattice_list *list)
{
    const struct weft_lattice_info *info = &plan->info;
    const struct walk walk = {.plan = plan,
                              .list = list,
                              .layer = {{info->box_min[0] & -WEFT_BRICK_SIZE, y, z},
                                        {info->box_max[0] | (WEFT_BRICK_SIZE - 1),
                                         y + WEFT_LATTICE_STRIP - 1, z + WEFT_BRICK_SIZE - 1}}};
    const size_t before = list->brick_count;
    if (!walk_nodes(&walk, 0, &walk.layer)) {
        weft_error(plan->log, "not enough memory for a list of %zu bricks", list->brick_count);
        return WEFT_ERR_MEMORY;
    }
    if (list->brick_count > before) // of no bricks there is no list
        qsort(list->brick + before, list->brick_count - before, sizeof *list->brick,
              compare_bricks);
    return WEFT_OK;
}
