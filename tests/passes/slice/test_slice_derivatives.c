// SPDX-License-Identifier: BSD-3-Clause
// Slices of derivatives: every output of a list, by both engines, within its bound of the double
// reference; parts and resident volumes have the whole slice's bits, and what is refused.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "tests/support/contexts.h"
#include "weft.h"

enum { N = 40 };

// ---- what is sliced -----------------------------------------------------------------------------

static float data[N * N * N];

// Waves, and a corner of one value; `rough`: with voxels that floats do not stand.
static weft_volume *make_volume(bool rough)
{
    weft_volume *volume = NULL;
    for (int i = 0; i < N * N * N; i++) {
        const int x = i % N, y = i / N % N, z = i / N / N;
        const bool flat = x < 20 && y < 22;
        data[i] = flat ? 0.75f
                       : (float)(0.5 + 0.4 * sin(0.31 * x + 0.17 * y - 0.29 * z)) +
                             (x > 28 ? (float)(i * 7919 % 101) / 505.0f : 0.0f);
    }
    if (rough) {
        data[(13 * N + 21) * N + 17] = NAN;
        data[(13 * N + 18) * N + 27] = INFINITY;
        data[(15 * N + 27) * N + 11] = 3e38f;
        data[(17 * N + 8) * N + 8] = NAN;
    }
    assert_int_equal(
        weft_volume_create(weft_volume_params(.size = {N, N, N}, .background = 0.0f, .data = data),
                           &volume),
        WEFT_OK);
    return volume;
}

static const struct weft_slice_geometry oblique = {{4, 3, 5}, {27, 9, 6}, {-3, 25, 10}, 270, 90};
static const struct weft_slice_geometry across = {{2, 3, 15}, {34, 0, 0}, {0, 32, 0}, 68, 64};

#define VALUE                                                                                      \
    {                                                                                              \
        {                                                                                          \
            0, 0, 0                                                                                \
        }                                                                                          \
    }
#define GRADIENT                                                                                   \
    {{1, 0, 0}}, {{0, 1, 0}},                                                                      \
    {                                                                                              \
        {                                                                                          \
            0, 0, 1                                                                                \
        }                                                                                          \
    }
#define HESSIAN                                                                                    \
    {{2, 0, 0}}, {{1, 1, 0}}, {{1, 0, 1}}, {{0, 2, 0}}, {{0, 1, 1}},                               \
    {                                                                                              \
        {                                                                                          \
            0, 0, 2                                                                                \
        }                                                                                          \
    }
static const struct weft_derivative all[] = {VALUE, GRADIENT, HESSIAN};
static const struct weft_derivative value_and_gradient[] = {VALUE, GRADIENT};
static const struct weft_derivative mixed[] = {{{0, 1, 1}}, {{1, 0, 0}}, {{0, 1, 1}}};
static const struct weft_derivative laplacian[] = {{{2, 0, 0}}, {{0, 2, 0}}, {{0, 0, 2}}};

// What a row leaves out is the default: all outputs of the oblique slice.
struct how {
    const char *name, *kernel;
    bool rough, across;
    const struct weft_derivative *derivative;
    int count;
    struct weft_slice_params params;
};
#define LIST(list) .derivative = (list), .count = WEFT_COUNT(list)
#define GL_SLICE(...)                                                                              \
    {                                                                                              \
        .engine = WEFT_ENGINE_GL, __VA_ARGS__                                                      \
    }
#define CPU_SLICE(...)                                                                             \
    {                                                                                              \
        .engine = WEFT_ENGINE_CPU, __VA_ARGS__                                                     \
    }
