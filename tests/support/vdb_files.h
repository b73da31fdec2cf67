// SPDX-License-Identifier: BSD-3-Clause
// What the tests of volumes in files share.
#ifndef WEFT_TESTS_SUPPORT_VDB_FILES_H
#define WEFT_TESTS_SUPPORT_VDB_FILES_H

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tiles/volume/volume.h"

// The last message.
struct test_log {
    char message[1024];
};

static void keep_message(void *priv, enum weft_log_level level, const char *message)
{
    if (level == WEFT_LOG_ERROR)
        snprintf(((struct test_log *)priv)->message, 1024, "%s", message);
}

static struct test_log last_error;
static const struct weft_log test_log = {keep_message, &last_error};

static char test_folder[256];

static inline const char *file_path(const char *name)
{
    static char path[512];
    snprintf(path, sizeof path, "%s/%s", test_folder, name);
    return path;
}

// A new folder, and the readers of this build.
static inline int make_folder(void **state)
{
    (void)state;
    const char *base = getenv("TMPDIR");
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 1);
    snprintf(test_folder, sizeof test_folder, "%s/weft-test-XXXXXX", base ? base : "/tmp");
    return mkdtemp(test_folder) ? 0 : -1;
}

static inline int remove_folder(void **state)
{
    (void)state;
    DIR *folder = opendir(test_folder);
    for (struct dirent *entry; folder && (entry = readdir(folder));)
        unlink(file_path(entry->d_name));
    if (folder)
        closedir(folder);
    return rmdir(test_folder);
}

static inline int count_fds(void)
{
    int count = 0;
    DIR *folder = opendir("/proc/self/fd");
    while (folder && readdir(folder))
        count++;
    if (folder)
        closedir(folder);
    return count;
}

// The whole file, to be freed; NULL where there is none.
static inline unsigned char *read_whole(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    *size = 0;
    if (!file)
        return NULL;
    fseek(file, 0, SEEK_END);
    long length = ftell(file);
    rewind(file);
    unsigned char *data = length < 0 ? NULL : malloc((size_t)length + 1);
    if (data)
        *size = fread(data, 1, (size_t)length, file);
    fclose(file);
    return data;
}

static inline void write_whole(const char *path, const void *data, size_t size)
{
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(data, 1, size, file) != size || fclose(file))
        abort();
}

static const struct weft_region everywhere = {
    {-WEFT_INDEX_LIMIT, -WEFT_INDEX_LIMIT, -WEFT_INDEX_LIMIT},
    {WEFT_INDEX_LIMIT, WEFT_INDEX_LIMIT, WEFT_INDEX_LIMIT},
    0,
    {{{0}, 0, 0}}};

// A sphere's distance field, cut off at +-3: bricks at its surface, around `centre`.
static inline weft_volume *make_sphere(double radius, const int32_t centre[3],
                                       const double transform[3][4])
{
    int32_t reach = ((int32_t)radius + 4 + 7) / 8 * 8;
    size_t count = 0, room = 0;
    int32_t(*origin)[3] = NULL;
    float *values = NULL;
    for (int32_t z = -reach; z < reach; z += 8)
        for (int32_t y = -reach; y < reach; y += 8)
            for (int32_t x = -reach; x < reach; x += 8) {
                double mx = x + 3.5, my = y + 3.5, mz = z + 3.5;
                double distance = sqrt(mx * mx + my * my + mz * mz) - radius;
                if (fabs(distance) > 3 + 6.1)
                    continue;
                if (count == room) {
                    room = room ? room * 2 : 64;
                    origin = realloc(origin, room * sizeof *origin);
                    values = realloc(values, room * 2048);
                    if (!origin || !values)
                        abort();
                }
                for (int v = 0; v < 512; v++) {
                    double i = x + (v & 7), j = y + (v >> 3 & 7), k = z + (v >> 6);
                    double d = sqrt(i * i + j * j + k * k) - radius;
                    values[count * 512 + (size_t)v] = (float)(d < -3 ? -3 : d > 3 ? 3 : d);
                }
                origin[count][0] = x + centre[0];
                origin[count][1] = y + centre[1];
                origin[count++][2] = z + centre[2];
            }
    struct weft_volume_bricks_params params = {.brick_count = count,
                                               .brick_origin = (const int32_t(*)[3])origin,
                                               .brick_values = values,
                                               .background = 3,
                                               .grid_class = "level set",
                                               .log = &test_log};
    if (transform)
        memcpy(params.index_to_world, transform, sizeof params.index_to_world);
    weft_volume *volume = NULL;
    weft_volume_create_bricks(&params, &volume);
    free(origin);
    free(values);
    return volume;
}

#endif
