// SPDX-License-Identifier: BSD-3-Clause
// passes/resample/resample.h as a C program calls it: planes with strides in, planes out.
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
#include "tests/support/plans.h"
#include "weft.h"

// ---- images -------------------------------------------------------------------------------------

enum { MAX_CHANNELS = WEFT_RESAMPLE_MAX_CHANNELS, PADDING = 3 };

// Planes whose rows lie PADDING floats apart, which hold a NAN with a payload.
struct picture {
    int width, height, channels;
    int64_t stride;
    float *plane[MAX_CHANNELS];
};

static const uint32_t untouched = 0x7fc12345;

static struct picture make_picture(int width, int height, int channels)
{
    struct picture p = {width, height, channels, width + PADDING, {NULL}};
    for (int c = 0; c < channels; c++) {
        p.plane[c] = malloc((size_t)p.stride * (size_t)height * sizeof(float));
        assert_non_null(p.plane[c]);
        for (int64_t i = 0; i < p.stride * height; i++)
            memcpy(&p.plane[c][i], &untouched, sizeof untouched);
    }
    return p;
}

static void clear_picture(struct picture *p)
{
    for (int c = 0; c < MAX_CHANNELS; c++)
        free(p->plane[c]);
    *p = (struct picture){0};
}

static bool padding_is_untouched(const struct picture *p)
{
    bool same = true;
    for (int c = 0; c < p->channels; c++)
        for (int y = 0; y < p->height; y++)
            for (int64_t x = p->width; x < p->stride; x++)
                same = same &&
                       memcmp(&p->plane[c][y * p->stride + x], &untouched, sizeof untouched) == 0;
    return same;
}

// A repeatable value in [-1, 1] for every number: the hardest signal for interpolation.
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
        for (int y = 0; y < height; y++)
            for (int x = 0; x < width; x++)
                p.plane[c][y * p.stride + x] =
                    (float)(3.0 * noise((uint32_t)((c * 4099 + y) * 8209 + x)) + c);
    return p;
}

// ---- the truth ----------------------------------------------------------------------------------

static double clamped_sample(const struct picture *p, int c, int64_t x, int64_t y)
{
    x = x < 0 ? 0 : x >= p->width ? p->width - 1 : x;
    y = y < 0 ? 0 : y >= p->height ? p->height - 1 : y;
    return (double)p->plane[c][y * p->stride + x];
}

struct channel {
    const struct picture *picture;
    int c;
};

static double fetch(void *priv, const int64_t index[3])
{
    const struct channel *channel = priv;
    return clamped_sample(channel->picture, channel->c, index[0], index[1]);
}

// Of prefiltered kernels the cardinal spline over the samples, cut off at 2^-40.
static double cardinal(const struct weft_kernel *kernel, const struct picture *p, int c,
                       const double at[2])
{
    struct weft_prefilter prefilter;
    double weights[2][WEFT_PREFILTER_MAX_WEIGHTS], sum = 0.0;
    int64_t first[2];
    assert_int_equal(weft_prefilter_compute(NULL, kernel, &prefilter), WEFT_OK);
    const int overlap = weft_prefilter_overlap(&prefilter, 0x1p-40);
    const int count = kernel->width + 2 * overlap;
    for (int a = 0; a < 2; a++)
        first[a] = weft_prefilter_weights(&prefilter, kernel, overlap, at[a], weights[a]);
    for (int j = 0; j < count; j++)
        for (int i = 0; i < count; i++)
            sum += weights[0][i] * weights[1][j] * clamped_sample(p, c, first[0] + i, first[1] + j);
    return sum;
}

static double truth(const struct weft_resample_info *info, const struct picture *p, int c,
                    const double at[2])
{
    double room[1000];
    const struct weft_kernel *kernel = &info->kernel;
    struct channel channel = {p, c};
    const bool stretched = info->stretch[0] > 1.0 || info->stretch[1] > 1.0;
    return stretched ? weft_reference_compute_stretched(kernel, info->stretch, 2, at, room, fetch,
                                                        &channel)
                           .value
           : kernel->prefiltered ? cardinal(kernel, p, c, at)
                                 : weft_reference_compute(kernel, 2, at, fetch, &channel).value;
}

// Largest error over all pixels of all channels (every `step`th of them); NAN where one is not
// finite.
static double largest_error(const struct weft_resample_info *info, const struct picture *samples,
                            const struct picture *pixels, int step)
{
    double largest = 0.0;
    int checked = 0;
    for (int c = 0; c < pixels->channels; c++)
        for (int i = 0; i < pixels->width * pixels->height; i += step, checked++) {
            const int x = i % pixels->width, y = i / pixels->width;
            const struct weft_window_map *m = info->map;
            const double at[2] = {
                ((double)(x + m[0].pixel) + 0.5) * (double)m[0].from / (double)m[0].to - 0.5 +
                    (double)m[0].sample,
                ((double)(y + m[1].pixel) + 0.5) * (double)m[1].from / (double)m[1].to - 0.5 +
                    (double)m[1].sample};
            const double value = (double)pixels->plane[c][y * pixels->stride + x];
            largest = larger(largest, fabs(value - truth(info, samples, c, at)));
        }
    assert_true(checked > 0);
    return largest;
}

// ---- plans of passes ----------------------------------------------------------------------------

struct pass_case {
    const char *kernel, *profile;
    enum weft_technique technique;
    int channels;
};

