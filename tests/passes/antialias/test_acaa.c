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
#include "tests/passes/antialias/pictures.h"

enum { MOST_TRIANGLES = 40 };

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
            for (int x = 0; x < s->width; x++)
                picture_check_value(picture, c, x, y, s->width,
                                    mean(s, x, y, c, picture->report.scale, background));
}

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
    samples_read(&triangles, size[0], size[1], samples, depth_bits, identity_place, &reference);
    for (size_t f = 0; f < WEFT_COUNT(exact_forms); f++) {
        const enum weft_acaa_coincident remedy = (seed + f) % WEFT_COINCIDENT_COUNT;
        picture_draw(&triangles,
                     weft_acaa_params(.width = size[0], .height = size[1], .samples = samples,
                                      .form = exact_forms[f], .depth_bits = depth_bits,
                                      .coincident = remedy,
                                      .background = {grey[0], grey[1], grey[2], grey[3]}),
                     &picture[f]);
        assert_int_equal(picture[f].report.form, exact_forms[f]);
        assert_int_equal(picture[f].report.passes, 1);
        picture_check_weights(&picture[f], size[0] * size[1]);
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
        if (!has_exact_forms(contexts[c]))
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
