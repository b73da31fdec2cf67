// SPDX-License-Identifier: BSD-3-Clause
// What ways of anti-aliasing cost.
//   bench_antialias ways [--size WxH] [--scene NAME] [--runs N] [--context auto|osmesa|egl]
//   bench_antialias adaptive [--size WxH] [--runs N] [--context ...] [SCENE...]
//   bench_antialias bytes [--size WxH] [--runs N] [--context ...]
// ways (512x512, polygons:4000,50): the median time of a picture, from triangles on OpenGL to
// floats in memory, beside that of MSAA; bytes of all that GL and memory hold for it, and by
// formula. Ways run in turns.
// adaptive (512x512; the paper's random polygons, few large ones, the Cornell box, and files that
// are named): the share of pixels with an edge, the paper's bytes and those that are held, time and
// bytes over those of full supersampling with as many samples, and pixels that are missed: not
// marked, though 16 x 16 samples of them differ, of the scene with one colour a triangle; and
// pixels that differ from the picture that they are to have the bytes of: of one sample, or of full
// supersampling.
// bytes (3840x2160): MSAA and accumulation by formula, with the paper's 8 samples and those that
// the device has, as they are held, and the time of both.
// Exit code: 0, 1 (it failed, a pixel is missed or differs), 2 (usage).
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/peers/antialias/pictured.h"

enum { MAX_RUNS = 99, MAX_SCENES = 16, MAX_WAYS = 24 };
static const double MIB = 0x1p20;

struct options {
    int size[2], runs;
    const char *context, *scene[MAX_SCENES];
    int scenes;
};

struct row {
    char label[64];
    struct antialias_params how;
    antialias_drawer *drawer;
    double seconds[MAX_RUNS], median;
    struct antialias_report report;
};

// ---- in turns -----------------------------------------------------------------------------------

static bool make_drawers(const struct pictured *p, struct row *rows, int count)
{
    for (int i = 0; i < count; i++)
        if (!(rows[i].drawer = pictured_make_drawer(p, rows[i].how)))
            return false;
    return true;
}

static void destroy_drawers(struct row *rows, int count)
{
    for (int i = 0; i < count; i++)
        antialias_drawer_destroy(&rows[i].drawer);
}

// One picture that makes shaders, then those that count.
static bool run_in_turns(const struct pictured *p, struct row *rows, int count, int runs,
                         float *const planes[4])
{
    for (int run = -1; run < runs; run++)
        for (int i = 0; i < count; i++) {
            const double seconds = pictured_draw(p, rows[i].drawer, planes);
            if (seconds < 0.0)
                return false;
            rows[i].seconds[run < 0 ? 0 : run] = seconds;
        }
    for (int i = 0; i < count; i++) {
        rows[i].median = pictured_median(rows[i].seconds, runs);
        antialias_drawer_get_report(rows[i].drawer, &rows[i].report);
    }
    return true;
}

static void add(struct row *rows, int *count, struct antialias_params how, const char *label)
{
    rows[*count] = (struct row){.how = how};
    snprintf(rows[(*count)++].label, sizeof rows[0].label, "%s", label);
}

static int device_samples(weft_context *context)
{
    double positions[WEFT_PATTERN_MAX][2];
    int most = 1;
    for (int n = 2; n <= 16; n *= 2)
        if (weft_msaa_positions(context, n, positions) == n)
            most = n;
    return most;
}

// ---- ways ---------------------------------------------------------------------------------------

static int list_ways(int device, struct row *rows)
{
    static const struct {
        const char *name;
        enum weft_acaa_form form;
    } forms[] = {{"post-depth", WEFT_ACAA_POST_DEPTH},
                 {"sample-id", WEFT_ACAA_SAMPLE_ID},
                 {"jitter", WEFT_ACAA_JITTER}};
    char label[64];
    int count = 0;
    add(rows, &count, (struct antialias_params){.way = ANTIALIAS_NONE, .samples = 1}, "none");
    for (int f = 0; f < WEFT_ANTIALIAS_FORMAT_COUNT; f++) {
        snprintf(label, sizeof label, "MSAA %d, %s", device, weft_antialias_format_names[f]);
        add(rows, &count,
            (struct antialias_params){
                .way = ANTIALIAS_MSAA, .samples = device, .format = (enum weft_antialias_format)f},
            label);
    }
    for (int f = 0; f < 3; f++) {
        snprintf(label, sizeof label, "ACAA %d, %s", device, forms[f].name);
        add(rows, &count,
            (struct antialias_params){
                .way = ANTIALIAS_ACAA, .samples = device, .form = forms[f].form},
            label);
    }
    for (int n = 8; n <= 64; n *= n == 16 ? 4 : 2) {
        snprintf(label, sizeof label, "ACAA %d", n);
        add(rows, &count, (struct antialias_params){.way = ANTIALIAS_ACAA, .samples = n}, label);
    }
    add(rows, &count, (struct antialias_params){.way = ANTIALIAS_SUPERSAMPLE, .samples = 16},
        "4 x 4");
    add(rows, &count, (struct antialias_params){.way = ANTIALIAS_ADAPTIVE, .samples = 16},
        "adaptive 4 x 4");
    add(rows, &count,
        (struct antialias_params){
            .way = ANTIALIAS_ADAPTIVE, .samples = 16, .store = WEFT_STORE_BLOCKS},
        "adaptive 4 x 4, blocks");
    return count;
}

