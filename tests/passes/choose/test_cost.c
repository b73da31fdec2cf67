// SPDX-License-Identifier: BSD-3-Clause
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "tests/support/contexts.h"
#include "weft.h"

// ---- text ---------------------------------------------------------------------------------------

static const double *numbers(const struct weft_cost_model *model, size_t *count)
{
    *count = (sizeof *model - offsetof(struct weft_cost_model, start)) / sizeof(double);
    return model->start;
}

static void texts_come_back(void **state)
{
    (void)state;
    struct weft_cost_model model = weft_cost_default, back;
    snprintf(model.renderer, sizeof model.renderer, "llvmpipe (LLVM 15, 256 bits)");
    model.instructions = WEFT_INSTRUCTIONS_AVX2;
    model.threads = 6;
    char *text = weft_cost_format(&model);
    assert_non_null(text);
    assert_int_equal(weft_cost_parse(&log_to_stderr, text, &back), WEFT_OK);
    assert_string_equal(back.renderer, model.renderer);
    assert_int_equal(back.instructions, model.instructions);
    assert_int_equal(back.threads, model.threads);
    size_t count;
    const double *a = numbers(&model, &count), *b = numbers(&back, &count);
    for (size_t i = 0; i < count; i++)
        assert_near(b[i], a[i], 1e-5 * a[i], "a number");
    text[strlen(text) - 1] = 0; // without the last line's end
    assert_int_equal(weft_cost_parse(&log_to_stderr, text, &back), WEFT_OK);
    free(text);
}

// `text` with `from` replaced by `to`, once.
static char *replaced(const char *text, const char *from, const char *to)
{
    const char *at = strstr(text, from);
    assert_non_null(at);
    char *out = malloc(strlen(text) + strlen(to) + 1);
    assert_non_null(out);
    sprintf(out, "%.*s%s%s", (int)(at - text), text, to, at + strlen(from));
    return out;
}

static void damaged_texts_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *from, *to, *says;
    } cases[] = {
        {"weft-cost 2", "weft-cost 1", "another version"},
        {"weft-cost 2", "weft-cost 30", "another version"},
        {"weft-cost 2", "weft-cost", "does not begin"},
        {"weft-cost 2", "", "does not begin"},
        {"renderer ", "", "names no renderer"},
        {"\ncpu auto 0", "", "no instruction set"},
        {"\ncpu auto 0", "\ncpu avx3 1", "no instruction set"},
        {"\ncpu auto 0", "\ncpu avx2", "no instruction set"},
        {"\ncpu auto 0", "\ncpu avx2 1.5", "no instruction set"},
        {"\ncpu auto 0", "\ncpu avx2 5000", "no instruction set"},
        {"\ncpu auto 0", "\ncpu avx2 2 2", "no instruction set"},
        {"\nvoxel 0.85", "\nvoxels 0.85", "line 5"},
        {"\nvoxel 0.85", "", "lacks"},
        {"\nvoxel 0.85", "\nvoxel -0.85", "line 5"},
        {"\nvoxel 0.85", "\nvoxel nan", "line 5"},
        {"\nvoxel 0.85", "\nvoxel 1e30", "line 5"},
        {"\nvoxel 0.85", "\nvoxel 0.85 1", "line 5"},
        {"\nvoxel 0.85", "\nvoxel", "line 5"},
        {"\nvoxel 0.85", "\nvoxel 0,85", "line 5"},
        {"\nvoxel 0.85", "\n\nvoxel 0.85", "line 5"},
        {"\nstart 60000", "\nstart", "line 4"},
    };
    char *text = weft_cost_format(&weft_cost_default);
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct message message = {0};
        struct weft_cost_model model;
        char *damaged = replaced(text, cases[i].from, cases[i].to);
        const struct weft_log log = {keep_message, &message};
        assert_int_equal(weft_cost_parse(&log, damaged, &model), WEFT_ERR_FORMAT);
        assert_int_equal(message.count, 1);
        if (!strstr(message.text, cases[i].says))
            fail_msg("case %zu: %s", i, message.text);
        free(damaged);
    }
    // However it is cut, it is refused or whole.
    for (size_t length = 0; length + 2 < strlen(text); length++) {
        struct message message = {0};
        struct weft_cost_model model;
        const struct weft_log log = {keep_message, &message};
        char *cut = strndup(text, length);
        if (weft_cost_parse(&log, cut, &model) != WEFT_OK)
            assert_int_equal(message.count, 1);
        else
            assert_non_null(strstr(cut, "\ncpu_separable_tap "));
        free(cut);
    }
    free(text);
}

