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
#include "tests/support/samples.h"
#include "weft.h"

static weft_kernel_tiles *make(const struct weft_kernel_tiles_params *params)
{
    weft_kernel_tiles *set = NULL;
    struct weft_kernel_tiles_params p = *params;
    p.log = p.log ? p.log : &log_to_stderr;
    if (weft_kernel_tiles_create(&p, &set) != WEFT_OK)
        fail_msg("%s, %dD, M %d, format %d, %d bits", p.kernel.info->name, p.dims, p.samples,
                 (int)p.format, p.bits);
    return set;
}

// ---- a grid of sets over the whole catalogue ----------------------------------------------------

// All samples where they are few, else a lattice through them that has the ends.
static int step_of(int samples)
{
    return samples > 9 ? samples / 5 : 1;
}

static const struct {
    enum weft_tile_format format;
    int bits;
} formats[] = {{WEFT_TILE_UNORM, 4},  {WEFT_TILE_UNORM, 7},  {WEFT_TILE_UNORM, 8},
               {WEFT_TILE_UNORM, 12}, {WEFT_TILE_UNORM, 16}, {WEFT_TILE_SNORM, 8},
               {WEFT_TILE_SNORM, 16}, {WEFT_TILE_HALF, 0},   {WEFT_TILE_FLOAT, 0}};

// M for every dimension: odd and even, small where taps are many.
static int samples_of(int dims, int width, int i)
{
    static const int samples[3][2] = {{64, 33}, {16, 7}, {6, 3}};
    return dims == 3 && width > 6 ? 2 + i % 2 : samples[dims - 1][i % 2];
}

typedef void check_set(const weft_kernel_tiles *set, const char *what);

static void over_the_catalogue(check_set *check, struct weft_kernel_tiles_params base, bool integer)
{
    int i = 0;
    for (const struct weft_kernel_info *const *k = weft_kernel_list; *k; k++) {
        for (int dims = 1; dims <= 3; dims++) {
            for (size_t f = 0; f < WEFT_COUNT(formats); f++, i++) {
                if (integer && formats[f].format >= WEFT_TILE_HALF)
                    continue;
                struct weft_kernel_tiles_params p = base;
                p.kernel = kernel_named((*k)->name);
                p.dims = dims;
                p.samples = samples_of(dims, p.kernel.width, i);
                p.format = formats[f].format;
                p.bits = formats[f].bits;
                p.placement = i / 2 % 2 ? WEFT_TILE_ENDS : WEFT_TILE_CENTRES;
                p.exact_scale = i / 4 % 2;
                char what[128];
                snprintf(what, sizeof what, "%s, %dD, M %d, format %d, %d bits, ends %d",
                         (*k)->name, dims, p.samples, (int)p.format, p.bits, (int)p.placement);
                weft_kernel_tiles *set = make(&p);
                check(set, what);
                weft_kernel_tiles_destroy(&set);
            }
        }
    }
}

static size_t tap_index(const struct weft_kernel_tiles_info *info, const int tap[3])
{
    return (size_t)((tap[2] * info->width + tap[1]) * info->width + tap[0]);
}

static size_t tap_count(const struct weft_kernel_tiles_info *info)
{
    size_t count = 1;
    for (int a = 0; a < info->dims; a++)
        count *= (size_t)info->width;
    return count;
}

// The weights of all taps at a position; sum and largest error go out.
static double survey(const weft_kernel_tiles *set, const int position[3], double *weight,
                     double *exact_sum, int64_t *integer_sum)
{
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(set);
    memset(weight, 0, tap_count(info) * sizeof *weight);
    *integer_sum = 0;
    for (int t = 0; t < info->tile_count; t++) {
        weight[tap_index(info, weft_kernel_tiles_get(set, t)->tap)] +=
            weft_kernel_tiles_value(set, t, position);
        if (info->format <= WEFT_TILE_SNORM)
            *integer_sum += weft_kernel_tiles_integer(set, t, position);
    }
    int tap[3] = {0};
    double error = 0.0;
    *exact_sum = 0.0;
    do {
        const double exact = weft_kernel_tiles_exact(set, tap, position);
        *exact_sum += exact;
        error = larger(error, fabs(weight[tap_index(info, tap)] - exact));
    } while (next_position(info->dims, info->width, tap));
    return error;
}

