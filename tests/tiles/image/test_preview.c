// SPDX-License-Identifier: BSD-3-Clause
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <float.h>
#include <png.h>
#include <signal.h>
#include <sys/resource.h>

#include "tests/support/files.h"
#include "filter/check.h"
#include "tiles/image/image.h"

// Decodes to RGB; to be freed.
static uint8_t *decode(const char *path, int width, int height, bool *grey)
{
    png_image image = {.version = PNG_IMAGE_VERSION};
    assert_true(png_image_begin_read_from_file(&image, path));
    assert_int_equal(image.width, width);
    assert_int_equal(image.height, height);
    *grey = !(image.format & PNG_FORMAT_FLAG_COLOR);
    image.format = PNG_FORMAT_RGB;
    uint8_t *pixels = malloc(PNG_IMAGE_SIZE(image));
    assert_non_null(pixels);
    assert_true(png_image_finish_read(&image, NULL, pixels, 0, NULL));
    return pixels;
}

static void test_colour_maps(void **state)
{
    (void)state;
    for (size_t i = 0; weft_colour_map_list[i]; i++) {
        const struct weft_colour_map *map = weft_colour_map_list[i];
        uint8_t rgb[3], old[3];
        assert_ptr_equal(weft_colour_map_find(map->name), map);
        assert_true(map->citation[0] != '\0');
        map->colour(0.0, old);
        for (int k = 1; k <= 1000; k++) { // no jumps
            map->colour(k / 1000.0, rgb);
            for (int c = 0; c < 3; c++)
                assert_in_range(abs(rgb[c] - old[c]), 0, 3);
            memcpy(old, rgb, sizeof old);
        }
        map->colour(2.0, rgb);
        assert_memory_equal(rgb, old, sizeof rgb);
    }
    assert_string_equal(weft_colour_map_list[0]->name, "grey");
    assert_null(weft_colour_map_find("none"));
    assert_null(weft_colour_map_find(NULL));

    assert_ptr_equal(weft_colour_map_find("gray"), weft_colour_map_find("grey"));
    assert_ptr_equal(weft_colour_map_find("coolwarm"), weft_colour_map_find("cool-warm"));
}

// Colours as they were published: entries of matplotlib's and Google's lists of 256, floats from 0
// to 1, and of Moreland's table.
static void test_published(void **state)
{
    (void)state;
    static const struct {
        const char *map;
        double position;
        double colour[3]; // 0 to 1
    } published[] = {
        {"viridis", 0 / 255.0, {0.267004, 0.004874, 0.329415}},
        {"viridis", 64 / 255.0, {0.229739, 0.322361, 0.545706}},
        {"viridis", 128 / 255.0, {0.127568, 0.566949, 0.550556}},
        {"viridis", 255 / 255.0, {0.993248, 0.906157, 0.143936}},
        {"magma", 0 / 255.0, {0.001462, 0.000466, 0.013866}},
        {"magma", 128 / 255.0, {0.716387, 0.214982, 0.475290}},
        {"magma", 255 / 255.0, {0.987053, 0.991438, 0.749504}},
        {"cividis", 0 / 255.0, {0.0, 0.135112, 0.304751}},
        {"cividis", 255 / 255.0, {0.995737, 0.909344, 0.217772}},
        {"turbo", 0 / 255.0, {0.18995, 0.07176, 0.23217}},
        {"turbo", 128 / 255.0, {0.64362, 0.98999, 0.23356}},
        {"turbo", 255 / 255.0, {0.47960, 0.01583, 0.01055}},
        {"cool-warm", 0.0, {59 / 255.0, 76 / 255.0, 192 / 255.0}},
        {"cool-warm", 0.5, {221 / 255.0, 221 / 255.0, 221 / 255.0}},
        {"cool-warm", 1.0, {180 / 255.0, 4 / 255.0, 38 / 255.0}},
    };
    for (size_t i = 0; i < sizeof published / sizeof *published; i++) {
        uint8_t rgb[3];
        weft_colour_map_find(published[i].map)->colour(published[i].position, rgb);
        for (int c = 0; c < 3; c++)
            assert_int_equal(rgb[c], lrint(255.0 * published[i].colour[c]));
    }
}

