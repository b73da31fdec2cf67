// SPDX-License-Identifier: BSD-3-Clause
// tools/common/hint.h - what may be wrong with a value, for the end of an error line.
#ifndef WEFT_TOOLS_COMMON_HINT_H
#define WEFT_TOOLS_COMMON_HINT_H

enum { HINT_TEXT = 96 };

// Of a text that is no number: " (decimals have a point: 1.5)", or "". Returns hint.
const char *hint_number(const char *text, char hint[HINT_TEXT]);

#endif
