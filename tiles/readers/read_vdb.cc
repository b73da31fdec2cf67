// SPDX-License-Identifier: BSD-3-Clause
// weft-read-vdb: grids, trees and voxels of VDB files, by OpenVDB.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <strings.h>
#include <memory>
#include <new>

#include "filter/closest.h"
#include "tiles/process/server.h"
#include "tiles/readers/vdb_file.h"
#include "tiles/readers/vdb_guard.h"
#include "tiles/readers/vdb_tree.h"

using weft::append;
using weft::fail;

namespace
{

unsigned long long wide(uint64_t value)
{
    return value;
}

// Cut texts end in "..."; a cut UTF-8 sequence is left out whole.
template <size_t size> void copy_text(char (&out)[size], const std::string &text)
{
    size_t length = strnlen(text.c_str(), text.size());
    if (length < size) {
        memcpy(out, text.data(), length);
        memset(out + length, 0, size - length);
        return;
    }
    length = size - 4;
    while (length && (text[length] & 0xc0) == 0x80)
        length--;
    memset(out, 0, size);
    memcpy(out, text.data(), length);
    memcpy(out + length, "...", 3);
}

// ---- one grid's description ---------------------------------------------------------------------

void check_transform(const double m[3][4])
{
    double norm[3], det = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                          m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                          m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    bool finite = std::isfinite(m[0][3]) && std::isfinite(m[1][3]) && std::isfinite(m[2][3]);
    for (int c = 0; c < 3; c++)
        norm[c] = std::hypot(m[0][c], m[1][c], m[2][c]);
    double relative = std::fabs(det) / norm[0] / norm[1] / norm[2];
    if (finite && std::isfinite(det) && relative > 1e-12)
        return;
    fail(WEFT_ERR_FORMAT, "the transform is %s: (%g %g %g %g) (%g %g %g %g) (%g %g %g %g)",
         finite && std::isfinite(det) ? "singular" : "not finite", m[0][0], m[0][1], m[0][2],
         m[0][3], m[1][0], m[1][1], m[1][2], m[1][3], m[2][0], m[2][1], m[2][2], m[2][3]);
}

// By the map's derivative, since OpenVDB takes affine matrices of small voxels for singular ones.
void read_transform(const openvdb::GridBase &grid, double m[3][4])
{
    if (!grid.transform().isLinear())
        fail(WEFT_ERR_UNSUPPORTED, "the grid has a frustum transform, not an affine one");
    openvdb::math::MapBase::ConstPtr map = grid.transform().baseMap();
    openvdb::Vec3d origin = map->applyMap(openvdb::Vec3d(0));
    for (int c = 0; c < 3; c++) {
        openvdb::Vec3d unit(0), column;
        unit[c] = 1;
        column = map->applyJacobian(unit);
        for (int r = 0; r < 3; r++)
            m[r][c] = column[r];
    }
    for (int r = 0; r < 3; r++)
        m[r][3] = origin[r];
}

void check_entry(const weft::GridEntry &entry)
{
    if (!entry.problem.empty())
        fail(WEFT_ERR_FORMAT, "%s", entry.problem.c_str());
    if (!entry.listed_type)
        fail(WEFT_ERR_UNSUPPORTED,
             "the type %.64s is none of float, double, half, int32, bool, vec3s, vec3d and vec3i",
             entry.type.c_str());
}

// A staggered grid's component c lies on the lower face of its cell across c.
void move_to_face(const openvdb::GridBase &grid, int component, double m[3][4])
{
    if (grid.getGridClass() != openvdb::GRID_STAGGERED)
        return;
    for (int r = 0; r < 3; r++)
        m[r][3] -= 0.5 * m[r][component];
}

// What the writing program claimed; a tree that is read tells the truth.
void read_claims(const openvdb::GridBase &grid, weft_volume_info *info)
{
    auto count = grid.getMetadata<openvdb::Int64Metadata>(openvdb::GridBase::META_FILE_VOXEL_COUNT);
    auto low = grid.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MIN);
    auto high = grid.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MAX);
    info->empty = !count || count->value() <= 0;
    info->counted = info->empty ? count && !count->value() : low && high;
    if (info->empty)
        return;
    info->active_voxels = static_cast<uint64_t>(count->value());
    for (int i = 0; low && high && i < 3; i++) {
        info->active_min[i] = low->value()[i];
        info->active_max[i] = high->value()[i];
    }
}

std::vector<weft_metadata> read_metadata(const openvdb::GridBase &grid)
{
    std::vector<weft_metadata> all;
    for (auto it = grid.beginMeta(); it != grid.endMeta(); ++it) {
        if (!it->second)
            continue;
        weft_metadata entry;
        copy_text(entry.key, it->first);
        copy_text(entry.value, it->second->str());
        all.push_back(entry);
    }
    return all;
}

