// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/readers/exr_file.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "filter/check.h"
#include "tiles/image/image_attribute.h"

enum {
    SIDE_LIMIT = 1 << 29,  // line strides are int32 bytes in OpenEXRCore
    RATIO_LIMIT = 10000,   // declared bytes per stored byte, as OpenImageIO has it
    FIRST_LOOK = 64 << 10, // bytes in which most headers end
    LAST_LOOK = 64 << 20,  // in which parts are counted
    PARTS_LIMIT = 1024,    // of parts: what is listed of each takes time
    MULTI_PART = 0x10      // of the version's second byte
};
#define RATIO_FLOOR_BYTES (UINT64_C(1) << 30)

static const enum weft_image_compression compressions[] = {
    WEFT_IMAGE_NONE,  WEFT_IMAGE_RLE, WEFT_IMAGE_ZIPS, WEFT_IMAGE_ZIP,  WEFT_IMAGE_PIZ,
    WEFT_IMAGE_PXR24, WEFT_IMAGE_B44, WEFT_IMAGE_B44A, WEFT_IMAGE_DWAA, WEFT_IMAGE_DWAB,
};
static const enum weft_pixel_type types[] = {WEFT_PIXEL_UINT, WEFT_PIXEL_HALF, WEFT_PIXEL_FLOAT};

// ---- opening ------------------------------------------------------------------------------------

// Of each thread. The handler cannot ask the context for its user data: OpenEXRCore 3.1 may hold
// the context's lock.
static _Thread_local struct weft_exr_complaint *current;

struct weft_exr_complaint *weft_exr_complain(struct weft_exr_complaint *to)
{
    struct weft_exr_complaint *before = current;
    current = to;
    return before;
}

static void keep_message(exr_const_context_t exr, exr_result_t code, const char *message)
{
    (void)exr;
    (void)code;
    if (current && !current->message[0])
        snprintf(current->message, sizeof current->message, "%s", message);
}

// OpenEXRCore 3.1 says "out of memory" of damaged data as well.
void *weft_exr_allocate(size_t size)
{
    void *memory = malloc(size);
    if (!memory && current)
        current->refused = size;
    return memory;
}

// Up to `size` bytes, fewer where the file ends; -1 with errno.
static int64_t read_whole(int fd, void *buffer, uint64_t size, uint64_t offset)
{
    uint64_t done = 0;
    while (done < size) {
        const ssize_t n = pread(fd, (char *)buffer + done, size - done, (off_t)(offset + done));
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return -1;
        if (n == 0)
            break;
        done += (uint64_t)n;
    }
    return (int64_t)done;
}

static int64_t read_bytes(exr_const_context_t exr, void *priv, void *buffer, uint64_t size,
                          uint64_t offset, exr_stream_error_func_ptr_t error)
{
    const struct weft_exr_file *file = priv;
    if (offset > INT64_MAX || size > INT64_MAX - offset) {
        error(exr, EXR_ERR_READ_IO, "offset %" PRIu64 " is beyond any file", offset);
        return -1;
    }
    const int64_t got = read_whole(file->server->input_fd, buffer, size, offset);
    if (got < 0)
        error(exr, EXR_ERR_READ_IO, "%s", strerror(errno));
    return got;
}

static int64_t query_size(exr_const_context_t exr, void *priv)
{
    (void)exr;
    return (int64_t)((struct weft_exr_file *)priv)->file_bytes;
}

enum weft_result weft_exr_fail(struct weft_exr_file *file, exr_result_t code)
{
    const struct weft_exr_complaint *complaint = &file->complaint;
    if (complaint->refused)
        return weft_server_fail(file->server, WEFT_ERR_LIMIT,
                                "another %zu bytes do not fit in the memory limit of %" PRIu64
                                " bytes",
                                complaint->refused, file->server->limits.memory_bytes);
    return weft_server_fail(
        file->server,
        code == EXR_ERR_FEATURE_NOT_IMPLEMENTED ? WEFT_ERR_UNSUPPORTED : WEFT_ERR_FORMAT, "%s",
        complaint->message[0] ? complaint->message : exr_get_default_error_message(code));
}

