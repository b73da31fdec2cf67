// SPDX-License-Identifier: BSD-3-Clause
// The measured error of random plans stays within their bounds.
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
#include "tests/support/plan_runs.h"
#include "tests/support/contexts.h"
#include "filter/check.h"
#include "weft.h"

// The numbers of plans, or WEFT_PLANS: 5000 is a long sweep.
enum { EMULATED = 500, DRAWN = 100, SIDE = 7, PIXELS = 14 };

static uint64_t random_state;

static uint32_t random_next(void)
{
    random_state += UINT64_C(0x9e3779b97f4a7c15);
    uint64_t h = random_state;
    h = (h ^ h >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    h = (h ^ h >> 27) * UINT64_C(0x94d049bb133111eb);
    return (uint32_t)((h ^ h >> 31) >> 16);
}

static int random_below(int limit)
{
    return (int)(random_next() % (uint32_t)limit);
}

static double random_unit(void)
{
    return random_next() * 0x1p-32;
}

// ---- a random job -------------------------------------------------------------------------------

struct job {
    struct weft_pass_plan_params params;
    weft_pass_plan *plan;
    struct weft_samples samples;
    struct weft_pixel_grid grid;
    float *plane[4], *pixels[4];
    double amplitude; // largest |sample| and range
};

static struct weft_kernel random_kernel(int dims)
{
    int count = 0;
    while (weft_kernel_list[count])
        count++;
    for (;;) {
        struct weft_kernel kernel = kernel_named(weft_kernel_list[random_below(count)]->name);
        const bool wide = kernel.width > (dims > 2 ? 4 : 6);
        // Second derivatives lose most of the range; some are enough.
        if (!wide && (kernel.info->derivation < 2 || random_below(8) == 0))
            return kernel;
    }
}

static bool may_derive(const struct weft_kernel *kernel, const struct weft_derivative *d)
{
    struct weft_kernel derived = *kernel;
    int most = 0;
    for (int a = 0; a < 3; a++)
        most = d->along[a] > most ? d->along[a] : most;
    for (int i = 0; i < most; i++)
        if (weft_kernel_derive(NULL, &derived, &derived) != WEFT_OK)
            return false;
    return true;
}

static struct weft_pass_plan_params random_params(void)
{
    static const int samples[] = {1, 3, 4, 5, 8, 16, 32, 64};
    const int dims = random_below(4) ? 2 : 3;
    struct weft_pass_plan_params p =
        *weft_pass_plan_params(.dims = dims, .kernel = random_kernel(dims));
    int profiles = 0;
    while (weft_profile_list[profiles])
        profiles++;
    p.profile = *weft_profile_list[random_below(profiles)];
    if (p.profile.target >= WEFT_TARGET_HALF && random_below(2))
        p.profile = *weft_profile_find("unorm8");
    p.taps_per_pass = 1 + random_below(p.profile.taps_per_pass);
    p.samples = samples[random_below(dims > 2 ? 5 : 8)];
    p.bits = p.profile.target == WEFT_TARGET_UNORM16 ? 8 + random_below(3) : 6 + random_below(5);
    p.technique = p.profile.target >= WEFT_TARGET_HALF ? (enum weft_technique)random_below(2)
                                                       : (enum weft_technique)random_below(5);
    p.worst_case = (enum weft_worst_case)(random_below(3) == 0);
    p.order = random_below(5) ? WEFT_ORDER_PLANNED : (enum weft_order)random_below(3);
    p.round_singly = random_below(6) == 0;
    p.blend_only = random_below(4) == 0;
    p.channels = p.technique != WEFT_TECHNIQUE_DOT4 && random_below(5) == 0 ? 4 : 1;
    if (random_below(6) == 0)
        p.derivative = derivative_named(derivative_in(dims, 1 + random_below(dims > 2 ? 9 : 5)));
    if (!may_derive(&p.kernel, &p.derivative))
        p.derivative = (struct weft_derivative){{0, 0, 0}};
    return p;
}

static size_t sample_count(const struct job *job)
{
    return (size_t)job->samples.size[0] * (size_t)job->samples.size[1] *
           (size_t)job->samples.size[2];
}

static void make_samples(struct job *job)
{
    const double low = random_below(2) ? 0.0 : 20.0 * random_unit() - 10.0;
    const double width = random_below(2) ? 1.0 : exp2(8.0 * random_unit() - 4.0);
    for (int a = 0; a < 3; a++)
        job->samples.size[a] = a < job->params.dims ? 1 + random_below(SIDE) : 1;
    job->samples.low = job->params.technique == WEFT_TECHNIQUE_LOG ? fabs(low) : low;
    job->samples.high = job->samples.low + width;
    job->amplitude = fmax(fabs(job->samples.low), fabs(job->samples.high));
    for (int c = 0; c < job->params.channels; c++) {
        job->plane[c] = malloc(sample_count(job) * sizeof(float));
        job->pixels[c] = malloc(PIXELS * PIXELS * sizeof(float));
        assert_non_null(job->plane[c]);
        assert_non_null(job->pixels[c]);
        job->samples.plane[c] = job->plane[c];
    }
}

// Noise, with many samples at the ends of the range; or one constant.
static void fill_samples(struct job *job, bool constant)
{
    const double level = random_below(3) ? random_unit() : random_below(2);
    const double width = job->samples.high - job->samples.low;
    for (int c = 0; c < job->params.channels; c++)
        for (size_t i = 0; i < sample_count(job); i++) {
            const double f = constant ? level : random_below(3) ? random_unit() : random_below(2);
            job->plane[c][i] = (float)(job->samples.low + f * width);
        }
}

static void make_grid(struct job *job)
{
    job->grid = (struct weft_pixel_grid){.width = PIXELS, .height = PIXELS};
    for (int a = 0; a < job->params.dims; a++) {
        job->grid.origin[a] = (SIDE + 4) * random_unit() - 2.0;
        job->grid.du[a] = random_unit() - 0.5;
        job->grid.dv[a] = random_unit() - 0.5;
    }
}

static void clear_job(struct job *job)
{
    weft_pass_plan_destroy(&job->plan);
    for (int c = 0; c < 4; c++) {
        free(job->plane[c]);
        free(job->pixels[c]);
    }
}

// false for the few requests that cannot be met: they say so.
static bool make_job(struct job *job)
{
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    *job = (struct job){.params = random_params()};
    job->params.log = &log;
    const enum weft_result res = weft_pass_plan_create(&job->params, &job->plan);
    if (res != WEFT_OK && res != WEFT_ERR_UNSUPPORTED && res != WEFT_ERR_LIMIT)
        fail_msg("%s: %s", weft_result_text(res), message.text);
    char along[WEFT_DERIVATIVE_TEXT];
    if (res != WEFT_OK && getenv("WEFT_REFUSALS"))
        print_message(
            "refused: %s %dD M %d, %s, %s, %d taps, %d bits, any %d, derivative %s, singly %d, "
            "blend %d: %s\n",
            job->params.kernel.info->name, job->params.dims, job->params.samples,
            job->params.profile.name, weft_technique_names[job->params.technique],
            job->params.taps_per_pass, job->params.bits, (int)job->params.worst_case,
            weft_derivative_format(&job->params.derivative, along), job->params.round_singly,
            job->params.blend_only, message.text);
    job->params.log = NULL;
    if (res != WEFT_OK)
        return false;
    make_samples(job);
    make_grid(job);
    return true;
}

// ---- what is measured ---------------------------------------------------------------------------

enum input { NOISE, CONSTANT, INPUTS };

struct tally {
    int plans, refused, beyond;
    int count[INPUTS];
    double *ratio[INPUTS]; // bound / measured, where anything was
};

// Results are single-precision numbers, and so are the samples that the reference sees.
static double float_error(const struct job *job)
{
    return 4.0 * 0x1p-24 * job->amplitude;
}

static bool is_coded(const struct job *job)
{
    return weft_target_bits(job->params.profile.target) > 0;
}

// On targets of fixed point, GL and emulation agree in every bit.
static void compare_with_emulation(const struct job *job,
                                   const struct weft_multipass_run_params *drawn, int number)
{
    struct weft_multipass_run_params params = *drawn;
    float emulated[4][PIXELS * PIXELS];
    for (int c = 0; c < job->params.channels; c++)
        params.pixels[c] = emulated[c];
    assert_int_equal(run_plan(NULL, job->plan, &params, NULL), WEFT_OK);
    for (int c = 0; c < job->params.channels; c++)
        if (memcmp(emulated[c], job->pixels[c], sizeof emulated[c]) != 0)
            fail_msg("plan %d: GL and emulation differ\n%s", number,
                     weft_pass_plan_get_info(job->plan)->text);
}

// The bound over the error measured, 0 where a result is not finite.
static double check(struct job *job, weft_context *context, bool constant, int number)
{
    const struct weft_pass_plan_info *info = weft_pass_plan_get_info(job->plan);
    struct weft_multipass_run_params params = {
        .samples = &job->samples, .grid = &job->grid, .log = &log_to_stderr};
    struct weft_verify_report error;
    memcpy(params.pixels, job->pixels, sizeof params.pixels);
    fill_samples(job, constant);
    assert_int_equal(run_plan(context, job->plan, &params, NULL), WEFT_OK);
    if (context && is_coded(job))
        compare_with_emulation(job, &params, number);
    assert_int_equal(verify_plan(job->plan, &params, &error), WEFT_OK);
    const double width = job->samples.high - job->samples.low;
    const bool declared = constant || job->params.worst_case == WEFT_WORST_ANY;
    const double bound =
        (declared ? info->error.bound : info->error.bound_any) * width + float_error(job);
    if (!(error.maximum <= bound) || error.not_finite_mismatches)
        print_error("plan %d, %s: %.6g is beyond the bound %.6g (range %.3g) at (%d, %d) channel "
                    "%d, or %d not finite; order %d%s%s, singly %d\n%s",
                    number, constant ? "constant" : "noise", error.maximum, bound, width,
                    error.at_x, error.at_y, error.at_channel, (int)error.not_finite_mismatches,
                    (int)job->params.order, job->params.blend_only ? ", blend only" : "",
                    job->params.channels == 4 ? ", 4 channels" : "", job->params.round_singly,
                    info->text);
    if (error.not_finite_mismatches || isnan(error.maximum))
        return 0.0;
    return error.maximum > 0.0 ? bound / error.maximum : INFINITY;
}

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void print_ratios(const char *what, double *ratio, int count)
{
    assert_true(count > 0);
    qsort(ratio, (size_t)count, sizeof *ratio, compare_doubles);
    print_message("  %s: bound / measured: least %.2f, median %.2f, 90 %% below %.1f\n", what,
                  ratio[0], ratio[count / 2], ratio[count * 9 / 10]);
}

static void run_jobs(weft_context *context, int jobs)
{
    const int limit = getenv("WEFT_PLANS") ? atoi(getenv("WEFT_PLANS")) : jobs;
    struct tally tally = {0};
    for (int input = 0; input < INPUTS; input++) {
        tally.ratio[input] = malloc((size_t)limit * sizeof(double));
        assert_non_null(tally.ratio[input]);
    }
    while (tally.plans < limit) {
        struct job job;
        if (!make_job(&job)) {
            tally.refused++;
            continue;
        }
        for (int input = 0; input < INPUTS; input++) {
            const double ratio = check(&job, context, input == CONSTANT, tally.plans);
            tally.beyond += !(ratio >= 1.0);
            // Constants come back exactly from many plans.
            if (ratio < 1e5)
                tally.ratio[input][tally.count[input]++] = ratio;
        }
        clear_job(&job);
        tally.plans++;
    }
    print_message("%d plans (%d requests refused): %d beyond their bounds\n", tally.plans,
                  tally.refused, tally.beyond);
    print_ratios("noise", tally.ratio[NOISE], tally.count[NOISE]);
    print_ratios("constants", tally.ratio[CONSTANT], tally.count[CONSTANT]);
    assert_int_equal(tally.beyond, 0);
    assert_true(tally.refused <= limit / 50);
    for (int input = 0; input < INPUTS; input++)
        free(tally.ratio[input]);
}

static void emulated_plans_stay_within_their_bounds(void **state)
{
    (void)state;
    random_state = 20030203;
    run_jobs(NULL, EMULATED);
}

static void drawn_plans_stay_within_their_bounds(void **state)
{
    (void)state;
    random_state = 20011009;
    run_jobs(contexts[0], DRAWN);
}

// ---- prefiltered kernels ------------------------------------------------------------------------

enum { LINE = 26, MIDDLE = LINE / 2 };
enum content { PREFILTERED_NOISE, ALTERNATING, STEP, ADVERSE, CONTENTS };

static struct weft_pass_plan_params random_prefiltered(void)
{
    static const char *const kernels[] = {"bspline2i", "bspline3i", "bspline4i",   "bspline5i",
                                          "bspline7i", "omomsi",    "d-bspline3i", "dd-bspline5i"};
    struct weft_pass_plan_params p = random_params();
    do
        p.kernel = kernel_named(kernels[random_below((int)WEFT_COUNT(kernels))]);
    while (p.dims > 2 && p.kernel.width > 4);
    p.technique = (enum weft_technique)random_below(p.profile.target >= WEFT_TARGET_HALF ? 2 : 4);
    p.channels = 1;
    if (!may_derive(&p.kernel, &p.derivative))
        p.derivative = (struct weft_derivative){{0, 0, 0}};
    return p;
}

// What a sample is worth to a pixel at `at`, less what it is worth where the tile was sampled: what
// the nearest sample position is off by, for a sample of 1.
static double sample_error(const struct job *job, const double at[3], const int index[3])
{
    double exact = 1.0, looked_up = 1.0;
    for (int a = 0; a < job->params.dims; a++) {
        double weights[2][WEFT_PREFILTER_MAX_WEIGHTS], fraction;
        struct weft_prefilter p;
        const int64_t tap = weft_kernel_first_tap(&job->params.kernel, at[a], &fraction);
        const double m = job->params.samples, cell = floor(fraction * m);
        assert_int_equal(weft_prefilter_compute(NULL, &job->params.kernel, &p), WEFT_OK);
        const double near = at[a] + (cell + 0.5) / m - fraction;
        const int64_t first =
            weft_prefilter_weights(&p, &job->params.kernel, 30, at[a], weights[0]);
        assert_true(first == tap - 30);
        assert_true(weft_prefilter_weights(&p, &job->params.kernel, 30, near, weights[1]) == first);
        exact *= weights[0][index[a] - first];
        looked_up *= weights[1][index[a] - first];
    }
    return looked_up - exact;
}

static double sample_of(const struct job *job, enum content content, const int index[3])
{
    switch (content) {
    case PREFILTERED_NOISE:
        return 2.0 * random_unit() - 1.0;
    case ALTERNATING:
        return (index[0] + index[1] + index[2]) % 2 ? -1.0 : 1.0;
    case STEP:
        return index[0] < MIDDLE ? -1.0 : 1.0;
    default:
        return sample_error(job, job->grid.origin, index) < 0.0 ? -1.0 : 1.0;
    }
}

static void filter_samples(const struct job *job, double *values)
{
    const int *size = job->samples.size;
    const ptrdiff_t pitch[3] = {1, size[0], (ptrdiff_t)size[0] * size[1]};
    struct weft_prefilter p;
    assert_int_equal(weft_prefilter_compute(NULL, &job->params.kernel, &p), WEFT_OK);
    for (int a = 0; a < job->params.dims; a++)
        for (size_t i = 0; i < sample_count(job); i++)
            if ((ptrdiff_t)i / pitch[a] % size[a] == 0)
                weft_prefilter_line(&p, values + i, LINE, pitch[a], (double)NAN, (double)NAN);
}

// Coefficients of samples from -1 to 1.
static void fill_coefficients(struct job *job, enum content content)
{
    const size_t count = sample_count(job);
    double *values = malloc(count * sizeof *values);
    assert_non_null(values);
    for (size_t i = 0; i < count; i++) {
        const int at = (int)i, index[3] = {at % LINE, at / LINE % LINE, at / LINE / LINE};
        values[i] = sample_of(job, content, index);
    }
    filter_samples(job, values);
    job->samples.low = INFINITY;
    job->samples.high = -INFINITY;
    for (size_t i = 0; i < count; i++) {
        job->plane[0][i] = (float)values[i];
        job->samples.low = fmin(job->samples.low, (double)job->plane[0][i]);
        job->samples.high = fmax(job->samples.high, (double)job->plane[0][i]);
    }
    job->amplitude = fmax(-job->samples.low, job->samples.high);
    free(values);
}

// All taps within the samples: beyond them planes repeat a coefficient. The first pixel lies where
// a cell begins, as far from the sample position as can be.
static void make_prefiltered(struct job *job)
{
    make_samples(job);
    free(job->plane[0]);
    job->grid = (struct weft_pixel_grid){.width = PIXELS, .height = PIXELS};
    for (int a = 0; a < job->params.dims; a++) {
        job->samples.size[a] = LINE;
        job->grid.origin[a] =
            MIDDLE + (double)random_below(job->params.samples) / job->params.samples;
        job->grid.du[a] = 0.5 * (random_unit() - 0.5);
        job->grid.dv[a] = 0.5 * (random_unit() - 0.5);
    }
    job->plane[0] = malloc(sample_count(job) * sizeof(float));
    assert_non_null(job->plane[0]);
    job->samples.plane[0] = job->plane[0];
}

// bound / measured.
static double check_prefiltered(struct job *job, enum content content, int *nearer)
{
    const struct weft_pass_plan_error *e = &weft_pass_plan_get_info(job->plan)->error;
    struct weft_multipass_run_params params = {
        .samples = &job->samples, .grid = &job->grid, .log = &log_to_stderr};
    struct weft_verify_report error;
    fill_coefficients(job, content);
    memcpy(params.pixels, job->pixels, sizeof params.pixels);
    assert_int_equal(run_plan(NULL, job->plan, &params, NULL), WEFT_OK);
    assert_int_equal(verify_plan(job->plan, &params, &error), WEFT_OK);
    const double width = job->samples.high - job->samples.low;
    const struct weft_bound_values values = {
        .low = job->samples.low, .high = job->samples.high, .sample_low = -1.0, .sample_high = 1.0};
    const struct weft_bound stated =
        weft_bound_compute(&weft_pass_plan_get_info(job->plan)->bound, &values);
    *nearer += stated.e2 < 0.5 * e->e2 * width;
    const double bound = stated.total;
    if (!(error.maximum <= bound))
        print_error("%s, content %d: %.6g is beyond the bound %.6g (width %.3g)\n%s",
                    job->params.kernel.info->name, (int)content, error.maximum, bound, width,
                    weft_pass_plan_get_info(job->plan)->text);
    return error.maximum > 0.0 ? bound / error.maximum : (double)INFINITY;
}

// The part of E2 that counts samples, not coefficients: for signs that make the most of it, too.
// WEFT_PREFILTER_JOBS: how many.
static void prefiltered_plans_stay_within_their_bounds(void **state)
{
    (void)state;
    const int limit = getenv("WEFT_PREFILTER_JOBS") ? atoi(getenv("WEFT_PREFILTER_JOBS")) : 60;
    double *ratio[CONTENTS];
    int count[CONTENTS] = {0}, beyond = 0, nearer = 0;
    random_state = 19930213;
    for (int content = 0; content < CONTENTS; content++) {
        ratio[content] = malloc((size_t)limit * sizeof(double));
        assert_non_null(ratio[content]);
    }
    for (int made = 0, tried = 0; made < limit; tried++) {
        struct job job = {.params = random_prefiltered()};
        assert_true(tried < 2 * limit);
        if (weft_pass_plan_create(&job.params, &job.plan) != WEFT_OK)
            continue;
        make_prefiltered(&job);
        for (int content = 0; content < CONTENTS; content++) {
            const double r = check_prefiltered(&job, (enum content)content, &nearer);
            beyond += r < 1.0;
            ratio[content][count[content]++] = r;
        }
        clear_job(&job);
        made++;
    }
    print_message("%d prefiltered plans: %d beyond, %d bounds halved\n", limit, beyond, nearer);
    static const char *const names[] = {"noise", "alternating", "step", "adverse"};
    for (int content = 0; content < CONTENTS; content++)
        print_ratios(names[content], ratio[content], count[content]);
    assert_int_equal(beyond, 0);
    assert_true(nearer > limit);
    for (int content = 0; content < CONTENTS; content++)
        free(ratio[content]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(emulated_plans_stay_within_their_bounds),
        cmocka_unit_test(prefiltered_plans_stay_within_their_bounds),
        cmocka_unit_test_setup_teardown(drawn_plans_stay_within_their_bounds, create_contexts,
                                        destroy_contexts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
