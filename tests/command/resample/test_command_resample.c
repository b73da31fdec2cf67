// SPDX-License-Identifier: BSD-3-Clause
// weft resample and weft slice --profile as their users see them, and what they refuse.
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>
#include <jansson.h>
#include <png.h>

#include "tests/support/command.h"
#include "tests/support/json.h"
#include "weft.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))

#define skip_without_gl()                                                                          \
    do {                                                                                           \
        if (!command_has_gl())                                                                     \
            skip();                                                                                \
    } while (0)

static const char *text(const json_t *object, const char *key)
{
    const char *value = json_string_value(json_object_get(object, key));
    if (!value)
        fail_msg("no text %s", key);
    return value;
}

static const json_t *part(const json_t *object, const char *key)
{
    const json_t *value = json_object_get(object, key);
    if (!value)
        fail_msg("no %s", key);
    return value;
}

// ---- images -------------------------------------------------------------------------------------

enum { WIDTH = 37, HEIGHT = 23, MAX_CHANNELS = 6 };

// A smooth pattern, another for each channel, from 0 to 1.
static float pattern(int c, int x, int y)
{
    return (float)(0.5 + 0.5 * sin(0.4 * (c + 1) * x + 0.9 * c) * cos(0.3 * y + 0.2 * c * x));
}

// Names up to NULL; value = low + (high - low) pattern. y: of the data window, in a display window
// that is larger by a pixel on each side.
static void make_image(const char *path, const char *const *names, double low, double high)
{
    struct weft_image_channel channels[MAX_CHANNELS] = {0};
    static float planes[MAX_CHANNELS][WIDTH * HEIGHT];
    struct weft_image_attribute attributes[] = {{"owner", "string", "a test", 6},
                                                {"weft.kernel", "string", "an earlier one", 14}};
    struct weft_image image = {.x = 10,
                               .y = -4,
                               .width = WIDTH,
                               .height = HEIGHT,
                               .display_min = {9, -5},
                               .display_max = {10 + WIDTH, -4 + HEIGHT},
                               .channels = channels,
                               .attribute_count = COUNT(attributes),
                               .attributes = attributes};
    for (int c = 0; names[c]; c++) {
        assert_true(c < MAX_CHANNELS);
        for (int i = 0; i < WIDTH * HEIGHT; i++)
            planes[c][i] = (float)(low + (high - low) * pattern(c, i % WIDTH, i / WIDTH));
        snprintf(channels[c].name, sizeof channels[c].name, "%s", names[c]);
        channels[c].plane = planes[c];
        image.channel_count++;
    }
    const struct weft_image_save_params params = {.path = path};
    assert_int_equal(weft_image_save(&image, &params), WEFT_OK);
}

static const char *const one_channel[] = {"Y", NULL};
static const char *const four_channels[] = {"R", "G", "B", "A", NULL};

static int setup(void **state)
{
    static const char *const layers[] = {"R", "G", "B", "A", "left.Z", "depth", NULL};
    if (command_setup(state) != 0)
        return -1;
    make_image("grey.exr", one_channel, 0.0, 1.0);
    make_image("rgba.exr", four_channels, -2.0, 6.0);
    make_image("layers.exr", layers, 0.0, 100.0);
    return 0;
}

static void load(const char *path, struct weft_image *image)
{
    const struct weft_image_load_params params = {.path = path};
    assert_int_equal(weft_image_load(&params, image), WEFT_OK);
}

// ---- help ---------------------------------------------------------------------------------------

static void help_names_everything(void **state)
{
    (void)state;
    char *help = strdup(command_succeeds("help", "resample", "all"));
    assert_non_null(help);
    assert_string_equal(help, command_succeeds("resample", "--help=all"));
    static const char *const words[] = {
        "--together", "--emulate",      "--profile",           "fp32",
        "--verify",   "--source-range", "usage: weft resample"};
    for (size_t i = 0; i < COUNT(words); i++)
        if (!strstr(help, words[i]))
            fail_msg("help does not tell of %s", words[i]);
    free(help);
    assert_non_null(strstr(command_succeeds("slice", "--help=all"), "--profile"));
    static const char *const verbs[] = {"resample", "slice"};
    for (size_t v = 0; v < COUNT(verbs); v++) {
        const char *profiles = command_succeeds(verbs[v], "--profile", "help");
        for (int i = 0; weft_profile_list[i]; i++)
            assert_non_null(strstr(profiles, weft_profile_list[i]->name));
        assert_non_null(strstr(command_succeeds(verbs[v], "--kernel", "help"), "catmull-rom"));
    }
}

// ---- resample -----------------------------------------------------------------------------------

static void plans_are_explained_without_gl(void **state)
{
    (void)state;
    const char *out = command_succeeds("resample", "grey.exr", "--explain", "--kernel", "bspline",
                                       "--profile", "unorm8", "--context", "auto");
    assert_non_null(strstr(out, "resample grey.exr: 37 x 23 -> 74 x 46, channels Y\n"));
    assert_non_null(strstr(out, "pass "));
    assert_non_null(strstr(out, "bspline"));
    json_t *root = parse(command_succeeds("resample", "layers.exr", "--explain", "--json",
                                          "--together", "--size", "100x90"));
    assert_int_equal(json_array_size(json_object_get(root, "plans")), 2);
    assert_int_equal(json_array_size(json_object_get(root, "groups")), 3);
    const json_t *plan = json_array_get(json_object_get(root, "plans"), 0);
    assert_string_equal(text(plan, "profile"), "fp32");
    assert_string_equal(text(plan, "technique"), "plain");
    assert_true(number(plan, "resolution") == 64);
    const json_t *display[2] = {part(part(root, "to"), "display_min"),
                                part(part(root, "to"), "display_max")};
    assert_int_equal(json_integer_value(json_array_get(display[1], 0)) -
                         json_integer_value(json_array_get(display[0], 0)),
                     99);
    json_decref(root);
}

static void every_channel_is_written(void **state)
{
    (void)state;
    skip_without_gl();
    struct weft_image in, out;
    command_succeeds("resample", "layers.exr", "-o", "out.exr", "--size", "78x75");
    load("layers.exr", &in);
    load("out.exr", &out);
    assert_int_equal(out.width, 74);
    assert_int_equal(out.height, 69);
    // Twice in x, three times in y, of the display window.
    assert_int_equal(out.x, 20);
    assert_int_equal(out.y, -12);
    assert_int_equal(out.display_min[0], 18);
    assert_int_equal(out.display_min[1], -15);
    assert_int_equal(out.display_max[0], 20 + 74 + 1);
    assert_int_equal(out.display_max[1], -12 + 69 + 2);
    assert_int_equal(out.channel_count, in.channel_count);
    for (size_t c = 0; c < out.channel_count; c++) {
        assert_string_equal(out.channels[c].name, in.channels[c].name);
        assert_int_equal(out.channels[c].type, WEFT_PIXEL_FLOAT);
    }
    weft_image_clear(&in);
    weft_image_clear(&out);
    json_t *info = parse(command_succeeds("info", "out.exr", "--json"));
    const json_t *metadata = part(info, "metadata");
    assert_string_equal(text(metadata, "owner"), "a test");
    assert_string_equal(text(metadata, "weft.kernel"), "catmull-rom");
    assert_string_equal(text(metadata, "weft.image"), "layers.exr");
    assert_string_equal(text(metadata, "weft.method"), "separable");
    assert_null(json_object_get(metadata, "weft.profile"));
    assert_string_equal(text(metadata, "weft.size"), "74x69 from 37x23");
    assert_non_null(strstr(text(metadata, "weft.bound"), "left.Z "));
    assert_non_null(strstr(text(metadata, "weft.source_range"), "depth "));
    json_decref(info);
    command_succeeds("resample", "layers.exr", "-o", "out.exr", "--profile", "fp32");
    info = parse(command_succeeds("info", "out.exr", "--json"));
    metadata = part(info, "metadata");
    assert_string_equal(text(metadata, "weft.method"), "passes");
    assert_string_equal(text(metadata, "weft.profile"), "fp32");
    assert_string_equal(text(metadata, "weft.technique"), "plain");
    json_decref(info);
    unlink("out.exr");
}

