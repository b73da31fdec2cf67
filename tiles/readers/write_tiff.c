// SPDX-License-Identifier: BSD-3-Clause
// weft-write-tiff: writes TIFF files through libtiff for libweft, see wire.h: what libtiff needs,
// JPEG and WebP and more, is no part of the library.
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "tiles/image/image_attribute.h"
#include "tiles/image/image_wire.h"
#include "tiles/process/server.h"
#include "tiles/readers/tiff/tiff_stream.h"
#include "tiles/readers/tiff/tiff_texts.h"

enum {
    STRIP_BYTES = 256 << 10, // of a strip, about
    LEVEL = 1                // of deflate
};
#define CLASSIC_LIMIT UINT64_C(4000000000) // bytes of values; more are BigTIFF

struct writer {
    struct weft_server *server;
    TIFF *tiff;
    struct weft_tiff_stream stream;
    unsigned char *buffer;
};

// A part as it came.
struct part {
    struct weft_wire_tiff head;
    const unsigned char *header;
    const char *values;
    size_t pixel_bytes;
    bool tiled;
};

static enum weft_result fail(struct writer *w)
{
    return weft_server_fail(w->server, WEFT_ERR_WRITE, "%s",
                            w->stream.message[0] ? w->stream.message
                                                 : "libtiff failed without a reason");
}

static enum weft_result open_file(struct writer *w)
{
    const bool big = w->server->request->payload_bytes > CLASSIC_LIMIT;
    w->stream.fd = w->server->input_fd;
    w->tiff = weft_tiff_stream_open(&w->stream, w->server->path, big ? "w8m" : "wm");
    return w->tiff ? WEFT_OK : fail(w);
}

// ---- tags ---------------------------------------------------------------------------------------

static void set_type(TIFF *tiff, const struct part *p)
{
    static const struct {
        uint16_t bits, format, predictor;
    } types[] = {
        [WEFT_PIXEL_FLOAT] = {32, SAMPLEFORMAT_IEEEFP, PREDICTOR_FLOATINGPOINT},
        [WEFT_PIXEL_HALF] = {16, SAMPLEFORMAT_IEEEFP, PREDICTOR_FLOATINGPOINT},
        [WEFT_PIXEL_UINT] = {32, SAMPLEFORMAT_UINT, PREDICTOR_HORIZONTAL},
        [WEFT_PIXEL_UNORM8] = {8, SAMPLEFORMAT_UINT, PREDICTOR_HORIZONTAL},
        [WEFT_PIXEL_UNORM16] = {16, SAMPLEFORMAT_UINT, PREDICTOR_HORIZONTAL},
    };
    const enum weft_image_compression from = (enum weft_image_compression)p->head.compression;
    const uint16_t compression = from == WEFT_IMAGE_NONE  ? COMPRESSION_NONE
                                 : from == WEFT_IMAGE_RLE ? COMPRESSION_PACKBITS
                                 : from == WEFT_IMAGE_LZW ? COMPRESSION_LZW
                                                          : COMPRESSION_ADOBE_DEFLATE;
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, types[p->head.type].bits);
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, types[p->head.type].format);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, compression);
    if (compression == COMPRESSION_LZW || compression == COMPRESSION_ADOBE_DEFLATE)
        TIFFSetField(tiff, TIFFTAG_PREDICTOR, types[p->head.type].predictor);
    if (compression == COMPRESSION_ADOBE_DEFLATE)
        TIFFSetField(tiff, TIFFTAG_ZIPQUALITY, LEVEL);
}

static bool set_extras(TIFF *tiff, const struct part *p)
{
    const uint32_t count = p->head.channels - p->head.colours;
    uint16_t *kinds = calloc(count + 1, sizeof *kinds);
    if (!kinds)
        return false;
    for (uint32_t i = 0; i < count; i++)
        kinds[i] = i || !p->head.alpha  ? EXTRASAMPLE_UNSPECIFIED
                   : p->head.associated ? EXTRASAMPLE_ASSOCALPHA
                                        : EXTRASAMPLE_UNASSALPHA;
    if (count)
        TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, (uint16_t)count, kinds);
    free(kinds);
    return true;
}

static uint32_t rows_of_strip(const struct part *p)
{
    const uint64_t row = (uint64_t)p->pixel_bytes * p->head.width;
    const uint64_t rows = row < STRIP_BYTES ? STRIP_BYTES / row : 1;
    return rows < p->head.height ? (uint32_t)rows : p->head.height;
}

