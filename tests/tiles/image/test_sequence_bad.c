// SPDX-License-Identifier: BSD-3-Clause
// Sequences of bad files, and of readers that do what they should not: each costs one frame, whose
// message says why, and no descriptor, process or memory.
// WEFT_MUTATIONS is the number of damaged files of a kind (default 150), WEFT_MUTATION_SEED their
// seed (default 1).
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/resource.h>

#include <cmocka.h>

#include "filter/check.h"
#include "tests/support/exr_maker.h"
#include "tests/support/files.h"
#include "tests/tiles/image/png_maker.h"
#include "tests/tiles/image/sequences.h"

#if defined(__SANITIZE_ADDRESS__)
enum { SANITIZED = 1 };
#else
enum { SANITIZED = 0 };
#endif

enum { SIDE = 24, PIXELS = SIDE * SIDE };

static void save_exr(const char *path, int compression)
{
    static float plane[PIXELS];
    for (int i = 0; i < PIXELS; i++)
        plane[i] = (float)(i * i % 991);
    struct weft_image_channel channels[] = {{.name = "A", .type = WEFT_PIXEL_HALF, .plane = plane},
                                            {.name = "Z", .plane = plane}};
    const struct weft_image image = {.width = SIDE,
                                     .height = SIDE,
                                     .compression = (enum weft_image_compression)compression,
                                     .channel_count = 2,
                                     .channels = channels};
    const struct weft_image_save_params params = {.path = path, .log = &test_log};
    assert_int_equal(weft_image_save(&image, &params), WEFT_OK);
}

static void save_png(const char *path, int bits, bool interlaced)
{
    png_make(&(struct png_recipe){.path = path,
                                  .width = SIDE,
                                  .height = SIDE,
                                  .bits = bits,
                                  .colour = PNG_COLOR_TYPE_RGB,
                                  .interlaced = interlaced,
                                  .gamma = 0.5});
}

static void save_part(const char *path, const char *from, double share)
{
    size_t size;
    char *data = test_read_file(from, &size);
    test_write_file(path, data, (size_t)((double)size * share));
    free(data);
}

static void save_unread(const char *path, exr_storage_t storage, int sampling)
{
    const float none[PIXELS] = {0};
    const struct exr_recipe recipe = {.path = path,
                                      .storage = storage,
                                      .compression = EXR_COMPRESSION_NONE,
                                      .type = EXR_PIXEL_FLOAT,
                                      .width = SIDE,
                                      .height = SIDE,
                                      .sampling = sampling,
                                      .pixels = none};
    assert_int_equal(exr_make(&recipe), EXR_ERR_SUCCESS);
}

// ---- bad files among good ones ------------------------------------------------------------------

struct bad_file {
    const char *name;
    enum weft_result result;
    const char *message;
};

static const struct bad_file bad_files[] = {
    {"good.exr", WEFT_OK, NULL},
    {"missing", WEFT_ERR_OPEN, "No such file"},
    {"", WEFT_ERR_OPEN, "cannot open"},
    {"folder", WEFT_ERR_OPEN, "directory"},
    {"pipe", WEFT_ERR_OPEN, "not a regular file"},
    {"empty", WEFT_ERR_FORMAT, "the file is empty"},
    {"text.exr", WEFT_ERR_FORMAT, "neither an EXR, a PNG nor a TIFF file: it starts with bytes 68 65"},
    {"short.png", WEFT_ERR_FORMAT, "neither an EXR, a PNG nor a TIFF"},
    {"signature.png", WEFT_ERR_FORMAT, "cut short"},
    {"magic.exr", WEFT_ERR_FORMAT, NULL},
    {"good.png", WEFT_OK, NULL},
    {"cut.exr", WEFT_ERR_FORMAT, NULL},
    {"cut.png", WEFT_ERR_FORMAT, "cut short"},
    {"end.png", WEFT_ERR_FORMAT, "cut short"}, // all pixels, but not its end
    {"deep.exr", WEFT_ERR_UNSUPPORTED, "deep images are unsupported"},
    {"sampled.exr", WEFT_ERR_UNSUPPORTED, "subsampled (2 x 2)"},
    {"large.exr", WEFT_ERR_LIMIT, "output limit is 20000"},
    {"large.png", WEFT_ERR_LIMIT, "output limit is 20000"},
    {"named.png", WEFT_OK, NULL}, // an EXR file
    {"named.exr", WEFT_OK, NULL}, // a PNG file
    {"good.exr", WEFT_OK, NULL},
};

