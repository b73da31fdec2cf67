// SPDX-License-Identifier: BSD-3-Clause
// Quantities of functions whose derivatives and curvatures are known, in index spaces that random
// affine maps make; bounds against errors that are drawn by chance.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "filter/quantity.h"
#include "tests/support/common.h"

static const char everything[] =
    "value,gradient,gradient-magnitude,normal,hessian,laplacian,mean-curvature,gaussian-curvature,"
    "principal-curvatures";

static struct weft_quantities list_of(const char *text)
{
    struct weft_quantities list;
    assert_int_equal(weft_quantities_parse(&log_to_stderr, text, &list), WEFT_OK);
    return list;
}

static uint64_t state = 1;

// In [-1, 1).
static double drawn(void)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (double)(state >> 11) * 0x1p-52 - 1.0;
}

// ---- functions ----------------------------------------------------------------------------------

typedef long double real;
enum { BALL, TORUS, CYLINDER, WAVES, FUNCTIONS };
#define TORUS_RADIUS 3.0L

// High within; level surfaces are spheres, tori and cylinders of any radius.
static real function(int which, const real p[3])
{
    const real ring = hypotl(p[0], p[1]) - TORUS_RADIUS;
    switch (which) {
    case BALL:
        return 5.0L - sqrtl(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    case TORUS:
        return 1.0L - hypotl(ring, p[2]);
    case CYLINDER:
        return 2.0L - hypotl(p[1], p[2]);
    default:
        return sinl(p[0] + 0.5L * p[1]) * cosl(p[2]) + 0.3L * p[0] * p[1];
    }
}

// Larger curvature first; false where none is known.
static bool known_curvatures(int which, const real p[3], real out[2])
{
    const real across = hypotl(p[0], p[1]), ring = across - TORUS_RADIUS;
    switch (which) {
    case BALL:
        out[0] = out[1] = 1.0L / sqrtl(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
        return true;
    case TORUS:
        out[0] = 1.0L / hypotl(ring, p[2]);
        out[1] = ring / hypotl(ring, p[2]) / across;
        return true;
    case CYLINDER:
        out[0] = 1.0L / hypotl(p[1], p[2]);
        out[1] = 0.0L;
        return true;
    default:
        return false;
    }
}

struct map {
    double m[3][4];
};

static real at(int which, const struct map *map, const real index[3])
{
    real p[3];
    for (int r = 0; r < 3; r++)
        p[r] = map->m[r][0] * index[0] + map->m[r][1] * index[1] + map->m[r][2] * index[2] +
               map->m[r][3];
    return function(which, p);
}

// By central differences of the fourth order, along the axes of index space, in long double.
static real difference(int which, const struct map *map, const struct weft_derivative *d,
                       const real index[3])
{
    static const real first[5] = {1.0L / 12, -8.0L / 12, 0.0L, 8.0L / 12, -1.0L / 12};
    static const real second[5] = {-1.0L / 12, 16.0L / 12, -30.0L / 12, 16.0L / 12, -1.0L / 12};
    const real step = 0x1p-10L;
    real sum = 0.0L;
    for (int i = 0; i < 125; i++) {
        const int offset[3] = {i % 5 - 2, i / 5 % 5 - 2, i / 25 - 2};
        real weight = 1.0L, moved[3];
        for (int a = 0; a < 3; a++) {
            const int order = d->along[a], k = offset[a] + 2;
            weight *= order == 0 ? (real)(offset[a] == 0)
                                 : (order == 1 ? first[k] / step : second[k] / (step * step));
            moved[a] = index[a] + offset[a] * step;
        }
        if (weight != 0.0L)
            sum += weight * at(which, map, moved);
    }
    return sum;
}

static struct map drawn_map(void)
{
    struct map map;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++)
            map.m[r][c] = 0.3 * drawn() + (r == c ? 1.0 : 0.0);
    return map;
}

// In world space there is nothing to transform.
static const struct map identity = {{{1.0}, {0.0, 1.0}, {0.0, 0.0, 1.0}}};

static void world_derivatives(int which, const real world[3], real out[WEFT_DERIVATIVES])
{
    const struct weft_quantities list = list_of("value,gradient,hessian");
    for (int i = 0; i < list.derivative_count; i++)
        out[i] = difference(which, &identity, &list.derivative[i], world);
}

// Goldman 2005, "Curvature formulas for implicit curves and surfaces": from g and H without any
// basis; signs as weft's.
static void curvatures_of(const real d[WEFT_DERIVATIVES], real *mean, real *gaussian)
{
    const real *g = d + 1, xx = d[4], xy = d[5], xz = d[6], yy = d[7], yz = d[8], zz = d[9];
    const real square = g[0] * g[0] + g[1] * g[1] + g[2] * g[2];
    const real h[3][3] = {{xx, xy, xz}, {xy, yy, yz}, {xz, yz, zz}};
    real ghg = 0.0L, gag = 0.0L;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) {
            const int p = (r + 1) % 3, q = (r + 2) % 3, s = (c + 1) % 3, t = (c + 2) % 3;
            ghg += g[r] * h[r][c] * g[c];
            gag += g[r] * (h[p][s] * h[q][t] - h[p][t] * h[q][s]) * g[c];
        }
    *mean = (ghg - square * (xx + yy + zz)) / (2.0L * square * sqrtl(square));
    *gaussian = gag / (square * square);
}

