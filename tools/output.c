// SPDX-License-Identifier: BSD-3-Clause
#include "output.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "paths.h"
#include "report.h"

static bool write_all(int fd, const char *data, size_t size)
{
    while (size) {
        ssize_t count = write(fd, data, size);
        if (count < 0 && errno != EINTR)
            return false;
        if (count > 0) {
            data += count;
            size -= (size_t)count;
        }
    }
    return true;
}

static enum weft_result fail_errno(const char *path)
{
    report_error("%s cannot be written: %s", path, strerror(errno));
    return WEFT_ERR_WRITE;
}

static enum weft_result write_stream(const char *path, const void *data, size_t size)
{
    int fd = open(path, O_WRONLY | O_NOCTTY | O_CLOEXEC);
    bool good = fd >= 0 && write_all(fd, data, size);
    enum weft_result res = good ? WEFT_OK : fail_errno(path);
    if (fd >= 0)
        close(fd);
    return res;
}

static mode_t new_file_mode(void)
{
    mode_t mask = umask(0);
    umask(mask);
    return 0666 & ~mask;
}

static enum weft_result replace(const char *path, mode_t mode, const void *data, size_t size)
{
    char *temporary = NULL;
    enum weft_result res = WEFT_ERR_MEMORY;
    int folder = (int)(paths_base_name(path) - path);
    if (asprintf(&temporary, "%.*s.weft.XXXXXX", folder, path) < 0) {
        report_error("%s cannot be written: out of memory", path);
        return res;
    }
    int fd = mkostemp(temporary, O_CLOEXEC);
    if (fd < 0) {
        res = fail_errno(path);
        free(temporary);
        return res;
    }
    bool good = write_all(fd, data, size) && fchmod(fd, mode) == 0 && fsync(fd) == 0;
    res = good ? WEFT_OK : fail_errno(path);
    if (close(fd) != 0 && res == WEFT_OK)
        res = fail_errno(path);
    if (res == WEFT_OK && rename(temporary, path) != 0)
        res = fail_errno(path);
    if (res != WEFT_OK)
        unlink(temporary);
    free(temporary);
    return res;
}

enum weft_result output_save(const char *path, const void *data, size_t size)
{
    struct stat status;
    if (stat(path, &status) != 0)
        return replace(path, new_file_mode(), data, size);
    // /dev/stdout may lead to a regular file, which is to go on where it stands.
    if (!S_ISREG(status.st_mode) || strncmp(path, "/dev/", 5) == 0)
        return write_stream(path, data, size);
    if (access(path, W_OK) != 0) // a rename would not ask for it
        return fail_errno(path);
    char *target = realpath(path, NULL);
    if (!target)
        return fail_errno(path);
    enum weft_result res = replace(target, status.st_mode & 0777, data, size);
    free(target);
    return res;
}
