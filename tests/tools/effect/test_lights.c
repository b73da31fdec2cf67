// SPDX-License-Identifier: BSD-3-Clause
// Virtual lights: how many, where, and how bright; on the CPU.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "tests/support/common.h"
#include "tests/tools/effect/path_tracer.h"
#include "tools/effect/lights/lights.h"
#include "tools/scene/build.h"

static struct scene named(const char *name)
{
    struct scene scene;
    assert_int_equal(
        scene_make(scene_params(.name = name, .size = {16, 16}, .log = &log_to_stderr), &scene),
        WEFT_OK);
    return scene;
}

static struct scene furnace(double reflectance)
{
    char name[32];
    snprintf(name, sizeof name, "furnace:%g", reflectance);
    return named(name);
}

static struct effect_virtual_lights make_lights(struct effect_lights_params params)
{
    struct effect_virtual_lights lights;
    params.log = &log_to_stderr;
    assert_int_equal(effect_lights_make(&params, &lights), WEFT_OK);
    return lights;
}
#define make(...) make_lights((struct effect_lights_params){EFFECT_LIGHTS_DEFAULTS __VA_ARGS__})

static double area_of(const struct scene *scene)
{
    struct scene_triangles triangles;
    double area = 0.0;
    assert_int_equal(scene_triangles_make(scene, 0.0, &triangles), WEFT_OK);
    for (size_t t = 0; t < triangles.count; t++)
        area += triangles.list[t].area;
    scene_triangles_clear(&triangles);
    return area;
}

// ---- Keller's paths -----------------------------------------------------------------------------

// Of N paths floor(N rho^j), the first ones, come to bounce j of a closed box. What they give
// together is its emission, radiance times area, times rho^j; and M < N / (1 - rho).
static void test_paths(void **state)
{
    (void)state;
    static const double reflectances[] = {0.0, 0.3, 0.5, 0.7, 0.9};
    static const int64_t paths = 1000;
    int bounces = 0;
    for (size_t r = 0; r < WEFT_COUNT(reflectances); r++) {
        struct scene scene = furnace(reflectances[r]);
        const double rho = (float)reflectances[r], area = area_of(&scene);
        struct effect_virtual_lights lights = make(.scene = &scene, .count = paths, .paths = true);
        assert_int_equal(lights.paths, paths);
        assert_near(lights.mean_reflectance, rho, 1e-12, "mean reflectance");
        assert_true((double)lights.count <= paths / (1.0 - rho) * (1.0 + 1e-12));
        int64_t expected = 0, found = 0;
        for (int j = 0; floor(paths * pow(rho, j) + 1e-5) >= 1.0; j++, bounces++) {
            const int64_t survivors = (int64_t)floor(paths * pow(rho, j) + 1e-5);
            expected += survivors;
            // All lights of a bounce have the same intensity here.
            const double each = area * pow(rho, j) * (double)lights.count / (double)survivors;
            int64_t alike = 0;
            for (int64_t i = 0; i < lights.count; i++)
                alike += fabs(lights.light[i].intensity[1] - each) <= 1e-7 * each;
            assert_true(alike >= survivors);
            found += survivors;
            assert_true(lights.bounces >= j);
        }
        assert_int_equal(lights.count, expected);
        assert_int_equal(lights.count, found);
        effect_lights_clear(&lights);
        scene_clear(&scene);
    }
    assert_true(bounces > 60);
}

// Survivors are the first: fewer paths are the beginning of more, in the order of lights too.
static void test_first_survive(void **state)
{
    (void)state;
    struct scene scene = named("cornell");
    struct effect_virtual_lights few = make(.scene = &scene, .count = 100, .paths = true),
                                 many = make(.scene = &scene, .count = 400, .paths = true);
    assert_true(few.count > 100 && few.count < many.count);
    for (int64_t i = 0; i < few.count; i++)
        for (int c = 0; c < 3; c++) {
            assert_true(few.light[i].position[c] == many.light[i].position[c]);
            assert_true(few.light[i].normal[c] == many.light[i].normal[c]);
        }
    effect_lights_clear(&few);
    effect_lights_clear(&many);
    scene_clear(&scene);
}

