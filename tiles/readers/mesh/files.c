// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/readers/mesh/files.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/openat2.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

// Names are quoted in messages, which have an end.
#define QUOTED "'%.200s'"

// The first one counts.
#define SAY(text, ...) (*(text) ? 0 : snprintf(text, sizeof(text), __VA_ARGS__))

static bool map(int fd, size_t size, struct weft_mesh_bytes *out)
{
    *out = (struct weft_mesh_bytes){NULL, 0};
    if (!size)
        return true;
    void *data = mmap(NULL, size, PROT_READ, MAP_PRIVATE, fd, 0);
    if (data == MAP_FAILED)
        return false;
    *out = (struct weft_mesh_bytes){data, size};
    return true;
}

void weft_mesh_bytes_release(struct weft_mesh_bytes *bytes)
{
    if (bytes->size)
        munmap((void *)(uintptr_t)bytes->data, bytes->size);
    *bytes = (struct weft_mesh_bytes){NULL, 0};
}

bool weft_mesh_files_begin(struct weft_mesh_files *files, const char *path, int fd)
{
    struct stat st;
    *files = (struct weft_mesh_files){.path = path, .folder = -1};
    if (fstat(fd, &st) == 0 && map(fd, (size_t)st.st_size, &files->main))
        return true;
    SAY(files->refused, "cannot map the file: %s", strerror(errno));
    return false;
}

// The folder by the path that the caller gave, be the file itself a link to somewhere else.
static bool open_folder(struct weft_mesh_files *files)
{
    if (files->folder >= 0)
        return true;
    const char *slash = strrchr(files->path, '/');
    char *folder = slash ? strndup(files->path, (size_t)(slash - files->path + 1)) : strdup(".");
    if (folder)
        files->folder = open(folder, O_PATH | O_DIRECTORY | O_CLOEXEC);
    free(folder);
    return files->folder >= 0;
}

// Without waiting for somebody to write to a named pipe. The kernel sees to it that no way leads
// out of the folder: neither an absolute name, nor "..", nor a link.
static int open_beneath(int folder, const char *name)
{
    struct open_how how = {.flags = O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY,
                           .resolve = RESOLVE_BENEATH | RESOLVE_NO_MAGICLINKS};
    return (int)syscall(SYS_openat2, folder, name, &how, sizeof how);
}

bool weft_mesh_files_open(struct weft_mesh_files *files, const char *name,
                          struct weft_mesh_bytes *out)
{
    struct stat st;
    bool good = false;
    *out = (struct weft_mesh_bytes){NULL, 0};
    const int fd = open_folder(files) ? open_beneath(files->folder, name) : -1;
    if (fd < 0 && (errno == EXDEV || errno == ELOOP))
        SAY(files->refused, "it names the file " QUOTED ", which leads out of its folder", name);
    else if (fd < 0 && (errno == ENOENT || errno == ENOTDIR))
        SAY(files->missing, "it names the file " QUOTED ", which is not there", name);
    else if (fd < 0 || fstat(fd, &st))
        SAY(files->refused, "it names the file " QUOTED ", which cannot be opened: %s", name,
            strerror(errno));
    else if (!S_ISREG(st.st_mode))
        SAY(files->refused, "it names the file " QUOTED ", which is not a plain file", name);
    else if (!map(fd, (size_t)st.st_size, out))
        SAY(files->refused, "it names the file " QUOTED ", which cannot be mapped: %s", name,
            strerror(errno));
    else
        good = true;
    files->opened += good;
    if (fd >= 0)
        close(fd);
    return good;
}
