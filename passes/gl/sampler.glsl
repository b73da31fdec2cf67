// Fragment shader: what the sampler makes of points along an axis, a row each
// (passes/gl/sampler_rows.h). Defined: ROWS.

uniform sampler3D source;
uniform vec2 rows[ROWS];     // the first point and the step to the next, in texels
uniform vec3 along, across;  // a texel along the axis; half-way along the others

out float value;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec2 row = rows[at.y];
    value = textureLod(source, across + along * (row.x + float(at.x) * row.y), 0.0).r;
}
