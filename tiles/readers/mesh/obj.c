// SPDX-License-Identifier: BSD-3-Clause
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "tiles/readers/mesh/source.h"

struct obj {
    struct weft_mesh_source *source;
    uint64_t count[3], coloured; // vertices, texture coordinates, normals so far
    uint64_t most[3], where[3];  // the largest index of each, and its face
};

static const char *const names[] = {"vertices", "texture coordinates", "normals"};

#define fail(o, ...) (weft_mesh_fail((o)->source, WEFT_ERR_FORMAT, __VA_ARGS__), false)

// ---- the text -----------------------------------------------------------------------------------

static bool is_space(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

// Zeros end lines for assimp, too.
static bool is_end(char c)
{
    return c == '\n' || c == '\0';
}

static bool copy_lines(struct weft_mesh_source *source)
{
    const char *at = source->files->main.data, *end = at + source->files->main.size;
    char *to = source->text = malloc(source->files->main.size + 3);
    if (!to)
        return weft_mesh_fail(source, WEFT_ERR_LIMIT, "it does not fit in memory") == WEFT_OK;
    while (at < end) {
        const char *stop = memchr(at, '\n', (size_t)(end - at)), *next = stop ? stop + 1 : end;
        stop = stop ? stop : end;
        while (at < stop && is_space(*at))
            at++;
        while (at < stop && is_space(stop[-1]))
            stop--;
        if (at < stop && (*at == 'f' || *at == 'v')) {
            const char *comment = memchr(at, '#', (size_t)(stop - at));
            stop = comment ? comment : stop;
        }
        const bool goes_on = at < stop && stop[-1] == '\\';
        if (at < stop && *at != '#') {
            memcpy(to, at, (size_t)(stop - at - goes_on));
            to += stop - at - goes_on;
            *to++ = goes_on ? ' ' : '\n';
        }
        at = next;
    }
    *to++ = '\n';
    *to = '\0';
    source->size = (size_t)(to - source->text);
    return true;
}

// ---- lines --------------------------------------------------------------------------------------

static const char *skip(const char *at)
{
    while (is_space(*at))
        at++;
    return at;
}

static int count_words(const char *at)
{
    int words = 0;
    for (at = skip(at); !is_end(*at); at = skip(at), words++)
        while (!is_space(*at) && !is_end(*at))
            at++;
    return words;
}

// One of a corner's indices, if it is there.
static bool check_index(struct obj *o, const char **at, int which, unsigned *seen)
{
    char *end;
    const bool back = **at == '-';
    if ((*at)[back] < '0' || (*at)[back] > '9')
        return which == 1; // "1//1"
    const long long value = strtoll(*at, &end, 10);
    *at = end;
    *seen |= 1u << which;
    if (!value || (back && (uint64_t)-value > o->count[which]))
        return fail(o, "face %" PRIu64 " has the index %lld of %" PRIu64 " %s", o->source->faces,
                    value, o->count[which], names[which]);
    if (!back && (uint64_t)value > o->most[which]) {
        o->most[which] = (uint64_t)value;
        o->where[which] = o->source->faces;
    }
    return true;
}

static bool check_corner(struct obj *o, const char **at, unsigned *seen)
{
    const char *start = *at;
    for (int which = 0; which < 3; which++) {
        if (!check_index(o, at, which, seen) || (**at != '/'))
            break;
        ++*at;
    }
    return o->source->result == WEFT_OK &&
           ((*seen && (is_space(**at) || is_end(**at)) && (*at)[-1] != '/') ||
            fail(o, "face %" PRIu64 " has a corner '%.*s'", o->source->faces,
                 (int)strcspn(start, " \t\n") % 40, start));
}

static bool check_face(struct obj *o, const char *at)
{
    unsigned first = 0;
    int corners = 0;
    o->source->faces++;
    while (!is_space(*at) && !is_end(*at))
        at++;
    for (at = skip(at); !is_end(*at); at = skip(at), corners++) {
        unsigned seen = 0;
        if (!check_corner(o, &at, &seen))
            return false;
        if (corners && seen != first)
            return fail(o,
                        "not all corners of face %" PRIu64
                        " have texture coordinates, or not all normals",
                        o->source->faces);
        first = seen;
    }
    return corners >= 3 ||
           fail(o, "face %" PRIu64 " has %d corners: 3 are the least", o->source->faces, corners);
}

static bool check_line(struct obj *o, const char *at)
{
    if (*at == 'f')
        return check_face(o, at);
    if (*at != 'v')
        return true;
    const char *numbers = at + (at[1] == 'n' || at[1] == 't' ? 2 : 1);
    if (numbers[strcspn(numbers, "nNiI\n")] != '\n')
        return fail(o, "'%.*s' has a number that is not finite", (int)strcspn(at, "\n") % 60, at);
    o->count[1] += at[1] == 't';
    o->count[2] += at[1] == 'n';
    if (!is_space(at[1]))
        return true;
    const int words = count_words(at + 1);
    o->count[0]++;
    o->coloured += words == 6;
    return words == 3 || words == 4 || words == 6 ||
           fail(o, "vertex %" PRIu64 " has %d numbers: 3, 4 or, with a colour, 6 are due",
                o->count[0], words);
}

enum weft_result weft_mesh_check_obj(struct weft_mesh_source *source)
{
    struct obj o = {.source = source};
    if (!copy_lines(source))
        return source->result;
    const char *end = source->text + source->size;
    for (const char *at = source->text; at < end;) {
        if (!check_line(&o, at))
            return source->result;
        while (!is_end(*at))
            at++;
        at++;
    }
    for (int i = 0; i < 3; i++)
        if (o.most[i] > o.count[i])
            weft_mesh_fail(source, WEFT_ERR_FORMAT,
                           "face %" PRIu64 " has the index %" PRIu64 " of %" PRIu64 " %s",
                           o.where[i], o.most[i], o.count[i], names[i]);
    if (o.coloured && o.coloured != o.count[0])
        weft_mesh_fail(source, WEFT_ERR_FORMAT, "%" PRIu64 " of %" PRIu64 " vertices have a colour",
                       o.coloured, o.count[0]);
    return source->result;
}
