// SPDX-License-Identifier: BSD-3-Clause
// The table with its channels, as text again.
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"
#include "tools/probe/job.h"
#include "tools/probe/numbers.h"

enum { CHUNK = 8192 };

struct writing {
    const struct probe_job *job;
    struct weft_bytes *parts; // of chunks, behind the header
};

static void write_chunk(void *priv, size_t chunk)
{
    struct writing *w = priv;
    const struct probe_job *job = w->job;
    const struct probe_table *t = &job->table;
    const size_t from = chunk * CHUNK, end = from + CHUNK < t->count ? from + CHUNK : t->count;
    size_t room = 0;
    for (size_t i = from; i < end; i++)
        room += t->line[i].size + 1 + (size_t)job->channel_count * (1 + NUMBERS_ROOM);
    char *text = malloc(room + 1), *at = text;
    for (size_t i = from; text && i < end; i++) {
        memcpy(at, t->line[i].text, t->line[i].size);
        at += t->line[i].size;
        for (int c = 0; c < job->channel_count; c++) {
            *at++ = t->separator;
            at = numbers_print(job->channels[(size_t)c * t->count + i], at);
        }
        *at++ = '\n';
    }
    w->parts[chunk] = (struct weft_bytes){text, text ? (size_t)(at - text) : 0};
}

// The names of columns that the table has, or x, y and z, and of the channels.
static char *make_header(const struct probe_job *job)
{
    const struct probe_table *t = &job->table;
    const size_t room = (size_t)t->header.size + (size_t)t->columns * 16 + 64 +
                        (size_t)job->channel_count * (1 + sizeof job->channel[0]);
    char *text = malloc(room);
    size_t size = 0;
    if (!text)
        return NULL;
    if (t->header.text) {
        memcpy(text, t->header.text, t->header.size);
        size = t->header.size;
    }
    for (int c = 0; !t->header.text && c < t->columns; c++) {
        if (c)
            text[size++] = t->separator;
        if (c < 3)
            text[size++] = "xyz"[c];
        else
            size += (size_t)snprintf(text + size, room - size, "column.%d", c + 1);
    }
    for (int c = 0; c < job->channel_count; c++)
        size += (size_t)snprintf(text + size, room - size, "%c%s", t->separator, job->channel[c]);
    snprintf(text + size, room - size, "\n");
    return text;
}

enum weft_result probe_write(const struct probe_job *job, const char *path)
{
    const size_t chunks = (job->table.count + CHUNK - 1) / CHUNK;
    struct weft_bytes *parts = calloc(chunks + 1, sizeof *parts);
    char *header = make_header(job);
    struct writing w = {job, parts ? parts + 1 : NULL};
    bool whole = parts && header;
    if (whole)
        probe_parallel(job->threads, chunks, write_chunk, &w);
    for (size_t i = 1; whole && i <= chunks; i++)
        whole = parts[i].data != NULL;
    enum weft_result res = WEFT_ERR_MEMORY;
    if (whole) {
        parts[0] = (struct weft_bytes){header, strlen(header)};
        res = weft_file_save_parts(report_log(), path, job->option[PROBE_NO_CLOBBER].given, parts,
                                   chunks + 1);
    } else {
        report_error("not enough memory for the text of %zu points", job->table.count);
    }
    for (size_t i = 1; parts && i <= chunks; i++)
        free((void *)parts[i].data);
    free(parts);
    free(header);
    return res;
}