static void check(int which, const struct map *map, const real index[3])
{
    const struct weft_quantities list = list_of(everything);
    struct weft_quantity_transform transform;
    real world[3], d[WEFT_DERIVATIVES], mean, gaussian, known[2];
    double in[WEFT_DERIVATIVES], out[WEFT_QUANTITY_CHANNELS];
    assert_int_equal(weft_quantity_transform_create(&log_to_stderr, map->m, &transform), WEFT_OK);
    assert_int_equal(list.derivative_count, WEFT_DERIVATIVES);
    assert_int_equal(list.channel_count, WEFT_QUANTITY_CHANNELS);
    for (int r = 0; r < 3; r++)
        world[r] = map->m[r][0] * index[0] + map->m[r][1] * index[1] + map->m[r][2] * index[2] +
                   map->m[r][3];
    for (int i = 0; i < WEFT_DERIVATIVES; i++)
        in[i] = (double)difference(which, map, &list.derivative[i], index);
    weft_quantities_compute(&list, &transform, in, out);
    world_derivatives(which, world, d);
    curvatures_of(d, &mean, &gaussian);
    const real length = sqrtl(d[1] * d[1] + d[2] * d[2] + d[3] * d[3]);
    const real apart = sqrtl(fmaxl(mean * mean - gaussian, 0.0L));
    const real expected[WEFT_QUANTITY_CHANNELS] = {
        d[0],           d[1],           d[2],           d[3],        length,
        -d[1] / length, -d[2] / length, -d[3] / length, d[4],        d[5],
        d[6],           d[7],           d[8],           d[9],        d[4] + d[7] + d[9],
        mean,           gaussian,       mean + apart,   mean - apart};
    // Differences are right to step^4 of fourth and higher derivatives, about 1e-12 of them, and
    // 1e-19 / step^2; apart is the root of what may be 1e-9 off.
    for (int c = 0; c < WEFT_QUANTITY_CHANNELS; c++)
        assert_near(out[c], (double)expected[c], c < 17 ? 1e-8 : 1e-4, list.channel[c]);
    if (known_curvatures(which, world, known))
        for (int k = 0; k < 2; k++)
            assert_near(out[17 + k], (double)known[k], 1e-8, list.channel[17 + k]);
}

