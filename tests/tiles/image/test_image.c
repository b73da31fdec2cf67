// SPDX-License-Identifier: BSD-3-Clause
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <float.h>

#include "tests/support/exr_maker.h"
#include "tests/support/exr_peer.h"
#include "tests/support/files.h"
#include "filter/check.h"
#include "tiles/image/image.h"

enum { WIDTH = 37, HEIGHT = 45, PIXELS = WIDTH * HEIGHT };

static uint32_t next_random(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8 ^ *state << 11;
}

static enum weft_result load(const char *path, struct weft_image *out)
{
    struct weft_image_load_params params = {.path = path, .log = &test_log};
    test_forget();
    return weft_image_load(&params, out);
}

static enum weft_result save(const char *path, const struct weft_image *image)
{
    struct weft_image_save_params params = {.path = path, .log = &test_log};
    test_forget();
    return weft_image_save(image, &params);
}

// ---- what is saved is loaded, bit for bit -------------------------------------------------------

static const float special[] = {NAN,    -NAN,    INFINITY, -INFINITY, 0.0f,     -0.0f,
                                1e-45f, -1e-42f, FLT_MIN,  FLT_MAX,   -FLT_MAX, 1.0f};

static void fill(float *plane, size_t count, uint32_t seed)
{
    for (size_t i = 0; i < count; i++) {
        uint32_t bits = next_random(&seed);
        memcpy(plane + i, &bits, sizeof bits);
    }
    memcpy(plane, special, sizeof special < count * sizeof *plane ? sizeof special : count * 4);
}

static void test_round_trip(void **state)
{
    (void)state;
    static const struct {
        int32_t x, y, width, height;
        size_t channels;
    } cases[] = {
        {0, 0, 1, 1, 1},
        {0, 0, 1, 300, 2},
        {0, 0, 300, 1, 1},
        {-20, -7, 33, 17, 4},
        {1000, 5, 64, 16, 3},
        {3, -40, 19, 81, 7},
        {-1073741000, 1073741000, 5, 5, 1},
    };
    static const char *const names[] = {
        "R", "G", "B", "A", "left.Z", "a", "a name of more than thirty-one characters"};
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        size_t count = (size_t)cases[i].width * (size_t)cases[i].height;
        struct weft_image_channel channels[7] = {0};
        static const struct weft_image_attribute attributes[] = {
            {"owner", "string", "nobody", 6}, {"weft.kernel", "string", "catmull-rom", 11}};
        struct weft_image loaded, image = {
                                      .x = cases[i].x,
                                      .y = cases[i].y,
                                      .width = cases[i].width,
                                      .height = cases[i].height,
                                      .display_min = {-1, -2},
                                      .display_max = {99, 98},
                                      .channel_count = cases[i].channels,
                                      .channels = channels,
                                      .attribute_count = 2,
                                      .attributes = (struct weft_image_attribute *)attributes,
                                  };
        for (size_t c = 0; c < image.channel_count; c++) {
            snprintf(channels[c].name, sizeof channels[c].name, "%s", names[c]);
            channels[c].plane = malloc(count * sizeof(float));
            fill(channels[c].plane, count, (uint32_t)(i * 100 + c));
        }
        assert_int_equal(save(test_path("a.exr"), &image), WEFT_OK);
        assert_int_equal(load(test_path("a.exr"), &loaded), WEFT_OK);
        assert_int_equal(test_errors, 0);
        assert_int_equal(loaded.x, image.x);
        assert_int_equal(loaded.y, image.y);
        assert_int_equal(loaded.width, image.width);
        assert_int_equal(loaded.height, image.height);
        assert_memory_equal(loaded.display_min, image.display_min, sizeof image.display_min);
        assert_memory_equal(loaded.display_max, image.display_max, sizeof image.display_max);
        assert_int_equal(loaded.compression, WEFT_IMAGE_ZIP);
        assert_false(loaded.tiled);
        assert_int_equal(loaded.channel_count, image.channel_count);
        for (size_t c = 0; c < image.channel_count; c++) {
            size_t k = 0;
            while (k < loaded.channel_count && strcmp(loaded.channels[k].name, channels[c].name))
                k++;
            assert_true(k < loaded.channel_count);
            assert_int_equal(loaded.channels[k].type, WEFT_PIXEL_FLOAT);
            assert_memory_equal(loaded.channels[k].plane, channels[c].plane, count * 4);
            free(channels[c].plane);
        }
        for (size_t m = 0; m < 2; m++) {
            const struct weft_image_attribute *found = weft_image_find(&loaded, attributes[m].name);
            assert_non_null(found);
            assert_string_equal(found->type, "string");
            assert_int_equal(found->size, attributes[m].size);
            assert_memory_equal(found->data, attributes[m].data, found->size);
        }
        // What was loaded can be saved again, its reserved attributes included.
        assert_int_equal(save(test_path("b.exr"), &loaded), WEFT_OK);
        weft_image_clear(&loaded);
        weft_image_clear(&loaded);
    }
}

