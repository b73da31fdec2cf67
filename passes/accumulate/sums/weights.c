// SPDX-License-Identifier: BSD-3-Clause
#include "passes/accumulate/sums/weights.h"

// Known weights are scaled where the largest is outside of these powers of two.
enum { LEAST_LOG2 = -8 };

void weft_weights_scale(struct weft_weights *weights, double largest)
{
    const int log2 = largest > 0.0 ? ilogb(largest) : 0;
    if (log2 < LEAST_LOG2 || log2 >= WEFT_WEIGHT_LARGEST_LOG2)
        weights->scale_log2 = -log2;
}

bool weft_weight_make(const struct weft_weights *weights, double weight, struct weft_weight *out)
{
    const double scaled = ldexp(weight, weights->scale_log2);
    *out = (struct weft_weight){.scaled = scaled};
    if (!(fabs(scaled) <= ldexp(1.0, WEFT_WEIGHT_LARGEST_LOG2)))
        return false;
    out->fixed = (weft_wide)nearbyint(ldexp(scaled, WEFT_WEIGHT_BITS));
    if (fabs(scaled) < WEFT_WEIGHT_NARROW_TOTAL && scaled == nearbyint(scaled))
        out->integer = (int32_t)scaled;
    return true;
}

// |integers| of both, -1 where that is not narrow.
static int64_t integers_of(int64_t a, int64_t b)
{
    return a >= 0 && b >= 0 && a + b < WEFT_WEIGHT_NARROW_TOTAL ? a + b : -1;
}

bool weft_weight_is_integer(const struct weft_weight *weight)
{
    return weight->integer != 0 || weight->fixed == 0;
}

static int64_t integer_of(const struct weft_weight *weight)
{
    if (!weft_weight_is_integer(weight))
        return -1;
    return weight->integer < 0 ? -(int64_t)weight->integer : weight->integer;
}

bool weft_weights_are_narrow(const struct weft_weights *weights, const struct weft_weight *weight)
{
    return integers_of(weights->integers, integer_of(weight)) >= 0;
}

void weft_weights_add(struct weft_weights *weights, const struct weft_weight *weight)
{
    const weft_uwide magnitude = weft_wide_magnitude(weight->fixed);
    const double kept = ldexp((double)weight->fixed, -WEFT_WEIGHT_BITS);
    weights->total += weight->fixed;
    weights->square = weft_wide256_sum(weights->square, weft_wide256_product(magnitude, magnitude));
    weights->integers = integers_of(weights->integers, integer_of(weight));
    weights->magnitude += magnitude;
    const double lost = fabs(kept - weight->scaled); // 2^-65 at most
    weights->lost += (uint64_t)ceil(ldexp(lost, WEFT_WEIGHT_LOST_BITS));
    if (lost > 0.0)
        weights->change = fmax(weights->change, lost / fabs(weight->scaled));
}

void weft_weights_join(struct weft_weights *weights, const struct weft_weights *other)
{
    weights->total += other->total;
    weights->square = weft_wide256_sum(weights->square, other->square);
    weights->integers = integers_of(weights->integers, other->integers);
    weights->magnitude += other->magnitude;
    weights->change = fmax(weights->change, other->change);
    weights->lost += other->lost;
}

double weft_weights_total(const struct weft_weights *weights)
{
    return ldexp((double)weights->total, -WEFT_WEIGHT_BITS - weights->scale_log2);
}

double weft_weights_square(const struct weft_weights *weights)
{
    return ldexp(weft_wide256_to_double(weights->square),
                 -2 * (WEFT_WEIGHT_BITS + weights->scale_log2));
}
