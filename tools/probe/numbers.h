// SPDX-License-Identifier: BSD-3-Clause
// tools/probe/numbers.h - numbers from and to text, by C++'s <charconv>, which is many times faster
// than strtod and printf and knows no locale. Thread-safe.
#ifndef WEFT_TOOLS_PROBE_NUMBERS_H
#define WEFT_TOOLS_PROBE_NUMBERS_H

#include "weft.h"

WEFT_BEGIN_DECLS

// Reads a decimal number, "nan" or "inf" at the start of a text that ends before `end`; of more
// than doubles hold an infinity, or 0. Returns where it ends; NULL where there is none.
const char *numbers_parse(const char *text, const char *end, double *out);

// Writes the shortest text that reads back as the same float, "nan", "inf" or "-inf", without a
// NUL; at most NUMBERS_ROOM bytes. Returns where it ends.
enum { NUMBERS_ROOM = 16 };
char *numbers_print(float value, char *out);

WEFT_END_DECLS
#endif
