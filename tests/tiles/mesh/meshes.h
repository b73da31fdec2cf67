// SPDX-License-Identifier: BSD-3-Clause
// tests/tiles/mesh/meshes.h - what tests of meshes share: files made of texts and numbers. Include
// after cmocka.h, common.h and files.h.
#ifndef WEFT_TESTS_TILES_MESH_MESHES_H
#define WEFT_TESTS_TILES_MESH_MESHES_H

#include "tests/tiles/image/sequences.h"
#include "tiles/mesh/mesh.h"

static inline void write_text(const char *name, const char *text)
{
    test_write_file(test_path(name), text, strlen(text));
}

static char test_warning[1024];

static inline void keep_warning(void *priv, enum weft_log_level level, const char *message)
{
    test_keep(priv, level, message);
    if (level == WEFT_LOG_WARNING)
        snprintf(test_warning, sizeof test_warning, "%s", message);
}

static const struct weft_log mesh_log = {.write = keep_warning};

// Everything that mesh.h promises of a mesh.
static inline void assert_valid(const struct weft_mesh *mesh)
{
    size_t next = 0;
    assert_true(mesh->vertex_count && mesh->index_count && mesh->part_count &&
                mesh->material_count);
    assert_int_equal(mesh->index_count % 3, 0);
    for (size_t i = 0; i < mesh->index_count; i++)
        assert_true(mesh->indices[i] < mesh->vertex_count);
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        const struct weft_mesh_vertex *v = &mesh->vertices[i];
        double length = 0.0;
        for (int c = 0; c < 3; c++) {
            assert_true(fabsf(v->position[c]) <= 1e30f);
            assert_true(v->colour[c] >= 0.0f && v->colour[c] <= 1.0f);
            length += (double)v->normal[c] * (double)v->normal[c];
        }
        assert_true(fabs(length - 1.0) < 1e-5);
        assert_true(isfinite(v->uv[0]) && isfinite(v->uv[1]));
    }
    for (size_t i = 0; i < mesh->part_count; i++) {
        const struct weft_mesh_part *part = &mesh->parts[i];
        assert_int_equal(part->first_index, next);
        assert_true(part->index_count && part->material < mesh->material_count && *part->name);
        next += part->index_count;
    }
    assert_int_equal(next, mesh->index_count);
}

static inline struct weft_mesh load_good(const char *name)
{
    struct weft_mesh mesh;
    test_forget();
    *test_warning = '\0';
    if (weft_mesh_load(weft_mesh_params(.path = test_path(name), .log = &mesh_log), &mesh))
        fail_msg("%s", test_message);
    assert_string_equal(test_message, "");
    assert_valid(&mesh);
    return mesh;
}

// ---- glTF ---------------------------------------------------------------------------------------

// A triangle (0 0 0) (1 0 0) (0 1 0), whose buffer's place in the text is %s.
static const float gltf_positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
static const unsigned short gltf_indices[4] = {0, 1, 2, 0};
enum { GLTF_BYTES = 44 };

static inline void gltf_bytes(char out[GLTF_BYTES])
{
    memcpy(out, gltf_positions, 36);
    memcpy(out + 36, gltf_indices, 8);
}

static inline void base64(const char *data, size_t size, char *out)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < size; i += 3) {
        unsigned v = 0;
        for (size_t k = 0; k < 3; k++)
            v = v << 8 | (i + k < size ? (unsigned char)data[i + k] : 0u);
        for (size_t k = 0; k < 4; k++)
            *out++ = i + k > size ? '=' : digits[v >> (18 - 6 * k) & 63];
    }
    *out = '\0';
}

#define GLTF_ACCESSORS                                                                             \
    "\"accessors\":["                                                                              \
    "{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"                     \
    "{\"bufferView\":1,\"componentType\":5123,\"count\":3,\"type\":\"SCALAR\"}],"                  \
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},"                                           \
    "{\"buffer\":0,\"byteOffset\":36,\"byteLength\":6}]"
#define GLTF_MESH                                                                                  \
    "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":0}]}"
#define GLTF_MATERIAL                                                                              \
    "{\"name\":\"clay\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.25,0.125,1]},"        \
    "\"emissiveFactor\":[1,0.5,0],\"extensions\":{\"KHR_materials_emissive_strength\":"            \
    "{\"emissiveStrength\":4}}}"
#define GLTF_START "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],"

// `nodes` and `buffer` are JSON; the rest is the triangle.
static inline void gltf_text(const char *nodes, const char *buffer, char *out, size_t size)
{
    const int length = snprintf(out, size,
                                GLTF_START "\"nodes\":[%s],\"meshes\":[" GLTF_MESH
                                           "],\"materials\":[" GLTF_MATERIAL "]," GLTF_ACCESSORS
                                           ",\"buffers\":[%s]}",
                                nodes, buffer);
    assert_true(length > 0 && (size_t)length < size);
}

static inline void data_buffer(char *out, size_t size)
{
    char bytes[GLTF_BYTES], text[80];
    gltf_bytes(bytes);
    base64(bytes, sizeof bytes, text);
    snprintf(out, size, "{\"byteLength\":44,\"uri\":\"data:application/octet-stream;base64,%s\"}",
             text);
}

static inline size_t glb_bytes(const char *nodes, char *out, size_t size)
{
    char text[4096], bytes[GLTF_BYTES];
    gltf_text(nodes, "{\"byteLength\":44}", text, sizeof text);
    gltf_bytes(bytes);
    const uint32_t json = (uint32_t)(strlen(text) + 3) / 4 * 4, body = GLTF_BYTES, version = 2,
                   all = 12 + 8 + json + 8 + body;
    assert_true(all <= size);
    memset(out, ' ', all);
    memcpy(out, "glTF", 4);
    memcpy(out + 4, &version, 4);
    memcpy(out + 8, &all, 4);
    memcpy(out + 12, &json, 4);
    memcpy(out + 16, "JSON", 4);
    memcpy(out + 20, text, strlen(text));
    memcpy(out + 20 + json, &body, 4);
    memcpy(out + 24 + json, "BIN\0", 4);
    memcpy(out + 28 + json, bytes, sizeof bytes);
    return all;
}

#endif
