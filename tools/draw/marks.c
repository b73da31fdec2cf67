// SPDX-License-Identifier: BSD-3-Clause
#include "tools/draw/marks.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct mark {
    int32_t x, y, width, height;
    uint8_t grey;
    uint8_t *coverage;                 // owned; NULL: all of it
    const struct weft_colour_map *map; // instead of grey, from below to above
};

struct marks {
    text_font *font;
    int32_t width;
    struct mark *mark;
    size_t count, capacity;
    bool incomplete;
};

enum weft_result marks_create(marks **out)
{
    *out = calloc(1, sizeof **out);
    if (!*out)
        return WEFT_ERR_MEMORY;
    const enum weft_result res = text_font_create(&(*out)->font);
    if (res != WEFT_OK)
        marks_destroy(out);
    return res;
}

void marks_destroy(marks **list)
{
    marks *m = *list;
    if (!m)
        return;
    for (size_t i = 0; i < m->count; i++)
        free(m->mark[i].coverage);
    free(m->mark);
    text_font_destroy(&m->font);
    free(m);
    *list = NULL;
}

void marks_set_width(marks *list, int32_t width)
{
    list->width = width;
}

bool marks_are_whole(const marks *list)
{
    return !list->incomplete;
}

// Takes the coverage.
static void add(marks *list, const struct mark *mark)
{
    if (list->count == list->capacity) {
        const size_t capacity = list->capacity ? 2 * list->capacity : 64;
        struct mark *more = realloc(list->mark, capacity * sizeof *more);
        if (!more) {
            list->incomplete = true;
            free(mark->coverage);
            return;
        }
        list->mark = more;
        list->capacity = capacity;
    }
    list->mark[list->count++] = *mark;
}

void marks_add_rectangle(marks *list, int32_t x, int32_t y, int32_t width, int32_t height,
                         uint8_t grey)
{
    add(list, &(struct mark){.x = x, .y = y, .width = width, .height = height, .grey = grey});
}

void marks_add_ramp(marks *list, int32_t x, int32_t y, int32_t width, int32_t height,
                    const struct weft_colour_map *map)
{
    add(list, &(struct mark){.x = x, .y = y, .width = width, .height = height, .map = map});
}

// ---- texts --------------------------------------------------------------------------------------

struct writing {
    marks *list;
    int32_t x, y;
    uint8_t grey;
};

static void add_glyph(void *priv, int pen, const struct text_glyph *glyph)
{
    const struct writing *w = priv;
    const size_t width = (size_t)glyph->width, height = (size_t)glyph->height;
    if (!width || !height)
        return;
    uint8_t *coverage = malloc(width * height);
    if (!coverage) {
        w->list->incomplete = true;
        return;
    }
    for (size_t y = 0; y < height; y++)
        memcpy(coverage + y * width, glyph->coverage + (ptrdiff_t)y * glyph->stride, width);
    add(w->list, &(struct mark){.x = w->x + pen + glyph->x,
                                .y = w->y + glyph->y,
                                .width = glyph->width,
                                .height = glyph->height,
                                .grey = w->grey,
                                .coverage = coverage});
}

void marks_add_text(marks *list, int32_t x, int32_t y, int size, uint8_t grey, const char *text)
{
    struct writing writing = {list, x, y, grey};
    text_lay_out(list->font, text, size, add_glyph, &writing);
}

int marks_text_width(const marks *list, int size, const char *text)
{
    return (int)ceil(text_lay_out(list->font, text, size, NULL, NULL));
}

// ---- drawing ------------------------------------------------------------------------------------

static void draw_mark(const struct mark *m, int32_t row, int32_t end, uint8_t *rgb)
{
    uint8_t colour[3] = {m->grey, m->grey, m->grey};
    const uint8_t *coverage = m->coverage ? m->coverage + (size_t)row * (size_t)m->width : NULL;
    if (m->map)
        m->map->colour(m->height > 1 ? 1.0 - (double)row / (m->height - 1) : 1.0, colour);
    for (int32_t i = m->x < 0 ? -m->x : 0; i < m->width && m->x + i < end; i++) {
        uint8_t *out = rgb + 3 * (size_t)(m->x + i);
        const int share = coverage ? coverage[i] : 255;
        for (int c = 0; c < 3; c++)
            out[c] = (uint8_t)((share * colour[c] + (255 - share) * out[c] + 127) / 255);
    }
}

void marks_draw(const void *list, int32_t y, uint8_t *rgb)
{
    const marks *m = list;
    for (size_t i = 0; i < m->count; i++) {
        const int32_t row = y - m->mark[i].y;
        if (row >= 0 && row < m->mark[i].height)
            draw_mark(&m->mark[i], row, m->width, rgb);
    }
}
