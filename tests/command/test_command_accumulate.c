// SPDX-License-Identifier: BSD-3-Clause
// weft accumulate as its users see it: means against exact sums of the frames, what becomes of
// channels, types, windows and attributes, PNG against IEC 61966-2-1 in double precision, weights,
// names, reports. What is refused is in test_command_accumulate_errors.c.
#include <dirent.h>
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>
#include <jansson.h>
#include <png.h>

#include "tests/support/command.h"
#include "tests/support/json.h"
#include "weft.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))

enum { WIDTH = 19, HEIGHT = 13, PIXELS = WIDTH * HEIGHT, MAX_CHANNELS = 8 };

// ---- frames -------------------------------------------------------------------------------------

// Multiples of 2^-10 from 0 to 1: halves hold them, and doubles sums of any number of them.
static float value_of(int frame, int c, int i)
{
    uint32_t bits = (uint32_t)(frame * 7919 + c * 104729 + i * 31 + 1);
    bits = (bits ^ bits >> 15) * 2246822519u;
    bits = (bits ^ bits >> 13) * 3266489917u;
    return (float)((bits ^ bits >> 16) % 1025) / 1024.0f;
}

struct recipe {
    const char *const *names; // NULL-ended
    enum weft_pixel_type type;
    int x, y;
    double scale;
};

static void make_frame(const char *path, int frame, const struct recipe *recipe)
{
    static float planes[MAX_CHANNELS][PIXELS];
    static uint32_t integers[PIXELS];
    char owner[32];
    struct weft_image_channel channels[MAX_CHANNELS] = {0};
    snprintf(owner, sizeof owner, "frame %d", frame);
    struct weft_image_attribute attributes[] = {{"owner", "string", owner, strlen(owner)},
                                                {"weft.kernel", "string", "an earlier one", 14}};
    struct weft_image image = {.x = recipe->x,
                               .y = recipe->y,
                               .width = WIDTH,
                               .height = HEIGHT,
                               .display_min = {-1, -2},
                               .display_max = {30, 40},
                               .channels = channels,
                               .attribute_count = COUNT(attributes),
                               .attributes = attributes};
    for (int c = 0; recipe->names[c]; c++) {
        assert_true(c < MAX_CHANNELS);
        const bool integer = strcmp(recipe->names[c], "count") == 0;
        for (int i = 0; i < PIXELS; i++) {
            planes[c][i] = value_of(frame, c, i) * (float)(recipe->scale ? recipe->scale : 1.0);
            if (integer)
                integers[i] = 4294967295u - (uint32_t)(frame * PIXELS + i);
        }
        snprintf(channels[c].name, sizeof channels[c].name, "%s", recipe->names[c]);
        channels[c].type = integer ? WEFT_PIXEL_UINT : recipe->type;
        channels[c].plane = planes[c];
        channels[c].integers = integer ? integers : NULL;
        image.channel_count++;
    }
    assert_int_equal(weft_image_save(&image, weft_image_save_params(.path = path)), WEFT_OK);
}

static const char *const rgb[] = {"R", "G", "B", NULL};

// f_0001.exr to f_000N.exr
static void make_frames(int count)
{
    const struct recipe recipe = {.names = rgb};
    for (int f = 1; f <= count; f++) {
        char path[32];
        snprintf(path, sizeof path, "f_%04d.exr", f);
        make_frame(path, f, &recipe);
    }
}

static void load(const char *path, struct weft_image *out)
{
    assert_int_equal(weft_image_load(weft_image_load_params(.path = path), out), WEFT_OK);
}

static const struct weft_image_channel *channel_of(const struct weft_image *image, const char *name)
{
    for (size_t c = 0; c < image->channel_count; c++)
        if (strcmp(image->channels[c].name, name) == 0)
            return &image->channels[c];
    fail_msg("no channel %s", name);
    return NULL;
}

static const char *attribute(const struct weft_image *image, const char *name, char text[200])
{
    const struct weft_image_attribute *a = weft_image_find(image, name);
    if (!a)
        return NULL;
    weft_image_attribute_format(a, text, 200);
    return text;
}

