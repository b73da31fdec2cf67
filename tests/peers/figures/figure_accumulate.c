// SPDX-License-Identifier: BSD-3-Clause
// What methods of accumulation do to frames: figure 3 of Lagae, Suykens, Dutre, "A Hardware
// Accelerated Alternative for the Accumulation Buffer" (report CW 369, 2003), with numbers.
//   figure_accumulate [--context auto|osmesa|egl] [OUT.png]
// Averages 32, 64, 128, 256 and 1,024 frames of 8 bits that are all the same, the RGB colour cube,
// and as many frames of noise, by the accumulation buffer (16 bits to nearest, 16 bits truncating
// as Mesa does, floats), by blending on 8 bits, and by trees on 8 bits. Prints errors in codes
// against the exact mean: the largest, the mean absolute, and the mean with its sign beside what
// the roundings of a tree make one expect. OUT.png has a row for each method and a column for each
// number of frames, of the cube: on the left the averages, on the right 16 times their errors on
// grey. Exit code: 0, 1, 2 (usage).
#include <math.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "passes/accumulate/buffer.h"
#include "tests/peers/cube.h"

enum { SIDE = 76, PIXELS = SIDE * SIDE, CHANNELS = 3, STEP = 4, GAP = 4, MAGNIFIED = 16 };

static const int counts[] = {32, 64, 128, 256, 1024};
enum { COUNTS = sizeof counts / sizeof *counts };

static const struct method {
    const char *label;
    bool mesa; // the buffer's own object, as the method `buffer` rounds to nearest
    struct weft_accumulator_params params;
} methods[] = {
    {"buffer, 16 bits", false, {.method = WEFT_ACCUMULATE_BUFFER, .bits = 16}},
    {"buffer, 16 bits, truncating", true, {0}},
    {"buffer, floats", false, {.method = WEFT_ACCUMULATE_BUFFER, .bits = 32}},
    {"blending, 8 bits", false, {.method = WEFT_ACCUMULATE_BLEND}},
    {"tree of 2", false, {.method = WEFT_ACCUMULATE_TREE, .branching = 2}},
    {"tree of 2, unbiased",
     false,
     {.method = WEFT_ACCUMULATE_TREE, .branching = 2, .rounding = WEFT_TREE_UNBIASED}},
    {"tree of 2, truncating",
     false,
     {.method = WEFT_ACCUMULATE_TREE, .branching = 2, .rounding = WEFT_TREE_TRUNCATE}},
    {"tree of 4", false, {.method = WEFT_ACCUMULATE_TREE, .branching = 4}},
};
enum { METHODS = sizeof methods / sizeof *methods };

// Codes of a frame, [y][x][STEP].
struct frames {
    uint8_t *cube;  // NULL: noise
    uint8_t *noise; // of the frame in hand
    double *sums;   // [PIXELS * CHANNELS]
    int count;
};

struct errors {
    double largest, absolute, mean, expected; // codes
};

static void say(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    if (level <= WEFT_LOG_WARNING)
        fprintf(stderr, "%s\n", message);
}
static const struct weft_log log_to_stderr = {.write = say};

// ---- frames -------------------------------------------------------------------------------------

static const uint8_t *frame_codes(struct frames *f, int index)
{
    if (f->cube)
        return f->cube;
    // Mixed twice, as frames of one generator after the other are not independent of each other.
    for (int i = 0; i < PIXELS * STEP; i++) {
        uint64_t state = ((uint64_t)index << 32 | (uint64_t)i) * 0x9e3779b97f4a7c15u;
        state = (state ^ state >> 30) * 0xbf58476d1ce4e5b9u;
        state = (state ^ state >> 27) * 0x94d049bb133111ebu;
        f->noise[i] = (uint8_t)(state >> 56);
    }
    return f->noise;
}

static void add_up(struct frames *f, int count)
{
    memset(f->sums, 0, PIXELS * CHANNELS * sizeof *f->sums);
    f->count = count;
    for (int k = 0; k < count; k++) {
        const uint8_t *codes = frame_codes(f, k);
        for (int i = 0; i < PIXELS * CHANNELS; i++)
            f->sums[i] += codes[i / CHANNELS * STEP + i % CHANNELS];
    }
}

static void get_planes(struct frames *f, int index, struct weft_plane planes[CHANNELS])
{
    const uint8_t *codes = frame_codes(f, index);
    for (int c = 0; c < CHANNELS; c++)
        planes[c] = (struct weft_plane){
            .values = codes + c, .type = WEFT_PLANE_UNORM8, .stride = SIDE * STEP, .step = STEP};
}

