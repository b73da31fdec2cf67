// SPDX-License-Identifier: BSD-3-Clause
// weft resample with PNG, TIFF and EXR files: what is kept, what becomes of it in another format,
// and what is refused before anything is done.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>
#include <math.h>

#include "tests/support/command.h"
#include "weft.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))

enum { WIDTH = 24, HEIGHT = 16, PIXELS = WIDTH * HEIGHT };

static float planes[4][PIXELS];

static struct weft_image_channel channels[4] = {{.name = "R", .plane = planes[0]},
                                                {.name = "G", .plane = planes[1]},
                                                {.name = "B", .plane = planes[2]},
                                                {.name = "A", .plane = planes[3]}};

// Light of codes of 8 bits under alpha of 1/255 to 1.
static struct weft_image picture(enum weft_pixel_type type)
{
    static const struct weft_transfer srgb = {.curve = WEFT_CURVE_SRGB};
    for (int i = 0; i < PIXELS; i++) {
        const double alpha = (1 + i * 11 % 255) / 255.0;
        planes[3][i] = (float)alpha;
        for (int c = 0; c < 3; c++)
            planes[c][i] = (float)(alpha * weft_transfer_light(&srgb, (i * (7 + c) % 256) / 255.0));
    }
    for (int c = 0; c < 4; c++)
        channels[c].type = type;
    return (struct weft_image){
        .width = WIDTH, .height = HEIGHT, .channel_count = 4, .channels = channels};
}

static void save(const char *path, enum weft_image_file_kind kind, const struct weft_image *image)
{
    const struct weft_image_save_params params = {.path = path, .kind = kind};
    assert_int_equal(weft_image_save(image, &params), WEFT_OK);
}

static void load(const char *path, struct weft_image *image)
{
    assert_int_equal(weft_image_load(&(struct weft_image_load_params){.path = path}, image),
                     WEFT_OK);
}

static void same_light(const char *a, const char *b)
{
    struct weft_image x, y;
    load(a, &x);
    load(b, &y);
    assert_int_equal(x.channel_count, y.channel_count);
    for (size_t c = 0; c < x.channel_count; c++) {
        size_t other = 0;
        while (strcmp(x.channels[c].name, y.channels[other].name))
            other++;
        assert_int_equal(x.channels[c].type, y.channels[other].type);
        assert_memory_equal(x.channels[c].plane, y.channels[other].plane,
                            sizeof(float) * (size_t)x.width * (size_t)x.height);
    }
    weft_image_clear(&x);
    weft_image_clear(&y);
}

// Untouched, codes stay codes: in place, through another format and back, and without a curve.
static void test_untouched(void **state)
{
    (void)state;
    static const char *const ends[] = {"out.png", "out.tif", "out.TIFF"};
    const struct weft_image image = picture(WEFT_PIXEL_UNORM8);
    save("in.png", WEFT_IMAGE_FILE_PNG, &image);
    for (size_t i = 0; i < COUNT(ends); i++) {
        command_succeeds("resample", "in.png", "-o", ends[i], "--size", "24x16", "--kernel",
                         "nearest", "--engine", "cpu", "--verify", "-q");
        same_light("in.png", ends[i]);
        command_succeeds("resample", ends[i], "-o", "back.png", "--size", "24x16", "--kernel",
                         "nearest", "--engine", "cpu", "--transfer", i == 1 ? "none" : "auto",
                         "-q");
        if (i != 1) // what is filtered as it is says nothing of its codes
            same_light("in.png", "back.png");
    }
    command_succeeds("resample", "in.png", "-o", "light.exr", "--size", "24x16", "--kernel",
                     "nearest", "--engine", "cpu", "--type", "float", "-q");
    command_succeeds("resample", "light.exr", "-o", "back.png", "--size", "24x16", "--kernel",
                     "nearest", "--engine", "cpu", "-q");
    same_light("in.png", "back.png");
}

// Types that a format has, and what they are without --type.
static void test_types(void **state)
{
    (void)state;
    static const struct {
        const char *out, *type;
        enum weft_pixel_type expected;
    } cases[] = {{"a.exr", NULL, WEFT_PIXEL_HALF},        {"a.png", NULL, WEFT_PIXEL_UNORM8},
                 {"a.tif", NULL, WEFT_PIXEL_UNORM8},      {"b.png", "unorm16", WEFT_PIXEL_UNORM16},
                 {"b.tif", "half", WEFT_PIXEL_HALF},      {"c.tif", "float", WEFT_PIXEL_FLOAT},
                 {"d.tif", "unorm16", WEFT_PIXEL_UNORM16}};
    const struct weft_image image = picture(WEFT_PIXEL_UNORM8);
    save("in.png", WEFT_IMAGE_FILE_PNG, &image);
    for (size_t i = 0; i < COUNT(cases); i++) {
        struct weft_image made;
        if (cases[i].type)
            command_succeeds("resample", "in.png", "-o", cases[i].out, "--engine", "cpu", "--type",
                             cases[i].type, "-q");
        else
            command_succeeds("resample", "in.png", "-o", cases[i].out, "--engine", "cpu", "-q");
        load(cases[i].out, &made);
        assert_int_equal(made.width, 2 * WIDTH);
        assert_int_equal(made.channels[0].type, cases[i].expected);
        weft_image_clear(&made);
    }
}