// Each is planned once.
static struct {
    struct pass_case of;
    weft_pass_plan *plan;
} made[16];

static weft_pass_plan *passes_of(const struct pass_case *p)
{
    size_t i = 0;
    while (made[i].plan &&
           (strcmp(made[i].of.kernel, p->kernel) != 0 ||
            strcmp(made[i].of.profile, p->profile) != 0 || made[i].of.technique != p->technique ||
            made[i].of.channels != p->channels))
        assert_true(++i < WEFT_COUNT(made));
    made[i].of = *p;
    if (!made[i].plan)
        made[i].plan = make_plan(weft_pass_plan_params(.kernel = kernel_named(p->kernel),
                                                       .profile = profile_named(p->profile),
                                                       .technique = p->technique,
                                                       .channels = p->channels, .samples = 16));
    return made[i].plan;
}

static int destroy_all(void **state)
{
    for (size_t i = 0; i < WEFT_COUNT(made); i++)
        weft_pass_plan_destroy(&made[i].plan);
    return destroy_contexts(state);
}

// ---- requests -----------------------------------------------------------------------------------

// One resampling with all that it takes.
struct work {
    struct picture samples, pixels;
    weft_resample_plan *plan;
    weft_resample_source *source;
    weft_resample_compiled *compiled;
    struct weft_resample_report report;
};

static void make_source(struct work *w, const struct weft_kernel *kernel)
{
    struct weft_resample_source_params *params =
        weft_resample_source_params(.kernel = *kernel, .width = w->samples.width,
                                    .height = w->samples.height, .channels = w->samples.channels,
                                    .stride = w->samples.stride, .log = &log_to_stderr);
    memcpy(params->plane, w->samples.plane, sizeof params->plane);
    assert_int_equal(weft_resample_source_create(params, &w->source), WEFT_OK);
}

static enum weft_result run_to(struct work *w, const struct picture *pixels,
                               const struct weft_progress *progress)
{
    struct weft_resample_run_params params = {
        .source = w->source, .stride = pixels->stride, .progress = progress, .log = &log_to_stderr};
    memcpy(params.plane, pixels->plane, sizeof params.plane);
    return weft_resample_run(w->compiled, &params, &w->report);
}

struct shape {
    const char *what;
    int size[2], width, height;
    struct weft_window_map map[2]; // all 0: plain
};

// Plans and compiles.
static struct work prepare(weft_context *context, const struct weft_kernel *kernel,
                           weft_pass_plan *passes, const struct shape *s, int channels)
{
    struct work w = {.samples = make_samples(s->size[0], s->size[1], channels),
                     .pixels = make_picture(s->width, s->height, channels)};
    const struct weft_resample_params *params =
        weft_resample_params(.passes = passes, .kernel = *kernel, .size = {s->size[0], s->size[1]},
                             .width = s->width, .height = s->height, .map = {s->map[0], s->map[1]},
                             .unstretched = passes || kernel->prefiltered, .log = &log_to_stderr);
    assert_int_equal(weft_resample_plan_create(params, &w.plan), WEFT_OK);
    assert_int_equal(weft_resample_compile(w.plan, weft_resample_compile_params(.context = context),
                                           &w.compiled),
                     WEFT_OK);
    make_source(&w, kernel);
    return w;
}

static struct work resample(weft_context *context, const struct weft_kernel *kernel,
                            weft_pass_plan *passes, const struct shape *s, int channels)
{
    struct work w = prepare(context, kernel, passes, s, channels);
    assert_int_equal(run_to(&w, &w.pixels, NULL), WEFT_OK);
    return w;
}

static void clear(struct work *w)
{
    weft_resample_compiled_destroy(&w->compiled);
    weft_resample_source_destroy(&w->source);
    weft_resample_plan_destroy(&w->plan);
    clear_picture(&w->samples);
    clear_picture(&w->pixels);
}

static double bound_of(const struct work *w)
{
    const struct weft_resample_statistics *s =
        &weft_resample_source_get_info(w->source)->statistics;
    const double any = weft_resample_bound(w->plan, s, 0.0).total;
    const double known =
        weft_resample_bound(w->plan, s, weft_statistics_magnitude(&w->report.pixels)).total;
    assert_true(known > 0.0 && known <= any * (1.0 + 1e-12));
    return known;
}

// Returns the error as a part of the plan's bound.
static double assert_right(const struct work *w, const char *what, int step)
{
    const struct weft_resample_info *info = weft_resample_plan_get_info(w->plan);
    const double error = largest_error(info, &w->samples, &w->pixels, step), bound = bound_of(w);
    if (!(error <= bound))
        fail_msg("%s: error %.3g, bound %.3g", what, error, bound);
    assert_true(padding_is_untouched(&w->pixels));
    assert_int_equal(w->report.pixels.not_finite, 0);
    assert_int_equal(w->report.pixels.count, (uint64_t)w->pixels.width *
                                                 (uint64_t)w->pixels.height *
                                                 (uint64_t)w->pixels.channels);
    return error / bound;
}

static const struct shape shapes[] = {
    {"up", {13, 9}, 41, 30, {{0}}},
    {"down", {41, 30}, 13, 9, {{0}}},
    {"the same size", {17, 12}, 17, 12, {{0}}},
    {"up along one axis, down along the other", {12, 40}, 50, 11, {{0}}},
    {"one sample", {1, 1}, 6, 5, {{0}}},
    {"one pixel", {8, 7}, 1, 1, {{0}}},
    {"a data window inside", {11, 8}, 26, 20, {{20, 47, 9, -4}, {16, 39, 4, -2}}},
    {"overscan", {20, 18}, 37, 33, {{16, 29, -4, 2}, {14, 25, -5, 3}}},
    {"far from the samples", {6, 5}, 7, 6, {{10, 10, -40, 0}, {10, 10, 90, 0}}},
};