// Interpolating kernels at thrice the size: every third pixel is an input's, up to the bound.
static void check_places(const char *json, double largest_bound)
{
    struct weft_image in, out;
    json_t *root = parse(json);
    const double bound = number(json_array_get(part(root, "groups"), 0), "bound");
    assert_true(bound > 0.0 && bound < largest_bound);
    json_decref(root);
    load("grey.exr", &in);
    load("out.exr", &out);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            assert_true(fabs(out.channels[0].plane[(3 * y + 1) * 111 + 3 * x + 1] -
                             in.channels[0].plane[y * WIDTH + x]) <= bound);
    weft_image_clear(&in);
    weft_image_clear(&out);
    unlink("out.exr");
}

static void pixels_lie_where_they_should(void **state)
{
    (void)state;
    skip_without_gl();
    check_places(command_succeeds("resample", "grey.exr", "-o", "out.exr", "--size", "117x75",
                                  "--json", "--resolution", "256"),
                 0.02);
    check_places(
        command_succeeds("resample", "grey.exr", "-o", "out.exr", "--size", "117x75", "--json"),
        1e-6);
}

static void assert_within(double expected, double value, double bound)
{
    if (!(fabs(value - expected) <= bound))
        fail_msg("%.9g, not %.9g +- %.3g", value, expected, bound);
}

// An axis: first pixel and size of the data and of the display window, and the size asked for.
static const struct windows {
    int data, size, display, display_size, to;
} window_cases[] = {
    {-5, 40, 0, 30, 45},  {-4, 40, 0, 30, 45},    {3, 20, 0, 30, 45},   {0, 30, 0, 30, 1000},
    {-7, 9, -3, 31, 200}, {101, 37, 90, 100, 33}, {-9, 40, -9, 20, 20}, {5, 3, 0, 7, 1},
};

// values = 3 X - 2 Y at the centre of pixel (X, Y), wherever the windows are.
static void make_ramp(const char *path, const struct windows axis[2])
{
    static float plane[64 * 64];
    struct weft_image_channel channel = {.name = "Y", .plane = plane};
    const struct weft_image image = {.x = axis[0].data,
                                     .y = axis[1].data,
                                     .width = axis[0].size,
                                     .height = axis[1].size,
                                     .display_min = {axis[0].display, axis[1].display},
                                     .display_max = {axis[0].display + axis[0].display_size - 1,
                                                     axis[1].display + axis[1].display_size - 1},
                                     .channel_count = 1,
                                     .channels = &channel};
    for (int y = 0; y < image.height; y++)
        for (int x = 0; x < image.width; x++)
            plane[y * image.width + x] =
                (float)(3.0 * (image.x + x + 0.5) - 2.0 * (image.y + y + 0.5));
    assert_int_equal(weft_image_save(&image, &(struct weft_image_save_params){.path = path}),
                     WEFT_OK);
}

// Where the centre of the result's pixel lies in the input, within the samples' centres: beyond
// them the edge's value holds.
static double place_in(const struct windows *w, int out_display, int pixel)
{
    const double at = w->display + (pixel + 0.5 - out_display) * w->display_size / w->to;
    return fmin(fmax(at, w->data + 0.5), w->data + w->size - 0.5);
}

static void check_windows(const struct windows *w, int first, int size, int display, int last)
{
    const double scale = (double)w->to / w->display_size;
    const double low = display + (w->data - w->display) * scale, high = low + w->size * scale;
    assert_int_equal(last - display + 1, w->to);
    assert_true(fabs(display - w->display * scale) <= 0.5);
    assert_true(first <= low + 1e-9 && first + 1 > low + 1e-9);
    assert_true(first + size >= high - 1e-9 && first + size - 1 < high - 1e-9);
}

// A linear kernel that is not stretched gives a ramp as it is, so that every pixel tells where it
// was taken from.
static void the_picture_keeps_its_place(void **state)
{
    (void)state;
    static const char *const methods[] = {"separable", "--emulate"};
    size_t ran = 0;
    for (size_t i = 0; i < COUNT(window_cases) * COUNT(methods); i++) {
        const struct windows axis[2] = {window_cases[i % COUNT(window_cases)],
                                        window_cases[(i + 3) % COUNT(window_cases)]};
        const bool emulated = i >= COUNT(window_cases);
        char size[32];
        struct weft_image out;
        if (!emulated && !command_has_gl())
            continue;
        snprintf(size, sizeof size, "%dx%d", axis[0].to, axis[1].to);
        make_ramp("ramp.exr", axis);
        json_t *root = parse(command_succeeds("resample", "ramp.exr", "-o", "out.exr", "--kernel",
                                              "linear", "-q", "--json", "--antialias", "off",
                                              "--size", size, emulated ? "--emulate" : NULL));
        const double bound = number(json_array_get(part(root, "groups"), 0), "bound");
        json_decref(root);
        load("out.exr", &out);
        check_windows(&axis[0], out.x, out.width, out.display_min[0], out.display_max[0]);
        check_windows(&axis[1], out.y, out.height, out.display_min[1], out.display_max[1]);
        for (int y = 0; y < out.height; y++)
            for (int x = 0; x < out.width; x++)
                assert_within(3.0 * place_in(&axis[0], out.display_min[0], out.x + x) -
                                  2.0 * place_in(&axis[1], out.display_min[1], out.y + y),
                              out.channels[0].plane[y * out.width + x], bound);
        weft_image_clear(&out);
        ran++;
    }
    assert_int_equal(ran, COUNT(window_cases) * (command_has_gl() ? COUNT(methods) : 1));
    unlink("ramp.exr");
    unlink("out.exr");
}

// At the input's own size; resolution: of tiles so fine that looking them up costs little.
static double resampling_error(const char *kernel, const char *resolution)
{
    struct weft_image in, out;
    double worst = 0.0;
    command_succeeds("resample", "grey.exr", "-o", "same.exr", "--size", "39x25", "--kernel",
                     kernel, resolution ? "--resolution" : NULL, resolution);
    load("grey.exr", &in);
    load("same.exr", &out);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        assert_true(isfinite(out.channels[0].plane[i]));
        worst =
            fmax(worst, fabs((double)out.channels[0].plane[i] - (double)in.channels[0].plane[i]));
    }
    weft_image_clear(&in);
    weft_image_clear(&out);
    return worst;
}

static void prefiltered_kernels_return_the_image(void **state)
{
    (void)state;
    skip_without_gl();
    assert_true(resampling_error("bspline3", "1024") > 1e-2);
    assert_true(resampling_error("bspline3i", "1024") < 1e-3);
    assert_true(resampling_error("bspline5i", "1024") < 1e-3);
    assert_true(resampling_error("bspline3", NULL) > 1e-2);
    assert_true(resampling_error("bspline3i", NULL) < 1e-6);
    assert_true(resampling_error("bspline7i", NULL) < 3e-6);
    json_t *separable = parse(
        command_succeeds("resample", "rgba.exr", "--kernel", "bspline3i", "--json", "--verify"));
    assert_true(number(separable, "prefilter_overlap") == 15);
    assert_string_equal(text(separable, "method"), "separable");
    json_decref(separable);
    json_t *root = parse(command_succeeds("resample", "rgba.exr", "--kernel", "bspline3i", "--json",
                                          "--verify", "--together"));
    assert_true(number(root, "prefilter_overlap") == 15);
    assert_string_equal(text(root, "kernel"), "bspline3i");
    json_decref(root);
}