// Headers of parts in a file's start: PARTS_LIMIT and one more at most; -1: they go on behind it.
static int64_t count_headers(const unsigned char *start, size_t size)
{
    struct weft_image_attribute attribute;
    enum weft_attribute_step step = WEFT_ATTRIBUTE_END;
    int64_t parts = 0;
    for (size_t at = 8; step == WEFT_ATTRIBUTE_END && parts <= PARTS_LIMIT; parts++) {
        const size_t first = at;
        do
            step = weft_attribute_next(start, size, &at, &attribute);
        while (step == WEFT_ATTRIBUTE_TAKEN);
        if (step == WEFT_ATTRIBUTE_END && at == first + 1)
            return parts; // an empty one ends them
    }
    return step == WEFT_ATTRIBUTE_END ? parts : -1;
}

// Before OpenEXRCore takes them all. Headers that are damaged or very long are left to it.
static enum weft_result check_part_count(struct weft_exr_file *file)
{
    unsigned char version[8], *start = NULL;
    int64_t parts = -1;
    const int fd = file->server->input_fd;
    if (read_whole(fd, version, sizeof version, 0) != sizeof version || !(version[5] & MULTI_PART))
        return WEFT_OK;
    for (uint64_t size = FIRST_LOOK; parts < 0 && size <= LAST_LOOK; size *= 2) {
        unsigned char *more = realloc(start, size);
        const int64_t got = more ? read_whole(fd, more, size, 0) : -1;
        start = more ? more : start;
        parts = got > 8 ? count_headers(start, (size_t)got) : -1;
        if (got < (int64_t)size)
            break;
    }
    free(start);
    if (parts <= PARTS_LIMIT)
        return WEFT_OK;
    return weft_server_fail(file->server, WEFT_ERR_LIMIT,
                            "it has more than %d parts, which is the limit", PARTS_LIMIT);
}

enum weft_result weft_exr_open(struct weft_exr_file *file)
{
    struct stat st;
    if (file->exr)
        return WEFT_OK;
    if (fstat(file->server->input_fd, &st))
        return weft_server_fail(file->server, WEFT_ERR_OPEN, "%s", strerror(errno));
    file->file_bytes = (uint64_t)st.st_size;
    const enum weft_result res = check_part_count(file);
    if (res != WEFT_OK)
        return res;

    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = keep_message;
    init.alloc_fn = weft_exr_allocate;
    init.free_fn = free;
    init.user_data = file;
    init.read_fn = read_bytes;
    init.size_fn = query_size;
    init.max_image_width = init.max_image_height = SIDE_LIMIT;
    init.max_tile_width = init.max_tile_height = SIDE_LIMIT;
    init.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    exr_result_t rv = exr_start_read(&file->exr, file->server->path, &init);
    if (!rv)
        rv = exr_get_count(file->exr, &file->part_count);
    return rv ? weft_exr_fail(file, rv) : WEFT_OK;
}

void weft_exr_close(struct weft_exr_file *file)
{
    if (file->exr)
        exr_finish(&file->exr);
    file->exr = NULL;
}

// ---- the header ---------------------------------------------------------------------------------

static exr_result_t read_header(struct weft_exr_file *file)
{
    exr_tile_round_mode_t rounding;
    exr_result_t rv = exr_get_storage(file->exr, file->part, &file->storage);
    if (!rv)
        rv = exr_get_compression(file->exr, file->part, &file->compression);
    if (!rv)
        rv = exr_get_data_window(file->exr, file->part, &file->data);
    if (!rv)
        rv = exr_get_display_window(file->exr, file->part, &file->display);
    if (!rv)
        rv = exr_get_channels(file->exr, file->part, &file->channels);
    file->tile[0] = file->tile[1] = 0;
    if (!rv && (file->storage == EXR_STORAGE_TILED || file->storage == EXR_STORAGE_DEEP_TILED))
        rv = exr_get_tile_descriptor(file->exr, file->part, &file->tile[0], &file->tile[1],
                                     &file->levels, &rounding);
    return rv;
}

