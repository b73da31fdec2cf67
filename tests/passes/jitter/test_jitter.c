// SPDX-License-Identifier: BSD-3-Clause
// Sets of samples: published values, and what each kind promises.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "tests/passes/jitter/points.h"

static struct message last;
static const struct weft_log remember_log = {keep_message, &last};

static struct weft_jitter square(const char *text)
{
    return set_named(text, WEFT_JITTER_SQUARE, 1.0, false);
}

static void make(const struct weft_jitter_params *params, struct weft_jitter *set)
{
    assert_int_equal(weft_jitter_create(params, set), WEFT_OK);
}

// ---- the list
// -------------------------------------------------------------------------------------

static void test_list(void **state)
{
    (void)state;
    int count = 0;
    for (; weft_jitter_list[count]; count++) {
        const struct weft_jitter_info *info = weft_jitter_list[count], *parsed;
        int number = -1;
        assert_ptr_equal(weft_jitter_find(info->name), info);
        assert_true(info->description && info->default_count > 0);
        assert_int_equal(weft_jitter_parse(NULL, info->name, &parsed, &number), WEFT_OK);
        assert_ptr_equal(parsed, info);
        assert_int_equal(number, 0);
        struct weft_jitter set;
        make(weft_jitter_params(.info = info), &set);
        assert_int_equal(set.count, info->default_count);
        for (int i = 0; i < set.count; i++)
            for (int axis = 0; axis < 2; axis++)
                assert_true(set.points[i][axis] >= -0.5 && set.points[i][axis] <= 0.5);
        weft_jitter_clear(&set);
        assert_null(set.points);
    }
    assert_int_equal(count, 14);
    assert_null(weft_jitter_find("j5"));
    assert_null(weft_jitter_find(NULL));
}

static void refused(const char *text, const char *expected)
{
    const struct weft_jitter_info *info = weft_jitter_list[0];
    int count = 7;
    last.count = 0;
    assert_int_equal(weft_jitter_parse(&remember_log, text, &info, &count), WEFT_ERR_ARGUMENT);
    assert_true(!info && count == 0);
    assert_int_equal(last.count, 1);
    if (!strstr(last.text, expected))
        fail_msg("'%s': '%s' lacks '%s'", text, last.text, expected);
}

static void test_texts(void **state)
{
    (void)state;
    const struct weft_jitter_info *info;
    int count;
    assert_int_equal(weft_jitter_parse(NULL, "halton:64", &info, &count), WEFT_OK);
    assert_string_equal(info->name, "halton");
    assert_int_equal(count, 64);
    refused("poisson", "there are j2, j3, j4, j8, j15, j24, j66, msaa, grid, stratified, halton, "
                       "hammersley, sobol, r2");
    refused("haltn:8", "did you mean halton");
    refused("", "there are");
    refused("j8:9", "j8 has 8 points, not 9");
    refused("msaa:3", "msaa has 1, 2, 4, 8 or 16 points, not 3");
    refused("sobol:0", "has 1 to 1048576 points, not 0");
    refused("sobol:1048577", "has 1 to 1048576 points, not 1048577");
    refused("sobol:", "'' is no number of points");
    refused("sobol:-4", "'-4' is no number of points");
    refused("sobol:8x", "'8x' is no number of points");
    refused("sobol:9999999999", "is no number of points");
    refused("a-name-that-is-far-longer-than-any-name-of-a-set-of-samples-can-be", "longer than 63");
}

static void test_bad_params(void **state)
{
    (void)state;
    const struct weft_jitter_info *msaa = weft_jitter_find("msaa");
    const struct weft_jitter_params bad[] = {
        {.info = NULL},
        {.info = msaa, .count = 3},
        {.info = msaa, .count = -1},
        {.info = msaa, .size = -1.0},
        {.info = msaa, .size = NAN},
        {.info = msaa, .size = INFINITY},
        {.info = msaa, .shape = WEFT_JITTER_SHAPE_COUNT},
    };
    for (size_t i = 0; i < WEFT_COUNT(bad); i++) {
        struct weft_jitter_params params = bad[i];
        struct weft_jitter set;
        params.log = &remember_log;
        last.count = 0;
        assert_int_equal(weft_jitter_create(&params, &set), WEFT_ERR_ARGUMENT);
        assert_true(last.count == 1 && !set.points && set.count == 0);
    }
}

