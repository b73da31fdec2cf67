// SPDX-License-Identifier: BSD-3-Clause
// NanoVDB's tri-cubic sampler as a peer: a float grid of all voxels, an accessor per thread. The
// sampler matches values, slopes and mixed derivatives by central differences at the corners of a
// cell, which is Catmull-Rom along each axis; it keeps the last cell's polynomial.
#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/SampleFromVoxels.h>

#include "tests/peers/volumes/peer.h"

namespace
{
struct State {
    peer_job job;
    const nanovdb::FloatGrid *grid;
};

void row(void *priv, int, int y)
{
    const State &s = *static_cast<State *>(priv);
    const peer_job &job = s.job;
    auto accessor = s.grid->getAccessor();
    auto sampler = nanovdb::createSampler<3>(accessor);
    float *out = job.pixels + size_t(y) * size_t(job.width);
    for (int x = 0; x < job.width; x++)
        out[x] = sampler(nanovdb::Vec3d(job.origin[0] + x * job.du[0] + y * job.dv[0],
                                        job.origin[1] + x * job.du[1] + y * job.dv[1],
                                        job.origin[2] + x * job.du[2] + y * job.dv[2]));
}

void run(void *priv)
{
    peer_rows(&static_cast<State *>(priv)->job, row, priv);
}

nanovdb::GridHandle<> build(const peer_job &job)
{
    nanovdb::GridBuilder<float> builder(0.0f);
    const size_t pitch = size_t(job.size[0]), plane = pitch * size_t(job.size[1]);
    builder(
        [&](const nanovdb::Coord &c) {
            return job.box[size_t(c[2]) * plane + size_t(c[1]) * pitch + size_t(c[0])];
        },
        nanovdb::CoordBBox(nanovdb::Coord(0),
                           nanovdb::Coord(job.size[0] - 1, job.size[1] - 1, job.size[2] - 1)));
    return builder.getHandle();
}
} // namespace

int main()
{
    State s;
    peer_load(&s.job);
    nanovdb::GridHandle<> handle;
    try {
        handle = build(s.job);
    } catch (const std::exception &) {
        peer_skip("NanoVDB refused the volume");
    }
    s.grid = handle.grid<float>();
    free(s.job.box);
    s.job.box = nullptr;
    char version[64];
    snprintf(version, sizeof version, "NanoVDB %d.%d.%d", NANOVDB_MAJOR_VERSION_NUMBER,
             NANOVDB_MINOR_VERSION_NUMBER, NANOVDB_PATCH_VERSION_NUMBER);
    return peer_serve(&s.job, version, run, nullptr, &s);
}