static enum weft_result check_windows(struct weft_exr_file *file)
{
    struct weft_server *s = file->server;
    file->width = (int64_t)file->data.max.x - file->data.min.x + 1;
    file->height = (int64_t)file->data.max.y - file->data.min.y + 1;
    file->first_row = 0;
    file->rows = file->height;
    if (file->width < 1 || file->height < 1)
        return weft_server_fail(s, WEFT_ERR_FORMAT, "the data window is empty");
    if (file->width >= SIDE_LIMIT || file->height >= SIDE_LIMIT)
        return weft_server_fail(s, WEFT_ERR_LIMIT,
                                "%" PRId64 " x %" PRId64 " pixels, the limit of a side is %d",
                                file->width, file->height, SIDE_LIMIT - 1);
    if (file->tile[0] >= SIDE_LIMIT || file->tile[1] >= SIDE_LIMIT ||
        (unsigned)file->levels >= WEFT_IMAGE_LEVELS_COUNT)
        return weft_server_fail(s, WEFT_ERR_LIMIT,
                                "tiles of %" PRIu32 " x %" PRIu32 " pixels in levels of kind %d, "
                                "the limit of a side is %d",
                                file->tile[0], file->tile[1], (int)file->levels, SIDE_LIMIT - 1);
    if (file->display.min.x > file->display.max.x || file->display.min.y > file->display.max.y)
        return weft_server_fail(s, WEFT_ERR_FORMAT, "the display window is empty");
    return WEFT_OK;
}

static enum weft_result check_channels(struct weft_exr_file *file)
{
    struct weft_server *s = file->server;
    int count = file->channels->num_channels;
    if (count < 1)
        return weft_server_fail(s, WEFT_ERR_FORMAT, "it has no channels");
    if (count > INT16_MAX)
        return weft_server_fail(s, WEFT_ERR_LIMIT, "%d channels, the limit is %d", count,
                                INT16_MAX);
    for (int c = 0; c < count; c++) {
        const exr_attr_chlist_entry_t *e = &file->channels->entries[c];
        if ((unsigned)e->pixel_type >= WEFT_COUNT(types))
            return weft_server_fail(s, WEFT_ERR_FORMAT, "channel %s has the unknown type %d",
                                    e->name.str, (int)e->pixel_type);
        if (e->x_sampling < 1 || e->y_sampling < 1)
            return weft_server_fail(s, WEFT_ERR_FORMAT, "channel %s has a sampling of %d x %d",
                                    e->name.str, e->x_sampling, e->y_sampling);
    }
    return WEFT_OK;
}

static enum weft_result check_header(struct weft_exr_file *file)
{
    struct weft_server *s = file->server;
    if ((unsigned)file->compression >= WEFT_COUNT(compressions))
        return weft_server_fail(s, WEFT_ERR_UNSUPPORTED, "compression %d is unknown",
                                (int)file->compression);
    enum weft_result res = check_windows(file);
    return res == WEFT_OK ? check_channels(file) : res;
}

enum weft_result weft_exr_take_part(struct weft_exr_file *file, uint32_t part)
{
    if (part >= (uint32_t)file->part_count)
        return weft_server_fail(file->server, WEFT_ERR_ARGUMENT,
                                "there is no part %" PRIu32 ": it has %d, from 0", part,
                                file->part_count);
    file->part = (int)part;
    const exr_result_t rv = read_header(file);
    return rv ? weft_exr_fail(file, rv) : check_header(file);
}

enum weft_result weft_exr_choose_rows(struct weft_exr_file *file, int64_t lines)
{
    struct weft_server *s = file->server;
    const int64_t first = s->request->first_row, rows = s->request->rows;
    if (rows && (first >= file->height || rows > file->height - first))
        return weft_server_fail(s, WEFT_ERR_ARGUMENT,
                                "there are no %" PRId64 " rows from row %" PRId64
                                " on: it has %" PRId64,
                                rows, first, file->height);
    if (rows) {
        const int64_t end = (first + rows + lines - 1) / lines * lines;
        file->first_row = first / lines * lines;
        file->rows = (end < file->height ? end : file->height) - file->first_row;
    }
    s->answer.count[0] = (uint64_t)file->first_row;
    s->answer.count[1] = (uint64_t)file->rows;
    return WEFT_OK;
}

