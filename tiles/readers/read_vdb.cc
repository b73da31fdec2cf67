// SPDX-License-Identifier: BSD-3-Clause
// weft-read-vdb: grids, trees and voxels of VDB files, by OpenVDB.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <sys/mman.h>
#include <sys/stat.h>

#include <openvdb/io/io.h>
#include <openvdb/openvdb.h>

#include "tiles/readers/server.h"
#include "tiles/readers/vdb_guard.h"
#include "tiles/readers/vdb_scan.h"
#include "tiles/region.h"

using openvdb::Coord;
using weft::fail;

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

void append(weft_server *server, const void *data, size_t size)
{
    if (!weft_server_append(server, data, size))
        throw weft::Failure{static_cast<weft_result>(server->answer.result),
                            server->answer.message};
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
    check_transform(m);
}

// What the writing program claimed; a tree that is read tells the truth.
void read_claims(const openvdb::GridBase &grid, weft_volume_info *info)
{
    auto count = grid.getMetadata<openvdb::Int64Metadata>(openvdb::GridBase::META_FILE_VOXEL_COUNT);
    auto low = grid.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MIN);
    auto high = grid.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MAX);
    info->empty = !count || count->value() <= 0;
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
        if (!it->second || it->second->typeName() == "__delayedload")
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
    copy_text(info.name, entry.name);
    copy_text(info.type, entry.type);
    copy_text(info.grid_class, "unknown");
    info.background = NAN;
    info.empty = true;
    for (int i = 0; i < 3; i++)
        info.index_to_world[i][i] = 1;
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

// ---- trees --------------------------------------------------------------------------------------

class Volume
{
  public:
    virtual ~Volume() = default;
    virtual void describe_tree(weft_volume_info *info) const = 0;
    virtual void find(weft_server *server, const weft_region &region) const = 0;
    virtual void read(weft_server *server, const int32_t (*origin)[3], size_t count) const = 0;
};

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

struct Finder {
    const weft_region &region;
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
            tiles.push_back({{origin[0], origin[1], origin[2]}, size, static_cast<float>(value)});
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

    explicit TypedVolume(typename Grid::Ptr grid) : grid_(grid)
    {
        check_root(grid_->tree());
    }

    void describe_tree(weft_volume_info *info) const override
    {
        Survey survey;
        Walk<Tree, Survey>::run(grid_->tree(), survey);
        info->background = static_cast<float>(grid_->tree().background());
        info->active_voxels = survey.voxels;
        info->bricks = survey.leaves;
        info->memory_bytes = survey.leaves * WEFT_BRICK_VOXELS * sizeof(float);
        info->empty = survey.voxels == 0;
        for (int i = 0; i < 3; i++) {
            info->active_min[i] = info->empty ? 0 : survey.box.min()[i];
            info->active_max[i] = info->empty ? 0 : survey.box.max()[i];
        }
    }

    void find(weft_server *server, const weft_region &region) const override
    {
        Finder found{region, {}, {}};
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
                    *out++ = static_cast<float>(values[x << 6 | y << 3 | z]);
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
};

template <class Grid> std::unique_ptr<Volume> cast_grid(const openvdb::GridBase::Ptr &grid)
{
    typename Grid::Ptr typed = openvdb::gridPtrCast<Grid>(grid);
    return typed ? std::make_unique<TypedVolume<Grid>>(typed) : nullptr;
}

std::unique_ptr<Volume> make_volume(const openvdb::GridBase::Ptr &grid)
{
    std::unique_ptr<Volume> volume;
    if (grid) {
        volume = cast_grid<openvdb::FloatGrid>(grid);
        volume = volume ? std::move(volume) : cast_grid<openvdb::DoubleGrid>(grid);
        volume = volume ? std::move(volume) : cast_grid<openvdb::Int32Grid>(grid);
        volume = volume ? std::move(volume) : cast_grid<openvdb::BoolGrid>(grid);
    }
    if (!volume)
        fail(WEFT_ERR_FORMAT, "the grid is not of the type that the file's table gives");
    return volume;
}

// ---- the file -----------------------------------------------------------------------------------

struct Reader {
    std::vector<weft::GridEntry> entries;
    std::unique_ptr<openvdb::io::File> file;
    std::unique_ptr<Volume> volume;
};

// OpenVDB maps the file, and would not tell why it cannot.
void check_mapping(const weft_server *server)
{
    struct stat stat;
    if (fstat(server->input_fd, &stat))
        fail(WEFT_ERR_OPEN, "cannot read the file");
    size_t size = static_cast<size_t>(stat.st_size);
    void *data = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, server->input_fd, 0);
    if (data == MAP_FAILED)
        fail(WEFT_ERR_LIMIT, "the file's %llu bytes do not fit into the memory limit of %llu bytes",
             wide(size), wide(server->limits.memory_bytes));
    munmap(data, size);
}

