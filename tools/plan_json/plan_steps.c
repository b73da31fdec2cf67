// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plan_json/plan_steps.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"

static const char separators[] = " \t\n;";

// A whole number from 0 to 99999 at *at, which moves behind it.
static bool read_whole(const char **at, int *out)
{
    const char *start = *at;
    for (*out = 0; isdigit((unsigned char)**at) && *at - start < 5; (*at)++)
        *out = 10 * *out + (**at - '0');
    return *at > start && !isdigit((unsigned char)**at);
}

static bool read_step(const char **at, int dims, struct weft_tile_name *step)
{
    *step = (struct weft_tile_name){.part = WEFT_TILE_WHOLE};
    for (int a = 0; a < dims; a++) {
        if (a && *(*at)++ != ',')
            return false;
        if (!read_whole(at, &step->tap[a]))
            return false;
    }
    if (**at == '+' || **at == '-')
        step->part = *(*at)++ == '+' ? WEFT_TILE_POSITIVE : WEFT_TILE_NEGATIVE;
    if (**at != '/')
        return true;
    (*at)++;
    return read_whole(at, &step->piece);
}

static bool read_split(const char **at, int dims, struct weft_pass_plan_split *split)
{
    if (!read_step(at, dims, &split->tile) || **at != '@')
        return false;
    char *end;
    split->threshold = strtod(++*at, &end);
    const bool there = end > *at && !isspace((unsigned char)**at);
    *at = end;
    return there && isfinite(split->threshold);
}

static enum weft_result refuse(const char *option, const char *item, int dims, const char *suffix)
{
    report_error("%s: '%.*s' is not a tap as 1,0%s, with + or - behind it for its part of that "
                 "sign, /N for a piece%s",
                 option, (int)strcspn(item, separators), item, dims == 3 ? ",2" : "", suffix);
    return WEFT_ERR_ARGUMENT;
}

static size_t count_items(const char *text)
{
    size_t count = 0;
    while (*(text += strspn(text, separators))) {
        text += strcspn(text, separators);
        count++;
    }
    return count;
}

static enum weft_result allocate(const char *option, const char *text, size_t size, void **out,
                                 size_t *count)
{
    *count = count_items(text);
    *out = calloc(*count + 1, size);
    if (!*out) {
        report_error("out of memory for %zu taps", *count);
        return WEFT_ERR_MEMORY;
    }
    if (*count)
        return WEFT_OK;
    report_error("%s: there is no tap in it", option);
    return WEFT_ERR_ARGUMENT;
}

enum weft_result plan_steps_parse(const char *text, int dims, struct weft_tile_name **out,
                                  size_t *count)
{
    void *memory;
    enum weft_result res = allocate("--order", text, sizeof **out, &memory, count);
    *out = memory;
    for (size_t i = 0; i < *count && res == WEFT_OK; i++) {
        const char *item = text += strspn(text, separators);
        if (!read_step(&text, dims, *out + i) || !strchr(separators, *text))
            res = refuse("--order", item, dims, "");
    }
    return res;
}

enum weft_result plan_splits_parse(const char *text, int dims, struct weft_pass_plan_split **out,
                                   size_t *count)
{
    void *memory;
    enum weft_result res = allocate("--split", text, sizeof **out, &memory, count);
    *out = memory;
    for (size_t i = 0; i < *count && res == WEFT_OK; i++) {
        const char *item = text += strspn(text, separators);
        if (!read_split(&text, dims, *out + i) || !strchr(separators, *text))
            res = refuse("--split", item, dims, ", and @T with a threshold");
    }
    return res;
}

const char *plan_step_format(const struct weft_tile_name *step, int dims, char text[PLAN_STEP_TEXT])
{
    static const char *const parts[] = {"", "+", "-"};
    int used = snprintf(text, PLAN_STEP_TEXT, "(%d,%d", step->tap[0], step->tap[1]);
    if (dims == 3)
        used += snprintf(text + used, PLAN_STEP_TEXT - (size_t)used, ",%d", step->tap[2]);
    used += snprintf(text + used, PLAN_STEP_TEXT - (size_t)used, ")%s", parts[step->part]);
    if (step->piece)
        snprintf(text + used, PLAN_STEP_TEXT - (size_t)used, "/%d", step->piece);
    return text;
}

// Pieces lie behind the unsplit tiles, so the first of a tap and part is the one that was split.
struct weft_tile_name *plan_steps_of(const weft_kernel_tiles *tiles)
{
    const int count = weft_kernel_tiles_get_info(tiles)->tile_count;
    struct weft_tile_name *steps = calloc((size_t)count + 1, sizeof *steps);
    for (int i = 0; steps && i < count; i++) {
        const struct weft_kernel_tile *tile = weft_kernel_tiles_get(tiles, i);
        const int first = weft_kernel_tiles_find(tiles, tile->tap, tile->part);
        memcpy(steps[i].tap, tile->tap, sizeof tile->tap);
        steps[i].part = tile->part;
        // How many pieces there are so far stands with the first.
        steps[i].piece = first < i ? ++steps[first].piece : 0;
    }
    for (int i = 0; steps && i < count; i++)
        if (weft_kernel_tiles_find(tiles, steps[i].tap, steps[i].part) == i)
            steps[i].piece = 0;
    return steps;
}

struct weft_tile_name *plan_steps_shortened(const weft_kernel_tiles *tiles)
{
    static const enum weft_tile_part other[] = {WEFT_TILE_WHOLE, WEFT_TILE_NEGATIVE,
                                                WEFT_TILE_POSITIVE};
    struct weft_tile_name *steps = plan_steps_of(tiles);
    for (int i = 0; steps && i < weft_kernel_tiles_get_info(tiles)->tile_count; i++)
        if (weft_kernel_tiles_find(tiles, steps[i].tap, other[steps[i].part]) < 0)
            steps[i].part = WEFT_TILE_WHOLE;
    return steps;
}
