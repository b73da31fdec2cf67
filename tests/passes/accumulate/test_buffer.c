// SPDX-License-Identifier: BSD-3-Clause
// The accumulation buffer: beside glAccum of a context of OSMesa's, and as a method beside the
// exact mean.
#include <dlfcn.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define GL_GLEXT_PROTOTYPES // for their types
#include <GL/osmesa.h>

#include "passes/accumulate/accumulate_impl.h"
#include "passes/accumulate/buffer.h"
#include "tests/passes/accumulate/frames.h"

// ---- OSMesa's buffer ----------------------------------------------------------------------------

enum { WIDTH = 64, HEIGHT = 16, VALUES = 4 * WIDTH * HEIGHT };

// A context of the compatibility profile with an accumulation buffer, that is current.
static struct {
    void *library;
    OSMesaContext context;
    float floats[VALUES];
    uint8_t bytes[VALUES];
} mesa;

#define OSMESA(name) ((__typeof__(&OSMesa##name))dlsym(mesa.library, "OSMesa" #name))
#define GL(name) ((__typeof__(&gl##name))dlsym(mesa.library, "gl" #name))

// `type`: of the colour buffer, GL_FLOAT or GL_UNSIGNED_BYTE. false: not to be had.
static bool start_mesa(GLenum type)
{
    static const int attributes[] = {OSMESA_FORMAT,
                                     OSMESA_RGBA,
                                     OSMESA_ACCUM_BITS,
                                     16,
                                     OSMESA_PROFILE,
                                     OSMESA_COMPAT_PROFILE,
                                     OSMESA_CONTEXT_MAJOR_VERSION,
                                     2,
                                     OSMESA_CONTEXT_MINOR_VERSION,
                                     1,
                                     0};
    GLint bits = 0;
    mesa.library = WITHOUT_GL ? NULL : dlopen("libOSMesa.so.8", RTLD_LAZY | RTLD_LOCAL);
    if (!mesa.library)
        return false;
    mesa.context = OSMESA(CreateContextAttribs)(attributes, NULL);
    if (!mesa.context ||
        !OSMESA(MakeCurrent)(mesa.context, type == GL_FLOAT ? (void *)mesa.floats : mesa.bytes,
                             type, WIDTH, HEIGHT))
        return false;
    GL(GetIntegerv)(GL_ACCUM_RED_BITS, &bits);
    GL(Clear)(GL_ACCUM_BUFFER_BIT); // its content is undefined before
    return bits == 16;
}

static void stop_mesa(void)
{
    assert_int_equal(GL(GetError)(), GL_NO_ERROR);
    OSMESA(MakeCurrent)(NULL, NULL, 0, 0, 0);
    OSMESA(DestroyContext)(mesa.context);
}

static void draw(GLenum type, const void *pixels)
{
    GL(Disable)(GL_DITHER);
    GL(RasterPos2f)(-1.0f, -1.0f);
    GL(DrawPixels)(WIDTH, HEIGHT, GL_RGBA, type, pixels);
}

// The codes of Mesa's buffer, through a colour buffer of floats.
static void read_mesa(int16_t *codes)
{
    static float values[VALUES];
    GL(Accum)(GL_RETURN, 1.0f);
    GL(ReadPixels)(0, 0, WIDTH, HEIGHT, GL_RGBA, GL_FLOAT, values);
    for (int i = 0; i < VALUES; i++)
        codes[i] = (int16_t)lrintf(values[i] * 32767.0f);
}

// ---- ours ---------------------------------------------------------------------------------------

static weft_accum_buffer *make_buffer(int channels, int bits, enum weft_accum_rounding rounding)
{
    weft_accum_buffer *buffer = NULL;
    assert_int_equal(
        weft_accum_buffer_create(
            weft_accum_buffer_params(.width = WIDTH, .height = HEIGHT, .channel_count = channels,
                                     .bits = bits, .rounding = rounding, .log = &log_to_stderr),
            &buffer),
        WEFT_OK);
    return buffer;
}