static void prefiltered_slices_are_verified(void **state)
{
    (void)state;
    skip_without_gl();
    json_t *root = parse(command_succeeds("slice", "ml.vdb", "--kernel", "bspline3i", "--verify",
                                          "--json", "--size", "64x64"));
    assert_string_equal(text(root, "kernel"), "bspline3i");
    assert_true(number(root, "prefilter_overlap") == 15);
    assert_true(number(part(root, "error"), "relative_max") < 2e-6);
    json_decref(root);
    command_fails(2, "has no prefilter", "slice", "ml.vdb", "--kernel", "mitchelli", "--json");
}

static void channels_can_be_chosen(void **state)
{
    (void)state;
    skip_without_gl();
    struct weft_image out;
    command_succeeds("resample", "layers.exr", "-o", "out.exr", "--channels", "left.Z,G");
    load("out.exr", &out);
    assert_int_equal(out.channel_count, 2);
    assert_string_equal(out.channels[0].name, "G");
    assert_string_equal(out.channels[1].name, "left.Z");
    weft_image_clear(&out);
    unlink("out.exr");
}

// The JSON of a run with --verify: each group's error is within its bound.
static void assert_within_bounds(const char *json, const char *what)
{
    json_t *root = parse(json);
    const json_t *groups = part(root, "groups");
    assert_true(json_array_size(groups) > 0);
    for (size_t g = 0; g < json_array_size(groups); g++) {
        const json_t *group = json_array_get(groups, g), *error = part(group, "error");
        const double bound = number(group, "bound");
        if (!(number(error, "max") <= bound) || number(error, "not_finite_mismatches") > 0)
            fail_msg("%s, group %zu: error %.9g, bound %.9g, %g not finite", what, g,
                     number(error, "max"), bound, number(error, "not_finite_mismatches"));
        assert_true(number(error, "rms") <= number(error, "max"));
    }
    json_decref(root);
}

static void axes_are_filtered_one_after_the_other(void **state)
{
    (void)state;
    skip_without_gl();
    static const char *const kernels[] = {"catmull-rom", "linear",   "nearest",
                                          "lanczos:3",   "bspline7", "bspline3i"};
    for (size_t k = 0; k < COUNT(kernels); k++)
        assert_within_bounds(command_succeeds("resample", "rgba.exr", "--verify", "--json",
                                              "--size", "61x90", "--kernel", kernels[k]),
                             kernels[k]);
    json_t *root = parse(command_succeeds("resample", "rgba.exr", "--json", "--verify"));
    assert_string_equal(text(root, "method"), "separable");
    assert_int_equal(json_array_size(part(root, "plans")), 0);
    assert_int_equal(json_array_size(part(root, "groups")), 4);
    assert_true(number(part(root, "separable"), "passes") == 8);
    assert_true(number(part(root, "separable"), "fetches_per_pixel") < 16);
    assert_true(number(json_array_get(part(root, "groups"), 0), "e1") > 0.0);
    json_decref(root);
    const char *out = command_succeeds("resample", "rgba.exr", "--explain");
    assert_non_null(strstr(out, "separable catmull-rom: 4 taps along each axis"));
    assert_null(strstr(out, "pass "));
    // Radial kernels cannot be, and go on in passes.
    root = parse(command_succeeds("resample", "grey.exr", "--json", "--kernel",
                                  "catmull-rom+radial+unit", "--verify"));
    assert_string_equal(text(root, "method"), "passes");
    json_decref(root);
}

// ---- values that floats hardly hold -------------------------------------------------------------

// One channel of 16 x 12 pixels, its own window.
static void make_values(const char *path, float *values)
{
    struct weft_image_channel channel = {.name = "Y", .plane = values};
    const struct weft_image image = {
        .width = 16, .height = 12, .channel_count = 1, .channels = &channel};
    assert_int_equal(weft_image_save(&image, &(struct weft_image_save_params){.path = path}),
                     WEFT_OK);
}

static const char *const value_methods[][2] = {{NULL, NULL},
                                               {"--emulate", NULL},
                                               {"--profile=fp32", "--technique=dot4"},
                                               {"--profile=unorm16", NULL}};

// At the same size every pixel is its own sample: what is missing stays that one pixel.
static void the_same_size_is_the_same(void **state)
{
    (void)state;
    skip_without_gl();
    static const char *const kernels[] = {"nearest", "linear", "catmull-rom", "lanczos:3"};
    float values[16 * 12];
    for (int i = 0; i < 16 * 12; i++)
        values[i] = i == 5 * 16 + 7 ? NAN : i % 3 ? 1e30f : i % 2 ? -0.0f : 1e-40f;
    make_values("same.exr", values);
    for (size_t i = 0; i < COUNT(kernels) * COUNT(value_methods); i++) {
        const char *const *method = value_methods[i / COUNT(kernels)];
        struct weft_image out;
        json_t *root = parse(command_succeeds(
            "resample", "same.exr", "-o", "out.exr", "--verify", "--json", "--size", "16x12",
            "--kernel", kernels[i % COUNT(kernels)], method[0] ? method[0] : "-q", method[1]));
        const json_t *group = json_array_get(part(root, "groups"), 0);
        assert_true(number(group, "not_finite") == 1);
        assert_true(number(part(group, "error"), "not_finite_mismatches") == 0);
        load("out.exr", &out);
        assert_true(isnan(out.channels[0].plane[5 * 16 + 7]));
        if (!method[0])
            assert_memory_equal(out.channels[0].plane, values, sizeof values);
        weft_image_clear(&out);
        json_decref(root);
    }
    unlink("same.exr");
    unlink("out.exr");
}

// The largest float, beside usual values, as many programs mark what is no data.
static void no_data_may_be_the_largest_float(void **state)
{
    (void)state;
    skip_without_gl();
    static const char *const kernels[] = {"linear", "bspline5", "catmull-rom", "lanczos:3"};
    float values[16 * 12];
    for (int i = 0; i < 16 * 12; i++)
        values[i] = (i % 16 > 9) != (i / 16 > 5) ? -FLT_MAX : (float)i;
    make_values("nodata.exr", values);
    for (size_t i = 0; i < COUNT(kernels) * COUNT(value_methods); i++) {
        const char *const *method = value_methods[i / COUNT(kernels)];
        const char *json = command_succeeds(
            "resample", "nodata.exr", "--verify", "--json", "--size", "41x31", "--kernel",
            kernels[i % COUNT(kernels)], method[0] ? method[0] : "-q", method[1]);
        assert_within_bounds(json, kernels[i % COUNT(kernels)]);
        json_t *root = parse(json);
        // Weights that are positive leave nothing outside the range of floats.
        if (i % COUNT(kernels) < 2)
            assert_true(number(json_array_get(part(root, "groups"), 0), "not_finite") == 0);
        json_decref(root);
    }
    command_fails(3, "leave the range of floats", "resample", "nodata.exr", "--json", "--kernel",
                  "bspline3i");
    unlink("nodata.exr");
}

// ---- normalised kernels -------------------------------------------------------------------------

// "lanczos:3" of a channel that is 1 everywhere, at an odd size.
static json_t *resample_white(const char *kernel, const char *normalise, const char *method)
{
    char option[32];
    snprintf(option, sizeof option, "--normalise=%s", normalise ? normalise : "");
    return parse(command_succeeds("resample", "white.exr", "--json", "--verify", "--size", "53x47",
                                  "--kernel", kernel, normalise ? option : "-q", method));
}

// Its smallest and largest pixel, and how far from 1 the bound lets them be.
static bool is_white(const json_t *root)
{
    const json_t *group = json_array_get(part(root, "groups"), 0);
    const double bound = number(group, "bound");
    assert_true(number(part(group, "error"), "max") <= bound);
    return fabs(number(group, "minimum") - 1.0) <= bound &&
           fabs(number(group, "maximum") - 1.0) <= bound;
}

