// SPDX-License-Identifier: BSD-3-Clause
// Soft shadows: the penumbra of a lamp is the share of it that is seen, from plan to picture.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "tests/tools/effect/pictures.h"

// A floor that fills the picture, a unit a pixel, at 32 from the eye; 40 above it, behind the eye,
// half a plane that throws the shadow; the lamp is 80 above the floor, 24 wide. A point of the
// floor, the edge and a place on the lamp are in line where
//     edge = place * share + point * (1 - share), share = 40 / 80.
static const int size[2] = {72, 64};
static const double floor_depth = 32.0, occluder_height = 40.0, lamp_height = 80.0, side = 24.0;

static void make_scene(struct scene *scene, enum scene_light_shape shape, double angle,
                       double distance)
{
    const double reach = 150.0, middle[2] = {0.0, 0.0}, floor_half[2] = {100.0, 100.0};
    const double away[2] = {cos(angle) * (distance - reach), sin(angle) * (distance - reach)};
    const double half[2] = {reach, reach};
    const struct scene_material white = {.name = "white", .reflectance = {1.0f, 1.0f, 1.0f}};
    const struct scene_light lamp = {.shape = shape,
                                     .falloff = SCENE_FALLOFF_NONE,
                                     .middle = {0.0, 0.0, lamp_height - floor_depth},
                                     .u = {side, 0.0, 0.0},
                                     .v = {0.0, -side, 0.0},
                                     .radiance = {1.0, 1.0, 1.0}};
    struct scene_build build = empty_scene(scene, size);
    const int material = scene_build_material(&build, &white);
    add_rectangle(&build, material, floor_depth, middle, floor_half, 0.0);
    add_rectangle(&build, material, floor_depth - occluder_height, away, half, angle);
    scene_build_lamp(&build, &lamp);
    end_scene(&build);
}

// The half plane hides the places with p . n <= limit, from a point of the floor.
static double find_limit(const double normal[2], double distance, int x, int y)
{
    const double share = occluder_height / lamp_height;
    const double along =
        normal[0] * (x + 0.5 - 0.5 * size[0]) + normal[1] * (y + 0.5 - 0.5 * size[1]);
    return (distance - along * (1.0 - share)) / share;
}

static double find_seen(enum scene_light_shape shape, const double normal[2], double limit)
{
    return 1.0 - (shape == SCENE_LIGHT_DISC ? weft_edge_disc(limit / side)
                                            : weft_edge_square(normal, limit / side));
}

// What half a texel of the map, along both of its axes, is on the floor in pixels, at most: of a
// map that sees 90 degrees to each side of the light's way down, 2 / size of its distance.
static double find_texel(weft_context *context, const struct scene *scene)
{
    scene_drawing *drawing;
    struct scene_shadow_info info;
    assert_int_equal(scene_drawing_create(scene_drawing_params(.scene = scene, .context = context,
                                                               .log = &log_to_stderr),
                                          &drawing),
                     WEFT_OK);
    scene_drawing_get_shadow(drawing, &info);
    scene_drawing_destroy(&drawing);
    assert_true(info.size >= 256);
    return M_SQRT2 * lamp_height / info.size;
}