// ---- as many as were asked for ------------------------------------------------------------------

// Radiance times area of all lights together is that of the scene in the limit: in a closed box
// area E / (1 - rho). The power of many lights, each an equal part of it, is exact but for the
// walk.
static void test_power(void **state)
{
    (void)state;
    static const double reflectances[] = {0.0, 0.3, 0.5, 0.7, 0.9};
    for (size_t r = 0; r < WEFT_COUNT(reflectances); r++) {
        struct scene scene = furnace(reflectances[r]);
        const double expected = area_of(&scene) / (1.0 - (float)reflectances[r]);
        for (uint64_t seed = 0; seed < 3; seed++) {
            struct effect_virtual_lights lights =
                make(.scene = &scene, .count = 1024, .seed = seed, .clamp = 0.0);
            double sum = 0.0;
            assert_int_equal(lights.count, 1024);
            for (int64_t i = 0; i < lights.count; i++) {
                sum += lights.light[i].intensity[0] / (double)lights.count;
                assert_true(lights.light[i].most == 0.0);
            }
            // The walk leaves out a share below 1 / N.
            assert_true(sum <= expected * (1.0 + 1e-9));
            assert_true(sum >= expected * (1.0 - 1.0 / (double)lights.paths - 1e-9));
            effect_lights_clear(&lights);
        }
        scene_clear(&scene);
    }
}

// Irradiance of all lights, seen from a point of a surface.
static void light_up(const struct tracer *tracer, const struct effect_virtual_lights *lights,
                     int64_t count, const double point[3], const double normal[3], size_t triangle,
                     double out[3])
{
    out[0] = out[1] = out[2] = 0.0;
    for (int64_t k = 0; k < count; k++) {
        const struct scene_point_light *light = &lights->light[k];
        double to[3], end[3], square = 0.0, here = 0.0, there = 0.0;
        for (int i = 0; i < 3; i++) {
            to[i] = light->position[i] - point[i];
            end[i] = point[i] + (1.0 - 1e-9) * to[i];
            square += to[i] * to[i];
            here += to[i] * normal[i];
            there -= to[i] * light->normal[i];
        }
        if (!(here > 0.0 && there > 0.0) || !tracer_sees(tracer, point, triangle, end, SIZE_MAX))
            continue;
        for (int i = 0; i < 3; i++)
            out[i] += light->intensity[i] * here * there / (square * square) / (double)count;
    }
}

// The Cornell box's floor, walls and ceiling, lit by lights of either kind and by the path tracer.
// Lights are told apart by seeds: their mean over seeds is within 4.5 of its standard errors.
static void test_irradiance(void **state)
{
    (void)state;
    enum { SEEDS = 8 };
    struct scene scene = named("cornell");
    struct tracer tracer;
    tracer_make(&scene, 0.0, &tracer);
    static const double points[][2][3] = {
        {{450.0, 0.0, 100.0}, {0.0, 1.0, 0.0}},     // floor
        {{100.0, 548.79, 150.0}, {0.0, -1.0, 0.0}}, // ceiling: no direct light
        {{0.01, 300.0, 300.0}, {1.0, 0.0, 0.0}},    // green wall
    };
    for (size_t p = 0; p < WEFT_COUNT(points); p++)
        for (int paths = 0; paths < 2; paths++) {
            const struct traced traced = tracer_irradiance(
                &tracer, points[p][0], points[p][1], SIZE_MAX, TRACED_ALL_BOUNCES, 40000, p + 1);
            double mean[3] = {0.0}, square[3] = {0.0};
            for (uint64_t seed = 1; seed <= SEEDS; seed++) {
                struct effect_virtual_lights lights =
                    make(.scene = &scene, .count = 1000, .paths = paths == 1, .seed = seed);
                double one[3];
                light_up(&tracer, &lights, lights.count, points[p][0], points[p][1], SIZE_MAX, one);
                for (int c = 0; c < 3; c++) {
                    mean[c] += one[c] / SEEDS;
                    square[c] += one[c] * one[c] / SEEDS;
                }
                effect_lights_clear(&lights);
            }
            for (int c = 0; c < 3; c++) {
                const double variance = fmax(square[c] - mean[c] * mean[c], 0.0) / (SEEDS - 1);
                const double error = sqrt(variance + traced.error[c] * traced.error[c]);
                assert_true(error < 0.1 * traced.mean[c]);
                assert_near(mean[c], traced.mean[c], 4.5 * error, "irradiance");
            }
        }
    tracer_clear(&tracer);
    scene_clear(&scene);
}

