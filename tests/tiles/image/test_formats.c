// SPDX-License-Identifier: BSD-3-Clause
// PNG and TIFF files of every kind, made by libpng and libtiff, as light and back to the same
// codes; mip levels of EXR files, which OpenEXR's C++ library reads; files that lie. WEFT_MUTATIONS
// is the number of damaged TIFF files (default 40), WEFT_MUTATION_SEED their seed.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <tiffio.h>

#include "filter/check.h"
#include "filter/half.h"
#include "tests/support/exr_peer.h"
#include "tests/support/files.h"
#include "tests/tiles/image/png_maker.h"
#include "tiles/image/image.h"

enum { WIDTH = 37, HEIGHT = 21 };

static uint64_t random_state = 1;

static uint32_t next_random(void)
{
    random_state = random_state * UINT64_C(6364136223846793005) + 1442695040888963407u;
    return (uint32_t)(random_state >> 33);
}

static enum weft_result load_part(const char *path, int part, enum weft_curve curve,
                                  struct weft_image *out)
{
    test_forget();
    return weft_image_load(
        &(struct weft_image_load_params){
            .path = path, .part = part, .transfer = {.curve = curve}, .log = &test_log},
        out);
}

static void must_load(const char *path, struct weft_image *out)
{
    if (load_part(path, 0, WEFT_CURVE_AUTO, out) != WEFT_OK)
        fail_msg("%s", test_message);
}

static struct weft_image_save_report must_save(const char *path, enum weft_image_file_kind kind,
                                               const struct weft_image *image, size_t count)
{
    struct weft_image_save_report report = {0};
    test_forget();
    const struct weft_image_save_params params = {
        .path = path, .kind = kind, .verify = true, .log = &test_log};
    if (weft_image_save_parts(image, count, &params, &report) != WEFT_OK)
        fail_msg("%s", test_message);
    return report;
}

// ---- curves -------------------------------------------------------------------------------------

// Every code comes back, of each curve, and what lies between codes becomes the nearest one.
static void test_curves(void **state)
{
    (void)state;
    static const struct weft_transfer curves[] = {{WEFT_CURVE_SRGB, 0.0},
                                                  {WEFT_CURVE_LINEAR, 0.0},
                                                  {WEFT_CURVE_POWER, 2.2},
                                                  {WEFT_CURVE_POWER, 0.5}};
    enum { SIDE = 256, COUNT = SIDE * SIDE };
    float *plane = malloc(COUNT * sizeof *plane);
    int tried = 0;
    for (size_t t = 0; t < WEFT_COUNT(curves); t++) {
        for (int random = 0; random < 2; random++, tried++) {
            for (int i = 0; i < COUNT; i++) {
                const double at = random ? next_random() / 4294967296.0 * 2.0 : i / 65535.0;
                plane[i] = (float)weft_transfer_light(&curves[t], fmin(at, 1.0));
            }
            struct weft_image_channel channel = {
                .name = "Y", .type = WEFT_PIXEL_UNORM16, .plane = plane};
            const struct weft_image image = {.width = SIDE,
                                             .height = SIDE,
                                             .channel_count = 1,
                                             .channels = &channel,
                                             .transfer = curves[t]};
            const char *path = test_path("curve.png");
            assert_true(must_save(path, WEFT_IMAGE_FILE_PNG, &image, 1).clamped == 0);
            struct weft_image read;
            assert_int_equal(load_part(path, 0, WEFT_CURVE_LINEAR, &read), WEFT_OK);
            for (int i = 0; i < COUNT; i++) {
                const double code = 65535.0 * weft_transfer_code(&curves[t], (double)plane[i]);
                const double got = 65535.0 * (double)read.channels[0].plane[i];
                // Half a code, and what a float has to say of a threshold: 2^-24 of its light,
                // which the inverse of a power of 0.5 doubles.
                if (!(fabs(got - code) <= 0.5 + 65535.0 * 0x1p-22))
                    fail_msg("curve %zu: light %.9g is code %.9g, and became %.9g", t,
                             (double)plane[i], code, got);
                if (!random && !(fabs(got - i) < 0.01))
                    fail_msg("curve %zu: code %d became %.9g", t, i, got);
            }
            weft_image_clear(&read);
        }
    }
    assert_int_equal(tried, 8);
    free(plane);
}

// ---- PNG ----------------------------------------------------------------------------------------

// RGBA of 16 bits, by libpng's own expansions.
static uint16_t *png_codes(const char *path)
{
    FILE *f = fopen(path, "rb");
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    uint16_t *out = malloc((size_t)WIDTH * HEIGHT * 4 * sizeof *out);
    png_bytep rows[HEIGHT];
    assert_true(f && png && info && out);
    if (setjmp(png_jmpbuf(png)))
        fail_msg("libpng cannot read %s", path);
    png_init_io(png, f);
    png_read_info(png, info);
    png_set_expand_16(png);
    png_set_gray_to_rgb(png);
    png_set_add_alpha(png, 0xffff, PNG_FILLER_AFTER);
    png_set_swap(png);
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
    assert_int_equal(png_get_rowbytes(png, info), WIDTH * 8);
    for (int y = 0; y < HEIGHT; y++)
        rows[y] = (png_bytep)(out + (size_t)y * WIDTH * 4);
    png_read_image(png, rows);
    png_destroy_read_struct(&png, &info, NULL);
    fclose(f);
    return out;
}

