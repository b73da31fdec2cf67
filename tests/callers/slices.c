// SPDX-License-Identifier: BSD-3-Clause
#include "tests/callers/callers.h"

static enum weft_result make_slice(weft_volume *v, const struct weft_slice_params *p)
{
    weft_slice_plan *made = NULL;
    const enum weft_result res = weft_slice_plan_create(v, p, &made);
    weft_slice_plan_destroy(&made);
    return res;
}

static struct weft_slice_params slice_params(weft_volume *v)
{
    struct weft_slice_params p = {.space = WEFT_SPACE_INDEX, .log = &logger};
    if (weft_slice_axis_geometry(&logger, v, p.space, 2, 1.5, 4, 4, &p.geometry) != WEFT_OK)
        exit(1);
    return p;
}

static void slice_geometry(void)
{
    weft_volume *v = volume();
    struct weft_slice_geometry good = slice_params(v).geometry;
    struct weft_slice_geometry out;
    for (size_t i = 0; i < WEFT_COUNT(bad_enums); i++) {
        const enum weft_space bad = (enum weft_space)bad_enums[i];
        struct weft_slice_geometry copy = good;
        REFUSED(weft_slice_size_compute(&logger, v, bad, &copy));
        REFUSED(weft_slice_axis_geometry(&logger, v, bad, 0, 0.0, 4, 4, &out));
        REFUSED(
            weft_slice_axis_geometry(&logger, v, WEFT_SPACE_INDEX, bad_enums[i], 0.0, 4, 4, &out));
    }
#define CALL weft_slice_size_compute(&logger, v, WEFT_SPACE_WORLD, &p)
    ANY_INT(good, width, CALL);
    ANY_INT(good, height, CALL);
    ANY_NUMBER(good, u[0], CALL);
    ANY_NUMBER(good, v[1], CALL);
    SET_REFUSED(good, u[0], NAN, CALL);
#undef CALL
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++)
        SURVIVED(weft_slice_axis_geometry(&logger, v, WEFT_SPACE_WORLD, 1, numbers[n], 4, 0, &out));
    for (size_t i = 0; i < WEFT_COUNT(ints); i++)
        SURVIVED(
            weft_slice_axis_geometry(&logger, v, WEFT_SPACE_WORLD, 1, 0.0, ints[i], ints[i], &out));
    weft_volume_destroy(&v);
}

static void slice_frames(void)
{
    weft_volume *v = volume();
    const struct weft_slice_geometry good = slice_params(v).geometry;
    struct weft_slice_geometry out;
    double low[3], high[3];
    weft_slice_active_box(weft_volume_get_info(v), WEFT_SPACE_INDEX, low, high);
    for (size_t i = 0; i < WEFT_COUNT(bad_enums); i++) {
        out = good;
        REFUSED(weft_slice_turn(&logger, v, (enum weft_space)bad_enums[i], (double[]){0, 1, 0},
                                true, &out));
        REFUSED(weft_slice_box_geometry(&logger, v, (enum weft_space)bad_enums[i], low, high, 2,
                                        1.5, 4, 4, &out));
        REFUSED(weft_slice_box_geometry(&logger, v, WEFT_SPACE_INDEX, low, high, bad_enums[i], 1.5,
                                        4, 4, &out));
    }
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        const double up[3] = {numbers[n], numbers[n], 0.0}, box[3] = {0.0, numbers[n], 0.0};
        out = good;
        SURVIVED(weft_slice_turn(&logger, v, WEFT_SPACE_INDEX, up, true, &out));
        SURVIVED(weft_slice_box_geometry(&logger, v, WEFT_SPACE_WORLD, box, high, 2, numbers[n], 4,
                                         0, &out));
    }
    out = good;
    REFUSED(weft_slice_turn(&logger, v, WEFT_SPACE_INDEX, (double[]){0, 0, 0}, false, &out));
    REFUSED(weft_slice_turn(&logger, v, WEFT_SPACE_INDEX, (double[]){0, 0, -2}, true, &out));
    weft_slice_mirror(true, true, &out);
    weft_volume_destroy(&v);
}

