// SPDX-License-Identifier: BSD-3-Clause
// What weft resample, weft slice and weft info do with EXR files: attributes, types, compression,
// parts.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>
#include <jansson.h>
#include <math.h>

#include "tests/support/command.h"
#include "tests/support/json.h"
#include "tests/support/exr_peer.h"
#include "filter/half.h"
#include "weft.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))

#define skip_without_gl()                                                                          \
    do {                                                                                           \
        if (!command_has_gl())                                                                     \
            skip();                                                                                \
    } while (0)

enum { WIDTH = 16, HEIGHT = 12, PIXELS = WIDTH * HEIGHT };

static void load(const char *path, int part, struct weft_image *image)
{
    const struct weft_image_load_params params = {.path = path, .part = part};
    assert_int_equal(weft_image_load(&params, image), WEFT_OK);
}

static void save(const char *path, const struct weft_image *image)
{
    const struct weft_image_save_params params = {.path = path};
    assert_int_equal(weft_image_save(image, &params), WEFT_OK);
}

static float plane[PIXELS];

static struct weft_image_channel grey = {.name = "Y", .plane = plane};

static struct weft_image picture(void)
{
    for (int i = 0; i < PIXELS; i++)
        plane[i] = 0.5f + 0.5f * sinf(0.7f * (float)i);
    return (struct weft_image){
        .width = WIDTH, .height = HEIGHT, .channel_count = 1, .channels = &grey};
}

// `weft ...` succeeds and says `text` on stderr; NULL: says nothing.
static void assert_warns(const char *text, const char *const *argv)
{
    static struct command_result result;
    command_run_list(&result, argv);
    if (result.code != 0 || (text ? strstr(result.err, text) == NULL : result.err[0] != 0))
        fail_msg("code %d, \"%s\" instead of \"%s\"", result.code, result.err, text ? text : "");
}

// ---- attributes ---------------------------------------------------------------------------------

static void attributes_are_kept_or_corrected(void **state)
{
    (void)state;
    skip_without_gl();
    static char manifest[12291], long_names[2][256];
    memset(manifest, 'm', sizeof manifest);
    for (int i = 0; i < 2; i++) {
        memset(long_names[i], 'k', 255);
        long_names[i][254] = (char)('1' + i);
    }
    static const unsigned char two[] = {0, 0, 0, 0x40}, density[] = {0, 0, 0x90, 0x42};
    static const unsigned char bytes[32] = {1, 2, 3, 4, 5, 6, 7, 8};
    struct weft_image_attribute attributes[] = {
        {"pixelAspectRatio", "float", two, 4},
        {"xDensity", "float", density, 4}, // 72
        {"weft.kernel", "string", "an earlier one", 14},
        {"screenWindowWidth", "float", two, 4},
        {"screenWindowCenter", "v2f", bytes, 8},
        {"chromaticities", "chromaticities", bytes, 32},
        {"timeCode", "timecode", bytes, 8},
        {"multiView", "stringvector", "\4\0\0\0left", 8},
        {"manifest", "string", manifest, sizeof manifest},
        {long_names[0], "string", "first", 5},
        {long_names[1], "string", "second", 6},
        {"ours", "a type nobody knows", bytes, 13},
    };
    struct weft_image out, image = picture();
    image.attributes = attributes;
    image.attribute_count = COUNT(attributes);
    save("in.exr", &image);
    command_succeeds("resample", "in.exr", "-o", "out.exr", "--size", "32x12", "--verify");
    load("out.exr", 0, &out);
    for (size_t i = 3; i < COUNT(attributes); i++) {
        const struct weft_image_attribute *found = weft_image_find(&out, attributes[i].name);
        if (!found)
            fail_msg("no %s", attributes[i].name);
        assert_string_equal(found->type, attributes[i].type);
        assert_int_equal(found->size, attributes[i].size);
        assert_memory_equal(found->data, attributes[i].data, found->size);
    }
    char text[100];
    // Twice as many pixels along x: each is half as wide, and there are twice as many an inch.
    weft_image_attribute_format(weft_image_find(&out, "pixelAspectRatio"), text, sizeof text);
    assert_string_equal(text, "1");
    weft_image_attribute_format(weft_image_find(&out, "xDensity"), text, sizeof text);
    assert_string_equal(text, "144");
    weft_image_attribute_format(weft_image_find(&out, "weft.kernel"), text, sizeof text);
    assert_string_equal(text, "catmull-rom");
    weft_image_clear(&out);
    json_t *info = parse(command_succeeds("info", "out.exr", "--json"));
    const json_t *value = json_object_get(json_object_get(info, "metadata"), "manifest");
    assert_int_equal(json_string_length(value), sizeof manifest);
    json_decref(info);
    assert_non_null(strstr(command_succeeds("info", "out.exr"), "... (12291 bytes)"));
}

