// SPDX-License-Identifier: BSD-3-Clause
// Compiled slices: run often, with strides, within a context's limits.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "tests/support/contexts.h"
#include "filter/check.h"
#include "passes/gl/context_backend.h"
#include "tiles/volume/volume_impl.h"
#include "weft.h"

enum { N = 40 };

static weft_volume *make_volume(void)
{
    float *data = malloc((size_t)N * N * N * sizeof *data);
    assert_non_null(data);
    for (int i = 0; i < N * N * N; i++)
        data[i] = (float)sin(0.37 * (i % N) + 0.21 * (i / N % N) - 0.5 * (i / N / N)) +
                  (float)(i * 7919 % 101) / 101.0f;
    weft_volume *volume = NULL;
    assert_int_equal(
        weft_volume_create(weft_volume_params(.size = {N, N, N}, .background = 0.0f, .data = data),
                           &volume),
        WEFT_OK);
    free(data);
    return volume;
}

static const struct weft_slice_geometry oblique = {{4, 3, 5}, {28, 9, 6}, {-5, 25, 10}, 150, 130};
static const struct weft_slice_geometry across = {{2, 2, 17.3}, {34, 0, 0}, {0, 34, 0}, 150, 130};

// The methods by which a slice is run.
static const struct engine {
    const char *name;
    const struct weft_slice_geometry *geometry;
    const char *profile; // NULL: none
    bool on_cpu;
} engines[] = {
    {"fused", &oblique, NULL, false},
    {"one axis after the other", &across, NULL, false},
    {"passes on GL", &oblique, "unorm16", false},
    {"passes on the CPU", &oblique, "unorm16", true},
};

static weft_pass_plan *make_passes(const char *profile)
{
    weft_pass_plan *passes = NULL;
    struct weft_pass_plan_params *params =
        weft_pass_plan_params(.kernel = kernel_named("linear"), .dims = 3, .samples = 8);
    assert_int_equal(weft_profile_parse(&log_to_stderr, profile, &params->profile), WEFT_OK);
    assert_int_equal(weft_pass_plan_create(params, &passes), WEFT_OK);
    return passes;
}

static void check_engine(weft_volume *volume, const struct engine *e)
{
    enum { GAP = 7 };
    const float untouched = 4711.0f;
    const size_t width = (size_t)e->geometry->width, height = (size_t)e->geometry->height;
    const size_t stride = width + GAP;
    weft_context *context = e->on_cpu ? NULL : contexts[0];
    weft_pass_plan *pass_plan = e->profile ? make_passes(e->profile) : NULL;
    const struct weft_slice_passes passes = {.plan = pass_plan, .log = &log_to_stderr};
    const struct weft_slice_params params = {.kernel = kernel_named("linear"),
                                             .space = WEFT_SPACE_INDEX,
                                             .geometry = *e->geometry,
                                             .log = &log_to_stderr};
    float *once = malloc(width * height * sizeof *once);
    float *often = malloc(stride * height * sizeof *often);
    weft_slice_plan *plan = NULL;
    weft_slice *slice = NULL;
    struct weft_slice_report report;
    assert_non_null(once);
    assert_non_null(often);
    assert_int_equal(weft_slice_plan_create(volume, &params, &plan), WEFT_OK);
    assert_int_equal(weft_slice_plan_get_info(plan)->savings & WEFT_SAVING_SEPARABLE,
                     e->geometry == &across ? WEFT_SAVING_SEPARABLE : 0);
    assert_int_equal(
        weft_slice_compile(
            plan,
            weft_slice_compile_params(.context = context, .passes = pass_plan ? &passes : NULL),
            &slice),
        WEFT_OK);
    for (int run = 0; run < 3; run++) {
        for (size_t i = 0; i < stride * height; i++)
            often[i] = untouched;
        assert_int_equal(
            weft_slice_run(slice, weft_slice_run_params(.pixels = often, .stride = (int64_t)stride),
                           &report),
            WEFT_OK);
        if (run == 0)
            assert_true(report.bricks_read > 10);
        else
            assert_int_equal(report.bricks_read, 0); // they are kept
        assert_int_equal(
            weft_slice_run_once(
                plan,
                weft_slice_compile_params(.context = context, .passes = pass_plan ? &passes : NULL),
                weft_slice_run_params(.pixels = once), NULL),
            WEFT_OK);
        for (size_t y = 0; y < height; y++) {
            if (memcmp(often + y * stride, once + y * width, width * sizeof *once) != 0)
                fail_msg("%s: row %zu of run %d differs", e->name, y, run);
            for (size_t x = width; x < stride; x++)
                assert_true(often[y * stride + x] == untouched);
        }
        assert_true(report.maximum > report.minimum && report.maximum < 3.0f);
        assert_int_equal(report.not_finite, 0);
    }
    weft_slice_destroy(&slice);
    weft_slice_plan_destroy(&plan);
    weft_pass_plan_destroy(&pass_plan);
    free(once);
    free(often);
}

