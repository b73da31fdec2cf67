// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/image/exr/header.h"

#include <string.h>

#include "filter/check.h"
#include "tiles/image/image_attribute.h"

enum { SHORT_NAME = 31, DEFAULT_TILE = 64 };

void weft_image_tile_size(const struct weft_image *image, int32_t out[2])
{
    for (int a = 0; a < 2; a++)
        out[a] = image->tile[a] > 0 ? image->tile[a] : DEFAULT_TILE;
}

int weft_image_levels_of(const struct weft_image *image)
{
    const bool mips = image->tiled && image->levels == WEFT_IMAGE_LEVELS_MIP && image->mips;
    return mips ? weft_image_level_count(image->width, image->height) : 1;
}

// ---- what every part has ------------------------------------------------------------------------

// Number `i` of an attribute of floats.
static float float_of(const struct weft_image *image, const char *name, size_t i, float otherwise)
{
    const struct weft_image_attribute *a = weft_image_find(image, name);
    if (!a)
        return otherwise;
    const unsigned char *b = (const unsigned char *)a->data + 4 * i;
    const uint32_t bits = b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static bool is_required(const char *name)
{
    static const char *const names[] = {"pixelAspectRatio", "screenWindowCenter",
                                        "screenWindowWidth"};
    for (size_t i = 0; i < WEFT_COUNT(names); i++)
        if (!strcmp(name, names[i]))
            return true;
    return false;
}

static exr_attr_box2i_t box_of(const int32_t min[2], const int32_t max[2])
{
    exr_attr_box2i_t box;
    memcpy(box.min.arr, min, sizeof box.min.arr);
    memcpy(box.max.arr, max, sizeof box.max.arr);
    return box;
}

static exr_result_t set_required(exr_context_t exr, int part, const struct weft_image *image)
{
    static const exr_compression_t codes[] = {[WEFT_IMAGE_NONE] = EXR_COMPRESSION_NONE,
                                              [WEFT_IMAGE_RLE] = EXR_COMPRESSION_RLE,
                                              [WEFT_IMAGE_ZIPS] = EXR_COMPRESSION_ZIPS,
                                              [WEFT_IMAGE_ZIP] = EXR_COMPRESSION_ZIP,
                                              [WEFT_IMAGE_PIZ] = EXR_COMPRESSION_PIZ};
    static const exr_attr_box2i_t unset;
    const int32_t min[2] = {image->x, image->y};
    const int32_t max[2] = {image->x + image->width - 1, image->y + image->height - 1};
    const exr_attr_box2i_t data = box_of(min, max);
    exr_attr_box2i_t display = box_of(image->display_min, image->display_max);
    exr_attr_v2f_t centre;
    centre.x = float_of(image, "screenWindowCenter", 0, 0.0f);
    centre.y = float_of(image, "screenWindowCenter", 1, 0.0f);
    if (!memcmp(&display, &unset, sizeof display))
        display = data;
    return exr_initialize_required_attr(exr, part, &display, &data,
                                        float_of(image, "pixelAspectRatio", 0, 1.0f), &centre,
                                        float_of(image, "screenWindowWidth", 0, 1.0f),
                                        EXR_LINEORDER_INCREASING_Y, codes[image->compression]);
}

static exr_result_t add_channel(exr_context_t exr, int part,
                                const struct weft_image_channel *channel)
{
    static const exr_pixel_type_t types[] = {[WEFT_PIXEL_FLOAT] = EXR_PIXEL_FLOAT,
                                             [WEFT_PIXEL_HALF] = EXR_PIXEL_HALF,
                                             [WEFT_PIXEL_UINT] = EXR_PIXEL_UINT};
    return exr_add_channel(exr, part, channel->name, types[channel->type],
                           channel->linear ? EXR_PERCEPTUALLY_LINEAR : EXR_PERCEPTUALLY_LOGARITHMIC,
                           1, 1);
}

// ---- attributes ---------------------------------------------------------------------------------

// Of any type as the bytes that it is: OpenEXRCore writes those of types that it does not know as
// they are, so that the type gets its name only after that.
static exr_result_t add_attribute(exr_context_t exr, int part, const struct weft_image_attribute *a)
{
    exr_attribute_t *out;
    exr_result_t rv = exr_attr_declare_by_type(exr, part, a->name, "weft bytes", &out);
    if (rv)
        return rv;
    out->type_name = a->type;
    out->type_name_length = (uint8_t)strlen(a->type);
    out->opaque->packed_data = a->size ? (void *)a->data : ""; // borrowed: its alloc_size is 0
    out->opaque->size = (int32_t)a->size;
    return EXR_ERR_SUCCESS;
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

// Lines, or tiles and their levels.
static exr_result_t set_tiles(exr_context_t exr, int part, const struct weft_image *image)
{
    int32_t tile[2];
    if (!image->tiled)
        return EXR_ERR_SUCCESS;
    weft_image_tile_size(image, tile);
    return exr_set_tile_descriptor(exr, part, (uint32_t)tile[0], (uint32_t)tile[1],
                                   weft_image_levels_of(image) > 1 ? EXR_TILE_MIPMAP_LEVELS
                                                                   : EXR_TILE_ONE_LEVEL,
                                   EXR_TILE_ROUND_DOWN);
}

exr_result_t weft_image_header_add(exr_context_t exr, const struct weft_image *image,
                                   const struct weft_image_channel *const *channels)
{
    int part;
    exr_result_t rv = exr_add_part(exr, *image->name ? image->name : NULL,
                                   image->tiled ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE, &part);
    if (!rv && has_long_names(image))
        rv = exr_set_longname_support(exr, 1);
    if (!rv)
        rv = set_required(exr, part, image);
    for (size_t c = 0; !rv && c < image->channel_count; c++)
        rv = add_channel(exr, part, channels[c]);
    if (!rv)
        rv = set_tiles(exr, part, image);
    for (size_t i = 0; !rv && i < image->attribute_count; i++)
        if (!weft_attribute_is_structure(image->attributes[i].name) &&
            !is_required(image->attributes[i].name))
            rv = add_attribute(exr, part, &image->attributes[i]);
    return rv;
}
