// SPDX-License-Identifier: BSD-3-Clause
// What packs EXR files: lines of every type, and files that are the same bytes whatever the number
// of threads. Files themselves are read by OpenEXR in test_image_save.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <sys/resource.h>

#include "tests/support/exr_peer.h"
#include "tests/support/files.h"
#include "filter/check.h"
#include "tiles/image/exr/chunk.h"

static uint32_t random_state;

static uint32_t next_random(void)
{
    random_state = random_state * 1664525u + 1013904223u;
    return random_state >> 8 ^ random_state << 11;
}

// ---- files --------------------------------------------------------------------------------------

enum { WIDTH = 301, HEIGHT = 203, PIXELS = WIDTH * HEIGHT, CHANNELS = 3 };

static float planes[CHANNELS][PIXELS];
static uint32_t integers[PIXELS];

static void fill_planes(void)
{
    random_state = 5;
    for (int c = 0; c < CHANNELS; c++) {
        for (int i = 0; i < PIXELS; i++) {
            const float x = 0.05f * (float)(i % WIDTH), y = 0.07f * (float)(i / WIDTH);
            const float noise = i % WIDTH > 200 ? 0x1p-33f * (float)next_random() : 0.0f;
            planes[c][i] = y > 11.0f ? (float)c : sinf(x + (float)c) * cosf(x * y) + noise;
            integers[i] = (uint32_t)(i / 7) + (i % 11 == 0 ? UINT32_C(0xf0000000) : 0);
        }
    }
}

static struct weft_image_channel channels[CHANNELS];

static struct weft_image make_image(enum weft_pixel_type type, enum weft_image_compression how)
{
    for (int c = 0; c < CHANNELS; c++)
        channels[c] = (struct weft_image_channel){
            .name = {(char)('A' + c)}, .type = type, .plane = planes[c], .integers = integers};
    return (struct weft_image){.x = -7,
                               .y = 11,
                               .width = WIDTH,
                               .height = HEIGHT,
                               .compression = how,
                               .channel_count = CHANNELS,
                               .channels = channels};
}

// Saved and loaded with 1, 2 and 5 threads: the same file, report and planes.
static void test_threads(void **state)
{
    (void)state;
    static const int threads[] = {1, 2, 5};
    int files = 0;
    fill_planes();
    for (int how = 0; weft_image_is_writable((enum weft_image_compression)how); how++) {
        for (int type = 0; type <= WEFT_PIXEL_UINT; type++, files++) {
            const struct weft_image image =
                make_image((enum weft_pixel_type)type, (enum weft_image_compression)how);
            struct weft_image_save_report report[3];
            struct weft_image loaded[3];
            char *file[3], why[400];
            size_t size[3];
            for (int k = 0; k < 3; k++) {
                const char *path = test_path("threads.exr");
                const struct weft_image_save_params save = {
                    .path = path, .threads = threads[k], .log = &test_log};
                const struct weft_image_load_params load = {
                    .path = path, .threads = threads[k], .log = &test_log};
                assert_int_equal(weft_image_save_parts(&image, 1, &save, &report[k]), WEFT_OK);
                assert_int_equal(weft_image_load(&load, &loaded[k]), WEFT_OK);
                file[k] = test_read_file(path, &size[k]);
                assert_int_equal(size[k], size[0]);
                assert_memory_equal(file[k], file[0], size[0]);
                assert_memory_equal(&report[k], &report[0], sizeof report[0]);
                for (size_t c = 0; c < CHANNELS; c++)
                    assert_memory_equal(loaded[k].channels[c].plane, loaded[0].channels[c].plane,
                                        sizeof planes[c]);
            }
            if (!exr_peer_agrees(test_path("threads.exr"), &image, why, sizeof why))
                fail_msg("%s, %s: %s", weft_image_compression_names[how],
                         weft_pixel_type_names[type], why);
            for (int k = 0; k < 3; k++) {
                weft_image_clear(&loaded[k]);
                free(file[k]);
            }
        }
    }
    assert_int_equal(files, 15);
}