// ---- types --------------------------------------------------------------------------------------

static void halves_stay_halves(void **state)
{
    (void)state;
    skip_without_gl();
    struct weft_image half, whole, image = picture();
    grey.type = WEFT_PIXEL_HALF;
    save("half.exr", &image);
    grey.type = WEFT_PIXEL_FLOAT;
    json_t *root =
        parse(command_succeeds("resample", "half.exr", "-o", "h.exr", "--verify", "--json"));
    const json_t *file = json_object_get(root, "file");
    assert_true(number(file, "values") == 4 * PIXELS && number(file, "verified") == 4 * PIXELS);
    assert_true(number(file, "rounding") > 0.0 && number(file, "rounding") <= 0x1p-11);
    json_decref(root);
    assert_non_null(strstr(
        command_succeeds("resample", "half.exr", "-o", "f.exr", "--type", "float", "--verify"),
        "f.exr: read back, all 768 values are those computed\n"));
    load("h.exr", 0, &half);
    load("f.exr", 0, &whole);
    assert_int_equal(half.channels[0].type, WEFT_PIXEL_HALF);
    assert_int_equal(whole.channels[0].type, WEFT_PIXEL_FLOAT);
    int rounded = 0;
    for (int i = 0; i < 4 * PIXELS; i++) {
        const float value = whole.channels[0].plane[i];
        assert_true(half.channels[0].plane[i] == weft_half_to_float(weft_half_from_float(value)));
        rounded += half.channels[0].plane[i] != value;
    }
    assert_true(rounded > 0);
    weft_image_clear(&half);
    weft_image_clear(&whole);
}

static void overflows_of_halves_are_told(void **state)
{
    (void)state;
    skip_without_gl();
    struct weft_image image = picture();
    for (int i = 0; i < PIXELS; i++)
        plane[i] = i % WIDTH < WIDTH / 2 ? 0.0f : 65000.0f; // catmull-rom overshoots by 7 %
    grey.type = WEFT_PIXEL_HALF;
    save("high.exr", &image);
    grey.type = WEFT_PIXEL_FLOAT;
    assert_warns("values are beyond 65504",
                 (const char *[]){"weft", "resample", "high.exr", "-o", "h.exr", NULL});
    assert_warns(NULL, (const char *[]){"weft", "resample", "high.exr", "-o", "h.exr", "--type",
                                        "float", NULL});
}