static void functions_have_their_quantities(void **unused)
{
    (void)unused;
    for (int which = 0; which < FUNCTIONS; which++)
        for (int i = 0; i < 40; i++) {
            const struct map map = i == 0 ? identity : drawn_map();
            // Away from the middle of the ball, and from the axes of the others.
            const real index[3] = {2.0L + drawn(), 2.5L + drawn(), 2.0L + 0.5 * drawn()};
            check(which, &map, index);
        }
}

// ---- bounds -------------------------------------------------------------------------------------

static void bounds_hold_and_are_near(void **unused)
{
    (void)unused;
    const struct weft_quantities list = list_of(everything);
    double nearest[WEFT_QUANTITY_CHANNELS] = {0.0};
    int infinite = 0, finite = 0;
    for (int i = 0; i < 400; i++) {
        const struct map map = drawn_map();
        struct weft_quantity_transform transform;
        double d[WEFT_DERIVATIVES], error[WEFT_DERIVATIVES], off[WEFT_DERIVATIVES];
        double value[WEFT_QUANTITY_CHANNELS], bound[WEFT_QUANTITY_CHANNELS];
        double moved[WEFT_QUANTITY_CHANNELS];
        const double scale = pow(10.0, -5.0 * fabs(drawn()));
        assert_int_equal(weft_quantity_transform_create(NULL, map.m, &transform), WEFT_OK);
        for (int k = 0; k < WEFT_DERIVATIVES; k++) {
            d[k] = drawn();
            error[k] = i % 3 ? scale : scale * fabs(drawn()); // alike, or each its own
        }
        weft_quantities_compute(&list, &transform, d, value);
        weft_quantities_bound(&list, &transform, d, error, bound);
        for (int n = 0; n < 40; n++) {
            for (int k = 0; k < WEFT_DERIVATIVES; k++)
                off[k] = d[k] + error[k] * (n % 2 ? drawn() : (drawn() < 0.0 ? -1.0 : 1.0));
            weft_quantities_compute(&list, &transform, off, moved);
            for (int c = 0; c < WEFT_QUANTITY_CHANNELS; c++) {
                const double by = fabs(moved[c] - value[c]);
                if (!(by <= bound[c] + 1e-12 * (1.0 + fabs(value[c]))))
                    fail_msg("%s moved by %g, bound %g", list.channel[c], by, bound[c]);
                if (isfinite(bound[c]) && by / bound[c] > nearest[c])
                    nearest[c] = by / bound[c];
                *(isfinite(bound[c]) ? &finite : &infinite) += 1;
            }
        }
    }
    assert_true(finite > 100000 && infinite > 1000);
    for (int c = 0; c < WEFT_QUANTITY_CHANNELS; c++) // none is a bound that nothing comes near
        if (!(nearest[c] > (c < 15 ? 0.8 : 0.2)))
            fail_msg("%s: nearest %g of its bound", list.channel[c], nearest[c]);
}

// ---- points without a normal, and without a value -----------------------------------------------

