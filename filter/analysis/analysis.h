// SPDX-License-Identifier: BSD-3-Clause
// filter/analysis/analysis.h - what a kernel does to a signal, from its definition alone.
// Numbers are good to about 1e-12 for kernels that are smooth between half integers, shifted ends
// +-r + k and nowhere else (all of the catalogue). Radial kernels are analysed as what they are in
// 1D, prefiltered ones (weft_kernel_make_prefiltered) as what they do to samples: in place of h
// stands the cardinal spline. Pure and thread-safe; nothing is allocated. For kernels that
// weft_kernel_check refuses all numbers are NAN, and integers 0.
#ifndef WEFT_FILTER_ANALYSIS_ANALYSIS_H
#define WEFT_FILTER_ANALYSIS_ANALYSIS_H

#include "../kernels/kernel.h"

WEFT_BEGIN_DECLS

// The largest order that is told, and the largest frequency that is answered for.
enum { WEFT_ANALYSIS_MAX_ORDER = 12, WEFT_ANALYSIS_MAX_FREQUENCY = 4096 };

// Returns a_n(t) = sum_k (k - t)^n h(t - k) / n!, the factor of the signal's n-th derivative in the
// reconstruction at t (Moeller, Machiraju, Mueller and Yagel, TVCG 1997). n is 0 to 64 and t
// finite, else NAN.
WEFT_API double weft_analysis_taylor(const struct weft_kernel *kernel, int n, double t);

// Returns the integral of x^n h(x) over the support, n as before.
WEFT_API double weft_analysis_moment(const struct weft_kernel *kernel, int n);

// What the Taylor coefficients show of a kernel's accuracy. d is the derivative that the kernel
// reconstructs (0: the signal itself). An error constant c means an error of
// c T^order |f^(order + d)| at sample distance T, by root mean square over all positions of the
// sample grid, as T goes to 0.
struct weft_analysis_order {
    int order;       // largest N with a_n = (n == d) for all n < N + d; WEFT_ANALYSIS_MAX_ORDER at
                     // most; 0 where not even constants (or their slopes) come out right
    double constant; // of eq. 1: the root mean square of a_N+d(t), less 1 where N = 0
    double largest;  // the same with the maximum over t (to 1e-6) instead: bounds E1
    int prefiltered; // largest L with a_n(t) constant in t for all n < L: Strang and Fix (1971)
    double prefiltered_constant; // the standard deviation of a_L(t): the least error in the space
                                 // of the kernel's shifts (Blu and Unser, IEEE TSP 1999), by least
                                 // squares; 0 where L is 0. That of the spline through the samples
                                 // is `constant` of the prefiltered kernel, and larger
};
// Computes it, which takes tens of milliseconds.
WEFT_API struct weft_analysis_order weft_analysis_order(const struct weft_kernel *kernel);

// The kernel's Fourier transform at a frequency: real and imaginary part.
struct weft_analysis_response {
    double re, im;
};
// Returns H(f), the integral of h(x) exp(-2 pi i f x), f in cycles per sample distance. |f| is at
// most WEFT_ANALYSIS_MAX_FREQUENCY, as the time it takes grows with |f|; else NAN.
WEFT_API struct weft_analysis_response weft_analysis_response(const struct weft_kernel *kernel,
                                                              double frequency);

// The metrics of Marschner and Lobb (Visualization 1994) for the tensor product in 1, 2 or 3
// dimensions: R is the Nyquist cube |f_i| < 1/2, of volume 1. NAN for radial kernels in 2D and 3D.
struct weft_analysis_metrics {
    double smoothing;    // 1 less the energy |H|^2 inside R
    double postaliasing; // the energy |H|^2 outside R
};
// Computes them; NAN for other dims, too.
WEFT_API struct weft_analysis_metrics weft_analysis_metrics(const struct weft_kernel *kernel,
                                                            int dims);

// The reconstruction of a unit step.
struct weft_analysis_overshoot {
    double above; // its largest value, less 1
    double below; // how far it falls below 0
};
// Computes it, from 1024 positions a unit.
WEFT_API struct weft_analysis_overshoot weft_analysis_overshoot(const struct weft_kernel *kernel);

// Returns the largest sum_k |h(t - k)| over t, of 1024 positions refined: the most that samples in
// [-1, 1] give along an axis. NAN for kernels that cannot be used.
WEFT_API double weft_analysis_gain(const struct weft_kernel *kernel);

// Returns the largest sum_k |h'(t - k)| over t, of 256 positions. A shift of a position by d
// changes a result by at most d times this times the largest |sample|. 0 for kernels without a
// derivative; of prefiltered kernels the slope of the kernel itself, that is of its coefficients'
// weights.
WEFT_API double weft_analysis_slope(const struct weft_kernel *kernel);

// Returns how far a result is from linear interpolation at most, in units of the samples' largest
// |second difference|: |(h - linear) * f| <= c max |f_k-1 - 2 f_k + f_k+1|. c is the largest
// sum_m |g_m(t)| over t, where the weights g_m of second differences make the kernel's weights of
// linear ones. 0 where there are none, as the weights do not reproduce constants and ramps.
WEFT_API double weft_analysis_curvature(const struct weft_kernel *kernel);

WEFT_END_DECLS
#endif
