// SPDX-License-Identifier: BSD-3-Clause
// Pictures of small scenes against what they are by geometry and Lambert's law, in double.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <cmocka.h>

#include "tests/support/common.h"
#include "tests/support/contexts.h"
#include "tests/tools/render/pictures.h"
#include "tests/tools/render/traced.h"

// A triangle of the scene in clip space, by the matrices in double: pixels whose centre lies more
// than 1/128 of a pixel from its edges are in or out (vertices are moved to 1/256 of a pixel, or
// half of that, along each axis).
static double edge(const double a[2], const double b[2], const double p[2])
{
    const double x = b[0] - a[0], y = b[1] - a[1];
    return (x * (p[1] - a[1]) - y * (p[0] - a[0])) / hypot(x, y);
}

static void check_projected(weft_context *context)
{
    enum { W = 96, H = 64 };
    static const double corner[3][3] = {{-0.7, -0.4, -2.0}, {0.9, -0.3, -2.6}, {0.1, 0.6, -1.7}};
    struct test_scene made;
    begin_scene(&made);
    add_polygon(&made, 3, corner, (struct scene_material){.emission = {0.5f, 0.25f, 2.0f}});
    const double background[4] = {0.125, 0.25, 0.5, 0.75};
    for (int i = 0; i < 4; i++)
        made.scene.background[i] = background[i];
    const struct scene_frame frame = {.camera = {.size = {W, H}, .move = {0.3, -0.2}}};
    float *picture = draw_picture(context, &made, &frame, 64);
    struct weft_camera_matrices matrices;
    assert_int_equal(
        weft_camera_compute(&log_to_stderr, &made.scene.camera, &frame.camera, &matrices), WEFT_OK);
    double at[3][2];
    for (int i = 0; i < 3; i++)
        project(&matrices, corner[i], W, H, at[i]);
    int in = 0, out = 0;
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++) {
            const double p[2] = {x + 0.5, y + 0.5};
            double least = INFINITY;
            for (int i = 0; i < 3; i++)
                least = fmin(least, edge(at[i], at[(i + 1) % 3], p));
            if (fabs(least) < 1.0 / 128.0)
                continue;
            const float *v = &picture[4 * (y * W + x)];
            const double expected[2][4] = {{0.125, 0.25, 0.5, 0.75}, {0.5, 0.25, 2.0, 1.0}};
            for (int c = 0; c < 4; c++)
                assert_near(v[c], expected[least > 0.0][c], 0.0, "value");
            *(least > 0.0 ? &in : &out) += 1;
        }
    assert_true(in > 500 && out > 3000);
    free(picture);
    end_scene(&made);
}

static void test_projected(void **state)
{
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++)
        check_projected(contexts[c]);
}

// ---- light, without shadows ---------------------------------------------------------------------

// What is told in drawing.h and scene.h, in double, and an error that comes from places: GL moves
// corners by up to 1/256 of a pixel, and cos cos / r^2 changes by 4 / r^3 a length at most.
static void find_light(const struct scene_frame *frame, const struct traced_point *point,
                       double light[3], double error[3])
{
    for (int i = 0; i < frame->light_count; i++) {
        const struct scene_point_light *l = &frame->light[i];
        double way[3], form = find_form(l, point), part;
        for (int k = 0; k < 3; k++)
            way[k] = l->position[k] - point->position[k];
        const double r = scene_normalise(way);
        const double most = l->most > 0.0 ? fmin(form, l->most) : form;
        const double change = 4.0 * point->reach / (r * r * r) + 1e-5 * form;
        if (l->falloff == SCENE_FALLOFF_RADIANCE)
            part = (frame->clamped_share ? form - most : most) / M_PI;
        else if (form <= 0.0 || frame->clamped_share)
            part = 0.0;
        else
            part = l->falloff == SCENE_FALLOFF_NONE ? 1.0 : scene_dot(way, point->smooth);
        for (int k = 0; k < 3; k++) {
            light[k] += part * l->intensity[k];
            error[k] += l->intensity[k] * (l->falloff == SCENE_FALLOFF_RADIANCE ? change / M_PI
                                           : l->falloff == SCENE_FALLOFF_COSINE
                                               ? 2.0 * point->reach / r + 1e-5
                                               : 0.0);
        }
    }
}

