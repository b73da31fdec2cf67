// SPDX-License-Identifier: BSD-3-Clause
#include "tests/callers/callers.h"

static void separable(void)
{
    weft_context *context = open_context();
    float out[16];
    static double at[4] = {0.0, 1.0, 2.0, 3.0};
    struct weft_verify_report error;
    weft_separable_plan *made = NULL;
    weft_separable *compiled = NULL;
    struct weft_separable_params good = {
        .size = {4, 4}, .width = 4, .height = 4, .x = at, .y = at, .log = &logger};
#define CALL weft_separable_plan_create(&p, &made)
    KERNELS_REFUSED(good, 1, CALL);
    SET_REFUSED(good, size[0], 0, CALL);
    SET_REFUSED(good, size[1], INT_MIN, CALL);
    SET_REFUSED(good, size[1], INT_MAX, CALL);
    SET_REFUSED(good, width, -1, CALL);
    SET_REFUSED(good, height, 0, CALL);
    SET_REFUSED(good, x, NULL, CALL);
    BAD_ENUM(good, engine, CALL);
    BAD_ENUM(good, sums, CALL);
#undef CALL
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        at[2] = numbers[n];
        SURVIVED(weft_separable_plan_create(&good, &made));
        weft_separable_plan_destroy(&made);
    }
    at[2] = 2.0;
    good.memory_bytes = 1;
    TRUE(weft_separable_plan_create(&good, &made) == WEFT_OK);
    REFUSED(
        weft_separable_compile(made, weft_separable_compile_params(.context = context), &compiled));
    weft_separable_plan_destroy(&made);
    good.memory_bytes = 0;
    TRUE(weft_separable_plan_create(&good, &made) == WEFT_OK);
    REFUSED(weft_separable_compile(made, weft_separable_compile_params(), &compiled));
    TRUE(weft_separable_compile(made, weft_separable_compile_params(.context = context),
                                &compiled) == WEFT_OK);
    TRUE(weft_separable_plan_get_info(made)->width == 4);
    struct weft_separable_run_params run = {.samples = voxels, .pixels = out, .log = &logger};
#define CALL weft_separable_run(compiled, &p, NULL)
    SET_REFUSED(run, stride, -1, CALL);
    SET_REFUSED(run, stride, 3, CALL);
    SET_REFUSED(run, samples, NULL, CALL);
    SET_REFUSED(run, pixels, NULL, CALL);
    SET_REFUSED(run, part.x, -1, CALL);
    SET_REFUSED(run, part.width, 5, CALL);
    SET_REFUSED(run, window.height, -1, CALL);
    SET_REFUSED(run, window, ((struct weft_rectangle){1, 0, 3, 4}), CALL); // not all, no survey
#undef CALL
    SURVIVED(weft_separable_run(compiled, &run, NULL));
    struct weft_separable_survey survey = {0};
    TRUE(weft_separable_reach(made, &(struct weft_rectangle){.width = 9}).width == 0);
    REFUSED(weft_separable_survey_samples(
        made, weft_separable_run_params(.window = {.width = 9}, .samples = voxels, .log = &logger),
        &survey));
    REFUSED(
        weft_separable_survey_samples(made, weft_separable_run_params(.log = &logger), &survey));
    SURVIVED(weft_separable_survey_samples(made, &run, &survey));
    weft_separable_survey_join(&survey, &survey);
    TRUE(weft_separable_plan_error(made) > 0.0 &&
         weft_separable_plan_bound(made, 1.0, 0x1p-28).relative > 0.0);
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++)
        SURVIVED(weft_separable_verify(
            made, &run, &(struct weft_verify_params){.max_seconds = numbers[n]}, &error));
    weft_separable_destroy(&compiled);
    weft_separable_destroy(NULL);
    weft_separable_plan_destroy(&made);
    weft_separable_plan_destroy(NULL);
    EACH_BAD_KERNEL(
        0, if (k < 6 || k == 7) {
            weft_separable_error_bound(&kernel, WEFT_SUMS_DOUBLE);
            weft_separable_bound_terms(&kernel, WEFT_SUMS_FLOAT, 1.0, 0x1p-28);
        })
    weft_context_destroy(&context);
}

static struct weft_resample_params resample_params(void)
{
    struct weft_resample_params params =
        *weft_resample_params(.size = {4, 4}, .width = 5, .height = 3, .log = &logger);
    return params;
}

