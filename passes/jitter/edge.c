// SPDX-License-Identifier: BSD-3-Clause
#include "passes/jitter/edge.h"

#include <math.h>
#include <stdlib.h>

#include "filter/check.h"

// ---- boxes and discs
// ------------------------------------------------------------------------------

// The magnitudes of a unit normal, the larger first; false for what is no normal.
static bool resolve(const double normal[2], double size[2])
{
    const double x = fabs(normal[0]), y = fabs(normal[1]), length = hypot(x, y);
    size[0] = fmax(x, y) / length;
    size[1] = fmin(x, y) / length;
    return isfinite(x) && isfinite(y) && length > 0.0;
}

double weft_edge_square(const double normal[2], double distance)
{
    double n[2];
    if (!resolve(normal, n) || isnan(distance))
        return NAN;
    const double a = n[0], b = n[1], d = fabs(distance), reach = 0.5 * (a + b);
    if (d <= 0.5 * (a - b))
        return 0.5 + distance / a;
    // A triangle, of legs (reach - d) / a and (reach - d) / b.
    const double corner = d < reach ? (reach - d) * (reach - d) / (2.0 * a * b) : 0.0;
    return distance > 0.0 ? 1.0 - corner : corner;
}

double weft_edge_disc(double distance)
{
    if (isnan(distance))
        return NAN;
    const double u = fmin(fmax(2.0 * distance, -1.0), 1.0);
    return fmin(fmax(0.5 + (asin(u) + u * sqrt((1.0 - u) * (1.0 + u))) / M_PI, 0.0), 1.0);
}

// ---- kernels
// --------------------------------------------------------------------------------------

// A kernel's corners at most: its two ends and every half integer between, and the ends' distances
// from the integers for kernels that are normalised, whose sum of weights has corners there.
enum { MAX_CORNERS = 4 * WEFT_KERNEL_MAX_WIDTH + 8, NODES = 10, MAX_PARTS = 16 };

// The rule of 10 points on [-1, 1]: exact for polynomials up to degree 19, which the product of two
// B-splines of degree 7 and the integral of one does not exceed.
static const double nodes[NODES / 2] = {0.14887433898163121088, 0.43339539412924719080,
                                        0.67940956829902440623, 0.86506336668898451073,
                                        0.97390652851717172008};
static const double node_weights[NODES / 2] = {0.29552422471475287017, 0.26926671930999635509,
                                               0.21908636251598204400, 0.14945134915058059315,
                                               0.06667134430868813759};

// h cut at its corners, in the kernel's unit; whole[i] is the integral of h up to corner i.
struct primitive {
    const struct weft_kernel *kernel;
    int count, parts; // corners; each piece between two is integrated in so many parts
    double corner[MAX_CORNERS], whole[MAX_CORNERS];
};

struct integral {
    double (*value)(const void *priv, double x);
    const void *priv;
};

static double integrate_part(struct integral f, double from, double to)
{
    const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
    double sum = 0.0;
    for (int i = 0; i < NODES / 2; i++)
        sum += node_weights[i] * (f.value(f.priv, middle - half * nodes[i]) +
                                  f.value(f.priv, middle + half * nodes[i]));
    return sum * half;
}

static double integrate(struct integral f, double from, double to, int parts)
{
    double sum = 0.0;
    for (int i = 0; i < parts; i++)
        sum +=
            integrate_part(f, from + (to - from) * i / parts, from + (to - from) * (i + 1) / parts);
    return sum;
}

