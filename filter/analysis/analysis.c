// SPDX-License-Identifier: BSD-3-Clause
#include "filter/analysis/analysis.h"

#include <math.h>
#include <string.h>

#include "filter/check.h"
#include "filter/kernels/kernel_nd.h"
#include "filter/kernels/kernel_records.h"
#include "filter/kernels/prefilter.h"

enum { NODES = 16, PIECES_PER_UNIT = 8, STEPS_PER_UNIT = 1024, MAX_MOMENT = 64 };

struct rule {
    double node[NODES], share[NODES]; // on [-1, 1]
};

// Gauss-Legendre by Newton's method on the three-term recurrence.
static struct rule gauss_legendre(void)
{
    struct rule rule;
    for (int i = 0; i < NODES; i++) {
        double x = cos(M_PI * (i + 0.75) / (NODES + 0.5)), slope = 1.0;
        for (int step = 0; step < 8; step++) {
            double p = x, before = 1.0;
            for (int n = 2; n <= NODES; n++) {
                const double next = ((2 * n - 1) * x * p - (n - 1) * before) / n;
                before = p;
                p = next;
            }
            slope = NODES * (x * p - before) / (x * x - 1.0);
            x -= p / slope;
        }
        rule.node[i] = x;
        rule.share[i] = 2.0 / ((1.0 - x * x) * slope * slope);
    }
    return rule;
}

typedef double integrand(const void *priv, double x);

// Over [from, to], where the integrand is smooth.
static double integrate_smooth(const struct rule *rule, integrand *f, const void *priv, double from,
                               double to, int pieces)
{
    double sum = 0.0;
    const double half = 0.5 * (to - from) / pieces;
    for (int i = 0; i < pieces; i++) {
        const double middle = from + (2 * i + 1) * half;
        for (int j = 0; j < NODES; j++)
            sum += half * rule->share[j] * f(priv, middle + half * rule->node[j]);
    }
    return sum;
}

// Over [from, to] (integers), split where a kernel of this support may have knots.
static double integrate(const struct rule *rule, double support, integrand *f, const void *priv,
                        double from, double to, double pieces_per_unit)
{
    const double end = support - floor(support);
    double knots[5] = {0.0, 0.5, end, 1.0 - end, 1.0};
    for (int i = 1; i < 5; i++)
        for (int j = i; j > 0 && knots[j] < knots[j - 1]; j--) {
            const double swap = knots[j];
            knots[j] = knots[j - 1];
            knots[j - 1] = swap;
        }
    double sum = 0.0;
    for (double unit = from; unit < to; unit += 1.0)
        for (int i = 0; i < 4; i++) {
            const double length = knots[i + 1] - knots[i];
            if (length > 0.0)
                sum += integrate_smooth(rule, f, priv, unit + knots[i], unit + knots[i + 1],
                                        (int)ceil(length * pieces_per_unit));
        }
    return sum;
}

static double integrate_kernel(const struct weft_kernel *kernel, integrand *f, const void *priv,
                               double pieces_per_unit)
{
    const struct rule rule = gauss_legendre();
    const double reach = ceil(kernel->support);
    return integrate(&rule, kernel->support, f, priv, -reach, reach, pieces_per_unit);
}

// ---- prefiltered kernels
// --------------------------------------------------------------------------

// Zero poles for other kernels.
static struct weft_prefilter prefilter_of(const struct weft_kernel *kernel)
{
    struct weft_prefilter prefilter = {0};
    if (kernel->prefiltered)
        weft_prefilter_compute(NULL, kernel, &prefilter);
    return prefilter;
}

// sum_k k^n r(k) / n! of the inverse filter r, which is even, for n up to a largest one.
struct inverse_moments {
    double of[MAX_MOMENT + 1];
};

static double power(double x, int n)
{
    double product = 1.0;
    for (; n > 0; n /= 2, x *= x)
        product *= n % 2 ? x : 1.0;
    return product;
}