static void find_pixel(const struct scene_triangles *triangles, const struct scene_frame *frame,
                       const struct traced_point *point, double value[4], double error[4])
{
    const struct scene *scene = triangles->scene;
    error[3] = 0.0;
    value[3] = point->triangle == SIZE_MAX ? scene->background[3] : 1.0;
    double light[3] = {0.0}, change[3] = {0.0}, reflectance[3] = {0.0};
    if (point->triangle == SIZE_MAX) {
        for (int k = 0; k < 3; k++) {
            value[k] = frame->clamped_share ? 0.0 : scene->background[k];
            error[k] = 0.0;
        }
        return;
    }
    const struct scene_material *material =
        &scene->materials[triangles->list[point->triangle].material];
    find_light(frame, point, light, change);
    scene_triangle_reflectance(triangles, point->triangle, point->hit.weight, reflectance);
    for (int k = 0; k < 3; k++) {
        const double ambient = frame->without_ambient ? 0.0 : scene->ambient[k];
        value[k] = reflectance[k] * (light[k] + (frame->clamped_share ? 0.0 : ambient));
        if (material->unlit) // all of it is of white corners and plain
            value[k] = frame->clamped_share ? 0.0 : material->reflectance[k];
        if (!point->hit.back && !frame->clamped_share)
            value[k] += material->emission[k];
        error[k] = reflectance[k] * change[k] + 4e-7 * value[k];
    }
}

// Returns how many pixels were compared; those at edges of triangles are not.
static int compare(const struct scene *scene, const struct scene_frame *frame, const float *picture)
{
    struct scene_triangles triangles;
    struct traced_camera camera;
    const int *size = frame->camera.size;
    int count = 0;
    assert_int_equal(scene_triangles_make(scene, frame->time, &triangles), WEFT_OK);
    find_camera(&scene->camera, size, frame->time, &camera);
    for (int y = 0; y < size[1]; y++)
        for (int x = 0; x < size[0]; x++) {
            struct traced_point point;
            double value[4], error[4];
            trace_pixel(&triangles, &camera, x + 0.5, y + 0.5, &point);
            if (!is_inside(&triangles, &camera, x + 0.5, y + 0.5, point.triangle))
                continue;
            find_pixel(&triangles, frame, &point, value, error);
            for (int k = 0; k < 4; k++) {
                const double actual = picture[4 * (y * size[0] + x) + k];
                if (!(fabs(actual - value[k]) <= error[k]))
                    fail_msg("pixel %d %d, channel %d: %.9g instead of %.9g +- %g", x, y, k, actual,
                             value[k], error[k]);
            }
            count++;
        }
    scene_triangles_clear(&triangles);
    return count;
}

// A ground, a ball, a sheet that is seen from its back, one that has no back, an unlit and a
// shining one.
static void make_things(struct test_scene *made)
{
    static const double ground[4][3] = {
        {-4.0, -1.0, -2.0}, {4.0, -1.0, -2.0}, {4.0, -1.0, -9.0}, {-4.0, -1.0, -9.0}};
    static const double sheet[4][3] = {
        {-1.5, -0.5, -4.0}, {-1.5, 0.9, -4.2}, {-0.6, 0.9, -4.6}, {-0.6, -0.5, -4.4}};
    double moved[4][3];
    begin_scene(made);
    add_polygon(made, 4, ground, (struct scene_material){.reflectance = {0.8f, 0.5f, 0.25f}});
    scene_build_object(&made->build, "ball",
                       scene_build_material(&made->build, &(struct scene_material){
                                                              .reflectance = {0.3f, 0.6f, 0.9f}}));
    scene_build_ball(&made->build, (double[]){0.3, -0.2, -4.5}, 0.7, 8);
    const struct scene_material material[4] = {
        {.reflectance = {0.5f, 0.5f, 0.5f}, .emission = {1.0f, 0.0f, 0.0f}}, // its front is behind
        {.reflectance = {0.5f, 0.5f, 0.5f}, .single_sided = true},           // not to be seen
        {.reflectance = {0.2f, 0.4f, 0.6f}, .emission = {0.1f, 0.0f, 0.0f}, .unlit = true},
        {.reflectance = {0.5f, 0.5f, 0.5f}, .emission = {0.25f, 0.5f, 1.0f}},
    };
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < 12; k++) {
            // The last two are turned to the viewer.
            const int from = i < 2 ? k / 3 : 3 - k / 3;
            moved[k / 3][k % 3] = sheet[from][k % 3] +
                                  (k % 3 == 0 ? (i == 1 ? 0.0 : 0.9 * i) : 0.0) -
                                  (k % 3 == 2 && i == 1 ? -0.3 : 0.0);
        }
        add_polygon(made, 4, (const double(*)[3])moved, material[i]);
    }
    for (int i = 0; i < 3; i++)
        made->scene.ambient[i] = 0.05 * (i + 1);
    made->scene.background[0] = 0.125;
    made->scene.background[3] = 0.5;
}

