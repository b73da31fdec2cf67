// SPDX-License-Identifier: BSD-3-Clause
// Options that frame pictures.
#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/hint.h"
#include "tools/common/report.h"
#include "tools/framing/framing.h"

// ---- sizes --------------------------------------------------------------------------------------

static bool read_side(const char *text, char **end, int64_t *out)
{
    errno = 0;
    *out = strtoll(text, end, 10);
    return isdigit((unsigned char)*text) && errno == 0;
}

enum weft_result framing_read_size(const char *text, int most, int64_t most_pixels,
                                   struct framing_size *out)
{
    int64_t side[2] = {0};
    char *end;
    *out = (struct framing_size){.longer = 0};
    const bool first = read_side(text, &end, &side[0]), alone = first && *end == 0;
    if (!first || (!alone && (*end != 'x' || !read_side(end + 1, &end, &side[1]) || *end))) {
        report_error("--size %s: it is WxH, as 1024x768, Wx0 or 0xH, or N, the longer side", text);
        return WEFT_ERR_ARGUMENT;
    }
    if (side[0] > most || side[1] > most || (!side[0] && !side[1])) {
        report_error("--size %s: width and height must be from 1 to %d, or one of them 0, which "
                     "follows from the other",
                     text, most);
        return WEFT_ERR_ARGUMENT;
    }
    if (side[0] * side[1] > most_pixels) {
        report_error("--size %s: there may be at most %lld pixels in all", text,
                     (long long)most_pixels);
        return WEFT_ERR_ARGUMENT;
    }
    out->longer = alone ? (int)side[0] : 0;
    out->side[0] = alone ? 0 : (int)side[0];
    out->side[1] = (int)side[1];
    return WEFT_OK;
}

// ---- places -------------------------------------------------------------------------------------

// Up to `end`, a number or a percentage.
static bool read_place(const char *text, const char *end, double *at, bool *part)
{
    char *stop;
    if (isspace((unsigned char)*text))
        return false;
    *at = strtod(text, &stop);
    *part = *stop == '%';
    if (*part)
        *at /= 100.0;
    return stop != text && isfinite(*at) && stop + *part == end;
}

// "1..2" is not "1." and ".2".
enum weft_result framing_read_at(const char *text, struct framing_span *out)
{
    const char *dots = strstr(text, "..");
    char first[64];
    const size_t length = dots ? (size_t)(dots - text) : strlen(text);
    *out = (struct framing_span){.moves = dots != NULL};
    if (length < sizeof first) {
        memcpy(first, text, length);
        first[length] = 0;
        if (read_place(first, first + length, &out->at[0], &out->part[0]) &&
            (!dots || read_place(dots + 2, dots + strlen(dots), &out->at[1], &out->part[1]))) {
            out->at[1] = dots ? out->at[1] : out->at[0];
            out->part[1] = dots ? out->part[1] : out->part[0];
            return WEFT_OK;
        }
    }
    char hint[HINT_TEXT];
    report_error("--at: '%s' is neither one finite number or percentage nor two, as A..B%s", text,
                 hint_number(text, hint));
    return WEFT_ERR_ARGUMENT;
}

// ---- directions and boxes -----------------------------------------------------------------------

// So many numbers and commas between them, and nothing else.
static bool read_numbers(const char *text, int count, double *out)
{
    for (int i = 0; i < count; i++) {
        char *end;
        if (isspace((unsigned char)*text))
            return false;
        out[i] = strtod(text, &end);
        if (end == text || !isfinite(out[i]) || *end != (i + 1 < count ? ',' : 0))
            return false;
        text = end + 1;
    }
    return true;
}

enum weft_result framing_read_up(const char *text, double out[3])
{
    const char *name = text + (*text == '-' || *text == '+');
    if (*name && strchr("xyzXYZ", *name) && !name[1]) {
        memset(out, 0, 3 * sizeof *out);
        out[tolower((unsigned char)*name) - 'x'] = *text == '-' ? -1.0 : 1.0;
        return WEFT_OK;
    }
    if (read_numbers(text, 3, out) && (out[0] != 0.0 || out[1] != 0.0 || out[2] != 0.0))
        return WEFT_OK;
    report_error("--up %s: it is x, -x, y, -y, z or -z, or a direction X,Y,Z", text);
    return WEFT_ERR_ARGUMENT;
}

enum weft_result framing_read_box(const char *text, struct framing *out)
{
    double box[6];
    if (strcmp(text, "all") == 0 || strcmp(text, "first") == 0) {
        out->box = *text == 'a' ? FRAMING_BOX_ALL : FRAMING_BOX_FIRST;
        return WEFT_OK;
    }
    if (!read_numbers(text, 6, box)) {
        report_error("--box %s: it is all, first, or a box X0,Y0,Z0,X1,Y1,Z1", text);
        return WEFT_ERR_ARGUMENT;
    }
    out->box = FRAMING_BOX_GIVEN;
    for (int i = 0; i < 3; i++) {
        out->low[i] = box[i];
        out->high[i] = box[i + 3];
        if (box[i] < box[i + 3])
            continue;
        report_error("--box %s: along %c it reaches from %g to %g, which is no way up", text,
                     "xyz"[i], box[i], box[i + 3]);
        return WEFT_ERR_ARGUMENT;
    }
    return WEFT_OK;
}
