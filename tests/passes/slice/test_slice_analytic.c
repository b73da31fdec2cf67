// SPDX-License-Identifier: BSD-3-Clause
// Derivatives and curvatures of slices against analytic ones: the test signal of Marschner and
// Lobb, a sphere and a torus. Halving the sample distance shows each kernel's order of convergence,
// which is the theoretical one (Moeller, Machiraju, Mueller, Yagel, TVCG 1997, for filters; Strang
// and Fix 1971 for splines with their prefilter).
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "weft.h"

// ---- functions with their derivatives -----------------------------------------------------------

// A value, its gradient and its Hessian (xx, xy, xz, yy, yz, zz).
struct jet {
    double v, g[3], h[6];
};
static const int pairs[6][2] = {{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}};

static struct jet coordinate(const double at[3], int axis, double from)
{
    struct jet j = {.v = at[axis] - from};
    j.g[axis] = 1.0;
    return j;
}

// f(j), by f, f' and f'' there.
static struct jet apply(struct jet j, double f, double d, double dd)
{
    struct jet out = {.v = f};
    for (int a = 0; a < 3; a++)
        out.g[a] = d * j.g[a];
    for (int i = 0; i < 6; i++)
        out.h[i] = d * j.h[i] + dd * j.g[pairs[i][0]] * j.g[pairs[i][1]];
    return out;
}

// a * j + b * k + c.
static struct jet combine(double a, struct jet j, double b, struct jet k, double c)
{
    struct jet out = {.v = a * j.v + b * k.v + c};
    for (int i = 0; i < 3; i++)
        out.g[i] = a * j.g[i] + b * k.g[i];
    for (int i = 0; i < 6; i++)
        out.h[i] = a * j.h[i] + b * k.h[i];
    return out;
}

static struct jet square(struct jet j)
{
    return apply(j, j.v * j.v, 2.0 * j.v, 2.0);
}

static struct jet root(struct jet j)
{
    const double r = sqrt(j.v);
    return apply(j, r, 0.5 / r, -0.25 / (r * j.v));
}

static struct jet cosine(struct jet j, double by)
{
    return apply(j, cos(by * j.v), -by * sin(by * j.v), -by * by * cos(by * j.v));
}

static struct jet distance(struct jet j, struct jet k)
{
    return root(combine(1.0, square(j), 1.0, square(k), 0.0));
}

static struct jet marschner_lobb(const double at[3])
{
    const double pi = acos(-1.0), alpha = 0.25;
    const struct jet r = distance(coordinate(at, 0, 0.0), coordinate(at, 1, 0.0));
    const struct jet ring = cosine(cosine(r, pi / 2.0), 2.0 * pi * 6.0);
    const struct jet z = cosine(coordinate(at, 2, 1.0), pi / 2.0); // sin(pi z / 2)
    const double by = 1.0 / (2.0 * (1.0 + alpha));
    return combine(-by, z, alpha * by, ring, 0.5);
}

// Signed distances, positive inside: to a sphere, and to a torus.
static struct jet sphere(const double at[3])
{
    const struct jet xy = distance(coordinate(at, 0, 0.0), coordinate(at, 1, 0.0));
    return combine(-1.0, distance(xy, coordinate(at, 2, 0.0)), 0.0, xy, 0.75);
}

static const double RING = 0.6;

static struct jet torus(const double at[3])
{
    const struct jet xy = distance(coordinate(at, 0, 0.0), coordinate(at, 1, 0.0));
    return combine(-1.0, distance(combine(1.0, xy, 0.0, xy, -RING), coordinate(at, 2, 0.0)), 0.0,
                   xy, 0.25);
}

// Principal curvatures of the level surfaces, the larger one first.
static void sphere_curvatures(const double at[3], double out[2])
{
    out[0] = out[1] = 1.0 / sqrt(at[0] * at[0] + at[1] * at[1] + at[2] * at[2]);
}

static void torus_curvatures(const double at[3], double out[2])
{
    const double rho = hypot(at[0], at[1]), tube = hypot(rho - RING, at[2]);
    out[0] = 1.0 / tube;
    out[1] = (rho - RING) / (tube * rho);
}

// ---- slices -------------------------------------------------------------------------------------

