// SPDX-License-Identifier: BSD-3-Clause
// PLY (G. Turk, "The PLY polygon file format", 1994): of a file its vertices and polygons are
// written anew, as little-endian floats and indices. What else it has is passed over.
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "tiles/readers/mesh/clean.h"
#include "tiles/readers/mesh/polygon.h"

enum {
    ELEMENTS_LIMIT = 64,
    PROPERTIES_LIMIT = 256, // of an element
    VALUES = 11,            // of a vertex, as listed below
};

// What of a vertex is taken, and under which names.
static const char *const value_names[VALUES][4] = {
    {"x"},
    {"y"},
    {"z"},
    {"nx"},
    {"ny"},
    {"nz"},
    {"red", "r"},
    {"green", "g"},
    {"blue", "b"},
    {"s", "u", "texture_u", "tx"},
    {"t", "v", "texture_v", "ty"},
};
// Where its groups start: all of a group is there, or none.
static const int group_starts[] = {0, 3, 6, 9, VALUES};
enum { GROUPS = 4 };

enum type { INT8, UINT8, INT16, UINT16, INT32, UINT32, FLOAT32, FLOAT64, TYPES };
static const char *const type_names[TYPES][2] = {
    {"char", "int8"}, {"uchar", "uint8"}, {"short", "int16"},   {"ushort", "uint16"},
    {"int", "int32"}, {"uint", "uint32"}, {"float", "float32"}, {"double", "float64"},
};
static const uint64_t type_bytes[TYPES] = {1, 1, 2, 2, 4, 4, 4, 8};

struct property {
    bool list;
    enum type count_type, type;
    int value;    // of a vertex; -1: none of them
    bool corners; // the list of a polygon's, or of strips of triangles
};

struct element {
    enum { OTHER, VERTEX, FACE, STRIPS, EDGE } kind;
    char name[64];
    uint64_t count;
    int property_count;
    struct property properties[PROPERTIES_LIMIT];
};

struct ply {
    struct weft_mesh_clean *clean;
    const char *at, *end; // what is left of the file
    bool ascii, big_endian;
    uint64_t vertex_count;
    int element_count;
    struct element *elements;
    bool has[VALUES];
    const struct element *element; // that is read
    uint64_t index;
    struct weft_mesh_text vertices, faces;
    uint32_t strip[2]; // the latest corners of a strip
    uint64_t strip_length;
};

// Says why not.
#define fail_with(p, result, ...) (weft_mesh_clean_fail((p)->clean, result, __VA_ARGS__), false)
#define fail(p, ...) fail_with(p, WEFT_ERR_FORMAT, __VA_ARGS__)

// ---- the header ---------------------------------------------------------------------------------

enum { WORDS = 6, WORD = 64 };

// The next line's words; longer ones are cut. A line that does not end is none.
static bool header_line(struct ply *p, char word[WORDS][WORD], int *count)
{
    const char *stop = p->at ? memchr(p->at, '\n', (size_t)(p->end - p->at)) : NULL;
    // Files of old Macintoshes end lines by CR alone.
    const char *cr = p->at ? memchr(p->at, '\r', (size_t)((stop ? stop : p->end) - p->at)) : NULL;
    *count = 0;
    if (!stop && !cr)
        return fail(p, "its header has no end");
    const char *end = cr ? cr : stop;
    for (const char *c = p->at; c < end;) {
        size_t length = 0;
        while (c < end && (*c == ' ' || *c == '\t'))
            c++;
        if (c == end || *count == WORDS)
            break;
        for (; c < end && *c != ' ' && *c != '\t'; c++)
            if (length < WORD - 1)
                word[*count][length++] = *c;
        word[(*count)++][length] = '\0';
    }
    p->at = end + 1 + (cr && cr + 1 == stop);
    return true;
}

static bool find_type(struct ply *p, const char *name, enum type *out)
{
    for (int t = 0; t < TYPES; t++)
        if (!strcmp(name, type_names[t][0]) || !strcmp(name, type_names[t][1])) {
            *out = (enum type)t;
            return true;
        }
    return fail(p, "'%.60s' is no type of a property", name);
}

static int find_value(const char *name)
{
    for (int v = 0; v < VALUES; v++)
        for (int i = 0; i < 4 && value_names[v][i]; i++)
            if (!strcmp(name, value_names[v][i]))
                return v;
    return -1;
}

