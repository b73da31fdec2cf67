// SPDX-License-Identifier: BSD-3-Clause
// Matrices of frames: against the Guide's accFrustum in long double, and by what an effect needs of
// them: the plane in focus stays, a move is a move, circles of confusion are the thin lens's.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <string.h>

#include "tests/passes/jitter/points.h"
#include "passes/jitter/camera.h"
#include "passes/jitter/counts.h"

static struct message last;
static const struct weft_log remember_log = {keep_message, &last};

static void compute(const struct weft_camera *camera, const struct weft_camera_frame *frame,
                    struct weft_camera_matrices *out)
{
    assert_int_equal(weft_camera_compute(&log_to_stderr, camera, frame, out), WEFT_OK);
}

// A camera somewhere, looking somewhere.
static struct weft_camera random_camera(uint64_t *random)
{
    struct weft_camera c = {
        .fovy_degrees = random_in(random, 20.0, 80.0),
        .aspect = random_in(random, 0.5, 2.0),
        .near_distance = random_in(random, 0.5, 2.0),
        .far_distance = random_in(random, 10.0, 50.0),
    };
    for (int i = 0; i < 3; i++) {
        c.eye[i] = random_in(random, -5.0, 5.0);
        c.target[i] = c.eye[i] + random_in(random, 1.0, 4.0) * (i % 2 ? -1.0 : 1.0);
        c.up[i] = i == 1 ? 1.0 : random_in(random, -0.3, 0.3);
    }
    return c;
}

// ---- the Guide's formulas, in long double
// ---------------------------------------------------------

typedef long double wide[16];

static void product(const wide a, const wide b, wide out)
{
    for (int column = 0; column < 4; column++)
        for (int row = 0; row < 4; row++) {
            out[4 * column + row] = 0.0L;
            for (int i = 0; i < 4; i++)
                out[4 * column + row] += a[4 * i + row] * b[4 * column + i];
        }
}

// glFrustum, as its reference page has it.
static void frustum(long double l, long double r, long double b, long double t, long double n,
                    long double f, wide m)
{
    memset(m, 0, sizeof(wide));
    m[0] = 2.0L * n / (r - l);
    m[5] = 2.0L * n / (t - b);
    m[8] = (r + l) / (r - l);
    m[9] = (t + b) / (t - b);
    m[10] = -(f + n) / (f - n);
    m[11] = -1.0L;
    m[14] = -2.0L * f * n / (f - n);
}

// accFrustum(l, r, b, t, near, far, pixdx, pixdy, eyedx, eyedy, focus), as the Guide prints it.
static void acc_frustum(const struct weft_camera *c, const struct weft_camera_frame *s, wide m)
{
    const long double pi = 3.14159265358979323846264338327950288L;
    const long double n = c->near_distance, top = n * tanl(c->fovy_degrees * pi / 360.0L);
    const long double right = top * c->aspect, xwsize = 2.0L * right, ywsize = 2.0L * top;
    long double dx = 0.0L, dy = 0.0L;
    dx = -(s->move[0] * xwsize / s->size[0] + s->lens[0] * n / s->focus);
    dy = -(s->move[1] * ywsize / s->size[1] + s->lens[1] * n / s->focus);
    wide projection;
    frustum(-right + dx, right + dx, -top + dy, top + dy, n, c->far_distance, projection);
    wide translate = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -s->lens[0], -s->lens[1], 0, 1};
    product(projection, translate, m);
}

// gluLookAt, as its reference page has it.
static void look_at(const struct weft_camera *c, wide m)
{
    long double f[3], s[3], u[3], length = 0.0L;
    for (int i = 0; i < 3; i++) {
        f[i] = (long double)c->target[i] - c->eye[i];
        length += f[i] * f[i];
    }
    for (int i = 0; i < 3; i++)
        f[i] /= sqrtl(length);
    for (int i = 0; i < 3; i++)
        s[i] = f[(i + 1) % 3] * c->up[(i + 2) % 3] - f[(i + 2) % 3] * c->up[(i + 1) % 3];
    length = sqrtl(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
    for (int i = 0; i < 3; i++)
        s[i] /= length;
    for (int i = 0; i < 3; i++)
        u[i] = s[(i + 1) % 3] * f[(i + 2) % 3] - s[(i + 2) % 3] * f[(i + 1) % 3];
    const wide turn = {s[0], u[0], -f[0], 0, s[1], u[1], -f[1], 0,
                       s[2], u[2], -f[2], 0, 0,    0,    0,     1};
    const wide move = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -c->eye[0], -c->eye[1], -c->eye[2], 1};
    product(turn, move, m);
}

