// Fragment shader: leaves the pixels of a mask, for a pass that writes the stencil
// (passes/antialias/supersample_scratch.c).
uniform sampler2D mask;
uniform ivec2 first; // pixel of the target that the mask begins with

void main()
{
    if (texelFetch(mask, ivec2(gl_FragCoord.xy) - first, 0).r == 0.0)
        discard;
}