static void slices(void)
{
    weft_volume *v = volume();
    struct weft_slice_params good = slice_params(v);
#define CALL make_slice(v, &p)
    KERNELS_REFUSED(good, 1, CALL);
    BAD_ENUM(good, space, CALL);
    BAD_ENUM(good, layout, CALL);
    BAD_ENUM(good, source, CALL);
    BAD_ENUM(good, lookup, CALL);
    SET_REFUSED(good, without, 1u << 31, CALL);
    SET_REFUSED(good, geometry.width, -1, CALL);
    SET_REFUSED(good, geometry.width, INT_MAX, CALL);
    SET_REFUSED(good, geometry.height, INT_MIN, CALL);
    for (int a = 0; a < 3; a++) {
        ANY_NUMBER(good, geometry.origin[a], CALL);
        ANY_NUMBER(good, geometry.u[a], CALL);
        ANY_NUMBER(good, geometry.v[a], CALL);
    }
    ANY_NUMBER(good, smooth_error, CALL);
    ANY_INT(good, memory_bytes, CALL);
    ANY_INT(good, max_target_size, CALL);
    ANY_INT(good, max_buffer_texels, CALL);
    struct weft_slice_params sampled = good;
    sampled.lookup = WEFT_LOOKUP_LINEAR;
    sampled.source = WEFT_SOURCE_UNORM8;
    sampled.high = 1.0;
    ANY_INT(sampled, samples, CALL);
    ANY_NUMBER(sampled, low, CALL);
    ANY_NUMBER(sampled, high, CALL);
#undef CALL
    weft_slice_plan_destroy(NULL);
    weft_volume_destroy(&v);
}

static enum weft_result make_footprint(const struct weft_footprint_params *p)
{
    weft_footprint *made = NULL;
    const enum weft_result res = weft_footprint_create(p, &made);
    weft_footprint_destroy(&made);
    return res;
}

static void footprints(void)
{
    weft_volume *v = volume();
    const struct weft_slice_params slice = slice_params(v);
    struct weft_footprint_params good = {
        .volume = v, .space = slice.space, .geometry = slice.geometry, .log = &logger};
#define CALL make_footprint(&p)
    KERNELS_REFUSED(good, 1, CALL);
    BAD_ENUM(good, space, CALL);
    SET_REFUSED(good, volume, NULL, CALL);
    SET_REFUSED(good, geometry.width, 0, CALL);
    SET_REFUSED(good, geometry.height, INT_MAX, CALL);
    for (int a = 0; a < 3; a++) {
        ANY_NUMBER(good, geometry.origin[a], CALL);
        ANY_NUMBER(good, geometry.u[a], CALL);
        ANY_NUMBER(good, geometry.v[a], CALL);
    }
    ANY_INT(good, memory_bytes, CALL);
#undef CALL
    weft_footprint *f = NULL;
    struct weft_slice_statistics statistics;
    TRUE(weft_footprint_create(&good, &f) == WEFT_OK);
    TRUE(weft_footprint_statistics(f, NULL, &statistics) == WEFT_OK);
    TRUE(weft_footprint_get_info(f)->bricks_read > 0);
    struct weft_slice_statistics of_part;
    REFUSED(weft_footprint_part_statistics(f, &(struct weft_rectangle){0, 0, INT_MAX, 1}, NULL,
                                           &of_part));
    REFUSED(
        weft_footprint_part_statistics(f, &(struct weft_rectangle){-1, 0, 1, 1}, NULL, &of_part));
    TRUE(weft_footprint_part_statistics(f, &(struct weft_rectangle){0, 0, 1, 1}, NULL, &of_part) ==
             WEFT_OK &&
         of_part.voxels > 0);
    of_part = weft_slice_statistics_join(&of_part, &statistics);
    TRUE(of_part.low == statistics.low && of_part.voxels > statistics.voxels);
    of_part.high = 4711.0;
    weft_footprint_set_statistics(f, &of_part);
    TRUE(weft_footprint_statistics(f, NULL, &statistics) == WEFT_OK && statistics.high == 4711.0);
    // A plan on it is of its slice.
    struct weft_slice_params shared = slice;
    shared.footprint = f;
#define CALL make_slice(v, &p)
    ANY_INT(shared, memory_bytes, CALL);
    SET_REFUSED(shared, geometry.width, slice.geometry.width + 1, CALL);
    SET_REFUSED(shared, space, WEFT_SPACE_WORLD, CALL);
#undef CALL
    weft_footprint_destroy(&f);
    weft_footprint_destroy(&f);
    weft_footprint_destroy(NULL);
    weft_volume_destroy(&v);
}

static enum weft_result make_resident(const struct weft_resident_params *p)
{
    weft_resident *made = NULL;
    const enum weft_result res = weft_resident_create(p, &made);
    weft_resident_destroy(&made);
    return res;
}

