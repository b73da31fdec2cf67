// SPDX-License-Identifier: BSD-3-Clause
// Cost maps as files:
//     weft-cost-map 1
//     picture 512 512
//     cells 64 64
//     (64 lines of 64 numbers: nanoseconds)
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "passes/distribute/schedule/cost_map.h"
#include "passes/distribute/schedule/cost_map_impl.h"
#include "tiles/output/output.h"

static const double most_nanoseconds = 1e18; // 30 years
enum { VERSION = 1 };

// A text that is read line by line.
struct text {
    const struct weft_log *log;
    const char *path, *at;
    int line;
};

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r';
}

static bool ends_line(struct text *text)
{
    while (is_blank(*text->at))
        text->at++;
    return *text->at == '\n' || *text->at == '\0';
}

// The word that is there, for messages: at most 40 bytes of it.
static int word_length(const char *at)
{
    const size_t length = strcspn(at, " \t\r\n");
    return length < 40 ? (int)length : 40;
}

static bool read_number(struct text *text, const char *what, int number, double least, double most,
                        double *out)
{
    if (ends_line(text)) {
        weft_error(text->log, "%s:%d: %s: number %d is missing", text->path, text->line, what,
                   number);
        return false;
    }
    const char *end = weft_number_parse(text->at, out);
    if (!end || !(is_blank(*end) || *end == '\n' || *end == '\0') ||
        !(*out >= least && *out <= most)) {
        weft_error(text->log, "%s:%d: %s: number %d is \"%.*s\": %g to %g are possible", text->path,
                   text->line, what, number, word_length(text->at), text->at, least, most);
        return false;
    }
    text->at = end;
    return true;
}

static bool end_line(struct text *text, const char *what, int numbers)
{
    if (!ends_line(text)) {
        weft_error(text->log, "%s:%d: %s: \"%.*s\" stands behind %d numbers", text->path,
                   text->line, what, word_length(text->at), text->at, numbers);
        return false;
    }
    text->at += *text->at == '\n';
    text->line++;
    return true;
}

// A line of a word and whole numbers.
static bool read_line(struct text *text, const char *word, int count, int32_t most, int32_t *out)
{
    const size_t length = strlen(word);
    if (strncmp(text->at, word, length) != 0 || !is_blank(text->at[length])) {
        weft_error(text->log, "%s:%d: \"%s\" was expected, not \"%.*s\"", text->path, text->line,
                   word, word_length(text->at), text->at);
        return false;
    }
    text->at += length;
    for (int i = 0; i < count; i++) {
        double value;
        if (!read_number(text, word, i + 1, 1.0, most, &value))
            return false;
        if (value != floor(value)) {
            weft_error(text->log, "%s:%d: %s: %g is no whole number", text->path, text->line, word,
                       value);
            return false;
        }
        out[i] = (int32_t)value;
    }
    return end_line(text, word, count);
}

static bool read_head(struct text *text, int32_t picture[2], int32_t cells[2])
{
    int32_t version;
    if (!read_line(text, "weft-cost-map", 1, VERSION, &version) ||
        !read_line(text, "picture", 2, INT32_MAX, picture) ||
        !read_line(text, "cells", 2, WEFT_COST_MAP_CELLS, cells))
        return false;
    for (int axis = 0; axis < 2; axis++)
        if (cells[axis] > picture[axis]) {
            weft_error(text->log, "%s: %d x %d cells of a picture of %d x %d pixels", text->path,
                       cells[0], cells[1], picture[0], picture[1]);
            return false;
        }
    return true;
}

// Cells of another grid, each spread over the part of this picture that it is of.
static bool read_cells(struct text *text, const int32_t cells[2], weft_cost_map *map)
{
    for (int32_t r = 0; r < cells[1]; r++) {
        const double y[2] = {(double)r * map->height / cells[1],
                             (r + 1.0) * map->height / cells[1]};
        for (int32_t c = 0; c < cells[0]; c++) {
            const double x[2] = {(double)c * map->width / cells[0],
                                 (c + 1.0) * map->width / cells[0]};
            double nanoseconds;
            if (!read_number(text, "cells", c + 1, 0.0, most_nanoseconds, &nanoseconds))
                return false;
            weft_cost_map_spread(map, x, y, 1e-9 * nanoseconds);
        }
        if (!end_line(text, "cells", cells[0]))
            return false;
    }
    while (ends_line(text) && *text->at)
        text->at++;
    if (*text->at)
        weft_error(text->log, "%s:%d: \"%.*s\" stands behind %d lines of cells", text->path,
                   text->line, word_length(text->at), text->at, cells[1]);
    return !*text->at;
}