// ---- predictions --------------------------------------------------------------------------------

static double predict(weft_volume *volume, const struct weft_method *method, int side)
{
    struct weft_method_params params = {
        .method = *method,
        .statistics = {.low = 0.0, .high = 1.0, .voxels = 512},
        .slice = {.space = WEFT_SPACE_INDEX,
                  .kernel = kernel_named("linear"),
                  .geometry = {.origin = {1, 1, 3.3},
                               .u = {20, 0, 0},
                               .v = {0, 20, 0},
                               .width = side,
                               .height = side},
                  .log = &log_to_stderr},
    };
    weft_method_plan *plan = NULL;
    if (method->algorithm == WEFT_ALGORITHM_MULTIPASS)
        params.method.samples = 16;
    assert_int_equal(weft_method_plan_create(volume, &params, &plan), WEFT_OK);
    const double seconds = weft_cost_of(&weft_cost_default, &weft_method_plan_get_info(plan)->work);
    weft_method_plan_destroy(&plan);
    return seconds;
}

static void more_pixels_cost_more(void **state)
{
    (void)state;
    enum { SIDE = 24 };
    float *data = calloc(SIDE * SIDE * SIDE, sizeof *data);
    weft_volume *volume = NULL;
    struct weft_method *methods = NULL;
    size_t count = 0;
    assert_int_equal(weft_volume_create(weft_volume_params(.size = {SIDE, SIDE, SIDE}, .data = data,
                                                           .log = &log_to_stderr),
                                        &volume),
                     WEFT_OK);
    assert_int_equal(weft_method_list(&log_to_stderr, &methods, &count), WEFT_OK);
    assert_true(count > 1);
    for (size_t i = 0; i < count; i++) {
        double last = 0.0;
        for (int side = 32; side <= 512; side *= 2) {
            const double seconds = predict(volume, &methods[i], side);
            assert_true(isfinite(seconds) && seconds > last);
            last = seconds;
        }
    }
    free(methods);
    free(data);
    weft_volume_destroy(&volume);
}