static void make_bad_files(void)
{
    save_exr(test_path("good.exr"), WEFT_IMAGE_ZIP);
    save_exr(test_path("named.png"), WEFT_IMAGE_ZIP);
    save_png(test_path("good.png"), 8, false);
    save_png(test_path("named.exr"), 16, true);
    assert_int_equal(mkdir(test_path("folder"), 0700), 0);
    assert_int_equal(mkfifo(test_path("pipe"), 0600), 0);
    test_write_file(test_path("empty"), "", 0);
    test_write_file(test_path("text.exr"), "hello", 5);
    test_write_file(test_path("short.png"), "\x89PNG", 4);
    test_write_file(test_path("signature.png"), "\x89PNG\r\n\x1a\n", 8);
    test_write_file(test_path("magic.exr"), "\x76\x2f\x31\x01", 4);
    save_part(test_path("cut.exr"), test_path("good.exr"), 0.7);
    save_part(test_path("cut.png"), test_path("good.png"), 0.7);
    save_part(test_path("end.png"), test_path("good.png"), 1.0 - 1e-9);
    save_unread(test_path("deep.exr"), EXR_STORAGE_DEEP_SCANLINE, 1);
    save_unread(test_path("sampled.exr"), EXR_STORAGE_SCANLINE, 2);
    png_make(&(struct png_recipe){.path = test_path("large.png"),
                                  .width = 100,
                                  .height = 201,
                                  .bits = 8,
                                  .colour = PNG_COLOR_TYPE_GRAY});
    static const float plane[50 * 150];
    struct weft_image_channel channel = {.name = "Y", .plane = (float *)(uintptr_t)plane};
    const struct weft_image image = {
        .width = 50, .height = 150, .channel_count = 1, .channels = &channel};
    assert_int_equal(
        weft_image_save(&image, &(struct weft_image_save_params){.path = test_path("large.exr"),
                                                                 .log = &test_log}),
        WEFT_OK);
}

static void test_bad_files(void **state)
{
    (void)state;
    enum { COUNT = WEFT_COUNT(bad_files) };
    const char *names[COUNT];
    const int fds = test_count_entries("/proc/self/fd");
    make_bad_files();
    for (int i = 0; i < COUNT; i++)
        names[i] = *bad_files[i].name ? strdup(test_path(bad_files[i].name)) : strdup("");
    for (int readers = 1; readers <= 4; readers++) {
        struct names list = {.name = names};
        weft_image_sequence *sequence = NULL;
        assert_int_equal(
            weft_image_sequence_create(weft_image_sequence_params(.count = COUNT, .name = name_of,
                                                                  .priv = &list, .readers = readers,
                                                                  .limits = {.output_bytes = 20000},
                                                                  .log = &test_log),
                                       &sequence),
            WEFT_OK);
        for (int i = 0; i < COUNT; i++) {
            const struct bad_file *bad = &bad_files[i];
            if (bad->result == WEFT_OK) {
                const struct weft_image_frame *frame = good_frame(sequence, i);
                assert_int_equal(frame->image.width, SIDE);
                continue;
            }
            const char *message = bad_frame(sequence, i, bad->result);
            if (bad->message && !strstr(message, bad->message))
                fail_msg("'%s' lacks '%s'", message, bad->message);
        }
        finish(&sequence);
        assert_int_equal(test_count_entries("/proc/self/fd"), fds);
        assert_int_equal(count_children(), 0);
    }
    for (int i = 0; i < COUNT; i++)
        free((void *)(uintptr_t)names[i]);
    rmdir(test_path("folder"));
}

// ---- readers that misbehave ---------------------------------------------------------------------

