// SPDX-License-Identifier: BSD-3-Clause
// tools/render/surface.h - programs that draw surfaces in the light of a frame, and what else
// passes of anti-aliasing draw; inside of tools/render. The context is current.
//
// One program for each head and kind of stage; of surfaces also for each list of kinds of lights:
// which shadow maps they have, how their light falls, whether they shine to one side, whether they
// are clamped. All have the same vertex shader.
#ifndef WEFT_TOOLS_RENDER_SURFACE_H
#define WEFT_TOOLS_RENDER_SURFACE_H

#include "tools/render/shadow.h"

// Uniforms of a program that are not shadow.h's.
enum scene_surface_uniform {
    SCENE_CLIP,
    SCENE_MODEL,
    SCENE_TURN,
    SCENE_PLANES,
    SCENE_SURFACES,
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

// What a program is for.
struct scene_surface_use {
    const char *head;                // of its fragment shader
    enum weft_antialias_stage stage; // points have the program of lines; all but colour have no
                                     // lights
    struct scene_light_kind kind[SCENE_MAX_LIGHTS];
    int light_count;
};

struct scene_surface {
    struct scene_surface_use use;
    char *head; // a copy, which `use` has, too; owned
    GLuint program;
    GLint at[SCENE_SURFACE_UNIFORM_COUNT];
    GLint shadow_at[SCENE_SHADOW_UNIFORM_COUNT];
};

// Those that were linked; the oldest one goes where there are too many. All zero: none.
enum { SCENE_MAX_SURFACES = 32 };
struct scene_surfaces {
    struct scene_surface list[SCENE_MAX_SURFACES];
    int count, next;
    GLuint vertex; // the shader of all
};
void scene_surfaces_end(const GladGLContext *gl, struct scene_surfaces *surfaces);

// The head that draws into a target of one colour.
extern const char scene_surface_head[];

// Finds or links the program of a stage with a head, in the light of a frame with its maps. Returns
// WEFT_ERR_GL or WEFT_ERR_MEMORY.
enum weft_result scene_surfaces_find(const GladGLContext *gl, const struct weft_log *log,
                                     struct scene_surfaces *surfaces,
                                     enum weft_antialias_stage stage, const char *head,
                                     const struct scene_shadow_view *view,
                                     const struct scene_point_light *light, int count,
                                     const struct scene_surface **out);

#endif