static void white_stays_white(void **state)
{
    (void)state;
    skip_without_gl();
    make_image("white.exr", one_channel, 1.0, 1.0);
    int normalised = 0;
    for (const struct weft_kernel_info *const *k = weft_kernel_list; *k; k++) {
        if ((*k)->derivation > 0 || (*k)->unit_sum)
            continue;
        json_t *root = resample_white((*k)->name, NULL, NULL);
        const char *name = text(root, "kernel");
        assert_string_equal(name + strlen(name) - 5, "+unit");
        if (!is_white(root))
            fail_msg("%s", name);
        json_decref(root);
        normalised++;
    }
    assert_in_range(normalised, 5, 50);
    static const char *const odd[] = {"lanczos:2.3", "gaussian:1.3,0.2", "lanczos:3+radial",
                                      "catmull-rom"};
    for (size_t i = 0; i < COUNT(odd); i++) {
        json_t *root = resample_white(odd[i], NULL, "--emulate");
        if (!is_white(root))
            fail_msg("%s in passes", odd[i]);
        json_decref(root);
    }
}

static void normalising_is_a_choice(void **state)
{
    (void)state;
    skip_without_gl();
    static const struct {
        const char *kernel, *normalise, *name;
        bool white;
    } cases[] = {
        {"lanczos:3", "off", "lanczos:3", false},
        {"lanczos:3", "on", "lanczos:3+unit", true},
        {"lanczos:3+unit", "off", "lanczos:3+unit", true},
        {"blackman-sinc", "off", "blackman-sinc:2", false},
        {"mitchell", "on", "mitchell", true},
        {"table:own.txt", NULL, "table:own.txt", false},
        {"table:own.txt", "on", "table:own.txt+unit", true},
    };
    make_image("white.exr", one_channel, 1.0, 1.0);
    command_write_file("own.txt", "support 1 0.9 0.3 0\n", 20);
    for (size_t i = 0; i < COUNT(cases); i++) {
        json_t *root = resample_white(cases[i].kernel, cases[i].normalise, NULL);
        assert_string_equal(text(root, "kernel"), cases[i].name);
        assert_int_equal(is_white(root), cases[i].white);
        json_decref(root);
    }
    command_write_file("dip.txt", "support 1 whole -1 0.5 1 0.5 -1\n", 31);
    command_fails(2, "cannot be divided", "resample", "white.exr", "--json", "--kernel",
                  "table:dip.txt", "--normalise", "on");
    unlink("dip.txt");
    unlink("own.txt");
    unlink("white.exr");
}

static void slices_normalise_too(void **state)
{
    (void)state;
    skip_without_gl();
    static const char *const cases[][3] = {{"lanczos:3", NULL, "lanczos:3+unit"},
                                           {"lanczos:3", "--normalise=off", "lanczos:3"},
                                           {"lanczos:3+unit", NULL, "lanczos:3+unit"}};
    struct weft_image out[3];
    for (int i = 0; i < 3; i++) {
        json_t *root =
            parse(command_succeeds("slice", "ml.vdb", "-o", "s.exr", "--json", "--size", "40x40",
                                   "--verify", "--kernel", cases[i][0], cases[i][1]));
        assert_string_equal(text(root, "kernel"), cases[i][2]);
        assert_true(number(part(root, "error"), "relative_max") <= number(root, "relative_bound"));
        json_decref(root);
        load("s.exr", &out[i]);
    }
    const size_t bytes = 40 * 40 * sizeof(float);
    assert_memory_equal(out[0].channels[0].plane, out[2].channels[0].plane, bytes);
    assert_memory_not_equal(out[0].channels[0].plane, out[1].channels[0].plane, bytes);
    for (int i = 0; i < 3; i++)
        weft_image_clear(&out[i]);
    unlink("s.exr");
}

// ---- budgets ------------------------------------------------------------------------------------

static void budgets_are_checked_before_anything_runs(void **state)
{
    (void)state;
    const char *out = command_succeeds("resample", "rgba.exr", "--explain", "--max-error", "16bit");
    assert_non_null(strstr(out, "R: samples from "));
    assert_non_null(strstr(out, "E1 "));
    command_fails(1, "the best one's bound is ", "resample", "rgba.exr", "-o", "a.exr",
                  "--max-error", "1e-9");
    // What was compared is explained nevertheless.
    struct command_result r;
    command_run(&r, "weft", "resample", "rgba.exr", "--explain", "--max-error", "1e-9");
    assert_int_equal(r.code, 1);
    assert_non_null(strstr(r.err, "within --max-error 1e-9"));
    assert_non_null(strstr(r.out, "separable cpu double"));
    static const char *const wrong[] = {"0", "-1", "8 bit", "99bit", "bit", "nan", "inf", "1e-3x"};
    for (size_t i = 0; i < COUNT(wrong); i++)
        command_fails(2, "--max-error", "resample", "rgba.exr", "-o", "a.exr", "--max-error",
                      wrong[i]);
    if (!command_has_gl())
        return;
    json_t *root = parse(
        command_succeeds("resample", "rgba.exr", "--max-error", "0.001", "--json", "--verify"));
    const json_t *group = json_array_get(part(root, "groups"), 0);
    assert_true(number(group, "max_error") == 0.001);
    assert_true(number(group, "bound") <= 0.001);
    json_decref(root);
}

// Half a code value of a channel of one value is of its distance from 0.
static void constant_channels_have_budgets(void **state)
{
    (void)state;
    make_image("flat.exr", one_channel, 5.0, 5.0);
    assert_non_null(strstr(
        command_succeeds("resample", "flat.exr", "--explain", "--max-error", "8bit"), "0.0098"));
    make_image("flat.exr", one_channel, 0.0, 0.0);
    command_succeeds("resample", "flat.exr", "--explain", "--max-error", "16bit");
    unlink("flat.exr");
}

// Half a code is one of the channel's range, not of its coefficients'.
static void bits_are_the_samples_own(void **state)
{
    (void)state;
    skip_without_gl();
    static const struct {
        const char *kernel, *budget, *profile;
    } cases[] = {{"bspline3i", "6bit", "unorm16"},
                 {"bspline7i", "4bit", "unorm16"},
                 {"bspline5i", "6bit", "unorm16"},
                 {"bspline5i", "12bit", NULL},
                 {"omomsi", "6bit", "fp32"}};
    for (size_t i = 0; i < COUNT(cases); i++) {
        const char *profile = cases[i].profile;
        json_t *root = parse(command_succeeds("resample", "grey.exr", "--kernel", cases[i].kernel,
                                              "--json", "--verify", "--max-error", cases[i].budget,
                                              profile ? "--profile" : NULL, profile));
        const json_t *group = json_array_get(part(root, "groups"), 0);
        const double range = number(group, "sample_high") - number(group, "sample_low");
        assert_true(range < 1.01 && number(group, "high") - number(group, "low") > range);
        assert_within(0.5 * range / (exp2(atoi(cases[i].budget)) - 1.0), number(group, "max_error"),
                      1e-12);
        const double bound = number(group, "bound");
        assert_true(number(part(group, "error"), "max") <= bound);
        assert_true(bound <= number(group, "max_error"));
        json_decref(root);
    }
}

