// SPDX-License-Identifier: BSD-3-Clause
// One call for a slice, or for points, against the calls that it stands for: the same bits, of
// volumes in memory and of a file, by the CPU engine and by OpenGL. Where pixels lie against boxes
// worked out by hand, and gradients against a field whose gradient is known. What is refused.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "tests/support/files.h"
#include "weft.h"

enum { SIDE = 512, NX = 20, NY = 12, NZ = 9, POINTS = 500 };

static float pixels[SIDE * SIDE], expected[SIDE * SIDE];
static weft_volume *turned; // in world space turned and stretched
static const double to_world[3][4] = {
    {0.4, 0.3, 0.0, -1.0}, {-0.3, 0.4, 0.0, 2.5}, {0, 0.1, 0.7, 3}};

static const double slope[3] = {2.0, -3.0, 0.5};

// A linear field of world space: catmull-rom and its slope reconstruct it.
static float field(int x, int y, int z)
{
    double value = 1.0;
    for (int r = 0; r < 3; r++)
        value += slope[r] *
                 (to_world[r][0] * x + to_world[r][1] * y + to_world[r][2] * z + to_world[r][3]);
    return (float)value;
}

static int set_up(void **state)
{
    static float data[NX * NY * NZ];
    for (int i = 0; i < NX * NY * NZ; i++)
        data[i] = field(i % NX, i / NX % NY, i / (NX * NY));
    struct weft_volume_params params = {
        .size = {NX, NY, NZ}, .data = data, .background = NAN, .name = "ramp", .log = &test_log};
    memcpy(params.index_to_world, to_world, sizeof to_world);
    return test_enter_folder(state) || weft_volume_create(&params, &turned) != WEFT_OK;
}

// Bricks with bits of their own.
static weft_volume *make_bricks(void)
{
    enum { BRICKS = 4 };
    static const int32_t origin[BRICKS][3] = {{0, 0, 0}, {8, 0, 0}, {0, 8, 8}, {-8, 0, 8}};
    static float values[BRICKS * WEFT_BRICK_VOXELS];
    uint32_t seed = 7;
    for (size_t i = 0; i < WEFT_BRICK_VOXELS * BRICKS; i++) {
        seed = seed * 1664525u + 1013904223u;
        values[i] = (float)(seed >> 8) * 0x1p-24f;
    }
    weft_volume *volume = NULL;
    assert_int_equal(weft_volume_create_bricks(
                         weft_volume_bricks_params(.brick_count = BRICKS, .brick_origin = origin,
                                                   .brick_values = values, .name = "noise"),
                         &volume),
                     WEFT_OK);
    return volume;
}

// ---- the long way -------------------------------------------------------------------------------

static void slice_long(weft_volume *volume, const char *kernel, enum weft_space space,
                       const struct weft_slice_geometry *geometry, weft_context *context)
{
    struct weft_slice_params params = {.space = space, .geometry = *geometry};
    weft_slice_plan *plan = NULL;
    weft_slice *slice = NULL;
    params.engine = context ? WEFT_ENGINE_GL : WEFT_ENGINE_CPU;
    assert_int_equal(weft_kernel_parse(NULL, kernel, &params.kernel), WEFT_OK);
    assert_int_equal(weft_slice_plan_create(volume, &params, &plan), WEFT_OK);
    if (context && !weft_context_get_info(context)->hardware &&
        weft_choose_engine(&weft_cost_default, plan, 0) == WEFT_ENGINE_CPU) {
        weft_slice_plan_destroy(&plan);
        slice_long(volume, kernel, space, geometry, NULL);
        return;
    }
    assert_int_equal(
        weft_slice_compile(plan, weft_slice_compile_params(.context = context), &slice), WEFT_OK);
    assert_int_equal(weft_slice_run(slice, weft_slice_run_params(.pixels = expected), NULL),
                     WEFT_OK);
    weft_slice_destroy(&slice);
    weft_slice_plan_destroy(&plan);
}

static void assert_pixels(size_t count)
{
    assert_memory_equal(pixels, expected, count * sizeof *pixels);
    memset(pixels, 0xa5, sizeof pixels);
}

// ---- slices -------------------------------------------------------------------------------------

