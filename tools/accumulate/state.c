// SPDX-License-Identifier: BSD-3-Clause
#include "tools/accumulate/state.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "tools/accumulate/settings.h"
#include "tools/common/paths.h"
#include "tools/common/report.h"

// Until a state was saved its cost is reckoned by this: 8 bytes a value, and so many a second.
static const double assumed_speed = 200e6;
static const double least_seconds = 0.1; // between two

static const char *state_path(const struct accumulate_job *job)
{
    return job->option[ACCUMULATE_RESUME].text;
}

// Whether the order of frames decides nothing.
static bool is_any_order(const struct accumulate_job *job)
{
    return job->planned.method == WEFT_ACCUMULATE_EXACT;
}

// ---- which frames it holds ----------------------------------------------------------------------

// A name, of a frame of the job or of the state, and its place there.
struct named {
    const char *name;
    int64_t index;
};

static int compare_named(const void *a, const void *b)
{
    const struct named *x = a, *y = b;
    const int order = strcmp(x->name, y->name);
    return order ? order : (x->index > y->index) - (x->index < y->index);
}

static void print_stamp(const struct state_stamp *stamp, char text[64])
{
    const time_t seconds = (time_t)(stamp->changed_ns / 1000000000);
    char when[32] = "";
    struct tm broken;
    if (gmtime_r(&seconds, &broken))
        strftime(when, sizeof when, "%Y-%m-%d %H:%M:%S", &broken);
    snprintf(text, 64, "%" PRId64 " bytes of %s.%09d", stamp->size, when,
             (int)(stamp->changed_ns % 1000000000));
}

static enum weft_result refuse_changed(const char *path, const struct state_frame *held,
                                       const struct state_stamp *now)
{
    char before[64], after[64];
    print_stamp(&held->stamp, before);
    print_stamp(now, after);
    if (now->size < 0)
        report_error("%s: %s, which it holds, is gone", path, held->name);
    else
        report_error("%s: %s has changed since it was added: %s, now %s (UTC)", path, held->name,
                     before, after);
    return WEFT_ERR_OPEN;
}

// A frame that the state holds is looked at no more, but for one that was unreadable and is another
// file now.
static enum weft_result match(struct accumulate_job *job, struct accumulate_frame *frame,
                              const struct state_frame *held)
{
    const struct state_stamp now = state_file_stamp(frame->path);
    const bool same = state_file_same_stamp(&now, &held->stamp);
    if (frame->weight != held->weight) {
        report_error("%s: %s had the weight %.17g and has %.17g now", state_path(job), held->name,
                     held->weight, frame->weight);
        return WEFT_ERR_ARGUMENT;
    }
    if (!held->problem[0] && !same)
        return refuse_changed(state_path(job), held, &now);
    if (held->problem[0] && (!same || !job->option[ACCUMULATE_SKIP_BAD].given))
        return WEFT_OK;
    frame->done = true;
    frame->stamp = held->stamp;
    if (!held->problem[0])
        return WEFT_OK;
    frame->problem = strdup(held->problem);
    return frame->problem ? WEFT_OK : WEFT_ERR_MEMORY;
}

// Both lists by name, those of one name in their order.
static enum weft_result match_sorted(struct accumulate_job *job, const struct named *now,
                                     const struct named *held)
{
    const struct state_content *content = &job->kept.file.content;
    int64_t at = 0;
    for (size_t i = 0; i < content->frame_count; i++) {
        int order = -1;
        while (at < job->counting && (order = strcmp(now[at].name, held[i].name)) < 0)
            at++;
        if (order != 0) {
            report_error("%s: %s, which it holds, is not among the frames that are given now",
                         state_path(job), held[i].name);
            return WEFT_ERR_ARGUMENT;
        }
        const enum weft_result res =
            match(job, &job->frame[now[at].index], &content->frames[held[i].index]);
        if (res != WEFT_OK)
            return res;
        at++;
    }
    return WEFT_OK;
}

static enum weft_result match_frames(struct accumulate_job *job)
{
    const struct state_content *content = &job->kept.file.content;
    struct named *now = malloc((size_t)job->counting * sizeof *now + 1);
    struct named *held = malloc(content->frame_count * sizeof *held + 1);
    enum weft_result res = now && held ? WEFT_OK : WEFT_ERR_MEMORY;
    if (res == WEFT_OK) {
        for (int64_t i = 0; i < job->counting; i++)
            now[i] = (struct named){job->frame[job->sequence[i]].path, job->sequence[i]};
        for (size_t i = 0; i < content->frame_count; i++)
            held[i] = (struct named){content->frames[i].name, (int64_t)i};
        qsort(now, (size_t)job->counting, sizeof *now, compare_named);
        qsort(held, content->frame_count, sizeof *held, compare_named);
        res = match_sorted(job, now, held);
    }
    free(now);
    free(held);
    if (res == WEFT_ERR_MEMORY)
        report_error("out of memory for the names of %zu frames", content->frame_count);
    return res;
}

