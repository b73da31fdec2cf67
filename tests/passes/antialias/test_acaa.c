// SPDX-License-Identifier: BSD-3-Clause
// Accumulative anti-aliasing of one pass and a box: both forms against the integer sum of what each
// sample shows, with equality; sizes, backgrounds, coincident surfaces.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "tests/support/contexts.h"
#include "tests/passes/antialias/samples.h"
#include "passes/antialias/accumulative.h"

static const double here[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
static const double grey[4] = {0.3, 0.1, 0.7, 0.25};
enum { MOST_PIXELS = 333 * 17, MOST_TRIANGLES = 40 };

struct picture {
    float channel[4][MOST_PIXELS], weight[MOST_PIXELS];
    struct weft_acaa_report report;
};

static void draw(weft_context *context, struct triangles *triangles,
                 const struct weft_acaa_params *params, struct picture *out)
{
    struct weft_acaa_params p = *params;
    weft_acaa *acaa;
    p.context = context;
    p.log = &log_to_stderr;
    assert_true(p.width * p.height <= MOST_PIXELS);
    assert_int_equal(weft_acaa_create(&p, &acaa), WEFT_OK);
    assert_int_equal(weft_acaa_run(acaa, triangles_drawing(triangles), NULL), WEFT_OK);
    for (int c = 0; c < 4; c++)
        assert_int_equal(weft_acaa_read(acaa, c, out->channel[c], 0), WEFT_OK);
    assert_int_equal(weft_acaa_read_weight(acaa, out->weight, 0), WEFT_OK);
    weft_acaa_get_report(acaa, &out->report);
    weft_acaa_destroy(&acaa);
}

static bool has_forms(const weft_context *context)
{
    return context->gl.VERSION_4_2;
}

static void check_weights(const struct picture *picture, int pixels)
{
    assert_int_equal(picture->report.less, 0);
    assert_int_equal(picture->report.more, 0);
    assert_true(picture->report.largest == 0.0);
    assert_int_equal(picture->report.first_less[0], -1);
    for (int i = 0; i < pixels; i++)
        assert_true(picture->weight[i] == 1.0f);
}

// The mean of integers, of samples that nobody covers those of the background.
static float mean(const struct samples *s, int x, int y, int channel, double scale,
                  const double background[4])
{
    double sum = 0.0;
    for (int i = 0; i < s->count; i++) {
        const float *value = samples_at(s, x, y, i);
        sum += nearbyint((value[3] > 0.0f ? (double)value[channel] : background[channel]) * scale);
    }
    return (float)(sum / s->count / scale);
}

static void check_samples(const struct picture *picture, const struct samples *s,
                          const double background[4])
{
    for (int c = 0; c < 4; c++)
        for (int y = 0; y < s->height; y++)
            for (int x = 0; x < s->width; x++) {
                const float expected = mean(s, x, y, c, picture->report.scale, background);
                const float actual = picture->channel[c][y * s->width + x];
                if (actual != expected)
                    fail_msg("channel %d at (%d, %d): %.9g instead of %.9g", c, x, y, actual,
                             expected);
            }
}

static const enum weft_acaa_form forms[] = {WEFT_ACAA_POST_DEPTH, WEFT_ACAA_SAMPLE_ID};

// Both forms, with each remedy, show what the samples show.
static int check_scene(weft_context *context, uint32_t seed, const int size[2], int samples,
                       int depth_bits, const char *fragment)
{
    static struct triangle_vertex vertices[3 * MOST_TRIANGLES];
    static struct picture picture[2];
    struct triangles triangles;
    struct samples reference;
    int compared = 0;
    samples_scene(seed, size, MOST_TRIANGLES, 1.0f, vertices);
    triangles_create(context, vertices, 3 * MOST_TRIANGLES, &triangles);
    triangles.fragment[WEFT_STAGE_COLOUR] = fragment;
    samples_read(&triangles, size[0], size[1], samples, depth_bits, here, &reference);
    for (size_t f = 0; f < WEFT_COUNT(forms); f++) {
        const enum weft_acaa_coincident remedy = (seed + f) % WEFT_COINCIDENT_COUNT;
        draw(context, &triangles,
             weft_acaa_params(.width = size[0], .height = size[1], .samples = samples,
                              .form = forms[f], .depth_bits = depth_bits, .coincident = remedy,
                              .background = {grey[0], grey[1], grey[2], grey[3]}),
             &picture[f]);
        assert_int_equal(picture[f].report.form, forms[f]);
        assert_int_equal(picture[f].report.passes, 1);
        check_weights(&picture[f], size[0] * size[1]);
        check_samples(&picture[f], &reference, grey);
        compared++;
    }
    assert_memory_equal(picture[0].channel, picture[1].channel, sizeof picture[0].channel);
    samples_free(&reference);
    triangles_destroy(&triangles);
    return compared;
}

static void test_samples(void **state)
{
    static const int sizes[][2] = {{1, 1}, {33, 17}, {1, 9}, {64, 64}, {9, 1}, {333, 17}};
    int compared = 0;
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++) {
        if (!has_forms(contexts[c]))
            continue;
        for (uint32_t i = 0; i < WEFT_COUNT(sizes); i++)
            compared +=
                check_scene(contexts[c], i, sizes[i], i % 4 == 1 ? 1 : 4, i % 3 == 2 ? 32 : 24,
                            i % 2 ? triangles_flat : triangles_smooth);
    }
    print_message("%d pictures compared with their samples\n", compared);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_samples),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
