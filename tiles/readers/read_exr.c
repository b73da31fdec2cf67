// SPDX-License-Identifier: BSD-3-Clause
// weft-read-exr: EXR headers and flat EXR images (level 0) for libweft, see wire.h.
#include <errno.h>
#include <inttypes.h>
#include <limits.h>
#include <malloc.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <openexr.h>

#include "filter/check.h"
#include "filter/threads.h"
#include "tiles/image/image_attribute.h"
#include "tiles/image/image_wire.h"
#include "tiles/process/server.h"

enum {
    SIDE_LIMIT = 1 << 29,       // line strides are int32 bytes in OpenEXRCore
    RATIO_LIMIT = 10000,        // declared bytes per stored byte, as OpenImageIO has it
    STACK = 1 << 20,            // bytes of a thread's
    WORTH_A_THREAD = 256 << 10, // bytes of planes
};
#define RATIO_FLOOR_BYTES (UINT64_C(1) << 30)

// What went wrong in OpenEXRCore.
struct complaint {
    char message[256]; // the first that it told
    size_t refused;    // bytes of an allocation that failed, else 0
};

struct reader {
    struct weft_server *server;
    exr_context_t exr;
    struct complaint complaint; // of this request
    uint64_t file_bytes;
    int part, part_count;
    exr_attr_box2i_t data, display;
    int64_t width, height;
    exr_storage_t storage;
    exr_compression_t compression;
    const exr_attr_chlist_t *channels;
};

static const enum weft_image_compression compressions[] = {
    WEFT_IMAGE_NONE,  WEFT_IMAGE_RLE, WEFT_IMAGE_ZIPS, WEFT_IMAGE_ZIP,  WEFT_IMAGE_PIZ,
    WEFT_IMAGE_PXR24, WEFT_IMAGE_B44, WEFT_IMAGE_B44A, WEFT_IMAGE_DWAA, WEFT_IMAGE_DWAB,
};
static const enum weft_pixel_type types[] = {WEFT_PIXEL_UINT, WEFT_PIXEL_HALF, WEFT_PIXEL_FLOAT};

// ---- opening ------------------------------------------------------------------------------------

// Of each thread. The handler cannot ask the context for its user data: OpenEXRCore 3.1 may hold
// the context's lock.
static _Thread_local struct complaint *current;

static void keep_message(exr_const_context_t exr, exr_result_t code, const char *message)
{
    (void)exr;
    (void)code;
    if (current && !current->message[0])
        snprintf(current->message, sizeof current->message, "%s", message);
}

// OpenEXRCore 3.1 says "out of memory" of damaged data as well.
static void *allocate(size_t size)
{
    void *memory = malloc(size);
    if (!memory && current)
        current->refused = size;
    return memory;
}

static int64_t read_bytes(exr_const_context_t exr, void *priv, void *buffer, uint64_t size,
                          uint64_t offset, exr_stream_error_func_ptr_t error)
{
    struct reader *r = priv;
    uint64_t done = 0;
    if (offset > INT64_MAX || size > INT64_MAX - offset) {
        error(exr, EXR_ERR_READ_IO, "offset %" PRIu64 " is beyond any file", offset);
        return -1;
    }
    while (done < size) {
        ssize_t n =
            pread(r->server->input_fd, (char *)buffer + done, size - done, (off_t)(offset + done));
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0) {
            error(exr, EXR_ERR_READ_IO, "%s", strerror(errno));
            return -1;
        }
        if (n == 0)
            break;
        done += (uint64_t)n;
    }
    return (int64_t)done;
}

static int64_t query_size(exr_const_context_t exr, void *priv)
{
    (void)exr;
    return (int64_t)((struct reader *)priv)->file_bytes;
}

static enum weft_result fail_exr(struct reader *r, exr_result_t code)
{
    const struct complaint *complaint = &r->complaint;
    if (complaint->refused)
        return weft_server_fail(r->server, WEFT_ERR_LIMIT,
                                "another %zu bytes do not fit in the memory limit of %" PRIu64
                                " bytes",
                                complaint->refused, r->server->limits.memory_bytes);
    return weft_server_fail(
        r->server, code == EXR_ERR_FEATURE_NOT_IMPLEMENTED ? WEFT_ERR_UNSUPPORTED : WEFT_ERR_FORMAT,
        "%s", complaint->message[0] ? complaint->message : exr_get_default_error_message(code));
}

