// Fragment shader: one tri-variate reconstruction per pixel, by fetches that the sampler filters.
// Defined by the plan: WIDTH (taps along an axis), GROUPS (of four taps), DEGREE and SEGMENTS of
// the kernel's polynomial tiles, FETCHES along an axis, FIRST_TAPS and SECOND_TAPS of each (WIDTH:
// none), SIDE (texels from block to block), MAPPED (1 if samples are mapped from their range),
// UNIT_SUM (1 if weights add up to one).

uniform isamplerBuffer entries; // per pixel: the block's number along each axis, 10 bits each
uniform sampler3D source;
uniform vec3 texel;             // 1 / size: a power of two
uniform vec2 mapping;           // scale and offset of samples
uniform ivec2 block;            // window coordinates of the block's first pixel (may lie outside)
uniform int row_entries;

out float value;

#include "passes/gl/kernel_weights.glsl"
#include "passes/positions/grid_uniforms.glsl"

const int first_tap[FETCHES] = int[FETCHES](FIRST_TAPS);
const int second_tap[FETCHES] = int[FETCHES](SECOND_TAPS);

// Weights and coordinates of the fetches along an axis. Weights that add up to 0 are both 0, but
// for roundings. Places between two texels are rounded to 2^-15, so that coordinates are exact
// wherever in the texture a block lies.
void pair(float t, float first, float size, out float weight[FETCHES], out float at[FETCHES])
{
    float taps[4 * GROUPS];
    kernel_weights(t, taps);
    for (int f = 0; f < FETCHES; f++) {
        float place = first + float(first_tap[f]);
        weight[f] = taps[first_tap[f]];
        if (second_tap[f] < WIDTH) {
            float second = taps[min(second_tap[f], WIDTH - 1)], both = weight[f] + second;
            float between = both != 0.0 ? clamp(second / both, 0.0, 1.0) : 0.0;
            place += floor(between * 32768.0 + 0.5) * (1.0 / 32768.0);
            weight[f] = both;
        }
        at[f] = place * size;
    }
}

void main()
{
    ivec2 window = ivec2(gl_FragCoord.xy);
    int entry = texelFetch(entries, window.y * row_entries + window.x).r;
    ivec3 start;
    vec3 t;
    grid_position(window - block, start, t);
    ivec3 at = ivec3(entry & 1023, entry >> 10 & 1023, entry >> 20 & 1023) * SIDE + start;
    vec3 centre = vec3(at) + 0.5; // of the first tap

    float wx[FETCHES], wy[FETCHES], wz[FETCHES], x[FETCHES], y[FETCHES], z[FETCHES];
    pair(t.x, centre.x, texel.x, wx, x);
    pair(t.y, centre.y, texel.y, wy, y);
    pair(t.z, centre.z, texel.z, wz, z);
    float sum = 0.0;
    for (int k = 0; k < FETCHES; k++) {
        float plane = 0.0;
        for (int j = 0; j < FETCHES; j++) {
            float row = 0.0;
            for (int i = 0; i < FETCHES; i++)
                row += wx[i] * textureLod(source, vec3(x[i], y[j], z[k]), 0.0).r;
            plane += wy[j] * row;
        }
        sum += wz[k] * plane;
    }
#if MAPPED
    float total = 1.0;
#if !UNIT_SUM
    float total_x = 0.0, total_y = 0.0, total_z = 0.0;
    for (int f = 0; f < FETCHES; f++) {
        total_x += wx[f];
        total_y += wy[f];
        total_z += wz[f];
    }
    total = total_x * total_y * total_z;
#endif
    sum = sum * mapping.x + mapping.y * total;
#endif
    value = sum;
}
