// SPDX-License-Identifier: BSD-3-Clause
// Sequences of good files: values as they are stored, in their order, within bounds.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/resource.h>

#include <cmocka.h>

#include <math.h>

#include "filter/check.h"
#include "filter/half.h"
#include "tests/support/exr_maker.h"
#include "tests/support/exr_peer.h"
#include "tests/support/files.h"
#include "tests/tiles/image/png_maker.h"
#include "tests/tiles/image/sequences.h"

enum { WIDTH = 37, HEIGHT = 41, PIXELS = WIDTH * HEIGHT };

// ---- EXR ----------------------------------------------------------------------------------------

static float half_plane[PIXELS], float_plane[PIXELS];
static uint32_t integers[PIXELS];

// Every half that there is among few pixels: NaN, infinities, subnormals.
static void make_values(int seed)
{
    for (int i = 0; i < PIXELS; i++) {
        half_plane[i] = weft_half_to_float((uint16_t)(i * 43 + seed));
        float_plane[i] = sinf((float)(i + seed)) * 1e20f;
        integers[i] = UINT32_MAX - (uint32_t)(i * (seed + 1));
    }
}

static const struct weft_image_attribute attributes[] = {{"capDate", "string", "2026", 4}};

static struct weft_image exr_image(struct weft_image_channel channels[3])
{
    channels[0] =
        (struct weft_image_channel){.name = "R", .type = WEFT_PIXEL_HALF, .plane = half_plane};
    channels[1] = (struct weft_image_channel){.name = "Z", .plane = float_plane};
    channels[2] =
        (struct weft_image_channel){.name = "id", .type = WEFT_PIXEL_UINT, .integers = integers};
    return (struct weft_image){.x = -3,
                               .y = 7,
                               .width = WIDTH,
                               .height = HEIGHT,
                               .display_min = {-10, -10},
                               .display_max = {100, 200},
                               .channel_count = 3,
                               .channels = channels,
                               .attribute_count = 1,
                               .attributes = (struct weft_image_attribute *)(uintptr_t)attributes};
}

static void save_exr(const char *path, enum weft_image_compression compression, int seed)
{
    struct weft_image_channel channels[3];
    make_values(seed);
    struct weft_image image = exr_image(channels);
    image.compression = compression;
    const struct weft_image_save_params params = {.path = path, .log = &test_log};
    assert_int_equal(weft_image_save(&image, &params), WEFT_OK);
}

static bool is_nan_half(uint16_t h)
{
    return (h & 0x7c00) == 0x7c00 && (h & 0x3ff);
}

static void assert_exr_values(const struct weft_image_frame *frame, int seed)
{
    make_values(seed);
    assert_int_equal(frame->image.width, WIDTH);
    assert_int_equal(frame->plane[0].type, WEFT_PLANE_HALF);
    assert_int_equal(frame->plane[1].type, WEFT_PLANE_FLOAT);
    assert_int_equal(frame->plane[2].type, WEFT_PLANE_UINT);
    const uint16_t *halves = frame->plane[0].values;
    int compared = 0;
    for (int i = 0; i < PIXELS; i++) {
        const uint16_t h = (uint16_t)(i * 43 + seed);
        if (is_nan_half(h) ? !is_nan_half(halves[i]) : halves[i] != h)
            fail_msg("half %d is %04x instead of %04x", i, halves[i], h);
        compared++;
    }
    assert_int_equal(compared, PIXELS);
    assert_memory_equal(frame->plane[1].values, float_plane, sizeof float_plane);
    assert_memory_equal(frame->plane[2].values, integers, sizeof integers);
    for (int c = 0; c < 3; c++) {
        assert_int_equal(frame->plane[c].stride, WIDTH);
        assert_int_equal(frame->plane[c].step, 1);
        assert_int_equal((uintptr_t)frame->plane[c].values % 64, 0);
        assert_null(frame->image.channels[c].plane);
        assert_null(frame->image.channels[c].integers);
    }
}

