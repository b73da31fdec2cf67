// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/image/image_huffman.h"

#include <stdlib.h>
#include <string.h>

enum {
    SYMBOLS = 65537, // all words, and the repetition beyond the largest
    HEADER = 20,
    LONGEST = 58,       // bits of a code; lengths beyond stand for runs of zeros in the table
    LONGEST_FOUND = 56, // of codes that occur: longer ones take more than 2^38 words
    SHORT_RUN = 59,     // 2 symbols without a code; up to 62: 5
    LONG_RUN = 63,      // 6 and more: 8 bits follow
    LONG_RUN_LEAST = 6,
    LONG_RUN_MOST = LONG_RUN_LEAST + 255,
    MOST_REPEATED = 255,
    LOOK = 12, // bits of codes that are found in one step
    DIGITS = 11,
};

struct weft_huffman {
    uint32_t count[SYMBOLS];
    unsigned char length[SYMBOLS];
    uint64_t code[SYMBOLS]; // as the highest bits, and the length as the lowest 6
    // Of the tree: leaves in the order of their counts, then inner nodes in the order of theirs.
    uint64_t sorted[2][SYMBOLS]; // count << 32 | symbol
    uint64_t weight[SYMBOLS];
    uint32_t parent[2 * SYMBOLS];
    // Of unpacking: symbols by code, and where each length begins.
    uint32_t symbol[SYMBOLS];
    uint64_t first[LONGEST + 2]; // code, as the highest of 64 bits
    uint32_t place[LONGEST + 2]; // in symbol
    uint32_t look[1 << LOOK];    // symbol << 8 | length; 0: a longer code, or none
};

weft_huffman *weft_huffman_create(void)
{
    return malloc(sizeof(struct weft_huffman));
}

void weft_huffman_destroy(weft_huffman **huffman)
{
    free(*huffman);
    *huffman = NULL;
}

// ---- codes --------------------------------------------------------------------------------------

// Sorts by counts. Least significant digits first, so that equal counts stay in order.
static const uint64_t *sort(weft_huffman *h, size_t count, uint32_t largest)
{
    uint64_t *from = h->sorted[0], *to = h->sorted[1];
    for (int shift = 32; shift < 64 && largest >> (shift - 32); shift += DIGITS) {
        uint32_t place[1 << DIGITS] = {0}, sum = 0;
        for (size_t i = 0; i < count; i++)
            place[from[i] >> shift & ((1 << DIGITS) - 1)]++;
        for (size_t d = 0; d < 1 << DIGITS; d++) {
            const uint32_t size = place[d];
            place[d] = sum;
            sum += size;
        }
        for (size_t i = 0; i < count; i++)
            to[place[from[i] >> shift & ((1 << DIGITS) - 1)]++] = from[i];
        uint64_t *const other = from;
        from = to;
        to = other;
    }
    return from;
}

// The lighter of the next leaf and the next inner node; `made` inner nodes are there.
static uint64_t take_lightest(const weft_huffman *h, const uint64_t *leaves, size_t count,
                              size_t made, size_t at[2], size_t *node)
{
    if (at[0] < count && (at[1] == made || leaves[at[0]] >> 32 <= h->weight[at[1]])) {
        *node = at[0];
        return leaves[at[0]++] >> 32;
    }
    *node = count + at[1];
    return h->weight[at[1]++];
}

// Lengths of the codes of all symbols that count. The tree: van Leeuwen, On the construction of
// Huffman trees (ICALP 1976), in two queues. No code is longer than 58 bits, for which counts would
// have to add up to the 60th Fibonacci number.
static void set_lengths(weft_huffman *h, size_t first, size_t last)
{
    size_t count = 0, at[2] = {0, 0};
    uint32_t largest = 0;
    for (size_t s = first; s <= last; s++) {
        h->length[s] = 0;
        if (!h->count[s])
            continue;
        h->sorted[0][count++] = (uint64_t)h->count[s] << 32 | s;
        largest = h->count[s] > largest ? h->count[s] : largest;
    }
    const uint64_t *leaves = sort(h, count, largest);
    for (size_t made = 0; made + 1 < count; made++) {
        size_t a, b;
        h->weight[made] = take_lightest(h, leaves, count, made, at, &a);
        h->weight[made] += take_lightest(h, leaves, count, made, at, &b);
        h->parent[a] = h->parent[b] = (uint32_t)(count + made);
    }
    // Each node's place in the tree takes its parent's: depths take the place of weights.
    h->weight[count - 2] = 0;
    for (size_t node = 2 * count - 2; node-- > 0;) {
        const uint64_t depth = h->weight[h->parent[node] - count] + 1;
        if (node >= count)
            h->weight[node - count] = depth;
        else
            h->length[(uint32_t)leaves[node]] = (unsigned char)depth;
    }
}

