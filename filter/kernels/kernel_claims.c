// SPDX-License-Identifier: BSD-3-Clause
// What a user's record claims, against what its functions give. Asked once, when a kernel is made
// of it: some thousand evaluations. Tolerances let functions pass that compute in single precision.
#include <math.h>

#include "filter/kernels/kernel_records.h"

enum { FRACTIONS = 32, MOST_MOMENTS = 12 };

typedef double function(const struct weft_kernel *kernel, double x);

static const double tolerance = 1e-6;

static double largest(const struct weft_kernel *kernel, function *f)
{
    double most = 0.0;
    const int count = 64 * kernel->width;
    for (int i = 0; i <= count; i++)
        most = fmax(most, fabs(f(kernel, kernel->support * (2.0 * i / count - 1.0))));
    return most;
}

// ---- support ------------------------------------------------------------------------------------

static bool check_zero(const struct weft_log *log, const struct weft_kernel *kernel,
                       const char *member, function *f)
{
    const double limit = tolerance * largest(kernel, f), r = kernel->support;
    for (int i = 0; i <= FRACTIONS; i++) {
        const double beyond = i / (double)FRACTIONS;
        for (int side = 0; side < 2; side++) {
            const double x = side ? r + beyond : nextafter(-r - beyond, -INFINITY);
            const double value = f(kernel, x);
            if (!(fabs(value) <= limit))
                return weft_kernel_complain(log, kernel->info,
                                            "%s is %g at %g: it is 0 outside [-%g, %g), by .radius",
                                            member, value, x, r, r);
        }
    }
    return true;
}

// ---- the degree ---------------------------------------------------------------------------------

static double tap(const struct weft_kernel *kernel, int j, double fraction)
{
    const double offset = weft_kernel_offset(kernel);
    return weft_kernel_value(kernel, weft_kernel_argument(fraction, offset - j));
}

// How far tap j, as a function of the fraction, is off the polynomial through degree + 1 of its
// values at Chebyshev nodes, by the barycentric formula (Berrut and Trefethen, SIAM Review 2004).
static double misfit(const struct weft_kernel *kernel, int degree, int j)
{
    double node[WEFT_KERNEL_MAX_DEGREE + 1], value[WEFT_KERNEL_MAX_DEGREE + 1], most = 0.0;
    for (int i = 0; i <= degree; i++) {
        node[i] = 0.5 - 0.5 * cos(M_PI * (i + 0.5) / (degree + 1));
        value[i] = tap(kernel, j, node[i]);
    }
    for (int k = 0; k < FRACTIONS; k++) {
        const double fraction = k / (double)FRACTIONS;
        double above = 0.0, below = 0.0;
        bool hit = false;
        for (int i = 0; i <= degree && !hit; i++) {
            const double weight = (i % 2 ? -1.0 : 1.0) * sin(M_PI * (i + 0.5) / (degree + 1));
            hit = fraction == node[i];
            above += weight / (fraction - node[i]) * value[i];
            below += weight / (fraction - node[i]);
        }
        if (!hit)
            most = fmax(most, fabs(tap(kernel, j, fraction) - above / below));
    }
    return most;
}

static bool check_degree(const struct weft_log *log, const struct weft_kernel *kernel)
{
    const struct weft_kernel_info *info = kernel->info;
    const double limit = tolerance * largest(kernel, info->weight);
    for (int j = 0; info->degree >= 0 && j < kernel->width; j++) {
        const double off = misfit(kernel, info->degree, j);
        if (!(off <= limit))
            return weft_kernel_complain(
                log, info,
                ".degree is %d, but the weights of tap %d are off a polynomial of the fraction of "
                "that degree by up to %g; -1 says that they are none",
                info->degree, j, off);
    }
    return true;
}

// ---- continuity ---------------------------------------------------------------------------------

