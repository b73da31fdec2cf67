// SPDX-License-Identifier: BSD-3-Clause
#include "tools/common/numbered.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"

// The length of "%d" or "%04d" at a percent sign, 0 if that is something else; *digits: at least so
// many.
static size_t conversion_length(const char *percent, int *digits)
{
    const bool wide = percent[1] == '0' && percent[2] >= '1' && percent[2] <= '9';
    *digits = wide ? percent[2] - '0' : 1;
    return percent[wide ? 3 : 1] == 'd' ? wide ? 4 : 2 : 0;
}

// The next percent sign but for those that are doubled; NULL: there is none.
static const char *find_percent(const char *name)
{
    const char *at = strchr(name, '%');
    while (at && at[1] == '%')
        at = strchr(at + 2, '%');
    return at;
}

bool numbered_is(const char *name)
{
    int digits;
    const char *at = find_percent(name);
    while (at && !conversion_length(at, &digits))
        at = find_percent(at + 1);
    return at != NULL;
}

enum weft_result numbered_check(const char *option, const char *name, bool required)
{
    int count = 0, digits;
    for (const char *at = find_percent(name); at; count++) {
        const size_t length = conversion_length(at, &digits);
        if (!length) {
            report_error(
                "%s%s: '%.3s' is neither a frame's number, which is %%d or %%01d to %%09d, "
                "nor a percent sign, which is %%%%",
                option, name, at);
            return WEFT_ERR_ARGUMENT;
        }
        at = find_percent(at + length);
    }
    if (count > 1)
        report_error("%s%s: the frame's number is there %d times", option, name, count);
    else if (required && !count)
        report_error("%s%s: every frame would have this name: put its number in, as in %%04d",
                     option, name);
    return count > 1 || (required && !count) ? WEFT_ERR_ARGUMENT : WEFT_OK;
}

char *numbered_format(const char *name, int64_t number)
{
    char *text = NULL;
    size_t size = 0;
    int digits;
    FILE *out = open_memstream(&text, &size);
    while (out && *name) {
        const size_t length = *name == '%' ? conversion_length(name, &digits) : 0;
        if (length)
            fprintf(out, "%0*lld", digits, (long long)number);
        else
            fputc(*name, out);
        name += length ? length : *name == '%' ? 2 : 1;
    }
    if (out && report_close(out))
        return text;
    free(text);
    return NULL;
}
