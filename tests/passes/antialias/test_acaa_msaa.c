// SPDX-License-Identifier: BSD-3-Clause
// Accumulative anti-aliasing against multisampling on many random scenes: both forms have the bytes
// of the exact sum of MSAA's samples, and GL's own resolve is within a code of them. Several passes
// and wide filters against sums of moved pictures. WEFT_ACAA_SCENES: how many scenes.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>

#include "tests/support/contexts.h"
#include "tests/passes/antialias/small_pictures.h"
#include "passes/accumulate/sums/wide.h"
#include "passes/antialias/multisample.h"

static const float hdr = 48.0f;

// Colours at the middle of a pixel that a triangle hardly covers lie far beyond those of its
// corners: they are cut off at what scenes of theirs have.
#define SMOOTH(low, high)                                                                          \
    "in vec4 smooth_colour;\n"                                                                     \
    "flat in uint surface;\n"                                                                      \
    "void main()\n"                                                                                \
    "{\n"                                                                                          \
    "    vec3 colour = clamp(WEFT_AT(smooth_colour).rgb, " low ", " high ");\n"                    \
    "    weft_write(vec4(colour, 1.0), surface);\n"                                                \
    "}\n"
static const char smooth[] = SMOOTH("0.0", "1.0"), smooth_hdr[] = SMOOTH("-48.0", "48.0");

// ---- scenes -------------------------------------------------------------------------------------

// A corner on the middle of another triangle's edge, two corners that others have, another
// triangle again in another colour, from another corner on, and turned about.
static void join_triangles(struct triangle_vertex *v)
{
    for (int c = 0; c < 4; c++)
        v[3].position[c] = 0.5f * (v[0].position[c] + v[1].position[c]);
    v[6].position[3] = v[0].position[3];
    memcpy(v[6].position, v[0].position, sizeof v[6].position);
    memcpy(v[7].position, v[2].position, sizeof v[7].position);
    for (int i = 0; i < 3; i++) {
        memcpy(v[9 + i].position, v[i].position, sizeof v[i].position);
        memcpy(v[12 + i].position, v[15 + (i + 1) % 3].position, sizeof v[i].position);
        memcpy(v[18 + i].position, v[21 + (3 - i) % 3].position, sizeof v[i].position);
    }
}

// Scenes in turn with colours to 1 and beyond.
static bool is_hdr(int scene)
{
    return scene % 4 >= 2;
}

static struct triangle_vertex *make_scenes(int count, uint32_t seed)
{
    struct triangle_vertex *vertices = malloc((size_t)count * VERTICES * sizeof *vertices);
    assert_non_null(vertices);
    for (int s = 0; s < count; s++) {
        struct triangle_vertex *v = vertices + (size_t)s * VERTICES;
        samples_scene(seed + (uint32_t)s, size, TRIANGLES, is_hdr(s) ? hdr : 1.0f, v);
        join_triangles(v);
    }
    return vertices;
}

// Scene s of those: interpolated colours in half of them.
static void choose_scene(struct triangles *t, int s)
{
    t->first = s * VERTICES;
    t->count = VERTICES;
    t->fragment[WEFT_STAGE_COLOUR] = s % 2 ? triangles_flat : is_hdr(s) ? smooth_hdr : smooth;
}

// ---- one pass -----------------------------------------------------------------------------------

static weft_msaa *create_msaa(weft_context *context, struct weft_msaa_params params)
{
    weft_msaa *msaa;
    params.width = WIDTH;
    params.height = HEIGHT;
    memcpy(params.background, background, sizeof background);
    params.context = context;
    params.log = &log_to_stderr;
    assert_int_equal(weft_msaa_create(&params, &msaa), WEFT_OK);
    return msaa;
}

static void run_msaa(weft_msaa *msaa, struct triangles *t, picture out)
{
    assert_int_equal(weft_msaa_run(msaa, triangles_drawing(t)), WEFT_OK);
    for (int c = 0; c < 4; c++)
        assert_int_equal(weft_msaa_read(msaa, c, out[c], 0), WEFT_OK);
}