static double smallest_scale(const weft_kernel_tiles *set)
{
    double scale = INFINITY;
    for (int t = 0; t < weft_kernel_tiles_get_info(set)->tile_count; t++)
        scale = fmin(scale, weft_kernel_tiles_get(set, t)->scale);
    return scale;
}

static double largest_weight(const weft_kernel_tiles *set)
{
    double largest = 0.0;
    for (int t = 0; t < weft_kernel_tiles_get_info(set)->tile_count; t++) {
        const struct weft_kernel_tile *tile = weft_kernel_tiles_get(set, t);
        largest = fmax(largest, fmax(-tile->minimum, tile->maximum));
    }
    return largest;
}

// The most that one weight may be off.
static double format_bound(const weft_kernel_tiles *set)
{
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(set);
    const double steps = info->rounding == WEFT_TILE_NEAREST ? 0.5 : 1.0;
    const double slack = 1e-9; // values that close to an integer count as one
    if (info->format <= WEFT_TILE_SNORM)
        return (steps + slack) / (info->one * smallest_scale(set));
    // Half an ulp of the largest weight; halves have steps of 2^-24 at the least.
    const double relative = info->format == WEFT_TILE_HALF ? 0x1p-10 : 0x1p-23;
    const double least = info->format == WEFT_TILE_HALF ? 0x1p-24 : 0.0;
    return steps * (relative * largest_weight(set) + least) * (1.0 + slack);
}

static double weights[16 * 16 * 16];

static void assert_bounded(const weft_kernel_tiles *set, const char *what)
{
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(set);
    const double bound = format_bound(set);
    int at[3] = {0};
    const int step = step_of(info->samples), steps = (info->samples - 1) / step + 1;
    int grid[3] = {0};
    do {
        double sum;
        int64_t integers;
        for (int a = 0; a < 3; a++)
            at[a] = grid[a] * step;
        const double error = survey(set, at, weights, &sum, &integers);
        if (!(error <= bound))
            fail_msg("%s: error %.9g over %.9g at (%d, %d, %d)", what, error, bound, at[0], at[1],
                     at[2]);
    } while (next_position(info->dims, steps, grid));
}

static void every_weight_is_within_its_formats_error(void **state)
{
    (void)state;
    struct weft_kernel_tiles_params p = *weft_kernel_tiles_params(.scaling = WEFT_TILE_SCALE_SET);
    over_the_catalogue(assert_bounded, p, false);
    p.rounding = WEFT_TILE_TRUNCATED;
    over_the_catalogue(assert_bounded, p, false);
}

static void assert_truncated(const weft_kernel_tiles *set, const char *what)
{
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(set);
    int at[3] = {0};
    do {
        for (int t = 0; t < info->tile_count; t++) {
            const struct weft_kernel_tile *tile = weft_kernel_tiles_get(set, t);
            const double exact = weft_kernel_tiles_exact(set, tile->tap, at);
            const double value = weft_kernel_tiles_value(set, t, at);
            if (!(fabs(value) <= fabs(exact) + 1e-9 / (info->one * tile->scale)) ||
                !(value * exact >= 0.0))
                fail_msg("%s: %.9g truncated to %.9g", what, exact, value);
        }
    } while (next_position(1, info->samples, at));
}

static void truncation_goes_towards_zero(void **state)
{
    (void)state;
    over_the_catalogue(
        assert_truncated,
        *weft_kernel_tiles_params(.rounding = WEFT_TILE_TRUNCATED, .scaling = WEFT_TILE_SCALE_EACH),
        false);
}

// The quantised weights add up to the exact total, rounded; where the exact one is 1 or 0 there is
// no ripple at all, whatever the position.
static void assert_sums(const weft_kernel_tiles *set, const char *what)
{
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(set);
    const double one = info->one * smallest_scale(set), bound = format_bound(set);
    const int step = step_of(info->samples), steps = (info->samples - 1) / step + 1;
    int grid[3] = {0};
    do {
        double sum;
        int64_t integers;
        const int at[3] = {grid[0] * step, grid[1] * step, grid[2] * step};
        const double error = survey(set, at, weights, &sum, &integers);
        // A total half way between integers may go either way by the last digit of the sum.
        const double total = sum * one, off = fabs((double)integers - total);
        if (!(off <= 0.5 + 1e-6) || !(error <= bound))
            fail_msg("%s: sum %d instead of %.9g, error %.4g LSB", what, (int)integers, total,
                     error * one);
        if (info->kernel.unit_sum && integers != (int64_t)floor(one + 0.5))
            fail_msg("%s: ripple, %d instead of %.9g", what, (int)integers, one);
    } while (next_position(info->dims, steps, grid));
}

