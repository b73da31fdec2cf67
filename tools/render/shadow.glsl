// Whether a light is hidden by a shadow map: shadow_view.h says how maps lie, and why the test is
// this one. Directions and normals are in the light's frame: right, up, forward.
uniform sampler2DArray shadow_maps;
uniform int shadow_kind[LIGHTS];    // enum scene_shadow_kind
uniform vec3 shadow_eye[LIGHTS];    // relative to the middle of the scene's box
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
    vec2 low, extent; // tangents
    ivec2 first, count; // texels
    int layer;
};

Face find_face(int i, vec3 way, vec3 normal)
{
    int size = textureSize(shadow_maps, 0).x;
    if (shadow_kind[i] == KIND_FITTED)
        return Face(way, normal, shadow_window[i].xy, shadow_window[i].zw, ivec2(0), ivec2(size),
                    0);
    bool whole = shadow_kind[i] == KIND_CUBE;
    vec3 a = abs(way);
    if (a.z >= max(a.x, a.y)) {
        float side = sign(way.z);
        return Face(vec3(way.xy, a.z), vec3(normal.xy, side * normal.z), vec2(-1.0), vec2(2.0),
                    ivec2(0), ivec2(size), whole && side < 0.0 ? 1 : 0);
    }
    // Faces at the sides; of half a cube they are halves, two of them in a layer.
    bool x = a.x >= a.y;
    bool below = (x ? way.x : way.y) < 0.0;
    float side = below ? -1.0 : 1.0;
    vec3 turned = x ? way.yzx : way.xzy, turned_normal = x ? normal.yzx : normal.xzy;
    turned.z *= side;
    turned_normal.z *= side;
    int number = x ? 0 : 1;
    if (whole)
        return Face(turned, turned_normal, vec2(-1.0), vec2(2.0), ivec2(0), ivec2(size),
                    2 + 2 * number + int(below));
    return Face(turned, turned_normal, vec2(-1.0, 0.0), vec2(2.0, 1.0),
                ivec2(0, below ? size / 2 : 0), ivec2(size, size / 2), 1 + number);
}

// `flat_normal` is turned to the light.
bool shadow_hides(int i, vec3 position, vec3 flat_normal, float bend)
{
    if (shadow_kind[i] == KIND_NONE)
        return false;
    Face face = find_face(i, shadow_frame[i] * (position - shadow_eye[i]),
                          shadow_frame[i] * flat_normal);
    float depth = face.way.z, near = shadow_near[i];
    vec2 place = (face.way.xy / depth - face.low) / face.extent;
    if (shadow_kind[i] == KIND_FITTED &&
        (depth <= 0.0 || any(lessThan(place, vec2(0.0))) || any(greaterThan(place, vec2(1.0)))))
        return false;
    ivec2 texel = clamp(ivec2(place * vec2(face.count)), ivec2(0), face.count - 1);
    vec2 step = face.extent / vec2(face.count);
    vec2 centre = face.low + (vec2(texel) + 0.5) * step;
    // The distance of the light above the plane that is compared.
    float above = -dot(face.normal, face.way);
    float lean = max(above / length(face.way), 0.125); // cosine
    above -= shadow_lift + min(bend * max(step.x, step.y) * depth / lean, 0.5 * above);
    if (above <= 0.0)
        return false;
    // near / depth of that plane in the middle of the texel, and how it grows over one.
    float compared = -near * dot(face.normal, vec3(centre, 1.0)) / above;
    float slope = near * dot(abs(face.normal.xy), step) / above;
    compared = max(compared, 0.5 * near / depth) + shadow_bias.x * slope + shadow_bias.y;
    float stored = texelFetch(shadow_maps, ivec3(face.first + texel, shadow_layer[i] + face.layer),
                              0).r;
    return 1.0 - stored > compared;
}