// What scenes of one range of colours are drawn with.
struct ways {
    weft_acaa *acaa[2]; // by both forms
    weft_msaa *sum, *blit_floats, *blit_codes;
};

static void create_ways(weft_context *context, float range, struct ways *out)
{
    static const enum weft_acaa_form forms[] = {WEFT_ACAA_POST_DEPTH, WEFT_ACAA_SAMPLE_ID};
    for (int f = 0; f < 2; f++)
        out->acaa[f] = create_acaa(
            context, (struct weft_acaa_params){.form = forms[f], .range = (double)range});
    out->sum = create_msaa(context, (struct weft_msaa_params){.format = WEFT_ANTIALIAS_RGBA32F,
                                                              .resolve = WEFT_MSAA_SUM,
                                                              .range = (double)range});
    out->blit_floats =
        create_msaa(context, (struct weft_msaa_params){.format = WEFT_ANTIALIAS_RGBA32F});
    out->blit_codes = create_msaa(context, (struct weft_msaa_params){0});
}

static void destroy_ways(struct ways *ways)
{
    for (int f = 0; f < 2; f++)
        weft_acaa_destroy(&ways->acaa[f]);
    weft_msaa_destroy(&ways->sum);
    weft_msaa_destroy(&ways->blit_floats);
    weft_msaa_destroy(&ways->blit_codes);
}

struct found {
    int scenes, mixed; // of pixels neither of one colour nor background
    double codes, floats;
};

static void check_scene(struct ways *ways, struct triangles *t, int scene, struct found *found)
{
    static picture sum, acaa, blit;
    run_msaa(ways->sum, t, sum);
    for (int f = 0; f < 2; f++) {
        struct weft_acaa_report report;
        struct weft_msaa_report msaa;
        run_acaa(ways->acaa[f], t, acaa);
        weft_acaa_get_report(ways->acaa[f], &report);
        weft_msaa_get_report(ways->sum, &msaa);
        assert_true(report.scale == msaa.scale && report.samples == msaa.samples);
        assert_int_equal(report.redone, 0);
        assert_int_equal(report.less + report.more, 0);
        if (memcmp(sum, acaa, sizeof sum) != 0)
            fail_msg("scene %d, form %s: %g from the sum of MSAA's samples", scene,
                     weft_acaa_form_names[report.form], distance(sum, acaa));
    }
    run_msaa(ways->blit_floats, t, blit);
    found->floats = larger(found->floats, distance(acaa, blit) / (is_hdr(scene) ? hdr : 1.0f));
    if (!is_hdr(scene)) {
        run_msaa(ways->blit_codes, t, blit);
        found->codes = larger(found->codes, 255.0 * distance(acaa, blit));
    }
    found->mixed += count_mixed(acaa);
    found->scenes++;
}

static void check_scenes(weft_context *context, int first, int count, struct found *found)
{
    struct triangle_vertex *vertices = make_scenes(count, (uint32_t)first);
    struct triangles t;
    struct ways ways[2];
    triangles_create(context, vertices, count * VERTICES, &t);
    create_ways(context, 1.0f, &ways[0]);
    create_ways(context, hdr, &ways[1]);
    for (int s = 0; s < count; s++) {
        choose_scene(&t, s);
        check_scene(&ways[is_hdr(s)], &t, s, found);
    }
    destroy_ways(&ways[0]);
    destroy_ways(&ways[1]);
    triangles_destroy(&t);
    free(vertices);
}

