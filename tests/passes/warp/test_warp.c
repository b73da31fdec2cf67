// SPDX-License-Identifier: BSD-3-Clause
// passes/warp/warp.h: every engine beside the double reference, what must be exact, and what is
// refused.
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
#include "tests/support/contexts.h"
#include "weft.h"

// ---- pictures -----------------------------------------------------------------------------------

enum { CHANNELS = WEFT_RESAMPLE_MAX_CHANNELS };

struct picture {
    int width, height, channels;
    float *plane[CHANNELS];
};

static struct picture make_picture(int width, int height, int channels)
{
    struct picture p = {width, height, channels, {NULL}};
    for (int c = 0; c < channels; c++)
        p.plane[c] = calloc((size_t)width * (size_t)height, sizeof(float));
    return p;
}

static void clear_picture(struct picture *p)
{
    for (int c = 0; c < p->channels; c++)
        free(p->plane[c]);
}

// A repeatable value in [-1, 1] for every number.
static double noise(uint32_t i)
{
    uint32_t h = i * 73856093u + 1u;
    h = (h ^ h >> 16) * 0x7feb352du;
    h = (h ^ h >> 15) * 0x846ca68bu;
    return (double)(h ^ h >> 16) / 2147483647.5 - 1.0;
}

static struct picture make_samples(int width, int height, int channels)
{
    struct picture p = make_picture(width, height, channels);
    for (int c = 0; c < channels; c++)
        for (int i = 0; i < width * height; i++)
            p.plane[c][i] = (float)(3.0 * noise((uint32_t)(c * 8209 * 4099 + i)) + c);
    return p;
}

// ---- requests -----------------------------------------------------------------------------------

struct how {
    enum weft_engine engine;
    enum weft_sums sums;
    struct weft_cpu cpu;
    struct weft_rectangle part;
};

static weft_resample_source *make_source(const struct weft_warp_info *info, const struct picture *p,
                                         double border)
{
    weft_resample_source *source;
    struct weft_resample_source_params params =
        *weft_resample_source_params(.kernel = info->kernel, .width = p->width, .height = p->height,
                                     .channels = p->channels, .boundary = info->boundary,
                                     .border = border);
    for (int c = 0; c < p->channels; c++)
        params.plane[c] = p->plane[c];
    assert_int_equal(weft_resample_source_create(&params, &source), WEFT_OK);
    return source;
}

struct ready {
    weft_warp_plan *plan;
    weft_warp_compiled *compiled;
};

static struct ready make_ready(const struct weft_warp_params *params, const struct how *how)
{
    struct weft_warp_params p = *params;
    struct ready ready;
    p.engine = how->engine;
    p.sums = how->sums;
    p.log = &log_to_stderr;
    assert_int_equal(weft_warp_plan_create(&p, &ready.plan), WEFT_OK);
    const struct weft_resample_compile_params compile = {
        .context = how->engine == WEFT_ENGINE_GL ? contexts[0] : NULL, .cpu = how->cpu};
    assert_int_equal(weft_warp_compile(ready.plan, &compile, &ready.compiled), WEFT_OK);
    return ready;
}

static void clear_ready(struct ready *ready)
{
    weft_warp_compiled_destroy(&ready->compiled);
    weft_warp_plan_destroy(&ready->plan);
}

// Makes the picture *out. error may be NULL.
static void run_ready(const struct ready *ready, const struct weft_rectangle *part,
                      const struct picture *in, struct picture *out,
                      struct weft_verify_report *error)
{
    const struct weft_warp_info *info = weft_warp_plan_get_info(ready->plan);
    weft_resample_source *source = make_source(info, in, 0.75);
    *out = part->width ? make_picture(part->width, part->height, in->channels)
                       : make_picture(info->width, info->height, in->channels);
    struct weft_warp_run_params run = {.source = source, .part = *part};
    struct weft_resample_verify_params verify = {.source = source, .part = *part};
    for (int c = 0; c < in->channels; c++)
        verify.plane[c] = run.plane[c] = out->plane[c];
    verify.how.max_seconds = INFINITY;
    struct weft_resample_report report;
    assert_int_equal(weft_warp_run(ready->compiled, &run, &report), WEFT_OK);
    if (error)
        assert_int_equal(weft_warp_verify(ready->plan, &verify, error), WEFT_OK);
    weft_resample_source_destroy(&source);
}

