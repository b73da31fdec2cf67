// SPDX-License-Identifier: BSD-3-Clause
// Writes VDB files of every kind that the reader must tell apart:
//   make_vdb_fixtures FOLDER
// types.vdb: float, double, half, int32, bool, vec3s and two grids of one name; frustum.vdb;
// zip.vdb, none.vdb: other compressions; far.vdb: beyond the index limit; streamed.vdb: no offsets.
#include <fstream>
#include <string>

#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

namespace
{

using openvdb::Coord;

// The value at (i, j, k) of every fixture: small integers, exact in all types. tests/test_volume.c
// knows it as well.
int value_at(int i, int j, int k)
{
    return (i * 7 + j * 3 + k) % 50 + 1;
}

template <class Grid> typename Grid::Ptr make(const std::string &name)
{
    using Value = typename Grid::ValueType;
    auto grid = Grid::create(Value(0));
    auto accessor = grid->getAccessor();
    for (int i = 0; i < 20; i++)
        for (int j = 0; j < 12; j++)
            for (int k = 0; k < 9; k++)
                accessor.setValue(Coord(i, j, k), Value(value_at(i, j, k)));
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
    auto first = make<openvdb::FloatGrid>("twin"), second = make<openvdb::FloatGrid>("twin");
    second->insertMeta("note", openvdb::StringMetadata(std::string(1000, 'x')));
    openvdb::GridPtrVec grids = {make<openvdb::Vec3SGrid>("vec3s"),
                                 make<openvdb::FloatGrid>("float"),
                                 make<openvdb::DoubleGrid>("double"),
                                 half,
                                 make<openvdb::Int32Grid>("int32"),
                                 make<openvdb::BoolGrid>("bool"),
                                 first,
                                 second};
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

    std::ofstream stream(folder + "streamed.vdb", std::ios::binary);
    openvdb::io::Stream(stream).write(openvdb::GridCPtrVec{make<openvdb::FloatGrid>("float")});
    return 0;
}
