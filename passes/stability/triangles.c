// SPDX-License-Identifier: BSD-3-Clause
#include "passes/stability/triangles.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"

struct vertex {
    GLfloat position[3], colour[3];
    GLuint surface;
};

// The scene's own matrices: model turns z to x, view turns z to y. Vertices are given turned back.
static const double model_angle = 0.4, view_angle = 0.7;

static const char vertex_text[] =
    "#version 330 core\n"
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 colour;\n"
    "layout(location = 2) in uint surface;\n"
    "uniform mat4 model, view, place;\n"
    "flat out vec3 own_colour;\n"
    "flat out uint own_surface;\n"
    "invariant gl_Position;\n"
    "void main()\n"
    "{\n"
    "    own_colour = colour;\n"
    "    own_surface = surface;\n"
    "    gl_Position = place * (view * (model * vec4(position, 1.0)));\n"
    "}\n";

// Of the depth pass alone: `whole` is the product of the three.
static const char apart_text[] = "#version 330 core\n"
                                 "layout(location = 0) in vec3 position;\n"
                                 "uniform mat4 whole;\n"
                                 "flat out vec3 own_colour;\n"
                                 "flat out uint own_surface;\n"
                                 "void main()\n"
                                 "{\n"
                                 "    own_colour = vec3(0.0);\n"
                                 "    own_surface = 0u;\n"
                                 "    gl_Position = whole * vec4(position, 1.0);\n"
                                 "}\n";

static const char fragment_text[] = "flat in vec3 own_colour;\n"
                                    "flat in uint own_surface;\n"
                                    "void main()\n"
                                    "{\n"
                                    "    weft_write(vec4(own_colour, 1.0), own_surface);\n"
                                    "}\n";

// ---- programs -----------------------------------------------------------------------------------

static GLuint compile(const GladGLContext *gl, GLenum kind, const char *first, const char *second)
{
    const char *const parts[2] = {first, second};
    const GLuint shader = gl->CreateShader(kind);
    gl->ShaderSource(shader, 2, parts, NULL);
    gl->CompileShader(shader);
    return shader;
}

static GLuint link_program(const struct weft_stability_scene *s, const char *vertex,
                           const char *head)
{
    const GladGLContext *gl = &s->context->gl;
    const GLuint shaders[2] = {compile(gl, GL_VERTEX_SHADER, vertex, ""),
                               compile(gl, GL_FRAGMENT_SHADER, head, fragment_text)};
    const GLuint program = gl->CreateProgram();
    GLint done = GL_FALSE;
    for (int i = 0; i < 2; i++)
        gl->AttachShader(program, shaders[i]);
    gl->LinkProgram(program);
    for (int i = 0; i < 2; i++)
        gl->DeleteShader(shaders[i]);
    gl->GetProgramiv(program, GL_LINK_STATUS, &done);
    if (done)
        return program;
    weft_error(s->log, "stability: a program of triangles does not link");
    gl->DeleteProgram(program);
    return 0;
}

static enum weft_result find_program(struct weft_stability_scene *s, bool apart, const char *head,
                                     GLuint *out)
{
    char *key = NULL;
    *out = 0;
    if (asprintf(&key, "%d%s", apart, head) < 0) {
        weft_error(s->log, "stability: not enough memory for a program");
        return WEFT_ERR_MEMORY;
    }
    for (int i = 0; i < s->programs && !*out; i++)
        if (strcmp(s->program[i].key, key) == 0)
            *out = s->program[i].program;
    if (*out || s->programs == WEFT_STABILITY_PROGRAMS) {
        free(key);
        return *out ? WEFT_OK : WEFT_ERR_LIMIT;
    }
    *out = link_program(s, apart ? apart_text : vertex_text, head);
    if (!*out) {
        free(key);
        return WEFT_ERR_GL;
    }
    s->program[s->programs].key = key;
    s->program[s->programs++].program = *out;
    return WEFT_OK;
}

// ---- matrices, column by column -----------------------------------------------------------------

// Turns axis 2 towards another.
static void turn(double angle, int axis, double out[16])
{
    memset(out, 0, 16 * sizeof *out);
    for (int i = 0; i < 4; i++)
        out[5 * i] = 1.0;
    out[5 * axis] = out[10] = cos(angle);
    out[4 * 2 + axis] = sin(angle);
    out[4 * axis + 2] = -sin(angle);
}

static void multiply(const double a[16], const double b[16], double out[16])
{
    for (int i = 0; i < 16; i++) {
        out[i] = 0.0;
        for (int k = 0; k < 4; k++)
            out[i] += a[4 * k + i % 4] * b[4 * (i / 4) + k];
    }
}

static void set_matrix(const GladGLContext *gl, GLuint program, const char *name,
                       const double matrix[16])
{
    GLfloat values[16];
    for (int i = 0; i < 16; i++)
        values[i] = (GLfloat)matrix[i];
    gl->UniformMatrix4fv(gl->GetUniformLocation(program, name), 1, GL_FALSE, values);
}