static void sum_preserving_weights_add_up_exactly(void **state)
{
    (void)state;
    struct weft_kernel_tiles_params p =
        *weft_kernel_tiles_params(.rounding = WEFT_TILE_SUM_PRESERVING,
                                  .scaling = WEFT_TILE_SCALE_SET);
    over_the_catalogue(assert_sums, p, true);
    p.store_all = true;
    over_the_catalogue(assert_sums, p, true);
}

static void normalised_weights_add_up_to_full_range(void **state)
{
    (void)state;
    int kernels = 0;
    for (const struct weft_kernel_info *const *k = weft_kernel_list; *k; k++) {
        if ((*k)->derivation)
            continue;
        // Snorm, unscaled: 127 is 1.0.
        struct weft_kernel_tiles_params p =
            *weft_kernel_tiles_params(.kernel = kernel_named((*k)->name), .samples = 15,
                                      .format = WEFT_TILE_UNORM,
                                      .rounding = WEFT_TILE_SUM_PRESERVING, .normalise = true);
        weft_kernel_tiles *set = NULL;
        if (weft_kernel_tiles_create(&p, &set) != WEFT_OK) {
            p.scaling = WEFT_TILE_SCALE_SET; // a weight over 1
            set = make(&p);
        }
        const double one = 255.0 * smallest_scale(set);
        int at[3] = {0};
        do {
            double sum;
            int64_t integers;
            survey(set, at, weights, &sum, &integers);
            assert_true(fabs(sum - 1.0) < 1e-12);
            assert_int_equal(integers, (int64_t)floor(one + 0.5));
        } while (next_position(2, 15, at));
        weft_kernel_tiles_destroy(&set);
        kernels++;
    }
    assert_true(kernels >= 20);
}

// ---- symmetry -----------------------------------------------------------------------------------

static void assert_same_values(const weft_kernel_tiles *a, const weft_kernel_tiles *b,
                               const char *what)
{
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(a);
    assert_int_equal(info->tile_count, weft_kernel_tiles_get_info(b)->tile_count);
    const int step = step_of(info->samples), steps = (info->samples - 1) / step + 1;
    for (int t = 0; t < info->tile_count; t++) {
        const struct weft_kernel_tile *s = weft_kernel_tiles_get(a, t);
        const struct weft_kernel_tile *u = weft_kernel_tiles_get(b, t);
        assert_memory_equal(s->tap, u->tap, sizeof s->tap);
        assert_int_equal(s->part, u->part);
        assert_true(s->minimum == u->minimum && s->maximum == u->maximum);
        int grid[3] = {0};
        do {
            const int at[3] = {grid[0] * step, grid[1] * step, grid[2] * step};
            const double x = weft_kernel_tiles_value(a, t, at);
            const double y = weft_kernel_tiles_value(b, t, at);
            if (x != y)
                fail_msg("%s: tile %d is %.9g mirrored, %.9g stored", what, t, x, y);
        } while (next_position(info->dims, steps, grid));
    }
}

