// SPDX-License-Identifier: BSD-3-Clause
// One axis after another: a block of the result from the source's planes across its last axis.
// Each plane is summed along its columns, then along its rows, and added to the result's planes
// that it weighs on, so that no more than one plane of the source is held. Weights are scalars to
// the innermost loops, which run along what is not summed: taps of weight 0 are left out. Sums add
// taps in their order, wherever a block begins: the same bytes in any block.
#include <stdlib.h>
#include <string.h>

#include "passes/lattice/lattice_impl.h"

// Wider kernels are summed row by row of the source, without a plane in memory.
enum { PLANE_WIDTH = 64 };

// ---- memory -------------------------------------------------------------------------------------

void weft_lattice_scratch_clear(struct weft_lattice_scratch *scratch)
{
    free(scratch->values);
    free(scratch->rows);
    free(scratch->row_weights);
    *scratch = (struct weft_lattice_scratch){.capacity = 0};
}

double *weft_lattice_scratch_values(struct weft_lattice_scratch *scratch, size_t count)
{
    if (count > scratch->capacity) {
        free(scratch->values);
        // Rows are read and written in whole vectors; padding is summed like all else.
        scratch->values = calloc(count, sizeof *scratch->values);
        scratch->capacity = scratch->values ? count : 0;
    }
    return scratch->values;
}

static bool need_rows(struct weft_lattice_scratch *scratch, size_t count)
{
    if (count <= scratch->row_capacity)
        return true;
    free(scratch->rows);
    free(scratch->row_weights);
    scratch->rows = malloc(count * sizeof *scratch->rows);
    scratch->row_weights = malloc(count * sizeof *scratch->row_weights);
    scratch->row_capacity = scratch->rows && scratch->row_weights ? count : 0;
    return scratch->row_capacity > 0;
}

static size_t round_up(int64_t count)
{
    return ((size_t)count + 7) / 8 * 8;
}

// ---- voxels -------------------------------------------------------------------------------------

// Of a brick that lies outside of a volume that is clamped to its edge.
static void fetch_edge(const weft_brick_store *store, const int32_t origin[3], const int from[3],
                       const int to[3], double *start, const size_t stride[3])
{
    struct weft_brick_cursor cursor = {.store = store};
    for (int z = from[2]; z <= to[2]; z++)
        for (int y = from[1]; y <= to[1]; y++) {
            double *row =
                start + (size_t)(z - from[2]) * stride[2] + (size_t)(y - from[1]) * stride[1];
            for (int x = from[0]; x <= to[0]; x++)
                row[(size_t)(x - from[0]) * stride[0]] = (double)weft_brick_cursor_voxel(
                    &cursor, origin[0] + x, origin[1] + y, origin[2] + z);
        }
}

void weft_lattice_fetch(const struct weft_lattice_plan *plan, const struct weft_lattice_box *box,
                        double *out, const size_t stride[3])
{
    const weft_brick_store *store = plan->reader.store ? plan->reader.store : plan->reader.places;
    int64_t cell[3];
    for (cell[2] = box->min[2] & -8; cell[2] <= box->max[2]; cell[2] += 8)
        for (cell[1] = box->min[1] & -8; cell[1] <= box->max[1]; cell[1] += 8)
            for (cell[0] = box->min[0] & -8; cell[0] <= box->max[0]; cell[0] += 8) {
                const int32_t origin[3] = {(int32_t)cell[0], (int32_t)cell[1], (int32_t)cell[2]};
                int from[3], to[3];
                const float *values;
                float constant;
                double *start = out;
                for (int a = 0; a < 3; a++) {
                    const int64_t low = cell[a] > box->min[a] ? cell[a] : box->min[a];
                    const int64_t high = cell[a] + 7 < box->max[a] ? cell[a] + 7 : box->max[a];
                    from[a] = (int)(low - cell[a]);
                    to[a] = (int)(high - cell[a]);
                    start += (size_t)(low - box->min[a]) * stride[a];
                }
                if (weft_brick_store_find(store, origin, &values, &constant) == WEFT_BRICK_EDGE) {
                    fetch_edge(store, origin, from, to, start, stride);
                    continue;
                }
                for (int z = from[2]; z <= to[2]; z++)
                    for (int y = from[1]; y <= to[1]; y++) {
                        double *row = start + (size_t)(z - from[2]) * stride[2] +
                                      (size_t)(y - from[1]) * stride[1];
                        const float *v = values ? values + (z << 6 | y << 3) : NULL;
                        for (int x = from[0]; x <= to[0]; x++)
                            row[(size_t)(x - from[0]) * stride[0]] =
                                v ? (double)v[x] : (double)constant;
                    }
            }
}

