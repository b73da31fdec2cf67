// SPDX-License-Identifier: BSD-3-Clause
// Files wait in a ring, in the order of their names, until readers have done their part.
#include "tiles/image/sequence.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "filter/check.h"
#include "filter/threads.h"
#include "tiles/image/image_impl.h"
#include "tiles/image/image_wire.h"
#include "tiles/process/pool.h"

#define ASK_STOP_SECONDS 0.1

static const char exr_program[] = "weft-read-exr", dwa_program[] = "weft-read-dwa";

// A file on its way.
struct slot {
    char *name;
    bool looked; // its kind is known
    bool taken;  // what it was given was checked
    size_t planes_offset;
    struct weft_image_frame frame;
    struct weft_plane *plane;
    struct weft_job job;
};

struct weft_image_sequence {
    struct weft_image_sequence_params params;
    struct weft_pool pool;
    int64_t next;            // name
    bool out;                // the ring's first frame is the caller's
    const char *exr_program; // that read the last one
    void *values;            // of the frame that the caller has
    size_t values_size;
    enum weft_result ended;
    int capacity, first, count;
    struct slot *ring;
};

static struct slot *slot_at(weft_image_sequence *s, int i)
{
    return &s->ring[(s->first + i) % s->capacity];
}

// ---- creating and destroying --------------------------------------------------------------------

// Each takes two descriptors; others are needed now and then, and by the caller.
static int choose_readers(const struct weft_image_sequence_params *p)
{
    enum { OTHERS = 20 };
    struct rlimit files;
    int64_t readers = p->readers ? p->readers : weft_threads_available();
    if (readers > WEFT_IMAGE_SEQUENCE_MAX_READERS)
        readers = WEFT_IMAGE_SEQUENCE_MAX_READERS;
    if (readers > p->count)
        readers = p->count;
    if (getrlimit(RLIMIT_NOFILE, &files) == 0 && files.rlim_cur < (rlim_t)(OTHERS + 2 * readers))
        readers = ((int64_t)files.rlim_cur - OTHERS) / 2;
    return readers < 1 ? 1 : (int)readers;
}

enum weft_result weft_image_sequence_create(const struct weft_image_sequence_params *params,
                                            weft_image_sequence **out)
{
    const struct weft_image_sequence_params *p = params;
    *out = NULL;
    weft_image_sequence *s = NULL;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, p->count >= 1 && p->name);
    weft_require(p->log, p->readers >= 0 && p->readers <= WEFT_IMAGE_SEQUENCE_MAX_READERS);
    weft_require(p->log, p->part >= 0);
    res = WEFT_ERR_MEMORY;
    s = calloc(1, sizeof *s);
    if (!s)
        goto fail;
    s->params = *p;
    s->exr_program = exr_program;
    s->pool.log = p->log;
    s->pool.limits = p->limits;
    s->pool.readers = choose_readers(p);
    s->pool.memory_bytes = p->memory_bytes ? p->memory_bytes : UINT64_C(256) << 20;
    s->capacity = s->pool.readers * WEFT_WIRE_ROOMS;
    s->ring = calloc((size_t)s->capacity, sizeof *s->ring);
    if (!s->ring)
        goto fail;
    *out = s;
    return WEFT_OK;
fail:
    if (res == WEFT_ERR_MEMORY)
        weft_error(p->log, "out of memory for a sequence of images");
    weft_image_sequence_destroy(&s);
    return res;
}

enum weft_result weft_image_sequence_extend(weft_image_sequence *s, int64_t count)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(s->params.log, count >= 1 && count <= INT64_MAX - s->params.count);
    s->params.count += count;
    res = WEFT_OK;
fail:
    return res;
}

static void clear_slot(struct slot *slot)
{
    weft_image_clear(&slot->frame.image);
    free(slot->plane);
    free(slot->name);
    *slot = (struct slot){.name = NULL};
}

