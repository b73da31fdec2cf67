// SPDX-License-Identifier: BSD-3-Clause
// weft accumulate and weft effect on ranks: every byte that one process writes, also of states,
// whoever adds which frames, in blocks of whatever size; bad frames told once; what is refused.
// By default a few of all combinations, WEFT_RANKS=full in the environment: all of them.
#include <math.h>

#include "tests/command/ranks/mpirun.h"
#include "weft.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))
enum { MOST_ARGUMENTS = 24, WIDTH = 13, HEIGHT = 11, PIXELS = WIDTH * HEIGHT, FRAMES = 22 };

static struct command_result result;

#define needs(kind)                                                                                \
    do {                                                                                           \
        if (!mpirun_is_here(kind))                                                                 \
            skip();                                                                                \
    } while (0)

// ---- frames -------------------------------------------------------------------------------------

// Halves, but for every fifth frame in floats; Z holds no colour, and is copied. Some values are of
// no number where that is asked for.
static void make_frame(const char *path, int frame, bool nonfinite)
{
    static const char *const names[] = {"B", "G", "R", "Z"};
    static float planes[COUNT(names)][PIXELS];
    struct weft_image_channel channels[COUNT(names)] = {0};
    char owner[16];
    snprintf(owner, sizeof owner, "frame %d", frame);
    struct weft_image_attribute attribute = {"owner", "string", owner, strlen(owner)};
    struct weft_image image = {.width = WIDTH,
                               .height = HEIGHT,
                               .display_max = {WIDTH - 1, HEIGHT - 1},
                               .channels = channels,
                               .channel_count = COUNT(names),
                               .attributes = &attribute,
                               .attribute_count = 1};
    for (size_t c = 0; c < COUNT(names); c++) {
        for (int i = 0; i < PIXELS; i++)
            planes[c][i] = (1.0f + sinf((float)(frame * 31 + i * 7) + (float)c)) / 3.0f;
        planes[c][frame * 3 % PIXELS] = nonfinite && c < 3 ? NAN : 0.5f;
        snprintf(channels[c].name, sizeof channels[c].name, "%s", names[c]);
        channels[c].type = frame % 5 == 3 ? WEFT_PIXEL_FLOAT : WEFT_PIXEL_HALF;
        channels[c].plane = planes[c];
    }
    assert_int_equal(weft_image_save(&image, weft_image_save_params(.path = path)), WEFT_OK);
}

// good_*.exr; n_*.exr with values of no number; bad_*.exr, of which 2 is missing, and 9 is damaged,
// as 15 is. Weights are small ones of either sign, and a 0.
static int setup(void **state)
{
    char weights[1024] = "";
    const int failed = command_setup_folder(state);
    for (int f = 1; f <= FRAMES && !failed; f++) {
        char path[32];
        snprintf(path, sizeof path, "good_%02d.exr", f);
        make_frame(path, f, false);
        snprintf(path, sizeof path, "n_%02d.exr", f);
        make_frame(path, f, true);
        snprintf(path, sizeof path, "bad_%02d.exr", f);
        if (f != 2)
            make_frame(path, f, false);
        if (f == 9 || f == 15)
            assert_int_equal(truncate(path, 300), 0);
        snprintf(weights + strlen(weights), sizeof weights - strlen(weights), "%.17g\n",
                 f == 7    ? 0.0
                 : f == 12 ? -0.0001
                           : 0.001 / (double)f);
    }
    command_write_file("weights.txt", weights, strlen(weights));
    return failed;
}

// ---- the same bytes -----------------------------------------------------------------------------

// How the work is divided.
struct division {
    enum mpirun_kind kind;
    int ranks; // 0: without a launcher, by the option
    const char *schedule, *granularity;
};

// A request, NULL-ended, and what it writes beside: -o and --stderr, with a state of its own
// (accumulate), to be continued where `begin` names frames that are there already.
struct request {
    const char *argument[MOST_ARGUMENTS];
    const char *begin[MOST_ARGUMENTS];
    bool keeps, stops; // stops: --until is met before the last frame
    int code;          // 3 where frames are left out
};

static size_t count_of(const char *const *list)
{
    size_t count = 0;
    while (list[count])
        count++;
    return count;
}