// Each compression and type holds what the plain file does, halves rounded.
static void slices_have_types(void **state)
{
    (void)state;
    skip_without_gl();
    struct weft_image plain, image;
    int files = 0;
    command_succeeds("make", "marschner-lobb", "--size", "20", "-o", "ml20.vdb");
    command_succeeds("slice", "ml20.vdb", "--size", "61x45", "-o", "plain.exr");
    load("plain.exr", 0, &plain);
    assert_int_equal(plain.compression, WEFT_IMAGE_ZIP);
    assert_int_equal(plain.channels[0].type, WEFT_PIXEL_FLOAT);
    for (int c = 0; weft_image_is_writable((enum weft_image_compression)c); c++) {
        for (int t = WEFT_PIXEL_FLOAT; t <= WEFT_PIXEL_HALF; t++, files++) {
            command_succeeds("slice", "ml20.vdb", "--size", "61x45", "-o", "typed.exr",
                             "--compression", weft_image_compression_names[c], "--type",
                             weft_pixel_type_names[t], "--verify");
            load("typed.exr", 0, &image);
            assert_int_equal(image.compression, c);
            assert_int_equal(image.channels[0].type, t);
            for (int i = 0; i < 61 * 45; i++) {
                const float value = plain.channels[0].plane[i];
                const float half = weft_half_to_float(weft_half_from_float(value));
                assert_true(image.channels[0].plane[i] == (t == WEFT_PIXEL_HALF ? half : value));
            }
            weft_image_clear(&image);
        }
    }
    assert_int_equal(files, 10);
    weft_image_clear(&plain);
    // A level set of three voxels, which are wide.
    command_succeeds("make", "sphere", "--size", "20", "--voxel", "1e5", "-o", "wide.vdb");
    assert_warns("values are beyond 65504",
                 (const char *[]){"weft", "slice", "wide.vdb", "--size", "40x40", "-o", "h.exr",
                                  "--type", "half", NULL});
    assert_warns(NULL, (const char *[]){"weft", "slice", "wide.vdb", "--size", "40x40", "-o",
                                        "h.exr", NULL});
    command_fails(2, "'uint' is not one of: float, half", "slice", "ml20.vdb", "-o", "no.exr",
                  "--type", "uint");
    command_fails(2, "--compression: 'dwaa' is not one of", "slice", "ml20.vdb", "-o", "no.exr",
                  "--compression", "dwaa");
    command_fails(2, "--type and --compression need -o OUT.exr", "slice", "ml20.vdb", "--verify",
                  "--type", "half");
    command_fails(2, "--compression needs -o OUT.exr", "resample", "plain.exr", "--verify",
                  "--compression", "none");
}

static uint32_t integers[PIXELS];

static void save_integers(const char *path)
{
    static struct weft_image_channel channel = {
        .name = "id", .type = WEFT_PIXEL_UINT, .integers = integers};
    const struct weft_image image = {.x = 3,
                                     .y = -2,
                                     .width = WIDTH,
                                     .height = HEIGHT,
                                     .display_min = {3, -2},
                                     .display_max = {WIDTH + 2, HEIGHT - 3},
                                     .channel_count = 1,
                                     .channels = &channel};
    uint32_t random = 7;
    for (int i = 0; i < PIXELS; i++) {
        random = random * 1664525u + 1013904223u;
        integers[i] = random | 0x80000001u; // odd and over 2^31: no float holds it
    }
    save(path, &image);
}

static void integers_are_exact_with_nearest(void **state)
{
    (void)state;
    static const int sizes[][2] = {{16, 12}, {32, 24}, {48, 36}, {19, 31}, {8, 6}, {1, 1}, {97, 3}};
    save_integers("ids.exr");
    for (size_t s = 0; s < COUNT(sizes); s++) {
        const int width = sizes[s][0], height = sizes[s][1];
        char size[40];
        struct weft_image out;
        snprintf(size, sizeof size, "%dx%d", width, height);
        json_t *root =
            parse(command_succeeds("resample", "ids.exr", "-o", "out.exr", "--kernel", "nearest",
                                   "--verify", "--json", "-q", "--size", size));
        const json_t *group = json_array_get(json_object_get(root, "groups"), 0);
        assert_true(number(json_object_get(group, "error"), "max") == 0.0);
        assert_true(number(group, "bound") == 0.0);
        assert_true(number(json_object_get(root, "file"), "verified") == width * height);
        json_decref(root);
        load("out.exr", 0, &out);
        assert_int_equal(out.channels[0].type, WEFT_PIXEL_UINT);
        assert_int_equal(out.width, width);
        for (int y = 0; y < height; y++)
            for (int x = 0; x < width; x++) {
                // The pixel in whose square the centre lies, the later one where two meet.
                const int column = (2 * x + 1) * WIDTH / (2 * width);
                const int row = (2 * y + 1) * HEIGHT / (2 * height);
                assert_int_equal(out.channels[0].integers[y * width + x],
                                 integers[row * WIDTH + column]);
            }
        weft_image_clear(&out);
    }
}

