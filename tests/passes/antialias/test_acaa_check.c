// SPDX-License-Identifier: BSD-3-Clause
// What the self-check finds: each planted fault, and coincident surfaces, for which each remedy
// shows what its words say.
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

enum { WIDTH = 31, HEIGHT = 23, PIXELS = WIDTH * HEIGHT, SAMPLES = 4 };

static const int size[2] = {WIDTH, HEIGHT};
static const double corners[3][2] = {{2.3, 1.7}, {28.9, 5.1}, {11.2, 21.6}};
static const float red[4] = {0.75f, 0.125f, 0.0f, 1.0f}, green[4] = {0.25f, 0.5f, 0.875f, 1.0f};
static struct picture picture;

// ---- coincident surfaces ------------------------------------------------------------------------

// How many samples of each pixel the first triangle has.
static void count_samples(struct triangles *t, int *out)
{
    struct samples samples;
    t->count = 3;
    samples_read(t, WIDTH, HEIGHT, SAMPLES, 24, identity_place, &samples);
    for (int i = 0; i < PIXELS; i++) {
        out[i] = 0;
        for (int k = 0; k < SAMPLES; k++)
            out[i] += samples_at(&samples, i % WIDTH, i / WIDTH, k)[3] > 0.0f;
    }
    samples_free(&samples);
    t->count = 0;
}

// What a pixel shows, in samples: of the first surface, the second and the background; n samples
// have both surfaces.
static void expect(enum weft_acaa_coincident remedy, int n, int out[3])
{
    out[0] = n;
    out[1] = 0;
    out[2] = SAMPLES - n;
    if (remedy == WEFT_COINCIDENT_NONE) {
        out[1] = n;
    } else if (remedy == WEFT_COINCIDENT_ALPHA) { // what there is room for
        out[1] = n < SAMPLES - n ? n : SAMPLES - n;
        out[2] = SAMPLES - out[0] - out[1];
    }
}

static void check_coincident(enum weft_acaa_coincident remedy, const int *covered)
{
    const bool counted_twice = remedy == WEFT_COINCIDENT_NONE || remedy == WEFT_COINCIDENT_ALPHA;
    int64_t both = 0;
    for (int i = 0; i < PIXELS; i++) {
        const int n = covered[i];
        int share[3];
        expect(remedy, n, share);
        for (int c = 0; c < 3; c++) {
            // All of them are exact in the scale and in floats.
            const double sum =
                share[0] * (double)red[c] + share[1] * (double)green[c] + share[2] * 0.5;
            picture_check_value(&picture, c, i % WIDTH, i / WIDTH, WIDTH, (float)(sum / SAMPLES));
        }
        both += n > 0;
        assert_true(picture.weight[i] == (float)(SAMPLES + (counted_twice ? n : 0)) / SAMPLES);
    }
    assert_int_equal(picture.report.less, 0);
    assert_int_equal(picture.report.more, counted_twice ? both : 0);
    assert_true(picture.report.largest == (counted_twice ? 1.0 : 0.0));
    assert_true(both > 100);
    if (counted_twice) {
        const int32_t *first = picture.report.first_more;
        assert_true(covered[first[1] * WIDTH + first[0]] > 0);
    }
}

// Two triangles in one place. The second one's vertices go round from another corner, but have the
// same depths at all samples, as they are flat. Of the claim mask the first one is seen on
// renderers that draw in order; elsewhere any, so that only its weights are asserted there.
static void test_coincident(void **state)
{
    int covered[PIXELS], pictures = 0;
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++) {
        struct triangle_vertex vertices[6];
        struct triangles triangles;
        if (!has_exact_forms(contexts[c]))
            continue;
        triangle_at(size, corners, 0.5, red, 1, vertices);
        triangle_at(size, corners, 0.5, green, 2, vertices + 3);
        triangles_create(contexts[c], vertices, 6, &triangles);
        count_samples(&triangles, covered);
        for (int r = 0; r < WEFT_COINCIDENT_COUNT; r++)
            for (int f = 0; f < 2; f++) {
                picture_draw(&triangles,
                             weft_acaa_params(.width = WIDTH, .height = HEIGHT,
                                              .form = exact_forms[f],
                                              .coincident = (enum weft_acaa_coincident)r,
                                              .background = {0.5, 0.5, 0.5, 0.5}),
                             &picture);
                if (r == WEFT_COINCIDENT_MASK && contexts[c]->info.hardware)
                    picture_check_weights(&picture, PIXELS);
                else
                    check_coincident((enum weft_acaa_coincident)r, covered);
                pictures++;
            }
        triangles_destroy(&triangles);
    }
    print_message("%d pictures of coincident surfaces\n", pictures);
}