// How many codes there are of each length, and the first of each. Returns whether they can be: none
// is beyond what its bits hold.
static bool set_first(const weft_huffman *h, size_t first, size_t last, uint64_t count[LONGEST + 1],
                      uint64_t code[LONGEST + 1])
{
    uint64_t next = 0;
    memset(count, 0, (LONGEST + 1) * sizeof *count);
    for (size_t s = first; s <= last; s++)
        count[h->length[s]]++;
    for (int length = LONGEST; length > 0; length--) {
        code[length] = next;
        if (count[length] && next + count[length] > UINT64_C(1) << length)
            return false;
        next = (next + count[length]) >> 1;
    }
    return true;
}

static void set_codes(weft_huffman *h, size_t first, size_t last)
{
    uint64_t count[LONGEST + 1], code[LONGEST + 1];
    set_first(h, first, last, count, code);
    for (size_t s = first; s <= last; s++) {
        const int length = h->length[s];
        if (length)
            h->code[s] = code[length]++ << (64 - length) | (unsigned)length;
    }
}

// ---- packing ------------------------------------------------------------------------------------

struct bits_out {
    unsigned char *at, *end; // eight bytes beyond the end may be written
    uint64_t bits;           // the highest `count` ones wait
    int count;
};

// Adds the highest `count` bits of `value`, whose others are 0.
static inline void add(struct bits_out *out, uint64_t value, int count)
{
    out->bits |= value >> out->count;
    out->count += count;
}

// Leaves fewer than 8 bits waiting, which are stored, too.
static inline void flush(struct bits_out *out)
{
    const uint64_t stored = __builtin_bswap64(out->bits);
    memcpy(out->at, &stored, 8);
    out->at += out->count >> 3;
    out->bits <<= out->count & ~7;
    out->count &= 7;
}

static void put(struct bits_out *out, uint64_t value, int count)
{
    add(out, value << (64 - count), count);
    flush(out);
}

static inline void add_code(struct bits_out *out, uint64_t code)
{
    add(out, code & ~UINT64_C(63), (int)(code & 63));
}

static void put_code(struct bits_out *out, uint64_t code)
{
    add_code(out, code);
    flush(out);
}

// Of `size` symbols without a code.
static void put_gap(struct bits_out *out, size_t size)
{
    while (size >= LONG_RUN_LEAST) {
        const size_t run = size < LONG_RUN_MOST ? size : LONG_RUN_MOST;
        put(out, LONG_RUN, 6);
        put(out, run - LONG_RUN_LEAST, 8);
        size -= run;
    }
    if (size > 1)
        put(out, SHORT_RUN + size - 2, 6);
    else if (size)
        put(out, 0, 6);
}

// Returns false where there may be no room.
static bool put_table(struct bits_out *out, const weft_huffman *h, size_t first, size_t last)
{
    size_t gap = 0;
    for (size_t s = first; s <= last; s++) {
        if (!h->length[s]) {
            gap++;
            continue;
        }
        if (out->end - out->at < (ptrdiff_t)(2 * (gap / 255) + 16))
            return false;
        put_gap(out, gap);
        put(out, h->length[s], 6);
        gap = 0;
    }
    return true;
}

// A word and what repeats it: by its own code, or by the one for repetitions where that is shorter.
static void put_run(struct bits_out *out, uint64_t code, uint64_t repeat, int repeated)
{
    put_code(out, code);
    if ((int)(code & 63) + (int)(repeat & 63) + 8 < (int)(code & 63) * repeated) {
        put_code(out, repeat);
        put(out, (uint64_t)repeated, 8);
        return;
    }
    while (repeated-- > 0)
        put_code(out, code);
}

