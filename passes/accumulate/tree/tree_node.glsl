// Fragment shader: a node of an accumulation tree, as struct weft_tree_node has it.
// Defined: INPUTS (2 to 16), ONE (the largest code; 0: floats), SMALL (1: the denominator times
// (ONE + 1) is at most 2^18).
out vec4 value;

uniform sampler2D inputs[INPUTS];
uniform float inverse; // 1 / denominator, to nearest
#if ONE && !SMALL
uniform uint factor[INPUTS], denominator, add;
#define SUM uvec4
#define TERM(i) uvec4(texelFetch(inputs[i], pixel, 0) * float(ONE) + 0.5) * factor[i]
#else
uniform float factor[INPUTS], add; // of codes: numerator * ONE
#define SUM vec4
#define TERM(i) texelFetch(inputs[i], pixel, 0) * factor[i]
#endif

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    SUM sum = TERM(0);
    // GLSL 3.30 wants constants for indices of samplers.
    sum += TERM(1);
#if INPUTS > 2
    sum += TERM(2);
#endif
#if INPUTS > 3
    sum += TERM(3);
#endif
#if INPUTS > 4
    sum += TERM(4);
#endif
#if INPUTS > 5
    sum += TERM(5);
#endif
#if INPUTS > 6
    sum += TERM(6);
#endif
#if INPUTS > 7
    sum += TERM(7);
#endif
#if INPUTS > 8
    sum += TERM(8);
#endif
#if INPUTS > 9
    sum += TERM(9);
#endif
#if INPUTS > 10
    sum += TERM(10);
#endif
#if INPUTS > 11
    sum += TERM(11);
#endif
#if INPUTS > 12
    sum += TERM(12);
#endif
#if INPUTS > 13
    sum += TERM(13);
#endif
#if INPUTS > 14
    sum += TERM(14);
#endif
#if INPUTS > 15
    sum += TERM(15);
#endif
#if ONE && !SMALL
    // floor((sum + add) / denominator) without a division, which has no vector instruction. Sums
    // are below 2^32, quotients at most ONE < 2^16: converting, 1 / denominator and the product
    // are within 2^-23 each, so that the quotient is within 1 of the right one. The remainder
    // tells: modulo 2^32 a negative one is large.
    sum += uvec4(add);
    uvec4 quotient = uvec4(vec4(sum) * inverse);
    uvec4 rest = sum - quotient * denominator;
    uvec4 above = uvec4(greaterThan(rest, uvec4(0x7fffffffu)));
    quotient -= above;
    rest += above * denominator;
    quotient += uvec4(greaterThanEqual(rest, uvec4(denominator)));
    value = vec4(quotient) / float(ONE);
#elif ONE
    // The same in floats, u = 2^-24: texels are within 4 u of code / ONE, products round once and
    // sums at most 16 times, so that the sum is off by less than 22 u denominator ONE, which is at
    // most 0.35. The exact one, as `add` has 1/2 more, is no nearer than 1/2 to multiples of the
    // denominator, between which the quotient's floor is the same. Its own roundings take 2 u
    // (ONE + 1), less than 0.04 / denominator.
    value = floor((sum + add) * inverse) / float(ONE);
#else
    value = sum;
#endif
}
