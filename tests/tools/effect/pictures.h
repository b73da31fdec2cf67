// SPDX-License-Identifier: BSD-3-Clause
// tests/tools/effect/pictures.h - plans that are drawn and accumulated. Include after cmocka.h.
#ifndef WEFT_TESTS_TOOLS_EFFECT_PICTURES_H
#define WEFT_TESTS_TOOLS_EFFECT_PICTURES_H

#include "tests/support/contexts.h"
#include "tests/tools/effect/effects.h"
#include "tools/effect/run.h"

// A mean of frames: 4 planes of floats, rows upwards.
struct picture {
    int size[2];
    float *value;
    struct weft_accumulator_report report;
};

static inline float pixel_at(const struct picture *picture, int channel, int x, int y)
{
    const size_t pixels = (size_t)picture->size[0] * (size_t)picture->size[1];
    return picture
        ->value[(size_t)channel * pixels + (size_t)y * (size_t)picture->size[0] + (size_t)x];
}

static inline void read_picture(weft_accumulator *accumulator, struct picture *out)
{
    const size_t pixels = (size_t)out->size[0] * (size_t)out->size[1];
    out->value = malloc(4 * pixels * sizeof *out->value);
    assert_non_null(out->value);
    for (int c = 0; c < 4; c++)
        assert_int_equal(weft_accumulator_current(accumulator, WEFT_ACCUMULATED_MEAN, c,
                                                  out->value + (size_t)c * pixels, 0),
                         WEFT_OK);
    weft_accumulator_get_report(accumulator, &out->report);
}

// One drawing a scene.
static inline void create_drawings(weft_context *context, const struct scene *const *scenes,
                                   int count, scene_drawing **out)
{
    for (int s = 0; s < count; s++)
        assert_int_equal(
            scene_drawing_create(
                scene_drawing_params(.scene = scenes[s], .context = context, .log = &log_to_stderr),
                &out[s]),
            WEFT_OK);
}

// Frames first to first + count (0: all that follow) of a plan, by `asked`, whose size, channels
// and context are filled in here.
static inline struct picture accumulate_frames(weft_context *context,
                                               const struct effect_plan *plan,
                                               scene_drawing *const *drawing,
                                               struct weft_accumulator_params asked, int64_t first,
                                               int64_t count)
{
    struct picture out = {.size = {plan->size[0], plan->size[1]}};
    weft_accumulator *accumulator;
    int64_t added;
    asked.width = out.size[0];
    asked.height = out.size[1];
    asked.channel_count = 4;
    asked.context = context;
    asked.log = &log_to_stderr;
    assert_int_equal(weft_accumulator_create(&asked, &accumulator), WEFT_OK);
    assert_int_equal(
        effect_run(effect_run_params(.plan = plan, .drawing = drawing, .accumulator = accumulator,
                                     .first = first, .count = count),
                   &added),
        WEFT_OK);
    assert_int_equal(added, count ? count : plan->count - first);
    read_picture(accumulator, &out);
    weft_accumulator_destroy(&accumulator);
    return out;
}

static inline struct picture draw_frames(weft_context *context, const struct effect_plan *plan,
                                         const struct scene *const *scenes,
                                         struct weft_accumulator_params asked, int64_t first,
                                         int64_t count)
{
    scene_drawing *drawing[EFFECT_MAX_SCENES] = {NULL};
    create_drawings(context, scenes, plan->scene_count, drawing);
    struct picture out = accumulate_frames(context, plan, drawing, asked, first, count);
    for (int s = 0; s < plan->scene_count; s++)
        scene_drawing_destroy(&drawing[s]);
    return out;
}

// All frames of a plan of one scene, by exact sums of floats.
static inline struct picture draw_plan(weft_context *context, const struct effect_plan *plan,
                                       const struct scene *scene)
{
    return draw_frames(
        context, plan, &scene,
        (struct weft_accumulator_params){.method = WEFT_ACCUMULATE_EXACT, .frame_bits = 32}, 0, 0);
}

#endif
