// SPDX-License-Identifier: BSD-3-Clause
// Slabs against the double reference at the same samples, and against dense quadrature.
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "tests/support/common.h"
#include "weft.h"

enum { SIDE = 11, WIDTH = 9, HEIGHT = 7, PIXELS = WIDTH * HEIGHT };

static float voxels[SIDE * SIDE * SIDE];
static double largest = 1.0;

// A rotation by thirds of a right angle, with voxels of other sizes along each axis, and a shear.
static const double transform[3][4] = {
    {0.43, -0.31, 0.05, 3.0}, {0.25, 0.54, 0.0, -2.0}, {0.0, 0.1, 0.8, 1.0}};

static weft_volume *make_volume(void)
{
    weft_volume *volume = NULL;
    struct weft_volume_params p = *weft_volume_params(.size = {SIDE, SIDE, SIDE}, .data = voxels,
                                                      .background = 0.0f, .log = &log_to_stderr);
    uint64_t state = 7;
    for (int i = 0; i < SIDE * SIDE * SIDE; i++) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        voxels[i] = (float)(state >> 40) * 0x1p-24f;
    }
    memcpy(p.index_to_world, transform, sizeof transform);
    assert_int_equal(weft_volume_create(&p, &volume), WEFT_OK);
    return volume;
}

static double fetch(void *priv, const int64_t index[3])
{
    (void)priv;
    for (int a = 0; a < 3; a++)
        if (index[a] < 0 || index[a] >= SIDE)
            return 0.0;
    return (double)voxels[(index[2] * SIDE + index[1]) * SIDE + index[0]];
}

static double value_at(const struct weft_kernel *kernel, const double world[3])
{
    struct weft_quantity_transform inverse;
    double index[3];
    weft_quantity_transform_create(NULL, transform, &inverse);
    for (int r = 0; r < 3; r++) {
        index[r] = 0.0;
        for (int c = 0; c < 3; c++)
            index[r] += inverse.inverse[r][c] * (world[c] - transform[c][3]);
    }
    return weft_reference_compute(kernel, 3, index, fetch, NULL).value;
}

// An oblique plane through the middle of the voxels.
static struct weft_slab_params oblique(weft_volume *volume)
{
    return (struct weft_slab_params){.volume = volume,
                                     .slice = {.kernel = kernel_named("bspline"),
                                               .geometry = {.origin = {1.7, -0.3, 3.6},
                                                            .u = {3.5, 1.0, 0.4},
                                                            .v = {-1.0, 3.6, 0.7},
                                                            .width = WIDTH,
                                                            .height = HEIGHT},
                                               .engine = WEFT_ENGINE_CPU,
                                               .log = &log_to_stderr},
                                     .thickness = 2.3};
}

static void pixel_position(const struct weft_slab_params *p, int x, int y, double out[3])
{
    const struct weft_slice_geometry *g = &p->slice.geometry;
    for (int i = 0; i < 3; i++)
        out[i] = g->origin[i] + (x + 0.5) / WIDTH * g->u[i] + (y + 0.5) / HEIGHT * g->v[i];
}

static double combined(enum weft_combine how, double a, double b)
{
    return how == WEFT_COMBINE_MAX ? fmax(a, b) : how == WEFT_COMBINE_MIN ? fmin(a, b) : a + b;
}

// By the reference, at `cuts` samples of the thickness.
static double expect(const struct weft_slab_params *p, const double normal[3], int cuts, int x,
                     int y)
{
    double middle[3], out = 0.0;
    pixel_position(p, x, y, middle);
    for (int i = 0; i < cuts; i++) {
        double at[3];
        for (int k = 0; k < 3; k++)
            at[k] = middle[k] + ((i + 0.5) / cuts - 0.5) * p->thickness * normal[k];
        const double value = value_at(&p->slice.kernel, at);
        out = i == 0 ? value : combined(p->combine, out, value);
    }
    const double mean = out / cuts;
    return p->combine == WEFT_COMBINE_MEAN  ? mean
           : p->combine == WEFT_COMBINE_SUM ? mean * p->thickness
                                            : out;
}

// What the plane's plan states for a sample.
static double sample_bound(const struct weft_slab_params *p)
{
    weft_slice_plan *plan = NULL;
    assert_int_equal(weft_slice_plan_create(p->volume, &p->slice, &plan), WEFT_OK);
    const struct weft_slice_output *o = &weft_slice_plan_get_info(plan)->output[0];
    const double bound = o->error_bound * largest + o->error_absolute;
    weft_slice_plan_destroy(&plan);
    return bound;
}

static void slabs_are_their_samples(void **state)
{
    (void)state;
    weft_volume *volume = make_volume();
    float pixels[PIXELS];
    struct weft_slab_params p = oblique(volume);
    // Positions are rounded to 2^-29 voxels: slopes are at most 3 times the largest voxel.
    const double bound = sample_bound(&p) + 9.0 * 0x1p-29;
    for (int how = 0; how < WEFT_COMBINE_COUNT; how++) {
        struct weft_slab_info info;
        p.combine = (enum weft_combine)how;
        assert_int_equal(weft_slab_place(&p, &info), WEFT_OK);
        assert_true(info.voxels <= 0.5 && info.voxels > 0.3 && info.cuts > 4);
        assert_near(info.spacing * info.cuts, p.thickness, 1e-12, "thickness");
        assert_int_equal(weft_slab_run(&p, weft_slice_compile_params(0),
                                       weft_slice_run_params(.pixels = pixels), NULL),
                         WEFT_OK);
        const double scale = how == WEFT_COMBINE_SUM ? p.thickness : 1.0;
        for (int i = 0; i < PIXELS; i++) {
            const double exact = expect(&p, info.normal, info.cuts, i % WIDTH, i / WIDTH);
            assert_near((double)pixels[i], exact, scale * bound + 0x1p-24 * fabs(exact),
                        weft_combine_names[how]);
        }
    }
    weft_volume_destroy(&volume);
}