static struct weft_verify_report warp(const struct weft_warp_params *params, const struct how *how,
                                      const struct picture *in, struct picture *out)
{
    struct weft_verify_report error;
    struct ready ready = make_ready(params, how);
    run_ready(&ready, &how->part, in, out, &error);
    clear_ready(&ready);
    return error;
}

static struct weft_warp_params request(const char *kernel, const struct picture *in)
{
    return *weft_warp_params(.kernel = kernel_named(kernel), .size = {in->width, in->height});
}

static void rotate(struct weft_warp_params *p, double degrees)
{
    const double centre[2] = {0.5 * p->size[0], 0.5 * p->size[1]};
    weft_warp_matrix_rotate(degrees, centre, p->map.matrix);
}

// ---- maps ---------------------------------------------------------------------------------------

static void apply(const double m[9], double x, double y, double out[2])
{
    const double w = m[6] * x + m[7] * y + m[8];
    out[0] = (m[0] * x + m[1] * y + m[2]) / w;
    out[1] = (m[3] * x + m[4] * y + m[5]) / w;
}

static void test_matrices(void **state)
{
    (void)state;
    double m[9], at[2];
    // SVG's matrix(a, b, c, d, e, f).
    weft_warp_matrix_affine((const double[]){2.0, 3.0, 5.0, 7.0, 11.0, 13.0}, m);
    apply(m, 1.0, 10.0, at);
    assert_true(at[0] == 2.0 + 50.0 + 11.0 && at[1] == 3.0 + 70.0 + 13.0);
    // What is to the right of the centre goes to the top: counter-clockwise with row 0 on top.
    const double centre[2] = {3.0, 4.0};
    weft_warp_matrix_rotate(90.0, centre, m);
    apply(m, 5.0, 4.0, at);
    assert_true(at[0] == 3.0 && at[1] == 2.0);
    weft_warp_matrix_rotate(-270.0, centre, m);
    apply(m, 5.0, 4.0, at);
    assert_true(at[0] == 3.0 && at[1] == 2.0);
    weft_warp_matrix_rotate(30.0, centre, m);
    apply(m, 5.0, 4.0, at);
    assert_true(fabs(at[0] - (3.0 + sqrt(3.0))) < 1e-15 && fabs(at[1] - 3.0) < 1e-15);
}

// A perspective in which scales differ, with a horizon outside.
static const double tilted[9] = {1.1, 0.2, -3.0, 0.1, 0.9, 1.0, 0.004, 0.011, 1.0};

enum { WIDTH = 41, HEIGHT = 33 };

// Waves that stay near their pixels, fold over in places and leave the samples.
static float *make_waves(int axis, double by)
{
    float *out = malloc(WIDTH * HEIGHT * sizeof *out);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            out[y * WIDTH + x] =
                (float)((axis ? y : x) + 0.5 + by * sin(0.35 * x + 0.2 * y + axis));
    return out;
}

