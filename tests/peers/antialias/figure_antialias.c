// SPDX-License-Identifier: BSD-3-Clause
// Ways of anti-aliasing side by side, for the eye, with errors and times.
//   figure_antialias [--scene NAME|FILE] [--size WxH] [--crop X,Y,WxH] [--zoom N] [--columns N]
//                    [--runs N] [--context auto|osmesa|egl]
//                    [--peer "LABEL|SECONDS|FILE.png"]... [--pov SCENE.pov] [OUT.png]
// Draws the scene, each triangle in one colour (default polygons:60,3000, 256x256), by every way,
// and compares it with its exact coverage: prints a line "LABEL|MS|MIB|LARGEST|RMS" for each, and
// for each peer's picture of the same scene. OUT.png has the cropped parts (default: the middle, 32
// pixels wide) enlarged, in rows of N columns, the exact one first. --pov: writes the scene for
// POV-Ray, and ends. Exit code: 0, 1, 2 (usage).
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/peers/antialias/povray.h"

enum { MAX_PEERS = 8, MAX_PICTURES = 32, MAX_RUNS = 99, GAP = 4 };

struct options {
    const char *scene, *context, *pov, *out, *peer[MAX_PEERS];
    int size[2], crop[4], zoom, columns, runs, peers;
};

static const struct way {
    const char *label;
    struct antialias_params how;
} ways[] = {
    {"one sample", {.way = ANTIALIAS_NONE, .samples = 1}},
    {"MSAA 4", {.way = ANTIALIAS_MSAA, .samples = 4}},
    {"ACAA 4", {.way = ANTIALIAS_ACAA, .samples = 4}},
    {"ACAA 16", {.way = ANTIALIAS_ACAA, .samples = 16}},
    {"ACAA 64", {.way = ANTIALIAS_ACAA, .samples = 64}},
    {"4 x 4", {.way = ANTIALIAS_SUPERSAMPLE, .samples = 16}},
    {"adaptive 4 x 4", {.way = ANTIALIAS_ADAPTIVE, .samples = 16}},
};
enum { WAYS = sizeof ways / sizeof *ways };

struct figure {
    const struct options *options;
    struct pictured pictured;
    double *exact;
    float *planes[4];            // of the picture in hand
    float *cells[3];             // of all crops, rows downwards
    int width, height, pictures; // of them
};

// ---- crops --------------------------------------------------------------------------------------

static int cells_of(const struct options *o)
{
    return 1 + WAYS + o->peers;
}

static bool allocate_cells(struct figure *f)
{
    const struct options *o = f->options;
    const int columns = o->columns < cells_of(o) ? o->columns : cells_of(o);
    const int rows = (cells_of(o) + columns - 1) / columns;
    f->width = columns * (o->crop[2] * o->zoom + GAP) - GAP;
    f->height = rows * (o->crop[3] * o->zoom + GAP) - GAP;
    bool good = true;
    for (int c = 0; c < PICTURED_COLOURS; c++) {
        const size_t count = (size_t)f->width * (size_t)f->height;
        f->cells[c] = malloc(count * sizeof *f->cells[c]);
        for (size_t i = 0; f->cells[c] && i < count; i++)
            f->cells[c][i] = 1.0f;
        good = good && f->cells[c];
    }
    return good;
}

// The picture in hand as the next cell.
static void put_cell(struct figure *f)
{
    const struct options *o = f->options;
    const int left = f->pictures % o->columns * (o->crop[2] * o->zoom + GAP);
    const int top = f->pictures++ / o->columns * (o->crop[3] * o->zoom + GAP);
    for (int y = 0; y < o->crop[3] * o->zoom; y++)
        for (int x = 0; x < o->crop[2] * o->zoom; x++) {
            const int row = o->size[1] - 1 - (o->crop[1] + y / o->zoom); // upwards
            const size_t from =
                (size_t)row * (size_t)o->size[0] + (size_t)(o->crop[0] + x / o->zoom);
            const size_t to = (size_t)(top + y) * (size_t)f->width + (size_t)(left + x);
            for (int c = 0; c < PICTURED_COLOURS; c++)
                f->cells[c][to] = fminf(fmaxf(f->planes[c][from], 0.0f), 1.0f);
        }
}

static bool save_cells(const struct figure *f)
{
    return weft_colour_preview_save(
               weft_colour_preview_params(.path = f->options->out, .width = f->width,
                                          .height = f->height, .red = f->cells[0],
                                          .green = f->cells[1], .blue = f->cells[2],
                                          .log = &pictured_log)) == WEFT_OK;
}

// ---- pictures -----------------------------------------------------------------------------------

static void report(const struct figure *f, const char *label, double seconds, double bytes)
{
    const struct pictured_error e = pictured_compare(&f->pictured, f->planes, f->exact);
    printf("%s|%.4g|", label, 1e3 * seconds);
    if (bytes > 0.0)
        printf("%.3g", bytes / 0x1p20);
    printf("|%.3g|%.3g\n", e.largest, e.rms);
}

static void take_exact(struct figure *f)
{
    const size_t pixels = (size_t)f->options->size[0] * (size_t)f->options->size[1];
    for (size_t i = 0; i < pixels; i++)
        for (size_t c = 0; c < PICTURED_CHANNELS; c++)
            f->planes[c][i] = (float)f->exact[PICTURED_CHANNELS * i + c];
}