// Words up to the first that comes twice, in twos while two codes go into 56 bits. Returns how
// many.
static size_t put_single(struct bits_out *out, const weft_huffman *h, const uint16_t *words,
                         size_t count)
{
    struct bits_out bits = *out;
    size_t i = 0;
    while (i + 2 < count && words[i] != words[i + 1] && words[i + 1] != words[i + 2] &&
           bits.at < bits.end) {
        const uint64_t a = h->code[words[i]], b = h->code[words[i + 1]];
        if ((a & 63) + (b & 63) > 56)
            break;
        add_code(&bits, a);
        add_code(&bits, b);
        flush(&bits);
        i += 2;
    }
    *out = bits;
    return i;
}

// A run takes less than MOST_REPEATED codes of 56 bits, or two codes.
static bool put_words(struct bits_out *out, const weft_huffman *h, const uint16_t *words,
                      size_t count, uint64_t repeat)
{
    for (size_t i = 0; i < count;) {
        i += put_single(out, h, words + i, count - i);
        const uint16_t word = words[i++];
        int repeated = 0;
        while (i < count && words[i] == word && repeated < MOST_REPEATED) {
            repeated++;
            i++;
        }
        if (out->end - out->at < 8 * (repeated + 1))
            return false;
        put_run(out, h->code[word], repeat, repeated);
    }
    return true;
}

static void store_number(unsigned char *out, uint64_t value)
{
    for (int i = 0; i < 4; i++)
        out[i] = (unsigned char)(value >> 8 * i);
}

// Ends with a whole byte; returns its bits before.
static uint64_t finish(struct bits_out *out, const unsigned char *from)
{
    const uint64_t bits = (uint64_t)(out->at - from) * 8 + (uint64_t)out->count;
    out->at += out->count > 0; // flush() has stored it
    return bits;
}

size_t weft_huffman_pack(weft_huffman *h, const uint16_t *words, size_t count, unsigned char *out,
                         size_t room)
{
    size_t first = 0, last = SYMBOLS - 1;
    if (room < HEADER + 8)
        return 0;
    memset(h->count, 0, sizeof h->count);
    for (size_t i = 0; i < count; i++)
        h->count[words[i]]++;
    while (!h->count[first])
        first++;
    while (!h->count[last])
        last--;
    h->count[++last] = 1;
    set_lengths(h, first, last);
    set_codes(h, first, last);
    struct bits_out bits = {.at = out + HEADER, .end = out + room - 8};
    if (!put_table(&bits, h, first, last))
        return 0;
    finish(&bits, out);
    unsigned char *const data = bits.at;
    bits = (struct bits_out){.at = data, .end = out + room - 8};
    if (!put_words(&bits, h, words, count, h->code[last]))
        return 0;
    const uint64_t data_bits = finish(&bits, data);
    store_number(out, first);
    store_number(out + 4, last);
    store_number(out + 8, (uint64_t)(data - out - HEADER));
    store_number(out + 12, data_bits);
    store_number(out + 16, 0);
    return data_bits <= INT32_MAX ? (size_t)(bits.at - out) : 0; // readers take it for an int
}

// ---- unpacking ----------------------------------------------------------------------------------

// Bits are zero past the end.
struct bits_in {
    const unsigned char *from, *at, *end;
    uint64_t bits; // the highest `count` ones are there
    int count;
    size_t beyond; // bytes past the end that were made up
};

static inline void fill(struct bits_in *in)
{
    if (in->end - in->at >= 8) {
        uint64_t next;
        memcpy(&next, in->at, 8);
        in->bits |= __builtin_bswap64(next) >> in->count;
        in->at += (63 - in->count) >> 3;
        in->count |= 56;
        return;
    }
    for (; in->count <= 56; in->count += 8) {
        if (in->at < in->end)
            in->bits |= (uint64_t)*in->at++ << (56 - in->count);
        else
            in->beyond++;
    }
}

static inline void drop(struct bits_in *in, int count)
{
    in->bits <<= count;
    in->count -= count;
}

static inline uint64_t get(struct bits_in *in, int count)
{
    if (in->count < count)
        fill(in);
    const uint64_t value = in->bits >> (64 - count);
    drop(in, count);
    return value;
}

// Bits that were taken, be they there or not.
static uint64_t bits_taken(const struct bits_in *in)
{
    return 8 * ((uint64_t)(in->at - in->from) + in->beyond) - (uint64_t)in->count;
}

