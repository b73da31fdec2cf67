// SPDX-License-Identifier: BSD-3-Clause
// What theory says of kernels, seen in reconstructions: the order of approximation and E1 (Moeller
// et al. 1997), measured on plane waves by direct convolution.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>

#include "tests/support/common.h"
#include "weft.h"

struct wave {
    double frequency, phase; // the frequency is the same along every axis in use
};

static double fetch_wave(void *priv, const int64_t index[3])
{
    const struct wave *wave = priv;
    double along = (double)index[0] + (double)index[1] + (double)index[2];
    return cos(wave->frequency * along + wave->phase);
}

// The largest |reconstruction - f^(d)| over positions of a cell and phases of the wave.
static double wave_error(const struct weft_kernel *kernel, int dims, double frequency)
{
    enum { PHASES = 16 };
    int steps = dims == 1 ? 64 : 12, d = kernel->info->derivation;
    double largest = 0.0;
    for (int i = 0; i < steps * PHASES; i++) {
        struct wave wave = {frequency, 2.0 * M_PI * (i % PHASES) / PHASES};
        // On the lattice too, and in the middle.
        double position = (double)(i / PHASES) / steps, at[3] = {position, position, position};
        double exact =
            pow(frequency, d) * cos(frequency * dims * position + wave.phase + d * M_PI / 2);
        double value = weft_reference_compute(kernel, dims, at, fetch_wave, &wave).value;
        largest = larger(largest, fabs(value - exact));
    }
    return largest;
}

static struct weft_kernel make(const struct weft_kernel_info *info)
{
    struct weft_kernel kernel;
    assert_int_equal(weft_kernel_create(NULL, info, NULL, &kernel), WEFT_OK);
    return kernel;
}

// Halving the frequency divides the error by 2^(order + derivation).
static void every_kernel_converges_with_its_order(void **state)
{
    (void)state;
    for (const struct weft_kernel_info *const *k = weft_kernel_list; *k; k++) {
        struct weft_kernel kernel = make(*k);
        // High enough for the error to stand above double's rounding, low enough for its first
        // term.
        double frequency = kernel.order > 4 ? 0.3 : 0.05;
        double observed =
            log2(wave_error(&kernel, 1, frequency) / wave_error(&kernel, 1, 0.5 * frequency));
        double expected = kernel.order + (*k)->derivation;
        // Order 0: what does not converge has an error of its own size, whatever the derivative's.
        bool right = kernel.order > 0 ? fabs(observed - expected) < 0.1 : observed < expected + 0.1;
        if (!right)
            fail_msg("%s: observed order %.3f, expected %.0f", (*k)->name, observed, expected);
    }
}

// E1 is the error's leading term at its largest: reached, and not passed by more than the next one.
static void e1_bounds_the_error_on_waves(void **state)
{
    (void)state;
    int in_1d = 0, in_3d = 0;
    for (const struct weft_kernel_info *const *k = weft_kernel_list; *k; k++) {
        struct weft_kernel kernel = make(*k);
        if (kernel.order == 0)
            continue;
        in_1d++;
        double frequency = kernel.order > 4 ? 0.3 : 0.05;
        double derivative = pow(frequency, kernel.order + (*k)->derivation);
        double bound = weft_error_e1(&kernel, 1, derivative);
        double measured = wave_error(&kernel, 1, frequency);
        if (!(measured <= 1.05 * bound && measured >= 0.5 * bound))
            fail_msg("%s: E1 is %.4g, measured %.4g", (*k)->name, bound, measured);
        if (kernel.width > 4 || (*k)->derivation > 0)
            continue; // products of derivatives are mixed ones
        in_3d++;
        bound = weft_error_e1(&kernel, 3, derivative);
        measured = wave_error(&kernel, 3, frequency);
        if (!(measured <= 1.1 * bound))
            fail_msg("%s in 3D: E1 is %.4g, measured %.4g", (*k)->name, bound, measured);
    }
    assert_true(in_1d >= 10 && in_3d >= 5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_kernel_converges_with_its_order),
        cmocka_unit_test(e1_bounds_the_error_on_waves),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
