// SPDX-License-Identifier: BSD-3-Clause
// weft-read-tiff: TIFF images through libtiff for libweft, see wire.h. Values are handed over as
// they are stored, upright and interleaved; palettes and 1, 2 and 4 bits are expanded, and white is
// the largest value. Nothing is done about curves, profiles and alpha.
#include <inttypes.h>
#include <malloc.h>
#include <stdlib.h>

#include "tiles/readers/tiff/tiff_file.h"

enum {
    RATIO_LIMIT = 10000, // declared bytes per stored byte, as weft-read-exr has it
    MOST_BLOCK = 1 << 30 // bytes of a strip or tile, unpacked
};
#define RATIO_FLOOR_BYTES (UINT64_C(1) << 30)

// ---- values of a block --------------------------------------------------------------------------

// A strip or tile as it was unpacked: rows of `across` pixels, of all channels or, where they lie
// apart, of one.
struct block {
    const unsigned char *data;
    uint32_t x, y, width, height; // of it that the image has
    uint32_t across;              // pixels of its rows
    uint32_t first, channels;     // that it has
    size_t row_bytes;
};

// Where the pixel that is stored at (0, 0) goes, and how far the next ones in its row and column
// are, in pixels: the eight ways of TIFF 6.0, page 36.
struct way {
    int64_t origin, right, down;
};

static struct way way_of(const struct weft_tiff_file *f)
{
    const int64_t w = f->shown_width, h = f->shown_height, last = w * h - 1;
    switch (f->orientation) {
    case ORIENTATION_TOPRIGHT:
        return (struct way){w - 1, -1, w};
    case ORIENTATION_BOTRIGHT:
        return (struct way){last, -1, -w};
    case ORIENTATION_BOTLEFT:
        return (struct way){last - w + 1, 1, -w};
    case ORIENTATION_LEFTTOP:
        return (struct way){0, w, 1};
    case ORIENTATION_RIGHTTOP:
        return (struct way){w - 1, w, -1};
    case ORIENTATION_RIGHTBOT:
        return (struct way){last, -w, -1};
    case ORIENTATION_LEFTBOT:
        return (struct way){last - w + 1, -w, 1};
    default:
        return (struct way){0, 1, w};
    }
}

// Sample `i` of a row.
static uint32_t sample_at(const struct weft_tiff_file *f, const unsigned char *row, size_t i)
{
    uint16_t word;
    if (f->bits == 16) {
        memcpy(&word, row + 2 * i, sizeof word);
        return word;
    }
    if (f->bits == 8)
        return row[i];
    const size_t bit = i * f->bits;
    return (uint32_t)(row[bit / 8] >> (8 - f->bits - bit % 8)) & ((1u << f->bits) - 1);
}

static void put_code(const struct weft_tiff_file *f, char *out, uint32_t code)
{
    const uint16_t word = (uint16_t)code;
    if (f->type == WEFT_PIXEL_UNORM8)
        *out = (char)code;
    else
        memcpy(out, &word, sizeof word);
}

static void put_palette(const struct weft_tiff_file *f, char *out, uint32_t index)
{
    for (int c = 0; c < 3; c++)
        put_code(f, out + (size_t)c * f->value_bytes,
                 f->type == WEFT_PIXEL_UNORM8 ? f->map[c][index] >> 8 : f->map[c][index]);
}

// One that is narrower than what it becomes, or is to be turned round, or stands for a colour.
static void put_expanded(const struct weft_tiff_file *f, char *out, uint32_t sample, uint32_t c)
{
    const uint32_t largest = (1u << f->bits) - 1;
    if (f->palette && c == 0) {
        put_palette(f, out, sample);
        return;
    }
    if (f->min_is_white && c == 0)
        sample = largest - sample;
    put_code(f, out, f->bits < 8 ? sample * 255 / largest : sample);
}

