// SPDX-License-Identifier: BSD-3-Clause
// tools/effect/lights/walk.h - particles that start where a scene emits, and are thrown back by
// what they hit, each by its own numbers of a sequence.
#ifndef WEFT_TOOLS_EFFECT_LIGHTS_WALK_H
#define WEFT_TOOLS_EFFECT_LIGHTS_WALK_H

#include "tools/scene/rays.h"

// Where particles start, and what they meet. All zero: none.
struct walk {
    struct scene_triangles triangles;
    struct walk_source *sources; // owned; what emits
    int source_count;
    double source_area; // of what emits; points have none
    uint64_t seed;      // shifts the sequence; 0: as it is
};

// A particle where it starts or is thrown back.
struct walk_particle {
    uint64_t index; // of the sequence
    int bounce;     // 0 at its start
    double position[3];
    double normal[3]; // to the side that it leaves to; all 0: it started at a point, to all sides
    double intensity[3]; // radiance times area, divided by the density of starts there; of a point
                         // W / sr likewise; times the reflectances on its way
    size_t triangle;     // that it is on; SIZE_MAX: none
};

// Gathers what emits at a time. On failure *out is all zero. Returns WEFT_ERR_ARGUMENT after a line
// (nothing emits; a lamp whose light does not fall off) or WEFT_ERR_MEMORY.
enum weft_result walk_make(const struct weft_log *log, const struct scene *scene, double time,
                           uint64_t seed, struct walk *out);
void walk_clear(struct walk *walk); // accepts NULL, leaves zeros behind

// Starts the particle of an index.
void walk_start(const struct walk *walk, uint64_t index, struct walk_particle *out);
// Sends it on to what it hits next. false: it leaves the scene, or what it hits throws nothing
// back.
bool walk_on(const struct walk *walk, struct walk_particle *particle);

// Returns where a choice by the seed starts, in [0, 1): 1/2 where it is 0.
double walk_offset(const struct walk *walk);

// Returns the mean reflectance by area, of R, G and B, of all triangles; 0 where there are none.
double walk_mean_reflectance(const struct scene_triangles *triangles);
// Returns the area of all triangles.
double walk_area(const struct scene_triangles *triangles);

#endif