static void test_exr(void **state)
{
    (void)state;
    const char *names[WEFT_IMAGE_PIZ + 1];
    for (int k = 0; k <= WEFT_IMAGE_PIZ; k++) {
        names[k] = strdup(test_path(weft_image_compression_names[k]));
        save_exr(names[k], (enum weft_image_compression)k, k);
    }
    struct names list = {.name = names};
    weft_image_sequence *sequence = begin(&list, WEFT_IMAGE_PIZ + 1, 2);
    for (int k = 0; k <= WEFT_IMAGE_PIZ; k++) {
        const struct weft_image_frame *frame = good_frame(sequence, k);
        struct stat st;
        assert_int_equal(stat(names[k], &st), 0);
        assert_string_equal(frame->name, names[k]);
        assert_int_equal(frame->kind, WEFT_IMAGE_FILE_EXR);
        assert_int_equal(frame->file_bytes, st.st_size);
        assert_true(frame->changed_ns ==
                    (int64_t)st.st_mtim.tv_sec * 1000000000 + st.st_mtim.tv_nsec);
        assert_int_equal(frame->image.compression, k);
        assert_int_equal(frame->image.x, -3);
        assert_int_equal(frame->image.display_max[1], 200);
        assert_int_equal(frame->image.channel_count, 3);
        assert_string_equal(frame->image.channels[2].name, "id");
        assert_int_equal(weft_image_find(&frame->image, "capDate")->size, 4);
        assert_exr_values(frame, k);
    }
    finish(&sequence);
    for (int k = 0; k <= WEFT_IMAGE_PIZ; k++)
        free((void *)(uintptr_t)names[k]);
}

// Tiled, and the second of two parts.
static void test_exr_parts(void **state)
{
    (void)state;
    float values[PIXELS];
    for (int i = 0; i < PIXELS; i++)
        values[i] = (float)i * 0.5f;
    const char *name = test_path("parts.exr");
    const struct exr_recipe recipe = {.path = name,
                                      .storage = EXR_STORAGE_TILED,
                                      .compression = EXR_COMPRESSION_ZIP,
                                      .type = EXR_PIXEL_FLOAT,
                                      .width = WIDTH,
                                      .height = HEIGHT,
                                      .tile_width = 16,
                                      .tile_height = 8,
                                      .parts = 2,
                                      .pixels = values};
    assert_int_equal(exr_make(&recipe), EXR_ERR_SUCCESS);
    for (int part = 0; part < 3; part++) {
        struct weft_image whole;
        struct names list = {.name = &name};
        weft_image_sequence *sequence = NULL;
        assert_int_equal(weft_image_sequence_create(
                             weft_image_sequence_params(.count = 1, .name = name_of, .priv = &list,
                                                        .part = part, .log = &test_log),
                             &sequence),
                         WEFT_OK);
        if (part == 2) {
            assert_non_null(strstr(bad_frame(sequence, 0, WEFT_ERR_ARGUMENT), "no part 2"));
        } else {
            const struct weft_image_frame *frame = good_frame(sequence, 0);
            assert_true(frame->image.tiled);
            assert_int_equal(frame->image.part, part);
            assert_int_equal(
                weft_image_load(
                    weft_image_load_params(.path = name, .part = part, .log = &test_log), &whole),
                WEFT_OK);
            assert_memory_equal(frame->plane[0].values, whole.channels[0].plane, sizeof values);
            weft_image_clear(&whole);
        }
        finish(&sequence);
    }
}

// DWA has a program of its own; it is told from the first file on.
static void test_dwa(void **state)
{
    (void)state;
    enum { FILES = 5 };
    char why[400];
    const char *names[FILES];
    struct weft_image_channel channels[3];
    make_values(1);
    for (int i = 0; i < PIXELS; i++)
        half_plane[i] = sinf(0.1f * (float)(i % WIDTH)) + 1.0f;
    struct weft_image image = exr_image(channels);
    for (int k = 0; k < FILES; k++) {
        char name[20];
        snprintf(name, sizeof name, "dwa%d", k);
        names[k] = strdup(test_path(name));
        image.compression = k % 2 ? WEFT_IMAGE_DWAB : WEFT_IMAGE_DWAA;
        if (k == 3) // and back again
            save_exr(names[k], WEFT_IMAGE_ZIP, 1);
        else if (!exr_peer_write(names[k], &image, 1, 0, why, sizeof why))
            fail_msg("%s", why);
    }
    struct names list = {.name = names};
    weft_image_sequence *sequence = begin(&list, FILES, 2);
    for (int k = 0; k < FILES; k++) {
        const struct weft_image_frame *frame = good_frame(sequence, k);
        if (k == 3) {
            assert_exr_values(frame, 1);
            continue;
        }
        float *values = exr_peer_values(names[k], "R", why, sizeof why);
        assert_non_null(values);
        assert_int_equal(frame->plane[0].type, WEFT_PLANE_HALF);
        for (int i = 0; i < PIXELS; i++) {
            const float v = weft_half_to_float(((const uint16_t *)frame->plane[0].values)[i]);
            if (!(v == values[i]))
                fail_msg("%s: value %d is %g instead of %g", names[k], i, v, values[i]);
        }
        free(values);
        assert_memory_equal(frame->plane[2].values, integers, sizeof integers);
    }
    finish(&sequence);
    for (int k = 0; k < FILES; k++)
        free((void *)(uintptr_t)names[k]);
}

