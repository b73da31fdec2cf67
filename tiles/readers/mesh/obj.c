// SPDX-License-Identifier: BSD-3-Clause
// Wavefront OBJ: B1, "Object files", of the Advanced Visualizer's manual. Of a file its polygons
// and the names and colours of their materials are written anew: numbers and indices as they are,
// but positive; groups and materials by number, with their names beside.
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jansson.h>

#include "filter/check.h"
#include "tiles/readers/mesh/clean.h"
#include "tiles/readers/mesh/polygon.h"

enum {
    LIBRARIES_LIMIT = 100,
    NUMBERS = 8, // of a vertex, and one too many
};

// A line without the space around it.
struct line {
    const char *at, *end;
};

// A file on its way: the OBJ file, or a library of materials.
struct obj {
    struct weft_mesh_clean *clean;
    const char *library;          // its name; NULL: the OBJ file
    const char *at, *end;         // what is left of it
    uint64_t number;              // of the line
    struct weft_mesh_text joined; // a line that goes on in the next one
    bool second;                  // counting is over
    bool coloured;
    uint64_t vertices, uvs, normals;            // so far
    uint64_t total[3];                          // after counting
    char material[256], group[256];             // that polygons get
    char given_material[256], given_group[256]; // that assimp was told last
    uint64_t switches, groups, libraries;
    json_t *colours; // of materials by name: Kd and Ke, six numbers
    json_t *used;    // materials that polygons have
};

// Says why not, and where.
#define fail_with(o, result, format, ...)                                                          \
    (weft_mesh_clean_fail((o)->clean, result, "line %" PRIu64 "%s%.100s%s: " format, (o)->number,  \
                          (o)->library ? " of '" : "", (o)->library ? (o)->library : "",           \
                          (o)->library ? "'" : "", __VA_ARGS__),                                   \
     false)
#define fail(o, ...) fail_with(o, WEFT_ERR_FORMAT, __VA_ARGS__)

// ---- lines and words ----------------------------------------------------------------------------

