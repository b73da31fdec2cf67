// SPDX-License-Identifier: BSD-3-Clause
#include "passes/gl/volume_texture.h"

static const struct {
    GLenum format, type;
} formats[WEFT_SOURCE_FORMATS] = {
    [WEFT_SOURCE_FLOAT] = {GL_R32F, GL_FLOAT},
    [WEFT_SOURCE_HALF] = {GL_R16F, GL_HALF_FLOAT},
    [WEFT_SOURCE_UNORM16] = {GL_R16, GL_UNSIGNED_SHORT},
    [WEFT_SOURCE_UNORM8] = {GL_R8, GL_UNSIGNED_BYTE},
};

enum weft_result weft_gl_volume_create(const struct weft_log *log, const GladGLContext *gl,
                                       enum weft_source_format format, const int size[3],
                                       struct weft_gl_volume *out)
{
    static const GLenum wraps[] = {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R};
    *out = (struct weft_gl_volume){.format = format, .size = {size[0], size[1], size[2]}};
    gl->GenTextures(1, &out->texture);
    gl->BindTexture(GL_TEXTURE_3D, out->texture);
    gl->TexImage3D(GL_TEXTURE_3D, 0, (GLint)formats[format].format, size[0], size[1], size[2], 0,
                   GL_RED, formats[format].type, NULL);
    gl->TexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAX_LEVEL, 0);
    gl->TexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl->TexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    for (size_t i = 0; i < WEFT_COUNT(wraps); i++)
        gl->TexParameteri(GL_TEXTURE_3D, wraps[i], GL_CLAMP_TO_EDGE);
    const enum weft_result res = weft_gl_check(log, gl, "creating a 3D texture");
    if (res == WEFT_OK)
        return WEFT_OK;
    weft_error(log, "GL: a 3D texture of %d x %d x %d texels %s cannot be had", size[0], size[1],
               size[2], weft_source_format_name(format));
    weft_gl_volume_destroy(gl, out);
    return res;
}

void weft_gl_volume_destroy(const GladGLContext *gl, struct weft_gl_volume *volume)
{
    if (volume->texture)
        gl->DeleteTextures(1, &volume->texture);
    *volume = (struct weft_gl_volume){0};
}

enum weft_result weft_gl_volume_load(const struct weft_log *log, const GladGLContext *gl,
                                     const struct weft_gl_volume *volume, int z, int depth,
                                     const void *texels)
{
    gl->BindTexture(GL_TEXTURE_3D, volume->texture);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    gl->TexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, z, volume->size[0], volume->size[1], depth, GL_RED,
                      formats[volume->format].type, texels);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 4);
    return weft_gl_check(log, gl, "filling a 3D texture");
}
