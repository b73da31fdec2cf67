// SPDX-License-Identifier: BSD-3-Clause
#include "tools/scene/arguments.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/log.h"

bool scene_read_number(const char **at, double *out)
{
    // strtod takes blanks in front, hexadecimal numbers, infinities and NAN, too.
    const size_t length = strspn(*at, "+-.0123456789eE");
    char *end;
    if (length == 0)
        return false;
    *out = strtod(*at, &end);
    if (end != *at + length || !isfinite(*out))
        return false;
    *at = end;
    return true;
}

static enum weft_result complain(const struct weft_log *log, const char *scene, const char *text,
                                 const struct scene_argument *a)
{
    log_error(log, "%s:%.200s: %s must be a%s number from %.15g to %.15g", scene, text, a->name,
              a->whole ? " whole" : "", a->least, a->most);
    return WEFT_ERR_ARGUMENT;
}

enum weft_result scene_read_arguments(const struct weft_log *log, const char *scene,
                                      const char *text, int count, struct scene_argument *argument)
{
    const char *at = text;
    for (int i = 0; i < count && at; i++) {
        struct scene_argument *a = &argument[i];
        const bool good = scene_read_number(&at, &a->value) && (*at == ',' || *at == '\0');
        if (!good || a->value < a->least || a->value > a->most ||
            (a->whole && a->value != floor(a->value)))
            return complain(log, scene, text, a);
        at = *at == ',' ? at + 1 : NULL;
    }
    if (!at || !text)
        return WEFT_OK;
    log_error(log, "%s:%.200s: there is more than the scene's %d numbers: %.100s", scene, text,
              count, at);
    return WEFT_ERR_ARGUMENT;
}
