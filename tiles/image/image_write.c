// SPDX-License-Identifier: BSD-3-Clause
// OpenEXRCore writes the file and packs PIZ. Its own writing of chunks is not used: 3.1 stores one
// whose packed form is as long as the raw lines packed, and every reader takes it for raw.
#include "tiles/image/image_write.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/half.h"
#include "tiles/image/image_chunk.h"
#include "tiles/image/image_header.h"

struct part {
    const struct weft_image *image;
    const struct weft_image_channel **sorted; // the format has channels by name
    size_t line_bytes;
    int lines; // of a chunk
};

struct writer {
    struct part *parts;
    size_t count;
    struct weft_output_file *file;
    const struct weft_progress *progress;
    struct weft_image_save_report *report;
    exr_context_t exr;
    enum weft_result stream_result; // of the writes that OpenEXRCore asked for
    char message[200];              // OpenEXRCore's first
    size_t chunks_done, chunks_all;
};

static enum weft_result fail_memory(const struct writer *w)
{
    weft_error(w->file->log, "cannot write %s: out of memory", w->file->path);
    return WEFT_ERR_MEMORY;
}

// ---- OpenEXRCore --------------------------------------------------------------------------------

// The handler cannot ask the context for its user data: OpenEXRCore 3.1 may hold the context's
// lock.
static _Thread_local struct writer *current;

static void keep_message(exr_const_context_t exr, exr_result_t code, const char *message)
{
    (void)exr;
    (void)code;
    if (current && !current->message[0])
        snprintf(current->message, sizeof current->message, "%s", message);
}

static int64_t write_bytes(exr_const_context_t exr, void *priv, const void *data, uint64_t size,
                           uint64_t offset, exr_stream_error_func_ptr_t error)
{
    struct writer *w = priv;
    if (w->stream_result == WEFT_OK)
        w->stream_result = weft_output_file_write(w->file, offset, data, size);
    if (w->stream_result == WEFT_OK)
        return (int64_t)size;
    error(exr, EXR_ERR_WRITE_IO, "write failed");
    return -1;
}

static enum weft_result result_of(struct writer *w, exr_result_t code)
{
    if (code == EXR_ERR_SUCCESS)
        return WEFT_OK;
    if (w->stream_result != WEFT_OK)
        return w->stream_result;
    if (code == EXR_ERR_OUT_OF_MEMORY)
        return fail_memory(w);
    weft_error(w->file->log, "cannot write %s: %s", w->file->path,
               w->message[0] ? w->message : exr_get_default_error_message(code));
    return WEFT_ERR_WRITE;
}

static exr_result_t start(struct writer *w)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = keep_message;
    init.alloc_fn = malloc;
    init.free_fn = free;
    init.user_data = w;
    init.write_fn = write_bytes;
    exr_result_t rv = exr_start_write(&w->exr, w->file->path, EXR_WRITE_FILE_DIRECTLY, &init);
    for (size_t p = 0; !rv && p < w->count; p++)
        rv = weft_image_header_add(w->exr, w->parts[p].image, w->parts[p].sorted);
    return rv ? rv : exr_write_header(w->exr);
}

// ---- lines --------------------------------------------------------------------------------------

static void store(unsigned char *out, uint32_t value, size_t size)
{
    for (size_t i = 0; i < size; i++)
        out[i] = (unsigned char)(value >> 8 * i);
}

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

// ---- PIZ ----------------------------------------------------------------------------------------

// Lines that are gathered already, and a pipeline that packs them and writes nothing.
struct piz {
    exr_encode_pipeline_t encode;
    const void *raw;
    size_t size;
};

static exr_result_t take_lines(exr_encode_pipeline_t *encode)
{
    const struct piz *piz = encode->encoding_user_data;
    memcpy(encode->packed_buffer, piz->raw, piz->size);
    encode->packed_bytes = piz->size;
    return EXR_ERR_SUCCESS;
}

static exr_result_t start_piz(struct writer *w, size_t p, const exr_chunk_info_t *info,
                              struct piz *piz)
{
    exr_encode_pipeline_t *encode = &piz->encode;
    exr_result_t rv = exr_encoding_initialize(w->exr, (int)p, info, encode);
    if (!rv)
        rv = exr_encoding_choose_default_routines(w->exr, (int)p, encode);
    encode->encoding_user_data = piz;
    encode->convert_and_pack_fn = take_lines;
    encode->yield_until_ready_fn = NULL;
    encode->write_fn = NULL;
    return rv;
}

static exr_result_t pack_piz(struct writer *w, size_t p, int line, struct piz *piz,
                             struct weft_chunk *out)
{
    exr_encode_pipeline_t *encode = &piz->encode;
    exr_chunk_info_t info;
    exr_result_t rv =
        exr_write_scanline_chunk_info(w->exr, (int)p, w->parts[p].image->y + line, &info);
    if (!rv)
        rv = encode->context ? exr_encoding_update(w->exr, (int)p, &info, encode)
                             : start_piz(w, p, &info, piz);
    for (int c = 0; !rv && c < encode->channel_count; c++) {
        exr_coding_channel_info_t *channel = &encode->channels[c];
        channel->encode_from_ptr = piz->raw; // take_lines knows where they are
        channel->user_bytes_per_element = channel->bytes_per_element;
        channel->user_data_type = channel->data_type;
    }
    if (!rv)
        rv = exr_encoding_run(w->exr, (int)p, encode);
    *out = (struct weft_chunk){.data = piz->raw, .size = piz->size};
    if (!rv && encode->compressed_bytes < piz->size)
        *out = (struct weft_chunk){
            .data = encode->compressed_buffer, .size = encode->compressed_bytes, .packed = true};
    return rv;
}

