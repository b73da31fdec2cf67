// SPDX-License-Identifier: BSD-3-Clause
// Tile sets with derivatives along the axes, and the limit of their scales.
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

static const char *named(const struct weft_derivative *derivative)
{
    static char text[WEFT_DERIVATIVE_TEXT];
    return weft_derivative_format(derivative, text);
}

static weft_kernel_tiles *make(const struct weft_kernel_tiles_params *params)
{
    weft_kernel_tiles *set = NULL;
    struct weft_kernel_tiles_params p = *params;
    p.log = &log_to_stderr;
    if (weft_kernel_tiles_create(&p, &set) != WEFT_OK)
        fail_msg("%s, %dD, derivative %s, M %d, format %d, %d bits", p.kernel.info->name, p.dims,
                 named(&p.derivative), p.samples, (int)p.format, p.bits);
    return set;
}

// ---- a grid of sets over the catalogue ----------------------------------------------------------

// The record of h' or h'' by its name, and not as the set finds it.
static const struct weft_kernel_info *find_derived(const struct weft_kernel_info *info, int times)
{
    char name[40];
    snprintf(name, sizeof name, "%s%s", times == 2 ? "dd-" : "d-", info->name);
    return info->derivation ? NULL : weft_kernel_find(name);
}

static const struct weft_kernel_info *find_slope(const struct weft_kernel_info *info)
{
    return find_derived(info, 1);
}

static bool has(const struct weft_kernel_info *info, const struct weft_derivative *d)
{
    for (int a = 0; a < 3; a++)
        if (d->along[a] && !find_derived(info, d->along[a]))
            return false;
    return true;
}

static const struct {
    enum weft_tile_format format;
    int bits;
} formats[] = {{WEFT_TILE_UNORM, 8},  {WEFT_TILE_UNORM, 5}, {WEFT_TILE_UNORM, 12},
               {WEFT_TILE_UNORM, 16}, {WEFT_TILE_SNORM, 8}, {WEFT_TILE_SNORM, 16},
               {WEFT_TILE_HALF, 0},   {WEFT_TILE_FLOAT, 0}};

struct span {
    int first, count;
};
static const struct span all_formats = {0, 8}, integer_formats = {0, 6}, signed_formats = {4, 4},
                         only_float = {7, 1};

typedef void check_set(const struct weft_kernel_tiles_params *params, const char *what);

// Ordinary kernels up to 6 wide, along every axis and in both placements, with the formats in turn.
// M is even or odd.
// A third of the derivatives of each kernel, others for the next one; all with WEFT_TILES=full.
static bool is_wanted(int kernel, int i)
{
    const char *size = getenv("WEFT_TILES");
    return (size && strcmp(size, "full") == 0) || (i + kernel) % 3 == 0;
}

static void over_the_catalogue(check_set *check, struct weft_kernel_tiles_params p,
                               struct span among)
{
    int i = 0, kernels = 0, sets = 0;
    for (const struct weft_kernel_info *const *k = weft_kernel_list; *k; k++) {
        p.kernel = kernel_named((*k)->name);
        if (!find_slope(*k) || p.kernel.width > 6)
            continue;
        kernels++;
        for (p.dims = 2; p.dims <= 3; p.dims++) {
            for (int n = 1; derivative_in(p.dims, n); n++, i++) {
                p.derivative = derivative_named(derivative_in(p.dims, n));
                if (!has(*k, &p.derivative))
                    continue;
                sets++;
                if (!is_wanted(kernels, i))
                    continue;
                for (p.placement = WEFT_TILE_CENTRES; p.placement <= WEFT_TILE_ENDS;
                     p.placement++) {
                    const int f = among.first + (i + 3 * (int)p.placement) % among.count;
                    p.format = formats[f].format;
                    p.bits = formats[f].bits;
                    p.samples = (p.dims == 2 ? 8 : 4) + (i % 3 == 1);
                    char what[128];
                    snprintf(what, sizeof what,
                             "%s, %dD, derivative %s, M %d, format %d, %d bits, ends %d",
                             (*k)->name, p.dims, named(&p.derivative), p.samples, (int)p.format,
                             p.bits, (int)p.placement);
                    check(&p, what);
                }
            }
        }
    }
    assert_int_equal(kernels, 25);
    assert_true(sets > 25 * (2 + 3 + 1 + 3) && sets <= 25 * (5 + 9)); // first, mixed; some second
}

