// SPDX-License-Identifier: BSD-3-Clause
// Exact pictures: against areas of half-planes and polygons by formulas, and against many samples.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "tools/common/random.h"
#include "tools/scene/build.h"
#include "tools/scene/exact.h"

// ---- scenes by pixels ---------------------------------------------------------------------------

// A scene whose picture has size x size pixels; the camera sees 1 to each side at a depth of 1.
struct flat {
    struct scene scene;
    struct scene_build build;
    int size;
};

static void begin(struct flat *flat, int size)
{
    memset(flat, 0, sizeof *flat);
    flat->build.scene = &flat->scene;
    flat->size = size;
    flat->scene.camera =
        *weft_camera(.fovy_degrees = 90.0, .near_distance = 0.25, .far_distance = 8.0);
}

// A triangle of one colour by the places of its corners in pixels, and their depths; an object of
// its own. Corners are rounded to floats: they are written back.
static void add(struct flat *flat, double corner[3][3], const float colour[3], bool single_sided)
{
    double modelled[3][3];
    const struct scene_material material = {.reflectance = {colour[0], colour[1], colour[2]},
                                            .unlit = true,
                                            .single_sided = single_sided};
    for (int i = 0; i < 3; i++) {
        const float depth = (float)corner[i][2];
        corner[i][2] = depth;
        modelled[i][2] = -corner[i][2];
        for (int k = 0; k < 2; k++) {
            // volatile: GCC 12 drops the rounding of pairs of numbers at -O2.
            const volatile float at = (float)((2.0 * corner[i][k] / flat->size - 1.0) * depth);
            modelled[i][k] = at;
            corner[i][k] = 0.5 * flat->size * (1.0 + modelled[i][k] / depth);
        }
    }
    scene_build_object(&flat->build, "", scene_build_material(&flat->build, &material));
    scene_build_polygon(&flat->build, 3, (const double(*)[3])modelled, NULL, NULL);
}

static const float WHITE[3] = {1.0f, 1.0f, 1.0f};

// The picture; ends the scene.
static double *draw_with(struct flat *flat, struct weft_kernel filter, double width, double *error)
{
    double *out = malloc(4 * (size_t)(flat->size * flat->size) * sizeof *out);
    assert_non_null(out);
    assert_int_equal(scene_build_end(&flat->build, &log_to_stderr), WEFT_OK);
    assert_int_equal(
        scene_exact_draw(scene_exact_params(.scene = &flat->scene, .size = {flat->size, flat->size},
                                            .filter = filter, .filter_width = width,
                                            .log = &log_to_stderr),
                         out, error),
        WEFT_OK);
    scene_clear(&flat->scene);
    return out;
}

static double *draw(struct flat *flat)
{
    double error;
    double *out = draw_with(flat, (struct weft_kernel){0}, 0.0, &error);
    assert_true(error >= 0.0 && error < 1e-10);
    return out;
}

// ---- half-planes --------------------------------------------------------------------------------

// A triangle that is half a plane as far as the picture and its filters reach: an edge through
// (x, y), the inside being where the angle's direction points away from. normal: to the outside.
static void add_half(struct flat *flat, double x, double y, double angle, double normal[2],
                     double point[2])
{
    const double n[2] = {cos(angle), sin(angle)}, reach = 100.0;
    double corner[3][3] = {{x + reach * n[1], y - reach * n[0], 1.0},
                           {x - reach * n[1], y + reach * n[0], 1.0},
                           {x - reach * n[0], y - reach * n[1], 1.0}};
    add(flat, corner, WHITE, false);
    normal[0] = corner[1][1] - corner[0][1];
    normal[1] = corner[0][0] - corner[1][0];
    point[0] = corner[0][0];
    point[1] = corner[0][1];
}

static double find_distance(const double normal[2], const double point[2], double x, double y)
{
    return (normal[0] * (point[0] - x) + normal[1] * (point[1] - y)) / hypot(normal[0], normal[1]);
}

enum { HALF = 6, ANGLES = 144 };