// The first lights of the list are a smaller sample of all: a quarter of them has the power of all.
static void test_first_are_sample(void **state)
{
    (void)state;
    struct scene scene = named("cornell");
    for (int paths = 0; paths < 2; paths++) {
        struct effect_virtual_lights lights =
            make(.scene = &scene, .count = 4096, .paths = paths == 1);
        double all = 0.0, part = 0.0;
        const int64_t quarter = lights.count / 4;
        for (int64_t i = 0; i < lights.count; i++) {
            const double each = lights.light[i].intensity[0];
            all += each / (double)lights.count;
            part += i < quarter ? each / (double)quarter : 0.0;
        }
        assert_near(part, all, 0.03 * all, "a quarter of the lights");
        effect_lights_clear(&lights);
    }
    scene_clear(&scene);
}

// Each light lies on a surface, and its normal is that surface's on the side where light came from.
static void test_places(void **state)
{
    (void)state;
    struct scene scene = named("cornell");
    struct scene_triangles triangles;
    assert_int_equal(scene_triangles_make(&scene, 0.0, &triangles), WEFT_OK);
    struct effect_virtual_lights lights = make(.scene = &scene, .count = 500);
    int on_lamp = 0;
    for (int64_t i = 0; i < lights.count; i++) {
        const struct scene_point_light *light = &lights.light[i];
        double nearest = INFINITY;
        for (size_t t = 0; t < triangles.count; t++) {
            double height = 0.0, along = 0.0;
            for (int k = 0; k < 3; k++) {
                height += (light->position[k] - triangles.list[t].corner[0][k]) *
                          triangles.list[t].normal[k];
                along += light->normal[k] * triangles.list[t].normal[k];
            }
            if (fabs(fabs(along) - 1.0) < 1e-9)
                nearest = fmin(nearest, fabs(height));
        }
        assert_true(nearest < 1e-6);
        assert_true(light->shadowed && light->falloff == SCENE_FALLOFF_RADIANCE);
        const double *at = light->position;
        on_lamp +=
            at[0] > 213.0 && at[0] < 343.0 && at[1] > 548.7 && at[2] > 227.0 && at[2] < 332.0;
    }
    // The lamp has its part of the lights, fewer than its share of the power.
    assert_in_range(on_lamp, 20, 150);
    effect_lights_clear(&lights);
    scene_triangles_clear(&triangles);
    scene_clear(&scene);
}

// ---- seeds, time, lamps that are not seen
// --------------------------------------------------------

static bool is_same(const struct effect_virtual_lights *a, const struct effect_virtual_lights *b)
{
    bool same = a->count == b->count;
    for (int64_t i = 0; i < a->count && same; i++)
        for (int c = 0; c < 3; c++)
            same = same && a->light[i].position[c] == b->light[i].position[c] &&
                   a->light[i].intensity[c] == b->light[i].intensity[c];
    return same;
}

static void test_seeds(void **state)
{
    (void)state;
    struct scene scene = named("cornell");
    for (int paths = 0; paths < 2; paths++) {
        struct effect_virtual_lights lights[4];
        for (int s = 0; s < 4; s++)
            lights[s] = make(.scene = &scene, .count = 200, .paths = paths == 1,
                             .seed = (const uint64_t[]){0, 1, 2, 1}[s]);
        assert_true(is_same(&lights[1], &lights[3]));
        assert_false(is_same(&lights[0], &lights[1]));
        assert_false(is_same(&lights[1], &lights[2]));
        for (int s = 0; s < 4; s++)
            effect_lights_clear(&lights[s]);
    }
    scene_clear(&scene);
}

