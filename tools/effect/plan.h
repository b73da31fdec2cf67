// SPDX-License-Identifier: BSD-3-Clause
// tools/effect/plan.h - what each frame of an effect shows.
//
// A frame is one sample of an integral over all dimensions that the effects have: place in the
// pixel's filter, place on the lens, place on each lamp, time, virtual light; and a fade's scenes
// are drawn with all of these, each. Every dimension has an evenly spread set of its own. Sets are
// joined in orders of their own, permuted by the seed, so that no two dimensions go together; an
// effect alone is the textbook's program. A frame's weight is the product of what its dimensions
// give it, divided by the sum over its scene's frames, times the scene's.
//
// Stopped early, a plan is the same picture with fewer frames: orders are such that the first n
// frames are a sample of all. Orders, and all but the places on discs, are the same bytes on every
// machine.
#ifndef WEFT_TOOLS_EFFECT_PLAN_H
#define WEFT_TOOLS_EFFECT_PLAN_H

#include <math.h>

#include "tools/effect/effect.h"
#include "tools/render/drawing.h"

enum {
    EFFECT_MAX_SCENES = 16,
    EFFECT_MAX_FRAMES = 1 << 17,     // of all scenes together; each takes about 1 KB
    EFFECT_MOST_AUTO = 1024,         // frames of a scene that are planned unasked
    EFFECT_FRAMES_ANTIALIAS = 16,    // that it asks for, a pixel's area of its filter
    EFFECT_FRAMES_RADIOSITY = 256,   // likewise: virtual lights, or paths
    EFFECT_MAX_DISCREPANCY = 1 << 10 // points of a set whose discrepancy is computed, in 0.2 s
};

// What is planned. What an effect that is not asked for needs is not looked at.
struct effect_params {
    unsigned effects;                             // of enum effect_bit (required)
    const struct scene *scene[EFFECT_MAX_SCENES]; // borrowed until the call returns (required)
    int scene_count;                              // 1; of fade 2 to EFFECT_MAX_SCENES (required)
    double fade[EFFECT_MAX_SCENES]; // weights of the scenes; default (all 0): even ones. They are
                                    // divided by their sum. A scene of weight 0 has no frames.
    int size[2];                    // of the picture in pixels (required)
    // Frames of each scene. 0: the largest need that an effect has (struct effect_need), up to
    // EFFECT_MOST_AUTO, in a number that the set of samples has.
    int64_t frames;
    // Places in the pixel, on the lens and on lamps: as many as frames. NULL: a table of the
    // Programming Guide where there is one of as many points, else sobol; centred.
    const struct weft_jitter_info *jitter;
    bool centre;               // the mean of each set is taken off
    struct weft_kernel filter; // of a pixel (default nearest, a box: all samples weigh alike)
    double filter_width;       // in pixels, as struct weft_weights_kernel_params; samples fill it
    double time[2];            // that the shutter is open, within 0 to 1 (default 0 to 1). Without
                               // motion-blur the middle is shown.
    struct weft_shutter shutter; // default a box
    double focus; // distance of the plane in focus, beyond the near plane; NAN (default): that of
                  // the camera's target, at the middle of the time
    double aperture; // diameter of the lens, >= 0, in the scene's unit; NAN (default): focus / 20
    bool paths;      // of radiosity: `frames` counts paths from the lamps, not virtual lights
    double clamp;    // of radiosity: struct scene_point_light, `most`; 0: none; NAN (default): what
                     // suits the number of lights (lights.h)
    uint64_t seed;
    const struct weft_log *log; // borrowed until the call returns; may be NULL
};
#define EFFECT_DEFAULTS                                                                            \
    .time = {0.0, 1.0}, .shutter = WEFT_SHUTTER_BOX, .focus = NAN, .aperture = NAN, .clamp = NAN,
#define effect_params(...) (&(struct effect_params){EFFECT_DEFAULTS __VA_ARGS__})

// One frame of it.
struct effect_frame {
    int scene;     // its place in the list
    double weight; // of all frames, they add up to 1; 0: it need not be drawn
    struct scene_frame show;
};

// How many frames of a scene an effect needs, and why.
struct effect_need {
    int64_t frames; // 0: the effect is not asked for, or needs none; counts.h has the rest
    double figure;  // pixels: of the longest motion, of the widest circle of confusion, of the
                    // widest penumbra; 0 of others
};

// Places that frames take: in the pixel, on the lens, on the first lamp that is not a point.
enum effect_place { EFFECT_PIXEL, EFFECT_LENS, EFFECT_LAMP, EFFECT_PLACE_COUNT };
extern const char *const effect_place_names[]; // "pixel", "lens", "lamp"; NULL-ended

// The set that places are of. All zero: there is none; a lens of diameter 0 has none.
struct effect_set {
    const struct weft_jitter_info *info;
    int count;
    enum weft_jitter_shape shape;
    double size;    // side or diameter: of the pixel's filter in pixels, of the lens in the scene's
                    // unit, of a lamp 1
    double mean[2]; // what it shifts the picture by, in that unit: the mean of the points, those of
                    // the pixel by their weights, y down
    double shift[2];    // what centring took off every point
    double discrepancy; // of half-planes (discrepancy.h), all points weighing alike; NAN: of more
                        // than EFFECT_MAX_DISCREPANCY
};

// All frames. All zero: none.
struct effect_plan {
    unsigned effects;
    int size[2];
    int scene_count;
    int64_t count;
    struct effect_frame *frames; // owned
    int64_t needed;              // frames of a scene: the largest need
    struct effect_need need[EFFECT_COUNT];
    struct effect_set set[EFFECT_PLACE_COUNT]; // of the first scene that has frames
    struct weft_weights_report weights;        // of all frames
    // The first n frames of a scene, whatever n, have the first n points of an evenly spread
    // sequence in the first of the dimensions: pixel, lens, lamps or virtual lights, time.
    // Otherwise, and in the dimensions that follow, they have points of the set that were chosen at
    // random.
    bool extends;
    double focus, aperture;  // of dof; else 0
    int64_t paths;           // of radiosity, of all scenes together; else 0
    double mean_reflectance; // likewise, of the first scene that has frames
    double clamp;            // likewise: what is clamped at; 0: nothing is
};

// Plans all frames. On failure *out is all zero. Returns WEFT_ERR_ARGUMENT after a line that says
// which member is wrong and how, WEFT_ERR_UNSUPPORTED (a filter that is no product),
// WEFT_ERR_LIMIT (more than EFFECT_MAX_FRAMES) or WEFT_ERR_MEMORY.
enum weft_result effect_plan_make(const struct effect_params *params, struct effect_plan *out);
void effect_plan_clear(struct effect_plan *plan); // accepts NULL, leaves zeros behind

// Writes the frames' weights, plan->count of them, as weft_accumulator_create takes them.
void effect_plan_get_weights(const struct effect_plan *plan, double *weights);

#endif