static const struct scene_point_light LIGHTS[] = {
    {.position = {0.5, 2.0, -3.0}, .intensity = {5.0, 6.0, 7.0}},
    {.position = {-1.0, 0.8, -2.5}, .normal = {0.6, 0.0, -0.8}, .intensity = {3.0, 1.0, 0.5}},
    {.position = {0.0, 5.0, 2.0}, .intensity = {0.5, 0.25, 0.125}, .falloff = SCENE_FALLOFF_COSINE},
    {.position = {3.0, 1.0, -1.0}, .intensity = {0.1, 0.2, 0.3}, .falloff = SCENE_FALLOFF_NONE},
    {.position = {-2.0, -0.9, -4.0}, .intensity = {1.0, 1.0, 1.0}, .most = 2.0},
};
enum { LIGHT_COUNT = sizeof LIGHTS / sizeof *LIGHTS };

// Each light alone, all of them, none; ambient light or none.
static void check_light(weft_context *context)
{
    struct test_scene made;
    make_things(&made);
    scene_drawing *drawing = begin_drawing(context, &made, 64);
    for (int i = 0; i <= LIGHT_COUNT + 1; i++) {
        struct scene_frame frame = {.camera = {.size = {80, 60}}, .without_ambient = i % 2};
        frame.light_count = i < LIGHT_COUNT ? 1 : i == LIGHT_COUNT ? LIGHT_COUNT : 0;
        for (int k = 0; k < frame.light_count; k++)
            frame.light[k] = LIGHTS[i < LIGHT_COUNT ? i : k];
        float *picture = draw_mean(context, drawing, 1, &frame);
        assert_true(compare(&made.scene, &frame, picture) > 3500);
        free(picture);
    }
    scene_drawing_destroy(&drawing);
    end_scene(&made);
}

static void test_light(void **state)
{
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++)
        check_light(contexts[c]);
}

// What clamping left and what it took away are the whole: of floats that are rounded once each.
static void test_clamping(void **state)
{
    (void)state;
    struct test_scene made;
    make_things(&made);
    scene_drawing *drawing = begin_drawing(contexts[0], &made, 64);
    struct scene_frame frame = {.camera = {.size = {80, 60}}, .light_count = 2};
    frame.light[0] = LIGHTS[4];
    frame.light[1] = LIGHTS[1];
    frame.light[0].shadowed = frame.light[1].shadowed = true;
    frame.light[1].most = 0.05;
    float *clamped = draw_mean(contexts[0], drawing, 1, &frame);
    frame.clamped_share = true;
    float *share = draw_mean(contexts[0], drawing, 1, &frame);
    frame.clamped_share = false;
    frame.light[0].most = frame.light[1].most = 0.0;
    float *whole = draw_mean(contexts[0], drawing, 1, &frame);
    int taken = 0;
    for (int i = 0; i < 80 * 60 * 4; i++) {
        if (i % 4 == 3) { // coverage is not shared
            assert_near(clamped[i], whole[i], 0.0, "alpha");
            assert_near(share[i], whole[i], 0.0, "alpha");
            continue;
        }
        taken += share[i] > 0.0f;
        assert_true(share[i] >= 0.0f);
        assert_near((double)clamped[i] + share[i], whole[i], 4e-6 * whole[i], "sum");
    }
    assert_true(taken > 300);
    free(clamped);
    free(share);
    free(whole);
    scene_drawing_destroy(&drawing);
    end_scene(&made);
}

// ---- patterns and motion ------------------------------------------------------------------------

// Squares of a chequered wall, by their place in the picture: pixels that are within 1/64 of a
// pixel of an edge of a square are left out.
static void check_checker(weft_context *context)
{
    enum { W = 90, H = 70 };
    static const double corner[4][3] = {
        {-3.0, -2.0, -6.0}, {3.0, -2.0, -3.0}, {3.0, 2.0, -3.0}, {-3.0, 2.0, -6.0}};
    static const double uv[4][2] = {{-1.5, 0.0}, {1.5, 0.0}, {1.5, 1.0}, {-1.5, 1.0}};
    const struct scene_material material = {.reflectance = {1.0f, 1.0f, 1.0f},
                                            .unlit = true,
                                            .pattern = SCENE_CHECKER,
                                            .frequency = 4.0f};
    struct test_scene made;
    begin_scene(&made);
    scene_build_object(&made.build, "", scene_build_material(&made.build, &material));
    scene_build_polygon(&made.build, 4, corner, uv, NULL);
    const struct scene_frame frame = {.camera = {.size = {W, H}}};
    float *picture = draw_picture(context, &made, &frame, 64);
    int counted[2] = {0};
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++) {
            // x / z and y / z of the pixel; on the wall z = (x - 9) / 2.
            const double t = tan(M_PI / 8.0);
            int cell = 0;
            bool same = true;
            for (int i = 0; i < 5; i++) {
                const double px = x + 0.5 + (i == 4 ? 0.0 : i & 1 ? 1.0 / 64 : -1.0 / 64);
                const double py = y + 0.5 + (i == 4 ? 0.0 : i & 2 ? 1.0 / 64 : -1.0 / 64);
                const double a = (2.0 * px / W - 1.0) * t * W / H, b = (2.0 * py / H - 1.0) * t;
                const double depth = 9.0 / (2.0 + a);
                const double u = 0.5 * a * depth, v = 0.25 * (b * depth + 2.0);
                const int at = (int)floor(4.0 * u) + (int)floor(4.0 * v);
                same = same && (i == 0 || (at & 1) == cell) && fabs(a * depth) < 3.0 &&
                       fabs(b * depth) < 2.0;
                cell = at & 1;
            }
            if (!same)
                continue;
            counted[cell]++;
            assert_near(picture[4 * (y * W + x)], cell ? 0.25 : 1.0, 1e-6, "square");
        }
    assert_true(counted[0] > 1000 && counted[1] > 1000);
    free(picture);
    end_scene(&made);
}