static void the_cheapest_passes_within_a_budget_are_chosen(void **state)
{
    (void)state;
    skip_without_gl();
    static const char *const profiles_and_errors[][2] = {
        {"unorm8", "0.2"}, {"unorm16", "0.1"}, {"fp32", "0.05"}, {"fp16", "0.1"}};
    for (size_t i = 0; i < COUNT(profiles_and_errors); i++) {
        const char *json = command_succeeds(
            "resample", "grey.exr", "--profile", profiles_and_errors[i][0], "--max-error",
            profiles_and_errors[i][1], "--json", "--verify", "--kernel", "linear");
        assert_within_bounds(json, profiles_and_errors[i][0]);
        json_t *root = parse(json);
        const double error = atof(profiles_and_errors[i][1]);
        const json_t *choices = part(root, "choices"), *chosen = NULL;
        for (size_t c = 0; c < json_array_size(choices); c++)
            if (!strcmp(text(json_array_get(choices, c), "state"), "chosen"))
                chosen = json_array_get(choices, c);
        assert_non_null(chosen);
        for (size_t c = 0; c < json_array_size(choices); c++) {
            const json_t *one = json_array_get(choices, c);
            const char *state = text(one, "state");
            if (!strcmp(state, "dearer"))
                assert_true(number(part(one, "seconds"), "total") >=
                            number(part(chosen, "seconds"), "total"));
            if (!strcmp(state, "exceeds"))
                assert_true(number(one, "bound") > number(chosen, "bound"));
        }
        const json_t *plan = json_array_get(part(root, "plans"), 0);
        assert_true(number(plan, "resolution") == number(chosen, "resolution"));
        assert_string_equal(text(plan, "technique"), text(chosen, "technique"));
        const json_t *group = json_array_get(part(root, "groups"), 0);
        assert_true(number(group, "bound") <= error);
        json_decref(root);
    }
    const char *out = command_succeeds("resample", "grey.exr", "--profile", "unorm16",
                                       "--technique", "plain", "--max-error", "0.1", "--explain");
    assert_non_null(strstr(out, "chosen"));
    assert_non_null(strstr(out, "exceeds"));
    assert_null(strstr(out, "dot4"));
    command_fails(1, "the best bound found is ", "resample", "grey.exr", "-o", "a.exr", "--profile",
                  "unorm8", "--max-error", "1e-4", "--kernel", "linear");
}

static const char *const profiles[] = {"fp32",   "fp16",       "unorm16",
                                       "unorm8", "radeon8500", "geforce3"};

static void errors_are_within_bounds(void **state)
{
    (void)state;
    skip_without_gl();
    for (size_t p = 0; p < COUNT(profiles); p++) {
        assert_within_bounds(command_succeeds("resample", "rgba.exr", "--verify", "--json",
                                              "--profile", profiles[p], "--kernel", "bspline"),
                             profiles[p]);
        assert_within_bounds(command_succeeds("resample", "rgba.exr", "--verify", "--json",
                                              "--profile", profiles[p], "--together", "--size",
                                              "64x200", "--kernel", "linear"),
                             profiles[p]);
    }
    static const char *const techniques[] = {"dot4", "split-precision", "hierarchical"};
    for (size_t t = 0; t < COUNT(techniques); t++)
        assert_within_bounds(command_succeeds("resample", "rgba.exr", "--verify", "--json",
                                              "--profile", "unorm8", "--technique", techniques[t],
                                              "--kernel", "bspline", "--channels", "R"),
                             techniques[t]);
    assert_within_bounds(command_succeeds("resample", "grey.exr", "--verify", "--json", "--profile",
                                          "unorm8", "--order", "natural", "--worst-case", "any",
                                          "--bits", "7", "--resolution", "16", "--taps-per-pass",
                                          "2"),
                         "natural order");
}

static void emulation_writes_the_same_pixels(void **state)
{
    (void)state;
    skip_without_gl();
    for (size_t p = 2; p < COUNT(profiles); p++) {
        struct weft_image gl, cpu;
        command_succeeds("resample", "rgba.exr", "-o", "gl.exr", "--profile", profiles[p],
                         "--kernel", "bspline", "--size", "50x61");
        command_succeeds("resample", "rgba.exr", "-o", "cpu.exr", "--profile", profiles[p],
                         "--kernel", "bspline", "--size", "50x61", "--emulate");
        load("gl.exr", &gl);
        load("cpu.exr", &cpu);
        for (size_t c = 0; c < gl.channel_count; c++)
            assert_memory_equal(gl.channels[c].plane, cpu.channels[c].plane,
                                (size_t)gl.width * (size_t)gl.height * sizeof(float));
        weft_image_clear(&gl);
        weft_image_clear(&cpu);
    }
    unlink("gl.exr");
    unlink("cpu.exr");
}

static void same_bytes_from_any_number_of_threads(void **state)
{
    (void)state;
    skip_without_gl();
    char *bytes[2];
    size_t size[2];
    for (int i = 0; i < 2; i++) {
        command_environment(i ? "LP_NUM_THREADS=2" : "LP_NUM_THREADS=0");
        command_succeeds("resample", "rgba.exr", "-o", "t.exr", "--size", "300x200", "--together");
        bytes[i] = command_read_file("t.exr", &size[i]);
    }
    assert_int_equal(size[0], size[1]);
    assert_memory_equal(bytes[0], bytes[1], size[0]);
    free(bytes[0]);
    free(bytes[1]);
    unlink("t.exr");
}

static void verify_prints_bounds(void **state)
{
    (void)state;
    skip_without_gl();
    const char *out = command_succeeds("resample", "rgba.exr", "--verify", "--profile", "unorm8",
                                       "--kernel", "bspline", "--channels", "R,B");
    assert_int_equal(strncmp(out, "B: max error ", 13), 0);
    assert_non_null(strstr(out, "\nR: max error "));
    assert_non_null(strstr(out, "bound "));
    assert_non_null(strstr(out, "for samples from -"));
}

static void smaller_sizes_are_warned_of(void **state)
{
    (void)state;
    skip_without_gl();
    struct command_result r;
    command_run(&r, "weft", "resample", "grey.exr", "--json", "--size", "5x4", "--verify", "-q");
    assert_int_equal(r.code, 0);
    assert_string_equal(r.err, "");
    assert_within_bounds(r.out, "smaller");
    command_run(&r, "weft", "resample", "grey.exr", "--json", "--size", "5x4", "--verify",
                "--antialias", "off");
    assert_int_equal(r.code, 0);
    assert_int_equal(strncmp(r.err, "weft: warning: ", 15), 0);
    assert_non_null(strstr(r.err, "alias"));
    assert_within_bounds(r.out, "smaller");
    command_run(&r, "weft", "resample", "grey.exr", "--json", "--size", "5x4", "-q");
    assert_int_equal(r.code, 0);
    assert_string_equal(r.err, "");
}

static void a_declared_range_is_used(void **state)
{
    (void)state;
    skip_without_gl();
    struct command_result r;
    json_t *root = parse(command_succeeds("resample", "grey.exr", "--json", "--verify",
                                          "--source-range", "-1,2", "--profile", "unorm8"));
    const json_t *group = json_array_get(part(root, "groups"), 0);
    assert_true(number(group, "low") == -1 && number(group, "high") == 2);
    assert_true(number(group, "clamped") == 0);
    json_decref(root);
    command_run(&r, "weft", "resample", "grey.exr", "--json", "--source-range", "0.25,0.5");
    assert_int_equal(r.code, 0);
    assert_non_null(strstr(r.err, "weft: warning: Y: "));
    root = parse(r.out);
    group = json_array_get(part(root, "groups"), 0);
    assert_true(number(group, "clamped") > 0);
    assert_true(number(group, "minimum") > 0.2 && number(group, "maximum") < 0.55);
    json_decref(root);
}

static void previews_are_written(void **state)
{
    (void)state;
    skip_without_gl();
    const char *out = command_succeeds("resample", "rgba.exr", "--preview", "p.png", "--size",
                                       "78x50", "--colour-map", "viridis");
    assert_non_null(strstr(out, "p.png: values from "));
    png_image png = {.version = PNG_IMAGE_VERSION};
    assert_true(png_image_begin_read_from_file(&png, "p.png"));
    assert_int_equal(png.width, 2 * WIDTH); // of the data window
    assert_int_equal(png.height, 2 * HEIGHT);
    png_image_free(&png);
    command_fails(4, "no-clobber", "resample", "rgba.exr", "--preview", "p.png", "--no-clobber");
    unlink("p.png");
}