// ---- one axis after another ---------------------------------------------------------------------

// Along one of the result's axes: of a block's positions.
struct along {
    int axis; // of the source
    int count;
    int64_t first, taps, width; // the source's voxels from first on
    const struct weft_lattice_weights *weights[WEFT_LATTICE_STRIP / WEFT_BRICK_SIZE];
};

static const double *weights_at(const struct along *along, int order, int i, int64_t *first)
{
    const struct weft_lattice_weights *w = along->weights[i >> 3];
    *first = w->first[i & 7] - along->first;
    return w->weight[order] + (size_t)(i & 7) * (size_t)along->width;
}

static struct along make_along(const struct weft_lattice_work *work, int axis)
{
    const struct weft_lattice_box *box = &work->block->box;
    const int a = work->plan->info.axis[axis];
    struct along out = {.axis = a,
                        .count = (int)(box->max[axis] - box->min[axis] + 1),
                        .first = INT64_MAX,
                        .width = work->plan->info.width[a]};
    int64_t last = INT64_MIN;
    for (int b = 0; b < out.count / WEFT_BRICK_SIZE; b++) {
        out.weights[b] =
            weft_lattice_memo_find(work->memo, axis, (int32_t)box->min[axis] + b * WEFT_BRICK_SIZE);
        for (int i = 0; i < WEFT_BRICK_SIZE; i++) {
            const int64_t first = out.weights[b]->first[i];
            out.first = first < out.first ? first : out.first;
            last = first + out.width - 1 > last ? first + out.width - 1 : last;
        }
    }
    out.taps = last - out.first + 1;
    return out;
}

struct pass {
    const struct weft_lattice_work *work;
    struct along x, y, z;
    size_t pitch;    // of rows of the source
    double *plane;   // [y'][x'], or one row
    double *columns; // summed along y: [y][x'], and turned
    double *turned;  // [x'][y]
    double *middle;  // summed along x, too: [x][y]
    double *out;     // [output][z][x][y]
};

static void fetch_rows(const struct pass *p, int64_t plane, int64_t row, int64_t rows, double *out)
{
    const int a = p->x.axis, b = p->y.axis, c = p->z.axis;
    struct weft_lattice_box box;
    size_t stride[3];
    box.min[a] = p->x.first;
    box.max[a] = p->x.first + p->x.taps - 1;
    box.min[b] = p->y.first + row;
    box.max[b] = p->y.first + row + rows - 1;
    box.min[c] = box.max[c] = p->z.first + plane;
    stride[a] = 1;
    stride[b] = p->pitch;
    stride[c] = 0;
    weft_lattice_fetch(p->work->plan, &box, out, stride);
}

// Those of the weights that are not 0, beside their rows.
static int64_t gather(struct weft_lattice_scratch *scratch, const double *weights, int64_t width,
                      const double *rows, size_t pitch)
{
    int64_t taps = 0;
    for (int64_t t = 0; t < width; t++)
        if (weights[t] != 0.0) {
            scratch->rows[taps] = rows + (size_t)t * pitch;
            scratch->row_weights[taps++] = weights[t];
        }
    return taps;
}

static void sum_rows(const struct pass *p, const struct along *along, int order, const double *rows,
                     size_t pitch, double *out)
{
    struct weft_lattice_scratch *scratch = p->work->scratch;
    for (int i = 0; i < along->count; i++) {
        int64_t first;
        const double *weights = weights_at(along, order, i, &first);
        const int64_t taps =
            gather(scratch, weights, along->width, rows + (size_t)first * pitch, pitch);
        p->work->lines->sum(out + (size_t)i * pitch, scratch->rows, scratch->row_weights, taps,
                            pitch);
    }
}

// Along y, row by row of the source.
static void add_rows(const struct pass *p, int order, int64_t plane)
{
    memset(p->columns, 0, (size_t)p->y.count * p->pitch * sizeof *p->columns);
    for (int64_t row = 0; row < p->y.taps; row++) {
        bool fetched = false;
        for (int i = 0; i < p->y.count; i++) {
            int64_t first;
            const double *weights = weights_at(&p->y, order, i, &first);
            if (row < first || row >= first + p->y.width || weights[row - first] == 0.0)
                continue;
            if (!fetched)
                fetch_rows(p, plane, row, 1, p->plane);
            fetched = true;
            p->work->lines->add(p->columns + (size_t)i * p->pitch, p->plane, weights[row - first],
                                p->pitch);
        }
    }
}