static const struct how hows[] = {
    {"interleaved", "catmull-rom", true, .params = GL_SLICE(.layout = WEFT_LAYOUT_INTERLEAVED)},
    {"aligned", "bspline5", true, .params = GL_SLICE(.layout = WEFT_LAYOUT_ALIGNED)},
    {"plain", "mitchell", true, .params = GL_SLICE(.layout = WEFT_LAYOUT_PLAIN)},
    {"automatic", "bspline3", .params = GL_SLICE()},
    {"gradient", "linear", true, LIST(value_and_gradient), .params = GL_SLICE()},
    {"mixed, without the value", "bspline2", LIST(mixed), .params = GL_SLICE()},
    {"segments", "lanczos", LIST(laplacian), .params = GL_SLICE()},
    {"in little memory", "catmull-rom", true, .params = GL_SLICE(.memory_bytes = 1 << 20)},
    {"across", "bspline3", true, true, .params = GL_SLICE()},
    {"without savings", "catmull-rom", true, .params = GL_SLICE(.without = WEFT_SAVING_ALL)},
    {"smooth is not saved", "catmull-rom", .params = GL_SLICE(.smooth_error = 1e-2)},
    {"unorm8", "bspline3",
     .params = GL_SLICE(.source = WEFT_SOURCE_UNORM8, .low = -0.1, .high = 1.3)},
    {"unorm16, not adding up to one", "gaussian",
     .params = GL_SLICE(.source = WEFT_SOURCE_UNORM16, .low = -0.1, .high = 1.3,
                        .layout = WEFT_LAYOUT_ALIGNED)},
    {"half, looked up", "bspline3", LIST(value_and_gradient),
     .params = GL_SLICE(.source = WEFT_SOURCE_HALF, .low = -0.1, .high = 1.3,
                        .lookup = WEFT_LOOKUP_LINEAR, .samples = 32)},
    {"looked up, nearest", "catmull-rom", .params = GL_SLICE(.lookup = WEFT_LOOKUP_NEAREST)},
    {"prefiltered", "bspline3i", LIST(value_and_gradient), .params = GL_SLICE()},
    {"CPU", "catmull-rom", true, .params = CPU_SLICE()},
    {"CPU, double", "bspline4", true, .params = CPU_SLICE(.sums = WEFT_SUMS_DOUBLE)},
    {"CPU, gradient", "linear", true, LIST(value_and_gradient), .params = CPU_SLICE()},
    {"CPU, mixed", "keys6", LIST(mixed), .params = CPU_SLICE()},
    {"CPU, across, in little memory", "bspline7", true, true,
     .params = CPU_SLICE(.memory_bytes = 1 << 20)},
    {"CPU, prefiltered", "bspline5i", LIST(value_and_gradient), .params = CPU_SLICE()},
};

// ---- running ------------------------------------------------------------------------------------

static struct weft_slice_params params_of(const struct how *how, const struct weft_rectangle *part)
{
    struct weft_slice_params params = how->params;
    params.kernel = kernel_named(how->kernel);
    params.space = WEFT_SPACE_INDEX;
    params.geometry = how->across ? across : oblique;
    params.part = *part;
    params.log = &log_to_stderr;
    params.derivative = how->count ? how->derivative : all;
    params.derivative_count = how->count ? how->count : (int)WEFT_COUNT(all);
    return params;
}

static weft_slice_plan *plan_of(const struct how *how, weft_volume *volume,
                                const struct weft_rectangle *part, weft_resident *resident)
{
    struct weft_slice_params params = params_of(how, part);
    weft_slice_plan *plan = NULL;
    params.resident = resident;
    assert_int_equal(weft_slice_plan_create(volume, &params, &plan), WEFT_OK);
    assert_int_equal(weft_slice_plan_get_info(plan)->output_count, params.derivative_count);
    return plan;
}

// Rows `gap` floats apart, planes a row more.
static float *run(const struct how *how, const weft_slice_plan *plan, int gap,
                  struct weft_slice_report *report)
{
    const struct weft_slice_plan_info *info = weft_slice_plan_get_info(plan);
    const bool gl = how->params.engine == WEFT_ENGINE_GL;
    const int64_t stride = info->part.width + gap;
    const int64_t plane = stride * (info->part.height + (gap > 0));
    float *pixels = calloc((size_t)(plane * info->output_count), sizeof *pixels);
    assert_non_null(pixels);
    assert_int_equal(
        weft_slice_run_once(plan, weft_slice_compile_params(.context = gl ? contexts[0] : NULL),
                            weft_slice_run_params(.pixels = pixels, .stride = gap ? stride : 0,
                                                  .plane_stride = gap ? plane : 0),
                            report),
        WEFT_OK);
    return pixels;
}

