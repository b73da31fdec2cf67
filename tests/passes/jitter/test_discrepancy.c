// SPDX-License-Identifier: BSD-3-Clause
// Half-plane discrepancies: published values, closed forms, and every edge that can be the worst,
// each counted by itself.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "tests/passes/jitter/points.h"
#include "passes/jitter/discrepancy.h"
#include "passes/jitter/edge.h"

static struct weft_discrepancy discrepancy(points_of points, int count,
                                           enum weft_jitter_shape shape, double size)
{
    struct weft_discrepancy d;
    assert_int_equal(weft_discrepancy_compute(
                         weft_discrepancy_params(.points = points, .count = count, .shape = shape,
                                                 .size = size, .log = &log_to_stderr),
                         &d),
                     WEFT_OK);
    return d;
}

static double named(const char *text, bool centre)
{
    struct weft_jitter set = set_named(text, WEFT_JITTER_SQUARE, 1.0, centre);
    const double d = discrepancy((points_of)set.points, set.count, WEFT_JITTER_SQUARE, 1.0).value;
    weft_jitter_clear(&set);
    return d;
}

// Found by others by a fine search, three digits of each: of Sobol's and Hammersley's points when
// they are centred, of Halton's and R2's as they are.
static void test_published(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        bool centre;
        double value;
    } sets[] = {
        {"j2", false, 0.500},           {"j3", false, 0.390},
        {"j4", false, 0.270},           {"j8", false, 0.198},
        {"j15", false, 0.151},          {"j24", false, 0.107},
        {"j66", false, 0.0577},         {"msaa:2", false, 0.500},
        {"msaa:4", false, 0.309},       {"msaa:8", false, 0.227},
        {"msaa:16", false, 0.172},      {"sobol:16", true, 0.252},
        {"sobol:64", true, 0.102},      {"sobol:256", true, 0.055},
        {"hammersley:64", true, 0.066}, {"hammersley:256", true, 0.032},
        {"halton:64", false, 0.109},    {"halton:256", false, 0.032},
        {"r2:64", false, 0.081},        {"r2:256", false, 0.039},
        {"grid:16", false, 0.125},      {"grid:64", false, 0.0625},
        {"grid:256", false, 0.03125},
    };
    for (size_t i = 0; i < WEFT_COUNT(sets); i++) {
        const double digits = sets[i].value == 0.0577 ? 5e-5 + 1e-6 : 5e-4;
        assert_near(named(sets[i].name, sets[i].centre), sets[i].value, digits, sets[i].name);
    }
}

// In sixteenths of a pixel everything is a fraction of few digits: 158/512 of four multisamples.
static void test_fractions(void **state)
{
    (void)state;
    assert_near(named("msaa:1", false), 0.5, 1e-11, "one");
    assert_near(named("msaa:2", false), 0.5, 1e-11, "two");
    assert_near(named("msaa:4", false), 158.0 / 512.0, 1e-11, "four");
    assert_near(named("msaa:8", false), 116.0 / 512.0, 1e-11, "eight");
    assert_near(named("msaa:16", false), 88.0 / 512.0, 1e-11, "sixteen");
}

// A grid of k by k has k points on its diagonals: half of that is the error, and no more.
static void test_grids(void **state)
{
    (void)state;
    for (int k = 1; k <= 40; k += k < 12 ? 1 : 7) {
        char text[32];
        snprintf(text, sizeof text, "grid:%d", k * k);
        assert_near(named(text, false), 0.5 / k, 1e-11, text);
    }
}

// What keeps 1/n: sets of 4 points at most.
static void test_within_one_nth(void **state)
{
    (void)state;
    int kept = 0, not_kept = 0;
    for (int i = 0; weft_jitter_list[i]; i++)
        for (int n = 1; n <= 80; n++) {
            struct weft_jitter set;
            if (weft_jitter_create(weft_jitter_params(.info = weft_jitter_list[i], .count = n),
                                   &set) != WEFT_OK)
                continue;
            const double d = discrepancy((points_of)set.points, n, WEFT_JITTER_SQUARE, 1.0).value;
            const bool keeps = d * n <= 1.0 + 1e-9;
            assert_true(!keeps || n <= 4);
            assert_true(d * n >= 0.5 - 1e-9);
            kept += keeps && n > 1;
            not_kept += !keeps;
            weft_jitter_clear(&set);
        }
    // j2, msaa of 2, grids of 2, 3 and 4 among them.
    assert_true(kept >= 5 && not_kept > 400);
}

// ---- closed forms
// ---------------------------------------------------------------------------------

