// SPDX-License-Identifier: BSD-3-Clause
// Every public function, called with values that its header does not allow: an error with a line in
// the log, or what the header says; never a crash, never a hang. Each function runs in a child of
// its own. The list of functions is made from the public headers: one without a case fails the
// test.
#include <float.h>
#include <limits.h>
#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "callers_functions.h"
#include "filter/check.h"
#include "weft.h"

enum { SECONDS = 30, COMPLAINTS = 3, SKIPPED = 4 };

// ---- in a child ---------------------------------------------------------------------------------

static int lines, complaints;

static void count_line(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    lines += level <= WEFT_LOG_WARNING && message[0];
}

static const struct weft_log logger = {.write = count_line};

static void expect(bool good, int line, const char *what)
{
    if (good)
        return;
    complaints++;
    fprintf(stderr, "    line %d: %s\n", line, what);
}

#define TRUE(condition) expect(condition, __LINE__, #condition)

// A result that is an error has a line in the log; `refused`: it must be one.
static void judge(enum weft_result res, bool refused, int line, const char *what)
{
    expect(res == WEFT_OK || lines > 0, line, what);
    expect(res != WEFT_OK || !refused, line, what);
    lines = 0;
}

#define REFUSED(call) judge(call, true, __LINE__, #call " is refused with a line")
#define SURVIVED(call) judge(call, false, __LINE__, #call " has a line where it fails")

static const int bad_enums[] = {-1, 99, INT_MAX, INT_MIN};
static const int ints[] = {INT_MIN, -1, 0, 1, 99, 1 << 20, INT_MAX};
static const double numbers[] = {NAN,  INFINITY, -INFINITY, DBL_MAX, -1e300,
                                 1e12, 0.0,      -1.0,      1e-300};

// A copy of `base`, p, has each bad value in turn in a member.
#define BAD_ENUM(base, member, call)                                                               \
    for (size_t at_ = 0; at_ < WEFT_COUNT(bad_enums); at_++) {                                     \
        __typeof__(base) p = base;                                                                 \
        p.member = (__typeof__(p.member))bad_enums[at_];                                           \
        REFUSED(call);                                                                             \
    }
#define ANY_INT(base, member, call)                                                                \
    for (size_t at_ = 0; at_ < WEFT_COUNT(ints); at_++) {                                          \
        __typeof__(base) p = base;                                                                 \
        p.member = (__typeof__(p.member))ints[at_];                                                \
        SURVIVED(call);                                                                            \
    }
#define ANY_NUMBER(base, member, call)                                                             \
    for (size_t at_ = 0; at_ < WEFT_COUNT(numbers); at_++) {                                       \
        __typeof__(base) p = base;                                                                 \
        p.member = (__typeof__(p.member))numbers[at_];                                             \
        SURVIVED(call);                                                                            \
    }
#define SET_REFUSED(base, member, value, call)                                                     \
    do {                                                                                           \
        __typeof__(base) p = base;                                                                 \
        p.member = (value);                                                                        \
        REFUSED(call);                                                                             \
    } while (0)

// ---- kernels that are none ----------------------------------------------------------------------

static double half(const struct weft_kernel *kernel, double x)
{
    (void)kernel;
    return x >= -1.0 && x < 1.0 ? 0.25 : 0.0;
}

static struct weft_kernel named(const char *text)
{
    struct weft_kernel kernel;
    if (weft_kernel_parse(NULL, text, &kernel) != WEFT_OK)
        exit(1);
    return kernel;
}

enum { BAD_KERNELS = 15 };

// The first is all zero: where a header says so, that asks for the default.
static struct weft_kernel bad_kernel(int i)
{
    static struct weft_kernel_info records[BAD_KERNELS];
    struct weft_kernel_info good = {
        .name = "own", .weight = half, .radius = 1.0, .degree = -1, .continuity = -1};
    struct weft_kernel kernel = named("catmull-rom");
    struct weft_kernel_info *info = &records[i];
    *info = good;
    if (i >= 7)
        kernel = (struct weft_kernel){.info = info, .support = 1.0, .width = 2, .continuity = -1};
    switch (i) {
    case 0:
        return (struct weft_kernel){0};
    case 1:
        kernel.width = 99;
        break;
    case 2:
        kernel.width = INT_MAX;
        break;
    case 3:
        kernel.width = INT_MIN;
        break;
    case 4:
        kernel.support = NAN;
        break;
    case 5:
        kernel.support = 1e300;
        break;
    case 6:
        kernel.order = -7;
        break;
    case 7:
        *info = (struct weft_kernel_info){0};
        break;
    case 8:
        info->weight = NULL;
        break;
    case 9:
        info->name = NULL;
        break;
    case 10:
        kernel.unit_sum = true;
        break; // the sum is 1/2
    case 11:
        kernel.interpolating = true;
        break;
    case 12:
        info->degree = 1000000;
        break;
    case 13:
        info->derivation = 7;
        break;
    default:
        kernel.prefiltered = true;
    }
    return kernel;
}

#define EACH_BAD_KERNEL(first, call)                                                               \
    for (int k = first; k < BAD_KERNELS; k++) {                                                    \
        const struct weft_kernel kernel = bad_kernel(k);                                           \
        call;                                                                                      \
    }
#define KERNELS_REFUSED(base, first, call)                                                         \
    EACH_BAD_KERNEL(first, __typeof__(base) p = base; p.kernel = kernel; REFUSED(call))

// ---- filter/ ------------------------------------------------------------------------------------

static void analysis(void)
{
    struct weft_kernel good = named("bspline3i");
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        weft_analysis_taylor(&good, ints[i], 0.3);
        weft_analysis_moment(&good, ints[i]);
        weft_analysis_metrics(&good, ints[i]);
    }
    for (size_t i = 0; i < WEFT_COUNT(numbers); i++) {
        weft_analysis_taylor(&good, 1, numbers[i]);
        weft_analysis_response(&good, numbers[i]);
    }
    TRUE(isnan(weft_analysis_response(&good, 1e300).re));
    TRUE(isnan(weft_analysis_response(&good, 1e6).re));
    TRUE(isfinite(weft_analysis_response(&good, WEFT_ANALYSIS_MAX_FREQUENCY).re));
    EACH_BAD_KERNEL(0, {
        weft_analysis_taylor(&kernel, 0, 0.0);
        weft_analysis_moment(&kernel, 0);
        weft_analysis_response(&kernel, 0.5);
        weft_analysis_metrics(&kernel, 2);
    })
    const struct weft_kernel none = {0};
    TRUE(isnan(weft_analysis_order(&none).constant));
    TRUE(isnan(weft_analysis_overshoot(&none).above));
    TRUE(isnan(weft_analysis_gain(&none)));
    TRUE(isnan(weft_analysis_curvature(&none)));
    TRUE(isnan(weft_analysis_slope(&none)));
    for (int k = 1; k < 6; k++) {
        const struct weft_kernel kernel = bad_kernel(k);
        weft_analysis_order(&kernel);
        weft_analysis_overshoot(&kernel);
        weft_analysis_gain(&kernel);
        weft_analysis_curvature(&kernel);
        weft_analysis_slope(&kernel);
    }
}

static void cpus(void)
{
    struct weft_cpu good = {.threads = 1}, out;
    TRUE(weft_cpu_threads() > 0);
    TRUE(weft_instruction_set_runs(weft_instruction_set_best()));
    for (size_t i = 0; i < WEFT_COUNT(bad_enums); i++)
        TRUE(!weft_instruction_set_runs((enum weft_instruction_set)bad_enums[i]));
#define CALL weft_cpu_resolve(&logger, &p, &out)
    SURVIVED(weft_cpu_resolve(&logger, &good, &out));
    SET_REFUSED(good, threads, -1, CALL);
    SET_REFUSED(good, threads, WEFT_CPU_MAX_THREADS + 1, CALL);
    BAD_ENUM(good, instructions, CALL);
#undef CALL
}

static void texts(void)
{
    for (size_t i = 0; i < WEFT_COUNT(bad_enums); i++) {
        TRUE(weft_result_text((enum weft_result)bad_enums[i])[0]);
        TRUE(weft_target_name((enum weft_target_format)bad_enums[i])[0]);
        TRUE(weft_target_bits((enum weft_target_format)bad_enums[i]) == 0);
        TRUE(weft_target_one((enum weft_target_format)bad_enums[i]) == 0);
        TRUE(weft_stability_verdict_text((enum weft_stability_verdict)bad_enums[i])[0]);
        TRUE(weft_layout_name((enum weft_layout)bad_enums[i])[0]);
        TRUE(weft_source_format_name((enum weft_source_format)bad_enums[i])[0]);
        TRUE(weft_source_format_bytes((enum weft_source_format)bad_enums[i]) == 0);
        TRUE(isnan(weft_source_format_error((enum weft_source_format)bad_enums[i])));
    }
    TRUE(weft_version()[0]);
    char text[] = "\x1b[31m\xff\n";
    TRUE(weft_text_clean(text, false) == text);
    TRUE(weft_text_skip_mark("\xef\xbb")[0]);
}

static void find(void)
{
    TRUE(!weft_kernel_find("") && !weft_signal_find("") && !weft_profile_find(""));
    static const char *const names[] = {"linear", NULL};
    TRUE(!weft_closest_find("", SIZE_MAX, names) && !weft_closest_find("lin", 0, names));
    TRUE(!weft_stability_find("") && !weft_colour_map_find(""));
}

static void statistics(void)
{
    struct weft_statistics none = WEFT_STATISTICS_NONE;
    const float values[] = {NAN, INFINITY, -INFINITY};
    TRUE(weft_statistics_magnitude(&none) == 0.0);
    weft_statistics_add(&none, values, 0);
    weft_statistics_add(&none, values, WEFT_COUNT(values));
    weft_statistics_add_differences(&none, values, WEFT_COUNT(values), 0);
    weft_statistics_add_differences(&none, values, 0, SIZE_MAX);
    const struct weft_statistics_plane plane = {values, 3, 1, 0};
    TRUE(weft_statistics_plane_difference(&plane, 1, 0, SIZE_MAX) == 0.0);
    TRUE(weft_statistics_plane_difference(&plane, 4, 5, 0) == 0.0);
    for (size_t i = 0; i < WEFT_COUNT(ints); i++)
        TRUE(weft_statistics_plane_difference(&plane, ints[i], 0, 1) == 0.0);
    weft_statistics_join(&none, &(struct weft_statistics)WEFT_STATISTICS_NONE);
    TRUE(isnan(none.minimum) && none.not_finite == 3 && none.difference[0] == 0.0);
}

static void errors(void)
{
    struct weft_error_kernel out;
    struct weft_error_kernel_params good = {
        .kernel = named("linear"), .dims = 1, .samples = 8, .locations = 16, .log = &logger};
#define CALL weft_error_kernel_compute(&p, &out)
    KERNELS_REFUSED(good, 0, CALL);
    ANY_INT(good, dims, CALL);
    ANY_INT(good, samples, CALL);
    ANY_INT(good, bits, CALL);
    SURVIVED(weft_error_kernel_compute(&good, &out));
    good.threads = INT_MIN;
    SURVIVED(weft_error_kernel_compute(&good, &out));
    SET_REFUSED(good, locations, INT_MAX, CALL);
    SET_REFUSED(good, locations, -1, CALL);
    BAD_ENUM(good, rounding, CALL);
    BAD_ENUM(good, lookup, CALL);
    BAD_ENUM(good, convention, CALL);
#undef CALL
    EACH_BAD_KERNEL(0, if (k < 6 || k == 7) weft_error_e1(&kernel, 2, 1.0))
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        if (ints[i] < 1 || ints[i] > 3)
            TRUE(isnan(weft_error_e1(&good.kernel, ints[i], 1.0)));
    }
}

static void bounds(void)
{
    const struct weft_bound_terms good = {.relative = 1e-6, .e2 = 1e-3, .rounded_gain = 1.0};
    const struct weft_bound_values read = {.low = -1.0, .high = 1.0};
    TRUE(weft_bound_compute(&good, &read).total > 0.0);
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        struct weft_bound_terms terms = good;
        struct weft_bound_values values = read;
        terms.e2 = values.beyond = numbers[n];
        weft_bound_compute(&terms, &read);
        weft_bound_compute(&good, &values);
    }
}

static void kernels(void)
{
    struct weft_kernel out;
    double weights[WEFT_KERNEL_MAX_WEIGHTS], fraction;
    char text[64];
    int64_t first[3];
    EACH_BAD_KERNEL(0, {
        struct weft_kernel copy = kernel;
        REFUSED(weft_kernel_check(&logger, &kernel));
        REFUSED(weft_kernel_normalise(&logger, &copy));
        REFUSED(weft_kernel_make_radial(&logger, &copy));
        REFUSED(weft_kernel_make_prefiltered(&logger, &copy));
        REFUSED(weft_kernel_derive(&logger, &kernel, &out));
        weft_kernel_format(&kernel, text, sizeof text);
        weft_kernel_weight(&kernel, 0.3);
        weft_kernel_derivative(&kernel, 0.3);
        weft_kernel_first_tap(&kernel, 0.3, &fraction);
        weft_kernel_offset(&kernel);
        weft_kernel_weights(&kernel, 0.3, weights);
        weft_kernel_is_radial(&kernel, 3);
        weft_kernel_weights_nd(&kernel, 3, (double[3]){0}, weights, first);
        weft_kernel_radial_sums(&kernel, 2);
    })
    struct weft_kernel good = named("catmull-rom");
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        weft_kernel_weight(&good, numbers[n]);
        weft_kernel_derivative(&good, numbers[n]);
        weft_kernel_first_tap(&good, numbers[n], &fraction);
        weft_kernel_weights(&good, numbers[n], weights);
    }
    const double *const axis[3] = {weights, weights, weights};
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        if (ints[i] < 1 || ints[i] > 3) {
            TRUE(weft_kernel_combine(&good, ints[i], axis, weights + 16) == 0);
            TRUE(weft_kernel_weights_nd(&good, ints[i], (double[3]){0}, weights, first) == 0);
            TRUE(isnan(weft_kernel_radial_sums(&good, ints[i]).least));
        }
        weft_kernel_is_radial(&good, ints[i]);
    }
    weft_kernel_format(&good, text, 0);
    REFUSED(weft_kernel_parse(&logger, "", &out));
    REFUSED(weft_kernel_parse(&logger, "cubic:nan", &out));
}

// A user's own record: the error names the member.
static char last_line[1024];

static void keep_line(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    (void)level;
    lines++;
    snprintf(last_line, sizeof last_line, "%s", message);
}

static void records(void)
{
    static const struct weft_log keep = {.write = keep_line};
    static const char *const members[BAD_KERNELS] = {
        [8] = "weight", [9] = "name", [12] = "degree", [13] = "derivation"};
    struct weft_kernel out;
    for (int i = 7; i < BAD_KERNELS; i++) {
        struct weft_kernel_info info = *bad_kernel(i).info;
        info.unit_sum = i == 10;
        info.interpolating = i == 11;
        if (i < 14)
            REFUSED(weft_kernel_create(&keep, &info, NULL, &out));
        TRUE(!members[i] || strstr(last_line, members[i]));
        TRUE(i != 10 || strstr(last_line, "unit_sum"));
        TRUE(i != 11 || strstr(last_line, "interpolating"));
    }
    const struct weft_kernel_info *cubic = weft_kernel_find("cubic");
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++)
        SURVIVED(weft_kernel_create(&keep, cubic, (double[2]){numbers[n], numbers[n]}, &out));
    struct weft_kernel_info own = *bad_kernel(14).info;
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        own.radius = numbers[n];
        if (!(own.radius > 0.0 && own.radius < 1.0))
            REFUSED(weft_kernel_create(&keep, &own, NULL, &out));
    }
}

static void tables(void)
{
    static const double samples[4] = {1.0, 0.5, 0.25, 0.0};
    struct weft_kernel_table out;
    struct weft_kernel_table_params good = {
        .samples = samples, .count = 4, .support = 1.0, .log = &logger};
#define CALL weft_kernel_table_init(&p, &out)
    ANY_NUMBER(good, support, CALL);
    BAD_ENUM(good, between, CALL);
    SET_REFUSED(good, count, 0, CALL);
    SET_REFUSED(good, count, SIZE_MAX, CALL);
#undef CALL
}

static void prefilters(void)
{
    struct weft_prefilter good, out;
    struct weft_prefilter_axis axis;
    double values[WEFT_PREFILTER_MAX_WEIGHTS] = {0};
    const struct weft_kernel spline = named("bspline3i");
    TRUE(weft_prefilter_compute(&logger, &spline, &good) == WEFT_OK);
    EACH_BAD_KERNEL(0, {
        if (k == 0 || k >= 7)
            REFUSED(weft_prefilter_compute(&logger, &kernel, &out));
        weft_prefilter_weights(&good, &kernel, 4, 0.3, values);
    })
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        struct weft_prefilter bad = good;
        bad.poles = ints[i];
        weft_prefilter_line(&bad, values, 8, 1, 0.0, NAN);
        weft_prefilter_overlap(&bad, 1e-9);
        weft_prefilter_taps(&bad, 4, values);
        weft_prefilter_weights(&bad, &spline, 4, 0.3, values);
        weft_prefilter_axis_set(&bad, &spline, 4, 0.3, INT64_MIN, INT64_MAX, &axis);
        weft_prefilter_axis_set(&good, &spline, ints[i], 0.3, ints[i], 7, &axis);
        if (ints[i] < 0 || ints[i] > WEFT_PREFILTER_MAX_OVERLAP) {
            weft_prefilter_taps(&good, ints[i], values);
            TRUE(weft_prefilter_weights(&good, &spline, ints[i], 0.3, values) == 0);
        }
    }
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        const int overlap = weft_prefilter_overlap(&good, numbers[n]);
        TRUE(overlap >= 0 && overlap <= WEFT_PREFILTER_MAX_OVERLAP);
        weft_prefilter_weights(&good, &spline, 4, numbers[n], values);
    }
    weft_prefilter_line(&good, values, 0, PTRDIFF_MIN, NAN, NAN);
    EACH_BAD_KERNEL(0, if (k < 6 || k == 7) weft_prefilter_error(&kernel, 3, 0x1p-28))
    for (size_t i = 0; i < WEFT_COUNT(ints); i++)
        weft_prefilter_error(&spline, ints[i], NAN);
    TRUE(!weft_prefilter_is_missing(NAN, NAN, NAN, true));
}

static double one(void *priv, const int64_t index[3])
{
    (void)priv;
    (void)index;
    return 1.0;
}

static void reference(void)
{
    struct weft_kernel good = named("linear");
    EACH_BAD_KERNEL(0, weft_reference_compute(&kernel, 3, (double[3]){0}, one, NULL))
    for (size_t i = 0; i < WEFT_COUNT(ints); i++)
        weft_reference_compute(&good, ints[i], (double[3]){NAN, INFINITY, 1e300}, one, NULL);
    TRUE(isnan(weft_reference_compute(&good, 0, NULL, one, NULL).value));
    EACH_BAD_KERNEL(0, weft_reference_compute_axes((struct weft_kernel[3]){good, kernel, kernel}, 3,
                                                   (double[3]){0}, one, NULL))
    const struct weft_kernel axes[3] = {good, good, good};
    TRUE(isnan(weft_reference_compute_axes(axes, 0, NULL, one, NULL).value));
}