// Where a channel's value is in a pixel that is handed over: a palette makes three of the first.
static size_t place_of(const struct weft_tiff_file *f, uint32_t channel)
{
    const size_t at = f->place[channel] + (f->palette && channel ? 2 : 0);
    return at * f->value_bytes;
}

static void put_row(const struct weft_tiff_file *f, const struct block *b, uint32_t y, char *out,
                    int64_t step)
{
    const unsigned char *row = b->data + (size_t)y * b->row_bytes;
    for (uint32_t x = 0; x < b->width; x++, out += step) {
        for (uint32_t c = 0; c < b->channels; c++) {
            const size_t i = (size_t)x * b->channels + c;
            char *to = out + place_of(f, b->first + c);
            if (f->expands)
                put_expanded(f, to, sample_at(f, row, i), b->first + c);
            else
                memcpy(to, row + i * f->value_bytes, f->value_bytes);
        }
    }
}

static void put_block(const struct weft_tiff_file *f, const struct block *b, char *values)
{
    const struct way way = way_of(f);
    const int64_t pixel = (int64_t)f->pixel_bytes;
    const bool plain = !f->expands && !f->moves && b->channels == f->samples && way.right == 1;
    for (uint32_t y = 0; y < b->height; y++) {
        const int64_t at = way.origin + (int64_t)b->x * way.right + (int64_t)(b->y + y) * way.down;
        if (plain)
            memcpy(values + at * pixel, b->data + (size_t)y * b->row_bytes,
                   (size_t)b->width * f->pixel_bytes);
        else
            put_row(f, b, y, values + at * pixel, way.right * pixel);
    }
}

// ---- strips and tiles ---------------------------------------------------------------------------

// The largest one is what is unpacked; no more memory than the image makes plausible.
static enum weft_result measure_blocks(struct weft_tiff_file *f)
{
    const uint64_t bytes = f->tiled ? TIFFTileSize64(f->tiff) : TIFFStripSize64(f->tiff);
    const uint64_t row = f->tiled ? TIFFTileRowSize64(f->tiff) : TIFFScanlineSize64(f->tiff);
    const uint64_t channels = f->planar ? 1 : f->samples;
    const uint64_t least = ((uint64_t)f->across * channels * f->bits + 7) / 8;
    if (!bytes || bytes > MOST_BLOCK)
        return weft_server_fail(f->server, WEFT_ERR_LIMIT,
                                "a strip or tile has %" PRIu64 " bytes, the limit is %d", bytes,
                                MOST_BLOCK);
    if (row < least || row * f->rows > bytes)
        return weft_server_fail(f->server, WEFT_ERR_FORMAT,
                                "rows of %" PRIu64 " bytes, %" PRIu32 " of them, are not a strip "
                                "or tile of %" PRIu64,
                                row, f->rows, bytes);
    f->row_bytes = row;
    f->block_bytes = bytes;
    return WEFT_OK;
}

static enum weft_result read_block(struct weft_tiff_file *f, uint32_t i, unsigned char *buffer,
                                   struct block *b, char *values)
{
    const tmsize_t size = (tmsize_t)f->block_bytes;
    const tmsize_t needed = (tmsize_t)(f->row_bytes * (f->tiled ? f->rows : b->height));
    const tmsize_t got = f->tiled ? TIFFReadEncodedTile(f->tiff, i, buffer, size)
                                  : TIFFReadEncodedStrip(f->tiff, i, buffer, needed);
    if (got != needed && !(f->tiled && got >= needed))
        return weft_tiff_fail(f, f->tiled ? "a tile" : "a strip");
    put_block(f, b, values);
    return WEFT_OK;
}

