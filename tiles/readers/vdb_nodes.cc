// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/readers/vdb_nodes.h"

#include <algorithm>
#include <memory>
#include <set>

#include "tiles/volume/volume.h"

namespace weft
{

namespace
{

// ---- delayed-load metadata ----------------------------------------------------------------------

// Of every leaf the kind of its values, and how many bytes its chunk and the length of that have.
struct Delayed {
    std::vector<unsigned char> kind;
    std::vector<uint64_t> bytes;
};

// 0 and the elements as they are, or the length of what Blosc made of them.
template <class Element> std::vector<Element> take_array(Cursor &cursor, size_t count)
{
    const size_t size = count * sizeof(Element);
    const uint32_t packed = cursor.get<uint32_t>();
    const unsigned char *data = cursor.take(packed ? packed : size);
    std::vector<Element> all(count);
    if (packed)
        unpack_blosc(data, packed, all.data(), size);
    else if (size)
        memcpy(all.data(), data, size);
    return all;
}

// Empty where it is not of so many leaves.
Delayed read_delayed(const std::string &bytes, size_t leaves)
{
    try {
        Cursor cursor(reinterpret_cast<const unsigned char *>(bytes.data()), 0, bytes.size());
        if (cursor.get<uint32_t>() != leaves)
            return {};
        Delayed delayed;
        delayed.kind = take_array<unsigned char>(cursor, leaves);
        delayed.bytes = take_array<uint64_t>(cursor, leaves);
        return delayed;
    } catch (const Failure &) {
        return {};
    }
}

// ---- the tree -----------------------------------------------------------------------------------

template <class Value> class Builder
{
  public:
    Builder(const Cursor &cursor, const Coding &coding)
        : cursor_(cursor), coding_(coding), values_(new Value[ChildMask<5>::places])
    {
    }

    Nodes<Value> run(const std::string &delayed)
    {
        read_root();
        // Values follow in the order of the keys, whatever that of the nodes was.
        std::sort(nodes_.upper.begin(), nodes_.upper.end(),
                  [](const UpperNode &a, const UpperNode &b) { return a.origin < b.origin; });
        if (coding_.compression & (COMPRESS_BLOSC | COMPRESS_ZIP))
            delayed_ = read_delayed(delayed, leaf_count_);
        nodes_.leaf.reserve(leaf_count_);
        for (const UpperNode &upper : nodes_.upper)
            for (uint32_t i = 0; i < upper.lower.count; i++)
                place_leaves(nodes_.lower[upper.first_lower + i]);
        return std::move(nodes_);
    }

  private:
    void read_root()
    {
        cursor_.skip(sizeof(int32_t)); // how many trees of values, always 1
        nodes_.background = take_value<Value>(cursor_);
        const uint32_t tiles = cursor_.get<uint32_t>(), children = cursor_.get<uint32_t>();
        for (uint32_t i = 0; i < tiles; i++) {
            const Coord origin = take_origin();
            const Value value = take_value<Value>(cursor_);
            add_tile(origin, 4096, value, cursor_.get<unsigned char>() != 0);
        }
        for (uint32_t i = 0; i < children; i++)
            read_upper(take_origin());
    }

    // All other coordinates are derived from these.
    Coord take_origin()
    {
        const Coord key = cursor_.get<Coord>();
        for (int32_t c : key) {
            if (c % 4096 != 0)
                fail(WEFT_ERR_FORMAT, "a node at (%d, %d, %d), which is not a multiple of 4096",
                     key[0], key[1], key[2]);
            if (c < -WEFT_INDEX_LIMIT || c >= WEFT_INDEX_LIMIT)
                fail(WEFT_ERR_LIMIT, "a node at (%d, %d, %d); the limit is +-%d", key[0], key[1],
                     key[2], WEFT_INDEX_LIMIT);
        }
        if (!taken_.insert(key).second)
            fail(WEFT_ERR_FORMAT, "two nodes at (%d, %d, %d)", key[0], key[1], key[2]);
        return key;
    }

    void add_tile(const Coord &origin, int32_t size, Value value, bool active)
    {
        const Value background = nodes_.background;
        const bool plain = value == background || (value != value && background != background);
        if (active || !plain)
            nodes_.tiles.push_back({origin, size, value, active});
    }

    // What stands in places that hold children means nothing.
    template <uint32_t log2, uint32_t child>
    void read_tiles(const Coord &node, const ChildMask<log2> &children, const unsigned char *active)
    {
        constexpr uint32_t places = ChildMask<log2>::places;
        read_values(cursor_, coding_, nodes_.background, active, places, buffer_, values_.get());
        for (uint32_t n = 0; n < places; n++)
            if (!children.has(n))
                add_tile(origin_of<log2, child>(node, n), 1 << child, values_[n],
                         bit_at(active, n));
    }

    void read_upper(const Coord &origin)
    {
        const ChildMask<5> lower(cursor_.take(ChildMask<5>::places / 8));
        const unsigned char *active = cursor_.take(ChildMask<5>::places / 8);
        read_tiles<5, 7>(origin, lower, active);
        nodes_.upper.push_back({origin, lower, nodes_.lower.size()});
        lower.each([&](uint32_t n) { read_lower(origin_of<5, 7>(origin, n)); });
    }

    void read_lower(const Coord &origin)
    {
        const ChildMask<4> leaves(cursor_.take(ChildMask<4>::places / 8));
        const unsigned char *active = cursor_.take(ChildMask<4>::places / 8);
        read_tiles<4, 3>(origin, leaves, active);
        nodes_.lower.push_back({origin, leaves, cursor_.at(), 0});
        cursor_.skip(uint64_t{leaves.count} * LEAF_MASK_BYTES);
        leaf_count_ += leaves.count;
    }

    void place_leaves(LowerNode &node)
    {
        node.first_leaf = nodes_.leaf.size();
        for (uint32_t i = 0; i < node.leaves.count; i++) {
            cursor_.skip(LEAF_MASK_BYTES); // the mask again
            if constexpr (std::is_same_v<Value, bool>)
                cursor_.skip(sizeof(Coord));
            nodes_.leaf.push_back(cursor_.at());
            skip_leaf(cursor_.bytes_at(node.masks + uint64_t{i} * LEAF_MASK_BYTES));
        }
    }

    void skip_leaf(const unsigned char *active)
    {
        const size_t index = nodes_.leaf.size() - 1;
        if constexpr (std::is_same_v<Value, bool>) {
            cursor_.skip(LEAF_MASK_BYTES);
        } else if (index >= delayed_.bytes.size()) {
            skip_values<Value>(cursor_, coding_, active, LEAF_VOXELS);
        } else {
            // The kinds are told of masked values only.
            const bool masked = coding_.compression & COMPRESS_ACTIVE_MASK;
            const NodeKind kind = masked ? check_kind(delayed_.kind[index]) : NODE_ALL_VALUES;
            cursor_.skip(1 + bytes_before_chunk<Value>(kind, LEAF_VOXELS));
            if (has_chunk(coding_, count_stored(coding_, kind, active, LEAF_VOXELS)))
                cursor_.skip(delayed_.bytes[index]);
        }
    }

    Cursor cursor_;
    const Coding coding_;
    Nodes<Value> nodes_;
    std::set<Coord> taken_; // the root's keys
    size_t leaf_count_ = 0;
    Delayed delayed_;
    std::vector<unsigned char> buffer_;
    std::unique_ptr<Value[]> values_; // of the node that is read
};

} // namespace

template <class Value>
Nodes<Value> read_nodes(const Cursor &cursor, const Coding &coding, const std::string &delayed)
{
    return Builder<Value>(cursor, coding).run(delayed);
}

template Nodes<float> read_nodes(const Cursor &, const Coding &, const std::string &);
template Nodes<double> read_nodes(const Cursor &, const Coding &, const std::string &);
template Nodes<int32_t> read_nodes(const Cursor &, const Coding &, const std::string &);
template Nodes<bool> read_nodes(const Cursor &, const Coding &, const std::string &);

} // namespace weft