// A floor below a lamp that is not seen.
static struct scene floor_below(const struct scene_light *lamp)
{
    struct scene scene = {.name = "floor"};
    struct scene_build build = {.scene = &scene};
    const double quad[4][3] = {
        {-50.0, 0.0, 50.0}, {50.0, 0.0, 50.0}, {50.0, 0.0, -50.0}, {-50.0, 0.0, -50.0}};
    scene_build_object(
        &build, "floor",
        scene_build_material(
            &build, &(struct scene_material){.name = "grey", .reflectance = {0.25f, 0.5f, 0.75f}}));
    scene_build_polygon(&build, 4, quad, NULL, NULL);
    scene_build_lamp(&build, lamp);
    assert_int_equal(scene_build_end(&build, &log_to_stderr), WEFT_OK);
    return scene;
}

// All of a square's or disc's light falls on the floor, nearly, and half of a point's: what the
// floor throws back is that, times its reflectance.
static void test_lamps(void **state)
{
    (void)state;
    for (int shape = 0; shape < SCENE_LIGHT_SHAPE_COUNT; shape++) {
        const struct scene_light lamp = {.shape = (enum scene_light_shape)shape,
                                         .middle = {1.0, 0.5, 2.0},
                                         .u = {0.0, 0.0, 0.5},
                                         .v = {-0.25, 0.0, 0.0},
                                         .radiance = {2.0, 4.0, 8.0}};
        struct scene scene = floor_below(&lamp);
        struct effect_virtual_lights lights = make(.scene = &scene, .count = 3000, .paths = true);
        double direct[3] = {0.0}, thrown[3] = {0.0};
        int64_t below = 0;
        for (int64_t i = 0; i < lights.count; i++) {
            const bool on_floor = lights.light[i].position[1] < 1e-6;
            below += on_floor;
            for (int c = 0; c < 3; c++)
                *(on_floor ? &thrown[c] : &direct[c]) +=
                    lights.light[i].intensity[c] / (double)lights.count;
        }
        assert_int_equal(lights.bounces, 1);
        assert_int_equal(lights.paths, 3000);
        const bool point = shape == SCENE_LIGHT_POINT;
        const double area = point ? 1.0 : 0.125 * (shape == SCENE_LIGHT_DISC ? M_PI / 4.0 : 1.0);
        // Points: 4 pi I, half of it downwards, leaves as pi times radiance times area.
        const double part = point ? 2.0 : 1.0;
        assert_true(below > (point ? 700 : 1450) && below <= 1500);
        for (int c = 0; c < 3; c++) {
            const double expected = lamp.radiance[c] * area;
            assert_near(direct[c], expected, 1e-9 * expected, "of the lamp");
            assert_near(thrown[c], part * expected * scene.materials[0].reflectance[c],
                        0.02 * expected, "of the floor");
        }
        effect_lights_clear(&lights);
        scene_clear(&scene);
    }
}

// What moves is where it is at the time.
static void test_time(void **state)
{
    (void)state;
    struct scene scene = floor_below(&(struct scene_light){.shape = SCENE_LIGHT_SQUARE,
                                                           .middle = {0.0, 1.0, 0.0},
                                                           .u = {0.0, 0.0, 0.5},
                                                           .v = {-0.5, 0.0, 0.0},
                                                           .radiance = {1.0, 1.0, 1.0}});
    struct scene_key keys[2] = {
        {.time = 0.0, .rotation = {0.0, 0.0, 0.0, 1.0}, .scale = 1.0},
        {.time = 1.0, .position = {0.0, -2.0, 0.0}, .rotation = {0.0, 0.0, 0.0, 1.0}, .scale = 1.0},
    };
    scene.objects[0].path = (struct scene_path){keys, 2};
    for (int t = 0; t < 3; t++) {
        struct effect_virtual_lights lights = make(.scene = &scene, .count = 50, .time = t / 2.0);
        double lowest = INFINITY;
        for (int64_t i = 0; i < lights.count; i++)
            lowest = fmin(lowest, lights.light[i].position[1]);
        assert_near(lowest, -t, 1e-9, "the floor");
        effect_lights_clear(&lights);
    }
    scene.objects[0].path = (struct scene_path){NULL, 0};
    scene_clear(&scene);
}