static void test_refused(void **state)
{
    (void)state;
    struct weft_image image = picture(WEFT_PIXEL_FLOAT);
    save("in.exr", WEFT_IMAGE_FILE_EXR, &image);
    command_fails(2, "--type half: a file of PNG has channels of unorm8 or unorm16", "resample",
                  "in.exr", "-o", "x.png", "--type", "half");
    command_fails(2, "--type unorm8: a file of EXR has channels of float, half or uint", "resample",
                  "in.exr", "-o", "x.exr", "--type", "unorm8");
    command_fails(2, "--compression piz: TIFF is written as", "resample", "in.exr", "-o", "x.tif",
                  "--compression", "piz");
    command_fails(2, "--compression zip: PNG has one of its own", "resample", "in.exr", "-o",
                  "x.png", "--compression", "zip");
    command_fails(2, "--mip: a PNG file has no levels", "resample", "in.exr", "-o", "x.png",
                  "--mip");
    command_fails(2, "must end in .exr", "resample", "in.exr", "-o", "x.webp");
    snprintf(channels[3].name, sizeof channels[3].name, "Z");
    save("z.exr", WEFT_IMAGE_FILE_EXR, &image);
    snprintf(channels[3].name, sizeof channels[3].name, "A");
    struct command_result result;
    command_run(&result, "weft", "resample", "z.exr", "-o", "x.png", "--engine", "cpu");
    assert_int_not_equal(result.code, 0);
    assert_non_null(strstr(result.err, "no place for channel Z"));
    assert_int_equal(access("x.png", F_OK), -1);
    command_succeeds("resample", "z.exr", "-o", "x.png", "--channels", "R,G,B", "--engine", "cpu",
                     "-q");
}

// Several pages become parts, one of them a PNG file; tiles stay tiles, and levels are made.
static void test_parts_and_levels(void **state)
{
    (void)state;
    struct weft_image pages[2] = {picture(WEFT_PIXEL_UNORM16), picture(WEFT_PIXEL_UNORM16)};
    for (int p = 0; p < 2; p++) {
        pages[p].tiled = true;
        pages[p].tile[0] = pages[p].tile[1] = 16;
    }
    const struct weft_image_save_params params = {.path = "pages.tif",
                                                  .kind = WEFT_IMAGE_FILE_TIFF};
    assert_int_equal(weft_image_save_parts(pages, 2, &params, NULL), WEFT_OK);
    command_fails(2, "pages.tif has 2 parts, and a PNG file one: --part says which", "resample",
                  "pages.tif", "-o", "x.png", "--engine", "cpu");
    command_succeeds("resample", "pages.tif", "-o", "one.png", "--part", "1", "--engine", "cpu",
                     "-q");
    command_succeeds("resample", "pages.tif", "-o", "all.exr", "--mip", "--engine", "cpu",
                     "--verify", "-q");
    struct weft_image_list list;
    assert_int_equal(
        weft_image_list_load(&(struct weft_image_load_params){.path = "all.exr"}, &list), WEFT_OK);
    assert_int_equal(list.count, 2);
    for (int p = 0; p < 2; p++) {
        assert_true(list.images[p].tiled && list.images[p].levels == WEFT_IMAGE_LEVELS_MIP);
        assert_int_equal(list.images[p].tile[0], 16);
    }
    weft_image_list_clear(&list);
    command_succeeds("resample", "all.exr", "-o", "again.exr", "--size", "30x20", "--engine", "cpu",
                     "-q");
    assert_non_null(strstr(command_succeeds("info", "again.exr"), "tiled with mip levels"));
    assert_non_null(strstr(command_succeeds("info", "pages.tif", "--json"), "\"tiff\""));
}

// Frames of the same codes have the same mean, whatever holds them.
static void test_accumulated(void **state)
{
    (void)state;
    const struct weft_image image = picture(WEFT_PIXEL_UNORM16);
    save("frame.png", WEFT_IMAGE_FILE_PNG, &image);
    save("frame.tif", WEFT_IMAGE_FILE_TIFF, &image);
    command_succeeds("accumulate", "frame.png", "-o", "png.exr", "--type", "float", "-q");
    command_succeeds("accumulate", "frame.tif", "-o", "tif.exr", "--type", "float", "-q");
    same_light("png.exr", "tif.exr");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_untouched),   cmocka_unit_test(test_types),
        cmocka_unit_test(test_refused),     cmocka_unit_test(test_parts_and_levels),
        cmocka_unit_test(test_accumulated),
    };
    return cmocka_run_group_tests(tests, command_setup_folder, command_teardown);
}