enum weft_result state_open(struct accumulate_job *job)
{
    const char *path = state_path(job);
    struct stat st;
    if (!path)
        return WEFT_OK;
    if (paths_is_special(path)) {
        report_error("--resume %s: a state must be a file", path);
        return WEFT_ERR_ARGUMENT;
    }
    if (stat(path, &st) != 0)
        return WEFT_OK;
    const enum weft_result res = state_file_read(path, &job->kept.file);
    return res == WEFT_OK ? match_frames(job) : res;
}

// ---- going on -----------------------------------------------------------------------------------

// What it holds comes first in the sequence, and is looked at no more.
static enum weft_result put_first(struct accumulate_job *job)
{
    int64_t *left = malloc((size_t)job->counting * sizeof *left), left_count = 0;
    if (!left)
        return WEFT_ERR_MEMORY;
    for (int64_t i = 0; i < job->counting; i++) {
        const int64_t at = job->sequence[i];
        const struct accumulate_frame *frame = &job->frame[at];
        if (!frame->done) {
            left[left_count++] = at;
            continue;
        }
        job->sequence[job->next++] = at;
        if (frame->problem)
            job->skipped++;
        else if (job->added++ == 0)
            job->first = at;
    }
    memcpy(job->sequence + job->next, left, (size_t)left_count * sizeof *left);
    free(left);
    return WEFT_OK;
}

// Where order matters, what the state holds comes before the rest; otherwise the first frame does,
// of which channels are copied.
static enum weft_result check_order(const struct accumulate_job *job)
{
    int64_t last = job->first;
    for (int64_t i = 0; !is_any_order(job) && i < job->frame_count; i++)
        if (job->frame[i].done)
            last = i;
    if (job->next == job->counting || job->sequence[job->next] > last)
        return WEFT_OK;
    report_error("%s: %s comes before %s, which it holds; new frames come behind %s",
                 state_path(job), job->frame[job->sequence[job->next]].path, job->frame[last].path,
                 is_any_order(job) ? "the first one" : "those that it holds");
    return WEFT_ERR_ARGUMENT;
}

enum weft_result state_take_first(struct accumulate_job *job, const struct weft_bytes *first)
{
    job->kept.first = malloc(first->size + 1);
    if (!job->kept.first)
        return WEFT_ERR_MEMORY;
    memcpy(job->kept.first, first->data, first->size);
    job->kept.first_size = first->size;
    return WEFT_OK;
}

static enum weft_result take_sums(struct accumulate_job *job)
{
    const struct weft_bytes *sums = &job->kept.file.content.sums;
    struct weft_accumulator_report report;
    const enum weft_result res = weft_accumulator_load(job->accumulator, sums->data, sums->size);
    if (res != WEFT_OK)
        return res;
    weft_accumulator_get_report(job->accumulator, &report);
    if (report.counted == job->added)
        return WEFT_OK;
    report_error("%s: the state is damaged: it names %" PRId64 " frames, and has the sums of "
                 "%" PRId64,
                 state_path(job), job->added, report.counted);
    return WEFT_ERR_FORMAT;
}

static void tell_taken(const struct accumulate_job *job)
{
    if (job->next == job->counting)
        report_tell("%s holds all %" PRId64 " frames: only the result is written", state_path(job),
                    job->added);
    else
        report_note("%s holds %" PRId64 " frames, %" PRId64 " are left", state_path(job),
                    job->added, job->counting - job->next);
}

enum weft_result state_take(struct accumulate_job *job)
{
    enum weft_result res = WEFT_OK;
    job->kept.saved_at = report_now_seconds();
    job->kept.cost =
        8.0 * job->image.width * job->image.height * job->averaged_count / assumed_speed;
    if (!job->kept.file.bytes || job->joins)
        return WEFT_OK;
    const struct state_content *content = &job->kept.file.content;
    res = settings_compare(job, state_path(job), content);
    if (res == WEFT_OK) {
        res = put_first(job);
        if (res == WEFT_OK)
            res = check_order(job);
    }
    if (res == WEFT_OK)
        res = settings_load_carried(job, state_path(job), &content->carried, false);
    if (res == WEFT_OK)
        res = state_take_first(job, &content->first);
    if (res == WEFT_OK)
        res = take_sums(job);
    if (res == WEFT_OK)
        tell_taken(job);
    job->kept.held = job->kept.resumed = job->next;
    state_file_clear(&job->kept.file);
    return res;
}

// ---- saving -------------------------------------------------------------------------------------

