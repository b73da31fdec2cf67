// SPDX-License-Identifier: BSD-3-Clause
// Each params struct's init function writes what its macro makes; the few whose defaults are not
// all zero, by their members. A program in C++17 goes from there to a slice.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "filter/check.h"
#include "weft.h"

// plain_cpp.cc: 0, or the line that failed.
int slice_in_cpp(float *pixels, int side);

// Structs whose default is not all zero.
static bool is_other(const char *tag)
{
    static const char *const others[] = {"weft_camera", "weft_division_params",
                                         "weft_nrrd_save_params", "weft_pixels_verify_params",
                                         "weft_volume_params"};
    for (size_t i = 0; i < WEFT_COUNT(others); i++)
        if (strcmp(others[i], tag) == 0)
            return true;
    return false;
}

static bool is_zero(const void *bytes, size_t size)
{
    const unsigned char *at = bytes;
    for (size_t i = 0; i < size; i++)
        if (at[i])
            return false;
    return true;
}

// With static storage, where padding is zero.
#define EXPECT(tag) static const struct tag *const expected_##tag = tag();
WEFT_PARAMS_LIST(EXPECT)

static void inits_write_what_macros_make(void **state)
{
    int count = 0;
    (void)state;
#define CHECK(tag)                                                                                 \
    {                                                                                              \
        struct tag params;                                                                         \
        memset(&params, 0x5a, sizeof params);                                                      \
        tag##_init(&params);                                                                       \
        assert_memory_equal(&params, expected_##tag, sizeof params);                               \
        if (is_zero(&params, sizeof params) == is_other(#tag))                                     \
            fail_msg("%s: zero is the default or not", #tag);                                      \
        count++;                                                                                   \
    }
    WEFT_PARAMS_LIST(CHECK)
    assert_true(count >= 70);

    struct weft_volume_params volume;
    weft_volume_params_init(&volume);
    assert_true(isnan(volume.background) && volume.size[0] == 0 && !volume.data);
    struct weft_division_params division;
    weft_division_params_init(&division);
    assert_true(division.keep == 0.5);
    struct weft_nrrd_save_params nrrd;
    weft_nrrd_save_params_init(&nrrd);
    assert_int_equal(nrrd.type, WEFT_SAMPLE_FLOAT);
    struct weft_pixels_verify_params pixels;
    weft_pixels_verify_params_init(&pixels);
    assert_true(isnan(pixels.bound_relative) && isnan(pixels.bound_absolute));
    struct weft_camera camera;
    weft_camera_init(&camera);
    assert_true(camera.fovy_degrees == 45.0 && camera.up[1] == 1.0);
}

// All of them stand in the list: what public headers declare as struct weft_..._params.
static void every_params_struct_is_listed(void **state)
{
    static const char list[] =
#define NAME(tag) #tag " "
        WEFT_PARAMS_LIST(NAME);
    FILE *headers =
        popen("cd " WEFT_SOURCE_DIR " && sed -n 's/^#include \"\\(.*\\)\"$/\\1/p' weft.h |"
              " xargs sed -n 's/^struct \\(weft_[a-z0-9_]*_params\\) {$/\\1 /p'",
              "r");
    char tag[128];
    int count = 0;
    (void)state;
    assert_non_null(headers);
    for (; fgets(tag, sizeof tag, headers); count++) {
        tag[strcspn(tag, "\n")] = '\0';
        if (!strstr(list, tag))
            fail_msg("%s is not in WEFT_PARAMS_LIST (passes/params/params.h)", tag);
    }
    assert_int_equal(pclose(headers), 0);
    assert_true(count > 60);
}

static void cpp_goes_to_a_slice(void **state)
{
    float pixels[8 * 8];
    (void)state;
    assert_int_equal(slice_in_cpp(pixels, 8), 0);
    // Pixels on the voxels of a ramp of x + 10 y + 100 z, at z = 3.
    for (int y = 0; y < 8; y++)
        for (int x = 0; x < 8; x++)
            assert_true(pixels[y * 8 + x] == (float)(x + 10 * y + 300));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(inits_write_what_macros_make),
        cmocka_unit_test(every_params_struct_is_listed),
        cmocka_unit_test(cpp_goes_to_a_slice),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
