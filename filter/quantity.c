// SPDX-License-Identifier: BSD-3-Clause
#include "filter/quantity.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "filter/check.h"
#include "filter/closest.h"
#include "filter/quantity_impl.h"

const char *const weft_quantity_names[] = {"value",
                                           "gradient",
                                           "gradient-magnitude",
                                           "normal",
                                           "hessian",
                                           "laplacian",
                                           "mean-curvature",
                                           "gaussian-curvature",
                                           "principal-curvatures",
                                           NULL};

// By quantity: names of its channels, NULL-ended, and the orders of derivatives that it is of.
static const struct {
    const char *channel[7];
    int orders; // bit 0: the value, 1: the gradient, 2: the Hessian
} records[WEFT_QUANTITY_COUNT] = {
    [WEFT_QUANTITY_VALUE] = {{"Y"}, 1},
    [WEFT_QUANTITY_GRADIENT] = {{"gradient.X", "gradient.Y", "gradient.Z"}, 2},
    [WEFT_QUANTITY_GRADIENT_MAGNITUDE] = {{"gradient-magnitude"}, 2},
    [WEFT_QUANTITY_NORMAL] = {{"normal.X", "normal.Y", "normal.Z"}, 2},
    [WEFT_QUANTITY_HESSIAN] = {{"hessian.XX", "hessian.XY", "hessian.XZ", "hessian.YY",
                                "hessian.YZ", "hessian.ZZ"},
                               4},
    [WEFT_QUANTITY_LAPLACIAN] = {{"laplacian"}, 4},
    [WEFT_QUANTITY_MEAN_CURVATURE] = {{"mean-curvature"}, 6},
    [WEFT_QUANTITY_GAUSSIAN_CURVATURE] = {{"gaussian-curvature"}, 6},
    [WEFT_QUANTITY_PRINCIPAL_CURVATURES] = {{"principal-curvature.1", "principal-curvature.2"}, 6},
};

// Axes of a transform are apart where the determinant of its columns, with largest entries of 1, is
// above this: below it the inverse has no digits left that floats would show.
#define LEAST_DETERMINANT 1e-12

