// SPDX-License-Identifier: BSD-3-Clause
// Plans of effects, without a pixel: every dimension's set, how they are joined, what they weigh.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "tests/support/alloc_fail.h"
#include "tests/tools/effect/effects.h"
#include "tools/render/lamps.h"
#include "tools/effect/samples.h"

enum { MAX_COUNT = 4096 };
static const int size[2] = {64, 48};
static struct scene scene, other_scene, lit_scene;

static int make_scenes(void **state)
{
    (void)state;
    make_half_plane(&scene, size, 0.3, 1.0);
    make_half_plane(&other_scene, size, 1.3, 0.0);
    struct scene_build build = empty_scene(&lit_scene, size);
    const double middle[2] = {0.0, 0.0}, half[2] = {20.0, 20.0};
    add_rectangle(&build, add_colour(&build, 1.0f, 1.0f, 1.0f), 24.0, middle, half, 0.0);
    const struct scene_light square = {.shape = SCENE_LIGHT_SQUARE,
                                       .middle = {1.0, 10.0, -5.0},
                                       .u = {3.0, 0.0, 0.0},
                                       .v = {0.0, 0.0, 2.0},
                                       .radiance = {1.0, 2.0, 4.0}};
    struct scene_light disc = square, point = square, even = square;
    disc.shape = SCENE_LIGHT_DISC;
    point.shape = SCENE_LIGHT_POINT;
    even.falloff = SCENE_FALLOFF_NONE;
    scene_build_lamp(&build, &square);
    scene_build_lamp(&build, &disc);
    scene_build_lamp(&build, &point);
    scene_build_lamp(&build, &even);
    end_scene(&build);
    return 0;
}

static int clear_scenes(void **state)
{
    (void)state;
    scene_clear(&scene);
    scene_clear(&other_scene);
    scene_clear(&lit_scene);
    return 0;
}

#define PARAMS(...)                                                                                \
    effect_params(.scene = {&scene}, .scene_count = 1, .size = {size[0], size[1]}, __VA_ARGS__)

// ---- names --------------------------------------------------------------------------------------

static void names_are_read(void **state)
{
    (void)state;
    unsigned effects;
    for (unsigned i = 0; i < EFFECT_COUNT; i++) {
        assert_int_equal(effect_parse(NULL, effect_names[i], &effects), WEFT_OK);
        assert_int_equal(effects, 1u << i);
    }
    assert_null(effect_names[EFFECT_COUNT]);
    assert_int_equal(effect_parse(NULL, "dof+antialias+motion-blur+fade+radiosity", &effects),
                     WEFT_OK);
    assert_int_equal(effects, EFFECT_DOF | EFFECT_ANTIALIAS | EFFECT_MOTION_BLUR | EFFECT_FADE |
                                  EFFECT_RADIOSITY);
    static const char *const bad[] = {
        "", "+", "dof+", "+dof", "dof+dof", "Dof", "dof ", "blur", "soft-shadow+radiosity"};
    for (size_t i = 0; i < WEFT_COUNT(bad); i++) {
        struct message message = {.count = 0};
        const struct weft_log log = {keep_message, &message};
        effects = 77;
        assert_int_equal(effect_parse(&log, bad[i], &effects), WEFT_ERR_ARGUMENT);
        assert_int_equal(effects, 0);
        assert_int_equal(message.count, 1);
    }
}

// ---- each dimension alone -----------------------------------------------------------------------

static int compare_points(const void *a, const void *b)
{
    const double *p = a, *q = b;
    return p[0] != q[0] ? (p[0] < q[0] ? -1 : 1) : (p[1] > q[1]) - (p[1] < q[1]);
}

// The same points, in the same order, or in any.
static void assert_same_points(double (*a)[2], double (*b)[2], int count, bool ordered)
{
    if (!ordered) {
        qsort(a, (size_t)count, sizeof *a, compare_points);
        qsort(b, (size_t)count, sizeof *b, compare_points);
    }
    for (int i = 0; i < count; i++)
        if (!(a[i][0] == b[i][0] && a[i][1] == b[i][1]))
            fail_msg("point %d is (%g, %g) instead of (%g, %g)", i, a[i][0], a[i][1], b[i][0],
                     b[i][1]);
}

// Samples of the pixel, in pixels, y down; places on the lens.
static void get_places(const struct effect_plan *plan, bool lens, double (*out)[2])
{
    for (int64_t k = 0; k < plan->count; k++) {
        const struct weft_camera_frame *camera = &plan->frames[k].show.camera;
        out[k][0] = lens ? camera->lens[0] : -camera->move[0];
        out[k][1] = lens ? camera->lens[1] : camera->move[1];
    }
}