static void residents(void)
{
    weft_volume *v = volume(), *other = volume();
    struct weft_resident_params good = {.volume = v, .log = &logger};
#define CALL make_resident(&p)
    KERNELS_REFUSED(good, 1, CALL);
    BAD_ENUM(good, layout, CALL);
    BAD_ENUM(good, source, CALL);
    SET_REFUSED(good, volume, NULL, CALL);
    SET_REFUSED(good, layout, WEFT_LAYOUT_ALIGNED, CALL); // in memory
    SET_REFUSED(good, memory_bytes, 1, CALL);
    ANY_INT(good, memory_bytes, CALL);
    ANY_INT(good, brick_bytes, CALL);
    struct weft_resident_params mapped = good;
    mapped.source = WEFT_SOURCE_UNORM8;
    mapped.high = 1.0;
    ANY_NUMBER(mapped, low, CALL);
    ANY_NUMBER(mapped, high, CALL);
#undef CALL
    weft_resident *r = NULL;
    TRUE(weft_resident_create(&good, &r) == WEFT_OK);
    TRUE(weft_resident_get_info(r)->capacity > 0);
    // Slices are of its volume, its layout, and the engine that it was made for.
    struct weft_slice_params slice = slice_params(v);
    slice.engine = WEFT_ENGINE_CPU;
    slice.resident = r;
#define CALL make_slice(v, &p)
    SET_REFUSED(slice, engine, WEFT_ENGINE_GL, CALL);
    SET_REFUSED(slice, layout, WEFT_LAYOUT_INTERLEAVED, CALL);
    SET_REFUSED(slice, source, WEFT_SOURCE_HALF, CALL);
#undef CALL
    REFUSED(make_slice(other, &slice));
    weft_resident_destroy(&r);
    weft_resident_destroy(&r);
    weft_resident_destroy(NULL);
    weft_volume_destroy(&other);
    weft_volume_destroy(&v);
}

static enum weft_result make_method(weft_volume *v, const struct weft_method_params *p)
{
    weft_method_plan *made = NULL;
    const enum weft_result res = weft_method_plan_create(v, p, &made);
    weft_method_plan_destroy(&made);
    return res;
}

static void methods(void)
{
    weft_volume *v = volume();
    struct weft_method_params good = {.method = {.layout = WEFT_LAYOUT_PLAIN},
                                      .slice = slice_params(v),
                                      .statistics = {.low = 0.0, .high = 3.0, .voxels = 64}};
    char text[96];
    good.slice.memory_bytes = 1 << 22; // or sets of 99^3 samples would be made
#define CALL make_method(v, &p)
    BAD_ENUM(good, method.algorithm, CALL);
    BAD_ENUM(good, method.layout, CALL);
    BAD_ENUM(good, method.source, CALL);
    BAD_ENUM(good, method.lookup, CALL);
    BAD_ENUM(good, method.technique, CALL);
    ANY_NUMBER(good, statistics.low, CALL);
    ANY_NUMBER(good, statistics.difference[0], CALL);
    good.method.algorithm = WEFT_ALGORITHM_MULTIPASS;
    good.method.profile = *weft_profile_find("unorm8");
    good.method.samples = 8;
    ANY_INT(good, method.samples, CALL);
    ANY_INT(good, method.bits, CALL);
    BAD_ENUM(good, method.profile.target, CALL);
#undef CALL
    for (size_t i = 0; i < WEFT_COUNT(bad_enums); i++) {
        const int bad = bad_enums[i];
        const struct weft_method method = {.algorithm = (enum weft_algorithm)bad,
                                           .sums = (enum weft_sums)bad,
                                           .layout = (enum weft_layout)bad,
                                           .source = (enum weft_source_format)bad,
                                           .lookup = (enum weft_lookup)bad,
                                           .technique = (enum weft_technique)bad};
        weft_method_format(&method, text, sizeof text);
        struct weft_method fused = method;
        fused.algorithm = WEFT_ALGORITHM_FUSED;
        weft_method_format(&fused, text, sizeof text);
        struct weft_method cpu = method;
        cpu.engine = WEFT_ENGINE_CPU;
        weft_method_format(&cpu, text, sizeof text);
    }
    struct weft_method *list = NULL;
    size_t count;
    SURVIVED(weft_method_list(&logger, &list, &count));
    free(list);
    weft_method_plan_destroy(NULL);
    weft_volume_destroy(&v);
}

