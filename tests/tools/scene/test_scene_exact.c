// SPDX-License-Identifier: BSD-3-Clause
// Exact pictures: against areas of half-planes and polygons by formulas, and against many samples.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "tools/common/random.h"
#include "tools/scene/build.h"
#include "tools/scene/exact.h"

// ---- scenes by pixels ---------------------------------------------------------------------------

// A scene whose picture has size x size pixels; the camera sees 1 to each side at a depth of 1.
struct flat {
    struct scene scene;
    struct scene_build build;
    int size;
};

static void begin(struct flat *flat, int size)
{
    memset(flat, 0, sizeof *flat);
    flat->build.scene = &flat->scene;
    flat->size = size;
    flat->scene.camera =
        *weft_camera(.fovy_degrees = 90.0, .near_distance = 0.25, .far_distance = 8.0);
}

// A triangle of one colour by the places of its corners in pixels, and their depths; an object of
// its own. Corners are rounded to floats: they are written back.
static void add(struct flat *flat, double corner[3][3], const float colour[3], bool single_sided)
{
    double modelled[3][3];
    const struct scene_material material = {.reflectance = {colour[0], colour[1], colour[2]},
                                            .unlit = true,
                                            .single_sided = single_sided};
    for (int i = 0; i < 3; i++) {
        const float depth = (float)corner[i][2];
        corner[i][2] = depth;
        modelled[i][2] = -corner[i][2];
        for (int k = 0; k < 2; k++) {
            // volatile: GCC 12 drops the rounding of pairs of numbers at -O2.
            const volatile float at = (float)((2.0 * corner[i][k] / flat->size - 1.0) * depth);
            modelled[i][k] = at;
            corner[i][k] = 0.5 * flat->size * (1.0 + modelled[i][k] / depth);
        }
    }
    scene_build_object(&flat->build, "", scene_build_material(&flat->build, &material));
    scene_build_polygon(&flat->build, 3, (const double(*)[3])modelled, NULL, NULL);
}

static const float WHITE[3] = {1.0f, 1.0f, 1.0f};

// The picture; ends the scene.
static double *draw_with(struct flat *flat, struct weft_kernel filter, double width, double *error)
{
    double *out = malloc(4 * (size_t)(flat->size * flat->size) * sizeof *out);
    assert_non_null(out);
    assert_int_equal(scene_build_end(&flat->build, &log_to_stderr), WEFT_OK);
    assert_int_equal(
        scene_exact_draw(scene_exact_params(.scene = &flat->scene, .size = {flat->size, flat->size},
                                            .filter = filter, .filter_width = width,
                                            .log = &log_to_stderr),
                         out, error),
        WEFT_OK);
    scene_clear(&flat->scene);
    return out;
}

static double *draw(struct flat *flat)
{
    double error;
    double *out = draw_with(flat, (struct weft_kernel){0}, 0.0, &error);
    assert_true(error >= 0.0 && error < 1e-10);
    return out;
}

// ---- half-planes --------------------------------------------------------------------------------

// A triangle that is half a plane as far as the picture and its filters reach: an edge through
// (x, y), the inside being where the angle's direction points away from. normal: to the outside.
static void add_half(struct flat *flat, double x, double y, double angle, double normal[2],
                     double point[2])
{
    const double n[2] = {cos(angle), sin(angle)}, reach = 100.0;
    double corner[3][3] = {{x + reach * n[1], y - reach * n[0], 1.0},
                           {x - reach * n[1], y + reach * n[0], 1.0},
                           {x - reach * n[0], y - reach * n[1], 1.0}};
    add(flat, corner, WHITE, false);
    normal[0] = corner[1][1] - corner[0][1];
    normal[1] = corner[0][0] - corner[1][0];
    point[0] = corner[0][0];
    point[1] = corner[0][1];
}

static double find_distance(const double normal[2], const double point[2], double x, double y)
{
    return (normal[0] * (point[0] - x) + normal[1] * (point[1] - y)) / hypot(normal[0], normal[1]);
}

enum { HALF = 6, ANGLES = 144 };

static void test_square(void **state)
{
    (void)state;
    int mixed = 0;
    for (int i = 0; i < ANGLES; i++) {
        struct flat flat;
        double normal[2], point[2];
        begin(&flat, HALF);
        add_half(&flat, 2.5 + 0.01 * i, 3.1 - 0.007 * i, 2.0 * M_PI * i / ANGLES, normal, point);
        double *picture = draw(&flat);
        for (int k = 0; k < HALF * HALF; k++) {
            const double d = find_distance(normal, point, k % HALF + 0.5, k / HALF + 0.5);
            const double wanted = weft_edge_square(normal, d);
            assert_near(picture[4 * k + 3], wanted, 1e-12, "alpha");
            assert_near(picture[4 * k], wanted, 1e-12, "red");
            mixed += wanted > 0.0 && wanted < 1.0;
        }
        free(picture);
    }
    assert_true(mixed > 5 * ANGLES);
}

// Kernels of all kinds, at their own and at other widths.
static void test_kernels(void **state)
{
    (void)state;
    static const struct {
        const char *kernel;
        double width;
    } list[] = {
        {"nearest", 1.7},  {"linear", 0.0},      {"bspline3", 0.0},  {"mitchell", 0.0},
        {"mitchell", 3.1}, {"catmull-rom", 0.0}, {"lanczos:3", 0.0}, {"lanczos:2+unit", 0.0},
        {"gaussian", 0.0}, {"gaussian", 2.6},    {"bspline5", 0.0},
    };
    for (size_t i = 0; i < sizeof list / sizeof *list; i++)
        for (int turn = 0; turn < 7; turn++) {
            struct weft_kernel kernel;
            struct flat flat;
            double normal[2], point[2], error;
            assert_int_equal(weft_kernel_parse(&log_to_stderr, list[i].kernel, &kernel), WEFT_OK);
            begin(&flat, HALF);
            add_half(&flat, 2.7, 3.2, M_PI * turn / 3.5 + (turn == 3 ? 0.0 : 0.13 * turn), normal,
                     point);
            double *picture = draw_with(&flat, kernel, list[i].width, &error);
            assert_true(error > 0.0 && error < 1e-9);
            for (int k = 0; k < HALF * HALF; k += turn ? 5 : 1) {
                struct weft_edge_value wanted;
                const double d = find_distance(normal, point, k % HALF + 0.5, k / HALF + 0.5);
                assert_int_equal(
                    weft_edge_kernel(&log_to_stderr, &kernel, list[i].width, normal, d, &wanted),
                    WEFT_OK);
                assert_near(picture[4 * k + 1], wanted.value, 1e-12 + error + wanted.error,
                            list[i].kernel);
            }
            free(picture);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_square),
        cmocka_unit_test(test_kernels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
