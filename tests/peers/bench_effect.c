// SPDX-License-Identifier: BSD-3-Clause
// What an effect costs by method: anti-aliasing of the RGB colour cube, frames drawn by the
// command's own drawing.
//   bench_effect [--paper] [--size WxH] [--frames N,N,...] [--runs N] [--clock wall|cpu]
//                [--context auto|osmesa|egl]
// Default: 512x512, 8, 64 and 1,024 frames, 5 runs, wall clock; of more than 100 frames 3 runs at
// most. On a software GL and a machine that others use as well, the processor time of all threads
// says more.
//
// Prints, for each number of frames and method: the median time of a picture, from
// creating the accumulator to the mean in memory; textures and bytes that were alive at most; the
// largest error of the picture against the exact mean of the same frames, in codes of 8 bits, and
// the bound that was promised for it; and the error against the exact mean of frames of floats,
// which has the frames' own rounding to 8 bits in it. --paper: instead, the 8-frame anti-aliasing
// of Haeberli and Akeley, "The Accumulation Buffer" (SIGGRAPH 1990), as Lagae, Suykens and Dutre
// time it: pictures and frames a second, with drawing and of frames that lie in textures. Methods
// run in turns. Exit code: 0, 1 (a run failed, or an error is beyond its bound), 2 (usage).
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "tests/peers/counts.h"
#include "tests/peers/drawn.h"
#include "tools/render/gl/gl.h"

enum { MAX_RUNS = 99, PAPER_FRAMES = 8, LONG = 100, LONG_RUNS = 3 };

static const struct row {
    const char *label;
    struct weft_accumulator_params params;
} rows[] = {
    {"exact, of floats", {.method = WEFT_ACCUMULATE_EXACT, .frame_bits = 32}},
    {"exact, of 8 bits", {.method = WEFT_ACCUMULATE_EXACT, .frame_bits = 8}},
    {"float", {.method = WEFT_ACCUMULATE_FLOAT, .frame_bits = 32}},
    {"tree of 4, 8 bits", {.method = WEFT_ACCUMULATE_TREE, .branching = 4, .bits = 8}},
    {"blending, 8 bits", {.method = WEFT_ACCUMULATE_BLEND, .bits = 8}},
    {"buffer, 16 bits", {.method = WEFT_ACCUMULATE_BUFFER, .bits = 16, .frame_bits = 8}},
};
enum { ROWS = sizeof rows / sizeof *rows, EXACT_FLOATS = 0, EXACT_CODES = 1 };

// What frames are drawn into: codes of 8 bits or floats.
enum depth { CODES, FLOATS, DEPTHS };

static enum depth depth_of(const struct row *row)
{
    return row->params.frame_bits == 32 ? FLOATS : CODES;
}

struct options {
    int size[2], runs;
    int64_t count[MAX_COUNTS];
    int counts;
    const char *context;
    bool paper;
    bool cpu; // processor time
};

struct bench {
    const struct options *options;
    struct drawn drawn;
    GladGLContext gl;
    float *picture[ROWS];
    struct {
        unsigned texture, framebuffer;
    } kept[DEPTHS][PAPER_FRAMES];
    unsigned z; // renderbuffer of depths
    double seconds[ROWS][MAX_RUNS];
};