static void compiled_slices_run_often(void **state)
{
    (void)state;
    weft_volume *volume = make_volume();
    for (size_t i = 0; i < WEFT_COUNT(engines); i++)
        check_engine(volume, &engines[i]);
    weft_volume_destroy(&volume);
}

// Plans for a small GL are cut so that it can run them, to the same pixels; a plan for a larger one
// is refused before anything is read.
static void plans_are_cut_to_the_contexts_limits(void **state)
{
    (void)state;
    weft_volume *volume = make_volume();
    const struct {
        int side;
        int64_t texels;
    } limits[] = {{64, 1 << 26}, {4096, 12000}, {100, 40000}};
    struct weft_slice_params params = {.kernel = kernel_named("catmull-rom"),
                                       .space = WEFT_SPACE_INDEX,
                                       .geometry = oblique,
                                       .layout = WEFT_LAYOUT_INTERLEAVED};
    static float whole[150 * 130], cut[150 * 130];
    weft_slice_plan *plan = NULL, *small = NULL;
    weft_slice *slice = NULL;
    assert_int_equal(weft_slice_plan_create(volume, &params, &plan), WEFT_OK);
    assert_int_equal(weft_slice_plan_get_info(plan)->tile_count, 1);
    assert_int_equal(weft_slice_run_once(plan, weft_slice_compile_params(.context = contexts[0]),
                                         weft_slice_run_params(.pixels = whole), NULL),
                     WEFT_OK);
    struct weft_context_info *info = &contexts[0]->info;
    const struct weft_context_info own = *info;
    for (size_t i = 0; i < WEFT_COUNT(limits); i++) {
        struct weft_slice_report report;
        info->max_target_size = params.max_target_size = limits[i].side;
        info->max_buffer_texels = params.max_buffer_texels = limits[i].texels;
        assert_int_equal(weft_slice_plan_create(volume, &params, &small), WEFT_OK);
        const struct weft_slice_plan_info *p = weft_slice_plan_get_info(small);
        assert_true(p->tile_count > 1);
        for (int t = 0; t < p->tile_count; t++)
            assert_true(p->tiles[t].width <= limits[i].side &&
                        p->tiles[t].height <= limits[i].side);
        memset(cut, 0, sizeof cut);
        assert_int_equal(weft_slice_run_once(small,
                                             weft_slice_compile_params(.context = contexts[0]),
                                             weft_slice_run_params(.pixels = cut), &report),
                         WEFT_OK);
        assert_memory_equal(cut, whole, sizeof cut);
        assert_int_equal(
            weft_slice_compile(plan, weft_slice_compile_params(.context = contexts[0]), &slice),
            WEFT_ERR_LIMIT);
        assert_null(slice);
        weft_slice_plan_destroy(&small);
    }
    *info = own;
    weft_slice_plan_destroy(&plan);
    weft_volume_destroy(&volume);
}

// Several tiles: what filters them is made once where there is room, so that a second run uploads
// less, and each time where there is none. Pixels are those of one tile.
static void separable_tiles_are_kept_where_there_is_room(void **state)
{
    static float whole[150 * 130], cut[2][150 * 130];
    int kept = 0, made = 0;
    (void)state;
    weft_volume *volume = make_volume();
    for (int size = 0; size < 2; size++) {
        struct weft_slice_params params = {.kernel = kernel_named("linear"),
                                           .space = WEFT_SPACE_INDEX,
                                           .geometry = across,
                                           .log = &log_to_stderr};
        params.geometry.width = size ? 150 : 40;
        params.geometry.height = size ? 130 : 36;
        const size_t count = (size_t)params.geometry.width * (size_t)params.geometry.height;
        for (uint64_t bytes = 400 << 10; bytes >= 70 << 10; bytes -= 5 << 10) {
            weft_slice_plan *plan = NULL;
            weft_slice *slice = NULL;
            struct weft_slice_report report[2];
            params.memory_bytes = bytes;
            assert_int_equal(weft_slice_plan_create(volume, &params, &plan), WEFT_OK);
            assert_int_equal(
                weft_slice_compile(plan, weft_slice_compile_params(.context = contexts[0]), &slice),
                WEFT_OK);
            for (int run = 0; run < 2; run++)
                assert_int_equal(
                    weft_slice_run(slice, weft_slice_run_params(.pixels = cut[run]), &report[run]),
                    WEFT_OK);
            const bool several = weft_slice_plan_get_info(plan)->tile_count > 1;
            const bool less = report[1].uploaded_bytes < report[0].uploaded_bytes;
            kept += several && less;
            made += several && !less;
            if (bytes == 400 << 10)
                memcpy(whole, cut[0], count * sizeof *whole);
            assert_memory_equal(cut[0], whole, count * sizeof *whole);
            assert_memory_equal(cut[1], whole, count * sizeof *whole);
            weft_slice_destroy(&slice);
            weft_slice_plan_destroy(&plan);
        }
    }
    assert_true(kept > 0 && made > 0);
    weft_volume_destroy(&volume);
}