// ---- tiles/ -------------------------------------------------------------------------------------

static weft_kernel_tiles *tiles(void)
{
    weft_kernel_tiles *set = NULL;
    const struct weft_kernel_tiles_params *p =
        weft_kernel_tiles_params(.kernel = named("catmull-rom"), .samples = 4, .log = &logger);
    if (weft_kernel_tiles_create(p, &set) != WEFT_OK)
        exit(1);
    return set;
}

static enum weft_result make_tiles(const struct weft_kernel_tiles_params *p)
{
    weft_kernel_tiles *set = NULL;
    const enum weft_result res = weft_kernel_tiles_create(p, &set);
    weft_kernel_tiles_destroy(&set);
    return res;
}

static void tile_sets(void)
{
    struct weft_kernel_tiles_params good = {
        .kernel = named("linear"), .samples = 4, .log = &logger, .memory_bytes = 1 << 24};
#define CALL make_tiles(&p)
    KERNELS_REFUSED(good, 0, CALL);
    ANY_INT(good, dims, CALL);
    ANY_INT(good, samples, CALL);
    ANY_INT(good, bits, CALL);
    ANY_INT(good, derivative, CALL);
    ANY_NUMBER(good, max_scale, CALL);
    BAD_ENUM(good, format, CALL);
    BAD_ENUM(good, rounding, CALL);
    BAD_ENUM(good, placement, CALL);
    BAD_ENUM(good, signs, CALL);
    BAD_ENUM(good, scaling, CALL);
#undef CALL
    weft_kernel_tiles_destroy(NULL);
    weft_kernel_tiles *none = NULL;
    weft_kernel_tiles_destroy(&none);
}

static void tile_questions(void)
{
    weft_kernel_tiles *set = tiles();
    const int origin[3] = {0};
    weft_kernel_tiles_get_info(set);
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        const int bad = ints[i], at[3] = {bad, bad, bad};
        if (bad >= 0 && bad < 4)
            continue;
        TRUE(!weft_kernel_tiles_get(set, bad) || bad == 1);
        TRUE(weft_kernel_tiles_find(set, at, WEFT_TILE_WHOLE) == -1);
        TRUE(weft_kernel_tiles_find(set, origin, (enum weft_tile_part)bad) == -1);
        TRUE(isnan(weft_kernel_tiles_position(set, bad)));
        TRUE(isnan(weft_kernel_tiles_value(set, bad, origin)));
        TRUE(isnan(weft_kernel_tiles_value(set, 0, at)));
        TRUE(weft_kernel_tiles_integer(set, bad, origin) == 0);
        TRUE(weft_kernel_tiles_integer(set, 0, at) == 0);
        TRUE(isnan(weft_kernel_tiles_exact(set, at, origin)));
        TRUE(isnan(weft_kernel_tiles_exact(set, origin, at)));
        REFUSED(weft_kernel_tiles_split(set, bad, NAN));
    }
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++)
        SURVIVED(weft_kernel_tiles_split(set, 0, numbers[n]));
    weft_kernel_tiles_destroy(&set);
}

static void layouts(void)
{
    enum weft_context_kind kind;
    struct weft_profile profile;
    struct weft_cost_model model;
    REFUSED(weft_context_kind_parse(&logger, "", &kind));
    REFUSED(weft_profile_parse(&logger, "", &profile));
    REFUSED(weft_profile_parse(&logger, "bits=1e99", &profile));
    REFUSED(weft_cost_parse(&logger, "voxel nan", &model));
}

static const float voxels[4 * 4 * 4] = {1.0f, 2.0f, 3.0f};

static weft_volume *volume(void)
{
    weft_volume *v = NULL;
    const struct weft_volume_params *p =
        weft_volume_params(.size = {4, 4, 4}, .data = voxels, .log = &logger);
    if (weft_volume_create(p, &v) != WEFT_OK)
        exit(1);
    return v;
}

static enum weft_result make_volume(const struct weft_volume_params *p)
{
    weft_volume *v = NULL;
    const enum weft_result res = weft_volume_create(p, &v);
    weft_volume_destroy(&v);
    return res;
}

static enum weft_result make_bricks(const struct weft_volume_bricks_params *p)
{
    weft_volume *v = NULL;
    const enum weft_result res = weft_volume_create_bricks(p, &v);
    weft_volume_destroy(&v);
    return res;
}

static void volumes(void)
{
    struct weft_volume_params good = {.size = {4, 4, 4}, .data = voxels, .log = &logger};
    for (int a = 0; a < 3; a++) {
        SET_REFUSED(good, size[a], 0, make_volume(&p));
        SET_REFUSED(good, size[a], INT_MIN, make_volume(&p));
        SET_REFUSED(good, size[a], INT_MAX, make_volume(&p));
        ANY_INT(good, origin[a], make_volume(&p));
        ANY_NUMBER(good, index_to_world[a][a], make_volume(&p));
    }
    ANY_NUMBER(good, background, make_volume(&p));

    static const float values[512];
    static int32_t origins[2][3];
    static struct weft_volume_tile tile[1];
    struct weft_volume_bricks_params bricks = {.brick_count = 1,
                                               .brick_origin = (const int32_t(*)[3])origins,
                                               .brick_values = values,
                                               .tile_count = 0,
                                               .tiles = tile,
                                               .log = &logger};
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        origins[0][0] = ints[i];
        SURVIVED(make_bricks(&bricks));
        tile[0] = (struct weft_volume_tile){.size = ints[i]};
        struct weft_volume_bricks_params p = {.tile_count = 1, .tiles = tile, .log = &logger};
        SURVIVED(make_bricks(&p));
        tile[0] = (struct weft_volume_tile){.size = 128, .origin = {ints[i], 0, 0}};
        SURVIVED(make_bricks(&p));
    }
    origins[0][0] = 3; // no multiple of 8
    REFUSED(make_bricks(&bricks));
    ANY_NUMBER(bricks, index_to_world[0][1], make_bricks(&p));
    weft_volume_destroy(NULL);
}

static void volume_files(void)
{
    weft_volume *out = NULL, *v = volume();
    struct weft_volume_list list = {0};
    const struct weft_volume_open_params missing = {.path = "/nonexistent", .log = &logger};
    const struct weft_volume_save_params nowhere = {.path = "/nonexistent/x.vdb", .log = &logger};
    REFUSED(weft_volume_open(&missing, &out));
    weft_volume_opening *opening = NULL;
    const struct weft_volume_open_params nameless = {.log = &logger};
    REFUSED(weft_volume_begin(&nameless, &opening));
    assert_int_equal(weft_volume_begin(&missing, &opening), WEFT_OK);
    REFUSED(weft_volume_await(&opening, &out));
    assert_int_equal(weft_volume_begin(&missing, &opening), WEFT_OK);
    weft_volume_abandon(&opening);
    weft_volume_abandon(&opening);
    weft_volume_abandon(NULL);
    REFUSED(weft_volume_list_load(&missing, &list));
    REFUSED(weft_volume_save(v, &nowhere));
    weft_volume_list_clear(&list);
    weft_volume_list_clear(NULL);
    REFUSED(weft_file_save(&logger, "/nonexistent/x", false, "", 0));
    REFUSED(weft_file_save(&logger, "", false, NULL, 0));
    REFUSED(weft_file_save_parts(&logger, "/nonexistent/x", false, NULL, 0));
    REFUSED(weft_file_save_parts(&logger, "x", false, NULL, 1));
    REFUSED(weft_file_save_parts(&logger, "x", false, &(struct weft_bytes){NULL, 1}, 1));
    weft_unfinished_discard();
    weft_volume_get_info(v);
    weft_volume_destroy(&v);
}

static enum weft_result prefilter_volume(weft_volume *v, const struct weft_kernel *kernel)
{
    weft_volume *out = NULL;
    const enum weft_result res = weft_volume_prefilter(v, kernel, &logger, &out);
    weft_volume_destroy(&out);
    return res;
}

static enum weft_result find_bricks(weft_volume *v, const struct weft_region *region)
{
    struct weft_brick_list list = {0};
    const enum weft_result res = weft_volume_find(v, region, &list);
    weft_brick_list_clear(&list);
    return res;
}

static void volume_voxels(void)
{
    weft_volume *v = volume();
    float values[2 * 512];
    EACH_BAD_KERNEL(0, REFUSED(prefilter_volume(v, &kernel)))
    struct weft_region good = {.min = {0, 0, 0}, .max = {3, 3, 3}};
#define CALL find_bricks(v, &p)
    SET_REFUSED(good, slab_count, 99, CALL);
    SET_REFUSED(good, slab_count, -1, CALL);
    SET_REFUSED(good, slab_count, INT_MAX, CALL);
    ANY_INT(good, min[0], CALL);
    ANY_INT(good, max[1], CALL);
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        struct weft_region p = good;
        p.slab_count = 1;
        p.slab[0] = (struct weft_slab){.normal = {numbers[n], 0, 0}, .upper = numbers[n]};
        SURVIVED(CALL);
    }
#undef CALL
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        const int32_t origin[1][3] = {{ints[i], 0, 0}};
        SURVIVED(weft_volume_read(v, 1, origin, values));
    }
    SURVIVED(weft_volume_read(v, 0, NULL, NULL));
    weft_brick_list_clear(NULL);
    weft_volume_destroy(&v);
}

static void images(void)
{
    static float plane[4];
    struct weft_image out = {0};
    struct weft_image_channel channel = {.name = "Y", .plane = plane};
    const struct weft_image_save_params null_device = {.path = "/dev/null", .log = &logger};
    const struct weft_image_load_params missing = {.path = "/nonexistent", .log = &logger};
    struct weft_image good = {.width = 2, .height = 2, .channel_count = 1, .channels = &channel};
#define CALL weft_image_save(&p, &null_device)
    SET_REFUSED(good, width, 0, CALL);
    SET_REFUSED(good, width, INT_MIN, CALL);
    SET_REFUSED(good, height, -1, CALL);
    SET_REFUSED(good, channel_count, 0, CALL);
    SET_REFUSED(good, compression, (enum weft_image_compression)99, CALL);
    ANY_INT(good, x, CALL);
    ANY_INT(good, y, CALL);
    ANY_INT(good, display_max[0], CALL);
    ANY_INT(good, display_min[1], CALL);
#undef CALL
    memset(channel.name, 'x', sizeof channel.name); // without an end
    SURVIVED(weft_image_save(&good, &null_device));
    memset(channel.name, 0, sizeof channel.name);
    SURVIVED(weft_image_save(&good, &null_device));
    REFUSED(weft_image_load(&missing, &out));
    weft_image_clear(&out);
    weft_image_clear(NULL);
    struct weft_image_list list;
    REFUSED(weft_image_list_load(&missing, &list));
    weft_image_list_clear(&list);
    weft_image_list_clear(NULL);
    REFUSED(weft_image_save_parts(&good, 0, &null_device, NULL));
    REFUSED(weft_image_save_parts(NULL, 1, &null_device, NULL));
    struct weft_image_packed packed;
    REFUSED(weft_image_pack(&good, 1, &logger, &packed)); // a channel without a name
    REFUSED(weft_image_pack(&good, -1, &logger, &packed));
    strcpy(channel.name, "Y");
    REFUSED(weft_image_pack(&(struct weft_image){.width = 2}, 1, &logger, &packed));
    TRUE(weft_image_pack(&good, 1, &logger, &packed) == WEFT_OK && packed.size > 4);
    weft_image_packed_clear(&packed);
    weft_image_packed_clear(&packed);
    TRUE(weft_image_block_lines(WEFT_IMAGE_ZIP) == 16);
    TRUE(weft_image_block_lines((enum weft_image_compression)99) == 1);
    const struct weft_image_attribute odd = {"a", "v2f", plane, 3};
    char text[4];
    assert_true(weft_image_attribute_format(&odd, text, sizeof text) > sizeof text);
    assert_null(weft_image_find(&good, "a"));
    assert_false(weft_image_is_writable((enum weft_image_compression)99));
    assert_false(weft_image_is_writable((enum weft_image_compression) - 1));
}

static const char *missing_name(void *priv, int64_t i)
{
    (void)priv;
    return i ? "/nonexistent" : NULL;
}

static void sequences(void)
{
    weft_image_sequence *sequence = NULL;
    const struct weft_image_frame *frame = NULL;
    struct weft_image_sequence_params good = {.count = 2, .name = missing_name, .log = &logger};
#define CALL weft_image_sequence_create(&p, &sequence)
    SET_REFUSED(good, count, 0, CALL);
    SET_REFUSED(good, count, INT64_MIN, CALL);
    SET_REFUSED(good, name, NULL, CALL);
    SET_REFUSED(good, readers, -1, CALL);
    SET_REFUSED(good, readers, INT_MAX, CALL);
    SET_REFUSED(good, part, -1, CALL);
    assert_null(sequence);
#undef CALL
    assert_int_equal(weft_image_sequence_create(&good, &sequence), WEFT_OK);
    assert_int_equal(weft_image_sequence_next(sequence, &frame), WEFT_OK);
    assert_int_equal(frame->index, 1);
    assert_int_equal(frame->result, WEFT_ERR_OPEN);
    assert_non_null(strstr(frame->message, "/nonexistent"));
    for (int i = 0; i < 2; i++) {
        assert_int_equal(weft_image_sequence_next(sequence, &frame), WEFT_OK);
        assert_null(frame);
    }
    REFUSED(weft_image_sequence_extend(sequence, 0));
    REFUSED(weft_image_sequence_extend(sequence, INT64_MIN));
    REFUSED(weft_image_sequence_extend(sequence, INT64_MAX));
    weft_image_sequence_destroy(&sequence);
    weft_image_sequence_destroy(&sequence);
    weft_image_sequence_destroy(NULL);
}

static void previews(void)
{
    static const float plane[4];
    struct weft_preview_params good = {
        .path = "/dev/null", .width = 2, .height = 2, .plane = plane, .log = &logger};
#define CALL weft_preview_save(&p, NULL)
    SET_REFUSED(good, width, 0, CALL);
    SET_REFUSED(good, width, -1, CALL);
    SET_REFUSED(good, height, INT_MIN, CALL);
    ANY_NUMBER(good, low, CALL);
    ANY_NUMBER(good, high, CALL);
#undef CALL
    struct weft_colour_preview_params colours = {.path = "/dev/null",
                                                 .width = 2,
                                                 .height = 2,
                                                 .red = plane,
                                                 .green = plane,
                                                 .blue = plane,
                                                 .log = &logger};
#define CALL weft_colour_preview_save(&p)
    SET_REFUSED(colours, width, 0, CALL);
    SET_REFUSED(colours, height, INT_MIN, CALL);
    SET_REFUSED(colours, blue, NULL, CALL);
    SET_REFUSED(colours, threads, -1, CALL);
    ANY_NUMBER(colours, low, CALL);
    ANY_NUMBER(colours, high, CALL);
#undef CALL
}

static void planes(void)
{
    static const float values[4] = {1.0f, 2.0f, 3.0f, 4.0f};
    float row[2];
    struct weft_plane plane = {.values = values};
    TRUE(weft_plane_line(&plane, 1, 2) == values + 2);
    for (size_t i = 0; i < sizeof bad_enums / sizeof *bad_enums; i++) {
        plane.type = (enum weft_plane_type)bad_enums[i];
        TRUE(weft_plane_type_size(plane.type) == 0);
        weft_plane_row(&plane, 0, 2, row, 1);
    }
}

static void kernel_files(void)
{
    struct weft_kernel kernel;
    weft_kernel_file *file = NULL;
    REFUSED(weft_kernel_load(&logger, "table:/nonexistent", &kernel, &file));
    REFUSED(weft_kernel_load(&logger, "table:", &kernel, &file));
    weft_kernel_file_destroy(&file);
    weft_kernel_file_destroy(NULL);
}

// ---- passes/: what plans ------------------------------------------------------------------------

static enum weft_result make_accum_buffer(const struct weft_accum_buffer_params *p)
{
    weft_accum_buffer *buffer = NULL;
    const enum weft_result res = weft_accum_buffer_create(p, &buffer);
    weft_accum_buffer_destroy(&buffer);
    return res;
}

static void accum_buffers(void)
{
    struct weft_accum_buffer_params good = {
        .width = 2, .height = 2, .channel_count = 1, .log = &logger};
    const float values[4] = {0.0f, 1.0f, NAN, INFINITY};
    const struct weft_plane plane = {.values = values}, none = {.values = NULL};
    float out[4];
    weft_accum_buffer *buffer = NULL;
    for (int i = -1; i <= 0; i++) {
        SET_REFUSED(good, width, i, make_accum_buffer(&p));
        SET_REFUSED(good, height, i, make_accum_buffer(&p));
        SET_REFUSED(good, channel_count, i, make_accum_buffer(&p));
    }
    for (size_t i = 0; i < WEFT_COUNT(ints); i++)
        if (ints[i] != 0)
            SET_REFUSED(good, bits, ints[i], make_accum_buffer(&p));
    BAD_ENUM(good, rounding, make_accum_buffer(&p));
    BAD_ENUM(good, cpu.instructions, make_accum_buffer(&p));
    SET_REFUSED(good, cpu.threads, -1, make_accum_buffer(&p));
    TRUE(weft_accum_buffer_create(&good, &buffer) == WEFT_OK);
    for (size_t i = 0; i < 5; i++) {
        REFUSED(weft_accum_buffer_load(buffer, &plane, numbers[i]));
        REFUSED(weft_accum_buffer_accum(buffer, &plane, numbers[i]));
        REFUSED(weft_accum_buffer_add(buffer, numbers[i]));
        REFUSED(weft_accum_buffer_mult(buffer, numbers[i]));
    }
    REFUSED(weft_accum_buffer_load(buffer, &none, 1.0));
    TRUE(weft_accum_buffer_load(buffer, &plane, 1e12) == WEFT_OK);
    TRUE(weft_accum_buffer_accum(buffer, &plane, -1e12) == WEFT_OK);
    REFUSED(weft_accum_buffer_return(buffer, NAN, 0, out, 0));
    REFUSED(weft_accum_buffer_return(buffer, 1.0, 1, out, 0));
    REFUSED(weft_accum_buffer_return(buffer, 1.0, 0, out, 1));
    REFUSED(weft_accum_buffer_read(buffer, 1.0, INFINITY, 0, out, 0));
    REFUSED(weft_accum_buffer_read(buffer, 1.0, 0.0, -1, out, 0));
    TRUE(weft_accum_buffer_read(buffer, 1.0, 0.0, 0, out, 0) == WEFT_OK);
    weft_accum_buffer_destroy(&buffer);
    weft_accum_buffer_destroy(NULL);
}

