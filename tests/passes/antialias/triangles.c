// SPDX-License-Identifier: BSD-3-Clause
#include "tests/passes/antialias/triangles.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <stdarg.h>
#include <setjmp.h>
#include <cmocka.h>

const char triangles_flat[] = "flat in vec4 flat_colour;\n"
                              "flat in uint surface;\n"
                              "void main()\n"
                              "{\n"
                              "    weft_write(flat_colour, surface);\n"
                              "}\n";
const char triangles_smooth[] = "in vec4 smooth_colour;\n"
                                "flat in uint surface;\n"
                                "void main()\n"
                                "{\n"
                                "    weft_write(WEFT_AT(smooth_colour), surface);\n"
                                "}\n";
static const char vertex_begin[] = "#version 330 core\n"
                                   "layout(location = 0) in vec4 position;\n"
                                   "layout(location = 1) in vec4 colour;\n"
                                   "layout(location = 2) in uint surface_in;\n"
                                   "uniform mat4 place;\n"
                                   "flat out vec4 flat_colour;\n"
                                   "out vec4 smooth_colour;\n"
                                   "flat out uint surface;\n"
                                   "invariant gl_Position;\n"
                                   "void main()\n"
                                   "{\n"
                                   "    flat_colour = colour;\n"
                                   "    smooth_colour = colour;\n"
                                   "    surface = surface_in;\n"
                                   "    gl_Position = place * position;\n";

static GLuint compile(const GladGLContext *gl, GLenum kind, const char *begin, const char *middle,
                      const char *end)
{
    const char *const parts[3] = {begin, middle, end};
    const GLuint shader = gl->CreateShader(kind);
    GLint done = GL_FALSE;
    gl->ShaderSource(shader, 3, parts, NULL);
    gl->CompileShader(shader);
    gl->GetShaderiv(shader, GL_COMPILE_STATUS, &done);
    if (!done) {
        char message[1024] = "";
        gl->GetShaderInfoLog(shader, sizeof message, NULL, message);
        fail_msg("%s\n%s%s%s", message, begin, middle, end);
    }
    return shader;
}

static GLuint link_program(const struct triangles *t, const char *head, const char *fragment,
                           const char *moved)
{
    const GladGLContext *gl = &t->context->gl;
    const bool own = moved && moved[0];
    const GLuint vertex =
        own ? compile(gl, GL_VERTEX_SHADER, vertex_begin, moved, "}\n") : t->vertex_shader;
    const GLuint shader = compile(gl, GL_FRAGMENT_SHADER, head, fragment, "");
    const GLuint program = gl->CreateProgram();
    GLint done = GL_FALSE;
    gl->AttachShader(program, vertex);
    gl->AttachShader(program, shader);
    gl->LinkProgram(program);
    gl->GetProgramiv(program, GL_LINK_STATUS, &done);
    gl->DeleteShader(shader);
    if (own)
        gl->DeleteShader(vertex);
    if (!done) {
        char message[1024] = "";
        gl->GetProgramInfoLog(program, sizeof message, NULL, message);
        fail_msg("%s\n%s%s", message, head, fragment);
    }
    return program;
}

static GLuint program_of(struct triangles *t, const struct weft_antialias_pass *pass)
{
    const char *fragment = t->fragment[pass->stage] ? t->fragment[pass->stage] : triangles_flat;
    const char *moved = t->moved[pass->stage] ? t->moved[pass->stage] : "";
    const size_t size = strlen(pass->head) + strlen(fragment) + strlen(moved) + 3;
    char *key = malloc(size);
    assert_non_null(key);
    snprintf(key, size, "%s\n%s\n%s", pass->head, fragment, moved);
    for (int i = 0; i < t->programs; i++) {
        if (strcmp(t->program[i].key, key) == 0) {
            free(key);
            return t->program[i].program;
        }
    }
    assert_true(t->programs < TRIANGLES_PROGRAMS);
    t->program[t->programs].key = key;
    t->program[t->programs].program = link_program(t, pass->head, fragment, moved);
    return t->program[t->programs++].program;
}

enum weft_result triangles_draw(void *triangles, const struct weft_antialias_pass *pass)
{
    struct triangles *t = triangles;
    const GladGLContext *gl = &t->context->gl;
    const GLuint program = program_of(t, pass);
    GLfloat place[16];
    t->calls[pass->stage]++;
    for (int i = 0; i < 16; i++)
        place[i] = (GLfloat)pass->place[i];
    gl->UseProgram(program);
    gl->UniformMatrix4fv(gl->GetUniformLocation(program, "place"), 1, GL_FALSE, place);
    gl->BindVertexArray(t->vertex_array);
    if (t->before)
        t->before(gl, pass);
    gl->DrawArrays(GL_TRIANGLES, t->first, t->count ? t->count : t->vertices - t->first);
    if (t->after)
        t->after(gl, pass);
    return t->result;
}

static void upload(struct triangles *t, const struct triangle_vertex *vertices)
{
    const GladGLContext *gl = &t->context->gl;
    const GLsizei stride = sizeof *vertices;
    gl->GenVertexArrays(1, &t->vertex_array);
    gl->BindVertexArray(t->vertex_array);
    gl->GenBuffers(1, &t->buffer);
    gl->BindBuffer(GL_ARRAY_BUFFER, t->buffer);
    gl->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)t->vertices * stride, vertices, GL_STATIC_DRAW);
    gl->VertexAttribPointer(0, 4, GL_FLOAT, GL_FALSE, stride, NULL);
    gl->VertexAttribPointer(1, 4, GL_FLOAT, GL_FALSE, stride,
                            (const void *)offsetof(struct triangle_vertex, colour));
    gl->VertexAttribIPointer(2, 1, GL_UNSIGNED_INT, stride,
                             (const void *)offsetof(struct triangle_vertex, surface));
    for (GLuint i = 0; i < 3; i++)
        gl->EnableVertexAttribArray(i);
}

void triangles_create(weft_context *context, const struct triangle_vertex *vertices, int count,
                      struct triangles *out)
{
    const GladGLContext *gl = &context->gl;
    GLint vertex_array = 0;
    *out = (struct triangles){.context = context, .vertices = count};
    assert_int_equal(weft_context_enter(context), WEFT_OK);
    gl->GetIntegerv(GL_VERTEX_ARRAY_BINDING, &vertex_array);
    upload(out, vertices);
    out->vertex_shader = compile(gl, GL_VERTEX_SHADER, vertex_begin, "", "}\n");
    weft_gl_reset_state(gl, (GLuint)vertex_array);
    weft_context_leave(context);
}

void triangles_destroy(struct triangles *t)
{
    const GladGLContext *gl = &t->context->gl;
    assert_int_equal(weft_context_enter(t->context), WEFT_OK);
    for (int i = 0; i < t->programs; i++) {
        gl->DeleteProgram(t->program[i].program);
        free(t->program[i].key);
    }
    gl->DeleteShader(t->vertex_shader);
    gl->DeleteBuffers(1, &t->buffer);
    gl->DeleteVertexArrays(1, &t->vertex_array);
    weft_context_leave(t->context);
    *t = (struct triangles){0};
}

void triangle_at(const int size[2], const double corner[3][2], double depth, const float colour[4],
                 uint32_t surface, struct triangle_vertex out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = (struct triangle_vertex){.position = {(float)(2.0 * corner[i][0] / size[0] - 1.0),
                                                       (float)(2.0 * corner[i][1] / size[1] - 1.0),
                                                       (float)(2.0 * depth - 1.0), 1.0f},
                                          .surface = surface};
        memcpy(out[i].colour, colour, sizeof out[i].colour);
    }
}