static void turn(const struct pass *p)
{
    const size_t rows = (size_t)p->y.count, columns = (size_t)p->x.taps;
    for (size_t x = 0; x < columns; x += 8)
        for (size_t y = 0; y < rows; y++)
            for (size_t i = x; i < columns && i < x + 8; i++)
                p->turned[i * rows + y] = p->columns[y * p->pitch + i];
}

// Adds what is summed along x and y to the outputs of these orders.
static void add_plane(const struct pass *p, int order_x, int order_y, int64_t plane)
{
    const struct weft_lattice_info *info = &p->work->plan->info;
    const size_t count = (size_t)p->x.count * (size_t)p->y.count;
    for (int d = 0; d < info->derivative_count; d++) {
        const int *along = info->derivative[d].along;
        if (along[p->x.axis] != order_x || along[p->y.axis] != order_y)
            continue;
        for (int i = 0; i < p->z.count; i++) {
            int64_t first;
            const double *weights = weights_at(&p->z, along[p->z.axis], i, &first);
            if (plane >= first && plane < first + p->z.width && weights[plane - first] != 0.0)
                p->work->lines->add(p->out + ((size_t)d * (size_t)p->z.count + (size_t)i) * count,
                                    p->middle, weights[plane - first], count);
        }
    }
}

static bool has_order(const struct weft_lattice_info *info, const struct pass *p, int x, int y)
{
    for (int d = 0; d < info->derivative_count; d++) {
        const int *along = info->derivative[d].along;
        if (along[p->y.axis] == y && (x < 0 || along[p->x.axis] == x))
            return true;
    }
    return false;
}

static bool plane_counts(const struct pass *p, int64_t plane)
{
    for (int i = 0; i < p->z.count; i++)
        for (int order = 0; order < WEFT_LATTICE_ORDERS; order++) {
            int64_t first;
            if (!p->z.weights[i >> 3]->weight[order])
                continue;
            const double *weights = weights_at(&p->z, order, i, &first);
            if (plane >= first && plane < first + p->z.width && weights[plane - first] != 0.0)
                return true;
        }
    return false;
}

static void pass_plane(const struct pass *p, int64_t plane)
{
    const struct weft_lattice_info *info = &p->work->plan->info;
    const bool whole = p->y.width <= PLANE_WIDTH;
    if (whole)
        fetch_rows(p, plane, 0, p->y.taps, p->plane);
    for (int y = 0; y < WEFT_LATTICE_ORDERS; y++) {
        if (!has_order(info, p, -1, y))
            continue;
        if (whole)
            sum_rows(p, &p->y, y, p->plane, p->pitch, p->columns);
        else
            add_rows(p, y, plane);
        turn(p);
        for (int x = 0; x < WEFT_LATTICE_ORDERS; x++) {
            if (!has_order(info, p, x, y))
                continue;
            sum_rows(p, &p->x, x, p->turned, (size_t)p->y.count, p->middle);
            add_plane(p, x, y, plane);
        }
    }
}

static size_t plane_rows(const struct along *y)
{
    return y->width <= PLANE_WIDTH ? (size_t)y->taps : 1;
}

bool weft_lattice_compute_separable(const struct weft_lattice_work *work, const double **out,
                                    size_t pitch[3])
{
    struct pass p = {
        .work = work, .x = make_along(work, 0), .y = make_along(work, 1), .z = make_along(work, 2)};
    p.pitch = round_up(p.x.taps);
    const size_t rows = (size_t)p.y.count, count = (size_t)p.x.count * rows;
    const size_t total = count * (size_t)p.z.count * (size_t)work->plan->info.derivative_count;
    const size_t sizes[] = {plane_rows(&p.y) * p.pitch, rows * p.pitch, p.pitch * rows, count,
                            total};
    double **places[] = {&p.plane, &p.columns, &p.turned, &p.middle, &p.out};
    size_t all = 0;
    for (int i = 0; i < 5; i++)
        all += sizes[i];
    double *next = weft_lattice_scratch_values(work->scratch, all);
    const int64_t width = p.x.width > p.y.width ? p.x.width : p.y.width;
    if (!next || !need_rows(work->scratch, (size_t)width))
        return false;
    for (int i = 0; i < 5; i++) {
        *places[i] = next;
        next += sizes[i];
    }
    memset(p.out, 0, total * sizeof *p.out);
    for (int64_t plane = 0; plane < p.z.taps; plane++)
        if (plane_counts(&p, plane))
            pass_plane(&p, plane);
    *out = p.out;
    pitch[0] = rows;
    pitch[1] = 1;
    pitch[2] = count;
    return true;
}
