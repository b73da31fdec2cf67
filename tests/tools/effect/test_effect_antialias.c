// SPDX-License-Identifier: BSD-3-Clause
// A jittered edge: the pixels that are drawn are the edge's exact coverage, within the set's own
// discrepancy, at every angle and for every set; with a filter, the exact share of its weight.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "tests/tools/effect/pictures.h"

static const int size[2] = {24, 16};

// The distance of an edge from a pixel's centre: the pixel has d where the edge has distance d.
static double pixel_distance(const double normal[2], double distance, int x, int y)
{
    return distance - normal[0] * (x + 0.5 - 0.5 * size[0]) - normal[1] * (y + 0.5 - 0.5 * size[1]);
}

static struct effect_plan plan_of(const struct scene *scene, const char *jitter, bool centre,
                                  int count, const char *filter, double width)
{
    return plan_made(
        effect_params(.effects = EFFECT_ANTIALIAS, .scene = {scene}, .scene_count = 1,
                      .size = {size[0], size[1]}, .frames = count,
                      .jitter = weft_jitter_find(jitter), .centre = centre,
                      .filter = filter ? kernel_named(filter) : (struct weft_kernel){.info = NULL},
                      .filter_width = width));
}

// What the plan's samples see of an edge: the sum of the weights of those inside.
static double sum_inside(const struct effect_plan *plan, const double normal[2], double distance)
{
    double sum = 0.0;
    for (int64_t k = 0; k < plan->count; k++) {
        const double *move = plan->frames[k].show.camera.move;
        sum += -move[0] * normal[0] - move[1] * normal[1] <= distance ? plan->frames[k].weight : 0;
    }
    return sum;
}

// All |weights| of samples that the rounding of vertices may carry across the edge.
static double sum_near(const struct effect_plan *plan, const double normal[2], double distance)
{
    double sum = 0.0;
    for (int64_t k = 0; k < plan->count; k++) {
        const double *move = plan->frames[k].show.camera.move;
        const double left = distance + move[0] * normal[0] + move[1] * normal[1];
        sum += fabs(left) <= snap ? fabs(plan->frames[k].weight) : 0.0;
    }
    return sum;
}

// Every pixel that the edge touches, of an edge of this angle.
struct tally {
    int pixels;
    double worst; // largest |pixel - coverage| / bound
};

// Samples see the edge where it was rounded to, at most `snap` away: from there to here the
// coverage changes by sqrt(2) snap at most, the longest chord of a pixel.
static void check_box(weft_context *context, const char *jitter, bool centre, int count,
                      double angle, double distance, double most, struct tally *tally)
{
    struct scene scene;
    make_half_plane(&scene, size, angle, distance);
    const double normal[2] = {cos(angle), sin(angle)};
    struct effect_plan plan = plan_of(&scene, jitter, centre, count, NULL, 0.0);
    struct picture picture = draw_plan(context, &plan, &scene);
    assert_true(plan.set[EFFECT_PIXEL].discrepancy <= most);
    const double bound = plan.set[EFFECT_PIXEL].discrepancy + M_SQRT2 * snap + 1e-6;
    for (int y = 0; y < size[1]; y++)
        for (int x = 0; x < size[0]; x++) {
            const double d = pixel_distance(normal, distance, x, y);
            const double value = pixel_at(&picture, 0, x, y);
            const double error = fabs(value - weft_edge_square(normal, d));
            if (!(error <= bound))
                fail_msg("%s of %d, angle %g: pixel (%d, %d) is %g, its coverage %g, D %g", jitter,
                         count, angle, x, y, value, weft_edge_square(normal, d),
                         plan.set[EFFECT_PIXEL].discrepancy);
            assert_near(value, sum_inside(&plan, normal, d), sum_near(&plan, normal, d) + 1e-6,
                        "share of the samples");
            tally->pixels += fabs(d) < 0.5;
            tally->worst = larger(tally->worst, error / bound);
        }
    free(picture.value);
    effect_plan_clear(&plan);
    scene_clear(&scene);
}

