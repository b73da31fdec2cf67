// SPDX-License-Identifier: BSD-3-Clause
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "tests/support/contexts.h"
#include "tests/support/slice_jobs.h"

enum { JOBS = 150 };

static struct weft_method random_method(struct random *r)
{
    if (below(r, 6) == 0)
        return (struct weft_method){.algorithm = WEFT_ALGORITHM_SEPARABLE,
                                    .engine = (enum weft_engine)below(r, 2)};
    if (below(r, 4) == 0)
        return (struct weft_method){.engine = WEFT_ENGINE_CPU, .sums = (enum weft_sums)below(r, 2)};
    if (below(r, 25) == 0)
        return (struct weft_method){.algorithm = WEFT_ALGORITHM_HARDWARE,
                                    .source = (enum weft_source_format)below(r, 4)};
    return (struct weft_method){.layout = (enum weft_layout)(1 + below(r, 3)),
                                .source = (enum weft_source_format)below(r, 4),
                                .lookup = (enum weft_lookup)below(r, 3),
                                .samples = 1 << below(r, 10)};
}

// ---- tests --------------------------------------------------------------------------------------

// What may be unsupported: separable methods, of slices that are not along the axes; hardware, of
// one tap, or clamped; and logarithms, of voxels below 0.
static bool may_be_refused(const struct job *job)
{
    const struct weft_method *method = &job->params.method;
    return method->algorithm == WEFT_ALGORITHM_SEPARABLE ||
           (method->algorithm == WEFT_ALGORITHM_HARDWARE &&
            (job->params.slice.kernel.width == 1 || job->params.slice.clamp_to_samples)) ||
           (method->algorithm == WEFT_ALGORITHM_MULTIPASS &&
            method->technique == WEFT_TECHNIQUE_LOG && job->params.statistics.low < 0.0);
}

// Runs one method and checks every pixel against the bound. Returns false where it is unsupported.
static bool check(weft_context *context, const struct job *job, const char *what,
                  struct weft_method_report *report, unsigned *savings, double *tightness)
{
    weft_method_plan *plan = NULL;
    enum weft_result res = weft_method_plan_create(job->volume, &job->params, &plan);
    if (res == WEFT_ERR_UNSUPPORTED && may_be_refused(job))
        return false;
    assert_int_equal(res, WEFT_OK);
    const struct weft_slice_geometry *g = &job->params.slice.geometry;
    const struct weft_method_plan_info *info = weft_method_plan_get_info(plan);
    float *pixels = malloc((size_t)g->width * (size_t)g->height * sizeof *pixels);
    struct weft_verify_report error;
    assert_non_null(pixels);
    assert_int_equal(
        weft_method_run(plan, weft_method_run_params(.context = context, .pixels = pixels), report),
        WEFT_OK);
    assert_int_equal(weft_slice_verify(weft_method_plan_get_slice(plan), pixels, NULL, &error),
                     WEFT_OK);
    if (!(error.maximum <= info->bound) || error.not_finite_mismatches)
        fail_msg("%s: %s with %s: error %.3g at (%d, %d) of %dx%d, %.9g instead of %.9g; the bound "
                 "is %.3g; %d not finite",
                 what, info->name, job->params.slice.kernel.info->name, error.maximum, error.at_x,
                 error.at_y, g->width, g->height, error.at_value, error.at_reference, info->bound,
                 (int)error.not_finite_mismatches);
    *savings |= info->slice->savings;
    *tightness = fmin(*tightness, info->bound / error.maximum);
    free(pixels);
    weft_method_plan_destroy(&plan);
    return true;
}

static void fused_methods_stay_within_their_bounds(void **state)
{
    (void)state;
    struct random r = {5};
    double tightness = INFINITY;
    uint64_t constant = 0, smooth = 0;
    unsigned savings = 0;
    int ran = 0, certain = 0;
    for (int i = 0; i < JOBS; i++) {
        struct job job;
        struct weft_method_report report;
        char what[32];
        snprintf(what, sizeof what, "job %d", i);
        set_job(&r, 1, &job);
        job.params.method = random_method(&r);
        job.params.slice.without = below(&r, 2) ? 0u : (unsigned)below(&r, WEFT_SAVING_ALL + 1);
        job.params.slice.clamp_to_samples =
            below(&r, 6) == 0 && !job.params.slice.kernel.prefiltered;
        if (below(&r, 2))
            job.params.slice.smooth_error =
                (job.params.statistics.high - job.params.statistics.low) *
                ldexp(1.0, -4 - below(&r, 12));
        weft_context *context = contexts[contexts[1] ? i % 2 : 0];
        certain += !may_be_refused(&job);
        if (check(context, &job, what, &report, &savings, &tightness))
            ran++;
        else
            report = (struct weft_method_report){0};
        constant += report.slice.cells_constant;
        smooth += report.slice.cells_smooth;
        weft_volume_destroy(&job.volume);
    }
    print_message(
        "%d of %d methods ran; bound / error: least %.3g; cells found constant %d, smooth "
        "%d\n",
        ran, (int)JOBS, tightness, (int)constant, (int)smooth);
    assert_in_range(certain, JOBS / 2, ran - 1); // and some that are separable
    assert_true(constant > 0 && smooth > 0);
    assert_int_equal(savings, WEFT_SAVING_ALL);
}

static void listed_methods_stay_within_their_bounds(void **state)
{
    (void)state;
    struct random r = {11};
    struct weft_method *methods = NULL;
    size_t count = 0, ran = 0, certain = 0;
    unsigned savings = 0;
    double tightness = INFINITY;
    assert_int_equal(weft_method_list(&log_to_stderr, &methods, &count), WEFT_OK);
    for (size_t i = 0; i < count; i++) {
        struct job job;
        struct weft_method_report report;
        char what[32], name[96], other[96];
        weft_method_format(&methods[i], name, sizeof name);
        for (size_t k = 0; k < i; k++) {
            weft_method_format(&methods[k], other, sizeof other);
            assert_string_not_equal(name, other);
        }
        snprintf(what, sizeof what, "method %d", (int)i);
        set_job(&r, 1, &job);
        job.params.method = methods[i];
        // Planning others takes long with many taps or samples.
        if (methods[i].algorithm == WEFT_ALGORITHM_MULTIPASS) {
            job.params.slice.kernel = kernel_named(i % 2 ? "linear" : "mitchell");
            job.params.method.samples = 16;
        }
        certain += !may_be_refused(&job);
        ran += check(contexts[0], &job, what, &report, &savings, &tightness);
        weft_volume_destroy(&job.volume);
    }
    print_message("%d of %d methods ran; bound / error: least %.3g\n", (int)ran, (int)count,
                  tightness);
    assert_in_range(certain, count - 5,
                    ran); // all but one separable method and a few of logarithms
    free(methods);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fused_methods_stay_within_their_bounds),
        cmocka_unit_test(listed_methods_stay_within_their_bounds),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
