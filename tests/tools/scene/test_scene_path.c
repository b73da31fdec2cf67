// SPDX-License-Identifier: BSD-3-Clause
// Paths: positions, rotations and scales between keys against what they are by hand.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "tests/support/common.h"
#include "tools/scene/build.h"

// Key times are sums of powers of two, so that shares are exact.
static struct scene_key key_at(double time, const double axis[3], double degrees)
{
    struct scene_key key = {.time = time, .scale = 1.0};
    scene_rotation(axis, degrees, key.rotation);
    return key;
}

static void assert_moves(const struct scene_path *path, double time, const double from[3],
                         const double to[3])
{
    double matrix[16], out[3];
    scene_path_at(path, time, matrix);
    scene_transform(matrix, from, out);
    for (int i = 0; i < 3; i++)
        assert_near(out[i], to[i], 1e-14, "a moved coordinate");
}

static void test_no_keys_move_nothing(void **state)
{
    (void)state;
    const struct scene_path path = {0};
    for (double time = -1.0; time <= 2.0; time += 0.5)
        assert_moves(&path, time, (double[]){1.0, 2.0, 3.0}, (double[]){1.0, 2.0, 3.0});
}

static void test_positions_and_scales_are_linear_and_rest_outside(void **state)
{
    (void)state;
    struct scene_key keys[3] = {{0.25, {1.0, 0.0, -2.0}, {0, 0, 0, 1}, 1.0},
                                {0.50, {3.0, 4.0, -2.0}, {0, 0, 0, 1}, 3.0},
                                {1.00, {3.0, 0.0, 6.0}, {0, 0, 0, 1}, 2.0}};
    const struct scene_path path = {keys, 3};
    static const struct {
        double time, position[3], scale;
    } cases[] = {
        {-5.0, {1.0, 0.0, -2.0}, 1.0},  {0.0, {1.0, 0.0, -2.0}, 1.0},
        {0.25, {1.0, 0.0, -2.0}, 1.0},  {0.3125, {1.5, 1.0, -2.0}, 1.5},
        {0.375, {2.0, 2.0, -2.0}, 2.0}, {0.5, {3.0, 4.0, -2.0}, 3.0},
        {0.75, {3.0, 2.0, 2.0}, 2.5},   {0.875, {3.0, 1.0, 4.0}, 2.25},
        {1.0, {3.0, 0.0, 6.0}, 2.0},    {9.0, {3.0, 0.0, 6.0}, 2.0},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const double s = cases[i].scale, *p = cases[i].position;
        assert_moves(&path, cases[i].time, (double[]){0.0, 0.0, 0.0}, p);
        assert_moves(&path, cases[i].time, (double[]){1.0, -1.0, 2.0},
                     (double[]){p[0] + s, p[1] - s, p[2] + 2.0 * s});
        assert_near(scene_path_key(&path, cases[i].time).time, cases[i].time, 0.0, "the time");
    }
}

static void test_rotations_by_axis_and_angle(void **state)
{
    (void)state;
    static const struct {
        double axis[3], degrees, from[3], to[3];
    } cases[] = {
        {{0, 0, 1}, 90.0, {1, 0, 0}, {0, 1, 0}},  {{0, 0, 5}, -90.0, {1, 0, 0}, {0, -1, 0}},
        {{1, 0, 0}, 90.0, {0, 1, 0}, {0, 0, 1}},  {{0, 2, 0}, 90.0, {0, 0, 1}, {1, 0, 0}},
        {{1, 1, 1}, 120.0, {1, 0, 0}, {0, 1, 0}}, {{1, 1, 1}, 240.0, {1, 0, 0}, {0, 0, 1}},
        {{1, 0, 1}, 180.0, {1, 0, 0}, {0, 0, 1}}, {{3, 4, 0}, 0.0, {1, 2, 3}, {1, 2, 3}},
        {{0, 1, 0}, 360.0, {1, 2, 3}, {1, 2, 3}},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct scene_key key = key_at(0.0, cases[i].axis, cases[i].degrees);
        assert_moves(&(struct scene_path){&key, 1}, 0.0, cases[i].from, cases[i].to);
    }
}

