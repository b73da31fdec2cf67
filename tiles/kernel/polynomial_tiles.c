// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/kernel/polynomial_tiles.h"

#include <math.h>
#include <stdlib.h>

enum { MAX_NODES = WEFT_POLYNOMIAL_MAX_DEGREE + 1 };

// Where the kernel is no polynomial, cubics over short segments cost four coefficients a look-up.
// For more than single precision there would have to be too many of them.
enum { FALLBACK_DEGREE = 3, PRECISE_FALLBACK_DEGREE = WEFT_POLYNOMIAL_MAX_DEGREE };
static const double PRECISE = 1e-10;

// Monomial coefficients in u of the polynomial through (node[i], value[i]), by Newton's
// differences.
static void interpolate(int degree, const double *node, const double *value, double *coefficient)
{
    double difference[MAX_NODES];
    for (int i = 0; i <= degree; i++)
        difference[i] = value[i];
    for (int order = 1; order <= degree; order++)
        for (int i = degree; i >= order; i--)
            difference[i] = (difference[i] - difference[i - 1]) / (node[i] - node[i - order]);
    for (int i = 0; i <= degree; i++)
        coefficient[i] = 0.0;
    for (int i = degree; i >= 0; i--) {
        // coefficient = coefficient * (u - node[i]) + difference[i]
        for (int p = degree; p > 0; p--)
            coefficient[p] = coefficient[p - 1] - node[i] * coefficient[p];
        coefficient[0] = difference[i] - node[i] * coefficient[0];
    }
    // Exact zeros keep on-lattice positions free of the neighbours' values.
    for (int p = 0; p <= degree; p++)
        if (fabs(coefficient[p]) < 1e-14)
            coefficient[p] = 0.0;
}

static double evaluate(int degree, const double *coefficient, double u)
{
    double sum = 0.0;
    for (int p = degree; p >= 0; p--)
        sum = sum * u + coefficient[p];
    return sum;
}

enum { PROBES = 17 };

// What lies between two neighbouring probes can be this much worse, where it is no polynomial.
static const double PROBED = 1.02;

// A segment's end, as seen from inside.
static const double END = 1.0 - 1e-12;

// Weight of a tap at u in a segment.
static double weight_at(const struct weft_kernel *kernel, int tap, int segment, int segments,
                        double u)
{
    double inside = fmin(u, END);
    return weft_kernel_weight(kernel,
                              (segment + inside) / segments + weft_kernel_offset(kernel) - tap);
}

// Chebyshev's nodes stretched so that the outer ones are the segment's ends: where a segment
// begins, weights are those of the kernel, exact zeros among them. A constant is that of the
// middle.
static double node_at(const struct weft_polynomial_tiles *tiles, int i)
{
    const double step = M_PI / (2.0 * (tiles->degree + 1));
    if (tiles->degree == 0)
        return 0.5;
    if (i == 0 || i == tiles->degree)
        return i == 0 ? 0.0 : END;
    return 0.5 - 0.5 * cos((2 * i + 1) * step) / cos(step);
}

// Fits one segment of one tap; errors at points between the nodes are added to `error`.
static double fit_segment(const struct weft_kernel *kernel,
                          const struct weft_polynomial_tiles *tiles, int tap, int segment,
                          double *coefficient, double error[PROBES])
{
    double node[MAX_NODES], value[MAX_NODES], largest = 0.0;
    for (int i = 0; i <= tiles->degree; i++) {
        node[i] = node_at(tiles, i);
        value[i] = weight_at(kernel, tap, segment, tiles->segments, node[i]);
    }
    interpolate(tiles->degree, node, value, coefficient);
    for (int i = 0; i < PROBES; i++) {
        double u = i / (PROBES - 1.0);
        double h = weight_at(kernel, tap, segment, tiles->segments, u);
        double off = fabs(evaluate(tiles->degree, coefficient, u) - h);
        error[i] += off;
        largest = fmax(largest, off);
    }
    return largest;
}

static void fit(const struct weft_kernel *kernel, struct weft_polynomial_tiles *tiles)
{
    int stride = 4 * tiles->groups;
    tiles->error = tiles->sum_error = 0.0;
    tiles->exact = true;
    for (int segment = 0; segment < tiles->segments; segment++) {
        double errors[PROBES] = {0};
        for (int tap = 0; tap < tiles->width; tap++) {
            double coefficient[MAX_NODES];
            tiles->error =
                fmax(tiles->error, fit_segment(kernel, tiles, tap, segment, coefficient, errors));
            const int at = segment * (tiles->degree + 1) * stride + tap;
            float *out = tiles->coefficients + at;
            for (int p = 0; p <= tiles->degree; p++) {
                tiles->precise[at + p * stride] = coefficient[p];
                out[p * stride] = (float)coefficient[p];
                tiles->exact &= fabs(out[p * stride] - coefficient[p]) < 1e-12;
            }
        }
        for (int i = 0; i < PROBES; i++)
            tiles->sum_error = fmax(tiles->sum_error, PROBED * errors[i]);
    }
}

// Of the exact polynomials, where the weights are such; dividing by their sum makes them others.
static int polynomial_degree(const struct weft_kernel *kernel, double tolerance)
{
    int degree = kernel->info->degree;
    bool exact = !kernel->normalised && degree >= 0 && degree <= WEFT_POLYNOMIAL_MAX_DEGREE;
    return exact ? degree : tolerance < PRECISE ? PRECISE_FALLBACK_DEGREE : FALLBACK_DEGREE;
}

