// SPDX-License-Identifier: BSD-3-Clause
// filter/check.h - what weft's own sources use to report and to check (not installed).
#ifndef WEFT_FILTER_CHECK_H
#define WEFT_FILTER_CHECK_H

#include "filter/base.h"

WEFT_BEGIN_DECLS

// Formats one line (cut at 1 KiB, control characters replaced by '?') and hands it to the log.
void weft_log_write(const struct weft_log *log, enum weft_log_level level, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#define weft_error(log, ...) weft_log_write(log, WEFT_LOG_ERROR, __VA_ARGS__)
#define weft_warn(log, ...) weft_log_write(log, WEFT_LOG_WARNING, __VA_ARGS__)
#define weft_note(log, ...) weft_log_write(log, WEFT_LOG_INFO, __VA_ARGS__)
#define weft_debug(log, ...) weft_log_write(log, WEFT_LOG_DEBUG, __VA_ARGS__)

// For caller bugs: logs function and condition, then goes to the function's `fail:` label.
// The function sets its result to WEFT_ERR_ARGUMENT before.
#define weft_require(log, condition)                                                               \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            weft_error(log, "%s: required: %s", __func__, #condition);                             \
            goto fail;                                                                             \
        }                                                                                          \
    } while (0)

// Likewise: a value of an enum that counts from 0 to `last`.
#define weft_require_enum(log, value, last)                                                        \
    do {                                                                                           \
        if ((unsigned)(value) > (unsigned)(last)) {                                                \
            weft_error(log, "%s: %s is %d: its enum has 0 to %d", __func__, #value, (int)(value),  \
                       (int)(last));                                                               \
            goto fail;                                                                             \
        }                                                                                          \
    } while (0)

// An entry of a NULL-ended list of names; "unknown" past its end.
static inline const char *weft_name(const char *const *names, unsigned value)
{
    for (unsigned i = 0; names[i]; i++)
        if (i == value)
            return names[i];
    return "unknown";
}

#define WEFT_COUNT(array) (sizeof(array) / sizeof((array)[0]))

// false on overflow; *out is then unspecified.
static inline bool weft_size_mul(size_t a, size_t b, size_t *out)
{
    return !__builtin_mul_overflow(a, b, out);
}

static inline bool weft_size_add(size_t a, size_t b, size_t *out)
{
    return !__builtin_add_overflow(a, b, out);
}

// A range that is not given: NAN at an end, or a struct left zero.
static inline bool weft_range_is_open(double end, double low, double high)
{
    return end != end || (low == 0.0 && high == 0.0);
}

// Reads one finite decimal number at the start of text, whatever the locale; returns where it ends,
// NULL where there is none. White space, "inf" and "nan", which strtod would take, are none.
const char *weft_number_parse(const char *text, double *out);

// Monotonic time in seconds, for reports.
double weft_now_seconds(void);

WEFT_END_DECLS
#endif
