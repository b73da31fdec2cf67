// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/output/output_file.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tiles/output/unfinished.h"

// Room for the dot, the random part and NAME_MAX (255) as the limit of file systems.
enum { NAME_KEPT = 200, RANDOM_CHARS = 6, TRIES = 100 };

static enum weft_result fail_errno(const struct weft_log *log, const char *path)
{
    int error = errno;
    weft_error(log, "cannot write %s: %s", path, strerror(error));
    return error == ENOMEM ? WEFT_ERR_MEMORY : WEFT_ERR_WRITE;
}

// The descriptor that a path stands for, or -1. It may be a regular file (by redirection), which is
// to be continued where it stands, not replaced.
static int path_descriptor(const char *path)
{
    static const char *const folder[] = {"/dev/fd/", "/proc/self/fd/"};
    if (!strcmp(path, "/dev/stdout"))
        return STDOUT_FILENO;
    if (!strcmp(path, "/dev/stderr"))
        return STDERR_FILENO;
    for (size_t i = 0; i < WEFT_COUNT(folder); i++) {
        size_t length = strlen(folder[i]);
        char *end;
        if (strncmp(path, folder[i], length) || path[length] < '0' || path[length] > '9')
            continue;
        long fd = strtol(path + length, &end, 10);
        if (!*end && fd <= INT_MAX)
            return (int)fd;
    }
    return -1;
}

static enum weft_result open_stream(struct weft_output_file *f)
{
    int fd = path_descriptor(f->path);
    if (fd >= 0)
        f->stream = fcntl(fd, F_DUPFD_CLOEXEC, 0);
    else
        f->stream = open(f->path, O_WRONLY | O_NOCTTY | O_CLOEXEC);
    if (f->stream >= 0)
        f->fd = memfd_create("weft-output", MFD_CLOEXEC);
    return f->fd < 0 ? fail_errno(f->log, f->path) : WEFT_OK;
}

static void fill_random(char *text)
{
    static const char letters[] = "abcdefghijklmnopqrstuvwxyz012345";
    unsigned char random[RANDOM_CHARS];
    if (getrandom(random, sizeof random, GRND_NONBLOCK) != (ssize_t)sizeof random)
        memset(random, 0, sizeof random);
    // Processes and calls differ even without randomness; O_EXCL settles the rest.
    static unsigned counter;
    unsigned salt = (unsigned)getpid() * 31u + __atomic_add_fetch(&counter, 1, __ATOMIC_RELAXED);
    for (int i = 0; i < RANDOM_CHARS; i++, salt /= 32)
        text[i] = letters[(random[i] ^ salt) % 32];
}

// The length of the path of the target's folder, with its slash; 0: the current one.
static int folder_length(const struct weft_output_file *f)
{
    const char *slash = strrchr(f->path, '/');
    return slash ? (int)(slash + 1 - f->path) : 0;
}

static void forget_temporary(struct weft_output_file *f)
{
    weft_unfinished_remove_file(f->temporary);
    free(f->temporary);
    f->temporary = NULL;
}

