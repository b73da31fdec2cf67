// SPDX-License-Identifier: BSD-3-Clause
// Cases of averages of frames: in targets of few bits, past what counters hold, of what must not be
// averaged. Both ways run through accumulators, on GL where there is a context, else emulated.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "filter/check.h"
#include "passes/accumulate/accumulate.h"
#include "passes/accumulate/buffer.h"
#include "passes/stability/cases.h"

// ---- frames -------------------------------------------------------------------------------------

enum { WIDTH = 64 };

static int pixels_of(const struct weft_stability_frames *f)
{
    return f->width * f->height;
}

static double one_of(enum weft_plane_type type)
{
    return type == WEFT_PLANE_UNORM8 ? 255.0 : type == WEFT_PLANE_UNORM16 ? 65535.0 : 1.0;
}

static void store(void *values, size_t at, enum weft_plane_type type, double value)
{
    if (type == WEFT_PLANE_UNORM8)
        ((uint8_t *)values)[at] = (uint8_t)value;
    else if (type == WEFT_PLANE_UNORM16)
        ((uint16_t *)values)[at] = (uint16_t)value;
    else
        ((float *)values)[at] = (float)value;
}

// As stored: codes, or values.
static double load(const struct weft_stability_frames *f, int frame, int pixel)
{
    const size_t at = (size_t)frame * (size_t)pixels_of(f) + (size_t)pixel;
    return f->type == WEFT_PLANE_UNORM8    ? ((const uint8_t *)f->values)[at]
           : f->type == WEFT_PLANE_UNORM16 ? ((const uint16_t *)f->values)[at]
                                           : (double)((const float *)f->values)[at];
}

// To be freed in any case.
static enum weft_result create_frames(struct weft_stability_frames *f, int count, int height,
                                      enum weft_plane_type type,
                                      double (*value)(int frame, int pixel))
{
    *f = (struct weft_stability_frames){count, WIDTH, height, type, NULL};
    f->values = malloc((size_t)count * (size_t)pixels_of(f) * weft_plane_type_size(type));
    if (!f->values)
        return WEFT_ERR_MEMORY;
    for (int i = 0; i < count; i++)
        for (int p = 0; p < pixels_of(f); p++)
            store(f->values, (size_t)i * (size_t)pixels_of(f) + (size_t)p, type, value(i, p));
    return WEFT_OK;
}

// Of results against exact means, in frames' units: codes, or values. As sums of codes are.
struct errors {
    double largest, mean; // the mean has a sign
};

static struct errors compare(const struct weft_stability_frames *f, const float *out)
{
    struct errors e = {0};
    const int pixels = pixels_of(f);
    for (int p = 0; p < pixels; p++) {
        double sum = 0.0;
        for (int i = 0; i < f->count; i++)
            sum += load(f, i, p);
        const double error = (double)out[p] * one_of(f->type) - sum / f->count;
        e.largest = fmax(e.largest, fabs(error));
        e.mean += error / pixels;
    }
    return e;
}

// Two methods on the same frames, by their largest errors, in codes.
static enum weft_result measure_both(const struct weft_stability_params *params,
                                     const struct weft_stability_frames *f,
                                     const struct weft_accumulator_params *naive,
                                     const struct weft_accumulator_params *ours,
                                     struct weft_stability_result *result)
{
    float out[WIDTH];
    struct weft_accumulator_report report = {0};
    enum weft_result res = weft_stability_accumulate(params, f, *naive, 1.0, out, NULL);
    if (res == WEFT_OK) {
        result->naive = compare(f, out).largest;
        res = weft_stability_accumulate(params, f, *ours, 1.0, out, &report);
    }
    if (res == WEFT_OK)
        result->ours = compare(f, out).largest;
    // Of a tree: half a code for every node above a leaf, and a rounding to a float.
    result->limit = report.bound * one_of(f->type);
    return res;
}

// ---- few bits -----------------------------------------------------------------------------------

// A level for every pixel, and noise.
static double noisy_code(int frame, int pixel)
{
    return 8 + (239 * pixel) / (WIDTH - 1) + (int)(8.0f * weft_stability_noise(frame, pixel, 0));
}

