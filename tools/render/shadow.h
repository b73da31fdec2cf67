// SPDX-License-Identifier: BSD-3-Clause
// tools/render/shadow.h - shadow maps on OpenGL; inside of tools/render. The context is current.
#ifndef WEFT_TOOLS_RENDER_SHADOW_H
#define WEFT_TOOLS_RENDER_SHADOW_H

#include "tools/render/casters.h"
#include "tools/render/gl/gl.h"
#include "tools/render/shadow_view.h"

// A scene as it is drawn into maps; all of it is borrowed.
struct scene_shadow_casting {
    const struct scene *scene;
    const struct scene_extent *extent; // of each object
    const struct scene_hull *hull;     // likewise
    const double (*model)[16];         // where each lies
    struct scene_caster *caster;       // room for all objects
    int *object;                       // likewise: which one a caster is
    double diagonal;                   // of the scene's box
};

enum { SCENE_SHADOW_LEAST = 4 }; // texels along a side

// Maps of all lights: layers of one array of depths, 32 bits each. All zero: none.
struct scene_shadows {
    GLuint program, texture;
    GLuint framebuffer[SCENE_MAX_LIGHTS * SCENE_SHADOW_LAYERS]; // one a layer
    GLint clip;                                                 // the program's uniform
    int size, layers;
    int faces; // that were drawn last
    struct scene_shadow_view view[SCENE_MAX_LIGHTS];
    int first_layer[SCENE_MAX_LIGHTS];
};

// Returns WEFT_ERR_LIMIT (the size), WEFT_ERR_GL.
enum weft_result scene_shadows_make(const GladGLContext *gl, const struct weft_log *log, int size,
                                    struct scene_shadows *out);
void scene_shadows_end(const GladGLContext *gl, struct scene_shadows *shadows); // all zero: nothing

// Draws the maps of a frame's lights. It leaves framebuffer, viewport and program behind.
// Errors are GL's.
void scene_shadows_draw(const GladGLContext *gl, struct scene_shadows *shadows,
                        const struct scene_shadow_casting *casting,
                        const struct scene_point_light *light, int count);

// Uniforms of shadow.glsl in a program.
enum scene_shadow_uniform {
    SCENE_SHADOW_MAPS,
    SCENE_SHADOW_EYE,
    SCENE_SHADOW_FRAME,
    SCENE_SHADOW_WINDOW,
    SCENE_SHADOW_NEAR,
    SCENE_SHADOW_LAYER,
    SCENE_SHADOW_LIFT,
    SCENE_SHADOW_BIAS,
    SCENE_SHADOW_UNIFORM_COUNT
};
void scene_shadows_find_uniforms(const GladGLContext *gl, GLuint program,
                                 GLint out[SCENE_SHADOW_UNIFORM_COUNT]);
// Sets them in the program that is used, for `count` lights; maps are bound to texture unit `unit`.
// The shader's lengths are in diagonals of the scene's box, from its middle.
void scene_shadows_use(const GladGLContext *gl, const struct scene_shadows *shadows,
                       const GLint uniform[SCENE_SHADOW_UNIFORM_COUNT], int count, int unit,
                       const double middle[3], double diagonal);

// 2^(1 - bits by which corners are placed in a pixel): texels that slopes are biased by.
double scene_shadows_get_bias(const GladGLContext *gl);

#endif
