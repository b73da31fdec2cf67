// SPDX-License-Identifier: BSD-3-Clause
// Scenes on OpenGL: what is uploaded once, and frames drawn from it.
#include <math.h>
#include <stdlib.h>

#include "tools/render/frame.h"

// ---- making and ending --------------------------------------------------------------------------

static enum weft_result make_objects(void *priv)
{
    scene_drawing *drawing = priv;
    if (!scene_gl_load(&drawing->gl, drawing->context))
        return WEFT_ERR_GL;
    const GladGLContext *gl = &drawing->gl;
    drawing->bias = scene_shadows_get_bias(gl);
    enum weft_result res = scene_buffers_make(
        gl, drawing->log, drawing->scene,
        weft_context_get_info(drawing->context)->max_buffer_texels, &drawing->buffers);
    if (res == WEFT_OK)
        res = scene_shadows_make(gl, drawing->log, drawing->shadow_size, &drawing->shadows);
    return res == WEFT_OK ? scene_frame_check(drawing, "a scene was uploaded") : res;
}

static enum weft_result end_objects(void *priv)
{
    scene_drawing *drawing = priv;
    const GladGLContext *gl = &drawing->gl;
    if (!gl->DeleteProgram)
        return WEFT_OK;
    scene_parts_end(drawing);
    scene_shadows_end(gl, &drawing->shadows);
    scene_surfaces_end(gl, &drawing->surfaces);
    scene_buffers_end(gl, &drawing->buffers);
    return WEFT_OK;
}

enum weft_result scene_drawing_create(const struct scene_drawing_params *params,
                                      scene_drawing **out)
{
    const struct scene *scene = params->scene;
    *out = NULL;
    scene_drawing *drawing = calloc(1, sizeof *drawing);
    if (!drawing)
        return WEFT_ERR_MEMORY;
    drawing->scene = scene;
    drawing->context = params->context;
    drawing->log = params->log;
    drawing->shadow_size = params->shadow_size;
    drawing->by_triangle = params->by_triangle;
    enum weft_result res = WEFT_ERR_MEMORY;
    const size_t room = (size_t)scene->object_count + 1;
    drawing->extent = calloc(room, sizeof *drawing->extent);
    drawing->hull = calloc(room, sizeof *drawing->hull);
    drawing->model = calloc(room, sizeof *drawing->model);
    drawing->caster = calloc(room, sizeof *drawing->caster);
    drawing->caster_object = calloc(room, sizeof *drawing->caster_object);
    if (!drawing->extent || !drawing->hull || !drawing->model || !drawing->caster ||
        !drawing->caster_object)
        goto fail;
    for (int i = 0; i < 3; i++)
        drawing->middle[i] = 0.5 * (scene->low[i] + scene->high[i]);
    drawing->diagonal = hypot(hypot(scene->high[0] - scene->low[0], scene->high[1] - scene->low[1]),
                              scene->high[2] - scene->low[2]);
    if (!(drawing->diagonal > 0.0))
        drawing->diagonal = 1.0;
    for (int i = 0; i < scene->object_count; i++)
        scene_extent_find(scene, &scene->objects[i], &drawing->extent[i]);
    scene_hulls_find(scene, drawing->hull);
    res = weft_context_call(drawing->context, make_objects, drawing);
    if (res == WEFT_OK) {
        *out = drawing;
        return WEFT_OK;
    }
fail:
    scene_drawing_destroy(&drawing);
    return res;
}

void scene_drawing_destroy(scene_drawing **drawing)
{
    if (!*drawing)
        return;
    weft_context_call((*drawing)->context, end_objects, *drawing);
    scene_frame_end_lines(*drawing);
    free((*drawing)->extent);
    free((*drawing)->hull);
    free((*drawing)->model);
    free((*drawing)->caster);
    free((*drawing)->caster_object);
    free(*drawing);
    *drawing = NULL;
}

// ---- frames -------------------------------------------------------------------------------------

static void set_target(const scene_drawing *drawing, const struct weft_draw_target *target)
{
    const GladGLContext *gl = &drawing->gl;
    float background[4];
    scene_round(drawing->scene->background, background, 4);
    for (int i = 0; i < 3 && drawing->frame.clamped_share; i++)
        background[i] = 0.0f;
    gl->BindFramebuffer(GL_FRAMEBUFFER, target->framebuffer);
    gl->Viewport(0, 0, target->width, target->height);
    gl->ClearBufferfv(GL_COLOR, 0, background);
    gl->Enable(GL_DEPTH_TEST);
}

enum weft_result scene_drawing_draw(scene_drawing *drawing, const struct scene_frame *frame,
                                    const struct weft_draw_target *target)
{
    const enum weft_result res = scene_frame_prepare(drawing, frame);
    if (res != WEFT_OK)
        return res;
    set_target(drawing, target);
    return scene_frame_draw(drawing, &(struct weft_antialias_pass){
                                         .stage = WEFT_STAGE_COLOUR,
                                         .framebuffer = target->framebuffer,
                                         .width = target->width,
                                         .height = target->height,
                                         .part = {0, 0, target->width, target->height},
                                         .place = {[0] = 1.0, [5] = 1.0, [10] = 1.0, [15] = 1.0},
                                         .head = scene_surface_head,
                                     });
}

enum weft_result scene_drawing_prepare(scene_drawing *drawing, const struct scene_frame *frame)
{
    const enum weft_result res = scene_frame_prepare(drawing, frame);
    return res == WEFT_OK ? scene_frame_prepare_lines(drawing) : res;
}

enum weft_result scene_drawing_pass(void *drawing, const struct weft_antialias_pass *pass)
{
    return scene_frame_draw(drawing, pass);
}

void scene_drawing_get_shadow(const scene_drawing *drawing, struct scene_shadow_info *out)
{
    const struct scene_shadows *shadows = &drawing->shadows;
    *out = (struct scene_shadow_info){
        .faces = shadows->faces,
        .size = shadows->size,
        .bias = drawing->bias,
        .bytes = 4 * (uint64_t)shadows->size * (uint64_t)shadows->size * (uint64_t)shadows->layers,
    };
}