static enum weft_result measure_blend_8(const struct weft_stability_params *params,
                                        struct weft_stability_result *result)
{
    struct weft_stability_frames f;
    enum weft_result res = create_frames(&f, 256, 1, WEFT_PLANE_UNORM8, noisy_code);
    if (res == WEFT_OK)
        res = measure_both(
            params, &f,
            weft_accumulator_params(.method = WEFT_ACCUMULATE_BLEND, .frame_count = f.count),
            weft_accumulator_params(.method = WEFT_ACCUMULATE_TREE,
                                    .branching = WEFT_TREE_MAX_INPUTS),
            result);
    free(f.values);
    weft_stability_say(result, "LSB",
                       "256 frames: blending is off by up to %.0f codes, the tree by %.2f",
                       result->naive, result->ours);
    return res;
}

const struct weft_stability_case weft_stability_blend_8 = {
    .name = "blend-8",
    .failure = "256 frames averaged on 8 bits",
    .naive = "blending, each frame times 1/256",
    .ours = "an accumulation tree of 16 inputs a node",
    .source = "Lagae, Suykens and Dutre, report CW 369, 2003, section 2",
    .measure = measure_blend_8,
};

// Light that fades in: what counts comes late.
static double fading_code(int frame, int pixel)
{
    return frame * 255 / 999 * (pixel + 1) / WIDTH;
}

static enum weft_result measure_mean_8(const struct weft_stability_params *params,
                                       struct weft_stability_result *result)
{
    struct weft_stability_frames f;
    enum weft_result res = create_frames(&f, 1000, 1, WEFT_PLANE_UNORM8, fading_code);
    if (res == WEFT_OK) // how many frames come is not said, so that frame k is mixed in by 1 / k
        res = measure_both(params, &f, weft_accumulator_params(.method = WEFT_ACCUMULATE_BLEND),
                           weft_accumulator_params(.method = WEFT_ACCUMULATE_TREE,
                                                   .branching = WEFT_TREE_MAX_INPUTS),
                           result);
    free(f.values);
    weft_stability_say(result, "LSB",
                       "1000 frames that fade in: the running mean is off by up to "
                       "%.0f codes, the tree by %.2f",
                       result->naive, result->ours);
    return res;
}

const struct weft_stability_case weft_stability_mean_8 = {
    .name = "mean-8",
    .failure = "1000 frames averaged on 8 bits: late frames change nothing",
    .naive = "a running mean, frame k mixed in by 1/k",
    .ours = "an accumulation tree of 16 inputs a node",
    .source = "Lagae, Suykens and Dutre, report CW 369, 2003, section 2",
    .measure = measure_mean_8,
};

// A level for every pixel, and noise, on 16 bits.
static double noisy_code_16(int frame, int pixel)
{
    return 4096 + (57344 * pixel) / (WIDTH - 1) +
           (int)(4095.0f * weft_stability_noise(frame, pixel, 0));
}

// Errors as fractions of 1.0.
static enum weft_result measure_half_sum(const struct weft_stability_params *params,
                                         struct weft_stability_result *result)
{
    struct weft_stability_frames f;
    enum weft_result res = create_frames(&f, 100, 1, WEFT_PLANE_UNORM16, noisy_code_16);
    if (res == WEFT_OK)
        res = measure_both(params, &f,
                           weft_accumulator_params(.method = WEFT_ACCUMULATE_BLEND,
                                                   .bits = WEFT_ACCUMULATE_HALF,
                                                   .frame_count = f.count),
                           weft_accumulator_params(.method = WEFT_ACCUMULATE_TREE, .bits = 16,
                                                   .branching = WEFT_TREE_MAX_INPUTS),
                           result);
    free(f.values);
    result->naive /= 65535.0;
    result->ours /= 65535.0;
    result->limit /= 65535.0;
    weft_stability_say(result, "relative",
                       "100 frames of noise: half floats are off by up to %.2f %%",
                       100.0 * result->naive);
    return res;
}

