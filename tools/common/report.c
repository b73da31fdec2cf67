// SPDX-License-Identifier: BSD-3-Clause
#include "tools/common/report.h"

#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "tools/common/ending.h"

enum { NO_PERCENTAGE = 100, NAME_SHOWN = 40 };

static enum weft_log_level shown_level = WEFT_LOG_WARNING;
static pthread_mutex_t screen = PTHREAD_MUTEX_INITIALIZER; // stderr, and what is shown there
static volatile sig_atomic_t progress_percent = -1;        // shown; -1: none is
static char *_Atomic last_words;                           // NULL: none
static bool error_shown, muted;

static const char *progress_what;
static struct {
    char name[64], place[64]; // "": what is done is no part
    char error[REPORT_LINE];  // the part's first one
} part;
static _Thread_local struct report_held *held_lines; // the thread's; NULL: it shows what it tells

void report_set_part(const char *name, const char *place)
{
    pthread_mutex_lock(&screen);
    snprintf(part.name, sizeof part.name, "%s", name ? name : "");
    snprintf(part.place, sizeof part.place, "%s%s", place ? place : "", place ? ", " : "");
    part.error[0] = 0;
    pthread_mutex_unlock(&screen);
}

const char *report_get_error(void)
{
    return part.error;
}

const char *report_get_part(void)
{
    return part.name;
}

void report_set_level(bool quiet, bool verbose)
{
    shown_level = verbose ? WEFT_LOG_DEBUG : quiet ? WEFT_LOG_ERROR : WEFT_LOG_WARNING;
}

void report_keep_stdout(void)
{
    if (!muted)
        stdout = stderr;
}

void report_mute(void)
{
    FILE *nowhere = fopen("/dev/null", "we");
    muted = true;
    if (nowhere)
        stdout = nowhere;
}

bool report_is_quiet(void)
{
    return shown_level == WEFT_LOG_ERROR;
}

static void write_all(const char *text)
{
    for (size_t left = strlen(text); left;) {
        const ssize_t count = write(STDERR_FILENO, text, left);
        if (count <= 0)
            return;
        text += count;
        left -= (size_t)count;
    }
}

// A signal handler's, too.
static void erase_progress(void)
{
    if (progress_percent >= 0)
        write_all("\r\033[K");
    progress_percent = -1;
}

void report_erase_progress(void)
{
    pthread_mutex_lock(&screen);
    erase_progress();
    pthread_mutex_unlock(&screen);
}

void report_set_last_words(const char *format, ...)
{
    static char texts[2][256];
    char *text = atomic_load(&last_words) == texts[0] ? texts[1] : texts[0];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof texts[0] - 1, format, args);
    va_end(args);
    strcat(text, "\n");
    atomic_store(&last_words, shown_level >= WEFT_LOG_WARNING && !muted ? text : NULL);
}

void report_end(void)
{
    const char *words = atomic_load(&last_words);
    erase_progress();
    if (words)
        write_all(words);
}

// A part's first error is the one that is shown.
static enum weft_log_level take_error(const char *message)
{
    if (part.error[0])
        return WEFT_LOG_DEBUG;
    snprintf(part.error, sizeof part.error, "%s", message);
    weft_text_clean(part.error, false);
    error_shown = true;
    return WEFT_LOG_ERROR;
}

static void show_line(enum weft_log_level level, char line[REPORT_LINE])
{
    static const char *const names[] = {"error", "warning", "info", "debug"};
    if (level == WEFT_LOG_ERROR)
        level = take_error(line);
    if (level > shown_level || muted)
        return;
    erase_progress();
    fprintf(stderr, "weft: %s: %s%s%s\n", names[level], part.name, part.name[0] ? ": " : "",
            weft_text_clean(line, false));
}