// Interleaved RGBA as four planes.
static void planes_of(enum weft_plane_type type, const void *pixels, struct weft_plane planes[4])
{
    for (int c = 0; c < 4; c++)
        planes[c] = (struct weft_plane){
            .values = (const char *)pixels + (size_t)c * weft_plane_type_size(type),
            .type = type,
            .step = 4,
        };
}

static void read_codes(const weft_accum_buffer *buffer, int16_t *codes)
{
    static float values[WIDTH * HEIGHT];
    for (int c = 0; c < 4; c++) {
        assert_int_equal(weft_accum_buffer_read(buffer, 32767.0, 0.0, c, values, 0), WEFT_OK);
        for (int i = 0; i < WIDTH * HEIGHT; i++)
            codes[4 * i + c] = (int16_t)values[i];
    }
}

static void assert_same_codes(const weft_accum_buffer *buffer, int round)
{
    static int16_t expected[VALUES], actual[VALUES];
    read_mesa(expected);
    read_codes(buffer, actual);
    for (int i = 0; i < VALUES; i++)
        if (expected[i] != actual[i])
            fail_msg("round %d, value %d: %d, and Mesa has %d", round, i, actual[i], expected[i]);
}

// Random operations that leave the buffer within `most` * [-1, 1] for frames within [-1, 1].
static double random_operation(weft_accum_buffer *buffer, const struct weft_plane *planes,
                               double most, uint64_t *seed)
{
    const double room = 0.999 - most, u = next_uniform(seed), sign = u < 0.5 ? -1.0 : 1.0;
    const float share = (float)(sign * room * next_uniform(seed));
    const float factor = (float)(sign * 2.0 * next_uniform(seed));
    switch (next_random(seed) % 8) {
    case 0:
        assert_int_equal(weft_accum_buffer_load(buffer, planes, (double)(2.0f * share)), WEFT_OK);
        GL(Accum)(GL_LOAD, 2.0f * share);
        return fabs(2.0 * (double)share) > 0.999 ? 2.0 : fabs(2.0 * (double)share);
    case 1:
        if (fabs((double)factor) * most > 0.999)
            return most;
        assert_int_equal(weft_accum_buffer_mult(buffer, (double)factor), WEFT_OK);
        GL(Accum)(GL_MULT, factor);
        return most * fabs((double)factor);
    case 2:
        assert_int_equal(weft_accum_buffer_add(buffer, (double)share), WEFT_OK);
        GL(Accum)(GL_ADD, share);
        return most + fabs((double)share);
    default:
        assert_int_equal(weft_accum_buffer_accum(buffer, planes, (double)share / 4.0), WEFT_OK);
        GL(Accum)(GL_ACCUM, share / 4.0f);
        return most + fabs((double)share) / 4.0;
    }
}

static void is_mesas_buffer_of_floats(void **state)
{
    (void)state;
    static float pixels[VALUES];
    struct weft_plane planes[4];
    uint64_t seed = 1;
    double most = 0.0;
    if (!start_mesa(GL_FLOAT))
        skip();
    weft_accum_buffer *buffer = make_buffer(4, 16, WEFT_ACCUM_TRUNCATE);
    planes_of(WEFT_PLANE_FLOAT, pixels, planes);
    GL(ClampColor)(GL_CLAMP_FRAGMENT_COLOR, GL_FALSE);
    GL(ClampColor)(GL_CLAMP_READ_COLOR, GL_FALSE);
    for (int round = 0; round < 400; round++) {
        for (int i = 0; i < VALUES; i++)
            pixels[i] = (float)(2.0 * next_uniform(&seed) - 1.0);
        draw(GL_FLOAT, pixels);
        most = random_operation(buffer, planes, most, &seed);
        if (most > 0.999) { // no room is left
            weft_accum_buffer_mult(buffer, 0.0);
            GL(Accum)(GL_MULT, 0.0f);
            most = 0.0;
        }
        assert_same_codes(buffer, round);
    }
    weft_accum_buffer_destroy(&buffer);
    stop_mesa();
}

