// SPDX-License-Identifier: BSD-3-Clause
#include "tools/render/surface.h"

#include <stdio.h>

#include "tools/render/program.h"

void scene_surfaces_end(const GladGLContext *gl, struct scene_surfaces *surfaces)
{
    for (int i = 0; i < surfaces->count; i++)
        gl->DeleteProgram(surfaces->list[i].program);
    surfaces->count = surfaces->next = 0;
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

static bool is_for(const struct scene_surface *surface, const struct scene_light_kind *kind,
                   int count)
{
    bool same = surface->light_count == count;
    for (int i = 0; i < count && same; i++)
        same = is_same(&surface->kind[i], &kind[i]);
    return same;
}

// What the shaders' text leaves open.
static void write_defines(const struct scene_surface *surface, char *out, size_t bytes)
{
    const int count = surface->light_count;
    int length = snprintf(out, bytes,
                          "#define LIGHTS %d\n#define FALLOFF_RADIANCE %d\n"
                          "#define FALLOFF_COSINE %d\n#define KIND_NONE %d\n"
                          "#define KIND_FITTED %d\n#define KIND_CUBE %d\n#define EACH_LIGHT",
                          count ? count : 1, SCENE_FALLOFF_RADIANCE, SCENE_FALLOFF_COSINE,
                          SCENE_SHADOW_NONE, SCENE_SHADOW_FITTED, SCENE_SHADOW_CUBE);
    for (int i = 0; i < count; i++) {
        const struct scene_light_kind *kind = &surface->kind[i];
        length += snprintf(out + length, bytes - (size_t)length, " LIGHT(%d, %d, %d, %s, %s)", i,
                           kind->shadow, kind->falloff, kind->is_flat ? "true" : "false",
                           kind->clamped ? "true" : "false");
    }
    snprintf(out + length, bytes - (size_t)length, "\n");
}

static enum weft_result link(const GladGLContext *gl, const struct weft_log *log,
                             struct scene_surface *surface)
{
    static const char *const name[SCENE_SURFACE_UNIFORM_COUNT] = {
        "clip",         "model",          "turn",         "planes",          "first_triangle",
        "reflectance",  "emission",       "ambient",      "checks",          "unlit",
        "only_clamped", "light_position", "light_normal", "light_intensity", "light_most",
    };
    char defines[1024];
    write_defines(surface, defines, sizeof defines);
    const enum weft_result res = scene_program_link(gl, log, defines, tools_shader_scene_vertex,
                                                    tools_shader_scene_surface, &surface->program);
    for (int i = 0; i < SCENE_SURFACE_UNIFORM_COUNT && res == WEFT_OK; i++)
        surface->at[i] = gl->GetUniformLocation(surface->program, name[i]);
    if (res == WEFT_OK)
        scene_shadows_find_uniforms(gl, surface->program, surface->shadow_at);
    return res;
}

enum weft_result scene_surfaces_find(const GladGLContext *gl, const struct weft_log *log,
                                     struct scene_surfaces *surfaces,
                                     const struct scene_shadow_view *view,
                                     const struct scene_point_light *light, int count,
                                     const struct scene_surface **out)
{
    struct scene_surface wanted = {.light_count = count};
    for (int i = 0; i < count; i++)
        wanted.kind[i] = find_kind(&view[i], &light[i]);
    for (int i = 0; i < surfaces->count; i++)
        if (is_for(&surfaces->list[i], wanted.kind, count)) {
            *out = &surfaces->list[i];
            return WEFT_OK;
        }
    const enum weft_result res = link(gl, log, &wanted);
    if (res != WEFT_OK)
        return res;
    struct scene_surface *place = &surfaces->list[surfaces->next];
    if (surfaces->count == SCENE_MAX_SURFACES)
        gl->DeleteProgram(place->program);
    else
        surfaces->count++;
    surfaces->next = (surfaces->next + 1) % SCENE_MAX_SURFACES;
    *place = wanted;
    *out = place;
    return WEFT_OK;
}
