// SPDX-License-Identifier: BSD-3-Clause
// tools/scene/scene.h - small scenes for the command, benches and tests: triangles, plain
// materials, a perspective camera, a few lights. Applications bring their own drawing instead
// (passes/accumulate/accumulate.h).
//
// Colours are linear light. Lengths are in the scene's unit. Time runs from 0 to 1; what moves has
// keyframes over it. Corners of a triangle go counterclockwise seen from its front; vertices'
// normals are the front's, and a back that is seen has them reversed.
//
// What emits, each thing once. Lamps are `lights`: soft shadows and plain drawing light the scene
// by them alone. A lamp that is `seen` stands among the triangles as well, with its radiance as its
// material's emission, so that instant radiosity starts from all triangles that emit and from the
// lamps that are not seen, and counts nothing twice; lamps of another falloff than that of radiance
// have no power to start with. Emission leaves a triangle's front only.
//
// A scene that is made changes no more: any number of threads may read it.
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
// A path: between keys positions and scales are linear, rotations go along the shorter great circle
// (Shoemake, "Animating rotation with quaternion curves", SIGGRAPH 1985); before the first and
// after the last key it rests. No keys: it stays where it is modelled.
struct scene_path {
    struct scene_key *keys; // owned by the scene
    int count;              // up to SCENE_MAX_KEYS
};
// The key of a time. No keys: position 0, no rotation, scale 1.
struct scene_key scene_path_key(const struct scene_path *path, double time);
// The same as a matrix, column by column, of modelled points: move * rotate * scale. Normals take
// its upper 3 x 3 and are made of length 1 again, as scales are alike along all axes.
void scene_path_at(const struct scene_path *path, double time, double matrix[16]);

// ---- what is seen -------------------------------------------------------------------------------

enum scene_pattern {
    SCENE_PLAIN,
    SCENE_CHECKER, // squares of 1 / frequency of uv: reflectance where floor(u frequency) +
                   // floor(v frequency) is even, a quarter of it elsewhere
    SCENE_PATTERN_COUNT
};

struct scene_material {
    char name[SCENE_NAME];
    float reflectance[3]; // diffuse (Lambert), 0 to 1; multiplied by the vertices' colours
    float emission[3];    // radiance of the front; it is added, unlit or not
    enum scene_pattern pattern;
    float frequency;   // of the pattern, squares per unit of uv
    bool unlit;        // it shows reflectance * colour, whatever the lights
    bool single_sided; // seen from its back it is not there, and casts no shadow; others have two
                       // sides
};

// Triangles that move together and have one material.
struct scene_object {
    char name[SCENE_NAME];
    uint32_t first_index, index_count; // three a triangle
    int material;
    struct scene_path path; // of its vertices, which no other object uses
};

// A lamp: a flat one that shines to the side of its normal, or a point. It does not move.
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
    SCENE_FALLOFF_COSINE, // the cosine at the lit surface alone, as of a lamp far away: what faces
                          // it has reflectance * radiance * cosine
    SCENE_FALLOFF_NONE,   // the same everywhere: what is lit has reflectance * radiance, so that
                          // the picture shows the visible share of the light
    SCENE_FALLOFF_COUNT
};
struct scene_light {
    enum scene_light_shape shape;
    enum scene_falloff falloff;
    double middle[3], u[3], v[3]; // it shines to the side of u x v; a square's edges, whole ones
    double radiance[3];           // RGB
    bool seen; // it is an object of the scene, too ("light"), flat and one-sided, of no reflectance
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
    double low[3], high[3];        // see scene_find_box
    char source[200];              // where its numbers come from, one line; "": weft's own
};
void scene_clear(struct scene *scene); // accepts NULL, leaves zeros behind

// Sets low and high to the box of all triangles, as they lie at every key of their paths and 16
// times between each two. What turns may leave it by 1/200 of its size. No triangles: 0.
void scene_find_box(struct scene *scene);

// A built-in scene.
struct scene_info {
    const char *name, *description; // one line
    const char *arguments;          // "[:N[,PIXELS]]"; NULL: none
    // Fills *out, which is all zero; `arguments` is what stands behind the colon, or NULL. Where it
    // has none, scene_make has refused them.
    enum weft_result (*make)(const struct weft_log *log, const char *arguments, uint64_t seed,
                             const int size[2], struct scene *out);
};
// cube (RGB colour cube), cornell, furnace, polygons, plane, moving, penumbra; NULL-ended.
extern const struct scene_info *const scene_list[];