static void resample_plans(void)
{
    weft_resample_plan *plan = NULL;
    struct weft_resample_params good = resample_params();
#define CALL (weft_resample_plan_destroy(&plan), weft_resample_plan_create(&p, &plan))
    KERNELS_REFUSED(good, 1, CALL);
    SET_REFUSED(good, size[0], 0, CALL);
    SET_REFUSED(good, size[1], INT_MIN, CALL);
    SET_REFUSED(good, size[1], INT_MAX, CALL);
    SET_REFUSED(good, width, -1, CALL);
    SET_REFUSED(good, height, INT_MAX, CALL);
    SET_REFUSED(good, map[0].from, -1, CALL);
    SET_REFUSED(good, map[1].to, INT64_MAX, CALL);
    SET_REFUSED(good, map[1].pixel, INT64_MIN, CALL);
    BAD_ENUM(good, engine, CALL);
    BAD_ENUM(good, sums, CALL);
    BAD_ENUM(good, boundary, CALL);
    SET_REFUSED(good, sums, WEFT_SUMS_DOUBLE, CALL); // on OpenGL
    SET_REFUSED(good, kernel, named("bspline3+radial"), CALL);
    weft_pass_plan *passes[3] = {NULL};
    SURVIVED(weft_pass_plan_create(weft_pass_plan_params(.samples = 16), &passes[0]));
    SURVIVED(weft_pass_plan_create(weft_pass_plan_params(.dims = 3, .samples = 8), &passes[1]));
    SURVIVED(weft_pass_plan_create(
        weft_pass_plan_params(.derivative = {{1, 0, 0}}, .samples = 16, .profile = {.name = ""}),
        &passes[2]));
    SET_REFUSED(good, passes, passes[1], CALL);
    if (passes[2])
        SET_REFUSED(good, passes, passes[2], CALL);
    struct weft_resample_params multipass = good;
    multipass.passes = passes[0];
    SET_REFUSED(multipass, kernel, named("mitchell"), CALL);
    SET_REFUSED(multipass, memory_bytes, 10, CALL);
    weft_resample_plan_destroy(&plan);
    weft_resample_plan_destroy(NULL);
    for (int i = 0; i < 3; i++)
        weft_pass_plan_destroy(&passes[i]);
#undef CALL
}

static struct weft_resample_source_params source_params(void)
{
    struct weft_resample_source_params params =
        *weft_resample_source_params(.width = 4, .height = 4, .plane = {voxels}, .log = &logger);
    return params;
}

static void resample_sources(void)
{
    weft_resample_source *source = NULL;
    struct weft_resample_source_params good = source_params();
#define CALL (weft_resample_source_destroy(&source), weft_resample_source_create(&p, &source))
    KERNELS_REFUSED(good, 1, CALL);
    SET_REFUSED(good, width, 0, CALL);
    SET_REFUSED(good, height, INT_MAX, CALL);
    SET_REFUSED(good, channels, -1, CALL);
    SET_REFUSED(good, channels, 5, CALL);
    SET_REFUSED(good, channels, 2, CALL); // there is one plane
    SET_REFUSED(good, plane[0], NULL, CALL);
    SET_REFUSED(good, stride, 3, CALL);
    SET_REFUSED(good, stride, INT64_MIN, CALL);
    SET_REFUSED(good, window, ((struct weft_rectangle){0, 0, 4, 3}), CALL); // nothing is measured
    SET_REFUSED(good, window.width, 5, CALL);
    SET_REFUSED(good, threads, -1, CALL);
    ANY_NUMBER(good, low, CALL)
    ANY_NUMBER(good, high, CALL)
    weft_resample_source_destroy(&source);
    weft_resample_source_destroy(NULL);
#undef CALL
    struct weft_resample_measured measured = WEFT_RESAMPLE_MEASURED_NONE;
#define CALL weft_resample_measure(&p, 0, 4, true, &measured)
    SET_REFUSED(good, window.height, 5, CALL);
    SET_REFUSED(good, window, ((struct weft_rectangle){0, 1, 4, 3}), CALL);
    SET_REFUSED(good, window, ((struct weft_rectangle){0, 0, 3, 4}), CALL);
    SET_REFUSED(good, plane[0], NULL, CALL);
#undef CALL
    REFUSED(weft_resample_measure(&good, -1, 1, false, &measured));
    REFUSED(weft_resample_measure(&good, 3, 2, false, &measured));
    SURVIVED(weft_resample_measure(&good, 0, 4, true, &measured));
    weft_resample_measured_join(&measured, &measured);
}

