// Fragment shader: the sum of a pixel's samples as integers. Defines: SAMPLES.
#if SAMPLES == 1
uniform sampler2D colours;
#else
uniform sampler2DMS colours;
#endif
uniform float scale, range; // integers for each unit of colour; the largest |component|
layout(location = 0) out ivec4 sum;

// What stands for colours that are beyond the range, and for some that are not finite: less than
// any sum.
const int beyond = -2147483647, no_number = -2147483647 - 1;

void main()
{
    sum = ivec4(0);
    for (int i = 0; i < SAMPLES; i++) {
        vec4 colour = texelFetch(colours, ivec2(gl_FragCoord.xy), SAMPLES == 1 ? 0 : i);
        if (any(isnan(colour)) || any(isinf(colour)))
            sum.x = no_number;
        else if (any(greaterThan(abs(colour), vec4(range))) && sum.x != no_number)
            sum.x = beyond;
        else if (sum.x > beyond)
            sum += ivec4(roundEven(colour * scale));
    }
}
