// SPDX-License-Identifier: BSD-3-Clause
// Coefficients of a volume's voxels, computed when they are read. A recursion along whole lines
// would make every coefficient depend, in its last bits, on where the lines begin, so on what else
// is asked for. Here the inverse filter's impulse response is cut off and applied directly: three
// passes in a fixed order and in fixed sums, each voxel's result depending on nothing but the
// voxels within the overlap.
#include "tiles/volume/volume.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/kernels/prefilter.h"
#include "tiles/volume/cell_map.h"
#include "tiles/volume/block_layout.h"
#include "tiles/volume/region.h"
#include "tiles/volume/volume_impl.h"

// Voxels along a side of the aligned cubes whose bricks are computed together.
enum { CUBE = 64 };

struct coefficients {
    weft_volume *base; // the caller's
    int overlap;
    double taps[WEFT_PREFILTER_MAX_OVERLAP + 1];
    double magnitudes[WEFT_PREFILTER_MAX_OVERLAP + 1]; // of the taps
};

static const struct coefficients *coefficients_of(const weft_volume *volume)
{
    return volume->data;
}

static int32_t clamp(int64_t x, int64_t low, int64_t high)
{
    return (int32_t)(x < low ? low : x > high ? high : x);
}

static enum weft_result out_of_memory(const weft_volume *volume, size_t count, const char *what)
{
    weft_error(volume->log, "not enough memory for %zu %s of coefficients", count, what);
    return WEFT_ERR_MEMORY;
}

// ---- what lies where ----------------------------------------------------------------------------

// Bricks around a base brick that its voxels change.
static int ring_count(const weft_volume *volume)
{
    return (coefficients_of(volume)->overlap + WEFT_BRICK_SIZE - 1) / WEFT_BRICK_SIZE;
}

static void child_origin(const int32_t origin[3], int32_t size, int child, int32_t out[3])
{
    for (int a = 0; a < 3; a++)
        out[a] = origin[a] + (child >> a & 1 ? size : 0);
}

static bool add_brick(struct weft_cell_map *map, const int32_t origin[3])
{
    const struct weft_cell_key key = {{origin[0] >> 3, origin[1] >> 3, origin[2] >> 3}};
    return weft_cell_map_add(map, key) != WEFT_CELL_NONE;
}

// Whether a cube in a tile keeps `margin` voxels from all of its faces.
static bool keeps_clear(const struct weft_volume_tile *tile, const int32_t origin[3], int32_t size,
                        int32_t margin)
{
    for (int a = 0; a < 3; a++)
        if (origin[a] < tile->origin[a] + margin ||
            origin[a] + size > tile->origin[a] + tile->size - margin)
            return false;
    return true;
}

// The outermost bricks of a tile, starting with the cube that it is.
static bool add_border(const struct weft_region *region, const struct weft_volume_tile *tile,
                       const int32_t origin[3], int32_t size, struct weft_cell_map *map)
{
    if (!weft_region_meets(region, origin, size) || keeps_clear(tile, origin, size, 1))
        return true;
    if (size == WEFT_BRICK_SIZE)
        return add_brick(map, origin);
    for (int child = 0; child < 8; child++) {
        int32_t at[3];
        child_origin(origin, size / 2, child, at);
        if (!add_border(region, tile, at, size / 2, map))
            return false;
    }
    return true;
}

// The parts of a tile where the coefficients are its value, as tiles: all but the bricks in `map`.
struct insides {
    const struct weft_region *region;
    const struct weft_cell_map *map;
    int32_t margin;
    struct weft_brick_list *list;
    size_t capacity;
};

static bool add_tile(struct insides *in, const int32_t origin[3], int32_t size, float value)
{
    struct weft_brick_list *list = in->list;
    if (list->tile_count == in->capacity) {
        in->capacity = in->capacity ? 2 * in->capacity : 64;
        void *tiles = realloc(list->tiles, in->capacity * sizeof *list->tiles);
        if (!tiles)
            return false;
        list->tiles = tiles;
    }
    list->tiles[list->tile_count++] = (struct weft_volume_tile){
        .origin = {origin[0], origin[1], origin[2]}, .size = size, .value = value};
    return true;
}

