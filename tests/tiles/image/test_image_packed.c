// SPDX-License-Identifier: BSD-3-Clause
// Lines that are packed before they are saved: the same file, whoever packed them.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "tests/support/files.h"
#include "weft.h"

enum { WIDTH = 83, HEIGHT = 150, MOST = HEIGHT };

static float plane[HEIGHT][WIDTH];

static struct weft_image image_of(struct weft_image_channel *channel,
                                  enum weft_image_compression compression, int from, int lines)
{
    channel->plane = plane[from];
    return (struct weft_image){.width = WIDTH,
                               .height = lines,
                               .compression = compression,
                               .channel_count = 1,
                               .channels = channel};
}

struct bands {
    struct weft_image_packed packed[MOST];
    int from[MOST], count, given;
};

static enum weft_result give(void *priv, int line, struct weft_bytes *out)
{
    struct bands *b = priv;
    assert_true(b->given < b->count);
    assert_int_equal(line, b->from[b->given]);
    *out = (struct weft_bytes){b->packed[b->given].data, b->packed[b->given].size};
    b->given++;
    return WEFT_OK;
}

// Bands of so many blocks each.
static void pack(struct weft_image_channel *channel, enum weft_image_compression compression,
                 int blocks, struct bands *b)
{
    const int step = blocks * weft_image_block_lines(compression);
    *b = (struct bands){.count = 0};
    for (int from = 0; from < HEIGHT; from += step) {
        const int left = HEIGHT - from;
        const struct weft_image image =
            image_of(channel, compression, from, left < step ? left : step);
        assert_int_equal(weft_image_pack(&image, 1, &log_to_stderr, &b->packed[b->count]), WEFT_OK);
        b->from[b->count++] = from;
    }
}

static void free_bands(struct bands *b)
{
    for (int i = 0; i < b->count; i++)
        weft_image_packed_clear(&b->packed[i]);
}

static void assert_same_file(const char *a, const char *b)
{
    size_t sizes[2];
    char *bytes[2] = {test_read_file(a, &sizes[0]), test_read_file(b, &sizes[1])};
    assert_int_equal(sizes[0], sizes[1]);
    assert_memory_equal(bytes[0], bytes[1], sizes[0]);
    free(bytes[0]);
    free(bytes[1]);
}

static void check(enum weft_pixel_type type, enum weft_image_compression compression, int blocks,
                  bool verify)
{
    struct weft_image_channel channel = {.name = "Y", .type = type};
    struct weft_image image = image_of(&channel, compression, 0, HEIGHT);
    struct weft_image_save_report told, packed, sum = {0};
    struct bands b;
    const char *const plain = test_path("plain.exr"), *const other = test_path("other.exr");
    assert_int_equal(
        weft_image_save_parts(&image, 1,
                              weft_image_save_params(.path = plain, .log = &log_to_stderr), &told),
        WEFT_OK);
    pack(&channel, compression, blocks, &b);
    for (int i = 0; i < b.count; i++) {
        sum.overflows += b.packed[i].report.overflows;
        sum.rounding = fmax(sum.rounding, b.packed[i].report.rounding);
        sum.raw += b.packed[i].report.raw;
        sum.chunks += b.packed[i].report.chunks;
        sum.values += b.packed[i].report.values;
    }
    channel.plane = verify ? plane[0] : NULL;
    assert_int_equal(weft_image_save_parts(&image, 1,
                                           weft_image_save_params(.path = other, .verify = verify,
                                                                  .packed = give, .packed_priv = &b,
                                                                  .log = &log_to_stderr),
                                           &packed),
                     WEFT_OK);
    assert_int_equal(b.given, b.count);
    assert_same_file(plain, other);
    assert_true(sum.overflows == told.overflows && sum.rounding == told.rounding);
    assert_true(sum.raw == told.raw && packed.raw == told.raw);
    assert_true(sum.chunks == told.chunks && packed.chunks == told.chunks);
    assert_true(sum.values == told.values && packed.values == told.values);
    assert_int_equal(packed.verified, verify ? told.values : 0);
    free_bands(&b);
    unlink(plain);
    unlink(other);
}

static void files_are_the_same_whoever_packs(void **state)
{
    int checked = 0;
    (void)state;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            plane[y][x] = y < 40 ? (float)(y / 7) : (float)sin(0.1 * x * y) * (x == 9 ? 1e5f : 1.f);
    for (int c = 0; c < WEFT_IMAGE_COMPRESSION_COUNT; c++) {
        if (!weft_image_is_writable((enum weft_image_compression)c))
            continue;
        check(WEFT_PIXEL_FLOAT, (enum weft_image_compression)c, 1, c == WEFT_IMAGE_ZIP);
        check(WEFT_PIXEL_HALF, (enum weft_image_compression)c, 3, false);
        checked++;
    }
    assert_true(checked >= 4);
}

static enum weft_result give_none(void *priv, int line, struct weft_bytes *out)
{
    (void)priv;
    (void)line;
    (void)out;
    return WEFT_ERR_CANCELLED;
}

// Blocks that are cut off, too long, too many, or that nobody has: no file.
static void what_is_no_block_is_refused(void **state)
{
    (void)state;
    for (int bad = 0; bad < 5; bad++) {
        struct weft_image_channel channel = {.name = "Y", .type = WEFT_PIXEL_FLOAT};
        struct weft_image image = image_of(&channel, WEFT_IMAGE_ZIP, 0, HEIGHT);
        struct message message = {.count = 0};
        const struct weft_log log = {keep_message, &message};
        struct bands b;
        const char *const path = test_path("bad.exr");
        pack(&channel, WEFT_IMAGE_ZIP, 100, &b);
        uint32_t *size = b.packed[0].data;
        if (bad == 0)
            b.packed[0].size -= 1;
        else if (bad == 1)
            *size = UINT32_MAX;
        else if (bad == 2)
            *size = 0;
        else if (bad == 3)
            image.height = 16;
        const struct weft_image_save_params *params =
            weft_image_save_params(.path = path, .packed = bad == 4 ? give_none : give,
                                   .packed_priv = &b, .log = &log);
        assert_int_equal(weft_image_save_parts(&image, 1, params, NULL),
                         bad == 4 ? WEFT_ERR_CANCELLED : WEFT_ERR_ARGUMENT);
        assert_int_equal(message.count, bad == 4 ? 0 : 1);
        assert_true(access(path, F_OK) != 0);
        free_bands(&b);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(files_are_the_same_whoever_packs),
        cmocka_unit_test(what_is_no_block_is_refused),
    };
    return cmocka_run_group_tests(tests, test_enter_folder, test_leave_folder);
}
