// SPDX-License-Identifier: BSD-3-Clause
// Virtual lights: how many, where, and how bright; on the CPU.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "tests/support/common.h"
#include "tests/tools/effect/boxes.h"
#include "tools/effect/lights.h"

static const double LOW[3] = {-1.0, 0.0, -2.0}, HIGH[3] = {1.0, 2.0, 2.0};

static struct effect_virtual_lights make(const struct effect_lights_params *params)
{
    struct effect_virtual_lights lights;
    assert_int_equal(effect_lights_make(params, &lights), WEFT_OK);
    return lights;
}

// Bounces of a box that is grey and emits 1 everywhere are told by the intensity: all lights of a
// bounce have the same.
static int count_alike(const struct effect_virtual_lights *lights, double intensity)
{
    int count = 0;
    for (int64_t i = 0; i < lights->count; i++)
        if (fabs(lights->light[i].intensity[1] - intensity) <= 1e-9 * intensity)
            count++;
    return count;
}

// Of N paths floor(N rho^j) come to bounce j of a closed box; each bounce has the power area rho^j
// (times pi), and the mean over all M lights is the picture.
static void test_paths(void **state)
{
    (void)state;
    static const float reflectances[] = {0.0f, 0.3f, 0.5f, 0.7f, 0.9f};
    const double area = 2.0 * (2 * 2 + 2 * 4 + 2 * 4);
    int bounces = 0;
    for (size_t r = 0; r < WEFT_COUNT(reflectances); r++) {
        struct scene scene;
        const double rho = reflectances[r];
        box_add_room(box_create(&scene), LOW, HIGH, rho, 1.0);
        struct effect_virtual_lights lights =
            make(effect_lights_params(.scene = &scene, .count = 1000, .paths = true));
        assert_int_equal(lights.paths, 1000);
        assert_near(lights.mean_reflectance, rho, 1e-12, "mean reflectance");
        assert_true((double)lights.count < 1000.0 / (1.0 - rho) + 1e-9);
        int64_t expected = 0;
        for (int j = 0; floor(1000.0 * pow(rho, j) + 1e-6) >= 1.0; j++, bounces++) {
            const int64_t survivors = (int64_t)floor(1000.0 * pow(rho, j) + 1e-6);
            expected += survivors;
            // Lights of bounce j: L area rho^j M / survivors each.
            const double each = area * pow(rho, j) * (double)lights.count / (double)survivors;
            assert_true(count_alike(&lights, each) >= survivors);
            assert_int_equal(lights.bounces >= j, true);
        }
        assert_int_equal(lights.count, expected);
        effect_lights_clear(&lights);
        scene_clear(&scene);
    }
    assert_true(bounces > 60);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_paths)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
