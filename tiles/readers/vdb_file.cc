// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/readers/vdb_file.h"

#include <cstring>
#include <sstream>
#include <sys/mman.h>
#include <sys/stat.h>

#include <openvdb/io/Archive.h>
#include <openvdb/io/DelayedLoadMetadata.h>

// A name that OpenVDB declares as a friend of its mapped files: the only way to make one without
// openvdb::io::File.
class TestMappedFile
{
  public:
    static openvdb::io::MappedFile::Ptr map(const std::string &path)
    {
        return openvdb::io::MappedFile::Ptr(new openvdb::io::MappedFile(path));
    }
};

namespace weft
{

class VdbFile::Archive : public openvdb::io::Archive
{
  public:
    // Tags the stream with what the file's header says.
    void read_settings(std::istream &stream)
    {
        readHeader(stream);
        setFormatVersion(stream);
        setLibraryVersion(stream);
        setDataCompression(stream);
    }

    static void read_compression(std::istream &stream)
    {
        readGridCompression(stream);
    }
};

namespace
{

// OpenVDB would not tell why it cannot map the file.
void check_mapping(int fd, uint64_t memory_bytes)
{
    struct stat stat;
    if (fstat(fd, &stat))
        fail(WEFT_ERR_OPEN, "cannot read the file");
    size_t size = static_cast<size_t>(stat.st_size);
    void *data = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, fd, 0);
    if (data == MAP_FAILED)
        fail(WEFT_ERR_LIMIT, "the file's %llu bytes do not fit into the memory limit of %llu bytes",
             static_cast<unsigned long long>(size), static_cast<unsigned long long>(memory_bytes));
    munmap(data, size);
}

uint64_t number_at(const std::string &bytes, size_t at)
{
    uint32_t number = 0;
    if (at + sizeof number <= bytes.size())
        memcpy(&number, bytes.data() + at, sizeof number);
    return number;
}

// One of the two arrays of delayed-load metadata, `count` elements stored as they are or by Blosc,
// whose header (version, flags, then sizes before and behind) must agree. Advances *at.
bool array_fits(const std::string &bytes, size_t *at, uint64_t count, uint64_t element)
{
    uint64_t packed = number_at(bytes, *at), start = *at + 4;
    uint64_t size = packed ? packed : count * element;
    if (start > bytes.size() || size > bytes.size() - start)
        return false;
    *at = start + size;
    return !packed || (packed >= 16 && number_at(bytes, start + 4) == count * element &&
                       number_at(bytes, start + 12) == packed);
}

// Where the leaves' sizes are stored, so that opening a grid need not look at each. OpenVDB
// believes whatever it finds there.
bool sizes_fit(const std::string &bytes, uint64_t leaves)
{
    constexpr uint64_t none = UINT32_MAX;
    size_t at = 4;
    return number_at(bytes, 0) == leaves && array_fits(bytes, &at, leaves, 1) &&
           ((number_at(bytes, at) == none && at + 4 <= bytes.size()) ||
            array_fits(bytes, &at, leaves, sizeof(int64_t)));
}

openvdb::Metadata::Ptr make_metadata(const MetadataEntry &entry)
{
    using openvdb::Metadata;
    Metadata::Ptr value;
    if (Metadata::isRegisteredType(entry.type))
        value = Metadata::createMetadata(entry.type);
    else
        value.reset(new openvdb::UnknownMetadata(entry.type));
    uint32_t size = static_cast<uint32_t>(entry.value.size());
    if (value->size() && value->size() != size) // types of no fixed size are empty now
        fail(WEFT_ERR_FORMAT, "metadata '%.64s' of the type %.32s has %u bytes", entry.key.c_str(),
             entry.type.c_str(), size);
    std::istringstream stream(std::string(reinterpret_cast<char *>(&size), sizeof size) +
                              entry.value);
    value->read(stream);
    return value;
}

} // namespace