static const char *name(const char *who, const char *ending)
{
    static char names[8][32];
    static int next;
    next = (next + 1) % 8;
    snprintf(names[next], sizeof names[next], "%s%s", who, ending);
    return names[next];
}

// The request, with outputs of this name.
static void write_out(const struct request *request, const char *who, const char *const *more,
                      const char *out[MPIRUN_MOST])
{
    size_t at = 0;
    for (size_t i = 0; request->argument[i]; i++)
        out[at++] = request->argument[i];
    const char *const outputs[] = {"-o",       name(who, ".exr"),  "--preview", name(who, ".png"),
                                   "--stderr", name(who, "_e.exr")};
    memcpy(out + at, outputs, sizeof outputs);
    at += COUNT(outputs);
    if (request->keeps) {
        out[at++] = "--resume";
        out[at++] = name(who, ".state");
    }
    for (size_t i = 0; more[i]; i++)
        out[at++] = more[i];
    out[at] = NULL;
}

static void begin(const struct request *request, const char *who)
{
    const char *list[MPIRUN_MOST];
    size_t at = count_of(request->begin);
    if (at == 0)
        return;
    memcpy(list, request->begin, at * sizeof *list);
    list[at++] = "--resume";
    list[at++] = name(who, ".state");
    list[at++] = "--stderr";
    list[at++] = "begun.exr";
    list[at] = NULL;
    mpirun_list(&result, MPIRUN_MPICH, 0, list);
    assert_int_equal(result.code, 0);
}

static void assert_same(const char *ending, bool must)
{
    size_t size = 0, other_size = 0;
    const char *one = name("one", ending), *all = name("all", ending);
    if (!must && access(one, F_OK) != 0 && access(all, F_OK) != 0)
        return;
    char *bytes = command_read_file(one, &size), *others = command_read_file(all, &other_size);
    if (size != other_size || memcmp(bytes, others, size) != 0)
        fail_msg("%s and %s differ", one, all);
    free(bytes);
    free(others);
}

static void remove_outputs(const char *who)
{
    static const char *const endings[] = {".exr", ".png", "_e.exr", ".state"};
    for (size_t i = 0; i < COUNT(endings); i++)
        unlink(name(who, endings[i]));
}

static void run_one(const struct request *request)
{
    static const char *const none[] = {NULL};
    const char *argv[MPIRUN_MOST];
    remove_outputs("one");
    begin(request, "one");
    write_out(request, "one", none, argv);
    mpirun_list(&result, MPIRUN_MPICH, 0, argv);
    if (result.code != request->code)
        fail_msg("exit code %d, not %d: %s", result.code, request->code, result.err);
    assert_int_equal(!!strstr(result.err, "is met after"), request->stops);
}

static void run_all(const struct request *request, const struct division *division)
{
    const char *const more[] = {"--schedule", division->schedule, "--granularity",
                                division->granularity, NULL};
    const char *argv[MPIRUN_MOST];
    remove_outputs("all");
    begin(request, "all");
    write_out(request, "all", more, argv);
    mpirun_list(&result, division->kind, division->ranks, argv);
    if (result.code != request->code)
        fail_msg("%d ranks, %s, granularity %s: exit code %d, not %d: %s", division->ranks,
                 division->schedule, division->granularity, result.code, request->code, result.err);
    assert_same(".exr", true);
    assert_same("_e.exr", true);
    assert_same(".png", true);
    if (request->keeps)
        assert_same(".state", true);
}

// All combinations of a full run.
static int run_full(const struct request *request)
{
    static const int ranks[] = {0, 1, 2, 3, 7};
    static const char *const schedules[] = {"static", "dynamic", "pull", "auto"},
                             *const granularities[] = {"1", "3", "16", "1000"};
    int ran = 0;
    for (size_t r = 0; r < COUNT(ranks); r++)
        for (size_t s = 0; s < COUNT(schedules); s++)
            for (size_t g = 0; g < COUNT(granularities); g++, ran++)
                run_all(request, &(struct division){ran % 5 == 4 ? MPIRUN_OPENMPI : MPIRUN_MPICH,
                                                    ranks[r], schedules[s], granularities[g]});
    return ran;
}