static void test_scenes(void **state)
{
    const char *text = getenv("WEFT_ACAA_SCENES");
    const int count = text ? atoi(text) : 1000;
    struct found found = {0};
    (void)state;
    for (int c = 0; c < 2; c++) {
        const int each = contexts[1] ? count / 2 : count;
        if (enter_and_ask(contexts[c]))
            check_scenes(contexts[c], c * each, each, &found);
        else
            print_message("[  SKIPPED ] a context without post-depth coverage\n");
    }
    print_message("%d scenes, %d pixels partly covered: difference 0 from the sum of MSAA's "
                  "samples; GL's resolve: %.3f codes of 8 bits, %g of floats' range\n",
                  found.scenes, found.mixed, found.codes, found.floats);
    assert_true(found.scenes == 0 || found.mixed > 10 * found.scenes);
    assert_true(found.codes <= 1.0 + 1e-5);
    // Three additions and a multiplication of floats.
    assert_true(found.floats <= 4.0 * 0x1p-24);
}

// The check finds what differs: the same surfaces without a remedy, in the pixels that the weights
// tell of and no others.
static void test_counted_twice(void **state)
{
    enum { SCENES = 8 };
    static picture sum, acaa;
    static float weight[PIXELS];
    int differ = 0;
    (void)state;
    if (!enter_and_ask(contexts[0]))
        skip();
    struct triangle_vertex *vertices = make_scenes(SCENES, 99);
    struct triangles t;
    triangles_create(contexts[0], vertices, SCENES * VERTICES, &t);
    for (int f = 0; f < 2; f++) {
        weft_acaa *a =
            create_acaa(contexts[0], (struct weft_acaa_params){.form = f ? WEFT_ACAA_SAMPLE_ID
                                                                         : WEFT_ACAA_POST_DEPTH,
                                                               .coincident = WEFT_COINCIDENT_NONE,
                                                               .range = 4.0 * (double)hdr});
        weft_msaa *m =
            create_msaa(contexts[0], (struct weft_msaa_params){.format = WEFT_ANTIALIAS_RGBA32F,
                                                               .resolve = WEFT_MSAA_SUM,
                                                               .range = 4.0 * (double)hdr});
        for (int s = 0; s < SCENES; s++) {
            choose_scene(&t, s);
            run_msaa(m, &t, sum);
            run_acaa(a, &t, acaa);
            assert_int_equal(weft_acaa_read_weight(a, weight, 0), WEFT_OK);
            for (int i = 0; i < PIXELS; i++)
                for (int c = 0; c < 3; c++)
                    // Sums of more than the total have a coarser scale.
                    if (fabs((double)acaa[c][i] - (double)sum[c][i]) > 1e-4) {
                        assert_true(weight[i] > 1.0f);
                        differ++;
                    }
        }
        weft_msaa_destroy(&m);
        weft_acaa_destroy(&a);
    }
    assert_true(differ > 100);
    triangles_destroy(&t);
    free(vertices);
}

// A range that is found while drawing: the same as MSAA's sum of that range.
static void test_found_range(void **state)
{
    enum { SCENES = 8 };
    static picture sum, acaa;
    int redone = 0;
    (void)state;
    if (!enter_and_ask(contexts[0]))
        skip();
    struct triangle_vertex *vertices = make_scenes(SCENES, 77);
    struct triangles t;
    triangles_create(contexts[0], vertices, SCENES * VERTICES, &t);
    for (int s = 0; s < SCENES; s++) {
        struct weft_acaa_report report;
        weft_acaa *a = create_acaa(contexts[0], (struct weft_acaa_params){0});
        choose_scene(&t, s);
        run_acaa(a, &t, acaa);
        weft_acaa_get_report(a, &report);
        assert_int_equal(report.redone, is_hdr(s));
        redone += report.redone;
        weft_msaa *m =
            create_msaa(contexts[0], (struct weft_msaa_params){.format = WEFT_ANTIALIAS_RGBA32F,
                                                               .resolve = WEFT_MSAA_SUM,
                                                               .range = report.range});
        run_msaa(m, &t, sum);
        assert_memory_equal(sum, acaa, sizeof sum);
        weft_msaa_destroy(&m);
        weft_acaa_destroy(&a);
    }
    assert_int_equal(redone, SCENES / 2);
    triangles_destroy(&t);
    free(vertices);
}

