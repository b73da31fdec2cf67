// SPDX-License-Identifier: BSD-3-Clause
#include "tools/accumulate/join.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "tools/accumulate/settings.h"
#include "tools/accumulate/state.h"
#include "tools/common/paths.h"
#include "tools/common/report.h"

static enum weft_result no_memory(void)
{
    report_error("out of memory for the names of frames");
    return WEFT_ERR_MEMORY;
}

// ---- what the operands are ----------------------------------------------------------------------

static enum weft_result find_states(struct accumulate_job *job)
{
    const char *state = NULL, *frame = NULL;
    for (const char *const *operand = job->operands; *operand; operand++) {
        if (state_file_is(*operand))
            state = state ? state : *operand;
        else
            frame = frame ? frame : *operand;
    }
    job->joins = state != NULL;
    if (!state || !frame)
        return WEFT_OK;
    report_error(
        "%s is a state and %s is none: accumulate frames with --resume, and join the states", state,
        frame);
    return WEFT_ERR_ARGUMENT;
}

// ---- their frames -------------------------------------------------------------------------------

// The name with its folder, without "./" and doubled slashes; NULL: no memory.
static char *full_name(const char *folder, const char *name)
{
    char *path = NULL;
    if (asprintf(&path, "%s/%s", *name == '/' ? "" : folder, name) < 0)
        return NULL;
    char *out = path;
    for (const char *in = path; *in;) {
        if (in[0] == '/' && in[1] == '/')
            in++;
        else if (in[0] == '/' && in[1] == '.' && in[2] == '/')
            in += 2;
        else
            *out++ = *in++;
    }
    *out = 0;
    return path;
}

// The frames of state number `state` behind those that are there.
static enum weft_result add_frames(struct accumulate_job *job, int state,
                                   const struct state_content *content)
{
    const size_t count = (size_t)job->frame_count + content->frame_count;
    struct accumulate_frame *list = realloc(job->frame, (count + 1) * sizeof *list);
    if (!list)
        return no_memory();
    job->frame = list;
    job->frame_room = (int64_t)count + 1;
    for (size_t i = 0; i < content->frame_count; i++) {
        const struct state_frame *held = &content->frames[i];
        struct accumulate_frame *frame = &job->frame[job->frame_count];
        *frame = (struct accumulate_frame){.path = full_name(content->folder, held->name),
                                           .weight = held->weight,
                                           .stamp = held->stamp,
                                           .state = state,
                                           .done = true};
        if (!frame->path)
            return no_memory();
        job->frame_count++;
        if (held->problem[0] && !(frame->problem = strdup(held->problem)))
            return no_memory();
        if (held->problem[0])
            job->skipped++;
        else if (job->added++ == 0)
            job->first = job->frame_count - 1;
    }
    return WEFT_OK;
}

static int compare_paths(const void *a, const void *b)
{
    const struct accumulate_frame *x = *(struct accumulate_frame *const *)a,
                                  *y = *(struct accumulate_frame *const *)b;
    return strcmp(x->path, y->path);
}

static int compare_files(const void *a, const void *b)
{
    const struct accumulate_frame *x = *(struct accumulate_frame *const *)a,
                                  *y = *(struct accumulate_frame *const *)b;
    const int order = strcmp(paths_base_name(x->path), paths_base_name(y->path));
    if (order != 0)
        return order;
    if (x->stamp.size != y->stamp.size)
        return x->stamp.size < y->stamp.size ? -1 : 1;
    return (x->stamp.changed_ns > y->stamp.changed_ns) -
           (x->stamp.changed_ns < y->stamp.changed_ns);
}

typedef int (*order)(const void *a, const void *b);

// Frames of different states that follow each other as equal ones; NULL: none do.
static struct accumulate_frame **find_both(struct accumulate_frame **list, size_t count,
                                           order compare)
{
    qsort(list, count, sizeof *list, compare);
    for (size_t i = 1; i < count; i++)
        if (compare(&list[i - 1], &list[i]) == 0 && list[i - 1]->state != list[i]->state)
            return &list[i - 1];
    return NULL;
}

// A frame of two states would count twice. A copy of it, or the same one by another way, is
// told by name, size and time only.
static enum weft_result check_both(const struct accumulate_job *job)
{
    struct accumulate_frame **list = malloc((size_t)job->frame_count * sizeof *list + 1), **both;
    size_t count = 0;
    if (!list)
        return no_memory();
    for (int64_t i = 0; i < job->frame_count; i++)
        if (!job->frame[i].problem)
            list[count++] = &job->frame[i];
    both = find_both(list, count, compare_paths);
    const bool twice = both != NULL;
    if (twice)
        report_error("%s is in %s and in %s: it would count twice", both[0]->path,
                     job->operands[both[0]->state], job->operands[both[1]->state]);
    else if ((both = find_both(list, count, compare_files)))
        report_warning("%s in %s and %s in %s have the same name, size and time: both count",
                       both[0]->path, job->operands[both[0]->state], both[1]->path,
                       job->operands[both[1]->state]);
    free(list);
    return twice ? WEFT_ERR_ARGUMENT : WEFT_OK;
}