// Each request once without ranks, and with those that stand beside it.
static void check_requests(const struct request *request, const struct division (*division)[3],
                           size_t count)
{
    int ran = 0;
    for (size_t i = 0; i < count; i++) {
        run_one(&request[i]);
        if (mpirun_is_full())
            ran += run_full(&request[i]);
        for (size_t d = 0; d < 3 && division[i][d].schedule && !mpirun_is_full(); d++, ran++)
            run_all(&request[i], &division[i][d]);
    }
    assert_true(ran >= (int)count);
}

static void test_files(void **state)
{
    static const struct request requests[] = {
        {.argument = {"accumulate", "good_%02d.exr"}, .keeps = true},
        {.argument = {"accumulate", "good_%02d.exr", "--weights", "weights.txt", "--batch", "3"},
         .keeps = true},
        {.argument = {"accumulate", "bad_%02d.exr", "--skip-bad", "--weights", "gauss"},
         .keeps = true,
         .code = 3},
        {.argument = {"accumulate", "n_%02d.exr", "--nonfinite", "skip", "--until", "0.08,least=4"},
         .keeps = true,
         .stops = true},
        {.argument = {"accumulate", "good_%02d.exr", "--batch", "4", "--until", "1e-9,least=5",
                      "--every", "0.01"}},
        {.argument = {"accumulate", "good_%02d.exr", "--batch", "4"},
         .begin = {"accumulate", "good_%02d.exr", "--frames", "1-6", "--batch", "4"},
         .keeps = true},
    };
    static const struct division divisions[COUNT(requests)][3] = {
        {{MPIRUN_MPICH, 2, "pull", "16"},
         {MPIRUN_MPICH, 7, "static", "1"},
         {MPIRUN_MPICH, 0, "auto", "3"}},
        {{MPIRUN_MPICH, 3, "pull", "2"}, {MPIRUN_OPENMPI, 2, "static", "16"}},
        {{MPIRUN_MPICH, 3, "static", "1"}, {MPIRUN_MPICH, 1, "pull", "3"}},
        {{MPIRUN_MPICH, 2, "dynamic", "16"}, {MPIRUN_MPICH, 3, "pull", "1"}},
        {{MPIRUN_MPICH, 3, "pull", "16"}, {MPIRUN_MPICH, 0, "static", "2"}},
        {{MPIRUN_MPICH, 3, "static", "16"}, {MPIRUN_MPICH, 2, "pull", "1"}},
    };
    (void)state;
    needs(MPIRUN_MPICH);
    needs(MPIRUN_OPENMPI);
    check_requests(requests, divisions, COUNT(requests));
}

