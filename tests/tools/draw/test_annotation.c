// SPDX-License-Identifier: BSD-3-Clause
// What --annotate puts around a picture: the picture stays as it is, the legend has the map's
// colours, texts leave ink where they belong, and pictures of any size and shape have room.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/draw/annotation.h"

static const struct annotation all = {.title = "smoke.vdb: density",
                                      .caption = "mitchell, z = 12.5",
                                      .low = -1.5,
                                      .high = 4.0,
                                      .quantity = "density",
                                      .across = {"x", -30.0, 20.0},
                                      .down = {"y", 10.0, -90.0},
                                      .length = 50.0,
                                      .unit = "mm"};

// A whole picture, of 0x55 within and white around; to be freed.
static uint8_t *draw(const struct annotation *a, int width, int height,
                     struct weft_preview_frame *frame)
{
    marks *list;
    if (annotation_create(a, width, height, &list, frame) != WEFT_OK)
        skip(); // no font here
    const int whole[2] = {frame->left + width + frame->right, frame->top + height + frame->bottom};
    assert_true(frame->left > 0 && frame->right > 0 && frame->top > 0 && frame->bottom > 0);
    uint8_t *out = malloc(3 * (size_t)whole[0] * (size_t)whole[1]);
    assert_non_null(out);
    for (int y = whole[1] - 1; y >= 0; y--) { // in any order
        uint8_t *row = out + 3 * (size_t)whole[0] * (size_t)y;
        memset(row, 255, 3 * (size_t)whole[0]);
        if (y >= frame->top && y < frame->top + height)
            memset(row + 3 * frame->left, 0x55, 3 * (size_t)width);
        frame->draw(frame->priv, y, row);
    }
    marks_destroy(&list);
    assert_null(list);
    return out;
}

// Pixels of the whole that are darker than half, in a rectangle.
static int ink(const uint8_t *pixels, int whole, int x, int y, int width, int height)
{
    int count = 0;
    for (int j = y; j < y + height; j++)
        for (int i = x; i < x + width; i++)
            count += pixels[3 * ((size_t)j * (size_t)whole + (size_t)i)] < 128;
    return count;
}

static void pictures_stay_as_they_are(void **state)
{
    static const int sizes[][2] = {{300, 200}, {16, 16},  {1, 1},
                                   {900, 20},  {20, 900}, {2000, 1500}};
    (void)state;
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        const int width = sizes[s][0], height = sizes[s][1];
        struct annotation a = all;
        struct weft_preview_frame f;
        a.colour_map = weft_colour_map_find("viridis");
        uint8_t *pixels = draw(&a, width, height, &f);
        const int whole = f.left + width + f.right;
        for (int y = 0; y < height; y++)
            for (int i = 0; i < 3 * width; i++)
                assert_int_equal(
                    pixels[3 * ((size_t)(f.top + y) * (size_t)whole + (size_t)f.left) + (size_t)i],
                    0x55);
        assert_true(ink(pixels, whole, f.left, 0, f.right, f.top) > 20); // the title
        assert_true(ink(pixels, whole, 0, f.top, f.left - 1, height) > 0);
        assert_true(ink(pixels, whole, 0, f.top + height + 1, whole, f.bottom - 1) > 20);
        free(pixels);
    }
}

// From below to above all colours from the first to the last, in a column right of the picture.
static void legends_have_the_colours_of_maps(void **state)
{
    enum { WIDTH = 300, HEIGHT = 256 };
    (void)state;
    for (size_t m = 0; weft_colour_map_list[m]; m++) {
        const struct weft_colour_map *map = weft_colour_map_list[m];
        struct annotation a = all;
        struct weft_preview_frame f;
        a.colour_map = map;
        uint8_t *pixels = draw(&a, WIDTH, HEIGHT, &f);
        const size_t whole = (size_t)(f.left + WIDTH + f.right);
        int found = 0;
        for (size_t x = (size_t)(f.left + WIDTH + 2); x < whole; x++) {
            bool same = true;
            for (int y = 0; y < HEIGHT && same; y++) {
                uint8_t rgb[3];
                map->colour(1.0 - (double)y / (HEIGHT - 1), rgb);
                same = memcmp(pixels + 3 * ((size_t)(f.top + y) * whole + x), rgb, 3) == 0;
            }
            found += same;
        }
        assert_in_range(found, 8, 40);
        free(pixels);
    }
}

// All zero is a margin; texts that are no text, too long or not UTF-8, and ranges of no width or
// none are drawn somehow.
static void anything_is_drawn(void **state)
{
    static const double ranges[][2] = {{0.0, 0.0},    {1.0, 1.0},       {-1e30, 1e30},
                                       {NAN, NAN},    {1e-9, 2e-9},     {1e6, 1.0000001e6},
                                       {0.0, 1e-300}, {-INFINITY, 1.0}, {5.0, -5.0}};
    (void)state;
    struct weft_preview_frame f;
    const struct annotation none = {.low = 0.0};
    free(draw(&none, 50, 50, &f));
    for (size_t i = 0; i < sizeof ranges / sizeof *ranges; i++) {
        struct annotation a = all;
        a.colour_map = weft_colour_map_list[0];
        a.low = a.across.start = ranges[i][0];
        a.high = a.across.end = ranges[i][1];
        a.length = ranges[i][1];
        memset(a.title, 'W', sizeof a.title - 1);
        snprintf(a.caption, sizeof a.caption, "\xff\xc3 \xe2\x82 \xc3\xa4 \xf0\x9f\x98\x80");
        free(draw(&a, 120, 80, &f));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_stay_as_they_are),
        cmocka_unit_test(legends_have_the_colours_of_maps),
        cmocka_unit_test(anything_is_drawn),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
