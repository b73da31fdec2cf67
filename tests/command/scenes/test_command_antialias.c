// SPDX-License-Identifier: BSD-3-Clause
// weft antialias as its users see it: pictures of every way and what options change in them, the
// self-check of weights, edges against exact coverage, several pictures, reports. What is refused
// is in test_command_antialias_errors.c.
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>
#include <jansson.h>

#include "tests/command/scenes/pictures.h"
#include "tests/support/command.h"
#include "tests/support/json.h"
#include "weft.h"

static const char *const ways[] = {"acaa", "msaa", "adaptive", "supersample", "none"};
enum { WAYS = COUNT(ways) };

#define FEW "--scene", "polygons:30,60"
#define antialias(...) command_succeeds("antialias", __VA_ARGS__)

static bool same_pixel(const struct weft_image *a, const struct weft_image *b, int i)
{
    bool same = true;
    for (int c = 0; c < 4; c++)
        same &= memcmp(&plane_of(a, channel_names[c])[i], &plane_of(b, channel_names[c])[i],
                       sizeof(float)) == 0;
    return same;
}

static int count_different(const struct weft_image *a, const struct weft_image *b)
{
    int count = 0;
    for (int i = 0; i < PIXELS; i++)
        count += !same_pixel(a, b, i);
    return count;
}

static double largest_difference(const struct weft_image *a, const struct weft_image *b, int i)
{
    double most = 0.0;
    for (int c = 0; c < 4; c++)
        most = fmax(most, fabs((double)plane_of(a, channel_names[c])[i] -
                               (double)plane_of(b, channel_names[c])[i]));
    return most;
}

static int different_files(const char *a, const char *b)
{
    struct weft_image image[2];
    load(a, &image[0]);
    load(b, &image[1]);
    const int count = count_different(&image[0], &image[1]);
    weft_image_clear(&image[0]);
    weft_image_clear(&image[1]);
    return count;
}

// ---- pictures -----------------------------------------------------------------------------------

static void every_way_makes_its_picture(void **state)
{
    (void)state;
    static const char *const samples[WAYS] = {"4", "4", "16", "16", "1"};
    char text[300];
    for (size_t i = 0; i < WAYS; i++) {
        struct weft_image image;
        json_t *root =
            parse(antialias(ways[i], SIZE, FEW, "-o", "p.exr", "--preview", "p.png", "--json"));
        load("p.exr", &image);
        assert_int_equal(image.width, WIDTH);
        assert_int_equal(image.height, HEIGHT);
        check_values(ways[i], &image);
        check_preview("p.png", &image);
        assert_string_equal(attribute(&image, "weft.antialias", text), ways[i]);
        assert_string_equal(attribute(&image, "weft.scene", text), "polygons:30,60");
        assert_string_equal(attribute(&image, "weft.samples", text), samples[i]);
        attribute(&image, "weft.renderer", text);
        assert_true(number(root, "samples") == atof(samples[i]));
        const json_t *bytes = json_object_get(root, "bytes");
        assert_true(number(bytes, "formula") > 0.0 && number(bytes, "held") > 0.0);
        assert_true(number(json_object_get(root, "picture_seconds"), "median") > 0.0);
        json_decref(root);
        weft_image_clear(&image);
    }
}

static void row_0_is_on_top(void **state)
{
    (void)state;
    for (size_t w = 0; w < WAYS; w++) {
        antialias(ways[w], SIZE, "--scene", "plane", w == 4 ? "--sample-format=16f" : "--samples=4", "-o",
                  "p.exr");
        check_sky("p.exr");
    }
}

static void the_same_request_gives_the_same_bytes(void **state)
{
    (void)state;
    struct command_result result;
    for (size_t i = 0; i < WAYS; i++) {
        antialias(ways[i], SIZE, "--scene", "cornell", "-o", "a.exr");
        antialias(ways[i], SIZE, "--scene", "cornell", "-o", "b.exr");
        assert_same_bytes("a.exr", "b.exr", true);
    }
    antialias("none", SIZE, FEW, "-o", "a.exr", "--seed", "1");
    antialias("none", SIZE, FEW, "-o", "b.exr", "--seed", "2");
    assert_same_bytes("a.exr", "b.exr", false);
    command_run(&result, "weft", "antialias", "none", SIZE, FEW, "-o", "-");
    assert_int_equal(result.code, 0);
    assert_memory_equal(result.out, "v/1\x01", 4);
}