// ---- published values
// -----------------------------------------------------------------------------

// The tables have six digits, and their coordinates add up to 0 but for them: a digit that is wrong
// by more than the last two shows. Ends and middles are compared by value besides.
static void test_tables(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        int at;
        double x, y;
    } values[] = {
        {"j2", 0, 0.246490, 0.249999},    {"j3", 1, 0.256263, 0.368119},
        {"j4", 3, 0.296924, 0.149994},    {"j8", 0, -0.334818, 0.435331},
        {"j8", 7, 0.164216, -0.054399},   {"j15", 7, -0.454968, 0.134088},
        {"j24", 23, 0.297997, -0.417965}, {"j66", 33, 0.009146, 0.015098},
        {"j66", 65, 0.145087, 0.221726},
    };
    for (size_t i = 0; i < WEFT_COUNT(values); i++) {
        struct weft_jitter set = square(values[i].name);
        assert_int_equal(set.count, atoi(values[i].name + 1));
        assert_true(set.points[values[i].at][0] == values[i].x);
        assert_true(set.points[values[i].at][1] == values[i].y);
        for (int axis = 0; axis < 2; axis++)
            assert_near(set.mean[axis], 0.0, 4e-7, values[i].name);
        weft_jitter_clear(&set);
    }
}

// Every digit: sums of the coordinates in millionths, each times its place in the table, made from
// another copy of the published file.
static void test_digits(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        int64_t sums[2];
    } tables[] = {{"j2", {-246490, -249999}},    {"j3", {490559, 132978}},
                  {"j4", {509369, -203689}},     {"j8", {593430, -533404}},
                  {"j15", {-6269063, -1977025}}, {"j24", {-1663110, 642786}},
                  {"j66", {35919465, 37421220}}};
    for (size_t t = 0; t < WEFT_COUNT(tables); t++) {
        struct weft_jitter set = square(tables[t].name);
        for (int axis = 0; axis < 2; axis++) {
            int64_t sum = 0;
            for (int i = 0; i < set.count; i++)
                sum += (i + 1) * (int64_t)llrint(set.points[i][axis] * 1e6);
            assert_true(sum == tables[t].sums[axis]);
        }
        weft_jitter_clear(&set);
    }
}

static void test_multisamples(void **state)
{
    (void)state;
    struct weft_jitter set = square("msaa:4");
    static const double four[4][2] = {
        {-0.125, -0.375}, {0.375, -0.125}, {-0.375, 0.125}, {0.125, 0.375}};
    assert_memory_equal(set.points, four, sizeof four);
    weft_jitter_clear(&set);
    static const int counts[] = {1, 2, 4, 8, 16};
    for (size_t c = 0; c < WEFT_COUNT(counts); c++) {
        struct weft_jitter_params params = {.info = weft_jitter_find("msaa"), .count = counts[c]};
        make(&params, &set);
        unsigned columns = 0, rows = 0;
        for (int i = 0; i < set.count; i++) {
            columns |= 1u << (int)(set.points[i][0] * 16.0 + 8.0);
            rows |= 1u << (int)(set.points[i][1] * 16.0 + 8.0);
        }
        // No two share a column or row of sixteenths.
        assert_int_equal(__builtin_popcount(columns), counts[c]);
        assert_int_equal(__builtin_popcount(rows), counts[c]);
        const double mean = counts[c] == 16 ? -1.0 / 32.0 : 0.0;
        assert_true(set.mean[0] == mean && set.mean[1] == mean);
        weft_jitter_clear(&set);
    }
}

