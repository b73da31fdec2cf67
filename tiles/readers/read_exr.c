// SPDX-License-Identifier: BSD-3-Clause
// weft-read-exr: flat EXR images (level 0 of the first part) for libweft, see wire.h.
#include <errno.h>
#include <inttypes.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <openexr.h>

#include "filter/check.h"
#include "tiles/readers/server.h"

enum {
    SIDE_LIMIT = 1 << 29, // line strides are int32 bytes in OpenEXRCore
    RATIO_LIMIT = 10000,  // declared bytes per stored byte, as OpenImageIO has it
};
#define RATIO_FLOOR_BYTES (UINT64_C(1) << 30)

struct reader {
    struct weft_server *server;
    exr_context_t exr;
    char message[256]; // the first that OpenEXRCore told during a request
    size_t refused;    // bytes of an allocation that failed, else 0
    uint64_t file_bytes;
    exr_attr_box2i_t data, display;
    int64_t width, height;
    exr_storage_t storage;
    exr_compression_t compression;
    const exr_attr_chlist_t *channels;
};

static const char *const compression_name[] = {
    "none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab",
};
static const char *const type_name[] = {"uint", "half", "float"};

// ---- opening ------------------------------------------------------------------------------------

// The handler cannot ask the context for its user data: OpenEXRCore 3.1 may hold the context's
// lock.
static struct reader *current;

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
    if (r->refused)
        return weft_server_fail(r->server, WEFT_ERR_LIMIT,
                                "another %zu bytes do not fit in the memory limit of %" PRIu64
                                " bytes",
                                r->refused, r->server->limits.memory_bytes);
    return weft_server_fail(
        r->server, code == EXR_ERR_FEATURE_NOT_IMPLEMENTED ? WEFT_ERR_UNSUPPORTED : WEFT_ERR_FORMAT,
        "%s", r->message[0] ? r->message : exr_get_default_error_message(code));
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
    return rv ? fail_exr(r, rv) : WEFT_OK;
}

// ---- the header ---------------------------------------------------------------------------------

static exr_result_t read_header(struct reader *r)
{
    exr_result_t rv = exr_get_storage(r->exr, 0, &r->storage);
    if (!rv)
        rv = exr_get_compression(r->exr, 0, &r->compression);
    if (!rv)
        rv = exr_get_data_window(r->exr, 0, &r->data);
    if (!rv)
        rv = exr_get_display_window(r->exr, 0, &r->display);
    if (!rv)
        rv = exr_get_channels(r->exr, 0, &r->channels);
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
        if ((unsigned)e->pixel_type >= WEFT_COUNT(type_name))
            return weft_server_fail(s, WEFT_ERR_FORMAT, "channel %s has the unknown type %d",
                                    e->name.str, (int)e->pixel_type);
        if (e->x_sampling != 1 || e->y_sampling != 1)
            return weft_server_fail(s, WEFT_ERR_UNSUPPORTED,
                                    "channel %s is subsampled (%d x %d), which is unsupported",
                                    e->name.str, e->x_sampling, e->y_sampling);
    }
    return WEFT_OK;
}

static enum weft_result check_header(struct reader *r)
{
    struct weft_server *s = r->server;
    if (r->storage != EXR_STORAGE_SCANLINE && r->storage != EXR_STORAGE_TILED)
        return weft_server_fail(s, WEFT_ERR_UNSUPPORTED, "deep images are unsupported");
    if ((unsigned)r->compression >= WEFT_COUNT(compression_name))
        return weft_server_fail(s, WEFT_ERR_UNSUPPORTED, "compression %d is unknown",
                                (int)r->compression);
    enum weft_result res = check_windows(r);
    return res == WEFT_OK ? check_channels(r) : res;
}

// ---- metadata as text
// -----------------------------------------------------------------------------

static void put(char *out, size_t size, const char *text, size_t length)
{
    size_t n = strnlen(text, length);
    size_t used = strlen(out);
    bool cut = n > size - 1 - used;
    memcpy(out + used, text, cut ? size - 1 - used : n);
    out[cut ? size - 1 : used + n] = '\0';
    if (cut)
        memcpy(out + size - 4, "...", 4);
}

