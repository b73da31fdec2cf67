// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/readers/vdb_tree.h"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <new>

#include <openvdb/io/io.h>

#include "tiles/readers/vdb_scan.h"
#include "tiles/volume/region.h"

using openvdb::Coord;

// A name that OpenVDB declares as a friend of its leaf buffers: the only way to learn where a
// leaf's voxels lie in the file. Reading them here rather than through the leaf keeps the tree
// without voxels, notices a stream that failed (the leaf would hand over uninitialised memory), and
// leaves no leaf half loaded, which its destructor does not survive.
class TestLeaf
{
  public:
    template <class Leaf> static auto file_info(const Leaf &leaf)
    {
        return leaf.buffer().mFileInfo;
    }
};

namespace weft
{

void append(weft_server *server, const void *data, size_t size)
{
    if (!weft_server_append(server, data, size))
        throw Failure{static_cast<weft_result>(server->answer.result), server->answer.message};
}

namespace
{

// Calls visit.enter(origin, size) before each node and leaves the node out if that is false,
// visit.leaf(leaf), and visit.tile(origin, size, value, active) for tiles that tell something: that
// are active or differ from the background.
template <class Tree, class Visit> class Walk
{
  public:
    using Value = typename Tree::ValueType;
    using Leaf = typename Tree::LeafNodeType;

    static void run(const Tree &tree, Visit &visit)
    {
        Walk(tree.background(), visit).node(tree.root());
    }

  private:
    Walk(Value background, Visit &visit) : background_(background), visit_(visit)
    {
    }

    template <class Node> void node(const Node &node)
    {
        for (auto it = node.cbeginChildOn(); it; ++it)
            child(*it);
        for (auto it = node.cbeginValueAll(); it; ++it) {
            Value value = it.getValue();
            bool plain = value == background_ || (value != value && background_ != background_);
            if (it.isValueOn() || !plain)
                visit_.tile(it.getCoord(), static_cast<int32_t>(Node::ChildNodeType::DIM), value,
                            it.isValueOn());
        }
    }

    template <class Node> void child(const Node &child)
    {
        if (!visit_.enter(child.origin(), static_cast<int32_t>(Node::DIM)))
            return;
        if constexpr (std::is_same_v<Node, Leaf>)
            visit_.leaf(child);
        else
            node(child);
    }

    Value background_;
    Visit &visit_;
};

// Everything below the root has coordinates derived from the root's, so these are checked first.
// The root's table is keyed by what the file says; nodes of unaligned keys would overlap.
template <class Tree> void check_root(const Tree &tree)
{
    auto check = [](const Coord &key) {
        for (int i = 0; i < 3; i++) {
            if (key[i] % 4096 != 0)
                fail(WEFT_ERR_FORMAT, "a node at (%d, %d, %d), which is not a multiple of 4096",
                     key[0], key[1], key[2]);
            if (key[i] < -WEFT_INDEX_LIMIT || key[i] >= WEFT_INDEX_LIMIT)
                fail(WEFT_ERR_LIMIT, "a node at (%d, %d, %d); the limit is +-%d", key[0], key[1],
                     key[2], WEFT_INDEX_LIMIT);
        }
    };
    for (auto it = tree.root().cbeginChildOn(); it; ++it)
        check(it.getCoord());
    for (auto it = tree.root().cbeginValueAll(); it; ++it)
        check(it.getCoord());
}

struct Survey {
    openvdb::CoordBBox box;
    uint64_t voxels = 0, leaves = 0;

