// SPDX-License-Identifier: BSD-3-Clause
// What kernels make of the same 40^3 samples of Marschner and Lobb's signal ("An Evaluation of
// Reconstruction Filters for Volume Rendering", Visualization 1994): the surface where the
// reconstructed signal is 0.5, seen from the front and above.
//   figure_kernels [--size WxH] OUT.png
// OUT.png has a cell of W x H (default 392x290) for each kernel and the last one for the signal
// itself, three in a row. Surfaces are shaded by the gradient that the kernel itself has; nearest,
// which has none, by the faces of its voxels. Prints `label|RMS error of values` for each cell,
// over random points at least 8 voxels from the faces. Exit code: 0, 1, 2 (usage).
#include <math.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "weft.h"

enum { SAMPLES = 40, COLUMNS = 3, GAP = 4, OVER = 2, STEPS = 40, HALVINGS = 14, TRIALS = 200000 };

static const char *const kernels[] = {"nearest",     "linear",    "bspline",
                                      "catmull-rom", "bspline3i", NULL}; // NULL: the signal
enum { CELLS = sizeof kernels / sizeof *kernels };

#define LEVEL 0.5
#define HIGH 0.2 // the surface lies between -0.16 and 0.16
#define HALF 0.64
#define ELEVATION 0.80
#define WRONG 0.1

// A source of values: the signal, or a volume of its samples seen through a kernel.
struct source {
    const struct weft_signal_info *signal;
    weft_points *points; // NULL: the signal itself
    bool smooth;         // has a gradient
};

// A ray for each sample of a cell, along +s: position start + s * down. See trace.
struct rays {
    size_t count;
    double (*position)[3];
    float *value;               // [4][count]
    double *x, *y, *low, *high; // x, y at height 0; heights
    bool *hit;
};

static void say(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    if (level <= WEFT_LOG_WARNING)
        fprintf(stderr, "%s\n", message);
}
static const struct weft_log log_to_stderr = {.write = say};

// ---- values -------------------------------------------------------------------------------------

