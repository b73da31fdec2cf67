// SPDX-License-Identifier: BSD-3-Clause
// Matrices: how people write them, their inverses, and what is wrong with some.
#include <math.h>
#include <string.h>

#include "passes/warp/warp_impl.h"

// ---- how they are written -----------------------------------------------------------------------

void weft_warp_matrix_affine(const double n[6], double out[9])
{
    const double m[9] = {n[0], n[2], n[4], n[1], n[3], n[5], 0.0, 0.0, 1.0};
    memcpy(out, m, sizeof m);
}

// Of whole quarter turns exactly.
static void turn(double degrees, double *cosine, double *sine)
{
    const double rest = fmod(degrees, 360.0), quarters = rest / 90.0;
    static const double exact[4] = {1.0, 0.0, -1.0, 0.0};
    *cosine = cos(rest * (M_PI / 180.0));
    *sine = sin(rest * (M_PI / 180.0));
    if (quarters != floor(quarters))
        return;
    const int q = ((int)quarters + 4) % 4;
    *cosine = exact[q];
    *sine = exact[(q + 3) % 4];
}

// With y down counter-clockwise is x' = c x + s y, y' = c y - s x.
void weft_warp_matrix_rotate(double degrees, const double centre[2], double out[9])
{
    double c, s;
    turn(degrees, &c, &s);
    const double m[9] = {c,   s,   centre[0] - c * centre[0] - s * centre[1],
                         -s,  c,   centre[1] + s * centre[0] - c * centre[1],
                         0.0, 0.0, 1.0};
    memcpy(out, m, sizeof m);
}

// ---- inverses -----------------------------------------------------------------------------------

// Determinants this small beside what their rows could make are rounding's.
static const double SINGULAR = 0x1p-46;

static bool is_affine(const double m[9])
{
    return m[6] == 0.0 && m[7] == 0.0 && m[8] != 0.0;
}

static enum weft_result refuse(const struct weft_warp_plan *plan, double determinant)
{
    const double *m = plan->map.matrix;
    weft_error(plan->log,
               "a warp by the matrix %g,%g,%g, %g,%g,%g, %g,%g,%g, which has no inverse: its "
               "determinant is %g",
               m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8], determinant);
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result invert_affine(const struct weft_warp_plan *plan, const double m[9],
                                      double out[9])
{
    const double a = m[0] / m[8], b = m[1] / m[8], c = m[3] / m[8], d = m[4] / m[8];
    const double e = m[2] / m[8], f = m[5] / m[8], determinant = a * d - b * c;
    if (!(fabs(determinant) > SINGULAR * hypot(a, b) * hypot(c, d)))
        return refuse(plan, determinant);
    const double n[9] = {d / determinant,
                         -b / determinant,
                         (b * f - d * e) / determinant,
                         -c / determinant,
                         a / determinant,
                         (c * e - a * f) / determinant,
                         0.0,
                         0.0,
                         1.0};
    memcpy(out, n, sizeof n);
    return WEFT_OK;
}

static double norm(const double row[3])
{
    return hypot(hypot(row[0], row[1]), row[2]);
}

static enum weft_result invert_projective(const struct weft_warp_plan *plan, const double m[9],
                                          double out[9])
{
    const double n[9] = {
        m[4] * m[8] - m[5] * m[7], m[2] * m[7] - m[1] * m[8], m[1] * m[5] - m[2] * m[4],
        m[5] * m[6] - m[3] * m[8], m[0] * m[8] - m[2] * m[6], m[2] * m[3] - m[0] * m[5],
        m[3] * m[7] - m[4] * m[6], m[1] * m[6] - m[0] * m[7], m[0] * m[4] - m[1] * m[3]};
    const double determinant = m[0] * n[0] + m[1] * n[3] + m[2] * n[6];
    if (!(fabs(determinant) > SINGULAR * norm(m) * norm(m + 3) * norm(m + 6)))
        return refuse(plan, determinant);
    for (int i = 0; i < 9; i++)
        out[i] = n[i] / determinant;
    return WEFT_OK;
}

// ---- between pixels and samples -----------------------------------------------------------------

// From indices to indices: half a pixel and the corners are added before, and taken away after.
static void move_corners(const struct weft_warp_map *map, double m[9])
{
    const double from[2] = {map->result_corner[0] + 0.5, map->result_corner[1] + 0.5};
    const double to[2] = {map->source_corner[0] + 0.5, map->source_corner[1] + 0.5};
    for (int i = 0; i < 9; i += 3)
        m[i + 2] += m[i] * from[0] + m[i + 1] * from[1];
    for (int a = 0; a < 2; a++)
        for (int i = 0; i < 3; i++)
            m[3 * a + i] -= to[a] * m[6 + i];
}

// At the result's corners, as pixel indices.
static void apply(const double m[9], double u, double v, double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = m[3 * i] * u + m[3 * i + 1] * v + m[3 * i + 2];
}

static void corner(const struct weft_warp_info *info, int i, double out[2])
{
    out[0] = i & 1 ? info->width - 0.5 : -0.5;
    out[1] = i & 2 ? info->height - 0.5 : -0.5;
}

