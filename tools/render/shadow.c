// SPDX-License-Identifier: BSD-3-Clause
#include "tools/render/shadow.h"

#include <math.h>

#include "tools/common/log.h"
#include "tools/render/gl/matrix.h"
#include "tools/render/gl/program.h"
#include "tools/scene/vector.h"

// ---- layers -------------------------------------------------------------------------------------

static void end_layers(const GladGLContext *gl, struct scene_shadows *shadows)
{
    gl->DeleteFramebuffers(shadows->layers, shadows->framebuffer);
    gl->DeleteTextures(1, &shadows->texture);
    shadows->texture = 0;
    shadows->layers = 0;
}

static void make_layers(const GladGLContext *gl, struct scene_shadows *shadows, int layers)
{
    static const GLenum parameter[][2] = {
        {GL_TEXTURE_MIN_FILTER, GL_NEAREST},
        {GL_TEXTURE_MAG_FILTER, GL_NEAREST},
        {GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE},
        {GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE},
        {GL_TEXTURE_MAX_LEVEL, 0},
    };
    end_layers(gl, shadows);
    gl->GenTextures(1, &shadows->texture);
    gl->BindTexture(GL_TEXTURE_2D_ARRAY, shadows->texture);
    gl->TexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_DEPTH_COMPONENT32F, shadows->size, shadows->size,
                   layers, 0, GL_DEPTH_COMPONENT, GL_FLOAT, NULL);
    for (size_t i = 0; i < sizeof parameter / sizeof *parameter; i++)
        gl->TexParameteri(GL_TEXTURE_2D_ARRAY, parameter[i][0], (GLint)parameter[i][1]);
    gl->GenFramebuffers(layers, shadows->framebuffer);
    for (int i = 0; i < layers; i++) {
        gl->BindFramebuffer(GL_FRAMEBUFFER, shadows->framebuffer[i]);
        gl->FramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, shadows->texture, 0, i);
        gl->DrawBuffer(GL_NONE);
        gl->ReadBuffer(GL_NONE);
    }
    shadows->layers = layers;
}

static GLuint link_program(const GladGLContext *gl, const struct weft_log *log)
{
    const char *const vertex_text[] = {SCENE_VERSION, tools_shader_scene_depth_vertex};
    const char *const fragment_text[] = {SCENE_VERSION, tools_shader_scene_depth};
    const GLuint vertex = scene_shader_compile(gl, log, GL_VERTEX_SHADER, vertex_text, 2);
    const GLuint fragment =
        vertex ? scene_shader_compile(gl, log, GL_FRAGMENT_SHADER, fragment_text, 2) : 0;
    const GLuint program = fragment ? scene_program_link(gl, log, vertex, fragment) : 0;
    gl->DeleteShader(vertex); // 0 is left alone
    gl->DeleteShader(fragment);
    return program;
}

enum weft_result scene_shadows_make(const GladGLContext *gl, const struct weft_log *log, int size,
                                    struct scene_shadows *out)
{
    GLint largest = 0;
    gl->GetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
    if (size < SCENE_SHADOW_LEAST || size > largest) {
        log_error(log, "shadow maps of %d texels along a side: from %d to %d are to be had", size,
                  SCENE_SHADOW_LEAST, largest);
        return WEFT_ERR_LIMIT;
    }
    out->program = link_program(gl, log);
    if (!out->program)
        return WEFT_ERR_GL;
    out->clip = gl->GetUniformLocation(out->program, "clip");
    out->size = size;
    make_layers(gl, out, 1); // shaders are to find some
    return WEFT_OK;
}

void scene_shadows_end(const GladGLContext *gl, struct scene_shadows *shadows)
{
    end_layers(gl, shadows);
    gl->DeleteProgram(shadows->program);
    *shadows = (struct scene_shadows){.size = 0};
}

// ---- maps ---------------------------------------------------------------------------------------

// Lists what can cast shadows in the light, and returns how much there is.
static int list_casters(const struct scene_shadow_casting *casting, const double eye[3])
{
    int count = 0;
    for (int i = 0; i < casting->scene->object_count; i++)
        if (casting->scene->objects[i].index_count > 0 &&
            scene_hull_casts(casting->scene, &casting->hull[i], eye)) {
            casting->object[count] = i;
            casting->caster[count++] = (struct scene_caster){
                .extent = &casting->extent[i],
                .model = casting->model[i],
            };
        }
    return count;
}

static void draw_face(const GladGLContext *gl, const struct scene_shadows *shadows,
                      const struct scene_shadow_casting *casting, int casters,
                      const struct scene_shadow_face *face)
{
    const struct scene *scene = casting->scene;
    gl->FrontFace(face->mirrored ? GL_CW : GL_CCW);
    for (int i = 0; i < casters; i++) {
        const struct scene_object *object = &scene->objects[casting->object[i]];
        double clip[16];
        float rounded[16];
        scene_multiply(face->clip, casting->caster[i].model, clip);
        if (!scene_extent_seen(casting->caster[i].extent, clip))
            continue;
        scene_round(clip, rounded, 16);
        gl->UniformMatrix4fv(shadows->clip, 1, GL_FALSE, rounded);
        if (scene->materials[object->material].single_sided)
            gl->Enable(GL_CULL_FACE);
        else
            gl->Disable(GL_CULL_FACE);
        gl->DrawElements(GL_TRIANGLES, (GLsizei)object->index_count, GL_UNSIGNED_INT,
                         (const void *)(object->first_index * sizeof(uint32_t)));
    }
}

