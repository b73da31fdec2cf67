// SPDX-License-Identifier: BSD-3-Clause
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "filter/check.h"
#include "tests/support/tile_error.h"
#include "tests/support/samples.h"
#include "weft.h"

static struct message last;
static const struct weft_log keep_log = {keep_message, &last};

static void assert_said(const char *text)
{
    if (last.count != 1 || !strstr(last.text, text) || strchr(last.text, '\n'))
        fail_msg("%d messages, last '%s', not '%s'", last.count, last.text, text);
    last.count = 0;
}

// Every ordinary record, with or without "+unit" behind "+radial"; false for derivatives.
static bool radial(const struct weft_kernel_info *info, bool unit, struct weft_kernel *out)
{
    assert_int_equal(weft_kernel_create(NULL, info, NULL, out), WEFT_OK);
    if (info->derivation)
        return false;
    assert_int_equal(weft_kernel_make_radial(NULL, out), WEFT_OK);
    if (unit)
        assert_int_equal(weft_kernel_normalise(NULL, out), WEFT_OK);
    return true;
}

static const double positions[][3] = {
    {0.0, 0.0, 0.0},
    {0.5, 0.25, 0.75},
    {-0.3, 0.9999, 12.0},
    {-7.125, 3.5, -0.5},
};

static bool can_be_normalised(const struct weft_kernel *k, int dims)
{
    const struct weft_kernel_sums sums = weft_kernel_radial_sums(k, dims);
    return dims == 1 || sums.least * sums.largest > 0.0;
}

static double total(const double *weights, int count)
{
    double sum = 0.0;
    for (int i = 0; i < count; i++)
        sum += weights[i];
    return sum;
}

// ---- weights ------------------------------------------------------------------------------------

// The tent 1 - |d|. In the middle of four samples |d| is 1 / sqrt(2), of eight sqrt(3) / 2; at
// (1/4, 0) two samples are in reach, at 1/4 and 3/4, and those a row further away are not.
static void weights_by_hand(void **state)
{
    (void)state;
    const struct weft_kernel tent = kernel_named("linear+radial"),
                             unit = kernel_named("linear+radial+unit");
    double w[WEFT_KERNEL_MAX_WEIGHTS];
    int64_t first[3];
    assert_int_equal(weft_kernel_weights_nd(&tent, 2, (double[]){0.5, -0.5}, w, first), 4);
    assert_true(first[0] == 0 && first[1] == -1 && first[2] == 0);
    for (int i = 0; i < 4; i++)
        assert_near(w[i], 1.0 - sqrt(0.5), 1e-15, "2D, middle");
    assert_int_equal(weft_kernel_weights_nd(&tent, 3, (double[]){0.5, 0.5, 0.5}, w, first), 8);
    for (int i = 0; i < 8; i++)
        assert_near(w[i], 1.0 - sqrt(0.75), 1e-15, "3D, middle");
    assert_int_equal(weft_kernel_weights_nd(&unit, 3, (double[]){0.5, 0.5, 0.5}, w, first), 8);
    for (int i = 0; i < 8; i++)
        assert_near(w[i], 0.125, 1e-15, "3D, middle, unit");
    weft_kernel_weights_nd(&tent, 2, (double[]){0.25, 0.0}, w, first);
    const double quarter[4] = {0.75, 0.25, 0.0, 0.0};
    for (int i = 0; i < 4; i++)
        assert_near(w[i], quarter[i], 0.0, "2D, (1/4, 0)");
    // (0.4, 0.3): distances 0.5, sqrt(0.45), sqrt(0.65) and sqrt(0.85) with x fastest.
    const double at[4] = {0.5, 1.0 - sqrt(0.45), 1.0 - sqrt(0.65), 1.0 - sqrt(0.85)};
    weft_kernel_weights_nd(&tent, 2, (double[]){0.4, 0.3}, w, first);
    for (int i = 0; i < 4; i++)
        assert_near(w[i], at[i], 1e-15, "2D, (0.4, 0.3)");
    weft_kernel_weights_nd(&unit, 2, (double[]){0.4, 0.3}, w, first);
    for (int i = 0; i < 4; i++)
        assert_near(w[i], at[i] / total(at, 4), 1e-15, "2D, (0.4, 0.3), unit");
    // Catmull-Rom reaches the diagonal neighbours of a sample: h(sqrt(2)).
    const struct weft_kernel cubic = kernel_named("catmull-rom+radial");
    weft_kernel_weights_nd(&cubic, 2, (double[]){0.0, 0.0}, w, first);
    assert_int_equal(first[0], -1);
    assert_near(w[5], 1.0, 0.0, "centre");
    assert_near(w[0], weft_kernel_weight(&cubic, M_SQRT2), 1e-15, "diagonal");
    assert_near(w[0], -0.0710678118654752, 1e-12, "diagonal by hand");
    assert_int_equal(weft_kernel_weights_nd(&cubic, 0, (double[]){0.0}, w, first), 0);
    assert_int_equal(weft_kernel_weights_nd(&cubic, 4, (double[]){0, 0, 0, 0}, w, first), 0);
}

