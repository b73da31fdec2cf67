// SPDX-License-Identifier: BSD-3-Clause
// tools/render/surface.h - programs that draw surfaces in the light of a frame; inside of
// tools/render. The context is current.
//
// One program for each list of kinds of lights: which shadow maps they have, how their light falls,
// whether they shine to one side, whether they are clamped.
#ifndef WEFT_TOOLS_RENDER_SURFACE_H
#define WEFT_TOOLS_RENDER_SURFACE_H

#include "tools/render/shadow.h"

// Uniforms of a program that are not shadow.h's.
enum scene_surface_uniform {
    SCENE_CLIP,
    SCENE_MODEL,
    SCENE_TURN,
    SCENE_PLANES,
    SCENE_FIRST_TRIANGLE,
    SCENE_REFLECTANCE,
    SCENE_EMISSION,
    SCENE_AMBIENT,
    SCENE_CHECKS,
    SCENE_UNLIT,
    SCENE_ONLY_CLAMPED,
    SCENE_LIGHT_POSITION,
    SCENE_LIGHT_NORMAL,
    SCENE_LIGHT_INTENSITY,
    SCENE_LIGHT_MOST,
    SCENE_SURFACE_UNIFORM_COUNT
};

// What a light is to a program.
struct scene_light_kind {
    enum scene_shadow_kind shadow;
    enum scene_falloff falloff;
    bool is_flat, clamped;
};

struct scene_surface {
    struct scene_light_kind kind[SCENE_MAX_LIGHTS];
    int light_count;
    GLuint program;
    GLint at[SCENE_SURFACE_UNIFORM_COUNT];
    GLint shadow_at[SCENE_SHADOW_UNIFORM_COUNT];
};

// Those that were linked; the oldest one goes where there are too many. All zero: none.
enum { SCENE_MAX_SURFACES = 32 };
struct scene_surfaces {
    struct scene_surface list[SCENE_MAX_SURFACES];
    int count, next;
};
void scene_surfaces_end(const GladGLContext *gl, struct scene_surfaces *surfaces);

// Finds or links the program of a frame's lights with their maps. Returns WEFT_ERR_GL.
enum weft_result scene_surfaces_find(const GladGLContext *gl, const struct weft_log *log,
                                     struct scene_surfaces *surfaces,
                                     const struct scene_shadow_view *view,
                                     const struct scene_point_light *light, int count,
                                     const struct scene_surface **out);

#endif
