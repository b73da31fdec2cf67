// SPDX-License-Identifier: BSD-3-Clause
// The format: http://teem.sourceforge.net/nrrd/format.html, sections 3 and 5.
#include "tiles/readers/dense/nrrd_text.h"

#include <ctype.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

enum { LONGEST = 1 << 20, MOST_FILES = 1 << 16 };

void weft_nrrd_text_clear(struct weft_nrrd_text *text)
{
    free(text->header);
    free(text->file);
    free(text->room);
    *text = (struct weft_nrrd_text){0};
}

static enum weft_result fail_memory(struct weft_server *server)
{
    return weft_server_fail(server, WEFT_ERR_LIMIT, "no memory for the header");
}

// The file's first bytes, with a NUL behind them.
static ssize_t read_start(struct weft_server *server, char *out)
{
    size_t size = 0;
    while (size < LONGEST) {
        const ssize_t n = pread(server->input_fd, out + size, LONGEST - size, (off_t)size);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return -1;
        if (n == 0)
            break;
        size += (size_t)n;
    }
    out[size] = 0;
    return (ssize_t)size;
}

// The end of the line that starts here; *next: where the one behind it does.
static char *end_line(char *line, char *end, char **next)
{
    char *feed = memchr(line, '\n', (size_t)(end - line));
    *next = feed ? feed + 1 : end;
    char *last = feed ? feed : end;
    while (last > line && (last[-1] == '\r' || last[-1] == ' '))
        last--;
    return last;
}

// Behind "data file:" and "datafile:"; NULL for any other field, and for keys with values.
static char *data_file_value(char *line)
{
    char *colon = strchr(line, ':');
    if (!colon || colon[1] == '=')
        return NULL;
    char name[16];
    size_t length = 0;
    for (const char *at = line; at < colon; at++) {
        if (isspace((unsigned char)*at))
            continue;
        if (length == sizeof name - 1)
            return NULL;
        name[length++] = *at;
    }
    name[length] = 0;
    if (strcasecmp(name, "datafile") != 0)
        return NULL;
    return colon + 1 + strspn(colon + 1, " \t");
}

static enum weft_result add_file(struct weft_server *server, struct weft_nrrd_text *out, char *name)
{
    if (out->file_count == MOST_FILES)
        return weft_server_fail(server, WEFT_ERR_LIMIT, "the header names more than %d files",
                                MOST_FILES);
    if ((out->file_count & (out->file_count - 1)) == 0) {
        char **more = realloc(out->file, (2 * out->file_count + 1) * sizeof *more);
        if (!more)
            return fail_memory(server);
        out->file = more;
    }
    out->file[out->file_count++] = name;
    return WEFT_OK;
}

// One "%d", maybe with a width as in "%03d", and nothing else that printf obeys.
static bool is_pattern(const char *name)
{
    const char *percent = strchr(name, '%');
    if (!percent || strchr(percent + 1, '%'))
        return false;
    const size_t digits = strspn(percent + 1, "0123456789");
    return digits <= 2 && percent[1 + digits] == 'd';
}

// "slice%03d.raw 1 30 1": a number for each file.
static enum weft_result add_numbered(struct weft_server *server, struct weft_nrrd_text *out,
                                     char *value)
{
    long first, last, step;
    int dimension, length = 0;
    char pattern[256];
    const int fields =
        sscanf(value, "%255s %ld %ld %ld%n %d", pattern, &first, &last, &step, &length, &dimension);
    if (fields < 4 || !is_pattern(pattern) || step == 0 || labs(first) > 1000000 ||
        labs(last) > 1000000 || labs(step) > 1000000 || (last - first) / step < 0 ||
        (last - first) / step >= MOST_FILES)
        return weft_server_fail(server, WEFT_ERR_FORMAT,
                                "its files are '%.200s', which is not NAME%%d FIRST LAST STEP of "
                                "up to %d files",
                                value, MOST_FILES);
    const size_t count = (size_t)((last - first) / step) + 1, size = strlen(pattern) + 128;
    out->room = calloc(count, size);
    if (!out->room)
        return fail_memory(server);
        // The pattern was checked; the compiler cannot know.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
    for (size_t i = 0; i < count; i++) {
        snprintf(out->room + i * size, size, pattern, (int)(first + (long)i * step));
        if (add_file(server, out, out->room + i * size) != WEFT_OK)
            return (enum weft_result)server->answer.result;
    }
#pragma GCC diagnostic pop
    return WEFT_OK;
}

// "LIST", and a name on each line up to the header's end.
static enum weft_result add_list(struct weft_server *server, struct weft_nrrd_text *out,
                                 const char *lines)
{
    char *next;
    out->room = strdup(lines);
    if (!out->room)
        return fail_memory(server);
    char *end = out->room + strlen(out->room);
    for (char *line = out->room; line < end; line = next) {
        char *last = end_line(line, end, &next);
        if (last == line)
            break;
        *last = 0;
        if (add_file(server, out, line) != WEFT_OK)
            return (enum weft_result)server->answer.result;
    }
    return WEFT_OK;
}

static enum weft_result add_files(struct weft_server *server, struct weft_nrrd_text *out,
                                  char *value, const char *lines)
{
    if (out->file_count)
        return weft_server_fail(server, WEFT_ERR_FORMAT, "the header names its file twice");
    if (!strncmp(value, "LIST", 4) && (!value[4] || value[4] == ' '))
        return add_list(server, out, lines);
    if (strchr(value, '%'))
        return add_numbered(server, out, value);
    out->room = strdup(value);
    return out->room ? add_file(server, out, out->room) : fail_memory(server);
}

// Copies lines up to the empty one that ends the header.
static enum weft_result take_lines(struct weft_server *server, char *start, size_t size,
                                   struct weft_nrrd_text *out)
{
    char *end = start + size, *next, *to = out->header;
    bool listed = false, ended = false;
    for (char *line = start; line < end && !ended; line = next) {
        char *last = end_line(line, end, &next);
        out->bytes = (size_t)(next - start);
        ended = last == line;
        const bool has_feed = next > line && next[-1] == '\n';
        if (ended || listed)
            continue;
        char saved = *last;
        *last = 0;
        char *value = data_file_value(line);
        if (!value) {
            to = stpcpy(to, line);
            *to++ = '\n';
            *last = saved;
            continue;
        }
        listed = !strncmp(value, "LIST", 4);
        if (add_files(server, out, value, has_feed ? next : "") != WEFT_OK)
            return (enum weft_result)server->answer.result;
        *last = saved;
    }
    *to = 0;
    if (!ended && !out->file_count)
        return weft_server_fail(server, WEFT_ERR_FORMAT,
                                "the header's end is not within its first %zu bytes (cut short?)",
                                size);
    return WEFT_OK;
}

enum weft_result weft_nrrd_text_read(struct weft_server *server, struct weft_nrrd_text *out)
{
    *out = (struct weft_nrrd_text){0};
    char *start = malloc(LONGEST + 1);
    enum weft_result res;
    ssize_t size = start ? read_start(server, start) : 0;
    out->header = start && size >= 0 ? malloc((size_t)size + 2) : NULL;
    if (size < 0)
        res = weft_server_fail(server, WEFT_ERR_OPEN, "cannot read the file: %s", strerror(errno));
    else if (!out->header)
        res = fail_memory(server);
    else
        res = take_lines(server, start, (size_t)size, out);
    free(start);
    return res;
}