// ---- weights ------------------------------------------------------------------------------------

// h or h' at a position of a tap's tile, at its end the limit from inside.
static double axis_weight(const struct weft_kernel *kernel, double position, int tap)
{
    const double shift = weft_kernel_offset(kernel) - tap;
    const double x = fmin(position, 1.0 - 0x1p-53) + shift;
    return weft_kernel_weight(kernel, fmin(x, nextafter(shift + 1.0, -INFINITY)));
}

// What all taps should weigh, [z][y][x]; returns their sum.
static double expect(const weft_kernel_tiles *set, const int at[3], double *weights)
{
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(set);
    struct weft_kernel derived[3] = {info->kernel};
    for (int times = 1; times <= 2; times++) {
        const struct weft_kernel_info *record = find_derived(info->kernel.info, times);
        if (record)
            assert_int_equal(weft_kernel_create(NULL, record, info->kernel.param, &derived[times]),
                             WEFT_OK);
    }
    int tap[3] = {0}, i = 0;
    double sum = 0.0;
    do {
        double w = 1.0;
        for (int a = 0; a < info->dims; a++)
            w *= axis_weight(&derived[info->derivative.along[a]],
                             weft_kernel_tiles_position(set, at[a]), tap[a]);
        weights[i++] = w;
        sum += w;
    } while (next_position(info->dims, info->width, tap));
    return sum;
}

static size_t tap_index(const struct weft_kernel_tiles_info *info, const int tap[3])
{
    return (size_t)((tap[2] * info->width + tap[1]) * info->width + tap[0]);
}

// What the tiles of all taps add up to, the least scale of each tap's, and the sum of integers.
struct found {
    double weight[216], scale[216];
    int64_t integers;
};

static void survey(const weft_kernel_tiles *set, const int at[3], struct found *out)
{
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(set);
    *out = (struct found){.integers = 0};
    for (int t = 0; t < info->tile_count; t++) {
        const struct weft_kernel_tile *tile = weft_kernel_tiles_get(set, t);
        const size_t i = tap_index(info, tile->tap);
        const double scale = out->scale[i] > 0.0 ? out->scale[i] : (double)INFINITY;
        out->weight[i] += weft_kernel_tiles_value(set, t, at);
        out->scale[i] = fmin(scale, tile->scale);
        if (info->format <= WEFT_TILE_SNORM)
            out->integers += weft_kernel_tiles_integer(set, t, at);
    }
}

// Half a step of the format at a weight. Values within 1e-9 of an integer count as one; at the ends
// exact weights are made even or odd to the last bit, of 1.
static double half_step(const struct weft_kernel_tiles_info *info, double weight, double scale)
{
    if (info->format == WEFT_TILE_FLOAT)
        return 0x1p-24 * fabs(weight) + 1e-15;
    if (info->format == WEFT_TILE_HALF)
        return 0x1p-11 * fabs(weight) + 0x1p-25 / scale;
    return (0.5 + 1e-9) / (info->one * scale);
}

static void assert_products(const struct weft_kernel_tiles_params *params, const char *what)
{
    weft_kernel_tiles *set = make(params);
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(set);
    assert_memory_equal(&info->derivative, &params->derivative, sizeof info->derivative);
    int at[3] = {0};
    do {
        double expected[216];
        struct found found;
        expect(set, at, expected);
        survey(set, at, &found);
        int tap[3] = {0}, i = 0;
        do {
            // A tap without tiles weighs nothing.
            const double w = expected[i], scale = found.scale[i];
            assert_near(weft_kernel_tiles_exact(set, tap, at), w, 1e-13, what);
            assert_near(found.weight[i++], w, scale > 0.0 ? half_step(info, w, scale) : 1e-13,
                        what);
        } while (next_position(info->dims, info->width, tap));
    } while (next_position(info->dims, info->samples, at));
    weft_kernel_tiles_destroy(&set);
}

