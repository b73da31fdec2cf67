// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/vdb_scan.h - the header and grid table of a VDB file and the headers of its grids,
// checked before OpenVDB sees them.
#ifndef WEFT_TILES_READERS_VDB_SCAN_H
#define WEFT_TILES_READERS_VDB_SCAN_H

#include <string>
#include <vector>

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

struct GridEntry {
    std::string unique_name; // as stored, with a suffix where names repeat
    std::string name;        // as OpenVDB shows it: "density", "density[1]"
    std::string label;       // the same fit to be printed, up to 255 bytes, and no other grid's
    std::string stored_type; // "Tree_float_5_4_3"
    bool half;               // its floats or doubles, of vectors too, are stored as halves
    std::string type;        // "float", "half", "vec3s", ... or the stored type where it is unusual
    bool listed_type;        // one of the types that weft reads
    int components;          // 3 of vectors, else 1
    std::string parent;      // the unique name of the grid whose tree it shares, "" = its own
    uint64_t starts, ends;   // its bytes in the file: metadata, transform, tree
    std::string problem;     // why it cannot be read as the table has it; "" = it can
};

struct MetadataEntry {
    std::string key, type, value; // the value's bytes
};

struct GridHeader {
    std::vector<MetadataEntry> metadata;
    uint64_t transform; // where it starts in the file
};

// Checks magic and version, and returns the grids in the file's order. One that lies outside the
// file has a problem; those behind it are lost, which its problem tells. Throws Failure where not
// even one grid is found that the file announces.
std::vector<GridEntry> scan_file(int fd);

// Reads a grid's metadata and checks the lengths in its transform. Every length is compared with
// the grid's bytes in the file before anything is allocated. Throws Failure.
GridHeader scan_header(int fd, const GridEntry &grid);

} // namespace weft

#endif