static void test_info_only(void **state)
{
    (void)state;
    float plane[4] = {1, 2, 3, 4};
    struct weft_image_channel channel = {.name = "Y", .plane = plane};
    struct weft_image loaded,
        image = {.width = 2, .height = 2, .channel_count = 1, .channels = &channel};
    assert_int_equal(save(test_path("a.exr"), &image), WEFT_OK);
    struct weft_image_load_params params = {.path = test_path("a.exr"), .info_only = true};
    assert_int_equal(weft_image_load(&params, &loaded), WEFT_OK);
    assert_int_equal(loaded.channel_count, 1);
    assert_null(loaded.channels[0].plane);
    assert_int_equal(loaded.display_max[0], 1); // unset: the data window
    weft_image_clear(&loaded);
}

static void test_bad_images(void **state)
{
    (void)state;
    float plane[4] = {0};
    struct weft_image_channel good[2] = {{.name = "Y", .plane = plane},
                                         {.name = "Z", .plane = plane}};
    struct weft_image_channel twins[2] = {good[0], good[0]};
    struct weft_image_channel empty[1] = {{.plane = plane}}, unplaned[1] = {{.name = "Y"}};
    struct weft_image_channel untyped[1] = {{.name = "Y", .plane = plane, .type = 9}};
    struct weft_image_channel integral[1] = {
        {.name = "Y", .plane = plane, .type = WEFT_PIXEL_UINT}};
    struct weft_image_channel subsampled[1] = {{.name = "Y", .plane = plane, .sampling = {2, 1}}};
    struct weft_image_attribute same_names[2] = {{"a", "string", "", 0}, {"a", "string", "", 0}};
    struct weft_image_attribute wrong_aspect[1] = {{"pixelAspectRatio", "double", plane, 8}};
    struct weft_image_attribute nameless[1] = {{"", "string", "", 0}};
    const struct weft_image cases[] = {
        {.width = 0, .height = 2, .channel_count = 1, .channels = good},
        {.width = 2, .height = -1, .channel_count = 1, .channels = good},
        {.x = INT32_MAX, .width = 2, .height = 2, .channel_count = 1, .channels = good},
        {.y = INT32_MIN, .width = 2, .height = 2, .channel_count = 1, .channels = good},
        {.width = 2, .height = 2, .channel_count = 0, .channels = good},
        {.width = 2, .height = 2, .channel_count = 1},
        {.width = 2, .height = 2, .channel_count = 2, .channels = twins},
        {.width = 2, .height = 2, .channel_count = 1, .channels = empty},
        {.width = 2, .height = 2, .channel_count = 1, .channels = unplaned},
        {.width = 2, .height = 2, .channel_count = 1, .channels = good, .attribute_count = 1},
        {.width = 2, .height = 2, .channel_count = 1, .channels = untyped},
        {.width = 2, .height = 2, .channel_count = 1, .channels = integral},
        {.width = 2, .height = 2, .channel_count = 1, .channels = subsampled},
        {.width = 2, .height = 2, .channel_count = 1, .channels = good, .compression = 11},
        {.width = 2, .height = 2, .channel_count = 1, .channels = good, .display_min = {0, 1}},
        {.width = 2,
         .height = 2,
         .channel_count = 1,
         .channels = good,
         .display_max = {INT32_MAX, 1}},
        {.width = 2,
         .height = 2,
         .channel_count = 1,
         .channels = good,
         .attribute_count = 2,
         .attributes = same_names},
        {.width = 2,
         .height = 2,
         .channel_count = 1,
         .channels = good,
         .attribute_count = 1,
         .attributes = wrong_aspect},
        {.width = 2,
         .height = 2,
         .channel_count = 1,
         .channels = good,
         .attribute_count = 1,
         .attributes = nameless},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        assert_int_equal(save(test_path("bad.exr"), &cases[i]), WEFT_ERR_ARGUMENT);
        assert_int_equal(test_errors, 1);
    }
    assert_int_equal(test_count_entries(test_folder), 2);
    struct weft_image image = {.width = 2, .height = 2, .channel_count = 2, .channels = good};
    assert_int_equal(save(test_path("missing/a.exr"), &image), WEFT_ERR_WRITE);
    assert_int_equal(save("/dev/full", &image), WEFT_ERR_WRITE);
    assert_int_equal(test_errors, 1);
    assert_int_equal(save(NULL, &image), WEFT_ERR_ARGUMENT);
    image.compression = WEFT_IMAGE_DWAA;
    assert_int_equal(save(test_path("bad.exr"), &image), WEFT_ERR_UNSUPPORTED);
    assert_non_null(strstr(test_message, "dwaa"));
}