// One sample is one frame of weft effect, in its middle.
static void one_sample_is_a_frame_of_an_effect(void **state)
{
    (void)state;
    static const char *const scenes[] = {"polygons", "cornell", "plane"};
    for (size_t i = 0; i < COUNT(scenes); i++) {
        antialias("none", SIZE, "--scene", scenes[i], "-o", "a.exr");
        command_succeeds("effect", "antialias", SIZE, "--scene", scenes[i], "--frames", "1", "-o",
                         "b.exr");
        assert_int_equal(different_files("a.exr", "b.exr"), 0);
    }
}

// ---- accumulative -------------------------------------------------------------------------------

// The forms that know what is visible give the same bytes; so do the sums of MSAA's samples where
// integers have the same scale.
static void accumulation_is_the_sum_of_samples(void **state)
{
    (void)state;
    double scale[2];
    json_t *root = parse(antialias("acaa", SIZE, FEW, "-o", "a.exr", "--json"));
    scale[0] = number(json_object_get(root, "acaa"), "scale");
    assert_true(json_is_true(json_object_get(json_object_get(root, "weights"), "whole")));
    json_decref(root);
    antialias("acaa", SIZE, FEW, "-o", "b.exr", "--form", "sample-id");
    assert_int_equal(different_files("a.exr", "b.exr"), 0);
    root = parse(antialias("msaa", SIZE, FEW, "-o", "b.exr", "--resolve", "sum", "--json"));
    scale[1] = number(json_object_get(root, "multisample"), "scale");
    json_decref(root);
    struct weft_image image[2];
    load("a.exr", &image[0]);
    load("b.exr", &image[1]);
    // Each rounds a colour to half a unit, and the mean to a float.
    const double bound = 0.5 / scale[0] + 0.5 / scale[1] + (double)FLT_EPSILON;
    int edges = 0;
    for (int c = 0; c < 4; c++)
        for (int i = 0; i < PIXELS; i++)
            if (!(fabs((double)plane_of(&image[0], channel_names[c])[i] -
                       (double)plane_of(&image[1], channel_names[c])[i]) <= bound))
                fail_msg("%s %d differs", channel_names[c], i);
    antialias("none", SIZE, FEW, "-o", "b.exr");
    edges = different_files("a.exr", "b.exr");
    assert_true(edges > PIXELS / 20);
    weft_image_clear(&image[0]);
    weft_image_clear(&image[1]);
}

// One picture a sample at the same places: but for vertices that are snapped anew, and so samples
// that lie next to an edge.
static void jittered_pictures_are_the_same_samples(void **state)
{
    (void)state;
    struct weft_image image[2];
    int other = 0;
    antialias("acaa", SIZE, FEW, "-o", "a.exr");
    antialias("acaa", SIZE, FEW, "-o", "b.exr", "--form", "jitter");
    load("a.exr", &image[0]);
    load("b.exr", &image[1]);
    for (int i = 0; i < PIXELS; i++)
        other += largest_difference(&image[0], &image[1], i) > 1e-6;
    assert_true(other < PIXELS / 20);
    weft_image_clear(&image[0]);
    weft_image_clear(&image[1]);
}

// A sum has the range that it needs; what is given is a start.
static void light_beyond_the_range_is_drawn_again(void **state)
{
    (void)state;
    json_t *root = parse(antialias("acaa", SIZE, "--scene", "cornell", "--json", "-o", "a.exr"));
    const json_t *acaa = json_object_get(root, "acaa");
    const double most = number(json_array_get(json_object_get(root, "channels"), 0), "maximum");
    assert_true(most > 1.0);
    assert_true(number(acaa, "redone") >= 1.0 && number(acaa, "range") >= most);
    json_decref(root);
    root = parse(antialias("acaa", SIZE, "--scene", "cornell", "--json", "--sum-range", "100"));
    assert_true(number(json_object_get(root, "acaa"), "redone") == 0.0);
    json_decref(root);
    antialias("acaa", SIZE, "--scene", "cornell", "--sums", "float", "-o", "b.exr");
    struct weft_image image;
    load("b.exr", &image);
    check_values("floats", &image);
    weft_image_clear(&image);
}

