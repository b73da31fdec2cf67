// SPDX-License-Identifier: BSD-3-Clause
#include "tools/draw/preview.h"

#include <stdio.h>
#include <string.h>

#include "tools/common/paths.h"
#include "tools/common/report.h"

enum { MAX_MAPS = 16 };

static enum weft_result unknown_colour_map(const char *name)
{
    const char *name_of[MAX_MAPS + 1] = {NULL};
    char names[512] = "";
    for (int i = 0; weft_colour_map_list[i] && i < MAX_MAPS; i++) {
        const size_t used = strlen(names);
        name_of[i] = weft_colour_map_list[i]->name;
        snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "", name_of[i]);
    }
    const char *meant = weft_closest_find(name, strlen(name), name_of);
    report_error("unknown colour map '%s'; %s%s%sthere are: %s", name, meant ? "did you mean " : "",
                 meant ? meant : "", meant ? "? " : "", names);
    return WEFT_ERR_ARGUMENT;
}

enum weft_result preview_check(const struct preview_options *options,
                               const struct weft_colour_map **out)
{
    const struct option_value *range = options->range, *map = options->colour_map;
    *out = map->given ? weft_colour_map_find(map->text) : NULL;
    if (map->given && !*out)
        return unknown_colour_map(map->text);
    if (!range->given || (float)range->number[0] < (float)range->number[1])
        return WEFT_OK;
    report_error("--range %s: LO must be less than HI, in single precision", range->text);
    return WEFT_ERR_ARGUMENT;
}

bool preview_help(const struct option_value *colour_map)
{
    if (!options_ask_for_help(colour_map))
        return false;
    puts("colour maps:");
    for (int i = 0; weft_colour_map_list[i]; i++) {
        const struct weft_colour_map *map = weft_colour_map_list[i];
        printf("  %-10s %s%s%s\n", map->name, map->citation, map->alias ? "; also " : "",
               map->alias ? map->alias : "");
    }
    return true;
}

enum weft_result preview_check_outputs(const struct preview_options *options, bool writes)
{
    const char *const both[] = {options->output, options->preview};
    if (both[0] && both[1] && paths_same_file(both[0], both[1])) {
        report_error("-o %s and --preview %s are the same file", both[0], both[1]);
        return WEFT_ERR_ARGUMENT;
    }
    for (int i = 0; i < 2; i++) {
        if (both[i] && paths_same_file(options->input, both[i])) {
            report_error("the output %s is the input %s", both[i], options->input);
            return WEFT_ERR_ARGUMENT;
        }
    }
    for (int i = 0; i < 2 && writes; i++)
        if (both[i] && paths_check_output(both[i], options->no_clobber) != WEFT_OK)
            return WEFT_ERR_WRITE;
    return WEFT_OK;
}

enum weft_result preview_save(const struct preview_options *options,
                              const struct weft_colour_map *colour_map, int32_t width,
                              int32_t height, const float *plane, float range[2])
{
    struct weft_preview_params *params =
        weft_preview_params(.path = options->preview, .no_clobber = options->no_clobber,
                            .width = width, .height = height, .plane = plane,
                            .colour_map = colour_map, .log = report_log());
    if (options->range->given) {
        params->low = (float)options->range->number[0];
        params->high = (float)options->range->number[1];
    }
    report_stage("writing", params->path);
    return weft_preview_save(params, range);
}

enum weft_result preview_save_colour(const struct preview_options *options, int threads,
                                     int32_t width, int32_t height, const float *const plane[3],
                                     float range[2])
{
    struct weft_colour_preview_params *params =
        weft_colour_preview_params(.path = options->preview, .no_clobber = options->no_clobber,
                                   .width = width, .height = height, .red = plane[0],
                                   .green = plane[1], .blue = plane[2], .threads = threads,
                                   .log = report_log());
    range[0] = 0.0f;
    range[1] = 1.0f;
    if (options->range->given) {
        range[0] = params->low = (float)options->range->number[0];
        range[1] = params->high = (float)options->range->number[1];
    }
    report_stage("writing", params->path);
    return weft_colour_preview_save(params);
}
