// SPDX-License-Identifier: BSD-3-Clause
// tools/effect/lights/lights.h - virtual lights (Keller, "Instant Radiosity", SIGGRAPH 1997):
// points where light starts or is thrown back. A picture drawn with each of them alone, with
// shadows, is a frame; the mean of all frames is the picture with all the light that diffuse
// surfaces throw at each other.
//
// Particles start on what emits, chosen by power, and are thrown back in directions distributed as
// the cosine, all of it by Halton's sequence: bases 2 and 3 for the start, the next two primes for
// each bounce. None is absorbed at random: of N paths the first floor(N rho^j) go on to bounce j,
// rho being the mean reflectance of the scene by area. Bounce j counts the mean over as many, so
// that rho decides how the work is shared out and not how bright the picture is. The light of
// bounces that no path reaches is missing: a share of the picture below 1/N in a closed scene of
// even reflectance.
//
// There are two ways to count.
// - `paths`: N is given, and all lights are drawn, as Keller has it: M < N / (1 - rho) of them,
//   fewer where particles leave the scene. Bounces that few paths reach have few, bright lights.
// - otherwise M lights are chosen from those of many more paths, about 16 M: walking takes no time
//   beside drawing. They are chosen by their power, systematically along a curve that visits what
//   faces alike and lies close together, so that each stands for a patch of surface of about the
//   same power. In the Cornell box 1,024 of them have half the error of as many of Keller's.
#ifndef WEFT_TOOLS_EFFECT_LIGHTS_LIGHTS_H
#define WEFT_TOOLS_EFFECT_LIGHTS_LIGHTS_H

#include "tools/render/drawing.h"

enum { EFFECT_MAX_LIGHTS = 1 << 20 }; // virtual lights of a scene

// Virtual lights of a scene at a time. All zero: none.
struct effect_virtual_lights {
    // Owned. Intensities are such that the mean over all is the picture. They come in an order in
    // which the first n, of any n that is not small, are a sample of all of them.
    struct scene_point_light *light;
    int64_t count;           // M
    int64_t paths;           // that were walked: N
    int bounces;             // of the longest path; 0: direct light only
    double mean_reflectance; // rho: of the scene, by area, mean of R, G and B
    double most;             // what the lights' factors are clamped at; 0: not at all
};

// What to make.
struct effect_lights_params {
    const struct scene *scene; // borrowed until the call returns (required)
    int64_t count; // virtual lights, or with `paths` paths, 1 to EFFECT_MAX_LIGHTS (required)
    bool paths;
    uint64_t seed; // shifts the sequence (Cranley and Patterson 1976); 0: as it is
    // Largest factor cos cos / distance^2 that counts, per unit of length squared; 0: all do. NAN
    // (default): pi M / (4 area of all triangles). Each light stands for 1/M of the surfaces; as a
    // patch it would light what is near it with pi times its radiance at most, as it does with pi
    // M / area. A quarter of it, that of a patch twice as wide, hides single lights in pictures of
    // some hundred. What is lost vanishes with many lights.
    double clamp;
    double time;                // of the scene, for what moves
    const struct weft_log *log; // borrowed until the call returns; may be NULL
};
#define EFFECT_LIGHTS_DEFAULTS .clamp = NAN,
#define effect_lights_params(...)                                                                  \
    (&(struct effect_lights_params){EFFECT_LIGHTS_DEFAULTS __VA_ARGS__})

// Makes the lights: starts are all triangles that emit and all lamps that are not seen (scene.h).
// The same parameters give the same lights. It takes about 15 ns for each ray and triangle: paths
// for which that would be 8 s or more are walked in smaller numbers, down to those that make M
// lights. On failure *out is all zero. Returns, after a line,
// WEFT_ERR_ARGUMENT (the count, the clamp, nothing that emits, a reflectance of 1 everywhere,
// a lamp whose light does not fall off), WEFT_ERR_LIMIT (paths that would make more than
// EFFECT_MAX_LIGHTS) or WEFT_ERR_MEMORY.
enum weft_result effect_lights_make(const struct effect_lights_params *params,
                                    struct effect_virtual_lights *out);
void effect_lights_clear(struct effect_virtual_lights *lights); // accepts NULL, leaves zeros behind

#endif
