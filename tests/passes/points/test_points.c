// SPDX-License-Identifier: BSD-3-Clause
// Volumes at points: every output within its bound of the double reference, for dense, clamped and
// sparse volumes, plain and prefiltered kernels, both precisions of sums, and positions that are
// meant to be awkward; the same bytes whatever the threads, the order and the memory. Positions
// along polylines against lines, circles and helices.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "filter/analysis/reference.h"
#include "tests/support/common.h"
#include "tests/support/slice_jobs.h"

enum { MOST_POINTS = 20000 };

static double position[MOST_POINTS][3], other[MOST_POINTS][3];
static float out[WEFT_DERIVATIVES * MOST_POINTS], again[WEFT_DERIVATIVES * MOST_POINTS];

static const struct weft_derivative all[WEFT_DERIVATIVES] = {
    {{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}, {{2, 0, 0}},
    {{1, 1, 0}}, {{1, 0, 1}}, {{0, 2, 0}}, {{0, 1, 1}}, {{0, 0, 2}},
};

// As many of these as the kernel has.
static int derivatives_of(const struct weft_kernel *kernel)
{
    struct weft_kernel first, second;
    if (weft_kernel_derive(NULL, kernel, &first) != WEFT_OK)
        return 1;
    return weft_kernel_derive(NULL, &first, &second) == WEFT_OK ? WEFT_DERIVATIVES : 4;
}

// ---- volumes whose voxels the test knows --------------------------------------------------------

enum kind { CLAMPED, DENSE, SPARSE, KINDS };
static const char *const kind_names[] = {"clamped", "dense", "sparse"};
enum { SIZE = 21, BRICKS = 5 };

static const struct weft_volume_tile tiles[] = {{{16, 0, 0}, 8, 0.5f}, {{-128, 0, 0}, 128, -0.25f}};
static const int32_t origins[BRICKS][3] = {
    {0, 0, 0}, {8, 0, 0}, {0, 8, 0}, {8, 8, 8}, {-8, -8, -8}};

struct truth {
    enum kind kind;
    float data[SIZE * SIZE * SIZE], bricks[BRICKS * WEFT_BRICK_VOXELS], background;
};
static struct truth truth;

// In voxels of the volume: it is turned and stretched in world space.
static const double to_world[3][4] = {
    {0.4, 0.3, 0.0, -1.0}, {-0.3, 0.4, 0.0, 2.5}, {0, 0.1, 0.7, 3}};

static double voxel(void *priv, const int64_t index[3])
{
    const struct truth *t = priv;
    int64_t at[3];
    memcpy(at, index, sizeof at);
    if (t->kind == SPARSE) {
        for (int b = 0; b < BRICKS; b++) {
            int64_t in[3];
            for (int a = 0; a < 3; a++)
                in[a] = at[a] - origins[b][a];
            if ((uint64_t)in[0] < 8 && (uint64_t)in[1] < 8 && (uint64_t)in[2] < 8)
                return (double)t->bricks[b * WEFT_BRICK_VOXELS + in[0] + 8 * in[1] + 64 * in[2]];
        }
        for (size_t i = 0; i < WEFT_COUNT(tiles); i++) {
            bool inside = true;
            for (int a = 0; a < 3; a++)
                inside &= at[a] >= tiles[i].origin[a] && at[a] < tiles[i].origin[a] + tiles[i].size;
            if (inside)
                return (double)tiles[i].value;
        }
        return (double)t->background;
    }
    for (int a = 0; a < 3; a++) {
        if (t->kind == DENSE && (at[a] < 0 || at[a] >= SIZE))
            return (double)t->background;
        at[a] = at[a] < 0 ? 0 : at[a] >= SIZE ? SIZE - 1 : at[a];
    }
    return (double)t->data[(at[2] * SIZE + at[1]) * SIZE + at[0]];
}

static void fill(struct random *r, enum kind kind, bool wild)
{
    float *values = kind == SPARSE ? truth.bricks : truth.data;
    const size_t count = kind == SPARSE ? WEFT_COUNT(truth.bricks) : WEFT_COUNT(truth.data);
    truth.kind = kind;
    truth.background = kind == CLAMPED ? NAN : 0.125f;
    for (size_t i = 0; i < count; i++)
        values[i] = (float)(2.0 * uniform(r) - 1.0);
    static const float odd[] = {NAN, INFINITY, -INFINITY, 3e38f, -2e38f};
    for (int i = 0; wild && i < 12; i++)
        values[below(r, (int)count)] = odd[i % 5];
}

static weft_volume *make_volume(enum kind kind)
{
    weft_volume *volume = NULL;
    if (kind == SPARSE) {
        struct weft_volume_bricks_params p = {.brick_count = BRICKS,
                                              .brick_origin = origins,
                                              .brick_values = truth.bricks,
                                              .tile_count = WEFT_COUNT(tiles),
                                              .tiles = tiles,
                                              .background = truth.background};
        memcpy(p.index_to_world, to_world, sizeof to_world);
        assert_int_equal(weft_volume_create_bricks(&p, &volume), WEFT_OK);
        return volume;
    }
    struct weft_volume_params p = {
        .size = {SIZE, SIZE, SIZE}, .data = truth.data, .background = truth.background};
    memcpy(p.index_to_world, to_world, sizeof to_world);
    assert_int_equal(weft_volume_create(&p, &volume), WEFT_OK);
    return volume;
}

// ---- positions ----------------------------------------------------------------------------------

// Inside, on voxels, half-way, a little off both, at the edges, outside, and far outside.
static double awkward(struct random *r)
{
    static const double little[] = {0.0, 0x1p-29, -0x1p-29, 0x1p-26, -0x1p-26, 0x1p-40, -0x1p-40};
    const double any = 30.0 * uniform(r) - 5.0;
    switch (below(r, 7)) {
    case 0:
        return floor(any) + little[below(r, 7)];
    case 1:
        return floor(any) + 0.5 + little[below(r, 7)];
    case 2:
        return (below(r, 2) ? 0.0 : SIZE - 1.0) + little[below(r, 7)];
    case 3:
        return below(r, 2) ? any : 1000.0 * (uniform(r) - 0.5);
    case 4:
        return below(r, 8) ? any : (WEFT_INDEX_LIMIT - 64.0) * (below(r, 2) ? 1 : -1);
    default:
        return any;
    }
}

static double rounded(double x)
{
    const double whole = floor(x);
    return whole + floor((x - whole) * 0x1p29 + 0.5) * 0x1p-29;
}

static void set_positions(struct random *r, size_t count)
{
    for (size_t i = 0; i < count; i++)
        for (int a = 0; a < 3; a++)
            position[i][a] = awkward(r);
}

// ---- against the reference ----------------------------------------------------------------------

struct sampled {
    struct weft_points_info info;
    struct weft_points_report report;
};

static struct sampled sample(weft_volume *volume, const struct weft_points_params *params,
                             size_t count, const double (*at)[3], float *to)
{
    struct sampled s;
    weft_points *points = NULL;
    struct weft_points_params own = *params;
    own.volume = volume;
    own.log = &log_to_stderr;
    assert_int_equal(weft_points_create(&own, &points), WEFT_OK);
    s.info = *weft_points_get_info(points);
    assert_int_equal(weft_points_run(points,
                                     weft_points_run_params(.count = count, .position = at,
                                                            .out = to, .measure = true),
                                     &s.report),
                     WEFT_OK);
    weft_points_destroy(&points);
    return s;
}

// How many values were compared.
static int compare(const struct sampled *s, size_t count, const char *what)
{
    int compared = 0;
    for (int o = 0; o < s->info.output_count; o++) {
        struct weft_kernel kernel[3];
        const double bound = weft_bound_compute(&s->info.bound[o], &s->report.values).total;
        for (int a = 0; a < 3; a++) {
            kernel[a] = s->info.kernel;
            for (int n = 0; n < s->info.output[o].along[a]; n++)
                assert_int_equal(weft_kernel_derive(NULL, &kernel[a], &kernel[a]), WEFT_OK);
        }
        for (size_t i = 0; i < count; i++, compared++) {
            double at[3];
            for (int a = 0; a < 3; a++)
                at[a] = rounded(position[i][a]);
            const double exact = weft_reference_compute_axes(kernel, 3, at, voxel, &truth).value;
            const double is = (double)out[(size_t)o * count + i];
            const bool same =
                isnan(exact) ? isnan(is)
                : fabs(exact) > 3.5e38
                    ? (double)(float)exact == is
                    : fabs(is - exact) <= bound + 0x1p-23 * fabs(exact) * (bound > 1e30);
            if (!same)
                fail_msg("%s, kernel %s, d %d%d%d at (%.17g, %.17g, %.17g): %.9g, not %.9g, bound "
                         "%.3g",
                         what, s->info.kernel.info->name, s->info.output[o].along[0],
                         s->info.output[o].along[1], s->info.output[o].along[2], at[0], at[1],
                         at[2], is, exact, bound);
        }
    }
    return compared;
}

static void points_are_within_their_bound(void **state)
{
    static const char *const kernels[] = {"catmull-rom", "bspline3", "linear",
                                          "nearest",     "bspline2", "lanczos:3"};
    enum { COUNT = 150 };
    struct random r = {1};
    int compared = 0;
    uint64_t outside = 0;
    (void)state;
    for (size_t k = 0; k < WEFT_COUNT(kernels); k++) {
        for (int kind = 0; kind < KINDS; kind++) {
            fill(&r, (enum kind)kind, false);
            weft_volume *volume = make_volume((enum kind)kind);
            struct weft_points_params p = {
                .kernel = kernel_named(kernels[k]), .space = WEFT_SPACE_INDEX, .derivative = all};
            p.derivative_count = derivatives_of(&p.kernel);
            for (int sums = 0; sums < 2; sums++) {
                p.sums = (enum weft_sums)sums;
                set_positions(&r, COUNT);
                const struct sampled s = sample(volume, &p, COUNT, position, out);
                compared += compare(&s, COUNT, kind_names[kind]);
                outside += s.report.outside;
                assert_int_equal(s.report.bad_positions + s.report.not_finite, 0);
                assert_int_equal(s.report.exact_points, 0);
            }
            weft_volume_destroy(&volume);
        }
    }
    assert_true(outside > 0 && outside < 6 * 3 * 2 * COUNT);
    assert_int_equal(compared, (10 + 10 + 4 + 1 + 10 + 10) * 3 * 2 * COUNT);
}

// Taps of weight 0 do not count, others make their points what they are.
static void voxels_that_are_not_finite(void **state)
{
    enum { COUNT = 3000 };
    struct random r = {7};
    uint64_t exact = 0, not_finite = 0;
    (void)state;
    for (int kind = 0; kind < KINDS; kind++) {
        fill(&r, (enum kind)kind, true);
        weft_volume *volume = make_volume((enum kind)kind);
        const struct weft_points_params p = {
            .space = WEFT_SPACE_INDEX, .derivative = all, .derivative_count = WEFT_DERIVATIVES};
        set_positions(&r, COUNT);
        const struct sampled s = sample(volume, &p, COUNT, position, out);
        compare(&s, COUNT, kind_names[kind]);
        exact += s.report.exact_points;
        not_finite += s.report.not_finite;
        weft_volume_destroy(&volume);
    }
    assert_true(exact > 100 && exact < 3 * COUNT);
    assert_true(not_finite > 100);
}

// Against sums over the samples themselves.
static void prefiltered_kernels(void **state)
{
    enum { COUNT = 8 };
    struct random r = {3};
    static const char *const kernels[] = {"bspline3i", "bspline2i"};
    (void)state;
    for (size_t k = 0; k < WEFT_COUNT(kernels); k++) {
        fill(&r, k ? CLAMPED : DENSE, false);
        weft_volume *volume = make_volume(truth.kind);
        const struct weft_points_params p = {.kernel = kernel_named(kernels[k]),
                                             .space = WEFT_SPACE_INDEX,
                                             .derivative = all,
                                             .derivative_count = WEFT_DERIVATIVES};
        for (size_t i = 0; i < COUNT; i++)
            for (int a = 0; a < 3; a++)
                position[i][a] = i ? 24.0 * uniform(&r) - 2.0 : 5.0;
        const struct sampled s = sample(volume, &p, COUNT, position, out);
        struct weft_prefilter filter;
        assert_int_equal(weft_prefilter_compute(NULL, &p.kernel, &filter), WEFT_OK);
        const int overlap = weft_prefilter_overlap(&filter, 0x1p-32);
        for (int o = 0; o < WEFT_DERIVATIVES; o++) {
            const double bound = weft_bound_compute(&s.info.bound[o], &s.report.values).total;
            assert_true(bound < 1e-3);
            for (size_t i = 0; i < COUNT; i++) {
                double w[3][WEFT_PREFILTER_MAX_WEIGHTS], sum = 0.0;
                int64_t first[3], at[3];
                const int count = p.kernel.width + 2 * overlap;
                for (int a = 0; a < 3; a++) {
                    struct weft_kernel kernel = p.kernel;
                    for (int n = 0; n < all[o].along[a]; n++)
                        weft_kernel_derive(NULL, &kernel, &kernel);
                    first[a] =
                        weft_prefilter_weights(&filter, &kernel, overlap, position[i][a], w[a]);
                }
                for (int z = 0; z < count; z++)
                    for (int y = 0; y < count; y++)
                        for (int x = 0; x < count; x++) {
                            at[0] = first[0] + x;
                            at[1] = first[1] + y;
                            at[2] = first[2] + z;
                            sum += w[0][x] * w[1][y] * w[2][z] * voxel(&truth, at);
                        }
                assert_near((double)out[(size_t)o * COUNT + i], sum, bound, kernels[k]);
            }
        }
        // On a voxel the spline is the voxel.
        assert_near((double)out[0], voxel(&truth, (const int64_t[]){5, 5, 5}),
                    weft_bound_compute(&s.info.bound[0], &s.report.values).total, "voxel");
        weft_volume_destroy(&volume);
    }
}

// ---- the same bytes -----------------------------------------------------------------------------

static void bytes_do_not_depend_on_how(void **state)
{
    struct random r = {5};
    size_t order[MOST_POINTS];
    (void)state;
    fill(&r, SPARSE, true);
    weft_volume *volume = make_volume(SPARSE);
    struct weft_points_params p = {
        .space = WEFT_SPACE_INDEX, .derivative = all, .derivative_count = 4, .cpu.threads = 1};
    set_positions(&r, MOST_POINTS);
    position[77][1] = NAN;
    const struct sampled s = sample(volume, &p, MOST_POINTS, position, out);
    assert_int_equal(s.report.bad_positions, 1);
    assert_true(isnan(out[77]) && isnan(out[77 + 3 * MOST_POINTS]));
    for (int threads = 2; threads < 8; threads += 3) {
        p.cpu.threads = threads;
        memset(again, 0x55, sizeof again);
        sample(volume, &p, MOST_POINTS, position, again);
        assert_memory_equal(out, again, 4 * MOST_POINTS * sizeof *out);
    }
    // Another order, in little memory; and a few of them alone.
    for (size_t i = 0; i < MOST_POINTS; i++)
        order[i] = i;
    for (size_t i = MOST_POINTS - 1; i > 0; i--) {
        const size_t j = (size_t)below(&r, (int)i + 1), swap = order[i];
        order[i] = order[j];
        order[j] = swap;
    }
    for (size_t i = 0; i < MOST_POINTS; i++)
        memcpy(other[i], position[order[i]], sizeof other[i]);
    p.memory_bytes = 1 << 20;
    const struct sampled small = sample(volume, &p, MOST_POINTS, other, again);
    assert_true(small.report.peak_bytes <= 1 << 20);
    for (size_t o = 0; o < 4; o++)
        for (size_t i = 0; i < MOST_POINTS; i++)
            assert_memory_equal(&again[o * MOST_POINTS + i], &out[o * MOST_POINTS + order[i]],
                                sizeof *out);
    sample(volume, &p, 50, other, again);
    for (size_t o = 0; o < 4; o++)
        for (size_t i = 0; i < 50; i++)
            assert_memory_equal(&again[o * 50 + i], &out[o * MOST_POINTS + order[i]], sizeof *out);
    weft_volume_destroy(&volume);
}

// A slice's pixels are points.
static void slices_agree(void **state)
{
    struct random r = {11};
    int compared = 0;
    (void)state;
    for (int kind = 0; kind < KINDS; kind++) {
        fill(&r, (enum kind)kind, false);
        weft_volume *volume = make_volume((enum kind)kind);
        const struct weft_slice_geometry g = {
            .origin = {-4, 2, 3}, .u = {9, 6, 2}, .v = {1, -8, 12}, .width = 70, .height = 60};
        weft_slice_plan *plan = NULL;
        assert_int_equal(
            weft_slice_plan_create(
                volume, weft_slice_params(.geometry = g, .engine = WEFT_ENGINE_CPU), &plan),
            WEFT_OK);
        assert_int_equal(weft_slice_run_once(plan, weft_slice_compile_params(.cpu.threads = 1),
                                             weft_slice_run_params(.pixels = again), NULL),
                         WEFT_OK);
        const size_t count = (size_t)(g.width * g.height);
        for (int i = 0; i < g.width * g.height; i++)
            for (int a = 0; a < 3; a++)
                position[i][a] = g.origin[a] + (i % g.width + 0.5) * g.u[a] / g.width +
                                 (i / g.width + 0.5) * g.v[a] / g.height;
        const struct weft_points_params p = {.cpu.threads = 1};
        const struct sampled s = sample(volume, &p, count, position, out);
        const double bound =
            weft_bound_compute(&s.info.bound[0], &s.report.values).total +
            weft_bound_compute(&weft_slice_plan_get_info(plan)->output[0].bound, &s.report.values)
                .total;
        for (size_t i = 0; i < count; i++, compared++)
            assert_near((double)out[i], (double)again[i], bound, kind_names[kind]);
        weft_slice_plan_destroy(&plan);
        weft_volume_destroy(&volume);
    }
    assert_int_equal(compared, 3 * 70 * 60);
}

// ---- refusals -----------------------------------------------------------------------------------

static void bad_requests(void **state)
{
    struct random r = {2};
    struct message last = {.count = 0};
    const struct weft_log log = {keep_message, &last};
    weft_points *points = NULL;
    (void)state;
    fill(&r, DENSE, false);
    weft_volume *volume = make_volume(DENSE);
    static const struct weft_derivative third = {{1, 1, 1}}, second = {{2, 0, 0}};
    const struct {
        struct weft_points_params params;
        enum weft_result expected;
        const char *text;
    } cases[] = {
        {{.derivative = &third, .derivative_count = 1}, WEFT_ERR_ARGUMENT, "(1, 1, 1) times"},
        {{.derivative = &second, .derivative_count = 11}, WEFT_ERR_ARGUMENT, "0 to 10"},
        {{.derivative_count = 1}, WEFT_ERR_ARGUMENT, "0 to 10"},
        {{.derivative = &second, .derivative_count = 1, .kernel = kernel_named("linear")},
         WEFT_ERR_UNSUPPORTED,
         "kernel linear has no second derivative"},
        {{.derivative = &second, .derivative_count = 1, .kernel = kernel_named("lanczos:3+unit")},
         WEFT_ERR_UNSUPPORTED,
         "divided by their sum"},
        {{.kernel = kernel_named("linear+radial")}, WEFT_ERR_UNSUPPORTED, "radial"},
        {{.memory_bytes = 1000}, WEFT_ERR_LIMIT, "1000 bytes"},
        {{.space = (enum weft_space)7}, WEFT_ERR_ARGUMENT, "space"},
        {{.sums = (enum weft_sums)7}, WEFT_ERR_ARGUMENT, "sums"},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct weft_points_params p = cases[i].params;
        p.volume = volume;
        p.log = &log;
        assert_int_equal(weft_points_create(&p, &points), cases[i].expected);
        assert_null(points);
        assert_non_null(strstr(last.text, cases[i].text));
    }
    assert_int_equal(weft_points_create(weft_points_params(.volume = volume, .log = &log), &points),
                     WEFT_OK);
    struct weft_points_report report;
    assert_int_equal(weft_points_run(points, weft_points_run_params(.count = 0), &report), WEFT_OK);
    assert_int_equal(weft_points_run(points, weft_points_run_params(.count = 1), NULL),
                     WEFT_ERR_ARGUMENT);
    assert_int_equal(weft_points_run(points,
                                     weft_points_run_params(.count = 2, .position = position,
                                                            .out = out, .stride = 1),
                                     NULL),
                     WEFT_ERR_ARGUMENT);
    // All of them without a position.
    for (int i = 0; i < 3; i++)
        for (int a = 0; a < 3; a++)
            position[i][a] = i == 0 ? (double)NAN : i == 1 ? (double)INFINITY : -1e300;
    assert_int_equal(
        weft_points_run(
            points, weft_points_run_params(.count = 3, .position = position, .out = out), &report),
        WEFT_OK);
    assert_int_equal(report.bad_positions, 3);
    assert_true(isnan(out[0]) && isnan(out[1]) && isnan(out[2]));
    weft_points_destroy(&points);
    weft_volume_destroy(&volume);
}

// ---- polylines ----------------------------------------------------------------------------------

enum { WIDTH = 60, HEIGHT = 11, CURVE = 400 };
static double curve[CURVE + 1][3], straightened[WIDTH * HEIGHT][3];

static double distance(const double a[3], const double b[3])
{
    return hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]);
}