static double now(const struct bench *b)
{
    struct timespec t;
    clock_gettime(b->options->cpu ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values, int count)
{
    qsort(values, (size_t)count, sizeof *values, by_value);
    return 0.5 * (values[(count - 1) / 2] + values[count / 2]);
}

static bool plan_frames(const struct bench *b, int64_t count, struct effect_plan *out)
{
    return drawn_plan(&b->drawn,
                      *effect_params(.effects = EFFECT_ANTIALIAS, .frames = count, .centre = true),
                      out) == WEFT_OK;
}

// ---- time, memory and errors --------------------------------------------------------------------

static void print_row(const struct bench *b, int r, int64_t count, double seconds,
                      const struct weft_accumulator_report *report, bool *good)
{
    const int own = depth_of(&rows[r]) == FLOATS ? EXACT_FLOATS : EXACT_CODES;
    const double error = drawn_compare(&b->drawn, b->picture[r], b->picture[own]).largest;
    const double apart = drawn_compare(&b->drawn, b->picture[r], b->picture[EXACT_FLOATS]).largest;
    // The exact mean that it is compared with is rounded to a float.
    const bool within = error <= report->bound + 0x1p-24;
    printf("| %" PRId64 " | %s | %.4g | %.3g | %d | %.2f | %.3g | %.3g%s | %.3g |\n", count,
           rows[r].label, seconds, (double)count / seconds, report->textures,
           (double)report->bytes * 1e-6, 255.0 * error, 255.0 * report->bound,
           within ? "" : " EXCEEDED", 255.0 * apart);
    *good = *good && within;
}

static bool measure_count(struct bench *b, int64_t count)
{
    const int runs = count > LONG && b->options->runs > LONG_RUNS ? LONG_RUNS : b->options->runs;
    struct weft_accumulator_report report[ROWS];
    struct effect_plan plan;
    bool ok = plan_frames(b, count, &plan), good = true;
    for (int run = 0; run < runs && ok; run++)
        for (int r = 0; r < ROWS && ok; r++) {
            const double start = now(b);
            ok = drawn_average(&b->drawn, &plan, rows[r].params, b->picture[r], &report[r]) ==
                 WEFT_OK;
            b->seconds[r][run] = now(b) - start;
        }
    for (int r = 0; r < ROWS && ok; r++)
        print_row(b, r, count, median(b->seconds[r], runs), &report[r], &good);
    effect_plan_clear(&plan);
    return ok && good;
}

static bool measure_all(struct bench *b)
{
    const struct options *o = b->options;
    struct effect_plan plan;
    printf("| N | method | s | frames/s | textures | MB | error, codes | bound | from floats, "
           "codes |\n|---:|---|---:|---:|---:|---:|---:|---:|---:|\n");
    bool ok = plan_frames(b, PAPER_FRAMES, &plan);
    for (int r = 0; r < ROWS && ok; r++) // warm-up
        ok = drawn_average(&b->drawn, &plan, rows[r].params, b->picture[r], NULL) == WEFT_OK;
    effect_plan_clear(&plan);
    for (int c = 0; c < o->counts && ok; c++)
        ok = measure_count(b, o->count[c]);
    return ok;
}

// ---- 8 frames -----------------------------------------------------------------------------------

static void create_kept(struct bench *b, enum depth depth, int k)
{
    const GladGLContext *gl = &b->gl;
    const int *size = b->options->size;
    gl->GenTextures(1, &b->kept[depth][k].texture);
    gl->BindTexture(GL_TEXTURE_2D, b->kept[depth][k].texture);
    gl->TexImage2D(GL_TEXTURE_2D, 0, depth == FLOATS ? GL_RGBA32F : GL_RGBA8, size[0], size[1], 0,
                   GL_RGBA, GL_UNSIGNED_BYTE, NULL);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    gl->GenFramebuffers(1, &b->kept[depth][k].framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, b->kept[depth][k].framebuffer);
    gl->FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D,
                             b->kept[depth][k].texture, 0);
    gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, b->z);
}

static enum weft_result create_all_kept(void *priv)
{
    struct bench *b = priv;
    if (!scene_gl_load(&b->gl, b->drawn.context))
        return WEFT_ERR_GL;
    b->gl.GenRenderbuffers(1, &b->z);
    b->gl.BindRenderbuffer(GL_RENDERBUFFER, b->z);
    b->gl.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, b->options->size[0],
                              b->options->size[1]);
    for (int depth = 0; depth < DEPTHS; depth++)
        for (int k = 0; k < PAPER_FRAMES; k++)
            create_kept(b, (enum depth)depth, k);
    return WEFT_OK;
}

