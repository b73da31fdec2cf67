// SPDX-License-Identifier: BSD-3-Clause
// tests/tools/render/pictures.h - small scenes made by hand, and pictures of them as floats.
// Include after cmocka.h and common.h.
#ifndef WEFT_TESTS_TOOLS_RENDER_PICTURES_H
#define WEFT_TESTS_TOOLS_RENDER_PICTURES_H

#include <string.h>

#include "tools/scene/build.h"
#include "tools/render/drawing.h"
#include "weft.h"

// A scene that is being made: WEFT_CAMERA_DEFAULTS, a black background of alpha 0, no lights.
struct test_scene {
    struct scene scene;
    struct scene_build build;
};

static inline void begin_scene(struct test_scene *made)
{
    memset(made, 0, sizeof *made);
    made->scene.camera = *weft_camera();
    made->build.scene = &made->scene;
}

// One object of its own material; white vertices.
static inline void add_polygon(struct test_scene *made, int count, const double corner[][3],
                               struct scene_material material)
{
    scene_build_object(&made->build, "", scene_build_material(&made->build, &material));
    scene_build_polygon(&made->build, count, corner, NULL, NULL);
}

static inline void end_scene(struct test_scene *made)
{
    scene_clear(&made->scene);
}

struct drawn_frame {
    scene_drawing *drawing;
    const struct scene_frame *frame;
};

static enum weft_result draw_frame(void *priv, int64_t index, const struct weft_draw_target *target)
{
    const struct drawn_frame *drawn = priv;
    (void)index;
    return scene_drawing_draw(drawn->drawing, drawn->frame, target);
}

// Draws frames and averages them in float, RGBA of size[0] * size[1] pixels, row 0 the lowest.
static inline float *draw_mean(weft_context *context, scene_drawing *drawing, int count,
                               const struct scene_frame *frame)
{
    const int width = frame->camera.size[0], height = frame->camera.size[1];
    weft_accumulator *accumulator = NULL;
    assert_int_equal(
        weft_accumulator_create(
            weft_accumulator_params(.width = width, .height = height, .channel_count = 4,
                                    .frame_count = count, .method = WEFT_ACCUMULATE_EXACT,
                                    .frame_bits = 32, .context = context, .log = &log_to_stderr),
            &accumulator),
        WEFT_OK);
    for (int i = 0; i < count; i++) {
        struct drawn_frame drawn = {drawing, &frame[i]};
        assert_int_equal(
            weft_accumulator_add(accumulator,
                                 &(struct weft_frame){.draw = draw_frame, .priv = &drawn}, 1.0),
            WEFT_OK);
    }
    float *plane = malloc((size_t)width * (size_t)height * sizeof *plane);
    float *picture = malloc((size_t)width * (size_t)height * 4 * sizeof *picture);
    assert_true(plane && picture);
    for (int c = 0; c < 4; c++) {
        assert_int_equal(weft_accumulator_current(accumulator, WEFT_ACCUMULATED_MEAN, c, plane, 0),
                         WEFT_OK);
        for (size_t i = 0; i < (size_t)width * (size_t)height; i++)
            picture[4 * i + (size_t)c] = plane[i];
    }
    free(plane);
    weft_accumulator_destroy(&accumulator);
    return picture;
}

static inline scene_drawing *begin_drawing(weft_context *context, struct test_scene *made,
                                           int shadow_size)
{
    scene_drawing *drawing = NULL;
    assert_int_equal(scene_build_end(&made->build, &log_to_stderr), WEFT_OK);
    assert_int_equal(scene_drawing_create(
                         scene_drawing_params(.scene = &made->scene, .context = context,
                                              .shadow_size = shadow_size, .log = &log_to_stderr),
                         &drawing),
                     WEFT_OK);
    return drawing;
}

// One frame of a scene that is complete.
static inline float *draw_picture(weft_context *context, struct test_scene *made,
                                  const struct scene_frame *frame, int shadow_size)
{
    scene_drawing *drawing = begin_drawing(context, made, shadow_size);
    float *picture = draw_mean(context, drawing, 1, frame);
    scene_drawing_destroy(&drawing);
    return picture;
}

// Where a point is in the picture, in pixels from the lower left corner.
static inline void project(const struct weft_camera_matrices *matrices, const double point[3],
                           int width, int height, double out[2])
{
    double p[4];
    for (int row = 0; row < 4; row++)
        p[row] = matrices->clip[row] * point[0] + matrices->clip[4 + row] * point[1] +
                 matrices->clip[8 + row] * point[2] + matrices->clip[12 + row];
    out[0] = 0.5 * width * (p[0] / p[3] + 1.0);
    out[1] = 0.5 * height * (p[1] / p[3] + 1.0);
}

#endif