static void straighten(const struct weft_polyline *line)
{
    assert_int_equal(weft_polyline_positions(&log_to_stderr, line, WIDTH, HEIGHT, straightened),
                     WEFT_OK);
}

static void straight_lines_and_corners(void **state)
{
    static const double points[][3] = {{1, 2, 3}, {5, 2, 3}, {5, 8, 3}};
    struct weft_polyline line = {.count = 2, .point = points, .across = 2.0, .up = {7, 0, -1}};
    (void)state;
    assert_near(weft_polyline_length(&line), 4.0, 0.0, "length");
    straighten(&line);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            const double expected[3] = {1 + (x + 0.5) / WIDTH * 4, 2,
                                        3 - ((y + 0.5) / HEIGHT - 0.5) * 2};
            assert_near(distance(straightened[y * WIDTH + x], expected), 0.0, 1e-12, "straight");
        }
    // In the plane of a corner: the middle row is the line, and the direction stays in the plane.
    line = (struct weft_polyline){.count = 3, .point = points, .across = 1.0, .up = {0, 1, 0}};
    assert_near(weft_polyline_length(&line), 10.0, 0.0, "length");
    straighten(&line);
    for (int x = 0; x < WIDTH; x++) {
        const double at = (x + 0.5) / WIDTH * 10, *middle = straightened[HEIGHT / 2 * WIDTH + x];
        const double expected[3] = {at < 4 ? 1 + at : 5, at < 4 ? 2 : at - 2, 3};
        assert_near(distance(middle, expected), 0.0, 1e-12, "corner");
        for (int y = 0; y < HEIGHT; y++)
            assert_near(straightened[y * WIDTH + x][2], 3.0, 1e-12, "plane");
    }
    // From the left of the first segment to the left of the second one.
    assert_true(straightened[(HEIGHT - 1) * WIDTH][1] > 2.4);
    assert_true(straightened[HEIGHT * WIDTH - 1][0] < 4.6);
    // Straight back, and on.
    static const double back[][3] = {{0, 0, 0}, {1, 0, 0}, {0, 0, 0}, {2, 0, 0}};
    line = (struct weft_polyline){.count = 4, .point = back, .across = 1.0};
    straighten(&line);
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        assert_true(isfinite(straightened[i][0] + straightened[i][1] + straightened[i][2]));
}