static void mirrored_fetch_equals_unmirrored(void **state)
{
    (void)state;
    int compared[4] = {0}; // by dimensions
    const enum weft_tile_scaling scalings[] = {WEFT_TILE_SCALE_SET, WEFT_TILE_SCALE_EACH};
    for (const struct weft_kernel_info *const *k = weft_kernel_list; *k; k++) {
        for (int i = 0; i < 12; i++) {
            struct weft_kernel_tiles_params p =
                *weft_kernel_tiles_params(.kernel = kernel_named((*k)->name), .dims = 1 + i % 3,
                                          .format = i % 4, .bits = i / 3 % 2 ? 16 : 8,
                                          .scaling = scalings[i % 2]);
            if (p.kernel.width > 8 && p.dims == 3)
                continue;
            p.samples = samples_of(p.dims, p.kernel.width, i);
            weft_kernel_tiles *mirrored = make(&p);
            p.store_all = true;
            weft_kernel_tiles *whole = make(&p);
            const struct weft_kernel_tiles_info *m = weft_kernel_tiles_get_info(mirrored);
            const struct weft_kernel_tiles_info *w = weft_kernel_tiles_get_info(whole);
            assert_true(m->mirrored);
            assert_false(w->mirrored);
            assert_int_equal(w->saved_bytes, 0);
            assert_int_equal(w->stored_count, w->tile_count);
            assert_int_equal(m->memory_bytes + m->saved_bytes, w->memory_bytes);
            assert_same_values(mirrored, whole, (*k)->name);
            compared[p.dims]++;
            weft_kernel_tiles_destroy(&mirrored);
            weft_kernel_tiles_destroy(&whole);
        }
    }
    assert_true(compared[1] >= 4 * 40 && compared[1] == compared[2]);
    assert_true(compared[3] > compared[2] / 2 && compared[3] <= compared[2]);
}

static int compared; // sets

// What the set holds is symmetric even where it is stored whole.
static void assert_symmetric(const weft_kernel_tiles *set, const char *what)
{
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(set);
    const double sign = info->kernel.info->derivation % 2 ? -1.0 : 1.0;
    if (!info->mirrored || info->dims > 1)
        return;
    compared++;
    double other[16];
    for (int k = 0; k < info->samples; k++) {
        double sum;
        int64_t integers;
        survey(set, (int[3]){k, 0, 0}, weights, &sum, &integers);
        memcpy(other, weights, sizeof other);
        survey(set, (int[3]){info->samples - 1 - k, 0, 0}, weights, &sum, &integers);
        for (int t = 0; t < info->width; t++)
            if (weights[info->width - 1 - t] != sign * other[t])
                fail_msg("%s: sample %d of tap %d has no mirror image", what, k, t);
    }
}

static void weights_are_symmetric(void **state)
{
    (void)state;
    struct weft_kernel_tiles_params p = *weft_kernel_tiles_params(.scaling = WEFT_TILE_SCALE_SET);
    compared = 0;
    over_the_catalogue(assert_symmetric, p, false);
    p.rounding = WEFT_TILE_SUM_PRESERVING;
    over_the_catalogue(assert_symmetric, p, true);
    assert_true(compared > 100);
}

static void the_memory_saved_is_as_counted(void **state)
{
    (void)state;
    const struct {
        const char *name;
        int dims, tiles, stored;
    } cases[] = {
        {"bspline", 1, 4, 2},
        {"bspline", 2, 16, 4},
        {"bspline", 3, 64, 8},
        {"linear", 3, 8, 1},
        {"bspline2", 2, 9, 4},
        {"nearest", 2, 1, 1},
        // Outer taps are negative, inner ones positive: no tap needs both parts.
        {"catmull-rom", 2, 16, 4},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        weft_kernel_tiles *set =
            make(weft_kernel_tiles_params(.kernel = kernel_named(cases[i].name),
                                          .dims = cases[i].dims, .samples = 8));
        const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(set);
        const size_t bytes = 2 * (size_t)pow(8, cases[i].dims);
        assert_int_equal(info->tile_count, cases[i].tiles);
        assert_int_equal(info->stored_count, cases[i].stored);
        assert_int_equal(info->memory_bytes, bytes * (size_t)cases[i].stored);
        assert_int_equal(info->saved_bytes, bytes * (size_t)(cases[i].tiles - cases[i].stored));
        weft_kernel_tiles_destroy(&set);
    }
}

static double lopsided(const struct weft_kernel *k, double x)
{
    (void)k;
    return x >= -1.0 && x < 1.0 ? 0.5 + 0.25 * x : 0.0;
}

