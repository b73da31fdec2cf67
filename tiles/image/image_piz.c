// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/image/image_piz.h"

#include <stdlib.h>
#include <string.h>

#include "tiles/image/image_huffman.h"
#include "tiles/image/image_wavelet.h"

enum {
    WORDS = 65536,
    BITMAP = WORDS / 8,
    SMALL = 1 << 14, // words below leave room for differences
};

struct weft_piz {
    const struct weft_chunk_shape *shape;
    weft_huffman *huffman;
    uint16_t *words; // of the channels one after the other, each as an image
    unsigned char bitmap[BITMAP];
    unsigned char occurs[WORDS];
    uint16_t number[WORDS]; // of each word, or the word of each number
};

size_t weft_chunk_line_bytes(const struct weft_chunk_shape *shape)
{
    size_t words = 0;
    for (size_t c = 0; c < shape->channel_count; c++)
        words += shape->words[c];
    return 2 * words * shape->width;
}

void weft_piz_destroy(weft_piz **piz)
{
    if (!*piz)
        return;
    weft_huffman_destroy(&(*piz)->huffman);
    free((*piz)->words);
    free(*piz);
    *piz = NULL;
}

enum weft_result weft_piz_create(const struct weft_chunk_shape *shape, weft_piz **out)
{
    weft_piz *piz = *out = calloc(1, sizeof *piz);
    if (!piz)
        return WEFT_ERR_MEMORY;
    piz->shape = shape;
    piz->huffman = weft_huffman_create();
    piz->words = malloc(weft_chunk_line_bytes(shape) * (size_t)shape->lines);
    if (!piz->huffman || !piz->words)
        weft_piz_destroy(out);
    return *out ? WEFT_OK : WEFT_ERR_MEMORY;
}

// ---- words and their numbers --------------------------------------------------------------------

// Lines to channels, or back: copies between the two orders.
static void copy_lines(const weft_piz *piz, unsigned char *raw, int lines, bool back)
{
    unsigned char *words = (unsigned char *)piz->words;
    for (size_t c = 0; c < piz->shape->channel_count; c++) {
        const size_t bytes = 2 * piz->shape->width * piz->shape->words[c];
        const size_t line_bytes = weft_chunk_line_bytes(piz->shape);
        for (int y = 0; y < lines; y++, words += bytes) {
            unsigned char *line = raw + (size_t)y * line_bytes;
            memcpy(back ? line : words, back ? words : line, bytes);
        }
        raw += bytes;
    }
}

#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
static void swap_words(uint16_t *words, size_t count)
{
    for (size_t i = 0; i < count; i++)
        words[i] = (uint16_t)(words[i] << 8 | words[i] >> 8);
}
#else
static void swap_words(uint16_t *words, size_t count)
{
    (void)words;
    (void)count;
}
#endif

// Which words occur, as bits; 0 always does and has none.
static void find_words(weft_piz *piz, size_t count)
{
    memset(piz->occurs, 0, sizeof piz->occurs);
    for (size_t i = 0; i < count; i++)
        piz->occurs[piz->words[i]] = 1;
    piz->occurs[0] = 0;
    for (size_t b = 0; b < BITMAP; b++) {
        piz->bitmap[b] = 0;
        for (int k = 0; k < 8; k++)
            piz->bitmap[b] |= (unsigned char)(piz->occurs[8 * b + (size_t)k] << k);
    }
}

// Numbers the words that occur; returns the largest number.
static size_t number_words(weft_piz *piz, bool back)
{
    size_t next = 0;
    for (size_t w = 0; w < WORDS; w++) {
        if (w > 0 && !(piz->bitmap[w / 8] >> w % 8 & 1))
            continue;
        piz->number[back ? next : w] = (uint16_t)(back ? w : next);
        next++;
    }
    return next - 1;
}

static void replace_words(weft_piz *piz, size_t count)
{
    for (size_t i = 0; i < count; i++)
        piz->words[i] = piz->number[piz->words[i]];
}