// Sums of products of dyadic numbers are exact in long double; so that their quotient is rounded
// to a float twice, which this test's values do not show.
static void check_mean(const char *path, const double *weight, int count)
{
    struct weft_image image;
    int checked = 0;
    load(path, &image);
    for (int c = 0; rgb[c]; c++) {
        const struct weft_image_channel *channel = channel_of(&image, rgb[c]);
        assert_int_equal(channel->type, WEFT_PIXEL_FLOAT);
        for (int i = 0; i < PIXELS; i++) {
            long double sum = 0.0L, total = 0.0L;
            for (int f = 1; f <= count; f++) {
                sum += (long double)weight[f - 1] * (long double)value_of(f, c, i);
                total += (long double)weight[f - 1];
            }
            const float mean = (float)(sum / total);
            if (channel->plane[i] != mean)
                fail_msg("%s, %s, value %d: %.9g, not %.9g", path, rgb[c], i,
                         (double)channel->plane[i], (double)mean);
            checked++;
        }
    }
    assert_int_equal(checked, 3 * PIXELS);
    weft_image_clear(&image);
}

static const double ones[16] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};

// ---- means --------------------------------------------------------------------------------------

static void test_mean(void **state)
{
    (void)state;
    make_frames(7);
    command_succeeds("accumulate", "f_%04d.exr", "-o", "mean.exr");
    check_mean("mean.exr", ones, 7);
    command_succeeds("accumulate", "f_0001.exr", "-o", "one.exr");
    check_mean("one.exr", ones, 1);
}

// The same values in another order, by one thread and by several.
static void test_order_does_not_matter(void **state)
{
    (void)state;
    struct weft_image forward, backward;
    make_frames(5);
    command_succeeds("accumulate", "f_%04d.exr", "-o", "forward.exr", "--threads", "1");
    command_succeeds("accumulate", "f_0003.exr", "f_0005.exr", "f_0001.exr", "f_0004.exr",
                     "f_0002.exr", "-o", "backward.exr", "--threads", "3");
    load("forward.exr", &forward);
    load("backward.exr", &backward);
    for (size_t c = 0; c < forward.channel_count; c++)
        assert_memory_equal(forward.channels[c].plane, backward.channels[c].plane,
                            PIXELS * sizeof(float));
    weft_image_clear(&forward);
    weft_image_clear(&backward);
}

// ---- names --------------------------------------------------------------------------------------

static void run_with_list(const char *list, size_t size)
{
    command_write_file("list", list, size);
    struct command_result result;
    command_input("list");
    command_run(&result, "weft", "accumulate", "-", "-o", "mean.exr");
    assert_int_equal(result.code, 0);
    assert_string_equal(result.err, "");
    check_mean("mean.exr", ones, 3);
}

static void test_names(void **state)
{
    (void)state;
    static const char lines[] = "f_0001.exr\nf_0002.exr\r\n\nf_0003.exr";
    static const char zeros[] = "f_0001.exr\0f_0002.exr\0f_0003.exr\0";
    make_frames(3);
    run_with_list(lines, sizeof lines - 1);
    run_with_list(zeros, sizeof zeros - 1);
    command_succeeds("accumulate", "f_%04d.exr", "--frames", "1-3:2", "-o", "mean.exr");
    check_mean("mean.exr", (double[]){1, 0, 1}, 3);
    // Numbers of other widths are other names, and the highest counts.
    assert_int_equal(rename("f_0003.exr", "f_12345.exr"), 0);
    command_write_file("f_00004.exr", "x", 1);
    command_fails(3, "cannot be read: No such file or directory; nor can", "accumulate",
                  "f_%04d.exr", "-o", "mean.exr");
    // A percent sign that is a file's.
    assert_int_equal(rename("f_0001.exr", "g_%04d.exr"), 0);
    command_succeeds("accumulate", "g_%04d.exr", "-o", "mean.exr");
    check_mean("mean.exr", ones, 1);
}

