// SPDX-License-Identifier: BSD-3-Clause
// The frames of `weft accumulate`: operands become names, in the order in which they count.
#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "tools/accumulate/job.h"
#include "tools/common/numbered.h"
#include "tools/common/paths.h"
#include "tools/common/report.h"

static enum weft_result no_memory(const struct accumulate_job *job)
{
    report_error("out of memory for the names of %lld frames", (long long)job->frame_count);
    return WEFT_ERR_MEMORY;
}

// Takes the name; NULL: there was no memory for it.
static enum weft_result add_name(struct accumulate_job *job, char *path)
{
    if (path && job->frame_count == WEFT_ACCUMULATE_MAX_FRAMES) {
        report_error("more than %d frames, at %s", WEFT_ACCUMULATE_MAX_FRAMES, path);
        free(path);
        return WEFT_ERR_LIMIT;
    }
    if (path && job->frame_count == job->frame_room) {
        const int64_t room = job->frame_room ? 2 * job->frame_room : 64;
        struct accumulate_frame *list = realloc(job->frame, (size_t)room * sizeof *list);
        if (!list) {
            free(path);
            return no_memory(job);
        }
        job->frame = list;
        job->frame_room = room;
    }
    if (!path)
        return no_memory(job);
    job->frame[job->frame_count++] = (struct accumulate_frame){.path = path, .weight = 1.0};
    return WEFT_OK;
}

// ---- patterns -----------------------------------------------------------------------------------

// The number of a name that the pattern makes; -1: it makes no such name. `pattern` and `name` are
// both without the folder.
static int64_t number_of(const char *pattern, const char *name)
{
    const char *percent = pattern;
    size_t before = 0; // characters of the name before the number
    while (*percent && (*percent != '%' || percent[1] == '%')) {
        percent += *percent == '%' ? 2 : 1;
        before++;
    }
    if (strlen(name) <= before || name[before] < '0' || name[before] > '9')
        return -1;
    const size_t digits = strspn(name + before, "0123456789");
    const long long number = digits < 16 ? strtoll(name + before, NULL, 10) : -1;
    char *again = number >= 0 ? numbered_format(pattern, number) : NULL;
    const bool same = again && strcmp(again, name) == 0;
    free(again);
    return same ? number : -1;
}

static enum weft_result fail_pattern(const char *pattern, const char *folder)
{
    report_error("%s: no file has such a name in %s", pattern, folder);
    return WEFT_ERR_OPEN;
}

// The lowest and the highest number that a file has.
static enum weft_result find_numbers(const char *pattern, struct numbered_span *out)
{
    const char *base = paths_base_name(pattern);
    char *folder = base == pattern ? strdup(".") : strndup(pattern, (size_t)(base - pattern));
    DIR *list = folder ? opendir(folder) : NULL;
    enum weft_result res = WEFT_OK;
    *out = (struct numbered_span){.first = INT64_MAX, .last = -1, .step = 1};
    if (!list) {
        report_error("%s: folder %s: %s", pattern, folder ? folder : "", strerror(errno));
        free(folder);
        return WEFT_ERR_OPEN;
    }
    for (const struct dirent *entry = readdir(list); entry; entry = readdir(list)) {
        const int64_t number = number_of(base, entry->d_name);
        if (number < 0)
            continue;
        out->first = number < out->first ? number : out->first;
        out->last = number > out->last ? number : out->last;
    }
    if (out->last < 0)
        res = fail_pattern(pattern, folder);
    closedir(list);
    free(folder);
    return res;
}

// All numbers from the lowest to the highest, holes too: they are frames that cannot be read.
static enum weft_result add_pattern(struct accumulate_job *job, const char *pattern)
{
    const struct option_value *frames = &job->option[ACCUMULATE_FRAMES];
    struct numbered_span span;
    enum weft_result res = numbered_check("", pattern, true);
    if (res == WEFT_OK && frames->given) {
        res = numbered_read_span(frames->text, WEFT_ACCUMULATE_MAX_FRAMES, &span);
    } else if (res == WEFT_OK && numbered_is(paths_base_name(pattern))) {
        res = find_numbers(pattern, &span);
    } else if (res == WEFT_OK) {
        report_error("%s: where a folder is numbered --frames FIRST-LAST must say how", pattern);
        res = WEFT_ERR_ARGUMENT;
    }
    if (res == WEFT_OK && (span.last - span.first) / span.step >= WEFT_ACCUMULATE_MAX_FRAMES) {
        report_error("%s: the numbers are from %lld to %lld, which are more than %d frames",
                     pattern, (long long)span.first, (long long)span.last,
                     WEFT_ACCUMULATE_MAX_FRAMES);
        res = WEFT_ERR_LIMIT;
    }
    for (int64_t n = span.first; res == WEFT_OK && n <= span.last; n += span.step)
        res = add_name(job, numbered_format(pattern, n));
    return res;
}

