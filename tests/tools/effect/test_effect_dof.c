// SPDX-License-Identifier: BSD-3-Clause
// Depth of field: the plane in focus stays put, circles of confusion are the thin lens's.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "tests/tools/effect/pictures.h"

static const int size[2] = {128, 96};

// A unit at depth z is so many pixels.
static double scale_at(double depth)
{
    return 0.5 * size[1] / depth;
}

static struct effect_plan plan_of(const struct scene *scene, unsigned more, int count, double focus,
                                  double aperture)
{
    return plan_made(effect_params(.effects = EFFECT_DOF | more, .scene = {scene}, .scene_count = 1,
                                   .size = {size[0], size[1]}, .frames = count, .focus = focus,
                                   .aperture = aperture));
}

// ---- matrices -----------------------------------------------------------------------------------

static void random_camera(uint64_t *seed, struct weft_camera *out)
{
    *out = *weft_camera(.fovy_degrees = random_in(seed, 10.0, 120.0));
    out->near_distance = random_in(seed, 0.1, 2.0);
    out->far_distance = out->near_distance * random_in(seed, 5.0, 1000.0);
    for (int i = 0; i < 3; i++) {
        out->eye[i] = random_in(seed, -10.0, 10.0);
        out->target[i] = random_in(seed, -10.0, 10.0);
        out->up[i] = random_in(seed, -1.0, 1.0);
    }
}

static void project(const double m[16], const double p[4], double out[4])
{
    for (int row = 0; row < 4; row++) {
        out[row] = 0.0;
        for (int i = 0; i < 4; i++)
            out[row] += m[4 * i + row] * p[i];
    }
}

// The point of the world at a place of the picture (-1 to 1) and a depth, by the view's own rows.
static void find_point(const struct weft_camera *camera, const struct weft_camera_matrices *m,
                       const double place[2], double depth, double out[4])
{
    const double v[3] = {place[0] * depth / m->projection[0], place[1] * depth / m->projection[5],
                         -depth};
    for (int i = 0; i < 3; i++) {
        out[i] = camera->eye[i];
        for (int row = 0; row < 3; row++)
            out[i] += m->view[4 * i + row] * v[row];
    }
    out[3] = 1.0;
}

// Frames of a plan on one camera. The largest move of points of the plane in focus, in units of
// half the picture; of others the difference to the thin lens's.
static void check_matrices(const struct weft_camera *camera, const struct effect_plan *plan,
                           uint64_t *seed, double *still, double *moved)
{
    struct weft_camera_frame middle = plan->frames[0].show.camera;
    struct weft_camera_matrices from, to;
    middle.lens[0] = middle.lens[1] = 0.0;
    middle.move[0] = middle.move[1] = 0.0;
    assert_int_equal(weft_camera_compute(&log_to_stderr, camera, &middle, &from), WEFT_OK);
    for (int64_t k = 0; k < plan->count; k++) {
        const struct weft_camera_frame *frame = &plan->frames[k].show.camera;
        assert_int_equal(weft_camera_compute(&log_to_stderr, camera, frame, &to), WEFT_OK);
        for (int at = 0; at < 2; at++) {
            const double place[2] = {random_in(seed, -1.0, 1.0), random_in(seed, -1.0, 1.0)};
            const double depth = plan->focus * (at ? random_in(seed, 0.5, 3.0) : 1.0);
            double point[4], a[4], b[4];
            find_point(camera, &from, place, depth, point);
            project(from.clip, point, a);
            project(to.clip, point, b);
            for (int axis = 0; axis < 2; axis++) {
                const double shift = b[axis] / b[3] - a[axis] / a[3];
                const double expected = frame->lens[axis] * (1.0 / plan->focus - 1.0 / depth) *
                                            from.projection[5 * axis] +
                                        2.0 * frame->move[axis] / size[axis];
                double *worst = at ? moved : still;
                *worst = larger(*worst, fabs(shift - expected));
            }
        }
    }
}

static void the_plane_in_focus_stays_put_in_the_matrices(void **state)
{
    (void)state;
    uint64_t seed = 3;
    double still = 0.0, moved = 0.0;
    for (int i = 0; i < 500; i++) {
        struct scene scene;
        make_half_plane(&scene, size, 0.0, 0.0);
        random_camera(&seed, &scene.camera);
        const double focus = scene.camera.near_distance * random_in(&seed, 1.1, 20.0);
        struct effect_plan plan = plan_of(&scene, i % 2 ? EFFECT_ANTIALIAS : 0, 8, focus,
                                          focus * random_in(&seed, 0.0, 0.3));
        check_matrices(&scene.camera, &plan, &seed, &still, &moved);
        effect_plan_clear(&plan);
        scene_clear(&scene);
    }
    print_message("points in focus stay within %.1e of half the picture, others are where the lens "
                  "has them within %.1e\n",
                  still, moved);
    assert_true(still <= 1e-12);
    assert_true(moved <= 1e-12);
}

