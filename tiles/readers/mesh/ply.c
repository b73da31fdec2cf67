// SPDX-License-Identifier: BSD-3-Clause
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tiles/readers/mesh/source.h"

struct ply {
    struct weft_mesh_source *source;
    bool text;
    int vertices, faces; // elements of these names
    uint64_t lines;      // of all elements, one each
};

#define fail(p, result, ...) (weft_mesh_fail((p)->source, result, __VA_ARGS__), false)

static bool starts(const char *line, size_t length, const char *word)
{
    const size_t n = strlen(word);
    return length >= n && !memcmp(line, word, n) && (length == n || line[n] == ' ');
}

static bool check_header_line(struct ply *p, const char *line, size_t length)
{
    char copy[100], name[32];
    uint64_t count;
    snprintf(copy, sizeof copy, "%.*s", (int)(length < sizeof copy ? length : sizeof copy), line);
    p->text |= starts(line, length, "format ascii");
    if (sscanf(copy, "element %31s %" SCNu64, name, &count) != 2)
        return !starts(line, length, "element") ||
               fail(p, WEFT_ERR_FORMAT, "'%s' has no name and number", copy);
    p->vertices += !strcmp(name, "vertex");
    p->faces += !strcmp(name, "face");
    if (__builtin_add_overflow(p->lines, count, &p->lines) || count > UINT32_MAX)
        return fail(p, WEFT_ERR_LIMIT, "'%s' is more than can be read", copy);
    return strcmp(name, "tristrips") != 0 ||
           fail(p, WEFT_ERR_UNSUPPORTED, "its triangles are strips, which are not read");
}

// Its lines without comments, as they are to be followed by the data.
static const char *copy_header(struct ply *p, const char *at, const char *end, char **to)
{
    bool last = false;
    while (!last) {
        const char *stop = memchr(at, '\n', (size_t)(end - at));
        if (!stop)
            return weft_mesh_fail(p->source, WEFT_ERR_FORMAT, "its header has no end"), NULL;
        const size_t length = (size_t)(stop - at) - (stop > at && stop[-1] == '\r');
        last = starts(at, length, "end_header");
        if (!check_header_line(p, at, length))
            return NULL;
        if (!starts(at, length, "comment") && !starts(at, length, "obj_info")) {
            memcpy(*to, at, length);
            *to += length;
            if (last && !p->text)
                *(*to)++ = '\r'; // assimp skips one line feed behind it
            *(*to)++ = '\n';
        }
        at = stop + 1;
    }
    return at;
}

static bool check_lines(struct ply *p, const char *at, const char *end)
{
    uint64_t lines = 0;
    for (; at < end; at++)
        lines += *at != '\n' && *at != '\r' && (at + 1 == end || at[1] == '\n' || at[1] == '\r');
    return lines >= p->lines ||
           fail(p, WEFT_ERR_FORMAT, "it has %" PRIu64 " lines of data instead of %" PRIu64, lines,
                p->lines);
}

enum weft_result weft_mesh_check_ply(struct weft_mesh_source *source)
{
    struct ply p = {.source = source};
    const struct weft_mesh_bytes file = source->files->main;
    const char *end = file.data + file.size;
    char *to = source->text = malloc(file.size + 2);
    if (!to)
        return weft_mesh_fail(source, WEFT_ERR_LIMIT, "it does not fit in memory");
    if (file.size < 4 || memcmp(file.data, "ply", 3))
        return weft_mesh_fail(source, WEFT_ERR_FORMAT, "a PLY file starts with 'ply'");
    const char *data = copy_header(&p, file.data, end, &to);
    if (!data)
        return source->result;
    if (p.vertices != 1 || p.faces > 1)
        return weft_mesh_fail(source, WEFT_ERR_FORMAT,
                              "it has %d elements 'vertex' and %d 'face' instead of one each",
                              p.vertices, p.faces);
    if (p.text && !check_lines(&p, data, end))
        return source->result;
    memcpy(to, data, (size_t)(end - data));
    to += end - data;
    if (p.text)
        *to++ = '\n';
    source->size = (size_t)(to - source->text);
    return WEFT_OK;
}