// ---- methods ------------------------------------------------------------------------------------

static enum weft_result run_mesa(struct frames *f, float *out)
{
    weft_accum_buffer *b = NULL;
    enum weft_result res = weft_accum_buffer_create(
        weft_accum_buffer_params(.width = SIDE, .height = SIDE, .channel_count = CHANNELS,
                                 .rounding = WEFT_ACCUM_TRUNCATE, .log = &log_to_stderr),
        &b);
    for (int k = 0; k < f->count && res == WEFT_OK; k++) {
        struct weft_plane planes[CHANNELS];
        get_planes(f, k, planes);
        res = weft_accum_buffer_accum(b, planes, 1.0 / f->count);
    }
    for (int c = 0; c < CHANNELS && res == WEFT_OK; c++)
        res = weft_accum_buffer_return(b, 1.0, c, out + c * PIXELS, 0);
    weft_accum_buffer_destroy(&b);
    return res;
}

static enum weft_result run_method(weft_context *context, const struct method *method,
                                   struct frames *f, float *out, double *expected)
{
    weft_accumulator *a = NULL;
    struct weft_accumulator_report report = {0};
    struct weft_accumulator_params params = method->params;
    params.width = params.height = SIDE;
    params.channel_count = CHANNELS;
    params.frame_count = f->count;
    params.context = context;
    params.log = &log_to_stderr;
    enum weft_result res = weft_accumulator_create(&params, &a);
    for (int k = 0; k < f->count && res == WEFT_OK; k++) {
        struct weft_plane planes[CHANNELS];
        get_planes(f, k, planes);
        res = weft_accumulator_add(a, &(struct weft_frame){.plane = planes}, 1.0);
    }
    for (int c = 0; c < CHANNELS && res == WEFT_OK; c++)
        res = weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, c, out + c * PIXELS, 0);
    if (res == WEFT_OK)
        weft_accumulator_get_report(a, &report);
    *expected = method->params.method == WEFT_ACCUMULATE_TREE ? 255.0 * report.bias : (double)NAN;
    weft_accumulator_destroy(&a);
    return res;
}

static double error_at(const struct frames *f, const float *out, int pixel, int channel)
{
    return 255.0 * (double)out[channel * PIXELS + pixel] -
           f->sums[pixel * CHANNELS + channel] / f->count;
}

static struct errors compare(const struct frames *f, const float *out)
{
    struct errors e = {0};
    for (int i = 0; i < PIXELS * CHANNELS; i++) {
        const double error = error_at(f, out, i / CHANNELS, i % CHANNELS);
        e.largest = fmax(e.largest, fabs(error));
        e.absolute += fabs(error) / (PIXELS * CHANNELS);
        e.mean += error / (PIXELS * CHANNELS);
    }
    return e;
}

// ---- picture ------------------------------------------------------------------------------------

enum panel { PANEL_CUBE, PANEL_CUBE_ERROR, PANEL_NOISE_ERROR, PANELS };
enum {
    PANEL = COUNTS * (SIDE + GAP) + 2 * GAP,
    WIDTH = PANELS * PANEL,
    HEIGHT = METHODS * (SIDE + GAP) + GAP,
};

static uint8_t to_code(double value)
{
    return (uint8_t)(value < 0.0 ? 0.0 : value > 255.0 ? 255.0 : rint(value));
}

static void put_cell(const struct frames *f, const float *out, int row, int column,
                     enum panel panel, uint8_t *image)
{
    const int y0 = GAP + row * (SIDE + GAP);
    const int x0 = GAP + (int)panel * PANEL + column * (SIDE + GAP);
    for (int p = 0; p < PIXELS; p++) {
        const size_t at = (size_t)(y0 + p / SIDE) * WIDTH + (size_t)(x0 + p % SIDE);
        for (int c = 0; c < CHANNELS; c++)
            image[at * 3 + (size_t)c] =
                to_code(panel == PANEL_CUBE ? 255.0 * (double)out[c * PIXELS + p]
                                            : 128.0 + MAGNIFIED * error_at(f, out, p, c));
    }
}

static bool write_image(const char *path, const uint8_t *image)
{
    png_image png = {
        .version = PNG_IMAGE_VERSION, .width = WIDTH, .height = HEIGHT, .format = PNG_FORMAT_RGB};
    if (png_image_write_to_file(&png, path, 0, image, 0, NULL))
        return true;
    fprintf(stderr, "%s: %s\n", path, png.message);
    return false;
}

