// SPDX-License-Identifier: BSD-3-Clause
// The box that all files of a sequence fit in.
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/ending.h"
#include "tools/common/numbered.h"
#include "tools/common/report.h"
#include "tools/framing/framing.h"

static void widen(const struct weft_volume_info *info, enum weft_space space, double low[3],
                  double high[3])
{
    double own_low[3], own_high[3];
    if (info->empty)
        return;
    weft_slice_active_box(info, space, own_low, own_high);
    for (int a = 0; a < 3; a++)
        if (!isfinite(own_low[a]) || !isfinite(own_high[a]))
            return;
    for (int a = 0; a < 3; a++) {
        low[a] = fmin(low[a], own_low[a]);
        high[a] = fmax(high[a], own_high[a]);
    }
}

// As the library chooses it: by its name, or the first one of numbers, or else of vectors.
static const struct weft_volume_info *find_grid(const struct weft_volume_list *list,
                                                const char *name)
{
    const struct weft_volume_info *found = NULL;
    for (size_t i = 0; i < list->count; i++) {
        const struct weft_volume_info *info = &list->grids[i];
        if (*name ? strcmp(info->name, name) == 0 : info->supported && info->components == 1)
            return info;
        if (!*name && info->supported && !found)
            found = info;
    }
    return found;
}

static void widen_opened(const struct weft_volume_open_params *params, enum weft_space space,
                         double low[3], double high[3])
{
    weft_volume *volume = NULL;
    if (weft_volume_open(params, &volume) == WEFT_OK)
        widen(weft_volume_get_info(volume), space, low, high);
    weft_volume_destroy(&volume);
}

static void widen_by_file(const struct framing_files *files, const char *path,
                          enum weft_space space, double low[3], double high[3])
{
    static const struct weft_log silent = {NULL, NULL};
    struct weft_volume_open_params params = {.path = path, .raw = files->raw, .log = &silent};
    struct weft_volume_list list = {0};
    if (weft_volume_list_load(&params, &list) != WEFT_OK)
        return;
    const struct weft_volume_info *info = find_grid(&list, files->grid);
    params.grid = *files->grid ? files->grid : NULL;
    if (info && info->counted)
        widen(info, space, low, high);
    else
        widen_opened(&params, space, low, high);
    weft_volume_list_clear(&list);
}

// Of one thread: each file is a process of its own that takes most of the time to start.
struct scan {
    const struct framing_files *files;
    enum weft_space space;
    atomic_int *next;
    pthread_t thread;
    double low[3], high[3];
};

static void *scan_files(void *priv)
{
    struct scan *scan = priv;
    const struct framing_files *files = scan->files;
    for (int i; (i = atomic_fetch_add(scan->next, 1)) < files->count;) {
        char *path = numbered_format(files->name, files->first + i * files->step);
        if (path)
            widen_by_file(files, path, scan->space, scan->low, scan->high);
        free(path);
    }
    return NULL;
}

void framing_widen_box(const struct framing_files *files, enum weft_space space, double low[3],
                       double high[3])
{
    enum { MOST = 8 };
    struct scan scan[MOST];
    atomic_int next = 0;
    int wanted = weft_cpu_threads() < MOST ? weft_cpu_threads() : MOST, started = 1;
    report_stage("reading the boxes of", files->name);
    for (int t = 0; t < MOST; t++) {
        scan[t] = (struct scan){.files = files, .space = space, .next = &next};
        memcpy(scan[t].low, low, sizeof scan[t].low);
        memcpy(scan[t].high, high, sizeof scan[t].high);
    }
    if (wanted > files->count)
        wanted = files->count;
    while (started < wanted &&
           ending_start_thread(&scan[started].thread, scan_files, &scan[started]))
        started++;
    scan_files(&scan[0]);
    for (int t = 0; t < started; t++) {
        if (t > 0)
            pthread_join(scan[t].thread, NULL);
        for (int a = 0; a < 3; a++) {
            low[a] = fmin(low[a], scan[t].low[a]);
            high[a] = fmax(high[a], scan[t].high[a]);
        }
    }
}