// 20 x 12 x 9 voxels: the box of the active ones, half a voxel around, is widened to a square.
static void all_zero_is_a_slice(void **state)
{
    weft_volume *plain = NULL;
    static float data[NX * NY * NZ];
    (void)state;
    for (int i = 0; i < NX * NY * NZ; i++)
        data[i] = sinf((float)i);
    assert_int_equal(
        weft_volume_create(weft_volume_params(.size = {NX, NY, NZ}, .data = data), &plain),
        WEFT_OK);
    const struct weft_slice_geometry across_z = {.origin = {-0.5, 0.5 * (NY - 1) - 0.5 * NX, 4.0},
                                                 .u = {NX, 0.0, 0.0},
                                                 .v = {0.0, NX, 0.0},
                                                 .width = SIDE,
                                                 .height = SIDE};
    slice_long(plain, "catmull-rom", WEFT_SPACE_WORLD, &across_z, NULL);
    assert_int_equal(weft_slice_volume(plain, NULL, pixels), WEFT_OK);
    assert_pixels(SIDE * SIDE);
    const struct weft_slice_file_params none = {0};
    assert_int_equal(weft_slice_volume(plain, &none, pixels), WEFT_OK);
    assert_pixels(SIDE * SIDE);

    // Across y at 3, 64 x 16 pixels: z, 9 voxels high, takes 16 pixels of 9 / 16, and x is widened.
    const double at = 3.0, wide = 64.0 * 9.0 / 16.0;
    const struct weft_slice_geometry across_y = {
        .origin = {9.5 - 0.5 * wide, 3.0, -0.5}, .u = {wide, 0, 0}, .v = {0, 0, NZ}, 64, 16};
    slice_long(plain, "mitchell", WEFT_SPACE_INDEX, &across_y, NULL);
    assert_int_equal(weft_slice_volume(plain,
                                       weft_slice_file_params(.kernel = "mitchell", .axis = 'y',
                                                              .at = &at, .width = 64, .height = 16,
                                                              .space = WEFT_SPACE_INDEX),
                                       pixels),
                     WEFT_OK);
    assert_pixels(64 * 16);
    weft_volume_destroy(&plain);
}

static void boxes_and_planes(void **state)
{
    static const char *const kernels[] = {"catmull-rom", "bspline3i", "lanczos:3+unit", "nearest"};
    (void)state;
    for (int i = 0; i < 3 * 4; i++) {
        struct weft_slice_geometry g;
        const enum weft_space space = i & 1 ? WEFT_SPACE_INDEX : WEFT_SPACE_WORLD;
        assert_int_equal(weft_slice_axis_geometry(NULL, turned, space, i % 3, NAN, 40, 30, &g),
                         WEFT_OK);
        slice_long(turned, kernels[i / 3], space, &g, NULL);
        struct weft_slice_file_params p = {.kernel = kernels[i / 3],
                                           .axis = (char)('x' + i % 3),
                                           .fill = true,
                                           .space = space,
                                           .width = 40,
                                           .height = 30};
        assert_int_equal(weft_slice_volume(turned, &p, pixels), WEFT_OK);
        assert_pixels(40 * 30);
        p = (struct weft_slice_file_params){.kernel = kernels[i / 3],
                                            .space = space,
                                            .origin = {1.0, 2.0, 3.0},
                                            .u = {4.0, 1.0, 0.0},
                                            .v = {0.0, 2.0, 3.0},
                                            .width = 33,
                                            .stride = 50};
        g = (struct weft_slice_geometry){{1, 2, 3}, {4, 1, 0}, {0, 2, 3}, 33, 33};
        slice_long(turned, kernels[i / 3], space, &g, NULL);
        assert_int_equal(weft_slice_volume(turned, &p, pixels), WEFT_OK);
        for (size_t y = 0; y < 33; y++)
            assert_memory_equal(pixels + 50 * y, expected + 33 * y, 33 * sizeof *pixels);
    }
}

static bool count_progress(void *priv, double fraction)
{
    double *last = priv;
    const bool grows = fraction >= last[0] && fraction <= 1.0;
    last[0] = grows ? fraction : 2.0;
    return last[1]-- > 0.0;
}

