// SPDX-License-Identifier: BSD-3-Clause
// weft antialias on ranks: every byte that one process writes, by all ways, for every number of
// ranks, schedule and size of parts; what is told of ranks; what is refused.
// By default a few of all combinations, WEFT_RANKS=full in the environment: all of them.
#include "tests/command/ranks/mpirun.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))
enum { MOST_ARGUMENTS = 24 };

static struct command_result result;

#define needs(kind)                                                                                \
    do {                                                                                           \
        if (!mpirun_is_here(kind) || !command_has_gl())                                            \
            skip();                                                                                \
    } while (0)

// ---- the same bytes -----------------------------------------------------------------------------

// A request, NULL-ended, without its outputs.
struct request {
    const char *argument[MOST_ARGUMENTS];
    int frames; // 0: one picture
    bool maps;  // weights, too
    int code;
};

// How it is divided. ranks 0: without a launcher. option: names and values, NULL-ended.
struct division {
    enum mpirun_kind kind;
    int ranks;
    const char *option[8];
};

static const char *const endings[] = {".exr", ".png", "_w.exr"};

// "one.exr", or of frame 3 "one_03.exr".
static const char *name(const struct request *request, const char *who, size_t ending, int frame)
{
    static char names[4][64];
    static int next;
    char number[16] = "";
    next = (next + 1) % 4;
    if (request->frames && frame < 0)
        snprintf(number, sizeof number, "_%%02d");
    else if (request->frames)
        snprintf(number, sizeof number, "_%02d", frame);
    snprintf(names[next], sizeof names[next], "%s%s%s", who, number, endings[ending]);
    return names[next];
}

static void run(const struct request *request, const char *who, const struct division *division)
{
    const char *argv[MPIRUN_MOST + 1] = {"weft", "antialias"};
    int at = 2;
    for (int i = 0; request->argument[i]; i++)
        argv[at++] = request->argument[i];
    argv[at++] = "-o";
    argv[at++] = strdup(name(request, who, 0, -1));
    argv[at++] = "--preview";
    argv[at++] = strdup(name(request, who, 1, -1));
    if (request->maps) {
        argv[at++] = "--weight-map";
        argv[at++] = strdup(name(request, who, 2, -1));
    }
    for (int i = 0; division && division->option[i]; i++)
        argv[at++] = division->option[i];
    if (division && division->ranks)
        mpirun_list(&result, division->kind, division->ranks, argv + 1);
    else
        command_run_list(&result, argv);
    if (result.code != request->code)
        fail_msg("%s, %d ranks, %s %s: exit code %d, not %d: %s", request->argument[0],
                 division ? division->ranks : 0,
                 division && division->option[0] ? division->option[0] : "",
                 division && division->option[0] ? division->option[1] : "", result.code,
                 request->code, result.err);
}

static void assert_same(const struct request *request, size_t ending, int frame,
                        const struct division *d)
{
    size_t size = 0, other_size = 0;
    const char *one = name(request, "one", ending, frame),
               *all = name(request, "all", ending, frame);
    char *bytes = command_read_file(one, &size), *others = command_read_file(all, &other_size);
    if (size != other_size || memcmp(bytes, others, size) != 0)
        fail_msg("%s: %s and %s of %d ranks, %s %s, differ", request->argument[0], one, all,
                 d->ranks, d->option[0] ? d->option[0] : "", d->option[0] ? d->option[1] : "");
    free(bytes);
    free(others);
    assert_int_equal(unlink(all), 0);
}

static void check(const struct request *request, const struct division *division)
{
    run(request, "all", division);
    for (int frame = 0; frame < (request->frames ? request->frames : 1); frame++)
        for (size_t e = 0; e < (request->maps ? COUNT(endings) : 2); e++)
            assert_same(request, e, frame, division);
}

