// SPDX-License-Identifier: BSD-3-Clause
// Fails the 1st, 2nd, 3rd ... allocation until the call succeeds. Every failure must be an error,
// leave no file and no descriptor behind, and (under a sanitizer) no memory.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include <math.h>

#include "tests/support/alloc_fail.h"
#include "tests/support/files.h"
#include "tests/support/plan_runs.h"
#include "filter/check.h"
#include "passes/accumulate/accumulate.h"
#include "passes/accumulate/tree/tree.h"
#include "passes/antialias/accumulative.h"
#include "passes/antialias/marks/marks.h"
#include "passes/antialias/multisample.h"
#include "passes/antialias/supersample.h"
#include "passes/distribute/division.h"
#include "passes/distribute/schedule/cost_map.h"
#include "passes/distribute/schedule/load.h"
#include "passes/distribute/schedule/schedule.h"
#include "passes/distribute/items.h"
#include "passes/fused/resident_impl.h"
#include "passes/jitter/discrepancy.h"
#include "passes/lattice/lattice.h"
#include "passes/multipass/multipass.h"
#include "passes/resample/resample.h"
#include "passes/separable/separable.h"
#include "passes/points/points.h"
#include "passes/slice/slab.h"
#include "passes/slice/slice.h"
#include "passes/verify/verify.h"
#include "passes/warp/warp.h"
#include "tiles/image/image.h"
#include "tiles/image/sequence.h"
#include "tiles/mesh/mesh.h"
#include "tiles/kernel/kernel_tiles.h"
#include "tiles/output/output_file.h"
#include "tiles/volume/volume.h"
#include "tiles/volume/volume_nrrd.h"

enum { SIDE = 40, ALLOCATIONS_LIMIT = 10000, EACH_OF = 100 };

static float plane[SIDE * SIDE];
static struct weft_image_channel channels[2] = {{.name = "R", .plane = plane},
                                                {.name = "G", .plane = plane}};
static struct weft_image_attribute attribute = {"a key of more than thirty-one characters",
                                                "string", "value", 5};
static const struct weft_image image = {
    .width = SIDE,
    .height = SIDE,
    .channel_count = 2,
    .channels = channels,
    .attribute_count = 1,
    .attributes = &attribute,
};

// Codes of colours under alpha, with a text beside them.
static struct weft_image_channel code_channels[] = {
    {.name = "R", .type = WEFT_PIXEL_UNORM16, .plane = plane},
    {.name = "G", .type = WEFT_PIXEL_UNORM16, .plane = plane},
    {.name = "B", .type = WEFT_PIXEL_UNORM16, .plane = plane},
    {.name = "A", .type = WEFT_PIXEL_UNORM16, .plane = plane}};
static struct weft_image_attribute comment = {"comments", "string", "value", 5};
static const struct weft_image codes = {
    .width = SIDE,
    .height = SIDE,
    .channel_count = WEFT_COUNT(code_channels),
    .channels = code_channels,
    .attribute_count = 1,
    .attributes = &comment,
};

static enum weft_image_file_kind image_kind;

static enum weft_result save_image_as(const char *name)
{
    const struct weft_image_save_params params = {
        .path = test_path(name), .kind = image_kind, .threads = 1, .log = &test_log};
    return weft_image_save(image_kind == WEFT_IMAGE_FILE_EXR ? &image : &codes, &params);
}

static enum weft_result save_image(void)
{
    return save_image_as("out");
}

static enum weft_result save_preview(void)
{
    return weft_preview_save(
        weft_preview_params(.path = test_path("out"), .width = SIDE, .height = SIDE, .plane = plane,
                            .colour_map = weft_colour_map_list[1], .log = &test_log),
        NULL);
}

static enum weft_result save_colour_preview(void)
{
    return weft_colour_preview_save(
        weft_colour_preview_params(.path = test_path("out"), .width = SIDE, .height = SIDE,
                                   .red = plane, .green = plane, .blue = plane, .log = &test_log));
}

static enum weft_result save_file(void)
{
    struct weft_output_file file;
    enum weft_result res = weft_output_file_create(&test_log, test_path("out"), false, &file);
    return res == WEFT_OK ? weft_output_file_commit(&file) : res;
}

static enum weft_result load_image(void)
{
    struct weft_image loaded;
    struct weft_image_load_params params = {
        .path = test_path("in.image"), .threads = 1, .log = &test_log};
    enum weft_result res = weft_image_load(&params, &loaded);
    weft_image_clear(&loaded);
    return res;
}

static enum weft_result load_parts(void)
{
    struct weft_image_list list;
    struct weft_image_load_params params = {.path = test_path("in.image"), .log = &test_log};
    enum weft_result res = weft_image_list_load(&params, &list);
    weft_image_list_clear(&list);
    return res;
}

static const char *input_name(void *priv, int64_t i)
{
    (void)i;
    return priv;
}

static enum weft_result load_sequence(void)
{
    weft_image_sequence *sequence = NULL;
    const struct weft_image_frame *frame = NULL;
    char name[512];
    snprintf(name, sizeof name, "%s", test_path("in.image"));
    enum weft_result res = weft_image_sequence_create(
        weft_image_sequence_params(.count = 3, .name = input_name, .priv = name, .readers = 1,
                                   .log = &test_log),
        &sequence);
    for (int i = 0; res == WEFT_OK && i < 4; i++)
        res = weft_image_sequence_next(sequence, &frame);
    weft_image_sequence_destroy(&sequence);
    return res;
}

