// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/vdb_scan.h - the header and grid table of a VDB file, checked before OpenVDB sees
// it.
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
    std::string name;        // as shown, and as OpenVDB takes it: "density", "density[1]"
    std::string type;        // "float", "half", "vec3s", ... or the stored type where it is unusual
    bool listed_type;        // one of the types that weft reads
};

// Checks magic, version, string lengths and that every grid's data lies inside the file, and
// returns the grids in the file's order. Throws Failure.
std::vector<GridEntry> scan_file(int fd);

} // namespace weft

#endif