// One point: the least area that an edge through it cuts off is 2 (1/2 - |x|) (1/2 - |y|) of the
// square and the segment across its radius of the disc; outside either all that is missed is 1.
static void test_one_point(void **state)
{
    (void)state;
    uint64_t random = 5;
    int outside = 0;
    for (int i = 0; i < 2000; i++) {
        const double point[1][2] = {{random_in(&random, -0.6, 0.6), random_in(&random, -0.6, 0.6)}};
        const double x = fabs(point[0][0]), y = fabs(point[0][1]), r = hypot(x, y);
        const bool inside = x < 0.5 && y < 0.5;
        assert_near(discrepancy(point, 1, WEFT_JITTER_SQUARE, 1.0).value,
                    inside ? 1.0 - 2.0 * (0.5 - x) * (0.5 - y) : 1.0, 1e-12, "square");
        assert_near(discrepancy(point, 1, WEFT_JITTER_DISC, 1.0).value, weft_edge_disc(r), 1e-12,
                    "disc");
        outside += !inside;
    }
    assert_true(outside > 100);
    const double axes[][2] = {{0.0, 0.0}, {0.3, 0.0}, {0.0, -0.3}, {0.5, 0.5}, {-0.5, 0.1}};
    for (size_t i = 0; i < WEFT_COUNT(axes); i++)
        assert_near(discrepancy(&axes[i], 1, WEFT_JITTER_SQUARE, 1.0).value,
                    1.0 - 2.0 * (0.5 - fabs(axes[i][0])) * (0.5 - fabs(axes[i][1])), 1e-12, "axes");
}

// Many points in one place are one; many on a line through the middle are missed or met by half.
static void test_heaps_and_lines(void **state)
{
    (void)state;
    double points[50][2];
    for (int i = 0; i < 50; i++)
        points[i][0] = 0.1, points[i][1] = -0.2;
    assert_near(discrepancy((points_of)points, 50, WEFT_JITTER_SQUARE, 1.0).value,
                1.0 - 2.0 * 0.4 * 0.3, 1e-11, "heap");
    for (int turn = 0; turn < 12; turn++) {
        const double angle = turn * M_PI / 12.0;
        for (int i = 0; i < 50; i++) {
            points[i][0] = (i / 49.0 - 0.5) * cos(angle);
            points[i][1] = (i / 49.0 - 0.5) * sin(angle);
        }
        assert_near(discrepancy((points_of)points, 50, WEFT_JITTER_DISC, 1.0).value, 0.5, 1e-11,
                    "line");
    }
}

// ---- every edge
// -----------------------------------------------------------------------------------

static double area_of(enum weft_jitter_shape shape, const double normal[2], double distance)
{
    return shape == WEFT_JITTER_DISC ? weft_edge_disc(distance)
                                     : weft_edge_square(normal, distance);
}

// The error of edges of one direction through a point, each other point being tested in long
// double.
static double through(points_of points, int count, enum weft_jitter_shape shape, const double *p,
                      const double normal[2])
{
    int inside = 0, on = 0;
    for (int i = 0; i < count; i++) {
        const long double side = ((long double)points[i][0] - p[0]) * normal[0] +
                                 ((long double)points[i][1] - p[1]) * normal[1];
        on += fabsl(side) <= 1e-13L;
        inside += side < -1e-13L;
    }
    const double area = area_of(shape, normal, p[0] * normal[0] + p[1] * normal[1]);
    return fmax((double)(inside + on) / count - area, area - (double)inside / count);
}

static double by_every_edge(points_of points, int count, enum weft_jitter_shape shape)
{
    double worst = 0.0;
    for (int i = 0; i < count; i++) {
        const double *p = points[i], r = hypot(p[0], p[1]);
        // The chord that is halved: from corner to corner of the rectangle about p.
        double halved[2] = {copysign(0.5 - fabs(p[1]), p[0]), copysign(0.5 - fabs(p[0]), p[1])};
        if (shape == WEFT_JITTER_DISC)
            halved[0] = r > 0.0 ? p[0] : 1.0, halved[1] = p[1];
        const double length = hypot(halved[0], halved[1]);
        const double unit[2] = {halved[0] / length, halved[1] / length};
        if (length > 0.0)
            worst = larger(worst, through(points, count, shape, p, unit));
        for (int j = 0; j < count; j++) {
            const double x = points[j][0] - p[0], y = points[j][1] - p[1], l = hypot(x, y);
            const double normal[2] = {y / l, -x / l}, reverse[2] = {-y / l, x / l};
            if (l == 0.0)
                continue;
            worst = larger(worst, through(points, count, shape, p, normal));
            worst = larger(worst, through(points, count, shape, p, reverse));
        }
    }
    return worst;
}

// The worst edge at each of many angles: an edge at each point, counted by itself.
static double by_search(points_of points, int count, enum weft_jitter_shape shape, int angles)
{
    double worst = 0.0;
    for (int a = 0; a < angles; a++) {
        const double angle = (a + 0.37) * M_PI / angles, normal[2] = {cos(angle), sin(angle)};
        for (int i = 0; i < count; i++)
            worst = larger(worst, through(points, count, shape, points[i], normal));
    }
    return worst;
}