static void test_radical_inverse(void **state)
{
    (void)state;
    static const struct {
        uint32_t base;
        uint64_t index;
        double value;
    } values[] = {
        {2, 0, 0.0},          {2, 1, 0.5},          {2, 6, 0.375},
        {2, 11, 13.0 / 16.0}, {3, 1, 1.0 / 3.0},    {3, 5, 7.0 / 9.0},
        {10, 1234, 0.4321},   {7, 48, 48.0 / 49.0}, {2, UINT64_MAX, 1.0 - 0x1p-53},
    };
    for (size_t i = 0; i < WEFT_COUNT(values); i++)
        assert_true(weft_jitter_radical_inverse(values[i].base, values[i].index) ==
                    values[i].value);
    const uint32_t bases[] = {0, 1, (1u << 26) + 1, UINT32_MAX};
    for (size_t i = 0; i < WEFT_COUNT(bases); i++)
        assert_true(isnan(weft_jitter_radical_inverse(bases[i], 1)));
    uint64_t random = 1;
    for (int i = 0; i < 20000; i++) {
        const uint32_t base = (uint32_t)random_in(&random, 2.0, i % 2 ? 40.0 : 0x1p26);
        const uint64_t index = (uint64_t)random_in(&random, 0.0, i % 3 ? 1e6 : 0x1p63);
        const double value = weft_jitter_radical_inverse(base, index);
        assert_true(value >= 0.0 && value < 1.0);
    }
}

static void test_halton(void **state)
{
    (void)state;
    static const double values[5][2] = {{1.0 / 2.0, 1.0 / 3.0},
                                        {1.0 / 4.0, 2.0 / 3.0},
                                        {3.0 / 4.0, 1.0 / 9.0},
                                        {1.0 / 8.0, 4.0 / 9.0},
                                        {5.0 / 8.0, 7.0 / 9.0}};
    struct weft_jitter set = square("halton:5");
    for (int i = 0; i < 5; i++)
        for (int axis = 0; axis < 2; axis++)
            assert_true(set.points[i][axis] == values[i][axis] - 0.5);
    weft_jitter_clear(&set);
}

// Roberts's formula in long double, to the last point there can be.
static void test_r2(void **state)
{
    (void)state;
    const long double g = 1.32471795724474602596090885447809734L;
    assert_true(fabsl(g * g * g - g - 1.0L) < 1e-18L);
    struct weft_jitter set = square("r2:1048576");
    int checked = 0;
    for (int i = 0; i < set.count; i += 37, checked++)
        for (int axis = 0; axis < 2; axis++) {
            const long double all = 0.5L + (i + 1) * (axis ? 1.0L / g / g : 1.0L / g);
            const double expected = (double)(all - floorl(all) - 0.5L);
            // What long double loses of a product of a million.
            assert_near(set.points[i][axis], expected, 1e-12, "r2");
        }
    assert_true(checked > 28000);
    weft_jitter_clear(&set);
}

// SplitMix64's published first numbers for the seed 0.
static void test_random_numbers(void **state)
{
    (void)state;
    struct weft_jitter set;
    make(weft_jitter_params(.info = weft_jitter_find("stratified"), .count = 1), &set);
    const uint64_t first = UINT64_C(0xe220a8397b1dcdaf), second = UINT64_C(0x6e789e6aa1b965f4);
    assert_true(set.points[0][0] == (double)(first >> 11) * 0x1p-53 - 0.5);
    assert_true(set.points[0][1] == (double)(second >> 11) * 0x1p-53 - 0.5);
    weft_jitter_clear(&set);
}

