// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/texture.h"

#include <stdlib.h>
#include <string.h>

static const uint64_t DEFAULT_MEMORY = UINT64_C(1) << 30;

struct storage {
    const char *name;
    GLenum internal_format, type;
    size_t texel_bytes;
    double one; // the integer that GL reads as 1.0
    bool bytes; // held as 16 bits by the set
};

static const struct storage unorm_8 = {"R8", GL_R8, GL_UNSIGNED_BYTE, 1, 255.0, true};
static const struct storage unorm_16 = {"R16", GL_R16, GL_UNSIGNED_SHORT, 2, 65535.0, false};
static const struct storage snorm_8 = {"R8_SNORM", GL_R8_SNORM, GL_BYTE, 1, 127.0, true};
static const struct storage snorm_16 = {"R16_SNORM", GL_R16_SNORM, GL_SHORT, 2, 32767.0, false};
static const struct storage half_float = {"R16F", GL_R16F, GL_FLOAT, 2, 1.0, false};
static const struct storage full_float = {"R32F", GL_R32F, GL_FLOAT, 4, 1.0, false};

static const struct storage *find_storage(const struct weft_kernel_tiles_info *info,
                                          enum weft_error_lookup lookup)
{
    switch (info->format) {
    case WEFT_TILE_UNORM:
        return info->bits > 8 || (info->bits < 8 && lookup == WEFT_ERROR_LINEAR) ? &unorm_16
                                                                                 : &unorm_8;
    case WEFT_TILE_SNORM:
        return info->bits == 8 ? &snorm_8 : &snorm_16;
    case WEFT_TILE_HALF:
        return &half_float;
    case WEFT_TILE_FLOAT:
        break;
    }
    return &full_float;
}

static const struct storage *storage_of(const struct weft_tile_texture *texture)
{
    static const struct storage *const all[] = {&unorm_8,  &unorm_16,   &snorm_8,
                                                &snorm_16, &half_float, &full_float};
    size_t i = 0;
    while (all[i]->internal_format != texture->internal_format)
        i++;
    return all[i];
}

// ---- sizes --------------------------------------------------------------------------------------

// `target` is the texture's own or its proxy.
static void allocate(const GladGLContext *gl, GLenum target, int dims, int m, GLenum internal,
                     GLenum format, GLenum type, const void *data)
{
    if (dims == 1)
        gl->TexImage1D(target, 0, (GLint)internal, m, 0, format, type, data);
    else if (dims == 2)
        gl->TexImage2D(target, 0, (GLint)internal, m, m, 0, format, type, data);
    else
        gl->TexImage3D(target, 0, (GLint)internal, m, m, m, 0, format, type, data);
}

static const GLenum targets[3] = {GL_TEXTURE_1D, GL_TEXTURE_2D, GL_TEXTURE_3D};
static const GLenum proxies[3] = {GL_PROXY_TEXTURE_1D, GL_PROXY_TEXTURE_2D, GL_PROXY_TEXTURE_3D};

static enum weft_result check_sizes(const struct weft_log *log, const GladGLContext *gl,
                                    const struct weft_kernel_tiles_info *info,
                                    const struct storage *storage, uint64_t memory_bytes,
                                    const struct weft_tile_texture *texture)
{
    const uint64_t limit = memory_bytes ? memory_bytes : DEFAULT_MEMORY;
    const uint64_t needed = (uint64_t)texture->bytes * (storage->bytes ? 2 : 1);
    if (needed > limit) {
        weft_error(log,
                   "a tile texture of %d^%d texels %s takes %.0f bytes, over the limit of %.0f",
                   info->samples, info->dims, storage->name, (double)needed, (double)limit);
        return WEFT_ERR_LIMIT;
    }
    const GLenum proxy = proxies[info->dims - 1];
    GLint width = 0;
    allocate(gl, proxy, info->dims, info->samples, texture->internal_format, GL_RED, storage->type,
             NULL);
    gl->GetTexLevelParameteriv(proxy, 0, GL_TEXTURE_WIDTH, &width);
    if (gl->GetError() != GL_NO_ERROR)
        width = 0; // some raise what a proxy should only answer
    if (width == info->samples)
        return WEFT_OK;
    weft_error(log, "a tile texture of %d^%d texels %s (%zu bytes) is more than this GL takes",
               info->samples, info->dims, storage->name, texture->bytes);
    return WEFT_ERR_LIMIT;
}

// ---- data ---------------------------------------------------------------------------------------

// The low byte of every 16-bit value, two's complement included.
static void narrow(const void *values, size_t count, uint8_t *out)
{
    for (size_t i = 0; i < count; i++)
        out[i] = (uint8_t)((const uint16_t *)values)[i];
}

