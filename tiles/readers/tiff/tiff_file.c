// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/readers/tiff/tiff_file.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

enum {
    SIDE_LIMIT = (1 << 29) - 1,
    MOST_TEXT = 8 << 20 // bytes of a text or profile that is kept
};

enum weft_result weft_tiff_fail(struct weft_tiff_file *f, const char *what)
{
    if (f->stream.message[0])
        return weft_server_fail(f->server, WEFT_ERR_FORMAT, "libtiff says: %s", f->stream.message);
    return weft_server_fail(f->server, WEFT_ERR_FORMAT, "%s is damaged or cut short", what);
}

// ---- opening ------------------------------------------------------------------------------------

// The directories' own chain, so that a file of millions is refused before they are.
static enum weft_result count_parts(struct weft_tiff_file *f)
{
    f->part_count = 1;
    while (!TIFFLastDirectory(f->tiff)) {
        if (f->part_count == WEFT_TIFF_PARTS)
            return weft_server_fail(f->server, WEFT_ERR_LIMIT,
                                    "it has more than %d parts, which is the limit",
                                    WEFT_TIFF_PARTS);
        if (!TIFFReadDirectory(f->tiff))
            return weft_tiff_fail(f, "a directory");
        f->part_count++;
    }
    return WEFT_OK;
}

enum weft_result weft_tiff_open(struct weft_tiff_file *f)
{
    struct stat st;
    if (f->tiff)
        return WEFT_OK;
    if (fstat(f->server->input_fd, &st))
        return weft_server_fail(f->server, WEFT_ERR_OPEN, "%s", strerror(errno));
    f->stream = (struct weft_tiff_stream){.fd = f->server->input_fd, .end = (uint64_t)st.st_size};
    f->tiff = weft_tiff_stream_open(&f->stream, f->server->path, "rm"); // m: not mapped
    return f->tiff ? count_parts(f) : weft_tiff_fail(f, "the header");
}

void weft_tiff_close(struct weft_tiff_file *f)
{
    if (f->tiff)
        TIFFClose(f->tiff);
    f->tiff = NULL;
}

// ---- a part's header ----------------------------------------------------------------------------

static uint16_t word_of(struct weft_tiff_file *f, uint32_t tag)
{
    uint16_t value = 0;
    TIFFGetFieldDefaulted(f->tiff, tag, &value);
    return value;
}

// Integers of up to 16 bits are codes; what else is handed over is as it is.
static enum weft_result choose_type(struct weft_tiff_file *f)
{
    const uint16_t format = word_of(f, TIFFTAG_SAMPLEFORMAT);
    const bool integer = format == SAMPLEFORMAT_UINT || format == SAMPLEFORMAT_VOID;
    const uint32_t bits = f->bits;
    if (integer && (bits == 1 || bits == 2 || bits == 4 || bits == 8))
        f->type = WEFT_PIXEL_UNORM8;
    else if (integer && bits == 16)
        f->type = WEFT_PIXEL_UNORM16;
    else if (integer && bits == 32)
        f->type = WEFT_PIXEL_UINT;
    else if (format == SAMPLEFORMAT_IEEEFP && bits == 16)
        f->type = WEFT_PIXEL_HALF;
    else if (format == SAMPLEFORMAT_IEEEFP && bits == 32)
        f->type = WEFT_PIXEL_FLOAT;
    else
        return weft_server_fail(f->server, WEFT_ERR_UNSUPPORTED,
                                "samples of %" PRIu32 " bits of format %d are unsupported: "
                                "unsigned integers of 1, 2, 4, 8, 16 and 32 bits and floats of 16 "
                                "and 32 are read",
                                bits, format);
    f->value_bytes = weft_wire_pixel_size(f->type);
    return WEFT_OK;
}

// A palette whose entries were bytes stays one of bytes.
static enum weft_result take_palette(struct weft_tiff_file *f)
{
    if (f->bits > 16 || f->type > WEFT_PIXEL_UNORM16 || f->type < WEFT_PIXEL_UNORM8 ||
        !TIFFGetField(f->tiff, TIFFTAG_COLORMAP, &f->map[0], &f->map[1], &f->map[2]))
        return weft_server_fail(f->server, WEFT_ERR_FORMAT, "it has no palette for its indices");
    bool bytes = true;
    for (int c = 0; c < 3; c++)
        for (uint32_t i = 0; i < 1u << f->bits; i++)
            bytes = bytes && f->map[c][i] >> 8 == (f->map[c][i] & 255);
    f->type = bytes ? WEFT_PIXEL_UNORM8 : WEFT_PIXEL_UNORM16;
    f->value_bytes = weft_wire_pixel_size(f->type);
    f->palette = true;
    return WEFT_OK;
}

