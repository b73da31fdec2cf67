// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/readers/vdb_tree.h"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <new>

#include "tiles/readers/vdb_nodes.h"
#include "tiles/volume/region.h"

namespace weft
{

void append(weft_server *server, const void *data, size_t size)
{
    if (!weft_server_append(server, data, size))
        throw Failure{static_cast<weft_result>(server->answer.result), server->answer.message};
}

namespace
{

bool comes_before(const Coord &a, const Coord &b)
{
    for (size_t i = 2; i > 0; i--)
        if (a[i] != b[i])
            return a[i] < b[i];
    return a[0] < b[0];
}

// The box of all active voxels, and how many they are.
struct Survey {
    Coord low{INT32_MAX, INT32_MAX, INT32_MAX}, high{INT32_MIN, INT32_MIN, INT32_MIN};
    uint64_t voxels = 0;

    void add_box(const Coord &first, const Coord &last)
    {
        for (size_t i = 0; i < 3; i++) {
            low[i] = std::min(low[i], first[i]);
            high[i] = std::max(high[i], last[i]);
        }
    }

    void add_cube(const Coord &origin, int32_t size)
    {
        const auto side = static_cast<uint64_t>(size);
        voxels += side * side * side;
        add_box(origin, {origin[0] + size - 1, origin[1] + size - 1, origin[2] + size - 1});
    }