// ---- effects by accumulation --------------------------------------------------------------------

static enum weft_result make_jitter(const struct weft_jitter_params *p)
{
    struct weft_jitter set;
    const enum weft_result res = weft_jitter_create(p, &set);
    TRUE((res == WEFT_OK) == (set.points != NULL));
    weft_jitter_clear(&set);
    return res;
}

static void jitters(void)
{
    struct weft_jitter_params good = {.info = weft_jitter_find("grid"), .log = &logger};
    const struct weft_jitter_info *info, none = {0};
    int count;
    SET_REFUSED(good, info, NULL, make_jitter(&p));
    SET_REFUSED(good, info, &none, make_jitter(&p));
    BAD_ENUM(good, shape, make_jitter(&p));
    ANY_INT(good, count, make_jitter(&p));
    ANY_NUMBER(good, size, make_jitter(&p));
    SET_REFUSED(good, count, -1, make_jitter(&p));
    SET_REFUSED(good, count, INT_MAX, make_jitter(&p));
    weft_jitter_clear(NULL);
    TRUE(weft_jitter_find(NULL) == NULL && weft_jitter_find("") == NULL);
    REFUSED(weft_jitter_parse(&logger, "", &info, &count));
    REFUSED(weft_jitter_parse(&logger, ":", &info, &count));
    REFUSED(weft_jitter_parse(&logger, "grid:99999999999999999999", &info, &count));
    REFUSED(weft_jitter_parse(&logger, "grid:1\n", &info, &count));
    TRUE(isnan(weft_jitter_radical_inverse(0, 0)) && isnan(weft_jitter_radical_inverse(1, 5)));
    TRUE(weft_jitter_radical_inverse(1u << 26, UINT64_MAX) < 1.0);
}

static void discrepancies(void)
{
    static const double points[2][2] = {{0.0, 0.1}, {0.2, 0.0}};
    static const double beyond[2][2] = {{0.0, 0.1}, {DBL_MAX, -DBL_MAX}};
    struct weft_discrepancy_params good = {.points = points, .count = 2, .log = &logger};
    struct weft_discrepancy d;
#define CALL weft_discrepancy_compute(&p, &d)
    SET_REFUSED(good, points, NULL, CALL);
    BAD_ENUM(good, shape, CALL);
    ANY_NUMBER(good, size, CALL);
    const int counts[] = {INT_MIN, -1, 0, WEFT_DISCREPANCY_MAX + 1, INT_MAX};
    for (size_t i = 0; i < WEFT_COUNT(counts); i++)
        SET_REFUSED(good, count, counts[i], CALL);
    struct weft_discrepancy_params far = good;
    far.points = beyond;
    SURVIVED(weft_discrepancy_compute(&far, &d));
#undef CALL
}

static void edges(void)
{
    struct weft_edge_value v;
    const double normal[2] = {0.6, 0.8};
    for (size_t i = 0; i < WEFT_COUNT(numbers); i++) {
        const double n[2] = {numbers[i], 1.0}, share = weft_edge_square(normal, numbers[i]);
        TRUE(isnan(numbers[i]) ? isnan(share) : share >= 0.0 && share <= 1.0);
        const double disc = weft_edge_disc(numbers[i]);
        TRUE(isnan(numbers[i]) ? isnan(disc) : disc >= 0.0 && disc <= 1.0);
        weft_edge_square(n, 0.1);
        const struct weft_kernel kernel = named("mitchell");
        SURVIVED(weft_edge_kernel(&logger, &kernel, 0.0, n, 0.1, &v));
        SURVIVED(weft_edge_kernel(&logger, &kernel, 0.0, normal, numbers[i], &v));
        SURVIVED(weft_edge_kernel(&logger, &kernel, numbers[i], normal, 0.1, &v));
    }
    for (int i = 0; i < BAD_KERNELS; i++) {
        const struct weft_kernel kernel = bad_kernel(i);
        REFUSED(weft_edge_kernel(&logger, &kernel, 0.0, normal, 0.1, &v));
    }
}

static void frame_weights(void)
{
    static const double points[2][2] = {{0.0, 0.1}, {0.2, 0.0}};
    static const double beyond[2][2] = {{0.0, 0.1}, {DBL_MAX, -DBL_MAX}};
    struct weft_weights_kernel_params good = {.points = points, .count = 2, .log = &logger};
    double weights[2];
#define CALL weft_weights_kernel(&p, weights, NULL)
    SET_REFUSED(good, points, NULL, CALL);
    SET_REFUSED(good, count, 0, CALL);
    SET_REFUSED(good, count, INT_MIN, CALL);
    ANY_NUMBER(good, width, CALL);
    for (int i = 1; i < BAD_KERNELS; i++)
        SET_REFUSED(good, kernel, bad_kernel(i), CALL);
#undef CALL
    good.points = beyond;
    SURVIVED(weft_weights_kernel(&good, weights, NULL));
    REFUSED(weft_weights_even(&logger, 0, weights, NULL));
    REFUSED(weft_weights_even(&logger, INT_MIN, weights, NULL));
    REFUSED(weft_weights_even(&logger, 2, NULL, NULL));
    REFUSED(weft_weights_normalise(&logger, INT_MIN, weights, NULL));
    REFUSED(weft_weights_normalise(&logger, 2, NULL, NULL));
    for (size_t i = 0; i < WEFT_COUNT(numbers); i++) {
        struct weft_weights_report report;
        weights[0] = numbers[i];
        weights[1] = -1.0;
        SURVIVED(weft_weights_normalise(&logger, 2, weights, &report));
    }
}

static void patterns(void)
{
    static const double device[2][2] = {{0.25, -0.25}, {-0.25, 0.25}};
    static const double beyond[2][2] = {{0.0, 0.1}, {DBL_MAX, -DBL_MAX}};
    struct weft_pattern_params good = {
        .device = device, .device_count = 2, .count = 4, .log = &logger};
    static struct weft_pattern pattern;
#define CALL weft_pattern_create(&p, &pattern)
    SET_REFUSED(good, device, NULL, CALL);
    SET_REFUSED(good, device, beyond, CALL);
    SET_REFUSED(good, device_count, 0, CALL);
    SET_REFUSED(good, device_count, INT_MIN, CALL);
    SET_REFUSED(good, device_count, 3, CALL);
    SET_REFUSED(good, device_count, INT_MAX, CALL);
    ANY_INT(good, count, CALL);
#undef CALL
    REFUSED(weft_pattern_create(&(struct weft_pattern_params){.log = &logger}, &pattern));
}

static void spreads(void)
{
    static const double points[2][2] = {{0.0, 0.1}, {0.2, 0.0}};
    static const double beyond[2][2] = {{0.0, 0.1}, {DBL_MAX, -DBL_MAX}};
    struct weft_spread_params good = {.position = points, .count = 2, .log = &logger};
    struct weft_spread s;
#define CALL weft_spread_create(&p, &s)
#define CALL_AND_CLEAR (CALL == WEFT_OK ? weft_spread_clear(&s), WEFT_OK : WEFT_ERR_ARGUMENT)
    SET_REFUSED(good, position, NULL, CALL);
    SET_REFUSED(good, position, beyond, CALL);
    SET_REFUSED(good, count, 0, CALL);
    SET_REFUSED(good, count, INT_MAX, CALL);
    SET_REFUSED(good, bits, 31, CALL);
    SET_REFUSED(good, bits, INT_MIN, CALL);
    ANY_NUMBER(good, filter_width, CALL_AND_CLEAR);
    for (int i = 1; i < BAD_KERNELS; i++)
        SET_REFUSED(good, filter, bad_kernel(i), CALL);
#undef CALL_AND_CLEAR
#undef CALL
    weft_spread_clear(NULL);
}

static void antialias_bytes(void)
{
    for (size_t i = 0; i < WEFT_COUNT(bad_enums); i++)
        TRUE(weft_antialias_format_bytes((enum weft_antialias_format)bad_enums[i]) == 0);
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        const int n = ints[i];
        TRUE(weft_bytes_multisample(n, n, n, n, n) == 0 || n > 0);
        TRUE(weft_bytes_accumulative(n, n, n, n, n) == 0 || n > 0);
        TRUE(weft_bytes_adaptive(n, n, n, n, n, n) == 0 || n > 0);
    }
}

static void shutters(void)
{
    struct weft_shutter good = WEFT_SHUTTER_BOX, out;
    double weights[3];
#define CALL weft_shutter_weights(&logger, &p, 3, NULL, weights, NULL)
    BAD_ENUM(good, shape, CALL);
    ANY_NUMBER(good, open, CALL);
    ANY_NUMBER(good, close, CALL);
    good.shape = WEFT_SHUTTER_GAUSS;
    ANY_NUMBER(good, sigma, CALL);
#undef CALL
    good = (struct weft_shutter)WEFT_SHUTTER_TENT;
    REFUSED(weft_shutter_weights(&logger, &good, 0, NULL, weights, NULL));
    REFUSED(weft_shutter_weights(&logger, &good, INT_MIN, NULL, weights, NULL));
    REFUSED(weft_shutter_parse(&logger, "", &out));
    REFUSED(weft_shutter_parse(&logger, ":", &out));
    REFUSED(weft_shutter_parse(&logger, "gauss:1e999", &out));
    for (size_t i = 0; i < WEFT_COUNT(numbers); i++) {
        TRUE(isnan(weft_shutter_light(&good, numbers[i])) == isnan(numbers[i]));
        TRUE(isnan(weft_shutter_share(&good, numbers[i])) == isnan(numbers[i]));
        TRUE(weft_frames_for_motion(numbers[i]) == -1 || weft_frames_for_motion(numbers[i]) >= 1);
        TRUE(weft_frames_for_circle(numbers[i]) == -1 || weft_frames_for_circle(numbers[i]) >= 1);
        const int64_t frames = weft_frames_for_penumbra(numbers[i], numbers[i]);
        TRUE(frames == -1 || frames >= 1);
    }
}

static void cameras(void)
{
    struct weft_camera good = {WEFT_CAMERA_DEFAULTS};
    struct weft_camera_frame frame = {.size = {4, 3}, .lens = {0.1, 0.0}, .focus = 2.0};
    struct weft_camera_matrices m;
#define CALL weft_camera_compute(&logger, &p, &frame, &m)
    ANY_NUMBER(good, fovy_degrees, CALL);
    ANY_NUMBER(good, aspect, CALL);
    ANY_NUMBER(good, near_distance, CALL);
    ANY_NUMBER(good, far_distance, CALL);
    ANY_NUMBER(good, eye[1], CALL);
    ANY_NUMBER(good, target[2], CALL);
    ANY_NUMBER(good, up[0], CALL);
    SET_REFUSED(good, up[1], 0.0, CALL);
#undef CALL
#define CALL weft_camera_compute(&logger, &good, &p, &m)
    ANY_INT(frame, size[0], CALL);
    ANY_NUMBER(frame, move[0], CALL);
    ANY_NUMBER(frame, lens[1], CALL);
    ANY_NUMBER(frame, focus, CALL);
    SET_REFUSED(frame, size[1], 0, CALL);
    SET_REFUSED(frame, focus, 0.0, CALL);
#undef CALL
    TRUE(isnan(weft_camera_circle(&good, frame.size, -1.0, 2.0, 3.0)));
    for (size_t i = 0; i < WEFT_COUNT(numbers); i++) {
        const double sample[2] = {numbers[i], numbers[i]};
        double move[2];
        weft_camera_move_to(sample, move);
        weft_camera_circle(&good, frame.size, 1.0, 2.0, numbers[i]);
    }
}

static enum weft_result make_accumulator(const struct weft_accumulator_params *p)
{
    weft_accumulator *a = NULL;
    const enum weft_result res = weft_accumulator_create(p, &a);
    weft_accumulator_destroy(&a);
    return res;
}

static const struct weft_accumulator_params usual_accumulator = {.width = 2,
                                                                 .height = 2,
                                                                 .channel_count = 1,
                                                                 .method = WEFT_ACCUMULATE_EXACT,
                                                                 .keep = WEFT_KEEP_VARIANCE,
                                                                 .log = &logger};

static void accumulators(void)
{
    struct weft_accumulator_params good = usual_accumulator;
    static const double weights[2] = {1.0, -1.0};
#define CALL make_accumulator(&p)
    for (int i = -1; i <= 0; i++) {
        SET_REFUSED(good, width, i, CALL);
        SET_REFUSED(good, height, i, CALL);
        SET_REFUSED(good, channel_count, i, CALL);
    }
    BAD_ENUM(good, method, CALL);
    BAD_ENUM(good, nonfinite, CALL);
    BAD_ENUM(good, rounding, CALL);
    BAD_ENUM(good, cpu.instructions, CALL);
    SET_REFUSED(good, frame_count, -1, CALL);
    SET_REFUSED(good, frame_count, INT64_MAX, CALL);
    SET_REFUSED(good, weight, weights, CALL); // of how many frames?
    SET_REFUSED(good, keep, 4, CALL);
    SET_REFUSED(good, batch, -1, CALL);
    SET_REFUSED(good, cpu.threads, -1, CALL);
    for (int method = 0; method < WEFT_ACCUMULATE_METHOD_COUNT; method++) {
        struct weft_accumulator_params emulated = good;
        emulated.method = (enum weft_accumulate_method)method;
        emulated.emulate = true;
        TRUE(make_accumulator(&emulated) == WEFT_OK);
        ANY_INT(emulated, branching, CALL);
        ANY_INT(emulated, level_branching[0], CALL);
        ANY_INT(emulated, level_branching[WEFT_TREE_MAX_LEVELS - 1], CALL);
        ANY_INT(emulated, bits, CALL);
        ANY_INT(emulated, frame_bits, CALL);
        ANY_NUMBER(emulated, low, CALL);
        ANY_NUMBER(emulated, high, CALL);
        ANY_NUMBER(emulated, max_error, CALL);
        emulated.frame_count = 2;
        SET_REFUSED(emulated, weight, weights, CALL); // adds up to 0
        emulated.emulate = false;
        emulated.weight = NULL;
        const bool on_gl = method == WEFT_ACCUMULATE_TREE || method == WEFT_ACCUMULATE_BLEND ||
                           method == WEFT_ACCUMULATE_FLOAT;
        TRUE((make_accumulator(&emulated) != WEFT_OK) == on_gl); // there is no context
        lines = 0;
    }
#undef CALL
}

static void accumulations(void)
{
    static const float values[4] = {1.0f, 2.0f, 3.0f, 4.0f};
    const struct weft_plane plane = {.values = values}, empty = {.values = NULL};
    struct weft_plane unknown = plane;
    const struct weft_frame frame = {.plane = &plane}, none = {.plane = NULL};
    struct weft_accumulator_report report;
    weft_accumulator *a = NULL;
    float out[4];
    TRUE(weft_accumulator_create(&usual_accumulator, &a) == WEFT_OK);
    REFUSED(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, out, 0)); // no frame
    REFUSED(weft_accumulator_finish(a));
    REFUSED(weft_accumulator_add(a, NULL, 1.0));
    REFUSED(weft_accumulator_add(a, &none, 1.0));
    REFUSED(weft_accumulator_add(a, &(struct weft_frame){.plane = &empty}, 1.0));
    REFUSED(weft_accumulator_add(a, &(struct weft_frame){.plane = &plane, .texture = 1}, 1.0));
    REFUSED(weft_accumulator_add(a, &(struct weft_frame){.texture = 1}, 1.0));
    for (size_t i = 0; i < WEFT_COUNT(bad_enums); i++) {
        unknown.type = (enum weft_plane_type)bad_enums[i];
        REFUSED(weft_accumulator_add(a, &(struct weft_frame){.plane = &unknown}, 1.0));
    }
    for (size_t i = 0; i < WEFT_COUNT(numbers); i++)
        SURVIVED(weft_accumulator_add(a, &frame, numbers[i]));
    TRUE(weft_accumulator_add(a, &frame, 1.0) == WEFT_OK);
    TRUE(weft_accumulator_add(a, &frame, 5.0) == WEFT_OK);
    for (size_t i = 0; i < WEFT_COUNT(bad_enums); i++)
        REFUSED(weft_accumulator_current(a, (enum weft_accumulated)bad_enums[i], 0, out, 0));
    REFUSED(weft_accumulator_current(a, WEFT_ACCUMULATED_MINIMUM, 0, out, 0)); // is not kept
    REFUSED(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, -1, out, 0));
    REFUSED(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 1, out, 0));
    REFUSED(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, out, 1));
    REFUSED(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, NULL, 0));
    TRUE(weft_accumulator_finish(a) == WEFT_OK && weft_accumulator_finish(a) == WEFT_OK);
    REFUSED(weft_accumulator_add(a, &frame, 1.0));
    TRUE(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, out, 0) == WEFT_OK);
    weft_accumulator_get_report(a, &report);
    TRUE(report.method == WEFT_ACCUMULATE_EXACT && report.counted >= 2);
    weft_accumulator_destroy(&a);
    weft_accumulator_destroy(&a);
    weft_accumulator_destroy(NULL);
}

static void accumulator_judgements(void)
{
    static const float values[4] = {1.0f, 2.0f, 3.0f, 4.0f};
    const struct weft_plane plane = {.values = values};
    struct weft_until good = {.absolute = 1.0};
    struct weft_accumulator_params plain = usual_accumulator;
    struct weft_convergence found;
    weft_accumulator *a = NULL;
    TRUE(weft_accumulator_create(&plain, &a) == WEFT_OK);
    REFUSED(weft_accumulator_judge(a, &good, &found)); // no frame
    TRUE(weft_accumulator_add(a, &(struct weft_frame){.plane = &plane}, 1.0) == WEFT_OK);
#define CALL weft_accumulator_judge(a, &p, &found)
    SET_REFUSED(good, absolute, 0.0, CALL);
    ANY_NUMBER(good, absolute, CALL);
    ANY_NUMBER(good, relative, CALL);
    ANY_NUMBER(good, share, CALL);
    SET_REFUSED(good, share, 1.5, CALL);
    SET_REFUSED(good, least, 1, CALL);
    SET_REFUSED(good, least, INT64_MIN, CALL);
    ANY_INT(good, radius, CALL);
#undef CALL
    weft_accumulator_destroy(&a);
    plain.keep = 0;
    TRUE(weft_accumulator_create(&plain, &a) == WEFT_OK);
    TRUE(weft_accumulator_add(a, &(struct weft_frame){.plane = &plane}, 1.0) == WEFT_OK);
    REFUSED(weft_accumulator_judge(a, &good, &found));
    weft_accumulator_destroy(&a);
}

