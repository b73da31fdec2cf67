// SPDX-License-Identifier: BSD-3-Clause
// What accumulating frames costs: table 1 of Lagae, Suykens, Dutre, "A Hardware Accelerated
// Alternative for the Accumulation Buffer" (report CW 369, 2003) on the machine at hand.
//   bench_accumulate [--size WxH] [--frames N,N,...] [--runs N] [--source drawn|textures|memory]
//                    [--clock wall|cpu] [--context auto|osmesa|egl]
// Default: 512x512, 2 to 1,024 frames in powers of two, 5 runs, frames that are drawn, wall clock.
// On a software GL and a machine that others use as well, the processor time of all threads says
// more.
//
// A run is one accumulated image: an accumulator is created, N frames are added, the mean of all
// four channels is read as floats, the accumulator is destroyed. Frames are 8-bit RGBA: the RGB
// colour cube, turned from frame to frame; drawn for each frame, or four of them that lie in
// textures or in memory. Beside the methods stand the frames alone ("drawing": no accumulation, the
// last one read back) and a pass that copies each of them ("copy"). All methods run in turns, so
// that what slows the machine down slows all of them.
//   images/s   of a run's median, as the paper counts
//   ms/frame   slope of a line through the medians over N, fitted by least squares of relative
//              deviations, and what the line has at N = 0; `off`: the largest deviation from it
//   over       ms/frame without what the frames alone cost, and that as a multiple of blending's
//              and of a copy's
// Exit code: 0, 1 (a run failed), 2 (usage).
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "passes/gl/program.h"
#include "tests/peers/counts.h"
#include "tests/peers/cube.h"

enum { MAX_RUNS = 99, FRAMES_KEPT = 4, CHANNELS = 4 };

enum source { SOURCE_DRAWN, SOURCE_TEXTURES, SOURCE_MEMORY };
static const char *const source_names[] = {"drawn", "textures", "memory"};

// What is timed: frames alone, copied, or accumulated.
enum kind { KIND_FRAMES, KIND_COPY, KIND_METHOD };

static const struct row {
    const char *label;
    enum kind kind;
    struct weft_accumulator_params params;
} rows[] = {
    {"drawing", KIND_FRAMES, {0}},
    {"copy", KIND_COPY, {0}},
    {"buffer", KIND_METHOD, {.method = WEFT_ACCUMULATE_BUFFER}},
    {"blend 8", KIND_METHOD, {.method = WEFT_ACCUMULATE_BLEND}},
    {"tree 2", KIND_METHOD, {.method = WEFT_ACCUMULATE_TREE, .branching = 2}},
    {"tree 4", KIND_METHOD, {.method = WEFT_ACCUMULATE_TREE, .branching = 4}},
    {"tree 8", KIND_METHOD, {.method = WEFT_ACCUMULATE_TREE, .branching = 8}},
    {"float", KIND_METHOD, {.method = WEFT_ACCUMULATE_FLOAT}},
    {"exact", KIND_METHOD, {.method = WEFT_ACCUMULATE_EXACT}},
};
enum { ROWS = sizeof rows / sizeof *rows, ROW_FRAMES = 0, ROW_COPY = 1, ROW_BLEND = 3 };

struct options {
    int width, height, runs;
    int64_t count[MAX_COUNTS];
    int counts;
    enum source source;
    const char *context;
    bool cpu; // processor time
};

struct bench {
    const struct options *options;
    struct cube cube;
    struct cube_target target, kept[FRAMES_KEPT], copy;
    GLuint copy_program;
    uint8_t *codes[FRAMES_KEPT]; // of the kept ones
    float *pixels;
    double seconds[ROWS][MAX_COUNTS][MAX_RUNS];
    double median[ROWS][MAX_COUNTS];
};

static const char copy_shader[] = "uniform sampler2D frame;\n"
                                  "out vec4 value;\n"
                                  "void main()\n"
                                  "{\n"
                                  "    value = texelFetch(frame, ivec2(gl_FragCoord.xy), 0);\n"
                                  "}\n";

