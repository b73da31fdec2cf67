// SPDX-License-Identifier: BSD-3-Clause
#include "passes/gl/textures/delivery.h"

#include <stdlib.h>

#include "filter/check.h"

enum weft_result weft_gl_delivery_begin(weft_context *context, const struct weft_log *log,
                                        const struct weft_texture *texture,
                                        struct weft_gl_delivery *d)
{
    d->reads = d->at != NULL;
    d->draws = texture != NULL;
    d->output = (struct weft_gl_output){.framebuffer = 0};
    return texture ? weft_gl_output_open(context, log, texture, d->width, d->height, d->outputs,
                                         &d->output)
                   : WEFT_OK;
}

void weft_gl_delivery_end(struct weft_gl_delivery *d)
{
    weft_gl_output_close(&d->output);
    if (!d->reads)
        free(d->at);
    d->at = NULL;
}

enum weft_result weft_gl_delivery_room(const struct weft_log *log, struct weft_gl_delivery *d)
{
    if (d->at)
        return WEFT_OK;
    d->stride = d->width;
    d->plane = d->stride * d->height;
    d->at = malloc((size_t)d->plane * (size_t)d->outputs * sizeof *d->at);
    if (d->at)
        return WEFT_OK;
    weft_error(log, "not enough memory for %d x %d pixels of %d outputs", d->width, d->height,
               d->outputs);
    return WEFT_ERR_MEMORY;
}

enum weft_result weft_gl_delivery_draw(const struct weft_gl_delivery *d,
                                       const struct weft_gl_drawn *drawn,
                                       const struct weft_rectangle *at)
{
    return d->draws ? weft_gl_output_draw(&d->output, drawn, 0, d->outputs, at) : WEFT_OK;
}

enum weft_result weft_gl_delivery_upload(struct weft_gl_delivery *d,
                                         const struct weft_rectangle *at)
{
    enum weft_result res = WEFT_OK;
    for (int o = 0; res == WEFT_OK && d->draws && o < d->outputs; o++)
        res = weft_gl_output_upload(&d->output, d->at + o * d->plane + at->y * d->stride + at->x,
                                    d->stride, o, at);
    return res;
}