static void walk_channels(const weft_piz *piz, int lines, bool small,
                          void (*walk)(const struct weft_word_image *image))
{
    struct weft_word_image image = {
        .words = piz->words, .width = piz->shape->width, .height = (size_t)lines, .small = small};
    for (size_t c = 0; c < piz->shape->channel_count; c++) {
        image.size = piz->shape->words[c];
        walk(&image);
        image.words += image.width * image.height * (size_t)image.size;
    }
}

// ---- blocks -------------------------------------------------------------------------------------

static void store(unsigned char *out, size_t value, int bytes)
{
    for (int i = 0; i < bytes; i++)
        out[i] = (unsigned char)(value >> 8 * i);
}

// From the first byte that is not 0 to the last one, and which these are. Returns its end.
static unsigned char *store_bitmap(const weft_piz *piz, unsigned char *out)
{
    size_t first = 0, last = BITMAP;
    while (first < BITMAP - 1 && !piz->bitmap[first])
        first++;
    while (last > 0 && !piz->bitmap[last - 1])
        last--;
    store(out, first, 2);
    store(out + 2, last ? last - 1 : 0, 2);
    const size_t bytes = last > first ? last - first : 0;
    memcpy(out + 4, piz->bitmap + first, bytes);
    return out + 4 + bytes;
}

size_t weft_piz_pack(weft_piz *piz, const void *raw, int lines, unsigned char *out)
{
    const size_t bytes = weft_chunk_line_bytes(piz->shape) * (size_t)lines, count = bytes / 2;
    copy_lines(piz, (unsigned char *)(uintptr_t)raw, lines, false);
    swap_words(piz->words, count);
    find_words(piz, count);
    const size_t largest = number_words(piz, false);
    replace_words(piz, count);
    walk_channels(piz, lines, largest < SMALL, weft_wavelet_split);
    unsigned char *at = store_bitmap(piz, out);
    const size_t used = (size_t)(at + 4 - out);
    const size_t packed =
        weft_huffman_pack(piz->huffman, piz->words, count, at + 4, bytes + WEFT_PIZ_SLACK - used);
    store(at, packed, 4);
    return packed && used + packed < bytes ? used + packed : 0;
}

static size_t load(const unsigned char *at, int bytes)
{
    size_t value = 0;
    for (int i = 0; i < bytes; i++)
        value |= (size_t)at[i] << 8 * i;
    return value;
}

// Returns the bytes taken, 0 where they are no bitmap.
static size_t load_bitmap(weft_piz *piz, const unsigned char *packed, size_t size)
{
    if (size < 4)
        return 0;
    const size_t first = load(packed, 2), last = load(packed + 2, 2);
    const size_t bytes = last >= first ? last - first + 1 : 0;
    if (last >= BITMAP || bytes > size - 4)
        return 0;
    memset(piz->bitmap, 0, sizeof piz->bitmap);
    memcpy(piz->bitmap + (bytes ? first : 0), packed + 4, bytes);
    return 4 + bytes;
}

bool weft_piz_unpack(weft_piz *piz, const unsigned char *packed, size_t size, int lines, void *raw)
{
    const size_t count = weft_chunk_line_bytes(piz->shape) * (size_t)lines / 2;
    const size_t used = load_bitmap(piz, packed, size);
    if (!used || size - used < 4)
        return false;
    const size_t coded = load(packed + used, 4);
    if (coded > size - used - 4 ||
        !weft_huffman_unpack(piz->huffman, packed + used + 4, coded, piz->words, count))
        return false;
    memset(piz->number, 0, sizeof piz->number);
    const size_t largest = number_words(piz, true);
    walk_channels(piz, lines, largest < SMALL, weft_wavelet_join);
    replace_words(piz, count);
    swap_words(piz->words, count);
    copy_lines(piz, raw, lines, true);
    return true;
}
