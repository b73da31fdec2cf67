// SPDX-License-Identifier: BSD-3-Clause
// Which pixels count. A marked pixel's samples reach the pixels within the filter's radius: all of
// these are supersampled. For each of them the samples within the radius are drawn, be they in the
// picture or in the rim around it.
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "passes/antialias/marks/marks_impl.h"
#include "passes/antialias/supersample_impl.h"

static enum weft_result no_memory(const weft_supersample *s)
{
    weft_error(s->params.log,
               "supersample: not enough memory for lists of the pixels of %d x %d pixels",
               s->window.width, s->window.height);
    return WEFT_ERR_MEMORY;
}

// Rows of a whole number of 8 x 8 pixels, about as many as they are long.
static void shape(struct weft_pixel_list *list)
{
    const int32_t side = (int32_t)ceil(sqrt((double)list->count));
    list->width = (side + 7) / 8 * 8;
    list->height = (int32_t)((list->count + list->width - 1) / list->width);
}

// Counts the pixels of the window, without `rim` at its borders, that are marked.
static int64_t count_marks(const struct weft_marks *marks, int rim)
{
    int64_t count = 0;
    for (int32_t y = rim; y < marks->height - rim; y++) {
        const uint8_t *row = &marks->marked[(size_t)y * (size_t)marks->width];
        for (int32_t x = rim; x < marks->width - rim; x++)
            count += row[x];
    }
    return count;
}

// Lists them, list->count in number, where they are in the scratch.
static bool make_list(const weft_supersample *s, int rim, struct weft_pixel_list *list)
{
    const struct weft_marks *marks = &s->mask;
    size_t i = 0;
    if (list->count == 0)
        return true;
    shape(list);
    const size_t room = (size_t)list->width * (size_t)list->height;
    list->at = malloc(room * sizeof *list->at);
    if (!list->at)
        return false;
    for (int32_t y = rim; y < marks->height - rim; y++) {
        const uint8_t *row = &marks->marked[(size_t)y * (size_t)marks->width];
        const uint8_t *end = row + marks->width - rim, *next = row + rim;
        while (next < end && (next = memchr(next, 1, (size_t)(end - next)))) {
            list->at[i][0] = (uint16_t)(s->window.x + (next++ - row));
            list->at[i++][1] = (uint16_t)(s->window.y + y);
        }
    }
    for (; i < room; i++)
        memcpy(list->at[i], list->at[list->count - 1], sizeof *list->at);
    return true;
}

// Copies the marks of the window, which begins a radius below and left of the part.
static void copy_marks(const weft_supersample *s, const struct weft_marks *marks,
                       struct weft_marks *out)
{
    const struct weft_rectangle of = weft_marks_part(marks);
    const struct weft_rectangle window = weft_part_moved(&s->window, -s->radius, -s->radius);
    const struct weft_rectangle both = weft_rectangle_common(&of, &window);
    for (int32_t y = both.y; y < both.y + both.height; y++) {
        const uint8_t *in =
            &marks->marked[(size_t)(y - of.y) * (size_t)of.width + (size_t)(both.x - of.x)];
        uint8_t *row = &out->marked[(size_t)(y - window.y) * (size_t)window.width +
                                    (size_t)(both.x - window.x)];
        for (int32_t x = 0; x < both.width; x++)
            row[x] = in[x] != 0;
    }
}

// Marks of the window: those of the picture, or everything.
static bool make_mask(const weft_supersample *s, const struct weft_marks *marks,
                      struct weft_marks *out)
{
    *out = (struct weft_marks){.width = s->window.width, .height = s->window.height};
    out->marked = calloc(weft_part_pixels(&s->window), 1);
    if (!out->marked)
        return false;
    if (marks)
        copy_marks(s, marks, out);
    else
        memset(out->marked, 1, weft_part_pixels(&s->window));
    return true;
}

// Takes off the marks of what is not of the part: they count for other parts.
static void clear_rim(const weft_supersample *s, struct weft_marks *marks)
{
    const int32_t rim = s->radius, width = marks->width, height = marks->height;
    for (int32_t y = 0; y < height && rim > 0; y++) {
        uint8_t *row = &marks->marked[(size_t)y * (size_t)width];
        const bool inside = y >= rim && y < height - rim;
        memset(row, 0, (size_t)(inside ? rim : width));
        if (inside)
            memset(row + width - rim, 0, (size_t)rim);
    }
}

// What is drawn are the samples that the pixels of the part are filtered from.
enum weft_result weft_supersample_list(weft_supersample *s, const struct weft_marks *marks)
{
    const bool blocks = s->params.store == WEFT_STORE_BLOCKS;
    s->masked = marks != NULL;
    if (!marks && !blocks) {
        s->result.width = s->part.width;
        s->result.height = s->part.height;
        s->result.count = (int64_t)weft_part_pixels(&s->part);
        s->sampled.count = (int64_t)weft_part_pixels(&s->window);
        return WEFT_OK;
    }
    if (!make_mask(s, marks, &s->mask))
        return no_memory(s);
    if (marks && weft_marks_dilate(&s->mask, s->radius) != WEFT_OK)
        return no_memory(s);
    s->result.count = count_marks(&s->mask, s->radius);
    if (!make_list(s, s->radius, &s->result))
        return no_memory(s);
    if (marks)
        clear_rim(s, &s->mask);
    if (marks && weft_marks_dilate(&s->mask, s->radius) != WEFT_OK)
        return no_memory(s);
    s->sampled.count = count_marks(&s->mask, 0);
    if (blocks && !make_list(s, 0, &s->sampled))
        return no_memory(s);
    return WEFT_OK;
}

void weft_pixel_list_clear(const GladGLContext *gl, struct weft_pixel_list *list)
{
    if (list->texture)
        gl->DeleteTextures(1, &list->texture);
    free(list->at);
    *list = (struct weft_pixel_list){0};
}

enum weft_result weft_places_load(const struct weft_log *log, const GladGLContext *gl,
                                  int32_t width, int32_t height, const uint16_t (*at)[2],
                                  GLuint *out)
{
    gl->GenTextures(1, out);
    gl->BindTexture(GL_TEXTURE_2D, *out);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    gl->TexImage2D(GL_TEXTURE_2D, 0, GL_RG16UI, width, height, 0, GL_RG_INTEGER, GL_UNSIGNED_SHORT,
                   at);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 4);
    weft_texture_by_texel(gl, GL_TEXTURE_2D);
    gl->BindTexture(GL_TEXTURE_2D, 0);
    return weft_gl_check(log, gl, "listing pixels");
}