// R, G and B of the preview, to be freed.
static uint8_t *decode_png(const char *path, int width, int height)
{
    png_image png = {.version = PNG_IMAGE_VERSION};
    assert_true(png_image_begin_read_from_file(&png, path));
    assert_int_equal(png.width, width);
    assert_int_equal(png.height, height);
    png.format = PNG_FORMAT_RGB;
    uint8_t *pixels = malloc(PNG_IMAGE_SIZE(png));
    assert_non_null(pixels);
    assert_true(png_image_finish_read(&png, NULL, pixels, 0, NULL));
    return pixels;
}

static int srgb(double light)
{
    const double v = fmin(fmax(light, 0.0), 1.0);
    return (int)lrint(255.0 * (v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1.0 / 2.4) - 0.055));
}

// Images of colours are shown in them: light times 2^stops, as sRGB. --annotate leaves the pixels
// as they are, somewhere in a larger picture.
static void previews_are_in_colour(void **state)
{
    (void)state;
    static const char *const channels[] = {"R", "G", "B"};
    command_succeeds("resample", "rgba.exr", "-o", "p.exr", "--preview", "p.png", "--engine", "cpu",
                     "--exposure", "-1.5", "--kernel", "nearest", "--size", "100%");
    struct weft_image image;
    assert_int_equal(weft_image_load(&(struct weft_image_load_params){.path = "p.exr"}, &image),
                     WEFT_OK);
    uint8_t *pixels = decode_png("p.png", image.width, image.height);
    for (int c = 0; c < 3; c++) {
        size_t at = 0;
        while (strcmp(image.channels[at].name, channels[c]) != 0)
            at++;
        for (int i = 0; i < image.width * image.height; i++)
            assert_int_equal(pixels[3 * i + c],
                             srgb((double)image.channels[at].plane[i] * exp2(-1.5)));
    }
    free(pixels);
    weft_image_clear(&image);
    unlink("p.png");
    unlink("p.exr");
}

// Larger than a tile, both of pixels and of samples.
static void large_images_have_no_seams(void **state)
{
    (void)state;
    skip_without_gl();
    struct weft_image out;
    command_succeeds("resample", "grey.exr", "-o", "big.exr", "--size", "2600x1100", "--profile",
                     "fp32", "--kernel", "bspline", "--resolution", "512");
    assert_within_bounds(command_succeeds("resample", "big.exr", "-o", "out.exr", "--size",
                                          "2700x1030", "-q", "--json", "--verify", "--kernel",
                                          "linear"),
                         "large");
    load("big.exr", &out);
    assert_true(out.width > 2 * 1024 && out.height > 1000);
    // 512 samples in 67 pixels: neighbours are no further apart than the smooth signal is.
    for (int y = 0; y < out.height; y++)
        for (int x = 1; x < out.width; x++)
            assert_true(fabs(out.channels[0].plane[y * out.width + x] -
                             out.channels[0].plane[y * out.width + x - 1]) < 0.02);
    weft_image_clear(&out);
    unlink("big.exr");
    unlink("out.exr");
}

static void one_pixel_becomes_many(void **state)
{
    (void)state;
    skip_without_gl();
    float value = 0.1f;
    struct weft_image_channel channel = {.name = "Y", .plane = &value};
    const struct weft_image image = {
        .width = 1, .height = 1, .channel_count = 1, .channels = &channel};
    struct weft_image out;
    assert_int_equal(weft_image_save(&image, &(struct weft_image_save_params){.path = "dot.exr"}),
                     WEFT_OK);
    command_succeeds("resample", "dot.exr", "-o", "out.exr", "--size", "9x7", "--profile",
                     "unorm8");
    load("out.exr", &out);
    for (int i = 0; i < 9 * 7; i++) // a constant comes back as it was
        assert_true(out.channels[0].plane[i] == value);
    weft_image_clear(&out);
    unlink("dot.exr");
    unlink("out.exr");
}

static void an_interrupt_leaves_nothing(void **state)
{
    (void)state;
    skip_without_gl();
    static const int signals[] = {SIGINT, SIGTERM};
    for (size_t i = 0; i < 2; i++) {
        int before = command_folder_size();
        int code = command_interrupt(
            1.0, signals[i],
            (const char *[]){"weft", "resample", "rgba.exr", "-o", "long.exr", "--preview",
                             "long.png", "--verify", "--size", "12000x9000", "--kernel", "bspline5",
                             "--profile", "unorm16", NULL});
        assert_int_equal(code, 128 + signals[i]);
        assert_int_equal(command_folder_size(), before);
    }
}

// Sizes by a factor, a percentage and one side; what a smaller picture and its edges become.
static void sizes_and_boundaries(void **state)
{
    static const struct {
        const char *size, *option, *value;
        int width, height;
    } cases[] = {
        {"x2", "--boundary", "mirror", 78, 50},    {"x0.5", "--boundary", "wrap", 20, 13},
        {"50%", "--boundary", "border:2", 20, 13}, {"13x0", "--antialias", "off", 13, 8},
        {"0x50", "--clamp", NULL, 78, 50},         {"1x0", "--kernel", "area", 1, 1},
        {"x0.001", "--clamp", NULL, 1, 1},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(cases); i++) {
        const char *json = command_succeeds("resample", "grey.exr", "-o", "out.exr", "--verify",
                                            "--json", "-q", "--engine", "cpu", "--size",
                                            cases[i].size, cases[i].option, cases[i].value);
        struct weft_image out;
        assert_within_bounds(json, cases[i].size);
        load("out.exr", &out);
        const int width = out.display_max[0] - out.display_min[0] + 1;
        assert_int_equal(width, cases[i].width);
        assert_int_equal(out.display_max[1] - out.display_min[1] + 1, cases[i].height);
        weft_image_clear(&out);
    }
    unlink("out.exr");
}

// ---- refusals -----------------------------------------------------------------------------------

static void bad_usage_is_refused(void **state)
{
    (void)state;
#define resample_fails(text, ...) command_fails(2, text, "resample", "grey.exr", __VA_ARGS__)
    command_fails(2, "no image", "resample", "-o", "a.exr");
    resample_fails("nothing to do", "--size", "10x10");
    resample_fails("exclude", "-o", "a.exr", "-q", "-v");
    resample_fails("--emulate", "-o", "a.exr", "--emulate", "--context", "egl");
    resample_fails("--preview", "-o", "a.exr", "--range", "0,1");
    resample_fails("LO", "--preview", "a.png", "--range", "1,0");
    resample_fails("exclude", "--preview", "a.png", "--range", "0,1", "--exposure", "1");
    resample_fails("of light", "--preview", "a.png", "--colour-map", "grey", "--exposure", "1");
    resample_fails("from -60 to 60", "--preview", "a.png", "--exposure", "61");
    resample_fails("--preview", "-o", "a.exr", "--exposure", "1");
    resample_fails("--preview", "-o", "a.exr", "--annotate");
    resample_fails("--annotate", "--preview", "a.png", "--title", "a");
    resample_fails("LO", "-o", "a.exr", "--source-range", "1,1");
    static const char *const no_sizes[] = {"0%", "x0", "0x0", "x", "%", "-5%", "3x4x5", "x1e", "2x"};
    for (size_t i = 0; i < COUNT(no_sizes); i++)
        resample_fails(no_sizes[i], "-o", "a.exr", "--size", no_sizes[i]);
    resample_fails("1 to 1048576", "-o", "a.exr", "--size", "1000000000x1000000000");
    resample_fails("at most 1048576", "-o", "a.exr", "--size", "x1e9");
    resample_fails("border:V", "-o", "a.exr", "--boundary", "border");
    resample_fails("border:V", "-o", "a.exr", "--boundary", "border:nan");
    resample_fails("border:V", "-o", "a.exr", "--boundary", "border:1e99");
    resample_fails("on, off", "-o", "a.exr", "--antialias", "maybe");
    command_fails(3, "--antialias off", "resample", "grey.exr", "-o", "a.exr", "--size", "50%",
                  "--profile", "unorm8");
    command_fails(3, "mitchell", "resample", "grey.exr", "-o", "a.exr", "--size", "50%", "--kernel",
                  "bspline3i");
    command_fails(3, "not wrap", "resample", "grey.exr", "-o", "a.exr", "--boundary", "wrap",
                  "--profile", "unorm8");
    resample_fails("1 to 1048576", "-o", "a.exr", "--size", "5x9999999");
    resample_fails("2147483648", "-o", "a.exr", "--size", "1000000x1000000");
    resample_fails("fp32", "-o", "a.exr", "--profile", "voodoo");
    resample_fails("catmull-rom", "-o", "a.exr", "--kernel", "nothing");
    resample_fails("dot4", "-o", "a.exr", "--technique", "magic");
    resample_fails("planned", "-o", "a.exr", "--order", "best");
    resample_fails("whole number", "-o", "a.exr", "--resolution", "2.5");
    resample_fails("4 to 16", "-o", "a.exr", "--bits", "3");
    resample_fails("taps-per-pass", "-o", "a.exr", "--taps-per-pass", "99");
    resample_fails("grey", "--preview", "a.png", "--colour-map", "puce");
    resample_fails("osmesa", "-o", "a.exr", "--context", "glx");
    resample_fails("no channel 'Q'; there are Y", "-o", "a.exr", "--channels", "Y,Q");
    resample_fails("no channel ''", "-o", "a.exr", "--channels", "Y,");
    resample_fails("twice", "-o", "a.exr", "--channels", "Y,Y");
    resample_fails("--together needs", "-o", "a.exr", "--together");
    command_fails(2, "--together needs", "resample", "rgba.exr", "-o", "a.exr", "--together",
                  "--channels", "R,G,B");
#undef resample_fails
}