static bool measure_ways(const struct options *o, weft_context *context)
{
    struct pictured p;
    struct row *rows = calloc(MAX_WAYS, sizeof *rows);
    float *planes[4] = {NULL};
    const int device = device_samples(context);
    const int count = rows ? list_ways(device, rows) : 0;
    bool ok = pictured_create(context, o->scene[0], false, o->size, &p) && rows &&
              pictured_allocate(&p, planes) && make_drawers(&p, rows, count) &&
              run_in_turns(&p, rows, count, o->runs, planes);
    if (ok)
        printf("%s, %d x %d, medians of %d\n\n| way | ms | / MSAA | MiB | by formula |\n"
               "|---|---:|---:|---:|---:|\n",
               o->scene[0], o->size[0], o->size[1], o->runs);
    for (int i = 0; i < count && ok; i++)
        printf("| %s | %.3g | %.2f | %.2f | %.2f |\n", rows[i].label, 1e3 * rows[i].median,
               rows[i].median / rows[1].median, (double)rows[i].report.bytes / MIB,
               (double)rows[i].report.formula_bytes / MIB);
    if (rows)
        destroy_drawers(rows, count);
    free(rows);
    pictured_free(planes);
    pictured_clear(&p);
    return ok;
}

// ---- adaptive -----------------------------------------------------------------------------------

// Pixels of the flat scene that are not marked though their samples differ, and those that have not
// the bytes of the picture they belong to.
struct faults {
    int64_t mixed, missed, differing;
};

static bool equal(float *const a[4], float *const b[4], size_t pixel)
{
    bool same = true;
    for (int c = 0; c < PICTURED_CHANNELS; c++)
        same = same && memcmp(&a[c][pixel], &b[c][pixel], sizeof a[c][pixel]) == 0;
    return same;
}

// Floats: a triangle's colour, of equal corners, is interpolated to within some 1e-7; in codes of 8
// bits it might fall to either side of a half.
static bool is_mixed(float *const all[4], float *const one[4], size_t pixel)
{
    double most = 0.0;
    for (int c = 0; c < PICTURED_COLOURS; c++)
        most = fmax(most, fabs((double)all[c][pixel] - (double)one[c][pixel]));
    return !(most < 1e-5);
}

enum { ONE, FULL, TRUTH, ADAPTIVE, FLAT_WAYS };

static bool find_faults(const struct options *o, weft_context *context, const char *scene,
                        struct faults *out)
{
    struct pictured p;
    struct row rows[FLAT_WAYS] = {
        [ONE] = {.how = {.way = ANTIALIAS_NONE, .samples = 1}},
        [FULL] = {.how = {.way = ANTIALIAS_SUPERSAMPLE, .samples = 16}},
        [TRUTH] = {.how = {.way = ANTIALIAS_SUPERSAMPLE, .samples = 256}},
        [ADAPTIVE] = {.how = {.way = ANTIALIAS_ADAPTIVE, .samples = 16}},
    };
    for (int i = 0; i < FLAT_WAYS; i++)
        rows[i].how.format = WEFT_ANTIALIAS_RGBA32F;
    float *planes[FLAT_WAYS][4] = {{NULL}};
    bool ok =
        pictured_create(context, scene, true, o->size, &p) && make_drawers(&p, rows, FLAT_WAYS);
    for (int i = 0; i < FLAT_WAYS && ok; i++)
        ok =
            pictured_allocate(&p, planes[i]) && pictured_draw(&p, rows[i].drawer, planes[i]) >= 0.0;
    *out = (struct faults){0};
    struct antialias_report report = {0};
    if (ok)
        antialias_drawer_get_report(rows[ADAPTIVE].drawer, &report);
    const uint8_t *marks = report.marks ? report.marks->marked : NULL;
    for (size_t i = 0; marks && i < (size_t)o->size[0] * (size_t)o->size[1]; i++) {
        const bool mixed = is_mixed(planes[TRUTH], planes[ONE], i);
        out->mixed += mixed;
        out->missed += mixed && !marks[i];
        out->differing += !equal(planes[ADAPTIVE], planes[marks[i] ? FULL : ONE], i);
    }
    destroy_drawers(rows, FLAT_WAYS);
    for (int i = 0; i < FLAT_WAYS; i++)
        pictured_free(planes[i]);
    pictured_clear(&p);
    return ok && marks;
}

