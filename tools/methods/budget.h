// SPDX-License-Identifier: BSD-3-Clause
// tools/methods/budget.h - error budgets as they are written.
#ifndef WEFT_TOOLS_METHODS_BUDGET_H
#define WEFT_TOOLS_METHODS_BUDGET_H

#include "weft.h"

struct budget {
    double error; // absolute; NAN: half a code of `bits`
    int bits;
};

// "0.001", or "8bit", "12bit", "16bit" (any from 1 to 24): half a code value of the source's range.
// Returns WEFT_ERR_ARGUMENT after an error line.
enum weft_result budget_parse(const char *text, struct budget *out);

// In the values of a source from low to high; of one value alone, its distance from 0 counts. Warns
// of a number that allows any result in that range.
double budget_error(const struct budget *budget, double low, double high);

#endif