    bool enter(const Coord &, int32_t)
    {
        return true;
    }
    template <class Leaf> void leaf(const Leaf &leaf)
    {
        leaves++;
        voxels += leaf.onVoxelCount();
        leaf.evalActiveBoundingBox(box, true);
    }
    template <class Value> void tile(const Coord &origin, int32_t size, Value, bool active)
    {
        if (!active)
            return;
        voxels +=
            static_cast<uint64_t>(size) * static_cast<uint64_t>(size) * static_cast<uint64_t>(size);
        box.expand(openvdb::CoordBBox::createCube(origin, static_cast<openvdb::Index>(size)));
    }
};

// A component of a vector, or the number that it is.
template <class Number> Number scalar_of(Number value, int)
{
    return value;
}
template <class Number> Number scalar_of(const openvdb::math::Vec3<Number> &value, int component)
{
    return value[component];
}
template <class Value> using Scalar = decltype(scalar_of(Value{}, 0));

// What of the values a float does not hold (volume.h: values_rounded etc.).
void count_value(int32_t value, weft_volume_info *info)
{
    double rounding = std::fabs(static_cast<double>(static_cast<float>(value)) - value);
    info->values_rounded += rounding > 0;
    info->largest_rounding = std::max(info->largest_rounding, rounding);
}

void count_value(double value, weft_volume_info *info)
{
    info->values_infinite += std::isfinite(value) && std::isinf(static_cast<float>(value));
    info->values_tiny += value != 0 && std::fabs(value) < FLT_MIN;
}

template <class Value> struct TileCounter {
    weft_volume_info *info;
    int component;
    std::vector<Coord> bricks;

    bool enter(const Coord &, int32_t)
    {
        return true;
    }
    template <class Leaf> void leaf(const Leaf &leaf)
    {
        bricks.push_back(leaf.origin());
    }
    void tile(const Coord &, int32_t, Value value, bool)
    {
        count_value(scalar_of(value, component), info);
    }
};

// A stored value as a float, or what that lacks of it.
template <class Number> float part_of(Number value, bool rest)
{
    float rounded = static_cast<float>(value);
    if (!rest)
        return rounded;
    double lack = static_cast<double>(value) - static_cast<double>(rounded);
    return std::isfinite(lack) ? static_cast<float>(lack) : 0;
}

struct Finder {
    const weft_region &region;
    int component;
    bool rest;
    std::vector<Coord> bricks;
    std::vector<weft_volume_tile> tiles;