static bool measure_scene(const struct options *o, weft_context *context, const char *scene)
{
    enum { FULL_ROW, SUMS, BLOCKS, ROWS };
    const double pixels = (double)o->size[0] * o->size[1];
    struct row rows[ROWS] = {
        [FULL_ROW] = {.how = {.way = ANTIALIAS_SUPERSAMPLE, .samples = 16}},
        [SUMS] = {.how = {.way = ANTIALIAS_ADAPTIVE, .samples = 16}},
        [BLOCKS] = {.how = {.way = ANTIALIAS_ADAPTIVE, .samples = 16, .store = WEFT_STORE_BLOCKS}},
    };
    struct pictured p;
    struct faults faults;
    float *planes[4] = {NULL};
    const bool ok = pictured_create(context, scene, false, o->size, &p) &&
                    pictured_allocate(&p, planes) && make_drawers(&p, rows, ROWS) &&
                    run_in_turns(&p, rows, ROWS, o->runs, planes) &&
                    find_faults(o, context, scene, &faults);
    const char *slash = strrchr(scene, '/');
    if (ok)
        printf(
            "| %s | %.1f | %.1f | %.2f | %.2f | %.3g | %.2f | %.2f | %.2f | %.2f | %.2f | "
            "%" PRId64 " | %" PRId64 " |\n",
            slash ? slash + 1 : scene, 100.0 * (double)rows[SUMS].report.marks->count / pixels,
            100.0 * (double)faults.mixed / pixels, 1e-6 * (double)rows[SUMS].report.formula_bytes,
            (double)rows[SUMS].report.formula_bytes / (double)rows[FULL_ROW].report.formula_bytes,
            1e3 * rows[SUMS].median, rows[SUMS].median / rows[FULL_ROW].median,
            rows[BLOCKS].median / rows[FULL_ROW].median, (double)rows[SUMS].report.bytes / MIB,
            (double)rows[BLOCKS].report.bytes / MIB, (double)rows[FULL_ROW].report.bytes / MIB,
            faults.missed, faults.differing);
    fflush(stdout);
    destroy_drawers(rows, ROWS);
    pictured_free(planes);
    pictured_clear(&p);
    return ok && faults.missed == 0 && faults.differing == 0;
}

static bool measure_adaptive(const struct options *o, weft_context *context)
{
    bool ok = true;
    printf("4 x 4 samples, %d x %d, medians of %d\n\n| scene | marked, %% | mixed, %% | MB by the "
           "paper | / full | ms | / full | blocks / full | MiB | blocks, MiB | full, MiB | missed "
           "| differing |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n",
           o->size[0], o->size[1], o->runs);
    for (int i = 0; i < o->scenes; i++)
        ok = measure_scene(o, context, o->scene[i]) && ok;
    return ok;
}

// ---- bytes --------------------------------------------------------------------------------------

static void print_formulas(const struct options *o)
{
    const int width = o->size[0], height = o->size[1];
    printf("by formula, %d x %d, MiB: MSAA and ACAA with colours of 8, 16f, 32f and depths of 4 "
           "bytes; sums of 3 and 4 integers\n\n| samples | MSAA 8 | ACAA 8 | MSAA 16f | ACAA 16f | "
           "MSAA 32f | ACAA 32f | ACAA 3 x 32 | ACAA 4 x 32 |\n"
           "|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n",
           width, height);
    for (int n = 4; n <= 16; n *= 2) {
        printf("| %d |", n);
        for (int bytes = 4; bytes <= 16; bytes *= 2)
            printf(" %.1f | %.1f |",
                   (double)weft_bytes_multisample(width, height, n, bytes, 4) / MIB,
                   (double)weft_bytes_accumulative(width, height, n, bytes, 4) / MIB);
        printf(" %.1f | %.1f |\n", (double)weft_bytes_accumulative(width, height, n, 12, 4) / MIB,
               (double)weft_bytes_accumulative(width, height, n, 16, 4) / MIB);
    }
    printf("\n");
}

static int list_bytes(int device, struct row *rows)
{
    char label[64];
    int count = 0;
    for (int f = 0; f < WEFT_ANTIALIAS_FORMAT_COUNT; f++) {
        snprintf(label, sizeof label, "MSAA %d, %s", device, weft_antialias_format_names[f]);
        add(rows, &count,
            (struct antialias_params){
                .way = ANTIALIAS_MSAA, .samples = device, .format = (enum weft_antialias_format)f},
            label);
    }
    snprintf(label, sizeof label, "ACAA %d", device);
    add(rows, &count, (struct antialias_params){.way = ANTIALIAS_ACAA, .samples = device}, label);
    return count;
}

