// SPDX-License-Identifier: BSD-3-Clause
// bench_zimg [SIZE [RUNS [FACTOR]]]: images scaled in memory by weft's CPU engine and by zimg, in
// turns, on one thread: four planes of floats, up 4 times and down 3.7 times. Prints medians of
// core-seconds (planning left out on both sides), their ratio, and how far the pixels are apart
// away from the edges.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <zimg.h>

#include "weft.h"

enum { CHANNELS = 4, MOST_RUNS = 99 };

struct work {
    const char *kernel; // weft's
    zimg_resample_filter_e filter;
    double a, b; // its parameters
    int from, to;
    float *samples[CHANNELS], *pixels[CHANNELS], *peers[CHANNELS];
    weft_resample_plan *plan;
    weft_resample_compiled *compiled;
    weft_resample_source *source;
    zimg_filter_graph *graph;
    void *scratch;
};

static double cpu_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void check(bool good, const char *what)
{
    if (good)
        return;
    fprintf(stderr, "bench_zimg: %s failed\n", what);
    exit(1);
}

static float *make_plane(int size, int c)
{
    float *plane = aligned_alloc(64, (size_t)size * (size_t)size * sizeof *plane + 64);
    check(plane, "memory");
    for (int i = 0; i < size * size; i++)
        plane[i] = (float)(0.5 + 0.4 * sin(0.01 * (c + 1) * (i % size)) * cos(0.013 * (i / size)) +
                           0.1 * ((uint32_t)(i + 1) * 2654435761u >> 9 & 1023) / 1023.0);
    return plane;
}

// ---- weft ---------------------------------------------------------------------------------------

static void prepare_weft(struct work *w)
{
    struct weft_kernel kernel;
    check(weft_kernel_parse(NULL, w->kernel, &kernel) == WEFT_OK, "kernel");
    check(weft_resample_plan_create(
              weft_resample_params(.kernel = kernel, .size = {w->from, w->from}, .width = w->to,
                                   .height = w->to, .engine = WEFT_ENGINE_CPU),
              &w->plan) == WEFT_OK,
          "plan");
    check(weft_resample_compile(w->plan, weft_resample_compile_params(.cpu = {.threads = 1}),
                                &w->compiled) == WEFT_OK,
          "compile");
    struct weft_resample_source_params params =
        *weft_resample_source_params(.kernel = kernel, .width = w->from, .height = w->from,
                                     .channels = CHANNELS, .threads = 1);
    memcpy(params.plane, w->samples, sizeof params.plane);
    check(weft_resample_source_create(&params, &w->source) == WEFT_OK, "source");
}

static void run_weft(struct work *w)
{
    struct weft_resample_run_params params = {.source = w->source};
    memcpy(params.plane, w->pixels, sizeof params.plane);
    check(weft_resample_run(w->compiled, &params, NULL) == WEFT_OK, "run");
}

// ---- zimg ---------------------------------------------------------------------------------------

static zimg_image_format format_of(int size)
{
    zimg_image_format format;
    zimg_image_format_default(&format, ZIMG_API_VERSION);
    format.width = format.height = (unsigned)size;
    format.pixel_type = ZIMG_PIXEL_FLOAT;
    format.color_family = ZIMG_COLOR_GREY;
    return format;
}

static void prepare_zimg(struct work *w)
{
    const zimg_image_format from = format_of(w->from), to = format_of(w->to);
    zimg_graph_builder_params params;
    size_t bytes = 0;
    zimg_graph_builder_params_default(&params, ZIMG_API_VERSION);
    params.resample_filter = w->filter;
    params.filter_param_a = w->a;
    params.filter_param_b = w->b;
    params.cpu_type = ZIMG_CPU_AUTO_64B;
    w->graph = zimg_filter_graph_build(&from, &to, &params);
    check(w->graph && !zimg_filter_graph_get_tmp_size(w->graph, &bytes), "zimg's graph");
    w->scratch = aligned_alloc(64, (bytes + 63) / 64 * 64);
    check(w->scratch, "memory");
}