static void check_edge(points_of points, int count, enum weft_jitter_shape shape,
                       const struct weft_discrepancy *d)
{
    const double normal[2] = {cos(d->angle), sin(d->angle)};
    int fewest = 0, most = 0;
    for (int i = 0; i < count; i++) {
        const double past = points[i][0] * normal[0] + points[i][1] * normal[1] - d->distance;
        fewest += past < -1e-11;
        most += past <= 1e-11;
    }
    assert_near(d->area, area_of(shape, normal, d->distance), 1e-13, "area");
    assert_near(fabs(d->share - d->area), d->value, 1e-15, "error");
    assert_near(d->share, (double)(d->share > d->area ? most : fewest) / count, 1e-15, "share");
}

// Random points, points of a lattice (many on one line, some in one place), some beyond the rim.
static void fill(double (*points)[2], int count, int kind, uint64_t *random)
{
    for (int i = 0; i < count; i++)
        for (int axis = 0; axis < 2; axis++) {
            const double reach = kind == 2 ? 0.6 : 0.5, x = random_in(random, -reach, reach);
            points[i][axis] = kind == 1 ? (floor(5.0 * (x + 0.5)) + 0.5) / 5.0 - 0.5 : x;
        }
}

static void test_every_edge(void **state)
{
    (void)state;
    double points[14][2];
    uint64_t random = 11;
    int checked = 0;
    for (int round = 0; round < 900; round++) {
        const int count = 1 + round % 14, kind = round % 3, shape = round % 2;
        fill(points, count, kind, &random);
        const struct weft_discrepancy d = discrepancy((points_of)points, count, shape, 1.0);
        assert_near(d.value, by_every_edge((points_of)points, count, shape), 1e-11, "every edge");
        check_edge((points_of)points, count, shape, &d);
        checked += d.value > 0.05;
    }
    assert_int_equal(checked, 900);
}

// A search by angles comes near from below: the area turns by less than 1 per radian.
static void test_search(void **state)
{
    (void)state;
    double points[20][2];
    uint64_t random = 13;
    const int angles = 3000;
    for (int round = 0; round < 24; round++) {
        const int count = 1 + round % 20, shape = round % 2;
        fill(points, count, round % 3, &random);
        const double found = by_search((points_of)points, count, shape, angles);
        const double d = discrepancy((points_of)points, count, shape, 1.0).value;
        assert_true(found <= d + 1e-11 && found >= d - 2.0 * M_PI / angles);
    }
}

// Turned by 90 degrees, mirrored, swapped or scaled, a set is as good as it was.
static void test_symmetries(void **state)
{
    (void)state;
    uint64_t random = 17;
    double points[60][2], other[60][2];
    for (int round = 0; round < 40; round++) {
        const int shape = round % 2;
        fill(points, 60, round % 3, &random);
        const double d = discrepancy((points_of)points, 60, shape, 1.0).value;
        for (int way = 0; way < 3; way++) {
            for (int i = 0; i < 60; i++) {
                other[i][0] = way == 0 ? -points[i][1] : way == 1 ? -points[i][0] : points[i][1];
                other[i][1] = way == 1 ? points[i][1] : points[i][0];
            }
            assert_near(discrepancy((points_of)other, 60, shape, 1.0).value, d, 1e-11, "turned");
        }
        for (int i = 0; i < 60; i++)
            for (int axis = 0; axis < 2; axis++)
                other[i][axis] = points[i][axis] * 3.5;
        assert_near(discrepancy((points_of)other, 60, shape, 3.5).value, d, 1e-11, "scaled");
    }
}

static struct message last;
static const struct weft_log remember_log = {keep_message, &last};

static void test_bad_params(void **state)
{
    (void)state;
    static const double good[1][2] = {{0.0, 0.0}}, bad[2][2] = {{0.0, 0.0}, {NAN, 0.0}};
    const struct weft_discrepancy_params wrong[] = {
        {.points = NULL, .count = 1},
        {.points = good, .count = 0},
        {.points = good, .count = WEFT_DISCREPANCY_MAX + 1},
        {.points = good, .count = 1, .shape = WEFT_JITTER_SHAPE_COUNT},
        {.points = good, .count = 1, .size = -1.0},
        {.points = bad, .count = 2},
    };
    for (size_t i = 0; i < WEFT_COUNT(wrong); i++) {
        struct weft_discrepancy_params params = wrong[i];
        struct weft_discrepancy d;
        params.log = &remember_log;
        last.count = 0;
        assert_int_equal(weft_discrepancy_compute(&params, &d), WEFT_ERR_ARGUMENT);
        assert_true(last.count == 1 && isnan(d.value));
    }
    assert_non_null(strstr(last.text, "sample 1 of 2"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_published),  cmocka_unit_test(test_fractions),
        cmocka_unit_test(test_grids),      cmocka_unit_test(test_within_one_nth),
        cmocka_unit_test(test_one_point),  cmocka_unit_test(test_heaps_and_lines),
        cmocka_unit_test(test_every_edge), cmocka_unit_test(test_search),
        cmocka_unit_test(test_symmetries), cmocka_unit_test(test_bad_params),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