static void choices(void)
{
    weft_volume *v = volume();
    struct weft_choice choice = {0};
    struct weft_choose_params good = {.slice = slice_params(v), .max_error = 0.1};
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        if (numbers[n] >= 0.0 && numbers[n] < 1.0)
            continue;
        struct weft_choose_params p = good;
        p.max_error = numbers[n];
        if (!(numbers[n] >= 0.0))
            REFUSED(weft_choose(v, &p, &choice));
    }
    struct weft_choose_params p = good;
    p.slice.layout = (enum weft_layout)99;
    REFUSED(weft_choose(v, &p, &choice));
    p = good;
    p.engines = 99;
    REFUSED(weft_choose(v, &p, &choice));
    p = good;
    p.threads = -1;
    REFUSED(weft_choose(v, &p, &choice));
    weft_choice_clear(&choice);
    weft_choice_clear(NULL);
    weft_volume_destroy(&v);
}

static void costs(void)
{
    struct weft_cost_model model = weft_cost_default;
    free(weft_cost_format(&model));
    for (size_t i = 0; i < WEFT_COUNT(bad_enums); i++) {
        const int bad = bad_enums[i];
        const struct weft_work bad_works[] = {
            {.algorithm = (enum weft_algorithm)bad},
            {.algorithm = WEFT_ALGORITHM_FUSED, .of.fused.layout = (enum weft_layout)bad},
            {.algorithm = WEFT_ALGORITHM_FUSED, .of.fused.source = (enum weft_source_format)bad},
            {.algorithm = WEFT_ALGORITHM_MULTIPASS,
             .of.passes.plan.target = (enum weft_target_format)bad},
            {.engine = (enum weft_engine)bad},
            {.engine = WEFT_ENGINE_CPU, .sums = (enum weft_sums)bad},
            {.engine = WEFT_ENGINE_CPU, .algorithm = WEFT_ALGORITHM_MULTIPASS},
            {.engine = WEFT_ENGINE_CPU, .threads = -1},
        };
        for (size_t k = 0; k < WEFT_COUNT(bad_works); k++)
            TRUE(isnan(weft_cost_of(&model, &bad_works[k])));
        const struct weft_pass_plan_params params = {.technique = (enum weft_technique)bad,
                                                     .log = &logger};
        TRUE(weft_pass_work_least(&params).passes == 0.0);
        TRUE(isnan(weft_pass_bound_least(&params, 1.0).e2));
    }
    TRUE(isfinite(weft_cost_of(&model, &(struct weft_work){.algorithm = WEFT_ALGORITHM_FUSED})));
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        weft_separable_work_of(ints[n % WEFT_COUNT(ints)], numbers[n], 1.0, 2.0, numbers[n]);
        weft_pass_bound_least(&(struct weft_pass_plan_params){.samples = 8}, numbers[n]);
    }
    memset(model.renderer, 'x', sizeof model.renderer); // without an end
    model.instructions = (enum weft_instruction_set)99;
    free(weft_cost_format(&model));
}

static void window_maps(void)
{
    const struct weft_window window = {0, 4};
    struct weft_window data, display;
    struct weft_window_map out;
    static const int64_t far[] = {INT64_MIN, INT64_MAX, INT64_C(1) << 40, -(INT64_C(1) << 31)};
#define SCALE(d, w, to) weft_window_map_scale(&logger, d, w, to, &data, &display, &out)
    REFUSED(SCALE(window, window, 0));
    REFUSED(SCALE(window, window, -3));
    REFUSED(SCALE(((struct weft_window){4, 4}), window, 8));
    REFUSED(SCALE(window, ((struct weft_window){5, 4}), 8));
    SURVIVED(
        SCALE(((struct weft_window){-1000000, 1000000}), ((struct weft_window){0, 1}), 1 << 29));
    TRUE(SCALE(window, window, 8) == WEFT_OK && data.end == 8 && out.to == 8);
    const struct weft_window_map good = weft_window_map_plain(4, 8);
    TRUE(weft_window_map_position(&good, 0, 0) == -0.25);
    TRUE(weft_window_map_square(&good, 7) == 3);
    for (size_t i = 0; i < WEFT_COUNT(far); i++) {
        struct weft_window_map maps[4] = {good, good, good, good};
        maps[0].from = maps[1].to = maps[2].pixel = maps[3].sample = far[i];
        for (int m = 0; m < 4; m++) {
            TRUE(isnan(weft_window_map_position(&maps[m], 1, 1)));
            TRUE(weft_window_map_square(&maps[m], 1) == INT64_MIN);
        }
        REFUSED(SCALE(((struct weft_window){far[i], 4}), window, 8));
        REFUSED(SCALE(window, ((struct weft_window){0, far[i]}), 8));
        REFUSED(SCALE(window, window, far[i]));
    }
    TRUE(isnan(weft_window_map_position(&good, INT_MAX, 0)));
    TRUE(isnan(weft_window_map_position(&good, 0, INT_MIN)));
    double at[2];
    weft_window_map_positions(&good, INT_MAX - 1, 2, INT_MIN, at);
    TRUE(isnan(at[0]) && isnan(at[1]));
#undef SCALE
}