static void weights_are_products_with_one_slope(void **state)
{
    (void)state;
    const enum weft_tile_scaling scalings[] = {WEFT_TILE_SCALE_SET, WEFT_TILE_SCALE_EACH};
    for (int i = 0; i < 4; i++)
        over_the_catalogue(assert_products,
                           *weft_kernel_tiles_params(.scaling = scalings[i % 2],
                                                     .store_all = !(i / 2), .exact_scale = i == 1),
                           all_formats);
}

// Slopes of kernels whose weights add up to one add up to zero, without any ripple; of the others,
// to what the exact ones do, rounded.
static void assert_sums(const struct weft_kernel_tiles_params *params, const char *what)
{
    weft_kernel_tiles *set = make(params);
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(set);
    int at[3] = {0};
    do {
        double expected[216];
        struct found found;
        const double sum = expect(set, at, expected);
        survey(set, at, &found);
        const double total = sum * info->one * weft_kernel_tiles_get(set, 0)->scale;
        // A total half way between integers may go either way by the last digit of the sum.
        assert_near((double)found.integers, total, 0.5 + 1e-6, what);
        if (info->kernel.unit_sum)
            assert_int_equal(found.integers, 0);
        for (int i = 0; i < (int)pow(info->width, info->dims); i++)
            if (found.scale[i] > 0.0)
                assert_near(found.weight[i], expected[i],
                            2.0 * half_step(info, expected[i], found.scale[i]), what);
    } while (next_position(info->dims, info->samples, at));
    weft_kernel_tiles_destroy(&set);
}

static void sum_preserving_slopes_add_up_exactly(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++)
        over_the_catalogue(assert_sums,
                           *weft_kernel_tiles_params(.rounding = WEFT_TILE_SUM_PRESERVING,
                                                     .scaling = WEFT_TILE_SCALE_SET,
                                                     .store_all = !(i % 2), .exact_scale = i / 2),
                           integer_formats);
}

// On a ramp along the axis the slope is 1, on one across it, and on a constant, 0. Kernels of order
// 2 or more reproduce ramps.
static void assert_ramps(const struct weft_kernel_tiles_params *params, const char *what)
{
    weft_kernel_tiles *set = make(params);
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(set);
    const int order = weft_derivative_order(&info->derivative);
    int at[3] = {0};
    do {
        struct found found;
        survey(set, at, &found);
        double constant = 0.0, ramp[3] = {0.0};
        int tap[3] = {0}, i = 0;
        do {
            constant += found.weight[i];
            for (int a = 0; a < info->dims; a++)
                ramp[a] += found.weight[i] * (tap[a] - 0.5 * info->width);
            i++;
        } while (next_position(info->dims, info->width, tap));
        assert_near(constant, 0.0, info->kernel.unit_sum ? 1e-6 : INFINITY, what);
        for (int a = 0; a < info->dims && info->kernel.order >= 2; a++)
            assert_near(ramp[a], order == 1 && info->derivative.along[a], 4e-6, what);
    } while (next_position(info->dims, info->samples, at));
    weft_kernel_tiles_destroy(&set);
}

static void ramps_have_their_slope(void **state)
{
    (void)state;
    over_the_catalogue(assert_ramps, *weft_kernel_tiles_params(.dims = 2), only_float);
}

