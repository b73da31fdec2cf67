// SPDX-License-Identifier: BSD-3-Clause
// What weft accumulate refuses: one line that names what, where and the numbers, the documented
// exit code, and the folder as it was.
#include <dirent.h>
#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>
#include <jansson.h>
#include <png.h>

#include "tests/support/command.h"
#include "tests/support/json.h"
#include "weft.h"

enum { WIDTH = 8, HEIGHT = 6, PIXELS = WIDTH * HEIGHT };

// ---- frames -------------------------------------------------------------------------------------

struct recipe {
    int width, x, display;
    float at_3; // value of pixel (3, 0)
    const char *name;
};

// One channel of 0.5, Y by default, but for one pixel.
static void make(const char *path, const struct recipe *recipe)
{
    float plane[2 * PIXELS];
    struct weft_image_channel channel = {.plane = plane};
    struct weft_image image = {.x = recipe->x,
                               .width = recipe->width ? recipe->width : WIDTH,
                               .height = HEIGHT,
                               .display_max = {30, 20 + recipe->display},
                               .channel_count = 1,
                               .channels = &channel};
    for (int i = 0; i < 2 * PIXELS; i++)
        plane[i] = 0.5f;
    plane[3] = recipe->at_3 != 0.0f ? recipe->at_3 : 0.5f;
    snprintf(channel.name, sizeof channel.name, "%s", recipe->name ? recipe->name : "Y");
    assert_int_equal(weft_image_save(&image, weft_image_save_params(.path = path)), WEFT_OK);
}

static void make_png(const char *path)
{
    static const uint8_t pixels[PIXELS];
    png_image png = {
        .version = PNG_IMAGE_VERSION, .width = WIDTH, .height = HEIGHT, .format = PNG_FORMAT_GRAY};
    assert_true(png_image_write_to_file(&png, path, 0, pixels, 0, NULL));
}

