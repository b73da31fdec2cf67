// SPDX-License-Identifier: BSD-3-Clause
// Which grids are converted.
#include "tools/volumes/convert.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"

void convert_clear(struct convert_job *job)
{
    for (size_t i = 0; i < job->grid_count; i++)
        for (int c = 0; c < 3; c++) {
            weft_volume_destroy(&job->grid[i].volume[c]);
            weft_volume_destroy(&job->grid[i].rest[c]);
        }
    free(job->grid);
    weft_volume_list_clear(&job->list);
    job->grid = NULL;
    job->grid_count = 0;
}

// What opening warns of need not hold for what is written.
static void tell_errors(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    if (level == WEFT_LOG_ERROR)
        report_log()->write(report_log()->priv, level, message);
}

static enum weft_result open_component(const struct convert_job *job,
                                       const struct weft_volume_info *info, int component,
                                       bool rest, weft_volume **out)
{
    static const struct weft_log errors = {tell_errors, NULL};
    const struct weft_volume_open_params params = {.path = job->input,
                                                   .grid = info->name,
                                                   .raw = job->raw,
                                                   .component = component,
                                                   .rest = rest,
                                                   .log = job->whole ? &errors : report_log()};
    return weft_volume_open(&params, out);
}

enum weft_result convert_open_rest(const struct convert_job *job, struct convert_grid *grid)
{
    enum weft_result res = WEFT_OK;
    for (int c = 0; c < grid->info->components && res == WEFT_OK; c++) {
        const struct weft_volume_info *info = weft_volume_get_info(grid->volume[c]);
        if (info->rounded || info->values_rounded)
            res = open_component(job, grid->info, c, true, &grid->rest[c]);
    }
    return res;
}

static enum weft_result add_grid(struct convert_job *job, struct weft_volume_info *info)
{
    struct convert_grid *grid = &job->grid[job->grid_count++];
    enum weft_result res = WEFT_OK;
    *grid = (struct convert_grid){.info = info};
    for (int c = 0; c < info->components && res == WEFT_OK; c++)
        res = open_component(job, info, c, false, &grid->volume[c]);
    return res;
}

static struct weft_volume_info *find(const struct convert_job *job, const char *name, size_t length)
{
    for (size_t i = 0; i < job->list.count; i++)
        if (strlen(job->list.grids[i].name) == length &&
            !strncmp(job->list.grids[i].name, name, length))
            return &job->list.grids[i];
    return NULL;
}

static enum weft_result add_all(struct convert_job *job, bool first_only)
{
    enum weft_result res = WEFT_OK;
    for (size_t i = 0; i < job->list.count && res == WEFT_OK; i++) {
        struct weft_volume_info *info = &job->list.grids[i];
        if (info->supported && (!first_only || !job->grid_count))
            res = add_grid(job, info);
        else if (!first_only)
            report_warning("grid %s is left out: %s", info->name, info->problem);
    }
    if (res == WEFT_OK && !job->grid_count) {
        report_error("%s: none of its %zu grids can be read", job->input, job->list.count);
        return WEFT_ERR_UNSUPPORTED;
    }
    return res;
}

enum { LINE = 300 };

// "; did you mean 'density'?", and the names that there are.
static void tell_names(const struct convert_job *job, const char *name, size_t length,
                       char out[LINE])
{
    const char **names = calloc(job->list.count + 1, sizeof *names);
    size_t used = (size_t)snprintf(out, LINE, "the file has");
    for (size_t i = 0; i < job->list.count && used < LINE - 100; i++)
        used += (size_t)snprintf(out + used, LINE - used, "%s '%.60s'", i ? "," : "",
                                 job->list.grids[i].name);
    for (size_t i = 0; names && i < job->list.count; i++)
        names[i] = job->list.grids[i].name;
    const char *meant = names ? weft_closest_find(name, length, names) : NULL;
    if (meant)
        snprintf(out + used, LINE - used, "; did you mean '%s'?", meant);
    free(names);
}

static enum weft_result add_listed(struct convert_job *job, const char *text)
{
    enum weft_result res = WEFT_OK;
    for (const char *name = text; res == WEFT_OK && *name;) {
        const size_t length = strcspn(name, ",");
        struct weft_volume_info *info = find(job, name, length);
        bool twice = false;
        for (size_t i = 0; i < job->grid_count; i++)
            twice = twice || job->grid[i].info == info;
        if (!info || twice) {
            char names[LINE] = "";
            if (!info)
                tell_names(job, name, length, names);
            report_error("--grid %s: '%.*s' is %s%s", text, (int)length, name,
                         info ? "there twice" : "no grid of the file; ", names);
            return WEFT_ERR_ARGUMENT;
        }
        res = add_grid(job, info);
        name += length + (name[length] == ',');
    }
    return res;
}

// A grid of this very name comes before lists and "all".
enum weft_result convert_open(struct convert_job *job)
{
    const struct option_value *grid = &job->option[CONVERT_GRID];
    enum weft_result res = weft_volume_list_load(
        weft_volume_open_params(.path = job->input, .raw = job->raw, .log = report_log()),
        &job->list);
    if (res != WEFT_OK)
        return res;
    job->grid = calloc(job->list.count + 1, sizeof *job->grid);
    if (!job->grid)
        return WEFT_ERR_MEMORY;
    struct weft_volume_info *named = grid->given ? find(job, grid->text, strlen(grid->text)) : NULL;
    if (named)
        return add_grid(job, named);
    if (!grid->given || !strcmp(grid->text, "all"))
        return add_all(job, !grid->given);
    return add_listed(job, grid->text);
}