static enum weft_result parse(const struct weft_log *log, const char *path, const char *bytes,
                              int32_t width, int32_t height, weft_cost_map **out)
{
    struct text text = {log, path, weft_text_skip_mark(bytes), 1};
    int32_t picture[2], cells[2];
    if (!read_head(&text, picture, cells))
        return WEFT_ERR_FORMAT;
    weft_cost_map *map = NULL;
    const enum weft_result res = weft_cost_map_create(width, height, &map);
    if (res != WEFT_OK) {
        weft_error(log, "%s: no memory for a cost map", path);
        return res;
    }
    if (!read_cells(&text, cells, map)) {
        weft_cost_map_destroy(&map);
        return WEFT_ERR_FORMAT;
    }
    *out = map;
    return WEFT_OK;
}

// All of it, ended by a NUL, to be freed.
static enum weft_result read_text(const struct weft_log *log, const char *path, char **out)
{
    char *bytes = malloc(WEFT_COST_MAP_BYTES + 1);
    if (!bytes) {
        weft_error(log, "%s: no memory for a cost map", path);
        return WEFT_ERR_MEMORY;
    }
    enum weft_result res = WEFT_ERR_OPEN;
    FILE *file = fopen(path, "rbe");
    size_t size = 0;
    if (file)
        size = fread(bytes, 1, WEFT_COST_MAP_BYTES + 1, file);
    if (!file || ferror(file)) {
        weft_error(log, "%s: %s", path, strerror(errno));
    } else if (size > WEFT_COST_MAP_BYTES) {
        weft_error(log, "%s is no cost map: it has more than %d bytes", path, WEFT_COST_MAP_BYTES);
        res = WEFT_ERR_FORMAT;
    } else if (memchr(bytes, 0, size)) {
        weft_error(log, "%s is no cost map: byte %zu is 0", path,
                   (size_t)((char *)memchr(bytes, 0, size) - bytes));
        res = WEFT_ERR_FORMAT;
    } else {
        bytes[size] = '\0';
        res = WEFT_OK;
    }
    if (file)
        fclose(file);
    if (res == WEFT_OK)
        *out = bytes;
    else
        free(bytes);
    return res;
}

enum weft_result weft_cost_map_load(const struct weft_log *log, const char *path, int32_t width,
                                    int32_t height, weft_cost_map **out)
{
    char *bytes = NULL;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    *out = NULL;
    weft_require(log, path && width > 0 && height > 0);
    res = read_text(log, path, &bytes);
    if (res == WEFT_OK)
        res = parse(log, path, bytes, width, height, out);
    free(bytes);
fail:
    return res;
}

// Whole nanoseconds, which look the same in all locales.
static char *format(const weft_cost_map *map, size_t *size)
{
    char *text = NULL;
    FILE *out = open_memstream(&text, size);
    if (!out)
        return NULL;
    fprintf(out,
            "weft-cost-map %d\npicture %" PRId32 " %" PRId32 "\ncells %" PRId32 " %" PRId32 "\n",
            VERSION, map->width, map->height, map->columns, map->rows);
    for (int32_t r = 0; r < map->rows; r++)
        for (int32_t c = 0; c < map->columns; c++) {
            const double x[2] = {(double)c * map->width / map->columns,
                                 (c + 1.0) * map->width / map->columns};
            const double y[2] = {(double)r * map->height / map->rows,
                                 (r + 1.0) * map->height / map->rows};
            fprintf(out, "%.0f%c", fmin(1e9 * weft_cost_map_sum(map, x, y), most_nanoseconds),
                    c + 1 < map->columns ? ' ' : '\n');
        }
    if (fclose(out) == 0)
        return text;
    free(text);
    return NULL;
}

enum weft_result weft_cost_map_save(const struct weft_log *log, const weft_cost_map *map,
                                    const char *path)
{
    size_t size = 0;
    char *text = format(map, &size);
    if (!text) {
        weft_error(log, "%s: no memory for a cost map", path ? path : "(no path)");
        return WEFT_ERR_MEMORY;
    }
    const enum weft_result res = weft_file_save(log, path, false, text, size);
    free(text);
    return res;
}