// ---- pictures -----------------------------------------------------------------------------------

enum { RECTANGLES = 24 };

// Rectangles in the plane in focus, in pixels; they do not overlap much. The mean of all frames is
// what the pinhole sees: 0 or 1 wherever a pixel's centre is further from an edge than positions
// are rounded. Many centres are just beyond that.
static void the_plane_in_focus_stays_put_in_the_picture(void **state)
{
    (void)state;
    const double focus = 31.7, unit = 1.0 / scale_at(focus), half[2] = {9.0 * unit, 5.0 * unit};
    double at[RECTANGLES][2], turn[RECTANGLES];
    uint64_t seed = 8;
    struct scene scene;
    struct scene_build build = empty_scene(&scene, size);
    const int white = add_colour(&build, 1.0f, 1.0f, 1.0f);
    for (int i = 0; i < RECTANGLES; i++) {
        at[i][0] = random_in(&seed, -60.0, 60.0) * unit;
        at[i][1] = random_in(&seed, -45.0, 45.0) * unit;
        turn[i] = random_in(&seed, 0.0, M_PI);
        add_rectangle(&build, white, focus, at[i], half, turn[i]);
    }
    end_scene(&build);
    struct effect_plan plan = plan_of(&scene, 0, 24, focus, 6.0);
    int close = 0, inside = 0;
    for (int c = 0; c < 2 && contexts[c]; c++) {
        struct picture picture = draw_plan(contexts[c], &plan, &scene);
        for (int y = 0; y < size[1]; y++)
            for (int x = 0; x < size[0]; x++) {
                const double px = (x + 0.5 - 0.5 * size[0]) * unit;
                const double py = (y + 0.5 - 0.5 * size[1]) * unit;
                double depth = -INFINITY, nearest = INFINITY; // pixels within; to any edge's line
                for (int i = 0; i < RECTANGLES; i++) {
                    const double dx = px - at[i][0], dy = py - at[i][1];
                    const double u = fabs(cos(turn[i]) * dx + sin(turn[i]) * dy);
                    const double v = fabs(cos(turn[i]) * dy - sin(turn[i]) * dx);
                    const double within = fmin(half[0] - u, half[1] - v) / unit;
                    depth = fmax(depth, within);
                    nearest = fmin(nearest, fabs(within));
                }
                if (nearest <= snap)
                    continue;
                assert_near(pixel_at(&picture, 0, x, y), depth > 0.0, 1e-6, "pixel in focus");
                inside += depth > 0.0;
                close += nearest <= 4.0 * snap;
            }
        free(picture.value);
    }
    print_message("%d pixels whose centres are 1/256 to 4/256 from an edge\n", close);
    assert_true(close >= 20 && inside > 1000);
    effect_plan_clear(&plan);
    scene_clear(&scene);
}

// A white square of 2 x 2 pixels at a depth, in the middle.
static void make_dot(struct scene *scene, double depth)
{
    const double middle[2] = {0.0, 0.0}, half[2] = {1.0 / scale_at(depth), 1.0 / scale_at(depth)};
    struct scene_build build = empty_scene(scene, size);
    add_rectangle(&build, add_colour(&build, 1.0f, 1.0f, 1.0f), depth, middle, half, 0.0);
    end_scene(&build);
}

struct blur {
    int extent[2];                // columns and rows that are not black
    double mean[2], deviation[2]; // of where the light is, pixels from the picture's middle
};

static struct blur measure(const struct picture *picture)
{
    struct blur blur = {{0, 0}, {0.0, 0.0}, {0.0, 0.0}};
    double sum = 0.0;
    int low[2] = {size[0], size[1]}, high[2] = {-1, -1};
    for (int y = 0; y < size[1]; y++)
        for (int x = 0; x < size[0]; x++) {
            const double value = pixel_at(picture, 0, x, y);
            const int at[2] = {x, y};
            sum += value;
            for (int axis = 0; axis < 2 && value > 0.0; axis++) {
                const double place = at[axis] + 0.5 - 0.5 * size[axis];
                blur.mean[axis] += value * place;
                blur.deviation[axis] += value * place * place;
                low[axis] = at[axis] < low[axis] ? at[axis] : low[axis];
                high[axis] = at[axis] > high[axis] ? at[axis] : high[axis];
            }
        }
    for (int axis = 0; axis < 2; axis++) {
        blur.extent[axis] = high[axis] - low[axis] + 1;
        blur.mean[axis] /= sum;
        blur.deviation[axis] = sqrt(blur.deviation[axis] / sum - blur.mean[axis] * blur.mean[axis]);
    }
    return blur;
}

