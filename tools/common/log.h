// SPDX-License-Identifier: BSD-3-Clause
// tools/common/log.h - messages of code that gets its log from its caller, as the library's does:
// tests read them, and the command hands over report_log().
#ifndef WEFT_TOOLS_COMMON_LOG_H
#define WEFT_TOOLS_COMMON_LOG_H

#include "weft.h"

// Formats one line, cut at 1 KiB and cleaned (weft_text_clean), and hands it to the log, which may
// be NULL.
void log_write(const struct weft_log *log, enum weft_log_level level, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#define log_error(log, ...) log_write(log, WEFT_LOG_ERROR, __VA_ARGS__)
#define log_warn(log, ...) log_write(log, WEFT_LOG_WARNING, __VA_ARGS__)
#define log_note(log, ...) log_write(log, WEFT_LOG_INFO, __VA_ARGS__)

#endif
