// SPDX-License-Identifier: BSD-3-Clause
#include "tools/render/frame.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/common/log.h"
#include "tools/scene/vector.h"

enum weft_result scene_frame_check(const scene_drawing *drawing, const char *what)
{
    const GLenum error = drawing->gl.GetError();
    if (error == GL_NO_ERROR)
        return WEFT_OK;
    log_error(drawing->log, "OpenGL: error 0x%04x while %s", error, what);
    return error == GL_OUT_OF_MEMORY ? WEFT_ERR_MEMORY : WEFT_ERR_GL;
}

// A frame that is drawn by one program.
struct pass {
    scene_drawing *drawing;
    enum weft_antialias_stage stage;
    const struct scene_surface *surface; // the program
    const struct scene_parts *parts;     // what is drawn; NULL: all
};

static void set_lights(const struct pass *pass)
{
    const GladGLContext *gl = &pass->drawing->gl;
    const GLint *at = pass->surface->at;
    float position[SCENE_MAX_LIGHTS][3], normal[SCENE_MAX_LIGHTS][3];
    float intensity[SCENE_MAX_LIGHTS][3], most[SCENE_MAX_LIGHTS];
    const int count = pass->drawing->frame.light_count;
    const double unit = pass->drawing->diagonal;
    for (int i = 0; i < count; i++) {
        const struct scene_point_light *light = &pass->drawing->frame.light[i];
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
    gl->Uniform3fv(at[SCENE_EMISSION], 1,
                   pass->drawing->frame.clamped_share ? none : material->emission);
    gl->Uniform1f(at[SCENE_CHECKS],
                  material->pattern == SCENE_CHECKER ? material->frequency : 0.0f);
    gl->Uniform1i(at[SCENE_UNLIT], material->unlit);
    if (material->single_sided)
        gl->Enable(GL_CULL_FACE);
    else
        gl->Disable(GL_CULL_FACE);
}

static void draw_range(const struct pass *pass, size_t first, size_t end)
{
    const GLenum mode = pass->stage == WEFT_STAGE_POINTS ? GL_POINTS : GL_LINES;
    if (end > first)
        pass->drawing->gl.DrawElements(mode, (GLsizei)(2 * (end - first)), GL_UNSIGNED_INT,
                                       (const void *)(first * sizeof(struct scene_line)));
}

// The lines of an object or, in the stage of points, their ends.
static void draw_lines(const struct pass *pass, int object)
{
    const scene_drawing *drawing = pass->drawing;
    const size_t *first = drawing->silhouette_first;
    const size_t lines = drawing->edges.line_first[drawing->scene->object_count];
    if (pass->parts) {
        draw_range(pass, pass->parts->line_first[object], pass->parts->line_first[object + 1]);
        return;
    }
    draw_range(pass, drawing->edges.line_first[object], drawing->edges.line_first[object + 1]);
    draw_range(pass, lines + first[object], lines + first[object + 1]);
}

static bool draws_triangles(const struct pass *pass)
{
    return pass->drawing->by_triangle || pass->stage <= WEFT_STAGE_COLOUR;
}

// Triangles of an object, of those that are drawn: the first one, and how many.
static size_t find_triangles(const struct pass *pass, int object, size_t *count)
{
    const struct scene_object *o = &pass->drawing->scene->objects[object];
    *count = o->index_count / 3;
    if (!pass->parts || !draws_triangles(pass))
        return o->first_index / 3;
    *count = pass->parts->first[object + 1] - pass->parts->first[object];
    return pass->parts->first[object];
}

static void draw_object(const struct pass *pass, int object, const double clip[16])
{
    const GladGLContext *gl = &pass->drawing->gl;
    const GLint *at = pass->surface->at;
    size_t count;
    const size_t first = find_triangles(pass, object, &count);
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
    gl->Uniform1i(at[SCENE_FIRST_TRIANGLE], (GLint)first);
    if (draws_triangles(pass))
        gl->DrawElements(GL_TRIANGLES, (GLsizei)(3 * count), GL_UNSIGNED_INT,
                         (const void *)(3 * first * sizeof(uint32_t)));
    else
        draw_lines(pass, object);
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

static void set_program(const struct pass *pass)
{
    const scene_drawing *drawing = pass->drawing;
    const GladGLContext *gl = &drawing->gl;
    const struct scene_surface *surface = pass->surface;
    const struct scene_parts *parts = draws_triangles(pass) ? pass->parts : NULL;
    const bool dark = drawing->frame.without_ambient || drawing->frame.clamped_share;
    float ambient[3];
    for (int i = 0; i < 3; i++)
        ambient[i] = dark ? 0.0f : (float)drawing->scene->ambient[i];
    gl->UseProgram(surface->program);
    gl->ActiveTexture(GL_TEXTURE0);
    gl->BindTexture(GL_TEXTURE_BUFFER, parts ? parts->texture[0] : drawing->buffers.plane_texture);
    gl->ActiveTexture(GL_TEXTURE2);
    gl->BindTexture(GL_TEXTURE_BUFFER,
                    parts ? parts->texture[1] : drawing->buffers.surface_texture);
    gl->Uniform1i(surface->at[SCENE_PLANES], 0);
    gl->Uniform1i(surface->at[SCENE_SURFACES], 2);
    gl->Uniform3fv(surface->at[SCENE_AMBIENT], 1, ambient);
    gl->Uniform1i(surface->at[SCENE_ONLY_CLAMPED], drawing->frame.clamped_share);
    set_lights(pass);
    scene_shadows_use(gl, &drawing->shadows, surface->shadow_at, drawing->frame.light_count, 1,
                      drawing->middle, drawing->diagonal);
}

// ---- what is drawn ------------------------------------------------------------------------------

static void draw_shadows(scene_drawing *drawing)
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
    scene_shadows_draw(&drawing->gl, &drawing->shadows, &casting, drawing->frame.light,
                       drawing->frame.light_count);
}

// The point that a rotation and a move take to the origin.
static void find_eye(const double view[16], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = -scene_dot(&view[4 * i], &view[12]);
}

enum weft_result scene_frame_prepare(scene_drawing *drawing, const struct scene_frame *frame)
{
    struct weft_camera camera;
    struct weft_camera_matrices matrices;
    scene_camera_at(drawing->scene, frame->time, &camera);
    const enum weft_result res =
        weft_camera_compute(drawing->log, &camera, &frame->camera, &matrices);
    if (res != WEFT_OK)
        return res;
    scene_parts_forget(drawing);
    drawing->frame = *frame;
    memcpy(drawing->camera, matrices.clip, sizeof drawing->camera);
    find_eye(matrices.view, drawing->eye);
    for (int i = 0; i < drawing->scene->object_count; i++)
        scene_path_at(&drawing->scene->objects[i].path, frame->time, drawing->model[i]);
    drawing->gl.BindVertexArray(drawing->buffers.vertex_array);
    draw_shadows(drawing);
    return scene_frame_check(drawing, "shadows were drawn");
}

// ---- lines --------------------------------------------------------------------------------------

// Numbers of surfaces that are single triangles.
static enum weft_result number_triangles(scene_drawing *drawing)
{
    const size_t count = drawing->scene->index_count / 3;
    uint32_t *surface = calloc(count + 1, sizeof *surface);
    if (!surface)
        return WEFT_ERR_MEMORY;
    for (size_t i = 0; i < count; i++)
        surface[i] = (uint32_t)i + 1;
    scene_buffers_add_edges(&drawing->gl, drawing->scene, surface, NULL, &drawing->buffers);
    free(surface);
    return WEFT_OK;
}

static enum weft_result make_edges(scene_drawing *drawing)
{
    const struct scene *scene = drawing->scene;
    const size_t objects = (size_t)scene->object_count;
    if (drawing->by_triangle)
        return number_triangles(drawing);
    const enum weft_result res = scene_edges_find(scene, &drawing->edges);
    if (res != WEFT_OK)
        return res;
    drawing->front = calloc(scene->index_count / 3 + 1, sizeof *drawing->front);
    drawing->silhouette =
        calloc(drawing->edges.fold_first[objects] + 1, sizeof *drawing->silhouette);
    drawing->silhouette_first = calloc(objects + 1, sizeof *drawing->silhouette_first);
    if (!drawing->front || !drawing->silhouette || !drawing->silhouette_first) {
        scene_frame_end_lines(drawing);
        return WEFT_ERR_MEMORY;
    }
    scene_buffers_add_edges(&drawing->gl, scene, drawing->edges.surface, &drawing->edges,
                            &drawing->buffers);
    return WEFT_OK;
}

void scene_frame_end_lines(scene_drawing *drawing)
{
    scene_edges_clear(&drawing->edges);
    free(drawing->front);
    free(drawing->silhouette);
    free(drawing->silhouette_first);
    drawing->front = NULL;
    drawing->silhouette = NULL;
    drawing->silhouette_first = NULL;
}

// The eye, where an object is modelled: its matrix moves, turns and scales.
static void find_model_eye(const double model[16], const double eye[3], double out[3])
{
    double way[3];
    for (int i = 0; i < 3; i++)
        way[i] = eye[i] - model[12 + i];
    for (int i = 0; i < 3; i++)
        out[i] = scene_dot(&model[4 * i], way) / scene_dot(&model[4 * i], &model[4 * i]);
}

static void find_silhouettes(scene_drawing *drawing)
{
    size_t count = 0;
    for (int i = 0; i < drawing->scene->object_count; i++) {
        double eye[3];
        find_model_eye(drawing->model[i], drawing->eye, eye);
        count += scene_edges_silhouette(drawing->scene, &drawing->edges, i, eye, drawing->front,
                                        drawing->silhouette + count);
        drawing->silhouette_first[i + 1] = count;
    }
}

enum weft_result scene_frame_prepare_lines(scene_drawing *drawing)
{
    const GladGLContext *gl = &drawing->gl;
    const enum weft_result res = drawing->buffers.surface_texture ? WEFT_OK : make_edges(drawing);
    if (res != WEFT_OK) {
        log_error(drawing->log, "out of memory for the edges of a scene");
        return res;
    }
    if (!drawing->by_triangle) {
        const size_t objects = (size_t)drawing->scene->object_count,
                     bytes = sizeof(struct scene_line);
        find_silhouettes(drawing);
        gl->BindVertexArray(drawing->buffers.line_array);
        gl->BufferSubData(
            GL_ELEMENT_ARRAY_BUFFER, (GLintptr)(drawing->edges.line_first[objects] * bytes),
            (GLsizeiptr)(drawing->silhouette_first[objects] * bytes), drawing->silhouette);
    }
    return scene_frame_check(drawing, "lines of a scene were uploaded");
}

// ---- drawing ------------------------------------------------------------------------------------

enum weft_result scene_frame_draw(scene_drawing *drawing, const struct weft_antialias_pass *drawn)
{
    struct pass pass = {.drawing = drawing, .stage = drawn->stage};
    const enum weft_result res = scene_surfaces_find(
        &drawing->gl, drawing->log, &drawing->surfaces, pass.stage, drawn->head,
        drawing->shadows.view, drawing->frame.light, drawing->frame.light_count, &pass.surface);
    if (res != WEFT_OK)
        return res;
    double placed[16];
    scene_multiply(drawn->place, drawing->camera, placed);
    const bool triangles = draws_triangles(&pass);
    drawing->gl.BindVertexArray(triangles ? drawing->buffers.vertex_array
                                          : drawing->buffers.line_array);
    pass.parts = scene_parts_list(drawing, drawn);
    set_program(&pass);
    draw_objects(&pass, placed);
    if (pass.parts)
        drawing->gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER,
                               triangles ? drawing->buffers.indices : drawing->buffers.lines);
    return scene_frame_check(drawing, "a scene was drawn");
}