// ---- separable ----------------------------------------------------------------------------------

static void separable_meets_the_reference(void **state)
{
    static const char *const kernels[] = {"nearest",  "linear",    "catmull-rom", "lanczos:3",
                                          "bspline3", "bspline3i", "bspline5i"};
    (void)state;
    int runs = 0;
    for (int k = 0; k < 2 && contexts[k]; k++)
        for (size_t i = 0; i < WEFT_COUNT(kernels); i++)
            for (size_t s = 0; s < (k ? 1 : WEFT_COUNT(shapes)); s++, runs++) {
                const struct weft_kernel kernel = kernel_named(kernels[i]);
                struct work w =
                    resample(contexts[k], &kernel, NULL, &shapes[s], 1 + runs % MAX_CHANNELS);
                assert_right(&w, shapes[s].what, kernel.prefiltered ? 29 : 1);
                assert_int_equal(w.report.work.tile_bytes, 0);
                const double fetches = weft_resample_plan_get_info(w.plan)->fetches;
                assert_true(fetches > 0.0 && fetches == w.report.work.fetches_per_pixel);
                assert_true(w.report.work.draws >= 2 * w.samples.channels);
                clear(&w);
            }
    assert_true(runs >= (int)(WEFT_COUNT(kernels) * WEFT_COUNT(shapes)));
}

static void defaults_are_what_they_say(void **state)
{
    (void)state;
    weft_resample_plan *plan = NULL;
    assert_int_equal(weft_resample_plan_create(
                         weft_resample_params(.size = {5, 6}, .width = 10, .height = 9), &plan),
                     WEFT_OK);
    const struct weft_resample_info *info = weft_resample_plan_get_info(plan);
    assert_string_equal(info->kernel.info->name, "catmull-rom");
    assert_null(info->passes);
    assert_int_equal(info->map[0].from, 5);
    assert_int_equal(info->map[1].to, 9);
    assert_non_null(strstr(info->text, "separable catmull-rom: 4 taps along each axis"));
    assert_false(info->moves);
    // Values of any size have a bound: 0 is exact, and the largest floats may be scaled.
    static const double ends[] = {0.0, 1.0, 0x1p99, 0x1p101, 3e38};
    for (size_t i = 0; i < WEFT_COUNT(ends); i++) {
        const struct weft_resample_statistics s = {
            .sample_high = ends[i], .high = ends[i], .sample_low = 0.0};
        const struct weft_bound_terms terms = weft_separable_bound_terms(
            &info->kernel, WEFT_SUMS_FLOAT, ends[i], WEFT_VOLUME_PREFILTER_ERROR);
        const struct weft_bound_values values = {.sample_high = ends[i], .high = ends[i]};
        assert_true(weft_resample_bound(plan, &s, 0.0).total ==
                    weft_bound_compute(&terms, &values).total);
    }
    weft_resample_plan_destroy(&plan);
    assert_null(plan);
}

// Less memory cuts the work, and not the result.
static void memory_does_not_matter(void **state)
{
    (void)state;
    const struct shape s = {"", {300, 200}, 700, 450, {{0}}};
    const struct weft_kernel kernel = kernel_named("mitchell");
    struct work w = resample(contexts[0], &kernel, NULL, &s, 2);
    weft_resample_plan *small = NULL;
    struct picture other = make_picture(s.width, s.height, 2);
    assert_int_equal(weft_resample_plan_create(
                         weft_resample_params(.kernel = kernel, .size = {300, 200}, .width = 700,
                                              .height = 450, .memory_bytes = 1 << 20),
                         &small),
                     WEFT_OK);
    weft_resample_compiled_destroy(&w.compiled);
    const int rectangles = w.report.work.tiles;
    assert_int_equal(weft_resample_compile(
                         small, weft_resample_compile_params(.context = contexts[0]), &w.compiled),
                     WEFT_OK);
    assert_int_equal(run_to(&w, &other, NULL), WEFT_OK);
    assert_true(w.report.work.tiles > rectangles);
    assert_true(w.report.work.peak_bytes <= 1 << 20);
    for (int c = 0; c < 2; c++)
        assert_memory_equal(other.plane[c], w.pixels.plane[c],
                            (size_t)(other.stride * s.height) * sizeof(float));
    weft_resample_compiled_destroy(&w.compiled);
    weft_resample_plan_destroy(&small);
    clear_picture(&other);
    clear(&w);
}

// ---- passes -------------------------------------------------------------------------------------

static const struct pass_case pass_cases[] = {
    {"catmull-rom", "unorm8", WEFT_TECHNIQUE_PLAIN, 1},
    {"catmull-rom", "unorm8", WEFT_TECHNIQUE_PLAIN, 4},
    {"catmull-rom", "unorm8", WEFT_TECHNIQUE_DOT4, 1},
    {"mitchell", "unorm16", WEFT_TECHNIQUE_PLAIN, 4},
    {"bspline3", "unorm8", WEFT_TECHNIQUE_SPLIT_PRECISION, 1},
    {"catmull-rom", "unorm8", WEFT_TECHNIQUE_HIERARCHICAL, 1},
    {"bspline3+radial+unit", "unorm16", WEFT_TECHNIQUE_PLAIN, 1},
    {"bspline3i", "unorm16", WEFT_TECHNIQUE_PLAIN, 1},
    {"lanczos:2+unit", "fp32", WEFT_TECHNIQUE_PLAIN, 4},
    {"bspline3i", "fp32", WEFT_TECHNIQUE_PLAIN, 1},
};