static void check_alone(const struct weft_jitter_info *info, int count, bool lens, bool centre)
{
    static double places[MAX_COUNT][2];
    const double aperture = 0.7;
    struct weft_jitter set;
    struct effect_plan plan = plan_made(PARAMS(.effects = lens ? EFFECT_DOF : EFFECT_ANTIALIAS,
                                               .frames = count, .jitter = info, .centre = centre,
                                               .seed = 5, .focus = 10.0, .aperture = aperture));
    assert_int_equal(plan.count, count);
    // The lens's seed is its dimension's.
    assert_int_equal(
        weft_jitter_create(weft_jitter_params(.info = info, .count = count, .seed = lens ? 6 : 5,
                                              .shape = lens ? WEFT_JITTER_DISC : WEFT_JITTER_SQUARE,
                                              .size = lens ? aperture : 1.0, .centre = centre),
                           &set),
        WEFT_OK);
    const struct effect_set *told = &plan.set[lens ? EFFECT_LENS : EFFECT_PIXEL];
    assert_ptr_equal(told->info, info);
    assert_int_equal(told->count, count);
    for (int axis = 0; axis < 2; axis++) {
        assert_near(told->mean[axis], set.mean[axis], 1e-15, "mean");
        assert_true(told->shift[axis] == set.shift[axis]);
    }
    get_places(&plan, lens, places);
    assert_same_points(places, set.points, count, info->extends);
    assert_int_equal(plan.extends, info->extends);
    for (int k = 0; k < count; k++) {
        assert_near(plan.frames[k].weight, 1.0 / count, 1e-15, "weight");
        assert_true(plan.frames[k].weight == plan.frames[0].weight);
        assert_true(plan.frames[k].show.time == 0.5);
        assert_int_equal(plan.frames[k].show.camera.size[0], size[0]);
    }
    weft_jitter_clear(&set);
    effect_plan_clear(&plan);
}

static void a_pixel_or_lens_alone_is_its_set(void **state)
{
    (void)state;
    int checked = 0;
    for (int i = 0; weft_jitter_list[i]; i++) {
        const struct weft_jitter_info *info = weft_jitter_list[i];
        static const int any[] = {1, 2, 7, 64, 0};
        const int *counts = info->counts ? info->counts : any;
        for (int c = 0; counts[c]; c++)
            for (int how = 0; how < 4; how++, checked++)
                check_alone(info, counts[c], how & 1, how & 2);
    }
    assert_true(checked >= 4 * (12 + 6 * 4));
}

// The tables' counts have tables, others Sobol's points, all centred; discrepancies are those of
// the sets (shared/notes: .198 for j8).
static void sets_are_chosen(void **state)
{
    (void)state;
    static const struct {
        int count;
        const char *name;
        double discrepancy;
    } cases[] = {{1, "grid", 0.5},   {2, "j2", 0.5},     {3, "j3", 0.39},    {4, "j4", 0.27},
                 {8, "j8", 0.198},   {15, "j15", 0.151}, {24, "j24", 0.107}, {66, "j66", 0.0577},
                 {16, "sobol", NAN}, {100, "sobol", NAN}};
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct effect_plan plan =
            plan_made(PARAMS(.effects = EFFECT_ANTIALIAS, .frames = cases[i].count));
        const struct effect_set *set = &plan.set[EFFECT_PIXEL];
        assert_string_equal(set->info->name, cases[i].name);
        assert_near(set->mean[0], 0.0, 1e-15, "mean");
        assert_near(set->mean[1], 0.0, 1e-15, "mean");
        assert_true(set->discrepancy > 0.0 && set->discrepancy < 1.0);
        if (!isnan(cases[i].discrepancy))
            assert_near(set->discrepancy, cases[i].discrepancy, 1e-3, cases[i].name);
        effect_plan_clear(&plan);
    }
    // Without centring the shift is told: Sobol's 16 points lie 1/32 too low.
    struct effect_plan plan = plan_made(
        PARAMS(.effects = EFFECT_ANTIALIAS, .frames = 16, .jitter = weft_jitter_find("sobol")));
    assert_near(plan.set[EFFECT_PIXEL].mean[0], -1.0 / 32.0, 1e-15, "mean");
    assert_near(plan.set[EFFECT_PIXEL].mean[1], -1.0 / 32.0, 1e-15, "mean");
    effect_plan_clear(&plan);
}

static int compare_numbers(const void *a, const void *b)
{
    const double p = *(const double *)a, q = *(const double *)b;
    return (p > q) - (p < q);
}

// Midpoints, each once; the first n are about as evenly spread as van der Corput's sequence is,
// whose discrepancy is at most (1 + log2(n)) / n, and 1 / count more for the ranks.
static void check_times(int count)
{
    static double times[MAX_COUNT], first[MAX_COUNT];
    struct effect_plan plan =
        plan_made(PARAMS(.effects = EFFECT_MOTION_BLUR, .frames = count, .time = {0.25, 0.75}));
    assert_true(plan.extends);
    for (int n = 1; n <= count; n++) {
        times[n - 1] = (plan.frames[n - 1].show.time - 0.25) / 0.5;
        memcpy(first, times, (size_t)n * sizeof *first);
        qsort(first, (size_t)n, sizeof *first, compare_numbers);
        double worst = 0.0;
        for (int i = 0; i < n; i++)
            worst = fmax(worst, fmax(first[i] - (double)i / n, (double)(i + 1) / n - first[i]));
        assert_in_range((int)(1e6 * worst), 0, (int)(1e6 * ((1.0 + log2(n)) / n + 1.0 / count)));
    }
    for (int k = 0; k < count; k++)
        assert_near(first[k], (k + 0.5) / count, 1e-14, "time");
    effect_plan_clear(&plan);
}