// ---- all of it ----------------------------------------------------------------------------------

static bool measure(weft_context *context, struct frames *f, struct errors e[METHODS][COUNTS],
                    uint8_t *image)
{
    float *out = malloc(CHANNELS * PIXELS * sizeof *out);
    enum weft_result res = out ? WEFT_OK : WEFT_ERR_MEMORY;
    for (int n = 0; n < COUNTS && res == WEFT_OK; n++) {
        add_up(f, counts[n]);
        for (int m = 0; m < METHODS && res == WEFT_OK; m++) {
            double expected = (double)NAN;
            res = methods[m].mesa ? run_mesa(f, out)
                                  : run_method(context, &methods[m], f, out, &expected);
            if (res != WEFT_OK)
                break;
            e[m][n] = compare(f, out);
            e[m][n].expected = expected;
            if (f->cube)
                put_cell(f, out, m, n, PANEL_CUBE, image);
            put_cell(f, out, m, n, f->cube ? PANEL_CUBE_ERROR : PANEL_NOISE_ERROR, image);
        }
    }
    free(out);
    if (res != WEFT_OK)
        fprintf(stderr, "figure_accumulate: %s\n", weft_result_text(res));
    return res == WEFT_OK;
}

static void print_heads(const char *title)
{
    printf("\n%s\n\n| N |", title);
    for (int n = 0; n < COUNTS; n++)
        printf(" %d |", counts[n]);
    printf("\n|---|");
    for (int n = 0; n < COUNTS; n++)
        printf("---|");
    printf("\n");
}

static void print_cube(struct errors e[METHODS][COUNTS])
{
    print_heads("identical frames: largest, mean error in codes");
    for (int m = 0; m < METHODS; m++) {
        printf("| %s |", methods[m].label);
        for (int n = 0; n < COUNTS; n++)
            printf(" %.2g, %.2g |", e[m][n].largest, e[m][n].absolute);
        printf("\n");
    }
}

static void print_noise(struct errors e[METHODS][COUNTS])
{
    print_heads("noise: largest error, mean error with its sign (and what is expected), in codes");
    for (int m = 0; m < METHODS; m++) {
        printf("| %s |", methods[m].label);
        for (int n = 0; n < COUNTS; n++) {
            printf(" %.2g, %+.3f", e[m][n].largest, e[m][n].mean);
            if (!isnan(e[m][n].expected))
                printf(" (%+.3f)", e[m][n].expected);
            printf(" |");
        }
        printf("\n");
    }
}

static bool run(weft_context *context, const char *path)
{
    static struct errors of_cube[METHODS][COUNTS], of_noise[METHODS][COUNTS];
    struct cube cube = {0};
    struct frames f = {.noise = malloc(PIXELS * STEP),
                       .sums = malloc(PIXELS * CHANNELS * sizeof(double))};
    uint8_t *image = malloc((size_t)WIDTH * HEIGHT * 3);
    bool good = f.noise && f.sums && image && cube_create(context, false, &cube);
    if (good) {
        memset(image, 255, (size_t)WIDTH * HEIGHT * 3);
        uint8_t *codes = f.cube = cube_codes(&cube, SIDE, SIDE);
        good = codes && measure(context, &f, of_cube, image);
        f.cube = NULL;
        free(codes);
        good = good && measure(context, &f, of_noise, image);
    }
    if (good) {
        printf("%d x %d pixels, %s\n", SIDE, SIDE, weft_context_get_info(context)->renderer);
        print_cube(of_cube);
        print_noise(of_noise);
        good = !path || write_image(path, image);
    }
    free(f.noise);
    free(f.sums);
    free(image);
    return good;
}

int main(int argc, char **argv)
{
    enum weft_context_kind kind = WEFT_CONTEXT_AUTO;
    weft_context *context = NULL;
    const bool chosen = argc > 2 && strcmp(argv[1], "--context") == 0;
    const int rest = chosen ? 3 : 1;
    if (argc > rest + 1 || (argc > rest && argv[rest][0] == '-') ||
        (chosen && weft_context_kind_parse(&log_to_stderr, argv[2], &kind) != WEFT_OK)) {
        fprintf(stderr, "usage: figure_accumulate [--context auto|osmesa|egl] [OUT.png]\n");
        return 2;
    }
    bool good = weft_context_create(weft_context_params(.kind = kind, .log = &log_to_stderr),
                                    &context) == WEFT_OK;
    good = good && run(context, argc > rest ? argv[rest] : NULL);
    weft_context_destroy(&context);
    return good ? 0 : 1;
}
