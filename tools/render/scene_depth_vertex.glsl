// Vertex shader of shadow maps (tools/render/shadow.c).
layout(location = 0) in vec3 at;
uniform mat4 clip; // face * object, multiplied in double

void main()
{
    gl_Position = clip * vec4(at, 1.0);
}