// ---- checks -------------------------------------------------------------------------------------

static void check_bounds(const struct how *how, const weft_slice_plan *plan, const float *pixels)
{
    const struct weft_slice_plan_info *info = weft_slice_plan_get_info(plan);
    struct weft_verify_report found[WEFT_DERIVATIVES];
    const bool prefiltered = info->kernel.prefiltered;
    assert_int_equal(
        weft_slice_verify(plan, pixels, weft_slice_verify_params(.max_seconds = 1e-4), found),
        WEFT_OK);
    for (int o = 0; o < info->output_count; o++) {
        const struct weft_verify_report *e = &found[o];
        const struct weft_slice_output *output = &info->output[o];
        const double stated = output->error_bound * e->magnitude + output->error_absolute;
        assert_true(e->values_compared > 20);
        if (!(e->share <= 1.0) || e->not_finite_mismatches ||
            (!prefiltered && !(e->maximum <= stated * (1.0 + 1e-12))))
            fail_msg("%s, output %d: error %.3g at (%d, %d), %.9g instead of %.9g; the bound is "
                     "%.3g, %.3g times met; %d not finite on one side",
                     how->name, o, e->maximum, e->at_x, e->at_y, e->at_value, e->at_reference,
                     stated, e->share, (int)e->not_finite_mismatches);
        // Bounds are worth something: no more than a part of what derivatives are here.
        if (info->source == WEFT_SOURCE_FLOAT && info->lookup == WEFT_LOOKUP_POLYNOMIAL &&
            !prefiltered)
            assert_true(output->error_bound < 1e-4);
    }
}

static void compare(const struct how *how, const struct weft_slice_plan_info *info,
                    const float *whole, const struct weft_rectangle *at, int gap,
                    const float *pixels)
{
    const struct weft_slice_geometry *g = &info->geometry;
    const size_t stride = (size_t)(at->width + gap), plane = stride * (size_t)(at->height + !!gap);
    for (int o = 0; o < info->output_count; o++) {
        for (int y = 0; y < at->height; y++) {
            const size_t from =
                ((size_t)o * (size_t)g->height + (size_t)(at->y + y)) * (size_t)g->width +
                (size_t)at->x;
            const float *own = pixels + (size_t)o * plane + (size_t)y * stride;
            if (memcmp(whole + from, own, (size_t)at->width * sizeof *own) != 0)
                fail_msg("%s, output %d: row %d differs from the whole slice's", how->name, o,
                         at->y + y);
        }
    }
}

static void check_part(const struct how *how, weft_volume *volume, const float *whole,
                       const struct weft_rectangle *at, weft_resident *resident)
{
    enum { GAP = 3 };
    weft_slice_plan *plan = plan_of(how, volume, at, resident);
    float *pixels = run(how, plan, GAP, NULL);
    compare(how, weft_slice_plan_get_info(plan), whole, at, GAP, pixels);
    free(pixels);
    weft_slice_plan_destroy(&plan);
}

