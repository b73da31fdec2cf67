// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/image/image_chunk.h"

#include <stdlib.h>
#include <string.h>

#include <libdeflate.h>

// SLACK: libdeflate gives up some bytes before the end of its room.
enum { LEVEL = 4, SLACK = 64, SHORTEST_RUN = 3, LONGEST_RUN = 127 };

struct weft_chunk_packer {
    enum weft_image_compression compression;
    size_t capacity;
    unsigned char *split, *packed, *unpacked;
    struct libdeflate_compressor *compressor;
    struct libdeflate_decompressor *decompressor;
};

int weft_chunk_lines(enum weft_image_compression compression)
{
    return compression == WEFT_IMAGE_ZIP ? 16 : compression == WEFT_IMAGE_PIZ ? 32 : 1;
}

void weft_chunk_packer_destroy(weft_chunk_packer **packer)
{
    weft_chunk_packer *p = *packer;
    if (!p)
        return;
    if (p->compressor)
        libdeflate_free_compressor(p->compressor);
    if (p->decompressor)
        libdeflate_free_decompressor(p->decompressor);
    free(p->split);
    free(p->packed);
    free(p->unpacked);
    free(p);
    *packer = NULL;
}

enum weft_result weft_chunk_packer_create(enum weft_image_compression compression, size_t capacity,
                                          weft_chunk_packer **out)
{
    weft_chunk_packer *p = *out = calloc(1, sizeof *p);
    if (!p)
        return WEFT_ERR_MEMORY;
    p->compression = compression;
    p->capacity = capacity;
    bool whole = true;
    if (compression != WEFT_IMAGE_NONE) {
        p->split = malloc(capacity);
        p->packed = malloc(capacity + SLACK);
        p->unpacked = malloc(capacity);
        whole = p->split && p->packed && p->unpacked;
    }
    if (compression == WEFT_IMAGE_ZIP || compression == WEFT_IMAGE_ZIPS) {
        p->compressor = libdeflate_alloc_compressor(LEVEL);
        p->decompressor = libdeflate_alloc_decompressor();
        whole = whole && p->compressor && p->decompressor;
    }
    if (!whole)
        weft_chunk_packer_destroy(out);
    return whole ? WEFT_OK : WEFT_ERR_MEMORY;
}

// ---- what ZIP and RLE do before and after -------------------------------------------------------

// Bytes of even index first, then each as its difference to the one before, plus 128.
static void split(const unsigned char *raw, size_t size, unsigned char *out)
{
    const size_t half = (size + 1) / 2;
    for (size_t i = 0; i < size; i++)
        out[(i & 1 ? half : 0) + i / 2] = raw[i];
    unsigned char before = size ? out[0] : 0;
    for (size_t i = 1; i < size; i++) {
        const unsigned char value = out[i];
        out[i] = (unsigned char)(value - before + 128);
        before = value;
    }
}

static bool joins_to(unsigned char *split, size_t size, const unsigned char *raw)
{
    const size_t half = (size + 1) / 2;
    for (size_t i = 1; i < size; i++)
        split[i] = (unsigned char)(split[i - 1] + split[i] - 128);
    for (size_t i = 0; i < size; i++)
        if (split[(i & 1 ? half : 0) + i / 2] != raw[i])
            return false;
    return true;
}

// ---- RLE ----------------------------------------------------------------------------------------

static size_t run_at(const unsigned char *data, size_t size, size_t at)
{
    size_t run = 1;
    while (run <= LONGEST_RUN && at + run < size && data[at + run] == data[at])
        run++;
    return run;
}

// A run is its length less one and the byte; other bytes follow the negative of their number.
// Returns 0 where out, of `size` bytes, has no room.
static size_t pack_runs(const unsigned char *data, size_t size, unsigned char *out)
{
    size_t used = 0;
    for (size_t at = 0; at < size;) {
        size_t run = run_at(data, size, at), others = 0;
        while (run < SHORTEST_RUN && others + run <= LONGEST_RUN && at + others < size) {
            others += run;
            run = at + others < size ? run_at(data, size, at + others) : 0;
        }
        if (used + 1 + (others ? others : 1) > size)
            return 0;
        out[used++] = others ? (unsigned char)-(int)others : (unsigned char)(run - 1);
        memcpy(out + used, data + at, others ? others : 1);
        used += others ? others : 1;
        at += others ? others : run;
    }
    return used;
}

static bool unpack_runs(const unsigned char *packed, size_t size, unsigned char *out, size_t room)
{
    size_t done = 0;
    for (size_t at = 0; at < size;) {
        const signed char count = (signed char)packed[at++];
        const size_t bytes = (size_t)(count < 0 ? -count : count + 1);
        if (bytes > room - done || size - at < (count < 0 ? bytes : 1))
            return false;
        if (count < 0)
            memcpy(out + done, packed + at, bytes);
        else
            memset(out + done, packed[at], bytes);
        at += count < 0 ? bytes : 1;
        done += bytes;
    }
    return done == room;
}

// ---- both ---------------------------------------------------------------------------------------

static size_t shorten(weft_chunk_packer *p, const void *raw, size_t size)
{
    split(raw, size, p->split);
    if (p->compression == WEFT_IMAGE_RLE)
        return pack_runs(p->split, size, p->packed);
    return libdeflate_zlib_compress(p->compressor, p->split, size, p->packed, size + SLACK);
}

static bool lengthen(weft_chunk_packer *p, size_t packed, size_t size)
{
    size_t got = 0;
    if (p->compression == WEFT_IMAGE_RLE)
        return unpack_runs(p->packed, packed, p->unpacked, size);
    return libdeflate_zlib_decompress(p->decompressor, p->packed, packed, p->unpacked, size,
                                      &got) == LIBDEFLATE_SUCCESS &&
           got == size;
}

enum weft_result weft_chunk_pack(weft_chunk_packer *p, const void *raw, size_t size,
                                 struct weft_chunk *out)
{
    *out = (struct weft_chunk){.data = raw, .size = size};
    if (p->compression == WEFT_IMAGE_NONE)
        return WEFT_OK;
    if (size > p->capacity)
        return WEFT_ERR_WRITE;
    out->shortest = shorten(p, raw, size);
    if (!out->shortest || out->shortest >= size)
        return WEFT_OK;
    if (!lengthen(p, out->shortest, size) || !joins_to(p->unpacked, size, raw))
        return WEFT_ERR_WRITE;
    out->data = p->packed;
    out->size = out->shortest;
    out->packed = true;
    return WEFT_OK;
}
