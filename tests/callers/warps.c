// SPDX-License-Identifier: BSD-3-Clause
#include "tests/callers/callers.h"

static struct weft_warp_params warp_params(void)
{
    struct weft_warp_params params =
        *weft_warp_params(.size = {4, 4}, .engine = WEFT_ENGINE_CPU, .log = &logger);
    return params;
}

static void warp_plans(void)
{
    weft_warp_plan *plan = NULL;
    struct weft_warp_params good = warp_params();
    double position[2], scale[2], matrix[9];
    static float at[16];
#define CALL (weft_warp_plan_destroy(&plan), weft_warp_plan_create(&p, &plan))
    KERNELS_REFUSED(good, 1, CALL);
    SET_REFUSED(good, size[0], 0, CALL);
    SET_REFUSED(good, size[1], INT_MAX, CALL);
    SET_REFUSED(good, width, 5, CALL); // and a height of 0
    SET_REFUSED(good, height, INT_MIN, CALL);
    SET_REFUSED(good, kernel, named("bspline3+radial"), CALL);
    BAD_ENUM(good, map.kind, CALL);
    BAD_ENUM(good, boundary, CALL);
    BAD_ENUM(good, engine, CALL);
    BAD_ENUM(good, sums, CALL);
    for (int i = 0; i < 9; i++)
        ANY_NUMBER(good, map.matrix[i], CALL)
    ANY_NUMBER(good, map.source_corner[0], CALL)
    ANY_NUMBER(good, map.result_corner[1], CALL)
    good.map.kind = WEFT_WARP_POSITIONS;
    SET_REFUSED(good, map.stride, 0, CALL); // there are no planes
    good.map.position[0] = good.map.position[1] = at;
    SET_REFUSED(good, map.position[1], NULL, CALL);
    SET_REFUSED(good, map.stride, 3, CALL);
    SET_REFUSED(good, map.stride, INT64_MIN, CALL);
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        at[5] = (float)numbers[n];
        SURVIVED((weft_warp_plan_destroy(&plan), weft_warp_plan_create(&good, &plan)));
    }
#undef CALL
    TRUE(plan != NULL);
    TRUE(weft_warp_plan_get_info(plan)->method == WEFT_WARP_PLANES);
    for (size_t i = 0; i < WEFT_COUNT(ints); i++)
        weft_warp_position(plan, ints[i], ints[i], position, scale);
    TRUE(isnan(position[0]) && isnan(scale[1]));
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        weft_warp_matrix_rotate(numbers[n], numbers, matrix);
        weft_warp_matrix_affine(numbers, matrix);
    }
    weft_warp_plan_destroy(&plan);
    weft_warp_plan_destroy(NULL);
}

static void run_warps(double degrees)
{
    weft_context *context = open_context();
    weft_warp_plan *plan = NULL;
    weft_warp_compiled *compiled = NULL;
    weft_resample_source *source = NULL, *small = NULL, *wrapped = NULL;
    struct weft_warp_params params = warp_params();
    struct weft_resample_source_params from =
        *weft_resample_source_params(.width = 4, .height = 4, .plane = {voxels}, .log = &logger);
    struct weft_verify_report error;
    float out[16] = {0};
    weft_warp_matrix_rotate(degrees, (const double[]){2.0, 2.0}, params.map.matrix);
    SURVIVED(weft_warp_plan_create(&params, &plan));
    SURVIVED(weft_resample_source_create(&from, &source));
    from.boundary = WEFT_BOUNDARY_WRAP;
    SURVIVED(weft_resample_source_create(&from, &wrapped));
    from.width = 3;
    SURVIVED(weft_resample_source_create(&from, &small));
    const struct weft_resample_statistics none = {.low = NAN};
    TRUE(weft_warp_bound(plan, &weft_resample_source_get_info(source)->statistics, 0.0).total >
         0.0);
    weft_warp_bound(plan, &none, -1.0);
    REFUSED(weft_warp_compile(plan, weft_resample_compile_params(.context = context), &compiled));
    REFUSED(
        weft_warp_compile(plan, weft_resample_compile_params(.cpu = {.threads = -1}), &compiled));
    SURVIVED(weft_warp_compile(plan, weft_resample_compile_params(), &compiled));
    struct weft_warp_run_params good = {.source = source, .plane = {out}, .log = &logger};
#define CALL weft_warp_run(compiled, &p, NULL)
    SET_REFUSED(good, source, NULL, CALL);
    SET_REFUSED(good, source, small, CALL);
    SET_REFUSED(good, source, wrapped, CALL);
    SET_REFUSED(good, plane[0], NULL, CALL);
    SET_REFUSED(good, stride, 3, CALL);
    SET_REFUSED(good, stride, INT64_MIN, CALL);
    SET_REFUSED(good, part.width, 6, CALL);
    SET_REFUSED(good, part.x, -1, CALL);
#undef CALL
    SURVIVED(weft_warp_run(compiled, &good, NULL));
    struct weft_resample_verify_params pixels = {.source = source, .plane = {out}, .log = &logger};
#define CALL weft_warp_verify(plan, &p, &error)
    SET_REFUSED(pixels, source, NULL, CALL);
    SET_REFUSED(pixels, source, small, CALL);
    SET_REFUSED(pixels, plane[0], NULL, CALL);
    SET_REFUSED(pixels, stride, -5, CALL);
    SET_REFUSED(pixels, part.height, -1, CALL);
#undef CALL
    SURVIVED(weft_warp_verify(plan, &pixels, &error));
    weft_warp_compiled_destroy(&compiled);
    weft_warp_compiled_destroy(NULL);
    weft_resample_source_destroy(&source);
    weft_resample_source_destroy(&small);
    weft_resample_source_destroy(&wrapped);
    weft_warp_plan_destroy(&plan);
    weft_context_destroy(&context);
}

// By both ways: along the axes, and directly.
static void warp_runs(void)
{
    run_warps(90.0);
    run_warps(10.0);
}

const struct caller_case callers_warps[] = {
    {warp_plans,
     {F(warp_plan_create), F(warp_plan_destroy), F(warp_plan_get_info), F(warp_position),
      F(warp_matrix_affine), F(warp_matrix_rotate)}},
    {warp_runs,
     {F(warp_compile), F(warp_compiled_destroy), F(warp_run), F(warp_bound), F(warp_verify)}},
    {0},
};