static double kernel_at(const void *priv, double x)
{
    const struct primitive *p = priv;
    return weft_kernel_weight(p->kernel, x);
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Sorts, and drops what is there twice.
static int sort_corners(double *corner, int count)
{
    int kept = 0;
    qsort(corner, (size_t)count, sizeof *corner, compare);
    for (int i = 0; i < count; i++)
        if (kept == 0 || corner[i] > corner[kept - 1])
            corner[kept++] = corner[i];
    return kept;
}

static void find_corners(struct primitive *p)
{
    const double r = p->kernel->support, ends[] = {0.0, 0.5, r - floor(r), ceil(r) - r};
    int count = 0;
    p->corner[count++] = -r;
    p->corner[count++] = r;
    for (size_t e = 0; e < WEFT_COUNT(ends); e++)
        for (int i = -(int)ceil(r); i < ceil(r); i++)
            if (fabs(i + ends[e]) < r && (e < 2 || p->kernel->normalised))
                p->corner[count++] = i + ends[e];
    p->count = sort_corners(p->corner, count);
}

static void sum_up(struct primitive *p, int parts)
{
    p->parts = parts;
    p->whole[0] = 0.0;
    for (int i = 0; i + 1 < p->count; i++)
        p->whole[i + 1] = p->whole[i] + integrate((struct integral){kernel_at, p}, p->corner[i],
                                                  p->corner[i + 1], parts);
}

static double primitive_at(const struct primitive *p, double x)
{
    const int last = p->count - 1;
    if (!(x > p->corner[0]))
        return 0.0;
    if (x >= p->corner[last])
        return p->whole[last];
    int i = 0;
    while (x >= p->corner[i + 1])
        i++;
    return p->whole[i] + integrate((struct integral){kernel_at, p}, p->corner[i], x, p->parts);
}

// An edge in the kernel's unit: h(x) H((d - a x) / b), a >= b > 0 the normal's magnitudes.
struct crossing {
    const struct primitive *p;
    double a, b, d;
};

static double crossing_at(const void *priv, double x)
{
    const struct crossing *c = priv;
    return weft_kernel_weight(c->p->kernel, x) * primitive_at(c->p, (c->d - c->a * x) / c->b);
}

// The integral over x, cut where either factor has a corner.
static double integrate_crossing(const struct crossing *c)
{
    const struct primitive *p = c->p;
    double corner[2 * MAX_CORNERS];
    int count = p->count;
    for (int i = 0; i < p->count; i++) {
        const double x = (c->d - c->b * p->corner[i]) / c->a;
        corner[i] = p->corner[i];
        if (fabs(x) < p->corner[p->count - 1])
            corner[count++] = x;
    }
    count = sort_corners(corner, count);
    double sum = 0.0;
    for (int i = 0; i + 1 < count; i++)
        sum += integrate((struct integral){crossing_at, c}, corner[i], corner[i + 1], p->parts);
    return sum;
}

static double compute(struct primitive *p, const double n[2], double d, int parts)
{
    sum_up(p, parts);
    const double whole = p->whole[p->count - 1];
    const double product = n[1] > 0.0 ? integrate_crossing(&(struct crossing){p, n[0], n[1], d})
                                      : primitive_at(p, d / n[0]) * whole;
    return product / (whole * whole);
}

static enum weft_result check(const struct weft_log *log, const struct weft_kernel *kernel,
                              double width)
{
    enum weft_result res = weft_kernel_check(log, kernel);
    if (res != WEFT_OK)
        return res;
    if (kernel->radial || kernel->prefiltered) {
        weft_error(log, "the coverage of an edge under kernel %s: %s", kernel->info->name,
                   kernel->radial ? "a radial kernel is no product of two"
                                  : "the support of a prefiltered kernel has no end");
        return WEFT_ERR_UNSUPPORTED;
    }
    if (kernel->info->derivation > 0) {
        weft_error(log, "kernel %s is a derivative: its integral is 0, and it covers nothing",
                   kernel->info->name);
        return WEFT_ERR_ARGUMENT;
    }
    if (width != 0.0 && !(width >= 0x1p-20 && width <= 0x1p20)) {
        weft_error(log, "a filter is %g pixels wide: it must be 2^-20 to 2^20", width);
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

// Refines until the value stands still, twice for kernels that are smooth between their corners.
static enum weft_result refine(const struct weft_log *log, struct primitive *p, const double n[2],
                               double d, struct weft_edge_value *out)
{
    const double enough = 1e-14, rounding = 2e-15;
    double value = compute(p, n, d, 1), change = INFINITY;
    if (!(p->whole[p->count - 1] > 0.0)) {
        weft_error(log, "the integral of kernel %s is %g: it must be above 0",
                   p->kernel->info->name, p->whole[p->count - 1]);
        return WEFT_ERR_ARGUMENT;
    }
    for (int parts = 2; parts <= MAX_PARTS && change > enough; parts *= 2) {
        const double finer = compute(p, n, d, parts);
        change = fabs(finer - value);
        value = finer;
    }
    *out = (struct weft_edge_value){value, change + rounding};
    return WEFT_OK;
}

enum weft_result weft_edge_kernel(const struct weft_log *log, const struct weft_kernel *kernel,
                                  double width, const double normal[2], double distance,
                                  struct weft_edge_value *out)
{
    double n[2];
    *out = (struct weft_edge_value){NAN, NAN};
    enum weft_result res = check(log, kernel, width);
    if (res != WEFT_OK)
        return res;
    if (!resolve(normal, n) || isnan(distance)) {
        weft_error(log, "no edge: normal (%g, %g), distance %g", normal[0], normal[1], distance);
        return WEFT_ERR_ARGUMENT;
    }
    struct primitive p = {.kernel = kernel};
    const double scale = width == 0.0 ? 1.0 : width / (2.0 * kernel->support);
    // Past both supports nothing changes: an infinite distance is as good as that.
    const double far = 4.0 * kernel->support, d = fmin(fmax(distance / scale, -far), far);
    find_corners(&p);
    return refine(log, &p, n, d, out);
}