static void test_positions(void **state)
{
    (void)state;
    const struct picture in = {37, 29, 1, {NULL}};
    struct weft_warp_params p = request("catmull-rom", &in);
    p.width = WIDTH;
    p.height = HEIGHT;
    memcpy(p.map.matrix, tilted, sizeof tilted);
    p.map.source_corner[0] = -4.0;
    p.map.result_corner[1] = 7.0;
    weft_warp_plan *plan;
    assert_int_equal(weft_warp_plan_create(&p, &plan), WEFT_OK);
    const struct weft_warp_info *info = weft_warp_plan_get_info(plan);
    assert_int_equal(info->method, WEFT_WARP_PROJECTIVE);
    int checked = 0;
    for (int y = 0; y < HEIGHT; y += 4)
        for (int x = 0; x < WIDTH; x += 5, checked++) {
            // The matrix takes what a pixel shows to its centre.
            double at[2], scale[2], back[2], next[2][2], unused[2];
            weft_warp_position(plan, x, y, at, scale);
            apply(tilted, at[0] + 0.5 - 4.0, at[1] + 0.5, back);
            assert_true(fabs(back[0] - (x + 0.5)) < 1e-10);
            assert_true(fabs(back[1] - (y + 7.5)) < 1e-10);
            if (x + 1 >= WIDTH || y + 1 >= HEIGHT || x == 0 || y == 0)
                continue;
            for (int a = 0; a < 2; a++) {
                double high[2], low[2];
                for (int d = 0; d < 2; d++) {
                    weft_warp_position(plan, x + (d == 0), y + (d == 1), high, unused);
                    weft_warp_position(plan, x - (d == 0), y - (d == 1), low, unused);
                    next[a][d] = 0.5 * (high[a] - low[a]);
                }
                const double own = hypot(next[a][0], next[a][1]);
                // Differences are derivatives to within the third ones.
                assert_true(fabs(fmax(own, 1.0) - scale[a]) < 0.01 * own);
                assert_true(scale[a] <= info->scale[a]);
            }
        }
    assert_true(checked > 50);
    weft_warp_plan_destroy(&plan);
}

// ---- the bound ----------------------------------------------------------------------------------

struct map {
    const char *name;
    double degrees, scale; // about the centre
    const double *matrix;
    double waves;
};
static const struct map maps[] = {
    {"15 degrees", 15.0, 1.0, NULL, 0.0},
    {"turned and larger", -100.0, 1.7, NULL, 0.0},
    {"turned and smaller", 33.0, 0.27, NULL, 0.0},
    {"tilted", 0.0, 1.0, tilted, 0.0},
    {"waves", 0.0, 1.0, NULL, 1.5},
    {"high waves", 0.0, 1.0, NULL, 9.0},
    {"on its side and smaller", 90.0, 0.4, NULL, 0.0},
};

static void set_map(const struct map *map, struct weft_warp_params *p, float *planes[2])
{
    p->width = WIDTH;
    p->height = HEIGHT;
    if (map->matrix)
        memcpy(p->map.matrix, map->matrix, 9 * sizeof(double));
    else
        rotate(p, map->degrees);
    for (int i = 0; !map->matrix && i < 6; i++)
        p->map.matrix[i] *= map->scale;
    for (int a = 0; map->waves > 0.0 && a < 2; a++) {
        p->map.kind = WEFT_WARP_POSITIONS;
        p->map.position[a] = planes[a] = make_waves(a, map->waves);
    }
}

static void assert_within(const struct weft_verify_report *error, const char *what)
{
    if (error->not_finite_mismatches || !(error->maximum <= error->bound))
        fail_msg("%s: %g at (%d, %d) of channel %d, %.9g beside %.9g, over %g; %llu mismatches",
                 what, error->maximum, error->at_x, error->at_y, error->at_channel, error->at_value,
                 error->at_reference, error->bound,
                 (unsigned long long)error->not_finite_mismatches);
    // A bound that says nothing would hold, too.
    assert_true(error->bound < 1e-4 * error->magnitude);
}

// OpenGL, and one way of the CPU's, another one each time.
static int check_engines(const struct weft_warp_params *p, const struct picture *in,
                         const char *what, int number)
{
    struct how hows[6] = {{.engine = WEFT_ENGINE_GL},
                          {.engine = WEFT_ENGINE_CPU, .sums = WEFT_SUMS_DOUBLE}};
    int count = 2, compared = 0;
    for (int set = WEFT_INSTRUCTIONS_PLAIN; set <= WEFT_INSTRUCTIONS_AVX512; set++)
        if (weft_instruction_set_runs((enum weft_instruction_set)set))
            hows[count++] = (struct how){.engine = WEFT_ENGINE_CPU,
                                         .cpu = {.instructions = (enum weft_instruction_set)set}};
    for (int i = WITHOUT_GL; i < 2; i++, compared++) {
        const int which = i == 0 ? 0 : 1 + number % (count - 1);
        struct picture out;
        char name[200];
        const struct weft_verify_report error = warp(p, &hows[which], in, &out);
        snprintf(name, sizeof name, "%s, engine %d", what, which);
        assert_within(&error, name);
        assert_int_equal(error.values_compared, WIDTH * HEIGHT * in->channels);
        clear_picture(&out);
    }
    return compared;
}

