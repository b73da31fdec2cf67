// Head of an application's fragment shaders in accumulative anti-aliasing. Behind #version, with
// POST_DEPTH, COINCIDENT (as enum weft_acaa_coincident), FLOATS, SUM_WORDS, WEIGHT_WORDS, DEVICE,
// SIDE, TOTAL, BOX (all weights are 1), WEIGHT_LAYER, WEIGHT_SHIFT, BACKGROUND_LAYER and the units'
// numbers defined.
#if POST_DEPTH
layout(post_depth_coverage) in;
#endif
layout(early_fragment_tests) in;

// Layers: sums of red, green and blue, then weights; low words first.
layout(binding = SUMS_UNIT, r32ui) uniform uimage2DArray weft_sums;
// The largest |component| beyond the range, as a float's bits; then rows, one for each pixel that a
// sample counts in, from the lower corner: a mask of the samples that do, and their weights.
layout(binding = TABLE_UNIT, r32i) uniform iimageBuffer weft_table;
#if COINCIDENT == 1
layout(binding = CLAIMS_UNIT, r32ui) uniform uimage2D weft_claims;
#endif
layout(std140, binding = PASS_BINDING) uniform weft_pass {
    ivec2 weft_size;    // of the picture
    ivec2 weft_first;   // the first row's pixel, from the target's
    float weft_scale;   // integers for each unit of colour
    float weft_range;
    int weft_rows;      // where this pass's begin in the table
};

const uint weft_all = 0xffffffffu >> (32 - DEVICE);

// What of the pixel's samples is seen and is this call's.
uint weft_visible()
{
#if POST_DEPTH
    return uint(gl_SampleMaskIn[0]) & weft_all;
#else
    return (1u << uint(gl_SampleID)) & weft_all;
#endif
}

// As alpha to coverage: the first samples of a pixel, as many as their share, rounded down.
uint weft_covered(float alpha)
{
    if (alpha >= 1.0)
        return weft_all;
    return (1u << uint(alpha > 0.0 ? alpha * float(DEVICE) : 0.0)) - 1u;
}

// Adds an integer of two words. Returns the low one that was there.
uint weft_add_wide(ivec3 at, int high, uint low)
{
    uint seen = imageAtomicAdd(weft_sums, at, low);
    high += seen > 0xffffffffu - low ? 1 : 0;
    if (high != 0)
        imageAtomicAdd(weft_sums, at + ivec3(0, 0, 1), uint(high));
    return seen;
}

#if FLOATS
// GL has no addition of floats that others cannot come between. Calls that have no fragment change
// nothing, and would wait for ever.
void weft_add_float(ivec3 at, float value)
{
    if (gl_HelperInvocation)
        return;
    uint seen = imageLoad(weft_sums, at).r;
    for (;;) {
        uint sum = floatBitsToUint(uintBitsToFloat(seen) + value);
        uint found = imageAtomicCompSwap(weft_sums, at, seen, sum);
        if (found == seen)
            break;
        seen = found;
    }
}
#endif

// Counts a weight of surfaces. Returns what of it counts.
int weft_count(ivec2 at, int weight)
{
    ivec3 place = ivec3(at, WEIGHT_LAYER);
#if WEIGHT_WORDS == 1
    uint seen = imageAtomicAdd(weft_sums, place, uint(weight) << WEIGHT_SHIFT) >> WEIGHT_SHIFT;
#else
    uint seen = weft_add_wide(place, weight < 0 ? -1 : 0, uint(weight));
#if COINCIDENT == 2
    if (imageLoad(weft_sums, place + ivec3(0, 0, 1)).r != 0u)
        return 0;
#endif
#endif
#if COINCIDENT == 2
    return clamp(TOTAL - int(min(seen, uint(TOTAL))), 0, weight);
#else
    return weight;
#endif
}

void weft_add_colour(ivec2 at, vec3 colour, ivec3 integers, int weight)
{
    weight = weft_count(at, weight);
    for (int c = 0; c < 3; c++) {
#if FLOATS
        weft_add_float(ivec3(at, c), colour[c] * float(weight));
#elif SUM_WORDS == 1
        imageAtomicAdd(weft_sums, ivec3(at, c), uint(integers[c] * weight));
#else
        int high, low;
        imulExtended(integers[c], weight, high, low);
        weft_add_wide(ivec3(at, 2 * c), high, uint(low));
#endif
    }
}

int weft_weigh(int row, uint mask)
{
#if BOX
    return bitCount(mask);
#endif
    int weight = 0;
    for (int i = 0; i < DEVICE; i++)
        if ((mask & (1u << uint(i))) != 0u)
            weight += imageLoad(weft_table, row + 1 + i).r;
    return weight;
}

// What these samples count in the pixels around: calls add(pixel, weight) for each.
#define WEFT_SPREAD(mask, add)                                                                     \
    for (int y = 0; y < SIDE; y++)                                                                 \
        for (int x = 0; x < SIDE; x++) {                                                           \
            ivec2 at = ivec2(gl_FragCoord.xy) + weft_first + ivec2(x, y);                          \
            int row = weft_rows + (y * SIDE + x) * (DEVICE + 1);                                   \
            uint counting = mask & uint(imageLoad(weft_table, row).r);                             \
            if (counting == 0u || any(lessThan(at, ivec2(0))) ||                                   \
                any(greaterThanEqual(at, weft_size)))                                              \
                continue;                                                                          \
            int weight = weft_weigh(row, counting);                                                \
            add;                                                                                   \
        }

// Notes a component that is beyond the range, or not finite. Those that are there are not noted
// again.
void weft_note(vec3 colour)
{
    int largest = 0;
    for (int c = 0; c < 3; c++)
        largest = max(largest, floatBitsToInt(colour[c]) & 0x7fffffff);
    if (largest > floatBitsToInt(weft_range) && largest > imageLoad(weft_table, 0).r)
        imageAtomicMax(weft_table, 0, largest);
}

void weft_write(vec4 colour, uint surface)
{
    uint mask = weft_visible() & weft_covered(colour.a);
    if (mask == 0u)
        return;
#if COINCIDENT == 1
    mask &= ~imageAtomicOr(weft_claims, ivec2(gl_FragCoord.xy), mask);
#endif
    weft_note(colour.rgb);
    // NAN becomes some number within the range.
    vec3 inside = min(max(colour.rgb, -weft_range), weft_range);
    ivec3 integers = ivec3(roundEven(inside * weft_scale));
    WEFT_SPREAD(mask, weft_add_colour(at, colour.rgb, integers, weight))
}

// Samples without a surface.
void weft_write_background()
{
    uint mask = weft_visible();
#if COINCIDENT == 1
    mask &= ~imageAtomicOr(weft_claims, ivec2(gl_FragCoord.xy), mask);
#endif
    WEFT_SPREAD(mask, imageAtomicAdd(weft_sums, ivec3(at, BACKGROUND_LAYER), uint(weight)))
}