static void test_square(void **state)
{
    (void)state;
    int mixed = 0;
    for (int i = 0; i < ANGLES; i++) {
        struct flat flat;
        double normal[2], point[2];
        begin(&flat, HALF);
        add_half(&flat, 2.5 + 0.01 * i, 3.1 - 0.007 * i, 2.0 * M_PI * i / ANGLES, normal, point);
        double *picture = draw(&flat);
        for (int k = 0; k < HALF * HALF; k++) {
            const double d = find_distance(normal, point, k % HALF + 0.5, k / HALF + 0.5);
            const double wanted = weft_edge_square(normal, d);
            assert_near(picture[4 * k + 3], wanted, 1e-12, "alpha");
            assert_near(picture[4 * k], wanted, 1e-12, "red");
            mixed += wanted > 0.0 && wanted < 1.0;
        }
        free(picture);
    }
    assert_true(mixed > 5 * ANGLES);
}

// Kernels of all kinds, at their own and at other widths.
static void test_kernels(void **state)
{
    (void)state;
    static const struct {
        const char *kernel;
        double width;
    } list[] = {
        {"nearest", 1.7},  {"linear", 0.0},      {"bspline3", 0.0},  {"mitchell", 0.0},
        {"mitchell", 3.1}, {"catmull-rom", 0.0}, {"lanczos:3", 0.0}, {"lanczos:2+unit", 0.0},
        {"gaussian", 0.0}, {"gaussian", 2.6},    {"bspline5", 0.0},
    };
    for (size_t i = 0; i < sizeof list / sizeof *list; i++)
        for (int turn = 0; turn < 7; turn++) {
            const struct weft_kernel kernel = kernel_named(list[i].kernel);
            struct flat flat;
            double normal[2], point[2], error;
            begin(&flat, HALF);
            add_half(&flat, 2.7, 3.2, M_PI * turn / 3.5 + (turn == 3 ? 0.0 : 0.13 * turn), normal,
                     point);
            double *picture = draw_with(&flat, kernel, list[i].width, &error);
            assert_true(error > 0.0 && error < 1e-9);
            for (int k = 0; k < HALF * HALF; k += turn ? 5 : 1) {
                struct weft_edge_value wanted;
                const double d = find_distance(normal, point, k % HALF + 0.5, k / HALF + 0.5);
                assert_int_equal(
                    weft_edge_kernel(&log_to_stderr, &kernel, list[i].width, normal, d, &wanted),
                    WEFT_OK);
                assert_near(picture[4 * k + 1], wanted.value, 1e-12 + error + wanted.error,
                            list[i].kernel);
            }
            free(picture);
        }
}

// ---- polygons -----------------------------------------------------------------------------------

static double between(uint64_t *random, double low, double high)
{
    return low + (high - low) * random_unit(random);
}

static double find_area(double corner[3][3])
{
    return 0.5 * fabs((corner[1][0] - corner[0][0]) * (corner[2][1] - corner[0][1]) -
                      (corner[1][1] - corner[0][1]) * (corner[2][0] - corner[0][0]));
}

static double sum_alpha(const double *picture, int size)
{
    double sum = 0.0;
    for (int i = 0; i < size * size; i++)
        sum += picture[4 * i + 3];
    return sum;
}

// Discs of many corners, about a point of the picture: their triangles' areas add up, and nothing
// is left open where these meet, nor counted twice.
static void test_discs(void **state)
{
    (void)state;
    static const int corners[] = {3, 5, 16, 200};
    for (int i = 0; i < 4; i++) {
        enum { SIZE = 20 };
        const int n = corners[i];
        struct flat flat;
        double area = 0.0;
        begin(&flat, SIZE);
        for (int k = 0; k < n; k++) {
            const double a = 2.0 * M_PI * k / n, b = 2.0 * M_PI * ((k + 1) % n) / n;
            double corner[3][3] = {{9.6, 10.3, 2.0},
                                   {9.6 + 8.5 * cos(a), 10.3 + 8.5 * sin(a), 2.0},
                                   {9.6 + 8.5 * cos(b), 10.3 + 8.5 * sin(b), 2.0}};
            add(&flat, corner, WHITE, true);
            area += find_area(corner);
        }
        assert_near(area, 0.5 * n * 8.5 * 8.5 * sin(2.0 * M_PI / n), 1e-4, "corners");
        double *picture = draw(&flat);
        assert_near(sum_alpha(picture, SIZE), area, 1e-11, "area");
        assert_near(picture[4 * (10 * SIZE + 9) + 3], 1.0, 1e-13, "middle");
        free(picture);
    }
}

