// SPDX-License-Identifier: BSD-3-Clause
#include "passes/slice/plane.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "filter/threads.h"
#include "passes/fused/exact.h"

// Fewer voxels than this are summed sooner than a thread starts.
enum { SIDE = WEFT_BRICK_SIZE, PART_VOXELS = 1 << 16 };

enum { PAIR = 2, QUAD = 4 };
typedef double doubles __attribute__((vector_size(PAIR * sizeof(double))));
typedef int32_t bits __attribute__((vector_size(QUAD * sizeof(int32_t))));

// ---- planes -------------------------------------------------------------------------------------

void weft_slice_plane_destroy(struct weft_slice_plane *p)
{
    free(p->samples);
    free(p->wide);
    free(p->x);
    free(p->y);
    *p = (struct weft_slice_plane){0};
}

static enum weft_result out_of_memory(const struct weft_slice_plan *plan,
                                      struct weft_slice_plane *p)
{
    weft_error(plan->log, "not enough memory for a plane of %d x %d samples", p->size[0],
               p->size[1]);
    weft_slice_plane_destroy(p);
    return WEFT_ERR_MEMORY;
}

enum weft_result weft_slice_plane_place(const struct weft_slice_plan *plan,
                                        const struct weft_slice_tile *tile,
                                        struct weft_slice_plane *p)
{
    const struct weft_slice_axes *axes = &plan->axes;
    const struct weft_slice_grid *grid = &plan->footprint->grid;
    const struct weft_rectangle at = {tile->x, tile->y, tile->width, tile->height};
    *p = (struct weft_slice_plane){0};
    weft_slice_axes_box(axes, &plan->info.kernel, grid, &at, p->min, p->max);
    for (int i = 0; i < 2; i++)
        p->size[i] = p->max[axes->order[i]] - p->min[axes->order[i]] + 1;
    p->x = malloc((size_t)tile->width * sizeof *p->x);
    p->y = malloc((size_t)tile->height * sizeof *p->y);
    if (!p->x || !p->y)
        return out_of_memory(plan, p);
    for (int i = 0; i < tile->width; i++)
        p->x[i] = weft_slice_axes_coordinate(axes, grid, 0, tile->x + i) - p->min[axes->order[0]];
    for (int i = 0; i < tile->height; i++)
        p->y[i] = weft_slice_axes_coordinate(axes, grid, 1, tile->y + i) - p->min[axes->order[1]];
    return WEFT_OK;
}

enum weft_result weft_slice_plane_create(const struct weft_slice_plan *plan,
                                         const struct weft_slice_tile *tile,
                                         struct weft_slice_plane *p)
{
    const enum weft_result res = weft_slice_plane_place(plan, tile, p);
    if (res != WEFT_OK)
        return res;
    const size_t count = (size_t)p->size[0] * (size_t)p->size[1];
    if (plan->info.sums == WEFT_SUMS_DOUBLE)
        p->wide = malloc(count * sizeof *p->wide);
    else
        p->samples = malloc(count * sizeof *p->samples);
    return p->wide || p->samples ? WEFT_OK : out_of_memory(plan, p);
}

// ---- sums ---------------------------------------------------------------------------------------

struct filling {
    const struct weft_slice_plan *plan;
    const weft_brick_store *store;
    struct weft_slice_plane *plane;
    atomic_bool unfit;
};

// Samples of one brick along rows and columns.
struct square {
    int from[2], size[2];                      // within the brick
    int at[2];                                 // of the plane's samples
    const float *layer[WEFT_KERNEL_MAX_WIDTH]; // each summed layer's voxel 0
    int step[2];                               // of voxels along rows and columns
    float made[3][WEFT_BRICK_VOXELS];          // bricks that nobody keeps
};

// The bricks along the summed axis, and in them the layers.
static void find_layers(const struct filling *f, int32_t origin[3], struct square *s)
{
    const struct weft_slice_axes *axes = &f->plan->axes;
    const int depth = axes->order[2];
    static const int step[3] = {1, SIDE, SIDE * SIDE};
    const float *values = NULL;
    int made = 0;
    for (int k = 0; k < axes->kept; k++) {
        const int32_t at = (int32_t)axes->plane + k;
        if (k == 0 || at % SIDE == 0) {
            float constant;
            origin[depth] = at & ~(SIDE - 1);
            if (weft_brick_store_find(f->store, origin, &values, &constant) != WEFT_BRICK_VALUES) {
                weft_brick_store_copy(f->store, origin, s->made[made]);
                values = s->made[made++];
            }
        }
        s->layer[k] = values + (at & (SIDE - 1)) * step[depth];
    }
    s->step[0] = step[axes->order[0]];
    s->step[1] = step[axes->order[1]];
}

// Up to eight samples side by side, of which some voxels may be unfit: those count as 0, and the
// result is false.
static bool sum_some(const struct filling *f, const struct square *s, int first, double sum[SIDE])
{
    const struct weft_slice_axes *axes = &f->plan->axes;
    bool fit = true;
    memset(sum, 0, SIDE * sizeof *sum);
    for (int k = 0; k < axes->kept; k++) {
        for (int x = 0; x < s->size[0]; x++) {
            const float voxel = s->layer[k][first + x * s->step[0]];
            const bool unfit = weft_slice_unfit(f->plan, voxel);
            sum[x] += unfit ? 0.0 : axes->weight[k] * (double)voxel;
            fit &= !unfit;
        }
    }
    return fit;
}

