// SPDX-License-Identifier: BSD-3-Clause
// EXR files that weft writes, read back by weft and by OpenEXR's C++ library, bit by bit.
// WEFT_IMAGES is the number of images (default 300).
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <float.h>
#include <math.h>

#include "tests/support/exr_peer.h"
#include "tests/support/files.h"
#include "filter/check.h"
#include "filter/half.h"
#include "tiles/image/exr/chunk.h"

static uint32_t random_state;

static uint32_t next_random(void)
{
    random_state = random_state * 1664525u + 1013904223u;
    return random_state >> 8 ^ random_state << 11;
}

static int between(int low, int high)
{
    return low + (int)(next_random() % (uint32_t)(high - low + 1));
}

static enum weft_result load(const char *path, int part, struct weft_image *out)
{
    struct weft_image_load_params params = {.path = path, .part = part, .log = &test_log};
    test_forget();
    return weft_image_load(&params, out);
}

static uint32_t bits_of(const struct weft_image_channel *channel, size_t i)
{
    uint32_t bits;
    float value;
    if (channel->type == WEFT_PIXEL_UINT)
        return channel->integers[i];
    value = channel->plane[i];
    if (channel->type == WEFT_PIXEL_HALF)
        value = weft_half_to_float(weft_half_from_float(value));
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static void assert_loads(const char *path, const struct weft_image *image)
{
    struct weft_image loaded;
    if (load(path, image->part, &loaded) != WEFT_OK)
        fail_msg("%s", test_message);
    assert_int_equal(loaded.channel_count, image->channel_count);
    assert_int_equal(loaded.compression, image->compression);
    for (size_t c = 0; c < image->channel_count; c++) {
        const struct weft_image_channel *a = &image->channels[c], *b = &loaded.channels[c];
        assert_string_equal(a->name, b->name);
        assert_int_equal(a->type, b->type);
        for (size_t i = 0; i < (size_t)image->width * (size_t)image->height; i++)
            if (bits_of(a, i) != bits_of(b, i))
                fail_msg("%s: value %zu of channel %s", path, i, a->name);
    }
    weft_image_clear(&loaded);
}

static void assert_read_by_all(const char *path, const struct weft_image *image, const char *what)
{
    char why[400];
    if (!exr_peer_agrees(path, image, why, sizeof why))
        fail_msg("%s: OpenEXR: %s", what, why);
    assert_loads(path, image);
}

// ---- images of many kinds -----------------------------------------------------------------------

enum { LARGEST = 300, CHANNELS = 3 };

struct picture {
    struct weft_image image;
    struct weft_image_channel channels[CHANNELS];
};

static float noise(uint32_t mask)
{
    const uint32_t bits = 0x3f000000 | (next_random() & mask);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

// What slices hold: smooth, with a constant beyond an edge.
static float smooth(int c, int x, int y, float scale)
{
    const float fx = scale * (float)x, fy = scale * (float)y;
    return fx * fx + fy * fy > 40.0f ? 0.0f : sinf(fx + (float)c) * cosf(fx * fy) + 0.5f;
}

struct photo {
    struct weft_image image;
    bool there;
};

static struct photo photos[3];

static int load_photos(void **state)
{
    static const char *const names[] = {"BrightRings.exr", "SquaresSwirls.exr", "GammaChart.exr"};
    (void)state;
    for (size_t i = 0; i < WEFT_COUNT(photos); i++) {
        char path[1024];
        snprintf(path, sizeof path, "%s/%s", WEFT_TEST_DATA, names[i]);
        photos[i].there = access(path, R_OK) == 0 && load(path, 0, &photos[i].image) == WEFT_OK;
        if (!photos[i].there)
            print_message("[  SKIPPED ] no %s in " WEFT_TEST_DATA "\n", names[i]);
    }
    return test_enter_folder(state);
}

static int drop_photos(void **state)
{
    for (size_t i = 0; i < WEFT_COUNT(photos); i++) {
        weft_image_clear(&photos[i].image);
        photos[i].there = false;
    }
    return test_leave_folder(state);
}

// A part of a photo at half the distance of its pixels, as resampling makes them.
static float photo_value(const struct photo *photo, int c, int x, int y)
{
    const struct weft_image *image = &photo->image;
    const float *plane = image->channels[(size_t)c % image->channel_count].plane;
    const int x0 = x / 2 % (image->width - 1), y0 = y / 2 % image->height;
    const float *at = plane + (size_t)y0 * (size_t)image->width + x0;
    return x % 2 ? 0.5f * (at[0] + at[1]) : at[0];
}

static void fill(struct picture *p, int c, int kind)
{
    struct weft_image_channel *channel = &p->channels[c];
    const int width = p->image.width, height = p->image.height;
    const uint32_t mask = (UINT32_C(1) << between(1, 23)) - 1;
    const float scale = 0.01f * (float)between(1, 30);
    const struct photo *photo = &photos[between(0, (int)WEFT_COUNT(photos) - 1)];
    for (int i = 0; i < width * height; i++) {
        const int x = i % width, y = i / width;
        const float value = kind == 0                    ? noise(mask)
                            : kind == 1 || !photo->there ? smooth(c, x, y, scale)
                                                         : photo_value(photo, c, x, y);
        if (channel->type == WEFT_PIXEL_UINT)
            channel->integers[i] = kind == 0 ? next_random() & mask : (uint32_t)(i / 7);
        else
            channel->plane[i] = value;
    }
}

static void make(struct picture *p, int kind, enum weft_pixel_type type,
                 enum weft_image_compression compression)
{
    static const char *const names[CHANNELS] = {"B", "G", "R"};
    *p = (struct picture){.image = {.x = between(-50, 50),
                                    .y = between(-50, 50),
                                    .width = between(8, between(8, LARGEST)),
                                    .height = between(8, between(8, LARGEST)),
                                    .compression = compression,
                                    .channel_count = (size_t)(between(0, 3) ? 1 : CHANNELS)}};
    for (size_t c = 0; c < p->image.channel_count; c++) {
        const size_t bytes = 4 * (size_t)p->image.width * (size_t)p->image.height;
        p->channels[c] = (struct weft_image_channel){.type = type, .plane = malloc(bytes)};
        snprintf(p->channels[c].name, sizeof p->channels[c].name, "%s", names[c]);
        if (type == WEFT_PIXEL_UINT)
            p->channels[c].integers = malloc(bytes);
        fill(p, (int)c, kind);
    }
}

static void clear(struct picture *p)
{
    for (size_t c = 0; c < p->image.channel_count; c++) {
        free(p->channels[c].plane);
        free(p->channels[c].integers);
    }
}

static const enum weft_image_compression written[] = {
    WEFT_IMAGE_ZIP, WEFT_IMAGE_ZIPS, WEFT_IMAGE_RLE, WEFT_IMAGE_NONE, WEFT_IMAGE_PIZ};

static void test_many_images(void **state)
{
    const char *setting = getenv("WEFT_IMAGES");
    const int count = setting ? atoi(setting) : 300;
    uint64_t chunks[WEFT_IMAGE_COMPRESSION_COUNT] = {0}, raw[WEFT_IMAGE_COMPRESSION_COUNT] = {0};
    (void)state;
    for (int i = 0; i < count; i++) {
        struct picture p;
        char what[100];
        random_state = (uint32_t)i;
        make(&p, i % 3, (enum weft_pixel_type)(i / 3 % 3), written[i / 9 % WEFT_COUNT(written)]);
        p.image.channels = p.channels;
        const struct weft_image_save_params params = {
            .path = test_path("many.exr"), .verify = i % 2, .log = &test_log};
        struct weft_image_save_report report;
        snprintf(what, sizeof what, "image %d, %d x %d", i, p.image.width, p.image.height);
        assert_int_equal(weft_image_save_parts(&p.image, 1, &params, &report), WEFT_OK);
        assert_int_equal(report.verified, i % 2 ? report.values : 0);
        assert_read_by_all(params.path, &p.image, what);
        chunks[p.image.compression] += report.chunks;
        raw[p.image.compression] += report.raw;
        clear(&p);
    }
    // Both happen, packed blocks and raw ones.
    for (size_t k = 0; k < WEFT_COUNT(written); k++) {
        const enum weft_image_compression c = written[k];
        print_message("%s: %llu blocks, %llu of them raw\n", weft_image_compression_names[c],
                      (unsigned long long)chunks[c], (unsigned long long)raw[c]);
        assert_true(raw[c] > 0);
        assert_true(c == WEFT_IMAGE_NONE ? raw[c] == chunks[c] : raw[c] < chunks[c]);
    }
}

// ---- blocks that packing makes exactly as long as they were -------------------------------------

// OpenEXRCore 3.1 stores such a block packed, and all readers take it for raw.
static void check_equal_length(const float *plane, int width, int height,
                               enum weft_image_compression compression)
{
    struct weft_image_channel channel = {.name = "Y", .plane = (float *)plane};
    const struct weft_image image = {.width = width,
                                     .height = height,
                                     .compression = compression,
                                     .channel_count = 1,
                                     .channels = &channel};
    const struct weft_image_save_params params = {.path = test_path("equal.exr"), .log = &test_log};
    struct weft_image_save_report report;
    assert_int_equal(weft_image_save_parts(&image, 1, &params, &report), WEFT_OK);
    assert_int_equal(report.chunks, 1);
    assert_int_equal(report.raw, 1);
    assert_read_by_all(params.path, &image, "a block of equal length");
}

static void test_equal_lengths(void **state)
{
    (void)state;
    enum { TRIES = 60000, ENOUGH = 5 };
    static const enum weft_image_compression kinds[] = {WEFT_IMAGE_ZIP, WEFT_IMAGE_ZIPS,
                                                        WEFT_IMAGE_RLE};
    static const unsigned char words = 2;
    static float plane[64 * 16];
    static unsigned char room[sizeof plane + WEFT_CHUNK_SLACK];
    for (size_t k = 0; k < WEFT_COUNT(kinds); k++) {
        int hits = 0, tries = 0;
        const int height = weft_chunk_lines(kinds[k]);
        for (; tries < TRIES && hits < ENOUGH; tries++) {
            weft_chunk_packer *packer;
            struct weft_chunk chunk;
            random_state = (uint32_t)tries;
            const int width = between(8, 64);
            const uint32_t mask = (UINT32_C(1) << between(14, 23)) - 1;
            const size_t size = sizeof *plane * (size_t)(width * height);
            for (int i = 0; i < width * height; i++)
                plane[i] = between(0, 9) ? noise(mask) : 0.5f;
            const struct weft_chunk_shape shape = {(size_t)width, 1, &words, height};
            assert_int_equal(weft_chunk_packer_create(kinds[k], &shape, &packer), WEFT_OK);
            assert_int_equal(weft_chunk_pack(packer, plane, height, room, &chunk), WEFT_OK);
            weft_chunk_packer_destroy(&packer);
            assert_true(chunk.packed ? chunk.size < size : chunk.size == size);
            if (chunk.shortest != size)
                continue;
            assert_false(chunk.packed);
            check_equal_length(plane, width, height, kinds[k]);
            hits++;
        }
        print_message("%s: %d blocks of equal length in %d\n",
                      weft_image_compression_names[kinds[k]], hits, tries);
        assert_int_equal(hits, ENOUGH);
    }
}

// ---- types --------------------------------------------------------------------------------------

static void test_rounding_is_reported(void **state)
{
    (void)state;
    float plane[] = {1.0f, 1.0f + 0x1p-11f, 65519.0f, 65520.0f, -1e9f, INFINITY, NAN, 1e-9f};
    uint32_t integers[] = {0, 1, 16777217, UINT32_MAX, 4294967295u, 7, 8, 9};
    struct weft_image_channel channels[] = {
        {.name = "h", .type = WEFT_PIXEL_HALF, .plane = plane, .linear = true},
        {.name = "u", .type = WEFT_PIXEL_UINT, .integers = integers}};
    const struct weft_image image = {
        .width = 8, .height = 1, .channel_count = 2, .channels = channels};
    const struct weft_image_save_params params = {
        .path = test_path("types.exr"), .verify = true, .log = &test_log};
    struct weft_image_save_report report;
    assert_int_equal(weft_image_save_parts(&image, 1, &params, &report), WEFT_OK);
    assert_int_equal(report.overflows, 2);
    assert_true(report.rounding == 15.0); // 65519 becomes 65504
    assert_int_equal(report.values, 16);
    assert_int_equal(report.verified, 16);
    assert_read_by_all(params.path, &image, "types");
}

// ---- attributes ---------------------------------------------------------------------------------

static void test_attributes_are_kept(void **state)
{
    (void)state;
    float pixel = 1.0f;
    char name[256], *text = malloc(40000);
    assert_non_null(text);
    memset(name, 'n', 255);
    name[255] = '\0';
    memset(text, 't', 40000);
    static const unsigned char numbers[64] = {1, 2, 3, 4, 5, 6, 7, 8, 0, 0, 0x80, 0x3f};
    static const unsigned char strings[] = {1, 0, 0, 0, 'a', 0, 0, 0, 0, 2, 0, 0, 0, 'b', 'c'};
    static const unsigned char time[] = {4, 3, 2, 1, 0, 0, 0, 0};
    static const unsigned char aspect[] = {0, 0, 0, 0x40};
    static const unsigned char channels[] = {'Y', 0, 2, 0, 0, 0, 0, 0, 0, 0,
                                             1,   0, 0, 0, 1, 0, 0, 0, 0};
    static const unsigned char preview[] = {1, 0, 0, 0, 1, 0, 0, 0, 9, 8, 7, 6};
    static const unsigned char key[28] = {
        [4] = 2, [8] = 3, [12] = 4, [16] = 5, [20] = 6, [24] = 64};
    static const unsigned char tiles[] = {64, 0, 0, 0, 32, 0, 0, 0, 0};
    static const unsigned char doubles[128] = {1, 2, 3, 4, 5, 6, 7,    8,
                                               0, 0, 0, 0, 0, 0, 0xf0, 0x3f};
    struct weft_image_attribute attributes[] = {
        {"long", "string", text, 40000},
        {name, "string", "first", 5},
        {"empty", "string", "", 0},
        {"multiView", "stringvector", strings, sizeof strings},
        {"timeCode", "timecode", time, 8},
        {"chromaticities", "chromaticities", numbers, 32},
        {"own", "a type of our own", numbers, 11},
        {"m", "m44f", numbers, 64},
        {"pixelAspectRatio", "float", aspect, 4},
        {"screenWindowWidth", "float", aspect, 4},
        {"screenWindowCenter", "v2f", numbers, 8},
        {"b2", "box2f", numbers, 16},
        {"b1", "box2i", numbers, 16},
        {"ch", "chlist", channels, sizeof channels},
        {"co", "compression", "\3", 1},
        {"do", "double", numbers, 8},
        {"en", "envmap", "\1", 1},
        {"fl", "floatvector", numbers, 12},
        {"in", "int", numbers, 4},
        {"ke", "keycode", key, sizeof key},
        {"li", "lineOrder", "\1", 1},
        {"m3", "m33d", doubles, 72},
        {"m4", "m44d", doubles, 128},
        {"no", "stringvector", "", 0},
        {"pr", "preview", preview, sizeof preview},
        {"ra", "rational", numbers, 8},
        {"ti", "tiledesc", tiles, sizeof tiles},
        {"v2", "v2d", numbers, 16},
        {"v3", "v3d", numbers, 24}};
    static const char *const words[WEFT_COUNT(attributes)] = {
        NULL, "first", "", "a, , bc", "01:02:03:04", NULL, "(11 bytes of type a type of our own)",
        NULL, "2",     "2"};
    struct weft_image_channel channel = {.name = "Y", .plane = &pixel};
    const struct weft_image image = {.width = 1,
                                     .height = 1,
                                     .channel_count = 1,
                                     .channels = &channel,
                                     .attribute_count = WEFT_COUNT(attributes),
                                     .attributes = attributes};
    const struct weft_image_save_params params = {
        .path = test_path("attributes.exr"), .verify = true, .log = &test_log};
    struct weft_image loaded;
    assert_int_equal(weft_image_save(&image, &params), WEFT_OK);
    assert_int_equal(load(params.path, 0, &loaded), WEFT_OK);
    for (size_t i = 0; i < WEFT_COUNT(attributes); i++) {
        const struct weft_image_attribute *found = weft_image_find(&loaded, attributes[i].name);
        char shown[300];
        assert_non_null(found);
        assert_string_equal(found->type, attributes[i].type);
        assert_int_equal(found->size, attributes[i].size);
        assert_memory_equal(found->data, attributes[i].data, found->size);
        const size_t length = weft_image_attribute_format(found, shown, sizeof shown);
        assert_int_equal(strlen(shown), length < sizeof shown ? length : sizeof shown - 1);
        if (words[i])
            assert_string_equal(shown, words[i]);
    }
    assert_int_equal(weft_image_attribute_format(weft_image_find(&loaded, "long"), NULL, 0), 40000);
    assert_read_by_all(params.path, &image, "attributes");
    weft_image_clear(&loaded);
    free(text);
}

// ---- parts --------------------------------------------------------------------------------------

static void test_parts(void **state)
{
    (void)state;
    struct picture pictures[3];
    struct weft_image parts[3];
    struct weft_image_list list;
    struct weft_image_save_report report;
    random_state = 1;
    for (int p = 0; p < 3; p++) {
        make(&pictures[p], p, (enum weft_pixel_type)p, written[p]);
        parts[p] = pictures[p].image;
        parts[p].channels = pictures[p].channels;
        parts[p].part = p;
        parts[p].display_max[0] = parts[p].display_max[1] = 99;
        snprintf(parts[p].name, sizeof parts[p].name, "part %d", p);
    }
    const struct weft_image_save_params params = {
        .path = test_path("parts.exr"), .verify = true, .log = &test_log};
    assert_int_equal(weft_image_save_parts(parts, 3, &params, &report), WEFT_OK);
    assert_int_equal(report.verified, report.values);
    for (int p = 0; p < 3; p++)
        assert_read_by_all(params.path, &parts[p], "parts");
    const struct weft_image_load_params load_params = {.path = params.path, .log = &test_log};
    assert_int_equal(weft_image_list_load(&load_params, &list), WEFT_OK);
    assert_int_equal(list.count, 3);
    for (int p = 0; p < 3; p++) {
        assert_string_equal(list.images[p].name, parts[p].name);
        assert_int_equal(list.images[p].part, p);
        assert_int_equal(list.images[p].part_count, 3);
        assert_int_equal(list.images[p].compression, written[p]);
        assert_null(list.images[p].channels[0].plane);
    }
    weft_image_list_clear(&list);
    struct weft_image loaded;
    assert_int_equal(load(params.path, 3, &loaded), WEFT_ERR_ARGUMENT);
    assert_non_null(strstr(test_message, "there is no part 3"));
    parts[1].display_max[0] = 98;
    assert_int_equal(weft_image_save_parts(parts, 3, &params, NULL), WEFT_ERR_ARGUMENT);
    assert_non_null(strstr(test_message, "display window"));
    parts[1].display_max[0] = 99;
    memcpy(parts[2].name, parts[0].name, sizeof parts[0].name);
    assert_int_equal(weft_image_save_parts(parts, 3, &params, NULL), WEFT_ERR_ARGUMENT);
    assert_non_null(strstr(test_message, "two parts"));
    for (int p = 0; p < 3; p++)
        clear(&pictures[p]);
}

int main(void)
{
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 1);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_many_images, load_photos, drop_photos),
        cmocka_unit_test_setup_teardown(test_equal_lengths, test_enter_folder, test_leave_folder),
        cmocka_unit_test_setup_teardown(test_rounding_is_reported, test_enter_folder,
                                        test_leave_folder),
        cmocka_unit_test_setup_teardown(test_attributes_are_kept, test_enter_folder,
                                        test_leave_folder),
        cmocka_unit_test_setup_teardown(test_parts, test_enter_folder, test_leave_folder),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
