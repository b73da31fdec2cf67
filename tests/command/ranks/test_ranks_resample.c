// SPDX-License-Identifier: BSD-3-Clause
// weft resample on ranks: every byte that one process writes, whoever makes which part, of whatever
// size, in whatever order; errors told once; what is refused.
// By default a few of all combinations, WEFT_RANKS=full in the environment: all of them.
#include <math.h>

#include "tests/command/ranks/mpirun.h"
#include <jansson.h>

#include "weft.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))
enum { MOST_ARGUMENTS = 24, WIDTH = 53, HEIGHT = 71, PIXELS = WIDTH * HEIGHT };

static struct command_result result;

#define needs(kind)                                                                                \
    do {                                                                                           \
        if (!mpirun_is_here(kind))                                                                 \
            skip();                                                                                \
    } while (0)

// ---- images -------------------------------------------------------------------------------------

// Channels R, G, B and A in halves, Z in floats with some of no number, and id in integers of which
// some are no floats.
static void fill_part(struct weft_image *image, struct weft_image_channel *channels,
                      float planes[5][PIXELS], uint32_t *ids, int seed)
{
    static const char *const names[] = {"A", "B", "G", "R", "Z", "id"};
    for (int c = 0; c < 5; c++)
        for (int i = 0; i < PIXELS; i++)
            planes[c][i] = 1.5f + sinf((float)(seed + i % WIDTH * (c + 1)) / 5.0f) *
                                      cosf((float)(i / WIDTH * 3 + c) / 7.0f);
    planes[4][PIXELS / 2] = NAN;
    planes[4][PIXELS - 1] = INFINITY;
    planes[4][3] = 1e30f;
    for (uint32_t i = 0; i < PIXELS; i++)
        ids[i] = (i + (uint32_t)seed) * 2654435761u;
    for (int c = 0; c < 6; c++) {
        channels[c] = (struct weft_image_channel){.type = c < 4    ? WEFT_PIXEL_HALF
                                                          : c == 4 ? WEFT_PIXEL_FLOAT
                                                                   : WEFT_PIXEL_UINT};
        snprintf(channels[c].name, sizeof channels[c].name, "%s", names[c]);
        if (c < 5)
            channels[c].plane = planes[c];
        else
            channels[c].integers = ids;
    }
    image->channels = channels;
    image->channel_count = 6;
}

static void make_images(void)
{
    static float planes[2][5][PIXELS];
    static uint32_t ids[2][PIXELS];
    static struct weft_image_channel channels[2][6];
    struct weft_image parts[2] = {{.name = "first",
                                   .x = -3,
                                   .y = 5,
                                   .width = WIDTH,
                                   .height = HEIGHT,
                                   .display_min = {0, 0},
                                   .display_max = {60, 80}},
                                  {.name = "second",
                                   .x = 4,
                                   .y = -6,
                                   .width = WIDTH - 20,
                                   .height = HEIGHT - 30,
                                   .display_min = {0, 0},
                                   .display_max = {60, 80},
                                   .compression = WEFT_IMAGE_PIZ}};
    for (int p = 0; p < 2; p++)
        fill_part(&parts[p], channels[p], planes[p], ids[p], p * 17);
    assert_int_equal(
        weft_image_save_parts(parts, 2, weft_image_save_params(.path = "parts.exr"), NULL),
        WEFT_OK);
    for (int c = 0; c < WEFT_IMAGE_PXR24; c++) {
        char path[32];
        snprintf(path, sizeof path, "%s.exr",
                 weft_image_compression_names[(enum weft_image_compression)c]);
        parts[0].compression = (enum weft_image_compression)c;
        assert_int_equal(weft_image_save(&parts[0], weft_image_save_params(.path = path)), WEFT_OK);
    }
}

static int setup(void **state)
{
    const int failed = command_setup(state);
    if (!failed)
        make_images();
    return failed;
}

// ---- the same bytes -----------------------------------------------------------------------------

// How the work is divided.
struct division {
    enum mpirun_kind kind;
    int ranks; // 0: without a launcher, by the option
    const char *schedule, *region;
};

struct request {
    const char *argument[MOST_ARGUMENTS];
    bool previews;
};

static void write_out(const struct request *request, const char *exr, const char *png,
                      const char *out[MPIRUN_MOST], const struct division *division)
{
    size_t at = 0;
    out[at++] = "resample";
    for (size_t i = 0; request->argument[i]; i++)
        out[at++] = request->argument[i];
    out[at++] = "-o";
    out[at++] = exr;
    if (request->previews) {
        out[at++] = "--preview";
        out[at++] = png;
    }
    if (division) {
        out[at++] = "--schedule";
        out[at++] = division->schedule;
        if (division->region) {
            out[at++] = "--region";
            out[at++] = division->region;
        }
    }
    out[at] = NULL;
}

