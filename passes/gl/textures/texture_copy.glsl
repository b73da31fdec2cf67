// Fragment shader: texels that a pass has drawn, as pixels of another texture. Defined: PACKED, a
// texel is four pixels of a row; MAPS, values become others.

uniform sampler2D source;
uniform ivec2 offset; // from a pixel of the viewport to one of the source
uniform int first;    // the channel that takes the source's first one; negative: one before
uniform vec3 mapping; // offset, scale, divisor

out vec4 value;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy) + offset;
#if PACKED
    vec4 found = vec4(texelFetch(source, ivec2(at.x >> 2, at.y), 0)[at.x & 3]);
#else
    vec4 found = texelFetch(source, at, 0);
#endif
#if MAPS
    found = mapping.x + found * mapping.y / mapping.z;
#endif
    for (int c = 0; c < 4; c++)
        value[c] = found[(c - first) & 3];
}