static void test_against_the_guide(void **state)
{
    (void)state;
    uint64_t random = 1;
    for (int i = 0; i < 2000; i++) {
        const struct weft_camera camera = random_camera(&random);
        struct weft_camera_frame frame = {.size = {1 + i % 640, 1 + i % 480},
                                          .focus = random_in(&random, 1.0, 20.0)};
        for (int axis = 0; axis < 2; axis++) {
            frame.move[axis] = random_in(&random, -2.0, 2.0);
            frame.lens[axis] = random_in(&random, -0.5, 0.5);
        }
        struct weft_camera_matrices m;
        compute(&camera, &frame, &m);
        wide projection, view, clip, twice;
        acc_frustum(&camera, &frame, projection);
        look_at(&camera, view);
        product(projection, view, clip);
        for (int k = 0; k < 16; k++) {
            assert_near(m.clip[k], (double)clip[k], 1e-13, "clip");
            assert_true(m.clip_float[k] == (float)m.clip[k] &&
                        m.view_float[k] == (float)m.view[k] &&
                        m.projection_float[k] == (float)m.projection[k]);
        }
        wide ours, mine;
        for (int k = 0; k < 16; k++)
            ours[k] = m.projection[k], mine[k] = m.view[k];
        product(ours, mine, twice);
        for (int k = 0; k < 16; k++)
            assert_near(m.clip[k], (double)twice[k], 1e-13, "product");
    }
}

// The Guide's own programs, by hand: dof has fovy 45, near 1, far 15, focus 5.
static void test_by_hand(void **state)
{
    (void)state;
    const struct weft_camera camera = {WEFT_CAMERA_DEFAULTS.far_distance = 15.0};
    const struct weft_camera_frame frame = {
        .size = {200, 100}, .move = {0.5, -0.25}, .lens = {0.33, 0.0}, .focus = 5.0};
    struct weft_camera_matrices m;
    compute(&camera, &frame, &m);
    const double cot = 1.0 + M_SQRT2; // of 22.5 degrees
    assert_near(m.projection[5], cot, 1e-15, "cot");
    assert_near(m.projection[0], cot / 2.0, 1e-15, "aspect from the picture");
    assert_near(m.projection[8], -0.005 - 0.33 / 5.0 * cot / 2.0, 1e-16, "x");
    assert_near(m.projection[9], 0.005, 1e-17, "y");
    assert_near(m.projection[10], -16.0 / 14.0, 1e-15, "z");
    assert_near(m.projection[14], -30.0 / 14.0, 1e-15, "z");
    assert_true(m.view[12] == -0.33 && m.view[13] == 0.0 && m.view[0] == 1.0 && m.view[5] == 1.0);
}

// ---- what an effect needs
// -------------------------------------------------------------------------

static void project(const double clip[16], const double point[3], double ndc[3])
{
    double out[4];
    for (int row = 0; row < 4; row++)
        out[row] = clip[row] * point[0] + clip[4 + row] * point[1] + clip[8 + row] * point[2] +
                   clip[12 + row];
    for (int i = 0; i < 3; i++)
        ndc[i] = out[i] / out[3];
}

// The point that is (x, y) off the middle of the view at a distance along the direction of sight,
// from the view without a lens.
static void place(const struct weft_camera_matrices *m, const struct weft_camera *c, double x,
                  double y, double depth, double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] =
            c->eye[i] + x * m->view[4 * i] + y * m->view[4 * i + 1] - depth * m->view[4 * i + 2];
}

