// SPDX-License-Identifier: BSD-3-Clause
#include "passes/positions/axes.h"

#include <math.h>

// A plane of more samples than this, a pixel, is more work than convolving each pixel by itself.
static const double MAX_SAMPLES_PER_PIXEL = 2.0;

// The axis along which every pixel has the same coordinate; -1: none.
static int constant_axis(const struct weft_slice_geometry *g)
{
    for (int a = 0; a < 3; a++)
        if (g->u[a] == 0.0 && g->v[a] == 0.0)
            return a;
    return -1;
}

void weft_slice_axes_set(const struct weft_kernel *kernel, const struct weft_slice_grid *grid,
                         bool may_sum, struct weft_slice_axes *axes)
{
    const int axis = may_sum ? constant_axis(&grid->index) : -1;
    *axes = (struct weft_slice_axes){.order = {0, 1, 2}, .summed = axis >= 0};
    for (int i = 0; i < 3; i++)
        axes->taps[i] = kernel->width;
    if (axis < 0)
        return;
    axes->taps[2] = 1;
    axes->order[0] = axis == 0 ? 1 : 0;
    axes->order[1] = axis == 2 ? 1 : 2;
    axes->order[2] = axis;
    // The fraction as the shader would have it.
    struct weft_slice_block block;
    int32_t whole[3];
    double fraction[3], weight[WEFT_KERNEL_MAX_WIDTH];
    weft_slice_grid_block(grid, 0, 0, &block);
    weft_slice_grid_pixel(grid, &block, 0, 0, whole, fraction);
    weft_kernel_weights(kernel, fraction[axis] - grid->tap_shift, weight);
    int last = kernel->width - 1;
    while (axes->first < last && weight[axes->first] == 0.0)
        axes->first++;
    while (last > axes->first && weight[last] == 0.0)
        last--;
    axes->kept = last - axes->first + 1;
    for (int i = 0; i < axes->kept; i++)
        axes->weight[i] = weight[axes->first + i];
    axes->plane = (int64_t)whole[axis] - grid->tap_offset + axes->first;
}

// The one axis along which an edge of the cut runs; -1: it is oblique.
static int axis_of(const double edge[3])
{
    int axis = -1;
    for (int a = 0; a < 3; a++) {
        if (edge[a] != 0.0 && axis >= 0)
            return -1;
        if (edge[a] != 0.0)
            axis = a;
    }
    return axis;
}

void weft_slice_axes_separate(const struct weft_kernel *kernel, const struct weft_slice_grid *grid,
                              struct weft_slice_axes *axes)
{
    const struct weft_slice_geometry *g = &grid->index;
    const int row = axis_of(g->u), column = axis_of(g->v);
    if (!axes->summed || row < 0 || column < 0)
        return;
    const double width = kernel->width;
    const double samples = (fabs(g->u[row]) + width) * (fabs(g->v[column]) + width);
    if (samples > MAX_SAMPLES_PER_PIXEL * g->width * g->height)
        return;
    axes->order[0] = row;
    axes->order[1] = column;
    axes->separable = true;
}

void weft_slice_axes_narrow(const struct weft_slice_axes *axes, int32_t min[3], int32_t max[3])
{
    if (axes->summed) {
        const int a = axes->order[2];
        min[a] += axes->first;
        max[a] = min[a] + axes->kept - 1;
    }
}

double weft_slice_axes_coordinate(const struct weft_slice_axes *axes,
                                  const struct weft_slice_grid *grid, int axis, int i)
{
    const int a = axes->order[axis], x = axis ? 0 : i, y = axis ? i : 0;
    struct weft_slice_block block;
    int32_t whole[3];
    double fraction[3];
    weft_slice_grid_block(grid, x / WEFT_GRID_BLOCK, y / WEFT_GRID_BLOCK, &block);
    weft_slice_grid_pixel(grid, &block, x, y, whole, fraction);
    return whole[a] + (fraction[a] - grid->tap_shift);
}

void weft_slice_axes_box(const struct weft_slice_axes *axes, const struct weft_kernel *kernel,
                         const struct weft_slice_grid *grid, const struct weft_rectangle *rectangle,
                         int32_t min[3], int32_t max[3])
{
    const int from[2] = {rectangle->x, rectangle->y};
    const int count[2] = {rectangle->width, rectangle->height};
    for (int i = 0; i < 2; i++) {
        const double first = weft_slice_axes_coordinate(axes, grid, i, from[i]);
        const double last = weft_slice_axes_coordinate(axes, grid, i, from[i] + count[i] - 1);
        double fraction;
        const int a = axes->order[i];
        min[a] = (int32_t)weft_kernel_first_tap(kernel, fmin(first, last), &fraction);
        max[a] = (int32_t)weft_kernel_first_tap(kernel, fmax(first, last), &fraction) +
                 kernel->width - 1;
    }
    min[axes->order[2]] = (int32_t)axes->plane;
    max[axes->order[2]] = (int32_t)axes->plane + axes->kept - 1;
}

void weft_slice_sum_planes(const struct weft_slice_axes *axes, const float *box, const int size[3],
                           const int span[3], float *out, int stride)
{
    const int *order = axes->order;
    const size_t pitch[3] = {1, (size_t)span[0], (size_t)span[0] * (size_t)span[1]};
    for (int y = 0; y < size[order[1]]; y++) {
        for (int x = 0; x < size[order[0]]; x++) {
            const float *at = box + (size_t)y * pitch[order[1]] + (size_t)x * pitch[order[0]];
            double sum = 0.0;
            for (int k = 0; k < axes->kept; k++)
                sum += axes->weight[k] * at[(size_t)k * pitch[order[2]]];
            out[(size_t)y * (size_t)stride + (size_t)x] = (float)sum;
        }
    }
}