static void times_are_midpoints_and_spread_from_the_first_on(void **state)
{
    (void)state;
    static const int counts[] = {1, 2, 3, 5, 8, 13, 64, 100, 257};
    for (size_t i = 0; i < WEFT_COUNT(counts); i++)
        check_times(counts[i]);
}

// Of each shutter the weights at the times.
static void times_weigh_what_the_shutter_says(void **state)
{
    (void)state;
    static const char *const shutters[] = {"box", "tent", "gauss", "0.25:0.5", "0:0"};
    for (size_t i = 0; i < WEFT_COUNT(shutters); i++) {
        struct weft_shutter shutter;
        assert_int_equal(weft_shutter_parse(&log_to_stderr, shutters[i], &shutter), WEFT_OK);
        struct effect_plan plan =
            plan_made(PARAMS(.effects = EFFECT_MOTION_BLUR, .frames = 37, .shutter = shutter));
        double all = 0.0, sum = 0.0;
        for (int k = 0; k < 37; k++)
            all += weft_shutter_light(&shutter, plan.frames[k].show.time);
        for (int k = 0; k < 37; k++) {
            assert_near(plan.frames[k].weight,
                        weft_shutter_light(&shutter, plan.frames[k].show.time) / all, 1e-15,
                        shutters[i]);
            sum += plan.frames[k].weight;
        }
        assert_near(sum, 1.0, 37 * 0x1p-53, "sum");
        effect_plan_clear(&plan);
    }
}

// The samples fill the support of the filter and weigh as it says; negative lobes are told.
static void samples_weigh_what_the_filter_says(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double width, support;
        bool negative;
    } cases[] = {{"nearest", 0.0, 1.0, false},      {"nearest", 1.5, 1.5, false},
                 {"linear", 0.0, 2.0, false},       {"linear", 3.0, 3.0, false},
                 {"mitchell", 0.0, 4.0, true},      {"lanczos:3", 0.0, 6.0, true},
                 {"lanczos:3+unit", 0.0, 6.0, true}};
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const struct weft_kernel kernel = kernel_named(cases[i].name);
        struct effect_plan plan =
            plan_made(PARAMS(.effects = EFFECT_ANTIALIAS, .frames = 64, .filter = kernel,
                             .filter_width = cases[i].width));
        assert_true(plan.set[EFFECT_PIXEL].size == cases[i].support);
        const double s = cases[i].width > 0.0 ? cases[i].width / (2.0 * kernel.support) : 1.0;
        double h[64], all = 0.0, farthest = 0.0;
        for (int k = 0; k < 64; k++) {
            const double *move = plan.frames[k].show.camera.move;
            h[k] = weft_kernel_weight(&kernel, move[0] / s) *
                   weft_kernel_weight(&kernel, -move[1] / s);
            all += h[k];
            farthest = fmax(farthest, fmax(fabs(move[0]), fabs(move[1])));
        }
        assert_in_range((int)(1000 * farthest / cases[i].support), 480, 500);
        for (int k = 0; k < 64; k++)
            assert_near(plan.frames[k].weight, h[k] / all, 1e-15, cases[i].name);
        assert_int_equal(plan.weights.negative > 0.0, cases[i].negative);
        effect_plan_clear(&plan);
    }
}

// ---- lamps --------------------------------------------------------------------------------------

static void lamps_are_points_in_the_middle(void **state)
{
    (void)state;
    struct effect_plan plan =
        plan_made(PARAMS(.scene = {&lit_scene}, .effects = EFFECT_ANTIALIAS, .frames = 1));
    const struct scene_frame *show = &plan.frames[0].show;
    static const double scale[] = {6.0, 6.0 * M_PI_4, 1.0, 1.0};
    assert_int_equal(show->light_count, 4);
    for (int i = 0; i < 4; i++) {
        const struct scene_light *lamp = &lit_scene.lights[i];
        const struct scene_point_light *light = &show->light[i];
        assert_true(light->shadowed);
        assert_int_equal(light->falloff, lamp->falloff);
        for (int axis = 0; axis < 3; axis++) {
            assert_true(light->position[axis] == lamp->middle[axis]);
            assert_near(light->intensity[axis], scale[i] * lamp->radiance[axis], 1e-14, "W / sr");
            // u x v is -y; a point shines all around.
            const double normal = axis == 1 && i != 2 ? -1.0 : 0.0;
            assert_near(light->normal[axis], normal, 1e-15, "normal");
        }
    }
    effect_plan_clear(&plan);
}

