// SPDX-License-Identifier: BSD-3-Clause
// Scenes on OpenGL: what is uploaded once, and frames drawn from it.
#include <math.h>
#include <stdlib.h>

#include "tools/common/log.h"
#include "tools/render/drawing.h"
#include "tools/render/matrix.h"
#include "tools/render/surface.h"
#include "tools/render/triangles.h"
#include "tools/scene/vector.h"

struct scene_drawing {
    const struct scene *scene;
    weft_context *context;
    const struct weft_log *log;
    int shadow_size;
    GladGLContext gl;
    double middle[3]; // of the scene's box
    double
        diagonal; // likewise; 1 where it is 0. Shaders' lengths are in diagonals, from the middle
    struct scene_extent *extent; // of each object, as modelled
    struct scene_hull *hull;     // of each object
    double (*model)[16];         // where each object lies in the frame that is drawn
    struct scene_caster *caster; // room for as many, and which object each is
    int *caster_object;
    struct scene_shadows shadows;
    double bias; // scene_shadows_get_bias
    struct scene_surfaces surfaces;
    struct scene_buffers buffers;
};

// ---- making and ending --------------------------------------------------------------------------

// WEFT_ERR_GL after a line where an error is pending.
static enum weft_result check(const scene_drawing *drawing, const char *what)
{
    const GLenum error = drawing->gl.GetError();
    if (error == GL_NO_ERROR)
        return WEFT_OK;
    log_error(drawing->log, "OpenGL: error 0x%04x while %s", error, what);
    return error == GL_OUT_OF_MEMORY ? WEFT_ERR_MEMORY : WEFT_ERR_GL;
}

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
    return res == WEFT_OK ? check(drawing, "a scene was uploaded") : res;
}

static enum weft_result end_objects(void *priv)
{
    scene_drawing *drawing = priv;
    const GladGLContext *gl = &drawing->gl;
    if (!gl->DeleteProgram)
        return WEFT_OK;
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
    free((*drawing)->extent);
    free((*drawing)->hull);
    free((*drawing)->model);
    free((*drawing)->caster);
    free((*drawing)->caster_object);
    free(*drawing);
    *drawing = NULL;
}

// ---- a frame ------------------------------------------------------------------------------------

// What draws one frame.
struct pass {
    scene_drawing *drawing;
    const struct scene_frame *frame;
    const struct scene_surface *surface; // the program
};

static void set_lights(const struct pass *pass)
{
    const GladGLContext *gl = &pass->drawing->gl;
    const GLint *at = pass->surface->at;
    float position[SCENE_MAX_LIGHTS][3], normal[SCENE_MAX_LIGHTS][3];
    float intensity[SCENE_MAX_LIGHTS][3], most[SCENE_MAX_LIGHTS];
    const int count = pass->frame->light_count;
    const double unit = pass->drawing->diagonal;
    for (int i = 0; i < count; i++) {
        const struct scene_point_light *light = &pass->frame->light[i];
        const bool falls = light->falloff == SCENE_FALLOFF_RADIANCE; // with the distance
        for (int axis = 0; axis < 3; axis++) {
            position[i][axis] =
                (float)((light->position[axis] - pass->drawing->middle[axis]) / unit);
            intensity[i][axis] = (float)(light->intensity[axis] / (falls ? unit * unit : 1.0));
        }
        scene_round(light->normal, normal[i], 3);
        most[i] = (float)(light->most * unit * unit);
    }
    gl->Uniform3fv(at[SCENE_LIGHT_POSITION], count, &position[0][0]);
    gl->Uniform3fv(at[SCENE_LIGHT_NORMAL], count, &normal[0][0]);
    gl->Uniform3fv(at[SCENE_LIGHT_INTENSITY], count, &intensity[0][0]);
    gl->Uniform1fv(at[SCENE_LIGHT_MOST], count, most);
}

static void set_material(const struct pass *pass, const struct scene_material *material)
{
    const GladGLContext *gl = &pass->drawing->gl;
    const GLint *at = pass->surface->at;
    static const float none[3] = {0.0f, 0.0f, 0.0f};
    gl->Uniform3fv(at[SCENE_REFLECTANCE], 1, material->reflectance);
    gl->Uniform3fv(at[SCENE_EMISSION], 1, pass->frame->clamped_share ? none : material->emission);
    gl->Uniform1f(at[SCENE_CHECKS],
                  material->pattern == SCENE_CHECKER ? material->frequency : 0.0f);
    gl->Uniform1i(at[SCENE_UNLIT], material->unlit);
    if (material->single_sided)
        gl->Enable(GL_CULL_FACE);
    else
        gl->Disable(GL_CULL_FACE);
}

