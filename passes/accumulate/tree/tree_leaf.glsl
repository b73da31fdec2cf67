// Fragment shader: a frame becomes the image of a leaf, as struct weft_tree_images_params has it.
// Defined: SOURCE (the largest code of the frame; 0: it is of floats), ONE (likewise of the image),
// RANGED, COPY (1: texels are what they are).
out vec4 value;

uniform sampler2D frame;
uniform float unit; // 1 / SOURCE, to nearest
uniform float low, scale;

void main()
{
    value = texelFetch(frame, ivec2(gl_FragCoord.xy), 0);
#if !COPY
#if SOURCE
    // GL's own quotient may be any of those near.
    value = floor(value * float(SOURCE) + 0.5) * unit;
#endif
#if RANGED
    value = (value - low) * scale;
#endif
#if ONE
    value = clamp(floor(value * float(ONE) + 0.5), 0.0, float(ONE)) / float(ONE);
#endif
#endif
}