static void test_bad_threads(void **state)
{
    (void)state;
    static const int bad[] = {-1, WEFT_IMAGE_MAX_THREADS + 1};
    const struct weft_image image = make_image(WEFT_PIXEL_FLOAT, WEFT_IMAGE_ZIP);
    struct weft_image loaded;
    const struct weft_image_save_params good = {.path = test_path("good.exr"), .log = &test_log};
    assert_int_equal(weft_image_save(&image, &good), WEFT_OK);
    for (size_t i = 0; i < WEFT_COUNT(bad); i++) {
        const struct weft_image_save_params save = {
            .path = test_path("bad.exr"), .threads = bad[i], .log = &test_log};
        const struct weft_image_load_params load = {
            .path = good.path, .threads = bad[i], .log = &test_log};
        test_forget();
        assert_int_equal(weft_image_save(&image, &save), WEFT_ERR_ARGUMENT);
        assert_int_equal(weft_image_load(&load, &loaded), WEFT_ERR_ARGUMENT);
        assert_int_equal(test_errors, 2);
        assert_non_null(strstr(test_message, "threads"));
    }
    assert_int_equal(access(test_path("bad.exr"), F_OK), -1);
}

// ---- progress -----------------------------------------------------------------------------------

struct watcher {
    pthread_t thread;
    double last, stop_at;
    int calls;
};

// In the caller's thread, never decreasing.
static bool watch(void *priv, double fraction)
{
    struct watcher *w = priv;
    assert_true(pthread_equal(w->thread, pthread_self()));
    assert_true(fraction >= w->last && fraction <= 1.0);
    w->last = fraction;
    w->calls++;
    return fraction < w->stop_at;
}

// Wherever it is stopped, nothing is left of the file, and what was there stays.
static void test_cancelled(void **state)
{
    (void)state;
    static const double stops[] = {0.0, 0.1, 0.5, 0.9, 1.0};
    const int entries = test_count_entries(test_folder);
    fill_planes();
    for (int how = 0; weft_image_is_writable((enum weft_image_compression)how); how++) {
        const struct weft_image image =
            make_image(WEFT_PIXEL_HALF, (enum weft_image_compression)how);
        for (int threads = 1; threads <= 5; threads += 2) {
            for (size_t i = 0; i < WEFT_COUNT(stops); i++) {
                struct watcher w = {pthread_self(), 0.0, stops[i], 0};
                const struct weft_progress progress = {watch, &w};
                const struct weft_image_save_params params = {.path = test_path("cancelled.exr"),
                                                              .threads = threads,
                                                              .progress = &progress,
                                                              .log = &test_log};
                test_forget();
                assert_int_equal(weft_image_save(&image, &params), WEFT_ERR_CANCELLED);
                assert_int_equal(test_errors, 0);
                assert_true(w.calls > 0);
                assert_int_equal(test_count_entries(test_folder), entries);
            }
            struct watcher w = {pthread_self(), 0.0, 2.0, 0};
            const struct weft_progress progress = {watch, &w};
            const struct weft_image_save_params params = {
                .path = "/dev/null", .threads = threads, .progress = &progress, .log = &test_log};
            assert_int_equal(weft_image_save(&image, &params), WEFT_OK);
            assert_true(w.last == 1.0);
        }
    }
}

// A disk that is full is told once, in the caller's thread, by whichever thread it was met.
static void test_full(void **state)
{
    (void)state;
    fill_planes();
    const struct weft_image image = make_image(WEFT_PIXEL_FLOAT, WEFT_IMAGE_NONE);
    struct rlimit old, small;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &old), 0);
    small = old;
    small.rlim_cur = 300000;
    void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
    for (int threads = 1; threads <= 5; threads += 2) {
        const struct weft_image_save_params params = {
            .path = test_path("full.exr"), .threads = threads, .log = &test_log};
        test_forget();
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
        const enum weft_result res = weft_image_save(&image, &params);
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &old), 0);
        assert_int_equal(res, WEFT_ERR_WRITE);
        assert_int_equal(test_errors, 1);
        assert_non_null(strstr(test_message, "File too large"));
        assert_int_equal(access(params.path, F_OK), -1);
    }
    signal(SIGXFSZ, handler);
}