const struct weft_stability_case weft_stability_half_sum = {
    .name = "half-sum",
    .failure = "100 frames averaged in half floats: sums drift",
    .naive = "blending into a half-float target, each frame times 0.01",
    .ours = "an accumulation tree on codes of 16 bits",
    .source = "Mesa 22.3, lp_bld_conv.c: stores to half floats truncate",
    .measure = measure_half_sum,
};

// What Mesa's accumulation buffer does: every product is cut off.
static enum weft_result run_buffer(const struct weft_stability_params *params,
                                   const struct weft_stability_frames *f, float *out)
{
    weft_accum_buffer *b = NULL;
    enum weft_result res = weft_accum_buffer_create(
        weft_accum_buffer_params(.width = WIDTH, .height = f->height, .channel_count = 1,
                                 .rounding = WEFT_ACCUM_TRUNCATE, .log = params->log),
        &b);
    for (int i = 0; i < f->count && res == WEFT_OK; i++) {
        const struct weft_plane plane = weft_stability_frame(f, i);
        res = weft_accum_buffer_accum(b, &plane, 1.0 / f->count);
    }
    if (res == WEFT_OK)
        res = weft_accum_buffer_return(b, 1.0, 0, out, 0);
    weft_accum_buffer_destroy(&b);
    return res;
}

static enum weft_result measure_buffer_16(const struct weft_stability_params *params,
                                          struct weft_stability_result *result)
{
    float out[WIDTH];
    struct weft_accumulator_report report = {0};
    struct weft_stability_frames f;
    enum weft_result res = create_frames(&f, 1024, 1, WEFT_PLANE_UNORM8, noisy_code);
    if (res == WEFT_OK)
        res = run_buffer(params, &f, out);
    if (res == WEFT_OK) {
        result->naive = compare(&f, out).largest;
        res = weft_stability_accumulate(params, &f,
                                        *weft_accumulator_params(.method = WEFT_ACCUMULATE_TREE),
                                        1.0, out, &report);
    }
    if (res == WEFT_OK)
        result->ours = compare(&f, out).largest;
    result->limit = 255.0 * report.bound; // half a code for each of 5 levels
    free(f.values);
    weft_stability_say(result, "LSB",
                       "1024 frames: a buffer of 16 bits loses up to %.1f codes, the tree of 8 "
                       "bits is off by %.2f",
                       result->naive, result->ours);
    return res;
}

const struct weft_stability_case weft_stability_buffer_16 = {
    .name = "buffer-16",
    .failure = "1024 frames in an accumulation buffer of 16 bits that truncates",
    .naive = "glAccum as Mesa has it, each frame times 1/1024",
    .ours = "an accumulation tree on 8 bits, of 4 inputs a node",
    .source = "Mesa 22.3, main/accum.c",
    .measure = measure_buffer_16,
};

// ---- roundings that lean ------------------------------------------------------------------------

static double noise_code(int frame, int pixel)
{
    return floor(128.0 + 100.0 * (double)weft_stability_noise(frame, pixel, 1));
}

// By the mean error, with its sign, of many pixels: what is left of it when one averages on.
static enum weft_result measure_tree_bias(const struct weft_stability_params *params,
                                          struct weft_stability_result *result)
{
    enum { FRAMES = 256, HEIGHT = 128, BRANCHING = 2 };
    float *out = malloc(WIDTH * HEIGHT * sizeof *out);
    struct weft_accumulator_report report = {0};
    struct weft_accumulator_params how = {.method = WEFT_ACCUMULATE_TREE, .branching = BRANCHING};
    struct weft_stability_frames f;
    enum weft_result res = create_frames(&f, FRAMES, HEIGHT, WEFT_PLANE_UNORM8, noise_code);
    if (res == WEFT_OK && !out)
        res = WEFT_ERR_MEMORY;
    if (res == WEFT_OK)
        res = weft_stability_accumulate(params, &f, how, 1.0, out, &report);
    if (res == WEFT_OK)
        result->naive = fabs(compare(&f, out).mean);
    const double predicted = 255.0 * report.bias;
    how.rounding = WEFT_TREE_UNBIASED;
    if (res == WEFT_OK)
        res = weft_stability_accumulate(params, &f, how, 1.0, out, &report);
    if (res == WEFT_OK)
        result->ours = fabs(compare(&f, out).mean);
    // As many nodes of a level round up as down, but for the root, which is alone: half a code in
    // one of b cases. Pixels are independent, each within the tree's bound: by Hoeffding's
    // inequality their mean is farther off than this less than once in 10^5 times.
    result->limit = 0.5 / BRANCHING + 5.0 * 255.0 * report.bound / sqrt(WIDTH * HEIGHT);
    free(f.values);
    free(out);
    weft_stability_say(result, "LSB, mean",
                       "256 frames of noise come out %.2f codes too bright (%.2f follow from the "
                       "roundings), unbiased %.2f",
                       result->naive, predicted, result->ours);
    return res;
}

