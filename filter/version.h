// SPDX-License-Identifier: BSD-3-Clause
// filter/version.h - which weft this is: of the headers that a program is compiled with by macros,
// of the library that it runs with by a function. CMake reads the three numbers from here.
#ifndef WEFT_FILTER_VERSION_H
#define WEFT_FILTER_VERSION_H

#include "base.h"

WEFT_BEGIN_DECLS

// MAJOR.MINOR.PATCH (semver.org; while MAJOR is 0, a new MINOR may break what used the last one).
#define WEFT_VERSION_MAJOR 0
#define WEFT_VERSION_MINOR 1
#define WEFT_VERSION_PATCH 0

// One number of three, which compares as versions do; each part is below 1000.
#define WEFT_VERSION_NUMBER(major, minor, patch) ((major)*1000000 + (minor)*1000 + (patch))

// That of these headers: #if WEFT_VERSION >= WEFT_VERSION_NUMBER(0, 2, 0).
#define WEFT_VERSION WEFT_VERSION_NUMBER(WEFT_VERSION_MAJOR, WEFT_VERSION_MINOR, WEFT_VERSION_PATCH)

// Likewise as text, "0.1.0": a literal, so that it joins others, as in "mine 3 with weft "
// WEFT_VERSION_TEXT.
#define WEFT_VERSION_TEXT                                                                          \
    WEFT_VERSION_DIGITS(WEFT_VERSION_MAJOR)                                                        \
    "." WEFT_VERSION_DIGITS(WEFT_VERSION_MINOR) "." WEFT_VERSION_DIGITS(WEFT_VERSION_PATCH)

// Makes the text: a macro's value, and its digits between quotes.
#define WEFT_VERSION_DIGITS(macro) WEFT_VERSION_QUOTED(macro)
#define WEFT_VERSION_QUOTED(digits) #digits

// Returns the text of the library that runs; static storage. A program that finds it different from
// WEFT_VERSION_TEXT was compiled with other headers.
WEFT_API const char *weft_version(void);

WEFT_END_DECLS
#endif