// ---- several passes, wide filters ---------------------------------------------------------------

struct reference {
    struct weft_pattern pattern;
    struct weft_spread spread;
    int rim;                                  // of the pictures
    struct samples samples[WEFT_PATTERN_MAX]; // of each pass
};

static void make_reference(struct triangles *t, int count, const struct weft_kernel *filter,
                           struct reference *out)
{
    double device[WEFT_PATTERN_MAX][2];
    assert_int_equal(weft_msaa_positions(t->context, 4, device), 4);
    assert_int_equal(weft_pattern_create(weft_pattern_params(.device = (const double(*)[2])device,
                                                             .device_count = 4, .count = count,
                                                             .log = &log_to_stderr),
                                         &out->pattern),
                     WEFT_OK);
    assert_int_equal(
        weft_spread_create(weft_spread_params(.position = (const double(*)[2])out->pattern.position,
                                              .count = count, .filter = *filter, .bits = 24,
                                              .log = &log_to_stderr),
                           &out->spread),
        WEFT_OK);
    // Samples that moves carry over a rim need a pixel more.
    out->rim = out->spread.radius + (out->pattern.passes > 1);
    for (int pass = 0; pass < out->pattern.passes; pass++) {
        double place[16];
        weft_drawing_place(WIDTH, HEIGHT, out->rim, out->pattern.offset[pass], place);
        samples_read(t, WIDTH + 2 * out->rim, HEIGHT + 2 * out->rim, 4, 24, place,
                     &out->samples[pass]);
    }
}

static void free_reference(struct reference *r)
{
    for (int pass = 0; pass < r->pattern.passes; pass++)
        samples_free(&r->samples[pass]);
    weft_spread_clear(&r->spread);
}

// Pixel (x, y), rows upwards: of integers by integer weights, and of colours by real ones.
static void sum_pixel(const struct reference *r, int x, int y, int channel, double scale,
                      float *exact, double *real)
{
    const struct weft_spread *s = &r->spread;
    const int side = 2 * s->radius + 1;
    weft_wide sum = 0;
    *real = 0.0;
    for (int down = -s->radius; down <= s->radius; down++)
        for (int right = -s->radius; right <= s->radius; right++)
            for (int i = 0; i < s->count; i++) {
                // What the pixel that lies (-right, -down) of this one gives to it; that pixel's
                // sample was drawn in the one before by `pixel`.
                const int16_t *p = r->pattern.pixel[i];
                const float *value = samples_at(&r->samples[i / 4], x - right - p[0] + r->rim,
                                                y + down + p[1] + r->rim, i % 4);
                const double colour =
                    value[3] > 0.0f ? (double)value[channel] : background[channel];
                const size_t at =
                    (size_t)((down + s->radius) * side + right + s->radius) * (size_t)s->count +
                    (size_t)i;
                sum += (weft_wide)s->integer[at] * llrint(colour * scale);
                *real += s->weight[at] * colour;
            }
    *exact = weft_wide_quotient(sum, s->total) / (float)scale;
}

static void check_passes(weft_acaa *acaa, struct triangles *t, const struct reference *r)
{
    static picture drawn;
    struct weft_acaa_report report;
    double largest = 0.0;
    run_acaa(acaa, t, drawn);
    weft_acaa_get_report(acaa, &report);
    assert_int_equal(report.passes, r->pattern.passes);
    assert_int_equal(report.radius, r->spread.radius);
    assert_int_equal(report.less + report.more, 0);
    assert_near(report.discrepancy, r->pattern.discrepancy, 1e-12, "discrepancy");
    for (int c = 0; c < 4; c++)
        for (int y = 0; y < HEIGHT; y++)
            for (int x = 0; x < WIDTH; x++) {
                float exact;
                double real;
                sum_pixel(r, x, y, c, report.scale, &exact, &real);
                if (drawn[c][y * WIDTH + x] != exact)
                    fail_msg("%d samples, channel %d at (%d, %d): %.9g instead of %.9g",
                             report.samples, c, x, y, (double)drawn[c][y * WIDTH + x],
                             (double)exact);
                largest = larger(largest, fabs((double)exact - real));
            }
    assert_true(largest <= report.bound);
}