// A frame of 100, 200, 255 and every other code, n times with 1 / n, into a colour buffer of bytes.
static void mesa_mean_of_bytes(const uint8_t *pixels, int n, uint8_t *out)
{
    draw(GL_UNSIGNED_BYTE, pixels);
    for (int i = 0; i < n; i++)
        GL(Accum)(i ? GL_ACCUM : GL_LOAD, 1.0f / (float)n);
    GL(Accum)(GL_RETURN, 1.0f);
    GL(ReadPixels)(0, 0, WIDTH, HEIGHT, GL_RGBA, GL_UNSIGNED_BYTE, out);
}

static void our_mean_of_bytes(const uint8_t *pixels, int n, enum weft_accum_rounding rounding,
                              uint8_t *out)
{
    static float values[WIDTH * HEIGHT];
    struct weft_plane planes[4];
    weft_accum_buffer *buffer = make_buffer(4, 16, rounding);
    planes_of(WEFT_PLANE_UNORM8, pixels, planes);
    for (int i = 0; i < n; i++)
        assert_int_equal(i ? weft_accum_buffer_accum(buffer, planes, 1.0 / n)
                           : weft_accum_buffer_load(buffer, planes, 1.0 / n),
                         WEFT_OK);
    for (int c = 0; c < 4; c++) {
        assert_int_equal(weft_accum_buffer_return(buffer, 1.0, c, values, 0), WEFT_OK);
        for (int i = 0; i < WIDTH * HEIGHT; i++)
            out[4 * i + c] = (uint8_t)lrintf(values[i] * 255.0f);
    }
    weft_accum_buffer_destroy(&buffer);
}

static void loses_what_mesa_loses(void **state)
{
    (void)state;
    static const struct {
        int n;
        uint8_t mean[3];
    } known[] = {
        {1, {100, 200, 255}},   {2, {100, 200, 255}},   {8, {100, 200, 255}},
        {64, {100, 200, 255}},  {128, {100, 199, 254}}, {256, {100, 199, 253}},
        {512, {100, 199, 251}}, {1024, {96, 199, 247}},
    };
    static uint8_t pixels[VALUES], ours[VALUES], theirs[VALUES];
    const bool with_mesa = start_mesa(GL_UNSIGNED_BYTE);
    for (int i = 0; i < VALUES; i++)
        pixels[i] = (uint8_t)(i / 4 + 64 * (i % 4));
    memcpy(pixels, (const uint8_t[]){100, 200, 255}, 3);
    for (size_t k = 0; k < WEFT_COUNT(known); k++) {
        our_mean_of_bytes(pixels, known[k].n, WEFT_ACCUM_TRUNCATE, ours);
        for (int c = 0; c < 3; c++)
            if (ours[c] != known[k].mean[c])
                fail_msg("%d times: %d instead of %d", known[k].n, ours[c], known[k].mean[c]);
        if (with_mesa) {
            mesa_mean_of_bytes(pixels, known[k].n, theirs);
            assert_memory_equal(ours, theirs, VALUES);
        }
        // Rounded to nearest: n halves of a code of 32767 at most.
        our_mean_of_bytes(pixels, known[k].n, WEFT_ACCUM_NEAREST, ours);
        const double bound = 255.0 / 32767.0 * WEFT_ACCUM_ERROR * known[k].n + 0.5;
        for (int i = 0; i < VALUES; i++)
            assert_true(fabs((double)ours[i] - pixels[i]) <= bound);
    }
    if (with_mesa)
        stop_mesa();
    else
        print_message("[  SKIPPED ] OSMesa's accumulation buffer is not to be had\n");
}

// ---- the object ---------------------------------------------------------------------------------

static void assert_value(const weft_accum_buffer *buffer, double expected)
{
    static float values[WIDTH * HEIGHT];
    assert_int_equal(weft_accum_buffer_read(buffer, 1.0, 0.0, 0, values, 0), WEFT_OK);
    assert_near((double)values[0], expected, 0.0, "first pixel");
    assert_near((double)values[WIDTH * HEIGHT - 1], expected, 0.0, "last pixel");
}