// Each frame's shadow ends within half a texel of where it should, so that the picture is that of
// places on the lamp that are off by as much: the penumbra is side wide (share 1/2), its slope at
// most sqrt(2) / side across the square's diagonal, 4 / (pi side) of a disc. The set of places adds
// its discrepancy.
static void check(weft_context *context, enum scene_light_shape shape, const char *jitter,
                  int count, double angle, double distance)
{
    struct scene scene;
    make_scene(&scene, shape, angle, distance);
    const double normal[2] = {cos(angle), sin(angle)};
    struct effect_plan plan =
        plan_made(effect_params(.effects = EFFECT_SOFT_SHADOW, .scene = {&scene}, .scene_count = 1,
                                .size = {size[0], size[1]}, .frames = count,
                                .jitter = weft_jitter_find(jitter)));
    struct picture picture = draw_plan(context, &plan, &scene);
    const double texel = find_texel(context, &scene), slope = M_SQRT2 / side;
    const double bound = plan.set[EFFECT_LAMP].discrepancy + texel * slope + 1e-5;
    double worst = 0.0, against_plan = 0.0;
    int between = 0;
    for (int y = 0; y < size[1]; y++)
        for (int x = 0; x < size[0]; x++) {
            const double limit = find_limit(normal, distance, x, y);
            const double exact = find_seen(shape, normal, limit);
            const double value = pixel_at(&picture, 0, x, y);
            double sum = 0.0, near = 0.0;
            for (int64_t k = 0; k < plan.count; k++) {
                const double *p = plan.frames[k].show.light[0].position;
                const double left = p[0] * normal[0] + p[1] * normal[1] - limit;
                sum += left > 0.0 ? plan.frames[k].weight : 0.0;
                near += fabs(left) <= 2.0 * texel ? plan.frames[k].weight : 0.0;
            }
            against_plan = larger(against_plan, fabs(value - sum) - near);
            worst = larger(worst, fabs(value - exact));
            between += exact > 0.0 && exact < 1.0;
        }
    print_message("%s of %d, edge at %.2f: error %.4f, bound %.4f, %d pixels of penumbra\n", jitter,
                  count, angle, worst, bound, between);
    assert_true(between > 1000);
    assert_true(against_plan <= 1e-5);
    assert_true(worst <= bound);
    free(picture.value);
    effect_plan_clear(&plan);
    scene_clear(&scene);
}

static void the_penumbra_of_a_square_is_its_visible_share(void **state)
{
    (void)state;
    check(contexts[0], SCENE_LIGHT_SQUARE, "j8", 8, 0.0, 1.3);
    check(contexts[0], SCENE_LIGHT_SQUARE, "j66", 66, M_PI_4, -2.0);
    check(contexts[0], SCENE_LIGHT_SQUARE, "sobol", 64, M_PI_2, 0.0);
    check(contexts[contexts[1] ? 1 : 0], SCENE_LIGHT_SQUARE, "halton", 256, 0.6, 2.2);
}

static void the_penumbra_of_a_disc_is_its_visible_share(void **state)
{
    (void)state;
    check(contexts[0], SCENE_LIGHT_DISC, "j66", 66, 0.0, 1.3);
    check(contexts[contexts[1] ? 1 : 0], SCENE_LIGHT_DISC, "r2", 128, M_PI_4, -2.0);
}

// Without the effect it is the hard shadow of the lamp's middle.
static void without_the_effect_shadows_are_hard(void **state)
{
    (void)state;
    struct scene scene;
    make_scene(&scene, SCENE_LIGHT_SQUARE, 0.0, 0.0);
    struct effect_plan plan =
        plan_made(effect_params(.effects = EFFECT_ANTIALIAS, .scene = {&scene}, .scene_count = 1,
                                .size = {size[0], size[1]}, .frames = 1));
    struct picture picture = draw_plan(contexts[0], &plan, &scene);
    const double texel = find_texel(contexts[0], &scene);
    const double normal[2] = {1.0, 0.0};
    int checked = 0;
    for (int y = 0; y < size[1]; y++)
        for (int x = 0; x < size[0]; x++) {
            const double limit = find_limit(normal, 0.0, x, y);
            if (fabs(limit) <= 2.0 * texel)
                continue;
            assert_near(pixel_at(&picture, 0, x, y), limit < 0.0, 1e-6, "pixel");
            checked++;
        }
    assert_true(checked > size[0] * size[1] * 9 / 10);
    free(picture.value);
    effect_plan_clear(&plan);
    scene_clear(&scene);
}

// Unasked: a frame a pixel of the widest penumbra, 24 of them here, as the scene estimates it.
static void penumbrae_ask_for_a_frame_a_pixel(void **state)
{
    (void)state;
    struct scene scene;
    make_scene(&scene, SCENE_LIGHT_SQUARE, 0.0, 0.0);
    struct effect_plan plan =
        plan_made(effect_params(.effects = EFFECT_SOFT_SHADOW, .scene = {&scene}, .scene_count = 1,
                                .size = {size[0], size[1]}));
    assert_int_equal(plan.count, plan.needed);
    assert_in_range(plan.count, 22, 40);
    effect_plan_clear(&plan);
    scene_clear(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_penumbra_of_a_square_is_its_visible_share),
        cmocka_unit_test(the_penumbra_of_a_disc_is_its_visible_share),
        cmocka_unit_test(without_the_effect_shadows_are_hard),
        cmocka_unit_test(penumbrae_ask_for_a_frame_a_pixel),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