// Draws the faces of a light into layers from `first` on, which are cleared.
static void draw_faces(const GladGLContext *gl, const struct scene_shadows *shadows,
                       const struct scene_shadow_casting *casting, int casters, int first,
                       const struct scene_shadow_face *face, int count)
{
    const int size = shadows->size;
    for (int i = 0; i < count; i++) {
        const int height = face[i].half ? size / 2 : size;
        if (i == 0 || face[i].layer != face[i - 1].layer) {
            gl->BindFramebuffer(GL_FRAMEBUFFER, shadows->framebuffer[first + face[i].layer]);
            gl->Clear(GL_DEPTH_BUFFER_BIT);
        }
        gl->Viewport(0, face[i].half && !face[i].lower ? height : 0, size, height);
        draw_face(gl, shadows, casting, casters, &face[i]);
    }
}

static void begin_maps(const GladGLContext *gl, const struct scene_shadows *shadows)
{
    gl->Enable(GL_DEPTH_TEST);
    gl->Enable(GL_DEPTH_CLAMP);
    gl->ClearDepth(1.0);
    gl->UseProgram(shadows->program);
}

static void end_maps(const GladGLContext *gl)
{
    gl->Disable(GL_DEPTH_CLAMP);
    gl->Disable(GL_CULL_FACE);
    gl->FrontFace(GL_CCW);
}

void scene_shadows_draw(const GladGLContext *gl, struct scene_shadows *shadows,
                        const struct scene_shadow_casting *casting,
                        const struct scene_point_light *light, int count)
{
    struct scene_shadow_face face[SCENE_SHADOW_FACES];
    int layers = 0, more;
    shadows->faces = 0;
    for (int i = 0; i < count; i++) {
        double eye[3];
        scene_shadow_eye(&light[i], casting->diagonal, eye);
        const int casters = light[i].shadowed ? list_casters(casting, eye) : 0;
        scene_shadow_view_find(&light[i], casting->caster, casters, casting->diagonal,
                               shadows->size, &shadows->view[i]);
        shadows->first_layer[i] = layers;
        scene_shadow_view_faces(&shadows->view[i], face, &more);
        layers += more;
    }
    if (layers > shadows->layers)
        make_layers(gl, shadows, layers);
    begin_maps(gl, shadows);
    for (int i = 0; i < count; i++) {
        const int faces = scene_shadow_view_faces(&shadows->view[i], face, &more);
        const int casters = faces ? list_casters(casting, shadows->view[i].eye) : 0;
        draw_faces(gl, shadows, casting, casters, shadows->first_layer[i], face, faces);
        shadows->faces += faces;
    }
    end_maps(gl);
}

// ---- what looks them up -------------------------------------------------------------------------

void scene_shadows_find_uniforms(const GladGLContext *gl, GLuint program,
                                 GLint out[SCENE_SHADOW_UNIFORM_COUNT])
{
    static const char *const name[SCENE_SHADOW_UNIFORM_COUNT] = {
        "shadow_maps", "shadow_eye",   "shadow_frame", "shadow_window",
        "shadow_near", "shadow_layer", "shadow_lift",  "shadow_bias",
    };
    for (int i = 0; i < SCENE_SHADOW_UNIFORM_COUNT; i++)
        out[i] = gl->GetUniformLocation(program, name[i]);
}

double scene_shadows_get_bias(const GladGLContext *gl)
{
    GLint bits = 4; // the least that there can be
    gl->GetIntegerv(GL_SUBPIXEL_BITS, &bits);
    return ldexp(1.0, 1 - bits);
}

void scene_shadows_use(const GladGLContext *gl, const struct scene_shadows *shadows,
                       const GLint at[SCENE_SHADOW_UNIFORM_COUNT], int count, int unit,
                       const double middle[3], double diagonal)
{
    float eye[SCENE_MAX_LIGHTS][3], frame[SCENE_MAX_LIGHTS][9], window[SCENE_MAX_LIGHTS][4];
    float near_distance[SCENE_MAX_LIGHTS];
    for (int i = 0; i < count; i++) {
        const struct scene_shadow_view *view = &shadows->view[i];
        near_distance[i] = (float)(view->near_distance / diagonal);
        for (int k = 0; k < 3; k++) {
            eye[i][k] = (float)((view->eye[k] - middle[k]) / diagonal);
            scene_round(view->axis[k], &frame[i][3 * k], 3);
        }
        scene_round(view->low, window[i], 2);
        scene_round(view->extent, window[i] + 2, 2);
    }
    gl->ActiveTexture(GL_TEXTURE0 + (GLenum)unit);
    gl->BindTexture(GL_TEXTURE_2D_ARRAY, shadows->texture);
    gl->Uniform1i(at[SCENE_SHADOW_MAPS], unit);
    gl->Uniform3fv(at[SCENE_SHADOW_EYE], count, &eye[0][0]);
    gl->UniformMatrix3fv(at[SCENE_SHADOW_FRAME], count, GL_TRUE, &frame[0][0]);
    gl->Uniform4fv(at[SCENE_SHADOW_WINDOW], count, &window[0][0]);
    gl->Uniform1fv(at[SCENE_SHADOW_NEAR], count, near_distance);
    gl->Uniform1iv(at[SCENE_SHADOW_LAYER], count, shadows->first_layer);
    gl->Uniform1f(at[SCENE_SHADOW_LIFT], (float)SCENE_SHADOW_RAISED);
    gl->Uniform2f(at[SCENE_SHADOW_BIAS], (float)scene_shadows_get_bias(gl),
                  (float)SCENE_SHADOW_DEPTH);
}