// Every weight of the catalogue is h(|d|), nothing is outside of the ball, and axes may be
// permuted.
static void weights_are_of_the_distance(void **state)
{
    (void)state;
    double w[WEFT_KERNEL_MAX_WEIGHTS], turned[WEFT_KERNEL_MAX_WEIGHTS];
    for (const struct weft_kernel_info *const *info = weft_kernel_list; *info; info++) {
        struct weft_kernel k;
        for (int c = 0; radial(*info, false, &k) && c < 8; c++) {
            const int dims = 2 + c % 2, width = k.width;
            const double *p = positions[c / 2];
            int64_t first[3], back[3];
            const int count = weft_kernel_weights_nd(&k, dims, p, w, first);
            assert_int_equal(count, (int)lround(pow(width, dims)));
            weft_kernel_weights_nd(&k, dims, (double[]){p[dims - 1], p[1 % (dims - 1)], p[0]},
                                   turned, back);
            for (int i = 0; i < count; i++) {
                const int tap[3] = {i % width, i / width % width, i / width / width};
                double d = 0.0;
                for (int a = 0; a < dims; a++)
                    d = hypot(d, p[a] - (double)(first[a] + tap[a]));
                // Where h jumps at r, roundings decide.
                if (fabs(d - k.support) > 1e-12)
                    assert_near(w[i], d < k.support ? weft_kernel_weight(&k, d) : 0.0, 1e-12,
                                (*info)->name);
                const int mirrored = dims == 2 ? tap[1] + width * tap[0]
                                               : tap[2] + width * (tap[1] + width * tap[0]);
                assert_true(w[i] == turned[mirrored]);
            }
        }
    }
}

// (3, 4) / 5 turned by quarter turns, and (5, 0): the same distance from a sample, the same weight.
static void equal_distances_weigh_the_same(void **state)
{
    (void)state;
    const struct weft_kernel k = kernel_named("blackman-sinc:3+radial");
    const double r = 1.7, offsets[][2] = {{1.0, 0.0}, {0.6, 0.8}, {-0.8, 0.6}, {0.28, -0.96}};
    for (size_t i = 0; i < WEFT_COUNT(offsets); i++) {
        const double p[2] = {r * offsets[i][0], r * offsets[i][1]};
        double w[WEFT_KERNEL_MAX_WEIGHTS];
        int64_t first[3];
        weft_kernel_weights_nd(&k, 2, p, w, first);
        assert_near(w[-first[1] * k.width - first[0]], weft_kernel_weight(&k, r), 1e-14, "turned");
    }
}

