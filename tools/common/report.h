// SPDX-License-Identifier: BSD-3-Clause
// tools/common/report.h - what the command tells its user: messages, progress, exit codes.
// Messages go to stderr as "weft: error: ...". A failure is one error line: the first one; later
// ones are its consequences and are shown with -v only. One command runs per process, so the state
// is the process's own. Thread-safety: any number of threads, where not said otherwise.
#ifndef WEFT_TOOLS_COMMON_REPORT_H
#define WEFT_TOOLS_COMMON_REPORT_H

#include <stdio.h>

#include "weft.h"

enum exit_code {
    EXIT_CODE_DONE = 0,
    EXIT_CODE_FAILED = 1,  // memory, a GL error, no gnuplot, a verification that failed
    EXIT_CODE_USAGE = 2,   // wrong usage
    EXIT_CODE_INPUT = 3,   // unreadable or refused input
    EXIT_CODE_OUTPUT = 4,  // output not written
    EXIT_CODE_CONTEXT = 5, // no usable GL context
};

// quiet: only errors. verbose: also what is done, and details. Neither: warnings and errors.
void report_set_level(bool quiet, bool verbose);
bool report_is_quiet(void);

// Standard output is for an output file: what is printed goes to stderr from now on.
void report_keep_stdout(void);

void report_error(const char *format, ...) __attribute__((format(printf, 1, 2)));
void report_warning(const char *format, ...) __attribute__((format(printf, 1, 2)));
void report_note(const char *format, ...) __attribute__((format(printf, 1, 2)));
// What is no warning and yet wants to be known: shown unless quiet.
void report_tell(const char *format, ...) __attribute__((format(printf, 1, 2)));

// What is done from now on is one of several parts: messages start with its name ("frame 12"),
// progress with the place ("frame 12 of 100"). Each part has an error line of its own. NULL and
// NULL: it is no part.
void report_set_part(const char *name, const char *place);
// The part's error line without its start, "" while there is none; until the next part.
const char *report_get_error(void);
const char *report_get_part(void); // its name; "": it is no part

// Messages of a part that is worked on before its turn comes, or after.
enum { REPORT_LINE = 1024, REPORT_HELD = 8 };
struct report_held {
    int count;
    enum weft_log_level level[REPORT_HELD];
    char line[REPORT_HELD][REPORT_LINE];
};
// Messages of the calling thread go there from now on, of more than fit the first, and it shows no
// progress. NULL: they are shown again.
void report_hold(struct report_held *held);
// Shows them, and empties it.
void report_release(struct report_held *held);

// Nothing is shown or printed from now on, by any thread: other processes tell what this one does.
// Errors are kept for report_get_error.
void report_mute(void);

// What is said, on a line of its own, when a signal ends the command; -q: nothing. One thread's.
void report_set_last_words(const char *format, ...) __attribute__((format(printf, 1, 2)));
// Says that, once progress is erased. Async-signal-safe.
void report_end(void);

// The verdict of a verification: false, after an error line, where pixels are finite on one side
// only or the largest error is beyond its bound (NAN: it has none). `what`: whose.
bool report_verdict(const char *what, double error, double bound, uint64_t not_finite_mismatches);

// Prints one line on stdout, cleaned (weft_text_clean), and a line end: for lines that hold names,
// paths or other text from outside.
void report_line(const char *format, ...) __attribute__((format(printf, 1, 2)));

// For the library's log members.
const struct weft_log *report_log(void);

// For the library's progress members: false once a deferred interrupt has come. With a terminal on
// stderr it shows `what` and a percentage there, until all is done; behind what stands for a second
// or more, here and below, how long progress has been shown.
const struct weft_progress *report_progress(const char *what);
// The same for work that tells no fraction: "reading", "large.exr".
void report_stage(const char *what, const char *path);
// For a file whose progress is told until it is written, and which is then read back, flushed and
// put in place: its name and a percentage, then "finishing". path is borrowed meanwhile.
const struct weft_progress *report_writing(const char *path); // NULL: it is not shown
void report_erase_progress(void);

// The exit code of a result; makes sure that a failure has its error line, and flushes stdout.
int report_finish(enum weft_result result);

// Closes a text in memory; false where there was none for all that was written.
bool report_close(FILE *text);

double report_now_seconds(void); // monotonic

#endif
