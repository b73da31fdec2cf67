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
#include "tests/tools/render/pictures.h"
#include "tests/tools/render/traced.h"

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

// ---- all around the light -----------------------------------------------------------------------

// A room whose walls hide something each, so that they are in the maps, and boxes all around its
// middle.
static void make_room(struct test_scene *made)
{
    const struct scene_material white = {.reflectance = {1.0f, 1.0f, 1.0f}};
    begin_scene(made);
    made->scene.camera = (struct weft_camera){.fovy_degrees = 80.0,
                                              .near_distance = 0.02,
                                              .far_distance = 10.0,
                                              .eye = {-0.9, -0.8, 0.95},
                                              .target = {0.4, 0.2, -0.5},
                                              .up = {0.0, 1.0, 0.0}};
    scene_build_object(&made->build, "room", scene_build_material(&made->build, &white));
    scene_build_box(&made->build, (double[]){-1.0, -1.0, -1.0}, (double[]){1.0, 1.0, 1.0});
    for (int axis = 0; axis < 3; axis++)
        for (int side = -1; side <= 1; side += 2) {
            double corner[3][3] = {{0.0}};
            for (int i = 0; i < 3; i++)
                corner[i][axis] = 1.5 * side;
            corner[1][(axis + 1) % 3] = corner[2][(axis + 2) % 3] = 0.1;
            scene_build_polygon(&made->build, 3, (const double(*)[3])corner, NULL, NULL);
        }
    // A speck that lights can be close to.
    static const double speck[3][3] = {
        {0.248, 0.198, 0.22}, {0.252, 0.198, 0.22}, {0.25, 0.202, 0.22}};
    scene_build_polygon(&made->build, 3, speck, NULL, NULL);
    for (int i = 0; i < 27; i++) {
        const int at[3] = {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
        double low[3], high[3];
        if (i == 13)
            continue;
        scene_build_object(&made->build, "box", 0);
        for (int k = 0; k < 3; k++) {
            low[k] = 0.45 * at[k] - 0.05 - 0.01 * (i % 4);
            high[k] = 0.45 * at[k] + 0.06;
        }
        scene_build_box(&made->build, low, high);
    }
}

static void check_room(weft_context *context)
{
    static const struct {
        double position[3], normal[3];
        int faces;
    } cases[] = {
        {{0.05, -0.03, 0.02}, {0.0, 0.0, 0.0}, 6}, // the middle
        {{0.1, -1.0, 0.2}, {0.0, 1.0, 0.0}, 5},    // the floor
        {{-1.0, 0.9, -0.95}, {1.0, 0.0, 0.0}, 5},  // a wall, close to a corner of the room
        {{-0.3, -0.3, 0.2}, {0.6, 0.0, -0.8}, 5},  // askew
        {{0.99, 0.2, 0.3}, {0.0, 0.0, 0.0}, 6},    // beside a wall: all but in its plane
        {{0.25, 0.2, 0.222}, {0.0, 0.0, 0.0}, 6},  // before what the near plane does not reach
    };
    struct test_scene made;
    struct scene_triangles triangles;
    make_room(&made);
    scene_drawing *drawing = begin_drawing(context, &made, 256);
    assert_int_equal(scene_triangles_make(&made.scene, 0.0, &triangles), WEFT_OK);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct scene_frame frame = {.camera = {.size = {64, 48}}, .light_count = 1};
        struct scene_point_light *light = &frame.light[0];
        light->shadowed = true;
        for (int k = 0; k < 3; k++) {
            light->position[k] = cases[i].position[k];
            light->normal[k] = cases[i].normal[k];
            light->intensity[k] = 1.0;
        }
        float *picture = draw_mean(context, drawing, 1, &frame);
        struct scene_shadow_info info;
        scene_drawing_get_shadow(drawing, &info);
        struct tally tally = {0};
        compare(&triangles, &frame, picture, 2.0 / 256.0, &tally);
        assert_int_equal(info.faces, cases[i].faces);
        assert_true(tally.lit + tally.hidden > 2000);
        assert_true(tally.lit > 300 && tally.hidden > 300);
        free(picture);
    }
    scene_triangles_clear(&triangles);
    scene_drawing_destroy(&drawing);
    end_scene(&made);
}

static void test_room(void **state)
{
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++)
        check_room(contexts[c]);
}

// ---- grazing light and smooth surfaces ----------------------------------------------------------

