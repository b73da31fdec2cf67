// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/readers/vdb_bytes.h"

#include <cstdarg>
#include <cstdio>
#include <sys/mman.h>
#include <sys/stat.h>

namespace weft
{

void fail(weft_result result, const char *format, ...)
{
    char text[480];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    throw Failure{result, text};
}

Mapping::Mapping(int fd, uint64_t memory_bytes) : data_(nullptr), size_(0)
{
    struct stat stat;
    if (fstat(fd, &stat) || !S_ISREG(stat.st_mode))
        fail(WEFT_ERR_OPEN, "not a regular file");
    size_ = static_cast<uint64_t>(stat.st_size);
    if (!size_) // which cannot be mapped
        return;
    void *data = mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, fd, 0);
    if (data == MAP_FAILED)
        fail(WEFT_ERR_LIMIT, "the file's %llu bytes do not fit into the memory limit of %llu bytes",
             wide(size_), wide(memory_bytes));
    data_ = static_cast<const unsigned char *>(data);
}

Mapping::~Mapping()
{
    if (size_)
        munmap(const_cast<unsigned char *>(data_), size_);
}

} // namespace weft