static void draw_object(const struct pass *pass, int object, const double clip[16])
{
    const GladGLContext *gl = &pass->drawing->gl;
    const GLint *at = pass->surface->at;
    const struct scene_object *o = &pass->drawing->scene->objects[object];
    const double *model = pass->drawing->model[object];
    const double scale = hypot(hypot(model[0], model[1]), model[2]), unit = pass->drawing->diagonal;
    float rounded[16], placed[16] = {[15] = 1.0f}, turned[9];
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            placed[4 * i + k] = (float)(model[4 * i + k] / unit);
            turned[3 * i + k] = (float)(model[4 * i + k] / scale);
        }
    for (int i = 0; i < 3; i++)
        placed[12 + i] = (float)((model[12 + i] - pass->drawing->middle[i]) / unit);
    scene_round(clip, rounded, 16);
    gl->UniformMatrix4fv(at[SCENE_CLIP], 1, GL_FALSE, rounded);
    gl->UniformMatrix4fv(at[SCENE_MODEL], 1, GL_FALSE, placed);
    gl->UniformMatrix3fv(at[SCENE_TURN], 1, GL_FALSE, turned);
    gl->Uniform1i(at[SCENE_FIRST_TRIANGLE], (GLint)(o->first_index / 3));
    gl->DrawElements(GL_TRIANGLES, (GLsizei)o->index_count, GL_UNSIGNED_INT,
                     (const void *)(o->first_index * sizeof(uint32_t)));
}

static void draw_objects(const struct pass *pass, const double camera[16])
{
    const scene_drawing *drawing = pass->drawing;
    int material = -1; // that is set
    for (int i = 0; i < drawing->scene->object_count; i++) {
        const struct scene_object *object = &drawing->scene->objects[i];
        double clip[16];
        scene_multiply(camera, drawing->model[i], clip);
        if (object->index_count == 0 || !scene_extent_seen(&drawing->extent[i], clip))
            continue;
        if (object->material != material)
            set_material(pass, &drawing->scene->materials[object->material]);
        material = object->material;
        draw_object(pass, i, clip);
    }
}

static void set_target(const struct pass *pass, const struct weft_draw_target *target)
{
    const GladGLContext *gl = &pass->drawing->gl;
    float background[4];
    scene_round(pass->drawing->scene->background, background, 4);
    for (int i = 0; i < 3 && pass->frame->clamped_share; i++)
        background[i] = 0.0f;
    gl->BindFramebuffer(GL_FRAMEBUFFER, target->framebuffer);
    gl->Viewport(0, 0, target->width, target->height);
    gl->ClearBufferfv(GL_COLOR, 0, background);
    gl->Enable(GL_DEPTH_TEST);
}

static void set_program(const struct pass *pass)
{
    const scene_drawing *drawing = pass->drawing;
    const GladGLContext *gl = &drawing->gl;
    const struct scene_surface *surface = pass->surface;
    const bool dark = pass->frame->without_ambient || pass->frame->clamped_share;
    float ambient[3];
    for (int i = 0; i < 3; i++)
        ambient[i] = dark ? 0.0f : (float)drawing->scene->ambient[i];
    gl->UseProgram(surface->program);
    gl->ActiveTexture(GL_TEXTURE0);
    gl->BindTexture(GL_TEXTURE_BUFFER, drawing->buffers.plane_texture);
    gl->Uniform1i(surface->at[SCENE_PLANES], 0);
    gl->Uniform3fv(surface->at[SCENE_AMBIENT], 1, ambient);
    gl->Uniform1i(surface->at[SCENE_ONLY_CLAMPED], pass->frame->clamped_share);
    set_lights(pass);
    scene_shadows_use(gl, &drawing->shadows, surface->shadow_at, pass->frame->light_count, 1,
                      drawing->middle, drawing->diagonal);
}

static void draw_shadows(scene_drawing *drawing, const struct scene_frame *frame)
{
    const struct scene_shadow_casting casting = {
        .scene = drawing->scene,
        .extent = drawing->extent,
        .hull = drawing->hull,
        .model = (const double(*)[16])drawing->model,
        .caster = drawing->caster,
        .object = drawing->caster_object,
        .diagonal = drawing->diagonal,
    };
    scene_shadows_draw(&drawing->gl, &drawing->shadows, &casting, frame->light, frame->light_count);
}

enum weft_result scene_drawing_draw(scene_drawing *drawing, const struct scene_frame *frame,
                                    const struct weft_draw_target *target)
{
    struct weft_camera camera;
    struct weft_camera_matrices matrices;
    scene_camera_at(drawing->scene, frame->time, &camera);
    enum weft_result res = weft_camera_compute(drawing->log, &camera, &frame->camera, &matrices);
    if (res != WEFT_OK)
        return res;
    for (int i = 0; i < drawing->scene->object_count; i++)
        scene_path_at(&drawing->scene->objects[i].path, frame->time, drawing->model[i]);
    drawing->gl.BindVertexArray(drawing->buffers.vertex_array);
    draw_shadows(drawing, frame);
    struct pass pass = {.drawing = drawing, .frame = frame};
    res = scene_surfaces_find(&drawing->gl, drawing->log, &drawing->surfaces, drawing->shadows.view,
                              frame->light, frame->light_count, &pass.surface);
    if (res != WEFT_OK)
        return res;
    set_target(&pass, target);
    set_program(&pass);
    draw_objects(&pass, matrices.clip);
    return check(drawing, "a scene was drawn");
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
