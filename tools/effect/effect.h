// SPDX-License-Identifier: BSD-3-Clause
// tools/effect/effect.h - effects by accumulation (Haeberli and Akeley 1990): what each frame of a
// picture shows, planned, and the frames drawn and accumulated.
//
// Each frame is one sample of an integral over all dimensions that the effects have: place in the
// pixel's filter, place on the lens, time, place on each lamp, scene of a fade, virtual light. Each
// dimension has its own evenly spread set; sets are joined in orders of their own, by the seed, so
// that no two dimensions go together.
#ifndef WEFT_TOOLS_EFFECT_EFFECT_H
#define WEFT_TOOLS_EFFECT_EFFECT_H

#include "tools/scene/drawing.h"

// What is asked for, to be added up with |.
enum effect_bit {
    EFFECT_FADE = 1,
    EFFECT_MOTION_BLUR = 2,
    EFFECT_ANTIALIAS = 4,
    EFFECT_DOF = 8,
    EFFECT_SOFT_SHADOW = 16,
    EFFECT_RADIOSITY = 32,
    EFFECT_COUNT = 6
};
extern const char *const effect_names[]; // "fade", "motion-blur", ...; NULL-ended, in bits' order

// "antialias+dof" as bits. Returns WEFT_ERR_ARGUMENT after a line with the list.
enum weft_result effect_parse(const struct weft_log *log, const char *text, unsigned *out);

enum { EFFECT_MAX_SCENES = 16, EFFECT_MAX_FRAMES = 1 << 20 };

// What is planned. What an effect that is not asked for needs is not looked at.
struct effect_params {
    unsigned effects;                             // (required)
    const struct scene *scene[EFFECT_MAX_SCENES]; // of fade several (required)
    int scene_count;
    double fade[EFFECT_MAX_SCENES]; // weights of the scenes
    int size[2];                    // of the picture in pixels (required)
    int64_t frames;                 // 0: from what the picture needs
    // Places in the pixel; count is that of frames. NULL: a table of as many points where there is
    // one, else sobol. The lens and lamps have such a set, too.
    const struct weft_jitter_info *jitter;
    bool centre;                 // its mean is taken off
    struct weft_kernel filter;   // of a pixel (default a box of one pixel)
    double filter_width;         // 0: the kernel's
    double time[2];              // that the shutter is open (default 0 to 1)
    struct weft_shutter shutter; // default: a box
    double aperture, focus;      // of the lens, in the scene's unit
    bool paths;   // of radiosity: `frames` counts paths from the lamps, not virtual lights
    double clamp; // of radiosity: see struct scene_point_light, `most`; 0: none
    uint64_t seed;
    const struct weft_log *log; // may be NULL
};
#define EFFECT_DEFAULTS .time = {0.0, 1.0}, .shutter = WEFT_SHUTTER_BOX,
#define effect_params(...) (&(struct effect_params){EFFECT_DEFAULTS __VA_ARGS__})

// One frame of it.
struct effect_frame {
    int scene;     // its place in the list
    double weight; // of all, adds up to 1
    struct scene_frame show;
};

// Why there are so many frames: what each effect needs.
struct effect_need {
    int64_t frames; // 0: the effect does not ask
    double figure;  // pixels of motion, of the circle of confusion, of the penumbra
};

// All frames. All zero: none.
struct effect_plan {
    unsigned effects;
    int64_t count;
    struct effect_frame *frames; // owned
    struct effect_need need[EFFECT_COUNT];
    const struct weft_jitter_info *jitter; // what places in the pixel, on lens and lamps are of
    double mean[2], shift[2];              // of the pixel's set: struct weft_jitter
    double discrepancy;                    // of half-planes, of the pixel's set; NAN: none
    struct weft_weights_report weights;    // of the frames
    bool extends;  // any number of first frames is a smaller picture of the same
    int64_t paths; // of radiosity
    double mean_reflectance;
};

// Returns WEFT_ERR_ARGUMENT after a line that says which member is wrong and how, WEFT_ERR_LIMIT or
// WEFT_ERR_MEMORY. On failure *out is all zero.
enum weft_result effect_plan_make(const struct effect_params *params, struct effect_plan *out);
void effect_plan_clear(struct effect_plan *plan); // accepts NULL

// ---- virtual lights (Keller, "Instant Radiosity", SIGGRAPH 1997)
// -----------------------------------

// Where light starts or is thrown back, to be drawn once each.
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
    double clamp;
    double time; // of the scene
    const struct weft_log *log;
};
// Returns WEFT_ERR_ARGUMENT (nothing emits, a reflectance of 1 everywhere) or WEFT_ERR_MEMORY.
enum weft_result effect_lights_make(const struct effect_lights_params *params,
                                    struct effect_virtual_lights *out);
void effect_lights_clear(struct effect_virtual_lights *lights);

// ---- running ------------------------------------------------------------------------------------

// Draws and adds frames of a plan to an accumulator of 4 channels, RGBA, of the plan's size.
struct effect_run_params {
    const struct effect_plan *plan;
    scene_drawing *const *drawing; // one a scene of the plan
    weft_accumulator *accumulator;
    int64_t first, count;                 // frames of the plan
    const struct weft_progress *progress; // may be NULL
};
// Returns WEFT_ERR_CANCELLED, what weft_accumulator_add returned.
enum weft_result effect_run(const struct effect_run_params *params);

#endif
