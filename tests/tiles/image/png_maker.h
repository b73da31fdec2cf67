// SPDX-License-Identifier: BSD-3-Clause
// tests/tiles/image/png_maker.h - PNG files of every kind, through libpng, and chunks by hand.
// Include after cmocka.h.
#ifndef WEFT_TESTS_TILES_IMAGE_PNG_MAKER_H
#define WEFT_TESTS_TILES_IMAGE_PNG_MAKER_H

#include <png.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

struct png_recipe {
    const char *path;
    int width, height, bits, colour; // PNG_COLOR_TYPE_...
    bool interlaced, transparent;    // a tRNS chunk: colour 0, or the palette's entry 0
    bool srgb;
    double gamma; // 0: none
    const uint8_t *cicp;
};

static inline int png_channels(int colour)
{
    return colour == PNG_COLOR_TYPE_PALETTE ? 1
                                            : 1 + (colour & PNG_COLOR_MASK_COLOR ? 2 : 0) +
                                                  (colour & PNG_COLOR_MASK_ALPHA ? 1 : 0);
}

// What a sample's code is: all of them occur.
static inline unsigned png_sample(const struct png_recipe *r, int x, int y, int c)
{
    const unsigned largest = (1u << r->bits) - 1;
    const unsigned v = (unsigned)(x + 3 * y + 5 * c) * (r->bits == 16 ? 257u * 7 + 3 : 1u);
    return v & largest;
}

// Entry i of the palette.
static inline png_color png_entry(int i)
{
    return (png_color){(png_byte)(i * 7), (png_byte)(255 - i), (png_byte)(i * i)};
}

static inline void png_set_chunks(png_structp png, png_infop info, const struct png_recipe *r)
{
    png_color palette[256];
    png_byte alpha[1] = {77};
    png_color_16 colour = {0};
    for (int i = 0; i < 256; i++)
        palette[i] = png_entry(i);
    if (r->colour == PNG_COLOR_TYPE_PALETTE)
        png_set_PLTE(png, info, palette, 1 << r->bits);
    if (r->transparent && r->colour == PNG_COLOR_TYPE_PALETTE)
        png_set_tRNS(png, info, alpha, 1, NULL);
    else if (r->transparent)
        png_set_tRNS(png, info, NULL, 0, &colour);
    if (r->srgb)
        png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    if (r->gamma > 0.0)
        png_set_gAMA(png, info, r->gamma);
    if (r->cicp) {
        png_unknown_chunk chunk = {
            .name = "cICP", .size = 4, .location = PNG_HAVE_IHDR, .data = (png_bytep)r->cicp};
        png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_ALWAYS, (png_const_bytep) "cICP", 1);
        png_set_unknown_chunks(png, info, &chunk, 1);
    }
}

static inline void png_make(const struct png_recipe *r)
{
    const int channels = png_channels(r->colour);
    const size_t row_bytes = ((size_t)r->width * (size_t)channels * (size_t)r->bits + 7) / 8;
    uint8_t *data = calloc((size_t)r->height, row_bytes);
    png_bytep *rows = calloc((size_t)r->height, sizeof *rows);
    FILE *f = fopen(r->path, "wb");
    assert_true(data && rows && f);
    for (int y = 0; y < r->height; y++) {
        rows[y] = data + (size_t)y * row_bytes;
        for (int i = 0; i < r->width * channels; i++) {
            const unsigned v = png_sample(r, i / channels, y, i % channels);
            if (r->bits == 16) {
                rows[y][2 * i] = (uint8_t)(v >> 8);
                rows[y][2 * i + 1] = (uint8_t)v;
            } else {
                const int bit = i * r->bits;
                rows[y][bit / 8] |= (uint8_t)(v << (8 - r->bits - bit % 8));
            }
        }
    }
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    if (setjmp(png_jmpbuf(png)))
        fail_msg("libpng cannot write %s", r->path);
    png_init_io(png, f);
    png_set_IHDR(png, info, (png_uint_32)r->width, (png_uint_32)r->height, r->bits, r->colour,
                 r->interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_BASE, PNG_FILTER_TYPE_BASE);
    png_set_chunks(png, info, r);
    png_write_info(png, info);
    png_write_image(png, rows);
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    assert_int_equal(fclose(f), 0);
    free(rows);
    free(data);
}

// ---- by hand ------------------------------------------------------------------------------------

static inline void png_put32(uint8_t *to, uint32_t v)
{
    for (int i = 0; i < 4; i++)
        to[i] = (uint8_t)(v >> (24 - 8 * i));
}

static inline void png_chunk(FILE *f, const char *name, const void *data, size_t size)
{
    uint8_t head[8], tail[4];
    png_put32(head, (uint32_t)size);
    memcpy(head + 4, name, 4);
    uLong crc = crc32(0, head + 4, 4);
    crc = size ? crc32(crc, data, (uInt)size) : crc;
    png_put32(tail, (uint32_t)crc);
    fwrite(head, 1, sizeof head, f);
    fwrite(data, 1, size, f);
    fwrite(tail, 1, sizeof tail, f);
}

// Begins a file with its header.
static inline FILE *png_begin(const char *path, uint32_t width, uint32_t height, int bits,
                              int colour)
{
    uint8_t header[13] = {0};
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    png_put32(header, width);
    png_put32(header + 4, height);
    header[8] = (uint8_t)bits;
    header[9] = (uint8_t)colour;
    fwrite("\x89PNG\r\n\x1a\n", 1, 8, f);
    png_chunk(f, "IHDR", header, sizeof header);
    return f;
}

// So many zeros, deflated, as a chunk behind `prefix`.
static inline void png_zeros(FILE *f, const char *name, const void *prefix, size_t prefix_size,
                             size_t zeros)
{
    const size_t room = zeros / 900 + 1000;
    uint8_t *packed = malloc(prefix_size + room), *block = calloc(1, 1 << 20);
    z_stream z = {0};
    assert_true(packed && block && deflateInit(&z, 9) == Z_OK);
    memcpy(packed, prefix, prefix_size);
    z.next_out = packed + prefix_size;
    z.avail_out = (uInt)room;
    for (size_t left = zeros; left;) {
        const size_t n = left < 1 << 20 ? left : 1 << 20;
        z.next_in = block;
        z.avail_in = (uInt)n;
        left -= n;
        assert_true(deflate(&z, left ? Z_NO_FLUSH : Z_FINISH) >= 0);
    }
    assert_int_equal(z.avail_in, 0);
    png_chunk(f, name, packed, prefix_size + z.total_out);
    deflateEnd(&z);
    free(packed);
    free(block);
}

static inline void png_end(FILE *f)
{
    png_chunk(f, "IEND", "", 0);
    assert_int_equal(fclose(f), 0);
}

#endif