// Of the bits that runs on the CPU and on GL give: on unorm targets they are the same.
static void passes_meet_the_reference(void **state)
{
    (void)state;
    int same = 0;
    double most = 0.0;
    for (size_t i = 0; i < WEFT_COUNT(pass_cases); i++)
        for (size_t s = 0; s < WEFT_COUNT(shapes); s++) {
            const struct pass_case *p = &pass_cases[i];
            const struct weft_kernel kernel = kernel_named(p->kernel);
            const int channels = 1 + (int)(i + s) % MAX_CHANNELS;
            struct work w = resample(NULL, &kernel, passes_of(p), &shapes[s], channels);
            most = fmax(most, assert_right(&w, shapes[s].what, kernel.prefiltered ? 29 : 1));
            for (int k = 0; k < 2 && contexts[k]; k++) {
                struct work gl = resample(contexts[k], &kernel, passes_of(p), &shapes[s], channels);
                assert_right(&gl, shapes[s].what, kernel.prefiltered ? 29 : 1);
                for (int c = 0; c < channels && strcmp(p->profile, "fp32") != 0; c++, same++)
                    assert_memory_equal(gl.pixels.plane[c], w.pixels.plane[c],
                                        (size_t)(w.pixels.stride * w.pixels.height) *
                                            sizeof(float));
                clear(&gl);
            }
            clear(&w);
        }
    assert_true(same >= 8 * (int)WEFT_COUNT(shapes));
    print_message("the largest error of passes is %.2f of its bound\n", most);
}

// Tiles meet without a seam: the pixels around their edges are as right as the others.
static void tiles_meet(void **state)
{
    (void)state;
    static const struct shape both[] = {{"columns of tiles", {700, 5}, 2100, 9, {{0}}},
                                        {"rows of tiles", {5, 700}, 9, 2100, {{0}}}};
    const struct pass_case p = {"catmull-rom", "unorm16", WEFT_TECHNIQUE_PLAIN, 4};
    const struct weft_kernel kernel = kernel_named(p.kernel);
    for (int i = 0; i < 2; i++) {
        struct work w = resample(NULL, &kernel, passes_of(&p), &both[i], 3);
        assert_int_equal(weft_resample_plan_get_info(w.plan)->tiles, 3);
        assert_int_equal(w.report.work.tiles, 3); // three channels, together
        assert_right(&w, both[i].what, 1);
        clear(&w);
    }
}

// Neither the rows of samples nor channels that share passes matter.
static void channels_do_not_matter(void **state)
{
    (void)state;
    const struct pass_case together = {"mitchell", "unorm8", WEFT_TECHNIQUE_PLAIN, 4};
    const struct pass_case alone = {"mitchell", "unorm8", WEFT_TECHNIQUE_PLAIN, 1};
    const struct weft_kernel kernel = kernel_named("mitchell");
    struct work a = resample(NULL, &kernel, passes_of(&together), &shapes[0], 3);
    struct work b = resample(NULL, &kernel, passes_of(&alone), &shapes[0], 3);
    for (int c = 0; c < 3; c++)
        assert_memory_equal(a.pixels.plane[c], b.pixels.plane[c],
                            (size_t)(a.pixels.stride * a.pixels.height) * sizeof(float));
    assert_int_equal(a.report.work.tiles, 1);
    assert_int_equal(b.report.work.tiles, 3);
    clear(&a);
    clear(&b);
}

// ---- runs ---------------------------------------------------------------------------------------

// Runs again, of the same source and then of another: what was compiled stays as it was.
static void compiled_plans_run_often(void **state)
{
    (void)state;
    const struct weft_kernel kernel = kernel_named("catmull-rom");
    const struct pass_case p = {"catmull-rom", "unorm8", WEFT_TECHNIQUE_PLAIN, 4};
    for (int engine = 0; engine < 3; engine++) {
        struct work w = resample(engine == 2 ? NULL : contexts[0], &kernel,
                                 engine ? passes_of(&p) : NULL, &shapes[0], 2);
        const size_t bytes = (size_t)(w.pixels.stride * w.pixels.height) * sizeof(float);
        const uint64_t first = w.report.work.uploaded_bytes;
        struct picture again = make_picture(w.pixels.width, w.pixels.height, 2);
        assert_int_equal(run_to(&w, &again, NULL), WEFT_OK);
        const uint64_t uploaded = w.report.work.uploaded_bytes;
        if (engine == 0)
            assert_true(uploaded < first); // weights are there from before
        else
            assert_int_equal(uploaded, first);
        assert_int_equal(run_to(&w, &again, NULL), WEFT_OK);
        assert_int_equal(w.report.work.uploaded_bytes, uploaded);
        const struct weft_resample_work *work = &w.report.work;
        if (engine == 1) // samples of four channels and positions, and no tiles
            assert_true(uploaded > 0 && uploaded <= work->source_bytes + work->position_bytes);
        const struct weft_resample_compiled_info *info =
            weft_resample_compiled_get_info(w.compiled);
        assert_true(info->programs > 0 || engine == 2);
        assert_true((info->tile_bytes > 0) == (engine > 0));
        for (int c = 0; c < 2; c++)
            assert_memory_equal(again.plane[c], w.pixels.plane[c], bytes);
        // The source borrows its planes: another one takes their place.
        weft_resample_source_destroy(&w.source);
        for (int i = 0; i < w.samples.width; i++)
            w.samples.plane[1][i] = (float)(i % 3);
        make_source(&w, &kernel);
        assert_int_equal(run_to(&w, &w.pixels, NULL), WEFT_OK);
        assert_right(&w, "another source", 1);
        assert_true(memcmp(again.plane[1], w.pixels.plane[1], bytes) != 0);
        clear_picture(&again);
        clear(&w);
    }
}

