// SPDX-License-Identifier: BSD-3-Clause
// Affine maps between lattices.
#include <string.h>

#include "passes/lattice/lattice_impl.h"

// By cofactors, of columns scaled to length 1: voxels may be as small as they like.
bool weft_lattice_invert(const double m[3][4], double out[3][4])
{
    double a[3][3], norm[3], det = 0.0;
    for (int c = 0; c < 3; c++) {
        norm[c] = hypot(hypot(m[0][c], m[1][c]), m[2][c]);
        for (int r = 0; r < 3; r++)
            a[r][c] = m[r][c] / norm[c];
    }
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) {
            const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            out[c][r] = a[r1][c1] * a[r2][c2] - a[r1][c2] * a[r2][c1];
        }
    for (int c = 0; c < 3; c++)
        det += a[0][c] * out[c][0];
    if (!(fabs(det) > 1e-12))
        return false;
    for (int r = 0; r < 3; r++) {
        for (int c = 0; c < 3; c++)
            out[r][c] = out[r][c] / det / norm[r];
        out[r][3] = -(out[r][0] * m[0][3] + out[r][1] * m[1][3] + out[r][2] * m[2][3]);
        for (int c = 0; c < 4; c++)
            if (!isfinite(out[r][c]))
                return false;
    }
    return true;
}

void weft_lattice_multiply(const double a[3][4], const double b[3][4], double out[3][4])
{
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++)
            out[r][c] = a[r][0] * b[0][c] + a[r][1] * b[1][c] + a[r][2] * b[2][c] +
                        (c == 3 ? a[r][3] : 0.0);
}

void weft_lattice_map_box(const double m[3][4], const double min[3], const double max[3],
                          double out_min[3], double out_max[3])
{
    for (int r = 0; r < 3; r++) {
        out_min[r] = out_max[r] = m[r][3];
        for (int c = 0; c < 3; c++) {
            const double a = m[r][c] * min[c], b = m[r][c] * max[c];
            out_min[r] += fmin(a, b);
            out_max[r] += fmax(a, b);
        }
    }
}

// An entry that is 0 but for what rounding made of it.
static double clean(double value, double largest)
{
    const double near = rint(value);
    return fabs(value) < 0x1p-44 * largest          ? 0.0
           : fabs(value - near) < 0x1p-44 * largest ? near
                                                    : value;
}

enum weft_result weft_lattice_map_compute(const struct weft_log *log, const double (*source)[4],
                                          const double (*moved)[4], const double (*result)[4],
                                          double (*to_source)[4])
{
    static const char *const names[] = {"the source's transform", "the matrix",
                                        "the result's transform"};
    const double(*given[3])[4] = {source, moved, result};
    double inverse[3][3][4], world[3][4];
    for (int i = 0; i < 3; i++) {
        if (!given[i] || weft_lattice_invert(given[i], inverse[i]))
            continue;
        weft_error(log, "%s is singular or not finite: (%g %g %g %g) (%g %g %g %g) (%g %g %g %g)",
                   names[i], given[i][0][0], given[i][0][1], given[i][0][2], given[i][0][3],
                   given[i][1][0], given[i][1][1], given[i][1][2], given[i][1][3], given[i][2][0],
                   given[i][2][1], given[i][2][2], given[i][2][3]);
        return WEFT_ERR_ARGUMENT;
    }
    memcpy(world, result, sizeof world);
    if (moved)
        weft_lattice_multiply(inverse[1], result, world);
    weft_lattice_multiply(inverse[0], world, to_source);
    for (int r = 0; r < 3; r++) {
        double largest = 0.0;
        for (int c = 0; c < 3; c++)
            largest = fmax(largest, fabs(to_source[r][c]));
        for (int c = 0; c < 3; c++)
            to_source[r][c] = clean(to_source[r][c], largest);
    }
    return WEFT_OK;
}
