// SPDX-License-Identifier: BSD-3-Clause
#include <inttypes.h>
#include <string.h>

#include <jansson.h>

#include "filter/check.h"
#include "tiles/readers/mesh/source.h"

struct gltf {
    struct weft_mesh_source *source;
    json_t *root, *views, *accessors;
};

#define fail(g, result, ...) (weft_mesh_fail((g)->source, result, __VA_ARGS__), false)

// Negative: none.
static json_int_t integer(const json_t *object, const char *key, json_int_t otherwise)
{
    const json_t *value = json_object_get(object, key);
    return json_is_integer(value) ? json_integer_value(value) : otherwise;
}

// ---- accessors ----------------------------------------------------------------------------------

static json_int_t type_bytes(json_int_t type)
{
    return type == 5120 || type == 5121   ? 1
           : type == 5122 || type == 5123 ? 2
           : type == 5125 || type == 5126 ? 4
                                          : 0;
}

static int components_of(const json_t *accessor)
{
    static const char *const names[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    const char *name = json_string_value(json_object_get(accessor, "type"));
    for (int i = 0; name && i < 4; i++)
        if (!strcmp(name, names[i]))
            return i + 1;
    return 0;
}

// Whether `count` elements of some bytes each, which `object` places, lie in their view.
static bool check_span(struct gltf *g, size_t which, const json_t *object, json_int_t count,
                       json_int_t bytes)
{
    const json_int_t at = integer(object, "bufferView", -1);
    const json_t *view = at < 0 ? NULL : json_array_get(g->views, (size_t)at);
    const json_int_t offset = integer(object, "byteOffset", 0),
                     length = integer(view, "byteLength", 0),
                     stride = integer(view, "byteStride", 0);
    json_int_t last;
    if (!view || offset < 0 || stride < 0 || (stride && stride < bytes) || count < 1 ||
        __builtin_mul_overflow(count - 1, stride ? stride : bytes, &last) ||
        __builtin_add_overflow(last, bytes, &last) || offset > length || last > length - offset)
        return fail(g, WEFT_ERR_FORMAT,
                    "accessors[%zu]: %" PRId64 " elements of %" PRId64 " bytes from %" PRId64
                    " on do not lie in the %" PRId64 " bytes of bufferViews[%" PRId64 "]",
                    which, (int64_t)count, (int64_t)bytes, (int64_t)offset, (int64_t)length,
                    (int64_t)at);
    return true;
}

// assimp takes interleaved values for sparse ones as if they were not.
static bool check_sparse(struct gltf *g, size_t which, const json_t *accessor, json_int_t bytes)
{
    const json_t *sparse = json_object_get(accessor, "sparse"),
                 *indices = json_object_get(sparse, "indices");
    const json_int_t view = integer(accessor, "bufferView", -1),
                     count = integer(sparse, "count", 0);
    if (!sparse)
        return true;
    if (view >= 0 && integer(json_array_get(g->views, (size_t)view), "byteStride", bytes) != bytes)
        return fail(g, WEFT_ERR_UNSUPPORTED,
                    "accessors[%zu] is sparse and interleaved, which is not read", which);
    return check_span(g, which, indices, count, type_bytes(integer(indices, "componentType", 0))) &&
           check_span(g, which, json_object_get(sparse, "values"), count, bytes);
}

static bool check_accessors(struct gltf *g)
{
    size_t i;
    const json_t *accessor;
    json_array_foreach(g->accessors, i, accessor)
    {
        const json_int_t bytes =
            components_of(accessor) * type_bytes(integer(accessor, "componentType", 0));
        if (!bytes) // matrices are of no mesh
            continue;
        if ((json_object_get(accessor, "bufferView") &&
             !check_span(g, i, accessor, integer(accessor, "count", 0), bytes)) ||
            !check_sparse(g, i, accessor, bytes))
            return false;
    }
    return true;
}

// ---- meshes -------------------------------------------------------------------------------------

// Component types and numbers as bits: FLOAT alone for what is no colour; assimp takes the bytes of
// others for such.
static bool check_use(struct gltf *g, const json_t *places, const char *key, unsigned types,
                      unsigned components)
{
    const json_int_t at = integer(places, key, -1);
    const json_t *accessor = at < 0 ? NULL : json_array_get(g->accessors, (size_t)at);
    const json_int_t type = integer(accessor, "componentType", 0) - 5120;
    if (!accessor) // assimp says so, if it is needed
        return true;
    if (type < 0 || type > 6 || !(types >> type & 1) ||
        !(components >> components_of(accessor) & 1))
        return fail(g, WEFT_ERR_UNSUPPORTED,
                    "accessors[%" PRId64 "], of %s, has %d components of type %" PRId64
                    ", which are not read",
                    (int64_t)at, key, components_of(accessor), (int64_t)(type + 5120));
    return true;
}

static bool check_primitive(struct gltf *g, const json_t *primitive)
{
    enum { FLOAT = 1 << 6, UINT = 1 << 5, USHORT = 1 << 3, UBYTE = 1 << 1 };
    const json_t *attributes = json_object_get(primitive, "attributes");
    return check_use(g, primitive, "indices", UBYTE | USHORT | UINT, 1 << 1) &&
           check_use(g, attributes, "POSITION", FLOAT, 1 << 3) &&
           check_use(g, attributes, "NORMAL", FLOAT, 1 << 3) &&
           check_use(g, attributes, "TEXCOORD_0", FLOAT, 1 << 2) &&
           check_use(g, attributes, "COLOR_0", FLOAT | UBYTE | USHORT, 1 << 3 | 1 << 4);
}

static bool check_meshes(struct gltf *g)
{
    size_t i, k;
    const json_t *mesh, *primitive;
    json_array_foreach(json_object_get(g->root, "meshes"), i, mesh)
    {
        json_array_foreach(json_object_get(mesh, "primitives"), k, primitive)
        {
            if (!check_primitive(g, primitive))
                return false;
        }
    }
    return true;
}

// ---- the document -------------------------------------------------------------------------------

static bool check_version(struct gltf *g)
{
    static const char *const harmless[] = {"KHR_materials_", "KHR_texture_", "EXT_texture_",
                                           "KHR_lights_"};
    const char *version =
        json_string_value(json_object_get(json_object_get(g->root, "asset"), "version"));
    size_t i;
    const json_t *required;
    if (!version || strncmp(version, "2.", 2))
        return fail(g, WEFT_ERR_UNSUPPORTED, "it is of glTF '%.20s': 2.0 is read",
                    version ? version : "");
    json_array_foreach(json_object_get(g->root, "extensionsRequired"), i, required)
    {
        const char *name = json_string_value(required);
        bool known = false;
        for (size_t k = 0; name && k < WEFT_COUNT(harmless); k++)
            known |= !strncmp(name, harmless[k], strlen(harmless[k]));
        if (!known)
            return fail(g, WEFT_ERR_UNSUPPORTED, "it cannot be read without its extension '%.100s'",
                        name ? name : "");
    }
    return true;
}

static void count_strengths(struct gltf *g)
{
    size_t i;
    const json_t *material;
    json_array_foreach(json_object_get(g->root, "materials"), i, material)
    {
        const json_t *extensions = json_object_get(material, "extensions");
        g->source->strengths +=
            json_object_get(extensions, "KHR_materials_emissive_strength") != NULL;
    }
}

// Section 4.4 of the specification: a header of 12 bytes, and chunks of 8 bytes and their data.
static bool find_json(struct gltf *g, struct weft_mesh_bytes *json)
{
    const struct weft_mesh_bytes file = g->source->files->main;
    const unsigned char *b = (const unsigned char *)file.data + 12;
    *json = file;
    if (g->source->kind != WEFT_MESH_GLB)
        return true;
    if (file.size < 20 || memcmp(file.data, "glTF", 4))
        return fail(g, WEFT_ERR_FORMAT, "a GLB file starts with 'glTF' and has 20 bytes at least");
    const size_t length = b[0] | (size_t)b[1] << 8 | (size_t)b[2] << 16 | (size_t)b[3] << 24;
    *json = (struct weft_mesh_bytes){file.data + 20, length};
    return length <= file.size - 20 ||
           fail(g, WEFT_ERR_FORMAT, "its header says %zu bytes of JSON: %zu are left", length,
                file.size - 20);
}

enum weft_result weft_mesh_check_gltf(struct weft_mesh_source *source)
{
    struct gltf g = {.source = source};
    struct weft_mesh_bytes json;
    json_error_t error;
    if (!find_json(&g, &json))
        return source->result;
    // The same key twice is one thing to one reader, and another to the next.
    g.root = json_loadb(json.data, json.size, JSON_REJECT_DUPLICATES, &error);
    g.views = json_object_get(g.root, "bufferViews");
    g.accessors = json_object_get(g.root, "accessors");
    if (!g.root)
        weft_mesh_fail(source, WEFT_ERR_FORMAT, "line %d: %s", error.line, error.text);
    else if (check_version(&g) && check_accessors(&g) && check_meshes(&g))
        count_strengths(&g);
    json_decref(g.root);
    return source->result;
}