static void separable_weights_are_products(void **state)
{
    (void)state;
    const struct weft_kernel k = kernel_named("lanczos:3+unit");
    double axis[3][WEFT_KERNEL_MAX_WIDTH], w[WEFT_KERNEL_MAX_WEIGHTS];
    int64_t first[3];
    for (size_t c = 0; c < WEFT_COUNT(positions); c++) {
        assert_int_equal(weft_kernel_weights_nd(&k, 3, positions[c], w, first), 216);
        for (int a = 0; a < 3; a++)
            assert_int_equal(weft_kernel_weights(&k, positions[c][a], axis[a]), first[a]);
        for (int i = 0; i < 216; i++)
            assert_near(w[i], axis[0][i % 6] * axis[1][i / 6 % 6] * axis[2][i / 36], 1e-16, "3D");
    }
}

static void one_dimension_is_unchanged(void **state)
{
    (void)state;
    int kernels = 0;
    for (const struct weft_kernel_info *const *info = weft_kernel_list; *info; info++) {
        struct weft_kernel plain, round;
        assert_int_equal(weft_kernel_create(NULL, *info, NULL, &plain), WEFT_OK);
        if (!radial(*info, false, &round))
            continue;
        for (size_t c = 0; c < WEFT_COUNT(positions); c++) {
            double a[WEFT_KERNEL_MAX_WEIGHTS], b[WEFT_KERNEL_MAX_WEIGHTS];
            int64_t first[3], same[3];
            const int count = weft_kernel_weights_nd(&plain, 1, positions[c], a, first);
            assert_int_equal(count, plain.width);
            assert_int_equal(weft_kernel_weights_nd(&round, 1, positions[c], b, same), count);
            assert_memory_equal(a, b, (size_t)count * sizeof *a);
            assert_memory_equal(first, same, sizeof first);
            assert_true(weft_kernel_weight(&plain, positions[c][0]) ==
                        weft_kernel_weight(&round, positions[c][0]));
        }
        kernels++;
    }
    assert_true(kernels >= 20);
    // Where it is the parameters that make h interpolate, its formula rounds.
    static const char *const names[] = {"cubic:0,0.3+radial", "cubic:0,0.7+radial"};
    for (size_t i = 0; i < WEFT_COUNT(names); i++) {
        const struct weft_kernel k = kernel_named(names[i]);
        for (int x = -2; x <= 2; x++)
            assert_near(weft_kernel_weight(&k, x), x == 0, 0.0, names[i]);
    }
}

// ---- what a radial kernel says of itself --------------------------------------------------------

static void records_are_honest(void **state)
{
    (void)state;
    struct weft_kernel k = kernel_named("catmull-rom+radial");
    assert_true(k.radial && !k.unit_sum && !k.normalised && !k.interpolating);
    assert_true(k.order == 0 && k.order_prefiltered == 0);
    k = kernel_named("catmull-rom+radial+unit");
    assert_true(k.radial && k.unit_sum && k.normalised && k.order == 1);
    assert_true(kernel_named("linear+radial").interpolating); // no diagonal neighbour is in reach
    assert_false(kernel_named("bspline+radial").interpolating);
    assert_true(weft_kernel_is_radial(&k, 2) && !weft_kernel_is_radial(&k, 1));
    // For analysis there is only what the kernel is in 1D.
    assert_true(isnan(weft_analysis_metrics(&k, 2).smoothing));
    assert_true(isnan(weft_error_e1(&k, 2, 1.0)) && !isnan(weft_error_e1(&k, 1, 1.0)));
}

