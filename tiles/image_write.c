// SPDX-License-Identifier: BSD-3-Clause
// The file layout is that of OpenEXR's "Technical Introduction" and "OpenEXR File Layout": magic,
// version and flags, a header per part, a table of offsets per part, chunks.
#include "tiles/image_write.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/half.h"
#include "tiles/image_attribute.h"
#include "tiles/image_chunk.h"

enum { MAGIC = 20000630, VERSION = 2, LONG_NAMES = 0x400, MULTIPART = 0x1000, SHORT_NAME = 31 };

struct part {
    const struct weft_image *image;
    const struct weft_image_channel **sorted; // the format has channels by name
    unsigned char *words;                     // of a value of each
    size_t line_bytes;
    int lines; // of a chunk
    size_t chunk_count;
    unsigned char *table; // offsets, little-endian
    uint64_t table_at;
};

struct writer {
    struct part *parts;
    size_t count;
    struct weft_output_file *file;
    const struct weft_progress *progress;
    struct weft_image_save_report *report;
    uint64_t at; // where the next byte goes
    size_t chunks_done, chunks_all;
};

static enum weft_result fail_memory(const struct writer *w)
{
    weft_error(w->file->log, "cannot write %s: out of memory", w->file->path);
    return WEFT_ERR_MEMORY;
}

// ---- bytes --------------------------------------------------------------------------------------

static void store(unsigned char *out, uint64_t value, size_t size)
{
    for (size_t i = 0; i < size; i++)
        out[i] = (unsigned char)(value >> 8 * i);
}

struct bytes {
    unsigned char *data;
    size_t size, room;
    bool failed; // out of memory
};

static void add(struct bytes *b, const void *data, size_t size)
{
    size_t need;
    if (b->failed || !weft_size_add(b->size, size, &need)) {
        b->failed = true;
        return;
    }
    if (need > b->room) {
        size_t room = need + need / 2 + 256;
        unsigned char *larger = realloc(b->data, room);
        b->failed = !larger;
        if (!larger)
            return;
        b->data = larger;
        b->room = room;
    }
    if (size)
        memcpy(b->data + b->size, data, size);
    b->size = need;
}

static void add_number(struct bytes *b, uint64_t value, size_t size)
{
    unsigned char data[8];
    store(data, value, size);
    add(b, data, size);
}

static void add_text(struct bytes *b, const char *text)
{
    add(b, text, strlen(text) + 1);
}

// ---- headers ------------------------------------------------------------------------------------

static void start_attribute(struct bytes *b, const char *name, const char *type, size_t size)
{
    add_text(b, name);
    add_text(b, type);
    add_number(b, size, 4);
}

static void add_string(struct bytes *b, const char *name, const char *text)
{
    start_attribute(b, name, "string", strlen(text));
    add(b, text, strlen(text));
}

static void add_channels(struct bytes *b, const struct part *part)
{
    static const unsigned char codes[] = {
        [WEFT_PIXEL_UINT] = 0, [WEFT_PIXEL_HALF] = 1, [WEFT_PIXEL_FLOAT] = 2};
    size_t size = 1;
    for (size_t c = 0; c < part->image->channel_count; c++)
        size += strlen(part->sorted[c]->name) + 1 + 16;
    start_attribute(b, "channels", "chlist", size);
    for (size_t c = 0; c < part->image->channel_count; c++) {
        add_text(b, part->sorted[c]->name);
        add_number(b, codes[part->sorted[c]->type], 4);
        add_number(b, part->sorted[c]->linear, 4);
        add_number(b, 1, 4);
        add_number(b, 1, 4);
    }
    add_number(b, 0, 1);
}

static void add_box(struct bytes *b, const char *name, const int32_t box[4])
{
    start_attribute(b, name, "box2i", 16);
    for (int i = 0; i < 4; i++)
        add_number(b, (uint32_t)box[i], 4);
}

static void add_windows(struct bytes *b, const struct weft_image *image)
{
    const int32_t data[4] = {image->x, image->y, image->x + image->width - 1,
                             image->y + image->height - 1};
    const int32_t display[4] = {image->display_min[0], image->display_min[1], image->display_max[0],
                                image->display_max[1]};
    static const int32_t unset[4];
    add_box(b, "dataWindow", data);
    add_box(b, "displayWindow", memcmp(display, unset, sizeof unset) ? display : data);
}

static void add_defaults(struct bytes *b, const struct weft_image *image)
{
    enum { ONE = 0x3f800000 };
    if (!weft_image_find(image, "pixelAspectRatio")) {
        start_attribute(b, "pixelAspectRatio", "float", 4);
        add_number(b, ONE, 4);
    }
    if (!weft_image_find(image, "screenWindowCenter")) {
        start_attribute(b, "screenWindowCenter", "v2f", 8);
        add_number(b, 0, 8);
    }
    if (!weft_image_find(image, "screenWindowWidth")) {
        start_attribute(b, "screenWindowWidth", "float", 4);
        add_number(b, ONE, 4);
    }
}