static void test_repeats_count(void **state)
{
    (void)state;
    struct command_result result;
    make_frames(2);
    command_run(&result, "weft", "accumulate", "f_0001.exr", "f_0002.exr", "f_0001.exr", "-o",
                "mean.exr");
    assert_int_equal(result.code, 0);
    assert_string_equal(result.err, "weft: warning: f_0001.exr is given twice, and counts twice\n");
    check_mean("mean.exr", (double[]){2, 1}, 2);
}

static void test_skip_bad(void **state)
{
    (void)state;
    static const char *const two[] = {"R", "G", NULL};
    struct command_result result;
    make_frames(6);
    unlink("f_0003.exr");
    command_write_file("f_0004.exr", "no image", 8);
    make_frame("f_0005.exr", 5, &(struct recipe){.names = two});
    command_run(&result, "weft", "accumulate", "f_%04d.exr", "-o", "mean.exr", "--skip-bad",
                "--json");
    assert_int_equal(result.code, 3);
    assert_non_null(strstr(result.err, "f_0003.exr: No such file or directory"));
    assert_non_null(strstr(result.err, "f_0005.exr has no channel B, which f_0001.exr has"));
    assert_non_null(strstr(result.err, "weft: warning: 3 of 6 frames were left out\n"));
    check_mean("mean.exr", (double[]){1, 1, 0, 0, 0, 1}, 6);
    json_t *root = parse(result.out);
    assert_int_equal(number(root, "added"), 3);
    assert_int_equal(number(root, "skipped_count"), 3);
    const json_t *skipped = json_object_get(root, "skipped");
    assert_int_equal(json_array_size(skipped), 3);
    assert_int_equal(number(json_array_get(skipped, 1), "frame"), 3);
    json_decref(root);
}

// ---- weights ------------------------------------------------------------------------------------

// A frame of weight 0 need not even be a file.
static void test_weights(void **state)
{
    (void)state;
    static const char text[] = "# shutter\r\n1\r\n\r\n 0.5 # half\r\n0\r\n-0.25\r\n";
    static const double weight[] = {1, 0.5, 0, -0.25};
    make_frames(4);
    unlink("f_0003.exr");
    command_write_file("w.txt", text, sizeof text - 1);
    command_succeeds("accumulate", "f_%04d.exr", "-o", "mean.exr", "--weights", "w.txt");
    check_mean("mean.exr", weight, 4);
}

// Midpoints of four frames: t = 1/8, 3/8, 5/8, 7/8.
static void check_shape(const char *shape, const double weight[4])
{
    json_t *root = parse(command_succeeds("accumulate", "f_%04d.exr", "--json", "-o", "mean.exr",
                                          "--weights", shape));
    const json_t *values = json_object_get(json_object_get(root, "weights"), "values");
    assert_int_equal(json_array_size(values), 4);
    for (size_t i = 0; i < 4; i++) {
        const double got = json_number_value(json_array_get(values, i));
        if (!(fabs(got - weight[i]) <= 1e-15))
            fail_msg("%s: weight %zu is %.17g, not %.17g", shape, i, got, weight[i]);
    }
    json_decref(root);
}

static void test_shapes(void **state)
{
    (void)state;
    const double a = exp(-0.5 * 0.375 * 0.375 / 0.04), b = exp(-0.5 * 0.125 * 0.125 / 0.04);
    const double c = exp(-0.5 * 0.375 * 0.375 * 36), d = exp(-0.5 * 0.125 * 0.125 * 36);
    make_frames(4);
    check_shape("uniform", (double[]){1, 1, 1, 1});
    check_shape("tent", (double[]){0.25, 0.75, 0.75, 0.25});
    check_shape("gauss:0.2", (double[]){a, b, b, a});
    check_shape("gauss", (double[]){c, d, d, c});
    check_shape("linear", (double[]){0.25, 0.75, 0.75, 0.25});
    // Catmull-Rom at 1/2 and 3/2.
    check_shape("catmull-rom", (double[]){-0.0625, 0.5625, 0.5625, -0.0625});
}

// ---- channels -----------------------------------------------------------------------------------

