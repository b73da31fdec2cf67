// SPDX-License-Identifier: BSD-3-Clause
// Sequences of low discrepancy, in integers.
#include <math.h>

#include "filter/check.h"
#include "passes/jitter/sets.h"

double weft_jitter_radical_inverse(uint32_t base, uint64_t index)
{
    if (base < 2 || base > 1u << 26)
        return NAN;
    uint64_t mirrored = 0, scale = 1;
    for (uint64_t rest = index; rest && scale <= (UINT64_C(1) << 53) / base; rest /= base) {
        mirrored = mirrored * base + rest % base;
        scale *= base;
    }
    // Below 2^53 both are doubles: the quotient is rounded once, and is no 1.
    return (double)mirrored / (double)scale;
}

static void compute_halton(const struct weft_jitter_info *info, int count, uint64_t seed,
                           double (*points)[2])
{
    (void)info, (void)seed;
    for (int i = 0; i < count; i++) {
        points[i][0] = weft_jitter_radical_inverse(2, (uint64_t)i + 1) - 0.5;
        points[i][1] = weft_jitter_radical_inverse(3, (uint64_t)i + 1) - 0.5;
    }
}

static void compute_hammersley(const struct weft_jitter_info *info, int count, uint64_t seed,
                               double (*points)[2])
{
    (void)info, (void)seed;
    for (int i = 0; i < count; i++) {
        points[i][0] = (2 * i + 1) / (2.0 * count) - 0.5;
        points[i][1] = weft_jitter_radical_inverse(2, (uint64_t)i) - 0.5;
    }
}

// The second dimension's primitive polynomial is x + 1: of its direction numbers each is the one
// before xor that shifted by one bit.
static void compute_sobol(const struct weft_jitter_info *info, int count, uint64_t seed,
                          double (*points)[2])
{
    (void)info, (void)seed;
    for (int i = 0; i < count; i++) {
        uint32_t x = 0, y = 0, direction = UINT32_C(1) << 31;
        for (int bit = 0; bit < 32; bit++, direction ^= direction >> 1)
            if ((uint32_t)i >> bit & 1) {
                x ^= UINT32_C(1) << (31 - bit);
                y ^= direction;
            }
        points[i][0] = x * 0x1p-32 - 0.5;
        points[i][1] = y * 0x1p-32 - 0.5;
    }
}

// A fraction of 64 bits, cut to the 53 of a double.
static double fraction(uint64_t bits)
{
    return (double)(bits >> 11) * 0x1p-53;
}

// g = 1.32471795724474602596...; multiples of 1/g and 1/g^2 in units of 2^-64, modulo 1.
static void compute_r2(const struct weft_jitter_info *info, int count, uint64_t seed,
                       double (*points)[2])
{
    (void)info, (void)seed;
    const uint64_t half = UINT64_C(1) << 63,
                   steps[2] = {UINT64_C(0xc13fa9a902a6328f), UINT64_C(0x91e10da5c79e7b1d)};
    for (int i = 0; i < count; i++)
        for (int axis = 0; axis < 2; axis++)
            points[i][axis] = fraction(half + ((uint64_t)i + 1) * steps[axis]) - 0.5;
}

const struct weft_jitter_info weft_jitter_halton = {
    .name = "halton",
    .description = "Halton's sequence in bases 2 and 3",
    .citation = "Halton, Numerische Mathematik 2, 1960",
    .default_count = 16,
    .extends = true,
    .compute = compute_halton,
};

const struct weft_jitter_info weft_jitter_hammersley = {
    .name = "hammersley",
    .description = "Hammersley's set in base 2, x at the middles of n columns",
    .citation = "Hammersley, Annals of the New York Academy of Sciences 86, 1960",
    .default_count = 16,
    .compute = compute_hammersley,
};

const struct weft_jitter_info weft_jitter_sobol = {
    .name = "sobol",
    .description = "Sobol's sequence, dimensions 1 and 2: a (0, 2)-sequence in base 2",
    .citation = "Sobol, USSR Computational Mathematics and Mathematical Physics 7(4), 1967",
    .default_count = 16,
    .extends = true,
    .compute = compute_sobol,
};

const struct weft_jitter_info weft_jitter_r2 = {
    .name = "r2",
    .description = "multiples of 1/g and 1/g^2, g^3 = g + 1",
    .citation = "Roberts, The Unreasonable Effectiveness of Quasirandom Sequences, 2018",
    .default_count = 16,
    .extends = true,
    .compute = compute_r2,
};