// A lit plane that is in the map has no acne: light that comes from 1 to 89.9 degrees aside.
static void check_grazing(weft_context *context)
{
    static const double degrees[] = {1.0, 30.0, 60.0, 80.0, 87.0, 89.0, 89.9};
    static const double plane[4][3] = {
        {-3.0, -2.0, -6.0}, {3.0, -2.1, -6.2}, {3.1, 2.0, -5.9}, {-2.9, 2.1, -5.7}};
    static const double below[3][3] = {{0.0, 0.0, -7.0}, {0.1, 0.0, -7.0}, {0.0, 0.1, -7.0}};
    for (size_t i = 0; i < sizeof degrees / sizeof *degrees; i++) {
        struct test_scene made;
        begin_scene(&made);
        add_polygon(&made, 4, plane, (struct scene_material){.reflectance = {1.0f, 1.0f, 1.0f}});
        add_polygon(&made, 3, below, (struct scene_material){.reflectance = {1.0f, 1.0f, 1.0f}});
        struct scene_frame frame = {.camera = {.size = {96, 64}}, .light_count = 1};
        const double angle = degrees[i] * M_PI / 180.0;
        // Above the plane's middle, turned about it in a direction that is no axis.
        double way[3] = {sin(angle) * 0.8, sin(angle) * 0.6, cos(angle)};
        double normal[3] = {0.0};
        for (int k = 0; k < 3; k++)
            normal[k] = made.scene.vertices[0].normal[k];
        double right[3], up[3], other[3] = {1.0, 0.0, 0.0};
        scene_cross(normal, other, up);
        scene_normalise(up);
        scene_cross(up, normal, right);
        frame.light[0] = (struct scene_point_light){
            .intensity = {1.0, 1.0, 1.0}, .falloff = SCENE_FALLOFF_NONE, .shadowed = true};
        for (int k = 0; k < 3; k++)
            frame.light[0].position[k] =
                (double[]){0.0, 0.0, -5.95}[k] +
                8.0 * (way[0] * right[k] + way[1] * up[k] + way[2] * normal[k]);
        float *picture = draw_picture(context, &made, &frame, 128);
        int lit = 0;
        for (int k = 0; k < 96 * 64; k++) {
            assert_near(picture[4 * k], picture[4 * k + 3], 1e-6, "lit");
            lit += picture[4 * k] > 0.0f;
        }
        assert_true(lit > 3000);
        free(picture);
        end_scene(&made);
    }
}

static void test_grazing(void **state)
{
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++)
        check_grazing(contexts[c]);
}

// A ball from outside, and the inside of another one, in maps whose texels are about as large as
// their triangles: what rays see of a light all around is lit, what they do not see is not.
static void check_smooth(weft_context *context)
{
    for (int inside = 0; inside < 2; inside++) {
        struct test_scene made;
        struct scene_triangles triangles;
        begin_scene(&made);
        const struct scene_material white = {.reflectance = {1.0f, 1.0f, 1.0f}};
        scene_build_object(&made.build, "ball", scene_build_material(&made.build, &white));
        scene_build_ball(&made.build, (double[]){0.0, 0.0, inside ? -1.5 : -4.0},
                         inside ? 3.0 : 1.0, 12);
        scene_drawing *drawing = begin_drawing(context, &made, 32);
        assert_int_equal(scene_triangles_make(&made.scene, 0.0, &triangles), WEFT_OK);
        struct scene_frame frame = {.camera = {.size = {64, 48}}, .light_count = 1};
        frame.light[0] = (struct scene_point_light){
            .position = {1.0, 1.5, -0.5}, .intensity = {1.0, 1.0, 1.0}, .shadowed = true};
        float *picture = draw_mean(context, drawing, 1, &frame);
        struct tally tally = {0};
        // Inside nothing is hidden, wherever texels end.
        compare(&triangles, &frame, picture, inside ? 0.0 : 2.0 / 32.0, &tally);
        assert_true(inside ? tally.lit > 2500 : tally.lit > 200 && tally.hidden > 40);
        free(picture);
        scene_triangles_clear(&triangles);
        scene_drawing_destroy(&drawing);
        end_scene(&made);
    }
}

static void test_smooth(void **state)
{
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++)
        check_smooth(contexts[c]);
}

// ---- what casts ---------------------------------------------------------------------------------