static void run_zimg(struct work *w)
{
    for (int c = 0; c < CHANNELS; c++) {
        zimg_image_buffer_const from = {ZIMG_API_VERSION, {{0}}};
        zimg_image_buffer to = {ZIMG_API_VERSION, {{0}}};
        from.plane[0].data = w->samples[c];
        from.plane[0].stride = w->from * (ptrdiff_t)sizeof(float);
        from.plane[0].mask = to.plane[0].mask = ZIMG_BUFFER_MAX;
        to.plane[0].data = w->peers[c];
        to.plane[0].stride = (w->to + 15) / 16 * 16 * (ptrdiff_t)sizeof(float);
        check(!zimg_filter_graph_process(w->graph, &from, &to, w->scratch, NULL, NULL, NULL, NULL),
              "zimg");
    }
}

// ---- turns --------------------------------------------------------------------------------------

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *seconds, int runs)
{
    qsort(seconds, (size_t)runs, sizeof *seconds, compare);
    return seconds[runs / 2];
}

static double largest_difference(const struct work *w)
{
    const int pitch = (w->to + 15) / 16 * 16;
    const int edge = w->to / 16 + 1; // where zimg's boundary is another
    double largest = 0.0;
    for (int y = edge; y < w->to - edge; y++)
        for (int x = edge; x < w->to - edge; x++)
            largest = fmax(largest, fabs((double)w->pixels[0][y * w->to + x] -
                                         (double)w->peers[0][y * pitch + x]));
    return largest;
}

static void bench(struct work *w, int runs)
{
    double seconds[2][MOST_RUNS];
    const size_t bytes = (size_t)(w->to + 16) * (size_t)w->to * sizeof(float);
    for (int c = 0; c < CHANNELS; c++) {
        w->samples[c] = make_plane(w->from, c);
        w->pixels[c] = aligned_alloc(64, (bytes + 63) / 64 * 64);
        w->peers[c] = aligned_alloc(64, (bytes + 63) / 64 * 64);
        check(w->pixels[c] && w->peers[c], "memory");
    }
    const double start = cpu_seconds();
    prepare_weft(w);
    const double planned = cpu_seconds();
    prepare_zimg(w);
    const double built = cpu_seconds();
    for (int i = -1; i < runs; i++) { // the first warms up
        const double at = cpu_seconds();
        run_weft(w);
        const double between = cpu_seconds();
        run_zimg(w);
        const double end = cpu_seconds();
        if (i < 0)
            continue;
        seconds[0][i] = between - at;
        seconds[1][i] = end - between;
    }
    const double own = median(seconds[0], runs), peers = median(seconds[1], runs);
    printf("%-12s %5d -> %5d  weft %.4f s (plan, source %.4f)  zimg %.4f s (graph %.4f)  ratio "
           "%.2f  largest difference %.2g\n",
           w->kernel, w->from, w->to, own, planned - start, peers, built - planned, own / peers,
           largest_difference(w));
    for (int c = 0; c < CHANNELS; c++) {
        free(w->samples[c]);
        free(w->pixels[c]);
        free(w->peers[c]);
    }
    weft_resample_source_destroy(&w->source);
    weft_resample_compiled_destroy(&w->compiled);
    weft_resample_plan_destroy(&w->plan);
    zimg_filter_graph_free(w->graph);
    free(w->scratch);
}

int main(int argc, char **argv)
{
    const int size = argc > 1 ? atoi(argv[1]) : 2048, runs = argc > 2 ? atoi(argv[2]) : 5;
    check(size >= 16 && size <= 8192 && runs >= 1 && runs <= MOST_RUNS, "SIZE and RUNS");
    const double factors[] = {argc > 3 ? atof(argv[3]) : 4.0, 1.0 / 3.7};
    for (int f = 0; f < (argc > 3 ? 1 : 2); f++) {
        struct work works[] = {
            {.kernel = "lanczos:3+unit", .filter = ZIMG_RESIZE_LANCZOS, .a = 3.0, .b = NAN},
            {.kernel = "catmull-rom", .filter = ZIMG_RESIZE_BICUBIC, .a = 0.0, .b = 0.5},
        };
        for (int k = 0; k < 2; k++) {
            works[k].from = size;
            works[k].to = (int)(size * factors[f] + 0.5);
            bench(&works[k], runs);
        }
    }
    return 0;
}
