// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/readers/mesh/clean.h"

#include <inttypes.h>
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

static void drop(char *text, uint64_t count, const char *what)
{
    const size_t used = strlen(text);
    if (count)
        snprintf(text + used, WEFT_MESH_DROPPED - used, "%s%" PRIu64 " %s%s", used ? ", " : "",
                 count, what, count == 1 ? "" : "s");
}

void weft_mesh_say_left(const struct weft_mesh_left *left, char text[WEFT_MESH_DROPPED])
{
    *text = '\0';
    drop(text, left->lines, "line");
    drop(text, left->points, "point");
    drop(text, left->curves, "curve");
    drop(text, left->textures, "texture");
    drop(text, left->animations, "animation");
    drop(text, left->skins, "skin");
    drop(text, left->morphs, "morph target");
    drop(text, left->cameras, "camera");
    drop(text, left->lights, "light");
}

enum weft_result weft_mesh_clean_no_faces(struct weft_mesh_clean *clean)
{
    char left[WEFT_MESH_DROPPED];
    weft_mesh_say_left(&clean->left, left);
    return weft_mesh_clean_fail(clean, WEFT_ERR_FORMAT, "it has no triangles%s%s",
                                *left ? ", but " : "", left);
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