static void accumulator_states(void)
{
    weft_accumulator *a = NULL, *b = NULL;
    struct weft_accumulator_params buffer = usual_accumulator;
    static const unsigned char nonsense[200];
    void *state = NULL;
    size_t size = 0;
    buffer.method = WEFT_ACCUMULATE_BUFFER;
    TRUE(weft_accumulator_create(&usual_accumulator, &a) == WEFT_OK);
    TRUE(weft_accumulator_create(&buffer, &b) == WEFT_OK);
    REFUSED(weft_accumulator_join(a, a));
    REFUSED(weft_accumulator_join(a, b));
    REFUSED(weft_accumulator_join(b, a));
    REFUSED(weft_accumulator_join(a, NULL));
    REFUSED(weft_accumulator_load(a, NULL, 0));
    REFUSED(weft_accumulator_load(a, nonsense, 0));
    REFUSED(weft_accumulator_load(a, nonsense, sizeof nonsense));
    TRUE(weft_accumulator_save(a, &state, &size) == WEFT_OK);
    REFUSED(weft_accumulator_load(b, state, size));
    TRUE(weft_accumulator_load(a, state, size) == WEFT_OK);
    free(state);
    weft_accumulator_destroy(&a);
    weft_accumulator_destroy(&b);
}

static enum weft_result make_tree(const struct weft_tree_params *p)
{
    weft_tree *tree = NULL;
    const enum weft_result res = weft_tree_create(p, &tree);
    weft_tree_destroy(&tree);
    return res;
}

static void trees(void)
{
    struct weft_tree_params good = {.leaf_count = 3, .log = &logger};
    const struct weft_tree_source nothing = {.fill = NULL};
    uint16_t code;
    weft_tree *tree = NULL;
    ANY_INT(good, leaf_count, make_tree(&p));
    ANY_INT(good, branching, make_tree(&p));
    ANY_INT(good, level_branching[0], make_tree(&p));
    ANY_INT(good, level_branching[15], make_tree(&p));
    static const uint32_t weights[3] = {0, UINT32_MAX, UINT32_MAX};
    SET_REFUSED(good, weight, weights, make_tree(&p));
    static const double errors_lsb[3] = {NAN, INFINITY, -1.0};
    SURVIVED(make_tree(
        &(struct weft_tree_params){.leaf_count = 3, .leaf_error_lsb = errors_lsb, .log = &logger}));
    TRUE(weft_tree_create(&good, &tree) == WEFT_OK);
    TRUE(weft_tree_get_info(tree)->leaf_count == 3);
    REFUSED(weft_tree_run_codes(tree, &nothing, 1, &code));
    weft_tree_destroy(&tree);
    weft_tree_destroy(NULL);
}

static enum weft_result make_plan(const struct weft_pass_plan_params *p)
{
    weft_pass_plan *plan = NULL;
    const enum weft_result res = weft_pass_plan_create(p, &plan);
    weft_pass_plan_destroy(&plan);
    return res;
}

static void plans(void)
{
    struct weft_pass_plan_params good = {.samples = 8, .log = &logger, .memory_bytes = 1 << 24};
#define CALL make_plan(&p)
    KERNELS_REFUSED(good, 1, CALL);
    ANY_INT(good, dims, CALL);
    ANY_INT(good, derivative, CALL);
    ANY_INT(good, taps_per_pass, CALL);
    ANY_INT(good, samples, CALL);
    ANY_INT(good, bits, CALL);
    ANY_INT(good, channels, CALL);
    BAD_ENUM(good, technique, CALL);
    BAD_ENUM(good, worst_case, CALL);
    BAD_ENUM(good, order, CALL);
    struct weft_pass_plan_params own = good;
    own.profile = *weft_profile_find("radeon8500");
    BAD_ENUM(own, profile.target, CALL);
    ANY_INT(own, profile.internal_bits, CALL);
    ANY_INT(own, profile.taps_per_pass, CALL);
    ANY_INT(own, profile.dot_width, CALL);
    ANY_INT(own, profile.max_scale, CALL);
    ANY_NUMBER(own, profile.internal_range, CALL);
    struct weft_pass_plan_params endless = own;
    memset(endless.profile.name, 'x', sizeof endless.profile.name);
    REFUSED(make_plan(&endless));
    struct weft_tile_name names[1] = {{{0}, WEFT_TILE_WHOLE, 0}};
    const struct weft_pass_plan_split splits[1] = {
        {{{99, -1, INT_MAX}, (enum weft_tile_part)77, -5}, NAN}};
    struct weft_pass_plan_params given = good;
    given.order = WEFT_ORDER_GIVEN;
    given.tile_order = names;
    given.tile_order_count = 1;
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        names[0] = (struct weft_tile_name){{ints[i], 0, 0}, WEFT_TILE_WHOLE, ints[i]};
        SURVIVED(make_plan(&given));
    }
    for (size_t i = 0; i < WEFT_COUNT(bad_enums); i++) {
        names[0].part = (enum weft_tile_part)bad_enums[i];
        REFUSED(make_plan(&given));
    }
    struct weft_pass_plan_params split = good;
    split.splits = splits;
    split.split_count = 1;
    REFUSED(make_plan(&split));
#undef CALL
    weft_pass_plan_destroy(NULL);
}

static weft_pass_plan *plan(int dims)
{
    weft_pass_plan *made = NULL;
    const struct weft_pass_plan_params *p =
        weft_pass_plan_params(.kernel = named("linear"), .dims = dims, .samples = 8,
                              .log = &logger);
    if (weft_pass_plan_create(p, &made) != WEFT_OK)
        exit(1);
    return made;
}

static void plan_questions(void)
{
    weft_pass_plan *made = plan(2);
    TRUE(weft_pass_plan_get_info(made)->tile_count > 0);
    const weft_kernel_tiles *tiles = weft_pass_plan_get_info(made)->passes->tiles;
    char text[WEFT_TILE_NAME_TEXT];
    struct weft_tile_name name;
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        name = weft_tile_name_of(tiles, ints[i], i % 2);
        TRUE(weft_tile_name_format(&name, ints[i], text) == text);
        name = (struct weft_tile_name){
            {ints[i], ints[i], ints[i]}, (enum weft_tile_part)ints[i], ints[i]};
        TRUE(weft_tile_name_format(&name, ints[i], text) == text);
        TRUE(weft_tile_name_find(tiles, &name) < weft_pass_plan_get_info(made)->tile_count);
        weft_tile_name_parse("1,2,3-/4", ints[i], &name);
    }
    TRUE(!weft_tile_name_parse("", 2, &name) && !weft_tile_name_parse("1,-2", 2, &name));
    TRUE(!weft_tile_name_parse("1,100000", 2, &name) && !weft_tile_name_parse("1,2/", 2, &name));
    weft_pass_plan_destroy(&made);
}

static void profiles(void)
{
    struct weft_profile bad = {0};
    REFUSED(weft_profile_check(&logger, &bad));
    bad = *weft_profile_find("unorm8");
    TRUE(weft_profile_check(&logger, &bad) == WEFT_OK);
    bad.target = (enum weft_target_format)77;
    REFUSED(weft_profile_check(&logger, &bad));
}

static void ranges(void)
{
    weft_pass_plan *made = plan(2);
    struct weft_pass_list good = *weft_pass_plan_get_info(made)->passes;
    struct weft_range_report report;
#define CALL weft_range_simulate(&logger, &p, WEFT_WORST_CONSTANT, NULL, NULL, &report)
    for (size_t i = 0; i < WEFT_COUNT(bad_enums); i++)
        REFUSED(weft_range_simulate(&logger, &good, (enum weft_worst_case)bad_enums[i], NULL, NULL,
                                    &report));
    TRUE(weft_pass_list_check(&logger, &good) == WEFT_OK);
    BAD_ENUM(good, target, weft_pass_list_check(&logger, &p));
    SET_REFUSED(good, passes, NULL, weft_pass_list_check(&logger, &p));
    SET_REFUSED(good, slot_count, 0, weft_pass_list_check(&logger, &p));
    BAD_ENUM(good, target, CALL);
    ANY_INT(good, dims, CALL);
    ANY_INT(good, dot_width, CALL);
    ANY_INT(good, extra_bits, CALL);
    ANY_INT(good, result, CALL);
    ANY_NUMBER(good, range, CALL);
    ANY_NUMBER(good, result_scale, CALL);
    SET_REFUSED(good, slot_count, -1, CALL);
    SET_REFUSED(good, slot_count, 0, CALL);
    SET_REFUSED(good, pass_count, -1, CALL);
    struct weft_pass pass = good.passes[0];
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        struct weft_pass_list p = good;
        p.passes = &pass;
        p.pass_count = 1;
#define MEMBER(member)                                                                             \
    pass = good.passes[0];                                                                         \
    pass.member = (__typeof__(pass.member))ints[i];                                                \
    SURVIVED(CALL)
        MEMBER(kind);
        MEMBER(target);
        MEMBER(initial);
        MEMBER(part);
        MEMBER(bias);
        MEMBER(divisor);
        MEMBER(group_first);
        MEMBER(group_count);
        MEMBER(input_count);
        pass = (struct weft_pass){.kind = WEFT_PASS_COMBINE,
                                  .input_count = 1,
                                  .denominator = ints[i],
                                  .input = {ints[i]},
                                  .numerator = {ints[i]}};
        SURVIVED(CALL);
#undef MEMBER
    }
#undef CALL
    weft_pass_plan_destroy(&made);
}

static enum weft_result judge_plan(const struct weft_pass_plan_params *params,
                                   const struct weft_pass_list *passes)
{
    weft_pass_plan *judged = NULL;
    const enum weft_result res = weft_pass_plan_judge(params, passes, &judged);
    weft_pass_plan_destroy(&judged);
    return res;
}

static void judgements(void)
{
    weft_pass_plan *made = plan(2);
    struct weft_pass_list good = *weft_pass_plan_get_info(made)->passes;
    struct weft_pass_plan_params params =
        *weft_pass_plan_params(.kernel = named("linear"), .samples = 8, .memory_bytes = 1 << 22,
                               .log = &logger);
#define CALL judge_plan(&params, &p)
    TRUE(judge_plan(&params, &good) == WEFT_OK);
    TRUE(weft_pass_work_of(weft_pass_plan_get_info(made)).passes > 0.0);
    ANY_INT(good, extra_bits, CALL);
    ANY_INT(good, result, CALL);
    ANY_INT(good, pattern[1][0], CALL);
    ANY_NUMBER(good, result_scale, CALL);
    ANY_NUMBER(good, result_bias, CALL);
    SET_REFUSED(good, result_scale, NAN, CALL);
    SET_REFUSED(good, pass_count, -1, CALL);
    struct weft_pass pass;
    struct weft_tap_group group;
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        struct weft_pass_list p = good;
        p.passes = &pass;
        p.pass_count = 1;
#define MEMBER(member)                                                                             \
    pass = good.passes[0];                                                                         \
    pass.member = (__typeof__(pass.member))ints[i];                                                \
    SURVIVED(CALL)
        MEMBER(kind);
        MEMBER(target);
        MEMBER(initial);
        MEMBER(part);
        MEMBER(bias);
        MEMBER(divisor);
        MEMBER(group_first);
        MEMBER(group_count);
        MEMBER(input_count);
        pass = (struct weft_pass){.kind = WEFT_PASS_COMBINE,
                                  .input_count = 1,
                                  .denominator = ints[i],
                                  .input = {ints[i]},
                                  .numerator = {ints[i]}};
        SURVIVED(CALL);
#undef MEMBER
        pass = good.passes[0];
        pass.group_first = 0;
        pass.group_count = 1;
        p.groups = &group;
        p.group_count = 1;
#define MEMBER(member)                                                                             \
    group = good.groups[0];                                                                        \
    group.member = ints[i];                                                                        \
    SURVIVED(CALL)
        MEMBER(offset[0]);
        MEMBER(tile[0]);
        MEMBER(sign[0]);
        MEMBER(shift[0]);
#undef MEMBER
    }
    BAD_ENUM(params, technique, judge_plan(&p, &good));
#undef CALL
    weft_pass_plan_destroy(&made);
}

// ---- passes/: slices ----------------------------------------------------------------------------

static enum weft_result make_slice(weft_volume *v, const struct weft_slice_params *p)
{
    weft_slice_plan *made = NULL;
    const enum weft_result res = weft_slice_plan_create(v, p, &made);
    weft_slice_plan_destroy(&made);
    return res;
}

static struct weft_slice_params slice_params(weft_volume *v)
{
    struct weft_slice_params p = {.space = WEFT_SPACE_INDEX, .log = &logger};
    if (weft_slice_axis_geometry(&logger, v, p.space, 2, 1.5, 4, 4, &p.geometry) != WEFT_OK)
        exit(1);
    return p;
}

static void slice_geometry(void)
{
    weft_volume *v = volume();
    struct weft_slice_geometry good = slice_params(v).geometry;
    struct weft_slice_geometry out;
    for (size_t i = 0; i < WEFT_COUNT(bad_enums); i++) {
        const enum weft_space bad = (enum weft_space)bad_enums[i];
        struct weft_slice_geometry copy = good;
        REFUSED(weft_slice_size_compute(&logger, v, bad, &copy));
        REFUSED(weft_slice_axis_geometry(&logger, v, bad, 0, 0.0, 4, 4, &out));
        REFUSED(
            weft_slice_axis_geometry(&logger, v, WEFT_SPACE_INDEX, bad_enums[i], 0.0, 4, 4, &out));
    }
#define CALL weft_slice_size_compute(&logger, v, WEFT_SPACE_WORLD, &p)
    ANY_INT(good, width, CALL);
    ANY_INT(good, height, CALL);
    ANY_NUMBER(good, u[0], CALL);
    ANY_NUMBER(good, v[1], CALL);
    SET_REFUSED(good, u[0], NAN, CALL);
#undef CALL
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++)
        SURVIVED(weft_slice_axis_geometry(&logger, v, WEFT_SPACE_WORLD, 1, numbers[n], 4, 0, &out));
    for (size_t i = 0; i < WEFT_COUNT(ints); i++)
        SURVIVED(
            weft_slice_axis_geometry(&logger, v, WEFT_SPACE_WORLD, 1, 0.0, ints[i], ints[i], &out));
    weft_volume_destroy(&v);
}

static void slices(void)
{
    weft_volume *v = volume();
    struct weft_slice_params good = slice_params(v);
#define CALL make_slice(v, &p)
    KERNELS_REFUSED(good, 1, CALL);
    BAD_ENUM(good, space, CALL);
    BAD_ENUM(good, layout, CALL);
    BAD_ENUM(good, source, CALL);
    BAD_ENUM(good, lookup, CALL);
    SET_REFUSED(good, without, 1u << 31, CALL);
    SET_REFUSED(good, geometry.width, -1, CALL);
    SET_REFUSED(good, geometry.width, INT_MAX, CALL);
    SET_REFUSED(good, geometry.height, INT_MIN, CALL);
    for (int a = 0; a < 3; a++) {
        ANY_NUMBER(good, geometry.origin[a], CALL);
        ANY_NUMBER(good, geometry.u[a], CALL);
        ANY_NUMBER(good, geometry.v[a], CALL);
    }
    ANY_NUMBER(good, smooth_error, CALL);
    ANY_INT(good, memory_bytes, CALL);
    ANY_INT(good, max_target_size, CALL);
    ANY_INT(good, max_buffer_texels, CALL);
    struct weft_slice_params sampled = good;
    sampled.lookup = WEFT_LOOKUP_LINEAR;
    sampled.source = WEFT_SOURCE_UNORM8;
    sampled.high = 1.0;
    ANY_INT(sampled, samples, CALL);
    ANY_NUMBER(sampled, low, CALL);
    ANY_NUMBER(sampled, high, CALL);
#undef CALL
    weft_slice_plan_destroy(NULL);
    weft_volume_destroy(&v);
}

static enum weft_result make_footprint(const struct weft_footprint_params *p)
{
    weft_footprint *made = NULL;
    const enum weft_result res = weft_footprint_create(p, &made);
    weft_footprint_destroy(&made);
    return res;
}

static void footprints(void)
{
    weft_volume *v = volume();
    const struct weft_slice_params slice = slice_params(v);
    struct weft_footprint_params good = {
        .volume = v, .space = slice.space, .geometry = slice.geometry, .log = &logger};
#define CALL make_footprint(&p)
    KERNELS_REFUSED(good, 1, CALL);
    BAD_ENUM(good, space, CALL);
    SET_REFUSED(good, volume, NULL, CALL);
    SET_REFUSED(good, geometry.width, 0, CALL);
    SET_REFUSED(good, geometry.height, INT_MAX, CALL);
    for (int a = 0; a < 3; a++) {
        ANY_NUMBER(good, geometry.origin[a], CALL);
        ANY_NUMBER(good, geometry.u[a], CALL);
        ANY_NUMBER(good, geometry.v[a], CALL);
    }
    ANY_INT(good, memory_bytes, CALL);
#undef CALL
    weft_footprint *f = NULL;
    struct weft_slice_statistics statistics;
    TRUE(weft_footprint_create(&good, &f) == WEFT_OK);
    TRUE(weft_footprint_statistics(f, NULL, &statistics) == WEFT_OK);
    TRUE(weft_footprint_get_info(f)->bricks_read > 0);
    struct weft_slice_statistics of_part;
    REFUSED(weft_footprint_part_statistics(f, &(struct weft_rectangle){0, 0, INT_MAX, 1}, NULL,
                                           &of_part));
    REFUSED(
        weft_footprint_part_statistics(f, &(struct weft_rectangle){-1, 0, 1, 1}, NULL, &of_part));
    TRUE(weft_footprint_part_statistics(f, &(struct weft_rectangle){0, 0, 1, 1}, NULL, &of_part) ==
             WEFT_OK &&
         of_part.voxels > 0);
    of_part = weft_slice_statistics_join(&of_part, &statistics);
    TRUE(of_part.low == statistics.low && of_part.voxels > statistics.voxels);
    of_part.high = 4711.0;
    weft_footprint_set_statistics(f, &of_part);
    TRUE(weft_footprint_statistics(f, NULL, &statistics) == WEFT_OK && statistics.high == 4711.0);
    // A plan on it is of its slice.
    struct weft_slice_params shared = slice;
    shared.footprint = f;
#define CALL make_slice(v, &p)
    ANY_INT(shared, memory_bytes, CALL);
    SET_REFUSED(shared, geometry.width, slice.geometry.width + 1, CALL);
    SET_REFUSED(shared, space, WEFT_SPACE_WORLD, CALL);
#undef CALL
    weft_footprint_destroy(&f);
    weft_footprint_destroy(&f);
    weft_footprint_destroy(NULL);
    weft_volume_destroy(&v);
}

static enum weft_result make_resident(const struct weft_resident_params *p)
{
    weft_resident *made = NULL;
    const enum weft_result res = weft_resident_create(p, &made);
    weft_resident_destroy(&made);
    return res;
}