static enum weft_result choose_colours(struct weft_tiff_file *f)
{
    const bool integer = f->type == WEFT_PIXEL_UNORM8 || f->type == WEFT_PIXEL_UNORM16;
    switch (f->photometric) {
    case PHOTOMETRIC_MINISWHITE:
        f->min_is_white = true;
        f->colours = 1;
        if (integer)
            return WEFT_OK;
        break;
    case PHOTOMETRIC_MINISBLACK:
        f->colours = 1;
        return WEFT_OK;
    case PHOTOMETRIC_RGB:
        f->colours = 3;
        return WEFT_OK;
    case PHOTOMETRIC_PALETTE:
        f->colours = 3;
        return take_palette(f);
    case PHOTOMETRIC_YCBCR: // which libtiff makes RGB of where JPEG packs it
        f->colours = 3;
        if (f->compression == COMPRESSION_JPEG && f->bits == 8 && !f->planar)
            return WEFT_OK;
        break;
    }
    return weft_server_fail(f->server, WEFT_ERR_UNSUPPORTED,
                            "colours of kind %d, packed as %d, are unsupported: grey, RGB and "
                            "palettes are read",
                            f->photometric, f->compression);
}

// The first alpha among the extra samples goes behind the colours.
static enum weft_result place_channels(struct weft_tiff_file *f)
{
    uint16_t count = 0, *kinds = NULL;
    const uint32_t own = f->palette ? 1 : f->colours;
    uint32_t alpha = 0; // sample; 0: none
    if (f->samples < own || f->samples > WEFT_TIFF_CHANNELS)
        return weft_server_fail(f->server, f->samples < own ? WEFT_ERR_FORMAT : WEFT_ERR_LIMIT,
                                "%" PRIu32 " samples a pixel, from %" PRIu32 " to %d are read",
                                f->samples, own, WEFT_TIFF_CHANNELS);
    if (!TIFFGetField(f->tiff, TIFFTAG_EXTRASAMPLES, &count, &kinds))
        count = 0;
    for (uint32_t i = 0; !alpha && i < count && own + i < f->samples; i++) {
        if (kinds[i] != EXTRASAMPLE_ASSOCALPHA && kinds[i] != EXTRASAMPLE_UNASSALPHA)
            continue;
        alpha = own + i;
        f->associated = kinds[i] == EXTRASAMPLE_ASSOCALPHA;
    }
    f->alpha = alpha != 0;
    for (uint32_t i = 0; i < f->samples; i++)
        f->place[i] = !alpha || i < own || i > alpha ? i : i == alpha ? own : i + 1;
    f->moves = alpha > own;
    f->channels = f->samples + (f->palette ? 2 : 0);
    f->pixel_bytes = f->channels * f->value_bytes;
    f->expands = f->bits < 8 || f->palette || f->min_is_white;
    return WEFT_OK;
}

static enum weft_result take_sizes(struct weft_tiff_file *f)
{
    struct weft_server *s = f->server;
    if (!TIFFGetField(f->tiff, TIFFTAG_IMAGEWIDTH, &f->width) ||
        !TIFFGetField(f->tiff, TIFFTAG_IMAGELENGTH, &f->height) || !f->width || !f->height)
        return weft_server_fail(s, WEFT_ERR_FORMAT, "it has no pixels");
    if (f->width > SIDE_LIMIT || f->height > SIDE_LIMIT)
        return weft_server_fail(s, WEFT_ERR_LIMIT,
                                "%" PRIu32 " x %" PRIu32 " pixels, the limit of a side is %d",
                                f->width, f->height, SIDE_LIMIT);
    f->tiled = TIFFIsTiled(f->tiff);
    f->across = f->width;
    f->rows = f->height;
    if (f->tiled) {
        TIFFGetField(f->tiff, TIFFTAG_TILEWIDTH, &f->across);
        TIFFGetField(f->tiff, TIFFTAG_TILELENGTH, &f->rows);
    } else {
        TIFFGetFieldDefaulted(f->tiff, TIFFTAG_ROWSPERSTRIP, &f->rows);
        f->rows = f->rows > f->height ? f->height : f->rows;
    }
    if (!f->across || !f->rows || f->across > SIDE_LIMIT || f->rows > SIDE_LIMIT)
        return weft_server_fail(s, WEFT_ERR_FORMAT,
                                "strips or tiles of %" PRIu32 " x %" PRIu32 " pixels", f->across,
                                f->rows);
    return WEFT_OK;
}