static void pixel_errors(void)
{
    float out[16] = {0};
    const struct weft_pixel_grid grid = {
        .width = 4, .height = 4, .du = {1.0, 0.0, 0.0}, .dv = {0.0, 1.0, 0.0}};
    struct weft_pixel_grid g = grid;
    struct weft_verify_report error;
    struct weft_pixels_verify_params good = {.kernel = {named("bspline")},
                                             .grid = &g,
                                             .size = {8, 8},
                                             .samples = {{.values = voxels}},
                                             .pixels = {{.values = out}},
                                             .log = &logger};
#define CALL weft_pixels_verify(&p, &error)
    TRUE(weft_pixels_verify(&good, &error) == WEFT_OK && error.pixels_checked == 16);
    SET_REFUSED(good, dims, -1, CALL);
    SET_REFUSED(good, dims, 4, CALL);
    SET_REFUSED(good, size[0], 0, CALL);
    SET_REFUSED(good, size[1], INT_MIN, CALL);
    SET_REFUSED(good, channels, 5, CALL);
    SET_REFUSED(good, channels, 2, CALL); // without planes
    SET_REFUSED(good, samples[0].values, NULL, CALL);
    SET_REFUSED(good, samples[0].stride, 7, CALL);
    SET_REFUSED(good, pixels[0].values, NULL, CALL);
    SET_REFUSED(good, pixels[0].stride, -1, CALL);
    SET_REFUSED(good, part.width, 4711, CALL);
    SET_REFUSED(good, window.y, -1, CALL);
    SET_REFUSED(good, kernel[0].info, NULL, CALL);
    SET_REFUSED(good, cardinal, true, CALL); // of a kernel without a prefilter
    BAD_ENUM(good, pixels[0].type, CALL);
    BAD_ENUM(good, samples[0].type, CALL);
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        struct weft_pixels_verify_params p = good;
        p.how.max_seconds = numbers[n];
        SURVIVED(CALL);
        g.origin[1] = numbers[n];
        SURVIVED(CALL);
        g = grid;
        p.bound_relative = numbers[n];
        SURVIVED(CALL);
        const struct weft_reference_value reference = {numbers[n], numbers[n]};
        weft_verify_add(&error, 0, 0, 0, numbers[(n + 1) % WEFT_COUNT(numbers)], &reference);
        weft_verify_join(&error, &error);
    }
#undef CALL
}

static void slice_runs_refuse(weft_context *context, const weft_slice_plan *plan)
{
    float out[64];
    weft_slice *compiled = NULL;
    REFUSED(weft_slice_compile(
        NULL,
        weft_slice_compile_params(.context = context, .passes = weft_slice_passes(.log = &logger)),
        &compiled));
    REFUSED(weft_slice_compile(plan, weft_slice_compile_params(),
                               &compiled)); // the CPU runs passes alone
    if (weft_slice_compile(plan, weft_slice_compile_params(.context = context), &compiled) !=
        WEFT_OK)
        return;
    struct weft_slice_run_params good = {.pixels = out, .stride = 16};
#define CALL weft_slice_run(compiled, &p, NULL)
    SURVIVED(weft_slice_run(compiled, &good, NULL));
    SET_REFUSED(good, pixels, NULL, CALL);
    SET_REFUSED(good, stride, -1, CALL);
    SET_REFUSED(good, stride, 3, CALL);
    SET_REFUSED(good, stride, INT64_MAX, CALL);
#undef CALL
    weft_slice_destroy(&compiled);
    weft_slice_destroy(&compiled);
    weft_slice_destroy(NULL);
}