static void test_types_and_windows(void **state)
{
    (void)state;
    struct weft_image image;
    char text[200];
    make_frame("a.exr", 1,
               &(struct recipe){.names = rgb, .type = WEFT_PIXEL_HALF, .x = 5, .y = -7});
    make_frame("b.exr", 2,
               &(struct recipe){.names = rgb, .type = WEFT_PIXEL_HALF, .x = 5, .y = -7});
    make_frame("c.exr", 3, &(struct recipe){.names = rgb, .x = 5, .y = -7});
    command_succeeds("accumulate", "a.exr", "b.exr", "-o", "half.exr");
    load("half.exr", &image);
    assert_int_equal(image.channels[0].type, WEFT_PIXEL_HALF);
    assert_int_equal(image.x, 5);
    assert_int_equal(image.y, -7);
    assert_int_equal(image.display_min[1], -2);
    assert_int_equal(image.display_max[1], 40);
    assert_string_equal(attribute(&image, "owner", text), "frame 1");
    assert_string_equal(attribute(&image, "weft.method", text), "exact");
    assert_string_equal(attribute(&image, "weft.frames", text), "2");
    assert_string_equal(attribute(&image, "weft.first_frame", text), "a.exr");
    assert_string_equal(attribute(&image, "weft.weights", text), "uniform");
    assert_null(attribute(&image, "weft.kernel", text));
    assert_true(strtod(attribute(&image, "weft.bound", text), NULL) > 0.0);
    weft_image_clear(&image);
    command_succeeds("accumulate", "a.exr", "b.exr", "c.exr", "-o", "mean.exr");
    check_mean("mean.exr", ones, 3);
    command_succeeds("accumulate", "c.exr", "c.exr", "-q", "-o", "half.exr", "--type", "half",
                     "--compression", "piz");
    load("half.exr", &image);
    assert_int_equal(image.channels[0].type, WEFT_PIXEL_HALF);
    assert_int_equal(image.compression, WEFT_IMAGE_PIZ);
    weft_image_clear(&image);
}

// What holds no colour is the first frame's, bit for bit.
static void test_data_is_copied(void **state)
{
    (void)state;
    static const char *const names[] = {"R", "Z", "count", "motion.u", "N.Z", "N.X", "N.Y", NULL};
    static const char *const line =
        "weft: info: copied from the first frame, not averaged: 3 channels that hold no colour, "
        "Z, count, motion.u (--average-all averages all)\n";
    struct command_result result;
    struct weft_image image;
    make_frame("a.exr", 1, &(struct recipe){.names = names});
    make_frame("b.exr", 2, &(struct recipe){.names = names});
    command_run(&result, "weft", "accumulate", "a.exr", "b.exr", "-o", "mean.exr");
    assert_int_equal(result.code, 0);
    assert_string_equal(result.err, line);
    load("mean.exr", &image);
    const struct weft_image_channel *count = channel_of(&image, "count");
    assert_int_equal(count->type, WEFT_PIXEL_UINT);
    for (int i = 0; i < PIXELS; i++) {
        assert_int_equal(count->integers[i], 4294967295u - (uint32_t)(PIXELS + i));
        assert_true(channel_of(&image, "Z")->plane[i] == value_of(1, 1, i));
        assert_true(channel_of(&image, "motion.u")->plane[i] == value_of(1, 3, i));
        assert_true(channel_of(&image, "N.Z")->plane[i] ==
                    0.5f * (value_of(1, 4, i) + value_of(2, 4, i)));
    }
    weft_image_clear(&image);
    assert_string_equal(
        command_succeeds("accumulate", "a.exr", "b.exr", "-o", "mean.exr", "--average-all"), "");
    load("mean.exr", &image);
    count = channel_of(&image, "count");
    assert_int_equal(count->type, WEFT_PIXEL_FLOAT);
    for (int i = 0; i < PIXELS; i++) {
        const double mean = 4294967295.0 - i - 1.5 * PIXELS;
        assert_true(count->plane[i] == (float)mean);
        assert_true(channel_of(&image, "Z")->plane[i] ==
                    0.5f * (value_of(1, 1, i) + value_of(2, 1, i)));
    }
    weft_image_clear(&image);
}

