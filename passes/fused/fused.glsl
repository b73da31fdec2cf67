// Fragment shader: one tri-variate reconstruction per pixel.
// Defined by the plan: WIDTH (taps along an axis), FIRST (samples from the first one in reach to
// the first tap), SKIP (of these, those fetched with interleaved rows), SUMMED (1 if blocks have no
// third axis), GROUPS (of four taps), DEGREE and SEGMENTS of the kernel's polynomial tiles,
// CONSTANTS (1 if entries may name constants), CONSTANTS_ONLY, MAPPED (1 if samples are mapped from
// their range), UNIT_SUM (1 if weights add up to one), one of LAYOUT_INTERLEAVED, LAYOUT_ALIGNED,
// LAYOUT_PLAIN, and, for pixels clamped to the samples next to them, CLAMP_FROM and CLAMP_TO, the
// taps of those. Axes are the block's: x along its rows.
// Of several outputs: TARGETS (of four each), DEGREE_n and SEGMENTS_n of derived tiles of order n,
// and lists of macros' arguments, each thing once (passes/fused/outputs.c): EACH_WEIGHTS (function,
// fraction, weights of an order along an axis), EACH_SHIFT (weights along x, the same for aligned
// rows), EACH_ROW (sum over a row, its weights), EACH_PLANE (sum over rows, that of each row,
// weights along y), EACH_SUM (output, its plane's sum, its weights along x, y and z, whether it is
// the value), STORE_SUMS and STORE_CONSTANTS. Constants are pairs, of a value and its derivatives.

uniform isamplerBuffer entries; // per pixel: >= 0 a block's start, else ~(texel of a constant)
uniform samplerBuffer constants;
uniform samplerBuffer source;
uniform vec2 mapping;           // scale and offset of samples
uniform ivec2 pitch;            // texels from row to row and from slice to slice of a block

uniform ivec2 block;  // window coordinates of the block's first pixel (may lie outside)
uniform int row_entries;

#if defined(TARGETS)
out vec4 value[TARGETS];
#else
out float value;
#endif

#include "passes/gl/kernel_weights.glsl"
#if defined(DEGREE_1)
#undef DEGREE
#undef SEGMENTS
#define DEGREE DEGREE_1
#define SEGMENTS SEGMENTS_1
#define kernel kernel_1
#define kernel_weights kernel_weights_1
#include "passes/gl/kernel_weights.glsl"
#undef kernel
#undef kernel_weights
#endif
#if defined(DEGREE_2)
#undef DEGREE
#undef SEGMENTS
#define DEGREE DEGREE_2
#define SEGMENTS SEGMENTS_2
#define kernel kernel_2
#define kernel_weights kernel_weights_2
#include "passes/gl/kernel_weights.glsl"
#undef kernel
#undef kernel_weights
#endif
#include "passes/positions/grid_uniforms.glsl"

const int DEPTH = SUMMED != 0 ? 1 : WIDTH;
const int ROW_FETCHES = (WIDTH + 3 + 3) / 4; // aligned rows

#if defined(LAYOUT_ALIGNED)
// Weights moved up by `shift` (0 to 3) places, zeros around.
void shift_weights(float weight[4 * GROUPS], int shift, out float shifted[4 * ROW_FETCHES])
{
    for (int i = 0; i < 4 * ROW_FETCHES; i++)
        shifted[i] = i < WIDTH ? weight[min(i, WIDTH - 1)] : 0.0;
    bool one = (shift & 1) != 0, two = (shift & 2) != 0;
    for (int i = 4 * ROW_FETCHES - 1; i >= 0; i--)
        shifted[i] = one ? (i >= 1 ? shifted[max(i - 1, 0)] : 0.0) : shifted[i];
    for (int i = 4 * ROW_FETCHES - 1; i >= 0; i--)
        shifted[i] = two ? (i >= 2 ? shifted[max(i - 2, 0)] : 0.0) : shifted[i];
}
#define ROW_WEIGHTS (4 * ROW_FETCHES)
#else
#define ROW_WEIGHTS (4 * GROUPS)
#endif

