// SPDX-License-Identifier: BSD-3-Clause
// Numbers of glTF 2.0 files: sections 3.6 (buffers and accessors) of its specification.
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "tiles/readers/mesh/gltf.h"

// Says why not.
#define fail(g, ...) (weft_mesh_clean_fail((g)->clean, WEFT_ERR_FORMAT, __VA_ARGS__), false)

// ---- members ------------------------------------------------------------------------------------

bool weft_gltf_index(struct weft_gltf *g, const json_t *object, const char *key, size_t count,
                     int64_t otherwise, int64_t *out)
{
    const json_t *value = json_object_get(object, key);
    *out = otherwise;
    if (!value)
        return true;
    if (!json_is_integer(value))
        return fail(g, "'%s' is not a whole number", key);
    *out = json_integer_value(value);
    if (*out < 0 || (uint64_t)*out >= count)
        return fail(g, "'%s' is %" PRId64 ": there are 0 to %" PRId64, key, *out,
                    (int64_t)count - 1);
    return true;
}

bool weft_gltf_numbers(struct weft_gltf *g, const json_t *object, const char *key, size_t count,
                       double *out, bool *found)
{
    const json_t *values = json_object_get(object, key);
    *found = values != NULL;
    if (!values)
        return true;
    if (!json_is_array(values) || json_array_size(values) != count)
        return fail(g, "'%s' is not an array of %zu numbers", key, count);
    for (size_t i = 0; i < count; i++) {
        const json_t *value = json_array_get(values, i);
        out[i] = json_number_value(value);
        if (!json_is_number(value) || !(fabs(out[i]) <= (double)WEFT_MESH_LARGEST))
            return fail(g, "'%s' has %g: finite numbers up to 1e30 are due", key, out[i]);
    }
    return true;
}

bool weft_gltf_array(struct weft_gltf *g, const json_t *object, const char *key, const json_t **out)
{
    *out = json_object_get(object, key);
    return !*out || json_is_array(*out) || fail(g, "'%s' is not an array", key);
}

// An entry of one of the root's arrays, which there is.
static const json_t *entry(struct weft_gltf *g, const char *key, int64_t index)
{
    const json_t *list, *object;
    if (!weft_gltf_array(g, g->root, key, &list))
        return NULL;
    object = json_array_get(list, (size_t)index);
    if (!json_is_object(object)) {
        weft_mesh_clean_fail(g->clean, WEFT_ERR_FORMAT, "there is no %s[%" PRId64 "]: it has %zu",
                             key, index, json_array_size(list));
        return NULL;
    }
    return object;
}

static bool size_member(struct weft_gltf *g, const json_t *object, const char *key, uint64_t *out)
{
    int64_t value;
    const bool good = weft_gltf_index(g, object, key, INT64_MAX, 0, &value);
    *out = (uint64_t)value;
    return good;
}

// ---- buffers ------------------------------------------------------------------------------------

static int base64_digit(char c)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const char *at = c ? strchr(digits, c) : NULL;
    return at ? (int)(at - digits) : -1;
}

// RFC 4648, section 4. NULL where it is none, or memory is short.
static char *base64_bytes(const char *text, size_t *size)
{
    size_t length = strlen(text);
    char *out = malloc(length + 1), *to = out;
    unsigned bits = 0, value = 0;
    while (length && text[length - 1] == '=')
        length--;
    for (size_t i = 0; out && i < length; i++) {
        const int digit = base64_digit(text[i]);
        if (digit < 0) {
            free(out);
            return NULL;
        }
        value = value << 6 | (unsigned)digit;
        bits += 6;
        if (bits >= 8) {
            bits -= 8;
            *to++ = (char)(value >> bits);
        }
    }
    *size = out ? (size_t)(to - out) : 0;
    return out;
}

static int hex_digit(char c)
{
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                  : -1;
}

