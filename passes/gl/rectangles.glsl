// Vertex shader: rectangles of whole pixels, an instance each, as strips of two triangles.
uniform ivec4 rectangles[64]; // left, bottom, right, top in pixels of the viewport
uniform vec2 viewport;        // its size

void main()
{
    ivec4 r = rectangles[gl_InstanceID];
    vec2 at = vec2((gl_VertexID & 1) != 0 ? r.z : r.x, (gl_VertexID & 2) != 0 ? r.w : r.y);
    gl_Position = vec4(2.0 * at / viewport - 1.0, 0.0, 1.0);
}