// ---- damage -------------------------------------------------------------------------------------

// The first block that is damaged is told, whatever the number of threads.
static void test_damage(void **state)
{
    (void)state;
    fill_planes();
    int refused = 0, read = 0;
    for (int how = 0; weft_image_is_writable((enum weft_image_compression)how); how++) {
        const struct weft_image image =
            make_image(WEFT_PIXEL_HALF, (enum weft_image_compression)how);
        const char *path = test_path("whole.exr");
        const struct weft_image_save_params save = {.path = path, .log = &test_log};
        size_t size;
        assert_int_equal(weft_image_save(&image, &save), WEFT_OK);
        char *file = test_read_file(path, &size);
        for (int i = 0; i < 12; i++) {
            enum weft_result results[2];
            char messages[2][sizeof test_message];
            random_state = (uint32_t)(100 * how + i);
            const size_t at = 400 + next_random() % (size - 400);
            const size_t bytes = i % 3 ? size : at;
            const char old = file[at];
            file[at] = (char)next_random();
            test_write_file(test_path("damaged.exr"), file, bytes);
            file[at] = old;
            for (int k = 0; k < 2; k++) {
                struct weft_image loaded;
                const struct weft_image_load_params load = {
                    .path = test_path("damaged.exr"), .threads = k ? 5 : 1, .log = &test_log};
                test_forget();
                results[k] = weft_image_load(&load, &loaded);
                assert_int_equal(test_errors, results[k] == WEFT_OK ? 0 : 1);
                snprintf(messages[k], sizeof messages[k], "%s", test_errors ? test_message : "");
                weft_image_clear(&loaded);
            }
            assert_int_equal(results[0], results[1]);
            assert_string_equal(messages[0], messages[1]);
            refused += results[0] != WEFT_OK;
            read += results[0] == WEFT_OK;
        }
        free(file);
    }
    print_message("%d refused, %d read\n", refused, read);
    assert_true(refused > 20 && read > 5);
}

// Where many threads find no memory, one does; where it finds none either, that is told.
static void test_memory_limits(void **state)
{
    (void)state;
    fill_planes();
    const struct weft_image image = make_image(WEFT_PIXEL_FLOAT, WEFT_IMAGE_PIZ);
    const char *path = test_path("memory.exr");
    const struct weft_image_save_params save = {.path = path, .log = &test_log};
    assert_int_equal(weft_image_save(&image, &save), WEFT_OK);
    int loaded = 0, refused = 0;
    for (uint64_t mb = 1; mb <= 512; mb *= 2) {
        enum weft_result results[2];
        for (int k = 0; k < 2; k++) {
            struct weft_image out;
            const struct weft_image_load_params load = {.path = path,
                                                        .threads = k ? 64 : 1,
                                                        .limits = {.memory_bytes = mb << 20},
                                                        .log = &test_log};
            test_forget();
            results[k] = weft_image_load(&load, &out);
            assert_int_equal(test_errors, results[k] == WEFT_OK ? 0 : 1);
            weft_image_clear(&out);
        }
        assert_true(results[0] == results[1]);
        loaded += results[0] == WEFT_OK;
        refused += results[0] != WEFT_OK;
    }
    print_message("%d limits suffice, %d do not\n", loaded, refused);
    assert_true(loaded > 1);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) // which have no such limits
    assert_true(refused > 1);
#endif
}

#define IN_FOLDER(name) cmocka_unit_test_setup_teardown(name, test_enter_folder, test_leave_folder)

int main(void)
{
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 1);
    const struct CMUnitTest tests[] = {
        IN_FOLDER(test_threads), IN_FOLDER(test_bad_threads), IN_FOLDER(test_cancelled),
        IN_FOLDER(test_full),    IN_FOLDER(test_damage),      IN_FOLDER(test_memory_limits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
