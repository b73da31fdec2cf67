// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/readers/vdb_values.h"

#include <memory>

#include <blosc.h>
#include <libdeflate.h>

namespace weft
{

namespace
{

// Chunks are packed only where that makes them smaller; the slack is for the codecs' own headers.
constexpr uint64_t slack = 1024;

// The bytes that a packed chunk takes; *packed: false where they are the values themselves.
uint64_t take_length(Cursor &cursor, uint64_t bytes, bool *packed)
{
    const int64_t stored = cursor.get<int64_t>();
    *packed = stored > 0;
    const uint64_t length =
        *packed ? static_cast<uint64_t>(stored) : 0 - static_cast<uint64_t>(stored);
    if (*packed ? length > bytes + slack : length != bytes)
        fail(WEFT_ERR_FORMAT, "a chunk of %lld bytes for %llu bytes of values",
             static_cast<long long>(stored), wide(bytes));
    return length;
}

void unzip(const unsigned char *data, uint64_t length, void *out, uint64_t bytes)
{
    static const std::unique_ptr<libdeflate_decompressor, void (*)(libdeflate_decompressor *)>
        decompressor(libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
    if (!decompressor)
        throw std::bad_alloc();
    if (libdeflate_zlib_decompress(decompressor.get(), data, length, out, bytes, nullptr) !=
        LIBDEFLATE_SUCCESS)
        fail(WEFT_ERR_FORMAT, "zlib's data is damaged, or is not of %llu bytes", wide(bytes));
}

} // namespace

void unpack_blosc(const unsigned char *data, uint64_t length, void *out, uint64_t bytes)
{
    size_t unpacked = 0;
    if (blosc_cbuffer_validate(data, length, &unpacked) || unpacked != bytes ||
        blosc_decompress_ctx(data, out, bytes, 1) != static_cast<int>(bytes))
        fail(WEFT_ERR_FORMAT, "Blosc's data is damaged, or is not of %llu bytes", wide(bytes));
}

NodeKind check_kind(unsigned char kind)
{
    if (kind > NODE_ALL_VALUES)
        fail(WEFT_ERR_FORMAT, "a node's values are stored in the unknown way %u", kind);
    return static_cast<NodeKind>(kind);
}

uint32_t count_bits(const unsigned char *mask, uint32_t bits)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < bits / 8; i += 8) {
        uint64_t word;
        memcpy(&word, mask + i, sizeof word);
        count += static_cast<uint32_t>(__builtin_popcountll(word));
    }
    return count;
}

void skip_chunk(Cursor &cursor, const Coding &coding, uint64_t bytes)
{
    bool packed;
    if (coding.compression & (COMPRESS_BLOSC | COMPRESS_ZIP))
        bytes = take_length(cursor, bytes, &packed);
    cursor.skip(bytes);
}

void read_chunk(Cursor &cursor, const Coding &coding, void *out, uint64_t bytes)
{
    bool packed = false;
    uint64_t length = bytes;
    if (coding.compression & (COMPRESS_BLOSC | COMPRESS_ZIP))
        length = take_length(cursor, bytes, &packed);
    const unsigned char *data = cursor.take(length);
    if (!bytes)
        return;
    if (!packed)
        memcpy(out, data, bytes);
    else if (coding.compression & COMPRESS_BLOSC)
        unpack_blosc(data, length, out, bytes);
    else
        unzip(data, length, out, bytes);
}

} // namespace weft