// Colours under no alpha at all are gone; nothing else is.
static void compare_png(const char *from, const char *to)
{
    uint16_t *a = png_codes(from), *b = png_codes(to);
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        for (int c = 0; c < 4; c++) {
            const uint16_t expected = a[4 * i + 3] ? a[4 * i + c] : 0;
            if (b[4 * i + c] != expected)
                fail_msg("%s: pixel %d, channel %d is %d, not %d", from, i, c, b[4 * i + c],
                         expected);
        }
    free(a);
    free(b);
}

static void test_png_codes(void **state)
{
    (void)state;
    static const int colours[] = {PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_RGB, PNG_COLOR_TYPE_PALETTE,
                                  PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGB_ALPHA};
    int tried = 0;
    for (size_t c = 0; c < WEFT_COUNT(colours); c++) {
        for (int bits = 1; bits <= 16; bits *= 2) {
            const bool palette = colours[c] == PNG_COLOR_TYPE_PALETTE;
            if ((palette && bits == 16) || (c && !palette && bits < 8))
                continue;
            const bool transparent = tried % 2 && !(colours[c] & PNG_COLOR_MASK_ALPHA);
            char from[600], to[600];
            snprintf(from, sizeof from, "%s", test_path("from.png"));
            snprintf(to, sizeof to, "%s", test_path("to.png"));
            png_make(&(struct png_recipe){.path = from,
                                          .width = WIDTH,
                                          .height = HEIGHT,
                                          .bits = bits,
                                          .colour = colours[c],
                                          .interlaced = tried % 3 == 0,
                                          .transparent = transparent,
                                          .gamma = tried % 4 == 3 ? 0.5 : 0.0});
            struct weft_image image;
            must_load(from, &image);
            assert_int_equal(image.kind, WEFT_IMAGE_FILE_PNG);
            assert_int_equal(image.channels[0].type,
                             bits == 16 ? WEFT_PIXEL_UNORM16 : WEFT_PIXEL_UNORM8);
            assert_true(must_save(to, WEFT_IMAGE_FILE_PNG, &image, 1).clamped == 0);
            compare_png(from, to);
            // Through TIFF, the same codes; and floats keep their light.
            must_save(test_path("to.tif"), WEFT_IMAGE_FILE_TIFF, &image, 1);
            weft_image_clear(&image);
            must_load(test_path("to.tif"), &image);
            if (tried % 4 != 3) // TIFF says nothing of powers
                must_save(to, WEFT_IMAGE_FILE_PNG, &image, 1);
            compare_png(from, to);
            weft_image_clear(&image);
            tried++;
        }
    }
    assert_int_equal(tried, 5 + 2 + 4 + 2 + 2);
}

// Light is what the file says, and alpha multiplies it.
static void test_png_light(void **state)
{
    (void)state;
    static const struct weft_transfer srgb = {.curve = WEFT_CURVE_SRGB};
    const char *path = test_path("light.png");
    png_make(&(struct png_recipe){.path = path,
                                  .width = WIDTH,
                                  .height = HEIGHT,
                                  .bits = 8,
                                  .colour = PNG_COLOR_TYPE_RGB_ALPHA});
    uint16_t *codes = png_codes(path);
    struct weft_image image;
    must_load(path, &image);
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        for (int c = 0; c < 4; c++) {
            const double code = codes[4 * i + c] / 65535.0, alpha = codes[4 * i + 3] / 65535.0;
            const double light = c == 3 ? code : alpha * weft_transfer_light(&srgb, code);
            // Light, alpha and their product are each rounded once.
            assert_true(fabs((double)image.channels[c].plane[i] - light) <= light * 0x1p-22);
        }
    weft_image_clear(&image);
    assert_int_equal(load_part(path, 0, WEFT_CURVE_LINEAR, &image), WEFT_OK);
    assert_true((double)image.channels[3].plane[5] == (float)(codes[23] / 65535.0));
    weft_image_clear(&image);
    free(codes);
}

// ---- TIFF ---------------------------------------------------------------------------------------

struct tiff_recipe {
    const char *path, *mode;
    enum weft_pixel_type type;
    int samples, alpha; // 1: associated, 2: not
    int compression;
    bool tiled, separate;
    int orientation;
};

static double tiff_value(const struct tiff_recipe *r, int x, int y, int c)
{
    static const double largest[] = {[WEFT_PIXEL_UNORM8] = 255.0, [WEFT_PIXEL_UNORM16] = 65535.0};
    const int colours = r->samples >= 3 ? 3 : 1;
    const unsigned v = (unsigned)(x * 7 + y * 31 + c * 101);
    if (r->type == WEFT_PIXEL_FLOAT || r->type == WEFT_PIXEL_HALF)
        return c == colours && r->alpha ? 0.25 : (double)(v % 1024) / 256.0 - 1.0;
    if (r->type == WEFT_PIXEL_UINT)
        return (double)(v * 2654435761u);
    if (c == colours && r->alpha) // never none
        return 1.0 + v % (unsigned)largest[r->type];
    const double code = v * 257u % ((unsigned)largest[r->type] + 1);
    // What is multiplied is not above its alpha.
    return r->alpha == 1 ? fmin(code, tiff_value(r, x, y, colours)) : code;
}