static void residents(void)
{
    weft_volume *v = volume(), *other = volume();
    struct weft_resident_params good = {.volume = v, .log = &logger};
#define CALL make_resident(&p)
    KERNELS_REFUSED(good, 1, CALL);
    BAD_ENUM(good, layout, CALL);
    BAD_ENUM(good, source, CALL);
    SET_REFUSED(good, volume, NULL, CALL);
    SET_REFUSED(good, layout, WEFT_LAYOUT_ALIGNED, CALL); // in memory
    SET_REFUSED(good, memory_bytes, 1, CALL);
    ANY_INT(good, memory_bytes, CALL);
    ANY_INT(good, brick_bytes, CALL);
    struct weft_resident_params mapped = good;
    mapped.source = WEFT_SOURCE_UNORM8;
    mapped.high = 1.0;
    ANY_NUMBER(mapped, low, CALL);
    ANY_NUMBER(mapped, high, CALL);
#undef CALL
    weft_resident *r = NULL;
    TRUE(weft_resident_create(&good, &r) == WEFT_OK);
    TRUE(weft_resident_get_info(r)->capacity > 0);
    // Slices are of its volume, its layout, and the engine that it was made for.
    struct weft_slice_params slice = slice_params(v);
    slice.engine = WEFT_ENGINE_CPU;
    slice.resident = r;
#define CALL make_slice(v, &p)
    SET_REFUSED(slice, engine, WEFT_ENGINE_GL, CALL);
    SET_REFUSED(slice, layout, WEFT_LAYOUT_INTERLEAVED, CALL);
    SET_REFUSED(slice, source, WEFT_SOURCE_HALF, CALL);
#undef CALL
    REFUSED(make_slice(other, &slice));
    weft_resident_destroy(&r);
    weft_resident_destroy(&r);
    weft_resident_destroy(NULL);
    weft_volume_destroy(&other);
    weft_volume_destroy(&v);
}

static enum weft_result make_method(weft_volume *v, const struct weft_method_params *p)
{
    weft_method_plan *made = NULL;
    const enum weft_result res = weft_method_plan_create(v, p, &made);
    weft_method_plan_destroy(&made);
    return res;
}

static void methods(void)
{
    weft_volume *v = volume();
    struct weft_method_params good = {.method = {.layout = WEFT_LAYOUT_PLAIN},
                                      .slice = slice_params(v),
                                      .statistics = {.low = 0.0, .high = 3.0, .voxels = 64}};
    char text[96];
    good.slice.memory_bytes = 1 << 22; // or sets of 99^3 samples would be made
#define CALL make_method(v, &p)
    BAD_ENUM(good, method.algorithm, CALL);
    BAD_ENUM(good, method.layout, CALL);
    BAD_ENUM(good, method.source, CALL);
    BAD_ENUM(good, method.lookup, CALL);
    BAD_ENUM(good, method.technique, CALL);
    ANY_NUMBER(good, statistics.low, CALL);
    ANY_NUMBER(good, statistics.difference[0], CALL);
    good.method.algorithm = WEFT_ALGORITHM_MULTIPASS;
    good.method.profile = *weft_profile_find("unorm8");
    good.method.samples = 8;
    ANY_INT(good, method.samples, CALL);
    ANY_INT(good, method.bits, CALL);
    BAD_ENUM(good, method.profile.target, CALL);
#undef CALL
    for (size_t i = 0; i < WEFT_COUNT(bad_enums); i++) {
        const int bad = bad_enums[i];
        const struct weft_method method = {.algorithm = (enum weft_algorithm)bad,
                                           .sums = (enum weft_sums)bad,
                                           .layout = (enum weft_layout)bad,
                                           .source = (enum weft_source_format)bad,
                                           .lookup = (enum weft_lookup)bad,
                                           .technique = (enum weft_technique)bad};
        weft_method_format(&method, text, sizeof text);
        struct weft_method fused = method;
        fused.algorithm = WEFT_ALGORITHM_FUSED;
        weft_method_format(&fused, text, sizeof text);
        struct weft_method cpu = method;
        cpu.engine = WEFT_ENGINE_CPU;
        weft_method_format(&cpu, text, sizeof text);
    }
    struct weft_method *list = NULL;
    size_t count;
    SURVIVED(weft_method_list(&logger, &list, &count));
    free(list);
    weft_method_plan_destroy(NULL);
    weft_volume_destroy(&v);
}

static void choices(void)
{
    weft_volume *v = volume();
    struct weft_choice choice = {0};
    struct weft_choose_params good = {.slice = slice_params(v), .max_error = 0.1};
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        if (numbers[n] >= 0.0 && numbers[n] < 1.0)
            continue;
        struct weft_choose_params p = good;
        p.max_error = numbers[n];
        if (!(numbers[n] >= 0.0))
            REFUSED(weft_choose(v, &p, &choice));
    }
    struct weft_choose_params p = good;
    p.slice.layout = (enum weft_layout)99;
    REFUSED(weft_choose(v, &p, &choice));
    p = good;
    p.engines = 99;
    REFUSED(weft_choose(v, &p, &choice));
    p = good;
    p.threads = -1;
    REFUSED(weft_choose(v, &p, &choice));
    weft_choice_clear(&choice);
    weft_choice_clear(NULL);
    weft_volume_destroy(&v);
}

static void costs(void)
{
    struct weft_cost_model model = weft_cost_default;
    free(weft_cost_format(&model));
    for (size_t i = 0; i < WEFT_COUNT(bad_enums); i++) {
        const int bad = bad_enums[i];
        const struct weft_work bad_works[] = {
            {.algorithm = (enum weft_algorithm)bad},
            {.algorithm = WEFT_ALGORITHM_FUSED, .of.fused.layout = (enum weft_layout)bad},
            {.algorithm = WEFT_ALGORITHM_FUSED, .of.fused.source = (enum weft_source_format)bad},
            {.algorithm = WEFT_ALGORITHM_MULTIPASS,
             .of.passes.plan.target = (enum weft_target_format)bad},
            {.engine = (enum weft_engine)bad},
            {.engine = WEFT_ENGINE_CPU, .sums = (enum weft_sums)bad},
            {.engine = WEFT_ENGINE_CPU, .algorithm = WEFT_ALGORITHM_MULTIPASS},
            {.engine = WEFT_ENGINE_CPU, .threads = -1},
        };
        for (size_t k = 0; k < WEFT_COUNT(bad_works); k++)
            TRUE(isnan(weft_cost_of(&model, &bad_works[k])));
        const struct weft_pass_plan_params params = {.technique = (enum weft_technique)bad,
                                                     .log = &logger};
        TRUE(weft_pass_work_least(&params).passes == 0.0);
        TRUE(isnan(weft_pass_bound_least(&params, 1.0).e2));
    }
    TRUE(isfinite(weft_cost_of(&model, &(struct weft_work){.algorithm = WEFT_ALGORITHM_FUSED})));
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        weft_separable_work_of(ints[n % WEFT_COUNT(ints)], numbers[n], 1.0, 2.0, numbers[n]);
        weft_pass_bound_least(&(struct weft_pass_plan_params){.samples = 8}, numbers[n]);
    }
    memset(model.renderer, 'x', sizeof model.renderer); // without an end
    model.instructions = (enum weft_instruction_set)99;
    free(weft_cost_format(&model));
}

// ---- passes/: what runs, on GL where that is to be had
// -------------------------------------------

static void meshes(void)
{
    struct weft_mesh mesh;
    const struct weft_mesh_params none = {.log = &logger},
                                  missing = {"/nowhere/a.obj", .log = &logger};
    REFUSED(weft_mesh_load(&none, &mesh));
    TRUE(!mesh.memory);
    REFUSED(weft_mesh_load(&missing, &mesh));
    TRUE(!mesh.memory);
    weft_mesh_clear(&mesh);
    weft_mesh_clear(NULL);
}

static void contexts(void)
{
    weft_context *context = NULL;
    struct weft_context_params good = {.log = &logger};
    weft_context_making *making = NULL;
    BAD_ENUM(good, kind, weft_context_create(&p, &context));
    BAD_ENUM(good, kind, weft_context_begin(&p, &making));
    assert_int_equal(weft_context_begin(&good, &making), WEFT_OK);
    weft_context_abandon(&making);
    weft_context_abandon(&making);
    weft_context_abandon(NULL);
    assert_int_equal(weft_context_begin(&good, &making), WEFT_OK);
    weft_context_await(&making, &context); // where none is to be had it stays NULL
    weft_context_destroy(&context);
    weft_context_destroy(NULL);
}

static weft_context *open_context(void)
{
    weft_context *context = NULL;
    if (weft_context_create(&(struct weft_context_params){0}, &context) != WEFT_OK)
        exit(SKIPPED);
    weft_context_get_info(context);
    weft_context_find_function(context, NULL);
    weft_context_call(context, NULL, NULL);
    return context;
}

static void convolutions(weft_context *context)
{
    weft_pass_plan *made = plan(2);
    float out[16];
    const struct weft_samples samples = {.size = {8, 8, 1}, .plane = {voxels}};
    const struct weft_pixel_grid grid = {
        .width = 4, .height = 4, .du = {1.0, 0.0, 0.0}, .dv = {0.0, 1.0, 0.0}};
    struct weft_samples s = samples;
    struct weft_pixel_grid g = grid;
    const struct weft_multipass_run_params params = {
        .samples = &s, .grid = &g, .pixels = {out}, .log = &logger};
    const struct weft_multipass_verify_params verify = {
        .plan = made, .samples = &s, .grid = &g, .pixels = {out}, .log = &logger};
    struct weft_verify_report error;
    weft_multipass *compiled = NULL;
    REFUSED(weft_multipass_compile(context, weft_multipass_params(.log = &logger), &compiled));
    assert_int_equal(weft_multipass_compile(
                         context, weft_multipass_params(.plan = made, .log = &logger), &compiled),
                     WEFT_OK);
    TRUE(weft_multipass_get_info(compiled)->tile_bytes > 0);
#define RUN weft_multipass_run(compiled, &params, NULL)
#define EACH(target, good, list, what)                                                             \
    for (size_t i = 0; i < WEFT_COUNT(list); i++) {                                                \
        target = list[i];                                                                          \
        what(RUN);                                                                                 \
        if (!context)                                                                              \
            what(weft_multipass_verify(&verify, &error));                                          \
        s = samples;                                                                               \
        g = grid;                                                                                  \
    }
    static const int bad_sizes[] = {INT_MIN, -1, 0};
    EACH(s.size[0], samples, bad_sizes, REFUSED)
    EACH(s.size[2], samples, bad_sizes, REFUSED)
    EACH(g.width, grid, bad_sizes, REFUSED)
    EACH(g.height, grid, bad_sizes, REFUSED)
    EACH(s.low, samples, numbers, SURVIVED)
    EACH(s.high, samples, numbers, SURVIVED)
    EACH(g.origin[0], grid, numbers, SURVIVED)
    EACH(g.du[1], grid, numbers, SURVIVED)
#undef EACH
#undef RUN
    weft_multipass_destroy(&compiled);
    weft_multipass_destroy(NULL);
    weft_pass_plan_destroy(&made);
}

static void emulations(void)
{
    convolutions(NULL);
}

static void convolutions_on_gl(void)
{
    weft_context *context = open_context();
    convolutions(context);
    weft_context_destroy(&context);
}

static void separable(void)
{
    weft_context *context = open_context();
    float out[16];
    static double at[4] = {0.0, 1.0, 2.0, 3.0};
    struct weft_verify_report error;
    weft_separable_plan *made = NULL;
    weft_separable *compiled = NULL;
    struct weft_separable_params good = {
        .size = {4, 4}, .width = 4, .height = 4, .x = at, .y = at, .log = &logger};
#define CALL weft_separable_plan_create(&p, &made)
    KERNELS_REFUSED(good, 1, CALL);
    SET_REFUSED(good, size[0], 0, CALL);
    SET_REFUSED(good, size[1], INT_MIN, CALL);
    SET_REFUSED(good, size[1], INT_MAX, CALL);
    SET_REFUSED(good, width, -1, CALL);
    SET_REFUSED(good, height, 0, CALL);
    SET_REFUSED(good, x, NULL, CALL);
    BAD_ENUM(good, engine, CALL);
    BAD_ENUM(good, sums, CALL);
#undef CALL
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        at[2] = numbers[n];
        SURVIVED(weft_separable_plan_create(&good, &made));
        weft_separable_plan_destroy(&made);
    }
    at[2] = 2.0;
    good.memory_bytes = 1;
    assert_int_equal(weft_separable_plan_create(&good, &made), WEFT_OK);
    REFUSED(
        weft_separable_compile(made, weft_separable_compile_params(.context = context), &compiled));
    weft_separable_plan_destroy(&made);
    good.memory_bytes = 0;
    assert_int_equal(weft_separable_plan_create(&good, &made), WEFT_OK);
    REFUSED(weft_separable_compile(made, weft_separable_compile_params(), &compiled));
    assert_int_equal(
        weft_separable_compile(made, weft_separable_compile_params(.context = context), &compiled),
        WEFT_OK);
    TRUE(weft_separable_plan_get_info(made)->width == 4);
    struct weft_separable_run_params run = {.samples = voxels, .pixels = out, .log = &logger};
#define CALL weft_separable_run(compiled, &p, NULL)
    SET_REFUSED(run, stride, -1, CALL);
    SET_REFUSED(run, stride, 3, CALL);
    SET_REFUSED(run, samples, NULL, CALL);
    SET_REFUSED(run, pixels, NULL, CALL);
    SET_REFUSED(run, part.x, -1, CALL);
    SET_REFUSED(run, part.width, 5, CALL);
    SET_REFUSED(run, window.height, -1, CALL);
    SET_REFUSED(run, window, ((struct weft_rectangle){1, 0, 3, 4}), CALL); // not all, no survey
#undef CALL
    SURVIVED(weft_separable_run(compiled, &run, NULL));
    struct weft_separable_survey survey = {0};
    TRUE(weft_separable_reach(made, &(struct weft_rectangle){.width = 9}).width == 0);
    REFUSED(weft_separable_survey_samples(
        made, weft_separable_run_params(.window = {.width = 9}, .samples = voxels, .log = &logger),
        &survey));
    REFUSED(
        weft_separable_survey_samples(made, weft_separable_run_params(.log = &logger), &survey));
    SURVIVED(weft_separable_survey_samples(made, &run, &survey));
    weft_separable_survey_join(&survey, &survey);
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++)
        SURVIVED(weft_separable_verify(
            made, &run, &(struct weft_verify_params){.max_seconds = numbers[n]}, &error));
    weft_separable_destroy(&compiled);
    weft_separable_destroy(NULL);
    weft_separable_plan_destroy(&made);
    weft_separable_plan_destroy(NULL);
    EACH_BAD_KERNEL(
        0, if (k < 6 || k == 7) {
            weft_separable_error_bound(&kernel, WEFT_SUMS_DOUBLE);
            weft_separable_bound_terms(&kernel, WEFT_SUMS_FLOAT, 1.0, 0x1p-28);
        })
    weft_context_destroy(&context);
}

static void rectangles(void)
{
    static const struct weft_rectangle bad[] = {
        {-1, 0, 2, 2},      {0, 0, 5, 2},      {0, 0, 2, 9},       {3, 0, 2, 2},
        {0, 0, 0, 2},       {1, 1, 0, 0},      {0, 0, INT_MIN, 1}, {INT_MAX, 0, INT_MAX, 1},
        {0, INT_MIN, 1, 1}, {0, 0, 1, INT_MAX}};
    const struct weft_rectangle none = {0}, some = {1, 2, 3, 4};
    struct weft_rectangle out;
    for (size_t i = 0; i < WEFT_COUNT(bad); i++)
        REFUSED(weft_rectangle_within(&logger, &bad[i], 4, 8, &out));
    TRUE(weft_rectangle_within(&logger, &none, 4, 8, &out) == WEFT_OK && out.width == 4 &&
         out.height == 8);
    out = weft_rectangle_common(&some, &out);
    TRUE(memcmp(&out, &some, sizeof out) == 0);
    out = weft_rectangle_common(&some, &(struct weft_rectangle){4, 2, 1, 1});
    TRUE(memcmp(&out, &none, sizeof out) == 0);
}

static void window_maps(void)
{
    const struct weft_window window = {0, 4};
    struct weft_window data, display;
    struct weft_window_map out;
    static const int64_t far[] = {INT64_MIN, INT64_MAX, INT64_C(1) << 40, -(INT64_C(1) << 31)};
#define SCALE(d, w, to) weft_window_map_scale(&logger, d, w, to, &data, &display, &out)
    REFUSED(SCALE(window, window, 0));
    REFUSED(SCALE(window, window, -3));
    REFUSED(SCALE(((struct weft_window){4, 4}), window, 8));
    REFUSED(SCALE(window, ((struct weft_window){5, 4}), 8));
    SURVIVED(
        SCALE(((struct weft_window){-1000000, 1000000}), ((struct weft_window){0, 1}), 1 << 29));
    TRUE(SCALE(window, window, 8) == WEFT_OK && data.end == 8 && out.to == 8);
    const struct weft_window_map good = weft_window_map_plain(4, 8);
    TRUE(weft_window_map_position(&good, 0, 0) == -0.25);
    TRUE(weft_window_map_square(&good, 7) == 3);
    for (size_t i = 0; i < WEFT_COUNT(far); i++) {
        struct weft_window_map maps[4] = {good, good, good, good};
        maps[0].from = maps[1].to = maps[2].pixel = maps[3].sample = far[i];
        for (int m = 0; m < 4; m++) {
            TRUE(isnan(weft_window_map_position(&maps[m], 1, 1)));
            TRUE(weft_window_map_square(&maps[m], 1) == INT64_MIN);
        }
        REFUSED(SCALE(((struct weft_window){far[i], 4}), window, 8));
        REFUSED(SCALE(window, ((struct weft_window){0, far[i]}), 8));
        REFUSED(SCALE(window, window, far[i]));
    }
    TRUE(isnan(weft_window_map_position(&good, INT_MAX, 0)));
    TRUE(isnan(weft_window_map_position(&good, 0, INT_MIN)));
    double at[2];
    weft_window_map_positions(&good, INT_MAX - 1, 2, INT_MIN, at);
    TRUE(isnan(at[0]) && isnan(at[1]));
#undef SCALE
}

static struct weft_resample_params resample_params(void)
{
    struct weft_resample_params params =
        *weft_resample_params(.size = {4, 4}, .width = 5, .height = 3, .log = &logger);
    return params;
}

