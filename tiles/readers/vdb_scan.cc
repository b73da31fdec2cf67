// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/readers/vdb_scan.h"

#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <sys/stat.h>
#include <unistd.h>

namespace weft
{

void fail(weft_result result, const char *format, ...)
{
    char text[480];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    throw Failure{result, text};
}

namespace
{

constexpr uint64_t magic = 0x56444220;
constexpr uint32_t oldest_version = 222; // node mask compression, 2012
constexpr uint32_t longest_name = 4096, most_grids = 65536, most_metadata = 1 << 20;

class Cursor
{
  public:
    explicit Cursor(int fd) : fd_(fd)
    {
        struct stat stat;
        if (fstat(fd, &stat) || !S_ISREG(stat.st_mode))
            fail(WEFT_ERR_OPEN, "not a regular file");
        size_ = static_cast<uint64_t>(stat.st_size);
    }

    uint64_t size() const
    {
        return size_;
    }

    void skip(uint64_t bytes)
    {
        if (bytes > size_ - at_)
            fail(WEFT_ERR_FORMAT, "the file ends within its header, after %llu bytes",
                 static_cast<unsigned long long>(size_));
        at_ += bytes;
    }

    void get(void *out, uint64_t bytes)
    {
        uint64_t from = at_;
        skip(bytes);
        for (uint64_t done = 0; done < bytes;) {
            ssize_t n = pread(fd_, static_cast<char *>(out) + done, bytes - done,
                              static_cast<off_t>(from + done));
            if (n <= 0)
                fail(WEFT_ERR_OPEN, "cannot read the file");
            done += static_cast<uint64_t>(n);
        }
    }

    template <class T> T get()
    {
        T value;
        get(&value, sizeof value);
        return value;
    }

    std::string get_string()
    {
        uint32_t length = get<uint32_t>();
        if (length > longest_name)
            fail(WEFT_ERR_FORMAT, "a name of %u bytes in the header; %u is the most", length,
                 longest_name);
        std::string text(length, '\0');
        get(&text[0], length);
        return text;
    }

  private:
    int fd_;
    uint64_t size_ = 0, at_ = 0;
};

void skip_metadata(Cursor &cursor)
{
    uint32_t count = cursor.get<uint32_t>();
    if (count > most_metadata)
        fail(WEFT_ERR_FORMAT, "%u metadata entries; %u is the most", count, most_metadata);
    for (uint32_t i = 0; i < count; i++) {
        cursor.get_string();
        cursor.get_string();
        cursor.skip(cursor.get<uint32_t>());
    }
}

void read_header(Cursor &cursor)
{
    if (cursor.size() == 0)
        fail(WEFT_ERR_FORMAT, "the file is empty");
    if (cursor.size() < sizeof magic || cursor.get<uint64_t>() != magic)
        fail(WEFT_ERR_FORMAT, "not a VDB file (wrong magic number)");
    uint32_t version = cursor.get<uint32_t>();
    if (version < oldest_version)
        fail(WEFT_ERR_UNSUPPORTED, "VDB file version %u; %u is the oldest supported", version,
             oldest_version);
    cursor.skip(2 * sizeof(uint32_t)); // the library's version
    if (!cursor.get<char>())
        fail(WEFT_ERR_UNSUPPORTED, "a streamed VDB file, which has no table of grid positions");
    cursor.skip(36); // UUID
    skip_metadata(cursor);
}

bool is_readable(const std::string &type)
{
    for (const char *known : {"float", "double", "half", "int32", "bool"})
        if (type == known)
            return true;
    return false;
}

bool strip_end(std::string &text, const char *end)
{
    size_t length = strlen(end);
    if (text.size() < length || text.compare(text.size() - length, length, end))
        return false;
    text.resize(text.size() - length);
    return true;
}

// "Tree_float_5_4_3_HalfFloat" is "half"; trees of another shape keep their full name.
std::string short_type(std::string type)
{
    std::string whole = type;
    bool half = strip_end(type, "_HalfFloat");
    if (type.compare(0, 5, "Tree_") || !strip_end(type, "_5_4_3"))
        return whole;
    type.erase(0, 5);
    return half && (type == "float" || type == "double") ? "half" : type;
}

// OpenVDB tells grids of one name apart by a record separator and a number.
std::string shown_name(const std::string &unique)
{
    size_t separator = unique.find('\x1e');
    if (separator == std::string::npos)
        return unique;
    return unique.substr(0, separator) + "[" + unique.substr(separator + 1) + "]";
}

void check_positions(const GridEntry &grid, const int64_t position[3], uint64_t file_size)
{
    if (position[0] > 0 && position[0] <= position[1] && position[1] <= position[2] &&
        static_cast<uint64_t>(position[2]) <= file_size)
        return;
    fail(WEFT_ERR_FORMAT,
         "grid '%.64s' lies at bytes %lld, %lld to %lld of a file of %llu bytes (cut short?)",
         grid.name.c_str(), static_cast<long long>(position[0]),
         static_cast<long long>(position[1]), static_cast<long long>(position[2]),
         static_cast<unsigned long long>(file_size));
}

} // namespace

std::vector<GridEntry> scan_file(int fd)
{
    Cursor cursor(fd);
    read_header(cursor);
    uint32_t count = cursor.get<uint32_t>();
    if (count > most_grids)
        fail(WEFT_ERR_FORMAT, "%u grids; %u is the most", count, most_grids);
    std::vector<GridEntry> grids;
    for (uint32_t i = 0; i < count; i++) {
        GridEntry grid;
        grid.unique_name = cursor.get_string();
        grid.name = shown_name(grid.unique_name);
        grid.type = short_type(cursor.get_string());
        grid.listed_type = is_readable(grid.type);
        cursor.get_string(); // of the grid that this one is an instance of
        int64_t position[3];
        cursor.get(position, sizeof position);
        check_positions(grid, position, cursor.size());
        // The next descriptor follows this grid's data.
        Cursor next(fd);
        next.skip(static_cast<uint64_t>(position[2]));
        cursor = next;
        grids.push_back(grid);
    }
    return grids;
}

} // namespace weft
