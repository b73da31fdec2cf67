// SPDX-License-Identifier: BSD-3-Clause
// passes/stability/triangles.h - a scene of triangles for cases of anti-aliasing (not installed).
#ifndef WEFT_PASSES_STABILITY_TRIANGLES_H
#define WEFT_PASSES_STABILITY_TRIANGLES_H

#include "passes/antialias/drawing/drawing.h"
#include "passes/gl/context_backend.h"
#include "passes/stability/stability.h"

enum { WEFT_STABILITY_MOST_TRIANGLES = 64, WEFT_STABILITY_PROGRAMS = 8 };

// One triangle: corners in pixels of the picture, y upwards, and depths from 0 to 1.
struct weft_stability_triangle {
    double corner[3][2], depth[3];
    float colour[3];
    uint32_t surface;
};

// How it is drawn may be changed between pictures.
struct weft_stability_scene {
    int copies;        // of each triangle in the colour pass, at the same place (1: just itself)
    bool depths_apart; // the depth pass has a vertex shader of its own, which multiplies the
                       // scene's matrix and the pass's before the position, not after one another
    // What the rest is about.
    weft_context *context;
    const struct weft_log *log;
    int count; // vertices
    GLuint vertex_array, buffer;
    struct {
        char *key;
        GLuint program;
    } program[WEFT_STABILITY_PROGRAMS];
    int programs;
};

// Uploads triangles of a picture of size x size pixels. To be destroyed in any case. Returns
// WEFT_ERR_GL or WEFT_ERR_MEMORY.
enum weft_result weft_stability_scene_create(const struct weft_stability_params *params, int size,
                                             const struct weft_stability_triangle *triangles,
                                             int count, struct weft_stability_scene *out);
void weft_stability_scene_destroy(struct weft_stability_scene *scene);

// The callback of weft_antialias_drawing.
enum weft_result weft_stability_scene_draw(void *scene, const struct weft_antialias_pass *pass);

#endif
