// SPDX-License-Identifier: BSD-3-Clause
// What sums hold: colours beyond the range are found and drawn again, with the same values as if
// the range had been known; excess weights; what is not finite. And what else can come: odd
// geometry, callbacks that fail, bytes.
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
#include "passes/gl/context_backend.h"

enum { WIDTH = 29, HEIGHT = 13, PIXELS = WIDTH * HEIGHT, TRIANGLES = 30 };

static const int size[2] = {WIDTH, HEIGHT};
static struct triangle_vertex vertices[3 * TRIANGLES];

static void check_samples(struct triangles *triangles, const struct picture *picture)
{
    struct samples samples;
    samples_read(triangles, WIDTH, HEIGHT, 4, 24, identity_place, &samples);
    for (int i = 0; i < PIXELS; i++)
        for (int c = 0; c < 3; c++) {
            double sum = 0.0;
            for (int k = 0; k < 4; k++)
                sum += nearbyint(samples_at(&samples, i % WIDTH, i / WIDTH, k)[c] *
                                 picture->report.scale);
            picture_check_value(picture, c, i % WIDTH, i / WIDTH, WIDTH,
                                (float)(sum / 4.0 / picture->report.scale));
        }
    samples_free(&samples);
}

#define PARAMS(...)                                                                                \
    weft_acaa_params(.width = WIDTH, .height = HEIGHT, .context = triangles->context,              \
                     .log = &log_to_stderr, __VA_ARGS__)

// Ranges: found (1 at first, then the last one's), given too small, given large enough.
static void check_ranges(struct triangles *triangles, float brightest)
{
    static struct picture first, second, given;
    weft_acaa *acaa;
    assert_int_equal(weft_acaa_create(PARAMS(.form = WEFT_ACAA_AUTO), &acaa), WEFT_OK);
    picture_next(acaa, triangles, &first);
    picture_next(acaa, triangles, &second);
    weft_acaa_destroy(&acaa);
    assert_int_equal(first.report.redone, brightest > 1.0f);
    assert_int_equal(second.report.redone, 0);
    assert_true(first.report.range >= (double)brightest * 0.5 && first.report.scale > 0.0);
    assert_int_equal(first.report.callbacks, brightest > 1.0f ? 4 : 2);
    assert_int_equal(second.report.callbacks, first.report.callbacks + 2);
    picture_check_weights(&first, PIXELS);
    check_samples(triangles, &first);
    assert_memory_equal(first.channel, second.channel, sizeof first.channel);
    picture_draw(triangles, PARAMS(.range = first.report.range), &given);
    assert_int_equal(given.report.redone, 0);
    assert_memory_equal(first.channel, given.channel, sizeof first.channel);
    picture_draw(triangles, PARAMS(.range = 1e-3), &given);
    assert_int_equal(given.report.redone, 1);
    check_samples(triangles, &given);
}

static void test_ranges(void **state)
{
    static const float ranges[] = {0.5f, 3000.0f, 1e30f};
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++) {
        if (!has_exact_forms(contexts[c]))
            continue;
        for (size_t i = c; i < WEFT_COUNT(ranges); i++) {
            struct triangles triangles;
            samples_scene(7 + (uint32_t)i, size, TRIANGLES, ranges[i], vertices);
            for (int k = 0; k < 3 * TRIANGLES; k += 2) // below 0, too
                vertices[k].colour[1] *= -1.0f;
            triangles_create(contexts[c], vertices, 3 * TRIANGLES, &triangles);
            check_ranges(&triangles, ranges[i]);
            triangles_destroy(&triangles);
        }
    }
}

// Twenty surfaces in one place, counted twenty times: more than integers of the range would hold.
static void test_excess(void **state)
{
    enum { LAYERS = 20 };
    static const double corner[3][2] = {{-40, -40}, {90, -20}, {-10, 99}};
    static const float colour[4] = {1.0f, -1.0f, 0.5f, 1.0f};
    static struct picture picture;
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++) {
        struct triangles triangles;
        if (!has_exact_forms(contexts[c]))
            continue;
        for (int i = 0; i < LAYERS; i++)
            triangle_at(size, corner, 0.25, colour, 1, vertices + 3 * i);
        triangles_create(contexts[c], vertices, 3 * LAYERS, &triangles);
        for (int floats = 0; floats < 2; floats++) {
            picture_draw(&triangles,
                         weft_acaa_params(.width = WIDTH, .height = HEIGHT,
                                          .coincident = WEFT_COINCIDENT_NONE,
                                          .sums = (enum weft_acaa_sums)floats),
                         &picture);
            assert_int_equal(picture.report.redone, !floats);
            assert_int_equal(picture.report.more, PIXELS);
            assert_true(picture.report.largest == LAYERS - 1.0);
            for (int i = 0; i < PIXELS; i++) {
                for (int k = 0; k < 3; k++)
                    assert_true(picture.channel[k][i] == LAYERS * colour[k]);
                assert_true(picture.weight[i] == (float)LAYERS);
            }
        }
        triangles_destroy(&triangles);
    }
}