// Directions square to the line, of length 1, which turn no more than they have to: around a helix
// by the torsion, c / (a^2 + c^2) a length, against the curve's own normal.
static void helices_and_circles(void **state)
{
    const double a = 3.0, c = 0.5, turns = 2.0, step = 2 * M_PI * turns / CURVE;
    const double speed = hypot(a, c);
    (void)state;
    for (int i = 0; i <= CURVE; i++) {
        curve[i][0] = a * cos(i * step);
        curve[i][1] = a * sin(i * step);
        curve[i][2] = c * i * step;
    }
    struct weft_polyline line = {
        .count = CURVE + 1, .point = curve, .across = 1.0, .up = {1, 0, 0}};
    assert_near(weft_polyline_length(&line), speed * 2 * M_PI * turns, 3e-3, "helix");
    straighten(&line);
    for (int x = 0; x < WIDTH; x++) {
        const double t = (x + 0.5) / WIDTH * 2 * M_PI * turns;
        const double *low = straightened[x], *high = straightened[(HEIGHT - 1) * WIDTH + x];
        double d[3], along = 0.0, normal = 0.0, binormal = 0.0;
        const double tangent[3] = {-a * sin(t) / speed, a * cos(t) / speed, c / speed};
        const double inward[3] = {-cos(t), -sin(t), 0};
        const double second[3] = {c * sin(t) / speed, -c * cos(t) / speed, a / speed};
        for (int i = 0; i < 3; i++) {
            d[i] = (high[i] - low[i]) / (1.0 - 1.0 / HEIGHT);
            along += d[i] * tangent[i];
            normal += d[i] * inward[i];
            binormal += d[i] * second[i];
        }
        assert_near(along, 0.0, 0.02, "square");
        assert_near(hypot(normal, binormal), 1.0, 1e-3, "length");
        // It began outward: at angle pi from inward, from which the torsion turns the frame.
        const double turned = M_PI - c / speed / speed * t * speed;
        assert_near(normal, cos(turned), 0.02, "normal");
        assert_near(binormal, sin(turned), 0.02, "binormal");
    }
    // A closed circle: the frame comes back as it was, the plane's normal as it is.
    for (int i = 0; i <= CURVE; i++) {
        curve[i][0] = a * cos(2 * M_PI * i / CURVE);
        curve[i][1] = a * sin(2 * M_PI * i / CURVE);
        curve[i][2] = 0.0;
    }
    memcpy(curve[CURVE], curve[0], sizeof curve[0]);
    line.up[0] = 0.0;
    line.up[2] = 1.0;
    straighten(&line);
    for (int x = 0; x < WIDTH; x++)
        assert_near(straightened[x][2], -0.5 * (1.0 - 1.0 / HEIGHT), 1e-9, "circle");
}