// RFC 3986, section 2.1: names are escaped in URIs. A NUL stays as it is written.
static void unescape(char *text)
{
    char *to = text;
    for (; *text; text++) {
        const int high = *text == '%' ? hex_digit(text[1]) : -1;
        const int low = high >= 0 ? hex_digit(text[2]) : -1;
        if (low >= 0 && high * 16 + low > 0) {
            *to++ = (char)(high * 16 + low);
            text += 2;
        } else {
            *to++ = *text;
        }
    }
    *to = '\0';
}

static bool open_uri(struct weft_gltf *g, const char *uri, size_t index)
{
    struct weft_mesh_files *files = g->clean->files;
    const char *comma = strchr(uri, ',');
    if (!strncmp(uri, "data:", 5)) {
        if (comma && comma - uri >= 7 && !strncmp(comma - 7, ";base64", 7))
            g->buffer[index].data = base64_bytes(comma + 1, &g->buffer[index].size);
        g->owned[index] = g->buffer[index].data != NULL;
        return g->owned[index] || fail(g, "buffer %zu holds no data in base64", index);
    }
    if (strstr(uri, "://"))
        return fail(g, "it names the file '%.200s', which leads out of its folder", uri);
    char *name = strdup(uri);
    if (name)
        unescape(name);
    const bool good = name && weft_mesh_files_open(files, name, &g->buffer[index]);
    free(name);
    return good || fail(g, "%s", *files->refused ? files->refused : files->missing);
}

static bool open_buffer(struct weft_gltf *g, int64_t at, struct weft_mesh_bytes *out)
{
    const json_t *buffer = entry(g, "buffers", at);
    const size_t index = (size_t)at;
    uint64_t length;
    if (!buffer || !size_member(g, buffer, "byteLength", &length))
        return false;
    const char *uri = json_string_value(json_object_get(buffer, "uri"));
    if (!g->opened[index]) {
        if (uri && !open_uri(g, uri, index))
            return false;
        if (!uri && (index || !g->body.size))
            return fail(g, "buffer %zu has no data", index);
        if (!uri)
            g->buffer[index] = g->body;
        g->opened[index] = true;
    }
    *out = g->buffer[index];
    if (out->size < length)
        return fail(g, "buffer %zu has %zu bytes instead of %" PRIu64, index, out->size, length);
    out->size = length;
    return true;
}

void weft_gltf_clear(struct weft_gltf *g)
{
    for (size_t i = 0; i < g->buffer_count; i++)
        if (g->owned[i])
            free((void *)(uintptr_t)g->buffer[i].data);
        else if (g->buffer[i].data != g->body.data)
            weft_mesh_bytes_release(&g->buffer[i]);
    free(g->buffer);
    free(g->opened);
    free(g->owned);
    json_decref(g->root);
}

// ---- accessors ----------------------------------------------------------------------------------

struct accessor {
    uint64_t count;
    int components, type; // numbers of an element; their component type
    bool normalized;
};

struct span {
    const unsigned char *data; // NULL: all are 0
    uint64_t stride;
};

static uint64_t type_bytes(int64_t type)
{
    switch (type) {
    case 5120: // BYTE
    case 5121: // UNSIGNED_BYTE
        return 1;
    case 5122: // SHORT
    case 5123: // UNSIGNED_SHORT
        return 2;
    case 5125: // UNSIGNED_INT
    case 5126: // FLOAT
        return 4;
    default:
        return 0;
    }
}