static void test_values(void **state)
{
    (void)state;
    const float plane[] = {-1.0f, 0.0f, 1.0f, 2.0f, 3.0f, NAN, INFINITY, -INFINITY};
    for (size_t i = 0; weft_colour_map_list[i]; i++) {
        const struct weft_colour_map *map = weft_colour_map_list[i];
        float range[2];
        bool grey;
        assert_int_equal(
            weft_preview_save(weft_preview_params(.path = test_path("a.png"), .width = 4,
                                                  .height = 2, .plane = plane, .colour_map = map),
                              range),
            WEFT_OK);
        assert_true(range[0] == -1.0f && range[1] == 3.0f);
        uint8_t *pixels = decode(test_path("a.png"), 4, 2, &grey);
        assert_int_equal(grey, i == 0);
        for (int k = 0; k < 8; k++) {
            uint8_t rgb[3] = {grey ? 0 : 255, 0, grey ? 0 : 255};
            if (!isnan(plane[k]))
                map->colour(fmin(fmax((plane[k] + 1.0) / 4.0, 0.0), 1.0), rgb);
            assert_memory_equal(pixels + 3 * k, rgb, 3);
        }
        free(pixels);
    }
}

// Larger than a thread's band of rows: every pixel is what its value says, and the file is the same
// bytes whatever the number of threads.
static void test_many_rows(void **state)
{
    (void)state;
    enum { WIDTH = 97, HEIGHT = 210 };
    static const int threads[] = {1, 2, 5};
    static float plane[WIDTH * HEIGHT];
    uint32_t seed = 7;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        seed = seed * 1664525u + 1013904223u;
        plane[i] = seed >> 24 ? sinf(0.01f * (float)i) + 0x1p-33f * (float)seed : NAN;
    }
    for (size_t m = 0; weft_colour_map_list[m]; m++) {
        char *files[3];
        size_t sizes[3];
        for (int k = 0; k < 3; k++) {
            const char *path = test_path("rows.png");
            const struct weft_preview_params params = {.path = path,
                                                       .width = WIDTH,
                                                       .height = HEIGHT,
                                                       .plane = plane,
                                                       .low = -1.0f,
                                                       .high = 1.25f,
                                                       .colour_map = weft_colour_map_list[m],
                                                       .threads = threads[k]};
            bool grey;
            assert_int_equal(weft_preview_save(&params, NULL), WEFT_OK);
            uint8_t *pixels = decode(path, WIDTH, HEIGHT, &grey);
            for (int i = 0; i < WIDTH * HEIGHT; i++) {
                uint8_t rgb[3] = {grey ? 0 : 255, 0, grey ? 0 : 255};
                const double t = ((double)plane[i] + 1.0) / 2.25;
                if (!isnan(plane[i]))
                    weft_colour_map_list[m]->colour(fmin(fmax(t, 0.0), 1.0), rgb);
                assert_memory_equal(pixels + 3 * i, rgb, 3);
            }
            free(pixels);
            files[k] = test_read_file(path, &sizes[k]);
            assert_int_equal(sizes[k], sizes[0]);
            assert_memory_equal(files[k], files[0], sizes[0]);
        }
        for (int k = 0; k < 3; k++)
            free(files[k]);
    }
}

// Draws a column over all rows, one pixel left of the preview's middle.
static void draw_column(const void *priv, int32_t y, uint8_t *rgb)
{
    const int *at = priv;
    rgb[3 * at[0]] = (uint8_t)y;
}