// The file of the first frame, as long as it is the one that was read.
static enum weft_result keep_first(struct accumulate_job *job)
{
    const struct accumulate_frame *frame = &job->frame[job->first];
    struct state_stamp now = state_file_stamp(frame->path);
    if (job->kept.first)
        return WEFT_OK;
    FILE *file = fopen(frame->path, "rbe");
    const size_t size = (size_t)frame->stamp.size;
    char *bytes = file ? malloc(size + 1) : NULL;
    bool whole = bytes && fread(bytes, 1, size + 1, file) == size;
    if (file)
        fclose(file);
    whole = whole && state_file_same_stamp(&now, &frame->stamp);
    now = state_file_stamp(frame->path);
    if (whole && state_file_same_stamp(&now, &frame->stamp)) {
        job->kept.first = bytes;
        job->kept.first_size = size;
        return WEFT_OK;
    }
    free(bytes);
    report_error("%s: no state can be saved: %s was read and is another file now", state_path(job),
                 frame->path);
    return WEFT_ERR_OPEN;
}

static size_t list_done(const struct accumulate_job *job, struct state_frame *out)
{
    size_t count = 0;
    for (int64_t i = 0; i < job->frame_count; i++) {
        const struct accumulate_frame *f = &job->frame[i];
        if (f->done)
            out[count++] =
                (struct state_frame){f->path, f->stamp, f->weight, f->problem ? f->problem : ""};
    }
    return count;
}

// The content but for the sums, and what it is made of.
struct parts {
    struct state_content content;
    struct settings settings;
    struct weft_bytes carried;
    struct state_frame *frames;
    char *folder;
};

static void clear_parts(struct parts *p)
{
    settings_clear(&p->settings);
    free((void *)p->carried.data);
    free(p->frames);
    free(p->folder);
}

static bool make_parts(const struct accumulate_job *job, struct parts *p)
{
    *p = (struct parts){.carried = settings_save_carried(job),
                        .frames = calloc((size_t)job->frame_count, sizeof *p->frames),
                        .folder = getcwd(NULL, 0)};
    if (!settings_make(job, &p->settings) || !p->carried.data || !p->frames || !p->folder)
        return false;
    p->content = (struct state_content){
        .folder = p->folder,
        .setting_count = p->settings.count,
        .settings = p->settings.setting,
        .frame_count = list_done(job, p->frames),
        .frames = p->frames,
        .first = {job->kept.first, job->kept.first_size},
        .carried = p->carried,
    };
    return true;
}

static enum weft_result write_state(struct accumulate_job *job)
{
    struct parts parts;
    void *sums = NULL;
    size_t size = 0;
    enum weft_result res = WEFT_ERR_MEMORY;
    if (make_parts(job, &parts))
        res = weft_accumulator_save(job->accumulator, &sums, &size);
    if (res == WEFT_OK) {
        parts.content.sums = (struct weft_bytes){sums, size};
        res = state_file_write(state_path(job), &parts.content);
    }
    free(sums);
    clear_parts(&parts);
    return res;
}

enum weft_result state_save(struct accumulate_job *job)
{
    const double start = report_now_seconds();
    if (!state_path(job) || job->added == 0 || job->kept.held == job->next)
        return WEFT_OK;
    enum weft_result res = keep_first(job);
    if (res == WEFT_OK)
        res = write_state(job);
    if (res == WEFT_OK)
        job->kept.held = job->next;
    job->kept.saved_at = report_now_seconds();
    job->kept.cost = job->kept.saved_at - start;
    job->kept.seconds += job->kept.cost;
    job->kept.saves++;
    return res;
}

double state_patience(const struct accumulate_job *job)
{
    const double wait = STATE_PATIENCE * job->kept.cost;
    return wait > least_seconds ? wait : least_seconds;
}

static bool is_due(const struct accumulate_job *job)
{
    return state_path(job) && report_now_seconds() - job->kept.saved_at >= state_patience(job);
}

void state_save_now_and_then(struct accumulate_job *job)
{
    struct report_held held = {.count = 0};
    if (!is_due(job))
        return;
    report_hold(&held);
    const enum weft_result res = state_save(job);
    report_hold(NULL);
    if (res == WEFT_OK || job->kept.warned)
        return;
    report_warning("%s is not saved: %s", state_path(job),
                   held.count ? held.line[held.count - 1] : weft_result_text(res));
    job->kept.warned = true;
}

void state_set_last_words(const struct accumulate_job *job)
{
    char means[64] = "nothing is written", held[REPORT_LINE / 4] = "";
    if (job->writing)
        snprintf(means, sizeof means, "while outputs were written");
    else if (job->every.added)
        snprintf(means, sizeof means, "the mean of %" PRId64 " is written", job->every.added);
    if (state_path(job) && job->kept.held)
        snprintf(held, sizeof held, ", %.160s holds %" PRId64, state_path(job), job->kept.held);
    else if (state_path(job))
        snprintf(held, sizeof held, ", %.160s holds none", state_path(job));
    report_set_last_words("weft: ended after %" PRId64 " of %" PRId64 " frames, %s%s", job->next,
                          job->counting, means, held);
}

void state_clear(struct accumulate_job *job)
{
    state_file_clear(&job->kept.file);
    free(job->kept.first);
}