// What sets that are not centred shift the picture by: Halton 8 and 4, R2 8, 16 multisamples.
static void test_shifts(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        int axis;
        double shift, digits;
    } values[] = {
        {"halton:8", 0, -0.055, 5e-4}, {"halton:4", 1, -0.11, 5e-3},
        {"r2:8", 0, -0.10, 5e-3},      {"msaa:16", 0, -0.03125, 0.0},
        {"msaa:16", 1, -0.03125, 0.0}, {"sobol:64", 1, -1.0 / 128, 0.0},
    };
    for (size_t i = 0; i < WEFT_COUNT(values); i++) {
        struct weft_jitter set = square(values[i].name);
        assert_near(set.mean[values[i].axis], values[i].shift, values[i].digits, values[i].name);
        weft_jitter_clear(&set);
    }
}

// ---- what each kind promises
// ----------------------------------------------------------------------

static void test_grid(void **state)
{
    (void)state;
    for (int k = 1; k <= 20; k++) {
        struct weft_jitter set;
        make(weft_jitter_params(.info = weft_jitter_find("grid"), .count = k * k), &set);
        for (int i = 0; i < k * k; i++) {
            assert_near(set.points[i][0], (i % k + 0.5) / k - 0.5, 2e-16, "x");
            assert_near(set.points[i][1], (i / k + 0.5) / k - 0.5, 2e-16, "y");
        }
        weft_jitter_clear(&set);
    }
    // Three rows of 4, and of 2, 3 and 3.
    struct weft_jitter twelve = square("grid:12"), eight = square("grid:8");
    assert_near(twelve.points[4][1], 0.0, 1e-16, "row");
    assert_near(eight.points[0][1], 1.0 / 8.0 - 0.5, 1e-16, "row");
    assert_near(eight.points[7][1], 0.5 - 3.0 / 16.0, 1e-16, "row");
    weft_jitter_clear(&twelve);
    weft_jitter_clear(&eight);
    for (int n = 1; n <= 400; n++) {
        struct weft_jitter set;
        make(weft_jitter_params(.info = weft_jitter_find("grid"), .count = n), &set);
        for (int axis = 0; axis < 2; axis++)
            assert_near(set.mean[axis], 0.0, 1e-16, "mean");
        weft_jitter_clear(&set);
    }
}

// Each cell has one point, for numbers that are squares and for those that are not: rows as high as
// they have cells.
static void test_stratified(void **state)
{
    (void)state;
    for (int n = 1; n <= 300; n++) {
        struct weft_jitter set, again, other, grid;
        const struct weft_jitter_info *info = weft_jitter_find("stratified");
        make(weft_jitter_params(.info = info, .count = n, .seed = 7), &set);
        make(weft_jitter_params(.info = info, .count = n, .seed = 7), &again);
        make(weft_jitter_params(.info = info, .count = n, .seed = 8), &other);
        make(weft_jitter_params(.info = weft_jitter_find("grid"), .count = n), &grid);
        assert_memory_equal(set.points, again.points, (size_t)n * sizeof *set.points);
        assert_memory_not_equal(set.points, other.points, (size_t)n * sizeof *set.points);
        for (int i = 0; i < n; i++) {
            int columns = 0;
            for (int j = 0; j < n; j++)
                columns += grid.points[j][1] == grid.points[i][1];
            // Cells of n all have the area 1 / n.
            assert_true(fabs(set.points[i][0] - grid.points[i][0]) <= 0.5 / columns + 1e-15);
            assert_true(fabs(set.points[i][1] - grid.points[i][1]) <= 0.5 * columns / n + 1e-15);
        }
        weft_jitter_clear(&set);
        weft_jitter_clear(&again);
        weft_jitter_clear(&other);
        weft_jitter_clear(&grid);
    }
}

// Whether 2^k points have one in each box of sides 2^-j and 2^(j-k), for every j.
static bool is_net(points_of points, int k)
{
    for (int j = 0; j <= k; j++) {
        unsigned char seen[1 << 10] = {0};
        for (int i = 0; i < 1 << k; i++) {
            const int column = (int)floor(ldexp(points[i][0] + 0.5, j));
            const int row = (int)floor(ldexp(points[i][1] + 0.5, k - j));
            unsigned char *box = &seen[row << j | column];
            if (*box)
                return false;
            *box = 1;
        }
    }
    return true;
}