const struct weft_stability_case weft_stability_tree_bias = {
    .name = "tree-bias",
    .failure = "averages rounded to nearest at every node: halves always go up",
    .naive = "a binary tree of 8 levels, halves up",
    .ours = "the same tree, halves up at every other node and down between",
    .measure = measure_tree_bias,
};

// ---- counters that stop -------------------------------------------------------------------------

// A light that is switched on when half of the samples are taken.
enum { LOG_SAMPLES = 25, LOG_FRAMES = 10 };

static double late_light(int frame, int pixel)
{
    (void)pixel;
    return frame < 1 << (LOG_FRAMES - 1) ? 0.75 : 1.0;
}

static float running_mean(void)
{
    float mean = 0.0f, count = 0.0f;
    for (int i = 0; i < 1 << LOG_SAMPLES; i++) {
        count += 1.0f;
        mean += ((float)late_light(i >> (LOG_SAMPLES - LOG_FRAMES), 0) - mean) / count;
    }
    return mean;
}

static enum weft_result measure_float_mean(const struct weft_stability_params *params,
                                           struct weft_stability_result *result)
{
    float out[WIDTH];
    struct weft_accumulator_report report = {0};
    struct weft_stability_frames f;
    enum weft_result res = create_frames(&f, 1 << LOG_FRAMES, 1, WEFT_PLANE_FLOAT, late_light);
    if (res == WEFT_OK) // each frame stands for as many samples as it is made of
        res = weft_stability_accumulate(params, &f,
                                        *weft_accumulator_params(.method = WEFT_ACCUMULATE_EXACT),
                                        1 << (LOG_SAMPLES - LOG_FRAMES), out, &report);
    if (res == WEFT_OK) {
        result->naive = fabs((double)running_mean() - 0.875);
        result->ours = compare(&f, out).largest;
        result->limit = report.bound;
    }
    free(f.values);
    weft_stability_say(
        result, "of 1.0",
        "2^25 samples, light from 2^24 on: the running mean stays where it was, %.3g "
        "too low",
        result->naive);
    return res;
}

const struct weft_stability_case weft_stability_float_mean = {
    .name = "float-mean",
    .failure = "a running mean past 2^24 samples: neither it nor its counter moves",
    .naive = "mean += (sample - mean) / count, in single precision",
    .ours = "exact sums, with numbers of samples as weights",
    .source = "IEEE 754: 2^24 + 1 is no float",
    .measure = measure_float_mean,
};

// ---- what must not be averaged ------------------------------------------------------------------

// IEC 61966-2-1, codes as fractions of 255.
static double srgb_to_linear(double v)
{
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

static double linear_to_srgb(double v)
{
    return v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1.0 / 2.4) - 0.055;
}

// An edge between black and grey that moves over the picture while the shutter is open.
static double edge_code(int frame, int pixel)
{
    return pixel < frame ? 240.0 : 4.0;
}

static double edge_light(int frame, int pixel)
{
    return srgb_to_linear(edge_code(frame, pixel) / 255.0);
}

// Codes that a screen is to show, against those of the light that came in, in double precision.
static double edge_error(const float *out, bool linear)
{
    double largest = 0.0;
    for (int p = 0; p < WIDTH; p++) {
        double light = 0.0;
        for (int i = 0; i < WIDTH; i++)
            light += edge_light(i, p) / WIDTH;
        const double code = linear ? linear_to_srgb((double)out[p]) : (double)out[p];
        largest = fmax(largest, 255.0 * fabs(code - linear_to_srgb(light)));
    }
    return largest;
}