static void clamps_where_opengl_says(void **state)
{
    (void)state;
    static float values[WIDTH * HEIGHT];
    static const int bits[] = {16, 32};
    for (size_t b = 0; b < 2; b++) {
        weft_accum_buffer *buffer = make_buffer(1, bits[b], WEFT_ACCUM_NEAREST);
        assert_value(buffer, 0.0);
        assert_int_equal(weft_accum_buffer_add(buffer, -1.0), WEFT_OK);
        assert_value(buffer, -1.0); // negative values stay until they are returned
        assert_int_equal(weft_accum_buffer_return(buffer, 1.0, 0, values, 0), WEFT_OK);
        assert_true(values[0] == 0.0f);
        assert_int_equal(weft_accum_buffer_return(buffer, -0.25, 0, values, 0), WEFT_OK);
        assert_true(values[0] == 0.25f);
        assert_int_equal(weft_accum_buffer_return(buffer, -4.0, 0, values, 0), WEFT_OK);
        assert_true(values[0] == 1.0f);
        // What has no code is the nearest one; floats go on.
        assert_int_equal(weft_accum_buffer_mult(buffer, -3.0), WEFT_OK);
        assert_value(buffer, bits[b] == 16 ? 1.0 : 3.0);
        assert_int_equal(weft_accum_buffer_add(buffer, 1e6), WEFT_OK);
        assert_value(buffer, bits[b] == 16 ? 1.0 : 1000003.0);
        assert_int_equal(weft_accum_buffer_mult(buffer, -1e9), WEFT_OK);
        if (bits[b] == 16)
            assert_value(buffer, -1.0);
        weft_accum_buffer_destroy(&buffer);
        assert_null(buffer);
        weft_accum_buffer_destroy(&buffer);
    }
}

// Every type of plane, with steps and rows that are not tight, beside codes by the definition.
static void takes_planes_of_all_types(void **state)
{
    (void)state;
    enum { STEP = 3, STRIDE = STEP * WIDTH + 5, COUNT = STRIDE * HEIGHT };
    static uint32_t values[COUNT];
    static float out[WIDTH * HEIGHT];
    uint64_t seed = 5;
    for (int type = 0; type < WEFT_PLANE_TYPE_COUNT; type++) {
        weft_accum_buffer *buffer = make_buffer(1, 16, WEFT_ACCUM_NEAREST);
        fill_plane((enum weft_plane_type)type, 0.0, 1.0, COUNT, &seed, values);
        const struct weft_plane plane = {values, (enum weft_plane_type)type, STRIDE, STEP};
        assert_int_equal(weft_accum_buffer_load(buffer, &plane, 0.5), WEFT_OK);
        assert_int_equal(weft_accum_buffer_accum(buffer, &plane, -0.125), WEFT_OK);
        assert_int_equal(weft_accum_buffer_read(buffer, 32767.0, 0.0, 0, out, 0), WEFT_OK);
        for (size_t i = 0; i < WIDTH * HEIGHT; i++) {
            const size_t at = i / WIDTH * STRIDE + i % WIDTH * STEP;
            const double exact = 32767.0 * 0.375 * plane_value(&plane, at);
            assert_near((double)out[i], exact, 2.0 * WEFT_ACCUM_ERROR, weft_plane_type_names[type]);
            assert_true(out[i] == rintf(out[i]));
        }
        weft_accum_buffer_destroy(&buffer);
    }
}

