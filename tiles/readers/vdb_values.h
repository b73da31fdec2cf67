// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/vdb_values.h - the values of one node of a VDB tree: of which of them a file holds
// any, and how those are packed.
#ifndef WEFT_TILES_READERS_VDB_VALUES_H
#define WEFT_TILES_READERS_VDB_VALUES_H

#include <type_traits>
#include <vector>

#include "filter/half.h"
#include "tiles/readers/vdb_bytes.h"

namespace weft
{

enum Compression : uint32_t {
    COMPRESS_ZIP = 1,         // chunks are packed by zlib
    COMPRESS_ACTIVE_MASK = 2, // inactive values are told by a mask and up to two values
    COMPRESS_BLOSC = 4,       // chunks are packed by Blosc, whatever the first bit says
};

// How a grid's values are stored.
struct Coding {
    uint32_t compression; // bits of enum Compression
    bool half;            // floats and doubles are stored as halves; false for other types
};

// What stands in front of the chunk of values in a node: which of OpenVDB's ways it is.
enum NodeKind : uint8_t {
    NODE_BACKGROUND,       // inactive values are the background
    NODE_MINUS_BACKGROUND, // or what it negates to
    NODE_ONE_VALUE,        // or a value that follows
    NODE_MASK_BACKGROUND,  // a mask tells those that are the background from its negative
    NODE_MASK_ONE_VALUE,   // from a value that follows
    NODE_MASK_TWO_VALUES,  // two values that follow from each other
    NODE_ALL_VALUES,       // all are in the chunk
};

inline bool has_mask(NodeKind kind)
{
    return kind >= NODE_MASK_BACKGROUND && kind <= NODE_MASK_TWO_VALUES;
}

inline uint32_t inactive_values(NodeKind kind)
{
    return kind == NODE_MASK_TWO_VALUES                            ? 2
           : kind == NODE_ONE_VALUE || kind == NODE_MASK_ONE_VALUE ? 1
                                                                   : 0;
}

// Throws Failure where there is no such kind.
NodeKind check_kind(unsigned char kind);

// Masks are stored as bits, the lowest of a byte first.
inline bool bit_at(const unsigned char *mask, uint32_t n)
{
    return mask[n >> 3] >> (n & 7) & 1;
}
uint32_t count_bits(const unsigned char *mask, uint32_t bits);

// The packed bytes of a chunk that unpacks to `bytes`; skips it. Throws Failure where its length
// cannot be right.
void skip_chunk(Cursor &cursor, const Coding &coding, uint64_t bytes);
void read_chunk(Cursor &cursor, const Coding &coding, void *out, uint64_t bytes);

// Unpacks what Blosc packed. Throws Failure where that is not so many bytes.
void unpack_blosc(const unsigned char *data, uint64_t length, void *out, uint64_t bytes);

// Bytes of one value as stored.
template <class Value> uint32_t stored_bytes(const Coding &coding)
{
    return coding.half ? 2 : sizeof(Value);
}

// How many of a node's `count` values its chunk has.
inline uint32_t count_stored(const Coding &coding, NodeKind kind, const unsigned char *active,
                             uint32_t count)
{
    const bool some = coding.compression & COMPRESS_ACTIVE_MASK && kind != NODE_ALL_VALUES;
    return some ? count_bits(active, count) : count;
}

// OpenVDB leaves out a chunk of no halves, and no other.
inline bool has_chunk(const Coding &coding, uint32_t stored)
{
    return stored || !coding.half;
}

template <class Value> Value negated(Value value)
{
    if constexpr (std::is_same_v<Value, bool>)
        return !value;
    else if constexpr (std::is_integral_v<Value>)
        return static_cast<Value>(0u - static_cast<std::make_unsigned_t<Value>>(value));
    else
        return -value;
}

template <class Value> Value take_value(Cursor &cursor)
{
    if constexpr (std::is_same_v<Value, bool>)
        return cursor.get<unsigned char>() != 0;
    else
        return cursor.get<Value>();
}

// Reads `count` values; `buffer` is kept from node to node.
template <class Value>
void read_stored(Cursor &cursor, const Coding &coding, uint32_t count,
                 std::vector<unsigned char> &buffer, Value *out)
{
    const uint32_t size = stored_bytes<Value>(coding);
    if (size == sizeof(Value) && !std::is_same_v<Value, bool>) {
        read_chunk(cursor, coding, out, static_cast<uint64_t>(count) * size);
        return;
    }
    buffer.resize(static_cast<size_t>(count) * size);
    read_chunk(cursor, coding, buffer.data(), buffer.size());
    for (uint32_t i = 0; i < count; i++) {
        if constexpr (std::is_floating_point_v<Value>) {
            uint16_t half;
            memcpy(&half, &buffer[2 * i], sizeof half);
            out[i] = weft_half_to_float(half);
        } else {
            out[i] = buffer[i] != 0;
        }
    }
}

// Reads the `count` values of a node, a multiple of 8, whose active ones `active` tells.
template <class Value>
void read_values(Cursor &cursor, const Coding &coding, Value background,
                 const unsigned char *active, uint32_t count, std::vector<unsigned char> &buffer,
                 Value *out)
{
    const NodeKind kind = check_kind(cursor.get<unsigned char>());
    Value inactive[2] = {kind == NODE_BACKGROUND ? background : negated(background), background};
    for (uint32_t i = 0; i < inactive_values(kind); i++)
        inactive[i] = take_value<Value>(cursor);
    const unsigned char *mask = has_mask(kind) ? cursor.take(count / 8) : nullptr;
    const uint32_t stored = count_stored(coding, kind, active, count);
    // They are spread from the end on: none is overwritten before it is used.
    Value *from = out + (count - stored);
    if (has_chunk(coding, stored))
        read_stored(cursor, coding, stored, buffer, from);
    for (uint32_t i = 0; stored < count && i < count; i++)
        out[i] = bit_at(active, i) ? *from++ : inactive[mask && bit_at(mask, i)];
}

// Bytes between the kind and the chunk.
template <class Value> uint64_t bytes_before_chunk(NodeKind kind, uint32_t count)
{
    return inactive_values(kind) * sizeof(Value) + (has_mask(kind) ? count / 8 : 0);
}

// The same for values that nobody wants.
template <class Value>
void skip_values(Cursor &cursor, const Coding &coding, const unsigned char *active, uint32_t count)
{
    const NodeKind kind = check_kind(cursor.get<unsigned char>());
    cursor.skip(bytes_before_chunk<Value>(kind, count));
    const uint32_t stored = count_stored(coding, kind, active, count);
    if (has_chunk(coding, stored))
        skip_chunk(cursor, coding, static_cast<uint64_t>(stored) * stored_bytes<Value>(coding));
}

} // namespace weft

#endif
