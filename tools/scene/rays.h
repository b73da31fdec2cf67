// SPDX-License-Identifier: BSD-3-Clause
// tools/scene/rays.h - a scene's triangles where they lie at a time, in double, and what a ray hits
// of them. Each ray is tested against the boxes of runs of triangles, and against each triangle of
// those that it meets: as neighbours in a mesh mostly are neighbours in its list, too, thousands of
// rays and a hundred thousand triangles take seconds.
#ifndef WEFT_TOOLS_SCENE_RAYS_H
#define WEFT_TOOLS_SCENE_RAYS_H

#include "tools/scene/scene.h"

// A triangle, in the scene's coordinates.
struct scene_triangle {
    double corner[3][3]; // counterclockwise seen from its front
    double normal[3];    // of the plane, to its front, of length 1
    double area;         // > 0
    uint32_t vertex[3];  // places of its corners in the scene's list
    int material;        // its place in the scene's list
};

// What bounds a run of triangles, wider than they are by 1e-9 of the largest coordinate of all:
// rays are to start no farther away than some thousand times that.
struct scene_bounds {
    double low[3], high[3];
};

enum { SCENE_RUN = 32 };

// All of them that have an area. All zero: none.
struct scene_triangles {
    const struct scene *scene;   // that they are of; borrowed
    struct scene_triangle *list; // owned; in the order of objects and indices
    size_t count;
    struct scene_bounds *run; // owned; of each SCENE_RUN of them in a row, the last may have fewer
};

// Where a ray meets a triangle.
struct scene_hit {
    size_t triangle;
    double distance;  // along the ray, in lengths of its direction
    double weight[3]; // of the corners, each >= 0, with the sum 1
    bool back;        // the ray comes from its back
};

// Moves every triangle to its place at a time. On failure *out is all zero. Returns
// WEFT_ERR_MEMORY.
enum weft_result scene_triangles_make(const struct scene *scene, double time,
                                      struct scene_triangles *out);
void scene_triangles_clear(struct scene_triangles *triangles); // accepts NULL, leaves zeros behind

// Finds the nearest triangle that a ray hits, from `origin` along `direction` (of any length but
// 0). No ray slips through between two triangles that have an edge in common (Woop, Benthin, Wald,
// "Watertight Ray/Triangle Intersection", Journal of Computer Graphics Techniques 2(1), 2013).
// Backs of one-sided materials are not there, neither is the triangle `from`, which the ray starts
// on (SIZE_MAX: none), nor what is at `most` lengths of the direction or farther (INFINITY: all
// counts). Returns whether there is one; *out (NULL: not wanted) is then filled.
bool scene_triangles_hit(const struct scene_triangles *triangles, const double origin[3],
                         const double direction[3], size_t from, double most,
                         struct scene_hit *out);

// Writes the point of a triangle, each weight of its corners at least 1e-9: within the triangle,
// not on its rim, so that a ray from there has its neighbours before it.
void scene_triangle_point(const struct scene_triangle *triangle, const double weight[3],
                          double point[3]);

// Writes the diffuse reflectance at a point of a triangle, RGB in 0 to 1: the material's, times the
// corners' colours, with its pattern. Unlit materials throw no light back: 0.
void scene_triangle_reflectance(const struct scene_triangles *triangles, size_t triangle,
                                const double weight[3], double reflectance[3]);

#endif