static enum weft_result open_file(struct reader *r)
{
    struct stat st;
    if (fstat(r->server->input_fd, &st))
        return weft_server_fail(r->server, WEFT_ERR_OPEN, "%s", strerror(errno));
    r->file_bytes = (uint64_t)st.st_size;

    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = keep_message;
    init.alloc_fn = allocate;
    init.free_fn = free;
    init.user_data = r;
    init.read_fn = read_bytes;
    init.size_fn = query_size;
    init.max_image_width = init.max_image_height = SIDE_LIMIT;
    init.max_tile_width = init.max_tile_height = SIDE_LIMIT;
    init.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    exr_result_t rv = exr_start_read(&r->exr, r->server->path, &init);
    if (!rv)
        rv = exr_get_count(r->exr, &r->part_count);
    return rv ? fail_exr(r, rv) : WEFT_OK;
}

// ---- the header ---------------------------------------------------------------------------------

static exr_result_t read_header(struct reader *r)
{
    exr_result_t rv = exr_get_storage(r->exr, r->part, &r->storage);
    if (!rv)
        rv = exr_get_compression(r->exr, r->part, &r->compression);
    if (!rv)
        rv = exr_get_data_window(r->exr, r->part, &r->data);
    if (!rv)
        rv = exr_get_display_window(r->exr, r->part, &r->display);
    if (!rv)
        rv = exr_get_channels(r->exr, r->part, &r->channels);
    return rv;
}

static enum weft_result check_windows(struct reader *r)
{
    struct weft_server *s = r->server;
    r->width = (int64_t)r->data.max.x - r->data.min.x + 1;
    r->height = (int64_t)r->data.max.y - r->data.min.y + 1;
    if (r->width < 1 || r->height < 1)
        return weft_server_fail(s, WEFT_ERR_FORMAT, "the data window is empty");
    if (r->width >= SIDE_LIMIT || r->height >= SIDE_LIMIT)
        return weft_server_fail(s, WEFT_ERR_LIMIT,
                                "%" PRId64 " x %" PRId64 " pixels, the limit of a side is %d",
                                r->width, r->height, SIDE_LIMIT - 1);
    if (r->display.min.x > r->display.max.x || r->display.min.y > r->display.max.y)
        return weft_server_fail(s, WEFT_ERR_FORMAT, "the display window is empty");
    return WEFT_OK;
}

static enum weft_result check_channels(struct reader *r)
{
    struct weft_server *s = r->server;
    int count = r->channels->num_channels;
    if (count < 1)
        return weft_server_fail(s, WEFT_ERR_FORMAT, "it has no channels");
    if (count > INT16_MAX)
        return weft_server_fail(s, WEFT_ERR_LIMIT, "%d channels, the limit is %d", count,
                                INT16_MAX);
    for (int c = 0; c < count; c++) {
        const exr_attr_chlist_entry_t *e = &r->channels->entries[c];
        if ((unsigned)e->pixel_type >= WEFT_COUNT(types))
            return weft_server_fail(s, WEFT_ERR_FORMAT, "channel %s has the unknown type %d",
                                    e->name.str, (int)e->pixel_type);
        if (e->x_sampling < 1 || e->y_sampling < 1)
            return weft_server_fail(s, WEFT_ERR_FORMAT, "channel %s has a sampling of %d x %d",
                                    e->name.str, e->x_sampling, e->y_sampling);
    }
    return WEFT_OK;
}

static enum weft_result check_header(struct reader *r)
{
    struct weft_server *s = r->server;
    if ((unsigned)r->compression >= WEFT_COUNT(compressions))
        return weft_server_fail(s, WEFT_ERR_UNSUPPORTED, "compression %d is unknown",
                                (int)r->compression);
    enum weft_result res = check_windows(r);
    return res == WEFT_OK ? check_channels(r) : res;
}

// ---- the header as it is ------------------------------------------------------------------------

static const unsigned char *map_file(struct reader *r)
{
    void *data = mmap(NULL, r->file_bytes, PROT_READ, MAP_PRIVATE, r->server->input_fd, 0);
    if (data != MAP_FAILED)
        return data;
    weft_server_fail(r->server, WEFT_ERR_LIMIT, "cannot map its %" PRIu64 " bytes: %s",
                     r->file_bytes, strerror(errno));
    return NULL;
}