// Attributes that are lists of numbers, behind a pointer or in the record itself.
static const struct number_type {
    exr_attribute_type_t type;
    char element; // i: int32, f: float, d: double
    int count;
    bool in_place;
} number_types[] = {
    {EXR_ATTR_INT, 'i', 1, true},      {EXR_ATTR_FLOAT, 'f', 1, true},
    {EXR_ATTR_DOUBLE, 'd', 1, true},   {EXR_ATTR_BOX2I, 'i', 4, false},
    {EXR_ATTR_BOX2F, 'f', 4, false},   {EXR_ATTR_CHROMATICITIES, 'f', 8, false},
    {EXR_ATTR_KEYCODE, 'i', 7, false}, {EXR_ATTR_M33F, 'f', 9, false},
    {EXR_ATTR_M33D, 'd', 9, false},    {EXR_ATTR_M44F, 'f', 16, false},
    {EXR_ATTR_M44D, 'd', 16, false},   {EXR_ATTR_V2I, 'i', 2, false},
    {EXR_ATTR_V2F, 'f', 2, false},     {EXR_ATTR_V2D, 'd', 2, false},
    {EXR_ATTR_V3I, 'i', 3, false},     {EXR_ATTR_V3F, 'f', 3, false},
    {EXR_ATTR_V3D, 'd', 3, false},
};

static void put_number(char element, const void *data, int i, struct weft_metadata *out)
{
    char text[40];
    int32_t integer;
    float single;
    double real;
    if (element == 'i') {
        memcpy(&integer, (const char *)data + 4 * i, sizeof integer);
        snprintf(text, sizeof text, "%" PRId32, integer);
    } else if (element == 'f') {
        memcpy(&single, (const char *)data + 4 * i, sizeof single);
        snprintf(text, sizeof text, "%.9g", single);
    } else {
        memcpy(&real, (const char *)data + 8 * i, sizeof real);
        snprintf(text, sizeof text, "%.17g", real);
    }
    if (i)
        put(out->value, sizeof out->value, " ", 1);
    put(out->value, sizeof out->value, text, sizeof text);
}

static bool put_numbers(const exr_attribute_t *a, struct weft_metadata *out)
{
    for (size_t t = 0; t < WEFT_COUNT(number_types); t++) {
        const struct number_type *type = &number_types[t];
        if (type->type != a->type)
            continue;
        const void *data = type->in_place ? (const void *)&a->i : a->rawptr;
        for (int i = 0; data && i < type->count; i++)
            put_number(type->element, data, i, out);
        return data != NULL;
    }
    return false;
}

static void put_strings(const exr_attr_string_vector_t *v, struct weft_metadata *out)
{
    for (int32_t i = 0; i < v->n_strings; i++) {
        if (i)
            put(out->value, sizeof out->value, ", ", 2);
        if (v->strings[i].str)
            put(out->value, sizeof out->value, v->strings[i].str, (size_t)v->strings[i].length);
    }
}

// false for attributes of other types.
static bool put_value(const exr_attribute_t *a, struct weft_metadata *out)
{
    static const char *const order[] = {"increasing y", "decreasing y", "random y"};
    static const char *const envmap[] = {"latitude-longitude", "cube"};
    if (a->type == EXR_ATTR_STRING && a->string && a->string->str)
        put(out->value, sizeof out->value, a->string->str, (size_t)a->string->length);
    else if (a->type == EXR_ATTR_STRING_VECTOR && a->stringvector)
        put_strings(a->stringvector, out);
    else if (a->type == EXR_ATTR_LINEORDER && a->uc < WEFT_COUNT(order))
        put(out->value, sizeof out->value, order[a->uc], PTRDIFF_MAX);
    else if (a->type == EXR_ATTR_ENVMAP && a->uc < WEFT_COUNT(envmap))
        put(out->value, sizeof out->value, envmap[a->uc], PTRDIFF_MAX);
    else if (a->type == EXR_ATTR_RATIONAL && a->rational)
        snprintf(out->value, sizeof out->value, "%d/%u", a->rational->num, a->rational->denom);
    else
        return put_numbers(a, out);
    return true;
}