static void a_file_is_opened(void **state)
{
    weft_volume *noise = make_bricks(), *opened = NULL;
    const char *path = test_path("noise.vdb");
    double at = 2.25, last[2] = {0.0, 1e9};
    struct weft_slice_geometry g;
    (void)state;
    assert_int_equal(weft_volume_save(noise, weft_volume_save_params(.path = path)), WEFT_OK);
    assert_int_equal(weft_volume_open(weft_volume_open_params(.path = path), &opened), WEFT_OK);
    assert_int_equal(weft_slice_axis_geometry(NULL, opened, WEFT_SPACE_WORLD, 0, at, 70, 70, &g),
                     WEFT_OK); // y and z are 16 voxels each
    slice_long(opened, "bspline", WEFT_SPACE_WORLD, &g, NULL);
    const struct weft_progress progress = {count_progress, last};
    struct weft_slice_file_params p = {.kernel = "bspline",
                                       .axis = 'x',
                                       .at = &at,
                                       .width = 70,
                                       .progress = &progress,
                                       .log = &test_log};
    assert_int_equal(weft_slice_file(path, &p, pixels), WEFT_OK);
    assert_pixels(70 * 70);
    assert_true(last[0] == 1.0);
    p.grid = "noise";
    assert_int_equal(weft_slice_file(path, &p, pixels), WEFT_OK);
    assert_pixels(70 * 70);
    last[0] = last[1] = 0.0;
    assert_int_equal(weft_slice_file(path, &p, pixels), WEFT_ERR_CANCELLED);

    float of_file[2], of_volume[2];
    const double points[2][3] = {{1.25, 2.5, 3.0}, {9.0, 9.0, 9.0}};
    assert_int_equal(weft_sample_file(path, NULL, 2, points, of_file, NULL), WEFT_OK);
    assert_int_equal(weft_sample(noise, NULL, 2, points, of_volume, NULL), WEFT_OK);
    assert_memory_equal(of_file, of_volume, sizeof of_file);
    weft_volume_destroy(&opened);
    weft_volume_destroy(&noise);
}

static void either_engine(void **state)
{
    weft_context *context = NULL;
    struct weft_slice_geometry g;
    (void)state;
    if (weft_context_create(weft_context_params(), &context) != WEFT_OK)
        skip();
    for (int size = 8; size <= SIDE; size *= 8) { // of which the model has either engine faster
        assert_int_equal(
            weft_slice_axis_geometry(NULL, turned, WEFT_SPACE_INDEX, 2, 4.5, size, size, &g),
            WEFT_OK);
        slice_long(turned, "catmull-rom", WEFT_SPACE_INDEX, &g, context);
        assert_int_equal(
            weft_slice_volume(turned,
                              weft_slice_file_params(.at = &(double){4.5}, .width = size,
                                                     .fill = true, .space = WEFT_SPACE_INDEX,
                                                     .context = context),
                              pixels),
            WEFT_OK);
        assert_pixels((size_t)size * (size_t)size);
    }
    weft_context_destroy(&context);
}

// ---- points -------------------------------------------------------------------------------------