// ---- PNG ----------------------------------------------------------------------------------------

// What the standard says that a pixel's channels are, as codes of 8 bits, or 16 where the file has
// 16.
static int expected_pixel(const struct png_recipe *r, int x, int y, unsigned out[4])
{
    const int stored = png_channels(r->colour);
    const unsigned largest = (1u << r->bits) - 1, one = r->bits == 16 ? 65535 : 255;
    int count = stored;
    bool clear = true;
    if (r->colour == PNG_COLOR_TYPE_PALETTE) {
        const unsigned index = png_sample(r, x, y, 0);
        const png_color colour = png_entry((int)index);
        out[0] = colour.red;
        out[1] = colour.green;
        out[2] = colour.blue;
        out[3] = index ? 255 : 77;
        return r->transparent ? 4 : 3;
    }
    for (int c = 0; c < stored; c++) {
        const unsigned v = png_sample(r, x, y, c);
        out[c] = v * one / largest;
        clear &= v == 0;
    }
    if (r->transparent)
        out[count++] = clear ? 0 : one;
    return count;
}

static void assert_png(const struct weft_image_frame *frame, const struct png_recipe *r)
{
    const bool wide = r->bits == 16;
    unsigned expected[4];
    const int channels = expected_pixel(r, 0, 0, expected);
    assert_int_equal(frame->kind, WEFT_IMAGE_FILE_PNG);
    assert_int_equal(frame->image.width, r->width);
    assert_int_equal(frame->image.height, r->height);
    assert_int_equal(frame->image.display_max[1], r->height - 1);
    assert_int_equal(frame->image.channel_count, channels);
    assert_string_equal(frame->image.channels[0].name, channels < 3 ? "Y" : "R");
    if (channels % 2 == 0)
        assert_string_equal(frame->image.channels[channels - 1].name, "A");
    assert_int_equal(frame->codes.bits, r->bits);
    assert_int_equal(frame->codes.palette, r->colour == PNG_COLOR_TYPE_PALETTE);
    assert_int_equal(frame->codes.alpha, channels % 2 == 0);
    assert_int_equal(frame->codes.interlaced, r->interlaced);
    for (int c = 0; c < channels; c++) {
        const struct weft_plane *plane = &frame->plane[c];
        assert_int_equal(plane->type, wide ? WEFT_PLANE_UNORM16 : WEFT_PLANE_UNORM8);
        for (int i = 0; i < r->width * r->height; i++) {
            const size_t at =
                (size_t)(i / r->width) * plane->stride + (size_t)(i % r->width) * plane->step;
            const unsigned code =
                wide ? ((const uint16_t *)plane->values)[at] : ((const uint8_t *)plane->values)[at];
            expected_pixel(r, i % r->width, i / r->width, expected);
            if (code != expected[c])
                fail_msg("colour type %d, %d bits, channel %d, pixel %d: %u instead of %u",
                         r->colour, r->bits, c, i, code, expected[c]);
        }
    }
}