// ---- what is refused ----------------------------------------------------------------------------

static const char not_finite[] = "flat in uint surface;\n"
                                 "void main()\n"
                                 "{\n"
                                 "    float bad = uintBitsToFloat(BITS);\n"
                                 "    weft_write(vec4(0.0, gl_FragCoord.x < 4.0 ? bad : 0.5, 0.0, "
                                 "1.0), surface);\n"
                                 "}\n";

static void check_refused(struct triangles *triangles, enum weft_acaa_sums sums,
                          const char *fragment, enum weft_result expected)
{
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    struct weft_acaa_params params = *PARAMS(.sums = sums);
    float pixel[PIXELS];
    weft_acaa *acaa;
    params.log = &log;
    assert_int_equal(weft_acaa_create(&params, &acaa), WEFT_OK);
    triangles->fragment[WEFT_STAGE_COLOUR] = fragment;
    assert_int_equal(weft_acaa_run(acaa, triangles_drawing(triangles), NULL), expected);
    assert_int_equal(message.count, 1);
    assert_int_equal(weft_acaa_read(acaa, 0, pixel, 0), WEFT_ERR_ARGUMENT);
    assert_int_equal(weft_acaa_read_weight(acaa, pixel, 0), WEFT_ERR_ARGUMENT);
    // The next one is as good as ever.
    triangles->fragment[WEFT_STAGE_COLOUR] = NULL;
    assert_int_equal(weft_acaa_run(acaa, triangles_drawing(triangles), NULL), WEFT_OK);
    assert_int_equal(weft_acaa_read(acaa, 0, pixel, 0), WEFT_OK);
    assert_int_equal(weft_acaa_read(acaa, 4, pixel, 0), WEFT_ERR_ARGUMENT);
    weft_acaa_destroy(&acaa);
}

static void test_refused(void **state)
{
    static const char *const bits[] = {"0x7fc00000u", "0xff800000u", "0x7f000000u"};
    char fragment[sizeof not_finite + 64];
    (void)state;
    if (!has_exact_forms(contexts[0]))
        return;
    struct triangles triangles;
    samples_scene(3, size, TRIANGLES, 1.0f, vertices);
    triangles_create(contexts[0], vertices, 3 * TRIANGLES, &triangles);
    for (int sums = 0; sums < 2; sums++)
        for (size_t i = 0; i < WEFT_COUNT(bits); i++) {
            snprintf(fragment, sizeof fragment, "#define BITS %s\n%s", bits[i], not_finite);
            if (i < 2)
                check_refused(&triangles, (enum weft_acaa_sums)sums, fragment, WEFT_ERR_FORMAT);
            else if (sums == WEFT_ACAA_FLOAT) // four of them are no float
                check_refused(&triangles, WEFT_ACAA_FLOAT, fragment, WEFT_ERR_LIMIT);
        }
    triangles_destroy(&triangles);
}

static bool stop_at_half(void *priv, double fraction)
{
    double *last = priv;
    assert_true(fraction >= *last);
    *last = fraction;
    return fraction < 0.5;
}

static void leave_an_error(const GladGLContext *gl, const struct weft_antialias_pass *pass)
{
    (void)pass;
    gl->Enable(GL_TEXTURE0);
}

