// SPDX-License-Identifier: BSD-3-Clause
// The volumes that a slice shows: grids of its file, and components of grids of vectors.
#include "tools/slice/stages.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/numbered.h"
#include "tools/common/report.h"

// Each open volume is a process that reads it: of more sources than this one is open at a time.
enum { KEPT_OPEN = 8, MAX_SOURCES = 128 };

static void close_source(struct slice_source *source)
{
    weft_volume_destroy(&source->volume);
    weft_volume_destroy(&source->rest);
}

void slice_close(struct slice_setup *setup)
{
    weft_resident_destroy(&setup->resident);
    for (int i = 0; i < setup->source_count; i++)
        close_source(&setup->source[i]);
    free(setup->volume_path);
    setup->volume_path = NULL;
}

void slice_clear_sources(struct slice_setup *setup)
{
    slice_close(setup);
    free(setup->source);
    setup->source = NULL;
    setup->source_count = 0;
}

// ---- which there are ----------------------------------------------------------------------------

static enum weft_result add_source(struct slice_setup *setup, const char *grid, int component,
                                   bool vector)
{
    if (setup->source_count >= MAX_SOURCES) {
        report_error("more than %d grids, and components of grids, in one slice", MAX_SOURCES);
        return WEFT_ERR_LIMIT;
    }
    struct slice_source *grown =
        realloc(setup->source, ((size_t)setup->source_count + 1) * sizeof *grown);
    if (!grown)
        return WEFT_ERR_MEMORY;
    setup->source = grown;
    grown += setup->source_count++;
    *grown = (struct slice_source){.component = component, .vector = vector};
    snprintf(grown->grid, sizeof grown->grid, "%s", grid);
    return WEFT_OK;
}

// A grid's components, but for the first one of those that are known.
static enum weft_result add_grid(struct slice_setup *setup, const char *grid, int from,
                                 int components)
{
    char name[sizeof setup->source->grid]; // which may be that of a source, and they move
    enum weft_result res = WEFT_OK;
    snprintf(name, sizeof name, "%s", grid);
    for (int c = from; c < components && res == WEFT_OK; c++)
        res = add_source(setup, name, c, components > 1);
    return res;
}

static const struct weft_volume_info *find_grid(const struct weft_volume_list *list,
                                                const char *name, size_t length)
{
    for (size_t i = 0; i < list->count; i++)
        if (strlen(list->grids[i].name) == length && !strncmp(list->grids[i].name, name, length))
            return &list->grids[i];
    return NULL;
}

static enum weft_result add_all(struct slice_setup *setup, const struct weft_volume_list *list)
{
    enum weft_result res = WEFT_OK;
    for (size_t i = 0; i < list->count && res == WEFT_OK; i++) {
        const struct weft_volume_info *info = &list->grids[i];
        if (info->supported && !info->empty)
            res = add_grid(setup, info->name, 0, info->components);
        else
            report_note("grid %s is left out: %s", info->name,
                        info->empty ? "it has no active voxel" : info->problem);
    }
    if (res == WEFT_OK && !setup->source_count) {
        report_error("%s: --grid all: none of its %zu grids can be sliced", setup->input,
                     list->count);
        return WEFT_ERR_UNSUPPORTED;
    }
    return res;
}

// "density,temperature". Names that are not there are told when they are opened, with all that are.
static enum weft_result add_listed(struct slice_setup *setup, const struct weft_volume_list *list,
                                   const char *text)
{
    enum weft_result res = WEFT_OK;
    for (; res == WEFT_OK; text++) {
        const size_t length = strcspn(text, ",");
        const struct weft_volume_info *info = find_grid(list, text, length);
        char name[sizeof setup->source->grid];
        snprintf(name, sizeof name, "%.*s", (int)length, text);
        for (int i = 0; i < setup->source_count; i++)
            if (!strcmp(setup->source[i].grid, name)) {
                report_error("--grid: %s is there twice", name);
                return WEFT_ERR_ARGUMENT;
            }
        if (!length) {
            report_error("--grid: a name of the list is empty");
            return WEFT_ERR_ARGUMENT;
        }
        res = add_grid(setup, name, 0, info ? info->components : 1);
        text += length;
        if (!*text)
            break;
    }
    return res;
}

// A grid of this very name comes before lists and "all".
static enum weft_result read_list(struct slice_job *job, const char *text)
{
    struct slice_setup *setup = job->setup;
    struct weft_volume_list list;
    enum weft_result res = weft_volume_list_load(
        weft_volume_open_params(.path = job->input, .raw = setup->raw, .log = report_log()), &list);
    if (res != WEFT_OK)
        return res;
    const struct weft_volume_info *info = find_grid(&list, text, strlen(text));
    if (info)
        res = add_grid(setup, info->name, 0, info->components);
    else
        res = strcmp(text, "all") == 0 ? add_all(setup, &list) : add_listed(setup, &list, text);
    weft_volume_list_clear(&list);
    return res;
}

static bool is_list(const char *text)
{
    return text && (strchr(text, ',') || strcmp(text, "all") == 0);
}

// ---- opened -------------------------------------------------------------------------------------

enum weft_result slice_begin(struct slice_setup *setup)
{
    const char *grid = setup->option[SLICE_GRID].text;
    const struct weft_volume_open_params params = {
        .path = setup->input, .grid = grid, .raw = setup->raw, .log = report_log()};
    return numbered_is(setup->input) || is_list(grid) ? WEFT_OK
                                                      : weft_volume_begin(&params, &setup->opening);
}