// Slivers of 1/100 down to 1/100,000,000 of a pixel, each alone.
static void test_thin(void **state)
{
    (void)state;
    uint64_t random = 7;
    for (int i = 0; i < 40; i++) {
        enum { SIZE = 12 };
        const double width = pow(10.0, -2.0 - i % 7), angle = between(&random, 0.0, 7.0);
        struct flat flat;
        begin(&flat, SIZE);
        double corner[3][3] = {{6.0 - 5.0 * cos(angle), 6.0 - 5.0 * sin(angle), 1.5},
                               {6.0 + 5.0 * cos(angle), 6.0 + 5.0 * sin(angle), 2.0},
                               {6.0 - width * sin(angle), 6.0 + width * cos(angle), 3.0}};
        add(&flat, corner, WHITE, false);
        double *picture = draw(&flat);
        // Of the coordinates in pixels and in the scene.
        assert_near(sum_alpha(picture, SIZE), find_area(corner), 1e-13, "area");
        free(picture);
    }
}

enum { RANDOM = 8, TRIANGLES = 24 };

// Triangles that hide and cut one another; thin ones, too.
static void find_random(uint64_t *random, double corner[3][3], float colour[3])
{
    const double x = between(random, 0.0, RANDOM), y = between(random, 0.0, RANDOM);
    const double reach = between(random, 0.2, 6.0);
    for (int i = 0; i < 3; i++) {
        corner[i][0] = x + between(random, -reach, reach);
        corner[i][1] = y + between(random, -reach, reach);
        corner[i][2] = between(random, 1.0, 6.0);
        colour[i] = (float)random_unit(random);
    }
}

// All white, in front of white: whatever hides what, the picture is white.
static void test_whole(void **state)
{
    (void)state;
    uint64_t random = 1;
    for (int i = 0; i < 20; i++) {
        struct flat flat;
        double corner[3][3], error;
        float colour[3];
        begin(&flat, RANDOM);
        for (int k = 0; k < 4; k++)
            flat.scene.background[k] = 1.0;
        for (int t = 0; t < TRIANGLES; t++) {
            find_random(&random, corner, colour);
            add(&flat, corner, WHITE, t % 3 == 0);
        }
        double *picture =
            draw_with(&flat, kernel_named(i % 2 ? "nearest" : "catmull-rom"), 0.0, &error);
        for (int k = 0; k < 4 * RANDOM * RANDOM; k++)
            assert_near(picture[k], 1.0, 2e-13, "white");
        free(picture);
    }
}

// The order in which triangles come does not matter, but for those in one place.
static void test_order(void **state)
{
    (void)state;
    uint64_t random = 2;
    for (int i = 0; i < 10; i++) {
        double corner[TRIANGLES][3][3], *picture[2];
        float colour[TRIANGLES][3];
        for (int t = 0; t < TRIANGLES; t++)
            find_random(&random, corner[t], colour[t]);
        for (int turn = 0; turn < 2; turn++) {
            struct flat flat;
            begin(&flat, RANDOM);
            for (int t = 0; t < TRIANGLES; t++) {
                const int from = turn ? (5 * t + 3) % TRIANGLES : t;
                double copy[3][3];
                memcpy(copy, corner[from], sizeof copy);
                add(&flat, copy, colour[from], false);
            }
            picture[turn] = draw(&flat);
        }
        for (int k = 0; k < 4 * RANDOM * RANDOM; k++)
            assert_near(picture[1][k], picture[0][k], 1e-11, "component");
        free(picture[0]);
        free(picture[1]);
    }
    // In one place: the first.
    for (int turn = 0; turn < 2; turn++) {
        struct flat flat;
        double corner[3][3] = {{-30.0, -30.0, 2.0}, {60.0, -30.0, 3.0}, {4.0, 90.0, 5.0}};
        double same[3][3];
        const float red[3] = {1.0f, 0.0f, 0.0f}, blue[3] = {0.0f, 0.0f, 1.0f};
        begin(&flat, RANDOM);
        memcpy(same, corner, sizeof same);
        add(&flat, corner, turn ? red : blue, false);
        add(&flat, same, turn ? blue : red, false);
        double *picture = draw(&flat);
        for (int k = 0; k < RANDOM * RANDOM; k++)
            assert_near(picture[4 * k], turn, 1e-13, "red");
        free(picture);
    }
}

