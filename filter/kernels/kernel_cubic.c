// SPDX-License-Identifier: BSD-3-Clause
#include "filter/kernels/kernel_records.h"

#include <math.h>
#include <stddef.h>

// The named members of the family bring B and C; a NAN there is the first parameter.
struct member {
    double b, c;
};

static struct member member(const struct weft_kernel *kernel)
{
    const struct member *fixed = kernel->info->data;
    if (!fixed)
        return (struct member){kernel->param[0], kernel->param[1]};
    return (struct member){fixed->b, isnan(fixed->c) ? kernel->param[0] : fixed->c};
}

// The n-th derivative of (a v + b) v^2 + c.
static double polynomial(double a, double b, double c, double v, int n)
{
    switch (n) {
    case 0:
        return (a * v + b) * v * v + c;
    case 1:
        return (3.0 * a * v + 2.0 * b) * v;
    case 2:
        return 6.0 * a * v + 2.0 * b;
    default:
        return 6.0 * a;
    }
}

// Mitchell and Netravali (1988), eq. 8; the outer piece in 2 - |x|, where it does not cancel. On a
// knot the piece is the one to the right.
static double cubic(const struct weft_kernel *kernel, double x, int n)
{
    const struct member m = member(kernel);
    const double t = fabs(x), sign = x < 0.0 && n % 2 ? -1.0 : 1.0;
    if (!(x >= -2.0 && x < 2.0))
        return 0.0;
    if (x >= -1.0 && x < 1.0)
        return sign *
               polynomial(2.0 - 1.5 * m.b - m.c, 2.0 * m.b + m.c - 3.0, 1.0 - m.b / 3.0, t, n);
    const double outer = polynomial((m.b + 6.0 * m.c) / 6.0, -m.c, 0.0, 2.0 - t, n);
    return n % 2 ? -sign * outer : outer;
}

WEFT_KERNEL_NTH(cubic, 0)
WEFT_KERNEL_NTH(cubic, 1)
WEFT_KERNEL_NTH(cubic, 2)
WEFT_KERNEL_NTH(cubic, 3)

// a1 vanishes on the line 2C + B = 1 and a2 = B/6 there (Moeller et al. 1997). The tolerance lets
// six typed digits of 1/3 be on the line.
static void refine(struct weft_kernel *kernel)
{
    const struct member m = member(kernel);
    const bool on_line = fabs(2.0 * m.c + m.b - 1.0) < 1e-5;
    const bool is_bspline = on_line && m.b == 1.0, is_keys = on_line && fabs(m.b) < 1e-5;
    const int n = kernel->info->derivation;
    kernel->interpolating = n == 0 && m.b == 0.0;
    if (n == 0) {
        kernel->order = !on_line ? 1 : is_keys ? 3 : 2;
        kernel->order_prefiltered = !on_line ? 1 : is_bspline ? 4 : 3;
    } else {
        kernel->order = !on_line ? 0 : n == 1 || is_bspline ? 2 : 1;
    }
    if (is_bspline)
        kernel->continuity = 2 - n;
}

#define MITCHELL .citation = "Mitchell and Netravali, SIGGRAPH 1988", .radius = 2.0
#define B_AND_C MITCHELL, .refine = refine, .params = {{"B", 0, -10, 10}, {"C", 0.5, -10, 10}}
#define ONLY_C                                                                                     \
    MITCHELL, .refine = refine, .params = {{"C", 0.75, -10, 10}}, .data = &(const struct member)   \
    {                                                                                              \
        0.0, NAN                                                                                   \
    }
#define KEYS                                                                                       \
    .citation = "Catmull and Rom 1974; Keys, IEEE TASSP 1981", .radius = 2.0,                      \
    .data = &(const struct member)                                                                 \
    {                                                                                              \
        0.0, 0.5                                                                                   \
    }
#define THIRDS                                                                                     \
    MITCHELL, .data = &(const struct member)                                                       \
    {                                                                                              \
        1.0 / 3.0, 1.0 / 3.0                                                                       \
    }
#define NOTCH                                                                                      \
    MITCHELL, .data = &(const struct member)                                                       \
    {                                                                                              \
        1.5, -0.25                                                                                 \
    }

#define CUBIC(self, text, order_d, order_dd, own, ...)                                             \
    {                                                                                              \
        WEFT_KERNEL_RECORD(text, cubic, 3, 1, own, .unit_sum = true, __VA_ARGS__),                 \
            WEFT_KERNEL_D(self, text, cubic, 3, 1, order_d, __VA_ARGS__),                          \
            WEFT_KERNEL_DD(self, text, cubic, cubic_3, 3, 1, order_dd, __VA_ARGS__),               \
    }

const struct weft_kernel_info weft_kernel_cubic[3] =
    CUBIC(weft_kernel_cubic, "cubic", 0, 0,
          (.description = "two-parameter family of cubics; order 2 where 2C + B = 1", .order = 1,
           .order_prefiltered = 1),
          B_AND_C);

const struct weft_kernel_info weft_kernel_cardinal[3] =
    CUBIC(weft_kernel_cardinal, "cardinal", 0, 0,
          (.description = "interpolating cubics, B = 0", .order = 1, .order_prefiltered = 1,
           .interpolating = true),
          ONLY_C);

const struct weft_kernel_info weft_kernel_catmull_rom[3] =
    CUBIC(weft_kernel_catmull_rom, "catmull-rom", 2, 1,
          (.description = "interpolating cubic, B = 0, C = 1/2", .order = 3, .order_prefiltered = 3,
           .interpolating = true),
          KEYS);

const struct weft_kernel_info weft_kernel_mitchell[3] =
    CUBIC(weft_kernel_mitchell, "mitchell", 2, 1,
          (.description = "smoothing and sharpening in balance, B = C = 1/3", .order = 2,
           .order_prefiltered = 3),
          THIRDS);

const struct weft_kernel_info weft_kernel_notch[3] =
    CUBIC(weft_kernel_notch, "notch", 2, 1,
          (.description = "no ripple at the sample rate, very smooth, B = 3/2, C = -1/4",
           .order = 2, .order_prefiltered = 3),
          NOTCH);