// Many values at once give what one by one gives: rows of all lengths, beside the definition in
// double, with values around halves of codes, beyond all codes and NAN.
static void codes_are_the_same_in_any_place(void **state)
{
    (void)state;
    enum { MOST = 41 };
    float values[MOST], out[MOST];
    uint64_t seed = 8;
    int halves = 0;
    for (int rounding = 0; rounding < WEFT_ACCUM_ROUNDING_COUNT; rounding++)
        for (int width = 1; width <= MOST; width++) {
            const struct weft_plane plane = {.values = values};
            weft_accum_buffer *buffer = NULL;
            assert_int_equal(
                weft_accum_buffer_create(
                    weft_accum_buffer_params(.width = width, .height = 1, .channel_count = 1,
                                             .rounding = (enum weft_accum_rounding)rounding),
                    &buffer),
                WEFT_OK);
            for (int i = 0; i < width; i++) {
                const double code = (double)(next_random(&seed) % 65536) - 32768.0;
                values[i] = (float)((code + 0.5) / 32767.0);
                if (next_random(&seed) % 8 == 0)
                    values[i] = i % 3 == 0 ? NAN : i % 3 == 1 ? INFINITY : -1e30f;
            }
            assert_int_equal(weft_accum_buffer_load(buffer, &plane, 1.0), WEFT_OK);
            assert_int_equal(weft_accum_buffer_accum(buffer, &plane, -0.25), WEFT_OK);
            assert_int_equal(weft_accum_buffer_mult(buffer, -0.5), WEFT_OK);
            assert_int_equal(weft_accum_buffer_read(buffer, 32767.0, 0.0, 0, out, 0), WEFT_OK);
            for (int i = 0; i < width; i++) {
                const bool down = rounding == WEFT_ACCUM_TRUNCATE;
                const double most = 32767.0, v = (double)values[i];
                // Products in single precision.
                double load = (double)(values[i] * 32767.0f), half = 0.0;
                double add = (double)(values[i] * (-0.25f * 32767.0f));
                halves += load - floor(load) == 0.5;
                load = isnan(v) ? -most : fmax(-most, fmin(most, down ? trunc(load) : rint(load)));
                add = isnan(v) ? -most : fmax(-most, fmin(most, down ? trunc(add) : rint(add)));
                half = -0.5 * fmax(-most, fmin(most, load + add));
                assert_true((double)out[i] == (down ? trunc(half) : rint(half)));
            }
            weft_accum_buffer_destroy(&buffer);
        }
    assert_true(halves > 100);
}

// Rounding to nearest has no bias where truncation loses half a code in each operation.
static void rounds_without_bias(void **state)
{
    (void)state;
    enum { N = 256 };
    static float pixels[WIDTH * HEIGHT], out[WIDTH * HEIGHT];
    const struct weft_plane plane = {.values = pixels};
    uint64_t seed = 9;
    for (int rounding = 0; rounding < WEFT_ACCUM_ROUNDING_COUNT; rounding++) {
        double bias = 0.0, exact[WIDTH * HEIGHT] = {0.0};
        weft_accum_buffer *buffer = make_buffer(1, 16, (enum weft_accum_rounding)rounding);
        for (int k = 0; k < N; k++) {
            for (int i = 0; i < WIDTH * HEIGHT; i++) {
                pixels[i] = (float)next_uniform(&seed);
                exact[i] += (double)pixels[i] * 32767.0 / N;
            }
            assert_int_equal(weft_accum_buffer_accum(buffer, &plane, 1.0 / N), WEFT_OK);
        }
        assert_int_equal(weft_accum_buffer_read(buffer, 32767.0, 0.0, 0, out, 0), WEFT_OK);
        for (int i = 0; i < WIDTH * HEIGHT; i++)
            bias += ((double)out[i] - exact[i]) / (WIDTH * HEIGHT);
        print_message("%s: bias of %d accums %.2f codes\n", weft_accum_rounding_names[rounding], N,
                      bias);
        // Of one rounding 1/sqrt(12) codes: sqrt(256 / 12 / 1024) = 0.14 of the mean.
        assert_near(bias, rounding == WEFT_ACCUM_NEAREST ? 0.0 : -N / 2.0, 6.0 * 0.15, "bias");
        weft_accum_buffer_destroy(&buffer);
    }
}