// A resident volume's whole slice is near the slice's own, whose constant cells are others, since
// blocks are of whole cells; and its parts have its bits.
static void check_resident(const struct how *how, weft_volume *volume, const weft_slice_plan *own,
                           const float *whole)
{
    const struct weft_slice_plan_info *info = weft_slice_plan_get_info(own);
    const bool gl = how->params.engine == WEFT_ENGINE_GL;
    const size_t plane = (size_t)info->geometry.width * (size_t)info->geometry.height;
    weft_resident *resident = NULL;
    assert_int_equal(weft_resident_create(
                         weft_resident_params(.volume = volume, .context = gl ? contexts[0] : NULL,
                                              .kernel = info->kernel, .layout = info->layout,
                                              .source = info->source, .memory_bytes = 64 << 20,
                                              .low = how->params.low, .high = how->params.high,
                                              .log = &log_to_stderr),
                         &resident),
                     WEFT_OK);
    weft_slice_plan *plan = plan_of(how, volume, &(struct weft_rectangle){0}, resident);
    float *pixels = run(how, plan, 0, NULL);
    for (size_t i = 0; i < plane * (size_t)info->output_count; i++) {
        const struct weft_slice_output *output = &info->output[i / plane];
        const double both = 2.0 * (2.0 * output->error_bound + output->error_absolute);
        if (isfinite(pixels[i]) != isfinite(whole[i]) ||
            (isfinite(pixels[i]) && how->rough == false &&
             !(fabs((double)pixels[i] - (double)whole[i]) <= both)))
            fail_msg("%s, output %zu: %.9g of a resident volume, else %.9g", how->name, i / plane,
                     (double)pixels[i], (double)whole[i]);
    }
    check_part(how, volume, pixels, &(struct weft_rectangle){33, 7, 19, 9}, resident);
    free(pixels);
    weft_slice_plan_destroy(&plan);
    weft_resident_destroy(&resident);
}

// Exactly 0 where all voxels in reach are one value, and the value itself.
static void check_flat(const struct weft_slice_plan_info *info, const float *pixels)
{
    const size_t plane = (size_t)info->geometry.width * (size_t)info->geometry.height;
    size_t flat = 0;
    for (size_t i = 0; i < plane; i++) {
        if (pixels[i] != 0.75f)
            continue;
        for (int o = 1; o < info->output_count; o++)
            flat += pixels[(size_t)o * plane + i] == 0.0f;
    }
    if (info->savings & WEFT_SAVING_CONSTANT)
        assert_true(flat > (size_t)info->output_count * 40);
}

static void check_how(const struct how *how)
{
    weft_volume *volume = make_volume(how->rough);
    weft_slice_plan *plan = plan_of(how, volume, &(struct weft_rectangle){0}, NULL);
    const struct weft_slice_plan_info *info = weft_slice_plan_get_info(plan);
    struct weft_slice_report report;
    float *whole = run(how, plan, 0, &report);
    const int width = info->geometry.width, height = info->geometry.height;
    assert_int_equal(
        info->savings & (WEFT_SAVING_AXIS | WEFT_SAVING_SEPARABLE | WEFT_SAVING_SMOOTH), 0);
    if (how->rough && !how->across)
        assert_true(report.exact_pixels > 10);
    check_bounds(how, plan, whole);
    if (info->output_count == (int)WEFT_COUNT(all) && !how->across)
        check_flat(info, whole);
    check_part(how, volume, whole, &(struct weft_rectangle){width / 3, 7, width / 3, 9}, NULL);
    check_part(how, volume, whole, &(struct weft_rectangle){width - 9, height - 8, 7, 7}, NULL);
    check_resident(how, volume, plan, whole);
    free(whole);
    weft_slice_plan_destroy(&plan);
    weft_volume_destroy(&volume);
}

static void outputs_are_within_their_bounds(void **state)
{
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(hows); i++)
        if (!WITHOUT_GL || hows[i].params.engine == WEFT_ENGINE_CPU)
            check_how(&hows[i]);
}

// ---- quantities ---------------------------------------------------------------------------------

static double fetch(void *priv, const int64_t index[3])
{
    (void)priv;
    for (int a = 0; a < 3; a++)
        if (index[a] < 0 || index[a] >= N)
            return 0.0;
    return (double)data[(index[2] * N + index[1]) * N + index[0]];
}

// Derivatives at a pixel in double, and the largest voxel in reach.
static double refer(const struct weft_slice_plan_info *info, int x, int y, double out[])
{
    const struct weft_slice_geometry *g = &info->geometry;
    struct weft_kernel orders[3] = {info->kernel};
    double at[3], magnitude = 0.0;
    for (int n = 1; n < 3; n++)
        assert_int_equal(weft_kernel_derive(NULL, &orders[n - 1], &orders[n]), WEFT_OK);
    for (int a = 0; a < 3; a++)
        at[a] = g->origin[a] + (x + 0.5) * g->u[a] / g->width + (y + 0.5) * g->v[a] / g->height;
    for (int o = 0; o < info->output_count; o++) {
        struct weft_kernel own[3];
        for (int a = 0; a < 3; a++)
            own[a] = orders[info->output[o].derivative.along[a]];
        const struct weft_reference_value value =
            weft_reference_compute_axes(own, 3, at, fetch, NULL);
        out[o] = value.value;
        magnitude = fmax(magnitude, value.magnitude);
    }
    return magnitude;
}