void weft_image_sequence_destroy(weft_image_sequence **sequence)
{
    weft_image_sequence *s = sequence ? *sequence : NULL;
    if (!s)
        return;
    weft_pool_clear(&s->pool);
    for (int i = 0; s->ring && i < s->capacity; i++)
        clear_slot(&s->ring[i]);
    free(s->ring);
    free(s->values);
    free(s);
    *sequence = NULL;
}

// ---- asking -------------------------------------------------------------------------------------

static void keep_line(void *priv, enum weft_log_level level, const char *message)
{
    struct weft_image_frame *frame = priv;
    if (level == WEFT_LOG_ERROR)
        snprintf(frame->message, sizeof frame->message, "%s", message);
}

static enum weft_result fail_slot(struct slot *slot, enum weft_result why)
{
    slot->job.state = WEFT_JOB_FAILED;
    slot->job.result = why;
    return why;
}

// What a file is.
static enum weft_result look(weft_image_sequence *s, struct slot *slot, int fd)
{
    struct weft_image_frame *frame = &slot->frame;
    const struct weft_log log = {keep_line, frame};
    struct stat st;
    const enum weft_result res = weft_image_find_kind(&log, slot->name, fd, &frame->kind);
    if (res != WEFT_OK)
        return fail_slot(slot, res);
    if (fstat(fd, &st)) {
        weft_error(&log, "%s cannot be read: %s", slot->name, strerror(errno));
        return fail_slot(slot, WEFT_ERR_OPEN);
    }
    frame->file_bytes = (uint64_t)st.st_size;
    frame->changed_ns = (int64_t)st.st_mtim.tv_sec * 1000000000 + st.st_mtim.tv_nsec;
    slot->job.program = frame->kind != WEFT_IMAGE_FILE_EXR ? weft_image_program(frame->kind)
                        : s->params.info_only              ? exr_program
                                                           : s->exr_program;
    slot->looked = true;
    return WEFT_OK;
}

// Gives the file to a reader, or leaves it waiting where none can have it now.
static enum weft_result ask(weft_image_sequence *s, struct slot *slot, bool urgent)
{
    const struct weft_log log = {keep_line, &slot->frame};
    int fd = -1;
    if (slot->looked && !weft_pool_has_place(&s->pool, &slot->job, urgent))
        return WEFT_OK;
    enum weft_result res = weft_reader_open(&log, slot->name, &fd);
    if (res != WEFT_OK) {
        fail_slot(slot, res);
        return WEFT_OK;
    }
    res = WEFT_OK;
    if (look(s, slot, fd) == WEFT_OK)
        res = weft_pool_place(&s->pool, &slot->job, fd, urgent);
    close(fd);
    return res;
}

// Takes names as long as there is room for more. Those without a text are left out.
static enum weft_result take_names(weft_image_sequence *s)
{
    while (s->count < s->capacity && s->next < s->params.count) {
        const int64_t index = s->next++;
        const char *name = s->params.name(s->params.priv, index);
        if (!name)
            continue;
        struct slot *slot = slot_at(s, s->count);
        *slot = (struct slot){.name = strdup(name)};
        if (!slot->name) {
            weft_error(s->params.log, "out of memory for a name");
            return WEFT_ERR_MEMORY;
        }
        slot->frame.index = index;
        slot->frame.name = slot->name;
        slot->job.path = slot->name;
        slot->job.part = (uint32_t)s->params.part;
        slot->job.info_only = s->params.info_only;
        s->count++;
    }
    return WEFT_OK;
}

// In their order: a later one does not get what an earlier one waits for.
static enum weft_result ask_all(weft_image_sequence *s)
{
    for (int i = 0; i < s->count; i++) {
        struct slot *slot = slot_at(s, i);
        if (slot->job.state != WEFT_JOB_NEW)
            continue;
        const enum weft_result res = ask(s, slot, i == 0);
        if (res != WEFT_OK)
            return res;
        if (slot->job.state == WEFT_JOB_NEW)
            break;
    }
    return WEFT_OK;
}

// ---- what readers give --------------------------------------------------------------------------