// ---- every kind of file -------------------------------------------------------------------------

static float half_value(uint16_t bits)
{
    int exponent = bits >> 10 & 31, fraction = bits & 1023;
    float value = exponent == 31  ? (fraction ? NAN : INFINITY)
                  : exponent == 0 ? ldexpf((float)fraction, -24)
                                  : ldexpf((float)(1024 + fraction), exponent - 25);
    return bits & 0x8000 ? -value : value;
}

static float stored_value(exr_pixel_type_t type, const void *pixels, size_t i)
{
    float value;
    if (type == EXR_PIXEL_HALF)
        return half_value(((const uint16_t *)pixels)[i]);
    if (type == EXR_PIXEL_UINT)
        return (float)((const uint32_t *)pixels)[i];
    memcpy(&value, (const char *)pixels + 4 * i, sizeof value);
    return value;
}

// PXR24 keeps 24 bits of a float; B44 rounds halves in blocks of 4 x 4, so it is given constant
// ones.
static bool same(exr_compression_t compression, exr_pixel_type_t type, float stored, float loaded)
{
    if (isnan(stored))
        return isnan(loaded);
    if (compression == EXR_COMPRESSION_PXR24 && type == EXR_PIXEL_FLOAT)
        return stored == loaded || fabsf(stored - loaded) <= ldexpf(fabsf(stored), -15) + 0x1p-141f;
    return stored == loaded;
}

static void fill_pixels(uint32_t *pixels, const struct exr_recipe *r)
{
    uint32_t seed = 1;
    bool constant = r->type == EXR_PIXEL_HALF && (r->compression == EXR_COMPRESSION_B44 ||
                                                  r->compression == EXR_COMPRESSION_B44A);
    for (int i = 0; i < PIXELS + 1; i++)
        pixels[i] = constant ? 0x3c003c00 : i % 5 ? next_random(&seed) : 0;
}

static const char *const storage_names[] = {"scanline", "tiled", "deep scanline", "deep tiled"};

