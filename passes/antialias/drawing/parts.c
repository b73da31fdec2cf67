// SPDX-License-Identifier: BSD-3-Clause
#include "passes/antialias/drawing/run.h"
#include "passes/gl/target.h"

void weft_part_scissor(const GladGLContext *gl, const struct weft_rectangle *part, int32_t width,
                       int32_t height)
{
    if (part->width == width && part->height == height) {
        gl->Disable(GL_SCISSOR_TEST);
        return;
    }
    gl->Enable(GL_SCISSOR_TEST);
    gl->Scissor(part->x, part->y, part->width, part->height);
}

struct weft_rectangle weft_part_grown(const struct weft_rectangle *part, int by, int32_t width,
                                      int32_t height)
{
    const struct weft_rectangle all = {0, 0, width, height};
    const struct weft_rectangle grown = {part->x - by, part->y - by, part->width + 2 * by,
                                         part->height + 2 * by};
    return weft_rectangle_common(&grown, &all);
}

struct weft_rectangle weft_part_moved(const struct weft_rectangle *part, int32_t x, int32_t y)
{
    return (struct weft_rectangle){part->x + x, part->y + y, part->width, part->height};
}

size_t weft_part_pixels(const struct weft_rectangle *part)
{
    return (size_t)part->width * (size_t)part->height;
}

enum weft_result weft_background_kept(const struct weft_log *log, const GladGLContext *gl,
                                      GLenum format, const double colour[4], GLfloat out[4])
{
    struct weft_gl_target target;
    for (int c = 0; c < 4; c++)
        out[c] = (GLfloat)colour[c];
    enum weft_result res = weft_gl_target_create(log, gl, format, 1, 1, &target);
    if (res != WEFT_OK)
        return res;
    gl->ClearBufferfv(GL_COLOR, 0, out);
    res = weft_gl_target_read(
        log, gl, &target,
        &(struct weft_gl_pixels){.width = 1, .height = 1, .type = GL_FLOAT, .data = out});
    weft_gl_target_destroy(gl, &target);
    return res;
}
