// SPDX-License-Identifier: BSD-3-Clause
#include "tools/common/log.h"

#include <stdarg.h>
#include <stdio.h>

void log_write(const struct weft_log *log, enum weft_log_level level, const char *format, ...)
{
    if (!log || !log->write)
        return;
    char line[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    log->write(log->priv, level, weft_text_clean(line, false));
}
