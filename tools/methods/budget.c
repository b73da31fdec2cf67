// SPDX-License-Identifier: BSD-3-Clause
#include "tools/methods/budget.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/report.h"

enum { MAX_BITS = 24 };

enum weft_result budget_parse(const char *text, struct budget *out)
{
    char *end = NULL;
    const double value = strtod(text, &end);
    *out = (struct budget){.error = value};
    if (strpbrk(text, "xX")) // hexadecimal numbers, which strtod takes
        end = NULL;
    if (end && end != text && *end == '\0' && isfinite(value) && value > 0.0)
        return WEFT_OK;
    if (end && end != text && strcmp(end, "bit") == 0 && value >= 1.0 && value <= MAX_BITS &&
        value == floor(value)) {
        *out = (struct budget){.error = NAN, .bits = (int)value};
        return WEFT_OK;
    }
    report_error("--max-error %s: a number above 0, or 8bit, 12bit, 16bit (1 to %d) for half a "
                 "code of the source's range",
                 text, MAX_BITS);
    return WEFT_ERR_ARGUMENT;
}

double budget_error(const struct budget *budget, double low, double high)
{
    const double width = high > low ? high - low : fabs(high);
    if (budget->bits)
        return 0.5 * width / (ldexp(1.0, budget->bits) - 1.0);
    const bool whole = budget->error <= MAX_BITS && budget->error == floor(budget->error);
    if (width > 0.0 && budget->error >= width && whole)
        report_warning("--max-error %g is as much as the whole range of the source, %g to %g: was "
                       "%gbit meant?",
                       budget->error, low, high, budget->error);
    else if (width > 0.0 && budget->error >= width)
        report_warning("--max-error %g is as much as the whole range of the source, %g to %g",
                       budget->error, low, high);
    return budget->error;
}