// By hand at a sample of Catmull-Rom: 1 + 4 h(sqrt 2) in 2D, 1 + 12 h(sqrt 2) + 8 h(sqrt 3) in 3D.
static void sums_by_hand(void **state)
{
    (void)state;
    const struct weft_kernel k = kernel_named("catmull-rom+radial+unit"),
                             tent = kernel_named("linear+radial");
    const struct weft_kernel plain = kernel_named("catmull-rom");
    const double h2 = weft_kernel_weight(&plain, M_SQRT2);
    const double h3 = weft_kernel_weight(&plain, sqrt(3.0));
    double w[WEFT_KERNEL_MAX_WEIGHTS];
    int64_t first[3];
    const double by_hand[2] = {1.0 + 4.0 * h2, 1.0 + 12.0 * h2 + 8.0 * h3};
    for (int dims = 2; dims <= 3; dims++) {
        const struct weft_kernel round = kernel_named("catmull-rom+radial");
        const int count = weft_kernel_weights_nd(&round, dims, (double[3]){0.0}, w, first);
        assert_near(total(w, count), by_hand[dims - 2], 1e-14, "at a sample");
        const struct weft_kernel_sums sums = weft_kernel_radial_sums(&k, dims);
        assert_true(sums.least <= by_hand[dims - 2] + 1e-14 &&
                    sums.largest >= by_hand[dims - 2] - 1e-14);
        assert_int_equal(sums.least * sums.largest > 0.0, dims == 2);
    }
    assert_near(weft_kernel_radial_sums(&tent, 2).largest, 4.0 * (1.0 - sqrt(0.5)), 1e-14, "tent");
}

static void texts_go_round(void **state)
{
    (void)state;
    static const char *const cases[][2] = {
        {"catmull-rom+radial", "catmull-rom+radial"},
        {"blackman-sinc:2+radial+unit", "blackman-sinc:2+radial+unit"},
        {"blackman-sinc:2+unit+radial", "blackman-sinc:2+radial+unit"},
        {"lanczos+radial", "lanczos:3+radial"},
        {"linear+radial+unit", "linear+radial+unit"},
        {"cubic:1,0+radial", "cubic:1,0+radial"},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const struct weft_kernel k = kernel_named(cases[i][0]);
        char text[128];
        weft_kernel_format(&k, text, sizeof text);
        assert_string_equal(text, cases[i][1]);
        const struct weft_kernel back = kernel_named(text);
        assert_true(back.radial && back.normalised == k.normalised && back.order == k.order);
    }
}

static void bad_texts_are_named(void **state)
{
    (void)state;
    static const char *const cases[][2] = {
        {"lanczos+radia", "no kernel 'lanczos'"},
        {"lanczos+radial+", "no kernel 'lanczos'"},
        {"lanczos+radial+radial", "no kernel 'lanczos'"},
        {"lanczos:3+radial+unit+radial", "is not a finite number"},
        {"lanczos:3+radial,2", "is not a finite number"},
        {"cubic:0+radial,1", "is not a finite number"},
        {"d-lanczos+radial", "cannot be radial"},
        {"dd-bspline+radial+unit", "cannot be radial"},
    };
    last.count = 0;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct weft_kernel k;
        assert_int_equal(weft_kernel_parse(&keep_log, cases[i][0], &k), WEFT_ERR_ARGUMENT);
        assert_null(k.info);
        assert_said(cases[i][1]);
    }
    assert_int_equal(weft_kernel_make_radial(&keep_log, NULL), WEFT_ERR_ARGUMENT);
}

// ---- reference ----------------------------------------------------------------------------------

static double constant(void *priv, const int64_t index[3])
{
    (void)index;
    return *(const double *)priv;
}

static double impulse(void *priv, const int64_t index[3])
{
    return memcmp(index, priv, 3 * sizeof *index) == 0 ? 1.0 : 0.0;
}

static void constants_need_unit_sums(void **state)
{
    (void)state;
    double value = -3.25;
    int checked = 0, refused = 0;
    for (const struct weft_kernel_info *const *info = weft_kernel_list; *info; info++) {
        struct weft_kernel k;
        for (int dims = 1; radial(*info, true, &k) && dims <= 3; dims++) {
            if (!can_be_normalised(&k, dims)) {
                refused++;
                continue;
            }
            checked += dims > 1;
            for (size_t c = 0; c < WEFT_COUNT(positions); c++) {
                const struct weft_reference_value v =
                    weft_reference_compute(&k, dims, positions[c], constant, &value);
                assert_near(v.value, value, 1e-12, (*info)->name);
                assert_true(v.magnitude == 3.25);
            }
        }
    }
    assert_true(checked >= 10 && refused > 0);
    // Without: what the weights by hand add up to.
    const struct weft_kernel tent = kernel_named("linear+radial");
    assert_near(weft_reference_compute(&tent, 3, (double[]){0.5, 0.5, 0.5}, constant, &value).value,
                value * 8.0 * (1.0 - sqrt(0.75)), 1e-14, "tent");
    assert_near(weft_reference_compute(&tent, 1, (double[]){0.3}, constant, &value).value, value,
                1e-15, "tent in 1D");
}