static void test_within_bound(void **state)
{
    (void)state;
    static const char *const kernels[] = {"nearest",   "linear",          "catmull-rom", "mitchell",
                                          "lanczos:3", "lanczos:2+unit",  "bspline3i",   "area",
                                          "bspline7",  "blackman-sinc:4", NULL};
    int runs = 0, number = 0;
    for (int k = 0; kernels[k]; k++)
        for (size_t m = 0; m < WEFT_COUNT(maps); m++) {
            const struct picture in = make_samples(37, 29, 1 + number % 4);
            struct weft_warp_params p = request(kernels[k], &in);
            float *planes[2] = {NULL, NULL};
            char what[128];
            const bool prefiltered = p.kernel.prefiltered;
            set_map(&maps[m], &p, planes);
            p.boundary = prefiltered ? WEFT_BOUNDARY_CLAMP
                                     : (enum weft_boundary)(number % WEFT_BOUNDARY_COUNT);
            p.unstretched = prefiltered;
            p.clamp = number % 5 == 0;
            snprintf(what, sizeof what, "%s, %s, %s", kernels[k], maps[m].name,
                     weft_boundary_names[p.boundary]);
            runs += check_engines(&p, &in, what, ++number);
            for (int a = 0; a < 2; a++)
                free(planes[a]);
            struct picture gone = in;
            clear_picture(&gone);
        }
    assert_int_equal(runs, 10 * (int)WEFT_COUNT(maps) * (WITHOUT_GL ? 1 : 2));
}

// ---- exact results ------------------------------------------------------------------------------

// Quarter turns, flips and whole translations of samples, by every kernel that interpolates.
static void check_moved(const struct weft_warp_params *p, const struct how *how,
                        const struct picture *in, int (*index)(int x, int y))
{
    struct picture out;
    const struct weft_verify_report error = warp(p, how, in, &out);
    assert_true(error.maximum == 0.0 && error.not_finite_mismatches == 0);
    int moved = 0;
    for (int c = 0; c < in->channels; c++)
        for (int y = 0; y < out.height; y++)
            for (int x = 0; x < out.width; x++) {
                const int at = index(x, y);
                if (at < 0)
                    continue;
                moved++;
                assert_memory_equal(&out.plane[c][y * out.width + x], &in->plane[c][at],
                                    sizeof(float));
            }
    assert_true(moved > 200);
    clear_picture(&out);
}

enum { SIDE = 24 };

static int same(int x, int y)
{
    return y * SIDE + x;
}
static int quarter(int x, int y) // counter-clockwise: the right column becomes the first row
{
    return x * SIDE + (SIDE - 1 - y);
}
static int half(int x, int y)
{
    return (SIDE - 1 - y) * SIDE + (SIDE - 1 - x);
}
static int three_quarters(int x, int y)
{
    return (SIDE - 1 - x) * SIDE + y;
}
static int wrapped(int x, int y)
{
    return (y + SIDE - 2) % SIDE * SIDE + (x + 5) % SIDE;
}

static void test_exact(void **state)
{
    (void)state;
    static const char *const kernels[] = {"nearest", "linear", "catmull-rom", "lanczos:3", NULL};
    int (*const turned[])(int, int) = {same, quarter, half, three_quarters};
    struct picture in = make_samples(SIDE, SIDE, 3);
    for (int k = 0; kernels[k]; k++)
        for (int e = WITHOUT_GL; e < 2; e++) {
            const struct how how = {.engine = (enum weft_engine)e};
            struct weft_warp_params p = request(kernels[k], &in);
            for (int quarters = 0; quarters < 4; quarters++) {
                rotate(&p, 90.0 * quarters);
                check_moved(&p, &how, &in, turned[quarters]);
            }
            weft_warp_matrix_affine((const double[]){1.0, 0.0, 0.0, 1.0, -5.0, 2.0}, p.map.matrix);
            p.boundary = WEFT_BOUNDARY_WRAP;
            check_moved(&p, &how, &in, wrapped);
        }
    clear_picture(&in);
}

