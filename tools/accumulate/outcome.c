// SPDX-License-Identifier: BSD-3-Clause
#include "tools/accumulate/outcome.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"

static enum weft_result no_memory(int64_t count)
{
    report_error("out of memory for what came of %lld frames", (long long)count);
    return WEFT_ERR_MEMORY;
}

enum weft_result outcomes_create(int64_t count, struct outcomes *out)
{
    *out = (struct outcomes){count, calloc((size_t)count, sizeof *out->list)};
    if (out->list)
        return WEFT_OK;
    out->count = 0;
    return no_memory(count);
}

void outcomes_clear(struct outcomes *outcomes)
{
    for (int64_t i = 0; i < outcomes->count; i++) {
        free(outcomes->list[i].problem);
        free(outcomes->list[i].warning);
    }
    free(outcomes->list);
    *outcomes = (struct outcomes){.count = 0};
}

// ---- as bytes -----------------------------------------------------------------------------------

// Before the texts, which follow without their ends.
struct record {
    struct state_stamp stamp;
    struct weft_transfer transfer;
    uint64_t problem, warning; // lengths + 1; 0: none
};

static uint64_t length_of(const char *text)
{
    return text ? strlen(text) + 1 : 0;
}

static void put_text(FILE *out, const char *text)
{
    if (text)
        fwrite(text, 1, strlen(text), out);
}

enum weft_result outcomes_pack(const struct outcomes *outcomes, const struct accumulate_job *job,
                               void **data, size_t *size)
{
    char *bytes = NULL;
    FILE *out = open_memstream(&bytes, size);
    if (!out)
        return no_memory(outcomes->count);
    for (size_t c = 0; c < job->image.channel_count; c++)
        fputc((int)job->channel[c].widest, out);
    for (int64_t i = 0; i < outcomes->count; i++) {
        const struct outcome *o = &outcomes->list[i];
        const struct record record = {o->stamp, o->transfer, length_of(o->problem),
                                      length_of(o->warning)};
        fwrite(&record, sizeof record, 1, out);
        put_text(out, o->problem);
        put_text(out, o->warning);
    }
    if (!report_close(out)) {
        free(bytes);
        return no_memory(outcomes->count);
    }
    *data = bytes;
    return WEFT_OK;
}

struct cursor {
    const char *at, *end;
    enum weft_result result; // of what was taken first without being there
};

static bool take(struct cursor *c, void *out, size_t size)
{
    if (c->result != WEFT_OK || (size_t)(c->end - c->at) < size) {
        c->result = c->result == WEFT_OK ? WEFT_ERR_FORMAT : c->result;
        return false;
    }
    memcpy(out, c->at, size);
    c->at += size;
    return true;
}

static char *take_text(struct cursor *c, uint64_t length)
{
    char *text = NULL;
    if (length == 0 || c->result != WEFT_OK)
        return NULL;
    if ((uint64_t)(c->end - c->at) < length - 1)
        c->result = WEFT_ERR_FORMAT;
    else if (!(text = strndup(c->at, length - 1)))
        c->result = WEFT_ERR_MEMORY;
    else
        c->at += length - 1;
    return text;
}

enum weft_result outcomes_take(struct outcomes *outcomes, struct accumulate_job *job, int64_t first,
                               int64_t count, const void *data, size_t size)
{
    struct cursor c = {data, (const char *)data + size, WEFT_OK};
    for (size_t i = 0; i < job->image.channel_count; i++) {
        struct accumulate_channel *channel = &job->channel[i];
        unsigned char type;
        if (take(&c, &type, 1))
            channel->widest = accumulate_wider(channel->widest, (enum weft_pixel_type)type);
    }
    for (int64_t i = first; i < first + count; i++) {
        struct record record;
        if (!take(&c, &record, sizeof record))
            break;
        outcomes->list[i] = (struct outcome){.stamp = record.stamp, .transfer = record.transfer};
        outcomes->list[i].problem = take_text(&c, record.problem);
        outcomes->list[i].warning = take_text(&c, record.warning);
    }
    if (c.result == WEFT_ERR_MEMORY)
        return no_memory(count);
    if (c.result != WEFT_OK)
        report_error("what came of frames was cut on its way");
    return c.result;
}