static void bad_files_are_refused(void **state)
{
    (void)state;
    command_fails(2, "is the input", "resample", "grey.exr", "-o", "grey.exr");
    command_fails(2, "must end in .png", "resample", "grey.exr", "--preview", "./grey.exr");
    assert_int_equal(symlink("grey.exr", "link.exr"), 0);
    command_fails(2, "is the input", "resample", "grey.exr", "-o", "link.exr");
    command_fails(2, "is the input", "resample", "link.exr", "-o", "grey.exr");
    unlink("link.exr");
    command_fails(2, "same file", "resample", "grey.exr", "-o", "a", "--preview", "./a");
    command_fails(4, "nowhere", "resample", "grey.exr", "-o", "nowhere/a.exr");
    command_fails(4, "folder", "resample", "grey.exr", "-o", ".");
    command_fails(4, "no-clobber", "resample", "grey.exr", "-o", "rgba.exr", "--no-clobber");
    command_fails(3, "missing.exr", "resample", "missing.exr", "-o", "a.exr");
    command_fails(3, "ml.vdb", "resample", "ml.vdb", "-o", "a.exr");
    command_write_file("broken.exr", "\x76\x2f\x31\x01\x02", 5);
    command_fails(3, "broken.exr", "resample", "broken.exr", "-o", "a.exr");
    unlink("broken.exr");
    if (command_has_gl())
        command_fails(4, "/proc/weft.exr", "resample", "grey.exr", "-o", "/proc/weft.exr");
}

static void windows_have_a_limit(void **state)
{
    (void)state;
    float value = 1.0f;
    struct weft_image_channel channel = {.name = "Y", .plane = &value};
    const struct weft_image image = {
        .x = -800000000, .width = 1, .height = 1, .channel_count = 1, .channels = &channel};
    assert_int_equal(weft_image_save(&image, &(struct weft_image_save_params){.path = "far.exr"}),
                     WEFT_OK);
    command_fails(3, "-1600000000", "resample", "far.exr", "-o", "a.exr");
    command_succeeds("resample", "far.exr", "--explain", "--size", "1x9");
    unlink("far.exr");
}

static void a_negative_range_has_no_logarithm(void **state)
{
    (void)state;
    command_fails(3, "logarithm", "resample", "rgba.exr", "-o", "a.exr", "--technique", "log",
                  "--kernel", "bspline", "--profile", "unorm8", "--emulate");
}

// ---- slices in passes ---------------------------------------------------------------------------

static void slices_run_in_passes(void **state)
{
    (void)state;
    skip_without_gl();
    json_t *root = parse(command_succeeds(
        "slice", "ml.vdb", "-o", "s.exr", "--profile", "radeon8500", "--technique", "dot4",
        "--kernel", "bspline", "--resolution", "16", "--size", "60x50", "--verify", "--json"));
    const json_t *plan = part(root, "pass_plan"), *error = part(root, "error");
    assert_string_equal(text(plan, "profile"), "radeon8500");
    assert_string_equal(text(plan, "technique"), "dot4");
    assert_true(number(plan, "passes") > 1);
    assert_true(number(root, "passes") >= number(plan, "passes"));
    assert_true(number(error, "max") <= number(root, "bound"));
    assert_true(number(part(root, "source_range"), "low") >= 0.0);
    assert_true(number(part(root, "source_range"), "high") <= 1.0);
    json_decref(root);
    json_t *info = parse(command_succeeds("info", "s.exr", "--json"));
    const json_t *metadata = part(info, "metadata");
    assert_string_equal(text(metadata, "weft.profile"), "radeon8500");
    assert_string_equal(text(metadata, "weft.technique"), "dot4");
    assert_string_equal(text(metadata, "weft.kernel"), "bspline");
    assert_true(atof(text(metadata, "weft.bound")) > 0.0);
    json_decref(info);
    unlink("s.exr");
    const char *out =
        command_succeeds("slice", "ml.vdb", "--profile", "unorm8", "--resolution", "8", "--size",
                         "20x20", "--verify", "--order", "natural", "--source-range", "0,1");
    assert_non_null(strstr(out, "max error: "));
    assert_non_null(strstr(out, "bound: "));
    out = command_succeeds("slice", "ml.vdb", "--profile", "unorm8", "--resolution", "8", "--size",
                           "20x20", "--explain");
    assert_non_null(strstr(out, "slice 20x20 of grid"));
    assert_non_null(strstr(out, "unorm8"));
}

static void options_of_passes_need_a_profile(void **state)
{
    (void)state;
    static const char *const cases[] = {
        "--technique=dot4", "--resolution=8",     "--bits=8",       "--taps-per-pass=2",
        "--worst-case=any", "--source-range=0,1", "--order=natural"};
    for (size_t i = 0; i < COUNT(cases); i++)
        command_fails(2, "need --profile", "slice", "ml.vdb", "-o", "a.exr", cases[i]);
    command_fails(2, "--layout", "slice", "ml.vdb", "-o", "a.exr", "--profile", "fp32", "--layout",
                  "plain");
    command_fails(2, "fp32", "slice", "ml.vdb", "-o", "a.exr", "--profile", "voodoo");
}

// ---- real images --------------------------------------------------------------------------------

static const char *real(const char *name)
{
    static char path[2][600];
    static int next;
    next = !next;
    snprintf(path[next], sizeof path[next], "%s/%s", WEFT_TEST_DATA, name);
    return access(path[next], R_OK) == 0 ? path[next] : NULL;
}

#define skip_without_data(name)                                                                    \
    do {                                                                                           \
        if (!real(name)) {                                                                         \
            print_message("[  SKIPPED ] no %s in " WEFT_TEST_DATA "\n", name);                     \
            skip();                                                                                \
        }                                                                                          \
    } while (0)

