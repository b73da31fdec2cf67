// SPDX-License-Identifier: BSD-3-Clause
#include "tests/callers/callers.h"

static void cpus(void)
{
    struct weft_cpu good = {.threads = 1}, out;
    TRUE(weft_cpu_threads() > 0);
    TRUE(weft_instruction_set_runs(weft_instruction_set_best()));
    for (size_t i = 0; i < WEFT_COUNT(bad_enums); i++)
        TRUE(!weft_instruction_set_runs((enum weft_instruction_set)bad_enums[i]));
#define CALL weft_cpu_resolve(&logger, &p, &out)
    SURVIVED(weft_cpu_resolve(&logger, &good, &out));
    SET_REFUSED(good, threads, -1, CALL);
    SET_REFUSED(good, threads, WEFT_CPU_MAX_THREADS + 1, CALL);
    BAD_ENUM(good, instructions, CALL);
#undef CALL
}

static void layouts(void)
{
    enum weft_context_kind kind;
    struct weft_profile profile;
    struct weft_cost_model model;
    REFUSED(weft_context_kind_parse(&logger, "", &kind));
    REFUSED(weft_profile_parse(&logger, "", &profile));
    REFUSED(weft_profile_parse(&logger, "bits=1e99", &profile));
    REFUSED(weft_cost_parse(&logger, "voxel nan", &model));
}

static bool never_current(void *priv)
{
    (void)priv;
    return false;
}

static void contexts(void)
{
    weft_context *context = NULL;
    struct weft_context_params good = {.log = &logger};
    weft_context_making *making = NULL;
    BAD_ENUM(good, kind, weft_context_create(&p, &context));
    BAD_ENUM(good, kind, weft_context_begin(&p, &making));
    SET_REFUSED(good, egl_share, &context, weft_context_create(&p, &context));
    SET_REFUSED(good, caller.make_current, never_current, weft_context_create(&p, &context));
    SET_REFUSED(good, caller.make_current, never_current, weft_context_begin(&p, &making));
    TRUE(weft_context_begin(&good, &making) == WEFT_OK);
    weft_context_abandon(&making);
    weft_context_abandon(&making);
    weft_context_abandon(NULL);
    TRUE(weft_context_begin(&good, &making) == WEFT_OK);
    weft_context_await(&making, &context); // where none is to be had it stays NULL
    weft_context_destroy(&context);
    weft_context_destroy(NULL);
}

static void samplers(void)
{
    weft_context *context = NULL;
    struct weft_sampler sampler;
    if (weft_context_create(weft_context_params(.log = &logger), &context) != WEFT_OK)
        exit(CALLERS_SKIPPED);
    callers_lines = 0;
    for (size_t i = 0; i < WEFT_COUNT(bad_enums); i++) {
        const enum weft_source_format bad = (enum weft_source_format)bad_enums[i];
        REFUSED(weft_sampler_measure(context, bad, &sampler));
        TRUE(weft_sampler_assume(bad).max_size == 0);
    }
    SURVIVED(weft_sampler_measure(context, WEFT_SOURCE_FLOAT, &sampler));
    weft_context_destroy(&context);
}

static void textures(void)
{
    float values[4] = {0.0f};
    float *planes[4] = {values, values, values, values};
    const float *const *from = (const float *const *)planes;
    weft_context *context = NULL;
    struct weft_texture good = {.name = 1};
    if (weft_context_create(weft_context_params(.log = &logger), &context) != WEFT_OK)
        exit(CALLERS_SKIPPED);
    callers_lines = 0;
    REFUSED(weft_texture_read(context, NULL, 1, 1, 1, planes, 0));
    REFUSED(weft_texture_write(context, &good, 1, 1, 1, NULL, 0));
    ANY_INT(good, name, weft_texture_write(context, &p, 1, 1, 1, from, 0));
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        REFUSED(weft_texture_read(context, &good, ints[i], 1, 1, planes, 0));
        REFUSED(weft_texture_write(context, &good, 1, ints[i], 1, from, 0));
        REFUSED(weft_texture_write(context, &good, 1, 1, ints[i], from, 0)); // there is none
        REFUSED(weft_texture_read(context, &good, 1, 1, 1, planes, ints[i]));
        SET_REFUSED(good, level, ints[i], weft_texture_read(context, &p, 1, 1, 1, planes, 0));
        SET_REFUSED(good, x, ints[i], weft_texture_read(context, &p, 1, 1, 1, planes, 0));
        SET_REFUSED(good, channel, ints[i], weft_texture_write(context, &p, 1, 1, 1, from, 0));
    }
    weft_context_destroy(&context);
}

static void stability(void)
{
    struct weft_stability_result result;
    struct weft_stability_params params = {.data_folder = "/nonexistent", .log = &logger};
    SURVIVED(weft_stability_run(weft_stability_find("order-2d"), &params, &result));
}

const struct caller_case callers_engines[] = {
    {cpus, {F(cpu_threads), F(cpu_resolve), F(instruction_set_best), F(instruction_set_runs)}},
    {layouts, {F(context_kind_parse), F(profile_parse), F(cost_parse)}},
    {contexts,
     {F(context_create), F(context_destroy), F(context_begin), F(context_await),
      F(context_abandon)}},
    {samplers, {F(sampler_assume), F(sampler_measure)}},
    {textures, {F(texture_read), F(texture_write)}},
    {stability, {F(stability_run)}},
    {0},
};