static double factorial(int n)
{
    double product = 1.0;
    for (int i = 2; i <= n; i++)
        product *= i;
    return product;
}

// Of other kernels the filter is 1 at 0 alone.
static struct inverse_moments inverse_moments(const struct weft_kernel *kernel, int largest)
{
    const struct weft_prefilter prefilter = prefilter_of(kernel);
    struct inverse_moments out = {.of = {1.0}};
    for (int n = 2; prefilter.poles && n <= largest; n += 2) {
        double sum = 0.0;
        for (int i = 0; i < prefilter.poles; i++) {
            const double z = prefilter.pole[i];
            double decay = z, term = z;
            // Past the maximum of k^n |z|^k, until nothing is left.
            for (int k = 2; k <= 4 * n || fabs(term) > 1e-30; k++) {
                sum += 2.0 * prefilter.factor[i] * term;
                decay *= z;
                term = power(k, n) * decay;
            }
        }
        out.of[n] = sum / factorial(n);
    }
    return out;
}

// The weights that samples have at t, at most WEFT_PREFILTER_MAX_WEIGHTS; returns the first index.
static int64_t sample_weights(const struct weft_kernel *kernel,
                              const struct weft_prefilter *prefilter, double t, double *weights,
                              int *count)
{
    const int overlap = prefilter->poles ? weft_prefilter_overlap(prefilter, 0x1p-50) : 0;
    *count = kernel->width + 2 * overlap;
    return prefilter->poles ? weft_prefilter_weights(prefilter, kernel, overlap, t, weights)
                            : weft_kernel_weights(kernel, t, weights);
}

// ---- integrals over kernels
// -----------------------------------------------------------------------

// Of the kernel's weights at t, from tap `first` on.
static double plain_taylor(const struct weft_kernel *kernel, const double *weights, double first,
                           int n, double *magnitude)
{
    double sum = 0.0, size = 0.0;
    for (int j = 0; j < kernel->width; j++) {
        const double term = power(first + j, n) * weights[j];
        sum += term;
        size += fabs(term);
    }
    *magnitude = size / factorial(n);
    return sum / factorial(n);
}

// Of the cardinal spline sum_l r(l) h(x - l), by the binomial theorem.
static double taylor(const struct weft_kernel *kernel, const struct inverse_moments *moments, int n,
                     double t, double *magnitude)
{
    double weights[WEFT_KERNEL_MAX_WIDTH], size;
    const double first = (double)weft_kernel_weights(kernel, t, weights) - t;
    double sum = plain_taylor(kernel, weights, first, n, magnitude);
    for (int p = 2; kernel->prefiltered && p <= n; p += 2) {
        sum += moments->of[p] * plain_taylor(kernel, weights, first, n - p, &size);
        *magnitude += fabs(moments->of[p]) * size;
    }
    return sum;
}

double weft_analysis_taylor(const struct weft_kernel *kernel, int n, double t)
{
    double magnitude;
    if (!weft_kernel_usable(kernel) || n < 0 || n > MAX_MOMENT || !isfinite(t))
        return NAN;
    const struct inverse_moments moments = inverse_moments(kernel, n);
    return taylor(kernel, &moments, n, t, &magnitude);
}

struct power_of {
    const struct weft_kernel *kernel;
    const struct inverse_moments *moments;
    int n;
    double shift;
};

static double moment_at(const void *priv, double x)
{
    const struct power_of *p = priv;
    return power(x, p->n) * weft_kernel_weight(p->kernel, x);
}

// As taylor.
double weft_analysis_moment(const struct weft_kernel *kernel, int n)
{
    if (!weft_kernel_usable(kernel) || n < 0 || n > MAX_MOMENT)
        return NAN;
    const struct inverse_moments moments = inverse_moments(kernel, n);
    double sum = 0.0;
    for (int p = 0; p <= (kernel->prefiltered ? n : 0); p += 2) {
        const struct power_of power_of = {.kernel = kernel, .n = n - p};
        sum += moments.of[p] / factorial(n - p) *
               integrate_kernel(kernel, moment_at, &power_of, PIECES_PER_UNIT);
    }
    return sum * factorial(n);
}