// In 1D the set is that of the derivative's own record.
static void in_1d_it_is_the_derivative(void **state)
{
    (void)state;
    int kernels = 0;
    for (const struct weft_kernel_info *const *k = weft_kernel_list; *k; k++) {
        if (!find_slope(*k))
            continue;
        struct weft_kernel_tiles_params p =
            *weft_kernel_tiles_params(.kernel = kernel_named((*k)->name), .dims = 1, .samples = 13,
                                      .derivative = derivative_named("x"),
                                      .scaling = WEFT_TILE_SCALE_EACH);
        weft_kernel_tiles *a = make(&p);
        p.kernel = kernel_named(find_slope(*k)->name);
        p.derivative = derivative_named("none");
        weft_kernel_tiles *b = make(&p);
        const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(a);
        assert_int_equal(info->tile_count, weft_kernel_tiles_get_info(b)->tile_count);
        assert_int_equal(info->stored_count, weft_kernel_tiles_get_info(b)->stored_count);
        for (int t = 0; t < info->tile_count; t++)
            for (int i = 0; i < 13; i++)
                assert_true(weft_kernel_tiles_value(a, t, (const int[3]){i}) ==
                            weft_kernel_tiles_value(b, t, (const int[3]){i}));
        weft_kernel_tiles_destroy(&a);
        weft_kernel_tiles_destroy(&b);
        kernels++;
    }
    assert_true(kernels >= 25); // those up to 6 wide, and wider ones
}

// ---- mirroring ----------------------------------------------------------------------------------

static void assert_mirrored(const struct weft_kernel_tiles_params *params, const char *what)
{
    struct weft_kernel_tiles_params p = *params;
    weft_kernel_tiles *mirrored = make(&p);
    p.store_all = true;
    weft_kernel_tiles *whole = make(&p);
    const struct weft_kernel_tiles_info *m = weft_kernel_tiles_get_info(mirrored);
    const struct weft_kernel_tiles_info *w = weft_kernel_tiles_get_info(whole);
    assert_true(m->mirrored && !w->mirrored);
    assert_int_equal(m->tile_count, w->tile_count);
    assert_int_equal(w->stored_count, w->tile_count);
    assert_true(m->stored_count < w->stored_count);
    assert_int_equal(m->memory_bytes + m->saved_bytes, w->memory_bytes);
    for (int t = 0; t < m->tile_count; t++) {
        const struct weft_kernel_tile *a = weft_kernel_tiles_get(mirrored, t);
        const struct weft_kernel_tile *b = weft_kernel_tiles_get(whole, t);
        assert_memory_equal(a->tap, b->tap, sizeof a->tap);
        assert_int_equal(a->part, b->part);
        assert_true(a->scale == b->scale && a->minimum == b->minimum && a->maximum == b->maximum);
        int at[3] = {0};
        do {
            assert_near(weft_kernel_tiles_value(mirrored, t, at),
                        weft_kernel_tiles_value(whole, t, at), 0.0, what);
        } while (next_position(m->dims, m->samples, at));
    }
    weft_kernel_tiles_destroy(&mirrored);
    weft_kernel_tiles_destroy(&whole);
}

static void mirrored_fetch_equals_unmirrored(void **state)
{
    (void)state;
    const enum weft_tile_scaling scalings[] = {WEFT_TILE_SCALE_SET, WEFT_TILE_SCALE_EACH};
    for (int i = 0; i < 6; i++) {
        struct weft_kernel_tiles_params p =
            *weft_kernel_tiles_params(.scaling = scalings[i % 2], .signs = i / 2);
        const struct span among = p.signs == WEFT_TILE_SIGNED ? signed_formats : all_formats;
        over_the_catalogue(assert_mirrored, p, among);
        p.rounding = WEFT_TILE_TRUNCATED;
        over_the_catalogue(assert_mirrored, p, among);
    }
}