static enum weft_result load_mesh(void)
{
    struct weft_mesh mesh;
    const enum weft_result res =
        weft_mesh_load(weft_mesh_params(.path = test_path("in.obj"), .log = &test_log), &mesh);
    weft_mesh_clear(&mesh);
    return res;
}

static enum weft_result make_tiles(void)
{
    weft_kernel_tiles *set = NULL;
    struct weft_kernel kernel;
    enum weft_result res = weft_kernel_parse(&test_log, "catmull-rom", &kernel);
    if (res == WEFT_OK)
        res = weft_kernel_tiles_create(
            weft_kernel_tiles_params(.kernel = kernel, .samples = 8, .log = &test_log), &set);
    if (res == WEFT_OK)
        res = weft_kernel_tiles_split(set, 0, NAN);
    weft_kernel_tiles_destroy(&set);
    return res;
}

static weft_context *context; // NULL: none is to be had

static enum weft_result create_volume(weft_volume **volume)
{
    return weft_volume_create(weft_volume_params(.size = {SIDE, SIDE, 1}, .data = plane,
                                                 .background = 0.0f, .log = &test_log),
                              volume);
}

static const char *slice_kernel;
static bool by_hardware, with_slopes;

// By the texture sampler, in several tiles.
static enum weft_result filter_slice(const weft_slice_plan *plan, float *pixels)
{
    weft_hardware_plan *hardware = NULL;
    enum weft_result res =
        weft_hardware_plan_create(weft_hardware_params(.slice = plan, .log = &test_log), &hardware);
    if (res == WEFT_OK && context)
        res = weft_slice_run_once(
            plan, weft_slice_compile_params(.context = context, .hardware = hardware),
            weft_slice_run_params(.pixels = pixels), NULL);
    weft_hardware_plan_destroy(&hardware);
    return res;
}

// From voxels in memory to pixels, in several tiles.
static enum weft_result slice_volume(void)
{
    enum { PIXELS = 300 };
    static float pixels[PIXELS * PIXELS];
    weft_volume *volume = NULL;
    weft_slice_plan *plan = NULL;
    struct weft_slice_params params = {.max_target_size = 200, .log = &test_log};
    struct weft_verify_report error;
    if (by_hardware)
        params.without = WEFT_SAVING_AXIS | WEFT_SAVING_SEPARABLE;
    enum weft_result res = weft_kernel_parse(&test_log, slice_kernel, &params.kernel);
    if (res == WEFT_OK)
        res = create_volume(&volume);
    if (res == WEFT_OK)
        res = weft_slice_axis_geometry(&test_log, volume, WEFT_SPACE_WORLD, 2, NAN, PIXELS, PIXELS,
                                       &params.geometry);
    if (res == WEFT_OK)
        res = weft_slice_plan_create(volume, &params, &plan);
    if (res == WEFT_OK && by_hardware)
        res = filter_slice(plan, pixels);
    else if (res == WEFT_OK && context)
        res = weft_slice_run_once(plan, weft_slice_compile_params(.context = context),
                                  weft_slice_run_params(.pixels = pixels), NULL);
    if (res == WEFT_OK && params.kernel.prefiltered)
        res = weft_slice_verify(plan, pixels,
                                &(struct weft_slice_verify_params){.max_seconds = 1e-2}, &error);
    weft_slice_plan_destroy(&plan);
    weft_volume_destroy(&volume);
    return res;
}

// Two planes through what stays of a volume, one beside the other, in a few tiles each.
static enum weft_result slice_resident(void)
{
    enum { PIXELS = 40, PLACES = 16 };
    static const struct weft_derivative outputs[] = {{{0, 0, 0}}, {{0, 1, 0}}, {{2, 0, 0}}};
    static float pixels[WEFT_COUNT(outputs) * PIXELS * PIXELS];
    weft_volume *volume = NULL;
    weft_resident *resident = NULL;
    struct weft_slice_params params = {
        .engine = context ? WEFT_ENGINE_GL : WEFT_ENGINE_CPU,
        .space = WEFT_SPACE_INDEX,
        .geometry = {{1, 1, -1}, {38, 1, 2}, {-1, 38, 1}, PIXELS, PIXELS},
        .without = WEFT_SAVING_CONSTANT,
        .derivative = outputs,
        .derivative_count = with_slopes ? (int)WEFT_COUNT(outputs) : 1,
        .log = &test_log};
    enum weft_result res = weft_kernel_parse(&test_log, slice_kernel, &params.kernel);
    if (res == WEFT_OK)
        res = create_volume(&volume);
    if (res == WEFT_OK)
        res = weft_resident_create(
            weft_resident_params(.volume = volume, .context = context, .kernel = params.kernel,
                                 .layout = WEFT_LAYOUT_PLAIN,
                                 .memory_bytes = (uint64_t)PLACES * 11 * 11 * 11 * 4,
                                 .log = &test_log),
            &resident);
    params.resident = resident;
    for (int i = 0; res == WEFT_OK && i < 2; i++) {
        weft_slice_plan *plan = NULL;
        struct weft_slice_blocks blocks = {.texels = NULL};
        params.geometry.origin[2] += i;
        res = weft_slice_plan_create(volume, &params, &plan);
        if (res == WEFT_OK && context)
            res = weft_slice_run_once(plan, weft_slice_compile_params(.context = context),
                                      weft_slice_run_params(.pixels = pixels), NULL);
        else if (res == WEFT_OK)
            res = weft_slice_blocks_create(plan, &blocks);
        if (res == WEFT_OK && !context)
            res = weft_resident_load(resident, plan, 0, NULL, &blocks);
        weft_slice_blocks_destroy(&blocks);
        weft_slice_plan_destroy(&plan);
    }
    weft_resident_destroy(&resident);
    weft_volume_destroy(&volume);
    return res;
}