static bool add_inside(struct insides *in, const struct weft_volume_tile *tile,
                       const int32_t origin[3], int32_t size)
{
    if (!weft_region_meets(in->region, origin, size))
        return true;
    if (size == WEFT_BRICK_SIZE) {
        const struct weft_cell_key key = {{origin[0] >> 3, origin[1] >> 3, origin[2] >> 3}};
        return weft_cell_map_find(in->map, key) != WEFT_CELL_NONE ||
               add_tile(in, origin, size, tile->value);
    }
    if (size == 128 && keeps_clear(tile, origin, size, in->margin))
        return add_tile(in, origin, size, tile->value);
    for (int child = 0; child < 8; child++) {
        int32_t at[3];
        child_origin(origin, size / 2, child, at);
        if (!add_inside(in, tile, at, size / 2))
            return false;
    }
    return true;
}

static bool dilate(const struct weft_cell_map *in, int axis, int rings, struct weft_cell_map *out)
{
    for (size_t i = 0; i < in->count; i++) {
        for (int step = -rings; step <= rings; step++) {
            struct weft_cell_key key = in->keys[i];
            key.at[axis] += step;
            if (weft_cell_map_add(out, key) == WEFT_CELL_NONE)
                return false;
        }
    }
    return true;
}

// Bricks that are not constant, and the rings of bricks around them.
static bool find_changing(const struct weft_region *region, const struct weft_brick_list *base,
                          int rings, struct weft_cell_map *out)
{
    struct weft_cell_map maps[3] = {0};
    bool done = true;
    for (size_t i = 0; done && i < base->brick_count; i++)
        done = add_brick(&maps[0], base->brick_origin[i]);
    for (size_t i = 0; done && i < base->tile_count; i++)
        done = add_border(region, &base->tiles[i], base->tiles[i].origin, base->tiles[i].size,
                          &maps[0]);
    for (int a = 0; done && a < 3; a++)
        done = dilate(&maps[a], a, rings, a < 2 ? &maps[a + 1] : out);
    for (int a = 0; a < 3; a++)
        weft_cell_map_destroy(&maps[a]);
    return done;
}

static int compare_origins(const void *a, const void *b)
{
    return weft_compare_origins(a, b);
}

static int compare_tiles(const void *a, const void *b)
{
    const struct weft_volume_tile *x = a, *y = b;
    return weft_compare_origins(x->origin, y->origin);
}

static bool list_bricks(const struct weft_region *region, const struct weft_cell_map *map,
                        struct weft_brick_list *out)
{
    out->brick_origin = malloc(map->count * sizeof *out->brick_origin + 1);
    if (!out->brick_origin)
        return false;
    for (size_t i = 0; i < map->count; i++) {
        int32_t *origin = out->brick_origin[out->brick_count];
        for (int a = 0; a < 3; a++)
            origin[a] = map->keys[i].at[a] * WEFT_BRICK_SIZE;
        out->brick_count += weft_region_meets(region, origin, WEFT_BRICK_SIZE);
    }
    qsort(out->brick_origin, out->brick_count, sizeof *out->brick_origin, compare_origins);
    return true;
}

static enum weft_result find_sparse(weft_volume *volume, const struct weft_region *region,
                                    struct weft_brick_list *out)
{
    const int rings = ring_count(volume);
    // Every base brick within the rings of a brick that meets the region meets this.
    const struct weft_region wide = weft_region_widen(region, rings * WEFT_BRICK_SIZE);
    struct weft_brick_list base = {0};
    struct weft_cell_map map = {0};
    struct insides in = {region, &map, (rings + 1) * WEFT_BRICK_SIZE, out, 0};
    enum weft_result res = weft_volume_find(coefficients_of(volume)->base, &wide, &base);
    if (res != WEFT_OK)
        return res;
    bool done = find_changing(&wide, &base, rings, &map) && list_bricks(region, &map, out);
    for (size_t i = 0; done && i < base.tile_count; i++)
        done = add_inside(&in, &base.tiles[i], base.tiles[i].origin, base.tiles[i].size);
    if (done && out->tile_count)
        qsort(out->tiles, out->tile_count, sizeof *out->tiles, compare_tiles);
    if (!done) {
        res = out_of_memory(volume, map.count, "bricks");
        weft_brick_list_clear(out);
    }
    weft_brick_list_clear(&base);
    weft_cell_map_destroy(&map);
    return res;
}

