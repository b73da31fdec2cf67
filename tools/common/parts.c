// SPDX-License-Identifier: BSD-3-Clause
#include "tools/common/parts.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"

int parts_number(const char *text)
{
    char *end;
    const long value = strtol(text, &end, 10);
    return *text >= '0' && *text <= '9' && !*end && value <= INT_MAX ? (int)value : -1;
}

enum weft_result parts_find(const char *input, const struct weft_image_list *list, const char *text,
                            size_t *out)
{
    char names[700] = "";
    const int number = parts_number(text);
    for (size_t p = 0; p < list->count; p++) {
        if (list->images[p].name[0] && strcmp(list->images[p].name, text) == 0) {
            *out = p;
            return WEFT_OK;
        }
        const size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%zu '%s'", p ? ", " : "", p,
                 list->images[p].name);
    }
    *out = (size_t)number;
    if (number >= 0 && *out < list->count)
        return WEFT_OK;
    report_error("%s has no part '%s'; there are: %s", input, text, names);
    return WEFT_ERR_ARGUMENT;
}
