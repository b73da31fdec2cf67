// SPDX-License-Identifier: BSD-3-Clause
// Files that broke other programs, and good ones of the same kinds. Each must end in success or in
// one error line, within the limits, whatever it does to the reader.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <float.h>

#include "tests/support/files.h"
#include "filter/check.h"
#include "tiles/image/image.h"

static const struct weft_limits limits = {
    .memory_bytes = UINT64_C(1) << 30,
    .output_bytes = UINT64_C(1) << 30,
    .cpu_seconds = 5,
    .wall_seconds = 20,
};

static void count(enum weft_result res, int counts[1000])
{
    assert_in_range(res, 0, 999);
    counts[res]++;
}

static void print_counts(const char *what, const int counts[1000])
{
    for (int i = 0; i < 1000; i++)
        if (counts[i])
            print_message("  %s: %3d %s\n", what, counts[i], weft_result_text(i));
}

static void load_damaged(const char *path, bool info_only, int counts[1000])
{
    struct weft_image image;
    struct weft_image_load_params params = {
        .path = path, .info_only = info_only, .limits = limits, .log = &test_log};
    test_forget();
    double start = weft_now_seconds();
    enum weft_result res = weft_image_load(&params, &image);
    if (test_errors != (res == WEFT_OK ? 0 : 1))
        fail_msg("%s: %d lines for result %d", path, test_errors, res);
    if (weft_now_seconds() - start > 2.0 * limits.wall_seconds + 2.0)
        fail_msg("%s: took %.1f s", path, weft_now_seconds() - start);
    if (getenv("WEFT_TEST_VERBOSE"))
        print_message("%3d %.2f s %s\n", res, weft_now_seconds() - start, test_message);
    count(res, counts);
    weft_image_clear(&image);
}

static void test_damaged_files(void **state)
{
    (void)state;
    int info[1000] = {0}, pixels[1000] = {0}, files = 0;
    DIR *dir = opendir(WEFT_TEST_DATA "/damaged");
    if (!dir) {
        print_message("[  SKIPPED ] no folder %s/damaged\n", WEFT_TEST_DATA);
        skip();
    }
    struct dirent *entry;
    while ((entry = readdir(dir))) {
        if (entry->d_name[0] == '.')
            continue;
        char path[1024];
        snprintf(path, sizeof path, "%s/damaged/%s", WEFT_TEST_DATA, entry->d_name);
        load_damaged(path, true, info);
        load_damaged(path, false, pixels);
        files++;
    }
    closedir(dir);
    print_message("%d damaged files\n", files);
    print_counts("info", info);
    print_counts("pixels", pixels);
    assert_true(files > 0);
    assert_true(pixels[WEFT_OK] < files); // some are so damaged that they are refused
}

// ---- good files
// -----------------------------------------------------------------------------------

struct census {
    size_t nan, infinite;
    float low, high; // of the finite
};

static struct census take_census(const struct weft_image *image)
{
    struct census census = {.low = FLT_MAX, .high = -FLT_MAX};
    size_t pixels = (size_t)image->width * (size_t)image->height;
    for (size_t c = 0; c < image->channel_count; c++) {
        for (size_t i = 0; i < pixels; i++) {
            float v = image->channels[c].plane[i];
            census.nan += isnan(v) != 0;
            census.infinite += isinf(v) != 0;
            if (isfinite(v)) {
                census.low = fminf(census.low, v);
                census.high = fmaxf(census.high, v);
            }
        }
    }
    return census;
}

static void test_good_files(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        bool nan, infinite;
        float at_least; // the largest finite value
    } cases[] = {
        {"BrightRings.exr", false, false, 1.0f},     {"BrightRingsNanInf.exr", true, true, 1.0f},
        {"GammaChart.exr", false, false, 0.5f},      {"SquaresSwirls.exr", false, false, 0.5f},
        {"WideFloatRange.exr", false, false, 1e38f}, {"stripes.exr", false, false, 0.5f},
    };
    size_t missing = 0;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        char path[1024];
        struct weft_image image;
        snprintf(path, sizeof path, "%s/%s", WEFT_TEST_DATA, cases[i].name);
        if (access(path, R_OK)) {
            print_message("[  SKIPPED ] no file %s\n", path);
            missing++;
            continue;
        }
        struct weft_image_load_params params = {.path = path, .log = &test_log};
        test_forget();
        enum weft_result res = weft_image_load(&params, &image);
        if (res != WEFT_OK)
            fail_msg("%s: %s", path, test_message);
        struct census census = take_census(&image);
        print_message("%s: %d x %d at (%d, %d), %zu channels (%s), %s%s, %.9g to %.9g, %zu NaN, "
                      "%zu infinite\n",
                      cases[i].name, image.width, image.height, image.x, image.y,
                      image.channel_count, weft_pixel_type_names[image.channels[0].type],
                      weft_image_compression_names[image.compression], image.tiled ? ", tiled" : "",
                      census.low, census.high, census.nan, census.infinite);
        assert_int_equal(census.nan > 0, cases[i].nan);
        assert_int_equal(census.infinite > 0, cases[i].infinite);
        assert_true(census.high >= cases[i].at_least);
        weft_image_clear(&image);
    }
    if (missing == WEFT_COUNT(cases))
        skip();
}

int main(void)
{
    setenv("WEFT_LIBEXEC", WEFT_BINARY_DIR, 1);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_damaged_files),
        cmocka_unit_test(test_good_files),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
