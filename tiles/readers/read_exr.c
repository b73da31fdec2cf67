// SPDX-License-Identifier: BSD-3-Clause
// weft-read-exr: EXR headers and flat EXR images (level 0) for libweft, see wire.h.
#include <inttypes.h>
#include <malloc.h>
#include <pthread.h>
#include <stdlib.h>

#include "filter/check.h"
#include "filter/threads.h"
#include "tiles/readers/exr_file.h"
#include "tiles/readers/exr_unzip.h"

enum {
    STACK = 1 << 20,            // bytes of a thread's
    WORTH_A_THREAD = 256 << 10, // bytes of planes
};

struct pipeline {
    exr_decode_pipeline_t decode;
    struct weft_exr_unzip unzip;
};

// A part on its way into planes: blocks of lines, or tiles, each by one thread.
struct decoding {
    struct weft_exr_file *file;
    char *planes;
    bool own_types;        // as struct weft_wire_frame has planes, not all of four bytes a value
    int64_t width, height; // of a block, but for the last ones
    size_t across;         // blocks in a row
    size_t first, count;   // of the blocks that are decoded, in all
    struct pipeline *pipelines; // of each thread
    // The first block that cannot be decoded: blocks are begun in order, so that it is the same one
    // whatever the number of threads.
    pthread_mutex_t lock;
    size_t failed; // count: none
    exr_result_t code;
    struct weft_exr_complaint complaint;
};

// What a chunk must be, whatever the file says.
struct block {
    int64_t x, y, width, height; // relative to the data window
};