static void resample_runs(void)
{
    weft_context *context = open_context();
    weft_resample_plan *plan = NULL;
    weft_resample_compiled *compiled = NULL;
    weft_resample_source *source = NULL, *small = NULL, *spline = NULL;
    struct weft_resample_params params = resample_params();
    struct weft_resample_source_params from = source_params();
    struct weft_verify_report error;
    struct weft_resample_work sum = {0};
    float out[15] = {0};
    SURVIVED(weft_resample_plan_create(&params, &plan));
    SURVIVED(weft_resample_source_create(&from, &source));
    from.width = 3;
    SURVIVED(weft_resample_source_create(&from, &small));
    from = source_params();
    from.kernel = named("bspline3i");
    SURVIVED(weft_resample_source_create(&from, &spline));
    TRUE(weft_resample_plan_get_info(plan)->width == 5);
    TRUE(weft_resample_source_get_info(source)->channels == 1);
    const struct weft_resample_statistics none = {.low = NAN};
    TRUE(weft_resample_bound(plan, &weft_resample_source_get_info(source)->statistics, 0.0).total >=
         0.0);
    weft_resample_bound(plan, &none, -1.0);
    TRUE(weft_resample_e1(source) > 0.0);
    REFUSED(
        weft_resample_compile(plan, weft_resample_compile_params(), &compiled)); // planned for GL
    SURVIVED(
        weft_resample_compile(plan, weft_resample_compile_params(.context = context), &compiled));
    TRUE(weft_resample_compiled_get_info(compiled)->tile_bytes == 0);
    struct weft_resample_run_params good = {.source = source, .plane = {out}, .log = &logger};
#define CALL weft_resample_run(compiled, &p, NULL)
    SET_REFUSED(good, source, NULL, CALL);
    SET_REFUSED(good, source, small, CALL);
    SET_REFUSED(good, source, spline, CALL);
    SET_REFUSED(good, plane[0], NULL, CALL);
    SET_REFUSED(good, stride, 4, CALL);
    SET_REFUSED(good, stride, INT64_MIN, CALL);
    SET_REFUSED(good, part.width, 6, CALL);
    SET_REFUSED(good, part.x, -1, CALL);
#undef CALL
    TRUE(weft_resample_reach(plan, &(struct weft_rectangle){.y = 99}).width == 0);
    struct weft_resample_survey survey = {{{0}}};
    REFUSED(weft_resample_survey_source(plan, small, &survey));
    REFUSED(weft_resample_survey_source(plan, NULL, &survey));
    SURVIVED(weft_resample_survey_source(plan, source, &survey));
    weft_resample_survey_join(&survey, &survey);
    SURVIVED(weft_resample_run(compiled, &good, NULL));
    struct weft_resample_verify_params pixels = {.source = source, .plane = {out}, .log = &logger};
#define CALL weft_resample_verify(plan, &p, &error)
    SET_REFUSED(pixels, source, NULL, CALL);
    SET_REFUSED(pixels, source, small, CALL);
    SET_REFUSED(pixels, plane[0], NULL, CALL);
    SET_REFUSED(pixels, stride, -5, CALL);
    SET_REFUSED(pixels, part.height, -1, CALL);
#undef CALL
    SURVIVED(weft_resample_verify(plan, &pixels, &error));
    weft_resample_work_add(&sum, &(struct weft_resample_work){.pass_seconds = NAN});
    weft_resample_compiled_destroy(&compiled);
    weft_resample_compiled_destroy(NULL);
    weft_resample_source_destroy(&source);
    weft_resample_source_destroy(&small);
    weft_resample_source_destroy(&spline);
    weft_resample_plan_destroy(&plan);
    weft_context_destroy(&context);
}

static void resample_integers(void)
{
    static const uint32_t codes[20] = {7, UINT32_MAX}; // height 5 is read, too
    weft_resample_plan *plan = NULL, *filter = NULL;
    struct weft_resample_params params = resample_params();
    struct weft_verify_report error;
    uint32_t out[15], range[2];
    SURVIVED(weft_resample_plan_create(&params, &filter));
    params.kernel = named("nearest");
    SURVIVED(weft_resample_plan_create(&params, &plan));
    EACH_BAD_KERNEL(0, weft_resample_moves(&kernel))
    struct weft_resample_integers good = {.width = 4, .height = 4, .plane = codes};
#define MOVE(plan, stride)                                                                         \
    (weft_resample_move_verify(plan, &p, NULL, out, stride, NULL, &error),                         \
     weft_resample_integer_range(&p, range), weft_resample_move(plan, &p, NULL, out, stride))
    SET_REFUSED(good, width, 0, MOVE(plan, 0));
    SET_REFUSED(good, height, 5, MOVE(plan, 0));
    SET_REFUSED(good, plane, NULL, MOVE(plan, 0));
    SET_REFUSED(good, stride, 3, MOVE(plan, 0));
    SET_REFUSED(good, stride, INT64_MIN, MOVE(plan, 0));
    SET_REFUSED(good, width, 4, MOVE(plan, 4));
    SET_REFUSED(good, width, 4, MOVE(filter, 0));
    SET_REFUSED(good, window.width, 5, MOVE(plan, 0));
    SET_REFUSED(good, window, ((struct weft_rectangle){0, 0, 1, 1}), MOVE(plan, 0));
#undef MOVE
    weft_resample_integer_range(&good, range);
    TRUE(range[0] == 0 && range[1] == UINT32_MAX);
    SURVIVED(weft_resample_move(plan, &good, NULL, out, 0));
    SURVIVED(weft_resample_move_verify(plan, &good, NULL, out, 5, NULL, &error));
    TRUE(error.maximum == 0.0);
    weft_resample_plan_destroy(&plan);
    weft_resample_plan_destroy(&filter);
}

