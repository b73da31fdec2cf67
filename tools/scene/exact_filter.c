// SPDX-License-Identifier: BSD-3-Clause
// Integrals of a pixel's filter h(x) h(y) over convex pieces. By Green's theorem the integral over
// a piece is that of H(x) h(y) dy along its outline, H being the integral of h: with polynomials of
// degree d, Gauss and Legendre's rule of d + 1 points is exact on each side.
#include <math.h>
#include <stdlib.h>

#include "tools/common/log.h"
#include "tools/scene/exact_parts.h"

enum { NODES = EXACT_MAX_DEGREE + 1, MOST_CORNERS = 4 * WEFT_KERNEL_MAX_WIDTH };

// ---- series -------------------------------------------------------------------------------------

// The kernel of a pixel that lies at the middle of its cell.
struct shape {
    struct weft_kernel kernel;
    double scale; // pixels for each unit of the kernel
};

// The coefficients of the polynomial that has h's values at Chebyshev's NODES points between two
// places of the kernel, from > to too.
static void find_series(const struct weft_kernel *kernel, double from, double to, double *out)
{
    double value[NODES];
    for (int i = 0; i < NODES; i++) {
        const double u = cos(M_PI * (i + 0.5) / NODES);
        value[i] = weft_kernel_weight(kernel, 0.5 * (from + to) + 0.5 * (to - from) * u);
    }
    for (int k = 0; k < NODES; k++) {
        out[k] = 0.0;
        for (int i = 0; i < NODES; i++)
            out[k] += value[i] * cos(M_PI * k * (i + 0.5) / NODES);
        out[k] *= (k ? 2.0 : 1.0) / NODES;
    }
}

// The largest of the coefficients from one on.
static double find_tail(const double *series, int first)
{
    double most = 0.0;
    for (int k = first; k < NODES; k++)
        most = fmax(most, fabs(series[k]));
    return most;
}

// Whether the kernel has a corner within its support: no series goes across it.
static bool is_corner(const struct weft_kernel *kernel, double x)
{
    double series[NODES];
    find_series(kernel, x - 0.25, x + 0.25, series);
    return find_tail(series, NODES - 4) > 1e-14 * find_tail(series, 0);
}

// ---- where cells are cut ------------------------------------------------------------------------

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static bool add_cut(const struct shape *s, double corner, int *count, double *cut)
{
    const double x = 0.5 + s->scale * corner, at = x - floor(x);
    if (at < 1e-13 || at > 1.0 - 1e-13)
        return true;
    for (int i = 0; i < *count; i++)
        if (fabs(cut[i] - at) < 1e-13)
            return true;
    if (*count == EXACT_MAX_PARTS)
        return false;
    cut[(*count)++] = at;
    return true;
}

// Kernels have corners at their ends and at half integers; those that are normalised also as far
// from the integers as the ends are.
static bool find_cuts(const struct shape *s, struct exact_filter *out)
{
    const double r = s->kernel.support, place[] = {0.0, 0.5, r - floor(r), ceil(r) - r};
    int count = 1;
    bool found = add_cut(s, -r, &count, out->cut) && add_cut(s, r, &count, out->cut);
    for (int e = 0; e < (s->kernel.normalised ? 4 : 2); e++)
        for (int i = -(int)ceil(r); i < ceil(r) && found; i++)
            if (fabs(i + place[e]) < r && is_corner(&s->kernel, i + place[e]))
                found = add_cut(s, i + place[e], &count, out->cut);
    out->cut[0] = 0.0;
    out->parts = count;
    out->cut[count] = 1.0;
    qsort(out->cut, (size_t)count, sizeof *out->cut, compare);
    return found && count < EXACT_MAX_PARTS;
}

// ---- Gauss and Legendre's rule ------------------------------------------------------------------

// Of `count` points of 0 to 1, by Newton's method from Tricomi's estimate.
static void find_rule(int count, double *node, double *weight)
{
    for (int i = 0; i < count; i++) {
        double x = cos(M_PI * (i + 0.75) / (count + 0.5)), slope = 1.0;
        for (int step = 0; step < 8; step++) {
            double p = 1.0, before = 0.0;
            for (int k = 0; k < count; k++) {
                const double next = ((2.0 * k + 1.0) * x * p - k * before) / (k + 1.0);
                before = p;
                p = next;
            }
            slope = count * (x * p - before) / (x * x - 1.0);
            x -= p / slope;
        }
        node[i] = 0.5 * (1.0 + x);
        weight[i] = 1.0 / ((1.0 - x * x) * slope * slope);
    }
}