static void bad_polylines(void **state)
{
    static const double same[][3] = {{1, 1, 1}, {1, 1, 1}}, nan[][3] = {{0, 0, 0}, {NAN, 1, 1}};
    static const double far[][3] = {{-1e308, 0, 0}, {1e308, 0, 0}},
                        fine[][3] = {{0, 0, 0}, {1, 0, 0}};
    const struct weft_polyline lines[] = {
        {.count = 1, .point = fine, .across = 1},
        {.count = 2, .point = same, .across = 1},
        {.count = 2, .point = nan, .across = 1},
        {.count = 2, .point = far, .across = 1},
        {.count = 2, .point = fine, .across = 0},
        {.count = 2, .point = fine, .across = NAN},
        {.count = 2, .point = fine, .across = 1, .up = {-3, 0, 0}},
        {.count = 2, .point = fine, .across = 1, .up = {NAN, 0, 0}},
    };
    const struct weft_polyline good = {.count = 2, .point = fine, .across = 1};
    struct message last = {.count = 0};
    const struct weft_log log = {keep_message, &last};
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(lines); i++) {
        assert_int_equal(weft_polyline_positions(&log, &lines[i], 4, 4, straightened),
                         WEFT_ERR_ARGUMENT);
        assert_int_equal(last.count, (int)i + 1);
        assert_int_equal(isnan(weft_polyline_length(&lines[i])), i < 4);
    }
    assert_int_equal(weft_polyline_positions(&log, &good, 0, 4, straightened), WEFT_ERR_ARGUMENT);
    assert_int_equal(weft_polyline_positions(&log, &good, 1 << 20, 1 << 20, straightened),
                     WEFT_ERR_ARGUMENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_are_within_their_bound),
        cmocka_unit_test(voxels_that_are_not_finite),
        cmocka_unit_test(prefiltered_kernels),
        cmocka_unit_test(bytes_do_not_depend_on_how),
        cmocka_unit_test(slices_agree),
        cmocka_unit_test(bad_requests),
        cmocka_unit_test(straight_lines_and_corners),
        cmocka_unit_test(helices_and_circles),
        cmocka_unit_test(bad_polylines),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