// The same with code points (ITU-T H.273) of BT.2020 and a transfer function.
static void put_cicp(const char *path, png_byte function)
{
    const png_byte points[4] = {9, function, 0, 1};
    png_byte row[WIDTH] = {0};
    FILE *out = fopen(path, "wb");
    assert_non_null(out);
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    png_init_io(png, out);
    png_set_IHDR(png, info, WIDTH, HEIGHT, 8, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info_before_PLTE(png, info);
    png_write_chunk(png, (png_const_bytep) "cICP", points, sizeof points);
    png_write_info(png, info);
    for (int y = 0; y < HEIGHT; y++)
        png_write_row(png, row);
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    assert_int_equal(fclose(out), 0);
}

// f_1.exr to f_N.exr
static void make_frames(int count)
{
    for (int i = 1; i <= count; i++) {
        char path[32];
        snprintf(path, sizeof path, "f_%d.exr", i);
        make(path, &(struct recipe){0});
    }
}

static void cut(const char *path, size_t size)
{
    assert_int_equal(truncate(path, (off_t)size), 0);
}

static void put(const char *path, const char *text)
{
    command_write_file(path, text, strlen(text));
}

#define fails(code, text, ...) command_fails(code, text, "accumulate", __VA_ARGS__)

// ---- names --------------------------------------------------------------------------------------

static void test_no_frames(void **state)
{
    (void)state;
    fails(2, "no frames given: weft accumulate FRAMES...", "-o", "m.exr");
    command_fails(2, "no frames given: weft accumulate FRAMES...", "accumulate");
    fails(2, "nothing to do: give -o OUT.exr, --stderr", "f.exr");
    put("list", "");
    command_input("list");
    fails(3, "the list of frames on standard input is empty", "-", "-o", "m.exr");
    put("list", "\r\n\n");
    command_input("list");
    fails(3, "the list of frames on standard input is empty", "-", "-o", "m.exr");
    fails(2, "-, the list of frames on standard input, is given 2 times", "-", "-", "-o", "m.exr");
}

static void test_no_file(void **state)
{
    (void)state;
    make_frames(2);
    assert_int_equal(mkfifo("pipe", 0600), 0);
    assert_int_equal(mkdir("folder", 0700), 0);
    fails(3, "g.exr cannot be read: No such file or directory", "f_1.exr", "g.exr", "-o", "m.exr");
    fails(3, "folder cannot be read: it is a folder; name its files, as FOLDER/*.exr", "folder",
          "-o", "m.exr");
    fails(3, "pipe cannot be read: it is no regular file", "f_1.exr", "pipe", "-o", "m.exr");
    put("text.exr", "hello");
    fails(3, "text.exr", "text.exr", "-o", "m.exr");
    put("empty.exr", "");
    fails(3, "empty.exr", "f_1.exr", "empty.exr", "-o", "m.exr");
    assert_int_equal(rmdir("folder"), 0);
}

static void test_patterns(void **state)
{
    (void)state;
    make_frames(9);
    fails(3, "g_%d.exr: no file has such a name in .", "g_%d.exr", "-o", "m.exr");
    fails(3, "no/g_%d.exr: folder no/: No such file", "no/g_%d.exr", "-o", "m.exr");
    fails(2, "where a folder is numbered --frames FIRST-LAST must say how", "d%d/g.exr", "-o",
          "m.exr");
    fails(2, "the frame's number is there 2 times", "f_%d_%d.exr", "-o", "m.exr");
    fails(2, "'%q_' is neither a frame's number", "%q_%d.exr", "-o", "m.exr");
    fails(2, "--frames needs a name with the frame's number", "f_1.exr", "--frames", "1-2", "-o",
          "m.exr");
    fails(2, "--frames 3-1: FIRST is more than LAST", "f_%d.exr", "--frames", "3-1", "-o", "m.exr");
    fails(2, "'1-' is not FIRST-LAST", "f_%d.exr", "--frames", "1-", "-o", "m.exr");
    fails(2, "--frames 0-99999999: these are 100000000 frames; there may be at most 16777216",
          "f_%d.exr", "--frames", "0-99999999", "-o", "m.exr");
    unlink("f_4.exr");
    fails(3, "f_4.exr cannot be read: No such file or directory", "f_%d.exr", "-o", "m.exr");
    unlink("f_5.exr");
    fails(3,
          "f_4.exr cannot be read: No such file or directory; nor can 1 others of 9 frames "
          "(--skip-bad goes on without them)",
          "f_%d.exr", "-o", "m.exr");
    put("f_99999999.exr", "far away");
    fails(3, "the numbers are from 1 to 99999999, which are more than 16777216 frames", "f_%d.exr",
          "-o", "m.exr");
}

// ---- frames that disagree or are bad ------------------------------------------------------------

static void test_disagreements(void **state)
{
    (void)state;
    make_frames(1);
    make("wide.exr", &(struct recipe){.width = 9});
    make("moved.exr", &(struct recipe){.x = 2});
    make("shown.exr", &(struct recipe){.display = 1});
    make("named.exr", &(struct recipe){.name = "Q"});
    make_png("grey.png");
    fails(3, "wide.exr has 9 x 6 pixels, and f_1.exr 8 x 6", "f_1.exr", "wide.exr", "-o", "m.exr");
    fails(3, "moved.exr has a data window from (2, 0), and f_1.exr from (0, 0)", "f_1.exr",
          "moved.exr", "-o", "m.exr");
    fails(3, "shown.exr has the display window (0, 0) to (30, 21), and f_1.exr (0, 0) to (30, 20)",
          "f_1.exr", "shown.exr", "-o", "m.exr");
    fails(3, "named.exr has no channel Y, which f_1.exr has", "f_1.exr", "named.exr", "-o",
          "m.exr");
    fails(2, "grey.png is PNG, and f_1.exr is EXR: all frames must be of one kind", "f_1.exr",
          "grey.png", "-o", "m.exr");
    put_cicp("grey.png", 16);
    fails(3, "grey.png has the transfer function 16 of H.273 (cICP), which weft does not know",
          "grey.png", "-o", "m.exr");
    command_succeeds("accumulate", "grey.png", "-o", "m.exr", "--transfer", "gamma:2.4");
    put_cicp("grey.png", 13);
    command_succeeds("accumulate", "grey.png", "-o", "m.exr");
    fails(2, "f_1.exr is EXR, and grey.png is PNG", "grey.png", "f_1.exr", "-o", "m.exr",
          "--skip-bad");
    fails(2, "--part", "f_1.exr", "--part", "-o", "m.exr");
    fails(2, "f_1.exr has no part 'left'; there are: 0", "f_1.exr", "--part", "left", "-o",
          "m.exr");
    make("id.exr", &(struct recipe){.name = "objectId"});
    fails(3, "id.exr: no channel of 1 holds colour", "id.exr", "-o", "m.exr");
}

// One of many is cut, and nothing is left of the others' mean.
static void test_bad_frames(void **state)
{
    (void)state;
    struct command_result result;
    make_frames(9);
    cut("f_7.exr", 330);
    fails(3, "f_7.exr: ", "f_%d.exr", "-o", "m.exr");
    put("old", "an earlier mean");
    assert_int_equal(rename("old", "m.exr"), 0);
    fails(3, "f_7.exr: ", "f_%d.exr", "-o", "m.exr");
    size_t size;
    char *kept = command_read_file("m.exr", &size);
    assert_int_equal(size, 15);
    free(kept);
    for (int i = 1; i <= 9; i++) {
        char path[32];
        snprintf(path, sizeof path, "f_%d.exr", i);
        cut(path, 50);
    }
    fails(3, "none of 9 frames can be read: f_1.exr: ", "f_%d.exr", "--skip-bad", "-o", "n.exr");
    // Readable headers, and no values.
    make("f_1.exr", &(struct recipe){.at_3 = NAN});
    command_run(&result, "weft", "accumulate", "f_1.exr", "f_2.exr", "--skip-bad", "-o", "n.exr");
    assert_int_equal(result.code, 3);
    assert_non_null(strstr(result.err, "none of 2 frames could be averaged\n"));
    assert_int_equal(access("n.exr", F_OK), -1);
}

static void test_values(void **state)
{
    (void)state;
    make_frames(2);
    make("nan.exr", &(struct recipe){.at_3 = NAN});
    make("inf.exr", &(struct recipe){.at_3 = INFINITY, .x = 10});
    make("low.exr", &(struct recipe){.at_3 = -0.25f});
    make("high.exr", &(struct recipe){.at_3 = 1.5f});
    fails(3, "nan.exr: channel Y is nan at pixel (3, 0) (--nonfinite says", "f_1.exr", "nan.exr",
          "-o", "m.exr");
    // Pixels are counted as the data window has them.
    fails(3, "inf.exr: channel Y is inf at pixel (13, 0)", "inf.exr", "-o", "m.exr");
    fails(3,
          "low.exr: channel Y is -0.25 at pixel (3, 0), beyond the range of the targets of 8 bits, "
          "0 to 1",
          "f_1.exr", "low.exr", "-o", "m.exr", "--method", "tree", "--emulate");
    fails(3,
          "high.exr: channel Y is 1.5 at pixel (3, 0), beyond the range of the targets of 16 bits, "
          "-1 to 1",
          "f_1.exr", "low.exr", "high.exr", "-o", "m.exr", "--method", "blend", "--bits", "16",
          "--emulate", "--source-range", "-1,1");
    command_succeeds("accumulate", "f_1.exr", "high.exr", "-o", "m.exr", "--method", "tree",
                     "--emulate", "--source-range", "0,2");
    command_succeeds("accumulate", "f_1.exr", "nan.exr", "-o", "m.exr", "--nonfinite", "skip");
    struct weft_image image;
    assert_int_equal(weft_image_load(weft_image_load_params(.path = "m.exr"), &image), WEFT_OK);
    assert_true(image.channels[0].plane[3] == 0.5f);
    weft_image_clear(&image);
    command_succeeds("accumulate", "f_1.exr", "nan.exr", "-o", "m.exr", "--nonfinite", "propagate");
    assert_int_equal(weft_image_load(weft_image_load_params(.path = "m.exr"), &image), WEFT_OK);
    assert_true(isnan(image.channels[0].plane[3]));
    weft_image_clear(&image);
}

// ---- weights ------------------------------------------------------------------------------------

static void weights_fail(int code, const char *weights, const char *message, const char *method)
{
    put("w", weights);
    command_fails(code, message, "accumulate", "f_%d.exr", "-o", "m.exr", "--weights", "w",
                  "--method", method);
}

static void test_weights(void **state)
{
    (void)state;
    make_frames(3);
    weights_fail(3, "1\n2\n", "w has 2 weights, for 3 frames", "auto");
    weights_fail(3, "1\n2\n3\n4", "w has 4 weights, for 3 frames", "auto");
    weights_fail(3, "1\r\n# one\r\nnan\r\n3", "w:3: 'nan' is no weight: it must be finite", "auto");
    weights_fail(3, "1\n2\n-inf\n", "w:3: '-inf' is no weight", "auto");
    weights_fail(3, "1\n2 3\n", "w:2: '2 3' is not one number", "auto");
    weights_fail(3, "1\n2\n1e999\n", "w:3: '1e999' is no weight", "auto");
    weights_fail(3, "0\n0\n0\n", "all 3 weights are 0", "auto");
    weights_fail(3, "1\n-2\n1\n", "the weights add up to 0", "exact");
    weights_fail(3, "1\n-2\n3\n", "w:2: '-2' is below 0, which --method tree does not take",
                 "tree");
    weights_fail(3, "1\n-2\n3\n", "w:2: '-2' is below 0, which --method blend does not take",
                 "blend");
    fails(3, "did you mean mitchell?", "f_%d.exr", "-o", "m.exr", "--weights", "mitchel");
    fails(3, "and the file: No such file", "f_%d.exr", "-o", "m.exr", "--weights", "none.txt");
    fails(2, "--weights gauss:0: sigma is", "f_%d.exr", "-o", "m.exr", "--weights", "gauss:0");
    fails(2, "frame 0, f_1.exr, has -0.0", "f_%d.exr", "-o", "m.exr", "--weights", "catmull-rom",
          "--method", "tree");
    fails(2, "the weights add up to", "f_%d.exr", "-o", "m.exr", "--weights", "d-bspline3");
    fails(2, "are the kernel's own, without a prefilter", "f_%d.exr", "-o", "m.exr", "--weights",
          "lanczos:3+unit");
}

// ---- options ------------------------------------------------------------------------------------

static void test_options(void **state)
{
    (void)state;
    static const struct {
        const char *option[5], *message;
    } cases[] = {
        {{"--method", "tree", "--branching", "1"}, "a node cannot have 1 inputs"},
        {{"--method", "tree", "--branching", "17"}, "a node cannot have 17 inputs"},
        {{"--method", "tree", "--branching", "2x17"}, "a node cannot have 17 inputs"},
        {{"--method", "tree", "--branching", "2x"}, "not a whole number, or several"},
        {{"--method", "tree", "--branching", "2,2"}, "not a whole number, or several"},
        {{"--method", "tree", "--branching", "2x2"}, "such a tree has 4 leaves, for 5 frames"},
        {{"--branching", "4"}, "--branching needs --method tree"},
        {{"--method", "exact", "--bits", "8"}, "--bits needs --method tree, buffer or blend"},
        {{"--method", "tree", "--bits", "half"}, "--bits half needs --method blend"},
        {{"--method", "exact", "--emulate"}, "--emulate needs --method tree, blend or float"},
        {{"--method", "tree", "--nonfinite", "skip"}, "--nonfinite skip needs --method exact"},
        {{"--method", "blend", "--source-range", "1,0"}, "LO must be less than HI"},
        {{"--method", "nearest"}, "'nearest' is not one of: auto, exact"},
        {{"--max-error", "0"}, "--max-error 0: it must be above 0"},
        {{"--until", "0"}, "'0' is not a standard error above 0"},
        {{"--until", "nan"}, "'nan' is not a standard error above 0"},
        {{"--until", "0.1,share=2"}, "'share=2' is not"},
        {{"--until", "0.1,least=1"}, "'least=1' is not"},
        {{"--until", "0.1,least=2.5"}, "'least=2.5' is not"},
        {{"--until", "0.1,radius=-1"}, "'radius=-1' is not"},
        {{"--until", "0.1,"}, "'' is not"},
        {{"--until", "share=90%"}, "neither a standard error, as 0.001, nor one relative"},
        {{"--batch", "0", "--until", "1"}, "--batch 0: not a whole number from 1"},
        {{"--batch", "2"}, "--batch is of the standard error"},
        {{"--transfer", "gamma"}, "not auto, linear, srgb, or gamma:G"},
        {{"--transfer", "gamma:nan"}, "not auto, linear, srgb, or gamma:G"},
        {{"--range", "0,1"}, "--range and --colour-map need --preview"},
        {{"--preview", "p.png", "--colour-map", "no"}, "no colour map 'no'"},
        {{"--threads", "0"}, "--threads 0: not a whole number from 1"},
        {{"-q", "-v"}, "-q and -v exclude each other"},
    };
    make_frames(5);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const char *const *o = cases[i].option;
        command_fails(2, cases[i].message, "accumulate", "f_%d.exr", "-o", "m.exr", o[0], o[1],
                      o[1] ? o[2] : NULL, o[1] && o[2] ? o[3] : NULL);
    }
    fails(1, "no method is within 1e-12 for values from 0 to 1", "f_%d.exr", "-o", "m.exr",
          "--max-error", "1e-12");
    fails(1, "--max-error 0.001: the bound of --method tree is 0.00", "f_%d.exr", "-o", "m.exr",
          "--max-error", "1e-3", "--method", "tree", "--emulate");
    // Floats around 20,000 are 1 / 512 apart.
    make("large.exr", &(struct recipe){.at_3 = 20000.0f});
    fails(1, "--max-error 0.0001: the bound of --method exact is 0.000977", "large.exr", "-o",
          "m.exr", "--max-error", "1e-4");
}

