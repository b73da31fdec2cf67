// Fragment shader: a frame's texel for the blending unit (passes/accumulate/blend_target.h).
// Defined: RANGE (1: the place in a range), WEIGHT (1: times a weight).
uniform sampler2D frame;
#if RANGE
uniform float low, scale;
#endif
#if WEIGHT
uniform float weight;
#endif
out vec4 value;

void main()
{
    vec4 v = texelFetch(frame, ivec2(gl_FragCoord.xy), 0);
#if RANGE
    v = (v - low) * scale;
#endif
#if WEIGHT
    v = v * weight;
#endif
    value = v;
}