static void edges_have_their_coverage(void **state)
{
    (void)state;
    static const struct {
        const char *jitter;
        int count;
        bool centre;
        double discrepancy; // not more, by a fine search
    } sets[] = {
        {"j2", 2, false, 0.5},      {"j3", 3, false, 0.39},         {"j4", 4, false, 0.27},
        {"j8", 8, false, 0.198},    {"j15", 15, false, 0.151},      {"j24", 24, false, 0.107},
        {"j66", 66, false, 0.058},  {"msaa", 8, false, 0.227},      {"msaa", 16, true, 0.2},
        {"halton", 64, true, 0.11}, {"hammersley", 64, true, 0.07}, {"sobol", 64, true, 0.11},
        {"r2", 64, true, 0.09},     {"grid", 64, false, 0.0625},    {"stratified", 16, false, 0.4},
    };
    uint64_t seed = 11;
    for (size_t i = 0; i < WEFT_COUNT(sets); i++) {
        struct tally tally = {0};
        for (int a = 0; a < 12; a++) {
            // Along the axes, the diagonals, and anywhere; contexts in turn.
            const double angle = a < 8 ? a * M_PI_4 : random_in(&seed, 0.0, 2.0 * M_PI);
            weft_context *context = contexts[1] && a % 2 ? contexts[1] : contexts[0];
            check_box(context, sets[i].jitter, sets[i].centre, sets[i].count, angle,
                      random_in(&seed, -3.0, 3.0), sets[i].discrepancy + 5e-4, &tally);
        }
        print_message("%s of %d: %d pixels on edges, error at worst %.2f of the bound\n",
                      sets[i].jitter, sets[i].count, tally.pixels, tally.worst);
        assert_true(tally.pixels > 100);
    }
}

// With a filter: the grid of k x k samples. A sample stands for a cell of the support. Where the
// edge passes through a cell, the weight there counts all or not at all; elsewhere it is the
// middle's in place of the mean. Both are at most the difference of the largest and the least of
// weight * inside over the cell, which is bounded here by looking at 5 x 5 places of it, and half
// as much again for what lies between.
static double find_filter_bound(const struct weft_kernel *kernel, int k, const double normal[2],
                                double distance)
{
    const double side = 2.0 * kernel->support / k;
    double bound = 0.0, all = 0.0;
    for (int cell = 0; cell < k * k; cell++) {
        double least = INFINITY, most = -INFINITY;
        for (int at = 0; at < 25; at++) {
            double p[2];
            for (int axis = 0; axis < 2; axis++) {
                const int c = axis ? cell / k : cell % k, i = axis ? at / 5 : at % 5;
                p[axis] = (c + i / 4.0) * side - kernel->support;
            }
            const double h = weft_kernel_weight(kernel, -p[0]) * weft_kernel_weight(kernel, -p[1]);
            const double value = p[0] * normal[0] + p[1] * normal[1] <= distance ? h : 0.0;
            least = fmin(least, value);
            most = fmax(most, value);
        }
        bound += 1.5 * (most - least) * side * side;
        all += side * side * weft_kernel_weight(kernel, (cell % k + 0.5) * side - kernel->support) *
               weft_kernel_weight(kernel, (cell / k + 0.5) * side - kernel->support);
    }
    return bound / all;
}

static void check_filter(weft_context *context, const char *filter, double angle, double distance,
                         struct tally *tally)
{
    enum { K = 24 };
    struct scene scene;
    make_half_plane(&scene, size, angle, distance);
    const double normal[2] = {cos(angle), sin(angle)};
    const struct weft_kernel kernel = kernel_named(filter);
    struct effect_plan plan = plan_of(&scene, "grid", false, K * K, filter, 0.0);
    struct picture picture = draw_plan(context, &plan, &scene);
    for (int y = 0; y < size[1]; y++)
        for (int x = 0; x < size[0]; x++) {
            const double d = pixel_distance(normal, distance, x, y);
            if (fabs(d) > kernel.support)
                continue;
            struct weft_edge_value exact;
            assert_int_equal(weft_edge_kernel(&log_to_stderr, &kernel, 0.0, normal, d, &exact),
                             WEFT_OK);
            const double near = sum_near(&plan, normal, d) + 1e-5;
            const double value = pixel_at(&picture, 0, x, y);
            assert_near(value, sum_inside(&plan, normal, d), near, "share of the weights");
            const double error = fabs(value - exact.value);
            assert_near(error, 0.0, find_filter_bound(&kernel, K, normal, d) + near,
                        "share of the filter");
            tally->pixels++;
            tally->worst = larger(tally->worst, error);
        }
    free(picture.value);
    effect_plan_clear(&plan);
    scene_clear(&scene);
}

