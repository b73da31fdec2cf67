// SPDX-License-Identifier: BSD-3-Clause
#include "filter/boundary.h"

const char *const weft_boundary_names[] = {"clamp", "mirror", "wrap", "border", NULL};

static int64_t modulo(int64_t index, int64_t period)
{
    const int64_t rest = index % period;
    return rest < 0 ? rest + period : rest;
}

static int64_t mirror(int64_t index, int64_t size)
{
    const int64_t period = 2 * (size - 1), at = period ? modulo(index, period) : 0;
    return at < size ? at : period - at;
}

int64_t weft_boundary_index(enum weft_boundary boundary, int64_t index, int64_t size)
{
    if (size < 1 || size > INT64_MAX / 2)
        return -1;
    switch (boundary) {
    case WEFT_BOUNDARY_CLAMP:
        return index < 0 ? 0 : index < size ? index : size - 1;
    case WEFT_BOUNDARY_MIRROR:
        return mirror(index, size);
    case WEFT_BOUNDARY_WRAP:
        return modulo(index, size);
    case WEFT_BOUNDARY_BORDER:
        return index >= 0 && index < size ? index : -1;
    default:
        return -1;
    }
}