static void set_density(TIFF *tiff, const struct part *p)
{
    const bool dense = p->head.density > 0.0f;
    if (!dense && p->head.aspect == 1.0f)
        return;
    const float across = dense ? p->head.density : 1.0f;
    TIFFSetField(tiff, TIFFTAG_RESOLUTIONUNIT, dense ? RESUNIT_INCH : RESUNIT_NONE);
    TIFFSetField(tiff, TIFFTAG_XRESOLUTION, across);
    TIFFSetField(tiff, TIFFTAG_YRESOLUTION, across * p->head.aspect);
}

static bool set_text(TIFF *tiff, uint32_t tag, const struct weft_image_attribute *a)
{
    char *text = malloc(a->size + 1);
    if (!text)
        return false;
    memcpy(text, a->data, a->size);
    text[a->size] = '\0';
    TIFFSetField(tiff, tag, text);
    free(text);
    return true;
}

static bool set_attribute(TIFF *tiff, const struct weft_image_attribute *a)
{
    if (!strcmp(a->name, WEFT_ATTRIBUTE_ICC) && a->size) {
        TIFFSetField(tiff, TIFFTAG_ICCPROFILE, (uint32_t)a->size, a->data);
        return true;
    }
    for (size_t i = 0; i < WEFT_COUNT(weft_tiff_texts); i++)
        if (!strcmp(a->name, weft_tiff_texts[i].name))
            return set_text(tiff, weft_tiff_texts[i].tag, a);
    return true;
}

static bool set_texts(TIFF *tiff, const struct part *p)
{
    struct weft_image_attribute a;
    size_t at = 0;
    bool whole = true;
    while (whole &&
           weft_attribute_next(p->header, p->head.header_bytes, &at, &a) == WEFT_ATTRIBUTE_TAKEN)
        whole = set_attribute(tiff, &a);
    TIFFSetField(tiff, TIFFTAG_SOFTWARE, "weft");
    return whole;
}

static enum weft_result set_tags(struct writer *w, const struct part *p, uint32_t index)
{
    TIFF *tiff = w->tiff;
    const uint32_t count = w->server->request->part;
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, p->head.width);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, p->head.height);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, (uint16_t)p->head.channels);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC,
                 p->head.colours == 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK);
    set_type(tiff, p);
    if (count > 1) {
        TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, FILETYPE_PAGE);
        TIFFSetField(tiff, TIFFTAG_PAGENUMBER, (uint16_t)index, (uint16_t)count);
    }
    if (p->tiled) {
        TIFFSetField(tiff, TIFFTAG_TILEWIDTH, p->head.tile[0]);
        TIFFSetField(tiff, TIFFTAG_TILELENGTH, p->head.tile[1]);
    } else {
        TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, rows_of_strip(p));
    }
    set_density(tiff, p);
    if (!set_extras(tiff, p) || !set_texts(tiff, p))
        return weft_server_fail(w->server, WEFT_ERR_MEMORY, "out of memory for tags");
    return WEFT_OK;
}

// ---- values -------------------------------------------------------------------------------------

// libtiff works on its input in place.
static enum weft_result write_strips(struct writer *w, const struct part *p)
{
    const uint32_t rows = rows_of_strip(p), count = (p->head.height - 1) / rows + 1;
    const size_t row_bytes = p->pixel_bytes * p->head.width;
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t left = p->head.height - i * rows;
        const size_t bytes = (left < rows ? left : rows) * row_bytes;
        memcpy(w->buffer, p->values + (size_t)i * rows * row_bytes, bytes);
        if (TIFFWriteEncodedStrip(w->tiff, i, w->buffer, (tmsize_t)bytes) < 0)
            return fail(w);
    }
    return WEFT_OK;
}

// What a tile has beyond the image repeats its last column and row, which packs well.
static void fill_tile(struct writer *w, const struct part *p, uint32_t x, uint32_t y)
{
    const uint32_t *tile = p->head.tile;
    const uint32_t left = p->head.width - x, wide = left < tile[0] ? left : tile[0];
    for (uint32_t j = 0; j < tile[1]; j++) {
        const uint32_t row = y + j < p->head.height ? y + j : p->head.height - 1;
        const char *from = p->values + ((size_t)row * p->head.width + x) * p->pixel_bytes;
        unsigned char *to = w->buffer + (size_t)j * tile[0] * p->pixel_bytes;
        memcpy(to, from, wide * p->pixel_bytes);
        for (uint32_t i = wide; i < tile[0]; i++)
            memcpy(to + i * p->pixel_bytes, from + (wide - 1) * p->pixel_bytes, p->pixel_bytes);
    }
}

