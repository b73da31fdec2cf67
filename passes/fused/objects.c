// SPDX-License-Identifier: BSD-3-Clause
#include "passes/fused/objects.h"

GLenum weft_fused_source_format(enum weft_source_format format, enum weft_layout layout)
{
    static const GLenum formats[WEFT_SOURCE_FORMATS][2] = {
        [WEFT_SOURCE_FLOAT] = {GL_RGBA32F, GL_R32F},
        [WEFT_SOURCE_HALF] = {GL_RGBA16F, GL_R16F},
        [WEFT_SOURCE_UNORM16] = {GL_RGBA16, GL_R16},
        [WEFT_SOURCE_UNORM8] = {GL_RGBA8, GL_R8},
    };
    return formats[format][layout == WEFT_LAYOUT_PLAIN];
}

static enum weft_result fit_buffer(const struct weft_log *log, const GladGLContext *gl,
                                   GLenum format, size_t texels, struct weft_gl_buffer *buffer)
{
    return texels ? weft_gl_buffer_fit(log, gl, format, texels, buffer) : WEFT_OK;
}

enum weft_result weft_fused_objects_fit(const struct weft_log *log, const GladGLContext *gl,
                                        const struct weft_fused_sizes *s,
                                        struct weft_fused_objects *o)
{
    enum weft_result res = fit_buffer(log, gl, s->source_format, s->source_texels, &o->source);
    if (res == WEFT_OK)
        res = fit_buffer(log, gl, GL_R32I, s->entries, &o->entries);
    if (res == WEFT_OK)
        res = fit_buffer(log, gl, GL_R32F, s->constants, &o->constants);
    if (res == WEFT_OK && !s->targets)
        res = weft_gl_target_fit(log, gl, GL_R32F, s->width, s->height, &o->target);
    for (int i = 0; res == WEFT_OK && i < s->targets; i++)
        res = weft_gl_target_fit(log, gl, GL_RGBA32F, s->width, s->height, &o->targets[i]);
    return res;
}

void weft_fused_objects_destroy(const GladGLContext *gl, struct weft_fused_objects *o)
{
    weft_gl_buffer_destroy(gl, &o->source);
    weft_gl_buffer_destroy(gl, &o->entries);
    weft_gl_buffer_destroy(gl, &o->constants);
    for (int n = 0; n < WEFT_LINE_ORDERS; n++)
        weft_gl_buffer_destroy(gl, &o->kernel[n]);
    weft_gl_target_destroy(gl, &o->target);
    for (int i = 0; i < WEFT_FUSED_TARGETS; i++)
        weft_gl_target_destroy(gl, &o->targets[i]);
}
