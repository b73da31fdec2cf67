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
#include "filter/version.h"

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
    return WEFT_VERSION_TEXT;
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