static void test_nets(void **state)
{
    (void)state;
    struct weft_jitter sobol = square("sobol:4096"), halton = square("halton:4096");
    int checked = 0, others = 0;
    for (int k = 0; k <= 10; k++)
        for (int first = 0; first + (1 << k) <= 4096; first += 1 << k, checked++) {
            assert_true(is_net((points_of)sobol.points + first, k));
            others += !is_net((points_of)halton.points + first, k);
        }
    assert_true(checked > 8000 && others > 1000);
    for (int k = 0; k <= 10; k++) {
        struct weft_jitter set;
        make(weft_jitter_params(.info = weft_jitter_find("hammersley"), .count = 1 << k), &set);
        assert_true(is_net((points_of)set.points, k));
        weft_jitter_clear(&set);
    }
    assert_true(sobol.points[1][0] == 0.0 && sobol.points[1][1] == 0.0);
    assert_true(sobol.points[2][0] == -0.25 && sobol.points[2][1] == 0.25);
    weft_jitter_clear(&sobol);
    weft_jitter_clear(&halton);
}

// Those that say so begin with the set of fewer points, and no others do.
static void test_extends(void **state)
{
    (void)state;
    int yes = 0, no = 0;
    for (int i = 0; weft_jitter_list[i]; i++) {
        const struct weft_jitter_info *info = weft_jitter_list[i];
        if (info->counts) {
            assert_false(info->extends);
            continue;
        }
        bool same = true;
        for (int n = 1; n < 70; n++) {
            struct weft_jitter a, b;
            make(weft_jitter_params(.info = info, .count = n), &a);
            make(weft_jitter_params(.info = info, .count = n + 1), &b);
            same = same && !memcmp(a.points, b.points, (size_t)n * sizeof *a.points);
            weft_jitter_clear(&a);
            weft_jitter_clear(&b);
        }
        assert_int_equal(same, info->extends);
        yes += same;
        no += !same;
    }
    assert_true(yes == 3 && no == 3);
}

// ---- centring, sizes, discs
// -----------------------------------------------------------------------

static void test_centre(void **state)
{
    (void)state;
    int shifted = 0;
    for (int i = 0; weft_jitter_list[i]; i++)
        for (int shape = 0; shape < WEFT_JITTER_SHAPE_COUNT; shape++) {
            struct weft_jitter plain, centred;
            struct weft_jitter_params params = {
                .info = weft_jitter_list[i], .shape = shape, .size = 3.0};
            make(&params, &plain);
            params.centre = true;
            make(&params, &centred);
            for (int axis = 0; axis < 2; axis++) {
                long double sum = 0.0L;
                for (int k = 0; k < plain.count; k++) {
                    sum += plain.points[k][axis];
                    assert_near(centred.points[k][axis] + centred.shift[axis],
                                plain.points[k][axis], 1e-15, params.info->name);
                }
                assert_near(plain.mean[axis], (double)(sum / plain.count), 1e-16, "mean");
                assert_true(plain.shift[axis] == 0.0 && centred.shift[axis] == plain.mean[axis]);
                assert_near(centred.mean[axis], 0.0, 1e-15, params.info->name);
                shifted += fabs(plain.mean[axis]) > 1e-3;
            }
            weft_jitter_clear(&plain);
            weft_jitter_clear(&centred);
        }
    assert_true(shifted >= 10);
}

static void test_size(void **state)
{
    (void)state;
    for (int shape = 0; shape < WEFT_JITTER_SHAPE_COUNT; shape++) {
        struct weft_jitter one = set_named("halton:50", shape, 0.0, false);
        struct weft_jitter large = set_named("halton:50", shape, 4.0, false);
        for (int i = 0; i < 50; i++)
            for (int axis = 0; axis < 2; axis++)
                assert_true(large.points[i][axis] == 4.0 * one.points[i][axis]);
        weft_jitter_clear(&one);
        weft_jitter_clear(&large);
    }
}

