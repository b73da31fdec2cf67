// SPDX-License-Identifier: BSD-3-Clause
// More samples than the device has, from several passes, and kernels wider than a pixel: against
// sums of each pass's samples, exactly for boxes, within the promised bound of double sums
// otherwise.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "tests/support/common.h"
#include "tests/support/contexts.h"
#include "tests/passes/antialias/pictures.h"
#include "passes/antialias/drawing/run.h"
#include "passes/antialias/multisample.h"

enum { MOST_TRIANGLES = 24 };

// What each pixel's sums come to by the filter's own weights, in double, or by integers of a box.
struct reference {
    double sum[PICTURE_PIXELS][4]; // of colours and of weights, over surfaces
    int width, height;
};

struct job {
    int width, height, samples;
    const char *kernel; // NULL: a box
    double filter_width;
    enum weft_acaa_sums sums;
    enum weft_acaa_coincident coincident;
};

static void make_pattern(weft_context *context, int samples, struct weft_pattern *out)
{
    double position[WEFT_PATTERN_MAX][2];
    int device = samples;
    while (samples % device != 0 || weft_msaa_positions(context, device, position) != device)
        device--;
    assert_int_equal(
        weft_pattern_create(weft_pattern_params(.device = (const double(*)[2])position,
                                                .device_count = device, .count = samples,
                                                .log = &log_to_stderr),
                            out),
        WEFT_OK);
}

// Adds a sample that shows `value` to the pixels that it counts in, (x, y) being its own, rows
// upwards.
static void spread_sample(struct reference *r, const struct weft_spread *spread, int sample, int x,
                          int y, const float value[4], double scale)
{
    const int side = 2 * spread->radius + 1;
    for (int j = 0; j < side; j++)
        for (int i = 0; i < side; i++) {
            const int at[2] = {x + i - spread->radius, y - (j - spread->radius)};
            double weight = spread->weight[(j * side + i) * spread->count + sample] * spread->count;
            weight = scale > 0.0 ? nearbyint(weight) : weight; // a box's are 0 and 1
            if (at[0] < 0 || at[1] < 0 || at[0] >= r->width || at[1] >= r->height)
                continue;
            double *sum = r->sum[at[1] * r->width + at[0]];
            for (int c = 0; c < 3; c++)
                sum[c] += weight * (scale > 0.0 ? nearbyint((double)value[c] * scale) / scale
                                                : (double)value[c]);
            sum[3] += weight;
        }
}

static void make_reference(struct triangles *triangles, const struct job *job, int radius,
                           double scale, struct reference *out)
{
    struct weft_pattern pattern;
    struct weft_spread spread;
    struct samples samples;
    struct weft_kernel kernel = {0};
    make_pattern(triangles->context, job->samples, &pattern);
    if (job->kernel)
        kernel = kernel_named(job->kernel);
    assert_int_equal(
        weft_spread_create(weft_spread_params(.position = (const double(*)[2])pattern.position,
                                              .count = pattern.count, .filter = kernel,
                                              .filter_width = job->filter_width),
                           &spread),
        WEFT_OK);
    assert_int_equal(spread.radius, radius);
    bool wraps = false;
    for (int i = 0; i < pattern.count; i++)
        wraps = wraps || pattern.pixel[i][0] || pattern.pixel[i][1];
    const int rim = radius + wraps, device = pattern.device_count;
    memset(out->sum, 0, sizeof out->sum);
    out->width = job->width;
    out->height = job->height;
    for (int p = 0; p < pattern.passes; p++) {
        double place[16];
        weft_drawing_place(job->width, job->height, rim, pattern.offset[p], place);
        samples_read(triangles, job->width + 2 * rim, job->height + 2 * rim, device, 24, place,
                     &samples);
        for (int y = 0; y < samples.height; y++)
            for (int x = 0; x < samples.width; x++)
                for (int i = 0; i < device; i++) {
                    const float *value = samples_at(&samples, x, y, i);
                    const int s = p * device + i;
                    if (value[3] > 0.0f)
                        spread_sample(out, &spread, s, x - rim + pattern.pixel[s][0],
                                      y - rim - pattern.pixel[s][1], value, scale);
                }
        samples_free(&samples);
    }
    weft_spread_clear(&spread);
}

