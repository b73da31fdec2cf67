// SPDX-License-Identifier: BSD-3-Clause
// Programs of shaders.
#include "tools/common/log.h"
#include "tools/render/gl/program.h"

GLuint scene_shader_compile(const GladGLContext *gl, const struct weft_log *log, GLenum stage,
                            const char *const *text, int count)
{
    const GLuint shader = gl->CreateShader(stage);
    GLint done = 0;
    gl->ShaderSource(shader, count, text, NULL);
    gl->CompileShader(shader);
    gl->GetShaderiv(shader, GL_COMPILE_STATUS, &done);
    if (done)
        return shader;
    char message[512] = "";
    gl->GetShaderInfoLog(shader, sizeof message, NULL, message);
    log_error(log, "a %s shader of scenes does not compile: %s",
              stage == GL_VERTEX_SHADER ? "vertex" : "fragment", message);
    gl->DeleteShader(shader);
    return 0;
}

GLuint scene_program_link(const GladGLContext *gl, const struct weft_log *log, GLuint vertex,
                          GLuint fragment)
{
    const GLuint program = gl->CreateProgram();
    GLint done = 0;
    gl->AttachShader(program, vertex);
    gl->AttachShader(program, fragment);
    gl->LinkProgram(program);
    // What a program was linked from may go, or be linked to others.
    gl->DetachShader(program, vertex);
    gl->DetachShader(program, fragment);
    gl->GetProgramiv(program, GL_LINK_STATUS, &done);
    if (done)
        return program;
    char message[512] = "";
    gl->GetProgramInfoLog(program, sizeof message, NULL, message);
    log_error(log, "a program of scenes does not link: %s", message);
    gl->DeleteProgram(program);
    return 0;
}
