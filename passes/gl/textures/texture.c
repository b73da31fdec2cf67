// SPDX-License-Identifier: BSD-3-Clause
#include "passes/gl/textures/texture.h"

#include <stdlib.h>

#include "filter/check.h"
#include "passes/gl/textures/output.h"

enum { CHANNELS = 4, READ_PIXELS = 1 << 18 };

static enum weft_result check(weft_context *context, const struct weft_texture *texture, int width,
                              int channels, const float *const *plane, int64_t *stride)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    if (!context)
        return res;
    weft_require(context->log, texture && plane);
    weft_require(context->log, channels >= 1 && channels <= CHANNELS);
    weft_require(context->log, *stride == 0 || (*stride >= width && *stride <= INT32_MAX));
    for (int c = 0; c < channels; c++)
        weft_require(context->log, plane[c] != NULL);
    if (*stride == 0)
        *stride = width;
    res = WEFT_OK;
fail:
    return res;
}

// Rows come with all four channels, as every GL reads them.
static enum weft_result read_rows(const struct weft_gl_output *o, int width, int height,
                                  int channels, float *const *plane, int64_t stride)
{
    const GladGLContext *gl = &o->context->gl;
    const int fit = READ_PIXELS / width, most = fit < 1 ? 1 : fit < height ? fit : height;
    float *texels = malloc((size_t)width * (size_t)most * CHANNELS * sizeof *texels);
    enum weft_result res = WEFT_OK;
    if (!texels) {
        weft_error(o->log, "not enough memory for %d rows of %d texels", most, width);
        return WEFT_ERR_MEMORY;
    }
    for (int y = 0; res == WEFT_OK && y < height; y += most) {
        const int rows = height - y < most ? height - y : most;
        gl->ReadPixels(o->at.x, o->at.y + y, width, rows, GL_RGBA, GL_FLOAT, texels);
        res = weft_gl_check(o->log, gl, "reading a texture");
        for (int c = 0; res == WEFT_OK && c < channels; c++)
            for (int row = 0; row < rows; row++)
                for (int x = 0; x < width; x++)
                    plane[c][(y + row) * stride + x] =
                        texels[CHANNELS * ((size_t)row * (size_t)width + (size_t)x) +
                               (size_t)(o->at.channel + c)];
    }
    free(texels);
    return res;
}

enum weft_result weft_texture_read(weft_context *context, const struct weft_texture *texture,
                                   int width, int height, int channels, float *const *plane,
                                   int64_t stride)
{
    struct weft_gl_output output;
    enum weft_result res =
        check(context, texture, width, channels, (const float *const *)plane, &stride);
    if (res == WEFT_OK)
        res = weft_context_enter(context);
    if (res != WEFT_OK)
        return res;
    res = weft_gl_output_open(context, context->log, texture, width, height, channels, &output);
    if (res == WEFT_OK) {
        res = read_rows(&output, width, height, channels, plane, stride);
        weft_gl_output_close(&output);
    }
    weft_context_leave(context);
    return res;
}

enum weft_result weft_texture_write(weft_context *context, const struct weft_texture *texture,
                                    int width, int height, int channels, const float *const *plane,
                                    int64_t stride)
{
    const struct weft_rectangle whole = {.width = width, .height = height};
    struct weft_gl_output output;
    enum weft_result res = check(context, texture, width, channels, plane, &stride);
    if (res == WEFT_OK)
        res = weft_context_enter(context);
    if (res != WEFT_OK)
        return res;
    res = weft_gl_output_open(context, context->log, texture, width, height, channels, &output);
    for (int c = 0; res == WEFT_OK && c < channels; c++)
        res = weft_gl_output_upload(&output, plane[c], stride, c, &whole);
    weft_gl_output_close(&output);
    weft_context_leave(context);
    return res;
}
