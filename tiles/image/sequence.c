// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/image/sequence.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "filter/check.h"

const char *const weft_image_file_kind_names[] = {"EXR", "PNG", NULL};

struct weft_image_sequence {
    struct weft_image_sequence_params params;
    int64_t next;
    char *name;
    struct weft_image_frame frame;
    struct weft_image loaded;
    struct weft_plane *planes;
};

static void keep_line(void *priv, enum weft_log_level level, const char *message)
{
    struct weft_image_frame *frame = priv;
    if (level == WEFT_LOG_ERROR)
        snprintf(frame->message, sizeof frame->message, "%s", message);
}

static void drop_frame(weft_image_sequence *s)
{
    weft_image_clear(&s->loaded);
    free(s->planes);
    free(s->name);
    s->planes = NULL;
    s->name = NULL;
    s->frame = (struct weft_image_frame){0};
}

enum weft_result weft_image_sequence_create(const struct weft_image_sequence_params *params,
                                            weft_image_sequence **out)
{
    const struct weft_image_sequence_params *p = params;
    *out = NULL;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, p->count >= 1 && p->name);
    weft_require(p->log, p->readers >= 0 && p->readers <= WEFT_IMAGE_SEQUENCE_MAX_READERS);
    weft_require(p->log, p->part >= 0);
    *out = calloc(1, sizeof **out);
    res = *out ? WEFT_OK : WEFT_ERR_MEMORY;
    if (*out)
        (*out)->params = *p;
    else
        weft_error(p->log, "out of memory for a sequence of images");
fail:
    return res;
}

void weft_image_sequence_destroy(weft_image_sequence **sequence)
{
    if (!sequence || !*sequence)
        return;
    drop_frame(*sequence);
    free(*sequence);
    *sequence = NULL;
}

static enum weft_result take_planes(weft_image_sequence *s)
{
    const struct weft_image *image = &s->loaded;
    s->planes = calloc(image->channel_count, sizeof *s->planes);
    if (!s->planes)
        return WEFT_ERR_MEMORY;
    for (size_t c = 0; c < image->channel_count; c++) {
        const struct weft_image_channel *channel = &image->channels[c];
        const bool integers = channel->integers != NULL;
        s->planes[c] = (struct weft_plane){.values = integers ? (const void *)channel->integers
                                                              : channel->plane,
                                           .type = integers ? WEFT_PLANE_UINT : WEFT_PLANE_FLOAT,
                                           .stride = (size_t)image->width,
                                           .step = 1};
    }
    return WEFT_OK;
}

static enum weft_result read_frame(weft_image_sequence *s)
{
    struct weft_image_frame *frame = &s->frame;
    const struct weft_log log = {keep_line, frame};
    struct stat st;
    frame->result = weft_image_load(weft_image_load_params(.path = s->name, .part = s->params.part,
                                                           .limits = s->params.limits, .log = &log),
                                    &s->loaded);
    if (frame->result != WEFT_OK)
        return WEFT_OK;
    frame->image = s->loaded;
    if (stat(s->name, &st) == 0) {
        frame->file_bytes = (uint64_t)st.st_size;
        frame->changed_ns = (int64_t)st.st_mtim.tv_sec * 1000000000 + st.st_mtim.tv_nsec;
    }
    const enum weft_result res = take_planes(s);
    frame->plane = s->planes;
    return res;
}

enum weft_result weft_image_sequence_next(weft_image_sequence *s,
                                          const struct weft_image_frame **frame)
{
    *frame = NULL;
    drop_frame(s);
    if (s->params.stop && s->params.stop(s->params.priv))
        return WEFT_ERR_CANCELLED;
    const char *name = NULL;
    while (!name && s->next < s->params.count)
        name = s->params.name(s->params.priv, s->next++);
    if (!name)
        return WEFT_OK;
    s->name = strdup(name);
    if (!s->name)
        return WEFT_ERR_MEMORY;
    s->frame.index = s->next - 1;
    s->frame.name = s->name;
    const enum weft_result res = read_frame(s);
    if (res == WEFT_OK)
        *frame = &s->frame;
    return res;
}