static void test_checker(void **state)
{
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++)
        check_checker(contexts[c]);
}

// A turned, scaled and moved object in the light, by the triangles where they lie at that time.
static void test_moved(void **state)
{
    (void)state;
    struct test_scene made;
    begin_scene(&made);
    scene_build_object(&made.build, "box",
                       scene_build_material(&made.build, &(struct scene_material){
                                                             .reflectance = {0.3f, 0.6f, 0.9f}}));
    scene_build_box(&made.build, (double[]){-0.5, -0.4, -0.3}, (double[]){0.5, 0.4, 0.3});
    struct scene_key *key = scene_build_path(&made.build, 2);
    assert_non_null(key);
    for (int i = 0; i < 2; i++) {
        key[i].position[0] = i - 0.5;
        key[i].position[2] = -3.0 - i;
        key[i].scale = 1.0 + i;
        scene_rotation((double[]){1.0, 2.0, 3.0}, 140.0 * i, key[i].rotation);
    }
    scene_drawing *drawing = begin_drawing(contexts[0], &made, 64);
    for (int i = 0; i <= 4; i++) {
        struct scene_frame frame = {.camera = {.size = {80, 60}}, .time = i / 4.0};
        frame.light_count = 1;
        frame.light[0] = LIGHTS[0];
        float *picture = draw_mean(contexts[0], drawing, 1, &frame);
        int seen = 0;
        for (int k = 0; k < 80 * 60; k++)
            seen += picture[4 * k + 3] > 0.0f;
        assert_true(seen > 150 && compare(&made.scene, &frame, picture) > 4300);
        free(picture);
    }
    scene_drawing_destroy(&drawing);
    end_scene(&made);
}

// ---- what is refused ----------------------------------------------------------------------------

static void test_refused(void **state)
{
    (void)state;
    static const int sizes[] = {0, 3, 1 << 20};
    struct test_scene made;
    make_things(&made);
    for (int i = 0; i < 3; i++) {
        struct message message = {.count = 0};
        const struct weft_log log = {keep_message, &message};
        scene_drawing *drawing = NULL;
        assert_int_equal(
            scene_drawing_create(scene_drawing_params(.scene = &made.scene, .context = contexts[0],
                                                      .shadow_size = sizes[i], .log = &log),
                                 &drawing),
            WEFT_ERR_LIMIT);
        assert_null(drawing);
        assert_int_equal(message.count, 1);
    }
    scene_drawing_destroy(&(scene_drawing *){NULL});
    end_scene(&made);
}

// Nothing to draw is the background.
static void test_empty(void **state)
{
    (void)state;
    struct test_scene made;
    begin_scene(&made);
    made.scene.background[1] = 0.5;
    struct scene_frame frame = {.camera = {.size = {8, 6}}, .light_count = 1};
    frame.light[0] = LIGHTS[0];
    frame.light[0].shadowed = true;
    float *picture = draw_picture(contexts[0], &made, &frame, 64);
    for (int i = 0; i < 8 * 6; i++)
        assert_near(picture[4 * i + 1], 0.5, 0.0, "background");
    free(picture);
    end_scene(&made);
}

int main(void)
{
    if (WITHOUT_GL)
        return EXIT_SKIPPED;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_projected), cmocka_unit_test(test_light),
        cmocka_unit_test(test_clamping),  cmocka_unit_test(test_checker),
        cmocka_unit_test(test_moved),     cmocka_unit_test(test_refused),
        cmocka_unit_test(test_empty),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
