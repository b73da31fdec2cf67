// SPDX-License-Identifier: BSD-3-Clause
#include "tests/callers/callers.h"

static enum weft_result make_plan(const struct weft_pass_plan_params *p)
{
    weft_pass_plan *plan = NULL;
    const enum weft_result res = weft_pass_plan_create(p, &plan);
    weft_pass_plan_destroy(&plan);
    return res;
}

static void plans(void)
{
    struct weft_pass_plan_params good = {.samples = 8, .log = &logger, .memory_bytes = 1 << 24};
#define CALL make_plan(&p)
    KERNELS_REFUSED(good, 1, CALL);
    ANY_INT(good, dims, CALL);
    for (int a = 0; a < 3; a++)
        ANY_INT(good, derivative.along[a], CALL);
    ANY_INT(good, taps_per_pass, CALL);
    ANY_INT(good, samples, CALL);
    ANY_INT(good, bits, CALL);
    ANY_INT(good, channels, CALL);
    BAD_ENUM(good, technique, CALL);
    BAD_ENUM(good, worst_case, CALL);
    BAD_ENUM(good, order, CALL);
    struct weft_pass_plan_params own = good;
    own.profile = *weft_profile_find("radeon8500");
    BAD_ENUM(own, profile.target, CALL);
    ANY_INT(own, profile.internal_bits, CALL);
    ANY_INT(own, profile.taps_per_pass, CALL);
    ANY_INT(own, profile.dot_width, CALL);
    ANY_INT(own, profile.max_scale, CALL);
    ANY_NUMBER(own, profile.internal_range, CALL);
    struct weft_pass_plan_params endless = own;
    memset(endless.profile.name, 'x', sizeof endless.profile.name);
    REFUSED(make_plan(&endless));
    struct weft_tile_name names[1] = {{{0}, WEFT_TILE_WHOLE, 0}};
    const struct weft_pass_plan_split splits[1] = {
        {{{99, -1, INT_MAX}, (enum weft_tile_part)77, -5}, NAN}};
    struct weft_pass_plan_params given = good;
    given.order = WEFT_ORDER_GIVEN;
    given.tile_order = names;
    given.tile_order_count = 1;
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        names[0] = (struct weft_tile_name){{ints[i], 0, 0}, WEFT_TILE_WHOLE, ints[i]};
        SURVIVED(make_plan(&given));
    }
    for (size_t i = 0; i < WEFT_COUNT(bad_enums); i++) {
        names[0].part = (enum weft_tile_part)bad_enums[i];
        REFUSED(make_plan(&given));
    }
    struct weft_pass_plan_params split = good;
    split.splits = splits;
    split.split_count = 1;
    REFUSED(make_plan(&split));
#undef CALL
    weft_pass_plan_destroy(NULL);
}

static void plan_questions(void)
{
    weft_pass_plan *made = plan(2);
    TRUE(weft_pass_plan_get_info(made)->tile_count > 0);
    const weft_kernel_tiles *tiles = weft_pass_plan_get_info(made)->passes->tiles;
    char text[WEFT_TILE_NAME_TEXT];
    struct weft_tile_name name;
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        name = weft_tile_name_of(tiles, ints[i], i % 2);
        TRUE(weft_tile_name_format(&name, ints[i], text) == text);
        name = (struct weft_tile_name){
            {ints[i], ints[i], ints[i]}, (enum weft_tile_part)ints[i], ints[i]};
        TRUE(weft_tile_name_format(&name, ints[i], text) == text);
        TRUE(weft_tile_name_find(tiles, &name) < weft_pass_plan_get_info(made)->tile_count);
        weft_tile_name_parse("1,2,3-/4", ints[i], &name);
    }
    TRUE(!weft_tile_name_parse("", 2, &name) && !weft_tile_name_parse("1,-2", 2, &name));
    TRUE(!weft_tile_name_parse("1,100000", 2, &name) && !weft_tile_name_parse("1,2/", 2, &name));
    weft_pass_plan_destroy(&made);
}

static void profiles(void)
{
    struct weft_profile bad = {0};
    REFUSED(weft_profile_check(&logger, &bad));
    bad = *weft_profile_find("unorm8");
    TRUE(weft_profile_check(&logger, &bad) == WEFT_OK);
    bad.target = (enum weft_target_format)77;
    REFUSED(weft_profile_check(&logger, &bad));
}

