// SPDX-License-Identifier: BSD-3-Clause
// glTF 2.0 (Khronos Group, 2021): of a file its nodes, triangles and colours are written anew, with
// all numbers in one buffer. Every entry keeps its place in its list.
#include "tiles/readers/mesh/gltf.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"

enum { DEPTH_LIMIT = 1000 }; // of nodes below each other

// Says why not.
#define fail(g, ...) (weft_mesh_clean_fail((g)->clean, WEFT_ERR_FORMAT, __VA_ARGS__), false)

static size_t list_size(struct weft_gltf *g, const char *key)
{
    return json_array_size(json_object_get(g->root, key));
}

static json_t *numbers(const double *values, size_t count)
{
    json_t *out = json_array();
    for (size_t i = 0; i < count; i++)
        json_array_append_new(out, json_real(values[i]));
    return out;
}

// ---- materials ----------------------------------------------------------------------------------

static bool clean_material(struct weft_gltf *g, const json_t *from, json_t *to)
{
    const json_t *pbr = json_object_get(from, "pbrMetallicRoughness");
    const json_t *strong =
        json_object_get(json_object_get(from, "extensions"), "KHR_materials_emissive_strength");
    const json_t *strength = json_object_get(strong, "emissiveStrength");
    double colour[4] = {1, 1, 1, 1}, emission[3] = {0, 0, 0};
    bool found;
    if (!weft_gltf_numbers(g, pbr, "baseColorFactor", 4, colour, &found) ||
        !weft_gltf_numbers(g, from, "emissiveFactor", 3, emission, &found))
        return false;
    for (int c = 0; c < 3 && json_is_number(strength); c++)
        emission[c] *= json_number_value(strength);
    json_t *base = json_object();
    json_object_set_new(base, "baseColorFactor", numbers(colour, 4));
    json_object_set_new(to, "pbrMetallicRoughness", base);
    json_object_set_new(to, "emissiveFactor", numbers(emission, 3));
    if (json_is_string(json_object_get(from, "name")))
        json_object_set(to, "name", json_object_get(from, "name"));
    return true;
}

// ---- meshes -------------------------------------------------------------------------------------

