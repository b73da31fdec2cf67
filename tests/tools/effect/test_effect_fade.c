// SPDX-License-Identifier: BSD-3-Clause
// A fade is the weighted mean of its scenes, in linear light.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "tests/tools/effect/pictures.h"

static const int size[2] = {16, 8};
enum { SCENES = 3 };
// Linear values that floats have, beyond 1 and 0 too.
static const float colour[SCENES][3] = {
    {0.25f, 1.0f, 0.0f}, {0.75f, 0.125f, 1.0f}, {0.5f, 0.0f, 0.0625f}};

static void make_colour(struct scene *scene, const float rgb[3])
{
    const double middle[2] = {0.0, 0.0}, half[2] = {100.0, 100.0};
    struct scene_build build = empty_scene(scene, size);
    add_rectangle(&build, add_colour(&build, rgb[0], rgb[1], rgb[2]), 4.0, middle, half, 0.0);
    end_scene(&build);
}

// Every pixel is sum w_s c_s / sum w, rounded once: colours are uniform, alpha is 1.
static void check_fade(weft_context *context, const double weights[SCENES], unsigned effects,
                       int count)
{
    struct scene scene[SCENES];
    struct effect_params params = {EFFECT_DEFAULTS};
    const struct scene *scenes[SCENES];
    double sum = 0.0;
    params.effects = effects | EFFECT_FADE;
    params.scene_count = SCENES;
    params.frames = count;
    for (int s = 0; s < SCENES; s++) {
        make_colour(&scene[s], colour[s]);
        params.scene[s] = scenes[s] = &scene[s];
        params.fade[s] = weights[s];
        sum += weights[s];
    }
    params.size[0] = size[0];
    params.size[1] = size[1];
    struct effect_plan plan = plan_made(&params);
    struct picture picture = draw_frames(
        context, &plan, scenes,
        (struct weft_accumulator_params){.method = WEFT_ACCUMULATE_EXACT, .frame_bits = 32}, 0, 0);
    for (int c = 0; c < 4; c++) {
        double expected = 0.0;
        for (int s = 0; s < SCENES; s++)
            expected += weights[s] / sum * (c < 3 ? colour[s][c] : 1.0);
        // Frames' weights are rounded, and the mean is; floats hold the colours.
        const double rounding = 0x1p-24 * fabs(expected) + 1e-12;
        for (int y = 0; y < size[1]; y++)
            for (int x = 0; x < size[0]; x++)
                assert_near(pixel_at(&picture, c, x, y), expected, rounding, "pixel");
    }
    assert_true(picture.report.counted == plan.count);
    free(picture.value);
    effect_plan_clear(&plan);
    for (int s = 0; s < SCENES; s++)
        scene_clear(&scene[s]);
}

static void a_fade_is_its_weights_in_linear_light(void **state)
{
    (void)state;
    static const double weights[][SCENES] = {
        {1.0, 1.0, 1.0}, {0.3, 0.7, 0.0}, {1.0, 0.0, 0.0}, {0.1, 0.2, 0.4}, {2.0, -0.5, 0.25}};
    int checked = 0;
    for (size_t i = 0; i < WEFT_COUNT(weights); i++)
        for (int c = 0; c < 2 && contexts[c]; c++, checked++) {
            check_fade(contexts[c], weights[i], 0, 0);
            check_fade(contexts[c], weights[i], EFFECT_ANTIALIAS, 8);
        }
    assert_true(checked >= (int)WEFT_COUNT(weights));
}

// An edge that fades into another one: each is anti-aliased, and their mean is the picture.
static void faded_edges_are_anti_aliased(void **state)
{
    (void)state;
    struct scene scene[2];
    make_half_plane(&scene[0], size, 0.4, 0.3);
    make_half_plane(&scene[1], size, 2.0, -0.7);
    const struct scene *const scenes[2] = {&scene[0], &scene[1]};
    struct picture faded = {.value = NULL}, alone[2];
    for (int i = 0; i < 3; i++) {
        const bool fades = i == 2;
        struct effect_plan plan =
            plan_made(effect_params(.effects = EFFECT_ANTIALIAS | (fades ? EFFECT_FADE : 0),
                                    .scene = {scenes[fades ? 0 : i], fades ? scenes[1] : NULL},
                                    .scene_count = fades ? 2 : 1, .fade = {0.25, 0.75},
                                    .frames = 66, .size = {size[0], size[1]}));
        struct picture picture = draw_frames(
            contexts[0], &plan, fades ? scenes : &scenes[i],
            (struct weft_accumulator_params){.method = WEFT_ACCUMULATE_EXACT, .frame_bits = 32}, 0,
            0);
        if (fades)
            faded = picture;
        else
            alone[i] = picture;
        effect_plan_clear(&plan);
    }
    int between = 0;
    for (int y = 0; y < size[1]; y++)
        for (int x = 0; x < size[0]; x++) {
            const double a = pixel_at(&alone[0], 0, x, y), b = pixel_at(&alone[1], 0, x, y);
            assert_near(pixel_at(&faded, 0, x, y), 0.25 * a + 0.75 * b, 2e-7, "pixel");
            between += (a > 0.0 && a < 1.0) || (b > 0.0 && b < 1.0);
        }
    assert_true(between > 10);
    free(faded.value);
    for (int s = 0; s < 2; s++) {
        free(alone[s].value);
        scene_clear(&scene[s]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_fade_is_its_weights_in_linear_light),
        cmocka_unit_test(faded_edges_are_anti_aliased),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
