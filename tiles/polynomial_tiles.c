// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/polynomial_tiles.h"

#include <math.h>
#include <stdlib.h>

enum { MAX_NODES = WEFT_POLYNOMIAL_MAX_DEGREE + 1 };

// Where the kernel is no polynomial, cubics over short segments cost four coefficients a look-up.
enum { FALLBACK_DEGREE = 3 };

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

// Fits one segment of one tap; returns the largest error at points between the nodes.
static double fit_segment(const struct weft_kernel *kernel, int tap, int segment, int segments,
                          int degree, double *coefficient)
{
    double offset = weft_kernel_offset(kernel) - tap;
    double node[MAX_NODES], value[MAX_NODES], error = 0.0;
    for (int i = 0; i <= degree; i++) {
        node[i] = 0.5 - 0.5 * cos(M_PI * (2 * i + 1) / (2.0 * (degree + 1)));
        value[i] = weft_kernel_weight(kernel, (segment + node[i]) / segments + offset);
    }
    interpolate(degree, node, value, coefficient);
    enum { PROBES = 17 };
    for (int i = 0; i < PROBES; i++) {
        double u = (i + 0.5) / PROBES;
        double h = weft_kernel_weight(kernel, (segment + u) / segments + offset);
        error = fmax(error, fabs(evaluate(degree, coefficient, u) - h));
    }
    return error;
}

static double fit(const struct weft_kernel *kernel, struct weft_polynomial_tiles *tiles)
{
    double error = 0.0;
    int stride = 4 * tiles->groups;
    for (int segment = 0; segment < tiles->segments; segment++) {
        for (int tap = 0; tap < tiles->width; tap++) {
            double coefficient[MAX_NODES];
            error = fmax(error, fit_segment(kernel, tap, segment, tiles->segments, tiles->degree,
                                            coefficient));
            float *out = &tiles->coefficients[segment * (tiles->degree + 1) * stride + tap];
            for (int p = 0; p <= tiles->degree; p++)
                out[p * stride] = (float)coefficient[p];
        }
    }
    return error;
}

// Of the exact polynomials, where the weights are such; dividing by their sum makes them others.
static int polynomial_degree(const struct weft_kernel *kernel)
{
    int degree = kernel->info->degree;
    bool exact = !kernel->normalised && degree >= 0 && degree <= WEFT_POLYNOMIAL_MAX_DEGREE;
    return exact ? degree : FALLBACK_DEGREE;
}

enum weft_result weft_polynomial_tiles_create(const struct weft_log *log,
                                              const struct weft_kernel *kernel, double tolerance,
                                              struct weft_polynomial_tiles *out)
{
    *out = (struct weft_polynomial_tiles){
        .width = kernel->width,
        .groups = (kernel->width + 3) / 4,
        .degree = polynomial_degree(kernel),
    };
    for (int segments = 1; segments <= WEFT_POLYNOMIAL_MAX_SEGMENTS; segments *= 2) {
        size_t count = (size_t)segments * (size_t)(out->degree + 1) * 4 * (size_t)out->groups;
        free(out->coefficients);
        out->coefficients = calloc(count, sizeof *out->coefficients);
        if (!out->coefficients) {
            weft_error(log, "not enough memory for %zu tile coefficients", count);
            return WEFT_ERR_MEMORY;
        }
        out->segments = segments;
        out->coefficient_count = count;
        out->error = fit(kernel, out);
        if (out->error <= tolerance)
            return WEFT_OK;
    }
    weft_error(log, "kernel %s: %d segments a tile leave an error of %.3g, over %.3g",
               kernel->info->name, out->segments, out->error, tolerance);
    weft_polynomial_tiles_destroy(out);
    return WEFT_ERR_LIMIT;
}

void weft_polynomial_tiles_destroy(struct weft_polynomial_tiles *tiles)
{
    free(tiles->coefficients);
    *tiles = (struct weft_polynomial_tiles){0};
}
