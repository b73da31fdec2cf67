// SPDX-License-Identifier: BSD-3-Clause
// Supersampling: pictures of marked pixels against those of all pixels, byte for byte, and those of
// all pixels against filtered samples in double, which are drawn apart.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "tests/support/common.h"
#include "tests/support/contexts.h"
#include "tests/passes/antialias/triangles.h"
#include "passes/antialias/drawing/run.h"
#include "passes/antialias/supersample.h"
#include "passes/gl/target.h"

enum { WIDTH = 37, HEIGHT = 29, PIXELS = WIDTH * HEIGHT, TRIANGLES = 40 };
static const int size[2] = {WIDTH, HEIGHT};
static const char *const kernels[] = {"nearest", "linear", "mitchell", "lanczos:2", "bspline3"};

static uint64_t state_of_random = 1;

static double random_number(void)
{
    state_of_random = state_of_random * 6364136223846793005u + 1442695040888963407u;
    return (double)(state_of_random >> 40) / (1 << 24);
}

// Triangles of any colour from 0 to `brightest`, some of them thin, some beyond the picture.
static void make_scene(weft_context *context, float brightest, struct triangles *out)
{
    static struct triangle_vertex vertices[3 * TRIANGLES];
    for (int i = 0; i < TRIANGLES; i++) {
        double corner[3][2];
        float colour[4] = {0.0f, 0.0f, 0.0f, 1.0f};
        const double x = 44.0 * random_number() - 4.0, y = 36.0 * random_number() - 4.0;
        for (int k = 0; k < 3; k++) {
            corner[k][0] = x + (i % 3 ? 12.0 : 60.0) * (random_number() - 0.5);
            corner[k][1] = y + (i % 2 ? 12.0 : 2.0) * (random_number() - 0.5);
            colour[k] = brightest * (float)random_number();
        }
        triangle_at(size, (const double(*)[2])corner, random_number(), colour, (uint32_t)i + 1,
                    &vertices[3 * i]);
    }
    triangles_create(context, vertices, 3 * TRIANGLES, out);
    out->fragment[WEFT_STAGE_COLOUR] = triangles_smooth;
}

static weft_supersample *create(struct weft_supersample_params params, weft_context *context)
{
    weft_supersample *s;
    params.width = WIDTH;
    params.height = HEIGHT;
    params.context = context;
    params.log = &log_to_stderr;
    assert_int_equal(weft_supersample_create(&params, &s), WEFT_OK);
    return s;
}

// What is left alone keeps these bits.
static const uint32_t untouched = 0x7fc12345u;

static void read_all(weft_supersample *s, float picture[4][PIXELS])
{
    for (int c = 0; c < 4; c++) {
        for (int i = 0; i < PIXELS; i++)
            memcpy(&picture[c][i], &untouched, sizeof untouched);
        assert_int_equal(weft_supersample_read(s, c, picture[c], 0), WEFT_OK);
    }
}

static void draw(const struct weft_supersample_params *params, struct triangles *t,
                 const struct weft_marks *marks, float picture[4][PIXELS],
                 struct weft_supersample_report *report)
{
    weft_supersample *s = create(*params, t->context);
    assert_int_equal(weft_supersample_run(s, triangles_drawing(t), marks, NULL), WEFT_OK);
    read_all(s, picture);
    weft_supersample_get_report(s, report);
    weft_supersample_destroy(&s);
    assert_null(s);
}

// ---- marked pixels ------------------------------------------------------------------------------

static void make_marks(double share, struct weft_marks *out)
{
    *out = (struct weft_marks){.width = WIDTH, .height = HEIGHT};
    out->marked = malloc(PIXELS);
    assert_non_null(out->marked);
    for (int i = 0; i < PIXELS; i++)
        out->count += out->marked[i] = random_number() < share;
}

// Whether a mark is within so many pixels of a place, which may lie outside of the picture.
static bool is_near(const struct weft_marks *marks, int x, int y, int reach)
{
    for (int v = y - reach; v <= y + reach; v++)
        for (int u = x - reach; u <= x + reach; u++)
            if (u >= 0 && v >= 0 && u < WIDTH && v < HEIGHT && marks->marked[v * WIDTH + u])
                return true;
    return false;
}

static int64_t count_near(const struct weft_marks *marks, int rim, int reach)
{
    int64_t count = 0;
    for (int y = -rim; y < HEIGHT + rim; y++)
        for (int x = -rim; x < WIDTH + rim; x++)
            count += is_near(marks, x, y, reach);
    return count;
}