// ---- PNG ----------------------------------------------------------------------------------------

static uint16_t code_of(int frame, int c, int i, int largest)
{
    return (uint16_t)lrint((double)value_of(frame, c, i) * largest);
}

static void fail_png(png_structp png, png_const_charp message)
{
    (void)png;
    fail_msg("libpng: %s", message);
}

// Codes of 8 or 16 bits; gamma 0: none is said.
static void make_png(const char *path, int frame, int bits, int colour_type, double gamma)
{
    static png_byte rows[HEIGHT][WIDTH * 8];
    const int channels = colour_type == PNG_COLOR_TYPE_RGB_ALPHA ? 4
                         : colour_type == PNG_COLOR_TYPE_RGB     ? 3
                                                                 : 1;
    FILE *out = fopen(path, "wb");
    assert_non_null(out);
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, fail_png, NULL);
    png_infop info = png_create_info_struct(png);
    png_init_io(png, out);
    png_set_IHDR(png, info, WIDTH, HEIGHT, bits, colour_type, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (gamma > 0.0)
        png_set_gAMA(png, info, gamma);
    png_write_info(png, info);
    for (int y = 0; y < HEIGHT; y++) {
        png_byte *at = rows[y];
        for (int k = 0; k < WIDTH * channels; k++) {
            const uint16_t code =
                code_of(frame, k % channels, y * WIDTH + k / channels, bits == 8 ? 255 : 65535);
            if (bits == 16)
                *at++ = (png_byte)(code >> 8);
            *at++ = (png_byte)code;
        }
        png_write_row(png, rows[y]);
    }
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    assert_int_equal(fclose(out), 0);
}

static double srgb(double c)
{
    return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
}

// exponent 0: sRGB.
static double light_of(int frame, int c, int i, int largest, double exponent)
{
    const double code = (double)code_of(frame, c, i, largest) / largest;
    return exponent == 0.0 ? srgb(code) : pow(code, exponent);
}

// The mean of frames 1 to 3, of `names` up to alpha: within the roundings of each frame's light,
// of its product with alpha, and of the mean.
static void check_png_mean(const char *path, const char *const *names, int largest, double exponent)
{
    struct weft_image image;
    int checked = 0;
    load(path, &image);
    const bool alpha = names[1] && names[3];
    for (int c = 0; names[c]; c++) {
        const struct weft_image_channel *channel = channel_of(&image, names[c]);
        assert_int_equal(channel->type, WEFT_PIXEL_FLOAT);
        for (int i = 0; i < PIXELS; i++) {
            double mean = 0.0;
            for (int f = 1; f <= 3; f++) {
                const double a = (double)code_of(f, 3, i, largest) / largest;
                mean += c == 3 ? a / 3 : light_of(f, c, i, largest, exponent) * (alpha ? a : 1) / 3;
            }
            if (!(fabs((double)channel->plane[i] - mean) <= 3 * 0x1p-25))
                fail_msg("%s, %s, value %d: %.9g, not %.9g", path, names[c], i,
                         (double)channel->plane[i], mean);
            checked++;
        }
    }
    assert_int_equal(checked, (int)image.channel_count * PIXELS);
    weft_image_clear(&image);
}

static void make_pngs(int bits, int colour_type, double gamma)
{
    for (int f = 1; f <= 3; f++) {
        char path[32];
        snprintf(path, sizeof path, "p%d.png", f);
        make_png(path, f, bits, colour_type, gamma);
    }
}