static int check_all(const struct request *request)
{
    static const int ranks[] = {0, 1, 2, 3, 7};
    static const char *const schedules[] = {"static", "dynamic", "pull", "auto"},
                             *const regions[] = {"1", "7", "64", "rows:5", "frame"};
    int ran = 0;
    for (size_t r = 0; r < COUNT(ranks); r++)
        for (size_t s = 0; s < COUNT(schedules); s++)
            for (size_t g = 0; g < COUNT(regions); g++) {
                const struct division division = {
                    ran % 5 == 4 ? MPIRUN_OPENMPI : MPIRUN_MPICH,
                    ranks[r],
                    {"--schedule", schedules[s], "--region", regions[g], NULL}};
                if (s == 1 && g == 4) // refused: nothing could move
                    continue;
                check(request, &division);
                ran++;
            }
    return ran;
}

#define POLYGONS "--scene", "polygons:40,20", "--size", "26x19"
static const struct {
    struct request request;
    struct division division[3]; // those with a first option
} cases[] = {
    {{.argument = {"acaa", POLYGONS, "--samples", "16", "--kernel", "mitchell"}, .maps = true},
     {{MPIRUN_MPICH, 2, {"--region", "7"}}, {MPIRUN_MPICH, 7, {"--granularity", "1"}}}},
    {{.argument = {"acaa", "--scene", "cornell", "--size", "18x14", "--coincident", "none",
                   "--kernel", "linear", "--frames", "9"},
      .frames = 9},
     {{MPIRUN_MPICH, 2, {"--schedule", "auto"}},
      {MPIRUN_MPICH, 3, {"--schedule", "dynamic", "--granularity", "2"}}}},
    {{.argument = {"acaa", POLYGONS, "--form", "jitter"}}, {{MPIRUN_MPICH, 0, {"--region", "7"}}}},
    {{.argument = {"acaa", POLYGONS, "--sums", "float", "--frames", "2"}, .frames = 2},
     {{MPIRUN_MPICH, 2, {"--schedule", "static"}}}},
    {{.argument = {"msaa", POLYGONS, "--resolve", "sum", "--sample-format", "16f"}},
     {{MPIRUN_MPICH, 3, {"--region", "rows:4"}}}},
    {{.argument = {"msaa", POLYGONS}}, {{MPIRUN_MPICH, 0, {"--region", "64"}}}},
    {{.argument = {"adaptive", POLYGONS, "--contrast", "0.1", "--kernel", "mitchell"}},
     {{MPIRUN_MPICH, 2, {"--region", "7", "--cost-map", "costs"}},
      {MPIRUN_MPICH, 3, {"--schedule", "pull", "--cost-map", "costs"}}}},
    {{.argument = {"adaptive", POLYGONS, "--max-edge-share", "20%", "--store", "blocks"}},
     {{MPIRUN_MPICH, 2, {"--region", "5x64", "--schedule", "static"}}}},
    {{.argument = {"supersample", "--scene", "moving", "--size", "26x19", "--samples", "4",
                   "--frames", "3"},
      .frames = 3},
     {{MPIRUN_MPICH, 0, {"--schedule", "dynamic", "--region", "7"}},
      {MPIRUN_OPENMPI, 2, {"--region", "frame"}}}},
    {{.argument = {"adaptive", "--scene", "plane", "--size", "30x24", "--samples", "4"}},
     {{MPIRUN_MPICH, 0, {"--region", "7"}}}},
    {{.argument = {"none", "--scene", "polygons:9,9", "--size", "6x5"}},
     {{MPIRUN_MPICH, 3, {"--region", "1", "--schedule", "static"}}}},
};

static void test_files(void **state)
{
    int ran = 0;
    (void)state;
    needs(MPIRUN_MPICH);
    needs(MPIRUN_OPENMPI);
    for (size_t i = 0; i < COUNT(cases); i++) {
        const struct request *request = &cases[i].request;
        run(request, "one", NULL);
        if (mpirun_is_full() && i != 3)
            ran += check_all(request);
        for (size_t d = 0; d < COUNT(cases[i].division) && cases[i].division[d].option[0];
             d++, ran++)
            check(request, &cases[i].division[d]);
    }
    assert_true(ran >= (int)COUNT(cases));
    assert_int_equal(access("costs", R_OK), 0);
}