    // A word for each x, a byte in it for each y, a bit in that for each z.
    void add_leaf(const Coord &origin, const unsigned char *active)
    {
        int first = 8, last = -1;
        uint64_t any = 0;
        for (int x = 0; x < 8; x++) {
            uint64_t word;
            memcpy(&word, active + 8 * x, sizeof word);
            if (!word)
                continue;
            voxels += static_cast<uint64_t>(__builtin_popcountll(word));
            any |= word;
            first = std::min(first, x);
            last = x;
        }
        if (!any)
            return;
        uint32_t z = 0;
        for (int y = 0; y < 8; y++)
            z |= any >> 8 * y & 0xff;
        const int y_first = __builtin_ctzll(any) / 8, y_last = 7 - __builtin_clzll(any) / 8;
        const int z_first = __builtin_ctz(z), z_last = 31 - __builtin_clz(z);
        add_box({origin[0] + first, origin[1] + y_first, origin[2] + z_first},
                {origin[0] + last, origin[1] + y_last, origin[2] + z_last});
    }
};

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

// A stored value as a float, or what that lacks of it.
template <class Value> float part_of(Value value, bool rest)
{
    float rounded = static_cast<float>(value);
    if (!rest)
        return rounded;
    double lack = static_cast<double>(value) - static_cast<double>(rounded);
    return std::isfinite(lack) ? static_cast<float>(lack) : 0;
}

template <class Value> class TypedVolume : public Volume
{
  public:
    TypedVolume(const Cursor &cursor, const Coding &coding, const std::string &delayed, bool rest)
        : cursor_(cursor), coding_(coding), rest_(rest),
          nodes_(read_nodes<Value>(cursor, coding, delayed))
    {
    }

    void describe_tree(weft_volume_info *info) const override
    {
        Survey survey;
        for (const LowerNode &node : nodes_.lower)
            each_leaf(node, [&](const Coord &origin, size_t, const unsigned char *active) {
                survey.add_leaf(origin, active);
            });
        for (const Tile<Value> &tile : nodes_.tiles)
            if (tile.active)
                survey.add_cube(tile.origin, tile.size);
        info->background = part_of(nodes_.background, rest_);
        info->active_voxels = survey.voxels;
        info->bricks = nodes_.leaf.size();
        info->memory_bytes = info->bricks * WEFT_BRICK_VOXELS * sizeof(float);
        info->empty = survey.voxels == 0;
        for (size_t i = 0; i < 3; i++) {
            info->active_min[i] = info->empty ? 0 : survey.low[i];
            info->active_max[i] = info->empty ? 0 : survey.high[i];
        }
        info->counted = true;
        if constexpr (std::is_same_v<Value, double> || std::is_same_v<Value, int32_t>)
            count_values(info);
    }

    void find(weft_server *server, const weft_region &region) const override
    {
        std::vector<Coord> bricks;
        for (const UpperNode &node : nodes_.upper)
            if (weft_region_meets(&region, node.origin.data(), 4096))
                find_in(node, region, bricks);
        std::sort(bricks.begin(), bricks.end(), comes_before);
        const std::vector<weft_volume_tile> tiles = find_tiles(region);
        append(server, bricks.data(), bricks.size() * sizeof(Coord));
        append(server, tiles.data(), tiles.size() * sizeof(weft_volume_tile));
        server->answer.count[0] = bricks.size();
        server->answer.count[1] = tiles.size();
    }

    void read(weft_server *server, const int32_t (*origin)[3], size_t count) const override
    {
        constexpr size_t batch = 64;
        std::vector<float> values(batch * WEFT_BRICK_VOXELS);
        for (size_t done = 0; done < count;) {
            const size_t n = std::min(batch, count - done);
            for (size_t i = 0; i < n; i++) {
                const int32_t *at = origin[done + i];
                read_brick({at[0], at[1], at[2]}, &values[i * WEFT_BRICK_VOXELS]);
            }
            append(server, values.data(), n * WEFT_BRICK_VOXELS * sizeof(float));
            done += n;
        }
        server->answer.count[0] = count;
    }

  private:
    // Calls visit(origin, index, mask of active voxels) for each leaf of a node.
    template <class Visit> void each_leaf(const LowerNode &node, Visit visit) const
    {
        size_t rank = 0;
        node.leaves.each([&](uint32_t n) {
            visit(origin_of<4, 3>(node.origin, n), node.first_leaf + rank,
                  cursor_.bytes_at(node.masks + rank * LEAF_MASK_BYTES));
            rank++;
        });
    }

    void find_in(const UpperNode &upper, const weft_region &region,
                 std::vector<Coord> &bricks) const
    {
        for (uint32_t i = 0; i < upper.lower.count; i++) {
            const LowerNode &node = nodes_.lower[upper.first_lower + i];
            if (!weft_region_meets(&region, node.origin.data(), 128))
                continue;
            node.leaves.each([&](uint32_t n) {
                const Coord origin = origin_of<4, 3>(node.origin, n);
                if (weft_region_meets(&region, origin.data(), WEFT_BRICK_SIZE))
                    bricks.push_back(origin);
            });
        }
    }

    std::vector<weft_volume_tile> find_tiles(const weft_region &region) const
    {
        std::vector<weft_volume_tile> found;
        for (const Tile<Value> &tile : nodes_.tiles) {
            const Coord &at = tile.origin;
            if (weft_region_meets(&region, at.data(), tile.size))
                found.push_back({{at[0], at[1], at[2]}, tile.size, part_of(tile.value, rest_)});
        }
        std::sort(found.begin(), found.end(),
                  [](const weft_volume_tile &a, const weft_volume_tile &b) {
                      return comes_before({a.origin[0], a.origin[1], a.origin[2]},
                                          {b.origin[0], b.origin[1], b.origin[2]});
                  });
        return found;
    }

    // Reads all voxels once. Damaged bricks are told when they are asked for.
    void count_values(weft_volume_info *info) const
    {
        for (const Tile<Value> &tile : nodes_.tiles)
            count_value(tile.value, info);
        count_value(nodes_.background, info);
        for (const LowerNode &node : nodes_.lower)
            each_leaf(node, [&](const Coord &, size_t index, const unsigned char *active) {
                Value values[LEAF_VOXELS];
                try {
                    read_leaf(index, active, values);
                } catch (const Failure &) {
                    return;
                }
                for (Value value : values)
                    count_value(value, info);
            });
    }

    // The lower node that a voxel lies in; NULL: there is none.
    const LowerNode *find_lower(const Coord &voxel) const
    {
        Coord key = voxel;
        for (int32_t &c : key)
            c &= ~4095;
        auto upper = std::lower_bound(
            nodes_.upper.begin(), nodes_.upper.end(), key,
            [](const UpperNode &node, const Coord &other) { return node.origin < other; });
        const uint32_t place = place_of<5, 7>(voxel);
        if (upper == nodes_.upper.end() || upper->origin != key || !upper->lower.has(place))
            return nullptr;
        return &nodes_.lower[upper->first_lower + upper->lower.rank(place)];
    }

    void read_brick(const Coord &origin, float *out) const
    {
        const LowerNode *node = find_lower(origin);
        const uint32_t place = place_of<4, 3>(origin);
        if (!node || !node->leaves.has(place) || origin_of<4, 3>(node->origin, place) != origin)
            fail(WEFT_ERR_ARGUMENT, "no brick at (%d, %d, %d)", origin[0], origin[1], origin[2]);
        const size_t rank = node->leaves.rank(place);
        Value values[LEAF_VOXELS];
        try {
            read_leaf(node->first_leaf + rank,
                      cursor_.bytes_at(node->masks + rank * LEAF_MASK_BYTES), values);
        } catch (const Failure &failure) {
            fail(failure.result, "the voxels of the brick at (%d, %d, %d) cannot be read: %.200s",
                 origin[0], origin[1], origin[2], failure.text.c_str());
        }
        for (int z = 0; z < 8; z++)
            for (int y = 0; y < 8; y++)
                for (int x = 0; x < 8; x++)
                    *out++ = part_of(values[x << 6 | y << 3 | z], rest_);
    }

    void read_leaf(size_t index, const unsigned char *active, Value *values) const
    {
        Cursor cursor = cursor_;
        cursor.move_to(nodes_.leaf[index]);
        if constexpr (std::is_same_v<Value, bool>) {
            const unsigned char *bits = cursor.take(LEAF_MASK_BYTES);
            for (uint32_t i = 0; i < LEAF_VOXELS; i++)
                values[i] = bit_at(bits, i);
        } else {
            read_values(cursor, coding_, nodes_.background, active, LEAF_VOXELS, buffer_, values);
        }
    }

    const Cursor cursor_;
    const Coding coding_;
    const bool rest_;
    const Nodes<Value> nodes_;
    mutable std::vector<unsigned char> buffer_; // of the leaf that is read
};

} // namespace

std::unique_ptr<Volume> read_volume(const Mapping &file, const GridEntry &grid,
                                    const GridHeader &header, uint64_t starts, bool rest)
{
    const Cursor cursor(file, starts, grid.ends);
    const Coding whole = {header.compression, false}, coding = {header.compression, grid.half};
    const std::string &type = grid.stored_type, &delayed = header.delayed;
    if (type == "Tree_float_5_4_3")
        return std::make_unique<TypedVolume<float>>(cursor, coding, delayed, rest);
    if (type == "Tree_double_5_4_3")
        return std::make_unique<TypedVolume<double>>(cursor, coding, delayed, rest);
    if (type == "Tree_int32_5_4_3")
        return std::make_unique<TypedVolume<int32_t>>(cursor, whole, delayed, rest);
    if (type == "Tree_bool_5_4_3")
        return std::make_unique<TypedVolume<bool>>(cursor, whole, delayed, rest);
    fail(WEFT_ERR_UNSUPPORTED, "the type %.64s is not read", type.c_str());
}

} // namespace weft