static void filters_have_the_exact_share(void **state)
{
    (void)state;
    // The errors seen: they may not grow. At 45 degrees a row of the grid lies on the edge, or not.
    static const struct {
        const char *filter;
        double seen;
    } cases[] = {{"linear", 0.04}, {"mitchell", 0.05}, {"lanczos:2", 0.055}, {"bspline3", 0.04}};
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct tally tally = {0};
        uint64_t seed = 5;
        for (int a = 0; a < 5; a++)
            check_filter(contexts[0], cases[i].filter, a * M_PI_4 + (a > 2 ? 0.3 : 0.0),
                         random_in(&seed, -2.0, 2.0), &tally);
        print_message("%s: %d pixels, error %.4f at worst\n", cases[i].filter, tally.pixels,
                      tally.worst);
        assert_true(tally.pixels > 100);
        assert_true(tally.worst <= cases[i].seen);
    }
}

// A filter of negative lobes rings beside the edge: below 0 and above 1 by what the table says.
static void lobes_are_drawn(void **state)
{
    (void)state;
    struct scene scene;
    make_half_plane(&scene, size, 0.0, 0.5);
    struct effect_plan plan = plan_of(&scene, "sobol", true, 256, "lanczos:3", 0.0);
    struct picture picture = draw_plan(contexts[0], &plan, &scene);
    float least = INFINITY, most = -INFINITY;
    for (int x = 0; x < size[0]; x++) {
        least = fminf(least, pixel_at(&picture, 0, x, 8));
        most = fmaxf(most, pixel_at(&picture, 0, x, 8));
    }
    assert_true(least < -0.03f && most > 1.03f);
    free(picture.value);
    effect_plan_clear(&plan);
    scene_clear(&scene);
}

// Samples lie where the plan says, not mirrored: a set of one point, a quarter right and below of
// the centre, sees an edge at x <= 0.2 not, and one at y >= 0.2 (rows go down) not.
static void compute_one(const struct weft_jitter_info *info, int count, uint64_t seed,
                        double (*points)[2])
{
    (void)info;
    (void)seed;
    for (int i = 0; i < count; i++) {
        points[i][0] = 0.25;
        points[i][1] = 0.25;
    }
}

static void samples_lie_right_and_below(void **state)
{
    (void)state;
    static const struct weft_jitter_info one = {
        .name = "one", .description = "(1/4, 1/4)", .default_count = 1, .compute = compute_one};
    // Edges of the pixel (12, 8), whose centre is (1/2, 1/2): white left of, and above them.
    static const struct {
        double angle, distance;
        float value;
    } cases[] = {{0.0, 0.5 + 0.2, 0.0f},
                 {0.0, 0.5 + 0.3, 1.0f},
                 {-M_PI_2, -0.5 + 0.2, 0.0f},
                 {-M_PI_2, -0.5 + 0.3, 1.0f}};
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct scene scene;
        make_half_plane(&scene, size, cases[i].angle, cases[i].distance);
        struct effect_plan plan = plan_made(
            effect_params(.effects = EFFECT_ANTIALIAS, .scene = {&scene}, .scene_count = 1,
                          .size = {size[0], size[1]}, .frames = 1, .jitter = &one));
        struct picture picture = draw_plan(contexts[0], &plan, &scene);
        assert_near(plan.set[EFFECT_PIXEL].mean[0], 0.25, 0.0, "mean");
        assert_near(pixel_at(&picture, 0, 12, 8), cases[i].value, 0.0, "pixel");
        free(picture.value);
        effect_plan_clear(&plan);
        scene_clear(&scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(edges_have_their_coverage),
        cmocka_unit_test(filters_have_the_exact_share),
        cmocka_unit_test(lobes_are_drawn),
        cmocka_unit_test(samples_lie_right_and_below),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
