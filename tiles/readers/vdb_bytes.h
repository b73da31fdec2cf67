// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/vdb_bytes.h - the bytes of a VDB file, and how the reader of VDB files fails.
#ifndef WEFT_TILES_READERS_VDB_BYTES_H
#define WEFT_TILES_READERS_VDB_BYTES_H

#include <cstring>
#include <string>

#include "filter/base.h"

namespace weft
{

// What every function of the VDB reader throws; the message goes to the caller's log.
struct Failure {
    weft_result result;
    std::string text;
};
[[noreturn]] void fail(weft_result result, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

// As printf's %llu wants it.
inline unsigned long long wide(uint64_t value)
{
    return value;
}

// A whole file, mapped for reading until the end of its life. Another program that cuts the file
// short meanwhile ends this one by SIGBUS, which the caller of the reader tells.
class Mapping
{
  public:
    // memory_bytes is told where the file does not fit into it. Throws Failure.
    Mapping(int fd, uint64_t memory_bytes);
    ~Mapping();
    Mapping(const Mapping &) = delete;
    Mapping &operator=(const Mapping &) = delete;

    const unsigned char *data() const
    {
        return data_;
    }
    uint64_t size() const
    {
        return size_;
    }

  private:
    const unsigned char *data_;
    uint64_t size_;
};

// Reads bytes from one place to another. What would lead beyond the end throws Failure
// before anything is read or memory asked for.
class Cursor
{
  public:
    // at <= end; `data` has `end` bytes.
    Cursor(const unsigned char *data, uint64_t at, uint64_t end) : data_(data), at_(at), end_(end)
    {
    }
    Cursor(const Mapping &file, uint64_t at, uint64_t end) : Cursor(file.data(), at, end)
    {
    }

    uint64_t at() const
    {
        return at_;
    }
    uint64_t end() const
    {
        return end_;
    }
    // at <= end().
    void move_to(uint64_t at)
    {
        at_ = at;
    }

    void skip(uint64_t bytes)
    {
        if (bytes > end_ - at_)
            fail(WEFT_ERR_FORMAT, "%llu bytes are missing at %llu, where it ends at %llu",
                 wide(bytes), wide(at_), wide(end_));
        at_ += bytes;
    }

    // The bytes themselves, at no particular alignment.
    const unsigned char *take(uint64_t bytes)
    {
        const unsigned char *from = data_ + at_;
        skip(bytes);
        return from;
    }

    // Bytes that were skipped or taken before.
    const unsigned char *bytes_at(uint64_t at) const
    {
        return data_ + at;
    }

    void get(void *out, uint64_t bytes)
    {
        memcpy(out, take(bytes), bytes);
    }

    template <class T> T get()
    {
        T value;
        get(&value, sizeof value);
        return value;
    }

    // Its length is in front of it.
    std::string get_string()
    {
        const uint32_t length = get<uint32_t>();
        return std::string(reinterpret_cast<const char *>(take(length)), length);
    }
    void skip_string()
    {
        skip(get<uint32_t>());
    }

  private:
    const unsigned char *data_;
    uint64_t at_, end_;
};

} // namespace weft

#endif
