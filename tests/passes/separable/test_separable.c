// SPDX-License-Identifier: BSD-3-Clause
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "tests/passes/separable/wheres.h"
#include "weft.h"

// ---- samples and positions ----------------------------------------------------------------------

enum { MAX_SIDE = 400, MAX_SAMPLES = 400 * 300 };

// A request with memory of its own.
struct request {
    struct weft_separable_params params;
    struct weft_separable_run_params run;
    float samples[MAX_SAMPLES];
    double x[MAX_SIDE], y[MAX_SIDE];
    float pixels[MAX_SIDE * MAX_SIDE];
};

// A repeatable value in [-1, 1] for every number: the hardest signal for interpolation.
static double noise(uint32_t i)
{
    uint32_t h = i * 73856093u + 1u;
    h = (h ^ h >> 16) * 0x7feb352du;
    h = (h ^ h >> 15) * 0x846ca68bu;
    return (double)(h ^ h >> 16) / 2147483647.5 - 1.0;
}

// Pixels of equal size over all samples and half a one around them.
static void set_positions(double *at, int pixels, int samples)
{
    for (int i = 0; i < pixels; i++)
        at[i] = (i + 0.5) * samples / pixels - 0.5;
}

static struct request *make_request(const char *kernel, int nx, int ny, int width, int height)
{
    struct request *r = calloc(1, sizeof *r);
    assert_non_null(r);
    assert_true(nx * ny <= MAX_SAMPLES && width <= MAX_SIDE && height <= MAX_SIDE);
    for (int i = 0; i < nx * ny; i++)
        r->samples[i] = (float)noise((uint32_t)i);
    set_positions(r->x, width, nx);
    set_positions(r->y, height, ny);
    r->params = (struct weft_separable_params){
        .kernel = kernel_named(kernel),
        .size = {nx, ny},
        .width = width,
        .height = height,
        .x = r->x,
        .y = r->y,
        .log = &log_to_stderr,
    };
    r->run = (struct weft_separable_run_params){
        .samples = r->samples, .pixels = r->pixels, .log = &log_to_stderr};
    return r;
}

// Plans, compiles, runs once and ends all of it.
static enum weft_result filter(const struct where *where, struct request *r,
                               struct weft_separable_report *report)
{
    weft_separable_plan *plan = NULL;
    weft_separable *compiled = NULL;
    r->params.engine = where->engine;
    r->params.sums = where->sums;
    enum weft_result res = weft_separable_plan_create(&r->params, &plan);
    if (res == WEFT_OK)
        res = weft_separable_compile(plan, &where->compile, &compiled);
    if (res == WEFT_OK)
        res = weft_separable_run(compiled, &r->run, report);
    weft_separable_destroy(&compiled);
    weft_separable_plan_destroy(&plan);
    return res;
}

static enum weft_result verify(const struct request *r, const struct weft_verify_params *how,
                               struct weft_verify_report *error)
{
    weft_separable_plan *plan = NULL;
    enum weft_result res = weft_separable_plan_create(&r->params, &plan);
    if (res == WEFT_OK)
        res = weft_separable_verify(plan, &r->run, how, error);
    weft_separable_plan_destroy(&plan);
    return res;
}

static int first_axis_of(const struct request *r)
{
    weft_separable_plan *plan = NULL;
    assert_int_equal(weft_separable_plan_create(&r->params, &plan), WEFT_OK);
    const int axis = weft_separable_plan_get_info(plan)->first_axis;
    weft_separable_plan_destroy(&plan);
    return axis;
}

// Runs and compares every pixel with the reference.
static struct weft_verify_report run(const struct where *where, struct request *r,
                                     struct weft_separable_report *report)
{
    struct weft_verify_report error;
    assert_int_equal(filter(where, r, report), WEFT_OK);
    assert_int_equal(verify(r, NULL, &error), WEFT_OK);
    assert_int_equal(error.pixels_checked, r->params.width * r->params.height);
    return error;
}