static void test_effects(void **state)
{
    static const struct request requests[] = {
        {.argument = {"effect", "dof+antialias+motion-blur", "--frames", "14", "--size", "20x16",
                      "--kernel", "mitchell", "--batch", "3"}},
        {.argument = {"effect", "radiosity", "--frames", "5", "--size", "20x16", "--shadow-size",
                      "64"}},
        {.argument = {"effect", "soft-shadow", "--frames", "40", "--size", "20x16", "--until",
                      "0.06,least=6", "--shadow-size", "64"},
         .stops = true},
        {.argument = {"effect", "fade", "--weights", "1,3", "--frames", "3", "--size", "20x16"}},
    };
    static const struct division divisions[COUNT(requests)][3] = {
        {{MPIRUN_MPICH, 2, "pull", "16"}},
        {{MPIRUN_MPICH, 3, "static", "1"}},
        {{MPIRUN_MPICH, 2, "pull", "1"}},
        {{MPIRUN_OPENMPI, 3, "auto", "2"}, {MPIRUN_MPICH, 0, "static", "3"}},
    };
    (void)state;
    needs(MPIRUN_MPICH);
    needs(MPIRUN_OPENMPI);
    if (!command_has_gl())
        skip();
    check_requests(requests, divisions, COUNT(requests));
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

static void test_bad_frames(void **state)
{
    (void)state;
    for (int kind = 0; kind < MPIRUN_KINDS; kind++) {
        needs(kind);
        mpirun(&result, kind, 3, "accumulate", "bad_%02d.exr", "-o", "o.exr");
        assert_refused(3, "bad_02.exr cannot be read");
    }
    mpirun(&result, MPIRUN_MPICH, 3, "accumulate", "bad_%02d.exr", "--frames", "3-22", "-o",
           "o.exr");
    assert_refused(3, ".exr");
    assert_true(strstr(result.err, "bad_09.exr") || strstr(result.err, "bad_15.exr"));
    mpirun(&result, MPIRUN_MPICH, 2, "accumulate", "n_%02d.exr", "-o", "o.exr");
    assert_refused(3, "is nan at pixel");
    // Left out, they are told in their order, each once.
    mpirun(&result, MPIRUN_MPICH, 3, "accumulate", "bad_%02d.exr", "--skip-bad", "--json",
           "--granularity", "30");
    assert_int_equal(result.code, 3);
    assert_int_equal(mpirun_count_lines(result.err, "weft: error: "), 3);
    const char *const missing = strstr(result.err, "bad_02.exr"),
                      *const first = strstr(result.err, "bad_09.exr"),
                      *const second = strstr(result.err, "bad_15.exr");
    assert_true(missing && first && second && missing < first && first < second);
    assert_non_null(strstr(result.err, "3 of 22 frames were left out"));
    assert_non_null(strstr(result.out, "\"skipped_count\": 3"));
    assert_non_null(strstr(result.out, "\"joined\""));
}

static void test_refused(void **state)
{
    static const struct {
        const char *argument[MOST_ARGUMENTS], *text;
        int code;
    } cases[] = {
        {{"accumulate", "good_%02d.exr", "-o", "o.exr", "--method", "tree"},
         "--method exact has none",
         2},
        {{"accumulate", "good_%02d.exr", "-o", "o.exr", "--region", "rows:8"}, "--granularity", 2},
        {{"accumulate", "good_%02d.exr", "--stderr", "o.exr", "--batch", "2", "--skip-bad"},
         "--batch and --skip-bad exclude each other on several ranks",
         2},
        {{"effect", "dof", "-o", "o.exr", "--method", "float"}, "--method exact has none", 2},
        {{"effect", "dof", "-o", "o.exr", "--cost-map", "map"}, "whole frames are divided", 2},
        {{"accumulate", "good_%02d.exr", "-o", "nowhere/o.exr"}, "nowhere", 4},
    };
    (void)state;
    needs(MPIRUN_MPICH);
    for (size_t i = 0; i < COUNT(cases); i++) {
        mpirun_list(&result, MPIRUN_MPICH, 2, cases[i].argument);
        assert_refused(cases[i].code, cases[i].text);
    }
}

// States are joined, and plans told, by rank 0 alone; names on standard input come to it alone.
static void test_rank_0(void **state)
{
    (void)state;
    needs(MPIRUN_MPICH);
    command_succeeds("accumulate", "good_%02d.exr", "--frames", "1-9", "--resume", "1.state");
    mpirun_succeeds(MPIRUN_MPICH, 2, "accumulate", "good_%02d.exr", "--frames", "10-22", "--resume",
                    "2.state");
    mpirun_succeeds(MPIRUN_MPICH, 2, "accumulate", "1.state", "2.state", "-o", "all.exr");
    command_succeeds("accumulate", "good_%02d.exr", "-o", "one.exr");
    assert_same(".exr", true);
    mpirun(&result, MPIRUN_MPICH, 2, "accumulate", "good_%02d.exr", "--explain");
    assert_int_equal(result.code, 0);
    assert_int_equal(mpirun_count_lines(result.err, "weft: "), 1); // that Z is copied
    const char *alone = command_succeeds("accumulate", "good_%02d.exr", "--explain");
    assert_string_equal(result.out, alone);
    char list[FRAMES * 16] = "";
    for (int f = 1; f <= FRAMES; f++)
        snprintf(list + strlen(list), sizeof list - strlen(list), "good_%02d.exr\n", f);
    command_write_file("list.txt", list, strlen(list));
    command_input("list.txt");
    mpirun_succeeds(MPIRUN_MPICH, 2, "accumulate", "-", "-o", "all.exr");
    assert_same(".exr", true);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_files),      cmocka_unit_test(test_effects),
        cmocka_unit_test(test_bad_frames), cmocka_unit_test(test_refused),
        cmocka_unit_test(test_rank_0),
    };
    return cmocka_run_group_tests(tests, setup, command_teardown);
}
