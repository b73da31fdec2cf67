// SPDX-License-Identifier: BSD-3-Clause
#include "tools/render/surface.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/render/gl/program.h"

const char scene_surface_head[] = SCENE_VERSION "out vec4 weft_colour;\n"
                                                "#define WEFT_AT(name) name\n"
                                                "void weft_write(vec4 colour, uint surface)\n"
                                                "{\n"
                                                "    weft_colour = colour;\n"
                                                "}\n";

static void end_surface(const GladGLContext *gl, struct scene_surface *surface)
{
    gl->DeleteProgram(surface->program);
    free(surface->head);
    surface->program = 0;
    surface->head = NULL;
}

void scene_surfaces_end(const GladGLContext *gl, struct scene_surfaces *surfaces)
{
    for (int i = 0; i < surfaces->count; i++)
        end_surface(gl, &surfaces->list[i]);
    gl->DeleteShader(surfaces->vertex);
    surfaces->count = surfaces->next = 0;
    surfaces->vertex = 0;
}

static struct scene_light_kind find_kind(const struct scene_shadow_view *view,
                                         const struct scene_point_light *light)
{
    return (struct scene_light_kind){
        .shadow = view->kind,
        .falloff = light->falloff,
        .is_flat = scene_light_is_flat(light),
        .clamped = light->most > 0.0,
    };
}

static bool is_same(const struct scene_light_kind *a, const struct scene_light_kind *b)
{
    return a->shadow == b->shadow && a->falloff == b->falloff && a->is_flat == b->is_flat &&
           a->clamped == b->clamped;
}

static bool is_for(const struct scene_surface *surface, const struct scene_surface_use *use)
{
    bool same = surface->use.stage == use->stage && surface->use.light_count == use->light_count &&
                strcmp(surface->use.head, use->head) == 0;
    for (int i = 0; i < use->light_count && same; i++)
        same = is_same(&surface->use.kind[i], &use->kind[i]);
    return same;
}

// What the shaders' text leaves open.
static void write_defines(const struct scene_surface_use *use, char *out, size_t bytes)
{
    const int count = use->light_count;
    int length = snprintf(out, bytes,
                          "#define LIGHTS %d\n#define FALLOFF_RADIANCE %d\n"
                          "#define FALLOFF_COSINE %d\n#define KIND_NONE %d\n"
                          "#define KIND_FITTED %d\n#define KIND_CUBE %d\n#define EACH_LIGHT",
                          count ? count : 1, SCENE_FALLOFF_RADIANCE, SCENE_FALLOFF_COSINE,
                          SCENE_SHADOW_NONE, SCENE_SHADOW_FITTED, SCENE_SHADOW_CUBE);
    for (int i = 0; i < count; i++) {
        const struct scene_light_kind *kind = &use->kind[i];
        length += snprintf(out + length, bytes - (size_t)length, " LIGHT(%d, %d, %d, %s, %s)", i,
                           kind->shadow, kind->falloff, kind->is_flat ? "true" : "false",
                           kind->clamped ? "true" : "false");
    }
    snprintf(out + length, bytes - (size_t)length, "\n");
}

// 0 after GL's message.
static GLuint compile_fragment(const GladGLContext *gl, const struct weft_log *log,
                               const struct scene_surface_use *use)
{
    char defines[1024];
    const char *text[] = {use->head, "", tools_shader_scene_line};
    if (use->stage == WEFT_STAGE_DEPTH)
        text[2] = tools_shader_scene_depth;
    if (use->stage == WEFT_STAGE_COLOUR) {
        write_defines(use, defines, sizeof defines);
        text[1] = defines;
        text[2] = tools_shader_scene_surface;
    }
    return scene_shader_compile(gl, log, GL_FRAGMENT_SHADER, text, 3);
}

static void find_uniforms(const GladGLContext *gl, struct scene_surface *surface)
{
    static const char *const name[SCENE_SURFACE_UNIFORM_COUNT] = {
        "clip",           "model",        "turn",           "planes",       "surfaces",
        "first_triangle", "reflectance",  "emission",       "ambient",      "checks",
        "unlit",          "only_clamped", "light_position", "light_normal", "light_intensity",
        "light_most",
    };
    for (int i = 0; i < SCENE_SURFACE_UNIFORM_COUNT; i++)
        surface->at[i] = gl->GetUniformLocation(surface->program, name[i]);
    scene_shadows_find_uniforms(gl, surface->program, surface->shadow_at);
}

static enum weft_result link(const GladGLContext *gl, const struct weft_log *log,
                             struct scene_surfaces *surfaces, const struct scene_surface_use *use,
                             struct scene_surface *out)
{
    const char *const text[] = {SCENE_VERSION, tools_shader_scene_vertex};
    *out = (struct scene_surface){.use = *use, .head = strdup(use->head)};
    if (!out->head)
        return WEFT_ERR_MEMORY;
    out->use.head = out->head;
    if (!surfaces->vertex)
        surfaces->vertex = scene_shader_compile(gl, log, GL_VERTEX_SHADER, text, 2);
    const GLuint fragment = surfaces->vertex ? compile_fragment(gl, log, use) : 0;
    if (fragment)
        out->program = scene_program_link(gl, log, surfaces->vertex, fragment);
    gl->DeleteShader(fragment); // 0 is left alone
    if (!out->program) {
        end_surface(gl, out);
        return WEFT_ERR_GL;
    }
    find_uniforms(gl, out);
    return WEFT_OK;
}

enum weft_result scene_surfaces_find(const GladGLContext *gl, const struct weft_log *log,
                                     struct scene_surfaces *surfaces,
                                     enum weft_antialias_stage stage, const char *head,
                                     const struct scene_shadow_view *view,
                                     const struct scene_point_light *light, int count,
                                     const struct scene_surface **out)
{
    struct scene_surface_use use = {.head = head, .stage = stage};
    if (stage == WEFT_STAGE_POINTS)
        use.stage = WEFT_STAGE_LINES;
    if (stage == WEFT_STAGE_COLOUR)
        use.light_count = count;
    for (int i = 0; i < use.light_count; i++)
        use.kind[i] = find_kind(&view[i], &light[i]);
    for (int i = 0; i < surfaces->count; i++)
        if (is_for(&surfaces->list[i], &use)) {
            *out = &surfaces->list[i];
            return WEFT_OK;
        }
    struct scene_surface made;
    const enum weft_result res = link(gl, log, surfaces, &use, &made);
    if (res != WEFT_OK)
        return res;
    struct scene_surface *place = &surfaces->list[surfaces->next];
    if (surfaces->count == SCENE_MAX_SURFACES)
        end_surface(gl, place);
    else
        surfaces->count++;
    surfaces->next = (surfaces->next + 1) % SCENE_MAX_SURFACES;
    *place = made;
    *out = place;
    return WEFT_OK;
}