// Surfaces in one place: the same pixels have too much weight, and the command ends with 1.
static void test_weights(void **state)
{
    static const char mesh[] = "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nv -1 -1 0\nv 1 -1 0\nv 0 1 0\n"
                               "f 1 2 3\nf 4 5 6\n";
    static char first[sizeof result.err];
    (void)state;
    needs(MPIRUN_MPICH);
    command_write_file("twice.obj", mesh, sizeof mesh - 1);
    command_run(&result, "weft", "antialias", "acaa", "--scene", "twice.obj", "--coincident",
                "none", "--size", "30x20", "-o", "one.exr");
    assert_int_equal(result.code, 1);
    assert_non_null(strstr(result.err, "have more, the first at"));
    memcpy(first, result.err, sizeof first);
    mpirun(&result, MPIRUN_MPICH, 3, "antialias", "acaa", "--scene", "twice.obj", "--coincident",
           "none", "--size", "30x20", "--region", "7", "-o", "all.exr");
    assert_int_equal(result.code, 1);
    char *line = strstr(first, "weft: error: ");
    assert_non_null(line);
    *strchr(line, '\n') = 0;
    if (!strstr(result.err, line))
        fail_msg("'%s' is not told: %s", line, result.err);
}

// ---- told and refused ---------------------------------------------------------------------------

static void test_told(void **state)
{
    (void)state;
    needs(MPIRUN_MPICH);
    mpirun(&result, MPIRUN_MPICH, 2, "antialias", "adaptive", POLYGONS, "--granularity", "3",
           "--verify", "--json");
    assert_int_equal(result.code, 0);
    for (const char *const *key =
             (const char *[]){"\"ranks\": {", "\"item_seconds\": [", "\"count\": 2", "\"error\": {",
                              "\"marks\": {", NULL};
         *key; key++)
        if (!strstr(result.out, *key))
            fail_msg("there is no %s: %s", *key, result.out);
    command_run(&result, "weft", "antialias", "none", POLYGONS, "--json");
    assert_int_equal(result.code, 0);
    assert_null(strstr(result.out, "\"ranks\""));
    mpirun(&result, MPIRUN_MPICH, 2, "antialias", "acaa", POLYGONS, "--explain");
    assert_int_equal(result.code, 0);
    assert_non_null(strstr(result.out, "26 x 19"));
    assert_null(strstr(strstr(result.out, "26 x 19") + 1, "26 x 19"));
}

static void assert_refused(int code, const char *text)
{
    if (result.code != code || !strstr(result.err, text) ||
        mpirun_count_lines(result.err, "weft: error: ") != 1)
        fail_msg("exit code %d, and not %d with one line '%s': %s", result.code, code, text,
                 result.err);
    assert_int_not_equal(access("o.exr", F_OK), 0);
}

static void test_refused(void **state)
{
    (void)state;
    needs(MPIRUN_MPICH);
    mpirun(&result, MPIRUN_MPICH, 2, "antialias", "acaa", "--sums", "float", "--region", "7", "-o",
           "o.exr");
    assert_refused(2, "--sums float depends on the order of fragments");
    command_run(&result, "weft", "antialias", "acaa", "--coincident", "alpha", "--granularity", "2",
                "-o", "o.exr");
    assert_refused(2, "--region frame leaves pictures whole");
    command_run(&result, "weft", "antialias", "none", "--region", "frame", "--cost-map", "c", "-o",
                "o.exr");
    assert_refused(2, "--cost-map is of parts");
    mpirun(&result, MPIRUN_MPICH, 3, "antialias", "none", "--scene", "missing.obj", "-o", "o.exr");
    assert_refused(3, "missing.obj");
    mpirun(&result, MPIRUN_MPICH, 2, "antialias", "msaa", "--resolve", "sum", "--scene", "cornell",
           "--region", "20", "--size", "40x30", "-o", "o.exr");
    assert_refused(3, "beyond the range of");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_files),
        cmocka_unit_test(test_weights),
        cmocka_unit_test(test_told),
        cmocka_unit_test(test_refused),
    };
    return cmocka_run_group_tests(tests, command_setup_folder, command_teardown);
}
