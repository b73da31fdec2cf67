// SPDX-License-Identifier: BSD-3-Clause
// Writes VDB files of every kind that the reader must tell apart:
//   make_vdb_fixtures FOLDER
// types.vdb: float, double, half, int32, bool, vec3s, two grids of one name and other vectors;
// frustum.vdb;
// zip.vdb, none.vdb: other compressions; far.vdb: beyond the index limit; streamed.vdb: no offsets;
// kinds.vdb: types that are not sliced, transforms, instances, empty and unnamed grids; names.vdb:
// long names and such that a terminal would obey; values.vdb: numbers that no float holds.
#include <fstream>
#include <string>

#include <openvdb/io/Stream.h>
#include "tiles/readers/vdb_trees.h"

namespace
{

using openvdb::Coord;

// The value at (i, j, k) of every fixture: small integers, exact in all types.
// tests/tiles/volume/test_volume.c knows it as well.
int value_at(int i, int j, int k)
{
    return (i * 7 + j * 3 + k) % 50 + 1;
}

template <class Number> Number make_value(int value, Number)
{
    return Number(value);
}

// Component c of vectors is c times 100 more.
template <class Number>
openvdb::math::Vec3<Number> make_value(int value, openvdb::math::Vec3<Number>)
{
    return {Number(value), Number(value + 100), Number(value + 200)};
}

template <class Grid> typename Grid::Ptr make(const std::string &name)
{
    using Value = typename Grid::ValueType;
    auto grid = Grid::create(Value(0));
    for (int i = 0; i < 20; i++)
        for (int j = 0; j < 12; j++)
            for (int k = 0; k < 9; k++)
                grid->tree().setValue(Coord(i, j, k), make_value(value_at(i, j, k), Value()));
    grid->setName(name);
    return grid;
}

void write(const std::string &path, const openvdb::GridPtrVec &grids, uint32_t compression)
{
    openvdb::io::File file(path);
    file.setCompression(compression);
    file.write(grids);
    file.close();
}

openvdb::math::Transform::Ptr affine()
{
    const double rows[] = {0, 0.5, 0, 0, -0.25, 0, 0.125, 0, 0, 0, 2, 0, 10, 20, 30, 1};
    openvdb::Mat4d matrix(rows); // the images of i, j, k and the origin
    return openvdb::math::Transform::createLinearTransform(matrix);
}

template <class Grid> typename Grid::Ptr single(const std::string &name)
{
    auto grid = Grid::create();
    grid->tree().setValueOn(Coord(3, 4, 5));
    grid->setName(name);
    return grid;
}

void write_kinds(const std::string &path, uint32_t compression)
{
    auto vector = make<openvdb::Vec3SGrid>("vector");
    vector->setTransform(affine());
    vector->setGridClass(openvdb::GRID_STAGGERED);
    auto long_integers = make<openvdb::Int64Grid>("int64");
    long_integers->setTransform(affine());
    auto mask = single<openvdb::MaskGrid>("mask");
    auto points = openvdb::GridBase::createGrid("Tree_ptdataidx32_5_4_3");
    points->setName("points");
    points->setTransform(affine());
    auto tiny = make<openvdb::FloatGrid>("tiny voxels");
    tiny->setTransform(openvdb::math::Transform::createLinearTransform(0.123456789));
    auto owner = make<openvdb::FloatGrid>("owner");
    auto instance = owner->copyGrid(); // the tree is shared
    instance->setName("instance");
    instance->setTransform(affine());
    auto tiles = openvdb::FloatGrid::create(1);
    tiles->tree().addTile(1, Coord(8, 16, 24), 7, true);
    tiles->tree().addTile(2, Coord(128, 0, 0), 8, true);
    tiles->setName("tiles");
    auto empty = openvdb::FloatGrid::create(5);
    empty->setName("empty");
    auto narrow = make<openvdb::DoubleGrid>("narrow double");
    narrow->setSaveFloatAsHalf(true);
    write(path,
          {vector, long_integers, mask, points, tiny, owner, instance, tiles, empty, narrow,
           make<openvdb::FloatGrid>(""), make<openvdb::Int32Grid>("")},
          compression);
}

// Of 512 values 256, 200 and 100 are not held by a float, besides the double's background.
void write_values(const std::string &path)
{
    auto integers = openvdb::Int32Grid::create(0);
    auto huge = openvdb::DoubleGrid::create(1e300), tiny = openvdb::DoubleGrid::create(0);
    auto all = openvdb::DoubleGrid::create(0);
    for (int n = 0; n < 512; n++) {
        Coord at(n & 7, n >> 3 & 7, n >> 6);
        integers->tree().setValue(at, 0x1000000 + n); // every second one is odd
        huge->tree().setValue(at, n < 200 ? -1e39 : n == 200 ? 3.4028235e38 : n);
        tiny->tree().setValue(at, n < 100 ? 1e-39 : n == 100 ? 0x1p-126 : -0.5);
        all->tree().setValue(at, 1e300);
    }
    integers->tree().setValue(Coord(100, 0, 0), -2147483647);
    integers->setName("integers");
    huge->setName("huge");
    tiny->setName("tiny");
    all->setName("all");
    write(path, {integers, huge, tiny, all}, openvdb::io::COMPRESS_NONE);
}

void write_names(const std::string &path)
{
    const std::string hostile = "\x1b]0;owned\x07\x1b[31m\n\xc2\x9b"
                                "2Jweft: error: \xff\xe2\x80\xae";
    std::string long_name(300, 'n');
    auto first = make<openvdb::FloatGrid>(long_name + "1"),
         second = single<openvdb::FloatGrid>(long_name + "2");
    auto bad = make<openvdb::FloatGrid>(hostile),
         like = single<openvdb::FloatGrid>(hostile + "\x02");
    bad->insertMeta(hostile, openvdb::StringMetadata(hostile));
    bad->insertMeta("class", openvdb::StringMetadata(hostile));
    auto longest = single<openvdb::BoolGrid>(std::string(70000, 'm'));
    write(path, {first, second, bad, like, longest}, openvdb::io::COMPRESS_NONE);
}

} // namespace