static void slice_runs(void)
{
    weft_context *context = open_context();
    weft_volume *v = volume();
    weft_slice_plan *slice = NULL;
    struct weft_slice_params params = slice_params(v);
    float out[16];
    struct weft_slice_statistics statistics;
    struct weft_verify_report error;
    TRUE(weft_slice_plan_create(v, &params, &slice) == WEFT_OK);
    TRUE(weft_slice_plan_get_info(slice)->tile_count > 0);
    SURVIVED(weft_footprint_statistics(weft_slice_plan_get_footprint(slice), NULL, &statistics));
    struct weft_slice_report sum = {.minimum = NAN}, other = {.minimum = 1.0f, .passes = INT_MAX};
    weft_slice_report_add(&sum, &other);
    TRUE(sum.minimum == 1.0f && sum.passes == INT_MAX);
    SURVIVED(weft_slice_run_once(slice, weft_slice_compile_params(.context = context),
                                 weft_slice_run_params(.pixels = out), NULL));
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++)
        SURVIVED(weft_slice_verify(
            slice, out, &(struct weft_slice_verify_params){.max_seconds = numbers[n]}, &error));

    slice_runs_refuse(context, slice);
    weft_pass_plan *flat = plan(2), *deep = plan(3);
    struct weft_slice_passes good = {.plan = deep, .log = &logger};
    weft_slice *compiled = NULL;
#define CALL weft_slice_compile(slice, weft_slice_compile_params(.passes = &p), &compiled)
    SET_REFUSED(good, plan, NULL, CALL);
    SET_REFUSED(good, plan, flat, CALL);
    SET_REFUSED(good, plan, deep, CALL); // another kernel than the slice's
    SET_REFUSED(good, low, INFINITY, CALL);
#undef CALL
    weft_pass_plan_destroy(&flat);
    weft_pass_plan_destroy(&deep);
    weft_slice_plan_destroy(&slice);
    weft_volume_destroy(&v);
    weft_context_destroy(&context);
}

// A cut along an axis, with and without what it saves there.
static enum weft_result run_slab(const struct weft_slab_params *p)
{
    static float pixels[16];
    return weft_slab_run(p, weft_slice_compile_params(0), weft_slice_run_params(.pixels = pixels),
                         NULL);
}

static void slabs(void)
{
    weft_volume *v = volume();
    struct weft_slab_params good = {.volume = v, .slice = slice_params(v), .thickness = 1.0};
    struct weft_slab_info info;
    good.slice.engine = WEFT_ENGINE_CPU;
#define CALL weft_slab_place(&p, &info)
    SET_REFUSED(good, volume, NULL, CALL);
    BAD_ENUM(good, combine, CALL);
    BAD_ENUM(good, slice.space, CALL);
    ANY_NUMBER(good, thickness, CALL);
    ANY_NUMBER(good, slice.geometry.u[0], CALL);
    ANY_INT(good, cuts, CALL);
    SET_REFUSED(good, thickness, 1e12, CALL);
    SET_REFUSED(good, cuts, -1, CALL);
#undef CALL
#define CALL run_slab(&p)
    BAD_ENUM(good, combine, CALL);
    EACH_BAD_KERNEL(1, struct weft_slab_params p = good; p.slice.kernel = kernel; REFUSED(CALL))
    SET_REFUSED(good, slice.geometry.width, INT_MAX, CALL);
    SET_REFUSED(good, slice.geometry.height, 0, CALL);
    SET_REFUSED(good, slice.part.width, 2, CALL);
    TRUE(run_slab(&good) == WEFT_OK);
#undef CALL
    REFUSED(weft_slab_run(&good, weft_slice_compile_params(0),
                          weft_slice_run_params(.pixels = NULL), NULL));
    REFUSED(weft_slab_run(&good, weft_slice_compile_params(0),
                          weft_slice_run_params(.pixels = (float[16]){0}, .stride = 1), NULL));
    weft_volume_destroy(&v);
}