// Surfaces that cut through each other at small angles, so that which one is nearest changes from
// pixel to pixel: where their depths are the same to the last bit, they count twice without a
// remedy; with one, never.
static void test_fighting(void **state)
{
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++) {
        enum { PAIRS = 40 };
        static struct triangle_vertex vertices[6 * PAIRS];
        struct triangles triangles;
        if (!has_exact_forms(contexts[c]))
            continue;
        for (int i = 0; i < PAIRS; i++) {
            const double at[3][2] = {{i % 8 * 4, i / 8 * 4.5},
                                     {i % 8 * 4 + 3.7, i / 8 * 4.5 + 0.2},
                                     {i % 8 * 4 + 0.4, i / 8 * 4.5 + 4.3}};
            triangle_at(size, at, 0.5, red, 1, vertices + 6 * i);
            triangle_at(size, at, 0.5, green, 2, vertices + 6 * i + 3);
            // Depths that differ by a few units of 2^-24 at one corner.
            vertices[6 * i + 3 + i % 3].position[2] += (float)(i - PAIRS / 2) * 0x1p-23f;
        }
        triangles_create(contexts[c], vertices, 6 * PAIRS, &triangles);
        for (int r = 0; r < WEFT_COINCIDENT_COUNT; r++) {
            picture_draw(&triangles,
                         weft_acaa_params(.width = WIDTH, .height = HEIGHT,
                                          .coincident = (enum weft_acaa_coincident)r),
                         &picture);
            assert_int_equal(picture.report.less, 0);
            if (r == WEFT_COINCIDENT_NONE || r == WEFT_COINCIDENT_ALPHA)
                assert_true(picture.report.more > 20);
            else
                picture_check_weights(&picture, PIXELS);
        }
        triangles_destroy(&triangles);
    }
}

// ---- faults -------------------------------------------------------------------------------------

static void offset_depths(const GladGLContext *gl, const struct weft_antialias_pass *pass)
{
    if (pass->stage == WEFT_STAGE_DEPTH) {
        gl->Enable(GL_POLYGON_OFFSET_FILL);
        gl->PolygonOffset(1.0f, 2.0f);
    }
}

static void offset_colours(const GladGLContext *gl, const struct weft_antialias_pass *pass)
{
    if (pass->stage == WEFT_STAGE_COLOUR) {
        gl->Enable(GL_POLYGON_OFFSET_FILL);
        gl->PolygonOffset(1.0f, 2.0f);
    }
}

static void offset_both(const GladGLContext *gl, const struct weft_antialias_pass *pass)
{
    (void)pass;
    gl->Enable(GL_POLYGON_OFFSET_FILL);
    gl->PolygonOffset(1.0f, 2.0f);
}

static void cover_by_alpha(const GladGLContext *gl, const struct weft_antialias_pass *pass)
{
    (void)pass;
    gl->Enable(GL_SAMPLE_ALPHA_TO_COVERAGE);
}

#define BEGIN "flat in vec4 flat_colour;\nflat in uint surface;\nvoid main()\n{\n"

static const char halves_discarded[] = BEGIN "    if (fract(gl_FragCoord.x * 0.25) < 0.5)\n"
                                             "        discard;\n"
                                             "    weft_write(flat_colour, surface);\n}\n";
static const char translucent[] =
    BEGIN "    weft_write(vec4(flat_colour.rgb * 0.6, 0.6), surface);\n}\n";
static const char with_depth[] = BEGIN "    gl_FragDepth = gl_FragCoord.z + 0.001;\n"
                                       "    weft_write(flat_colour, surface);\n}\n";