static void assert_within_bound(const struct weft_verify_report *error, const struct request *r,
                                const char *what)
{
    const double bound = weft_separable_error_bound(&r->params.kernel, r->params.sums);
    if (!(error->relative_maximum <= bound) || error->not_finite_mismatches)
        fail_msg("%s: error %.3g of %.3g at (%d, %d), %d not finite", what, error->relative_maximum,
                 bound, error->at_x, error->at_y, (int)error->not_finite_mismatches);
}

// ---- against the reference ----------------------------------------------------------------------

static void every_kernel_meets_the_reference(void **state)
{
    (void)state;
    double closest = 0.0;
    for (int w = 0; w < where_count; w++) {
        for (const struct weft_kernel_info *const *k = weft_kernel_list; *k; k++) {
            struct request *r = make_request((*k)->name, 23, 19, 47, 31);
            const struct weft_verify_report error = run(&wheres[w], r, NULL);
            assert_within_bound(&error, r, (*k)->name);
            closest =
                fmax(closest, error.relative_maximum /
                                  weft_separable_error_bound(&r->params.kernel, r->params.sums));
            free(r);
        }
    }
    print_message("the largest error is %.2f of its bound\n", closest);
}

static const struct shape {
    const char *what, *kernel;
    int nx, ny, width, height;
    int first_axis; // -1: either
} shapes[] = {
    {"one sample", "catmull-rom", 1, 1, 9, 7, -1},
    {"one sample, one pixel", "lanczos:8", 1, 1, 1, 1, -1},
    {"a row", "bspline3", 50, 1, 101, 3, -1},
    {"a column", "bspline3", 1, 50, 3, 101, -1},
    {"a kernel wider than the samples", "lanczos:8", 3, 2, 30, 41, -1},
    {"one column of pixels", "mitchell", 20, 30, 1, 77, -1},
    {"one row of pixels", "mitchell", 20, 30, 77, 1, -1},
    {"magnification", "catmull-rom", 40, 30, 399, 301, 0},
    {"magnification, whole texels", "catmull-rom", 40, 30, 400, 300, 0},
    {"as many", "bspline7", 60, 60, 60, 60, -1},
    {"minification", "bspline3", 400, 300, 33, 21, 1},
    {"minification along y", "lanczos:3", 30, 400, 120, 10, 1},
    {"minification along x", "lanczos:3", 400, 30, 10, 120, 0},
    {"nearest", "nearest", 31, 17, 90, 70, -1},
};

static void every_shape_meets_the_reference(void **state)
{
    (void)state;
    for (int w = 0; w < where_count; w++) {
        for (size_t i = 0; i < WEFT_COUNT(shapes); i++) {
            const struct shape *s = &shapes[i];
            struct weft_separable_report report;
            struct request *r = make_request(s->kernel, s->nx, s->ny, s->width, s->height);
            const struct weft_verify_report error = run(&wheres[w], r, &report);
            assert_within_bound(&error, r, s->what);
            if (s->first_axis >= 0 && first_axis_of(r) != s->first_axis)
                fail_msg("%s: axis %d went first", s->what, first_axis_of(r));
            assert_int_equal(report.passes,
                             wheres[w].engine == WEFT_ENGINE_GL ? 2 * report.rectangles : 0);
            assert_int_equal(report.cpu.instructions, wheres[w].compile.cpu.instructions);
            assert_int_equal(report.pixels.count, s->width * s->height);
            free(r);
        }
    }
}

static void positions_may_be_anywhere(void **state)
{
    (void)state;
    static const double far[] = {-1e300, -1e18, -4e9, -100.5, -3.0, -2.0, -1.0, -0.0,
                                 1e300,  1e18,  4e9,  100.5,  15.0, 14.0, 13.5};
    struct request *r = make_request("lanczos:3", 13, 13, 120, 120);
    for (int i = 0; i < 120; i++) {
        r->x[i] = i % 3 ? 20.0 * noise((uint32_t)i) : far[(size_t)i / 3 % WEFT_COUNT(far)];
        r->y[i] = i % 3 ? 20.0 * noise((uint32_t)~i) : far[(size_t)i % WEFT_COUNT(far)];
    }
    for (int w = 0; w < where_count; w++) {
        const struct weft_verify_report error = run(&wheres[w], r, NULL);
        assert_within_bound(&error, r, "positions in any order");
    }
    free(r);
}