// The first lamp's places are the set's, in its order; those of others are other permutations of
// theirs. The point stays.
static void lamps_have_sets_of_their_own(void **state)
{
    (void)state;
    enum { N = 64 };
    static double place[4][N][2];
    const struct weft_jitter_info *halton = weft_jitter_find("halton");
    struct effect_plan plan = plan_made(PARAMS(.scene = {&lit_scene}, .effects = EFFECT_SOFT_SHADOW,
                                               .frames = N, .jitter = halton));
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < N; k++) {
            const double *p = plan.frames[k].show.light[i].position;
            place[i][k][0] = (p[0] - 1.0) / 3.0;
            place[i][k][1] = (p[2] + 5.0) / 2.0;
            assert_true(p[1] == 10.0);
        }
    for (int i = 0; i < 4; i++) {
        struct weft_jitter set;
        const bool disc = i == 1;
        assert_int_equal(weft_jitter_create(weft_jitter_params(.info = halton, .count = N,
                                                               .shape = disc ? WEFT_JITTER_DISC
                                                                             : WEFT_JITTER_SQUARE),
                                            &set),
                         WEFT_OK);
        int same = 0;
        double error = 0.0;
        for (int k = 0; k < N; k++)
            same +=
                hypot(place[i][k][0] - set.points[k][0], place[i][k][1] - set.points[k][1]) < 1e-12;
        if (i == 2) {
            assert_int_equal(same, 0);
        } else {
            assert_int_equal(same == N, i == 0);
            qsort(place[i], N, sizeof *place[i], compare_points);
            qsort(set.points, N, sizeof *set.points, compare_points);
            for (int k = 0; k < N; k++)
                error = larger(error, hypot(place[i][k][0] - set.points[k][0],
                                            place[i][k][1] - set.points[k][1]));
            assert_near(error, 0.0, 1e-14, "places");
        }
        weft_jitter_clear(&set);
    }
    assert_int_equal(plan.set[EFFECT_LAMP].shape, WEFT_JITTER_SQUARE);
    assert_int_equal(plan.set[EFFECT_LAMP].count, N);
    effect_plan_clear(&plan);
}

// ---- several dimensions -------------------------------------------------------------------------

static double find_correlation(const double (*pairs)[2], int count)
{
    double mean[2] = {0.0, 0.0}, square[2] = {0.0, 0.0}, product = 0.0;
    for (int k = 0; k < count; k++)
        for (int axis = 0; axis < 2; axis++)
            mean[axis] += pairs[k][axis] / count;
    for (int k = 0; k < count; k++) {
        const double a = pairs[k][0] - mean[0], b = pairs[k][1] - mean[1];
        square[0] += a * a;
        square[1] += b * b;
        product += a * b;
    }
    return product / sqrt(square[0] * square[1]);
}

// Pairs of place in the pixel and time, in the unit square about 0.
static void get_pairs(const struct effect_plan *plan, int axis, double (*out)[2])
{
    for (int64_t k = 0; k < plan->count; k++) {
        const double *move = plan->frames[k].show.camera.move;
        out[k][0] = axis == 0 ? -move[0] : move[1];
        out[k][1] = plan->frames[k].show.time - 0.5;
    }
}

static double find_discrepancy(double (*pairs)[2], int count)
{
    struct weft_discrepancy discrepancy;
    assert_int_equal(
        weft_discrepancy_compute(
            weft_discrepancy_params(.points = (const double(*)[2])pairs, .count = count),
            &discrepancy),
        WEFT_OK);
    return discrepancy.value;
}

// Hammersley's first coordinate is (k + 1/2) / N, as times are: joined one by one, an edge that
// moves along x would be where it was or not at all. Permuted, the pairs fill the square as so
// many random ones do: correlations have the mean 0 and the variance 1 / (N - 1) over seeds.
static void pixel_and_time_do_not_go_together(void **state)
{
    (void)state;
    enum { SEEDS = 64 };
    static double pairs[1024][2];
    static const int counts[] = {16, 64, 256};
    for (size_t c = 0; c < WEFT_COUNT(counts); c++) {
        const int n = counts[c];
        for (int k = 0; k < n; k++)
            pairs[k][0] = pairs[k][1] = (k + 0.5) / n - 0.5;
        const double unpermuted = find_discrepancy(pairs, n);
        double squares = 0.0, worst = 0.0;
        for (uint64_t seed = 0; seed < SEEDS; seed++) {
            struct effect_plan plan =
                plan_made(PARAMS(.effects = EFFECT_ANTIALIAS | EFFECT_MOTION_BLUR, .frames = n,
                                 .jitter = weft_jitter_find("hammersley"), .seed = seed));
            for (int axis = 0; axis < 2; axis++) {
                get_pairs(&plan, axis, pairs);
                const double r = find_correlation((const double(*)[2])pairs, n);
                squares += r * r;
                // 2 SEEDS of them, about normal: beyond 4.5 deviations is 1 in 100,000.
                assert_true(fabs(r) <= 4.5 / sqrt(n - 1.0));
                if (seed < 8)
                    worst = fmax(worst, find_discrepancy(pairs, n));
            }
            effect_plan_clear(&plan);
        }
        // The mean of 128 squares, each of variance 2 / (N - 1)^2: 1 +- 5 deviations.
        assert_near(squares / (2 * SEEDS) * (n - 1), 1.0, 5.0 * sqrt(2.0 / (2 * SEEDS)),
                    "mean square of correlations");
        print_message("N = %d: half-plane discrepancy of pixel and time %.3f at worst, one by one "
                      "%.3f\n",
                      n, worst, unpermuted);
        assert_true(worst < 0.75 * unpermuted);
    }
}

