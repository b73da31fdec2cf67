// SPDX-License-Identifier: BSD-3-Clause
// Planes in a file, one a line.
#include "tools/slice/sweep.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"

enum { LINE_ROOM = 1024 };

struct planes_file {
    const char *path;
    FILE *in;
    int64_t line, count, wanted;
    int64_t room;
    struct slice_plane *planes; // [room]; those that are wanted
};

static enum weft_result refuse(const struct planes_file *file, const char *what)
{
    report_error("%s, line %lld: %s", file->path, (long long)file->line, what);
    return WEFT_ERR_FORMAT;
}

static bool read_point(const char **at, double out[3])
{
    for (int i = 0; i < 3; i++) {
        char *end;
        if (strchr(" \t", **at)) // which strtod would skip
            return false;
        out[i] = strtod(*at, &end);
        if (end == *at || !isfinite(out[i]) || (i < 2 && *end != ','))
            return false;
        *at = end + (i < 2);
    }
    return true;
}

static double length(const double v[3])
{
    return hypot(hypot(v[0], v[1]), v[2]);
}

// The library asks for the same, in index space.
static bool spans_plane(const struct slice_plane *p)
{
    const double of_u = length(p->u), of_v = length(p->v);
    if (!(of_u > 0.0 && of_v > 0.0 && isfinite(of_u) && isfinite(of_v)))
        return false;
    double u[3], v[3];
    for (int i = 0; i < 3; i++) {
        u[i] = p->u[i] / of_u;
        v[i] = p->v[i] / of_v;
    }
    return length((double[]){u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                             u[0] * v[1] - u[1] * v[0]}) > 1e-9;
}

static enum weft_result add_plane(struct planes_file *file, const struct slice_plane *plane)
{
    if (file->count < file->wanted && file->count == file->room) {
        const int64_t room = 2 * file->room + 64;
        struct slice_plane *planes = realloc(file->planes, (size_t)room * sizeof *planes);
        if (!planes)
            return WEFT_ERR_MEMORY;
        file->planes = planes;
        file->room = room;
    }
    if (file->count < file->wanted)
        file->planes[file->count] = *plane;
    file->count++;
    return WEFT_OK;
}

static enum weft_result read_line(struct planes_file *file, const char *at)
{
    struct slice_plane plane;
    double *const points[] = {plane.origin, plane.u, plane.v};
    at += strspn(at, " \t");
    if (!*at || *at == '#')
        return WEFT_OK;
    for (int i = 0; i < 3; i++) {
        at += strspn(at, " \t");
        if (!read_point(&at, points[i]) || (*at && !strchr(" \t", *at)))
            return refuse(file, "not a plane: origin, u and v as X,Y,Z X,Y,Z X,Y,Z, all finite");
    }
    if (at[strspn(at, " \t")])
        return refuse(file, "more than a plane: origin, u and v as X,Y,Z X,Y,Z X,Y,Z");
    if (!spans_plane(&plane))
        return refuse(file, "u and v span no plane: zero or parallel");
    return add_plane(file, &plane);
}

// Lines end in \n or \r\n. *more: there was one.
static enum weft_result next_line(struct planes_file *file, char line[LINE_ROOM], bool *more)
{
    int size = 0, c;
    file->line++;
    while ((c = getc(file->in)) != EOF && c != '\n') {
        if (c == 0 || size == LINE_ROOM - 1)
            return refuse(file, c ? "longer than 1023 bytes" : "a NUL byte: this is no text");
        line[size++] = (char)c;
    }
    if (size && line[size - 1] == '\r')
        size--;
    line[size] = 0;
    *more = c != EOF || size;
    if (!ferror(file->in))
        return WEFT_OK;
    report_error("%s cannot be read: %s", file->path, strerror(errno));
    return WEFT_ERR_OPEN;
}

static enum weft_result read_lines(struct planes_file *file)
{
    char line[LINE_ROOM];
    bool more = true;
    enum weft_result res = WEFT_OK;
    while (res == WEFT_OK && more) {
        res = next_line(file, line, &more);
        if (res == WEFT_OK && more)
            res = read_line(file, line);
    }
    if (res != WEFT_OK || file->count == file->wanted)
        return res;
    report_error("%s has %lld planes; --frames needs %lld, one for each number from FIRST to LAST",
                 file->path, (long long)file->count, (long long)file->wanted);
    return WEFT_ERR_FORMAT;
}

enum weft_result sweep_load_planes(const char *path, int64_t count, struct slice_plane **out)
{
    struct planes_file file = {.path = path, .in = fopen(path, "re"), .wanted = count};
    *out = NULL;
    if (!file.in) {
        report_error("%s cannot be opened: %s", path, strerror(errno));
        return WEFT_ERR_OPEN;
    }
    const enum weft_result res = read_lines(&file);
    fclose(file.in);
    if (res == WEFT_OK)
        *out = file.planes;
    else
        free(file.planes);
    return res;
}