static void check_kind(const struct exr_recipe *r)
{
    struct weft_image image;
    if (load(r->path, &image) != WEFT_OK)
        fail_msg("compression %d, type %d, %s, order %d: %s", (int)r->compression, (int)r->type,
                 storage_names[r->storage], (int)r->order, test_message);
    assert_int_equal(image.x, r->x);
    assert_int_equal(image.y, r->y);
    assert_int_equal(image.width, r->width);
    assert_int_equal(image.height, r->height);
    assert_int_equal(image.tiled, r->storage == EXR_STORAGE_TILED);
    assert_int_equal(image.channel_count, 1);
    for (size_t i = 0; i < PIXELS; i++) {
        float stored = stored_value(r->type, r->pixels, i), loaded = image.channels[0].plane[i];
        if (r->type == EXR_PIXEL_UINT)
            assert_int_equal(image.channels[0].integers[i], ((const uint32_t *)r->pixels)[i]);
        if (!same(r->compression, r->type, stored, loaded))
            fail_msg("%s, compression %s, type %s, order %d: pixel %zu is %.9g, not %.9g",
                     storage_names[r->storage], weft_image_compression_names[image.compression],
                     weft_pixel_type_names[image.channels[0].type], (int)r->order, i, loaded,
                     stored);
    }
    weft_image_clear(&image);
}

// Rows from anywhere on are those of the whole.
static void check_rows(const char *path, int width, int height)
{
    const int rows[][2] = {{0, 1}, {height - 1, 1}, {5, height - 7}, {15, 2}, {16, 16}};
    struct weft_image whole, image;
    assert_int_equal(load(path, &whole), WEFT_OK);
    assert_int_equal(whole.rows, height);
    for (size_t i = 0; i < WEFT_COUNT(rows) * whole.channel_count; i++) {
        const int *r = rows[i / whole.channel_count];
        const struct weft_image_load_params params = {
            .path = path, .first_row = r[0], .rows = r[1], .log = &test_log};
        const size_t first = (size_t)(r[0] * width), count = (size_t)(r[1] * width);
        assert_int_equal(weft_image_load(&params, &image), WEFT_OK);
        assert_int_equal(image.height, height);
        assert_int_equal(image.first_row, r[0]);
        assert_int_equal(image.rows, r[1]);
        const struct weft_image_channel *one = &image.channels[i % whole.channel_count],
                                        *all = &whole.channels[i % whole.channel_count];
        assert_memory_equal(one->plane, all->plane + first, 4 * count);
        if (all->integers)
            assert_memory_equal(one->integers, all->integers + first, 4 * count);
        weft_image_clear(&image);
    }
    weft_image_clear(&whole);
}

static void test_rows_that_are_not_there(void **state)
{
    static const int rows[][2] = {{0, HEIGHT + 1}, {HEIGHT, 1}, {-1, 2}, {3, 0}, {3, -1}};
    static uint32_t pixels[PIXELS + 1];
    const struct exr_recipe r = {.path = test_path("rows.exr"),
                                 .type = EXR_PIXEL_FLOAT,
                                 .width = WIDTH,
                                 .height = HEIGHT,
                                 .pixels = pixels};
    struct weft_image image;
    (void)state;
    assert_int_equal(exr_make(&r), EXR_ERR_SUCCESS);
    for (size_t i = 0; i < WEFT_COUNT(rows); i++) {
        const struct weft_image_load_params params = {
            .path = r.path, .first_row = rows[i][0], .rows = rows[i][1], .log = &test_log};
        assert_int_equal(weft_image_load(&params, &image), WEFT_ERR_ARGUMENT);
        assert_non_null(strstr(test_message, "rows.exr: there are no"));
        assert_null(image.channels);
    }
}