// Any part, with any number of threads, has the whole's bytes.
static void test_parts(void **state)
{
    (void)state;
    const struct picture in = make_samples(37, 29, 3);
    int parts = 0;
    for (size_t m = 0; m < WEFT_COUNT(maps); m++)
        for (int e = WITHOUT_GL; e < 2; e++) {
            struct weft_warp_params p = request("mitchell", &in);
            float *planes[2] = {NULL, NULL};
            struct picture whole, part;
            struct how how = {.engine = (enum weft_engine)e, .cpu = {.threads = e ? 3 : 0}};
            set_map(&maps[m], &p, planes);
            warp(&p, &how, &in, &whole);
            how.part = (struct weft_rectangle){7, 5, 23, 21};
            how.cpu.threads = e ? 1 : 0;
            p.memory_bytes = 20000; // few samples at once, and few pixels
            warp(&p, &how, &in, &part);
            for (int c = 0; c < 3; c++)
                for (int y = 0; y < 21; y++, parts++)
                    assert_memory_equal(part.plane[c] + y * 23,
                                        whole.plane[c] + (y + 5) * WIDTH + 7, 23 * sizeof(float));
            clear_picture(&whole);
            clear_picture(&part);
            free(planes[0]);
            free(planes[1]);
        }
    assert_true(parts >= (int)WEFT_COUNT(maps) * 63);
    struct picture gone = in;
    clear_picture(&gone);
}

// ---- axes that follow axes ----------------------------------------------------------------------

// a to f of matrices of which each axis goes along one, and one of which none does.
static const struct {
    double of[6];
    enum weft_warp_method method;
} straight[] = {
    {{0.0, 0.37, -0.61, 0.0, 21.0, 2.5}, WEFT_WARP_ALIGNED},
    {{0.0, 1.3, 1.7, 0.0, -3.25, 0.0}, WEFT_WARP_ALIGNED},
    {{-1.1, 0.0, 0.0, 0.45, 40.0, 1.125}, WEFT_WARP_ALIGNED},
    {{1.0, 0.0, 0.0, -1.0, 0.4, 30.3}, WEFT_WARP_ALIGNED},
    {{1.0, 0.0, 1e-9, 1.0, 0.0, 0.0}, WEFT_WARP_AFFINE},
};

// Whole and in a part whose columns are turned back in bands.
static void check_straight(const struct weft_warp_params *p, enum weft_engine engine,
                           const struct picture *in, enum weft_warp_method method)
{
    struct weft_warp_params few = *p;
    struct how how = {.engine = engine};
    struct picture whole, part;
    struct weft_verify_report error;
    struct ready ready = make_ready(p, &how);
    assert_int_equal(weft_warp_plan_get_info(ready.plan)->method, method);
    run_ready(&ready, &how.part, in, &whole, &error);
    clear_ready(&ready);
    assert_within(&error, p->kernel.info->name);
    how.part = (struct weft_rectangle){7, 5, 23, 21};
    few.memory_bytes = 9000; // a band of 17 columns, or fewer
    ready = make_ready(&few, &how);
    run_ready(&ready, &how.part, in, &part, NULL);
    clear_ready(&ready);
    for (int c = 0; c < in->channels; c++)
        for (int y = 0; y < 21; y++)
            assert_memory_equal(part.plane[c] + y * 23, whole.plane[c] + (y + 5) * WIDTH + 7,
                                23 * sizeof(float));
    clear_picture(&whole);
    clear_picture(&part);
}

static void test_aligned(void **state)
{
    (void)state;
    static const char *const kernels[] = {"nearest", "catmull-rom", "area", "bspline5i", NULL};
    struct picture in = make_samples(37, 29, 2);
    int runs = 0;
    for (int k = 0; kernels[k]; k++)
        for (size_t m = 0; m < WEFT_COUNT(straight); m++)
            for (int e = WITHOUT_GL; e < 2; e++, runs++) {
                struct weft_warp_params p = request(kernels[k], &in);
                weft_warp_matrix_affine(straight[m].of, p.map.matrix);
                p.width = WIDTH;
                p.height = HEIGHT;
                p.unstretched = p.kernel.prefiltered;
                p.boundary = p.kernel.prefiltered ? WEFT_BOUNDARY_CLAMP
                                                  : (enum weft_boundary)(m % WEFT_BOUNDARY_COUNT);
                p.clamp = m == 1;
                check_straight(&p, (enum weft_engine)e, &in, straight[m].method);
            }
    assert_int_equal(runs, 20 * (WITHOUT_GL ? 1 : 2));
    clear_picture(&in);
}