// A caller's own record: three points that stand for a point and steps along both axes.
static double corner[3][2];

static void compute_corner(const struct weft_jitter_info *info, int count, uint64_t seed,
                           double (*points)[2])
{
    (void)info, (void)seed;
    memcpy(points, corner, (size_t)count * sizeof *points);
}

static const struct weft_jitter_info corner_info = {.name = "corner", .compute = compute_corner};

// The map keeps areas: its determinant is pi / 4 everywhere. Rings become circles, and the
// diagonals, where its formula changes, stay.
static void test_disc(void **state)
{
    (void)state;
    const double h = 1e-6;
    uint64_t random = 3;
    int checked = 0;
    while (checked < 2000) {
        const double x = random_in(&random, -0.5, 0.49), y = random_in(&random, -0.5, 0.49);
        const double r = fmax(fabs(x), fabs(y));
        corner[0][0] = corner[2][0] = x;
        corner[0][1] = corner[1][1] = y;
        corner[1][0] = x + h;
        corner[2][1] = y + h;
        if (fabs(fabs(x) - fabs(y)) < 1e-4 || r < 0.02)
            continue;
        checked++;
        struct weft_jitter set;
        make(weft_jitter_params(.info = &corner_info, .count = 3, .shape = WEFT_JITTER_DISC), &set);
        const double *p = set.points[0], *u = set.points[1], *v = set.points[2];
        assert_near(hypot(p[0], p[1]), r, 1e-15, "radius");
        const double area = (u[0] - p[0]) * (v[1] - p[1]) - (u[1] - p[1]) * (v[0] - p[0]);
        // Differences of steps of 1e-6: second derivatives are below 2 / r.
        assert_near(area / h / h, M_PI_4, 4.0 * h / r + 1e-9, "area");
        weft_jitter_clear(&set);
    }
    static const double fixed[][4] = {
        {0.0, 0.0, 0.0, 0.0},
        {0.5, 0.0, 0.5, 0.0},
        {0.0, -0.25, 0.0, -0.25},
        {-0.5, 0.0, -0.5, 0.0},
        {0.5, 0.5, M_SQRT1_2 / 2, M_SQRT1_2 / 2},
        {-0.5, 0.5, -M_SQRT1_2 / 2, M_SQRT1_2 / 2},
        {-0.2, -0.2, -0.2 * M_SQRT1_2, -0.2 * M_SQRT1_2},
    };
    for (size_t i = 0; i < WEFT_COUNT(fixed); i++) {
        struct weft_jitter set;
        memcpy(corner[0], fixed[i], sizeof corner[0]);
        make(weft_jitter_params(.info = &corner_info, .count = 1, .shape = WEFT_JITTER_DISC), &set);
        for (int axis = 0; axis < 2; axis++)
            assert_near(set.points[0][axis], fixed[i][2 + axis], 1e-16, "fixed");
        weft_jitter_clear(&set);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_list),
        cmocka_unit_test(test_texts),
        cmocka_unit_test(test_bad_params),
        cmocka_unit_test(test_tables),
        cmocka_unit_test(test_digits),
        cmocka_unit_test(test_multisamples),
        cmocka_unit_test(test_radical_inverse),
        cmocka_unit_test(test_halton),
        cmocka_unit_test(test_r2),
        cmocka_unit_test(test_random_numbers),
        cmocka_unit_test(test_shifts),
        cmocka_unit_test(test_grid),
        cmocka_unit_test(test_stratified),
        cmocka_unit_test(test_nets),
        cmocka_unit_test(test_extends),
        cmocka_unit_test(test_centre),
        cmocka_unit_test(test_size),
        cmocka_unit_test(test_disc),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