static void put_sample(const struct tiff_recipe *r, unsigned char *out, double value)
{
    const float f = (float)value;
    const uint32_t u = value > 0.0 ? (uint32_t)value : 0;
    const uint16_t h = r->type == WEFT_PIXEL_HALF ? weft_half_from_float(f) : (uint16_t)u;
    if (r->type == WEFT_PIXEL_FLOAT)
        memcpy(out, &f, 4);
    else if (r->type == WEFT_PIXEL_UINT)
        memcpy(out, &u, 4);
    else if (r->type == WEFT_PIXEL_UNORM8)
        *out = (unsigned char)u;
    else
        memcpy(out, &h, 2);
}

static int sample_bytes(const struct tiff_recipe *r)
{
    return r->type == WEFT_PIXEL_UNORM8                                  ? 1
           : r->type == WEFT_PIXEL_UNORM16 || r->type == WEFT_PIXEL_HALF ? 2
                                                                         : 4;
}

static void set_tiff_tags(TIFF *tiff, const struct tiff_recipe *r)
{
    uint16_t extra[8] = {r->alpha == 1   ? EXTRASAMPLE_ASSOCALPHA
                         : r->alpha == 2 ? EXTRASAMPLE_UNASSALPHA
                                         : EXTRASAMPLE_UNSPECIFIED};
    const int colours = r->samples >= 3 ? 3 : 1;
    const bool integer = r->type != WEFT_PIXEL_FLOAT && r->type != WEFT_PIXEL_HALF;
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, WIDTH);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, HEIGHT);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, r->samples);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8 * sample_bytes(r));
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, integer ? SAMPLEFORMAT_UINT : SAMPLEFORMAT_IEEEFP);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC,
                 colours == 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, r->compression);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG,
                 r->separate ? PLANARCONFIG_SEPARATE : PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_ORIENTATION, r->orientation ? r->orientation : 1);
    if (r->samples > colours)
        TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, r->samples - colours, extra);
    if (r->tiled) {
        TIFFSetField(tiff, TIFFTAG_TILEWIDTH, 16);
        TIFFSetField(tiff, TIFFTAG_TILELENGTH, 16);
    } else {
        TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 4);
    }
}

// A strip or a tile of some samples.
static void put_tiff_block(TIFF *tiff, const struct tiff_recipe *r, int x, int y, int first,
                           int count)
{
    static unsigned char block[WIDTH * 16 * 4 * 8];
    const int wide = r->tiled ? 16 : WIDTH, high = r->tiled ? 16 : 4, bytes = sample_bytes(r);
    const int rows = r->tiled || HEIGHT - y > high ? high : HEIGHT - y;
    for (int j = 0; j < rows; j++)
        for (int i = 0; i < wide; i++)
            for (int c = 0; c < count; c++)
                put_sample(r, block + ((j * wide + i) * count + c) * bytes,
                           tiff_value(r, x + i, y + j, first + c));
    const tmsize_t size = (tmsize_t)rows * wide * count * bytes;
    if (r->tiled)
        assert_true(TIFFWriteTile(tiff, block, (uint32_t)x, (uint32_t)y, 0, (uint16_t)first) > 0);
    else
        assert_true(TIFFWriteEncodedStrip(tiff,
                                          TIFFComputeStrip(tiff, (uint32_t)y, (uint16_t)first),
                                          block, size) == size);
}

static void put_tiff(TIFF *tiff, const struct tiff_recipe *r)
{
    const int wide = r->tiled ? 16 : WIDTH, high = r->tiled ? 16 : 4;
    set_tiff_tags(tiff, r);
    for (int first = 0; first < (r->separate ? r->samples : 1); first++)
        for (int y = 0; y < HEIGHT; y += high)
            for (int x = 0; x < WIDTH; x += wide)
                put_tiff_block(tiff, r, x, y, first, r->separate ? 1 : r->samples);
}

static void tiff_make(const struct tiff_recipe *r)
{
    TIFF *tiff = TIFFOpen(r->path, r->mode ? r->mode : "w");
    assert_non_null(tiff);
    put_tiff(tiff, r);
    TIFFClose(tiff);
}

// What weft makes of a value of a channel.
static double expected_light(const struct tiff_recipe *r, int x, int y, int c)
{
    static const struct weft_transfer srgb = {.curve = WEFT_CURVE_SRGB};
    const int colours = r->samples >= 3 ? 3 : 1;
    const double value = tiff_value(r, x, y, c);
    const bool code = r->type == WEFT_PIXEL_UNORM8 || r->type == WEFT_PIXEL_UNORM16;
    const double largest = r->type == WEFT_PIXEL_UNORM8 ? 255.0 : code ? 65535.0 : 1.0;
    if (c >= colours || r->type == WEFT_PIXEL_UINT)
        return value / largest;
    const double alpha = r->alpha ? tiff_value(r, x, y, colours) / largest : 1.0;
    if (!code)
        return r->alpha == 2 ? value * alpha : value;
    return alpha * weft_transfer_light(&srgb, value / largest / (r->alpha == 1 ? alpha : 1.0));
}