// The same sums of eight voxels that lie side by side in their bricks, where all are fit; false:
// one is not.
static bool sum_eight(const struct filling *f, const struct square *s, int first, double sum[SIDE])
{
    const struct weft_slice_axes *axes = &f->plan->axes;
    int32_t limit;
    memcpy(&limit, &f->plan->largest_fit, sizeof limit);
    doubles part[SIDE / PAIR] = {{0}};
    bits unfit = {0};
    for (int k = 0; k < axes->kept; k++) {
        const float *voxel = s->layer[k] + first;
        bits magnitude[SIDE / QUAD];
        memcpy(magnitude, voxel, sizeof magnitude);
        for (int i = 0; i < SIDE / QUAD; i++)
            unfit |= (magnitude[i] & INT32_MAX) > limit;
        for (int i = 0; i < SIDE / PAIR; i++)
            part[i] +=
                axes->weight[k] * (doubles){(double)voxel[PAIR * i], (double)voxel[PAIR * i + 1]};
    }
    memcpy(sum, part, sizeof part);
    return !(unfit[0] | unfit[1] | unfit[2] | unfit[3]);
}

// A row of up to eight samples, of the summed layers in order; false: a voxel was unfit.
static bool sum_row(const struct filling *f, const struct square *s, int y, double sum[SIDE])
{
    const int first = (s->from[1] + y) * s->step[1] + s->from[0] * s->step[0];
    if (s->step[0] == 1 && s->size[0] == SIDE && sum_eight(f, s, first, sum))
        return true;
    return sum_some(f, s, first, sum);
}

static bool sum_square(const struct filling *f, const struct square *s)
{
    struct weft_slice_plane *p = f->plane;
    bool fit = true;
    for (int y = 0; y < s->size[1]; y++) {
        const size_t at = (size_t)(s->at[1] + y) * (size_t)p->size[0] + (size_t)s->at[0];
        const size_t count = (size_t)s->size[0];
        double sum[SIDE];
        fit &= sum_row(f, s, y, sum);
        if (p->wide)
            memcpy(p->wide + at, sum, count * sizeof *sum);
        else
            for (size_t x = 0; x < count; x++)
                p->samples[at + x] = (float)sum[x];
    }
    return fit;
}

// The part of brick number i along an axis of the plane that is in reach.
static int32_t set_span(const struct filling *f, int axis, int i, struct square *s)
{
    const int a = f->plan->axes.order[axis];
    const int32_t low = f->plane->min[a], high = f->plane->max[a];
    const int32_t origin = (low & ~(SIDE - 1)) + i * SIDE;
    const int32_t from = origin > low ? origin : low;
    const int32_t to = high - origin < SIDE - 1 ? high : origin + SIDE - 1;
    s->from[axis] = from - origin;
    s->size[axis] = to - from + 1;
    s->at[axis] = from - low;
    return origin;
}

static int brick_count(const struct filling *f, int axis)
{
    const int a = f->plan->axes.order[axis];
    return (f->plane->max[a] >> 3) - (f->plane->min[a] >> 3) + 1;
}

// Where voxels do not lie side by side layers do.
static void prefetch(const struct filling *f, const struct square *s)
{
    const int layers = s->step[0] == 1 ? f->plan->axes.kept : 1;
    for (int k = 0; k < layers; k++)
        for (int y = 0; y < SIDE; y++)
            for (int x = 0; x < SIDE; x += s->step[0] == 1 ? SIDE : 2)
                __builtin_prefetch(s->layer[k] + y * s->step[1] + x * s->step[0]);
}

// Square number b of a row of bricks.
static void set_square(const struct filling *f, size_t row, int b, struct square *s)
{
    const int *order = f->plan->axes.order;
    int32_t origin[3];
    origin[order[1]] = set_span(f, 1, (int)row, s);
    origin[order[0]] = set_span(f, 0, b, s);
    find_layers(f, origin, s);
    prefetch(f, s);
}

// A row of bricks: while one is summed the next comes from memory.
static bool fill_part(void *priv, int thread, size_t row)
{
    struct filling *f = priv;
    const int count = brick_count(f, 0);
    struct square s[2];
    (void)thread;
    set_square(f, row, 0, &s[0]);
    for (int b = 0; b < count; b++) {
        if (b + 1 < count)
            set_square(f, row, b + 1, &s[(b + 1) % 2]);
        if (!sum_square(f, &s[b % 2]))
            atomic_store(&f->unfit, true);
    }
    return true;
}

bool weft_slice_plane_fill(const struct weft_slice_plan *plan, const weft_brick_store *store,
                           int threads, struct weft_slice_plane *plane)
{
    struct filling f = {.plan = plan, .store = store, .plane = plane};
    const int64_t voxels = (int64_t)plane->size[0] * plane->size[1] * plan->axes.kept;
    const int64_t worth = 1 + voxels / PART_VOXELS;
    weft_threads_run(worth < threads ? (int)worth : threads, (size_t)brick_count(&f, 1), fill_part,
                     &f);
    return !atomic_load(&f.unfit);
}