static void constants_stay(void **state)
{
    (void)state;
    for (const struct weft_kernel_info *const *k = weft_kernel_list; *k; k++) {
        struct request *r = make_request((*k)->name, 11, 9, 50, 40);
        for (int i = 0; i < 11 * 9; i++)
            r->samples[i] = -3.7f;
        // The sum of a catalogue kernel's weights in double is 1 this closely.
        const double bound =
            3.7f * (weft_separable_error_bound(&r->params.kernel, r->params.sums) + 1e-13);
        if (r->params.kernel.unit_sum) {
            assert_int_equal(filter(&wheres[0], r, NULL), WEFT_OK);
            for (int i = 0; i < 50 * 40; i++)
                assert_near((double)r->pixels[i], (double)-3.7f, bound, (*k)->name);
        }
        free(r);
    }
}

// ---- not finite, cut, stride --------------------------------------------------------------------

// Whether a tap along an axis that reads one of two samples has a weight that is not 0.
static bool counts(const struct weft_kernel *kernel, double at, int size, int sample)
{
    double weights[WEFT_KERNEL_MAX_WIDTH];
    const int64_t first = weft_kernel_weights(kernel, at, weights);
    for (int j = 0; j < kernel->width; j++) {
        const int64_t tap = first + j < 0 ? 0 : first + j >= size ? size - 1 : first + j;
        if (tap == sample && weights[j] != 0.0)
            return true;
    }
    return false;
}

// A pixel is not finite where a tap of its that counts is not, and only there.
static int check_not_finite(const struct request *r, const int bad[2][2], const char *what)
{
    const struct weft_separable_params *p = &r->params;
    bool columns[2][MAX_SIDE], rows[2][MAX_SIDE];
    int count = 0;
    for (int i = 0; i < 2; i++) {
        for (int x = 0; x < p->width; x++)
            columns[i][x] = counts(&p->kernel, p->x[x], p->size[0], bad[i][0]);
        for (int y = 0; y < p->height; y++)
            rows[i][y] = counts(&p->kernel, p->y[y], p->size[1], bad[i][1]);
    }
    for (int y = 0; y < p->height; y++) {
        for (int x = 0; x < p->width; x++) {
            const bool expected = (columns[0][x] && rows[0][y]) || (columns[1][x] && rows[1][y]);
            if (isfinite(r->pixels[y * p->width + x]) == expected)
                fail_msg("%s at (%d, %d): %g", what, x, y, (double)r->pixels[y * p->width + x]);
            count += expected;
        }
    }
    return count;
}

static void not_finite_samples_stay_where_they_count(void **state)
{
    (void)state;
    static const char *const kernels[] = {"nearest",   "linear",          "bspline2",
                                          "lagrange5", "catmull-rom",     "lanczos:3",
                                          "d-linear",  "gaussian:2,0.05", "gaussian:2,0.11"};
    static const float values[] = {NAN, INFINITY, -INFINITY};
    static const int bad[2][2] = {{22, 17}, {39, 36}};
    // Minified, some columns whole, all whole: pixels of the three.
    static const int sizes[][2] = {{21, 33}, {160, 111}, {40, 37}};
    for (int w = 0; w < where_count; w++) {
        for (size_t i = 0; i < WEFT_COUNT(kernels) * WEFT_COUNT(values) * WEFT_COUNT(sizes); i++) {
            const char *kernel = kernels[i % WEFT_COUNT(kernels)];
            const int *size = sizes[i / WEFT_COUNT(kernels) % WEFT_COUNT(sizes)];
            struct request *r = make_request(kernel, 40, 37, size[0], size[1]);
            for (int b = 0; b < 2; b++)
                r->samples[bad[b][1] * 40 + bad[b][0]] =
                    values[i / WEFT_COUNT(kernels) / WEFT_COUNT(sizes)];
            for (int x = 0; size[0] == 160 && x < 40; x++)
                r->x[x] = x;
            assert_int_equal(filter(&wheres[w], r, NULL), WEFT_OK);
            const int count = check_not_finite(r, bad, kernel);
            assert_in_range(count, size[0] < 40 ? 0 : 1, size[0] * size[1] / 4);
            if (size[0] == 40 && r->params.kernel.interpolating)
                assert_int_equal(count, 2);
            if (i % 4 == 0) {
                struct weft_verify_report error;
                assert_int_equal(verify(r, NULL, &error), WEFT_OK);
                assert_within_bound(&error, r, kernel);
            }
            free(r);
        }
    }
}