// White around, the preview as without a frame, and what is drawn over both; by any number of
// threads. Grey is RGB then, and NaN magenta.
static void test_frames(void **state)
{
    (void)state;
    enum { WIDTH = 31, HEIGHT = 45, LEFT = 5, RIGHT = 2, TOP = 3, BOTTOM = 7 };
    enum { WHOLE = LEFT + WIDTH + RIGHT, ROWS = TOP + HEIGHT + BOTTOM };
    static float plane[WIDTH * HEIGHT];
    static const int column = LEFT + 9;
    const struct weft_preview_frame frame = {LEFT, RIGHT, TOP, BOTTOM, draw_column, &column};
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        plane[i] = i % 17 ? (float)i : NAN;
    for (int colour = 0; colour < 2; colour++) {
        bool grey;
        const struct weft_preview_params params = {.path = test_path("frame.png"),
                                                   .width = WIDTH,
                                                   .height = HEIGHT,
                                                   .plane = plane,
                                                   .high = 1400.0f,
                                                   .frame = &frame};
        const struct weft_colour_preview_params light = {.path = test_path("frame.png"),
                                                         .width = WIDTH,
                                                         .height = HEIGHT,
                                                         .red = plane,
                                                         .green = plane,
                                                         .blue = plane,
                                                         .frame = &frame,
                                                         .threads = 1};
        assert_int_equal(
            colour ? weft_colour_preview_save(&light) : weft_preview_save(&params, NULL), WEFT_OK);
        uint8_t *pixels = decode(test_path("frame.png"), WHOLE, ROWS, &grey);
        assert_false(grey);
        for (int y = 0; y < ROWS; y++)
            for (int x = 0; x < WHOLE; x++) {
                const bool inside = x >= LEFT && x < LEFT + WIDTH && y >= TOP && y < TOP + HEIGHT;
                const int i = (y - TOP) * WIDTH + x - LEFT;
                uint8_t rgb[3] = {255, 255, 255};
                if (inside && isnan(plane[i]))
                    rgb[1] = 0;
                else if (inside && !colour)
                    memset(rgb, (int)lrint(255.0 * (double)plane[i] / 1400.0), 3);
                if (x == column)
                    rgb[0] = (uint8_t)y;
                assert_memory_equal(pixels + 3 * (y * WHOLE + x), rgb, 3);
            }
        free(pixels);
    }
}

// IEC 61966-2-1 in double precision, with its published values; NaN in one channel is magenta.
static void test_colours(void **state)
{
    (void)state;
    enum { COUNT = 4099 };
    static const struct {
        double light;
        int code;
    } published[] = {{0.0, 0},   {0.0031308, 10},  {0.2140411, 127},
                     {0.5, 188}, {0.7304608, 222}, {1.0, 255}};
    static float red[COUNT], green[COUNT], blue[COUNT];
    bool grey;
    for (int i = 0; i < COUNT; i++) {
        red[i] = (float)i / 4096.0f;
        green[i] = 1.0f - red[i];
        blue[i] = -red[i];
    }
    for (size_t i = 0; i < sizeof published / sizeof *published; i++)
        red[i] = (float)published[i].light;
    red[7] = green[8] = blue[9] = NAN;
    red[10] = INFINITY;
    struct weft_colour_preview_params params = {.path = test_path("c.png"),
                                                .width = COUNT,
                                                .height = 1,
                                                .red = red,
                                                .green = green,
                                                .blue = blue};
    assert_int_equal(weft_colour_preview_save(&params), WEFT_OK);
    uint8_t *pixels = decode(params.path, COUNT, 1, &grey);
    assert_false(grey);
    for (size_t i = 0; i < sizeof published / sizeof *published; i++)
        assert_in_range(pixels[3 * i], published[i].code, published[i].code + (i == 2));
    for (int i = 0; i < COUNT; i++) {
        if (i >= 7 && i <= 9) {
            assert_memory_equal(pixels + 3 * i, "\xff\x00\xff", 3);
            continue;
        }
        const float *const plane[] = {red, green, blue};
        for (int c = 0; c < 3; c++) {
            const double v = fmin(fmax((double)plane[c][i], 0.0), 1.0);
            const double code = v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1 / 2.4) - 0.055;
            assert_true(fabs(pixels[3 * i + c] - 255.0 * code) <= 0.5 + 1e-9);
        }
    }
    free(pixels);
    // Light from 1 to 3 is what 0 to 1 is otherwise.
    params.low = 1.0f;
    params.high = 3.0f;
    red[0] = 1.0f + 2.0f * 0.5f;
    assert_int_equal(weft_colour_preview_save(&params), WEFT_OK);
    pixels = decode(params.path, COUNT, 1, &grey);
    assert_int_equal(pixels[0], 188);
    free(pixels);
}

