// A kernel's weights from its polynomial tiles (passes/gl/kernel_weights.h).
// Defined: GROUPS (of four taps), DEGREE and SEGMENTS of the tiles.

#if SEGMENTS > 1
uniform samplerBuffer kernel; // [segment][power][group]
#else
uniform vec4 kernel[(DEGREE + 1) * GROUPS]; // [power][group]
#endif

void kernel_weights(float t, out float weight[4 * GROUPS])
{
    vec4 c[(DEGREE + 1) * GROUPS];
#if SEGMENTS > 1
    float scaled = t * float(SEGMENTS);
    int segment = min(int(scaled), SEGMENTS - 1);
    float u = scaled - float(segment);
    for (int i = 0; i < (DEGREE + 1) * GROUPS; i++)
        c[i] = texelFetch(kernel, segment * ((DEGREE + 1) * GROUPS) + i);
#else
    float u = t;
    for (int i = 0; i < (DEGREE + 1) * GROUPS; i++)
        c[i] = kernel[i];
#endif
    for (int g = 0; g < GROUPS; g++) {
        vec4 sum = c[DEGREE * GROUPS + g];
        for (int p = DEGREE - 1; p >= 0; p--)
            sum = sum * u + c[p * GROUPS + g];
        for (int i = 0; i < 4; i++)
            weight[4 * g + i] = sum[i];
    }
}
