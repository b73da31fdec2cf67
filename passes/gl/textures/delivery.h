// SPDX-License-Identifier: BSD-3-Clause
// passes/gl/textures/delivery.h - pictures that are drawn in rectangles, on their way to memory, to
// a caller's texture, or to both (not installed). The context is current in all calls.
#ifndef WEFT_PASSES_GL_TEXTURES_DELIVERY_H
#define WEFT_PASSES_GL_TEXTURES_DELIVERY_H

#include "passes/gl/textures/output.h"

struct weft_gl_delivery {
    int width, height, outputs; // of the picture
    // Output o of pixel (x, y) is at[o * plane + y * stride + x]; NULL: not in memory so far.
    float *at;
    int64_t stride, plane;
    bool reads; // the caller wants them in memory: `at` is the caller's
    bool draws; // the caller wants them in a texture
    struct weft_gl_output output;
};

// The members before `reads` are set; texture NULL: none. Returns what weft_gl_output_open does.
enum weft_result weft_gl_delivery_begin(weft_context *context, const struct weft_log *log,
                                        const struct weft_texture *texture,
                                        struct weft_gl_delivery *delivery);
void weft_gl_delivery_end(struct weft_gl_delivery *delivery);

// Makes sure that there is memory, for pixels that are not as they were drawn. Returns
// WEFT_ERR_MEMORY.
enum weft_result weft_gl_delivery_room(const struct weft_log *log,
                                       struct weft_gl_delivery *delivery);

// Hands a rectangle to the texture, if there is one: as it was drawn (outputs in the order of the
// texels' channels), or as it lies in memory. Returns WEFT_ERR_GL or WEFT_ERR_MEMORY.
enum weft_result weft_gl_delivery_draw(const struct weft_gl_delivery *delivery,
                                       const struct weft_gl_drawn *drawn,
                                       const struct weft_rectangle *at);
enum weft_result weft_gl_delivery_upload(struct weft_gl_delivery *delivery,
                                         const struct weft_rectangle *at);

#endif