// At whole positions of an interpolating kernel the pixel is the sample, whatever its bits.
static void whole_positions_give_the_samples(void **state)
{
    (void)state;
    static const uint32_t special[] = {0x80000000, 0x00000001, 0x807fffff, 0x7f7fffff,
                                       0xff7fffff, 0x7f800000, 0xff800000, 0x7fc12345};
    int kernels = 0;
    for (const struct weft_kernel_info *const *k = weft_kernel_list; *k; k++) {
        for (int times = 1; (*k)->interpolating && times <= 3; times += 2) {
            struct request *r = make_request((*k)->name, 61, 43, 61 * times, 43 * times);
            for (int i = 0; i < 61 * 43; i += 7)
                memcpy(&r->samples[i], &special[(size_t)i / 7 % WEFT_COUNT(special)],
                       sizeof *special);
            for (int i = 0; i < 61 * times; i++)
                r->x[i] = ((2 * i + 1) * 61 - 61 * times) / (2.0 * 61 * times);
            for (int i = 0; i < 43 * times; i++)
                r->y[i] = ((2 * i + 1) * 43 - 43 * times) / (2.0 * 43 * times);
            assert_int_equal(filter(&wheres[kernels % where_count], r, NULL), WEFT_OK);
            for (int y = 0; y < 43; y++)
                for (int x = 0; x < 61; x++)
                    if (memcmp(&r->pixels[(times * y + times / 2) * 61 * times + times * x +
                                          times / 2],
                               &r->samples[y * 61 + x], sizeof(float)) != 0)
                        fail_msg("%s, %d times, (%d, %d)", (*k)->name, times, x, y);
            kernels += times == 1;
            free(r);
        }
    }
    assert_in_range(kernels, 8, 100);
}

// Where a value of no data next to others is as large as floats go, no sum overflows on its way to
// a result in their range; and results beyond it are infinite, or that range's end.
static void the_largest_floats_do_not_overflow(void **state)
{
    (void)state;
    static const char *const kernels[] = {"nearest",  "linear",    "catmull-rom", "lanczos:3+unit",
                                          "bspline7", "lagrange5", "d-bspline3",  "keys6"};
    static const float fills[][2] = {
        {FLT_MAX, 1.0f}, {-FLT_MAX, FLT_MAX}, {FLT_MAX, FLT_MAX}, {0x1p126f, -0x1.8p125f}};
    int inside = 0, beyond = 0;
    for (size_t i = 0; i < WEFT_COUNT(kernels) * WEFT_COUNT(fills); i++) {
        const float *fill = fills[i / WEFT_COUNT(kernels)];
        const char *kernel = kernels[i % WEFT_COUNT(kernels)];
        struct request *r = make_request(kernel, 24, 18, 43, 37);
        for (int s = 0; s < 24 * 18; s++)
            r->samples[s] = fill[noise((uint32_t)s) > 0.0];
        for (int w = 0; w < where_count; w++) {
            const struct weft_verify_report error = run(&wheres[w], r, NULL);
            assert_within_bound(&error, r, kernel);
            for (int p = 0; p < 43 * 37; p++) {
                assert_false(isnan(r->pixels[p]));
                inside += isfinite(r->pixels[p]);
                beyond += isinf(r->pixels[p]);
            }
        }
        free(r);
    }
    assert_true(inside > 100000 && beyond > 1000);
}