struct signal {
    const char *name;
    struct jet (*at)(const double at[3]);
    void (*curvatures)(const double at[3], double out[2]); // NULL: by its derivatives
    double middle[3];                                      // of the slice
    double
        step; // that is halved: where errors are neither floats' rounding nor far from their limit
};
static const struct signal signals[] = {
    {"Marschner-Lobb", marschner_lobb, NULL, {0.31, 0.22, 0.13}, 0.006},
    {"sphere", sphere, sphere_curvatures, {0.43, 0.41, 0.45}, 0.045},
    {"torus", torus, torus_curvatures, {0.62, 0.31, 0.19}, 0.015},
};

enum { SIDE = 24, PIXELS = SIDE * SIDE, MARGIN = 20, MOST = 104 };
static const double U[3] = {0.08, 0.03, 0.02}, V[3] = {-0.03, 0.07, 0.035};

// Samples around the slice, `step` apart, in box^3 voxels; the first one lies at `corner`.
static weft_volume *sample(const struct signal *signal, double step, int box, double corner[3])
{
    float *data = malloc((size_t)box * (size_t)box * (size_t)box * sizeof *data);
    weft_volume *volume = NULL;
    assert_non_null(data);
    assert_true(box <= MOST);
    for (int a = 0; a < 3; a++)
        corner[a] = signal->middle[a] - 0.5 * step * (box - 1);
    for (int i = 0; i < box * box * box; i++)
        data[i] = (float)signal
                      ->at((const double[3]){corner[0] + step * (i % box),
                                             corner[1] + step * (i / box % box),
                                             corner[2] + step * (i / box / box)})
                      .v;
    assert_int_equal(
        weft_volume_create(weft_volume_params(.size = {box, box, box}, .data = data), &volume),
        WEFT_OK);
    free(data);
    return volume;
}

// What is asked for, in groups of channels.
enum { VALUE, GRADIENT, HESSIAN, MEAN, GAUSSIAN, PRINCIPAL, GROUPS };
static const char *const group_names[GROUPS] = {
    "value", "gradient", "Hessian", "mean curvature", "Gaussian curvature", "principal curvatures"};
static const int group_end[GROUPS] = {1, 4, 10, 11, 12, 14};

static void analytic(const struct signal *signal, const struct weft_quantities *list,
                     const double at[3], double channel[WEFT_QUANTITY_CHANNELS])
{
    const struct jet j = signal->at(at);
    struct weft_quantity_transform identity;
    double derivative[WEFT_DERIVATIVES];
    assert_int_equal(weft_quantity_transform_create(NULL, NULL, &identity), WEFT_OK);
    for (int i = 0; i < list->derivative_count; i++) {
        const int *along = list->derivative[i].along;
        derivative[i] = j.v;
        for (int a = 0; a < 3; a++)
            if (along[a] == 1 && along[0] + along[1] + along[2] == 1)
                derivative[i] = j.g[a];
        for (int k = 0; k < 6; k++) {
            int of[3] = {0};
            of[pairs[k][0]]++;
            of[pairs[k][1]]++;
            if (memcmp(of, along, sizeof of) == 0)
                derivative[i] = j.h[k];
        }
    }
    weft_quantities_compute(list, &identity, derivative, channel);
    if (!signal->curvatures)
        return;
    double *k = channel + group_end[GAUSSIAN];
    signal->curvatures(at, k);
    channel[group_end[HESSIAN]] = 0.5 * (k[0] + k[1]);
    channel[group_end[MEAN]] = k[0] * k[1];
}

// A slice's planes, of outputs that `list` asks for, with the position of each pixel.
struct slice {
    int outputs;
    float pixels[WEFT_DERIVATIVES * PIXELS];
    double at[PIXELS][3];
};

