// SPDX-License-Identifier: BSD-3-Clause
// What a picture needs: motion, depths and penumbrae of set-ups whose figures are known by hand.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "tests/support/common.h"
#include "tools/scene/build.h"

// 200 x 100 pixels, and so that a length of 1 at a depth of 1 has 50 of them.
static const int size[2] = {200, 100};
static const double PIXELS = 50.0;

static void begin(struct scene *scene, struct scene_build *build)
{
    *scene = (struct scene){.camera = {.fovy_degrees = 90.0,
                                       .near_distance = 1.0,
                                       .far_distance = 100.0,
                                       .target = {0.0, 0.0, -1.0},
                                       .up = {0.0, 1.0, 0.0}}};
    *build = (struct scene_build){.scene = scene};
    scene_build_material(build, &(struct scene_material){.reflectance = {0.5f, 0.5f, 0.5f}});
}

// A triangle parallel to the picture, `half` around a place.
static void add_triangle(struct scene_build *build, double x, double y, double depth, double half)
{
    const double corner[3][3] = {
        {x - half, y - half, -depth}, {x + half, y - half, -depth}, {x, y + half, -depth}};
    scene_build_object(build, "triangle", 0);
    scene_build_polygon(build, 3, corner, NULL, NULL);
}

// Gives the last object a straight way.
static void add_way(struct scene_build *build, double x, double y, double z)
{
    struct scene_key *keys = scene_build_path(build, 2);
    assert_non_null(keys);
    keys[1].position[0] = x;
    keys[1].position[1] = y;
    keys[1].position[2] = z;
}

static void end(struct scene_build *build)
{
    assert_int_equal(scene_build_end(build, &log_to_stderr), WEFT_OK);
}

// ---- motion -------------------------------------------------------------------------------------

static void test_motion_across_at_a_depth(void **state)
{
    (void)state;
    struct scene s;
    struct scene_build build;
    begin(&s, &build);
    add_triangle(&build, -0.5, 0.0, 4.0, 0.25);
    add_way(&build, 0.8, -0.6, 0.0);
    end(&build);
    const double whole = 1.0 * PIXELS / 4.0; // a length of 1
    assert_near(scene_longest_motion(&s, size, 0.0, 1.0), whole, 1e-9, "all of it");
    assert_near(scene_longest_motion(&s, size, 0.25, 0.75), 0.5 * whole, 1e-9, "a half");
    assert_near(scene_longest_motion(&s, size, 0.0, 0.0), 0.0, 0.0, "no time");
    assert_near(scene_longest_motion(&s, size, 1.0, 0.0), 0.0, 0.0, "less than none");
    assert_near(scene_longest_motion(&s, size, 1.0, 2.0), 0.0, 0.0, "after the last key");
    // In half of the time it moves: copies are as far apart as if it went on.
    assert_near(scene_longest_motion(&s, size, 0.5, 1.5), whole, 1e-9, "half of it at rest");
    scene_clear(&s);
}

// The fastest counts: nearer things, and parts of the time.
static void test_the_fastest_counts(void **state)
{
    (void)state;
    struct scene s;
    struct scene_build build;
    begin(&s, &build);
    add_triangle(&build, 0.0, 0.0, 8.0, 0.25);
    add_way(&build, 1.0, 0.0, 0.0);
    add_triangle(&build, 0.0, 0.0, 2.0, 0.25);
    struct scene_key *keys = scene_build_path(&build, 3);
    assert_non_null(keys);
    keys[1].time = 0.75;
    keys[1].position[0] = keys[2].position[0] = 0.75;
    keys[2].position[1] = 0.5;
    end(&build);
    // 0.75 in 0.75 is slower than 0.5 in 0.25.
    assert_near(scene_longest_motion(&s, size, 0.0, 1.0), 2.0 * PIXELS / 2.0, 1e-9, "the fastest");
    assert_near(scene_longest_motion(&s, size, 0.0, 0.75), 0.75 * PIXELS / 2.0, 1e-9, "before");
    scene_clear(&s);
}

// A key within one of the 64 parts: the way there and back counts, not the distance between ends.
static void test_keys_within_a_part_count(void **state)
{
    (void)state;
    struct scene s;
    struct scene_build build;
    begin(&s, &build);
    add_triangle(&build, 0.0, 0.0, 2.0, 0.25);
    struct scene_key *keys = scene_build_path(&build, 3);
    assert_non_null(keys);
    keys[1].time = 1.0 / 128.0;
    keys[2].time = 1.0 / 64.0;
    keys[1].position[0] = 0.1;
    end(&build);
    assert_near(scene_longest_motion(&s, size, 0.0, 1.0), 64.0 * 0.2 * PIXELS / 2.0, 1e-9, "both");
    scene_clear(&s);
}

