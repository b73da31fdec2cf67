// Fragment shader: four pixels of a row, filtered along one axis. The target's texel (x, y) holds
// columns 4x to 4x + 3 of row y.
// Defined by the run: WIDTH (taps), GROUPS (of four taps), ALONG_X (1, or 0: along y), SKIPS_ZEROS (1:
// samples may be NaN or infinite, which taps of weight 0 must not spread).
// Weights past the last tap are not touched: their samples may be NaN.

uniform samplerBuffer source;      // filtered along x: a column per texel; along y: four
uniform samplerBuffer weights;     // [column or row][group]
uniform isamplerBuffer first_taps; // [column or row]
uniform int pitch;                 // texels of the source from row to row

out vec4 value;

#if SKIPS_ZEROS
#define COUNTS(weight) ((weight) != 0.0)
#else
#define COUNTS(weight) true
#endif

#if ALONG_X
float filter_column(int row, int column)
{
    int at = row + texelFetch(first_taps, column).r;
    float sum = 0.0;
    for (int g = 0; g < GROUPS; g++) {
        vec4 weight = texelFetch(weights, column * GROUPS + g);
        for (int i = 0; i < 4; i++)
            if (4 * g + i < WIDTH && COUNTS(weight[i]))
                sum += weight[i] * texelFetch(source, at + 4 * g + i).r;
    }
    return sum;
}

void main()
{
    ivec2 window = ivec2(gl_FragCoord.xy);
    for (int i = 0; i < 4; i++)
        value[i] = filter_column(window.y * pitch, 4 * window.x + i);
}
#else
void main()
{
    ivec2 window = ivec2(gl_FragCoord.xy);
    int at = texelFetch(first_taps, window.y).r * pitch + window.x;
    vec4 sum = vec4(0.0);
    for (int g = 0; g < GROUPS; g++) {
        vec4 weight = texelFetch(weights, window.y * GROUPS + g);
        for (int i = 0; i < 4; i++)
            if (4 * g + i < WIDTH && COUNTS(weight[i]))
                sum += weight[i] * texelFetch(source, at + (4 * g + i) * pitch);
    }
    value = sum;
}
#endif