static void ranges(void)
{
    weft_pass_plan *made = plan(2);
    struct weft_pass_list good = *weft_pass_plan_get_info(made)->passes;
    struct weft_range_report report;
#define CALL weft_range_simulate(&logger, &p, WEFT_WORST_CONSTANT, NULL, NULL, &report)
    for (size_t i = 0; i < WEFT_COUNT(bad_enums); i++)
        REFUSED(weft_range_simulate(&logger, &good, (enum weft_worst_case)bad_enums[i], NULL, NULL,
                                    &report));
    TRUE(weft_pass_list_check(&logger, &good) == WEFT_OK);
    BAD_ENUM(good, target, weft_pass_list_check(&logger, &p));
    SET_REFUSED(good, passes, NULL, weft_pass_list_check(&logger, &p));
    SET_REFUSED(good, slot_count, 0, weft_pass_list_check(&logger, &p));
    BAD_ENUM(good, target, CALL);
    ANY_INT(good, dims, CALL);
    ANY_INT(good, dot_width, CALL);
    ANY_INT(good, extra_bits, CALL);
    ANY_INT(good, result, CALL);
    ANY_NUMBER(good, range, CALL);
    ANY_NUMBER(good, result_scale, CALL);
    SET_REFUSED(good, slot_count, -1, CALL);
    SET_REFUSED(good, slot_count, 0, CALL);
    SET_REFUSED(good, pass_count, -1, CALL);
    struct weft_pass pass = good.passes[0];
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        struct weft_pass_list p = good;
        p.passes = &pass;
        p.pass_count = 1;
#define MEMBER(member)                                                                             \
    pass = good.passes[0];                                                                         \
    pass.member = (__typeof__(pass.member))ints[i];                                                \
    SURVIVED(CALL)
        MEMBER(kind);
        MEMBER(target);
        MEMBER(initial);
        MEMBER(part);
        MEMBER(bias);
        MEMBER(divisor);
        MEMBER(group_first);
        MEMBER(group_count);
        MEMBER(input_count);
        pass = (struct weft_pass){.kind = WEFT_PASS_COMBINE,
                                  .input_count = 1,
                                  .denominator = ints[i],
                                  .input = {ints[i]},
                                  .numerator = {ints[i]}};
        SURVIVED(CALL);
#undef MEMBER
    }
#undef CALL
    weft_pass_plan_destroy(&made);
}

static enum weft_result judge_plan(const struct weft_pass_plan_params *params,
                                   const struct weft_pass_list *passes)
{
    weft_pass_plan *judged = NULL;
    const enum weft_result res = weft_pass_plan_judge(params, passes, &judged);
    weft_pass_plan_destroy(&judged);
    return res;
}

static void judgements(void)
{
    weft_pass_plan *made = plan(2);
    struct weft_pass_list good = *weft_pass_plan_get_info(made)->passes;
    struct weft_pass_plan_params params =
        *weft_pass_plan_params(.kernel = named("linear"), .samples = 8, .memory_bytes = 1 << 22,
                               .log = &logger);
#define CALL judge_plan(&params, &p)
    TRUE(judge_plan(&params, &good) == WEFT_OK);
    TRUE(weft_pass_work_of(weft_pass_plan_get_info(made)).passes > 0.0);
    ANY_INT(good, extra_bits, CALL);
    ANY_INT(good, result, CALL);
    ANY_INT(good, pattern[1][0], CALL);
    ANY_NUMBER(good, result_scale, CALL);
    ANY_NUMBER(good, result_bias, CALL);
    SET_REFUSED(good, result_scale, NAN, CALL);
    SET_REFUSED(good, pass_count, -1, CALL);
    struct weft_pass pass;
    struct weft_tap_group group;
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        struct weft_pass_list p = good;
        p.passes = &pass;
        p.pass_count = 1;
#define MEMBER(member)                                                                             \
    pass = good.passes[0];                                                                         \
    pass.member = (__typeof__(pass.member))ints[i];                                                \
    SURVIVED(CALL)
        MEMBER(kind);
        MEMBER(target);
        MEMBER(initial);
        MEMBER(part);
        MEMBER(bias);
        MEMBER(divisor);
        MEMBER(group_first);
        MEMBER(group_count);
        MEMBER(input_count);
        pass = (struct weft_pass){.kind = WEFT_PASS_COMBINE,
                                  .input_count = 1,
                                  .denominator = ints[i],
                                  .input = {ints[i]},
                                  .numerator = {ints[i]}};
        SURVIVED(CALL);
#undef MEMBER
        pass = good.passes[0];
        pass.group_first = 0;
        pass.group_count = 1;
        p.groups = &group;
        p.group_count = 1;
#define MEMBER(member)                                                                             \
    group = good.groups[0];                                                                        \
    group.member = ints[i];                                                                        \
    SURVIVED(CALL)
        MEMBER(offset[0]);
        MEMBER(tile[0]);
        MEMBER(sign[0]);
        MEMBER(shift[0]);
#undef MEMBER
    }
    BAD_ENUM(params, technique, judge_plan(&p, &good));
