// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/image_piz.h"

#include <stdlib.h>
#include <string.h>

enum {
    VALUES = 1 << 16,
    BITMAP_BYTES = VALUES / 8,
    SYMBOLS = VALUES + 1, // and one for runs
    LONGEST_CODE = 58,
    LONGEST_RUN = 255,
};

struct node {
    uint64_t frequency;
    uint32_t symbol; // of a leaf
    uint32_t parent; // its place in the list
};

struct weft_piz {
    struct weft_chunk_shape shape;
    size_t line_words;
    uint16_t *words;
    unsigned char bitmap[BITMAP_BYTES];
    uint16_t number[VALUES]; // of each value that occurs
    uint64_t frequency[SYMBOLS], code[SYMBOLS];
    unsigned char length[SYMBOLS]; // of the code, in bits; 0: the symbol does not occur
    struct node node[2 * SYMBOLS]; // leaves by frequency, then inner ones
};

weft_piz *weft_piz_create(const struct weft_chunk_shape *shape, int lines)
{
    weft_piz *p = calloc(1, sizeof *p);
    if (!p)
        return NULL;
    p->shape = *shape;
    for (size_t c = 0; c < shape->channel_count; c++)
        p->line_words += shape->words[c] * shape->width;
    p->words = malloc(p->line_words * (size_t)lines * sizeof *p->words);
    if (!p->words)
        weft_piz_destroy(&p);
    return p;
}

void weft_piz_destroy(weft_piz **piz)
{
    if (!*piz)
        return;
    free((*piz)->words);
    free(*piz);
    *piz = NULL;
}

// ---- words --------------------------------------------------------------------------------------

// All lines of a channel follow each other.
static void gather(weft_piz *p, const unsigned char *raw, size_t lines)
{
    uint16_t *out = p->words;
    size_t first = 0;
    for (size_t c = 0; c < p->shape.channel_count; c++) {
        const size_t count = p->shape.words[c] * p->shape.width;
        for (size_t y = 0; y < lines; y++) {
            const unsigned char *at = raw + 2 * (y * p->line_words + first);
            for (size_t i = 0; i < count; i++)
                *out++ = (uint16_t)(at[2 * i] | at[2 * i + 1] << 8);
        }
        first += count;
    }
}

// Numbers the values that occur, and 0, from 0 on. Returns the largest number.
static unsigned renumber(weft_piz *p, size_t count)
{
    unsigned next = 0;
    memset(p->bitmap, 0, sizeof p->bitmap);
    for (size_t i = 0; i < count; i++)
        p->bitmap[p->words[i] >> 3] |= (unsigned char)(1u << (p->words[i] & 7));
    p->bitmap[0] &= 0xfe; // 0 goes without saying
    for (unsigned v = 0; v < VALUES; v++)
        if (v == 0 || p->bitmap[v >> 3] & 1u << (v & 7))
            p->number[v] = (uint16_t)next++;
    for (size_t i = 0; i < count; i++)
        p->words[i] = p->number[p->words[i]];
    return next - 1;
}

// ---- wavelet ------------------------------------------------------------------------------------

// Mean and difference. small: both fit in 15 bits and a sign; otherwise modulo 2^16.
static void haar(bool small, uint16_t *a, uint16_t *b)
{
    if (small) {
        const int x = (int16_t)*a, y = (int16_t)*b;
        *a = (uint16_t)((x + y) >> 1);
        *b = (uint16_t)(x - y);
        return;
    }
    const int x = (*a + 0x8000) & 0xffff, difference = x - *b;
    int mean = (x + *b) >> 1;
    if (difference < 0)
        mean = (mean + 0x8000) & 0xffff;
    *a = (uint16_t)mean;
    *b = (uint16_t)(difference & 0xffff);
}

// Of one pair of lines at distance p, step apart along them; the last column may have no partner.
static void transform_rows(bool small, uint16_t *row, size_t width, size_t step, size_t stride,
                           size_t p)
{
    const size_t right = p * step, below = p * stride;
    size_t x = 0;
    for (; x + 2 * p <= width; x += 2 * p) {
        uint16_t *at = row + x * step;
        haar(small, at, at + right);
        haar(small, at + below, at + below + right);
        haar(small, at, at + below);
        haar(small, at + right, at + below + right);
    }
    if (width & p)
        haar(small, row + x * step, row + x * step + below);
}

