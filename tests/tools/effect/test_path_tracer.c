// SPDX-License-Identifier: BSD-3-Clause
// The reference itself, against what is known: a furnace, and direct light by Lambert's formula.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "tests/support/common.h"
#include "tests/tools/effect/path_tracer.h"

// Estimates are within this many standard errors; of a few hundred none is outside by chance.
static const double TRUST = 4.5;

static void make(const char *name, struct scene *scene)
{
    assert_int_equal(
        scene_make(scene_params(.name = name, .size = {16, 16}, .log = &log_to_stderr), scene),
        WEFT_OK);
}

// Every pixel of a closed box whose walls emit 1 and reflect rho shows 1 / (1 - rho).
static void test_furnace(void **state)
{
    (void)state;
    static const double reflectances[] = {0.0, 0.3, 0.5, 0.7};
    const int size[2] = {12, 8}, count = 12 * 8;
    int seen = 0;
    for (size_t r = 0; r < WEFT_COUNT(reflectances); r++) {
        char name[32];
        struct scene scene;
        struct tracer tracer;
        struct traced_pixel pixels[12 * 8];
        snprintf(name, sizeof name, "furnace:%g", reflectances[r]);
        make(name, &scene);
        tracer_make(&scene, 0.0, &tracer);
        tracer_picture(&tracer, &scene.camera, size, 400, r, 2, pixels);
        const double expected = 1.0 / (1.0 - (float)reflectances[r]);
        double mean = 0.0;
        for (int i = 0; i < count; i++, seen++) {
            const struct traced *radiance = &pixels[i].radiance;
            assert_near(radiance->mean[1], expected, TRUST * radiance->error[1] + 1e-6, "a pixel");
            assert_true(radiance->error[1] < 0.05 * expected);
            mean += radiance->mean[1] / count;
        }
        assert_near(mean, expected, 0.005 * expected, "the picture");
        tracer_clear(&tracer);
        scene_clear(&scene);
    }
    assert_int_equal(seen, 4 * 12 * 8);
}

// Direct light on the Cornell box's floor, where a point sees all of the lamp.
static void test_lambert(void **state)
{
    (void)state;
    struct scene scene;
    struct tracer tracer;
    make("cornell", &scene);
    tracer_make(&scene, 0.0, &tracer);
    const double lamp[4][3] = {
        {213.0, 548.8, 332.0}, {343.0, 548.8, 332.0}, {343.0, 548.8, 227.0}, {213.0, 548.8, 227.0}};
    static const double radiance[3] = {17.0, 12.0, 4.0}, up[3] = {0.0, 1.0, 0.0};
    static const double points[][3] = {
        {450.0, 0.0, 60.0}, {400.0, 0.0, 150.0}, {520.0, 0.0, 120.0}};
    for (size_t p = 0; p < WEFT_COUNT(points); p++) {
        const double form = lambert_irradiance(lamp, 4, points[p], up);
        assert_true(form > 0.01);
        const struct traced traced =
            tracer_irradiance(&tracer, points[p], up, SIZE_MAX, 0, 20000, p);
        for (int i = 0; i < 3; i++) {
            assert_near(traced.mean[i], radiance[i] * form, TRUST * traced.error[i], "irradiance");
            assert_true(traced.error[i] < 0.01 * traced.mean[i]);
        }
    }
    // The formula itself: a square of side 2 at height 1 above the point has the form factor
    // 4 / (pi sqrt 2) atan(1 / sqrt 2) of all that a plane sees (Howell's catalogue, B-4 four times
    // over); E = pi F.
    const double square[4][3] = {
        {-1.0, 1.0, 1.0}, {1.0, 1.0, 1.0}, {1.0, 1.0, -1.0}, {-1.0, 1.0, -1.0}};
    assert_near(lambert_irradiance(square, 4, (double[]){0.0, 0.0, 0.0}, up),
                4.0 / sqrt(2.0) * atan(1.0 / sqrt(2.0)), 1e-12, "Lambert's formula");
    // In the shadow of the tall block there is none.
    const double hidden[3] = {400.0, 0.0, 520.0};
    const struct traced dark = tracer_irradiance(&tracer, hidden, up, SIZE_MAX, 0, 1000, 1);
    assert_true(dark.mean[0] < 0.5 * radiance[0] * lambert_irradiance(lamp, 4, hidden, up));
    tracer_clear(&tracer);
    scene_clear(&scene);
}

// The number of threads changes nothing; what is seen is where it was built.
static void test_picture(void **state)
{
    (void)state;
    struct scene scene;
    struct tracer tracer;
    const int size[2] = {16, 16};
    struct traced_pixel one[256], two[256];
    make("cornell", &scene);
    tracer_make(&scene, 0.0, &tracer);
    tracer_picture(&tracer, &scene.camera, size, 4, 7, 1, one);
    tracer_picture(&tracer, &scene.camera, size, 4, 7, 3, two);
    int on_floor = 0;
    for (int i = 0; i < 256; i++) {
        for (int c = 0; c < 3; c++)
            assert_true(one[i].radiance.mean[c] == two[i].radiance.mean[c]);
        if (one[i].normal[1] > 0.999 && fabs(one[i].point[1]) < 1e-3) {
            // Walls at x = 0 and z = 559.2 are not nearer than this.
            const double walls = fmin(one[i].point[0], 559.2 - one[i].point[2]);
            assert_true(one[i].clearance <= walls + 1e-4);
            on_floor++;
        }
    }
    assert_true(on_floor > 20);
    // Rows go up: the lowest one sees the floor.
    assert_true(fabs(one[8].point[1]) < 1e-3);
    tracer_clear(&tracer);
    scene_clear(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_furnace),
        cmocka_unit_test(test_lambert),
        cmocka_unit_test(test_picture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
