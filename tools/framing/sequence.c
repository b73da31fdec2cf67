// SPDX-License-Identifier: BSD-3-Clause
// The box that all files of a sequence fit in.
#include <math.h>
#include <stdlib.h>
#include <string.h>

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

void framing_widen_box(const struct framing_files *files, enum weft_space space, double low[3],
                       double high[3])
{
    for (int i = 0; i < files->count; i++) {
        char *path = numbered_format(files->name, files->first + i * files->step);
        if (!path)
            continue;
        report_stage("reading the box of", path);
        widen_by_file(files, path, space, low, high);
        free(path);
    }
}