// Good files are 'y'; 'z' ends any process that has read a file before.
static void test_liars(void **state)
{
    (void)state;
    static const char kinds[] = "yaybyczdyeyfyzyygyhyiyjykylymynyoypyqyryzsyty";
    enum { COUNT = sizeof kinds - 1 };
    const char *names[COUNT];
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR "/liars", 1);
    for (int i = 0; i < COUNT; i++) {
        char name[20], data[] = "\x89PNG\r\n\x1a\n?";
        snprintf(name, sizeof name, "%d", i);
        names[i] = strdup(test_path(name));
        data[8] = kinds[i];
        test_write_file(names[i], data, 9);
    }
    for (int readers = 1; readers <= 3; readers += 2) {
        int bad = 0;
        struct names list = {.name = names};
        weft_image_sequence *sequence = NULL;
        assert_int_equal(
            weft_image_sequence_create(weft_image_sequence_params(.count = COUNT, .name = name_of,
                                                                  .priv = &list, .readers = readers,
                                                                  .limits = {.wall_seconds = 1},
                                                                  .log = &test_log),
                                       &sequence),
            WEFT_OK);
        for (int i = 0; i < COUNT; i++) {
            if (kinds[i] == 'y' || kinds[i] == 'z') {
                const struct weft_image_frame *frame = good_frame(sequence, i);
                assert_memory_equal(frame->plane[0].values, "\1\2\3\4", 4);
                assert_string_equal(frame->image.channels[0].name, "Y");
                continue;
            }
            const char *message =
                bad_frame(sequence, i, kinds[i] == 'r' ? WEFT_ERR_LIMIT : WEFT_ERR_READER);
            assert_non_null(strstr(message, "weft-read-"));
            bad++;
        }
        assert_int_equal(bad, 20);
        finish(&sequence);
        assert_int_equal(count_children(), 0);
    }
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 1);
    for (int i = 0; i < COUNT; i++)
        free((void *)(uintptr_t)names[i]);
}

// A reader that somebody kills, or stops for longer than it may take, costs no frame.
static void test_killed_readers(void **state)
{
    (void)state;
    enum { COUNT = 60 };
    const char *names[COUNT], *name = test_path("good.exr");
    save_exr(name, WEFT_IMAGE_ZIP);
    for (int i = 0; i < COUNT; i++)
        names[i] = name;
    struct names list = {.name = names};
    weft_image_sequence *sequence = NULL;
    assert_int_equal(
        weft_image_sequence_create(
            weft_image_sequence_params(.count = COUNT, .name = name_of, .priv = &list, .readers = 2,
                                       .limits = {.wall_seconds = 1}, .log = &test_log),
            &sequence),
        WEFT_OK);
    int hit = 0;
    for (int i = 0; i < COUNT; i++) {
        pid_t reader = 0;
        good_frame(sequence, i);
        if (i % 10 == 5 && children(&reader)) {
            kill(reader, i == 25 ? SIGSTOP : SIGKILL);
            hit++;
        }
    }
    assert_int_equal(hit, 6);
    finish(&sequence);
    assert_int_equal(count_children(), 0);
}

static void test_no_program(void **state)
{
    (void)state;
    const char *name = test_path("good.exr");
    const struct weft_image_frame *frame = NULL;
    save_exr(name, WEFT_IMAGE_ZIP);
    setenv("WEFT_LIBEXEC", "/nonexistent", 1);
    struct names list = {.name = &name};
    weft_image_sequence *sequence = begin(&list, 1, 0);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(weft_image_sequence_next(sequence, &frame), WEFT_ERR_READER);
        assert_null(frame);
    }
    assert_non_null(strstr(test_message, "weft-read-exr is not in /nonexistent"));
    assert_int_equal(test_errors, 1);
    weft_image_sequence_destroy(&sequence);
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 1);
    test_forget();
}

// ---- bombs --------------------------------------------------------------------------------------

static long children_kilobytes(void)
{
    struct rusage used;
    getrusage(RUSAGE_CHILDREN, &used);
    return used.ru_maxrss;
}

