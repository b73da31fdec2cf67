// SPDX-License-Identifier: BSD-3-Clause
#include "filter/kernel_records.h"

#include <math.h>
#include <stddef.h>

// B and C: the record's own where it is a named member of the family.
static const double *bc(const struct weft_kernel *kernel)
{
    return kernel->info->data ? kernel->info->data : kernel->param;
}

// Mitchell and Netravali (1988), eq. 8, the outer piece in s = 2 - |x|, where it does not cancel.
static double weight(const struct weft_kernel *kernel, double x)
{
    const double b = bc(kernel)[0], c = bc(kernel)[1];
    const double t = fabs(x), s = 2.0 - t;
    if (t < 1.0)
        return (((12.0 - 9.0 * b - 6.0 * c) * t - 18.0 + 12.0 * b + 6.0 * c) * t * t + 6.0 -
                2.0 * b) /
               6.0;
    return s > 0.0 ? s * s * (b * s - 6.0 * c * (1.0 - s)) / 6.0 : 0.0;
}

static double derivative(const struct weft_kernel *kernel, double x)
{
    const double b = bc(kernel)[0], c = bc(kernel)[1];
    const double t = fabs(x), s = 2.0 - t;
    double slope = 0.0;
    if (t < 1.0)
        slope = t * ((12.0 - 9.0 * b - 6.0 * c) * t - 12.0 + 8.0 * b + 4.0 * c) / 2.0;
    else if (s > 0.0)
        slope = -s * ((b + 6.0 * c) * s - 4.0 * c) / 2.0;
    return copysign(1.0, x) * slope;
}

// a1 vanishes on the line 2C + B = 1 and a2 on it at Catmull-Rom only (Moeller et al. 1997). The
// tolerance lets six typed digits of 1/3 be on the line.
static void refine(struct weft_kernel *kernel)
{
    const double b = kernel->param[0], c = kernel->param[1];
    const bool on_line = fabs(2.0 * c + b - 1.0) < 1e-5;
    kernel->interpolating = b == 0.0;
    kernel->order = !on_line ? 1 : fabs(b) < 1e-5 ? 3 : 2;
}

const struct weft_kernel_info weft_kernel_cubic = {
    .name = "cubic",
    .description = "two-parameter family of cubics; 2C + B = 1 for order 2",
    .citation = "Mitchell and Netravali, SIGGRAPH 1988",
    .params = {{"B", 0.0, -10.0, 10.0}, {"C", 0.5, -10.0, 10.0}},
    .radius = 2.0,
    .weight = weight,
    .derivative = derivative,
    .refine = refine,
    .degree = 3,
    .continuity = 1,
    .order = 1,
    .unit_sum = true,
};

const struct weft_kernel_info weft_kernel_catmull_rom = {
    .name = "catmull-rom",
    .description = "interpolating cubic, B = 0, C = 1/2",
    .citation = "Catmull and Rom 1974; Keys, IEEE TASSP 1981",
    .radius = 2.0,
    .weight = weight,
    .derivative = derivative,
    .data = (const double[]){0.0, 0.5},
    .degree = 3,
    .continuity = 1,
    .order = 3,
    .interpolating = true,
    .unit_sum = true,
};

const struct weft_kernel_info weft_kernel_mitchell = {
    .name = "mitchell",
    .description = "smoothing and sharpening in balance, B = C = 1/3",
    .citation = "Mitchell and Netravali, SIGGRAPH 1988",
    .radius = 2.0,
    .weight = weight,
    .derivative = derivative,
    .data = (const double[]){1.0 / 3.0, 1.0 / 3.0},
    .degree = 3,
    .continuity = 1,
    .order = 2,
    .unit_sum = true,
};
