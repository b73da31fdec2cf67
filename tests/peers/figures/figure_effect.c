// SPDX-License-Identifier: BSD-3-Clause
// How effects converge: the error of a picture over the number of its frames.
//   figure_effect [--size WxH] [--most N] [--reference N] [--context auto|osmesa|egl]
// Default: 64x64, up to 256 frames, references of 2,048 frames. Prints a block for each curve,
// for gnuplot: a line of its name and slope, then lines N, RMS error over R, G and B, largest
// error; blocks are two empty lines apart. Errors are against pictures of many frames that are
// placed in another way (Hammersley's points, another seed). The slope is that of a line through
// log error over log N, by least squares, from 8 frames on. Exit code: 0, 1 (a run failed), 2
// (usage).
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/peers/drawn.h"

enum { MAX_POINTS = 32, FIRST_OF_SLOPE = 8 };

static const struct curve {
    const char *name;
    unsigned effects;
    const char *scene;  // NULL: the effect's own
    const char *jitter; // NULL: by default
} curves[] = {
    {"sobol", EFFECT_ANTIALIAS, NULL, "sobol"},
    {"halton", EFFECT_ANTIALIAS, NULL, "halton"},
    {"r2", EFFECT_ANTIALIAS, NULL, "r2"},
    {"grid", EFFECT_ANTIALIAS, NULL, "grid"},
    {"stratified", EFFECT_ANTIALIAS, NULL, "stratified"},
    {"j2 to j66", EFFECT_ANTIALIAS, NULL, "j"},
    {"antialias", EFFECT_ANTIALIAS, NULL, NULL},
    {"motion-blur", EFFECT_MOTION_BLUR, NULL, NULL},
    {"dof", EFFECT_DOF, NULL, NULL},
    {"soft-shadow", EFFECT_SOFT_SHADOW, NULL, NULL},
    {"antialias+dof+motion-blur", EFFECT_ANTIALIAS | EFFECT_DOF | EFFECT_MOTION_BLUR, "moving",
     NULL},
    {"radiosity", EFFECT_RADIOSITY, NULL, NULL},
};
enum { CURVES = sizeof curves / sizeof *curves };

struct options {
    int size[2];
    int64_t most, reference;
    const char *context;
};

struct point {
    int64_t frames;
    struct drawn_error error;
};

// Of the lights' factors: that of 1/20 of the scene's diagonal, whatever the number of lights. 1 /
// distance^2 by itself has no variance, so that a reference would have spikes of its own; and with
// the clamp of so many lights all pictures would be of other integrals.
static double choose_clamp(const struct scene *scene)
{
    double square = 0.0;
    for (int i = 0; i < 3; i++)
        square += pow(scene->high[i] - scene->low[i], 2.0);
    return 400.0 / square;
}

static enum weft_result average(const struct drawn *drawn, const struct curve *curve,
                                struct effect_params params, float *out)
{
    struct effect_plan plan;
    params.effects = curve->effects;
    params.centre = true;
    params.clamp = choose_clamp(&drawn->scene[0]);
    enum weft_result res = drawn_plan(drawn, params, &plan);
    if (res == WEFT_OK)
        res = drawn_average_exactly(drawn, &plan, out);
    effect_plan_clear(&plan);
    return res;
}

// Numbers of frames and the set that has them: powers of two, or the tables there are.
static int find_counts(const struct options *o, const struct curve *curve, int64_t counts[],
                       const struct weft_jitter_info *sets[])
{
    int count = 0;
    if (curve->jitter && strcmp(curve->jitter, "j") == 0) {
        for (int i = 0; weft_jitter_list[i] && count < MAX_POINTS; i++)
            if (weft_jitter_list[i]->name[0] == 'j') {
                sets[count] = weft_jitter_list[i];
                counts[count++] = weft_jitter_list[i]->counts[0];
            }
        return count;
    }
    for (int64_t n = 1; n <= o->most && count < MAX_POINTS; n *= 2) {
        sets[count] = curve->jitter ? weft_jitter_find(curve->jitter) : NULL;
        counts[count++] = n;
    }
    return count;
}