    bool enter(const Coord &origin, int32_t size)
    {
        return weft_region_meets(&region, origin.data(), size);
    }
    template <class Leaf> void leaf(const Leaf &leaf)
    {
        bricks.push_back(leaf.origin());
    }
    template <class Value> void tile(const Coord &origin, int32_t size, Value value, bool)
    {
        if (enter(origin, size))
            tiles.push_back({{origin[0], origin[1], origin[2]},
                             size,
                             part_of(scalar_of(value, component), rest)});
    }
};

bool comes_before(const int32_t *a, const int32_t *b)
{
    for (int i = 2; i > 0; i--)
        if (a[i] != b[i])
            return a[i] < b[i];
    return a[0] < b[0];
}

template <class Grid> class TypedVolume : public Volume
{
  public:
    using Tree = typename Grid::TreeType;
    using Leaf = typename Tree::LeafNodeType;
    using Value = typename Tree::ValueType;

    TypedVolume(typename Grid::Ptr grid, int component, bool rest)
        : grid_(grid), component_(component), rest_(rest)
    {
        check_root(grid_->tree());
    }

    void describe_tree(weft_volume_info *info) const override
    {
        Survey survey;
        Walk<Tree, Survey>::run(grid_->tree(), survey);
        info->background = part_of(scalar_of(grid_->tree().background(), component_), rest_);
        info->active_voxels = survey.voxels;
        info->bricks = survey.leaves;
        info->memory_bytes = survey.leaves * WEFT_BRICK_VOXELS * sizeof(float);
        info->empty = survey.voxels == 0;
        for (int i = 0; i < 3; i++) {
            info->active_min[i] = info->empty ? 0 : survey.box.min()[i];
            info->active_max[i] = info->empty ? 0 : survey.box.max()[i];
        }
        info->counted = true;
        if constexpr (std::is_same_v<Scalar<Value>, double> ||
                      std::is_same_v<Scalar<Value>, int32_t>)
            count_values(info);
    }

    void find(weft_server *server, const weft_region &region) const override
    {
        Finder found{region, component_, rest_, {}, {}};
        Walk<Tree, Finder>::run(grid_->tree(), found);
        std::sort(found.bricks.begin(), found.bricks.end(),
                  [](const Coord &a, const Coord &b) { return comes_before(a.data(), b.data()); });
        std::sort(found.tiles.begin(), found.tiles.end(),
                  [](const weft_volume_tile &a, const weft_volume_tile &b) {
                      return comes_before(a.origin, b.origin);
                  });
        static_assert(sizeof(Coord) == sizeof(int32_t[3]), "bricks go out as they are");
        append(server, found.bricks.data(), found.bricks.size() * sizeof(Coord));
        append(server, found.tiles.data(), found.tiles.size() * sizeof(weft_volume_tile));
        server->answer.count[0] = found.bricks.size();
        server->answer.count[1] = found.tiles.size();
    }

    void read(weft_server *server, const int32_t (*origin)[3], size_t count) const override
    {
        constexpr size_t batch = 64;
        std::vector<float> values(batch * WEFT_BRICK_VOXELS);
        typename Grid::ConstAccessor accessor = grid_->getConstAccessor();
        Stream stream;
        for (size_t done = 0; done < count;) {
            size_t n = std::min(batch, count - done);
            for (size_t i = 0; i < n; i++)
                read_leaf(accessor, Coord(origin[done + i]), stream,
                          &values[i * WEFT_BRICK_VOXELS]);
            append(server, values.data(), n * WEFT_BRICK_VOXELS * sizeof(float));
            done += n;
        }
        server->answer.count[0] = count;
    }

  private:
    // All leaves of a grid share one mapping and one set of stream settings.
    struct Stream {
        openvdb::SharedPtr<std::streambuf> buffer;
        std::unique_ptr<std::istream> stream;
    };

    // Reads all voxels once. Damaged bricks are told when they are asked for.
    void count_values(weft_volume_info *info) const
    {
        TileCounter<Value> counter{info, component_, {}};
        Walk<Tree, TileCounter<Value>>::run(grid_->tree(), counter);
        count_value(scalar_of(grid_->tree().background(), component_), info);
        typename Grid::ConstAccessor accessor = grid_->getConstAccessor();
        Stream stream;
        for (const Coord &origin : counter.bricks) {
            Value values[WEFT_BRICK_VOXELS] = {};
            try {
                load(*accessor.probeConstLeaf(origin), stream, values);
            } catch (const openvdb::Exception &) {
                continue;
            }
            for (const Value &value : values)
                count_value(scalar_of(value, component_), info);
        }
    }

    void read_leaf(typename Grid::ConstAccessor &accessor, const Coord &origin, Stream &stream,
                   float *out) const
    {
        const Leaf *leaf = accessor.probeConstLeaf(origin);
        if (!leaf || leaf->origin() != origin)
            fail(WEFT_ERR_ARGUMENT, "no brick at (%d, %d, %d)", origin[0], origin[1], origin[2]);
        Value values[WEFT_BRICK_VOXELS] = {};
        try {
            load(*leaf, stream, values);
        } catch (const std::bad_alloc &) {
            throw;
        } catch (const std::exception &error) {
            fail(WEFT_ERR_FORMAT, "the voxels of the brick at (%d, %d, %d) cannot be read: %.200s",
                 origin[0], origin[1], origin[2], error.what());
        }
        for (int z = 0; z < 8; z++)
            for (int y = 0; y < 8; y++)
                for (int x = 0; x < 8; x++)
                    *out++ = part_of(scalar_of(values[x << 6 | y << 3 | z], component_), rest_);
    }

    static void load(const Leaf &leaf, Stream &stream, Value *values)
    {
        if constexpr (!std::is_same_v<Value, bool>) {
            if (leaf.buffer().isOutOfCore()) {
                load_from_file(leaf, stream, values);
                return;
            }
        }
        for (openvdb::Index i = 0; i < Leaf::SIZE; i++)
            values[i] = leaf.getValue(i);
    }

    static void load_from_file(const Leaf &leaf, Stream &stream, Value *values)
    {
        auto *info = TestLeaf::file_info(leaf);
        if (!stream.stream) {
            stream.buffer = info->mapping->createBuffer();
            stream.stream = std::make_unique<std::istream>(stream.buffer.get());
            openvdb::io::setStreamMetadataPtr(*stream.stream, info->meta, /*transfer=*/true);
            stream.stream->exceptions(std::ios::failbit | std::ios::badbit);
        }
        stream.stream->clear();
        stream.stream->seekg(info->bufpos);
        openvdb::io::readCompressedValues(*stream.stream, values, Leaf::SIZE, leaf.valueMask(),
                                          openvdb::io::getHalfFloat(*stream.stream));
    }

    typename Grid::Ptr grid_;
    int component_;
    bool rest_;
};

// The volume of a grid of the first of these types that it has.
template <class Grid, class... Others>
std::unique_ptr<Volume> cast_grid(const openvdb::GridBase::Ptr &grid, int component, bool rest)
{
    if (typename Grid::Ptr typed = openvdb::gridPtrCast<Grid>(grid))
        return std::make_unique<TypedVolume<Grid>>(typed, component, rest);
    if constexpr (sizeof...(Others) > 0)
        return cast_grid<Others...>(grid, component, rest);
    return nullptr;
}

} // namespace

std::unique_ptr<Volume> make_volume(const openvdb::GridBase::Ptr &grid, int component, bool rest)
{
    using namespace openvdb;
    std::unique_ptr<Volume> volume;
    if (grid)
        volume =
            cast_grid<FloatGrid, DoubleGrid, Int32Grid, BoolGrid, Vec3SGrid, Vec3DGrid, Vec3IGrid>(
                grid, component, rest);
    if (!volume)
        fail(WEFT_ERR_FORMAT, "the grid is not of the type that the file's table gives");
    return volume;
}

} // namespace weft