// A one-sided sheet casts a shadow of the side that is there only.
static void test_one_sided(void **state)
{
    (void)state;
    static const double ground[4][3] = {
        {-4.0, -3.0, -6.0}, {4.0, -3.0, -6.0}, {4.0, 3.0, -6.0}, {-4.0, 3.0, -6.0}};
    for (int turned = 0; turned < 2; turned++) {
        struct test_scene made;
        double sheet[3][3] = {{-1.0, -1.0, -5.0}, {1.0, -1.0, -5.0}, {0.0, 1.0, -5.0}};
        if (turned)
            for (int k = 0; k < 3; k++) {
                const double x = sheet[0][k];
                sheet[0][k] = sheet[1][k];
                sheet[1][k] = x;
            }
        begin_scene(&made);
        const struct scene_material white = {.reflectance = {1.0f, 1.0f, 1.0f},
                                             .single_sided = true};
        add_polygon(&made, 4, ground, white);
        add_polygon(&made, 3, (const double(*)[3])sheet, white);
        struct scene_frame frame = {.camera = {.size = {64, 48}}, .light_count = 1};
        frame.light[0] = (struct scene_point_light){.position = {3.0, 0.0, -3.0},
                                                    .intensity = {1.0, 1.0, 1.0},
                                                    .falloff = SCENE_FALLOFF_NONE,
                                                    .shadowed = true};
        float *picture = draw_picture(contexts[0], &made, &frame, 128);
        int dark = 0;
        for (int k = 0; k < 64 * 48; k++)
            dark += picture[4 * k] == 0.0f && picture[4 * k + 3] == 1.0f;
        assert_true(turned ? dark == 0 : dark > 50);
        free(picture);
        end_scene(&made);
    }
}

// Eight lights with maps of different kinds in one frame are the sum of eight frames.
static void test_several(void **state)
{
    (void)state;
    struct test_scene made;
    make_room(&made);
    scene_drawing *drawing = begin_drawing(contexts[0], &made, 128);
    struct scene_frame all = {.camera = {.size = {64, 48}}, .light_count = SCENE_MAX_LIGHTS};
    double sum[64 * 48] = {0.0};
    for (int i = 0; i < SCENE_MAX_LIGHTS; i++) {
        struct scene_frame one = {.camera = {.size = {64, 48}}, .light_count = 1};
        struct scene_point_light *light = &one.light[0];
        *light = (struct scene_point_light){.position = {0.2 * i - 0.7, 0.1 * i - 0.3, 0.3},
                                            .normal = {0.0, i % 2 ? 1.0 : 0.0, 0.0},
                                            .intensity = {1.0 + i, 1.0, 1.0},
                                            .shadowed = i != 3,
                                            .most = i == 5 ? 1.0 : 0.0};
        if (i == 6)
            light->position[1] = 4.0; // outside
        all.light[i] = *light;
        float *picture = draw_mean(contexts[0], drawing, 1, &one);
        for (int k = 0; k < 64 * 48; k++)
            sum[k] += picture[4 * k];
        free(picture);
    }
    float *picture = draw_mean(contexts[0], drawing, 1, &all);
    for (int k = 0; k < 64 * 48; k++)
        assert_near(picture[4 * k], sum[k], 2e-6 * sum[k], "sum");
    free(picture);
    scene_drawing_destroy(&drawing);
    end_scene(&made);
}

// The picture does not depend on the unit of length: the same bits for 2^40 and 2^-40 of it.
static float *draw_scaled(double unit)
{
    struct test_scene made;
    make_room(&made);
    for (size_t i = 0; i < made.scene.vertex_count; i++)
        for (int k = 0; k < 3; k++)
            made.scene.vertices[i].position[k] *= (float)unit;
    struct weft_camera *camera = &made.scene.camera;
    camera->near_distance *= unit;
    camera->far_distance *= unit;
    for (int k = 0; k < 3; k++) {
        camera->eye[k] *= unit;
        camera->target[k] *= unit;
    }
    struct scene_frame frame = {.camera = {.size = {64, 48}}, .light_count = 1};
    frame.light[0] = (struct scene_point_light){.position = {0.1 * unit, -1.0 * unit, 0.2 * unit},
                                                .normal = {0.0, 1.0, 0.0},
                                                .most = 2.0 / (unit * unit),
                                                .shadowed = true};
    for (int k = 0; k < 3; k++)
        frame.light[0].intensity[k] = unit * unit;
    float *picture = draw_picture(contexts[0], &made, &frame, 128);
    end_scene(&made);
    return picture;
}

static void test_scaled(void **state)
{
    (void)state;
    float *plain = draw_scaled(1.0);
    for (int i = -40; i <= 40; i += 80) {
        float *scaled = draw_scaled(ldexp(1.0, i));
        assert_memory_equal(scaled, plain, 64 * 48 * 4 * sizeof *plain);
        free(scaled);
    }
    free(plain);
}

// ---- soft shadows -------------------------------------------------------------------------------

// A lamp of width 1 at the height 4 over a ground, a half-plane at the height 1 that ends along
// the direction `angle` + 90 degrees: what of the lamp is seen from the ground.
enum { SAMPLES = 64, MAP = 1024, W = 160, H = 120 };
static const double LAMP = 4.0, EDGE = 1.0, GROUND = -6.0;