static void assert_same(const char *one, const char *all, const struct division *d)
{
    size_t size = 0, other_size = 0;
    char *bytes = command_read_file(one, &size), *others = command_read_file(all, &other_size);
    if (size != other_size || memcmp(bytes, others, size) != 0)
        fail_msg("%s and %s differ: %d ranks, %s, region %s", one, all, d->ranks, d->schedule,
                 d->region ? d->region : "none");
    free(bytes);
    free(others);
}

static void run_all(const struct request *request, const struct division *division, const char *err)
{
    const char *argv[MPIRUN_MOST];
    unlink("all.exr");
    unlink("all.png");
    write_out(request, "all.exr", "all.png", argv, division);
    mpirun_list(&result, division->kind, division->ranks, argv);
    if (result.code != 0)
        fail_msg("%d ranks, %s, region %s: exit code %d: %s", division->ranks, division->schedule,
                 division->region ? division->region : "none", result.code, result.err);
    assert_same("one.exr", "all.exr", division);
    if (request->previews)
        assert_same("one.png", "all.png", division);
    // What is warned of is warned of once.
    assert_int_equal(mpirun_count_lines(result.err, "weft: warning: "),
                     mpirun_count_lines(err, "weft: warning: "));
}

// All combinations, or those of a covering few that a request has.
static int check_request(const struct request *request, const struct division *few, size_t count)
{
    static const int ranks[] = {0, 1, 2, 3, 7};
    static const char *const schedules[] = {"static", "dynamic", "pull", "auto"},
                             *const regions[] = {NULL, "1x9", "7", "64", "rows:13"};
    static struct command_result one;
    const char *argv[MPIRUN_MOST];
    int ran = 0;
    unlink("one.exr");
    write_out(request, "one.exr", "one.png", argv, NULL);
    mpirun_list(&result, MPIRUN_MPICH, 0, argv);
    if (result.code != 0)
        fail_msg("exit code %d: %s", result.code, result.err);
    one = result;
    for (size_t d = 0; !mpirun_is_full() && d < count; d++, ran++)
        run_all(request, &few[d], one.err);
    for (size_t i = 0; mpirun_is_full() && i < COUNT(ranks) * COUNT(schedules) * COUNT(regions);
         i++, ran++)
        run_all(request,
                &(struct division){i % 5 == 4 ? MPIRUN_OPENMPI : MPIRUN_MPICH,
                                   ranks[i / COUNT(schedules) / COUNT(regions)],
                                   schedules[i / COUNT(regions) % COUNT(schedules)],
                                   regions[i % COUNT(regions)]},
                one.err);
    return ran;
}

static const struct request requests[] = {
    {{"parts.exr", "--engine", "cpu"}, true},
    {{"zip.exr", "--engine", "cpu", "--kernel", "nearest", "--size", "97x133"}, true},
    {{"piz.exr", "--engine", "cpu", "--kernel", "lanczos:3", "--sums", "double", "--size", "150x31",
      "--type", "uint"},
     false},
    {{"zips.exr", "--kernel", "bspline3i", "--engine", "cpu", "--verify"}, false},
    {{"rle.exr", "--emulate", "--profile", "radeon8500", "--together", "--channels", "R,G,B,A",
      "--source-range", "0.5,2"},
     false},
    {{"none.exr", "--engine", "cpu", "--max-error", "12bit", "--compression", "zip", "--verify",
      "--channels", "R,G,id"},
     true},
    {{"parts.exr", "--engine", "cpu", "--part", "second", "--compression", "none", "--size",
      "61x162", "--json"},
     false},
};
static const struct division divisions[] = {
    {MPIRUN_MPICH, 2, "auto", NULL},   {MPIRUN_MPICH, 3, "static", "rows:13"},
    {MPIRUN_MPICH, 0, "static", "7"},  {MPIRUN_MPICH, 7, "pull", "64"},
    {MPIRUN_OPENMPI, 2, "pull", "7"},  {MPIRUN_MPICH, 1, "dynamic", NULL},
    {MPIRUN_MPICH, 3, "auto", "29x3"}, {MPIRUN_MPICH, 0, "pull", "rows:64"},
};

static void test_same_bytes(void **state)
{
    int ran = 0;
    (void)state;
    needs(MPIRUN_MPICH);
    needs(MPIRUN_OPENMPI);
    for (size_t i = 0; i < COUNT(requests); i++) {
        const struct division few[] = {divisions[i % COUNT(divisions)],
                                       divisions[(i + 3) % COUNT(divisions)]};
        ran += check_request(&requests[i], few, COUNT(few));
    }
    assert_true(ran >= 2 * (int)COUNT(requests));
}