// One of our own accessors, in its own view; both stand in lists of their own. Returns its place.
static json_int_t add_values(json_t *document, const struct weft_gltf_values *values, bool indices)
{
    static const char *const types[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    json_t *views = json_object_get(document, "bufferViews"),
           *accessors = json_object_get(document, "accessors");
    const json_int_t place = (json_int_t)json_array_size(views);
    json_array_append_new(
        views,
        json_pack("{sisIsI}", "buffer", 0, "byteOffset", (json_int_t)values->offset, "byteLength",
                  (json_int_t)(values->count * 4 * (uint64_t)values->components)));
    json_array_append_new(accessors,
                          json_pack("{sIsisIss}", "bufferView", place, "componentType",
                                    indices ? 5125 : 5126, "count", (json_int_t)values->count,
                                    "type", types[values->components - 1]));
    return place;
}

// An attribute that has one value for each vertex.
static bool clean_attribute(struct weft_gltf *g, json_t *document, const json_t *from,
                            const char *name, unsigned components, uint64_t vertices, json_t *to)
{
    struct weft_gltf_values values;
    int64_t which;
    if (!weft_gltf_index(g, from, name, list_size(g, "accessors"), -1, &which))
        return false;
    if (which < 0)
        return true;
    if (!weft_gltf_take(g, which, components, 0, &values))
        return false;
    if (values.count != vertices)
        return fail(g, "%s has %" PRIu64 " elements for %" PRIu64 " vertices", name, values.count,
                    vertices);
    json_object_set_new(to, name, json_integer(add_values(document, &values, false)));
    return true;
}

static void count_left(struct weft_mesh_left *left, int64_t mode, uint64_t corners)
{
    if (mode == 0)
        left->points += corners;
    else
        left->lines += mode == 1 ? corners / 2 : mode == 2 ? corners : corners - (corners > 0);
}

static bool clean_triangles(struct weft_gltf *g, json_t *document, const json_t *from, int64_t mode,
                            const struct weft_gltf_values *position, json_t *to)
{
    const json_t *attributes = json_object_get(from, "attributes");
    struct weft_gltf_values indices = {.count = position->count};
    int64_t which, material;
    if (!weft_gltf_index(g, from, "indices", list_size(g, "accessors"), -1, &which) ||
        !weft_gltf_index(g, from, "material", list_size(g, "materials"), -1, &material) ||
        (which >= 0 && !weft_gltf_take(g, which, 1u << 1, position->count, &indices)))
        return false;
    if (indices.count < 3 || (mode == 4 && indices.count % 3))
        return fail(g, "%" PRIu64 " corners make no %s", indices.count,
                    mode == 4 ? "triangles" : "strip of triangles");
    json_t *clean = json_object(), *places = json_object();
    json_object_set_new(places, "POSITION", json_integer(add_values(document, position, false)));
    json_object_set_new(clean, "mode", json_integer(mode));
    json_object_set_new(clean, "attributes", places);
    if (which >= 0)
        json_object_set_new(clean, "indices", json_integer(add_values(document, &indices, true)));
    if (material >= 0)
        json_object_set_new(clean, "material", json_integer(material));
    json_array_append_new(to, clean);
    return clean_attribute(g, document, attributes, "NORMAL", 1u << 3, position->count, places) &&
           clean_attribute(g, document, attributes, "TEXCOORD_0", 1u << 2, position->count,
                           places) &&
           clean_attribute(g, document, attributes, "COLOR_0", 1u << 3 | 1u << 4, position->count,
                           places);
}

static bool clean_primitive(struct weft_gltf *g, json_t *document, const json_t *from, json_t *to)
{
    const json_t *attributes = json_object_get(from, "attributes"), *targets;
    struct weft_gltf_values position, indices;
    int64_t mode, which, corners;
    if (!weft_gltf_index(g, from, "mode", 7, 4, &mode) ||
        !weft_gltf_index(g, attributes, "POSITION", list_size(g, "accessors"), -1, &which) ||
        !weft_gltf_index(g, from, "indices", list_size(g, "accessors"), -1, &corners) ||
        !weft_gltf_array(g, from, "targets", &targets))
        return false;
    g->clean->left.morphs += json_array_size(targets);
    if (which < 0) // nothing is drawn without positions
        return true;
    const size_t before = g->clean->other.size;
    if (!weft_gltf_take(g, which, 1u << 3, 0, &position))
        return false;
    if (mode >= 4)
        return clean_triangles(g, document, from, mode, &position, to);
    indices = position;
    const bool good = corners < 0 || weft_gltf_take(g, corners, 1u << 1, position.count, &indices);
    count_left(&g->clean->left, mode, indices.count);
    g->clean->other.size = before;
    return good;
}

static bool clean_mesh(struct weft_gltf *g, json_t *document, const json_t *from, json_t *to)
{
    const json_t *primitives;
    json_t *clean = json_array();
    json_object_set_new(to, "primitives", clean);
    if (!weft_gltf_array(g, from, "primitives", &primitives))
        return false;
    for (size_t i = 0; i < json_array_size(primitives); i++)
        if (!clean_primitive(g, document, json_array_get(primitives, i), clean))
            return false;
    return true;
}

// ---- nodes --------------------------------------------------------------------------------------

// Its own name, or its mesh's.
static const char *name_of(const json_t *node, const json_t *mesh)
{
    const char *name = json_string_value(json_object_get(node, "name"));
    if (!name || !*name)
        name = json_string_value(json_object_get(mesh, "name"));
    return name && *name ? name : WEFT_MESH_NAMELESS;
}

static bool clean_node(struct weft_gltf *g, const json_t *from, json_t *to)
{
    static const struct {
        const char *key;
        size_t count;
    } parts[] = {{"matrix", 16}, {"translation", 3}, {"rotation", 4}, {"scale", 3}};
    const json_t *children;
    int64_t mesh;
    double values[16];
    bool found;
    if (!weft_gltf_index(g, from, "mesh", list_size(g, "meshes"), -1, &mesh) ||
        !weft_gltf_array(g, from, "children", &children))
        return false;
    const json_t *meshes = json_object_get(g->root, "meshes");
    const json_t *drawn = mesh < 0 ? NULL : json_array_get(meshes, (size_t)mesh);
    json_object_set_new(to, "name", json_string(name_of(from, drawn)));
    if (mesh >= 0)
        json_object_set_new(to, "mesh", json_integer(mesh));
    if (json_array_size(children))
        json_object_set(to, "children", (json_t *)(uintptr_t)children);
    for (size_t i = 0; i < WEFT_COUNT(parts); i++) {
        if (!weft_gltf_numbers(g, from, parts[i].key, parts[i].count, values, &found))
            return false;
        if (found)
            json_object_set_new(to, parts[i].key, numbers(values, parts[i].count));
    }
    return true;
}

// Nodes are trees: each has one parent at most, and is not below itself (section 3.5.2).
static bool find_parents(struct weft_gltf *g, int64_t *parent, size_t count)
{
    const json_t *nodes = json_object_get(g->root, "nodes");
    for (size_t i = 0; i < count; i++)
        parent[i] = -1;
    for (size_t i = 0; i < count; i++) {
        const json_t *children = json_object_get(json_array_get(nodes, i), "children");
        for (size_t k = 0; k < json_array_size(children); k++) {
            const json_t *child = json_array_get(children, k);
            const json_int_t at = json_integer_value(child);
            if (!json_is_integer(child) || at < 0 || (uint64_t)at >= count)
                return fail(g, "nodes[%zu] has the child %" PRId64 ": there are %zu nodes", i,
                            (int64_t)at, count);
            if (parent[at] >= 0)
                return fail(g, "nodes[%" PRId64 "] is the child of two nodes", (int64_t)at);
            parent[at] = (int64_t)i;
        }
    }
    return true;
}

static bool check_depths(struct weft_gltf *g, const int64_t *parent, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        int depth = 0;
        for (int64_t at = parent[i]; at >= 0; at = parent[at])
            if (++depth > DEPTH_LIMIT)
                return fail(g, "nodes[%zu] lies below itself, or more than %d nodes deep", i,
                            DEPTH_LIMIT);
    }
    return true;
}