static bool add_element(struct ply *p, char word[WORDS][WORD], int count)
{
    static const char *const names[] = {"", "vertex", "face", "tristrips", "edge"};
    if (p->element_count == ELEMENTS_LIMIT)
        return fail_with(p, WEFT_ERR_LIMIT, "it has more than %d kinds of elements",
                         ELEMENTS_LIMIT);
    struct element *e = &p->elements[p->element_count++];
    char *end = NULL;
    if (count != 3 || *word[2] < '0' || *word[2] > '9' ||
        (e->count = strtoull(word[2], &end, 10), *end) || e->count > INT64_MAX)
        return fail(p, "'%.60s' is no number of elements", count > 2 ? word[2] : "");
    snprintf(e->name, sizeof e->name, "%s", word[1]);
    for (int kind = VERTEX; kind <= EDGE; kind++)
        if (!strcmp(e->name, names[kind]))
            e->kind = (int)kind;
    for (int i = 0; i < p->element_count - 1; i++)
        if (e->kind != OTHER && p->elements[i].kind == e->kind)
            return fail(p, "it has the element '%s' twice", e->name);
    if (e->kind == VERTEX)
        p->vertex_count = e->count;
    return true;
}

static bool add_property(struct ply *p, char word[WORDS][WORD], int count)
{
    struct element *e = p->element_count ? &p->elements[p->element_count - 1] : NULL;
    const bool list = count > 1 && !strcmp(word[1], "list");
    const int name = list ? 4 : 2;
    if (!e || count != name + 1)
        return fail(p, "a property of %d words stands in its header", count);
    if (e->property_count == PROPERTIES_LIMIT)
        return fail_with(p, WEFT_ERR_LIMIT, "an element has more than %d properties",
                         PROPERTIES_LIMIT);
    struct property *q = &e->properties[e->property_count++];
    *q = (struct property){.list = list, .value = -1};
    if ((list && !find_type(p, word[2], &q->count_type)) || !find_type(p, word[name - 1], &q->type))
        return false;
    if (list)
        q->corners = (e->kind == FACE || e->kind == STRIPS) &&
                     (!strcmp(word[4], "vertex_index") || !strcmp(word[4], "vertex_indices"));
    else if (e->kind == VERTEX)
        q->value = find_value(word[2]);
    if (q->value >= 0 && p->has[q->value])
        return fail(p, "a vertex has the property '%s' twice", word[2]);
    if (q->value >= 0)
        p->has[q->value] = true;
    return true;
}

static bool set_format(struct ply *p, char word[WORDS][WORD], int count)
{
    p->ascii = count > 1 && !strcmp(word[1], "ascii");
    p->big_endian = count > 1 && !strcmp(word[1], "binary_big_endian");
    if (count != 3 || strcmp(word[2], "1.0") ||
        !(p->ascii || p->big_endian || !strcmp(word[1], "binary_little_endian")))
        return fail_with(p, WEFT_ERR_UNSUPPORTED, "it is of the format '%.60s %.60s'",
                         count > 1 ? word[1] : "", count > 2 ? word[2] : "");
    return true;
}

static bool read_header(struct ply *p)
{
    char word[WORDS][WORD];
    int count;
    bool format = false, good = true;
    if (!header_line(p, word, &count))
        return false;
    if (count != 1 || strcmp(word[0], "ply"))
        return fail(p, "a PLY file starts with 'ply'");
    while (good && (good = header_line(p, word, &count))) {
        if (!count)
            continue;
        if (!strcmp(word[0], "end_header"))
            return format || fail(p, "its header names no format");
        if (!strcmp(word[0], "format"))
            format = good = set_format(p, word, count);
        else if (!strcmp(word[0], "element"))
            good = add_element(p, word, count);
        else if (!strcmp(word[0], "property"))
            good = add_property(p, word, count);
        else if (!strcmp(word[0], "comment"))
            p->clean->left.textures += count > 1 && !strcmp(word[1], "TextureFile");
        else if (strcmp(word[0], "obj_info"))
            return fail(p, "'%.60s' stands in its header", word[0]);
    }
    return false;
}

// A group of which a part is missing is not there.
static bool check_values(struct ply *p)
{
    for (int g = 0; g < GROUPS; g++) {
        bool whole = true;
        for (int v = group_starts[g]; v < group_starts[g + 1]; v++)
            whole &= p->has[v];
        for (int v = group_starts[g]; v < group_starts[g + 1]; v++)
            p->has[v] = whole;
    }
    if (!p->has[0])
        return fail(p, "its vertices have no x, y and z");
    return p->vertex_count <= INT32_MAX ||
           fail_with(p, WEFT_ERR_LIMIT, "it has %" PRIu64 " vertices: %d is the limit",
                     p->vertex_count, INT32_MAX);
}

// ---- values -------------------------------------------------------------------------------------

static bool ended(struct ply *p)
{
    return fail(p, "the file ends in %s %" PRIu64 " of %" PRIu64, p->element->name, p->index,
                p->element->count);
}