static void pixels_do_not_depend_on_the_cut(void **state)
{
    (void)state;
    static const struct shape *const cases[] = {&shapes[7], &shapes[8], &shapes[10], &shapes[12]};
    static const uint64_t memory[] = {200000, 30000, 12000};
    static float whole[MAX_SIDE * MAX_SIDE];
    for (size_t i = 0; i < WEFT_COUNT(cases) * WEFT_COUNT(memory); i++) {
        const struct shape *s = cases[i / WEFT_COUNT(memory)];
        struct request *r = make_request(s->kernel, s->nx, s->ny, s->width, s->height);
        for (int w = 0; w < where_count; w++) {
            struct weft_separable_report report;
            r->params.memory_bytes = 0;
            assert_int_equal(filter(&wheres[w], r, &report), WEFT_OK);
            if (wheres[w].engine == WEFT_ENGINE_GL)
                assert_int_equal(report.rectangles, 1);
            memcpy(whole, r->pixels, sizeof whole);
            memset(r->pixels, 0xff, sizeof r->pixels);
            r->params.memory_bytes = memory[i % WEFT_COUNT(memory)];
            assert_int_equal(filter(&wheres[w], r, &report), WEFT_OK);
            if (wheres[w].engine == WEFT_ENGINE_GL)
                assert_true(report.rectangles > 1 || r->params.memory_bytes > 12000);
            assert_true(report.peak_bytes <= r->params.memory_bytes);
            assert_memory_equal(r->pixels, whole,
                                sizeof *whole * (size_t)s->width * (size_t)s->height);
        }
        free(r);
    }
}

static void only_the_pixels_are_written(void **state)
{
    (void)state;
    static const int strides[] = {60, 61, 64, 100};
    static const int widths[] = {57, 60};
    const size_t cases = WEFT_COUNT(strides) * WEFT_COUNT(widths);
    for (size_t i = 0; i < cases * (size_t)where_count; i++) {
        const struct where *where = &wheres[i / cases];
        const int width = widths[i / WEFT_COUNT(strides) % WEFT_COUNT(widths)];
        struct request *r = make_request("catmull-rom", 20, 20, width, 50);
        r->run.stride = strides[i % WEFT_COUNT(strides)];
        r->params.memory_bytes = i % 2 ? 20000 : 0;
        for (size_t p = 0; p < WEFT_COUNT(r->pixels); p++)
            r->pixels[p] = 77.0f;
        const struct weft_verify_report error = run(where, r, NULL);
        assert_within_bound(&error, r, "stride");
        for (int p = 0; p < MAX_SIDE * MAX_SIDE; p++)
            if (p % r->run.stride >= width || p / r->run.stride >= 50)
                assert_true(r->pixels[p] == 77.0f);
        free(r);
    }
}

static void only_samples_in_reach_are_uploaded(void **state)
{
    (void)state;
    if (first_cpu == 0)
        skip();
    struct weft_separable_report report;
    struct request *r = make_request("catmull-rom", 400, 300, 8, 8);
    for (int i = 0; i < 8; i++) {
        r->x[i] = i < 4 ? 10.5 : 390.25; // eight columns of samples
        r->y[i] = i < 4 ? 5.5 : 250.25;  // and eight rows
    }
    const struct weft_verify_report error = run(&wheres[0], r, &report);
    assert_within_bound(&error, r, "two places");
    // And a texel of weights and a first tap for all positions.
    assert_int_equal(report.uploaded_bytes, 8 * 8 * 4 + 16 * (16 + 4));
    free(r);
}

// ---- once means once ----------------------------------------------------------------------------