static void add_header(struct bytes *b, const struct part *part, bool multipart)
{
    static const unsigned char codes[] = {[WEFT_IMAGE_NONE] = 0,
                                          [WEFT_IMAGE_RLE] = 1,
                                          [WEFT_IMAGE_ZIPS] = 2,
                                          [WEFT_IMAGE_ZIP] = 3,
                                          [WEFT_IMAGE_PIZ] = 4};
    const struct weft_image *image = part->image;
    add_channels(b, part);
    start_attribute(b, "compression", "compression", 1);
    add_number(b, codes[image->compression], 1);
    add_windows(b, image);
    start_attribute(b, "lineOrder", "lineOrder", 1);
    add_number(b, 0, 1); // increasing y
    add_defaults(b, image);
    add_string(b, "type", "scanlineimage");
    if (*image->name)
        add_string(b, "name", image->name);
    if (multipart) {
        start_attribute(b, "chunkCount", "int", 4);
        add_number(b, part->chunk_count, 4);
    }
    for (size_t i = 0; i < image->attribute_count; i++) {
        const struct weft_image_attribute *a = &image->attributes[i];
        if (weft_attribute_is_structure(a->name))
            continue;
        start_attribute(b, a->name, a->type, a->size);
        add(b, a->data, a->size);
    }
    add_number(b, 0, 1);
}

static bool has_long_names(const struct weft_image *image)
{
    for (size_t c = 0; c < image->channel_count; c++)
        if (strlen(image->channels[c].name) > SHORT_NAME)
            return true;
    for (size_t i = 0; i < image->attribute_count; i++)
        if (strlen(image->attributes[i].name) > SHORT_NAME ||
            strlen(image->attributes[i].type) > SHORT_NAME)
            return true;
    return false;
}

static enum weft_result write_headers(struct writer *w)
{
    struct bytes b = {0};
    const bool multipart = w->count > 1;
    uint32_t version = VERSION | (multipart ? MULTIPART : 0);
    for (size_t p = 0; p < w->count; p++)
        version |= has_long_names(w->parts[p].image) ? LONG_NAMES : 0;
    add_number(&b, MAGIC, 4);
    add_number(&b, version, 4);
    for (size_t p = 0; p < w->count; p++)
        add_header(&b, &w->parts[p], multipart);
    if (multipart)
        add_number(&b, 0, 1);
    enum weft_result res =
        b.failed ? fail_memory(w) : weft_output_file_write(w->file, 0, b.data, b.size);
    w->at = b.size;
    free(b.data);
    return res;
}

// ---- chunks -------------------------------------------------------------------------------------

static void note_half(struct weft_image_save_report *report, float given, uint16_t half)
{
    const float stored = weft_half_to_float(half);
    if (isfinite(stored))
        report->rounding = fmax(report->rounding, fabs((double)stored - (double)given));
    else if (isfinite(given))
        report->overflows++;
}

static unsigned char *put_line(const struct weft_image_channel *channel, size_t first, size_t width,
                               unsigned char *out, struct weft_image_save_report *report)
{
    for (size_t i = first; i < first + width; i++) {
        if (channel->type == WEFT_PIXEL_HALF) {
            const uint16_t half = weft_half_from_float(channel->plane[i]);
            note_half(report, channel->plane[i], half);
            store(out, half, 2);
            out += 2;
        } else {
            uint32_t bits;
            if (channel->type == WEFT_PIXEL_UINT)
                bits = channel->integers[i];
            else
                memcpy(&bits, channel->plane + i, sizeof bits);
            store(out, bits, 4);
            out += 4;
        }
    }
    return out;
}

// Lines of all channels, one channel after the other in each line. Returns their bytes.
static size_t gather_lines(const struct writer *w, const struct part *part, int first, int count,
                           unsigned char *out)
{
    const size_t width = (size_t)part->image->width;
    unsigned char *at = out;
    for (int y = first; y < first + count; y++)
        for (size_t c = 0; c < part->image->channel_count; c++)
            at = put_line(part->sorted[c], (size_t)y * width, width, at, w->report);
    return (size_t)(at - out);
}

static enum weft_result append(struct writer *w, const void *data, size_t size)
{
    enum weft_result res = weft_output_file_write(w->file, w->at, data, size);
    w->at += size;
    return res;
}

static enum weft_result write_chunk(struct writer *w, size_t p, int line,
                                    const struct weft_chunk *chunk)
{
    unsigned char head[12];
    const size_t skipped = w->count > 1 ? 0 : 4;
    struct part *part = &w->parts[p];
    store(part->table + 8 * (size_t)(line / part->lines), w->at, 8);
    store(head, p, 4);
    store(head + 4, (uint32_t)(part->image->y + line), 4);
    store(head + 8, chunk->size, 4);
    w->report->chunks++;
    w->report->raw += !chunk->packed;
    enum weft_result res = append(w, head + skipped, sizeof head - skipped);
    return res == WEFT_OK ? append(w, chunk->data, chunk->size) : res;
}

static bool report_step(struct writer *w)
{
    return !w->progress ||
           w->progress->report(w->progress->priv, (double)w->chunks_done++ / (double)w->chunks_all);
}