static void test_png(void **state)
{
    (void)state;
    static const char *const rgba[] = {"R", "G", "B", "A", NULL}, *const grey[] = {"Y", NULL};
    make_pngs(8, PNG_COLOR_TYPE_RGB_ALPHA, 0.0);
    command_succeeds("accumulate", "p%d.png", "-o", "mean.exr");
    check_png_mean("mean.exr", rgba, 255, 0.0);
    command_succeeds("accumulate", "p%d.png", "-o", "mean.exr", "--transfer", "linear");
    check_png_mean("mean.exr", rgba, 255, 1.0);
    make_pngs(16, PNG_COLOR_TYPE_RGB_ALPHA, 0.0);
    command_succeeds("accumulate", "p%d.png", "-o", "mean.exr");
    check_png_mean("mean.exr", rgba, 65535, 0.0);
    make_pngs(8, PNG_COLOR_TYPE_RGB, 1 / 1.8);
    command_succeeds("accumulate", "p%d.png", "-o", "mean.exr");
    check_png_mean("mean.exr", rgb, 255, 1 / 0.55556); // the chunk has five decimals
    command_succeeds("accumulate", "p%d.png", "-o", "mean.exr", "--transfer", "gamma:2.5");
    check_png_mean("mean.exr", rgb, 255, 2.5);
    make_pngs(8, PNG_COLOR_TYPE_GRAY, 0.0);
    command_succeeds("accumulate", "p%d.png", "-o", "mean.exr");
    check_png_mean("mean.exr", grey, 255, 0.0);
    make_pngs(16, PNG_COLOR_TYPE_GRAY, 1.0);
    command_succeeds("accumulate", "p%d.png", "-o", "mean.exr");
    check_png_mean("mean.exr", grey, 65535, 1.0);
}

// Pixels of the picture are the mean's light in sRGB.
static void test_preview(void **state)
{
    (void)state;
    struct weft_image image;
    png_image png = {.version = PNG_IMAGE_VERSION};
    uint8_t pixels[3 * PIXELS];
    make_frames(3);
    assert_string_equal(command_succeeds("accumulate", "f_%04d.exr", "-o", "mean.exr", "--preview",
                                         "p.png", "--range", "0,0.5"),
                        "p.png: values from 0 to 0.5\n");
    load("mean.exr", &image);
    assert_true(png_image_begin_read_from_file(&png, "p.png"));
    png.format = PNG_FORMAT_RGB;
    assert_true(png_image_finish_read(&png, NULL, pixels, 0, NULL));
    for (int i = 0; i < 3 * PIXELS; i++) {
        const float light = channel_of(&image, rgb[i % 3])->plane[i / 3];
        assert_true(fabs(srgb(pixels[i] / 255.0) - fmin(2.0 * (double)light, 1.0)) <= 0.006);
    }
    weft_image_clear(&image);
    // A layer's colours, where there are no others; data do not count.
    static const char *const layers[] = {"crypto00.R", "crypto00.G", "crypto00.B", "left.R",
                                         "left.G",     "left.B",     NULL};
    make_frame("l.exr", 1, &(struct recipe){.names = layers});
    command_succeeds("accumulate", "l.exr", "-q", "--preview", "p.png");
    png = (png_image){.version = PNG_IMAGE_VERSION};
    assert_true(png_image_begin_read_from_file(&png, "p.png"));
    png.format = PNG_FORMAT_RGB;
    assert_true(png_image_finish_read(&png, NULL, pixels, 0, NULL));
    for (int i = 0; i < 3 * PIXELS; i++)
        assert_true(fabs(srgb(pixels[i] / 255.0) - (double)value_of(1, 3 + i % 3, i / 3)) <= 0.006);
    // One channel has a colour map, and grey as default.
    command_succeeds("accumulate", "f_%04d.exr", "--preview", "p.png", "--colour-map", "viridis");
}

// ---- statistics ---------------------------------------------------------------------------------

static void test_standard_error(void **state)
{
    (void)state;
    struct weft_image image;
    make_frames(6);
    command_succeeds("accumulate", "f_%04d.exr", "-o", "mean.exr", "--stderr", "error.exr");
    load("error.exr", &image);
    assert_int_equal(image.channel_count, 3);
    for (int c = 0; c < 3; c++) {
        const struct weft_image_channel *channel = channel_of(&image, rgb[c]);
        for (int i = 0; i < PIXELS; i++) {
            double sum = 0.0, squares = 0.0;
            for (int f = 1; f <= 6; f++) {
                sum += (double)value_of(f, c, i);
                squares += (double)value_of(f, c, i) * (double)value_of(f, c, i);
            }
            const double error = sqrt((squares - sum * sum / 6) / 5 / 6);
            if (!(fabs((double)channel->plane[i] - error) <= 1e-7 * error + 1e-12))
                fail_msg("%s, value %d: %.9g, not %.9g", rgb[c], i, (double)channel->plane[i],
                         error);
        }
    }
    weft_image_clear(&image);
}