static void test_png(void **state)
{
    (void)state;
    static const struct {
        int colour, bits;
        bool transparent;
    } kinds[] = {
        {PNG_COLOR_TYPE_GRAY, 1, false},       {PNG_COLOR_TYPE_GRAY, 1, true},
        {PNG_COLOR_TYPE_GRAY, 2, false},       {PNG_COLOR_TYPE_GRAY, 2, true},
        {PNG_COLOR_TYPE_GRAY, 4, false},       {PNG_COLOR_TYPE_GRAY, 4, true},
        {PNG_COLOR_TYPE_GRAY, 8, false},       {PNG_COLOR_TYPE_GRAY, 8, true},
        {PNG_COLOR_TYPE_GRAY, 16, false},      {PNG_COLOR_TYPE_GRAY, 16, true},
        {PNG_COLOR_TYPE_RGB, 8, false},        {PNG_COLOR_TYPE_RGB, 8, true},
        {PNG_COLOR_TYPE_RGB, 16, false},       {PNG_COLOR_TYPE_RGB, 16, true},
        {PNG_COLOR_TYPE_GRAY_ALPHA, 8, false}, {PNG_COLOR_TYPE_GRAY_ALPHA, 16, false},
        {PNG_COLOR_TYPE_RGB_ALPHA, 8, false},  {PNG_COLOR_TYPE_RGB_ALPHA, 16, false},
        {PNG_COLOR_TYPE_PALETTE, 1, false},    {PNG_COLOR_TYPE_PALETTE, 1, true},
        {PNG_COLOR_TYPE_PALETTE, 2, false},    {PNG_COLOR_TYPE_PALETTE, 2, true},
        {PNG_COLOR_TYPE_PALETTE, 4, false},    {PNG_COLOR_TYPE_PALETTE, 4, true},
        {PNG_COLOR_TYPE_PALETTE, 8, false},    {PNG_COLOR_TYPE_PALETTE, 8, true},
    };
    enum { COUNT = WEFT_COUNT(kinds) * 2 };
    struct png_recipe recipes[COUNT];
    const char *names[COUNT];
    for (int i = 0; i < COUNT; i++) {
        char name[20];
        snprintf(name, sizeof name, "%d.png", i);
        names[i] = strdup(test_path(name));
        recipes[i] = (struct png_recipe){.path = names[i],
                                         .width = WIDTH,
                                         .height = HEIGHT,
                                         .bits = kinds[i / 2].bits,
                                         .colour = kinds[i / 2].colour,
                                         .transparent = kinds[i / 2].transparent,
                                         .interlaced = i % 2};
        png_make(&recipes[i]);
    }
    struct names list = {.name = names};
    weft_image_sequence *sequence = begin(&list, COUNT, 2);
    for (int i = 0; i < COUNT; i++)
        assert_png(good_frame(sequence, i), &recipes[i]);
    finish(&sequence);
    for (int i = 0; i < COUNT; i++)
        free((void *)(uintptr_t)names[i]);
}

static void test_png_colour(void **state)
{
    (void)state;
    static const uint8_t pq[] = {9, 16, 0, 1};
    static const struct {
        bool srgb;
        double gamma, expected;
        const uint8_t *cicp;
    } cases[] = {{false, 0.0, 0.0, NULL},
                 {true, 0.0, 0.45455, NULL},
                 {false, 1.0, 1.0, NULL},
                 {false, 0.5, 0.5, pq}};
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const struct png_recipe recipe = {.path = test_path("colour.png"),
                                          .width = 3,
                                          .height = 2,
                                          .bits = 8,
                                          .colour = PNG_COLOR_TYPE_RGB,
                                          .srgb = cases[i].srgb,
                                          .gamma = cases[i].gamma,
                                          .cicp = cases[i].cicp};
        png_make(&recipe);
        struct names list = {.name = &recipe.path};
        weft_image_sequence *sequence = begin(&list, 1, 1);
        const struct weft_image_frame *frame = good_frame(sequence, 0);
        assert_int_equal(frame->codes.srgb, cases[i].srgb);
        assert_false(frame->codes.icc);
        assert_true(frame->codes.gamma == cases[i].expected);
        const uint8_t none[4] = {0};
        assert_memory_equal(frame->codes.cicp, cases[i].cicp ? cases[i].cicp : none, 4);
        finish(&sequence);
    }
}

// ---- many ---------------------------------------------------------------------------------------

