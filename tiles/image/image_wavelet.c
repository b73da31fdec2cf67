// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/image/image_wavelet.h"

#define INLINE static inline __attribute__((always_inline))

// Mean and difference. Of words below 2^14 as they are; of any, modulo 2^16 and from the middle.
static inline void split_small(int a, int b, uint16_t *mean, uint16_t *difference)
{
    *mean = (uint16_t)((a + b) >> 1);
    *difference = (uint16_t)(a - b);
}

static inline void split_any(unsigned a, unsigned b, uint16_t *mean, uint16_t *difference)
{
    const unsigned moved = a ^ 0x8000;
    *mean = (uint16_t)((moved + b) >> 1 ^ (moved < b ? 0x8000 : 0));
    *difference = (uint16_t)(moved - b);
}

static inline void join_small(int mean, int difference, uint16_t *a, uint16_t *b)
{
    const int first = mean + (difference & 1) + (difference >> 1);
    *a = (uint16_t)first;
    *b = (uint16_t)(first - difference);
}

static inline void join_any(unsigned mean, unsigned difference, uint16_t *a, uint16_t *b)
{
    const unsigned second = mean - (difference >> 1);
    *b = (uint16_t)second;
    *a = (uint16_t)((difference + second) ^ 0x8000);
}

INLINE void split(bool small, uint16_t a, uint16_t b, uint16_t *mean, uint16_t *difference)
{
    if (small)
        split_small((int16_t)a, (int16_t)b, mean, difference);
    else
        split_any(a, b, mean, difference);
}

INLINE void join(bool small, uint16_t mean, uint16_t difference, uint16_t *a, uint16_t *b)
{
    if (small)
        join_small((int16_t)mean, (int16_t)difference, a, b);
    else
        join_any(mean, difference, a, b);
}

// Of four words: p[0], p[x], p[y] and p[x + y].
INLINE void split_four(bool small, uint16_t *p, size_t x, size_t y)
{
    uint16_t mean[2], difference[2];
    split(small, p[0], p[x], &mean[0], &difference[0]);
    split(small, p[y], p[x + y], &mean[1], &difference[1]);
    split(small, mean[0], mean[1], &p[0], &p[y]);
    split(small, difference[0], difference[1], &p[x], &p[x + y]);
}

INLINE void join_four(bool small, uint16_t *p, size_t x, size_t y)
{
    uint16_t mean[2], difference[2];
    join(small, p[0], p[y], &mean[0], &mean[1]);
    join(small, p[x], p[x + y], &difference[0], &difference[1]);
    join(small, mean[0], difference[0], &p[0], &p[x]);
    join(small, mean[1], difference[1], &p[y], &p[x + y]);
}

// ---- a level ------------------------------------------------------------------------------------

// Words that are p values apart. What has no neighbour in one direction is split in the other.
struct level {
    uint16_t *words;
    size_t p, step, line; // from a word to its neighbours, in words
    size_t pairs, rows;   // of values in a line, of lines
    bool odd_column, odd_row;
};

static struct level level_of(const struct weft_word_image *image, size_t p)
{
    const size_t size = (size_t)image->size;
    return (struct level){
        .words = image->words,
        .p = p,
        .step = size * p,
        .line = size * image->width * p,
        .pairs = image->width / (2 * p),
        .rows = image->height / (2 * p),
        .odd_column = image->width & p,
        .odd_row = image->height & p,
    };
}

// Two lines of single words next to each other, four words in two times 32 bits: what compilers
// make vectors of.
INLINE void walk_singles(bool joins, bool small, uint16_t *row, const struct level *l)
{
    uint16_t *restrict upper = row, *restrict lower = row + l->line;
    for (size_t i = 0; i < l->pairs; i++) {
        uint16_t p[4] = {upper[2 * i], upper[2 * i + 1], lower[2 * i], lower[2 * i + 1]};
        if (joins)
            join_four(small, p, 1, 2);
        else
            split_four(small, p, 1, 2);
        upper[2 * i] = p[0];
        upper[2 * i + 1] = p[1];
        lower[2 * i] = p[2];
        lower[2 * i + 1] = p[3];
    }
}

// Likewise of values of two words.
INLINE void walk_doubles(bool joins, bool small, uint16_t *row, const struct level *l)
{
    uint16_t *restrict upper = row, *restrict lower = row + l->line;
    for (size_t i = 0; i < l->pairs; i++) {
        for (size_t w = 0; w < 2; w++) {
            const size_t at = 4 * i + w;
            uint16_t p[4] = {upper[at], upper[at + 2], lower[at], lower[at + 2]};
            if (joins)
                join_four(small, p, 1, 2);
            else
                split_four(small, p, 1, 2);
            upper[at] = p[0];
            upper[at + 2] = p[1];
            lower[at] = p[2];
            lower[at + 2] = p[3];
        }
    }
}

INLINE void walk_far(bool joins, bool small, uint16_t *row, const struct level *l, size_t size)
{
    for (size_t i = 0; i < l->pairs; i++) {
        for (size_t w = 0; w < size; w++) {
            if (joins)
                join_four(small, row + 2 * l->step * i + w, l->step, l->line);
            else
                split_four(small, row + 2 * l->step * i + w, l->step, l->line);
        }
    }
}

INLINE void walk_two(bool joins, bool small, uint16_t *at, size_t step, size_t size)
{
    for (size_t w = 0; w < size; w++) {
        if (joins)
            join(small, at[w], at[w + step], &at[w], &at[w + step]);
        else
            split(small, at[w], at[w + step], &at[w], &at[w + step]);
    }
}

INLINE void walk_level(bool joins, bool small, size_t size, const struct level *l)
{
    uint16_t *row = l->words;
    for (size_t k = 0; k < l->rows; k++, row += 2 * l->line) {
        if (l->p == 1 && size == 1)
            walk_singles(joins, small, row, l);
        else if (l->p == 1)
            walk_doubles(joins, small, row, l);
        else
            walk_far(joins, small, row, l, size);
        if (l->odd_column)
            walk_two(joins, small, row + 2 * l->step * l->pairs, l->line, size);
    }
    for (size_t i = 0; l->odd_row && i < l->pairs; i++)
        walk_two(joins, small, row + 2 * l->step * i, l->step, size);
}

// Each kind has its own code.
INLINE void walk_kind(bool joins, const struct weft_word_image *image, size_t p)
{
    const struct level l = level_of(image, p);
    if (image->small && image->size == 1)
        walk_level(joins, true, 1, &l);
    else if (image->small)
        walk_level(joins, true, 2, &l);
    else if (image->size == 1)
        walk_level(joins, false, 1, &l);
    else
        walk_level(joins, false, 2, &l);
}

void weft_wavelet_split(const struct weft_word_image *image)
{
    for (size_t p = 1; 2 * p <= image->width && 2 * p <= image->height; p *= 2)
        walk_kind(false, image, p);
}

void weft_wavelet_join(const struct weft_word_image *image)
{
    size_t p = 1;
    while (2 * p <= image->width && 2 * p <= image->height)
        p *= 2;
    for (p /= 2; p > 0; p /= 2)
        walk_kind(true, image, p);
}