// The second run makes and uploads nothing but samples, and gives the same pixels; samples that are
// not finite ask for another program, once.
static void runs_repeat_nothing_and_agree(void **state)
{
    static float first[MAX_SIDE * MAX_SIDE];
    (void)state;
    for (int i = 0; i < 2 * where_count; i++) {
        const struct where *where = &wheres[i / 2];
        const bool gl = where->engine == WEFT_ENGINE_GL;
        struct request *r = make_request("bspline3", 60, 50, 127, 101);
        struct weft_separable_report report[4];
        weft_separable_plan *plan = NULL;
        weft_separable *compiled = NULL;
        r->params.memory_bytes = i % 2 ? 40000 : 0; // several rectangles, or one
        r->params.engine = where->engine;
        r->params.sums = where->sums;
        assert_int_equal(weft_separable_plan_create(&r->params, &plan), WEFT_OK);
        assert_int_equal(weft_separable_compile(plan, &where->compile, &compiled), WEFT_OK);
        assert_int_equal(weft_separable_run(compiled, &r->run, &report[0]), WEFT_OK);
        memcpy(first, r->pixels, sizeof first);
        memset(r->pixels, 0, sizeof r->pixels);
        assert_int_equal(weft_separable_run(compiled, &r->run, &report[1]), WEFT_OK);
        assert_memory_equal(r->pixels, first, sizeof first);
        assert_int_equal(report[0].programs_linked, 0);
        assert_int_equal(report[1].programs_linked, 0);
        // A texel of weights and a first tap for 127 columns, to whole texels, and 101 rows.
        if (i % 2 == 0 && gl)
            assert_int_equal(report[0].uploaded_bytes - report[1].uploaded_bytes,
                             (128 + 104) * (16 + 4));
        assert_true(!gl || (report[0].rectangles > 1) == (i % 2));
        r->samples[77] = NAN;
        assert_int_equal(weft_separable_run(compiled, &r->run, &report[2]), WEFT_OK);
        assert_int_equal(weft_separable_run(compiled, &r->run, &report[3]), WEFT_OK);
        assert_int_equal(report[3].programs_linked, 0);
        r->samples[77] = (float)noise(77);
        assert_int_equal(weft_separable_run(compiled, &r->run, NULL), WEFT_OK);
        assert_memory_equal(r->pixels, first, sizeof first);
        weft_separable_destroy(&compiled);
        weft_separable_plan_destroy(&plan);
        free(r);
    }
}

// ---- refusals -----------------------------------------------------------------------------------

static void radial(struct request *r)
{
    r->params.kernel = kernel_named("catmull-rom+radial");
}
static void no_samples(struct request *r)
{
    r->run.samples = NULL;
}
static void no_pixels(struct request *r)
{
    r->run.pixels = NULL;
}
static void no_positions(struct request *r)
{
    r->params.y = NULL;
}
static void no_size(struct request *r)
{
    r->params.size[1] = 0;
}
static void too_many_samples(struct request *r)
{
    r->params.size[0] = WEFT_SEPARABLE_MAX_SIZE + 1;
}
static void no_width(struct request *r)
{
    r->params.width = 0;
}
static void too_high(struct request *r)
{
    r->params.height = WEFT_SEPARABLE_MAX_SIZE + 1;
}
static void small_stride(struct request *r)
{
    r->run.stride = 29;
}
static void nan_position(struct request *r)
{
    r->x[29] = NAN;
}
static void infinite_position(struct request *r)
{
    r->y[3] = -INFINITY;
}
static void little_memory(struct request *r)
{
    r->params.memory_bytes = 100;
}

static void no_engine(struct request *r)
{
    r->params.engine = (enum weft_engine)2;
}
static void no_sums(struct request *r)
{
    r->params.sums = (enum weft_sums) - 1;
}
static void double_on_gl(struct request *r)
{
    r->params.engine = WEFT_ENGINE_GL;
    r->params.sums = WEFT_SUMS_DOUBLE;
}
static void double_samples(struct request *r)
{
    r->run.wide = r->x; // of sums in single precision
}

