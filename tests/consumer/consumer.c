// SPDX-License-Identifier: BSD-3-Clause
// consumer [RAMP.vdb]: what a user's program does with weft: plans, opens a context and cuts slices,
// of a volume in memory and of a file of `weft make ramp --size 8`, and calls what needs each library
// that weft is linked with.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include <weft.h>

static void say(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    if (level <= WEFT_LOG_WARNING)
        fprintf(stderr, "%s\n", message);
}

static const struct weft_log logger = {.write = say};

static void must(enum weft_result res, const char *what)
{
    if (res == WEFT_OK)
        return;
    fprintf(stderr, "%s: %s\n", what, weft_result_text(res));
    exit(1);
}

static void plan_passes(void)
{
    weft_pass_plan *plan = NULL;
    must(weft_pass_plan_create(weft_pass_plan_params(.log = &logger), &plan),
         "weft_pass_plan_create");
    puts(weft_pass_plan_get_info(plan)->valid ? "a valid plan" : "an invalid plan");
    weft_pass_plan_destroy(&plan);
}

// PNG by libpng, EXR by OpenEXRCore.
static void write_images(void)
{
    float plane[2] = {0.0f, 1.0f};
    struct weft_image_channel channel = {.name = "Y", .plane = plane};
    const struct weft_image image = {
        .width = 2, .height = 1, .channel_count = 1, .channels = &channel};
    const struct weft_image_save_params save = {.path = "/dev/null", .log = &logger};
    must(weft_preview_save(weft_preview_params(.path = "/dev/null", .width = 2, .height = 1,
                                               .plane = plane, .log = &logger),
                           NULL),
         "weft_preview_save");
    must(weft_image_save(&image, &save), "weft_image_save");
}

// Pixels are to lie on the voxels of plane z, side x side of them.
static void cut_plane(weft_volume *volume, int z, int side, const float *expected)
{
    float pixels[64];
    weft_context *context = NULL;
    weft_slice_plan *plan = NULL;
    struct weft_slice_params params = {.space = WEFT_SPACE_INDEX, .log = &logger};
    const struct weft_context_params any = {.kind = WEFT_CONTEXT_AUTO, .log = &logger};
    must(weft_slice_axis_geometry(&logger, volume, params.space, 2, z, side, side,
                                  &params.geometry),
         "weft_slice_axis_geometry");
    must(weft_slice_plan_create(volume, &params, &plan), "weft_slice_plan_create");
    must(weft_context_create(&any, &context), "weft_context_create");
    must(weft_slice_run_once(plan, weft_slice_compile_params(.context = context),
                             weft_slice_run_params(.pixels = pixels), NULL),
         "weft_slice_run_once");
    for (int i = 0; i < side * side; i++)
        if (!(fabsf(pixels[i] - expected[i]) <= 1e-5f))
            must(WEFT_ERR_GL, "the slice's values");
    printf("a slice by %s\n", weft_context_get_info(context)->renderer);
    weft_context_destroy(&context);
    weft_slice_plan_destroy(&plan);
}

static void cut_memory(void)
{
    static const float data[8] = {1, 2, 3, 4, 5, 6, 7, 8};
    weft_volume *volume = NULL;
    must(weft_volume_create(weft_volume_params(.size = {2, 2, 2}, .data = data), &volume),
         "weft_volume_create");
    cut_plane(volume, 0, 2, data);
    weft_volume_destroy(&volume);
}

// By a reader, which weft finds.
static void cut_file(const char *path)
{
    enum { SIDE = 8, Z = 3 };
    float ramp[SIDE * SIDE];
    weft_volume *volume = NULL;
    must(weft_volume_open(weft_volume_open_params(.path = path, .log = &logger), &volume),
         "weft_volume_open");
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++)
            ramp[SIDE * y + x] = (float)(x + 2 * y + 3 * Z + 3) / (6 * SIDE);
    cut_plane(volume, Z, SIDE, ramp);
    weft_volume_destroy(&volume);
}

// README.md's second example, smaller.
static enum weft_result enlarge(weft_context *context, const float *const plane[3],
                                float *const out[3])
{
    weft_resample_plan *plan = NULL;
    weft_resample_compiled *compiled = NULL;
    weft_resample_source *source = NULL;
    enum weft_result res = weft_resample_plan_create(
        weft_resample_params(.size = {3, 2}, .width = 9, .height = 6), &plan);
    if (res == WEFT_OK)
        res = weft_resample_compile(plan, weft_resample_compile_params(.context = context),
                                    &compiled);
    if (res == WEFT_OK)
        res = weft_resample_source_create(
            weft_resample_source_params(.width = 3, .height = 2, .stride = 4, .channels = 3,
                                        .plane = {plane[0], plane[1], plane[2]}),
            &source);
    if (res == WEFT_OK)
        res = weft_resample_run(compiled,
                                weft_resample_run_params(.source = source, .stride = 10,
                                                         .plane = {out[0], out[1], out[2]}),
                                NULL);
    weft_resample_source_destroy(&source);
    weft_resample_compiled_destroy(&compiled);
    weft_resample_plan_destroy(&plan);
    return res;
}

static void resample_planes(void)
{
    static const float samples[3][8] = {
        {1, 2, 3, -9, 4, 5, 6, -9}, {7, 7, 7, -9, 7, 7, 7, -9}, {0, 1, 0, -9, 1, 0, 1, -9}};
    float pixels[3][60];
    weft_context *context = NULL;
    const struct weft_context_params any = {.kind = WEFT_CONTEXT_AUTO, .log = &logger};
    must(weft_context_create(&any, &context), "weft_context_create");
    must(enlarge(context, (const float *const[]){samples[0], samples[1], samples[2]},
                 (float *const[]){pixels[0], pixels[1], pixels[2]}),
         "enlarge");
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < 6; i++) { // every third pixel lies on a sample
            const float pixel = pixels[c][(3 * (i / 3) + 1) * 10 + 3 * (i % 3) + 1];
            if (!(fabsf(pixel - samples[c][i / 3 * 4 + i % 3]) <= 1e-5f))
                must(WEFT_ERR_GL, "the pixels' values");
        }
    puts("three planes resampled");
    weft_context_destroy(&context);
}

int main(int argc, char **argv)
{
    printf("weft %s, the first of its kernels: %s\n", weft_version(), weft_kernel_list[0]->name);
    plan_passes();
    write_images();
    cut_memory();
    if (argc > 1)
        cut_file(argv[1]);
    resample_planes();
    return 0;
}
