// SPDX-License-Identifier: BSD-3-Clause
// peer_openvdb IN.vdb OUT.vdb SCALE box|quadratic: the first float grid on another lattice by
// OpenVDB's own tools::resampleToMatch, with all threads: what `weft lattice --scale` is measured
// beside. Prints seconds of reading, resampling and writing, and active voxels and leaves.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <openvdb/openvdb.h>
#include <openvdb/tools/GridTransformer.h>

static double now()
{
    using namespace std::chrono;
    return duration<double>(steady_clock::now().time_since_epoch()).count();
}

static openvdb::FloatGrid::Ptr read_grid(const char *path)
{
    openvdb::io::File file(path);
    file.open(false);
    for (auto name = file.beginName(); name != file.endName(); ++name) {
        auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid(name.gridName()));
        if (grid)
            return grid;
    }
    return nullptr;
}

int main(int argc, char **argv)
{
    if (argc != 5) {
        fprintf(stderr, "usage: %s IN.vdb OUT.vdb SCALE box|quadratic\n", argv[0]);
        return 2;
    }
    openvdb::initialize();
    const double start = now();
    auto source = read_grid(argv[1]);
    if (!source) {
        fprintf(stderr, "%s: no float grid\n", argv[1]);
        return 3;
    }
    const double read = now();
    auto result = openvdb::FloatGrid::create(source->background());
    result->setGridClass(source->getGridClass());
    result->setName(source->getName());
    result->setTransform(source->transform().copy());
    const double step = 1.0 / atof(argv[3]);
    result->transform().preScale(openvdb::Vec3d(step));
    if (strcmp(argv[4], "box") == 0)
        openvdb::tools::resampleToMatch<openvdb::tools::BoxSampler>(*source, *result);
    else
        openvdb::tools::resampleToMatch<openvdb::tools::QuadraticSampler>(*source, *result);
    const double made = now();
    openvdb::io::File file(argv[2]);
    file.write(openvdb::GridCPtrVec{result});
    file.close();
    printf("read %.3f resample %.3f write %.3f active %llu leaves %llu\n", read - start, made - read,
           now() - made, static_cast<unsigned long long>(result->activeVoxelCount()),
           static_cast<unsigned long long>(result->tree().leafCount()));
    return 0;
}
