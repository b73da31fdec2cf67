// SPDX-License-Identifier: BSD-3-Clause
// All taps at once, where the result's axes do not run along the source's.
#include <stdlib.h>

#include "passes/lattice/lattice_impl.h"

// Of the source's voxels that are fetched together, at most, but for a single voxel's own.
enum { FETCHED = 1 << 21 };

// A cube of the result's voxels, the source's in its reach, and room for weights.
struct direct {
    const struct weft_lattice_work *work;
    double *out, *weights, *voxels;
    size_t room; // for voxels
    struct weft_lattice_box reach;
    size_t stride[3];
};

static void weigh(const struct weft_lattice_plan *plan, int axis, int order, double x,
                  double *weights, int64_t *first)
{
    const double stretch = plan->info.stretch[axis];
    *first = stretch == 1.0 ? weft_kernel_weights(&plan->kernel[order], x, weights)
                            : weft_stretch_weights(&plan->kernel[order], stretch, x, weights);
}

// Weights of all orders along each axis, one after another.
struct weighed {
    int64_t first[3];
    double *weight[3][WEFT_LATTICE_ORDERS]; // NULL: not needed
};

static struct weighed weigh_all(const struct direct *d, const int64_t r[3])
{
    const struct weft_lattice_plan *plan = d->work->plan;
    struct weighed out = {.first = {0}};
    double *next = d->weights;
    for (int a = 0; a < 3; a++) {
        const double x = weft_lattice_at(plan->info.to_source[a], r);
        for (int i = 0; i < plan->info.derivative_count; i++) {
            const int order = plan->info.derivative[i].along[a];
            if (out.weight[a][order])
                continue;
            out.weight[a][order] = next;
            weigh(plan, a, order, x, next, &out.first[a]);
            next += plan->info.width[a];
        }
    }
    return out;
}

// sum += weight * value; a weight of 0 does not count.
static double add(double sum, double weight, double value)
{
    return weight == 0.0 ? sum : sum + weight * value;
}

static double sum_row(const double *weights, const double *row, int64_t width)
{
    double sum = 0.0;
    for (int64_t t = 0; t < width; t++)
        sum = add(sum, weights[t], row[t]);
    return sum;
}

static void compute_voxel(const struct direct *d, const struct weighed *w, double *out,
                          size_t output)
{
    const struct weft_lattice_info *info = &d->work->plan->info;
    const double *start = d->voxels;
    for (int a = 0; a < 3; a++)
        start += (size_t)(w->first[a] - d->reach.min[a]) * d->stride[a];
    for (int i = 0; i < info->derivative_count; i++)
        out[(size_t)i * output] = 0.0;
    for (int64_t z = 0; z < info->width[2]; z++) {
        double plane[WEFT_LATTICE_ORDERS][WEFT_LATTICE_ORDERS] = {{0.0}};
        for (int64_t y = 0; y < info->width[1]; y++) {
            const double *row = start + (size_t)z * d->stride[2] + (size_t)y * d->stride[1];
            for (int x = 0; x < WEFT_LATTICE_ORDERS; x++) {
                if (!w->weight[0][x])
                    continue;
                const double sum = sum_row(w->weight[0][x], row, info->width[0]);
                for (int order = 0; order < WEFT_LATTICE_ORDERS; order++)
                    if (w->weight[1][order])
                        plane[x][order] = add(plane[x][order], w->weight[1][order][y], sum);
            }
        }
        for (int i = 0; i < info->derivative_count; i++) {
            const int *along = info->derivative[i].along;
            double *value = out + (size_t)i * output;
            *value = add(*value, w->weight[2][along[2]][z], plane[along[0]][along[1]]);
        }
    }
}

// A row of weight 0 along y or z, whatever lies in it, is left out by `add`; one that is not finite
// and has weight 0 along x by sum_row.
static void compute_cube(const struct direct *d, const struct weft_lattice_box *cube,
                         const size_t pitch[3], size_t output)
{
    const struct weft_lattice_box *box = &d->work->block->box;
    int64_t r[3];
    for (r[2] = cube->min[2]; r[2] <= cube->max[2]; r[2]++)
        for (r[1] = cube->min[1]; r[1] <= cube->max[1]; r[1]++)
            for (r[0] = cube->min[0]; r[0] <= cube->max[0]; r[0]++) {
                const struct weighed w = weigh_all(d, r);
                double *out = d->out;
                for (int a = 0; a < 3; a++)
                    out += (size_t)(r[a] - box->min[a]) * pitch[a];
                compute_voxel(d, &w, out, output);
            }
}

static void make_ready(struct direct *d, const struct weft_lattice_box *cube)
{
    d->reach = weft_lattice_footprint(d->work->plan, cube);
    d->stride[0] = 1;
    for (int a = 0; a < 3; a++) { // weights of 0 may lie a voxel past the kernel's support
        d->reach.min[a] -= 1;
        d->reach.max[a] += 1;
    }
    for (int a = 1; a < 3; a++)
        d->stride[a] = d->stride[a - 1] * (size_t)(d->reach.max[a - 1] - d->reach.min[a - 1] + 1);
}

static size_t voxels_of(const struct direct *d)
{
    return d->stride[2] * (size_t)(d->reach.max[2] - d->reach.min[2] + 1);
}

// The largest cubes that a brick is cut into.
static int cube_size(struct direct *d, const int64_t origin[3])
{
    int size = WEFT_BRICK_SIZE;
    for (;; size /= 2) {
        struct weft_lattice_box cube;
        for (int a = 0; a < 3; a++) {
            cube.min[a] = origin[a];
            cube.max[a] = origin[a] + size - 1;
        }
        make_ready(d, &cube);
        if (size == 1 || voxels_of(d) <= FETCHED)
            return size;
    }
}

bool weft_lattice_compute_direct(const struct weft_lattice_work *work, const double **out,
                                 size_t pitch[3])
{
    const struct weft_lattice_info *info = &work->plan->info;
    const struct weft_lattice_box *box = &work->block->box;
    struct direct d = {.work = work};
    const size_t output = WEFT_BRICK_VOXELS;
    const int size = cube_size(&d, box->min);
    // Cubes of one size have reaches that differ by a voxel along each axis.
    size_t room = 1, weights = 0;
    for (int a = 0; a < 3; a++) {
        room *= (size_t)(d.reach.max[a] - d.reach.min[a] + 3);
        weights += WEFT_LATTICE_ORDERS * (size_t)info->width[a];
    }
    d.out = weft_lattice_scratch_values(work->scratch,
                                        output * (size_t)info->derivative_count + weights + room);
    if (!d.out)
        return false;
    d.weights = d.out + output * (size_t)info->derivative_count;
    d.voxels = d.weights + weights;
    pitch[0] = 8;
    pitch[1] = 1;
    pitch[2] = 64;
    struct weft_lattice_box cube;
    for (cube.min[2] = box->min[2]; cube.min[2] <= box->max[2]; cube.min[2] += size)
        for (cube.min[1] = box->min[1]; cube.min[1] <= box->max[1]; cube.min[1] += size)
            for (cube.min[0] = box->min[0]; cube.min[0] <= box->max[0]; cube.min[0] += size) {
                for (int a = 0; a < 3; a++)
                    cube.max[a] = cube.min[a] + size - 1;
                make_ready(&d, &cube);
                weft_lattice_fetch(work->plan, &d.reach, d.voxels, d.stride);
                compute_cube(&d, &cube, pitch, output);
            }
    *out = d.out;
    return true;
}