static void resample_plans(void)
{
    weft_resample_plan *plan = NULL;
    struct weft_resample_params good = resample_params();
#define CALL (weft_resample_plan_destroy(&plan), weft_resample_plan_create(&p, &plan))
    KERNELS_REFUSED(good, 1, CALL);
    SET_REFUSED(good, size[0], 0, CALL);
    SET_REFUSED(good, size[1], INT_MIN, CALL);
    SET_REFUSED(good, size[1], INT_MAX, CALL);
    SET_REFUSED(good, width, -1, CALL);
    SET_REFUSED(good, height, INT_MAX, CALL);
    SET_REFUSED(good, map[0].from, -1, CALL);
    SET_REFUSED(good, map[1].to, INT64_MAX, CALL);
    SET_REFUSED(good, map[1].pixel, INT64_MIN, CALL);
    BAD_ENUM(good, engine, CALL);
    BAD_ENUM(good, sums, CALL);
    SET_REFUSED(good, sums, WEFT_SUMS_DOUBLE, CALL); // on OpenGL
    SET_REFUSED(good, kernel, named("bspline3+radial"), CALL);
    weft_pass_plan *passes[3] = {NULL};
    SURVIVED(weft_pass_plan_create(weft_pass_plan_params(.samples = 16), &passes[0]));
    SURVIVED(weft_pass_plan_create(weft_pass_plan_params(.dims = 3, .samples = 8), &passes[1]));
    SURVIVED(weft_pass_plan_create(
        weft_pass_plan_params(.derivative = 1, .samples = 16, .profile = {.name = ""}),
        &passes[2]));
    SET_REFUSED(good, passes, passes[1], CALL);
    if (passes[2])
        SET_REFUSED(good, passes, passes[2], CALL);
    struct weft_resample_params multipass = good;
    multipass.passes = passes[0];
    SET_REFUSED(multipass, kernel, named("mitchell"), CALL);
    SET_REFUSED(multipass, memory_bytes, 10, CALL);
    weft_resample_plan_destroy(&plan);
    weft_resample_plan_destroy(NULL);
    for (int i = 0; i < 3; i++)
        weft_pass_plan_destroy(&passes[i]);
#undef CALL
}

static struct weft_resample_source_params source_params(void)
{
    struct weft_resample_source_params params =
        *weft_resample_source_params(.width = 4, .height = 4, .plane = {voxels}, .log = &logger);
    return params;
}

static void resample_sources(void)
{
    weft_resample_source *source = NULL;
    struct weft_resample_source_params good = source_params();
#define CALL (weft_resample_source_destroy(&source), weft_resample_source_create(&p, &source))
    KERNELS_REFUSED(good, 1, CALL);
    SET_REFUSED(good, width, 0, CALL);
    SET_REFUSED(good, height, INT_MAX, CALL);
    SET_REFUSED(good, channels, -1, CALL);
    SET_REFUSED(good, channels, 5, CALL);
    SET_REFUSED(good, channels, 2, CALL); // there is one plane
    SET_REFUSED(good, plane[0], NULL, CALL);
    SET_REFUSED(good, stride, 3, CALL);
    SET_REFUSED(good, stride, INT64_MIN, CALL);
    SET_REFUSED(good, window, ((struct weft_rectangle){0, 0, 4, 3}), CALL); // nothing is measured
    SET_REFUSED(good, window.width, 5, CALL);
    SET_REFUSED(good, threads, -1, CALL);
    ANY_NUMBER(good, low, CALL)
    ANY_NUMBER(good, high, CALL)
    weft_resample_source_destroy(&source);
    weft_resample_source_destroy(NULL);
#undef CALL
    struct weft_resample_measured measured = WEFT_RESAMPLE_MEASURED_NONE;
#define CALL weft_resample_measure(&p, 0, 4, true, &measured)
    SET_REFUSED(good, window.height, 5, CALL);
    SET_REFUSED(good, window, ((struct weft_rectangle){0, 1, 4, 3}), CALL);
    SET_REFUSED(good, window, ((struct weft_rectangle){0, 0, 3, 4}), CALL);
    SET_REFUSED(good, plane[0], NULL, CALL);
#undef CALL
    REFUSED(weft_resample_measure(&good, -1, 1, false, &measured));
    REFUSED(weft_resample_measure(&good, 3, 2, false, &measured));
    SURVIVED(weft_resample_measure(&good, 0, 4, true, &measured));
    weft_resample_measured_join(&measured, &measured);
}

static void resample_runs(void)
{
    weft_context *context = open_context();
    weft_resample_plan *plan = NULL;
    weft_resample_compiled *compiled = NULL;
    weft_resample_source *source = NULL, *small = NULL, *spline = NULL;
    struct weft_resample_params params = resample_params();
    struct weft_resample_source_params from = source_params();
    struct weft_verify_report error;
    struct weft_resample_work sum = {0};
    float out[15] = {0};
    SURVIVED(weft_resample_plan_create(&params, &plan));
    SURVIVED(weft_resample_source_create(&from, &source));
    from.width = 3;
    SURVIVED(weft_resample_source_create(&from, &small));
    from = source_params();
    from.kernel = named("bspline3i");
    SURVIVED(weft_resample_source_create(&from, &spline));
    TRUE(weft_resample_plan_get_info(plan)->width == 5);
    TRUE(weft_resample_source_get_info(source)->channels == 1);
    const struct weft_resample_statistics none = {.low = NAN};
    TRUE(weft_resample_bound(plan, &weft_resample_source_get_info(source)->statistics, 0.0).total >=
         0.0);
    weft_resample_bound(plan, &none, -1.0);
    TRUE(weft_resample_e1(source) > 0.0);
    REFUSED(
        weft_resample_compile(plan, weft_resample_compile_params(), &compiled)); // planned for GL
    SURVIVED(
        weft_resample_compile(plan, weft_resample_compile_params(.context = context), &compiled));
    TRUE(weft_resample_compiled_get_info(compiled)->tile_bytes == 0);
    struct weft_resample_run_params good = {.source = source, .plane = {out}, .log = &logger};
#define CALL weft_resample_run(compiled, &p, NULL)
    SET_REFUSED(good, source, NULL, CALL);
    SET_REFUSED(good, source, small, CALL);
    SET_REFUSED(good, source, spline, CALL);
    SET_REFUSED(good, plane[0], NULL, CALL);
    SET_REFUSED(good, stride, 4, CALL);
    SET_REFUSED(good, stride, INT64_MIN, CALL);
    SET_REFUSED(good, part.width, 6, CALL);
    SET_REFUSED(good, part.x, -1, CALL);
#undef CALL
    TRUE(weft_resample_reach(plan, &(struct weft_rectangle){.y = 99}).width == 0);
    struct weft_resample_survey survey = {{{0}}};
    REFUSED(weft_resample_survey_source(plan, small, &survey));
    REFUSED(weft_resample_survey_source(plan, NULL, &survey));
    SURVIVED(weft_resample_survey_source(plan, source, &survey));
    weft_resample_survey_join(&survey, &survey);
    SURVIVED(weft_resample_run(compiled, &good, NULL));
    struct weft_resample_verify_params pixels = {.source = source, .plane = {out}, .log = &logger};
#define CALL weft_resample_verify(plan, &p, &error)
    SET_REFUSED(pixels, source, NULL, CALL);
    SET_REFUSED(pixels, source, small, CALL);
    SET_REFUSED(pixels, plane[0], NULL, CALL);
    SET_REFUSED(pixels, stride, -5, CALL);
    SET_REFUSED(pixels, part.height, -1, CALL);
#undef CALL
    SURVIVED(weft_resample_verify(plan, &pixels, &error));
    weft_resample_work_add(&sum, &(struct weft_resample_work){.pass_seconds = NAN});
    weft_resample_compiled_destroy(&compiled);
    weft_resample_compiled_destroy(NULL);
    weft_resample_source_destroy(&source);
    weft_resample_source_destroy(&small);
    weft_resample_source_destroy(&spline);
    weft_resample_plan_destroy(&plan);
    weft_context_destroy(&context);
}

static void resample_integers(void)
{
    static const uint32_t codes[20] = {7, UINT32_MAX}; // height 5 is read, too
    weft_resample_plan *plan = NULL, *filter = NULL;
    struct weft_resample_params params = resample_params();
    struct weft_verify_report error;
    uint32_t out[15], range[2];
    SURVIVED(weft_resample_plan_create(&params, &filter));
    params.kernel = named("nearest");
    SURVIVED(weft_resample_plan_create(&params, &plan));
    EACH_BAD_KERNEL(0, weft_resample_moves(&kernel))
    struct weft_resample_integers good = {.width = 4, .height = 4, .plane = codes};
#define MOVE(plan, stride)                                                                         \
    (weft_resample_move_verify(plan, &p, NULL, out, stride, NULL, &error),                         \
     weft_resample_integer_range(&p, range), weft_resample_move(plan, &p, NULL, out, stride))
    SET_REFUSED(good, width, 0, MOVE(plan, 0));
    SET_REFUSED(good, height, 5, MOVE(plan, 0));
    SET_REFUSED(good, plane, NULL, MOVE(plan, 0));
    SET_REFUSED(good, stride, 3, MOVE(plan, 0));
    SET_REFUSED(good, stride, INT64_MIN, MOVE(plan, 0));
    SET_REFUSED(good, width, 4, MOVE(plan, 4));
    SET_REFUSED(good, width, 4, MOVE(filter, 0));
    SET_REFUSED(good, window.width, 5, MOVE(plan, 0));
    SET_REFUSED(good, window, ((struct weft_rectangle){0, 0, 1, 1}), MOVE(plan, 0));
#undef MOVE
    weft_resample_integer_range(&good, range);
    TRUE(range[0] == 0 && range[1] == UINT32_MAX);
    SURVIVED(weft_resample_move(plan, &good, NULL, out, 0));
    SURVIVED(weft_resample_move_verify(plan, &good, NULL, out, 5, NULL, &error));
    TRUE(error.maximum == 0.0);
    weft_resample_plan_destroy(&plan);
    weft_resample_plan_destroy(&filter);
}

static void resample_choices(void)
{
    weft_resample_source *source = NULL;
    struct weft_resample_source_params from = source_params();
    struct weft_resample_choice choice = {0};
    SURVIVED(weft_resample_source_create(&from, &source));
    const double max_error = 1.0, none = 0.0, nan = NAN;
    const weft_resample_source *sources[1] = {source};
    struct weft_resample_choose_params good = {.passes = {.samples = 16},
                                               .sources = sources,
                                               .max_error = &max_error,
                                               .source_count = 1,
                                               .width = 4,
                                               .height = 4,
                                               .log = &logger};
#define CALL (weft_resample_choice_clear(&choice), weft_resample_choose(&p, &choice))
    SET_REFUSED(good, sources, NULL, CALL);
    SET_REFUSED(good, source_count, 0, CALL);
    SET_REFUSED(good, max_error, NULL, CALL);
    SET_REFUSED(good, max_error, &none, CALL);
    SET_REFUSED(good, max_error, &nan, CALL);
    SET_REFUSED(good, width, 0, CALL);
    SET_REFUSED(good, height, INT_MIN, CALL);
#undef CALL
    SURVIVED(weft_resample_choose(&good, &choice));
    weft_resample_choice_clear(&choice);
    struct weft_resample_engine_params engines = {
        .plan = {.size = {3, 2}, .width = 4, .height = 4, .log = &logger},
        .sources = sources,
        .max_error = &max_error,
        .source_count = 1,
        .log = &logger};
#define CALL (weft_resample_choice_clear(&choice), weft_resample_choose_engine(&p, &choice))
    SET_REFUSED(engines, sources, NULL, CALL);
    SET_REFUSED(engines, source_count, 0, CALL);
    const double below = -1.0;
    SET_REFUSED(engines, max_error, &below, CALL);
    SET_REFUSED(engines, max_error, &nan, CALL);
    SET_REFUSED(engines, engines, 99, CALL);
    SET_REFUSED(engines, threads, -1, CALL);
    SET_REFUSED(engines, plan.width, 0, CALL);
    SET_REFUSED(engines, plan.passes, (const weft_pass_plan *)&none, CALL);
#undef CALL
    SURVIVED(weft_resample_choose_engine(&engines, &choice));
    TRUE(choice.separable != NULL);
    weft_resample_choice_clear(&choice);
    weft_resample_source_destroy(&source);
}

static void pixel_errors(void)
{
    float out[16] = {0};
    const struct weft_pixel_grid grid = {
        .width = 4, .height = 4, .du = {1.0, 0.0, 0.0}, .dv = {0.0, 1.0, 0.0}};
    struct weft_pixel_grid g = grid;
    struct weft_verify_report error;
    struct weft_pixels_verify_params good = {.kernel = {named("bspline")},
                                             .grid = &g,
                                             .size = {8, 8},
                                             .samples = {{.values = voxels}},
                                             .pixels = {{.values = out}},
                                             .log = &logger};
#define CALL weft_pixels_verify(&p, &error)
    TRUE(weft_pixels_verify(&good, &error) == WEFT_OK && error.pixels_checked == 16);
    SET_REFUSED(good, dims, -1, CALL);
    SET_REFUSED(good, dims, 4, CALL);
    SET_REFUSED(good, size[0], 0, CALL);
    SET_REFUSED(good, size[1], INT_MIN, CALL);
    SET_REFUSED(good, channels, 5, CALL);
    SET_REFUSED(good, channels, 2, CALL); // without planes
    SET_REFUSED(good, samples[0].values, NULL, CALL);
    SET_REFUSED(good, samples[0].stride, 7, CALL);
    SET_REFUSED(good, pixels[0].values, NULL, CALL);
    SET_REFUSED(good, pixels[0].stride, -1, CALL);
    SET_REFUSED(good, part.width, 4711, CALL);
    SET_REFUSED(good, window.y, -1, CALL);
    SET_REFUSED(good, kernel[0].info, NULL, CALL);
    SET_REFUSED(good, cardinal, true, CALL); // of a kernel without a prefilter
    BAD_ENUM(good, pixels[0].type, CALL);
    BAD_ENUM(good, samples[0].type, CALL);
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        struct weft_pixels_verify_params p = good;
        p.how.max_seconds = numbers[n];
        SURVIVED(CALL);
        g.origin[1] = numbers[n];
        SURVIVED(CALL);
        g = grid;
        p.bound_relative = numbers[n];
        SURVIVED(CALL);
        const struct weft_reference_value reference = {numbers[n], numbers[n]};
        weft_verify_add(&error, 0, 0, 0, numbers[(n + 1) % WEFT_COUNT(numbers)], &reference);
        weft_verify_join(&error, &error);
    }
#undef CALL
}

static void slice_runs_refuse(weft_context *context, const weft_slice_plan *plan)
{
    float out[64];
    weft_slice *compiled = NULL;
    REFUSED(weft_slice_compile(
        NULL,
        weft_slice_compile_params(.context = context, .passes = weft_slice_passes(.log = &logger)),
        &compiled));
    REFUSED(weft_slice_compile(plan, weft_slice_compile_params(),
                               &compiled)); // the CPU runs passes alone
    if (weft_slice_compile(plan, weft_slice_compile_params(.context = context), &compiled) !=
        WEFT_OK)
        return;
    struct weft_slice_run_params good = {.pixels = out, .stride = 16};
#define CALL weft_slice_run(compiled, &p, NULL)
    SURVIVED(weft_slice_run(compiled, &good, NULL));
    SET_REFUSED(good, pixels, NULL, CALL);
    SET_REFUSED(good, stride, -1, CALL);
    SET_REFUSED(good, stride, 3, CALL);
    SET_REFUSED(good, stride, INT64_MAX, CALL);
#undef CALL
    weft_slice_destroy(&compiled);
    weft_slice_destroy(&compiled);
    weft_slice_destroy(NULL);
}

static void slice_runs(void)
{
    weft_context *context = open_context();
    weft_volume *v = volume();
    weft_slice_plan *slice = NULL;
    struct weft_slice_params params = slice_params(v);
    float out[16];
    struct weft_slice_statistics statistics;
    struct weft_verify_report error;
    TRUE(weft_slice_plan_create(v, &params, &slice) == WEFT_OK);
    TRUE(weft_slice_plan_get_info(slice)->tile_count > 0);
    SURVIVED(weft_footprint_statistics(weft_slice_plan_get_footprint(slice), NULL, &statistics));
    SURVIVED(weft_slice_run_once(slice, weft_slice_compile_params(.context = context),
                                 weft_slice_run_params(.pixels = out), NULL));
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++)
        SURVIVED(weft_slice_verify(
            slice, out, &(struct weft_slice_verify_params){.max_seconds = numbers[n]}, &error));

    slice_runs_refuse(context, slice);
    weft_pass_plan *flat = plan(2), *deep = plan(3);
    struct weft_slice_passes good = {.plan = deep, .log = &logger};
    weft_slice *compiled = NULL;
#define CALL weft_slice_compile(slice, weft_slice_compile_params(.passes = &p), &compiled)
    SET_REFUSED(good, plan, NULL, CALL);
    SET_REFUSED(good, plan, flat, CALL);
    SET_REFUSED(good, plan, deep, CALL); // another kernel than the slice's
    SET_REFUSED(good, low, INFINITY, CALL);
#undef CALL
    weft_pass_plan_destroy(&flat);
    weft_pass_plan_destroy(&deep);
    weft_slice_plan_destroy(&slice);
    weft_volume_destroy(&v);
    weft_context_destroy(&context);
}

// A cut along an axis, with and without what it saves there.
static void hardware_plans(void)
{
    weft_volume *v = volume();
    weft_slice_plan *summed = NULL, *slice = NULL;
    weft_hardware_plan *plan = NULL;
    struct weft_slice_params params = slice_params(v);
    TRUE(weft_slice_plan_create(v, &params, &summed) == WEFT_OK);
    params.without = WEFT_SAVING_AXIS | WEFT_SAVING_SEPARABLE;
    TRUE(weft_slice_plan_create(v, &params, &slice) == WEFT_OK);
    struct weft_hardware_params good = {.slice = slice, .log = &logger};
    TRUE(weft_hardware_plan_create(&good, &plan) == WEFT_OK);
    TRUE(weft_hardware_plan_get_info(plan)->fetches_per_pixel == 27);
    weft_hardware_plan_destroy(&plan);
    good.sampler = weft_sampler_assume(WEFT_SOURCE_FLOAT);
#define CALL weft_hardware_plan_create(&p, &plan)
    SET_REFUSED(good, slice, NULL, CALL);
    SET_REFUSED(good, slice, summed, CALL);
    SET_REFUSED(good, memory_bytes, 1, CALL);
    SET_REFUSED(good, sampler.max_size, 1024, CALL);
    SET_REFUSED(good, sampler.max_size, -1, CALL);
    SET_REFUSED(good, sampler.fraction, NAN, CALL);
    SET_REFUSED(good, sampler.fraction, 0.75, CALL);
    SET_REFUSED(good, sampler.rounding, -1.0, CALL);
    SET_REFUSED(good, sampler.rounding, INFINITY, CALL);
#undef CALL
    TRUE(plan == NULL);
    weft_hardware_plan_destroy(&plan);
    weft_hardware_plan_destroy(NULL);
    weft_slice_plan_destroy(&slice);
    weft_slice_plan_destroy(&summed);
    weft_volume_destroy(&v);
}

static void samplers(void)
{
    weft_context *context = NULL;
    struct weft_sampler sampler;
    if (weft_context_create(weft_context_params(.log = &logger), &context) != WEFT_OK)
        exit(SKIPPED);
    lines = 0;
    for (size_t i = 0; i < WEFT_COUNT(bad_enums); i++) {
        const enum weft_source_format bad = (enum weft_source_format)bad_enums[i];
        REFUSED(weft_sampler_measure(context, bad, &sampler));
        TRUE(weft_sampler_assume(bad).max_size == 0);
    }
    SURVIVED(weft_sampler_measure(context, WEFT_SOURCE_FLOAT, &sampler));
    weft_context_destroy(&context);
}