static enum weft_result write_tiles(struct writer *w, const struct part *p)
{
    const uint32_t *tile = p->head.tile;
    const size_t bytes = (size_t)tile[0] * tile[1] * p->pixel_bytes;
    uint32_t i = 0;
    for (uint64_t y = 0; y < p->head.height; y += tile[1]) {
        for (uint64_t x = 0; x < p->head.width; x += tile[0], i++) {
            fill_tile(w, p, (uint32_t)x, (uint32_t)y);
            if (TIFFWriteEncodedTile(w->tiff, i, w->buffer, (tmsize_t)bytes) < 0)
                return fail(w);
        }
    }
    return WEFT_OK;
}

// ---- parts --------------------------------------------------------------------------------------

// What comes is ours, but for a caller's mistake.
static bool take_part(const char **at, const char *end, struct part *out)
{
    struct weft_wire_tiff *h = &out->head;
    if ((size_t)(end - *at) < sizeof *h)
        return false;
    memcpy(h, *at, sizeof *h);
    *at += sizeof *h;
    const uint64_t left = (uint64_t)(end - *at);
    if (h->type >= WEFT_PIXEL_TYPE_COUNT || (h->colours != 1 && h->colours != 3) ||
        h->channels < h->colours + (h->alpha != 0) || h->channels > UINT16_MAX || !h->width ||
        !h->height || h->header_bytes > left || h->value_bytes > left - h->header_bytes)
        return false;
    out->pixel_bytes = h->channels * weft_wire_pixel_size(h->type);
    out->header = (const unsigned char *)*at;
    out->values = *at + h->header_bytes;
    *at += h->header_bytes + h->value_bytes;
    out->tiled = h->tile[0] && h->tile[1] && h->tile[0] % 16 == 0 && h->tile[1] % 16 == 0 &&
                 h->tile[0] <= 8192 && h->tile[1] <= 8192;
    return h->value_bytes / h->width / h->height == out->pixel_bytes;
}

static enum weft_result write_part(struct writer *w, const struct part *p, uint32_t index)
{
    const size_t bytes = p->tiled ? (size_t)p->head.tile[0] * p->head.tile[1] * p->pixel_bytes
                                  : rows_of_strip(p) * p->pixel_bytes * p->head.width;
    enum weft_result res = set_tags(w, p, index);
    if (res != WEFT_OK)
        return res;
    w->buffer = malloc(bytes);
    if (!w->buffer)
        return weft_server_fail(w->server, WEFT_ERR_MEMORY, "out of memory for %zu bytes", bytes);
    res = p->tiled ? write_tiles(w, p) : write_strips(w, p);
    free(w->buffer);
    w->buffer = NULL;
    if (res == WEFT_OK && !TIFFWriteDirectory(w->tiff))
        res = fail(w);
    return res;
}

static enum weft_result write_parts(struct writer *w)
{
    const struct weft_wire_request *request = w->server->request;
    const char *at = w->server->request_payload, *end = at + request->payload_bytes;
    enum weft_result res = WEFT_OK;
    for (uint32_t i = 0; res == WEFT_OK && i < request->part; i++) {
        struct part part;
        if (!at || !take_part(&at, end, &part))
            return weft_server_fail(w->server, WEFT_ERR_READER, "part %" PRIu32 " is cut short", i);
        res = write_part(w, &part, i);
    }
    return res;
}

static enum weft_result handle(struct weft_server *server)
{
    struct writer w = {.server = server};
    if (server->request->op != WEFT_WIRE_IMAGE_WRITE)
        return weft_server_fail(server, WEFT_ERR_READER,
                                "weft-write-tiff: unknown request %" PRIu32, server->request->op);
    enum weft_result res = open_file(&w);
    if (res != WEFT_OK)
        return res;
    res = write_parts(&w);
    TIFFClose(w.tiff);
    if (res == WEFT_OK && w.stream.message[0])
        res = fail(&w);
    server->answer.count[0] = w.stream.end;
    return res;
}

int main(int argc, char **argv)
{
    return weft_server_run(argc, argv, handle, NULL);
}
