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
    const bool has_version = strncmp(defines, "#version", 8) == 0;
    const char *const parts[3] = {has_version ? "" : "#version 330 core\n", defines, source};
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

static struct weft_cached_program *find(weft_context *context, const char *key)
{
    for (size_t i = 0; i < context->program_count; i++)
        if (strcmp(context->programs[i].key, key) == 0)
            return &context->programs[i];
    return NULL;
}

// The oldest that nobody holds; NULL while there is room for more, or where all are held.
static struct weft_cached_program *find_oldest(weft_context *context)
{
    if (context->program_count < WEFT_PROGRAM_CACHE)
        return NULL;
    for (size_t i = 0; i < context->program_count; i++) {
        struct weft_cached_program *p =
            &context->programs[(context->next_program + i) % context->program_count];
        if (p->holders == 0) {
            context->next_program = (size_t)(p - context->programs) + 1;
            return p;
        }
    }
    return NULL;
}

// Takes key and program; false: no memory.
static bool keep(weft_context *context, char *key, GLuint program)
{
    struct weft_cached_program *slot = find_oldest(context);
    if (slot) {
        context->gl.DeleteProgram(slot->program);
        free(slot->key);
    } else {
        void *programs =
            realloc(context->programs, (context->program_count + 1) * sizeof *context->programs);
        if (!programs)
            return false;
        context->programs = programs;
        slot = &context->programs[context->program_count++];
    }
    *slot = (struct weft_cached_program){key, program, 0};
    context->programs_linked++;
    return true;
}

enum weft_result weft_program_get(weft_context *context, const char *name, const char *defines,
                                  const char *vertex, const char *fragment, GLuint *out)
{
    char *key = NULL;
    enum weft_result res = WEFT_ERR_MEMORY;
    *out = 0;
    if (asprintf(&key, "%s\n%s", name, defines) < 0) {
        weft_error(context->log, "not enough memory for the %s program", name);
        return WEFT_ERR_MEMORY;
    }
    const struct weft_cached_program *cached = find(context, key);
    if (cached) {
        free(key);
        *out = cached->program;
        return WEFT_OK;
    }
    GLuint program = link_program(context->log, &context->gl, name, defines, vertex, fragment);
    if (program && keep(context, key, program)) {
        *out = program;
        return WEFT_OK;
    }
    if (program) {
        context->gl.DeleteProgram(program);
        weft_error(context->log, "not enough memory for the %s program", name);
    } else {
        res = WEFT_ERR_GL;
    }
    free(key);
    return res;
}

static void add_holder(weft_context *context, GLuint program, int change)
{
    for (size_t i = 0; program && i < context->program_count; i++)
        if (context->programs[i].program == program)
            context->programs[i].holders += change;
}

void weft_program_hold(weft_context *context, GLuint program)
{
    add_holder(context, program, 1);
}

void weft_program_release(weft_context *context, GLuint program)
{
    add_holder(context, program, -1);
}