static void resample_choices(void)
{
    weft_resample_source *source = NULL;
    struct weft_resample_source_params from = source_params();
    struct weft_resample_choice choice = {0};
    SURVIVED(weft_resample_source_create(&from, &source));
    const double max_error = 1.0, none = 0.0, nan = NAN;
    const weft_resample_source *sources[1] = {source};
    struct weft_resample_choose_params good = {.passes = {.samples = 16},
                                               .sources = sources,
                                               .max_error = &max_error,
                                               .source_count = 1,
                                               .width = 4,
                                               .height = 4,
                                               .log = &logger};
#define CALL (weft_resample_choice_clear(&choice), weft_resample_choose(&p, &choice))
    SET_REFUSED(good, sources, NULL, CALL);
    SET_REFUSED(good, source_count, 0, CALL);
    SET_REFUSED(good, max_error, NULL, CALL);
    SET_REFUSED(good, max_error, &none, CALL);
    SET_REFUSED(good, max_error, &nan, CALL);
    SET_REFUSED(good, width, 0, CALL);
    SET_REFUSED(good, height, INT_MIN, CALL);
#undef CALL
    SURVIVED(weft_resample_choose(&good, &choice));
    weft_resample_choice_clear(&choice);
    struct weft_resample_engine_params engines = {
        .plan = {.size = {3, 2}, .width = 4, .height = 4, .log = &logger},
        .sources = sources,
        .max_error = &max_error,
        .source_count = 1,
        .log = &logger};
#define CALL (weft_resample_choice_clear(&choice), weft_resample_choose_engine(&p, &choice))
    SET_REFUSED(engines, sources, NULL, CALL);
    SET_REFUSED(engines, source_count, 0, CALL);
    const double below = -1.0;
    SET_REFUSED(engines, max_error, &below, CALL);
    SET_REFUSED(engines, max_error, &nan, CALL);
    SET_REFUSED(engines, engines, 99, CALL);
    SET_REFUSED(engines, threads, -1, CALL);
    SET_REFUSED(engines, plan.width, 0, CALL);
    SET_REFUSED(engines, plan.passes, (const weft_pass_plan *)&none, CALL);
#undef CALL
    SURVIVED(weft_resample_choose_engine(&engines, &choice));
    TRUE(choice.separable != NULL);
    weft_resample_choice_clear(&choice);
    weft_resample_source_destroy(&source);
}

const struct caller_case callers_images[] = {
    {separable,
     {F(separable_plan_create), F(separable_plan_destroy), F(separable_plan_get_info),
      F(separable_compile), F(separable_destroy), F(separable_run), F(separable_verify),
      F(separable_error_bound), F(separable_bound_terms), F(separable_plan_error),
      F(separable_plan_bound), F(separable_reach), F(separable_survey_samples),
      F(separable_survey_join)}},
    {resample_plans, {F(resample_plan_create), F(resample_plan_destroy)}},
    {resample_sources,
     {F(resample_source_create), F(resample_source_destroy), F(resample_measure),
      F(resample_measured_join)}},
    {resample_runs,
     {F(resample_compile), F(resample_compiled_destroy), F(resample_compiled_get_info),
      F(resample_run), F(resample_verify), F(resample_plan_get_info), F(resample_source_get_info),
      F(resample_bound), F(resample_e1), F(resample_work_add), F(resample_reach),
      F(resample_survey_source), F(resample_survey_join)}},
    {resample_integers,
     {F(resample_moves), F(resample_integer_range), F(resample_move), F(resample_move_verify)}},
    {resample_choices, {F(resample_choose), F(resample_choose_engine), F(resample_choice_clear)}},
    {0},
};