// ---- lists --------------------------------------------------------------------------------------

static char *read_all(FILE *in, size_t *size)
{
    size_t room = 1 << 16;
    char *text = malloc(room);
    *size = 0;
    while (text) {
        *size += fread(text + *size, 1, room - *size, in);
        if (*size < room)
            return text;
        char *more = realloc(text, room *= 2);
        if (!more)
            free(text);
        text = more;
    }
    return NULL;
}

// Names end with NUL where the list has any, and otherwise with line ends of either kind.
static enum weft_result add_names(struct accumulate_job *job, const char *text, size_t size)
{
    const char separator = memchr(text, 0, size) ? 0 : '\n';
    enum weft_result res = WEFT_OK;
    for (const char *at = text, *end = text + size; at < end && res == WEFT_OK;) {
        const char *stop = memchr(at, separator, (size_t)(end - at));
        size_t length = (size_t)((stop ? stop : end) - at);
        const char *next = stop ? stop + 1 : end;
        if (separator && length && at[length - 1] == '\r')
            length--;
        if (length)
            res = add_name(job, strndup(at, length));
        at = next;
    }
    return res;
}

static enum weft_result add_list(struct accumulate_job *job)
{
    size_t size;
    char *text = read_all(stdin, &size);
    const int64_t before = job->frame_count;
    enum weft_result res = text ? WEFT_OK : no_memory(job);
    if (res == WEFT_OK && ferror(stdin)) {
        report_error("the list of frames on standard input cannot be read: %s", strerror(errno));
        res = WEFT_ERR_OPEN;
    }
    if (res == WEFT_OK)
        res = add_names(job, text, size);
    if (res == WEFT_OK && job->frame_count == before) {
        report_error("the list of frames on standard input is empty");
        res = WEFT_ERR_OPEN;
    }
    free(text);
    return res;
}

// ---- all ----------------------------------------------------------------------------------------

// A percent sign may be a letter of a file's name.
static bool is_pattern(const char *operand)
{
    struct stat status;
    return numbered_is(operand) && lstat(operand, &status) != 0;
}

static enum weft_result check_operands(const struct accumulate_job *job)
{
    int lists = 0, patterns = 0;
    for (const char *const *operand = job->operands; *operand; operand++) {
        lists += strcmp(*operand, "-") == 0;
        patterns += is_pattern(*operand);
    }
    if (lists > 1)
        report_error("-, the list of frames on standard input, is given %d times", lists);
    else if (job->option[ACCUMULATE_FRAMES].given && !patterns)
        report_error("--frames needs a name with the frame's number, as frame_%%04d.exr");
    else
        return WEFT_OK;
    return WEFT_ERR_ARGUMENT;
}

static int compare_paths(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

// They count as often as they are named: whether that is meant nobody knows.
static enum weft_result warn_of_repeats(const struct accumulate_job *job)
{
    const size_t count = (size_t)job->frame_count;
    char **path = malloc(count * sizeof *path);
    const char *first = NULL;
    int64_t repeats = 0;
    if (!path)
        return no_memory(job);
    for (size_t i = 0; i < count; i++)
        path[i] = job->frame[i].path;
    qsort(path, count, sizeof *path, compare_paths);
    for (size_t i = 1; i < count; i++) {
        if (strcmp(path[i], path[i - 1]) != 0)
            continue;
        first = first ? first : path[i];
        repeats++;
    }
    if (repeats == 1)
        report_warning("%s is given twice, and counts twice", first);
    else if (repeats)
        report_warning("%lld names are given again, the first is %s: each counts as often as it "
                       "is given",
                       (long long)repeats, first);
    free(path);
    return WEFT_OK;
}

enum weft_result accumulate_list_frames(struct accumulate_job *job)
{
    if (job->joins)
        return WEFT_OK;
    enum weft_result res = check_operands(job);
    for (const char *const *operand = job->operands; res == WEFT_OK && *operand; operand++)
        res = strcmp(*operand, "-") == 0 ? add_list(job)
              : is_pattern(*operand)     ? add_pattern(job, *operand)
                                         : add_name(job, strdup(*operand));
    return res == WEFT_OK ? warn_of_repeats(job) : res;
}
