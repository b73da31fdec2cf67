// SPDX-License-Identifier: BSD-3-Clause
#include "tools/common/hint.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *hint_number(const char *text, char hint[HINT_TEXT])
{
    char *end;
    *hint = 0;
    const size_t digits = strspn(text, "+-0123456789");
    if (strstr(text, "\u2212") || strstr(text, "\u2013") || strstr(text, "\u2014"))
        snprintf(hint, HINT_TEXT, " (its minus is a dash that is not '-')");
    else if (text[digits] == ',' && strlen(text) < 32 &&
             !text[digits + 1 + strspn(text + digits + 1, "0123456789")])
        snprintf(hint, HINT_TEXT, " (decimals have a point: %.*s.%s)", (int)digits, text,
                 text + digits + 1);
    else if (strtod(text, &end), end != text && (isalpha((unsigned char)*end) || *end == '%'))
        snprintf(hint, HINT_TEXT, " (without '%.16s')", end);
    return hint;
}