// What was begun, or another.
static enum weft_result open_source(struct slice_job *job, struct slice_source *source)
{
    struct slice_setup *setup = job->setup;
    const struct weft_volume_open_params params = {.path = job->input,
                                                   .grid = source->grid[0] ? source->grid : NULL,
                                                   .raw = setup->raw,
                                                   .component = source->component,
                                                   .log = report_log()};
    if (setup->opening && source == setup->source && strcmp(job->input, setup->input) == 0)
        return weft_volume_await(&setup->opening, &source->volume);
    return weft_volume_open(&params, &source->volume);
}

// A name of the file is one of its channels', too.
static void name_source(const struct slice_setup *setup, struct slice_source *source)
{
    static const char *const axes[] = {"X", "Y", "Z"};
    const struct weft_volume_info *info = weft_volume_get_info(source->volume);
    bool alone = true;
    for (int i = 0; i < setup->source_count; i++)
        alone = alone && !strcmp(setup->source[i].grid, source->grid);
    const char *axis = source->vector ? axes[source->component] : "";
    if (alone)
        snprintf(source->name, sizeof source->name, "%s", source->vector ? axis : "Y");
    else
        snprintf(source->name, sizeof source->name, "%s%s%s", info->name, source->vector ? "." : "",
                 axis);
    if (!alone || source->vector)
        snprintf(source->prefix, sizeof source->prefix, "%s.", source->name);
}

// What a file has room for, with the longest name of a quantity's channel.
static enum weft_result check_name(const struct slice_source *source)
{
    enum { LONGEST = 255 - 22 };
    if (strlen(source->name) <= LONGEST)
        return WEFT_OK;
    report_error("grid %s: its name is too long for channels, %zu bytes of %d at most",
                 source->grid, strlen(source->name), LONGEST);
    return WEFT_ERR_LIMIT;
}

// The sources of the first volume: of a grid that was named, or not, they are known once it is
// open.
static enum weft_result find_sources(struct slice_job *job)
{
    struct slice_setup *setup = job->setup;
    const char *grid = setup->option[SLICE_GRID].text;
    enum weft_result res =
        is_list(grid) ? read_list(job, grid) : add_source(setup, grid ? grid : "", 0, false);
    if (res != WEFT_OK || is_list(grid))
        return res;
    res = open_source(job, setup->source);
    if (res != WEFT_OK)
        return res;
    const int components = weft_volume_get_info(setup->source->volume)->components;
    setup->source->vector = components > 1;
    return add_grid(setup, setup->source->grid, 1, components);
}

static enum weft_result take_first_volume(struct slice_job *job)
{
    const enum weft_result res = find_sources(job);
    return res == WEFT_OK ? slice_check_channels(job->setup) : res;
}

static enum weft_result check_components(const struct slice_job *job,
                                         const struct slice_source *source)
{
    const struct weft_volume_info *info = weft_volume_get_info(source->volume);
    if ((info->components > 1) == source->vector)
        return WEFT_OK;
    report_error("%s: grid %s has %d component%s: the first volume's has not", job->input,
                 info->name, info->components, info->components > 1 ? "s" : "");
    return WEFT_ERR_UNSUPPORTED;
}

// Coordinates of index space are those of one.
static enum weft_result check_space(const struct slice_job *job, const struct slice_source *source)
{
    const struct slice_source *first = job->setup->source;
    if (job->setup->option[SLICE_SPACE].integer[0] != WEFT_SPACE_INDEX || source == first ||
        !first->volume)
        return WEFT_OK;
    const struct weft_volume_info *a = weft_volume_get_info(first->volume),
                                  *b = weft_volume_get_info(source->volume);
    if (!memcmp(a->index_to_world, b->index_to_world, sizeof a->index_to_world))
        return WEFT_OK;
    report_error("--space index: voxels of %s (%s) and %s (%s) do not lie at the same places: give "
                 "the plane in world space",
                 a->name, first->name, b->name, source->name);
    return WEFT_ERR_ARGUMENT;
}

static enum weft_result open_next(struct slice_job *job, struct slice_source *source)
{
    enum weft_result res = source->volume ? WEFT_OK : open_source(job, source);
    if (res == WEFT_OK)
        res = check_components(job, source);
    if (res != WEFT_OK)
        return res;
    name_source(job->setup, source);
    const enum weft_result named = check_name(source);
    return named == WEFT_OK ? check_space(job, source) : named;
}

enum weft_result slice_open(struct slice_job *job)
{
    struct slice_setup *setup = job->setup;
    const double start = report_now_seconds();
    enum weft_result res = WEFT_OK;
    if (!setup->volume_path || strcmp(setup->volume_path, job->input) != 0) {
        slice_close(setup);
        report_stage("reading", job->input);
        setup->volume_path = strdup(job->input);
        res = setup->volume_path ? WEFT_OK : WEFT_ERR_MEMORY;
    }
    if (res == WEFT_OK && !setup->source_count)
        res = take_first_volume(job);
    if (res == WEFT_OK)
        res = open_next(job, setup->source);
    if (res == WEFT_OK) {
        job->source = setup->source;
        job->volume = setup->source->volume;
    }
    job->open_seconds += report_now_seconds() - start;
    return res;
}

enum weft_result slice_take_source(struct slice_job *job, int index)
{
    struct slice_setup *setup = job->setup;
    const double start = report_now_seconds();
    if (index == 0)
        return WEFT_OK;
    // The first one stays: planes are placed by it.
    if (index > 1 && setup->source_count > KEPT_OPEN) {
        slice_release(job);
        close_source(&setup->source[index - 1]);
    }
    const enum weft_result res = open_next(job, &setup->source[index]);
    if (res == WEFT_OK) {
        slice_release(job);
        job->source = &setup->source[index];
        job->volume = job->source->volume;
    }
    job->open_seconds += report_now_seconds() - start;
    return res;
}