static void check_tiff(const struct tiff_recipe *r, const struct weft_image *image)
{
    assert_int_equal(image->kind, WEFT_IMAGE_FILE_TIFF);
    assert_int_equal(image->channel_count, r->samples);
    assert_int_equal(image->channels[0].type, r->type);
    assert_int_equal(image->tiled, r->tiled);
    for (int c = 0; c < r->samples; c++)
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            const double light = expected_light(r, i % WIDTH, i / WIDTH, c);
            const double got = (double)image->channels[c].plane[i];
            if (!(fabs(got - light) <= fabs(light) * 0x1p-22))
                fail_msg("type %s, %d samples: (%d, %d) of channel %d is %.9g, not %.9g",
                         weft_pixel_type_names[r->type], r->samples, i % WIDTH, i / WIDTH, c, got,
                         light);
        }
}

// The samples of a file that weft wrote, whole in one strip or in tiles, as libtiff reads them.
static void check_written(const struct tiff_recipe *r, const char *path)
{
    TIFF *tiff = TIFFOpen(path, "rc"); // strips as they are
    const int bytes = sample_bytes(r), pixel = bytes * r->samples;
    const int wide = r->tiled ? 16 : WIDTH;
    unsigned char expected[4], *block = malloc((size_t)WIDTH * 64 * 4 * 8);
    assert_non_null(tiff);
    assert_int_equal(TIFFIsTiled(tiff), r->tiled);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const int x = i % WIDTH, y = i / WIDTH;
        if (r->tiled)
            assert_true(TIFFReadTile(tiff, block, (uint32_t)x, (uint32_t)y, 0, 0) > 0);
        else if (i == 0 && TIFFReadEncodedStrip(tiff, 0, block, -1) != HEIGHT * WIDTH * pixel)
            fail_msg("%s of %d samples, compression %d: no strip", weft_pixel_type_names[r->type],
                     r->samples, r->compression);
        const int at = r->tiled ? (y % 16 * wide + x % 16) * pixel : i * pixel;
        for (int c = 0; c < r->samples; c++) {
            // Floats are multiplied by alpha there.
            const bool light = r->type == WEFT_PIXEL_FLOAT || r->type == WEFT_PIXEL_HALF;
            put_sample(r, expected, light ? expected_light(r, x, y, c) : tiff_value(r, x, y, c));
            if (memcmp(block + at + c * bytes, expected, (size_t)bytes))
                fail_msg("%s of %d samples, alpha %d, compression %d, tiled %d: (%d, %d) of "
                         "channel %d is another",
                         weft_pixel_type_names[r->type], r->samples, r->alpha, r->compression,
                         r->tiled, x, y, c);
        }
    }
    free(block);
    TIFFClose(tiff);
}

static void test_tiff_codes(void **state)
{
    (void)state;
    static const int compressions[] = {COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_PACKBITS,
                                       COMPRESSION_ADOBE_DEFLATE};
    static const enum weft_image_compression kept[] = {WEFT_IMAGE_NONE, WEFT_IMAGE_LZW,
                                                       WEFT_IMAGE_RLE, WEFT_IMAGE_ZIP};
    static const char *const modes[] = {"w", "wb", "w8", "wb8", "wl"};
    static const struct {
        int samples, alpha;
    } shapes[] = {{1, 0}, {2, 1}, {2, 2}, {3, 0}, {4, 1}, {4, 2}, {5, 2}, {6, 0}};
    int tried = 0;
    for (int type = 0; type < WEFT_PIXEL_TYPE_COUNT; type++) {
        for (size_t s = 0; s < WEFT_COUNT(shapes); s++, tried++) {
            char from[600], to[600];
            snprintf(from, sizeof from, "%s", test_path("from.tif"));
            snprintf(to, sizeof to, "%s", test_path("to.tif"));
            const int way = tried + type;
            const struct tiff_recipe r = {.path = from,
                                          .mode = modes[way % 5],
                                          .type = (enum weft_pixel_type)type,
                                          .samples = shapes[s].samples,
                                          .alpha = type == WEFT_PIXEL_UINT ? 0 : shapes[s].alpha,
                                          .compression = compressions[way % 4],
                                          .tiled = way / 2 % 2,
                                          .separate = way / 4 % 2};
            struct weft_image image;
            tiff_make(&r);
            must_load(from, &image);
            assert_int_equal(image.compression, kept[way % 4]);
            check_tiff(&r, &image);
            assert_true(must_save(to, WEFT_IMAGE_FILE_TIFF, &image, 1).clamped == 0);
            check_written(&r, to);
            weft_image_clear(&image);
        }
    }
    assert_int_equal(tried, 40);
}