// Each dimension of several is still its set, and the first one keeps its order.
static void several_dimensions_are_each_their_set(void **state)
{
    (void)state;
    enum { N = 100 };
    static double places[N][2];
    double times[N];
    struct effect_plan plan = plan_made(
        PARAMS(.scene = {&lit_scene},
               .effects = EFFECT_ANTIALIAS | EFFECT_DOF | EFFECT_MOTION_BLUR | EFFECT_SOFT_SHADOW,
               .frames = N, .jitter = weft_jitter_find("r2"), .focus = 9.0, .aperture = 0.5,
               .seed = 3));
    for (int lens = 0; lens < 2; lens++) {
        struct weft_jitter set;
        assert_int_equal(
            weft_jitter_create(
                weft_jitter_params(.info = weft_jitter_find("r2"), .count = N,
                                   .shape = lens ? WEFT_JITTER_DISC : WEFT_JITTER_SQUARE,
                                   .size = lens ? 0.5 : 1.0),
                &set),
            WEFT_OK);
        get_places(&plan, lens, places);
        assert_same_points(places, set.points, N, !lens);
        weft_jitter_clear(&set);
    }
    for (int k = 0; k < N; k++) {
        times[k] = plan.frames[k].show.time;
        assert_true(plan.frames[k].show.camera.focus == 9.0);
    }
    qsort(times, N, sizeof *times, compare_numbers);
    for (int k = 0; k < N; k++)
        assert_near(times[k], (k + 0.5) / N, 1e-14, "time");
    assert_true(plan.extends);
    effect_plan_clear(&plan);
}

static void weights_of_several_multiply(void **state)
{
    (void)state;
    struct weft_shutter tent = WEFT_SHUTTER_TENT;
    const struct weft_kernel kernel = kernel_named("mitchell");
    struct effect_plan plan = plan_made(PARAMS(.effects = EFFECT_ANTIALIAS | EFFECT_MOTION_BLUR,
                                               .frames = 256, .filter = kernel, .shutter = tent));
    double all = 0.0, sum = 0.0;
    for (int pass = 0; pass < 2; pass++)
        for (int k = 0; k < 256; k++) {
            const struct effect_frame *frame = &plan.frames[k];
            const double w = weft_kernel_weight(&kernel, frame->show.camera.move[0]) *
                             weft_kernel_weight(&kernel, -frame->show.camera.move[1]) *
                             weft_shutter_light(&tent, frame->show.time);
            if (pass == 0) {
                all += w;
            } else {
                assert_near(frame->weight, w / all, 1e-15, "weight");
                sum += frame->weight;
            }
        }
    assert_near(sum, 1.0, 1e-14, "sum");
    assert_true(plan.weights.negative > 0.0 && plan.weights.gain > 1.0);
    effect_plan_clear(&plan);
}

static void seeds_give_other_orders_of_the_same(void **state)
{
    (void)state;
    struct effect_plan plan[3];
    for (int i = 0; i < 3; i++)
        plan[i] =
            plan_made(PARAMS(.scene = {&lit_scene},
                             .effects = EFFECT_ANTIALIAS | EFFECT_DOF | EFFECT_MOTION_BLUR |
                                        EFFECT_SOFT_SHADOW,
                             .frames = 64, .focus = 9.0, .aperture = 0.5, .seed = i == 2 ? 8 : 7));
    assert_true(is_same(&plan[0], &plan[1]));
    assert_false(is_same(&plan[0], &plan[2]));
    for (int i = 0; i < 3; i++)
        effect_plan_clear(&plan[i]);
}

// The first numbers of SplitMix64, of the seed 0 and its first number as the seed, make this
// permutation on every machine.
static void permutations_are_the_same_everywhere(void **state)
{
    (void)state;
    enum { N = 8 };
    int order[N];
    bool seen[N] = {false};
    // By hand: Fisher and Yates with the numbers of the reference implementation.
    uint64_t seed = 0, start = 0;
    start = random_next(&seed) + EFFECT_BY_TIME;
    int expected[N] = {0, 1, 2, 3, 4, 5, 6, 7};
    for (int i = N - 1; i > 0; i--) {
        const int j = (int)(random_next(&start) % (uint64_t)(i + 1)), at = expected[i];
        expected[i] = expected[j];
        expected[j] = at;
    }
    effect_order_make(EFFECT_ORDER_PERMUTED, 0, EFFECT_BY_TIME, N, order);
    for (int i = 0; i < N; i++) {
        assert_int_equal(order[i], expected[i]);
        assert_false(seen[order[i]]);
        seen[order[i]] = true;
    }
    // Mirrored in three bits, 0 to 5 are 0, 4, 2, 6, 1, 5.
    static const int spread[] = {0, 3, 2, 5, 1, 4};
    int got[6];
    effect_order_make(EFFECT_ORDER_SPREAD, 0, EFFECT_BY_TIME, 6, got);
    for (int i = 0; i < 6; i++)
        assert_int_equal(got[i], spread[i]);
}

