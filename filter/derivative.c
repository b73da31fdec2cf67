// SPDX-License-Identifier: BSD-3-Clause
#include <string.h>

#include "filter/check.h"
#include "filter/quantity.h"

int weft_derivative_order(const struct weft_derivative *derivative)
{
    int order = 0;
    for (int axis = 0; axis < 3; axis++) {
        if (derivative->along[axis] < 0 || derivative->along[axis] > 2)
            return -1;
        order += derivative->along[axis];
    }
    return order <= 2 ? order : -1;
}

const char *weft_derivative_format(const struct weft_derivative *derivative,
                                   char text[WEFT_DERIVATIVE_TEXT])
{
    int end = 0;
    if (weft_derivative_order(derivative) < 0)
        return strcpy(text, "unknown");
    for (int axis = 0; axis < 3; axis++)
        for (int i = 0; i < derivative->along[axis]; i++)
            text[end++] = "xyz"[axis];
    text[end] = 0;
    return end ? text : strcpy(text, "none");
}

enum weft_result weft_derivative_parse(const struct weft_log *log, const char *text,
                                       struct weft_derivative *out)
{
    const size_t length = strlen(text);
    *out = (struct weft_derivative){{0, 0, 0}};
    if (strcmp(text, "none") == 0)
        return WEFT_OK;
    if (length >= 1 && length <= 2 && strspn(text, "xyz") == length) {
        for (size_t i = 0; i < length; i++)
            out->along[text[i] - 'x']++;
        return WEFT_OK;
    }
    weft_error(log, "no derivative '%.16s': there are x, y, z, xx, xy, xz, yy, yz, zz and none",
               text);
    return WEFT_ERR_ARGUMENT;
}
