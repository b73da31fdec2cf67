// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/readers/mesh/text.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"

static bool make_room(struct weft_mesh_text *text, size_t size)
{
    size_t least;
    if (text->failed || !weft_size_add(text->size, size, &least) || least > SIZE_MAX / 2) {
        text->failed = true;
        return false;
    }
    if (least <= text->room)
        return true;
    const size_t room = least + least / 2 + 256;
    char *data = realloc(text->data, room);
    text->failed = !data;
    if (!data)
        return false;
    text->data = data;
    text->room = room;
    return true;
}

void weft_mesh_text_add(struct weft_mesh_text *text, const void *data, size_t size)
{
    if (!make_room(text, size))
        return;
    if (size)
        memcpy(text->data + text->size, data, size);
    text->size += size;
}

void weft_mesh_text_print(struct weft_mesh_text *text, const char *format, ...)
{
    enum { LINE = 256 };
    va_list args;
    if (!make_room(text, LINE))
        return;
    va_start(args, format);
    const int length = vsnprintf(text->data + text->size, LINE, format, args);
    va_end(args);
    if (length < 0 || length >= LINE)
        text->failed = true;
    else
        text->size += (size_t)length;
}

void weft_mesh_text_clear(struct weft_mesh_text *text)
{
    free(text->data);
    *text = (struct weft_mesh_text){0};
}
