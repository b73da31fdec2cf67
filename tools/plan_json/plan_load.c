// SPDX-License-Identifier: BSD-3-Clause
// Files to JSON values, within limits.
#include "tools/plan_json/plan_json.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tools/common/report.h"

enum { MAX_FILE_BYTES = 64 << 20 };
// What jansson takes for a list or an object, and for any other value, both rounded up.
static const uint64_t container_bytes = 320, value_bytes = 96;

// What is opened without waiting, so that a pipe needs no writer, has to be waited for.
static bool read_some(int fd, char *to, size_t size, ssize_t *count)
{
    struct pollfd ready = {.fd = fd, .events = POLLIN};
    *count = -1;
    if (poll(&ready, 1, -1) > 0)
        *count = read(fd, to, size);
    return *count >= 0 || (errno == EINTR);
}

static enum weft_result read_bytes(int fd, const char *path, char **out, size_t *size)
{
    size_t room = 0;
    ssize_t count;
    do {
        if (*size == room) {
            room = room ? 2 * room : 1 << 16;
            char *larger = realloc(*out, room);
            if (!larger) {
                report_error("out of memory for %zu bytes of %s", room, path);
                return WEFT_ERR_MEMORY;
            }
            *out = larger;
        }
        if (!read_some(fd, *out + *size, room - *size, &count)) {
            report_error("%s cannot be read: %s", path, strerror(errno));
            return WEFT_ERR_OPEN;
        }
        *size += count > 0 ? (size_t)count : 0;
        if (*size > MAX_FILE_BYTES) {
            report_error("%s has more than %d bytes, the limit for a plan", path, MAX_FILE_BYTES);
            return WEFT_ERR_LIMIT;
        }
    } while (count != 0);
    return WEFT_OK;
}

static enum weft_result read_file(const char *path, char **out, size_t *size)
{
    const bool standard = strcmp(path, "-") == 0;
    const int fd = standard ? STDIN_FILENO : open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0) {
        report_error("%s cannot be read: %s", path, strerror(errno));
        return WEFT_ERR_OPEN;
    }
    const enum weft_result res = read_bytes(fd, standard ? "standard input" : path, out, size);
    if (!standard)
        close(fd);
    return res;
}

// JSON of a hundred bytes takes thousands in memory: this is known before it does.
static enum weft_result check_memory(const char *path, const char *text, size_t size,
                                     uint64_t limit)
{
    uint64_t bytes = 0;
    for (size_t i = 0; i < size; i++)
        bytes += text[i] == '[' || text[i] == '{'   ? container_bytes
                 : text[i] == ',' || text[i] == ':' ? value_bytes
                                                    : 0;
    if (bytes <= limit)
        return WEFT_OK;
    report_error("%s: so many values take %llu bytes, over the limit of %llu", path,
                 (unsigned long long)bytes, (unsigned long long)limit);
    return WEFT_ERR_LIMIT;
}

static enum weft_result parse(const char *path, const char *text, size_t size, json_t **out)
{
    json_error_t error;
    const size_t mark = size >= 3 ? (size_t)(weft_text_skip_mark(text) - text) : 0;
    *out = json_loadb(text + mark, size - mark, JSON_REJECT_DUPLICATES, &error);
    if (*out)
        return WEFT_OK;
    report_error("%s is no JSON: line %d: %s", path, error.line, error.text);
    return json_error_code(&error) == json_error_out_of_memory ? WEFT_ERR_MEMORY : WEFT_ERR_FORMAT;
}

enum weft_result plan_json_load(const char *path, uint64_t memory_bytes, json_t **out)
{
    const char *name = strcmp(path, "-") == 0 ? "standard input" : path;
    char *text = NULL;
    size_t size = 0;
    *out = NULL;
    enum weft_result res = read_file(path, &text, &size);
    if (res == WEFT_OK)
        res = check_memory(name, text, size, memory_bytes);
    if (res == WEFT_OK)
        res = parse(name, text, size, out);
    free(text);
    return res;
}