weft_volume_info describe(const weft::GridEntry &entry)
{
    weft_volume_info info;
    memset(&info, 0, sizeof info);
    copy_text(info.name, entry.label);
    copy_text(info.type, entry.type);
    copy_text(info.grid_class, "unknown");
    info.components = entry.components;
    info.rounded = entry.type == "double" || entry.type == "vec3d";
    info.background = NAN;
    info.empty = true;
    std::fill_n(&info.index_to_world[0][0], 12, NAN);
    return info;
}

void append_grid(weft_server *server, weft_volume_info info,
                 const std::vector<weft_metadata> &metadata)
{
    weft_wire_grid wire;
    memset(&wire, 0, sizeof wire);
    info.metadata = nullptr;
    info.metadata_count = metadata.size();
    memcpy(&wire.info, &info, sizeof info);
    append(server, &wire, sizeof wire);
    append(server, metadata.data(), metadata.size() * sizeof metadata[0]);
}

// ---- the file -----------------------------------------------------------------------------------

struct Reader {
    std::unique_ptr<weft::VdbFile> file;
    std::unique_ptr<weft::Volume> volume;
};

void open_file(weft_server *server, Reader *reader)
{
    if (reader->file)
        return;
    if (!weft::guard_is_complete())
        fail(WEFT_ERR_READER, "this libopenvdb is not the one that the reader was built for");
    reader->file = std::make_unique<weft::VdbFile>(server->input_fd, server->limits.memory_bytes);
}

// What is thrown now, as a result and a text of its reason.
weft::Failure reason(const weft_server *server)
{
    try {
        throw;
    } catch (const weft::Failure &failure) {
        return failure;
    } catch (const std::bad_alloc &) {
        return {WEFT_ERR_LIMIT, "more memory is needed than the limit of " +
                                    std::to_string(server->limits.memory_bytes) + " bytes"};
    } catch (const std::exception &error) {
        return {WEFT_ERR_FORMAT, std::string("OpenVDB says: ") + error.what()};
    } catch (...) {
        return {WEFT_ERR_FORMAT, "OpenVDB failed without a reason"};
    }
}

void list_grid(weft_server *server, Reader *reader, const weft::GridEntry &entry)
{
    weft_volume_info info = describe(entry);
    std::vector<weft_metadata> metadata;
    try {
        openvdb::GridBase::Ptr grid = reader->file->read_header(entry);
        copy_text(info.grid_class, openvdb::GridBase::gridClassToString(grid->getGridClass()));
        metadata = read_metadata(*grid);
        read_claims(*grid, &info);
        read_transform(*grid, info.index_to_world);
        check_entry(entry);
        check_transform(info.index_to_world);
        info.supported = true;
    } catch (...) {
        weft::Failure failure = reason(server);
        info.result = entry.problem.empty() ? failure.result : WEFT_ERR_FORMAT;
        copy_text(info.problem, entry.problem.empty() ? failure.text : entry.problem);
    }
    append_grid(server, info, metadata);
}

void list_grids(weft_server *server, Reader *reader)
{
    open_file(server, reader);
    for (const weft::GridEntry &entry : reader->file->entries())
        list_grid(server, reader, entry);
    server->answer.count[0] = reader->file->entries().size();
}

// Labels are unique; beside them goes what the file has, and "density" also means "density[0]".
const weft::GridEntry *find_grid(const Reader &reader, const std::string &name)
{
    const std::vector<weft::GridEntry> &entries = reader.file->entries();
    auto find = [&](auto test) {
        auto found = std::find_if(entries.begin(), entries.end(), test);
        return found == entries.end() ? nullptr : &*found;
    };
    using Entry = const weft::GridEntry &;
    const weft::GridEntry *found = find([&](Entry entry) { return entry.label == name; });
    if (!found)
        found = find([&](Entry entry) { return entry.name == name || entry.unique_name == name; });
    if (!found)
        found = find([&](Entry entry) { return entry.name == name + "[0]"; });
    return found;
}

std::string all_names(const Reader &reader)
{
    std::string names;
    for (const weft::GridEntry &entry : reader.file->entries())
        names += (names.empty() ? "'" : ", '") + entry.label + "' (" + entry.type + ")";
    return names.empty() ? "no grids" : names;
}

// What was meant, if it is near: capitals and small letters differ in names of grids.
std::string suggestion(const Reader &reader, const std::string &name)
{
    std::vector<const char *> names;
    for (const weft::GridEntry &entry : reader.file->entries())
        names.push_back(entry.label.c_str());
    names.push_back(nullptr);
    const char *meant = weft_closest_find(name.c_str(), name.size(), names.data());
    if (!meant)
        return "";
    const bool capitals = strcasecmp(meant, name.c_str()) == 0;
    return std::string("; did you mean '") + meant + (capitals ? "'? capitals count" : "'?");
}