// From the part's first attribute to the zero that ends its header, behind those of other parts.
static bool find_header(const struct reader *r, const unsigned char *file, size_t *first,
                        size_t *end)
{
    struct weft_image_attribute attribute;
    enum weft_attribute_step step = WEFT_ATTRIBUTE_END;
    size_t at = 8; // magic and version
    for (int part = 0; step == WEFT_ATTRIBUTE_END && part <= r->part; part++) {
        *first = at;
        do
            step = weft_attribute_next(file, r->file_bytes, &at, &attribute);
        while (step == WEFT_ATTRIBUTE_TAKEN);
    }
    *end = at;
    return step == WEFT_ATTRIBUTE_END;
}

// ---- answers ------------------------------------------------------------------------------------

static enum weft_result append(struct reader *r, const void *data, size_t size)
{
    return weft_server_append(r->server, data, size) ? WEFT_OK
                                                     : (enum weft_result)r->server->answer.result;
}

static enum weft_result append_channels(struct reader *r)
{
    enum weft_result res = WEFT_OK;
    for (int c = 0; res == WEFT_OK && c < r->channels->num_channels; c++) {
        const exr_attr_chlist_entry_t *e = &r->channels->entries[c];
        struct weft_wire_channel channel = {.type = types[e->pixel_type],
                                            .linear = e->p_linear != 0,
                                            .sampling = {e->x_sampling, e->y_sampling}};
        snprintf(channel.name, sizeof channel.name, "%.*s", (int)e->name.length, e->name.str);
        res = append(r, &channel, sizeof channel);
    }
    return res;
}

static enum weft_result append_info(struct reader *r, const unsigned char *header, size_t size)
{
    const struct weft_wire_image wire = {
        .x = r->data.min.x,
        .y = r->data.min.y,
        .width = (int32_t)r->width,
        .height = (int32_t)r->height,
        .display_min = {r->display.min.x, r->display.min.y},
        .display_max = {r->display.max.x, r->display.max.y},
        .compression = compressions[r->compression],
        .tiled = r->storage == EXR_STORAGE_TILED || r->storage == EXR_STORAGE_DEEP_TILED,
        .deep = r->storage == EXR_STORAGE_DEEP_SCANLINE || r->storage == EXR_STORAGE_DEEP_TILED,
        .part_count = (uint32_t)r->part_count,
        .channel_count = (uint64_t)r->channels->num_channels,
        .header_bytes = size,
    };
    enum weft_result res = append(r, &wire, sizeof wire);
    if (res == WEFT_OK)
        res = append_channels(r);
    return res == WEFT_OK ? append(r, header, size) : res;
}

static enum weft_result answer_info(struct reader *r)
{
    size_t first = 0, end = 0;
    const unsigned char *file = map_file(r);
    if (!file)
        return WEFT_ERR_LIMIT;
    enum weft_result res = find_header(r, file, &first, &end)
                               ? append_info(r, file + first, end - first)
                               : weft_server_fail(r->server, WEFT_ERR_FORMAT,
                                                  "an attribute of part %d ends nowhere", r->part);
    munmap((void *)(uintptr_t)file, r->file_bytes);
    return res;
}

// ---- pixels -------------------------------------------------------------------------------------

static enum weft_result check_kind(struct reader *r)
{
    struct weft_server *s = r->server;
    if (r->storage != EXR_STORAGE_SCANLINE && r->storage != EXR_STORAGE_TILED)
        return weft_server_fail(s, WEFT_ERR_UNSUPPORTED, "deep images are unsupported");
    if (r->compression == EXR_COMPRESSION_DWAA || r->compression == EXR_COMPRESSION_DWAB)
        return weft_server_fail(s, WEFT_ERR_UNSUPPORTED, "DWA is read by weft-read-dwa");
    for (int c = 0; c < r->channels->num_channels; c++) {
        const exr_attr_chlist_entry_t *e = &r->channels->entries[c];
        if (e->x_sampling != 1 || e->y_sampling != 1)
            return weft_server_fail(s, WEFT_ERR_UNSUPPORTED,
                                    "channel %s is subsampled (%d x %d), which is unsupported",
                                    e->name.str, e->x_sampling, e->y_sampling);
    }
    return WEFT_OK;
}