static void resample(const struct weft_warp_params *like, const struct picture *in,
                     struct picture *out)
{
    weft_resample_plan *plan;
    weft_resample_compiled *compiled;
    const struct weft_warp_info info = {.kernel = like->kernel, .boundary = like->boundary};
    weft_resample_source *source = make_source(&info, in, 0.75);
    const struct weft_resample_params params =
        *weft_resample_params(.kernel = like->kernel, .size = {in->width, in->height},
                              .width = like->width, .height = like->height,
                              .boundary = like->boundary, .engine = WEFT_ENGINE_CPU);
    struct weft_resample_run_params run = {.source = source};
    *out = make_picture(like->width, like->height, in->channels);
    for (int c = 0; c < in->channels; c++)
        run.plane[c] = out->plane[c];
    assert_int_equal(weft_resample_plan_create(&params, &plan), WEFT_OK);
    assert_int_equal(weft_resample_compile(plan, weft_resample_compile_params(), &compiled),
                     WEFT_OK);
    assert_int_equal(weft_resample_run(compiled, &run, NULL), WEFT_OK);
    weft_resample_compiled_destroy(&compiled);
    weft_resample_plan_destroy(&plan);
    weft_resample_source_destroy(&source);
}

// A change of size about the corner, by powers of 2, which leave positions without roundings.
static void test_as_resampled(void **state)
{
    (void)state;
    static const char *const kernels[] = {"lanczos:3", "mitchell", "area", "bspline3i", NULL};
    struct picture in = make_samples(40, 28, 3);
    int compared = 0;
    for (int k = 0; kernels[k]; k++)
        for (int bits = -2; bits <= 2; bits++) {
            struct weft_warp_params p = request(kernels[k], &in);
            struct picture warped, resampled;
            if (p.kernel.prefiltered && bits < 0)
                continue; // both refuse
            const double scale = ldexp(1.0, bits);
            weft_warp_matrix_affine((const double[]){scale, 0.0, 0.0, scale, 0.0, 0.0},
                                    p.map.matrix);
            p.width = (int)(40.0 * scale);
            p.height = (int)(28.0 * scale);
            p.boundary = p.kernel.prefiltered ? WEFT_BOUNDARY_CLAMP : WEFT_BOUNDARY_MIRROR;
            const struct how how = {.engine = WEFT_ENGINE_CPU};
            struct ready ready = make_ready(&p, &how);
            run_ready(&ready, &how.part, &in, &warped, NULL);
            clear_ready(&ready);
            resample(&p, &in, &resampled);
            for (int c = 0; c < 3; c++, compared++)
                assert_memory_equal(warped.plane[c], resampled.plane[c],
                                    (size_t)(p.width * p.height) * sizeof(float));
            clear_picture(&warped);
            clear_picture(&resampled);
        }
    assert_int_equal(compared, 3 * (3 * 5 + 3));
    clear_picture(&in);
}

// ---- samples that are not finite, or large ------------------------------------------------------

static void test_not_finite(void **state)
{
    (void)state;
    static const float bad[] = {NAN, INFINITY, 3.0e38f};
    for (int b = 0; b < 3; b++)
        for (size_t m = 0; m < WEFT_COUNT(maps); m++)
            for (int e = WITHOUT_GL; e < 2; e++) {
                struct picture in = make_samples(37, 29, 2), out;
                struct weft_warp_params p = request("catmull-rom", &in);
                float *planes[2] = {NULL, NULL};
                in.plane[1][14 * 37 + 18] = bad[b];
                set_map(&maps[m], &p, planes);
                const struct weft_verify_report error =
                    warp(&p, &(struct how){.engine = (enum weft_engine)e}, &in, &out);
                assert_within(&error, maps[m].name);
                // Some pixels of the channel see it, and most do not.
                const uint64_t all = WIDTH * HEIGHT * 2;
                if (b < 2)
                    assert_true(error.values_compared < all && error.values_compared > all / 2);
                else
                    assert_int_equal(error.values_compared, all);
                clear_picture(&in);
                clear_picture(&out);
                free(planes[0]);
                free(planes[1]);
            }
}

