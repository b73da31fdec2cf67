// SPDX-License-Identifier: BSD-3-Clause
// weft resample with --rotate, --matrix, --perspective and --positions, as users see them.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <jansson.h>

#include "tests/support/command.h"
#include "weft.h"

enum { WIDTH = 20, HEIGHT = 20, CHANNELS = 5 };

static float value(int c, int x, int y)
{
    return (float)(c + 0.01 * x + 0.37 * y * (c == 2 ? -1 : 1));
}

// A data window of WIDTH x HEIGHT at (3, -2), which is the display window.
static void make_image(const char *path, const char *const *names, float (*of)(int, int, int))
{
    struct weft_image_channel channels[CHANNELS] = {0};
    static float planes[CHANNELS][WIDTH * HEIGHT];
    struct weft_image image = {.x = 3,
                               .y = -2,
                               .width = WIDTH,
                               .height = HEIGHT,
                               .display_min = {3, -2},
                               .display_max = {3 + WIDTH - 1, -2 + HEIGHT - 1},
                               .channels = channels};
    for (int c = 0; names[c]; c++) {
        for (int i = 0; i < WIDTH * HEIGHT; i++)
            planes[c][i] = of(c, i % WIDTH, i / WIDTH);
        snprintf(channels[c].name, sizeof channels[c].name, "%s", names[c]);
        channels[c].type = WEFT_PIXEL_FLOAT;
        channels[c].plane = planes[c];
        image.channel_count++;
    }
    const struct weft_image_save_params params = {.path = path};
    assert_int_equal(weft_image_save(&image, &params), WEFT_OK);
}

static const char *const rgbaz[] = {"A", "B", "G", "R", "Z", NULL};

static struct weft_image load(const char *path)
{
    struct weft_image image;
    assert_int_equal(weft_image_load(&(struct weft_image_load_params){.path = path}, &image),
                     WEFT_OK);
    return image;
}

// A quarter turn moves every pixel, counter-clockwise with row 0 on top, in place.
static void test_quarter(void **state)
{
    (void)state;
    make_image("in.exr", rgbaz, value);
    command_succeeds("resample", "in.exr", "-o", "out.exr", "--rotate", "90", "--verify");
    struct weft_image out = load("out.exr");
    assert_true(out.x == 3 && out.y == -2 && out.width == WIDTH && out.height == HEIGHT);
    assert_int_equal(out.channel_count, CHANNELS);
    const struct weft_image_attribute *map = NULL;
    for (size_t i = 0; i < out.attribute_count; i++)
        if (strcmp(out.attributes[i].name, "weft.map") == 0)
            map = &out.attributes[i];
    assert_non_null(map);
    assert_memory_equal(map->data, "rotate 90", 9);
    for (int c = 0; c < CHANNELS; c++)
        for (int y = 0; y < HEIGHT; y++)
            for (int x = 0; x < WIDTH; x++)
                assert_true(out.channels[c].plane[y * WIDTH + x] == value(c, WIDTH - 1 - y, x));
    weft_image_clear(&out);
}

// R, G, B and A go together, Z by itself; all within their bounds, on both engines.
static void test_json(void **state)
{
    (void)state;
    const char *const engines[] = {"cpu", "gl"};
    make_image("in.exr", rgbaz, value);
    for (int e = 0; e < 1 + command_has_gl(); e++) {
        json_t *root = json_loads(command_succeeds("resample", "in.exr", "--verify", "--json",
                                                   "--engine", engines[e], "--perspective",
                                                   "0.9,0.1,1,-0.1,0.6,2,0.001,0.01,1"),
                                  0, NULL);
        const json_t *groups = json_object_get(root, "groups"),
                     *warp = json_object_get(root, "warp");
        assert_string_equal(json_string_value(json_object_get(warp, "map")), "projective");
        assert_true(json_number_value(json_array_get(json_object_get(warp, "scale"), 1)) > 1.3);
        assert_int_equal(json_array_size(groups), 2);
        for (size_t g = 0; g < 2; g++) {
            const json_t *group = json_array_get(groups, g);
            const json_t *bound = json_object_get(group, "bound");
            const json_t *error = json_object_get(group, "error");
            assert_int_equal(json_array_size(json_object_get(group, "channels")), g ? 1 : 4);
            assert_true(json_number_value(json_object_get(error, "max")) <=
                        json_number_value(bound));
        }
        json_decref(root);
    }
}