static void more_samples_take_more_passes(void **state)
{
    (void)state;
    json_t *root = parse(antialias("acaa", SIZE, "--samples", "16", "--explain", "--json"));
    const double device = number(json_object_get(root, "acaa"), "device_samples");
    assert_true(device >= 1.0 && number(root, "passes") == 16.0 / device);
    assert_true(number(root, "discrepancy") > 0.0 && number(root, "discrepancy") < 0.3);
    json_decref(root);
}

// ---- weights ------------------------------------------------------------------------------------

// Two squares in one place, each with vertices of its own, one of which covers half the other.
#define COINCIDENT                                                                                 \
    "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv -1 -1 0\nv 0 -1 0\nv 0 1 0\nv -1 1 0\n"             \
    "f 1 2 3 4\nf 5 6 7 8\n"
#define BEFORE_IT "--eye", "0,0,3", "--target", "0,0,0", "--up", "0,1,0"

static void load_map(const char *path, float out[PIXELS])
{
    struct weft_image map;
    assert_int_equal(weft_image_load(weft_image_load_params(.path = path), &map), WEFT_OK);
    assert_int_equal(map.channel_count, 1);
    memcpy(out, plane_of(&map, "weight"), PIXELS * sizeof *out);
    weft_image_clear(&map);
}

static void wrong_weights_end_with_1(void **state)
{
    (void)state;
    struct command_result r;
    static float map[PIXELS];
    static png_byte codes[PIXELS];
    put("twice.obj", COINCIDENT);
    command_run(&r, "weft", "antialias", "acaa", SIZE, "--scene", "twice.obj", BEFORE_IT,
                "--coincident", "none", "-o", "p.exr", "--weight-map", "m.exr", "--json");
    assert_int_equal(r.code, 1);
    assert_non_null(strstr(r.err, "weft: error: "));
    assert_non_null(strstr(r.err, "have more, the first at "));
    assert_null(strchr(strchr(r.err, '\n') + 1, '\n'));
    json_t *root = parse(r.out);
    const json_t *weights = json_object_get(root, "weights");
    const json_t *first = json_object_get(weights, "first_more");
    load_map("m.exr", map);
    int more = 0;
    for (int i = 0; i < PIXELS; i++) {
        assert_true(map[i] >= 1.0f && map[i] <= 2.0f);
        more += map[i] > 1.0f;
    }
    assert_true(more > 20 && more < PIXELS);
    assert_true(number(weights, "more") == more && number(weights, "less") == 0.0);
    assert_true(number(weights, "largest") == 1.0);
    const int x = (int)json_integer_value(json_array_get(first, 0)),
              y = (int)json_integer_value(json_array_get(first, 1));
    assert_true(map[y * WIDTH + x] > 1.0f);
    json_decref(root);
    assert_int_equal(access("p.exr", R_OK), 0);
    // The same as codes.
    command_run(&r, "weft", "antialias", "acaa", SIZE, "--scene", "twice.obj", BEFORE_IT,
                "--coincident", "none", "--weight-map", "m.png", "--allow-weight");
    assert_int_equal(r.code, 0);
    assert_non_null(strstr(r.err, "weft: warning: "));
    load_codes("m.png", PNG_FORMAT_GRAY, codes);
    for (int i = 0; i < PIXELS; i++)
        assert_true(abs(codes[i] - (int)lrint(127.5 * (double)map[i])) <= 1);
    assert_int_equal(codes[0], 128);
}

static void coincident_surfaces_count_once(void **state)
{
    (void)state;
    static const char *const remedies[] = {"stencil", "mask"};
    static float map[PIXELS];
    put("twice.obj", COINCIDENT);
    antialias("none", SIZE, "--scene", "twice.obj", BEFORE_IT, "-o", "n.exr");
    for (size_t i = 0; i < COUNT(remedies); i++) {
        const char *text =
            antialias("acaa", SIZE, "--scene", "twice.obj", BEFORE_IT, "--coincident", remedies[i],
                      "-o", "p.exr", "--weight-map", "m.exr");
        assert_non_null(strstr(text, "weights: all pixels have that of their 4 samples"));
        load_map("m.exr", map);
        for (int k = 0; k < PIXELS; k++)
            assert_true(map[k] == 1.0f);
    }
}

// ---- filters ------------------------------------------------------------------------------------