// Sizes that are declared, and data that unpacks to far more than it is. First: it measures the
// largest child so far.
static void test_bombs(void **state)
{
    (void)state;
    enum { COUNT = 8, MIB = 1 << 20 };
    const uint32_t most = 0x7fffffff;
    const char *names[COUNT];
    static const char text[] = "key\0", profile[] = "name\0";
    FILE *f;
    for (int i = 0; i < COUNT; i++) {
        char name[20];
        snprintf(name, sizeof name, "bomb%d", i);
        names[i] = strdup(test_path(name));
        f = png_begin(names[i],
                      i == 0   ? most
                      : i == 1 ? 1
                      : i == 2 ? 60000
                               : 16,
                      i == 0   ? most
                      : i == 1 ? most
                      : i == 2 ? 60000
                               : 16,
                      8, PNG_COLOR_TYPE_GRAY);
        if (i == 4)
            png_zeros(f, "zTXt", text, 5, 100 * MIB);
        if (i == 5)
            png_zeros(f, "iCCP", profile, 6, 100 * MIB);
        for (int k = 0; i == 6 && k < 50000; k++)
            png_chunk(f, "tEXt", "key\0value", 9);
        png_zeros(f, "IDAT", "", 0, i == 3 ? 100 * MIB : 17 * 16);
        if (i == 7)
            png_chunk(f, "caNC", "", 0);
        png_end(f);
    }
    struct names list = {.name = names};
    weft_image_sequence *sequence = begin(&list, COUNT, 2);
    const double start = weft_now_seconds();
    assert_non_null(strstr(bad_frame(sequence, 0, WEFT_ERR_FORMAT), "IHDR"));
    bad_frame(sequence, 1, WEFT_ERR_FORMAT);
    assert_non_null(strstr(bad_frame(sequence, 2, WEFT_ERR_LIMIT), "times as many"));
    for (int i = 3; i < COUNT; i++)
        good_frame(sequence, i);
    finish(&sequence);
    print_message("bombs: %.2f s, readers of up to %ld MiB\n", weft_now_seconds() - start,
                  children_kilobytes() >> 10);
    assert_true(weft_now_seconds() - start < 20.0);
    if (!SANITIZED)
        assert_true(children_kilobytes() < 64 << 10);
    for (int i = 0; i < COUNT; i++)
        free((void *)(uintptr_t)names[i]);
}

// ---- mutations ----------------------------------------------------------------------------------

static uint64_t random_state;

static uint64_t next_random(void)
{
    uint64_t z = random_state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return z ^ z >> 31;
}

static int setting(const char *name, int otherwise)
{
    const char *text = getenv(name);
    return text && *text ? atoi(text) : otherwise;
}

// Checksums put right again, so that what is behind them meets the damage.
static void mend_png(unsigned char *data, size_t size)
{
    for (size_t at = 8; at + 12 <= size;) {
        const uint32_t length = (uint32_t)data[at] << 24 | (uint32_t)data[at + 1] << 16 |
                                (uint32_t)data[at + 2] << 8 | data[at + 3];
        if (length > size - at - 12)
            return;
        png_put32(data + at + 8 + length, (uint32_t)crc32(0, data + at + 4, 4 + length));
        at += 12 + length;
    }
}

static void save_mutation(const char *path, const char *source, size_t source_size, bool mend)
{
    static const uint32_t words[] = {0, 1, 0x7fffffff, 0x80000000, 0xffffffff, 0x10000, 4096, 512};
    size_t size = source_size;
    unsigned char *data = malloc(size + 4);
    assert_non_null(data);
    memcpy(data, source, size);
    for (int i = 1 + (int)(next_random() % 4); i > 0; i--) {
        const size_t at = next_random() % source_size;
        switch (next_random() % 4) {
        case 0:
            data[at] ^= (unsigned char)(1u << next_random() % 8);
            break;
        case 1:
            data[at] = (unsigned char)next_random();
            break;
        case 2:
            memcpy(data + at, &words[next_random() % WEFT_COUNT(words)], 4);
            break;
        default:
            if (next_random() % 8 == 0)
                size = 1 + next_random() % size;
        }
    }
    if (mend)
        mend_png(data, size);
    test_write_file(path, data, size);
    free(data);
}

struct outcome {
    enum weft_result result;
    uint64_t hash;
    char message[1024];
};

static uint64_t hash_of(const struct weft_image_frame *frame)
{
    uint64_t h = 1469598103934665603u;
    for (size_t c = 0; c < frame->image.channel_count; c++) {
        const struct weft_plane *plane = &frame->plane[c];
        const size_t value = weft_plane_type_size(plane->type);
        for (size_t i = 0; i < (size_t)frame->image.width * (size_t)frame->image.height; i++) {
            const size_t width = (size_t)frame->image.width;
            const unsigned char *at = (const unsigned char *)plane->values +
                                      (i / width * plane->stride + i % width * plane->step) * value;
            for (size_t b = 0; b < value; b++)
                h = (h ^ at[b]) * 1099511628211u;
        }
    }
    return h;
}

