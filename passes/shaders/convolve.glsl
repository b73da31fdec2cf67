// Fragment shader: adds one sum of products to a target, in the arithmetic of passes/pass.h.
// Defined: FLOATS (1: half and float targets), ONE (T), EXTRA_BITS (e), DIVISOR, GROUPS, DOT4,
// SPLIT_DOT (1: R, G, B and A apart), CHANNELS, DIMS, PART (0 whole, 1 high, 2 low), READS_TARGET,
// EXACT, LIMIT, LOGARITHMS, LINEAR (1: positions are one number, else POSITION_BITS per axis).

uniform usamplerBuffer entries; // per pixel: source texel at the first tap, tile sample position
uniform int row_entries;
uniform int source_offset[GROUPS];
uniform int tile_base[GROUPS];
uniform ivec3 tile_step[GROUPS]; // along the tile sample position, negative where mirrored
uniform int divisor;             // where DIVISOR is that and no number
#if FLOATS
#define ONE_NUMBER float
#define FOUR_NUMBERS vec4
uniform samplerBuffer source, tiles;
#else
#define ONE_NUMBER int
#define FOUR_NUMBERS ivec4
uniform usamplerBuffer source, tiles;
uniform int rounds; // what n takes along before its low bits go
uniform int n_sign; // of n's low bits
#endif
uniform FOUR_NUMBERS factor[GROUPS]; // sign 2^(shift + e), of floats / divisor; without dot4 only x
uniform ONE_NUMBER bias;             // with EXACT integers in 1 / DIVISOR
uniform ONE_NUMBER change_sign;      // of what a target that is read changes by
#if READS_TARGET
uniform sampler2D target;
#endif
#if LOGARITHMS
uniform usamplerBuffer log_table;
#endif

// A result per channel; texels of the source have that or, with dot4, four samples.
#if CHANNELS == 4
#define NUMBERS FOUR_NUMBERS
#define REAL vec4
#define SWIZZLE rgba
out vec4 value;
#else
#define NUMBERS ONE_NUMBER
#define REAL float
#define SWIZZLE r
out float value;
#endif
#if CHANNELS == 4 || DOT4
#define SOURCE FOUR_NUMBERS
#define SOURCE_SWIZZLE rgba
#else
#define SOURCE ONE_NUMBER
#define SOURCE_SWIZZLE r
#endif
#if DOT4
#define TILE FOUR_NUMBERS
#define TILE_SWIZZLE rgba
#else
#define TILE ONE_NUMBER
#define TILE_SWIZZLE r
#endif

int tile_texel(int group, uint position)
{
#if LINEAR
    return tile_base[group] + int(position);
#else
    const uint mask = (1u << POSITION_BITS) - 1u;
    int at = tile_base[group] + int(position & mask) * tile_step[group].x;
#if DIMS > 1
    at += int((position >> POSITION_BITS) & mask) * tile_step[group].y;
#endif
#if DIMS > 2
    at += int(position >> (2 * POSITION_BITS)) * tile_step[group].z;
#endif
    return at;
#endif
}

#if !FLOATS
// To the nearest, halves away from zero.
int divided(int x)
{
    int magnitude = int((uint(abs(x)) + uint(DIVISOR) / 2u) / uint(DIVISOR));
    return x < 0 ? -magnitude : magnitude;
}
ivec4 divided(ivec4 x)
{
    ivec4 magnitude = ivec4((uvec4(abs(x)) + uint(DIVISOR) / 2u) / uint(DIVISOR));
    return magnitude * (1 - 2 * ivec4(lessThan(x, ivec4(0))));
}
#endif

#if LOGARITHMS
int product(int s, int q)
{
    return s == ONE || q == ONE ? 0 : int(texelFetch(log_table, s + q).r);
}
#if CHANNELS == 4 || DOT4
ivec4 product(ivec4 s, ivec4 q)
{
    return ivec4(product(s.x, q.x), product(s.y, q.y), product(s.z, q.z), product(s.w, q.w));
}
ivec4 product(ivec4 s, int q)
{
    return product(s, ivec4(q));
}
#endif
#else
#define product(s, q) ((s) * (q))
#endif

#if FLOATS || EXACT || LOGARITHMS
#define ROUNDED(x) (x)
#else
#define ROUNDED(x) divided(x)
#endif

NUMBERS saturated(NUMBERS x)
{
#ifdef LIMIT
    return clamp(x, NUMBERS(-LIMIT), NUMBERS(LIMIT));
#else
    return x;
#endif
}

// Sums go from the first component on, floats too.
NUMBERS add_group(NUMBERS sum, int group, uvec2 entry)
{
    SOURCE s = SOURCE(texelFetch(source, int(entry.x) + source_offset[group]).SOURCE_SWIZZLE);
    TILE q = TILE(texelFetch(tiles, tile_texel(group, entry.y)).TILE_SWIZZLE);
#if DOT4
    FOUR_NUMBERS p = ROUNDED(product(s, q) * factor[group]);
    sum = sum + p.x;
    sum = sum + p.y;
    sum = sum + p.z;
#if SPLIT_DOT
    sum = saturated(sum);
#endif
    sum = sum + p.w;
#else
    sum = sum + ROUNDED(product(s, q) * factor[group].x);
#endif
    return saturated(sum);
}

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uvec2 entry = texelFetch(entries, pixel.y * row_entries + pixel.x).rg;
    NUMBERS n = NUMBERS(bias);
    for (int g = 0; g < GROUPS; g++)
        n = add_group(n, g, entry);
#if FLOATS
#if READS_TARGET
    n = texelFetch(target, pixel, 0).SWIZZLE + change_sign * n;
#endif
    value = n;
#else
#if EXACT && !LOGARITHMS
    n = divided(n);
#endif
#if PART == 2
    n = (n_sign * n) & ((1 << EXTRA_BITS) - 1);
#else
    n = (n + rounds) >> EXTRA_BITS;
#endif
#if READS_TARGET
    NUMBERS y = NUMBERS(texelFetch(target, pixel, 0).SWIZZLE * float(ONE) + 0.5);
    n = clamp(y + change_sign * n, NUMBERS(0), NUMBERS(ONE));
#endif
    value = REAL(n) / float(ONE); // a code: nothing is left to round
#endif
}