static void test_ranges(void **state)
{
    (void)state;
    static const struct {
        float value[2], low, high, expected[2];
        uint8_t grey[2];
    } cases[] = {
        {{5, 5}, NAN, NAN, {5, 5}, {128, 128}},        // constant
        {{4, 6}, 5, 5, {5, 5}, {0, 255}},              // no width
        {{NAN, INFINITY}, NAN, NAN, {0, 1}, {0, 255}}, // nothing finite
        {{0, 1}, 1, 0, {1, 0}, {255, 0}},              // reversed
        {{-1, 1}, 0, NAN, {0, 1}, {0, 255}},           // half given
        {{-FLT_MAX, FLT_MAX}, NAN, NAN, {-FLT_MAX, FLT_MAX}, {0, 255}},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        float range[2];
        bool grey;
        assert_int_equal(
            weft_preview_save(weft_preview_params(.path = test_path("r.png"), .width = 2,
                                                  .height = 1, .plane = cases[i].value,
                                                  .low = cases[i].low, .high = cases[i].high),
                              range),
            WEFT_OK);
        assert_true(range[0] == cases[i].expected[0] && range[1] == cases[i].expected[1]);
        uint8_t *pixels = decode(test_path("r.png"), 2, 1, &grey);
        assert_int_equal(pixels[0], cases[i].grey[0]);
        assert_int_equal(pixels[3], cases[i].grey[1]);
        free(pixels);
    }
}

static void test_errors_are_told(void **state)
{
    (void)state;
    const float plane[1] = {0};
    const struct {
        struct weft_preview_params params;
        enum weft_result res;
    } cases[] = {
        {{.width = 1, .height = 1, .plane = plane}, WEFT_ERR_ARGUMENT},
        {{.path = "x.png", .width = 0, .height = 1, .plane = plane}, WEFT_ERR_ARGUMENT},
        {{.path = "x.png", .width = 1, .height = -1, .plane = plane}, WEFT_ERR_ARGUMENT},
        {{.path = "x.png", .width = 1, .height = 1}, WEFT_ERR_ARGUMENT},
        {{.path = "x.png", .width = 1, .height = 1, .plane = plane, .low = INFINITY},
         WEFT_ERR_ARGUMENT},
        {{.path = "/dev/full", .width = 1, .height = 1, .plane = plane}, WEFT_ERR_WRITE},
        {{.path = test_path("missing/x.png"), .width = 1, .height = 1, .plane = plane},
         WEFT_ERR_WRITE},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct weft_preview_params params = cases[i].params;
        params.log = &test_log;
        test_forget();
        assert_int_equal(weft_preview_save(&params, NULL), cases[i].res);
        assert_int_equal(test_errors, 1);
    }
    assert_int_equal(test_count_entries(test_folder), 2);
}

// A disk that is full is told once, in the caller's thread, by whichever thread it was met.
static void test_full(void **state)
{
    (void)state;
    enum { WIDTH = 701, HEIGHT = 901 };
    static float plane[WIDTH * HEIGHT];
    uint32_t seed = 3;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        seed = seed * 1664525u + 1013904223u;
        plane[i] = (float)(seed >> 24);
    }
    struct rlimit old, small;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &old), 0);
    small = old;
    small.rlim_cur = 300000;
    void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
    for (int threads = 1; threads <= 5; threads += 2) {
        const struct weft_preview_params params = {.path = test_path("full.png"),
                                                   .width = WIDTH,
                                                   .height = HEIGHT,
                                                   .plane = plane,
                                                   .threads = threads,
                                                   .log = &test_log};
        test_forget();
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
        const enum weft_result res = weft_preview_save(&params, NULL);
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &old), 0);
        assert_int_equal(res, WEFT_ERR_WRITE);
        assert_int_equal(test_errors, 1);
        assert_non_null(strstr(test_message, "File too large"));
        assert_int_equal(test_count_entries(test_folder), 2);
    }
    signal(SIGXFSZ, handler);
}

#define IN_FOLDER(name) cmocka_unit_test_setup_teardown(name, test_enter_folder, test_leave_folder)

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_colour_maps),
        cmocka_unit_test(test_published),
        cmocka_unit_test(test_frames),
        IN_FOLDER(test_values),
        IN_FOLDER(test_many_rows),
        IN_FOLDER(test_ranges),
        IN_FOLDER(test_colours),
        IN_FOLDER(test_errors_are_told),
        IN_FOLDER(test_full),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
