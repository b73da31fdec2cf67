// SPDX-License-Identifier: BSD-3-Clause
// Cases of effects by accumulation: frames that are taken at the wrong places, too few of them, or
// of light that has no bound. Frames are samples of scenes so plain that their integrals are known;
// both ways average them exactly, so that nothing but the samples differs.
#include <math.h>
#include <stdlib.h>

#include "filter/check.h"
#include "passes/accumulate/accumulate.h"
#include "passes/jitter/camera.h"
#include "passes/jitter/counts.h"
#include "passes/jitter/edge.h"
#include "passes/jitter/jitter.h"
#include "passes/jitter/shutter.h"
#include "passes/stability/cases.h"

enum { WIDTH = 64 };

// One effect: what a frame shows, and what all frames should.
struct effect {
    int height;
    double (*sample)(const void *scene, int frame, int pixel);
    double (*exact)(int pixel);
};

static int pixels_of(const struct effect *e)
{
    return WIDTH * e->height;
}

// The mean of `count` frames, all alike, in floats. bound: of its error against the samples as
// they are; NULL where nobody asks.
static enum weft_result average(const struct weft_stability_params *params, const struct effect *e,
                                const void *scene, int count, float *out, double *bound)
{
    const int pixels = pixels_of(e);
    struct weft_accumulator_report report = {0};
    struct weft_stability_frames frames = {count, WIDTH, e->height, WEFT_PLANE_FLOAT, NULL};
    float *values = malloc((size_t)count * (size_t)pixels * sizeof *values);
    if (!values)
        return WEFT_ERR_MEMORY;
    double largest = 0.0;
    for (int i = 0; i < count; i++)
        for (int p = 0; p < pixels; p++) {
            const double value = e->sample(scene, i, p);
            values[(size_t)i * (size_t)pixels + (size_t)p] = (float)value;
            largest = fmax(largest, fabs(value));
        }
    frames.values = values;
    const enum weft_result res = weft_stability_accumulate(
        params, &frames, *weft_accumulator_params(.method = WEFT_ACCUMULATE_EXACT), 1.0, out,
        &report);
    if (bound)
        *bound = report.bound + largest * 0x1p-24;
    free(values);
    return res;
}

// A NAN counts.
static double largest_error(const struct effect *e, const float *out)
{
    double largest = 0.0;
    for (int p = 0; p < pixels_of(e); p++) {
        const double error = fabs((double)out[p] - e->exact(p));
        largest = error <= largest ? largest : error;
    }
    return largest;
}

// Two lists of samples by their largest errors. The limit is what ours may be off by, which the
// caller derives, and the roundings of the mean.
static enum weft_result measure_both(const struct weft_stability_params *params,
                                     const struct effect *e, const void *naive, int naive_count,
                                     const void *ours, int ours_count, double limit,
                                     struct weft_stability_result *result)
{
    float out[WIDTH];
    double bound = 0.0;
    enum weft_result res = average(params, e, naive, naive_count, out, NULL);
    if (res == WEFT_OK) {
        result->naive = largest_error(e, out);
        res = average(params, e, ours, ours_count, out, &bound);
    }
    if (res == WEFT_OK)
        result->ours = largest_error(e, out);
    result->limit = limit + bound;
    return res;
}

// ---- samples beside the pixel's middle ----------------------------------------------------------

// An upright edge that lies in each pixel a little further right than in the one before: from one
// pixel left of the middle to one right of it.
enum { EDGE_HEIGHT = 16, EDGE_PIXELS = WIDTH * EDGE_HEIGHT };
static const double edge_step = 2.0 / EDGE_PIXELS;

static double edge_place(int pixel)
{
    return -1.0 + (pixel + 0.5) * edge_step;
}

static double edge_sample(const void *scene, int frame, int pixel)
{
    const struct weft_jitter *set = scene;
    return set->points[frame][0] <= edge_place(pixel);
}

static double edge_exact(int pixel)
{
    return weft_edge_square((const double[2]){1.0, 0.0}, edge_place(pixel));
}

static const struct effect edge = {EDGE_HEIGHT, edge_sample, edge_exact};

// How far the edge in the picture lies from where it is, in pixels: the area between both.
static enum weft_result measure_shift(const struct weft_stability_params *params, bool centre,
                                      double *shift, double *bound)
{
    float out[EDGE_PIXELS];
    struct weft_jitter set = {0};
    enum weft_result res =
        weft_jitter_create(weft_jitter_params(.info = weft_jitter_find("halton"), .count = 8,
                                              .centre = centre, .log = params->log),
                           &set);
    if (res == WEFT_OK)
        res = average(params, &edge, &set, set.count, out, bound);
    *shift = 0.0;
    for (int p = 0; p < EDGE_PIXELS && res == WEFT_OK; p++)
        *shift += (edge_exact(p) - (double)out[p]) * edge_step;
    weft_jitter_clear(&set);
    return res;
}