static enum weft_result measure_srgb_mean(const struct weft_stability_params *params,
                                          struct weft_stability_result *result)
{
    const struct weft_accumulator_params how = {.method = WEFT_ACCUMULATE_EXACT};
    float out[WIDTH];
    struct weft_accumulator_report report = {0};
    struct weft_stability_frames codes = {0}, light = {0};
    enum weft_result res = create_frames(&codes, WIDTH, 1, WEFT_PLANE_UNORM8, edge_code);
    if (res == WEFT_OK)
        res = create_frames(&light, WIDTH, 1, WEFT_PLANE_FLOAT, edge_light);
    if (res == WEFT_OK)
        res = weft_stability_accumulate(params, &codes, how, 1.0, out, NULL);
    result->naive = res == WEFT_OK ? edge_error(out, false) : 0.0;
    if (res == WEFT_OK)
        res = weft_stability_accumulate(params, &light, how, 1.0, out, &report);
    result->ours = res == WEFT_OK ? edge_error(out, true) : 0.0;
    // The light is rounded to floats, and its mean; sRGB is steepest at 0. The reference's own
    // roundings are doubles'.
    result->limit = 255.0 * 12.92 * (0x1p-25 + report.bound);
    free(codes.values);
    free(light.values);
    weft_stability_say(result, "LSB",
                       "an edge moves over a pixel: the mean of codes is up to %.0f codes too dark",
                       result->naive);
    return res;
}

const struct weft_stability_case weft_stability_srgb_mean = {
    .name = "srgb-mean",
    .failure = "averages of sRGB codes: blurred motion is too dark",
    .naive = "codes averaged as they are, exactly",
    .ours = "codes to light, which is averaged, and back",
    .source = "IEC 61966-2-1",
    .measure = measure_srgb_mean,
};

// Three objects, two of which meet at every pixel as their edge moves.
enum { OBJECTS = 3 };
static const double object_id[OBJECTS] = {3.0, 7.0, 12.0};

static int object_at(int frame, int pixel)
{
    return (2 * pixel + frame) / WIDTH % OBJECTS;
}

static double id_at(int frame, int pixel)
{
    return object_id[object_at(frame, pixel)];
}

#define COVERAGE(k)                                                                                \
    static double coverage_##k(int frame, int pixel)                                               \
    {                                                                                              \
        return object_at(frame, pixel) == (k);                                                     \
    }
COVERAGE(0)
COVERAGE(1)
COVERAGE(2)
static double (*const coverage[OBJECTS])(int, int) = {coverage_0, coverage_1, coverage_2};

// Pixels whose id, rounded to the next integer, is not that of an object that covers them most.
static int wrong_ids(const float *out)
{
    int wrong = 0;
    for (int p = 0; p < WIDTH; p++) {
        int frames[OBJECTS] = {0}, most = 0, own = 0;
        for (int i = 0; i < WIDTH; i++)
            frames[object_at(i, p)]++;
        for (int k = 0; k < OBJECTS; k++) {
            most = frames[k] > most ? frames[k] : most;
            own = rint((double)out[p]) == object_id[k] ? frames[k] : own;
        }
        wrong += own < most;
    }
    return wrong;
}

static enum weft_result most_covering(const struct weft_stability_params *params, float *ids)
{
    float share[WIDTH], best[WIDTH] = {0};
    enum weft_result res = WEFT_OK;
    for (int k = 0; k < OBJECTS && res == WEFT_OK; k++) {
        struct weft_stability_frames f;
        res = create_frames(&f, WIDTH, 1, WEFT_PLANE_FLOAT, coverage[k]);
        if (res == WEFT_OK)
            res = weft_stability_accumulate(
                params, &f, *weft_accumulator_params(.method = WEFT_ACCUMULATE_EXACT), 1.0, share,
                NULL);
        for (int p = 0; p < WIDTH && res == WEFT_OK; p++) {
            ids[p] = share[p] > best[p] ? (float)object_id[k] : ids[p];
            best[p] = fmaxf(best[p], share[p]);
        }
        free(f.values);
    }
    return res;
}

