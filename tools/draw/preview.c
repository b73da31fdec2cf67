// SPDX-License-Identifier: BSD-3-Clause
#include "tools/draw/preview.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tools/common/paths.h"
#include "tools/common/report.h"

enum { MAX_MAPS = 16, MOST_STOPS = 60 };

static bool is_given(const struct option_value *option)
{
    return option && option->given;
}

const char *preview_conflict(const struct preview_options *options, bool given)
{
    if (!given && (is_given(options->annotate) || is_given(options->title)))
        return "--annotate and --title need --preview OUT.png";
    if (!given && is_given(options->exposure))
        return "--exposure needs --preview OUT.png";
    if (is_given(options->title) && !is_given(options->annotate))
        return "--title is the title of --annotate";
    if (is_given(options->exposure) && is_given(options->range))
        return "--exposure and --range exclude each other";
    if (is_given(options->exposure) && is_given(options->colour_map))
        return "--exposure is of light, and not of --colour-map";
    return NULL;
}

bool preview_shows_light(const struct preview_options *options)
{
    return is_given(options->exposure);
}

bool preview_annotate(const struct preview_options *options, const char *title, const char *caption,
                      struct annotation *out)
{
    *out = (struct annotation){.low = 0.0};
    snprintf(out->title, sizeof out->title, "%s",
             is_given(options->title) ? options->title->text : title);
    snprintf(out->caption, sizeof out->caption, "%s", caption);
    return is_given(options->annotate);
}

static enum weft_result unknown_colour_map(const char *name)
{
    const char *names[MAX_MAPS + 1] = {NULL};
    char explanation[512];
    for (int i = 0; i < MAX_MAPS && weft_colour_map_list[i]; i++)
        names[i] = weft_colour_map_list[i]->name;
    report_error("no colour map '%s'%s", name,
                 weft_closest_explain(name, strlen(name), names, explanation, sizeof explanation));
    return WEFT_ERR_ARGUMENT;
}

// Before long work.
static enum weft_result check_font(void)
{
    text_font *font;
    const enum weft_result res = text_font_create(&font);
    text_font_destroy(&font);
    return res;
}

enum weft_result preview_check(const struct preview_options *options,
                               const struct weft_colour_map **out)
{
    const struct option_value *range = options->range, *map = options->colour_map;
    *out = map->given ? weft_colour_map_find(map->text) : NULL;
    if (map->given && !*out)
        return unknown_colour_map(map->text);
    if (is_given(options->exposure) && !(fabs(options->exposure->number[0]) <= MOST_STOPS)) {
        report_error("--exposure %s: stops are from -%d to %d", options->exposure->text, MOST_STOPS,
                     MOST_STOPS);
        return WEFT_ERR_ARGUMENT;
    }
    if (!range->given || (float)range->number[0] < (float)range->number[1])
        return is_given(options->annotate) ? check_font() : WEFT_OK;
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
    const struct paths_output outputs[] = {{"-o", options->output},
                                           {"--preview", options->preview},
                                           {"--error-image", options->error_image}};
    const int count = sizeof outputs / sizeof *outputs;
    const enum weft_result res = paths_check_distinct(outputs, count, &options->input, 1);
    for (int i = 0; i < count && writes && res == WEFT_OK; i++)
        if (outputs[i].path && paths_check_output(outputs[i].path, options->no_clobber) != WEFT_OK)
            return WEFT_ERR_WRITE;
    return res;
}

// ---- writing ------------------------------------------------------------------------------------

// What is around a preview, while it is written.
struct around {
    marks *list;
    struct weft_preview_frame frame;
};

// What is shown as first and last colour, for the legend: as weft_preview_save finds it.
static void find_range(const struct weft_preview_params *params, double range[2])
{
    struct weft_statistics s = WEFT_STATISTICS_NONE;
    range[0] = (double)params->low;
    range[1] = (double)params->high;
    if (range[0] != 0.0 || range[1] != 0.0)
        return;
    weft_statistics_add(&s, params->plane, (size_t)params->width * (size_t)params->height);
    range[0] = isnan(s.minimum) ? 0.0 : s.minimum;
    range[1] = isnan(s.minimum) ? 1.0 : s.maximum;
}

static enum weft_result surround(const struct preview_options *options,
                                 struct weft_preview_params *params, struct around *around)
{
    double range[2];
    if (!options->annotation)
        return WEFT_OK;
    struct annotation annotation = *options->annotation;
    find_range(params, range);
    annotation.colour_map = params->colour_map ? params->colour_map : weft_colour_map_list[0];
    annotation.low = range[0];
    annotation.high = range[1];
    params->frame = &around->frame;
    return annotation_create(&annotation, params->width, params->height, &around->list,
                             &around->frame);
}

static enum weft_result surround_colour(const struct preview_options *options,
                                        struct weft_colour_preview_params *params,
                                        struct around *around)
{
    if (!options->annotation)
        return WEFT_OK;
    params->frame = &around->frame;
    return annotation_create(options->annotation, params->width, params->height, &around->list,
                             &around->frame);
}

enum weft_result preview_save(const struct preview_options *options,
                              const struct weft_colour_map *colour_map, int32_t width,
                              int32_t height, const float *plane, float range[2])
{
    struct around around = {.list = NULL};
    struct weft_preview_params *params =
        weft_preview_params(.path = options->preview, .no_clobber = options->no_clobber,
                            .width = width, .height = height, .plane = plane,
                            .colour_map = colour_map, .log = report_log());
    if (options->range->given) {
        params->low = (float)options->range->number[0];
        params->high = (float)options->range->number[1];
    }
    enum weft_result res = surround(options, params, &around);
    report_stage("writing", params->path);
    if (res == WEFT_OK)
        res = weft_preview_save(params, range);
    marks_destroy(&around.list);
    return res;
}

enum weft_result preview_save_colour(const struct preview_options *options, int threads,
                                     int32_t width, int32_t height, const float *const plane[3],
                                     float range[2])
{
    struct around around = {.list = NULL};
    struct weft_colour_preview_params *params =
        weft_colour_preview_params(.path = options->preview, .no_clobber = options->no_clobber,
                                   .width = width, .height = height, .red = plane[0],
                                   .green = plane[1], .blue = plane[2], .threads = threads,
                                   .log = report_log());
    if (options->range->given) {
        params->low = (float)options->range->number[0];
        params->high = (float)options->range->number[1];
    } else {
        params->high = is_given(options->exposure) ? (float)exp2(-options->exposure->number[0]) : 1;
    }
    range[0] = params->low;
    range[1] = params->high;
    enum weft_result res = surround_colour(options, params, &around);
    report_stage("writing", params->path);
    if (res == WEFT_OK)
        res = weft_colour_preview_save(params);
    marks_destroy(&around.list);
    return res;
}
