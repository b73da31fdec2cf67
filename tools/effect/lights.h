// SPDX-License-Identifier: BSD-3-Clause
// tools/effect/lights.h - virtual lights (Keller, "Instant Radiosity", SIGGRAPH 1997): where light
// starts, or is thrown back, to be drawn once each.
#ifndef WEFT_TOOLS_EFFECT_LIGHTS_H
#define WEFT_TOOLS_EFFECT_LIGHTS_H

#include "tools/scene/drawing.h"

// Virtual lights of a scene. All zero: none.
struct effect_virtual_lights {
    struct scene_point_light *light; // owned; intensities are such that the mean over all is the
                                     // picture
    int64_t count, paths;
    double mean_reflectance; // of the scene, by area
};
struct effect_lights_params {
    const struct scene *scene;
    int64_t count; // virtual lights, or with `paths` paths (required)
    bool paths;
    uint64_t seed; // shifts the sequence (Cranley-Patterson); 0: as it is
    double clamp;  // see struct scene_point_light, `most`; 0: none
    double time;   // of the scene
    const struct weft_log *log;
};
#define EFFECT_LIGHTS_DEFAULTS
#define effect_lights_params(...)                                                                  \
    (&(struct effect_lights_params){EFFECT_LIGHTS_DEFAULTS __VA_ARGS__})

// On failure *out is all zero. Returns WEFT_ERR_ARGUMENT (nothing emits, a reflectance of 1
// everywhere) or WEFT_ERR_MEMORY.
enum weft_result effect_lights_make(const struct effect_lights_params *params,
                                    struct effect_virtual_lights *out);
void effect_lights_clear(struct effect_virtual_lights *lights); // accepts NULL

#endif
