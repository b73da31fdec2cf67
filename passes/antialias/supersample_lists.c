// SPDX-License-Identifier: BSD-3-Clause
// Which pixels count. A marked pixel's samples reach the pixels within the filter's radius: all of
// these are supersampled. For each of them the samples within the radius are drawn, be they in the
// picture or in the rim around it.
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "passes/antialias/supersample_impl.h"

static enum weft_result no_memory(const weft_supersample *s)
{
    weft_error(s->params.log,
               "supersample: not enough memory for lists of the pixels of %d x %d pixels",
               s->scratch.width, s->scratch.height);
    return WEFT_ERR_MEMORY;
}

// Rows of a whole number of 8 x 8 pixels, about as many as they are long.
static void shape(struct weft_pixel_list *list)
{
    const int32_t side = (int32_t)ceil(sqrt((double)list->count));
    list->width = (side + 7) / 8 * 8;
    list->height = (int32_t)((list->count + list->width - 1) / list->width);
}

// Counts the pixels of the scratch target, without `rim` at its borders, that are marked.
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

// Lists them, list->count in number.
static bool make_list(const struct weft_marks *marks, int rim, struct weft_pixel_list *list)
{
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
            list->at[i][0] = (uint16_t)(next++ - row);
            list->at[i++][1] = (uint16_t)y;
        }
    }
    for (; i < room; i++)
        memcpy(list->at[i], list->at[list->count - 1], sizeof *list->at);
    return true;
}

// Marks of the scratch target: those of the picture, or everything.
static bool copy_marks(const weft_supersample *s, const struct weft_marks *marks,
                       struct weft_marks *out)
{
    const size_t width = (size_t)s->scratch.width, height = (size_t)s->scratch.height,
                 rim = (size_t)s->radius;
    *out = (struct weft_marks){.width = s->scratch.width, .height = s->scratch.height};
    out->marked = calloc(width * height, 1);
    if (!out->marked)
        return false;
    if (!marks)
        memset(out->marked, 1, width * height);
    for (size_t y = 0; marks && y < (size_t)marks->height; y++) {
        const uint8_t *in = &marks->marked[y * (size_t)marks->width];
        uint8_t *row = &out->marked[(y + rim) * width + rim];
        for (int32_t x = 0; x < marks->width; x++)
            row[x] = in[x] != 0;
    }
    return true;
}

// A mark reaches a pixel of the rim, or what is drawn for it, by way of a pixel of the picture: the
// pixels between them are. So what is drawn are the marks, dilated twice.
enum weft_result weft_supersample_list(weft_supersample *s, const struct weft_marks *marks)
{
    const bool blocks = s->params.store == WEFT_STORE_BLOCKS;
    s->masked = marks != NULL;
    if (!marks && !blocks) {
        s->result.width = s->params.width;
        s->result.height = s->params.height;
        s->result.count = (int64_t)s->params.width * s->params.height;
        s->sampled.count = (int64_t)s->scratch.width * s->scratch.height;
        return WEFT_OK;
    }
    if (!copy_marks(s, marks, &s->mask))
        return no_memory(s);
    if (marks && weft_marks_dilate(&s->mask, s->radius) != WEFT_OK)
        return no_memory(s);
    s->result.count = count_marks(&s->mask, s->radius);
    if (!make_list(&s->mask, s->radius, &s->result))
        return no_memory(s);
    if (marks && weft_marks_dilate(&s->mask, s->radius) != WEFT_OK)
        return no_memory(s);
    s->sampled.count = count_marks(&s->mask, 0);
    if (blocks && !make_list(&s->mask, 0, &s->sampled))
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