bool weft_exr_is_dwa(const struct weft_exr_file *file)
{
    return file->compression == EXR_COMPRESSION_DWAA || file->compression == EXR_COMPRESSION_DWAB;
}

enum weft_result weft_exr_check_kind(const struct weft_exr_file *file)
{
    struct weft_server *s = file->server;
    if (file->storage != EXR_STORAGE_SCANLINE && file->storage != EXR_STORAGE_TILED)
        return weft_server_fail(s, WEFT_ERR_UNSUPPORTED, "deep images are unsupported");
    for (int c = 0; c < file->channels->num_channels; c++) {
        const exr_attr_chlist_entry_t *e = &file->channels->entries[c];
        if (e->x_sampling != 1 || e->y_sampling != 1)
            return weft_server_fail(s, WEFT_ERR_UNSUPPORTED,
                                    "channel %s is subsampled (%d x %d), which is unsupported",
                                    e->name.str, e->x_sampling, e->y_sampling);
    }
    return WEFT_OK;
}

static size_t sum_of_planes(const struct weft_exr_file *file, bool own_types)
{
    size_t pixels, plane, sum = 0;
    if (!weft_size_mul((size_t)file->width, (size_t)file->rows, &pixels))
        return SIZE_MAX;
    for (int c = 0; c < file->channels->num_channels; c++) {
        const uint32_t type = types[file->channels->entries[c].pixel_type];
        if (!weft_size_mul(pixels, own_types ? weft_wire_pixel_size(type) : 4, &plane) ||
            (own_types && !weft_wire_align(plane, &plane)) || !weft_size_add(sum, plane, &sum))
            return SIZE_MAX;
    }
    return sum;
}

enum weft_result weft_exr_measure(const struct weft_exr_file *file, bool own_types, size_t *bytes)
{
    struct weft_server *s = file->server;
    *bytes = sum_of_planes(file, own_types);
    if (*bytes > s->limits.output_bytes)
        return weft_server_fail(s, WEFT_ERR_LIMIT,
                                "%" PRId64 " x %" PRId64 " pixels of %d channels are %zu bytes,"
                                " the output limit is %" PRIu64,
                                file->width, file->height, file->channels->num_channels, *bytes,
                                s->limits.output_bytes);
    if (*bytes > RATIO_FLOOR_BYTES && *bytes / RATIO_LIMIT > file->file_bytes)
        return weft_server_fail(s, WEFT_ERR_LIMIT,
                                "%zu bytes are declared in a file of %" PRIu64
                                " bytes, the limit is %d times as many",
                                *bytes, file->file_bytes, RATIO_LIMIT);
    return WEFT_OK;
}

// ---- the header as it is ------------------------------------------------------------------------

// From the part's first attribute to the zero that ends its header, behind those of other parts.
static bool find_header(const unsigned char *start, size_t size, int wanted, size_t *first,
                        size_t *end)
{
    struct weft_image_attribute attribute;
    enum weft_attribute_step step = WEFT_ATTRIBUTE_END;
    size_t at = 8; // magic and version
    for (int part = 0; step == WEFT_ATTRIBUTE_END && part <= wanted; part++) {
        *first = at;
        do
            step = weft_attribute_next(start, size, &at, &attribute);
        while (step == WEFT_ATTRIBUTE_TAKEN);
    }
    *end = at;
    return step == WEFT_ATTRIBUTE_END;
}

// As much of the file's start as has the header. NULL after a message.
static unsigned char *load_header(struct weft_exr_file *file, size_t *first, size_t *end)
{
    unsigned char *start = NULL;
    for (uint64_t size = FIRST_LOOK;; size *= 2) {
        size = size < file->file_bytes ? size : file->file_bytes;
        unsigned char *more = realloc(start, size);
        if (!more) {
            weft_server_fail(file->server, WEFT_ERR_LIMIT,
                             "its header of over %" PRIu64 " bytes does not fit in the memory "
                             "limit of %" PRIu64 " bytes",
                             size / 2, file->server->limits.memory_bytes);
            break;
        }
        start = more;
        const int64_t got = read_whole(file->server->input_fd, start, size, 0);
        if (got > 8 && find_header(start, (size_t)got, file->part, first, end))
            return start;
        if (size == file->file_bytes || got < (int64_t)size) {
            weft_server_fail(file->server, WEFT_ERR_FORMAT, "an attribute of part %d ends nowhere",
                             file->part);
            break;
        }
    }
    free(start);
    return NULL;
}