// The midpoint rule leaves step^2 / 24 of the largest second derivative: the B-spline's are at most
// 4 of voxels from 0 to 1, along each axis, of a step of half a voxel along all three together.
static void means_are_near_the_integral(void **state)
{
    (void)state;
    weft_volume *volume = make_volume();
    float pixels[PIXELS], finer[PIXELS];
    struct weft_slab_params p = oblique(volume);
    struct weft_slab_info info;
    double worst = 0.0, worst_finer = 0.0;
    assert_int_equal(weft_slab_place(&p, &info), WEFT_OK);
    assert_int_equal(weft_slab_run(&p, weft_slice_compile_params(0),
                                   weft_slice_run_params(.pixels = pixels), NULL),
                     WEFT_OK);
    p.cuts = 4 * info.cuts;
    assert_int_equal(weft_slab_run(&p, weft_slice_compile_params(0),
                                   weft_slice_run_params(.pixels = finer), NULL),
                     WEFT_OK);
    for (int i = 0; i < PIXELS; i += 5) {
        const double exact = expect(&p, info.normal, 1000, i % WIDTH, i / WIDTH);
        worst = fmax(worst, fabs((double)pixels[i] - exact));
        worst_finer = fmax(worst_finer, fabs((double)finer[i] - exact));
    }
    assert_true(worst <= 0.25 / 24.0 * 4.0 * 3.0);
    assert_true(worst_finer <= worst / 8.0); // the second order would be 16
    weft_volume_destroy(&volume);
}

// In index space the thickness is still one of the world; planes have strides of their own.
static void spaces_strides_and_quantities(void **state)
{
    (void)state;
    weft_volume *volume = make_volume();
    struct weft_slab_params p = oblique(volume), q;
    struct weft_slab_info world, index;
    struct weft_quantities list;
    float pixels[PIXELS], others[2 * (WIDTH + 3) * HEIGHT];
    weft_slice_plan *plan = NULL;
    assert_int_equal(weft_slice_plan_create(volume, &p.slice, &plan), WEFT_OK);
    q = p;
    q.slice.geometry = weft_slice_plan_get_info(plan)->index_geometry;
    q.slice.space = WEFT_SPACE_INDEX;
    weft_slice_plan_destroy(&plan);
    assert_int_equal(weft_slab_place(&p, &world), WEFT_OK);
    assert_int_equal(weft_slab_place(&q, &index), WEFT_OK);
    assert_int_equal(world.cuts, index.cuts);
    for (int i = 0; i < 3; i++)
        assert_near(world.normal[i], index.normal[i], 1e-12, "normal");
    assert_int_equal(weft_quantities_parse(NULL, "value", &list), WEFT_OK);
    q.quantities = &list;
    assert_int_equal(weft_slab_run(&p, weft_slice_compile_params(0),
                                   weft_slice_run_params(.pixels = pixels), NULL),
                     WEFT_OK);
    assert_int_equal(weft_slab_run(&q, weft_slice_compile_params(0),
                                   weft_slice_run_params(.pixels = others, .stride = WIDTH + 3),
                                   NULL),
                     WEFT_OK);
    for (int i = 0; i < PIXELS; i++)
        assert_near((double)others[i / WIDTH * (WIDTH + 3) + i % WIDTH], (double)pixels[i], 1e-5,
                    "index space");
    weft_volume_destroy(&volume);
}

static void bad_slabs_are_refused(void **state)
{
    (void)state;
    weft_volume *volume = make_volume();
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    static const struct {
        double thickness;
        const char *text;
        enum weft_result res;
    } cases[] = {{0.0, "above 0, not 0", WEFT_ERR_ARGUMENT},
                 {-1.0, "not -1", WEFT_ERR_ARGUMENT},
                 {NAN, "not nan", WEFT_ERR_ARGUMENT},
                 {INFINITY, "not inf", WEFT_ERR_ARGUMENT},
                 {1e12, "cuts: there may be at most 65536", WEFT_ERR_LIMIT}};
    struct weft_slab_params p = oblique(volume);
    struct weft_slab_info info;
    p.slice.log = &log;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        p.thickness = cases[i].thickness;
        message.count = 0;
        assert_int_equal(weft_slab_place(&p, &info), cases[i].res);
        assert_int_equal(message.count, 1);
        assert_non_null(strstr(message.text, cases[i].text));
        assert_int_equal(info.cuts, 0);
    }
    p.thickness = 1.0;
    memcpy(p.slice.geometry.v, p.slice.geometry.u, sizeof p.slice.geometry.v);
    assert_int_equal(weft_slab_place(&p, &info), WEFT_ERR_ARGUMENT);
    weft_volume_destroy(&volume);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slabs_are_their_samples), cmocka_unit_test(means_are_near_the_integral),
        cmocka_unit_test(spaces_strides_and_quantities), cmocka_unit_test(bad_slabs_are_refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