#undef CALL
    weft_pass_plan_destroy(&made);
}

static void convolutions(weft_context *context)
{
    weft_pass_plan *made = plan(2);
    float out[16];
    const struct weft_samples samples = {.size = {8, 8, 1}, .plane = {voxels}};
    const struct weft_pixel_grid grid = {
        .width = 4, .height = 4, .du = {1.0, 0.0, 0.0}, .dv = {0.0, 1.0, 0.0}};
    struct weft_samples s = samples;
    struct weft_pixel_grid g = grid;
    const struct weft_multipass_run_params params = {
        .samples = &s, .grid = &g, .pixels = {out}, .log = &logger};
    const struct weft_multipass_verify_params verify = {
        .plan = made, .samples = &s, .grid = &g, .pixels = {out}, .log = &logger};
    struct weft_verify_report error;
    weft_multipass *compiled = NULL;
    REFUSED(weft_multipass_compile(context, weft_multipass_params(.log = &logger), &compiled));
    TRUE(weft_multipass_compile(context, weft_multipass_params(.plan = made, .log = &logger),
                                &compiled) == WEFT_OK);
    TRUE(weft_multipass_get_info(compiled)->tile_bytes > 0);
#define RUN weft_multipass_run(compiled, &params, NULL)
#define EACH(target, good, list, what)                                                             \
    for (size_t i = 0; i < WEFT_COUNT(list); i++) {                                                \
        target = list[i];                                                                          \
        what(RUN);                                                                                 \
        if (!context)                                                                              \
            what(weft_multipass_verify(&verify, &error));                                          \
        s = samples;                                                                               \
        g = grid;                                                                                  \
    }
    static const int bad_sizes[] = {INT_MIN, -1, 0};
    EACH(s.size[0], samples, bad_sizes, REFUSED)
    EACH(s.size[2], samples, bad_sizes, REFUSED)
    EACH(g.width, grid, bad_sizes, REFUSED)
    EACH(g.height, grid, bad_sizes, REFUSED)
    EACH(s.low, samples, numbers, SURVIVED)
    EACH(s.high, samples, numbers, SURVIVED)
    EACH(g.origin[0], grid, numbers, SURVIVED)
    EACH(g.du[1], grid, numbers, SURVIVED)
#undef EACH
#undef RUN
    weft_multipass_destroy(&compiled);
    weft_multipass_destroy(NULL);
    weft_pass_plan_destroy(&made);
}

static void emulations(void)
{
    convolutions(NULL);
}

static void convolutions_on_gl(void)
{
    weft_context *context = open_context();
    convolutions(context);
    weft_context_destroy(&context);
}

const struct caller_case callers_plans[] = {
    {plans, {F(pass_plan_create), F(pass_plan_destroy)}},
    {plan_questions,
     {F(pass_plan_get_info), F(tile_name_of), F(tile_name_find), F(tile_name_format),
      F(tile_name_parse)}},
    {profiles, {F(profile_check)}},
    {ranges, {F(range_simulate), F(pass_list_check)}},
    {judgements, {F(pass_plan_judge), F(pass_work_of)}},
    {emulations, {F(multipass_compile), F(multipass_destroy), F(multipass_verify)}},
    {convolutions_on_gl,
     {F(multipass_run), F(multipass_get_info), F(context_get_info), F(context_find_function),
      F(context_call)}},
    {0},
};