static void other_kernels_and_odd_sums_are_stored_whole(void **state)
{
    (void)state;
    const struct weft_kernel_info info = {
        .name = "lopsided", .radius = 1.0, .weight = lopsided, .degree = 1, .continuity = -1};
    struct weft_kernel k;
    assert_int_equal(weft_kernel_create(NULL, &info, NULL, &k), WEFT_OK);
    weft_kernel_tiles *set = make(weft_kernel_tiles_params(.kernel = k));
    assert_false(weft_kernel_tiles_get_info(set)->mirrored);
    assert_bounded(set, "lopsided");
    weft_kernel_tiles_destroy(&set);
    for (int m = 8; m <= 9; m++) {
        set = make(weft_kernel_tiles_params(.kernel = kernel_named("linear"), .samples = m,
                                            .rounding = WEFT_TILE_SUM_PRESERVING));
        assert_int_equal(weft_kernel_tiles_get_info(set)->mirrored, m == 8);
        weft_kernel_tiles_destroy(&set);
    }
}

// ---- scales and signs ---------------------------------------------------------------------------

static void scaled_tiles_use_the_full_range(void **state)
{
    (void)state;
    for (const struct weft_kernel_info *const *k = weft_kernel_list; *k; k++) {
        for (int i = 0; i < 16; i++) {
            const bool each = i & 1, exact = i & 2;
            struct weft_kernel_tiles_params p =
                *weft_kernel_tiles_params(.kernel = kernel_named((*k)->name), .dims = 1 + i / 8,
                                          .samples = 12 + i / 8,
                                          .format = i & 4 ? WEFT_TILE_SNORM : WEFT_TILE_UNORM,
                                          .exact_scale = exact,
                                          .scaling =
                                              each ? WEFT_TILE_SCALE_EACH : WEFT_TILE_SCALE_SET);
            weft_kernel_tiles *set = make(&p);
            const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(set);
            double most = 0.0;
            for (int t = 0; t < info->tile_count; t++) {
                const struct weft_kernel_tile *tile = weft_kernel_tiles_get(set, t);
                const double full = fmax(-tile->minimum, tile->maximum) * tile->scale * info->one;
                int exponent;
                most = fmax(most, full);
                assert_true(full <= info->one * (1.0 + 1e-12));
                assert_true(exact || frexp(tile->scale, &exponent) == 0.5);
                if (each && full > 0.0)
                    assert_true(exact ? fabs(full - info->one) < 1e-6
                                      : full >= floor(info->one / 2));
            }
            assert_true(exact ? fabs(most - info->one) < 1e-6 : most >= floor(info->one / 2));
            weft_kernel_tiles_destroy(&set);
        }
    }
}

static void separate_parts_have_one_sign_each(void **state)
{
    (void)state;
    const char *const names[] = {"catmull-rom", "lanczos:3", "d-bspline", "dd-bspline"};
    for (size_t i = 0; i < WEFT_COUNT(names); i++) {
        struct weft_kernel_tiles_params p =
            *weft_kernel_tiles_params(.kernel = kernel_named(names[i]), .samples = 10,
                                      .format = WEFT_TILE_SNORM, .scaling = WEFT_TILE_SCALE_SET);
        weft_kernel_tiles *whole = make(&p);
        p.signs = WEFT_TILE_SEPARATE;
        weft_kernel_tiles *parts = make(&p);
        const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(parts);
        for (int t = 0; t < info->tile_count; t++) {
            const struct weft_kernel_tile *tile = weft_kernel_tiles_get(parts, t);
            assert_true(tile->part == WEFT_TILE_NEGATIVE ? tile->maximum <= 0.0
                                                         : tile->minimum >= 0.0);
            for (size_t n = 0; n < info->tile_values; n++)
                assert_true(((const int16_t *)tile->data)[n] >= 0);
        }
        int at[3] = {0};
        do {
            double sum;
            int64_t integers;
            static double other[16 * 16];
            survey(whole, at, weights, &sum, &integers);
            memcpy(other, weights, sizeof other);
            survey(parts, at, weights, &sum, &integers);
            assert_memory_equal(other, weights, tap_count(info) * sizeof *weights);
        } while (next_position(2, 10, at));
        weft_kernel_tiles_destroy(&whole);
        weft_kernel_tiles_destroy(&parts);
    }
}

// ---- splitting and interleaving -----------------------------------------------------------------