// Blocks of all columns and rows; of planes that lie apart one after the other.
static enum weft_result read_blocks(struct weft_tiff_file *f, unsigned char *buffer, char *values)
{
    const uint32_t columns = (f->width - 1) / f->across + 1, lines = (f->height - 1) / f->rows + 1;
    const uint32_t planes = f->planar ? f->samples : 1;
    uint32_t i = 0;
    enum weft_result res = WEFT_OK;
    for (uint32_t p = 0; res == WEFT_OK && p < planes; p++)
        for (uint32_t y = 0; res == WEFT_OK && y < lines; y++)
            for (uint32_t x = 0; res == WEFT_OK && x < columns; x++, i++) {
                struct block b = {.data = buffer,
                                  .x = x * f->across,
                                  .y = y * f->rows,
                                  .across = f->across,
                                  .first = p,
                                  .channels = f->planar ? 1 : f->samples,
                                  .row_bytes = f->row_bytes};
                b.width = f->width - b.x < f->across ? f->width - b.x : f->across;
                b.height = f->height - b.y < f->rows ? f->height - b.y : f->rows;
                res = read_block(f, i, buffer, &b, values);
            }
    return res;
}

static enum weft_result read_values(struct weft_tiff_file *f, char *values)
{
    unsigned char *buffer = malloc(f->block_bytes);
    if (!buffer)
        return weft_server_fail(f->server, WEFT_ERR_LIMIT,
                                "a strip or tile of %" PRIu64 " bytes does not fit in the memory "
                                "limit of %" PRIu64 " bytes",
                                f->block_bytes, f->server->limits.memory_bytes);
    const enum weft_result res = read_blocks(f, buffer, values);
    free(buffer);
    return res;
}

// ---- the answer ---------------------------------------------------------------------------------

static enum weft_result check_amount(struct weft_tiff_file *f, size_t *bytes)
{
    struct weft_server *s = f->server;
    if (!weft_size_mul((size_t)f->width * f->pixel_bytes, f->height, bytes))
        *bytes = SIZE_MAX;
    if (*bytes > s->limits.output_bytes)
        return weft_server_fail(s, WEFT_ERR_LIMIT,
                                "%" PRIu32 " x %" PRIu32 " pixels of %" PRIu32 " channels are %zu "
                                "bytes, the output limit is %" PRIu64,
                                f->width, f->height, f->channels, *bytes, s->limits.output_bytes);
    if (*bytes > RATIO_FLOOR_BYTES && *bytes / RATIO_LIMIT > f->stream.end)
        return weft_server_fail(s, WEFT_ERR_LIMIT,
                                "%zu bytes are declared in a file of %" PRIu64
                                " bytes, the limit is %d times as many",
                                *bytes, f->stream.end, RATIO_LIMIT);
    return WEFT_OK;
}

static enum weft_result answer(struct weft_tiff_file *f)
{
    size_t bytes = 0;
    char *values = NULL;
    const bool info_only = f->server->request->info_only;
    enum weft_result res = weft_tiff_open(f);
    if (res == WEFT_OK)
        res = weft_tiff_take_part(f, f->server->request->part);
    if (res == WEFT_OK && !info_only)
        res = check_amount(f, &bytes);
    if (res == WEFT_OK && !info_only)
        res = measure_blocks(f);
    if (res == WEFT_OK)
        res = weft_tiff_begin_frame(f, bytes, &values);
    return values && !info_only ? read_values(f, values) : res;
}

static enum weft_result handle(struct weft_server *server)
{
    struct weft_tiff_file *f = server->priv;
    f->server = server;
    f->stream.message[0] = '\0';
    if (server->request->op != WEFT_WIRE_IMAGE_FRAME)
        return weft_server_fail(server, WEFT_ERR_READER, "weft-read-tiff: unknown request %" PRIu32,
                                server->request->op);
    if (server->request->attached & WEFT_WIRE_ATTACHED_FILE)
        weft_tiff_close(f); // the one before
    return answer(f);
}

int main(int argc, char **argv)
{
    struct weft_tiff_file file = {.tiff = NULL};
    mallopt(M_ARENA_MAX, 1); // address space is limited
    return weft_server_run(argc, argv, handle, &file);
}