static void points_and_gradients(void **state)
{
    static double position[POINTS][3];
    static float value[POINTS], alone[POINTS], gradient[POINTS][3], planes[4 * POINTS];
    static const struct weft_derivative derivative[] = {
        {{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}};
    (void)state;
    for (int i = 0; i < POINTS; i++) {
        // Three voxels from the edge, where the field is linear all around.
        const double at[3] = {3.0 + 13.0 * i / POINTS, 3.0 + fmod(0.37 * i, 5.0),
                              3.0 + fmod(0.71 * i, 2.0)};
        for (int r = 0; r < 3; r++)
            position[i][r] = to_world[r][0] * at[0] + to_world[r][1] * at[1] +
                             to_world[r][2] * at[2] + to_world[r][3];
    }
    position[POINTS - 1][1] = NAN;
    assert_int_equal(weft_sample(turned, NULL, POINTS, position, alone, NULL), WEFT_OK);
    assert_int_equal(weft_sample(turned, NULL, POINTS, position, value, gradient), WEFT_OK);
    for (int i = 0; i < POINTS - 1; i++) {
        double exact = 1.0;
        for (int r = 0; r < 3; r++)
            exact += slope[r] * position[i][r];
        // Values reach 30, rounded to float once in voxels and in sums of 64 products.
        assert_float_equal(value[i], exact, 1e-4);
        assert_float_equal(alone[i], exact, 1e-4);
        for (int r = 0; r < 3; r++) // gradients are of differences of them, by A^-T (below 4)
            assert_float_equal(gradient[i][r], slope[r], 2e-3);
    }
    assert_true(isnan(value[POINTS - 1]) && isnan(alone[POINTS - 1]) &&
                isnan(gradient[POINTS - 1][0]));

    weft_points *points = NULL;
    struct weft_quantity_transform transform;
    struct weft_quantities list;
    assert_int_equal(
        weft_points_create(
            weft_points_params(.volume = turned, .derivative = derivative, .derivative_count = 4),
            &points),
        WEFT_OK);
    assert_int_equal(weft_points_run(points,
                                     weft_points_run_params(.count = POINTS, .position = position,
                                                            .out = planes),
                                     NULL),
                     WEFT_OK);
    assert_int_equal(weft_quantity_transform_create(NULL, to_world, &transform), WEFT_OK);
    assert_int_equal(weft_quantities_parse(NULL, "gradient", &list), WEFT_OK);
    assert_memory_equal(value, planes, sizeof value);
    for (int i = 0; i < POINTS - 1; i++) {
        double d[3], channel[3];
        for (int a = 0; a < 3; a++)
            d[a] = (double)planes[(a + 1) * POINTS + i];
        weft_quantities_compute(&list, &transform, d, channel);
        for (int a = 0; a < 3; a++)
            assert_true(gradient[i][a] == (float)channel[a]);
    }
    weft_points_destroy(&points);
}

// ---- what is refused ----------------------------------------------------------------------------

static void refused(const struct weft_slice_file_params *params, enum weft_result expected_result,
                    const char *word)
{
    struct weft_slice_file_params p = *params;
    test_forget();
    p.log = &test_log;
    assert_int_equal(weft_slice_volume(turned, &p, pixels), expected_result);
    assert_int_equal(test_errors, 1);
    if (!strstr(test_message, word))
        fail_msg("no \"%s\" in: %s", word, test_message);
}

static void bad_requests(void **state)
{
    const double at = NAN, there = 1.0;
    const enum weft_result bad = WEFT_ERR_ARGUMENT;
    (void)state;
    refused(weft_slice_file_params(.kernel = "catmul-rom"), bad, "catmull-rom");
    refused(weft_slice_file_params(.kernel = "linear+radial"), WEFT_ERR_UNSUPPORTED, "radial");
    refused(weft_slice_file_params(.axis = 'w'), bad, ".axis is 119 ('w')");
    refused(weft_slice_file_params(.axis = 2), bad, ".axis is 2");
    refused(weft_slice_file_params(.at = &at), bad, ".at is");
    refused(weft_slice_file_params(.width = -4), bad, "-4 x 0 pixels");
    refused(weft_slice_file_params(.u = {1, 0, 0}), bad, "span no plane");
    refused(weft_slice_file_params(.u = {1, 0, 0}, .v = {2, 0, 0}), bad, "");
    refused(weft_slice_file_params(.u = {1, 0, 0}, .v = {0, 1, 0}, .at = &there), bad, "exclude");
    refused(weft_slice_file_params(.origin = {1, 0, 0}), bad, "span no plane");
    refused(weft_slice_file_params(.space = (enum weft_space)7), bad, "space is 7");
    refused(weft_slice_file_params(.stride = 5), bad, "stride");
    refused(weft_slice_file_params(.cpu = {.threads = -1}), bad, "threads");
    refused(weft_slice_file_params(.grid = "density"), bad, "grid");
    test_forget();
    const struct weft_slice_file_params logged = {.log = &test_log};
    assert_int_equal(weft_slice_file(test_path("none.vdb"), &logged, pixels), WEFT_ERR_OPEN);
    assert_int_equal(weft_slice_file(NULL, &logged, pixels), bad);
    assert_int_equal(weft_slice_volume(turned, &logged, NULL), bad);
    assert_int_equal(test_errors, 3);
    assert_int_equal(weft_slice_file(test_path("none.vdb"), NULL, pixels), WEFT_ERR_OPEN);
}

static void bad_points(void **state)
{
    const double position[1][3] = {{0}};
    float value[1], gradient[1][3];
    struct weft_sample_params p = {.log = &test_log, .kernel = "nearest"};
    (void)state;
    test_forget();
    assert_int_equal(weft_sample(turned, &p, 1, position, value, gradient), WEFT_ERR_UNSUPPORTED);
    p.kernel = "nearrest";
    assert_int_equal(weft_sample(turned, &p, 1, position, value, NULL), WEFT_ERR_ARGUMENT);
    assert_non_null(strstr(test_message, "nearest"));
    p.kernel = NULL;
    assert_int_equal(weft_sample(turned, &p, 1, NULL, value, NULL), WEFT_ERR_ARGUMENT);
    assert_int_equal(weft_sample(turned, &p, 1, position, NULL, NULL), WEFT_ERR_ARGUMENT);
    assert_int_equal(weft_sample_file(test_path("none.vdb"), &p, 1, position, value, NULL),
                     WEFT_ERR_OPEN);
    p.grid = "ramp";
    assert_int_equal(weft_sample(turned, &p, 1, position, value, NULL), WEFT_ERR_ARGUMENT);
    assert_int_equal(test_errors, 6);
    assert_int_equal(weft_sample(turned, NULL, 0, NULL, NULL, NULL), WEFT_OK);
}

static int tear_down(void **state)
{
    weft_volume_destroy(&turned);
    return test_leave_folder(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_zero_is_a_slice),  cmocka_unit_test(boxes_and_planes),
        cmocka_unit_test(a_file_is_opened),     cmocka_unit_test(either_engine),
        cmocka_unit_test(points_and_gradients), cmocka_unit_test(bad_requests),
        cmocka_unit_test(bad_points),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
