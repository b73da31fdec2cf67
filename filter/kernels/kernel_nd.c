// SPDX-License-Identifier: BSD-3-Clause
#include "filter/kernels/kernel_nd.h"

#include <float.h>
#include <math.h>

#include "filter/kernels/kernel_records.h"

bool weft_kernel_is_radial(const struct weft_kernel *kernel, int dims)
{
    return kernel->radial && dims > 1;
}

// The smallest square first, so that permuted axes give the same weight to the last bit.
static double length(double x, double y, double z)
{
    const double a = x * x, b = y * y, c = z * z;
    const double least = fmin(a, fmin(b, c)), most = fmax(a, fmax(b, c));
    const double middle = fmax(fmin(a, b), fmin(fmax(a, b), c));
    return sqrt(least + middle + most);
}

static double radial_weight(const struct weft_kernel *kernel, double x, double y, double z)
{
    const double distance = length(x, y, z);
    return distance < kernel->support ? weft_kernel_value(kernel, distance) : 0.0;
}

static double sum(const double *weights, int count)
{
    double total = 0.0;
    for (int i = 0; i < count; i++)
        total += weights[i];
    return total;
}

static void divide_by_sum(double *weights, int count)
{
    const double total = sum(weights, count);
    for (int i = 0; i < count; i++)
        weights[i] /= total;
}

// Never 0 where no factor is: a tap whose weight is exactly 0 does not count, and this one does.
static double product(double x, double y, double z)
{
    const double xyz = x * y * z;
    const bool vanishes = xyz == 0.0 && x != 0.0 && y != 0.0 && z != 0.0;
    return vanishes ? copysign(DBL_TRUE_MIN, xyz) : xyz;
}

int weft_kernel_combine(const struct weft_kernel *kernel, int dims, const double *const axis[3],
                        double *weights)
{
    if (!weft_kernel_usable(kernel) || dims < 1 || dims > 3)
        return 0;
    const bool radial = weft_kernel_is_radial(kernel, dims);
    const int width = kernel->width, rows = dims > 1 ? width : 1, planes = dims > 2 ? width : 1;
    const double unused = radial ? 0.0 : 1.0; // along axes past dims
    double *weight = weights;
    for (int k = 0; k < planes; k++) {
        for (int j = 0; j < rows; j++) {
            const double y = dims > 1 ? axis[1][j] : unused, z = dims > 2 ? axis[2][k] : unused;
            for (int i = 0; i < width; i++)
                *weight++ =
                    radial ? radial_weight(kernel, axis[0][i], y, z) : product(axis[0][i], y, z);
        }
    }
    const int count = planes * rows * width;
    if (radial && kernel->normalised) // the weights of an axis are so already
        divide_by_sum(weights, count);
    return count;
}

static int64_t offsets(const struct weft_kernel *kernel, double x, double *offset)
{
    double fraction;
    const int64_t first = weft_kernel_first_tap(kernel, x, &fraction);
    for (int j = 0; j < kernel->width; j++)
        offset[j] = weft_kernel_argument(fraction, weft_kernel_offset(kernel) - j);
    return first;
}

int weft_kernel_weights_nd(const struct weft_kernel *kernel, int dims, const double *position,
                           double *weights, int64_t first[3])
{
    if (!weft_kernel_usable(kernel) || dims < 1 || dims > 3)
        return 0;
    double values[3][WEFT_KERNEL_MAX_WIDTH];
    for (int a = 0; a < 3; a++)
        first[a] = a >= dims ? 0
                   : weft_kernel_is_radial(kernel, dims)
                       ? offsets(kernel, position[a], values[a])
                       : weft_kernel_weights(kernel, position[a], values[a]);
    return weft_kernel_combine(kernel, dims,
                               (const double *const[3]){values[0], values[1], values[2]}, weights);
}

// Sums are even about the samples and the middles between them, where their extremes are likely.
struct weft_kernel_sums weft_kernel_radial_sums(const struct weft_kernel *kernel, int dims)
{
    enum { STEPS = 9 };
    if (!weft_kernel_usable(kernel) || dims < 2 || dims > 3)
        return (struct weft_kernel_sums){NAN, NAN};
    struct weft_kernel plain = *kernel;
    plain.radial = true;
    plain.normalised = false;
    struct weft_kernel_sums sums = {INFINITY, -INFINITY};
    for (int i = 0; i < STEPS * STEPS * (dims > 2 ? STEPS : 1); i++) {
        const double position[3] = {(i % STEPS) / 16.0, (i / STEPS % STEPS) / 16.0,
                                    (i / STEPS / STEPS) / 16.0};
        double weights[WEFT_KERNEL_MAX_WEIGHTS];
        int64_t first[3];
        const int count = weft_kernel_weights_nd(&plain, dims, position, weights, first);
        const double total = sum(weights, count);
        sums.least = fmin(sums.least, total);
        sums.largest = fmax(sums.largest, total);
    }
    return sums;
}
