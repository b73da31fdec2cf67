// Fragment shader: stores a weighted sum of targets, in the arithmetic of passes/pass.h.
// Defined: FLOATS (1: half and float targets), INPUTS (1 to 16), ONE (T), EXTRA_BITS (e), EXACT,
// DENOMINATOR, CHANNELS.

#if CHANNELS == 4
#define SWIZZLE rgba
out vec4 value;
#define REAL vec4
#define WHOLE ivec4
#else
#define SWIZZLE r
out float value;
#define REAL float
#define WHOLE int
#endif

uniform sampler2D targets[INPUTS];
#if FLOATS
uniform float factor[INPUTS]; // numerator / denominator
uniform float bias;
#else
uniform int factor[INPUTS]; // numerators; times 2^e unless EXACT
uniform int bias;           // and half a denominator
#endif

#if !FLOATS
// To the nearest, halves away from zero.
WHOLE divided(WHOLE x)
{
    const int half_of_it = DENOMINATOR / 2;
    return sign(x) * ((abs(x) + half_of_it) / DENOMINATOR);
}
#endif

ivec2 pixel;

#if FLOATS
#define ADD(sum, i) sum = sum + texelFetch(targets[i], pixel, 0).SWIZZLE * factor[i]
#else
#define CODE(i) WHOLE(texelFetch(targets[i], pixel, 0).SWIZZLE * float(ONE) + 0.5)
#if EXACT
#define ADD(sum, i) sum += CODE(i) * factor[i]
#else
#define ADD(sum, i) sum += divided(CODE(i) * factor[i])
#endif
#endif

void main()
{
    pixel = ivec2(gl_FragCoord.xy);
#if FLOATS
    REAL sum = REAL(bias);
#else
    WHOLE sum = WHOLE(bias);
#endif
    // GLSL 3.30 wants constants for indices of samplers.
    ADD(sum, 0);
#if INPUTS > 1
    ADD(sum, 1);
#endif
#if INPUTS > 2
    ADD(sum, 2);
#endif
#if INPUTS > 3
    ADD(sum, 3);
#endif
#if INPUTS > 4
    ADD(sum, 4);
#endif
#if INPUTS > 5
    ADD(sum, 5);
#endif
#if INPUTS > 6
    ADD(sum, 6);
#endif
#if INPUTS > 7
    ADD(sum, 7);
#endif
#if INPUTS > 8
    ADD(sum, 8);
#endif
#if INPUTS > 9
    ADD(sum, 9);
#endif
#if INPUTS > 10
    ADD(sum, 10);
#endif
#if INPUTS > 11
    ADD(sum, 11);
#endif
#if INPUTS > 12
    ADD(sum, 12);
#endif
#if INPUTS > 13
    ADD(sum, 13);
#endif
#if INPUTS > 14
    ADD(sum, 14);
#endif
#if INPUTS > 15
    ADD(sum, 15);
#endif
#if FLOATS
    value = sum;
#else
    // What is below 0 clamps, so that its quotient need not be floored.
    sum = max(sum, WHOLE(0)) / (EXACT != 0 ? DENOMINATOR : 1 << EXTRA_BITS);
    value = REAL(min(sum, WHOLE(ONE))) / float(ONE);
#endif
}