const weft::GridEntry &choose_grid(const Reader &reader, const std::string *name)
{
    if (name) {
        const weft::GridEntry *found = find_grid(reader, *name);
        if (!found)
            fail(WEFT_ERR_ARGUMENT, "no grid '%.64s'; the file has %.300s%s", name->c_str(),
                 all_names(reader).c_str(), suggestion(reader, *name).c_str());
        return *found;
    }
    for (int components : {1, 3})
        for (const weft::GridEntry &entry : reader.file->entries())
            if (entry.listed_type && entry.components == components)
                return entry;
    fail(WEFT_ERR_UNSUPPORTED, "no grid of numbers; the file has %.300s",
         all_names(reader).c_str());
}

void load_grid(weft_server *server, Reader *reader, const weft::GridEntry &entry)
{
    weft_volume_info info = describe(entry);
    info.component = static_cast<int>(server->request->component);
    check_entry(entry);
    if (info.component < 0 || info.component >= info.components)
        fail(WEFT_ERR_ARGUMENT, "no component %d: a grid of %s has %d", info.component, info.type,
             info.components);
    // The transform first: it is cheap, and decides whether the tree is wanted.
    openvdb::GridBase::Ptr grid = reader->file->read_header(entry);
    read_transform(*grid, info.index_to_world);
    check_transform(info.index_to_world);
    grid = reader->file->read_grid(entry);
    if (info.components > 1)
        move_to_face(*grid, info.component, info.index_to_world);
    reader->volume = weft::make_volume(grid, info.component, server->request->rest);
    info.supported = true;
    copy_text(info.grid_class, openvdb::GridBase::gridClassToString(grid->getGridClass()));
    reader->volume->describe_tree(&info);
    append_grid(server, info, read_metadata(*grid));
    server->answer.count[0] = 1;
}

void open_grid(weft_server *server, Reader *reader)
{
    open_file(server, reader);
    std::string name;
    if (server->request->payload_bytes)
        name.assign(static_cast<const char *>(server->request_payload),
                    server->request->payload_bytes - 1);
    const weft::GridEntry &entry =
        choose_grid(*reader, server->request->payload_bytes ? &name : nullptr);
    try {
        load_grid(server, reader, entry);
    } catch (...) {
        weft::Failure failure = reason(server);
        fail(failure.result, "grid '%.100s': %s", entry.label.c_str(), failure.text.c_str());
    }
}

void find_bricks(weft_server *server, Reader *reader)
{
    weft_region region;
    if (server->request->payload_bytes != sizeof region)
        fail(WEFT_ERR_READER, "a request for bricks without a region");
    memcpy(&region, server->request_payload, sizeof region);
    reader->volume->find(server, region);
}

void read_bricks(weft_server *server, Reader *reader)
{
    constexpr uint64_t origin_bytes = sizeof(int32_t[3]);
    constexpr uint64_t brick_bytes = WEFT_BRICK_VOXELS * sizeof(float);
    uint64_t count = server->request->payload_bytes / origin_bytes;
    if (count > server->limits.output_bytes / brick_bytes)
        fail(WEFT_ERR_LIMIT, "%llu bricks have %llu bytes, the output limit is %llu", wide(count),
             wide(count * brick_bytes), wide(server->limits.output_bytes));
    reader->volume->read(server, static_cast<const int32_t(*)[3]>(server->request_payload),
                         static_cast<size_t>(count));
}

void dispatch(weft_server *server, Reader *reader)
{
    uint32_t op = server->request->op;
    if (!reader->volume && (op == WEFT_WIRE_FIND || op == WEFT_WIRE_READ))
        fail(WEFT_ERR_ARGUMENT, "no grid is open");
    switch (op) {
    case WEFT_WIRE_LIST:
        return list_grids(server, reader);
    case WEFT_WIRE_OPEN:
        return open_grid(server, reader);
    case WEFT_WIRE_FIND:
        return find_bricks(server, reader);
    case WEFT_WIRE_READ:
        return read_bricks(server, reader);
    default:
        fail(WEFT_ERR_ARGUMENT, "a VDB reader cannot do operation %u", op);
    }
}

weft_result handle(weft_server *server)
{
    try {
        dispatch(server, static_cast<Reader *>(server->priv));
        return WEFT_OK;
    } catch (...) {
        weft::Failure failure = reason(server);
        return weft_server_fail(server, failure.result, "%s", failure.text.c_str());
    }
}

} // namespace

int main(int argc, char **argv)
{
    // Delayed loading is what keeps voxels out of memory until they are asked for.
    unsetenv("OPENVDB_DISABLE_DELAYED_LOAD");
    openvdb::initialize();
    static Reader reader;
    return weft_server_run(argc, argv, handle, &reader);
}
