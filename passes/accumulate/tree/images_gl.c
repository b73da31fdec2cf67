// SPDX-License-Identifier: BSD-3-Clause
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "filter/check.h"
#include "passes/accumulate/tree/images.h"
#include "passes/gl/program.h"

// A program and where its uniforms are; all zero: not wanted yet.
struct weft_tree_program {
    GLuint program;
    GLint factor, inverse, denominator, add; // of nodes
    GLint unit, low, scale;                  // of leaves
};

// Nodes by inputs and arithmetic, then leaves by what frames are of.
enum { SMALL = 1, ARITHMETICS, SOURCES = 4 };
enum { LEAVES = (WEFT_TREE_MAX_INPUTS + 1) * ARITHMETICS, PROGRAMS = LEAVES + SOURCES };

enum weft_result weft_tree_gl_create(struct weft_tree_images *images)
{
    const struct weft_tree_images_params *p = &images->params;
    const int most = p->context->info.max_target_size;
    if (p->width > most || p->height > most) {
        weft_error(p->log,
                   "tree: frames of %" PRId32 " x %" PRId32 " pixels, GL's limit is %d a side",
                   p->width, p->height, most);
        return WEFT_ERR_LIMIT;
    }
    images->programs = calloc(PROGRAMS, sizeof *images->programs);
    if (images->programs)
        return WEFT_OK;
    weft_error(p->log, "tree: not enough memory");
    return WEFT_ERR_MEMORY;
}

void weft_tree_gl_destroy(struct weft_tree_images *images)
{
    for (int i = 0; images->programs && i < PROGRAMS; i++)
        weft_program_release(images->params.context, images->programs[i].program);
    free(images->programs);
}

// ---- programs -----------------------------------------------------------------------------------

static void set_units(const GladGLContext *gl, GLuint program, const char *name, int count)
{
    GLint units[WEFT_TREE_MAX_INPUTS];
    for (int i = 0; i < count; i++)
        units[i] = i;
    gl->UseProgram(program);
    gl->Uniform1iv(weft_gl_location(gl, program, name), count, units);
}

static enum weft_result make_program(struct weft_tree_images *images, const char *name,
                                     const char *defines, const char *source, int units,
                                     struct weft_tree_program *out)
{
    weft_context *context = images->params.context;
    const GladGLContext *gl = &context->gl;
    GLuint program;
    const enum weft_result res =
        weft_program_get(context, name, defines, weft_shader_full_target, source, &program);
    if (res != WEFT_OK)
        return res;
    weft_program_hold(context, program);
    *out = (struct weft_tree_program){
        .program = program,
        .factor = weft_gl_location(gl, program, "factor"),
        .inverse = weft_gl_location(gl, program, "inverse"),
        .denominator = weft_gl_location(gl, program, "denominator"),
        .add = weft_gl_location(gl, program, "add"),
        .unit = weft_gl_location(gl, program, "unit"),
        .low = weft_gl_location(gl, program, "low"),
        .scale = weft_gl_location(gl, program, "scale"),
    };
    set_units(gl, program, units > 1 ? "inputs" : "frame", units);
    return WEFT_OK;
}

static enum weft_result find_node(struct weft_tree_images *images, int inputs, bool small,
                                  const struct weft_tree_program **out)
{
    struct weft_tree_program *program = &images->programs[inputs * ARITHMETICS + small];
    char defines[96];
    *out = program;
    if (program->program)
        return WEFT_OK;
    snprintf(defines, sizeof defines,
             "#define INPUTS %d\n#define ONE %" PRIu32 "\n#define SMALL %d\n", inputs, images->one,
             small);
    return make_program(images, "tree node", defines, weft_shader_tree_node, inputs, program);
}

// The largest code of a texture's format; 0: floats.
static uint32_t one_of(GLenum format)
{
    return format == GL_R8 || format == GL_RGBA8     ? UINT8_MAX
           : format == GL_R16 || format == GL_RGBA16 ? UINT16_MAX
                                                     : 0;
}

static enum weft_result find_leaf(struct weft_tree_images *images, uint32_t source, bool copy,
                                  const struct weft_tree_program **out)
{
    const int index = copy ? 0 : source == UINT8_MAX ? 1 : source == UINT16_MAX ? 2 : 3;
    struct weft_tree_program *program = &images->programs[LEAVES + index];
    char defines[128];
    *out = program;
    if (program->program)
        return WEFT_OK;
    snprintf(defines, sizeof defines,
             "#define SOURCE %" PRIu32 "\n#define ONE %" PRIu32
             "\n#define RANGED %d\n#define COPY %d\n",
             source, images->one, images->params.ranged && images->one, copy);
    return make_program(images, "tree leaf", defines, weft_shader_tree_leaf, 1, program);
}