// A turn of 60 degrees about the middle of the picture: the arc of the farthest corner, of which
// each of 64 chords is shorter by (60 degrees / 64)^2 / 24.
static void test_motion_of_a_turn(void **state)
{
    (void)state;
    struct scene s;
    struct scene_build build;
    begin(&s, &build);
    add_triangle(&build, 0.0, 0.0, 5.0, 1.0);
    struct scene_key *keys = scene_build_path(&build, 2);
    assert_non_null(keys);
    scene_rotation((double[]){0.0, 0.0, 1.0}, 60.0, keys[1].rotation);
    end(&build);
    const double arc = sqrt(2.0) * (M_PI / 3.0) * PIXELS / 5.0, part = M_PI / 3.0 / 64.0;
    assert_near(scene_longest_motion(&s, size, 0.0, 1.0), arc * (1.0 - part * part / 24.0),
                1e-8 * arc, "the arc");
    scene_clear(&s);
}

// What is out of sight does not count, but what is at most 1/8 of the picture beside it does.
static void test_only_what_is_in_sight_moves(void **state)
{
    (void)state;
    static const struct {
        double x, y, depth;
        bool counts;
    } cases[] = {
        {0.0, 0.0, 4.0, true},    {0.0, 0.0, -4.0, false}, // behind the eye
        {0.0, 0.0, 0.5, false},                            // before the near plane
        {0.0, 0.0, 200.0, false},                          // beyond the far plane
        {9.0, 0.0, 4.0, true},                             // edge at 8
        {10.3, 0.0, 4.0, false},  {-10.3, 0.0, 4.0, false}, {0.0, 4.8, 4.0, true},
        {0.0, 5.3, 4.0, false},   {0.0, -5.3, 4.0, false},
    };
    int seen = 0;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct scene s;
        struct scene_build build;
        begin(&s, &build);
        add_triangle(&build, cases[i].x, cases[i].y, cases[i].depth, 0.125);
        add_way(&build, 0.0, 0.1, 0.0);
        end(&build);
        const double expected = cases[i].counts ? 0.1 * PIXELS / cases[i].depth : 0.0;
        assert_near(scene_longest_motion(&s, size, 0.0, 1.0), expected, 1e-9, "a motion");
        seen += cases[i].counts;
        scene_clear(&s);
    }
    assert_int_equal(seen, 3);
}

// A moving camera moves all that rests, also a plane whose corners are all out of sight: the ground
// is fastest where it leaves the margin below the picture, at the depth height / tan.
static void test_moving_camera(void **state)
{
    (void)state;
    struct scene s;
    struct scene_build build;
    begin(&s, &build);
    const double ground[4][3] = {
        {-900.0, -2.0, 900.0}, {900.0, -2.0, 900.0}, {900.0, -2.0, -900.0}, {-900.0, -2.0, -900.0}};
    scene_build_object(&build, "ground", 0);
    scene_build_polygon(&build, 4, ground, NULL, NULL);
    end(&build);
    struct scene_key keys[2] = {{0.0, {0.0, 0.0, 0.0}, {0, 0, 0, 1}, 1.0},
                                {1.0, {0.5, 0.0, 0.0}, {0, 0, 0, 1}, 1.0}};
    s.camera_path = (struct scene_path){keys, 2};
    const double nearest = 2.0 / 1.25;
    assert_near(scene_longest_motion(&s, size, 0.0, 1.0), 0.5 * PIXELS / nearest, 1e-6, "ground");
    // The same by a thing that is carried along, beside: it rests on the screen.
    s.objects[0].path = s.camera_path;
    assert_near(scene_longest_motion(&s, size, 0.0, 1.0), 0.0, 1e-6, "carried along");
    s.objects[0].path = s.camera_path = (struct scene_path){0};
    scene_clear(&s);
}

// ---- depths -------------------------------------------------------------------------------------

static void test_depths(void **state)
{
    (void)state;
    struct scene s;
    struct scene_build build;
    double nearest, farthest;
    begin(&s, &build);
    add_triangle(&build, 0.0, 0.0, 5.0, 0.5);
    add_way(&build, 0.0, 0.0, 2.0);
    add_triangle(&build, 0.5, 0.0, 7.0, 0.5);
    add_triangle(&build, 30.0, 0.0, 3.0, 0.5); // beside the picture
    add_triangle(&build, 0.0, 0.0, -3.0, 0.5); // behind
    end(&build);
    scene_depths(&s, size, 0.0, &nearest, &farthest);
    assert_near(nearest, 5.0, 1e-6, "the nearest");
    assert_near(farthest, 7.0, 1e-6, "the farthest");
    scene_depths(&s, size, 0.75, &nearest, &farthest);
    assert_near(nearest, 3.5, 1e-6, "the nearest, closer");
    scene_clear(&s);

    // A ground: from the picture's lower edge to the far plane.
    begin(&s, &build);
    const double ground[4][3] = {
        {-900.0, -2.0, 900.0}, {900.0, -2.0, 900.0}, {900.0, -2.0, -900.0}, {-900.0, -2.0, -900.0}};
    scene_build_object(&build, "ground", 0);
    scene_build_polygon(&build, 4, ground, NULL, NULL);
    end(&build);
    scene_depths(&s, size, 0.0, &nearest, &farthest);
    assert_near(nearest, 2.0, 1e-9, "the lower edge");
    assert_near(farthest, 100.0, 1e-9, "the far plane");
    scene_clear(&s);

    begin(&s, &build);
    add_triangle(&build, 0.0, 0.0, -3.0, 0.5);
    end(&build);
    scene_depths(&s, size, 0.0, &nearest, &farthest);
    assert_true(isnan(nearest) && isnan(farthest));
    scene_clear(&s);
}