static void make_penumbra(struct test_scene *made, double angle, double middle[2])
{
    static const double ground[4][3] = {
        {-6.0, -5.0, GROUND}, {6.0, -5.0, GROUND}, {6.0, 5.0, GROUND}, {-6.0, 5.0, GROUND}};
    const double n[2] = {cos(angle), sin(angle)};
    const struct scene_material white = {.reflectance = {1.0f, 1.0f, 1.0f}};
    double corner[4][3];
    begin_scene(made);
    add_polygon(made, 4, ground, white);
    for (int i = 0; i < 4; i++) {
        const double along = i == 1 || i == 2 ? 1.5 : -1.5, across = i < 2 ? 0.0 : -2.0;
        corner[i][0] = across * n[0] - along * n[1];
        corner[i][1] = across * n[1] + along * n[0];
        corner[i][2] = GROUND + EDGE;
    }
    add_polygon(made, 4, (const double(*)[3])corner, white);
    for (int i = 0; i < 2; i++)
        middle[i] = -1.5 * n[i];
}

static void set_lamp(struct scene_frame *frame, const double middle[2], const double place[2],
                     enum scene_falloff falloff)
{
    *frame = (struct scene_frame){.camera = {.size = {W, H}}, .light_count = 1};
    frame->light[0] = (struct scene_point_light){
        .position = {middle[0] + place[0], middle[1] + place[1], GROUND + LAMP},
        .normal = {0.0, 0.0, -1.0},
        .intensity = {1.0, 1.0, 1.0},
        .falloff = falloff,
        .shadowed = true,
    };
}

// The ground's point in a pixel. false: the half-plane hides it from the viewer, or its other
// edges can hide the lamp.
static bool find_ground(int x, int y, double angle, double out[2])
{
    const double t = -GROUND * tan(M_PI / 8.0), n[2] = {cos(angle), sin(angle)};
    out[0] = (2.0 * (x + 0.5) / W - 1.0) * t * W / H;
    out[1] = (2.0 * (y + 0.5) / H - 1.0) * t;
    const double along = out[1] * n[0] - out[0] * n[1], across = out[0] * n[0] + out[1] * n[1];
    return fabs(along) < 1.0 && across > 0.05 && across < 1.5;
}

// Width of a texel on the lamp, as seen past the edge: the map's face is fitted to the half-plane
// of 2 x 3 (5 x 5 at most, askew, with a margin), and lies askew itself by up to 40 degrees.
static double find_texel(void)
{
    const double window = 5.0 / MAP / (LAMP - EDGE);                     // at distance 1
    return window * LAMP / (cos(0.7) * cos(0.7)) * (LAMP - EDGE) / EDGE; // on the ground, the lamp
}

static void check_share(weft_context *context, enum weft_jitter_shape shape, double angle)
{
    struct test_scene made;
    struct weft_jitter set;
    struct weft_discrepancy worst;
    struct scene_frame frame[SAMPLES];
    double middle[2];
    assert_int_equal(weft_jitter_create(weft_jitter_params(.info = weft_jitter_find("sobol"),
                                                           .count = SAMPLES, .shape = shape,
                                                           .centre = true, .log = &log_to_stderr),
                                        &set),
                     WEFT_OK);
    assert_int_equal(
        weft_discrepancy_compute(weft_discrepancy_params(.points = (const double(*)[2])set.points,
                                                         .count = SAMPLES, .shape = shape,
                                                         .log = &log_to_stderr),
                                 &worst),
        WEFT_OK);
    make_penumbra(&made, angle, middle);
    for (int i = 0; i < SAMPLES; i++)
        set_lamp(&frame[i], middle, set.points[i], SCENE_FALLOFF_NONE);
    scene_drawing *drawing = begin_drawing(context, &made, MAP);
    float *picture = draw_mean(context, drawing, SAMPLES, frame);
    // The share changes by 1 / width of the lamp along the normal at most, by 4 / pi of a disc.
    const double steepest = shape == WEFT_JITTER_DISC ? 4.0 / M_PI : M_SQRT2;
    const double tolerance = worst.value + steepest * M_SQRT1_2 * find_texel();
    const double n[2] = {cos(angle), sin(angle)};
    int between = 0, lit = 0, dark = 0;
    double most = 0.0;
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++) {
            double p[2];
            if (!find_ground(x, y, angle, p))
                continue;
            const double across = p[0] * n[0] + p[1] * n[1];
            const double d = -across * (LAMP - EDGE) / EDGE + 1.5;
            const double share =
                1.0 - (shape == WEFT_JITTER_DISC ? weft_edge_disc(d) : weft_edge_square(n, d));
            most = larger(most, fabs(picture[4 * (y * W + x)] - share));
            *(share == 0.0 ? &dark : share == 1.0 ? &lit : &between) += 1;
        }
    if (!(most <= tolerance))
        fail_msg("angle %g: off by %g, more than %g", angle, most, tolerance);
    assert_true(between > 200 && lit > 500 && dark > 100);
    free(picture);
    scene_drawing_destroy(&drawing);
    weft_jitter_clear(&set);
    end_scene(&made);
}

