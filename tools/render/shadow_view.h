// SPDX-License-Identifier: BSD-3-Clause
// tools/render/shadow_view.h - how the shadow maps of a light lie, and the test that they serve;
// inside of tools/render. Pure, without OpenGL.
//
// Maps. Where all that casts shadows can be seen through one face of at most 4 x 4 units of
// tangent (127 degrees), that face is fitted to it: beyond it nothing is hidden. Otherwise, as
// inside a room, a light that shines to one side has half a cube around it - one whole face and
// four halves, which take three layers -, one that shines all around six faces. What lies between
// the light and the near plane counts as lying in that plane (GL_DEPTH_CLAMP). A light on a surface
// is looked from at the height SCENE_SHADOW_HEIGHT * (diagonal of the scene's box) above it.
//
// The test is one of planes. What is lit at P lies in the plane of its triangle; the plane's point
// P' in the middle of P's texel is compared with what the map has there, without any filter: P is
// hidden where P' is, but for
//  - rounding: P' is nearer to the light by 2^(1 - b) texels of the plane's slope, b being the bits
//    by which OpenGL places corners in a pixel (mostly 8; llvmpipe, whose depth is that of the
//    corners as they were, needs none of it), by 2^-22 of depth, and the plane by 2^-21 of the
//    box's diagonal;
//  - smooth surfaces: their planes are raised by what a neighbour that tilts as far as the corners'
//    normals tell rises within half a texel, seen under a cosine of 1/8 or more;
//  - P' beyond the plane's horizon, or twice as far away as P: then a point as far away as that.
// So flat surfaces show no acne under any angle; edges of shadows, and light at contacts, are off
// by half a texel along each axis of the map at most; and where two surfaces meet that do not
// belong to one smooth one, a stripe within half a texel may be as dark as the other surface's
// inside.
#ifndef WEFT_TOOLS_RENDER_SHADOW_VIEW_H
#define WEFT_TOOLS_RENDER_SHADOW_VIEW_H

#include "tools/render/drawing.h"
#include "tools/render/gl/matrix.h"

// To the box's diagonal: of lights above their surfaces, of planes towards lights; of depth.
#define SCENE_SHADOW_HEIGHT 0x1p-14
#define SCENE_SHADOW_RAISED 0x1p-21
#define SCENE_SHADOW_DEPTH 0x1p-22

enum scene_shadow_kind {
    SCENE_SHADOW_NONE, // nothing is hidden
    SCENE_SHADOW_FITTED,
    SCENE_SHADOW_HALF_CUBE,
    SCENE_SHADOW_CUBE,
};

// What can cast shadows in a frame.
struct scene_caster {
    const struct scene_extent *extent;
    const double *model; // 16: where it lies
};

// Maps of one light.
struct scene_shadow_view {
    enum scene_shadow_kind kind;
    double eye[3];
    double axis[3][3];        // right, up and forward, of length 1
    double low[2], extent[2]; // tangents of a fitted face, along right and up
    double near_distance;
};

// One face: x and y of clip space are the face's own, w is the distance along its axis, z is
// w - 2 near, so that a depth buffer holds 1 - near / w.
struct scene_shadow_face {
    double clip[16];
    int layer;  // from the light's first one
    bool lower; // half a layer: the upper or the lower one
    bool half;
    bool mirrored; // fronts are clockwise
};
enum { SCENE_SHADOW_FACES = 6, SCENE_SHADOW_LAYERS = 6 };

// Whether it shines to one side.
bool scene_light_is_flat(const struct scene_point_light *light);

// Where the maps of a light are seen from.
void scene_shadow_eye(const struct scene_point_light *light, double diagonal, double out[3]);

// Finds the maps of a light. diagonal: of the scene's box; size: texels along a side.
void scene_shadow_view_find(const struct scene_point_light *light,
                            const struct scene_caster *caster, int count, double diagonal, int size,
                            struct scene_shadow_view *out);

// Writes its faces, and returns how many there are; *layers: how many layers they take.
int scene_shadow_view_faces(const struct scene_shadow_view *view,
                            struct scene_shadow_face out[SCENE_SHADOW_FACES], int *layers);

#endif
