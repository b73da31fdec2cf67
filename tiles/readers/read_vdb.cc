// SPDX-License-Identifier: BSD-3-Clause
// weft-read-vdb: grids, trees and voxels of VDB files. It does so itself: to load libopenvdb takes
// 40 ms, since that has 70000 symbols with names of 300 letters to be found, and it trusts files.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <new>

#include "tiles/readers/vdb_tree.h"

using weft::append;
using weft::fail;

namespace
{

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

// Returns where the tree starts.
uint64_t read_index_to_world(const weft::Mapping &file, const weft::GridEntry &entry,
                             const weft::GridHeader &header, weft_volume_info *info)
{
    const weft::Transform transform = weft::read_transform(file, entry, header);
    if (!transform.affine)
        fail(WEFT_ERR_UNSUPPORTED, "the grid has a frustum transform, not an affine one");
    memcpy(info->index_to_world, transform.index_to_world, sizeof info->index_to_world);
    return transform.ends;
}

void check_entry(const weft::GridEntry &entry)
{
    if (!entry.problem.empty())
        fail(WEFT_ERR_FORMAT, "%s", entry.problem.c_str());
    if (!entry.listed_type)
        fail(WEFT_ERR_UNSUPPORTED, "the type %.64s is none of float, double, half, int32 and bool",
             entry.type.c_str());
}

// A value of metadata that has this type; false: there is none.
template <class T>
bool get_metadata(const weft::GridHeader &header, const char *key, const char *type, T *out)
{
    const weft::MetadataEntry *entry = weft::find_metadata(header, key, type);
    if (entry)
        memcpy(out, entry->value.data(), sizeof *out);
    return entry != nullptr;
}

// What the writing program claimed; a tree that is read tells the truth.
void read_claims(const weft::GridHeader &header, weft_volume_info *info)
{
    int64_t count = 0;
    int32_t low[3], high[3];
    const bool known = get_metadata(header, "file_voxel_count", "int64", &count);
    const bool boxed = get_metadata(header, "file_bbox_min", "vec3i", &low) &&
                       get_metadata(header, "file_bbox_max", "vec3i", &high);
    info->empty = count <= 0;
    info->counted = info->empty ? known && !count : boxed;
    if (info->empty)
        return;
    info->active_voxels = static_cast<uint64_t>(count);
    for (int i = 0; boxed && i < 3; i++) {
        info->active_min[i] = low[i];
        info->active_max[i] = high[i];
    }
}

// One of OpenVDB's classes, whose letters and spaces around may be any.
void read_class(const weft::GridHeader &header, weft_volume_info *info)
{
    const weft::MetadataEntry *entry = weft::find_metadata(header, "class", "string");
    constexpr char spaces[] = " \f\n\r\t\v";
    std::string text = entry ? entry->value : "";
    text.erase(text.find_last_not_of(spaces) + 1);
    text.erase(0, std::min(text.find_first_not_of(spaces), text.size()));
    for (char &c : text)
        c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    for (const char *known : {"level set", "fog volume", "staggered"})
        if (text == known)
            copy_text(info->grid_class, known);
}

std::vector<weft_metadata> format_metadata(const weft::GridHeader &header)
{
    std::vector<weft_metadata> all;
    for (const weft::MetadataEntry &stored : header.metadata) {
        weft_metadata entry;
        copy_text(entry.key, stored.key);
        copy_text(entry.value, weft::metadata_text(stored));
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
    std::unique_ptr<weft::Mapping> file;
    std::vector<weft::GridEntry> entries;
    std::unique_ptr<weft::Volume> volume;
};

void open_file(weft_server *server, Reader *reader)
{
    if (reader->file)
        return;
    auto file = std::make_unique<weft::Mapping>(server->input_fd, server->limits.memory_bytes);
    reader->entries = weft::scan_file(*file);
    reader->file = std::move(file);
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
        return {WEFT_ERR_READER, error.what()};
    }
}

void list_grid(weft_server *server, Reader *reader, const weft::GridEntry &entry)
{
    weft_volume_info info = describe(entry);
    std::vector<weft_metadata> metadata;
    try {
        const weft::GridHeader header = weft::read_header(*reader->file, entry);
        read_class(header, &info);
        metadata = format_metadata(header);
        read_claims(header, &info);
        read_index_to_world(*reader->file, entry, header, &info);
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
    for (const weft::GridEntry &entry : reader->entries)
        list_grid(server, reader, entry);
    server->answer.count[0] = reader->entries.size();
}

// Labels are unique; beside them goes what the file has, and "density" also means "density[0]".
const weft::GridEntry *find_grid(const Reader &reader, const std::string &name)
{
    const std::vector<weft::GridEntry> &entries = reader.entries;
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
    for (const weft::GridEntry &entry : reader.entries)
        names += (names.empty() ? "'" : ", '") + entry.label + "' (" + entry.type + ")";
    return names.empty() ? "no grids" : names;
}

const weft::GridEntry &choose_grid(const Reader &reader, const std::string *name)
{
    if (name) {
        const weft::GridEntry *found = find_grid(reader, *name);
        if (!found)
            fail(WEFT_ERR_ARGUMENT, "no grid '%.64s'; the file has %.300s", name->c_str(),
                 all_names(reader).c_str());
        return *found;
    }
    for (const weft::GridEntry &entry : reader.entries)
        if (entry.listed_type)
            return entry;
    fail(WEFT_ERR_UNSUPPORTED, "no scalar grid; the file has %.300s", all_names(reader).c_str());
}

// An instance has the tree of another grid.
const weft::GridEntry &tree_owner(const Reader &reader, const weft::GridEntry &entry)
{
    if (entry.parent.empty())
        return entry;
    for (const weft::GridEntry &other : reader.entries)
        if (other.unique_name == entry.parent && other.parent.empty())
            return other;
    fail(WEFT_ERR_FORMAT, "it shares the tree of grid '%.64s', which has none",
         entry.parent.c_str());
}

void load_grid(weft_server *server, Reader *reader, const weft::GridEntry &entry)
{
    weft_volume_info info = describe(entry), owners;
    check_entry(entry);
    // The transform first: it is cheap, and decides whether the tree is wanted.
    const weft::GridHeader header = weft::read_header(*reader->file, entry);
    read_index_to_world(*reader->file, entry, header, &info);
    check_transform(info.index_to_world);
    const weft::GridEntry &owner = tree_owner(*reader, entry);
    check_entry(owner);
    const weft::GridHeader owner_header = weft::read_header(*reader->file, owner);
    const uint64_t starts = read_index_to_world(*reader->file, owner, owner_header, &owners);
    reader->volume =
        weft::read_volume(*reader->file, owner, owner_header, starts, server->request->rest);
    info.supported = true;
    read_class(header, &info);
    reader->volume->describe_tree(&info);
    append_grid(server, info, format_metadata(header));
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
        fail(WEFT_ERR_LIMIT, "%llu bricks have %llu bytes, the output limit is %llu",
             weft::wide(count), weft::wide(count * brick_bytes),
             weft::wide(server->limits.output_bytes));
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
    static Reader reader;
    return weft_server_run(argc, argv, handle, &reader);
}
