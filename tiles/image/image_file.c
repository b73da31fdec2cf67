// SPDX-License-Identifier: BSD-3-Clause
// Whatever weft-read-exr says is checked again here: a damaged file may have taken it over.
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "filter/check.h"
#include "filter/threads.h"
#include "tiles/image/image_attribute.h"
#include "tiles/image/image_impl.h"
#include "tiles/image/image_wire.h"
#include "tiles/process/client.h"

enum { PIECE = 1 << 20 }; // bytes of a plane, copied by one thread

static enum weft_result open_input(const struct weft_log *log, const char *path, int *out)
{
    struct stat st;
    // Without O_NONBLOCK a pipe would wait for a writer.
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (fd < 0 || fstat(fd, &st)) {
        weft_error(log, "cannot open %s: %s", path, strerror(errno));
    } else if (S_ISDIR(st.st_mode)) {
        weft_error(log, "cannot open %s: %s", path, strerror(EISDIR));
    } else if (!S_ISREG(st.st_mode)) {
        weft_error(log, "cannot open %s: not a regular file", path);
    } else if (st.st_size == 0) {
        weft_error(log, "%s: the file is empty", path);
        close(fd);
        return WEFT_ERR_FORMAT;
    } else {
        *out = fd;
        return WEFT_OK;
    }
    if (fd >= 0)
        close(fd);
    return WEFT_ERR_OPEN;
}

// ---- the answer to IMAGE_INFO -------------------------------------------------------------------

// Ended, and free of what could command a terminal.
static bool clean_text(char *text, size_t size)
{
    char *end = memchr(text, '\0', size);
    if (!end)
        return false;
    for (char *c = text; c < end; c++)
        if ((unsigned char)*c < 0x20 || *c == 0x7f)
            *c = *c == '\n' || *c == '\t' ? ' ' : '?';
    memset(end, 0, size - (size_t)(end - text));
    return true;
}

static bool plausible_frame(const struct weft_wire_image *wire)
{
    return wire->tiled <= 1 && wire->deep <= 1 && wire->width > 0 && wire->height > 0 &&
           (int64_t)wire->x + wire->width - 1 <= INT32_MAX &&
           (int64_t)wire->y + wire->height - 1 <= INT32_MAX &&
           wire->display_min[0] <= wire->display_max[0] &&
           wire->display_min[1] <= wire->display_max[1] &&
           wire->compression < WEFT_IMAGE_COMPRESSION_COUNT && wire->part_count > 0 &&
           wire->part_count <= INT32_MAX;
}

static bool plausible_counts(const struct weft_wire_image *wire, size_t payload_size)
{
    size_t size;
    return wire->channel_count > 0 && wire->channel_count <= INT16_MAX &&
           wire->header_bytes <= payload_size &&
           weft_size_mul(wire->channel_count, sizeof(struct weft_wire_channel), &size) &&
           weft_size_add(size, sizeof *wire, &size) &&
           weft_size_add(size, wire->header_bytes, &size) && size == payload_size;
}

static bool take_channels(struct weft_image *image, const char *data)
{
    for (size_t c = 0; c < image->channel_count; c++, data += sizeof(struct weft_wire_channel)) {
        struct weft_image_channel *channel = &image->channels[c];
        struct weft_wire_channel wire;
        memcpy(&wire, data, sizeof wire);
        if (!clean_text(wire.name, sizeof wire.name) || !wire.name[0] ||
            wire.type >= WEFT_PIXEL_TYPE_COUNT || wire.linear > 1 || wire.sampling[0] < 1 ||
            wire.sampling[1] < 1)
            return false;
        memcpy(channel->name, wire.name, sizeof channel->name);
        memcpy(channel->sampling, wire.sampling, sizeof channel->sampling);
        channel->type = (enum weft_pixel_type)wire.type;
        channel->linear = wire.linear;
    }
    return true;
}

// How many attributes a header has; -1 where it is no header, or does not end with its last byte.
static int64_t count_attributes(const unsigned char *header, size_t size)
{
    struct weft_image_attribute attribute;
    enum weft_attribute_step step;
    int64_t count = 0;
    size_t at = 0;
    while ((step = weft_attribute_next(header, size, &at, &attribute)) == WEFT_ATTRIBUTE_TAKEN)
        count++;
    return step == WEFT_ATTRIBUTE_END && at == size ? count : -1;
}

static void take_name(struct weft_image *image, const struct weft_image_attribute *a)
{
    if (strcmp(a->name, "name") || strcmp(a->type, "string"))
        return;
    const size_t size =
        strnlen(a->data, a->size < sizeof image->name ? a->size : sizeof image->name - 1);
    memcpy(image->name, a->data, size);
    image->name[size] = '\0';
    clean_text(image->name, sizeof image->name);
}