// The parts of every tile of the set, split twice, against the set as it was.
static void split_parts_add_up_exactly(void **state)
{
    (void)state;
    for (const struct weft_kernel_info *const *k = weft_kernel_list; *k; k++) {
        for (int f = 0; f < 4; f++) {
            struct weft_kernel_tiles_params p =
                *weft_kernel_tiles_params(.kernel = kernel_named((*k)->name), .dims = 1 + f % 2,
                                          .samples = 9, .format = f,
                                          .scaling =
                                              f / 2 ? WEFT_TILE_SCALE_EACH : WEFT_TILE_SCALE_SET);
            weft_kernel_tiles *set = make(&p), *before = make(&p);
            const int count = weft_kernel_tiles_get_info(set)->tile_count;
            for (int t = 0; t < count; t++) {
                const double middle = 0.5 * (weft_kernel_tiles_get(set, t)->minimum +
                                             weft_kernel_tiles_get(set, t)->maximum);
                assert_int_equal(weft_kernel_tiles_split(set, t, NAN), WEFT_OK);
                assert_int_equal(weft_kernel_tiles_get_info(set)->tile_count, count + t + 1);
                const int low = count + t;
                int at[3] = {0};
                do {
                    const double was = weft_kernel_tiles_value(before, t, at);
                    const double a = weft_kernel_tiles_value(set, t, at);
                    const double b = weft_kernel_tiles_value(set, low, at);
                    assert_true(a + b == was && (a == 0.0 || b == 0.0));
                    assert_true((was >= middle ? a : b) == was);
                } while (next_position(p.dims, 9, at));
                assert_true(weft_kernel_tiles_get(set, low)->maximum <= fmax(middle, 0.0));
            }
            const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(set);
            // Nothing is left over, and what was shared is so no more.
            assert_int_equal(info->memory_bytes,
                             (size_t)info->stored_count * info->tile_values * info->value_bytes);
            assert_true(info->stored_count <= 2 * count);
            weft_kernel_tiles_destroy(&set);
            weft_kernel_tiles_destroy(&before);
        }
    }
}

// ---- bad requests -------------------------------------------------------------------------------

