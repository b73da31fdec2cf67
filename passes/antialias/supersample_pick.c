// SPDX-License-Identifier: BSD-3-Clause
// On software GL, samples that are not filtered are picked from memory, a band of rows at a time:
// reading rows is copying them there, and a pixel of a list costs a tenth of what a shader and
// reading back its target take. All pixels of a part are read at once. Values are the same ones,
// codes or bits of floats.
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "passes/antialias/supersample_impl.h"

enum { BAND_ROWS = 32 };

static const struct {
    GLenum type;
    enum weft_plane_type plane;
    size_t channel_bytes;
} formats[WEFT_ANTIALIAS_FORMAT_COUNT] = {
    {GL_UNSIGNED_BYTE, WEFT_PLANE_UNORM8, 1},
    {GL_HALF_FLOAT, WEFT_PLANE_HALF, 2},
    {GL_FLOAT, WEFT_PLANE_FLOAT, 4},
};

static size_t pixel_bytes(const weft_supersample *s)
{
    return 4 * formats[s->params.format].channel_bytes;
}

bool weft_supersample_picks(const weft_supersample *s)
{
    const enum weft_accumulate_method method = s->params.method;
    const bool all = s->result.count == (int64_t)s->params.width * s->params.height;
    return s->copies && (s->result.at || !all) && s->params.store == WEFT_STORE_SUMS &&
           !weft_context_get_info(s->params.context)->hardware &&
           (method == WEFT_ACCUMULATE_AUTO || method == WEFT_ACCUMULATE_EXACT);
}

uint64_t weft_supersample_pick_bytes(const weft_supersample *s)
{
    const struct weft_pixel_list *list = &s->result;
    return weft_supersample_picks(s)
               ? pixel_bytes(s) * ((uint64_t)list->width * (uint64_t)list->height +
                                   (list->at ? BAND_ROWS * (uint64_t)s->part.width : 0))
               : 0;
}

enum weft_result weft_supersample_make_picked(weft_supersample *s)
{
    const size_t pixels = (size_t)s->result.width * (size_t)s->result.height;
    s->picked = malloc(pixels * pixel_bytes(s));
    if (s->result.at)
        s->band = malloc(BAND_ROWS * (size_t)s->part.width * pixel_bytes(s));
    if (s->picked && (s->band || !s->result.at))
        return WEFT_OK;
    weft_error(s->params.log, "supersample: not enough memory for %" PRId64 " pixels",
               s->result.count);
    return WEFT_ERR_MEMORY;
}

void weft_supersample_destroy_picked(weft_supersample *s)
{
    free(s->picked);
    free(s->band);
    s->picked = s->band = NULL;
}

// Pixels from `first` on that lie in the band whose lowest row is `low`; returns the next one.
static size_t pick_band(weft_supersample *s, size_t first, size_t low, size_t bytes)
{
    const struct weft_pixel_list *list = &s->result;
    const size_t room = (size_t)list->width * (size_t)list->height, width = (size_t)s->part.width,
                 left = (size_t)(s->part.x + s->radius);
    const char *band = s->band;
    char *out = s->picked;
    size_t i = first;
    for (; i < room && list->at[i][1] < low + BAND_ROWS; i++)
        memcpy(out + i * bytes,
               band + ((list->at[i][1] - low) * width + list->at[i][0] - left) * bytes, bytes);
    return i;
}

// Constant sizes, so that copies are moves.
static size_t pick(weft_supersample *s, size_t first, size_t low)
{
    switch (s->params.format) {
    case WEFT_ANTIALIAS_RGBA8:
        return pick_band(s, first, low, 4);
    case WEFT_ANTIALIAS_RGBA16F:
        return pick_band(s, first, low, 8);
    default:
        return pick_band(s, first, low, 16);
    }
}

// Columns of the part, from a row of the scratch on.
static void read_rows(const weft_supersample *s, int32_t low, int32_t rows, void *out)
{
    s->params.context->gl.ReadPixels(s->part.x + s->radius, low, s->part.width, rows, GL_RGBA,
                                     formats[s->params.format].type, out);
}

static void pick_list(weft_supersample *s)
{
    const struct weft_pixel_list *list = &s->result;
    const size_t room = (size_t)list->width * (size_t)list->height;
    const int32_t end = s->part.y + s->radius + s->part.height;
    for (size_t i = 0; i < room;) {
        const int32_t low = list->at[i][1];
        read_rows(s, low, end - low < BAND_ROWS ? end - low : BAND_ROWS, s->band);
        i = pick(s, i, (size_t)low);
    }
}

enum weft_result weft_supersample_pick(weft_supersample *s, struct weft_plane planes[4])
{
    const GladGLContext *gl = &s->params.context->gl;
    const struct weft_pixel_list *list = &s->result;
    gl->BindFramebuffer(GL_FRAMEBUFFER, s->scratch.framebuffer);
    gl->PixelStorei(GL_PACK_ALIGNMENT, 1);
    if (list->at)
        pick_list(s);
    else
        read_rows(s, s->part.y + s->radius, s->part.height, s->picked);
    gl->PixelStorei(GL_PACK_ALIGNMENT, 4);
    for (int c = 0; c < 4; c++)
        planes[c] = (struct weft_plane){
            .values = (char *)s->picked + (size_t)c * formats[s->params.format].channel_bytes,
            .type = formats[s->params.format].plane,
            .step = 4,
            .stride = 4 * (size_t)list->width,
        };
    return weft_gl_check(s->params.log, gl, "reading samples");
}
