// SPDX-License-Identifier: BSD-3-Clause
// Programs of shaders.
#include "tools/common/log.h"
#include "tools/render/program.h"

static GLuint compile(const GladGLContext *gl, const struct weft_log *log, GLenum stage,
                      const char *defines, const char *source)
{
    const char *const text[3] = {"#version 330 core\n", defines, source};
    const GLuint shader = gl->CreateShader(stage);
    GLint done = 0;
    gl->ShaderSource(shader, 3, text, NULL);
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

static bool link(const GladGLContext *gl, const struct weft_log *log, GLuint program)
{
    GLint done = 0;
    gl->LinkProgram(program);
    gl->GetProgramiv(program, GL_LINK_STATUS, &done);
    if (done)
        return true;
    char message[512] = "";
    gl->GetProgramInfoLog(program, sizeof message, NULL, message);
    log_error(log, "a program of scenes does not link: %s", message);
    return false;
}

enum weft_result scene_program_link(const GladGLContext *gl, const struct weft_log *log,
                                    const char *defines, const char *vertex, const char *fragment,
                                    GLuint *out)
{
    *out = 0;
    const GLuint first = compile(gl, log, GL_VERTEX_SHADER, defines, vertex);
    const GLuint second = first ? compile(gl, log, GL_FRAGMENT_SHADER, defines, fragment) : 0;
    if (second) {
        *out = gl->CreateProgram();
        gl->AttachShader(*out, first);
        gl->AttachShader(*out, second);
        if (!link(gl, log, *out)) {
            gl->DeleteProgram(*out);
            *out = 0;
        }
    }
    // 0 is left alone; what is attached lives as long as the program.
    gl->DeleteShader(first);
    gl->DeleteShader(second);
    return *out ? WEFT_OK : WEFT_ERR_GL;
}
