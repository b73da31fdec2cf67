// SPDX-License-Identifier: BSD-3-Clause
#include "tools/common/standard_input.h"

#include <errno.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tools/common/report.h"

enum { BLOCK = 1 << 16 };

static bool write_all(int fd, const char *bytes, size_t size)
{
    while (size) {
        const ssize_t count = write(fd, bytes, size);
        if (count < 0 && errno == EINTR)
            continue;
        if (count <= 0)
            return false;
        bytes += count;
        size -= (size_t)count;
    }
    return true;
}

static enum weft_result copy(int fd)
{
    static char block[BLOCK];
    for (;;) {
        const ssize_t count = read(STDIN_FILENO, block, sizeof block);
        if (count == 0)
            return WEFT_OK;
        if (count < 0 && errno == EINTR)
            continue;
        if (count < 0) {
            report_error("standard input cannot be read: %s", strerror(errno));
            return WEFT_ERR_OPEN;
        }
        if (!write_all(fd, block, (size_t)count)) {
            report_error("standard input does not fit into memory: %s", strerror(errno));
            return WEFT_ERR_MEMORY;
        }
    }
}

enum weft_result standard_input_take(void)
{
    struct stat status;
    if (isatty(STDIN_FILENO)) {
        report_error("- is standard input, and that is a terminal");
        return WEFT_ERR_OPEN;
    }
    if (fstat(STDIN_FILENO, &status) == 0 && S_ISREG(status.st_mode))
        return WEFT_OK;
    const int fd = memfd_create("standard input", MFD_CLOEXEC);
    if (fd < 0) {
        report_error("no file in memory for standard input: %s", strerror(errno));
        return WEFT_ERR_MEMORY;
    }
    report_stage("reading", "standard input");
    enum weft_result res = copy(fd);
    if (res == WEFT_OK && dup2(fd, STDIN_FILENO) < 0)
        res = WEFT_ERR_OPEN;
    close(fd);
    report_erase_progress();
    return res;
}
