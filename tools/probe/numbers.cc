// SPDX-License-Identifier: BSD-3-Clause
#include "tools/probe/numbers.h"

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <string>

extern "C" const char *numbers_parse(const char *text, const char *end, double *out)
{
    // Which from_chars does not take, and only one.
    if (text < end && *text == '+' && end - text > 1 && text[1] != '-')
        text++;
    const std::from_chars_result r = std::from_chars(text, end, *out);
    if (r.ec == std::errc::invalid_argument)
        return NULL;
    if (r.ec == std::errc::result_out_of_range)
        *out = std::strtod(std::string(text, r.ptr).c_str(), NULL);
    return r.ptr;
}

extern "C" char *numbers_print(float value, char *out)
{
    if (std::isnan(value)) // of either sign
        value = std::fabs(value);
    return std::to_chars(out, out + NUMBERS_ROOM, value).ptr;
}