// Where there is no room left an error takes the last line.
static void hold_line(enum weft_log_level level, const char *line)
{
    struct report_held *held = held_lines;
    const bool full = held->count == REPORT_HELD;
    if (level > shown_level || (full && level != WEFT_LOG_ERROR))
        return;
    const int at = full ? REPORT_HELD - 1 : held->count++;
    held->level[at] = level;
    snprintf(held->line[at], REPORT_LINE, "%s", line);
}

static void write_line(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    char line[REPORT_LINE];
    snprintf(line, sizeof line, "%s", message);
    if (held_lines) {
        hold_line(level, line);
        return;
    }
    pthread_mutex_lock(&screen);
    show_line(level, line);
    pthread_mutex_unlock(&screen);
}

void report_tell(const char *format, ...)
{
    char line[REPORT_LINE];
    va_list args;
    va_start(args, format);
    vsnprintf(line, sizeof line, format, args);
    va_end(args);
    if (report_is_quiet() || muted)
        return;
    pthread_mutex_lock(&screen);
    erase_progress();
    fprintf(stderr, "weft: info: %s\n", weft_text_clean(line, false));
    pthread_mutex_unlock(&screen);
}

void report_hold(struct report_held *held)
{
    held_lines = held;
}

void report_release(struct report_held *held)
{
    for (int i = 0; i < held->count; i++)
        write_line(NULL, held->level[i], held->line[i]);
    held->count = 0;
}

static const struct weft_log log_to_stderr = {.write = write_line};

bool report_verdict(const char *what, double error, double bound, uint64_t not_finite_mismatches)
{
    if (not_finite_mismatches)
        report_error("verification failed, %s: %llu pixels are finite on one side only", what,
                     (unsigned long long)not_finite_mismatches);
    else if (error > bound)
        report_error("verification failed, %s: the largest error, %.3g, is beyond the bound of "
                     "%.3g",
                     what, error, bound);
    return !not_finite_mismatches && !(error > bound);
}

const struct weft_log *report_log(void)
{
    return &log_to_stderr;
}

static void write_format(enum weft_log_level level, const char *format, va_list args)
{
    char line[REPORT_LINE];
    vsnprintf(line, sizeof line, format, args);
    write_line(NULL, level, line);
}

#define DEFINE_REPORT(name, level)                                                                 \
    void name(const char *format, ...)                                                             \
    {                                                                                              \
        va_list args;                                                                              \
        va_start(args, format);                                                                    \
        write_format(level, format, args);                                                         \
        va_end(args);                                                                              \
    }
DEFINE_REPORT(report_error, WEFT_LOG_ERROR)
DEFINE_REPORT(report_warning, WEFT_LOG_WARNING)
DEFINE_REPORT(report_note, WEFT_LOG_INFO)

void report_line(const char *format, ...)
{
    char *line = NULL;
    va_list args;
    va_start(args, format);
    int length = vasprintf(&line, format, args);
    va_end(args);
    if (length < 0) {
        report_error("out of memory for a line of text");
        return;
    }
    puts(weft_text_clean(line, false));
    free(line);
}

// ---- progress -----------------------------------------------------------------------------------

static char shown_text[160]; // the line, without the seconds behind it
static double shown_at;      // when that came

// A line that has stood for a second says how long the command has run, and each second anew.
static void *tick(void *begun)
{
    for (const double start = *(const double *)begun;;) {
        nanosleep(&(struct timespec){.tv_sec = 1}, NULL);
        pthread_mutex_lock(&screen);
        const double now = report_now_seconds();
        if (progress_percent >= 0 && now - shown_at > 0.9)
            fprintf(stderr, "\r%s, %.0f s\033[K", shown_text, now - start);
        pthread_mutex_unlock(&screen);
    }
    return NULL;
}

// The screen is locked.
static void show_text(int percent)
{
    static double begun;
    static pthread_t ticker;
    shown_at = report_now_seconds();
    fprintf(stderr, "\r%s\033[K", shown_text);
    progress_percent = percent;
    if (begun == 0.0) {
        begun = shown_at;
        if (ending_start_thread(&ticker, tick, &begun))
            pthread_detach(ticker);
    }
}

