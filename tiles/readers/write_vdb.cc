// SPDX-License-Identifier: BSD-3-Clause
// weft-write-vdb: a volume as a float grid in a VDB file, by OpenVDB.
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <new>

#include <sys/stat.h>
#include <unistd.h>

#include <openvdb/tools/Prune.h>
#include <openvdb/tools/SignedFloodFill.h>

#include "tiles/process/server.h"
#include "tiles/volume/volume_wire.h"
#include "tiles/readers/vdb_scan.h"
#include "tiles/readers/vdb_trees.h"

using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::FloatTree;
using weft::fail;

namespace
{

struct Source {
    weft_wire_volume head;
    const int32_t (*origin)[3];
    const weft_volume_tile *tiles;
    const float *values;
    bool level_set;
};

Source parse(const weft_server *server)
{
    Source source;
    uint64_t left = server->request->payload_bytes;
    if (left < sizeof source.head)
        fail(WEFT_ERR_ARGUMENT, "the request has no volume");
    memcpy(&source.head, server->request_payload, sizeof source.head);
    left -= sizeof source.head;
    uint64_t bricks = source.head.brick_count, tiles = source.head.tile_count;
    constexpr uint64_t brick_bytes = sizeof(int32_t[3]) + WEFT_BRICK_VOXELS * sizeof(float);
    if (bricks > left / brick_bytes || tiles > left / sizeof(weft_volume_tile) ||
        left != bricks * brick_bytes + tiles * sizeof(weft_volume_tile))
        fail(WEFT_ERR_ARGUMENT, "the request's size does not match its counts");
    const char *data = static_cast<const char *>(server->request_payload) + sizeof source.head;
    source.origin = reinterpret_cast<const int32_t(*)[3]>(data);
    data += bricks * sizeof(int32_t[3]);
    source.tiles = reinterpret_cast<const weft_volume_tile *>(data);
    source.values = reinterpret_cast<const float *>(data + tiles * sizeof(weft_volume_tile));
    source.level_set = !strcmp(source.head.grid_class, "level set");
    return source;
}

bool is_active(const Source &source, float value)
{
    return source.level_set ? std::fabs(value) < std::fabs(source.head.background)
                            : value != source.head.background;
}

bool in_box(const Source &source, const Coord &at)
{
    for (int i = 0; i < 3; i++)
        if (at[i] < source.head.box_min[i] || at[i] > source.head.box_max[i])
            return false;
    return true;
}

// Our voxels are [z][y][x], OpenVDB's [x][y][z].
void fill_leaf(const Source &source, const float *values, FloatTree::LeafNodeType *leaf)
{
    float *out = leaf->buffer().data();
    for (openvdb::Index x = 0; x < 8; x++)
        for (openvdb::Index y = 0; y < 8; y++)
            for (openvdb::Index z = 0; z < 8; z++) {
                openvdb::Index n = x << 6 | y << 3 | z;
                float value = values[z << 6 | y << 3 | x];
                bool active = source.head.boxed ? in_box(source, leaf->offsetToGlobalCoord(n))
                                                : is_active(source, value);
                out[n] = source.head.boxed && !active ? source.head.background : value;
                leaf->setActiveState(n, active);
            }
}

void fill_tree(const Source &source, FloatTree *tree)
{
    for (uint64_t i = 0; i < source.head.brick_count; i++) {
        auto *leaf =
            new FloatTree::LeafNodeType(Coord(source.origin[i]), source.head.background, false);
        fill_leaf(source, source.values + i * WEFT_BRICK_VOXELS, leaf);
        if (leaf->valueMask().isOff() && !source.level_set)
            delete leaf;
        else
            tree->addLeaf(leaf);
    }
    for (uint64_t i = 0; i < source.head.tile_count; i++) {
        const weft_volume_tile &tile = source.tiles[i];
        openvdb::Index level = tile.size == 8 ? 1 : tile.size == 128 ? 2 : 3;
        tree->addTile(level, Coord(tile.origin), tile.value, is_active(source, tile.value));
    }
    if (source.level_set) {
        openvdb::tools::signedFloodFill(*tree);
        openvdb::tools::pruneLevelSet(*tree);
    }
}

// OpenVDB takes affine matrices of small voxels for singular ones, scales it does not.
openvdb::math::Transform::Ptr make_transform(const double m[3][4])
{
    using namespace openvdb::math;
    bool diagonal = true;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            diagonal = diagonal && (r == c || m[r][c] == 0);
    if (diagonal) {
        openvdb::Vec3d scale(m[0][0], m[1][1], m[2][2]), shift(m[0][3], m[1][3], m[2][3]);
        if (scale[0] == scale[1] && scale[1] == scale[2])
            return Transform::Ptr(
                new Transform(MapBase::Ptr(new UniformScaleTranslateMap(scale[0], shift))));
        return Transform::Ptr(new Transform(MapBase::Ptr(new ScaleTranslateMap(scale, shift))));
    }
    // Row vectors: the transpose of ours.
    return Transform::createLinearTransform(Mat4d(m[0][0], m[1][0], m[2][0], 0.0, m[0][1], m[1][1],
                                                  m[2][1], 0.0, m[0][2], m[1][2], m[2][2], 0.0,
                                                  m[0][3], m[1][3], m[2][3], 1.0));
}

uint64_t file_size(int fd)
{
    struct stat status;
    return fstat(fd, &status) == 0 ? static_cast<uint64_t>(status.st_size) : 0;
}

// OpenVDB does not tell when the disk is full, which one more block does. Its signal would end us.
[[noreturn]] void fail_cut_short(int fd, uint64_t size)
{
    static const char block[1 << 16] = {};
    for (int i = 0; i < 2; i++)
        if (pwrite(fd, block, sizeof block, static_cast<off_t>(size) + i * (1 << 16)) < 0)
            fail(WEFT_ERR_WRITE, "the file was not written whole: %s after %llu bytes",
                 strerror(errno), static_cast<unsigned long long>(size));
    fail(WEFT_ERR_WRITE, "the file was not written whole: it ends after %llu bytes",
         static_cast<unsigned long long>(size));
}

// A file that is cut short is found out by reading where its grid lies.
bool is_whole(int fd)
{
    try {
        const std::vector<weft::GridEntry> grids = weft::scan_file(fd);
        return grids.size() == 1 && grids[0].problem.empty();
    } catch (const weft::Failure &) {
        return false;
    }
}

void write_volume(weft_server *server)
{
    if (server->request->op != WEFT_WIRE_WRITE)
        fail(WEFT_ERR_ARGUMENT, "a VDB writer cannot do operation %u", server->request->op);
    Source source = parse(server);
    FloatGrid::Ptr grid = FloatGrid::create(source.head.background);
    grid->setName(source.head.name);
    grid->setGridClass(openvdb::GridBase::stringToGridClass(source.head.grid_class));
    grid->setCreator("weft");
    grid->setTransform(make_transform(source.head.index_to_world));
    fill_tree(source, &grid->tree());

    openvdb::io::File file("/proc/self/fd/" + std::to_string(server->input_fd));
    file.setCompression(openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK);
    file.write(openvdb::GridCPtrVec{grid});
    file.close();
    const uint64_t size = file_size(server->input_fd);
    if (!is_whole(server->input_fd))
        fail_cut_short(server->input_fd, size);
    server->answer.count[0] = size;
}

weft_result handle(weft_server *server)
{
    try {
        write_volume(server);
        return WEFT_OK;
    } catch (const weft::Failure &failure) {
        return weft_server_fail(server, failure.result, "%s", failure.text.c_str());
    } catch (const std::bad_alloc &) {
        return weft_server_fail(server, WEFT_ERR_LIMIT,
                                "more memory is needed than the limit of %llu bytes",
                                static_cast<unsigned long long>(server->limits.memory_bytes));
    } catch (const std::exception &error) {
        return weft_server_fail(server, WEFT_ERR_WRITE, "OpenVDB says: %.400s", error.what());
    } catch (...) {
        return weft_server_fail(server, WEFT_ERR_WRITE, "OpenVDB failed without a reason");
    }
}

} // namespace

int main(int argc, char **argv)
{
    openvdb::initialize();
    return weft_server_run(argc, argv, handle, nullptr);
}
