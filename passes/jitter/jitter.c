// SPDX-License-Identifier: BSD-3-Clause
// The list of sets, their texts, and what is made of their points.
#include "passes/jitter/jitter.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "filter/closest.h"
#include "passes/jitter/sets.h"

enum { MAX_TEXT = 63, MAX_NAMES = 32 };

const char *const weft_jitter_shape_names[] = {"square", "disc", NULL};

const struct weft_jitter_info *const weft_jitter_list[] = {
    &weft_jitter_tables[0],  &weft_jitter_tables[1], &weft_jitter_tables[2],
    &weft_jitter_tables[3],  &weft_jitter_tables[4], &weft_jitter_tables[5],
    &weft_jitter_tables[6],  &weft_jitter_msaa,      &weft_jitter_grid,
    &weft_jitter_stratified, &weft_jitter_halton,    &weft_jitter_hammersley,
    &weft_jitter_sobol,      &weft_jitter_r2,        NULL,
};

static const struct weft_jitter_info *find(const char *name, size_t length)
{
    for (size_t i = 0; weft_jitter_list[i]; i++)
        if (strlen(weft_jitter_list[i]->name) == length &&
            !memcmp(weft_jitter_list[i]->name, name, length))
            return weft_jitter_list[i];
    return NULL;
}

const struct weft_jitter_info *weft_jitter_find(const char *name)
{
    return name ? find(name, strlen(name)) : NULL;
}

// ---- texts
// ----------------------------------------------------------------------------------------

static void append(char *text, size_t size, const char *more)
{
    const size_t used = strlen(text);
    snprintf(text + used, size - used, "%s", more);
}

// "1, 2, 4, 8 or 16".
static void format_counts(const int *counts, char *text, size_t size)
{
    text[0] = 0;
    for (size_t i = 0; counts[i]; i++) {
        char number[24];
        snprintf(number, sizeof number, "%s%d",
                 i == 0          ? ""
                 : counts[i + 1] ? ", "
                                 : " or ",
                 counts[i]);
        append(text, size, number);
    }
}

static void log_unknown(const struct weft_log *log, const char *text, size_t length)
{
    const char *names[MAX_NAMES] = {NULL};
    char explanation[512];
    for (size_t i = 0; weft_jitter_list[i] && i + 1 < MAX_NAMES; i++)
        names[i] = weft_jitter_list[i]->name;
    weft_error(log, "no set of samples '%.*s'%s", (int)length, text,
               weft_closest_explain(text, length, names, explanation, sizeof explanation));
}

static bool has_count(const struct weft_log *log, const struct weft_jitter_info *info, int count)
{
    if (!info->counts) {
        const bool good = count >= 1 && count <= WEFT_JITTER_MAX;
        if (!good)
            weft_error(log, "set of samples %s has 1 to %d points, not %d", info->name,
                       WEFT_JITTER_MAX, count);
        return good;
    }
    for (size_t i = 0; info->counts[i]; i++)
        if (info->counts[i] == count)
            return true;
    char counts[128];
    format_counts(info->counts, counts, sizeof counts);
    weft_error(log, "set of samples %s has %s points, not %d", info->name, counts, count);
    return false;
}

// A number of points: decimal digits and nothing else.
static bool parse_count(const struct weft_log *log, const struct weft_jitter_info *info,
                        const char *text, int *count)
{
    const size_t digits = strspn(text, "0123456789");
    if (digits == 0 || digits > 9 || text[digits]) {
        weft_error(log, "set of samples %s: '%s' is no number of points", info->name, text);
        return false;
    }
    *count = atoi(text);
    return has_count(log, info, *count);
}

enum weft_result weft_jitter_parse(const struct weft_log *log, const char *text,
                                   const struct weft_jitter_info **info, int *count)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(log, text && info && count);
    *info = NULL;
    *count = 0;
    if (strnlen(text, MAX_TEXT + 1) > MAX_TEXT) {
        weft_error(log, "the name of a set of samples is longer than %d bytes: '%.32s...'",
                   MAX_TEXT, text);
        goto fail;
    }
    const size_t length = strcspn(text, ":");
    const struct weft_jitter_info *found = find(text, length);
    if (!found) {
        log_unknown(log, text, length);
        goto fail;
    }
    if (text[length] && !parse_count(log, found, text + length + 1, count)) {
        *count = 0;
        goto fail;
    }
    *info = found;
    res = WEFT_OK;
fail:
    return res;
}

// ---- points
// ---------------------------------------------------------------------------------------

// Shirley and Chiu's map, of a square of side 1 onto a disc of diameter 1: the ring at distance
// r = max(|x|, |y|) from the centre becomes the circle of radius r.
static void map_to_disc(double point[2])
{
    const double x = point[0], y = point[1];
    const bool wide = fabs(x) >= fabs(y);
    const double r = wide ? x : y;
    if (r == 0.0)
        return;
    const double angle = wide ? M_PI_4 * (y / x) : M_PI_2 - M_PI_4 * (x / y);
    point[0] = r * cos(angle);
    point[1] = r * sin(angle);
}

// The mean along an axis, with Neumaier's sum, so that no rounding of many points adds up.
static double find_mean(const struct weft_jitter *set, int axis)
{
    double sum = 0.0, rest = 0.0;
    for (int i = 0; i < set->count; i++) {
        const double value = set->points[i][axis], next = sum + value;
        rest += fabs(sum) >= fabs(value) ? sum - next + value : value - next + sum;
        sum = next;
    }
    return (sum + rest) / set->count;
}

static void finish(const struct weft_jitter_params *params, double size, struct weft_jitter *set)
{
    for (int i = 0; i < set->count; i++) {
        if (params->shape == WEFT_JITTER_DISC)
            map_to_disc(set->points[i]);
        for (int axis = 0; axis < 2; axis++)
            set->points[i][axis] *= size;
    }
    for (int axis = 0; axis < 2; axis++) {
        set->mean[axis] = find_mean(set, axis);
        if (!params->centre)
            continue;
        set->shift[axis] = set->mean[axis];
        for (int i = 0; i < set->count; i++)
            set->points[i][axis] -= set->shift[axis];
        set->mean[axis] = find_mean(set, axis);
    }
}

enum weft_result weft_jitter_create(const struct weft_jitter_params *params,
                                    struct weft_jitter *out)
{
    const struct weft_log *log = params ? params->log : NULL;
    struct weft_jitter set = {.info = params ? params->info : NULL};
    enum weft_result res = WEFT_ERR_ARGUMENT;
    *out = (struct weft_jitter){0};
    weft_require(log, params && params->info && params->info->name && params->info->compute);
    weft_require_enum(log, params->shape, WEFT_JITTER_SHAPE_COUNT - 1);
    const double size = params->size == 0.0 ? 1.0 : params->size;
    if (!(size >= 0x1p-100 && size <= 0x1p100)) {
        weft_error(log, "the size of a set of samples is %g: it must be in 2^-100 to 2^100", size);
        goto fail;
    }
    set.count = params->count == 0 ? set.info->default_count : params->count;
    if (!has_count(log, set.info, set.count))
        goto fail;
    set.points = malloc((size_t)set.count * sizeof *set.points);
    if (!set.points) {
        weft_error(log, "no memory for %d samples", set.count);
        res = WEFT_ERR_MEMORY;
        goto fail;
    }
    set.info->compute(set.info, set.count, params->seed, set.points);
    finish(params, size, &set);
    *out = set;
    return WEFT_OK;
fail:
    return res;
}

void weft_jitter_clear(struct weft_jitter *set)
{
    if (!set)
        return;
    free(set->points);
    *set = (struct weft_jitter){0};
}