// More of anything costs more, by every engine.
static void more_work_costs_more(void **state)
{
    (void)state;
    static const struct weft_work bases[] = {
        {.algorithm = WEFT_ALGORITHM_FUSED,
         .pixels = 1e5,
         .voxels = 1e5,
         .of.fused = {.layout = WEFT_LAYOUT_PLAIN, .texels = 1e5, .fetches = 64, .weights = 3}},
        {.algorithm = WEFT_ALGORITHM_SEPARABLE,
         .pixels = 1e5,
         .voxels = 1e5,
         .of.separable = {.summed = 1e5, .taps = 4e5}},
        {.algorithm = WEFT_ALGORITHM_MULTIPASS,
         .pixels = 1e5,
         .voxels = 1e5,
         .of.passes = {.plan = {.passes = 4, .fetches = 64, .tile_bytes = 1e6, .exact_weights = 12},
                       .samples = 1e5}},
        {.algorithm = WEFT_ALGORITHM_FUSED,
         .engine = WEFT_ENGINE_CPU,
         .pixels = 1e5,
         .voxels = 1e5,
         .of.fused_cpu = {.samples = 1e5, .rows = 16, .width = 4}},
        {.algorithm = WEFT_ALGORITHM_SEPARABLE,
         .engine = WEFT_ENGINE_CPU,
         .sums = WEFT_SUMS_DOUBLE,
         .pixels = 1e5,
         .voxels = 1e5,
         .of.separable = {.width = 4, .summed = 1e5, .taps = 4e5}},
    };
#define MEMBER(name) offsetof(struct weft_work, name)
    const size_t members[][7] = {
        {MEMBER(pixels), MEMBER(voxels), MEMBER(of.fused.texels), MEMBER(of.fused.fetches),
         MEMBER(of.fused.weights)},
        {MEMBER(pixels), MEMBER(voxels), MEMBER(of.separable.summed), MEMBER(of.separable.taps)},
        {MEMBER(pixels), MEMBER(voxels), MEMBER(of.passes.plan.passes),
         MEMBER(of.passes.plan.fetches), MEMBER(of.passes.plan.tile_bytes),
         MEMBER(of.passes.plan.exact_weights), MEMBER(of.passes.samples)},
        {MEMBER(pixels), MEMBER(voxels), MEMBER(of.fused_cpu.samples), MEMBER(of.fused_cpu.rows)},
        {MEMBER(voxels), MEMBER(of.separable.summed), MEMBER(of.separable.taps)},
    };
#undef MEMBER
    int compared = 0;
    for (size_t e = 0; e < WEFT_COUNT(bases); e++) {
        for (size_t i = 0; i < WEFT_COUNT(members[e]) && members[e][i]; i++) {
            struct weft_work more = bases[e];
            *(double *)(void *)((char *)&more + members[e][i]) *= 4.0;
            assert_true(weft_cost_of(&weft_cost_default, &more) >
                        weft_cost_of(&weft_cost_default, &bases[e]));
            compared++;
        }
    }
    assert_int_equal(compared, 5 + 4 + 7 + 4 + 3);
    // Half the threads that were measured take twice the time, but for the start and the reading.
    struct weft_cost_model model = weft_cost_default;
    struct weft_work work = bases[3];
    model.threads = 8;
    const double start = 1e-9 * (model.cpu_fused_start[0] + work.voxels * model.voxel);
    const double whole = weft_cost_of(&model, &work) - start;
    work.threads = 4;
    assert_near(weft_cost_of(&model, &work) - start, 2.0 * whole, 1e-12, "half the threads");
    // Rows are as long as was measured, between, or longer; a row is none.
    double last = 0.0;
    for (int width = 2; width <= 16; width++) {
        work.of.fused_cpu.width = width;
        const double seconds = weft_cost_of(&model, &work);
        const double ns = (1e9 * seconds - model.cpu_fused_start[0] - 1e5 * model.voxel) / 2.0;
        if (width <= 8 && width % 2 == 0)
            assert_near(ns,
                        1e5 * (model.cpu_sample[0] + model.cpu_pixel[0] +
                               16 * model.cpu_row[0][width / 2 - 1]),
                        1e-6 * ns, "a width that is measured");
        assert_true(width < 9 || seconds > last);
        last = seconds;
    }
    // Nothing at all still has a start, and no tiles are no trouble.
    const struct weft_work nothing = {.algorithm = WEFT_ALGORITHM_MULTIPASS};
    assert_near(weft_cost_of(&weft_cost_default, &nothing), 1e-9 * weft_cost_default.start[2],
                1e-15, "nothing");
}

// ---- calibration --------------------------------------------------------------------------------

struct stop {
    int calls, last;
    double fraction;
};

static bool stop_after(void *priv, double fraction)
{
    struct stop *stop = priv;
    assert_true(fraction >= stop->fraction && fraction <= 1.0);
    stop->fraction = fraction;
    return ++stop->calls < stop->last;
}

static void calibration_can_be_cancelled(void **state)
{
    (void)state;
    static const int lasts[] = {1, 2, 7};
    for (size_t i = 0; i < WEFT_COUNT(lasts); i++) {
        struct weft_cost_model model;
        struct stop stop = {.last = lasts[i]};
        const struct weft_progress progress = {stop_after, &stop};
        assert_int_equal(weft_cost_calibrate(&log_to_stderr, contexts[0], &progress, &model),
                         WEFT_ERR_CANCELLED);
        assert_int_equal(stop.calls, lasts[i]);
        assert_true(model.voxel == 0.0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(texts_come_back),
        cmocka_unit_test(damaged_texts_are_refused),
        cmocka_unit_test(more_pixels_cost_more),
        cmocka_unit_test(more_work_costs_more),
        cmocka_unit_test(calibration_can_be_cancelled),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