static bool is_turned(uint16_t orientation)
{
    return orientation >= ORIENTATION_LEFTTOP && orientation <= ORIENTATION_LEFTBOT;
}

static void reset_part(struct weft_tiff_file *f)
{
    f->bits = word_of(f, TIFFTAG_BITSPERSAMPLE);
    f->samples = word_of(f, TIFFTAG_SAMPLESPERPIXEL);
    f->planar = word_of(f, TIFFTAG_PLANARCONFIG) == PLANARCONFIG_SEPARATE && f->samples > 1;
    f->orientation = word_of(f, TIFFTAG_ORIENTATION);
    f->compression = word_of(f, TIFFTAG_COMPRESSION);
    f->photometric = PHOTOMETRIC_MINISBLACK;
    if (!TIFFGetField(f->tiff, TIFFTAG_PHOTOMETRIC, &f->photometric) && f->samples >= 3)
        f->photometric = PHOTOMETRIC_RGB;
    f->min_is_white = f->palette = f->alpha = f->associated = false;
    if (f->photometric == PHOTOMETRIC_YCBCR && f->compression == COMPRESSION_JPEG)
        TIFFSetField(f->tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
}

enum weft_result weft_tiff_take_part(struct weft_tiff_file *f, uint32_t part)
{
    if (part >= f->part_count)
        return weft_server_fail(f->server, WEFT_ERR_ARGUMENT,
                                "there is no part %" PRIu32 ": it has %" PRIu32 ", from 0", part,
                                f->part_count);
    if (TIFFCurrentDirectory(f->tiff) != part && !TIFFSetDirectory(f->tiff, part))
        return weft_tiff_fail(f, "a directory");
    reset_part(f);
    enum weft_result res = take_sizes(f);
    if (res == WEFT_OK)
        res = choose_type(f);
    if (res == WEFT_OK)
        res = choose_colours(f);
    if (res == WEFT_OK)
        res = place_channels(f);
    f->shown_width = is_turned(f->orientation) ? f->height : f->width;
    f->shown_height = is_turned(f->orientation) ? f->width : f->height;
    return res;
}

// ---- what it says of itself ---------------------------------------------------------------------

static void take_density(struct weft_tiff_file *f, struct weft_attribute_list *out)
{
    float across = 0.0f, down = 0.0f;
    const uint16_t unit = word_of(f, TIFFTAG_RESOLUTIONUNIT);
    if (!TIFFGetField(f->tiff, TIFFTAG_XRESOLUTION, &across) ||
        !TIFFGetField(f->tiff, TIFFTAG_YRESOLUTION, &down) || !(across > 0.0f) || !(down > 0.0f) ||
        !isfinite(across) || !isfinite(down))
        return;
    if (is_turned(f->orientation)) {
        const float other = across;
        across = down;
        down = other;
    }
    if (across != down && isfinite(down / across))
        weft_attribute_add_float(out, "pixelAspectRatio", down / across);
    if (unit == RESUNIT_INCH || unit == RESUNIT_CENTIMETER)
        weft_attribute_add_float(out, "xDensity", unit == RESUNIT_INCH ? across : across * 2.54f);
}

static void take_texts(struct weft_tiff_file *f, struct weft_attribute_list *out)
{
    for (size_t i = 0; i < WEFT_COUNT(weft_tiff_texts); i++) {
        char *text = NULL;
        if (TIFFGetField(f->tiff, weft_tiff_texts[i].tag, &text) && text && *text &&
            strlen(text) <= MOST_TEXT)
            weft_attribute_add(out, weft_tiff_texts[i].name, "string", text, strlen(text));
    }
}

static bool has_profile(struct weft_tiff_file *f, struct weft_attribute_list *out)
{
    uint32_t size = 0;
    void *profile = NULL;
    if (!TIFFGetField(f->tiff, TIFFTAG_ICCPROFILE, &size, &profile) || !size || size > MOST_TEXT)
        return false;
    weft_attribute_add(out, WEFT_ATTRIBUTE_ICC, "icc", profile, size);
    return true;
}

// ---- the answer ---------------------------------------------------------------------------------

static uint32_t compression_of(uint16_t compression)
{
    return compression == COMPRESSION_NONE       ? WEFT_IMAGE_NONE
           : compression == COMPRESSION_LZW      ? WEFT_IMAGE_LZW
           : compression == COMPRESSION_PACKBITS ? WEFT_IMAGE_RLE
                                                 : WEFT_IMAGE_ZIP;
}

static struct weft_wire_image describe(const struct weft_tiff_file *f, size_t header_bytes)
{
    return (struct weft_wire_image){
        .width = (int32_t)f->shown_width,
        .height = (int32_t)f->shown_height,
        .display_max = {(int32_t)f->shown_width - 1, (int32_t)f->shown_height - 1},
        .compression = compression_of(f->compression),
        .tiled = f->tiled,
        .tile = {f->tiled ? (int32_t)f->across : 0, f->tiled ? (int32_t)f->rows : 0},
        .part_count = f->part_count,
        .channel_count = f->channels,
        .header_bytes = header_bytes,
    };
}

static void put_channels(const struct weft_tiff_file *f, char *out)
{
    static const char *const colours[] = {"R", "G", "B"};
    for (uint32_t c = 0; c < f->channels; c++, out += sizeof(struct weft_wire_channel)) {
        struct weft_wire_channel channel = {.type = f->type, .sampling = {1, 1}};
        const uint32_t extra = c - f->colours - f->alpha + 1;
        if (c < f->colours)
            snprintf(channel.name, sizeof channel.name, "%s", f->colours == 1 ? "Y" : colours[c]);
        else if (f->alpha && c == f->colours)
            snprintf(channel.name, sizeof channel.name, "A");
        else
            snprintf(channel.name, sizeof channel.name, "extra%" PRIu32, extra);
        memcpy(out, &channel, sizeof channel);
    }
}

static struct weft_wire_frame make_frame(const struct weft_tiff_file *f, bool profile)
{
    return (struct weft_wire_frame){.bits = f->bits,
                                    .flags = (f->palette ? WEFT_WIRE_CODES_PALETTE : 0) |
                                             (f->alpha ? WEFT_WIRE_CODES_ALPHA : 0) |
                                             (profile ? WEFT_WIRE_CODES_ICC : 0) |
                                             (f->associated ? WEFT_WIRE_CODES_ASSOCIATED : 0)};
}

static char *put_frame(struct weft_tiff_file *f, struct weft_wire_frame *frame,
                       const struct weft_attribute_list *list, size_t bytes)
{
    const struct weft_wire_image image = describe(f, list->size);
    const size_t channels = f->channels * sizeof(struct weft_wire_channel);
    size_t offset = 0;
    frame->info_bytes = sizeof image + channels + list->size;
    weft_wire_align(sizeof *frame + frame->info_bytes, &offset);
    frame->planes_offset = offset;
    char *payload = weft_server_map(f->server, offset + bytes);
    if (!payload)
        return NULL;
    memcpy(payload, frame, sizeof *frame);
    memcpy(payload + sizeof *frame, &image, sizeof image);
    put_channels(f, payload + sizeof *frame + sizeof image);
    memcpy(payload + sizeof *frame + sizeof image + channels, list->data, list->size);
    return payload + offset;
}

enum weft_result weft_tiff_begin_frame(struct weft_tiff_file *f, size_t bytes, char **values)
{
    struct weft_attribute_list list = {.data = NULL};
    take_density(f, &list);
    take_texts(f, &list);
    struct weft_wire_frame frame = make_frame(f, has_profile(f, &list));
    *values = NULL;
    if (weft_attribute_end(&list))
        *values = put_frame(f, &frame, &list, bytes);
    else
        weft_server_fail(f->server, WEFT_ERR_LIMIT,
                         "its texts do not fit in the memory limit of %" PRIu64 " bytes",
                         f->server->limits.memory_bytes);
    free(list.data);
    return (enum weft_result)f->server->answer.result;
}
