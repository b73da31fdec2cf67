// SPDX-License-Identifier: BSD-3-Clause
// weft-write-vdb: grids of floats and of vectors in a VDB file, by OpenVDB, brick by brick.
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
using openvdb::Vec3SGrid;
using weft::fail;

namespace
{

// A grid that is being filled.
struct Target {
    weft_wire_volume head;
    bool level_set;
    openvdb::GridBase::Ptr grid;
};

// What the process has been told so far.
struct Targets {
    std::vector<Target> target;
};

struct Lot {
    weft_wire_lot head;
    const int32_t (*origin)[3];
    const weft_volume_tile *tiles;
    const float *values;
};

Lot parse(const weft_server *server, uint64_t components)
{
    Lot lot;
    uint64_t left = server->request->payload_bytes;
    if (left < sizeof lot.head)
        fail(WEFT_ERR_ARGUMENT, "the request has no bricks");
    memcpy(&lot.head, server->request_payload, sizeof lot.head);
    left -= sizeof lot.head;
    const uint64_t bricks = lot.head.brick_count, tiles = lot.head.tile_count;
    const uint64_t brick_bytes =
        sizeof(int32_t[3]) + components * WEFT_BRICK_VOXELS * sizeof(float);
    if (bricks > left / brick_bytes || tiles > left / sizeof(weft_volume_tile) ||
        left != bricks * brick_bytes + tiles * sizeof(weft_volume_tile))
        fail(WEFT_ERR_ARGUMENT, "the request's size does not match its counts");
    const char *data = static_cast<const char *>(server->request_payload) + sizeof lot.head;
    lot.origin = reinterpret_cast<const int32_t(*)[3]>(data);
    data += bricks * sizeof(int32_t[3]);
    lot.tiles = reinterpret_cast<const weft_volume_tile *>(data);
    lot.values = reinterpret_cast<const float *>(data + tiles * sizeof(weft_volume_tile));
    return lot;
}

bool is_active(const Target &target, float value)
{
    return target.level_set ? std::fabs(value) < std::fabs(target.head.background)
                            : value != target.head.background;
}

bool is_active(const Target &, const openvdb::Vec3s &value)
{
    return value != openvdb::Vec3s(0.0f);
}

bool in_box(const Target &target, const Coord &at)
{
    for (int i = 0; i < 3; i++)
        if (at[i] < target.head.box_min[i] || at[i] > target.head.box_max[i])
            return false;
    return true;
}

void get_value(const float *values, float *out)
{
    *out = values[0];
}

void get_value(const float *values, openvdb::Vec3s *out)
{
    *out = openvdb::Vec3s(values[0], values[WEFT_BRICK_VOXELS], values[2 * WEFT_BRICK_VOXELS]);
}

// Our voxels are [z][y][x], OpenVDB's [x][y][z].
template <typename Leaf>
void fill_leaf(const Target &target, const float *values,
               const typename Leaf::ValueType &background, Leaf *leaf)
{
    auto *out = leaf->buffer().data();
    for (openvdb::Index x = 0; x < 8; x++)
        for (openvdb::Index y = 0; y < 8; y++)
            for (openvdb::Index z = 0; z < 8; z++) {
                const openvdb::Index n = x << 6 | y << 3 | z;
                typename Leaf::ValueType value;
                get_value(values + (z << 6 | y << 3 | x), &value);
                const bool active = target.head.boxed ? in_box(target, leaf->offsetToGlobalCoord(n))
                                                      : is_active(target, value);
                out[n] = target.head.boxed && !active ? background : value;
                leaf->setActiveState(n, active);
            }
}

template <typename Grid> void add_bricks(const Target &target, const Lot &lot, Grid *grid)
{
    using Leaf = typename Grid::TreeType::LeafNodeType;
    const auto background = grid->background();
    for (uint64_t i = 0; i < lot.head.brick_count; i++) {
        auto *leaf = new Leaf(Coord(lot.origin[i]), background, false);
        fill_leaf(target, lot.values + i * target.head.components * WEFT_BRICK_VOXELS, background,
                  leaf);
        if (leaf->valueMask().isOff() && !target.level_set)
            delete leaf;
        else
            grid->tree().addLeaf(leaf);
    }
}

void add_tiles(const Target &target, const Lot &lot, FloatGrid *grid)
{
    for (uint64_t i = 0; i < lot.head.tile_count; i++) {
        const weft_volume_tile &tile = lot.tiles[i];
        const openvdb::Index level = tile.size == 8 ? 1 : tile.size == 128 ? 2 : 3;
        grid->tree().addTile(level, Coord(tile.origin), tile.value, is_active(target, tile.value));
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
bool is_whole(int fd, size_t count)
{
    try {
        const std::vector<weft::GridEntry> grids = weft::scan_file(fd);
        for (const weft::GridEntry &grid : grids)
            if (!grid.problem.empty())
                return false;
        return grids.size() == count;
    } catch (const weft::Failure &) {
        return false;
    }
}

// What OpenVDB writes by itself.
bool is_own(const std::string &key)
{
    static const char *const own[] = {
        "class", "creator",    "is_local_space", "is_saved_as_half_float",
        "name",  "value_type", "vector_type"};
    for (const char *name : own)
        if (key == name)
            return true;
    return key.compare(0, 5, "file_") == 0;
}

void begin_grid(const weft_wire_volume &head, const weft_metadata *metadata, Target *target)
{
    target->head = head;
    target->level_set = !strcmp(head.grid_class, "level set");
    if (head.components == 1)
        target->grid = FloatGrid::create(head.background);
    else
        target->grid = Vec3SGrid::create(openvdb::Vec3s(0.0f));
    target->grid->setName(head.name);
    target->grid->setGridClass(openvdb::GridBase::stringToGridClass(head.grid_class));
    if (head.components > 1)
        target->grid->setVectorType(openvdb::GridBase::stringToVecType(head.vector_type));
    target->grid->setCreator("weft");
    target->grid->setTransform(make_transform(head.index_to_world));
    for (uint64_t i = 0; i < head.metadata_count; i++)
        if (!is_own(metadata[i].key))
            target->grid->insertMeta(metadata[i].key, openvdb::StringMetadata(metadata[i].value));
}

void begin(weft_server *server, Targets *targets)
{
    const char *data = static_cast<const char *>(server->request_payload);
    uint64_t left = server->request->payload_bytes;
    targets->target.clear();
    while (left) {
        weft_wire_volume head;
        if (left < sizeof head)
            fail(WEFT_ERR_ARGUMENT, "the request is cut short");
        memcpy(&head, data, sizeof head);
        data += sizeof head;
        left -= sizeof head;
        if (head.metadata_count > left / sizeof(weft_metadata) ||
            (head.components != 1 && head.components != 3))
            fail(WEFT_ERR_ARGUMENT, "the request's counts are wrong");
        targets->target.emplace_back();
        begin_grid(head, reinterpret_cast<const weft_metadata *>(data), &targets->target.back());
        data += head.metadata_count * sizeof(weft_metadata);
        left -= head.metadata_count * sizeof(weft_metadata);
    }
}

void add(weft_server *server, Targets *targets)
{
    if (server->request->part >= targets->target.size())
        fail(WEFT_ERR_ARGUMENT, "there is no grid %u", server->request->part);
    Target &target = targets->target[server->request->part];
    const Lot lot = parse(server, target.head.components);
    if (target.head.components > 1) {
        add_bricks(target, lot, openvdb::gridPtrCast<Vec3SGrid>(target.grid).get());
        return;
    }
    FloatGrid *grid = openvdb::gridPtrCast<FloatGrid>(target.grid).get();
    add_bricks(target, lot, grid);
    add_tiles(target, lot, grid);
}

void finish(weft_server *server, Targets *targets)
{
    openvdb::GridCPtrVec grids;
    for (Target &target : targets->target) {
        if (target.level_set && target.head.components == 1) {
            FloatGrid *grid = openvdb::gridPtrCast<FloatGrid>(target.grid).get();
            openvdb::tools::signedFloodFill(grid->tree());
            openvdb::tools::pruneLevelSet(grid->tree());
        }
        grids.push_back(target.grid);
    }
    openvdb::io::File file("/proc/self/fd/" + std::to_string(server->input_fd));
    file.setCompression(openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK);
    file.write(grids);
    file.close();
    const uint64_t size = file_size(server->input_fd);
    if (!is_whole(server->input_fd, grids.size()))
        fail_cut_short(server->input_fd, size);
    server->answer.count[0] = size;
}

void answer(weft_server *server)
{
    Targets *targets = static_cast<Targets *>(server->priv);
    switch (server->request->op) {
    case WEFT_WIRE_WRITE_BEGIN:
        return begin(server, targets);
    case WEFT_WIRE_WRITE_ADD:
        return add(server, targets);
    case WEFT_WIRE_WRITE:
        return finish(server, targets);
    default:
        fail(WEFT_ERR_ARGUMENT, "a VDB writer cannot do operation %u", server->request->op);
    }
}

weft_result handle(weft_server *server)
{
    try {
        answer(server);
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
    Targets targets;
    return weft_server_run(argc, argv, handle, &targets);
}
