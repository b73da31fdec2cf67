// SPDX-License-Identifier: BSD-3-Clause
#include "passes/gl/program.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void log_source(const struct weft_log *log, const char *const parts[3])
{
    int number = 1;
    for (int i = 0; i < 3; i++) {
        for (const char *line = parts[i]; *line; number++) {
            int length = (int)strcspn(line, "\n");
            weft_debug(log, "%4d  %.*s", number, length, line);
            line += length + (line[length] == '\n');
        }
    }
}

static GLuint compile(const struct weft_log *log, const GladGLContext *gl, const char *name,
                      GLenum kind, const char *defines, const char *source)
{
    const char *const parts[3] = {"#version 330 core\n", defines, source};
    GLuint shader = gl->CreateShader(kind);
    GLint done = GL_FALSE;
    gl->ShaderSource(shader, 3, parts, NULL);
    gl->CompileShader(shader);
    gl->GetShaderiv(shader, GL_COMPILE_STATUS, &done);
    if (done)
        return shader;
    char message[512] = "";
    gl->GetShaderInfoLog(shader, sizeof message, NULL, message);
    weft_error(log, "GL: the %s shader does not compile: %s", name, message);
    log_source(log, parts);
    gl->DeleteShader(shader);
    return 0;
}

static GLuint link_program(const struct weft_log *log, const GladGLContext *gl, const char *name,
                           const char *defines, const char *vertex, const char *fragment)
{
    GLuint shaders[2] = {compile(log, gl, name, GL_VERTEX_SHADER, "", vertex),
                         compile(log, gl, name, GL_FRAGMENT_SHADER, defines, fragment)};
    GLuint program = gl->CreateProgram();
    GLint done = GL_FALSE;
    if (shaders[0] && shaders[1]) {
        for (int i = 0; i < 2; i++)
            gl->AttachShader(program, shaders[i]);
        gl->LinkProgram(program);
        gl->GetProgramiv(program, GL_LINK_STATUS, &done);
        if (!done) {
            char message[512] = "";
            gl->GetProgramInfoLog(program, sizeof message, NULL, message);
            weft_error(log, "GL: the %s program does not link: %s", name, message);
        }
    }
    for (int i = 0; i < 2; i++)
        if (shaders[i])
            gl->DeleteShader(shaders[i]);
    if (done)
        return program;
    gl->DeleteProgram(program);
    return 0;
}

enum weft_result weft_program_get(weft_context *context, const char *name, const char *defines,
                                  const char *vertex, const char *fragment, GLuint *out)
{
    char *key = NULL;
    *out = 0;
    if (asprintf(&key, "%s\n%s", name, defines) < 0) {
        weft_error(context->log, "not enough memory for the %s program", name);
        return WEFT_ERR_MEMORY;
    }
    for (size_t i = 0; i < WEFT_PROGRAM_CACHE; i++) {
        if (context->programs[i].key && strcmp(context->programs[i].key, key) == 0) {
            free(key);
            *out = context->programs[i].program;
            return WEFT_OK;
        }
    }
    GLuint program = link_program(context->log, &context->gl, name, defines, vertex, fragment);
    if (!program) {
        free(key);
        return WEFT_ERR_GL;
    }
    struct weft_cached_program *slot = &context->programs[context->next_program];
    context->next_program = (context->next_program + 1) % WEFT_PROGRAM_CACHE;
    if (slot->key)
        context->gl.DeleteProgram(slot->program);
    free(slot->key);
    *slot = (struct weft_cached_program){key, program};
    *out = program;
    return WEFT_OK;
}