// Lobes below 0 make values outside of those that there are.
static void filters_reach_further(void **state)
{
    (void)state;
    static const char *const some[] = {"acaa", "adaptive", "supersample"};
    struct weft_image image;
    for (size_t i = 0; i < COUNT(some); i++) {
        double least = 0.0;
        json_t *root =
            parse(antialias(some[i], SIZE, FEW, "--kernel", "mitchell", "-o", "b.exr", "--json"));
        assert_true(number(json_object_get(root, "filter"), "radius") == 2.0);
        json_decref(root);
        load("b.exr", &image);
        for (int k = 0; k < PIXELS; k++)
            least = fmin(least, (double)plane_of(&image, "R")[k]);
        assert_true(least < -1e-4);
        weft_image_clear(&image);
        antialias(some[i], SIZE, FEW, "--kernel-width", "2", "-o", "c.exr");
        assert_true(different_files("b.exr", "c.exr") > PIXELS / 10);
    }
}

// ---- adaptive -----------------------------------------------------------------------------------

// Bit for bit the pixels of one sample, or the supersampled ones.
static void unmarked_pixels_are_those_of_one_sample(void **state)
{
    (void)state;
    struct weft_image one, all, some;
    antialias("none", SIZE, FEW, "-o", "one.exr");
    antialias("supersample", SIZE, FEW, "-o", "all.exr");
    json_t *root = parse(antialias("adaptive", SIZE, FEW, "-o", "some.exr", "--json"));
    const json_t *marks = json_object_get(root, "marks");
    load("one.exr", &one);
    load("all.exr", &all);
    load("some.exr", &some);
    int as_one = 0, as_all = 0;
    for (int i = 0; i < PIXELS; i++) {
        as_one += same_pixel(&some, &one, i);
        as_all += same_pixel(&some, &all, i);
        assert_true(same_pixel(&some, &one, i) || same_pixel(&some, &all, i));
        // All edges are found: elsewhere there is one colour, interpolated anew for each sample.
        assert_true(largest_difference(&some, &all, i) < 1e-6);
    }
    assert_true(as_all > 20 && as_all < PIXELS);
    assert_true(as_one < PIXELS - 20);
    assert_true(number(marks, "pixels") >= PIXELS - as_one);
    assert_true(number(marks, "pixels") < PIXELS);
    assert_true(number(marks, "by_edges") == number(marks, "pixels"));
    assert_true(number(json_object_get(root, "bytes"), "formula") ==
                PIXELS * 11.0 + 112.0 * number(marks, "pixels"));
    assert_true(number(json_object_get(root, "bytes"), "full_supersampling") == PIXELS * 112.0);
    json_decref(root);
    weft_image_clear(&one);
    weft_image_clear(&all);
    weft_image_clear(&some);
}

static void stores_have_the_same_bytes(void **state)
{
    (void)state;
    antialias("adaptive", SIZE, FEW, "-o", "a.exr");
    antialias("adaptive", SIZE, FEW, "--store", "blocks", "-o", "b.exr");
    assert_int_equal(different_files("a.exr", "b.exr"), 0);
    antialias("adaptive", SIZE, FEW, "--pattern", "halton:16", "-o", "b.exr");
    assert_true(different_files("a.exr", "b.exr") > 20);
    json_t *root = parse(antialias("adaptive", SIZE, FEW, "--pattern", "j8", "--json"));
    assert_true(number(root, "samples") == 8.0);
    json_decref(root);
}

static double marked(const char *option, const char *value, const char *key)
{
    json_t *root = parse(antialias("adaptive", SIZE, "--scene", "plane", "--json", option, value));
    const double count = number(json_object_get(root, "marks"), key);
    json_decref(root);
    return count;
}

static void marks_are_as_many_as_asked_for(void **state)
{
    (void)state;
    const double usual = marked("--mark", "complete", "pixels");
    assert_true(usual > 0.0 && usual < PIXELS);
    assert_true(marked("--mark", "visible", "pixels") <= usual);
    assert_true(marked("--contrast", "0.05", "by_contrast") > 0.0);
    assert_true(marked("--contrast", "0.05", "pixels") > usual);
    assert_true(marked("--max-edge-share", "1%", "pixels") <= 0.01 * PIXELS);
    assert_true(marked("--max-edge-share", "0.01", "left") > 0.0);
    assert_true(marked("--max-edge-share", "0.01", "left_error") > 0.0);
}