static enum weft_result measure_jitter_shift(const struct weft_stability_params *params,
                                             struct weft_stability_result *result)
{
    double bound = 0.0;
    enum weft_result res = measure_shift(params, false, &result->naive, NULL);
    if (res == WEFT_OK)
        res = measure_shift(params, true, &result->ours, &bound);
    result->naive = fabs(result->naive);
    result->ours = fabs(result->ours);
    weft_stability_say(result, "pixels", "halton:8 moves the picture by %.3f pixels, centred %.3f",
                       result->naive, result->ours);
    // Each sample sees the edge half a step too early or too late; the mean of all places is 0.
    result->limit = 0.5 * edge_step + 2.0 * bound;
    return res;
}

const struct weft_stability_case weft_stability_jitter_shift = {
    .name = "jitter-shift",
    .failure = "samples of a pixel whose mean is not its middle: the picture moves",
    .naive = "the first 8 points of Halton's sequence as they are",
    .ours = "their mean taken off every point (or told: weft_jitter's mean)",
    .source = "Halton, Numerische Mathematik 2, 1960: the first n points lean to 0",
    .measure = measure_jitter_shift,
};

// ---- copies -------------------------------------------------------------------------------------

// A bar that crosses half of the picture while the shutter is open.
static const double bar_width = 4.0, bar_start = 12.25, bar_way = 32.0;
static const struct weft_shutter bar_shutter = WEFT_SHUTTER_BOX;

static double bar_sample(const void *scene, int frame, int pixel)
{
    const double *times = scene;
    const double from_left = pixel + 0.5 - (bar_start + bar_way * times[frame]);
    return from_left >= 0.0 && from_left < bar_width;
}

static double bar_exact(int pixel)
{
    const double come = (pixel + 0.5 - bar_start) / bar_way;
    const double gone = (pixel + 0.5 - bar_start - bar_width) / bar_way;
    return weft_shutter_share(&bar_shutter, come) - weft_shutter_share(&bar_shutter, gone);
}

static const struct effect bar = {1, bar_sample, bar_exact};

static enum weft_result measure_few_frames(const struct weft_stability_params *params,
                                           struct weft_stability_result *result)
{
    enum { FEW = 4, MOST = 64 };
    double few[FEW], enough[MOST], weights[MOST]; // of a box: all alike
    const int count = (int)weft_frames_for_motion(bar_way);
    if (count > MOST)
        return WEFT_ERR_LIMIT;
    enum weft_result res = weft_shutter_weights(params->log, &bar_shutter, FEW, few, weights, NULL);
    if (res == WEFT_OK)
        res = weft_shutter_weights(params->log, &bar_shutter, count, enough, weights, NULL);
    if (res == WEFT_OK) // either edge of the bar is a ramp within 1 / (2 count): shutter.h
        res = measure_both(params, &bar, few, FEW, enough, count, 1.0 / count, result);
    weft_stability_say(
        result, "of 1.0",
        "a bar of %.0f pixels moves %.0f: %d frames leave %d copies and gaps, off by "
        "%.3f where %.3f is right; %d frames by %.3f",
        bar_width, bar_way, FEW, FEW, result->naive, bar_width / bar_way, count, result->ours);
    return res;
}

const struct weft_stability_case weft_stability_few_frames = {
    .name = "few-frames",
    .failure = "fewer frames than pixels of motion: copies in place of a blur",
    .naive = "4 frames of a bar that moves 32 pixels",
    .ours = "a frame for each pixel of the motion (weft_frames_for_motion)",
    .source = "Haeberli and Akeley, The Accumulation Buffer, SIGGRAPH 1990",
    .measure = measure_few_frames,
};

// ---- depth of field and motion at once ----------------------------------------------------------

// An edge in the middle of the picture comes into focus while the shutter is open: 1 / depth grows
// evenly, so that its blur shrinks evenly from 32 pixels to none. The lens is a slit across it.
enum { LENS_ROWS = 16, LENS_FRAMES = LENS_ROWS * LENS_ROWS };
static const double lens_blur = 32.0, lens_focus = 5.0, lens_start = 10.0;

struct lens_frame {
    double place; // on the lens, -1/2 to 1/2
    double time;  // that the depth is of
    double edge;  // where it then is in the picture, in pixels
};

static double lens_depth(double time)
{
    return 1.0 / ((1.0 - time) / lens_start + time / lens_focus);
}

static double lens_sample(const void *scene, int frame, int pixel)
{
    return pixel + 0.5 >= ((const struct lens_frame *)scene)[frame].edge;
}