// The nodes of the scene that is shown; without a scene, all that have no parent.
static bool add_scene(struct weft_gltf *g, const int64_t *parent, size_t count, json_t *document)
{
    const json_t *scenes, *roots = NULL;
    json_t *clean = json_array();
    int64_t which;
    json_object_set_new(document, "scenes", json_pack("[{so}]", "nodes", clean));
    json_object_set_new(document, "scene", json_integer(0));
    if (!weft_gltf_array(g, g->root, "scenes", &scenes) ||
        !weft_gltf_index(g, g->root, "scene", json_array_size(scenes), 0, &which))
        return false;
    if (!scenes) {
        for (size_t i = 0; i < count; i++)
            if (parent[i] < 0)
                json_array_append_new(clean, json_integer((json_int_t)i));
        return true;
    }
    if (!weft_gltf_array(g, json_array_get(scenes, (size_t)which), "nodes", &roots))
        return false;
    for (size_t i = 0; i < json_array_size(roots); i++) {
        const json_t *root = json_array_get(roots, i);
        const json_int_t at = json_integer_value(root);
        if (!json_is_integer(root) || at < 0 || (uint64_t)at >= count || parent[at] >= 0)
            return fail(g, "a scene shows the node %" PRId64 ": it has a parent, or there is none",
                        (int64_t)at);
        json_array_append_new(clean, json_integer(at));
    }
    return true;
}