struct counter {
    int calls, stop;
    double last;
    bool falls;
};

static bool count_calls(void *priv, double fraction)
{
    struct counter *c = priv;
    c->falls = c->falls || !(fraction >= c->last && fraction <= 1.0);
    c->last = fraction;
    return ++c->calls != c->stop;
}

static void progress_stops_the_work(void **state)
{
    (void)state;
    const struct weft_kernel kernel = kernel_named("catmull-rom");
    const struct pass_case p = {"catmull-rom", "unorm8", WEFT_TECHNIQUE_PLAIN, 1};
    int stopped = 0;
    for (int engine = 0; engine < 3; engine++) {
        struct work w = prepare(engine == 2 ? NULL : contexts[0], &kernel,
                                engine ? passes_of(&p) : NULL, &shapes[0], 3);
        struct counter counter = {.stop = 0};
        const struct weft_progress progress = {count_calls, &counter};
        assert_int_equal(run_to(&w, &w.pixels, &progress), WEFT_OK);
        assert_false(counter.falls);
        assert_true(counter.calls >= 3);
        const int calls = counter.calls;
        for (int stop = 1; stop <= calls; stop += 1 + calls / 5) {
            counter = (struct counter){.stop = stop};
            const enum weft_result res = run_to(&w, &w.pixels, &progress);
            assert_true(res == WEFT_ERR_CANCELLED || (res == WEFT_OK && counter.last == 1.0));
            stopped += res == WEFT_ERR_CANCELLED;
        }
        struct weft_verify_report error;
        struct weft_resample_verify_params verify = {
            .source = w.source, .stride = w.pixels.stride, .how = {.progress = &progress}};
        for (int c = 0; c < 3; c++)
            verify.plane[c] = w.pixels.plane[c];
        counter = (struct counter){.stop = 1};
        assert_int_equal(weft_resample_verify(w.plan, &verify, &error), WEFT_ERR_CANCELLED);
        clear(&w);
    }
    assert_true(stopped >= 6);
}

static void limits_are_told(void **state)
{
    (void)state;
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    const struct pass_case p = {"catmull-rom", "unorm8", WEFT_TECHNIQUE_PLAIN, 4};
    weft_pass_plan *passes = passes_of(&p);
    weft_resample_plan *plan = NULL;
    struct weft_resample_params *params =
        weft_resample_params(.passes = passes, .size = {100, 100}, .width = 200, .height = 200,
                             .memory_bytes = 100000, .log = &log);
    assert_int_equal(weft_resample_plan_create(params, &plan), WEFT_ERR_LIMIT);
    assert_null(plan);
    assert_non_null(strstr(message.text, "100000"));
    assert_non_null(strstr(message.text, "200 x 200 pixels"));
    params->memory_bytes = 10000000;
    assert_int_equal(weft_resample_plan_create(params, &plan), WEFT_OK);
    weft_resample_plan_destroy(&plan);
}

// ---- what is measured ---------------------------------------------------------------------------

static void statistics_are_of_all_channels(void **state)
{
    (void)state;
    struct picture p = make_samples(6, 4, 2);
    p.plane[0][0] = -70.0f;
    p.plane[0][1] = -1.0f; // the ends of a range are in it
    p.plane[0][2] = 4.0f;
    p.plane[1][2 * p.stride + 3] = 90.0f;
    p.plane[1][2 * p.stride + 4] = NAN;
    struct weft_resample_source_params *params =
        weft_resample_source_params(.kernel = kernel_named("linear"), .width = 6, .height = 4,
                                    .channels = 2, .stride = p.stride);
    memcpy(params->plane, p.plane, sizeof params->plane);
    weft_resample_source *source = NULL;
    assert_int_equal(weft_resample_source_create(params, &source), WEFT_OK);
    const struct weft_resample_statistics *s = &weft_resample_source_get_info(source)->statistics;
    assert_true(s->sample_low == -70.0 && s->sample_high == 90.0);
    assert_true(s->low == -70.0 && s->high == 90.0);
    assert_int_equal(s->clamped, 1);
    // Second differences of linear interpolation: 90's, along a column (NAN is its neighbour).
    double largest = 0.0;
    const float *column = &p.plane[1][3];
    for (int y = 0; y < 2; y++)
        largest = fmax(largest, fabs((double)column[y * p.stride] -
                                     2.0 * (double)column[(y + 1) * p.stride] +
                                     (double)column[(y + 2) * p.stride]));
    assert_true(largest > 170.0);
    const struct weft_kernel linear = kernel_named("linear");
    const double e1 = weft_error_e1(&linear, 2, largest);
    assert_near(weft_resample_e1(source), e1, 1e-12 * e1, "E1 of the largest difference");
    weft_resample_source_destroy(&source);
    params->low = -1.0;
    params->high = 4.0;
    assert_int_equal(weft_resample_source_create(params, &source), WEFT_OK);
    s = &weft_resample_source_get_info(source)->statistics;
    uint64_t outside = 0;
    for (int c = 0; c < 2; c++)
        for (int y = 0; y < 4; y++)
            for (int x = 0; x < 6; x++) {
                const float v = p.plane[c][y * p.stride + x];
                outside += !(v >= -1.0f && v <= 4.0f);
            }
    assert_true(outside > 3);
    assert_int_equal(s->clamped, outside);
    assert_true(s->low == -1.0 && s->high == 4.0 && s->sample_high == 90.0);
    weft_resample_source_destroy(&source);
    clear_picture(&p);
}