// Within what the bounds of derivatives make of each quantity.
static int check_quantities(const struct weft_quantities *list,
                            const struct weft_slice_plan_info *info, const float *pixels, int x,
                            int y)
{
    static const double to_world[3][4] = {{0.5, 0.1, 0.0, 0.0}, {0.0, 0.4, 0.0}, {0.1, 0.0, 0.7}};
    const size_t plane = (size_t)info->geometry.width * (size_t)info->geometry.height;
    struct weft_quantity_transform transform;
    double exact[WEFT_DERIVATIVES], made[WEFT_DERIVATIVES], error[WEFT_DERIVATIVES];
    double expected[WEFT_QUANTITY_CHANNELS], found[WEFT_QUANTITY_CHANNELS];
    double bound[WEFT_QUANTITY_CHANNELS];
    int finite = 0;
    assert_int_equal(weft_quantity_transform_create(NULL, to_world, &transform), WEFT_OK);
    const double magnitude = refer(info, x, y, exact);
    for (int o = 0; o < info->output_count; o++) {
        const struct weft_slice_output *output = &info->output[o];
        made[o] = (double)pixels[(size_t)o * plane + (size_t)(y * info->geometry.width + x)];
        error[o] = output->error_bound * magnitude + output->error_absolute;
    }
    weft_quantities_compute(list, &transform, exact, expected);
    weft_quantities_compute(list, &transform, made, found);
    weft_quantities_bound(list, &transform, made, error, bound);
    for (int c = 0; c < list->channel_count; c++) {
        if (!(fabs(found[c] - expected[c]) <= bound[c]))
            fail_msg("%s at (%d, %d): %.9g instead of %.9g, the bound is %.3g", list->channel[c], x,
                     y, found[c], expected[c], bound[c]);
        finite += bound[c] < 0.1 * (1.0 + fabs(expected[c]));
    }
    return finite;
}

static void bounds_hold_for_every_quantity(void **state)
{
    static const struct how engines[] = {
        {"GL", "bspline3", .params = GL_SLICE()},
        {"CPU", "bspline3", .params = CPU_SLICE()},
    };
    static const char *const names = "value,gradient,gradient-magnitude,normal,hessian,laplacian,"
                                     "mean-curvature,gaussian-curvature,principal-curvatures";
    struct weft_quantities list;
    weft_volume *volume = make_volume(false);
    (void)state;
    assert_int_equal(weft_quantities_parse(&log_to_stderr, names, &list), WEFT_OK);
    for (size_t i = WITHOUT_GL; i < WEFT_COUNT(engines); i++) {
        struct how how = engines[i];
        how.derivative = list.derivative;
        how.count = list.derivative_count;
        weft_slice_plan *plan = plan_of(&how, volume, &(struct weft_rectangle){0}, NULL);
        const struct weft_slice_plan_info *info = weft_slice_plan_get_info(plan);
        float *pixels = run(&how, plan, 0, NULL);
        int checked = 0, finite = 0;
        for (int y = 3; y < info->geometry.height; y += 11)
            for (int x = 5; x < info->geometry.width; x += 23, checked++)
                finite += check_quantities(&list, info, pixels, x, y);
        assert_true(checked > 80 && finite > checked * list.channel_count / 2);
        free(pixels);
        weft_slice_plan_destroy(&plan);
    }
    weft_volume_destroy(&volume);
}