static void degenerate_points(void **unused)
{
    (void)unused;
    const struct weft_quantities list = list_of(everything);
    struct weft_quantity_transform transform;
    double d[WEFT_DERIVATIVES] = {7.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0};
    double out[WEFT_QUANTITY_CHANNELS], bound[WEFT_QUANTITY_CHANNELS];
    const double none[WEFT_DERIVATIVES] = {0.0};
    assert_int_equal(weft_quantity_transform_create(NULL, NULL, &transform), WEFT_OK);
    weft_quantities_compute(&list, &transform, d, out);
    weft_quantities_bound(&list, &transform, d, none, bound);
    for (int c = 0; c < WEFT_QUANTITY_CHANNELS; c++) {
        const double expected = c == 0 ? 7.0 : c >= 8 && c < 14 ? c - 7.0 : c == 14 ? 11.0 : 0.0;
        assert_true(out[c] == expected);
        // The gradient is known to be 0, but a normal has no bound there.
        assert_true((c >= 5 && c < 8) || c >= 15 ? isinf(bound[c]) : bound[c] == 0.0);
    }
    for (int k = 0; k < WEFT_DERIVATIVES; k++) {
        double bad[WEFT_DERIVATIVES] = {7.0, 1.0, 1.0, 1.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0};
        bad[k] = NAN;
        weft_quantities_compute(&list, &transform, bad, out);
        for (int c = 0; c < WEFT_QUANTITY_CHANNELS; c++) {
            const bool own = c == 0  ? k == 0
                             : c < 4 ? k == c // the identity still sums up 0 * NAN
                                     : false;
            if (own || (c == 4 && k >= 1 && k < 4) || (c >= 15 && k >= 1))
                assert_true(isnan(out[c]));
            if (k == 0 && c > 0)
                assert_true(isfinite(out[c]));
            if (k >= 4 && c < 8)
                assert_true(isfinite(out[c]));
        }
    }
    // Voxels of any size: 1e-200 in one place, 1e200 in another.
    for (int e = -200; e <= 200; e += 400) {
        const double m[3][4] = {{pow(10.0, e)}, {0.0, pow(10.0, e)}, {0.0, 0.0, pow(10.0, e)}};
        const double slope[WEFT_DERIVATIVES] = {0.0, 3.0, 0.0, 4.0};
        assert_int_equal(weft_quantity_transform_create(NULL, m, &transform), WEFT_OK);
        weft_quantities_compute(&list, &transform, slope, out);
        assert_near(out[4] * m[0][0], 5.0, 1e-12, "magnitude");
        assert_near(out[5], -0.6, 1e-12, "normal.X");
    }
}

// ---- planes, lists and transforms ---------------------------------------------------------------

enum { POINTS = 203 };

static void planes_are_points(void **unused)
{
    (void)unused;
    static const char *const lists[] = {everything, "laplacian,value", "normal", "hessian",
                                        "principal-curvatures,gradient"};
    static float in[WEFT_DERIVATIVES][POINTS], out[WEFT_QUANTITY_CHANNELS][POINTS];
    const float *from[WEFT_DERIVATIVES];
    float *to[WEFT_QUANTITY_CHANNELS];
    const struct map map = drawn_map();
    struct weft_quantity_transform transform;
    assert_int_equal(weft_quantity_transform_create(NULL, map.m, &transform), WEFT_OK);
    for (size_t n = 0; n < WEFT_COUNT(lists); n++) {
        const struct weft_quantities list = list_of(lists[n]);
        for (int i = 0; i < list.derivative_count; i++) {
            for (int k = 0; k < POINTS; k++)
                in[i][k] = k == 71 ? NAN : k == 99 ? 0.0f : (float)drawn();
            from[i] = in[i];
        }
        for (int c = 0; c < list.channel_count; c++)
            to[c] = out[c];
        weft_quantities_compute_planes(&list, &transform, POINTS, from, to);
        for (int k = 0; k < POINTS; k++) {
            double d[WEFT_DERIVATIVES], channel[WEFT_QUANTITY_CHANNELS];
            for (int i = 0; i < list.derivative_count; i++)
                d[i] = (double)in[i][k];
            weft_quantities_compute(&list, &transform, d, channel);
            for (int c = 0; c < list.channel_count; c++)
                if (isnan(channel[c]) ? !isnan(out[c][k]) : out[c][k] != (float)channel[c])
                    fail_msg("%s of %s: %g, not %g", list.channel[c], lists[n], (double)out[c][k],
                             channel[c]);
        }
    }
}