static enum weft_result check_amount(struct reader *r, size_t *bytes)
{
    struct weft_server *s = r->server;
    size_t pixels, planes;
    if (!weft_size_mul((size_t)r->width, (size_t)r->height, &pixels) ||
        !weft_size_mul(pixels, (size_t)r->channels->num_channels, &planes) ||
        !weft_size_mul(planes, sizeof(float), bytes))
        *bytes = SIZE_MAX;
    if (*bytes > s->limits.output_bytes)
        return weft_server_fail(s, WEFT_ERR_LIMIT,
                                "%" PRId64 " x %" PRId64 " pixels of %d channels are %zu bytes,"
                                " the output limit is %" PRIu64,
                                r->width, r->height, r->channels->num_channels, *bytes,
                                s->limits.output_bytes);
    if (*bytes > RATIO_FLOOR_BYTES && *bytes / RATIO_LIMIT > r->file_bytes)
        return weft_server_fail(s, WEFT_ERR_LIMIT,
                                "%zu bytes are declared in a file of %" PRIu64
                                " bytes, the limit is %d times as many",
                                *bytes, r->file_bytes, RATIO_LIMIT);
    return WEFT_OK;
}

// A part on its way into planes: blocks of lines, or tiles, each by one thread.
struct decoding {
    struct reader *reader;
    float *planes;
    int64_t width, height;            // of a block, but for the last ones
    size_t across, count;             // blocks in a row, in all
    exr_decode_pipeline_t *pipelines; // of each thread
    // The first block that cannot be decoded: blocks are begun in order, so that it is the same one
    // whatever the number of threads.
    pthread_mutex_t lock;
    size_t failed; // count: none
    exr_result_t code;
    struct complaint complaint;
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
    const struct reader *r = d->reader;
    const int64_t x = (int64_t)(i % d->across) * d->width, y = (int64_t)(i / d->across) * d->height;
    return (struct block){x, y, smaller(d->width, r->width - x), smaller(d->height, r->height - y)};
}

// uint stays uint here: OpenEXRCore's own conversion is by way of other roundings.
static void point_to(const struct decoding *d, exr_decode_pipeline_t *decode, int64_t x, int64_t y)
{
    const struct reader *r = d->reader;
    size_t plane_size = (size_t)r->width * (size_t)r->height;
    for (int c = 0; c < decode->channel_count; c++) {
        exr_coding_channel_info_t *channel = &decode->channels[c];
        float *first = d->planes + (size_t)c * plane_size + y * r->width + x;
        channel->decode_to_ptr = (uint8_t *)first;
        channel->user_bytes_per_element = sizeof(float);
        channel->user_data_type =
            channel->data_type == EXR_PIXEL_UINT ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = sizeof(float);
        channel->user_line_stride = (int32_t)((size_t)r->width * sizeof(float));
    }
}

static exr_result_t find_chunk(const struct decoding *d, const struct block *b,
                               exr_chunk_info_t *out)
{
    const struct reader *r = d->reader;
    if (r->storage == EXR_STORAGE_TILED)
        return exr_read_tile_chunk_info(r->exr, r->part, (int)(b->x / d->width),
                                        (int)(b->y / d->height), 0, 0, out);
    return exr_read_scanline_chunk_info(r->exr, r->part, (int)(r->data.min.y + b->y), out);
}

static exr_result_t decode_block(const struct decoding *d, exr_decode_pipeline_t *decode, size_t i)
{
    const struct reader *r = d->reader;
    const struct block block = block_of(d, i);
    exr_chunk_info_t chunk;
    exr_result_t rv = find_chunk(d, &block, &chunk);
    if (rv)
        return rv;
    if (chunk.width != block.width || chunk.height != block.height)
        return EXR_ERR_CORRUPT_CHUNK;
    bool first = decode->channels == NULL;
    rv = first ? exr_decoding_initialize(r->exr, r->part, &chunk, decode)
               : exr_decoding_update(r->exr, r->part, &chunk, decode);
    if (rv)
        return rv;
    if (decode->channel_count != r->channels->num_channels)
        return EXR_ERR_CORRUPT_CHUNK;
    point_to(d, decode, block.x, block.y);
    if (first)
        rv = exr_decoding_choose_default_routines(r->exr, r->part, decode);
    return rv ? rv : exr_decoding_run(r->exr, r->part, decode);
}