// What is shown at (x, y) is stored where TIFF 6.0, page 36, says: row 0 is one side, column 0
// another.
static void stored_at(int orientation, int x, int y, int *column, int *row)
{
    const bool turned = orientation > 4;
    const int width = turned ? HEIGHT : WIDTH, height = turned ? WIDTH : HEIGHT;
    static const struct {
        bool right, bottom; // row 0 or column 0 begins there
    } corner[] = {{0, 0}, {0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const int across = corner[orientation].right ? width - 1 - x : x;
    const int down = corner[orientation].bottom ? height - 1 - y : y;
    *column = turned ? down : across;
    *row = turned ? across : down;
}

static void test_orientations(void **state)
{
    (void)state;
    for (int o = 1; o <= 8; o++) {
        const struct tiff_recipe r = {.path = test_path("turned.tif"),
                                      .type = WEFT_PIXEL_UINT,
                                      .samples = 3,
                                      .compression = COMPRESSION_NONE,
                                      .tiled = o % 3 == 0,
                                      .separate = o % 2,
                                      .orientation = o};
        struct weft_image image;
        tiff_make(&r);
        must_load(r.path, &image);
        assert_int_equal(image.width, o > 4 ? HEIGHT : WIDTH);
        assert_int_equal(image.height, o > 4 ? WIDTH : HEIGHT);
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            int column, row;
            stored_at(o, i % image.width, i / image.width, &column, &row);
            for (int c = 0; c < 3; c++)
                assert_int_equal(image.channels[c].integers[i],
                                 (uint32_t)tiff_value(&r, column, row, c));
        }
        weft_image_clear(&image);
    }
}

// Bits, palettes and white as nothing.
static void test_expanded(void **state)
{
    (void)state;
    static const struct weft_transfer srgb = {.curve = WEFT_CURVE_SRGB};
    static const int bits_of[] = {1, 2, 4, 8};
    uint16_t map[3][256];
    int tried = 0;
    for (int i = 0; i < 3 * 256; i++)
        map[i / 256][i % 256] = (uint16_t)(i * 251);
    for (int kind = 0; kind < 3; kind++) { // black, white, palette
        for (size_t b = 0; b < WEFT_COUNT(bits_of); b++, tried++) {
            const int bits = bits_of[b], largest = (1 << bits) - 1;
            TIFF *tiff = TIFFOpen(test_path("bits.tif"), "w");
            TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 16);
            TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 1);
            TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
            TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, bits);
            TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC,
                         kind == 2   ? PHOTOMETRIC_PALETTE
                         : kind == 1 ? PHOTOMETRIC_MINISWHITE
                                     : PHOTOMETRIC_MINISBLACK);
            if (kind == 2)
                TIFFSetField(tiff, TIFFTAG_COLORMAP, map[0], map[1], map[2]);
            unsigned char row[16] = {0};
            for (int x = 0; x < 16; x++)
                row[x * bits / 8] |= (unsigned char)((x & largest) << (8 - bits - x * bits % 8));
            assert_int_equal(TIFFWriteEncodedStrip(tiff, 0, row, 2 * bits), 2 * bits);
            TIFFClose(tiff);
            struct weft_image image;
            must_load(test_path("bits.tif"), &image);
            assert_int_equal(image.channel_count, kind == 2 ? 3 : 1);
            assert_int_equal(image.codes.bits, bits);
            for (int x = 0; x < 16; x++) {
                const int index = x & largest;
                const double code = kind == 2   ? map[1][index] / 65535.0
                                    : kind == 1 ? (double)(largest - index) / largest
                                                : (double)index / largest;
                const double got = (double)image.channels[kind == 2 ? 1 : 0].plane[x];
                assert_true(fabs(got - weft_transfer_light(&srgb, code)) <= 0x1p-23);
            }
            weft_image_clear(&image);
        }
    }
    assert_int_equal(tried, 12);
}

// Directories are parts, with names; what EXR has attributes for comes and goes.
static void test_parts(void **state)
{
    (void)state;
    enum { PARTS = 3 };
    float planes[PARTS][4] = {{0.0f, 0.25f, 0.5f, 1.0f}, {1.0f, 1.0f, 0.0f, 0.0f}, {0.5f}};
    struct weft_image parts[PARTS];
    struct weft_image_channel channels[PARTS];
    static const unsigned char density[4] = {0, 0, 0x96, 0x43}, aspect[4] = {0, 0, 0, 0x40};
    struct weft_image_attribute attributes[] = {{"comments", "string", "a text", 6},
                                                {"xDensity", "float", density, 4},
                                                {"pixelAspectRatio", "float", aspect, 4}};
    for (int p = 0; p < PARTS; p++) {
        channels[p] =
            (struct weft_image_channel){.name = "Y", .type = WEFT_PIXEL_FLOAT, .plane = planes[p]};
        parts[p] = (struct weft_image){.width = 2,
                                       .height = 2,
                                       .channel_count = 1,
                                       .channels = &channels[p],
                                       .attribute_count = WEFT_COUNT(attributes),
                                       .attributes = attributes};
        snprintf(parts[p].name, sizeof parts[p].name, "page %d", p);
    }
    const char *path = test_path("parts.tif");
    must_save(path, WEFT_IMAGE_FILE_TIFF, parts, PARTS);
    struct weft_image_list list;
    assert_int_equal(weft_image_list_load(
                         &(struct weft_image_load_params){.path = path, .log = &test_log}, &list),
                     WEFT_OK);
    assert_int_equal(list.count, PARTS);
    for (int p = 0; p < PARTS; p++) {
        struct weft_image image;
        assert_string_equal(list.images[p].name, parts[p].name);
        assert_int_equal(load_part(path, p, WEFT_CURVE_AUTO, &image), WEFT_OK);
        assert_memory_equal(image.channels[0].plane, planes[p], sizeof planes[p]);
        for (size_t i = 0; i < WEFT_COUNT(attributes); i++) {
            const struct weft_image_attribute *a = weft_image_find(&image, attributes[i].name);
            assert_non_null(a);
            assert_string_equal(a->type, attributes[i].type);
            assert_int_equal(a->size, attributes[i].size);
            assert_memory_equal(a->data, attributes[i].data, a->size);
        }
        weft_image_clear(&image);
    }
    weft_image_list_clear(&list);
    struct weft_image none;
    assert_int_equal(load_part(path, PARTS, WEFT_CURVE_AUTO, &none), WEFT_ERR_ARGUMENT);
    assert_non_null(strstr(test_message, "there is no part 3: it has 3"));
}

