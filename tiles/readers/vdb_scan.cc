// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/readers/vdb_scan.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <set>

namespace weft
{

namespace
{

constexpr uint64_t magic = 0x56444220;
constexpr uint32_t oldest_version = 222; // node mask compression, 2012
constexpr uint32_t most_grids = 65536;
constexpr size_t longest_label = 255;

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

// "Tree_float_5_4_3" is "float", or "half"; trees of another shape keep their full name.
void name_type(GridEntry &grid, std::string stored)
{
    std::string whole = stored;
    grid.half = strip_end(stored, "_HalfFloat");
    grid.stored_type = stored;
    grid.type = whole;
    if (!stored.compare(0, 5, "Tree_") && strip_end(stored, "_5_4_3")) {
        stored.erase(0, 5);
        bool narrow = grid.half && (stored == "float" || stored == "double");
        grid.type = narrow ? "half" : stored;
    }
    grid.listed_type = is_readable(grid.type);
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

std::vector<GridEntry> scan_file(const Mapping &file)
{
    Cursor cursor(file, 0, file.size());
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

} // namespace weft
