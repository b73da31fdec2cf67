// SPDX-License-Identifier: BSD-3-Clause
// How far off results of hardware filtering may be.
//
// Along an axis the exact weights of the taps are a_i, with sums of |a_i| of at most g, the
// kernel's gain. The shader has a_i' in their place, off by `weight` in all: Horner's rule and the
// rounding of t as in the fused pass, one more rounding for each sum of two, and for pairs of one
// wrong sign both taps by the smaller one, since the offset is clamped to [0, 1] (a roundings' size
// more where only the rounded weights differ in sign).
//
// A fetch asks the sampler for c = i + 1/2 + o, with o = a_{i+1}' / (a_i' + a_{i+1}') (or 0), in
// [0, 1]. GL promises no division better than 2.5 units in the last place: o is off by up to 4
// units with the rounding of what is divided. It is then rounded to a multiple of 2^-15, so that c
// is exact in textures of up to 512 texels; dividing by their size, a power of two, and what the
// sampler does to undo that, are exact. So the sampler's fraction is off from that of exact
// arithmetic by no more than
//     `fraction` = what was measured + 2^-16 + 2^-22,
// and neither goes past the two texels, as the sampler gives them at their centres and its
// fractions do not fall. Pixels do not depend on where in the texture their voxels lie, as far as
// the sampler does not.
//
// A trilinear fetch whose fractions are off by d along each axis is off by at most 3 d times the
// largest difference of neighbours among its own eight texels, which are taps: at most the range W
// of the values read. Over all fetches weights sum up to at most (g + weight)^3. Blending itself
// rounds by 3 times what was measured (or 5 units: a difference, a product, a sum), relative to the
// largest |texel| M. Then come the roundings of sums of products, as in the fused pass. In all
//     (g + weight)^3 (1 + sums) - g^3             times M
//   + (g + weight)^3 (1 + sums) 3 rounding        times M
//   + (g + weight)^3 (1 + sums) 3 fraction        times W.
#include <math.h>

#include "passes/hardware/plan.h"

static const double UNIT = 0x1p-24; // unit roundoff of single precision

// Of one axis, in units of the largest |value read|.
static double weight_error(const struct weft_slice_plan *slice,
                           const struct weft_hardware_pairs *pairs)
{
    return weft_slice_weight_bound(slice) + UNIT * slice->smooth.gain + pairs->wrong_sign +
           2.0 * pairs->pairs * slice->weights[0]->error;
}

struct weft_bound_terms weft_hardware_bound(const struct weft_slice_plan *slice,
                                            const struct weft_hardware_pairs *pairs,
                                            const struct weft_sampler *sampler)
{
    const double gain = slice->smooth.gain, whole = pow(gain, 3);
    const double rounding = fmax(sampler->rounding, 5.0 * UNIT);
    const double fraction = sampler->fraction + 0x1p-16 + 0x1p-22;
    const double sums = 1.0 + 3.0 * (pairs->fetches + 1) * UNIT;
    const double reached = pow(gain + weight_error(slice, pairs), 3) * sums;
    const double relative = reached - whole + reached * 3.0 * rounding;
    const double sampled = reached * 3.0 * fraction;
    struct weft_bound_terms terms =
        slice->info.output[0].bound; // of the grid's numbers and the prefilter
    terms.relative = relative;
    terms.e3 = sampled;
    // What GL may flush to 0 is below 2^-126: texels, blends, products and sums on three levels.
    terms.absolute =
        0x1p-124 * (slice->info.kernel.width + gain + 1.0) * (1.0 + gain + gain * gain);
    if (slice->info.source == WEFT_SOURCE_FLOAT)
        return terms;
    // All of it is relative to the source's own range then, as in the fused pass.
    const struct weft_source_range *range = &slice->range;
    const double width = range->high - range->low;
    const double offset = fmax(fabs(range->low), fabs(range->high));
    const double off = relative + sampled;
    terms.relative = terms.e3 = 0.0;
    if (!slice->info.kernel.unit_sum) // their sum, by which the range's offset counts, is off too
        terms.absolute += (reached - whole) * offset;
    terms.absolute += width * (weft_source_format_error(slice->info.source) * (whole + off) + off +
                               2.0 * UNIT * whole) +
                      4.0 * UNIT * whole * offset;
    return terms;
}