// Points in the input's own coordinates: shifted by (1, 2) the picture is another's part.
static float shifted_x(int x)
{
    return (float)(3 + x + 1) + 0.5f;
}
static float shifted(int c, int x, int y)
{
    return c == 0 ? shifted_x(x) : (float)(-2 + y + 2) + 0.5f;
}
static float missing(int c, int x, int y)
{
    return x == 7 && y == 9 ? NAN : shifted(c, x, y);
}

static void test_positions(void **state)
{
    (void)state;
    static const char *const xy[] = {"X", "Y", NULL};
    make_image("in.exr", rgbaz, value);
    make_image("p.exr", xy, shifted);
    command_succeeds("resample", "in.exr", "-o", "out.exr", "--positions", "p.exr");
    struct weft_image out = load("out.exr");
    for (int y = 0; y + 2 < HEIGHT; y++)
        for (int x = 0; x + 1 < WIDTH; x++)
            assert_true(out.channels[1].plane[y * WIDTH + x] == value(1, x + 1, y + 2));
    weft_image_clear(&out);
    make_image("nan.exr", xy, missing);
    command_fails(2, "pixel (7, 9) shows the point (nan, nan)", "resample", "in.exr", "-o",
                  "new.exr", "--positions", "nan.exr");
    command_fails(2, "channels X and Y are needed", "resample", "in.exr", "-o", "new.exr",
                  "--positions", "in.exr");
}

static void test_size(void **state)
{
    (void)state;
    make_image("in.exr", rgbaz, value);
    command_succeeds("resample", "in.exr", "-o", "out.exr", "--rotate", "0", "--size", "30x26");
    struct weft_image out = load("out.exr");
    assert_true(out.width == 30 && out.height == 26 && out.x == 3 && out.display_max[1] == 23);
    assert_true(out.channels[0].plane[3 * 30 + 5] == value(0, 0, 0)); // centred
    weft_image_clear(&out);
}

static void test_refused(void **state)
{
    (void)state;
    make_image("in.exr", rgbaz, value);
#define REFUSED(text, ...)                                                                         \
    command_fails(2, text, "resample", "in.exr", "-o", "new.exr", __VA_ARGS__)
    REFUSED("no inverse: its determinant is 0", "--matrix", "1,2,2,4,0,0");
    REFUSED("a matrix of zeros has no inverse", "--perspective", "0,0,0,0,0,0,0,0,0");
    REFUSED("horizon meets the 20 x 20 pixels", "--perspective", "1,0,0,0,1,0,0.1,0,-1");
    REFUSED("6 numbers with commas", "--matrix", "1,0,0,1,0");
    REFUSED("6 numbers with commas", "--matrix", "1,0,0,1,0,inf");
    REFUSED("9 numbers with commas", "--perspective", "1,0,0,0,1,0,0,0,1,");
    REFUSED("--rotate: 'x' is not one finite number", "--rotate", "x");
    REFUSED("--rotate does not go with --matrix", "--rotate", "3", "--matrix", "1,0,0,1,0,0");
    REFUSED("does not go with --rotate", "--rotate", "3", "--profile", "fp32");
    REFUSED("does not go with --rotate", "--rotate", "3", "--max-error", "8bit");
    REFUSED("does not go with --positions", "--positions", "p.exr", "--size", "4x4");
#undef REFUSED
    command_fails(3, "which is prefiltered: it cannot be stretched", "resample", "in.exr", "-o",
                  "new.exr", "--matrix", "0.5,0.1,0,0.5,0,0", "--kernel", "bspline3i");
    command_fails(3, "is not divided", "resample", "in.exr", "-o", "new.exr", "--rotate", "3",
                  "--schedule", "static");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_quarter),   cmocka_unit_test(test_json),
        cmocka_unit_test(test_positions), cmocka_unit_test(test_size),
        cmocka_unit_test(test_refused),
    };
    return cmocka_run_group_tests(tests, command_setup_folder, command_teardown);
}