static void test_kinds(void **state)
{
    (void)state;
    static uint32_t pixels[PIXELS + 1];
    int kinds = 0;
    for (int compression = 0; compression < EXR_COMPRESSION_DWAA; compression++) {
        for (int type = 0; type < EXR_PIXEL_LAST_TYPE; type++) {
            for (int tiled = 0; tiled < 2; tiled++) {
                for (int order = 0; order < 2 + tiled; order++) {
                    struct exr_recipe r = {
                        .path = test_path("kind.exr"),
                        .storage = tiled ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE,
                        .compression = compression,
                        .type = type,
                        .order = order,
                        .x = -5,
                        .y = -33,
                        .width = WIDTH,
                        .height = HEIGHT,
                        .tile_width = 20,
                        .tile_height = 16,
                        .pixels = pixels,
                    };
                    fill_pixels(pixels, &r);
                    assert_int_equal(exr_make(&r), EXR_ERR_SUCCESS);
                    check_kind(&r);
                    if (order == (type + compression) % 2)
                        check_rows(r.path, WIDTH, HEIGHT);
                    kinds++;
                }
            }
        }
    }
    print_message("%d kinds of files\n", kinds);
}

static void test_first_of_two_parts(void **state)
{
    (void)state;
    static uint32_t pixels[PIXELS + 1];
    struct exr_recipe r = {
        .path = test_path("parts.exr"),
        .type = EXR_PIXEL_FLOAT,
        .compression = EXR_COMPRESSION_ZIP,
        .width = WIDTH,
        .height = HEIGHT,
        .parts = 2,
        .pixels = pixels,
    };
    fill_pixels(pixels, &r);
    assert_int_equal(exr_make(&r), EXR_ERR_SUCCESS);
    check_kind(&r);
}

static void test_unsupported(void **state)
{
    (void)state;
    static const uint32_t pixels[PIXELS + 1];
    static const struct {
        struct exr_recipe recipe;
        const char *message;
    } cases[] = {
        {{.storage = EXR_STORAGE_DEEP_SCANLINE}, "deep"},
        {{.storage = EXR_STORAGE_DEEP_TILED, .tile_width = 8, .tile_height = 8}, "deep"},
        {{.sampling = 2, .type = EXR_PIXEL_HALF}, "channel V is subsampled (2 x 2)"},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct exr_recipe r = cases[i].recipe;
        struct weft_image image;
        r.path = test_path("unsupported.exr");
        r.width = 8;
        r.height = 8;
        r.pixels = pixels;
        exr_make(&r); // the header suffices
        assert_int_equal(load(r.path, &image), WEFT_ERR_UNSUPPORTED);
        assert_int_equal(test_errors, 1);
        if (!strstr(test_message, cases[i].message))
            fail_msg("\"%s\" does not say \"%s\"", test_message, cases[i].message);
        struct weft_image_load_params params = {.path = r.path, .info_only = true};
        assert_int_equal(weft_image_load(&params, &image), WEFT_OK);
        assert_int_equal(image.deep, r.storage >= EXR_STORAGE_DEEP_SCANLINE);
        assert_int_equal(image.tiled, r.storage == EXR_STORAGE_DEEP_TILED);
        assert_int_equal(image.channels[0].sampling[0], r.sampling ? r.sampling : 1);
        weft_image_clear(&image);
    }
}

// ---- DWA, which OpenEXR's C++ library alone reads and writes ------------------------------------