static void impulses_show_the_distance(void **state)
{
    (void)state;
    int64_t origin[3] = {0, 0, 0};
    const struct weft_kernel k = kernel_named("bspline+radial");
    const double p[3] = {0.3, -0.9, 1.1};
    assert_near(weft_reference_compute(&k, 3, p, impulse, origin).value,
                weft_kernel_weight(&k, sqrt(0.09 + 0.81 + 1.21)), 1e-15, "3D");
    assert_near(weft_reference_compute(&k, 2, p, impulse, origin).value,
                weft_kernel_weight(&k, sqrt(0.9)), 1e-15, "2D");
    // Inside of the square of the taps, outside of the disc.
    const double corner[2] = {1.5, 1.5};
    assert_true(weft_reference_compute(&k, 2, corner, impulse, origin).value == 0.0);
}

// ---- tile sets ----------------------------------------------------------------------------------

static weft_kernel_tiles *make(const struct weft_kernel_tiles_params *params)
{
    struct weft_kernel_tiles_params p = *params;
    weft_kernel_tiles *set = NULL;
    p.log = &keep_log;
    if (weft_kernel_tiles_create(&p, &set) != WEFT_OK)
        fail_msg("%s", last.text);
    return set;
}

// The weight of a tap as the tiles have it, all parts added.
static double tile_weight(const weft_kernel_tiles *set, const int tap[3], const int at[3])
{
    double sum = 0.0;
    for (int part = WEFT_TILE_WHOLE; part <= WEFT_TILE_NEGATIVE; part++) {
        const int tile = weft_kernel_tiles_find(set, tap, part);
        sum += tile >= 0 ? weft_kernel_tiles_value(set, tile, at) : 0.0;
    }
    return sum;
}

// Tiles against weft_kernel_weights_nd at the sample positions, and their sums against the exact
// ones, in steps of the format.
static void check_set(const weft_kernel_tiles *set, double steps, double sum_steps)
{
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(set);
    const double step = 1.0 / (info->one * weft_kernel_tiles_get(set, 0)->scale);
    const double tolerance = steps * step + 1e-9, sum_tolerance = sum_steps * step + 1e-9;
    double w[WEFT_KERNEL_MAX_WEIGHTS];
    int at[3] = {0};
    do {
        double p[3] = {0.0}, sum = 0.0;
        int64_t first[3];
        for (int a = 0; a < info->dims; a++)
            p[a] = weft_kernel_tiles_position(set, at[a]) + (info->width % 2 ? 0.5 : 0.0);
        const int count = weft_kernel_weights_nd(&info->kernel, info->dims, p, w, first);
        int tap[3] = {0};
        for (int i = 0; i < count; i++, next_position(info->dims, info->width, tap)) {
            const double tile = tile_weight(set, tap, at);
            if (i % 13 == 0)
                assert_near(weft_kernel_tiles_exact(set, tap, at), w[i], 1e-12, "exact");
            assert_near(tile, w[i], tolerance, info->kernel.info->name);
            sum += tile;
        }
        assert_near(sum, total(w, count), sum_tolerance, "sum");
    } while (next_position(info->dims, info->samples, at));
}