// ---- depth --------------------------------------------------------------------------------------

// 1 / depth of a triangle as a linear function of the place in the picture.
static void find_plane(double corner[3][3], double out[3])
{
    const double *a = corner[0], *b = corner[1], *c = corner[2];
    const double x[2] = {b[0] - a[0], c[0] - a[0]}, y[2] = {b[1] - a[1], c[1] - a[1]};
    const double d[2] = {1.0 / b[2] - 1.0 / a[2], 1.0 / c[2] - 1.0 / a[2]};
    const double all = x[0] * y[1] - x[1] * y[0];
    out[0] = (d[0] * y[1] - d[1] * y[0]) / all;
    out[1] = (d[1] * x[0] - d[0] * x[1]) / all;
    out[2] = 1.0 / a[2] - out[0] * a[0] - out[1] * a[1];
}

// Two triangles that fill the picture and go through one another: each is seen on one side of a
// line, whose coverage is exact.
static void test_crossing(void **state)
{
    (void)state;
    uint64_t random = 3;
    int mixed = 0;
    for (int i = 0; i < 60; i++) {
        const float colour[2][3] = {{1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}};
        double plane[2][3];
        struct flat flat;
        begin(&flat, RANDOM);
        const double x = between(&random, 2.0, 6.0), y = between(&random, 2.0, 6.0);
        for (int t = 0; t < 2; t++) {
            double corner[3][3] = {{-30.0, -30.0}, {60.0, -30.0}, {4.0, 90.0}};
            const double slope[2] = {between(&random, -2e-3, 2e-3), between(&random, -2e-3, 2e-3)};
            for (int k = 0; k < 3; k++)
                corner[k][2] =
                    1.0 / (0.5 + slope[0] * (corner[k][0] - x) + slope[1] * (corner[k][1] - y));
            add(&flat, corner, colour[t], false);
            find_plane(corner, plane[t]);
        }
        double *picture = draw(&flat);
        // The second is nearer where this is above 0.
        double line[3];
        for (int k = 0; k < 3; k++)
            line[k] = plane[1][k] - plane[0][k];
        const double length = hypot(line[0], line[1]), normal[2] = {-line[0], -line[1]};
        for (int k = 0; k < RANDOM * RANDOM; k++) {
            const double value =
                line[0] * (k % RANDOM + 0.5) + line[1] * (k / RANDOM + 0.5) + line[2];
            const double wanted = weft_edge_square(normal, value / length);
            assert_near(picture[4 * k + 1], wanted, 1e-9, "green");
            assert_near(picture[4 * k], 1.0 - wanted, 1e-9, "red");
            mixed += wanted > 0.01 && wanted < 0.99;
        }
        free(picture);
    }
    assert_true(mixed > 200);
}

// A ground that starts behind the eye is cut at the near plane, and at the far one.
static void test_cut(void **state)
{
    (void)state;
    enum { SIZE = 32 };
    const float height = -0.125f;
    static const double corner[4][3] = {{-100.0, height, 50.0},
                                        {100.0, height, 50.0},
                                        {100.0, height, -50.0},
                                        {-100.0, height, -50.0}};
    const struct scene_material material = {.reflectance = {1.0f, 1.0f, 1.0f}, .unlit = true};
    struct flat flat;
    begin(&flat, SIZE);
    scene_build_object(&flat.build, "", scene_build_material(&flat.build, &material));
    scene_build_polygon(&flat.build, 4, corner, NULL, NULL);
    double *picture = draw(&flat);
    // Seen from depth 1/4, 1/2 below the middle, to depth 8, 1/64 below.
    const double low = 0.5 * SIZE * (1.0 - 0.5), high = 0.5 * SIZE * (1.0 - 1.0 / 64.0);
    for (int k = 0; k < SIZE * SIZE; k++) {
        const double y = k / SIZE;
        const double wanted = fmax(fmin(high, y + 1.0) - fmax(low, y), 0.0);
        assert_near(picture[4 * k + 3], wanted, 1e-12, "ground");
    }
    free(picture);
}