static void hardware_plans(void)
{
    weft_volume *v = volume();
    weft_slice_plan *summed = NULL, *slice = NULL;
    weft_hardware_plan *plan = NULL;
    struct weft_slice_params params = slice_params(v);
    TRUE(weft_slice_plan_create(v, &params, &summed) == WEFT_OK);
    params.without = WEFT_SAVING_AXIS | WEFT_SAVING_SEPARABLE;
    TRUE(weft_slice_plan_create(v, &params, &slice) == WEFT_OK);
    struct weft_hardware_params good = {.slice = slice, .log = &logger};
    TRUE(weft_hardware_plan_create(&good, &plan) == WEFT_OK);
    TRUE(weft_hardware_plan_get_info(plan)->fetches_per_pixel == 27);
    weft_hardware_plan_destroy(&plan);
    good.sampler = weft_sampler_assume(WEFT_SOURCE_FLOAT);
#define CALL weft_hardware_plan_create(&p, &plan)
    SET_REFUSED(good, slice, NULL, CALL);
    SET_REFUSED(good, slice, summed, CALL);
    SET_REFUSED(good, memory_bytes, 1, CALL);
    SET_REFUSED(good, sampler.max_size, 1024, CALL);
    SET_REFUSED(good, sampler.max_size, -1, CALL);
    SET_REFUSED(good, sampler.fraction, NAN, CALL);
    SET_REFUSED(good, sampler.fraction, 0.75, CALL);
    SET_REFUSED(good, sampler.rounding, -1.0, CALL);
    SET_REFUSED(good, sampler.rounding, INFINITY, CALL);
#undef CALL
    TRUE(plan == NULL);
    weft_hardware_plan_destroy(&plan);
    weft_hardware_plan_destroy(NULL);
    weft_slice_plan_destroy(&slice);
    weft_slice_plan_destroy(&summed);
    weft_volume_destroy(&v);
}

static void method_runs(void)
{
    weft_context *context = open_context();
    weft_volume *v = volume();
    weft_method_plan *method = NULL;
    float out[16];
    struct weft_method_params params = {.method = {.layout = WEFT_LAYOUT_PLAIN},
                                        .slice = slice_params(v),
                                        .statistics = {.high = 3.0}};
    TRUE(weft_method_plan_create(v, &params, &method) == WEFT_OK);
    TRUE(weft_method_plan_get_info(method)->name[0] && weft_method_plan_get_slice(method));
    TRUE(!weft_method_plan_get_passes(method));
    SURVIVED(
        weft_method_run(method, weft_method_run_params(.context = context, .pixels = out), NULL));
    struct weft_cost_model model = weft_cost_default;
    model.pixel = NAN;
    weft_cost_of(&model, &weft_method_plan_get_info(method)->work);
    for (size_t n = 0; n < WEFT_COUNT(ints); n++)
        TRUE((unsigned)weft_choose_engine(&model, weft_method_plan_get_slice(method), ints[n]) <=
             WEFT_ENGINE_CPU);
    weft_method_plan_destroy(&method);
    weft_volume_destroy(&v);
    weft_context_destroy(&context);
}

static bool stop(void *priv, double fraction)
{
    (void)priv;
    (void)fraction;
    return false;
}

static void calibrations(void)
{
    weft_context *context = open_context();
    struct weft_cost_model model;
    const struct weft_progress at_once = {.report = stop};
    TRUE(weft_cost_calibrate(&logger, context, &at_once, &model) == WEFT_ERR_CANCELLED);
    weft_context_destroy(&context);
}

static enum weft_result make_points(const struct weft_points_params *p)
{
    weft_points *made = NULL;
    const enum weft_result res = weft_points_create(p, &made);
    weft_points_destroy(&made);
    return res;
}

static void points(void)
{
    static const struct weft_derivative first = {{1, 0, 0}};
    struct weft_points_params good = {
        .volume = volume(), .derivative = &first, .derivative_count = 1, .log = &logger};
    weft_points *made = NULL;
#define CALL make_points(&p)
    KERNELS_REFUSED(good, 1, CALL);
    BAD_ENUM(good, space, CALL);
    BAD_ENUM(good, sums, CALL);
    BAD_ENUM(good, cpu.instructions, CALL);
    for (size_t i = 0; i < WEFT_COUNT(ints); i++) {
        const struct weft_derivative bad = {{ints[i], 0, 3}};
        SET_REFUSED(good, derivative, &bad, CALL);
        if (ints[i] != 0 && ints[i] != 1)
            SET_REFUSED(good, derivative_count, ints[i], CALL);
    }
    SET_REFUSED(good, derivative, NULL, CALL);
    SET_REFUSED(good, volume, NULL, CALL);
    ANY_INT(good, memory_bytes, CALL);
    ANY_INT(good, cpu.threads, CALL);
#undef CALL
    TRUE(weft_points_create(&good, &made) == WEFT_OK && weft_points_get_info(made));
    float out[9];
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        const double at[1][3] = {{1.0, numbers[n], 2.0}};
        SURVIVED(weft_points_run(
            made, weft_points_run_params(.count = 1, .position = at, .out = out, .measure = true),
            NULL));
    }
    const struct weft_points_report none = {.bricks_read = 0};
    struct weft_verify_report error[1];
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        const double at[1][3] = {{1.0, numbers[n], 2.0}};
        SURVIVED(weft_points_verify(made,
                                    weft_points_run_params(.count = 1, .position = at, .out = out),
                                    &none, weft_verify_params(.max_seconds = numbers[n]), error));
    }
    REFUSED(weft_points_verify(
        made, weft_points_run_params(.count = SIZE_MAX, .position = NULL, .out = out), &none, NULL,
        error));
    REFUSED(weft_points_run(made, weft_points_run_params(.count = 3), NULL));
    REFUSED(weft_points_run(
        made, weft_points_run_params(.count = 9, .position = (const double(*)[3])numbers), NULL));
    weft_points_destroy(&made);
    weft_points_destroy(NULL);
    weft_volume_destroy(&good.volume);
}

