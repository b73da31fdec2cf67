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

// A folder that is not there is told apart by the whole path alone.
struct paths_identity paths_identify(const char *path)
{
    struct stat status;
    char folder[PATH_MAX];
    if (stat(path, &status) == 0)
        return (struct paths_identity){status.st_dev, status.st_ino, ""};
    folder_name(path, folder);
    if (stat(folder, &status) == 0)
        return (struct paths_identity){status.st_dev, status.st_ino, paths_base_name(path)};
    return (struct paths_identity){0, 0, path};
}

int paths_compare(const struct paths_identity *a, const struct paths_identity *b)
{
    if (a->device != b->device)
        return a->device < b->device ? -1 : 1;
    if (a->inode != b->inode)
        return a->inode < b->inode ? -1 : 1;
    return strcmp(a->base, b->base);
}

bool paths_same_file(const char *a, const char *b)
{
    const struct paths_identity of_a = paths_identify(a), of_b = paths_identify(b);
    return paths_compare(&of_a, &of_b) == 0;
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

static enum weft_result fail_same(const struct paths_output *a, const struct paths_output *b)
{
    report_error("%s %s and %s %s are the same file", a->option, a->path, b->option, b->path);
    return WEFT_ERR_ARGUMENT;
}

enum weft_result paths_check_distinct(const struct paths_output *output, int output_count,
                                      const char *const *input, int input_count)
{
    for (int i = 0; i < output_count; i++) {
        const char *path = output[i].path;
        for (int k = 0; k < i && path; k++)
            if (output[k].path && paths_same_file(output[k].path, path))
                return fail_same(&output[k], &output[i]);
        for (int k = 0; k < input_count && path; k++)
            if (input[k] && paths_same_file(path, input[k])) {
                report_error("the output %s is the input %s", path, input[k]);
                return WEFT_ERR_ARGUMENT;
            }
    }
    return WEFT_OK;
}