static void transform(uint16_t *plane, size_t width, size_t height, size_t step, unsigned largest)
{
    const bool small = largest < 1 << 14;
    const size_t stride = width * step, least = width < height ? width : height;
    for (size_t p = 1; 2 * p <= least; p *= 2) {
        size_t y = 0;
        for (; y + 2 * p <= height; y += 2 * p)
            transform_rows(small, plane + y * stride, width, step, stride, p);
        for (size_t x = 0; height & p && x + 2 * p <= width; x += 2 * p)
            haar(small, plane + y * stride + x * step, plane + y * stride + (x + p) * step);
    }
}

static void transform_channels(weft_piz *p, size_t lines, unsigned largest)
{
    uint16_t *plane = p->words;
    for (size_t c = 0; c < p->shape.channel_count; c++) {
        const size_t step = p->shape.words[c];
        for (size_t w = 0; w < step; w++)
            transform(plane + w, p->shape.width, lines, step, largest);
        plane += step * p->shape.width * lines;
    }
}

// ---- bits ---------------------------------------------------------------------------------------

struct bits {
    unsigned char *out;
    size_t used, room;
    uint64_t pending; // the last `count` bits
    int count;
    bool full;
};

static void put_byte(struct bits *b, unsigned value)
{
    if (b->used < b->room)
        b->out[b->used++] = (unsigned char)value;
    else
        b->full = true;
}

static void put_bits(struct bits *b, int count, uint64_t value)
{
    b->pending = b->pending << count | value;
    b->count += count;
    while (b->count >= 8) {
        b->count -= 8;
        put_byte(b, (unsigned)(b->pending >> b->count) & 0xff);
    }
}

// Returns the bits of the byte that was not whole.
static int put_rest(struct bits *b)
{
    const int rest = b->count;
    if (rest)
        put_byte(b, (unsigned)(b->pending << (8 - rest)) & 0xff);
    b->count = 0;
    return rest;
}

static void put_number(struct bits *b, uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++)
        put_byte(b, (unsigned)(value >> 8 * i) & 0xff);
}

static void set_number(struct bits *b, size_t at, uint32_t value)
{
    for (size_t i = 0; i < 4 && at + i < b->room; i++)
        b->out[at + i] = (unsigned char)(value >> 8 * i);
}

// ---- Huffman code -------------------------------------------------------------------------------

static int compare_nodes(const void *a, const void *b)
{
    const struct node *p = a, *q = b;
    if (p->frequency != q->frequency)
        return p->frequency < q->frequency ? -1 : 1;
    return p->symbol < q->symbol ? -1 : p->symbol > q->symbol;
}

// Of leaves that are sorted, and inner nodes that are made in ascending order, the smaller one.
static size_t take_smallest(const weft_piz *p, size_t *leaf, size_t leaves, size_t *inner,
                            size_t made)
{
    if (*inner == made || (*leaf < leaves && p->node[*leaf].frequency <= p->node[*inner].frequency))
        return (*leaf)++;
    return (*inner)++;
}

// Depths in the tree of least total length; there are at least two leaves. Deeper than 58 would
// take more symbols than a block has bytes: frequencies grow as Fibonacci's numbers.
static void set_lengths(weft_piz *p, size_t leaves)
{
    size_t leaf = 0, inner = leaves, made = leaves;
    qsort(p->node, leaves, sizeof *p->node, compare_nodes);
    for (; made < 2 * leaves - 1; made++) {
        uint64_t sum = 0;
        for (int i = 0; i < 2; i++) {
            const size_t child = take_smallest(p, &leaf, leaves, &inner, made);
            p->node[child].parent = (uint32_t)made;
            sum += p->node[child].frequency;
        }
        p->node[made] = (struct node){.frequency = sum};
    }
    // From the root down; an inner node's frequency is of no more use and makes room for its depth.
    p->node[made - 1].frequency = 0;
    for (size_t i = made - 1; i-- > 0;) {
        p->node[i].frequency = p->node[p->node[i].parent].frequency + 1;
        if (i < leaves)
            p->length[p->node[i].symbol] = (unsigned char)p->node[i].frequency;
    }
}

// Longer codes are numerically smaller; of one length they ascend with the symbols.
static void set_codes(weft_piz *p)
{
    uint64_t first[LONGEST_CODE + 1] = {0}, code = 0;
    for (size_t s = 0; s < SYMBOLS; s++)
        first[p->length[s]] += p->length[s] != 0;
    for (int l = LONGEST_CODE; l > 0; l--) {
        const uint64_t next = (code + first[l]) >> 1;
        first[l] = code;
        code = next;
    }
    for (size_t s = 0; s < SYMBOLS; s++)
        if (p->length[s])
            p->code[s] = first[p->length[s]]++;
}