// ---- many samples -------------------------------------------------------------------------------

enum { SAMPLES = 256, GRID = RANDOM * SAMPLES };

// Writes which triangle each sample shows, from 0 on; -1: none.
static void draw_samples(double corner[TRIANGLES][3][3], const bool *single_sided, int8_t *seen,
                         float *nearest)
{
    for (int i = 0; i < GRID * GRID; i++) {
        seen[i] = -1;
        nearest[i] = 0.0f;
    }
    for (int t = 0; t < TRIANGLES; t++) {
        double plane[3], edge[3][3];
        const double turn =
            (corner[t][1][0] - corner[t][0][0]) * (corner[t][2][1] - corner[t][0][1]) -
            (corner[t][1][1] - corner[t][0][1]) * (corner[t][2][0] - corner[t][0][0]);
        if (turn < 0.0 && single_sided[t])
            continue;
        find_plane(corner[t], plane);
        for (int e = 0; e < 3; e++) {
            const double *a = corner[t][e], *b = corner[t][(e + 1) % 3];
            edge[e][0] = (a[1] - b[1]) / turn;
            edge[e][1] = (b[0] - a[0]) / turn;
            edge[e][2] = -edge[e][0] * a[0] - edge[e][1] * a[1];
        }
        for (int i = 0; i < GRID * GRID; i++) {
            const double x = (i % GRID + 0.5) / SAMPLES, y = (i / GRID + 0.5) / SAMPLES;
            if (edge[0][0] * x + edge[0][1] * y + edge[0][2] < 0.0 ||
                edge[1][0] * x + edge[1][1] * y + edge[1][2] < 0.0 ||
                edge[2][0] * x + edge[2][1] * y + edge[2][2] < 0.0)
                continue;
            const float near = (float)(plane[0] * x + plane[1] * y + plane[2]);
            if (near > nearest[i]) {
                nearest[i] = near;
                seen[i] = (int8_t)t;
            }
        }
    }
}

// A row of samples is wrong about an edge by half a sample at most, along 1.41 of it: 0.0028 of a
// pixel an edge in the worst case, and several pass a pixel.
static void test_samples(void **state)
{
    (void)state;
    int8_t *seen = malloc((size_t)GRID * GRID);
    float *nearest = malloc(sizeof *nearest * GRID * GRID);
    uint64_t random = 4;
    assert_true(seen && nearest);
    for (int i = 0; i < 3; i++) {
        double corner[TRIANGLES][3][3], square = 0.0;
        float colour[TRIANGLES][3];
        bool single_sided[TRIANGLES];
        struct flat flat;
        begin(&flat, RANDOM);
        for (int t = 0; t < TRIANGLES; t++) {
            single_sided[t] = t % 4 == 0;
            find_random(&random, corner[t], colour[t]);
            add(&flat, corner[t], colour[t], single_sided[t]);
        }
        double *picture = draw(&flat);
        draw_samples(corner, single_sided, seen, nearest);
        for (int k = 0; k < RANDOM * RANDOM; k++) {
            double sum[3] = {0.0};
            for (int s = 0; s < SAMPLES * SAMPLES; s++) {
                const int t = seen[(k / RANDOM * SAMPLES + s / SAMPLES) * GRID +
                                   k % RANDOM * SAMPLES + s % SAMPLES];
                for (int c = 0; c < 3 && t >= 0; c++)
                    sum[c] += colour[t][c];
            }
            for (int c = 0; c < 3; c++) {
                const double error = sum[c] / (SAMPLES * SAMPLES) - picture[4 * k + c];
                assert_near(error, 0.0, 2.0 * 0.0028, "sampled");
                square += error * error / (3.0 * RANDOM * RANDOM);
            }
        }
        assert_true(sqrt(square) < 5e-4);
        free(picture);
    }
    free(seen);
    free(nearest);
}

// ---- scenes -------------------------------------------------------------------------------------