// ---- fades --------------------------------------------------------------------------------------

static void a_fade_is_its_weights(void **state)
{
    (void)state;
    struct effect_plan plan =
        plan_made(effect_params(.effects = EFFECT_FADE | EFFECT_ANTIALIAS,
                                .scene = {&scene, &other_scene, &lit_scene}, .scene_count = 3,
                                .fade = {1.0, 0.0, 3.0}, .size = {size[0], size[1]}, .frames = 24,
                                .filter = kernel_named("mitchell"), .shutter = WEFT_SHUTTER_BOX,
                                .time = {0.0, 1.0}));
    double sum[3] = {0.0, 0.0, 0.0};
    assert_int_equal(plan.count, 48);
    for (int k = 0; k < 48; k++) {
        sum[plan.frames[k].scene] += plan.frames[k].weight;
        assert_int_equal(plan.frames[k].scene, k % 2 ? 2 : 0);
    }
    assert_near(sum[0], 0.25, 1e-15, "first scene");
    assert_near(sum[1], 0.0, 0.0, "scene of weight 0");
    assert_near(sum[2], 0.75, 1e-15, "third scene");
    effect_plan_clear(&plan);
    // Alone, one frame each; no weights are even ones.
    plan = plan_made(effect_params(.effects = EFFECT_FADE, .scene = {&scene, &other_scene},
                                   .scene_count = 2, .size = {size[0], size[1]}));
    assert_int_equal(plan.count, 2);
    assert_true(plan.frames[0].weight == 0.5 && plan.frames[1].weight == 0.5);
    effect_plan_clear(&plan);
}

// ---- counts -------------------------------------------------------------------------------------

static struct effect_need need_of(const struct effect_plan *plan, unsigned effect)
{
    for (int i = 0; i < EFFECT_COUNT; i++)
        if (1u << i == effect)
            return plan->need[i];
    return (struct effect_need){0};
}

// A square that moves 37.5 pixels along x, at 24 units, where a unit is a pixel.
static void motion_asks_for_a_frame_a_pixel(void **state)
{
    (void)state;
    struct scene moving;
    struct scene_build build = empty_scene(&moving, size);
    const double middle[2] = {-10.0, 0.0}, half[2] = {4.0, 4.0};
    add_rectangle(&build, add_colour(&build, 1.0f, 1.0f, 1.0f), 24.0, middle, half, 0.0);
    move_last(&build, 37.5, 0.0);
    end_scene(&build);
    struct effect_plan plan =
        plan_made(PARAMS(.scene = {&moving}, .effects = EFFECT_MOTION_BLUR | EFFECT_ANTIALIAS));
    const struct effect_need need = need_of(&plan, EFFECT_MOTION_BLUR);
    assert_near(need.figure, 37.5, 0.5, "pixels");
    assert_int_equal(need.frames, (int64_t)ceil(need.figure));
    assert_int_equal(plan.count, need.frames);
    assert_int_equal(plan.needed, need.frames);
    assert_int_equal(need_of(&plan, EFFECT_ANTIALIAS).frames, EFFECT_FRAMES_ANTIALIAS);
    assert_int_equal(need_of(&plan, EFFECT_DOF).frames, 0);
    effect_plan_clear(&plan);
    // Half the time, half the way: anti-aliasing asks for more then.
    plan = plan_made(PARAMS(.scene = {&moving}, .time = {0.0, 0.25},
                            .effects = EFFECT_MOTION_BLUR | EFFECT_ANTIALIAS));
    assert_near(need_of(&plan, EFFECT_MOTION_BLUR).figure, 37.5 / 4, 0.5, "pixels");
    assert_int_equal(plan.count, EFFECT_FRAMES_ANTIALIAS);
    effect_plan_clear(&plan);
    scene_clear(&moving);
}

// 16 samples to a pixel's area of the filter.
static void wide_filters_ask_for_more(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double width;
        int count;
    } cases[] = {{"nearest", 0.0, 16}, {"nearest", 0.5, 16},   {"linear", 0.0, 64},
                 {"linear", 1.5, 36},  {"mitchell", 0.0, 256}, {"lanczos:3", 0.0, 576}};
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct effect_plan plan =
            plan_made(PARAMS(.effects = EFFECT_ANTIALIAS, .filter = kernel_named(cases[i].name),
                             .filter_width = cases[i].width));
        assert_int_equal(plan.count, cases[i].count);
        effect_plan_clear(&plan);
    }
}