// All bricks of the box, which is the base's with the overlap around it.
static enum weft_result find_clamped(weft_volume *volume, const struct weft_region *region,
                                     struct weft_brick_list *out)
{
    const struct weft_volume_info *info = &volume->info;
    int32_t first[3], last[3], at[3];
    size_t count = 1;
    for (int a = 0; a < 3; a++) {
        first[a] = clamp(region->min[a], info->active_min[a], info->active_max[a]) & ~7;
        last[a] = clamp(region->max[a], info->active_min[a], info->active_max[a]) & ~7;
        if (region->min[a] > region->max[a] ||
            !weft_size_mul(count, (size_t)((last[a] - first[a]) / 8 + 1), &count))
            return WEFT_OK;
    }
    out->brick_origin = malloc(count * sizeof *out->brick_origin);
    if (!out->brick_origin)
        return out_of_memory(volume, count, "bricks");
    for (at[2] = first[2]; at[2] <= last[2]; at[2] += WEFT_BRICK_SIZE)
        for (at[1] = first[1]; at[1] <= last[1]; at[1] += WEFT_BRICK_SIZE)
            for (at[0] = first[0]; at[0] <= last[0]; at[0] += WEFT_BRICK_SIZE)
                if (weft_volume_brick_meets(info, region, at))
                    memcpy(out->brick_origin[out->brick_count++], at, sizeof at);
    return WEFT_OK;
}

static enum weft_result find(weft_volume *volume, const struct weft_region *region,
                             struct weft_brick_list *out)
{
    return volume->info.clamp_to_edge ? find_clamped(volume, region, out)
                                      : find_sparse(volume, region, out);
}

// ---- computing ----------------------------------------------------------------------------------

// Base voxels, and coefficients of the box without the overlap around it.
struct box {
    int32_t min[3];
    int size[3];
    float *voxels;
};

static size_t count_of(const int size[3])
{
    return (size_t)size[0] * (size_t)size[1] * (size_t)size[2];
}

static enum weft_result load_voxels(weft_volume *volume, struct box *box)
{
    weft_volume *base = coefficients_of(volume)->base;
    const struct weft_volume_info *info = &base->info;
    struct weft_region region = {.slab_count = 0};
    struct weft_brick_list list = {0};
    weft_brick_store *store = NULL;
    float *values = NULL;
    for (int a = 0; a < 3; a++) {
        const int32_t last = box->min[a] + box->size[a] - 1;
        const bool clamped = info->clamp_to_edge;
        region.min[a] =
            clamped ? clamp(box->min[a], info->active_min[a], info->active_max[a]) : box->min[a];
        region.max[a] = clamped ? clamp(last, info->active_min[a], info->active_max[a]) : last;
    }
    enum weft_result res = weft_volume_find(base, &region, &list);
    if (res != WEFT_OK)
        goto fail;
    values = malloc(list.brick_count * WEFT_BRICK_VOXELS * sizeof *values + 1);
    if (!values) {
        res = out_of_memory(volume, list.brick_count, "bricks");
        goto fail;
    }
    res = weft_volume_read(base, list.brick_count, (const int32_t(*)[3])list.brick_origin, values);
    if (res == WEFT_OK)
        res = weft_brick_store_create(volume->log, list.brick_count + list.tile_count,
                                      info->background, &store);
    if (res == WEFT_OK)
        res = weft_brick_store_add_list(store, &list, values);
    if (res != WEFT_OK)
        goto fail;
    if (info->clamp_to_edge)
        weft_brick_store_clamp(store, info->active_min, info->active_max);
    weft_brick_store_copy_box(store, box->min, box->size, box->size, NULL, box->voxels);
fail:
    weft_brick_store_destroy(&store);
    weft_brick_list_clear(&list);
    free(values);
    return res;
}

// out[i] = sum_k taps[|k|] in[i + k step], always in the same order.
static void filter_row(const double *taps, int overlap, const double *restrict in, size_t step,
                       size_t count, double *restrict out)
{
    for (size_t i = 0; i < count; i++)
        out[i] = taps[0] * in[i];
    for (int k = 1; k <= overlap; k++) {
        const double *before = in - (size_t)k * step, *after = in + (size_t)k * step;
        for (size_t i = 0; i < count; i++)
            out[i] += taps[k] * (before[i] + after[i]);
    }
}

