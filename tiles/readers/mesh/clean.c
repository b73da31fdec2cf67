// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/readers/mesh/clean.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum weft_result weft_mesh_clean_fail(struct weft_mesh_clean *clean, enum weft_result result,
                                      const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vsnprintf(clean->message, sizeof clean->message, format, args);
    va_end(args);
    clean->result = result;
    return result;
}

void weft_mesh_copy_name(char out[WEFT_MESH_NAME], const char *text, size_t length)
{
    if (length >= WEFT_MESH_NAME)
        for (length = WEFT_MESH_NAME - 1; length && ((unsigned char)text[length] & 0xc0) == 0x80;)
            length--;
    memcpy(out, text, length);
    memset(out + length, 0, WEFT_MESH_NAME - length);
}

void weft_mesh_clean_clear(struct weft_mesh_clean *clean)
{
    weft_mesh_text_clear(&clean->main);
    weft_mesh_text_clear(&clean->other);
    weft_mesh_text_clear(&clean->names);
}