int main(int argc, char **argv)
{
    if (argc != 2)
        return 2;
    openvdb::initialize();
    const std::string folder = std::string(argv[1]) + "/";
    const uint32_t mask = openvdb::io::COMPRESS_ACTIVE_MASK;

    auto half = make<openvdb::FloatGrid>("half");
    half->setSaveFloatAsHalf(true);
    auto vector_half = make<openvdb::Vec3DGrid>("vec3h");
    vector_half->setSaveFloatAsHalf(true);
    auto first = make<openvdb::FloatGrid>("twin"), second = make<openvdb::FloatGrid>("twin");
    second->insertMeta("note", openvdb::StringMetadata(std::string(1000, 'x')));
    openvdb::GridPtrVec grids = {make<openvdb::Vec3SGrid>("vec3s"),
                                 make<openvdb::FloatGrid>("float"),
                                 make<openvdb::DoubleGrid>("double"),
                                 half,
                                 make<openvdb::Int32Grid>("int32"),
                                 make<openvdb::BoolGrid>("bool"),
                                 first,
                                 second,
                                 make<openvdb::Int64Grid>("int64"),
                                 make<openvdb::Vec3DGrid>("vec3d"),
                                 vector_half,
                                 make<openvdb::Vec3IGrid>("vec3i")};
    write(folder + "types.vdb", grids, openvdb::io::COMPRESS_BLOSC | mask);
    write(folder + "zip.vdb", grids, openvdb::io::COMPRESS_ZIP | mask);
    write(folder + "none.vdb", grids, openvdb::io::COMPRESS_NONE);

    auto frustum = make<openvdb::FloatGrid>("float");
    frustum->setTransform(openvdb::math::Transform::createFrustumTransform(
        openvdb::BBoxd(openvdb::Vec3d(0), openvdb::Vec3d(20)), 0.5, 10));
    write(folder + "frustum.vdb", {frustum}, mask);

    auto far = openvdb::FloatGrid::create();
    far->tree().setValue(Coord(1 << 30, 0, 0), 1);
    far->setName("far");
    write(folder + "far.vdb", {far}, mask);

    write_kinds(folder + "kinds.vdb", openvdb::io::COMPRESS_BLOSC | mask);
    write_values(folder + "values.vdb");
    write_names(folder + "names.vdb");

    std::ofstream stream(folder + "streamed.vdb", std::ios::binary);
    openvdb::io::Stream(stream).write(openvdb::GridCPtrVec{make<openvdb::FloatGrid>("float")});
    return 0;
}
