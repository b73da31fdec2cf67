// SPDX-License-Identifier: BSD-3-Clause
#include "passes/plan/tile_name.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

static const enum weft_tile_part other_part[] = {WEFT_TILE_WHOLE, WEFT_TILE_NEGATIVE,
                                                 WEFT_TILE_POSITIVE};

struct weft_tile_name weft_tile_name_of(const weft_kernel_tiles *tiles, int tile, bool brief)
{
    const struct weft_kernel_tile *t = weft_kernel_tiles_get(tiles, tile);
    if (!t)
        return (struct weft_tile_name){{-1, -1, -1}, WEFT_TILE_WHOLE, -1};
    struct weft_tile_name name = {.part = t->part};
    memcpy(name.tap, t->tap, sizeof name.tap);
    for (int i = 0; i < tile; i++) {
        const struct weft_kernel_tile *other = weft_kernel_tiles_get(tiles, i);
        name.piece += other->part == t->part && memcmp(other->tap, t->tap, sizeof t->tap) == 0;
    }
    if (brief && weft_kernel_tiles_find(tiles, t->tap, other_part[t->part]) < 0)
        name.part = WEFT_TILE_WHOLE;
    return name;
}

int weft_tile_name_find(const weft_kernel_tiles *tiles, const struct weft_tile_name *name)
{
    const int count = weft_kernel_tiles_get_info(tiles)->tile_count;
    int piece = 0;
    for (int i = 0; i < count; i++) {
        const struct weft_kernel_tile *tile = weft_kernel_tiles_get(tiles, i);
        if (memcmp(tile->tap, name->tap, sizeof tile->tap) != 0)
            continue;
        if (name->part != WEFT_TILE_WHOLE && tile->part != name->part)
            continue;
        if (piece++ == name->piece)
            return i;
    }
    return -1;
}

const char *weft_tile_name_format(const struct weft_tile_name *name, int dims,
                                  char text[WEFT_TILE_NAME_TEXT])
{
    static const char *const parts[] = {"", "+", "-"};
    const size_t size = WEFT_TILE_NAME_TEXT;
    int used = snprintf(text, size, "(%d", name->tap[0]);
    for (int a = 1; a < dims && a < 3; a++)
        used += snprintf(text + used, size - (size_t)used, ",%d", name->tap[a]);
    used += snprintf(text + used, size - (size_t)used, ")%s",
                     (unsigned)name->part < 3 ? parts[name->part] : "?");
    if (name->piece)
        snprintf(text + used, size - (size_t)used, "/%d", name->piece);
    return text;
}

// A whole number from 0 to 99999; NULL where there is none.
static const char *read_whole(const char *text, int *out)
{
    const char *at = text;
    for (*out = 0; isdigit((unsigned char)*at) && at - text < 5; at++)
        *out = 10 * *out + (*at - '0');
    return at > text && !isdigit((unsigned char)*at) ? at : NULL;
}

const char *weft_tile_name_parse(const char *text, int dims, struct weft_tile_name *out)
{
    *out = (struct weft_tile_name){.part = WEFT_TILE_WHOLE};
    for (int a = 0; a < dims && a < 3; a++) {
        if (a && *text++ != ',')
            return NULL;
        text = read_whole(text, &out->tap[a]);
        if (!text)
            return NULL;
    }
    if (*text == '+' || *text == '-')
        out->part = *text++ == '+' ? WEFT_TILE_POSITIVE : WEFT_TILE_NEGATIVE;
    return *text == '/' ? read_whole(text + 1, &out->piece) : text;
}
