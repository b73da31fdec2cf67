// SPDX-License-Identifier: BSD-3-Clause
// tests/tools/effect/effects.h - plans, scenes and pictures of these tests. Include after cmocka.h.
//
// The camera of these scenes looks along -z with 90 degrees; at z = -height / 2 a unit is a pixel,
// and (0, 0) the middle of the picture.
#ifndef WEFT_TESTS_TOOLS_EFFECT_EFFECTS_H
#define WEFT_TESTS_TOOLS_EFFECT_EFFECTS_H

#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "tools/effect/plan.h"
#include "tools/scene/build.h"

// Positions of vertices on the screen are rounded to 1/256 pixel (GL_SUBPIXEL_BITS 8).
static const double snap = 1.0 / 256.0;

static inline double random_in(uint64_t *state, double low, double high)
{
    return low + (high - low) * random_unit(state);
}

static inline struct effect_plan plan_made(const struct effect_params *params)
{
    struct effect_plan plan;
    struct effect_params logged = *params;
    logged.log = params->log ? params->log : &log_to_stderr;
    assert_int_equal(effect_plan_make(&logged, &plan), WEFT_OK);
    return plan;
}

// Whether two plans have the same frames.
static inline bool is_same(const struct effect_plan *a, const struct effect_plan *b)
{
    bool same = a->count == b->count;
    for (int64_t k = 0; k < a->count && same; k++) {
        const struct effect_frame *f = &a->frames[k], *g = &b->frames[k];
        same = f->scene == g->scene && f->weight == g->weight && f->show.time == g->show.time &&
               f->show.light_count == g->show.light_count;
        for (int axis = 0; axis < 2; axis++)
            same = same && f->show.camera.move[axis] == g->show.camera.move[axis] &&
                   f->show.camera.lens[axis] == g->show.camera.lens[axis];
        for (int i = 0; i < f->show.light_count; i++)
            for (int axis = 0; axis < 3; axis++)
                same = same && f->show.light[i].position[axis] == g->show.light[i].position[axis] &&
                       f->show.light[i].intensity[axis] == g->show.light[i].intensity[axis];
    }
    return same;
}

// ---- scenes -------------------------------------------------------------------------------------

static inline struct scene_build empty_scene(struct scene *scene, const int size[2])
{
    *scene = (struct scene){.background = {0.0, 0.0, 0.0, 0.0}};
    snprintf(scene->name, sizeof scene->name, "test");
    scene->camera =
        *weft_camera(.fovy_degrees = 90.0, .near_distance = 0.25, .far_distance = 16.0 * size[1]);
    return (struct scene_build){.scene = scene};
}

static inline void end_scene(struct scene_build *build)
{
    assert_int_equal(scene_build_end(build, &log_to_stderr), WEFT_OK);
}

// A material that shows its colour.
static inline int add_colour(struct scene_build *build, float red, float green, float blue)
{
    const struct scene_material material = {
        .name = "colour", .reflectance = {red, green, blue}, .unlit = true};
    return scene_build_material(build, &material);
}

// A rectangle at a depth, about (x, y) in its plane, turned, as an object of its own.
static inline void add_rectangle(struct scene_build *build, int material, double depth,
                                 const double middle[2], const double half[2], double angle)
{
    static const int sign[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    double corner[4][3];
    for (int i = 0; i < 4; i++) {
        const double u = sign[i][0] * half[0], v = sign[i][1] * half[1];
        corner[i][0] = middle[0] + u * cos(angle) - v * sin(angle);
        corner[i][1] = middle[1] + u * sin(angle) + v * cos(angle);
        corner[i][2] = -depth;
    }
    scene_build_object(build, "rectangle", material);
    scene_build_polygon(build, 4, (const double(*)[3])corner, NULL, NULL);
}

// White where p . (cos, sin) <= distance, p in pixels from the picture's middle, y up.
static inline void make_half_plane(struct scene *scene, const int size[2], double angle,
                                   double distance)
{
    const double reach = 2.0 * (size[0] + size[1]);
    const double middle[2] = {cos(angle) * (distance - reach), sin(angle) * (distance - reach)};
    const double half[2] = {reach, reach};
    struct scene_build build = empty_scene(scene, size);
    add_rectangle(&build, add_colour(&build, 1.0f, 1.0f, 1.0f), size[1] / 2.0, middle, half, angle);
    end_scene(&build);
}

// The object that was added last moves by so much from time 0 to 1.
static inline void move_last(struct scene_build *build, double x, double y)
{
    struct scene_key *key = scene_build_path(build, 2);
    assert_non_null(key);
    for (int i = 0; i < 2; i++)
        key[i] = (struct scene_key){
            .time = i, .position = {i * x, i * y, 0.0}, .rotation = {0, 0, 0, 1}, .scale = 1.0};
}

#endif
