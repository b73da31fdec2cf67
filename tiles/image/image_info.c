// SPDX-License-Identifier: BSD-3-Clause
// Image files before their values: what readers say of their headers, which is checked again here:
// a damaged file may have taken a reader over.
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "tiles/image/image_attribute.h"
#include "tiles/image/image_impl.h"
#include "tiles/image/image_wire.h"

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

enum weft_result weft_image_take_info(const void *info, size_t size, int part,
                                      struct weft_image *out)
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
