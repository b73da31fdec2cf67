// SPDX-License-Identifier: BSD-3-Clause
#include "tools/common/numbered.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/paths.h"
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

// ---- spans --------------------------------------------------------------------------------------

// Digits and nothing else, up to the largest number.
static bool read_number(const char **at, int64_t *out)
{
    const size_t length = strspn(*at, "0123456789");
    if (length < 1 || length > 9)
        return false;
    *out = strtoll(*at, NULL, 10);
    *at += length;
    return true;
}

enum weft_result numbered_read_span(const char *text, int64_t most, struct numbered_span *out)
{
    const char *at = text;
    out->step = 1;
    bool good = read_number(&at, &out->first) && *at++ == '-' && read_number(&at, &out->last);
    if (good && *at == ':') {
        at++;
        good = read_number(&at, &out->step);
    }
    if (!good || *at)
        report_error("--frames: '%s' is not FIRST-LAST or FIRST-LAST:STEP, whole numbers from 0 to "
                     "%d, as 1-100",
                     text, NUMBERED_MAX);
    else if (out->first > out->last)
        report_error("--frames %s: FIRST is more than LAST", text);
    else if (out->step == 0)
        report_error("--frames %s: STEP must be 1 or more", text);
    else if ((out->last - out->first) / out->step >= most)
        report_error("--frames %s: these are %lld frames; there may be at most %d", text,
                     (long long)((out->last - out->first) / out->step + 1), (int)most);
    else
        return WEFT_OK;
    return WEFT_ERR_ARGUMENT;
}

// ---- files --------------------------------------------------------------------------------------

struct known_file {
    struct paths_identity identity;
    const struct numbered_file *file;
};

static int compare(const void *a, const void *b)
{
    const struct known_file *x = a, *y = b;
    const int order = paths_compare(&x->identity, &y->identity);
    return order ? order : (x->file->frame > y->file->frame) - (x->file->frame < y->file->frame);
}

static const struct known_file *find_output(const struct known_file *known, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!known[i].file->input)
            return &known[i];
    return NULL;
}

// Of files that are one: frames may read it, or one may write it.
static enum weft_result check_group(const struct known_file *known, size_t count)
{
    const struct known_file *output = find_output(known, count);
    if (count == 1 || !output)
        return WEFT_OK;
    const struct numbered_file *other = (output == known ? known + 1 : known)->file;
    report_error("%s is written by frame %lld, and %s by frame %lld", output->file->path,
                 (long long)output->file->frame, other->input ? "read" : "written",
                 (long long)other->frame);
    return WEFT_ERR_ARGUMENT;
}

enum weft_result numbered_check_files(const struct numbered_file *file, size_t count)
{
    struct known_file *known = calloc(count ? count : 1, sizeof *known);
    enum weft_result res = WEFT_OK;
    if (!known) {
        report_error("out of memory for the names of %zu files", count);
        return WEFT_ERR_MEMORY;
    }
    for (size_t i = 0; i < count; i++)
        known[i] = (struct known_file){paths_identify(file[i].path), &file[i]};
    qsort(known, count, sizeof *known, compare);
    for (size_t at = 0, end; at < count && res == WEFT_OK; at = end) {
        for (end = at + 1;
             end < count && paths_compare(&known[at].identity, &known[end].identity) == 0;)
            end++;
        res = check_group(known + at, end - at);
    }
    free(known);
    return res;
}
