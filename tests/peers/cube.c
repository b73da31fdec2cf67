// SPDX-License-Identifier: BSD-3-Clause
#include "tests/peers/cube.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "passes/gl/program.h"

// Six faces of two triangles; a corner's place in the unit cube is its colour.
static const char vertex[] =
    "uniform mat3 turn;\n"
    "out vec3 colour;\n"
    "void main()\n"
    "{\n"
    "    const int corner[6] = int[6](0, 1, 2, 2, 1, 3);\n"
    "    int face = gl_VertexID / 6, c = corner[gl_VertexID % 6], axis = face / 2;\n"
    "    vec3 p;\n"
    "    p[axis] = float(face & 1);\n"
    "    p[(axis + 1) % 3] = float(c & 1);\n"
    "    p[(axis + 2) % 3] = float(c >> 1);\n"
    "    colour = p;\n"
    "    vec3 at = turn * (p - 0.5);\n"
    "    gl_Position = vec4(1.1 * at.xy, at.z, 1.0);\n"
    "}\n";
static const char fragment[] = "in vec3 colour;\n"
                               "out vec4 value;\n"
                               "void main()\n"
                               "{\n"
                               "    value = vec4(colour, 1.0);\n"
                               "}\n";

bool cube_create(weft_context *context, bool turns, struct cube *out)
{
    *out = (struct cube){.context = context, .gl = &context->gl, .turns = turns};
    enum weft_result res = weft_context_enter(context);
    if (res != WEFT_OK)
        return false;
    res = weft_program_get(context, "colour cube", "", vertex, fragment, &out->program);
    if (res == WEFT_OK)
        weft_program_hold(context, out->program);
    weft_context_leave(context);
    if (res != WEFT_OK)
        fprintf(stderr, "the colour cube cannot be drawn: %s\n", weft_result_text(res));
    return res == WEFT_OK;
}

// About the vertical axis by a, and then toward the viewer, column by column.
static void set_turn(const struct cube *cube, int64_t index)
{
    const double a = 0.6 + (cube->turns ? 0.01 * (double)index : 0.0), b = 0.6;
    const float turn[9] = {
        (float)cos(a),
        (float)(sin(a) * sin(b)),
        (float)(sin(a) * cos(b)),
        0.0f,
        (float)cos(b),
        (float)-sin(b),
        (float)sin(a),
        (float)(-cos(a) * sin(b)),
        (float)(-cos(a) * cos(b)),
    };
    cube->gl->UniformMatrix3fv(weft_gl_location(cube->gl, cube->program, "turn"), 1, GL_FALSE,
                               turn);
}

enum weft_result cube_draw(void *priv, int64_t index, const struct weft_draw_target *target)
{
    const struct cube *cube = priv;
    const GladGLContext *gl = cube->gl;
    (void)target;
    gl->UseProgram(cube->program);
    set_turn(cube, index);
    gl->Disable(GL_BLEND);
    gl->Enable(GL_DEPTH_TEST);
    gl->DrawArrays(GL_TRIANGLES, 0, 36);
    gl->Disable(GL_DEPTH_TEST);
    return WEFT_OK;
}

bool cube_target_create(const struct cube *cube, int width, int height, struct cube_target *out)
{
    const GladGLContext *gl = cube->gl;
    *out = (struct cube_target){.drawn = {.width = width, .height = height}};
    if (weft_gl_target_create(NULL, gl, GL_RGBA8, width, height, &out->colour) != WEFT_OK) {
        fprintf(stderr, "no target of %d x %d pixels\n", width, height);
        return false;
    }
    gl->GenRenderbuffers(1, &out->depth);
    gl->BindRenderbuffer(GL_RENDERBUFFER, out->depth);
    gl->RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, width, height);
    gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, out->depth);
    out->drawn.framebuffer = out->colour.framebuffer;
    return gl->CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
}

void cube_target_destroy(const struct cube *cube, struct cube_target *target)
{
    weft_gl_target_destroy(cube->gl, &target->colour);
    cube->gl->DeleteRenderbuffers(1, &target->depth);
}

void cube_target_draw(const struct cube *cube, const struct cube_target *target, int64_t index)
{
    const GladGLContext *gl = cube->gl;
    weft_gl_target_bind(gl, &target->colour, target->drawn.width, target->drawn.height);
    gl->ClearColor(0.0f, 0.0f, 0.0f, 0.0f);
    gl->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    cube_draw((void *)cube, index, &target->drawn);
}

uint8_t *cube_codes(const struct cube *cube, int width, int height)
{
    const size_t row = 4 * (size_t)width;
    uint8_t *codes = malloc(row * (size_t)height), *up = malloc(row * (size_t)height);
    struct cube_target target = {0};
    if (codes && up && weft_context_enter(cube->context) == WEFT_OK) {
        const struct weft_gl_pixels pixels = {
            .width = width, .height = height, .type = GL_UNSIGNED_BYTE, .data = up};
        bool ok = cube_target_create(cube, width, height, &target);
        if (ok)
            cube_target_draw(cube, &target, 0);
        ok = ok && weft_gl_target_read(NULL, cube->gl, &target.colour, &pixels) == WEFT_OK;
        for (int y = 0; ok && y < height; y++)
            memcpy(codes + (size_t)y * row, up + (size_t)(height - 1 - y) * row, row);
        cube_target_destroy(cube, &target);
        weft_context_leave(cube->context);
        if (ok) {
            free(up);
            return codes;
        }
    }
    fprintf(stderr, "the colour cube cannot be drawn\n");
    free(codes);
    free(up);
    return NULL;
}