float row(int at, float weight[ROW_WEIGHTS])
{
    float sum = 0.0;
#if defined(LAYOUT_PLAIN)
    for (int i = 0; i < WIDTH; i++)
        sum += texelFetch(source, at + i).r * weight[i];
#elif defined(LAYOUT_ALIGNED)
    for (int f = 0; f < ROW_FETCHES; f++) {
        vec4 s = texelFetch(source, at + f);
        sum += (s.x * weight[4 * f] + s.y * weight[4 * f + 1]) +
               (s.z * weight[4 * f + 2] + s.w * weight[4 * f + 3]);
    }
#else
    // Samples past the last tap are not touched: a NaN there must not get in.
    for (int g = 0; g < (SKIP + WIDTH + 3) / 4; g++) {
        vec4 s = texelFetch(source, at + 4 * g - SKIP);
        for (int i = 0; i < 4; i++)
            if (4 * g + i >= SKIP && 4 * g + i < SKIP + WIDTH)
                sum += s[i] * weight[4 * g + i - SKIP];
    }
#endif
    return sum;
}

#if defined(CLAMP_FROM)
// The sample of one tap, of a row whose first tap's sample is number `start` of the block's row.
float sample_at(int at, int start, ivec3 tap)
{
    at += tap.z * pitch.y + tap.y * pitch.x;
#if defined(LAYOUT_ALIGNED)
    int x = (start & 3) + tap.x;
    return texelFetch(source, at + (x >> 2))[x & 3];
#elif defined(LAYOUT_PLAIN)
    return texelFetch(source, at + tap.x).r;
#else
    int x = tap.x + SKIP;
    return texelFetch(source, at - SKIP + (x & ~3))[x & 3];
#endif
}
#endif

#if MAPPED && !UNIT_SUM
float total(float weight[4 * GROUPS])
{
    float sum = 0.0;
    for (int i = 0; i < WIDTH; i++)
        sum += weight[i];
    return sum;
}
#endif

#if defined(TARGETS)
#if defined(LAYOUT_ALIGNED)
#define ROW_WEIGHTS_0 shifted0
#define ROW_WEIGHTS_1 shifted1
#define ROW_WEIGHTS_2 shifted2
#else
#define ROW_WEIGHTS_0 x0
#define ROW_WEIGHTS_1 x1
#define ROW_WEIGHTS_2 x2
#endif
#define MAKE_WEIGHTS(function, fraction, own) float own[4 * GROUPS]; function(fraction, own);
#define MAKE_SHIFTED(own, to) float to[ROW_WEIGHTS]; shift_weights(own, start.x & 3, to);
#define CLEAR_ROW(sum, own) float sum = 0.0;
#define CLEAR_PLANE(sum, of, own) float sum = 0.0;
#define CLEAR_SUM(sum, of, wx, wy, wz, one) float sum = 0.0;
#define ADD_SAMPLE(sum, own) sum += s * own[i];
#define ADD_TEXEL(sum, own) sum += (s.x * own[4 * f] + s.y * own[4 * f + 1]) + \
                                   (s.z * own[4 * f + 2] + s.w * own[4 * f + 3]);
#define ADD_ROW(sum, of, own) sum += own[j] * of;
#define ADD_PLANE(sum, of, wx, wy, wz, one) sum += wz[k] * of;
#define MAP_UNIT(sum, of, wx, wy, wz, one) sum = sum * mapping.x + mapping.y * one;
#define MAP_TOTAL(sum, of, wx, wy, wz, one) \
    sum = sum * mapping.x + mapping.y * (total(wx) * total(wy) * total(wz));