static bool add_way(struct figure *f, const struct way *w)
{
    double seconds[MAX_RUNS];
    antialias_drawer *drawer = pictured_make_drawer(&f->pictured, w->how);
    bool ok = drawer && pictured_draw(&f->pictured, drawer, f->planes) >= 0.0;
    for (int run = 0; run < f->options->runs && ok; run++) {
        seconds[run] = pictured_draw(&f->pictured, drawer, f->planes);
        ok = seconds[run] >= 0.0;
    }
    if (ok) {
        struct antialias_report r;
        antialias_drawer_get_report(drawer, &r);
        report(f, w->label, pictured_median(seconds, f->options->runs), (double)r.bytes);
        put_cell(f);
    }
    antialias_drawer_destroy(&drawer);
    return ok;
}

// LABEL|SECONDS|FILE
static bool add_peer(struct figure *f, const char *text)
{
    char label[64];
    double seconds;
    int used = 0;
    if (sscanf(text, "%63[^|]|%lf|%n", label, &seconds, &used) != 2 || !used) {
        fprintf(stderr, "--peer %s: not LABEL|SECONDS|FILE.png\n", text);
        return false;
    }
    if (!povray_read(&f->pictured, text + used, f->planes))
        return false;
    report(f, label, seconds, 0.0);
    put_cell(f);
    return true;
}

static bool make_all(struct figure *f)
{
    const struct options *o = f->options;
    f->exact = pictured_make_exact(&f->pictured);
    bool ok = f->exact && pictured_allocate(&f->pictured, f->planes) && allocate_cells(f);
    if (!ok)
        return false;
    take_exact(f);
    report(f, "exact", 0.0, 0.0);
    put_cell(f);
    for (int i = 0; i < WAYS && ok; i++)
        ok = add_way(f, &ways[i]);
    for (int i = 0; i < o->peers && ok; i++)
        ok = add_peer(f, o->peer[i]);
    return ok && (!o->out || save_cells(f));
}

static bool run(const struct options *o)
{
    struct figure f = {.options = o};
    weft_context *context = NULL;
    enum weft_context_kind kind;
    bool ok = weft_context_kind_parse(&pictured_log, o->context, &kind) == WEFT_OK &&
              weft_context_create(weft_context_params(.kind = kind, .log = &pictured_log),
                                  &context) == WEFT_OK &&
              pictured_create(context, o->scene, true, o->size, &f.pictured);
    if (ok)
        ok = o->pov ? povray_write(&f.pictured, o->pov) : make_all(&f);
    pictured_clear(&f.pictured);
    pictured_free(f.planes);
    for (int c = 0; c < PICTURED_COLOURS; c++)
        free(f.cells[c]);
    free(f.exact);
    weft_context_destroy(&context);
    return ok;
}

// ---- options ------------------------------------------------------------------------------------

static bool parse_number(const char *text, int least, int most, int *out)
{
    int used = 0;
    return sscanf(text, "%d%n", out, &used) == 1 && !text[used] && *out >= least && *out <= most;
}

static bool parse_option(const char *name, const char *value, struct options *o)
{
    int used = 0, *crop = o->crop;
    if (strcmp(name, "--size") == 0)
        return sscanf(value, "%dx%d%n", &o->size[0], &o->size[1], &used) == 2 && !value[used] &&
               o->size[0] >= 1 && o->size[1] >= 1 && o->size[0] <= 8192 && o->size[1] <= 8192;
    if (strcmp(name, "--crop") == 0)
        return sscanf(value, "%d,%d,%dx%d%n", &crop[0], &crop[1], &crop[2], &crop[3], &used) == 4 &&
               !value[used] && crop[2] > 0 && crop[3] > 0;
    if (strcmp(name, "--zoom") == 0)
        return parse_number(value, 1, 64, &o->zoom);
    if (strcmp(name, "--columns") == 0)
        return parse_number(value, 1, MAX_PICTURES, &o->columns);
    if (strcmp(name, "--runs") == 0)
        return parse_number(value, 1, MAX_RUNS, &o->runs);
    if (strcmp(name, "--peer") == 0 && o->peers < MAX_PEERS)
        return o->peer[o->peers++] = value, true;
    const struct {
        const char *name, **text;
    } texts[] = {{"--scene", &o->scene}, {"--context", &o->context}, {"--pov", &o->pov}};
    for (int i = 0; i < 3; i++)
        if (strcmp(name, texts[i].name) == 0)
            return *texts[i].text = value, true;
    return false;
}

// Where the crop lies is known with the size.
static bool settle(struct options *o)
{
    if (!o->crop[2]) {
        for (int i = 0; i < 2; i++) {
            o->crop[2 + i] = o->size[i] < 32 ? o->size[i] : 32;
            o->crop[i] = (o->size[i] - o->crop[2 + i]) / 2;
        }
    }
    return o->crop[0] >= 0 && o->crop[1] >= 0 && o->crop[2] <= o->size[0] - o->crop[0] &&
           o->crop[3] <= o->size[1] - o->crop[1];
}

int main(int argc, char **argv)
{
    struct options o = {.scene = "polygons:60,3000",
                        .context = "auto",
                        .size = {256, 256},
                        .zoom = 5,
                        .columns = 5,
                        .runs = 5};
    bool good = true;
    for (int i = 1; i < argc && good; i++) {
        if (argv[i][0] != '-') {
            good = !o.out;
            o.out = argv[i];
        } else {
            good = ++i < argc && parse_option(argv[i - 1], argv[i], &o);
        }
    }
    if (!good || !settle(&o)) {
        fprintf(stderr, "usage: figure_antialias [--scene NAME|FILE] [--size WxH] [--crop X,Y,WxH] "
                        "[--zoom N] [--columns N] [--runs N] [--context auto|osmesa|egl] [--peer "
                        "\"LABEL|SECONDS|FILE.png\"]... [--pov SCENE.pov] [OUT.png]\n");
        return 2;
    }
    return run(&o) ? 0 : 1;
}