// ---- the document -------------------------------------------------------------------------------

static bool clean_list(struct weft_gltf *g, json_t *document, const char *key,
                       bool (*clean)(struct weft_gltf *, json_t *, const json_t *, json_t *))
{
    const json_t *list;
    json_t *out = json_array();
    json_object_set_new(document, key, out);
    if (!weft_gltf_array(g, g->root, key, &list))
        return false;
    for (size_t i = 0; i < json_array_size(list); i++) {
        const json_t *from = json_array_get(list, i);
        json_t *to = json_object();
        json_array_append_new(out, to);
        if (!json_is_object(from))
            return fail(g, "%s[%zu] is not an object", key, i);
        if (!clean(g, document, from, to))
            return false;
    }
    return true;
}

static bool one_material(struct weft_gltf *g, json_t *document, const json_t *from, json_t *to)
{
    (void)document;
    return clean_material(g, from, to);
}

static bool one_node(struct weft_gltf *g, json_t *document, const json_t *from, json_t *to)
{
    (void)document;
    return clean_node(g, from, to);
}

static bool clean_nodes(struct weft_gltf *g, json_t *document)
{
    const size_t count = list_size(g, "nodes");
    int64_t *parent = malloc((count + 1) * sizeof *parent);
    const bool good = parent && clean_list(g, document, "nodes", one_node) &&
                      find_parents(g, parent, count) && check_depths(g, parent, count) &&
                      add_scene(g, parent, count, document);
    free(parent);
    return good;
}

static bool check_version(struct weft_gltf *g)
{
    static const char *const harmless[] = {"KHR_materials_", "KHR_texture_", "EXT_texture_",
                                           "KHR_lights_", "KHR_mesh_quantization"};
    const json_t *asset = json_object_get(g->root, "asset"), *required;
    const char *version = json_string_value(json_object_get(asset, "version"));
    if (!version || strncmp(version, "2.", 2)) {
        weft_mesh_clean_fail(g->clean, WEFT_ERR_UNSUPPORTED, "it is of glTF '%.20s': 2.0 is read",
                             version ? version : "");
        return false;
    }
    if (!weft_gltf_array(g, g->root, "extensionsRequired", &required))
        return false;
    for (size_t i = 0; i < json_array_size(required); i++) {
        const char *name = json_string_value(json_array_get(required, i));
        bool known = false;
        for (size_t k = 0; name && k < WEFT_COUNT(harmless); k++)
            known |= !strncmp(name, harmless[k], strlen(harmless[k]));
        if (!known) {
            weft_mesh_clean_fail(g->clean, WEFT_ERR_UNSUPPORTED,
                                 "it cannot be read without its extension '%.100s'",
                                 name ? name : "");
            return false;
        }
    }
    return true;
}

static void count_rest(struct weft_gltf *g)
{
    struct weft_mesh_left *left = &g->clean->left;
    const json_t *lights =
        json_object_get(json_object_get(g->root, "extensions"), "KHR_lights_punctual");
    left->textures = list_size(g, "textures");
    left->animations = list_size(g, "animations");
    left->skins = list_size(g, "skins");
    left->cameras = list_size(g, "cameras");
    left->lights = json_array_size(json_object_get(lights, "lights"));
}

static int add_text(const char *data, size_t size, void *text)
{
    weft_mesh_text_add(text, data, size);
    return 0;
}