// ---- making -------------------------------------------------------------------------------------

static enum weft_result check(const struct scene_exact_params *params, struct shape *out)
{
    const struct weft_log *log = params->log;
    out->kernel = params->filter;
    enum weft_result res = WEFT_OK;
    if (!out->kernel.info)
        res = weft_kernel_create(log, weft_kernel_find("nearest"), NULL, &out->kernel);
    if (res == WEFT_OK)
        res = weft_kernel_check(log, &out->kernel);
    if (res != WEFT_OK)
        return res;
    const char *name = out->kernel.info->name;
    const double width = params->filter_width;
    if (out->kernel.radial || out->kernel.prefiltered) {
        log_error(log, "exact pictures: %s is %s", name,
                  out->kernel.radial ? "radial" : "prefiltered");
        return WEFT_ERR_UNSUPPORTED;
    }
    if (out->kernel.info->derivation || !(width >= 0.0 && width <= 2.0 * EXACT_MAX_RADIUS)) {
        log_error(log, "exact pictures: a filter %s of %g pixels: %s", name, width,
                  out->kernel.info->derivation ? "it is a derivative" : "0 to 16 are to be had");
        return WEFT_ERR_ARGUMENT;
    }
    out->scale = width > 0.0 ? width / (2.0 * out->kernel.support) : 1.0;
    return WEFT_OK;
}

// Of the axis y rows go up, those of the library's patterns down: kernels that are not even are
// turned.
static void fill_series(const struct shape *s, struct exact_filter *out, double *error)
{
    double(*series)[NODES] = out->series;
    for (int axis = 0; axis < 2; axis++)
        for (int part = 0; part < out->parts; part++)
            for (int o = -out->radius; o <= out->radius; o++, series++) {
                const double sign = (axis ? 1.0 : -1.0) / s->scale;
                const double from = sign * (out->cut[part] - o - 0.5);
                const double to = sign * (out->cut[part + 1] - o - 0.5);
                find_series(&s->kernel, from, to, *series);
                if (axis == 0)
                    *error += (out->cut[part + 1] - out->cut[part]) * find_tail(*series, NODES - 2);
            }
}

// The integral of a series from the middle of its part on.
static void integrate(const struct exact_filter *filter, int part, const double *series,
                      double *out)
{
    const double half = 0.5 * (filter->cut[part + 1] - filter->cut[part]);
    const int degree = filter->degree;
    for (int k = 1; k <= degree + 1; k++) {
        const double below = (k == 1 ? 2.0 : 1.0) * series[k - 1];
        const double above = k + 1 <= degree ? series[k + 1] : 0.0;
        out[k] = half * (below - above) / (2.0 * k);
    }
    out[0] = 0.0;
}

// Scales the filter to an integral of 1. Returns the integral of its magnitude; 0: it has none.
static double normalise(struct exact_filter *out, double error)
{
    const int side = 2 * out->radius + 1, count = out->parts * side;
    double sum = 0.0, magnitude = 0.0, most = 0.0;
    for (int i = 0; i < 2 * count; i++)
        most = fmax(most, find_tail(out->series[i], 0));
    for (int i = 0; i < 2 * count; i++)
        for (int k = out->degree + 1; k < NODES; k++)
            if (fabs(out->series[i][k]) > 4e-15 * most)
                out->degree = k;
    for (int i = 0; i < 2 * count; i++) {
        const int part = i / side % out->parts;
        double all = 0.0;
        for (int k = 0; k <= out->degree; k += 2)
            all += out->series[i][k] / (1.0 - k * k);
        out->share[i] = all * (out->cut[part + 1] - out->cut[part]);
        sum += i < count ? out->share[i] : 0.0;
        magnitude += i < count ? fabs(out->share[i]) : 0.0;
    }
    if (!(sum > 1e-3 * magnitude))
        return 0.0;
    for (int i = 0; i < 2 * count; i++) {
        out->share[i] /= sum;
        for (int k = 0; k <= out->degree; k++)
            out->series[i][k] /= sum;
    }
    for (int i = 0; i < count; i++)
        integrate(out, i / side, out->series[i], out->whole[i]);
    out->error = 2.0 * magnitude / sum * (error / sum + 1e-13);
    return magnitude;
}

