// Fragment shader of what is seen (tools/render/drawing.c): radiance of a Lambert surface.
// Defined: LIGHTS (that there can be), the values of enum scene_falloff.
in vec3 position, normal, colour;
in vec2 uv;

uniform samplerBuffer planes; // of each triangle: normal as modelled, bend (shadow_hides)
uniform int first_triangle;
uniform mat4 model;
uniform vec3 reflectance, emission, ambient;
uniform float checks; // squares per unit of uv; 0: plain
uniform bool unlit, only_clamped;

uniform int light_count;
uniform vec3 light_position[LIGHTS], light_normal[LIGHTS], light_intensity[LIGHTS];
uniform bool light_has_normal[LIGHTS];
uniform int light_falloff[LIGHTS];
uniform float light_most[LIGHTS]; // 0: all of it

out vec4 radiance;

#include "tools/render/shadow.glsl"

const float PI = 3.14159265358979;

vec3 find_reflectance()
{
    vec3 all = reflectance * colour;
    vec2 cell = floor(uv * checks);
    return checks > 0.0 && mod(cell.x + cell.y, 2.0) != 0.0 ? 0.25 * all : all;
}

// cos cos / distance^2, or what clamping took away of it.
float find_factor(int i, float cosine, float from, float square)
{
    float factor = cosine * from / square;
    float most = light_most[i] > 0.0 ? min(factor, light_most[i]) : factor;
    return only_clamped ? factor - most : most;
}

// What a light of intensity 1 makes of a surface of reflectance 1. `flat_normal` is its triangle's.
float find_light(int i, vec3 flat_normal, vec3 smooth_normal, float bend)
{
    vec3 way = light_position[i] - position;
    float square = dot(way, way);
    if (dot(flat_normal, way) <= 0.0)
        return 0.0;
    vec3 to = way / sqrt(square);
    float cosine = dot(smooth_normal, to);
    float from = light_has_normal[i] ? -dot(light_normal[i], to) : 1.0;
    if (cosine <= 0.0 || from <= 0.0)
        return 0.0;
    float part;
    if (light_falloff[i] == FALLOFF_RADIANCE)
        part = find_factor(i, cosine, from, square) / PI;
    else
        part = only_clamped ? 0.0 : light_falloff[i] == FALLOFF_COSINE ? cosine : 1.0;
    return part > 0.0 && !shadow_hides(i, position, flat_normal, bend) ? part : 0.0;
}

vec3 find_radiance()
{
    vec4 plane = texelFetch(planes, first_triangle + gl_PrimitiveID);
    vec3 flat_normal = normalize(mat3(model) * plane.xyz);
    if (!gl_FrontFacing)
        flat_normal = -flat_normal;
    // The side that is seen; where normals of vertices are wanting, the triangle's.
    vec3 smooth_normal = dot(normal, flat_normal) < 0.0 ? -normal : normal;
    smooth_normal = dot(normal, normal) > 0.0 ? normalize(smooth_normal) : flat_normal;
    vec3 surface = find_reflectance();
    vec3 sum = ambient * surface;
    if (unlit)
        sum = only_clamped ? vec3(0.0) : surface;
    for (int i = 0; i < light_count && !unlit; i++) {
        float part = find_light(i, flat_normal, smooth_normal, plane.w);
        sum += part * light_intensity[i] * surface;
    }
    return gl_FrontFacing ? sum + emission : sum;
}

void main()
{
    radiance = vec4(find_radiance(), 1.0);
}