static bool clean_document(struct weft_gltf *g, json_t *document)
{
    json_object_set_new(document, "accessors", json_array());
    json_object_set_new(document, "bufferViews", json_array());
    if (!check_version(g) || !clean_list(g, document, "materials", one_material) ||
        !clean_list(g, document, "meshes", clean_mesh) || !clean_nodes(g, document))
        return false;
    count_rest(g);
    json_object_set_new(document, "asset", json_pack("{ss}", "version", "2.0"));
    json_object_set_new(document, "buffers",
                        json_pack("[{sIss}]", "byteLength", (json_int_t)g->clean->other.size, "uri",
                                  WEFT_MESH_OTHER));
    json_dump_callback(document, add_text, &g->clean->main, JSON_COMPACT | JSON_REAL_PRECISION(17));
    if (!g->clean->main.failed)
        return true;
    weft_mesh_clean_fail(g->clean, WEFT_ERR_LIMIT, "it does not fit in memory");
    return false;
}

// ---- the file -----------------------------------------------------------------------------------

static uint32_t word(const char *data)
{
    const unsigned char *b = (const unsigned char *)data;
    return b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

// Section 4.4 of the specification: a header of 12 bytes, and chunks of 8 bytes and their data.
static bool open_chunks(struct weft_gltf *g, struct weft_mesh_bytes *json)
{
    enum { JSON = 0x4e4f534a, BIN = 0x004e4942 };
    const struct weft_mesh_bytes file = g->clean->files->main;
    if (file.size < 20 || memcmp(file.data, "glTF", 4))
        return fail(g, "a GLB file starts with 'glTF' and has 20 bytes at least");
    if (word(file.data + 4) != 2) {
        weft_mesh_clean_fail(g->clean, WEFT_ERR_UNSUPPORTED,
                             "it is of version %" PRIu32 ": 2 is read", word(file.data + 4));
        return false;
    }
    const size_t size = word(file.data + 8), length = word(file.data + 12);
    if (size > file.size || size < 20 || length > size - 20 || word(file.data + 16) != JSON)
        return fail(g, "its header says %zu bytes, %zu of them JSON: it has %zu", size, length,
                    file.size);
    *json = (struct weft_mesh_bytes){file.data + 20, length};
    const size_t at = 20 + (length + 3) / 4 * 4;
    if (size < 8 || at > size - 8 || word(file.data + at + 4) != BIN)
        return true;
    if (word(file.data + at) > size - at - 8)
        return fail(g, "its second chunk says %" PRIu32 " bytes: %zu are left",
                    word(file.data + at), size - at - 8);
    g->body = (struct weft_mesh_bytes){file.data + at + 8, word(file.data + at)};
    return true;
}

static bool load(struct weft_gltf *g)
{
    struct weft_mesh_bytes json = g->clean->files->main;
    json_error_t error;
    if (g->clean->kind == WEFT_MESH_GLB && !open_chunks(g, &json))
        return false;
    // The same key twice is one thing to one reader, and another to the next.
    g->root = json_loadb(json.data, json.size, JSON_REJECT_DUPLICATES, &error);
    if (!g->root)
        return fail(g, "line %d: %s", error.line, error.text);
    if (!json_is_object(g->root))
        return fail(g, "it is no object of JSON");
    g->buffer_count = list_size(g, "buffers");
    g->buffer = calloc(g->buffer_count + 1, sizeof *g->buffer);
    g->opened = calloc(g->buffer_count + 1, sizeof *g->opened);
    g->owned = calloc(g->buffer_count + 1, sizeof *g->owned);
    if (g->buffer && g->opened && g->owned)
        return true;
    g->buffer_count = 0;
    weft_mesh_clean_fail(g->clean, WEFT_ERR_LIMIT, "it does not fit in memory");
    return false;
}

enum weft_result weft_mesh_clean_gltf(struct weft_mesh_clean *clean)
{
    struct weft_gltf g = {.clean = clean};
    json_t *document = json_object();
    clean->result = WEFT_OK;
    if (!(load(&g) && clean_document(&g, document)) && clean->result == WEFT_OK)
        weft_mesh_clean_fail(clean, WEFT_ERR_LIMIT, "it does not fit in memory");
    json_decref(document);
    weft_gltf_clear(&g);
    return clean->result;
}
