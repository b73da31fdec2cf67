// Fragment shader: marks pixels that two surfaces may intersect in, and writes as depth how far back
// an edge may lie that marks its pixel. marks.c says why.
out float marked;

uniform usampler2D surfaces; // number, and slope of depth as the bits of a float
uniform sampler2D depths;
uniform bool complete;
uniform int rim; // pixels around the picture, which are nobody's

// Of depths, which are rounded to 24 bits, and of their interpolation.
const float ROUNDINGS = 1.0 / 4194304.0;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy) - rim, last = textureSize(surfaces, 0) - 1;
    uvec2 own = texelFetch(surfaces, at, 0).xy;
    float depth = texelFetch(depths, at, 0).x, slope = uintBitsToFloat(own.y), steepest = 0.0;
    bool intersects = false;
    for (int y = -1; y <= 1; y++)
        for (int x = -1; x <= 1; x++) {
            ivec2 p = clamp(at + ivec2(x, y), ivec2(0), last);
            uvec2 other = texelFetch(surfaces, p, 0).xy;
            bool behind = texelFetch(depths, p, 0).x > depth + slope + ROUNDINGS;
            intersects = intersects || (abs(x) + abs(y) == 1 && other.x != own.x && !behind);
            steepest = max(steepest, uintBitsToFloat(other.y));
        }
    bool at_rim = any(equal(at, ivec2(0))) || any(equal(at, last));
    bool outside = any(lessThan(at, ivec2(0))) || any(greaterThan(at, last));
    marked = !outside && own.x != 0u && (intersects || complete && at_rim) ? 1.0 : 0.0;
    float limit = depth + 0.5 * slope + ROUNDINGS + (complete ? 1.5 * steepest : 0.0);
    gl_FragDepth = marked > 0.0 || outside ? 0.0 : min(limit, 1.0);
}
