// SPDX-License-Identifier: BSD-3-Clause
// Tables of points: where lines are, and the numbers in them.
#include <errno.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "tools/common/report.h"
#include "tools/probe/job.h"
#include "tools/probe/numbers.h"

enum { LONGEST_LINE = 1 << 20, CHUNK = 8192 };

// ---- text ---------------------------------------------------------------------------------------

static enum weft_result grow(struct probe_table *t, size_t *room)
{
    const size_t wanted = *room ? 2 * *room : 1 << 16;
    char *text = wanted > *room ? realloc(t->text, wanted) : NULL;
    if (!text) {
        report_error("%s: not enough memory for more than %zu bytes", t->name, *room);
        return WEFT_ERR_MEMORY;
    }
    t->text = text;
    *room = wanted;
    return WEFT_OK;
}

static enum weft_result read_all(FILE *file, struct probe_table *t)
{
    size_t room = 0;
    enum weft_result res = WEFT_OK;
    while (res == WEFT_OK && !feof(file)) {
        if (t->size == room)
            res = grow(t, &room);
        if (res != WEFT_OK)
            break;
        t->size += fread(t->text + t->size, 1, room - t->size, file);
        if (ferror(file)) {
            report_error("%s: cannot be read: %s", t->name, strerror(errno));
            res = WEFT_ERR_OPEN;
        }
    }
    return res;
}

static enum weft_result read_text(const char *path, struct probe_table *t)
{
    if (strcmp(path, "-") == 0)
        return read_all(stdin, t);
    FILE *file = fopen(path, "rb");
    if (!file) {
        report_error("%s: cannot be opened: %s", path, strerror(errno));
        return WEFT_ERR_OPEN;
    }
    const enum weft_result res = read_all(file, t);
    fclose(file);
    return res;
}

// ---- lines --------------------------------------------------------------------------------------

static size_t line_number(const struct probe_table *t, const char *at)
{
    size_t number = 1;
    for (const char *c = t->text; (c = memchr(c, '\n', (size_t)(at - c))) != NULL; c++)
        number++;
    return number;
}

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r';
}

// Without blanks around it.
static struct probe_line trim(const char *text, const char *end)
{
    while (text < end && is_blank(*text))
        text++;
    while (text < end && is_blank(end[-1]))
        end--;
    return (struct probe_line){text, (uint32_t)(end - text)};
}

static enum weft_result add_line(struct probe_table *t, struct probe_line line)
{
    if (t->count == t->capacity) {
        const size_t capacity = t->capacity ? 2 * t->capacity : 1024;
        void *lines = realloc(t->line, capacity * sizeof *t->line);
        if (!lines) {
            report_error("%s: not enough memory for %zu lines", t->name, capacity);
            return WEFT_ERR_MEMORY;
        }
        t->line = lines;
        t->capacity = capacity;
    }
    t->line[t->count++] = line;
    return WEFT_OK;
}

static enum weft_result find_lines(struct probe_table *t)
{
    const char *at = t->text, *end = at ? at + t->size : at;
    if (t->size >= 3 && memcmp(at, "\xef\xbb\xbf", 3) == 0) // of UTF-8
        at += 3;
    enum weft_result res = WEFT_OK;
    while (res == WEFT_OK && at < end) {
        const char *stop = memchr(at, '\n', (size_t)(end - at));
        stop = stop ? stop : end;
        if (stop - at > LONGEST_LINE) {
            report_error("%s, line %zu: %zu bytes long: at most %d are read", t->name,
                         line_number(t, at), (size_t)(stop - at), LONGEST_LINE);
            return WEFT_ERR_LIMIT;
        }
        const struct probe_line line = trim(at, stop);
        if (line.size && line.text[0] != '#')
            res = add_line(t, line);
        at = stop + 1;
    }
    return res;
}

// ---- fields -------------------------------------------------------------------------------------

// Commas stand in lines that semicolons or tabs separate, not the other way round; tabs beside
// spaces are blanks.
static char find_separator(const struct probe_line *line)
{
    const char *tab = memchr(line->text, '\t', line->size);
    if (memchr(line->text, ';', line->size))
        return ';';
    if (tab && tab[-1] != ' ' && tab[1] != ' ') // lines have no blanks around them
        return '\t';
    return memchr(line->text, ',', line->size) ? ',' : ' ';
}

// The next field from *at on, without blanks around it; false: there is none.
static bool next_field(char separator, const char **at, const char *end, struct probe_line *out)
{
    const char *from = *at, *stop;
    if (!from)
        return false;
    if (separator == ' ') {
        while (from < end && is_blank(*from))
            from++;
        if (from == end)
            return false;
        for (stop = from; stop < end && !is_blank(*stop);)
            stop++;
        *at = stop;
    } else {
        stop = memchr(from, separator, (size_t)(end - from));
        *at = stop ? stop + 1 : NULL;
        stop = stop ? stop : end;
    }
    *out = trim(from, stop);
    return true;
}