// The default clamp is a quarter of that of a patch of 1/M of the surfaces, pi M / area.
static void test_clamp(void **state)
{
    (void)state;
    struct scene scene = furnace(0.5);
    struct effect_virtual_lights lights = make(.scene = &scene, .count = 100),
                                 asked = make(.scene = &scene, .count = 100, .clamp = 3.0);
    assert_near(lights.most, M_PI * 25.0 / area_of(&scene), 1e-9, "clamp");
    assert_true(asked.most == 3.0 && asked.light[7].most == 3.0 &&
                lights.light[7].most == lights.most);
    effect_lights_clear(&lights);
    effect_lights_clear(&asked);
    scene_clear(&scene);
}

// ---- what is refused ----------------------------------------------------------------------------

static void refuse(struct effect_lights_params params, enum weft_result expected, const char *text)
{
    struct message message = {{0}, 0};
    const struct weft_log log = {keep_message, &message};
    struct effect_virtual_lights lights = {.count = 7};
    params.log = &log;
    assert_int_equal(effect_lights_make(&params, &lights), expected);
    assert_int_equal(message.count, 1);
    if (!strstr(message.text, text))
        fail_msg("\"%s\" does not say \"%s\"", message.text, text);
    assert_null(lights.light);
    assert_int_equal(lights.count, 0);
}

static void test_errors(void **state)
{
    (void)state;
    struct scene scene = furnace(0.5);
    const struct effect_lights_params good = {EFFECT_LIGHTS_DEFAULTS.scene = &scene, .count = 10};
    struct effect_lights_params bad = good;
    bad.count = 0;
    refuse(bad, WEFT_ERR_ARGUMENT, "0 virtual lights: it must be 1 to 1048576");
    bad.count = EFFECT_MAX_LIGHTS + 1;
    bad.paths = true;
    refuse(bad, WEFT_ERR_ARGUMENT, "1048577 paths");
    bad.count = EFFECT_MAX_LIGHTS;
    refuse(bad, WEFT_ERR_LIMIT, "make more than 1048576 virtual lights");
    bad = good;
    bad.clamp = -1.0;
    refuse(bad, WEFT_ERR_ARGUMENT, "the clamp is -1");
    bad.clamp = INFINITY;
    refuse(bad, WEFT_ERR_ARGUMENT, "the clamp is inf");
    for (int c = 0; c < 3; c++)
        scene.materials[0].reflectance[c] = 1.0f;
    refuse(good, WEFT_ERR_ARGUMENT, "no path ends");
    for (int c = 0; c < 3; c++)
        scene.materials[0].emission[c] = 0.0f;
    refuse(good, WEFT_ERR_ARGUMENT, "nothing emits");
    scene.lights[0] = (struct scene_light){.falloff = SCENE_FALLOFF_NONE, .radiance = {1, 1, 1}};
    scene.light_count = 1;
    refuse(good, WEFT_ERR_ARGUMENT, "lamp 1 of the scene does not fall off");
    scene_clear(&scene);
    effect_lights_clear(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_paths),
        cmocka_unit_test(test_first_survive),
        cmocka_unit_test(test_power),
        cmocka_unit_test(test_irradiance),
        cmocka_unit_test(test_first_are_sample),
        cmocka_unit_test(test_places),
        cmocka_unit_test(test_seeds),
        cmocka_unit_test(test_lamps),
        cmocka_unit_test(test_time),
        cmocka_unit_test(test_clamp),
        cmocka_unit_test(test_errors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