static bool shows_progress(void)
{
    return !held_lines && !muted && shown_level >= WEFT_LOG_WARNING && isatty(STDERR_FILENO);
}

// What is done is no news: whatever comes next has a line of its own.
static bool show_progress(void *priv, double fraction)
{
    (void)priv;
    int percent = (int)(100 * fraction);
    pthread_mutex_lock(&screen);
    if (percent >= 100) {
        erase_progress();
    } else if (percent != progress_percent && shows_progress()) {
        snprintf(shown_text, sizeof shown_text, "weft: %s%s %3d %%", part.place, progress_what,
                 percent);
        show_text(percent);
    }
    pthread_mutex_unlock(&screen);
    return !ending_is_due();
}

static const struct weft_progress progress_to_stderr = {.report = show_progress};

const struct weft_progress *report_progress(const char *what)
{
    progress_what = what;
    return &progress_to_stderr;
}

// Its last part, not all of it where it is long.
static char *shown_name(const char *path, char name[NAME_SHOWN + 1])
{
    const char *slash = strrchr(path, '/');
    snprintf(name, NAME_SHOWN + 1, "%s", slash ? slash + 1 : path);
    return weft_text_clean(name, false);
}

void report_stage(const char *what, const char *path)
{
    char name[NAME_SHOWN + 1];
    if (!shows_progress())
        return;
    pthread_mutex_lock(&screen);
    snprintf(shown_text, sizeof shown_text, "weft: %s%s %s", part.place, what,
             shown_name(path, name));
    show_text(NO_PERCENTAGE);
    pthread_mutex_unlock(&screen);
}

static bool show_writing(void *priv, double fraction)
{
    const bool goes_on = show_progress(NULL, fraction);
    if (fraction >= 1.0)
        report_stage("finishing", *(const char *const *)priv);
    return goes_on;
}

const struct weft_progress *report_writing(const char *path)
{
    static const char *written;
    static const struct weft_progress progress = {.report = show_writing, .priv = &written};
    static char what[sizeof "writing " + NAME_SHOWN];
    char name[NAME_SHOWN + 1];
    if (held_lines)
        return NULL;
    written = path;
    snprintf(what, sizeof what, "writing %s", shown_name(path, name));
    report_progress(what);
    return &progress;
}

static int exit_code(enum weft_result result)
{
    switch (result) {
    case WEFT_OK:
        return EXIT_CODE_DONE;
    case WEFT_ERR_ARGUMENT:
        return EXIT_CODE_USAGE;
    case WEFT_ERR_UNSUPPORTED:
    case WEFT_ERR_LIMIT:
    case WEFT_ERR_OPEN:
    case WEFT_ERR_FORMAT:
    case WEFT_ERR_READER:
        return EXIT_CODE_INPUT;
    case WEFT_ERR_WRITE:
        return EXIT_CODE_OUTPUT;
    case WEFT_ERR_CONTEXT:
        return EXIT_CODE_CONTEXT;
    case WEFT_ERR_CANCELLED:
    case WEFT_ERR_MEMORY:
    case WEFT_ERR_GL:
        return EXIT_CODE_FAILED;
    }
    return EXIT_CODE_FAILED;
}

int report_finish(enum weft_result result)
{
    report_erase_progress();
    if (result == WEFT_OK && (fflush(stdout) != 0 || ferror(stdout))) {
        report_error("standard output cannot be written: %s", strerror(errno));
        return EXIT_CODE_OUTPUT;
    }
    if (result != WEFT_OK && !error_shown)
        report_error("%s", weft_result_text(result));
    return exit_code(result);
}

bool report_close(FILE *text)
{
    const bool lost = ferror(text);
    return fclose(text) == 0 && !lost;
}

double report_now_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}