// ---- what is refused ----------------------------------------------------------------------------

static void test_refused_channels(void **state)
{
    (void)state;
    float plane[4] = {-1.0f, 2.0f, NAN, 0.5f};
    struct weft_image_channel depth[] = {{.name = "Y", .type = WEFT_PIXEL_UNORM8, .plane = plane},
                                         {.name = "Z", .type = WEFT_PIXEL_UNORM8, .plane = plane}};
    struct weft_image_channel halves[] = {{.name = "Y", .type = WEFT_PIXEL_HALF, .plane = plane}};
    struct weft_image_channel two[] = {{.name = "R", .type = WEFT_PIXEL_UNORM8, .plane = plane},
                                       {.name = "G", .type = WEFT_PIXEL_UNORM8, .plane = plane}};
    struct weft_image_channel mixed[] = {{.name = "Y", .type = WEFT_PIXEL_FLOAT, .plane = plane},
                                         {.name = "A", .type = WEFT_PIXEL_HALF, .plane = plane}};
    const struct {
        struct weft_image_channel *channels;
        size_t count;
        enum weft_image_file_kind kind;
        const char *message;
    } cases[] = {{depth, 2, WEFT_IMAGE_FILE_PNG, "no place for channel Z"},
                 {halves, 1, WEFT_IMAGE_FILE_PNG, "not of half"},
                 {two, 2, WEFT_IMAGE_FILE_PNG, "there are 2, the first of them R"},
                 {mixed, 2, WEFT_IMAGE_FILE_TIFF, "Y is float, A is half"},
                 {depth, 1, WEFT_IMAGE_FILE_EXR, "which EXR files do not have"}};
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        const struct weft_image image = {.width = 2,
                                         .height = 2,
                                         .channel_count = cases[i].count,
                                         .channels = cases[i].channels};
        const struct weft_image_save_params params = {
            .path = test_path("refused"), .kind = cases[i].kind, .log = &test_log};
        test_forget();
        assert_int_equal(weft_image_save(&image, &params), WEFT_ERR_UNSUPPORTED);
        assert_int_equal(test_errors, 1);
        if (!strstr(test_message, cases[i].message))
            fail_msg("'%s' lacks '%s'", test_message, cases[i].message);
        assert_int_equal(access(params.path, F_OK), -1);
    }
    const struct weft_image clamped = {
        .width = 2, .height = 2, .channel_count = 1, .channels = depth};
    assert_int_equal(must_save(test_path("c.png"), WEFT_IMAGE_FILE_PNG, &clamped, 1).clamped, 3);
}

// A little-endian TIFF file of one directory by hand.
struct entry {
    uint16_t tag, type;
    uint32_t count, value;
};

static void make_lying(const char *path, const struct entry *entries, int count, uint32_t next)
{
    FILE *f = fopen(path, "wb");
    const uint16_t entry_count = (uint16_t)count;
    assert_non_null(f);
    fwrite("II*\0\x08\0\0\0", 1, 8, f);
    fwrite(&entry_count, 2, 1, f);
    for (int i = 0; i < count; i++) {
        fwrite(&entries[i].tag, 2, 1, f);
        fwrite(&entries[i].type, 2, 1, f);
        fwrite(&entries[i].count, 4, 1, f);
        fwrite(&entries[i].value, 4, 1, f);
    }
    fwrite(&next, 4, 1, f);
    for (int i = 0; i < 64; i++)
        fputc(i, f);
    fclose(f);
}