// ---- what they have in common -------------------------------------------------------------------

static enum weft_result compare(const struct accumulate_job *job, const char *path,
                                const struct state_content *content)
{
    const struct state_content *first = &job->kept.file.content;
    const struct state_setting *other = settings_find_other(first, content);
    if (!other)
        return WEFT_OK;
    report_error("%s and %s cannot be joined: %s: %s there, and %s here", job->operands[0], path,
                 other->name, settings_find(first, other->name), other->value);
    return WEFT_ERR_ARGUMENT;
}

// Reads all of them, and keeps the first.
static enum weft_result read_states(struct accumulate_job *job)
{
    enum weft_result res = WEFT_OK;
    for (int i = 0; job->operands[i] && res == WEFT_OK; i++) {
        struct state_file file = {.bytes = NULL};
        res = state_file_read(job->operands[i], &file);
        if (res == WEFT_OK && i > 0)
            res = compare(job, job->operands[i], &file.content);
        if (res == WEFT_OK)
            res = add_frames(job, i, &file.content);
        if (res == WEFT_OK && i == 0)
            job->kept.file = file;
        else
            state_file_clear(&file);
    }
    if (res == WEFT_OK && job->added == 0) {
        report_error("%s holds no frame", job->operands[0]);
        res = WEFT_ERR_FORMAT;
    }
    return res == WEFT_OK ? check_both(job) : res;
}

// The first frame's file as one that can be opened.
static enum weft_result make_substitute(struct accumulate_job *job)
{
    const struct weft_bytes *first = &job->kept.file.content.first;
    const int fd = memfd_create("weft-first-frame", MFD_CLOEXEC);
    job->substitute_fd = fd + 1;
    for (size_t at = 0; fd >= 0 && at < first->size;) {
        const ssize_t count = write(fd, (const char *)first->data + at, first->size - at);
        if (count < 0 && errno != EINTR)
            break;
        at += count > 0 ? (size_t)count : 0;
        if (at == first->size)
            errno = 0;
    }
    if (fd < 0 || errno) {
        report_error("no memory for the first frame: %s", strerror(errno));
        return WEFT_ERR_MEMORY;
    }
    snprintf(job->substitute, sizeof job->substitute, "/proc/self/fd/%d", fd);
    return WEFT_OK;
}

enum weft_result join_open(struct accumulate_job *job)
{
    const struct option_value *resume = &job->option[ACCUMULATE_RESUME];
    enum weft_result res = find_states(job);
    if (res != WEFT_OK || !job->joins)
        return res;
    res = read_states(job);
    if (res == WEFT_OK)
        res = settings_adopt(job, &job->kept.file.content);
    if (res == WEFT_OK && resume->given && access(resume->text, F_OK) == 0) {
        report_error("--resume %s: it exists; states are joined into a new one", resume->text);
        res = WEFT_ERR_ARGUMENT;
    }
    return res == WEFT_OK ? make_substitute(job) : res;
}

// ---- their sums ---------------------------------------------------------------------------------

// One more; the first is in job->kept.file.
static enum weft_result take(struct accumulate_job *job, int i, const struct state_file *file)
{
    weft_accumulator *other = NULL;
    enum weft_result res =
        settings_load_carried(job, job->operands[i], &file->content.carried, i > 0);
    const struct weft_bytes *sums = &file->content.sums;
    if (res == WEFT_OK && i == 0)
        return weft_accumulator_load(job->accumulator, sums->data, sums->size);
    if (res == WEFT_OK)
        res = accumulate_create(job, &other);
    if (res == WEFT_OK)
        res = weft_accumulator_load(other, sums->data, sums->size);
    if (res == WEFT_OK)
        res = weft_accumulator_join(job->accumulator, other);
    weft_accumulator_destroy(&other);
    return res;
}

enum weft_result join_take(struct accumulate_job *job)
{
    enum weft_result res = WEFT_OK;
    if (job->joins)
        res = state_take_first(job, &job->kept.file.content.first);
    for (int i = 0; job->joins && job->operands[i] && res == WEFT_OK; i++) {
        struct state_file file = {.bytes = NULL};
        if (i > 0)
            res = state_file_read(job->operands[i], &file);
        if (res == WEFT_OK)
            res = take(job, i, i > 0 ? &file : &job->kept.file);
        state_file_clear(&file);
    }
    if (job->joins)
        job->next = job->counting;
    return res;
}

void join_clear(struct accumulate_job *job)
{
    if (job->substitute_fd)
        close(job->substitute_fd - 1);
}
