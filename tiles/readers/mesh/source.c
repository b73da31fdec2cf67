// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/readers/mesh/source.h"

#include <stdarg.h>
#include <stdio.h>

enum weft_result weft_mesh_fail(struct weft_mesh_source *source, enum weft_result result,
                                const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vsnprintf(source->message, sizeof source->message, format, args);
    va_end(args);
    source->result = result;
    return result;
}