static int64_t smaller(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

static struct block block_of(const struct decoding *d, size_t i)
{
    const struct weft_exr_file *file = d->file;
    const int64_t x = (int64_t)(i % d->across) * d->width, y = (int64_t)(i / d->across) * d->height;
    return (struct block){x, y, smaller(d->width, file->width - x),
                          smaller(d->height, file->height - y)};
}

// Bytes of a value in memory.
static size_t value_size(const struct decoding *d, exr_pixel_type_t type)
{
    return d->own_types && type == EXR_PIXEL_HALF ? 2 : 4;
}

// Types are kept, or half becomes float and uint stays uint: OpenEXRCore's own conversion of those
// is by way of other roundings.
static void point_to(const struct decoding *d, exr_decode_pipeline_t *decode, int64_t x, int64_t y)
{
    const struct weft_exr_file *file = d->file;
    const size_t pixels = (size_t)file->width * (size_t)file->rows;
    char *plane = d->planes;
    for (int c = 0; c < decode->channel_count; c++) {
        exr_coding_channel_info_t *channel = &decode->channels[c];
        const exr_pixel_type_t type = (exr_pixel_type_t)channel->data_type;
        const size_t value = value_size(d, type);
        size_t bytes = pixels * value;
        channel->decode_to_ptr =
            (uint8_t *)plane + (size_t)((y - file->first_row) * file->width + x) * value;
        channel->user_bytes_per_element = (int16_t)value;
        channel->user_data_type =
            type == EXR_PIXEL_HALF && !d->own_types ? EXR_PIXEL_FLOAT : (uint16_t)type;
        channel->user_pixel_stride = (int32_t)value;
        channel->user_line_stride = (int32_t)((size_t)file->width * value);
        if (d->own_types)
            weft_wire_align(bytes, &bytes);
        plane += bytes;
    }
}

static exr_result_t find_chunk(const struct decoding *d, const struct block *b,
                               exr_chunk_info_t *out)
{
    const struct weft_exr_file *file = d->file;
    if (file->storage == EXR_STORAGE_TILED)
        return exr_read_tile_chunk_info(file->exr, file->part, (int)(b->x / d->width),
                                        (int)(b->y / d->height), 0, 0, out);
    return exr_read_scanline_chunk_info(file->exr, file->part, (int)(file->data.min.y + b->y), out);
}

static exr_result_t choose_routines(const struct weft_exr_file *file, struct pipeline *pipeline)
{
    const exr_result_t rv =
        exr_decoding_choose_default_routines(file->exr, file->part, &pipeline->decode);
    if (!rv &&
        (file->compression == EXR_COMPRESSION_ZIP || file->compression == EXR_COMPRESSION_ZIPS))
        weft_exr_unzip_install(&pipeline->unzip, &pipeline->decode);
    return rv;
}

static exr_result_t decode_block(const struct decoding *d, struct pipeline *pipeline, size_t i)
{
    const struct weft_exr_file *file = d->file;
    exr_decode_pipeline_t *decode = &pipeline->decode;
    const struct block block = block_of(d, i);
    exr_chunk_info_t chunk;
    exr_result_t rv = find_chunk(d, &block, &chunk);
    if (rv)
        return rv;
    if (chunk.width != block.width || chunk.height != block.height)
        return EXR_ERR_CORRUPT_CHUNK;
    bool first = decode->channels == NULL;
    rv = first ? exr_decoding_initialize(file->exr, file->part, &chunk, decode)
               : exr_decoding_update(file->exr, file->part, &chunk, decode);
    if (rv)
        return rv;
    if (decode->channel_count != file->channels->num_channels)
        return EXR_ERR_CORRUPT_CHUNK;
    point_to(d, decode, block.x, block.y);
    if (first)
        rv = choose_routines(file, pipeline);
    return rv ? rv : exr_decoding_run(file->exr, file->part, decode);
}

static bool decode_one(void *priv, int thread, size_t i)
{
    struct decoding *d = priv;
    struct weft_exr_complaint own = {0}, *outer = weft_exr_complain(&own);
    const exr_result_t rv = decode_block(d, &d->pipelines[thread], d->first + i);
    weft_exr_complain(outer);
    if (!rv)
        return true;
    pthread_mutex_lock(&d->lock);
    if (i < d->failed) {
        d->failed = i;
        d->code = rv;
        d->complaint = own;
    }
    pthread_mutex_unlock(&d->lock);
    return false;
}

// Sizes of the blocks.
static exr_result_t measure_blocks(struct decoding *d)
{
    struct weft_exr_file *file = d->file;
    int32_t width = 0, height = 0;
    exr_result_t rv = file->storage == EXR_STORAGE_TILED
                          ? exr_get_tile_sizes(file->exr, file->part, 0, 0, &width, &height)
                          : exr_get_scanlines_per_chunk(file->exr, file->part, &height);
    if (!rv && (height < 1 || (file->storage == EXR_STORAGE_TILED && width < 1)))
        rv = EXR_ERR_CORRUPT_CHUNK;
    if (rv)
        return rv;
    d->width = file->storage == EXR_STORAGE_TILED ? width : file->width;
    d->height = height;
    d->across = (size_t)((file->width - 1) / d->width + 1);
    return rv;
}

// Those that have rows which are read.
static void number_blocks(struct decoding *d)
{
    const struct weft_exr_file *file = d->file;
    d->first = d->across * (size_t)(file->first_row / d->height);
    d->count = d->across * (size_t)((file->rows - 1) / d->height + 1);
}

// As many as are asked for, worth their start, and sure to find memory: a thread holds its stack
// and a block in several forms.
static int choose_threads(const struct decoding *d, size_t bytes)
{
    const struct weft_exr_file *file = d->file;
    const uint64_t asked = file->server->request->threads,
                   memory = file->server->limits.memory_bytes;
    const uint64_t block = (uint64_t)smaller(d->width, file->width) *
                           (uint64_t)smaller(d->height, file->height) *
                           (uint64_t)file->channels->num_channels * sizeof(float);
    const uint64_t free_bytes = memory > bytes ? memory - bytes : 0;
    const uint64_t most[] = {asked, d->count, 1 + bytes / WORTH_A_THREAD, WEFT_IMAGE_MAX_THREADS,
                             1 + free_bytes / 2 / (STACK + 6 * block)};
    uint64_t threads = most[0] ? most[0] : 1;
    for (size_t i = 1; i < WEFT_COUNT(most); i++)
        threads = most[i] < threads ? most[i] : threads;
    return (int)threads;
}

static exr_result_t decode_all(struct decoding *d, int threads)
{
    struct weft_exr_file *file = d->file;
    d->failed = d->count;
    d->code = EXR_ERR_OUT_OF_MEMORY;
    d->pipelines = weft_exr_allocate((size_t)threads * sizeof *d->pipelines);
    if (!d->pipelines)
        return EXR_ERR_OUT_OF_MEMORY;
    for (int t = 0; t < threads; t++)
        d->pipelines[t] = (struct pipeline){EXR_DECODE_PIPELINE_INITIALIZER, {0}};
    const bool whole = weft_threads_run(threads, d->count, decode_one, d);
    for (int t = 0; t < threads; t++) {
        exr_decoding_destroy(file->exr, &d->pipelines[t].decode);
        weft_exr_unzip_clear(&d->pipelines[t].unzip);
    }
    free(d->pipelines);
    if (whole)
        return EXR_ERR_SUCCESS;
    file->complaint = d->complaint;
    return d->code;
}

// Into d->planes.
static enum weft_result decode_planes(struct decoding *d, size_t bytes)
{
    struct weft_exr_file *file = d->file;
    const int threads = choose_threads(d, bytes);
    exr_result_t rv = decode_all(d, threads);
    if (rv && file->complaint.refused && threads > 1) { // one may still have room
        file->complaint = d->complaint = (struct weft_exr_complaint){{0}, 0};
        rv = decode_all(d, 1);
    }
    return rv ? weft_exr_fail(file, rv) : WEFT_OK;
}

// What the planes need, and how they come about.
static enum weft_result prepare(struct decoding *d, size_t *bytes)
{
    enum weft_result res = weft_exr_check_kind(d->file);
    if (res != WEFT_OK)
        return res;
    const exr_result_t rv = measure_blocks(d);
    if (rv)
        return weft_exr_fail(d->file, rv);
    if (!d->own_types)
        res = weft_exr_choose_rows(d->file, d->height);
    number_blocks(d);
    return res == WEFT_OK ? weft_exr_measure(d->file, d->own_types, bytes) : res;
}

static enum weft_result answer_pixels(struct weft_exr_file *file)
{
    size_t bytes = 0;
    struct decoding d = {.file = file, .lock = PTHREAD_MUTEX_INITIALIZER};
    if (weft_exr_is_dwa(file))
        return weft_server_fail(file->server, WEFT_ERR_UNSUPPORTED, "DWA is read by weft-read-dwa");
    const enum weft_result res = prepare(&d, &bytes);
    if (res != WEFT_OK)
        return res;
    d.planes = weft_server_map(file->server, bytes); // zero, should a chunk leave a gap
    return d.planes ? decode_planes(&d, bytes) : (enum weft_result)file->server->answer.result;
}

static enum weft_result answer_frame(struct weft_exr_file *file)
{
    size_t bytes = 0;
    struct decoding d = {.file = file, .own_types = true, .lock = PTHREAD_MUTEX_INITIALIZER};
    const bool info_only = file->server->request->info_only;
    if (weft_exr_is_dwa(file) && !info_only) {
        file->server->answer.verdict = WEFT_WIRE_OTHER_PROGRAM;
        return WEFT_OK;
    }
    enum weft_result res = info_only ? WEFT_OK : prepare(&d, &bytes);
    if (res == WEFT_OK)
        res = weft_exr_begin_frame(file, bytes, &d.planes);
    return d.planes ? decode_planes(&d, bytes) : res;
}

static enum weft_result answer_info(struct weft_exr_file *file)
{
    void *info = NULL;
    size_t size = 0;
    const enum weft_result res = weft_exr_inform(file, &info, &size);
    if (res == WEFT_OK)
        weft_server_append(file->server, info, size);
    free(info);
    return res;
}

static enum weft_result handle(struct weft_server *server)
{
    struct weft_exr_file *file = server->priv;
    const uint32_t op = server->request->op;
    file->server = server;
    file->complaint = (struct weft_exr_complaint){{0}, 0};
    weft_exr_complain(&file->complaint);
    if (op == WEFT_WIRE_IMAGE_FRAME)
        weft_exr_close(file); // the one before
    enum weft_result res = weft_exr_open(file);
    if (res == WEFT_OK)
        res = weft_exr_take_part(file, server->request->part);
    if (res != WEFT_OK)
        return res;
    switch (op) {
    case WEFT_WIRE_IMAGE_INFO:
        return answer_info(file);
    case WEFT_WIRE_IMAGE_PIXELS:
        return answer_pixels(file);
    case WEFT_WIRE_IMAGE_FRAME:
        return answer_frame(file);
    }
    return weft_server_fail(server, WEFT_ERR_READER, "weft-read-exr: unknown request %" PRIu32, op);
}

int main(int argc, char **argv)
{
    struct weft_exr_file file = {0};
    pthread_attr_t attributes;
    // Address space is limited: by default a thread's stack takes 8 MiB of it and its heap 64.
    if (!pthread_attr_init(&attributes) && !pthread_attr_setstacksize(&attributes, STACK))
        pthread_setattr_default_np(&attributes);
    mallopt(M_ARENA_MAX, 1);
    const int status = weft_server_run(argc, argv, handle, &file);
    weft_exr_close(&file);
    return status;
}
