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
#include "tests/tools/scene/pictures.h"

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

int main(void)
{
    if (WITHOUT_GL)
        return EXIT_SKIPPED;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_projected),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