// The change of f that is left when [a, b] is halved again and again where it changes more.
static double find_jump(const struct weft_kernel *kernel, function *f, double a, double b,
                        double *where)
{
    double at_a = f(kernel, a), at_b = f(kernel, b);
    for (int i = 0; i < 40; i++) {
        const double middle = 0.5 * (a + b), at_middle = f(kernel, middle);
        if (fabs(at_middle - at_a) > fabs(at_b - at_middle)) {
            b = middle;
            at_b = at_middle;
        } else {
            a = middle;
            at_a = at_middle;
        }
    }
    *where = b;
    return at_b - at_a;
}

static bool check_jumps(const struct weft_log *log, const struct weft_kernel *kernel,
                        const char *what, function *f, double relative)
{
    const int count = 64 * (kernel->width + 1);
    const double limit = relative * largest(kernel, f), end = kernel->support + 0.5;
    for (int i = 0; i < count; i++) {
        const double a = end * (2.0 * i / count - 1.0), b = end * (2.0 * (i + 1) / count - 1.0);
        double where, jump;
        if (fabs(f(kernel, b) - f(kernel, a)) <= limit)
            continue;
        jump = find_jump(kernel, f, a, b, &where);
        if (!(fabs(jump) <= limit))
            return weft_kernel_complain(log, kernel->info,
                                        ".continuity is %d, but %s jumps by %g at %g",
                                        kernel->continuity, what, jump, where);
    }
    return true;
}

static bool check_continuity(const struct weft_log *log, const struct weft_kernel *kernel)
{
    const struct weft_kernel_info *info = kernel->info;
    return (kernel->continuity < 0 || check_jumps(log, kernel, "h", info->weight, tolerance)) &&
           (kernel->continuity < 1 || !info->derivative ||
            check_jumps(log, kernel, "h'", info->derivative, 100.0 * tolerance));
}

// ---- derivatives --------------------------------------------------------------------------------

// Whether `slope` is the derivative of f between its jumps: over short intervals f grows by its
// integral, which kinks do not disturb. Of their steps the one that is farthest off does not count:
// f may jump there.
static bool check_slope(const struct weft_log *log, const struct weft_kernel *kernel,
                        const struct weft_kernel *of, function *f, function *slope,
                        const char *member)
{
    enum { STEPS = 128, PER_UNIT = 8 };
    const int count = PER_UNIT * kernel->width;
    const double step = 2.0 * kernel->support / count / STEPS;
    const double limit = 0.01 * step * STEPS * largest(kernel, slope) + tolerance * largest(of, f);
    for (int i = 0; i < count; i++) {
        const double start = i * STEPS * step - kernel->support;
        double off = 0.0, most = 0.0, before = f(of, start);
        for (int s = 0; s < STEPS; s++) {
            const double after = f(of, start + (s + 1) * step);
            const double by = after - before - step * slope(kernel, start + (s + 0.5) * step);
            off += by;
            most = fabs(by) > fabs(most) ? by : most;
            before = after;
        }
        if (!(fabs(off - most) <= limit))
            return weft_kernel_complain(log, kernel->info,
                                        "%s: between %g and %g its growth and its derivative's "
                                        "integral differ by %g",
                                        member, start, start + STEPS * step, fabs(off));
    }
    return true;
}

static bool check_derivatives(const struct weft_log *log, const struct weft_kernel *kernel,
                              const struct weft_kernel *primitive)
{
    const struct weft_kernel_info *info = kernel->info;
    if (info->derivative &&
        !(check_zero(log, kernel, ".derivative", info->derivative) &&
          check_slope(log, kernel, kernel, info->weight, info->derivative, ".derivative: .weight")))
        return false;
    if (info->derivation == 0)
        return true;
    const bool first = info->derivation == 1;
    function *f = first ? primitive->info->weight : primitive->info->derivative;
    if (!f)
        return weft_kernel_complain(log, info,
                                    ".primitive (%s) has no derivative for .derivation to be 2 of",
                                    primitive->info->name);
    return check_slope(log, kernel, primitive, f, info->weight,
                       first ? ".primitive: its weight" : ".primitive: its derivative");
}