// By hand: the tent, M = 4, at (0.625, 0.625). h' is -1 in tap 0 and 1 in tap 1, h is 0.375 and
// 0.625, of 255: 95.6 and 159.4. Only tap (0, 0) is stored; along the slope its sign flips.
static void a_set_by_hand(void **state)
{
    (void)state;
    const struct {
        const char *derivative;
        int tap[3];
        enum weft_tile_part part;
        bool mirrored[3];
        int value;
    } cases[] = {
        {"x", {0, 0}, WEFT_TILE_NEGATIVE, {false, false}, -96},
        {"x", {1, 0}, WEFT_TILE_POSITIVE, {true, false}, 96},
        {"x", {0, 1}, WEFT_TILE_NEGATIVE, {false, true}, -159},
        {"x", {1, 1}, WEFT_TILE_POSITIVE, {true, true}, 159},
        {"y", {0, 0}, WEFT_TILE_NEGATIVE, {false, false}, -96},
        {"y", {1, 0}, WEFT_TILE_NEGATIVE, {true, false}, -159},
        {"y", {0, 1}, WEFT_TILE_POSITIVE, {false, true}, 96},
        {"y", {1, 1}, WEFT_TILE_POSITIVE, {true, true}, 159},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        weft_kernel_tiles *set =
            make(weft_kernel_tiles_params(.kernel = kernel_named("linear"), .samples = 4,
                                          .derivative = derivative_named(cases[i].derivative)));
        assert_int_equal(weft_kernel_tiles_get_info(set)->tile_count, 4);
        assert_int_equal(weft_kernel_tiles_get_info(set)->stored_count, 1);
        const int t = weft_kernel_tiles_find(set, cases[i].tap, cases[i].part);
        assert_true(t >= 0);
        const struct weft_kernel_tile *tile = weft_kernel_tiles_get(set, t);
        assert_memory_equal(tile->mirrored, cases[i].mirrored, sizeof tile->mirrored);
        assert_int_equal(tile->negated, cases[i].value < 0);
        assert_int_equal(weft_kernel_tiles_integer(set, t, (const int[3]){2, 2}), cases[i].value);
        weft_kernel_tiles_destroy(&set);
    }
}

// ---- splitting and interleaving -----------------------------------------------------------------

static void assert_split(const struct weft_kernel_tiles_params *params, const char *what)
{
    weft_kernel_tiles *set = make(params), *before = make(params);
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(set);
    const int count = info->tile_count;
    for (int t = 0; t < count; t += 5) {
        const int low = info->tile_count;
        assert_int_equal(weft_kernel_tiles_split(set, t, NAN), WEFT_OK);
        int at[3] = {0};
        do {
            const double a = weft_kernel_tiles_value(set, t, at);
            const double b = weft_kernel_tiles_value(set, low, at);
            assert_true(a == 0.0 || b == 0.0);
            assert_near(a + b, weft_kernel_tiles_value(before, t, at), 0.0, what);
        } while (next_position(info->dims, info->samples, at));
    }
    // Those that shared its memory are as they were.
    for (int t = 0; t < count; t++) {
        int at[3] = {0};
        do {
            if (t % 5 != 0)
                assert_near(weft_kernel_tiles_value(set, t, at),
                            weft_kernel_tiles_value(before, t, at), 0.0, what);
        } while (next_position(info->dims, info->samples, at));
    }
    weft_kernel_tiles_destroy(&set);
    weft_kernel_tiles_destroy(&before);
}

static void split_parts_add_up_exactly(void **state)
{
    (void)state;
    over_the_catalogue(assert_split, *weft_kernel_tiles_params(.scaling = WEFT_TILE_SCALE_EACH),
                       all_formats);
}

// ---- the error of a set -------------------------------------------------------------------------

// Looked up at its own samples a set is as good as its format.
static void assert_error(const struct weft_kernel_tiles_params *params, const char *what)
{
    struct weft_kernel_tiles_params p = *params;
    p.placement = WEFT_TILE_CENTRES;
    p.samples = 8;
    weft_kernel_tiles *set = make(&p);
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(set);
    const struct weft_tile_error_params error_params = {
        .tiles = set, .lookup = WEFT_ERROR_NEAREST, .locations = 8, .log = &log_to_stderr};
    struct weft_tile_error error;
    assert_int_equal(weft_tile_error_model(&error_params, &error), WEFT_OK);
    double largest = 0.0;
    for (int t = 0; t < info->tile_count; t++)
        largest = fmax(largest, fmax(weft_kernel_tiles_get(set, t)->maximum,
                                     -weft_kernel_tiles_get(set, t)->minimum));
    const double bound =
        half_step(info, largest * (1.0 + 0x1p-10), weft_kernel_tiles_get(set, 0)->scale);
    assert_near(error.ideal.single, 0.0, bound, what);
    weft_kernel_tiles_destroy(&set);
}