static void random_point(uint64_t *random, const struct weft_camera_matrices *m,
                         const struct weft_camera *c, double depth, double out[3])
{
    const double reach = depth * tan(c->fovy_degrees * M_PI / 360.0);
    place(m, c, random_in(random, -reach, reach) * c->aspect, random_in(random, -reach, reach),
          depth, out);
}

static void test_focus(void **state)
{
    (void)state;
    uint64_t random = 2;
    double farthest = 0.0;
    int moved = 0;
    for (int i = 0; i < 300; i++) {
        const struct weft_camera camera = random_camera(&random);
        const double focus = random_in(&random, camera.near_distance, camera.far_distance);
        struct weft_camera_frame frame = {.size = {640, 480}, .focus = focus};
        struct weft_camera_matrices middle, m;
        compute(&camera, &frame, &middle);
        for (int k = 0; k < 20; k++) {
            double on[3], off[3], a[3], b[3];
            for (int axis = 0; axis < 2; axis++)
                frame.lens[axis] = random_in(&random, -0.5, 0.5);
            compute(&camera, &frame, &m);
            random_point(&random, &middle, &camera, focus, on);
            random_point(&random, &middle, &camera, 1.5 * focus, off);
            project(middle.clip, on, a);
            project(m.clip, on, b);
            for (int axis = 0; axis < 3; axis++)
                farthest = larger(farthest, fabs(a[axis] - b[axis]));
            project(middle.clip, off, a);
            project(m.clip, off, b);
            moved += hypot(a[0] - b[0], a[1] - b[1]) > 1e-4;
        }
    }
    assert_near(farthest, 0.0, 1e-12, "of the plane in focus");
    assert_true(moved > 5900);
}

// A move is as many pixels for every point, whatever its depth and whatever the lens.
static void test_move(void **state)
{
    (void)state;
    uint64_t random = 3;
    double farthest = 0.0;
    for (int i = 0; i < 300; i++) {
        const struct weft_camera camera = random_camera(&random);
        struct weft_camera_frame frame = {.size = {1 + i, 1000 - i},
                                          .lens = {random_in(&random, -0.3, 0.3), 0.1},
                                          .focus = random_in(&random, 2.0, 9.0)};
        struct weft_camera_matrices still, m, middle;
        compute(&camera, &frame, &still);
        compute(&camera, &(struct weft_camera_frame){.size = {1, 1}}, &middle);
        for (int k = 0; k < 20; k++) {
            double point[3], a[3], b[3];
            for (int axis = 0; axis < 2; axis++)
                frame.move[axis] = random_in(&random, -3.0, 3.0);
            compute(&camera, &frame, &m);
            random_point(&random, &middle, &camera,
                         random_in(&random, camera.near_distance, camera.far_distance), point);
            project(still.clip, point, a);
            project(m.clip, point, b);
            for (int axis = 0; axis < 2; axis++) {
                const double pixels = (b[axis] - a[axis]) * 0.5 * frame.size[axis];
                farthest = larger(farthest, fabs(pixels - frame.move[axis]));
            }
            assert_near(b[2], a[2], 1e-14, "depth");
        }
    }
    // A few roundings of coordinates up to 1 across 1,000 pixels.
    assert_near(farthest, 0.0, 1e-11, "pixels");
}

// Everything as the header's figure has it, in pixels of OpenGL and in rows of an image.
static void test_signs(void **state)
{
    (void)state;
    const struct weft_camera camera = {WEFT_CAMERA_DEFAULTS};
    struct weft_camera_frame frame = {.size = {64, 32}};
    struct weft_camera_matrices m;
    const double ahead[3] = {0.0, 0.0, -7.0}, sample[2] = {0.3, 0.4};
    double ndc[3];
    // Of the pixel whose centre is the picture's, the sample is right of and, in rows, below it:
    // the point there, at the pixel of OpenGL (32.3, 16 - 0.4), comes to the centre.
    weft_camera_move_to(sample, frame.move);
    assert_true(frame.move[0] == -0.3 && frame.move[1] == 0.4);
    compute(&camera, &frame, &m);
    const double half = 7.0 * tan(M_PI / 8.0);
    const double point[3] = {0.3 / 32.0 * 2.0 * half, -0.4 / 16.0 * half, -7.0};
    project(m.clip, point, ndc);
    assert_near(ndc[0], 0.0, 1e-15, "x");
    assert_near(ndc[1], 0.0, 1e-15, "y");
    // In place.
    double both[2] = {1.0, 2.0};
    weft_camera_move_to(both, both);
    assert_true(both[0] == -1.0 && both[1] == 2.0);
    // With the eye to the right and up, what is beyond the focus goes right and up, what is before
    // it left and down.
    frame = (struct weft_camera_frame){.size = {64, 32}, .lens = {0.2, 0.1}, .focus = 10.0};
    compute(&camera, &frame, &m);
    project(m.clip, ahead, ndc);
    assert_true(ndc[0] < -1e-3 && ndc[1] < -1e-3);
    frame.focus = 5.0;
    compute(&camera, &frame, &m);
    project(m.clip, ahead, ndc);
    assert_true(ndc[0] > 1e-3 && ndc[1] > 1e-3);
}