// Returns how many pixels of the first picture are the second's, bit for bit, all four channels.
static int count_same(float a[4][PIXELS], float b[4][PIXELS], const struct weft_marks *marks,
                      int radius)
{
    int same = 0;
    for (int i = 0; i < PIXELS; i++) {
        const bool drawn = is_near(marks, i % WIDTH, i / WIDTH, radius);
        bool equal = true;
        for (int c = 0; c < 4; c++)
            equal =
                equal && memcmp(&a[c][i], drawn ? (void *)&b[c][i] : (void *)&untouched, 4) == 0;
        same += equal;
    }
    return same;
}

static void compare_stores(struct weft_supersample_params params, struct triangles *t, double share)
{
    static float full[4][PIXELS], sums[4][PIXELS], blocks[4][PIXELS];
    struct weft_supersample_report of_full, of_sums, of_blocks;
    struct weft_marks marks;
    make_marks(share, &marks);
    draw(&params, t, NULL, full, &of_full);
    t->calls[WEFT_STAGE_COLOUR] = 0;
    draw(&params, t, &marks, sums, &of_sums);
    params.store = WEFT_STORE_BLOCKS;
    draw(&params, t, &marks, blocks, &of_blocks);
    const int radius = of_full.radius;
    assert_int_equal(count_same(sums, full, &marks, radius), PIXELS);
    assert_int_equal(count_same(blocks, full, &marks, radius), PIXELS);
    assert_int_equal(of_full.pixels, PIXELS);
    assert_int_equal(of_full.sampled, (WIDTH + 2 * radius) * (HEIGHT + 2 * radius));
    assert_int_equal(of_sums.pixels, count_near(&marks, 0, radius));
    assert_int_equal(of_sums.sampled, count_near(&marks, radius, 2 * radius));
    assert_true(of_blocks.pixels == of_sums.pixels && of_blocks.sampled == of_sums.sampled);
    assert_int_equal(t->calls[WEFT_STAGE_COLOUR],
                     of_sums.pixels ? of_sums.passes + of_blocks.passes : 0);
    weft_marks_clear(&marks);
}

// Every byte of every pixel, in every format, for every kernel; on the second context each kernel
// in one of the formats.
static void test_marked(void **state)
{
    static const double shares[] = {0.0, 0.003, 0.05, 0.3, 1.0};
    int cases = 0;
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++) {
        for (int f = 0; f < WEFT_ANTIALIAS_FORMAT_COUNT; f++) {
            struct triangles t;
            make_scene(contexts[c], f == WEFT_ANTIALIAS_RGBA8 ? 1.0f : 9.0f, &t);
            for (size_t k = 0; k < WEFT_COUNT(kernels); k++) {
                if ((int)k % 3 != f && c == 1)
                    continue;
                const int side = 1 + cases % 4;
                compare_stores((struct weft_supersample_params){.filter = kernel_named(kernels[k]),
                                                                .count = side * side,
                                                                .format = f,
                                                                .background = {0.1, 0.2, 0.3, 1.0}},
                               &t, shares[cases % WEFT_COUNT(shares)]);
                cases++;
            }
            triangles_destroy(&t);
        }
    }
    assert_true(cases == 15 || cases == 20);
}

// Pictures of all pixels in blocks are the same, too, and those of one object are, one after
// another.
static void test_again(void **state)
{
    static float first[4][PIXELS], other[4][PIXELS];
    struct weft_supersample_report report;
    struct weft_supersample_params params = {.filter = kernel_named("mitchell"), .count = 4};
    struct triangles t;
    struct weft_marks marks;
    (void)state;
    make_scene(contexts[0], 1.0f, &t);
    make_marks(0.1, &marks);
    draw(&params, &t, NULL, first, &report);
    params.store = WEFT_STORE_BLOCKS;
    draw(&params, &t, NULL, other, &report);
    assert_memory_equal(first, other, sizeof first);
    for (int store = 0; store < WEFT_STORE_COUNT; store++) {
        params.store = store;
        weft_supersample *s = create(params, contexts[0]);
        for (int i = 0; i < 4; i++) {
            const struct weft_marks *drawn = i % 2 ? &marks : NULL;
            assert_int_equal(weft_supersample_run(s, triangles_drawing(&t), drawn, NULL), WEFT_OK);
            read_all(s, other);
            if (drawn)
                assert_int_equal(count_same(other, first, &marks, report.radius), PIXELS);
            else
                assert_memory_equal(first, other, sizeof first);
        }
        weft_supersample_destroy(&s);
    }
    weft_marks_clear(&marks);
    triangles_destroy(&t);
}