// Planes that lie one after another from `base`, or between one another; their bytes in all,
// SIZE_MAX where there can be none so large.
static size_t lay_out(const struct weft_image_frame *frame, struct weft_plane *plane,
                      const void *base)
{
    const struct weft_image *image = &frame->image;
    const bool mixed = frame->kind != WEFT_IMAGE_FILE_EXR;
    size_t at = 0;
    for (size_t c = 0; c < image->channel_count; c++) {
        const size_t value = weft_plane_type_size(plane[c].type);
        size_t bytes;
        plane[c].step = mixed ? image->channel_count : 1;
        plane[c].stride = (size_t)image->width * plane[c].step;
        plane[c].values = (const void *)((uintptr_t)base + at + (mixed ? c * value : 0));
        if (!weft_size_mul(plane[c].stride * value, (size_t)image->height, &bytes))
            return SIZE_MAX;
        if (mixed && c + 1 < image->channel_count)
            continue;
        if ((!mixed && !weft_wire_align(bytes, &bytes)) || !weft_size_add(at, bytes, &at))
            return SIZE_MAX;
    }
    return at;
}

// Codes are handed out as they are; what is made of them has the channels' types.
static void set_types(struct slot *slot)
{
    static const enum weft_plane_type types[] = {
        [WEFT_PIXEL_FLOAT] = WEFT_PLANE_FLOAT,     [WEFT_PIXEL_HALF] = WEFT_PLANE_HALF,
        [WEFT_PIXEL_UINT] = WEFT_PLANE_UINT,       [WEFT_PIXEL_UNORM8] = WEFT_PLANE_UNORM8,
        [WEFT_PIXEL_UNORM16] = WEFT_PLANE_UNORM16,
    };
    struct weft_image *image = &slot->frame.image;
    for (size_t c = 0; c < image->channel_count; c++) {
        struct weft_image_channel *channel = &image->channels[c];
        slot->plane[c].type = types[channel->type];
        if (channel->type == WEFT_PIXEL_UNORM8 || channel->type == WEFT_PIXEL_UNORM16)
            channel->type = WEFT_PIXEL_FLOAT;
    }
}

// The answer but for its values, which nothing depends on.
static enum weft_result take_answer(weft_image_sequence *s, struct slot *slot)
{
    struct weft_image_frame *frame = &slot->frame;
    const struct weft_job *job = &slot->job;
    struct weft_wire_frame wire;
    if (job->size < sizeof wire)
        return WEFT_ERR_READER;
    memcpy(&wire, job->data, sizeof wire);
    if (wire.planes_offset > job->size || wire.planes_offset % WEFT_WIRE_ALIGN ||
        wire.planes_offset < sizeof wire || wire.info_bytes > wire.planes_offset - sizeof wire)
        return WEFT_ERR_READER;
    void *info = malloc(wire.info_bytes + 1);
    if (!info)
        return WEFT_ERR_MEMORY;
    memcpy(info, (const char *)job->data + sizeof wire, wire.info_bytes);
    enum weft_result res =
        weft_image_take_info(info, wire.info_bytes, frame->kind, s->params.part, &frame->image);
    free(info);
    if (res == WEFT_OK && frame->kind != WEFT_IMAGE_FILE_EXR)
        res = weft_image_take_codes(&wire, &frame->image);
    if (res != WEFT_OK)
        return res;
    frame->codes = frame->image.codes;
    if (frame->kind != WEFT_IMAGE_FILE_EXR)
        frame->image.attribute_count = 0;
    slot->planes_offset = wire.planes_offset;
    slot->plane = calloc(frame->image.channel_count, sizeof *slot->plane);
    if (!slot->plane)
        return WEFT_ERR_MEMORY;
    set_types(slot);
    const size_t bytes = s->params.info_only ? 0 : lay_out(frame, slot->plane, NULL);
    return bytes == job->size - slot->planes_offset ? WEFT_OK : WEFT_ERR_READER;
}

static void forget_answer(struct slot *slot)
{
    weft_image_clear(&slot->frame.image);
    free(slot->plane);
    slot->plane = NULL;
    slot->frame.codes = (struct weft_code_info){0};
}

