// Fragment shader: what the sampler returns for one tile, at a grid of resampling positions.
// Defined: DIMS. Pixel (x, y) is position (x, y % locations, y / locations) + 1/2 over locations.

#if DIMS == 1
uniform sampler1D tile;
#elif DIMS == 2
uniform sampler2D tile;
#else
uniform sampler3D tile;
#endif
uniform int locations;
uniform vec2 placement; // gain and bias from tile positions to texture coordinates
uniform bvec3 mirrored;

out float value;

void main()
{
    ivec2 p = ivec2(gl_FragCoord.xy);
    ivec3 i = ivec3(p.x, p.y % locations, p.y / locations);
    vec3 s = (vec3(i) + 0.5) / float(locations);
    s = s * placement.x + placement.y;
    s = mix(s, 1.0 - s, mirrored);
#if DIMS == 1
    value = texture(tile, s.x).r;
#elif DIMS == 2
    value = texture(tile, s.xy).r;
#else
    value = texture(tile, s).r;
#endif
}