static struct weft_polynomial_tiles tiles_of(const struct weft_kernel *kernel, int degree)
{
    return (struct weft_polynomial_tiles){
        .width = kernel->width,
        .groups = (kernel->width + 3) / 4,
        .degree = degree,
    };
}

static enum weft_result fit_segments(const struct weft_log *log, const struct weft_kernel *kernel,
                                     int segments, struct weft_polynomial_tiles *tiles)
{
    size_t count = (size_t)segments * (size_t)(tiles->degree + 1) * 4 * (size_t)tiles->groups;
    free(tiles->coefficients);
    free(tiles->precise);
    tiles->coefficients = calloc(count, sizeof *tiles->coefficients);
    tiles->precise = calloc(count, sizeof *tiles->precise);
    if (!tiles->coefficients || !tiles->precise) {
        weft_error(log, "not enough memory for %zu tile coefficients", count);
        return WEFT_ERR_MEMORY;
    }
    tiles->segments = segments;
    tiles->coefficient_count = count;
    fit(kernel, tiles);
    return WEFT_OK;
}

static double largest_weight(const struct weft_kernel *kernel)
{
    enum { POSITIONS = 64 };
    double weights[WEFT_KERNEL_MAX_WIDTH], largest = 0.0;
    for (int i = 0; i < POSITIONS; i++) {
        weft_kernel_weights(kernel, (double)i / POSITIONS, weights);
        for (int tap = 0; tap < kernel->width; tap++)
            largest = fmax(largest, fabs(weights[tap]));
    }
    return largest;
}

// Whether the ends of the support, where a kernel may jump or kink, are borders of segments.
static bool meets_ends(const struct weft_kernel *kernel, int segments)
{
    for (int side = -1; side <= 1; side += 2) {
        const double at = segments * (side * kernel->support - weft_kernel_offset(kernel));
        if (fabs(at - round(at)) > 1e-9 * segments)
            return false;
    }
    return true;
}

struct search {
    const struct weft_log *log;
    const struct weft_kernel *kernel;
    double tolerance;
    int best; // segments with the least error
    double least;
};

// Doubles the segments, from `from` or at once as often as there is room.
static enum weft_result try_segments(struct search *s, int from, bool finest,
                                     struct weft_polynomial_tiles *out)
{
    while (finest && 2 * from <= WEFT_POLYNOMIAL_MAX_SEGMENTS)
        from *= 2;
    enum weft_result res = WEFT_OK;
    for (int n = from;
         res == WEFT_OK && s->least > s->tolerance && n <= WEFT_POLYNOMIAL_MAX_SEGMENTS; n *= 2) {
        res = fit_segments(s->log, s->kernel, n, out);
        if (out->error < s->least) {
            s->least = out->error;
            s->best = n;
        }
    }
    return res;
}

// Powers of two; then what has the support's ends on borders; then what may have a table's knots
// there.
enum weft_result weft_polynomial_tiles_create(const struct weft_log *log,
                                              const struct weft_kernel *kernel, double tolerance,
                                              struct weft_polynomial_tiles *out)
{
    enum { MOST_KNOTS = 63 };
    struct search s = {log, kernel, tolerance * fmax(1.0, largest_weight(kernel)), 0, INFINITY};
    *out = tiles_of(kernel, polynomial_degree(kernel, tolerance));
    enum weft_result res = try_segments(&s, 1, false, out);
    for (int n = 3; res == WEFT_OK && n <= WEFT_POLYNOMIAL_MAX_SEGMENTS; n++)
        if (meets_ends(kernel, n)) {
            res = try_segments(&s, n, false, out);
            break;
        }
    for (int n = 3; res == WEFT_OK && n <= MOST_KNOTS; n += 2)
        res = try_segments(&s, n, true, out);
    if (res == WEFT_OK && out->segments != s.best)
        res = fit_segments(log, kernel, s.best, out);
    // A jump inside a segment can leave up to 1.6 times what the probes find: between two of them
    // the cubic changes by a fifth of the jump.
    if (res == WEFT_OK && out->error > s.tolerance)
        out->sum_error *= 2.0;
    if (res != WEFT_OK)
        weft_polynomial_tiles_destroy(out);
    return res;
}

enum weft_result weft_polynomial_tiles_sample(const struct weft_log *log,
                                              const struct weft_kernel *kernel, int samples,
                                              bool linear, struct weft_polynomial_tiles *out)
{
    *out = tiles_of(kernel, linear ? 1 : 0);
    if (samples < 1 || samples > WEFT_POLYNOMIAL_MAX_SEGMENTS) {
        weft_error(log, "%d samples a kernel tile: there must be 1 to %d", samples,
                   WEFT_POLYNOMIAL_MAX_SEGMENTS);
        return WEFT_ERR_ARGUMENT;
    }
    return fit_segments(log, kernel, samples, out);
}

void weft_polynomial_tiles_destroy(struct weft_polynomial_tiles *tiles)
{
    free(tiles->coefficients);
    free(tiles->precise);
    *tiles = (struct weft_polynomial_tiles){0};
}