// ---- several pictures ---------------------------------------------------------------------------

static void pictures_show_the_middles_of_their_times(void **state)
{
    (void)state;
    struct weft_image image;
    char text[300];
    const int before = command_folder_size();
    const char *told = antialias("msaa", SIZE, "--scene", "moving", "--frames", "4", "-o",
                                 "f_%02d.exr", "--preview", "f_%d.png", "--time", "0..0.8");
    assert_non_null(strstr(told, "4 pictures of 4 samples"));
    assert_int_equal(command_folder_size(), before + 8);
    antialias("msaa", SIZE, "--scene", "moving", "-o", "p.exr", "--time", "0.3");
    assert_int_equal(different_files("f_01.exr", "p.exr"), 0);
    assert_true(different_files("f_01.exr", "f_02.exr") > 0);
    load("f_03.exr", &image);
    assert_string_equal(attribute(&image, "weft.frame", text), "3 of 4");
    assert_string_equal(attribute(&image, "weft.time", text), "0.7");
    check_preview("f_3.png", &image);
    weft_image_clear(&image);
    // Nothing is written where nothing is named.
    const int now = command_folder_size();
    for (size_t i = 0; i < WAYS; i++)
        antialias(ways[i], "--size", "16x16", FEW, "--frames", "2");
    assert_int_equal(command_folder_size(), now);
}

// ---- edges --------------------------------------------------------------------------------------

static double rms_of(const char *way, const char *option, const char *value)
{
    json_t *root = parse(antialias(way, SIZE, FEW, "--verify", "--json", option, value));
    const json_t *verify = json_object_get(root, "error");
    const double rms = number(verify, "rms");
    assert_true(number(verify, "max") >= rms && number(verify, "known_to") < 1e-6);
    json_decref(root);
    return rms;
}

// Against exact coverage: more samples are closer.
static void edges_are_verified(void **state)
{
    (void)state;
    const double one = rms_of("none", "--sample-format", "32f"), four = rms_of("msaa", "--samples", "4"),
                 accumulated = rms_of("acaa", "--samples", "4"),
                 sixteen = rms_of("acaa", "--samples", "16"),
                 adaptive = rms_of("adaptive", "--samples", "16"),
                 full = rms_of("supersample", "--samples", "16");
    assert_true(one > 0.02);
    assert_true(four < 0.6 * one && sixteen < 0.6 * four);
    assert_true(fabs(accumulated - four) < 1e-6);
    assert_true(fabs(adaptive - full) < 1e-9 && full < 0.6 * four);
    assert_true(rms_of("acaa", "--kernel", "mitchell") < 0.6 * one);
}

// ---- formats ------------------------------------------------------------------------------------

static double brightest(const char *way, const char *format)
{
    json_t *root = parse(antialias(way, SIZE, "--scene", "cornell", "--json", "--sample-format", format));
    const double most = number(json_array_get(json_object_get(root, "channels"), 0), "maximum");
    json_decref(root);
    return most;
}

static void bytes_cut_light_off(void **state)
{
    (void)state;
    static const char *const some[] = {"msaa", "adaptive"};
    for (size_t i = 0; i < COUNT(some); i++) {
        assert_true(brightest(some[i], "8") == 1.0);
        const double halves = brightest(some[i], "16f");
        assert_true(halves > 2.0);
        assert_true(fabs(halves / brightest(some[i], "32f") - 1.0) < 0x1p-9);
    }
    antialias("msaa", SIZE, FEW, "--depth", "32", "-o", "a.exr", "--type", "half");
    struct weft_image image;
    load("a.exr", &image);
    assert_int_equal(image.channels[0].type, WEFT_PIXEL_HALF);
    weft_image_clear(&image);
}

// ---- scenes -------------------------------------------------------------------------------------