static double taylor_at(const void *priv, double t)
{
    const struct power_of *p = priv;
    double magnitude;
    return taylor(p->kernel, p->moments, p->n, t, &magnitude);
}

static double taylor_square_at(const void *priv, double t)
{
    const struct power_of *p = priv;
    const double a = taylor_at(priv, t) - p->shift;
    return a * a;
}

struct range {
    double min, max;
    double rounding; // what is no more than that
};

// Both sides of every step, as half integers may be jumps.
static struct range taylor_range(const struct weft_kernel *kernel,
                                 const struct inverse_moments *moments, int n)
{
    struct range r = {.min = INFINITY, .max = -INFINITY};
    for (int i = 0; i < 2 * STEPS_PER_UNIT; i++) {
        const double step = (double)(i / 2 + 1) / STEPS_PER_UNIT;
        double magnitude;
        const double a =
            taylor(kernel, moments, n, i % 2 ? nextafter(step, 0.0) : step, &magnitude);
        r.min = fmin(r.min, a);
        r.max = fmax(r.max, a);
        r.rounding = fmax(r.rounding, 1e-12 * magnitude);
    }
    return r;
}

static double root_mean_square(const struct weft_kernel *kernel,
                               const struct inverse_moments *moments, int n, double shift)
{
    const struct rule rule = gauss_legendre();
    const struct power_of p = {.kernel = kernel, .moments = moments, .n = n, .shift = shift};
    return sqrt(integrate(&rule, kernel->support, taylor_square_at, &p, 0.0, 1.0, PIECES_PER_UNIT));
}

static double mean(const struct weft_kernel *kernel, const struct inverse_moments *moments, int n)
{
    const struct rule rule = gauss_legendre();
    const struct power_of p = {.kernel = kernel, .moments = moments, .n = n};
    return integrate(&rule, kernel->support, taylor_at, &p, 0.0, 1.0, PIECES_PER_UNIT);
}

// The standard deviation over t is, by Parseval, the root of sum_n |H^(L)(n)|^2 / (L! (2 pi)^L)^2
// over n != 0 that Blu and Unser give.
struct weft_analysis_order weft_analysis_order(const struct weft_kernel *kernel)
{
    struct weft_analysis_order out = {0, NAN, NAN, 0, NAN};
    if (!weft_kernel_usable(kernel))
        return out;
    const int d = kernel->info->derivation;
    const struct inverse_moments moments = inverse_moments(kernel, WEFT_ANALYSIS_MAX_ORDER + d);
    struct range ranges[WEFT_ANALYSIS_MAX_ORDER + 2]; // second derivatives are the highest
    int n = 0, known = 0;
    double wanted = 0.0;
    for (; n < WEFT_ANALYSIS_MAX_ORDER + d; n++) {
        const struct range r = ranges[known++] = taylor_range(kernel, &moments, n);
        wanted = n == d ? 1.0 : 0.0;
        out.largest = fmax(fabs(r.min - wanted), fabs(r.max - wanted));
        if (out.largest > r.rounding + 1e-13)
            break;
    }
    out.order = n > d ? n - d : 0;
    out.constant = root_mean_square(kernel, &moments, n, wanted);
    for (n = 0; n < WEFT_ANALYSIS_MAX_ORDER; n++) {
        const struct range r = n < known ? ranges[n] : taylor_range(kernel, &moments, n);
        if (r.max - r.min > r.rounding + 1e-13)
            break;
    }
    out.prefiltered = n;
    out.prefiltered_constant =
        n > 0 ? root_mean_square(kernel, &moments, n, mean(kernel, &moments, n)) : 0.0;
    return out;
}

struct wave_of {
    const struct weft_kernel *kernel;
    double rate;
};