static enum weft_result write_lines(struct writer *w, size_t p, weft_chunk_packer *packer,
                                    unsigned char *raw)
{
    const struct part *part = &w->parts[p];
    const int height = part->image->height;
    enum weft_result res = WEFT_OK;
    for (int line = 0; res == WEFT_OK && line < height; line += part->lines) {
        const int count = height - line < part->lines ? height - line : part->lines;
        struct weft_chunk chunk;
        if (!report_step(w))
            return WEFT_ERR_CANCELLED;
        const size_t size = gather_lines(w, part, line, count, raw);
        res = weft_chunk_pack(packer, raw, size, &chunk);
        if (res != WEFT_OK)
            weft_error(w->file->log,
                       "cannot write %s: lines %d to %d, packed, do not unpack to what they were",
                       w->file->path, line, line + count - 1);
        else
            res = write_chunk(w, p, line, &chunk);
    }
    return res;
}

static enum weft_result write_part(struct writer *w, size_t p)
{
    const struct part *part = &w->parts[p];
    const size_t capacity = part->line_bytes * (size_t)part->lines;
    weft_chunk_packer *packer = NULL;
    const struct weft_chunk_shape shape = {.width = (size_t)part->image->width,
                                           .channel_count = part->image->channel_count,
                                           .words = part->words};
    unsigned char *raw = malloc(capacity);
    enum weft_result res =
        raw ? weft_chunk_packer_create(part->image->compression, capacity, &shape, &packer)
            : WEFT_ERR_MEMORY;
    if (res == WEFT_OK)
        res = write_lines(w, p, packer, raw);
    else
        res = fail_memory(w);
    weft_chunk_packer_destroy(&packer);
    free(raw);
    w->report->values +=
        (uint64_t)part->image->width * (uint64_t)part->image->height * part->image->channel_count;
    return res;
}

// ---- parts --------------------------------------------------------------------------------------

static int compare_names(const void *a, const void *b)
{
    const struct weft_image_channel *const *p = a, *const *q = b;
    return strcmp((*p)->name, (*q)->name);
}

static enum weft_result set_part(struct writer *w, const struct weft_image *image, struct part *out)
{
    const size_t count = image->channel_count;
    *out = (struct part){.image = image, .lines = weft_chunk_lines(image->compression)};
    out->chunk_count = (size_t)((image->height - 1) / out->lines + 1);
    out->sorted = calloc(count, sizeof *out->sorted);
    out->words = malloc(count);
    out->table = calloc(out->chunk_count, 8);
    if (!out->sorted || !out->words || !out->table)
        return fail_memory(w);
    for (size_t c = 0; c < count; c++)
        out->sorted[c] = &image->channels[c];
    qsort(out->sorted, count, sizeof *out->sorted, compare_names);
    size_t pixel_bytes = 0;
    for (size_t c = 0; c < count; c++) {
        out->words[c] = out->sorted[c]->type == WEFT_PIXEL_HALF ? 1 : 2;
        pixel_bytes += 2 * out->words[c];
    }
    // At most 2^15 channels of 2^31 pixels in a line.
    out->line_bytes = pixel_bytes * (size_t)image->width;
    w->chunks_all += out->chunk_count;
    if (out->line_bytes <= (size_t)INT32_MAX / (size_t)out->lines)
        return WEFT_OK;
    weft_error(w->file->log, "cannot write %s: %d lines are %zu bytes, the limit is %d",
               w->file->path, out->lines, out->line_bytes * (size_t)out->lines, INT32_MAX);
    return WEFT_ERR_LIMIT;
}

// First as zeros, so that chunks find their place behind them, then as they are.
static enum weft_result write_tables(struct writer *w, bool final)
{
    enum weft_result res = WEFT_OK;
    for (size_t p = 0; res == WEFT_OK && p < w->count; p++) {
        struct part *part = &w->parts[p];
        const size_t size = 8 * part->chunk_count;
        if (!final) {
            part->table_at = w->at;
            w->at += size;
        }
        res = weft_output_file_write(w->file, part->table_at, part->table, size);
    }
    return res;
}

enum weft_result weft_image_write(const struct weft_image *parts, size_t count,
                                  const struct weft_progress *progress,
                                  struct weft_output_file *file,
                                  struct weft_image_save_report *report)
{
    struct writer w = {.count = count, .file = file, .progress = progress, .report = report};
    w.parts = calloc(count, sizeof *w.parts);
    enum weft_result res = w.parts ? WEFT_OK : fail_memory(&w);
    for (size_t p = 0; res == WEFT_OK && p < count; p++)
        res = set_part(&w, &parts[p], &w.parts[p]);
    if (res == WEFT_OK)
        res = write_headers(&w);
    if (res == WEFT_OK)
        res = write_tables(&w, false);
    for (size_t p = 0; res == WEFT_OK && p < count; p++)
        res = write_part(&w, p);
    if (res == WEFT_OK)
        res = write_tables(&w, true);
    for (size_t p = 0; w.parts && p < count; p++) {
        free(w.parts[p].sorted);
        free(w.parts[p].words);
        free(w.parts[p].table);
    }
    free(w.parts);
    return res;
}