static void lists_are_read(void **unused)
{
    (void)unused;
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    static const char *const bad[][2] = {
        {"", "no quantity ''"},
        {"value,", "no quantity ''"},
        {"gradiant", "did you mean gradient?"},
        {"value,normal,value", "value is asked for twice"},
        {"value, normal", "no quantity ' normal'"},
        {"value,value,value,value,value,value,value,value,value,value,value", "twice"},
        {"xyzzy", "there are value, gradient,"}};
    struct weft_quantities list, none = {0};
    for (size_t i = 0; i < WEFT_COUNT(bad); i++) {
        message.count = 0;
        assert_int_equal(weft_quantities_parse(&log, bad[i][0], &list), WEFT_ERR_ARGUMENT);
        assert_int_equal(message.count, 1);
        assert_non_null(strstr(message.text, bad[i][1]));
        assert_memory_equal(&list, &none, sizeof list);
    }
    list = list_of("normal,value");
    assert_int_equal(list.derivative_count, 4);
    assert_int_equal(list.channel_count, 4);
    assert_string_equal(list.channel[0], "normal.X");
    assert_string_equal(list.channel[3], "Y");
    assert_int_equal(list_of("laplacian").derivative_count, 6);
    assert_int_equal(list_of("value").derivative_count, 1);
    for (int q = 0; q < WEFT_QUANTITY_COUNT; q++)
        assert_int_equal(list_of(weft_quantity_names[q]).quantity[0], q);
    assert_null(weft_quantity_names[WEFT_QUANTITY_COUNT]);
}

static void derivatives_are_read(void **unused)
{
    (void)unused;
    static const struct {
        const char *text, *written;
        int along[3], order;
    } cases[] = {{"none", "none", {0, 0, 0}, 0},
                 {"x", "x", {1, 0, 0}, 1},
                 {"z", "z", {0, 0, 1}, 1},
                 {"yy", "yy", {0, 2, 0}, 2},
                 {"zx", "xz", {1, 0, 1}, 2}};
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        char text[WEFT_DERIVATIVE_TEXT];
        const struct weft_derivative d = derivative_named(cases[i].text);
        assert_memory_equal(d.along, cases[i].along, sizeof d.along);
        assert_int_equal(weft_derivative_order(&d), cases[i].order);
        assert_string_equal(weft_derivative_format(&d, text), cases[i].written);
    }
    for (int dims = 1; dims <= 3; dims++)
        for (int i = 0; derivative_in(dims, i); i++)
            for (int a = dims; a < 3; a++)
                assert_int_equal(derivative_named(derivative_in(dims, i)).along[a], 0);
}

static void transforms_have_inverses(void **unused)
{
    (void)unused;
    static const double bad[][3][4] = {{{0.0}},
                                       {{1.0, 2.0}, {2.0, 4.0}, {0.0, 0.0, 1.0}},
                                       {{NAN, 0.0}, {0.0, 1.0}, {0.0, 0.0, 1.0}},
                                       {{INFINITY, 0.0}, {0.0, 1.0}, {0.0, 0.0, 1.0}},
                                       {{1e-320, 0.0}, {0.0, 1.0}, {0.0, 0.0, 1.0}}};
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    struct weft_quantity_transform transform;
    for (size_t i = 0; i < WEFT_COUNT(bad); i++)
        assert_int_equal(weft_quantity_transform_create(&log, bad[i], &transform),
                         WEFT_ERR_ARGUMENT);
    assert_int_equal(message.count, (int)WEFT_COUNT(bad));
    for (int i = 0; i < 100; i++) {
        const struct map map = drawn_map();
        assert_int_equal(weft_quantity_transform_create(NULL, map.m, &transform), WEFT_OK);
        for (int r = 0; r < 3; r++)
            for (int c = 0; c < 3; c++) {
                double sum = 0.0;
                for (int k = 0; k < 3; k++)
                    sum += transform.inverse[r][k] * map.m[k][c];
                assert_near(sum, r == c ? 1.0 : 0.0, 1e-13, "inverse");
            }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(functions_have_their_quantities),
                                       cmocka_unit_test(degenerate_points),
                                       cmocka_unit_test(bounds_hold_and_are_near),
                                       cmocka_unit_test(planes_are_points),
                                       cmocka_unit_test(lists_are_read),
                                       cmocka_unit_test(derivatives_are_read),
                                       cmocka_unit_test(transforms_have_inverses)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