// ---- penumbrae ----------------------------------------------------------------------------------

// A wall at a depth of 10, a board parallel to it, a lamp beside the camera.
static double find_penumbra(double side, double board, double lamp, enum scene_light_shape shape,
                            bool turned_away)
{
    struct scene s;
    struct scene_build build;
    begin(&s, &build);
    add_triangle(&build, 0.0, 0.0, 10.0, 40.0);
    if (board > 0.0)
        add_triangle(&build, 0.0, 0.0, 10.0 - board, 1.5);
    // It shines along -z.
    scene_build_lamp(&build, &(struct scene_light){.shape = shape,
                                                   .falloff = SCENE_FALLOFF_NONE,
                                                   .middle = {0.0, 0.0, lamp - 10.0},
                                                   .u = {0.0, side, 0.0},
                                                   .v = {turned_away ? -side : side, 0.0, 0.0},
                                                   .radiance = {1.0, 1.0, 1.0}});
    end(&build);
    const double out = scene_widest_penumbra(&s, size, 0.0);
    scene_clear(&s);
    return out;
}

static void test_penumbra_of_a_board(void **state)
{
    (void)state;
    static const struct {
        double side, board, lamp;
    } cases[] = {{1.0, 2.0, 8.0}, {0.5, 2.0, 8.0}, {1.0, 3.0, 8.0}, {1.0, 4.0, 8.0}};
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const double side = cases[i].side, ho = cases[i].board, hl = cases[i].lamp;
        const double expected = side * ho / (hl - ho) * PIXELS / 10.0;
        const double square = find_penumbra(side, ho, hl, SCENE_LIGHT_SQUARE, false);
        assert_near(square, expected, 1e-6 * expected, "of a square");
        const double disc = find_penumbra(side, ho, hl, SCENE_LIGHT_DISC, false);
        assert_near(disc, expected, 1e-6 * expected, "of a disc");
    }
    assert_near(find_penumbra(1.0, 2.0, 8.0, SCENE_LIGHT_POINT, false), 0.0, 0.0, "of a point");
    assert_near(find_penumbra(1.0, 2.0, 8.0, SCENE_LIGHT_SQUARE, true), 0.0, 0.0, "turned away");
    assert_near(find_penumbra(1.0, 0.0, 8.0, SCENE_LIGHT_SQUARE, false), 0.0, 0.0, "no board");
}

// That of the built-in scene, whose board is at 1 and whose lamp of 1 at 4: 1/3 wide on the floor,
// seen from depths between those of the camera's nearest and farthest shadow.
static void test_penumbra_of_the_scene(void **state)
{
    (void)state;
    struct scene s;
    const int square[2] = {512, 512};
    assert_int_equal(
        scene_make(scene_params(.name = "penumbra", .size = {512, 512}, .log = &log_to_stderr), &s),
        WEFT_OK);
    const double scale = 512.0 / (2.0 * tan(M_PI / 9.0));
    const double widest = scene_widest_penumbra(&s, square, 0.5);
    // The post, 1.6 high, makes the widest one: 1.6 / 2.4 wide, some 7 to 9 away.
    assert_true(widest > 1.0 / 3.0 * scale / 9.0);
    assert_true(widest < 1.6 / 2.4 * scale / 6.0);
    scene_clear(&s);
}

// A path may bring a camera where it sees nothing: nothing is in sight then.
static void test_cameras_that_see_nothing(void **state)
{
    (void)state;
    struct scene s;
    struct scene_build build;
    double nearest, farthest;
    begin(&s, &build);
    add_triangle(&build, 0.0, 0.0, 4.0, 0.25);
    add_way(&build, 1.0, 0.0, 0.0);
    end(&build);
    s.camera.near_distance = 0.0;
    assert_near(scene_longest_motion(&s, size, 0.0, 1.0), 0.0, 0.0, "motion");
    assert_near(scene_widest_penumbra(&s, size, 0.0), 0.0, 0.0, "penumbra");
    scene_depths(&s, size, 0.0, &nearest, &farthest);
    assert_true(isnan(nearest) && isnan(farthest));
    scene_clear(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_motion_across_at_a_depth),
        cmocka_unit_test(test_the_fastest_counts),
        cmocka_unit_test(test_keys_within_a_part_count),
        cmocka_unit_test(test_motion_of_a_turn),
        cmocka_unit_test(test_only_what_is_in_sight_moves),
        cmocka_unit_test(test_moving_camera),
        cmocka_unit_test(test_depths),
        cmocka_unit_test(test_penumbra_of_a_board),
        cmocka_unit_test(test_penumbra_of_the_scene),
        cmocka_unit_test(test_cameras_that_see_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
