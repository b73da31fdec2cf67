// SPDX-License-Identifier: BSD-3-Clause
// Time and the reader's peak memory for opening a VDB file, finding the bricks of an oblique plane
// through its middle, and reading them:
//   bench_vdb FILE...           existing files
//   bench_vdb --sphere N FILE   first writes a level set of a sphere N voxels across
#include <ctype.h>

#include "filter/check.h"
#include "tests/support/vdb_files.h"

static void print_error(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    if (level == WEFT_LOG_ERROR)
        fprintf(stderr, "%s\n", message);
}

static const struct weft_log console = {print_error, NULL};

// Peak and current resident kB of the only child.
static void child_memory(long *peak, long *anonymous)
{
    *peak = *anonymous = 0;
    DIR *folder = opendir("/proc");
    for (struct dirent *entry; folder && (entry = readdir(folder));) {
        char path[64], line[256];
        long parent = 0, high = 0, anon = 0;
        if (!isdigit((unsigned char)*entry->d_name))
            continue;
        snprintf(path, sizeof path, "/proc/%.20s/status", entry->d_name);
        FILE *file = fopen(path, "r");
        while (file && fgets(line, sizeof line, file)) {
            sscanf(line, "PPid: %ld", &parent);
            sscanf(line, "VmHWM: %ld", &high);
            sscanf(line, "RssAnon: %ld", &anon);
        }
        if (file)
            fclose(file);
        if (parent == getpid()) {
            *peak = high;
            *anonymous = anon;
        }
    }
    if (folder)
        closedir(folder);
}

static struct weft_region middle_plane(const struct weft_volume_info *info)
{
    struct weft_region region = everywhere;
    double middle = 0;
    const double normal[3] = {0.6, 0.48, 0.64};
    region.slab_count = 1;
    for (int i = 0; i < 3; i++) {
        region.slab[0].normal[i] = normal[i];
        middle += normal[i] * 0.5 * (info->active_min[i] + info->active_max[i]);
    }
    region.slab[0].lower = middle - 2;
    region.slab[0].upper = middle + 2;
    return region;
}

static int run(const char *path)
{
    weft_volume *volume = NULL;
    struct weft_brick_list list = {0};
    struct weft_volume_open_params params = {.path = path, .log = &console};
    long peak[3], anonymous[3];
    double start = weft_now_seconds();
    if (weft_volume_open(&params, &volume))
        return 1;
    const struct weft_volume_info *info = weft_volume_get_info(volume);
    double opened = weft_now_seconds();
    child_memory(&peak[0], &anonymous[0]);
    struct weft_region region = middle_plane(info);
    if (weft_volume_find(volume, &region, &list))
        return 1;
    double found = weft_now_seconds();
    child_memory(&peak[1], &anonymous[1]);
    float *values = malloc(list.brick_count * 2048 + 1);
    double reading = weft_now_seconds();
    if (!values ||
        weft_volume_read(volume, list.brick_count, (const int32_t(*)[3])list.brick_origin, values))
        return 1;
    double read = weft_now_seconds();
    child_memory(&peak[2], &anonymous[2]);
    printf("%s: %llu bricks, %llu active voxels; the plane meets %zu bricks, %zu tiles\n", path,
           (unsigned long long)info->bricks, (unsigned long long)info->active_voxels,
           list.brick_count, list.tile_count);
    printf("  open %.3f s, find %.4f s, read %.3f s\n", opened - start, found - opened,
           read - reading);
    printf(
        "  reader's resident MB, peak (of it now anonymous): open %.1f (%.1f), find %.1f (%.1f), "
        "read %.1f (%.1f)\n",
        (double)peak[0] / 1e3, (double)anonymous[0] / 1e3, (double)peak[1] / 1e3,
        (double)anonymous[1] / 1e3, (double)peak[2] / 1e3, (double)anonymous[2] / 1e3);
    free(values);
    weft_brick_list_clear(&list);
    weft_volume_destroy(&volume);
    return 0;
}

static int save_sphere(int size, const char *path)
{
    struct weft_volume_save_params params = {.path = path, .log = &console};
    double start = weft_now_seconds();
    weft_volume *sphere = make_sphere(size / 2, (int32_t[3]){0}, NULL);
    double made = weft_now_seconds();
    int failed = !sphere || weft_volume_save(sphere, &params);
    printf("%s: made in %.1f s, saved in %.1f s\n", path, made - start, weft_now_seconds() - made);
    weft_volume_destroy(&sphere);
    return failed;
}

int main(int argc, char **argv)
{
    int first = 1, failed = 0;
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 0);
    if (argc == 4 && !strcmp(argv[1], "--sphere")) {
        failed = save_sphere(atoi(argv[2]), argv[3]);
        first = 3;
    }
    for (int i = first; i < argc && !failed; i++)
        failed = run(argv[i]);
    return failed;
}