static bool create_named(struct weft_output_file *f)
{
    f->fd = open(f->temporary, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    return f->fd >= 0;
}

// By its descriptor, since a file without a name has no other.
static bool link_to(const struct weft_output_file *f, const char *path)
{
    char from[32];
    snprintf(from, sizeof from, "/proc/self/fd/%d", f->fd);
    return linkat(AT_FDCWD, from, AT_FDCWD, path, AT_SYMLINK_FOLLOW) == 0;
}

static bool link_temporary(struct weft_output_file *f)
{
    return link_to(f, f->temporary);
}

// Finds a free temporary name, for which `make` makes the file. On failure errno tells why.
static bool make_temporary(struct weft_output_file *f, bool (*make)(struct weft_output_file *f))
{
    int folder = folder_length(f);
    if (asprintf(&f->temporary, "%.*s.%.*s.XXXXXX", folder, f->path, NAME_KEPT, f->path + folder) <
        0) {
        f->temporary = NULL;
        errno = ENOMEM;
        return false;
    }
    for (int i = 0; i < TRIES; i++) {
        fill_random(f->temporary + strlen(f->temporary) - RANDOM_CHARS);
        weft_unfinished_add_file(f->temporary);
        if (make(f))
            return true;
        int error = errno;
        weft_unfinished_remove_file(f->temporary); // not ours to unlink
        errno = error;
        if (error != EEXIST)
            break;
    }
    int error = errno;
    free(f->temporary);
    f->temporary = NULL;
    errno = error;
    return false;
}

// Whatever ends the process, nothing is left of a file without a name.
static bool open_nameless(struct weft_output_file *f)
{
    char folder[PATH_MAX], link[32];
    struct stat st;
    int length = folder_length(f);
    snprintf(folder, sizeof folder, "%.*s", length ? length : 1, length ? f->path : ".");
    f->fd = length < PATH_MAX ? open(folder, O_TMPFILE | O_RDWR | O_CLOEXEC, 0666) : -1;
    if (f->fd < 0)
        return false;
    snprintf(link, sizeof link, "/proc/self/fd/%d", f->fd);
    if (!lstat(link, &st))
        return true;
    close(f->fd); // without /proc it could not get its name
    f->fd = -1;
    return false;
}

static enum weft_result open_temporary(struct weft_output_file *f)
{
    if (open_nameless(f) || make_temporary(f, create_named))
        return WEFT_OK;
    int error = errno;
    weft_error(f->log, "cannot write %s: no file can be made in its folder: %s", f->path,
               strerror(error));
    return error == ENOMEM ? WEFT_ERR_MEMORY : WEFT_ERR_WRITE;
}

static enum weft_result follow_links(struct weft_output_file *f)
{
    char *resolved = realpath(f->path, NULL);
    if (!resolved)
        return fail_errno(f->log, f->path);
    free(f->path);
    f->path = resolved;
    return WEFT_OK;
}

// The target exists, a regular file.
static enum weft_result open_replacement(struct weft_output_file *f, mode_t mode)
{
    if (f->no_clobber) {
        weft_error(f->log, "cannot write %s: it exists and may not be replaced", f->path);
        return WEFT_ERR_WRITE;
    }
    enum weft_result res = follow_links(f);
    if (res != WEFT_OK)
        return res;
    // A rename would not ask for it.
    if (faccessat(AT_FDCWD, f->path, W_OK, AT_EACCESS))
        return fail_errno(f->log, f->path);
    res = open_temporary(f);
    if (res == WEFT_OK && fchmod(f->fd, mode & 0777))
        weft_debug(f->log, "%s: permissions not carried over: %s", f->path, strerror(errno));
    return res;
}

static enum weft_result open_target(struct weft_output_file *f)
{
    struct stat st, link;
    if (stat(f->path, &st)) {
        if (errno != ENOENT)
            return fail_errno(f->log, f->path);
        if (!lstat(f->path, &link)) {
            weft_error(f->log, "cannot write %s: it is a symbolic link to nothing", f->path);
            return WEFT_ERR_WRITE;
        }
        size_t length = strlen(f->path);
        errno = length ? EISDIR : ENOENT;
        if (!length || f->path[length - 1] == '/')
            return fail_errno(f->log, f->path);
        return open_temporary(f);
    }
    if (S_ISDIR(st.st_mode)) {
        errno = EISDIR;
        return fail_errno(f->log, f->path);
    }
    if (!S_ISREG(st.st_mode) || path_descriptor(f->path) >= 0)
        return open_stream(f);
    return open_replacement(f, st.st_mode);
}

enum weft_result weft_output_file_create(const struct weft_log *log, const char *path,
                                         bool no_clobber, struct weft_output_file *out)
{
    *out = (struct weft_output_file){.fd = -1, .stream = -1, .no_clobber = no_clobber, .log = log};
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, path != NULL);

    res = WEFT_ERR_MEMORY;
    out->path = strdup(path);
    if (!out->path) {
        weft_error(log, "cannot write %s: out of memory", path);
        goto fail;
    }
    res = open_target(out);
    if (res == WEFT_OK)
        return WEFT_OK;
fail:
    weft_output_file_discard(out);
    return res;
}

bool weft_output_file_put(struct weft_output_file *file, uint64_t offset, const void *data,
                          size_t size)
{
    const char *next = data;
    while (size) {
        ssize_t n = pwrite(file->fd, next, size, (off_t)offset);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return false;
        next += n;
        offset += (uint64_t)n;
        size -= (size_t)n;
    }
    return true;
}

enum weft_result weft_output_file_fail(const struct weft_output_file *file)
{
    return fail_errno(file->log, file->path);
}

enum weft_result weft_output_file_write(struct weft_output_file *file, uint64_t offset,
                                        const void *data, size_t size)
{
    return weft_output_file_put(file, offset, data, size) ? WEFT_OK : weft_output_file_fail(file);
}