// Filters along an axis, which gets shorter by twice the overlap.
static void filter_axis(const double *taps, int overlap, int axis, int size[3], const double *in,
                        double *out)
{
    const size_t row = (size_t)size[0], plane = row * (size_t)size[1], n = (size_t)overlap;
    const size_t step = axis == 2 ? plane : axis == 1 ? row : 1;
    size[axis] -= 2 * overlap;
    for (int z = 0; z < size[2]; z++) {
        for (int y = 0; y < size[1]; y++) {
            filter_row(taps, overlap, in + (size_t)z * plane + (size_t)y * row + n * step, step,
                       (size_t)size[0], out);
            out += size[0];
        }
    }
}

// Along all axes, from `whole` by way of itself to `part`.
static void filter_box(const double *taps, int overlap, const struct box *box, double *whole,
                       double *part)
{
    int size[3] = {box->size[0], box->size[1], box->size[2]};
    filter_axis(taps, overlap, 2, size, whole, part);
    filter_axis(taps, overlap, 1, size, part, whole);
    filter_axis(taps, overlap, 0, size, whole, part);
}

// Makes coefficients that depend on missing voxels missing, too. The sums are those of the voxels
// within the overlap, always in the same order, so that they do not depend on the box.
static void mark_missing(const struct coefficients *c, const struct box *box, double *whole,
                         double *sums, double *coefficients)
{
    const size_t voxels = count_of(box->size);
    const int inner[3] = {box->size[0] - 2 * c->overlap, box->size[1] - 2 * c->overlap,
                          box->size[2] - 2 * c->overlap};
    for (size_t i = 0; i < voxels; i++)
        whole[i] = isfinite(box->voxels[i]) ? 0.0 : 1.0;
    filter_box(c->magnitudes, c->overlap, box, whole, sums);
    for (size_t i = 0; i < count_of(inner); i++)
        if (sums[i] > WEFT_PREFILTER_MISSING)
            coefficients[i] = NAN;
}

// A missing voxel stays what it is: NaN or an infinity.
static void copy_brick(const struct box *box, int overlap, const double *coefficients,
                       const int32_t origin[3], float *out)
{
    int at[3], inner[3];
    for (int a = 0; a < 3; a++) {
        at[a] = origin[a] - box->min[a];
        inner[a] = box->size[a] - 2 * overlap;
    }
    for (int v = 0; v < WEFT_BRICK_VOXELS; v++) {
        const size_t x = (size_t)(at[0] + (v & 7)), y = (size_t)(at[1] + (v >> 3 & 7)),
                     z = (size_t)(at[2] + (v >> 6)), n = (size_t)overlap;
        const float voxel = box->voxels[(z * (size_t)box->size[1] + y) * (size_t)box->size[0] + x];
        out[v] =
            isfinite(voxel)
                ? (float)coefficients[((z - n) * (size_t)inner[1] + (y - n)) * (size_t)inner[0] +
                                      (x - n)]
                : voxel;
    }
}

struct order {
    int32_t cube[3];
    size_t index;
};

static int compare_order(const void *a, const void *b)
{
    const struct order *x = a, *y = b;
    const int order = weft_compare_origins(x->cube, y->cube);
    return order ? order : (x->index > y->index) - (x->index < y->index);
}

static void set_box(const struct order *order, size_t count, const int32_t (*origin)[3],
                    int overlap, struct box *box)
{
    for (int a = 0; a < 3; a++) {
        int32_t low = origin[order[0].index][a], high = low;
        for (size_t i = 1; i < count; i++) {
            const int32_t at = origin[order[i].index][a];
            low = at < low ? at : low;
            high = at > high ? at : high;
        }
        box->min[a] = low - overlap;
        box->size[a] = high + WEFT_BRICK_SIZE - low + 2 * overlap;
    }
}

// The bricks of one cube.
static enum weft_result compute_bricks(weft_volume *volume, const struct order *order, size_t count,
                                       const int32_t (*origin)[3], float *values)
{
    const struct coefficients *c = volume->data;
    struct box box = {.voxels = NULL};
    double *whole = NULL, *part = NULL, *sums = NULL;
    size_t missing = 0;
    enum weft_result res = WEFT_ERR_MEMORY;
    set_box(order, count, origin, c->overlap, &box);
    const size_t voxels = count_of(box.size);
    const size_t room = voxels / (size_t)box.size[2] * (size_t)(box.size[2] - 2 * c->overlap);
    box.voxels = malloc(voxels * sizeof *box.voxels);
    whole = malloc(voxels * sizeof *whole);
    part = malloc(room * sizeof *part);
    if (!box.voxels || !whole || !part)
        goto no_memory;
    res = load_voxels(volume, &box);
    if (res != WEFT_OK)
        goto fail;
    for (size_t i = 0; i < voxels; i++) {
        whole[i] = isfinite(box.voxels[i]) ? (double)box.voxels[i] : 0.0;
        missing += !isfinite(box.voxels[i]);
    }
    filter_box(c->taps, c->overlap, &box, whole, part);
    if (missing) {
        sums = malloc(room * sizeof *sums);
        if (!sums)
            goto no_memory;
        mark_missing(c, &box, whole, sums, part);
    }
    for (size_t i = 0; i < count; i++)
        copy_brick(&box, c->overlap, part, origin[order[i].index],
                   values + order[i].index * WEFT_BRICK_VOXELS);
    res = WEFT_OK;
    goto fail;
no_memory:
    res = out_of_memory(volume, voxels, "voxels");
fail:
    free(box.voxels);
    free(whole);
    free(part);
    free(sums);
    return res;
}

