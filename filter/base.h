// SPDX-License-Identifier: BSD-3-Clause
// filter/base.h - results, log and progress callbacks, checked arithmetic.
// Everything in weft returns enum weft_result, tells its reasons to a log, and takes the log as its
// first parameter or as a member of its params. A NULL log is silence.
//
// Pointers are required, and what they point to lives through the call, unless a comment says that
// NULL is allowed; NULL for a required one is a bug of the caller that may end the process.
// Functions that destroy or clear accept NULL, and what is destroyed or all zero already. Any other
// value may be handed in: one that is out of its range gives WEFT_ERR_ARGUMENT (or what the
// function says) and a line in the log; where there is neither, NAN, NULL, 0, -1 or "unknown".
//
// Every params struct is filled by a macro of its name, weft_volume_params(.size = {8, 8, 8}, ...),
// whose value is a pointer to such a struct. It starts from WEFT_VOLUME_DEFAULTS, which an
// initialiser of one's own may start with, too. Members left out or zero ask for the defaults.
// DEFAULTS macros are empty but where zero is a value and the default is another. C++ and bindings,
// which have no compound literals, call weft_volume_params_init(&params) and its like
// (passes/params/params.h).
//
// Thread-safety: nothing is global. Functions may be called from any thread, also at once, with
// different objects; what may be shared stands beside each object's type.
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

// Returns a short English text for a result, "unknown result" for other values; never NULL, static
// storage.
WEFT_API const char *weft_result_text(enum weft_result result);

// How much a message matters: why a call failed; what a caller should know although it did not;
// what was done; what helps whoever looks for a fault.
enum weft_log_level { WEFT_LOG_ERROR, WEFT_LOG_WARNING, WEFT_LOG_INFO, WEFT_LOG_DEBUG };

// Where messages go. A message is one line of UTF-8 without a line end, up to 1 KiB, cleaned by
// weft_text_clean whatever names and file contents it quotes, and valid during the call only. It
// comes in the thread that called weft. The struct is borrowed, as long as a comment says.
struct weft_log {
    void (*write)(void *priv, enum weft_log_level level, const char *message); // NULL: silence
    void *priv; // handed to write as it is
};

// Called now and then during long work with the fraction done, 0 to 1, never decreasing, in the
// thread that called weft. Returning false stops the work, which then returns WEFT_ERR_CANCELLED;
// files are not left in part. The struct is borrowed until the call returns.
struct weft_progress {
    bool (*report)(void *priv, double fraction); // NULL: nobody asks
    void *priv;                                  // handed to report as it is
};

// Makes a text that comes from a file, a name or a path safe to print, in place; it never grows.
// A '?' replaces each control character (C0, DEL, C1: they begin a terminal's escape sequences),
// each byte that is not UTF-8 (RFC 3629: no overlong forms, no surrogates, nothing over U+10FFFF),
// and each line or paragraph separator and mark that turns the direction of writing (U+061C,
// U+200E, U+200F, U+2028 to U+202E, U+2066 to U+2069). With keep_lines, line ends and tabs stay.
// Returns the text.
WEFT_API char *weft_text_clean(char *text, bool keep_lines);

// Returns where a text file's content starts: behind UTF-8's byte order mark (EF BB BF), which some
// editors put in front, or at `text` itself where there is none.
WEFT_API const char *weft_text_skip_mark(const char *text);

WEFT_END_DECLS
#endif