static void is_the_same_on_any_number_of_threads(void **state)
{
    (void)state;
    enum { W = 301, H = 977 }; // several parts, of rows that are not whole steps
    static float pixels[W * H];
    static float out[2][W * H];
    uint64_t seed = 3;
    for (int i = 0; i < W * H; i++)
        pixels[i] = (float)next_uniform(&seed);
    for (int bits = 16; bits <= 32; bits += 16)
        for (int threads = 1; threads <= 5; threads++) {
            weft_accum_buffer *buffer = NULL;
            struct weft_plane planes[2] = {{.values = pixels}, {.values = pixels}};
            assert_int_equal(
                weft_accum_buffer_create(weft_accum_buffer_params(.width = W, .height = H,
                                                                  .channel_count = 2, .bits = bits,
                                                                  .cpu.threads = threads),
                                         &buffer),
                WEFT_OK);
            assert_int_equal(weft_accum_buffer_load(buffer, planes, 0.3), WEFT_OK);
            assert_int_equal(weft_accum_buffer_accum(buffer, planes, 0.1), WEFT_OK);
            assert_int_equal(weft_accum_buffer_mult(buffer, 0.7), WEFT_OK);
            assert_int_equal(weft_accum_buffer_add(buffer, 0.1), WEFT_OK);
            assert_int_equal(weft_accum_buffer_return(buffer, 1.1, 1, out[threads == 1 ? 0 : 1], 0),
                             WEFT_OK);
            if (threads > 1)
                assert_memory_equal(out[0], out[1], sizeof out[0]);
            for (int i = 0; i < W * H; i++)
                assert_near((double)out[0][i], 1.1 * (0.7 * 0.4 * (double)pixels[i] + 0.1), 1e-4,
                            "value");
            weft_accum_buffer_destroy(&buffer);
        }
}

// ---- the method ---------------------------------------------------------------------------------

struct job {
    int n, bits;
    enum weft_plane_type type;
    enum weighing weighing;
    bool known, truncate;
    double low, high;
};

enum { JOB_WIDTH = 9, JOB_HEIGHT = 5, JOB_CHANNELS = 2, JOB_PIXELS = JOB_WIDTH * JOB_HEIGHT };

static weft_accumulator *create_job(const struct job *j, const struct frames *f)
{
    weft_accumulator *a = NULL;
    assert_int_equal(
        weft_accumulator_create(
            weft_accumulator_params(
                    .width = JOB_WIDTH, .height = JOB_HEIGHT, .channel_count = JOB_CHANNELS,
                    .method = WEFT_ACCUMULATE_BUFFER, .bits = j->bits,
                    .rounding = j->truncate ? WEFT_TREE_TRUNCATE : WEFT_TREE_NEAREST,
                    .frame_count = j->known ? j->n : 0, .weight = j->known ? f->weight : NULL,
                    .low = j->low, .high = j->high, .log = &log_to_stderr),
            &a),
        WEFT_OK);
    return a;
}

// Goes on from its own state.
static void pass_state_on(const struct job *j, const struct frames *f, weft_accumulator **a)
{
    void *state = NULL;
    size_t size = 0;
    weft_accumulator *next = create_job(j, f);
    assert_int_equal(weft_accumulator_save(*a, &state, &size), WEFT_OK);
    assert_int_equal(weft_accumulator_load(next, state, size), WEFT_OK);
    free(state);
    weft_accumulator_destroy(a);
    *a = next;
}

