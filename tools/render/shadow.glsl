// Whether a light is hidden by a shadow map: shadow_view.h says how maps lie, and why the test is
// this one. Directions and normals are in the light's frame: right, up, forward. `kind` is constant
// wherever it is called, so that only one way of looking up is left.
uniform sampler2DArray shadow_maps;
uniform vec3 shadow_eye[LIGHTS];
uniform mat3 shadow_frame[LIGHTS];  // rows: right, up, forward
uniform vec4 shadow_window[LIGHTS]; // of a fitted face: low tangents, and their extents
uniform float shadow_near[LIGHTS];
uniform int shadow_layer[LIGHTS]; // the first one
uniform float shadow_lift;        // that planes are moved towards lights
uniform vec2 shadow_bias;         // of texels, and of depth

// A face as it is looked up: direction and normal with the face's axis last, and its part of a
// layer.
struct Face {
    vec3 way, normal;
    vec2 low, extent;   // tangents
    ivec2 first, count; // texels
    int layer;
};

// The one of six, or of one and four halves, two of which share a layer.
Face find_cube_face(bool whole, vec3 way, vec3 normal, int size)
{
    vec3 a = abs(way);
    bool top = a.z >= max(a.x, a.y), x = a.x >= a.y;
    vec3 turned = top ? way : x ? way.yzx : way.xzy;
    vec3 turned_normal = top ? normal : x ? normal.yzx : normal.xzy;
    bool below = turned.z < 0.0;
    turned.z = abs(turned.z);
    turned_normal.z = below ? -turned_normal.z : turned_normal.z;
    int pair = top ? 0 : x ? 1 : 2;
    if (whole)
        return Face(turned, turned_normal, vec2(-1.0), vec2(2.0), ivec2(0), ivec2(size),
                    2 * pair + int(below));
    return Face(turned, turned_normal, vec2(-1.0, top ? -1.0 : 0.0), vec2(2.0, top ? 2.0 : 1.0),
                ivec2(0, !top && below ? size / 2 : 0), ivec2(size, top ? size : size / 2), pair);
}

// `flat_normal` is turned to the light.
bool shadow_hides(int i, int kind, vec3 position, vec3 flat_normal, float bend)
{
    if (kind == KIND_NONE)
        return false;
    vec3 way = shadow_frame[i] * (position - shadow_eye[i]);
    vec3 normal = shadow_frame[i] * flat_normal;
    int size = textureSize(shadow_maps, 0).x;
    Face face = Face(way, normal, shadow_window[i].xy, shadow_window[i].zw, ivec2(0), ivec2(size),
                     0);
    if (kind != KIND_FITTED)
        face = find_cube_face(kind == KIND_CUBE, way, normal, size);
    float depth = face.way.z, near = shadow_near[i];
    vec2 place = (face.way.xy / depth - face.low) / face.extent;
    bool seen = kind != KIND_FITTED || (depth > 0.0 && all(greaterThanEqual(place, vec2(0.0))) &&
                                        all(lessThanEqual(place, vec2(1.0))));
    vec2 count = vec2(face.count);
    vec2 texel = clamp(floor(place * count), vec2(0.0), count - 1.0);
    vec2 step = face.extent / count;
    vec2 centre = face.low + (texel + 0.5) * step;
    // The distance of the light above the plane that is compared.
    float above = -dot(face.normal, face.way);
    float lean = max(above / length(face.way), 0.125); // cosine
    above -= shadow_lift + min(bend * max(step.x, step.y) * depth / lean, 0.5 * above);
    // near / depth of that plane in the middle of the texel, and how it grows over one.
    float scale = near / above;
    float compared = -scale * dot(face.normal, vec3(centre, 1.0));
    float slope = scale * dot(abs(face.normal.xy), step);
    compared = max(compared, 0.5 * near / depth) + shadow_bias.x * slope + shadow_bias.y;
    float stored =
        texelFetch(shadow_maps, ivec3(face.first + ivec2(texel), shadow_layer[i] + face.layer), 0)
            .r;
    return seen && above > 0.0 && 1.0 - stored > compared;
}
