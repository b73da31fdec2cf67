// SPDX-License-Identifier: BSD-3-Clause
#include "report.h"

#include <errno.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static volatile sig_atomic_t interrupted;
static enum weft_log_level shown_level = WEFT_LOG_WARNING;
static bool error_shown;
static const char *progress_what;
static int progress_percent = -1;

static void on_signal(int number)
{
    (void)number;
    interrupted = 1;
}

void report_start(void)
{
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = (int)SA_RESETHAND | SA_RESTART};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
}

void report_set_level(bool quiet, bool verbose)
{
    shown_level = verbose ? WEFT_LOG_DEBUG : quiet ? WEFT_LOG_ERROR : WEFT_LOG_WARNING;
}

bool report_is_quiet(void)
{
    return shown_level == WEFT_LOG_ERROR;
}

static void clear_progress(void)
{
    if (progress_percent >= 0)
        fputs("\r\033[K", stderr);
    progress_percent = -1;
}

static void write_line(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    static const char *const names[] = {"error", "warning", "info", "debug"};
    if (level == WEFT_LOG_ERROR) {
        // Ctrl-C reaches the readers too; that they were killed is not the news then.
        if (error_shown || interrupted)
            level = WEFT_LOG_DEBUG;
        else
            error_shown = true;
    }
    if (level > shown_level)
        return;
    clear_progress();
    fprintf(stderr, "weft: %s: %s\n", names[level], message);
}

static const struct weft_log log_to_stderr = {.write = write_line};

const struct weft_log *report_log(void)
{
    return &log_to_stderr;
}

static void write_format(enum weft_log_level level, const char *format, va_list args)
{
    char line[1024];
    vsnprintf(line, sizeof line, format, args);
    write_line(NULL, level, weft_text_clean(line, false));
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

static bool show_progress(void *priv, double fraction)
{
    (void)priv;
    int percent = (int)(100 * fraction);
    if (percent != progress_percent && shown_level >= WEFT_LOG_WARNING && isatty(STDERR_FILENO)) {
        fprintf(stderr, "\rweft: %s %3d %%\033[K", progress_what, percent);
        progress_percent = percent;
    }
    return !interrupted;
}

static const struct weft_progress progress_to_stderr = {.report = show_progress};

const struct weft_progress *report_progress(const char *what)
{
    progress_what = what;
    return &progress_to_stderr;
}

bool report_interrupted(void)
{
    return interrupted;
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
    clear_progress();
    if (result != WEFT_OK && interrupted) {
        if (!error_shown)
            fputs("weft: error: interrupted\n", stderr);
        return EXIT_CODE_FAILED;
    }
    if (result == WEFT_OK && (fflush(stdout) != 0 || ferror(stdout))) {
        report_error("standard output cannot be written: %s", strerror(errno));
        return EXIT_CODE_OUTPUT;
    }
    if (result != WEFT_OK && !error_shown)
        report_error("%s", weft_result_text(result));
    return exit_code(result);
}

double report_now_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}