// What moves is where it is at the time: the bar of `moving`, which is unlit and has upright edges.
static void test_time(void **state)
{
    (void)state;
    enum { SIZE = 40 };
    double width[3];
    for (int i = 0; i < 3; i++) {
        struct scene scene;
        double *out = malloc(sizeof *out * 4 * SIZE * SIZE), error, mean = 0.0, sum = 0.0;
        assert_non_null(out);
        assert_int_equal(scene_make(scene_params(.name = "moving", .size = {SIZE, SIZE}), &scene),
                         WEFT_OK);
        for (int m = 0; m < scene.material_count; m++) {
            for (int k = 0; k < 3; k++)
                scene.materials[m].reflectance[k] *= m == 0;
            scene.materials[m].unlit = true;
        }
        assert_int_equal(
            scene_exact_draw(scene_exact_params(.scene = &scene, .size = {SIZE, SIZE},
                                                .time = 0.5 * i, .log = &log_to_stderr),
                             out, &error),
            WEFT_OK);
        for (int k = 0; k < SIZE * SIZE; k++) {
            mean += (k % SIZE + 0.5) * out[4 * k];
            sum += out[4 * k];
        }
        width[i] = mean / sum;
        free(out);
        scene_clear(&scene);
    }
    // 0.48 in all, at depths of 4.95 to 5.05.
    const double pixel = 0.48 * 0.5 * SIZE / (5.0 * tan(M_PI / 9.0));
    assert_near(width[2] - width[0], pixel, 0.03 * pixel, "way");
    assert_near(width[1], 0.5 * SIZE, 1e-6, "middle");
}

static bool stop(void *priv, double fraction)
{
    (void)fraction;
    return ++*(int *)priv < 3;
}

static void test_refused(void **state)
{
    (void)state;
    static const struct {
        const char *scene, *kernel;
        double width;
        enum weft_result result;
    } list[] = {
        {"cornell", "nearest", 0.0, WEFT_ERR_UNSUPPORTED},
        {"cube", "nearest", 0.0, WEFT_ERR_UNSUPPORTED}, // colours of corners
        {"plane", "nearest", 0.0, WEFT_ERR_UNSUPPORTED},
        {"polygons:9", "linear+radial", 0.0, WEFT_ERR_UNSUPPORTED},
        {"polygons:9", "bspline3i", 0.0, WEFT_ERR_UNSUPPORTED},
        {"polygons:9", "d-linear", 0.0, WEFT_ERR_ARGUMENT},
        {"polygons:9", "linear", -1.0, WEFT_ERR_ARGUMENT},
        {"polygons:9", "linear", NAN, WEFT_ERR_ARGUMENT},
        {"polygons:9", "linear", 17.0, WEFT_ERR_ARGUMENT},
    };
    for (size_t i = 0; i < sizeof list / sizeof *list; i++) {
        struct message message = {.count = 0};
        const struct weft_log log = {keep_message, &message};
        struct scene scene;
        double out[4 * 4], error;
        assert_int_equal(scene_make(scene_params(.name = list[i].scene, .size = {2, 2}), &scene),
                         WEFT_OK);
        assert_int_equal(
            scene_exact_draw(scene_exact_params(.scene = &scene, .size = {2, 2},
                                                .filter = kernel_named(list[i].kernel),
                                                .filter_width = list[i].width, .log = &log),
                             out, &error),
            list[i].result);
        assert_int_equal(message.count, 1);
        scene_clear(&scene);
    }
    struct scene scene;
    double out[4 * 8 * 8], error;
    int count = 0;
    const struct weft_progress progress = {stop, &count};
    assert_int_equal(scene_make(scene_params(.name = "polygons:9", .size = {8, 8}), &scene),
                     WEFT_OK);
    assert_int_equal(
        scene_exact_draw(scene_exact_params(.scene = &scene, .size = {8, 8}, .progress = &progress),
                         out, &error),
        WEFT_ERR_CANCELLED);
    assert_int_equal(count, 3);
    scene_clear(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_square),   cmocka_unit_test(test_kernels),
        cmocka_unit_test(test_discs),    cmocka_unit_test(test_thin),
        cmocka_unit_test(test_whole),    cmocka_unit_test(test_order),
        cmocka_unit_test(test_crossing), cmocka_unit_test(test_cut),
        cmocka_unit_test(test_samples),  cmocka_unit_test(test_time),
        cmocka_unit_test(test_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