// Lossy for halves of some channel names, lossless for others: both must be what the library reads.
static void test_dwa(void **state)
{
    (void)state;
    static const enum weft_image_compression kinds[] = {WEFT_IMAGE_DWAA, WEFT_IMAGE_DWAB};
    static float planes[2][PIXELS];
    static uint32_t ids[PIXELS];
    char why[400];
    for (int i = 0; i < PIXELS; i++) {
        planes[0][i] = sinf(0.1f * (float)(i % WIDTH)) + 1.0f;
        planes[1][i] = (float)i;
        ids[i] = UINT32_MAX - (uint32_t)i;
    }
    struct weft_image_channel channels[] = {
        {.name = "R", .type = WEFT_PIXEL_HALF, .plane = planes[0]},
        {.name = "Z", .type = WEFT_PIXEL_FLOAT, .plane = planes[1]},
        {.name = "id", .type = WEFT_PIXEL_UINT, .integers = ids}};
    for (size_t k = 0; k < 4; k++) {
        const char *path = test_path("dwa.exr");
        struct weft_image loaded, image = {.x = -3,
                                           .y = 7,
                                           .width = WIDTH,
                                           .height = HEIGHT,
                                           .compression = kinds[k % 2],
                                           .channel_count = 3,
                                           .channels = channels};
        if (!exr_peer_write(path, &image, 1, k < 2 ? 0 : 16, why, sizeof why))
            fail_msg("%s", why);
        if (load(path, &loaded) != WEFT_OK)
            fail_msg("%s", test_message);
        assert_int_equal(loaded.compression, kinds[k % 2]);
        assert_int_equal(loaded.channel_count, 3);
        for (size_t c = 0; c < 2; c++) {
            float *values = exr_peer_values(path, channels[c].name, why, sizeof why);
            assert_non_null(values);
            assert_memory_equal(values, loaded.channels[c].plane, sizeof planes[c]);
            free(values);
        }
        assert_memory_equal(loaded.channels[1].plane, planes[1], sizeof planes[1]);
        assert_memory_equal(loaded.channels[2].integers, ids, sizeof ids);
        for (int i = 0; i < PIXELS; i++)
            assert_true(fabsf(loaded.channels[0].plane[i] - planes[0][i]) < 0.05f);
        weft_image_clear(&loaded);
        check_rows(path, WIDTH, HEIGHT);

        size_t size;
        char *file = test_read_file(path, &size);
        test_write_file(test_path("cut.exr"), file, size - size / 3);
        enum weft_result res = load(test_path("cut.exr"), &loaded);
        assert_true(res == WEFT_ERR_FORMAT);
        assert_int_equal(test_errors, 1);
        uint32_t seed = (uint32_t)k;
        for (int i = 0; i < 25; i++) {
            const size_t where = next_random(&seed) % size;
            const char old = file[where];
            file[where] = (char)next_random(&seed);
            test_write_file(test_path("changed.exr"), file, size);
            file[where] = old;
            res = load(test_path("changed.exr"), &loaded);
            assert_int_equal(test_errors, res == WEFT_OK ? 0 : 1);
            weft_image_clear(&loaded);
        }
        free(file);
    }
}

// ---- files that are none ------------------------------------------------------------------------

static void test_no_file(void **state)
{
    (void)state;
    struct weft_image image;
    assert_int_equal(load(test_path("missing.exr"), &image), WEFT_ERR_OPEN);
    assert_non_null(strstr(test_message, "No such file or directory"));
    assert_int_equal(load(test_folder, &image), WEFT_ERR_OPEN);
    assert_non_null(strstr(test_message, "Is a directory"));
    assert_int_equal(mkfifo(test_path("pipe"), 0600), 0);
    assert_int_equal(load(test_path("pipe"), &image), WEFT_ERR_OPEN);
    assert_non_null(strstr(test_message, "not a regular file"));
    test_write_file(test_path("empty.exr"), "", 0);
    assert_int_equal(load(test_path("empty.exr"), &image), WEFT_ERR_FORMAT);
    assert_non_null(strstr(test_message, "empty"));
    assert_int_equal(load(NULL, &image), WEFT_ERR_ARGUMENT);
}

static void test_cut_and_changed_files(void **state)
{
    (void)state;
    static uint32_t pixels[PIXELS + 1];
    struct exr_recipe r = {
        .path = test_path("whole.exr"),
        .type = EXR_PIXEL_FLOAT,
        .compression = EXR_COMPRESSION_ZIP,
        .width = WIDTH,
        .height = HEIGHT,
        .pixels = pixels,
    };
    fill_pixels(pixels, &r);
    assert_int_equal(exr_make(&r), EXR_ERR_SUCCESS);
    size_t size;
    char *whole = test_read_file(test_path("whole.exr"), &size);
    struct weft_image image;
    for (size_t i = 0; i < 40; i++) {
        test_write_file(test_path("cut.exr"), whole, size * i / 40);
        enum weft_result res = load(test_path("cut.exr"), &image);
        assert_int_equal(test_errors, 1);
        assert_int_equal(res, WEFT_ERR_FORMAT);
    }
    uint32_t seed = 3;
    for (int i = 0; i < 60; i++) {
        char old = whole[0];
        size_t where = next_random(&seed) % (i % 2 ? size : 400);
        old = whole[where];
        whole[where] = (char)next_random(&seed);
        test_write_file(test_path("changed.exr"), whole, size);
        whole[where] = old;
        enum weft_result res = load(test_path("changed.exr"), &image);
        assert_int_equal(test_errors, res == WEFT_OK ? 0 : 1);
        weft_image_clear(&image);
    }
    for (int i = 0; i < 10; i++) {
        for (size_t k = 8; k < 500; k++)
            whole[k] = (char)next_random(&seed);
        test_write_file(test_path("random.exr"), whole, 500);
        assert_int_not_equal(load(test_path("random.exr"), &image), WEFT_OK);
        assert_int_equal(test_errors, 1);
    }
    free(whole);
}