// The scenes that show an effect ("fade", "motion-blur", "antialias", "dof", "soft-shadow",
// "radiosity") when none is named: one, of fade two; NULL-ended. NULL: there is no such effect.
const char *const *scene_find_default(const char *effect);

// Makes the scene that a user named: a built-in one ("polygons:4000,50"), or a file that ends in
// .obj, .ply, .gltf or .glb, with a camera that sees all of it and a square light above. On failure
// *out is all zero. Returns weft_mesh_load's errors, or after a line that says what and why
// WEFT_ERR_ARGUMENT (the name, with the list of those there are; its arguments; the size),
// WEFT_ERR_LIMIT or WEFT_ERR_MEMORY. The same parameters give the same bytes everywhere.
struct scene_params {
    const char *name;           // required
    uint64_t seed;              // of what is random
    int size[2];                // of the picture in pixels, 1 to 65536 each (required); what is
                                // given in pixels depends on it, and where a file's camera stands
    struct weft_limits limits;  // of the reader of files
    const struct weft_log *log; // borrowed until the call returns; may be NULL
};
#define SCENE_DEFAULTS
#define scene_params(...) (&(struct scene_params){SCENE_DEFAULTS __VA_ARGS__})
enum weft_result scene_make(const struct scene_params *params, struct scene *out);

// Reads keyframes: lines of a file
//     NAME TIME X,Y,Z [AXIS_X,AXIS_Y,AXIS_Z,DEGREES [SCALE]]
// NAME being that of objects, * for all that no line names, or "camera", which has no scale; it
// stands in double quotes where it has blanks. Numbers are within +-1e30, a scale is above 0, an
// axis may have any length, times of a name ascend. What follows # does not count. Paths that are
// there are replaced, the box is found anew. The rotation between two keys is the shorter one: a
// turn of more than 180 degrees needs a key on its way. On failure the scene is as it was. Returns
// WEFT_ERR_ARGUMENT (no such name), or WEFT_ERR_OPEN, WEFT_ERR_FORMAT, WEFT_ERR_LIMIT (4096 keys of
// a name, 1024 names) or WEFT_ERR_MEMORY, after a line that names the file's line and what is
// wrong.
enum weft_result scene_read_keys(const struct weft_log *log, const char *path, struct scene *scene);

// ---- what a picture of it needs -----------------------------------------------------------------

// The camera at a time: moved and turned about its eye by its path.
void scene_camera_at(const struct scene *scene, double time, struct weft_camera *out);

// The longest motion on the screen, in pixels, over a time that the shutter is open: the way of the
// fastest point in sight, over 64 equal parts of the time (with what is on its way between keys),
// 64 times over. What moves evenly has moved so far; copies of what does not are so far apart at
// most, in 1/64 of the time. Points are the corners of the part of each triangle that is in sight
// when a part of the time starts: beyond the near plane, and in the picture or 1/8 of its size
// beside it. Hidden ones count. 0: nothing moves, or the time is empty.
double scene_longest_motion(const struct scene *scene, const int size[2], double from, double to);

// Nearest and farthest depth, along the direction of sight, of the parts of triangles that are in
// the picture at a time, hidden ones too; both NAN where nothing is.
void scene_depths(const struct scene *scene, const int size[2], double time, double *nearest,
                  double *farthest);

// The widest penumbra in pixels at a time, estimated. Of 48 x 48 points of the picture (fewer, but
// 12 x 12, of a scene of more than 30,000 triangles) each that sees a surface turned to a lamp
// looks at its middle and close to its four corners. What is between, at the share t of the way
// from the lamp, makes a penumbra of s (1 - t) / t there (as wide as on a surface that is parallel
// to the lamp), s being the longer of u and v; at the surface's depth that is so many pixels
// across, seen straight on. Penumbrae that fall between the points, and how tilted surfaces stretch
// or shorten them, are not counted. 0: no lamp has an area, or no shadow is seen; NAN: memory ran
// out.
double scene_widest_penumbra(const struct scene *scene, const int size[2], double time);

#endif