// A quad at depth 24, focused at 8 or at 30 through a lens of diameter 2: c = A |1/f - 1/z| H / 2.
static void circles_ask_for_their_area(void **state)
{
    (void)state;
    static const double focus[] = {8.0, 30.0};
    for (int i = 0; i < 2; i++) {
        struct effect_plan plan = plan_made(PARAMS(.scene = {&lit_scene}, .effects = EFFECT_DOF,
                                                   .focus = focus[i], .aperture = 2.0));
        const double circle = 2.0 * fabs(1.0 / focus[i] - 1.0 / 24.0) * size[1] / 2.0;
        const struct effect_need need = need_of(&plan, EFFECT_DOF);
        assert_near(need.figure, circle, 1e-9, "circle");
        assert_int_equal(need.frames, weft_frames_for_circle(need.figure));
        assert_int_equal(plan.count, need.frames);
        assert_near(plan.focus, focus[i], 0.0, "focus");
        effect_plan_clear(&plan);
    }
    // Unasked: at the target, a twentieth.
    struct effect_plan plan = plan_made(PARAMS(.scene = {&lit_scene}, .effects = EFFECT_DOF));
    assert_near(plan.focus, 1.0, 1e-15, "focus");
    assert_near(plan.aperture, 0.05, 1e-15, "aperture");
    effect_plan_clear(&plan);
    // A pinhole: one frame, in the middle.
    plan = plan_made(
        PARAMS(.scene = {&lit_scene}, .effects = EFFECT_DOF, .focus = 8.0, .aperture = 0.0));
    assert_int_equal(plan.count, 1);
    assert_true(plan.frames[0].show.camera.lens[0] == 0.0);
    assert_null(plan.set[EFFECT_LENS].info);
    effect_plan_clear(&plan);
}

static void counts_fit_the_set_and_the_cap(void **state)
{
    (void)state;
    static const struct {
        const char *jitter;
        double aperture; // of a circle of 2 A pixels
        int count;
        bool warns;
    } cases[] = {
        {"j8", 1.0, 8, false},    {"j8", 4.0, 8, true},
        {"msaa", 0.5, 1, false},  {"msaa", 0.9, 4, false},
        {"msaa", 2.0, 16, false}, {"msaa", 4.0, 16, true},
        {NULL, 4.0, 51, false},   {NULL, 40.0, EFFECT_MOST_AUTO, true},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct message message = {.count = 0};
        const struct weft_log log = {keep_message, &message};
        struct effect_plan plan = plan_made(
            PARAMS(.scene = {&lit_scene}, .effects = EFFECT_DOF, .focus = 8.0, .log = &log,
                   .aperture = cases[i].aperture, .jitter = weft_jitter_find(cases[i].jitter)));
        assert_int_equal(plan.count, cases[i].count);
        assert_int_equal(message.count, cases[i].warns);
        assert_int_equal(plan.needed > plan.count, cases[i].warns);
        effect_plan_clear(&plan);
    }
}

// ---- what is refused ----------------------------------------------------------------------------

static void assert_refused(const struct effect_params *good, enum weft_result expected,
                           const char *text)
{
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    struct effect_params params = *good;
    struct effect_plan plan = {.count = 5};
    params.log = &log;
    const enum weft_result res = effect_plan_make(&params, &plan);
    if (res != expected || message.count != 1 || !strstr(message.text, text))
        fail_msg("result %d, %d lines, '%s' instead of %d, '%s'", res, message.count, message.text,
                 expected, text);
    assert_null(plan.frames);
    assert_int_equal(plan.count, 0);
}

