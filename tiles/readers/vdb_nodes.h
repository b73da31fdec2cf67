// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/vdb_nodes.h - the nodes of a VDB tree: a root of nodes of 32^3 nodes of 16^3 leaves
// of 8^3 voxels. Of a leaf nothing is kept but where its values lie in the file.
#ifndef WEFT_TILES_READERS_VDB_NODES_H
#define WEFT_TILES_READERS_VDB_NODES_H

#include <array>
#include <vector>

#include "tiles/readers/vdb_values.h"

namespace weft
{

using Coord = std::array<int32_t, 3>;

enum : uint32_t { LEAF_VOXELS = 512, LEAF_MASK_BYTES = LEAF_VOXELS / 8 };

// Which of a node's places hold a child. Place n of a node with 2^log2 places a side lies at
// (n >> 2 log2, n >> log2, n), each modulo 2^log2.
template <uint32_t log2> struct ChildMask {
    static constexpr uint32_t places = 1u << 3 * log2;

    explicit ChildMask(const unsigned char *bits)
    {
        memcpy(word, bits, sizeof word);
        uint32_t sum = 0;
        for (uint32_t i = 0; i < places / 64; i++) {
            before[i] = static_cast<uint16_t>(sum);
            sum += static_cast<uint32_t>(__builtin_popcountll(word[i]));
        }
        count = sum;
    }

    bool has(uint32_t n) const
    {
        return word[n / 64] >> n % 64 & 1;
    }
    // How many children come before this place.
    uint32_t rank(uint32_t n) const
    {
        const uint64_t below = word[n / 64] & ((UINT64_C(1) << n % 64) - 1);
        return before[n / 64] + static_cast<uint32_t>(__builtin_popcountll(below));
    }
    // Calls visit(place) for each child, in order.
    template <class Visit> void each(Visit visit) const
    {
        for (uint32_t i = 0; i < places / 64; i++)
            for (uint64_t left = word[i]; left; left &= left - 1)
                visit(i * 64 + static_cast<uint32_t>(__builtin_ctzll(left)));
    }

    uint64_t word[places / 64];
    uint16_t before[places / 64];
    uint32_t count;
};

// The place in a node of 2^log2 children a side, each of 2^child voxels, of a voxel in it.
template <uint32_t log2, uint32_t child> uint32_t place_of(const Coord &voxel)
{
    uint32_t place = 0;
    for (int i = 0; i < 3; i++)
        place = place << log2 | (static_cast<uint32_t>(voxel[static_cast<size_t>(i)]) >> child &
                                 ((1u << log2) - 1));
    return place;
}

template <uint32_t log2, uint32_t child> Coord origin_of(const Coord &node, uint32_t place)
{
    Coord origin = node;
    for (size_t i = 0; i < 3; i++)
        origin[i] += static_cast<int32_t>((place >> (2 - i) * log2 & ((1u << log2) - 1)) << child);
    return origin;
}

struct LowerNode {
    Coord origin;
    ChildMask<4> leaves;
    uint64_t masks;    // where its leaves' masks of active voxels lie, one after the other
    size_t first_leaf; // of all leaves
};

struct UpperNode {
    Coord origin;
    ChildMask<5> lower;
    size_t first_lower; // of all lower nodes
};

// A constant cube of a node's size that tells something: it is active, or not the background.
template <class Value> struct Tile {
    Coord origin;
    int32_t size;
    Value value;
    bool active;
};

template <class Value> struct Nodes {
    Value background;
    std::vector<UpperNode> upper; // sorted by x, then y, then z, as leaves' values are stored
    std::vector<LowerNode> lower; // of each upper node one after the other
    std::vector<Tile<Value>> tiles;
    std::vector<uint64_t> leaf; // where each leaf's values start in the file
};

// Reads a tree from where a cursor stands. `delayed`: the value of the grid's delayed-load
// metadata, by which leaves' values are skipped unseen; ignored where it does not fit. Throws
// Failure. Value: float, double, int32_t or bool.
template <class Value>
Nodes<Value> read_nodes(const Cursor &cursor, const Coding &coding, const std::string &delayed);

} // namespace weft

#endif