// With c(t) = c (1 - t), at u = 2 d / c from the edge: 1 for t > 1 - u, 1/2 + d / c(t) before.
static double lens_exact(int pixel)
{
    const double d = pixel + 0.5 - 0.5 * WIDTH, u = fmin(1.0, 2.0 * fabs(d) / lens_blur);
    return 0.5 + copysign(0.5 * u * (1.0 - log(u)), d);
}

static const struct effect lens = {1, lens_sample, lens_exact};

static enum weft_result project(const struct weft_stability_params *params, int count,
                                struct lens_frame *frames)
{
    const struct weft_camera camera = {WEFT_CAMERA_DEFAULTS};
    const int size[2] = {WIDTH, WIDTH};
    const double aperture =
        lens_blur / weft_camera_circle(&camera, size, 1.0, lens_focus, lens_start);
    enum weft_result res = WEFT_OK;
    for (int i = 0; i < count && res == WEFT_OK; i++) {
        const struct weft_camera_frame frame = {
            .size = {WIDTH, WIDTH}, .lens = {aperture * frames[i].place}, .focus = lens_focus};
        struct weft_camera_matrices m;
        res = weft_camera_compute(params->log, &camera, &frame, &m);
        const double z = -lens_depth(frames[i].time); // the edge goes through (0, 0, z)
        const double x = (m.clip[8] * z + m.clip[12]) / (m.clip[11] * z + m.clip[15]);
        frames[i].edge = 0.5 * WIDTH * (1.0 + x);
    }
    return res;
}

// Time and place on the lens of each frame. Naive: all frames of the lens after those of the time.
static enum weft_result place_lens_frames(const struct weft_stability_params *params,
                                          struct lens_frame *naive, struct lens_frame *ours)
{
    struct weft_jitter set = {0};
    enum weft_result res =
        weft_jitter_create(weft_jitter_params(.info = weft_jitter_find("hammersley"),
                                              .count = LENS_FRAMES, .log = params->log),
                           &set);
    for (int i = 0; i < LENS_FRAMES && res == WEFT_OK; i++) {
        naive[i] = (struct lens_frame){.place = (i % LENS_ROWS + 0.5) / LENS_ROWS - 0.5,
                                       .time = (LENS_ROWS - 0.5) / LENS_ROWS};
        ours[i] = (struct lens_frame){.place = set.points[i][1], .time = set.points[i][0] + 0.5};
    }
    weft_jitter_clear(&set);
    if (res == WEFT_OK)
        res = project(params, LENS_FRAMES, naive);
    return res == WEFT_OK ? project(params, LENS_FRAMES, ours) : res;
}

static enum weft_result measure_lens_outside(const struct weft_stability_params *params,
                                             struct weft_stability_result *result)
{
    struct lens_frame naive[LENS_FRAMES], ours[LENS_FRAMES];
    // Hammersley's 256 points have one in each of 16 x 16 boxes of time and lens. What a pixel sees
    // of them ends at a curve that rises or falls all along: it crosses 31 boxes at most, and in
    // each the share may be off by the whole box.
    const double limit = (2.0 * LENS_ROWS - 1.0) / LENS_FRAMES;
    enum weft_result res = place_lens_frames(params, naive, ours);
    if (res == WEFT_OK)
        res = measure_both(params, &lens, naive, LENS_FRAMES, ours, LENS_FRAMES, limit, result);
    weft_stability_say(result, "of 1.0",
                       "an edge comes into focus: the last depth's blur, %.0f pixel in place of up "
                       "to %.0f, is off by %.2f",
                       lens_blur * 0.5 / LENS_ROWS, lens_blur, result->naive);
    return res;
}

const struct weft_stability_case weft_stability_lens_outside = {
    .name = "lens-outside",
    .failure = "places on the lens outside of the frames of a motion: the last depth's blur",
    .naive = "the shutter's frames first, then the lens's with the last depth",
    .ours = "every frame has a time and a place on the lens of its own",
    .source = "Unity HDRP, accumulation: depth of field inside the sub-frames",
    .measure = measure_lens_outside,
};

// ---- light without bound ------------------------------------------------------------------------

// A floor, x from 0 to 1 and y from -1/2 to 1/2, at the foot of a wall x = 0 that is as large and
// has the radiance 1. The light comes from 64 points of the wall: 8 x 8 cells have one each.
enum { FLOOR_PIXELS = WIDTH * WIDTH, WALL_ROWS = 8, WALL_LIGHTS = WALL_ROWS * WALL_ROWS };

struct wall {
    double (*light)[2]; // y, and z - 1/2
    double most;        // largest factor that counts
};

static void floor_place(int pixel, double *x, double *y)
{
    *x = (pixel % WIDTH + 0.5) / WIDTH;
    *y = (pixel / WIDTH + 0.5) / WIDTH - 0.5;
}

// cos cos / distance^2 between places x on the floor and z on the wall, `across` from each other.
static double light_factor(double x, double across, double z)
{
    const double square = x * x + across * across + z * z;
    return x * z / (square * square);
}