// ---- circles of confusion
// -------------------------------------------------------------------------

// The image of a point by the thin lens equation, 1 / f = 1 / depth + 1 / v, for a focal length:
// the sensor stands at the image of the focus; its half height is seen under fovy / 2 from the
// lens.
static double thin_lens(const struct weft_camera *c, const int size[2], double aperture,
                        double focus, double depth, long double focal)
{
    const long double sensor = focal * focus / (focus - focal);
    const long double image = focal * depth / (depth - focal);
    const long double circle = aperture * fabsl(sensor - image) / fabsl(image);
    const long double half = sensor * tanl(c->fovy_degrees * M_PI / 360.0);
    return (double)(circle / (2.0L * half) * size[1]);
}

static void test_circles(void **state)
{
    (void)state;
    uint64_t random = 4;
    for (int i = 0; i < 2000; i++) {
        struct weft_camera camera = random_camera(&random);
        const int size[2] = {320, 240};
        camera.aspect = i % 2 ? 0.0 : 320.0 / 240.0;
        const double aperture = random_in(&random, 0.0, 1.0), focus = random_in(&random, 1.0, 20.0);
        const double depth = random_in(&random, 1.0, 40.0);
        const double c = weft_camera_circle(&camera, size, aperture, focus, depth);
        for (int f = 1; f <= 3; f++)
            assert_near(c, thin_lens(&camera, size, aperture, focus, depth, 0.02L * f),
                        1e-12 * (1.0 + c), "thin lens");
        // The disc that the matrices draw: from opposite points of the lens's rim.
        camera.aspect = 320.0 / 240.0;
        const double angle = random_in(&random, 0.0, M_PI);
        struct weft_camera_frame frame = {.size = {320, 240}, .focus = focus};
        struct weft_camera_matrices middle, one, other;
        compute(&camera, &frame, &middle);
        frame.lens[0] = 0.5 * aperture * cos(angle);
        frame.lens[1] = 0.5 * aperture * sin(angle);
        compute(&camera, &frame, &one);
        frame.lens[0] = -frame.lens[0];
        frame.lens[1] = -frame.lens[1];
        compute(&camera, &frame, &other);
        double point[3], a[3], b[3];
        random_point(&random, &middle, &camera, depth, point);
        project(one.clip, point, a);
        project(other.clip, point, b);
        assert_near(hypot(160.0 * (a[0] - b[0]), 120.0 * (a[1] - b[1])), c, 1e-10, "drawn");
        assert_true(weft_camera_circle(&camera, size, aperture, focus, focus) == 0.0);
    }
}