static enum weft_result destroy_all_kept(void *priv)
{
    struct bench *b = priv;
    for (int depth = 0; depth < DEPTHS; depth++)
        for (int k = 0; k < PAPER_FRAMES; k++) {
            b->gl.DeleteFramebuffers(1, &b->kept[depth][k].framebuffer);
            b->gl.DeleteTextures(1, &b->kept[depth][k].texture);
        }
    b->gl.DeleteRenderbuffers(1, &b->z);
    return WEFT_OK;
}

struct drawing {
    struct bench *bench;
    const struct effect_plan *plan;
    enum depth depth;
};

static enum weft_result draw_all(void *priv)
{
    const struct drawing *d = priv;
    struct bench *b = d->bench;
    enum weft_result res = WEFT_OK;
    for (int k = 0; k < PAPER_FRAMES && res == WEFT_OK; k++) {
        const struct weft_draw_target target = {b->kept[d->depth][k].framebuffer,
                                                b->options->size[0], b->options->size[1]};
        b->gl.BindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
        b->gl.Viewport(0, 0, target.width, target.height);
        b->gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
        res = scene_drawing_draw(b->drawn.drawing[0], &d->plan->frames[k].show, &target);
    }
    b->gl.Finish();
    return res;
}

// The frames that draw_all left, averaged.
static bool average_kept(struct bench *b, const struct row *row)
{
    weft_accumulator *a = NULL;
    struct weft_accumulator_params params = row->params;
    params.width = b->options->size[0];
    params.height = b->options->size[1];
    params.channel_count = DRAWN_CHANNELS;
    params.frame_count = PAPER_FRAMES;
    params.context = b->drawn.context;
    params.log = &drawn_log;
    enum weft_result res = weft_accumulator_create(&params, &a);
    for (int k = 0; k < PAPER_FRAMES && res == WEFT_OK; k++) {
        const struct weft_frame frame = {.texture = b->kept[depth_of(row)][k].texture};
        res = weft_accumulator_add(a, &frame, 1.0);
    }
    for (int c = 0; c < DRAWN_CHANNELS && res == WEFT_OK; c++)
        res = weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, c, b->picture[0], 0);
    weft_accumulator_destroy(&a);
    return res == WEFT_OK;
}

static void print_paper(const char *label, double drawn, double kept)
{
    printf("| %s | %.3g | %.3g |", label, 1.0 / drawn, PAPER_FRAMES / drawn);
    if (kept > 0.0)
        printf(" %.3g | %.3g |\n", 1.0 / kept, PAPER_FRAMES / kept);
    else
        printf(" | |\n");
}

static bool measure_paper(struct bench *b)
{
    static double kept[ROWS][MAX_RUNS], alone[DEPTHS][MAX_RUNS];
    const int runs = b->options->runs;
    struct effect_plan plan;
    bool ok = plan_frames(b, PAPER_FRAMES, &plan) &&
              weft_context_call(b->drawn.context, create_all_kept, b) == WEFT_OK;
    for (int run = -1; run < runs && ok; run++) { // the first one warms up
        const int at = run < 0 ? 0 : run;
        for (int depth = 0; depth < DEPTHS && ok; depth++) {
            struct drawing d = {b, &plan, (enum depth)depth};
            const double start = now(b);
            ok = weft_context_call(b->drawn.context, draw_all, &d) == WEFT_OK;
            alone[depth][at] = now(b) - start;
        }
        for (int r = 0; r < ROWS && ok; r++) {
            const double start = now(b);
            ok = drawn_average(&b->drawn, &plan, rows[r].params, b->picture[r], NULL) == WEFT_OK;
            const double middle = now(b);
            ok = ok && average_kept(b, &rows[r]);
            b->seconds[r][at] = middle - start;
            kept[r][at] = now(b) - middle;
        }
    }
    effect_plan_clear(&plan);
    if (!ok)
        return false;
    printf("| %d frames | pictures/s, drawn | frames/s | pictures/s, from textures | frames/s "
           "|\n|---|---:|---:|---:|---:|\n",
           PAPER_FRAMES);
    print_paper("drawing alone, 8 bits", median(alone[CODES], runs), 0.0);
    print_paper("drawing alone, floats", median(alone[FLOATS], runs), 0.0);
    for (int r = 0; r < ROWS; r++)
        print_paper(rows[r].label, median(b->seconds[r], runs), median(kept[r], runs));
    return weft_context_call(b->drawn.context, destroy_all_kept, b) == WEFT_OK;
}