// In the order of struct weft_quantities.derivative; entries of each order follow one another.
static const struct weft_derivative all[WEFT_DERIVATIVES] = {
    {{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}, {{2, 0, 0}},
    {{1, 1, 0}}, {{1, 0, 1}}, {{0, 2, 0}}, {{0, 1, 1}}, {{0, 0, 2}}};

int weft_quantity_channels(enum weft_quantity q)
{
    int count = 0;
    while (records[q].channel[count])
        count++;
    return count;
}

// ---- lists --------------------------------------------------------------------------------------

enum weft_result weft_quantities_create(const struct weft_log *log,
                                        const enum weft_quantity *quantity, int count,
                                        struct weft_quantities *out)
{
    int orders = 0;
    *out = (struct weft_quantities){0};
    weft_require(log, quantity && count >= 1);
    for (int i = 0; i < count; i++) {
        weft_require_enum(log, quantity[i], WEFT_QUANTITY_COUNT - 1);
        for (int k = 0; k < i; k++)
            if (quantity[k] == quantity[i]) {
                weft_error(log, "quantity %s is asked for twice", weft_quantity_names[quantity[i]]);
                goto fail;
            }
        out->quantity[out->count++] = quantity[i];
        orders |= records[quantity[i]].orders;
        for (const char *const *name = records[quantity[i]].channel; *name; name++)
            out->channel[out->channel_count++] = *name;
    }
    for (int i = 0; i < WEFT_DERIVATIVES; i++)
        if (orders >> weft_derivative_order(&all[i]) & 1)
            out->derivative[out->derivative_count++] = all[i];
    return WEFT_OK;
fail:
    *out = (struct weft_quantities){0};
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result find(const struct weft_log *log, const char *text, size_t length,
                             enum weft_quantity *out)
{
    char explanation[256];
    for (int i = 0; i < WEFT_QUANTITY_COUNT; i++) {
        const char *name = weft_quantity_names[i];
        *out = (enum weft_quantity)i;
        if (strlen(name) == length && !strncmp(name, text, length))
            return WEFT_OK;
    }
    weft_error(
        log, "no quantity '%.*s'%s", (int)(length < 64 ? length : 64), text,
        weft_closest_explain(text, length, weft_quantity_names, explanation, sizeof explanation));
    return WEFT_ERR_ARGUMENT;
}

enum weft_result weft_quantities_parse(const struct weft_log *log, const char *text,
                                       struct weft_quantities *out)
{
    enum weft_quantity quantity[WEFT_QUANTITY_COUNT + 1]; // one more: some is there twice then
    int count = 0;
    *out = (struct weft_quantities){0};
    for (;; text++) {
        const size_t length = strcspn(text, ",");
        const enum weft_result res = find(log, text, length, &quantity[count]);
        if (res != WEFT_OK)
            return res;
        text += length;
        if (++count > WEFT_QUANTITY_COUNT || !*text)
            return weft_quantities_create(log, quantity, count, out);
    }
}

// ---- transforms ---------------------------------------------------------------------------------

// Of the columns divided by their largest entries, so that a small voxel is not a singular one.
static double invert(const double (*m)[4], double out[3][3])
{
    double a[3][3], scale[3];
    for (int c = 0; c < 3; c++) {
        scale[c] = fmax(fmax(fabs(m[0][c]), fabs(m[1][c])), fabs(m[2][c]));
        for (int r = 0; r < 3; r++)
            a[r][c] = m[r][c] / scale[c];
    }
    for (int r = 0; r < 3; r++) {
        const int p = (r + 1) % 3, q = (r + 2) % 3;
        for (int c = 0; c < 3; c++) {
            const int s = (c + 1) % 3, t = (c + 2) % 3;
            out[c][r] = a[p][s] * a[q][t] - a[p][t] * a[q][s];
        }
    }
    const double determinant = a[0][0] * out[0][0] + a[0][1] * out[1][0] + a[0][2] * out[2][0];
    for (int i = 0; i < 9; i++)
        out[i / 3][i % 3] = out[i / 3][i % 3] / determinant / scale[i / 3];
    return determinant;
}

enum weft_result weft_quantity_transform_create(const struct weft_log *log,
                                                const double (*index_to_world)[4],
                                                struct weft_quantity_transform *out)
{
    static const double identity[3][4] = {{1.0}, {0.0, 1.0}, {0.0, 0.0, 1.0}};
    const double determinant = invert(index_to_world ? index_to_world : identity, out->inverse);
    bool good = fabs(determinant) > LEAST_DETERMINANT;
    for (int i = 0; i < 9; i++)
        good = good && isfinite(out->inverse[i / 3][i % 3]);
    if (good)
        return WEFT_OK;
    *out = (struct weft_quantity_transform){{{0.0}}};
    weft_error(log,
               "derivatives in world space take a finite transform with an inverse: the "
               "determinant of this one, of axes with largest entries of 1, is %g",
               determinant);
    return WEFT_ERR_ARGUMENT;
}

// ---- channels -----------------------------------------------------------------------------------

// Points that are computed at once, so that rows of them stay in the first cache.
enum { BLOCK = 64 };
typedef double row[BLOCK];

// What a block of points has, and what is made of it.
struct block {
    row derivative[WEFT_DERIVATIVES]; // of the list, in its order
    row g[3], h[6];                   // in world space: XX, XY, XZ, YY, YZ, ZZ
    row magnitude, normal[3], laplacian, mean, gaussian, principal[2];
};

// What stays of a list and a transform for all blocks.
struct work {
    struct weft_quantity_terms terms;
    double unit; // a power of two near the largest entry of A^-1: squares of g / unit are in range
    bool normals, curvatures;
};

struct weft_quantity_terms weft_quantity_terms_of(const struct weft_quantities *list,
                                                  const struct weft_quantity_transform *transform)
{
    static const int pair[6][2] = {{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}};
    const double(*b)[3] = transform->inverse;
    struct weft_quantity_terms out = {.first = {-1, -1, -1}};
    for (int i = list->derivative_count - 1; i >= 0; i--)
        out.first[weft_derivative_order(&list->derivative[i])] = i;
    for (int to = 0; to < 3; to++)
        for (int from = 0; from < 3; from++)
            out.g[to][from] = b[from][to];
    for (int to = 0; to < 6; to++)
        for (int from = 0; from < 6; from++) {
            const int i = pair[to][0], j = pair[to][1], k = pair[from][0], l = pair[from][1];
            out.h[to][from] = b[k][i] * b[l][j] + (k != l ? b[l][i] * b[k][j] : 0.0);
        }
    return out;
}

static struct work work_of(const struct weft_quantities *list,
                           const struct weft_quantity_transform *transform)
{
    struct work work = {.terms = weft_quantity_terms_of(list, transform)};
    double largest = 0.0;
    int exponent;
    for (int i = 0; i < list->count; i++) {
        const enum weft_quantity q = list->quantity[i];
        const bool curved = q >= WEFT_QUANTITY_MEAN_CURVATURE;
        work.curvatures |= curved;
        work.normals |=
            curved || q == WEFT_QUANTITY_NORMAL || q == WEFT_QUANTITY_GRADIENT_MAGNITUDE;
    }
    for (int i = 0; i < 9; i++)
        largest = fmax(largest, fabs(transform->inverse[i / 3][i % 3]));
    frexp(largest, &exponent);
    work.unit = ldexp(1.0, exponent);
    return work;
}

static void make_gradient(const struct work *work, int count, struct block *b)
{
    const row *d = b->derivative + work->terms.first[1];
    for (int r = 0; r < 3; r++) {
        const double *w = work->terms.g[r];
        for (int i = 0; i < count; i++)
            b->g[r][i] = w[0] * d[0][i] + w[1] * d[1][i] + w[2] * d[2][i];
    }
}

static void make_hessian(const struct work *work, int count, struct block *b)
{
    const row *d = b->derivative + work->terms.first[2];
    for (int r = 0; r < 6; r++) {
        const double *w = work->terms.h[r];
        for (int i = 0; i < count; i++)
            b->h[r][i] = w[0] * d[0][i] + w[1] * d[1][i] + w[2] * d[2][i] + w[3] * d[3][i] +
                         w[4] * d[4][i] + w[5] * d[5][i];
    }
    for (int i = 0; i < count; i++)
        b->laplacian[i] = b->h[0][i] + b->h[3][i] + b->h[5][i];
}

static void make_normals(const struct work *work, int count, struct block *b)
{
    const double unit = work->unit, from = 1.0 / unit;
    for (int i = 0; i < count; i++) {
        const double x = b->g[0][i] * from, y = b->g[1][i] * from, z = b->g[2][i] * from;
        const double length = sqrt(x * x + y * y + z * z);
        const double divide = length == 0.0 ? 0.0 : -1.0 / length; // NAN stays NAN
        b->magnitude[i] = length * unit;
        b->normal[0][i] = x * divide;
        b->normal[1][i] = y * divide;
        b->normal[2][i] = z * divide;
    }
}

// Of the shape operator in the plane square to the normal, in a basis of two vectors of it (Duff
// and others 2017, "Building an orthonormal basis, revisited"): a symmetric matrix of 2 x 2, whose
// eigenvalues do not cancel where they are near each other, as a trace's and a norm's do.
static void make_curvatures(int count, struct block *b)
{
    for (int i = 0; i < count; i++) {
        const double x = b->normal[0][i], y = b->normal[1][i], z = b->normal[2][i];
        const double sign = copysign(1.0, z), s = -1.0 / (sign + z), t = x * y * s;
        const double ux = 1.0 + sign * x * x * s, uy = sign * t, uz = -sign * x;
        const double vx = t, vy = sign + y * y * s, vz = -y;
        const double xx = b->h[0][i], xy = b->h[1][i], xz = b->h[2][i];
        const double yy = b->h[3][i], yz = b->h[4][i], zz = b->h[5][i];
        const double hux = xx * ux + xy * uy + xz * uz, huy = xy * ux + yy * uy + yz * uz;
        const double huz = xz * ux + yz * uy + zz * uz;
        const double hvx = xx * vx + xy * vy + xz * vz, hvy = xy * vx + yy * vy + yz * vz;
        const double hvz = xz * vx + yz * vy + zz * vz;
        const double length = b->magnitude[i], divide = length == 0.0 ? 0.0 : -1.0 / length;
        const double a = (ux * hux + uy * huy + uz * huz) * divide;
        const double m = (vx * hux + vy * huy + vz * huz) * divide;
        const double c = (vx * hvx + vy * hvy + vz * hvz) * divide;
        const double mean = 0.5 * (a + c), half = 0.5 * (a - c);
        const double apart = sqrt(half * half + m * m);
        b->mean[i] = mean;
        b->gaussian[i] = a * c - m * m;
        b->principal[0][i] = mean + apart;
        b->principal[1][i] = mean - apart;
    }
}

static void make(const struct work *work, int count, struct block *b)
{
    if (work->terms.first[1] >= 0)
        make_gradient(work, count, b);
    if (work->terms.first[2] >= 0)
        make_hessian(work, count, b);
    if (work->normals)
        make_normals(work, count, b);
    if (work->curvatures)
        make_curvatures(count, b);
}

// The rows of a quantity's channels, which follow one another in a block.
static const row *rows_of(const struct work *work, const struct block *b, enum weft_quantity q)
{
    switch (q) {
    case WEFT_QUANTITY_VALUE:
        return b->derivative + work->terms.first[0];
    case WEFT_QUANTITY_GRADIENT:
        return b->g;
    case WEFT_QUANTITY_GRADIENT_MAGNITUDE:
        return &b->magnitude;
    case WEFT_QUANTITY_NORMAL:
        return b->normal;
    case WEFT_QUANTITY_HESSIAN:
        return b->h;
    case WEFT_QUANTITY_LAPLACIAN:
        return &b->laplacian;
    case WEFT_QUANTITY_MEAN_CURVATURE:
        return &b->mean;
    case WEFT_QUANTITY_GAUSSIAN_CURVATURE:
        return &b->gaussian;
    default:
        return b->principal;
    }
}

void weft_quantities_compute(const struct weft_quantities *list,
                             const struct weft_quantity_transform *transform,
                             const double *derivative, double *channel)
{
    const struct work work = work_of(list, transform);
    struct block block;
    for (int i = 0; i < list->derivative_count; i++)
        block.derivative[i][0] = derivative[i];
    make(&work, 1, &block);
    for (int i = 0, c = 0; i < list->count; i++) {
        const row *rows = rows_of(&work, &block, list->quantity[i]);
        for (int k = 0; k < weft_quantity_channels(list->quantity[i]); k++)
            channel[c++] = rows[k][0];
    }
}

void weft_quantities_compute_planes(const struct weft_quantities *list,
                                    const struct weft_quantity_transform *transform, size_t count,
                                    const float *const *derivative, float *const *channel)
{
    const struct work work = work_of(list, transform);
    struct block block;
    for (size_t from = 0; from < count; from += BLOCK) {
        const int n = count - from < BLOCK ? (int)(count - from) : BLOCK;
        for (int i = 0; i < list->derivative_count; i++)
            for (int k = 0; k < n; k++)
                block.derivative[i][k] = (double)derivative[i][from + (size_t)k];
        make(&work, n, &block);
        for (int i = 0, c = 0; i < list->count; i++) {
            const row *rows = rows_of(&work, &block, list->quantity[i]);
            for (int r = 0; r < weft_quantity_channels(list->quantity[i]); r++, c++)
                for (int k = 0; k < n; k++)
                    channel[c][from + (size_t)k] = (float)rows[r][k];
        }
    }
}