// Each is the good one, 4 x 4 grey pixels, but for one entry.
static void test_lies(void **state)
{
    (void)state;
    enum { LONG = 4, SHORT = 3, ENTRIES = 9 };
    static const struct entry good[ENTRIES] = {
        {256, LONG, 1, 4},  {257, LONG, 1, 4},  {258, SHORT, 1, 8},
        {259, SHORT, 1, 1}, {262, SHORT, 1, 1}, {273, LONG, 1, 124},
        {277, SHORT, 1, 1}, {278, LONG, 1, 4},  {279, LONG, 1, 16}};
    static const struct {
        int at;
        struct entry entry;
        enum weft_result result; // WEFT_OK: only that it is not read
    } lies[] = {
        {0, {256, LONG, 1, 0x7fffffff}, WEFT_ERR_LIMIT},
        {0, {256, LONG, 1, 0}, WEFT_OK},
        {0, {256, LONG, 1, 500000000}, WEFT_OK},
        {1, {257, LONG, 1, 0xffffffff}, WEFT_OK},
        {1, {257, LONG, 1, 400000000}, WEFT_OK},
        {2, {258, SHORT, 1, 64}, WEFT_ERR_UNSUPPORTED},
        {2, {258, SHORT, 1, 0}, WEFT_OK},
        {3, {259, SHORT, 1, 34712}, WEFT_OK},
        {4, {262, SHORT, 1, 5}, WEFT_ERR_UNSUPPORTED},
        {5, {273, LONG, 1, 0x7ffffff0}, WEFT_OK},
        {5, {273, LONG, 0x40000000, 124}, WEFT_OK},
        {6, {277, SHORT, 1, 0xffff}, WEFT_OK},
        {7, {278, LONG, 1, 0}, WEFT_OK},
    };
    const char *path = test_path("lie.tif");
    struct weft_image image;
    make_lying(path, good, ENTRIES, 0);
    must_load(path, &image);
    weft_image_clear(&image);
    for (size_t i = 0; i < WEFT_COUNT(lies); i++) {
        struct entry entries[ENTRIES];
        memcpy(entries, good, sizeof good);
        entries[lies[i].at] = lies[i].entry;
        make_lying(path, entries, ENTRIES, 0);
        const enum weft_result res = load_part(path, 0, WEFT_CURVE_AUTO, &image);
        if (res == WEFT_OK || test_errors != 1 || (lies[i].result && res != lies[i].result))
            fail_msg("lie %zu: %s, %d lines: %s", i, weft_result_text(res), test_errors,
                     test_message);
    }
    make_lying(path, good, ENTRIES, 8); // it is its own next
    assert_int_equal(load_part(path, 0, WEFT_CURVE_AUTO, &image), WEFT_ERR_FORMAT);
}

// A chain of directories that has more of them than a file may have parts.
static void test_many_parts(void **state)
{
    (void)state;
    enum { PARTS = 4000, BYTES = 2 + 12 * 9 + 4 };
    static const struct {
        uint16_t tag, type;
        uint32_t value;
    } tags[9] = {{256, 4, 1}, {257, 4, 1}, {258, 3, 8}, {259, 3, 1}, {262, 3, 1},
                 {273, 4, 8}, {277, 3, 1}, {278, 4, 1}, {279, 4, 1}};
    FILE *f = fopen(test_path("many.tif"), "wb");
    assert_non_null(f);
    fwrite("II*\0\x10\0\0\0pixels..", 1, 16, f);
    for (uint32_t p = 0; p < PARTS; p++) {
        const uint16_t count = 9;
        const uint32_t one = 1, next = p + 1 < PARTS ? 16 + (p + 1) * BYTES : 0;
        fwrite(&count, 2, 1, f);
        for (int i = 0; i < 9; i++) {
            fwrite(&tags[i].tag, 2, 1, f);
            fwrite(&tags[i].type, 2, 1, f);
            fwrite(&one, 4, 1, f);
            fwrite(&tags[i].value, 4, 1, f);
        }
        fwrite(&next, 4, 1, f);
    }
    fclose(f);
    struct weft_image image;
    assert_int_equal(load_part(test_path("many.tif"), 0, WEFT_CURVE_AUTO, &image), WEFT_ERR_LIMIT);
    assert_non_null(strstr(test_message, "more than 1024 parts"));
}

static int setting(const char *name, int otherwise)
{
    const char *text = getenv(name);
    return text && *text ? atoi(text) : otherwise;
}