static void test_circle_ends(void **state)
{
    (void)state;
    const struct weft_camera camera = {WEFT_CAMERA_DEFAULTS.aspect = 1.0};
    const int square[2] = {100, 100}, tall[2] = {50, 100}, wide_size[2] = {200, 100};
    const double cot = 1.0 + M_SQRT2;
    // Of infinity the circle is aperture / focus; focused there, aperture / depth.
    assert_near(weft_camera_circle(&camera, square, 0.5, 5.0, INFINITY), 0.1 * 50.0 * cot, 1e-13,
                "infinity");
    assert_near(weft_camera_circle(&camera, square, 0.5, INFINITY, 10.0), 0.05 * 50.0 * cot, 1e-13,
                "focused at infinity");
    // Pixels that are not square: the larger diameter.
    assert_near(weft_camera_circle(&camera, tall, 0.5, 5.0, INFINITY), 0.1 * 50.0 * cot, 1e-13, "");
    assert_near(weft_camera_circle(&camera, wide_size, 0.5, 5.0, INFINITY), 0.1 * 100.0 * cot,
                1e-13, "");
    assert_int_equal(
        weft_frames_for_circle(weft_camera_circle(&camera, square, 0.5, 5.0, INFINITY)), 115);
    const double bad[][3] = {{-1.0, 5.0, 5.0}, {NAN, 5.0, 5.0}, {1.0, 0.0, 5.0},
                             {1.0, 5.0, -1.0}, {1.0, 5.0, NAN}, {1.0, NAN, 5.0}};
    for (size_t i = 0; i < WEFT_COUNT(bad); i++)
        assert_true(isnan(weft_camera_circle(&camera, square, bad[i][0], bad[i][1], bad[i][2])));
    const int none[2] = {0, 5};
    assert_true(isnan(weft_camera_circle(&camera, none, 1.0, 5.0, 6.0)));
    assert_true(isnan(
        weft_camera_circle(&(struct weft_camera){.fovy_degrees = 45.0}, square, 1.0, 5.0, 6.0)));
}

// ---- what is refused
// ------------------------------------------------------------------------------

static void refused(const struct weft_camera *camera, const struct weft_camera_frame *frame,
                    const char *expected)
{
    struct weft_camera_matrices m;
    last.count = 0;
    assert_int_equal(weft_camera_compute(&remember_log, camera, frame, &m), WEFT_ERR_ARGUMENT);
    assert_int_equal(last.count, 1);
    assert_true(isnan(m.clip[0]) && isnan(m.view_float[15]));
    if (!strstr(last.text, expected))
        fail_msg("'%s' lacks '%s'", last.text, expected);
}

static void test_refused(void **state)
{
    (void)state;
    const struct weft_camera good = {WEFT_CAMERA_DEFAULTS};
    const struct weft_camera_frame frame = {.size = {10, 10}};
#define CAMERA(expected, ...)                                                                      \
    refused(&(struct weft_camera){WEFT_CAMERA_DEFAULTS __VA_ARGS__}, &frame, expected)
    CAMERA("fovy is 0", .fovy_degrees = 0.0);
    CAMERA("fovy is 180", .fovy_degrees = 180.0);
    CAMERA("fovy is nan", .fovy_degrees = NAN);
    CAMERA("aspect is -1", .aspect = -1.0);
    CAMERA("near_distance is 0", .near_distance = 0.0);
    CAMERA("far_distance is 1", .far_distance = 1.0);
    CAMERA("far_distance is inf", .far_distance = INFINITY);
    CAMERA("from eye to target is 0", .target = {0.0, 0.0, 0.0});
    CAMERA("length of up is 0", .up = {0.0, 0.0, 0.0});
    CAMERA("sine", .up = {0.0, 0.0, 3.0});
    CAMERA("must be finite", .eye = {NAN, 0.0, 0.0});
#undef CAMERA
#define FRAME(expected, ...)                                                                       \
    refused(&good, &(struct weft_camera_frame){.size = {10, 10}, __VA_ARGS__}, expected)
    FRAME("size in pixels is 0", .size = {10, 0});
    FRAME("move is nan", .move = {NAN, 0.0});
    FRAME("lens is inf", .lens = {0.0, INFINITY});
    FRAME("focus is 0", .lens = {0.1, 0.0});
    FRAME("focus is -2", .lens = {0.1, 0.0}, .focus = -2.0);
#undef FRAME
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_against_the_guide),
        cmocka_unit_test(test_by_hand),
        cmocka_unit_test(test_focus),
        cmocka_unit_test(test_move),
        cmocka_unit_test(test_signs),
        cmocka_unit_test(test_circles),
        cmocka_unit_test(test_circle_ends),
        cmocka_unit_test(test_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
