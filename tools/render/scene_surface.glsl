// Fragment shader of what is seen (tools/render/surface.c): radiance of a Lambert surface, behind a
// head as passes/antialias/drawing/drawing.h tells of. Defined: LIGHTS (of the frame, or 1), the values of enum scene_falloff and scene_shadow_kind, and
// EACH_LIGHT: a LIGHT(place, kind, falloff, flat, clamped) for each light, so that the compiler
// knows all but their numbers - with arrays of kinds, and a loop, a frame takes twice as long.
in vec3 position, normal, colour;
in vec2 uv;

uniform samplerBuffer planes; // of each triangle: normal as modelled, bend (shadow_hides)
uniform usamplerBuffer surfaces; // of each triangle: its number
uniform int first_triangle;
uniform mat3 turn; // the object's rotation
uniform vec3 reflectance, emission, ambient;
uniform float checks; // squares per unit of uv; 0: plain
uniform bool unlit, only_clamped;

uniform vec3 light_position[LIGHTS], light_normal[LIGHTS], light_intensity[LIGHTS];
uniform float light_most[LIGHTS]; // largest factor that counts

#include "tools/render/shadow.glsl"

const float PI = 3.14159265358979;

vec3 find_reflectance()
{
    vec3 all = reflectance * WEFT_AT(colour);
    vec2 cell = floor(WEFT_AT(uv) * checks);
    return checks > 0.0 && mod(cell.x + cell.y, 2.0) != 0.0 ? 0.25 * all : all;
}

// What a light of intensity 1 makes of a surface of reflectance 1. `flat_normal` is its triangle's;
// is_flat: the light shines to one side.
float find_light(int i, int kind, int falloff, bool is_flat, bool clamped, vec3 at,
                 vec3 flat_normal, vec3 smooth_normal, float bend)
{
    vec3 way = light_position[i] - at;
    float square = dot(way, way), scale = inversesqrt(square);
    float cosine = dot(smooth_normal, way) * scale;
    float from = is_flat ? -dot(light_normal[i], way) * scale : 1.0;
    bool lit = dot(flat_normal, way) > 0.0 && cosine > 0.0 && from > 0.0 &&
               !shadow_hides(i, kind, at, flat_normal, bend);
    float part = falloff == FALLOFF_COSINE ? cosine : 1.0, rest = 0.0;
    if (falloff == FALLOFF_RADIANCE) {
        float factor = cosine * from / square;
        float most = clamped ? min(factor, light_most[i]) : factor;
        part = most / PI;
        rest = (factor - most) / PI;
    }
    return lit ? only_clamped ? rest : part : 0.0;
}

vec3 find_radiance(int triangle)
{
    vec3 at = WEFT_AT(position), vertex_normal = WEFT_AT(normal);
    vec4 plane = texelFetch(planes, triangle);
    vec3 flat_normal = turn * plane.xyz;
    if (!gl_FrontFacing)
        flat_normal = -flat_normal;
    // The side that is seen; where normals of vertices are wanting, the triangle's.
    vec3 smooth_normal = dot(vertex_normal, flat_normal) < 0.0 ? -vertex_normal : vertex_normal;
    smooth_normal =
        dot(vertex_normal, vertex_normal) > 0.0 ? normalize(smooth_normal) : flat_normal;
    vec3 surface = find_reflectance();
    vec3 sum = ambient * surface;
    if (unlit)
        sum = only_clamped ? vec3(0.0) : surface;
    vec3 light = vec3(0.0);
#define LIGHT(i, kind, falloff, flat, clamped)                                                     \
    light +=                                                                                       \
        find_light(i, kind, falloff, flat, clamped, at, flat_normal, smooth_normal, plane.w) *     \
        light_intensity[i];
    EACH_LIGHT
    if (!unlit)
        sum += light * surface;
    return gl_FrontFacing ? sum + emission : sum;
}

void main()
{
    int triangle = first_triangle + gl_PrimitiveID;
    weft_write(vec4(find_radiance(triangle), 1.0), texelFetch(surfaces, triangle).r);
}