// Largest error / bound, of every prefix that is looked at; another run goes through a state.
static double run_job(const struct job *j, uint64_t seed)
{
    struct frames f;
    float out[2][JOB_PIXELS];
    double worst = 0.0;
    struct weft_accumulator_report report;
    make_frames(&f, j->n, JOB_CHANNELS, JOB_PIXELS, j->type, j->low, j->high, seed);
    weigh_frames(&f, j->weighing, seed + 1);
    weft_accumulator *a = create_job(j, &f), *resumed = create_job(j, &f);
    weft_accumulator_get_report(a, &report);
    assert_true(j->known ? isfinite(report.bound) : isinf(report.bound));
    const double predicted = report.bound;
    const double expected = a->way->expect(&a->params, j->n);
    if (j->known && j->weighing == EQUAL)
        assert_near(expected, predicted, 1e-9 * predicted, "the bound that is expected");
    for (int k = 0; k < j->n; k++) {
        const struct weft_frame frame = {.plane = &f.plane[k * JOB_CHANNELS]};
        assert_int_equal(weft_accumulator_add(a, &frame, f.weight[k]), WEFT_OK);
        assert_int_equal(weft_accumulator_add(resumed, &frame, f.weight[k]), WEFT_OK);
        sum_frame(&f, k);
        if (k == j->n / 2)
            pass_state_on(j, &f, &resumed);
        if (k % 7 && k != j->n - 1)
            continue;
        weft_accumulator_get_report(a, &report);
        for (int c = 0; c < JOB_CHANNELS; c++) {
            assert_int_equal(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, c, out[0], 0),
                             WEFT_OK);
            assert_int_equal(weft_accumulator_current(resumed, WEFT_ACCUMULATED_MEAN, c, out[1], 0),
                             WEFT_OK);
            assert_memory_equal(out[0], out[1], sizeof out[0]);
            const double error = mean_error(&f, c, out[0]);
            if (!(error <= report.bound))
                fail_msg("%d of %d frames, %d bits, weighing %d%s: error %g, bound %g", k + 1, j->n,
                         j->bits, (int)j->weighing, j->known ? "" : ", not known", error,
                         report.bound);
            worst = larger(worst, error / report.bound);
        }
    }
    assert_int_equal(report.frames, j->n);
    assert_true(report.method == WEFT_ACCUMULATE_BUFFER && report.bits == j->bits);
    // The bound that was predicted holds for frames that fill the range.
    if (j->known)
        assert_true(report.bound <= predicted * 1.0001);
    weft_accumulator_destroy(&a);
    weft_accumulator_destroy(&resumed);
    free_frames(&f);
    return worst;
}

static void is_within_its_bound(void **state)
{
    (void)state;
    static const int counts[] = {1, 2, 3, 5, 17, 64, 101, 256, 300};
    static const double ranges[][2] = {{0.0, 1.0}, {-3.0, 10.0}, {0.0, 0.25}};
    double worst = 0.0;
    int jobs = 0;
    for (size_t i = 0; i < WEFT_COUNT(counts); i++)
        for (int bits = 16; bits <= 32; bits += 16)
            for (int weighing = 0; weighing < WEIGHINGS; weighing++)
                for (int way = 0; way < 4; way++)
                    for (size_t r = 0; r < WEFT_COUNT(ranges); r++) {
                        const struct job j = {
                            .n = counts[i],
                            .bits = bits,
                            .type = r ? jobs % 2 ? WEFT_PLANE_HALF : WEFT_PLANE_FLOAT
                                      : (enum weft_plane_type)(jobs % WEFT_PLANE_TYPE_COUNT),
                            .weighing = (enum weighing)weighing,
                            .known = way & 1,
                            .truncate = way & 2,
                            .low = ranges[r][0],
                            .high = ranges[r][1],
                        };
                        worst = larger(worst, run_job(&j, (uint64_t)++jobs));
                    }
    print_message("%d jobs: at most %.3f of the bound\n", jobs, worst);
    assert_int_equal(jobs, 9 * 2 * WEIGHINGS * 4 * 3);
    assert_true(worst <= 1.0 && worst > 0.5);
}

// Truncation reaches its bound: n codes nearly lost.
static void bound_is_reached(void **state)
{
    (void)state;
    enum { N = 256 };
    // 1/256 of it is just below a code more.
    const float value = (float)((102.0 * N - 0.01 * N) / 32767.0);
    const struct weft_plane plane = {.values = &value};
    struct weft_accumulator_report report;
    weft_accumulator *a = NULL;
    float out;
    assert_int_equal(weft_accumulator_create(
                         weft_accumulator_params(.width = 1, .height = 1, .channel_count = 1,
                                                 .method = WEFT_ACCUMULATE_BUFFER,
                                                 .rounding = WEFT_TREE_TRUNCATE, .frame_count = N),
                         &a),
                     WEFT_OK);
    for (int i = 0; i < N; i++)
        assert_int_equal(weft_accumulator_add(a, &(struct weft_frame){.plane = &plane}, 1.0),
                         WEFT_OK);
    assert_int_equal(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, &out, 0), WEFT_OK);
    weft_accumulator_get_report(a, &report);
    const double error = (double)value - (double)out;
    assert_true(error <= report.bound && error > 0.95 * report.bound);
    weft_accumulator_destroy(&a);
}