static void tiles_hold_the_weights(void **state)
{
    (void)state;
    static const char *const names[] = {"linear+radial", "catmull-rom+radial",
                                        "bspline2+radial+unit", "blackman-sinc:2+radial+unit",
                                        "lanczos:2.5+radial"};
    for (size_t i = 0; i < WEFT_COUNT(names); i++) {
        for (int c = 0; c < 8; c++) {
            struct weft_kernel_tiles_params p =
                *weft_kernel_tiles_params(.kernel = kernel_named(names[i]), .dims = 2 + c % 2,
                                          .samples = 6 + c / 2 % 2, .scaling = WEFT_TILE_SCALE_SET,
                                          .store_all = !(c / 4));
            // Half a step of 255, and the sums of so many; floats keep 24 bits.
            weft_kernel_tiles *set = make(&p);
            assert_int_equal(weft_kernel_tiles_get_info(set)->mirrored, c / 4);
            check_set(set, 0.5, INFINITY);
            weft_kernel_tiles_destroy(&set);
            p.format = WEFT_TILE_FLOAT;
            p.scaling = WEFT_TILE_UNSCALED;
            set = make(&p);
            check_set(set, 0x1p-24, 1e-6);
            weft_kernel_tiles_destroy(&set);
            p.format = WEFT_TILE_SNORM;
            p.bits = 16;
            p.scaling = WEFT_TILE_SCALE_SET;
            p.rounding = WEFT_TILE_TRUNCATED;
            set = make(&p);
            check_set(set, 1.0, INFINITY);
            weft_kernel_tiles_destroy(&set);
        }
    }
}

// The sum of a position is its exact sum, rounded to a step of 255: 1 where it is normalised.
static void sums_are_preserved(void **state)
{
    (void)state;
    static const char *const names[] = {"linear+radial", "bspline+radial", "bspline+radial+unit",
                                        "blackman-sinc:2+radial+unit"};
    int exact = 0, rounded = 0;
    for (size_t i = 0; i < WEFT_COUNT(names); i++) {
        for (int dims = 2; dims <= 3; dims++) {
            for (int samples = 7; samples <= 8; samples++) {
                const struct weft_kernel k = kernel_named(names[i]);
                weft_kernel_tiles *set =
                    make(weft_kernel_tiles_params(.kernel = k, .dims = dims, .samples = samples,
                                                  .scaling = WEFT_TILE_SCALE_SET,
                                                  .rounding = WEFT_TILE_SUM_PRESERVING));
                // 1 is a whole number of steps if the scale is.
                const bool whole = k.normalised && weft_kernel_tiles_get(set, 0)->scale >= 1.0;
                check_set(set, 1.0, whole ? 0.0 : 0.5);
                *(whole ? &exact : &rounded) += 1;
                weft_kernel_tiles_destroy(&set);
            }
        }
    }
    assert_true(exact > 0 && rounded > 0);
}

// At the ends of tiles too, where some of these jump.
static void tiles_are_symmetric(void **state)
{
    (void)state;
    static const char *const names[] = {"rect-sinc:2", "gaussian", "welch-sinc:2.5", "nearest"};
    for (size_t i = 0; i < WEFT_COUNT(names); i++) {
        for (int dims = 2; dims <= 3; dims++) {
            struct weft_kernel k = kernel_named(names[i]);
            assert_int_equal(weft_kernel_make_radial(NULL, &k), WEFT_OK);
            weft_kernel_tiles *set = make(
                weft_kernel_tiles_params(.kernel = k, .dims = dims, .samples = 6, .store_all = true,
                                         .placement = WEFT_TILE_ENDS, .format = WEFT_TILE_FLOAT));
            int at[3] = {0};
            do {
                int tap[3] = {0};
                do {
                    // Along the first axis, and with the first two swapped.
                    const int back[3] = {5 - at[0], at[1], at[2]}, swap[3] = {at[1], at[0], at[2]};
                    const int tap_back[3] = {k.width - 1 - tap[0], tap[1], tap[2]};
                    const int tap_swap[3] = {tap[1], tap[0], tap[2]};
                    const double w = weft_kernel_tiles_exact(set, tap, at);
                    assert_true(w == weft_kernel_tiles_exact(set, tap_back, back));
                    assert_true(w == weft_kernel_tiles_exact(set, tap_swap, swap));
                    assert_true((double)(float)w == tile_weight(set, tap, at));
                } while (next_position(dims, k.width, tap));
            } while (next_position(dims, 6, at));
            weft_kernel_tiles_destroy(&set);
        }
    }
}