struct fault {
    const char *name;
    const char *depth, *colour, *moved_depth, *moved_colour;
    void (*before)(const GladGLContext *, const struct weft_antialias_pass *);
    bool is_found;
};

static const struct fault faults[] = {
    {"none", .is_found = false},
    {"discard", .colour = halves_discarded, .is_found = true},
    {"discard in both", .depth = halves_discarded, .colour = halves_discarded, .is_found = false},
    {"alpha to coverage", .colour = translucent, .before = cover_by_alpha, .is_found = true},
    {"alpha", .colour = translucent, .is_found = true},
    {"polygon offset of depths", .before = offset_depths, .is_found = true},
    {"polygon offset of colours", .before = offset_colours, .is_found = true},
    {"polygon offset of both", .before = offset_both, .is_found = false},
    {"depths moved by 2^-22", .moved_depth = "gl_Position.z += 4.7683716e-7;", .is_found = true},
    {"a shader that moves", .moved_colour = "gl_Position.z *= 1.0001;", .is_found = true},
    {"another order of operations",
     .moved_colour = "gl_Position.xyz += 0.37; gl_Position.xyz -= 0.3700001;", .is_found = true},
    {"depth by a shader", .depth = with_depth, .colour = with_depth, .is_found = true},
};

// Where less is counted, the background fills it up; nothing is brighter than without the fault.
static void check_fault(const struct fault *fault, const struct picture *sound)
{
    const struct weft_acaa_report *r = &picture.report;
    int64_t less = 0;
    if (!fault->is_found) {
        picture_check_weights(&picture, PIXELS);
        return;
    }
    if (r->less == 0)
        fail_msg("%s is not found", fault->name);
    assert_int_equal(r->more, 0);
    assert_true(r->largest > 0.0 && r->largest <= 1.0);
    for (int i = 0; i < PIXELS; i++) {
        if (picture.weight[i] == 1.0f)
            continue;
        assert_true(picture.weight[i] < 1.0f);
        if (less++ == 0) {
            assert_int_equal(r->first_less[0], i % WIDTH);
            assert_int_equal(r->first_less[1], i / WIDTH);
        }
        assert_true(picture.channel[3][i] <= sound->channel[3][i]);
    }
    assert_int_equal(less, r->less);
}

// Slanted triangles, so that polygon offset has slopes.
static void slant(struct triangle_vertex *vertices)
{
    for (int i = 0; i < 3; i++)
        vertices[i].position[2] = -0.5f + 0.31f * (float)i;
}

static void test_faults(void **state)
{
    static struct picture sound, first;
    int found = 0, clean = 0;
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++) {
        struct triangle_vertex vertices[3];
        struct triangles triangles;
        if (!has_exact_forms(contexts[c]))
            continue;
        triangle_at(size, corners, 0.5, red, 1, vertices);
        slant(vertices);
        triangles_create(contexts[c], vertices, 3, &triangles);
        for (size_t i = 0; i < WEFT_COUNT(faults); i++)
            for (int f = 0; f < 2; f++) {
                triangles.fragment[WEFT_STAGE_DEPTH] = faults[i].depth;
                triangles.fragment[WEFT_STAGE_COLOUR] = faults[i].colour;
                triangles.moved[WEFT_STAGE_DEPTH] = faults[i].moved_depth;
                triangles.moved[WEFT_STAGE_COLOUR] = faults[i].moved_colour;
                triangles.before = faults[i].before;
                picture_draw(
                    &triangles,
                    weft_acaa_params(.width = WIDTH, .height = HEIGHT, .form = exact_forms[f]),
                    &picture);
                if (i == 0)
                    sound = picture;
                check_fault(&faults[i], &sound);
                // What is wrong is so in the same bytes.
                if (f == 0)
                    first = picture;
                else
                    assert_memory_equal(first.channel, picture.channel, sizeof first.channel);
                found += faults[i].is_found;
                clean += !faults[i].is_found;
            }
        triangles_destroy(&triangles);
    }
    print_message("%d pictures with a fault that is found, %d without\n", found, clean);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_coincident),
        cmocka_unit_test(test_fighting),
        cmocka_unit_test(test_faults),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
