// Fragment shader: pixels of a list, filtered from the samples around them
// (passes/antialias/supersample_gather.c). Defined: LISTED (else all pixels, in order), BLOCKS
// (samples are read from a layer of blocks, through pointers, else from the scratch target),
// COLUMNS of the filter's window (0: samples are copied) and LARGEST, how many pixels one has at most.
// Whatever the list and the store, products and sums are the same ones in the same order.
#ifdef GL_ARB_gpu_shader5
#define ROUNDED precise // no products and sums are rounded as one
#else
#define ROUNDED
#endif
#if LISTED
uniform usampler2D list; // places in the scratch target
#endif
#if BLOCKS
uniform sampler2DArray blocks;
uniform usampler2D pointers; // of the window's pixels: where they are in a layer
uniform ivec2 window;        // pixel of the scratch target that it begins with
uniform int layer;
#else
uniform sampler2D scratch;
#endif
#if !LISTED
uniform ivec2 corner; // pixel of the scratch target that is the first one
#endif
#if COLUMNS > 0
uniform ivec2 first; // pixel of the filter's window, from the one that is filtered
uniform int rows;
uniform float weight[LARGEST];
#endif
out vec4 value;

vec4 fetch(ivec2 at)
{
#if BLOCKS
    return texelFetch(blocks, ivec3(texelFetch(pointers, at - window, 0).xy, layer), 0);
#else
    return texelFetch(scratch, at, 0);
#endif
}

void main()
{
#if LISTED
    ivec2 at = ivec2(texelFetch(list, ivec2(gl_FragCoord.xy), 0).xy);
#else
    ivec2 at = ivec2(gl_FragCoord.xy) + corner;
#endif
#if COLUMNS > 0
    ROUNDED vec4 sum = vec4(0.0);
    for (int y = 0; y < rows; y++)
        for (int x = 0; x < COLUMNS; x++)
            sum = sum + weight[y * COLUMNS + x] * fetch(at + first + ivec2(x, y));
    value = sum;
#else
    value = fetch(at);
#endif
}