static void test_limits(void **state)
{
    (void)state;
    static uint32_t pixels[PIXELS + 1];
    struct exr_recipe r = {.path = test_path("big.exr"),
                           .type = EXR_PIXEL_FLOAT,
                           .width = WIDTH,
                           .height = HEIGHT,
                           .pixels = pixels};
    assert_int_equal(exr_make(&r), EXR_ERR_SUCCESS);
    struct weft_image image;
    struct weft_image_load_params params = {
        .path = test_path("big.exr"), .limits = {.output_bytes = PIXELS * 4 - 1}, .log = &test_log};
    test_forget();
    assert_int_equal(weft_image_load(&params, &image), WEFT_ERR_LIMIT);
    assert_int_equal(test_errors, 1);
    assert_non_null(strstr(test_message, "6660"));
    assert_non_null(strstr(test_message, "6659"));
    params.limits.output_bytes++;
    assert_int_equal(weft_image_load(&params, &image), WEFT_OK);
    weft_image_clear(&image);

    // A header that declares 2 GiB in 16 scan lines; the chunk table is all there is.
    r = (struct exr_recipe){.path = test_path("bomb.exr"),
                            .type = EXR_PIXEL_FLOAT,
                            .storage = EXR_STORAGE_SCANLINE,
                            .compression = EXR_COMPRESSION_ZIP,
                            .width = 1 << 25,
                            .height = 16,
                            .pixels = NULL,
                            .sampling = 1};
    static const char marker[] = "dataWindow\0box2i\0\20\0\0\0";
    struct exr_recipe small = r;
    small.width = 2;
    small.pixels = pixels;
    small.path = test_path("bomb.exr");
    assert_int_equal(exr_make(&small), EXR_ERR_SUCCESS);
    size_t size;
    char *file = test_read_file(small.path, &size);
    char *window = memmem(file, size, marker, sizeof marker - 1);
    assert_non_null(window);
    int32_t last = r.width - 1;
    memcpy(window + sizeof marker - 1 + 8, &last, sizeof last);
    test_write_file(small.path, file, size);
    free(file);
    params = (struct weft_image_load_params){.path = test_path("bomb.exr"), .log = &test_log};
    test_forget();
    assert_int_equal(weft_image_load(&params, &image), WEFT_ERR_LIMIT);
    assert_non_null(strstr(test_message, "2147483648 bytes are declared"));
}

#define IN_FOLDER(name) cmocka_unit_test_setup_teardown(name, test_enter_folder, test_leave_folder)

int main(void)
{
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 1);
    const struct CMUnitTest tests[] = {
        IN_FOLDER(test_round_trip),
        IN_FOLDER(test_info_only),
        IN_FOLDER(test_bad_images),
        IN_FOLDER(test_kinds),
        IN_FOLDER(test_rows_that_are_not_there),
        IN_FOLDER(test_first_of_two_parts),
        IN_FOLDER(test_unsupported),
        IN_FOLDER(test_dwa),
        IN_FOLDER(test_no_file),
        IN_FOLDER(test_cut_and_changed_files),
        IN_FOLDER(test_limits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