static int components_of(const char *type)
{
    static const char *const names[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    for (int i = 0; type && i < 4; i++)
        if (!strcmp(type, names[i]))
            return i + 1;
    return 0;
}

// `count` elements of some bytes each from an offset in a view.
static bool open_view(struct weft_gltf *g, int64_t at, uint64_t offset, uint64_t count,
                      uint64_t bytes, struct span *out)
{
    const json_t *view = entry(g, "bufferViews", at);
    struct weft_mesh_bytes buffer;
    uint64_t first, length, stride, last;
    int64_t which;
    if (!view || !weft_gltf_index(g, view, "buffer", g->buffer_count, -1, &which) ||
        !size_member(g, view, "byteOffset", &first) ||
        !size_member(g, view, "byteLength", &length) ||
        !size_member(g, view, "byteStride", &stride))
        return false;
    if (which < 0)
        return fail(g, "bufferViews[%" PRId64 "] has no buffer", at);
    if (!open_buffer(g, which, &buffer))
        return false;
    if (stride && (stride < bytes || stride > 252))
        return fail(g,
                    "bufferViews[%" PRId64 "] has the stride %" PRIu64 ": elements have %" PRIu64
                    " bytes",
                    at, stride, bytes);
    if (!stride)
        stride = bytes;
    if (first > buffer.size || length > buffer.size - first)
        return fail(g,
                    "bufferViews[%" PRId64 "] has %" PRIu64 " bytes from %" PRIu64
                    " on: the buffer has %zu",
                    at, length, first, buffer.size);
    if (__builtin_mul_overflow(count - 1, stride, &last) ||
        __builtin_add_overflow(last, bytes, &last) || offset > length || last > length - offset)
        return fail(g,
                    "%" PRIu64 " elements of %" PRIu64 " bytes from %" PRIu64
                    " on do not lie in the %" PRIu64 " bytes of bufferViews[%" PRId64 "]",
                    count, bytes, offset, length, at);
    *out = (struct span){(const unsigned char *)buffer.data + first + offset, stride};
    return true;
}

static double number_at(const unsigned char *at, const struct accessor *a)
{
    int8_t s8;
    uint16_t u16;
    int16_t s16;
    uint32_t u32;
    float f32;
    switch (a->type) {
    case 5120:
        memcpy(&s8, at, sizeof s8);
        return a->normalized ? fmax(s8 / 127.0, -1.0) : s8;
    case 5121:
        return a->normalized ? *at / 255.0 : *at;
    case 5122:
        memcpy(&s16, at, sizeof s16);
        return a->normalized ? fmax(s16 / 32767.0, -1.0) : s16;
    case 5123:
        memcpy(&u16, at, sizeof u16);
        return a->normalized ? u16 / 65535.0 : u16;
    case 5125:
        memcpy(&u32, at, sizeof u32);
        return u32;
    default:
        memcpy(&f32, at, sizeof f32);
        return (double)f32;
    }
}

// One element, from where it lies to where it goes; both kinds of values take 4 bytes.
static bool put_element(struct weft_gltf *g, int64_t which, const struct accessor *a,
                        const unsigned char *from, uint64_t index, uint64_t limit, char *to)
{
    for (int c = 0; c < a->components; c++) {
        const double value = from ? number_at(from + (uint64_t)c * type_bytes(a->type), a) : 0.0;
        const uint32_t whole = limit ? (uint32_t)value : 0;
        const float number = (float)value;
        if (limit && !(value < (double)limit))
            return fail(g, "accessors[%" PRId64 "] has the index %.0f of %" PRIu64 " vertices",
                        which, value, limit);
        if (!(fabs(value) <= (double)WEFT_MESH_LARGEST))
            return fail(g,
                        "accessors[%" PRId64 "] has the number %g in its element %" PRIu64
                        ": finite numbers up to 1e30 are due",
                        which, value, index);
        memcpy(to + 4 * (size_t)c, limit ? (const void *)&whole : (const void *)&number, 4);
    }
    return true;
}

// Elements that are given one by one, in place of those that are there.
static bool patch(struct weft_gltf *g, int64_t which, const struct accessor *a,
                  const json_t *sparse, uint64_t limit, uint64_t offset)
{
    const json_t *indices = json_object_get(sparse, "indices"),
                 *values = json_object_get(sparse, "values");
    const uint64_t bytes = type_bytes(a->type) * (uint64_t)a->components;
    struct accessor index = {.components = 1};
    struct span place, value;
    uint64_t count, from[2];
    int64_t view[2], type;
    if (!size_member(g, sparse, "count", &count) ||
        !size_member(g, indices, "byteOffset", &from[0]) ||
        !size_member(g, values, "byteOffset", &from[1]) ||
        !weft_gltf_index(g, indices, "bufferView", INT64_MAX, -1, &view[0]) ||
        !weft_gltf_index(g, values, "bufferView", INT64_MAX, -1, &view[1]) ||
        !weft_gltf_index(g, indices, "componentType", 5126, 0, &type))
        return false;
    if (!count || count > a->count || view[0] < 0 || view[1] < 0 || !type_bytes(type))
        return fail(g, "accessors[%" PRId64 "] is sparse without saying where", which);
    index.type = (int)type;
    if (!open_view(g, view[0], from[0], count, type_bytes(type), &place) ||
        !open_view(g, view[1], from[1], count, bytes, &value))
        return false;
    for (uint64_t i = 0; i < count; i++) {
        const double at = number_at(place.data + i * place.stride, &index);
        if (!(at >= 0.0 && at < (double)a->count))
            return fail(g, "accessors[%" PRId64 "] has the sparse index %.0f of %" PRIu64, which,
                        at, a->count);
        if (!put_element(g, which, a, value.data + i * value.stride, (uint64_t)at, limit,
                         g->clean->other.data + offset + (uint64_t)at * 4 * (size_t)a->components))
            return false;
    }
    return true;
}

static bool describe(struct weft_gltf *g, int64_t which, const json_t *object, unsigned components,
                     uint64_t limit, struct accessor *out)
{
    int64_t type;
    const char *name = json_string_value(json_object_get(object, "type"));
    if (!size_member(g, object, "count", &out->count) ||
        !weft_gltf_index(g, object, "componentType", 5127, 0, &type))
        return false;
    out->type = (int)type;
    out->components = components_of(name);
    out->normalized = json_is_true(json_object_get(object, "normalized"));
    if (!type_bytes(type) || !(components >> out->components & 1) || !out->components ||
        (limit && type != 5121 && type != 5123 && type != 5125))
        return fail(g,
                    "accessors[%" PRId64 "] is of type '%.20s', component type %" PRId64
                    ": it is used for something else",
                    which, name ? name : "", type);
    if (!out->count || out->count > INT32_MAX)
        return fail(g, "accessors[%" PRId64 "] has %" PRIu64 " elements", which, out->count);
    return true;
}

bool weft_gltf_take(struct weft_gltf *g, int64_t which, unsigned components, uint64_t limit,
                    struct weft_gltf_values *out)
{
    struct weft_mesh_text *to = &g->clean->other;
    const json_t *object = entry(g, "accessors", which);
    struct accessor a;
    struct span span = {NULL, 0};
    uint64_t offset;
    int64_t view;
    if (!object || !describe(g, which, object, components, limit, &a) ||
        !size_member(g, object, "byteOffset", &offset) ||
        !weft_gltf_index(g, object, "bufferView", INT64_MAX, -1, &view))
        return false;
    const json_t *sparse = json_object_get(object, "sparse");
    if (view < 0 && !sparse)
        return fail(g, "accessors[%" PRId64 "] has no data", which);
    if (view >= 0 &&
        !open_view(g, view, offset, a.count, type_bytes(a.type) * (uint64_t)a.components, &span))
        return false;
    *out = (struct weft_gltf_values){to->size, a.count, a.components};
    for (uint64_t i = 0; i < a.count; i++) {
        char element[16];
        if (!put_element(g, which, &a, span.data ? span.data + i * span.stride : NULL, i, limit,
                         element))
            return false;
        weft_mesh_text_add(to, element, 4 * (size_t)a.components);
    }
    if (to->failed) {
        weft_mesh_clean_fail(g->clean, WEFT_ERR_LIMIT, "its vertices do not fit in memory");
        return false;
    }
    return !sparse || patch(g, which, &a, sparse, limit, out->offset);
}
