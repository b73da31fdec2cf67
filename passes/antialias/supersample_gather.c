// SPDX-License-Identifier: BSD-3-Clause
// Passes over lists of pixels: samples into a layer of the blocks, and samples, filtered or as they
// are, into a compact target.
#include <stdio.h>
#include <stdlib.h>

#include "filter/check.h"
#include "passes/antialias/supersample_impl.h"
#include "passes/gl/program.h"

// ---- what they go into --------------------------------------------------------------------------

// Where the pixels of the window are in a layer.
static enum weft_result load_pointers(weft_supersample *s)
{
    const struct weft_pixel_list *list = &s->sampled;
    const struct weft_rectangle *window = &s->window;
    const size_t width = (size_t)window->width, height = (size_t)window->height;
    uint16_t(*at)[2] = calloc(width * height, sizeof *at);
    if (!at) {
        weft_error(s->params.log, "supersample: not enough memory for %zu pointers",
                   width * height);
        return WEFT_ERR_MEMORY;
    }
    for (int64_t i = 0; i < list->count; i++) {
        uint16_t *pointer =
            at[(size_t)(list->at[i][1] - window->y) * width + (size_t)(list->at[i][0] - window->x)];
        pointer[0] = (uint16_t)(i % list->width);
        pointer[1] = (uint16_t)(i / list->width);
    }
    const enum weft_result res =
        weft_places_load(s->params.log, &s->params.context->gl, window->width, window->height,
                         (const uint16_t(*)[2])at, &s->pointers);
    free(at);
    return res;
}

static enum weft_result make_blocks(weft_supersample *s)
{
    const GladGLContext *gl = &s->params.context->gl;
    static const GLenum types[WEFT_ANTIALIAS_FORMAT_COUNT] = {GL_UNSIGNED_BYTE, GL_FLOAT, GL_FLOAT};
    gl->GenTextures(1, &s->blocks);
    gl->BindTexture(GL_TEXTURE_2D_ARRAY, s->blocks);
    gl->TexImage3D(GL_TEXTURE_2D_ARRAY, 0, (GLint)weft_supersample_format(s), s->sampled.width,
                   s->sampled.height, s->used, 0, GL_RGBA, types[s->params.format], NULL);
    weft_texture_by_texel(gl, GL_TEXTURE_2D_ARRAY);
    gl->BindTexture(GL_TEXTURE_2D_ARRAY, 0);
    gl->GenFramebuffers(1, &s->framebuffer);
    enum weft_result res = weft_gl_check(s->params.log, gl, "making blocks of samples");
    if (res == WEFT_OK)
        res = weft_places_load(s->params.log, gl, s->sampled.width, s->sampled.height,
                               (const uint16_t(*)[2])s->sampled.at, &s->sampled.texture);
    return res == WEFT_OK ? load_pointers(s) : res;
}

// A picture of all pixels, whose samples are not filtered, is a frame as it is.
static bool scratch_is_frame(const weft_supersample *s)
{
    return s->copies && !s->result.at && s->params.store == WEFT_STORE_SUMS &&
           s->result.count == (int64_t)s->params.width * s->params.height;
}

enum weft_result weft_supersample_make_compact(weft_supersample *s)
{
    const struct weft_log *log = s->params.log;
    const GladGLContext *gl = &s->params.context->gl;
    enum weft_result res = WEFT_OK;
    if (weft_supersample_picks(s))
        return weft_supersample_make_picked(s);
    if (s->result.at)
        res = weft_places_load(log, gl, s->result.width, s->result.height,
                               (const uint16_t(*)[2])s->result.at, &s->result.texture);
    if (res == WEFT_OK && s->params.store == WEFT_STORE_BLOCKS)
        res = make_blocks(s);
    if (res == WEFT_OK && !scratch_is_frame(s))
        res = weft_gl_target_create(log, gl, s->copies ? weft_supersample_format(s) : GL_RGBA32F,
                                    s->result.width, s->result.height, &s->compact);
    return res;
}

void weft_supersample_destroy_compact(weft_supersample *s)
{
    const GladGLContext *gl = &s->params.context->gl;
    weft_gl_target_destroy(gl, &s->compact);
    if (s->blocks)
        gl->DeleteTextures(1, &s->blocks);
    if (s->pointers)
        gl->DeleteTextures(1, &s->pointers);
    if (s->framebuffer)
        gl->DeleteFramebuffers(1, &s->framebuffer);
    s->blocks = s->pointers = s->framebuffer = 0;
    weft_supersample_destroy_picked(s);
}

