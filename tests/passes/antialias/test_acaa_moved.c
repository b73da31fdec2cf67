// SPDX-License-Identifier: BSD-3-Clause
// Accumulative anti-aliasing by moved pictures of one sample: the picture of the other forms where
// vertices need no snapping.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "tests/support/contexts.h"
#include "tests/passes/antialias/small_pictures.h"
#include "passes/antialias/multisample.h"

// In 256ths of a pixel, where GL snaps vertices to, so that moves by such change nothing: a
// triangle of one depth.
static void snapped_triangle(uint32_t *random, struct triangle_vertex out[3])
{
    double corners[3][2];
    float colour[4] = {0.0f, 0.0f, 0.0f, 1.0f};
    uint32_t number[10];
    for (int i = 0; i < 10; i++) {
        *random = *random * 1664525u + 1013904223u;
        number[i] = *random >> 8;
    }
    for (int i = 0; i < 6; i++)
        corners[i / 2][i % 2] = (number[i] % (uint32_t)(size[i % 2] * 256)) / 256.0;
    for (int c = 0; c < 3; c++)
        colour[c] = (float)(number[6 + c] % 1000) / 1000.0f;
    triangle_at(size, corners, (number[9] % 1000 + 1) / 1002.0, colour, 1, out);
}

// The least distance of a sample of the pixel from the lines of a triangle's edges.
static double edge_distance(const struct triangle_vertex v[3], const struct weft_pattern *pattern,
                            int x, int y)
{
    double least = INFINITY, at[3][2];
    for (int i = 0; i < 3; i++)
        for (int axis = 0; axis < 2; axis++)
            at[i][axis] = 0.5 * ((double)v[i].position[axis] + 1.0) * size[axis];
    for (int s = 0; s < pattern->count; s++) {
        const double p[2] = {x + 0.5 + pattern->position[s][0], y + 0.5 - pattern->position[s][1]};
        for (int i = 0; i < 3; i++) {
            const double *from = at[i], *to = at[(i + 1) % 3];
            const double along[2] = {to[0] - from[0], to[1] - from[1]};
            const double length = hypot(along[0], along[1]);
            least = fmin(least,
                         fabs((p[0] - from[0]) * along[1] - (p[1] - from[1]) * along[0]) / length);
        }
    }
    return least;
}

static double scene_distance(const struct triangle_vertex *v, int triangles,
                             const struct weft_pattern *pattern, int x, int y)
{
    double least = INFINITY;
    for (int i = 0; i < triangles; i++)
        least = fmin(least, edge_distance(v + 3 * i, pattern, x, y));
    return least;
}

static void find_pattern(weft_context *context, int count, struct weft_pattern *out)
{
    double device[WEFT_PATTERN_MAX][2];
    const int samples = weft_msaa_positions(context, count < 4 ? 1 : 4, device);
    assert_int_equal(weft_pattern_create(weft_pattern_params(.device = (const double(*)[2])device,
                                                             .device_count = samples,
                                                             .count = count, .log = &log_to_stderr),
                                         out),
                     WEFT_OK);
}

// With vertices that need no snapping, one depth and one colour each, the samples are the same
// ones, and so are the pictures; but for samples nearly on an edge: llvmpipe finds the sides on
// which samples of several lie with less than a thousandth of a pixel lost, those of one exactly.
static void test_snapped(void **state)
{
    static const int counts[] = {1, 4, 8, 16};
    enum { SCENES = 12 };
    static struct triangle_vertex vertices[SCENES * VERTICES];
    static picture a, c;
    static struct weft_pattern pattern;
    int compared = 0, differ = 0;
    uint32_t random = 3;
    struct triangles t;
    (void)state;
    if (!enter_and_ask(contexts[0]))
        skip();
    for (int i = 0; i < SCENES * TRIANGLES; i++)
        snapped_triangle(&random, &vertices[3 * i]);
    triangles_create(contexts[0], vertices, SCENES * VERTICES, &t);
    for (size_t n = 0; n < WEFT_COUNT(counts); n++) {
        weft_acaa *exact =
            create_acaa(contexts[0], (struct weft_acaa_params){.samples = counts[n], .range = 1.0});
        weft_acaa *moved = create_acaa(
            contexts[0], (struct weft_acaa_params){
                             .samples = counts[n], .form = WEFT_ACAA_JITTER, .range = 1.0});
        find_pattern(contexts[0], counts[n], &pattern);
        for (int s = 0; s < SCENES; s++) {
            t.first = s * VERTICES;
            t.count = VERTICES;
            run_acaa(exact, &t, a);
            run_acaa(moved, &t, c);
            for (int i = 0; i < PIXELS; i++) {
                compared++;
                // Means of floats and of integers of 2^28 and less, each rounded once.
                if (pixel_distance(a, c, i) <= 0x1p-23)
                    continue;
                differ++;
                assert_true(scene_distance(vertices + s * VERTICES, TRIANGLES, &pattern, i % WIDTH,
                                           i / WIDTH) <= 0x1p-10);
            }
        }
        weft_acaa_destroy(&exact);
        weft_acaa_destroy(&moved);
    }
    print_message("form jitter without snapping: %d of %d pixels differ, all with a sample within "
                  "1/1024 of a pixel of an edge\n",
                  differ, compared);
    assert_true(compared == 4 * SCENES * PIXELS && differ < compared / 1000);
    triangles_destroy(&t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_snapped),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