static bool parse_field(const struct probe_line *field, double *out)
{
    const char *end = field->text + field->size;
    return field->size && numbers_parse(field->text, end, out) == end;
}

static bool is_named(const struct probe_line *field, char name)
{
    const bool quoted = field->size == 3 && field->text[0] == '"' && field->text[2] == '"';
    return (field->size == 1 || quoted) && (field->text[quoted] | 0x20) == name;
}

// Looks at the first line: what separates its fields, and whether it names columns.
static void find_columns(struct probe_table *t)
{
    const struct probe_line first = t->line[0];
    const char *at = first.text, *end = at + first.size;
    struct probe_line field;
    double number;
    bool named = false;
    int found[3] = {-1, -1, -1};
    t->separator = find_separator(&first);
    for (t->columns = 0; next_field(t->separator, &at, end, &field); t->columns++) {
        named = named || (t->columns == 0 && !parse_field(&field, &number));
        for (int a = 0; a < 3; a++)
            if (is_named(&field, "xyz"[a]) && found[a] < 0)
                found[a] = t->columns;
        named = named || found[0] >= 0 || found[1] >= 0 || found[2] >= 0;
    }
    const bool all = found[0] >= 0 && found[1] >= 0 && found[2] >= 0;
    for (int a = 0; a < 3; a++)
        t->column[a] = all ? found[a] : a;
    if (!named)
        return;
    t->header = first;
    t->count--;
    memmove(t->line, t->line + 1, t->count * sizeof *t->line);
}

// ---- numbers ------------------------------------------------------------------------------------

struct parsing {
    struct probe_table *table;
    _Atomic size_t bad; // the first line that is
};

// Returns the column of a field that is none, from 0; -1: all are there.
static int parse_line(const struct probe_table *t, const struct probe_line *line, double out[3])
{
    const char *at = line->text, *end = at + line->size;
    struct probe_line field;
    int last = t->column[0] > t->column[1] ? t->column[0] : t->column[1];
    last = t->column[2] > last ? t->column[2] : last;
    for (int c = 0; c <= last; c++) {
        if (!next_field(t->separator, &at, end, &field))
            return c;
        for (int a = 0; a < 3; a++)
            if (c == t->column[a] && !parse_field(&field, &out[a]))
                return c;
    }
    return -1;
}

static void parse_chunk(void *priv, size_t chunk)
{
    struct parsing *p = priv;
    struct probe_table *t = p->table;
    const size_t end = (chunk + 1) * CHUNK < t->count ? (chunk + 1) * CHUNK : t->count;
    for (size_t i = chunk * CHUNK; i < end; i++) {
        if (parse_line(t, &t->line[i], t->position[i]) < 0)
            continue;
        size_t known = atomic_load(&p->bad);
        while (i < known && !atomic_compare_exchange_weak(&p->bad, &known, i))
            ;
        return;
    }
}

static enum weft_result tell_bad(const struct probe_table *t, size_t bad)
{
    const struct probe_line *line = &t->line[bad];
    double position[3];
    report_error("%s, line %zu: column %d is no number: '%.*s'; a point is x, y and z, and fields "
                 "are separated by %s",
                 t->name, line_number(t, line->text), parse_line(t, line, position) + 1,
                 line->size < 60 ? (int)line->size : 60, line->text,
                 t->separator == ' '    ? "spaces"
                 : t->separator == '\t' ? "tabs"
                 : t->separator == ','  ? "commas"
                                        : "semicolons");
    return WEFT_ERR_FORMAT;
}

static enum weft_result parse_lines(struct probe_table *t, int threads)
{
    struct parsing p = {.table = t, .bad = SIZE_MAX};
    t->position = malloc((t->count + 1) * sizeof *t->position);
    if (!t->position) {
        report_error("%s: not enough memory for %zu points", t->name, t->count);
        return WEFT_ERR_MEMORY;
    }
    probe_parallel(threads, (t->count + CHUNK - 1) / CHUNK, parse_chunk, &p);
    const size_t bad = atomic_load(&p.bad);
    return bad == SIZE_MAX ? WEFT_OK : tell_bad(t, bad);
}

enum weft_result probe_table_read(const char *path, int threads, struct probe_table *t)
{
    *t = (struct probe_table){.name = strcmp(path, "-") ? path : "standard input"};
    enum weft_result res = read_text(path, t);
    if (res == WEFT_OK)
        res = find_lines(t);
    if (res == WEFT_OK && t->count)
        find_columns(t);
    if (res == WEFT_OK && !t->count && !t->header.text) {
        report_error("%s: there is no point in it", t->name);
        res = WEFT_ERR_FORMAT;
    }
    if (res == WEFT_OK && !t->count)
        report_warning("%s: there is no point in it, only a line of names", t->name);
    return res == WEFT_OK ? parse_lines(t, threads) : res;
}

void probe_table_clear(struct probe_table *t)
{
    free(t->text);
    free(t->line);
    free(t->position);
    *t = (struct probe_table){0};
}