static bool is_space(char c)
{
    return c == ' ' || (c >= '\t' && c <= '\r');
}

static bool text_value(struct ply *p, double *out)
{
    char text[64];
    size_t length = 0;
    while (p->at < p->end && is_space(*p->at))
        p->at++;
    if (p->at == p->end)
        return ended(p);
    for (; p->at < p->end && !is_space(*p->at); p->at++)
        if (length < sizeof text - 1)
            text[length++] = *p->at;
    text[length] = '\0';
    const char *end = weft_number_parse(text, out);
    return (end && !*end) || fail(p, "%s %" PRIu64 " has '%s', which is no finite number",
                                  p->element->name, p->index, text);
}

static bool binary_value(struct ply *p, enum type type, double *out)
{
    const size_t bytes = type_bytes[type];
    unsigned char raw[8];
    uint64_t whole = 0;
    float single;
    if ((size_t)(p->end - p->at) < bytes)
        return ended(p);
    memcpy(raw, p->at, bytes);
    p->at += bytes;
    for (size_t i = 0; i < bytes; i++)
        whole |= (uint64_t)raw[p->big_endian ? bytes - 1 - i : i] << 8 * i;
    const uint32_t low = (uint32_t)whole;
    switch (type) {
    case INT8:
        *out = (int8_t)low;
        break;
    case INT16:
        *out = (int16_t)low;
        break;
    case INT32:
        *out = (int32_t)low;
        break;
    case FLOAT32:
        memcpy(&single, &low, sizeof single);
        *out = (double)single;
        break;
    case FLOAT64:
        memcpy(out, &whole, sizeof *out);
        break;
    default:
        *out = low;
    }
    return true;
}

static bool value(struct ply *p, enum type type, double *out)
{
    return p->ascii ? text_value(p, out) : binary_value(p, type, out);
}

// Whole and positive, or -1.
static bool whole_value(struct ply *p, enum type type, int64_t *out)
{
    double number;
    if (!value(p, type, &number))
        return false;
    *out = number >= -1.0 && number <= (double)INT32_MAX ? (int64_t)number : -2;
    return (double)*out == number || fail(p,
                                          "%s %" PRIu64 " has %g where an index or a number of "
                                          "them is due",
                                          p->element->name, p->index, number);
}

// ---- elements -----------------------------------------------------------------------------------

static bool corner_valid(struct ply *p, int64_t corner)
{
    return (corner >= 0 && (uint64_t)corner < p->vertex_count) ||
           fail(p, "%s %" PRIu64 " has the index %" PRId64 " of %" PRIu64 " vertices",
                p->element->name, p->index, corner, p->vertex_count);
}

static bool polygon(struct ply *p, const struct property *q, int64_t count)
{
    const uint32_t corners = (uint32_t)count;
    if (count > WEFT_MESH_CORNERS)
        return fail_with(p, WEFT_ERR_LIMIT,
                         "%s %" PRIu64 " has %" PRId64 " corners: %d is the limit",
                         p->element->name, p->index, count, WEFT_MESH_CORNERS);
    if (count >= 3)
        weft_mesh_text_add(&p->faces, &corners, sizeof corners);
    for (int64_t i = 0; i < count; i++) {
        int64_t corner;
        if (!whole_value(p, q->type, &corner) || !corner_valid(p, corner))
            return false;
        const uint32_t index = (uint32_t)corner;
        if (count >= 3)
            weft_mesh_text_add(&p->faces, &index, sizeof index);
    }
    p->clean->left.points += count == 1;
    p->clean->left.lines += count == 2;
    p->clean->faces += count >= 3;
    return true;
}

// Strips of triangles, one after another; -1 ends one. Every second triangle is turned.
static bool strips(struct ply *p, const struct property *q, int64_t count)
{
    p->strip_length = 0;
    for (int64_t i = 0; i < count; i++) {
        int64_t corner;
        if (!whole_value(p, q->type, &corner) || (corner != -1 && !corner_valid(p, corner)))
            return false;
        if (corner == -1) {
            p->strip_length = 0;
            continue;
        }
        const int odd = (int)(p->strip_length % 2);
        const uint32_t face[4] = {3, p->strip[odd], p->strip[!odd], (uint32_t)corner};
        if (p->strip_length >= 2) {
            weft_mesh_text_add(&p->faces, face, sizeof face);
            p->clean->faces++;
        }
        p->strip[0] = p->strip[1];
        p->strip[1] = (uint32_t)corner;
        p->strip_length++;
    }
    return true;
}

