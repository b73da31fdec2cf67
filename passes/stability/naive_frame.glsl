// Fragment shader: one frame, for the blending unit to add (passes/stability.h).
uniform sampler2D frames; // a row each
uniform int frame;

out float value;

void main()
{
    value = texelFetch(frames, ivec2(int(gl_FragCoord.x), frame), 0).r;
}