// ---- what is refused ----------------------------------------------------------------------------

static void assert_refused(struct weft_warp_params p, enum weft_result expected, const char *words)
{
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    weft_warp_plan *plan = (void *)1;
    p.log = &log;
    assert_int_equal(weft_warp_plan_create(&p, &plan), expected);
    assert_null(plan);
    assert_int_equal(message.count, 1);
    if (!strstr(message.text, words))
        fail_msg("'%s' is not in: %s", words, message.text);
}

static void test_refused(void **state)
{
    (void)state;
    const struct picture in = {37, 29, 1, {NULL}};
    const struct weft_warp_params good = request("catmull-rom", &in);
    static const double singular[][9] = {{1.0, 2.0, 0.0, 2.0, 4.0, 0.0, 0.0, 0.0, 1.0},
                                         {1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0},
                                         {0.0, 0.0, 3.0, 0.0, 0.0, 6.0, 0.0, 0.0, 1.0}};
    for (int i = 0; i < 3; i++) {
        struct weft_warp_params p = good;
        memcpy(p.map.matrix, singular[i], sizeof singular[i]);
        assert_refused(p, WEFT_ERR_ARGUMENT, "has no inverse: its determinant is 0");
    }
    struct weft_warp_params p = good;
    memcpy(p.map.matrix, (const double[]){1, 0, 0, 0, 1, 0, 0.1, 0, -1}, 9 * sizeof(double));
    assert_refused(p, WEFT_ERR_ARGUMENT, "horizon meets the 37 x 29 pixels");
    p = good;
    p.map.matrix[0] = (double)NAN;
    assert_refused(p, WEFT_ERR_ARGUMENT, "must be finite");
    p = good;
    weft_warp_matrix_affine((const double[]){1e-9, 0, 0, 1e-9, 0, 0}, p.map.matrix);
    assert_refused(p, WEFT_ERR_ARGUMENT, "at most 268435456");
    p = good;
    weft_warp_matrix_affine((const double[]){1e-4, 1e-4, -1e-4, 1e-4, 0, 0}, p.map.matrix);
    assert_refused(p, WEFT_ERR_LIMIT, "at most 4096 are possible");
    p.unstretched = true; // then it is only far away
    weft_warp_plan *plan;
    assert_int_equal(weft_warp_plan_create(&p, &plan), WEFT_OK);
    weft_warp_plan_destroy(&plan);
    p = good;
    p.kernel = kernel_named("bspline3i");
    weft_warp_matrix_affine((const double[]){0.5, 0.1, -0.1, 0.5, 0, 0}, p.map.matrix);
    assert_refused(p, WEFT_ERR_UNSUPPORTED, "which is prefiltered: it cannot be stretched");
    p = good;
    p.width = 1 << 30;
    p.height = 1;
    assert_refused(p, WEFT_ERR_ARGUMENT, "1073741824 x 1 pixels");
    // One position of many.
    p = good;
    p.width = WIDTH;
    p.height = HEIGHT;
    p.map.kind = WEFT_WARP_POSITIONS;
    float *planes[2] = {make_waves(0, 1.0), make_waves(1, 1.0)};
    p.map.position[0] = planes[0];
    p.map.position[1] = planes[1];
    planes[1][20 * WIDTH + 30] = NAN;
    assert_refused(p, WEFT_ERR_ARGUMENT, "pixel (30, 20) shows the point");
    planes[1][20 * WIDTH + 30] = 3e8f;
    assert_refused(p, WEFT_ERR_ARGUMENT, "1 of 41 x 33 are not");
    free(planes[0]);
    free(planes[1]);
}

// ---- quality ------------------------------------------------------------------------------------