// A dot 2 pixels wide covers two columns of centres in each frame, wherever it is, so that the blur
// is as many columns wide as the places on the lens are apart, in pixels, and 2, give or take one
// and the rounding of both ends. Places come to the lens's rim as near as the plan says: within 1
// %. And the light is spread as over a disc: with the deviation c / 4 of its own, that of two
// columns, 1/2, and at most 1/2 of where they lie to where the dot is.
static void check_circle(weft_context *context, double depth, double focus, double aperture)
{
    struct scene scene;
    make_dot(&scene, depth);
    struct effect_plan plan = plan_of(&scene, 0, 1024, focus, aperture);
    struct picture picture = draw_plan(context, &plan, &scene);
    const struct blur blur = measure(&picture);
    const double circle = weft_camera_circle(&scene.camera, size, aperture, focus, depth);
    for (int axis = 0; axis < 2; axis++) {
        double low = 0.0, high = 0.0;
        for (int64_t k = 0; k < plan.count; k++) {
            low = fmin(low, plan.frames[k].show.camera.lens[axis]);
            high = fmax(high, plan.frames[k].show.camera.lens[axis]);
        }
        const double reached = (high - low) / aperture;
        assert_true(reached > 0.99 && reached <= 1.0);
        assert_true(blur.extent[axis] - 2 >= reached * circle - 1.0 - 2.0 * snap);
        assert_true(blur.extent[axis] - 2 <= circle + 1.0 + 2.0 * snap);
        assert_near(blur.deviation[axis], hypot(circle / 4.0, 0.5), 0.5, "deviation");
        assert_near(blur.mean[axis], 0.0, 0.1, "middle");
    }
    const double diameter = 4.0 * sqrt(blur.deviation[0] * blur.deviation[0] - 0.25 - 1.0 / 12.0);
    print_message(
        "depth %g, focus %g: %d columns, diameter %.2f by its deviation, the lens's %.2f\n", depth,
        focus, blur.extent[0], diameter, circle);
    assert_near(diameter, circle, 0.02 * circle, "diameter");
    free(picture.value);
    effect_plan_clear(&plan);
    scene_clear(&scene);
}

static void circles_have_the_lens_diameter(void **state)
{
    (void)state;
    check_circle(contexts[0], 4.0, 10.0, 5.0);
    check_circle(contexts[0], 25.0, 10.0, 12.0);
    check_circle(contexts[0], 200.0, 10.0, 8.0);
    check_circle(contexts[contexts[1] ? 1 : 0], 7.0, 50.0, 10.0);
}

// With the eye to the right and above, what lies beyond the plane in focus moves right and up, what
// lies before it left and down.
static void both_sides_move_as_they_should(void **state)
{
    (void)state;
    static const double depth[2] = {5.0, 30.0};
    for (int i = 0; i < 2; i++) {
        struct scene scene;
        make_dot(&scene, depth[i]);
        const struct scene *const scenes = &scene;
        struct effect_plan plan = plan_of(&scene, 0, 66, 10.0, 5.0);
        for (int64_t k = 0; k < plan.count; k += 5) {
            struct picture picture = draw_frames(
                contexts[0], &plan, &scenes,
                (struct weft_accumulator_params){.method = WEFT_ACCUMULATE_EXACT, .frame_bits = 32},
                k, 1);
            const struct blur blur = measure(&picture);
            for (int axis = 0; axis < 2; axis++)
                assert_near(blur.mean[axis],
                            plan.frames[k].show.camera.lens[axis] * (0.1 - 1.0 / depth[i]) *
                                size[1] / 2.0,
                            0.5 + snap, "where it is");
            free(picture.value);
        }
        effect_plan_clear(&plan);
        scene_clear(&scene);
    }
}

// ---- edges out of focus -------------------------------------------------------------------------

static void make_edge(struct scene *scene, double depth, double angle, double distance)
{
    const double reach = 400.0, unit = 1.0 / scale_at(depth), side = reach * unit;
    const double middle[2] = {cos(angle) * (distance - reach) * unit,
                              sin(angle) * (distance - reach) * unit};
    const double half[2] = {side, side};
    struct scene_build build = empty_scene(scene, size);
    add_rectangle(&build, add_colour(&build, 1.0f, 1.0f, 1.0f), depth, middle, half, angle);
    end_scene(&build);
}

// The share of a disc of diameter `circle`, and of a pixel where `boxed`, that lies before d: the
// mean over the pixel's places along the normal, by the middles of many parts of its trapezoid.
static double find_share(double circle, bool boxed, const double normal[2], double d)
{
    enum { PARTS = 100 };
    double sum = 0.0;
    if (!boxed)
        return weft_edge_disc(d / circle);
    if (fabs(d) > circle / 2.0 + 1.0)
        return d > 0.0;
    double before = weft_edge_square(normal, -1.0);
    for (int i = 0; i < PARTS; i++) {
        const double at = -1.0 + 2.0 * (i + 1.0) / PARTS, now = weft_edge_square(normal, at);
        sum += (now - before) * weft_edge_disc((d - at + 1.0 / PARTS) / circle);
        before = now;
    }
    return sum;
}