static enum weft_result measure_id_mean(const struct weft_stability_params *params,
                                        struct weft_stability_result *result)
{
    float out[WIDTH] = {0};
    struct weft_stability_frames f;
    enum weft_result res = create_frames(&f, WIDTH, 1, WEFT_PLANE_FLOAT, id_at);
    if (res == WEFT_OK)
        res = weft_stability_accumulate(
            params, &f, *weft_accumulator_params(.method = WEFT_ACCUMULATE_EXACT), 1.0, out, NULL);
    result->naive = wrong_ids(out);
    if (res == WEFT_OK)
        res = most_covering(params, out);
    result->ours = wrong_ids(out);
    result->limit = 0.0; // shares are exact multiples of 1/64, so that none is taken for another
    free(f.values);
    weft_stability_say(result, "pixels",
                       "objects 3, 7 and 12 that move: %.0f of %d pixels have another id than what "
                       "covers them most",
                       result->naive, WIDTH);
    return res;
}

const struct weft_stability_case weft_stability_id_mean = {
    .name = "id-mean",
    .failure = "ids averaged: objects that are not there",
    .naive = "the mean of ids, exactly",
    .ours = "the mean of each object's coverage, and the id of the largest",
    .source = "Friedman and Jones, Fully automatic ID mattes, SIGGRAPH 2015 talks",
    .measure = measure_id_mean,
};

// ---- frames that are no frames ------------------------------------------------------------------

enum { BAD_FRAME = 637 };

static double nan_frame(int frame, int pixel)
{
    return frame == BAD_FRAME ? (double)NAN
                              : 0.5 + 0.5 * (double)weft_stability_noise(frame, pixel, 2);
}

// Largest distance from the mean of what is finite; INFINITY where it is not finite.
static double finite_error(const struct weft_stability_frames *f, const float *out)
{
    double largest = 0.0;
    for (int p = 0; p < WIDTH; p++) {
        double sum = 0.0;
        for (int i = 0; i < f->count; i++)
            sum += i == BAD_FRAME ? 0.0 : load(f, i, p);
        const double error = fabs((double)out[p] - sum / (f->count - 1));
        largest = isfinite(error) ? fmax(largest, error) : (double)INFINITY;
    }
    return largest;
}

static enum weft_result measure_nan_frame(const struct weft_stability_params *params,
                                          struct weft_stability_result *result)
{
    float out[WIDTH];
    struct weft_accumulator_report report = {0};
    struct weft_accumulator_params how = {.method = WEFT_ACCUMULATE_EXACT,
                                          .nonfinite = WEFT_NONFINITE_PROPAGATE};
    struct weft_stability_frames f;
    enum weft_result res = create_frames(&f, 1000, 1, WEFT_PLANE_FLOAT, nan_frame);
    if (res == WEFT_OK)
        res = weft_stability_accumulate(params, &f, how, 1.0, out, NULL);
    result->naive = res == WEFT_OK ? finite_error(&f, out) : 0.0;
    how.nonfinite = WEFT_NONFINITE_SKIP;
    if (res == WEFT_OK)
        res = weft_stability_accumulate(params, &f, how, 1.0, out, &report);
    result->ours = res == WEFT_OK ? finite_error(&f, out) : 0.0;
    // The reference's sums are doubles': 1000 roundings of sums below 1000.
    result->limit = report.bound + 1000.0 * 0x1p-53;
    free(f.values);
    weft_stability_say(result, "of 1.0", "frame %d of 1000 is NaN: %s", BAD_FRAME,
                       isinf(result->naive) ? "so is all of the mean" : "the mean is finite");
    return res;
}

const struct weft_stability_case weft_stability_nan_frame = {
    .name = "nan-frame",
    .failure = "one frame in a thousand that is NaN",
    .naive = "all frames added",
    .ours = "values that are not finite do not count, those of other frames do",
    .source = "IEEE 754: NaN plus anything is NaN",
    .measure = measure_nan_frame,
};