// Coefficients of a constant are that constant; of the largest floats they are none.
static void coefficients_have_a_range(void **state)
{
    (void)state;
    struct picture p = make_picture(5, 4, 1);
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    struct weft_resample_source_params *params =
        weft_resample_source_params(.kernel = kernel_named("bspline3i"), .width = 5, .height = 4,
                                    .plane = {p.plane[0]}, .stride = p.stride, .log = &log);
    weft_resample_source *source = NULL;
    for (int i = 0; i < 20; i++)
        p.plane[0][i / 5 * p.stride + i % 5] = 2.5f;
    assert_int_equal(weft_resample_source_create(params, &source), WEFT_OK);
    const struct weft_resample_statistics *s = &weft_resample_source_get_info(source)->statistics;
    assert_near(s->low, 2.5, 1e-6, "low");
    assert_near(s->high, 2.5, 1e-6, "high");
    weft_resample_source_destroy(&source);
    for (int i = 0; i < 20; i++)
        p.plane[0][i / 5 * p.stride + i % 5] = i % 2 ? 3e38f : -3e38f;
    assert_int_equal(weft_resample_source_create(params, &source), WEFT_ERR_LIMIT);
    assert_null(source);
    assert_non_null(strstr(message.text, "leave the range of floats"));
    clear_picture(&p);
}

// ---- verifying ----------------------------------------------------------------------------------

static struct weft_verify_report verify(const struct work *w)
{
    struct weft_verify_report error;
    struct weft_resample_verify_params params = {
        .source = w->source, .stride = w->pixels.stride, .log = &log_to_stderr};
    for (int c = 0; c < w->pixels.channels; c++)
        params.plane[c] = w->pixels.plane[c];
    assert_int_equal(weft_resample_verify(w->plan, &params, &error), WEFT_OK);
    return error;
}

static void errors_are_found(void **state)
{
    static const struct pass_case engines[] = {
        {"catmull-rom", "", 0, 0},
        {"bspline3i", "", 0, 0},
        {"catmull-rom", "unorm8", WEFT_TECHNIQUE_PLAIN, 4},
        {"bspline3i", "unorm16", WEFT_TECHNIQUE_PLAIN, 1},
    };
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(engines); i++) {
        const bool separable = engines[i].channels == 0;
        const struct weft_kernel kernel = kernel_named(engines[i].kernel);
        struct work w = resample(separable ? contexts[0] : NULL, &kernel,
                                 separable ? NULL : passes_of(&engines[i]), &shapes[7], 3);
        struct weft_verify_report error = verify(&w);
        const double own =
            largest_error(weft_resample_plan_get_info(w.plan), &w.samples, &w.pixels, 1);
        // The verifier's cardinal spline is cut off at 2^-32 of samples up to 5.
        assert_near(error.maximum, own, kernel.prefiltered ? 2e-9 : 1e-13, "largest error");
        assert_true(error.rms > 0.0 && error.rms <= error.maximum);
        assert_int_equal(error.not_finite_mismatches, 0);
        w.pixels.plane[2][5 * w.pixels.stride + 7] += 100.0f;
        error = verify(&w);
        assert_true(error.maximum > 99.0);
        assert_int_equal(error.at_x, 7);
        assert_int_equal(error.at_y, 5);
        assert_int_equal(error.at_channel, 2);
        w.pixels.plane[1][0] = NAN;
        assert_int_equal(verify(&w).not_finite_mismatches, 1);
        clear(&w);
    }
}

// Where a sample is not finite, pixels in its reach are not, and no others.
static void missing_samples_spread_no_farther(void **state)
{
    (void)state;
    const struct shape s = {"", {12, 9}, 36, 27, {{0}}};
    const struct weft_kernel kernel = kernel_named("linear");
    const struct pass_case p = {"linear", "unorm8", WEFT_TECHNIQUE_PLAIN, 1};
    for (int engine = 0; engine < 2; engine++) {
        struct work w =
            prepare(engine ? NULL : contexts[0], &kernel, engine ? passes_of(&p) : NULL, &s, 1);
        weft_resample_source_destroy(&w.source);
        w.samples.plane[0][4 * w.samples.stride + 5] = NAN;
        make_source(&w, &kernel);
        assert_int_equal(run_to(&w, &w.pixels, NULL), WEFT_OK);
        // Three pixels a sample, from those between it and its neighbours: 5 along either axis.
        assert_int_equal(w.report.pixels.not_finite, 25);
        for (int y = 0; y < s.height; y++)
            for (int x = 0; x < s.width; x++)
                assert_int_equal(!isfinite(w.pixels.plane[0][y * w.pixels.stride + x]),
                                 x >= 14 && x < 19 && y >= 11 && y < 16);
        assert_int_equal(verify(&w).not_finite_mismatches, 0);
        clear(&w);
    }
}

