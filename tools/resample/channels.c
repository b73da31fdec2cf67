// SPDX-License-Identifier: BSD-3-Clause
// Which channels `weft resample` takes, and which of them together.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"
#include "tools/resample/job.h"

// ---- names --------------------------------------------------------------------------------------

bool resample_names_channel(const char *list, const char *name)
{
    const size_t size = strlen(name);
    for (const char *at = list; at; at = strchr(at, ',')) {
        at += *at == ',';
        if (strncmp(at, name, size) == 0 && (at[size] == ',' || at[size] == 0))
            return true;
    }
    return false;
}

static void list_channels(const struct weft_image *images, size_t count, char *text, size_t size)
{
    text[0] = 0;
    for (size_t p = 0; p < count; p++)
        for (size_t i = 0; i < images[p].channel_count; i++) {
            const size_t used = strlen(text);
            snprintf(text + used, size - used, "%s%s", used ? ", " : "",
                     images[p].channels[i].name);
        }
}

static void report_missing(const char *input, const struct weft_image *images, size_t count,
                           const char *name)
{
    enum { MOST = 64 };
    const char *names[MOST + 1] = {NULL};
    char explanation[700];
    int known = 0;
    for (size_t p = 0; p < count; p++)
        for (size_t i = 0; i < images[p].channel_count && known < MOST; i++)
            names[known++] = images[p].channels[i].name;
    report_error("%s has no channel '%s'%s", input, name,
                 weft_closest_explain(name, strlen(name), names, explanation, sizeof explanation));
}

static bool has_channel(const struct weft_image *images, size_t count, const char *name)
{
    for (size_t p = 0; p < count; p++)
        for (size_t i = 0; i < images[p].channel_count; i++)
            if (strcmp(images[p].channels[i].name, name) == 0)
                return true;
    return false;
}

enum weft_result resample_check_names(const char *input, const struct weft_image *images,
                                      size_t count, const char *list)
{
    char name[256];
    for (const char *at = list; at; at = strchr(at, ',')) {
        at += *at == ',' && at != list;
        const size_t size = strcspn(at, ",");
        snprintf(name, sizeof name, "%.*s", (int)(size < sizeof name ? size : sizeof name), at);
        const bool there = has_channel(images, count, name);
        if (there && (!at[size] || !resample_names_channel(at + size + 1, name)))
            continue;
        if (there)
            report_error("--channels %s: '%s' is there twice", list, name);
        else
            report_missing(input, images, count, name);
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}

enum weft_result resample_choose_channels(struct resample_job *job)
{
    const struct option_value *list = &job->option[RESAMPLE_CHANNELS];
    const size_t count = job->image.channel_count;
    job->result.channels = calloc(count, sizeof *job->result.channels);
    job->source = calloc(count, sizeof *job->source);
    job->group = calloc(count, sizeof *job->group);
    if (!job->result.channels || !job->source || !job->group) {
        report_error("out of memory for %zu channels", count);
        return WEFT_ERR_MEMORY;
    }
    for (size_t i = 0; i < count; i++) {
        if (list->given && !resample_names_channel(list->text, job->image.channels[i].name))
            continue;
        const size_t at = job->result.channel_count++;
        job->source[at] = i;
        job->result.channels[at] = job->image.channels[i];
        job->result.channels[at].plane = NULL;
        job->result.channels[at].integers = NULL;
    }
    return WEFT_OK;
}

// ---- groups -------------------------------------------------------------------------------------

// Where channel `name` of a layer is ("left." of "left.R"), in the result; -1: nowhere.
static int find_in_layer(const struct weft_image *image, const char *layer, size_t layer_size,
                         const char *name, enum weft_pixel_type type)
{
    for (size_t i = 0; i < image->channel_count; i++) {
        const struct weft_image_channel *c = &image->channels[i];
        if (strncmp(c->name, layer, layer_size) == 0 && strcmp(c->name + layer_size, name) == 0 &&
            c->type == type)
            return (int)i;
    }
    return -1;
}

// The four of the layer that a channel's name ends in R of.
static bool find_colours(const struct weft_image *image, size_t red, struct resample_group *group)
{
    static const char *const names[RESAMPLE_MAX_TOGETHER] = {"R", "G", "B", "A"};
    const struct weft_image_channel *c = &image->channels[red];
    const char *dot = strrchr(c->name, '.');
    const size_t layer_size = dot ? (size_t)(dot + 1 - c->name) : 0;
    if (strcmp(c->name + layer_size, "R") != 0)
        return false;
    *group = (struct resample_group){.count = RESAMPLE_MAX_TOGETHER};
    for (int i = 0; i < RESAMPLE_MAX_TOGETHER; i++) {
        const int at = find_in_layer(image, c->name, layer_size, names[i], c->type);
        if (at < 0)
            return false;
        group->channel[i] = (size_t)at;
    }
    return true;
}

// Four channels of one type, and no more.
static bool find_four(const struct weft_image *image, struct resample_group *group)
{
    if (image->channel_count != RESAMPLE_MAX_TOGETHER)
        return false;
    *group = (struct resample_group){.count = RESAMPLE_MAX_TOGETHER};
    for (size_t i = 0; i < RESAMPLE_MAX_TOGETHER; i++) {
        if (image->channels[i].type != image->channels[0].type)
            return false;
        group->channel[i] = i;
    }
    return true;
}

static bool is_grouped(const struct resample_job *job, size_t channel)
{
    for (size_t g = 0; g < job->group_count; g++)
        for (int c = 0; c < job->group[g].count; c++)
            if (job->group[g].channel[c] == channel)
                return true;
    return false;
}

enum weft_result resample_make_groups(struct resample_job *job)
{
    const struct weft_image *image = &job->result;
    const bool together = job->option[RESAMPLE_TOGETHER].given;
    struct resample_group group;
    for (size_t i = 0; together && i < image->channel_count; i++)
        if (find_colours(image, i, &group))
            job->group[job->group_count++] = group;
    if (together && job->group_count == 0 && find_four(image, &group))
        job->group[job->group_count++] = group;
    if (together && job->group_count == 0) {
        char names[700];
        list_channels(image, 1, names, sizeof names);
        report_error("--together needs R, G, B and A, or four channels, of one type; there are: %s",
                     names);
        return WEFT_ERR_ARGUMENT;
    }
    for (size_t i = 0; i < image->channel_count; i++)
        if (!is_grouped(job, i))
            job->group[job->group_count++] = (struct resample_group){.count = 1, .channel = {i}};
    return WEFT_OK;
}

void resample_group_name(const struct resample_job *job, const struct resample_group *group,
                         char *text, size_t size)
{
    text[0] = 0;
    for (int c = 0; c < group->count; c++) {
        const size_t used = strlen(text);
        snprintf(text + used, size - used, "%s%s", c ? " " : "",
                 job->result.channels[group->channel[c]].name);
    }
    weft_text_clean(text, false);
}