// A turn by any angle up to 180 degrees is at an even speed about its axis.
static void test_turns_are_even_along_the_shorter_arc(void **state)
{
    (void)state;
    static const double axes[][3] = {{0, 0, 1}, {1, 2, 3}, {-1, 0.5, 0}};
    static const double degrees[] = {1e-7, 1e-4, 1.0, 90.0, 179.0};
    int ran = 0;
    for (size_t a = 0; a < WEFT_COUNT(axes); a++)
        for (size_t d = 0; d < WEFT_COUNT(degrees); d++)
            for (int sign = 0; sign < 2; sign++) {
                struct scene_key keys[2] = {key_at(0.0, axes[a], 20.0),
                                            key_at(1.0, axes[a], 20.0 + degrees[d])};
                // The same rotation has two quaternions.
                for (int i = 0; i < 4 && sign; i++)
                    keys[1].rotation[i] = -keys[1].rotation[i];
                const struct scene_path path = {keys, 2};
                for (int k = 0; k <= 8; k++) {
                    double to[3], q[4];
                    const double from[3] = {0.3, -1.0, 0.7};
                    scene_rotation(axes[a], 20.0 + degrees[d] * k / 8.0, q);
                    scene_rotate(q, from, to);
                    assert_moves(&path, k / 8.0, from, to);
                    ran++;
                }
            }
    assert_int_equal(ran, 3 * 5 * 2 * 9);
    // Halfway of 90 degrees are 45; of 270 it is -45.
    struct scene_key quarter[2] = {key_at(0.0, axes[0], 0.0), key_at(1.0, axes[0], 90.0)};
    assert_moves(&(struct scene_path){quarter, 2}, 0.5, (double[]){1.0, 0.0, 0.0},
                 (double[]){M_SQRT1_2, M_SQRT1_2, 0.0});
    quarter[1] = key_at(1.0, axes[0], 270.0);
    assert_moves(&(struct scene_path){quarter, 2}, 0.5, (double[]){1.0, 0.0, 0.0},
                 (double[]){M_SQRT1_2, -M_SQRT1_2, 0.0});
}

// Matrices are rotations times scales, whatever the keys.
static void test_matrices_are_rotations_times_scales(void **state)
{
    (void)state;
    uint64_t random = 7;
    int ran = 0;
    for (int k = 0; k < 200; k++) {
        struct scene_key keys[2];
        for (int i = 0; i < 2; i++) {
            const double axis[3] = {random_unit(&random) - 0.5, random_unit(&random) - 0.5,
                                    random_unit(&random)};
            keys[i] = key_at(i, axis, 720.0 * random_unit(&random) - 360.0);
            keys[i].scale = 0.5 + random_unit(&random);
        }
        const struct scene_path path = {keys, 2};
        const double time = random_unit(&random), scale = scene_path_key(&path, time).scale;
        double m[16], product[3];
        scene_path_at(&path, time, m);
        for (int a = 0; a < 3; a++, ran++) {
            scene_cross(m + 4 * a, m + 4 * ((a + 1) % 3), product);
            for (int i = 0; i < 3; i++)
                assert_near(product[i], scale * m[4 * ((a + 2) % 3) + i], 1e-14, "an axis");
            assert_near(scene_dot(m + 4 * a, m + 4 * a), scale * scale, 1e-14, "its length");
        }
    }
    assert_int_equal(ran, 600);
}

static void test_a_camera_turns_about_its_eye(void **state)
{
    (void)state;
    struct scene_key keys[2] = {key_at(0.0, (double[]){0, 1, 0}, 0.0),
                                key_at(1.0, (double[]){0, 1, 0}, 90.0)};
    keys[1].position[0] = 2.0;
    struct scene scene = {.camera = {.eye = {1.0, 2.0, 3.0},
                                     .target = {1.0, 2.0, -7.0},
                                     .up = {0.0, 1.0, 0.0},
                                     .fovy_degrees = 30.0},
                          .camera_path = {keys, 2}};
    struct weft_camera out;
    scene_camera_at(&scene, 1.0, &out);
    // -z is turned to -x.
    const double eye[3] = {3.0, 2.0, 3.0}, target[3] = {-7.0, 2.0, 3.0}, up[3] = {0.0, 1.0, 0.0};
    for (int i = 0; i < 3; i++) {
        assert_near(out.eye[i], eye[i], 1e-14, "the eye");
        assert_near(out.target[i], target[i], 1e-14, "the target");
        assert_near(out.up[i], up[i], 1e-14, "up");
    }
    assert_near(out.fovy_degrees, 30.0, 0.0, "the angle");
    scene.camera_path.count = 0;
    scene_camera_at(&scene, 0.7, &out);
    assert_memory_equal(&out, &scene.camera, sizeof out);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_no_keys_move_nothing),
        cmocka_unit_test(test_positions_and_scales_are_linear_and_rest_outside),
        cmocka_unit_test(test_rotations_by_axis_and_angle),
        cmocka_unit_test(test_turns_are_even_along_the_shorter_arc),
        cmocka_unit_test(test_matrices_are_rotations_times_scales),
        cmocka_unit_test(test_a_camera_turns_about_its_eye),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