// ---- reading ------------------------------------------------------------------------------------

enum { BRICKS = N / WEFT_BRICK_SIZE };

// A volume that counts how often each of its bricks is read.
struct counted {
    weft_volume *base;
    int reads[BRICKS * BRICKS * BRICKS];
};

static enum weft_result find_counted(weft_volume *volume, const struct weft_region *region,
                                     struct weft_brick_list *out)
{
    const struct counted *c = volume->data;
    return weft_volume_find(c->base, region, out);
}

static enum weft_result read_counted(weft_volume *volume, size_t count, const int32_t (*origin)[3],
                                     float *values)
{
    struct counted *c = volume->data;
    for (size_t i = 0; i < count; i++)
        c->reads[(origin[i][2] / 8 * BRICKS + origin[i][1] / 8) * BRICKS + origin[i][0] / 8]++;
    return weft_volume_read(c->base, count, origin, values);
}

static void clear_counted(void *data)
{
    weft_volume_destroy(&((struct counted *)data)->base);
}

static weft_volume *make_counted(void)
{
    static const struct weft_volume_backend backend = {sizeof(struct counted), find_counted,
                                                       read_counted, clear_counted};
    weft_volume *volume = NULL;
    assert_int_equal(weft_volume_make(&log_to_stderr, &backend, &volume), WEFT_OK);
    struct counted *c = volume->data;
    c->base = make_volume();
    volume->info = *weft_volume_get_info(c->base);
    volume->info.metadata = NULL;
    volume->info.metadata_count = 0;
    return volume;
}

// Statistics, two runs and verification; returns how many bricks were read in all.
static uint64_t read_all(const char *kernel, uint64_t memory_bytes, float *pixels, int *most)
{
    weft_volume *volume = make_counted();
    const struct counted *c = volume->data;
    const struct weft_slice_params params = {.kernel = kernel_named(kernel),
                                             .space = WEFT_SPACE_INDEX,
                                             .geometry = oblique,
                                             .layout = WEFT_LAYOUT_PLAIN,
                                             .memory_bytes = memory_bytes,
                                             .log = &log_to_stderr};
    const struct weft_slice_verify_params few = {.max_seconds = 1e-3};
    struct weft_slice_statistics statistics;
    struct weft_verify_report error;
    weft_slice_plan *plan = NULL;
    uint64_t sum = 0;
    assert_int_equal(weft_slice_plan_create(volume, &params, &plan), WEFT_OK);
    weft_footprint *footprint = weft_slice_plan_get_footprint(plan);
    assert_int_equal(weft_footprint_statistics(footprint, NULL, &statistics), WEFT_OK);
    for (int run = 0; run < 2; run++)
        assert_int_equal(weft_slice_run_once(plan,
                                             weft_slice_compile_params(.context = contexts[0]),
                                             weft_slice_run_params(.pixels = pixels), NULL),
                         WEFT_OK);
    assert_int_equal(weft_slice_verify(plan, pixels, &few, &error), WEFT_OK);
    assert_true(error.maximum <= error.bound);
    *most = 0;
    for (int i = 0; i < BRICKS * BRICKS * BRICKS; i++) {
        sum += (uint64_t)c->reads[i];
        *most = c->reads[i] > *most ? c->reads[i] : *most;
    }
    assert_int_equal(weft_footprint_get_info(footprint)->bricks_read, sum);
    assert_true(memory_bytes == 0 ||
                weft_footprint_get_info(footprint)->kept_bytes <= memory_bytes);
    weft_slice_plan_destroy(&plan);
    weft_volume_destroy(&volume);
    return sum;
}

static void bricks_are_read_once_in_all(void **state)
{
    static const char *const kernels[] = {"catmull-rom", "bspline3i", "bspline5i"};
    static float room[150 * 130], none[150 * 130];
    (void)state;
    for (size_t k = 0; k < WEFT_COUNT(kernels); k++) {
        int once, often;
        const uint64_t least = read_all(kernels[k], 0, room, &once);
        const uint64_t more = read_all(kernels[k], 256 << 10, none, &often);
        assert_in_range(least, 40, BRICKS * BRICKS * BRICKS);
        assert_int_equal(once, 1);
        assert_true(often > 1 && more > least);
        assert_memory_equal(room, none, sizeof room);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(compiled_slices_run_often),
        cmocka_unit_test(plans_are_cut_to_the_contexts_limits),
        cmocka_unit_test(separable_tiles_are_kept_where_there_is_room),
        cmocka_unit_test(bricks_are_read_once_in_all),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