static bool write_all(int fd, const char *data, size_t size)
{
    while (size) {
        ssize_t n = write(fd, data, size);
        if (n < 0 && errno != EINTR)
            return false;
        if (n > 0) {
            data += n;
            size -= (size_t)n;
        }
    }
    return true;
}

static bool copy_to_stream(struct weft_output_file *f)
{
    char block[65536];
    off_t offset = 0;
    for (;;) {
        ssize_t n = pread(f->fd, block, sizeof block, offset);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0 || !write_all(f->stream, block, (size_t)n))
            return false;
        if (!n)
            break;
        offset += n;
    }
    int fd = f->stream;
    f->stream = -1;
    return close(fd) == 0;
}

static bool move_without_replacing(const char *from, const char *to)
{
    if (!renameat2(AT_FDCWD, from, AT_FDCWD, to, RENAME_NOREPLACE))
        return true;
    // Some file systems know no such rename, others no links.
    if (errno != EINVAL && errno != ENOSYS)
        return false;
    return !link(from, to) && !unlink(from);
}

static bool move_temporary(struct weft_output_file *f)
{
    bool moved = f->no_clobber ? move_without_replacing(f->temporary, f->path)
                               : !rename(f->temporary, f->path);
    if (moved)
        forget_temporary(f);
    return moved;
}

// A link does not replace what has the name, a rename does.
static bool name_it(struct weft_output_file *f)
{
    if (link_to(f, f->path))
        return true;
    return errno == EEXIST && !f->no_clobber && make_temporary(f, link_temporary) &&
           move_temporary(f);
}

static bool put_in_place(struct weft_output_file *f)
{
    if (fsync(f->fd) && errno != EINVAL && errno != ENOTSUP)
        return false;
    if (!f->temporary && !name_it(f))
        return false;
    int fd = f->fd;
    f->fd = -1;
    if (close(fd))
        return false;
    return !f->temporary || move_temporary(f);
}

// The file is complete and in place by now; only a power cut could still undo the rename.
static void sync_folder(struct weft_output_file *f)
{
    char *slash = strrchr(f->path, '/');
    if (slash)
        slash[slash == f->path] = '\0';
    int fd = open(slash ? f->path : ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0)
        return;
    if (fsync(fd) && errno != EINVAL && errno != ENOTSUP)
        weft_warn(f->log, "%s: the folder could not be synchronised: %s", slash ? f->path : ".",
                  strerror(errno));
    close(fd);
}

enum weft_result weft_output_file_commit(struct weft_output_file *file)
{
    enum weft_result res = WEFT_OK;
    if (!(file->stream >= 0 ? copy_to_stream(file) : put_in_place(file)))
        res = fail_errno(file->log, file->path);
    else if (file->stream < 0 && file->fd < 0)
        sync_folder(file);
    weft_output_file_discard(file);
    return res;
}

void weft_output_file_discard(struct weft_output_file *file)
{
    if (!file->path)
        return;
    if (file->temporary) {
        unlink(file->temporary);
        forget_temporary(file);
    }
    if (file->fd >= 0)
        close(file->fd);
    if (file->stream >= 0)
        close(file->stream);
    free(file->path);
    *file = (struct weft_output_file){.fd = -1, .stream = -1};
}

enum weft_result weft_file_save_parts(const struct weft_log *log, const char *path, bool no_clobber,
                                      const struct weft_bytes *parts, size_t count)
{
    struct weft_output_file file = {.fd = -1};
    enum weft_result res = WEFT_ERR_ARGUMENT;
    uint64_t offset = 0;
    weft_require(log, path != NULL && (parts != NULL || count == 0));
    for (size_t i = 0; i < count; i++)
        weft_require(log, parts[i].data != NULL || parts[i].size == 0);
    res = weft_output_file_create(log, path, no_clobber, &file);
    for (size_t i = 0; i < count && res == WEFT_OK; offset += parts[i++].size)
        res = weft_output_file_write(&file, offset, parts[i].data, parts[i].size);
    if (res == WEFT_OK)
        res = weft_output_file_commit(&file);
    weft_output_file_discard(&file);
fail:
    return res;
}

enum weft_result weft_file_save(const struct weft_log *log, const char *path, bool no_clobber,
                                const void *data, size_t size)
{
    return weft_file_save_parts(log, path, no_clobber, &(struct weft_bytes){data, size}, 1);
}
