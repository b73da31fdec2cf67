// SPDX-License-Identifier: BSD-3-Clause
// tools/render/scene_options.h - the options that say what scene is shown, from where, in what
// light and how large, as verbs share them, and the scenes that come of them.
#ifndef WEFT_TOOLS_RENDER_SCENE_OPTIONS_H
#define WEFT_TOOLS_RENDER_SCENE_OPTIONS_H

#include "tools/common/json.h"
#include "tools/options/options.h"
#include "tools/render/drawing.h"

// A verb's own enum has these side by side, from a `first` on.
enum scene_option {
    SCENE_OPTION_SCENE,
    SCENE_OPTION_SIZE,
    SCENE_OPTION_SEED,
    SCENE_OPTION_TIME,
    SCENE_OPTION_KEYFRAMES,
    SCENE_OPTION_EYE,
    SCENE_OPTION_TARGET,
    SCENE_OPTION_UP,
    SCENE_OPTION_FOV,
    SCENE_OPTION_LIGHT,
    SCENE_OPTION_SHADOW_SIZE,
    SCENE_OPTION_COUNT
};

// For the verbs' tables. which: what stands for no name, and how several are written; random: what
// the seed is of; shutter: what is shown of the time; texels: the default of --shadow-size.
#define SCENE_OPTIONS(first, which, random, shutter, texels)                                       \
    [first + SCENE_OPTION_SCENE] = {.name = "scene",                                               \
                                    0,                                                             \
                                    OPTION_TEXT,                                                   \
                                    "NAME|FILE",                                                   \
                                    "what is shown: a built-in scene, or the triangles of an "     \
                                    "OBJ, PLY or glTF file; " which,                               \
                                    .group = OPTION_GEOMETRY,                                      \
                                    .brief = "what is drawn; help lists scenes"},                  \
             [first + SCENE_OPTION_SIZE] = {.name = "size",                                        \
                                            0,                                                     \
                                            OPTION_PIXELS,                                         \
                                            "N|WxH",                                               \
                                            "of the picture (default 512x512)",                    \
                                            .group = OPTION_GEOMETRY,                              \
                                            .brief = "pixels"},                                    \
             [first + SCENE_OPTION_SEED] = {.name = "seed",                                        \
                                            0,                                                     \
                                            OPTION_NUMBER,                                         \
                                            "N",                                                   \
                                            "of what is random: " random " (default 0)",           \
                                            .group = OPTION_METHOD},                               \
             [first + SCENE_OPTION_TIME] =                                                         \
                 {.name = "time", 0, OPTION_SPAN, "T|A..B", shutter, .group = OPTION_GEOMETRY},    \
             [first + SCENE_OPTION_KEYFRAMES] = {.name = "keyframes",                              \
                                                 0,                                                \
                                                 OPTION_TEXT,                                      \
                                                 "FILE",                                           \
                                                 "paths of objects and of the camera: lines NAME " \
                                                 "TIME X,Y,Z [AXIS_X,AXIS_Y,AXIS_Z,DEGREES "       \
                                                 "[SCALE]]; NAME is an object's, * for all or "    \
                                                 "camera",                                         \
                                                 .group = OPTION_GEOMETRY,                         \
                                                 .names = OPTION_NAMES_FILE},                      \
             [first + SCENE_OPTION_EYE] = {.name = "eye",                                          \
                                           0,                                                      \
                                           OPTION_POINT,                                           \
                                           "X,Y,Z",                                                \
                                           "where the camera is",                                  \
                                           .group = OPTION_GEOMETRY},                              \
             [first + SCENE_OPTION_TARGET] = {.name = "target",                                    \
                                              0,                                                   \
                                              OPTION_POINT,                                        \
                                              "X,Y,Z",                                             \
                                              "what it looks at",                                  \
                                              .group = OPTION_GEOMETRY},                           \
             [first + SCENE_OPTION_UP] = {.name = "up",                                            \
                                          0,                                                       \
                                          OPTION_POINT,                                            \
                                          "X,Y,Z",                                                 \
                                          "what is up in the picture",                             \
                                          .group = OPTION_GEOMETRY},                               \
             [first + SCENE_OPTION_FOV] = {.name = "fov",                                          \
                                           0,                                                      \
                                           OPTION_NUMBER,                                          \
                                           "DEGREES",                                              \
                                           "angle that the picture's height is seen under",        \
                                           .group = OPTION_GEOMETRY},                              \
             [first + SCENE_OPTION_LIGHT] = {.name = "light",                                      \
                                             0,                                                    \
                                             OPTION_POINT,                                         \
                                             "X,Y,Z",                                              \
                                             "moves the scene's first lamp there, turned to the "  \
                                             "scene's middle",                                     \
                                             .group = OPTION_TASK},                                \
             [first + SCENE_OPTION_SHADOW_SIZE] = {.name = "shadow-size",                          \
                                                   0,                                              \
                                                   OPTION_NUMBER,                                  \
                                                   "TEXELS",                                       \
                                                   "along a side of shadow maps (default " texels  \
                                                   ")",                                            \
                                                   .group = OPTION_TASK}

// What the options say, as far as no scene is needed.
struct scene_request {
    const struct option_value *option; // the first one, borrowed
    int size[2];                       // of the picture: 512 x 512, or what was given
    uint64_t seed;
    double time[2];  // within 0 to 1, ascending: 0 to 1, or what was given
    int shadow_size; // 0: was not given
};

// Fills *out. Returns WEFT_ERR_ARGUMENT after an error line that has the option, its value and the
// range.
enum weft_result scene_options_read(const struct option_value *first, struct scene_request *out);

// Makes the scene of a name, changed as the options say. nearest: the depth that the near plane
// must be before; INFINITY: any. On failure *out may hold a part, for scene_clear. Returns
// scene_make's errors, scene_read_keys' or weft_camera_compute's, or WEFT_ERR_ARGUMENT (--light,
// and there is no lamp that can be moved), after an error line.
enum weft_result scene_options_make(const struct scene_request *request, const char *name,
                                    double nearest, struct scene *out);

// That a scene has lamps where --shadow-size is given. Returns WEFT_ERR_ARGUMENT after an error
// line.
enum weft_result scene_options_check_shadows(const struct scene_request *request,
                                             const struct scene *scene);
// Says that a scene has no lamp for an option ("--light"; why: "can be moved"). Returns
// WEFT_ERR_ARGUMENT.
enum weft_result scene_options_fail_lamp(const char *option, const struct scene *scene,
                                         const char *why);

// A scene for a report, by the name that it was asked for; and how its shadows were found.
json_t *scene_options_json(const char *name, const struct scene *scene);
json_t *scene_options_shadow_json(const struct scene_shadow_info *shadow);

// Prints the names of all scenes on stdout.
void scene_options_print_scenes(void);

#endif