static double wall_sample(const void *scene, int frame, int pixel)
{
    const struct wall *wall = scene;
    const double *light = wall->light[frame];
    double x, y;
    floor_place(pixel, &x, &y);
    return fmin(wall->most, light_factor(x, y - light[0], light[1] + 0.5));
}

// The integral of light_factor over the wall, by z first.
static double wall_exact(int pixel)
{
    double x, y;
    floor_place(pixel, &x, &y);
    const double far = sqrt(1.0 + x * x), left = -0.5 - y, right = 0.5 - y;
    return 0.5 * (atan(right / x) - atan(left / x)) -
           0.5 * x / far * (atan(right / far) - atan(left / far));
}

static const struct effect wall_light = {WIDTH, wall_sample, wall_exact};

// Least and largest factor of a light that is anywhere in a cell. It falls with the way across; up
// to z = distance / sqrt(3) it rises with z, and falls from there.
static void cell_range(double x, double y, int cell, double *least, double *most)
{
    const double size = 1.0 / WALL_ROWS;
    const double left = (cell % WALL_ROWS) * size - 0.5, low = (cell / WALL_ROWS) * size;
    const double near = fmax(0.0, fmax(left - y, y - left - size));
    const double far = fmax(fabs(left - y), fabs(left + size - y));
    const double top = fmin(low + size, fmax(low, sqrt((x * x + near * near) / 3.0)));
    *most = light_factor(x, near, top);
    *least = fmin(light_factor(x, far, low), light_factor(x, far, low + size));
}

// The largest error that lights with such a clamp can have, one in each cell, wherever they are.
static double wall_limit(double clamp)
{
    double largest = 0.0;
    for (int p = 0; p < FLOOR_PIXELS; p++) {
        double x, y, low = 0.0, high = 0.0;
        floor_place(p, &x, &y);
        for (int c = 0; c < WALL_LIGHTS; c++) {
            double least, most;
            cell_range(x, y, c, &least, &most);
            low += fmin(clamp, least) / WALL_LIGHTS;
            high += fmin(clamp, most) / WALL_LIGHTS;
        }
        largest = fmax(largest, fmax(wall_exact(p) - low, high - wall_exact(p)));
    }
    return largest;
}

static double sum_of(const float *values)
{
    double sum = 0.0;
    for (int p = 0; p < FLOOR_PIXELS; p++)
        sum += (double)values[p];
    return sum;
}

// out: two pictures.
static enum weft_result light_floor(const struct weft_stability_params *params,
                                    const struct weft_jitter *set, float *out,
                                    struct weft_stability_result *result)
{
    // A light stands for 1/64 of the wall, which as a patch gives pi at most.
    const struct wall all = {set->points, (double)INFINITY},
                      clamped = {set->points, acos(-1.0) * WALL_LIGHTS};
    float *const kept = out + FLOOR_PIXELS;
    double bound = 0.0;
    enum weft_result res = average(params, &wall_light, &all, set->count, out, NULL);
    if (res == WEFT_OK)
        res = average(params, &wall_light, &clamped, set->count, kept, &bound);
    if (res != WEFT_OK)
        return res;
    result->naive = largest_error(&wall_light, out);
    result->ours = largest_error(&wall_light, kept);
    result->limit = wall_limit(clamped.most) + bound;
    weft_stability_say(result, "of 1.0",
                       "a light beside a corner is off by %.0f where pi/2 is the most there is; "
                       "clamped by %.2f, and %.1f %% of the light lost",
                       result->naive, result->ours, 100.0 * (1.0 - sum_of(kept) / sum_of(out)));
    return WEFT_OK;
}

static enum weft_result measure_light_corner(const struct weft_stability_params *params,
                                             struct weft_stability_result *result)
{
    struct weft_jitter set = {0};
    float *out = malloc(2 * FLOOR_PIXELS * sizeof *out);
    enum weft_result res = out ? WEFT_OK : WEFT_ERR_MEMORY;
    if (res == WEFT_OK) // centred, the points are in the middles of their 64 x 64 boxes
        res = weft_jitter_create(weft_jitter_params(.info = weft_jitter_find("sobol"),
                                                    .count = WALL_LIGHTS, .centre = true,
                                                    .log = params->log),
                                 &set);
    if (res == WEFT_OK)
        res = light_floor(params, &set, out, result);
    weft_jitter_clear(&set);
    free(out);
    return res;
}

const struct weft_stability_case weft_stability_light_corner = {
    .name = "light-corner",
    .failure = "a virtual light next to a corner: 1 / distance^2 has no bound",
    .naive = "64 lights for a wall, each as it is",
    .ours = "each light gives what its share of the wall could at most, and the loss is told",
    .source = "Keller, Instant Radiosity, SIGGRAPH 1997",
    .measure = measure_light_corner,
};
