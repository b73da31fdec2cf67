// SPDX-License-Identifier: BSD-3-Clause
// tests/tools/effect/path_tracer.h - light by unbiased path tracing (Kajiya 1986), in double: the
// reference that pictures of virtual lights are judged by. It shares the places of triangles and
// their reflectances with what it judges; rays, sampling and sums are its own.
//
// Every diffuse surface gets light from a point of a source chosen by power, and from a direction
// distributed as the cosine, joined by the balance heuristic (Veach and Guibas 1995); long paths
// end by Russian roulette.
#ifndef WEFT_TESTS_TOOLS_EFFECT_PATH_TRACER_H
#define WEFT_TESTS_TOOLS_EFFECT_PATH_TRACER_H

#include "tools/scene/rays.h"

enum { TRACED_ALL_BOUNCES = 1 << 20 };

// A scene of triangles at a time; what emits are triangles: lamps that are not seen do not count.
// Any number of threads may trace it. Cleared by tracer_clear.
struct tracer {
    struct scene_triangles triangles;
    struct traced_face *faces; // one a triangle
    double power;              // of all faces
};
// Fails the test where memory does not do.
void tracer_make(const struct scene *scene, double time, struct tracer *out);
void tracer_clear(struct tracer *tracer);

// A mean and its standard error, RGB.
struct traced {
    double mean[3], error[3];
};

// Irradiance at a point that lies on a triangle (SIZE_MAX: on none), to the side of `normal`, by so
// many paths of light that is thrown back `bounces` times at most.
struct traced tracer_irradiance(const struct tracer *tracer, const double point[3],
                                const double normal[3], size_t triangle, int bounces, int samples,
                                uint64_t seed);

// Whether light passes between two points that each lie on a triangle, or on none (SIZE_MAX).
bool tracer_sees(const struct tracer *tracer, const double from[3], size_t from_triangle,
                 const double to[3], size_t to_triangle);

// A pixel's centre.
struct traced_pixel {
    size_t triangle;            // that is seen there; SIZE_MAX: the background
    double point[3], normal[3]; // to the side that is seen
    double reflectance[3];
    double emission[3];     // to that side
    double clearance;       // distance to the nearest triangle that is not in the same plane
    struct traced radiance; // of paths of any length; NAN without samples
};
// What the camera sees through the centres of pixels, rows upwards, `samples` paths each (0: no
// radiance), on so many threads. The seed and not the number of threads decides what comes out.
void tracer_picture(const struct tracer *tracer, const struct weft_camera *camera,
                    const int size[2], int samples, uint64_t seed, int threads,
                    struct traced_pixel *out);

// Irradiance of a polygon that emits radiance 1, all of it seen, at a point: Lambert's formula,
// E = 1/2 sum Theta_i Gamma_i . n, for corners clockwise seen from the point; no corner may lie
// below the point's horizon.
double lambert_irradiance(const double (*corner)[3], int count, const double point[3],
                          const double normal[3]);

#endif