static void read_all(const char *const *names, int count, int readers, struct outcome *out)
{
    struct names list = {.name = names};
    weft_image_sequence *sequence = NULL;
    assert_int_equal(weft_image_sequence_create(
                         weft_image_sequence_params(.count = count, .name = name_of, .priv = &list,
                                                    .readers = readers,
                                                    .limits = {.memory_bytes = UINT64_C(1) << 30,
                                                               .output_bytes = 256 << 20,
                                                               .cpu_seconds = 5,
                                                               .wall_seconds = 20},
                                                    .log = &test_log),
                         &sequence),
                     WEFT_OK);
    for (int i = 0; i < count; i++) {
        const struct weft_image_frame *frame;
        next_frame(sequence, i, &frame);
        if (frame->result != WEFT_OK)
            assert_non_null(strstr(frame->message, frame->name));
        out[i].result = frame->result;
        out[i].hash = frame->result == WEFT_OK ? hash_of(frame) : 0;
        memcpy(out[i].message, frame->message, sizeof out[i].message);
    }
    finish(&sequence);
}

// The same comes of them whatever the number of readers, and whichever meets them.
static void mutate(const char *source, const char *kind, bool mend)
{
    static const enum weft_result clean[] = {WEFT_OK, WEFT_ERR_UNSUPPORTED, WEFT_ERR_LIMIT,
                                             WEFT_ERR_FORMAT, WEFT_ERR_READER};
    const int count = setting("WEFT_MUTATIONS", 150);
    const int fds = test_count_entries("/proc/self/fd");
    size_t counts[WEFT_COUNT(clean)] = {0}, size;
    char *data = test_read_file(source, &size), **names = calloc((size_t)count, sizeof *names);
    struct outcome *one = calloc((size_t)count, sizeof *one);
    struct outcome *three = calloc((size_t)count, sizeof *three);
    assert_true(names && one && three);
    random_state = (uint64_t)setting("WEFT_MUTATION_SEED", 1) << 32;
    for (int i = 0; i < count; i++) {
        char name[40];
        snprintf(name, sizeof name, "mutant%d", i);
        names[i] = strdup(test_path(name));
        save_mutation(names[i], data, size, mend);
    }
    const double start = weft_now_seconds();
    read_all((const char *const *)names, count, 1, one);
    read_all((const char *const *)names, count, 3, three);
    for (int i = 0; i < count; i++) {
        size_t which = 0;
        while (which < WEFT_COUNT(clean) && clean[which] != one[i].result)
            which++;
        if (which == WEFT_COUNT(clean) || one[i].result != three[i].result ||
            one[i].hash != three[i].hash || strcmp(one[i].message, three[i].message))
            fail_msg("%s: %d or %d, '%s' or '%s'", names[i], one[i].result, three[i].result,
                     one[i].message, three[i].message);
        counts[which]++;
        remove(names[i]);
        free(names[i]);
    }
    print_message("%s: %d mutations: %zu read, %zu unsupported, %zu over a limit, %zu refused, "
                  "%zu readers lost; %.2f s\n",
                  kind, count, counts[0], counts[1], counts[2], counts[3], counts[4],
                  weft_now_seconds() - start);
    assert_true(count < 60 || counts[0] < (size_t)count);
    assert_int_equal(test_count_entries("/proc/self/fd"), fds);
    free(names);
    free(one);
    free(three);
    free(data);
}

static void test_mutations(void **state)
{
    (void)state;
    char source[512];
    snprintf(source, sizeof source, "%s", test_path("source"));
    save_png(source, 16, false);
    mutate(source, "PNG 16", false);
    mutate(source, "PNG 16, checksums mended", true);
    save_png(source, 8, true);
    mutate(source, "PNG 8 interlaced, checksums mended", true);
    png_make(&(struct png_recipe){.path = source,
                                  .width = SIDE,
                                  .height = SIDE,
                                  .bits = 4,
                                  .colour = PNG_COLOR_TYPE_PALETTE,
                                  .transparent = true});
    mutate(source, "PNG palette, checksums mended", true);
    save_exr(source, WEFT_IMAGE_ZIP);
    mutate(source, "EXR zip", false);
    save_exr(source, WEFT_IMAGE_PIZ);
    mutate(source, "EXR piz", false);
}

int main(void)
{
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 1);
    const struct CMUnitTest tests[] = {
        IN_FOLDER(test_bombs),          IN_FOLDER(test_bad_files),  IN_FOLDER(test_liars),
        IN_FOLDER(test_killed_readers), IN_FOLDER(test_no_program), IN_FOLDER(test_mutations),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