void open_file(weft_server *server, Reader *reader)
{
    if (reader->file)
        return;
    if (!weft::guard_is_complete())
        fail(WEFT_ERR_READER, "this libopenvdb is not the one that the reader was built for");
    reader->entries = weft::scan_file(server->input_fd);
    check_mapping(server);
    auto file =
        std::make_unique<openvdb::io::File>("/proc/self/fd/" + std::to_string(server->input_fd));
    // By default small files are copied to a temporary one, for fear of changes during reading.
    file->setCopyMaxBytes(0);
    file->open(/*delayLoad=*/true);
    reader->file = std::move(file);
}

void list_grid(weft_server *server, Reader *reader, const weft::GridEntry &entry)
{
    weft_volume_info info = describe(entry);
    std::vector<weft_metadata> metadata;
    try {
        openvdb::GridBase::Ptr grid = reader->file->readGridMetadata(entry.name);
        copy_text(info.grid_class, openvdb::GridBase::gridClassToString(grid->getGridClass()));
        metadata = read_metadata(*grid);
        read_claims(*grid, &info);
        read_transform(*grid, info.index_to_world);
        info.supported = entry.listed_type;
    } catch (const std::bad_alloc &) {
        throw;
    } catch (const weft::Failure &) {  // of the transform
    } catch (const std::exception &) { // an unknown type, or damaged
    }
    if (!info.supported)
        for (int i = 0; i < 12; i++)
            info.index_to_world[i / 4][i % 4] = i / 4 == i % 4;
    append_grid(server, info, metadata);
}

void list_grids(weft_server *server, Reader *reader)
{
    open_file(server, reader);
    for (const weft::GridEntry &entry : reader->entries)
        list_grid(server, reader, entry);
    server->answer.count[0] = reader->entries.size();
}

// "density" also means "density[0]".
bool has_name(const weft::GridEntry &entry, const std::string &name)
{
    char shown[sizeof weft_volume_info::name];
    copy_text(shown, entry.name);
    return name == shown || entry.unique_name == name + "\x1e"
                                                        "0";
}

std::string all_names(const Reader &reader)
{
    std::string names;
    for (const weft::GridEntry &entry : reader.entries)
        names += (names.empty() ? "'" : ", '") + entry.name + "' (" + entry.type + ")";
    return names.empty() ? "no grids" : names;
}

const weft::GridEntry &choose_grid(const Reader &reader, const std::string &name)
{
    for (const weft::GridEntry &entry : reader.entries)
        if (name.empty() ? entry.listed_type : has_name(entry, name)) {
            if (!entry.listed_type)
                fail(WEFT_ERR_UNSUPPORTED, "grid '%.64s' has the type %.64s, which is not scalar",
                     entry.name.c_str(), entry.type.c_str());
            return entry;
        }
    if (name.empty())
        fail(WEFT_ERR_UNSUPPORTED, "no scalar grid; the file has %.300s",
             all_names(reader).c_str());
    fail(WEFT_ERR_ARGUMENT, "no grid '%.64s'; the file has %.300s", name.c_str(),
         all_names(reader).c_str());
}

void open_grid(weft_server *server, Reader *reader)
{
    open_file(server, reader);
    const weft::GridEntry &entry = choose_grid(*reader, server->request->name);
    weft_volume_info info = describe(entry);
    // The transform first: it is cheap, and decides whether the tree is wanted.
    openvdb::GridBase::Ptr grid = reader->file->readGridMetadata(entry.name);
    read_transform(*grid, info.index_to_world);
    grid = reader->file->readGrid(entry.name);
    reader->volume = make_volume(grid);
    info.supported = true;
    copy_text(info.grid_class, openvdb::GridBase::gridClassToString(grid->getGridClass()));
    reader->volume->describe_tree(&info);
    append_grid(server, info, read_metadata(*grid));
    server->answer.count[0] = 1;
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
        return reader->volume->find(server, server->request->region);
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
    } catch (const weft::Failure &failure) {
        return weft_server_fail(server, failure.result, "%s", failure.text.c_str());
    } catch (const std::bad_alloc &) {
        return weft_server_fail(server, WEFT_ERR_LIMIT,
                                "more memory is needed than the limit of %llu bytes",
                                wide(server->limits.memory_bytes));
    } catch (const std::exception &error) {
        return weft_server_fail(server, WEFT_ERR_FORMAT, "OpenVDB says: %.400s", error.what());
    } catch (...) {
        return weft_server_fail(server, WEFT_ERR_FORMAT, "OpenVDB failed without a reason");
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