static void the_error_is_that_of_slopes(void **state)
{
    (void)state;
    over_the_catalogue(assert_error, *weft_kernel_tiles_params(.scaling = WEFT_TILE_SCALE_SET),
                       all_formats);
}

// ---- scales -------------------------------------------------------------------------------------

static void no_tile_is_scaled_by_more(void **state)
{
    (void)state;
    const char *const names[] = {"linear", "blackman-sinc:3", "bspline5", "gaussian"};
    const enum weft_tile_scaling scalings[] = {WEFT_TILE_SCALE_SET, WEFT_TILE_SCALE_EACH};
    const double limits[] = {0x1p-3, 0.5, 1.0, 2.0, 16.0, 0x1p40};
    for (int i = 0; i < (int)(4 * WEFT_COUNT(names)); i++) {
        struct weft_kernel_tiles_params p =
            *weft_kernel_tiles_params(.kernel = kernel_named(names[i / 4]), .samples = 9,
                                      .exact_scale = i / 2 % 2, .scaling = scalings[i % 2],
                                      .derivative = {{i % 3 == 1, i % 3 == 2, 0}});
        weft_kernel_tiles *free_set = make(&p);
        for (size_t l = 0; l < WEFT_COUNT(limits); l++) {
            p.max_scale = limits[l];
            weft_kernel_tiles *set = make(&p);
            const int count = weft_kernel_tiles_get_info(set)->tile_count;
            assert_int_equal(count, weft_kernel_tiles_get_info(free_set)->tile_count);
            for (int t = 0; t < count; t++)
                assert_true(weft_kernel_tiles_get(set, t)->scale ==
                            fmin(weft_kernel_tiles_get(free_set, t)->scale, limits[l]));
            int at[3] = {0};
            do {
                for (int t = 0; t < count; t++) {
                    const struct weft_kernel_tile *tile = weft_kernel_tiles_get(set, t);
                    const double w = weft_kernel_tiles_exact(set, tile->tap, at);
                    const bool other_part = (tile->part == WEFT_TILE_NEGATIVE) != (w < 0.0);
                    assert_near(weft_kernel_tiles_value(set, t, at), other_part ? 0.0 : w,
                                (0.5 + 1e-9) / (255.0 * tile->scale), names[i / 4]);
                }
            } while (next_position(2, 9, at));
            weft_kernel_tiles_destroy(&set);
        }
        weft_kernel_tiles_destroy(&free_set);
    }
}

// ---- bad requests -------------------------------------------------------------------------------

static double tent(const struct weft_kernel *k, double x)
{
    (void)k;
    return fmax(0.0, 1.0 - fabs(x));
}

static double tent_slope(const struct weft_kernel *k, double x)
{
    (void)k;
    return x >= -1.0 && x < 1.0 ? x < 0.0 ? 1.0 : -1.0 : 0.0;
}