static double cosine_at(const void *priv, double x)
{
    const struct wave_of *w = priv;
    return weft_kernel_weight(w->kernel, x) * cos(w->rate * x);
}

static double sine_at(const void *priv, double x)
{
    const struct wave_of *w = priv;
    return weft_kernel_weight(w->kernel, x) * sin(w->rate * x);
}

struct weft_analysis_response weft_analysis_response(const struct weft_kernel *kernel,
                                                     double frequency)
{
    if (!weft_kernel_usable(kernel) || !(fabs(frequency) <= WEFT_ANALYSIS_MAX_FREQUENCY))
        return (struct weft_analysis_response){NAN, NAN};
    const struct wave_of w = {.kernel = kernel, .rate = 2.0 * M_PI * frequency};
    // At most half a cycle per piece.
    const double pieces = fmax(PIECES_PER_UNIT, 2.0 * fabs(frequency));
    const struct weft_prefilter prefilter = prefilter_of(kernel);
    double inverse = 1.0;
    for (int i = 0; i < prefilter.poles; i++) {
        const double z = prefilter.pole[i];
        inverse *= (1.0 - z) * (1.0 - z) / (1.0 + z * z - 2.0 * z * cos(w.rate));
    }
    return (struct weft_analysis_response){
        .re = inverse * integrate_kernel(kernel, cosine_at, &w, pieces),
        .im = -inverse * integrate_kernel(kernel, sine_at, &w, pieces),
    };
}

static double power_at(const void *priv, double frequency)
{
    const struct weft_analysis_response h = weft_analysis_response(priv, frequency);
    return h.re * h.re + h.im * h.im;
}

// The integral of h^2 is that of this over [0, 1].
static double square_sum_at(const void *priv, double t)
{
    const struct weft_prefilter prefilter = prefilter_of(priv);
    double weights[WEFT_PREFILTER_MAX_WEIGHTS], sum = 0.0;
    int count;
    sample_weights(priv, &prefilter, t, weights, &count);
    for (int j = 0; j < count; j++)
        sum += weights[j] * weights[j];
    return sum;
}

// The tensor product's energies are powers of those in one dimension; all of it by Parseval.
struct weft_analysis_metrics weft_analysis_metrics(const struct weft_kernel *kernel, int dims)
{
    if (!weft_kernel_usable(kernel) || dims < 1 || dims > 3 || weft_kernel_is_radial(kernel, dims))
        return (struct weft_analysis_metrics){NAN, NAN};
    const struct rule rule = gauss_legendre();
    const double inside =
        2.0 * integrate_smooth(&rule, power_at, kernel, 0.0, 0.5, (kernel->width + 7) / 8 * 2);
    const double all =
        integrate(&rule, kernel->support, square_sum_at, kernel, 0.0, 1.0, PIECES_PER_UNIT);
    return (struct weft_analysis_metrics){
        .smoothing = 1.0 - pow(inside, dims),
        .postaliasing = pow(all, dims) - pow(inside, dims),
    };
}

// Samples are 1 from tap 0 on; t is the position.
static double step_at(const struct weft_kernel *kernel, const struct weft_prefilter *prefilter,
                      double t)
{
    double weights[WEFT_PREFILTER_MAX_WEIGHTS], sum = 0.0;
    int count;
    const int64_t first = sample_weights(kernel, prefilter, t, weights, &count);
    for (int j = 0; j < count; j++)
        sum += first + j >= 0 ? weights[j] : 0.0;
    return sum;
}

static double minus_step_at(const struct weft_kernel *kernel,
                            const struct weft_prefilter *prefilter, double t)
{
    return -step_at(kernel, prefilter, t);
}

static double gain_at(const struct weft_kernel *kernel, const struct weft_prefilter *prefilter,
                      double t)
{
    double weights[WEFT_PREFILTER_MAX_WEIGHTS], sum = 0.0;
    int count;
    sample_weights(kernel, prefilter, t, weights, &count);
    for (int j = 0; j < count; j++)
        sum += fabs(weights[j]);
    return sum;
}