static double slope_of(const struct point *points, int count)
{
    double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
    for (int i = 0; i < count; i++) {
        if (points[i].frames < FIRST_OF_SLOPE)
            continue;
        const double u = log((double)points[i].frames), v = log(points[i].error.rms);
        n += 1.0;
        x += u;
        y += v;
        xx += u * u;
        xy += u * v;
    }
    return (n * xy - x * y) / (n * xx - x * x);
}

static void print_curve(const struct curve *curve, const struct point *points, int count)
{
    printf("\"%s\" %.3f\n", curve->name, slope_of(points, count));
    for (int i = 0; i < count; i++)
        printf("%lld %.6g %.6g\n", (long long)points[i].frames, points[i].error.rms,
               points[i].error.largest);
    printf("\n\n");
    fflush(stdout);
}

static bool measure(const struct options *o, const struct curve *curve, const struct drawn *drawn,
                    const float *reference, float *picture)
{
    int64_t counts[MAX_POINTS];
    const struct weft_jitter_info *sets[MAX_POINTS];
    struct point points[MAX_POINTS];
    const int count = find_counts(o, curve, counts, sets);
    enum weft_result res = WEFT_OK;
    for (int i = 0; i < count && res == WEFT_OK; i++) {
        res =
            average(drawn, curve, *effect_params(.frames = counts[i], .jitter = sets[i]), picture);
        points[i] = (struct point){counts[i], drawn_compare(drawn, picture, reference)};
    }
    if (res == WEFT_OK)
        print_curve(curve, points, count);
    return res == WEFT_OK;
}

// All curves, the reference kept while the pictures stay the same.
static bool measure_all(const struct options *o, weft_context *context)
{
    const size_t values = DRAWN_CHANNELS * (size_t)o->size[0] * (size_t)o->size[1];
    float *reference = malloc(values * sizeof *reference);
    float *picture = malloc(values * sizeof *picture);
    struct drawn drawn = {0};
    bool ok = reference && picture;
    for (int c = 0; c < CURVES && ok; c++) {
        const struct curve *curve = &curves[c];
        const bool same = c && curve->effects == curves[c - 1].effects;
        if (!same) {
            drawn_clear(&drawn);
            ok = drawn_create(context, curve->effects, curve->scene, o->size, 512, &drawn);
            const bool places = curve->effects != EFFECT_MOTION_BLUR;
            ok = ok &&
                 average(&drawn, curve,
                         *effect_params(.frames = o->reference, .seed = 1,
                                        .jitter = places ? weft_jitter_find("hammersley") : NULL),
                         reference) == WEFT_OK;
        }
        ok = ok && measure(o, curve, &drawn, reference, picture);
    }
    drawn_clear(&drawn);
    free(reference);
    free(picture);
    return ok;
}

static bool parse_option(const char *name, const char *value, struct options *o)
{
    int used = 0;
    if (strcmp(name, "--size") == 0)
        return sscanf(value, "%dx%d%n", &o->size[0], &o->size[1], &used) == 2 && !value[used] &&
               o->size[0] >= 1 && o->size[1] >= 1 && o->size[0] <= 4096 && o->size[1] <= 4096;
    if (strcmp(name, "--most") == 0 || strcmp(name, "--reference") == 0) {
        long long n = 0;
        const bool good = sscanf(value, "%lld%n", &n, &used) == 1 && !value[used] &&
                          n >= 2 * FIRST_OF_SLOPE && n <= EFFECT_MAX_FRAMES;
        *(name[2] == 'm' ? &o->most : &o->reference) = n;
        return good;
    }
    o->context = value;
    return strcmp(name, "--context") == 0;
}

int main(int argc, char **argv)
{
    struct options o = {{64, 64}, 256, 2048, "auto"};
    for (int i = 1; i < argc; i += 2)
        if (i + 1 >= argc || !parse_option(argv[i], argv[i + 1], &o)) {
            fprintf(stderr, "usage: figure_effect [--size WxH] [--most N] [--reference N] "
                            "[--context auto|osmesa|egl]\n");
            return 2;
        }
    enum weft_context_kind kind = WEFT_CONTEXT_AUTO;
    weft_context *context = NULL;
    const bool ok = weft_context_kind_parse(&drawn_log, o.context, &kind) == WEFT_OK &&
                    weft_context_create(weft_context_params(.kind = kind, .log = &drawn_log),
                                        &context) == WEFT_OK &&
                    measure_all(&o, context);
    weft_context_destroy(&context);
    return ok ? 0 : 1;
}