static void filtered_integers_are_warned_of(void **state)
{
    (void)state;
    skip_without_gl();
    struct weft_image out;
    save_integers("ids.exr");
    assert_warns("id: 192 of its integers are no floats",
                 (const char *[]){"weft", "resample", "ids.exr", "-o", "out.exr", NULL});
    load("out.exr", 0, &out);
    assert_int_equal(out.channels[0].type, WEFT_PIXEL_FLOAT);
    weft_image_clear(&out);
    assert_warns("192 of its integers are no floats",
                 (const char *[]){"weft", "resample", "ids.exr", "-o", "out.exr", "--kernel",
                                  "nearest", "--type", "float", NULL});
    // Few and small: nothing to warn of.
    struct weft_image image = picture();
    for (int i = 0; i < PIXELS; i++)
        integers[i] = (uint32_t)i;
    struct weft_image_channel channel = {
        .name = "n", .type = WEFT_PIXEL_UINT, .integers = integers};
    image.channels = &channel;
    save("small.exr", &image);
    assert_warns(NULL, (const char *[]){"weft", "resample", "small.exr", "-o", "out.exr", NULL});
    assert_warns("are negative, too large", (const char *[]){"weft", "resample", "small.exr", "-o",
                                                             "out.exr", "--type", "uint", NULL});
}

// ---- compression --------------------------------------------------------------------------------

static void compression_is_kept(void **state)
{
    (void)state;
    skip_without_gl();
    static const enum weft_image_compression kept[] = {
        WEFT_IMAGE_NONE, WEFT_IMAGE_RLE, WEFT_IMAGE_ZIPS, WEFT_IMAGE_PIZ, WEFT_IMAGE_ZIP};
    char why[300];
    struct weft_image out, image = picture();
    for (size_t i = 0; i < COUNT(kept); i++) {
        image.compression = kept[i];
        save("in.exr", &image);
        assert_warns(NULL, (const char *[]){"weft", "resample", "in.exr", "-o", "out.exr", NULL});
        load("out.exr", 0, &out);
        assert_int_equal(out.compression, kept[i]);
        weft_image_clear(&out);
    }
    command_succeeds("resample", "in.exr", "-o", "out.exr", "--compression", "rle");
    load("out.exr", 0, &out);
    assert_int_equal(out.compression, WEFT_IMAGE_RLE);
    weft_image_clear(&out);
    image.compression = WEFT_IMAGE_DWAB;
    assert_true(exr_peer_write("dwa.exr", &image, 1, 8, why, sizeof why));
    assert_warns("not kept: compression dwab (zip is written)",
                 (const char *[]){"weft", "resample", "dwa.exr", "-o", "out.exr", NULL});
}

// ---- parts --------------------------------------------------------------------------------------