static void make_slice(const struct signal *signal, const struct weft_kernel *kernel, double step,
                       const struct weft_quantities *list, int outputs, struct slice *out)
{
    double corner[3], widest = 0.0;
    for (int a = 0; a < 3; a++)
        widest = fmax(widest, fabs(U[a]) + fabs(V[a]));
    weft_volume *volume = sample(signal, step, (int)(widest / step) + 2 * MARGIN, corner);
    struct weft_slice_geometry g = {.width = SIDE, .height = SIDE};
    weft_slice_plan *plan = NULL;
    for (int a = 0; a < 3; a++) {
        g.origin[a] = (signal->middle[a] - 0.5 * (U[a] + V[a]) - corner[a]) / step;
        g.u[a] = U[a] / step;
        g.v[a] = V[a] / step;
    }
    out->outputs = outputs;
    for (int i = 0; i < PIXELS; i++)
        for (int a = 0; a < 3; a++)
            out->at[i][a] = corner[a] + step * (g.origin[a] + (i % SIDE + 0.5) / SIDE * g.u[a] +
                                                (i / SIDE + 0.5) / SIDE * g.v[a]);
    assert_int_equal(weft_slice_plan_create(
                         volume,
                         weft_slice_params(.kernel = *kernel, .space = WEFT_SPACE_INDEX,
                                           .geometry = g, .derivative = list->derivative,
                                           .derivative_count = outputs, .engine = WEFT_ENGINE_CPU,
                                           .sums = WEFT_SUMS_DOUBLE, .log = &log_to_stderr),
                         &plan),
                     WEFT_OK);
    assert_int_equal(weft_slice_run_once(plan, weft_slice_compile_params(.cpu = {0}),
                                         weft_slice_run_params(.pixels = out->pixels), NULL),
                     WEFT_OK);
    weft_slice_plan_destroy(&plan);
    weft_volume_destroy(&volume);
}

// Channels of a pixel in the signal's units.
static void channels_of(const struct slice *slice, const struct weft_quantities *list, double step,
                        int i, double channel[WEFT_QUANTITY_CHANNELS])
{
    const double to_world[3][4] = {{step}, {0.0, step}, {0.0, 0.0, step}};
    struct weft_quantity_transform transform;
    double derivative[WEFT_DERIVATIVES] = {0.0};
    assert_int_equal(weft_quantity_transform_create(NULL, to_world, &transform), WEFT_OK);
    for (int o = 0; o < slice->outputs; o++)
        derivative[o] = (double)slice->pixels[o * PIXELS + i];
    weft_quantities_compute(list, &transform, derivative, channel);
}

// ---- orders of convergence ----------------------------------------------------------------------

// Root mean square of each group's errors.
static void find_errors(const struct signal *signal, const struct weft_kernel *kernel, double step,
                        int outputs, double errors[GROUPS])
{
    static struct slice slice;
    struct weft_quantities list;
    assert_int_equal(weft_quantities_parse(&log_to_stderr,
                                           "value,gradient,hessian,mean-curvature,"
                                           "gaussian-curvature,principal-curvatures",
                                           &list),
                     WEFT_OK);
    assert_int_equal(list.channel_count, group_end[GROUPS - 1]);
    make_slice(signal, kernel, step, &list, outputs, &slice);
    memset(errors, 0, GROUPS * sizeof *errors);
    for (int i = 0; i < PIXELS; i++) {
        double own[WEFT_QUANTITY_CHANNELS], exact[WEFT_QUANTITY_CHANNELS];
        channels_of(&slice, &list, step, i, own);
        analytic(signal, &list, slice.at[i], exact);
        for (int g = 0, c = 0; g < GROUPS; g++)
            for (; c < group_end[g]; c++)
                errors[g] += (own[c] - exact[c]) * (own[c] - exact[c]);
    }
    for (int g = 0; g < GROUPS; g++)
        errors[g] = sqrt(errors[g] / PIXELS);
}

// Orders of the value, of first and of second derivatives; 0: there are none. Samples are floats,
// whose rounding the best kernels are soon as good as: they are shown on coarser ones.
static const struct {
    const char *name;
    int order[3];
    double coarser;
} kernels[] = {
    {"linear", {2, 1, 0}, 1.0},   {"catmull-rom", {3, 2, 1}, 1.0}, {"mitchell", {2, 2, 1}, 1.0},
    {"bspline3", {2, 2, 2}, 1.0}, {"bspline3i", {4, 3, 2}, 1.4},
};

