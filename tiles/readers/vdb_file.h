// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/vdb_file.h - one VDB file, whose grids OpenVDB reads one by one: what is wrong with
// one does not keep the others from being read. (openvdb::io::File reads the whole table itself.)
#ifndef WEFT_TILES_READERS_VDB_FILE_H
#define WEFT_TILES_READERS_VDB_FILE_H

#include <istream>
#include <memory>
#include <vector>

#include <openvdb/io/io.h>

#include "tiles/readers/vdb_scan.h"
#include "tiles/readers/vdb_trees.h"

namespace weft
{

class VdbFile
{
  public:
    // Maps the file. Throws Failure, also where the map does not fit into memory_bytes.
    VdbFile(int fd, uint64_t memory_bytes);
    ~VdbFile();

    const std::vector<GridEntry> &entries() const
    {
        return entries_;
    }

    // A grid without its tree: metadata and transform. Its type is float, whatever the file's is.
    // Throws Failure or what OpenVDB throws.
    openvdb::GridBase::Ptr read_header(const GridEntry &entry);

    // The same with its tree, whose voxels stay in the file until they are asked for. An instance
    // gets the tree of the grid that it shares it with.
    openvdb::GridBase::Ptr read_grid(const GridEntry &entry);

  private:
    class Archive;

    const GridEntry &tree_owner(const GridEntry &entry) const;
    void read_metadata(const GridEntry &entry, openvdb::MetaMap *metadata);
    openvdb::GridBase::Ptr read_tree(const GridEntry &entry);

    int fd_;
    std::vector<GridEntry> entries_;
    openvdb::io::MappedFile::Ptr mapping_;
    openvdb::SharedPtr<std::streambuf> buffer_;
    std::unique_ptr<std::istream> stream_;
    std::unique_ptr<Archive> archive_;
    // The stream points to these two: the file's settings, and those of the grid that is read.
    openvdb::io::StreamMetadata::Ptr file_settings_, grid_settings_;
};

} // namespace weft

#endif