static double snr_of_turns(const char *kernel, const struct picture *in)
{
    struct picture now = make_picture(in->width, in->height, 1), next;
    double signal = 0.0, error = 0.0;
    memcpy(now.plane[0], in->plane[0], (size_t)(in->width * in->height) * sizeof(float));
    struct weft_warp_params p = request(kernel, in);
    rotate(&p, 15.0);
    struct ready ready = make_ready(&p, &(struct how){.engine = WEFT_ENGINE_CPU});
    for (int i = 0; i < 24; i++) {
        run_ready(&ready, &(struct weft_rectangle){0}, &now, &next, NULL);
        clear_picture(&now);
        now = next;
    }
    clear_ready(&ready);
    // Within the circle that never left the picture.
    for (int y = 0; y < in->height; y++)
        for (int x = 0; x < in->width; x++) {
            const double a = (double)in->plane[0][y * in->width + x];
            const double e = (double)now.plane[0][y * in->width + x] - a;
            if (hypot(x + 0.5 - 0.5 * in->width, y + 0.5 - 0.5 * in->height) > 0.35 * in->width)
                continue;
            signal += a * a;
            error += e * e;
        }
    clear_picture(&now);
    return 10.0 * log10(signal / error);
}

// The test of Thevenaz, Blu and Unser (2000): after 24 turns by 15 degrees a picture is what it
// was, but for what the kernel lost, and kernels rank by their order.
static void test_turns(void **state)
{
    (void)state;
    const char *size = getenv("WEFT_WARP_TURNS");
    const int side = size ? atoi(size) : 40;
    struct picture in = make_picture(side, side, 1);
    for (int y = 0; y < side; y++)
        for (int x = 0; x < side; x++)
            in.plane[0][y * side + x] =
                (float)(sin(0.9 * x + 0.3 * y) + cos(0.02 * (x - 20) * (y + 5)) + 1.0);
    const double linear = snr_of_turns("linear", &in), cubic = snr_of_turns("catmull-rom", &in);
    const double spline = snr_of_turns("bspline3i", &in), fifth = snr_of_turns("bspline5i", &in);
    if (size)
        print_message("linear %.2f dB, catmull-rom %.2f, bspline3i %.2f, bspline5i %.2f\n", linear,
                      cubic, spline, fifth);
    assert_true(linear < cubic - 3.0 && cubic < spline - 3.0 && spline < fifth - 3.0);
    clear_picture(&in);
}

// A checkerboard of single samples, turned and 8.5 times smaller: all of it is above what pixels
// can show, and the stretched kernel leaves next to nothing but its mean; unstretched it aliases.
static void test_checkerboard(void **state)
{
    (void)state;
    struct picture in = make_picture(256, 256, 1), out;
    for (int i = 0; i < 256 * 256; i++)
        in.plane[0][i] = (float)((i + i / 256) & 1);
    for (int unstretched = 0; unstretched < 2; unstretched++)
        for (int e = WITHOUT_GL; e < 2; e++) {
            struct weft_warp_params p = request("mitchell", &in);
            double largest = 0.0;
            rotate(&p, 15.0);
            for (int i = 0; i < 6; i++)
                p.map.matrix[i] /= 8.5;
            p.width = p.height = 22;
            p.unstretched = unstretched;
            p.map.result_corner[0] = p.map.result_corner[1] = 4.0;
            const struct weft_verify_report error =
                warp(&p, &(struct how){.engine = (enum weft_engine)e}, &in, &out);
            assert_within(&error, "checkerboard");
            for (int i = 0; i < 22 * 22; i++)
                largest = fmax(largest, fabs((double)out.plane[0][i] - 0.5));
            // Mitchell's response at 8.5 times the Nyquist frequency along both axes.
            assert_true(unstretched ? largest > 0.2 : largest < 1e-3);
            clear_picture(&out);
        }
    clear_picture(&in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_matrices),     cmocka_unit_test(test_positions),
        cmocka_unit_test(test_within_bound), cmocka_unit_test(test_exact),
        cmocka_unit_test(test_parts),        cmocka_unit_test(test_not_finite),
        cmocka_unit_test(test_refused),      cmocka_unit_test(test_turns),
        cmocka_unit_test(test_checkerboard), cmocka_unit_test(test_aligned),
        cmocka_unit_test(test_as_resampled),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