// ---- refusals -----------------------------------------------------------------------------------

static void what_needs_products_refuses(void **state)
{
    (void)state;
    const struct weft_kernel k = kernel_named("bspline+radial");
    struct weft_error_kernel error, plain;
    last.count = 0;
    struct weft_error_kernel_params p = {.kernel = k, .dims = 2, .locations = 16, .log = &keep_log};
    for (p.dims = 2; p.dims <= 3; p.dims++) {
        assert_int_equal(weft_error_kernel_compute(&p, &error), WEFT_ERR_UNSUPPORTED);
        assert_said("bspline is radial");
    }
    p.dims = 1;
    assert_int_equal(weft_error_kernel_compute(&p, &error), WEFT_OK);
    p.kernel = kernel_named("bspline");
    assert_int_equal(weft_error_kernel_compute(&p, &plain), WEFT_OK);
    assert_memory_equal(&error, &plain, sizeof error);

    weft_kernel_tiles *set = make(weft_kernel_tiles_params(.kernel = k, .samples = 4));
    struct weft_tile_error tile_error;
    const struct weft_tile_error_params tile_params = {.tiles = set, .log = &keep_log};
    assert_int_equal(weft_tile_error_model(&tile_params, &tile_error), WEFT_ERR_UNSUPPORTED);
    assert_said("bspline is radial");
    weft_kernel_tiles_destroy(&set);

    // No tap is within 1/2 of the middle between four.
    const struct weft_kernel_tiles_params empty =
        *weft_kernel_tiles_params(.kernel = kernel_named("nearest+radial+unit"), .samples = 4,
                                  .log = &keep_log);
    assert_int_equal(weft_kernel_tiles_create(&empty, &set), WEFT_ERR_ARGUMENT);
    assert_said("kernel nearest add up to 0 to 1 in 2D");
    struct weft_kernel_tiles_params lobes =
        *weft_kernel_tiles_params(.kernel = kernel_named("catmull-rom+radial+unit"), .samples = 4,
                                  .dims = 3, .log = &keep_log);
    assert_int_equal(weft_kernel_tiles_create(&lobes, &set), WEFT_ERR_ARGUMENT);
    assert_said("cannot be divided by their sum");
    lobes.dims = 2;
    lobes.scaling = WEFT_TILE_SCALE_SET;
    assert_int_equal(weft_kernel_tiles_create(&lobes, &set), WEFT_OK);
    weft_kernel_tiles_destroy(&set);

    const float voxel[8] = {0};
    weft_volume *volume = NULL;
    weft_slice_plan *plan = NULL;
    assert_int_equal(
        weft_volume_create(weft_volume_params(.size = {2, 2, 2}, .data = voxel), &volume), WEFT_OK);
    const struct weft_slice_params slice = {.kernel = k, .log = &keep_log};
    assert_int_equal(weft_slice_plan_create(volume, &slice, &plan), WEFT_ERR_UNSUPPORTED);
    assert_null(plan);
    assert_said("kernel bspline is radial");
    weft_volume_destroy(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(weights_by_hand),
        cmocka_unit_test(weights_are_of_the_distance),
        cmocka_unit_test(equal_distances_weigh_the_same),
        cmocka_unit_test(separable_weights_are_products),
        cmocka_unit_test(one_dimension_is_unchanged),
        cmocka_unit_test(records_are_honest),
        cmocka_unit_test(sums_by_hand),
        cmocka_unit_test(texts_go_round),
        cmocka_unit_test(bad_texts_are_named),
        cmocka_unit_test(constants_need_unit_sums),
        cmocka_unit_test(impulses_show_the_distance),
        cmocka_unit_test(tiles_hold_the_weights),
        cmocka_unit_test(sums_are_preserved),
        cmocka_unit_test(tiles_are_symmetric),
        cmocka_unit_test(what_needs_products_refuses),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