// A value and its slope at points, by one thread.
static enum weft_result sample_points(void)
{
    static const double at[][3] = {{3, 4, 5}, {20.5, 3.25, 11}, {1e6, 0, 0}};
    static const struct weft_derivative outputs[] = {{{0, 0, 0}}, {{0, 1, 0}}};
    float out[2 * WEFT_COUNT(at)];
    weft_volume *volume = NULL;
    weft_points *points = NULL;
    struct weft_points_params params = {.space = WEFT_SPACE_INDEX,
                                        .derivative = outputs,
                                        .derivative_count = 2,
                                        .cpu.threads = 1,
                                        .log = &test_log};
    enum weft_result res = weft_kernel_parse(&test_log, slice_kernel, &params.kernel);
    if (res == WEFT_OK)
        res = create_volume(&volume);
    params.volume = volume;
    if (res == WEFT_OK)
        res = weft_points_create(&params, &points);
    if (res == WEFT_OK)
        res = weft_points_run(points,
                              weft_points_run_params(.count = WEFT_COUNT(at), .position = at,
                                                     .out = out, .measure = true),
                              NULL);
    weft_points_destroy(&points);
    weft_volume_destroy(&volume);
    return res;
}

// Two cuts of two channels, by one thread.
static enum weft_result combine_cuts(void)
{
    enum { PIXELS = 4 };
    static const enum weft_quantity asked[] = {WEFT_QUANTITY_VALUE, WEFT_QUANTITY_GRADIENT};
    static float pixels[4 * PIXELS * PIXELS];
    struct weft_quantities list;
    weft_volume *volume = NULL;
    struct weft_slab_params params = {
        .slice = {.engine = WEFT_ENGINE_CPU,
                  .geometry = {{1, 1, -1}, {38, 1, 2}, {-1, 38, 1}, PIXELS, PIXELS},
                  .log = &test_log},
        .thickness = 1.0,
        .cuts = 2,
        .quantities = &list};
    enum weft_result res = weft_kernel_parse(&test_log, slice_kernel, &params.slice.kernel);
    if (res == WEFT_OK)
        res = weft_quantities_create(&test_log, asked, 2, &list);
    if (res == WEFT_OK)
        res = create_volume(&volume);
    params.volume = volume;
    if (res == WEFT_OK)
        res = weft_slab_run(&params, weft_slice_compile_params(.cpu.threads = 1),
                            weft_slice_run_params(.pixels = pixels), NULL);
    weft_volume_destroy(&volume);
    return res;
}