// Bits, bytes and words of good files; the directory lies at the end.
static void test_mutations(void **state)
{
    (void)state;
    static const uint32_t words[] = {0, 1, 0x7fffffff, 0x80000000, 0xffffffff, 0x10000, 4096};
    const int count = setting("WEFT_MUTATIONS", 40), seed = setting("WEFT_MUTATION_SEED", 1);
    const int fds = test_count_entries("/proc/self/fd");
    int read = 0, refused = 0;
    for (int i = 0; i < count; i++) {
        random_state = (uint64_t)seed << 32 | (uint64_t)i;
        const struct tiff_recipe r = {.path = test_path("mutant.tif"),
                                      .type = (enum weft_pixel_type)(i % 5),
                                      .samples = 1 + i % 4,
                                      .compression = i % 3 ? COMPRESSION_LZW : COMPRESSION_NONE,
                                      .tiled = i / 2 % 2,
                                      .separate = i / 4 % 2};
        tiff_make(&r);
        FILE *f = fopen(r.path, "r+b");
        fseek(f, 0, SEEK_END);
        const long size = ftell(f), head = size < 400 ? size : 400;
        for (int k = 1 + (int)(next_random() % 4); k > 0; k--) {
            const uint32_t word =
                next_random() % 2 ? next_random() : words[next_random() % WEFT_COUNT(words)];
            const long at = next_random() % 4 ? size - 1 - (long)(next_random() % (uint32_t)head)
                                              : (long)(next_random() % (uint32_t)size);
            fseek(f, at, SEEK_SET);
            fwrite(&word, 1, 1 + next_random() % 4, f);
        }
        fclose(f);
        struct weft_image image;
        const struct weft_image_load_params params = {
            .path = r.path,
            .limits = {.memory_bytes = UINT64_C(1) << 30, .cpu_seconds = 5, .wall_seconds = 10},
            .log = &test_log};
        test_forget();
        const enum weft_result res = weft_image_load(&params, &image);
        weft_image_clear(&image);
        const bool clean =
            res == WEFT_OK || ((res == WEFT_ERR_FORMAT || res == WEFT_ERR_LIMIT ||
                                res == WEFT_ERR_UNSUPPORTED || res == WEFT_ERR_READER) &&
                               test_errors == 1);
        if (!clean)
            fail_msg("mutation %d of seed %d: %s, %d lines: %s", i, seed, weft_result_text(res),
                     test_errors, test_message);
        read += res == WEFT_OK;
        refused += res != WEFT_OK;
    }
    print_message("%d damaged files: %d read, %d refused\n", count, read, refused);
    assert_true(count < 40 || (read && refused));
    assert_int_equal(test_count_entries("/proc/self/fd"), fds);
}

// ---- EXR levels ---------------------------------------------------------------------------------

// All levels come back through the C++ library, of every compression, and tiles of odd sizes.
static void test_levels(void **state)
{
    (void)state;
    static const int tiles[][2] = {{64, 64}, {16, 8}, {7, 40}, {0, 0}};
    int tried = 0;
    for (int compression = 0; compression <= WEFT_IMAGE_PIZ; compression++) {
        for (size_t t = 0; t < WEFT_COUNT(tiles); t++, tried++) {
            const int type = tried % 2 ? WEFT_PIXEL_HALF : WEFT_PIXEL_FLOAT;
            const int count = weft_image_level_count(70, 45);
            struct weft_image level[8];
            struct weft_image_channel channels[8];
            assert_int_equal(count, 7);
            for (int l = 0; l < count; l++) {
                const int width = weft_image_level_size(70, l),
                          height = weft_image_level_size(45, l);
                channels[l] = (struct weft_image_channel){
                    .name = "Y", .type = type, .plane = malloc((size_t)(width * height) * 4)};
                for (int i = 0; i < width * height; i++)
                    channels[l].plane[i] = (float)(next_random() % 2048) / 16.0f;
                level[l] = (struct weft_image){.x = l ? 0 : -5,
                                               .y = l ? 0 : 9,
                                               .width = width,
                                               .height = height,
                                               .channel_count = 1,
                                               .channels = &channels[l]};
            }
            level[0].compression = (enum weft_image_compression)compression;
            level[0].tiled = true;
            memcpy(level[0].tile, tiles[t], sizeof level[0].tile);
            level[0].levels = WEFT_IMAGE_LEVELS_MIP;
            level[0].mips = level + 1;
            const char *path = test_path("mip.exr");
            must_save(path, WEFT_IMAGE_FILE_EXR, level, 1);
            struct weft_image read;
            must_load(path, &read);
            assert_true(read.tiled && read.levels == WEFT_IMAGE_LEVELS_MIP);
            assert_int_equal(read.tile[0], tiles[t][0] ? tiles[t][0] : 64);
            weft_image_clear(&read);
            for (int l = 0; l < count; l++) {
                char why[200] = "";
                int size[2], levels;
                float *values = exr_peer_level(path, "Y", l, size, &levels, why, sizeof why);
                if (!values)
                    fail_msg("level %d: %s", l, why);
                assert_int_equal(levels, count);
                assert_true(size[0] == level[l].width && size[1] == level[l].height);
                assert_memory_equal(values, channels[l].plane, (size_t)(size[0] * size[1]) * 4);
                free(values);
            }
            level[1].width++;
            test_forget();
            assert_int_equal(
                weft_image_save(level,
                                &(struct weft_image_save_params){.path = path, .log = &test_log}),
                WEFT_ERR_ARGUMENT);
            assert_non_null(strstr(test_message, "mip level 1 is 36 x 22"));
            for (int l = 0; l < count; l++)
                free(channels[l].plane);
        }
    }
    assert_int_equal(tried, 20);
}

static int start(void **state)
{
    TIFFSetWarningHandler(NULL);
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 1);
    return test_enter_folder(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_curves),       cmocka_unit_test(test_png_codes),
        cmocka_unit_test(test_png_light),    cmocka_unit_test(test_tiff_codes),
        cmocka_unit_test(test_orientations), cmocka_unit_test(test_expanded),
        cmocka_unit_test(test_parts),        cmocka_unit_test(test_refused_channels),
        cmocka_unit_test(test_lies),         cmocka_unit_test(test_many_parts),
        cmocka_unit_test(test_mutations),    cmocka_unit_test(test_levels),
    };
    return cmocka_run_group_tests(tests, start, test_leave_folder);
}