uint64_t weft_supersample_gl_bytes(const weft_supersample *s)
{
    const GladGLContext *gl = &s->params.context->gl;
    const GLuint textures[] = {s->scratch.texture, s->compact.texture, s->result.texture,
                               s->sampled.texture, s->pointers};
    uint64_t bytes = s->depth.bytes;
    for (size_t i = 0; i < WEFT_COUNT(textures); i++)
        if (textures[i])
            bytes += weft_texture_bytes(gl, GL_TEXTURE_2D, textures[i]);
    if (s->blocks)
        bytes += weft_texture_bytes(gl, GL_TEXTURE_2D_ARRAY, s->blocks);
    return bytes;
}

// ---- passes -------------------------------------------------------------------------------------

struct gathering {
    GLuint framebuffer;
    const struct weft_pixel_list *list;
    bool from_blocks;
    const struct weft_supersample_sample *filter; // NULL: samples are copied
    int layer;
};

static enum weft_result find_program(weft_supersample *s, const struct gathering *g, GLuint *out)
{
    char defines[256];
    snprintf(defines, sizeof defines,
             "#extension GL_ARB_gpu_shader5 : enable\n"
             "#define LISTED %d\n#define BLOCKS %d\n#define COLUMNS %d\n#define LARGEST %d\n",
             g->list->at != NULL, g->from_blocks, g->filter ? g->filter->columns : 0,
             (2 * WEFT_PATTERN_MAX_RADIUS + 1) * (2 * WEFT_PATTERN_MAX_RADIUS + 1));
    return weft_program_get(s->params.context, "supersample_gather", defines,
                            weft_shader_full_target, weft_shader_supersample_gather, out);
}

static enum weft_result run(weft_supersample *s, const struct gathering *g)
{
    const GladGLContext *gl = &s->params.context->gl;
    GLuint program;
    const enum weft_result res = find_program(s, g, &program);
    if (res != WEFT_OK)
        return res;
    gl->BindFramebuffer(GL_FRAMEBUFFER, g->framebuffer);
    gl->Viewport(0, 0, g->list->width, g->list->height);
    gl->UseProgram(program);
    if (g->list->at)
        weft_gl_bind_texture(gl, program, 0, "list", GL_TEXTURE_2D, g->list->texture);
    if (g->from_blocks) {
        weft_gl_bind_texture(gl, program, 1, "blocks", GL_TEXTURE_2D_ARRAY, s->blocks);
        weft_gl_bind_texture(gl, program, 2, "pointers", GL_TEXTURE_2D, s->pointers);
        gl->Uniform2i(weft_gl_location(gl, program, "window"), s->window.x, s->window.y);
        gl->Uniform1i(weft_gl_location(gl, program, "layer"), g->layer);
    } else {
        weft_gl_bind_texture(gl, program, 1, "scratch", GL_TEXTURE_2D, s->scratch.texture);
    }
    if (!g->list->at)
        gl->Uniform2i(weft_gl_location(gl, program, "corner"), s->part.x + s->radius,
                      s->part.y + s->radius);
    if (g->filter) {
        const struct weft_supersample_sample *f = g->filter;
        gl->Uniform2i(weft_gl_location(gl, program, "first"), f->first[0], f->first[1]);
        gl->Uniform1i(weft_gl_location(gl, program, "rows"), f->rows);
        gl->Uniform1fv(weft_gl_location(gl, program, "weight"), f->columns * f->rows, f->weight);
    }
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    return weft_gl_check(s->params.log, gl, "gathering samples");
}

enum weft_result weft_supersample_keep(weft_supersample *s, int index)
{
    const GladGLContext *gl = &s->params.context->gl;
    gl->BindFramebuffer(GL_FRAMEBUFFER, s->framebuffer);
    gl->FramebufferTextureLayer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, s->blocks, 0, index);
    return run(s, &(struct gathering){.framebuffer = s->framebuffer, .list = &s->sampled});
}

enum weft_result weft_supersample_gather(weft_supersample *s, int index, GLuint *texture)
{
    *texture = scratch_is_frame(s) ? s->scratch.texture : s->compact.texture;
    if (scratch_is_frame(s))
        return WEFT_OK;
    return run(s, &(struct gathering){
                      .framebuffer = s->compact.framebuffer,
                      .list = &s->result,
                      .from_blocks = s->params.store == WEFT_STORE_BLOCKS,
                      .filter = s->copies ? NULL : &s->sample[index],
                      .layer = index,
                  });
}