static bool measure_bytes(const struct options *o, weft_context *context)
{
    struct pictured p;
    struct row *rows = calloc(MAX_WAYS, sizeof *rows);
    float *planes[4] = {NULL};
    const int count = rows ? list_bytes(device_samples(context), rows) : 0;
    print_formulas(o);
    bool ok = pictured_create(context, o->scene[0], false, o->size, &p) && rows &&
              pictured_allocate(&p, planes);
    if (ok)
        printf("held, %s, medians of %d\n\n| way | bytes/pixel | MiB | by formula | ms |\n"
               "|---|---:|---:|---:|---:|\n",
               o->scene[0], o->runs);
    for (int i = 0; i < count && ok; i++) { // one after the other, as they are large
        ok = make_drawers(&p, rows + i, 1) && run_in_turns(&p, rows + i, 1, o->runs, planes);
        if (ok)
            printf("| %s | %.1f | %.1f | %.1f | %.4g |\n", rows[i].label,
                   (double)rows[i].report.bytes / ((double)o->size[0] * o->size[1]),
                   (double)rows[i].report.bytes / MIB, (double)rows[i].report.formula_bytes / MIB,
                   1e3 * rows[i].median);
        destroy_drawers(rows + i, 1);
    }
    free(rows);
    pictured_free(planes);
    pictured_clear(&p);
    return ok;
}

// ---- options ------------------------------------------------------------------------------------

static bool parse_option(const char *name, const char *value, struct options *o)
{
    int used = 0;
    if (strcmp(name, "--size") == 0)
        return sscanf(value, "%dx%d%n", &o->size[0], &o->size[1], &used) == 2 && !value[used] &&
               o->size[0] >= 1 && o->size[1] >= 1 && o->size[0] <= 8192 && o->size[1] <= 8192;
    if (strcmp(name, "--runs") == 0)
        return sscanf(value, "%d%n", &o->runs, &used) == 1 && !value[used] && o->runs >= 1 &&
               o->runs <= MAX_RUNS;
    if (strcmp(name, "--scene") == 0) {
        o->scene[0] = value;
        o->scenes = 1;
        return true;
    }
    o->context = value;
    return strcmp(name, "--context") == 0;
}

static bool parse(int argc, char **argv, struct options *o)
{
    for (int i = 2; i < argc; i++) {
        if (argv[i][0] != '-') {
            if (o->scenes == MAX_SCENES)
                return false;
            o->scene[o->scenes++] = argv[i];
        } else if (++i >= argc || !parse_option(argv[i - 1], argv[i], o)) {
            return false;
        }
    }
    return true;
}

int main(int argc, char **argv)
{
    static const struct {
        const char *name;
        bool (*measure)(const struct options *o, weft_context *context);
        struct options options;
    } benches[] = {
        {"ways",
         measure_ways,
         {.size = {512, 512}, .runs = 5, .scene = {"polygons:4000,50"}, .scenes = 1}},
        {"adaptive",
         measure_adaptive,
         {.size = {512, 512},
          .runs = 5,
          .scene = {"polygons:4000,50", "polygons:32000,50", "polygons:40,20000", "cornell"},
          .scenes = 4}},
        {"bytes",
         measure_bytes,
         {.size = {3840, 2160}, .runs = 3, .scene = {"polygons:4000,50"}, .scenes = 1}},
    };
    const int count = sizeof benches / sizeof *benches;
    int which = 0;
    while (which < count && (argc < 2 || strcmp(argv[1], benches[which].name) != 0))
        which++;
    struct options options = benches[which % count].options;
    options.context = "auto";
    if (which == count || !parse(argc, argv, &options)) {
        fprintf(stderr, "usage: bench_antialias ways|adaptive|bytes [--size WxH] [--scene NAME] "
                        "[--runs N] [--context auto|osmesa|egl] [SCENE...]\n");
        return 2;
    }
    weft_context *context = NULL;
    enum weft_context_kind kind;
    bool ok = weft_context_kind_parse(&pictured_log, options.context, &kind) == WEFT_OK &&
              weft_context_create(weft_context_params(.kind = kind, .log = &pictured_log),
                                  &context) == WEFT_OK;
    if (ok)
        printf("%s; ", weft_context_get_info(context)->renderer);
    ok = ok && benches[which].measure(&options, context);
    weft_context_destroy(&context);
    return ok ? 0 : 1;
}
