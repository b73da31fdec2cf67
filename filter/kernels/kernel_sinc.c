// SPDX-License-Identifier: BSD-3-Clause
// Windowed sincs: sinc(x) times a window over [-r, r), with r the first parameter. Derivatives by
// Leibniz's rule from the derivatives of both; also the truncated Gaussian.
#include "filter/kernels/kernel_records.h"

#include <math.h>
#include <stddef.h>

enum { MAX_DERIVATIVE = 2 };

// sin(pi x) and cos(pi x), exact at integers and half integers.
static double sin_pi(double x)
{
    const double nearest = nearbyint(x), rest = sin(M_PI * (x - nearest));
    return fmod(nearest, 2.0) == 0.0 ? rest : -rest;
}

static double cos_pi(double x)
{
    return sin_pi(0.5 - fabs(x)); // even to the last bit
}

// sum_m (-pi^2)^m x^(2m) / (2m + 1)!, differentiated term by term.
static void sinc_series(double x, double out[MAX_DERIVATIVE + 1])
{
    const double square = -M_PI * M_PI;
    double term = 1.0; // (-pi^2)^m / (2m + 1)!
    for (int n = 0; n <= MAX_DERIVATIVE; n++)
        out[n] = 0.0;
    double power[3] = {1.0, 0.0, 0.0}; // x^(2m), x^(2m - 1), x^(2m - 2)
    for (int m = 0; m < 12; m++) {
        out[0] += term * power[0];
        out[1] += term * power[1] * (2 * m);
        out[2] += term * power[2] * (2 * m) * (2 * m - 1);
        power[2] = power[0];
        power[1] = power[0] * x;
        power[0] *= x * x;
        term *= square / ((2 * m + 2) * (2 * m + 3));
    }
}

// sinc, sinc' and sinc'' at x; the closed forms cancel near 0, where the series converges at once.
static void sinc(double x, double out[MAX_DERIVATIVE + 1])
{
    if (fabs(x) < 0.5) {
        sinc_series(x, out);
        return;
    }
    out[0] = sin_pi(x) / (M_PI * x);
    out[1] = (cos_pi(x) - out[0]) / x;
    out[2] = -M_PI * M_PI * out[0] - 2.0 * out[1] / x;
}

// w, w' and w'' at x in [-r, r).
typedef void window(const struct weft_kernel *kernel, double x, double out[MAX_DERIVATIVE + 1]);

static void cosines(const double a[3], double r, double x, double out[MAX_DERIVATIVE + 1])
{
    const double u = x / r, rate = M_PI / r;
    out[0] = a[0] + a[1] * cos_pi(u) + a[2] * cos_pi(2.0 * u);
    out[1] = -rate * (a[1] * sin_pi(u) + 2.0 * a[2] * sin_pi(2.0 * u));
    out[2] = -rate * rate * (a[1] * cos_pi(u) + 4.0 * a[2] * cos_pi(2.0 * u));
}

static void hann_window(const struct weft_kernel *kernel, double x, double out[MAX_DERIVATIVE + 1])
{
    cosines((const double[3]){0.5, 0.5, 0.0}, kernel->support, x, out);
}

static void hamming_window(const struct weft_kernel *kernel, double x,
                           double out[MAX_DERIVATIVE + 1])
{
    cosines((const double[3]){0.54, 0.46, 0.0}, kernel->support, x, out);
}

static void blackman_window(const struct weft_kernel *kernel, double x,
                            double out[MAX_DERIVATIVE + 1])
{
    cosines((const double[3]){0.42, 0.5, 0.08}, kernel->support, x, out);
}

static void lanczos_window(const struct weft_kernel *kernel, double x,
                           double out[MAX_DERIVATIVE + 1])
{
    const double r = kernel->support;
    sinc(x / r, out);
    out[1] /= r;
    out[2] /= r * r;
}