static void bad_arguments_are_named(void **state)
{
    (void)state;
    const struct weft_kernel_info users = {.name = "users",
                                           .radius = 1.0,
                                           .weight = tent,
                                           .derivative = tent_slope,
                                           .degree = 1,
                                           .unit_sum = true};
    struct weft_kernel own;
    assert_int_equal(weft_kernel_create(NULL, &users, NULL, &own), WEFT_OK);
    const struct weft_kernel cubic = kernel_named("catmull-rom");
    const struct {
        struct weft_kernel_tiles_params *params;
        enum weft_result expected;
        const char *text, *more;
    } cases[] = {
#define BAD(result, text, more, ...)                                                               \
    {weft_kernel_tiles_params(.kernel = cubic, __VA_ARGS__), result, text, more}
        BAD(WEFT_ERR_ARGUMENT, "no derivative in 2D", "1 along z", .derivative = {{0, 0, 1}}),
        BAD(WEFT_ERR_ARGUMENT, "no derivative in 1D", "1 along y", .derivative = {{0, 1, 0}},
            .dims = 1),
        BAD(WEFT_ERR_ARGUMENT, "no derivative in 3D", "3 times along x", .derivative = {{3, 0, 0}},
            .dims = 3),
        BAD(WEFT_ERR_ARGUMENT, "no derivative in 3D", "1 along y", .derivative = {{1, 1, 1}},
            .dims = 3),
        BAD(WEFT_ERR_ARGUMENT, "no derivative in 2D", "-1 times", .derivative = {{-1, 0, 0}}),
        BAD(WEFT_ERR_ARGUMENT, "derivative", "to 0, not to 1", .derivative = {{1, 0, 0}},
            .normalise = true),
        BAD(WEFT_ERR_ARGUMENT, "kernel nearest", "no record of its derivative",
            .derivative = {{1, 0, 0}}, .kernel = kernel_named("nearest")),
        BAD(WEFT_ERR_ARGUMENT, "kernel dd-bspline", "no record of its derivative",
            .derivative = {{1, 0, 0}}, .kernel = kernel_named("dd-bspline")),
        BAD(WEFT_ERR_ARGUMENT, "kernel users", "no record of its derivative",
            .derivative = {{1, 0, 0}}, .kernel = own),
        BAD(WEFT_ERR_ARGUMENT, "kernel lanczos", "divided by the sum", .derivative = {{0, 1, 0}},
            .kernel = kernel_named("lanczos:3+unit")),
        BAD(WEFT_ERR_UNSUPPORTED, "kernel catmull-rom", "radial", .derivative = {{1, 0, 0}},
            .kernel = kernel_named("catmull-rom+radial")),
        BAD(WEFT_ERR_ARGUMENT, "d-catmull-rom", "over 1: scale them", .derivative = {{1, 0, 0}}),
        BAD(WEFT_ERR_ARGUMENT, "d-bspline", "weights down to -0.4", .derivative = {{1, 0, 0}},
            .signs = WEFT_TILE_SIGNED, .kernel = kernel_named("bspline")),
        BAD(WEFT_ERR_ARGUMENT, "power of two", "not 3", .max_scale = 3.0),
        BAD(WEFT_ERR_ARGUMENT, "power of two", "not -2", .max_scale = -2.0),
        BAD(WEFT_ERR_ARGUMENT, "power of two", "inf", .max_scale = INFINITY),
        BAD(WEFT_ERR_ARGUMENT, "power of two", "nan", .max_scale = NAN),
        BAD(WEFT_ERR_ARGUMENT, "power of two", "not 0.3", .max_scale = 0.3, .exact_scale = true,
            .scaling = WEFT_TILE_SCALE_EACH),
#undef BAD
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct message message = {.count = 0};
        struct weft_log log = {keep_message, &message};
        weft_kernel_tiles *set = NULL;
        cases[i].params->log = &log;
        if (weft_kernel_tiles_create(cases[i].params, &set) != cases[i].expected || set ||
            message.count != 1 || !strstr(message.text, cases[i].text) ||
            !strstr(message.text, cases[i].more))
            fail_msg("case %d: %d messages, last '%s'", (int)i, message.count, message.text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_set_by_hand),
        cmocka_unit_test(weights_are_products_with_one_slope),
        cmocka_unit_test(sum_preserving_slopes_add_up_exactly),
        cmocka_unit_test(ramps_have_their_slope),
        cmocka_unit_test(in_1d_it_is_the_derivative),
        cmocka_unit_test(mirrored_fetch_equals_unmirrored),
        cmocka_unit_test(split_parts_add_up_exactly),
        cmocka_unit_test(the_error_is_that_of_slopes),
        cmocka_unit_test(no_tile_is_scaled_by_more),
        cmocka_unit_test(bad_arguments_are_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