// What struct weft_image says in its own members, or what only describes the file's layout.
static bool is_structure(const char *name)
{
    static const char *const names[] = {"channels", "compression", "dataWindow", "displayWindow",
                                        "tiles",    "chunkCount",  "type",       "version"};
    for (size_t i = 0; i < WEFT_COUNT(names); i++)
        if (!strcmp(name, names[i]))
            return true;
    return false;
}

static bool describe_attribute(struct reader *r, int32_t index, struct weft_metadata *out)
{
    const exr_attribute_t *a = NULL;
    *out = (struct weft_metadata){0};
    if (exr_get_attribute_by_index(r->exr, 0, EXR_ATTR_LIST_FILE_ORDER, index, &a) || !a->name)
        return false;
    if (is_structure(a->name) || !put_value(a, out))
        return false;
    put(out->key, sizeof out->key, a->name, PTRDIFF_MAX);
    return out->key[0] != '\0';
}

// ---- answers
// --------------------------------------------------------------------------------------

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
        struct weft_image_channel channel = {0};
        put(channel.name, sizeof channel.name, e->name.str, (size_t)e->name.length);
        put(channel.type, sizeof channel.type, type_name[e->pixel_type], PTRDIFF_MAX);
        res = append(r, &channel, sizeof channel);
    }
    return res;
}

static enum weft_result answer_info(struct reader *r)
{
    struct weft_metadata entry;
    struct weft_wire_image wire = {0};
    int32_t attributes = 0;
    exr_get_attribute_count(r->exr, 0, &attributes);
    for (int32_t i = 0; i < attributes; i++)
        wire.image.metadata_count += describe_attribute(r, i, &entry);
    wire.image.x = r->data.min.x;
    wire.image.y = r->data.min.y;
    wire.image.width = (int32_t)r->width;
    wire.image.height = (int32_t)r->height;
    wire.image.display_min[0] = r->display.min.x;
    wire.image.display_min[1] = r->display.min.y;
    wire.image.display_max[0] = r->display.max.x;
    wire.image.display_max[1] = r->display.max.y;
    wire.image.tiled = r->storage == EXR_STORAGE_TILED;
    wire.image.channel_count = (size_t)r->channels->num_channels;
    put(wire.image.compression, sizeof wire.image.compression, compression_name[r->compression],
        PTRDIFF_MAX);

    enum weft_result res = append(r, &wire, sizeof wire);
    if (res == WEFT_OK)
        res = append_channels(r);
    for (int32_t i = 0; res == WEFT_OK && i < attributes; i++)
        if (describe_attribute(r, i, &entry))
            res = append(r, &entry, sizeof entry);
    return res;
}

// ---- pixels
// ---------------------------------------------------------------------------------------

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

// uint stays uint here: OpenEXRCore's own conversion is by way of other roundings.
static void point_to(struct reader *r, exr_decode_pipeline_t *decode, float *planes, int64_t x,
                     int64_t y)
{
    size_t plane_size = (size_t)r->width * (size_t)r->height;
    for (int c = 0; c < decode->channel_count; c++) {
        exr_coding_channel_info_t *channel = &decode->channels[c];
        float *first = planes + (size_t)c * plane_size + y * r->width + x;
        channel->decode_to_ptr = (uint8_t *)first;
        channel->user_bytes_per_element = sizeof(float);
        channel->user_data_type =
            channel->data_type == EXR_PIXEL_UINT ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = sizeof(float);
        channel->user_line_stride = (int32_t)((size_t)r->width * sizeof(float));
    }
}

// What a chunk must be, whatever the file says.
struct block {
    int64_t x, y, width, height; // relative to the data window
};

static exr_result_t decode_block(struct reader *r, exr_decode_pipeline_t *decode,
                                 const exr_chunk_info_t *chunk, const struct block *block,
                                 float *planes)
{
    if (chunk->width != block->width || chunk->height != block->height)
        return EXR_ERR_CORRUPT_CHUNK;
    bool first = decode->channels == NULL;
    exr_result_t rv = first ? exr_decoding_initialize(r->exr, 0, chunk, decode)
                            : exr_decoding_update(r->exr, 0, chunk, decode);
    if (rv)
        return rv;
    if (decode->channel_count != r->channels->num_channels)
        return EXR_ERR_CORRUPT_CHUNK;
    point_to(r, decode, planes, block->x, block->y);
    if (first)
        rv = exr_decoding_choose_default_routines(r->exr, 0, decode);
    return rv ? rv : exr_decoding_run(r->exr, 0, decode);
}