static const struct refusal {
    void (*change)(struct request *r);
    enum weft_result result;
    const char *text;
    bool run_only;
} refusals[] = {
    {radial, WEFT_ERR_UNSUPPORTED, "radial", false},
    {no_samples, WEFT_ERR_ARGUMENT, "params->samples || params->wide", false},
    {no_pixels, WEFT_ERR_ARGUMENT, "required: params->pixels", false},
    {no_positions, WEFT_ERR_ARGUMENT, "p->y", false},
    {no_size, WEFT_ERR_ARGUMENT, "of 10 x 0 samples", false},
    {too_many_samples, WEFT_ERR_ARGUMENT, "16777217 x 10 samples", false},
    {no_width, WEFT_ERR_ARGUMENT, "to 0 x 20 pixels", false},
    {too_high, WEFT_ERR_ARGUMENT, "to 30 x 16777217 pixels", false},
    {small_stride, WEFT_ERR_ARGUMENT, "stride of 29 floats", false},
    {nan_position, WEFT_ERR_ARGUMENT, "nan of pixel 29 along x", false},
    {infinite_position, WEFT_ERR_ARGUMENT, "-inf of pixel 3 along y", false},
    {little_memory, WEFT_ERR_LIMIT, "over the limit of 100 bytes", true},
    {no_engine, WEFT_ERR_ARGUMENT, "p->engine is 2", false},
    {no_sums, WEFT_ERR_ARGUMENT, "p->sums is -1", false},
    {double_on_gl, WEFT_ERR_UNSUPPORTED, "need the CPU engine", false},
    {double_samples, WEFT_ERR_ARGUMENT, "!params->wide", false},
};

// Planned, compiled and run as it is asked for, once.
static enum weft_result request_as_it_is(const struct where *where, struct request *r)
{
    struct where own = *where;
    own.engine = r->params.engine;
    own.sums = r->params.sums;
    return filter(&own, r, NULL);
}

static void bad_requests_are_refused(void **state)
{
    (void)state;
    for (size_t i = 0; i < 2 * WEFT_COUNT(refusals); i++) {
        const struct refusal *refusal = &refusals[i / 2];
        const struct where *where = &wheres[i % 2 ? first_cpu : 0];
        struct message message[2] = {{.count = 0}, {.count = 0}};
        struct weft_log log = {keep_message, &message[0]};
        struct weft_verify_report error;
        struct request *r = make_request("catmull-rom", 10, 10, 30, 20);
        r->params.engine = where->engine;
        r->params.log = r->run.log = &log;
        refusal->change(r);
        assert_int_equal(request_as_it_is(where, r), refusal->result);
        log.priv = &message[1];
        if (!refusal->run_only)
            assert_int_equal(verify(r, NULL, &error), refusal->result);
        for (int m = 0; m < (refusal->run_only ? 1 : 2); m++) {
            assert_int_equal(message[m].count, 1);
            if (!strstr(message[m].text, refusal->text))
                fail_msg("'%s' without '%s'", message[m].text, refusal->text);
        }
        free(r);
    }
}

// What a plan is compiled for must be what it was made for.
static void other_engines_are_refused(void **state)
{
    (void)state;
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    struct request *r = make_request("catmull-rom", 10, 10, 30, 20);
    r->params.log = &log;
    struct where cpu = wheres[first_cpu];
    int refused = 0;
    cpu.engine = WEFT_ENGINE_GL;
    assert_int_equal(filter(&cpu, r, NULL), WEFT_ERR_ARGUMENT);
    assert_int_equal(message.count, ++refused);
    cpu.engine = WEFT_ENGINE_CPU;
    cpu.compile.cpu.threads = -1;
    assert_int_equal(filter(&cpu, r, NULL), WEFT_ERR_ARGUMENT);
    assert_int_equal(message.count, ++refused);
    cpu.compile.cpu = (struct weft_cpu){.instructions = (enum weft_instruction_set)77};
    assert_int_equal(filter(&cpu, r, NULL), WEFT_ERR_ARGUMENT);
    assert_int_equal(message.count, ++refused);
    if (first_cpu > 0) {
        struct where gl = wheres[0];
        gl.engine = WEFT_ENGINE_CPU;
        assert_int_equal(filter(&gl, r, NULL), WEFT_ERR_ARGUMENT);
        assert_int_equal(message.count, ++refused);
    }
    free(r);
}

