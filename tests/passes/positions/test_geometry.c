// SPDX-License-Identifier: BSD-3-Clause
// Cuts within their plane: turned so that a direction is up, mirrored, and laid through boxes.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "passes/positions/geometry.h"

// Voxels of three sizes, and axes that are sheared: world = m index.
static const double sheared[3][4] = {{0.5, 0.25, 0, 3}, {0, 2, 0.5, -1}, {0, 0, 1.5, 7}};

static weft_volume *make_volume(const double (*transform)[4])
{
    static float data[4 * 6 * 10];
    struct weft_volume_params params = *weft_volume_params(.size = {4, 6, 10}, .data = data);
    weft_volume *volume = NULL;
    if (transform)
        memcpy(params.index_to_world, transform, sizeof params.index_to_world);
    assert_int_equal(weft_volume_create(&params, &volume), WEFT_OK);
    return volume;
}

static void to_world(enum weft_space space, const double in[3], double out[3])
{
    for (int r = 0; r < 3; r++)
        out[r] = space == WEFT_SPACE_WORLD
                     ? in[r]
                     : sheared[r][0] * in[0] + sheared[r][1] * in[1] + sheared[r][2] * in[2];
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Where the corner x, y (0 or 1) of a cut lies.
static void corner_of(const struct weft_slice_geometry *g, int x, int y, double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = g->origin[i] + x * g->u[i] + y * g->v[i];
}

static void assert_point(const double a[3], const double b[3])
{
    for (int i = 0; i < 3; i++)
        assert_near(a[i], b[i], 1e-12 * (1.0 + fabs(b[i])), "coordinate");
}

// The other axis grows to the right, and the cut is what it was.
static void axes_point_up(void **state)
{
    (void)state;
    weft_volume *volume = make_volume(sheared);
    int turned = 0;
    for (int axis = 0; axis < 3; axis++)
        for (int up = 0; up < 3; up++)
            for (int sign = -1; sign <= 1; sign += 2) {
                struct weft_slice_geometry was, g;
                double direction[3] = {0}, a[3], b[3];
                direction[up] = sign;
                direction[axis] += 5.0; // square to the plane: it does not count
                assert_int_equal(weft_slice_axis_geometry(NULL, volume, WEFT_SPACE_WORLD, axis, 1.0,
                                                          30, 20, &was),
                                 WEFT_OK);
                g = was;
                const enum weft_result res =
                    weft_slice_turn(NULL, volume, WEFT_SPACE_WORLD, direction, true, &g);
                assert_int_equal(res, up == axis ? WEFT_ERR_ARGUMENT : WEFT_OK);
                if (up == axis) {
                    assert_memory_equal(&g, &was, sizeof g);
                    continue;
                }
                turned++;
                const int right = 3 - axis - up;
                const bool swapped = up < right;
                assert_true(g.v[up] * sign < 0.0 && g.u[right] > 0.0);
                assert_true(g.v[right] == 0.0 && g.u[up] == 0.0);
                assert_int_equal(g.width, swapped ? 20 : 30);
                assert_int_equal(g.height, swapped ? 30 : 20);
                for (int x = 0; x < 2; x++)
                    for (int y = 0; y < 2; y++) {
                        const int row = sign > 0 ? 1 - y : y;
                        corner_of(&g, x, row, a);
                        corner_of(&was, swapped ? y : x, swapped ? x : y, b);
                        assert_point(a, b);
                    }
            }
    assert_int_equal(turned, 12);
    weft_volume_destroy(&volume);
}

// Any direction: rows and columns are square to each other, columns run against the direction's
// projection, and every side of the rectangle touches the picture that it holds.
static void any_direction_points_up(void **state)
{
    (void)state;
    static const double directions[][3] = {{1, 1, 0},  {1, 0.1, 0}, {-0.3, 1, 0.7},
                                           {2, -1, 5}, {-1, -3, 0}, {0.25, 2, 9}};
    weft_volume *volume = make_volume(sheared);
    for (int space = 0; space < 2; space++)
        for (size_t d = 0; d < sizeof directions / sizeof *directions; d++) {
            struct weft_slice_geometry was, g;
            double u[3], v[3], up[3], normal[3], edge[2][3];
            assert_int_equal(
                weft_slice_axis_geometry(NULL, volume, (enum weft_space)space, 2, 8.0, 0, 0, &was),
                WEFT_OK);
            g = was;
            assert_int_equal(
                weft_slice_turn(NULL, volume, (enum weft_space)space, directions[d], true, &g),
                WEFT_OK);
            assert_int_equal(g.width + g.height, 0);
            to_world((enum weft_space)space, g.u, u);
            to_world((enum weft_space)space, g.v, v);
            to_world((enum weft_space)space, directions[d], up);
            to_world((enum weft_space)space, was.u, edge[0]);
            to_world((enum weft_space)space, was.v, edge[1]);
            assert_near(dot(u, v), 0.0, 1e-12 * sqrt(dot(u, u) * dot(v, v)), "right angle");
            for (int i = 0; i < 3; i++)
                normal[i] = edge[0][(i + 1) % 3] * edge[1][(i + 2) % 3] -
                            edge[0][(i + 2) % 3] * edge[1][(i + 1) % 3];
            assert_near(dot(u, normal) / sqrt(dot(u, u) * dot(normal, normal)), 0.0, 1e-12,
                        "plane");
            assert_near(dot(u, up), 0.0, 1e-9, "sideways");
            assert_true(dot(v, up) < 0.0);
            // Corners of the picture from 0 to 1 along both sides, with both ends met.
            double low[2] = {9, 9}, high[2] = {-9, -9};
            for (int c = 0; c < 4; c++) {
                double at[3], from[3];
                corner_of(&was, c & 1, c >> 1, at);
                for (int i = 0; i < 3; i++)
                    at[i] -= g.origin[i];
                to_world((enum weft_space)space, at, from);
                const double s[2] = {dot(from, u) / dot(u, u), dot(from, v) / dot(v, v)};
                for (int i = 0; i < 2; i++) {
                    low[i] = fmin(low[i], s[i]);
                    high[i] = fmax(high[i], s[i]);
                }
            }
            for (int i = 0; i < 2; i++) {
                assert_near(low[i], 0.0, 1e-12, "first side");
                assert_near(high[i], 1.0, 1e-12, "last side");
            }
        }
    weft_volume_destroy(&volume);
}

static void given_edges_stay(void **state)
{
    (void)state;
    const struct weft_slice_geometry was = {
        .origin = {1, 2, 3}, .u = {4, 0, 3}, .v = {-1, 8, 1}, .width = 5, .height = 6};
    struct weft_slice_geometry g = was;
    weft_volume *volume = make_volume(NULL);
    assert_int_equal(
        weft_slice_turn(NULL, volume, WEFT_SPACE_WORLD, (double[]){0, 0, 1}, false, &g), WEFT_OK);
    assert_true(g.width == 6 && g.height == 5);
    assert_point(g.u, was.v);
    assert_point(g.v, (double[]){-4, 0, -3});
    assert_point(g.origin, (double[]){5, 2, 6});
    assert_int_equal(
        weft_slice_turn(NULL, volume, WEFT_SPACE_WORLD, (double[]){0, -1, 0}, false, &g), WEFT_OK);
    assert_point(g.u, (double[]){-4, 0, -3});
    assert_point(g.v, was.v);
    weft_slice_mirror(true, true, &g);
    assert_point(g.origin, (double[]){0, 10, 4});
    assert_point(g.u, was.u);
    assert_point(g.v, (double[]){1, -8, -1});
    weft_volume_destroy(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(axes_point_up),
        cmocka_unit_test(any_direction_points_up),
        cmocka_unit_test(given_edges_stay),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