// A straightened slice of a corner.
static enum weft_result straighten_line(void)
{
    static const double at[][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
    double position[16][3];
    const struct weft_polyline line = {.count = 3, .point = at, .across = 1.0};
    return weft_polyline_positions(&test_log, &line, 4, 4, position);
}

// In several rectangles, through staging memory.
static enum weft_result filter_plane(void)
{
    enum { PIXELS = 99 };
    static float pixels[PIXELS * PIXELS];
    static double at[PIXELS];
    for (int i = 0; i < PIXELS; i++)
        at[i] = i * 0.4;
    weft_separable_plan *plan = NULL;
    weft_separable *compiled = NULL;
    enum weft_result res = weft_separable_plan_create(
        weft_separable_params(.size = {SIDE, SIDE}, .width = PIXELS, .height = PIXELS, .x = at,
                              .y = at, .memory_bytes = 40000, .log = &test_log),
        &plan);
    if (res == WEFT_OK)
        res = weft_separable_compile(plan, weft_separable_compile_params(.context = context),
                                     &compiled);
    if (res == WEFT_OK)
        res = weft_separable_run(
            compiled,
            weft_separable_run_params(.samples = plane, .pixels = pixels, .log = &test_log), NULL);
    weft_separable_destroy(&compiled);
    weft_separable_plan_destroy(&plan);
    return res;
}

static const char *resample_kernel;
static bool resample_passes;

// Two channels whose rows lie apart.
static enum weft_result resample_planes(void)
{
    enum { PIXELS = 50 };
    static float pixels[2][PIXELS * PIXELS];
    weft_pass_plan *passes = NULL;
    weft_resample_plan *plan = NULL;
    weft_resample_compiled *compiled = NULL;
    weft_resample_source *source = NULL;
    struct weft_kernel kernel;
    enum weft_result res = weft_kernel_parse(&test_log, resample_kernel, &kernel);
    if (res == WEFT_OK && resample_passes)
        res = weft_pass_plan_create(
            weft_pass_plan_params(.kernel = kernel, .samples = 16, .log = &test_log), &passes);
    if (res == WEFT_OK)
        res = weft_resample_plan_create(
            weft_resample_params(.passes = passes, .kernel = kernel, .size = {SIDE - 1, SIDE},
                                 .width = PIXELS, .height = PIXELS, .log = &test_log),
            &plan);
    if (res == WEFT_OK)
        res = weft_resample_compile(
            plan, weft_resample_compile_params(.context = passes ? NULL : context), &compiled);
    if (res == WEFT_OK)
        res = weft_resample_source_create(
            weft_resample_source_params(.kernel = kernel, .width = SIDE - 1, .height = SIDE,
                                        .stride = SIDE, .channels = 2, .plane = {plane, plane},
                                        .log = &test_log),
            &source);
    if (res == WEFT_OK)
        res = weft_resample_run(compiled,
                                &(struct weft_resample_run_params){.source = source,
                                                                   .plane = {pixels[0], pixels[1]},
                                                                   .log = &test_log},
                                NULL);
    weft_resample_source_destroy(&source);
    weft_resample_compiled_destroy(&compiled);
    weft_resample_plan_destroy(&plan);
    weft_pass_plan_destroy(&passes);
    return res;
}

static bool warp_in_double, warp_aligned;

// Turned, or in perspective where sums are doubles.
static enum weft_result warp_planes(void)
{
    enum { PIXELS = 8 };
    static float pixels[2][PIXELS * PIXELS];
    weft_warp_plan *plan = NULL;
    weft_warp_compiled *compiled = NULL;
    weft_resample_source *source = NULL;
    struct weft_verify_report error;
    struct weft_warp_params params =
        *weft_warp_params(.map.matrix = {0.2, -0.1, 2.0, 0.1, 0.2, 0.5, 0.0, 0.0, 1.0},
                          .size = {SIDE, SIDE}, .width = PIXELS, .height = PIXELS,
                          .engine = context ? WEFT_ENGINE_GL : WEFT_ENGINE_CPU,
                          .sums = warp_in_double ? WEFT_SUMS_DOUBLE : WEFT_SUMS_FLOAT,
                          .log = &test_log);
    params.map.matrix[6] = warp_in_double ? 0.001 : 0.0;
    if (warp_aligned) // the axes are swapped
        params.map.matrix[0] = params.map.matrix[4] = 0.0;
    enum weft_result res = weft_kernel_parse(&test_log, "catmull-rom", &params.kernel);
    if (res == WEFT_OK)
        res = weft_warp_plan_create(&params, &plan);
    if (res == WEFT_OK && isnan(weft_warp_plan_get_info(plan)->bound.relative))
        res = WEFT_ERR_READER; // a bound that nobody knows
    if (res == WEFT_OK)
        res = weft_warp_compile(
            plan, weft_resample_compile_params(.context = context, .cpu.threads = 1), &compiled);
    if (res == WEFT_OK)
        res = weft_resample_source_create(
            weft_resample_source_params(.kernel = params.kernel, .width = SIDE, .height = SIDE,
                                        .channels = 2, .plane = {plane, plane}, .threads = 1,
                                        .log = &test_log),
            &source);
    if (res == WEFT_OK)
        res = weft_warp_run(compiled,
                            weft_warp_run_params(.source = source, .plane = {pixels[0], pixels[1]},
                                                 .log = &test_log),
                            NULL);
    if (res == WEFT_OK)
        res = weft_warp_verify(
            plan,
            &(struct weft_resample_verify_params){
                .source = source, .plane = {pixels[0], pixels[1]}, .log = &test_log},
            &error);
    weft_resample_source_destroy(&source);
    weft_warp_compiled_destroy(&compiled);
    weft_warp_plan_destroy(&plan);
    return res;
}

static enum weft_result save_nrrd(void)
{
    weft_volume *volume = NULL;
    enum weft_result res = create_volume(&volume);
    if (res == WEFT_OK)
        res = weft_volume_save_nrrd(
            weft_nrrd_save_params(.path = test_path("out"), .volume = {volume, volume, volume},
                                  .components = 3, .type = WEFT_SAMPLE_INT16, .log = &test_log));
    weft_volume_destroy(&volume);
    return res;
}

static enum weft_result save_volume(void)
{
    weft_volume *volume = NULL;
    struct weft_volume_save_params params = {.path = test_path("out"), .log = &test_log};
    enum weft_result res = create_volume(&volume);
    if (res == WEFT_OK)
        res = weft_volume_save(volume, &params);
    weft_volume_destroy(&volume);
    return res;
}

static enum weft_result drop_lot(void *priv, const struct weft_volume_lot *lot)
{
    (void)priv, (void)lot;
    return WEFT_OK;
}

// Scaled along the axes, and turned; values and gradients.
static enum weft_result make_lattice(void)
{
    static const enum weft_quantity asked[] = {WEFT_QUANTITY_VALUE, WEFT_QUANTITY_GRADIENT};
    struct weft_quantities list;
    weft_volume *volume = NULL;
    enum weft_result res = weft_quantities_create(&test_log, asked, 2, &list);
    if (res == WEFT_OK)
        res = create_volume(&volume);
    for (int turned = 0; res == WEFT_OK && turned < 2; turned++) {
        weft_lattice_plan *made = NULL;
        struct weft_lattice_params params = {
            .volume = volume, .quantities = &list, .log = &test_log};
        const struct weft_lattice_run_params how = {
            .sink = drop_lot, .cpu = {.threads = 1}, .verify = {.share = 0.001}};
        for (int a = 0; a < 3; a++)
            params.to_source[a][a] = 1.5;
        params.to_source[0][1] = turned;
        res = weft_lattice_plan_create(&params, &made);
        if (res == WEFT_OK)
            res = weft_lattice_run(made, &how, NULL);
        weft_lattice_plan_destroy(&made);
    }
    weft_volume_destroy(&volume);
    return res;
}

static enum weft_result load_volume(void)
{
    weft_volume *volume = NULL;
    struct weft_brick_list list = {0};
    static float values[64 * WEFT_BRICK_VOXELS];
    struct weft_volume_open_params params = {.path = test_path("in.vdb"), .log = &test_log};
    struct weft_region everywhere = {.min = {0, 0, 0}, .max = {SIDE, SIDE, SIDE}};
    enum weft_result res = weft_volume_open(&params, &volume);
    if (res == WEFT_OK)
        res = weft_volume_find(volume, &everywhere, &list);
    if (res == WEFT_OK)
        res = weft_volume_read(volume, list.brick_count < 64 ? list.brick_count : 64,
                               (const int32_t(*)[3])list.brick_origin, values);
    weft_brick_list_clear(&list);
    weft_volume_destroy(&volume);
    return res;
}

static enum weft_technique technique;

// Plans a gradient and runs it without GL.
static enum weft_result plan_and_run(void)
{
    static float pixels[16 * 16];
    weft_pass_plan *plan = NULL;
    const struct weft_samples samples = {.size = {SIDE, SIDE, 1}, .plane = {plane}, .high = 1.0};
    const struct weft_pixel_grid grid = {
        .width = 16, .height = 16, .du = {0.1, 0.0}, .dv = {0.0, 0.1}};
    const struct weft_pass_plan_params *params =
        weft_pass_plan_params(.samples = 4, .taps_per_pass = 2, .technique = technique,
                              .derivative = {{technique == WEFT_TECHNIQUE_PLAIN, 0, 0}},
                              .log = &test_log);
    enum weft_result res = weft_pass_plan_create(params, &plan);
    const struct weft_multipass_run_params run = {
        .samples = &samples, .grid = &grid, .pixels = {pixels}, .log = &test_log};
    if (res == WEFT_OK)
        res = run_plan(NULL, plan, &run, NULL);
    if (res == WEFT_OK && context)
        res = run_plan(context, plan, &run, NULL);
    weft_pass_plan_destroy(&plan);
    return res;
}

static enum weft_result average_frame(void *priv, int leaf, size_t count, uint16_t *codes)
{
    (void)priv;
    for (size_t i = 0; i < count; i++)
        codes[i] = (uint16_t)leaf;
    return WEFT_OK;
}

static enum weft_result run_tree(void)
{
    weft_tree *tree = NULL;
    uint16_t out[16];
    const struct weft_tree_source source = {.fill = average_frame};
    enum weft_result res = weft_tree_create(
        &(struct weft_tree_params){.leaf_count = 10, .branching = 3, .log = &test_log}, &tree);
    if (res == WEFT_OK)
        res = weft_tree_run_codes(tree, &source, WEFT_COUNT(out), out);
    weft_tree_destroy(&tree);
    return res;
}

static enum weft_accumulate_method accumulate_method;

// Halves, then floats with a value of no number, which makes sums wide and marks; a state on the
// way. One thread: the failing allocation is anybody's.
static enum weft_result accumulate(void)
{
    enum { COUNT = 16 };
    static const float floats[COUNT] = {1.0f, NAN}, numbers[COUNT] = {0.5f};
    static const uint16_t halves[COUNT] = {0x3c00};
    const bool exact = accumulate_method == WEFT_ACCUMULATE_EXACT;
    const struct weft_plane planes[] = {{.values = halves, .type = WEFT_PLANE_HALF},
                                        {.values = exact ? floats : numbers}};
    const struct weft_accumulator_params params = {.width = 4,
                                                   .height = 4,
                                                   .channel_count = 1,
                                                   .method = accumulate_method,
                                                   .emulate = true,
                                                   .keep = WEFT_KEEP_VARIANCE | WEFT_KEEP_EXTREMES,
                                                   .nonfinite = exact ? WEFT_NONFINITE_SKIP
                                                                      : WEFT_NONFINITE_ERROR,
                                                   .batch = 2,
                                                   .cpu.threads = 1,
                                                   .log = &test_log};
    weft_accumulator *a = NULL, *b = NULL;
    void *state = NULL;
    size_t size = 0;
    float out[COUNT];
    struct weft_convergence found;
    enum weft_result res = weft_accumulator_create(&params, &a);
    for (int f = 0; f < 2 && res == WEFT_OK; f++)
        res = weft_accumulator_add(a, &(struct weft_frame){.plane = &planes[f]}, 1.0);
    if (res == WEFT_OK)
        res = weft_accumulator_judge(a, &(struct weft_until){.absolute = 1.0}, &found);
    if (res == WEFT_OK)
        res = weft_accumulator_save(a, &state, &size);
    if (res == WEFT_OK)
        res = weft_accumulator_create(&params, &b);
    if (res == WEFT_OK)
        res = weft_accumulator_load(b, state, size);
    if (res == WEFT_OK && exact)
        res = weft_accumulator_join(b, a);
    if (res == WEFT_OK)
        res = weft_accumulator_current(b, WEFT_ACCUMULATED_MEAN, 0, out, 0);
    free(state);
    weft_accumulator_destroy(&a);
    weft_accumulator_destroy(&b);
    return res;
}

static enum weft_result judge_samples(void)
{
    struct weft_jitter set;
    struct weft_discrepancy d;
    enum weft_result res = weft_jitter_create(
        weft_jitter_params(.info = weft_jitter_find("halton"), .log = &test_log), &set);
    if (res == WEFT_OK)
        res = weft_discrepancy_compute(
            weft_discrepancy_params(.points = (const double(*)[2])set.points, .count = set.count,
                                    .log = &test_log),
            &d);
    weft_jitter_clear(&set);
    return res;
}

static enum weft_result spread_samples(void)
{
    static const double points[2][2] = {{0.0, 0.1}, {0.2, 0.0}};
    struct weft_kernel kernel;
    struct weft_spread spread;
    const enum weft_result res = weft_kernel_parse(NULL, "mitchell", &kernel);
    if (res != WEFT_OK)
        return res;
    const enum weft_result made =
        weft_spread_create(weft_spread_params(.position = points, .count = 2, .filter = kernel,
                                              .bits = 12, .log = &test_log),
                           &spread);
    weft_spread_clear(&spread);
    return made;
}

static enum weft_result draw_nothing(void *priv, const struct weft_antialias_pass *pass)
{
    (void)priv;
    (void)pass;
    return WEFT_OK;
}

static enum weft_result multisample(void)
{
    const struct weft_antialias_drawing drawing = {.draw = draw_nothing};
    weft_msaa *msaa;
    enum weft_result res =
        weft_msaa_create(weft_msaa_params(.width = 4, .height = 4, .resolve = WEFT_MSAA_SUM,
                                          .context = context, .log = &test_log),
                         &msaa);
    if (res == WEFT_OK)
        res = weft_msaa_run(msaa, &drawing);
    weft_msaa_destroy(&msaa);
    return res;
}

static enum weft_acaa_form acaa_form;

static enum weft_result accumulate_samples(void)
{
    const struct weft_antialias_drawing drawing = {.draw = draw_nothing};
    weft_acaa *acaa;
    enum weft_result res =
        weft_acaa_create(weft_acaa_params(.width = 4, .height = 4, .form = acaa_form,
                                          .context = context, .log = &test_log),
                         &acaa);
    if (res == WEFT_OK)
        res = weft_acaa_run(acaa, &drawing, NULL);
    weft_acaa_destroy(&acaa);
    return res;
}

static enum weft_result mark(void)
{
    const struct weft_antialias_drawing drawing = {.draw = draw_nothing};
    weft_marker *marker;
    struct weft_marks marks = {0};
    enum weft_result res =
        weft_marker_create(weft_marker_params(.width = 4, .height = 4, .contrast = 0.5,
                                              .context = context, .log = &test_log),
                           &marker);
    if (res == WEFT_OK)
        res = weft_marker_run(marker, &drawing, &marks);
    weft_marks_clear(&marks);
    weft_marker_destroy(&marker);
    return res;
}

// Marked pixels of two samples, filtered, in blocks or not.
static enum weft_result supersample(void)
{
    static const double position[2][2] = {{-0.25, 0.0}, {0.25, 0.0}};
    const struct weft_antialias_drawing drawing = {.draw = draw_nothing};
    uint8_t marked[16] = {[5] = 1};
    const struct weft_marks marks = {.width = 4, .height = 4, .marked = marked, .count = 1};
    struct weft_kernel kernel;
    enum weft_result res = weft_kernel_parse(NULL, "mitchell", &kernel);
    for (int store = 0; store < WEFT_STORE_COUNT && res == WEFT_OK; store++) {
        weft_supersample *s;
        float out[16];
        res = weft_supersample_create(
            weft_supersample_params(.width = 4, .height = 4, .position = position, .count = 2,
                                    .filter = kernel, .store = (enum weft_supersample_store)store,
                                    .context = context, .log = &test_log),
            &s);
        if (res == WEFT_OK)
            res = weft_supersample_run(s, &drawing, &marks, NULL);
        if (res == WEFT_OK)
            res = weft_supersample_read(s, 0, out, 0);
        weft_supersample_destroy(&s);
    }
    return res;
}

// The next allocation to fail: each of the first ones, then every seventh, all of them with
// WEFT_ALLOCATIONS=full.
static unsigned long next_allocation(unsigned long k)
{
    const char *size = getenv("WEFT_ALLOCATIONS");
    const bool full = size && strcmp(size, "full") == 0;
    return k + (full || k < EACH_OF ? 1 : 7);
}

static void run(const char *what, enum weft_result (*call)(void))
{
    enum weft_result res;
    unsigned long k = 0, tried = 0, refused = 0;
    int entries = test_count_entries(test_folder);
    int descriptors = test_count_entries("/proc/self/fd");
    do {
        k = next_allocation(k);
        assert_true(k < ALLOCATIONS_LIMIT);
        tried++;
        test_forget();
        alloc_fail_at(k);
        res = call();
        bool struck = alloc_fail_struck();
        alloc_fail_at(0);
        if (struck && res != WEFT_ERR_MEMORY && res != WEFT_OK)
            fail_msg("%s, allocation %lu: result %d (%s)", what, k, res, test_message);
        if (!struck)
            assert_int_equal(res, WEFT_OK);
        refused += res != WEFT_OK;
        if (res != WEFT_OK) {
            if (test_errors != 1)
                fail_msg("%s, allocation %lu: %d error lines", what, k, test_errors);
            assert_int_equal(test_count_entries(test_folder), entries);
        }
        remove(test_path("out"));
        assert_int_equal(test_count_entries("/proc/self/fd"), descriptors);
        if (!struck)
            break;
    } while (true);
    print_message("%s: %lu allocations failed in turn\n", what, tried - 1);
    assert_true(tried > 1 && refused > 0);
}

static void run_of(const char *what, const char *kind, enum weft_result (*call)(void))
{
    char name[64];
    snprintf(name, sizeof name, "%s, %s", what, kind);
    run(name, call);
}

static void test_outputs(void **state)
{
    (void)state;
    run("weft_output_file", save_file);
    for (int k = 0; k < WEFT_IMAGE_FILE_KIND_COUNT; k++) {
        image_kind = (enum weft_image_file_kind)k;
        run_of("weft_image_save", weft_image_file_kind_names[k], save_image);
    }
    run("weft_preview_save", save_preview);
    run("weft_colour_preview_save", save_colour_preview);
}

static void test_load(void **state)
{
    (void)state;
    for (int k = 0; k < WEFT_IMAGE_FILE_KIND_COUNT; k++) {
        image_kind = (enum weft_image_file_kind)k;
        assert_int_equal(save_image_as("in.image"), WEFT_OK);
        run_of("weft_image_load", weft_image_file_kind_names[k], load_image);
        run_of("weft_image_list_load", weft_image_file_kind_names[k], load_parts);
    }
    run("weft_image_sequence", load_sequence);
    test_write_file(test_path("in.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", 32);
    run("weft_mesh_load", load_mesh);
}

static enum weft_result make_item(void *priv, int64_t item, void **data, size_t *size)
{
    (void)priv, (void)item;
    *size = 8;
    *data = calloc(1, *size);
    if (!*data)
        weft_error(&test_log, "out of memory: an item");
    return *data ? WEFT_OK : WEFT_ERR_MEMORY;
}

static enum weft_result take_item(void *priv, int64_t item, const void *data, size_t size)
{
    (void)priv, (void)item, (void)data, (void)size;
    return WEFT_OK;
}

static enum weft_result work_on_items(void *priv, weft_ranks *ranks)
{
    static const double costs[] = {1.0, 3.0, 2.0};
    const struct weft_items work = {.count = 3,
                                    .cost = costs,
                                    .run = make_item,
                                    .take = take_item,
                                    .schedule = WEFT_SCHEDULE_PULL};
    struct weft_items_report report;
    struct weft_ranks_part part;
    (void)priv;
    enum weft_result res = weft_ranks_do_items(ranks, &work, &report);
    weft_items_report_clear(&report);
    if (res == WEFT_OK)
        res = weft_ranks_gather(ranks, costs, sizeof costs, &part);
    if (res == WEFT_OK)
        weft_ranks_free_parts(1, &part);
    return res;
}

static enum weft_result distribute(void)
{
    return weft_distribute_over(NULL, weft_distribute_params(.log = &test_log), work_on_items,
                                NULL);
}

static void test_ranks(void **state)
{
    (void)state;
    run("weft_distribute_over, weft_ranks_do_items", distribute);
}

static void test_tiles(void **state)
{
    (void)state;
    run("weft_kernel_tiles", make_tiles);
}

static void test_volumes(void **state)
{
    (void)state;
    run("weft_volume_save", save_volume);
    assert_int_equal(save_volume(), WEFT_OK);
    assert_int_equal(rename(test_path("out"), test_path("in.vdb")), 0);
    run("weft_volume_open", load_volume);
    run("weft_volume_save_nrrd", save_nrrd);
    run("weft_lattice_run", make_lattice);
}

static void test_slices(void **state)
{
    (void)state;
    struct weft_context_params params = {.kind = WEFT_CONTEXT_AUTO, .log = &test_log};
    if (weft_context_create(&params, &context) != WEFT_OK)
        print_message("[  SKIPPED ] no GL context: slices are planned, not run\n");
    slice_kernel = "catmull-rom";
    run("weft_slice", slice_volume);
    by_hardware = true;
    run("weft_slice, hardware", slice_volume);
    by_hardware = false;
    if (context)
        run("weft_separable", filter_plane);
    run("weft_resident", slice_resident);
    run("weft_points", sample_points);
    with_slopes = true;
    run("weft_resident, derivatives", slice_resident);
    with_slopes = false;
    slice_kernel = "bspline3i";
    run("weft_slice, prefiltered", slice_volume);
    run("weft_resident, prefiltered", slice_resident);
    run("weft_points, prefiltered", sample_points);
    run("weft_polyline", straighten_line);
    slice_kernel = "bspline";
    run("weft_slab", combine_cuts);
    slice_kernel = "bspline3i";
    weft_context_destroy(&context);
    run("weft_resident, in memory", slice_resident);
}

static void test_resampling(void **state)
{
    static const char *const kernels[] = {"catmull-rom", "bspline3i"};
    (void)state;
    const struct weft_context_params params = {.kind = WEFT_CONTEXT_AUTO, .log = &test_log};
    if (weft_context_create(&params, &context) != WEFT_OK)
        print_message("[  SKIPPED ] no GL context: planes are resampled on the CPU only\n");
    for (size_t k = 0; k < WEFT_COUNT(kernels); k++) {
        resample_kernel = kernels[k];
        for (int passes = context ? 0 : 1; passes < 2; passes++) {
            resample_passes = passes;
            run(passes ? "weft_resample, by passes" : "weft_resample", resample_planes);
        }
    }
    if (context)
        run("weft_warp", warp_planes);
    weft_context_destroy(&context);
    run("weft_warp, in memory", warp_planes);
    warp_in_double = true;
    run("weft_warp, in memory, in double", warp_planes);
    warp_in_double = false;
    warp_aligned = true;
    run("weft_warp, aligned", warp_planes);
}

static void test_plans(void **state)
{
    (void)state;
    const struct weft_context_params params = {.kind = WEFT_CONTEXT_AUTO, .log = &test_log};
    if (weft_context_create(&params, &context) != WEFT_OK)
        print_message("[  SKIPPED ] no GL context: plans are emulated only\n");
    for (int t = 0; weft_technique_names[t]; t++) {
        technique = (enum weft_technique)t;
        run(weft_technique_names[t], plan_and_run);
    }
    if (context) {
        run("weft_msaa", multisample);
        run("weft_marker", mark);
        run("weft_acaa", accumulate_samples);
        acaa_form = WEFT_ACAA_JITTER;
        run("weft_acaa, jitter", accumulate_samples);
        run("weft_supersample", supersample);
    }
    weft_context_destroy(&context);
    run("weft_spread", spread_samples);
    run("weft_tree", run_tree);
    run("weft_jitter, weft_discrepancy", judge_samples);
    for (int m = WEFT_ACCUMULATE_EXACT; m < WEFT_ACCUMULATE_METHOD_COUNT; m++) {
        accumulate_method = (enum weft_accumulate_method)m;
        run(weft_accumulate_method_names[m], accumulate);
    }
}

static enum weft_result divide(void)
{
    weft_regions *regions = NULL;
    struct weft_load load;
    const double seconds[8] = {1.0};
    enum weft_result res = weft_regions_create(
        weft_regions_params(.width = SIDE, .height = SIDE / 2, .log = &test_log), &regions);
    if (res != WEFT_OK)
        return res;
    // These two have no log.
    res = weft_regions_balance(regions, seconds, 0.0);
    weft_regions_destroy(&regions);
    if (res == WEFT_OK)
        res = weft_load_create(3, &load);
    if (res == WEFT_OK)
        weft_load_clear(&load);
    test_errors += res != WEFT_OK;
    return res;
}

static enum weft_result learn(void *priv, weft_ranks *ranks)
{
    weft_division *division = NULL;
    double seconds[8] = {1.0};
    const struct weft_items_report report = {.item_seconds = seconds,
                                             .schedule = WEFT_SCHEDULE_DYNAMIC};
    enum weft_result res = weft_division_create(
        ranks,
        weft_division_params(.regions = {.width = SIDE, .height = SIDE / 2, .log = &test_log},
                             .schedule = WEFT_SCHEDULE_DYNAMIC, .map = priv),
        &division);
    if (res == WEFT_OK)
        res = weft_division_learn(division, &report);
    weft_division_destroy(&division);
    return res;
}

static enum weft_result keep_costs(void)
{
    weft_cost_map *map = NULL;
    enum weft_result res = weft_cost_map_create(SIDE, SIDE / 2, &map);
    test_errors += res != WEFT_OK; // without a log
    if (res == WEFT_OK)
        res = weft_cost_map_save(&test_log, map, test_path("out"));
    weft_cost_map_destroy(&map);
    if (res == WEFT_OK)
        res = weft_cost_map_load(&test_log, test_path("out"), SIDE, SIDE / 2, &map);
    remove(test_path("out"));
    if (res != WEFT_OK)
        return res;
    res = weft_distribute_over(NULL, weft_distribute_params(.log = &test_log), learn, map);
    if (res != WEFT_OK && test_errors == 0)
        test_errors++; // boundaries are moved without a log
    weft_cost_map_destroy(&map);
    return res;
}

static void test_schedules(void **state)
{
    (void)state;
    run("weft_cost_map, weft_division", keep_costs);
    run("weft_regions, weft_load", divide);
}

#define IN_FOLDER(name) cmocka_unit_test_setup_teardown(name, test_enter_folder, test_leave_folder)

int main(void)
{
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 1);
    setenv("MESA_SHADER_CACHE_DISABLE", "true", 1); // its thread has files open, now and then
    for (int i = 0; i < SIDE * SIDE; i++)
        plane[i] = (float)i;
    const struct CMUnitTest tests[] = {
        IN_FOLDER(test_outputs),    IN_FOLDER(test_load),   IN_FOLDER(test_tiles),
        IN_FOLDER(test_volumes),    IN_FOLDER(test_slices), IN_FOLDER(test_plans),
        IN_FOLDER(test_resampling), IN_FOLDER(test_ranks),  IN_FOLDER(test_schedules),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