static int compare_numbers(const void *a, const void *b)
{
    const double p = *(const double *)a, q = *(const double *)b;
    return (p > q) - (p < q);
}

// Where a frame sees the edge, along its normal: pixels that it has moved.
static double find_place(const struct effect_frame *frame, const double normal[2], double scale)
{
    const struct weft_camera_frame *camera = &frame->show.camera;
    double place = 0.0;
    for (int axis = 0; axis < 2; axis++)
        place += normal[axis] * (camera->lens[axis] * scale + camera->move[axis]);
    return place;
}

// The largest difference of the places' distribution to the one they stand for.
static double find_discrepancy(const struct effect_plan *plan, const double normal[2],
                               double circle, bool boxed)
{
    static double place[256];
    const int count = (int)plan->count;
    double worst = 0.0;
    for (int k = 0; k < count; k++)
        place[k] = find_place(&plan->frames[k], normal, circle / plan->aperture);
    qsort(place, (size_t)count, sizeof *place, compare_numbers);
    for (int k = 0; k < count; k++) {
        const double share = find_share(circle, boxed, normal, place[k]);
        worst = fmax(worst, fmax(share - (double)k / count, (k + 1.0) / count - share));
    }
    return worst;
}

// An edge beyond the plane in focus, within the discrepancy of the lens's set; with anti-aliasing
// too, within that of the sums of both places along the edge's normal.
static void check_edge(bool boxed, double angle, double distance)
{
    const double depth = 30.0, focus = 10.0, aperture = 4.0;
    const double normal[2] = {cos(angle), sin(angle)};
    struct scene scene;
    make_edge(&scene, depth, angle, distance);
    const double circle = weft_camera_circle(&scene.camera, size, aperture, focus, depth);
    struct effect_plan plan = plan_of(&scene, boxed ? EFFECT_ANTIALIAS : 0, 256, focus, aperture);
    struct picture picture = draw_plan(contexts[0], &plan, &scene);
    const double slope = snap * 4.0 / (M_PI * circle); // of the disc, at most, over the rounding
    double worst = 0.0, against_plan = 0.0;
    int between = 0;
    for (int y = 0; y < size[1]; y += 7)
        for (int x = 0; x < size[0]; x++) {
            const double d = distance - normal[0] * (x + 0.5 - 0.5 * size[0]) -
                             normal[1] * (y + 0.5 - 0.5 * size[1]);
            const double exact = find_share(circle, boxed, normal, d);
            const double value = pixel_at(&picture, 0, x, y);
            double sum = 0.0, near = 0.0;
            for (int64_t k = 0; k < plan.count; k++) {
                const double place = find_place(&plan.frames[k], normal, circle / aperture);
                sum += place <= -d ? 0.0 : plan.frames[k].weight;
                near += fabs(place + d) <= 2.0 * snap ? plan.frames[k].weight : 0.0;
            }
            against_plan = larger(against_plan, fabs(value - sum) - near);
            worst = larger(worst, fabs(value - exact));
            between += exact > 0.0 && exact < 1.0;
        }
    const double bound =
        boxed ? find_discrepancy(&plan, normal, circle, true) : plan.set[EFFECT_LENS].discrepancy;
    print_message("edge at %g, %s: error %.4f, bound %.4f, %d pixels\n", angle,
                  boxed ? "anti-aliased" : "not", worst, bound + slope, between);
    assert_true(against_plan <= 1e-6);
    assert_true(worst <= bound + slope + 1e-6);
    assert_true(bound < 0.06); // as seen; of random places it would be 1.36 / sqrt(256) at 5 %
    assert_true(between > 100);
    free(picture.value);
    effect_plan_clear(&plan);
    scene_clear(&scene);
}

static void an_edge_out_of_focus_is_the_share_of_the_lens(void **state)
{
    (void)state;
    for (int i = 0; i < 6; i++) {
        check_edge(false, i * 0.7, 0.3 * i - 1.0);
        check_edge(true, i * 0.7, 0.3 * i - 1.0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_plane_in_focus_stays_put_in_the_matrices),
        cmocka_unit_test(the_plane_in_focus_stays_put_in_the_picture),
        cmocka_unit_test(circles_have_the_lens_diameter),
        cmocka_unit_test(both_sides_move_as_they_should),
        cmocka_unit_test(an_edge_out_of_focus_is_the_share_of_the_lens),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
