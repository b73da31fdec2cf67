// SPDX-License-Identifier: BSD-3-Clause
// libopenvdb calls some functions through its procedure linkage table, so definitions in the
// program take precedence: they check what it does not, and pass the call on.
// - It does not look at its streams: past the end of a file it builds whole trees from whatever the
//   memory held before. Here reading past the end throws.
// - Before 11.0 it reads a stored (not compressed) chunk of as many bytes as the file claims into a
//   buffer of the size that the tree needs (fixed there by commit f02e7e1cb).
#include <cstring>
#include <dlfcn.h>
#include <string>

#include <openvdb/io/Compression.h>

#include "tiles/readers/vdb_guard.h"

namespace
{

using Decompress = void (*)(std::istream &, char *, size_t);

Decompress next_definition(const char *name)
{
    std::string version = OPENVDB_PREPROC_STRINGIFY(OPENVDB_VERSION_NAME);
    std::string mangled =
        "_ZN7openvdb" + std::to_string(version.size()) + version + "2io" + name + "ERSiPcm";
    return reinterpret_cast<Decompress>(dlsym(RTLD_NEXT, mangled.c_str()));
}

const Decompress next_unzip = next_definition("15unzipFromStream");
const Decompress next_blosc = next_definition("15bloscFromStream");

// Compressed chunks are kept only where they are smaller; the slack is for the codecs' own headers.
constexpr int64_t slack = 1024;

void check_chunk(std::istream &is, size_t size)
{
    int64_t stored = 0;
    std::istream::pos_type start = is.tellg();
    is.read(reinterpret_cast<char *>(&stored), sizeof stored);
    is.seekg(start);
    int64_t expected = static_cast<int64_t>(size);
    bool fits = stored > 0 ? stored <= expected + slack : stored == -expected;
    if (!is || !fits)
        OPENVDB_THROW(openvdb::IoError,
                      "a chunk of " << stored << " bytes for " << size << " bytes of values");
}

void guarded(Decompress next, std::istream &is, char *data, size_t size)
{
    if (!next)
        OPENVDB_THROW(openvdb::NotImplementedError, "libopenvdb lacks a decompressor");
    check_chunk(is, size);
    next(is, data, size);
    if (!is)
        OPENVDB_THROW(openvdb::IoError, "the file ends within a chunk");
}

using Read = std::istream *(*)(std::istream *, char *, std::streamsize);
constexpr char read_symbol[] = "_ZNSi4readEPcl";
const Read next_read = reinterpret_cast<Read>(dlsym(RTLD_NEXT, read_symbol));

} // namespace

// std::istream::read as the platform's C++ ABI has it: the object comes first, a reference is a
// pointer.
extern "C" __attribute__((visibility("default"))) std::istream *
weft_guarded_read(std::istream *is, char *data, std::streamsize size) __asm__("_ZNSi4readEPcl");

std::istream *weft_guarded_read(std::istream *is, char *data, std::streamsize size)
{
    next_read(is, data, size);
    if (!*is)
        OPENVDB_THROW(openvdb::IoError, "the file ends too early");
    return is;
}

bool weft::guard_is_complete()
{
    return next_unzip && next_blosc && next_read;
}

namespace openvdb
{
OPENVDB_USE_VERSION_NAMESPACE
namespace OPENVDB_VERSION_NAME
{
namespace io
{

__attribute__((visibility("default"))) void unzipFromStream(std::istream &is, char *data,
                                                            size_t size)
{
    guarded(next_unzip, is, data, size);
}

__attribute__((visibility("default"))) void bloscFromStream(std::istream &is, char *data,
                                                            size_t size)
{
    guarded(next_blosc, is, data, size);
}

} // namespace io
} // namespace OPENVDB_VERSION_NAME
} // namespace openvdb