static void refuses_what_it_cannot_take(void **state)
{
    (void)state;
    struct message message = {.count = 0};
    const struct weft_log log = {keep_message, &message};
    float pixels[4] = {0.0f, 0.5f, 1.0f, 0.25f}, out[4];
    const struct weft_plane plane = {.values = pixels};
    const struct weft_frame frame = {.plane = &plane};
    weft_accumulator *a = NULL;
    struct weft_accumulator_params p = {
        .width = 2, .height = 2, .channel_count = 1, .method = WEFT_ACCUMULATE_BUFFER, .log = &log};
    p.bits = 8;
    assert_int_equal(weft_accumulator_create(&p, &a), WEFT_ERR_ARGUMENT);
    p.bits = 0;
    p.nonfinite = WEFT_NONFINITE_PROPAGATE;
    assert_int_equal(weft_accumulator_create(&p, &a), WEFT_ERR_ARGUMENT);
    p.nonfinite = WEFT_NONFINITE_ERROR;
    p.rounding = WEFT_TREE_UNBIASED;
    assert_int_equal(weft_accumulator_create(&p, &a), WEFT_ERR_ARGUMENT);
    p.rounding = WEFT_TREE_NEAREST;
    assert_int_equal(message.count, 3);
    assert_null(a);
    assert_int_equal(weft_accumulator_create(&p, &a), WEFT_OK);
    assert_int_equal(weft_accumulator_add(a, &frame, 1.0), WEFT_OK);
    // A frame that is refused leaves no trace.
    static const float bad[] = {-0.01f, 1.01f, NAN, INFINITY};
    for (size_t i = 0; i < WEFT_COUNT(bad); i++) {
        pixels[2] = bad[i];
        assert_int_equal(weft_accumulator_add(a, &frame, 1.0), WEFT_ERR_FORMAT);
        assert_non_null(strstr(message.text, "frame 1, channel 0, pixel (0, 1)"));
    }
    pixels[2] = 1.0f;
    assert_int_equal(message.count, 7);
    assert_int_equal(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, out, 0), WEFT_OK);
    for (int i = 0; i < 4; i++)
        assert_near((double)out[i], (double)pixels[i], 2e-5, "the one frame that counts");
    // Weights that cancel out leave no mean, and the next frame brings one.
    assert_int_equal(weft_accumulator_add(a, &frame, -1.0), WEFT_OK);
    assert_int_equal(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, out, 0),
                     WEFT_ERR_ARGUMENT);
    assert_int_equal(weft_accumulator_add(a, &frame, 0.5), WEFT_OK);
    assert_int_equal(weft_accumulator_current(a, WEFT_ACCUMULATED_MEAN, 0, out, 0), WEFT_OK);
    assert_near((double)out[1], 0.5, 2e-4, "half of the buffer's range is taken");
    weft_accumulator_destroy(&a);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(is_mesas_buffer_of_floats),
        cmocka_unit_test(loses_what_mesa_loses),
        cmocka_unit_test(clamps_where_opengl_says),
        cmocka_unit_test(takes_planes_of_all_types),
        cmocka_unit_test(codes_are_the_same_in_any_place),
        cmocka_unit_test(rounds_without_bias),
        cmocka_unit_test(is_the_same_on_any_number_of_threads),
        cmocka_unit_test(is_within_its_bound),
        cmocka_unit_test(bound_is_reached),
        cmocka_unit_test(refuses_what_it_cannot_take),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