static void real_images_are_within_bounds(void **state)
{
    (void)state;
    static const char *const images[] = {"stripes.exr", "GammaChart.exr", "BrightRings.exr",
                                         "SquaresSwirls.exr"};
    skip_without_gl();
    skip_without_data("stripes.exr");
    for (size_t i = 0; i < COUNT(images); i++) {
        assert_within_bounds(command_succeeds("resample", real(images[i]), "--verify", "--json",
                                              "-o", "r.exr", "--size", "300x200", "-q"),
                             images[i]);
        assert_within_bounds(command_succeeds("resample", real(images[i]), "--verify", "--json",
                                              "--size", "200x300", "-q", "--profile", "unorm8",
                                              "--kernel", "bspline", "--antialias", "off"),
                             images[i]);
        struct weft_image out;
        load("r.exr", &out);
        assert_int_equal(out.width, 300);
        assert_int_equal(out.height, 200);
        weft_image_clear(&out);
        unlink("r.exr");
    }
}

static void wide_ranges_are_kept(void **state)
{
    (void)state;
    skip_without_gl();
    skip_without_data("WideFloatRange.exr");
    json_t *root = parse(command_succeeds("resample", real("WideFloatRange.exr"), "--verify",
                                          "--json", "-q", "--kernel", "catmull-rom"));
    const json_t *group = json_array_get(part(root, "groups"), 0);
    assert_true(number(part(group, "error"), "max") <= 1e-6 * number(group, "high"));
    json_decref(root);
    assert_within_bounds(command_succeeds("resample", real("WideFloatRange.exr"), "--verify",
                                          "--json", "-q", "--kernel", "bspline", "--profile",
                                          "fp32"),
                         "WideFloatRange");
    assert_within_bounds(command_succeeds("resample", real("WideFloatRange.exr"), "--verify",
                                          "--json", "-q", "--kernel", "bspline"),
                         "WideFloatRange");
}

static void nan_stays_in_reach(void **state)
{
    (void)state;
    skip_without_gl();
    skip_without_data("BrightRingsNanInf.exr");
    const char *json = command_succeeds("resample", real("BrightRingsNanInf.exr"), "--verify",
                                        "--json", "-q", "--profile", "unorm8");
    assert_within_bounds(json, "BrightRingsNanInf");
    json_t *root = parse(json);
    double pixels = number(part(root, "to"), "width") * number(part(root, "to"), "height");
    const json_t *groups = part(root, "groups");
    for (size_t g = 0; g < json_array_size(groups); g++) {
        const json_t *group = json_array_get(groups, g);
        assert_true(number(group, "clamped") > 0);
        // At twice the size, each bad sample has 8 x 8 pixels in whose reach it is.
        assert_true(number(group, "not_finite") > 0);
        assert_true(number(group, "not_finite") <= 64 * number(group, "clamped"));
        assert_true(number(group, "not_finite") < pixels / 2);
    }
    json_decref(root);
}

// ---- missing samples ----------------------------------------------------------------------------

enum { FIELD = 64 };

// Noise around `level`, and values that are not finite, if any.
static void make_field(const char *path, double level, bool holes)
{
    static float plane[FIELD * FIELD];
    struct weft_image_channel channel = {.name = "Y", .plane = plane};
    struct weft_image image = {.width = FIELD,
                               .height = FIELD,
                               .display_max = {FIELD - 1, FIELD - 1},
                               .channel_count = 1,
                               .channels = &channel};
    for (int i = 0; i < FIELD * FIELD; i++)
        plane[i] = (float)(level + (level > 2.0 ? 0.0 : sin(7.0 * i * i)));
    if (holes) {
        plane[20 * FIELD + 30] = NAN;
        plane[22 * FIELD + 31] = -INFINITY;
        plane[63 * FIELD + 2] = INFINITY; // on the border
    }
    const struct weft_image_save_params params = {.path = path};
    assert_int_equal(weft_image_save(&image, &params), WEFT_OK);
}

// Finite pixels are within the bound of those of an image that misses nothing, and verification
// knows which these are.
static void finite_pixels_depend_on_no_missing_sample(void **state)
{
    (void)state;
    skip_without_gl();
    static const char *const kernels[] = {"bspline2i", "bspline3i", "omomsi", "bspline7i"};
    static const char *const with_profile[] = {NULL, "fp32", "unorm16"};
    for (size_t i = 0; i < 2 * COUNT(kernels); i++) {
        const char *kernel = kernels[i / 2], *profile = with_profile[i % COUNT(with_profile)];
        struct weft_image holes, full;
        make_field("full.exr", i % 2 ? 1000.0 : 0.0, false);
        make_field("holes.exr", i % 2 ? 1000.0 : 0.0, true);
        command_succeeds("resample", "full.exr", "-o", "full-out.exr", "--kernel", kernel, "--size",
                         "150x140");
        json_t *root = parse(command_succeeds("resample", "holes.exr", "-o", "holes-out.exr",
                                              "--size", "150x140", "--kernel", kernel, "--json",
                                              "--verify", profile ? "--profile" : NULL, profile));
        const json_t *group = json_array_get(part(root, "groups"), 0);
        const double bound = number(group, "bound");
        assert_true(number(part(group, "error"), "not_finite_mismatches") == 0.0);
        assert_true(number(part(group, "error"), "max") <= bound);
        json_decref(root);
        load("holes-out.exr", &holes);
        load("full-out.exr", &full);
        int missing = 0;
        for (int k = 0; k < 150 * 140; k++) {
            const double value = (double)holes.channels[0].plane[k];
            missing += !isfinite(value);
            if (isfinite(value))
                assert_within((double)full.channels[0].plane[k], value,
                              bound + 2e-6 * (i % 2 ? 1000.0 : 1.0));
        }
        assert_true(missing > 100 && missing < 150 * 140 - 1000);
        weft_image_clear(&holes);
        weft_image_clear(&full);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(help_names_everything),
        cmocka_unit_test(plans_are_explained_without_gl),
        cmocka_unit_test(every_channel_is_written),
        cmocka_unit_test(pixels_lie_where_they_should),
        cmocka_unit_test(the_picture_keeps_its_place),
        cmocka_unit_test(prefiltered_kernels_return_the_image),
        cmocka_unit_test(prefiltered_slices_are_verified),
        cmocka_unit_test(channels_can_be_chosen),
        cmocka_unit_test(axes_are_filtered_one_after_the_other),
        cmocka_unit_test(the_same_size_is_the_same),
        cmocka_unit_test(no_data_may_be_the_largest_float),
        cmocka_unit_test(white_stays_white),
        cmocka_unit_test(normalising_is_a_choice),
        cmocka_unit_test(slices_normalise_too),
        cmocka_unit_test(budgets_are_checked_before_anything_runs),
        cmocka_unit_test(constant_channels_have_budgets),
        cmocka_unit_test(bits_are_the_samples_own),
        cmocka_unit_test(the_cheapest_passes_within_a_budget_are_chosen),
        cmocka_unit_test(errors_are_within_bounds),
        cmocka_unit_test(emulation_writes_the_same_pixels),
        cmocka_unit_test(same_bytes_from_any_number_of_threads),
        cmocka_unit_test(verify_prints_bounds),
        cmocka_unit_test(smaller_sizes_are_warned_of),
        cmocka_unit_test(sizes_and_boundaries),
        cmocka_unit_test(a_declared_range_is_used),
        cmocka_unit_test(previews_are_written),
        cmocka_unit_test(previews_are_in_colour),
        cmocka_unit_test(large_images_have_no_seams),
        cmocka_unit_test(one_pixel_becomes_many),
        cmocka_unit_test(an_interrupt_leaves_nothing),
        cmocka_unit_test(bad_usage_is_refused),
        cmocka_unit_test(bad_files_are_refused),
        cmocka_unit_test(windows_have_a_limit),
        cmocka_unit_test(a_negative_range_has_no_logarithm),
        cmocka_unit_test(slices_run_in_passes),
        cmocka_unit_test(options_of_passes_need_a_profile),
        cmocka_unit_test(real_images_are_within_bounds),
        cmocka_unit_test(wide_ranges_are_kept),
        cmocka_unit_test(nan_stays_in_reach),
        cmocka_unit_test(finite_pixels_depend_on_no_missing_sample),
    };
    return cmocka_run_group_tests(tests, setup, command_teardown);
}