// ---- sums over the taps -------------------------------------------------------------------------

// sum_k (k - x)^n h(x - k) / n! at a fraction, and the largest that rounding may take for it.
static double moment(const struct weft_kernel *kernel, double fraction, int n, double *size)
{
    double weights[WEFT_KERNEL_MAX_WIDTH], sum = 0.0;
    const int64_t first = weft_kernel_weights(kernel, fraction, weights);
    *size = 1.0;
    for (int j = 0; j < kernel->width; j++) {
        double term = weights[j];
        for (int i = 1; i <= n; i++)
            term *= ((double)(first + j) - fraction) / i;
        sum += term;
        *size += fabs(term);
    }
    return sum;
}

static int at_most(int a, int b)
{
    return a < b ? a : b;
}

static bool check_order(const struct weft_log *log, const struct weft_kernel *kernel)
{
    const int derivation = kernel->info->derivation;
    const int count = kernel->order > 0 ? at_most(kernel->order + derivation, MOST_MOMENTS) : 0;
    for (int n = 0; n < count; n++) {
        for (int i = 0; i < FRACTIONS; i++) {
            double size;
            const double fraction = i / (double)FRACTIONS;
            const double sum = moment(kernel, fraction, n, &size), exact = n == derivation;
            if (!(fabs(sum - exact) <= tolerance * size))
                return weft_kernel_complain(
                    log, kernel->info,
                    ".order is %d, but at fraction %g the sum of (k - x)^%d h(x - k) / %d! is %g, "
                    "not %g",
                    kernel->order, fraction, n, n, sum, exact);
        }
    }
    return true;
}

static bool check_order_prefiltered(const struct weft_log *log, const struct weft_kernel *kernel)
{
    const int order = kernel->order_prefiltered;
    if (order > 0 && kernel->info->derivation > 0)
        return weft_kernel_complain(log, kernel->info,
                                    ".order_prefiltered is %d, but records that reconstruct a "
                                    "derivative have none",
                                    order);
    for (int n = 0; n < at_most(order, MOST_MOMENTS); n++) {
        double size;
        const double start = moment(kernel, 0.0, n, &size);
        for (int i = 1; i < FRACTIONS; i++) {
            const double fraction = i / (double)FRACTIONS;
            const double sum = moment(kernel, fraction, n, &size);
            if (!(fabs(sum - start) <= tolerance * size))
                return weft_kernel_complain(
                    log, kernel->info,
                    ".order_prefiltered is %d, but the sum of (k - x)^%d h(x - k) / %d! is %g at "
                    "fraction 0 and %g at %g",
                    order, n, n, start, sum, fraction);
        }
    }
    return true;
}

static bool check_moves(const struct weft_log *log, const struct weft_kernel *kernel)
{
    for (int i = 0; i < FRACTIONS && kernel->info->moves; i++) {
        double weights[WEFT_KERNEL_MAX_WIDTH], most = 0.0, sum = 0.0;
        weft_kernel_weights(kernel, i / (double)FRACTIONS, weights);
        for (int j = 0; j < kernel->width; j++) {
            most = fmax(most, weights[j]);
            sum += fabs(weights[j]);
        }
        if (!(fabs(most - 1.0) <= tolerance && fabs(sum - 1.0) <= tolerance))
            return weft_kernel_complain(log, kernel->info,
                                        ".moves is claimed, but at fraction %g the largest weight "
                                        "is %g of %g: no sample is taken as it is",
                                        i / (double)FRACTIONS, most, sum);
    }
    return true;
}

bool weft_kernel_check_claims(const struct weft_log *log, const struct weft_kernel *kernel,
                              const struct weft_kernel *primitive)
{
    return check_zero(log, kernel, ".weight", kernel->info->weight) && check_moves(log, kernel) &&
           check_degree(log, kernel) && check_derivatives(log, kernel, primitive) &&
           check_continuity(log, kernel) && check_order(log, kernel) &&
           check_order_prefiltered(log, kernel);
}
