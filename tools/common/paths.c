// SPDX-License-Identifier: BSD-3-Clause
#include "tools/common/paths.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tools/common/report.h"

const char *paths_base_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

const char *paths_ending(const char *path)
{
    const char *base = paths_base_name(path), *dot = strrchr(base, '.');
    return dot && dot != base && dot[1] ? dot : "";
}

bool paths_is_stdout(const char *path)
{
    static const char *const names[] = {"/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"};
    for (size_t i = 0; path && i < sizeof names / sizeof *names; i++)
        if (strcmp(path, names[i]) == 0)
            return true;
    return false;
}

// A descriptor may be of a file, which is to go on where it stands.
bool paths_is_special(const char *path)
{
    static const char *const folders[] = {"/dev/std", "/dev/fd/", "/proc/self/fd/"};
    struct stat status;
    for (size_t i = 0; i < sizeof folders / sizeof *folders; i++)
        if (strncmp(path, folders[i], strlen(folders[i])) == 0)
            return true;
    return stat(path, &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
}

// "." where the path has none; cut at PATH_MAX, which no call accepts anyway.
static void folder_name(const char *path, char out[PATH_MAX])
{
    int size = (int)(paths_base_name(path) - path);
    if (size == 0)
        snprintf(out, PATH_MAX, ".");
    else
        snprintf(out, PATH_MAX, "%.*s", size, path);
}

static bool same_inode(const char *a, const char *b)
{
    struct stat sa, sb;
    return stat(a, &sa) == 0 && stat(b, &sb) == 0 && sa.st_dev == sb.st_dev &&
           sa.st_ino == sb.st_ino;
}

bool paths_same_file(const char *a, const char *b)
{
    if (same_inode(a, b))
        return true;
    char folder_a[PATH_MAX], folder_b[PATH_MAX];
    folder_name(a, folder_a);
    folder_name(b, folder_b);
    return strcmp(paths_base_name(a), paths_base_name(b)) == 0 && same_inode(folder_a, folder_b);
}

enum weft_result paths_check_output(const char *path, bool no_clobber)
{
    struct stat status;
    char folder[PATH_MAX];
    folder_name(path, folder);
    if (paths_is_special(path))
        return WEFT_OK; // opening it tells
    if (lstat(path, &status) == 0 && no_clobber)
        report_error("%s exists, and --no-clobber is given", path);
    else if (*paths_base_name(path) == 0 || (stat(path, &status) == 0 && S_ISDIR(status.st_mode)))
        report_error("%s cannot be written: it is a folder", path);
    else if (stat(folder, &status) != 0)
        report_error("%s cannot be written: folder %s: %s", path, folder, strerror(errno));
    else if (!S_ISDIR(status.st_mode))
        report_error("%s cannot be written: %s is not a folder", path, folder);
    else if (access(folder, W_OK | X_OK) != 0)
        report_error("%s cannot be written: folder %s: %s", path, folder, strerror(errno));
    else
        return WEFT_OK;
    return WEFT_ERR_WRITE;
}