// ---- set-up -------------------------------------------------------------------------------------

static bool set_up(struct bench *b, weft_context *context)
{
    const int *size = b->options->size;
    bool ok = drawn_create(context, EFFECT_ANTIALIAS, "cube", size, 512, &b->drawn);
    for (int r = 0; r < ROWS && ok; r++) {
        b->picture[r] =
            malloc(DRAWN_CHANNELS * (size_t)size[0] * (size_t)size[1] * sizeof *b->picture[r]);
        ok = b->picture[r] != NULL;
    }
    if (ok)
        printf("anti-aliasing of the cube, %d x %d pixels, medians of %d runs, %s, %s\n\n", size[0],
               size[1], b->options->runs, b->options->cpu ? "processor time" : "wall clock",
               weft_context_get_info(context)->renderer);
    return ok;
}

static bool run(const struct options *options)
{
    enum weft_context_kind kind = WEFT_CONTEXT_AUTO;
    weft_context *context = NULL;
    struct bench *b = calloc(1, sizeof *b);
    bool ok = b && weft_context_kind_parse(&drawn_log, options->context, &kind) == WEFT_OK &&
              weft_context_create(weft_context_params(.kind = kind, .log = &drawn_log), &context) ==
                  WEFT_OK;
    if (ok) {
        b->options = options;
        ok = set_up(b, context) && (options->paper ? measure_paper(b) : measure_all(b));
    }
    for (int r = 0; r < ROWS && b; r++)
        free(b->picture[r]);
    if (b)
        drawn_clear(&b->drawn);
    free(b);
    weft_context_destroy(&context);
    return ok;
}

// ---- options ------------------------------------------------------------------------------------

static bool parse_option(const char *name, const char *value, struct options *o)
{
    int used = 0;
    if (strcmp(name, "--size") == 0)
        return sscanf(value, "%dx%d%n", &o->size[0], &o->size[1], &used) == 2 && !value[used] &&
               o->size[0] >= 1 && o->size[1] >= 1 && o->size[0] <= 8192 && o->size[1] <= 8192;
    if (strcmp(name, "--frames") == 0)
        return (o->counts = parse_counts(value, EFFECT_MAX_FRAMES, o->count)) > 0;
    if (strcmp(name, "--runs") == 0)
        return sscanf(value, "%d%n", &o->runs, &used) == 1 && !value[used] && o->runs >= 1 &&
               o->runs <= MAX_RUNS;
    if (strcmp(name, "--clock") == 0) {
        o->cpu = strcmp(value, "cpu") == 0;
        return o->cpu || strcmp(value, "wall") == 0;
    }
    o->context = value;
    return strcmp(name, "--context") == 0;
}

int main(int argc, char **argv)
{
    struct options options = {
        .size = {512, 512}, .runs = 5, .context = "auto", .count = {8, 64, 1024}, .counts = 3};
    for (int i = 1; i < argc; i++) {
        const bool paper = strcmp(argv[i], "--paper") == 0;
        options.paper |= paper;
        if (!paper && (i + 1 >= argc || !parse_option(argv[i], argv[i + 1], &options))) {
            fprintf(stderr, "usage: bench_effect [--paper] [--size WxH] [--frames N,N,...] "
                            "[--runs N] [--clock wall|cpu] [--context auto|osmesa|egl]\n");
            return 2;
        }
        i += !paper;
    }
    return run(&options) ? 0 : 1;
}