// The symbols that occur are from *low to *high, which stands for runs.
static void make_code(weft_piz *p, size_t count, size_t *low, size_t *high)
{
    size_t leaves = 0;
    memset(p->frequency, 0, sizeof p->frequency);
    memset(p->length, 0, sizeof p->length);
    for (size_t i = 0; i < count; i++)
        p->frequency[p->words[i]]++;
    *low = 0;
    while (!p->frequency[*low])
        (*low)++;
    *high = VALUES;
    while (!p->frequency[*high - 1])
        (*high)--;
    p->frequency[*high] = 1;
    for (size_t s = *low; s <= *high; s++)
        if (p->frequency[s])
            p->node[leaves++] = (struct node){.frequency = p->frequency[s], .symbol = (uint32_t)s};
    set_lengths(p, leaves);
    set_codes(p);
}

// Six bits a length; 59 to 62 are 2 to 5 zeros, 63 and eight more bits are 6 to 261.
static void put_lengths(const weft_piz *p, struct bits *b, size_t low, size_t high)
{
    enum { SHORT_RUN = 59, LONG_RUN = 63, SHORTEST_LONG = 2 + LONG_RUN - SHORT_RUN };
    for (size_t s = low; s <= high; s++) {
        size_t zeros = 0;
        while (zeros < SHORTEST_LONG + 255 && s + zeros <= high && !p->length[s + zeros])
            zeros++;
        if (zeros >= SHORTEST_LONG) {
            put_bits(b, 6, LONG_RUN);
            put_bits(b, 8, zeros - SHORTEST_LONG);
        } else if (zeros >= 2) {
            put_bits(b, 6, SHORT_RUN + zeros - 2);
        } else {
            put_bits(b, 6, p->length[s]);
        }
        s += zeros >= 2 ? zeros - 1 : 0;
    }
}

// A word and how often it comes again, as a run where that is shorter.
static void put_run(const weft_piz *p, struct bits *b, size_t word, int again, size_t run)
{
    if (p->length[word] + p->length[run] + 8 < p->length[word] * again) {
        put_bits(b, p->length[word], p->code[word]);
        put_bits(b, p->length[run], p->code[run]);
        put_bits(b, 8, (uint64_t)again);
        return;
    }
    for (int i = 0; i <= again && !b->full; i++)
        put_bits(b, p->length[word], p->code[word]);
}

// Returns the bits.
static uint64_t put_words(const weft_piz *p, struct bits *b, size_t count, size_t run)
{
    const size_t before = b->used;
    int again = 0;
    for (size_t i = 1; i < count && !b->full; i++) {
        if (p->words[i] == p->words[i - 1] && again < LONGEST_RUN) {
            again++;
            continue;
        }
        put_run(p, b, p->words[i - 1], again, run);
        again = 0;
    }
    put_run(p, b, p->words[count - 1], again, run);
    const uint64_t whole = 8 * (uint64_t)(b->used - before);
    return whole + (uint64_t)put_rest(b);
}

static void put_code(weft_piz *p, struct bits *b, size_t count)
{
    size_t low, high;
    const size_t start = b->used; // length, first, last, table's bytes, bits, 0
    make_code(p, count, &low, &high);
    for (int i = 0; i < 6; i++)
        put_number(b, 0, 4);
    put_lengths(p, b, low, high);
    put_rest(b);
    const size_t table = b->used - start - 24;
    const uint64_t bits = put_words(p, b, count, high);
    b->full = b->full || bits > INT32_MAX; // the format's limit
    set_number(b, start, (uint32_t)(b->used - start - 4));
    set_number(b, start + 4, (uint32_t)low);
    set_number(b, start + 8, (uint32_t)high);
    set_number(b, start + 12, (uint32_t)table);
    set_number(b, start + 16, (uint32_t)bits);
}

// ---- all of it ----------------------------------------------------------------------------------

static void put_bitmap(const weft_piz *p, struct bits *b)
{
    size_t first = 0, last = BITMAP_BYTES - 1;
    while (first < BITMAP_BYTES - 1 && !p->bitmap[first])
        first++;
    while (last > 0 && !p->bitmap[last])
        last--;
    put_number(b, first, 2);
    put_number(b, last, 2);
    for (size_t i = first; i <= last; i++)
        put_byte(b, p->bitmap[i]);
}

size_t weft_piz_pack(weft_piz *p, const void *raw, size_t size, unsigned char *out, size_t room)
{
    struct bits b = {.out = out, .room = room};
    const size_t lines = size / (2 * p->line_words), count = lines * p->line_words;
    gather(p, raw, lines);
    const unsigned largest = renumber(p, count);
    put_bitmap(p, &b);
    transform_channels(p, lines, largest);
    put_code(p, &b, count);
    return b.full ? 0 : b.used;
}