static void bad_arguments_are_named(void **state)
{
    (void)state;
    const struct weft_kernel cubic = kernel_named("catmull-rom"),
                             hann = kernel_named("hann-sinc:3");
    const struct weft_kernel slope = kernel_named("dd-bspline");
    const struct {
        struct weft_kernel_tiles_params *params;
        enum weft_result expected;
        const char *text, *more;
    } cases[] = {
#define BAD(result, text, more, ...)                                                               \
    {weft_kernel_tiles_params(.kernel = cubic, __VA_ARGS__), result, text, more}
        BAD(WEFT_ERR_ARGUMENT, "not 5000", "4096", .samples = 5000),
        BAD(WEFT_ERR_ARGUMENT, "not -1", "4096", .samples = -1),
        BAD(WEFT_ERR_ARGUMENT, "not 1", "2 to 4096", .samples = 1, .placement = WEFT_TILE_ENDS),
        BAD(WEFT_ERR_ARGUMENT, "not 3", "4 to 16 bits", .bits = 3),
        BAD(WEFT_ERR_ARGUMENT, "not 17", "4 to 16 bits", .bits = 17),
        BAD(WEFT_ERR_ARGUMENT, "not 12", "8 or 16", .format = WEFT_TILE_SNORM, .bits = 12),
        BAD(WEFT_ERR_ARGUMENT, "not 4", "dimension", .dims = 4),
        BAD(WEFT_ERR_ARGUMENT, "-0.07", "unorm", .signs = WEFT_TILE_SIGNED),
        BAD(WEFT_ERR_ARGUMENT, "integer", "sum", .format = WEFT_TILE_FLOAT,
            .rounding = WEFT_TILE_SUM_PRESERVING),
        BAD(WEFT_ERR_ARGUMENT, "scales", "sum", .scaling = WEFT_TILE_SCALE_EACH,
            .rounding = WEFT_TILE_SUM_PRESERVING),
        BAD(WEFT_ERR_ARGUMENT, "up to 3.9", "over 1", .kernel = slope),
        BAD(WEFT_ERR_ARGUMENT, "derivative", "", .kernel = slope, .normalise = true),
        BAD(WEFT_ERR_ARGUMENT, "no kernel", "info", .kernel = {0}),
        // 4 stored tiles of 512^2 at two bytes.
        BAD(WEFT_ERR_LIMIT, "2097152", "1000000", .samples = 512, .memory_bytes = 1000000),
        // 8 of 4096^3.
        BAD(WEFT_ERR_LIMIT, "1099511627776", "1073741824", .samples = 4096, .dims = 3),
        BAD(WEFT_ERR_LIMIT, "over the limit", "", .kernel = hann, .samples = 4096, .dims = 3,
            .memory_bytes = UINT64_C(1) << 40, .store_all = true),
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

static void splits_know_their_limits(void **state)
{
    (void)state;
    struct message message = {.count = 0};
    struct weft_log log = {keep_message, &message};
    // Room for the four stored tiles and one more.
    weft_kernel_tiles *set =
        make(weft_kernel_tiles_params(.kernel = kernel_named("bspline"), .samples = 8,
                                      .memory_bytes = 5 * 128, .log = &log));
    assert_int_equal(weft_kernel_tiles_split(set, 0, NAN), WEFT_ERR_LIMIT);
    assert_non_null(strstr(message.text, "640"));
    assert_non_null(strstr(message.text, "256"));
    assert_int_equal(weft_kernel_tiles_get_info(set)->tile_count, 16);
    assert_int_equal(weft_kernel_tiles_split(set, 16, NAN), WEFT_ERR_ARGUMENT);
    assert_int_equal(weft_kernel_tiles_split(set, -1, NAN), WEFT_ERR_ARGUMENT);
    assert_null(weft_kernel_tiles_get(set, 16));
    weft_kernel_tiles_destroy(&set);
    weft_kernel_tiles_destroy(&set);
}

// By hand: linear at M = 4, eight bits: 255 x 1/8, 3/8, 5/8, 7/8.
static void a_tile_by_hand(void **state)
{
    (void)state;
    const int nearest[4] = {32, 96, 159, 223}, truncated[4] = {31, 95, 159, 223};
    for (int r = 0; r < 2; r++) {
        weft_kernel_tiles *set =
            make(weft_kernel_tiles_params(.kernel = kernel_named("linear"), .dims = 1, .samples = 4,
                                          .rounding = r ? WEFT_TILE_TRUNCATED : WEFT_TILE_NEAREST));
        const int at = weft_kernel_tiles_find(set, (const int[3]){1, 0, 0}, WEFT_TILE_POSITIVE);
        assert_true(at >= 0);
        for (int k = 0; k < 4; k++)
            assert_int_equal(weft_kernel_tiles_integer(set, at, (const int[3]){k, 0, 0}),
                             r ? truncated[k] : nearest[k]);
        weft_kernel_tiles_destroy(&set);
    }
    weft_kernel_tiles *set =
        make(weft_kernel_tiles_params(.kernel = kernel_named("linear"), .dims = 1, .samples = 5,
                                      .placement = WEFT_TILE_ENDS, .format = WEFT_TILE_FLOAT));
    for (int k = 0; k < 5; k++) {
        assert_true(weft_kernel_tiles_position(set, k) == k / 4.0);
        const double w = weft_kernel_tiles_value(set, 1, (const int[3]){k, 0, 0});
        assert_true(fabs(w - k / 4.0) < 1e-7);
    }
    weft_kernel_tiles_destroy(&set);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_tile_by_hand),
        cmocka_unit_test(every_weight_is_within_its_formats_error),
        cmocka_unit_test(truncation_goes_towards_zero),
        cmocka_unit_test(sum_preserving_weights_add_up_exactly),
        cmocka_unit_test(normalised_weights_add_up_to_full_range),
        cmocka_unit_test(mirrored_fetch_equals_unmirrored),
        cmocka_unit_test(weights_are_symmetric),
        cmocka_unit_test(the_memory_saved_is_as_counted),
        cmocka_unit_test(other_kernels_and_odd_sums_are_stored_whole),
        cmocka_unit_test(scaled_tiles_use_the_full_range),
        cmocka_unit_test(separate_parts_have_one_sign_each),
        cmocka_unit_test(split_parts_add_up_exactly),
        cmocka_unit_test(bad_arguments_are_named),
        cmocka_unit_test(splits_know_their_limits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
