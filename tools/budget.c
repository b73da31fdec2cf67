// SPDX-License-Identifier: BSD-3-Clause
#include "budget.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "report.h"

enum weft_result budget_parse(const char *text, struct budget *out)
{
    static const int bits[] = {8, 12, 16};
    *out = (struct budget){0};
    for (size_t i = 0; i < sizeof bits / sizeof *bits; i++) {
        char *end;
        if (strtol(text, &end, 10) == bits[i] && strcmp(end, "bit") == 0) {
            out->bits = bits[i];
            return WEFT_OK;
        }
    }
    char *end;
    out->error = strtod(text, &end);
    if (end != text && *end == 0 && isfinite(out->error) && out->error > 0.0)
        return WEFT_OK;
    report_error("--max-error %s: it is a number above 0, or 8bit, 12bit or 16bit", text);
    return WEFT_ERR_ARGUMENT;
}

double budget_error(const struct budget *budget, double low, double high)
{
    const double width = high > low ? high - low : fabs(high);
    return budget->bits ? 0.5 / (ldexp(1.0, budget->bits) - 1.0) * width : budget->error;
}