static void test_passes(void **state)
{
    static const struct {
        int count;
        const char *filter;
    } cases[] = {{8, "nearest"},   {16, "nearest"},  {64, "nearest"},
                 {4, "lanczos:3"}, {16, "mitchell"}, {4, "gaussian"}};
    enum { SCENES = 4 };
    struct triangle_vertex *vertices = make_scenes(SCENES, 4711);
    int compared = 0;
    (void)state;
    for (int c = 0; c < 2; c++) {
        struct triangles t;
        if (!enter_and_ask(contexts[c]))
            continue;
        triangles_create(contexts[c], vertices, SCENES * VERTICES, &t);
        for (size_t i = 0; i < WEFT_COUNT(cases); i++) {
            static struct reference reference;
            const struct weft_kernel filter = kernel_named(cases[i].filter);
            const int scene = (int)(i % SCENES);
            choose_scene(&t, scene);
            make_reference(&t, cases[i].count, &filter, &reference);
            for (int f = 0; f < 2; f++) {
                weft_acaa *acaa = create_acaa(
                    contexts[c], (struct weft_acaa_params){
                                     .samples = cases[i].count,
                                     .form = f ? WEFT_ACAA_SAMPLE_ID : WEFT_ACAA_POST_DEPTH,
                                     .filter = filter,
                                     .range = is_hdr(scene) ? (double)hdr : 1.0,
                                 });
                check_passes(acaa, &t, &reference);
                weft_acaa_destroy(&acaa);
                compared++;
            }
            free_reference(&reference);
        }
        triangles_destroy(&t);
    }
    print_message("%d pictures of several passes or wide filters have the bytes of their sums\n",
                  compared);
    free(vertices);
}

// ---- bytes --------------------------------------------------------------------------------------

// GL's own sizes: half or less of what MSAA takes with colours of 32 bits; more than half of it
// with halves and codes, at four samples.
static void test_bytes(void **state)
{
    (void)state;
    for (int c = 0; c < 2; c++) {
        if (!enter_and_ask(contexts[c]))
            continue;
        struct weft_acaa_report report;
        weft_acaa *acaa = create_acaa(contexts[c], (struct weft_acaa_params){0});
        weft_acaa_get_report(acaa, &report);
        weft_acaa_destroy(&acaa);
        // Depths, and sums of four words; beside them a table that does not grow with the picture.
        assert_int_equal(report.formula_bytes, PIXELS * (4 * 4 + 4 * 4));
        assert_true(report.bytes >= report.formula_bytes &&
                    report.bytes < report.formula_bytes + 256);
        for (int format = 0; format < WEFT_ANTIALIAS_FORMAT_COUNT; format++) {
            struct weft_msaa_report msaa;
            weft_msaa *m = create_msaa(
                contexts[c],
                (struct weft_msaa_params){.format = (enum weft_antialias_format)format});
            weft_msaa_get_report(m, &msaa);
            weft_msaa_destroy(&m);
            const double share = (double)report.bytes / (double)msaa.bytes;
            print_message("%s: %.1f bytes a pixel instead of %.1f: %.0f %%\n",
                          weft_antialias_format_names[format], (double)report.bytes / PIXELS,
                          (double)msaa.bytes / PIXELS, 100.0 * share);
            assert_int_equal(share <= 0.5, format == WEFT_ANTIALIAS_RGBA32F);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_scenes),      cmocka_unit_test(test_counted_twice),
        cmocka_unit_test(test_found_range), cmocka_unit_test(test_passes),
        cmocka_unit_test(test_bytes),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
