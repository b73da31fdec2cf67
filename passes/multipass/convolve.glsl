// Fragment shader: adds one sum of products to a target, in the arithmetic of passes/pass.h.
// Defined: FLOATS (1: half and float targets), ONE (T), EXTRA_BITS (e), DIVISOR, GROUPS, DOT4,
// SPLIT_DOT (1: R, G, B and A apart), FACTORS (4: one per component of a group), CHANNELS, DIMS,
// PART (0 whole, 1 high, 2 low), SUBTRACT, READS_TARGET (1: from a texture, 2: what is in the pixel,
// by GL_EXT_shader_framebuffer_fetch), EXACT, LIMIT (of sums, if there is one), HAS_BIAS,
// LOGARITHMS, POSITIONS (0: packed in POSITION_BITS per axis, 1: linear, 2: linear, some
// mirrored). What can be a define is: llvmpipe takes as long for a uniform as for a division.

uniform usamplerBuffer entries; // per pixel: source texel at the first tap, tile sample position
uniform int row_entries;
uniform int source_offset[GROUPS];
uniform int tile_base[GROUPS];
#if POSITIONS == 0
uniform ivec3 tile_step[GROUPS]; // along the tile sample position, negative where mirrored
#elif POSITIONS == 2
uniform int tile_flip[GROUPS]; // the position's bits that mirroring turns
#endif
uniform int divisor; // where DIVISOR is that and no number
#if FLOATS
#define ONE_NUMBER float
#define FOUR_NUMBERS vec4
uniform samplerBuffer source, tiles;
#else
#define ONE_NUMBER int
#define FOUR_NUMBERS ivec4
uniform usamplerBuffer source, tiles;
#endif
// Signs times 2^(shift + e), of floats / divisor. Turned where the pass subtracts, as the bias is.
#if FACTORS == 4
uniform FOUR_NUMBERS factor[GROUPS];
#else
uniform ONE_NUMBER factor[GROUPS];
#endif
#if HAS_BIAS
uniform ONE_NUMBER bias; // with EXACT integers in 1 / DIVISOR
#else
#define bias 0
#endif
#if READS_TARGET == 1
uniform sampler2D target;
#endif
#if LOGARITHMS
uniform usamplerBuffer log_table;
#endif

#if READS_TARGET == 2
#define OUT inout
#define TARGET value
#else
#define OUT out
#define TARGET texelFetch(target, pixel, 0).SWIZZLE
#endif

// A result per channel; texels of the source have that or, with dot4, four samples.
#if CHANNELS == 4
#define NUMBERS FOUR_NUMBERS
#define REAL vec4
#define SWIZZLE rgba
OUT vec4 value;
#else
#define NUMBERS ONE_NUMBER
#define REAL float
#define SWIZZLE r
OUT float value;
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
#if POSITIONS == 1
    return tile_base[group] + int(position);
#elif POSITIONS == 2
    return tile_base[group] + (int(position) ^ tile_flip[group]);
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

#if SUBTRACT && PART != 2
#define CHANGED_BY -
#else
#define CHANGED_BY +
#endif

#if !FLOATS
NUMBERS part(NUMBERS n)
{
    const int last = (1 << EXTRA_BITS) - 1;
#if PART == 2
    return (SUBTRACT != 0 ? -n : n) & last;
#elif PART == 1
    return (SUBTRACT != 0 ? n + last : n) >> EXTRA_BITS;
#else
    return (n + ((1 << EXTRA_BITS) >> 1)) >> EXTRA_BITS;
#endif
}
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
    sum = sum + ROUNDED(product(s, q) * factor[group]);
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
    n = TARGET CHANGED_BY n;
#endif
    value = n;
#else
#if EXACT && !LOGARITHMS
    n = divided(n);
#endif
    n = part(n);
#if READS_TARGET
    NUMBERS y = NUMBERS(TARGET * float(ONE) + 0.5);
    n = clamp(y CHANGED_BY n, NUMBERS(0), NUMBERS(ONE));
#endif
    value = REAL(n) / float(ONE); // a code: nothing is left to round
#endif
}