VdbFile::VdbFile(int fd, uint64_t memory_bytes) : fd_(fd), entries_(scan_file(fd))
{
    using namespace openvdb;
    check_mapping(fd, memory_bytes);
    mapping_ = TestMappedFile::map("/proc/self/fd/" + std::to_string(fd));
    buffer_ = mapping_->createBuffer();
    stream_ = std::make_unique<std::istream>(buffer_.get());
    archive_ = std::make_unique<Archive>();
    file_settings_.reset(new io::StreamMetadata);
    file_settings_->setSeekable(true);
    io::setStreamMetadataPtr(*stream_, file_settings_, /*transfer=*/false);
    archive_->read_settings(*stream_);
    io::setMappedFilePtr(*stream_, mapping_);
}

VdbFile::~VdbFile() = default;

// Leaves the stream at the transform, and the grid's settings in force.
void VdbFile::read_metadata(const GridEntry &entry, openvdb::MetaMap *metadata)
{
    using namespace openvdb;
    GridHeader header = scan_header(fd_, entry);
    for (const MetadataEntry &stored : header.metadata)
        if (stored.type != io::DelayedLoadMetadata::staticTypeName())
            metadata->insertMeta(stored.key, *make_metadata(stored));
    stream_->clear();
    stream_->seekg(static_cast<std::streamoff>(entry.starts));
    io::setStreamMetadataPtr(*stream_, file_settings_, /*transfer=*/false);
    Archive::read_compression(*stream_);
    grid_settings_.reset(new io::StreamMetadata(*file_settings_));
    grid_settings_->setHalfFloat(entry.half);
    grid_settings_->gridMetadata() = *metadata;
    io::setStreamMetadataPtr(*stream_, grid_settings_, /*transfer=*/false);
    io::setGridBackgroundValuePtr(*stream_, nullptr);
    stream_->seekg(static_cast<std::streamoff>(header.transform));
}

openvdb::GridBase::Ptr VdbFile::read_header(const GridEntry &entry)
{
    auto grid = openvdb::FloatGrid::create();
    read_metadata(entry, grid.get());
    grid->readTransform(*stream_);
    return grid;
}

const GridEntry &VdbFile::tree_owner(const GridEntry &entry) const
{
    if (entry.parent.empty())
        return entry;
    for (const GridEntry &other : entries_)
        if (other.unique_name == entry.parent && other.parent.empty())
            return other;
    fail(WEFT_ERR_FORMAT, "it shares the tree of grid '%.64s', which has none",
         entry.parent.c_str());
}

openvdb::GridBase::Ptr VdbFile::read_tree(const GridEntry &entry)
{
    using namespace openvdb;
    if (!GridBase::isRegistered(entry.stored_type))
        fail(WEFT_ERR_UNSUPPORTED, "OpenVDB knows no type %.64s", entry.stored_type.c_str());
    GridBase::Ptr grid = GridBase::createGrid(entry.stored_type);
    grid->setSaveFloatAsHalf(entry.half);
    read_metadata(entry, grid.get());
    io::setGridClass(*stream_, grid->getGridClass());
    grid->readTransform(*stream_);
    grid->readTopology(*stream_);
    for (const MetadataEntry &stored : scan_header(fd_, entry).metadata)
        if (stored.type == io::DelayedLoadMetadata::staticTypeName() &&
            sizes_fit(stored.value, grid->baseTree().leafCount()))
            grid_settings_->gridMetadata().insertMeta(GridBase::META_FILE_DELAYED_LOAD,
                                                      *make_metadata(stored));
    grid_settings_->setLeaf(0);
    grid->readBuffers(*stream_);
    return grid;
}

openvdb::GridBase::Ptr VdbFile::read_grid(const GridEntry &entry)
{
    const GridEntry &owner = tree_owner(entry);
    openvdb::GridBase::Ptr grid = read_tree(owner);
    if (&owner == &entry)
        return grid;
    openvdb::GridBase::Ptr header = read_header(entry);
    grid->setTransform(header->transformPtr());
    grid->clearMetadata();
    for (auto it = header->beginMeta(); it != header->endMeta(); ++it)
        grid->insertMeta(it->first, *it->second);
    return grid;
}

} // namespace weft