// ---- integers -----------------------------------------------------------------------------------

static void integers_are_moved_exactly(void **state)
{
    (void)state;
    const struct weft_kernel kernel = kernel_named("nearest");
    assert_true(weft_resample_moves(&kernel));
    const struct weft_kernel linear = kernel_named("linear");
    assert_false(weft_resample_moves(&linear));
    int compared = 0;
    for (size_t s = 0; s < WEFT_COUNT(shapes); s++) {
        const struct shape *shape = &shapes[s];
        const int nx = shape->size[0], ny = shape->size[1];
        const int64_t from_stride = nx + PADDING, stride = shape->width + PADDING;
        uint32_t *from = malloc((size_t)(from_stride * ny) * sizeof *from);
        uint32_t *to = malloc((size_t)(stride * shape->height) * sizeof *to);
        assert_true(from && to);
        for (int64_t i = 0; i < from_stride * ny; i++)
            from[i] = (uint32_t)i * 2654435761u | 1u; // more bits than a float has
        for (int64_t i = 0; i < stride * shape->height; i++)
            to[i] = 42;
        weft_resample_plan *plan = NULL;
        assert_int_equal(weft_resample_plan_create(
                             weft_resample_params(.kernel = kernel, .size = {nx, ny},
                                                  .width = shape->width, .height = shape->height,
                                                  .map = {shape->map[0], shape->map[1]}),
                             &plan),
                         WEFT_OK);
        const struct weft_resample_info *info = weft_resample_plan_get_info(plan);
        assert_true(info->moves);
        const struct weft_resample_integers source = {nx, ny, {0}, from, from_stride};
        assert_int_equal(weft_resample_move(plan, &source, NULL, to, stride), WEFT_OK);
        for (int y = 0; y < shape->height; y++) {
            for (int x = 0; x < shape->width; x++, compared++) {
                int64_t at[2] = {x, y};
                for (int a = 0; a < 2; a++) { // floor((x + pixel + 1/2) from / to) + sample
                    const struct weft_window_map *m = &info->map[a];
                    const int64_t n = (2 * (at[a] + m->pixel) + 1) * m->from, d = 2 * m->to;
                    at[a] = n / d - (n % d < 0) + m->sample;
                    at[a] = at[a] < 0 ? 0 : at[a] >= info->size[a] ? info->size[a] - 1 : at[a];
                }
                assert_int_equal(to[y * stride + x], from[at[1] * from_stride + at[0]]);
            }
            for (int64_t x = shape->width; x < stride; x++)
                assert_int_equal(to[y * stride + x], 42);
        }
        struct weft_verify_report error;
        assert_int_equal(weft_resample_move_verify(plan, &source, NULL, to, stride, NULL, &error),
                         WEFT_OK);
        assert_true(error.maximum == 0.0 && error.rms == 0.0);
        to[0] ^= 1u;
        assert_int_equal(weft_resample_move_verify(plan, &source, NULL, to, stride, NULL, &error),
                         WEFT_OK);
        assert_true(error.maximum == 1.0 && error.at_x == 0 && error.at_y == 0);
        weft_resample_plan_destroy(&plan);
        free(from);
        free(to);
    }
    assert_true(compared > 1000);
}

// ---- choosing -----------------------------------------------------------------------------------

static void chosen_passes_meet_the_budget(void **state)
{
    (void)state;
    const struct weft_kernel kernel = kernel_named("catmull-rom");
    struct work w = {.samples = make_samples(13, 9, 1), .pixels = make_picture(41, 30, 1)};
    make_source(&w, &kernel);
    const weft_resample_source *sources[1] = {w.source};
    const struct weft_resample_statistics *s = &weft_resample_source_get_info(w.source)->statistics;
    double budget = 0.08 * (s->high - s->low);
    const struct weft_resample_choose_params params = {
        .passes = {.profile = profile_named("unorm16"), .kernel = kernel},
        .any_technique = false,
        .any_samples = true,
        .any_bits = true,
        .sources = sources,
        .max_error = &budget,
        .source_count = 1,
        .width = 41,
        .height = 30,
        .log = &log_to_stderr};
    struct weft_resample_choice choice;
    assert_int_equal(weft_resample_choose(&params, &choice), WEFT_OK);
    assert_true(choice.chosen >= 0 && choice.plan);
    int cheaper = 0;
    for (size_t i = 0; i < choice.count; i++) {
        const struct weft_candidate *c = &choice.candidates[i];
        assert_true((c->state == WEFT_CANDIDATE_CHOSEN) == ((int)i == choice.chosen));
        // What is cheaper has a bound that is over the budget, for sure.
        if (c->state == WEFT_CANDIDATE_REFUSED ||
            c->seconds >= choice.candidates[choice.chosen].seconds)
            continue;
        assert_int_equal(c->state, WEFT_CANDIDATE_EXCEEDS);
        assert_true(c->bound > choice.max_error);
        cheaper++;
    }
    assert_true(cheaper > 0);
    weft_pass_plan *passes = choice.plan;
    choice.plan = NULL;
    weft_resample_choice_clear(&choice);
    assert_int_equal(
        weft_resample_plan_create(
            weft_resample_params(.passes = passes, .size = {13, 9}, .width = 41, .height = 30),
            &w.plan),
        WEFT_OK);
    assert_int_equal(weft_resample_compile(w.plan, weft_resample_compile_params(), &w.compiled),
                     WEFT_OK);
    assert_int_equal(run_to(&w, &w.pixels, NULL), WEFT_OK);
    assert_right(&w, "chosen", 1);
    assert_true(bound_of(&w) <= budget);
    budget = 1e-12;
    assert_int_equal(weft_resample_choose(&params, &choice), WEFT_OK);
    assert_int_equal(choice.chosen, -1);
    assert_true(choice.best >= 0);
    assert_null(choice.plan);
    weft_resample_choice_clear(&choice);
    clear(&w);
    weft_pass_plan_destroy(&passes);
}