static void what_is_wrong_is_named(void **state)
{
    (void)state;
    const enum weft_result argument = WEFT_ERR_ARGUMENT;
    const struct weft_jitter_info *j8 = weft_jitter_find("j8");
#define REFUSED(text, ...) assert_refused(PARAMS(__VA_ARGS__), argument, text)
    REFUSED("no effects", .effects = 0);
    REFUSED("no effects", .effects = 64);
    REFUSED("radiosity", .effects = EFFECT_RADIOSITY | EFFECT_SOFT_SHADOW);
    REFUSED("number of scenes", .effects = EFFECT_FADE);
    REFUSED("number of scenes", .effects = EFFECT_DOF, .scene_count = 2);
    REFUSED("scene 1 is missing", .effects = EFFECT_DOF, .scene = {NULL});
    REFUSED("scene 2 is missing", .effects = EFFECT_FADE, .scene_count = 2);
    REFUSED("weight of a scene", .effects = EFFECT_FADE, .scene_count = 2,
            .scene = {&scene, &scene}, .fade = {1.0, NAN});
    REFUSED("add up to", .effects = EFFECT_FADE, .scene_count = 2, .scene = {&scene, &scene},
            .fade = {1.0, -1.0});
    REFUSED("side of the picture", .effects = EFFECT_ANTIALIAS, .size = {0, 5});
    REFUSED("number of frames", .effects = EFFECT_ANTIALIAS, .frames = -1);
    REFUSED("shutter is open from", .effects = EFFECT_MOTION_BLUR, .time = {0.5, 0.25});
    REFUSED("shutter is open from", .effects = EFFECT_MOTION_BLUR, .time = {0.5, 1.5});
    REFUSED("shutter is open from", .effects = EFFECT_MOTION_BLUR, .time = {NAN, 1.0});
    REFUSED("shutter", .effects = EFFECT_MOTION_BLUR, .shutter = {.open = 0.5, .close = 0.25});
    REFUSED("plane in focus is at 0.25", .effects = EFFECT_DOF, .focus = 0.25);
    REFUSED("plane in focus is at -3", .effects = EFFECT_DOF, .focus = -3.0);
    REFUSED("plane in focus is at inf", .effects = EFFECT_DOF, .focus = INFINITY);
    REFUSED("aperture is -1", .effects = EFFECT_DOF, .focus = 5.0, .aperture = -1.0);
    REFUSED("aperture is inf", .effects = EFFECT_DOF, .focus = 5.0, .aperture = INFINITY);
    REFUSED("clamp", .effects = EFFECT_RADIOSITY, .clamp = -1.0);
    REFUSED("clamp", .effects = EFFECT_RADIOSITY, .clamp = -1.0);
    REFUSED("no square or round lamp", .effects = EFFECT_SOFT_SHADOW);
    REFUSED("j8 has 8 points, not 9", .effects = EFFECT_ANTIALIAS, .jitter = j8, .frames = 9);
    REFUSED("derivative", .effects = EFFECT_ANTIALIAS, .filter = kernel_named("d-catmull-rom"));
    REFUSED("pixels wide", .effects = EFFECT_ANTIALIAS, .filter = kernel_named("linear"),
            .filter_width = 1e9, .frames = 8);
    assert_refused(PARAMS(.effects = EFFECT_ANTIALIAS, .filter = kernel_named("lanczos:3+radial")),
                   WEFT_ERR_UNSUPPORTED, "radial");
    assert_refused(PARAMS(.effects = EFFECT_MOTION_BLUR, .frames = EFFECT_MAX_FRAMES + 1),
                   WEFT_ERR_LIMIT, "131072");
    assert_refused(PARAMS(.effects = EFFECT_MOTION_BLUR | EFFECT_FADE, .scene_count = 2,
                          .scene = {&scene, &scene}, .frames = EFFECT_MAX_FRAMES),
                   WEFT_ERR_LIMIT, "131072");
#undef REFUSED
    effect_plan_clear(NULL);
}

// Each allocation fails once: of sets, orders, frames, virtual lights, a fade's turns.
static void memory_that_runs_out_is_told(void **state)
{
    (void)state;
    struct scene cornell;
    assert_int_equal(
        scene_make(scene_params(.name = "cornell", .size = {64, 48}, .log = &log_to_stderr),
                   &cornell),
        WEFT_OK);
    for (int i = 0; i < 2; i++) {
        const struct effect_params *params =
            effect_params(.effects = EFFECT_FADE | EFFECT_ANTIALIAS | EFFECT_DOF |
                                     EFFECT_MOTION_BLUR |
                                     (i ? EFFECT_RADIOSITY : EFFECT_SOFT_SHADOW),
                          .scene = {&cornell, &cornell}, .scene_count = 2, .size = {64, 48},
                          .frames = 24);
        unsigned long failed = 0;
        enum weft_result res = WEFT_ERR_MEMORY;
        for (bool struck = true; struck; failed += struck) {
            struct effect_plan plan = {.count = 5};
            alloc_fail_at(failed + 1);
            res = effect_plan_make(params, &plan);
            struck = alloc_fail_struck();
            alloc_fail_at(0);
            assert_int_equal(res, struck ? WEFT_ERR_MEMORY : WEFT_OK);
            assert_int_equal(plan.frames == NULL, struck);
            effect_plan_clear(&plan);
        }
        print_message("%lu allocations failed\n", failed);
        assert_true(failed > 20);
    }
    scene_clear(&cornell);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_are_read),
        cmocka_unit_test(a_pixel_or_lens_alone_is_its_set),
        cmocka_unit_test(sets_are_chosen),
        cmocka_unit_test(times_are_midpoints_and_spread_from_the_first_on),
        cmocka_unit_test(times_weigh_what_the_shutter_says),
        cmocka_unit_test(samples_weigh_what_the_filter_says),
        cmocka_unit_test(lamps_are_points_in_the_middle),
        cmocka_unit_test(lamps_have_sets_of_their_own),
        cmocka_unit_test(pixel_and_time_do_not_go_together),
        cmocka_unit_test(several_dimensions_are_each_their_set),
        cmocka_unit_test(weights_of_several_multiply),
        cmocka_unit_test(seeds_give_other_orders_of_the_same),
        cmocka_unit_test(permutations_are_the_same_everywhere),
        cmocka_unit_test(a_fade_is_its_weights),
        cmocka_unit_test(motion_asks_for_a_frame_a_pixel),
        cmocka_unit_test(wide_filters_ask_for_more),
        cmocka_unit_test(circles_ask_for_their_area),
        cmocka_unit_test(counts_fit_the_set_and_the_cap),
        cmocka_unit_test(what_is_wrong_is_named),
        cmocka_unit_test(memory_that_runs_out_is_told),
    };
    return cmocka_run_group_tests(tests, make_scenes, clear_scenes);
}