static enum weft_result read(weft_volume *volume, size_t count, const int32_t (*brick_origin)[3],
                             float *values)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    struct order *order = malloc(count * sizeof *order + 1);
    if (!order) {
        res = out_of_memory(volume, count, "bricks");
        goto fail;
    }
    for (size_t i = 0; i < count; i++) {
        order[i].index = i;
        for (int a = 0; a < 3; a++) {
            const int32_t at = brick_origin[i][a];
            weft_require(volume->log, at % WEFT_BRICK_SIZE == 0 && at >= -WEFT_INDEX_LIMIT &&
                                          at < WEFT_INDEX_LIMIT);
            order[i].cube[a] = at & ~(CUBE - 1);
        }
    }
    qsort(order, count, sizeof *order, compare_order);
    res = WEFT_OK;
    for (size_t from = 0, to; from < count && res == WEFT_OK; from = to) {
        for (to = from + 1; to < count && !weft_compare_origins(order[from].cube, order[to].cube);)
            to++;
        res = compute_bricks(volume, order + from, to - from, brick_origin, values);
    }
fail:
    free(order);
    return res;
}

static void clear(void *data)
{
    (void)data; // the base is the caller's
}

static const struct weft_volume_backend backend = {
    .data_bytes = sizeof(struct coefficients), .find = find, .read = read, .clear = clear};

// ---- making -------------------------------------------------------------------------------------

static enum weft_result widen_box(weft_volume *volume)
{
    struct weft_volume_info *info = &volume->info;
    const int overlap = coefficients_of(volume)->overlap;
    for (int a = 0; a < 3; a++) {
        // Of whole bricks: rings, and the one that the box ends in.
        const int64_t margin = (ring_count(volume) + 1) * WEFT_BRICK_SIZE;
        const int64_t low = info->active_min[a] - margin, high = info->active_max[a] + margin;
        if (low < -WEFT_INDEX_LIMIT || high > WEFT_INDEX_LIMIT) {
            weft_error(volume->log,
                       "coefficients from %lld to %lld; index coordinates are limited to +-%d",
                       (long long)low, (long long)high, WEFT_INDEX_LIMIT);
            return WEFT_ERR_LIMIT;
        }
        info->active_min[a] -= overlap;
        info->active_max[a] += overlap;
    }
    return WEFT_OK;
}

enum weft_result weft_volume_prefilter(const struct weft_log *log, weft_volume *volume,
                                       const struct weft_kernel *kernel, weft_volume **out)
{
    *out = NULL;
    struct weft_prefilter prefilter;
    weft_volume *v = NULL;
    struct coefficients *c;
    enum weft_result res = weft_prefilter_compute(log, kernel, &prefilter);
    if (res == WEFT_OK)
        res = weft_volume_make(log, &backend, &v);
    if (res != WEFT_OK)
        goto fail;
    c = v->data;
    v->info = volume->info;
    v->info.metadata_count = 0;
    v->info.metadata = NULL;
    c->base = volume;
    c->overlap = weft_prefilter_overlap(&prefilter, WEFT_VOLUME_PREFILTER_ERROR);
    weft_prefilter_taps(&prefilter, c->overlap, c->taps);
    for (int k = 0; k <= c->overlap; k++)
        c->magnitudes[k] = fabs(c->taps[k]);
    res = v->info.empty ? WEFT_OK : widen_box(v);
    if (res != WEFT_OK)
        goto fail;
    *out = v;
    return WEFT_OK;
fail:
    weft_volume_destroy(&v);
    return res;
}
