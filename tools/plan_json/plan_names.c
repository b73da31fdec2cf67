// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plan_json/plan_names.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"

static const char separators[] = " \t\n;";

static bool read_split(const char **at, int dims, struct weft_pass_plan_split *split)
{
    *at = weft_tile_name_parse(*at, dims, &split->tile);
    if (!*at || **at != '@')
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

enum weft_result plan_names_parse(const char *text, int dims, struct weft_tile_name **out,
                                  size_t *count)
{
    void *memory;
    enum weft_result res = allocate("--order", text, sizeof **out, &memory, count);
    *out = memory;
    for (size_t i = 0; i < *count && res == WEFT_OK; i++) {
        const char *item = text += strspn(text, separators);
        text = weft_tile_name_parse(text, dims, *out + i);
        if (!text || !strchr(separators, *text))
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