// The records and the header that they point to, in one piece.
static enum weft_result take_attributes(struct weft_image *image, const void *header, size_t size)
{
    const int64_t count = count_attributes(header, size);
    size_t bytes;
    if (count < 0)
        return WEFT_ERR_READER;
    if (!weft_size_mul((size_t)count, sizeof *image->attributes, &bytes) ||
        !weft_size_add(bytes, size, &bytes) || !(image->attributes = malloc(bytes)))
        return WEFT_ERR_MEMORY;
    unsigned char *copy = (unsigned char *)(image->attributes + count);
    struct weft_image_attribute attribute;
    size_t at = 0;
    memcpy(copy, header, size);
    while (weft_attribute_next(copy, size, &at, &attribute) == WEFT_ATTRIBUTE_TAKEN) {
        take_name(image, &attribute);
        if (!weft_attribute_is_structure(attribute.name))
            image->attributes[image->attribute_count++] = attribute;
    }
    return WEFT_OK;
}

static enum weft_result take_info(const struct weft_payload *payload, int part,
                                  struct weft_image *out)
{
    struct weft_wire_image wire;
    const char *data = payload->data;
    if (payload->size < sizeof wire)
        return WEFT_ERR_READER;
    memcpy(&wire, data, sizeof wire);
    data += sizeof wire;
    if (!plausible_frame(&wire) || !plausible_counts(&wire, payload->size) ||
        (uint32_t)part >= wire.part_count)
        return WEFT_ERR_READER;
    *out = (struct weft_image){
        .x = wire.x,
        .y = wire.y,
        .width = wire.width,
        .height = wire.height,
        .display_min = {wire.display_min[0], wire.display_min[1]},
        .display_max = {wire.display_max[0], wire.display_max[1]},
        .compression = (enum weft_image_compression)wire.compression,
        .tiled = wire.tiled,
        .deep = wire.deep,
        .part = part,
        .part_count = (int)wire.part_count,
    };
    out->channels = calloc(wire.channel_count, sizeof *out->channels);
    if (!out->channels)
        return WEFT_ERR_MEMORY;
    out->channel_count = wire.channel_count;
    if (!take_channels(out, data))
        return WEFT_ERR_READER;
    data += wire.channel_count * sizeof(struct weft_wire_channel);
    return take_attributes(out, data, wire.header_bytes);
}

// ---- the answer to IMAGE_PIXELS -----------------------------------------------------------------

// Planes as they came, to be copied in pieces.
struct copy {
    struct weft_image *image;
    const char *data;
    size_t plane_bytes, pieces; // of each plane
};

static bool copy_piece(void *priv, int thread, size_t i)
{
    const struct copy *copy = priv;
    struct weft_image_channel *channel = &copy->image->channels[i / copy->pieces];
    const size_t from = i % copy->pieces * PIECE, left = copy->plane_bytes - from;
    const size_t bytes = left < PIECE ? left : PIECE, first = from / sizeof *channel->plane;
    const char *data = copy->data + i / copy->pieces * copy->plane_bytes + from;
    (void)thread;
    if (channel->type != WEFT_PIXEL_UINT) {
        memcpy(channel->plane + first, data, bytes);
        return true;
    }
    memcpy(channel->integers + first, data, bytes);
    for (size_t k = first; k < first + bytes / sizeof *channel->plane; k++)
        channel->plane[k] = (float)channel->integers[k];
    return true;
}

static bool make_planes(struct weft_image *image, size_t plane_bytes)
{
    for (size_t c = 0; c < image->channel_count; c++) {
        struct weft_image_channel *channel = &image->channels[c];
        const bool integers = channel->type == WEFT_PIXEL_UINT;
        channel->plane = malloc(plane_bytes);
        channel->integers = integers ? malloc(plane_bytes) : NULL;
        if (!channel->plane || (integers && !channel->integers))
            return false;
    }
    return true;
}

static enum weft_result take_pixels(const struct weft_payload *payload, int threads,
                                    struct weft_image *image)
{
    size_t plane_bytes, size;
    if (!weft_size_mul((size_t)image->width, (size_t)image->height, &plane_bytes) ||
        !weft_size_mul(plane_bytes, sizeof(float), &plane_bytes) ||
        !weft_size_mul(plane_bytes, image->channel_count, &size) || size != payload->size)
        return WEFT_ERR_READER;
    if (!make_planes(image, plane_bytes))
        return WEFT_ERR_MEMORY;
    struct copy copy = {image, payload->data, plane_bytes, (plane_bytes - 1) / PIECE + 1};
    const size_t pieces = copy.pieces * image->channel_count;
    weft_threads_run(pieces > 1 ? threads : 1, pieces, copy_piece, &copy);
    return WEFT_OK;
}

// ---- asking -------------------------------------------------------------------------------------