static enum weft_result take(weft_image_sequence *s, struct slot *slot)
{
    struct weft_job *job = &slot->job;
    if (job->state == WEFT_JOB_NEW && job->other_program) {
        const bool was_dwa = job->program == dwa_program;
        job->program = s->exr_program = was_dwa ? exr_program : dwa_program;
        job->other_program = false;
    }
    if (job->state != WEFT_JOB_GIVEN || slot->taken)
        return WEFT_OK;
    const enum weft_result res = take_answer(s, slot);
    slot->taken = res == WEFT_OK;
    if (res == WEFT_OK)
        return WEFT_OK;
    forget_answer(slot);
    if (res == WEFT_ERR_READER) {
        weft_pool_refuse(&s->pool, job);
        return WEFT_OK;
    }
    weft_error(s->params.log, "%s: out of memory", slot->name);
    return res;
}

static enum weft_result take_all(weft_image_sequence *s)
{
    enum weft_result res = WEFT_OK;
    for (int i = 0; res == WEFT_OK && i < s->count; i++)
        res = take(s, slot_at(s, i));
    return res;
}

// ---- handing out --------------------------------------------------------------------------------

static void drop_frame(weft_image_sequence *s)
{
    if (!s->out)
        return;
    clear_slot(slot_at(s, 0));
    s->first = (s->first + 1) % s->capacity;
    s->count--;
    s->out = false;
}

// The caller's own: nobody can change it.
static enum weft_result copy_values(weft_image_sequence *s, struct slot *slot)
{
    const size_t size = slot->job.size - slot->planes_offset;
    if (size > s->values_size) {
        size_t room = 0; // aligned_alloc wants whole units
        free(s->values);
        s->values = weft_wire_align(size, &room) ? aligned_alloc(WEFT_WIRE_ALIGN, room) : NULL;
        s->values_size = s->values ? room : 0;
        if (!s->values) {
            weft_error(s->params.log, "%s: out of memory for %zu bytes", slot->name, size);
            return WEFT_ERR_MEMORY;
        }
    }
    memcpy(s->values, (const char *)slot->job.data + slot->planes_offset, size);
    lay_out(&slot->frame, slot->plane, s->values);
    slot->frame.plane = slot->plane;
    return WEFT_OK;
}

static enum weft_result hand_out(weft_image_sequence *s, const struct weft_image_frame **frame)
{
    struct slot *slot = slot_at(s, 0);
    enum weft_result res = WEFT_OK;
    if (slot->job.state == WEFT_JOB_FAILED) {
        slot->frame.result = slot->job.result;
        if (*slot->job.message)
            snprintf(slot->frame.message, sizeof slot->frame.message, "%s", slot->job.message);
    } else {
        if (!s->params.info_only)
            res = copy_values(s, slot);
        weft_pool_release(&s->pool, &slot->job);
    }
    s->out = true;
    *frame = res == WEFT_OK ? &slot->frame : NULL;
    return res;
}

static bool is_done(const struct slot *slot)
{
    return slot->job.state == WEFT_JOB_FAILED || slot->taken;
}

static enum weft_result advance(weft_image_sequence *s, const struct weft_image_frame **frame)
{
    for (;;) {
        enum weft_result res = take_names(s);
        if (res == WEFT_OK)
            res = ask_all(s);
        if (res != WEFT_OK || !s->count)
            return res;
        if (is_done(slot_at(s, 0)))
            return hand_out(s, frame);
        if (s->params.stop && s->params.stop(s->params.priv))
            return WEFT_ERR_CANCELLED;
        weft_pool_wait(&s->pool, s->params.stop ? ASK_STOP_SECONDS : -1.0);
        res = take_all(s);
        if (res != WEFT_OK)
            return res;
    }
}

enum weft_result weft_image_sequence_next(weft_image_sequence *s,
                                          const struct weft_image_frame **frame)
{
    *frame = NULL;
    drop_frame(s);
    if (s->ended)
        return s->ended;
    const enum weft_result res = advance(s, frame);
    if (res != WEFT_OK && res != WEFT_ERR_CANCELLED)
        s->ended = res;
    return res;
}