// ---- passes -------------------------------------------------------------------------------------

static void draw(struct weft_tree_images *images, const struct weft_gl_target *out)
{
    const GladGLContext *gl = &images->params.context->gl;
    weft_gl_target_bind(gl, out, images->params.width, images->params.height);
    gl->Disable(GL_DITHER);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    gl->Enable(GL_DITHER);
    images->passes++;
}

static void set_node(const GladGLContext *gl, const struct weft_tree_program *program,
                     const struct weft_tree_node *node, uint32_t one, bool small)
{
    GLfloat factor[WEFT_TREE_MAX_INPUTS];
    const int count = node->input_count;
    gl->UseProgram(program->program);
    if (!one) {
        gl->Uniform1fv(program->factor, count, node->factor);
        return;
    }
    gl->Uniform1f(program->inverse, (GLfloat)(1.0 / node->denominator));
    if (!small) {
        gl->Uniform1uiv(program->factor, count, node->numerator);
        gl->Uniform1ui(program->denominator, node->denominator);
        gl->Uniform1ui(program->add, node->add);
        return;
    }
    for (int k = 0; k < count; k++)
        factor[k] = (GLfloat)(node->numerator[k] * one);
    gl->Uniform1fv(program->factor, count, factor);
    gl->Uniform1f(program->add, (GLfloat)node->add + 0.5f);
}

enum weft_result weft_tree_gl_combine(struct weft_tree_images *images, const int *inputs,
                                      const struct weft_tree_node *node, int out)
{
    const GladGLContext *gl = &images->params.context->gl;
    const bool small = (uint64_t)node->denominator * (images->one + 1) <= 1 << 18;
    const struct weft_tree_program *program = NULL;
    const enum weft_result res = find_node(images, node->input_count, small, &program);
    if (res != WEFT_OK)
        return res;
    set_node(gl, program, node, images->one, small);
    for (int g = 0; g < images->params.groups; g++) {
        for (int k = 0; k < node->input_count; k++) {
            gl->ActiveTexture(GL_TEXTURE0 + (GLenum)k);
            gl->BindTexture(GL_TEXTURE_2D, images->image[inputs[k]].targets[g].texture);
        }
        draw(images, &images->image[out].targets[g]);
    }
    gl->ActiveTexture(GL_TEXTURE0);
    return weft_gl_check(images->params.log, gl, "averaging frames");
}

// Without a pass: in memory on software renderers.
static bool copies(const struct weft_tree_images *images, const struct weft_gl_target *out,
                   const struct weft_gl_target *texture)
{
    const GladGLContext *gl = &images->params.context->gl;
    if (!gl->CopyImageSubData || texture->format != out->format)
        return false;
    gl->CopyImageSubData(texture->texture, GL_TEXTURE_2D, 0, 0, 0, 0, out->texture, GL_TEXTURE_2D,
                         0, 0, 0, 0, images->params.width, images->params.height, 1);
    return true;
}

// Texels that are as they have to be are copied: codes of as many bits, and floats into floats.
enum weft_result weft_tree_gl_load(struct weft_tree_images *images,
                                   const struct weft_gl_target *out,
                                   const struct weft_gl_target *texture)
{
    const struct weft_tree_images_params *p = &images->params;
    const GladGLContext *gl = &p->context->gl;
    const uint32_t source = one_of(texture->format);
    const bool copy = source == images->one && !(images->one && p->ranged);
    const struct weft_tree_program *program = NULL;
    if (copy && copies(images, out, texture))
        return weft_gl_check(p->log, gl, "copying a frame");
    const enum weft_result res = find_leaf(images, source, copy, &program);
    if (res != WEFT_OK)
        return res;
    gl->UseProgram(program->program);
    gl->Uniform1f(program->unit, source ? (GLfloat)(1.0 / source) : 1.0f);
    gl->Uniform1f(program->low, p->low);
    gl->Uniform1f(program->scale, p->scale);
    gl->BindTexture(GL_TEXTURE_2D, texture->texture);
    draw(images, out);
    return weft_gl_check(p->log, gl, "taking a frame in");
}