// ---- all pixels against samples that are drawn apart --------------------------------------------

enum { RIM = 3, WIDE = WIDTH + 2 * RIM, HIGH = HEIGHT + 2 * RIM };

// A sample's picture with a rim, as floats: the scene moved so that pixels' middles lie where the
// sample lies, x to the right and y down; of 8 bits the colours are codes.
static void draw_moved(struct triangles *t, enum weft_antialias_format format, int rim,
                       const double sample[2], const double background[4], float *out)
{
    static const GLenum formats[] = {GL_RGBA8, GL_RGBA16F, GL_RGBA32F};
    const GladGLContext *gl = &t->context->gl;
    struct weft_gl_target target;
    GLuint depth;
    struct weft_antialias_pass pass = {.stage = WEFT_STAGE_COLOUR,
                                       .width = WIDTH + 2 * rim,
                                       .height = HEIGHT + 2 * rim,
                                       .part = {0, 0, WIDTH + 2 * rim, HEIGHT + 2 * rim},
                                       .place = {[10] = 1.0, [15] = 1.0},
                                       .head = weft_head_colour(&t->context->gl, false)};
    // x of the target = x of the picture + rim - sample, in pixels; in clip coordinates that is
    // 2 x / width - 1, and in those of the picture likewise.
    pass.place[0] = (double)WIDTH / pass.width;
    pass.place[5] = (double)HEIGHT / pass.height;
    pass.place[12] = -2.0 * sample[0] / pass.width;
    pass.place[13] = 2.0 * sample[1] / pass.height;
    GLint vertex_array = 0;
    assert_int_equal(weft_context_enter(t->context), WEFT_OK);
    gl->GetIntegerv(GL_VERTEX_ARRAY_BINDING, &vertex_array);
    assert_int_equal(weft_gl_target_create(&log_to_stderr, gl, formats[format], pass.width,
                                           pass.height, &target),
                     WEFT_OK);
    gl->GenRenderbuffers(1, &depth);
    gl->BindRenderbuffer(GL_RENDERBUFFER, depth);
    gl->RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, pass.width, pass.height);
    gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth);
    gl->Viewport(0, 0, pass.width, pass.height);
    gl->Enable(GL_DEPTH_TEST);
    gl->ClearColor((float)background[0], (float)background[1], (float)background[2],
                   (float)background[3]);
    gl->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    assert_int_equal(triangles_draw(t, &pass), WEFT_OK);
    gl->ReadPixels(0, 0, pass.width, pass.height, GL_RGBA, GL_FLOAT, out);
    weft_gl_target_destroy(gl, &target);
    gl->DeleteRenderbuffers(1, &depth);
    weft_gl_reset_state(gl, (GLuint)vertex_array);
    weft_context_leave(t->context);
}

// h of a distance in pixels, [-r, r) being what a kernel with jumps at its rims covers.
static double weigh(const struct weft_kernel *kernel, double x)
{
    if (kernel->continuity < 0 && x == kernel->support)
        return weft_kernel_weight(kernel, nextafter(x, 0.0));
    return x == -kernel->support ? 0.0 : weft_kernel_weight(kernel, x);
}

// Adds sum h v of a sample, and sum h: a pixel P has h(P - S) of a sample S. Rows of both go up.
static void add_sample(const struct weft_kernel *kernel, int rim, const double sample[2],
                       const float *drawn, double (*sum)[4], double *weight)
{
    for (int i = 0; i < PIXELS; i++) {
        for (int v = -rim; v <= rim; v++)
            for (int u = -rim; u <= rim; u++) {
                const double h = weigh(kernel, -(u + sample[0])) * weigh(kernel, v - sample[1]);
                const float *from =
                    &drawn[4 * ((i / WIDTH + rim + v) * (WIDTH + 2 * rim) + i % WIDTH + rim + u)];
                for (int c = 0; c < 4; c++)
                    sum[i][c] += h * (double)from[c];
                *weight += i == 0 ? h : 0.0;
            }
    }
}

