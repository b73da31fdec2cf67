// SPDX-License-Identifier: BSD-3-Clause
// tools/scene/scene.h - small scenes for the command, benches and tests: triangles, plain
// materials, a perspective camera, a few lights. Applications bring their own drawing instead
// (passes/accumulate/accumulate.h).
//
// Colours are linear light. Lengths are in the scene's unit. Time runs from 0 to 1; what moves has
// keyframes over it.
#ifndef WEFT_TOOLS_SCENE_SCENE_H
#define WEFT_TOOLS_SCENE_SCENE_H

#include "weft.h"

enum { SCENE_NAME = 64, SCENE_MAX_LIGHTS = 8, SCENE_MAX_KEYS = 4096 };

// ---- what moves ---------------------------------------------------------------------------------

// Where something is at a time.
struct scene_key {
    double time;        // ascending over a path's keys
    double position[3]; // it is moved there from where it is modelled
    double rotation[4]; // unit quaternion (x, y, z, w), about its own origin, before it is moved
    double scale;       // before that, > 0
};
// A path: between keys positions and scales are linear, rotations go along the great circle; before
// the first and after the last key it rests. No keys: it stays where it is modelled.
struct scene_path {
    struct scene_key *keys; // owned by the scene
    int count;
};
// The path's place at a time as a matrix, column by column, and of normals its upper 3 x 3 rotated.
void scene_path_at(const struct scene_path *path, double time, double matrix[16]);

// ---- what is seen -------------------------------------------------------------------------------

enum scene_pattern {
    SCENE_PLAIN,
    SCENE_CHECKER, // squares of 1 / frequency of uv, reflectance and a quarter of it
    SCENE_PATTERN_COUNT
};

struct scene_material {
    char name[SCENE_NAME];
    float reflectance[3]; // diffuse (Lambert), 0 to 1; multiplied by the vertices' colours
    float emission[3];    // radiance
    enum scene_pattern pattern;
    float frequency;   // of the pattern, squares per unit of uv
    bool unlit;        // it shows its reflectance, whatever the lights
    bool single_sided; // seen from its back it is not there, and casts no shadow; others have two
                       // sides
};

// Triangles that move together and have one material.
struct scene_object {
    char name[SCENE_NAME];
    uint32_t first_index, index_count; // three a triangle
    int material;
    struct scene_path path;
};

// A light that shines by itself, not by a material's emission: a flat one that emits to the side of
// its normal, or a point.
enum scene_light_shape {
    SCENE_LIGHT_POINT,
    SCENE_LIGHT_SQUARE, // a parallelogram: middle, edges u and v
    SCENE_LIGHT_DISC,   // an ellipse of the diameters u and v
    SCENE_LIGHT_SHAPE_COUNT
};
// How light falls on surfaces.
enum scene_falloff {
    SCENE_FALLOFF_RADIANCE, // of a surface: cosines at both ends, 1 / distance^2; of a point,
                            // whose `radiance` is an intensity, without the first cosine
    SCENE_FALLOFF_NONE,     // the same everywhere: what is lit has reflectance * radiance, so that
                            // the picture shows the visible share of the light
    SCENE_FALLOFF_COUNT
};
struct scene_light {
    enum scene_light_shape shape;
    enum scene_falloff falloff;
    double middle[3], u[3], v[3]; // it shines to the side of u x v
    double radiance[3];           // RGB
    bool seen; // it is drawn, as a surface that emits; part of the triangles then, too
};

// ---- all of it ----------------------------------------------------------------------------------

// A scene. All zero: none.
struct scene {
    char name[SCENE_NAME]; // "cornell", or a file's
    struct weft_mesh_vertex *vertices;
    size_t vertex_count;
    uint32_t *indices;
    size_t index_count;
    struct scene_object *objects;
    int object_count;
    struct scene_material *materials;
    int material_count;
    struct scene_light lights[SCENE_MAX_LIGHTS];
    int light_count;
    double ambient[3]; // light from everywhere, without shadows: reflectance * ambient is added
    struct weft_camera camera;
    struct scene_path camera_path; // moves and turns the camera; the eye is its origin
    double background[4];          // linear, associated alpha
    double low[3], high[3];        // the box of everything at every key, of vertices as they move
    char source[200];              // where its numbers come from, one line; "": weft's own
};
void scene_clear(struct scene *scene); // accepts NULL, leaves zeros behind

// A built-in scene.
struct scene_info {
    const char *name, *description; // one line
    const char *arguments;          // "[:N[,PIXELS]]"; NULL: none
    // Fills *out, which is all zero; `arguments` is what stands behind the colon, or NULL.
    enum weft_result (*make)(const struct weft_log *log, const char *arguments, uint64_t seed,
                             const int size[2], struct scene *out);
};
// cube (RGB colour cube), cornell, furnace, polygons, plane, moving, penumbra; NULL-ended.
extern const struct scene_info *const scene_list[];

// Makes the scene that a user named: a built-in one ("polygons:4000,50"), or a file that ends in
// .obj, .ply, .gltf or .glb, with a camera that sees all of it and a square light above. On failure
// *out is all zero; errors are weft_mesh_load's, or WEFT_ERR_ARGUMENT with the list of names.
struct scene_params {
    const char *name;           // required
    uint64_t seed;              // of what is random
    int size[2];                // of the picture in pixels; what is given in pixels depends on it
    struct weft_limits limits;  // of the reader of files
    const struct weft_log *log; // may be NULL
};
enum weft_result scene_make(const struct scene_params *params, struct scene *out);

// Reads keyframes: lines of a file
//     NAME TIME X,Y,Z [AXIS_X,AXIS_Y,AXIS_Z,DEGREES [SCALE]]
// NAME being an object's, * for all of them, or "camera". Paths that are there are replaced. What
// follows # does not count. Returns WEFT_ERR_ARGUMENT, WEFT_ERR_OPEN or WEFT_ERR_FORMAT after a
// line that names the line and what is wrong.
enum weft_result scene_read_keys(const struct weft_log *log, const char *path, struct scene *scene);

// The camera at a time.
void scene_camera_at(const struct scene *scene, double time, struct weft_camera *out);
// The path of a scene's vertex on the screen: the longest, in pixels, over the given time, sampled
// at its keys and 64 times besides. What is behind the near plane does not count.
double scene_longest_motion(const struct scene *scene, const int size[2], double from, double to);
// Nearest and farthest depth of what is in sight at a time; both NAN where nothing is.
void scene_depths(const struct scene *scene, const int size[2], double time, double *nearest,
                  double *farthest);
// The widest penumbra in pixels that a light makes on what is in sight, from the box of the scene:
// an upper estimate; see the source.
double scene_widest_penumbra(const struct scene *scene, const int size[2]);

#endif