static bool get_table(struct bits_in *in, weft_huffman *h, size_t first, size_t last)
{
    for (size_t s = first; s <= last;) {
        const uint64_t length = get(in, 6);
        size_t gap = 1;
        if (length == LONG_RUN)
            gap = (size_t)get(in, 8) + LONG_RUN_LEAST;
        else if (length >= SHORT_RUN)
            gap = (size_t)length - SHORT_RUN + 2;
        if (gap > last + 1 - s)
            return false;
        memset(h->length + s, length > LONGEST ? 0 : (int)length, gap);
        s += gap;
    }
    return bits_taken(in) <= 8 * (uint64_t)(in->end - in->from);
}

// Symbols in the order of their codes, longest first, which as the highest of 64 bits grow.
static bool set_symbols(weft_huffman *h, size_t first, size_t last)
{
    uint64_t count[LONGEST + 1], code[LONGEST + 1];
    uint32_t place = 0;
    if (!set_first(h, first, last, count, code))
        return false;
    for (int length = LONGEST; length > 0; length--) {
        h->first[length] = code[length] << (64 - length);
        h->place[length] = place;
        place += (uint32_t)count[length];
    }
    uint32_t next[LONGEST + 1];
    memcpy(next, h->place, sizeof next);
    memset(h->look, 0, sizeof h->look);
    for (size_t s = first; s <= last; s++) {
        const int length = h->length[s];
        if (!length)
            continue;
        const uint64_t at = code[length] + next[length] - h->place[length];
        h->symbol[next[length]++] = (uint32_t)s;
        for (size_t i = 0; length <= LOOK && i < (size_t)1 << (LOOK - length); i++)
            h->look[(at << (LOOK - length)) + i] = (uint32_t)s << 8 | (unsigned)length;
    }
    h->place[0] = place;
    return place > 0;
}

// Of a code that is longer than LOOK bits: of the shortest length whose first code is not beyond
// the bits, since longer codes come first. Returns SYMBOLS where there is none.
static uint32_t find_symbol(const weft_huffman *h, struct bits_in *in)
{
    for (int length = LOOK + 1; length <= LONGEST_FOUND; length++) {
        const uint64_t count = h->place[length - 1] - h->place[length];
        if (!count || h->first[length] > in->bits)
            continue;
        const uint64_t step = (in->bits - h->first[length]) >> (64 - length);
        if (step >= count)
            return SYMBOLS;
        drop(in, length);
        return h->symbol[h->place[length] + step];
    }
    return SYMBOLS;
}

// Returns false where it takes other than `bits` bits.
static bool get_words(struct bits_in *in, const weft_huffman *h, size_t repeat, uint16_t *words,
                      size_t count, uint64_t bits)
{
    for (size_t i = 0; i < count;) {
        fill(in);
        const uint32_t found = h->look[in->bits >> (64 - LOOK)];
        uint32_t symbol = found >> 8;
        if (found)
            drop(in, (int)(found & 255));
        else if ((symbol = find_symbol(h, in)) == SYMBOLS)
            return false;
        if (symbol != repeat) {
            words[i++] = (uint16_t)symbol;
            continue;
        }
        const size_t size = (size_t)get(in, 8);
        if (!i || !size || size > count - i)
            return false;
        for (size_t k = 0; k < size; k++, i++)
            words[i] = words[i - 1];
    }
    return bits_taken(in) == bits;
}

static uint32_t load_number(const unsigned char *at)
{
    return at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

bool weft_huffman_unpack(weft_huffman *h, const unsigned char *packed, size_t size, uint16_t *words,
                         size_t count)
{
    if (size < HEADER)
        return false;
    const size_t first = load_number(packed), last = load_number(packed + 4);
    const size_t table = load_number(packed + 8), bits = load_number(packed + 12);
    if (first > last || last >= SYMBOLS || table > size - HEADER ||
        (bits + 7) / 8 > size - HEADER - table)
        return false;
    const unsigned char *data = packed + HEADER;
    struct bits_in in = {.from = data, .at = data, .end = data + table};
    if (!get_table(&in, h, first, last) || !set_symbols(h, first, last))
        return false;
    data += table;
    in = (struct bits_in){.from = data, .at = data, .end = data + (bits + 7) / 8};
    return get_words(&in, h, last, words, count, bits);
}
