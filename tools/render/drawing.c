// SPDX-License-Identifier: BSD-3-Clause
// Scenes on OpenGL: what is uploaded once, and frames drawn from it.
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include "tools/common/log.h"
#include "tools/scene/build.h"
#include "tools/scene/drawing.h"
#include "tools/render/matrix.h"
#include "tools/render/program.h"
#include "tools/render/shadow.h"

// Uniforms of the program of surfaces, and their names.
enum uniform {
    CLIP,
    MODEL,
    PLANES,
    FIRST_TRIANGLE,
    REFLECTANCE,
    EMISSION,
    AMBIENT,
    CHECKS,
    UNLIT,
    ONLY_CLAMPED,
    LIGHT_COUNT,
    LIGHT_POSITION,
    LIGHT_NORMAL,
    LIGHT_INTENSITY,
    LIGHT_HAS_NORMAL,
    LIGHT_FALLOFF,
    LIGHT_MOST,
    UNIFORM_COUNT
};
static const char *const uniform_name[UNIFORM_COUNT] = {
    "clip",          "model",          "planes",       "first_triangle",  "reflectance",
    "emission",      "ambient",        "checks",       "unlit",           "only_clamped",
    "light_count",   "light_position", "light_normal", "light_intensity", "light_has_normal",
    "light_falloff", "light_most",
};

struct scene_drawing {
    const struct scene *scene;
    weft_context *context;
    const struct weft_log *log;
    int shadow_size;
    GladGLContext gl;
    double middle[3];            // of the scene's box: shaders' positions are relative to it
    double diagonal;             // likewise
    struct scene_extent *extent; // of each object, as modelled
    struct scene_hull *hull;     // of each object
    double (*model)[16];         // where each object lies in the frame that is drawn
    struct scene_caster *caster; // room for as many, and which object each is
    int *caster_object;
    struct scene_shadows shadows;
    GLuint vertex_array, vertices, indices, planes, plane_texture;
    GLuint program;
    double bias; // scene_shadows_get_bias
    GLint uniform[UNIFORM_COUNT], shadow_uniform[SCENE_SHADOW_UNIFORM_COUNT];
};

// ---- what is uploaded ---------------------------------------------------------------------------

static void find_extent(const struct scene *scene, const struct scene_object *object,
                        struct scene_extent *out)
{
    for (int axis = 0; axis < 3; axis++) {
        out->low[axis] = INFINITY;
        out->high[axis] = -INFINITY;
    }
    for (uint32_t i = 0; i < object->index_count; i++) {
        const float *p = scene->vertices[scene->indices[object->first_index + i]].position;
        for (int axis = 0; axis < 3; axis++) {
            out->low[axis] = fmin(out->low[axis], p[axis]);
            out->high[axis] = fmax(out->high[axis], p[axis]);
        }
    }
}

// A triangle's normal of length 1, as modelled; then how far the neighbours of a smooth surface
// tilt against it, as a tangent: twice the largest angle to the normal of a corner. None of a
// triangle without area.
static void find_plane(const struct scene *scene, size_t first, float out[4])
{
    const struct weft_mesh_vertex *corner[3];
    double side[2][3], normal[3], least = 1.0;
    for (int i = 0; i < 3; i++)
        corner[i] = &scene->vertices[scene->indices[first + (size_t)i]];
    for (int i = 0; i < 3; i++) {
        side[0][i] = (double)corner[1]->position[i] - corner[0]->position[i];
        side[1][i] = (double)corner[2]->position[i] - corner[0]->position[i];
    }
    scene_cross(side[0], side[1], normal);
    const bool has_area = scene_normalise(normal) > 0.0;
    for (int i = 0; i < 3; i++) {
        const float *n = corner[i]->normal;
        const double cosine = fabs(normal[0] * n[0] + normal[1] * n[1] + normal[2] * n[2]);
        least = fmin(least, cosine);
        out[i] = (float)normal[i];
    }
    const double angle = 2.0 * acos(least);
    out[3] = has_area && angle > 1e-3 ? (float)fmin(tan(fmin(angle, 1.0)), 1.0) : 0.0f;
}

