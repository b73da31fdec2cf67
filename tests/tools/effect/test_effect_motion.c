// SPDX-License-Identifier: BSD-3-Clause
// A moving edge is the ramp of its shutter; what turns is what its frames' places say; motion blur
// with anti-aliasing is the ramp seen through a pixel.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "tests/tools/effect/pictures.h"

static const int size[2] = {64, 4};

// White left of an edge at x = from, pixels from the picture's middle, which moves right by `way`.
static void make_moving_edge(struct scene *scene, double from, double way)
{
    const double middle[2] = {from - 200.0, 0.0}, half[2] = {200.0, 100.0};
    struct scene_build build = empty_scene(scene, size);
    add_rectangle(&build, add_colour(&build, 1.0f, 1.0f, 1.0f), size[1] / 2.0, middle, half, 0.0);
    move_last(&build, way, 0.0);
    end_scene(&build);
}

// How far a ramp of `count` frames may be from the shutter's: half the largest weight, 1 / (2 N) of
// a box, and what the middles of parts miss of the light of others (shutter.h).
static double find_step(const struct effect_plan *plan, const struct weft_shutter *shutter)
{
    const double n = (double)plan->count;
    double missed = 0.0, all = 1.0;
    if (shutter->shape == WEFT_SHUTTER_GAUSS) {
        all = 0.0;
        for (int k = 0; k < 10000; k++)
            all += weft_shutter_light(shutter, (k + 0.5) / 10000) / 10000;
        missed = 1.0 / (24.0 * shutter->sigma * shutter->sigma * n * n);
    } else {
        all = (1.0 + shutter->close - shutter->open) / 2.0;
        if (shutter->open > 0.0)
            missed += 1.0 / (8.0 * n * n * shutter->open);
        if (shutter->close < 1.0)
            missed += 1.0 / (8.0 * n * n * (1.0 - shutter->close));
    }
    return plan->weights.largest / 2.0 + 2.0 / all * missed;
}

// Edges lie where they were rounded to, at most `snap` away: the ramp is met between there and
// there, and one step besides.
static void check_ramp(weft_context *context, const char *name, int count, double way,
                       const double time[2])
{
    struct scene scene;
    struct weft_shutter shutter;
    const double from = -20.3;
    make_moving_edge(&scene, from, way);
    assert_int_equal(weft_shutter_parse(&log_to_stderr, name, &shutter), WEFT_OK);
    struct effect_plan plan =
        plan_made(effect_params(.effects = EFFECT_MOTION_BLUR, .scene = {&scene}, .scene_count = 1,
                                .size = {size[0], size[1]}, .frames = count, .shutter = shutter,
                                .time = {time[0], time[1]}));
    struct picture picture = draw_plan(context, &plan, &scene);
    const double step = find_step(&plan, &shutter);
    const double begin = from + way * time[0], length = way * (time[1] - time[0]);
    int between = 0;
    for (int x = 0; x < size[0]; x++) {
        // The edge has passed the pixel's centre from that time on: it is white since then.
        const double u = (x + 0.5 - 0.5 * size[0] - begin) / length;
        const double early = 1.0 - weft_shutter_share(&shutter, u + snap / length);
        const double late = 1.0 - weft_shutter_share(&shutter, u - snap / length);
        const double value = pixel_at(&picture, 0, x, 2);
        if (!(value >= early - step - 1e-6 && value <= late + step + 1e-6))
            fail_msg("%s, %d frames, %g pixels: pixel %d is %g instead of %g to %g, step %g", name,
                     count, length, x, value, early, late, step);
        between += value > 0.0 && value < 1.0;
    }
    assert_true(between >= (count > 1 ? (int)length / 2 : 0));
    free(picture.value);
    effect_plan_clear(&plan);
    scene_clear(&scene);
}

static void a_moving_edge_is_the_ramp_of_its_shutter(void **state)
{
    (void)state;
    static const char *const shutters[] = {"box",   "tent",      "gauss", "gauss:0.1",
                                           "0:0.5", "0.25:0.75", "1:1"};
    static const int counts[] = {1, 2, 7, 32, 100};
    static const double times[2][2] = {{0.0, 1.0}, {0.25, 0.75}};
    int checked = 0;
    for (size_t s = 0; s < WEFT_COUNT(shutters); s++)
        for (size_t n = 0; n < WEFT_COUNT(counts); n++, checked++)
            check_ramp(contexts[contexts[1] && checked % 2], shutters[s], counts[n],
                       n % 2 ? 32.0 : 40.7, times[s % 2]);
    assert_int_equal(checked, 35);
}