// I_n(z) / z^n from its power series in z^2 / 4, all terms positive.
static double bessel_ratio(int n, double quarter_square)
{
    double term = n == 0 ? 1.0 : n == 1 ? 0.5 : 0.125, sum = 0.0; // 1 / (2^n n!)
    for (int k = 1; sum + term != sum; k++) {
        sum += term;
        term *= quarter_square / ((double)k * (k + n));
    }
    return sum;
}

// I0(z) / I0(beta), z = beta sqrt(1 - u^2): z dz/du = -beta^2 u and d/dz (I_n / z^n) = I_(n+1) /
// z^n.
static void kaiser_window(const struct weft_kernel *kernel, double x,
                          double out[MAX_DERIVATIVE + 1])
{
    const double r = kernel->support, u = x / r, b2 = kernel->param[1] * kernel->param[1];
    const double z2 = 0.25 * b2 * (1.0 - u * u), scale = 1.0 / bessel_ratio(0, 0.25 * b2);
    const double i1 = bessel_ratio(1, z2), i2 = bessel_ratio(2, z2);
    out[0] = scale * bessel_ratio(0, z2);
    out[1] = -scale * b2 * u / r * i1;
    out[2] = -scale * b2 / (r * r) * (i1 - b2 * u * u * i2);
}

static void gauss_window(const struct weft_kernel *kernel, double x, double out[MAX_DERIVATIVE + 1])
{
    const double s2 = kernel->param[1] * kernel->param[1];
    out[0] = exp(-0.5 * x * x / s2);
    out[1] = -x / s2 * out[0];
    out[2] = (x * x / s2 - 1.0) / s2 * out[0];
}

static void welch_window(const struct weft_kernel *kernel, double x, double out[MAX_DERIVATIVE + 1])
{
    const double r2 = kernel->support * kernel->support;
    out[0] = (kernel->support - x) * (kernel->support + x) / r2;
    out[1] = -2.0 * x / r2;
    out[2] = -2.0 / r2;
}

static void rect_window(const struct weft_kernel *kernel, double x, double out[MAX_DERIVATIVE + 1])
{
    (void)kernel;
    (void)x;
    out[0] = 1.0;
    out[1] = out[2] = 0.0;
}

struct window_data {
    window *function;
};

static double windowed(const struct weft_kernel *kernel, double x, int n)
{
    if (!(x >= -kernel->support && x < kernel->support))
        return 0.0;
    double s[MAX_DERIVATIVE + 1], w[MAX_DERIVATIVE + 1];
    sinc(x, s);
    ((const struct window_data *)kernel->info->data)->function(kernel, x, w);
    return n == 0   ? s[0] * w[0]
           : n == 1 ? s[1] * w[0] + s[0] * w[1]
                    : s[2] * w[0] + 2.0 * s[1] * w[1] + s[0] * w[2];
}

WEFT_KERNEL_NTH(windowed, 0)
WEFT_KERNEL_NTH(windowed, 1)
WEFT_KERNEL_NTH(windowed, 2)

// A whole half-width ends on a zero of the sinc, which is worth one derivative.
static void refine(struct weft_kernel *kernel)
{
    const struct weft_kernel_info *base =
        kernel->info->primitive ? kernel->info->primitive : kernel->info;
    const bool whole = kernel->support == floor(kernel->support);
    kernel->continuity = base->continuity + whole - kernel->info->derivation;
    if (kernel->continuity < -1)
        kernel->continuity = -1;
}

#define WINDOWED(self, text, its_continuity, about, ...)                                           \
    {                                                                                              \
        WEFT_KERNEL_RECORD(text, windowed, -1, its_continuity,                                     \
                           (.description = "sinc with " about, .interpolating = true),             \
                           .refine = refine, __VA_ARGS__),                                         \
            WEFT_KERNEL_D(self, text, windowed, -1, its_continuity, 0, .refine = refine,           \
                          __VA_ARGS__),                                                            \
            WEFT_KERNEL_DD(self, text, windowed, NULL, -1, its_continuity, 0, .refine = refine,    \
                           __VA_ARGS__),                                                           \
    }