// Noise around one half, of a standard deviation of 0.1: some 100 frames bring the error to 0.01.
static void make_noise(int count)
{
    static const char *const y[] = {"Y", NULL};
    for (int f = 1; f <= count; f++) {
        char path[32];
        snprintf(path, sizeof path, "n_%03d.exr", f);
        make_frame(path, f, &(struct recipe){.names = y, .scale = 0.34641});
    }
}

static void test_until(void **state)
{
    (void)state;
    enum { FRAMES = 200 };
    struct command_result result;
    make_noise(FRAMES);
    command_run(&result, "weft", "accumulate", "n_%03d.exr", "-o", "mean.exr", "--until",
                "0.01,share=95%,least=8", "--json", "--stderr", "error.exr");
    assert_int_equal(result.code, 0);
    assert_non_null(strstr(result.err, "weft: info: --until 0.01,share=95%,least=8 is met after "));
    json_t *root = parse(result.out);
    const json_t *until = json_object_get(root, "until");
    assert_true(json_is_true(json_object_get(until, "stopped")));
    assert_in_range((int)number(root, "added"), 90, 150);
    assert_true(number(until, "share") >= 0.95);
    json_decref(root);
    command_run(&result, "weft", "accumulate", "n_%03d.exr", "-o", "mean.exr", "--until", "0.1%");
    assert_int_equal(result.code, 0);
    assert_non_null(strstr(result.err, "is not met by all 200 frames"));
}

// ---- methods ------------------------------------------------------------------------------------

// Errors stay within the bound that is told, and are there where it says so.
static void check_method(const char *const *arguments, bool exact_method)
{
    const char *argv[24] = {"weft", "accumulate", "f_%04d.exr", "-o", "mean.exr", "--json"};
    int count = 6;
    while (*arguments)
        argv[count++] = *arguments++;
    struct command_result result;
    struct weft_image image;
    command_run_list(&result, argv);
    if (result.code != 0)
        fail_msg("%s", result.err);
    json_t *root = parse(result.out);
    const double bound = number(json_object_get(root, "method"), "bound");
    double largest = 0.0;
    json_decref(root);
    load("mean.exr", &image);
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < PIXELS; i++) {
            double mean = 0.0;
            for (int f = 1; f <= 11; f++)
                mean += (double)value_of(f, c, i) / 11.0;
            largest = fmax(largest, fabs((double)channel_of(&image, rgb[c])->plane[i] - mean));
        }
    }
    weft_image_clear(&image);
    if (!(largest <= bound && (exact_method || largest > 0.0)))
        fail_msg("%s %s: error %.3g, bound %.3g", argv[6], argv[7], largest, bound);
}

static void test_methods(void **state)
{
    (void)state;
    static const char *const methods[][8] = {
        {"--method", "exact"},
        {"--method", "buffer"},
        {"--method", "tree", "--emulate"},
        {"--method", "tree", "--emulate", "--branching", "2x3x2", "--rounding", "unbiased"},
        {"--method", "tree", "--emulate", "--bits", "16"},
        {"--method", "tree", "--emulate", "--bits", "32"},
        {"--method", "blend", "--emulate", "--bits", "16"},
        {"--method", "blend", "--emulate", "--bits", "half"},
        {"--method", "float", "--emulate"},
    };
    static const char *const drawn[][4] = {{"--method", "tree", "--bits", "8"},
                                           {"--method", "blend", "--bits", "16"},
                                           {"--method", "float"}};
    make_frames(11);
    for (size_t m = 0; m < COUNT(methods); m++)
        check_method(methods[m], m == 0);
    for (size_t m = 0; m < COUNT(drawn) && command_has_gl(); m++) {
        struct weft_image gl, emulated;
        const char *const *o = drawn[m];
        command_succeeds("accumulate", "f_%04d.exr", "-o", "gl.exr", "--weights", "tent", o[0],
                         o[1], o[2], o[3]);
        command_succeeds("accumulate", "f_%04d.exr", "-o", "emulated.exr", "--emulate", "--weights",
                         "tent", o[0], o[1], o[2], o[3]);
        load("gl.exr", &gl);
        load("emulated.exr", &emulated);
        for (size_t c = 0; c < 3; c++)
            assert_memory_equal(gl.channels[c].plane, emulated.channels[c].plane,
                                PIXELS * sizeof(float));
        weft_image_clear(&gl);
        weft_image_clear(&emulated);
    }
    command_fails(1, "--max-error 0.0001: the bound of --method tree is", "accumulate",
                  "f_%04d.exr", "-o", "mean.exr", "--method", "tree", "--emulate", "--max-error",
                  "1e-4");
}

