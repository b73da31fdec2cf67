// Vertex shader of what is seen (tools/render/frame.c): one object in all programs, so that depths
// of two passes are the same.
invariant gl_Position;
layout(location = 0) in vec3 at;
layout(location = 1) in vec3 points_to;
layout(location = 2) in vec2 at_uv;
layout(location = 3) in vec3 has_colour;
uniform mat4 clip;  // camera * object, multiplied in double
uniform mat4 model; // object, in diagonals of the scene's box, from its middle
uniform mat3 turn;  // its rotation
out vec3 position, normal, colour;
out vec2 uv;

void main()
{
    position = (model * vec4(at, 1.0)).xyz;
    normal = turn * points_to;
    uv = at_uv;
    colour = has_colour;
    gl_Position = clip * vec4(at, 1.0);
}