struct patience {
    int left;
    double last;
};

static bool lose_patience(void *priv, double fraction)
{
    struct patience *patience = priv;
    assert_true(fraction >= patience->last && fraction <= 1.0);
    patience->last = fraction;
    return patience->left-- > 0;
}

// One thread asks before each of its rectangles.
static void progress_cancels(struct where where)
{
    struct request *r = make_request("linear", 20, 20, 399, 399);
    struct weft_separable_report report;
    struct weft_verify_report error;
    r->params.memory_bytes = where.engine == WEFT_ENGINE_GL ? 20000 : 0;
    where.compile.cpu.threads = 1;
    assert_int_equal(filter(&where, r, &report), WEFT_OK);
    assert_true(report.rectangles > 3);
    for (int calls = 0; calls < report.rectangles; calls += 3) {
        struct patience patience = {calls, 0.0};
        const struct weft_progress progress = {lose_patience, &patience};
        r->run.progress = &progress;
        assert_int_equal(filter(&where, r, NULL), WEFT_ERR_CANCELLED);
    }
    struct patience patience = {report.rectangles, 0.0};
    const struct weft_progress progress = {lose_patience, &patience};
    r->run.progress = &progress;
    assert_int_equal(filter(&where, r, NULL), WEFT_OK);
    assert_true(patience.last == 1.0);
    patience = (struct patience){1, 0.0};
    assert_int_equal(verify(r, NULL, &error), WEFT_ERR_CANCELLED);
    free(r);
}

static void progress_can_cancel(void **state)
{
    (void)state;
    progress_cancels(wheres[0]);
    progress_cancels(wheres[first_cpu]);
}

// With little time, pixels that are spread over the image; with much, each once.
static void verifying_may_be_short(void **state)
{
    (void)state;
    struct weft_verify_report error;
    struct request *r = make_request("lanczos:8", 20, 20, 399, 301);
    assert_int_equal(filter(&wheres[0], r, NULL), WEFT_OK);
    assert_int_equal(verify(r, &(struct weft_verify_params){.max_seconds = 1e-9}, &error), WEFT_OK);
    assert_int_equal(error.pixels_total, 399 * 301);
    assert_in_range(error.pixels_checked, 1, 399 * 301 - 1);
    for (int i = 0; i < 10; i++) {
        const int at = (i * 12011 + 5) % (10 * 10);
        struct request *small = make_request("linear", 10, 10, 10, 10);
        assert_int_equal(filter(&wheres[0], small, NULL), WEFT_OK);
        small->pixels[at] += 1.0f;
        assert_int_equal(verify(small, NULL, &error), WEFT_OK);
        assert_int_equal(error.at_y * 10 + error.at_x, at);
        assert_near(error.maximum, 1.0, 1e-6, "an error of one");
        assert_near(error.rms, 0.1, 1e-6, "of one pixel in a hundred");
        free(small);
    }
    free(r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_kernel_meets_the_reference),
        cmocka_unit_test(every_shape_meets_the_reference),
        cmocka_unit_test(positions_may_be_anywhere),
        cmocka_unit_test(constants_stay),
        cmocka_unit_test(not_finite_samples_stay_where_they_count),
        cmocka_unit_test(whole_positions_give_the_samples),
        cmocka_unit_test(the_largest_floats_do_not_overflow),
        cmocka_unit_test(pixels_do_not_depend_on_the_cut),
        cmocka_unit_test(only_the_pixels_are_written),
        cmocka_unit_test(only_samples_in_reach_are_uploaded),
        cmocka_unit_test(runs_repeat_nothing_and_agree),
        cmocka_unit_test(bad_requests_are_refused),
        cmocka_unit_test(other_engines_are_refused),
        cmocka_unit_test(progress_can_cancel),
        cmocka_unit_test(verifying_may_be_short),
    };
    return cmocka_run_group_tests(tests, create_wheres, destroy_wheres);
}