static void widen(const struct storage *storage, const uint8_t *bytes, size_t count, void *values)
{
    for (size_t i = 0; i < count; i++) {
        if (storage->type == GL_BYTE)
            ((int16_t *)values)[i] = (int8_t)bytes[i];
        else
            ((uint16_t *)values)[i] = bytes[i];
    }
}

static void set_sampling(const GladGLContext *gl, GLenum target, enum weft_error_lookup lookup)
{
    static const GLenum wraps[3] = {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R};
    const GLint filter = lookup == WEFT_ERROR_LINEAR ? GL_LINEAR : GL_NEAREST;
    gl->TexParameteri(target, GL_TEXTURE_MIN_FILTER, filter);
    gl->TexParameteri(target, GL_TEXTURE_MAG_FILTER, filter);
    gl->TexParameteri(target, GL_TEXTURE_MAX_LEVEL, 0);
    for (int a = 0; a < 3; a++)
        if (a == 0 || target == GL_TEXTURE_3D || (a == 1 && target == GL_TEXTURE_2D))
            gl->TexParameteri(target, wraps[a], GL_CLAMP_TO_EDGE);
}

static enum weft_result create(const struct weft_log *log, const GladGLContext *gl,
                               const weft_kernel_tiles *tiles, const void *values,
                               enum weft_error_lookup lookup, uint64_t memory_bytes,
                               struct weft_tile_texture *out)
{
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(tiles);
    const struct storage *storage = find_storage(info, lookup);
    const size_t count = info->tile_values;
    uint8_t *staging = NULL;
    out->target = targets[info->dims - 1];
    out->internal_format = storage->internal_format;
    out->bytes = count * storage->texel_bytes;
    out->factor *= storage->one / info->one;
    enum weft_result res = check_sizes(log, gl, info, storage, memory_bytes, out);
    if (res != WEFT_OK)
        goto fail;
    if (storage->bytes) {
        res = WEFT_ERR_MEMORY;
        staging = malloc(count);
        if (!staging) {
            weft_error(log, "not enough memory for %zu bytes of a tile texture", count);
            goto fail;
        }
        narrow(values, count, staging);
    }
    gl->GenTextures(1, &out->texture);
    gl->BindTexture(out->target, out->texture);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    allocate(gl, out->target, info->dims, info->samples, out->internal_format, GL_RED,
             storage->type, storage->bytes ? staging : values);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 4);
    set_sampling(gl, out->target, lookup);
    res = weft_gl_check(log, gl, "uploading a tile");
    if (res != WEFT_OK) {
        weft_error(log, "a tile texture of %zu bytes could not be created", out->bytes);
        goto fail;
    }
    free(staging);
    return WEFT_OK;
fail:
    free(staging);
    weft_tile_texture_destroy(gl, out);
    return res;
}

enum weft_result weft_tile_texture_create(const struct weft_log *log, const GladGLContext *gl,
                                          const weft_kernel_tiles *tiles, int tile,
                                          enum weft_error_lookup lookup, uint64_t memory_bytes,
                                          struct weft_tile_texture *out)
{
    enum weft_result res = WEFT_ERR_ARGUMENT;
    const struct weft_kernel_tile *t = weft_kernel_tiles_get(tiles, tile);
    *out = (struct weft_tile_texture){0};
    weft_require(log, t);
    out->factor = (t->negated ? -1.0 : 1.0) / t->scale;
    return create(log, gl, tiles, t->data, lookup, memory_bytes, out);
fail:
    return res;
}

void weft_tile_texture_destroy(const GladGLContext *gl, struct weft_tile_texture *texture)
{
    if (texture->texture)
        gl->DeleteTextures(1, &texture->texture);
    *texture = (struct weft_tile_texture){0};
}

enum weft_result weft_tile_texture_read(const struct weft_log *log, const GladGLContext *gl,
                                        const weft_kernel_tiles *tiles,
                                        const struct weft_tile_texture *texture, void *values)
{
    const struct storage *storage = storage_of(texture);
    const size_t count = weft_kernel_tiles_get_info(tiles)->tile_values;
    uint8_t *staging = storage->bytes ? malloc(count) : NULL;
    if (storage->bytes && !staging) {
        weft_error(log, "not enough memory to read a tile of %zu bytes back", count);
        return WEFT_ERR_MEMORY;
    }
    gl->BindTexture(texture->target, texture->texture);
    gl->PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl->PixelStorei(GL_PACK_ROW_LENGTH, 0);
    gl->GetTexImage(texture->target, 0, GL_RED, storage->type, storage->bytes ? staging : values);
    gl->PixelStorei(GL_PACK_ALIGNMENT, 4);
    if (storage->bytes)
        widen(storage, staging, count, values);
    free(staging);
    return weft_gl_check(log, gl, "reading a tile back");
}
