// SPDX-License-Identifier: BSD-3-Clause
// Even kernels of polynomial pieces one unit wide.
#include "filter/kernels/kernel_records.h"

#include <math.h>
#include <stddef.h>

enum { MAX_PIECES = 3, MAX_COEFFICIENTS = 6 };

// Piece i covers i <= |x| <= i + 1, in powers of s = i + 1 - |x|: near the end of the support
// nothing cancels.
struct pieces {
    int count, coefficients;
    double c[MAX_PIECES][MAX_COEFFICIENTS];
};

// The n-th derivative by s.
static double polynomial(const double *c, int coefficients, double s, int n)
{
    double sum = 0.0;
    for (int i = coefficients - 1; i >= n; i--) {
        double factor = 1.0;
        for (int j = 0; j < n; j++)
            factor *= i - j;
        sum = sum * s + factor * c[i];
    }
    return sum;
}

// On a knot, the piece to the right: left of the origin that is the one nearer to it.
static double pieces(const struct weft_kernel *kernel, double x, int n)
{
    const struct pieces *p = kernel->info->data;
    if (!(x >= -p->count && x < p->count))
        return 0.0;
    const double t = fabs(x);
    const int i = x < 0.0 ? (int)ceil(t) - 1 : (int)floor(t);
    const double value = polynomial(p->c[i], p->coefficients, i + 1 - t, n);
    return n % 2 && x >= 0.0 ? -value : value;
}

WEFT_KERNEL_NTH(pieces, 0)
WEFT_KERNEL_NTH(pieces, 1)
WEFT_KERNEL_NTH(pieces, 2)
WEFT_KERNEL_NTH(pieces, 3)

// beta3 + beta3'' / 42.
static const struct pieces omoms_pieces = {
    2, 4, {{4.0 / 21, 3.0 / 7, 1.0 / 2, -1.0 / 2}, {0, 1.0 / 42, 0, 1.0 / 6}}};

static const struct pieces lagrange3_pieces = {
    2, 4, {{0, 1, 1.0 / 2, -1.0 / 2}, {0, -1.0 / 6, 0, 1.0 / 6}}};

static const struct pieces lagrange5_pieces = {
    3,
    6,
    {{0, 1, 2.0 / 3, -7.0 / 12, -1.0 / 6, 1.0 / 12},
     {0, -1.0 / 4, -1.0 / 24, 7.0 / 24, 1.0 / 24, -1.0 / 24},
     {0, 1.0 / 30, 0, -1.0 / 24, 0, 1.0 / 120}}};

// Keys (1981): 4/3 t^3 - 7/3 t^2 + 1 and so on in t = |x|, rewritten in s.
static const struct pieces keys6_pieces = {3,
                                           4,
                                           {{0, 2.0 / 3, 5.0 / 3, -4.0 / 3},
                                            {0, -1.0 / 12, -1.0 / 2, 7.0 / 12},
                                            {0, 0, 1.0 / 12, -1.0 / 12}}};

#define OMOMS                                                                                      \
    .citation = "Blu, Thevenaz and Unser, IEEE TIP 2001", .radius = 2.0, .data = &omoms_pieces
const struct weft_kernel_info weft_kernel_omoms[2] = {
    WEFT_KERNEL_RECORD("omoms", pieces, 3, 0,
                       (.description = "cubic o-Moms, smooths unless prefiltered", .order = 2,
                        .order_prefiltered = 4, .unit_sum = true),
                       OMOMS),
    WEFT_KERNEL_D(weft_kernel_omoms, "omoms", pieces, 3, 0, 2, OMOMS),
};

#define LAGRANGE(r, p) .citation = "Schafer and Rabiner, Proc. IEEE 1973", .radius = r, .data = &p
const struct weft_kernel_info weft_kernel_lagrange3[2] = {
    WEFT_KERNEL_RECORD("lagrange3", pieces, 3, 0,
                       (.description = "central Lagrange interpolation, cubic", .order = 4,
                        .order_prefiltered = 4, .interpolating = true, .unit_sum = true),
                       LAGRANGE(2.0, lagrange3_pieces)),
    WEFT_KERNEL_D(weft_kernel_lagrange3, "lagrange3", pieces, 3, 0, 3,
                  LAGRANGE(2.0, lagrange3_pieces)),
};
const struct weft_kernel_info weft_kernel_lagrange5[2] = {
    WEFT_KERNEL_RECORD("lagrange5", pieces, 5, 0,
                       (.description = "central Lagrange interpolation, quintic", .order = 6,
                        .order_prefiltered = 6, .interpolating = true, .unit_sum = true),
                       LAGRANGE(3.0, lagrange5_pieces)),
    WEFT_KERNEL_D(weft_kernel_lagrange5, "lagrange5", pieces, 5, 0, 5,
                  LAGRANGE(3.0, lagrange5_pieces)),
};

#define KEYS6 .citation = "Keys, IEEE TASSP 1981", .radius = 3.0, .data = &keys6_pieces
const struct weft_kernel_info weft_kernel_keys6[3] = {
    WEFT_KERNEL_RECORD("keys6", pieces, 3, 1,
                       (.description = "cubic convolution over six points", .order = 4,
                        .order_prefiltered = 4, .interpolating = true, .unit_sum = true),
                       KEYS6),
    WEFT_KERNEL_D(weft_kernel_keys6, "keys6", pieces, 3, 1, 3, KEYS6),
    WEFT_KERNEL_DD(weft_kernel_keys6, "keys6", pieces, pieces_3, 3, 1, 2, KEYS6),
};
