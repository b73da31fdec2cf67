// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/kernel/kernel_file.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "filter/check.h"
#include "filter/kernels/kernel_records.h"
#include "filter/kernels/kernel_table.h"

struct weft_kernel_file {
    struct weft_kernel_table table;
    double *samples;
    char *name; // "table:FILE"
};

static const char prefix[] = "table:";

// The whole of a regular file, with a NUL behind it.
static enum weft_result read_file(const struct weft_log *log, const char *path, char **out)
{
    enum weft_result res = WEFT_ERR_OPEN;
    char *content = NULL;
    struct stat status;
    size_t used = 0;
    // Without O_NONBLOCK a pipe without a writer would hang here.
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0 || fstat(fd, &status)) {
        weft_error(log, "%s: %s", path, strerror(errno));
        goto fail;
    }
    if (!S_ISREG(status.st_mode)) {
        weft_error(log, "%s: not a regular file", path);
        goto fail;
    }
    if (status.st_size > WEFT_KERNEL_FILE_MAX_BYTES) {
        weft_error(log, "%s: %lld bytes, the limit is %d", path, (long long)status.st_size,
                   WEFT_KERNEL_FILE_MAX_BYTES);
        res = WEFT_ERR_LIMIT;
        goto fail;
    }
    const size_t size = (size_t)status.st_size;
    content = malloc(size + 1);
    if (!content) {
        weft_error(log, "%s: no memory for %zu bytes", path, size);
        res = WEFT_ERR_MEMORY;
        goto fail;
    }
    while (used < size) {
        const ssize_t n = read(fd, content + used, size - used);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            weft_error(log, "%s: %s", path, strerror(errno));
        if (n < 0)
            goto fail;
        if (n == 0)
            break;
        used += (size_t)n;
    }
    content[used] = '\0';
    *out = content;
    content = NULL;
    res = WEFT_OK;
    if (strlen(*out) != used) {
        weft_error(log, "%s: byte %zu is NUL, this is no text", path, strlen(*out));
        free(*out);
        *out = NULL;
        res = WEFT_ERR_FORMAT;
    }
fail:
    free(content);
    if (fd >= 0)
        close(fd);
    return res;
}

struct parser {
    const struct weft_log *log;
    const char *path;
    int line;
    char *rest;
    struct weft_kernel_table_params table;
    double *samples;
};

// The next word, cut off in place; NULL at the end.
static char *next_word(struct parser *p)
{
    for (;;) {
        p->rest += strspn(p->rest, " \t\r\f\v");
        if (*p->rest == '#')
            p->rest += strcspn(p->rest, "\n");
        if (*p->rest != '\n')
            break;
        p->line++;
        p->rest++;
    }
    if (!*p->rest)
        return NULL;
    char *word = p->rest;
    // The line end stays for the next call to count.
    p->rest += strcspn(p->rest, " \t\r\f\v\n#");
    return word;
}

// Words end where `rest` is; numbers end there by themselves.
static bool is_word(const struct parser *p, const char *word, const char *expected)
{
    const size_t length = (size_t)(p->rest - word);
    return strlen(expected) == length && !memcmp(word, expected, length);
}

static enum weft_result bad_word(const struct parser *p, const char *word, const char *what)
{
    const int length = p->rest - word < 40 ? (int)(p->rest - word) : 40;
    weft_error(p->log, "%s:%d: '%.*s' is not %s", p->path, p->line, word ? length : 0,
               word ? word : "", what);
    return WEFT_ERR_FORMAT;
}

static bool is_number(const struct parser *p, const char *word, double *out)
{
    return word && weft_number_parse(word, out) == p->rest;
}

