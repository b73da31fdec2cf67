// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/readers/vdb_scan.h"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <map>
#include <set>
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
constexpr uint32_t most_grids = 65536;
constexpr size_t longest_label = 255;

unsigned long long wide(uint64_t value)
{
    return value;
}

uint64_t file_size(int fd)
{
    struct stat stat;
    if (fstat(fd, &stat) || !S_ISREG(stat.st_mode))
        fail(WEFT_ERR_OPEN, "not a regular file");
    return static_cast<uint64_t>(stat.st_size);
}

// Reads the bytes of a file from one place to another; what would lead beyond it fails before
// memory is asked for.
class Cursor
{
  public:
    Cursor(int fd, uint64_t at, uint64_t end) : fd_(fd), at_(at), end_(end)
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

    void move_to(uint64_t at)
    {
        at_ = at;
    }

    void skip(uint64_t bytes)
    {
        if (bytes > end_ - at_)
            fail(WEFT_ERR_FORMAT, "the header has %llu bytes at %llu, and ends at %llu",
                 wide(bytes), wide(at_), wide(end_));
        at_ += bytes;
    }

    void get(void *out, uint64_t bytes)
    {
        uint64_t from = at_;
        skip(bytes);
        if (bytes > window_size) {
            read(out, from, bytes);
            return;
        }
        if (from < window_at_ || at_ > window_at_ + window_.size()) {
            window_.resize(std::min(window_size, end_ - from));
            window_at_ = from;
            read(window_.data(), from, window_.size());
        }
        memcpy(out, window_.data() + (from - window_at_), bytes);
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
        if (length > end_ - at_)
            fail(WEFT_ERR_FORMAT, "a text of %u bytes at %llu of a header that ends at %llu",
                 length, wide(at_), wide(end_));
        std::string text(length, '\0');
        get(&text[0], length);
        return text;
    }

    void skip_string()
    {
        skip(get<uint32_t>());
    }

  private:
    static constexpr uint64_t window_size = 4096;

    void read(void *out, uint64_t from, uint64_t bytes) const
    {
        for (uint64_t done = 0; done < bytes;) {
            ssize_t n = pread(fd_, static_cast<char *>(out) + done, bytes - done,
                              static_cast<off_t>(from + done));
            if (n <= 0)
                fail(WEFT_ERR_OPEN, "cannot read the file");
            done += static_cast<uint64_t>(n);
        }
    }

    int fd_;
    uint64_t at_, end_, window_at_ = 0;
    std::vector<char> window_;
};

void skip_metadata(Cursor &cursor)
{
    for (uint32_t count = cursor.get<uint32_t>(); count; count--)
        for (int part = 0; part < 3; part++) // key, type, value
            cursor.skip_string();
}