static void test_callbacks(void **state)
{
    (void)state;
    if (!has_exact_forms(contexts[0]))
        return;
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    struct triangles store, *triangles = &store;
    double last = 0.0;
    weft_acaa *acaa;
    samples_scene(3, size, TRIANGLES, 1.0f, vertices);
    triangles_create(contexts[0], vertices, 3 * TRIANGLES, triangles);
    struct weft_acaa_params params = *PARAMS(.samples = 16);
    params.log = &log;
    assert_int_equal(weft_acaa_create(&params, &acaa), WEFT_OK);
    triangles->result = WEFT_ERR_OPEN;
    assert_int_equal(weft_acaa_run(acaa, triangles_drawing(triangles), NULL), WEFT_ERR_OPEN);
    assert_int_equal(triangles->calls[WEFT_STAGE_DEPTH], 1);
    assert_int_equal(triangles->calls[WEFT_STAGE_COLOUR], 0);
    triangles->result = WEFT_OK;
    triangles->after = leave_an_error;
    assert_int_equal(weft_acaa_run(acaa, triangles_drawing(triangles), NULL), WEFT_ERR_GL);
    triangles->after = NULL;
    const struct weft_progress progress = {stop_at_half, &last};
    assert_int_equal(weft_acaa_run(acaa, triangles_drawing(triangles), &progress),
                     WEFT_ERR_CANCELLED);
    assert_true(last == 0.5);
    assert_int_equal(weft_acaa_run(acaa, triangles_drawing(triangles), NULL), WEFT_OK);
    weft_acaa_destroy(&acaa);
    triangles_destroy(triangles);
}

// ---- odd geometry -------------------------------------------------------------------------------

// Many triangles meet in one point, some reach far outside, some behind the eye, and some lie at
// the far plane, where the background is. All of it shows what samples show, both forms alike.
static void test_geometry(void **state)
{
    enum { FAN = 20 };
    static struct picture picture[2];
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++) {
        struct triangles triangles;
        if (!has_exact_forms(contexts[c]))
            continue;
        samples_scene(11, size, TRIANGLES, 1.0f, vertices);
        for (int i = 0; i < TRIANGLES; i++) {
            struct triangle_vertex *v = vertices + 3 * i;
            if (i < FAN)
                for (int k = 0; k < 3; k++) {
                    const double angle = 6.2831853 * (i + k) / FAN;
                    v[k].position[0] = k == 2 ? 0.0137f : (float)cos(angle);
                    v[k].position[1] = k == 2 ? 0.0711f : (float)sin(angle);
                }
            else if (i % 3 == 0)
                v[i / 3 % 3].position[3] = -0.4f;
            else if (i % 3 == 1)
                v[0].position[0] = 3e4f;
            else
                v[0].position[2] = v[1].position[2] = v[2].position[2] = 1.0f;
        }
        triangles_create(contexts[c], vertices, 3 * TRIANGLES, &triangles);
        for (int f = 0; f < 2; f++) {
            picture_draw(&triangles,
                         weft_acaa_params(.width = WIDTH, .height = HEIGHT, .form = exact_forms[f]),
                         &picture[f]);
            picture_check_weights(&picture[f], PIXELS);
        }
        assert_memory_equal(picture[0].channel, picture[1].channel, sizeof picture[0].channel);
        triangles_destroy(&triangles);
    }
}

// ---- bytes --------------------------------------------------------------------------------------

// What GL says that it holds is the formula's, but for a table of a few hundred bytes.
static void test_bytes(void **state)
{
    static const struct {
        enum weft_acaa_coincident coincident;
        int samples, depth_bits, depth_bytes, words;
    } cases[] = {
        {WEFT_COINCIDENT_STENCIL, 4, 24, 4, 4}, {WEFT_COINCIDENT_STENCIL, 4, 32, 8, 4},
        {WEFT_COINCIDENT_MASK, 4, 32, 4, 5},    {WEFT_COINCIDENT_NONE, 4, 24, 4, 4},
        {WEFT_COINCIDENT_STENCIL, 1, 24, 4, 4},
    };
    (void)state;
    if (!has_exact_forms(contexts[0]))
        return;
    for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
        struct weft_acaa_report report;
        weft_acaa *acaa;
        assert_int_equal(
            weft_acaa_create(weft_acaa_params(.width = 64, .height = 64,
                                              .samples = cases[i].samples,
                                              .coincident = cases[i].coincident,
                                              .depth_bits = cases[i].depth_bits,
                                              .context = contexts[0], .log = &log_to_stderr),
                             &acaa),
            WEFT_OK);
        weft_acaa_get_report(acaa, &report);
        assert_int_equal(report.formula_bytes,
                         64 * 64 * (cases[i].samples * cases[i].depth_bytes + 4 * cases[i].words));
        assert_true(report.bytes >= report.formula_bytes &&
                    report.bytes < report.formula_bytes + 512);
        weft_acaa_destroy(&acaa);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_ranges),   cmocka_unit_test(test_excess),
        cmocka_unit_test(test_refused),  cmocka_unit_test(test_callbacks),
        cmocka_unit_test(test_geometry), cmocka_unit_test(test_bytes),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
