// SPDX-License-Identifier: BSD-3-Clause
// Image files before their values: what readers say of their headers, which is checked again here:
// a damaged file may have taken a reader over.
#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "filter/check.h"
#include "tiles/image/image_attribute.h"
#include "tiles/image/image_impl.h"
#include "tiles/image/image_wire.h"
#include "tiles/process/foreign.h"

// ---- what a file is -----------------------------------------------------------------------------

bool weft_image_recognise(const void *start, size_t size, enum weft_image_file_kind *out)
{
    static const struct {
        unsigned char bytes[8];
        size_t size;
        enum weft_image_file_kind kind;
    } kinds[] = {
        {{0x76, 0x2f, 0x31, 0x01}, 4, WEFT_IMAGE_FILE_EXR},
        {{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'}, 8, WEFT_IMAGE_FILE_PNG},
        {{'I', 'I', 42, 0}, 4, WEFT_IMAGE_FILE_TIFF},
        {{'M', 'M', 0, 42}, 4, WEFT_IMAGE_FILE_TIFF},
        {{'I', 'I', 43, 0}, 4, WEFT_IMAGE_FILE_TIFF}, // BigTIFF
        {{'M', 'M', 0, 43}, 4, WEFT_IMAGE_FILE_TIFF},
    };
    for (size_t i = 0; i < WEFT_COUNT(kinds); i++) {
        if (size < kinds[i].size || memcmp(start, kinds[i].bytes, kinds[i].size))
            continue;
        *out = kinds[i].kind;
        return true;
    }
    return false;
}

enum weft_result weft_image_find_kind(const struct weft_log *log, const char *path, int fd,
                                      enum weft_image_file_kind *out)
{
    unsigned char start[8] = {0};
    const ssize_t got = pread(fd, start, sizeof start, 0);
    if (got < 0) {
        weft_error(log, "%s cannot be read: %s", path, strerror(errno));
        return WEFT_ERR_OPEN;
    }
    if (weft_image_recognise(start, (size_t)got, out))
        return WEFT_OK;
    const char *name = weft_foreign_name(start, (size_t)got);
    if (name) {
        weft_error(log, "%s is %s, not an image (an EXR, PNG or TIFF file)", path, name);
        return WEFT_ERR_FORMAT;
    }
    weft_error(log,
               "%s is neither an EXR, a PNG nor a TIFF file: it starts with bytes %02x %02x %02x "
               "%02x",
               path, start[0], start[1], start[2], start[3]);
    return WEFT_ERR_FORMAT;
}

const char *weft_image_program(enum weft_image_file_kind kind)
{
    static const char *const programs[] = {[WEFT_IMAGE_FILE_EXR] = "weft-read-exr",
                                           [WEFT_IMAGE_FILE_PNG] = "weft-read-png",
                                           [WEFT_IMAGE_FILE_TIFF] = "weft-read-tiff"};
    return programs[kind];
}

// ---- what an image is ---------------------------------------------------------------------------

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
           wire->levels < WEFT_IMAGE_LEVELS_COUNT &&
           (!wire->tiled || (wire->tile[0] > 0 && wire->tile[1] > 0)) &&
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

// EXR has no codes; the others have one type for all channels.
static bool plausible_types(const struct weft_image *image)
{
    const enum weft_pixel_type first = image->channels[0].type;
    bool same = true;
    for (size_t c = 0; c < image->channel_count; c++) {
        if (image->kind == WEFT_IMAGE_FILE_EXR && image->channels[c].type > WEFT_PIXEL_UINT)
            return false;
        same = same && image->channels[c].type == first;
    }
    return image->kind == WEFT_IMAGE_FILE_EXR ||
           (image->kind == WEFT_IMAGE_FILE_PNG && same && image->channel_count <= 4 &&
            (first == WEFT_PIXEL_UNORM8 || first == WEFT_PIXEL_UNORM16)) ||
           (image->kind == WEFT_IMAGE_FILE_TIFF && same);
}

enum weft_result weft_image_take_info(const void *info, size_t size, enum weft_image_file_kind kind,
                                      int part, struct weft_image *out)
{
    struct weft_wire_image wire;
    const char *data = info;
    *out = (struct weft_image){0};
    if (size < sizeof wire)
        return WEFT_ERR_READER;
    memcpy(&wire, data, sizeof wire);
    data += sizeof wire;
    if (!plausible_frame(&wire) || !plausible_counts(&wire, size) ||
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
        .tile = {wire.tile[0], wire.tile[1]},
        .levels = (enum weft_image_levels)wire.levels,
        .deep = wire.deep,
        .kind = kind,
        .part = part,
        .part_count = (int)wire.part_count,
    };
    out->channels = calloc(wire.channel_count, sizeof *out->channels);
    if (!out->channels)
        return WEFT_ERR_MEMORY;
    out->channel_count = wire.channel_count;
    if (!take_channels(out, data) || !plausible_types(out))
        return WEFT_ERR_READER;
    data += wire.channel_count * sizeof(struct weft_wire_channel);
    return take_attributes(out, data, wire.header_bytes);
}

enum weft_result weft_image_take_codes(const struct weft_wire_frame *frame,
                                       struct weft_image *image)
{
    const uint32_t bits = frame->bits, flags = frame->flags;
    const bool png = image->kind == WEFT_IMAGE_FILE_PNG;
    if (!(bits == 1 || bits == 2 || bits == 4 || bits == 8 || bits == 16 || (!png && bits == 32)) ||
        flags > WEFT_WIRE_CODES_FLAGS || (png && flags & WEFT_WIRE_CODES_ASSOCIATED) ||
        !(frame->gamma >= 0.0 && frame->gamma < 1e9))
        return WEFT_ERR_READER;
    image->codes = (struct weft_code_info){
        .bits = (int)bits,
        .palette = flags & WEFT_WIRE_CODES_PALETTE,
        .alpha = flags & WEFT_WIRE_CODES_ALPHA,
        .interlaced = flags & WEFT_WIRE_CODES_INTERLACED,
        .srgb = flags & WEFT_WIRE_CODES_SRGB,
        .icc = flags & WEFT_WIRE_CODES_ICC,
        .associated = flags & WEFT_WIRE_CODES_ASSOCIATED,
        .gamma = frame->gamma,
    };
    memcpy(image->codes.cicp, frame->cicp, sizeof image->codes.cicp);
    return WEFT_OK;
}
