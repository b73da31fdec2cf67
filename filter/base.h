// SPDX-License-Identifier: BSD-3-Clause
// filter/base.h - results, log and progress callbacks, checked arithmetic.
// Everything in weft returns enum weft_result, tells its reasons to a log, and takes the log as its
// first parameter or as a member of its params. A NULL log is silence.
#ifndef WEFT_FILTER_BASE_H
#define WEFT_FILTER_BASE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
#define WEFT_BEGIN_DECLS extern "C" {
#define WEFT_END_DECLS }
#else
#define WEFT_BEGIN_DECLS
#define WEFT_END_DECLS
#endif

#define WEFT_API __attribute__((visibility("default")))

WEFT_BEGIN_DECLS

// Bands of hundreds: 1xx the caller, 2xx unsupported, 3xx limits, 4xx memory, 5xx files, 6xx GL.
enum weft_result {
    WEFT_OK = 0,
    WEFT_ERR_ARGUMENT = 100,    // a parameter is out of its range, or a name is unknown
    WEFT_ERR_CANCELLED = 101,   // the progress callback said stop
    WEFT_ERR_UNSUPPORTED = 200, // a valid file or request that weft does not handle
    WEFT_ERR_LIMIT = 300,       // a size, memory, time or output limit; the log has both numbers
    WEFT_ERR_MEMORY = 400,      // an allocation failed
    WEFT_ERR_OPEN = 500,        // a file cannot be opened or read
    WEFT_ERR_FORMAT = 501,      // a file is damaged, or its content contradicts itself
    WEFT_ERR_READER = 502,      // a reader program is missing, was killed or broke its protocol
    WEFT_ERR_WRITE = 503,       // an output cannot be written, or exists and may not be replaced
    WEFT_ERR_CONTEXT = 600,     // no usable GL context
    WEFT_ERR_GL = 601,          // GL reported an error
};

// A short English text for a result; never NULL, static storage.
WEFT_API const char *weft_result_text(enum weft_result result);

enum weft_log_level { WEFT_LOG_ERROR, WEFT_LOG_WARNING, WEFT_LOG_INFO, WEFT_LOG_DEBUG };

// Messages are one line of UTF-8 without a line end, and are valid during the call only.
struct weft_log {
    void (*write)(void *priv, enum weft_log_level level, const char *message);
    void *priv;
};

// Called now and then during long work with the fraction done, 0 to 1, never decreasing.
// Returning false stops the work, which then returns WEFT_ERR_CANCELLED and leaves no partial
// output.
struct weft_progress {
    bool (*report)(void *priv, double fraction);
    void *priv;
};

// "0.1.0"; static storage.
WEFT_API const char *weft_version(void);

WEFT_END_DECLS
#endif