enum weft_result exact_filter_make(const struct scene_exact_params *params,
                                   struct exact_filter *out)
{
    struct shape shape;
    double error = 0.0;
    *out = (struct exact_filter){.degree = 0};
    enum weft_result res = check(params, &shape);
    if (res != WEFT_OK)
        return res;
    out->radius = (int)ceil(shape.scale * shape.kernel.support + 0.5 - 1e-13) - 1;
    if (out->radius > EXACT_MAX_RADIUS || !find_cuts(&shape, out)) {
        log_error(params->log,
                  "exact pictures: %s reaches %d pixels, or has corners in too many "
                  "places of a pixel: %d are to be had",
                  shape.kernel.info->name, out->radius, EXACT_MAX_RADIUS);
        return WEFT_ERR_LIMIT;
    }
    const size_t count = (size_t)(out->parts * (2 * out->radius + 1));
    out->series = calloc(2 * count, sizeof *out->series);
    out->whole = calloc(count, sizeof *out->whole);
    out->share = calloc(2 * count, sizeof *out->share);
    if (!out->series || !out->whole || !out->share) {
        exact_filter_clear(out);
        return WEFT_ERR_MEMORY;
    }
    fill_series(&shape, out, &error);
    if (!(normalise(out, error) > 0.0)) {
        log_error(params->log, "exact pictures: the weights of %s add up to nothing",
                  shape.kernel.info->name);
        exact_filter_clear(out);
        return WEFT_ERR_ARGUMENT;
    }
    find_rule(out->degree + 1, out->node, out->weight);
    return WEFT_OK;
}

void exact_filter_clear(struct exact_filter *filter)
{
    free(filter->series);
    free(filter->whole);
    free(filter->share);
    *filter = (struct exact_filter){.degree = 0};
}

// ---- integrals ----------------------------------------------------------------------------------

// Chebyshev's polynomials at u.
static void find_polynomials(double u, int degree, double *out)
{
    out[0] = 1.0;
    out[1] = u;
    for (int k = 2; k <= degree; k++)
        out[k] = 2.0 * u * out[k - 1] - out[k - 2];
}

static double find_value(const double *series, const double *polynomial, int degree)
{
    double sum = 0.0;
    for (int k = 0; k <= degree; k++)
        sum += series[k] * polynomial[k];
    return sum;
}

// Whether a piece is all of its part, as most are.
static bool is_part(const struct exact_filter *filter, const struct exact_piece *piece,
                    const int part[2])
{
    bool same = piece->count == 4;
    for (int i = 0; i < 4 && same; i++)
        same = piece->corner[i][0] == filter->cut[part[0] + (i == 1 || i == 2)] &&
               piece->corner[i][1] == filter->cut[part[1] + i / 2];
    return same;
}

static void add_part(const struct exact_filter *filter, const int part[2], double *sum)
{
    const int side = 2 * filter->radius + 1;
    const double *across = filter->share + part[0] * side;
    const double *up = filter->share + (filter->parts + part[1]) * side;
    for (int i = 0; i < side * side; i++)
        sum[i] += up[i / side] * across[i % side];
}

void exact_filter_add(const struct exact_filter *filter, const struct exact_piece *piece,
                      double *sum)
{
    const int side = 2 * filter->radius + 1, degree = filter->degree;
    const int part[2] = {piece->part % filter->parts, piece->part / filter->parts};
    const double(*whole)[NODES + 1] = (const double(*)[NODES + 1]) filter->whole + part[0] * side;
    const double(*series)[NODES] =
        (const double(*)[NODES])filter->series + (filter->parts + part[1]) * side;
    double low[2], scale[2], across[2 * EXACT_MAX_RADIUS + 1], polynomial[2][NODES + 1];
    if (is_part(filter, piece, part)) {
        add_part(filter, part, sum);
        return;
    }
    for (int axis = 0; axis < 2; axis++) {
        low[axis] = filter->cut[part[axis]];
        scale[axis] = 2.0 / (filter->cut[part[axis] + 1] - low[axis]);
    }
    for (int i = 0; i < piece->count; i++) {
        const double *a = piece->corner[i], *b = piece->corner[(i + 1) % piece->count];
        if (a[1] == b[1])
            continue;
        for (int n = 0; n <= degree; n++) {
            for (int axis = 0; axis < 2; axis++) {
                const double at = a[axis] + filter->node[n] * (b[axis] - a[axis]);
                find_polynomials(scale[axis] * (at - low[axis]) - 1.0, degree + 1,
                                 polynomial[axis]);
            }
            for (int x = 0; x < side; x++)
                across[x] = find_value(whole[x], polynomial[0], degree + 1);
            for (int y = 0; y < side; y++) {
                const double up = filter->weight[n] * (b[1] - a[1]) *
                                  find_value(series[y], polynomial[1], degree);
                for (int x = 0; x < side; x++)
                    sum[y * side + x] += up * across[x];
            }
        }
    }
}