static enum weft_result source_create(const char *name, weft_volume *volume, struct source *s)
{
    static const struct weft_derivative orders[] = {{{0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}};
    *s = (struct source){.signal = weft_signal_find("marschner-lobb"), .smooth = true};
    if (!name)
        return WEFT_OK;
    struct weft_kernel kernel;
    enum weft_result res = weft_kernel_parse(&log_to_stderr, name, &kernel);
    s->smooth = strcmp(name, "nearest") != 0;
    if (res == WEFT_OK)
        res = weft_points_create(
            weft_points_params(.volume = volume, .kernel = kernel, .derivative = orders,
                               .derivative_count = s->smooth ? 4 : 1, .log = &log_to_stderr),
            &s->points);
    return res;
}

// Values at positions of [-1, 1]^3, and derivatives where the source has them: out[4][count].
static enum weft_result evaluate(const struct source *s, size_t count, const double (*p)[3],
                                 float *out)
{
    if (s->points)
        return weft_points_run(
            s->points, weft_points_run_params(.count = count, .position = p, .out = out), NULL);
    for (size_t i = 0; i < count; i++) {
        double gradient[3];
        out[i] = (float)s->signal->value(p[i]);
        s->signal->gradient(p[i], gradient);
        for (int axis = 0; axis < 3; axis++)
            out[(size_t)(axis + 1) * count + i] = (float)gradient[axis];
    }
    return WEFT_OK;
}

static enum weft_result make_volume(weft_volume **out)
{
    const struct weft_signal_info *signal = weft_signal_find("marschner-lobb");
    static float data[SAMPLES * SAMPLES * SAMPLES];
    for (int i = 0; i < SAMPLES * SAMPLES * SAMPLES; i++) {
        const int at[3] = {i % SAMPLES, i / SAMPLES % SAMPLES, i / SAMPLES / SAMPLES};
        double p[3];
        for (int axis = 0; axis < 3; axis++)
            p[axis] = weft_signal_coordinate(at[axis], SAMPLES);
        data[i] = (float)signal->value(p);
    }
    const double step = 2.0 / SAMPLES, first = weft_signal_coordinate(0, SAMPLES);
    return weft_volume_create(weft_volume_params(.size = {SAMPLES, SAMPLES, SAMPLES}, .data = data,
                                                 .log = &log_to_stderr,
                                                 .index_to_world = {{step, 0, 0, first},
                                                                    {0, step, 0, first},
                                                                    {0, 0, step, first}}),
                              out);
}

// The RMS error of values far from the faces.
static enum weft_result measure(const struct source *s, struct rays *r, double *rms)
{
    uint64_t state = 1;
    double sum = 0.0;
    const size_t count = r->count < TRIALS ? r->count : TRIALS;
    for (size_t i = 0; i < count; i++)
        for (int axis = 0; axis < 3; axis++) {
            state = state * 6364136223846793005u + 1442695040888963407u;
            r->position[i][axis] = 1.2 * ((double)(state >> 11) * 0x1p-53) - 0.6;
        }
    const enum weft_result res = evaluate(s, count, (const double(*)[3])r->position, r->value);
    for (size_t i = 0; i < count; i++) {
        const double error = r->value[i] - s->signal->value(r->position[i]);
        sum += error * error;
    }
    *rms = sqrt(sum / (double)count);
    return res;
}

// ---- rays ---------------------------------------------------------------------------------------

static bool rays_create(struct rays *r, size_t count)
{
    *r = (struct rays){.count = count};
    r->position = calloc(count, sizeof *r->position);
    r->value = calloc(count, 4 * sizeof *r->value);
    r->x = calloc(count, sizeof *r->x);
    r->y = calloc(count, sizeof *r->y);
    r->low = calloc(count, sizeof *r->low);
    r->high = calloc(count, sizeof *r->high);
    r->hit = calloc(count, sizeof *r->hit);
    return r->position && r->value && r->x && r->y && r->low && r->high && r->hit;
}

static void rays_destroy(struct rays *r)
{
    free(r->position);
    free(r->value);
    free(r->x);
    free(r->y);
    free(r->low);
    free(r->high);
    free(r->hit);
}

// Rays are parallel, x to the right and y away from the eye. Sets where ray i enters the block, at
// r->high, and leaves it, at r->low; returns its y at height 0.
static double enter(struct rays *r, int width, int height, size_t i, double *x)
{
    const double across = ((double)(i % (size_t)width) + 0.5) / width * 2.0 - 1.0;
    const double down = ((double)(i / (size_t)width) + 0.5) / height * 2.0 - 1.0;
    const double slope = tan(ELEVATION); // heights that a ray falls by along y
    const double y = -(HALF + HIGH / slope) * down;
    *x = HALF * across;
    r->high[i] = fmin(HIGH, (y + HALF) * slope);
    r->low[i] = fmax(-HIGH, (y - HALF) * slope);
    return y;
}

static enum weft_result at_heights(const struct source *s, struct rays *r, const double *z)
{
    for (size_t i = 0; i < r->count; i++) {
        r->position[i][0] = r->x[i];
        r->position[i][1] = r->y[i] - z[i] / tan(ELEVATION);
        r->position[i][2] = z[i];
    }
    return evaluate(s, r->count, (const double(*)[3])r->position, r->value);
}

// Finds where rays first reach the level: r->low at or beyond it, r->high before it. A ray that
// meets it as it enters has both there.
static enum weft_result trace(const struct source *s, struct rays *r, int width, int height)
{
    enum weft_result res = WEFT_OK;
    double *z = calloc(r->count, 3 * sizeof *z), *top = z + r->count, *bottom = top + r->count;
    if (!z)
        return WEFT_ERR_MEMORY;
    for (size_t i = 0; i < r->count; i++) {
        r->y[i] = enter(r, width, height, i, &r->x[i]);
        top[i] = r->high[i];
        bottom[i] = r->low[i];
        r->hit[i] = false;
    }
    for (int step = 0; step <= STEPS && res == WEFT_OK; step++) {
        for (size_t i = 0; i < r->count; i++)
            z[i] = top[i] + (bottom[i] - top[i]) * step / STEPS;
        res = at_heights(s, r, z);
        for (size_t i = 0; i < r->count; i++)
            if (!r->hit[i]) {
                r->hit[i] = r->value[i] >= LEVEL;
                r->low[i] = z[i];
                if (!r->hit[i] || step == 0)
                    r->high[i] = z[i];
            }
    }
    for (int step = 0; step < HALVINGS && res == WEFT_OK; step++) {
        for (size_t i = 0; i < r->count; i++)
            z[i] = 0.5 * (r->low[i] + r->high[i]);
        res = at_heights(s, r, z);
        for (size_t i = 0; i < r->count; i++)
            *(r->value[i] >= LEVEL ? &r->low[i] : &r->high[i]) = z[i];
    }
    free(z);
    return res;
}

// The gradient of a source that has none: differences across a tenth of a voxel.
static enum weft_result differences(const struct source *s, struct rays *r)
{
    const double step = 0.05 * 2.0 / SAMPLES;
    for (int axis = 0; axis < 3; axis++) {
        float *out = r->value + (size_t)(axis + 1) * r->count;
        for (int side = -1; side <= 1; side += 2) {
            for (size_t i = 0; i < r->count; i++)
                r->position[i][axis] += side * step;
            const enum weft_result res =
                evaluate(s, r->count, (const double(*)[3])r->position, r->value);
            if (res != WEFT_OK)
                return res;
            for (size_t i = 0; i < r->count; i++) {
                out[i] = side < 0 ? -r->value[i] : out[i] + r->value[i];
                r->position[i][axis] -= side * step;
            }
        }
    }
    return WEFT_OK;
}

// ---- light --------------------------------------------------------------------------------------

// Linear light of a surface that rises along -gradient, seen from the front and above.
static void shade(const double normal[3], double error, double colour[3])
{
    static const double lamp[3] = {-0.62, -0.25, 0.74};
    static const double right[3] = {0.42, 0.66, 0.70}, wrong[3] = {0.80, 0.03, 0.01};
    const double share = fmin(error / WRONG, 1.0);
    const double eye[3] = {0.0, -cos(ELEVATION), sin(ELEVATION)};
    double half[3], length = 0.0, diffuse = 0.0, shine = 0.0;
    for (int i = 0; i < 3; i++) {
        half[i] = lamp[i] + eye[i];
        length += half[i] * half[i];
        diffuse += lamp[i] * normal[i];
    }
    for (int i = 0; i < 3; i++)
        shine += half[i] / sqrt(length) * normal[i];
    diffuse = fmax(diffuse, 0.0);
    shine = 0.2 * pow(fmax(shine, 0.0), 40.0);
    for (int i = 0; i < 3; i++)
        colour[i] = (right[i] + share * (wrong[i] - right[i])) * (0.10 + 0.90 * diffuse) + shine;
}

static void colour_of(const struct rays *r, size_t i, double colour[3])
{
    double normal[3], length = 0.0;
    if (!r->hit[i]) {
        colour[0] = colour[1] = colour[2] = 1.0;
        return;
    }
    for (int axis = 0; axis < 3; axis++) {
        normal[axis] = -(double)r->value[(size_t)(axis + 1) * r->count + i];
        length += normal[axis] * normal[axis];
    }
    if (r->position[i][1] < -HALF + 1e-3) { // the cut in front
        colour[0] = colour[1] = colour[2] = 0.10;
        return;
    }
    for (int axis = 0; axis < 3; axis++)
        normal[axis] /= length > 0.0 ? sqrt(length) : 1.0;
    shade(normal, fabs(LEVEL - weft_signal_find("marschner-lobb")->value(r->position[i])), colour);
}

// sRGB in steps of 4 codes: nobody sees them here, and the file is two thirds as large.
static uint8_t code_of(double light)
{
    light = fmin(light, 1.0);
    const double code =
        255.0 * (light <= 0.0031308 ? 12.92 * light : 1.055 * pow(light, 1.0 / 2.4) - 0.055);
    return (uint8_t)fmin(4.0 * round(code / 4.0), 255.0);
}

// Draws a cell at `pixels`, rows `stride` bytes apart.
static enum weft_result draw(const struct source *s, struct rays *r, int width, int height,
                             uint8_t *pixels, size_t stride)
{
    const int wide = width * OVER, high = height * OVER;
    enum weft_result res = trace(s, r, wide, high);
    if (res == WEFT_OK)
        res = at_heights(s, r, r->low);
    if (res == WEFT_OK && !s->smooth)
        res = differences(s, r);
    for (int y = 0; y < height && res == WEFT_OK; y++)
        for (int x = 0; x < width; x++) {
            double sum[3] = {0.0};
            for (int sample = 0; sample < OVER * OVER; sample++) {
                double colour[3];
                colour_of(r,
                          (size_t)(y * OVER + sample / OVER) * (size_t)wide +
                              (size_t)(x * OVER + sample % OVER),
                          colour);
                for (int c = 0; c < 3; c++)
                    sum[c] += colour[c] / (OVER * OVER);
            }
            for (int c = 0; c < 3; c++)
                pixels[(size_t)y * stride + (size_t)x * 3 + (size_t)c] = code_of(sum[c]);
        }
    return res;
}

// ---- the picture --------------------------------------------------------------------------------

static enum weft_result cell(int index, weft_volume *volume, struct rays *r, int width, int height,
                             uint8_t *pixels, size_t stride)
{
    struct source s;
    double rms = 0.0;
    enum weft_result res = source_create(kernels[index], volume, &s);
    if (res == WEFT_OK)
        res = draw(&s, r, width, height, pixels, stride);
    if (res == WEFT_OK)
        res = measure(&s, r, &rms);
    if (res == WEFT_OK)
        printf("%s|%.3f\n", kernels[index] ? kernels[index] : "the signal itself", rms);
    weft_points_destroy(&s.points);
    return res;
}

static bool save(const char *path, int width, int height, const uint8_t *pixels)
{
    png_image image = {.version = PNG_IMAGE_VERSION,
                       .width = (png_uint_32)width,
                       .height = (png_uint_32)height,
                       .format = PNG_FORMAT_RGB};
    if (png_image_write_to_file(&image, path, 0, pixels, 0, NULL))
        return true;
    fprintf(stderr, "figure_kernels: %s: %s\n", path, image.message);
    return false;
}

int main(int argc, char **argv)
{
    int width = 392, height = 290;
    char end;
    if (argc == 4 && strcmp(argv[1], "--size") == 0 &&
        (sscanf(argv[2], "%dx%d%c", &width, &height, &end) != 2 || width < 8 || height < 8 ||
         width > 4096 || height > 4096))
        argc = 0;
    if (argc != 2 && (argc != 4 || strcmp(argv[1], "--size") != 0)) {
        fprintf(stderr, "usage: figure_kernels [--size WxH] OUT.png\n");
        return 2;
    }
    const int rows = (CELLS + COLUMNS - 1) / COLUMNS;
    const int wide = COLUMNS * (width + GAP) - GAP, high = rows * (height + GAP) - GAP;
    uint8_t *pixels = malloc((size_t)wide * (size_t)high * 3);
    struct rays r;
    weft_volume *volume = NULL;
    enum weft_result res = WEFT_ERR_MEMORY;
    if (rays_create(&r, (size_t)width * (size_t)height * OVER * OVER) && pixels) {
        memset(pixels, 255, (size_t)wide * (size_t)high * 3);
        res = make_volume(&volume);
    }
    for (int i = 0; i < CELLS && res == WEFT_OK; i++)
        res = cell(i, volume, &r, width, height,
                   pixels + ((size_t)(i / COLUMNS * (height + GAP)) * (size_t)wide +
                             (size_t)(i % COLUMNS * (width + GAP))) *
                                3,
                   (size_t)wide * 3);
    if (res != WEFT_OK)
        fprintf(stderr, "figure_kernels: %s\n", weft_result_text(res));
    const bool saved = res == WEFT_OK && save(argv[argc - 1], wide, high, pixels);
    weft_volume_destroy(&volume);
    rays_destroy(&r);
    free(pixels);
    return !saved;
}