static int64_t smaller(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

static exr_result_t decode_lines(struct reader *r, exr_decode_pipeline_t *decode, float *planes)
{
    int32_t lines = 0;
    exr_result_t rv = exr_get_scanlines_per_chunk(r->exr, 0, &lines);
    if (!rv && lines < 1)
        rv = EXR_ERR_CORRUPT_CHUNK;
    struct block b = {.width = r->width};
    for (; !rv && b.y < r->height; b.y += lines) {
        exr_chunk_info_t chunk;
        b.height = smaller(lines, r->height - b.y);
        rv = exr_read_scanline_chunk_info(r->exr, 0, (int)(r->data.min.y + b.y), &chunk);
        if (!rv)
            rv = decode_block(r, decode, &chunk, &b, planes);
    }
    return rv;
}

static exr_result_t decode_tiles(struct reader *r, exr_decode_pipeline_t *decode, float *planes)
{
    int32_t width = 0, height = 0;
    exr_result_t rv = exr_get_tile_sizes(r->exr, 0, 0, 0, &width, &height);
    if (!rv && (width < 1 || height < 1))
        rv = EXR_ERR_CORRUPT_CHUNK;
    for (int64_t y = 0; !rv && y < r->height; y += height) {
        for (int64_t x = 0; !rv && x < r->width; x += width) {
            struct block b = {x, y, smaller(width, r->width - x), smaller(height, r->height - y)};
            exr_chunk_info_t chunk;
            rv = exr_read_tile_chunk_info(r->exr, 0, (int)(x / width), (int)(y / height), 0, 0,
                                          &chunk);
            if (!rv)
                rv = decode_block(r, decode, &chunk, &b, planes);
        }
    }
    return rv;
}

static void convert_uints(const struct reader *r, float *planes)
{
    size_t plane_size = (size_t)r->width * (size_t)r->height;
    for (int c = 0; c < r->channels->num_channels; c++) {
        if (r->channels->entries[c].pixel_type != EXR_PIXEL_UINT)
            continue;
        float *plane = planes + (size_t)c * plane_size;
        for (size_t i = 0; i < plane_size; i++) {
            uint32_t value;
            memcpy(&value, plane + i, sizeof value);
            plane[i] = (float)value;
        }
    }
}

static enum weft_result answer_pixels(struct reader *r)
{
    struct weft_server *s = r->server;
    if (r->compression == EXR_COMPRESSION_DWAA || r->compression == EXR_COMPRESSION_DWAB)
        return weft_server_fail(s, WEFT_ERR_UNSUPPORTED, "compression %s is unsupported",
                                compression_name[r->compression]);
    size_t bytes = 0;
    enum weft_result res = check_amount(r, &bytes);
    if (res != WEFT_OK)
        return res;
    float *planes = calloc(bytes, 1); // zero, should a chunk leave a gap
    if (!planes)
        return weft_server_fail(s, WEFT_ERR_LIMIT,
                                "%zu bytes of pixels do not fit in the memory limit of %" PRIu64
                                " bytes",
                                bytes, s->limits.memory_bytes);

    exr_decode_pipeline_t decode = EXR_DECODE_PIPELINE_INITIALIZER;
    exr_result_t rv = r->storage == EXR_STORAGE_TILED ? decode_tiles(r, &decode, planes)
                                                      : decode_lines(r, &decode, planes);
    exr_decoding_destroy(r->exr, &decode);
    if (rv) {
        res = fail_exr(r, rv);
    } else {
        convert_uints(r, planes);
        res = append(r, planes, bytes);
    }
    free(planes);
    return res;
}

static enum weft_result handle(struct weft_server *server)
{
    struct reader *r = server->priv;
    enum weft_result res = WEFT_OK;
    r->server = server;
    r->message[0] = '\0';
    r->refused = 0;
    current = r;
    if (!r->exr)
        res = open_file(r);
    if (res != WEFT_OK)
        return res;
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
    int status = weft_server_run(argc, argv, handle, &reader);
    if (reader.exr)
        exr_finish(&reader.exr);
    return status;
}