static enum weft_result draw_nothing(void *priv, const struct weft_antialias_pass *pass)
{
    (void)priv;
    (void)pass;
    return WEFT_OK;
}

static void multisampling(void)
{
    static double at[WEFT_PATTERN_MAX][2];
    weft_context *context = open_context();
    struct weft_msaa_params good = {.width = 4, .height = 4, .context = context, .log = &logger};
    weft_msaa *msaa = NULL;
    float out[16];
    lines = 0;
#define CALL weft_msaa_create(&p, &msaa)
    SET_REFUSED(good, context, NULL, CALL);
    SET_REFUSED(good, width, 0, CALL);
    SET_REFUSED(good, height, INT_MIN, CALL);
    SET_REFUSED(good, width, INT_MAX, CALL);
    SET_REFUSED(good, samples, -1, CALL);
    SET_REFUSED(good, samples, INT_MAX, CALL);
    SET_REFUSED(good, depth_bits, 16, CALL);
    SET_REFUSED(good, range, (double)NAN, CALL);
    SET_REFUSED(good, range, -1.0, CALL);
    SET_REFUSED(good, background[3], (double)INFINITY, CALL);
    BAD_ENUM(good, format, CALL);
    BAD_ENUM(good, resolve, CALL);
#undef CALL
    TRUE(weft_msaa_create(&good, &msaa) == WEFT_OK);
    REFUSED(weft_msaa_read(msaa, 0, out, 0));
    REFUSED(weft_msaa_run(msaa, NULL));
    REFUSED(weft_msaa_run(msaa, &(struct weft_antialias_drawing){.draw = NULL}));
    REFUSED(weft_msaa_run(
        msaa, &(struct weft_antialias_drawing){.draw = draw_nothing, .part = {0, -1, 1, 1}}));
    SURVIVED(weft_msaa_run(msaa, &(struct weft_antialias_drawing){.draw = draw_nothing}));
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        SURVIVED(weft_msaa_read(msaa, ints[i], out, 0));
        TRUE(weft_msaa_positions(context, ints[i], at) >= 0);
        TRUE(weft_msaa_positions(NULL, ints[i], at) == 0);
    }
    struct weft_msaa_report report;
    weft_msaa_get_report(msaa, &report);
    TRUE(report.samples == 4);
    weft_msaa_destroy(&msaa);
    weft_msaa_destroy(&msaa);
    weft_msaa_destroy(NULL);
    weft_context_destroy(&context);
}

static void accumulative_room(weft_acaa *acaa, bool has)
{
    struct weft_acaa_room room;
    weft_acaa_get_room(acaa, &room);
    TRUE(has ? room.range >= 1.0 && room.weight == 1.0 : room.range == 0.0);
    TRUE(weft_acaa_set_room(acaa, &room) == WEFT_OK);
    if (!has)
        return;
    REFUSED(weft_acaa_set_room(acaa, &(struct weft_acaa_room){0.0, 1.0}));
    REFUSED(weft_acaa_set_room(acaa, &(struct weft_acaa_room){room.range, (double)NAN}));
    REFUSED(weft_acaa_set_room(acaa, &(struct weft_acaa_room){1e300, 1e300}));
}

static void accumulative_run(weft_acaa *acaa)
{
    float out[16];
    REFUSED(weft_acaa_read(acaa, 0, out, 0));
    REFUSED(weft_acaa_read_weight(acaa, out, 0));
    REFUSED(weft_acaa_run(acaa, NULL, NULL));
    REFUSED(weft_acaa_run(acaa, &(struct weft_antialias_drawing){.draw = NULL}, NULL));
    REFUSED(weft_acaa_run(
        acaa, &(struct weft_antialias_drawing){.draw = draw_nothing, .part = {1, 0, 4, 1}}, NULL));
    TRUE(weft_acaa_run(acaa, &(struct weft_antialias_drawing){.draw = draw_nothing}, NULL) ==
         WEFT_OK);
    for (size_t i = 0; i < WEFT_COUNT(ints); i++)
        SURVIVED(weft_acaa_read(acaa, ints[i], out, 0));
    REFUSED(weft_acaa_read(acaa, 0, NULL, 0));
    REFUSED(weft_acaa_read(acaa, 0, out, 3));
    REFUSED(weft_acaa_read_weight(acaa, NULL, 0));
    REFUSED(weft_acaa_read_weight(acaa, out, 3));
    TRUE(weft_acaa_read_weight(acaa, out, 0) == WEFT_OK && out[15] == 1.0f);
}

static void accumulative(void)
{
    weft_context *context = open_context();
    struct weft_acaa_params good = {.width = 4, .height = 4, .context = context, .log = &logger};
    weft_acaa *acaa = NULL;
    lines = 0;
#define CALL weft_acaa_create(&p, &acaa)
#define CALL_AND_DESTROY (CALL == WEFT_OK ? weft_acaa_destroy(&acaa), WEFT_OK : WEFT_ERR_LIMIT)
    SET_REFUSED(good, context, NULL, CALL);
    SET_REFUSED(good, width, 0, CALL);
    SET_REFUSED(good, height, INT_MIN, CALL);
    SET_REFUSED(good, width, INT_MAX, CALL);
    SET_REFUSED(good, samples, -1, CALL);
    SET_REFUSED(good, samples, INT_MAX, CALL);
    SET_REFUSED(good, depth_bits, 16, CALL);
    SET_REFUSED(good, range, (double)NAN, CALL);
    SET_REFUSED(good, background[3], (double)INFINITY, CALL);
    ANY_NUMBER(good, range, CALL_AND_DESTROY);
    ANY_NUMBER(good, filter_width, CALL_AND_DESTROY);
    BAD_ENUM(good, form, CALL);
    BAD_ENUM(good, coincident, CALL);
    BAD_ENUM(good, sums, CALL);
    for (int i = 1; i < BAD_KERNELS; i++)
        SET_REFUSED(good, filter, bad_kernel(i), CALL);
#undef CALL_AND_DESTROY
#undef CALL
    for (int f = WEFT_ACAA_AUTO; f < WEFT_ACAA_FORM_COUNT; f += WEFT_ACAA_JITTER) {
        good.form = (enum weft_acaa_form)f;
        TRUE(weft_acaa_create(&good, &acaa) == WEFT_OK);
        accumulative_run(acaa);
        accumulative_room(acaa, f != WEFT_ACAA_JITTER);
        struct weft_acaa_report report;
        weft_acaa_get_report(acaa, &report);
        TRUE(report.samples == 4);
        weft_acaa_destroy(&acaa);
    }
    weft_acaa_destroy(&acaa);
    weft_acaa_destroy(NULL);
    weft_context_destroy(&context);
}

static void marks_run(weft_marker *marker)
{
    float out[16];
    struct weft_marks marks;
    REFUSED(weft_marker_read(marker, 0, out, 0));
    REFUSED(weft_marker_run(marker, NULL, &marks));
    REFUSED(weft_marker_run(marker, &(struct weft_antialias_drawing){.draw = NULL}, &marks));
    TRUE(weft_marker_run(marker, &(struct weft_antialias_drawing){.draw = draw_nothing}, &marks) ==
         WEFT_OK);
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        SURVIVED(weft_marker_read(marker, ints[i], out, 0));
        TRUE(weft_marks_dilate(&marks, ints[i]) ==
             (ints[i] < 0 || ints[i] > WEFT_MARKS_MAX_RADIUS ? WEFT_ERR_ARGUMENT : WEFT_OK));
    }
    REFUSED(weft_marker_read(marker, 0, NULL, 0));
    REFUSED(weft_marker_read(marker, 0, out, 3));
    TRUE(weft_marker_bytes(marker) > 0 && weft_marker_bytes(NULL) == 0);
    weft_marks_clear(&marks);
    weft_marks_clear(&marks);
    weft_marks_clear(NULL);
    TRUE(weft_marks_dilate(&marks, 1) == WEFT_ERR_ARGUMENT);
    TRUE(weft_marks_dilate(NULL, 1) == WEFT_ERR_ARGUMENT);
}

static void marking(void)
{
    weft_context *context = open_context();
    struct weft_marker_params good = {.width = 4, .height = 4, .context = context, .log = &logger};
    weft_marker *marker = NULL;
    lines = 0;
#define CALL weft_marker_create(&p, &marker)
#define CALL_AND_DESTROY (CALL == WEFT_OK ? weft_marker_destroy(&marker), WEFT_OK : WEFT_ERR_LIMIT)
    SET_REFUSED(good, context, NULL, CALL);
    SET_REFUSED(good, width, 0, CALL);
    SET_REFUSED(good, height, INT_MIN, CALL);
    SET_REFUSED(good, width, INT_MAX, CALL);
    SET_REFUSED(good, contrast, (double)NAN, CALL);
    SET_REFUSED(good, contrast, -1.0, CALL);
    SET_REFUSED(good, background[3], (double)INFINITY, CALL);
    ANY_NUMBER(good, max_share, CALL_AND_DESTROY);
    BAD_ENUM(good, format, CALL);
    BAD_ENUM(good, mark, CALL);
#undef CALL_AND_DESTROY
#undef CALL
    TRUE(weft_marker_create(&good, &marker) == WEFT_OK);
    marks_run(marker);
    weft_marker_destroy(&marker);
    weft_marker_destroy(&marker);
    weft_marker_destroy(NULL);
    weft_context_destroy(&context);
}

static void run_supersample(weft_supersample *s)
{
    const struct weft_antialias_drawing drawing = {.draw = draw_nothing};
    struct weft_marks marks = {.width = 4, .height = 4, .marked = calloc(16, 1)};
    float out[16];
    REFUSED(weft_supersample_read(s, 0, out, 0));
    REFUSED(weft_supersample_run(s, NULL, NULL, NULL));
    REFUSED(weft_supersample_run(s, &(struct weft_antialias_drawing){.draw = NULL}, NULL, NULL));
    REFUSED(weft_supersample_run(s, &drawing, &(struct weft_marks){0}, NULL));
    REFUSED(weft_supersample_run(s, &drawing, &(struct weft_marks){.width = 4, .height = 4}, NULL));
    SURVIVED(weft_supersample_run(s, &drawing, &marks, NULL));
    SURVIVED(weft_supersample_run(s, &drawing, NULL, NULL));
    for (size_t i = 0; i < WEFT_COUNT(ints); i++)
        SURVIVED(weft_supersample_read(s, ints[i], out, 0));
    weft_marks_clear(&marks);
}

static void supersampling(void)
{
    static const double outside[1][2] = {{0.0, 2.0}}, none[1][2] = {{(double)NAN, 0.0}};
    weft_context *context = open_context();
    struct weft_supersample_params good = {
        .width = 4, .height = 4, .count = 4, .context = context, .log = &logger};
    weft_supersample *s = NULL;
    struct weft_kernel kernel;
    lines = 0;
#define CALL weft_supersample_create(&p, &s)
    SET_REFUSED(good, context, NULL, CALL);
    SET_REFUSED(good, width, 0, CALL);
    SET_REFUSED(good, height, INT_MIN, CALL);
    SET_REFUSED(good, width, INT_MAX, CALL);
    SET_REFUSED(good, count, -1, CALL);
    SET_REFUSED(good, count, 15, CALL);
    SET_REFUSED(good, count, INT_MAX, CALL);
    SET_REFUSED(good, filter_width, (double)NAN, CALL);
    SET_REFUSED(good, filter_width, 1e6, CALL);
    SET_REFUSED(good, background[3], (double)INFINITY, CALL);
    BAD_ENUM(good, store, CALL);
    BAD_ENUM(good, format, CALL);
    BAD_ENUM(good, method, CALL);
    good.count = 1;
    SET_REFUSED(good, position, outside, CALL);
    SET_REFUSED(good, position, none, CALL);
    TRUE(weft_kernel_parse(&logger, "mitchell", &kernel) == WEFT_OK);
    good.count = 4;
    good.filter = kernel;
    SET_REFUSED(good, method, WEFT_ACCUMULATE_TREE, CALL);
    good.count = 1;
#undef CALL
    TRUE(weft_supersample_create(&good, &s) == WEFT_OK);
    run_supersample(s);
    struct weft_supersample_report report;
    weft_supersample_get_report(s, &report);
    TRUE(report.samples == 1);
    weft_supersample_destroy(&s);
    weft_supersample_destroy(&s);
    weft_supersample_destroy(NULL);
    weft_context_destroy(&context);
}

static void method_runs(void)
{
    weft_context *context = open_context();
    weft_volume *v = volume();
    weft_method_plan *method = NULL;
    float out[16];
    struct weft_method_params params = {.method = {.layout = WEFT_LAYOUT_PLAIN},
                                        .slice = slice_params(v),
                                        .statistics = {.high = 3.0}};
    TRUE(weft_method_plan_create(v, &params, &method) == WEFT_OK);
    TRUE(weft_method_plan_get_info(method)->name[0] && weft_method_plan_get_slice(method));
    TRUE(!weft_method_plan_get_passes(method));
    SURVIVED(
        weft_method_run(method, weft_method_run_params(.context = context, .pixels = out), NULL));
    struct weft_cost_model model = weft_cost_default;
    model.pixel = NAN;
    weft_cost_of(&model, &weft_method_plan_get_info(method)->work);
    for (size_t n = 0; n < WEFT_COUNT(ints); n++)
        TRUE((unsigned)weft_choose_engine(&model, weft_method_plan_get_slice(method), ints[n]) <=
             WEFT_ENGINE_CPU);
    weft_method_plan_destroy(&method);
    weft_volume_destroy(&v);
    weft_context_destroy(&context);
}

static bool stop(void *priv, double fraction)
{
    (void)priv;
    (void)fraction;
    return false;
}

static void calibrations(void)
{
    weft_context *context = open_context();
    struct weft_cost_model model;
    const struct weft_progress at_once = {.report = stop};
    TRUE(weft_cost_calibrate(&logger, context, &at_once, &model) == WEFT_ERR_CANCELLED);
    weft_context_destroy(&context);
}

static void stability(void)
{
    struct weft_stability_result result;
    struct weft_stability_params params = {.data_folder = "/nonexistent", .log = &logger};
    SURVIVED(weft_stability_run(weft_stability_find("order-2d"), &params, &result));
}

static void schedules(void)
{
    struct weft_regions_params good = {.width = 20, .height = 10, .log = &logger};
    weft_regions *regions = NULL;
#define CALL (weft_regions_destroy(&regions), weft_regions_create(&p, &regions))
    SET_REFUSED(good, width, 0, CALL);
    SET_REFUSED(good, height, -1, CALL);
    ANY_INT(good, width, CALL);
    ANY_INT(good, height, CALL);
    ANY_INT(good, region_width, CALL);
    ANY_INT(good, region_height, CALL);
    ANY_INT(good, ranks, CALL);
    ANY_INT(good, granularity, CALL);
    ANY_INT(good, least, CALL);
#undef CALL
    weft_regions_destroy(&regions);
    TRUE(weft_regions_create(&good, &regions) == WEFT_OK);
    TRUE(weft_regions_get(regions, -1).width < 0);
    TRUE(weft_regions_get(regions, weft_regions_count(regions)).width < 0);
    double seconds[8] = {1.0};
    TRUE(weft_regions_count(regions) == 8);
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        const enum weft_result res = weft_regions_balance(regions, seconds, numbers[n]);
        TRUE((res == WEFT_OK) == (numbers[n] >= 0.0 && numbers[n] < 1.0));
        seconds[7] = numbers[n];
        TRUE(weft_regions_balance(regions, seconds, 0.0) ==
             (numbers[n] >= 0.0 && !isinf(numbers[n]) ? WEFT_OK : WEFT_ERR_ARGUMENT));
        seconds[7] = 0.0;
    }
    weft_regions_destroy(&regions);
    weft_regions_destroy(&regions);
    struct weft_load load, fewer = {0};
    TRUE(weft_load_create(0, &load) == WEFT_ERR_ARGUMENT && !load.rank);
    TRUE(weft_load_create(2, &load) == WEFT_OK);
    struct weft_load_figures figures;
    weft_load_add(&load, &fewer);
    weft_load_add(&fewer, &load);
    weft_load_compute(&fewer, &figures);
    TRUE(figures.idle_share == 0.0 && figures.imbalance == 1.0);
    load.rank[0].busy = NAN, load.seconds = -1.0;
    weft_load_compute(&load, &figures);
    weft_load_clear(&load);
    weft_load_clear(&load);
}

// ---- ranks --------------------------------------------------------------------------------------

static enum weft_result idle_item(void *priv, int64_t item, void **data, size_t *size)
{
    (void)priv, (void)item, (void)data, (void)size;
    return WEFT_OK;
}

static enum weft_result idle_take(void *priv, int64_t item, const void *data, size_t size)
{
    (void)priv, (void)item, (void)data, (void)size;
    return WEFT_OK;
}

static enum weft_result ask_ranks(void *priv, weft_ranks *ranks)
{
    (void)priv;
    struct weft_ranks_info info;
    weft_ranks_get_info(ranks, &info);
    TRUE(info.rank == 0 && info.size == 1 && info.threads > 0 && info.host[0]);
    for (size_t i = 0; i < WEFT_COUNT(numbers); i++)
        if (!(numbers[i] >= 0.5 && isfinite(numbers[i])))
            REFUSED(weft_ranks_set_timeout(ranks, numbers[i]));
    void *data = NULL;
    size_t size = 0;
    struct weft_ranks_part part;
    SURVIVED(weft_ranks_share(ranks, &data, &size));
    SURVIVED(weft_ranks_gather(ranks, NULL, 0, &part));
    weft_ranks_free_parts(1, &part);
    weft_ranks_free_parts(1, &part);
    char line[1] = "";
    TRUE(weft_ranks_agree(ranks, WEFT_ERR_GL, line, sizeof line, NULL) == WEFT_ERR_GL);
    SURVIVED(weft_ranks_compare(ranks, "", ""));

    struct weft_items_report report = {0};
    const double costs[2] = {1.0, 0.0};
    struct weft_items good = {.count = 2, .run = idle_item, .take = idle_take};
    TRUE(weft_ranks_do_items(ranks, &good, &report) == WEFT_OK && report.failed_rank == -1);
    weft_items_report_clear(&report);
    weft_items_report_clear(&report);
    weft_items_report_clear(NULL);
    BAD_ENUM(good, schedule, weft_ranks_do_items(ranks, &p, &report));
    struct weft_items bad = good;
    bad.count = -1;
    REFUSED(weft_ranks_do_items(ranks, &bad, &report));
    bad = good, bad.cost = costs;
    REFUSED(weft_ranks_do_items(ranks, &bad, &report));
    bad = good, bad.run = NULL;
    REFUSED(weft_ranks_do_items(ranks, &bad, &report));
    return WEFT_ERR_FORMAT;
}