static void upload_planes(scene_drawing *drawing, const float (*plane)[4])
{
    const GladGLContext *gl = &drawing->gl;
    const GLsizeiptr bytes = (GLsizeiptr)(drawing->scene->index_count / 3 * sizeof *plane);
    gl->GenBuffers(1, &drawing->planes);
    gl->BindBuffer(GL_TEXTURE_BUFFER, drawing->planes);
    gl->BufferData(GL_TEXTURE_BUFFER, bytes, plane, GL_STATIC_DRAW);
    gl->GenTextures(1, &drawing->plane_texture);
    gl->BindTexture(GL_TEXTURE_BUFFER, drawing->plane_texture);
    gl->TexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, drawing->planes);
}

static enum weft_result make_planes(scene_drawing *drawing)
{
    const struct scene *scene = drawing->scene;
    const size_t count = scene->index_count / 3;
    const int64_t most = weft_context_get_info(drawing->context)->max_buffer_texels;
    if ((uint64_t)count > (uint64_t)most) {
        log_error(drawing->log,
                  "%zu triangles are more than the %lld texels of a buffer that OpenGL has here",
                  count, (long long)most);
        return WEFT_ERR_LIMIT;
    }
    float(*plane)[4] = malloc((count + 1) * sizeof *plane);
    if (!plane)
        return WEFT_ERR_MEMORY;
    for (size_t i = 0; i < count; i++)
        find_plane(scene, 3 * i, plane[i]);
    upload_planes(drawing, (const float(*)[4])plane);
    free(plane);
    return WEFT_OK;
}

static void upload_triangles(scene_drawing *drawing)
{
    static const struct {
        GLint count;
        size_t offset;
    } part[] = {
        {3, offsetof(struct weft_mesh_vertex, position)},
        {3, offsetof(struct weft_mesh_vertex, normal)},
        {2, offsetof(struct weft_mesh_vertex, uv)},
        {3, offsetof(struct weft_mesh_vertex, colour)},
    };
    const GladGLContext *gl = &drawing->gl;
    const struct scene *scene = drawing->scene;
    gl->GenVertexArrays(1, &drawing->vertex_array);
    gl->BindVertexArray(drawing->vertex_array);
    gl->GenBuffers(1, &drawing->vertices);
    gl->BindBuffer(GL_ARRAY_BUFFER, drawing->vertices);
    gl->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(scene->vertex_count * sizeof *scene->vertices),
                   scene->vertices, GL_STATIC_DRAW);
    gl->GenBuffers(1, &drawing->indices);
    gl->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, drawing->indices);
    gl->BufferData(GL_ELEMENT_ARRAY_BUFFER,
                   (GLsizeiptr)(scene->index_count * sizeof *scene->indices), scene->indices,
                   GL_STATIC_DRAW);
    for (GLuint i = 0; i < 4; i++) {
        gl->VertexAttribPointer(i, part[i].count, GL_FLOAT, GL_FALSE,
                                sizeof(struct weft_mesh_vertex), (const void *)part[i].offset);
        gl->EnableVertexAttribArray(i);
    }
}

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

static enum weft_result make_program(scene_drawing *drawing)
{
    char defines[300];
    snprintf(defines, sizeof defines,
             "#define LIGHTS %d\n#define FALLOFF_RADIANCE %d\n#define FALLOFF_COSINE %d\n"
             "#define KIND_NONE %d\n#define KIND_FITTED %d\n#define KIND_CUBE %d\n",
             SCENE_MAX_LIGHTS, SCENE_FALLOFF_RADIANCE, SCENE_FALLOFF_COSINE, SCENE_SHADOW_NONE,
             SCENE_SHADOW_FITTED, SCENE_SHADOW_CUBE);
    const enum weft_result res =
        scene_program_link(&drawing->gl, drawing->log, defines, tools_shader_scene_vertex,
                           tools_shader_scene_surface, &drawing->program);
    for (int i = 0; i < UNIFORM_COUNT && res == WEFT_OK; i++)
        drawing->uniform[i] = drawing->gl.GetUniformLocation(drawing->program, uniform_name[i]);
    if (res == WEFT_OK)
        scene_shadows_find_uniforms(&drawing->gl, drawing->program, drawing->shadow_uniform);
    return res;
}

