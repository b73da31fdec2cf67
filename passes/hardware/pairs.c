// SPDX-License-Identifier: BSD-3-Clause
#include "passes/hardware/pairs.h"

#include <math.h>

enum { MAX_TERMS = WEFT_POLYNOMIAL_MAX_DEGREE + 1, MAX_HALVINGS = 24 };

// A polynomial over a part of a segment, by its Bernstein coefficients: it lies between the least
// and the largest of them, and takes the first and the last one at the part's ends.
struct part {
    int degree;
    double c[MAX_TERMS];
};

// Of tap `tap` in a segment: b_j = sum_k C(j, k) / C(n, k) c_k of the monomials' c.
static struct part part_of(const struct weft_polynomial_tiles *t, int segment, int tap)
{
    const size_t stride = 4 * (size_t)t->groups;
    const float *monomial =
        t->coefficients + (size_t)segment * (size_t)(t->degree + 1) * stride + tap;
    struct part p = {.degree = t->degree};
    for (int j = 0; j <= t->degree; j++) {
        double ratio = 1.0; // C(j, k) / C(n, k)
        for (int k = 0; k <= j; k++) {
            p.c[j] += ratio * (double)monomial[(size_t)k * stride];
            ratio *= (double)(j - k) / (double)(t->degree - k > 0 ? t->degree - k : 1);
        }
    }
    return p;
}

// De Casteljau's halves.
static void halve(const struct part *whole, struct part *first, struct part *second)
{
    struct part p = *whole;
    const int n = p.degree;
    first->degree = second->degree = n;
    for (int j = 0; j <= n; j++) {
        first->c[j] = p.c[0];
        second->c[n - j] = p.c[n - j];
        for (int k = 0; k < n - j; k++)
            p.c[k] = 0.5 * (p.c[k] + p.c[k + 1]);
    }
}

static void enclose(const struct part *p, double *low, double *high)
{
    *low = *high = p->c[0];
    for (int j = 1; j <= p->degree; j++) {
        *low = fmin(*low, p->c[j]);
        *high = fmax(*high, p->c[j]);
    }
}

// At least how far one of two weights is on the other one's wrong side, anywhere in the part;
// INFINITY where that is more than a rounding, or may be.
static double find_wrong(const struct part *a, const struct part *b, int halvings)
{
    double low_a, high_a, low_b, high_b;
    enclose(a, &low_a, &high_a);
    enclose(b, &low_b, &high_b);
    const double below = fmax(0.0, -fmin(low_a, low_b)), above = fmax(0.0, fmax(high_a, high_b));
    // As both above 0, as both below, or as one that is next to nothing.
    const double least_a = fmax(-low_a, high_a), least_b = fmax(-low_b, high_b);
    const double wrong = fmin(fmin(below, above), fmin(least_a, least_b));
    if (wrong <= WEFT_HARDWARE_WRONG_SIGN)
        return wrong;
    // Where signs differ at an end there is no need to look closer.
    const double end = fmin(fabs(a->c[0]), fabs(b->c[0]));
    if (halvings == 0 || (a->c[0] * b->c[0] < 0.0 && end > WEFT_HARDWARE_WRONG_SIGN))
        return INFINITY;
    struct part half_a[2], half_b[2];
    halve(a, &half_a[0], &half_a[1]);
    halve(b, &half_b[0], &half_b[1]);
    const double first = find_wrong(&half_a[0], &half_b[0], halvings - 1);
    return isinf(first) ? first : fmax(first, find_wrong(&half_a[1], &half_b[1], halvings - 1));
}

// Of taps `tap` and the next one, over all segments.
static double find_pair(const struct weft_polynomial_tiles *tiles, int tap)
{
    double wrong = 0.0;
    for (int segment = 0; segment < tiles->segments && !isinf(wrong); segment++) {
        const struct part a = part_of(tiles, segment, tap), b = part_of(tiles, segment, tap + 1);
        wrong = fmax(wrong, find_wrong(&a, &b, MAX_HALVINGS));
    }
    return wrong;
}

// Taking the first pair that there is, from the first tap on, leaves the fewest taps alone.
void weft_hardware_pairs_find(const struct weft_polynomial_tiles *tiles,
                              struct weft_hardware_pairs *out)
{
    *out = (struct weft_hardware_pairs){0};
    for (int tap = 0; tap < tiles->width; tap++) {
        const double wrong = tap + 1 < tiles->width ? find_pair(tiles, tap) : INFINITY;
        const bool paired = !isinf(wrong);
        out->tap[out->fetches] = tap;
        out->paired[out->fetches++] = paired;
        out->pairs += paired;
        // Both of the two are off by the smaller one.
        out->wrong_sign += paired ? 2.0 * wrong : 0.0;
        tap += paired;
    }
}