static void check_orders(const struct signal *signal, size_t k, double step)
{
    const struct weft_kernel kernel = kernel_named(kernels[k].name);
    const int *order = kernels[k].order, groups = order[2] ? GROUPS : HESSIAN;
    double coarse[GROUPS], fine[GROUPS];
    find_errors(signal, &kernel, step, order[2] ? 10 : 4, coarse);
    find_errors(signal, &kernel, 0.5 * step, order[2] ? 10 : 4, fine);
    for (int g = 0; g < groups; g++) {
        const int expected = order[g < HESSIAN ? g : 2];
        const double observed = log2(coarse[g] / fine[g]);
        if (getenv("WEFT_ORDERS"))
            print_message("%-14s %-12s %-21s %.3g, %.3g: order %.2f of %d\n", signal->name,
                          kernels[k].name, group_names[g], coarse[g], fine[g], observed, expected);
        if (!(fabs(observed - expected) < 0.25))
            fail_msg("%s, %s: %s converges by order %.2f, not %d (%.3g, %.3g)", signal->name,
                     kernels[k].name, group_names[g], observed, expected, coarse[g], fine[g]);
    }
}

static void orders_of_convergence(void **state)
{
    (void)state;
    for (size_t s = 0; s < WEFT_COUNT(signals); s++)
        for (size_t k = 0; k < WEFT_COUNT(kernels); k++)
            check_orders(&signals[s], k, signals[s].step * kernels[k].coarser);
}

// The jets are the signal's derivatives.
static void jets_are_right(void **state)
{
    const struct weft_signal_info *info = weft_signal_find("marschner-lobb");
    (void)state;
    for (int i = 0; i < 100; i++) {
        const double at[3] = {0.3 + 0.003 * i, 0.5 - 0.007 * i, -0.4 + 0.008 * i};
        const struct jet j = marschner_lobb(at);
        double gradient[3];
        assert_near(j.v, info->value(at), 1e-12, "value");
        info->gradient(at, gradient);
        for (int a = 0; a < 3; a++)
            assert_near(j.g[a], gradient[a], 1e-10, "gradient");
        for (int k = 0; k < 6; k++) {
            const int along = pairs[k][1];
            double near[3] = {at[0], at[1], at[2]};
            near[along] += 1e-6;
            const struct jet other = marschner_lobb(near);
            assert_near(j.h[k], (other.g[pairs[k][0]] - j.g[pairs[k][0]]) / 1e-6, 2e-2, "Hessian");
        }
    }
}

// ---- normals ------------------------------------------------------------------------------------

// Of a level set of radius 50 voxels, in degrees.
static double largest_angle(const char *name)
{
    static struct slice slice;
    const struct weft_kernel kernel = kernel_named(name);
    const double step = 0.75 / 50.0;
    struct weft_quantities list;
    double largest = 0.0;
    int near = 0;
    assert_int_equal(weft_quantities_parse(&log_to_stderr, "normal,value", &list), WEFT_OK);
    make_slice(&signals[1], &kernel, step, &list, list.derivative_count, &slice);
    for (int i = 0; i < PIXELS; i++) {
        const double *at = slice.at[i], r = sqrt(at[0] * at[0] + at[1] * at[1] + at[2] * at[2]);
        double channel[WEFT_QUANTITY_CHANNELS], across = 0.0;
        if (fabs(r - 0.75) > 1.5 * step)
            continue;
        channels_of(&slice, &list, step, i, channel);
        for (int a = 0; a < 3; a++) {
            const int b = (a + 1) % 3, c = (a + 2) % 3;
            across += pow(channel[b] * at[c] / r - channel[c] * at[b] / r, 2.0);
        }
        assert_true(channel[0] * at[0] + channel[1] * at[1] + channel[2] * at[2] > 0.0);
        largest = fmax(largest, asin(sqrt(across)) * 180.0 / acos(-1.0));
        near++;
    }
    assert_true(near > PIXELS / 4);
    return largest;
}

static void normals_of_a_level_set(void **state)
{
    static const char *const names[] = {"catmull-rom", "bspline3", "keys6", "bspline3i",
                                        "bspline5"};
    (void)state;
    for (size_t k = 0; k < WEFT_COUNT(names); k++) {
        const double angle = largest_angle(names[k]);
        print_message("%s: normals of a sphere of radius 50 voxels within %.3g degrees\n", names[k],
                      angle);
        assert_true(angle < 0.1);
    }
    assert_true(largest_angle("linear") > 0.1); // or the test shows nothing
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(jets_are_right),
        cmocka_unit_test(orders_of_convergence),
        cmocka_unit_test(normals_of_a_level_set),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