// ---- chunks -------------------------------------------------------------------------------------

static bool report_step(struct writer *w)
{
    return !w->progress ||
           w->progress->report(w->progress->priv, (double)w->chunks_done++ / (double)w->chunks_all);
}

struct packing {
    weft_chunk_packer *packer; // NULL: PIZ
    struct piz piz;
    unsigned char *raw; // room for one chunk
};

static enum weft_result pack(struct writer *w, size_t p, int line, int count,
                             struct packing *packing, struct weft_chunk *out)
{
    const size_t size = gather_lines(w, &w->parts[p], line, count, packing->raw);
    if (!packing->packer) {
        packing->piz.raw = packing->raw;
        packing->piz.size = size;
        return result_of(w, pack_piz(w, p, line, &packing->piz, out));
    }
    enum weft_result res = weft_chunk_pack(packing->packer, packing->raw, size, out);
    if (res != WEFT_OK)
        weft_error(w->file->log,
                   "cannot write %s: lines %d to %d, packed, do not unpack to what they were",
                   w->file->path, line, line + count - 1);
    return res;
}

static enum weft_result write_lines(struct writer *w, size_t p, struct packing *packing)
{
    const struct part *part = &w->parts[p];
    const int height = part->image->height;
    enum weft_result res = WEFT_OK;
    for (int line = 0; res == WEFT_OK && line < height; line += part->lines) {
        const int count = height - line < part->lines ? height - line : part->lines;
        struct weft_chunk chunk;
        if (!report_step(w))
            return WEFT_ERR_CANCELLED;
        res = pack(w, p, line, count, packing, &chunk);
        if (res != WEFT_OK)
            return res;
        w->report->chunks++;
        w->report->raw += !chunk.packed;
        res = result_of(w, exr_write_scanline_chunk(w->exr, (int)p, part->image->y + line,
                                                    chunk.data, chunk.size));
    }
    return res;
}

static enum weft_result write_part(struct writer *w, size_t p)
{
    const struct weft_image *image = w->parts[p].image;
    const size_t capacity = w->parts[p].line_bytes * (size_t)w->parts[p].lines;
    struct packing packing = {.raw = malloc(capacity)};
    enum weft_result res = packing.raw ? WEFT_OK : WEFT_ERR_MEMORY;
    if (res == WEFT_OK && image->compression != WEFT_IMAGE_PIZ)
        res = weft_chunk_packer_create(image->compression, capacity, &packing.packer);
    if (res == WEFT_OK)
        res = write_lines(w, p, &packing);
    else
        res = fail_memory(w);
    if (packing.piz.encode.context)
        exr_encoding_destroy(w->exr, &packing.piz.encode);
    weft_chunk_packer_destroy(&packing.packer);
    free(packing.raw);
    w->report->values += (uint64_t)image->width * (uint64_t)image->height * image->channel_count;
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
    out->sorted = calloc(count, sizeof *out->sorted);
    if (!out->sorted)
        return fail_memory(w);
    size_t pixel_bytes = 0;
    for (size_t c = 0; c < count; c++) {
        out->sorted[c] = &image->channels[c];
        pixel_bytes += image->channels[c].type == WEFT_PIXEL_HALF ? 2 : 4;
    }
    qsort(out->sorted, count, sizeof *out->sorted, compare_names);
    // At most 2^15 channels of 2^31 pixels in a line.
    out->line_bytes = pixel_bytes * (size_t)image->width;
    w->chunks_all += (size_t)((image->height - 1) / out->lines + 1);
    if (out->line_bytes <= (size_t)INT32_MAX / (size_t)out->lines)
        return WEFT_OK;
    weft_error(w->file->log, "cannot write %s: %d lines are %zu bytes, the limit is %d",
               w->file->path, out->lines, out->line_bytes * (size_t)out->lines, INT32_MAX);
    return WEFT_ERR_LIMIT;
}

static enum weft_result write_file(struct writer *w)
{
    struct writer *outer = current; // of a progress callback that saves, too
    current = w;
    enum weft_result res = result_of(w, start(w));
    for (size_t p = 0; res == WEFT_OK && p < w->count; p++)
        res = write_part(w, p);
    if (w->exr) {
        const exr_result_t finished = exr_finish(&w->exr);
        res = res == WEFT_OK ? result_of(w, finished) : res;
    }
    current = outer;
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
        res = write_file(&w);
    if (res == WEFT_OK && !report_step(&w))
        res = WEFT_ERR_CANCELLED;
    for (size_t p = 0; w.parts && p < count; p++)
        free(w.parts[p].sorted);
    free(w.parts);
    return res;
}