static double compare_reference(const struct weft_supersample_params *params, int count,
                                const double (*position)[2], struct triangles *t)
{
    static float picture[4][PIXELS], drawn[4 * WIDE * HIGH];
    static double sum[PIXELS][4];
    struct weft_supersample_report report;
    double weight = 0.0, largest = 0.0, worst = 0.0;
    memset(sum, 0, sizeof sum);
    draw(params, t, NULL, picture, &report);
    assert_true(report.radius <= RIM);
    for (int i = 0; i < count; i++) {
        draw_moved(t, params->format, report.radius, position[i], params->background, drawn);
        for (int k = 0; k < 4 * (WIDTH + 2 * report.radius) * (HEIGHT + 2 * report.radius); k++)
            largest = fmax(largest, fabs((double)drawn[k]));
        add_sample(&params->filter, report.radius, position[i], drawn, sum, &weight);
    }
    // Codes as floats, which the test reads, are a unit in the last place from them.
    const double bound = report.bound + report.filter_bound * largest + 0x1p-23 * largest;
    for (int i = 0; i < PIXELS; i++)
        for (int c = 0; c < 4; c++) {
            const double error = fabs((double)picture[c][i] - sum[i][c] / weight);
            worst = larger(worst, error / bound);
        }
    if (!(worst <= 1.0))
        fail_msg("%s, %d samples: %g of the bound %g", params->filter.info->name, count, worst,
                 bound);
    return worst;
}

static void test_reference(void **state)
{
    static const double pattern[5][2] = {
        {0.25, -0.375}, {-0.4375, -0.0625}, {0.125, 0.3125}, {-0.25, 0.4375}, {0.0, 0.0}};
    int cases = 0;
    double worst = 0.0;
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++) {
        for (int f = 0; f < WEFT_ANTIALIAS_FORMAT_COUNT; f++) {
            struct triangles t;
            make_scene(contexts[c], f == WEFT_ANTIALIAS_RGBA8 ? 1.0f : 9.0f, &t);
            for (size_t k = 0; k < WEFT_COUNT(kernels); k++) {
                if ((int)k % 3 != f && c == 1)
                    continue;
                const struct weft_supersample_params params = {.filter = kernel_named(kernels[k]),
                                                               .position = pattern,
                                                               .count = 5,
                                                               .format = f,
                                                               .background = {0.3, 0.2, 0.1, 1.0}};
                worst = fmax(worst, compare_reference(&params, 5, pattern, &t));
                cases++;
            }
            triangles_destroy(&t);
        }
    }
    assert_true(cases == 15 || cases == 20);
    assert_true(worst > 1e-3); // the bound is not out of this world
}

// Without positions samples are k x k, in the middles of squares: edges cover their share.
static void test_grid(void **state)
{
    static float picture[4][PIXELS];
    static const float white[4] = {1.0f, 1.0f, 1.0f, 1.0f};
    (void)state;
    for (int side = 1; side <= 4; side++) {
        for (int axis = 0; axis < 2; axis++) {
            struct triangle_vertex vertices[3];
            struct weft_supersample_report report;
            struct triangles t;
            double corner[3][2] = {{10.3, 1000.0}, {10.3, -1000.0}, {-1000.0, 0.0}};
            for (int k = 0; axis == 1 && k < 3; k++) {
                const double x = corner[k][0];
                corner[k][0] = corner[k][1];
                corner[k][1] = x;
            }
            triangle_at(size, (const double(*)[2])corner, 0.5, white, 1, vertices);
            triangles_create(contexts[0], vertices, 3, &t);
            draw(&(struct weft_supersample_params){.count = side * side}, &t, NULL, picture,
                 &report);
            int inside = 0;
            for (int i = 0; i < side; i++)
                inside += (i + 0.5) / side < 0.3;
            for (int i = 0; i < PIXELS; i++) {
                const int at = axis ? i / WIDTH : i % WIDTH;
                const double share = at < 10 ? 1.0 : at > 10 ? 0.0 : (double)inside / side;
                assert_true(picture[0][i] == (float)share && picture[3][i] == (float)share);
            }
            assert_true(report.samples == side * side && report.passes == side * side);
            triangles_destroy(&t);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_marked),
        cmocka_unit_test(test_again),
        cmocka_unit_test(test_reference),
        cmocka_unit_test(test_grid),
    };
    return cmocka_run_group_tests_name("supersample", tests, create_contexts, destroy_contexts);
}