// The maximum over [from, to]: the best of many steps, then a golden-section search beside it.
static double maximum(const struct weft_kernel *kernel, const struct weft_prefilter *prefilter,
                      double (*f)(const struct weft_kernel *kernel,
                                  const struct weft_prefilter *prefilter, double t),
                      double from, double to)
{
    const double step = 1.0 / STEPS_PER_UNIT, golden = 0.61803398874989485;
    double best = -INFINITY, at = from;
    for (int i = 0; i <= (int)((to - from) * STEPS_PER_UNIT); i++) {
        const double value = f(kernel, prefilter, from + i * step);
        if (value > best) {
            best = value;
            at = from + i * step;
        }
    }
    double a = at - step, b = at + step;
    for (int i = 0; i < 60; i++) {
        const double left = b - golden * (b - a), right = a + golden * (b - a);
        const double at_left = f(kernel, prefilter, left), at_right = f(kernel, prefilter, right);
        best = fmax(best, fmax(at_left, at_right));
        if (at_left > at_right)
            b = right;
        else
            a = left;
    }
    return best;
}

struct weft_analysis_overshoot weft_analysis_overshoot(const struct weft_kernel *kernel)
{
    if (!weft_kernel_usable(kernel))
        return (struct weft_analysis_overshoot){NAN, NAN};
    const struct weft_prefilter prefilter = prefilter_of(kernel);
    const double reach = kernel->width;
    return (struct weft_analysis_overshoot){
        .above = maximum(kernel, &prefilter, step_at, -reach, reach) - 1.0,
        .below = maximum(kernel, &prefilter, minus_step_at, -reach, reach),
    };
}

double weft_analysis_gain(const struct weft_kernel *kernel)
{
    if (!weft_kernel_usable(kernel))
        return NAN;
    const struct weft_prefilter prefilter = prefilter_of(kernel);
    return maximum(kernel, &prefilter, gain_at, 0.0, 1.0);
}

// Weights less those of linear interpolation, summed up twice: what is left after the last tap are
// the differences of their sums and of their first moments. INFINITY where these are not 0.
static double curvature_at(const struct weft_kernel *kernel, const struct weft_prefilter *prefilter,
                           double x)
{
    double weights[WEFT_PREFILTER_MAX_WEIGHTS], sum = 0.0, second_sum = 0.0, total = 0.0;
    int count;
    const int64_t first = sample_weights(kernel, prefilter, x, weights, &count);
    const int64_t below = (int64_t)floor(x), end = first + count;
    for (int64_t k = first < below ? first : below; k < end || k < below + 2; k++) {
        const double linear = fmax(0.0, 1.0 - fabs(x - (double)k));
        sum += (k >= first && k < end ? weights[k - first] : 0.0) - linear;
        second_sum += sum;
        total += fabs(second_sum);
    }
    return fabs(sum) + fabs(second_sum) < 1e-9 ? total : INFINITY;
}

double weft_analysis_slope(const struct weft_kernel *kernel)
{
    enum { POSITIONS = 256 };
    double largest = 0.0;
    if (!weft_kernel_usable(kernel))
        return NAN;
    for (int i = 0; i < POSITIONS && kernel->info->derivative; i++) {
        const double at = (i + 0.5) / POSITIONS;
        double sum = 0.0, fraction;
        const int64_t first = weft_kernel_first_tap(kernel, at, &fraction);
        for (int tap = 0; tap < kernel->width; tap++)
            sum += fabs(weft_kernel_derivative(kernel, at - (double)(first + tap)));
        largest = fmax(largest, sum);
    }
    return largest;
}

double weft_analysis_curvature(const struct weft_kernel *kernel)
{
    if (!weft_kernel_usable(kernel))
        return NAN;
    const struct weft_prefilter prefilter = prefilter_of(kernel);
    const double largest = maximum(kernel, &prefilter, curvature_at, 0.0, 1.0);
    return isfinite(largest) ? largest : 0.0;
}