static bool is_space(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

static struct line trimmed(const char *at, const char *end)
{
    while (at < end && is_space(*at))
        at++;
    while (at < end && is_space(end[-1]))
        end--;
    return (struct line){at, end};
}

static struct line next_word(struct line *line)
{
    struct line word = {line->at, line->at};
    while (word.end < line->end && !is_space(*word.end))
        word.end++;
    *line = trimmed(word.end, line->end);
    return word;
}

static bool word_is(struct line word, const char *text)
{
    return (size_t)(word.end - word.at) == strlen(text) && !memcmp(word.at, text, strlen(text));
}

static int shown(struct line word)
{
    return word.end - word.at > 60 ? 60 : (int)(word.end - word.at);
}

// One line of the file; a backslash at its end joins the next one.
static bool next_line(struct obj *o, struct line *out)
{
    o->joined.size = 0;
    for (bool first = true;; first = false) {
        if (o->at == o->end)
            return !first;
        const char *start = o->at;
        const char *stop = memchr(start, '\n', (size_t)(o->end - start));
        o->at = stop ? stop + 1 : o->end;
        o->number++;
        *out = trimmed(start, stop ? stop : o->end);
        const bool goes_on = out->at < out->end && out->end[-1] == '\\';
        if (first && !goes_on)
            return true;
        weft_mesh_text_add(&o->joined, out->at, (size_t)(out->end - out->at) - goes_on);
        weft_mesh_text_add(&o->joined, " ", 1);
        *out = trimmed(o->joined.data, o->joined.data + o->joined.size);
        if (!goes_on)
            return !o->joined.failed;
    }
}

// A number as strtod takes it, without inf, nan and hexadecimal digits, and not larger than what a
// mesh may have.
static bool take_number(struct obj *o, struct line word, double *out)
{
    char text[64];
    const size_t length = (size_t)(word.end - word.at);
    if (length < sizeof text) {
        memcpy(text, word.at, length);
        text[length] = '\0';
        const char *end = weft_number_parse(text, out);
        if (end && !*end && fabs(*out) <= (double)WEFT_MESH_LARGEST)
            return true;
    }
    return fail(o, "'%.*s' is not a finite number up to 1e30", shown(word), word.at);
}

static bool take_numbers(struct obj *o, struct line line, double *out, int *count)
{
    for (*count = 0; line.at < line.end && *line.at != '#'; (*count)++) {
        if (*count == NUMBERS)
            return fail(o, "more than %d numbers", NUMBERS - 1);
        if (!take_number(o, next_word(&line), &out[*count]))
            return false;
    }
    return true;
}

static bool copy_text(struct obj *o, struct line line, char out[256])
{
    const size_t length = (size_t)(line.end - line.at);
    if (length > 255)
        return fail(o, "a name has %zu bytes: 255 is the limit", length);
    memcpy(out, line.at, length);
    out[length] = '\0';
    return !memchr(out, '\0', length) || fail(o, "a name has a %s in it", "zero");
}

// ---- vertices -----------------------------------------------------------------------------------

static bool position(struct obj *o, struct line line)
{
    double n[NUMBERS];
    int count;
    if (!take_numbers(o, line, n, &count))
        return false;
    if (count != 3 && count != 4 && count != 6)
        return fail(o, "a vertex of %d numbers: 3, 4 or, with a colour, 6 are due", count);
    o->vertices++;
    o->coloured |= count == 6;
    if (!o->second)
        return true;
    if (count == 4 && !(fabs(n[3]) >= 1e-30))
        return fail(o, "the weight of a vertex is %g", n[3]);
    const double w = count == 4 ? n[3] : 1.0;
    weft_mesh_text_print(&o->clean->main, "v %.9g %.9g %.9g", n[0] / w, n[1] / w, n[2] / w);
    if (o->coloured) // those without one are white
        weft_mesh_text_print(&o->clean->main, " %.9g %.9g %.9g", count == 6 ? n[3] : 1.0,
                             count == 6 ? n[4] : 1.0, count == 6 ? n[5] : 1.0);
    weft_mesh_text_add(&o->clean->main, "\n", 1);
    return true;
}

static bool uv(struct obj *o, struct line line)
{
    double n[NUMBERS] = {0};
    int count;
    if (!take_numbers(o, line, n, &count))
        return false;
    if (count < 1 || count > 3)
        return fail(o, "%d texture coordinates: 1 to 3 are due", count);
    o->uvs++;
    if (o->second)
        weft_mesh_text_print(&o->clean->main, "vt %.9g %.9g\n", n[0], count > 1 ? n[1] : 0.0);
    return true;
}

static bool normal(struct obj *o, struct line line)
{
    double n[NUMBERS];
    int count;
    if (!take_numbers(o, line, n, &count))
        return false;
    if (count != 3)
        return fail(o, "a normal of %d numbers: 3 are due", count);
    o->normals++;
    if (o->second)
        weft_mesh_text_print(&o->clean->main, "vn %.9g %.9g %.9g\n", n[0], n[1], n[2]);
    return true;
}

// ---- polygons -----------------------------------------------------------------------------------

// One of a corner's indices, from 1; behind it the next one or the corner's end.
static bool take_index(struct obj *o, struct line word, const char **at, uint64_t so_far,
                       uint64_t total, uint64_t *out)
{
    const char *c = *at;
    const bool back = c < word.end && *c == '-';
    uint64_t value = 0;
    for (c += back; c < word.end && *c >= '0' && *c <= '9' && value < INT64_MAX / 16; c++)
        value = 10 * value + (uint64_t)(*c - '0');
    if (c == *at + back || (c < word.end && *c != '/'))
        return fail(o, "'%.*s' is no corner", shown(word), word.at);
    if (!value || value > (back ? so_far : total))
        return fail(o, "the index %.*s leads to none of %" PRIu64,
                    (int)(c - *at > 24 ? 24 : c - *at), *at, back ? so_far : total);
    *out = back ? so_far + 1 - value : value;
    *at = c;
    return true;
}

// "1", "1/2", "1//3" or "1/2/3"; 0 for what is not there.
static bool take_corner(struct obj *o, struct line word, uint64_t out[3])
{
    const char *at = word.at;
    const uint64_t so_far[3] = {o->vertices, o->uvs, o->normals};
    out[0] = out[1] = out[2] = 0;
    for (int i = 0; i < 3; i++) {
        const bool empty = i == 1 && at < word.end && *at == '/';
        if (!empty && !take_index(o, word, &at, so_far[i], o->total[i], &out[i]))
            return false;
        if (at == word.end)
            return true;
        at++; // the slash
    }
    return fail(o, "'%.*s' is no corner", shown(word), word.at);
}

// What polygons from here on belong to, if that is new. Groups become numbers: assimp takes their
// names to the first space.
static bool say_place(struct obj *o)
{
    struct weft_mesh_text *to = &o->clean->main;
    const bool group = strcmp(o->group, o->given_group) != 0;
    const bool material = strcmp(o->material, o->given_material) != 0;
    char name[WEFT_MESH_NAME];
    if (!group && !material)
        return true;
    if (++o->switches > WEFT_MESH_MAX_PARTS)
        return fail_with(o, WEFT_ERR_LIMIT, "groups and materials change more than %d times",
                         WEFT_MESH_MAX_PARTS);
    if (group) {
        weft_mesh_text_print(to, "o %" PRIu64 "\n", ++o->groups);
        weft_mesh_copy_name(name, o->group, strlen(o->group));
        weft_mesh_text_add(&o->clean->names, name, sizeof name);
    }
    weft_mesh_text_add(to, "usemtl ", 7);
    weft_mesh_text_add(to, o->material, strlen(o->material));
    weft_mesh_text_add(to, "\n", 1);
    json_object_set_new_nocheck(o->used, o->material, json_true());
    memcpy(o->given_group, o->group, sizeof o->group);
    memcpy(o->given_material, o->material, sizeof o->material);
    return true;
}

static bool polygon(struct obj *o, struct line line)
{
    struct weft_mesh_text *to = &o->clean->main;
    uint64_t corner[3], first[3] = {0};
    int corners = 0;
    if (!o->second)
        return true;
    if (!say_place(o))
        return false;
    weft_mesh_text_add(to, "f", 1);
    for (; line.at < line.end && *line.at != '#'; corners++) {
        if (!take_corner(o, next_word(&line), corner))
            return false;
        if (!corners)
            memcpy(first, corner, sizeof first);
        if (!first[1] != !corner[1] || !first[2] != !corner[2])
            return fail(o, "not all %s have texture coordinates, or not all normals", "corners");
        if (corners == WEFT_MESH_CORNERS)
            return fail_with(o, WEFT_ERR_LIMIT, "a polygon has more than %d corners",
                             WEFT_MESH_CORNERS);
        weft_mesh_text_print(to, " %" PRIu64, corner[0]);
        if (corner[1])
            weft_mesh_text_print(to, "/%" PRIu64, corner[1]);
        if (corner[2])
            weft_mesh_text_print(to, corner[1] ? "/%" PRIu64 : "//%" PRIu64, corner[2]);
    }
    weft_mesh_text_add(to, "\n", 1);
    o->clean->faces++;
    return corners >= 3 || fail(o, "a polygon has %d corners: 3 are the least", corners);
}

// ---- materials ----------------------------------------------------------------------------------

// Kd or Ke of the material that is described; what is no colour of three numbers is left.
static bool colour(struct obj *o, struct line line, size_t first)
{
    double n[NUMBERS];
    int count;
    json_t *values = json_object_get(o->colours, o->material);
    if (line.at < line.end && strchr("sx", *line.at)) // spectral, xyz
        return true;
    if (!take_numbers(o, line, n, &count))
        return false;
    if (count != 1 && count != 3)
        return fail(o, "a colour of %d numbers: 3 are due", count);
    for (size_t c = 0; values && c < 3; c++)
        json_array_set_new(values, first + c, json_real(n[count == 3 ? c : 0]));
    return true;
}

static bool library_line(struct obj *o, struct line line)
{
    static const char *const textures[] = {"map_", "bump", "disp", "decal", "refl", "norm"};
    const double grey = (double)WEFT_MESH_REFLECTANCE;
    const struct line word = next_word(&line);
    if (word_is(word, "newmtl"))
        return copy_text(o, line, o->material) &&
               (json_object_set_new_nocheck(o->colours, o->material,
                                            json_pack("[ffffff]", grey, grey, grey, 0., 0., 0.)),
                true);
    if (word_is(word, "Kd"))
        return colour(o, line, 0);
    if (word_is(word, "Ke"))
        return colour(o, line, 3);
    for (size_t i = 0; i < WEFT_COUNT(textures); i++)
        if (word.end - word.at >= 4 && !memcmp(word.at, textures[i], 4))
            o->clean->left.textures++;
    return true;
}

// A library that is missing is no failure.
static bool load_library(struct obj *o, const char *name, bool *there)
{
    struct weft_mesh_files *files = o->clean->files;
    struct weft_mesh_bytes bytes;
    *there = weft_mesh_files_open(files, name, &bytes);
    if (!*there)
        return !*files->refused ||
               (weft_mesh_clean_fail(o->clean, WEFT_ERR_FORMAT, "%s", files->refused), false);
    struct obj library = {.clean = o->clean,
                          .library = name,
                          .at = bytes.data,
                          .end = bytes.data + bytes.size,
                          .colours = o->colours};
    struct line line;
    bool good = true;
    while (good && next_line(&library, &line))
        good = library_line(&library, line);
    weft_mesh_text_clear(&library.joined);
    weft_mesh_bytes_release(&bytes);
    return good;
}

// One name, which may have spaces, or several.
static bool libraries(struct obj *o, struct line line)
{
    struct weft_mesh_files *files = o->clean->files;
    char name[256], missing[sizeof files->missing];
    bool there, any = false;
    if (o->second || line.at == line.end)
        return true;
    if (++o->libraries > LIBRARIES_LIMIT)
        return fail_with(o, WEFT_ERR_LIMIT, "more than %d libraries of materials", LIBRARIES_LIMIT);
    if (!copy_text(o, line, name) || !load_library(o, name, &there))
        return false;
    if (there)
        return true;
    memcpy(missing, files->missing, sizeof missing);
    *files->missing = '\0';
    while (line.at < line.end) {
        if (!copy_text(o, next_word(&line), name) || !load_library(o, name, &there))
            return false;
        any |= there;
    }
    if (!any)
        memcpy(files->missing, missing, sizeof missing);
    return true;
}

// What assimp is told of materials.
static void say_materials(struct obj *o)
{
    const char *name;
    json_t *unused;
    struct weft_mesh_text *to = &o->clean->other;
    json_object_foreach(o->used, name, unused)
    {
        const json_t *values = json_object_get(o->colours, name);
        double n[6] = {0};
        for (size_t i = 0; i < 6; i++)
            n[i] = values ? json_number_value(json_array_get(values, i))
                          : (double)(i < 3 ? WEFT_MESH_REFLECTANCE : 0.0f);
        weft_mesh_text_add(to, "newmtl ", 7);
        weft_mesh_text_add(to, name, strlen(name));
        weft_mesh_text_print(to, "\nKd %.9g %.9g %.9g\nKe %.9g %.9g %.9g\n", n[0], n[1], n[2], n[3],
                             n[4], n[5]);
    }
}

// ---- the file -----------------------------------------------------------------------------------

// What is left out is counted once; a line of n corners has n - 1 pieces.
static bool leave_out(struct obj *o, struct line word, struct line line)
{
    struct weft_mesh_left *left = &o->clean->left;
    uint64_t words = 0;
    if (o->second)
        return true;
    for (; line.at < line.end; words++)
        next_word(&line);
    if (word_is(word, "l"))
        left->lines += words - (words > 0);
    else if (word_is(word, "p"))
        left->points += words;
    else if (word_is(word, "curv") || word_is(word, "curv2") || word_is(word, "surf"))
        left->curves++;
    return true;
}

static bool one_line(struct obj *o, struct line line)
{
    const struct line word = next_word(&line);
    if (word_is(word, "v"))
        return position(o, line);
    if (word_is(word, "vt"))
        return uv(o, line);
    if (word_is(word, "vn"))
        return normal(o, line);
    if (word_is(word, "f") || word_is(word, "fo"))
        return polygon(o, line);
    if (word_is(word, "g") || word_is(word, "o"))
        return copy_text(o, line, o->group);
    if (word_is(word, "usemtl"))
        return copy_text(o, line, o->material) &&
               (*o->material || (strcpy(o->material, WEFT_MESH_NAMELESS), true));
    if (word_is(word, "mtllib"))
        return libraries(o, line);
    return leave_out(o, word, line);
}

static bool all_lines(struct obj *o)
{
    struct line line;
    const struct weft_mesh_bytes file = o->clean->files->main;
    o->at = file.data;
    o->end = file.data + file.size;
    o->number = o->vertices = o->uvs = o->normals = 0;
    while (next_line(o, &line))
        if (!one_line(o, line))
            return false;
    return true;
}

enum weft_result weft_mesh_clean_obj(struct weft_mesh_clean *clean)
{
    struct obj o = {.clean = clean,
                    .material = WEFT_MESH_NAMELESS,
                    .given_material = "\2",
                    .colours = json_object(),
                    .used = json_object()};
    clean->result = WEFT_OK;
    bool good = all_lines(&o);
    if (good) {
        o.total[0] = o.vertices;
        o.total[1] = o.uvs;
        o.total[2] = o.normals;
        o.second = true;
        strcpy(o.material, WEFT_MESH_NAMELESS);
        *o.group = '\0';
        weft_mesh_text_print(&clean->main, "mtllib %s\n", WEFT_MESH_OTHER);
        good = all_lines(&o);
    }
    if (good)
        say_materials(&o);
    if (good && !clean->faces)
        weft_mesh_clean_no_faces(clean);
    if (good &&
        (clean->main.failed || clean->other.failed || clean->names.failed || o.joined.failed))
        weft_mesh_clean_fail(clean, WEFT_ERR_LIMIT, "%s", "it does not fit in memory");
    weft_mesh_text_clear(&o.joined);
    json_decref(o.colours);
    json_decref(o.used);
    return clean->result;
}