static void polylines(void)
{
    static const double at[2][3] = {{0, 0, 0}, {1, 2, 3}};
    double position[16][3];
    struct weft_polyline good = {.count = 2, .point = at, .across = 1.0};
#define CALL weft_polyline_positions(&logger, &p, 4, 4, position)
    ANY_NUMBER(good, across, CALL);
    ANY_NUMBER(good, up[1], CALL);
    SET_REFUSED(good, count, 1, CALL);
    SET_REFUSED(good, point, NULL, CALL);
#undef CALL
    for (size_t i = 0; i < WEFT_COUNT(ints); i++)
        if (ints[i] != 1)
            REFUSED(weft_polyline_positions(&logger, &good, ints[i] == 99 ? 0 : ints[i], 1 << 21,
                                            position));
    for (size_t n = 0; n < WEFT_COUNT(numbers); n++) {
        const double bad[2][3] = {{0, 0, 0}, {numbers[n], numbers[n], 0}};
        const struct weft_polyline line = {.count = 2, .point = bad, .across = 1.0};
        TRUE(!(weft_polyline_length(&line) < 0.0));
        SURVIVED(weft_polyline_positions(&logger, &line, 4, 4, position));
    }
}

const struct caller_case callers_slices[] = {
    {points,
     {F(points_create), F(points_destroy), F(points_get_info), F(points_run), F(points_verify)}},
    {polylines, {F(polyline_length), F(polyline_positions)}},
    {footprints,
     {F(footprint_create), F(footprint_destroy), F(footprint_get_info), F(footprint_statistics),
      F(footprint_part_statistics), F(slice_statistics_join), F(footprint_set_statistics)}},
    {residents, {F(resident_create), F(resident_destroy), F(resident_get_info)}},
    {slice_geometry, {F(slice_size_compute), F(slice_axis_geometry)}},
    {slice_frames, {F(slice_active_box), F(slice_box_geometry), F(slice_turn), F(slice_mirror)}},
    {slabs, {F(slab_place), F(slab_run)}},
    {slices, {F(slice_plan_create), F(slice_plan_destroy)}},
    {methods, {F(method_plan_create), F(method_plan_destroy), F(method_format), F(method_list)}},
    {choices, {F(choose), F(choice_clear)}},
    {costs,
     {F(cost_of), F(cost_format), F(pass_work_least), F(pass_bound_least), F(separable_work_of)}},
    {window_maps,
     {F(window_map_plain), F(window_map_scale), F(window_map_position), F(window_map_positions),
      F(window_map_square)}},
    {pixel_errors, {F(pixels_verify), F(verify_add), F(verify_join)}},
    {hardware_plans,
     {F(hardware_plan_create), F(hardware_plan_destroy), F(hardware_plan_get_info)}},
    {slice_runs,
     {F(slice_run), F(slice_verify), F(slice_plan_get_info), F(slice_plan_get_footprint),
      F(slice_compile), F(slice_destroy), F(slice_run_once), F(slice_report_add),
      F(slice_multipass_bound_terms)}},
    {method_runs,
     {F(method_run), F(method_plan_get_info), F(method_plan_get_slice), F(method_plan_get_passes),
      F(choose_engine)}},
    {calibrations, {F(cost_calibrate)}},
    {0},
};
