// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/vdb_tree.h - a grid's tree: what it holds, what lies where, and its voxels.
#ifndef WEFT_TILES_READERS_VDB_TREE_H
#define WEFT_TILES_READERS_VDB_TREE_H

#include <memory>

#include "tiles/process/server.h"
#include "tiles/readers/vdb_trees.h"
#include "tiles/volume/volume_wire.h"

namespace weft
{

// Adds to the answer's payload. Throws Failure.
void append(weft_server *server, const void *data, size_t size);

// All members throw Failure or what OpenVDB throws.
class Volume
{
  public:
    virtual ~Volume() = default;
    // Counts of voxels, bricks and values that a float does not hold, and the background.
    virtual void describe_tree(weft_volume_info *info) const = 0;
    // Appends the bricks' origins and the tiles that meet the region, both sorted.
    virtual void find(weft_server *server, const weft_region &region) const = 0;
    // Appends the voxels of these bricks.
    virtual void read(weft_server *server, const int32_t (*origin)[3], size_t count) const = 0;
};

// component: of vectors, 0 to 2. rest: values are what floats lack of the stored ones. Throws
// Failure for a grid of another type than float, double, int32, bool or vectors of three of the
// first three.
std::unique_ptr<Volume> make_volume(const openvdb::GridBase::Ptr &grid, int component, bool rest);

} // namespace weft

#endif
