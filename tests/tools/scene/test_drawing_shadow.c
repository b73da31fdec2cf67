// SPDX-License-Identifier: BSD-3-Clause
// Shadows by maps against rays, in double, and soft ones against the share of a lamp that is seen.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <cmocka.h>

#include "tests/support/common.h"
#include "tests/support/contexts.h"
#include "tests/tools/scene/pictures.h"
#include "tests/tools/scene/traced.h"

// What was found of a picture.
struct tally {
    int lit, hidden, between, edge;
};

// Every pixel of a picture with one light, of reflectance 1, against rays. Those whose surface ends
// within 1/64 of a pixel are left out, and where shadows end within half a texel along each axis of
// the map. texel: largest one, in tangents.
static void compare(const struct scene_triangles *triangles, const struct scene_frame *frame,
                    const float *picture, double texel, struct tally *tally)
{
    const struct scene_point_light *light = &frame->light[0];
    const int *size = frame->camera.size;
    struct traced_camera camera;
    find_camera(&triangles->scene->camera, size, frame->time, &camera);
    double eye[3]; // as shadow_view.h says it
    const double *low = triangles->scene->low, *high = triangles->scene->high;
    const double diagonal = hypot(hypot(high[0] - low[0], high[1] - low[1]), high[2] - low[2]);
    for (int i = 0; i < 3; i++)
        eye[i] = light->position[i] + 0x1p-14 * diagonal * light->normal[i];
    for (int y = 0; y < size[1]; y++)
        for (int x = 0; x < size[0]; x++) {
            struct traced_point point;
            trace_pixel(triangles, &camera, x + 0.5, y + 0.5, &point);
            if (!is_inside(triangles, &camera, x + 0.5, y + 0.5, point.triangle)) {
                tally->edge++;
                continue;
            }
            if (point.triangle == SIZE_MAX)
                continue;
            const double form = find_form(light, &point);
            enum traced_light seen = TRACED_HIDDEN;
            if (form > 0.0)
                seen = trace_light(triangles, &point, eye, texel * M_SQRT1_2 * 1.02);
            tally->lit += seen == TRACED_LIT;
            tally->hidden += seen == TRACED_HIDDEN;
            tally->between += seen == TRACED_BETWEEN;
            if (seen == TRACED_BETWEEN)
                continue;
            double way[3], error = 1e-5 * form;
            for (int i = 0; i < 3; i++)
                way[i] = light->position[i] - point.position[i];
            const double distance = sqrt(scene_dot(way, way));
            error += 4.0 * point.reach / (distance * distance * distance);
            const double expected = seen == TRACED_LIT ? form / M_PI * light->intensity[0] : 0.0;
            const double actual = picture[4 * (y * size[0] + x)];
            error *= light->intensity[0] / M_PI;
            if (!(fabs(actual - expected) <= error))
                fail_msg("pixel %d %d (%g %g %g): %g instead of %g +- %g", x, y, point.position[0],
                         point.position[1], point.position[2], actual, expected, error);
        }
}

static void make_cornell(struct scene *out)
{
    assert_int_equal(
        scene_make(scene_params(.name = "cornell", .size = {64, 64}, .log = &log_to_stderr), out),
        WEFT_OK);
    for (int i = 0; i < out->material_count; i++)
        for (int k = 0; k < 3; k++) {
            out->materials[i].reflectance[k] = 1.0f;
            out->materials[i].emission[k] = 0.0f;
        }
}

static void check_cornell(weft_context *context)
{
    static const struct {
        double position[3], normal[3];
        int faces;
    } cases[] = {
        {{278.0, 548.8, 279.5}, {0.0, -1.0, 0.0}, 1}, // the lamp
        {{10.0, 500.0, 10.0}, {0.0, -1.0, 0.0}, 1},
        {{100.0, 0.0, 400.0}, {0.0, 1.0, 0.0}, 1},    // the floor, between the blocks
        {{0.0, 100.0, 250.0}, {1.0, 0.0, 0.0}, 1},    // the wall beside a block
        {{200.0, 165.0, 200.0}, {0.0, 1.0, 0.0}, 1},  // the short block
        {{368.0, 330.0, 351.0}, {0.0, 1.0, 0.0}, 0},  // the tall block
        {{278.0, 200.0, 200.0}, {0.0, 0.0, 0.0}, 6},  // in the air
        {{278.0, 300.0, -700.0}, {0.0, 0.0, 0.0}, 1}, // outside
    };
    struct scene scene;
    struct scene_triangles triangles;
    make_cornell(&scene);
    assert_int_equal(scene_triangles_make(&scene, 0.0, &triangles), WEFT_OK);
    scene_drawing *drawing = NULL;
    assert_int_equal(
        scene_drawing_create(scene_drawing_params(.scene = &scene, .context = context,
                                                  .shadow_size = 256, .log = &log_to_stderr),
                             &drawing),
        WEFT_OK);
    int hidden = 0;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct scene_frame frame = {.camera = {.size = {64, 64}}, .light_count = 1};
        struct scene_point_light *light = &frame.light[0];
        light->shadowed = true;
        for (int k = 0; k < 3; k++) {
            light->position[k] = cases[i].position[k];
            light->normal[k] = cases[i].normal[k];
            light->intensity[k] = 1e5;
        }
        float *picture = draw_mean(context, drawing, 1, &frame);
        struct scene_shadow_info info;
        scene_drawing_get_shadow(drawing, &info);
        struct tally tally = {0};
        compare(&triangles, &frame, picture, 4.0 / 256.0, &tally);
        assert_int_equal(info.faces, cases[i].faces);
        assert_true(tally.lit > 1500 && tally.between + tally.edge < 1100);
        hidden += tally.hidden;
        free(picture);
    }
    assert_true(hidden > 8000);
    scene_drawing_destroy(&drawing);
    scene_triangles_clear(&triangles);
    scene_clear(&scene);
}

static void test_cornell(void **state)
{
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++)
        check_cornell(contexts[c]);
}

int main(void)
{
    if (WITHOUT_GL)
        return EXIT_SKIPPED;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cornell),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