// A list of the value alone is no list; on the CPU the value has its bits in any list.
static void values_are_the_same(void **state)
{
    static const struct weft_derivative value[] = {VALUE};
    static const struct how lists[] = {
        {"value", "catmull-rom", true, LIST(value), .params = CPU_SLICE()},
        {"all", "catmull-rom", true, LIST(all), .params = CPU_SLICE()},
        {"value on GL", "catmull-rom", true, LIST(value), .params = GL_SLICE()},
    };
    weft_volume *volume = make_volume(true);
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(lists) - WITHOUT_GL; i++) {
        struct weft_slice_params params = params_of(&lists[i], &(struct weft_rectangle){0});
        weft_slice_plan *plan = plan_of(&lists[i], volume, &(struct weft_rectangle){0}, NULL);
        weft_slice_plan *plain = NULL;
        params.derivative_count = 0;
        assert_int_equal(weft_slice_plan_create(volume, &params, &plain), WEFT_OK);
        float *pixels = run(&lists[i], plan, 0, NULL), *values = run(&lists[i], plain, 0, NULL);
        assert_memory_equal(pixels, values,
                            (size_t)params.geometry.width * (size_t)params.geometry.height *
                                sizeof *values);
        if (lists[i].count == 1)
            assert_string_equal(weft_slice_plan_get_info(plan)->text,
                                weft_slice_plan_get_info(plain)->text);
        else
            assert_non_null(strstr(weft_slice_plan_get_info(plan)->text,
                                   "output 04: derivative along xx, error bound"));
        free(pixels);
        free(values);
        weft_slice_plan_destroy(&plan);
        weft_slice_plan_destroy(&plain);
    }
    weft_volume_destroy(&volume);
}

static void what_is_refused(void **state)
{
    static const struct weft_derivative third = {{1, 1, 1}}, negative = {{-1, 0, 0}};
    static const struct {
        const char *kernel, *text;
        enum weft_result result;
        struct weft_slice_params params;
    } cases[] = {
        {"nearest",
         "kernel nearest has no derivative of order 1",
         WEFT_ERR_UNSUPPORTED,
         {.derivative = value_and_gradient, .derivative_count = 4}},
        {"linear",
         "kernel linear has no derivative of order 2",
         WEFT_ERR_UNSUPPORTED,
         {.derivative = all, .derivative_count = 10}},
        {"lanczos+unit",
         "kernel lanczos+unit has no derivative of order 1",
         WEFT_ERR_UNSUPPORTED,
         {.derivative = all, .derivative_count = 10}},
        {"catmull-rom",
         "clamped to samples",
         WEFT_ERR_UNSUPPORTED,
         {.derivative = all, .derivative_count = 10, .clamp_to_samples = true}},
        {"catmull-rom", "<= 2", WEFT_ERR_ARGUMENT, {.derivative = &third, .derivative_count = 1}},
        {"catmull-rom",
         ">= 0",
         WEFT_ERR_ARGUMENT,
         {.derivative = &negative, .derivative_count = 1}},
        {"catmull-rom", "derivative", WEFT_ERR_ARGUMENT, {.derivative_count = 1}},
        {"catmull-rom",
         "derivative_count",
         WEFT_ERR_ARGUMENT,
         {.derivative = all, .derivative_count = 11}},
    };
    weft_volume *volume = make_volume(false);
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct message message = {"", 0};
        const struct weft_log log = {keep_message, &message};
        struct weft_slice_params params = cases[i].params;
        weft_slice_plan *plan = NULL;
        params.kernel = kernel_named(cases[i].kernel);
        params.space = WEFT_SPACE_INDEX;
        params.geometry = oblique;
        params.log = &log;
        assert_int_equal(weft_slice_plan_create(volume, &params, &plan), cases[i].result);
        assert_null(plan);
        assert_int_equal(message.count, 1);
        if (!strstr(message.text, cases[i].text))
            fail_msg("%zu: %s", i, message.text);
    }
    weft_volume_destroy(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(outputs_are_within_their_bounds),
        cmocka_unit_test(bounds_hold_for_every_quantity),
        cmocka_unit_test(values_are_the_same),
        cmocka_unit_test(what_is_refused),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