static enum weft_result make_objects(void *priv)
{
    scene_drawing *drawing = priv;
    if (!scene_gl_load(&drawing->gl, drawing->context))
        return WEFT_ERR_GL;
    enum weft_result res = make_program(drawing);
    if (res == WEFT_OK)
        res = make_planes(drawing);
    if (res == WEFT_OK)
        res =
            scene_shadows_make(&drawing->gl, drawing->log, drawing->shadow_size, &drawing->shadows);
    if (res == WEFT_OK) {
        drawing->bias = scene_shadows_get_bias(&drawing->gl);
        upload_triangles(drawing);
        res = check(drawing, "a scene was uploaded");
    }
    return res;
}

static enum weft_result end_objects(void *priv)
{
    scene_drawing *drawing = priv;
    const GladGLContext *gl = &drawing->gl;
    if (!gl->DeleteProgram)
        return WEFT_OK;
    scene_shadows_end(gl, &drawing->shadows);
    gl->DeleteProgram(drawing->program);
    gl->DeleteVertexArrays(1, &drawing->vertex_array);
    gl->DeleteBuffers(3, (GLuint[]){drawing->vertices, drawing->indices, drawing->planes});
    gl->DeleteTextures(1, &drawing->plane_texture);
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
    for (int i = 0; i < scene->object_count; i++) {
        find_extent(scene, &scene->objects[i], &drawing->extent[i]);
        scene_hull_find(scene, i, &drawing->hull[i]);
    }
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

static void set_lights(const scene_drawing *drawing, const struct scene_frame *frame)
{
    const GladGLContext *gl = &drawing->gl;
    const GLint *at = drawing->uniform;
    float position[SCENE_MAX_LIGHTS][3], normal[SCENE_MAX_LIGHTS][3];
    float intensity[SCENE_MAX_LIGHTS][3], most[SCENE_MAX_LIGHTS];
    GLint has_normal[SCENE_MAX_LIGHTS], falloff[SCENE_MAX_LIGHTS];
    const int count = frame->light_count;
    for (int i = 0; i < count; i++) {
        const struct scene_point_light *light = &frame->light[i];
        for (int axis = 0; axis < 3; axis++)
            position[i][axis] = (float)(light->position[axis] - drawing->middle[axis]);
        scene_round(light->normal, normal[i], 3);
        scene_round(light->intensity, intensity[i], 3);
        has_normal[i] =
            light->normal[0] != 0.0 || light->normal[1] != 0.0 || light->normal[2] != 0.0;
        falloff[i] = (GLint)light->falloff;
        most[i] = (float)light->most;
    }
    gl->Uniform1i(at[LIGHT_COUNT], count);
    gl->Uniform3fv(at[LIGHT_POSITION], count, &position[0][0]);
    gl->Uniform3fv(at[LIGHT_NORMAL], count, &normal[0][0]);
    gl->Uniform3fv(at[LIGHT_INTENSITY], count, &intensity[0][0]);
    gl->Uniform1iv(at[LIGHT_HAS_NORMAL], count, has_normal);
    gl->Uniform1iv(at[LIGHT_FALLOFF], count, falloff);
    gl->Uniform1fv(at[LIGHT_MOST], count, most);
}

static void set_material(const scene_drawing *drawing, const struct scene_material *material,
                         const struct scene_frame *frame)
{
    const GladGLContext *gl = &drawing->gl;
    const GLint *at = drawing->uniform;
    static const float none[3] = {0.0f, 0.0f, 0.0f};
    gl->Uniform3fv(at[REFLECTANCE], 1, material->reflectance);
    gl->Uniform3fv(at[EMISSION], 1, frame->clamped_share ? none : material->emission);
    gl->Uniform1f(at[CHECKS], material->pattern == SCENE_CHECKER ? material->frequency : 0.0f);
    gl->Uniform1i(at[UNLIT], material->unlit);
    if (material->single_sided)
        gl->Enable(GL_CULL_FACE);
    else
        gl->Disable(GL_CULL_FACE);
}

static void draw_object(const scene_drawing *drawing, int object, const double clip[16])
{
    const GladGLContext *gl = &drawing->gl;
    const struct scene_object *o = &drawing->scene->objects[object];
    double model[16];
    float rounded[16];
    scene_round(clip, rounded, 16);
    gl->UniformMatrix4fv(drawing->uniform[CLIP], 1, GL_FALSE, rounded);
    for (int i = 0; i < 16; i++)
        model[i] = drawing->model[object][i];
    for (int i = 0; i < 3; i++)
        model[12 + i] -= drawing->middle[i];
    scene_round(model, rounded, 16);
    gl->UniformMatrix4fv(drawing->uniform[MODEL], 1, GL_FALSE, rounded);
    gl->Uniform1i(drawing->uniform[FIRST_TRIANGLE], (GLint)(o->first_index / 3));
    gl->DrawElements(GL_TRIANGLES, (GLsizei)o->index_count, GL_UNSIGNED_INT,
                     (const void *)(o->first_index * sizeof(uint32_t)));
}

static void draw_objects(scene_drawing *drawing, const struct scene_frame *frame,
                         const double camera[16])
{
    int material = -1; // that is set
    for (int i = 0; i < drawing->scene->object_count; i++) {
        const struct scene_object *object = &drawing->scene->objects[i];
        double clip[16];
        scene_multiply(camera, drawing->model[i], clip);
        if (!scene_extent_seen(&drawing->extent[i], clip))
            continue;
        if (object->material != material)
            set_material(drawing, &drawing->scene->materials[object->material], frame);
        material = object->material;
        draw_object(drawing, i, clip);
    }
}

static void set_frame(const scene_drawing *drawing, const struct scene_frame *frame,
                      const struct weft_draw_target *target)
{
    const GladGLContext *gl = &drawing->gl;
    const bool ambient = !frame->without_ambient && !frame->clamped_share;
    float background[4] = {0}, light[3] = {0};
    scene_round(drawing->scene->background, background, 4);
    scene_round(drawing->scene->ambient, light, 3);
    for (int i = 0; i < 3; i++) {
        background[i] = frame->clamped_share ? 0.0f : background[i];
        light[i] = ambient ? light[i] : 0.0f;
    }
    gl->BindFramebuffer(GL_FRAMEBUFFER, target->framebuffer);
    gl->Viewport(0, 0, target->width, target->height);
    gl->ClearBufferfv(GL_COLOR, 0, background);
    gl->Enable(GL_DEPTH_TEST);
    gl->UseProgram(drawing->program);
    gl->ActiveTexture(GL_TEXTURE0);
    gl->BindTexture(GL_TEXTURE_BUFFER, drawing->plane_texture);
    gl->Uniform1i(drawing->uniform[PLANES], 0);
    gl->Uniform3fv(drawing->uniform[AMBIENT], 1, light);
    gl->Uniform1i(drawing->uniform[ONLY_CLAMPED], frame->clamped_share);
    set_lights(drawing, frame);
    scene_shadows_use(gl, &drawing->shadows, drawing->shadow_uniform, frame->light_count, 1,
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
    const enum weft_result res =
        weft_camera_compute(drawing->log, &camera, &frame->camera, &matrices);
    if (res != WEFT_OK)
        return res;
    for (int i = 0; i < drawing->scene->object_count; i++)
        scene_path_at(&drawing->scene->objects[i].path, frame->time, drawing->model[i]);
    drawing->gl.BindVertexArray(drawing->vertex_array);
    draw_shadows(drawing, frame);
    set_frame(drawing, frame, target);
    draw_objects(drawing, frame, matrices.clip);
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