static void test_info_only(void **state)
{
    (void)state;
    const char *names[] = {test_path("a.exr"), test_path("b.png"), test_path("c.exr")};
    char why[400];
    struct weft_image_channel channels[3];
    save_exr(names[0], WEFT_IMAGE_PIZ, 0);
    png_make(&(struct png_recipe){
        .path = names[1], .width = 5, .height = 6, .bits = 16, .colour = PNG_COLOR_TYPE_RGB});
    struct weft_image image = exr_image(channels);
    image.compression = WEFT_IMAGE_DWAA;
    assert_true(exr_peer_write(names[2], &image, 1, 0, why, sizeof why));
    struct names list = {.name = names};
    weft_image_sequence *sequence = NULL;
    assert_int_equal(weft_image_sequence_create(
                         weft_image_sequence_params(.count = 3, .name = name_of, .priv = &list,
                                                    .info_only = true, .log = &test_log),
                         &sequence),
                     WEFT_OK);
    for (int i = 0; i < 3; i++) {
        const struct weft_image_frame *frame = good_frame(sequence, i);
        assert_null(frame->plane);
        assert_int_equal(frame->image.width, i == 1 ? 5 : WIDTH);
        assert_int_equal(frame->image.channel_count, 3);
        assert_int_equal(frame->codes.bits, i == 1 ? 16 : 0);
    }
    finish(&sequence);
}

// Two files under many names, some left out, with few descriptors and little memory.
static void test_many(void **state)
{
    (void)state;
    enum { COUNT = 700 };
    static const struct {
        int readers;
        uint64_t memory_bytes;
    } cases[] = {{1, 0}, {2, 0}, {5, 0}, {32, 0}, {3, 1}, {2, 40000}};
    const char *two[] = {test_path("a.exr"), test_path("b.exr")}, *names[COUNT];
    struct rlimit old, low;
    save_exr(two[0], WEFT_IMAGE_ZIP, 10);
    save_exr(two[1], WEFT_IMAGE_RLE, 11);
    for (int i = 0; i < COUNT; i++)
        names[i] = i % 7 == 3 ? NULL : two[i % 2];
    assert_int_equal(getrlimit(RLIMIT_NOFILE, &old), 0);
    low = old;
    low.rlim_cur = 32;
    assert_int_equal(setrlimit(RLIMIT_NOFILE, &low), 0);
    for (size_t k = 0; k < WEFT_COUNT(cases); k++) {
        const int fds = test_count_entries("/proc/self/fd");
        struct names list = {.name = names};
        const int count = k ? COUNT / 5 : COUNT;
        weft_image_sequence *sequence = NULL;
        assert_int_equal(
            weft_image_sequence_create(
                weft_image_sequence_params(.count = count, .name = name_of, .priv = &list,
                                           .readers = cases[k].readers,
                                           .memory_bytes = cases[k].memory_bytes, .log = &test_log),
                &sequence),
            WEFT_OK);
        int most = 0;
        for (int i = 0; i < count; i++) {
            if (i % 7 == 3)
                continue;
            assert_exr_values(good_frame(sequence, i), 10 + i % 2);
            const int children = count_children();
            most = children > most ? children : most;
        }
        assert_in_range(most, 1, cases[k].readers < 6 ? cases[k].readers : 6);
        finish(&sequence);
        assert_int_equal(list.asked, count);
        assert_int_equal(test_count_entries("/proc/self/fd"), fds);
        assert_int_equal(count_children(), 0);
    }
    assert_int_equal(setrlimit(RLIMIT_NOFILE, &old), 0);
}

// Frames of other sizes than those before need memory of their own.
static void test_sizes(void **state)
{
    (void)state;
    enum { COUNT = 12 };
    const char *names[COUNT];
    struct png_recipe recipes[COUNT];
    for (int i = 0; i < COUNT; i++) {
        char name[20];
        snprintf(name, sizeof name, "%d.png", i);
        names[i] = strdup(test_path(name));
        recipes[i] = (struct png_recipe){.path = names[i],
                                         .width = i % 3 ? 600 + 300 * i : 1,
                                         .height = i % 4 == 1 ? 900 : 2,
                                         .bits = 8,
                                         .colour = PNG_COLOR_TYPE_GRAY};
        png_make(&recipes[i]);
    }
    for (int readers = 1; readers <= 3; readers++) {
        struct names list = {.name = names};
        weft_image_sequence *sequence = NULL;
        assert_int_equal(weft_image_sequence_create(
                             weft_image_sequence_params(.count = COUNT, .name = name_of,
                                                        .priv = &list, .readers = readers,
                                                        .memory_bytes = 2 << 20, .log = &test_log),
                             &sequence),
                         WEFT_OK);
        for (int i = 0; i < COUNT; i++)
            assert_png(good_frame(sequence, i), &recipes[i]);
        finish(&sequence);
    }
    for (int i = 0; i < COUNT; i++)
        free((void *)(uintptr_t)names[i]);
}

