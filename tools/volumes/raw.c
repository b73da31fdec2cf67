// SPDX-License-Identifier: BSD-3-Clause
#include "tools/volumes/raw.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"

static bool read_size(const char *text, int out[3])
{
    for (int i = 0; i < 3; i++) {
        char *end;
        errno = 0;
        const long size = strtol(text, &end, 10);
        if (end == text || *text < '0' || *text > '9' || errno || size < 1 ||
            size > WEFT_INDEX_LIMIT || *end != (i < 2 ? 'x' : 0))
            return false;
        out[i] = (int)size;
        text = end + 1;
    }
    return true;
}

static bool read_type(const char *text, enum weft_sample_type *out)
{
    for (int t = 0; t < WEFT_SAMPLE_TYPE_COUNT; t++)
        if (!strcmp(text, weft_sample_type_names[t])) {
            *out = (enum weft_sample_type)t;
            return true;
        }
    return false;
}

static bool read_point(const char *text, double out[3])
{
    for (int i = 0; i < 3; i++) {
        char *end;
        out[i] = strtod(text, &end);
        if (end == text || !isfinite(out[i]) || *end != (i < 2 ? ',' : 0))
            return false;
        text = end + 1;
    }
    return true;
}

static bool read_bytes(const char *text, uint64_t *out)
{
    char *end;
    errno = 0;
    *out = strtoull(text, &end, 10);
    return *text >= '0' && *text <= '9' && !*end && !errno && *out <= INT64_MAX;
}

static bool read_field(const char *text, struct weft_raw_layout *out)
{
    if (!strcmp(text, "little") || !strcmp(text, "big")) {
        out->big_endian = *text == 'b';
        return true;
    }
    if (!strncmp(text, "skip=", 5))
        return read_bytes(text + 5, &out->skip);
    if (!strncmp(text, "origin=", 7))
        return read_point(text + 7, out->origin);
    return !strncmp(text, "spacing=", 8) && read_point(text + 8, out->spacing) &&
           out->spacing[0] != 0.0 && out->spacing[1] != 0.0 && out->spacing[2] != 0.0;
}

enum weft_result raw_read(const struct option_value *value, struct weft_raw_layout *out,
                          const struct weft_raw_layout **raw)
{
    char *rest = value->given ? strdup(value->text) : NULL, *copy = rest;
    *out = *weft_raw_layout(.skip = 0);
    *raw = NULL;
    if (!value->given)
        return WEFT_OK;
    if (!copy) {
        report_error("not enough memory for an option");
        return WEFT_ERR_MEMORY;
    }
    const char *field = strsep(&rest, ":");
    const char *what = read_size(field, out->size) ? NULL : "a size is NXxNYxNZ, each 1 to 2^30";
    field = rest ? strsep(&rest, ":") : "";
    if (!what && !read_type(field, &out->type))
        what = "a type is uint8, int8, uint16, int16, uint32, int32, uint64, int64, float or "
               "double";
    while (!what && rest)
        if (!read_field(field = strsep(&rest, ":"), out))
            what = "behind the type stand little, big, skip=BYTES, spacing=X,Y,Z (none of them 0) "
                   "or origin=X,Y,Z";
    free(copy);
    *raw = out;
    if (!what)
        return WEFT_OK;
    report_error("--raw %s: %s", value->text, what);
    return WEFT_ERR_ARGUMENT;
}