// ---- reports ------------------------------------------------------------------------------------

static void test_json(void **state)
{
    (void)state;
    static const char *const stages[] = {"plan",  "context", "read",  "decode", "add",
                                         "judge", "result",  "write", "total"};
    make_frames(3);
    json_t *root = parse(command_succeeds("accumulate", "f_%04d.exr", "-o", "mean.exr", "--json"));
    assert_int_equal(number(root, "frames"), 3);
    assert_int_equal(number(root, "counting"), 3);
    assert_int_equal(number(root, "added"), 3);
    assert_int_equal(number(root, "width"), WIDTH);
    assert_int_equal(json_array_size(json_object_get(root, "channels")), 3);
    const json_t *method = json_object_get(root, "method");
    assert_string_equal(json_string_value(json_object_get(method, "name")), "exact");
    assert_true(number(method, "bound") > 0.0 && number(method, "bound") < 1e-7);
    assert_true(number(json_object_get(root, "weights"), "total") == 3.0);
    for (size_t i = 0; i < COUNT(stages); i++)
        assert_true(number(json_object_get(root, "seconds"), stages[i]) >= 0.0);
    json_decref(root);
}

static void test_explain(void **state)
{
    (void)state;
    make_frames(9);
    const int before = command_folder_size();
    const char *text = command_succeeds("accumulate", "f_%04d.exr", "-o", "no.exr", "--explain");
    assert_non_null(strstr(text, "accumulate 9 frames, from f_0001.exr: EXR, 19 x 13\n"));
    assert_non_null(strstr(text, "averaged: B, G, R\n"));
    assert_non_null(strstr(text, "method: exact"));
    assert_non_null(strstr(text, "memory: about 0.0119 MB of sums")); // 19 x 13 x 3 x 16 bytes
    text = command_succeeds("accumulate", "f_%04d.exr", "--explain", "--method", "tree",
                            "--branching", "3", "--bits", "16");
    assert_non_null(strstr(text, "method: tree of 16 bits, branching 3 (asked for)\n"));
    // 9 leaves, 3 nodes and their node, (b - 1) log_b N + 1 textures.
    assert_non_null(strstr(text, "passes: 13, of 9 frames and 4 nodes, on a stack of 5 textures"));
    assert_int_equal(command_folder_size(), before);
}

// Every test begins with an empty folder.
static int empty_folder(void **state)
{
    (void)state;
    DIR *folder = opendir(".");
    for (const struct dirent *entry = folder ? readdir(folder) : NULL; entry;
         entry = readdir(folder))
        unlink(entry->d_name);
    return folder ? closedir(folder) : -1;
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup(name, empty_folder)
    const struct CMUnitTest tests[] = {
        TEST(test_mean),           TEST(test_order_does_not_matter),
        TEST(test_names),          TEST(test_repeats_count),
        TEST(test_skip_bad),       TEST(test_weights),
        TEST(test_shapes),         TEST(test_types_and_windows),
        TEST(test_data_is_copied), TEST(test_png),
        TEST(test_preview),        TEST(test_standard_error),
        TEST(test_until),          TEST(test_methods),
        TEST(test_json),           TEST(test_explain),
    };
    return cmocka_run_group_tests(tests, command_setup_folder, command_teardown);
}