// The horizon is where w is 0, and straight: pixels meet it where corners lie on both sides.
static enum weft_result check_horizon(const struct weft_warp_plan *plan, double m[9])
{
    double least = INFINITY, most = -INFINITY, w[4];
    for (int i = 0; i < 4; i++) {
        double at[2], p[3];
        corner(&plan->info, i, at);
        apply(m, at[0], at[1], p);
        w[i] = p[2];
        least = fmin(least, w[i]);
        most = fmax(most, w[i]);
    }
    if (least > 0.0 || most < 0.0) {
        // So that w is positive, and of about 1.
        const double scale = 1.0 / (0.5 * (least + most));
        for (int i = 0; i < 9; i++)
            m[i] *= scale;
        return WEFT_OK;
    }
    weft_error(plan->log,
               "a warp whose horizon meets the %d x %d pixels of the result: w is %g, %g, %g and "
               "%g at their corners",
               plan->info.width, plan->info.height, w[0], w[1], w[2], w[3]);
    return WEFT_ERR_ARGUMENT;
}

// Positions are extreme at corners, and w least.
static enum weft_result check_reach(const struct weft_warp_plan *plan, const double m[9])
{
    for (int i = 0; i < 4; i++) {
        double at[2], p[3];
        corner(&plan->info, i, at);
        apply(m, at[0], at[1], p);
        const double x = p[0] / p[2], y = p[1] / p[2];
        if (fabs(x) <= WEFT_WARP_MAX_POSITION && fabs(y) <= WEFT_WARP_MAX_POSITION)
            continue;
        weft_error(plan->log,
                   "a warp of %d x %d pixels whose corner (%g, %g) lies at (%g, %g) of the source: "
                   "at most %d is possible",
                   plan->info.width, plan->info.height, at[0] + 0.5, at[1] + 0.5, x, y,
                   WEFT_WARP_MAX_POSITION);
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

// Of derivatives (m0 - x m6) / w and (m1 - x m7) / w the numerators are linear along u and v: their
// norm is largest at a corner, and w least.
static void set_scales(struct weft_warp_plan *plan, const double m[9])
{
    for (int a = 0; a < 2; a++) {
        const double *row = m + 3 * a;
        double most = 0.0, least = INFINITY;
        for (int i = 0; i < 4; i++) {
            double at[2], p[3];
            corner(&plan->info, i, at);
            apply(m, at[0], at[1], p);
            most = fmax(most, hypot(row[0] * p[2] - p[a] * m[6], row[1] * p[2] - p[a] * m[7]));
            least = fmin(least, p[2]);
        }
        plan->info.scale[a] = fmax(1.0, most / (least * least));
    }
}

static bool is_zero(const double m[9])
{
    for (int i = 0; i < 9; i++)
        if (m[i] != 0.0)
            return false;
    return true;
}

static enum weft_result check_finite(const struct weft_warp_plan *plan)
{
    const struct weft_warp_map *map = &plan->map;
    bool finite = true;
    for (int i = 0; i < 9; i++)
        finite = finite && isfinite(map->matrix[i]);
    for (int a = 0; a < 2; a++)
        finite = finite && fabs(map->source_corner[a]) <= WEFT_WARP_MAX_POSITION &&
                 fabs(map->result_corner[a]) <= WEFT_WARP_MAX_POSITION;
    if (finite)
        return WEFT_OK;
    const double *m = map->matrix;
    weft_error(plan->log,
               "a warp by the matrix %g,%g,%g, %g,%g,%g, %g,%g,%g, from (%g, %g) to (%g, %g): all "
               "must be finite, corners within %d",
               m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8], map->source_corner[0],
               map->source_corner[1], map->result_corner[0], map->result_corner[1],
               WEFT_WARP_MAX_POSITION);
    return WEFT_ERR_ARGUMENT;
}

static bool is_aligned(const double m[9])
{
    return (m[1] == 0.0 && m[3] == 0.0) || (m[0] == 0.0 && m[4] == 0.0);
}

enum weft_result weft_warp_set_matrix(struct weft_warp_plan *plan)
{
    static const double identity[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
    const double *m = is_zero(plan->map.matrix) ? identity : plan->map.matrix;
    double inverse[9];
    enum weft_result res = check_finite(plan);
    if (res != WEFT_OK)
        return res;
    const bool affine = is_affine(m);
    res = affine ? invert_affine(plan, m, inverse) : invert_projective(plan, m, inverse);
    if (res != WEFT_OK)
        return res;
    move_corners(&plan->map, inverse);
    if (!affine)
        res = check_horizon(plan, inverse);
    if (res == WEFT_OK)
        res = check_reach(plan, inverse);
    if (res != WEFT_OK)
        return res;
    set_scales(plan, inverse);
    memcpy(plan->info.inverse, inverse, sizeof inverse);
    plan->info.method = !affine               ? WEFT_WARP_PROJECTIVE
                        : is_aligned(inverse) ? WEFT_WARP_ALIGNED
                                              : WEFT_WARP_AFFINE;
    return WEFT_OK;
}
