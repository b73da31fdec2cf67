// SPDX-License-Identifier: BSD-3-Clause
// tests/support/common.h - what tests share: logs that are kept or printed, kernels by name,
// closeness. Include after cmocka.h.
#ifndef WEFT_TESTS_SUPPORT_COMMON_H
#define WEFT_TESTS_SUPPORT_COMMON_H

#include <math.h>
#include <stdio.h>

#include "filter/check.h"
#include "filter/kernels/kernel.h"
#include "filter/quantity.h"

// Errors and warnings: the last text and how many there were.
struct message {
    char text[1100];
    int count;
};

static inline void keep_message(void *priv, enum weft_log_level level, const char *text)
{
    struct message *message = priv;
    if (level > WEFT_LOG_WARNING)
        return;
    snprintf(message->text, sizeof message->text, "%s", text);
    message->count++;
}

static inline void print_message_to_stderr(void *priv, enum weft_log_level level, const char *text)
{
    (void)priv;
    if (level == WEFT_LOG_ERROR)
        print_error("%s\n", text);
}

static const struct weft_log log_to_stderr = {print_message_to_stderr, NULL};

// To the thread sanitizer Mesa's own threads race: tests of weft's leave OpenGL out then.
#ifdef __SANITIZE_THREAD__
enum { WITHOUT_GL = 1 };
#else
enum { WITHOUT_GL = 0 };
#endif

static inline struct weft_kernel kernel_named(const char *name)
{
    struct weft_kernel kernel;
    assert_int_equal(weft_kernel_parse(&log_to_stderr, name, &kernel), WEFT_OK);
    return kernel;
}

// "x", "yz", ..., "none".
static inline struct weft_derivative derivative_named(const char *text)
{
    struct weft_derivative out;
    assert_int_equal(weft_derivative_parse(&log_to_stderr, text, &out), WEFT_OK);
    return out;
}

// One that may be taken in so many dimensions: first the value, then x, xx, y, xy, yy, z, ...; NULL
// past the last.
static inline const char *derivative_in(int dims, int index)
{
    static const char *const names[] = {"none", "x", "xx", "y", "xy", "yy", "z", "xz", "yz", "zz"};
    const int count = dims == 1 ? 3 : dims == 2 ? 6 : 10;
    return index < count ? names[index] : NULL;
}

static inline void assert_near(double actual, double expected, double tolerance, const char *what)
{
    if (!(fabs(actual - expected) <= tolerance))
        fail_msg("%s: %.17g instead of %.17g", what, actual, expected);
}

// The larger of both, where fmax would drop a NAN: once there, it stays.
static inline double larger(double a, double b)
{
    return isnan(a) || isnan(b) ? (double)NAN : fmax(a, b);
}

#endif
