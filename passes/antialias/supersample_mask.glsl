// Fragment shader: leaves the pixels of a mask, for a pass that writes the stencil
// (passes/antialias/supersample_scratch.c).
uniform sampler2D mask;

void main()
{
    if (texelFetch(mask, ivec2(gl_FragCoord.xy), 0).r == 0.0)
        discard;
}