// The fastest engine and sums whose bound is within: the CPU's in double where the budget is small,
// and whatever the model says is faster where it is not.
static void chosen_engines_meet_the_budget(void **state)
{
    (void)state;
    struct weft_cost_model slow_cpu = weft_cost_default;
    const struct weft_kernel kernel = kernel_named("mitchell");
    struct work w = {.samples = make_samples(60, 40, 1), .pixels = make_picture(300, 200, 1)};
    make_source(&w, &kernel);
    const weft_resample_source *sources[1] = {w.source};
    const struct weft_resample_statistics *s = &weft_resample_source_get_info(w.source)->statistics;
    const double largest = fmax(-s->sample_low, s->sample_high);
    double budget;
    for (int sums = 0; sums < WEFT_COST_SUMS; sums++)
        for (int w = 0; w < WEFT_COST_WIDTHS; w++)
            slow_cpu.cpu_separable_tap[sums][w] = 1e4;
    struct weft_resample_engine_params params = {
        .plan = *weft_resample_params(.kernel = kernel, .size = {60, 40}, .width = 300,
                                      .height = 200, .log = &log_to_stderr),
        .sources = sources,
        .max_error = &budget,
        .source_count = 1,
        .log = &log_to_stderr};
    const unsigned gl = 1u << WEFT_ENGINE_GL, cpu = 1u << WEFT_ENGINE_CPU;
    const struct {
        double budget; // in units of the largest sample
        const struct weft_cost_model *model;
        unsigned engines;
        const char *chosen; // NULL: none is within
    } cases[] = {
        {1e-3, NULL, 0, "separable cpu float"},
        {1e-3, &slow_cpu, 0, "separable"},
        {1e-3, NULL, gl, "separable"},
        {1e-3, &slow_cpu, cpu, "separable cpu float"},
        {2e-7, &slow_cpu, 0, "separable cpu double"},
        {2e-7, NULL, gl, NULL},
        {1e-9, NULL, 0, NULL},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct weft_resample_choice choice;
        budget = cases[i].budget * largest;
        params.model = cases[i].model;
        params.engines = cases[i].engines;
        assert_int_equal(weft_resample_choose_engine(&params, &choice), WEFT_OK);
        assert_int_equal(choice.chosen >= 0, cases[i].chosen != NULL);
        assert_true((choice.separable != NULL) == (choice.chosen >= 0));
        assert_true(choice.best >= 0);
        if (cases[i].chosen) {
            assert_string_equal(choice.candidates[choice.chosen].name, cases[i].chosen);
            w.plan = choice.separable;
            choice.separable = NULL;
            const bool on_gl = weft_resample_plan_get_info(w.plan)->engine == WEFT_ENGINE_GL;
            assert_int_equal(
                weft_resample_compile(
                    w.plan, weft_resample_compile_params(.context = on_gl ? contexts[0] : NULL),
                    &w.compiled),
                WEFT_OK);
            assert_int_equal(run_to(&w, &w.pixels, NULL), WEFT_OK);
            assert_right(&w, cases[i].chosen, 1);
            assert_true(bound_of(&w) <= budget);
            weft_resample_compiled_destroy(&w.compiled);
            weft_resample_plan_destroy(&w.plan);
        }
        weft_resample_choice_clear(&choice);
    }
    // Without a budget sums are single.
    params.max_error = NULL;
    params.source_count = 0;
    struct weft_resample_choice choice;
    assert_int_equal(weft_resample_choose_engine(&params, &choice), WEFT_OK);
    assert_int_equal(choice.count, 2);
    assert_true(choice.chosen == 0 && choice.separable);
    weft_resample_choice_clear(&choice);
    clear(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(separable_meets_the_reference),
        cmocka_unit_test(defaults_are_what_they_say),
        cmocka_unit_test(memory_does_not_matter),
        cmocka_unit_test(passes_meet_the_reference),
        cmocka_unit_test(tiles_meet),
        cmocka_unit_test(channels_do_not_matter),
        cmocka_unit_test(compiled_plans_run_often),
        cmocka_unit_test(progress_stops_the_work),
        cmocka_unit_test(limits_are_told),
        cmocka_unit_test(statistics_are_of_all_channels),
        cmocka_unit_test(coefficients_have_a_range),
        cmocka_unit_test(errors_are_found),
        cmocka_unit_test(missing_samples_spread_no_farther),
        cmocka_unit_test(integers_are_moved_exactly),
        cmocka_unit_test(chosen_passes_meet_the_budget),
        cmocka_unit_test(chosen_engines_meet_the_budget),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_all);
}
