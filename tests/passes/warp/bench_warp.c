// SPDX-License-Identifier: BSD-3-Clause
// bench_warp IMAGE.exr...: the test of Thevenaz, Blu and Unser (2000, "Interpolation revisited")
// for each kernel and image: 24 turns by 15 degrees, and the ratio of signal to error in dB, of all
// channels within the disc that no turn leaves, 0.35 times the smaller side. The first turn is
// verified against the double reference for a second, and its share of the bound is told. Images
// with samples that are not finite are named and left out.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "weft.h"

static const char *const kernels[] = {
    "nearest",        "linear",    "catmull-rom",    "mitchell",  "lanczos:2",
    "lanczos:2+unit", "lanczos:3", "lanczos:3+unit", "lanczos:4", "bspline3",
    "bspline3i",      "omomsi",    "bspline5i",      "bspline7i", NULL};

struct turn {
    weft_warp_plan *plan;
    weft_warp_compiled *compiled;
    float *plane[2][WEFT_RESAMPLE_MAX_CHANNELS]; // now, and next
    int width, height, channels;
    double share, seconds;
};

static void complain(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    if (level == WEFT_LOG_ERROR)
        fprintf(stderr, "bench_warp: %s\n", message);
}
static const struct weft_log log_errors = {complain, NULL};

static bool turn_once(struct turn *t, bool verify)
{
    const double start = weft_now_seconds();
    const struct weft_warp_info *info = weft_warp_plan_get_info(t->plan);
    struct weft_resample_source_params from =
        *weft_resample_source_params(.kernel = info->kernel, .width = t->width, .height = t->height,
                                     .channels = t->channels, .log = &log_errors);
    struct weft_warp_run_params run = {.log = &log_errors};
    struct weft_resample_verify_params check = {.how = {.max_seconds = 1.0}, .log = &log_errors};
    weft_resample_source *source = NULL;
    struct weft_verify_report error;
    for (int c = 0; c < t->channels; c++) {
        from.plane[c] = t->plane[0][c];
        check.plane[c] = run.plane[c] = t->plane[1][c];
    }
    bool good = weft_resample_source_create(&from, &source) == WEFT_OK;
    check.source = run.source = source;
    good = good && weft_warp_run(t->compiled, &run, NULL) == WEFT_OK;
    t->seconds += weft_now_seconds() - start;
    if (good && verify) {
        good = weft_warp_verify(t->plan, &check, &error) == WEFT_OK && error.maximum <= error.bound;
        t->share = error.maximum / error.bound;
    }
    weft_resample_source_destroy(&source);
    for (int c = 0; c < t->channels; c++) {
        float *const swap = t->plane[0][c];
        t->plane[0][c] = t->plane[1][c];
        t->plane[1][c] = swap;
    }
    return good;
}

static double ratio(const struct turn *t, const struct weft_image *image)
{
    const double radius = 0.35 * (t->width < t->height ? t->width : t->height);
    double signal = 0.0, error = 0.0;
    for (int c = 0; c < t->channels; c++)
        for (int y = 0; y < t->height; y++)
            for (int x = 0; x < t->width; x++) {
                const double was = (double)image->channels[c].plane[y * t->width + x];
                const double off = (double)t->plane[0][c][y * t->width + x] - was;
                if (hypot(x + 0.5 - 0.5 * t->width, y + 0.5 - 0.5 * t->height) > radius)
                    continue;
                signal += was * was;
                error += off * off;
            }
    return 10.0 * log10(signal / error);
}

static bool run_kernel(const char *name, const struct weft_image *image)
{
    struct weft_kernel kernel;
    struct turn t = {.width = image->width,
                     .height = image->height,
                     .channels = image->channel_count > 4 ? 4 : (int)image->channel_count};
    const double centre[2] = {0.5 * t.width, 0.5 * t.height};
    struct weft_warp_params params =
        *weft_warp_params(.size = {t.width, t.height}, .engine = WEFT_ENGINE_CPU,
                          .log = &log_errors);
    bool good = weft_kernel_parse(&log_errors, name, &kernel) == WEFT_OK;
    params.kernel = kernel;
    weft_warp_matrix_rotate(15.0, centre, params.map.matrix);
    good = good && weft_warp_plan_create(&params, &t.plan) == WEFT_OK &&
           weft_warp_compile(t.plan, weft_resample_compile_params(), &t.compiled) == WEFT_OK;
    const size_t bytes = (size_t)t.width * (size_t)t.height * sizeof(float);
    for (int c = 0; good && c < t.channels; c++) {
        t.plane[0][c] = malloc(bytes);
        t.plane[1][c] = malloc(bytes);
        good = t.plane[0][c] && t.plane[1][c];
        if (good)
            memcpy(t.plane[0][c], image->channels[c].plane, bytes);
    }
    for (int i = 0; good && i < 24; i++)
        good = turn_once(&t, i == 0);
    if (good)
        printf("  %-14s %8.2f dB, %3.0f%% of the bound, %7.2f Mpixel/s\n", name, ratio(&t, image),
               100.0 * t.share, 24e-6 * t.width * t.height / t.seconds);
    for (int c = 0; c < t.channels; c++) {
        free(t.plane[0][c]);
        free(t.plane[1][c]);
    }
    weft_warp_compiled_destroy(&t.compiled);
    weft_warp_plan_destroy(&t.plan);
    return good;
}

static bool is_finite(const struct weft_image *image)
{
    for (size_t c = 0; c < image->channel_count; c++)
        for (int i = 0; i < image->width * image->height; i++)
            if (!isfinite(image->channels[c].plane[i]))
                return false;
    return true;
}

int main(int argc, char **argv)
{
    bool good = argc > 1;
    for (int i = 1; good && i < argc; i++) {
        struct weft_image image;
        good =
            weft_image_load(&(struct weft_image_load_params){.path = argv[i], .log = &log_errors},
                            &image) == WEFT_OK;
        if (!good)
            break;
        const bool finite = is_finite(&image);
        printf("%s, %d x %d, %zu channels%s\n", argv[i], image.width, image.height,
               image.channel_count, finite ? "" : ": left out, not all finite");
        for (int k = 0; good && finite && kernels[k]; k++)
            good = run_kernel(kernels[k], &image);
        weft_image_clear(&image);
    }
    return good ? 0 : 1;
}