static double now(const struct options *o)
{
    struct timespec t;
    clock_gettime(o->cpu ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

// ---- runs ---------------------------------------------------------------------------------------

static void draw_copy(struct bench *b, GLuint texture)
{
    const GladGLContext *gl = b->cube.gl;
    weft_gl_target_bind(gl, &b->copy.colour, b->options->width, b->options->height);
    gl->UseProgram(b->copy_program);
    weft_gl_bind_texture(gl, b->copy_program, 0, "frame", GL_TEXTURE_2D, texture);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
}

// Frames, and copies of them, without an accumulator; the last one is read back.
static bool run_frames(struct bench *b, int64_t count, bool copy)
{
    const struct options *o = b->options;
    const GladGLContext *gl = b->cube.gl;
    if (weft_context_enter(b->cube.context) != WEFT_OK)
        return false;
    for (int64_t i = 0; i < count; i++) {
        const struct cube_target *frame =
            o->source == SOURCE_DRAWN ? &b->target : &b->kept[i % FRAMES_KEPT];
        if (o->source == SOURCE_DRAWN)
            cube_target_draw(&b->cube, &b->target, i);
        if (copy)
            draw_copy(b, frame->colour.texture);
    }
    const struct weft_gl_pixels out = {
        .width = o->width, .height = o->height, .type = GL_UNSIGNED_BYTE, .data = b->pixels};
    const bool ok =
        weft_gl_target_read(NULL, gl, copy ? &b->copy.colour : &b->target.colour, &out) == WEFT_OK;
    gl->Finish();
    weft_context_leave(b->cube.context);
    return ok;
}

static enum weft_result add_frame(struct bench *b, weft_accumulator *a, int64_t index)
{
    const int kept = (int)(index % FRAMES_KEPT);
    struct weft_frame frame = {0};
    struct weft_plane planes[CHANNELS];
    for (int c = 0; c < CHANNELS; c++)
        planes[c] = (struct weft_plane){
            .values = b->codes[kept] + c, .type = WEFT_PLANE_UNORM8, .step = CHANNELS};
    if (b->options->source == SOURCE_DRAWN)
        frame = (struct weft_frame){.draw = cube_draw, .priv = &b->cube};
    else if (b->options->source == SOURCE_TEXTURES)
        frame.texture = b->kept[kept].colour.texture;
    else
        frame.plane = planes;
    return weft_accumulator_add(a, &frame, 1.0);
}

static void say(void *priv, enum weft_log_level level, const char *message)
{
    (void)priv;
    if (level <= WEFT_LOG_WARNING)
        fprintf(stderr, "%s\n", message);
}

static bool run_method(struct bench *b, const struct row *row, int64_t count)
{
    static const struct weft_log log = {.write = say};
    const struct options *o = b->options;
    weft_accumulator *a = NULL;
    struct weft_accumulator_params params = row->params;
    params.width = o->width;
    params.height = o->height;
    params.channel_count = CHANNELS;
    params.frame_bits = 8;
    params.frame_count = count;
    params.context = b->cube.context;
    params.log = &log;
    enum weft_result res = weft_accumulator_create(&params, &a);
    for (int64_t i = 0; i < count && res == WEFT_OK; i++)
        res = add_frame(b, a, i);
    for (int c = 0; c < CHANNELS && res == WEFT_OK; c++)
        res = weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, c, b->pixels, 0);
    weft_accumulator_destroy(&a);
    return res == WEFT_OK;
}

static bool run_row(struct bench *b, int r, int64_t count, double *seconds)
{
    const struct row *row = &rows[r];
    const double start = now(b->options);
    const bool ok = row->kind == KIND_METHOD ? run_method(b, row, count)
                                             : run_frames(b, count, row->kind == KIND_COPY);
    *seconds = now(b->options) - start;
    if (!ok)
        fprintf(stderr, "bench_accumulate: %s of %" PRId64 " frames failed\n", row->label, count);
    return ok;
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

static bool measure(struct bench *b)
{
    const struct options *o = b->options;
    double warm_up;
    bool ok = true;
    for (int r = 0; r < ROWS && ok; r++)
        ok = run_row(b, r, 8, &warm_up);
    for (int c = 0; c < o->counts && ok; c++) {
        for (int run = 0; run < o->runs && ok; run++)
            for (int r = 0; r < ROWS && ok; r++)
                ok = run_row(b, r, o->count[c], &b->seconds[r][c][run]);
        for (int r = 0; r < ROWS && ok; r++)
            b->median[r][c] = median(b->seconds[r][c], o->runs);
    }
    return ok;
}

// ---- results ------------------------------------------------------------------------------------

struct line {
    double start, slope, off; // seconds, seconds a frame, largest relative deviation
};

// Weights 1 / seconds^2, so that small N count as much as large ones.
static struct line fit(const struct options *o, const double *seconds)
{
    double s = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
    for (int c = 0; c < o->counts; c++) {
        const double w = 1.0 / (seconds[c] * seconds[c]), n = (double)o->count[c];
        s += w;
        x += w * n;
        y += w * seconds[c];
        xx += w * n * n;
        xy += w * n * seconds[c];
    }
    struct line line = {.slope = seconds[0] / (double)o->count[0]};
    if (o->counts > 1) {
        line.slope = (s * xy - x * y) / (s * xx - x * x);
        line.start = (y - line.slope * x) / s;
    }
    for (int c = 0; c < o->counts; c++)
        line.off = fmax(line.off,
                        fabs((line.start + line.slope * (double)o->count[c]) / seconds[c] - 1.0));
    return line;
}

static void print_images(const struct bench *b)
{
    const struct options *o = b->options;
    printf("\nimages/s\n\n| N |");
    for (int r = 0; r < ROWS; r++)
        printf(" %s |", rows[r].label);
    printf("\n|---|");
    for (int r = 0; r < ROWS; r++)
        printf("---|");
    for (int c = 0; c < o->counts; c++) {
        printf("\n| %" PRId64 " |", o->count[c]);
        for (int r = 0; r < ROWS; r++)
            printf(" %.3g |", 1.0 / b->median[r][c]);
    }
    printf("\n");
}

static void print_lines(const struct bench *b)
{
    struct line line[ROWS];
    for (int r = 0; r < ROWS; r++)
        line[r] = fit(b->options, b->median[r]);
    const double frames = line[ROW_FRAMES].slope;
    const double blend = line[ROW_BLEND].slope - frames, copy = line[ROW_COPY].slope - frames;
    printf("\n| | ms/frame | at N = 0, ms | off, %% | over, ms | / blend 8 | / copy |\n"
           "|---|---|---|---|---|---|---|\n");
    for (int r = 0; r < ROWS; r++) {
        const double over = line[r].slope - frames;
        printf("| %s | %.3f | %.2f | %.0f | %.3f | %.2f | %.2f |\n", rows[r].label,
               1e3 * line[r].slope, 1e3 * line[r].start, 100.0 * line[r].off, 1e3 * over,
               over / blend, over / copy);
    }
}

static void print(const struct bench *b)
{
    const struct options *o = b->options;
    printf("%d x %d pixels, RGBA8, frames: %s; medians of %d runs, %s; %s\n", o->width, o->height,
           source_names[o->source], o->runs, o->cpu ? "processor time" : "wall clock",
           weft_context_get_info(b->cube.context)->renderer);
    print_images(b);
    print_lines(b);
}

// ---- set-up -------------------------------------------------------------------------------------

static bool keep_frames(struct bench *b)
{
    const struct options *o = b->options;
    bool ok = true;
    for (int i = 0; i < FRAMES_KEPT && ok; i++) {
        b->codes[i] = malloc((size_t)o->width * (size_t)o->height * CHANNELS);
        ok = b->codes[i] && cube_target_create(&b->cube, o->width, o->height, &b->kept[i]);
        if (!ok)
            break;
        cube_target_draw(&b->cube, &b->kept[i], 50 * i);
        const struct weft_gl_pixels out = {
            .width = o->width, .height = o->height, .type = GL_UNSIGNED_BYTE, .data = b->codes[i]};
        ok = weft_gl_target_read(NULL, b->cube.gl, &b->kept[i].colour, &out) == WEFT_OK;
    }
    return ok;
}

static bool set_up(struct bench *b, weft_context *context)
{
    const struct options *o = b->options;
    b->pixels = malloc((size_t)o->width * (size_t)o->height * sizeof *b->pixels);
    if (!b->pixels || !cube_create(context, true, &b->cube) ||
        weft_context_enter(context) != WEFT_OK)
        return false;
    bool ok = weft_program_get(context, "copy", "", weft_shader_full_target, copy_shader,
                               &b->copy_program) == WEFT_OK;
    if (ok)
        weft_program_hold(context, b->copy_program);
    ok = ok && cube_target_create(&b->cube, o->width, o->height, &b->target) &&
         cube_target_create(&b->cube, o->width, o->height, &b->copy) && keep_frames(b);
    weft_context_leave(context);
    return ok;
}

static void clear(struct bench *b)
{
    if (b->cube.context && weft_context_enter(b->cube.context) == WEFT_OK) {
        cube_target_destroy(&b->cube, &b->target);
        cube_target_destroy(&b->cube, &b->copy);
        for (int i = 0; i < FRAMES_KEPT; i++)
            cube_target_destroy(&b->cube, &b->kept[i]);
        weft_context_leave(b->cube.context);
    }
    for (int i = 0; i < FRAMES_KEPT; i++)
        free(b->codes[i]);
    free(b->pixels);
}

static bool run(const struct options *options)
{
    static const struct weft_log log = {.write = say};
    enum weft_context_kind kind = WEFT_CONTEXT_AUTO;
    weft_context *context = NULL;
    struct bench *b = calloc(1, sizeof *b);
    bool ok =
        b && weft_context_kind_parse(&log, options->context, &kind) == WEFT_OK &&
        weft_context_create(weft_context_params(.kind = kind, .log = &log), &context) == WEFT_OK;
    if (ok) {
        b->options = options;
        ok = set_up(b, context) && measure(b);
    }
    if (ok)
        print(b);
    if (b)
        clear(b);
    free(b);
    weft_context_destroy(&context);
    return ok;
}

// ---- options ------------------------------------------------------------------------------------

static bool parse_option(const char *name, const char *value, struct options *o)
{
    int used = 0;
    if (strcmp(name, "--size") == 0)
        return sscanf(value, "%dx%d%n", &o->width, &o->height, &used) == 2 && !value[used] &&
               o->width >= 1 && o->height >= 1 && o->width <= 8192 && o->height <= 8192;
    if (strcmp(name, "--frames") == 0)
        return (o->counts = parse_counts(value, WEFT_ACCUMULATE_MAX_FRAMES, o->count)) > 0;
    if (strcmp(name, "--runs") == 0)
        return sscanf(value, "%d%n", &o->runs, &used) == 1 && !value[used] && o->runs >= 1 &&
               o->runs <= MAX_RUNS;
    if (strcmp(name, "--context") == 0) {
        o->context = value;
        return true;
    }
    if (strcmp(name, "--clock") == 0) {
        o->cpu = strcmp(value, "cpu") == 0;
        return o->cpu || strcmp(value, "wall") == 0;
    }
    for (int s = 0; s < 3 && strcmp(name, "--source") == 0; s++) {
        if (strcmp(value, source_names[s]) == 0) {
            o->source = (enum source)s;
            return true;
        }
    }
    return false;
}

int main(int argc, char **argv)
{
    struct options options = {.width = 512, .height = 512, .runs = 5, .context = "auto"};
    for (int64_t n = 2; n <= 1024; n *= 2)
        options.count[options.counts++] = n;
    for (int i = 1; i < argc; i += 2) {
        if (i + 1 >= argc || !parse_option(argv[i], argv[i + 1], &options)) {
            fprintf(stderr,
                    "usage: bench_accumulate [--size WxH] [--frames N,N,...] [--runs N]\n"
                    "                        [--source drawn|textures|memory] [--clock wall|cpu]\n"
                    "                        [--context auto|osmesa|egl]\n");
            return 2;
        }
    }
    return run(&options) ? 0 : 1;
}
