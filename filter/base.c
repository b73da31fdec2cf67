// SPDX-License-Identifier: BSD-3-Clause
#include "filter/base.h"

#include <locale.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "filter/check.h"

const char *weft_result_text(enum weft_result result)
{
    switch (result) {
    case WEFT_OK:
        return "done";
    case WEFT_ERR_ARGUMENT:
        return "bad argument";
    case WEFT_ERR_CANCELLED:
        return "cancelled";
    case WEFT_ERR_UNSUPPORTED:
        return "unsupported";
    case WEFT_ERR_LIMIT:
        return "over a limit";
    case WEFT_ERR_MEMORY:
        return "out of memory";
    case WEFT_ERR_OPEN:
        return "cannot open";
    case WEFT_ERR_FORMAT:
        return "damaged file";
    case WEFT_ERR_READER:
        return "reader process failed";
    case WEFT_ERR_WRITE:
        return "cannot write";
    case WEFT_ERR_CONTEXT:
        return "no usable GL context";
    case WEFT_ERR_GL:
        return "GL error";
    }
    return "unknown result";
}

const char *weft_version(void)
{
    return WEFT_VERSION;
}

// The bytes of the UTF-8 sequence at `text`, and its code point; 0 if it is none.
static size_t decode_utf8(const char *text, uint32_t *point)
{
    static const uint32_t smallest[] = {0, 0, 0x80, 0x800, 0x10000};
    const unsigned char *c = (const unsigned char *)text;
    size_t length = *c < 0x80 ? 1 : *c >> 5 == 6 ? 2 : *c >> 4 == 14 ? 3 : *c >> 3 == 30 ? 4 : 0;
    *point = length < 2 ? *c : *c & (0x7fu >> length);
    for (size_t i = 1; i < length; i++) {
        if (c[i] >> 6 != 2) // the end of the text, too
            return 0;
        *point = *point << 6 | (c[i] & 0x3f);
    }
    bool surrogate = *point >= 0xd800 && *point <= 0xdfff;
    return *point < smallest[length] || *point > 0x10ffff || surrogate ? 0 : length;
}

static bool printable(uint32_t point, bool keep_lines)
{
    if (point < 0x20)
        return keep_lines && (point == '\n' || point == '\t');
    bool turns = point == 0x61c || point == 0x200e || point == 0x200f ||
                 (point >= 0x2028 && point <= 0x202e) || (point >= 0x2066 && point <= 0x2069);
    return !turns && (point < 0x7f || point > 0x9f);
}

char *weft_text_clean(char *text, bool keep_lines)
{
    char *out = text;
    for (const char *in = text; *in;) {
        uint32_t point;
        size_t length = decode_utf8(in, &point);
        if (length && printable(point, keep_lines)) {
            memmove(out, in, length);
            out += length;
        } else {
            *out++ = '?';
        }
        in += length ? length : 1;
    }
    *out = 0;
    return text;
}

const char *weft_text_skip_mark(const char *text)
{
    static const char mark[] = "\xef\xbb\xbf";
    return strncmp(text, mark, strlen(mark)) == 0 ? text + strlen(mark) : text;
}

void weft_log_write(const struct weft_log *log, enum weft_log_level level, const char *format, ...)
{
    if (!log || !log->write)
        return;
    char line[1024];
    va_list args;
    va_start(args, format);
    vsnprintf(line, sizeof line, format, args);
    va_end(args);
    log->write(log->priv, level, weft_text_clean(line, false));
}

const char *weft_number_parse(const char *text, double *out)
{
    if (!*text || !strchr("+-.0123456789", *text))
        return NULL;
    char *end = NULL;
    const locale_t c_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    *out = strtod_l(text, &end, c_locale);
    freelocale(c_locale);
    return end != text && isfinite(*out) ? end : NULL;
}

double weft_now_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}