static void several_ranks(void)
{
    const struct weft_distribute_params *params = weft_distribute_params(.log = &logger);
    TRUE(weft_distribute_over(NULL, params, ask_ranks, NULL) == WEFT_ERR_FORMAT);
    REFUSED(weft_distribute_over(NULL, params, NULL, NULL));
    for (size_t i = 0; i < WEFT_COUNT(numbers); i++)
        if (numbers[i] != 0.0 && !(numbers[i] >= 0.5 && isfinite(numbers[i])))
            REFUSED(weft_distribute_over(
                NULL, weft_distribute_params(.timeout = numbers[i], .log = &logger), ask_ranks,
                NULL));
}

static void cost_maps(void)
{
    weft_cost_map *map = NULL;
    for (size_t n = 0; n < WEFT_COUNT(ints); n++) {
        TRUE((weft_cost_map_create(ints[n], 1, &map) == WEFT_OK) == (ints[n] > 0));
        weft_cost_map_destroy(&map);
        TRUE((weft_cost_map_create(1, ints[n], &map) == WEFT_OK) == (ints[n] > 0));
        weft_cost_map_destroy(&map);
        TRUE(weft_cost_map_load(&logger, "/nonexistent", ints[n], 1, &map) != WEFT_OK && lines > 0);
        lines = 0;
    }
    REFUSED(weft_cost_map_load(&logger, NULL, 1, 1, &map));
    TRUE(!map && weft_cost_map_create(100, 100, &map) == WEFT_OK);
    for (size_t i = 0; i < WEFT_COUNT(ints); i++)
        for (size_t k = 0; k < WEFT_COUNT(ints); k++) {
            const struct weft_rectangle across = {ints[i], 0, ints[k], 1};
            const struct weft_rectangle down = {0, ints[i], 1, ints[k]};
            weft_cost_map_add(map, &across, 1.0);
            weft_cost_map_add(map, &down, 1.0);
            TRUE(weft_cost_map_estimate(map, &across) >= 0.0);
            TRUE(weft_cost_map_estimate(map, &down) >= 0.0);
        }
    const struct weft_rectangle all = {0, 0, 100, 100};
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++)
        weft_cost_map_add(map, &all, numbers[n]);
    TRUE(weft_cost_map_estimate(map, &all) > 0.0);
    REFUSED(weft_cost_map_save(&logger, map, NULL));
    REFUSED(weft_cost_map_save(&logger, map, "/nonexistent/map"));
    weft_cost_map_destroy(&map);
    weft_cost_map_destroy(&map);
}

static enum weft_result divide_badly(void *priv, weft_ranks *ranks)
{
    (void)priv;
    weft_division *division = NULL;
    struct weft_division_params good = {.regions = {.width = 20, .height = 10, .log = &logger}};
#define CALL (weft_division_destroy(&division), weft_division_create(ranks, &p, &division))
    BAD_ENUM(good, schedule, CALL);
    ANY_NUMBER(good, keep, CALL);
    ANY_INT(good, regions.width, CALL);
    ANY_INT(good, regions.least, CALL);
#undef CALL
    weft_division_destroy(&division);
    good.schedule = WEFT_SCHEDULE_DYNAMIC;
    TRUE(weft_division_create(ranks, &good, &division) == WEFT_OK);
    TRUE(weft_regions_count(weft_division_regions(division)) == 8);
    TRUE(!weft_division_costs(division));
    double seconds[8] = {NAN, INFINITY, -1.0};
    struct weft_items_report report = {.item_seconds = seconds, .schedule = WEFT_SCHEDULE_DYNAMIC};
    TRUE(weft_division_learn(division, &report) == WEFT_ERR_ARGUMENT);
    weft_division_destroy(&division);
    weft_division_destroy(&division);
    return WEFT_OK;
}

static void divisions(void)
{
    TRUE(weft_distribute_over(NULL, weft_distribute_params(.log = &logger), divide_badly, NULL) ==
         WEFT_OK);
}

// ---- the table ----------------------------------------------------------------------------------

static const struct {
    void (*run)(void);
    const char *functions[20]; // that it calls, NULL-ended
} cases[] = {
#define F(name) "weft_" #name
    {analysis,
     {F(analysis_taylor), F(analysis_moment), F(analysis_order), F(analysis_response),
      F(analysis_metrics), F(analysis_overshoot), F(analysis_gain), F(analysis_curvature),
      F(analysis_slope)}},
    {texts,
     {F(result_text), F(version), F(text_clean), F(text_skip_mark), F(target_name), F(target_bits),
      F(target_one), F(stability_verdict_text), F(layout_name), F(source_format_name),
      F(source_format_bytes), F(source_format_error)}},
    {cpus, {F(cpu_threads), F(cpu_resolve), F(instruction_set_best), F(instruction_set_runs)}},
    {find,
     {F(closest_find), F(kernel_find), F(signal_find), F(profile_find), F(stability_find),
      F(colour_map_find)}},
    {statistics,
     {F(statistics_add), F(statistics_add_differences), F(statistics_magnitude), F(statistics_join),
      F(statistics_plane_difference)}},
    {errors, {F(error_kernel_compute), F(error_e1)}},
    {bounds, {F(bound_compute)}},
    {kernels,
     {F(kernel_check), F(kernel_normalise), F(kernel_make_radial), F(kernel_make_prefiltered),
      F(kernel_derive), F(kernel_format), F(kernel_weight), F(kernel_derivative),
      F(kernel_first_tap), F(kernel_offset), F(kernel_weights), F(kernel_is_radial),
      F(kernel_weights_nd), F(kernel_radial_sums), F(kernel_combine), F(kernel_parse)}},
    {records, {F(kernel_create)}},
    {tables, {F(kernel_table_init)}},
    {prefilters,
     {F(prefilter_compute), F(prefilter_line), F(prefilter_overlap), F(prefilter_taps),
      F(prefilter_is_missing), F(prefilter_error), F(prefilter_axis_set), F(prefilter_weights)}},
    {reference, {F(reference_compute), F(reference_compute_axes)}},
    {tile_sets, {F(kernel_tiles_create), F(kernel_tiles_destroy)}},
    {tile_questions,
     {F(kernel_tiles_get_info), F(kernel_tiles_get), F(kernel_tiles_find), F(kernel_tiles_position),
      F(kernel_tiles_value), F(kernel_tiles_integer), F(kernel_tiles_exact),
      F(kernel_tiles_split)}},
    {layouts, {F(context_kind_parse), F(profile_parse), F(cost_parse)}},
    {volumes, {F(volume_create), F(volume_create_bricks), F(volume_destroy)}},
    {volume_files,
     {F(volume_open), F(volume_begin), F(volume_await), F(volume_abandon), F(file_save),
      F(file_save_parts), F(unfinished_discard), F(volume_list_load), F(volume_list_clear),
      F(volume_save), F(volume_get_info)}},
    {volume_voxels, {F(volume_prefilter), F(volume_find), F(volume_read), F(brick_list_clear)}},
    {images,
     {F(image_save), F(image_load), F(image_clear), F(image_attribute_format), F(image_find),
      F(image_is_writable), F(image_list_clear), F(image_list_load), F(image_save_parts),
      F(image_pack), F(image_packed_clear), F(image_block_lines)}},
    {sequences,
     {F(image_sequence_create), F(image_sequence_destroy), F(image_sequence_next),
      F(image_sequence_extend)}},
    {previews, {F(preview_save), F(colour_preview_save)}},
    {planes, {F(plane_line), F(plane_row), F(plane_type_size)}},
    {kernel_files, {F(kernel_load), F(kernel_file_destroy)}},
    {accum_buffers,
     {F(accum_buffer_create), F(accum_buffer_destroy), F(accum_buffer_load), F(accum_buffer_accum),
      F(accum_buffer_add), F(accum_buffer_mult), F(accum_buffer_return), F(accum_buffer_read)}},
    {accumulators, {F(accumulator_create), F(accumulator_destroy)}},
    {accumulations,
     {F(accumulator_add), F(accumulator_current), F(accumulator_finish),
      F(accumulator_get_report)}},
    {accumulator_judgements, {F(accumulator_judge)}},
    {accumulator_states, {F(accumulator_save), F(accumulator_load), F(accumulator_join)}},
    {trees, {F(tree_create), F(tree_destroy), F(tree_get_info), F(tree_run_codes)}},
    {jitters,
     {F(jitter_create), F(jitter_clear), F(jitter_find), F(jitter_parse),
      F(jitter_radical_inverse)}},
    {discrepancies, {F(discrepancy_compute)}},
    {edges, {F(edge_square), F(edge_disc), F(edge_kernel)}},
    {frame_weights, {F(weights_even), F(weights_normalise), F(weights_kernel)}},
    {patterns, {F(pattern_create)}},
    {spreads, {F(spread_create), F(spread_clear)}},
    {antialias_bytes,
     {F(antialias_format_bytes), F(bytes_multisample), F(bytes_accumulative), F(bytes_adaptive)}},
    {shutters,
     {F(shutter_parse), F(shutter_light), F(shutter_share), F(shutter_weights),
      F(frames_for_motion), F(frames_for_circle), F(frames_for_penumbra)}},
    {cameras, {F(camera_compute), F(camera_move_to), F(camera_circle)}},
    {plans, {F(pass_plan_create), F(pass_plan_destroy)}},
    {plan_questions,
     {F(pass_plan_get_info), F(tile_name_of), F(tile_name_find), F(tile_name_format),
      F(tile_name_parse)}},
    {profiles, {F(profile_check)}},
    {ranges, {F(range_simulate), F(pass_list_check)}},
    {judgements, {F(pass_plan_judge), F(pass_work_of)}},
    {footprints,
     {F(footprint_create), F(footprint_destroy), F(footprint_get_info), F(footprint_statistics),
      F(footprint_part_statistics), F(slice_statistics_join), F(footprint_set_statistics)}},
    {residents, {F(resident_create), F(resident_destroy), F(resident_get_info)}},
    {slice_geometry, {F(slice_size_compute), F(slice_axis_geometry)}},
    {slices, {F(slice_plan_create), F(slice_plan_destroy)}},
    {methods, {F(method_plan_create), F(method_plan_destroy), F(method_format), F(method_list)}},
    {choices, {F(choose), F(choice_clear)}},
    {costs,
     {F(cost_of), F(cost_format), F(pass_work_least), F(pass_bound_least), F(separable_work_of)}},
    {meshes, {F(mesh_load), F(mesh_clear)}},
    {contexts,
     {F(context_create), F(context_destroy), F(context_begin), F(context_await),
      F(context_abandon)}},
    {multisampling,
     {F(msaa_create), F(msaa_destroy), F(msaa_run), F(msaa_read), F(msaa_get_report),
      F(msaa_positions)}},
    {accumulative,
     {F(acaa_create), F(acaa_destroy), F(acaa_run), F(acaa_read), F(acaa_read_weight),
      F(acaa_get_room), F(acaa_set_room), F(acaa_get_report)}},
    {marking,
     {F(marker_create), F(marker_destroy), F(marker_run), F(marker_read), F(marker_bytes),
      F(marks_clear), F(marks_dilate)}},
    {supersampling,
     {F(supersample_create), F(supersample_destroy), F(supersample_run), F(supersample_read),
      F(supersample_get_report)}},
    {emulations, {F(multipass_compile), F(multipass_destroy), F(multipass_verify)}},
    {convolutions_on_gl,
     {F(multipass_run), F(multipass_get_info), F(context_get_info), F(context_find_function),
      F(context_call)}},
    {separable,
     {F(separable_plan_create), F(separable_plan_destroy), F(separable_plan_get_info),
      F(separable_compile), F(separable_destroy), F(separable_run), F(separable_verify),
      F(separable_error_bound), F(separable_bound_terms), F(separable_reach),
      F(separable_survey_samples), F(separable_survey_join)}},
    {rectangles, {F(rectangle_within), F(rectangle_common)}},
    {window_maps,
     {F(window_map_plain), F(window_map_scale), F(window_map_position), F(window_map_positions),
      F(window_map_square)}},
    {resample_plans, {F(resample_plan_create), F(resample_plan_destroy)}},
    {resample_sources,
     {F(resample_source_create), F(resample_source_destroy), F(resample_measure),
      F(resample_measured_join)}},
    {resample_runs,
     {F(resample_compile), F(resample_compiled_destroy), F(resample_compiled_get_info),
      F(resample_run), F(resample_verify), F(resample_plan_get_info), F(resample_source_get_info),
      F(resample_bound), F(resample_e1), F(resample_work_add), F(resample_reach),
      F(resample_survey_source), F(resample_survey_join)}},
    {resample_integers,
     {F(resample_moves), F(resample_integer_range), F(resample_move), F(resample_move_verify)}},
    {resample_choices, {F(resample_choose), F(resample_choose_engine), F(resample_choice_clear)}},
    {pixel_errors, {F(pixels_verify), F(verify_add), F(verify_join)}},
    {hardware_plans,
     {F(hardware_plan_create), F(hardware_plan_destroy), F(hardware_plan_get_info)}},
    {samplers, {F(sampler_assume), F(sampler_measure)}},
    {slice_runs,
     {F(slice_run), F(slice_verify), F(slice_plan_get_info), F(slice_plan_get_footprint),
      F(slice_compile), F(slice_destroy), F(slice_run_once), F(slice_multipass_bound_terms)}},
    {method_runs,
     {F(method_run), F(method_plan_get_info), F(method_plan_get_slice), F(method_plan_get_passes),
      F(choose_engine)}},
    {several_ranks,
     {F(distribute_over), F(ranks_get_info), F(ranks_set_timeout), F(ranks_share), F(ranks_gather),
      F(ranks_free_parts), F(ranks_agree), F(ranks_compare), F(ranks_do_items),
      F(items_report_clear)}},
    {calibrations, {F(cost_calibrate)}},
    {stability, {F(stability_run)}},
    {cost_maps,
     {F(cost_map_create), F(cost_map_destroy), F(cost_map_add), F(cost_map_estimate),
      F(cost_map_load), F(cost_map_save)}},
    {divisions,
     {F(division_create), F(division_destroy), F(division_regions), F(division_costs),
      F(division_learn)}},
    {schedules,
     {F(regions_create), F(regions_destroy), F(regions_count), F(regions_get), F(regions_balance),
      F(load_create), F(load_clear), F(load_add), F(load_compute)}},
#undef F
};

static bool is_called(const char *function)
{
    for (size_t i = 0; i < WEFT_COUNT(cases); i++)
        for (size_t f = 0; cases[i].functions[f]; f++)
            if (strcmp(cases[i].functions[f], function) == 0)
                return true;
    return false;
}

static void every_function_has_a_case(void **state)
{
    (void)state;
    assert_true(WEFT_COUNT(public_functions) > 100);
    for (size_t i = 0; i < WEFT_COUNT(public_functions); i++)
        if (!is_called(public_functions[i]))
            fail_msg("%s has no case", public_functions[i]);
}

static void bad_values_are_refused(void **state)
{
    (void)state;
    int failed = 0, skipped = 0;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        int status = 0;
        fflush(NULL);
        const double started = weft_now_seconds();
        const pid_t child = fork();
        if (child == 0) {
            for (int number = 1; number < NSIG; number++)
                signal(number, SIG_DFL);
            alarm(SECONDS);
            cases[i].run();
            _exit(complaints > 0 ? COMPLAINTS : 0);
        }
        assert_true(child > 0 && waitpid(child, &status, 0) == child);
        if (getenv("WEFT_CALLERS_TIMES"))
            print_message("%6.2f s %s, ...\n", weft_now_seconds() - started, cases[i].functions[0]);
        const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
        skipped += code == SKIPPED;
        if (code == 0 || code == SKIPPED)
            continue;
        failed++;
        print_error("%s, ...: %s\n", cases[i].functions[0],
                    WIFSIGNALED(status)  ? strsignal(WTERMSIG(status))
                    : code == COMPLAINTS ? "see above"
                                         : "it ended");
    }
    if (skipped > 0)
        print_message("[  SKIPPED ] %d cases without a GL context\n", skipped);
    assert_int_equal(failed, 0);
}

// What is all zero but for what is required gives what the defaults written out give.
static void zero_asks_for_the_defaults(void **state)
{
    (void)state;
    static const float plane[4] = {-1.0f, 0.0f, 2.0f, 5.0f};
    float range[2];
    const struct weft_preview_params preview = {
        .path = "/dev/null", .width = 4, .height = 1, .plane = plane};
    assert_int_equal(weft_preview_save(&preview, range), WEFT_OK);
    assert_true(range[0] == -1.0f && range[1] == 5.0f);

    const struct weft_pass_plan_params plain = {0};
    const struct weft_pass_plan_params *full =
        weft_pass_plan_params(.kernel = named("catmull-rom"), .dims = 2,
                              .profile = *weft_profile_find("unorm8"), .samples = 64, .bits = 8,
                              .channels = 1, .memory_bytes = UINT64_C(1) << 30);
    weft_pass_plan *a = NULL, *b = NULL;
    assert_int_equal(weft_pass_plan_create(&plain, &a), WEFT_OK);
    assert_int_equal(weft_pass_plan_create(full, &b), WEFT_OK);
    assert_int_equal(weft_pass_plan_get_info(a)->fetches, weft_pass_plan_get_info(b)->fetches);
    assert_true(weft_pass_plan_get_info(a)->error.bound == weft_pass_plan_get_info(b)->error.bound);
    weft_pass_plan_destroy(&a);
    weft_pass_plan_destroy(&b);

    weft_kernel_tiles *set = NULL;
    const struct weft_kernel_tiles_params set_params = {.kernel = named("catmull-rom")};
    assert_int_equal(weft_kernel_tiles_create(&set_params, &set), WEFT_OK);
    const struct weft_kernel_tiles_info *info = weft_kernel_tiles_get_info(set);
    assert_true(info->dims == 2 && info->samples == 64 && info->bits == 8 && info->mirrored);
    weft_kernel_tiles_destroy(&set);

    // Of no range: that of the samples, so that the pixel of the largest is it.
    float pixel = 0.0f;
    weft_pass_plan *reals = NULL;
    const struct weft_samples samples = {.size = {4, 1, 1}, .plane = {plane}};
    const struct weft_pixel_grid grid = {.width = 1, .height = 1, .origin = {3.0, 0.0, 0.0}};
    assert_int_equal(
        weft_pass_plan_create(
            weft_pass_plan_params(.kernel = named("linear"), .profile = *weft_profile_find("fp32")),
            &reals),
        WEFT_OK);
    weft_multipass *compiled = NULL;
    struct weft_multipass_report report;
    assert_int_equal(weft_multipass_compile(NULL, weft_multipass_params(.plan = reals), &compiled),
                     WEFT_OK);
    assert_int_equal(
        weft_multipass_run(
            compiled,
            weft_multipass_run_params(.samples = &samples, .grid = &grid, .pixels = {&pixel}),
            &report),
        WEFT_OK);
    weft_multipass_destroy(&compiled);
    assert_true(report.low == -1.0 && report.high == 5.0 && report.clamped == 0);
    weft_pass_plan_destroy(&reals);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_function_has_a_case),
        cmocka_unit_test(bad_values_are_refused),
        cmocka_unit_test(zero_asks_for_the_defaults),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