static bool list(struct ply *p, const struct property *q)
{
    int64_t count;
    double unused;
    if (!whole_value(p, q->count_type, &count))
        return false;
    if (count < 0)
        return fail(p, "%s %" PRIu64 " has a list of %" PRId64, p->element->name, p->index, count);
    if (q->corners)
        return p->element->kind == STRIPS ? strips(p, q, count) : polygon(p, q, count);
    for (int64_t i = 0; i < count; i++)
        if (!value(p, q->type, &unused))
            return false;
    return true;
}

// Codes stand for 0 to 1.
static double fraction(double v, enum type type)
{
    return type == UINT8 ? v / 255.0 : type == UINT16 ? v / 65535.0 : v;
}

static bool instance(struct ply *p)
{
    float values[VALUES] = {0};
    for (int i = 0; i < p->element->property_count; i++) {
        const struct property *q = &p->element->properties[i];
        double v;
        if (q->list ? !list(p, q) : !value(p, q->type, &v))
            return false;
        if (q->value < 0 || !p->has[q->value])
            continue;
        if (!(fabs(v) <= (double)WEFT_MESH_LARGEST))
            return fail(p, "%s %" PRIu64 " has %s = %g: finite numbers up to 1e30 are due",
                        p->element->name, p->index, value_names[q->value][0], v);
        values[q->value] = (float)(q->value >= 6 && q->value < 9 ? fraction(v, q->type) : v);
    }
    for (int v = 0; p->element->kind == VERTEX && v < VALUES; v++)
        if (p->has[v])
            weft_mesh_text_add(&p->vertices, &values[v], sizeof values[v]);
    return true;
}

// Every value takes a byte at least, and a number that stands for itself and a space two.
static bool read_element(struct ply *p, const struct element *e)
{
    uint64_t least = 0;
    p->element = e;
    p->index = 0;
    for (int i = 0; i < e->property_count; i++)
        least += p->ascii ? 1
                          : type_bytes[e->properties[i].list ? e->properties[i].count_type
                                                             : e->properties[i].type];
    if (!least)
        return true;
    if (e->count > (uint64_t)(p->end - p->at) / least)
        return fail(p,
                    "it says %" PRIu64 " of '%s', each of %" PRIu64
                    " bytes at least: %zu bytes are left",
                    e->count, e->name, least, (size_t)(p->end - p->at));
    for (; p->index < e->count; p->index++)
        if (!instance(p))
            return false;
    return true;
}

// ---- the file -----------------------------------------------------------------------------------

static bool read_elements(struct ply *p)
{
    struct weft_mesh_left *left = &p->clean->left;
    bool faces = false;
    for (int i = 0; i < p->element_count; i++) {
        const struct element *e = &p->elements[i];
        if (!read_element(p, e))
            return false;
        if (e->kind == EDGE)
            left->lines += e->count;
        faces |= (e->kind == FACE || e->kind == STRIPS) && e->count;
    }
    if (!faces)
        left->points += p->vertex_count;
    return p->clean->faces || weft_mesh_clean_no_faces(p->clean) == WEFT_OK;
}

static void write_file(struct ply *p)
{
    struct weft_mesh_text *to = &p->clean->main;
    weft_mesh_text_print(to, "ply\nformat binary_little_endian 1.0\nelement vertex %" PRIu64 "\n",
                         p->vertex_count);
    for (int v = 0; v < VALUES; v++)
        if (p->has[v])
            weft_mesh_text_print(to, "property float %s\n", value_names[v][0]);
    // assimp takes a line feed away that comes first.
    weft_mesh_text_print(
        to, "element face %" PRIu64 "\nproperty list uint uint vertex_indices\nend_header\n\n",
        p->clean->faces);
    weft_mesh_text_add(to, p->vertices.data, p->vertices.size);
    weft_mesh_text_add(to, p->faces.data, p->faces.size);
    if (to->failed || p->vertices.failed || p->faces.failed)
        weft_mesh_clean_fail(p->clean, WEFT_ERR_LIMIT, "it does not fit in memory");
}

enum weft_result weft_mesh_clean_ply(struct weft_mesh_clean *clean)
{
    struct ply p = {.clean = clean,
                    .at = clean->files->main.data,
                    .end = clean->files->main.data + clean->files->main.size,
                    .elements = calloc(ELEMENTS_LIMIT, sizeof *p.elements)};
    clean->result = WEFT_OK;
    if (!p.elements)
        weft_mesh_clean_fail(clean, WEFT_ERR_LIMIT, "it does not fit in memory");
    else if (read_header(&p) && check_values(&p) && read_elements(&p))
        write_file(&p);
    free(p.elements);
    weft_mesh_text_clear(&p.vertices);
    weft_mesh_text_clear(&p.faces);
    return clean->result;
}