// Of part `part` of the file.
static enum weft_result ask(const struct weft_image_load_params *params, const char *program,
                            weft_reader *reader, enum weft_wire_op op, int part,
                            struct weft_image *image)
{
    const int threads = params->threads ? params->threads : weft_threads_available();
    struct weft_wire_request request = {
        .op = op, .part = (uint32_t)part, .threads = (uint32_t)threads};
    struct weft_wire_answer answer;
    struct weft_payload payload = {0};
    enum weft_result res = weft_reader_call(reader, &request, NULL, &answer, &payload);
    if (res != WEFT_OK)
        return res;
    res = op == WEFT_WIRE_IMAGE_INFO ? take_info(&payload, part, image)
                                     : take_pixels(&payload, threads, image);
    if (res == WEFT_ERR_READER)
        weft_error(params->log, "%s: the answer of %s contradicts itself", params->path, program);
    else if (res == WEFT_ERR_MEMORY)
        weft_error(params->log, "%s: out of memory for %zu bytes", params->path, payload.size);
    weft_payload_release(&payload);
    return res;
}

static bool is_dwa(const struct weft_image *image)
{
    return !image->deep &&
           (image->compression == WEFT_IMAGE_DWAA || image->compression == WEFT_IMAGE_DWAB);
}

// DWA has a program of its own, which knows channels in the order of their names only.
static enum weft_result read_dwa(const struct weft_image_load_params *params, int fd,
                                 struct weft_image *image)
{
    static const char program[] = "weft-read-dwa";
    weft_reader *reader = NULL;
    for (size_t c = 1; c < image->channel_count; c++) {
        if (strcmp(image->channels[c - 1].name, image->channels[c].name) < 0)
            continue;
        weft_error(params->log, "%s: its channels are not in the order of their names",
                   params->path);
        return WEFT_ERR_FORMAT;
    }
    enum weft_result res =
        weft_reader_start(params->log, program, params->path, fd, &params->limits, &reader);
    if (res == WEFT_OK)
        res = ask(params, program, reader, WEFT_WIRE_IMAGE_PIXELS, params->part, image);
    weft_reader_stop(&reader);
    return res;
}

enum weft_result weft_image_read(const struct weft_image_load_params *params, int fd,
                                 struct weft_image *out)
{
    static const char program[] = "weft-read-exr";
    weft_reader *reader = NULL;
    *out = (struct weft_image){0};
    enum weft_result res =
        weft_reader_start(params->log, program, params->path, fd, &params->limits, &reader);
    if (res == WEFT_OK)
        res = ask(params, program, reader, WEFT_WIRE_IMAGE_INFO, params->part, out);
    if (res == WEFT_OK && !params->info_only && is_dwa(out))
        res = read_dwa(params, fd, out);
    else if (res == WEFT_OK && !params->info_only)
        res = ask(params, program, reader, WEFT_WIRE_IMAGE_PIXELS, params->part, out);
    weft_reader_stop(&reader);
    if (res != WEFT_OK)
        weft_image_clear(out);
    return res;
}

enum weft_result weft_image_load(const struct weft_image_load_params *params,
                                 struct weft_image *out)
{
    *out = (struct weft_image){0};
    int fd = -1;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(params->log, params->path != NULL);
    weft_require(params->log, params->part >= 0);
    weft_require(params->log, params->threads >= 0 && params->threads <= WEFT_IMAGE_MAX_THREADS);

    res = open_input(params->log, params->path, &fd);
    if (res == WEFT_OK)
        res = weft_image_read(params, fd, out);
fail:
    if (fd >= 0)
        close(fd);
    return res;
}

static enum weft_result ask_parts(const struct weft_image_load_params *params, weft_reader *reader,
                                  struct weft_image_list *out)
{
    struct weft_image first = {0};
    enum weft_result res = ask(params, "weft-read-exr", reader, WEFT_WIRE_IMAGE_INFO, 0, &first);
    if (res == WEFT_OK)
        out->images = calloc((size_t)first.part_count, sizeof *out->images);
    if (res == WEFT_OK && !out->images) {
        weft_error(params->log, "%s: out of memory for %d parts", params->path, first.part_count);
        res = WEFT_ERR_MEMORY;
    }
    if (res != WEFT_OK) {
        weft_image_clear(&first);
        return res;
    }
    out->images[out->count++] = first;
    for (int part = 1; res == WEFT_OK && part < first.part_count; part++)
        res = ask(params, "weft-read-exr", reader, WEFT_WIRE_IMAGE_INFO, part,
                  &out->images[out->count++]);
    return res;
}

enum weft_result weft_image_list_load(const struct weft_image_load_params *params,
                                      struct weft_image_list *out)
{
    *out = (struct weft_image_list){0};
    weft_reader *reader = NULL;
    int fd = -1;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(params->log, params->path != NULL);

    res = open_input(params->log, params->path, &fd);
    if (res == WEFT_OK)
        res = weft_reader_start(params->log, "weft-read-exr", params->path, fd, &params->limits,
                                &reader);
    if (res == WEFT_OK)
        res = ask_parts(params, reader, out);
fail:
    weft_reader_stop(&reader);
    if (fd >= 0)
        close(fd);
    if (res != WEFT_OK)
        weft_image_list_clear(out);
    return res;
}
