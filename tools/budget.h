// SPDX-License-Identifier: BSD-3-Clause
// tools/budget.h - what --max-error allows.
#ifndef WEFT_TOOLS_BUDGET_H
#define WEFT_TOOLS_BUDGET_H

#include "weft.h"

struct budget {
    int bits;     // half a code value of so many bits, of the source's range; 0: `error`
    double error; // in the source's values
};

// A number above 0, or "8bit", "12bit", "16bit". Returns WEFT_ERR_ARGUMENT after an error line.
enum weft_result budget_parse(const char *text, struct budget *out);

// 0.5 / (2^bits - 1) of the range's width (of one value: of its distance from 0), or the error
// asked for.
double budget_error(const struct budget *budget, double low, double high);

#endif