// ---- outputs ------------------------------------------------------------------------------------

static void test_outputs(void **state)
{
    (void)state;
    make_frames(2);
    assert_int_equal(symlink("f_2.exr", "link.exr"), 0);
    assert_int_equal(mkdir("folder.exr", 0700), 0);
    fails(2, "the output f_2.exr is the input f_2.exr", "f_%d.exr", "-o", "f_2.exr");
    fails(2, "the output link.exr is the input f_2.exr", "f_%d.exr", "-o", "link.exr");
    fails(2, "the output ./f_1.exr is the input f_1.exr", "f_%d.exr", "-o", "m.exr", "--stderr",
          "./f_1.exr");
    fails(2, "-o m.exr and --stderr ./m.exr are the same file", "f_%d.exr", "-o", "m.exr",
          "--stderr", "./m.exr");
    fails(4, "no/m.exr cannot be written: folder no/: No such file", "f_%d.exr", "-o", "no/m.exr");
    fails(4, "folder.exr cannot be written: it is a folder", "f_%d.exr", "-o", "folder.exr");
    fails(4, "no/p.png cannot be written", "f_%d.exr", "-o", "m.exr", "--preview", "no/p.png");
    fails(4, "No space left on device", "f_%d.exr", "-o", "/dev/full");
    put("m.exr", "an earlier mean");
    fails(4, "m.exr exists, and --no-clobber is given", "f_%d.exr", "-o", "m.exr", "--no-clobber");
    fails(2, "the name must end in .exr (--preview writes .png)", "f_%d.exr", "-o", "m.png");
    assert_int_equal(rmdir("folder.exr"), 0);
}