static void all_parts_are_resampled(void **state)
{
    (void)state;
    skip_without_gl();
    char why[300];
    struct weft_image_channel depth = {.name = "Z", .plane = plane};
    struct weft_image out, parts[3] = {picture(), picture(), picture()};
    parts[1].x = 2;
    parts[1].width = WIDTH / 2;
    parts[2].deep = true;
    static const char *const names[] = {"beauty", "depth", "deep"};
    for (int p = 0; p < 3; p++)
        snprintf(parts[p].name, sizeof parts[p].name, "%s", names[p]);
    for (int p = 0; p < 3; p++) {
        parts[p].display_max[0] = WIDTH - 1;
        parts[p].display_max[1] = HEIGHT - 1;
    }
    assert_true(exr_peer_write("parts.exr", parts, 3, 0, why, sizeof why));
    parts[1].channels = &depth;
    assert_true(exr_peer_write("layers.exr", parts, 2, 0, why, sizeof why));
    char *info = strdup(command_succeeds("info", "parts.exr"));
    assert_non_null(strstr(info, "parts.exr: OpenEXR, 3 parts\npart 0 'beauty': 16 x 12 pixels"));
    assert_non_null(strstr(info, "part 2 'deep': 16 x 12 pixels, 1 channel, deep scanline"));
    free(info);

    assert_warns("not kept: deep parts, which weft does not filter: 2 'deep'",
                 (const char *[]){"weft", "resample", "parts.exr", "-o", "out.exr", NULL});
    for (int p = 0; p < 2; p++) {
        load("out.exr", p, &out);
        assert_int_equal(out.part_count, 2);
        assert_string_equal(out.name, names[p]);
        assert_int_equal(out.x, 2 * parts[p].x);
        assert_int_equal(out.width, 2 * parts[p].width);
        assert_int_equal(out.height, 2 * HEIGHT);
        out.part = p;
        if (!exr_peer_agrees("out.exr", &out, why, sizeof why))
            fail_msg("%s", why);
        weft_image_clear(&out);
    }
    static const char *const chosen[] = {"depth", "1"};
    for (size_t i = 0; i < COUNT(chosen); i++) {
        assert_warns(NULL, (const char *[]){"weft", "resample", "parts.exr", "-o", "out.exr",
                                            "--part", chosen[i], NULL});
        load("out.exr", 0, &out);
        assert_int_equal(out.part_count, 1);
        assert_string_equal(out.name, "depth");
        weft_image_clear(&out);
    }
    // A part that has none of the channels is not asked for.
    command_succeeds("resample", "layers.exr", "-o", "out.exr", "--channels", "Z", "-q");
    load("out.exr", 0, &out);
    assert_int_equal(out.part_count, 1);
    assert_string_equal(out.name, "depth");
    weft_image_clear(&out);
    command_fails(2, "no channel 'W'; there are Y, Z", "resample", "layers.exr", "-o", "out2.exr",
                  "--channels", "Z,W");
    json_t *root = parse(command_succeeds("resample", "parts.exr", "--json", "--verify", "-q"));
    assert_int_equal(json_array_size(json_object_get(root, "parts")), 2);
    json_decref(root);
    root = parse(command_succeeds("info", "parts.exr", "--json"));
    assert_int_equal(json_array_size(json_object_get(root, "parts")), 3);
    json_decref(root);
    unlink("out.exr");
    command_fails(3, "deep images are unsupported", "resample", "parts.exr", "-o", "out.exr",
                  "--part", "deep");
    command_fails(2, "no part 'sky'; there are: 0 'beauty', 1 'depth', 2 'deep'", "resample",
                  "parts.exr", "-o", "out.exr", "--part", "sky");
    command_fails(2, "no part '3'", "resample", "parts.exr", "-o", "out.exr", "--part", "3");
}

static void slices_are_read_back(void **state)
{
    (void)state;
    skip_without_gl();
    assert_non_null(
        strstr(command_succeeds("slice", "ml.vdb", "-o", "s.exr", "--size", "40x30", "--verify"),
               "s.exr: read back, all 1200 values are those computed\n"));
}

static void png_files_are_told_of(void **state)
{
    (void)state;
    const struct weft_image image = picture();
    assert_int_equal(
        weft_preview_save(weft_preview_params(.path = "p.png", .width = WIDTH, .height = HEIGHT,
                                              .plane = image.channels[0].plane),
                          NULL),
        WEFT_OK);
    assert_non_null(
        strstr(command_succeeds("info", "p.png"), "p.png: PNG, 16 x 12 pixels, 8 bits"));
    json_t *root = parse(command_succeeds("info", "p.png", "--json"));
    assert_string_equal(json_string_value(json_object_get(root, "format")), "png");
    assert_int_equal(json_integer_value(json_object_get(root, "height")), HEIGHT);
    assert_int_equal(json_integer_value(json_object_get(root, "bits")), 8);
    assert_int_equal(json_array_size(json_object_get(root, "channels")), 1);
    json_decref(root);
    command_write_file("cut.png", "\x89PNG\r\n\x1a\n", 8);
    command_fails(3, "cut.png: it is cut short", "info", "cut.png");
    command_write_file("other", "GIF89a", 6);
    command_fails(3, "neither a VDB, an NRRD, a NIfTI, an EXR, a PNG nor a TIFF file", "info",
                  "other");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(attributes_are_kept_or_corrected),
        cmocka_unit_test(halves_stay_halves),
        cmocka_unit_test(overflows_of_halves_are_told),
        cmocka_unit_test(slices_have_types),
        cmocka_unit_test(integers_are_exact_with_nearest),
        cmocka_unit_test(filtered_integers_are_warned_of),
        cmocka_unit_test(compression_is_kept),
        cmocka_unit_test(all_parts_are_resampled),
        cmocka_unit_test(slices_are_read_back),
        cmocka_unit_test(png_files_are_told_of),
    };
    return cmocka_run_group_tests(tests, command_setup, command_teardown);
}