static bool decode_one(void *priv, int thread, size_t i)
{
    struct decoding *d = priv;
    struct complaint own = {0}, *outer = current;
    current = &own;
    const exr_result_t rv = decode_block(d, &d->pipelines[thread], i);
    current = outer;
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

// Sizes and number of the blocks.
static exr_result_t measure_blocks(struct decoding *d)
{
    struct reader *r = d->reader;
    int32_t width = 0, height = 0;
    exr_result_t rv = r->storage == EXR_STORAGE_TILED
                          ? exr_get_tile_sizes(r->exr, r->part, 0, 0, &width, &height)
                          : exr_get_scanlines_per_chunk(r->exr, r->part, &height);
    if (!rv && (height < 1 || (r->storage == EXR_STORAGE_TILED && width < 1)))
        rv = EXR_ERR_CORRUPT_CHUNK;
    if (rv)
        return rv;
    d->width = r->storage == EXR_STORAGE_TILED ? width : r->width;
    d->height = height;
    d->across = (size_t)((r->width - 1) / d->width + 1);
    d->count = d->across * (size_t)((r->height - 1) / d->height + 1);
    return rv;
}

// As many as are asked for, worth their start, and sure to find memory: a thread holds its stack
// and a block in several forms.
static int choose_threads(const struct decoding *d, size_t bytes)
{
    const struct reader *r = d->reader;
    const uint64_t asked = r->server->request->threads, memory = r->server->limits.memory_bytes;
    const uint64_t block = (uint64_t)smaller(d->width, r->width) *
                           (uint64_t)smaller(d->height, r->height) *
                           (uint64_t)r->channels->num_channels * sizeof(float);
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
    struct reader *r = d->reader;
    d->failed = d->count;
    d->code = EXR_ERR_OUT_OF_MEMORY;
    d->pipelines = allocate((size_t)threads * sizeof *d->pipelines);
    if (!d->pipelines)
        return EXR_ERR_OUT_OF_MEMORY;
    for (int t = 0; t < threads; t++)
        d->pipelines[t] = (exr_decode_pipeline_t)EXR_DECODE_PIPELINE_INITIALIZER;
    const bool whole = weft_threads_run(threads, d->count, decode_one, d);
    for (int t = 0; t < threads; t++)
        exr_decoding_destroy(r->exr, &d->pipelines[t]);
    free(d->pipelines);
    if (whole)
        return EXR_ERR_SUCCESS;
    r->complaint = d->complaint;
    return d->code;
}

static enum weft_result answer_pixels(struct reader *r)
{
    size_t bytes = 0;
    struct decoding d = {.reader = r, .lock = PTHREAD_MUTEX_INITIALIZER};
    enum weft_result res = check_kind(r);
    if (res == WEFT_OK)
        res = check_amount(r, &bytes);
    if (res != WEFT_OK)
        return res;
    exr_result_t rv = measure_blocks(&d);
    if (rv)
        return fail_exr(r, rv);
    d.planes = weft_server_map(r->server, bytes); // zero, should a chunk leave a gap
    if (!d.planes)
        return (enum weft_result)r->server->answer.result;
    const int threads = choose_threads(&d, bytes);
    rv = decode_all(&d, threads);
    if (rv && r->complaint.refused && threads > 1) { // one may still have room
        r->complaint = d.complaint = (struct complaint){{0}, 0};
        rv = decode_all(&d, 1);
    }
    return rv ? fail_exr(r, rv) : WEFT_OK;
}

static enum weft_result handle(struct weft_server *server)
{
    struct reader *r = server->priv;
    enum weft_result res = WEFT_OK;
    r->server = server;
    r->complaint = (struct complaint){{0}, 0};
    current = &r->complaint;
    if (!r->exr)
        res = open_file(r);
    if (res != WEFT_OK)
        return res;
    if (server->request->part >= (uint32_t)r->part_count)
        return weft_server_fail(server, WEFT_ERR_ARGUMENT,
                                "there is no part %" PRIu32 ": it has %d, from 0",
                                server->request->part, r->part_count);
    r->part = (int)server->request->part;
    exr_result_t rv = read_header(r);
    if (rv)
        return fail_exr(r, rv);
    res = check_header(r);
    if (res != WEFT_OK)
        return res;
    switch (server->request->op) {
    case WEFT_WIRE_IMAGE_INFO:
        return answer_info(r);
    case WEFT_WIRE_IMAGE_PIXELS:
        return answer_pixels(r);
    }
    return weft_server_fail(server, WEFT_ERR_READER, "weft-read-exr: unknown request %" PRIu32,
                            server->request->op);
}

int main(int argc, char **argv)
{
    struct reader reader = {0};
    pthread_attr_t attributes;
    // Address space is limited: by default a thread's stack takes 8 MiB of it and its heap 64.
    if (!pthread_attr_init(&attributes) && !pthread_attr_setstacksize(&attributes, STACK))
        pthread_setattr_default_np(&attributes);
    mallopt(M_ARENA_MAX, 1);
    int status = weft_server_run(argc, argv, handle, &reader);
    if (reader.exr)
        exr_finish(&reader.exr);
    return status;
}