// ---- answers ------------------------------------------------------------------------------------

static void put_channels(const struct weft_exr_file *file, char *to)
{
    for (int c = 0; c < file->channels->num_channels; c++) {
        const exr_attr_chlist_entry_t *e = &file->channels->entries[c];
        struct weft_wire_channel channel = {.type = types[e->pixel_type],
                                            .linear = e->p_linear != 0,
                                            .sampling = {e->x_sampling, e->y_sampling}};
        snprintf(channel.name, sizeof channel.name, "%.*s", (int)e->name.length, e->name.str);
        memcpy(to, &channel, sizeof channel);
        to += sizeof channel;
    }
}

static struct weft_wire_image describe(const struct weft_exr_file *file, size_t header_bytes)
{
    const bool tiled =
        file->storage == EXR_STORAGE_TILED || file->storage == EXR_STORAGE_DEEP_TILED;
    return (struct weft_wire_image){
        .x = file->data.min.x,
        .y = file->data.min.y,
        .width = (int32_t)file->width,
        .height = (int32_t)file->height,
        .display_min = {file->display.min.x, file->display.min.y},
        .display_max = {file->display.max.x, file->display.max.y},
        .compression = compressions[file->compression],
        .tiled = tiled,
        .tile = {(int32_t)file->tile[0], (int32_t)file->tile[1]},
        .levels = tiled ? (uint32_t)file->levels : 0,
        .deep =
            file->storage == EXR_STORAGE_DEEP_SCANLINE || file->storage == EXR_STORAGE_DEEP_TILED,
        .part_count = (uint32_t)file->part_count,
        .channel_count = (uint64_t)file->channels->num_channels,
        .header_bytes = header_bytes,
    };
}

enum weft_result weft_exr_inform(struct weft_exr_file *file, void **out, size_t *size)
{
    size_t first = 0, end = 0;
    *out = NULL;
    unsigned char *header = load_header(file, &first, &end);
    if (!header)
        return (enum weft_result)file->server->answer.result;
    const struct weft_wire_image wire = describe(file, end - first);
    const size_t channels = wire.channel_count * sizeof(struct weft_wire_channel);
    *size = sizeof wire + channels + wire.header_bytes;
    char *info = *out = malloc(*size);
    if (info) {
        memcpy(info, &wire, sizeof wire);
        put_channels(file, info + sizeof wire);
        memcpy(info + sizeof wire + channels, header + first, end - first);
    } else {
        weft_server_fail(file->server, WEFT_ERR_LIMIT,
                         "what its header says does not fit in the memory limit of %" PRIu64
                         " bytes",
                         file->server->limits.memory_bytes);
    }
    free(header);
    return info ? WEFT_OK : WEFT_ERR_LIMIT;
}

enum weft_result weft_exr_begin_frame(struct weft_exr_file *file, size_t bytes, char **planes)
{
    void *info = NULL;
    size_t info_bytes = 0, offset = 0;
    *planes = NULL;
    const enum weft_result res = weft_exr_inform(file, &info, &info_bytes);
    if (res != WEFT_OK)
        return res;
    weft_wire_align(sizeof(struct weft_wire_frame) + info_bytes, &offset);
    const struct weft_wire_frame frame = {.info_bytes = info_bytes, .planes_offset = offset};
    char *payload = weft_server_map(file->server, offset + bytes);
    if (payload) {
        memcpy(payload, &frame, sizeof frame);
        memcpy(payload + sizeof frame, info, info_bytes);
        *planes = bytes ? payload + offset : NULL;
    }
    free(info);
    return (enum weft_result)file->server->answer.result;
}