// An interrupt writes nothing, leaves no process, and ends weft by the signal.
static void test_interrupt(void **state)
{
    (void)state;
    enum { NAMES = 20000 };
    make_frames(1);
    FILE *list = fopen("list", "w");
    assert_non_null(list);
    for (int i = 0; i < NAMES; i++)
        fputs("f_1.exr\n", list);
    assert_int_equal(fclose(list), 0);
    const int before = command_folder_size();
    command_input("list");
    const int code = command_interrupt(
        0.5, SIGINT, (const char *[]){"weft", "accumulate", "-", "-o", "m.exr", "-q", NULL});
    if (code >= 0) // it may have been faster
        assert_int_equal(code, 128 + SIGINT);
    else
        assert_int_equal(unlink("m.exr"), 0);
    assert_int_equal(command_folder_size(), before);
}

// Every test begins with an empty folder.
static int empty_folder(void **state)
{
    (void)state;
    DIR *folder = opendir(".");
    for (const struct dirent *entry = folder ? readdir(folder) : NULL; entry;
         entry = readdir(folder))
        unlink(entry->d_name);
    return folder ? closedir(folder) : -1;
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup(name, empty_folder)
    const struct CMUnitTest tests[] = {
        TEST(test_no_frames),  TEST(test_no_file),   TEST(test_patterns), TEST(test_disagreements),
        TEST(test_bad_frames), TEST(test_values),    TEST(test_weights),  TEST(test_options),
        TEST(test_outputs),    TEST(test_interrupt),
    };
    return cmocka_run_group_tests(tests, command_setup_folder, command_teardown);
}
