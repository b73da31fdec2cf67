// Fragment shader: a pixel of a warp, all channels in one texel.
// Defined by the plan: WIDTH (taps along an axis), GROUPS (of four taps), DEGREE and SEGMENTS of the
// kernel's polynomial tiles, STRETCHED (1: weights come with the pixels, and WIDTH is not used),
// STRIDE (stretched: weights of a pixel, at most), BOUNDARY (0 clamp, 1 mirror, 2 wrap, 3 border),
// SKIPS_ZEROS (1: samples may be NaN or infinite, which taps of weight 0 must not spread).

uniform samplerBuffer entries; // per pixel: first tap along x and y; fractions, or counts of taps
uniform samplerBuffer source;  // the samples of an area, all channels of one in a texel
uniform ivec4 area;            // its first column and row, and its columns
uniform ivec2 size;            // of all samples
uniform vec4 border;
uniform int row_entries;

out vec4 value;

#if STRETCHED
uniform samplerBuffer weights; // [pixel][STRIDE]: along x, then along y
#else
#include "passes/gl/kernel_weights.glsl"
#endif

// The sample at an index along an axis; -1: the border's value.
int bound(int i, int n)
{
#if BOUNDARY == 0
    return clamp(i, 0, n - 1);
#elif BOUNDARY == 1
    int period = max(2 * (n - 1), 1);
    int at = i % period;
    at = at < 0 ? at + period : at;
    return at < n ? at : period - at;
#elif BOUNDARY == 2
    int at = i % n;
    return at < 0 ? at + n : at;
#else
    return i < 0 || i >= n ? -1 : i;
#endif
}

vec4 fetch(int x, int y)
{
#if BOUNDARY == 3
    if (x < 0 || y < 0)
        return border;
#endif
    return texelFetch(source, (y - area.y) * area.z + (x - area.x));
}

#if SKIPS_ZEROS
#define COUNTS(weight) ((weight) != 0.0)
#else
#define COUNTS(weight) true
#endif

void main()
{
    ivec2 window = ivec2(gl_FragCoord.xy);
    int number = window.y * row_entries + window.x;
    vec4 entry = texelFetch(entries, number);
    ivec2 first = ivec2(entry.xy);
    vec4 sum = vec4(0.0);
#if STRETCHED
    ivec2 count = ivec2(entry.zw);
    int at = number * STRIDE;
    for (int j = 0; j < count.y; j++) {
        float wy = texelFetch(weights, at + count.x + j).r;
        if (!COUNTS(wy))
            continue;
        int y = bound(first.y + j, size.y);
        vec4 along = vec4(0.0);
        for (int i = 0; i < count.x; i++) {
            float wx = texelFetch(weights, at + i).r;
            if (COUNTS(wx))
                along += wx * fetch(bound(first.x + i, size.x), y);
        }
        sum += wy * along;
    }
#else
    float wx[4 * GROUPS], wy[4 * GROUPS];
    kernel_weights(entry.z, wx);
    kernel_weights(entry.w, wy);
    int column[WIDTH];
    for (int i = 0; i < WIDTH; i++)
        column[i] = bound(first.x + i, size.x);
    for (int j = 0; j < WIDTH; j++) {
        if (!COUNTS(wy[j]))
            continue;
        int y = bound(first.y + j, size.y);
        vec4 along = vec4(0.0);
        for (int i = 0; i < WIDTH; i++)
            if (COUNTS(wx[i]))
                along += wx[i] * fetch(column[i], y);
        sum += wy[j] * along;
    }
#endif
    value = sum;
}