// ---- scenes -------------------------------------------------------------------------------------

static void turn_back(double angle, int axis, double v[3])
{
    const double c = cos(angle), s = sin(angle), along = v[axis], z = v[2];
    v[axis] = c * along - s * z;
    v[2] = s * along + c * z;
}

// Turned back, as vertices are kept.
static struct vertex vertex_of(const struct weft_stability_triangle *t, int corner, int size)
{
    double v[3] = {2.0 * t->corner[corner][0] / size - 1.0, 2.0 * t->corner[corner][1] / size - 1.0,
                   2.0 * t->depth[corner] - 1.0};
    turn_back(view_angle, 1, v);
    turn_back(model_angle, 0, v);
    return (struct vertex){.position = {(GLfloat)v[0], (GLfloat)v[1], (GLfloat)v[2]},
                           .colour = {t->colour[0], t->colour[1], t->colour[2]},
                           .surface = t->surface};
}

static void upload(struct weft_stability_scene *s, const struct vertex *vertices)
{
    const GladGLContext *gl = &s->context->gl;
    const GLsizei stride = sizeof *vertices;
    gl->GenVertexArrays(1, &s->vertex_array);
    gl->BindVertexArray(s->vertex_array);
    gl->GenBuffers(1, &s->buffer);
    gl->BindBuffer(GL_ARRAY_BUFFER, s->buffer);
    gl->BufferData(GL_ARRAY_BUFFER, s->count * stride, vertices, GL_STATIC_DRAW);
    gl->VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, stride, NULL);
    gl->VertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, stride,
                            (const void *)offsetof(struct vertex, colour));
    gl->VertexAttribIPointer(2, 1, GL_UNSIGNED_INT, stride,
                             (const void *)offsetof(struct vertex, surface));
    for (GLuint i = 0; i < 3; i++)
        gl->EnableVertexAttribArray(i);
}

enum weft_result weft_stability_scene_create(const struct weft_stability_params *params, int size,
                                             const struct weft_stability_triangle *triangles,
                                             int count, struct weft_stability_scene *out)
{
    struct vertex vertices[3 * WEFT_STABILITY_MOST_TRIANGLES];
    GLint vertex_array = 0;
    *out = (struct weft_stability_scene){.copies = 1};
    if (count > WEFT_STABILITY_MOST_TRIANGLES)
        return WEFT_ERR_LIMIT;
    for (int i = 0; i < 3 * count; i++)
        vertices[i] = vertex_of(&triangles[i / 3], i % 3, size);
    enum weft_result res = weft_context_enter(params->context);
    if (res != WEFT_OK)
        return res;
    const GladGLContext *gl = &params->context->gl;
    out->context = params->context;
    out->log = params->log;
    out->count = 3 * count;
    gl->GetIntegerv(GL_VERTEX_ARRAY_BINDING, &vertex_array);
    upload(out, vertices);
    gl->BindVertexArray((GLuint)vertex_array);
    res = weft_gl_check(params->log, gl, "loading triangles");
    weft_context_leave(params->context);
    return res;
}

void weft_stability_scene_destroy(struct weft_stability_scene *s)
{
    for (int i = 0; i < s->programs; i++)
        free(s->program[i].key);
    if (s->context && weft_context_enter(s->context) == WEFT_OK) {
        const GladGLContext *gl = &s->context->gl;
        for (int i = 0; i < s->programs; i++)
            gl->DeleteProgram(s->program[i].program);
        gl->DeleteBuffers(1, &s->buffer);
        gl->DeleteVertexArrays(1, &s->vertex_array);
        weft_context_leave(s->context);
    }
    *s = (struct weft_stability_scene){0};
}

enum weft_result weft_stability_scene_draw(void *scene, const struct weft_antialias_pass *pass)
{
    struct weft_stability_scene *s = scene;
    const GladGLContext *gl = &s->context->gl;
    const bool apart = s->depths_apart && pass->stage == WEFT_STAGE_DEPTH;
    double model[16], view[16], seen[16], whole[16];
    GLuint program;
    const enum weft_result res = find_program(s, apart, pass->head, &program);
    if (res != WEFT_OK)
        return res;
    turn(model_angle, 0, model);
    turn(view_angle, 1, view);
    multiply(view, model, seen);
    multiply(pass->place, seen, whole);
    gl->UseProgram(program);
    set_matrix(gl, program, "model", model);
    set_matrix(gl, program, "view", view);
    set_matrix(gl, program, "place", pass->place);
    set_matrix(gl, program, "whole", whole);
    gl->BindVertexArray(s->vertex_array);
    for (int i = 0; i < (pass->stage == WEFT_STAGE_COLOUR ? s->copies : 1); i++)
        gl->DrawArrays(GL_TRIANGLES, 0, s->count);
    return WEFT_OK;
}