static bool stop_now(void *priv)
{
    return ((struct names *)priv)->stop;
}

static void test_stop(void **state)
{
    (void)state;
    const char *name = test_path("a.exr");
    save_exr(name, WEFT_IMAGE_ZIP, 3);
    struct names list = {.name = &name, .stop = true};
    const struct weft_image_frame *frame = NULL;
    weft_image_sequence *sequence = NULL;
    assert_int_equal(weft_image_sequence_create(
                         weft_image_sequence_params(.count = 1, .name = name_of, .stop = stop_now,
                                                    .priv = &list, .log = &test_log),
                         &sequence),
                     WEFT_OK);
    for (int i = 0; i < 3; i++) {
        assert_int_equal(weft_image_sequence_next(sequence, &frame), WEFT_ERR_CANCELLED);
        assert_null(frame);
    }
    list.stop = false;
    assert_exr_values(good_frame(sequence, 0), 3);
    finish(&sequence);
    // Ended in the middle of it.
    list = (struct names){.name = &name, .stop = true};
    assert_int_equal(weft_image_sequence_create(
                         weft_image_sequence_params(.count = 1, .name = name_of, .stop = stop_now,
                                                    .priv = &list, .log = &test_log),
                         &sequence),
                     WEFT_OK);
    assert_int_equal(weft_image_sequence_next(sequence, &frame), WEFT_ERR_CANCELLED);
    assert_int_equal(count_children(), 1);
    weft_image_sequence_destroy(&sequence);
    assert_int_equal(count_children(), 0);
}

// More names, before the last frame was had and after it: the same process reads them.
static void test_extend(void **state)
{
    enum { COUNT = 9 };
    const char *names[COUNT];
    const struct weft_image_frame *frame = NULL;
    pid_t first = 0, later = 0;
    (void)state;
    for (int i = 0; i < COUNT; i++) {
        char name[20];
        snprintf(name, sizeof name, "%d.exr", i);
        names[i] = strdup(test_path(name));
        save_exr(names[i], WEFT_IMAGE_ZIP, i);
    }
    struct names list = {.name = names};
    weft_image_sequence *sequence = begin(&list, 2, 1);
    for (int i = 0; i < COUNT; i++) {
        if (i == 1)
            assert_int_equal(weft_image_sequence_extend(sequence, 3), WEFT_OK);
        if (i == 5) {
            assert_int_equal(weft_image_sequence_next(sequence, &frame), WEFT_OK);
            assert_null(frame);
            assert_int_equal(list.asked, 5);
            assert_int_equal(weft_image_sequence_extend(sequence, COUNT - 5), WEFT_OK);
        }
        assert_exr_values(good_frame(sequence, i), i);
        assert_int_equal(children(i ? &later : &first), 1);
        assert_true(!i || later == first);
    }
    assert_int_equal(weft_image_sequence_extend(sequence, 0), WEFT_ERR_ARGUMENT);
    test_forget();
    finish(&sequence);
    for (int i = 0; i < COUNT; i++)
        free((void *)(uintptr_t)names[i]);
}

int main(void)
{
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 1);
    const struct CMUnitTest tests[] = {
        IN_FOLDER(test_exr),    IN_FOLDER(test_exr_parts),  IN_FOLDER(test_dwa),
        IN_FOLDER(test_png),    IN_FOLDER(test_png_colour), IN_FOLDER(test_info_only),
        IN_FOLDER(test_many),   IN_FOLDER(test_sizes),      IN_FOLDER(test_stop),
        IN_FOLDER(test_extend),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