static void test_share(void **state)
{
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++)
        for (int i = 0; i < 3; i++) {
            const double angle = (double[]){0.0, M_PI_4, 1.1}[i];
            check_share(contexts[c], WEFT_JITTER_SQUARE, angle);
            check_share(contexts[c], WEFT_JITTER_DISC, angle);
        }
}

// Irradiance of a point on the ground by a rectangle of radiance 1 over it: Lambert's formula,
// 1/2 sum of the edges' angles times their normals' cosines.
static double find_irradiance(const double p[2], const double low[2], const double high[2])
{
    double sum = 0.0;
    for (int i = 0; i < 4; i++) {
        double a[3], b[3], normal[3];
        for (int k = 0; k < 2; k++) {
            const int turn[2] = {i, (i + 1) % 4};
            double *const corner = k ? b : a;
            corner[0] = (turn[k] == 1 || turn[k] == 2 ? high[0] : low[0]) - p[0];
            corner[1] = (turn[k] >= 2 ? high[1] : low[1]) - p[1];
            corner[2] = LAMP;
            scene_normalise(corner);
        }
        scene_cross(a, b, normal);
        scene_normalise(normal);
        sum += acos(scene_dot(a, b)) * normal[2];
    }
    return 0.5 * sum;
}

// A square lamp behind an edge that is parallel to a side: what is seen of it is a rectangle. The
// 16 x 16 samples lie in the middles of squares; of a whole lamp they are off by (1 / 16)^2 / 24
// times both second derivatives, up to 28 / r^2 of the value each: by 6e-4. The edge is off by
// half a column and what a texel makes of it.
static void check_irradiance(weft_context *context)
{
    enum { SIDE = 16 };
    struct test_scene made;
    double middle[2];
    make_penumbra(&made, 0.0, middle);
    struct scene_frame *frame = calloc(SIDE * SIDE, sizeof *frame);
    assert_non_null(frame);
    for (int i = 0; i < SIDE * SIDE; i++)
        set_lamp(&frame[i], middle,
                 (double[]){(i % SIDE + 0.5) / SIDE - 0.5, (i / SIDE + 0.5) / SIDE - 0.5},
                 SCENE_FALLOFF_RADIANCE);
    scene_drawing *drawing = begin_drawing(context, &made, MAP);
    float *picture = draw_mean(context, drawing, SIDE * SIDE, frame);
    int part = 0, whole = 0;
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++) {
            double p[2];
            if (!find_ground(x, y, 0.0, p))
                continue;
            double low[2] = {middle[0] - 0.5, middle[1] - 0.5};
            const double high[2] = {middle[0] + 0.5, middle[1] + 0.5};
            const double all = find_irradiance(p, low, high);
            low[0] = fmin(fmax(low[0], -p[0] * (LAMP - EDGE) / EDGE), high[0]);
            const double seen = low[0] < high[0] ? find_irradiance(p, low, high) : 0.0;
            const bool is_part = low[0] != middle[0] - 0.5;
            const double edge = is_part ? 0.5 / SIDE + find_texel() / 2.0 : 0.0;
            assert_near(picture[4 * (y * W + x)] * M_PI, seen, 6e-4 * all + 1.1 * edge * all,
                        "irradiance");
            *(is_part ? &part : &whole) += 1;
        }
    assert_true(part > 500 && whole > 500);
    free(picture);
    free(frame);
    scene_drawing_destroy(&drawing);
    end_scene(&made);
}

static void test_irradiance(void **state)
{
    (void)state;
    check_irradiance(contexts[0]); // both were compared where shares are
}

int main(void)
{
    if (WITHOUT_GL)
        return EXIT_SKIPPED;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cornell),    cmocka_unit_test(test_room),
        cmocka_unit_test(test_grazing),    cmocka_unit_test(test_smooth),
        cmocka_unit_test(test_one_sided),  cmocka_unit_test(test_several),
        cmocka_unit_test(test_scaled),     cmocka_unit_test(test_share),
        cmocka_unit_test(test_irradiance),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