// What is asked for unasked: a frame a pixel, so that steps are a pixel wide at most.
static void frames_are_as_many_as_pixels(void **state)
{
    (void)state;
    struct scene scene;
    make_moving_edge(&scene, -16.0, 32.0);
    struct effect_plan plan =
        plan_made(effect_params(.effects = EFFECT_MOTION_BLUR, .scene = {&scene}, .scene_count = 1,
                                .size = {size[0], size[1]}));
    struct picture picture = draw_plan(contexts[0], &plan, &scene);
    assert_int_equal(plan.count, plan.needed);
    assert_in_range(plan.count, 32, 33);
    for (int x = 17; x < 47; x++) {
        const float step = pixel_at(&picture, 0, x - 1, 2) - pixel_at(&picture, 0, x, 2);
        assert_true(step > 0.0f && step < 1.5f / 32.0f);
    }
    free(picture.value);
    effect_plan_clear(&plan);
    scene_clear(&scene);
}

// ---- what turns ---------------------------------------------------------------------------------

enum { WIDE = 48 };

// A rectangle that turns by 200 degrees, over three keys, grows and moves on a bent way. It grows
// about the eye, and is moved back to its depth.
static void make_turning(struct scene *scene)
{
    static const int picture[2] = {WIDE, WIDE};
    static const double middle[2] = {0.0, 0.0}, half[2] = {14.0, 3.0};
    struct scene_build build = empty_scene(scene, picture);
    add_rectangle(&build, add_colour(&build, 1.0f, 1.0f, 1.0f), WIDE / 2.0, middle, half, 0.0);
    struct scene_key *key = scene_build_path(&build, 3);
    assert_non_null(key);
    for (int i = 0; i < 3; i++) {
        const double angle = i * 100.0 * M_PI / 180.0;
        key[i] = (struct scene_key){
            .time = i == 1 ? 0.4 : i / 2.0,
            .position = {i == 1 ? 5.0 : -3.0, 4.0 * i - 3.0, WIDE / 2.0 * 0.25 * i},
            .rotation = {0.0, 0.0, sin(angle / 2), cos(angle / 2)},
            .scale = 1.0 + 0.25 * i};
    }
    end_scene(&build);
}

// Where the rectangle is at a time, by the definition of paths, apart from the scene's code:
// between keys everything is linear here, the angle too, as all turns have one axis.
struct turned {
    double middle[2], angle, scale;
};
static struct turned turn_to(double time)
{
    static const double at[3] = {0.0, 0.4, 1.0}, x[3] = {-3.0, 5.0, -3.0}, y[3] = {-3.0, 1.0, 5.0};
    const int i = time < 0.4 ? 0 : 1;
    const double u = (time - at[i]) / (at[i + 1] - at[i]);
    return (struct turned){{x[i] + u * (x[i + 1] - x[i]), y[i] + u * (y[i + 1] - y[i])},
                           (i + u) * 100.0 * M_PI / 180.0,
                           1.0 + 0.25 * (i + u)};
}

// Distance of a point inside of the rectangle to its nearest edge; below 0 outside.
static double find_depth(const struct turned *t, double x, double y)
{
    const double dx = x - t->middle[0], dy = y - t->middle[1], c = cos(t->angle), s = sin(t->angle);
    const double u = c * dx + s * dy, v = c * dy - s * dx;
    return fmin(14.0 * t->scale - fabs(u), 3.0 * t->scale - fabs(v));
}

static void what_turns_is_what_its_places_say(void **state)
{
    (void)state;
    struct scene scene;
    make_turning(&scene);
    struct weft_shutter shutter = {.open = 0.3, .close = 0.6};
    struct effect_plan plan = plan_made(
        effect_params(.effects = EFFECT_MOTION_BLUR, .scene = {&scene}, .scene_count = 1,
                      .size = {WIDE, WIDE}, .frames = 61, .shutter = shutter, .time = {0.1, 0.95}));
    struct picture picture = draw_plan(contexts[0], &plan, &scene);
    double doubtful = 0.0;
    int between = 0;
    for (int y = 0; y < WIDE; y++)
        for (int x = 0; x < WIDE; x++) {
            double sum = 0.0, near = 0.0;
            for (int64_t k = 0; k < plan.count; k++) {
                const struct turned turned = turn_to(plan.frames[k].show.time);
                const double depth =
                    find_depth(&turned, x + 0.5 - WIDE / 2.0, y + 0.5 - WIDE / 2.0);
                sum += depth > 0.0 ? plan.frames[k].weight : 0.0;
                near += fabs(depth) <= snap ? plan.frames[k].weight : 0.0;
            }
            assert_near(pixel_at(&picture, 0, x, y), sum, near + 1e-6, "pixel");
            doubtful += near;
            between += sum > 0.01 && sum < 0.99;
        }
    print_message("%d pixels in motion, %.2f of them within 1/256 of an edge\n", between, doubtful);
    assert_true(between > 500 && doubtful < 0.02 * between);
    free(picture.value);
    effect_plan_clear(&plan);
    scene_clear(&scene);
}

