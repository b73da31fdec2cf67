// SPDX-License-Identifier: BSD-3-Clause
// How far averages of frames are from the exact one.
//   mean_error RESULT.exr... -- FRAME...
// Frames are EXR or 8-bit PNG files of one size with channels R, G, B and perhaps A; of PNG files
// codes / 255 count, as they are. A name may stand there many times. Halves and codes are multiples
// of one unit, and so few of them are added that sums in double precision are exact, and the mean
// is rounded once. Prints for every result the largest and the mean absolute error.
// Exit code: 0, 1 (a file cannot be read, or is of another size), 2 (usage).
#include <math.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "weft.h"

static const char names[] = "RGBA";
enum { CHANNELS = 4 };

struct mean {
    int width, height;
    double *sums[CHANNELS];
    int count;
};

static void say(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    if (level <= WEFT_LOG_WARNING)
        fprintf(stderr, "%s\n", message);
}

static bool fit(struct mean *m, const char *path, int width, int height)
{
    if (!m->width) {
        m->width = width;
        m->height = height;
        for (int c = 0; c < CHANNELS; c++)
            m->sums[c] = calloc((size_t)width * (size_t)height, sizeof *m->sums[c]);
    }
    if (m->width != width || m->height != height)
        fprintf(stderr, "%s: %d x %d pixels, not %d x %d\n", path, width, height, m->width,
                m->height);
    return m->width == width && m->height == height && m->sums[0] && m->sums[1] && m->sums[2] &&
           m->sums[3];
}

static const float *plane_of(const struct weft_image *image, char name)
{
    for (size_t c = 0; c < (size_t)image->channel_count; c++)
        if (image->channels[c].name[0] == name && !image->channels[c].name[1])
            return image->channels[c].plane;
    return NULL;
}

static bool load_exr(const char *path, struct weft_image *image)
{
    static const struct weft_log log = {.write = say};
    return weft_image_load(&(struct weft_image_load_params){.path = path, .log = &log}, image) ==
           WEFT_OK;
}

static bool add_exr(struct mean *m, const char *path, int times)
{
    struct weft_image image;
    if (!load_exr(path, &image))
        return false;
    const bool good = fit(m, path, image.width, image.height);
    for (int c = 0; c < CHANNELS && good; c++) {
        const float *plane = plane_of(&image, names[c]);
        for (size_t i = 0; plane && i < (size_t)m->width * (size_t)m->height; i++)
            m->sums[c][i] += (double)times * (double)plane[i];
    }
    weft_image_clear(&image);
    return good;
}

// Codes are added up as such, and divided by 255 at the end: see `unit`.
static bool add_png(struct mean *m, const char *path, int times)
{
    png_image png = {.version = PNG_IMAGE_VERSION};
    if (!png_image_begin_read_from_file(&png, path)) {
        fprintf(stderr, "%s: %s\n", path, png.message);
        return false;
    }
    png.format = PNG_FORMAT_RGBA;
    uint8_t *codes = malloc(PNG_IMAGE_SIZE(png));
    bool good = codes && png_image_finish_read(&png, NULL, codes, 0, NULL);
    good = good && fit(m, path, (int)png.width, (int)png.height);
    for (int c = 0; c < CHANNELS && good; c++)
        for (size_t i = 0; i < (size_t)m->width * (size_t)m->height; i++)
            m->sums[c][i] += (double)times * codes[CHANNELS * i + (size_t)c];
    free(codes);
    png_image_free(&png);
    return good;
}

static bool is_png(const char *path)
{
    const size_t length = strlen(path);
    return length > 4 && strcmp(path + length - 4, ".png") == 0;
}

// Each name once, as often as it stands there.
static bool add_all(struct mean *m, char **paths, int count)
{
    bool good = true;
    for (int i = 0; i < count && good; i++) {
        int times = 0;
        bool first = true;
        for (int j = 0; j < count; j++) {
            times += strcmp(paths[i], paths[j]) == 0;
            first = first && (j >= i || strcmp(paths[i], paths[j]) != 0);
        }
        if (first)
            good = is_png(paths[i]) ? add_png(m, paths[i], times) : add_exr(m, paths[i], times);
    }
    m->count = count;
    return good;
}

static bool compare(const struct mean *m, const char *path, double unit)
{
    struct weft_image image;
    if (!load_exr(path, &image))
        return false;
    const size_t pixels = (size_t)m->width * (size_t)m->height;
    double largest = 0.0, sum = 0.0;
    size_t values = 0;
    const bool good = image.width == m->width && image.height == m->height;
    for (int c = 0; c < CHANNELS && good; c++) {
        const float *plane = plane_of(&image, names[c]);
        for (size_t i = 0; plane && i < pixels; i++, values++) {
            const double error = fabs((double)plane[i] - m->sums[c][i] / (unit * m->count));
            largest = error <= largest ? largest : error; // NAN stays
            sum += error;
        }
    }
    weft_image_clear(&image);
    if (!good || !values) {
        fprintf(stderr, "%s: other pixels or channels than the frames\n", path);
        return false;
    }
    printf("%s %.3g %.3g\n", path, largest, sum / (double)values);
    return true;
}

int main(int argc, char **argv)
{
    struct mean m = {0};
    int results = 0;
    while (results + 1 < argc && strcmp(argv[results + 1], "--") != 0)
        results++;
    if (results == 0 || results + 2 >= argc) {
        fprintf(stderr, "usage: mean_error RESULT.exr... -- FRAME...\n");
        return 2;
    }
    bool good = add_all(&m, argv + results + 2, argc - results - 2);
    const double unit = is_png(argv[results + 2]) ? 255.0 : 1.0;
    for (int r = 1; r <= results && good; r++)
        good = compare(&m, argv[r], unit);
    for (int c = 0; c < CHANNELS; c++)
        free(m.sums[c]);
    return good ? 0 : 1;
}