static void test_same_bytes_of_gl(void **state)
{
    static const struct request of_gl[] = {
        {{"zip.exr"}, false},
        {{"zip.exr", "--kernel", "mitchell", "--profile", "fp32", "--channels", "R,Z"}, false}};
    (void)state;
    needs(MPIRUN_MPICH);
    if (!command_has_gl())
        skip();
    for (size_t i = 0; i < COUNT(of_gl); i++) {
        const struct division few[] = {{MPIRUN_MPICH, 3, "pull", i ? "64" : NULL},
                                       {MPIRUN_MPICH, 0, "static", "7"}};
        assert_true(check_request(&of_gl[i], few, COUNT(few)) >= 2);
    }
}

static void test_shared_images(void **state)
{
    static const char *const names[] = {"BrightRingsNanInf.exr", "GammaChart.exr"};
    int ran = 0;
    (void)state;
    needs(MPIRUN_MPICH);
    for (size_t i = 0; i < COUNT(names); i++) {
        char path[512];
        snprintf(path, sizeof path, "%s/%s", WEFT_TEST_DATA, names[i]);
        if (access(path, R_OK) != 0) {
            print_message("[  SKIPPED ] %s is not there\n", path);
            continue;
        }
        const struct request request = {{path, "--engine", "cpu", "--size", "500x300"}, false};
        const struct division few[] = {{MPIRUN_MPICH, 3, "auto", NULL}};
        ran += check_request(&request, few, COUNT(few));
    }
    if (!ran)
        skip();
}

// ---- told and refused ---------------------------------------------------------------------------

// One line of weft's, with the text in it; and no output.
static void assert_refused(int code, const char *text)
{
    if (result.code != code || !strstr(result.err, text) ||
        mpirun_count_lines(result.err, "weft: error: ") != 1)
        fail_msg("exit code %d, and not %d with one line '%s': %s", result.code, code, text,
                 result.err);
    assert_int_not_equal(access("o.exr", F_OK), 0);
    assert_string_equal(result.out, "");
}

static void test_refused(void **state)
{
    size_t size;
    (void)state;
    needs(MPIRUN_MPICH);
    mpirun(&result, MPIRUN_MPICH, 2, "resample", "zip.exr", "-o", "o.exr", "--region", "frame");
    assert_refused(2, "--region frame: there is one picture");
    mpirun(&result, MPIRUN_MPICH, 3, "resample", "gone.exr", "-o", "o.exr");
    assert_refused(3, "gone.exr");
    mpirun(&result, MPIRUN_MPICH, 2, "resample", "zip.exr", "-o", "o.exr", "--channels", "Q");
    assert_refused(2, "has no channel 'Q'");
    mpirun(&result, MPIRUN_MPICH, 2, "resample", "zip.exr", "-o", "o.exr", "--engine", "cpu",
           "--max-error", "1e-30");
    assert_refused(1, "--max-error 1e-30");
    // Cut where the last lines are: a rank that reads them tells it, whichever it is.
    char *bytes = command_read_file("none.exr", &size);
    command_write_file("cut.exr", bytes, size - 3000);
    free(bytes);
    mpirun(&result, MPIRUN_MPICH, 3, "resample", "cut.exr", "-o", "o.exr", "--engine", "cpu");
    assert_refused(3, "cut.exr");
}

// What is only planned, and what there is to tell, is told once.
static void test_told_once(void **state)
{
    (void)state;
    needs(MPIRUN_MPICH);
    mpirun_succeeds(MPIRUN_MPICH, 3, "resample", "zip.exr", "--explain", "--max-error", "8bit",
                    "--engine", "cpu");
    mpirun(&result, MPIRUN_MPICH, 2, "resample", "zip.exr", "--engine", "cpu", "--json");
    assert_int_equal(result.code, 0);
    json_error_t why;
    json_t *root = json_loads(result.out, 0, &why);
    assert_non_null(root);
    const json_t *ranks = json_object_get(root, "ranks");
    assert_int_equal(json_integer_value(json_object_get(ranks, "count")), 2);
    assert_true(json_integer_value(json_object_get(ranks, "items")) >= 2);
    json_decref(root);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same_bytes),    cmocka_unit_test(test_same_bytes_of_gl),
        cmocka_unit_test(test_shared_images), cmocka_unit_test(test_refused),
        cmocka_unit_test(test_told_once),
    };
    return cmocka_run_group_tests(tests, setup, command_teardown);
}
