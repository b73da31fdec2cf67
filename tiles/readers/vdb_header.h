// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/vdb_header.h - what stands in front of a grid's tree: compression, metadata, and
// the transform from index space to the world.
#ifndef WEFT_TILES_READERS_VDB_HEADER_H
#define WEFT_TILES_READERS_VDB_HEADER_H

#include <string>
#include <vector>

#include "tiles/readers/vdb_scan.h"

namespace weft
{

struct MetadataEntry {
    std::string key, type, value; // the value's bytes
};

struct GridHeader {
    uint32_t compression;                // bits of enum Compression (vdb_values.h)
    std::vector<MetadataEntry> metadata; // sorted by key, each key once: the last one's value
    std::string delayed;                 // of the type __delayedload, which is not listed
    uint64_t transform;                  // where it starts in the file
};

// Reads a grid's metadata. Every length is compared with the grid's bytes in the file, and values
// of known types with their size, before anything is allocated. Throws Failure.
GridHeader read_header(const Mapping &file, const GridEntry &grid);

// A value as OpenVDB's Metadata::str() shows it: numbers with 6 digits, "[1, 2, 3]", texts as they
// are, "<binary data>" for types that OpenVDB does not know.
std::string metadata_text(const MetadataEntry &entry);

// The entry of this key and type; NULL: none.
const MetadataEntry *find_metadata(const GridHeader &header, const char *key, const char *type);

struct Transform {
    bool affine; // otherwise a frustum, which is not read
    double index_to_world[3][4];
    uint64_t ends; // where the tree starts in the file
};

// Throws Failure, also for a map of a name that OpenVDB does not have.
Transform read_transform(const Mapping &file, const GridEntry &grid, const GridHeader &header);

} // namespace weft

#endif