void read_header(Cursor &cursor)
{
    if (cursor.end() == 0)
        fail(WEFT_ERR_FORMAT, "the file is empty");
    if (cursor.end() < sizeof magic || cursor.get<uint64_t>() != magic)
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
    for (const char *known :
         {"float", "double", "half", "int32", "bool", "vec3s", "vec3d", "vec3h", "vec3i"})
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

// "Tree_float_5_4_3" is "float", or "half" ("vec3h" of vectors); trees of another shape keep their
// full name.
void name_type(GridEntry &grid, std::string stored)
{
    std::string whole = stored;
    grid.half = strip_end(stored, "_HalfFloat");
    grid.stored_type = stored;
    grid.type = whole;
    if (!stored.compare(0, 5, "Tree_") && strip_end(stored, "_5_4_3")) {
        stored.erase(0, 5);
        grid.type = stored;
        if (grid.half && (stored == "float" || stored == "double"))
            grid.type = "half";
        if (grid.half && (stored == "vec3s" || stored == "vec3d"))
            grid.type = "vec3h";
    }
    grid.listed_type = is_readable(grid.type);
    grid.components = !grid.type.compare(0, 4, "vec3") ? 3 : 1;
}

// OpenVDB tells grids of one name apart by a record separator and a number.
std::string shown_name(const std::string &unique)
{
    size_t separator = unique.find('\x1e');
    if (separator == std::string::npos)
        return unique;
    return unique.substr(0, separator) + "[" + unique.substr(separator + 1) + "]";
}

// Whole UTF-8 sequences and "...".
std::string shorten(const std::string &text, size_t size)
{
    if (text.size() <= size)
        return text;
    size -= 3;
    while (size && (text[size] & 0xc0) == 0x80)
        size--;
    return text.substr(0, size) + "...";
}

// Names that differ in what a label does not show are told apart by a number.
void label_grids(std::vector<GridEntry> &grids)
{
    std::set<std::string> taken;
    std::map<std::string, int> count;
    for (GridEntry &grid : grids) {
        std::string text = grid.name;
        std::replace(text.begin(), text.end(), '\0', '\n');
        weft_text_clean(&text[0], false);
        text.resize(strlen(text.c_str()));
        const std::string plain = shorten(text, longest_label);
        grid.label = plain;
        while (!taken.insert(grid.label).second) {
            std::string number = "[" + std::to_string(++count[plain]) + "]";
            grid.label = shorten(text, longest_label - number.size()) + number;
        }
    }
}

std::string lost_behind(uint32_t count)
{
    return count ? "; " + std::to_string(count) + " more behind it cannot be found" : "";
}

// The next descriptor follows this grid's data, so that data which ends outside the file hides the
// grids behind it. Instances have no place for blocks.
void place_grid(Cursor &cursor, GridEntry &grid, uint32_t behind)
{
    int64_t position[3];
    cursor.get(position, sizeof position);
    auto starts = static_cast<uint64_t>(position[0]), blocks = static_cast<uint64_t>(position[1]),
         ends = static_cast<uint64_t>(position[2]);
    bool ordered = grid.parent.empty() ? starts <= blocks && blocks <= ends : starts <= ends;
    grid.starts = starts;
    grid.ends = ends;
    if (starts >= cursor.at() && ordered && ends <= cursor.end()) {
        cursor.move_to(ends);
        return;
    }
    char text[256];
    snprintf(text, sizeof text, "it lies at bytes %lld, %lld to %lld of a file of %llu bytes%s",
             static_cast<long long>(position[0]), static_cast<long long>(position[1]),
             static_cast<long long>(position[2]), wide(cursor.end()),
             ends > cursor.end() ? " (cut short?)" : "");
    grid.problem = text;
    grid.problem += lost_behind(behind);
    grid.starts = std::min(starts, cursor.end());
    grid.ends = cursor.end();
}

GridEntry read_descriptor(Cursor &cursor, uint32_t number, uint32_t count)
{
    GridEntry grid{};
    try {
        grid.unique_name = cursor.get_string();
        grid.name = shown_name(grid.unique_name);
        name_type(grid, cursor.get_string());
        grid.parent = cursor.get_string();
        place_grid(cursor, grid, count - number);
    } catch (const Failure &failure) {
        if (number == 1)
            throw;
        grid.problem = "the file's table ends in it (cut short?): " + failure.text +
                       lost_behind(count - number);
    }
    return grid;
}

} // namespace

std::vector<GridEntry> scan_file(int fd)
{
    Cursor cursor(fd, 0, file_size(fd));
    read_header(cursor);
    uint32_t count = cursor.get<uint32_t>();
    if (count > most_grids)
        fail(WEFT_ERR_FORMAT, "%u grids; %u is the most", count, most_grids);
    std::vector<GridEntry> grids;
    while (grids.size() < count && (grids.empty() || grids.back().problem.empty()))
        grids.push_back(read_descriptor(cursor, static_cast<uint32_t>(grids.size()) + 1, count));
    label_grids(grids);
    return grids;
}

GridHeader scan_header(int fd, const GridEntry &grid)
{
    GridHeader header;
    Cursor cursor(fd, grid.starts, grid.ends);
    cursor.skip(sizeof(uint32_t)); // compression
    for (uint32_t count = cursor.get<uint32_t>(); count; count--) {
        MetadataEntry entry;
        entry.key = cursor.get_string();
        entry.type = cursor.get_string();
        entry.value = cursor.get_string();
        header.metadata.push_back(std::move(entry));
    }
    header.transform = cursor.at();
    if (cursor.get_string() == "NonlinearFrustumMap") {
        cursor.skip(8 * sizeof(double)); // taper, depth, box: the map behind it is named next
        cursor.skip_string();
    }
    return header;
}

} // namespace weft
