// Fragment shader: a slice as one writes it first, to be beaten (passes/stability.h).
// Defined: LOOKUP (0 Catmull-Rom, 1 linear in a row of four, 2 sampler, 3 sampler from corner to
// corner), NORMALISED (1: positions by way of a texture coordinate of the whole picture).

uniform sampler3D source;
uniform vec3 origin, du, dv; // index space
uniform vec3 first;          // index coordinates of texel (0, 0, 0)
uniform vec2 shown;          // pixels of the target

out float value;

vec4 weights(float t)
{
#if LOOKUP == 0
    return vec4(((-0.5 * t + 1.0) * t - 0.5) * t, (1.5 * t - 2.5) * t * t + 1.0,
                ((-1.5 * t + 2.0) * t + 0.5) * t, (0.5 * t - 0.5) * t * t);
#else
    return max(1.0 - abs(vec4(-1.0, 0.0, 1.0, 2.0) - t), 0.0); // the tent, in a row of four
#endif
}

void main()
{
    ivec3 size = textureSize(source, 0);
#if NORMALISED
    vec2 coordinate = gl_FragCoord.xy / shown;
    vec3 position = vec3(coordinate * vec2(size.xy) - 0.5, 0.0);
#else
    vec3 position = origin + gl_FragCoord.x * du + gl_FragCoord.y * dv;
#endif
#if LOOKUP == 2
    value = texture(source, (position - first + 0.5) / vec3(size)).r;
#elif LOOKUP == 3
    value = texture(source, (position - first) / vec3(size - 1)).r;
#else
    vec3 below = floor(position);
    vec4 wx = weights(position.x - below.x), wy = weights(position.y - below.y),
         wz = weights(position.z - below.z);
    ivec3 at = ivec3(below - first) - 1;
    value = 0.0;
    for (int z = 0; z < 4; z++)
        for (int y = 0; y < 4; y++)
            for (int x = 0; x < 4; x++)
                value += wx[x] * wy[y] * wz[z] *
                         texelFetch(source, clamp(at + ivec3(x, y, z), ivec3(0), size - 1), 0).r;
#endif
}