// All outputs of a pixel whose first tap's texel is `at`.
void make_outputs(int at, ivec3 start, vec3 t)
{
    EACH_WEIGHTS(MAKE_WEIGHTS)
#if defined(LAYOUT_ALIGNED)
    EACH_SHIFT(MAKE_SHIFTED)
#endif
    EACH_SUM(CLEAR_SUM)
    for (int k = 0; k < WIDTH; k++) {
        EACH_PLANE(CLEAR_PLANE)
        for (int j = 0; j < WIDTH; j++) {
            int row = at + k * pitch.y + j * pitch.x;
            EACH_ROW(CLEAR_ROW)
#if defined(LAYOUT_PLAIN)
            for (int i = 0; i < WIDTH; i++) {
                float s = texelFetch(source, row + i).r;
                EACH_ROW(ADD_SAMPLE)
            }
#elif defined(LAYOUT_ALIGNED)
            for (int f = 0; f < ROW_FETCHES; f++) {
                vec4 s = texelFetch(source, row + f);
                EACH_ROW(ADD_TEXEL)
            }
#else
            for (int g = 0; g < (SKIP + WIDTH + 3) / 4; g++) {
                vec4 texel = texelFetch(source, row + 4 * g - SKIP);
                for (int c = 0; c < 4; c++) {
                    int i = 4 * g + c - SKIP;
                    float s = texel[c];
                    if (i >= 0 && i < WIDTH) {
                        EACH_ROW(ADD_SAMPLE)
                    }
                }
            }
#endif
            EACH_PLANE(ADD_ROW)
        }
        EACH_SUM(ADD_PLANE)
    }
#if MAPPED && UNIT_SUM
    EACH_SUM(MAP_UNIT)
#elif MAPPED
    EACH_SUM(MAP_TOTAL)
#endif
    STORE_SUMS
}
#endif

void main()
{
    ivec2 window = ivec2(gl_FragCoord.xy);
    int entry = texelFetch(entries, window.y * row_entries + window.x).r;
#if CONSTANTS
    if (entry < 0) {
#if defined(TARGETS)
        float c = texelFetch(constants, 2 * ~entry).r, d = texelFetch(constants, 2 * ~entry + 1).r;
        STORE_CONSTANTS
#else
        value = texelFetch(constants, ~entry).r;
#endif
        return;
    }
#endif
#if CONSTANTS_ONLY && defined(TARGETS)
    for (int i = 0; i < TARGETS; i++)
        value[i] = vec4(0.0);
}
#elif CONSTANTS_ONLY
    value = 0.0;
}
#else

    ivec3 start;
    vec3 t;
    grid_position(window - block, start, t);
    start += FIRST;
#if defined(TARGETS)
    int texel = start.x;
#if defined(LAYOUT_ALIGNED)
    texel >>= 2;
#endif
    make_outputs(entry + start.z * pitch.y + start.y * pitch.x + texel, start, t);
}
#else

    float wx[4 * GROUPS], wy[4 * GROUPS], wz[4 * GROUPS];
    kernel_weights(t.x, wx);
    kernel_weights(t.y, wy);
#if !SUMMED
    kernel_weights(t.z, wz);
#else
    start.z = 0;
    wz[0] = 1.0;
#endif

#if defined(LAYOUT_ALIGNED)
    float row_weights[ROW_WEIGHTS];
    shift_weights(wx, start.x & 3, row_weights);
    int at = entry + start.z * pitch.y + start.y * pitch.x + (start.x >> 2);
#else
#define row_weights wx
    int at = entry + start.z * pitch.y + start.y * pitch.x + start.x;
#endif
    float sum = 0.0;
    for (int z = 0; z < DEPTH; z++) {
        float plane = 0.0;
        for (int y = 0; y < WIDTH; y++)
            plane += wy[y] * row(at + z * pitch.y + y * pitch.x, row_weights);
        sum += wz[z] * plane;
    }
#if MAPPED && UNIT_SUM
    sum = sum * mapping.x + mapping.y;
#elif MAPPED
    sum = sum * mapping.x + mapping.y * (total(wx) * total(wy) * (SUMMED != 0 ? 1.0 : total(wz)));
#endif
#if defined(CLAMP_FROM)
    // Comparisons with NaN are false: it stays.
    float least = sample_at(at, start.x, ivec3(CLAMP_FROM)), most = least;
    for (int z = CLAMP_FROM; z <= CLAMP_TO; z++)
        for (int y = CLAMP_FROM; y <= CLAMP_TO; y++)
            for (int x = CLAMP_FROM; x <= CLAMP_TO; x++) {
                float s = sample_at(at, start.x, ivec3(x, y, z));
                least = s < least ? s : least;
                most = s > most ? s : most;
            }
#if MAPPED
    least = least * mapping.x + mapping.y;
    most = most * mapping.x + mapping.y;
#endif
    sum = sum < least ? least : sum > most ? most : sum;
#endif
    value = sum;
}
#endif
#endif