static enum weft_result parse_word(struct parser *p, char *word)
{
    double number;
    if (is_word(p, word, "support")) {
        word = next_word(p);
        if (!is_number(p, word, &p->table.support) || !(p->table.support > 0.0) ||
            p->table.support > 0.5 * WEFT_KERNEL_MAX_WIDTH)
            return bad_word(p, word, "a half-width in (0, 8]");
    } else if (is_word(p, word, "half") || is_word(p, word, "whole")) {
        p->table.whole = *word == 'w';
    } else if (is_word(p, word, "linear") || is_word(p, word, "cubic")) {
        p->table.between = *word == 'c' ? WEFT_KERNEL_BETWEEN_CUBIC : WEFT_KERNEL_BETWEEN_LINEAR;
    } else if (is_number(p, word, &number)) {
        if (p->table.count == WEFT_KERNEL_TABLE_MAX_SAMPLES) {
            weft_error(p->log, "%s:%d: more than %d samples", p->path, p->line,
                       WEFT_KERNEL_TABLE_MAX_SAMPLES);
            return WEFT_ERR_LIMIT;
        }
        p->samples[p->table.count++] = number;
    } else {
        return bad_word(p, word, "support, half, whole, linear, cubic or a finite number");
    }
    return WEFT_OK;
}

static enum weft_result parse(struct parser *p)
{
    enum weft_result res = WEFT_OK;
    for (char *word = next_word(p); word && !res; word = res ? NULL : next_word(p))
        res = parse_word(p, word);
    if (res)
        return res;
    if (!(p->table.support > 0.0) || p->table.count < 2) {
        weft_error(p->log, "%s: %s", p->path,
                   p->table.count < 2 ? "fewer than 2 samples" : "no support is given");
        return WEFT_ERR_FORMAT;
    }
    return WEFT_OK;
}

static enum weft_result load(const struct weft_log *log, const char *path, weft_kernel_file *file)
{
    char *content = NULL;
    enum weft_result res = read_file(log, path, &content);
    if (res)
        return res;
    struct parser p = {.log = log, .path = path, .line = 1};
    p.rest = content + (weft_text_skip_mark(content) - content);
    // A number takes two bytes with the space behind it.
    const size_t most = strlen(content) / 2 + 1;
    p.samples = file->samples = malloc(most * sizeof *file->samples);
    res = WEFT_ERR_MEMORY;
    if (!file->samples) {
        weft_error(log, "%s: no memory for %zu samples", path, most);
        goto fail;
    }
    res = parse(&p);
    if (res)
        goto fail;
    p.table.log = log;
    p.table.name = file->name;
    p.table.samples = file->samples;
    res = weft_kernel_table_init(&p.table, &file->table);
fail:
    free(content);
    return res;
}

// "table:FILE" of text without the flags behind it.
static char *file_name(const char *text, struct weft_kernel_flags *flags)
{
    size_t length = 0;
    while (!weft_kernel_read_flags(text + length, flags))
        length++;
    return strndup(text, length);
}

enum weft_result weft_kernel_load(const struct weft_log *log, const char *text,
                                  struct weft_kernel *out, weft_kernel_file **file)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_kernel_file *f = NULL;
    struct weft_kernel_flags flags = {0};
    weft_require(log, text && out && file);
    *file = NULL;
    *out = (struct weft_kernel){0};
    if (strncmp(text, prefix, strlen(prefix)))
        return weft_kernel_parse(log, text, out);
    res = WEFT_ERR_MEMORY;
    f = calloc(1, sizeof *f);
    if (!f || !(f->name = file_name(text, &flags))) {
        weft_error(log, "kernel file: no memory");
        goto fail;
    }
    res = load(log, f->name + strlen(prefix), f);
    weft_text_clean(f->name, false);
    if (!res)
        res = weft_kernel_create(log, &f->table.info, NULL, out);
    if (!res)
        res = weft_kernel_apply_flags(log, flags, out);
    if (res)
        goto fail;
    *file = f;
    return WEFT_OK;
fail:
    weft_kernel_file_destroy(&f);
    return res;
}

void weft_kernel_file_destroy(weft_kernel_file **file)
{
    if (!file || !*file)
        return;
    free((*file)->samples);
    free((*file)->name);
    free(*file);
    *file = NULL;
}
