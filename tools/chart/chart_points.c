// SPDX-License-Identifier: BSD-3-Clause
// Lists of points, and those that were measured elsewhere.
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/chart/chart.h"

static const char header[] = "technique,label,seconds,bytes,max_error,rms_error";
enum { FIELDS = 6, MAX_LINE = 1024, MAX_POINTS = 200 };

enum weft_result chart_append(struct chart_point **list, size_t *count,
                              const struct chart_point *point)
{
    struct chart_point *more = realloc(*list, (*count + 1) * sizeof **list);
    if (!more) {
        report_error("out of memory for %zu points", *count + 1);
        return WEFT_ERR_MEMORY;
    }
    *list = more;
    more[(*count)++] = *point;
    return WEFT_OK;
}

// The end of a quoted field that starts at `at`, unquoted in place; NULL: no quote ends it.
static char *unquote(char *at)
{
    char *out = at;
    for (char *in = at + 1; *in; in++) {
        if (*in == '"' && *++in != '"') {
            *out = 0;
            return in;
        }
        *out++ = *in;
    }
    return NULL;
}

// Cuts a line of CSV (RFC 4180, without line breaks in fields) into its fields.
static bool split(char *line, char *field[FIELDS])
{
    for (int i = 0; i < FIELDS; i++) {
        field[i] = line;
        char *end = *line == '"' ? unquote(line) : line + strcspn(line, ",");
        if (!end || *end != (i < FIELDS - 1 ? ',' : 0))
            return false;
        *end = 0;
        line = end + 1;
    }
    return true;
}

// A finite number, not below 0.
static bool parse(const char *text, double *out)
{
    char *end;
    *out = strtod(text, &end);
    return end != text && *end == 0 && isfinite(*out) && *out >= 0.0;
}

static bool parse_point(char *line, struct chart_point *out)
{
    char *field[FIELDS];
    double bytes;
    if (!split(line, field) || !*field[0])
        return false;
    *out = (struct chart_point){.family = CHART_PEER, .kernel = -1, .bound = NAN};
    snprintf(out->technique, sizeof out->technique, "%s", field[0]);
    snprintf(out->label, sizeof out->label, "%s", *field[1] ? field[1] : field[0]);
    if (!parse(field[2], &out->seconds) || !(out->seconds > 0.0) || !parse(field[3], &bytes) ||
        !(bytes < 0x1p63) || !parse(field[4], &out->max_error) || !parse(field[5], &out->rms_error))
        return false;
    out->read_seconds = out->pass_seconds = NAN;
    out->bytes = (uint64_t)bytes;
    return true;
}

static enum weft_result read_points(const char *path, FILE *file, struct chart *chart)
{
    char line[MAX_LINE];
    size_t added = 0;
    for (int number = 1; fgets(line, sizeof line, file); number++) {
        struct chart_point point;
        line[strcspn(line, "\r\n")] = 0;
        if (number == 1 ? strcmp(weft_text_skip_mark(line), header) != 0
                        : *line && !parse_point(line, &point)) {
            report_error("%s, line %d: not %s", path, number,
                         number == 1 ? header : "two texts and four numbers from 0 on");
            return WEFT_ERR_FORMAT;
        }
        if (number == 1 || !*line)
            continue;
        if (added++ == MAX_POINTS) {
            report_error("%s: more than %d points", path, MAX_POINTS);
            return WEFT_ERR_LIMIT;
        }
        enum weft_result res = chart_append(&chart->point, &chart->count, &point);
        if (res != WEFT_OK)
            return res;
    }
    if (!added) {
        report_error("%s: no points", path);
        return WEFT_ERR_FORMAT;
    }
    return WEFT_OK;
}

enum weft_result chart_points_load(const char *path, struct chart *chart)
{
    FILE *file = fopen(path, "r");
    if (!file) {
        report_error("%s cannot be opened: %s", path, strerror(errno));
        return WEFT_ERR_OPEN;
    }
    enum weft_result res = read_points(path, file, chart);
    fclose(file);
    return res;
}