static void scenes_are_seen_as_asked_for(void **state)
{
    (void)state;
    put("square.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n");
    put("keys", "* 0 -0.5,0,0\n* 1 0.5,0,0\n");
    antialias("acaa", SIZE, "--scene", "square.obj", BEFORE_IT, "-o", "a.exr");
    antialias("acaa", SIZE, "--scene", "square.obj", BEFORE_IT, "-o", "b.exr", "--fov", "30");
    assert_true(different_files("a.exr", "b.exr") > 0);
    antialias("acaa", SIZE, "--scene", "square.obj", BEFORE_IT, "-o", "b.exr", "--light",
              "0,0,-90");
    assert_true(different_files("a.exr", "b.exr") > 0);
    antialias("acaa", SIZE, "--scene", "square.obj", BEFORE_IT, "-o", "b.exr", "--keyframes",
              "keys", "--time", "0");
    assert_true(different_files("a.exr", "b.exr") > 0);
    antialias("none", SIZE, "--scene", "cornell", "-o", "a.exr");
    antialias("none", SIZE, "--scene", "cornell", "-o", "b.exr", "--shadow-size", "16");
    assert_true(different_files("a.exr", "b.exr") > 0);
}

// ---- reports ------------------------------------------------------------------------------------

static void lists_are_printed(void **state)
{
    (void)state;
    assert_non_null(strstr(antialias("--scene", "help"), "  cornell "));
    assert_non_null(strstr(antialias("adaptive", "--pattern", "help"), "  j66 "));
    assert_non_null(strstr(antialias("--kernel", "help"), "mitchell"));
}

static void plans_are_explained_and_nothing_drawn(void **state)
{
    (void)state;
    const int before = command_folder_size();
    static const char *const parts[WAYS][3] = {
        {"acaa of polygons, 48 x 32: 1 picture of 4 samples", "form: ", "MSAA of as many samples"},
        {"msaa of polygons", "resolve: blit, colours: 32f", "bytes: 0.1229 MB by formula"},
        {"adaptive of polygons", "marks: complete edges",
         "bytes: by the paper's formula 0.0169 MB and 112 for each marked pixel; 0.172 MB"},
        {"supersample of polygons, 48 x 32: 1 picture of 16 samples", "store: sums",
         "filter: box, 1 pixels wide: a sample reaches 0 pixels"},
        {"none of polygons, 48 x 32: 1 picture of 1 sample", "depths of 24 bits",
         "bytes: 0.03072 MB"},
    };
    for (size_t i = 0; i < WAYS; i++) {
        const char *text = antialias(ways[i], SIZE, "--explain", "-o", "never.exr");
        for (size_t k = 0; k < 3; k++)
            if (!strstr(text, parts[i][k]))
                fail_msg("no \"%s\" in:\n%s", parts[i][k], text);
    }
    assert_int_equal(command_folder_size(), before);
}

static void lines_say_what_came_of_it(void **state)
{
    (void)state;
    const char *text = antialias("adaptive", SIZE, FEW, "--preview", "p.png");
    assert_non_null(strstr(text, "adaptive of polygons:30,60: 1 picture of 16 samples, "));
    assert_non_null(strstr(text, "marked: "));
    assert_non_null(strstr(text, " for full supersampling"));
    assert_non_null(strstr(text, "p.png: values from 0 to 1"));
    assert_string_equal(antialias("none", SIZE, FEW, "--preview", "p.png", "-q"), "");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_way_makes_its_picture),
        cmocka_unit_test(row_0_is_on_top),
        cmocka_unit_test(the_same_request_gives_the_same_bytes),
        cmocka_unit_test(one_sample_is_a_frame_of_an_effect),
        cmocka_unit_test(accumulation_is_the_sum_of_samples),
        cmocka_unit_test(jittered_pictures_are_the_same_samples),
        cmocka_unit_test(light_beyond_the_range_is_drawn_again),
        cmocka_unit_test(more_samples_take_more_passes),
        cmocka_unit_test(wrong_weights_end_with_1),
        cmocka_unit_test(coincident_surfaces_count_once),
        cmocka_unit_test(filters_reach_further),
        cmocka_unit_test(unmarked_pixels_are_those_of_one_sample),
        cmocka_unit_test(stores_have_the_same_bytes),
        cmocka_unit_test(marks_are_as_many_as_asked_for),
        cmocka_unit_test(pictures_show_the_middles_of_their_times),
        cmocka_unit_test(edges_are_verified),
        cmocka_unit_test(bytes_cut_light_off),
        cmocka_unit_test(scenes_are_seen_as_asked_for),
        cmocka_unit_test(lists_are_printed),
        cmocka_unit_test(plans_are_explained_and_nothing_drawn),
        cmocka_unit_test(lines_say_what_came_of_it),
    };
    return cmocka_run_group_tests(tests, set_up, command_teardown);
}