// Returns the largest departure, as a share of the bound. scale: of a box of integers, which is
// exact; else 0.
static double compare(const struct picture *picture, const struct job *job,
                      const struct reference *r, double scale)
{
    double most = 0.0;
    for (int i = 0; i < job->width * job->height; i++)
        for (int c = 0; c < 4; c++) {
            const double covered = r->sum[i][3], shown = job->samples - covered;
            const double surface = c < 3 ? r->sum[i][c] : covered;
            const double behind = scale > 0.0 ? nearbyint(grey[c] * scale) / scale : grey[c];
            const double expected = (surface + shown * behind) / job->samples;
            if (scale > 0.0)
                picture_check_value(picture, c, i % job->width, i / job->width, job->width,
                                    (float)expected);
            most = larger(most,
                          fabs((double)picture->channel[c][i] - expected) / picture->report.bound);
        }
    return most;
}

static double check_job(weft_context *context, uint32_t seed, const struct job *job)
{
    static struct triangle_vertex vertices[3 * MOST_TRIANGLES];
    static struct picture picture[2];
    static struct reference reference;
    const int size[2] = {job->width, job->height};
    struct triangles triangles;
    double most = 0.0;
    samples_scene(seed, size, MOST_TRIANGLES, 1.0f, vertices);
    triangles_create(context, vertices, 3 * MOST_TRIANGLES, &triangles);
    triangles.fragment[WEFT_STAGE_COLOUR] = triangles_smooth;
    for (int f = 0; f < 2; f++) {
        const struct weft_kernel filter =
            job->kernel ? kernel_named(job->kernel) : (struct weft_kernel){0};
        picture_draw(&triangles,
                     weft_acaa_params(.width = size[0], .height = size[1], .samples = job->samples,
                                      .form = exact_forms[f], .filter = filter,
                                      .filter_width = job->filter_width, .sums = job->sums,
                                      .coincident = job->coincident,
                                      .background = {grey[0], grey[1], grey[2], grey[3]}),
                     &picture[f]);
        picture_check_weights(&picture[f], size[0] * size[1]);
        const double scale = job->kernel ? 0.0 : picture[f].report.scale; // 0 of floats
        if (f == 0)
            make_reference(&triangles, job, picture[0].report.radius, scale, &reference);
        most = larger(most, compare(&picture[f], job, &reference, scale));
    }
    if (job->sums == WEFT_ACAA_INTEGER)
        assert_memory_equal(picture[0].channel, picture[1].channel, sizeof picture[0].channel);
    triangles_destroy(&triangles);
    print_message("%d x %d, %d samples of %d in %d passes, %s %g, %s: discrepancy %.4f, bound "
                  "%.3g, largest departure %.3f of it\n",
                  size[0], size[1], job->samples, picture[0].report.device_samples,
                  picture[0].report.passes, job->kernel ? job->kernel : "box", job->filter_width,
                  weft_acaa_sums_names[job->sums], picture[0].report.discrepancy,
                  picture[0].report.bound, most);
    return most;
}

#define SIZE(w, h) .width = (w), .height = (h)

static const struct job jobs[] = {
    {SIZE(33, 17), .samples = 8},
    {SIZE(33, 17), .samples = 16, .coincident = WEFT_COINCIDENT_MASK},
    {SIZE(17, 5), .samples = 64, .coincident = WEFT_COINCIDENT_NONE},
    {SIZE(9, 9), .samples = 6},
    {SIZE(1, 1), .samples = 16},
    {SIZE(33, 17), .samples = 4, .kernel = "linear", .filter_width = 3.0},
    {SIZE(33, 17), .samples = 4, .kernel = "catmull-rom"},
    {SIZE(13, 9), .samples = 8, .kernel = "catmull-rom", .coincident = WEFT_COINCIDENT_MASK},
    {SIZE(13, 9), .samples = 16, .kernel = "bspline", .coincident = WEFT_COINCIDENT_ALPHA},
    {SIZE(1, 7), .samples = 4, .kernel = "lanczos"},
    {SIZE(33, 17), .samples = 4, .sums = WEFT_ACAA_FLOAT},
    {SIZE(13, 9), .samples = 8, .kernel = "catmull-rom", .sums = WEFT_ACAA_FLOAT},
};

static void test_jobs(void **state)
{
    int compared = 0;
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++) {
        if (!has_exact_forms(contexts[c]))
            continue;
        // Of the second context some: the first one is as good, and shaders take their time.
        for (size_t i = 0; i < WEFT_COUNT(jobs); i += c == 0 ? 1 : 5) {
            const double most = check_job(contexts[c], (uint32_t)i, &jobs[i]);
            assert_true(most > 0.0 && most <= 1.0);
            compared++;
        }
    }
    print_message("%d jobs compared with their samples\n", compared);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_jobs),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