// ---- with anti-aliasing -------------------------------------------------------------------------

// The edge's pixel is the share of (place, time) pairs that it covers: 1/2 + d / v of a square cut
// by a straight line, which is the convolution of a pixel and a ramp. The pairs' own half-plane
// discrepancy bounds the error, and the edge's rounding adds its slope.
// `drawn` are the first ones of `count` frames.
static void check_with_antialias(int count, int drawn, uint64_t seed, const char *jitter)
{
    static double pairs[1024][2];
    struct scene scene;
    const double from = -8.3, way = 21.0;
    make_moving_edge(&scene, from, way);
    struct effect_plan plan =
        plan_made(effect_params(.effects = EFFECT_MOTION_BLUR | EFFECT_ANTIALIAS, .scene = {&scene},
                                .scene_count = 1, .size = {size[0], size[1]}, .frames = count,
                                .seed = seed, .centre = true, .jitter = weft_jitter_find(jitter)));
    for (int k = 0; k < drawn; k++) {
        pairs[k][0] = -plan.frames[k].show.camera.move[0];
        pairs[k][1] = plan.frames[k].show.time - 0.5;
    }
    struct weft_discrepancy joint;
    assert_int_equal(
        weft_discrepancy_compute(
            weft_discrepancy_params(.points = (const double(*)[2])pairs, .count = drawn), &joint),
        WEFT_OK);
    const struct scene *const scenes = &scene;
    struct picture picture = draw_frames(
        contexts[0], &plan, &scenes,
        (struct weft_accumulator_params){.method = WEFT_ACCUMULATE_EXACT, .frame_bits = 32}, 0,
        drawn);
    // A sample at p, pixels from the centre c, is white at the time t where c + p <= from + way t.
    const double normal[2] = {1.0, -way}, length = hypot(1.0, way);
    const double bound = joint.value + M_SQRT2 * snap / length + 1e-6;
    double worst = 0.0;
    int between = 0;
    for (int x = 0; x < size[0]; x++) {
        const double d = (from + way / 2.0 - (x + 0.5 - 0.5 * size[0])) / length;
        const double exact = weft_edge_square(normal, d), value = pixel_at(&picture, 0, x, 1);
        worst = larger(worst, fabs(value - exact));
        between += exact > 0.0 && exact < 1.0;
    }
    print_message("%d of %d frames by %s, with motion: error %.3f, bound %.3f\n", drawn, count,
                  jitter, worst, bound);
    // No worse than three times what sets are that fill a square as evenly as can be (Sobol's).
    assert_true(joint.value <= 3.0 * pow(drawn, -0.6));
    assert_true(between >= 22);
    assert_true(worst <= bound);
    free(picture.value);
    effect_plan_clear(&plan);
    scene_clear(&scene);
}

static void with_antialiasing_it_is_the_ramp_through_a_pixel(void **state)
{
    (void)state;
    check_with_antialias(8, 8, 1, "j8");
    check_with_antialias(66, 66, 2, "j66");
    check_with_antialias(256, 256, 3, "sobol");
    check_with_antialias(1024, 1024, 4, "halton");
}

// Whatever the set, the first frames are a sample of all dimensions.
static void plans_can_be_stopped_early(void **state)
{
    (void)state;
    static const char *const sets[] = {"sobol", "r2", "hammersley", "grid"};
    for (size_t i = 0; i < WEFT_COUNT(sets); i++)
        for (int drawn = 64; drawn <= 256; drawn *= 4)
            check_with_antialias(1024, drawn, i, sets[i]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_moving_edge_is_the_ramp_of_its_shutter),
        cmocka_unit_test(frames_are_as_many_as_pixels),
        cmocka_unit_test(what_turns_is_what_its_places_say),
        cmocka_unit_test(with_antialiasing_it_is_the_ramp_through_a_pixel),
        cmocka_unit_test(plans_can_be_stopped_early),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