#define HARRIS .citation = "Harris, Proc. IEEE 1978; Theussl, Hauser and Groeller 2000"
#define WINDOW(its_function)                                                                       \
    .data = &(const struct window_data)                                                            \
    {                                                                                              \
        its_function                                                                               \
    }
#define RADIUS(initial)                                                                            \
    {                                                                                              \
        "radius", initial, 0.5, 8.0                                                                \
    }
#define ONLY_RADIUS(initial) .params = {RADIUS(initial)}
#define RADIUS_AND(initial, ...) .params = {RADIUS(initial), {__VA_ARGS__}}

const struct weft_kernel_info weft_kernel_hann[3] = WINDOWED(
    weft_kernel_hann, "hann-sinc", 1, "a Hann window", HARRIS, ONLY_RADIUS(3), WINDOW(hann_window));
const struct weft_kernel_info weft_kernel_hamming[3] =
    WINDOWED(weft_kernel_hamming, "hamming-sinc", -1, "a Hamming window", HARRIS, ONLY_RADIUS(3),
             WINDOW(hamming_window));
const struct weft_kernel_info weft_kernel_blackman[3] =
    WINDOWED(weft_kernel_blackman, "blackman-sinc", 1, "a Blackman window (0.42, 0.5, 0.08)",
             HARRIS, ONLY_RADIUS(2), WINDOW(blackman_window));
const struct weft_kernel_info weft_kernel_lanczos[3] =
    WINDOWED(weft_kernel_lanczos, "lanczos", 0, "the main lobe of a wider sinc",
             .citation = "Duchon, Journal of Applied Meteorology 1979", ONLY_RADIUS(3),
             WINDOW(lanczos_window));
const struct weft_kernel_info weft_kernel_kaiser[3] =
    WINDOWED(weft_kernel_kaiser, "kaiser-sinc", -1, "a Kaiser window",
             .citation = "Kaiser, IEEE Symposium on Circuits and Systems 1974",
             RADIUS_AND(2, "beta", 5.36, 0, 50), WINDOW(kaiser_window));
const struct weft_kernel_info weft_kernel_gauss_sinc[3] =
    WINDOWED(weft_kernel_gauss_sinc, "gauss-sinc", -1, "a Gaussian window", HARRIS,
             RADIUS_AND(3, "sigma", 1.2, 0.05, 100), WINDOW(gauss_window));
const struct weft_kernel_info weft_kernel_welch[3] =
    WINDOWED(weft_kernel_welch, "welch-sinc", 0, "a parabolic window", HARRIS, ONLY_RADIUS(3),
             WINDOW(welch_window));
const struct weft_kernel_info weft_kernel_rect[3] =
    WINDOWED(weft_kernel_rect, "rect-sinc", -1, "no window, truncated", HARRIS, ONLY_RADIUS(3),
             WINDOW(rect_window));

// Scaled to unit integral after the truncation.
static double gaussian(const struct weft_kernel *kernel, double x, int n)
{
    if (!(x >= -kernel->support && x < kernel->support))
        return 0.0;
    const double sigma = kernel->param[1];
    double w[MAX_DERIVATIVE + 1];
    gauss_window(kernel, x, w);
    return w[n] / (sigma * sqrt(2.0 * M_PI) * erf(kernel->support / (sigma * M_SQRT2)));
}

WEFT_KERNEL_NTH(gaussian, 0)
WEFT_KERNEL_NTH(gaussian, 1)
WEFT_KERNEL_NTH(gaussian, 2)

#define GAUSSIAN .citation = "truncated normal density", RADIUS_AND(2, "sigma", 0.5, 0.05, 100)
const struct weft_kernel_info weft_kernel_gaussian[3] = {
    WEFT_KERNEL_RECORD("gaussian", gaussian, -1, -1, (.description = "truncated Gaussian"),
                       GAUSSIAN),
    WEFT_KERNEL_D(weft_kernel_gaussian, "gaussian", gaussian, -1, -1, 0, GAUSSIAN),
    WEFT_KERNEL_DD(weft_kernel_gaussian, "gaussian", gaussian, NULL, -1, -1, 0, GAUSSIAN),
};
